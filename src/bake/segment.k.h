/* All media between two points, as one: Sec. 4.4. */
#ifndef TY_BAKE_SEGMENT_K_H
#define TY_BAKE_SEGMENT_K_H

#include "bake/fog_point.k.h"
#include "scene/spans.k.h"

typedef struct ty_segment {
    float depth[3];     /* integrals along it: of sigma_t, */
    float scattered[3]; /* of sigma_s, */
    float turned[3];    /* of g sigma_s */
    float transmittance[3];
    float leave;         /* where the last medium ends, m */
    ty_fog_point* point; /* is offered all of it; NULL: none is wanted */
} ty_segment;

/* Adds matter, in metres at density 1, whose colours are those at a point, over [enter, leave]. */
TY_FN void ty_segment_add(ty_segment* segment, TY_GLOBAL const ty_medium_view* medium, ty_vec at, float matter,
                          float enter, float leave) {
    float sigma_s[3], g[3];
    if (segment->point != NULL) ty_fog_point_offer(segment->point, medium, matter, enter, leave);
    ty_medium_sigma_s(medium, at, sigma_s);
    ty_medium_g(medium, at, g);
    for (int c = 0; c < 3; ++c) {
        segment->depth[c] += medium->sigma_t[c] * matter;
        segment->scattered[c] += sigma_s[c] * matter;
        segment->turned[c] += g[c] * sigma_s[c] * matter;
    }
}

TY_FN float ty_segment_density(TY_GLOBAL const ty_medium_view* medium, ty_vec at) {
    const float value = ty_grid_value(&medium->grid, ty_map_point(medium->to_index, at));
    return ty_maxf(0.0f, medium->transfer != NULL ? ty_transfer_density(medium->transfer, medium->transfer_count, value)
                                                  : value);
}

/* A stretch of a grid: bricks that are even at once, the rest voxel by voxel. */
TY_FN void ty_segment_add_grid(ty_segment* segment, TY_GLOBAL const ty_medium_view* medium, ty_vec origin,
                               ty_vec direction, float enter, float leave) {
    ty_majorant_dda bricks;
    const ty_vec across = ty_map_direction(medium->to_index, direction);
    const float per_metre = sqrtf(ty_dot(across, across));
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

TY_FN void ty_segment_stretch(ty_segment* segment, TY_GLOBAL const ty_medium_view* medium, ty_vec origin,
                              ty_vec direction, float enter, float leave) {
    segment->leave = ty_maxf(segment->leave, leave);
    if (medium->has_grid != 0)
        ty_segment_add_grid(segment, medium, origin, direction, enter, leave);
    else if (medium->heterogeneous == 0)
        ty_segment_add(segment, medium, origin, leave - enter, enter, leave);
    else {
        enum { PARTS = 16 };
        const float step = (leave - enter) / (float)PARTS;
        for (int32_t i = 0; i < PARTS; ++i) {
            const float begin = enter + (float)i * step;
            ty_segment_add(segment, medium, ty_mad(origin, direction, begin + 0.5f * step), step, begin, begin + step);
        }
    }
}

/* Media over [0, far] of a ray with unit direction. */
TY_FN void ty_segment_find(ty_segment* segment, TY_GLOBAL const ty_medium_view* media, int32_t count, ty_vec origin,
                           ty_vec direction, float far) {
    segment->leave = 0.0f;
    for (int c = 0; c < 3; ++c) segment->depth[c] = segment->scattered[c] = segment->turned[c] = 0.0f;
    for (int32_t m = 0; m < count; ++m) {
        float enter = 0.0f, leave = far;
        if (!ty_medium_interval(&media[m], origin, direction, &enter, &leave)) continue;
        if (media[m].bounds != TY_BOUNDED_MESH) {
            ty_segment_stretch(segment, &media[m], origin, direction, enter, leave);
            continue;
        }
        ty_spans spans;
        spans.count = spans.heterogeneous = spans.emits = 0;
        ty_spans_add_shell(&spans, media, m, origin, direction, enter, leave);
        for (int32_t i = 0; i < spans.count; ++i)
            ty_segment_stretch(segment, &media[m], origin, direction, spans.enter[i], spans.leave[i]);
    }
    for (int c = 0; c < 3; ++c)
        segment->transmittance[c] =
            c > 0 && segment->depth[c] == segment->depth[0] ? segment->transmittance[0] : ty_expf(-segment->depth[c]);
}

#endif
