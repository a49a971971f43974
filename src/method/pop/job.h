/* Result of a solve (struct ty_pop), and the state of one call across the method's stages. */
#ifndef TY_METHOD_POP_JOB_H
#define TY_METHOD_POP_JOB_H

#include "base/progress.h"
#include "direct/single/single.k.h"
#include "direct/uncollided/uncollided.h"
#include "image/options.h"
#include "method/pop/carried.h"
#include "method/pop/merge.h"
#include "scene/scene.h"
#include "solve/diffusion/diffuse_light.h"
#include "option/option.h"

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
    ty_diffuse_light* diffuse; /* split mode */
    float* guide;              /* mean extinction of merged cells, 1/m */
};

typedef struct ty_pop_job {
    ty_context* context;
    const ty_scene* scene;
    const ty_pop_def* def;
    ty_part_progress progress;
    ty_grid_medium* fine;             /* for fine-grid lights; NULL if there are none */
    ty_grid_medium* medium;           /* merged cells */
    float* source[3];                 /* diffusion source on merged cells, W m^-3 */
    ty_pop_delta_source delta_source; /* of fine-grid beams with lobes; without cells if there are none */
    double initial_light;             /* published modes: initial light */
    float importance[TY_POP_IMPORTANCE_WIDTH * TY_POP_IMPORTANCE_HEIGHT];
    ty_pop* light;
    ty_pop_stats stats;
} ty_pop_job;

extern const ty_option_table ty_pop_options;
/* Makes *def point to own: a copy of the caller's def in the library's own size, with all ranges checked. Fails with
 * the first field out of range. Errors: TY_ERROR_ARGUMENT. */
ty_result ty_pop_take_def(ty_context* context, const ty_pop_def** def, ty_pop_def* own);
ty_image_options ty_pop_image_options(const ty_pop_def* def);

/* Sizes all grids and samples the media on them. */
ty_result ty_pop_sample_media(ty_pop_job* job);
/* Lights the fine grid, and adds its diffusion source. */
ty_result ty_pop_inject_fine_grid(ty_pop_job* job);
/* Ordinates of all other lights: their light on their own grids, merged. */
ty_result ty_pop_light_ordinates(ty_pop_job* job);
/* Split mode: diffusion source of the ordinates' light, and the diffusion solve. */
ty_result ty_pop_diffuse(ty_pop_job* job);
/* Makes a view of the light for another eye, with merged cells recomputed from stored lobes: it shares all memory with
 * the light but for the merged cells and the table of ordinates. It is freed by ty_pop_end_view, after errors, too.
 * Errors: TY_ERROR_MEMORY. */
ty_result ty_pop_move_eye(const ty_pop* light, const float eye[3], ty_pop* out);
void ty_pop_end_view(const ty_pop* light, ty_pop* view);

/* Allocates zeros. with_unpropagated: with arrays of light not yet propagated. */
ty_result ty_pop_merged_create(ty_context* context, const ty_grid_box* box, bool with_unpropagated, ty_pop_merged* out);
void ty_pop_merged_destroy(ty_context* context, ty_pop_merged* merged);

#endif
