/* The result of a solve, and the state of one call on its way through the parts of the method. */
#ifndef TY_METHOD_OCTAVES_JOB_H
#define TY_METHOD_OCTAVES_JOB_H

#include "base/progress.h"
#include "direct/group.h"
#include "image/march.h"
#include "image/options.h"
#include "option/option.h"

#include <tyndall/octaves.h>

/* Lights with a field of their own, so that their phase function stays sharp, beside one of all others together. */
enum { TY_OCTAVES_OWN_MAX = 8, TY_OCTAVES_LIGHTS_MAX = TY_OCTAVES_OWN_MAX + 1 };

struct ty_octaves {
    ty_context* context;
    ty_grid_box box; /* of the cells of light */
    int32_t light_count;
    ty_light_field* fields[TY_OCTAVES_MAX][TY_OCTAVES_LIGHTS_MAX];
    ty_single_light
        lights[TY_OCTAVES_MAX * TY_OCTAVES_LIGHTS_MAX]; /* light_count of each octave, one after the other */
    ty_march_octaves octaves;
};

typedef struct ty_octaves_job {
    ty_context* context;
    const ty_scene* scene;
    const ty_octaves_def* def;
    ty_part_progress progress;
    ty_grid_medium* medium;
    ty_source* sources; /* of the octave that is lit, as are groups */
    int32_t source_count;
    ty_source_group* groups;
    int32_t group_count;
    ty_octaves* light;
    ty_octaves_stats stats;
} ty_octaves_job;

extern const ty_option_table ty_octaves_options;
/* Copies a caller's def to own, which *def then is, and checks it. Errors: TY_ERROR_ARGUMENT. */
ty_result ty_octaves_take_def(ty_context* context, const ty_octaves_def** def, ty_octaves_def* own);
ty_image_options ty_octaves_image_options(const ty_octaves_def* def);

/* a^i, b^i and c^i of all octaves. */
ty_march_octaves ty_octaves_of(const ty_octaves_def* def);
/* The fluence of all lights on the medium's cells, once per octave behind b^i sigma_t. */
ty_result ty_octaves_light(ty_octaves_job* job);

#endif
