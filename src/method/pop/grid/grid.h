/* One ordinate's light on its own grid. Each call runs on one thread, so that ordinates run in parallel. */
#ifndef TY_METHOD_POP_GRID_GRID_H
#define TY_METHOD_POP_GRID_GRID_H

#include "direct/media/grid_medium.h"
#include "method/pop/grid/grid_geometry.k.h"

#include <tyndall/pop.h>

/* Floats per cell of `accumulated`, and index of the weight among them. */
enum { TY_POP_CELL_FLOATS = 8, TY_POP_CELL_FLOATS_PROPAGATED = 12, TY_POP_CELL_WEIGHT = 6 };

/* Light of one ordinate. Per cell of `accumulated`, in this order: radiance scattered towards the eye per scattering
 * coefficient, L_acc (R, G, B; W m^-2 sr^-1); fluence in the forward lobe (R, G, B; W m^-2; in propagated modes all
 * fluence that passed through the cell); in split mode the cell's weight, by which all of these are multiplied; 1
 * unused; in propagated modes the fluence not yet propagated (R, G, B), 1 unused. Radial grids store values times
 * r^2, m^2, and have one ghost cell on each side along i and j, which repeats the cell across the map's edge for
 * interpolation. */
typedef struct ty_pop_light {
    ty_discrete_light ordinate;
    ty_pop_grid grid;
    int32_t floats; /* TY_POP_CELL_FLOATS, TY_POP_CELL_FLOATS_PROPAGATED */
    float* accumulated;
    /* Stored lobes, else NULL, on cells without ghosts, per unit of the ordinate's color. Split mode, per plane of
     * the medium: three arrays U, R, S (below). Propagated modes, per plane: one array of uncollided fluence, and
     * for each band of iterations one of fluence and one of fluence times mean cosine. Shadows, profiles and, for
     * point lights in parallel grids, 1 / r^2 are included. */
    float* lobes;
    size_t lobe_floats;
    /* Outputs of the sweep or propagation: */
    ty_pop_mode mode;
    int32_t bands;           /* propagated modes: at most TY_POP_BANDS */
    double diffuse_power[3]; /* split mode: power scattered out of the forward lobe in the box, W, per channel */
    int32_t planes;          /* spectral planes of the medium */
} ty_pop_light;

/* Iterations are stored in bands 1, 2, 3-4, 5-8, ..., which bounds the number of arrays. */
enum { TY_POP_BANDS = 12 };
/* Band of iteration m, which counts from 1. */
int32_t ty_pop_band_index(int32_t m);

/* Fits a grid of `resolution` cells per axis around a box. A radial ordinate so distant that the box covers few
 * columns gets a parallel grid along the direction from its point to the box's center; the 1 / r^2 falloff is kept. */
void ty_pop_grid_fit(const ty_grid_box* box, const ty_discrete_light* ordinate, int32_t resolution, ty_pop_grid* out);

/* Sizes in floats of a light's `accumulated` and `lobes`. */
size_t ty_pop_accumulated_floats(const ty_pop_grid* grid, int32_t floats);
size_t ty_pop_lobe_floats(const ty_pop_grid* grid, const ty_pop_def* def, int32_t planes, int32_t iterations);

/* Split mode, one sweep along the columns: transmittances U, R and S of direct/single/forward.k.h as cell means, and
 * the radiance scattered towards the eye, with lobes flattened for a disc of mean cosine a_n (lobe.k.h). R and S take
 * negative g as 0; the phase function takes it as it is. medium: cells about as large as the grid's. */
void ty_pop_sweep(const ty_scene* scene, const ty_grid_medium* medium, const float eye[3], ty_pop_light* light);

/* Recomputes `accumulated` from stored lobes for another eye; in propagated modes only the radiance. */
void ty_pop_evaluate_lobes(const ty_grid_medium* medium, const float eye[3], ty_pop_light* light);

/* Adds to radiance (3) the scattered radiance along a unit vector at a point, from stored lobes, and to uncollided
 * (3; may be NULL) the uncollided fluence. */
void ty_pop_light_radiance(const ty_grid_medium* medium, const ty_pop_light* light, ty_vec point, ty_vec direction,
                           float* radiance, float* uncollided);

#endif
