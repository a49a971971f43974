/* Loops over planes of a level of multigrid; built once per instruction set, with TY_ISA naming it. */
#include "solve/kernel.h"

#include "solve/level.k.h"

#include <string.h>

#define TY_JOIN_(a, b) a##b
#define TY_JOIN(a, b) TY_JOIN_(a, b)

/* Items of a row on the stack. */
enum { ROW_ITEMS = TY_DIFFUSION_SIDE_MAX };

static void relax(const ty_level* level, int32_t color, int32_t z) {
    const ptrdiff_t row = level->box.row, plane = level->box.plane;
    for (int32_t y = 0; y < level->box.size[1]; ++y) {
        const ptrdiff_t at = ty_box_at(&level->box, y, z);
        const float *gx = level->g[0] + at, *gy = level->g[1] + at, *gz = level->g[2] + at, *d = level->d + at;
        const float* f = level->f + at;
        float* e = level->e + at;
#pragma omp simd
        for (int32_t i = (color + y + z) & 1; i < level->box.size[0]; i += 2)
            e[i] = ty_level_relax(gx, gy, gz, d, f, e, row, plane, i);
    }
}

/* ---- between levels ---- */

/* Adds pairs of items, or copies them where one cell makes one. */
static void pair_up(const float* items, int32_t count, int32_t children, float* out) {
    if (children == 1) {
        memcpy(out, items, sizeof(float) * (size_t)count);
        return;
    }
#pragma omp simd
    for (int32_t i = 0; i < count / 2; ++i) out[i] = items[2 * i] + items[2 * i + 1];
    if ((count & 1) != 0) out[count / 2] = items[count - 1];
}

/* The end of the finer cells that make coarse cell i along an axis. */
static int32_t children_end(const ty_level* fine, const ty_level* coarse, int axis, int32_t i) {
    const int32_t end = (i + 1) * coarse->children[axis];
    return end < fine->box.size[axis] ? end : fine->box.size[axis];
}

static void add_residual(const ty_level* fine, int32_t y, int32_t z, float* sum) {
    const ptrdiff_t at = ty_box_at(&fine->box, y, z), row = fine->box.row, plane = fine->box.plane;
    const float *gx = fine->g[0] + at, *gy = fine->g[1] + at, *gz = fine->g[2] + at, *d = fine->d + at;
    const float *e = fine->e + at, *f = fine->f + at;
#pragma omp simd
    for (int32_t i = 0; i < fine->box.size[0]; ++i) sum[i] += f[i] - ty_level_apply(gx, gy, gz, d, e, row, plane, i);
}

static void restrict_residual(const ty_level* fine, const ty_level* coarse, int32_t z) {
    float sum[ROW_ITEMS];
    const int32_t nx = fine->box.size[0], z_end = children_end(fine, coarse, 2, z);
    for (int32_t y = 0; y < coarse->box.size[1]; ++y) {
        const int32_t y_end = children_end(fine, coarse, 1, y);
        memset(sum, 0, sizeof(float) * (size_t)nx);
        for (int32_t fz = z * coarse->children[2]; fz < z_end; ++fz)
            for (int32_t fy = y * coarse->children[1]; fy < y_end; ++fy) add_residual(fine, fy, fz, sum);
        const ptrdiff_t at = ty_box_at(&coarse->box, y, z);
        pair_up(sum, nx, coarse->children[0], coarse->f + at);
        memset(coarse->e + at, 0, sizeof(float) * (size_t)coarse->box.size[0]);
    }
}

static void prolong(const ty_level* fine, const ty_level* coarse, int32_t z) {
    const int32_t nx = fine->box.size[0];
    for (int32_t y = 0; y < fine->box.size[1]; ++y) {
        const ptrdiff_t from = ty_box_at(&coarse->box, y / coarse->children[1], z / coarse->children[2]);
        const float* parents = coarse->e + from;
        float* e = fine->e + ty_box_at(&fine->box, y, z);
        if (coarse->children[0] == 1) {
#pragma omp simd
            for (int32_t i = 0; i < nx; ++i) e[i] += parents[i];
            continue;
        }
#pragma omp simd
        for (int32_t i = 0; i < nx / 2; ++i) {
            e[2 * i] += parents[i];
            e[2 * i + 1] += parents[i];
        }
        if ((nx & 1) != 0) e[nx - 1] += parents[nx / 2];
    }
}

/* Sums of g over the fine faces below fine cell `index` along an axis, for a coarse row: sum[i] for each fine x. */
static void sum_faces(const ty_level* fine, const ty_level* coarse, const float* g, int axis, int32_t index, int32_t y,
                      int32_t z, float* sum) {
    int32_t begin[3] = {0, y * coarse->children[1], z * coarse->children[2]};
    int32_t end[3] = {0, children_end(fine, coarse, 1, y), children_end(fine, coarse, 2, z)};
    if (axis != 0) {
        begin[axis] = index;
        end[axis] = index + 1;
    }
    memset(sum, 0, sizeof(float) * (size_t)fine->box.size[0]);
    for (int32_t fz = begin[2]; fz < end[2]; ++fz)
        for (int32_t fy = begin[1]; fy < end[1]; ++fy) {
            const float* row = g + ty_box_at(&fine->box, fy, fz);
#pragma omp simd
            for (int32_t i = 0; i < fine->box.size[0]; ++i) sum[i] += row[i];
        }
}

/* What couplings between coarse cells are of the sum of those between their children: centres are twice as far apart.
 */
static float distance_share(const ty_level* coarse, int axis) {
    return coarse->children[axis] == 2 ? 0.5f : 1.0f;
}

/* Faces below a coarse row along y or z. */
static void coarsen_across(const ty_level* fine, const ty_level* coarse, int axis, int32_t y, int32_t z) {
    float sum[ROW_ITEMS];
    const int32_t index = (axis == 1 ? y : z) * coarse->children[axis];
    const float share = distance_share(coarse, axis);
    sum_faces(fine, coarse, fine->g[axis], axis, index, y, z, sum);
    float* g = coarse->g[axis] + ty_box_at(&coarse->box, y, z);
    pair_up(sum, fine->box.size[0], coarse->children[0], g);
#pragma omp simd
    for (int32_t i = 0; i < coarse->box.size[0]; ++i) g[i] *= share;
}

static void coarsen_along(const ty_level* fine, const ty_level* coarse, int32_t y, int32_t z) {
    float sum[ROW_ITEMS];
    const int32_t children = coarse->children[0];
    const float share = distance_share(coarse, 0);
    sum_faces(fine, coarse, fine->g[0], 0, 0, y, z, sum);
    float* g = coarse->g[0] + ty_box_at(&coarse->box, y, z);
    for (int32_t i = 0; i < coarse->box.size[0]; ++i) g[i] = share * sum[i * children];
}

static void coarsen_sinks(const ty_level* fine, const ty_level* coarse, int32_t y, int32_t z) {
    float sum[ROW_ITEMS];
    sum_faces(fine, coarse, fine->d, 0, 0, y, z, sum);
    pair_up(sum, fine->box.size[0], coarse->children[0], coarse->d + ty_box_at(&coarse->box, y, z));
}

static void coarsen(const ty_level* fine, const ty_level* coarse, int32_t z) {
    for (int32_t y = 0; y < coarse->box.size[1]; ++y) {
        coarsen_sinks(fine, coarse, y, z);
        coarsen_along(fine, coarse, y, z);
        if (y > 0) coarsen_across(fine, coarse, 1, y, z);
        if (z > 0) coarsen_across(fine, coarse, 2, y, z);
    }
}

/* ---- conjugate gradients ---- */

static ty_plane_sums apply(const ty_level* level, const float* p, float* out, int32_t z) {
    const ptrdiff_t row = level->box.row, plane = level->box.plane;
    ty_plane_sums sums = {0};
    for (int32_t y = 0; y < level->box.size[1]; ++y) {
        const ptrdiff_t at = ty_box_at(&level->box, y, z);
        const float *gx = level->g[0] + at, *gy = level->g[1] + at, *gz = level->g[2] + at, *d = level->d + at;
        const float* in = p + at;
        float *to = out + at, sum = 0;
#pragma omp simd reduction(+ : sum)
        for (int32_t i = 0; i < level->box.size[0]; ++i) {
            to[i] = ty_level_apply(gx, gy, gz, d, in, row, plane, i);
            sum += to[i] * in[i];
        }
        sums.a += (double)sum;
    }
    return sums;
}

static ty_plane_sums dots(const ty_level* level, const float* out, int32_t z) {
    ty_plane_sums sums = {0};
    for (int32_t y = 0; y < level->box.size[1]; ++y) {
        const ptrdiff_t at = ty_box_at(&level->box, y, z);
        const float *e = level->e + at, *f = level->f + at, *other = out + at;
        float a = 0, b = 0;
#pragma omp simd reduction(+ : a, b)
        for (int32_t i = 0; i < level->box.size[0]; ++i) {
            a += f[i] * e[i];
            b += e[i] * other[i];
        }
        sums.a += (double)a;
        sums.b += (double)b;
    }
    return sums;
}

static void direct(const ty_level* level, float beta, float* p, int32_t z) {
    for (int32_t y = 0; y < level->box.size[1]; ++y) {
        const ptrdiff_t at = ty_box_at(&level->box, y, z);
        const float* e = level->e + at;
        float* row = p + at;
#pragma omp simd
        for (int32_t i = 0; i < level->box.size[0]; ++i) row[i] = e[i] + beta * row[i];
    }
}

static ty_plane_sums step(const ty_level* level, float alpha, const float* p, const float* out, float* x, int32_t z) {
    ty_plane_sums sums = {0};
    for (int32_t y = 0; y < level->box.size[1]; ++y) {
        const ptrdiff_t at = ty_box_at(&level->box, y, z);
        const float *direction = p + at, *image = out + at;
        float *f = level->f + at, *change = x + at, sum = 0;
#pragma omp simd reduction(+ : sum)
        for (int32_t i = 0; i < level->box.size[0]; ++i) {
            change[i] += alpha * direction[i];
            f[i] -= alpha * image[i];
            sum += f[i] * f[i];
        }
        sums.a += (double)sum;
    }
    return sums;
}

const ty_level_kernels TY_JOIN(ty_level_kernels_, TY_ISA) = {
    .relax = relax,
    .restrict_residual = restrict_residual,
    .prolong = prolong,
    .coarsen = coarsen,
    .apply = apply,
    .dots = dots,
    .direct = direct,
    .step = step,
};
