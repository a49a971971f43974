/* One ordinate's light on its own grid. Calls work on one thread each, so that ordinates run side by side. */
#ifndef TY_METHOD_POP_GRID_H
#define TY_METHOD_POP_GRID_H

#include "direct/media/grid_medium.h"
#include "method/pop/frame.k.h"

/* Floats of a cell of `seen`. */
enum { TY_POP_SEEN = 8, TY_POP_SEEN_LEFT = 12, TY_POP_WEIGHT = 6 };

/* What merging needs of each cell, in this order: radiance that scatters towards the eye per scattering coefficient (R,
 * G, B; W m^-2 sr^-1), fluence of light that has kept its direction (R, G, B; W m^-2; propagated: of all that went
 * through the cell), split: the cell's weight, which all of these are multiplied by, else unused; 1 unused; of
 * propagated light fluence not yet passed on (R, G, B), 1 unused. In radial grids all are times the square of the
 * distance, m^2. Radial grids have a ring of one cell around i and j, which repeats what lies across the map's edges,
 * so that all cells can be looked up between. */
typedef struct ty_pop_light {
    ty_discrete_light ordinate;
    ty_pop_frame frame;
    int32_t floats; /* TY_POP_SEEN, TY_POP_SEEN_LEFT */
    float* seen;
    /* Kept lobes, else NULL, cells without a ring; all per ordinate's color. For each plane of the medium,
     * split: three arrays of cells, transmittance without and with the light that scattering sends on (below).
     * Propagated: an array of the light that has not scattered, and for each band of iterations one of the light that
     * passed, and one of it times its mean cosine. Shadows, profiles and in parallel grids of lamps 1 / r^2 are in. */
    float* lobes;
    size_t lobe_floats;
    /* Set by what fills in the light: */
    ty_pop_mode mode;
    int32_t bands;    /* propagated: TY_POP_BANDS at most */
    double turned[3]; /* split: W that scattering turned aside in the box, per channel */
    int32_t planes;   /* of the medium */
} ty_pop_light;

/* Iterations are kept in bands: 1, 2, 3-4, 5-8, ... so that few of them hold all. */
enum { TY_POP_BANDS = 12 };

/* The grid that spans a box: `resolution` cells along each axis. Radial ordinates so far from the box that it would be
 * within few columns get a parallel grid, along the way from the point to the box's middle; their light falls with
 * distance in it all the same. */
void ty_pop_frame_fit(const ty_grid_box* box, const ty_discrete_light* ordinate, int32_t resolution, ty_pop_frame* out);

/* Floats of a light's seen and lobes, and of the scratch that ty_pop_walk needs. */
size_t ty_pop_seen_floats(const ty_pop_frame* frame, int32_t floats);
size_t ty_pop_lobe_floats(const ty_pop_frame* frame, const ty_pop_def* def, int32_t planes, int32_t iterations);
size_t ty_pop_scratch_floats(const ty_pop_frame* frame, const ty_pop_def* def, int32_t planes);

/* Split mode, in one sweep: U, R and S of direct/forward.k.h along columns, as means over cells, and what of them
 * scatters towards the eye, flattened as light from a disc of mean cosine a_n is (lobe.k.h). Negative g counts as 0 in
 * R and S, and as it is in what scatters. medium: cells about as large as the grid's. */
void ty_pop_sweep(const ty_scene* scene, const ty_grid_medium* medium, const float eye[3], ty_pop_light* light);

/* What the published modes found of an ordinate. */
typedef struct ty_pop_walk_stats {
    double entered,
        left; /* sums of fluence times volume over cells and channels: at the beginning, not passed on yet */
    double initial_seconds, propagation_seconds;
} ty_pop_walk_stats;

/* Eq. 1-8: `iterations` of them, after what def->mode begins with. */
void ty_pop_walk(const ty_scene* scene, const ty_pop_def* def, const ty_grid_medium* medium, const float eye[3],
                 int32_t iterations, float* scratch, ty_pop_light* light, ty_pop_walk_stats* stats);

/* Eq. 9-10: iterations after which light of mean cosine `cosine` has one of def->residuum, in grids with cells of
 * `step`, m, at least as many as cells along the direction. */
int32_t ty_pop_walk_length(const ty_pop_def* def, const ty_grid_medium* medium, float cosine, float step);

/* Fills in `seen` anew from kept lobes for another eye; of propagated light what scatters towards it alone. */
void ty_pop_see(const ty_grid_medium* medium, const float eye[3], ty_pop_light* light);

/* Adds to radiance (3) what at a point travels along a unit vector and has scattered, from kept lobes; uncollided (3;
 * may be NULL): the fluence that has not. */
void ty_pop_light_radiance(const ty_grid_medium* medium, const ty_pop_light* light, ty_vec point, ty_vec way,
                           float* radiance, float* uncollided);

#endif
