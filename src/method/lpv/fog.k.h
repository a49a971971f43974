/* One ray through the media: front to back, in steps of the lattice's cells; what they let through and send, and what
 * they scatter of the lattice's light. Extinction is exact whatever the steps, for homogeneous media in closed form,
 * for others cell by cell; light is looked up where a step's matter is seen in the mean. */
#ifndef TY_METHOD_LPV_FOG_K_H
#define TY_METHOD_LPV_FOG_K_H

#include "direct/beam.k.h"
#include "direct/grid_medium.h"
#include "method/lpv/look.k.h"
#include "scene/scene.h"
#include "scene/spans.k.h"

/* Transmittance below which a ray ends. */
#define TY_FOG_BLACK 1e-5f
/* Length of what has no end, m. */
#define TY_FOG_FAR 1e30f

typedef struct ty_fog_request {
    const ty_scene_view* scene;
    const ty_grid_medium* medium; /* where media vary */
    const ty_lattice_look* look;  /* NULL: nothing is looked up */
    float step;                   /* cells */
} ty_fog_request;

/* What a ray brings. */
typedef struct ty_fog {
    float transmittance[3];
    float multiple[3];  /* of the lattice's light, W m^-2 sr^-1 */
    float glow[3];      /* that media send themselves */
    float scattered[3]; /* the part of the light that media scatter */
    /* Where the ray ends, for rays that go a little farther or not as far: extinction, 1/m, and how transmittance times
     * what media scatter of the lattice's light, and of all light, rises by the metre. */
    float extinction[3], multiple_rise[3], scattered_rise[3];
} ty_fog;

/* Media at a place: coefficients, 1/m, and radiance that they send per metre. */
typedef struct ty_fog_media {
    float extinction[3], scattering[3], forward[3], glow[3]; /* forward: scattering times mean cosine */
} ty_fog_media;

/* A way through the cells of a medium. */
typedef struct ty_fog_cells {
    int32_t cell[3], step[3];
    float next[3], per_cell[3]; /* m along the ray */
    float enter, leave;         /* of the box */
} ty_fog_cells;

typedef struct ty_fog_ray {
    const ty_fog_request* request;
    ty_vec origin, direction;
    float enter[TY_LPV_CASCADES_MAX], leave[TY_LPV_CASCADES_MAX]; /* of the lattices; nowhere: enter > leave */
    float offset;
    ty_fog_media media; /* of the stretch, where they are homogeneous */
    ty_fog_cells cells; /* of the stretch, where they are not */
    int32_t heterogeneous;
    /* Of the step: what its media scatter, times how much of it is seen, and the same along the ray (for where light is
     * looked up). */
    float even[3], directed[3], amount, moment;
    float sum[TY_LOOK_FLOATS];  /* of the lattice's light, band by band as it is scattered */
    float last[TY_LOOK_FLOATS]; /* of the last step's, not yet scattered */
    ty_fog out;
} ty_fog_ray;

/* ---- media ---- */

TY_FN void ty_fog_add_medium(ty_fog_media* media, TY_GLOBAL const ty_medium_view* medium) {
    for (int c = 0; c < 3; ++c) {
        media->extinction[c] += medium->sigma_t[c];
        media->scattering[c] += medium->sigma_s[c];
        media->forward[c] += medium->sigma_s[c] * medium->g[c];
        media->glow[c] += ty_maxf(0.0f, medium->sigma_t[c] - medium->sigma_s[c]) * medium->emission[c];
    }
}

TY_FN void ty_fog_load(const ty_grid_medium* medium, const int32_t cell[3], ty_fog_media* media) {
    const size_t nx = (size_t)medium->box.size[0], ny = (size_t)medium->box.size[1];
    const size_t at = (size_t)cell[0] + nx * ((size_t)cell[1] + ny * (size_t)cell[2]);
    for (int c = 0; c < 3; ++c) {
        media->extinction[c] = medium->extinction[c][at];
        media->scattering[c] = medium->scattering[c][at];
        media->forward[c] = medium->scattering[c][at] * medium->g[c][at];
        media->glow[c] = medium->emission[0] != NULL ? medium->emission[c][at] * TY_INV_4PI : 0.0f;
    }
}

TY_FN void ty_fog_cells_axis(const ty_grid_medium* medium, int32_t axis, float origin, float direction, float t,
                             ty_fog_cells* cells) {
    const float lower = (float)medium->box.lower[axis], side = (float)medium->cell[axis];
    const int32_t last = medium->box.size[axis] - 1;
    const int32_t cell = (int32_t)ty_clampf(floorf((origin + direction * t - lower) / side), 0.0f, (float)last);
    cells->cell[axis] = cell;
    cells->step[axis] = direction > 0.0f ? 1 : -1;
    const float face = lower + side * (float)(direction > 0.0f ? cell + 1 : cell);
    cells->next[axis] = direction != 0.0f ? (face - origin) / direction : TY_FLOAT_MAX;
    cells->per_cell[axis] = direction != 0.0f ? side / fabsf(direction) : TY_FLOAT_MAX;
}

/* The cells from t on. */
TY_FN void ty_fog_cells_begin(const ty_fog_request* request, ty_vec origin, ty_vec direction, float t, float end,
                              ty_fog_cells* cells) {
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
    ty_fog_cells_axis(medium, 0, origin.x, direction.x, cells->enter, cells);
    ty_fog_cells_axis(medium, 1, origin.y, direction.y, cells->enter, cells);
    ty_fog_cells_axis(medium, 2, origin.z, direction.z, cells->enter, cells);
}

/* Goes on to the next cell; false past the box. */
TY_FN bool ty_fog_cells_advance(const ty_grid_medium* medium, ty_fog_cells* cells) {
    const int32_t xy = cells->next[0] < cells->next[1] ? 0 : 1;
    const int32_t axis = cells->next[xy] < cells->next[2] ? xy : 2;
    cells->cell[axis] += cells->step[axis];
    cells->next[axis] += cells->per_cell[axis];
    return cells->cell[axis] >= 0 && cells->cell[axis] < medium->box.size[axis];
}

/* ---- steps ---- */

/* Where the light of a slab of optical depth x comes from in the mean, of its length: 1/x - 1/(e^x - 1), nearly. */
TY_FN float ty_fog_middle(float x) {
    return (1.0f + 0.1296f * x) / (2.0f + x * (0.5926f + 0.1296f * x));
}

/* Takes a piece of the ray, from t on, within which media are alike. */
TY_FN void ty_fog_take(ty_fog_ray* ray, const ty_fog_media* media, float t, float length) {
    float depth = 0.0f, seen = 0.0f;
    for (int c = 0; c < 3; ++c) {
        const float x = media->extinction[c] * length, decay = ty_decay(x);
        const float reach = ray->out.transmittance[c] * length * ty_mean_decay(x, decay);
        ray->even[c] += reach * media->scattering[c];
        ray->directed[c] += reach * media->forward[c];
        ray->out.glow[c] += reach * media->glow[c];
        ray->out.scattered[c] += reach * media->scattering[c];
        ray->out.transmittance[c] *= decay;
        depth += x * (1.0f / 3.0f);
        seen += reach * media->scattering[c];
    }
    if (!(seen > 0.0f)) return;
    ray->amount += seen;
    ray->moment += seen * (t + length * ty_fog_middle(depth));
}

TY_FN void ty_fog_take_cells(ty_fog_ray* ray, float t, float end) {
    const ty_grid_medium* medium = ray->request->medium;
    ty_fog_cells* cells = &ray->cells;
    t = ty_maxf(t, cells->enter);
    end = ty_minf(end, cells->leave);
    while (t < end) {
        const float face = ty_minf(cells->next[0], ty_minf(cells->next[1], cells->next[2]));
        const float until = ty_minf(end, face);
        ty_fog_media media;
        ty_fog_load(medium, cells->cell, &media);
        if (until > t) ty_fog_take(ray, &media, t, until - t);
        t = ty_maxf(t, until);
        if (face <= end && !ty_fog_cells_advance(medium, cells)) {
            cells->leave = t;
            return;
        }
    }
}

/* The lattice's light at a distance along the ray; level: of the finest lattice there. */
TY_FN void ty_fog_look(const ty_fog_ray* ray, float at, int32_t level, float light[TY_LOOK_FLOATS]) {
    const ty_lattice_look* look = ray->request->look;
    const ty_look_lattice* lattice = &look->lattices[level];
    const ty_vec point = ty_mad(ray->origin, ray->direction, at);
    ty_look_cells cells;
    ty_look_locate(lattice, ty_look_place_in(lattice, point), &cells);
    ty_look_mean(&cells, 0, light);
    if (level + 1 >= look->count) return;
    const float finer = ty_clampf(ty_look_depth(lattice, point), 0.0f, 1.0f);
    if (finer >= 1.0f) return;
    float coarse[TY_LOOK_FLOATS];
    ty_look_locate(lattice + 1, ty_look_place_in(lattice + 1, point), &cells);
    ty_look_mean(&cells, 0, coarse);
    for (int j = 0; j < TY_LOOK_FLOATS; ++j) light[j] = coarse[j] + finer * (light[j] - coarse[j]);
}

/* A step through media that vary, from t to `end`, in a lattice or (-1) in none. */
TY_FN void ty_fog_step(ty_fog_ray* ray, float t, float end, int32_t level) {
    for (int c = 0; c < 3; ++c) ray->even[c] = ray->directed[c] = 0.0f;
    ray->amount = ray->moment = 0.0f;
    ty_fog_take_cells(ray, t, end);
    if (level < 0 || !(ray->amount > 0.0f)) return;
    ty_fog_look(ray, ty_clampf(ray->moment / ray->amount, t, end), level, ray->last);
    for (int c = 0; c < 3; ++c) {
        ray->sum[4 * c] += ray->even[c] * ray->last[4 * c];
        for (int i = 1; i < 4; ++i) ray->sum[4 * c + i] += ray->directed[c] * ray->last[4 * c + i];
    }
}

/* A step through homogeneous media: of light, term by term, what is scattered of it, and what passes. */
typedef struct ty_fog_even {
    float length, at; /* m; where it is looked up, from the step's start */
    float scatters[TY_LOOK_FLOATS], passes[TY_LOOK_FLOATS];
} ty_fog_even;

TY_FN void ty_fog_even_make(const ty_fog_media* media, float length, ty_fog_even* step) {
    float depth = 0.0f;
    for (int j = 12; j < TY_LOOK_FLOATS; ++j) step->scatters[j] = step->passes[j] = 0.0f;
    for (int c = 0; c < 3; ++c) {
        const float x = media->extinction[c] * length, decay = ty_decay(x), reach = length * ty_mean_decay(x, decay);
        for (int i = 0; i < 4; ++i) {
            step->scatters[4 * c + i] = reach * (i == 0 ? media->scattering[c] : media->forward[c]);
            step->passes[4 * c + i] = decay;
        }
        depth += x * (1.0f / 3.0f);
    }
    step->length = length;
    step->at = length * ty_fog_middle(depth);
}

/* Steps of a ray together, so that where they look is found for many at a time. */
enum { TY_FOG_BATCH = 16 };

typedef struct ty_fog_batch {
    int32_t count;
    int32_t kind[TY_FOG_BATCH];
    float at[TY_FOG_BATCH];                                  /* m along the ray; all are numbers */
    int32_t base[TY_FOG_BATCH];                              /* the lowest of the eight cells */
    float x[TY_FOG_BATCH], y[TY_FOG_BATCH], z[TY_FOG_BATCH]; /* how far on the place is towards the others */
} ty_fog_batch;

TY_FN void ty_fog_locate(const ty_look_lattice* lattice, ty_vec origin, ty_vec direction, ty_fog_batch* batch) {
    const ty_vec o = ty_look_place_in(lattice, origin), d = ty_scale(direction, lattice->per_metre);
    const int32_t *size = lattice->size, nx = size[0], nxy = size[0] * size[1];
#pragma omp simd
    for (int k = 0; k < TY_FOG_BATCH; ++k) {
        const float at = batch->at[k];
        batch->base[k] = ty_look_axis(o.x + d.x * at, size[0], &batch->x[k]) +
                         nx * ty_look_axis(o.y + d.y * at, size[1], &batch->y[k]) +
                         nxy * ty_look_axis(o.z + d.z * at, size[2], &batch->z[k]);
    }
}

/* The next steps up to `end`, of three kinds: the first one is cut short in front, the last one behind. */
TY_FN float ty_fog_list(const ty_fog_ray* ray, float t, float end, float step, float* number, ty_fog_even even[3],
                        ty_fog_batch* batch) {
    batch->count = 0;
    while (batch->count < TY_FOG_BATCH && t < end) {
        const float until = ty_minf(end, (*number + ray->offset) * step);
        *number += 1.0f;
        if (!(until > t)) continue;
        const int32_t kind = until == end ? 2 : even[0].length > 0.0f ? 1 : 0;
        if (!(even[kind].length > 0.0f)) ty_fog_even_make(&ray->media, until - t, &even[kind]);
        if (kind == 2 && !(even[0].length > 0.0f)) even[0].length = 1.0f;
        batch->kind[batch->count] = kind;
        batch->at[batch->count++] = t + even[kind].at;
        t = until;
    }
    for (int k = batch->count; k < TY_FOG_BATCH; ++k) batch->at[k] = t;
    return t;
}

/* Goes from t to end through homogeneous media in one lattice: light alone, with the transmittance step by step. Steps
 * end at the same distances from the eye whatever begins or ends between them. */
TY_FN void ty_fog_walk_even(ty_fog_ray* ray, float t, float end, int32_t level) {
    const ty_look_lattice* lattice = &ray->request->look->lattices[level];
    const bool blends = level + 1 < ray->request->look->count;
    const float step = ray->request->step * lattice->cell;
    float number = floorf(t / step - ray->offset) + 1.0f;
    float passed[TY_LOOK_FLOATS], sum[TY_LOOK_FLOATS], light[TY_LOOK_FLOATS];
    ty_fog_even even[3];
    ty_fog_batch batch;
    for (int i = 0; i < 3; ++i) even[i].length = 0.0f;
    for (int j = 0; j < TY_LOOK_FLOATS; ++j) {
        passed[j] = j < 12 ? ray->out.transmittance[j / 4] : 0.0f;
        sum[j] = ray->sum[j];
        light[j] = 0.0f;
    }
    while (t < end && passed[0] + passed[4] + passed[8] > TY_FOG_BLACK) {
        t = ty_fog_list(ray, t, end, step, &number, even, &batch);
        if (!blends) ty_fog_locate(lattice, ray->origin, ray->direction, &batch);
        for (int32_t k = 0; k < batch.count; ++k) {
            const ty_fog_even* taken = &even[batch.kind[k]];
            if (blends) {
                ty_fog_look(ray, batch.at[k], level, light);
            } else {
                ty_look_cells cells;
                ty_look_around(lattice, batch.base[k], batch.x[k], batch.y[k], batch.z[k], &cells);
                ty_look_mean(&cells, 0, light);
            }
#pragma omp simd
            for (int j = 0; j < TY_LOOK_FLOATS; ++j) {
                sum[j] += passed[j] * taken->scatters[j] * light[j];
                passed[j] *= taken->passes[j];
            }
        }
    }
    for (int j = 0; j < TY_LOOK_FLOATS; ++j) {
        ray->sum[j] = sum[j];
        ray->last[j] = light[j];
    }
}

TY_FN bool ty_fog_is_black(const ty_fog* fog) {
    return fog->transmittance[0] < TY_FOG_BLACK && fog->transmittance[1] < TY_FOG_BLACK &&
           fog->transmittance[2] < TY_FOG_BLACK;
}

/* The finest lattice from t on, -1: none, and up to where it is that. */
TY_FN int32_t ty_fog_level(const ty_fog_ray* ray, float t, float* end) {
    const int32_t count = ray->request->look != NULL ? ray->request->look->count : 0;
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

/* The same through media that vary; false when nothing behind is seen. */
TY_FN bool ty_fog_walk(ty_fog_ray* ray, float t, float end, int32_t level) {
    const float step = ray->request->step * ray->request->look->lattices[level].cell;
    float number = floorf(t / step - ray->offset) + 1.0f;
    while (t < end) {
        const float until = ty_minf(end, (number + ray->offset) * step);
        number += 1.0f;
        if (until > t) ty_fog_step(ray, t, until, level);
        t = ty_maxf(t, until);
        if (ty_fog_is_black(&ray->out)) return false;
    }
    return true;
}

/* From t to end, within which the same media are there; false when nothing behind is seen. */
TY_FN bool ty_fog_stretch(ty_fog_ray* ray, float t, float end) {
    if (ray->heterogeneous != 0) ty_fog_cells_begin(ray->request, ray->origin, ray->direction, t, end, &ray->cells);
    while (t < end) {
        float until = end;
        const int32_t level = ty_fog_level(ray, t, &until);
        for (int j = 0; j < TY_LOOK_FLOATS && level < 0; ++j) ray->last[j] = 0.0f;
        if (ray->heterogeneous == 0) {
            if (level >= 0) ty_fog_walk_even(ray, t, until, level);
            ty_fog_take(ray, &ray->media, t, ty_minf(until - t, TY_FOG_FAR));
        } else if (level < 0) {
            ty_fog_step(ray, t, until, -1);
        } else if (!ty_fog_walk(ray, t, until, level)) {
            return false;
        }
        t = until;
    }
    return !ty_fog_is_black(&ray->out);
}

/* ---- rays ---- */

/* The media at t, and up to where no other comes and none of them ends; false: there is none. */
TY_FN bool ty_fog_activate(ty_fog_ray* ray, const ty_spans* spans, float t, float* end) {
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
        ty_fog_add_medium(&ray->media, &media[spans->medium[i]]);
        if (media[spans->medium[i]].heterogeneous != 0 && ray->request->medium != NULL) ray->heterogeneous = 1;
    }
    return any;
}

TY_FN void ty_fog_begin(ty_fog_ray* ray, const ty_fog_request* request, ty_vec origin, ty_vec direction, float far,
                        float offset) {
    const int32_t count = request->look != NULL ? request->look->count : 0;
    ray->request = request;
    ray->origin = origin;
    ray->direction = direction;
    ray->offset = offset;
    memset(&ray->out, 0, sizeof ray->out);
    for (int c = 0; c < 3; ++c) ray->out.transmittance[c] = 1.0f;
    for (int j = 0; j < TY_LOOK_FLOATS; ++j) ray->sum[j] = ray->last[j] = 0.0f;
    for (int32_t i = 0; i < count; ++i) {
        ray->enter[i] = 0.0f;
        ray->leave[i] = far;
        if (!ty_clip_box(origin, direction, request->look->lattices[i].lower, request->look->lattices[i].upper,
                         &ray->enter[i], &ray->leave[i]))
            ray->leave[i] = -1.0f;
    }
}

/* What the lattice's light brings: it travels against the ray. */
TY_FN void ty_fog_gather(ty_fog_ray* ray) {
    float y[TY_SH_TERMS];
    ty_sh_at(ty_scale(ray->direction, -1.0f), 2, y);
    for (int c = 0; c < 3; ++c) {
        float sum = 0.0f;
        for (int i = 0; i < 4; ++i) sum += ray->sum[4 * c + i] * y[i];
        ray->out.multiple[c] = ty_maxf(sum, 0.0f);
    }
}

/* What the ray ends in, if it ends within media. */
TY_FN void ty_fog_end(ty_fog_ray* ray, float far) {
    float y[TY_SH_TERMS];
    ty_fog_media media = ray->media;
    if (ray->heterogeneous != 0) {
        if (ray->cells.leave < far) return;
        /* Where the box's side is what the ray ends at, the cell behind it may have been the next. */
        const int32_t* size = ray->request->medium->box.size;
        int32_t cell[3];
        for (int a = 0; a < 3; ++a) {
            const int32_t at = ray->cells.cell[a];
            cell[a] = at < 0 ? 0 : at < size[a] ? at : size[a] - 1;
        }
        ty_fog_load(ray->request->medium, cell, &media);
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

/* Follows a ray with a unit direction as far as `far`. offset: where its first step ends, (0, 1] of a step. */
TY_FN void ty_fog_follow(ty_fog_ray* ray, const ty_fog_request* request, ty_vec origin, ty_vec direction, float far,
                         float offset) {
    ty_spans spans;
    ty_spans_find(request->scene->media, request->scene->medium_count, origin, direction, far, &spans);
    ty_fog_begin(ray, request, origin, direction, far, offset);
    float t = 0.0f, end;
    bool seen = true, inside = false;
    while (seen && t < TY_FLOAT_MAX) {
        const bool any = ty_fog_activate(ray, &spans, t, &end);
        if (any) seen = ty_fog_stretch(ray, t, end);
        inside = any && end >= far;
        if (inside) break;
        t = end;
    }
    for (int c = 0; c < 3 && !seen; ++c) ray->out.transmittance[c] = 0.0f;
    if (seen && inside && far < TY_FLOAT_MAX) ty_fog_end(ray, far);
    ty_fog_gather(ray);
}

#endif
