/* Result of a solve: lights on the fine grid, ordinates on their own grids, merged cells and diffuse light. */
#ifndef TY_METHOD_POP_SOLUTION_H
#define TY_METHOD_POP_SOLUTION_H

#include "direct/single/single.k.h"
#include "direct/uncollided/uncollided.h"
#include "method/pop/merge/merge.h"
#include "method/diffuse/interreflection.h"
#include "method/pop/ordinate/ordinate.h"
#include "solve/diffusion/light/diffuse_light.h"

struct ty_pop {
    ty_context* context;
    ty_pop_def def; /* with a resolution of 0 resolved */
    float eye[3];
    /* Lights on the fine grid. */
    ty_grid_box fine_box;
    ty_light_field* fields[TY_POP_FINE_LIGHTS_MAX][TY_FLUENCE_COUNT];
    ty_light_fluence lights[TY_POP_FINE_LIGHTS_MAX];
    int32_t light_count;
    /* Ordinates, each on its own grid. */
    ty_grid_medium* medium; /* sampled by the ordinates' grids */
    ty_pop_light* ordinates;
    int32_t count;
    ty_pop_merged merged;   /* sum over ordinates */
    ty_pop_merged residuum; /* published modes: light from the isotropic residuum */
    float scale[3];         /* split mode: factor on merged fluence that restores the ordinates' power, per channel */
    size_t cells;           /* of merged and residuum */
    ty_diffuse_light* diffuse;  /* split mode */
    ty_irradiance_cache* cache; /* split mode: of surfaces outside of the box; NULL: none */
    float* guide;               /* mean extinction of merged cells, 1/m */
};

/* Makes a view of the light for another eye, with merged cells recomputed from stored lobes: it shares all memory with
 * the light but for the merged cells and the table of ordinates. It is freed by ty_pop_end_view, after errors, too.
 * Errors: TY_ERROR_MEMORY, TY_CANCELLED. */
ty_result ty_pop_move_eye(const ty_pop* light, const float eye[3], const ty_part_progress* progress, ty_pop* out);
void ty_pop_end_view(const ty_pop* light, ty_pop* view);

#endif
