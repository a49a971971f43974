/* Memory, media and surfaces of light on its way, and its steps. */
#include "method/lpv/march.h"

#include "base/context.h"
#include "base/parallel.h"

/* ---- shapes ---- */

/* Cosines about links for light that surfaces send back, relative to its first term: 2 / sqrt 3 and sqrt 5 / 4 times
 * what functions that are 1 along the link are of. */
static void make_lobe(const int32_t step[3], float lobe[TY_SH_TERMS]) {
    const ty_vec way = ty_normalize(ty_vec_make((float)step[0], (float)step[1], (float)step[2]));
    float y[TY_SH_TERMS];
    ty_sh_at(way, TY_SH_BANDS, y);
    for (int32_t t = 0; t < TY_SH_TERMS; ++t) lobe[t] = y[t] * ty_sh_cosine(ty_sh_band(t)) / (TY_SH_0 * TY_PI);
}

static ty_lpv_shapes make_shapes(const ty_lpv_transfer* transfer) {
    ty_lpv_shapes shapes = {.even = {0}};
    memcpy(shapes.all, transfer->shape, sizeof shapes.all);
    for (int32_t k = 0; k < TY_LPV_LINKS; ++k) make_lobe(transfer->step[k], shapes.lobes[k]);
    for (int32_t kind = 0; kind < 3; ++kind) {
        const int32_t k = ty_lpv_link(1, kind > 0, kind > 1);
        shapes.even[kind] = shapes.all[k][0];
        shapes.along[kind] = shapes.all[k][3];
    }
    return shapes;
}

/* ---- media ---- */

static bool is_even(const ty_lattice* lattice) {
    const ty_grid_medium* medium = lattice->medium;
    if (lattice->spread != NULL) return false;
    if (medium == NULL) return true;
    for (int32_t c = 0; c < medium->planes; ++c) {
        const float *t = medium->extinction[c], *s = medium->scattering[c], *g = medium->g[c];
        for (size_t i = 1; i < medium->cells; ++i)
            if (t[i] != t[0] || s[i] != s[0] || g[i] != g[0]) return false;
    }
    return true;
}

static void store_step(const ty_lpv_medium_step* step, int32_t bands, float* factors, size_t apart) {
    for (int32_t l = 0; l < bands; ++l) {
        factors[(size_t)(TY_FACTOR_PASS + l) * apart] = step->pass[l];
        factors[(size_t)(TY_FACTOR_SEEN + l) * apart] = step->seen[l];
    }
    factors[TY_FACTOR_LENGTH * apart] = step->length;
    factors[TY_FACTOR_SHOWN * apart] = step->shown[1];
}

/* The step of the cell before, which is mostly that of the next one but for lamps. */
typedef struct last_step {
    bool exists;
    ty_lpv_cell_medium medium;
    ty_lpv_links_step links;
    ty_lpv_medium_step step;
} last_step;

static void step_in(const ty_lpv_march* march, int32_t channel, size_t cell, last_step* last) {
    const ty_lpv_cell_medium medium = ty_lattice_medium_in(march->lattice, channel, cell);
    const bool links = march->mode == TY_LPV_MODE_LINKS;
    const bool alike = last->exists && medium.extinction == last->medium.extinction &&
                       medium.scattering == last->medium.scattering && medium.g == last->medium.g;
    if (alike && (!links || medium.spread == last->medium.spread)) return;
    if (links && !alike) last->links = ty_lpv_links_step_in(&march->transfer, march->lattice->cell, &medium);
    last->step = links ? ty_lpv_links_step_about(&march->transfer, march->lattice->cell, &last->links, medium.spread)
                       : ty_lpv_step_in(&march->transfer, march->mode, march->lattice->cell, &medium);
    last->medium = medium;
    last->exists = true;
}

/* Of a plane of cells; of one row where media are the same everywhere. Rows are filled up to whole blocks. */
static void find_factors(const ty_lpv_march* march, int32_t z) {
    const int32_t *size = march->lattice->box.size, width = march->blocks * TY_LPV_BLOCK;
    if (march->even && z > 0) return;
    for (int32_t c = 0; c < march->planes; ++c) {
        last_step last = {.exists = false};
        for (int32_t y = 0; y < (march->even ? 1 : size[1]); ++y) {
            const size_t row = (size_t)(z * size[1] + y);
            float* to = march->factors[c] + row * (size_t)width;
            for (int32_t x = 0; x < width; ++x) {
                if (x < size[0]) step_in(march, c, row * (size_t)size[0] + (size_t)x, &last);
                store_step(&last.step, march->lattice->bands, to + x, march->factor_floats);
            }
        }
    }
}

/* ---- surfaces ---- */

static void find_near(const ty_lpv_march* march, int32_t z) {
    const int32_t* size = march->lattice->box.size;
    for (int32_t y = 0; y < size[1]; ++y) {
        const size_t row = (size_t)z * (size_t)size[1] + (size_t)y;
        for (int32_t b = 0; b < march->blocks; ++b) {
            const int32_t begin = b * TY_LPV_BLOCK;
            const int32_t count = size[0] - begin < TY_LPV_BLOCK ? size[0] - begin : TY_LPV_BLOCK;
            uint32_t links = 0;
            for (int32_t k = 0; k < TY_LPV_LINKS; ++k) {
                const uint8_t* open = march->lattice->open[k] + row * (size_t)size[0] + begin;
                uint8_t all = 255;
                for (int32_t i = 0; i < count; ++i) all &= open[i];
                links |= (all != 255 ? 1u : 0u) << k;
            }
            march->near[row * (size_t)march->blocks + (size_t)b] = links;
        }
    }
}

/* ---- memory ---- */

enum { BATCHES = 4 }; /* of slabs, per thread and step */

static ty_result take_memory(ty_lpv_march* march) {
    ty_context* context = march->lattice->context;
    const double bytes = sizeof(float) * (3.0 * (double)march->floats +
                                          (double)(march->planes * TY_FACTORS) * (double)march->factor_floats);
    ty_result result = ty_check_memory(context, bytes, "light on its way");
    if (result != TY_OK) return result;
    march->flows = ty_alloc_array(context, 3 * march->floats, sizeof(float), false);
    if (march->flows == NULL) return TY_ERROR_MEMORY;
    march->from = march->flows;
    march->to = march->flows + march->floats;
    march->sum = march->flows + 2 * march->floats;
    for (int32_t c = 0; c < march->planes; ++c) {
        march->factors[c] = ty_alloc_array(context, TY_FACTORS * march->factor_floats, sizeof(float), false);
        if (march->factors[c] == NULL) return TY_ERROR_MEMORY;
    }
    march->slabs = ty_alloc_array(context, (size_t)march->lattice->box.size[2], sizeof *march->slabs, true);
    if (march->slabs == NULL) return TY_ERROR_MEMORY;
    if (!march->lattice->blocked) return TY_OK;
    march->near = ty_alloc_array(context, march->near_count, sizeof *march->near, false);
    return march->near == NULL ? TY_ERROR_MEMORY : TY_OK;
}

/* ---- darkness ---- */

static void clear_floats(const ty_lpv_march* march, size_t first, size_t count) {
    memset(march->from + first, 0, count * sizeof(float));
    memset(march->to + first, 0, count * sizeof(float));
}

/* What is around a plane's cells; together with the planes before the first and behind the last, all there is around
 * the lattice. Cells themselves get what is injected, and what steps bring. */
static void clear_around(const ty_lpv_march* march, int32_t z) {
    const int32_t* size = march->lattice->box.size;
    const size_t row = (size_t)march->pitch.row, term = (size_t)march->pitch.term, width = (size_t)size[0];
    const size_t terms = (size_t)(3 * march->lattice->terms), plane = (size_t)march->pitch.plane;
    if (z == -1) clear_floats(march, 0, plane + TY_LPV_BLOCK);
    if (z == size[2]) clear_floats(march, march->floats - plane - TY_LPV_BLOCK, plane + TY_LPV_BLOCK);
    if (z == -1 || z == size[2]) return;
    clear_floats(march, ty_lpv_march_place(march, -1, z), row);
    clear_floats(march, ty_lpv_march_place(march, size[1], z), row);
    for (int32_t y = 0; y < size[1]; ++y)
        for (size_t i = 0; i < terms; ++i) {
            const size_t end = ty_lpv_march_place(march, y, z) + i * term + width;
            clear_floats(march, end, term - width);
            memset(march->sum + end, 0, (term - width) * sizeof(float));
        }
}

static void prepare_plane(void* user, int64_t index, int32_t worker) {
    (void)worker;
    const ty_lpv_march* march = user;
    const int32_t z = (int32_t)index - 1;
    clear_around(march, z);
    if (z < 0 || z >= march->lattice->box.size[2]) return;
    find_factors(march, z);
    if (march->near != NULL) find_near(march, z);
}

void ty_lpv_march_destroy(ty_lpv_march* march) {
    ty_context* context = march->lattice->context;
    ty_free_array(context, march->flows, 3 * march->floats, sizeof(float));
    for (int32_t c = 0; c < march->planes; ++c)
        ty_free_array(context, march->factors[c], TY_FACTORS * march->factor_floats, sizeof(float));
    ty_free_array(context, march->slabs, (size_t)march->lattice->box.size[2], sizeof *march->slabs);
    ty_free_array(context, march->near, march->near_count, sizeof *march->near);
}

ty_result ty_lpv_march_create(ty_lattice* lattice, const ty_lpv_def* def, ty_lpv_march* march) {
    const int32_t* size = lattice->box.size;
    *march = (ty_lpv_march){.lattice = lattice, .mode = def->mode, .kernels = TY_BEST_KERNELS(ty_lpv_kernels)};
    ty_lpv_transfer_make(lattice->bands, def->mode == TY_LPV_MODE_LINKS, &march->transfer);
    march->shapes = make_shapes(&march->transfer);
    march->blocks = (size[0] + TY_LPV_BLOCK - 1) / TY_LPV_BLOCK;
    march->pitch.term = march->blocks * TY_LPV_BLOCK + 8; /* whole blocks, and at least one dark cell before the next */
    march->pitch.row = 3 * lattice->terms * march->pitch.term;
    march->pitch.plane = (size[1] + 2) * march->pitch.row;
    march->floats = (size_t)((size[2] + 2) * march->pitch.plane) + 2 * (size_t)TY_LPV_BLOCK;
    march->batch = size[2] / (BATCHES * ty_context_threads(lattice->context)) + 1;
    march->even = is_even(lattice);
    march->planes = lattice->medium != NULL ? lattice->medium->planes : 1;
    const size_t rows = (size_t)size[1] * (size_t)size[2];
    march->factor_floats = (size_t)(march->blocks * TY_LPV_BLOCK) * (march->even ? 1 : rows);
    march->near_count = rows * (size_t)march->blocks;
    const ty_result result = take_memory(march);
    if (result != TY_OK) {
        ty_lpv_march_destroy(march);
        return result;
    }
    ty_parallel_flushed(lattice->context, size[2] + 2, prepare_plane, march);
    return TY_OK;
}

/* ---- steps ---- */

/* Whether what goes against link k from the cells at a place (0: the first, 1: between, 2: the last) of a row leaves
 * the lattice; a row of one cell has it as the first. */
static bool leaves(const ty_lpv_march* march, int32_t place, int32_t y, int32_t z, int32_t k) {
    const int32_t *step = march->transfer.step[k], *size = march->lattice->box.size;
    const bool first = place == 0, last = place == 2 || (first && size[0] == 1);
    return (first && step[0] > 0) || (last && step[0] < 0) || y - step[1] < 0 || y - step[1] >= size[1] ||
           z - step[2] < 0 || z - step[2] >= size[2];
}

static void find_border(const ty_lpv_march* march, int32_t y, int32_t z, ty_lpv_row* row) {
    memset(row->out, 0, sizeof row->out);
    row->border = false;
    for (int32_t k = 0; k < TY_LPV_LINKS; ++k) {
        const int32_t against = k < TY_LPV_HALF_LINKS ? k + TY_LPV_HALF_LINKS : k - TY_LPV_HALF_LINKS;
        const float* shape = march->transfer.shape[against];
        for (int32_t place = 0; place < 3; ++place) {
            row->leaves[place][k] = leaves(march, place, y, z, k);
            if (row->leaves[place][k] == 0) continue;
            for (int32_t t = 0; t < row->terms; ++t) row->out[place][t] += shape[0] * shape[t];
            row->border = row->border || place == 1;
        }
    }
}

static void point_at(const ty_lpv_march* march, int32_t y, int32_t z, ty_lpv_row* row) {
    const ty_lattice* lattice = march->lattice;
    const size_t place = ty_lpv_march_place(march, y, z);
    const size_t index = (size_t)z * (size_t)lattice->box.size[1] + (size_t)y;
    row->from = march->from + place;
    row->to = march->to + place;
    row->sum = march->adds ? march->sum + place : NULL;
    row->first = index * (size_t)lattice->box.size[0];
    row->near = march->near != NULL ? march->near + index * (size_t)march->blocks : NULL;
    for (int32_t c = 0; c < 3; ++c) {
        row->albedo[c] = march->mode == TY_LPV_MODE_LINKS ? lattice->albedo[c] + row->first : NULL;
        for (int32_t l = 0; l < TY_LPV_BANDS_MAX; ++l)
            row->pass[c][l] = ty_lpv_march_factor(march, c, TY_FACTOR_PASS + l, y, z);
    }
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
        sums->kept[c] += add_lanes(row->sums[c][TY_LPV_KEPT]);
        sums->left[c] += add_lanes(row->sums[c][TY_LPV_LEFT]);
    }
}

static void step_slab(const ty_lpv_march* march, int32_t z) {
    const int32_t* size = march->lattice->box.size;
    ty_lpv_row row = {.count = size[0],
                      .terms = march->lattice->terms,
                      .pitch = march->pitch,
                      .shapes = &march->shapes,
                      .open = (const uint8_t* const*)march->lattice->open};
    march->slabs[z] = (ty_lpv_sums){.arrived = {0}};
    ty_lpv_lane_sums sums;
    memset(&sums, 0, sizeof sums);
    for (int32_t y = 0; y < size[1]; ++y) {
        if (y < 2 || y == size[1] - 1) find_border(march, y, z, &row); /* alike for all rows between */
        point_at(march, y, z, &row);
        march->kernels->step(&row, &sums);
    }
    add_slab(&sums, &march->slabs[z]);
}

/* Slabs one after another, as each begins with what the last one read. */
static void step_slabs(void* user, int64_t index, int32_t worker) {
    (void)worker;
    const ty_lpv_march* march = user;
    const int32_t begin = (int32_t)index * march->batch, size = march->lattice->box.size[2];
    const int32_t end = begin + march->batch < size ? begin + march->batch : size;
    for (int32_t z = begin; z < end; ++z) step_slab(march, z);
}

static ty_lpv_sums add_slabs(const ty_lpv_march* march) {
    ty_lpv_sums sums = {.arrived = {0}};
    for (int32_t z = 0; z < march->lattice->box.size[2]; ++z)
        for (int32_t c = 0; c < 3; ++c) {
            sums.arrived[c] += march->slabs[z].arrived[c];
            sums.size[c] += march->slabs[z].size[c];
            sums.goes_on[c] += march->slabs[z].goes_on[c];
            sums.kept[c] += march->slabs[z].kept[c];
            sums.left[c] += march->slabs[z].left[c];
        }
    return sums;
}

ty_lpv_sums ty_lpv_march_step(ty_lpv_march* march, bool adds) {
    march->adds = adds;
    const int32_t size = march->lattice->box.size[2];
    ty_parallel_flushed(march->lattice->context, (size + march->batch - 1) / march->batch, step_slabs, march);
    float* done = march->from;
    march->from = march->to;
    march->to = done;
    return add_slabs(march);
}

/* ---- injection and the end ---- */

typedef struct slab_job {
    ty_lpv_march* march;
    float* const (*seen)[TY_SH_TERMS]; /* NULL: what media's steps say */
    bool pending;                      /* whether what flows is not in the sum yet */
} slab_job;

/* What counts of the light that is injected into a row. */
static void count_row(const slab_job* job, int32_t channel, int32_t term, size_t first, const float* flow,
                      const float* share, float* counted) {
    const int32_t count = job->march->lattice->box.size[0];
    const float* seen = job->seen != NULL ? job->seen[channel][term] : NULL;
    for (int32_t x = 0; x < count; ++x)
        counted[x] = job->seen == NULL ? share[x] * flow[x] : seen != NULL ? seen[first + (size_t)x] : 0.0f;
}

static void inject_slab(void* user, int64_t index, int32_t worker) {
    (void)worker;
    const slab_job* job = user;
    ty_lpv_march* march = job->march;
    const ty_lattice* lattice = march->lattice;
    const int32_t *size = lattice->box.size, z = (int32_t)index;
    float counted[TY_LPV_CELLS_MAX];
    ty_lpv_sums* sums = &march->slabs[z];
    *sums = (ty_lpv_sums){.arrived = {0}};
    for (int32_t y = 0; y < size[1]; ++y)
        for (int32_t i = 0; i < 3 * lattice->terms; ++i) {
            const int32_t c = i / lattice->terms, t = i % lattice->terms;
            const size_t place = ty_lpv_march_place(march, y, z) + (size_t)(i * march->pitch.term);
            const size_t first = ((size_t)z * (size_t)size[1] + (size_t)y) * (size_t)size[0];
            const float* flow = lattice->flow[c][t] + first;
            const float* pass = ty_lpv_march_factor(march, c, TY_FACTOR_PASS + ty_sh_band(t), y, z);
            count_row(job, c, t, first, flow, ty_lpv_march_factor(march, c, TY_FACTOR_SEEN + ty_sh_band(t), y, z),
                      counted);
            for (int32_t x = 0; x < size[0]; ++x) {
                const float passed = pass[x] * flow[x];
                march->from[place + (size_t)x] = march->entered ? march->from[place + (size_t)x] + passed : passed;
                march->sum[place + (size_t)x] = pass[x] * counted[x] - passed;
                if (t > 0) continue;
                sums->arrived[c] += (double)flow[x];
                sums->size[c] += (double)fabsf(flow[x]);
                sums->goes_on[c] += (double)passed;
            }
        }
}

ty_lpv_sums ty_lpv_march_inject(ty_lpv_march* march, float* const seen[3][TY_SH_TERMS]) {
    slab_job job = {.march = march, .seen = seen};
    ty_parallel_flushed(march->lattice->context, march->lattice->box.size[2], inject_slab, &job);
    return add_slabs(march);
}

static void gather_slab(void* user, int64_t index, int32_t worker) {
    (void)worker;
    const slab_job* job = user;
    const ty_lpv_march* march = job->march;
    const ty_lattice* lattice = march->lattice;
    const int32_t *size = lattice->box.size, z = (int32_t)index;
    const float per_volume = 1.0f / (lattice->cell * lattice->cell * lattice->cell);
    float counted[TY_LPV_CELLS_MAX];
    for (int32_t y = 0; y < size[1]; ++y)
        for (int32_t i = 0; i < 3 * lattice->terms; ++i) {
            const int32_t c = i / lattice->terms, t = i % lattice->terms;
            const size_t first = ((size_t)z * (size_t)size[1] + (size_t)y) * (size_t)size[0];
            const float *length = ty_lpv_march_factor(march, c, TY_FACTOR_LENGTH, y, z),
                        *shown = ty_lpv_march_factor(march, c, TY_FACTOR_SHOWN, y, z);
            const float* pass = ty_lpv_march_factor(march, c, TY_FACTOR_PASS + ty_sh_band(t), y, z);
            const size_t even = ty_lpv_march_place(march, y, z) + (size_t)(c * lattice->terms * march->pitch.term);
            const size_t place = even + (size_t)(t * march->pitch.term);
            const float flowing = job->pending ? 1.0f : 0.0f;
            float *flow = lattice->flow[c][t] + first, *light = lattice->light[c][t] + first;
            count_row(job, c, t, first, flow, ty_lpv_march_factor(march, c, TY_FACTOR_SEEN + ty_sh_band(t), y, z),
                      counted);
            for (int32_t x = 0; x < size[0]; ++x) {
                const float scale = length[x] * per_volume * (ty_sh_band(t) == 1 ? shown[x] : 1.0f);
                const bool lit = march->sum[even + (size_t)x] + flowing * march->from[even + (size_t)x] > 0.0f;
                const float sum = march->sum[place + (size_t)x] + flowing * march->from[place + (size_t)x];
                light[x] = lit ? sum / pass[x] * scale : 0.0f;
                flow[x] = (flow[x] - counted[x]) * scale;
            }
        }
}

void ty_lpv_march_gather(ty_lpv_march* march, float* const seen[3][TY_SH_TERMS], bool pending) {
    slab_job job = {.march = march, .seen = seen, .pending = pending};
    ty_parallel_flushed(march->lattice->context, march->lattice->box.size[2], gather_slab, &job);
}
