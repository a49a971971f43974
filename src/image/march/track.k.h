/* A medium along a ray: intervals with density, and the density in them, voxel by voxel. */
#ifndef TY_IMAGE_TRACK_K_H
#define TY_IMAGE_TRACK_K_H

#include "image/march/voxel.k.h"

/* Subdivisions of a piece that contains a point of a transfer function. */
enum { TY_TRACK_KINK_PIECES = 4 };

/* Steps per voxel of a temperature field, and per voxel where transfer functions make edges. */
#define TY_TRACK_TEMPERATURE_STEPS 4.0f
#define TY_TRACK_TRANSFER_STEPS 2.0f

/* Relative growth of steps with opacity: of voxel-sized steps, which are finer than scattered light, and of other
 * steps. */
#define TY_TRACK_GROWTH_VOXELS 4.0f
#define TY_TRACK_GROWTH_CELLS 1.0f

/* A medium on an interval of the ray. */
typedef struct ty_track {
    TY_GLOBAL const ty_medium_view* medium;
    ty_majorant_dda bricks; /* also the ray in the grid's index space */
    float enter, leave;     /* current or next interval of non-zero density, m along the ray */
    float next_enter, next_leave;
    int32_t has_next; /* 1: another interval follows */
    int32_t cell[3];  /* lowest of the eight voxels around the ray */
    float next[3];    /* exit distances along each axis */
    float inverse[3];
    float cell_leave;
    float corner[8];
    int32_t kink_pieces; /* subdivisions of pieces whose density may have a kink */
    float step;          /* distance between light lookups, m */
    float growth;        /* growth of steps where the medium is invisible: factor 1 + growth */
    float max_sigma_t;   /* extinction at density 1 of the most significant channel, 1/m */
    float mean;          /* extinction at density 1, channel mean, 1/m */
    float density;       /* at the current distance */
    float center, last;  /* at the center of the current piece, and at its end */
    float column,
        moment; /* integrals over the step of the density, and of density times distance from the step's start */
} ty_track;

/* ---- intervals ---- */

/* Merges consecutive bricks into the next interval. */
TY_FN void ty_track_next_run(ty_track* track) {
    track->enter = track->has_next != 0 ? track->next_enter : TY_FLOAT_MAX;
    track->leave = track->has_next != 0 ? track->next_leave : TY_FLOAT_MAX;
    while (track->has_next != 0) {
        track->has_next = ty_majorant_dda_next(&track->bricks) ? 1 : 0;
        track->next_enter = track->bricks.enter;
        track->next_leave = track->bricks.leave;
        if (track->has_next == 0 || track->next_enter > track->leave) break;
        track->leave = track->next_leave;
    }
}

TY_FN float ty_track_per_metre(TY_GLOBAL const float to_index[12], ty_vec direction) {
    const ty_vec d = ty_map_direction(to_index, direction);
    return sqrtf(ty_dot(d, d));
}

/* Voxels per metre along the ray of the fields other than density; 0: none. */
TY_FN float ty_track_colors_per_metre(TY_GLOBAL const ty_medium_view* medium, ty_vec direction) {
    float max_rate = 0.0f;
    for (int32_t i = 0; i < medium->albedo_fields; ++i)
        max_rate = ty_maxf(max_rate, ty_track_per_metre(medium->albedo[i].to_index, direction));
    if (medium->has_g_field != 0) max_rate = ty_maxf(max_rate, ty_track_per_metre(medium->g_field.to_index, direction));
    /* Visible emission rises with such a high power of the temperature that it varies within a voxel. */
    if (medium->has_temperature != 0)
        max_rate =
            ty_maxf(max_rate, TY_TRACK_TEMPERATURE_STEPS * ty_track_per_metre(medium->temperature.to_index, direction));
    if (medium->transfer_albedo != 0) max_rate = ty_maxf(max_rate, ty_track_per_metre(medium->to_index, direction));
    return max_rate;
}

/* Distance between light lookups. light_per_metre: cells per metre along the ray of the light, 0: constant. Transfer
 * functions make edges within voxels, on whose lit sides light decays within less than a voxel. */
TY_FN float ty_track_step(TY_GLOBAL const ty_medium_view* medium, ty_vec direction, float light_per_metre) {
    float per_metre = light_per_metre;
    if (medium->has_grid != 0) {
        const float voxels = ty_track_per_metre(medium->to_index, direction);
        per_metre = light_per_metre > 0.0f ? ty_minf(voxels, light_per_metre) : voxels;
        if (medium->transfer != NULL) per_metre = TY_TRACK_TRANSFER_STEPS * voxels;
    }
    per_metre = ty_maxf(per_metre, ty_track_colors_per_metre(medium, direction));
    return per_metre > 0.0f ? 1.0f / per_metre : TY_FLOAT_MAX;
}

/* Step growth; 0 for emitting media, which may outshine the opacity in front of them. */
TY_FN float ty_track_growth(TY_GLOBAL const ty_medium_view* medium, ty_vec direction, float step) {
    if (medium->has_temperature != 0) return 0.0f;
    const bool of_voxels = medium->has_grid != 0 && step * ty_track_per_metre(medium->to_index, direction) < 1.5f;
    return of_voxels ? TY_TRACK_GROWTH_VOXELS : TY_TRACK_GROWTH_CELLS;
}

TY_FN void ty_track_begin(ty_track* track, TY_GLOBAL const ty_medium_view* medium, ty_vec origin, ty_vec direction,
                          float enter, float leave) {
    track->medium = medium;
    track->max_sigma_t = medium->sigma_t_max;
    track->mean = (medium->sigma_t[0] + medium->sigma_t[1] + medium->sigma_t[2]) * (1.0f / 3.0f);
    track->column = track->moment = 0.0f;
    ty_majorant_dda_begin(&track->bricks, medium, origin, direction, enter, leave);
    track->has_next = ty_majorant_dda_next(&track->bricks) ? 1 : 0;
    track->next_enter = track->bricks.enter;
    track->next_leave = track->bricks.leave;
    ty_track_next_run(track);
}

/* ---- voxels ---- */

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

/* The density t metres along the ray, within the current eight voxels. */
TY_FN float ty_track_density(const ty_track* track, float t) {
    TY_GLOBAL const ty_medium_view* medium = track->medium;
    if (medium->has_grid == 0) return 1.0f;
    const ty_majorant_dda* b = &track->bricks;
    const float x = b->origin.x + b->direction.x * t - (float)track->cell[0];
    const float y = b->origin.y + b->direction.y * t - (float)track->cell[1];
    const float z = b->origin.z + b->direction.z * t - (float)track->cell[2];
    return ty_voxels_to_density(medium, ty_voxels_interpolate(track->corner, x, y, z));
}

/* True if the transfer function has a point within the value range of the eight voxels. */
TY_FN bool ty_track_has_kink(const ty_track* track) {
    TY_GLOBAL const ty_medium_view* medium = track->medium;
    float lower = track->corner[0], upper = track->corner[0];
    for (int i = 1; i < 8; ++i) {
        lower = ty_minf(lower, track->corner[i]);
        upper = ty_maxf(upper, track->corner[i]);
    }
    for (int32_t i = 0; i < medium->transfer_count; ++i)
        if (medium->transfer[i].value > lower && medium->transfer[i].value < upper) return true;
    return false;
}

TY_FN void ty_track_enter_cell(ty_track* track) {
    ty_voxels_fetch(&track->medium->grid, track->cell, track->corner);
    track->kink_pieces = track->medium->transfer != NULL && ty_track_has_kink(track) ? TY_TRACK_KINK_PIECES : 1;
}

/* Starts an interval at t. */
TY_FN void ty_track_seek(ty_track* track, float t) {
    track->density = 1.0f;
    track->kink_pieces = 1;
    track->cell_leave = TY_FLOAT_MAX;
    if (track->medium->has_grid == 0) return;
    const ty_majorant_dda* b = &track->bricks;
    ty_track_find_axis(track, 0, b->origin.x, b->direction.x, t);
    ty_track_find_axis(track, 1, b->origin.y, b->direction.y, t);
    ty_track_find_axis(track, 2, b->origin.z, b->direction.z, t);
    ty_track_leave(track);
    ty_track_enter_cell(track);
    track->density = ty_track_density(track, t);
}

/* Advances to the voxels around t. */
TY_FN void ty_track_advance(ty_track* track, float t) {
    const ty_majorant_dda* b = &track->bricks;
    const float origin[3] = {b->origin.x, b->origin.y, b->origin.z};
    const float direction[3] = {b->direction.x, b->direction.y, b->direction.z};
    while (track->cell_leave <= t) {
        const int32_t xy = track->next[0] < track->next[1] ? 0 : 1;
        const int32_t axis = track->next[xy] < track->next[2] ? xy : 2;
        track->cell[axis] += direction[axis] > 0.0f ? 1 : -1;
        ty_track_face(track, axis, origin[axis], direction[axis]);
        ty_track_leave(track);
    }
    ty_track_enter_cell(track);
}

/* The density t metres along the ray, anywhere in the medium. */
TY_FN float ty_track_density_anywhere(const ty_track* track, float t) {
    TY_GLOBAL const ty_medium_view* medium = track->medium;
    if (medium->has_grid == 0) return 1.0f;
    return ty_voxels_density(medium, ty_mad(track->bricks.origin, track->bricks.direction, t));
}

/* Extinction there; channel mean, 1/m. */
TY_FN float ty_track_extinction(const ty_track* track, float t) {
    return track->mean * ty_track_density_anywhere(track, t);
}

/* ---- pieces ---- */

/* Integrates the density of the piece from t to `end`, which lies within the current voxels. Along a ray a trilinear
 * density is a cubic, for which Simpson's rule is exact; where a transfer function has a kink, the rule is applied to
 * subdivisions. */
TY_FN float ty_track_integrate(ty_track* track, float t, float end) {
    const float length = end - t;
    track->center = ty_track_density(track, t + 0.5f * length);
    track->last = ty_track_density(track, end);
    if (track->kink_pieces > 1) {
        const float sub_length = length * (1.0f / TY_TRACK_KINK_PIECES);
        float boundaries = 0.0f, centers = 0.0f;
        for (int i = 1; i < TY_TRACK_KINK_PIECES; ++i) boundaries += ty_track_density(track, t + sub_length * (float)i);
        for (int i = 0; i < TY_TRACK_KINK_PIECES; ++i)
            centers += ty_track_density(track, t + sub_length * ((float)i + 0.5f));
        const float sum =
            (track->density + track->last + 2.0f * boundaries + 4.0f * centers) * (1.0f / TY_TRACK_KINK_PIECES);
        track->center = 0.25f * (sum - track->density - track->last);
    }
    return (track->density + 4.0f * track->center + track->last) * length * (1.0f / 6.0f);
}

/* Adds that piece to the step that began at `begin`. */
TY_FN void ty_track_add_piece(ty_track* track, float begin, float t, float end) {
    const float length = (end - t) * (1.0f / 6.0f);
    const float sides = track->density + track->last, center = 4.0f * track->center;
    track->column += (sides + center) * length;
    track->moment +=
        (track->density * (t - begin) + center * (0.5f * (t + end) - begin) + track->last * (end - begin)) * length;
    track->density = track->last;
}

#endif
