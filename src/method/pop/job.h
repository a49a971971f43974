/* What a solve leaves behind, and one call on its way through the parts of the method. */
#ifndef TY_METHOD_POP_JOB_H
#define TY_METHOD_POP_JOB_H

#include "base/progress.h"
#include "direct/single.k.h"
#include "direct/uncollided.h"
#include "image/options.h"
#include "method/pop/carried.h"
#include "method/pop/merge.h"
#include "scene/scene.h"
#include "solve/diffusion/diffuse_light.h"

struct ty_pop {
    ty_context* context;
    ty_pop_def def; /* with the resolution that is meant by 0 */
    float eye[3];
    /* Sharp lights. */
    ty_grid_box fine_box;
    ty_light_field* fields[TY_POP_SHARP_MAX][TY_SINGLE_FLUENCES];
    ty_single_light lights[TY_POP_SHARP_MAX];
    ty_source sources[TY_POP_SHARP_MAX];
    int32_t light_count;
    /* Ordinates, each in a grid of its own. */
    ty_grid_medium* medium; /* what their grids sample */
    ty_pop_light* ordinates;
    int32_t count;
    ty_pop_merged merged;      /* all of them */
    ty_pop_merged residuum;    /* published modes: what their isotropic rest brings */
    float scale[3];            /* split mode: of merged fluence, so that it holds the ordinates' energy */
    size_t cells;              /* of both */
    ty_diffuse_light* diffuse; /* split mode */
    float* guide;              /* mean extinction of merged cells, 1/m */
};

typedef struct ty_pop_job {
    ty_context* context;
    const ty_scene* scene;
    const ty_pop_def* def;
    ty_part_progress progress;
    ty_grid_medium* fine;   /* cells of sharp lights; NULL where there are none */
    ty_grid_medium* medium; /* merged cells */
    float* source[3];       /* what turns aside on merged cells, W m^-3 */
    ty_pop_carried carried; /* of sharp beams with lobes; no cells where there are none */
    double entered;         /* published modes: light that came in */
    float importance[TY_POP_IMPORTANCE_WIDTH * TY_POP_IMPORTANCE_HEIGHT];
    ty_pop* light;
    ty_pop_stats stats;
} ty_pop_job;

/* Fails with the first field that is out of its range. */
ty_result ty_pop_check(ty_context* context, const ty_pop_def* def);
ty_image_options ty_pop_image_options(const ty_pop_def* def);

/* Cells of all kinds, and the media on them. */
ty_result ty_pop_sample_media(ty_pop_job* job);
/* Sharp lights, and what turns aside of them. */
ty_result ty_pop_light_sharply(ty_pop_job* job);
/* Ordinates of all other lights, their light on their own grids, and all of it on merged cells. */
ty_result ty_pop_light_ordinates(ty_pop_job* job);
/* What of the ordinates' light turns aside, split mode, and its diffusion. */
ty_result ty_pop_diffuse(ty_pop_job* job);
/* Merged cells seen from another place than before, from kept lobes. Errors: TY_ERROR_MEMORY. */
ty_result ty_pop_see_from(ty_pop* light, const float eye[3]);

/* Dark merged cells. with_left: also of light that is not passed on. */
ty_result ty_pop_merged_create(ty_context* context, const ty_grid_box* box, bool with_left, ty_pop_merged* out);
void ty_pop_merged_destroy(ty_context* context, ty_pop_merged* merged);

#endif
