/* The field beside the surface of an interior whose cells are thicker than a transport mean free path. There paths
 * collide in a small part of a cell, and what they find should follow the surface, not its cells: the light that leaves
 * through the faces of cells, averaged along the surface, has the fluence and flux of diffusion at an interface. */
#include "base/constants.h"
#include "base/context.h"
#include "solve/diffusion/fresnel_boundary.h"
#include "solve/enclosed/body.h"

#include <math.h>

/* Standard deviation of the average, and the cells that it reaches from that of a point, cells. */
static const float deviation = 0.8f;
enum { REACH = 2 };
/* Thickness of a cell, transport mean free paths, from which on the average begins to replace the cells' own field; it
 * does so entirely one mean free path above. */
static const float min_thickness = 0.5f;

/* Weighted sums over the faces around a cell's center. */
typedef struct face_sums {
    float normal[3], weighted_normal[3];
    float area;                   /* of the surface */
    float power[3], thickness[3]; /* leaving light; of cells, times the area */
} face_sums;

/* The cells that a face reaches, and the factors of its weight along each axis. */
typedef struct reach {
    int32_t first[3], count[3];
    float factor[3][2 * REACH + 1];
} reach;

static reach reach_of(const ty_enclosed_body* body, const ty_enclosed_side* side) {
    const float position[3] = {side->position.x, side->position.y, side->position.z};
    reach r;
    for (int a = 0; a < 3; ++a) {
        const float at = (position[a] - (float)body->lower[a]) / (float)body->cell[a] - 0.5f;
        const int32_t center = (int32_t)lrintf(at), first = center > REACH ? center - REACH : 0;
        const int32_t last = center + REACH < body->size[a] - 1 ? center + REACH : body->size[a] - 1;
        r.first[a] = first;
        r.count[a] = last >= first ? last - first + 1 : 0;
        for (int32_t i = 0; i < r.count[a]; ++i) {
            const float off = ((float)(first + i) - at) / deviation;
            r.factor[a][i] = expf(-0.5f * off * off);
        }
    }
    return r;
}

static float face_area(const ty_enclosed_body* body, int32_t side) {
    const int axis = body->face[side] / 2;
    return (float)(body->cell[(axis + 1) % 3] * body->cell[(axis + 2) % 3]);
}

/* Adds a face's normal; then, to cells whose mean normal is similar, all else. */
static void add_face(const ty_enclosed_body* body, int32_t i, bool normals, face_sums* sums) {
    const ty_enclosed_side* side = &body->sides[i];
    const float normal[3] = {side->normal.x, side->normal.y, side->normal.z};
    const float edge = (float)body->cell[body->face[i] / 2];
    const reach r = reach_of(body, side);
    float thickness[3];
    for (int c = 0; c < 3; ++c)
        thickness[c] =
            edge * (body->extinction[c][side->cell] - body->legendre[c][1] * body->scattering[c][side->cell]);
    for (int32_t z = 0; z < r.count[2]; ++z)
        for (int32_t y = 0; y < r.count[1]; ++y)
            for (int32_t x = 0; x < r.count[0]; ++x) {
                const int32_t row = (r.first[2] + z) * body->size[1] + r.first[1] + y;
                face_sums* s = &sums[(size_t)row * (size_t)body->size[0] + (size_t)(r.first[0] + x)];
                float weight = r.factor[0][x] * r.factor[1][y] * r.factor[2][z];
                if (normals) {
                    for (int a = 0; a < 3; ++a) s->normal[a] += weight * side->area * normal[a];
                    continue;
                }
                const float cosine = s->normal[0] * normal[0] + s->normal[1] * normal[1] + s->normal[2] * normal[2];
                const float square =
                    s->normal[0] * s->normal[0] + s->normal[1] * s->normal[1] + s->normal[2] * s->normal[2];
                weight *= cosine > 0 ? cosine * cosine / square : 0;
                s->area += weight * side->area;
                for (int a = 0; a < 3; ++a) s->weighted_normal[a] += weight * side->area * normal[a];
                for (int c = 0; c < 3; ++c) {
                    s->power[c] += weight * face_area(body, i) * body->exitance[c][i];
                    s->thickness[c] += weight * side->area * thickness[c];
                }
            }
}

/* Replaces the field of a cell by phi = 2 A J and the flux J n, as far as cells are thick. */
static void set_cell(ty_enclosed_body* body, size_t cell, const face_sums* s, float factor) {
    const size_t terms = (size_t)body->terms, at = cell * terms;
    static const int32_t axis_of[3] = {1, 2, 0};
    float parts[3], min_part = 1;
    for (int c = 0; c < 3; ++c) {
        parts[c] = ty_clampf(s->thickness[c] / s->area - min_thickness, 0, 1);
        min_part = ty_minf(min_part, parts[c]);
    }
    if (body->near_cell[cell] == 0 && min_part < 1) return;
    body->near_cell[cell] = 1;
    const float length =
        sqrtf(s->weighted_normal[0] * s->weighted_normal[0] + s->weighted_normal[1] * s->weighted_normal[1] +
              s->weighted_normal[2] * s->weighted_normal[2]);
    for (int c = 0; c < 3; ++c) {
        const float current = ty_maxf(s->power[c] / s->area, 0);
        float* field = body->field[c] + at;
        for (size_t t = 0; t < terms; ++t) {
            float value = t == 0 ? factor * current / (float)TY_SQRT_4PI_F64 : 0;
            if (t > 0 && t < 4 && length > 0)
                value = current * s->weighted_normal[axis_of[t - 1]] / length * (float)(sqrt(3) / TY_SQRT_4PI_F64);
            field[t] += parts[c] * (value - field[t]);
        }
    }
}

static bool is_thick(const ty_enclosed_body* body) {
    for (int32_t i = 0; i < body->side_count; ++i) {
        const int32_t cell = body->sides[i].cell;
        for (int c = 0; c < 3 && cell >= 0; ++c)
            if (body->extinction[c][cell] - body->legendre[c][1] * body->scattering[c][cell] >
                min_thickness / (float)body->cell[body->face[i] / 2])
                return true;
    }
    return false;
}

ty_result ty_enclosed_spread_exitance(ty_enclosed_body* body) {
    const float ior = body->scene->interiors[body->interior].ior;
    if (!is_thick(body)) return TY_OK;
    face_sums* sums = ty_alloc_array(body->context, body->cells, sizeof *sums, true);
    if (sums == NULL) return TY_ERROR_MEMORY;
    for (int pass = 0; pass < 2; ++pass)
        for (int32_t i = 0; i < body->side_count; ++i)
            if (body->sides[i].cell >= 0) add_face(body, i, pass == 0, sums);
    const float factor = 2 * (float)ty_fresnel_partial_current_factor((double)ior);
    for (size_t i = 0; i < body->cells; ++i)
        if (sums[i].area > 0) set_cell(body, i, &sums[i], factor);
    ty_free_array(body->context, sums, body->cells, sizeof *sums);
    return TY_OK;
}
