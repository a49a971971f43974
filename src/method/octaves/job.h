/* The result of a solve, and the state of a call. */
#ifndef TY_METHOD_OCTAVES_JOB_H
#define TY_METHOD_OCTAVES_JOB_H

#include "base/progress.h"
#include "direct/lights/discretize.h"
#include "direct/uncollided/light_groups.h"
#include "image/march.h"
#include "image/options.h"
#include "option/option.h"

#include <tyndall/octaves.h>

/* Maximum number of lights with a dedicated fluence field, which preserves the shape of their phase function; all other
 * lights share an aggregate field. */
enum { TY_OCTAVES_OWN_MAX = 8, TY_OCTAVES_LIGHTS_MAX = TY_OCTAVES_OWN_MAX + 1 };

struct ty_octaves {
    ty_context* context;
    ty_grid_box box; /* dimensions of the fluence grid */
    int32_t light_count;
    ty_light_field* fields[TY_OCTAVES_MAX][TY_OCTAVES_LIGHTS_MAX];
    ty_light_fluence
        lights[TY_OCTAVES_MAX * TY_OCTAVES_LIGHTS_MAX]; /* light_count fields per octave, octave by octave */
    ty_march_octaves octaves;
};

typedef struct ty_octaves_job {
    ty_context* context;
    const ty_scene* scene;
    const ty_octaves_def* def;
    ty_part_progress progress;
    ty_grid_medium* medium;
    ty_discrete_light_set sources; /* fields of the current octave, as are groups */
    ty_light_group* groups;
    int32_t group_count;
    ty_octaves* light;
    ty_octaves_stats stats;
} ty_octaves_job;

extern const ty_option_table ty_octaves_options;
/* Copies a caller's def to own, sets *def to own, and checks it. Errors: TY_ERROR_ARGUMENT. */
ty_result ty_octaves_take_def(ty_context* context, const ty_octaves_def** def, ty_octaves_def* own);
ty_image_options ty_octaves_image_options(const ty_octaves_def* def);

/* Computes a^i, b^i and c^i of all octaves (Wrenninge 2013). */
ty_march_octaves ty_octaves_of(const ty_octaves_def* def);
/* Computes the uncollided fluence of all lights on the medium's cells, per octave with extinction b^i sigma_t. */
ty_result ty_octaves_light(ty_octaves_job* job);

#endif
