/* The boundary source of surfaces outside of the box, such as a floor under a cloud, whose irradiance is in a cache.
 * The incident radiance along each direction of the quadrature and through each face is the mean over a few rays. */
#include "base/context.h"
#include "method/dom/solve/solve.h"
#include "scene/scene.h"

#include <math.h>
#include <string.h>

/* Rays per direction through each of the three faces that it enters the box through, and through all of them. */
enum { FACE_RAYS = 8, RAYS = 3 * FACE_RAYS };

/* Generators of the R2 low-discrepancy sequence: powers of the inverse of the real root of x^3 = x + 1. */
static const double step_u = 0.7548776662466927, step_v = 0.5698402909980532;

typedef struct boundary_job {
    ty_dom_job* job;
    ty_boundary_faces surfaces; /* surfaces that rays hit, as boundary sides; those of direction d start at d RAYS */
    float* irradiance[3];
    ty_reflected_light reflected; /* of the cache's points */
} boundary_job;

/* The point at which one of a direction's rays enters the box. */
static void ray_entry(const ty_dom_job* job, int32_t direction, int32_t ray, double at[3]) {
    const ty_grid_box* box = &job->coarse->box;
    const int axis = ray / FACE_RAYS, b = (axis + 1) % 3, c = (axis + 2) % 3;
    const double u = (ray + 1) * step_u, v = (ray + 1) * step_v;
    at[axis] = job->set->direction[axis][direction] > 0 ? box->lower[axis] : box->upper[axis];
    at[b] = box->lower[b] + (box->upper[b] - box->lower[b]) * (u - floor(u));
    at[c] = box->lower[c] + (box->upper[c] - box->lower[c]) * (v - floor(v));
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

/* The irradiance of the surfaces, by the cache's points. */
static void find_irradiance(const boundary_job* in) {
    const ty_irradiance_cache* cache = in->job->light->cache;
    for (size_t ray = 0; ray < (size_t)in->surfaces.count; ++ray) {
        const ty_boundary_side* side = &in->surfaces.sides[ray];
        float irradiance[3];
        ty_irradiance_cache_at(cache, in->reflected, side->position, side->normal, irradiance);
        for (int c = 0; c < 3; ++c) in->irradiance[c][ray] = irradiance[c];
    }
}

/* Radiance towards the box, in units of a channel. */
static float radiance_of(const boundary_job* in, int32_t channel, size_t ray) {
    const ty_boundary_side* side = &in->surfaces.sides[ray];
    const ty_dom* light = in->job->light;
    float radiance[3];
    for (int c = 0; c < 3; ++c)
        radiance[c] = side->albedo[c] / TY_PI * in->irradiance[c][ray] +
                      (in->reflected == TY_REFLECTED_LAMPS ? side->emission[c] : 0);
    if (!light->shared) return radiance[channel];
    return (radiance[0] + radiance[1] + radiance[2]) / (light->color[0] + light->color[1] + light->color[2]);
}

static ty_result average_radiance(const boundary_job* in, float* out[3]) {
    const ty_dom_job* job = in->job;
    for (int32_t c = 0; c < ty_dom_channels(job->light); ++c) {
        out[c] = ty_alloc_array(job->context, 3 * TY_ORDINATES_MAX, sizeof(float), true);
        if (out[c] == NULL) return TY_ERROR_MEMORY;
        for (int32_t d = 0; d < job->set->count; ++d)
            for (int32_t ray = 0; ray < RAYS; ++ray)
                out[c][ray / FACE_RAYS * TY_ORDINATES_MAX + d] +=
                    radiance_of(in, c, (size_t)d * RAYS + (size_t)ray) / FACE_RAYS;
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

static ty_result find_radiance(ty_dom_job* job, ty_reflected_light reflected, float* out[3]) {
    const size_t count = (size_t)job->set->count * RAYS;
    boundary_job in = {
        .job = job, .surfaces = {.context = job->context, .count = (int32_t)count}, .reflected = reflected};
    in.surfaces.sides = ty_alloc_array(job->context, count, sizeof *in.surfaces.sides, false);
    float* irradiance = ty_alloc_array(job->context, 3 * count, sizeof *irradiance, true);
    ty_result result = in.surfaces.sides != NULL && irradiance != NULL ? TY_OK : TY_ERROR_MEMORY;
    for (size_t c = 0; c < 3; ++c) in.irradiance[c] = irradiance + c * count;
    if (result == TY_OK) {
        ty_parallel_for(job->context, job->set->count, trace_rays, &in);
        find_irradiance(&in);
        result = average_radiance(&in, out);
    }
    ty_free_array(job->context, in.surfaces.sides, count, sizeof *in.surfaces.sides);
    ty_free_array(job->context, irradiance, 3 * count, sizeof *irradiance);
    return result;
}

ty_result ty_dom_find_incident_radiance(ty_dom_job* job) {
    ty_irradiance_cache** cache = &job->light->cache;
    ty_result result = ty_irradiance_cache_create(job->scene, job->coarse, cache);
    if (result != TY_OK || *cache == NULL) return result;
    result = ty_irradiance_cache_light(*cache, job->scene, job->coarse, job->sources.items, job->sources.count);
    return result == TY_OK ? find_radiance(job, TY_REFLECTED_LAMPS, job->incident_radiance) : result;
}

ty_result ty_dom_find_returned_radiance(ty_dom_job* job, float* out[3]) {
    return find_radiance(job, TY_REFLECTED_MEDIA, out);
}
