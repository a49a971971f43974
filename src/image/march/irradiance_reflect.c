/* Light of a cache's points: of the scene's lights, of one another, and what reaches the box. */
#include "base/context.h"
#include "image/march/irradiance_points.h"
#include "scene/scene.h"

#include <math.h>
#include <string.h>

/* Reflections at most, and the largest irradiance of the last, relative to the largest of all. */
enum { REFLECTIONS = 64 };
static const float NEGLIGIBLE = 1e-3f;

/* ---- one another ---- */

/* Irradiance of what rays find reflected: E = sum of weight times E of their points (radiance albedo E / pi, and pi
 * over the number of rays of the density of a cosine). */
static float reflect_once(const ty_irradiance_cache* cache, const float* from, float* to) {
    float largest = 0;
    memset(to, 0, sizeof *to * 3 * (size_t)cache->view.count);
    for (int32_t i = 0; i < cache->view.count; ++i) {
        const ty_irradiance_ray* rays = cache->rays + (size_t)i * TY_IRRADIANCE_RAYS;
        if (cache->points[i].inside != 0) continue;
        for (int32_t r = 0; r < TY_IRRADIANCE_RAYS; ++r) {
            const int32_t point = rays[r].point;
            if (point < 0) continue;
            for (int c = 0; c < 3; ++c) to[3 * i + c] += rays[r].weight[c] * from[3 * point + c];
        }
        for (int c = 0; c < 3; ++c) largest = fmaxf(largest, to[3 * i + c]);
    }
    return largest;
}

ty_result ty_irradiance_reflect(const ty_irradiance_cache* cache, float* irradiance) {
    const size_t count = 3 * (size_t)cache->view.count;
    float largest = 0;
    float* planes = ty_alloc_array(cache->context, 2 * count, sizeof *planes, false);
    if (planes == NULL) return TY_ERROR_MEMORY;
    float *from = planes, *to = planes + count;
    memcpy(from, irradiance, sizeof *from * count);
    for (size_t i = 0; i < count; ++i) largest = fmaxf(largest, irradiance[i]);
    for (int i = 0; i < REFLECTIONS; ++i) {
        const float last = reflect_once(cache, from, to);
        for (size_t k = 0; k < count; ++k) irradiance[k] += to[k];
        float* swapped = from;
        from = to;
        to = swapped;
        if (!(last > NEGLIGIBLE * largest)) break;
    }
    ty_free_array(cache->context, planes, 2 * count, sizeof *planes);
    return TY_OK;
}

/* ---- lamps ---- */

/* Means over the places of each point. */
static void average(const ty_irradiance_cache* cache, float* const planes[3], const int32_t* first, float* out) {
    for (int32_t i = 0; i < cache->view.count; ++i)
        for (int32_t k = 0; k < cache->points[i].places; ++k)
            for (int c = 0; c < 3; ++c) out[3 * i + c] += planes[c][first[i] + k] / (float)cache->points[i].places;
}

typedef struct places {
    ty_boundary_faces faces;
    int32_t* first; /* of each point */
    float* planes;  /* irradiance, 3 of them */
} places;

static ty_result list_places(const ty_irradiance_cache* cache, places* out) {
    const size_t capacity = (size_t)cache->view.count * TY_IRRADIANCE_PLACES;
    *out = (places){.faces = {.context = cache->context}};
    out->faces.sides = ty_alloc_array(cache->context, capacity, sizeof *out->faces.sides, false);
    out->first = ty_alloc_array(cache->context, (size_t)cache->view.count, sizeof *out->first, false);
    out->planes = ty_alloc_array(cache->context, 3 * capacity, sizeof *out->planes, true);
    if (out->faces.sides == NULL || out->first == NULL || out->planes == NULL) return TY_ERROR_MEMORY;
    for (int32_t i = 0; i < cache->view.count; ++i) {
        out->first[i] = out->faces.count;
        for (int32_t k = 0; k < cache->points[i].places; ++k)
            out->faces.sides[out->faces.count++] = cache->places[(size_t)i * TY_IRRADIANCE_PLACES + (size_t)k];
    }
    return TY_OK;
}

static void free_places(const ty_irradiance_cache* cache, places* list) {
    const size_t capacity = (size_t)cache->view.count * TY_IRRADIANCE_PLACES;
    ty_free_array(cache->context, list->faces.sides, capacity, sizeof *list->faces.sides);
    ty_free_array(cache->context, list->first, (size_t)cache->view.count, sizeof *list->first);
    ty_free_array(cache->context, list->planes, 3 * capacity, sizeof *list->planes);
}

/* Adds what surfaces emit that are no lights. */
static void add_emission(const ty_irradiance_cache* cache, float* irradiance) {
    for (int32_t i = 0; i < cache->view.count; ++i) {
        const ty_irradiance_ray* rays = cache->rays + (size_t)i * TY_IRRADIANCE_RAYS;
        for (int32_t r = 0; r < TY_IRRADIANCE_RAYS && cache->points[i].inside == 0; ++r)
            for (int c = 0; c < 3; ++c) irradiance[3 * i + c] += rays[r].emitted[c];
    }
}

ty_result ty_irradiance_cache_light(ty_irradiance_cache* cache, const ty_scene* scene, const ty_grid_medium* medium,
                                    const ty_discrete_light* sources, int32_t count) {
    const size_t capacity = (size_t)cache->view.count * TY_IRRADIANCE_PLACES;
    places list;
    float* irradiance = cache->irradiance[TY_REFLECTED_LAMPS];
    ty_result result = list_places(cache, &list);
    if (result == TY_OK) {
        float* const planes[3] = {list.planes, list.planes + capacity, list.planes + 2 * capacity};
        ty_boundary_irradiance_add(scene, &list.faces, medium, medium->extinction, sources, count, planes, NULL);
        average(cache, planes, list.first, irradiance);
        add_emission(cache, irradiance);
        result = ty_irradiance_reflect(cache, irradiance);
    }
    free_places(cache, &list);
    return result;
}

/* ---- the box ---- */

void ty_irradiance_cache_add_more(ty_irradiance_cache* cache, double factor) {
    for (int32_t i = 0; i < 3 * cache->view.count; ++i)
        cache->irradiance[TY_REFLECTED_MEDIA][i] += (float)factor * cache->irradiance[TY_REFLECTED_MORE][i];
}

void ty_irradiance_cache_faces(const ty_irradiance_cache* cache, ty_reflected_light light,
                               float out[6][TY_IRRADIANCE_FACE_PATCHES][3]) {
    memset(out, 0, sizeof(float) * 6 * TY_IRRADIANCE_FACE_PATCHES * 3);
    for (int face = 0; face < 6; ++face) {
        const ty_irradiance_ray* rays = ty_irradiance_face_rays(cache, face);
        for (int32_t i = 0; i < TY_IRRADIANCE_FACE_PATCHES * TY_IRRADIANCE_PATCH_RAYS; ++i)
            for (int c = 0; c < 3 && rays[i].point >= 0; ++c)
                out[face][i / TY_IRRADIANCE_PATCH_RAYS][c] +=
                    rays[i].weight[c] * cache->irradiance[light][3 * rays[i].point + c] +
                    (light == TY_REFLECTED_LAMPS ? rays[i].emitted[c] : 0);
    }
}

double ty_irradiance_cache_power(const ty_irradiance_cache* cache, ty_reflected_light light) {
    float faces[6][TY_IRRADIANCE_FACE_PATCHES][3];
    double power = 0;
    ty_irradiance_cache_faces(cache, light, faces);
    for (int face = 0; face < 6; ++face)
        for (int patch = 0; patch < TY_IRRADIANCE_FACE_PATCHES; ++patch)
            for (int c = 0; c < 3; ++c)
                power += (double)faces[face][patch][c] * cache->area[face / 2] / TY_IRRADIANCE_FACE_PATCHES;
    return power;
}

void ty_irradiance_cache_at(const ty_irradiance_cache* cache, ty_reflected_light light, ty_vec position, ty_vec normal,
                            float irradiance[3]) {
    const int32_t point = ty_irradiance_find(&cache->view, position, normal);
    for (int c = 0; c < 3; ++c) irradiance[c] = point >= 0 ? cache->irradiance[light][3 * point + c] : 0;
}
