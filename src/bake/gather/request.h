/* The request from the baker's driver to its kernel, which is built once per instruction set. */
#ifndef TY_BAKE_GATHER_REQUEST_H
#define TY_BAKE_GATHER_REQUEST_H

#include "base/dispatch.h"
#include "bake/gather/cache_view.h"
#include "bake/gather/virtual_emitters.h"
#include "method/impulse/lookup.h"
#include "method/path/trace/kernel.h"

#include <tyndall/bake.h>

enum {
    TY_BAKE_SURFACE_TERMS = 4, /* irradiance, and x, y, z of the vector irradiance */
    TY_BAKE_TERMS_MAX = TY_BAKE_SH_TERMS,
    /* TY_BAKE_CACHE: one gather ray per path where the prior counts for fewer rays than TY_FOG_MIN_PRIOR_RAYS; else
       none for the first TY_FOG_PRIOR_PATHS paths, and then one per fog_every paths. */
    TY_FOG_MIN_PRIOR_RAYS = 16,
    TY_FOG_PRIOR_PATHS = 64
};

/* Impulse responses in a request. */
typedef struct ty_bake_impulse {
    const ty_impulse* tables;
    ty_impulse_merged merged[3]; /* per channel, for media of one albedo and g; rows NULL: media differ */
    float max_bounce_ratio[3];   /* upper bound of the ratio of successive bounces in the tables' infinite medium */
    const ty_virtual_emitters* emitters;
    int32_t media_only; /* 1: only light scattered by media counts */
    int32_t published;  /* 1: TY_BAKE_PUBLISHED */
    float step;         /* m: a distance over which media hardly change */
    float mean_cosine;  /* of scattering in the media, at most 0.9 */
} ty_bake_impulse;

typedef struct ty_bake_request {
    ty_path_request path; /* scene, random numbers, bounds; media of zero density are left out of the scene */
    int32_t method;       /* ty_bake_method */
    int32_t scatterings;
    int32_t back_scattering;
    int32_t gray;        /* 1: media are identical in all channels */
    ty_cache_view cache; /* TY_BAKE_CACHE; light NULL: no media */
    int32_t transparent; /* 1: some surface passes light (bake/gather/transparent.k.h) */
    int32_t media_emit;  /* 1: some medium emits, and paths sample its emission */
    const ty_bake_receiver* receivers;
    int64_t first;      /* place of receivers[0], of which random numbers are functions */
    int32_t terms;      /* TY_BAKE_SURFACE_TERMS, or TY_BAKE_SH_TERMS for probes */
    uint32_t fog_every; /* TY_BAKE_IMPULSE: samples per lookup of the tables, a power of two; TY_BAKE_CACHE: paths per
                           gather ray */
    ty_bake_impulse impulse;
} ty_bake_request;

/* Sums over a receiver's samples. */
typedef struct ty_bake_sums {
    double mean[3], square[3]; /* sums of the sampled irradiance and its square */
    double blocked;            /* rays that hit back faces */
    /* Sums of scattered light and its square, over table lookups or gather rays; not included in mean and square. */
    double fog_mean[3], fog_square[3];
    double prior_rays; /* TY_BAKE_CACHE: gather rays that the prior counts for, and the variance of its mean */
    double prior_variance[3];
    uint64_t paths, rays;
    int32_t count;       /* samples */
    int32_t gather_rays; /* TY_BAKE_IMPULSE: samples with a lookup of the tables; TY_BAKE_CACHE: gather rays */
    int32_t done;
} ty_bake_sums;

/* Adds samples [first, first + count) of receivers [begin, end) to sums and light, which cover all receivers. light:
 * layers x 3 channels x terms each. */
#define TY_BAKE_KERNEL(name)                                                                                           \
    void name(const ty_bake_request* request, int64_t begin, int64_t end, uint32_t first, uint32_t count,              \
              ty_bake_sums* sums, double* light)
typedef TY_BAKE_KERNEL((*ty_bake_kernel));
TY_DECLARE_KERNEL_FUNCTION(TY_BAKE_KERNEL, ty_bake_kernel);
/* The same of TY_BAKE_PATH alone, by paths that refract at solid dielectrics. */
TY_DECLARE_KERNEL_FUNCTION(TY_BAKE_KERNEL, ty_bake_path_kernel);

#endif
