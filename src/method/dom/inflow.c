/* Surfaces outside of the box, such as a floor under a cloud: what they send into it of environments and area lights is
 * radiance that comes in through its faces, along each ordinate the mean of what some rays meet. */
#include "base/context.h"
#include "method/dom/job.h"
#include "scene/scene.h"

#include <math.h>
#include <string.h>

/* Rays of each direction, evenly over the faces that it leads in through. */
enum { RAYS = 16 };

/* Of a sequence that fills a square evenly: one over powers of the root of x^3 = x + 1. */
static const double step_u = 0.7548776662466927, step_v = 0.5698402909980532;

typedef struct inflow {
    ty_dom_job* job;
    ty_walls met; /* surfaces that rays met, as sides of walls: of direction d from d RAYS on */
    float* irradiance[3];
} inflow;

/* Where one of a direction's rays enters the box. */
static void entry(const ty_dom_job* job, int32_t direction, int32_t ray, double at[3]) {
    const ty_grid_box* box = &job->coarse->box;
    double edge[3], way[3], share[3], sum = 0;
    for (int a = 0; a < 3; ++a) {
        edge[a] = box->upper[a] - box->lower[a];
        way[a] = (double)job->set->direction[a][direction];
    }
    for (int a = 0; a < 3; ++a) sum += share[a] = fabs(way[a]) * edge[(a + 1) % 3] * edge[(a + 2) % 3];
    double place = (ray + 0.5) / RAYS * sum;
    int axis = 0;
    for (; axis < 2 && place > share[axis]; ++axis) place -= share[axis];
    const double u = (ray + 1) * step_u, v = (ray + 1) * step_v;
    const int b = (axis + 1) % 3, c = (axis + 2) % 3;
    at[axis] = way[axis] > 0 ? box->lower[axis] : box->upper[axis];
    at[b] = box->lower[b] + edge[b] * (u - floor(u));
    at[c] = box->lower[c] + edge[c] * (v - floor(v));
}

/* What a ray back from there meets; albedo 0: nothing, or a wall of the box. */
static void meet(const inflow* in, int32_t direction, int32_t ray, ty_wall* wall) {
    const ty_scene_view* view = &in->job->scene->view;
    const ty_angular_quadrature* set = in->job->set;
    const ty_vec back =
        ty_vec_make(-set->direction[0][direction], -set->direction[1][direction], -set->direction[2][direction]);
    double at[3];
    float from[3];
    ty_hit hit;
    entry(in->job, direction, ray, at);
    for (int a = 0; a < 3; ++a) from[a] = (float)at[a];
    *wall = (ty_wall){.position = ty_vec_load(from), .normal = ty_scale(back, -1)};
    if (!ty_accel_intersect(view->mesh, ty_vec_load(from), back, TY_FLOAT_MAX, &hit)) return;
    if (ty_dom_is_walled(in->job, hit.position)) return;
    ty_surface_point point;
    ty_surface_evaluate(&view->surfaces[hit.surface], &hit, back, &point);
    wall->normal = point.ng;
    wall->position = ty_hit_leave(&hit, point.ng);
    for (int c = 0; c < 3; ++c) {
        wall->albedo[c] = ty_minf(point.albedo[c], 1);
        wall->emission[c] = point.light < 0 ? point.emission[c] : 0;
    }
}

static void meet_all(void* user, int64_t direction, int32_t worker) {
    (void)worker;
    const inflow* in = user;
    for (int32_t ray = 0; ray < RAYS; ++ray) meet(in, (int32_t)direction, ray, &in->met.sides[direction * RAYS + ray]);
}

/* Sources whose reflections no virtual lamps stand for. */
static void light_met(const inflow* in) {
    const ty_dom_job* job = in->job;
    const ty_light_set* lights = &ty_scene_get_view(job->scene)->lights;
    for (int32_t i = 0; i < job->source_count; ++i) {
        const ty_source* source = &job->sources[i];
        const int32_t kind = lights->lights[source->light].kind;
        const bool apart = kind == TY_KIND_DIRECTIONAL || kind == TY_KIND_POINT || kind == TY_KIND_SPOT;
        if (source->stand_in == NULL && apart) continue;
        ty_walls_light(job->scene, &in->met, job->coarse, job->coarse->extinction, source, 1, in->irradiance, NULL);
    }
}

/* In units of a channel. */
static float radiance_of(const inflow* in, int32_t channel, size_t ray) {
    const ty_wall* wall = &in->met.sides[ray];
    const ty_dom* light = in->job->light;
    float sent[3];
    for (int c = 0; c < 3; ++c) sent[c] = wall->albedo[c] / TY_PI * in->irradiance[c][ray] + wall->emission[c];
    if (!light->shared) return sent[channel];
    return (sent[0] + sent[1] + sent[2]) / (light->color[0] + light->color[1] + light->color[2]);
}

static ty_result take_inflow(const inflow* in) {
    ty_dom_job* job = in->job;
    for (int32_t c = 0; c < ty_dom_channels(job->light); ++c) {
        job->inflow[c] = ty_alloc_array(job->context, TY_ORDINATES_MAX, sizeof(float), true);
        if (job->inflow[c] == NULL) return TY_ERROR_MEMORY;
        for (int32_t d = 0; d < job->set->count; ++d)
            for (size_t ray = 0; ray < RAYS; ++ray)
                job->inflow[c][d] += radiance_of(in, c, (size_t)d * RAYS + ray) / RAYS;
    }
    return TY_OK;
}

bool ty_dom_reaches_out(const ty_dom_job* job) {
    double lower[3], upper[3];
    bool out = false;
    if (ty_scene_get_view(job->scene)->mesh == NULL) return false;
    ty_scene_surface_extent(job->scene, lower, upper);
    for (int a = 0; a < 3; ++a) {
        const double half = 0.5 * job->coarse->cell[a];
        out = out || lower[a] < job->coarse->box.lower[a] - half || upper[a] > job->coarse->box.upper[a] + half;
    }
    return out;
}

bool ty_dom_is_gray(const ty_dom_job* job) {
    for (size_t i = 0; i < job->scene->surface_count; ++i) {
        const ty_surface* surface = &job->scene->surfaces[i];
        if (ty_texture_exists(&surface->albedo_texture) || surface->colors != NULL) return false;
        for (int c = 0; c < 3; ++c)
            if (surface->albedo[c] != surface->albedo[0] || surface->emission[c] != surface->emission[0]) return false;
    }
    return true;
}

ty_result ty_dom_let_in(ty_dom_job* job) {
    if (!ty_dom_reaches_out(job)) return TY_OK;
    const size_t count = (size_t)job->set->count * RAYS;
    inflow in = {.job = job, .met = {.context = job->context, .count = (int32_t)count}};
    in.met.sides = ty_alloc_array(job->context, count, sizeof *in.met.sides, false);
    float* irradiance = ty_alloc_array(job->context, 3 * count, sizeof *irradiance, true);
    ty_result result = in.met.sides != NULL && irradiance != NULL ? TY_OK : TY_ERROR_MEMORY;
    for (size_t c = 0; c < 3; ++c) in.irradiance[c] = irradiance + c * count;
    if (result == TY_OK) {
        ty_parallel_for(job->context, job->set->count, meet_all, &in);
        light_met(&in);
        result = take_inflow(&in);
    }
    ty_free_array(job->context, in.met.sides, count, sizeof *in.met.sides);
    ty_free_array(job->context, irradiance, 3 * count, sizeof *irradiance);
    return result;
}
