/* Optical depths of all media between two points (Sec. 4.4, Dubouchet 2019). */
#ifndef TY_BAKE_GATHER_SEGMENT_K_H
#define TY_BAKE_GATHER_SEGMENT_K_H

#include "bake/gather/fog_point.k.h"
#include "scene/media/spans.k.h"

typedef struct ty_segment {
    float depth[3];              /* integrals along the segment: of sigma_t, */
    float scattering_depth[3];   /* of sigma_s, */
    float g_scattering_depth[3]; /* of g sigma_s */
    float transmittance[3];
    float leave;         /* distance at which the last medium ends, m */
    ty_fog_point* point; /* media sample point updated with all pieces; NULL: none */
} ty_segment;

/* Adds a piece of a medium, its optical length in metres at density 1, with the coefficients at a point, over [enter,
 * leave]. */
TY_FN void ty_segment_add(ty_segment* segment, TY_GLOBAL const ty_medium_view* medium, ty_vec at, float optical_length,
                          float enter, float leave) {
    float sigma_s[3], g[3];
    if (segment->point != NULL) ty_fog_point_add_piece(segment->point, medium, optical_length, enter, leave);
    ty_medium_sigma_s(medium, at, sigma_s);
    ty_medium_g(medium, at, g);
    for (int c = 0; c < 3; ++c) {
        segment->depth[c] += medium->sigma_t[c] * optical_length;
        segment->scattering_depth[c] += sigma_s[c] * optical_length;
        segment->g_scattering_depth[c] += g[c] * sigma_s[c] * optical_length;
    }
}

TY_FN float ty_segment_density(TY_GLOBAL const ty_medium_view* medium, ty_vec at) {
    const float value = ty_grid_value(&medium->grid, ty_map_point(medium->to_index, at));
    return ty_maxf(0.0f, medium->transfer != NULL ? ty_transfer_density(medium->transfer, medium->transfer_count, value)
                                                  : value);
}

/* Adds an interval of a grid medium: uniform bricks at once, the others voxel by voxel. */
TY_FN void ty_segment_add_grid(ty_segment* segment, TY_GLOBAL const ty_medium_view* medium, ty_vec origin,
                               ty_vec direction, float enter, float leave) {
    ty_majorant_dda bricks;
    const ty_vec index_direction = ty_map_direction(medium->to_index, direction);
    const float per_metre = sqrtf(ty_dot(index_direction, index_direction));
    ty_majorant_dda_begin(&bricks, medium, origin, direction, enter, leave);
    while (ty_majorant_dda_next(&bricks)) {
        const float length = bricks.leave - bricks.enter;
        if (bricks.minorant == bricks.majorant) {
            ty_segment_add(segment, medium, ty_mad(origin, direction, bricks.enter + 0.5f * length),
                           bricks.minorant * length, bricks.enter, bricks.leave);
            continue;
        }
        const int32_t steps = (int32_t)ty_minf(ceilf(length * per_metre), 4.0f * (float)TY_BRICK) + 1;
        const float step = length / (float)steps;
        for (int32_t i = 0; i < steps; ++i) {
            const float begin = bricks.enter + (float)i * step;
            const ty_vec at = ty_mad(origin, direction, begin + 0.5f * step);
            ty_segment_add(segment, medium, at, step * ty_segment_density(medium, at), begin, begin + step);
        }
    }
}

TY_FN void ty_segment_add_interval(ty_segment* segment, TY_GLOBAL const ty_medium_view* medium, ty_vec origin,
                                   ty_vec direction, float enter, float leave) {
    segment->leave = ty_maxf(segment->leave, leave);
    if (medium->has_grid != 0)
        ty_segment_add_grid(segment, medium, origin, direction, enter, leave);
    else if (medium->heterogeneous == 0)
        ty_segment_add(segment, medium, origin, leave - enter, enter, leave);
    else {
        enum { STEPS = 16 };
        const float step = (leave - enter) / (float)STEPS;
        for (int32_t i = 0; i < STEPS; ++i) {
            const float begin = enter + (float)i * step;
            ty_segment_add(segment, medium, ty_mad(origin, direction, begin + 0.5f * step), step, begin, begin + step);
        }
    }
}

/* Optical depths and length-weighted means of the media over [0, max_distance] of a ray with unit direction: Sec. 4.4
 * (Dubouchet 2019). */
TY_FN void ty_segment_find(ty_segment* segment, TY_GLOBAL const ty_medium_view* media, int32_t count, ty_vec origin,
                           ty_vec direction, float max_distance) {
    segment->leave = 0.0f;
    for (int c = 0; c < 3; ++c)
        segment->depth[c] = segment->scattering_depth[c] = segment->g_scattering_depth[c] = 0.0f;
    for (int32_t m = 0; m < count; ++m) {
        float enter = 0.0f, leave = max_distance;
        if (!ty_medium_interval(&media[m], origin, direction, &enter, &leave)) continue;
        if (media[m].bounds != TY_BOUNDED_MESH) {
            ty_segment_add_interval(segment, &media[m], origin, direction, enter, leave);
            continue;
        }
        ty_spans spans;
        spans.count = spans.heterogeneous = spans.emits = 0;
        ty_spans_add_shell(&spans, media, m, origin, direction, enter, leave);
        for (int32_t i = 0; i < spans.count; ++i)
            ty_segment_add_interval(segment, &media[m], origin, direction, spans.enter[i], spans.leave[i]);
    }
    for (int c = 0; c < 3; ++c)
        segment->transmittance[c] =
            c > 0 && segment->depth[c] == segment->depth[0] ? segment->transmittance[0] : ty_expf(-segment->depth[c]);
}

#endif
