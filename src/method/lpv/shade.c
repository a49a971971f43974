/* What surfaces reflect. */
#include "method/lpv/frame.h"

/* Cosines between surfaces and lights below which maps are not asked if rays may be. */
static const float grazing = 0.02f;
/* How much nearer than a surface's plane texels may be, in their widths, to be of the surface itself: where rays decide
 * whether those up to `touching` of them are, and where they do not. */
static const float own_with_rays = 0.1f, own_without = 1.0f, touching = 6.0f;

/* ---- shadows ---- */

/* How wide the texels of a map are about so far from its light, m. */
static float texel_width(const ty_lit_map* lit, float distance) {
    const ty_light_map* map = lit->map;
    double square[2] = {0, 0};
    for (int a = 0; a < 3; ++a) {
        square[0] += map->right[0][a] * map->right[0][a];
        square[1] += map->up[0][a] * map->up[0][a];
    }
    const float width = 2.0f * (float)sqrt(fmax(square[0], square[1])) / (float)map->side;
    return lit->light.kind == TY_KIND_DIRECTIONAL ? width : width * distance;
}

/* Rays towards a light that wait until there are enough of them. */
typedef struct shadow_packet {
    int32_t count;
    ty_ray rays[TY_PACKET];
    ty_lpv_pixel* pixels[TY_PACKET];
    float light[TY_PACKET][3]; /* what they bring if nothing is in between */
} shadow_packet;

static void trace_shadows(ty_lpv_frame* frame, shadow_packet* packet) {
    bool occluded[TY_PACKET];
    if (packet->count == 0) return;
    const int64_t begun = ty_lpv_clock(frame, TY_CLOCKS, 0);
    ty_accel_occluded_packet(frame->scene->mesh, packet->rays, packet->count, occluded);
    ty_lpv_clock(frame, TY_CLOCK_RAYS, begun);
    for (int32_t i = 0; i < packet->count; ++i)
        for (int c = 0; c < 3 && !occluded[i]; ++c) packet->pixels[i]->radiance[c] += packet->light[i][c];
    atomic_fetch_add(&frame->rays, packet->count);
    packet->count = 0;
}

static void ask_ray(ty_lpv_frame* frame, const ty_light_sample* sample, ty_lpv_pixel* pixel, const float light[3],
                    shadow_packet* packet) {
    const ty_vec from = ty_mad(pixel->position, pixel->facing, pixel->margin), way = sample->wi;
    const float far = sample->distance < TY_FLOAT_MAX ? sample->distance * 0.9999f : INFINITY;
    packet->rays[packet->count] = (ty_ray){{from.x, from.y, from.z}, {way.x, way.y, way.z}, far};
    packet->pixels[packet->count] = pixel;
    memcpy(packet->light[packet->count], light, sizeof packet->light[0]);
    if (++packet->count == TY_PACKET) trace_shadows(frame, packet);
}

/* The share of a light that gets to a pixel by its map; -1: a ray is to say. */
static float share_of_light(const ty_lpv_frame* frame, const ty_lit_map* map, const ty_lpv_pixel* pixel,
                            const ty_light_sample* sample) {
    const bool asks = frame->job->def->shadow_rays && frame->scene->mesh != NULL;
    if (asks && ty_dot(pixel->facing, sample->wi) < grazing) return -1.0f;
    const float texel = texel_width(map, sample->distance), own = asks ? own_with_rays : own_without;
    bool sure;
    const float share =
        ty_lit_share(map, pixel->position, pixel->facing, own * texel + 2.0f * pixel->margin, touching * texel, &sure);
    return asks && !sure ? -1.0f : share;
}

/* ---- direct light ---- */

/* Radiance by a light that nothing shadows; false where there is none. */
static bool reflect_light(const ty_lpv_frame* frame, int32_t index, const ty_light_sample* sample,
                          const ty_lpv_pixel* pixel, float light[3]) {
    const float facing = ty_dot(pixel->normal, sample->wi) * (1.0f / TY_PI);
    if (!(facing > 0.0f) || !(ty_dot(pixel->facing, sample->wi) > 0.0f)) return false;
    float sum = 0.0f;
    for (int c = 0; c < 3; ++c) {
        light[c] = pixel->albedo[c] * facing * sample->radiance[c];
        sum += light[c];
    }
    if (!(sum > 0.0f && sum < TY_FLOAT_MAX)) return false;
    if (!frame->foggy || frame->job->airlight == NULL) return true;
    float transmittance[3];
    ty_airlight_reach(frame->job->airlight, index, pixel->position, transmittance);
    for (int c = 0; c < 3; ++c) light[c] *= transmittance[c];
    return true;
}

static void add_light(ty_lpv_frame* frame, int32_t index, ty_lpv_tile* tile) {
    const ty_lit_map* map = frame->job->maps[index];
    const ty_light_view* view = &frame->scene->lights.lights[index];
    shadow_packet packet = {.count = 0};
    for (int32_t i = 0; i < tile->count; ++i) {
        ty_lpv_pixel* pixel = &tile->pixels[i];
        ty_light_sample sample;
        float light[3];
        if (isinf(pixel->distance) || !ty_light_sample_from(view, pixel->position, 0.5f, 0.5f, &sample)) continue;
        if (!(ty_dot(pixel->normal, sample.wi) > 0.0f)) continue;
        const float share = share_of_light(frame, map, pixel, &sample);
        if (share == 0.0f || !reflect_light(frame, index, &sample, pixel, light)) continue;
        if (share < 0.0f) {
            ask_ray(frame, &sample, pixel, light, &packet);
            continue;
        }
        for (int c = 0; c < 3; ++c) pixel->radiance[c] += share * light[c];
    }
    trace_shadows(frame, &packet);
}

/* ---- the lattice's light ---- */

/* Where light is looked up, and what arrives there. */
typedef struct look_list {
    int32_t count;
    ty_look_place places[TY_TILE_PIXELS];
} look_list;

/* Blocks are flat if their pixels are no farther apart than this, in cells, and their normals' cosines at least so. */
static const float flat_within = 0.25f, flat_cosine = 0.998f;

/* Whether a tile's pixels from `first` on are a whole block on one flat surface: then its corners say it all. */
static bool is_flat(const ty_lpv_frame* frame, const ty_lpv_tile* tile, int32_t first) {
    const ty_lpv_pixel* block = &tile->pixels[first];
    const float most = flat_within * frame->look.lattices[0].cell;
    if (first + TY_BLOCK_PIXELS > tile->count || block[TY_BLOCK_PIXELS - 1].x != block[0].x + TY_BLOCK - 1 ||
        block[TY_BLOCK_PIXELS - 1].y != block[0].y + TY_BLOCK - 1)
        return false;
    bool flat = true;
    for (int32_t i = 0; i < TY_BLOCK_PIXELS && flat; ++i) {
        if (isinf(block[i].distance)) return false;
        const ty_vec off = ty_sub(block[i].position, block[0].position);
        flat = ty_dot(off, off) < most * most && ty_dot(block[i].normal, block[0].normal) > flat_cosine;
    }
    return flat;
}

static void list_place(const ty_lpv_pixel* pixel, look_list* list) {
    list->places[list->count++] = (ty_look_place){.point = pixel->position, .normal = pixel->normal};
}

static void add_irradiance(const float irradiance[3], ty_lpv_pixel* pixel) {
    for (int c = 0; c < 3; ++c) pixel->radiance[c] += pixel->albedo[c] * (1.0f / TY_PI) * irradiance[c];
}

/* Between the corners of a block. */
static void add_between(const ty_look_place corners[4], ty_lpv_pixel* block) {
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

static void add_lattice(ty_lpv_frame* frame, ty_lpv_tile* tile) {
    static const int32_t corner[4] = {0, TY_BLOCK - 1, TY_BLOCK_PIXELS - TY_BLOCK, TY_BLOCK_PIXELS - 1};
    bool flat[TY_TILE_PIXELS / TY_BLOCK_PIXELS];
    look_list list;
    list.count = 0;
    for (int32_t first = 0; first < tile->count; first += TY_BLOCK_PIXELS) {
        ty_lpv_pixel* block = &tile->pixels[first];
        flat[first / TY_BLOCK_PIXELS] = is_flat(frame, tile, first);
        for (int32_t i = 0; i < 4 && flat[first / TY_BLOCK_PIXELS]; ++i) list_place(&block[corner[i]], &list);
        for (int32_t i = first; i < first + TY_BLOCK_PIXELS && i < tile->count; ++i)
            if (!flat[first / TY_BLOCK_PIXELS] && !isinf(tile->pixels[i].distance)) list_place(&tile->pixels[i], &list);
    }
    frame->kernels->irradiance(&frame->look, list.places, list.count);
    const ty_look_place* next = list.places;
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

void ty_lpv_shade(ty_lpv_frame* frame, ty_lpv_tile* tile) {
    for (int32_t i = 0; i < frame->job->map_count; ++i) add_light(frame, i, tile);
    if ((frame->job->def->parts & TY_LPV_SURFACES) != 0 && frame->look.count > 0) add_lattice(frame, tile);
    for (int32_t i = 0; i < tile->count; ++i) {
        const ty_lpv_pixel* pixel = &tile->pixels[i];
        float* to = frame->surface + 3 * ty_lpv_kept(frame, pixel->x, pixel->y);
        for (int c = 0; c < 3; ++c) to[c] = pixel->radiance[c];
    }
}
