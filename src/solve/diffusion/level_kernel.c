/* Loops over planes of a multigrid level. Compiled once per instruction set, which TY_ISA names. */
#include "solve/diffusion/cell_kernel.h"

#include "base/simd.h"
#include "solve/diffusion/level.k.h"

#include <string.h>

/* Capacity of a row on the stack. */
enum { ROW_ITEMS = TY_DIFFUSION_SIDE_MAX };
/* Cells relaxed together. */
enum { BLOCK = 32 };

/* A row of a level. */
typedef struct level_row {
    const float *gx, *gy, *gz; /* stored couplings, or */
    const float* diffusivity;  /* D from which they are derived */
    float k[3];
    const float *sink, *f;
    float* e;
    ptrdiff_t row, plane;
} level_row;

TY_INLINE level_row row_of(const ty_level* level, int32_t y, int32_t z) {
    const ptrdiff_t at = ty_box_at(&level->box, y, z);
    level_row r = {.sink = level->d + at,
                   .f = level->f + at,
                   .e = level->e + at,
                   .row = level->box.row,
                   .plane = level->box.plane};
    if (level->diffusivity != NULL) {
        r.diffusivity = level->diffusivity + at;
        memcpy(r.k, level->coupling, sizeof r.k);
        return r;
    }
    r.gx = level->g[0] + at;
    r.gy = level->g[1] + at;
    r.gz = level->g[2] + at;
    return r;
}

TY_INLINE ty_level_faces faces_at(const level_row* r, const bool from_diffusivity, ptrdiff_t i) {
    return from_diffusivity ? ty_level_faces_made(r->diffusivity, r->k[0], r->k[1], r->k[2], r->row, r->plane, i)
                            : ty_level_faces_stored(r->gx, r->gy, r->gz, r->row, r->plane, i);
}

/* Calls row_fn(&row, from_diffusivity, ...) with a constant flag. */
#define WITH_FACES(row_fn, r, ...)                                                                                     \
    ((r).diffusivity != NULL ? row_fn(&(r), true, __VA_ARGS__) : row_fn(&(r), false, __VA_ARGS__))

/* Relaxes cells of a colour from `begin` with stride 2. */
TY_INLINE void relax_strided(const level_row* row, const bool from_diffusivity, int32_t begin, int32_t count) {
    const level_row r = *row;
#pragma omp simd
    for (int32_t i = begin; i < count; i += 2)
        r.e[i] = ty_level_relax(faces_at(&r, from_diffusivity, i), r.sink[i], r.f[i], r.e, r.row, r.plane, i);
}

/* Relaxes a block by evaluating all its cells and discarding the results of the other colour. */
TY_INLINE void relax_block(const level_row* row, const bool from_diffusivity, int32_t first, int32_t begin,
                           const int32_t cells) {
    const level_row r = *row;
    float next[BLOCK];
#pragma omp simd
    for (int32_t i = 0; i < cells; ++i)
        next[i] = ty_level_relax(faces_at(&r, from_diffusivity, begin + i), r.sink[begin + i], r.f[begin + i], r.e,
                                 r.row, r.plane, begin + i);
    for (int32_t i = 0; i < cells / 2; ++i) r.e[begin + first + 2 * i] = next[first + 2 * i];
}

/* Blocks are faster: vector loads are contiguous, and no scalar remainder is left at the end of a row. */
TY_INLINE void relax_row(const level_row* row, const bool from_diffusivity, int32_t first, int32_t count, bool alone) {
    int32_t begin = 0;
    for (; alone && begin + BLOCK <= count; begin += BLOCK) relax_block(row, from_diffusivity, first, begin, BLOCK);
    for (; alone && begin + BLOCK / 4 <= count; begin += BLOCK / 4)
        relax_block(row, from_diffusivity, first, begin, BLOCK / 4);
    relax_strided(row, from_diffusivity, begin + first, count);
}

TY_INLINE void relax_row_from_zero(const level_row* row, const bool from_diffusivity, int32_t first, int32_t count) {
    const level_row r = *row;
#pragma omp simd
    for (int32_t i = first; i < count; i += 2)
        r.e[i] = r.f[i] / ty_level_diagonal(faces_at(&r, from_diffusivity, i), r.sink[i]);
}

static void relax(const ty_level* level, int32_t color, const int32_t rows[2], int32_t z, bool alone) {
    for (int32_t y = rows[0]; y < rows[1]; ++y) {
        const level_row r = row_of(level, y, z);
        WITH_FACES(relax_row, r, (color + y + z) & 1, level->box.size[0], alone);
    }
}

static void begin(const ty_level* level, int32_t color, const int32_t rows[2], int32_t z) {
    for (int32_t y = rows[0]; y < rows[1]; ++y) {
        const level_row r = row_of(level, y, z);
        WITH_FACES(relax_row_from_zero, r, (color + y + z) & 1, level->box.size[0]);
    }
}

/* ---- between levels ---- */

/* Adds pairs of items, or copies them where a coarse cell has one child. */
static void sum_pairs(const float* items, int32_t count, int32_t children, float* out) {
    if (children == 1) {
        memcpy(out, items, sizeof(float) * (size_t)count);
        return;
    }
#pragma omp simd
    for (int32_t i = 0; i < count / 2; ++i) out[i] = items[2 * i] + items[2 * i + 1];
    if ((count & 1) != 0) out[count / 2] = items[count - 1];
}

/* End of the finer cells within coarse cell i along an axis. */
static int32_t children_end(const ty_level* fine, const ty_level* coarse, int axis, int32_t i) {
    const int32_t end = (i + 1) * coarse->children[axis];
    return end < fine->box.size[axis] ? end : fine->box.size[axis];
}

/* Returns the sum of squares. */
TY_INLINE float add_residual(const level_row* row, const bool from_diffusivity, int32_t count, float* sum) {
    const level_row r = *row;
    float squares = 0;
#pragma omp simd reduction(+ : squares)
    for (int32_t i = 0; i < count; ++i) {
        const float residual =
            r.f[i] - ty_level_apply(faces_at(&r, from_diffusivity, i), r.sink[i], r.e, r.row, r.plane, i);
        sum[i] += residual;
        squares += residual * residual;
    }
    return squares;
}

static double restrict_residual(const ty_level* fine, const ty_level* coarse, int32_t z) {
    float sum[ROW_ITEMS];
    double squares = 0;
    const int32_t nx = fine->box.size[0], z_end = children_end(fine, coarse, 2, z);
    for (int32_t y = 0; y < coarse->box.size[1]; ++y) {
        const int32_t y_end = children_end(fine, coarse, 1, y);
        memset(sum, 0, sizeof(float) * (size_t)nx);
        for (int32_t fz = z * coarse->children[2]; fz < z_end; ++fz)
            for (int32_t fy = y * coarse->children[1]; fy < y_end; ++fy) {
                const level_row r = row_of(fine, fy, fz);
                squares += (double)WITH_FACES(add_residual, r, nx, sum);
            }
        sum_pairs(sum, nx, coarse->children[0], coarse->f + ty_box_at(&coarse->box, y, z));
    }
    return squares;
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

/* Adds the couplings of a fine row through its lower faces along an axis. */
static void add_faces(const ty_level* fine, int axis, int32_t y, int32_t z, float* sum) {
    const ptrdiff_t at = ty_box_at(&fine->box, y, z);
    const int32_t count = fine->box.size[0];
    if (fine->diffusivity == NULL) {
        const float* g = fine->g[axis] + at;
#pragma omp simd
        for (int32_t i = 0; i < count; ++i) sum[i] += g[i];
        return;
    }
    const ptrdiff_t below = axis == 0 ? 1 : axis == 1 ? fine->box.row : fine->box.plane;
    const float *d = fine->diffusivity + at, k = fine->coupling[axis];
#pragma omp simd
    for (int32_t i = 0; i < count; ++i) sum[i] += k * (d[i] + d[i - below]);
}

static void add_sinks(const ty_level* fine, int32_t y, int32_t z, float* sum) {
    const float* sink = fine->d + ty_box_at(&fine->box, y, z);
#pragma omp simd
    for (int32_t i = 0; i < fine->box.size[0]; ++i) sum[i] += sink[i];
}

/* Sums over the fine rows of a coarse one, per fine x: couplings through the lower faces of fine cell `index` along an
 * axis, or sinks. */
enum { SINKS = -1 };

static void sum_faces(const ty_level* fine, const ty_level* coarse, int axis, int32_t index, int32_t y, int32_t z,
                      float* sum) {
    int32_t begin[3] = {0, y * coarse->children[1], z * coarse->children[2]};
    int32_t end[3] = {0, children_end(fine, coarse, 1, y), children_end(fine, coarse, 2, z)};
    if (axis > 0) {
        begin[axis] = index;
        end[axis] = index + 1;
    }
    memset(sum, 0, sizeof(float) * (size_t)fine->box.size[0]);
    for (int32_t fz = begin[2]; fz < end[2]; ++fz)
        for (int32_t fy = begin[1]; fy < end[1]; ++fy)
            if (axis == SINKS)
                add_sinks(fine, fy, fz, sum);
            else
                add_faces(fine, axis, fy, fz, sum);
}

/* Ratio of a coarse coupling to the sum of its children's: centers are twice as far apart. */
static float coupling_ratio(const ty_level* coarse, int axis) {
    return coarse->children[axis] == 2 ? 0.5f : 1.0f;
}

/* Lower faces of a coarse row along y or z. */
static void coarsen_across(const ty_level* fine, const ty_level* coarse, int axis, int32_t y, int32_t z) {
    float sum[ROW_ITEMS];
    const int32_t index = (axis == 1 ? y : z) * coarse->children[axis];
    const float ratio = coupling_ratio(coarse, axis);
    sum_faces(fine, coarse, axis, index, y, z, sum);
    float* g = coarse->g[axis] + ty_box_at(&coarse->box, y, z);
    sum_pairs(sum, fine->box.size[0], coarse->children[0], g);
#pragma omp simd
    for (int32_t i = 0; i < coarse->box.size[0]; ++i) g[i] *= ratio;
}

static void coarsen_along(const ty_level* fine, const ty_level* coarse, int32_t y, int32_t z) {
    float sum[ROW_ITEMS];
    const int32_t children = coarse->children[0];
    const float ratio = coupling_ratio(coarse, 0);
    sum_faces(fine, coarse, 0, 0, y, z, sum);
    float* g = coarse->g[0] + ty_box_at(&coarse->box, y, z);
    for (int32_t i = 0; i < coarse->box.size[0]; ++i) g[i] = ratio * sum[i * children];
}

static void coarsen_sinks(const ty_level* fine, const ty_level* coarse, int32_t y, int32_t z) {
    float sum[ROW_ITEMS];
    sum_faces(fine, coarse, SINKS, 0, y, z, sum);
    sum_pairs(sum, fine->box.size[0], coarse->children[0], coarse->d + ty_box_at(&coarse->box, y, z));
}

static void coarsen(const ty_level* fine, const ty_level* coarse, int32_t z) {
    for (int32_t y = 0; y < coarse->box.size[1]; ++y) {
        coarsen_sinks(fine, coarse, y, z);
        coarsen_along(fine, coarse, y, z);
        if (y > 0 || !ty_box_ends(&coarse->box, 2)) coarsen_across(fine, coarse, 1, y, z);
        if (z > 0 || !ty_box_ends(&coarse->box, 4)) coarsen_across(fine, coarse, 2, y, z);
    }
}

/* ---- conjugate gradients ---- */

static double dot(const ty_level* level, int32_t z) {
    double sum = 0;
    for (int32_t y = 0; y < level->box.size[1]; ++y) {
        const ptrdiff_t at = ty_box_at(&level->box, y, z);
        const float *e = level->e + at, *f = level->f + at;
        float a = 0;
#pragma omp simd reduction(+ : a)
        for (int32_t i = 0; i < level->box.size[0]; ++i) a += f[i] * e[i];
        sum += (double)a;
    }
    return sum;
}

static void update_direction(const ty_level* level, float beta, float* p, int32_t z) {
    for (int32_t y = 0; y < level->box.size[1]; ++y) {
        const ptrdiff_t at = ty_box_at(&level->box, y, z);
        const float* e = level->e + at;
        float* row = p + at;
#pragma omp simd
        for (int32_t i = 0; i < level->box.size[0]; ++i) row[i] = e[i] + beta * row[i];
    }
}

TY_INLINE float apply_row(const level_row* row, const bool from_diffusivity, int32_t count, const float* p) {
    const level_row r = *row;
    float sum = 0;
#pragma omp simd reduction(+ : sum)
    for (int32_t i = 0; i < count; ++i) {
        const float image = ty_level_apply(faces_at(&r, from_diffusivity, i), r.sink[i], p, r.row, r.plane, i);
        r.e[i] = image;
        sum += image * p[i];
    }
    return sum;
}

static double apply(const ty_level* level, const float* p, int32_t z) {
    double sum = 0;
    for (int32_t y = 0; y < level->box.size[1]; ++y) {
        const level_row r = row_of(level, y, z);
        const float* in = p + ty_box_at(&level->box, y, z);
        sum += (double)WITH_FACES(apply_row, r, level->box.size[0], in);
    }
    return sum;
}

static double step(const ty_level* level, float alpha, const float* p, float* x, int32_t z) {
    double total = 0;
    for (int32_t y = 0; y < level->box.size[1]; ++y) {
        const ptrdiff_t at = ty_box_at(&level->box, y, z);
        const float *direction = p + at, *image = level->e + at;
        float *f = level->f + at, *change = x + at, sum = 0;
#pragma omp simd reduction(+ : sum)
        for (int32_t i = 0; i < level->box.size[0]; ++i) {
            change[i] += alpha * direction[i];
            f[i] -= alpha * image[i];
            sum += f[i] * f[i];
        }
        total += (double)sum;
    }
    return total;
}

const ty_level_kernels TY_KERNEL_NAME(ty_level_kernels) = {
    .begin = begin,
    .relax = relax,
    .restrict_residual = restrict_residual,
    .prolong = prolong,
    .coarsen = coarsen,
    .dot = dot,
    .update_direction = update_direction,
    .apply = apply,
    .step = step,
};
