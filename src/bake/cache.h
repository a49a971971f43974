/* Light in cells of the media: what it is kept in, and what its driver hands to its kernel, which is built once per
 * instruction set. */
#ifndef TY_BAKE_CACHE_H
#define TY_BAKE_CACHE_H

#include "base/dispatch.h"
#include "method/path/kernel.h"

#include <tyndall/bake.h>

enum { TY_CACHE_CELLS_MAX = 512 };

/* Light that arrives in a cell: straight from lights, and the rest. Floats of each: the mean radiance over all
 * directions, red, green and blue. Where media do not scatter evenly, the unit vector to where most comes from, and how
 * far all of it comes from there, 0..1; by channel, where media are not gray. */
enum { TY_CACHE_EVEN = 3, TY_CACHE_GRAY = 7, TY_CACHE_COLORED = 9 };
enum { TY_CACHE_ONCE = 0, TY_CACHE_REST = 1, TY_CACHE_KINDS = 2 };

/* What is known of light on surfaces in a cell that media scattered (once and never touched by anything else, and
 * other), apart for surfaces that face along each of six axes: the mean of walks from points on them. Floats: the mean
 * place and normal; per kind and channel irradiance and vector irradiance; per channel the variance of all irradiance;
 * how many walks that is the mean of. */
enum { TY_WALL_SINGLE = 0, TY_WALL_MULTIPLE = 1, TY_WALL_KINDS = 2, TY_WALL_TERMS = 4, TY_WALL_WAYS = 6 };
enum { TY_WALL_PLACE = 0, TY_WALL_NORMAL = 3, TY_WALL_LIGHT = 6 };
enum { TY_WALL_LIGHTS = TY_WALL_KINDS * 3 * TY_WALL_TERMS, TY_WALL_VARIANCE = TY_WALL_LIGHT + TY_WALL_LIGHTS };
enum { TY_WALL_WALKS = TY_WALL_VARIANCE + 3, TY_WALL_FLOATS = TY_WALL_WALKS + 1 };

/* A cell that surfaces cut has two sides: what its middle sees, and the rest, of which one point is the anchor. What is
 * known of a cell: the light on either side (bits of known), and whether who looks there has to see an anchor first. */
enum { TY_CACHE_SIDES = 2, TY_CACHE_CUT = 1 << TY_CACHE_SIDES };

typedef struct ty_cache_view {
    float lower[3], per_metre;
    int32_t size[3];
    int32_t floats;       /* per kind of light: TY_CACHE_... */
    float* light;         /* of the first side, cell by cell, both kinds */
    float* other;         /* of the other */
    float* anchor;        /* per cell the anchors of both sides, 3 floats each */
    const uint8_t* known; /* per cell */
    const uint8_t* ways;  /* per cell, bits of the ways that surfaces in it face; NULL: not known yet */
    const int32_t* first; /* per cell, which is the first of its walls, one per bit */
    float* walls;         /* TY_WALL_FLOATS each */
} ty_cache_view;

struct ty_bake_cache {
    ty_context* context;
    ty_cache_view view;
    uint8_t* known; /* view's */
    uint8_t* ways;  /* view's */
    int32_t* first; /* view's */
    size_t cells, walls;
    ty_bake_cache_info info;
};

struct ty_bake_run;

/* True where a medium is the same in all channels. */
bool ty_bake_is_gray(const ty_medium_view* medium);
/* The light in the media of a prepared run. */
ty_result ty_bake_cache_make(const struct ty_bake_run* run, const ty_scene* scene, ty_bake_cache** out);
/* Once all cells are filled: which of them see each other, and what is known where nothing was found. Errors:
 * TY_ERROR_MEMORY. */
ty_result ty_cache_part(ty_bake_cache* cache, const ty_mesh* mesh);

typedef struct ty_cache_request {
    ty_path_request path; /* scene and random numbers */
    ty_cache_view view;
    const int32_t* cells;               /* those that are filled */
    uint32_t paths;                     /* per cell */
    _Atomic uint8_t* met;               /* per cell, bits of the ways that surfaces in it were found to face */
    const struct ty_bake_request* bake; /* of walls: what walks look at */
} ty_cache_request;

/* Fills cells[begin..end), what is known but TY_CACHE_CUT of light from other cells; returns rays. */
#define TY_CACHE_KERNEL(name) uint64_t name(const ty_cache_request* request, int64_t begin, int64_t end, uint8_t* known)
typedef TY_CACHE_KERNEL((*ty_cache_kernel));
TY_DECLARE_KERNEL_FUNCTION(TY_CACHE_KERNEL, ty_cache_kernel);
/* Fills the walls of cells[begin..end), once light in all cells is known. */
TY_DECLARE_KERNEL_FUNCTION(TY_CACHE_KERNEL, ty_wall_kernel);

#endif
