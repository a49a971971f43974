/* Beams through a grid. */
#ifndef TY_DIRECT_UNCOLLIDED_COLLIMATED_H
#define TY_DIRECT_UNCOLLIDED_COLLIMATED_H

#include "direct/uncollided/transpose_scratch.h"
#include "direct/media/grid_medium.h"
#include "direct/uncollided/kernel.h"
#include "direct/uncollided/progress_meter.h"
#include "scene/scene.h"

/* Tubes and the slabs they pass, in the order in which the beam does. Axes 0, 1, 2 here are u, v, w: w is the world's
 * axis along which the beam passes the most cells, so that from one slab to the next it moves by a cell at most along u
 * and v; u is the axis of a row in memory. */
typedef struct ty_collimated {
    ty_context* context;
    const ty_direct_kernels* kernels;
    int32_t axis[3];       /* of the world */
    int32_t size[3];       /* cells */
    size_t stride[3];      /* floats from cell to cell */
    bool backwards;        /* along w */
    float length;          /* of a tube within a slab, m */
    double section;        /* of a tube, m^2 */
    int32_t* shift[2];     /* per slab along u and v: tube t covers cells t + shift and the next two */
    float (*weight[2])[3]; /* of the three, on the mean over the slab */
    int32_t first[2];      /* number of the tubes' first column and row */
    int32_t tubes[2];      /* columns and rows of tubes */
    float* hit;            /* TY_TUBE_RAYS times per tube: how far a surface is, m; NULL: there are none */
    float* along[2];       /* per tube: transmittance so far, by turns */
} ty_collimated;

/* Whatever becomes of it, ty_collimated_end may follow. Errors: TY_ERROR_MEMORY. */
ty_result ty_collimated_begin(const ty_scene_view* scene, const ty_grid_medium* medium, const double outside[2][3],
                              ty_vec direction, ty_collimated* beam);
void ty_collimated_end(ty_collimated* beam);
size_t ty_collimated_tubes(const ty_collimated* beam);
/* 2 w, and one more for a beam that goes backwards along w: beams with the same one can pass together. */
int32_t ty_collimated_sweep_axis(const ty_grid_medium* medium, ty_vec direction);

/* Beams that pass together, and planes of one value a cell to which mean transmittances are added, each beam's times a
 * factor. Planes are in the medium's order of cells. */
enum { TY_COLLIMATED_MAX = 16 };

typedef struct ty_collimated_batch {
    ty_collimated* beams; /* of one way */
    int32_t count;
    const float* extinction;
    int32_t plane_count;
    float* planes[TY_TUBE_PLANES_MAX];
    float factor[TY_COLLIMATED_MAX][TY_TUBE_PLANES_MAX];
    ty_transpose_scratch* scratch; /* NULL: of this pass alone */
    ty_progress_meter* meter;      /* NULL: none */
    double done, work;             /* for it: sources' worth before this, and of this */
} ty_collimated_batch;

/* Errors: TY_ERROR_MEMORY; TY_CANCELLED. */
ty_result ty_collimated_sweep(const ty_collimated_batch* beams, const ty_grid_medium* medium);
/* Of a beam that has passed: power per irradiance entering and leaving, m^2. Errors: TY_ERROR_MEMORY. */
ty_result ty_collimated_power_of(const ty_collimated* beam, double power[2]);

#endif
