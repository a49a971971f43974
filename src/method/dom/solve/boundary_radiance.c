/* The boundary source of surfaces outside of the box, such as a floor under a cloud: they reflect environments and area
 * lights through the box's faces. The incident radiance along each direction of the quadrature is the mean over a few
 * rays. */
#include "base/context.h"
#include "method/dom/solve/solve.h"
#include "scene/scene.h"

#include <math.h>
#include <string.h>

/* Rays per direction, spread over the faces through which the direction enters the box. */
enum { RAYS = 16 };

/* Generators of the R2 low-discrepancy sequence: powers of the inverse of the real root of x^3 = x + 1. */
static const double step_u = 0.7548776662466927, step_v = 0.5698402909980532;

typedef struct boundary_job {
    ty_dom_job* job;
    ty_boundary_faces surfaces; /* surfaces that rays hit, as boundary sides; those of direction d start at d RAYS */
    float* irradiance[3];
} boundary_job;

/* The point at which one of a direction's rays enters the box. */
static void ray_entry(const ty_dom_job* job, int32_t direction, int32_t ray, double at[3]) {
    const ty_grid_box* box = &job->coarse->box;
    double edge[3], omega[3], weight[3], sum = 0;
    for (int a = 0; a < 3; ++a) {
        edge[a] = box->upper[a] - box->lower[a];
        omega[a] = (double)job->set->direction[a][direction];
    }
    for (int a = 0; a < 3; ++a) sum += weight[a] = fabs(omega[a]) * edge[(a + 1) % 3] * edge[(a + 2) % 3];
    double position = (ray + 0.5) / RAYS * sum;
    int axis = 0;
    for (; axis < 2 && position > weight[axis]; ++axis) position -= weight[axis];
    const double u = (ray + 1) * step_u, v = (ray + 1) * step_v;
    const int b = (axis + 1) % 3, c = (axis + 2) % 3;
    at[axis] = omega[axis] > 0 ? box->lower[axis] : box->upper[axis];
    at[b] = box->lower[b] + edge[b] * (u - floor(u));
    at[c] = box->lower[c] + edge[c] * (v - floor(v));
}

/* The surface that the ray hits when followed back from its entry; albedo 0 if it misses or hits a boundary face. */
static void trace_ray(const boundary_job* in, int32_t direction, int32_t ray, ty_boundary_side* side) {
    const ty_scene_view* view = &in->job->scene->view;
    const ty_angular_quadrature* set = in->job->set;
    const ty_vec direction_back =
        ty_vec_make(-set->direction[0][direction], -set->direction[1][direction], -set->direction[2][direction]);
    double at[3];
    float from[3];
    ty_hit hit;
    ray_entry(in->job, direction, ray, at);
    for (int a = 0; a < 3; ++a) from[a] = (float)at[a];
    *side = (ty_boundary_side){.position = ty_vec_load(from), .normal = ty_scale(direction_back, -1)};
    if (!ty_accel_intersect(view->mesh, ty_vec_load(from), direction_back, TY_FLOAT_MAX, &hit)) return;
    if (ty_dom_is_within_boundary(in->job, hit.position)) return;
    ty_surface_point point;
    ty_surface_evaluate(&view->surfaces[hit.surface], &hit, direction_back, &point);
    side->normal = point.ng;
    side->position = ty_hit_leave(&hit, point.ng);
    for (int c = 0; c < 3; ++c) {
        side->albedo[c] = ty_minf(point.albedo[c], 1);
        side->emission[c] = point.light < 0 ? point.emission[c] : 0;
    }
}

static void trace_rays(void* user, int64_t direction, int32_t worker) {
    (void)worker;
    const boundary_job* in = user;
    for (int32_t ray = 0; ray < RAYS; ++ray)
        trace_ray(in, (int32_t)direction, ray, &in->surfaces.sides[direction * RAYS + ray]);
}

/* Lights the surfaces by all sources but those whose reflection VPLs stand for. */
static void light_surfaces(const boundary_job* in) {
    const ty_dom_job* job = in->job;
    const ty_light_set* lights = &ty_scene_get_view(job->scene)->lights;
    for (int32_t i = 0; i < job->sources.count; ++i) {
        const ty_discrete_light* source = &job->sources.items[i];
        const int32_t kind = lights->lights[source->light].kind;
        const bool has_vpls = kind == TY_KIND_DIRECTIONAL || kind == TY_KIND_POINT || kind == TY_KIND_SPOT;
        if (source->is_virtual == 0 && has_vpls) continue;
        ty_boundary_irradiance_add(job->scene, &in->surfaces, job->coarse, job->coarse->extinction, source, 1,
                                   in->irradiance, NULL);
    }
}

/* Radiance towards the box, in units of a channel. */
static float radiance_of(const boundary_job* in, int32_t channel, size_t ray) {
    const ty_boundary_side* side = &in->surfaces.sides[ray];
    const ty_dom* light = in->job->light;
    float radiance[3];
    for (int c = 0; c < 3; ++c) radiance[c] = side->albedo[c] / TY_PI * in->irradiance[c][ray] + side->emission[c];
    if (!light->shared) return radiance[channel];
    return (radiance[0] + radiance[1] + radiance[2]) / (light->color[0] + light->color[1] + light->color[2]);
}

static ty_result average_radiance(const boundary_job* in) {
    ty_dom_job* job = in->job;
    for (int32_t c = 0; c < ty_dom_channels(job->light); ++c) {
        job->incident_radiance[c] = ty_alloc_array(job->context, TY_ORDINATES_MAX, sizeof(float), true);
        if (job->incident_radiance[c] == NULL) return TY_ERROR_MEMORY;
        for (int32_t d = 0; d < job->set->count; ++d)
            for (size_t ray = 0; ray < RAYS; ++ray)
                job->incident_radiance[c][d] += radiance_of(in, c, (size_t)d * RAYS + ray) / RAYS;
    }
    return TY_OK;
}

bool ty_dom_has_outer_surfaces(const ty_dom_job* job) {
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

bool ty_dom_surfaces_are_gray(const ty_dom_job* job) {
    for (size_t i = 0; i < job->scene->surfaces.count; ++i) {
        const ty_surface* surface = &job->scene->surfaces.surfaces[i];
        if (ty_texture_exists(&surface->albedo_texture) || surface->colors != NULL || surface->gloss != NULL)
            return false;
        for (int c = 0; c < 3; ++c)
            if (surface->albedo[c] != surface->albedo[0] || surface->emission[c] != surface->emission[0]) return false;
    }
    return true;
}

ty_result ty_dom_find_incident_radiance(ty_dom_job* job) {
    if (!ty_dom_has_outer_surfaces(job)) return TY_OK;
    const size_t count = (size_t)job->set->count * RAYS;
    boundary_job in = {.job = job, .surfaces = {.context = job->context, .count = (int32_t)count}};
    in.surfaces.sides = ty_alloc_array(job->context, count, sizeof *in.surfaces.sides, false);
    float* irradiance = ty_alloc_array(job->context, 3 * count, sizeof *irradiance, true);
    ty_result result = in.surfaces.sides != NULL && irradiance != NULL ? TY_OK : TY_ERROR_MEMORY;
    for (size_t c = 0; c < 3; ++c) in.irradiance[c] = irradiance + c * count;
    if (result == TY_OK) {
        ty_parallel_for(job->context, job->set->count, trace_rays, &in);
        light_surfaces(&in);
        result = average_radiance(&in);
    }
    ty_free_array(job->context, in.surfaces.sides, count, sizeof *in.surfaces.sides);
    ty_free_array(job->context, irradiance, 3 * count, sizeof *irradiance);
    return result;
}
