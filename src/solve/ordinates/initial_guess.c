/* Initial guess from a solution on cells of twice the size, with few bands and sweeps. It costs less than half a sweep
 * of the full box and has the discretisation error of coarse cells, some percent, where diffusion alone is off by a
 * third or more. */
#include "base/arena.h"
#include "base/kernel.h"
#include "base/parallel.h"
#include "solve/ordinates/job.h"

#include <math.h>
#include <string.h>

/* Smaller boxes start from diffusion, shorter axes are not coarsened. More bands or sweeps of the coarse box save no
 * sweep of the full one. */
enum { MIN_CELLS = 1 << 14, MIN_SIDE = 8, BANDS = 3, SWEEPS = 2, TERMS = BANDS * BANDS };

typedef struct coarse_box {
    ty_ordinates_job* fine;
    ty_ordinates_def def;
    ty_domain domain; /* of the coarse cells, where the fine ones are a part */
    int32_t ratio[3]; /* fine cells per coarse cell along each axis: 1 or 2 */
    size_t cells;
    float *extinction, *scattering, *g;
    float *source[TERMS], *moments[TERMS];
} coarse_box;

/* ---- conditions ---- */

/* Maximum cell edge, transport mean free paths; minimum rms of the source's first moments relative to the zeroth. */
static const double MAX_THICKNESS = 0.5, MIN_ANISOTROPY = 0.5;

static bool is_thin(const ty_ordinates_job* job) {
    const ty_ordinates_def* def = job->def;
    const double edge = fmax(fmax(def->cell[0], def->cell[1]), def->cell[2]);
    float max_extinction = 0;
    for (int64_t i = 0; i < job->cells; ++i)
        max_extinction = ty_maxf(max_extinction, def->extinction[i] - def->g[i] * def->scattering[i]);
    return (double)max_extinction * edge <= MAX_THICKNESS;
}

static bool is_anisotropic(const ty_ordinates_job* job) {
    double squares[2] = {0, 0};
    for (int32_t t = 0; t < 4; ++t)
        for (int64_t i = 0; i < job->cells; ++i)
            squares[t > 0] += (double)job->def->source[t][i] * (double)job->def->source[t][i];
    ty_ordinates_sum_ranks(job, squares, 2);
    return squares[1] > MIN_ANISOTROPY * MIN_ANISOTROPY * squares[0];
}

/* Cells of the whole along an axis. */
static int32_t whole_side(const ty_ordinates_def* def, int axis) {
    return def->domain != NULL ? def->domain->cells[axis] : def->size[axis];
}

/* True if parts begin at pairs of cells. */
static bool cuts_between_pairs(const ty_ordinates_def* def) {
    for (int axis = 0; axis < 3 && def->domain != NULL; ++axis)
        if (ty_domain_is_cut(def->domain, axis) &&
            (def->domain->unit[axis] % 2 != 0 || def->domain->cells[axis] < MIN_SIDE))
            return false;
    return true;
}

static bool pays(const ty_ordinates_job* job) {
    const ty_ordinates_def* def = job->def;
    const int64_t cells = (int64_t)whole_side(def, 0) * whole_side(def, 1) * whole_side(def, 2);
    if (cells < MIN_CELLS || def->bands < BANDS || def->source_terms == 1 || !cuts_between_pairs(def)) return false;
    double against = def->walls.count > 0 || !is_thin(job) ? 1 : 0;
    ty_ordinates_sum_ranks(job, &against, 1);
    return against <= 0 && is_anisotropic(job);
}

/* ---- memory ---- */

static float* allocate(const coarse_box* coarse, ty_arena* arena) {
    return ty_arena_take(arena, sizeof(float) * coarse->cells);
}

static void lay_out(coarse_box* coarse, ty_arena* arena) {
    coarse->extinction = allocate(coarse, arena);
    coarse->scattering = allocate(coarse, arena);
    coarse->g = allocate(coarse, arena);
    for (int32_t t = 0; t < TERMS; ++t) coarse->source[t] = allocate(coarse, arena);
    for (int32_t t = 0; t < TERMS; ++t) coarse->moments[t] = allocate(coarse, arena);
    coarse->def.memory = ty_arena_take(arena, ty_ordinates_memory(&coarse->def));
}

/* Uses the memory of later fine iterates. Returns false if it is too small on some rank, as for boxes of a few cells
 * across. */
static bool reuse_memory(coarse_box* coarse) {
    const ty_ordinates_job* fine = coarse->fine;
    char *begin = (char*)fine->moments[1], *end = (char*)fine->changes[fine->depth - 1];
    ty_arena arena = {0};
    lay_out(coarse, &arena);
    double small = arena.used > (size_t)(end - begin) ? 1 : 0;
    ty_ordinates_sum_ranks(fine, &small, 1);
    if (small > 0) return false;
    arena = (ty_arena){.base = begin};
    lay_out(coarse, &arena);
    return true;
}

/* ---- restriction ---- */

/* Sums over the fine rows of a coarse row. weight: of fine cells; NULL: 1. */
static void sum_rows(const coarse_box* coarse, const float* from, const float* weight, int32_t y, int32_t z,
                     float* sum) {
    const int32_t *fine = coarse->fine->def->size, *ratio = coarse->ratio;
    memset(sum, 0, sizeof *sum * (size_t)(fine[0] + 1));
    for (int32_t k = z * ratio[2]; k < (z + 1) * ratio[2] && k < fine[2]; ++k)
        for (int32_t j = y * ratio[1]; j < (y + 1) * ratio[1] && j < fine[1]; ++j) {
            const size_t at = (size_t)fine[0] * ((size_t)j + (size_t)fine[1] * (size_t)k);
            for (size_t x = 0; x < (size_t)fine[0]; ++x)
                sum[x] += weight != NULL ? weight[at + x] * from[at + x] : from[at + x];
        }
}

/* Means over a row of coarse cells; the part of a coarse cell outside the box is vacuum. */
static void mean_row(const coarse_box* coarse, const float* from, const float* weight, int32_t y, int32_t z,
                     float* to) {
    const int32_t *ratio = coarse->ratio, width = coarse->def.size[0];
    const float scale = 1 / (float)(ratio[0] * ratio[1] * ratio[2]);
    float sum[TY_ORDINATES_SIDE_MAX + 1];
    sum_rows(coarse, from, weight, y, z, sum);
    for (int32_t x = 0; x < width; ++x) to[x] = scale * (ratio[0] == 2 ? sum[2 * x] + sum[2 * x + 1] : sum[x]);
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
            /* Rounding must not move means out of their ranges. */
            g[x] = scattering[x] > 0 ? ty_clampf(g[x] / scattering[x], -0.9999f, 0.9999f) : 0;
            scattering[x] = ty_minf(scattering[x], extinction[x]);
        }
        for (int32_t t = 0; t < TERMS; ++t) mean_row(coarse, def->source[t], NULL, y, plane, coarse->source[t] + at);
    }
}

/* ---- interpolation ---- */

/* The two coarse cells whose centers enclose the center of a fine cell, and their interpolation weights. */
typedef struct pair {
    int32_t at[2];
    float weight[2];
} pair;

static pair find_pair(int32_t index, int32_t ratio, int32_t size) {
    if (ratio == 1) return (pair){{index, index}, {1, 0}};
    const int32_t near = index / 2, adjacent = (index & 1) != 0 ? near + 1 : near - 1;
    return (pair){{near, adjacent < 0 || adjacent >= size ? near : adjacent}, {0.75f, 0.25f}};
}

/* Interpolates one coarse term across rows; the end cells are repeated on both sides. */
static void interpolate_rows(const coarse_box* coarse, const float* term, const pair* y, const pair* z, float* to) {
    const size_t width = (size_t)coarse->def.size[0], rows = (size_t)coarse->def.size[1];
    memset(to, 0, sizeof *to * (width + 2));
    for (int i = 0; i < 4; ++i) {
        const float weight = y->weight[i & 1] * z->weight[i >> 1];
        const float* from = term + width * ((size_t)y->at[i & 1] + rows * (size_t)z->at[i >> 1]);
        for (size_t x = 0; x < width; ++x) to[x + 1] += weight * from[x];
    }
    to[0] = to[1];
    to[width + 1] = to[width];
}

/* Interpolates one term along a row of fine cells. */
static void interpolate_row(const coarse_box* coarse, const float* row, int32_t term, float* to) {
    const int32_t terms = coarse->fine->terms, width = coarse->fine->def->size[0];
    if (coarse->ratio[0] == 1) {
        for (int32_t x = 0; x < width; ++x) to[x * terms + term] = row[x + 1];
        return;
    }
    for (int32_t x = 0; x < width; x += 2) {
        const float *here = row + x / 2 + 1, near = 0.75f * *here;
        to[x * terms + term] = near + 0.25f * here[-1];
        if (x + 1 < width) to[(x + 1) * terms + term] = near + 0.25f * here[1];
    }
}

static void interpolate_plane(void* user, int64_t z, int32_t worker) {
    (void)worker;
    const coarse_box* coarse = user;
    const ty_ordinates_job* fine = coarse->fine;
    const int32_t *size = fine->def->size, *from = coarse->def.size, *ratio = coarse->ratio;
    const size_t items = (size_t)fine->terms * (size_t)size[0];
    const pair weights_z = find_pair((int32_t)z, ratio[2], from[2]);
    float row[TY_ORDINATES_SIDE_MAX + 2];
    for (int32_t y = 0; y < size[1]; ++y) {
        const pair weights_y = find_pair(y, ratio[1], from[1]);
        float* to = fine->moments[0] + items * ((size_t)y + (size_t)size[1] * (size_t)z);
        memset(to, 0, sizeof *to * items);
        for (int32_t t = 0; t < TERMS; ++t) {
            interpolate_rows(coarse, coarse->moments[t], &weights_y, &weights_z, row);
            interpolate_row(coarse, row, t, to);
        }
    }
}

/* ---- solve ---- */

/* Progress of the coarse solve: the caller can cancel, the fraction stays 0. */
static bool report(void* user, const ty_progress* coarse_progress) {
    const ty_ordinates_job* job = user;
    ty_progress progress = *coarse_progress;
    progress.fraction = 0;
    progress.remaining = -1;
    return job->def->progress(job->def->progress_user, &progress);
}

/* Cells of a domain that are larger by a ratio along an axis; its boxes begin at multiples of that, if it is cut. */
static void coarsen_domain(ty_domain* domain, int axis, int32_t ratio) {
    domain->cells[axis] = (domain->cells[axis] + ratio - 1) / ratio;
    domain->first[axis] /= ratio;
    domain->end[axis] = (domain->end[axis] + ratio - 1) / ratio;
    domain->unit[axis] = domain->unit[axis] > ratio ? domain->unit[axis] / ratio : 1;
}

static bool define(coarse_box* coarse) {
    ty_ordinates_def* def = &coarse->def;
    *def = *coarse->fine->def;
    coarse->cells = 1;
    if (def->domain != NULL) {
        coarse->domain = *def->domain;
        coarse->domain.buffer = NULL;
        coarse->domain.capacity = 0;
        def->domain = &coarse->domain;
    }
    for (int a = 0; a < 3; ++a) {
        coarse->ratio[a] = whole_side(coarse->fine->def, a) >= MIN_SIDE ? 2 : 1;
        coarsen_domain(&coarse->domain, a, coarse->ratio[a]);
        def->size[a] = (def->size[a] + coarse->ratio[a] - 1) / coarse->ratio[a];
        def->cell[a] *= coarse->ratio[a];
        coarse->cells *= (size_t)def->size[a];
    }
    def->bands = def->output_order = BANDS;
    def->source_terms = TERMS;
    def->sweeps = SWEEPS;
    def->passing[0] = def->passing[1] = NULL;
    def->scattered = NULL;
    def->progress = def->progress != NULL ? report : NULL;
    def->progress_user = coarse->fine;
    if (!reuse_memory(coarse)) return false;
    def->extinction = coarse->extinction;
    def->scattering = coarse->scattering;
    def->g = coarse->g;
    def->source = (const float* const*)coarse->source;
    def->source_center = NULL;
    return true;
}

ty_result ty_ordinates_coarse_initial_guess(ty_ordinates_job* job) {
    coarse_box coarse = {.fine = job};
    if (!pays(job) || !define(&coarse)) return TY_OK;
    ty_parallel_flushed(job->context, coarse.def.size[2], mean_plane, &coarse);
    const ty_result result = ty_ordinates_solve(job->context, &coarse.def, coarse.moments, NULL, 0, NULL);
    ty_domain_destroy(&coarse.domain);
    if (result != TY_OK) return result;
    ty_ordinates_planes(job, interpolate_plane, &coarse);
    ty_ordinates_start(job);
    return TY_OK;
}
