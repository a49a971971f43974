/* Tracing and checking reflective shadow maps. */
#include "direct/shadow/rsm.h"

#include "base/context.h"
#include "direct/shadow/texels.h"
#include "base/check.h"

#include <stdio.h>

enum { SIDE_MAX = 8192 };

/* Texels of a spot light's face whose center is more than this many texels outside the cone are not traced. */
enum { CONE_ROOM = 2 };

/* Cosine of 80 degrees: spot lights with a wider half angle get six faces. */
static const float cos_face_max = 0.17364818f;

static bool has_six_faces(const ty_light_view* light) {
    return light->kind == TY_KIND_POINT || (light->kind == TY_KIND_SPOT && light->cos_outer < cos_face_max);
}

/* ---- projection ---- */

/* Texel coordinate to the face coordinate -1..1. */
static float place_in(const ty_rsm* map, float texel) {
    return 2.0f * texel / (float)map->side - 1.0f;
}

static ty_vec vec_of(const double v[3]) {
    return ty_vec_make((float)v[0], (float)v[1], (float)v[2]);
}

void ty_rsm_ray(const ty_rsm* map, const ty_light_view* light, int32_t face, float x, float y, ty_vec* origin,
                ty_vec* direction) {
    const float s = place_in(map, x), t = place_in(map, y);
    const ty_vec forward = vec_of(map->forward[face]);
    const ty_vec across = ty_mad(ty_scale(vec_of(map->right[face]), s), vec_of(map->up[face]), t);
    const bool parallel = light->kind == TY_KIND_DIRECTIONAL;
    *origin = parallel ? ty_add(vec_of(map->origin), across) : light->position;
    *direction = parallel ? forward : ty_add(forward, across);
}

float ty_rsm_texel_measure(const ty_rsm* map, const ty_light_view* light, int32_t face, int32_t x, int32_t y) {
    const ty_vec right = vec_of(map->right[face]), up = vec_of(map->up[face]);
    const float wide2 = ty_dot(right, right), high2 = ty_dot(up, up);
    const float area = 4.0f * sqrtf(wide2 * high2) / ((float)map->side * (float)map->side);
    if (light->kind == TY_KIND_DIRECTIONAL) return area;
    /* Mean solid angle per area of the face at distance 1, by 2 x 2 Gauss-Legendre quadrature. */
    static const float off = 0.288675135f;
    const float s[2] = {place_in(map, (float)x + 0.5f - off), place_in(map, (float)x + 0.5f + off)};
    const float t[2] = {place_in(map, (float)y + 0.5f - off), place_in(map, (float)y + 0.5f + off)};
    float square[4], sum = 0.0f;
    for (int i = 0; i < 4; ++i) square[i] = 1.0f + wide2 * s[i & 1] * s[i & 1] + high2 * t[i >> 1] * t[i >> 1];
#pragma omp simd reduction(+ : sum)
    for (int i = 0; i < 4; ++i) sum += 1.0f / (square[i] * sqrtf(square[i]));
    return 0.25f * area * sum;
}

/* ---- placement ---- */

/* Two unit vectors orthogonal to a direction. They rotate continuously with it except at straight up, so that the
 * texels of a moving light do not jump. */
static void frame_about(ty_axis up, ty_vec omega, double right[3], double above[3]) {
    const double n[3] = {(double)omega.x, (double)omega.y, (double)omega.z};
    const int w = up == TY_AXIS_Z ? 2 : 1, v = 3 - w;
    const double length = sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
    const double u0 = n[0] / length, v0 = n[v] / length, w0 = n[w] / length;
    const double a = -1 / fmax(1 - w0, 1e-9), b = u0 * v0 * a;
    right[0] = 1 + u0 * u0 * a;
    right[v] = b;
    right[w] = u0;
    above[0] = b;
    above[v] = 1 + v0 * v0 * a;
    above[w] = v0;
}

/* The six faces of a cube. */
static void place_cube(ty_rsm* map) {
    for (int face = 0; face < 6; ++face) {
        const int a = face / 2;
        map->forward[face][a] = face % 2 == 0 ? 1 : -1;
        map->right[face][(a + 1) % 3] = 1;
        map->up[face][(a + 2) % 3] = 1;
    }
}

static void place_cone(const ty_scene* scene, const ty_light_view* light, ty_rsm* map) {
    const double cosine = (double)light->cos_outer;
    const double tangent = sqrt(fmax(0, (1 - cosine) * (1 + cosine))) / cosine;
    frame_about(scene->up, light->direction, map->right[0], map->up[0]);
    for (int a = 0; a < 3; ++a) {
        map->right[0][a] *= tangent;
        map->up[0][a] *= tangent;
    }
}

/* A face across the box; rays start in front of the box and of all surfaces. */
static void place_parallel(const ty_scene* scene, const ty_rsm_def* def, ty_rsm* map) {
    double *axes[3] = {map->right[0], map->up[0], map->forward[0]}, range[2], surfaces[2], lower[3], upper[3];
    frame_about(scene->up, vec_of(map->forward[0]), map->right[0], map->up[0]);
    ty_scene_surface_extent(scene, lower, upper);
    for (int i = 0; i < 3; ++i) {
        ty_texels_extent(vec_of(axes[i]), def->lower, def->upper, range);
        double at = 0.5 * (range[0] + range[1]);
        if (i == 2) {
            ty_texels_extent(vec_of(axes[i]), lower, upper, surfaces);
            const double first = fmin(range[0], surfaces[0]), last = fmax(range[1], surfaces[1]);
            at = first - 1e-3 * (last - first) - 1e-6;
        }
        for (int a = 0; a < 3; ++a) map->origin[a] += axes[i][a] * at;
        for (int a = 0; a < 3 && i < 2; ++a) axes[i][a] *= fmax(0.5 * (range[1] - range[0]), 1e-6);
    }
}

static void place(const ty_scene* scene, const ty_light_view* light, const ty_rsm_def* def, ty_rsm* map) {
    if (map->faces == 6) {
        place_cube(map);
        return;
    }
    const ty_vec omega = ty_normalize(light->direction);
    map->forward[0][0] = (double)omega.x;
    map->forward[0][1] = (double)omega.y;
    map->forward[0][2] = (double)omega.z;
    if (light->kind == TY_KIND_SPOT)
        place_cone(scene, light, map);
    else
        place_parallel(scene, def, map);
}

/* ---- tracing ---- */

/* One face of a map. */
typedef struct map_face {
    ty_vec origin, forward, right, up;
} map_face;

typedef struct map_job {
    const ty_light_view* light;
    ty_rsm* map;
    map_face faces[6];
    float *depth, *normal, *albedo; /* arrays of the map */
} map_job;

static map_face face_of(const map_job* job, int32_t face) {
    const ty_rsm* map = job->map;
    const bool parallel = job->light->kind == TY_KIND_DIRECTIONAL;
    return (map_face){.origin = parallel ? vec_of(map->origin) : job->light->position,
                      .forward = vec_of(map->forward[face]),
                      .right = vec_of(map->right[face]),
                      .up = vec_of(map->up[face])};
}

/* The ray through the center of a texel, as ty_rsm_ray. */
static bool ray_of(const void* user, int32_t index, int32_t column, int32_t line, ty_ray* ray) {
    const map_job* job = user;
    const map_face* face = &job->faces[index];
    const float x = (float)column + 0.5f, y = (float)line + 0.5f;
    if (job->light->kind == TY_KIND_SPOT && job->map->faces == 1) {
        const float half = 0.5f * (float)job->map->side, radius = half + (float)CONE_ROOM;
        if ((x - half) * (x - half) + (y - half) * (y - half) > radius * radius) return false;
    }
    const ty_vec across = ty_mad(ty_scale(face->right, place_in(job->map, x)), face->up, place_in(job->map, y));
    const bool parallel = job->light->kind == TY_KIND_DIRECTIONAL;
    const ty_vec origin = parallel ? ty_add(face->origin, across) : face->origin;
    const ty_vec direction = parallel ? face->forward : ty_normalize(ty_add(face->forward, across));
    *ray = (ty_ray){.origin = {origin.x, origin.y, origin.z},
                    .direction = {direction.x, direction.y, direction.z},
                    .far = INFINITY};
    return true;
}

static void meet(const void* user, size_t texel, const ty_ray* ray, const ty_hit* hit, const ty_surface_point* point) {
    const map_job* job = user;
    const size_t texels = (size_t)job->map->side * (size_t)job->map->side;
    const size_t face = job->map->faces == 1 ? 0 : texel / texels;
    job->depth[texel] = hit->distance * ty_dot(ty_vec_load(ray->direction), job->faces[face].forward);
    if (job->normal == NULL) return;
    job->normal[3 * texel] = point->ns.x;
    job->normal[3 * texel + 1] = point->ns.y;
    job->normal[3 * texel + 2] = point->ns.z;
    for (size_t c = 0; c < 3; ++c) job->albedo[3 * texel + c] = point->albedo[c];
}

static size_t texel_count(const ty_rsm* map) {
    return (size_t)map->faces * (size_t)map->side * (size_t)map->side;
}

/* Texels without a surface. */
static ty_result take_texels(ty_context* context, bool reflective, map_job* job) {
    const size_t count = texel_count(job->map);
    job->map->depth = job->depth = ty_alloc_array(context, count, sizeof(float), false);
    if (job->depth == NULL) return TY_ERROR_MEMORY;
    for (size_t i = 0; i < count; ++i) job->depth[i] = INFINITY;
    if (!reflective) return TY_OK;
    job->map->normal = job->normal = ty_alloc_array(context, 3 * count, sizeof(float), true);
    job->map->albedo = job->albedo = ty_alloc_array(context, 3 * count, sizeof(float), true);
    return job->normal != NULL && job->albedo != NULL ? TY_OK : TY_ERROR_MEMORY;
}

ty_result ty_rsm_trace(const ty_scene* scene, const ty_rsm_def* def, int32_t light, ty_rsm** out,
                       ty_ray_counter* counter) {
    *out = NULL;
    const ty_scene_view* view = ty_scene_get_view(scene);
    if (view == NULL) return TY_ERROR_ARGUMENT;
    ty_result result = ty_check_number(scene->context, "RSM: side", def->side, 1, SIDE_MAX);
    if (result == TY_OK) result = ty_texels_check_light(scene, "RSM", light);
    if (result != TY_OK) return result;
    map_job job = {.light = &view->lights.lights[light]};
    job.map = ty_alloc_array(scene->context, 1, sizeof *job.map, true);
    if (job.map == NULL) return TY_ERROR_MEMORY;
    job.map->side = def->side;
    job.map->faces = has_six_faces(job.light) ? 6 : 1;
    place(scene, job.light, def, job.map);
    for (int32_t face = 0; face < job.map->faces; ++face) job.faces[face] = face_of(&job, face);
    result = take_texels(scene->context, def->reflective, &job);
    if (result != TY_OK) {
        ty_rsm_destroy(scene->context, job.map);
        return result;
    }
    const ty_texels texels = {.scene = scene,
                              .side = def->side,
                              .faces = job.map->faces,
                              .user = &job,
                              .ray = ray_of,
                              .bare = !def->reflective,
                              .meet = meet};
    if (view->mesh != NULL) ty_texels_trace(&texels, counter);
    *out = job.map;
    return TY_OK;
}

void ty_rsm_destroy(ty_context* context, ty_rsm* map) {
    if (map == NULL) return;
    const size_t count = texel_count(map);
    ty_free_array(context, (float*)map->depth, count, sizeof(float));
    ty_free_array(context, (float*)map->normal, 3 * count, sizeof(float));
    ty_free_array(context, (float*)map->albedo, 3 * count, sizeof(float));
    ty_free_array(context, map, 1, sizeof *map);
}

/* ---- maps of callers ---- */

static double dot(const double a[3], const double b[3]) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* True if the axes of a face are orthogonal, forward is unit and the other axes are not degenerate. */
static bool is_frame(const double forward[3], const double right[3], const double up[3]) {
    const double r = sqrt(dot(right, right)), u = sqrt(dot(up, up)), slack = 1e-3;
    return fabs(dot(forward, forward) - 1) < slack && r > 0 && u > 0 && isfinite(r) && isfinite(u) &&
           fabs(dot(forward, right)) < slack * r && fabs(dot(forward, up)) < slack * u &&
           fabs(dot(right, up)) < slack * r * u;
}

/* True if a texel with a surface holds a valid depth, normal and albedo. */
static bool is_texel(const ty_rsm* map, size_t i) {
    if (!(map->depth[i] >= 0)) return false;
    if (isinf(map->depth[i]) || map->normal == NULL) return true;
    const ty_vec normal = ty_vec_load(map->normal + 3 * i);
    if (!(fabsf(ty_dot(normal, normal) - 1.0f) < 0.05f)) return false;
    for (size_t c = 0; c < 3; ++c)
        if (!(map->albedo[3 * i + c] >= 0 && map->albedo[3 * i + c] <= 1)) return false;
    return true;
}

ty_result ty_rsm_check(ty_context* context, const ty_light_view* light, const ty_rsm* map, int32_t index) {
    char name[32];
    snprintf(name, sizeof name, "maps[%d].side", (int)index);
    ty_result result = ty_check_number(context, name, map->side, 1, SIDE_MAX);
    if (result != TY_OK) return result;
    const bool fits = light->kind == TY_KIND_SPOT ? map->faces == 1 || map->faces == 6
                                                  : map->faces == (light->kind == TY_KIND_POINT ? 6 : 1);
    if (!fits)
        return ty_fail(context, TY_ERROR_ARGUMENT,
                       "maps[%d].faces: %d is not what its light has (point: 6; spot: 1 "
                       "or 6; directional: 1)",
                       (int)index, (int)map->faces);
    snprintf(name, sizeof name, "maps[%d].origin", (int)index);
    if (light->kind == TY_KIND_DIRECTIONAL) result = ty_check_point(context, name, map->origin);
    if (result != TY_OK) return result;
    for (int face = 0; face < map->faces; ++face)
        if (!is_frame(map->forward[face], map->right[face], map->up[face]))
            return ty_fail(context, TY_ERROR_ARGUMENT,
                           "maps[%d]: forward[%d] is not a unit vector at right angles to right and up", (int)index,
                           face);
    if (map->depth == NULL || (map->normal == NULL) != (map->albedo == NULL))
        return ty_fail(context, TY_ERROR_ARGUMENT, "maps[%d]: has no depth, or only one of normal and albedo",
                       (int)index);
    for (size_t i = 0; i < texel_count(map); ++i)
        if (!is_texel(map, i))
            return ty_fail(context, TY_ERROR_ARGUMENT,
                           "maps[%d]: texel %zu has a depth below 0, a normal that is not unit or an albedo outside "
                           "[0, 1]",
                           (int)index, i);
    return TY_OK;
}
