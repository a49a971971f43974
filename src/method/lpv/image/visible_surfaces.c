/* Surfaces that the camera sees. */
#include "method/lpv/image/visible_surfaces.h"

#include "scene/surfaces/fetch.h"

static void list_pixels(const ty_lpv_march_state* state, int32_t x, int32_t y, int32_t right, int32_t bottom,
                        ty_lpv_tile* tile) {
    tile->count = 0;
    for (int32_t i = 0; i < TY_TILE_PIXELS; ++i) {
        const int32_t block = i / TY_BLOCK_PIXELS, within = i % TY_BLOCK_PIXELS;
        const int32_t px = x + block % (TY_TILE / TY_BLOCK) * TY_BLOCK + within % TY_BLOCK;
        const int32_t py = y + block / (TY_TILE / TY_BLOCK) * TY_BLOCK + within / TY_BLOCK;
        if (px >= right || py >= bottom) continue;
        ty_lpv_pixel* pixel = &tile->pixels[tile->count++];
        pixel->x = px;
        pixel->y = py;
        pixel->direction = ty_camera_direction(&state->camera, (float)px + state->dx, (float)py + state->dy);
        pixel->distance = INFINITY;
        for (int c = 0; c < 3; ++c) pixel->radiance[c] = 0.0f;
    }
}

/* ---- traced ---- */

static void add_environment(const ty_lpv_march_state* state, ty_lpv_pixel* pixel) {
    const ty_light_set* lights = &state->scene->lights;
    for (int32_t i = 0; i < lights->distant_count; ++i) {
        const ty_light_view* light = &lights->lights[lights->distant[i]];
        float radiance[3];
        if (light->kind != TY_KIND_ENVIRONMENT) continue;
        ty_environment_radiance(&light->environment, pixel->direction, radiance);
        for (int c = 0; c < 3; ++c) pixel->radiance[c] += radiance[c];
    }
}

static void set_surface(const ty_lpv_march_state* state, const ty_hit* hit, ty_lpv_pixel* pixel) {
    ty_surface_point point;
    ty_surface_evaluate_fetched(&state->scene->surfaces[hit->surface], hit, pixel->direction, &point);
    pixel->distance = hit->distance;
    pixel->position = hit->position;
    pixel->normal = point.ns;
    pixel->facing = point.ng;
    pixel->margin = hit->margin;
    for (int c = 0; c < 3; ++c) {
        pixel->albedo[c] = point.albedo[c];
        pixel->radiance[c] = point.emission[c];
    }
}

/* Packets that are traced before their hits are shaded, so that surface data can be prefetched. */
enum { PACKETS = 8 };

typedef struct packet_group {
    int32_t first, packets; /* first pixel of the tile; number of packets */
    ty_hit hits[PACKETS][TY_PACKET];
} packet_group;

static int32_t packet_size(const ty_lpv_tile* tile, const packet_group* group, int32_t packet) {
    const int32_t left = tile->count - group->first - packet * TY_PACKET;
    return left < TY_PACKET ? left : TY_PACKET;
}

static void trace_packet(const ty_lpv_march_state* state, const ty_lpv_pixel* pixels, int32_t count, ty_hit* hits) {
    const ty_vec origin = state->camera.origin;
    ty_ray rays[TY_PACKET];
    for (int32_t i = 0; i < count; ++i) {
        const ty_vec direction = pixels[i].direction;
        rays[i] = (ty_ray){{origin.x, origin.y, origin.z}, {direction.x, direction.y, direction.z}, INFINITY};
    }
    ty_accel_intersect_packet(state->scene->mesh, rays, count, hits);
}

static void shade_hits(const ty_lpv_march_state* state, const ty_hit* hits, int32_t count, ty_lpv_pixel* pixels) {
    for (int32_t i = 0; i < count; ++i) {
        if (hits[i].surface >= 0)
            set_surface(state, &hits[i], &pixels[i]);
        else
            add_environment(state, &pixels[i]);
    }
}

static void trace_group(ty_lpv_march_state* state, ty_lpv_tile* tile, packet_group* group) {
    const ty_surface* surfaces = state->scene->surfaces;
    const int64_t begun = ty_lpv_clock_now();
    for (int32_t p = 0; p < group->packets; ++p)
        trace_packet(state, &tile->pixels[group->first + p * TY_PACKET], packet_size(tile, group, p), group->hits[p]);
    ty_lpv_clock_add(&state->clocks, TY_CLOCK_RAYS, begun);
    ty_surfaces_fetch(surfaces, group->hits[0], packet_size(tile, group, 0));
    for (int32_t p = 0; p < group->packets; ++p) {
        if (p + 1 < group->packets) ty_surfaces_fetch(surfaces, group->hits[p + 1], packet_size(tile, group, p + 1));
        shade_hits(state, group->hits[p], packet_size(tile, group, p), &tile->pixels[group->first + p * TY_PACKET]);
    }
}

static void trace(ty_lpv_march_state* state, ty_lpv_tile* tile) {
    packet_group group;
    for (group.first = 0; group.first < tile->count; group.first += PACKETS * TY_PACKET) {
        const int32_t packets = (tile->count - group.first + TY_PACKET - 1) / TY_PACKET;
        group.packets = packets < PACKETS ? packets : PACKETS;
        trace_group(state, tile, &group);
    }
    atomic_fetch_add(&state->rays, tile->count);
}

/* ---- handed in by a caller ---- */

static float number_in(float value, float max) {
    return value >= 0.0f ? ty_minf(value, max) : 0.0f;
}

/* Callers' values are unchecked. Distances above this, m, whose squares overflow, count as no surface. */
static const float farthest = 1e15f;

static void set_view_surface(const ty_lpv_march_state* state, const ty_lpv_view_def* view, ty_lpv_pixel* pixel) {
    const size_t at = (size_t)pixel->y * (size_t)state->width + (size_t)pixel->x;
    const float distance = view->distance[at];
    if (!(distance >= 0.0f && distance < farthest)) {
        add_environment(state, pixel);
        return;
    }
    const ty_vec normal = ty_vec_load(view->normal + 3 * at);
    const float square = ty_dot(normal, normal);
    const bool exists = square > 1e-12f && square < TY_FLOAT_MAX;
    pixel->distance = distance;
    pixel->position = ty_mad(state->camera.origin, pixel->direction, distance);
    pixel->normal = exists ? ty_scale(normal, 1.0f / sqrtf(square)) : ty_scale(pixel->direction, -1.0f);
    pixel->facing = pixel->normal;
    pixel->margin = 2e-5f * (distance + fabsf(pixel->position.x) + fabsf(pixel->position.y) + fabsf(pixel->position.z));
    for (size_t c = 0; c < 3; ++c) {
        pixel->albedo[c] = number_in(view->albedo[3 * at + c], 1.0f);
        if (view->emission != NULL) pixel->radiance[c] = number_in(view->emission[3 * at + c], TY_FLOAT_MAX);
    }
}

/* ---- channels ---- */

static void store(const ty_lpv_march_state* state, const ty_lpv_pixel* pixel) {
    const size_t at = (size_t)pixel->y * (size_t)state->width + (size_t)pixel->x;
    state->distance[ty_lpv_band_index(state, pixel->x, pixel->y)] = pixel->distance;
    if (isinf(pixel->distance)) return;
    if (state->planes.depth[0] != NULL) state->planes.depth[0][at] += pixel->distance;
    if (state->planes.hits != NULL) state->planes.hits[at] += 1.0f;
    const float normal[3] = {pixel->normal.x, pixel->normal.y, pixel->normal.z};
    for (int c = 0; c < 3 && state->planes.normal[0] != NULL; ++c) state->planes.normal[c][at] += normal[c];
}

void ty_lpv_find_visible_surfaces(ty_lpv_march_state* state, int32_t x, int32_t y, int32_t right, int32_t bottom,
                                  ty_lpv_tile* tile) {
    const ty_lpv_view_def* view = state->job->def->view;
    list_pixels(state, x, y, right, bottom, tile);
    if (view == NULL && state->scene->mesh != NULL) {
        trace(state, tile);
    } else {
        for (int32_t i = 0; i < tile->count; ++i) {
            if (view != NULL)
                set_view_surface(state, view, &tile->pixels[i]);
            else
                add_environment(state, &tile->pixels[i]);
        }
    }
    for (int32_t i = 0; i < tile->count; ++i) store(state, &tile->pixels[i]);
}
