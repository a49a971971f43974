/* Modes published and collided: propagation between neighbouring cells of an ordinate's grid (Elek 2014). */
#include "method/pop/published/propagate.h"

#include "base/context.h"
#include "base/float_mode.h"
#include "method/pop/published/propagate_kernel.h"
#include "method/pop/grid/slab.h"

#include <math.h>

enum { TY_POP_ITERATIONS_MAX = 10000 };

/* ---- sizes ---- */

/* Slices have one ghost cell without medium on each side, and padding at the end, so that each starts on a vector
 * boundary. */
enum { LANES = 16 };

static size_t slice_floats(const ty_pop_grid* grid) {
    const size_t cells = ((size_t)grid->size[0] + 2) * ((size_t)grid->size[1] + 2);
    return (cells + LANES - 1) / LANES * LANES;
}

size_t ty_pop_scratch_floats(const ty_pop_grid* grid, const ty_pop_def* def, int32_t planes) {
    if (def->mode == TY_POP_MODE_SPLIT) return 0;
    const size_t slice = slice_floats(grid), slices = (size_t)grid->size[2];
    return slice * (slices * (TY_POP_PROPAGATION_PLANE_ARRAYS * (size_t)planes + TY_POP_PROPAGATION_ARRAYS) +
                    TY_POP_PROPAGATION_SLICES);
}

/* ---- arrays ---- */

/* Arrays over all cells, slices with ghosts. */
typedef struct plane_arrays {
    float* light;                            /* fluence not yet propagated, per unit color */
    float *pass[2], *anisotropy_retained[2]; /* as in ty_pop_half_cells */
    float* uncollided;
    float* next_g; /* factor on the mean cosine of light scattered towards the eye; 1: no further scattering. Eq. 8
                      (Elek 2014) */
} plane_arrays;

typedef struct propagation {
    const ty_pop_grid_kernels* grid_kernels;
    const ty_pop_propagation_kernels* kernels;
    const ty_grid_medium* medium;
    ty_pop_light* light;
    ty_pop_mode mode;
    int32_t iterations, row;
    size_t slice, all; /* floats of a slice and of an array */
    plane_arrays planes[3];
    float *cosine, *fluence, *accumulated_radiance, *two_one_minus_mu;
    float* outgoing; /* slices of outgoing light (outgoing_of), and one of zeros */
    ty_pop_columns columns;
    ty_pop_slab slab;
    ty_pop_transmittance through;
    ty_pop_eye_view view;
    float mean[3][TY_POP_BLOCK]; /* slab means, per plane */
} propagation;

/* Distance to the neighbour beside, relative to the distance to the one in front. */
static float aspect_ratio(const ty_pop_grid* grid, int32_t k) {
    if (grid->kind == TY_DISCRETE_DIRECTIONAL) return 0.5f * (grid->step.x + grid->step.y) / grid->step.z;
    return ty_pop_radius(grid, (float)k + 0.5f) * sqrtf(4 * TY_PI) /
           ((float)grid->size[0] * ty_pop_cell_length(grid, k));
}

/* True if cells are cubes to 1 %, so that factors along and across are equal. */
static bool has_cubic_cells(const ty_pop_grid* grid) {
    return fabsf(aspect_ratio(grid, grid->size[2] / 2) - 1) < 0.01f;
}

static float* allocate_floats(float** next, size_t count) {
    float* floats = *next;
    *next += count;
    return floats;
}

static void allocate_arrays(propagation* w, float* scratch) {
    memset(scratch, 0,
           sizeof *scratch *
               (w->all * (TY_POP_PROPAGATION_PLANE_ARRAYS * (size_t)w->medium->planes + TY_POP_PROPAGATION_ARRAYS) +
                w->slice * TY_POP_PROPAGATION_SLICES));
    for (int32_t p = 0; p < w->medium->planes; ++p) {
        plane_arrays* plane = &w->planes[p];
        float** const arrays[TY_POP_PROPAGATION_PLANE_ARRAYS] = {&plane->light,
                                                                 &plane->pass[0],
                                                                 &plane->pass[1],
                                                                 &plane->anisotropy_retained[0],
                                                                 &plane->anisotropy_retained[1],
                                                                 &plane->uncollided,
                                                                 &plane->next_g};
        for (int a = 0; a < TY_POP_PROPAGATION_PLANE_ARRAYS; ++a) *arrays[a] = allocate_floats(&scratch, w->all);
        if (!has_cubic_cells(&w->light->grid)) continue;
        plane->pass[1] = plane->pass[0];
        plane->anisotropy_retained[1] = plane->anisotropy_retained[0];
    }
    float** const shared[TY_POP_PROPAGATION_ARRAYS] = {&w->cosine, &w->fluence, &w->accumulated_radiance,
                                                       &w->two_one_minus_mu};
    for (int a = 0; a < TY_POP_PROPAGATION_ARRAYS; ++a) *shared[a] = allocate_floats(&scratch, w->all);
    w->outgoing = scratch;
}

/* Outgoing light of slice k. It is kept while neighbours need it: three slices for the front, two for the sides and
 * one for the back, a working set that leaves the caches to the other arrays. */
static ty_pop_outgoing outgoing_of(const propagation* w, int32_t k) {
    enum { FRONTS = 3, SIDES = 2 };
    float *front = w->outgoing + 2 * w->slice * (size_t)(k % FRONTS), *sides = w->outgoing + 2 * FRONTS * w->slice;
    float *side = sides + 2 * w->slice * (size_t)(k % SIDES), *back = sides + 2 * SIDES * w->slice;
    return (ty_pop_outgoing){front, side, back, front + w->slice, side + w->slice, back + w->slice};
}

/* Zero light from beyond the ends of the grid. */
static ty_pop_outgoing no_incoming(const propagation* w) {
    float* nothing = w->outgoing + (TY_POP_PROPAGATION_SLICES - 1) * w->slice;
    return (ty_pop_outgoing){nothing, nothing, nothing, nothing, nothing, nothing};
}

/* Index of the first cell in a row. */
static size_t row_index(const propagation* w, int32_t j, int32_t k) {
    return w->slice * (size_t)k + (size_t)(w->row * (j + 1) + 1);
}

/* ---- initial light ---- */

/* Copies the block's columns to slice k. */
static void store(const propagation* w, const float* from, int32_t k, float* to) {
    const int32_t n = w->light->grid.size[0];
    for (int32_t i = 0; i < w->columns.count; i += n)
        memcpy(to + row_index(w, (w->columns.first + i) / n, k), from + i, (size_t)n * sizeof *to);
}

static void start_plane(propagation* w, int32_t p, int32_t k) {
    const ty_pop_grid* grid = &w->light->grid;
    const plane_arrays* plane = &w->planes[p];
    ty_pop_initial_slab start;
    start.collided = w->mode == TY_POP_MODE_COLLIDED;
    start.plane = p;
    start.mean = w->mean[p];
    start.across = aspect_ratio(grid, k);
    w->kernels->initial_slab(&w->slab, &start);
    store(w, start.light, k, plane->light);
    store(w, start.next_g, k, plane->next_g);
    store(w, start.mean, k, plane->uncollided);
    for (int side = 0; side < (plane->pass[0] == plane->pass[1] ? 1 : 2); ++side) {
        store(w, start.pass[side], k, plane->pass[side]);
        store(w, start.anisotropy_retained[side], k, plane->anisotropy_retained[side]);
    }
}

static void start_columns(propagation* w) {
    float two_one_minus_mu[TY_POP_BLOCK]; /* towards the eye */
    const ty_pop_grid* grid = &w->light->grid;
    ty_pop_transmittance_begin(w->grid_kernels, 1, &w->slab, &w->through);
    for (int32_t p = 0; p < w->medium->planes; ++p) w->through.mean[p][0] = w->mean[p];
    for (int32_t k = 0; k < grid->size[2]; ++k) {
        ty_pop_slab_enter(w->grid_kernels, k, &w->slab);
        w->grid_kernels->incident_light(&w->slab);
        w->grid_kernels->attenuate(&w->slab, &w->through);
        w->grid_kernels->eye_cosines(&w->slab, &w->view);
        for (int32_t i = 0; i < w->columns.count; ++i) two_one_minus_mu[i] = 2 * (1 - w->view.mu[i]);
        store(w, two_one_minus_mu, k, w->two_one_minus_mu);
        for (int32_t p = 0; p < w->medium->planes; ++p) start_plane(w, p, k);
    }
}

/* ---- iterations ---- */

/* Ghost cells beyond the octahedral map's edges send the light of the cells across the edge. */
static void wrap_octahedral(const propagation* w, float* side) {
    const int32_t n = w->light->grid.size[0], row = w->row;
    for (int32_t i = 0; i < n; ++i) {
        side[i + 1] = side[n - i + row];
        side[i + 1 + row * (n + 1)] = side[n - i + row * n];
        side[row * (i + 1)] = side[1 + row * (n - i)];
        side[n + 1 + row * (i + 1)] = side[n + row * (n - i)];
    }
}

static ty_pop_half_cells half_cells(const plane_arrays* plane, size_t at) {
    return (ty_pop_half_cells){{plane->pass[0] + at, plane->pass[1] + at},
                               {plane->anisotropy_retained[0] + at, plane->anisotropy_retained[1] + at}};
}

static void scatter_slice(const propagation* w, const plane_arrays* plane, int32_t k) {
    const ty_pop_outgoing out = outgoing_of(w, k);
    const size_t at = w->slice * (size_t)k;
    const ty_pop_scatter_slice slice = {(int32_t)w->slice, half_cells(plane, at), plane->light + at, w->cosine + at,
                                        out};
    w->kernels->scatter_to_neighbours(&slice);
    if (w->light->grid.kind == TY_DISCRETE_DIRECTIONAL) return;
    wrap_octahedral(w, out.side);
    wrap_octahedral(w, out.side_moment);
}

/* The range covers whole vectors, and all rows but the first and last. Reads beyond a slice's sides fall in adjacent
 * arrays, with weight 0. */
static void gather_slice(const propagation* w, const plane_arrays* plane, int32_t k) {
    const size_t at = w->slice * (size_t)k;
    const int32_t end = w->row * (w->light->grid.size[1] + 1), last = w->light->grid.size[2] - 1;
    const ty_pop_gather_slice slice = {.row = w->row,
                                       .begin = w->row / LANES * LANES,
                                       .end = (end + LANES - 1) / LANES * LANES,
                                       .half = half_cells(plane, at),
                                       .before = k > 0 ? outgoing_of(w, k - 1) : no_incoming(w),
                                       .beside = outgoing_of(w, k),
                                       .after = k < last ? outgoing_of(w, k + 1) : no_incoming(w),
                                       .two_one_minus_mu = w->two_one_minus_mu + at,
                                       .next_g = plane->next_g + at,
                                       .light = plane->light + at,
                                       .cosine = w->cosine + at,
                                       .fluence = w->fluence + at,
                                       .accumulated_radiance = w->accumulated_radiance + at};
    w->kernels->gather_from_neighbours(&slice);
}

/* A slice gathers once its neighbours have scattered theirs. */
static void iterate(const propagation* w, const plane_arrays* plane) {
    scatter_slice(w, plane, 0);
    for (int32_t k = 0; k < w->light->grid.size[2]; ++k) {
        if (k + 1 < w->light->grid.size[2]) scatter_slice(w, plane, k + 1);
        gather_slice(w, plane, k);
    }
}

/* ---- results ---- */

static float* lobe_array(const propagation* w, int32_t p, int32_t number) {
    const size_t arrays = 1 + 2 * (size_t)w->light->bands;
    return w->light->lobes + ((size_t)p * arrays + (size_t)number) * ty_pop_cells(&w->light->grid);
}

static void copy_array(const propagation* w, const float* from, float* to) {
    const int32_t* size = w->light->grid.size;
    for (int32_t row = 0; row < size[1] * size[2]; ++row, to += size[0])
        memcpy(to, from + row_index(w, row % size[1], row / size[1]), (size_t)size[0] * sizeof *to);
}

static void accumulate_band(const propagation* w, int32_t p, int32_t band) {
    if (w->light->lobes == NULL) return;
    const int32_t* size = w->light->grid.size;
    float *passed = lobe_array(w, p, 1 + 2 * band), *sigma_s_g = lobe_array(w, p, 2 + 2 * band);
    for (int32_t row = 0; row < size[1] * size[2]; ++row, passed += size[0], sigma_s_g += size[0]) {
        const size_t at = row_index(w, row % size[1], row / size[1]);
        const float *light = w->planes[p].light + at, *cosine = w->cosine + at;
        for (int32_t i = 0; i < size[0]; ++i) {
            passed[i] += light[i];
            sigma_s_g[i] += light[i] * cosine[i];
        }
    }
}

/* Initial accumulation of a plane. In mode published L_acc starts at 0: the initial light of the cells is
 * uncollided. In mode collided it has scattered once, and counts, as does the uncollided light. */
static void begin_plane(const propagation* w, int32_t p) {
    const plane_arrays* plane = &w->planes[p];
    const bool collided = w->mode == TY_POP_MODE_COLLIDED;
    const ty_pop_initial_cells begin = {.count = (int32_t)w->all,
                                        .collided = collided,
                                        .cosine = w->light->ordinate.mean_cosine,
                                        .uncollided = plane->uncollided,
                                        .light = plane->light,
                                        .next_g = plane->next_g,
                                        .two_one_minus_mu = w->two_one_minus_mu,
                                        .cosines = w->cosine,
                                        .fluence = w->fluence,
                                        .accumulated_radiance = w->accumulated_radiance};
    w->kernels->initial_cells(&begin);
    if (w->light->lobes != NULL) copy_array(w, plane->uncollided, lobe_array(w, p, 0));
    if (collided) accumulate_band(w, p, 0);
}

/* One row of channel c in `accumulated`. */
static void write_row(const propagation* w, int32_t c, size_t at, float* accumulated_radiance) {
    const ty_pop_light* light = w->light;
    const float* restrict left = w->planes[light->planes == 3 ? c : 0].light + at;
    const float* restrict radiance = w->accumulated_radiance + at, * restrict fluence = w->fluence + at;
    const float color = light->ordinate.color[c];
    float* restrict cell = accumulated_radiance + c;
    for (int32_t i = 0; i < light->grid.size[0]; ++i, cell += TY_POP_CELL_FLOATS_PROPAGATED) {
        cell[0] = color * radiance[i];
        cell[3] = color * fluence[i];
        cell[8] = color * left[i];
    }
}

static void end_plane(const propagation* w, int32_t p) {
    const ty_pop_grid* grid = &w->light->grid;
    const int32_t ghosts = ty_pop_ghost_width(grid), row = grid->size[0] + 2 * ghosts,
                  end = w->light->planes == 3 ? p + 1 : 3;
    for (int32_t k = 0; k < grid->size[2]; ++k) {
        float* slab = ty_pop_accumulated_slab(w->light, k);
        for (int32_t j = 0; j < grid->size[1]; ++j)
            for (int32_t c = p; c < end; ++c)
                write_row(w, c, row_index(w, j, k),
                          slab + (size_t)w->light->floats * (size_t)(ghosts + row * (j + ghosts)));
    }
}

/* Unpropagated fluence times volume of plane p, over cells and the plane's channels. */
static double total_light(const propagation* w, int32_t p) {
    const ty_pop_grid* grid = &w->light->grid;
    const float* color = w->light->ordinate.color;
    const double colors = w->light->planes == 3 ? (double)color[p] : (double)(color[0] + color[1] + color[2]);
    const double section = grid->kind == TY_DISCRETE_POINT ? 4 * (double)TY_PI / ((double)grid->size[0] * grid->size[1])
                                                           : (double)grid->step.x * (double)grid->step.y;
    double sum = 0;
    for (int32_t k = 0; k < grid->size[2]; ++k) {
        const float* slice = w->planes[p].light + w->slice * (size_t)k;
        sum += (double)w->kernels->sum(slice, (int32_t)w->slice) * (double)ty_pop_cell_length(grid, k);
    }
    return sum * section * colors;
}

static void propagate_plane(propagation* w, int32_t p, ty_pop_propagation_stats* stats) {
    stats->initial += total_light(w, p);
    begin_plane(w, p);
    for (int32_t m = 1; m <= w->iterations; ++m) {
        iterate(w, &w->planes[p]);
        accumulate_band(w, p, ty_pop_band_index(m));
    }
    stats->unpropagated += total_light(w, p);
    end_plane(w, p);
}

static void begin_propagation(const ty_scene* scene, const float eye[3], float* scratch, propagation* w) {
    const ty_pop_grid* grid = &w->light->grid;
    w->row = grid->size[0] + 2;
    w->slice = slice_floats(grid);
    w->all = w->slice * (size_t)grid->size[2];
    allocate_arrays(w, scratch);
    ty_pop_slab_setup(w->grid_kernels, w->medium, &w->columns, &w->slab);
    ty_pop_eye_view_setup(w->medium, eye, w->light, &w->view);
    for (int32_t first = 0; first < grid->size[0] * grid->size[1]; first += w->columns.count) {
        ty_pop_columns_begin(scene, w->medium, w->light, first, &w->columns);
        start_columns(w);
    }
}

/* Propagates L_i and a_i from cell to cell: Sec. 4.1 (Elek 2014). */
void ty_pop_propagate(const ty_scene* scene, const ty_pop_def* def, const ty_grid_medium* medium, const float eye[3],
                      int32_t iterations, float* scratch, ty_pop_light* light, ty_pop_propagation_stats* stats) {
    const double begun = ty_wall_seconds();
    const unsigned state = ty_flush_denormals();
    propagation w;
    w.grid_kernels = TY_BEST_KERNELS(ty_pop_grid_kernels);
    w.kernels = TY_BEST_KERNELS(ty_pop_propagation_kernels);
    w.medium = medium;
    w.light = light;
    w.mode = def->mode;
    w.iterations = iterations;
    *stats = (ty_pop_propagation_stats){0};
    light->mode = def->mode;
    light->planes = medium->planes;
    light->bands = ty_pop_band_index(iterations) + 1;
    memset(light->accumulated, 0, ty_pop_accumulated_floats(&light->grid, light->floats) * sizeof *light->accumulated);
    if (light->lobes != NULL)
        memset(light->lobes, 0,
               ty_pop_lobe_floats(&light->grid, def, light->planes, iterations) * sizeof *light->lobes);
    begin_propagation(scene, eye, scratch, &w);
    stats->initial_seconds = ty_wall_seconds() - begun;
    for (int32_t p = 0; p < medium->planes; ++p) propagate_plane(&w, p, stats);
    ty_pop_fill_ghost_cells(light);
    stats->propagation_seconds = ty_wall_seconds() - begun - stats->initial_seconds;
    ty_restore_denormals(state);
}

/* ---- number of iterations ---- */

/* m' of Eq. 9 and 10 (Elek 2014), the maximum over the medium's planes. */
int32_t ty_pop_iteration_count(const ty_pop_def* def, const ty_grid_medium* medium, float cosine, float step) {
    double max_iterations = def->resolution;
    for (int32_t p = 0; p < medium->planes && def->residuum > 0; ++p) {
        double scattering = 0, sigma_s_g = 0;
        size_t cells = 0;
        for (size_t i = 0; i < medium->cells; ++i) {
            const double sigma = (double)medium->scattering[p][i];
            scattering += sigma;
            sigma_s_g += sigma * (double)medium->g[p][i];
            cells += sigma > 0 ? 1 : 0;
        }
        if (!(sigma_s_g > 0)) continue;
        const double g = sigma_s_g / scattering, per_metre = scattering / (double)cells;
        const double loss = def->mode == TY_POP_MODE_PUBLISHED ? -log(g) : 1 - g;
        /* Eq. 10 (Elek 2014): m = (ln eps_a - ln a_max) / (ln g sigma_s dx) */
        const double iterations = (log((double)cosine) - log(def->residuum)) / (loss * per_metre * (double)step);
        if (iterations > max_iterations) max_iterations = iterations;
    }
    return (int32_t)fmin(ceil(max_iterations), TY_POP_ITERATIONS_MAX);
}
