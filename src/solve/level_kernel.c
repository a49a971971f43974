/* Loops over planes of a level of multigrid; built once per instruction set, with TY_ISA naming it. */
#include "solve/kernel.h"

#include "solve/level.k.h"

#include <string.h>

#define TY_JOIN_(a, b) a##b
#define TY_JOIN(a, b) TY_JOIN_(a, b)

/* Items of a row on the stack, with room for a ghost before and after. */
enum { ROW_ITEMS = TY_DIFFUSION_SIDE_MAX + 16, FIRST = 8 };

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

/* The coarse cells that a fine one lies between along an axis, and the share of the farther. */
static float find_parents(const ty_level* fine, const ty_level* coarse, int axis, int32_t i, int32_t parents[2]) {
    const int32_t children = coarse->children[axis], last = coarse->box.size[axis] - 1;
    parents[0] = i / children;
    parents[1] = parents[0];
    if (children == 1 || i + 1 == (fine->box.size[axis] | 1)) return 0;
    const int32_t other = (i & 1) != 0 ? parents[0] + 1 : parents[0] - 1;
    if (other < 0 || other > last) return 0;
    parents[1] = other;
    return 0.25f;
}

static void add_row(const float* coarse, int32_t count, int32_t children, float* out) {
    if (children == 1) {
#pragma omp simd
        for (int32_t i = 0; i < count; ++i) out[i] += coarse[i];
        return;
    }
#pragma omp simd
    for (int32_t i = 0; i < count / 2; ++i) {
        const float near = 0.75f * coarse[i];
        out[2 * i] += near + 0.25f * coarse[i - 1];
        out[2 * i + 1] += near + 0.25f * coarse[i + 1];
    }
    if ((count & 1) != 0) out[count - 1] += coarse[count / 2];
}

static void prolong(const ty_level* fine, const ty_level* coarse, int32_t z) {
    float mixed[ROW_ITEMS];
    int32_t zs[2], ys[2];
    const int32_t nx = coarse->box.size[0];
    const float far_z = find_parents(fine, coarse, 2, z, zs);
    for (int32_t y = 0; y < fine->box.size[1]; ++y) {
        const float far_y = find_parents(fine, coarse, 1, y, ys);
        const float* a = coarse->e + ty_box_at(&coarse->box, ys[0], zs[0]);
        const float* b = coarse->e + ty_box_at(&coarse->box, ys[1], zs[0]);
        const float* c = coarse->e + ty_box_at(&coarse->box, ys[0], zs[1]);
        const float* d = coarse->e + ty_box_at(&coarse->box, ys[1], zs[1]);
        const float of_a = (1 - far_y) * (1 - far_z), of_b = far_y * (1 - far_z), of_c = (1 - far_y) * far_z,
                    of_d = far_y * far_z;
        float* row = mixed + FIRST;
#pragma omp simd
        for (int32_t i = 0; i < nx; ++i) row[i] = of_a * a[i] + of_b * b[i] + (of_c * c[i] + of_d * d[i]);
        row[-1] = row[0];
        row[nx] = row[nx - 1];
        add_row(row, fine->box.size[0], coarse->children[0], fine->e + ty_box_at(&fine->box, y, z));
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

static void fill(float* items, int32_t count, float value) {
    for (int32_t i = 0; i < count; ++i) items[i] = value;
}

/* Faces below a coarse row along y or z. */
static void coarsen_across(const ty_level* fine, const ty_level* coarse, int axis, int32_t y, int32_t z) {
    const int32_t children = coarse->children[axis], nx = coarse->box.size[0], at = (axis == 1 ? y : z) * children;
    float sum[ROW_ITEMS], pairs[3][TY_DIFFUSION_SIDE_MAX];
    for (int side = 0; side < 3; ++side) {
        const int32_t index = at + side - 1;
        if (side == 1 || (children == 2 && index < fine->box.size[axis])) {
            sum_faces(fine, coarse, fine->g[axis], axis, index, y, z, sum);
            pair_up(sum, fine->box.size[0], coarse->children[0], pairs[side]);
        } else {
            fill(pairs[side], nx, TY_FLOAT_MAX);
        }
    }
    float* g = coarse->g[axis] + ty_box_at(&coarse->box, y, z);
#pragma omp simd
    for (int32_t i = 0; i < nx; ++i) g[i] = ty_level_series(pairs[0][i], pairs[1][i], pairs[2][i]);
}

static void coarsen_along(const ty_level* fine, const ty_level* coarse, int32_t y, int32_t z) {
    float sum[ROW_ITEMS];
    const int32_t nx = coarse->box.size[0], fine_nx = fine->box.size[0];
    sum_faces(fine, coarse, fine->g[0], 0, 0, y, z, sum);
    float* g = coarse->g[0] + ty_box_at(&coarse->box, y, z);
    if (coarse->children[0] == 1) {
        memcpy(g, sum, sizeof(float) * (size_t)nx);
        return;
    }
    if ((fine_nx & 1) != 0) sum[fine_nx] = TY_FLOAT_MAX;
    g[0] = 0;
#pragma omp simd
    for (int32_t i = 1; i < nx; ++i) g[i] = ty_level_series(sum[2 * i - 1], sum[2 * i], sum[2 * i + 1]);
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
