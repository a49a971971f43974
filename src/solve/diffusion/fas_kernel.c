/* Loops over planes for the transfer between FAS stages. Compiled once per instruction set, which TY_ISA names. */
#include "solve/diffusion/cell_kernel.h"

#include "base/kernel.h"

#include <string.h>

/* Capacity of a row on the stack. */
enum { ROW_ITEMS = TY_DIFFUSION_SIDE_MAX };
/* Smaller fluences count as 0. */
static const float MIN_PHI = 1e-30f;

/* Rows of finer cells within a coarse row. */
typedef struct child_rows {
    int32_t y_begin, y_end, z_begin, z_end;
    float weight; /* 1 / rows */
} child_rows;

static child_rows make_child_rows(const ty_fas_level* fine, const ty_fas_level* coarse, int32_t y, int32_t z) {
    const int32_t *size = fine->cells.box.size, *n = coarse->children;
    child_rows rows = {y * n[1], (y + 1) * n[1], z * n[2], (z + 1) * n[2], 0};
    if (rows.y_end > size[1]) rows.y_end = size[1];
    if (rows.z_end > size[2]) rows.z_end = size[2];
    rows.weight = 1.0f / (float)((rows.y_end - rows.y_begin) * (rows.z_end - rows.z_begin));
    return rows;
}

/* Means of pairs of items, times a weight; an odd last item stands alone. */
static void pair_means(const float* items, int32_t count, int32_t children, float weight, float* out) {
    if (children == 1) {
#pragma omp simd
        for (int32_t i = 0; i < count; ++i) out[i] = weight * items[i];
        return;
    }
    const float half = 0.5f * weight;
#pragma omp simd
    for (int32_t i = 0; i < count / 2; ++i) out[i] = half * (items[2 * i] + items[2 * i + 1]);
    if ((count & 1) != 0) out[count / 2] = weight * items[count - 1];
}

static void restrict_media(const ty_fas_level* fine, const ty_fas_level* coarse, int32_t z) {
    float path[ROW_ITEMS], absorbed[ROW_ITEMS], source[ROW_ITEMS];
    const ty_cells* from = &fine->cells;
    const int32_t nx = from->box.size[0];
    for (int32_t y = 0; y < coarse->cells.box.size[1]; ++y) {
        const child_rows rows = make_child_rows(fine, coarse, y, z);
        memset(path, 0, sizeof(float) * (size_t)nx);
        memset(absorbed, 0, sizeof(float) * (size_t)nx);
        memset(source, 0, sizeof(float) * (size_t)nx);
        for (int32_t fz = rows.z_begin; fz < rows.z_end; ++fz)
            for (int32_t fy = rows.y_begin; fy < rows.y_end; ++fy) {
                const ptrdiff_t at = ty_box_dense(&from->box, fy, fz);
                const float *sigma = from->extinction + at, *q = from->source + at;
                const float* sigma_a = from->absorption != NULL ? from->absorption + at : from->zeros;
#pragma omp simd
                for (int32_t i = 0; i < nx; ++i) {
                    path[i] += 1.0f / ty_maxf(sigma[i], from->min_extinction);
                    absorbed[i] += sigma_a[i];
                    source[i] += q[i] * from->scale;
                }
            }
        const ptrdiff_t to = ty_box_dense(&coarse->cells.box, y, z);
        float* extinction = coarse->extinction + to;
        pair_means(path, nx, coarse->children[0], rows.weight, extinction);
        pair_means(absorbed, nx, coarse->children[0], rows.weight, coarse->absorption + to);
        pair_means(source, nx, coarse->children[0], rows.weight, coarse->source + to);
#pragma omp simd
        for (int32_t i = 0; i < coarse->cells.box.size[0]; ++i) extinction[i] = 1.0f / extinction[i];
    }
}

static void restrict_phi(const ty_fas_level* fine, const float* f, const ty_fas_level* coarse, int32_t z) {
    float sum[ROW_ITEMS], residual_sum[ROW_ITEMS];
    const int32_t nx = fine->cells.box.size[0];
    for (int32_t y = 0; y < coarse->cells.box.size[1]; ++y) {
        const child_rows rows = make_child_rows(fine, coarse, y, z);
        memset(sum, 0, sizeof(float) * (size_t)nx);
        memset(residual_sum, 0, sizeof(float) * (size_t)nx);
        for (int32_t fz = rows.z_begin; fz < rows.z_end; ++fz)
            for (int32_t fy = rows.y_begin; fy < rows.y_end; ++fy) {
                const ptrdiff_t at = ty_box_at(&fine->cells.box, fy, fz);
                const double* phi = fine->phi + at;
                const float* residual = f + at;
#pragma omp simd
                for (int32_t i = 0; i < nx; ++i) {
                    sum[i] += (float)phi[i];
                    residual_sum[i] += residual[i];
                }
            }
        const ptrdiff_t to = ty_box_at(&coarse->cells.box, y, z);
        float *restricted = coarse->restricted + to, *source = coarse->source + ty_box_dense(&coarse->cells.box, y, z);
        double* phi = coarse->phi + to;
        pair_means(sum, nx, coarse->children[0], rows.weight, restricted);
        pair_means(residual_sum, nx, coarse->children[0], rows.weight, source);
#pragma omp simd
        for (int32_t i = 0; i < coarse->cells.box.size[0]; ++i) phi[i] = (double)restricted[i];
    }
}

static void set_fas_source(const ty_fas_level* stage, const float* f, int32_t z) {
    const ty_box* box = &stage->cells.box;
    for (int32_t y = 0; y < box->size[1]; ++y) {
        float* source = stage->source + ty_box_dense(box, y, z);
        const float* row = f + ty_box_at(box, y, z);
#pragma omp simd
        for (int32_t i = 0; i < box->size[0]; ++i) source[i] = 2.0f * source[i] - row[i];
    }
}

static void relative_change(const ty_fas_level* stage, int32_t z) {
    const ty_box* box = &stage->cells.box;
    for (int32_t y = 0; y < box->size[1]; ++y) {
        float* restricted = stage->restricted + ty_box_at(box, y, z);
        const double* phi = stage->phi + ty_box_at(box, y, z);
#pragma omp simd
        for (int32_t i = 0; i < box->size[0]; ++i) {
            const float from = ty_maxf(restricted[i], MIN_PHI);
            restricted[i] = restricted[i] > MIN_PHI ? (float)((phi[i] - (double)from) / (double)from) : 0.0f;
        }
    }
}

/* The coarse cells whose centers enclose that of a fine one; returns the weight of the second. */
static float neighbours(const ty_fas_level* coarse, int axis, int32_t fine, int32_t at[2]) {
    at[0] = at[1] = fine / coarse->children[axis];
    if (coarse->children[axis] == 1) return 0;
    const bool up = (fine & 1) != 0;
    const int32_t next = up ? at[0] + 1 : at[0] - 1;
    if ((next >= 0 && next < coarse->cells.box.size[axis]) || !ty_box_ends(&coarse->cells.box, 2 * axis + up))
        at[1] = next;
    return 0.25f;
}

/* Interpolates a row of `restricted` to a fine y and z. */
static void interpolate_row(const ty_fas_level* coarse, int32_t y, int32_t z, float* out) {
    const ty_box* box = &coarse->cells.box;
    int32_t ys[2], zs[2];
    const float wy = neighbours(coarse, 1, y, ys), wz = neighbours(coarse, 2, z, zs);
    const float* rows[4];
    for (int i = 0; i < 4; ++i) rows[i] = coarse->restricted + ty_box_at(box, ys[i & 1], zs[i >> 1]);
    const float w0 = (1 - wy) * (1 - wz), w1 = wy * (1 - wz), w2 = (1 - wy) * wz, w3 = wy * wz;
#pragma omp simd
    for (int32_t i = 0; i < box->size[0]; ++i)
        out[i] = w0 * rows[0][i] + w1 * rows[1][i] + w2 * rows[2][i] + w3 * rows[3][i];
}

static void correct(const ty_fas_level* fine, const ty_fas_level* coarse, int32_t z) {
    float row[ROW_ITEMS + 2];
    const int32_t nx = fine->cells.box.size[0], coarse_nx = coarse->cells.box.size[0];
    float* change = row + 1;
    for (int32_t y = 0; y < fine->cells.box.size[1]; ++y) {
        double* phi = fine->phi + ty_box_at(&fine->cells.box, y, z);
        interpolate_row(coarse, y, z, change);
        if (coarse->children[0] == 1) {
#pragma omp simd
            for (int32_t i = 0; i < nx; ++i) phi[i] *= 1 + (double)change[i];
            continue;
        }
        change[-1] = change[0];
        change[coarse_nx] = change[coarse_nx - 1];
#pragma omp simd
        for (int32_t i = 0; i < nx / 2; ++i) {
            const float here = 0.75f * change[i];
            phi[2 * i] *= 1 + (double)(here + 0.25f * change[i - 1]);
            phi[2 * i + 1] *= 1 + (double)(here + 0.25f * change[i + 1]);
        }
        if ((nx & 1) != 0) phi[nx - 1] *= 1 + (double)(0.75f * change[nx / 2] + 0.25f * change[nx / 2 - 1]);
    }
}

const ty_fas_kernels TY_KERNEL_NAME(ty_fas_kernels) = {
    .restrict_media = restrict_media,
    .restrict_phi = restrict_phi,
    .set_fas_source = set_fas_source,
    .relative_change = relative_change,
    .correct = correct,
};
