/* What iterations start from: a solution on cells twice as large, of few bands and sweeps. It costs less than half a
 * sweep of the whole, and is off by what cells leave out, some percent, where diffusion alone is by a third and more.
 */
#include "base/arena.h"
#include "base/kernel.h"
#include "base/parallel.h"
#include "solve/ordinates/job.h"

#include <math.h>
#include <string.h>

/* Boxes of fewer cells start from diffusion, axes of fewer stay as they are. More bands or sweeps of the coarse box
 * save none of the whole. */
enum { LEAST_CELLS = 1 << 14, LEAST_SIDE = 8, BANDS = 3, SWEEPS = 2, TERMS = BANDS * BANDS };

typedef struct coarse_box {
    ty_ordinates_job* fine;
    ty_ordinates_def def;
    int32_t times[3]; /* cells along each axis that make one: 1 or 2 */
    size_t cells;
    float *extinction, *scattering, *g;
    float *source[TERMS], *moments[TERMS];
} coarse_box;

/* ---- where it pays ---- */

/* Of cells' edges in mean free paths, reduced ones; and of the light's first moments beside the zeroth, rms. */
static const double THICKEST = 0.5, LEAST_DIRECTED = 0.5;

static bool is_thin(const ty_ordinates_job* job) {
    const ty_ordinates_def* def = job->def;
    const double edge = fmax(fmax(def->cell[0], def->cell[1]), def->cell[2]);
    float most = 0;
    for (int64_t i = 0; i < job->cells; ++i) most = ty_maxf(most, def->extinction[i] - def->g[i] * def->scattering[i]);
    return (double)most * edge <= THICKEST;
}

static bool is_directed(const ty_ordinates_job* job) {
    double squares[2] = {0, 0};
    for (int32_t t = 0; t < 4; ++t)
        for (int64_t i = 0; i < job->cells; ++i)
            squares[t > 0] += (double)job->def->source[t][i] * (double)job->def->source[t][i];
    return squares[1] > LEAST_DIRECTED * LEAST_DIRECTED * squares[0];
}

static bool pays(const ty_ordinates_job* job) {
    return job->cells >= LEAST_CELLS && job->def->walls.count == 0 && job->def->bands >= BANDS &&
           job->def->source_terms > 1 && is_thin(job) && is_directed(job);
}

/* ---- memory ---- */

static float* take(const coarse_box* coarse, ty_arena* arena) {
    return ty_arena_take(arena, sizeof(float) * coarse->cells);
}

static void lay_out(coarse_box* coarse, ty_arena* arena) {
    coarse->extinction = take(coarse, arena);
    coarse->scattering = take(coarse, arena);
    coarse->g = take(coarse, arena);
    for (int32_t t = 0; t < TERMS; ++t) coarse->source[t] = take(coarse, arena);
    for (int32_t t = 0; t < TERMS; ++t) coarse->moments[t] = take(coarse, arena);
    coarse->def.memory = ty_arena_take(arena, ty_ordinates_memory(&coarse->def));
}

/* Where later iterates of the fine box go. False: it is too little, as of boxes of a few cells across. */
static bool take_memory(coarse_box* coarse) {
    const ty_ordinates_job* fine = coarse->fine;
    char *begin = (char*)fine->moments[1], *end = (char*)fine->changes[fine->depth - 1];
    ty_arena arena = {0};
    lay_out(coarse, &arena);
    if (arena.used > (size_t)(end - begin)) return false;
    arena = (ty_arena){.base = begin};
    lay_out(coarse, &arena);
    return true;
}

/* ---- to the coarse box ---- */

/* Sums over the fine rows of a coarse one. weight: of fine cells; NULL: 1. */
static void sum_rows(const coarse_box* coarse, const float* from, const float* weight, int32_t y, int32_t z,
                     float* sum) {
    const int32_t *fine = coarse->fine->def->size, *times = coarse->times;
    memset(sum, 0, sizeof *sum * (size_t)(fine[0] + 1));
    for (int32_t k = z * times[2]; k < (z + 1) * times[2] && k < fine[2]; ++k)
        for (int32_t j = y * times[1]; j < (y + 1) * times[1] && j < fine[1]; ++j) {
            const size_t at = (size_t)fine[0] * ((size_t)j + (size_t)fine[1] * (size_t)k);
            for (size_t x = 0; x < (size_t)fine[0]; ++x)
                sum[x] += weight != NULL ? weight[at + x] * from[at + x] : from[at + x];
        }
}

/* Means over a row of coarse cells; where the box ends within one, the rest is vacuum. */
static void mean_row(const coarse_box* coarse, const float* from, const float* weight, int32_t y, int32_t z,
                     float* to) {
    const int32_t *times = coarse->times, width = coarse->def.size[0];
    const float share = 1 / (float)(times[0] * times[1] * times[2]);
    float sum[TY_ORDINATES_SIDE_MAX + 1];
    sum_rows(coarse, from, weight, y, z, sum);
    for (int32_t x = 0; x < width; ++x) to[x] = share * (times[0] == 2 ? sum[2 * x] + sum[2 * x + 1] : sum[x]);
}

static void mean_plane(void* user, int64_t z, int32_t worker) {
    (void)worker;
    const coarse_box* coarse = user;
    const ty_ordinates_def* def = coarse->fine->def;
    const int32_t *size = coarse->def.size, plane = (int32_t)z;
    for (int32_t y = 0; y < size[1]; ++y) {
        const size_t at = (size_t)size[0] * ((size_t)y + (size_t)size[1] * (size_t)z);
        float *extinction = coarse->extinction + at, *scattering = coarse->scattering + at, *g = coarse->g + at;
        mean_row(coarse, def->extinction, NULL, y, plane, extinction);
        mean_row(coarse, def->scattering, NULL, y, plane, scattering);
        mean_row(coarse, def->g, def->scattering, y, plane, g);
        for (int32_t x = 0; x < size[0]; ++x) {
            /* Rounding must not take means out of their ranges. */
            g[x] = scattering[x] > 0 ? ty_clampf(g[x] / scattering[x], -0.9999f, 0.9999f) : 0;
            scattering[x] = ty_minf(scattering[x], extinction[x]);
        }
        for (int32_t t = 0; t < TERMS; ++t) mean_row(coarse, def->source[t], NULL, y, plane, coarse->source[t] + at);
    }
}

/* ---- and back ---- */

/* The coarse cells whose middles are on either side of a fine one's, and their shares. */
typedef struct pair {
    int32_t at[2];
    float share[2];
} pair;

static pair find_pair(int32_t index, int32_t times, int32_t size) {
    if (times == 1) return (pair){{index, index}, {1, 0}};
    const int32_t near = index / 2, beside = (index & 1) != 0 ? near + 1 : near - 1;
    return (pair){{near, beside < 0 || beside >= size ? near : beside}, {0.75f, 0.25f}};
}

/* A row of one coarse term, linear across rows, with the cells at its ends once more beside it. */
static void mix_rows(const coarse_box* coarse, const float* term, const pair* y, const pair* z, float* to) {
    const size_t width = (size_t)coarse->def.size[0], rows = (size_t)coarse->def.size[1];
    memset(to, 0, sizeof *to * (width + 2));
    for (int i = 0; i < 4; ++i) {
        const float share = y->share[i & 1] * z->share[i >> 1];
        const float* from = term + width * ((size_t)y->at[i & 1] + rows * (size_t)z->at[i >> 1]);
        for (size_t x = 0; x < width; ++x) to[x + 1] += share * from[x];
    }
    to[0] = to[1];
    to[width + 1] = to[width];
}

/* The term of a row of fine cells, linear along it. */
static void spread_row(const coarse_box* coarse, const float* row, int32_t term, float* to) {
    const int32_t terms = coarse->fine->terms, width = coarse->fine->def->size[0];
    if (coarse->times[0] == 1) {
        for (int32_t x = 0; x < width; ++x) to[x * terms + term] = row[x + 1];
        return;
    }
    for (int32_t x = 0; x < width; x += 2) {
        const float *here = row + x / 2 + 1, most = 0.75f * *here;
        to[x * terms + term] = most + 0.25f * here[-1];
        if (x + 1 < width) to[(x + 1) * terms + term] = most + 0.25f * here[1];
    }
}

static void spread_plane(void* user, int64_t z, int32_t worker) {
    (void)worker;
    const coarse_box* coarse = user;
    const ty_ordinates_job* fine = coarse->fine;
    const int32_t *size = fine->def->size, *from = coarse->def.size, *times = coarse->times;
    const size_t items = (size_t)fine->terms * (size_t)size[0];
    const pair along_z = find_pair((int32_t)z, times[2], from[2]);
    float row[TY_ORDINATES_SIDE_MAX + 2];
    for (int32_t y = 0; y < size[1]; ++y) {
        const pair along_y = find_pair(y, times[1], from[1]);
        float* to = fine->moments[0] + items * ((size_t)y + (size_t)size[1] * (size_t)z);
        memset(to, 0, sizeof *to * items);
        for (int32_t t = 0; t < TERMS; ++t) {
            mix_rows(coarse, coarse->moments[t], &along_y, &along_z, row);
            spread_row(coarse, row, t, to);
        }
    }
}

/* ---- work ---- */

/* Of the coarse solve the caller hears that it is there, and may end it. */
static bool report(void* user, const ty_progress* part) {
    const ty_ordinates_job* job = user;
    ty_progress progress = *part;
    progress.fraction = 0;
    progress.remaining = -1;
    return job->def->progress(job->def->progress_user, &progress);
}

static bool define(coarse_box* coarse) {
    ty_ordinates_def* def = &coarse->def;
    *def = *coarse->fine->def;
    coarse->cells = 1;
    for (int a = 0; a < 3; ++a) {
        coarse->times[a] = def->size[a] >= LEAST_SIDE ? 2 : 1;
        def->size[a] = (def->size[a] + coarse->times[a] - 1) / coarse->times[a];
        def->cell[a] *= coarse->times[a];
        coarse->cells *= (size_t)def->size[a];
    }
    def->bands = def->kept = BANDS;
    def->source_terms = TERMS;
    def->sweeps = SWEEPS;
    def->scattered = NULL;
    def->progress = def->progress != NULL ? report : NULL;
    def->progress_user = coarse->fine;
    if (!take_memory(coarse)) return false;
    def->extinction = coarse->extinction;
    def->scattering = coarse->scattering;
    def->g = coarse->g;
    def->source = (const float* const*)coarse->source;
    return true;
}

ty_result ty_ordinates_coarse_initial_guess(ty_ordinates_job* job) {
    coarse_box coarse = {.fine = job};
    if (!pays(job) || !define(&coarse)) return TY_OK;
    ty_parallel_flushed(job->context, coarse.def.size[2], mean_plane, &coarse);
    const ty_result result = ty_ordinates_solve(job->context, &coarse.def, coarse.moments, NULL, 0, NULL);
    if (result != TY_OK) return result;
    ty_ordinates_planes(job, spread_plane, &coarse);
    ty_ordinates_start(job);
    return TY_OK;
}
