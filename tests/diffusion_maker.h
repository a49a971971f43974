/* Diffusion problems for tests: boxes of cells filled from functions of their centres. */
#ifndef TY_TESTS_DIFFUSION_MAKER_H
#define TY_TESTS_DIFFUSION_MAKER_H

#include "solve/diffusion/diffusion.h"

#include "checks.h"

#include <string.h>

typedef struct problem {
    ty_diffusion_def def;
    ty_diffusion_out out;
    ty_diffusion_stats stats;
    size_t cells;
    float *extinction, *absorption, *source, *fluence, *diffusivity;
} problem;

static inline float* make_floats(size_t count) {
    float* floats = calloc(count, sizeof *floats);
    assert_non_null(floats);
    return floats;
}

/* A box `extent` m long with nx x ny x nz cells, of extinction 1/m, without absorption and source. */
static inline problem make_problem(int32_t nx, int32_t ny, int32_t nz, double extent, float extinction) {
    problem p = {.def = ty_default_diffusion_def(), .cells = (size_t)nx * (size_t)ny * (size_t)nz};
    const int32_t size[3] = {nx, ny, nz};
    for (int axis = 0; axis < 3; ++axis) {
        p.def.size[axis] = size[axis];
        p.def.cell[axis] = extent / nx;
    }
    p.extinction = make_floats(p.cells);
    p.absorption = make_floats(p.cells);
    p.source = make_floats(p.cells);
    p.fluence = make_floats(p.cells);
    p.diffusivity = make_floats(p.cells);
    for (size_t i = 0; i < p.cells; ++i) p.extinction[i] = extinction;
    p.def.extinction = p.extinction;
    p.def.absorption = p.absorption;
    p.def.source = p.source;
    p.out.fluence = p.fluence;
    p.out.diffusivity = p.diffusivity;
    return p;
}

static inline void free_problem(problem* p) {
    float* const arrays[] = {p->extinction, p->absorption, p->source, p->fluence, p->diffusivity};
    for (size_t i = 0; i < sizeof arrays / sizeof *arrays; ++i) free(arrays[i]);
}

static inline void set_boundaries(problem* p, ty_boundary_kind kind) {
    for (int side = 0; side < 6; ++side) p->def.boundary[side] = (ty_boundary){.kind = kind};
}

static inline size_t cell_index(const problem* p, int32_t x, int32_t y, int32_t z) {
    return ((size_t)z * (size_t)p->def.size[1] + (size_t)y) * (size_t)p->def.size[0] + (size_t)x;
}

/* Calls fill(p, index, centre in m). */
static inline void fill_problem(problem* p, void (*fill)(problem* p, size_t i, const double at[3])) {
    for (int32_t z = 0; z < p->def.size[2]; ++z)
        for (int32_t y = 0; y < p->def.size[1]; ++y)
            for (int32_t x = 0; x < p->def.size[0]; ++x) {
                const double at[3] = {(x + 0.5) * p->def.cell[0], (y + 0.5) * p->def.cell[1],
                                      (z + 0.5) * p->def.cell[2]};
                fill(p, cell_index(p, x, y, z), at);
            }
}

/* Solves, and asserts that it converged. */
static inline void solve_problem(ty_context* context, problem* p) {
    if (ty_diffusion_solve(context, &p->def, &p->out, &p->stats) != TY_OK) fail_msg("%s", ty_take_error(context));
    if (!p->stats.converged) fail_msg("residual %g after %d iterations", p->stats.residual, (int)p->stats.iterations);
}

/* Faces of a side with values of a function of their centres; freed by the caller. */
static inline float* face_values(const problem* p, int side, double (*value)(const double at[3])) {
    const int axis = side / 2, u = axis == 0 ? 1 : 0, v = axis == 2 ? 1 : 2;
    float* values = make_floats((size_t)p->def.size[u] * (size_t)p->def.size[v]);
    for (int32_t j = 0; j < p->def.size[v]; ++j)
        for (int32_t i = 0; i < p->def.size[u]; ++i) {
            double at[3];
            at[axis] = (side & 1) != 0 ? p->def.cell[axis] * p->def.size[axis] : 0;
            at[u] = (i + 0.5) * p->def.cell[u];
            at[v] = (j + 0.5) * p->def.cell[v];
            values[(size_t)j * (size_t)p->def.size[u] + (size_t)i] = (float)value(at);
        }
    return values;
}

/* Dirichlet boundaries all around, of a function. */
static inline void set_faces(problem* p, float* values[6], double (*value)(const double at[3])) {
    for (int side = 0; side < 6; ++side) {
        values[side] = face_values(p, side, value);
        p->def.boundary[side] = (ty_boundary){.kind = TY_BOUNDARY_DIRICHLET, .value = values[side]};
    }
}

/* The largest difference of two fluences, relative to the larger. */
static inline double largest_difference(const float* a, const float* b, size_t count) {
    double largest = 0;
    for (size_t i = 0; i < count; ++i) {
        const double scale = fmax(fabs((double)a[i]), fabs((double)b[i]));
        if (scale > 0) largest = fmax(largest, fabs((double)a[i] - (double)b[i]) / scale);
    }
    return largest;
}

/* A box of cells whose outer faces are closed, and those between the cells `split` - 1 and `split` along
 * an axis (0: none). */
typedef struct closed_box {
    ty_diffusion_faces faces;
    int32_t *first, *x;
    uint8_t *face, *closed;
    float *albedo, *radiosity, *staircase;
} closed_box;

static inline closed_box close_box(const problem* p, int axis, int32_t split, float albedo, float radiosity) {
    const int32_t* size = p->def.size;
    const size_t rows = (size_t)size[1] * (size_t)size[2], max_sides = 6 * p->cells;
    closed_box box = {.first = calloc(rows + 1, sizeof *box.first),
                      .x = calloc(max_sides, sizeof *box.x),
                      .face = calloc(max_sides, 1),
                      .closed = calloc(p->cells, 1),
                      .albedo = make_floats(max_sides),
                      .radiosity = make_floats(max_sides),
                      .staircase = make_floats(max_sides)};
    int32_t count = 0;
    for (size_t row = 0; row < rows; ++row) {
        box.first[row] = count;
        int32_t at[3] = {0, (int32_t)row % size[1], (int32_t)row / size[1]};
        for (; at[0] < size[0]; ++at[0])
            for (uint8_t face = 0; face < 6; ++face) {
                const bool up = (face & 1) != 0;
                const bool outer = at[face / 2] == (up ? size[face / 2] - 1 : 0);
                if (!outer && !(face / 2 == axis && split > 0 && at[axis] == (up ? split - 1 : split))) continue;
                box.closed[row * (size_t)size[0] + (size_t)at[0]] |= (uint8_t)(1 << face);
                box.x[count] = at[0];
                box.face[count] = face;
                box.albedo[count] = albedo;
                box.radiosity[count] = radiosity;
                box.staircase[count++] = 1;
            }
    }
    box.first[rows] = count;
    box.faces =
        (ty_diffusion_faces){count, box.first, box.x, box.face, box.closed, box.albedo, box.radiosity, box.staircase};
    return box;
}

static inline void free_box(closed_box* box) {
    free(box->first);
    free(box->x);
    free(box->face);
    free(box->closed);
    free(box->albedo);
    free(box->radiosity);
    free(box->staircase);
}

#endif
