/* Intervals of a ray inside media. */
#ifndef TY_SCENE_MEDIA_SPANS_K_H
#define TY_SCENE_MEDIA_SPANS_K_H

#include "scene/media/medium.k.h"

/* On devices, where a thread's memory is scarce, scenes with more than TY_DEVICE_MEDIA_MAX media are refused. */
enum { TY_DEVICE_MEDIA_MAX = 12 };
#if defined(TY_DEVICE)
enum { TY_SPANS_MAX = TY_DEVICE_MEDIA_MAX };
#else
enum { TY_SPANS_MAX = 128 };
#endif

/* Intervals of a ray inside media, unordered; a medium with a closed mesh can have several. Those beyond TY_SPANS_MAX
 * are dropped. */
typedef struct ty_spans {
    int32_t count;
    int32_t heterogeneous; /* true for any of the media */
    int32_t emits;         /* true for any of the media */
    int32_t medium[TY_SPANS_MAX];
    float enter[TY_SPANS_MAX], leave[TY_SPANS_MAX];
} ty_spans;

TY_FN void ty_spans_add(ty_spans* spans, TY_GLOBAL const ty_medium_view* media, int32_t medium, float enter,
                        float leave) {
    if (spans->count >= TY_SPANS_MAX || !(enter < leave)) return;
    spans->medium[spans->count] = medium;
    spans->enter[spans->count] = enter;
    spans->leave[spans->count++] = leave;
    spans->heterogeneous |= media[medium].heterogeneous;
    spans->emits |= media[medium].emits;
}

/* Adds the part of [enter, leave] inside a medium's closed mesh. Infinity is outside, so crossings are counted from
 * there. */
TY_FN void ty_spans_add_shell(ty_spans* spans, TY_GLOBAL const ty_medium_view* media, int32_t medium, ty_vec origin,
                              ty_vec direction, float enter, float leave) {
    ty_crossing crossings[TY_CROSSINGS_MAX];
    const ty_vec o = ty_map_point(media[medium].to_bounds, origin);
    const ty_vec d = ty_map_direction(media[medium].to_bounds, direction);
    int32_t inside;
    const int32_t count = ty_accel_crossings(media[medium].shell, o, d, crossings, &inside);
    float end = count > 0 ? crossings[count - 1].t : 0.0f;
    for (int32_t i = count; i-- > 0;) {
        const int32_t outside_count = inside + crossings[i].exits;
        if (inside <= 0 && outside_count > 0) end = crossings[i].t;
        if (inside > 0 && outside_count <= 0)
            ty_spans_add(spans, media, medium, ty_maxf(enter, crossings[i].t), ty_minf(leave, end));
        inside = outside_count;
    }
    if (inside > 0) ty_spans_add(spans, media, medium, enter, ty_minf(leave, end));
}

TY_FN void ty_spans_find(TY_GLOBAL const ty_medium_view* media, int32_t count, ty_vec origin, ty_vec direction,
                         float far, ty_spans* spans) {
    spans->count = 0;
    spans->heterogeneous = 0;
    spans->emits = 0;
    for (int32_t m = 0; m < count; ++m) {
        float enter = 0.0f, leave = far;
        if (!ty_medium_interval(&media[m], origin, direction, &enter, &leave)) continue;
        if (media[m].bounds == TY_BOUNDED_MESH)
            ty_spans_add_shell(spans, media, m, origin, direction, enter, leave);
        else
            ty_spans_add(spans, media, m, enter, leave);
    }
}

#endif
