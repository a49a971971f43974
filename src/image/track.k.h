/* Media along a ray as the marcher meets them: stretches that hold matter, and in them the density, voxel by voxel. */
#ifndef TY_IMAGE_TRACK_K_H
#define TY_IMAGE_TRACK_K_H

#include "image/voxel.k.h"

/* Parts of a piece in which a transfer function has a point. */
enum { TY_TRACK_PARTS = 4 };

/* Steps per voxel of a temperature, and where transfer functions make edges, times those of other things. */
#define TY_TRACK_GLOWS 4.0f
#define TY_TRACK_EDGES 2.0f

/* How much longer steps are behind all that is seen, of what they are before it: of voxels, which are finer than
 * scattered light is, and of other things. */
#define TY_TRACK_GROWTH_VOXELS 4.0f
#define TY_TRACK_GROWTH_CELLS 1.0f

/* A medium on a stretch of the ray. */
typedef struct ty_track {
    TY_GLOBAL const ty_medium_view* medium;
    ty_majorant_dda bricks; /* also the ray in the grid's index space */
    float enter, leave;     /* matter without a gap, m along the ray: where the ray is, or what it comes to next */
    float ahead_enter, ahead_leave;
    int32_t ahead;   /* whether there is more behind a gap */
    int32_t cell[3]; /* the lowest of the eight voxels around the ray */
    float next[3];   /* where the ray leaves them along each axis */
    float inverse[3];
    float cell_leave;
    float corner[8];
    int32_t parts;        /* that pieces are cut into: their density may have a kink */
    float step;           /* how far apart light is looked up, m */
    float growth;         /* times 1 + this where nothing is seen of it any more */
    float live;           /* extinction at density 1 of the channel that counts most, 1/m */
    float mean;           /* of the channels */
    float density;        /* where the ray is */
    float middle, last;   /* in the middle of the piece that is looked at, and at its end */
    float amount, moment; /* integrals over the step of the density, and of it times the way from the step's start */
} ty_track;

/* ---- stretches ---- */

/* Joins bricks that follow one another. */
TY_FN void ty_track_next_run(ty_track* track) {
    track->enter = track->ahead != 0 ? track->ahead_enter : TY_FLOAT_MAX;
    track->leave = track->ahead != 0 ? track->ahead_leave : TY_FLOAT_MAX;
    while (track->ahead != 0) {
        track->ahead = ty_majorant_dda_next(&track->bricks) ? 1 : 0;
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
    /* Visible light rises with so high a power of the temperature that it changes within a voxel. */
    if (medium->has_temperature != 0)
        most = ty_maxf(most, TY_TRACK_GLOWS * ty_track_per_metre(medium->temperature.to_index, direction));
    if (medium->transfer_albedo != 0) most = ty_maxf(most, ty_track_per_metre(medium->to_index, direction));
    return most;
}

/* light_per_metre: cells per metre along the ray that light changes over, 0 if it does not. Transfer functions make
 * edges within voxels, on whose lit sides light is lost within less. */
TY_FN float ty_track_step(TY_GLOBAL const ty_medium_view* medium, ty_vec direction, float light_per_metre) {
    float per_metre = light_per_metre;
    if (medium->has_grid != 0) {
        const float voxels = ty_track_per_metre(medium->to_index, direction);
        per_metre = light_per_metre > 0.0f ? ty_minf(voxels, light_per_metre) : voxels;
        if (medium->transfer != NULL) per_metre = TY_TRACK_EDGES * voxels;
    }
    per_metre = ty_maxf(per_metre, ty_track_colors_per_metre(medium, direction));
    return per_metre > 0.0f ? 1.0f / per_metre : TY_FLOAT_MAX;
}

/* What glows may outshine by far all that hides it. */
TY_FN float ty_track_growth(TY_GLOBAL const ty_medium_view* medium, ty_vec direction, float step) {
    if (medium->has_temperature != 0) return 0.0f;
    const bool of_voxels = medium->has_grid != 0 && step * ty_track_per_metre(medium->to_index, direction) < 1.5f;
    return of_voxels ? TY_TRACK_GROWTH_VOXELS : TY_TRACK_GROWTH_CELLS;
}

TY_FN void ty_track_begin(ty_track* track, TY_GLOBAL const ty_medium_view* medium, ty_vec origin, ty_vec direction,
                          float enter, float leave) {
    track->medium = medium;
    track->live = medium->sigma_t_max;
    track->mean = (medium->sigma_t[0] + medium->sigma_t[1] + medium->sigma_t[2]) * (1.0f / 3.0f);
    track->amount = track->moment = 0.0f;
    ty_majorant_dda_begin(&track->bricks, medium, origin, direction, enter, leave);
    track->ahead = ty_majorant_dda_next(&track->bricks) ? 1 : 0;
    track->ahead_enter = track->bricks.enter;
    track->ahead_leave = track->bricks.leave;
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

/* The density where the ray is t metres along, which is between the eight voxels. */
TY_FN float ty_track_density(const ty_track* track, float t) {
    TY_GLOBAL const ty_medium_view* medium = track->medium;
    if (medium->has_grid == 0) return 1.0f;
    const ty_majorant_dda* b = &track->bricks;
    const float x = b->origin.x + b->direction.x * t - (float)track->cell[0];
    const float y = b->origin.y + b->direction.y * t - (float)track->cell[1];
    const float z = b->origin.z + b->direction.z * t - (float)track->cell[2];
    return ty_voxels_to_density(medium, ty_voxels_between(track->corner, x, y, z));
}

/* Whether the transfer function has a point within the range of the eight voxels. */
TY_FN bool ty_track_bends(const ty_track* track) {
    TY_GLOBAL const ty_medium_view* medium = track->medium;
    float low = track->corner[0], high = track->corner[0];
    for (int i = 1; i < 8; ++i) {
        low = ty_minf(low, track->corner[i]);
        high = ty_maxf(high, track->corner[i]);
    }
    for (int32_t i = 0; i < medium->transfer_count; ++i)
        if (medium->transfer[i].value > low && medium->transfer[i].value < high) return true;
    return false;
}

TY_FN void ty_track_enter_cell(ty_track* track) {
    ty_voxels_fetch(&track->medium->grid, track->cell, track->corner);
    track->parts = track->medium->transfer != NULL && ty_track_bends(track) ? TY_TRACK_PARTS : 1;
}

/* At the start of a stretch. */
TY_FN void ty_track_find(ty_track* track, float t) {
    track->density = 1.0f;
    track->parts = 1;
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

/* On to the voxels around t, where the ray has left those that it was between. */
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

/* Extinction where the ray is t metres along, which may be anywhere in the medium; mean of the channels, 1/m. */
TY_FN float ty_track_extinction(const ty_track* track, float t) {
    TY_GLOBAL const ty_medium_view* medium = track->medium;
    if (medium->has_grid == 0) return track->mean;
    return track->mean * ty_voxels_density(medium, ty_mad(track->bricks.origin, track->bricks.direction, t));
}

/* ---- pieces ---- */

/* Looks at the piece from t to `end`, between whose ends no voxels are left; returns the integral of its density. Along
 * a ray a trilinear density is a cubic, for which Simpson's rule is exact; where a transfer function bends it, the rule
 * is applied part by part. */
TY_FN float ty_track_look(ty_track* track, float t, float end) {
    const float length = end - t;
    track->middle = ty_track_density(track, t + 0.5f * length);
    track->last = ty_track_density(track, end);
    if (track->parts > 1) {
        const float part = length * (1.0f / TY_TRACK_PARTS);
        float ends = 0.0f, middles = 0.0f;
        for (int i = 1; i < TY_TRACK_PARTS; ++i) ends += ty_track_density(track, t + part * (float)i);
        for (int i = 0; i < TY_TRACK_PARTS; ++i) middles += ty_track_density(track, t + part * ((float)i + 0.5f));
        const float sum = (track->density + track->last + 2.0f * ends + 4.0f * middles) * (1.0f / TY_TRACK_PARTS);
        track->middle = 0.25f * (sum - track->density - track->last);
    }
    return (track->density + 4.0f * track->middle + track->last) * length * (1.0f / 6.0f);
}

/* Takes that piece into the step that began at `begin`. */
TY_FN void ty_track_take(ty_track* track, float begin, float t, float end) {
    const float length = (end - t) * (1.0f / 6.0f);
    const float sides = track->density + track->last, middle = 4.0f * track->middle;
    track->amount += (sides + middle) * length;
    track->moment +=
        (track->density * (t - begin) + middle * (0.5f * (t + end) - begin) + track->last * (end - begin)) * length;
    track->density = track->last;
}

#endif
