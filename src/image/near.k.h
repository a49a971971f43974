/* Uncollided light where media are so thick that the cells it lies on do not resolve how it fades: followed from the
 * point towards the light through the media as they are, and taken from the cells further on. */
#ifndef TY_IMAGE_NEAR_K_H
#define TY_IMAGE_NEAR_K_H

#include "image/kernel.h"
#include "image/voxel.k.h"
#include "scene/spans.k.h"

/* Optical depth of a cell above which that is done, and where transfer functions make media with edges; how many cells
 * further on at a time, and times at most; samples of the density on the way, for each voxel (and one for each unit of
 * optical depth), and in all of a time. */
#define TY_NEAR_THICK 0.7f
#define TY_NEAR_THICK_EDGED 0.15f
#define TY_NEAR_CELLS 2.0f
#define TY_NEAR_PER_VOXEL 1.5f
enum { TY_NEAR_PIECES = 8, TY_NEAR_SAMPLES_MIN = 3, TY_NEAR_SAMPLES_MAX = 8 };
/* Optical depth behind which there is next to no light; relative difference, and optical depth of a piece, up to which
 * media are even. */
#define TY_NEAR_BLACK 8.0f
#define TY_NEAR_EVEN 0.3f
#define TY_NEAR_EMPTY 0.02f

/* A light as it is seen from a point. */
typedef struct ty_near_light {
    ty_cell_point at;                     /* where its fluences are taken */
    float passing[TY_SINGLE_FLUENCES][3]; /* what of each comes from there */
} ty_near_light;

/* The integral of a medium's density between two distances along a ray, m. extinction: about what it is there, 1/m. */
TY_FN float ty_near_amount(TY_GLOBAL const ty_medium_view* medium, ty_vec from, ty_vec toward, float enter, float leave,
                           float extinction) {
    const float length = leave - enter;
    if (medium->has_grid == 0) return length;
    const ty_vec origin = ty_map_point(medium->to_index, from);
    const ty_vec direction = ty_map_direction(medium->to_index, toward);
    const float voxels = length * sqrtf(ty_dot(direction, direction));
    const int32_t count = (int32_t)ty_clampf(TY_NEAR_PER_VOXEL * voxels + extinction * length + 0.5f,
                                             (float)TY_NEAR_SAMPLES_MIN, (float)TY_NEAR_SAMPLES_MAX);
    const float part = length / (float)count;
    float sum = 0.0f;
    for (int32_t i = 0; i < count; ++i)
        sum += ty_voxels_density(medium, ty_mad(origin, direction, enter + part * ((float)i + 0.5f)));
    return sum * part;
}

/* How much of what scatters counts as light that goes straight on. */
TY_FN float ty_near_kept(int32_t reduced, float g) {
    if (reduced < 2) return reduced == 0 ? 0.0f : ty_maxf(0.0f, g);
    float power = g;
    for (int32_t l = 1; l < reduced; ++l) power *= g;
    return power;
}

/* Adds the optical depths of a medium between two distances along a ray, as beams' fluences lose light. */
TY_FN void ty_near_depth(TY_GLOBAL const ty_march_request* request, TY_GLOBAL const ty_medium_view* medium, ty_vec from,
                         ty_vec toward, float enter, float leave, float extinction,
                         float depth[TY_SINGLE_FLUENCES][3]) {
    const float amount = ty_near_amount(medium, from, toward, enter, leave, extinction);
    const ty_vec middle = ty_mad(from, toward, 0.5f * (enter + leave));
    float sigma_s[3], g[3];
    ty_medium_sigma_s(medium, middle, sigma_s);
    ty_medium_g(medium, middle, g);
    for (int32_t c = 0; c < 3; ++c) {
        const float sigma_t = medium->sigma_t[c], power = ty_near_kept(request->reduced, g[c]);
        const float kept = request->fit.bands > 0 ? request->fit.straight : power;
        depth[TY_SINGLE_KEPT][c] += amount * ty_maxf(0.0f, sigma_t - kept * sigma_s[c]);
        depth[TY_SINGLE_STRAIGHT][c] += amount * sigma_t;
        depth[TY_SINGLE_BENT][c] += amount * ty_maxf(0.0f, sigma_t - ty_maxf(0.0f, g[c]) * power * sigma_s[c]);
    }
}

TY_FN bool ty_near_in_box(ty_vec p, ty_vec low, ty_vec high) {
    return p.x >= low.x && p.y >= low.y && p.z >= low.z && p.x <= high.x && p.y <= high.y && p.z <= high.z;
}

/* Whether a point is within a medium's bounds and grid, if they are convex: then so is all between two such points. */
TY_FN bool ty_near_inside(TY_GLOBAL const ty_medium_view* medium, ty_vec point) {
    if (medium->bounds == TY_BOUNDED_MESH) return false;
    const ty_vec p = ty_map_point(medium->to_bounds, point);
    if (medium->bounds == TY_BOUNDED_BOX && !ty_near_in_box(p, ty_vec_make(-1, -1, -1), ty_vec_make(1, 1, 1)))
        return false;
    if (medium->bounds == TY_BOUNDED_SPHERE && ty_dot(p, p) > 1.0f) return false;
    const int32_t* size = medium->grid.size;
    return medium->has_grid == 0 || ty_near_in_box(ty_map_point(medium->to_index, point), ty_vec_make(-1, -1, -1),
                                                   ty_vec_make((float)size[0], (float)size[1], (float)size[2]));
}

/* The optical depth of all media from a point up to some distance. */
TY_FN void ty_near_depths(TY_GLOBAL const ty_march_request* request, ty_vec from, ty_vec toward, float far,
                          float extinction, float depth[TY_SINGLE_FLUENCES][3]) {
    TY_GLOBAL const ty_scene_view* scene = request->scene;
    const ty_vec end = ty_mad(from, toward, far);
    for (int32_t m = 0; m < scene->medium_count; ++m) {
        TY_GLOBAL const ty_medium_view* medium = &scene->media[m];
        if (ty_near_inside(medium, from) && ty_near_inside(medium, end)) {
            ty_near_depth(request, medium, from, toward, 0.0f, far, extinction, depth);
            continue;
        }
        ty_spans spans;
        ty_spans_find(medium, 1, from, toward, far, &spans);
        for (int32_t i = 0; i < spans.count; ++i)
            ty_near_depth(request, medium, from, toward, spans.enter[i], spans.leave[i], extinction, depth);
    }
}

/* A way from a point towards a light. */
typedef struct ty_near_way {
    ty_vec from, toward;
    float piece, far; /* lengths, m */
} ty_near_way;

/* Adds the optical depths along it, piece by piece, until the light is lost, or the media have been even: what cells
 * hold there does for the rest. Where they have edges that cells do not resolve, that is not so. Returns how far it
 * went, m. extinction: where the way begins. */
TY_FN float ty_near_pass(TY_GLOBAL const ty_march_request* request, const ty_near_way* way, float extinction,
                         float depth[TY_SINGLE_FLUENCES][3]) {
    const float* sums = depth[TY_SINGLE_STRAIGHT];
    float at = 0.0f, before = extinction, sum = 0.0f;
    for (int32_t i = 0; i < TY_NEAR_PIECES && at < way->far; ++i) {
        const float length = ty_minf(way->piece, way->far - at), expected = before * length;
        ty_near_depths(request, ty_mad(way->from, way->toward, at), way->toward, length, before, depth);
        const float next = (sums[0] + sums[1] + sums[2]) * (1.0f / 3.0f), piece = next - sum;
        sum = next;
        before = piece / length;
        at += length;
        if (sum > TY_NEAR_BLACK || fabsf(piece - expected) < TY_NEAR_EVEN * expected + TY_NEAR_EMPTY) break;
    }
    return at;
}

/* One light, through the media on the way to cells further on; false where there are none, beyond the middles of the
 * outer cells, or a surface is on the way. */
TY_FN bool ty_near_follow(TY_GLOBAL const ty_march_request* request, TY_GLOBAL const ty_single_light* light,
                          ty_vec point, float extinction, ty_near_light* out) {
    TY_GLOBAL const ty_scene_view* scene = request->scene;
    ty_vec toward = ty_scale(light->toward, -1.0f);
    float distance = TY_FLOAT_MAX;
    if (light->kind == TY_SINGLE_LAMP) {
        const ty_vec to = ty_sub(light->toward, point);
        distance = sqrtf(ty_maxf(ty_dot(to, to), 1e-30f));
        toward = ty_scale(to, 1.0f / distance);
    }
    const ty_vec cells = ty_vec_make(toward.x * request->light.per_cell.x, toward.y * request->light.per_cell.y,
                                     toward.z * request->light.per_cell.z);
    const ty_vec from = ty_cell_coordinates(&request->light, point);
    const ty_vec first = ty_vec_make(0.5f, 0.5f, 0.5f);
    const ty_vec last = ty_vec_make((float)request->light.size[0] - 0.5f, (float)request->light.size[1] - 0.5f,
                                    (float)request->light.size[2] - 0.5f);
    const float piece = TY_NEAR_CELLS / sqrtf(ty_dot(cells, cells));
    float near = 0.0f, far = ty_minf((float)TY_NEAR_PIECES * piece, 0.5f * distance);
    if (!ty_near_in_box(from, first, last)) return false;
    if (!ty_near_in_box(ty_mad(from, cells, far), first, last)) ty_clip_box(from, cells, first, last, &near, &far);
    float depth[TY_SINGLE_FLUENCES][3];
    memset(depth, 0, sizeof depth);
    const ty_near_way way = {point, toward, piece, far};
    far = ty_near_pass(request, &way, extinction, depth);
    if (scene->mesh != NULL && ty_accel_occluded(scene->mesh, point, toward, far)) return false;
    const float spread = distance < TY_FLOAT_MAX ? (distance - far) / distance : 1.0f;
    for (int32_t f = 0; f < (light->lobes != 0 ? TY_SINGLE_FLUENCES : 1); ++f)
        for (int32_t c = 0; c < 3; ++c) out->passing[f][c] = spread * spread * ty_decay(depth[f][c]);
    out->at = ty_cell_locate(request->light.size, ty_mad(from, cells, far));
    return true;
}

/* Whether all that a light meets on its way counts where the mean extinction is as given, 1/m. */
TY_FN bool ty_near_thick(TY_GLOBAL const ty_march_request* request, float extinction) {
    TY_GLOBAL const ty_scene_view* scene = request->scene;
    const ty_vec per_cell = request->light.per_cell;
    const float coarsest = ty_minf(per_cell.x, ty_minf(per_cell.y, per_cell.z));
    if (extinction > TY_NEAR_THICK * coarsest) return true;
    if (!(extinction > TY_NEAR_THICK_EDGED * coarsest)) return false;
    for (int32_t m = 0; m < scene->medium_count; ++m)
        if (scene->media[m].transfer != NULL) return true;
    return false;
}

/* All lights from a point where the mean extinction is as given, 1/m. */
TY_FN void ty_near_look(TY_GLOBAL const ty_march_request* request, ty_vec point, float extinction,
                        ty_near_light* lights) {
    if (request->light_count == 0) return;
    const bool thick = ty_near_thick(request, extinction);
    for (int32_t i = 0; i < request->light_count; ++i) {
        TY_GLOBAL const ty_single_light* light = &request->lights[i];
        if (thick && light->kind < TY_SINGLE_MANY && ty_near_follow(request, light, point, extinction, &lights[i]))
            continue;
        lights[i].at = ty_cell_locate(request->light.size, ty_cell_coordinates(&request->light, point));
        for (int32_t f = 0; f < TY_SINGLE_FLUENCES; ++f)
            for (int32_t c = 0; c < 3; ++c) lights[i].passing[f][c] = 1.0f;
    }
}

#endif
