#include "solve/ordinates/diffusive_cells.h"

#include "base/arena.h"
#include "base/context.h"

#include <math.h>
#include <string.h>

/* Minimum of a diffusive cell's shortest edge in transport mean free paths. */
static const double MIN_REDUCED_THICKNESS = 1.5;
/* The same of cells that scatter forwards and absorb more than this part of sigma_tr: there two moments do
 * not tell how much light turns round before it is absorbed. */
static const double MAX_FORWARD_ABSORPTION = 0.5, MIN_ABSORBING_THICKNESS = 2.2;
/* Reduction of P1's D for a black cell, which then emits a quarter of its fluence. */
static const double BLACK_REDUCTION = 0.1339745962155614; /* 1 - sqrt(3) / 2 */
/* Maximum of the logarithmic growth of a source from cell to cell, per optical thickness of a cell. */
static const double MAX_GROWTH = 2;

typedef struct search {
    const ty_ordinates_def* def;
    const float *extinction, *absorption;
    float* reduced;
    ty_diffusive_cells* diffusive;
    int64_t cells, steps[3];
    double shortest, longest, mean; /* edges, m */
} search;

static search begin_search(const ty_ordinates_def* def, const float* extinction, float* reduced,
                           const float* absorption, ty_diffusive_cells* diffusive) {
    const int32_t* size = def->size;
    const double* edge = def->cell;
    return (search){.def = def,
                    .extinction = extinction,
                    .absorption = absorption,
                    .reduced = reduced,
                    .diffusive = diffusive,
                    .cells = (int64_t)size[0] * size[1] * size[2],
                    .steps = {1, size[0], (int64_t)size[0] * size[1]},
                    .shortest = fmin(fmin(edge[0], edge[1]), edge[2]),
                    .longest = fmax(fmax(edge[0], edge[1]), edge[2]),
                    .mean = cbrt(edge[0] * edge[1] * edge[2])};
}

static bool is_diffusive(const search* f, int64_t cell) {
    const double reduced = (double)f->reduced[cell], extinction = (double)f->extinction[cell];
    const bool absorbs = reduced < extinction && (double)f->absorption[cell] > MAX_FORWARD_ABSORPTION * reduced;
    return extinction * f->longest > f->def->diffusive_paths &&
           reduced * f->shortest > (absorbs ? MIN_ABSORBING_THICKNESS : MIN_REDUCED_THICKNESS);
}

/* ---- cells ---- */

static void lay_out(const search* f, ty_arena* arena) {
    ty_diffusive_cells* diffusive = f->diffusive;
    diffusive->cells = ty_arena_take(arena, sizeof *diffusive->cells * (size_t)diffusive->count);
    diffusive->slots = ty_arena_take(arena, sizeof *diffusive->slots * (size_t)f->cells);
    diffusive->first = ty_arena_take(arena, sizeof *diffusive->first * ((size_t)f->def->size[2] + 1));
    diffusive->interfaces = ty_arena_take(arena, sizeof *diffusive->interfaces * (size_t)diffusive->interface_count);
}

/* Cell behind a face; negative: outside the box. */
static int64_t neighbour(const search* f, int64_t cell, int face) {
    const int axis = face / 2;
    const int32_t at = (int32_t)(cell / f->steps[axis] % f->def->size[axis]);
    if ((face & 1) == 0) return at > 0 ? cell - f->steps[axis] : -1;
    return at + 1 < f->def->size[axis] ? cell + f->steps[axis] : -1;
}

/* Boundary face at a cell's face; negative: none. */
static int32_t side_at(const search* f, int64_t cell, int face) {
    const ty_ordinates_faces* walls = &f->def->walls;
    if (walls->count == 0) return -1;
    const int64_t row = cell / f->def->size[0];
    for (int32_t side = walls->first[row]; side < walls->first[row + 1]; ++side)
        if (walls->x[side] == cell % f->def->size[0] && walls->face[side] == face) return side;
    return -1;
}

static int32_t link_of(const search* f, int64_t cell, int face, int32_t interface_index) {
    const int32_t side = side_at(f, cell, face);
    if (side >= 0) return TY_LINK_BOUNDARY_FACE - side;
    const int64_t next = neighbour(f, cell, face);
    return next >= 0 && is_diffusive(f, next) ? TY_LINK_DIFFUSIVE : interface_index;
}

static void count_cells(const search* f) {
    ty_diffusive_cells* diffusive = f->diffusive;
    for (int64_t i = 0; i < f->cells; ++i) {
        if (!is_diffusive(f, i)) continue;
        ++diffusive->count;
        for (int face = 0; face < 6; ++face) diffusive->interface_count += link_of(f, i, face, 0) >= 0 ? 1 : 0;
    }
}

static void fill_cells(const search* f) {
    ty_diffusive_cells* diffusive = f->diffusive;
    int32_t count = 0, interfaces = 0;
    for (int64_t i = 0; i < f->cells; ++i) {
        if (i % f->steps[2] == 0) diffusive->first[i / f->steps[2]] = count;
        diffusive->slots[i] = -1;
        if (!is_diffusive(f, i)) continue;
        ty_diffusive_cell* cell = &diffusive->cells[count];
        *cell = (ty_diffusive_cell){.index = (int32_t)i};
        for (int face = 0; face < 6; ++face) {
            cell->link[face] = link_of(f, i, face, interfaces);
            if (cell->link[face] < 0) continue;
            diffusive->interfaces[interfaces++] =
                (ty_interface_face){.cell = count, .face = face, .outer = neighbour(f, i, face) < 0};
        }
        diffusive->slots[i] = count++;
    }
    diffusive->first[f->def->size[2]] = count;
}

/* ---- positions of sources within cells ---- */

/* Fraction of a source at x that leaves through the upper of two planes at -u and u, without absorption at the planes;
 * lengths in diffusion lengths, u > 0. */
static double upward_fraction(double x, double u) {
    return exp(x - u) * expm1(-2 * (u + x)) / expm1(-4 * u);
}

/* Logarithm of the growth of the source over a cell along an axis, from an exponential through it and its diffusive
 * neighbours. */
static double growth_of(const search* f, const ty_diffusive_cell* cell, int axis) {
    const float* source = f->def->source[0];
    double lower = (double)source[cell->index], upper = lower;
    int neighbours = 0;
    if (cell->link[2 * axis] == TY_LINK_DIFFUSIVE) lower = (double)source[cell->index - f->steps[axis]], ++neighbours;
    if (cell->link[2 * axis + 1] == TY_LINK_DIFFUSIVE)
        upper = (double)source[cell->index + f->steps[axis]], ++neighbours;
    const double max_growth = MAX_GROWTH * (double)f->extinction[cell->index] * f->def->cell[axis];
    if (neighbours == 0 || (lower <= 0 && upper <= 0)) return 0;
    if (lower <= 0 || upper <= 0) return lower <= 0 ? max_growth : -max_growth;
    return fmax(fmin(log(upper / lower) / neighbours, max_growth), -max_growth);
}

/* Center of mass of an exponential on [-1, 1] with this growth. */
static double exponential_center(double growth) {
    const double half = growth / 2;
    return fabs(half) < 1e-2 ? half / 3 : 1 / tanh(half) - 1 / half;
}

/* Center of the source along an axis, -1..1: as far as it is known, and of the rest by its growth. */
static double isotropic_center(const search* f, const ty_diffusive_cell* cell, int axis) {
    const float* const* known = f->def->source_center;
    const double by_growth = exponential_center(growth_of(f, cell, axis));
    if (known == NULL) return by_growth;
    const double part = (double)known[0][cell->index], all = fmax(part, (double)f->def->source[0][cell->index]);
    return ((double)known[1 + axis][cell->index] + (all - part) * by_growth) / all;
}

/* Center of the source along an axis, -1..1, displaced by the transport mean free path in the direction of its first
 * moment. */
static double source_center(const search* f, const ty_diffusive_cell* cell, int axis, double reduced) {
    static const int terms[3] = {3, 1, 2};
    const double emission = (double)f->def->source[0][cell->index], half = f->def->cell[axis] / 2;
    double center = isotropic_center(f, cell, axis);
    if (f->def->source_terms > 1)
        center += (double)f->def->source[terms[axis]][cell->index] / (sqrt(3) * emission * reduced * half);
    return fmax(fmin(center, 1), -1);
}

/* A source at the cell's center fills the cell and leaves with its diffuse light; a source at a face leaves directly.
 * Between the two, the directly leaving fraction is the excess over the centered source. */
static void set_interface_source(const search* f, ty_diffusive_cell* cell, double reduced) {
    const double source = (double)f->def->source[0][cell->index], absorption = (double)f->absorption[cell->index];
    if (!(source > 0)) return;
    double fractions[6], sum = 0;
    for (int axis = 0; axis < 3; ++axis) {
        const double u = fmax(f->def->cell[axis] / 2 * sqrt(3 * reduced * absorption), 1e-3);
        const double center = source_center(f, cell, axis, reduced), centered_weight = 1 - center * center,
                     centered = upward_fraction(0, u);
        for (int up = 0; up < 2; ++up) {
            fractions[2 * axis + up] =
                upward_fraction(up != 0 ? center * u : -center * u, u) - centered_weight * centered;
            sum += fractions[2 * axis + up];
        }
    }
    for (int face = 0; face < 6; ++face)
        cell->interface_source[face] = (float)(source * f->def->cell[face / 2] * fractions[face] / fmax(sum, 1));
}

/* ---- coefficients ---- */

static void set_diffusivity(const search* f, ty_diffusive_cell* cell) {
    const double reduced = (double)f->reduced[cell->index], absorption = (double)f->absorption[cell->index];
    const double u = fmax(f->mean / 2 * sqrt(3 * reduced * absorption), 1e-3);
    const double base_d = (1 - BLACK_REDUCTION * absorption / reduced) / (3 * reduced);
    cell->d = (float)(base_d * u / tanh(u));
    cell->edge_d = (float)(base_d * u / (1 + expm1(-2 * u) / (2 * u)));
    cell->p1_weight = (float)(1 - sqrt(fmin(absorption / reduced, 1)));
    set_interface_source(f, cell, reduced);
    f->reduced[cell->index] = 1 / (3 * cell->d);
}

/* ---- sweep faces ---- */

static void lay_out_sides(const search* f, ty_arena* arena, int32_t** first, int32_t** x, uint8_t** face) {
    ty_diffusive_cells* diffusive = f->diffusive;
    const size_t count = (size_t)diffusive->sides.count, rows = (size_t)f->def->size[1] * (size_t)f->def->size[2];
    diffusive->sides.first = *first = ty_arena_take(arena, sizeof **first * (rows + 1));
    diffusive->sides.x = *x = ty_arena_take(arena, sizeof **x * count);
    diffusive->sides.face = *face = ty_arena_take(arena, sizeof **face * count);
    diffusive->sides.emitted = diffusive->radiance = ty_arena_take(arena, sizeof(float) * count);
    diffusive->sides.emitted_slope = diffusive->radiance_slope = ty_arena_take(arena, sizeof(float) * count);
    diffusive->sides.incident_power = ty_arena_take(arena, sizeof(float) * count);
    diffusive->source = ty_arena_take(arena, sizeof *diffusive->source * count);
}

/* Source index of a cell's face for the sweep. Returns whether the face is a side at all. */
static bool side_of(const search* f, int64_t cell, int face, int32_t* source) {
    const ty_diffusive_cells* diffusive = f->diffusive;
    const int32_t side = side_at(f, cell, face), slot = diffusive->slots[cell];
    const int64_t next = neighbour(f, cell, face);
    *source = TY_LINK_DIFFUSIVE;
    if (slot >= 0) return side >= 0 || diffusive->cells[slot].link[face] >= 0;
    *source = side;
    if (side >= 0) return true;
    if (next < 0 || diffusive->slots[next] < 0) return false;
    *source = TY_LINK_BOUNDARY_FACE - diffusive->cells[diffusive->slots[next]].link[face ^ 1];
    return true;
}

/* Counts the sides of all cells, and fills the arrays unless they are NULL. */
static int32_t fill_sides(const search* f, int32_t* first, int32_t* x, uint8_t* faces) {
    int32_t count = 0, source;
    for (int64_t i = 0; i < f->cells; ++i) {
        if (first != NULL && i % f->def->size[0] == 0) first[i / f->def->size[0]] = count;
        for (int face = 0; face < 6; ++face) {
            if (!side_of(f, i, face, &source)) continue;
            if (first != NULL) {
                x[count] = (int32_t)(i % f->def->size[0]);
                faces[count] = (uint8_t)face;
                f->diffusive->source[count] = source;
            }
            ++count;
        }
    }
    if (first != NULL) first[f->cells / f->def->size[0]] = count;
    return count;
}

static ty_result make_sides(const search* f) {
    ty_diffusive_cells* diffusive = f->diffusive;
    int32_t *first, *x;
    uint8_t* face;
    diffusive->sides.count = fill_sides(f, NULL, NULL, NULL);
    ty_arena arena = {0};
    lay_out_sides(f, &arena, &first, &x, &face);
    diffusive->side_bytes = arena.used;
    diffusive->side_memory = ty_alloc_array(diffusive->context, diffusive->side_bytes, 1, true);
    if (diffusive->side_memory == NULL) return TY_ERROR_MEMORY;
    arena = (ty_arena){.base = diffusive->side_memory};
    lay_out_sides(f, &arena, &first, &x, &face);
    fill_sides(f, first, x, face);
    return TY_OK;
}

ty_result ty_diffusive_cells_find(ty_context* context, const ty_ordinates_def* def, const float* extinction,
                                  float* reduced, const float* absorption, ty_diffusive_cells* out) {
    *out = (ty_diffusive_cells){.context = context};
    const search f = begin_search(def, extinction, reduced, absorption, out);
    count_cells(&f);
    if (out->count == 0) return TY_OK;
    ty_arena arena = {0};
    lay_out(&f, &arena);
    out->bytes = arena.used;
    out->memory = ty_alloc_array(context, out->bytes, 1, false);
    if (out->memory == NULL) return TY_ERROR_MEMORY;
    arena = (ty_arena){.base = out->memory};
    lay_out(&f, &arena);
    fill_cells(&f);
    for (int32_t i = 0; i < out->count; ++i) set_diffusivity(&f, &out->cells[i]);
    return make_sides(&f);
}

void ty_diffusive_cells_free(ty_diffusive_cells* diffusive) {
    if (diffusive->memory != NULL) ty_free_array(diffusive->context, diffusive->memory, diffusive->bytes, 1);
    if (diffusive->side_memory != NULL)
        ty_free_array(diffusive->context, diffusive->side_memory, diffusive->side_bytes, 1);
}
