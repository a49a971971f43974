/* The field of all light of an interior, from its cells continued to those beyond the surface, so that paths find
 * values up to the surface. */
#include "solve/enclosed/body.h"

#include <math.h>

/* Neighbours along an axis: the cell beside and the one behind it. */
typedef struct pair {
    size_t near, far;
    bool has_near, has_far;
} pair;

static pair find_pair(const ty_enclosed_body* body, const int32_t at[3], int axis, int32_t step) {
    const size_t steps[3] = {1, (size_t)body->size[0], (size_t)body->size[0] * (size_t)body->size[1]};
    const int32_t one = at[axis] + step, two = one + step;
    const size_t here = ((size_t)at[2] * (size_t)body->size[1] + (size_t)at[1]) * (size_t)body->size[0] + (size_t)at[0];
    pair p = {.near = here + (size_t)step * steps[axis], .far = here + 2 * (size_t)step * steps[axis]};
    p.has_near = one >= 0 && one < body->size[axis] && body->inside[p.near] != 0;
    p.has_far = p.has_near && two >= 0 && two < body->size[axis] && body->inside[p.far] != 0;
    return p;
}

/* Mean over the axes of linear continuations, at least half of the cell beside. */
static void continue_cell(ty_enclosed_body* body, const int32_t at[3], size_t cell) {
    const size_t terms = (size_t)body->terms;
    int32_t count = 0;
    for (int i = 0; i < 6; ++i) {
        const pair p = find_pair(body, at, i / 2, (i & 1) != 0 ? 1 : -1);
        if (!p.has_near) continue;
        ++count;
        for (int c = 0; c < 3; ++c) {
            float* field = body->field[c];
            const float near = field[p.near * terms], far = p.has_far ? field[p.far * terms] : near;
            const float factor = near > 0 ? fminf(fmaxf(2 - far / near, 0.5f), 1.5f) : 1;
            for (size_t t = 0; t < terms; ++t) field[cell * terms + t] += factor * field[p.near * terms + t];
        }
    }
    for (int c = 0; c < 3 && count > 0; ++c)
        for (size_t t = 0; t < terms; ++t) body->field[c][cell * terms + t] /= (float)count;
    body->near_cell[cell] = count > 0;
}

void ty_enclosed_fill_field(ty_enclosed_body* body) {
    const size_t terms = (size_t)body->terms;
    for (size_t i = 0; i < body->cells; ++i) {
        const bool inside = body->inside[i] != 0;
        body->near_cell[i] = inside;
        for (int c = 0; c < 3; ++c)
            for (size_t t = 0; t < terms; ++t) {
                const size_t at = i * terms + t;
                body->field[c][at] =
                    inside ? body->of_lights[c][at] + body->of_surfaces[c][at] + body->solved[c][t * body->cells + i]
                           : 0;
            }
    }
    for (size_t i = 0; i < body->cells; ++i) {
        const int32_t at[3] = {(int32_t)(i % (size_t)body->size[0]),
                               (int32_t)(i / (size_t)body->size[0] % (size_t)body->size[1]),
                               (int32_t)(i / ((size_t)body->size[0] * (size_t)body->size[1]))};
        if (body->inside[i] == 0) continue_cell(body, at, i);
    }
}
