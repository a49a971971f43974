/* Direct light and light of the lattices that visible surfaces reflect. */
#include "method/lpv/image/shading.h"

/* Cosine of incidence below which shadow rays replace the shadow map. */
static const float grazing = 0.02f;
/* Depth bias, in texel widths, within which a texel in front of a surface's plane counts as the surface itself: with
 * shadow rays, which decide up to a bias of `touching`, and without. */
static const float own_with_rays = 0.1f, own_without = 1.0f, touching = 6.0f;

/* ---- shadows ---- */

/* Approximate texel width at a distance from the light, m. */
static float texel_width(const ty_shadow_hierarchy* lit, float distance) {
    const ty_rsm* map = lit->map;
    double square[2] = {0, 0};
    for (int a = 0; a < 3; ++a) {
        square[0] += map->right[0][a] * map->right[0][a];
        square[1] += map->up[0][a] * map->up[0][a];
    }
    const float width = 2.0f * (float)sqrt(fmax(square[0], square[1])) / (float)map->side;
    return lit->light.kind == TY_KIND_DIRECTIONAL ? width : width * distance;
}

/* A packet of shadow rays that is traced when full. */
typedef struct shadow_packet {
    int32_t count;
    ty_ray rays[TY_PACKET];
    ty_lpv_pixel* pixels[TY_PACKET];
    float light[TY_PACKET][3]; /* reflected radiance if the ray is unoccluded */
} shadow_packet;

static void trace_shadows(ty_lpv_march_state* state, shadow_packet* packet) {
    bool occluded[TY_PACKET];
    if (packet->count == 0) return;
    const int64_t begun = ty_lpv_clock_now();
    ty_accel_occluded_packet(state->scene->mesh, packet->rays, packet->count, occluded);
    ty_lpv_clock_add(&state->clocks, TY_CLOCK_RAYS, begun);
    for (int32_t i = 0; i < packet->count; ++i)
        for (int c = 0; c < 3 && !occluded[i]; ++c) packet->pixels[i]->radiance[c] += packet->light[i][c];
    atomic_fetch_add(&state->rays, packet->count);
    packet->count = 0;
}

static void queue_shadow_ray(ty_lpv_march_state* state, const ty_light_sample* sample, ty_lpv_pixel* pixel,
                             const float light[3], shadow_packet* packet) {
    const ty_vec from = ty_mad(pixel->position, pixel->facing, pixel->margin), wi = sample->wi;
    const float far = sample->distance < TY_FLOAT_MAX ? sample->distance * 0.9999f : INFINITY;
    packet->rays[packet->count] = (ty_ray){{from.x, from.y, from.z}, {wi.x, wi.y, wi.z}, far};
    packet->pixels[packet->count] = pixel;
    memcpy(packet->light[packet->count], light, sizeof packet->light[0]);
    if (++packet->count == TY_PACKET) trace_shadows(state, packet);
}

/* Visibility of a light from its shadow map; -1: a shadow ray has to decide. */
static float visibility_of(const ty_lpv_march_state* state, const ty_shadow_hierarchy* map, const ty_lpv_pixel* pixel,
                           const ty_light_sample* sample) {
    const bool asks = state->job->def->shadow_rays && state->scene->mesh != NULL;
    if (asks && ty_dot(pixel->facing, sample->wi) < grazing) return -1.0f;
    const float texel = texel_width(map, sample->distance), own = asks ? own_with_rays : own_without;
    bool sure;
    const float fraction = ty_shadow_visibility(map, pixel->position, pixel->facing, own * texel + 2.0f * pixel->margin,
                                                touching * texel, &sure);
    return asks && !sure ? -1.0f : fraction;
}

/* ---- direct light ---- */

/* Reflected radiance of an unshadowed light; false if it is zero. */
static bool reflect_light(const ty_lpv_march_state* state, int32_t index, const ty_light_sample* sample,
                          const ty_lpv_pixel* pixel, float light[3]) {
    const float facing = ty_dot(pixel->normal, sample->wi) * (1.0f / TY_PI);
    if (!(facing > 0.0f) || !(ty_dot(pixel->facing, sample->wi) > 0.0f)) return false;
    float sum = 0.0f;
    for (int c = 0; c < 3; ++c) {
        light[c] = pixel->albedo[c] * facing * sample->radiance[c];
        sum += light[c];
    }
    if (!(sum > 0.0f && sum < TY_FLOAT_MAX)) return false;
    if (!state->has_media || state->job->airlight == NULL) return true;
    float transmittance[3];
    ty_airlight_transmittance(state->job->airlight, index, pixel->position, transmittance);
    for (int c = 0; c < 3; ++c) light[c] *= transmittance[c];
    return true;
}

static void add_light(ty_lpv_march_state* state, int32_t index, ty_lpv_tile* tile) {
    const ty_shadow_hierarchy* map = state->job->shadow_maps[index];
    const ty_light_view* view = &map->light;
    shadow_packet packet = {.count = 0};
    for (int32_t i = 0; i < tile->count; ++i) {
        ty_lpv_pixel* pixel = &tile->pixels[i];
        ty_light_sample sample;
        float light[3];
        if (isinf(pixel->distance) || !ty_light_sample_from(view, pixel->position, 0.5f, 0.5f, &sample)) continue;
        if (!(ty_dot(pixel->normal, sample.wi) > 0.0f)) continue;
        const float fraction = visibility_of(state, map, pixel, &sample);
        if (fraction == 0.0f || !reflect_light(state, index, &sample, pixel, light)) continue;
        if (fraction < 0.0f) {
            queue_shadow_ray(state, &sample, pixel, light, &packet);
            continue;
        }
        for (int c = 0; c < 3; ++c) pixel->radiance[c] += fraction * light[c];
    }
    trace_shadows(state, &packet);
}

/* ---- direct light of lights with extent ---- */

/* Neighbours share direct light if they are this close to one plane, as a fraction of their distance from each other,
 * and the cosine between their normals is at least this. */
static const float within_plane = 0.1f, alike_cosine = 0.95f;

/* The pixels of a tile by their place in it, and the irradiance that each found for itself. */
typedef struct direct_tile {
    const ty_lpv_pixel* pixels[TY_TILE][TY_TILE]; /* NULL: no surface */
    float irradiance[TY_TILE][TY_TILE][3];
} direct_tile;

static void find_direct(ty_lpv_march_state* state, const ty_lpv_tile* tile, direct_tile* direct) {
    const ty_extended_view view = ty_extended_view_of(state->job->scene, state->job->extended, &state->light_points,
                                                      state->job->medium, state->job->reduced);
    const int64_t begun = ty_lpv_clock_now();
    int64_t rays = 0;
    memset(direct->pixels, 0, sizeof direct->pixels);
    for (int32_t i = 0; i < tile->count; ++i) {
        const ty_lpv_pixel* pixel = &tile->pixels[i];
        if (isinf(pixel->distance)) continue;
        const ty_light_receiver receiver = {ty_mad(pixel->position, pixel->facing, pixel->margin), pixel->facing,
                                            pixel->normal};
        const int32_t x = pixel->x % TY_TILE, y = pixel->y % TY_TILE;
        const int32_t place = y % TY_LIGHT_PATTERN_SIDE * TY_LIGHT_PATTERN_SIDE + x % TY_LIGHT_PATTERN_SIDE;
        direct->pixels[y][x] = pixel;
        rays += ty_extended_irradiance(&view, &receiver, place, direct->irradiance[y][x]);
    }
    ty_lpv_clock_add(&state->clocks, TY_CLOCK_RAYS, begun);
    atomic_fetch_add(&state->rays, rays);
}

static bool is_alike(const ty_lpv_pixel* a, const ty_lpv_pixel* b) {
    const ty_vec off = ty_sub(b->position, a->position);
    const float away = fabsf(ty_dot(off, a->facing)), max = within_plane * within_plane * ty_dot(off, off);
    return a == b || (away * away <= max && ty_dot(a->normal, b->normal) >= alike_cosine);
}

/* The first of the four pixels around one, along an axis of the tile. */
static int32_t window_begin(int32_t at) {
    const int32_t first = at - TY_LIGHT_PATTERN_SIDE / 2, last = TY_TILE - TY_LIGHT_PATTERN_SIDE;
    return first < 0 ? 0 : first < last ? first : last;
}

/* Reflects the mean over the pixels around each that see the same surface, which together have all places of the
 * pattern. */
static void add_extended(ty_lpv_march_state* state, ty_lpv_tile* tile) {
    direct_tile direct;
    find_direct(state, tile, &direct);
    for (int32_t i = 0; i < tile->count; ++i) {
        ty_lpv_pixel* pixel = &tile->pixels[i];
        if (isinf(pixel->distance)) continue;
        const int32_t left = window_begin(pixel->x % TY_TILE), top = window_begin(pixel->y % TY_TILE);
        float sum[3] = {0, 0, 0}, count = 0;
        for (int32_t k = 0; k < TY_LIGHT_PATTERN; ++k) {
            const int32_t x = left + k % TY_LIGHT_PATTERN_SIDE, y = top + k / TY_LIGHT_PATTERN_SIDE;
            if (direct.pixels[y][x] == NULL || !is_alike(pixel, direct.pixels[y][x])) continue;
            for (int c = 0; c < 3; ++c) sum[c] += direct.irradiance[y][x][c];
            count += 1.0f;
        }
        for (int c = 0; c < 3; ++c) pixel->radiance[c] += pixel->albedo[c] * (1.0f / TY_PI) * sum[c] / count;
    }
}

/* ---- light of the lattices ---- */

/* The irradiance queries of a tile. */
typedef struct irradiance_list {
    int32_t count;
    ty_irradiance_query places[TY_TILE_PIXELS];
} irradiance_list;

/* A block is flat if its pixels are within this distance, in cells, and the cosines between their normals are at least
 * this. */
static const float flat_within = 0.25f, flat_cosine = 0.998f;

/* True if the pixels from `first` on are a whole block on a flat surface: then irradiance is interpolated from its
 * corners. */
static bool is_flat(const ty_lpv_march_state* state, const ty_lpv_tile* tile, int32_t first) {
    const ty_lpv_pixel* block = &tile->pixels[first];
    const float max_off = flat_within * state->lattices.lattices[0].cell;
    if (first + TY_BLOCK_PIXELS > tile->count || block[TY_BLOCK_PIXELS - 1].x != block[0].x + TY_BLOCK - 1 ||
        block[TY_BLOCK_PIXELS - 1].y != block[0].y + TY_BLOCK - 1)
        return false;
    bool flat = true;
    for (int32_t i = 0; i < TY_BLOCK_PIXELS && flat; ++i) {
        if (isinf(block[i].distance)) return false;
        const ty_vec off = ty_sub(block[i].position, block[0].position);
        flat = ty_dot(off, off) < max_off * max_off && ty_dot(block[i].normal, block[0].normal) > flat_cosine;
    }
    return flat;
}

static void list_place(const ty_lpv_pixel* pixel, irradiance_list* list) {
    list->places[list->count++] = (ty_irradiance_query){.point = pixel->position, .normal = pixel->normal};
}

static void add_irradiance(const float irradiance[3], ty_lpv_pixel* pixel) {
    for (int c = 0; c < 3; ++c) pixel->radiance[c] += pixel->albedo[c] * (1.0f / TY_PI) * irradiance[c];
}

/* Interpolates between the corners of a block. */
static void add_between(const ty_irradiance_query corners[4], ty_lpv_pixel* block) {
    for (int32_t i = 0; i < TY_BLOCK_PIXELS; ++i) {
        const float across = (float)(i % TY_BLOCK) * (1.0f / (TY_BLOCK - 1));
        const float down = (float)(i / TY_BLOCK) * (1.0f / (TY_BLOCK - 1));
        float irradiance[3];
        for (int c = 0; c < 3; ++c)
            irradiance[c] = ty_lerpf(ty_lerpf(corners[0].irradiance[c], corners[1].irradiance[c], across),
                                     ty_lerpf(corners[2].irradiance[c], corners[3].irradiance[c], across), down);
        add_irradiance(irradiance, &block[i]);
    }
}

static void add_lattice(ty_lpv_march_state* state, ty_lpv_tile* tile) {
    static const int32_t corner[4] = {0, TY_BLOCK - 1, TY_BLOCK_PIXELS - TY_BLOCK, TY_BLOCK_PIXELS - 1};
    bool flat[TY_TILE_PIXELS / TY_BLOCK_PIXELS];
    irradiance_list list;
    list.count = 0;
    for (int32_t first = 0; first < tile->count; first += TY_BLOCK_PIXELS) {
        ty_lpv_pixel* block = &tile->pixels[first];
        flat[first / TY_BLOCK_PIXELS] = is_flat(state, tile, first);
        for (int32_t i = 0; i < 4 && flat[first / TY_BLOCK_PIXELS]; ++i) list_place(&block[corner[i]], &list);
        for (int32_t i = first; i < first + TY_BLOCK_PIXELS && i < tile->count; ++i)
            if (!flat[first / TY_BLOCK_PIXELS] && !isinf(tile->pixels[i].distance)) list_place(&tile->pixels[i], &list);
    }
    state->kernels->irradiance(&state->lattices, list.places, list.count);
    const ty_irradiance_query* next = list.places;
    for (int32_t first = 0; first < tile->count; first += TY_BLOCK_PIXELS) {
        if (flat[first / TY_BLOCK_PIXELS]) {
            add_between(next, &tile->pixels[first]);
            next += 4;
            continue;
        }
        for (int32_t i = first; i < first + TY_BLOCK_PIXELS && i < tile->count; ++i)
            if (!isinf(tile->pixels[i].distance)) add_irradiance((next++)->irradiance, &tile->pixels[i]);
    }
}

void ty_lpv_shade_surfaces(ty_lpv_march_state* state, ty_lpv_tile* tile) {
    for (int32_t i = 0; i < state->job->shadow_map_count; ++i) add_light(state, i, tile);
    if (state->job->extended != NULL) add_extended(state, tile);
    if ((state->job->def->parts & TY_LPV_SURFACES) != 0 && state->lattices.count > 0) add_lattice(state, tile);
    for (int32_t i = 0; i < tile->count; ++i) {
        const ty_lpv_pixel* pixel = &tile->pixels[i];
        float* to = state->surface + 3 * ty_lpv_band_index(state, pixel->x, pixel->y);
        for (int c = 0; c < 3; ++c) to[c] = pixel->radiance[c];
    }
}
