/* The result of a solve, and the state of a call. */
#ifndef TY_METHOD_OCTAVES_JOB_H
#define TY_METHOD_OCTAVES_JOB_H

#include "direct/lights/discretize.h"
#include "direct/uncollided/light_groups.h"
#include "image/march/march.h"
#include "method/volume_method.h"

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
    ty_octaves* light;
    ty_octaves_stats stats;
} ty_octaves_job;

extern const ty_option_table ty_octaves_options;
extern const ty_volume_method ty_volume_octaves;
/* Refuses a scattering scale above the extinction scale of an attenuated view. */
ty_result ty_octaves_check_scales(ty_context* context, const void* def);

/* Computes a^i, b^i and c^i of all octaves (Wrenninge 2013). */
ty_march_octaves ty_octaves_of(const ty_octaves_def* def);
/* Computes the uncollided fluence of all lights on the medium's cells, per octave with extinction b^i sigma_t. */
ty_result ty_octaves_light(ty_octaves_job* job);

#endif
