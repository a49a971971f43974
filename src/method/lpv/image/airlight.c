/* Airlight: its precomputed data and entry points. */
#include "method/lpv/image/airlight.h"

#include "base/context.h"
#include "method/lpv/image/airlight_ray.h"
#include "direct/media/transmittance.k.h"
#include "direct/uncollided/uncollided.h"

/* ---- media ---- */

/* True if a medium is homogeneous within its bounds. */
static bool is_homogeneous(const ty_medium_view* medium) {
    return medium->has_grid == 0 && medium->albedo_fields == 0 && medium->has_g_field == 0;
}

static void classify_media(ty_airlight* airlight) {
    airlight->channels = 1;
    for (int32_t m = 0; m < airlight->scene->medium_count; ++m) {
        const ty_medium_view* medium = &airlight->scene->media[m];
        if (!is_homogeneous(medium)) airlight->on_cells = 1;
        if (medium->gray == 0 || airlight->light_media[m].gray == 0) airlight->channels = 3;
        if (medium->sigma_t_max > 0) airlight->collide |= (uint64_t)1 << m;
    }
}

static bool is_within(const ty_medium_view* medium, ty_vec point) {
    const ty_vec p = ty_map_point(medium->to_bounds, point);
    if (medium->bounds == TY_BOUNDED_SPHERE) return ty_dot(p, p) < 1.0f;
    return medium->bounds == TY_BOUNDED_BOX && fabsf(p.x) < 1.0f && fabsf(p.y) < 1.0f && fabsf(p.z) < 1.0f;
}

static bool is_within_all(const ty_airlight* airlight, ty_vec point) {
    for (int32_t m = 0; m < airlight->scene->medium_count; ++m)
        if ((airlight->collide >> m & 1) != 0 && !is_within(&airlight->scene->media[m], point)) return false;
    return true;
}

/* ---- lights ---- */

static ty_result find_planes(const ty_airlight* airlight, ty_airlight_source* light) {
    const ty_grid_medium* medium = airlight->light_medium;
    const ty_discrete_light source = {.kind = light->light->kind == TY_KIND_DIRECTIONAL ? TY_DISCRETE_DIRECTIONAL
                                                                                        : TY_DISCRETE_POINT,
                                      .direction = light->light->direction,
                                      .position = light->light->position,
                                      .is_point = 1};
    for (int32_t c = 0; c < medium->planes; ++c) {
        light->planes[c] = ty_alloc_array(airlight->context, medium->cells, sizeof *light->planes[c], true);
        if (light->planes[c] == NULL) return TY_ERROR_MEMORY;
    }
    return ty_uncollided_in_media(medium, &source, light->planes);
}

static ty_result find_light(const ty_airlight* airlight, const ty_shadow_hierarchy* map, ty_airlight_source* light) {
    light->map = map;
    light->light = &map->light;
    if (airlight->on_cells != 0) return find_planes(airlight, light);
    light->inside = light->light->kind != TY_KIND_DIRECTIONAL && is_within_all(airlight, light->light->position);
    return TY_OK;
}

ty_result ty_airlight_create(const ty_scene* scene, const ty_airlight_def* def, ty_airlight** out) {
    const ty_scene_view* view = ty_scene_get_view(scene);
    if (view == NULL) return TY_ERROR_ARGUMENT;
    if (def->count < 0 || def->count > TY_AIRLIGHT_SOURCES_MAX)
        return ty_fail(scene->context, TY_ERROR_ARGUMENT, "airlight: %d lights are not 0..%d", def->count,
                       TY_AIRLIGHT_SOURCES_MAX);
    ty_airlight* airlight = ty_alloc_array(scene->context, 1, sizeof *airlight, true);
    if (airlight == NULL) return TY_ERROR_MEMORY;
    airlight->context = scene->context;
    airlight->scene = view;
    airlight->medium = airlight->light_medium = def->medium;
    airlight->light_media = view->media;
    if (def->reduced != NULL && def->reduced->medium != NULL && def->reduced->view_count == view->medium_count) {
        airlight->light_medium = def->reduced->medium;
        airlight->light_media = def->reduced->views;
    }
    airlight->count = def->count;
    classify_media(airlight);
    airlight->lights = ty_alloc_array(scene->context, (size_t)def->count, sizeof *airlight->lights, true);
    ty_result result = airlight->lights != NULL ? TY_OK : TY_ERROR_MEMORY;
    for (int32_t i = 0; i < def->count && result == TY_OK; ++i)
        result = find_light(airlight, def->maps[i], &airlight->lights[i]);
    if (result != TY_OK) {
        ty_airlight_destroy(airlight);
        return result;
    }
    *out = airlight;
    return TY_OK;
}

void ty_airlight_destroy(ty_airlight* airlight) {
    if (airlight == NULL) return;
    for (int32_t i = 0; airlight->lights != NULL && i < airlight->count; ++i)
        for (int c = 0; c < 3; ++c)
            ty_free_array(airlight->context, airlight->lights[i].planes[c], airlight->medium->cells, sizeof(float));
    ty_free_array(airlight->context, airlight->lights, (size_t)airlight->count, sizeof *airlight->lights);
    ty_free_array(airlight->context, airlight, 1, sizeof *airlight);
}

/* ---- queries ---- */

/* At most TY_SHADOW_RAYS_MAX rays. */
static void add_rays(const ty_airlight* airlight, ty_vec origin, const ty_eye_ray* rays, int32_t count,
                     ty_airlight_sum* sums) {
    for (int32_t i = 0; i < count; ++i) sums[i] = (ty_airlight_sum){.transmittance = {1, 1, 1}};
    if (airlight->on_cells == 0) {
        ty_airlight_homogeneous(airlight, origin, rays, count, sums);
        return;
    }
    for (int32_t i = 0; i < count; ++i)
        ty_airlight_heterogeneous(airlight, origin, rays[i].direction, rays[i].far, rays[i].offset, &sums[i]);
}

void ty_airlight_rays(const ty_airlight* airlight, ty_vec origin, const ty_eye_ray* rays, int32_t count,
                      float (*radiance)[3], float (*transmittance)[3]) {
    ty_airlight_sum sums[TY_SHADOW_RAYS_MAX];
    for (int32_t first = 0; first < count; first += TY_SHADOW_RAYS_MAX) {
        const int32_t some = count - first < TY_SHADOW_RAYS_MAX ? count - first : TY_SHADOW_RAYS_MAX;
        add_rays(airlight, origin, rays + first, some, sums);
        for (int32_t i = 0; i < some; ++i) {
            memcpy(radiance[first + i], sums[i].radiance, sizeof sums[i].radiance);
            if (transmittance != NULL)
                memcpy(transmittance[first + i], sums[i].transmittance, sizeof sums[i].transmittance);
        }
    }
}

void ty_airlight_ray(const ty_airlight* airlight, ty_vec origin, ty_vec direction, float far, float offset,
                     float radiance[3], float transmittance[3]) {
    const ty_eye_ray ray = {.direction = direction, .far = far, .offset = offset};
    ty_airlight_rays(airlight, origin, &ray, 1, (float(*)[3])radiance, (float(*)[3])transmittance);
}

void ty_airlight_transmittance(const ty_airlight* airlight, int32_t light, ty_vec point, float transmittance[3]) {
    const ty_airlight_source* from = &airlight->lights[light];
    if (airlight->on_cells != 0) {
        ty_airlight_heterogeneous_transmittance(airlight, from, point, transmittance);
        return;
    }
    ty_vec back = ty_scale(from->light->direction, -1.0f);
    float far = TY_FLOAT_MAX;
    if (from->light->kind != TY_KIND_DIRECTIONAL) {
        const ty_vec to = ty_sub(from->light->position, point);
        far = sqrtf(ty_dot(to, to));
        back = ty_scale(to, 1.0f / ty_maxf(far, 1e-30f));
    }
    ty_transmittance(airlight->light_media, airlight->scene->medium_count, point, back, far, NULL, transmittance);
}
