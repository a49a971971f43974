#include "solve/ordinates/diffusive_cells.h"

#include "base/arena.h"
#include "base/context.h"

#include <math.h>
#include <string.h>

/* Free paths, and those after which light has forgotten its direction, across a thick cell at least. */
static const double THICK = TY_DIFFUSIVE_FREE_PATHS, THICK_REDUCED = 1.5;
/* Of P1's D, what a black cell's is less, so that it sends a quarter of its fluence. */
static const double BLACK = 0.1339745962155614; /* 1 - sqrt(3) / 2 */
/* The logarithm of what a source grows by from cell to cell is at most this often a cell's free paths. */
static const double STEEPEST = 2;

typedef struct finder {
    const ty_ordinates_def* def;
    const float *extinction, *absorption;
    float* reduced;
    ty_diffusive_cells* thick;
    int64_t cells, steps[3];
    double shortest, longest, mean; /* edges, m */
} finder;

static finder finder_of(const ty_ordinates_def* def, const float* extinction, float* reduced, const float* absorption,
                        ty_diffusive_cells* thick) {
    const int32_t* size = def->size;
    const double* edge = def->cell;
    return (finder){.def = def,
                    .extinction = extinction,
                    .absorption = absorption,
                    .reduced = reduced,
                    .thick = thick,
                    .cells = (int64_t)size[0] * size[1] * size[2],
                    .steps = {1, size[0], (int64_t)size[0] * size[1]},
                    .shortest = fmin(fmin(edge[0], edge[1]), edge[2]),
                    .longest = fmax(fmax(edge[0], edge[1]), edge[2]),
                    .mean = cbrt(edge[0] * edge[1] * edge[2])};
}

static bool is_thick(const finder* f, int64_t cell) {
    return (double)f->extinction[cell] * f->longest > THICK && (double)f->reduced[cell] * f->shortest > THICK_REDUCED;
}

/* ---- cells ---- */

static void lay_out(const finder* f, ty_arena* arena) {
    ty_diffusive_cells* thick = f->thick;
    thick->cells = ty_arena_take(arena, sizeof *thick->cells * (size_t)thick->count);
    thick->slots = ty_arena_take(arena, sizeof *thick->slots * (size_t)f->cells);
    thick->first = ty_arena_take(arena, sizeof *thick->first * ((size_t)f->def->size[2] + 1));
    thick->skins = ty_arena_take(arena, sizeof *thick->skins * (size_t)thick->skin_count);
}

/* The cell behind a face; below 0: the box's outside. */
static int64_t behind(const finder* f, int64_t cell, int face) {
    const int axis = face / 2;
    const int32_t at = (int32_t)(cell / f->steps[axis] % f->def->size[axis]);
    if ((face & 1) == 0) return at > 0 ? cell - f->steps[axis] : -1;
    return at + 1 < f->def->size[axis] ? cell + f->steps[axis] : -1;
}

/* A wall's side at a cell's face; below 0: there is none. */
static int32_t side_at(const finder* f, int64_t cell, int face) {
    const ty_ordinates_faces* walls = &f->def->walls;
    if (walls->count == 0) return -1;
    const int64_t row = cell / f->def->size[0];
    for (int32_t side = walls->first[row]; side < walls->first[row + 1]; ++side)
        if (walls->x[side] == cell % f->def->size[0] && walls->face[side] == face) return side;
    return -1;
}

static int32_t link_of(const finder* f, int64_t cell, int face, int32_t skin) {
    const int32_t side = side_at(f, cell, face);
    if (side >= 0) return TY_LINK_BOUNDARY_FACE - side;
    const int64_t next = behind(f, cell, face);
    return next >= 0 && is_thick(f, next) ? TY_LINK_DIFFUSIVE : skin;
}

static void count_cells(const finder* f) {
    ty_diffusive_cells* thick = f->thick;
    for (int64_t i = 0; i < f->cells; ++i) {
        if (!is_thick(f, i)) continue;
        ++thick->count;
        for (int face = 0; face < 6; ++face) thick->skin_count += link_of(f, i, face, 0) >= 0 ? 1 : 0;
    }
}

static void fill_cells(const finder* f) {
    ty_diffusive_cells* thick = f->thick;
    int32_t count = 0, skins = 0;
    for (int64_t i = 0; i < f->cells; ++i) {
        if (i % f->steps[2] == 0) thick->first[i / f->steps[2]] = count;
        thick->slots[i] = -1;
        if (!is_thick(f, i)) continue;
        ty_diffusive_cell* cell = &thick->cells[count];
        *cell = (ty_diffusive_cell){.index = (int32_t)i};
        for (int face = 0; face < 6; ++face) {
            cell->link[face] = link_of(f, i, face, skins);
            if (cell->link[face] < 0) continue;
            thick->skins[skins++] = (ty_interface_face){.cell = count, .face = face, .outer = behind(f, i, face) < 0};
        }
        thick->slots[i] = count++;
    }
    thick->first[f->def->size[2]] = count;
}

/* ---- where sources are within cells ---- */

/* Of a source at x between planes u on both sides of 0, all in diffusion lengths and u above 0, what leaves through the
 * upper one, if nothing stays there. */
static double share_up(double x, double u) {
    return exp(x - u) * expm1(-2 * (u + x)) / expm1(-4 * u);
}

/* What the source grows by over a cell along an axis, as a logarithm: of it and its thick neighbours, those of an
 * exponential. */
static double growth_of(const finder* f, const ty_diffusive_cell* cell, int axis) {
    const float* source = f->def->source[0];
    double low = (double)source[cell->index], high = low;
    int ways = 0;
    if (cell->link[2 * axis] == TY_LINK_DIFFUSIVE) low = (double)source[cell->index - f->steps[axis]], ++ways;
    if (cell->link[2 * axis + 1] == TY_LINK_DIFFUSIVE) high = (double)source[cell->index + f->steps[axis]], ++ways;
    const double steepest = STEEPEST * (double)f->extinction[cell->index] * f->def->cell[axis];
    if (ways == 0 || (low <= 0 && high <= 0)) return 0;
    if (low <= 0 || high <= 0) return low <= 0 ? steepest : -steepest;
    return fmax(fmin(log(high / low) / ways, steepest), -steepest);
}

/* The middle of an exponential between -1 and 1 that grows so. */
static double middle_of(double growth) {
    const double half = growth / 2;
    return fabs(half) < 1e-2 ? half / 3 : 1 / tanh(half) - 1 / half;
}

/* Along an axis: the source's middle, -1..1, with the free path that what is sent straight on goes. */
static double place_of(const finder* f, const ty_diffusive_cell* cell, int axis, double reduced) {
    static const int terms[3] = {3, 1, 2};
    const double even = (double)f->def->source[0][cell->index], half = f->def->cell[axis] / 2;
    double place = middle_of(growth_of(f, cell, axis));
    if (f->def->source_terms > 1)
        place += (double)f->def->source[terms[axis]][cell->index] / (sqrt(3) * even * reduced * half);
    return fmax(fmin(place, 1), -1);
}

/* A source in the middle fills the cell and leaves as what is there does, and one at a face leaves; in between, as the
 * share of the light that is there by it alone. */
static void push(const finder* f, ty_diffusive_cell* cell, double reduced) {
    const double source = (double)f->def->source[0][cell->index], absorption = (double)f->absorption[cell->index];
    if (!(source > 0)) return;
    double shares[6], sum = 0;
    for (int axis = 0; axis < 3; ++axis) {
        const double u = fmax(f->def->cell[axis] / 2 * sqrt(3 * reduced * absorption), 1e-3);
        const double place = place_of(f, cell, axis, reduced), even = 1 - place * place, middle = share_up(0, u);
        for (int up = 0; up < 2; ++up) {
            shares[2 * axis + up] = share_up(up != 0 ? place * u : -place * u, u) - even * middle;
            sum += shares[2 * axis + up];
        }
    }
    for (int face = 0; face < 6; ++face)
        cell->push[face] = (float)(source * f->def->cell[face / 2] * shares[face] / fmax(sum, 1));
}

/* ---- coefficients ---- */

static void set_diffusivity(const finder* f, ty_diffusive_cell* cell) {
    const double reduced = (double)f->reduced[cell->index], absorption = (double)f->absorption[cell->index];
    const double u = fmax(f->mean / 2 * sqrt(3 * reduced * absorption), 1e-3);
    const double long_d = (1 - BLACK * absorption / reduced) / (3 * reduced);
    cell->d = (float)(long_d * u / tanh(u));
    cell->edge_d = (float)(long_d * u / (1 + expm1(-2 * u) / (2 * u)));
    cell->lean = (float)(1 - sqrt(fmin(absorption / reduced, 1)));
    push(f, cell, reduced);
    f->reduced[cell->index] = 1 / (3 * cell->d);
}

/* ---- sides for sweeps ---- */

static void lay_out_sides(const finder* f, ty_arena* arena, int32_t** first, int32_t** x, uint8_t** face) {
    ty_diffusive_cells* thick = f->thick;
    const size_t count = (size_t)thick->sides.count, rows = (size_t)f->def->size[1] * (size_t)f->def->size[2];
    thick->sides.first = *first = ty_arena_take(arena, sizeof **first * (rows + 1));
    thick->sides.x = *x = ty_arena_take(arena, sizeof **x * count);
    thick->sides.face = *face = ty_arena_take(arena, sizeof **face * count);
    thick->sides.emitted = thick->sent = ty_arena_take(arena, sizeof(float) * count);
    thick->sides.emitted_slope = thick->tilt = ty_arena_take(arena, sizeof(float) * count);
    thick->sides.incident_power = ty_arena_take(arena, sizeof(float) * count);
    thick->source = ty_arena_take(arena, sizeof *thick->source * count);
}

/* What a face of a cell is to sweeps. Returns whether it is a side at all. */
static bool side_of(const finder* f, int64_t cell, int face, int32_t* source) {
    const ty_diffusive_cells* thick = f->thick;
    const int32_t side = side_at(f, cell, face), slot = thick->slots[cell];
    const int64_t next = behind(f, cell, face);
    *source = TY_LINK_DIFFUSIVE;
    if (slot >= 0) return side >= 0 || thick->cells[slot].link[face] >= 0;
    *source = side;
    if (side >= 0) return true;
    if (next < 0 || thick->slots[next] < 0) return false;
    *source = TY_LINK_BOUNDARY_FACE - thick->cells[thick->slots[next]].link[face ^ 1];
    return true;
}

/* Counts the sides of all cells, and, where there are arrays, fills these. */
static int32_t go_round(const finder* f, int32_t* first, int32_t* x, uint8_t* faces) {
    int32_t count = 0, source;
    for (int64_t i = 0; i < f->cells; ++i) {
        if (first != NULL && i % f->def->size[0] == 0) first[i / f->def->size[0]] = count;
        for (int face = 0; face < 6; ++face) {
            if (!side_of(f, i, face, &source)) continue;
            if (first != NULL) {
                x[count] = (int32_t)(i % f->def->size[0]);
                faces[count] = (uint8_t)face;
                f->thick->source[count] = source;
            }
            ++count;
        }
    }
    if (first != NULL) first[f->cells / f->def->size[0]] = count;
    return count;
}

static ty_result make_sides(const finder* f) {
    ty_diffusive_cells* thick = f->thick;
    int32_t *first, *x;
    uint8_t* face;
    thick->sides.count = go_round(f, NULL, NULL, NULL);
    ty_arena arena = {0};
    lay_out_sides(f, &arena, &first, &x, &face);
    thick->side_bytes = arena.used;
    thick->side_memory = ty_alloc_array(thick->context, thick->side_bytes, 1, true);
    if (thick->side_memory == NULL) return TY_ERROR_MEMORY;
    arena = (ty_arena){.base = thick->side_memory};
    lay_out_sides(f, &arena, &first, &x, &face);
    go_round(f, first, x, face);
    return TY_OK;
}

ty_result ty_diffusive_cells_find(ty_context* context, const ty_ordinates_def* def, const float* extinction,
                                  float* reduced, const float* absorption, ty_diffusive_cells* out) {
    *out = (ty_diffusive_cells){.context = context};
    const finder f = finder_of(def, extinction, reduced, absorption, out);
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

void ty_diffusive_cells_free(ty_diffusive_cells* thick) {
    if (thick->memory != NULL) ty_free_array(thick->context, thick->memory, thick->bytes, 1);
    if (thick->side_memory != NULL) ty_free_array(thick->context, thick->side_memory, thick->side_bytes, 1);
}
