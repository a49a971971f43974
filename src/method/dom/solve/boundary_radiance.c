/* The boundary source of surfaces outside of the box, such as a floor under a cloud, whose irradiance is in a cache:
 * the radiance along each direction of the quadrature through each patch of the box's faces, by a ray. */
#include "base/constants.h"
#include "base/context.h"
#include "method/dom/solve/solve.h"
#include "scene/scene.h"

#include <math.h>

/* Patches along each axis at most. */
enum { PATCHES = 24 };

typedef struct boundary_job {
    const ty_dom_job* job;
    ty_boundary_radiance boundary; /* its patches */
    size_t first[3];               /* the first number of each axis */
    ty_reflected_light reflected;  /* of the cache's points */
    float* const* out;
} boundary_job;

static ty_boundary_radiance patches_of(const ty_dom_job* job) {
    ty_boundary_radiance boundary = {.across = {NULL}};
    for (int a = 0; a < 3; ++a)
        boundary.patches[a] = job->coarse->box.size[a] < PATCHES ? job->coarse->box.size[a] : PATCHES;
    return boundary;
}

static size_t plane_floats(const ty_dom_job* job, int axis) {
    const ty_boundary_radiance boundary = patches_of(job);
    return (size_t)ty_boundary_patch_count(&boundary, axis) * (size_t)job->set->count;
}

size_t ty_dom_incident_floats(const ty_dom_job* job) {
    return plane_floats(job, 0) + plane_floats(job, 1) + plane_floats(job, 2);
}

ty_boundary_radiance ty_dom_boundary_radiance(const ty_dom_job* job, const float* radiance) {
    ty_boundary_radiance boundary = patches_of(job);
    for (int a = 0; a < 3 && radiance != NULL; ++a) {
        boundary.across[a] = radiance;
        radiance += plane_floats(job, a);
    }
    return boundary;
}

/* The center of a patch of the face that a direction enters through, with a number of patches along an axis. */
static void patch_center(const boundary_job* in, int axis, int32_t patch, int32_t direction, float at[3]) {
    const ty_grid_box* box = &in->job->coarse->box;
    const int low = axis == 0 ? 1 : 0, high = axis == 2 ? 1 : 2;
    const int32_t columns = in->boundary.patches[low], rows = in->boundary.patches[high];
    const double u = (patch % columns + 0.5) / columns, v = (patch / columns + 0.5) / rows;
    at[axis] = (float)(in->job->set->direction[axis][direction] > 0 ? box->lower[axis] : box->upper[axis]);
    at[low] = (float)(box->lower[low] + (box->upper[low] - box->lower[low]) * u);
    at[high] = (float)(box->lower[high] + (box->upper[high] - box->lower[high]) * v);
}

/* Radiance of the surface that a ray hits when followed back from its entry; 0 if it misses or hits a boundary face. */
static void trace(const boundary_job* in, const float from[3], int32_t direction, float radiance[3]) {
    const ty_scene_view* view = &in->job->scene->view;
    const ty_angular_quadrature* set = in->job->set;
    const ty_vec back =
        ty_vec_make(-set->direction[0][direction], -set->direction[1][direction], -set->direction[2][direction]);
    ty_surface_point point;
    ty_hit hit;
    float irradiance[3];
    for (int c = 0; c < 3; ++c) radiance[c] = 0;
    if (!ty_accel_intersect(view->mesh, ty_vec_load(from), back, TY_FLOAT_MAX, &hit)) return;
    if (ty_dom_is_within_boundary(in->job, hit.position)) return;
    ty_surface_evaluate(&view->surfaces[hit.surface], &hit, back, &point);
    ty_irradiance_cache_at(in->job->light->cache, in->reflected, ty_hit_leave(&hit, point.ng), point.ng, irradiance);
    for (int c = 0; c < 3; ++c) {
        radiance[c] = ty_minf(point.albedo[c], 1) * (1 / TY_PI) * irradiance[c];
        if (in->reflected == TY_REFLECTED_LAMPS && point.light < 0) radiance[c] += point.emission[c];
    }
}

static void fill_patch(void* user, int64_t index, int32_t worker) {
    (void)worker;
    const boundary_job* in = user;
    const ty_dom* light = in->job->light;
    const float sum = light->color[0] + light->color[1] + light->color[2];
    int axis = 0;
    for (; axis < 2 && index >= ty_boundary_patch_count(&in->boundary, axis); ++axis)
        index -= ty_boundary_patch_count(&in->boundary, axis);
    for (int32_t d = 0; d < in->job->set->count; ++d) {
        const size_t at = in->first[axis] + (size_t)index * (size_t)in->job->set->count + (size_t)d;
        float from[3], radiance[3];
        patch_center(in, axis, (int32_t)index, d, from);
        trace(in, from, d, radiance);
        for (int32_t c = 0; c < ty_dom_channels(light); ++c)
            in->out[c][at] = light->shared ? (radiance[0] + radiance[1] + radiance[2]) / sum : radiance[c];
    }
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

/* Radiance towards the box, in units of the channels. */
static ty_result find_radiance(const ty_dom_job* job, ty_reflected_light reflected, float* out[3]) {
    boundary_job in = {.job = job, .boundary = patches_of(job), .reflected = reflected, .out = out};
    int64_t patches = 0;
    for (int a = 0; a < 3; ++a) {
        if (a > 0) in.first[a] = in.first[a - 1] + plane_floats(job, a - 1);
        patches += ty_boundary_patch_count(&in.boundary, a);
    }
    for (int32_t c = 0; c < ty_dom_channels(job->light); ++c) {
        out[c] = ty_alloc_array(job->context, ty_dom_incident_floats(job), sizeof(float), false);
        if (out[c] == NULL) return TY_ERROR_MEMORY;
    }
    ty_parallel_for(job->context, patches, fill_patch, &in);
    return TY_OK;
}

ty_result ty_dom_find_incident_radiance(ty_dom_job* job) {
    ty_irradiance_cache** cache = &job->light->cache;
    ty_result result = ty_irradiance_cache_create(job->scene, job->coarse, cache);
    if (result != TY_OK || *cache == NULL) return result;
    result = ty_irradiance_cache_light(*cache, job->scene, job->coarse, job->sources.items, job->sources.count);
    return result == TY_OK ? find_radiance(job, TY_REFLECTED_LAMPS, job->incident_radiance) : result;
}

ty_result ty_dom_find_returned_radiance(const ty_dom_job* job, float* out[3]) {
    return find_radiance(job, TY_REFLECTED_MEDIA, out);
}
