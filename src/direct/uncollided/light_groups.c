/* Groups of samples by light. */
#include "direct/uncollided/light_groups.h"

#include "base/context.h"
#include "scene/scene.h"

#include <math.h>

/* Relative tolerance for colors that are multiples of each other. */
static const float color_tolerance = 1e-6f;

/* Maximum ratio of radius to distance at which a surface light counts as a point. */
static const float max_angular_radius = 0.5f;

static float distance_to_box(const ty_grid_box* box, ty_vec p) {
    const float at[3] = {p.x, p.y, p.z};
    float square = 0;
    for (int a = 0; a < 3; ++a) {
        const float off = at[a] - ty_clampf(at[a], (float)box->lower[a], (float)box->upper[a]);
        square += off * off;
    }
    return sqrtf(square);
}

/* The group from sample `first` on; dedicated if the light allows it. */
static ty_light_group next_group(const ty_scene* scene, const ty_grid_box* box, const ty_discrete_light* sources,
                                 int32_t count, int32_t first, float point_radius) {
    const ty_light_set* lights = &ty_scene_get_view(scene)->lights;
    ty_light_group g = {.first = first, .dedicated = true};
    const int32_t light = sources[first].light;
    ty_vec sum = ty_vec_make(0, 0, 0);
    /* VPLs are not at the light that they reflect, so they form groups of their own. */
    for (int32_t i = first;
         i < count && sources[i].light == light && sources[i].is_virtual == sources[first].is_virtual; ++i) {
        ++g.count;
        sum = ty_add(sum, sources[i].position);
    }
    g.center = ty_scale(sum, 1.0f / (float)g.count);
    if (sources[first].kind == TY_DISCRETE_DIRECTIONAL) {
        g.dedicated = g.count == 1 && lights->lights[light].kind == TY_KIND_DIRECTIONAL;
        return g;
    }
    if (sources[first].is_virtual != 0) g.dedicated = false;
    if (sources[first].is_point != 0 || !g.dedicated) return g;
    float radius = 0;
    for (int32_t i = first; i < first + g.count; ++i) {
        const ty_vec off = ty_sub(sources[i].position, g.center);
        radius = ty_maxf(radius, sqrtf(ty_dot(off, off)));
    }
    g.dedicated = lights->lights[light].kind != TY_KIND_TRIANGLE &&
                  (radius <= point_radius || radius <= max_angular_radius * distance_to_box(box, g.center));
    return g;
}

int32_t ty_light_groups_find(const ty_scene* scene, const ty_grid_box* box, const ty_discrete_light* sources,
                             int32_t count, int32_t max_dedicated, float point_radius, ty_light_group* groups) {
    int32_t found = 0, dedicated = 0;
    for (int32_t i = 0; i < count; i += groups[found++].count) {
        groups[found] = next_group(scene, box, sources, count, i, point_radius);
        groups[found].dedicated = groups[found].dedicated && dedicated < max_dedicated;
        if (groups[found].dedicated) ++dedicated;
    }
    return found;
}

bool ty_discrete_lights_share_color(const ty_discrete_light* sources, int32_t count, const float color[3]) {
    for (int32_t i = 0; i < count; ++i)
        for (int c = 0; c < 3; ++c) {
            const float* dedicated = sources[i].color;
            const int d = (c + 1) % 3;
            if (fabsf(dedicated[c] * color[d] - dedicated[d] * color[c]) >
                color_tolerance * ty_maxf(dedicated[c] * color[d], dedicated[d] * color[c]))
                return false;
        }
    return true;
}

ty_result ty_light_groups_field(const ty_discrete_light* sources, const ty_light_group* groups, int32_t count,
                                bool dedicated, const ty_grid_medium* medium, bool with_flux, ty_light_field** out) {
    const float* color = sources[groups[0].first].color;
    bool shared = medium->planes == 1 && color[0] + color[1] + color[2] > 0;
    for (int32_t i = 0; i < count; ++i)
        shared = shared && (groups[i].dedicated != dedicated ||
                            ty_discrete_lights_share_color(&sources[groups[i].first], groups[i].count, color));
    return shared ? ty_light_field_create_shared(medium, with_flux, color, out)
                  : ty_light_field_create(medium, with_flux, out);
}

ty_light_fluence ty_light_group_fluence(const ty_discrete_light* sources, const ty_light_group* group,
                                        const ty_light_field* field) {
    ty_light_fluence light = {.kind = TY_FLUENCE_P1};
    if (group != NULL) {
        ty_discrete_light sample = sources[group->first];
        if (sample.kind == TY_DISCRETE_POINT) sample.position = group->center;
        light = ty_light_fluence_of(&sample);
    }
    light.shared = field->planes == 1;
    for (int c = 0; c < 3; ++c) {
        light.color[c] = field->planes == 1 ? field->color[c] : 1;
        light.fluence[c] = field->fluence[c];
        for (int a = 0; a < 3; ++a) light.flux[c][a] = field->flux[c][a];
    }
    return light;
}

/* ---- light of all groups ---- */

typedef struct groups_job {
    const ty_scene* scene;
    const ty_grid_medium* medium;
    float* const* extinction;
    const ty_discrete_light* samples;
    const ty_light_group* groups;
    int32_t group_count;
    ty_part_progress* progress;
} groups_job;

static ty_result light_group(const groups_job* job, const ty_light_group* group, ty_light_field** field) {
    ty_result result = ty_part_show(job->progress, "direct light", 0);
    if (result == TY_OK && *field == NULL)
        result = ty_light_groups_field(job->samples, group->dedicated ? group : job->groups,
                                       group->dedicated ? 1 : job->group_count, group->dedicated, job->medium,
                                       !group->dedicated, field);
    if (result == TY_OK)
        result = ty_uncollided_add_with_progress(job->scene, job->medium, job->extinction, &job->samples[group->first],
                                                 group->count, *field, ty_part_report, job->progress);
    return result;
}

static ty_result light_groups(const groups_job* job, ty_light_field** fields, ty_light_field** aggregate,
                              ty_light_fluence* fluences, int32_t* count) {
    ty_part_progress* progress = job->progress;
    const double from = progress->from, fraction = progress->span;
    ty_result result = TY_OK;
    *count = 0;
    progress->span = fraction / ty_maxf(1, (float)job->group_count);
    for (int32_t i = 0; i < job->group_count && result == TY_OK; ++i) {
        const ty_light_group* group = &job->groups[i];
        ty_light_field** field = group->dedicated ? &fields[*count] : aggregate;
        result = light_group(job, group, field);
        progress->from += progress->span;
        if (result == TY_OK && group->dedicated)
            fluences[(*count)++] = ty_light_group_fluence(job->samples, group, *field);
    }
    progress->from = from;
    progress->span = fraction;
    if (result == TY_OK && *aggregate != NULL)
        fluences[(*count)++] = ty_light_group_fluence(job->samples, NULL, *aggregate);
    return result;
}

ty_result ty_light_groups_solve(const ty_scene* scene, const ty_grid_medium* medium, float* const extinction[3],
                                const ty_discrete_light_set* samples, int32_t max_dedicated, ty_part_progress* progress,
                                ty_light_field** fields, ty_light_fluence* fluences, int32_t* count) {
    const size_t max_groups = (size_t)samples->count;
    ty_light_group* groups = ty_alloc_array(medium->context, max_groups, sizeof *groups, false);
    if (groups == NULL) return TY_ERROR_MEMORY;
    const groups_job job = {
        .scene = scene,
        .medium = medium,
        .extinction = extinction,
        .samples = samples->items,
        .groups = groups,
        .group_count =
            ty_light_groups_find(scene, &medium->box, samples->items, samples->count, max_dedicated, 0, groups),
        .progress = progress,
    };
    const ty_result result = light_groups(&job, fields, &fields[max_dedicated], fluences, count);
    ty_free_array(medium->context, groups, max_groups, sizeof *groups);
    return result;
}
