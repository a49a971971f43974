/* A ray march through the media, front to back, in steps of the lattice's cells: transmittance, emission, and the
 * lattice's light scattered towards the eye. Extinction is exact for any step length, in closed form in homogeneous
 * media and cell by cell in others; the light is looked up at the mean point of a step's visible scattering. */
#ifndef TY_METHOD_LPV_IMAGE_RAY_MARCH_K_H
#define TY_METHOD_LPV_IMAGE_RAY_MARCH_K_H

#include "direct/media/attenuation.k.h"
#include "direct/media/grid_medium.h"
#include "method/lpv/lattice/packed_lattice.k.h"
#include "scene/scene.h"
#include "scene/media/spans.k.h"

/* Transmittance below which a ray march ends. */
#define TY_RAY_MARCH_OPAQUE 1e-5f
/* Length of an unbounded interval, m. */
#define TY_RAY_MARCH_FAR 1e30f

typedef struct ty_ray_march_request {
    const ty_scene_view* scene;
    const ty_grid_medium* medium;       /* heterogeneous media on cells */
    const ty_packed_lattices* lattices; /* NULL: no multiple scattering */
    float step;                         /* cells */
} ty_ray_march_request;

/* The results of a ray march. */
typedef struct ty_ray_march_result {
    float transmittance[3];
    float multiple[3];  /* scattered light of the lattice, W m^-2 sr^-1 */
    float emission[3];  /* emission of the media */
    float scattered[3]; /* fraction of the light that media scatter */
    /* At the end of the ray, to extrapolate to slightly longer or shorter rays: extinction, 1/m, and the derivatives of
     * `multiple` and `scattered` with respect to distance. */
    float extinction[3], multiple_rise[3], scattered_rise[3];
} ty_ray_march_result;

/* Coefficients of the media at a point, 1/m, and their emission per metre. */
typedef struct ty_media_coefficients {
    float extinction[3], scattering[3], forward[3], emission[3]; /* forward: scattering times g */
} ty_media_coefficients;

/* A voxel traversal of a medium's cells. */
typedef struct ty_voxel_walk {
    int32_t cell[3], step[3];
    float next[3], per_cell[3]; /* m along the ray */
    float enter, leave;         /* of the box */
} ty_voxel_walk;

typedef struct ty_ray_march {
    const ty_ray_march_request* request;
    ty_vec origin, direction;
    float enter[TY_LPV_CASCADES_MAX],
        leave[TY_LPV_CASCADES_MAX]; /* interval of the ray in each cascade; empty: enter > leave */
    float offset;
    ty_media_coefficients media; /* of an interval with homogeneous media */
    ty_voxel_walk cells;         /* of an interval with heterogeneous media */
    int32_t heterogeneous;
    /* Of the step: the visible scattering of bands 0 and 1, its sum, and its first moment along the ray (for the lookup
     * point). */
    float isotropic[3], directed[3], amount, moment;
    float sum[TY_PACKED_FLOATS];  /* scattered light of the lattice, per term */
    float last[TY_PACKED_FLOATS]; /* light of the lattice at the last step */
    ty_ray_march_result out;
} ty_ray_march;

/* ---- media ---- */

TY_FN void ty_media_coefficients_add(ty_media_coefficients* media, TY_GLOBAL const ty_medium_view* medium) {
    for (int c = 0; c < 3; ++c) {
        media->extinction[c] += medium->sigma_t[c];
        media->scattering[c] += medium->sigma_s[c];
        media->forward[c] += medium->sigma_s[c] * medium->g[c];
        media->emission[c] += ty_maxf(0.0f, medium->sigma_t[c] - medium->sigma_s[c]) * medium->emission[c];
    }
}

TY_FN void ty_media_coefficients_load(const ty_grid_medium* medium, const int32_t cell[3],
                                      ty_media_coefficients* media) {
    const size_t nx = (size_t)medium->box.size[0], ny = (size_t)medium->box.size[1];
    const size_t at = (size_t)cell[0] + nx * ((size_t)cell[1] + ny * (size_t)cell[2]);
    for (int c = 0; c < 3; ++c) {
        media->extinction[c] = medium->extinction[c][at];
        media->scattering[c] = medium->scattering[c][at];
        media->forward[c] = medium->scattering[c][at] * medium->g[c][at];
        media->emission[c] = medium->emission[0] != NULL ? medium->emission[c][at] * TY_INV_4PI : 0.0f;
    }
}

TY_FN void ty_voxel_walk_axis(const ty_grid_medium* medium, int32_t axis, float origin, float direction, float t,
                              ty_voxel_walk* cells) {
    const float lower = (float)medium->box.lower[axis], side = (float)medium->cell[axis];
    const int32_t last = medium->box.size[axis] - 1;
    const int32_t cell = (int32_t)ty_clampf(floorf((origin + direction * t - lower) / side), 0.0f, (float)last);
    cells->cell[axis] = cell;
    cells->step[axis] = direction > 0.0f ? 1 : -1;
    const float face = lower + side * (float)(direction > 0.0f ? cell + 1 : cell);
    cells->next[axis] = direction != 0.0f ? (face - origin) / direction : TY_FLOAT_MAX;
    cells->per_cell[axis] = direction != 0.0f ? side / fabsf(direction) : TY_FLOAT_MAX;
}

/* Begins the traversal at distance t. */
TY_FN void ty_voxel_walk_begin(const ty_ray_march_request* request, ty_vec origin, ty_vec direction, float t, float end,
                               ty_voxel_walk* cells) {
    const ty_grid_medium* medium = request->medium;
    const ty_vec lower =
        ty_vec_make((float)medium->box.lower[0], (float)medium->box.lower[1], (float)medium->box.lower[2]);
    const ty_vec upper =
        ty_vec_make((float)medium->box.upper[0], (float)medium->box.upper[1], (float)medium->box.upper[2]);
    cells->enter = t;
    cells->leave = end;
    if (!ty_clip_box(origin, direction, lower, upper, &cells->enter, &cells->leave)) {
        cells->enter = cells->leave = end;
        return;
    }
    ty_voxel_walk_axis(medium, 0, origin.x, direction.x, cells->enter, cells);
    ty_voxel_walk_axis(medium, 1, origin.y, direction.y, cells->enter, cells);
    ty_voxel_walk_axis(medium, 2, origin.z, direction.z, cells->enter, cells);
}

/* Advances to the next cell; false outside the box. */
TY_FN bool ty_voxel_walk_advance(const ty_grid_medium* medium, ty_voxel_walk* cells) {
    const int32_t xy = cells->next[0] < cells->next[1] ? 0 : 1;
    const int32_t axis = cells->next[xy] < cells->next[2] ? xy : 2;
    cells->cell[axis] += cells->step[axis];
    cells->next[axis] += cells->per_cell[axis];
    return cells->cell[axis] >= 0 && cells->cell[axis] < medium->box.size[axis];
}

/* ---- steps ---- */

/* Mean depth of the visible scattering in a slab of optical depth x, as a fraction of its length: a rational
 * approximation of 1/x - 1/(e^x - 1). */
TY_FN float ty_ray_march_mean_depth(float x) {
    return (1.0f + 0.1296f * x) / (2.0f + x * (0.5926f + 0.1296f * x));
}

/* Adds an interval of the ray with constant coefficients, from t on. */
TY_FN void ty_ray_march_add_interval(ty_ray_march* ray, const ty_media_coefficients* media, float t, float length) {
    float depth = 0.0f, visible = 0.0f;
    for (int c = 0; c < 3; ++c) {
        const float x = media->extinction[c] * length, decay = ty_attenuation(x);
        const float reach = ray->out.transmittance[c] * length * ty_mean_attenuation(x, decay);
        ray->isotropic[c] += reach * media->scattering[c];
        ray->directed[c] += reach * media->forward[c];
        ray->out.emission[c] += reach * media->emission[c];
        ray->out.scattered[c] += reach * media->scattering[c];
        ray->out.transmittance[c] *= decay;
        depth += x * (1.0f / 3.0f);
        visible += reach * media->scattering[c];
    }
    if (!(visible > 0.0f)) return;
    ray->amount += visible;
    ray->moment += visible * (t + length * ty_ray_march_mean_depth(depth));
}

TY_FN void ty_ray_march_add_voxels(ty_ray_march* ray, float t, float end) {
    const ty_grid_medium* medium = ray->request->medium;
    ty_voxel_walk* cells = &ray->cells;
    t = ty_maxf(t, cells->enter);
    end = ty_minf(end, cells->leave);
    while (t < end) {
        const float face = ty_minf(cells->next[0], ty_minf(cells->next[1], cells->next[2]));
        const float until = ty_minf(end, face);
        ty_media_coefficients media;
        ty_media_coefficients_load(medium, cells->cell, &media);
        if (until > t) ty_ray_march_add_interval(ray, &media, t, until - t);
        t = ty_maxf(t, until);
        if (face <= end && !ty_voxel_walk_advance(medium, cells)) {
            cells->leave = t;
            return;
        }
    }
}

/* The lattice's light at a distance along the ray; level: the finest cascade there. */
TY_FN void ty_ray_march_lookup(const ty_ray_march* ray, float at, int32_t level, float light[TY_PACKED_FLOATS]) {
    const ty_packed_lattices* lattices = ray->request->lattices;
    const ty_packed_lattice* lattice = &lattices->lattices[level];
    const ty_vec point = ty_mad(ray->origin, ray->direction, at);
    ty_packed_cells cells;
    ty_packed_locate(lattice, ty_packed_coordinates(lattice, point), &cells);
    ty_packed_mean(&cells, 0, light);
    if (level + 1 >= lattices->count) return;
    const float finer = ty_clampf(ty_packed_depth(lattice, point), 0.0f, 1.0f);
    if (finer >= 1.0f) return;
    float coarse[TY_PACKED_FLOATS];
    ty_packed_locate(lattice + 1, ty_packed_coordinates(lattice + 1, point), &cells);
    ty_packed_mean(&cells, 0, coarse);
    for (int j = 0; j < TY_PACKED_FLOATS; ++j) light[j] = coarse[j] + finer * (light[j] - coarse[j]);
}

/* A step through heterogeneous media from t to `end`; level: the cascade, -1 for none. */
TY_FN void ty_ray_march_step(ty_ray_march* ray, float t, float end, int32_t level) {
    for (int c = 0; c < 3; ++c) ray->isotropic[c] = ray->directed[c] = 0.0f;
    ray->amount = ray->moment = 0.0f;
    ty_ray_march_add_voxels(ray, t, end);
    if (level < 0 || !(ray->amount > 0.0f)) return;
    ty_ray_march_lookup(ray, ty_clampf(ray->moment / ray->amount, t, end), level, ray->last);
    for (int c = 0; c < 3; ++c) {
        ray->sum[4 * c] += ray->isotropic[c] * ray->last[4 * c];
        for (int i = 1; i < 4; ++i) ray->sum[4 * c + i] += ray->directed[c] * ray->last[4 * c + i];
    }
}

/* A step through homogeneous media: per term, the fraction scattered towards the eye and the transmittance. */
typedef struct ty_homogeneous_step {
    float length, at; /* m; distance of the lookup point from the step's start */
    float scatters[TY_PACKED_FLOATS], passes[TY_PACKED_FLOATS];
} ty_homogeneous_step;

TY_FN void ty_homogeneous_step_make(const ty_media_coefficients* media, float length, ty_homogeneous_step* step) {
    float depth = 0.0f;
    for (int j = 12; j < TY_PACKED_FLOATS; ++j) step->scatters[j] = step->passes[j] = 0.0f;
    for (int c = 0; c < 3; ++c) {
        const float x = media->extinction[c] * length, decay = ty_attenuation(x),
                    reach = length * ty_mean_attenuation(x, decay);
        for (int i = 0; i < 4; ++i) {
            step->scatters[4 * c + i] = reach * (i == 0 ? media->scattering[c] : media->forward[c]);
            step->passes[4 * c + i] = decay;
        }
        depth += x * (1.0f / 3.0f);
    }
    step->length = length;
    step->at = length * ty_ray_march_mean_depth(depth);
}

/* A batch of steps, whose lookup cells are computed together. */
enum { TY_RAY_MARCH_BATCH = 16 };

typedef struct ty_ray_march_batch {
    int32_t count;
    int32_t kind[TY_RAY_MARCH_BATCH];
    float at[TY_RAY_MARCH_BATCH];     /* m along the ray; every entry is finite */
    int32_t base[TY_RAY_MARCH_BATCH]; /* index of the lowest of the eight cells */
    float x[TY_RAY_MARCH_BATCH], y[TY_RAY_MARCH_BATCH], z[TY_RAY_MARCH_BATCH]; /* interpolation fractions */
} ty_ray_march_batch;

TY_FN void ty_ray_march_locate(const ty_packed_lattice* lattice, ty_vec origin, ty_vec direction,
                               ty_ray_march_batch* batch) {
    const ty_vec o = ty_packed_coordinates(lattice, origin), d = ty_scale(direction, lattice->per_metre);
    const int32_t *size = lattice->size, nx = size[0], nxy = size[0] * size[1];
#pragma omp simd
    for (int k = 0; k < TY_RAY_MARCH_BATCH; ++k) {
        const float at = batch->at[k];
        batch->base[k] = ty_packed_axis(o.x + d.x * at, size[0], &batch->x[k]) +
                         nx * ty_packed_axis(o.y + d.y * at, size[1], &batch->y[k]) +
                         nxy * ty_packed_axis(o.z + d.z * at, size[2], &batch->z[k]);
    }
}

/* Lists the next steps up to `end`. There are three kinds: a shortened first step, full steps, and a shortened last
 * step. */
TY_FN float ty_ray_march_list_steps(const ty_ray_march* ray, float t, float end, float step, float* number,
                                    ty_homogeneous_step isotropic[3], ty_ray_march_batch* batch) {
    batch->count = 0;
    while (batch->count < TY_RAY_MARCH_BATCH && t < end) {
        const float until = ty_minf(end, (*number + ray->offset) * step);
        *number += 1.0f;
        if (!(until > t)) continue;
        const int32_t kind = until == end ? 2 : isotropic[0].length > 0.0f ? 1 : 0;
        if (!(isotropic[kind].length > 0.0f)) ty_homogeneous_step_make(&ray->media, until - t, &isotropic[kind]);
        if (kind == 2 && !(isotropic[0].length > 0.0f)) isotropic[0].length = 1.0f;
        batch->kind[batch->count] = kind;
        batch->at[batch->count++] = t + isotropic[kind].at;
        t = until;
    }
    for (int k = batch->count; k < TY_RAY_MARCH_BATCH; ++k) batch->at[k] = t;
    return t;
}

/* Marches from t to end through homogeneous media in one cascade, for the scattered light only. Steps end at fixed
 * distances from the eye, independent of the boundaries between them. */
TY_FN void ty_ray_march_homogeneous(ty_ray_march* ray, float t, float end, int32_t level) {
    const ty_packed_lattice* lattice = &ray->request->lattices->lattices[level];
    const bool blends = level + 1 < ray->request->lattices->count;
    const float step = ray->request->step * lattice->cell;
    float number = floorf(t / step - ray->offset) + 1.0f;
    float passed[TY_PACKED_FLOATS], sum[TY_PACKED_FLOATS], light[TY_PACKED_FLOATS];
    ty_homogeneous_step isotropic[3];
    ty_ray_march_batch batch;
    for (int i = 0; i < 3; ++i) isotropic[i].length = 0.0f;
    for (int j = 0; j < TY_PACKED_FLOATS; ++j) {
        passed[j] = j < 12 ? ray->out.transmittance[j / 4] : 0.0f;
        sum[j] = ray->sum[j];
        light[j] = 0.0f;
    }
    while (t < end && passed[0] + passed[4] + passed[8] > TY_RAY_MARCH_OPAQUE) {
        t = ty_ray_march_list_steps(ray, t, end, step, &number, isotropic, &batch);
        if (!blends) ty_ray_march_locate(lattice, ray->origin, ray->direction, &batch);
        for (int32_t k = 0; k < batch.count; ++k) {
            const ty_homogeneous_step* taken = &isotropic[batch.kind[k]];
            if (blends) {
                ty_ray_march_lookup(ray, batch.at[k], level, light);
            } else {
                ty_packed_cells cells;
                ty_packed_cells_around(lattice, batch.base[k], batch.x[k], batch.y[k], batch.z[k], &cells);
                ty_packed_mean(&cells, 0, light);
            }
#pragma omp simd
            for (int j = 0; j < TY_PACKED_FLOATS; ++j) {
                sum[j] += passed[j] * taken->scatters[j] * light[j];
                passed[j] *= taken->passes[j];
            }
        }
    }
    for (int j = 0; j < TY_PACKED_FLOATS; ++j) {
        ray->sum[j] = sum[j];
        ray->last[j] = light[j];
    }
}

TY_FN bool ty_ray_march_is_opaque(const ty_ray_march_result* result) {
    return result->transmittance[0] < TY_RAY_MARCH_OPAQUE && result->transmittance[1] < TY_RAY_MARCH_OPAQUE &&
           result->transmittance[2] < TY_RAY_MARCH_OPAQUE;
}

/* The finest cascade at t, -1 for none; *end is reduced to where that changes. */
TY_FN int32_t ty_ray_march_cascade(const ty_ray_march* ray, float t, float* end) {
    const int32_t count = ray->request->lattices != NULL ? ray->request->lattices->count : 0;
    for (int32_t i = 0; i < count; ++i) {
        if (!(ray->enter[i] < ray->leave[i]) || ray->leave[i] <= t) continue;
        if (ray->enter[i] <= t) {
            *end = ty_minf(*end, ray->leave[i]);
            return i;
        }
        *end = ty_minf(*end, ray->enter[i]);
    }
    return -1;
}

/* Marches through heterogeneous media; false when the ray is opaque. */
TY_FN bool ty_ray_march_heterogeneous(ty_ray_march* ray, float t, float end, int32_t level) {
    const float step = ray->request->step * ray->request->lattices->lattices[level].cell;
    float number = floorf(t / step - ray->offset) + 1.0f;
    while (t < end) {
        const float until = ty_minf(end, (number + ray->offset) * step);
        number += 1.0f;
        if (until > t) ty_ray_march_step(ray, t, until, level);
        t = ty_maxf(t, until);
        if (ty_ray_march_is_opaque(&ray->out)) return false;
    }
    return true;
}

/* Marches from t to end, where the set of media is constant; false when the ray is opaque. */
TY_FN bool ty_ray_march_interval(ty_ray_march* ray, float t, float end) {
    if (ray->heterogeneous != 0) ty_voxel_walk_begin(ray->request, ray->origin, ray->direction, t, end, &ray->cells);
    while (t < end) {
        float until = end;
        const int32_t level = ty_ray_march_cascade(ray, t, &until);
        for (int j = 0; j < TY_PACKED_FLOATS && level < 0; ++j) ray->last[j] = 0.0f;
        if (ray->heterogeneous == 0) {
            if (level >= 0) ty_ray_march_homogeneous(ray, t, until, level);
            ty_ray_march_add_interval(ray, &ray->media, t, ty_minf(until - t, TY_RAY_MARCH_FAR));
        } else if (level < 0) {
            ty_ray_march_step(ray, t, until, -1);
        } else if (!ty_ray_march_heterogeneous(ray, t, until, level)) {
            return false;
        }
        t = until;
    }
    return !ty_ray_march_is_opaque(&ray->out);
}

/* ---- rays ---- */

/* The media at t; *end is the distance up to which the set of media is constant. False if there are none. */
TY_FN bool ty_ray_march_media_at(ty_ray_march* ray, const ty_spans* spans, float t, float* end) {
    TY_GLOBAL const ty_medium_view* media = ray->request->scene->media;
    bool any = false;
    *end = TY_FLOAT_MAX;
    ray->heterogeneous = 0;
    memset(&ray->media, 0, sizeof ray->media);
    for (int32_t i = 0; i < spans->count; ++i) {
        if (spans->leave[i] <= t) continue;
        *end = ty_minf(*end, spans->enter[i] <= t ? spans->leave[i] : spans->enter[i]);
        if (spans->enter[i] > t) continue;
        any = true;
        ty_media_coefficients_add(&ray->media, &media[spans->medium[i]]);
        if (media[spans->medium[i]].heterogeneous != 0 && ray->request->medium != NULL) ray->heterogeneous = 1;
    }
    return any;
}

TY_FN void ty_ray_march_begin(ty_ray_march* ray, const ty_ray_march_request* request, ty_vec origin, ty_vec direction,
                              float far, float offset) {
    const int32_t count = request->lattices != NULL ? request->lattices->count : 0;
    ray->request = request;
    ray->origin = origin;
    ray->direction = direction;
    ray->offset = offset;
    memset(&ray->out, 0, sizeof ray->out);
    for (int c = 0; c < 3; ++c) ray->out.transmittance[c] = 1.0f;
    for (int j = 0; j < TY_PACKED_FLOATS; ++j) ray->sum[j] = ray->last[j] = 0.0f;
    for (int32_t i = 0; i < count; ++i) {
        ray->enter[i] = 0.0f;
        ray->leave[i] = far;
        if (!ty_clip_box(origin, direction, request->lattices->lattices[i].lower, request->lattices->lattices[i].upper,
                         &ray->enter[i], &ray->leave[i]))
            ray->leave[i] = -1.0f;
    }
}

/* Evaluates the scattered light in the direction against the ray. */
TY_FN void ty_ray_march_gather(ty_ray_march* ray) {
    float y[TY_SH_TERMS];
    ty_sh_at(ty_scale(ray->direction, -1.0f), 2, y);
    for (int c = 0; c < 3; ++c) {
        float sum = 0.0f;
        for (int i = 0; i < 4; ++i) sum += ray->sum[4 * c + i] * y[i];
        ray->out.multiple[c] = ty_maxf(sum, 0.0f);
    }
}

/* The derivatives at the end of a ray that ends inside media. */
TY_FN void ty_ray_march_end(ty_ray_march* ray, float far) {
    float y[TY_SH_TERMS];
    ty_media_coefficients media = ray->media;
    if (ray->heterogeneous != 0) {
        if (ray->cells.leave < far) return;
        /* At a face of the box the traversal may already be past the last cell. */
        const int32_t* size = ray->request->medium->box.size;
        int32_t cell[3];
        for (int a = 0; a < 3; ++a) {
            const int32_t at = ray->cells.cell[a];
            cell[a] = at < 0 ? 0 : at < size[a] ? at : size[a] - 1;
        }
        ty_media_coefficients_load(ray->request->medium, cell, &media);
    }
    ty_sh_at(ty_scale(ray->direction, -1.0f), 2, y);
    for (int c = 0; c < 3; ++c) {
        const float passes = ray->out.transmittance[c];
        float directed = 0.0f;
        for (int i = 1; i < 4; ++i) directed += ray->last[4 * c + i] * y[i];
        ray->out.extinction[c] = media.extinction[c];
        ray->out.scattered_rise[c] = passes * media.scattering[c];
        ray->out.multiple_rise[c] =
            passes * ty_maxf(0.0f, media.scattering[c] * ray->last[4 * c] * y[0] + media.forward[c] * directed);
    }
}

/* Marches along a unit direction up to `far`. offset: end of the first step, (0, 1] of a step. */
TY_FN void ty_ray_march_follow(ty_ray_march* ray, const ty_ray_march_request* request, ty_vec origin, ty_vec direction,
                               float far, float offset) {
    ty_spans spans;
    ty_spans_find(request->scene->media, request->scene->medium_count, origin, direction, far, &spans);
    ty_ray_march_begin(ray, request, origin, direction, far, offset);
    float t = 0.0f, end;
    bool visible = true, inside = false;
    while (visible && t < TY_FLOAT_MAX) {
        const bool any = ty_ray_march_media_at(ray, &spans, t, &end);
        if (any) visible = ty_ray_march_interval(ray, t, end);
        inside = any && end >= far;
        if (inside) break;
        t = end;
    }
    for (int c = 0; c < 3 && !visible; ++c) ray->out.transmittance[c] = 0.0f;
    if (visible && inside && far < TY_FLOAT_MAX) ty_ray_march_end(ray, far);
    ty_ray_march_gather(ray);
}

#endif
