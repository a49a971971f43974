/* Uncollided light in media so dense that the light's cells do not resolve its attenuation: traced from the point
 * towards the light through the original media, and looked up in cells farther along. */
#ifndef TY_IMAGE_NEAR_K_H
#define TY_IMAGE_NEAR_K_H

#include "image/march/kernel.h"
#include "image/march/voxel.k.h"
#include "scene/media/spans.k.h"

/* Optical depth of a cell above which rays are traced, and the same for media with transfer functions, which have
 * edges; length of a piece in cells; samples of the density per voxel (plus one per unit of optical depth). Below:
 * maximum number of pieces, and bounds of the samples per piece. */
#define TY_NEAR_MIN_CELL_DEPTH 0.7f
#define TY_NEAR_MIN_CELL_DEPTH_TRANSFER 0.15f
#define TY_NEAR_CELLS 2.0f
#define TY_NEAR_PER_VOXEL 1.5f
enum { TY_NEAR_PIECES = 8, TY_NEAR_SAMPLES_MIN = 3, TY_NEAR_SAMPLES_MAX = 8 };
/* Optical depth that counts as opaque; relative difference, and optical depth of a piece, up to which media count as
 * uniform. */
#define TY_NEAR_BLACK 8.0f
#define TY_NEAR_UNIFORM 0.3f
#define TY_NEAR_EMPTY 0.02f
/* Rays to a light with extent, per axis, and the part of the distance to a light that is free of its own surface. */
enum { TY_NEAR_SIDE = 2 };
#define TY_NEAR_VISIBLE 0.999f

/* A light at a point. */
typedef struct ty_near_light {
    ty_cell_point at;                         /* cell position of its fluence lookup */
    float transmittance[TY_FLUENCE_COUNT][3]; /* transmittance from there, per fluence */
    float depth[3];                           /* optical depth of sigma_t from the point to the lookup */
    float
        falloff; /* squared ratio of the distances to a point light: irradiance at the point over that at the lookup */
} ty_near_light;

/* Integral of a medium's density between two distances along a ray, m. extinction: its approximate value there, 1/m. */
TY_FN float ty_near_column(TY_GLOBAL const ty_medium_view* medium, ty_vec from, ty_vec wi, float enter, float leave,
                           float extinction) {
    const float length = leave - enter;
    if (medium->has_grid == 0) return length;
    const ty_vec origin = ty_map_point(medium->to_index, from);
    const ty_vec direction = ty_map_direction(medium->to_index, wi);
    const float voxels = length * sqrtf(ty_dot(direction, direction));
    const int32_t count = (int32_t)ty_clampf(TY_NEAR_PER_VOXEL * voxels + extinction * length + 0.5f,
                                             (float)TY_NEAR_SAMPLES_MIN, (float)TY_NEAR_SAMPLES_MAX);
    const float spacing = length / (float)count;
    float sum = 0.0f;
    for (int32_t i = 0; i < count; ++i)
        sum += ty_voxels_density(medium, ty_mad(origin, direction, enter + spacing * ((float)i + 0.5f)));
    return sum * spacing;
}

/* Fraction of scattering that counts as delta-scattered. */
TY_FN float ty_near_forward_fraction(int32_t reduced, float g) {
    if (reduced < 2) return reduced == 0 ? 0.0f : ty_maxf(0.0f, g);
    float power = g;
    for (int32_t l = 1; l < reduced; ++l) power *= g;
    return power;
}

/* Adds the optical depths of a medium between two distances along a ray, for each of the scaled extinctions of the
 * fluences. */
TY_FN void ty_near_depth(TY_GLOBAL const ty_march_request* request, TY_GLOBAL const ty_medium_view* medium, ty_vec from,
                         ty_vec wi, float enter, float leave, float extinction, float depth[TY_FLUENCE_COUNT][3]) {
    const float column = ty_near_column(medium, from, wi, enter, leave, extinction);
    const ty_vec center = ty_mad(from, wi, 0.5f * (enter + leave));
    float sigma_s[3], g[3];
    ty_medium_sigma_s(medium, center, sigma_s);
    ty_medium_g(medium, center, g);
    for (int32_t c = 0; c < 3; ++c) {
        const float sigma_t = medium->sigma_t[c];
        const float power =
            request->has_forward != 0 ? request->forward[0] : ty_near_forward_fraction(request->reduced, g[c]);
        const float next = request->has_forward != 0 ? request->forward[1] : ty_maxf(0.0f, g[c]) * power;
        const float forward = request->fit.bands > 0 ? request->fit.forward_fraction : power;
        depth[TY_FLUENCE_ORDER_L][c] += column * ty_maxf(0.0f, sigma_t - forward * sigma_s[c]);
        depth[TY_FLUENCE_UNSCATTERED][c] += column * sigma_t;
        depth[TY_FLUENCE_NEXT_ORDER][c] += column * ty_maxf(0.0f, sigma_t - next * sigma_s[c]);
    }
}

TY_FN bool ty_near_in_box(ty_vec p, ty_vec low, ty_vec high) {
    return p.x >= low.x && p.y >= low.y && p.z >= low.z && p.x <= high.x && p.y <= high.y && p.z <= high.z;
}

/* True if a point is inside a convex medium and its grid: then so is the segment between two such points. */
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

/* Adds the optical depths of all media from a point up to a distance. */
TY_FN void ty_near_depths(TY_GLOBAL const ty_march_request* request, ty_vec from, ty_vec wi, float max_distance,
                          float extinction, float depth[TY_FLUENCE_COUNT][3]) {
    TY_GLOBAL const ty_scene_view* scene = request->scene;
    const ty_vec end = ty_mad(from, wi, max_distance);
    for (int32_t m = 0; m < scene->medium_count; ++m) {
        TY_GLOBAL const ty_medium_view* medium = &scene->media[m];
        if (ty_near_inside(medium, from) && ty_near_inside(medium, end)) {
            ty_near_depth(request, medium, from, wi, 0.0f, max_distance, extinction, depth);
            continue;
        }
        ty_spans spans;
        ty_spans_find(medium, 1, from, wi, max_distance, &spans);
        for (int32_t i = 0; i < spans.count; ++i)
            ty_near_depth(request, medium, from, wi, spans.enter[i], spans.leave[i], extinction, depth);
    }
}

/* A ray from a point towards a light. */
typedef struct ty_near_ray {
    ty_vec origin, wi;
    float piece, max_distance; /* lengths, m */
    float inner[2];            /* its part between the centers of the outer cells, m */
} ty_near_ray;

/* Adds the optical depths along the ray piece by piece, until it is opaque or the media are uniform: from there the
 * cells are accurate, but for the outer halves of outer cells, whose light is not interpolated. Media with unresolved
 * edges never count as uniform. Returns the distance marched, m. extinction: at the origin. */
TY_FN float ty_near_integrate(TY_GLOBAL const ty_march_request* request, const ty_near_ray* near, float extinction,
                              float depth[TY_FLUENCE_COUNT][3]) {
    const float* sums = depth[TY_FLUENCE_UNSCATTERED];
    float at = 0.0f, before = extinction, sum = 0.0f;
    for (int32_t i = 0; i < TY_NEAR_PIECES && at < near->max_distance; ++i) {
        const float length = ty_minf(near->piece, near->max_distance - at), expected = before * length;
        ty_near_depths(request, ty_mad(near->origin, near->wi, at), near->wi, length, before, depth);
        const float next = (sums[0] + sums[1] + sums[2]) * (1.0f / 3.0f), piece = next - sum;
        sum = next;
        before = piece / length;
        at += length;
        if (sum > TY_NEAR_BLACK) break;
        if (at >= near->inner[0] && at <= near->inner[1] &&
            fabsf(piece - expected) < TY_NEAR_UNIFORM * expected + TY_NEAR_EMPTY)
            break;
    }
    return at;
}

/* The ray from a point in the cells' box towards a light: to the box's end, or as far as attenuation is traced. Returns
 * whether it reaches the end. */
TY_FN bool ty_near_aim(TY_GLOBAL const ty_march_request* request, ty_vec from, ty_vec cells, float distance,
                       ty_near_ray* ray) {
    const ty_cell_lattice* lattice = &request->light;
    const ty_vec size = ty_vec_make((float)lattice->size[0], (float)lattice->size[1], (float)lattice->size[2]);
    const ty_vec half = ty_vec_make(0.5f, 0.5f, 0.5f);
    float begin = 0.0f, end = distance;
    ray->piece = TY_NEAR_CELLS / sqrtf(ty_dot(cells, cells));
    ray->max_distance = ty_minf((float)TY_NEAR_PIECES * ray->piece, 0.5f * distance);
    ray->inner[0] = 0.0f;
    ray->inner[1] = TY_FLOAT_MAX;
    if (!ty_clip_box(from, cells, half, ty_sub(size, half), &ray->inner[0], &ray->inner[1])) ray->inner[1] = -1.0f;
    if (request->traces_faces == 0) {
        ray->max_distance = ty_minf(ray->max_distance, ray->inner[1]);
        ray->inner[1] = TY_FLOAT_MAX;
        return false;
    }
    ty_clip_box(from, cells, ty_vec_make(0.0f, 0.0f, 0.0f), size, &begin, &end);
    if (end > (float)TY_NEAR_PIECES * ray->piece || !(end < distance)) return false;
    ray->max_distance = end;
    return true;
}

/* Fluence of a light at a point that no media attenuate it up to, W m^-2, with the shadows of surfaces. */
TY_FN void ty_near_unattenuated(TY_GLOBAL const ty_scene_view* scene, const ty_discrete_light* sample, ty_vec point,
                                float fluence[3]) {
    TY_GLOBAL const ty_light_view* light = &scene->lights.lights[sample->light];
    const int32_t side = sample->kind == TY_DISCRETE_POINT && sample->is_point == 0 ? TY_NEAR_SIDE : 1;
    for (int32_t c = 0; c < 3; ++c) fluence[c] = 0.0f;
    for (int32_t i = 0; i < side * side; ++i) {
        const float u = ((float)(i % side) + 0.5f) / (float)side, v = ((float)(i / side) + 0.5f) / (float)side;
        ty_light_sample to;
        if (!ty_light_sample_from(light, point, u, v, &to)) continue;
        if (scene->mesh != NULL && sample->shadowed != 0 &&
            ty_accel_occluded(scene->mesh, point, to.wi, TY_NEAR_VISIBLE * to.distance))
            continue;
        for (int32_t c = 0; c < 3; ++c) fluence[c] += to.radiance[c] / (float)(side * side);
    }
}

/* Divides the unattenuated fluence by that of the cell where it is looked up, whose mean the media in it attenuate. */
TY_FN void ty_near_enter(TY_GLOBAL const ty_light_fluence* light, const float unattenuated[3], ty_near_light* out) {
    for (int32_t f = 0; f < (light->lobe_order != 0 ? TY_FLUENCE_COUNT : 1); ++f)
        for (int32_t c = 0; c < 3; ++c) {
            const int32_t plane = light->shared != 0 ? 0 : c;
            TY_GLOBAL const float* planes[TY_FLUENCE_COUNT] = {light->fluence[plane], light->unscattered[plane],
                                                               light->next_order[plane]};
            const float value = ty_cell_value(planes[f], &out->at) * (light->shared != 0 ? light->color[c] : 1.0f);
            out->transmittance[f][c] *= value > 0.0f ? unattenuated[c] / value : 0.0f;
        }
}

/* One light, traced through the media to cells farther along, or to the end of the box, where nothing has attenuated
 * it; false if a surface is in between, or the cells there are outer ones. */
TY_FN bool ty_near_follow(TY_GLOBAL const ty_march_request* request, TY_GLOBAL const ty_light_fluence* light,
                          ty_vec point, float extinction, ty_near_light* out) {
    TY_GLOBAL const ty_scene_view* scene = request->scene;
    ty_vec wi = ty_scale(light->anchor, -1.0f);
    float distance = TY_FLOAT_MAX;
    if (light->kind == TY_FLUENCE_POINT) {
        const ty_vec to = ty_sub(light->anchor, point);
        distance = sqrtf(ty_maxf(ty_dot(to, to), 1e-30f));
        wi = ty_scale(to, 1.0f / distance);
    }
    const ty_vec cells = ty_vec_make(wi.x * request->light.per_cell.x, wi.y * request->light.per_cell.y,
                                     wi.z * request->light.per_cell.z);
    const ty_vec from = ty_cell_coordinates(&request->light, point);
    ty_near_ray ray = {.origin = point, .wi = wi};
    if (!ty_cell_inside(&request->light, from)) return false;
    const bool enters = ty_near_aim(request, from, cells, distance, &ray) && light->sample.light < scene->lights.count;
    if (request->traces_faces == 0 && (ray.inner[0] > 0.0f || ray.max_distance < 0.0f)) return false;
    float depth[TY_FLUENCE_COUNT][3];
    memset(depth, 0, sizeof depth);
    const float marched = ty_near_integrate(request, &ray, extinction, depth);
    const bool outside = enters && marched >= ray.max_distance;
    const float* sums = depth[TY_FLUENCE_UNSCATTERED];
    const bool opaque = sums[0] + sums[1] + sums[2] > 3.0f * TY_NEAR_BLACK;
    if (!outside && !opaque && (marched < ray.inner[0] || marched > ray.inner[1])) return false;
    if (scene->mesh != NULL && ty_accel_occluded(scene->mesh, point, wi, marched)) return false;
    const float distance_ratio = distance < TY_FLOAT_MAX ? (distance - marched) / distance : 1.0f;
    out->falloff = distance_ratio * distance_ratio;
    const float falloff = outside ? 1.0f : out->falloff;
    for (int32_t f = 0; f < (light->lobe_order != 0 ? TY_FLUENCE_COUNT : 1); ++f)
        for (int32_t c = 0; c < 3; ++c) out->transmittance[f][c] = falloff * ty_attenuation(depth[f][c]);
    for (int32_t c = 0; c < 3; ++c) out->depth[c] = sums[c];
    out->at = ty_cell_locate(request->light.size, ty_mad(from, cells, marched));
    if (!outside) return true;
    float unattenuated[3];
    ty_near_unattenuated(scene, &light->sample, point, unattenuated);
    ty_near_enter(light, unattenuated, out);
    return true;
}

/* True if attenuation towards a light must be traced at this mean extinction, 1/m. */
TY_FN bool ty_near_is_needed(TY_GLOBAL const ty_march_request* request, float extinction) {
    TY_GLOBAL const ty_scene_view* scene = request->scene;
    const ty_vec per_cell = request->light.per_cell;
    const float coarsest = ty_minf(per_cell.x, ty_minf(per_cell.y, per_cell.z));
    if (extinction > TY_NEAR_MIN_CELL_DEPTH * coarsest) return true;
    if (!(extinction > TY_NEAR_MIN_CELL_DEPTH_TRANSFER * coarsest)) return false;
    for (int32_t m = 0; m < scene->medium_count; ++m)
        if (scene->media[m].transfer != NULL) return true;
    return false;
}

/* Lights [first, end) at a point of the given mean extinction, 1/m. */
TY_FN void ty_near_lookup(TY_GLOBAL const ty_march_request* request, ty_vec point, float extinction, int32_t first,
                          int32_t end, ty_near_light* lights) {
    if (first == end) return;
    const bool traced = ty_near_is_needed(request, extinction);
    for (int32_t i = first; i < end; ++i) {
        TY_GLOBAL const ty_light_fluence* light = &request->lights[i];
        ty_near_light* out = &lights[i - first];
        if (traced && light->kind < TY_FLUENCE_P1 && ty_near_follow(request, light, point, extinction, out)) continue;
        out->at = ty_cell_locate(request->light.size, ty_cell_coordinates(&request->light, point));
        out->falloff = 1.0f;
        for (int32_t c = 0; c < 3; ++c) out->depth[c] = 0.0f;
        for (int32_t f = 0; f < TY_FLUENCE_COUNT; ++f)
            for (int32_t c = 0; c < 3; ++c) out->transmittance[f][c] = 1.0f;
    }
}

#endif
