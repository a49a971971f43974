/* Uncollided light, and the source that it is for diffusion: q of Eq. 6, from the reduced beam unless the paper's is
 * asked for. */
#include "method/fld/job.h"

#include "base/context.h"
#include "direct/turned.h"
#include "scene/scene.h"

#include <math.h>
#include <string.h>

/* Relative difference up to which colors are multiples of each other. */
static const float alike = 1e-6f;

/* A light is as good as a point from where it looks at most this large: its radius over the distance. */
static const float point_like = 0.5f;

/* ---- which sources keep fields of their own ---- */

/* Consecutive sources of one light. */
typedef struct group {
    int32_t first, count;
    ty_vec middle; /* of lamps, m */
    bool own;      /* whether the phase function can be met from one direction, or one point */
} group;

static float distance_to_box(const ty_grid_box* box, ty_vec p) {
    const float at[3] = {p.x, p.y, p.z};
    float square = 0;
    for (int a = 0; a < 3; ++a) {
        const float off = at[a] - ty_clampf(at[a], (float)box->lower[a], (float)box->upper[a]);
        square += off * off;
    }
    return sqrtf(square);
}

/* The next group after the sources before `first`. */
static group next_group(const ty_fld_job* job, int32_t first) {
    const ty_source* sources = job->sources;
    const ty_light_set* lights = &ty_scene_get_view(job->scene)->lights;
    group g = {.first = first, .own = true};
    const int32_t light = sources[first].light;
    ty_vec sum = ty_vec_make(0, 0, 0);
    for (int32_t i = first; i < job->source_count && sources[i].light == light; ++i) {
        ++g.count;
        sum = ty_add(sum, sources[i].position);
    }
    g.middle = ty_scale(sum, 1.0f / (float)g.count);
    if (sources[first].kind == TY_SOURCE_BEAM) {
        g.own = g.count == 1 && lights->lights[light].kind == TY_KIND_DIRECTIONAL;
        return g;
    }
    if (sources[first].alone != 0) return g;
    float radius = 0;
    for (int32_t i = first; i < first + g.count; ++i) {
        const ty_vec off = ty_sub(sources[i].position, g.middle);
        radius = ty_maxf(radius, sqrtf(ty_dot(off, off)));
    }
    g.own = lights->lights[light].kind != TY_KIND_TRIANGLE &&
            radius <= point_like * distance_to_box(&job->fine->box, g.middle);
    return g;
}

/* Whether light of these sources differs between channels by `color` alone: then one plane will do for all. */
static bool share_color(const ty_fld_job* job, const group* g, const float color[3]) {
    for (int32_t i = g->first; i < g->first + g->count; ++i)
        for (int c = 0; c < 3; ++c) {
            const float* own = job->sources[i].color;
            const int d = (c + 1) % 3;
            if (fabsf(own[c] * color[d] - own[d] * color[c]) > alike * ty_maxf(own[c] * color[d], own[d] * color[c]))
                return false;
        }
    return true;
}

/* Dark fields for a group that has one of its own, or for all that have none. */
static ty_result make_field(ty_fld_job* job, const group* groups, int32_t count, bool own, ty_light_field** out) {
    const float* color = job->sources[groups[0].first].color;
    bool shared = job->fine->planes == 1 && color[0] + color[1] + color[2] > 0;
    for (int32_t i = 0; i < count; ++i)
        shared = shared && (groups[i].own != own || share_color(job, &groups[i], color));
    return shared ? ty_light_field_create_shared(job->fine, !own, color, out)
                  : ty_light_field_create(job->fine, !own, out);
}

/* What the marcher is told of a field. */
static void describe_field(const ty_light_field* field, ty_single_light* single) {
    single->shared = field->planes == 1;
    for (int c = 0; c < 3; ++c) {
        single->color[c] = field->planes == 1 ? field->color[c] : 1;
        single->fluence[c] = field->fluence[c];
        for (int a = 0; a < 3; ++a) single->flux[c][a] = field->flux[c][a];
    }
}

static ty_result light_field(ty_fld_job* job, float* const extinction[3], const group* g, ty_light_field* field) {
    return ty_uncollided_add_watched(job->scene, job->fine, extinction, &job->sources[g->first], g->count, field,
                                     ty_part_report, &job->progress);
}

/* The groups that have fields of their own, then all others together. */
static ty_result light_groups(ty_fld_job* job, float* const extinction[3], const group* groups, int32_t count) {
    ty_fld* light = job->light;
    const double from = job->progress.from, share = job->progress.share;
    ty_result result = TY_OK;
    job->progress.share = share / ty_maxf(1, (float)count);
    for (int32_t i = 0; i < count && result == TY_OK; ++i) {
        ty_light_field** field = &light->beam[groups[i].own ? light->light_count : TY_FLD_OWN_MAX];
        result = ty_part_show(&job->progress, "direct light");
        if (result == TY_OK && *field == NULL)
            result =
                make_field(job, groups[i].own ? &groups[i] : groups, groups[i].own ? 1 : count, groups[i].own, field);
        if (result == TY_OK) result = light_field(job, extinction, &groups[i], *field);
        job->progress.from += job->progress.share;
        if (result != TY_OK || !groups[i].own) continue;
        const ty_source* source = &job->sources[groups[i].first];
        ty_single_light* single = &light->lights[light->light_count++];
        single->kind = source->kind == TY_SOURCE_BEAM ? TY_SINGLE_BEAM : TY_SINGLE_LAMP;
        single->toward = source->kind == TY_SOURCE_BEAM ? source->direction : groups[i].middle;
        describe_field(*field, single);
    }
    job->progress.from = from;
    job->progress.share = share;
    if (result != TY_OK || light->beam[TY_FLD_OWN_MAX] == NULL) return result;
    ty_single_light* single = &light->lights[light->light_count++];
    single->kind = TY_SINGLE_MANY;
    describe_field(light->beam[TY_FLD_OWN_MAX], single);
    return TY_OK;
}

/* Sources by light; at most TY_FLD_OWN_MAX keep fields of their own. */
static ty_result light_all(ty_fld_job* job, float* const extinction[3]) {
    group* groups = ty_alloc_array(job->context, (size_t)job->source_count, sizeof *groups, false);
    if (groups == NULL) return TY_ERROR_MEMORY;
    int32_t count = 0, own = 0;
    for (int32_t i = 0; i < job->source_count; i += groups[count++].count) {
        groups[count] = next_group(job, i);
        groups[count].own = groups[count].own && own < TY_FLD_OWN_MAX;
        if (groups[count].own) ++own;
    }
    const ty_result result = light_groups(job, extinction, groups, count);
    ty_free_array(job->context, groups, (size_t)job->source_count, sizeof *groups);
    return result;
}

/* ---- what scatters of it ---- */

ty_result ty_fld_find_sources(ty_fld_job* job, const ty_grid_medium* medium, float* source[3]) {
    float* fine = ty_alloc_array(job->context, job->fine->cells, sizeof *fine, false);
    if (fine == NULL) return TY_ERROR_MEMORY;
    ty_result result = TY_OK;
    for (int32_t c = 0; c < 3 && result == TY_OK; ++c) {
        source[c] = ty_alloc_array(job->context, medium->cells, sizeof(float), false);
        if (source[c] == NULL) {
            result = TY_ERROR_MEMORY;
            break;
        }
        ty_turned_find(job->fine, job->light->lights, job->light->light_count, c, job->def->beam == TY_FLD_BEAM_REDUCED,
                       fine);
        ty_grid_average(job->context, fine, job->fine->box.size, medium->box.size, source[c]);
    }
    ty_free_array(job->context, fine, job->fine->cells, sizeof *fine);
    return result;
}

ty_result ty_fld_light_directly(ty_fld_job* job) {
    const ty_source_def def = {
        .environment = job->def->environment_beams, .surface = job->def->surface_points, .seed = job->def->seed};
    const ty_grid_medium* fine = job->fine;
    float* extinction[3] = {0};
    ty_result result = ty_sources_create(job->scene, &def, &job->sources, &job->source_count);
    for (int32_t p = 0; p < fine->planes && result == TY_OK; ++p) {
        extinction[p] = ty_alloc_array(job->context, fine->cells, sizeof(float), false);
        if (extinction[p] == NULL) result = TY_ERROR_MEMORY;
    }
    if (result == TY_OK) ty_turned_extinction(fine, job->def->beam == TY_FLD_BEAM_REDUCED ? 1 : 0, extinction);
    if (result == TY_OK) result = light_all(job, extinction);
    for (int32_t p = 0; p < fine->planes; ++p) ty_free_array(job->context, extinction[p], fine->cells, sizeof(float));
    return result == TY_OK ? ty_fld_find_sources(job, job->coarse, job->source) : result;
}
