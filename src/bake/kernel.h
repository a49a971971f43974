/* What the baker's driver hands to its kernel, which is built once per instruction set. */
#ifndef TY_BAKE_KERNEL_H
#define TY_BAKE_KERNEL_H

#include "base/dispatch.h"
#include "bake/cache.h"
#include "bake/impulse/impulse.h"

enum {
    TY_BAKE_SURFACE_TERMS = 4, /* irradiance, and the vector irradiance's x, y, z */
    TY_BAKE_TERMS_MAX = TY_BAKE_SH_TERMS,
    /* TY_BAKE_CACHE: rays that gather what media scattered are as many as paths where cells know less of it than so
     * many would tell; else there is none for the first paths, and then one for fog_every more. */
    TY_FOG_LEAST = 16,
    TY_FOG_ENOUGH = 64
};

typedef struct ty_bake_request {
    ty_path_request path; /* scene, random numbers, bounds; media without matter are left out of the scene */
    int32_t method;       /* ty_bake_method */
    int32_t scatterings;
    int32_t back_scattering;
    int32_t gray;        /* whether media do the same to all channels */
    ty_cache_view cache; /* TY_BAKE_CACHE; light NULL: no media */
    int32_t glows;       /* TY_BAKE_CACHE: whether media send light of their own, which paths look for */
    const ty_bake_receiver* receivers;
    int32_t terms;      /* TY_BAKE_SURFACE_TERMS, or TY_BAKE_SH_TERMS: receivers are probes */
    uint32_t fog_every; /* TY_BAKE_IMPULSE: one in so many samples asks the tables: a power of two; TY_BAKE_CACHE: paths
                           per ray that gathers what media scattered */
    ty_bake_impulse impulse;
} ty_bake_request;

/* Sums over a receiver's samples. */
typedef struct ty_bake_sums {
    double mean[3], square[3]; /* of what variance is told of */
    double blocked;            /* rays that met the back of a surface */
    /* The same of what media make of emitters, over the samples that ask, or of fog rays: it is not in mean and square.
     */
    double fog_mean[3], fog_square[3];
    double borrowed; /* TY_BAKE_CACHE: fog rays that what cells know counts as; its variance, as a mean */
    double borrowed_variance[3];
    uint64_t paths, rays;
    int32_t count; /* samples */
    int32_t asked; /* TY_BAKE_IMPULSE: of which so many asked what media make of emitters; TY_BAKE_CACHE: fog rays */
    int32_t done;
} ty_bake_sums;

/* Adds samples [first, first + count) of receivers [begin, end) to sums and to light, both of all receivers. light:
 * layers x 3 channels x terms each. */
#define TY_BAKE_KERNEL(name)                                                                                           \
    void name(const ty_bake_request* request, int64_t begin, int64_t end, uint32_t first, uint32_t count,              \
              ty_bake_sums* sums, double* light)
typedef TY_BAKE_KERNEL((*ty_bake_kernel));
TY_DECLARE_KERNEL_FUNCTION(TY_BAKE_KERNEL, ty_bake_kernel);

#endif
