/* Parallel light through a grid. */
#ifndef TY_DIRECT_UNCOLLIDED_COLLIMATED_H
#define TY_DIRECT_UNCOLLIDED_COLLIMATED_H

#include "base/progress.h"
#include "direct/uncollided/transpose.h"
#include "direct/media/grid_medium.h"
#include "direct/uncollided/kernel.h"
#include "scene/scene.h"

/* Tubes of parallel light, and the slabs of cells in the order of travel. Axes 0, 1, 2 are u, v, w: w is the world's
 * axis along which the light crosses the most cells, so that a tube moves by at most one cell along u and v from slab
 * to slab; u is the axis of rows in memory. */
typedef struct ty_collimated {
    ty_context* context;
    const ty_direct_kernels* kernels;
    int32_t axis[3];       /* world axes of u, v, w */
    int32_t size[3];       /* cells */
    size_t stride[3];      /* floats between cells */
    bool backwards;        /* travels towards lower w */
    float length;          /* path length of a tube within a slab, m */
    double section;        /* cross section of a tube, m^2 */
    int32_t* shift[2];     /* per slab along u and v: tube t covers cells t + shift and the next two */
    float (*weight[2])[3]; /* mean overlap with these three cells */
    int32_t first[2];      /* first column and row of tubes */
    int32_t tubes[2];      /* columns and rows of tubes */
    float* hit;            /* distance to the first surface for TY_TUBE_RAYS rays per tube, m; NULL: no surfaces */
    float* along[2];       /* transmittance per tube before and after a slab, double buffered */
} ty_collimated;

/* ty_collimated_end may follow in any case. Errors: TY_ERROR_MEMORY. */
ty_result ty_collimated_begin(const ty_scene_view* scene, const ty_grid_medium* medium, const double outside[2][3],
                              ty_vec direction, ty_collimated* beam);
void ty_collimated_end(ty_collimated* beam);
size_t ty_collimated_tubes(const ty_collimated* beam);
/* 2 w, plus 1 towards lower w: light with the same number can be swept together. */
int32_t ty_collimated_sweep_axis(const ty_grid_medium* medium, ty_vec direction);

/* Parallel light of several directions that is swept together, and the planes that mean transmittances are added to,
 * each times a factor. Planes are in the medium's order of cells. */
enum { TY_COLLIMATED_MAX = 16 };

typedef struct ty_collimated_batch {
    ty_collimated* beams; /* all with one sweep axis */
    int32_t count;
    const float* extinction;
    int32_t plane_count;
    float* planes[TY_TUBE_PLANES_MAX];
    float factor[TY_COLLIMATED_MAX][TY_TUBE_PLANES_MAX];
    ty_transpose_scratch* scratch; /* NULL: allocated for this sweep */
    ty_part_progress* progress;    /* of this sweep; NULL: no progress */
} ty_collimated_batch;

/* Mean overlap of cell `at` with a tube one cell wide whose position moves from `from` to `to`, cells. */
double ty_tube_overlap(double at, double from, double to);
/* Errors: TY_ERROR_MEMORY; TY_CANCELLED. */
ty_result ty_collimated_sweep(const ty_collimated_batch* beams, const ty_grid_medium* medium);
/* After a sweep: entering and leaving power per irradiance, m^2. Errors: TY_ERROR_MEMORY. */
ty_result ty_collimated_power_of(const ty_collimated* beam, double power[2]);

#endif
