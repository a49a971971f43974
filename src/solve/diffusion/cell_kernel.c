/* Loops over planes of cells of the nonlinear problem. Compiled once per instruction set, which TY_ISA names. */
#include "solve/diffusion/cell_kernel.h"

#include "base/simd.h"
#include "solve/diffusion/cells.k.h"

/* A row of the box: couplings to the six neighbours (0 at boundaries), and the boundary terms. */
typedef struct row_view {
    const float *extinction, *absorption, *source;
    float k[6];
    float a[6], b[6];
    const float* value[6];
} row_view;

static bool is_edge(const ty_cells* cells, int32_t y, int32_t z) {
    const ty_box* box = &cells->box;
    return (y == 0 && ty_box_ends(box, 2)) || (z == 0 && ty_box_ends(box, 4)) ||
           (y == box->size[1] - 1 && ty_box_ends(box, 3)) || (z == box->size[2] - 1 && ty_box_ends(box, 5));
}

/* Cells of a row within `depth` cells of a face of the grid; returns the number of ranges. */
static int32_t ranges_within(const ty_cells* cells, int32_t depth, int32_t y, int32_t z, int32_t ranges[2][2]) {
    const int32_t *whole = cells->box.whole, nx = whole[0];
    const int32_t at_y = y + cells->box.first[1], at_z = z + cells->box.first[2];
    const bool is_full =
        at_y < depth || at_z < depth || at_y >= whole[1] - depth || at_z >= whole[2] - depth || 2 * depth >= nx;
    ranges[0][0] = 0;
    ranges[0][1] = is_full ? nx : depth;
    ranges[1][0] = nx - depth;
    ranges[1][1] = nx;
    return is_full ? 1 : 2;
}

TY_INLINE void set_side(const ty_cells* cells, row_view* view, int side, ptrdiff_t face) {
    view->k[side] = 0;
    view->a[side] = cells->sides[side].a;
    view->b[side] = cells->sides[side].b;
    view->value[side] = cells->sides[side].value + face;
}

TY_INLINE void set_interior(const ty_cells* cells, row_view* view, int side) {
    view->k[side] = cells->coupling[side / 2];
    view->a[side] = view->b[side] = 0;
    view->value[side] = cells->zeros;
}

/* Without boundaries along x. Rows are initialised in place: copying a view would stall on store forwarding. */
TY_INLINE void set_row(const ty_cells* cells, int32_t y, int32_t z, row_view* view) {
    const ptrdiff_t at = ty_box_dense(&cells->box, y, z);
    view->extinction = cells->extinction + at;
    view->absorption = cells->absorption != NULL ? cells->absorption + at : cells->zeros;
    view->source = cells->source + at;
    for (int side = 0; side < 6; ++side) set_interior(cells, view, side);
    const ty_box* box = &cells->box;
    if (y == 0 && ty_box_ends(box, 2)) set_side(cells, view, 2, cells->sides[2].step * z);
    if (y == box->size[1] - 1 && ty_box_ends(box, 3)) set_side(cells, view, 3, cells->sides[3].step * z);
    if (z == 0 && ty_box_ends(box, 4)) set_side(cells, view, 4, cells->sides[4].step * y);
    if (z == box->size[2] - 1 && ty_box_ends(box, 5)) set_side(cells, view, 5, cells->sides[5].step * y);
}

TY_INLINE void set_x_side(const ty_cells* cells, int32_t y, int32_t z, int side, row_view* view) {
    set_side(cells, view, side, cells->sides[side].step * z + y);
}

/* Cells of a colour per block of Algorithm 1, and cells relaxed together. */
enum { SOR_BLOCK = 64, SOR_LANES = 16 };

/* Every other element of a row; `to` is padded to whole vectors. Not inlined: with some 200 calls the compile time
 * would grow by a minute. */
#if defined(__AVX512F__)
/* Explicit vectors: rows are short, and compilers leave up to half of one to scalar loops. */
static __attribute__((noinline)) void every_other_float(const float* from, int32_t count, float* to) {
    const __m512i even = _mm512_setr_epi32(0, 2, 4, 6, 8, 10, 12, 14, 16, 18, 20, 22, 24, 26, 28, 30);
    for (int32_t n = 0; n < count; n += 16) {
        const uint32_t in = count - n < 16 ? (UINT32_C(1) << (2 * (count - n) - 1)) - 1 : UINT32_C(0x7fffffff);
        const __m512 low = _mm512_maskz_loadu_ps((__mmask16)in, from + 2 * n);
        const __m512 high = _mm512_maskz_loadu_ps((__mmask16)(in >> 16), from + 2 * n + 16);
        _mm512_storeu_ps(to + n, _mm512_permutex2var_ps(low, even, high));
    }
}

static __attribute__((noinline)) void every_other_double(const double* from, int32_t count, double* to) {
    const __m512i even = _mm512_setr_epi64(0, 2, 4, 6, 8, 10, 12, 14);
    for (int32_t n = 0; n < count; n += 8) {
        const uint32_t in = count - n < 8 ? (UINT32_C(1) << (2 * (count - n) - 1)) - 1 : UINT32_C(0x7fff);
        const __m512d low = _mm512_maskz_loadu_pd((__mmask8)in, from + 2 * n);
        const __m512d high = _mm512_maskz_loadu_pd((__mmask8)(in >> 8), from + 2 * n + 8);
        _mm512_storeu_pd(to + n, _mm512_permutex2var_pd(low, even, high));
    }
}
#else
#define EVERY_OTHER(type)                                                                                              \
    static __attribute__((noinline)) void every_other_##type(const type* from, int32_t count, type* to) {              \
        _Pragma("omp simd") for (int32_t n = 0; n < count; ++n) to[n] = from[2 * n];                                   \
    }
EVERY_OTHER(float)
EVERY_OTHER(double)
#undef EVERY_OTHER
#endif

#define REAL float
#define NAME(name) name##_float
#include "solve/diffusion/cell_rows.h"
#undef REAL
#undef NAME
#define REAL double
#define NAME(name) name##_double
#include "solve/diffusion/cell_rows.h"
#undef REAL
#undef NAME

#define DIFFUSE_ROWS(kind)                                                                                             \
    case kind:                                                                                                         \
        for (int32_t y = 0; y < box->size[1]; ++y) {                                                                   \
            const ptrdiff_t at = ty_box_at(box, y, z);                                                                 \
            const float* extinction = cells->extinction + ty_box_dense(box, y, z);                                     \
            _Pragma("omp simd") for (int32_t i = 0; i < box->size[0]; ++i) diffusivity[at + i] =                       \
                ty_filter_diffusivity_update(diffusivity[at + i],                                                      \
                                             diffusivity_double(cells, kind, phi + at, extinction[i], i));             \
        }                                                                                                              \
        break

/* Ghosts of D beside plane z that make the face means at the grid's faces 0. */
static void set_diffusivity_ghosts(const ty_box* box, float* diffusivity, int32_t z) {
    const int32_t nx = box->size[0], ny = box->size[1], nz = box->size[2];
    for (int32_t y = 0; y < ny; ++y) {
        float* row = diffusivity + ty_box_at(box, y, z);
        row[-1] = -row[0];
        row[nx] = -row[nx - 1];
    }
    float *low = diffusivity + ty_box_at(box, 0, z), *high = diffusivity + ty_box_at(box, ny - 1, z);
    for (int32_t x = 0; x < nx && ty_box_ends(box, 2); ++x) low[x - box->row] = -low[x];
    for (int32_t x = 0; x < nx && ty_box_ends(box, 3); ++x) high[x + box->row] = -high[x];
    const bool first = z == 0 && ty_box_ends(box, 4), last = z == nz - 1 && ty_box_ends(box, 5);
    for (int32_t y = 0; y < ny && (first || last); ++y) {
        float* row = diffusivity + ty_box_at(box, y, z);
        for (int32_t x = 0; x < nx; ++x) {
            if (first) row[x - box->plane] = -row[x];
            if (last) row[x + box->plane] = -row[x];
        }
    }
}

static void diffuse(const ty_cells* cells, const double* phi, float* diffusivity, int32_t z) {
    const ty_box* box = &cells->box;
    switch (cells->limiter) {
        DIFFUSE_ROWS(TY_LIMITER_SUM);
        DIFFUSE_ROWS(TY_LIMITER_MAX);
        DIFFUSE_ROWS(TY_LIMITER_KERSHAW);
        DIFFUSE_ROWS(TY_LIMITER_LARSEN);
        DIFFUSE_ROWS(TY_LIMITER_LEVERMORE_POMRANING);
        DIFFUSE_ROWS(TY_LIMITER_NONE);
    default: break;
    }
    set_diffusivity_ghosts(box, diffusivity, z);
}
#undef DIFFUSE_ROWS

static void damp(const ty_cells* cells, const float* diffusivity, float lambda, float* out, int32_t z) {
    const ty_box* box = &cells->box;
    for (int32_t y = 0; y < box->size[1]; ++y) {
        const float* extinction = cells->extinction + ty_box_dense(box, y, z);
        const float* d = diffusivity + ty_box_at(box, y, z);
        float* row = out + ty_box_at(box, y, z);
#pragma omp simd
        for (int32_t i = 0; i < box->size[0]; ++i)
            row[i] = ty_damped_diffusivity(d[i], ty_maxf(extinction[i], cells->min_extinction), lambda);
    }
    set_diffusivity_ghosts(box, out, z);
}

TY_INLINE double assemble_range(const ty_cells* cells, const row_view* view, const double* phi, const float* diff,
                                const ty_level* level, ptrdiff_t at, int32_t begin, int32_t end, const bool edge) {
    const ptrdiff_t row = cells->box.row, plane = cells->box.plane;
    const float* k = view->k;
    const double scale = (double)cells->scale;
    float *sink = level->d + at, *f = level->f + at;
    double sum = 0;
#pragma omp simd reduction(+ : sum)
    for (int32_t i = begin; i < end; ++i) {
        const float d = diff[i];
        const float x0 = k[0] * (d + diff[i - 1]), x1 = k[1] * (d + diff[i + 1]);
        const float y0 = k[2] * (d + diff[i - row]), y1 = k[3] * (d + diff[i + row]);
        const float z0 = k[4] * (d + diff[i - plane]), z1 = k[5] * (d + diff[i + plane]);
        const double here = phi[i];
        double residual = (double)view->source[i] * scale - (double)view->absorption[i] * here +
                          (double)x0 * (phi[i - 1] - here) + (double)x1 * (phi[i + 1] - here) +
                          (double)y0 * (phi[i - row] - here) + (double)y1 * (phi[i + row] - here) +
                          (double)z0 * (phi[i - plane] - here) + (double)z1 * (phi[i + plane] - here);
        float total_sink = view->absorption[i];
        if (edge)
            for (int s = 0; s < 6; ++s) {
                const float w = ty_cell_boundary(view->a[s], view->b[s], d);
                residual += (double)w * ((double)view->value[s][s < 2 ? 0 : i] - here);
                total_sink += w;
            }
        sink[i] = total_sink;
        f[i] = (float)residual;
        sum += residual * residual;
    }
    return sum;
}

static double assemble(const ty_cells* cells, const double* phi, const float* diffusivity, const ty_level* level,
                       int32_t z) {
    const int32_t nx = cells->box.size[0];
    double sum = 0;
    for (int32_t y = 0; y < cells->box.size[1]; ++y) {
        const ptrdiff_t at = ty_box_at(&cells->box, y, z);
        const double* row = phi + at;
        const float* diff = diffusivity + at;
        row_view view;
        set_row(cells, y, z, &view);
        set_x_side(cells, y, z, 0, &view);
        if (nx == 1) set_x_side(cells, y, z, 1, &view);
        sum += assemble_range(cells, &view, row, diff, level, at, 0, 1, true);
        set_interior(cells, &view, 0);
        sum += is_edge(cells, y, z) ? assemble_range(cells, &view, row, diff, level, at, 1, nx - 1, true)
                                    : assemble_range(cells, &view, row, diff, level, at, 1, nx - 1, false);
        if (nx == 1) continue;
        set_x_side(cells, y, z, 1, &view);
        sum += assemble_range(cells, &view, row, diff, level, at, nx - 1, nx, true);
    }
    return sum;
}

static void update(const ty_cells* cells, const float* x, double* phi, int32_t z) {
    const double min_fraction = cells->limiter != TY_LIMITER_NONE ? (double)TY_POSITIVITY_FLOOR : -1e300;
    for (int32_t y = 0; y < cells->box.size[1]; ++y) {
        const ptrdiff_t at = ty_box_at(&cells->box, y, z);
        double* row = phi + at;
        const float* change = x + at;
#pragma omp simd
        for (int32_t i = 0; i < cells->box.size[0]; ++i) {
            const double next = row[i] + (double)change[i],
                         min_phi = min_fraction > 0 ? min_fraction * row[i] : min_fraction;
            row[i] = next > min_phi ? next : min_phi;
        }
    }
}

const ty_cell_kernels TY_KERNEL_NAME(ty_cell_kernels) = {
    .ghosts = ghosts_double,
    .ghosts_float = ghosts_float,
    .diffuse = diffuse,
    .damp = damp,
    .assemble = assemble,
    .sor = sor_double,
    .sor_float = sor_float,
    .update = update,
};
