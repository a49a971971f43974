/* Media along a ray as the marcher meets them: stretches that hold matter, and in them the density, voxel by voxel. */
#ifndef TY_IMAGE_TRACK_K_H
#define TY_IMAGE_TRACK_K_H

#include "scene/spans.k.h"

/* Pieces of a ray that are looked at side by side, and parts of those in which a transfer function has a point. */
enum { TY_TRACK_PIECES = 16, TY_TRACK_PARTS = 4 };

/* A medium on a stretch of the ray. */
typedef struct ty_track {
    TY_GLOBAL const ty_medium_view* medium;
    ty_bricks bricks;   /* also the ray in the grid's index space */
    float enter, leave; /* matter without a gap, m along the ray: where the ray is, or what it comes to next */
    float ahead_enter, ahead_leave;
    int32_t ahead; /* whether there is more behind a gap */
    float step;    /* how far apart light is looked up, m */
    float live;    /* extinction at density 1 of the channel that counts most, 1/m */
    float mean;    /* of the channels */
    float taken_amount,
        taken_moment; /* integrals over the step of the density, and of it times the way from its start */

    int32_t cell[3]; /* the lowest of the eight voxels around the ray */
    float next[3];   /* where the ray leaves them along each axis */
    float inverse[3];
    float cell_leave;
    int32_t apart; /* whether pieces need care: voxels outside the grid, or not floats */

    /* Piece by piece. */
    float low[3][TY_TRACK_PIECES];     /* cell */
    int32_t at[TY_TRACK_PIECES];       /* the same in memory, from the first piece's on */
    float density[3][TY_TRACK_PIECES]; /* at the start, at the end, and a middle for which Simpson's rule is exact */
    float amount[TY_TRACK_PIECES], moment[TY_TRACK_PIECES]; /* integrals, the way being from the piece's start */
} ty_track;

/* ---- stretches ---- */

/* Joins bricks that follow one another. */
TY_FN void ty_track_next_run(ty_track* track) {
    track->enter = track->ahead != 0 ? track->ahead_enter : TY_FLOAT_MAX;
    track->leave = track->ahead != 0 ? track->ahead_leave : TY_FLOAT_MAX;
    while (track->ahead != 0) {
        track->ahead = ty_bricks_next(&track->bricks) ? 1 : 0;
        track->ahead_enter = track->bricks.enter;
        track->ahead_leave = track->bricks.leave;
        if (track->ahead == 0 || track->ahead_enter > track->leave) break;
        track->leave = track->ahead_leave;
    }
}

TY_FN float ty_track_per_metre(TY_GLOBAL const float to_index[12], ty_vec direction) {
    const ty_vec d = ty_map_direction(to_index, direction);
    return sqrtf(ty_dot(d, d));
}

/* Voxels per metre along the ray of what varies beside the density; 0 if nothing does. */
TY_FN float ty_track_colors_per_metre(TY_GLOBAL const ty_medium_view* medium, ty_vec direction) {
    float most = 0.0f;
    for (int32_t i = 0; i < medium->albedo_fields; ++i)
        most = ty_maxf(most, ty_track_per_metre(medium->albedo[i].to_index, direction));
    if (medium->has_g_field != 0) most = ty_maxf(most, ty_track_per_metre(medium->g_field.to_index, direction));
    if (medium->has_temperature != 0) most = ty_maxf(most, ty_track_per_metre(medium->temperature.to_index, direction));
    if (medium->transfer_albedo != 0) most = ty_maxf(most, ty_track_per_metre(medium->to_index, direction));
    return most;
}

/* light_per_metre: cells per metre along the ray that light changes over, 0 if it does not. */
TY_FN float ty_track_step(TY_GLOBAL const ty_medium_view* medium, ty_vec direction, float light_per_metre) {
    float per_metre = light_per_metre;
    if (medium->has_grid != 0) {
        const float voxels = ty_track_per_metre(medium->to_index, direction);
        per_metre = light_per_metre > 0.0f ? ty_minf(voxels, light_per_metre) : voxels;
    }
    per_metre = ty_maxf(per_metre, ty_track_colors_per_metre(medium, direction));
    return per_metre > 0.0f ? 1.0f / per_metre : TY_FLOAT_MAX;
}

TY_FN void ty_track_begin(ty_track* track, TY_GLOBAL const ty_medium_view* medium, ty_vec origin, ty_vec direction,
                          float enter, float leave) {
    track->medium = medium;
    track->live = medium->sigma_t_max;
    track->mean = (medium->sigma_t[0] + medium->sigma_t[1] + medium->sigma_t[2]) * (1.0f / 3.0f);
    track->taken_amount = track->taken_moment = 0.0f;
    ty_bricks_begin(&track->bricks, medium, origin, direction, enter, leave);
    track->ahead = ty_bricks_next(&track->bricks) ? 1 : 0;
    track->ahead_enter = track->bricks.enter;
    track->ahead_leave = track->bricks.leave;
    ty_track_next_run(track);
}

/* ---- voxels ---- */

/* Voxels that one memory address tells apart from the first piece's. */
enum { TY_TRACK_PLANE_MAX = 1 << 26 };

TY_FN void ty_track_face(ty_track* track, int32_t axis, float origin, float direction) {
    const int32_t face = track->cell[axis] + (direction > 0.0f ? 1 : 0);
    track->next[axis] = direction != 0.0f ? ((float)face - origin) * track->inverse[axis] : TY_FLOAT_MAX;
}

TY_FN void ty_track_find_axis(ty_track* track, int32_t axis, float origin, float direction, float t) {
    track->cell[axis] = (int32_t)floorf(origin + direction * t);
    track->inverse[axis] = direction != 0.0f ? 1.0f / direction : 0.0f;
    ty_track_face(track, axis, origin, direction);
}

TY_FN void ty_track_leave(ty_track* track) {
    track->cell_leave = ty_minf(track->next[0], ty_minf(track->next[1], track->next[2]));
}

/* At the start of a stretch. */
TY_FN void ty_track_find(ty_track* track, float t) {
    track->cell_leave = TY_FLOAT_MAX;
    if (track->medium->has_grid == 0) return;
    const ty_bricks* b = &track->bricks;
    ty_track_find_axis(track, 0, b->origin.x, b->direction.x, t);
    ty_track_find_axis(track, 1, b->origin.y, b->direction.y, t);
    ty_track_find_axis(track, 2, b->origin.z, b->direction.z, t);
    ty_track_leave(track);
}

/* On to the voxels around t, where the ray has left those that it was between. */
TY_FN void ty_track_advance(ty_track* track, float t) {
    const ty_bricks* b = &track->bricks;
    const float origin[3] = {b->origin.x, b->origin.y, b->origin.z};
    const float direction[3] = {b->direction.x, b->direction.y, b->direction.z};
    while (track->cell_leave <= t) {
        const int32_t xy = track->next[0] < track->next[1] ? 0 : 1;
        const int32_t axis = track->next[xy] < track->next[2] ? xy : 2;
        track->cell[axis] += direction[axis] > 0.0f ? 1 : -1;
        ty_track_face(track, axis, origin[axis], direction[axis]);
        ty_track_leave(track);
    }
}

/* Notes the voxels of piece i. */
TY_FN void ty_track_note(ty_track* track, int32_t i) {
    TY_GLOBAL const ty_grid_view* grid = &track->medium->grid;
    const int32_t *cell = track->cell, *size = grid->size;
    if (i == 0) track->apart = grid->floats == NULL || (int64_t)size[0] * size[1] > TY_TRACK_PLANE_MAX;
    const bool inside = (uint32_t)cell[0] < (uint32_t)(size[0] - 1) && (uint32_t)cell[1] < (uint32_t)(size[1] - 1) &&
                        (uint32_t)cell[2] < (uint32_t)(size[2] - 1);
    track->apart |= inside ? 0 : 1;
    for (int a = 0; a < 3; ++a) track->low[a][i] = (float)cell[a];
}

/* ---- pieces ---- */

/* The eight voxels of every piece, x fastest. */
TY_FN void ty_track_fetch(ty_track* track, int32_t count, float corner[8][TY_TRACK_PIECES]) {
    TY_GLOBAL const ty_grid_view* grid = &track->medium->grid;
    if (track->apart != 0) {
        for (int32_t i = 0; i < count; ++i)
            for (int k = 0; k < 8; ++k)
                corner[k][i] =
                    ty_grid_fetch(grid, (int32_t)track->low[0][i] + (k & 1), (int32_t)track->low[1][i] + (k >> 1 & 1),
                                  (int32_t)track->low[2][i] + (k >> 2));
        return;
    }
    const int32_t row = grid->size[0], plane = row * grid->size[1];
    const float first[3] = {track->low[0][0], track->low[1][0], track->low[2][0]};
    TY_GLOBAL const float* base =
        grid->floats + ((size_t)first[0] + (size_t)row * (size_t)first[1] + (size_t)plane * (size_t)first[2]);
    for (int32_t i = 0; i < TY_TRACK_PIECES; ++i)
        track->at[i] = (int32_t)(track->low[0][i] - first[0]) + row * (int32_t)(track->low[1][i] - first[1]) +
                       plane * (int32_t)(track->low[2][i] - first[2]);
    for (int k = 0; k < 8; ++k) {
        TY_GLOBAL const float* from = base + ((k & 1) + (k >> 1 & 1) * row) + (size_t)(k >> 2) * (size_t)plane;
        float* to = corner[k];
#pragma omp simd
        for (int32_t i = 0; i < TY_TRACK_PIECES; ++i) to[i] = from[track->at[i]];
    }
}

/* The grid's value at a place within every piece: 0 its start, 1 its end. */
TY_FN void ty_track_values(const ty_track* track, const float* time, float place, float corner[8][TY_TRACK_PIECES],
                           float* values) {
    const ty_vec o = track->bricks.origin, d = track->bricks.direction;
#pragma omp simd
    for (int32_t i = 0; i < TY_TRACK_PIECES; ++i) {
        const float t = time[i] + place * (time[i + 1] - time[i]);
        const float x = o.x + d.x * t - track->low[0][i];
        const float y = o.y + d.y * t - track->low[1][i];
        const float z = o.z + d.z * t - track->low[2][i];
        const float low = ty_lerpf(ty_lerpf(corner[0][i], corner[1][i], x), ty_lerpf(corner[2][i], corner[3][i], x), y);
        const float high =
            ty_lerpf(ty_lerpf(corner[4][i], corner[5][i], x), ty_lerpf(corner[6][i], corner[7][i], x), y);
        values[i] = ty_lerpf(low, high, z);
    }
}

/* Whether the transfer function has a point within the range of a piece's voxels. */
TY_FN bool ty_track_bends(TY_GLOBAL const ty_medium_view* medium, float corner[8][TY_TRACK_PIECES], int32_t i) {
    float low = corner[0][i], high = corner[0][i];
    for (int k = 1; k < 8; ++k) {
        low = ty_minf(low, corner[k][i]);
        high = ty_maxf(high, corner[k][i]);
    }
    for (int32_t p = 0; p < medium->transfer_count; ++p)
        if (medium->transfer[p].value > low && medium->transfer[p].value < high) return true;
    return false;
}

/* Densities from values; pieces that the transfer function bends get Simpson's rule part by part, and a middle with
 * which one part gives the same. */
TY_FN void ty_track_transfer(ty_track* track, const float* time, int32_t count, float corner[8][TY_TRACK_PIECES]) {
    TY_GLOBAL const ty_medium_view* medium = track->medium;
    float inner[2 * TY_TRACK_PARTS - 1][TY_TRACK_PIECES];
    bool bends = false;
    for (int32_t i = 0; i < count; ++i) bends = bends || ty_track_bends(medium, corner, i);
    for (int n = 0; n < 3; ++n)
        for (int32_t i = 0; i < count; ++i)
            track->density[n][i] = ty_transfer_density(medium->transfer, medium->transfer_count, track->density[n][i]);
    if (!bends) return;
    for (int n = 0; n < 2 * TY_TRACK_PARTS - 1; ++n)
        ty_track_values(track, time, (float)(n + 1) / (2 * TY_TRACK_PARTS), corner, inner[n]);
    for (int32_t i = 0; i < count; ++i) {
        float sum = 0.0f;
        const float sides = track->density[0][i] + track->density[1][i];
        for (int n = 0; n < 2 * TY_TRACK_PARTS - 1; ++n)
            sum +=
                (n % 2 == 0 ? 4.0f : 2.0f) * ty_transfer_density(medium->transfer, medium->transfer_count, inner[n][i]);
        track->density[2][i] = 0.25f * ((sum + sides) * (1.0f / TY_TRACK_PARTS) - sides);
    }
}

/* Looks at pieces time[0] to time[1] and so on, between whose ends no voxels are left. Along a ray a trilinear density
 * is a cubic, for which Simpson's rule is exact. Times past `count` are there, and whatever they are. */
TY_FN void ty_track_look(ty_track* track, const float* time, int32_t count) {
    float corner[8][TY_TRACK_PIECES];
    float *first = track->density[0], *last = track->density[1], *middle = track->density[2];
    if (track->medium->has_grid == 0) {
        for (int32_t i = 0; i < count; ++i) first[i] = last[i] = middle[i] = 1.0f;
    } else {
        for (int a = 0; a < 3; ++a)
            for (int32_t i = count; i < TY_TRACK_PIECES; ++i) track->low[a][i] = track->low[a][count - 1];
        ty_track_fetch(track, count, corner);
        ty_track_values(track, time, 0.0f, corner, first);
        ty_track_values(track, time, 1.0f, corner, last);
        ty_track_values(track, time, 0.5f, corner, middle);
        if (track->medium->transfer != NULL) {
            ty_track_transfer(track, time, count, corner);
        } else {
            for (int n = 0; n < 3; ++n)
                for (int32_t i = 0; i < TY_TRACK_PIECES; ++i)
                    track->density[n][i] = ty_maxf(0.0f, track->density[n][i]);
        }
    }
#pragma omp simd
    for (int32_t i = 0; i < TY_TRACK_PIECES; ++i) {
        const float length = time[i + 1] - time[i];
        track->amount[i] = (first[i] + 4.0f * middle[i] + last[i]) * length * (1.0f / 6.0f);
        track->moment[i] = (2.0f * middle[i] + last[i]) * length * length * (1.0f / 6.0f);
    }
}

/* The same of the part of piece i between shares u and v of it, taking its density as the parabola that Simpson's rule
 * takes it as: parts add up to the whole. */
TY_FN void ty_track_part(const ty_track* track, int32_t i, float length, float u, float v, float* amount,
                         float* moment) {
    if (u <= 0.0f && v >= 1.0f) {
        *amount = track->amount[i];
        *moment = track->moment[i];
        return;
    }
    const float first = track->density[0][i], last = track->density[1][i], middle = track->density[2][i];
    const float slope = 4.0f * middle - 3.0f * first - last, bend = 2.0f * (first + last) - 4.0f * middle;
    const float w = 0.5f * (u + v), part = (v - u) * length * (1.0f / 6.0f);
    const float at_u = first + u * (slope + u * bend), at_v = first + v * (slope + v * bend);
    const float at_w = first + w * (slope + w * bend);
    *amount = (at_u + 4.0f * at_w + at_v) * part;
    *moment = (at_u * u + 4.0f * at_w * w + at_v * v) * part * length;
}

#endif
