/* Memory, scattering operators, blockers and steps of a propagation. */
#include "method/lpv/propagate/propagation.h"

#include "base/context.h"
#include "base/parallel.h"

/* ---- transfer functions ---- */

/* The clamped cosine lobe about a link, for light that surfaces reflect, scaled to a first term of 1. */
static void make_lobe(const int32_t step[3], float lobe[TY_SH_TERMS]) {
    const ty_vec direction = ty_normalize(ty_vec_make((float)step[0], (float)step[1], (float)step[2]));
    float y[TY_SH_TERMS];
    ty_sh_at(direction, TY_SH_BANDS, y);
    for (int32_t t = 0; t < TY_SH_TERMS; ++t) lobe[t] = y[t] * ty_sh_cosine(ty_sh_band(t)) / (TY_SH_0 * TY_PI);
}

static ty_lpv_link_functions make_link_functions(const ty_lpv_transfer* transfer) {
    ty_lpv_link_functions link_functions = {.band0 = {0}};
    memcpy(link_functions.G, transfer->G, sizeof link_functions.G);
    for (int32_t k = 0; k < TY_LPV_LINKS; ++k) make_lobe(transfer->step[k], link_functions.lobes[k]);
    for (int32_t kind = 0; kind < 3; ++kind) {
        const int32_t k = ty_lpv_link(1, kind > 0, kind > 1);
        link_functions.band0[kind] = link_functions.G[k][0];
        link_functions.band1[kind] = link_functions.G[k][3];
    }
    return link_functions;
}

/* ---- media ---- */

static bool is_homogeneous(const ty_lattice* lattice) {
    const ty_grid_medium* medium = lattice->medium;
    if (lattice->extinction_floor != NULL) return false;
    if (medium == NULL) return true;
    for (int32_t c = 0; c < medium->planes; ++c) {
        for (size_t i = 0; i < medium->cells && lattice->border_scale[c] != NULL; ++i)
            if (lattice->border_scale[c][i] < 1.0f) return false;
        const float *t = medium->extinction[c], *s = medium->scattering[c], *g = medium->g[c];
        for (size_t i = 1; i < medium->cells; ++i)
            if (t[i] != t[0] || s[i] != s[0] || g[i] != g[0]) return false;
    }
    return true;
}

static void store_step(const ty_lpv_medium_step* step, int32_t bands, float* factors, size_t apart) {
    for (int32_t l = 0; l < bands; ++l) {
        factors[(size_t)(TY_FACTOR_SCATTER + l) * apart] = step->scatter_factor[l];
        factors[(size_t)(TY_FACTOR_INJECTED + l) * apart] = step->injected_fraction[l];
    }
    factors[TY_FACTOR_LENGTH * apart] = step->length;
    factors[TY_FACTOR_FLUX * apart] = step->flux_factor[1];
}

/* The operator of the previous cell, which usually equals that of the next one except for the extinction floor. */
typedef struct last_step {
    bool exists;
    ty_lpv_cell_medium medium;
    ty_lpv_links_step links;
    ty_lpv_medium_step step;
} last_step;

static void step_in(const ty_lpv_propagation* propagation, int32_t channel, size_t cell, last_step* last) {
    const ty_lpv_cell_medium medium = ty_lattice_medium_in(propagation->lattice, channel, cell);
    const bool links = propagation->mode == TY_LPV_MODE_LINKS;
    const bool alike = last->exists && medium.extinction == last->medium.extinction &&
                       medium.scattering == last->medium.scattering && medium.g == last->medium.g;
    if (alike && (!links || medium.extinction_floor == last->medium.extinction_floor)) return;
    if (links && !alike)
        last->links = ty_lpv_links_step_in(&propagation->transfer, propagation->lattice->cell, &medium);
    last->step = links ? ty_lpv_links_step_about(&propagation->transfer, propagation->lattice->cell, &last->links,
                                                 medium.extinction_floor)
                       : ty_lpv_step_in(&propagation->transfer, propagation->mode, propagation->lattice->cell, &medium);
    last->medium = medium;
    last->exists = true;
}

/* The factors of a plane of cells, or of a single row for homogeneous media. Rows are padded to whole blocks. */
static void find_factors(const ty_lpv_propagation* propagation, int32_t z) {
    const int32_t *size = propagation->lattice->box.size, width = propagation->blocks * TY_LPV_BLOCK;
    if (propagation->homogeneous && z > 0) return;
    for (int32_t c = 0; c < propagation->planes; ++c) {
        last_step last = {.exists = false};
        for (int32_t y = 0; y < (propagation->homogeneous ? 1 : size[1]); ++y) {
            const size_t row = (size_t)(z * size[1] + y);
            float* to = propagation->factors[c] + row * (size_t)width;
            for (int32_t x = 0; x < width; ++x) {
                if (x < size[0]) step_in(propagation, c, row * (size_t)size[0] + (size_t)x, &last);
                store_step(&last.step, propagation->lattice->bands, to + x, propagation->factor_floats);
            }
        }
    }
}

/* ---- surfaces ---- */

static void find_blocked_links(const ty_lpv_propagation* propagation, int32_t z) {
    const int32_t* size = propagation->lattice->box.size;
    for (int32_t y = 0; y < size[1]; ++y) {
        const size_t row = (size_t)z * (size_t)size[1] + (size_t)y;
        for (int32_t b = 0; b < propagation->blocks; ++b) {
            const int32_t begin = b * TY_LPV_BLOCK;
            const int32_t count = size[0] - begin < TY_LPV_BLOCK ? size[0] - begin : TY_LPV_BLOCK;
            uint32_t links = 0;
            for (int32_t k = 0; k < TY_LPV_LINKS; ++k) {
                const uint8_t* transmission = propagation->lattice->transmission[k] + row * (size_t)size[0] + begin;
                uint8_t transfer_G = 255;
                for (int32_t i = 0; i < count; ++i) transfer_G &= transmission[i];
                links |= (transfer_G != 255 ? 1u : 0u) << k;
            }
            propagation->blocked_links[row * (size_t)propagation->blocks + (size_t)b] = links;
        }
    }
}

/* ---- memory ---- */

enum { BATCHES = 4 }; /* batches of slabs per thread and step */

static ty_result take_memory(ty_lpv_propagation* propagation) {
    ty_context* context = propagation->lattice->context;
    const double bytes =
        sizeof(float) * (3.0 * (double)propagation->floats +
                         (double)(propagation->planes * TY_FACTORS) * (double)propagation->factor_floats);
    ty_result result = ty_check_memory(context, bytes, "light on its way");
    if (result != TY_OK) return result;
    propagation->buffers = ty_alloc_array(context, 3 * propagation->floats, sizeof(float), false);
    if (propagation->buffers == NULL) return TY_ERROR_MEMORY;
    propagation->from = propagation->buffers;
    propagation->to = propagation->buffers + propagation->floats;
    propagation->sum = propagation->buffers + 2 * propagation->floats;
    for (int32_t c = 0; c < propagation->planes; ++c) {
        propagation->factors[c] =
            ty_alloc_array(context, TY_FACTORS * propagation->factor_floats, sizeof(float), false);
        if (propagation->factors[c] == NULL) return TY_ERROR_MEMORY;
    }
    propagation->slabs =
        ty_alloc_array(context, (size_t)propagation->lattice->box.size[2], sizeof *propagation->slabs, true);
    if (propagation->slabs == NULL) return TY_ERROR_MEMORY;
    if (!propagation->lattice->blocked) return TY_OK;
    propagation->blocked_links =
        ty_alloc_array(context, propagation->blocked_link_count, sizeof *propagation->blocked_links, false);
    return propagation->blocked_links == NULL ? TY_ERROR_MEMORY : TY_OK;
}

/* ---- dark border ---- */

static void clear_floats(const ty_lpv_propagation* propagation, size_t first, size_t count) {
    memset(propagation->from + first, 0, count * sizeof(float));
    memset(propagation->to + first, 0, count * sizeof(float));
}

/* Clears the border cells of a plane; together with the planes before the first and after the last this is the whole
 * border of the lattice. Inner cells are set by injection and by steps. */
static void clear_around(const ty_lpv_propagation* propagation, int32_t z) {
    const int32_t* size = propagation->lattice->box.size;
    const size_t row = (size_t)propagation->pitch.row, term = (size_t)propagation->pitch.term, width = (size_t)size[0];
    const size_t terms = (size_t)(3 * propagation->lattice->terms), plane = (size_t)propagation->pitch.plane;
    if (z == -1) clear_floats(propagation, 0, plane + TY_LPV_BLOCK);
    if (z == size[2]) clear_floats(propagation, propagation->floats - plane - TY_LPV_BLOCK, plane + TY_LPV_BLOCK);
    if (z == -1 || z == size[2]) return;
    clear_floats(propagation, ty_lpv_propagation_index(propagation, -1, z), row);
    clear_floats(propagation, ty_lpv_propagation_index(propagation, size[1], z), row);
    for (int32_t y = 0; y < size[1]; ++y)
        for (size_t i = 0; i < terms; ++i) {
            const size_t end = ty_lpv_propagation_index(propagation, y, z) + i * term + width;
            clear_floats(propagation, end, term - width);
            memset(propagation->sum + end, 0, (term - width) * sizeof(float));
        }
}

static void prepare_plane(void* user, int64_t index, int32_t worker) {
    (void)worker;
    const ty_lpv_propagation* propagation = user;
    const int32_t z = (int32_t)index - 1;
    clear_around(propagation, z);
    if (z < 0 || z >= propagation->lattice->box.size[2]) return;
    find_factors(propagation, z);
    if (propagation->blocked_links != NULL) find_blocked_links(propagation, z);
}

void ty_lpv_propagation_destroy(ty_lpv_propagation* propagation) {
    ty_context* context = propagation->lattice->context;
    ty_free_array(context, propagation->buffers, 3 * propagation->floats, sizeof(float));
    for (int32_t c = 0; c < propagation->planes; ++c)
        ty_free_array(context, propagation->factors[c], TY_FACTORS * propagation->factor_floats, sizeof(float));
    ty_free_array(context, propagation->slabs, (size_t)propagation->lattice->box.size[2], sizeof *propagation->slabs);
    ty_free_array(context, propagation->blocked_links, propagation->blocked_link_count,
                  sizeof *propagation->blocked_links);
}

ty_result ty_lpv_propagation_create(ty_lattice* lattice, const ty_lpv_def* def, ty_lpv_propagation* propagation) {
    const int32_t* size = lattice->box.size;
    *propagation =
        (ty_lpv_propagation){.lattice = lattice, .mode = def->mode, .kernels = TY_BEST_KERNELS(ty_lpv_kernels)};
    ty_lpv_transfer_make(lattice->bands, def->mode == TY_LPV_MODE_LINKS, &propagation->transfer);
    propagation->link_functions = make_link_functions(&propagation->transfer);
    propagation->blocks = (size[0] + TY_LPV_BLOCK - 1) / TY_LPV_BLOCK;
    propagation->pitch.term =
        propagation->blocks * TY_LPV_BLOCK + 8; /* whole blocks, and at least one dark cell before the next term */
    propagation->pitch.row = 3 * lattice->terms * propagation->pitch.term;
    propagation->pitch.plane = (size[1] + 2) * propagation->pitch.row;
    propagation->floats = (size_t)((size[2] + 2) * propagation->pitch.plane) + 2 * (size_t)TY_LPV_BLOCK;
    propagation->batch = size[2] / (BATCHES * ty_context_threads(lattice->context)) + 1;
    propagation->homogeneous = is_homogeneous(lattice);
    propagation->planes = lattice->medium != NULL ? lattice->medium->planes : 1;
    const size_t rows = (size_t)size[1] * (size_t)size[2];
    propagation->factor_floats = (size_t)(propagation->blocks * TY_LPV_BLOCK) * (propagation->homogeneous ? 1 : rows);
    propagation->blocked_link_count = rows * (size_t)propagation->blocks;
    const ty_result result = take_memory(propagation);
    if (result != TY_OK) {
        ty_lpv_propagation_destroy(propagation);
        return result;
    }
    ty_parallel_flushed(lattice->context, size[2] + 2, prepare_plane, propagation);
    return TY_OK;
}

/* ---- steps ---- */

/* True if light against link k leaves the lattice from the first (place 0), inner (1) or last (2) cells of a row; the
 * cell of a one-cell row is the first. */
static bool leaves(const ty_lpv_propagation* propagation, int32_t place, int32_t y, int32_t z, int32_t k) {
    const int32_t *step = propagation->transfer.step[k], *size = propagation->lattice->box.size;
    const bool first = place == 0, last = place == 2 || (first && size[0] == 1);
    return (first && step[0] > 0) || (last && step[0] < 0) || y - step[1] < 0 || y - step[1] >= size[1] ||
           z - step[2] < 0 || z - step[2] >= size[2];
}

static void find_border(const ty_lpv_propagation* propagation, int32_t y, int32_t z, ty_lpv_row* row) {
    memset(row->out, 0, sizeof row->out);
    row->border = false;
    for (int32_t k = 0; k < TY_LPV_LINKS; ++k) {
        const int32_t against = k < TY_LPV_HALF_LINKS ? k + TY_LPV_HALF_LINKS : k - TY_LPV_HALF_LINKS;
        const float* transfer_G = propagation->transfer.G[against];
        for (int32_t place = 0; place < 3; ++place) {
            row->leaves[place][k] = leaves(propagation, place, y, z, k);
            if (row->leaves[place][k] == 0) continue;
            for (int32_t t = 0; t < row->terms; ++t) row->out[place][t] += transfer_G[0] * transfer_G[t];
            row->border = row->border || place == 1;
        }
    }
}

static void point_at(const ty_lpv_propagation* propagation, int32_t y, int32_t z, ty_lpv_row* row) {
    const ty_lattice* lattice = propagation->lattice;
    const size_t place = ty_lpv_propagation_index(propagation, y, z);
    const size_t index = (size_t)z * (size_t)lattice->box.size[1] + (size_t)y;
    row->from = propagation->from + place;
    row->to = propagation->to + place;
    row->sum = propagation->adds ? propagation->sum + place : NULL;
    row->first = index * (size_t)lattice->box.size[0];
    row->blocked_links =
        propagation->blocked_links != NULL ? propagation->blocked_links + index * (size_t)propagation->blocks : NULL;
    for (int32_t c = 0; c < 3; ++c) {
        row->albedo[c] = propagation->mode == TY_LPV_MODE_LINKS ? lattice->albedo[c] + row->first : NULL;
        for (int32_t l = 0; l < TY_LPV_BANDS_MAX; ++l)
            row->scatter_factor[c][l] = ty_lpv_propagation_factor(propagation, c, TY_FACTOR_SCATTER + l, y, z);
    }
}

ty_lpv_row ty_lpv_propagation_begin_row(const ty_lpv_propagation* propagation) {
    return (ty_lpv_row){.count = propagation->lattice->box.size[0],
                        .terms = propagation->lattice->terms,
                        .pitch = propagation->pitch,
                        .link_functions = &propagation->link_functions,
                        .transmission = (const uint8_t* const*)propagation->lattice->transmission};
}

void ty_lpv_propagation_move_row(const ty_lpv_propagation* propagation, int32_t y, int32_t z, ty_lpv_row* row) {
    const int32_t last = propagation->lattice->box.size[1] - 1;
    if (y < 2 || y == last) find_border(propagation, y, z, row); /* equal for all rows between */
    point_at(propagation, y, z, row);
}

static double add_lanes(const float lanes[TY_LPV_BLOCK]) {
    double sum = 0;
    for (int32_t i = 0; i < TY_LPV_BLOCK; ++i) sum += (double)lanes[i];
    return sum;
}

static void add_slab(const ty_lpv_lane_sums* row, ty_lpv_sums* sums) {
    for (int32_t c = 0; c < 3; ++c) {
        sums->arrived[c] += add_lanes(row->sums[c][TY_LPV_ARRIVED]);
        sums->size[c] += add_lanes(row->sums[c][TY_LPV_SIZE]);
        sums->goes_on[c] += add_lanes(row->sums[c][TY_LPV_GOES_ON]);
        sums->blocked[c] += add_lanes(row->sums[c][TY_LPV_BLOCKED]);
        sums->left[c] += add_lanes(row->sums[c][TY_LPV_LEFT]);
    }
}

static void step_slab(const ty_lpv_propagation* propagation, int32_t z) {
    const int32_t* size = propagation->lattice->box.size;
    ty_lpv_row row = ty_lpv_propagation_begin_row(propagation);
    propagation->slabs[z] = (ty_lpv_sums){.arrived = {0}};
    ty_lpv_lane_sums sums;
    memset(&sums, 0, sizeof sums);
    for (int32_t y = 0; y < size[1]; ++y) {
        ty_lpv_propagation_move_row(propagation, y, z, &row);
        propagation->kernels->step(&row, &sums);
    }
    add_slab(&sums, &propagation->slabs[z]);
}

/* Steps consecutive slabs, which share the rows read last. */
static void step_slabs(void* user, int64_t index, int32_t worker) {
    (void)worker;
    const ty_lpv_propagation* propagation = user;
    const int32_t begin = (int32_t)index * propagation->batch, size = propagation->lattice->box.size[2];
    const int32_t end = begin + propagation->batch < size ? begin + propagation->batch : size;
    for (int32_t z = begin; z < end; ++z) step_slab(propagation, z);
}

static ty_lpv_sums add_slabs(const ty_lpv_propagation* propagation) {
    ty_lpv_sums sums = {.arrived = {0}};
    for (int32_t z = 0; z < propagation->lattice->box.size[2]; ++z)
        for (int32_t c = 0; c < 3; ++c) {
            sums.arrived[c] += propagation->slabs[z].arrived[c];
            sums.size[c] += propagation->slabs[z].size[c];
            sums.goes_on[c] += propagation->slabs[z].goes_on[c];
            sums.blocked[c] += propagation->slabs[z].blocked[c];
            sums.left[c] += propagation->slabs[z].left[c];
        }
    return sums;
}

ty_lpv_sums ty_lpv_propagation_step(ty_lpv_propagation* propagation, bool adds) {
    propagation->adds = adds;
    const int32_t size = propagation->lattice->box.size[2];
    ty_parallel_flushed(propagation->lattice->context, (size + propagation->batch - 1) / propagation->batch, step_slabs,
                        propagation);
    float* done = propagation->from;
    propagation->from = propagation->to;
    propagation->to = done;
    return add_slabs(propagation);
}

/* ---- injection and gathering ---- */

typedef struct slab_job {
    ty_lpv_propagation* propagation;
    float* const (*own_cell_sh)[TY_SH_TERMS]; /* NULL: injected_fraction of the medium's operator */
    bool pending;                             /* whether the last step is not in the sum yet */
} slab_job;

/* The part of a row's injected light that counts in its own cell. */
static void count_row(const slab_job* job, int32_t channel, int32_t term, size_t first, const float* propagated_sh,
                      const float* fraction, float* counted) {
    const int32_t count = job->propagation->lattice->box.size[0];
    const float* own_cell_sh = job->own_cell_sh != NULL ? job->own_cell_sh[channel][term] : NULL;
    for (int32_t x = 0; x < count; ++x)
        counted[x] = job->own_cell_sh == NULL ? fraction[x] * propagated_sh[x]
                     : own_cell_sh != NULL    ? own_cell_sh[first + (size_t)x]
                                              : 0.0f;
}

static void inject_slab(void* user, int64_t index, int32_t worker) {
    (void)worker;
    const slab_job* job = user;
    ty_lpv_propagation* propagation = job->propagation;
    const ty_lattice* lattice = propagation->lattice;
    const int32_t *size = lattice->box.size, z = (int32_t)index;
    float counted[TY_LPV_CELLS_MAX];
    ty_lpv_sums* sums = &propagation->slabs[z];
    *sums = (ty_lpv_sums){.arrived = {0}};
    for (int32_t y = 0; y < size[1]; ++y)
        for (int32_t i = 0; i < 3 * lattice->terms; ++i) {
            const int32_t c = i / lattice->terms, t = i % lattice->terms;
            const size_t place = ty_lpv_propagation_index(propagation, y, z) + (size_t)(i * propagation->pitch.term);
            const size_t first = ((size_t)z * (size_t)size[1] + (size_t)y) * (size_t)size[0];
            const float* propagated_sh = lattice->propagated_sh[c][t] + first;
            const float* scatter_factor =
                ty_lpv_propagation_factor(propagation, c, TY_FACTOR_SCATTER + ty_sh_band(t), y, z);
            count_row(job, c, t, first, propagated_sh,
                      ty_lpv_propagation_factor(propagation, c, TY_FACTOR_INJECTED + ty_sh_band(t), y, z), counted);
            for (int32_t x = 0; x < size[0]; ++x) {
                const float passed = scatter_factor[x] * propagated_sh[x];
                propagation->from[place + (size_t)x] =
                    propagation->entered ? propagation->from[place + (size_t)x] + passed : passed;
                propagation->sum[place + (size_t)x] = scatter_factor[x] * counted[x] - passed;
                if (t > 0) continue;
                sums->arrived[c] += (double)propagated_sh[x];
                sums->size[c] += (double)fabsf(propagated_sh[x]);
                sums->goes_on[c] += (double)passed;
            }
        }
}

ty_lpv_sums ty_lpv_propagation_inject(ty_lpv_propagation* propagation, float* const own_cell_sh[3][TY_SH_TERMS]) {
    slab_job job = {.propagation = propagation, .own_cell_sh = own_cell_sh};
    ty_parallel_flushed(propagation->lattice->context, propagation->lattice->box.size[2], inject_slab, &job);
    return add_slabs(propagation);
}

static void gather_slab(void* user, int64_t index, int32_t worker) {
    (void)worker;
    const slab_job* job = user;
    const ty_lpv_propagation* propagation = job->propagation;
    const ty_lattice* lattice = propagation->lattice;
    const int32_t *size = lattice->box.size, z = (int32_t)index;
    const float per_volume = 1.0f / (lattice->cell * lattice->cell * lattice->cell);
    float counted[TY_LPV_CELLS_MAX];
    for (int32_t y = 0; y < size[1]; ++y)
        for (int32_t i = 0; i < 3 * lattice->terms; ++i) {
            const int32_t c = i / lattice->terms, t = i % lattice->terms;
            const size_t first = ((size_t)z * (size_t)size[1] + (size_t)y) * (size_t)size[0];
            const float *length = ty_lpv_propagation_factor(propagation, c, TY_FACTOR_LENGTH, y, z),
                        *flux_factor = ty_lpv_propagation_factor(propagation, c, TY_FACTOR_FLUX, y, z);
            const float* scatter_factor =
                ty_lpv_propagation_factor(propagation, c, TY_FACTOR_SCATTER + ty_sh_band(t), y, z);
            const size_t homogeneous =
                ty_lpv_propagation_index(propagation, y, z) + (size_t)(c * lattice->terms * propagation->pitch.term);
            const size_t place = homogeneous + (size_t)(t * propagation->pitch.term);
            const float flowing = job->pending ? 1.0f : 0.0f;
            float *propagated_sh = lattice->propagated_sh[c][t] + first, *light = lattice->light[c][t] + first;
            count_row(job, c, t, first, propagated_sh,
                      ty_lpv_propagation_factor(propagation, c, TY_FACTOR_INJECTED + ty_sh_band(t), y, z), counted);
            for (int32_t x = 0; x < size[0]; ++x) {
                const float scale = length[x] * per_volume * (ty_sh_band(t) == 1 ? flux_factor[x] : 1.0f);
                const bool is_lit =
                    propagation->sum[homogeneous + (size_t)x] + flowing * propagation->from[homogeneous + (size_t)x] >
                    0.0f;
                const float sum = propagation->sum[place + (size_t)x] + flowing * propagation->from[place + (size_t)x];
                light[x] = is_lit ? sum / scatter_factor[x] * scale : 0.0f;
                propagated_sh[x] = (propagated_sh[x] - counted[x]) * scale;
            }
        }
}

void ty_lpv_propagation_gather(ty_lpv_propagation* propagation, float* const own_cell_sh[3][TY_SH_TERMS],
                               bool pending) {
    slab_job job = {.propagation = propagation, .own_cell_sh = own_cell_sh, .pending = pending};
    ty_parallel_flushed(propagation->lattice->context, propagation->lattice->box.size[2], gather_slab, &job);
}
