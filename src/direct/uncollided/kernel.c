/* Row loops of parallel light and point lights, built once per instruction set, with TY_ISA naming it. */
#include "direct/uncollided/kernel.h"

#include "direct/lights/discrete_light.h"
#include "direct/uncollided/point_rows.k.h"

/* ---- parallel light ---- */

/* Weighted mean extinction of the three rows below a row of tubes, with two empty cells at either end. */
static void blend_rows(const ty_tube_row* row) {
    const int32_t count = row->count;
    const float *a = row->cells[0], *b = row->cells[1], *c = row->cells[2];
    const float* weight = row->weight[1];
    float* blend = row->blend;
    blend[0] = blend[1] = blend[count + 2] = blend[count + 3] = 0.0f;
#pragma omp simd
    for (int32_t i = 0; i < count; ++i) blend[i + 2] = ty_weighted_sum3(a[i], b[i], c[i], weight);
}

static void pass(const ty_tube_row* row) {
    const float *blend = row->blend, *in = row->in;
    float *out = row->out, *mean = row->mean;
    const float* weight = row->weight[0];
    const float length = row->length;
#pragma omp simd
    for (int32_t t = 0; t < row->count + 2; ++t) {
        const float depth = ty_weighted_sum3(blend[t], blend[t + 1], blend[t + 2], weight) * length;
        const float attenuation = ty_attenuation(depth);
        mean[t] = in[t] * ty_mean_attenuation(depth, attenuation);
        out[t] = in[t] * attenuation;
    }
}

/* The fraction of a slab that a ray crosses before it meets a surface. */
TY_FN float visible_fraction(float hit, float start, float per_length) {
    return ty_clampf((hit - start) * per_length, 0.0f, 1.0f);
}

/* Scales each tube's mean transmittance by the visible fraction of its rays. */
static void apply_shadows(const ty_tube_row* row) {
    const float *a = row->hit[0], *b = row->hit[1], *c = row->hit[2], *d = row->hit[3];
    const float start = row->start, per_length = 1.0f / row->length;
    float* mean = row->mean;
#pragma omp simd
    for (int32_t t = 0; t < row->count + 2; ++t)
        mean[t] *= 0.25f * (visible_fraction(a[t], start, per_length) + visible_fraction(b[t], start, per_length) +
                            visible_fraction(c[t], start, per_length) + visible_fraction(d[t], start, per_length));
}

static void tubes(const ty_tube_row* row) {
    blend_rows(row);
    pass(row);
    if (row->hit[0] != NULL) apply_shadows(row);
}

static void cells(const ty_tube_cells* c) {
    const float *first = c->mean[0], *second = c->mean[1], *third = c->mean[2];
    const float *u = c->weight[0], *v = c->weight[1];
    float* transmittance = c->transmittance;
#pragma omp simd
    for (int32_t i = 0; i < c->count; ++i)
        transmittance[i] = ty_weighted_sum3(ty_weighted_sum3(first[i + 2], first[i + 1], first[i], u),
                                            ty_weighted_sum3(second[i + 2], second[i + 1], second[i], u),
                                            ty_weighted_sum3(third[i + 2], third[i + 1], third[i], u), v);
    for (int32_t p = 0; p < c->plane_count; ++p) {
        const float factor = c->factor[p];
        float* plane = c->planes[p];
#pragma omp simd
        for (int32_t i = 0; i < c->count; ++i) plane[i] += factor * transmittance[i];
    }
}

static void transpose(const ty_transpose_block* b) {
    float tile[TY_TRANSPOSE_SIDE][TY_TRANSPOSE_SIDE + 1];
    for (int32_t row = 0; row < b->rows; ++row) {
        float* from = b->from + b->stride * (size_t)row;
        const int32_t column = b->backwards != 0 ? b->rows - 1 - row : row;
        for (int32_t i = 0; i < b->columns; ++i) {
            tile[i][column] = from[i];
            from[i] = 0.0f;
        }
    }
    for (int32_t i = 0; i < b->columns; ++i) {
        float* to = b->to + b->to_stride * (size_t)i;
#pragma omp simd
        for (int32_t column = 0; column < b->rows; ++column) to[column] += tile[i][column];
    }
}

/* ---- point lights ---- */

static void trace_row(const ty_ray_row* rays) {
    const ty_ray_row r = *rays;
    const float *cells = r.cells, *entry = r.entry;
    float *depth = r.depth, *mean = r.mean;
#pragma omp simd
    for (int32_t i = r.begin; i < r.end; ++i) {
        const ty_ray_place p = ty_ray_row_place(&r, i, entry[i]);
        const float before = ty_lerp_exact(cells[p.base], cells[p.base + p.next_u], p.t);
        const float after = ty_lerp_exact(cells[p.base + p.next_v], cells[p.base + p.next_v + p.next_u], p.t);
        const float sigma = ty_lerp_exact(before, after, p.row_t);
        mean[i] = p.passed > 0.0f ? depth[i] / p.passed : sigma;
        depth[i] += sigma * (r.far - p.from);
    }
}

static void blend_rays(const ty_ray_row_blend* b) {
    const float *a0 = b->mean[0], *a1 = b->mean[1], *b0 = b->mean[2], *b1 = b->mean[3];
    const float row_t = b->row_t, far_t = b->far_t, along = b->along;
    float* out = b->out;
#pragma omp simd
    for (int32_t i = b->begin; i < b->end; ++i)
        out[i] = ty_lerp_exact(ty_lerp_exact(a0[i], a1[i], row_t), ty_lerp_exact(b0[i], b1[i], row_t), far_t);
    if (b->hit[0] == NULL) return;
    const float *before = b->hit[0], *after = b->hit[1];
    float* visible = b->visible;
#pragma omp simd
    for (int32_t i = b->begin; i < b->end; ++i)
        visible[i] = ty_lerp_exact(before[i] > along ? 1.0f : 0.0f, after[i] > along ? 1.0f : 0.0f, row_t);
}

/* Mean over a cell, from the optical depth and its gradient at the center. */
TY_FN float cell_mean(const ty_cell_row_means* c, int32_t i, float mean, float extinction) {
    const ty_cell_place p = ty_cell_row_place_at(c, i);
    ty_cell_depth d;
    d.depth = mean * p.in_media;
    d.extinction = extinction;
    for (int32_t a = 0; a < 3; ++a) d.slope[a] = p.slope[a];
    return c->spread != 0 ? ty_cell_mean_falloff(&d, p.to, p.per_distance, c->cell)
                          : ty_cell_mean_transmittance(&d, c->cell);
}

static void cell_means(const ty_cell_row_means* cells) {
    const ty_cell_row_means c = *cells;
#pragma omp simd
    for (int32_t i = c.begin; i < c.end; ++i) {
        float t;
        const int32_t ray = ty_cell_row_column(&c, i, &t);
        const float mean = ty_lerp_exact(c.mean[ray], c.mean[ray + 1], t);
        c.transmittance[i] = cell_mean(&c, i, mean, c.extinction[(size_t)i * c.stride]);
    }
    if (c.visible == NULL) return;
#pragma omp simd
    for (int32_t i = c.begin; i < c.end; ++i) {
        float t;
        const int32_t ray = ty_cell_row_column(&c, i, &t);
        c.transmittance[i] *= ty_lerp_exact(c.visible[ray], c.visible[ray + 1], t);
    }
}

static void directions(const ty_cell_row_directions* row) {
    const ty_cell_row_directions w = *row;
#pragma omp simd
    for (int32_t i = w.begin; i < w.end; ++i) {
        const float off = w.off[0] + w.off[1] * (float)i;
        const float per_distance = 1.0f / sqrtf(off * off + w.v * w.v + w.w * w.w);
        w.omega[0][i] = off * per_distance;
        w.omega[1][i] = w.v * per_distance;
        w.omega[2][i] = w.w * per_distance;
        w.falloff[i] = per_distance * per_distance;
    }
    if (w.profile == TY_PROFILE_ISOTROPIC) return;
#pragma omp simd
    for (int32_t i = w.begin; i < w.end; ++i)
        w.falloff[i] *= ty_light_profile_at(w.profile, w.light,
                                            w.omega[0][i] * w.axis_direction[0] + w.omega[1][i] * w.axis_direction[1] +
                                                w.omega[2][i] * w.axis_direction[2]);
}

TY_FN void add_light_row(const ty_cell_row_sum* s, size_t stride) {
    const float *transmittance = s->transmittance, *falloff = s->falloff, color = s->color;
    float* fluence = s->fluence;
#pragma omp simd
    for (int32_t i = s->begin; i < s->end; ++i) fluence[(size_t)i * stride] += color * transmittance[i] * falloff[i];
    for (int a = 0; a < 3 && s->flux[a] != NULL; ++a) {
        const float* omega = s->omega[a];
        float* flux = s->flux[a];
#pragma omp simd
        for (int32_t i = s->begin; i < s->end; ++i)
            flux[(size_t)i * stride] += color * transmittance[i] * falloff[i] * omega[i];
    }
}

static void add_light(const ty_cell_row_sum* s) {
    if (s->stride == 1)
        add_light_row(s, 1);
    else
        add_light_row(s, s->stride);
}

const ty_direct_kernels TY_KERNEL_NAME(ty_direct_kernels) = {
    .tubes = tubes,
    .cells = cells,
    .transpose = transpose,
    .trace_row = trace_row,
    .blend_rows = blend_rays,
    .cell_means = cell_means,
    .directions = directions,
    .add_light = add_light,
};
