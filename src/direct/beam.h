/* One beam through a grid. */
#ifndef TY_DIRECT_BEAM_H
#define TY_DIRECT_BEAM_H

#include "direct/grid_medium.h"
#include "direct/kernel.h"
#include "scene/scene.h"

/* Tubes and the slabs they pass, in the order in which the beam does. Axes 0, 1, 2 here are u, v, w: w is the world's
 * axis along which the beam passes the most cells, so that from one slab to the next it moves by a cell at most along u
 * and v; u is the axis of a row in memory. */
typedef struct ty_beam {
    ty_context* context;
    const ty_beam_kernels* kernels;
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
    float* hit;            /* TY_BEAM_RAYS times per tube: how far a surface is, m; NULL: there are none */
    float* along[2];       /* per tube: transmittance so far, by turns */
    float* scratch;        /* of the workers */
    size_t scratch_size;   /* of each */
} ty_beam;

/* Whatever becomes of it, ty_beam_end may follow. Errors: TY_ERROR_MEMORY. */
ty_result ty_beam_begin(const ty_scene_view* scene, const ty_grid_medium* medium, const double outside[2][3],
                        ty_vec direction, ty_beam* beam);
void ty_beam_end(ty_beam* beam);
/* Mean transmittance of every cell to `lit`, power per irradiance entering and leaving to `power` unless that is NULL;
 * extinction and lit are in the medium's order of cells. Errors: TY_ERROR_MEMORY. */
ty_result ty_beam_pass(ty_beam* beam, const ty_grid_medium* medium, const float* extinction, float* lit,
                       double power[2]);

#endif
