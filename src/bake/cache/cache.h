/* Light cache of the media: its storage, and the request from its driver to its kernel, which is built once per
 * instruction set. */
#ifndef TY_BAKE_CACHE_CACHE_H
#define TY_BAKE_CACHE_CACHE_H

#include "bake/gather/run.h"

struct ty_bake_cache {
    ty_context* context;
    ty_cache_view view;
    uint8_t* flags;        /* view's */
    uint8_t* surfel_axes;  /* view's */
    int32_t* first_surfel; /* view's */
    size_t cells, surfels;
    ty_enclosed* enclosed; /* light in media inside dielectrics; NULL: none */
    ty_bake_cache_info info;
};

/* True if a medium is identical in all channels. */
bool ty_bake_is_gray(const ty_medium_view* medium);
/* Creates the light cache of a prepared run. */
ty_result ty_bake_cache_make(const ty_bake_run* run, const ty_scene* scene, ty_bake_cache** out);
/* After filling: marks the cells that need visibility tests, and fills cells without known light from their neighbours.
 * Errors: TY_ERROR_MEMORY. */
ty_result ty_cache_find_visibility(ty_bake_cache* cache, const ty_accel* mesh);

typedef struct ty_cache_request {
    ty_path_request path; /* scene and random numbers */
    ty_cache_view view;
    const int32_t* cells;          /* indices of the cells to fill */
    uint32_t paths;                /* per cell */
    _Atomic uint8_t* surface_axes; /* per cell, bits of the normal axes of the surfaces that paths hit in it */
    const ty_bake_request* bake;   /* for surfels: the request of the baker */
} ty_cache_request;

/* Fills cells[begin..end) and their flags except TY_CACHE_TEST_VISIBILITY, which depends on other cells; returns the
 * number of rays. */
#define TY_CACHE_KERNEL(name) uint64_t name(const ty_cache_request* request, int64_t begin, int64_t end, uint8_t* flags)
typedef TY_CACHE_KERNEL((*ty_cache_kernel));
TY_DECLARE_KERNEL_FUNCTION(TY_CACHE_KERNEL, ty_cache_kernel);
/* Fills the surfels of cells[begin..end), once the light of all cells is known. */
TY_DECLARE_KERNEL_FUNCTION(TY_CACHE_KERNEL, ty_surfel_kernel);

#endif
