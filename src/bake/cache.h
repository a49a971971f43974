/* Light in cells of the media: what it is kept in, and what its driver hands to its kernel, which is built once per
 * instruction set. */
#ifndef TY_BAKE_CACHE_H
#define TY_BAKE_CACHE_H

#include "method/path/kernel.h"

#include <tyndall/bake.h>

enum { TY_CACHE_CELLS_MAX = 512 };

/* Per term and channel (r, g, b and a gap). A cell's first terms are of light straight from lights, then as many of all
 * light. Term 0: its mean radiance over all directions; 1..3: the mean of radiance times the unit vector to where it
 * comes from. */
enum { TY_CACHE_TERM = 4, TY_CACHE_TERMS_MAX = 4 };

typedef struct ty_cache_view {
    float lower[3], per_metre;
    int32_t size[3];
    int32_t terms;    /* 1: media scatter evenly; 4 */
    size_t stride[3]; /* from a cell to the next, in floats; 0 where there is one alone */
    const float* light;
} ty_cache_view;

struct ty_bake_cache {
    ty_context* context;
    ty_cache_view view;
    float* light;
    size_t floats;
    ty_bake_cache_info info;
};

typedef struct ty_cache_request {
    ty_path_request path; /* scene and random numbers */
    ty_cache_view view;
    const int32_t* cells; /* those that are filled */
    uint32_t paths;       /* per cell */
} ty_cache_request;

/* Fills cells[begin..end) of light; returns rays. */
#define TY_CACHE_KERNEL(name)                                                                                          \
    uint64_t name(const ty_cache_request* request, int64_t begin, int64_t end, float* light)
typedef TY_CACHE_KERNEL((*ty_cache_kernel));
TY_CACHE_KERNEL(ty_cache_kernel_v1);
TY_CACHE_KERNEL(ty_cache_kernel_v3);
TY_CACHE_KERNEL(ty_cache_kernel_v4);

#endif
