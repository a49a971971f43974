/* Seams: the least-squares change of texels that makes bilinear lookups on both sides of an edge equal. Rows of A are
 * lookups on one side minus lookups on the other, at points along all seams; (A'A + P) d = -A'A x is solved for the
 * change d of light x by conjugate gradients, with weak regularisation P towards the original texels. */
#include "base/context.h"
#include "bake/atlas/atlas.h"

#include <math.h>
#include <string.h>

/* Regularisation weights of valid texels and of padding texels, which hold no light of their own. */
static const float regularisation_valid = 2e-3f;
static const float regularisation_padding = 2e-4f;
/* Sample points along seams, per texel. */
enum { POINTS_PER_TEXEL = 2 };
/* Maps with millions of points get fewer iterations: the remaining error is small by then. */
enum { ITERATIONS = 200, ITERATIONS_MIN = 30 };
static const double iterations_times_rows = 2e8;
static const double tolerance = 2e-4;
/* Minimum bilinear weight inside the chart; points with less are skipped. */
static const double min_weight = 0.25;

enum { TAPS = 8, LANES = 8, GROUPS = TY_ATLAS_PLANES / LANES };
_Static_assert(TY_ATLAS_PLANES % LANES == 0, "planes are closed in groups");

typedef struct row {
    int32_t index[TAPS]; /* indices of unknowns; weight 0: unused */
    float weight[TAPS];
} row;

typedef struct seam_solver {
    const ty_atlas* atlas;
    const int32_t* source;
    float* const* planes;
    int32_t* unknown; /* per texel: index of its unknown; -1: none */
    int32_t* texels;  /* per unknown */
    size_t count, capacity;
    row* rows;
    size_t row_count, row_capacity;
    float* scratch;        /* per worker: VECTORS * LANES * count */
    float* regularisation; /* per unknown */
    float* inverse;        /* per unknown: 1 / the matrix' diagonal */
} seam_solver;

enum { X, CHANGE, RESIDUAL, SEARCH, APPLIED, VECTORS };

static bool belongs(const seam_solver* work, size_t texel, int32_t chart) {
    const int32_t source = work->source[texel];
    return source >= 0 && work->atlas->charts[work->atlas->receiver[source]] == chart;
}

/* The texels of a bilinear lookup that belong to a chart, with weights normalised to sign; false: too little weight. */
static bool look_up(const seam_solver* work, const double at[2], int32_t chart, float sign, int32_t texels[4],
                    float weights[4]) {
    const int32_t width = work->atlas->width, height = work->atlas->height;
    const int32_t x = (int32_t)floor(at[0] - 0.5), y = (int32_t)floor(at[1] - 0.5);
    const double right = at[0] - 0.5 - x, below = at[1] - 0.5 - y;
    double bilinear[4], sum = 0;
    for (int tap = 0; tap < 4; ++tap) {
        const int32_t column = x + tap % 2, line = y + tap / 2;
        const size_t clamped_x = (size_t)(column < 0 ? 0 : column >= width ? width - 1 : column);
        const size_t clamped_y = (size_t)(line < 0 ? 0 : line >= height ? height - 1 : line);
        texels[tap] = (int32_t)(clamped_y * (size_t)width + clamped_x);
        bilinear[tap] = (tap % 2 == 1 ? right : 1 - right) * (tap / 2 == 1 ? below : 1 - below);
        if (!belongs(work, (size_t)texels[tap], chart)) bilinear[tap] = 0;
        sum += bilinear[tap];
    }
    for (int tap = 0; tap < 4 && sum > 0; ++tap) weights[tap] = sign * (float)(bilinear[tap] / sum);
    return sum >= min_weight;
}

/* Index of a texel among the unknowns; -1: out of memory. */
static int32_t number_of(seam_solver* work, int32_t texel) {
    if (work->unknown[texel] >= 0) return work->unknown[texel];
    if (!ty_grow_array(work->atlas->context, (void**)&work->texels, &work->capacity, work->count, sizeof *work->texels))
        return -1;
    work->texels[work->count] = texel;
    return work->unknown[texel] = (int32_t)work->count++;
}

static bool add_row(seam_solver* work, const ty_seam* seam, double t) {
    row added = {{0}, {0}};
    int32_t texels[TAPS];
    for (int side = 0; side < 2; ++side) {
        double at[2];
        for (int axis = 0; axis < 2; ++axis)
            at[axis] = (1 - t) * (double)seam->from[side][axis] + t * (double)seam->to[side][axis];
        if (!look_up(work, at, seam->chart[side], side == 0 ? 1.0f : -1.0f, texels + 4 * side, added.weight + 4 * side))
            return true;
    }
    if (!ty_grow_array(work->atlas->context, (void**)&work->rows, &work->row_capacity, work->row_count,
                       sizeof *work->rows))
        return false;
    for (int tap = 0; tap < TAPS; ++tap) {
        if (added.weight[tap] == 0) continue;
        added.index[tap] = number_of(work, texels[tap]);
        if (added.index[tap] < 0) return false;
    }
    work->rows[work->row_count++] = added;
    return true;
}

static bool add_seam(seam_solver* work, const ty_seam* seam) {
    double length = 0;
    for (int side = 0; side < 2; ++side)
        length = fmax(length, hypot((double)(seam->to[side][0] - seam->from[side][0]),
                                    (double)(seam->to[side][1] - seam->from[side][1])));
    const int32_t points = (int32_t)ceil(POINTS_PER_TEXEL * length);
    for (int32_t i = 0; i <= points; ++i)
        if (!add_row(work, seam, points == 0 ? 0.5 : (double)i / points)) return false;
    return true;
}

/* ---- conjugate gradients ---- */

/* Planes are solved side by side: each unknown has LANES values. */

/* out = A'A in, plus pull * in if pulled; product: dot product of in and out. */
static void apply(const seam_solver* work, const float* in, bool regularised, float* out, double product[LANES]) {
    for (size_t i = 0; i < work->count; ++i)
        for (size_t lane = 0; lane < LANES; ++lane)
            out[LANES * i + lane] = regularised ? work->regularisation[i] * in[LANES * i + lane] : 0.0f;
    for (size_t r = 0; r < work->row_count; ++r) {
        const row* at = &work->rows[r];
        float sum[LANES] = {0};
        for (int tap = 0; tap < TAPS; ++tap) {
            const float* from = in + LANES * (size_t)at->index[tap];
            for (int lane = 0; lane < LANES; ++lane) sum[lane] += at->weight[tap] * from[lane];
        }
        for (int tap = 0; tap < TAPS; ++tap) {
            float* to = out + LANES * (size_t)at->index[tap];
            for (int lane = 0; lane < LANES; ++lane) to[lane] += at->weight[tap] * sum[lane];
        }
    }
    for (int lane = 0; lane < LANES; ++lane) product[lane] = 0;
    for (size_t i = 0; i < work->count; ++i)
        for (size_t lane = 0; lane < LANES; ++lane)
            product[lane] += (double)(in[LANES * i + lane] * out[LANES * i + lane]);
}

static void preconditioned(const seam_solver* work, const float* residual, double product[LANES]) {
    for (int lane = 0; lane < LANES; ++lane) product[lane] = 0;
    for (size_t i = 0; i < work->count; ++i)
        for (size_t lane = 0; lane < LANES; ++lane)
            product[lane] += (double)(residual[LANES * i + lane] * residual[LANES * i + lane] * work->inverse[i]);
}

/* Zero denominators mean that a lane has converged. */
static float ratio(double a, double b) {
    return b > 0 ? (float)(a / b) : 0.0f;
}

static bool any_above(const double a[LANES], const double b[LANES]) {
    bool any = false;
    for (int lane = 0; lane < LANES; ++lane) any |= a[lane] > b[lane];
    return any;
}

/* Solves for the change of the texels of LANES planes. */
static void solve(const seam_solver* work, float* const vectors[VECTORS]) {
    float *change = vectors[CHANGE], *residual = vectors[RESIDUAL], *search = vectors[SEARCH];
    const size_t n = work->count;
    double residual_norm[LANES], curvature[LANES], next[LANES], target[LANES];
    const int iterations = (int)fmin(fmax(iterations_times_rows / (double)work->row_count, ITERATIONS_MIN), ITERATIONS);
    apply(work, vectors[X], false, residual, residual_norm);
    for (size_t i = 0; i < LANES * n; ++i) {
        residual[i] = -residual[i];
        change[i] = 0;
        search[i] = work->inverse[i / LANES] * residual[i];
    }
    preconditioned(work, residual, residual_norm);
    for (int lane = 0; lane < LANES; ++lane) target[lane] = tolerance * tolerance * residual_norm[lane];
    for (int iteration = 0; iteration < iterations && any_above(residual_norm, target); ++iteration) {
        float step[LANES], beta[LANES];
        apply(work, search, true, vectors[APPLIED], curvature);
        for (int lane = 0; lane < LANES; ++lane) step[lane] = ratio(residual_norm[lane], curvature[lane]);
        for (size_t i = 0; i < n; ++i)
            for (size_t lane = 0; lane < LANES; ++lane) {
                change[LANES * i + lane] += step[lane] * search[LANES * i + lane];
                residual[LANES * i + lane] -= step[lane] * vectors[APPLIED][LANES * i + lane];
            }
        preconditioned(work, residual, next);
        for (int lane = 0; lane < LANES; ++lane) {
            beta[lane] = ratio(next[lane], residual_norm[lane]);
            residual_norm[lane] = next[lane];
        }
        for (size_t i = 0; i < n; ++i)
            for (size_t lane = 0; lane < LANES; ++lane)
                search[LANES * i + lane] =
                    work->inverse[i] * residual[LANES * i + lane] + beta[lane] * search[LANES * i + lane];
    }
}

/* Irradiance and fluence are clamped to 0; vector irradiance is signed. */
static float clamped(int plane, float light) {
    const bool directed = plane >= TY_ATLAS_VECTOR_IRRADIANCE && plane < TY_ATLAS_FLUENCE;
    return directed || light > 0 ? light : 0.0f;
}

static void close_planes(void* user, int64_t index, int32_t worker) {
    const seam_solver* work = user;
    float* const* planes = work->planes + LANES * index;
    float* vectors[VECTORS];
    for (int i = 0; i < VECTORS; ++i)
        vectors[i] = work->scratch + ((size_t)worker * VECTORS + (size_t)i) * LANES * work->count;
    for (size_t i = 0; i < work->count; ++i)
        for (size_t lane = 0; lane < LANES; ++lane)
            vectors[X][LANES * i + lane] = planes[lane][work->source[work->texels[i]]];
    solve(work, vectors);
    for (size_t i = 0; i < work->count; ++i)
        for (size_t lane = 0; lane < LANES; ++lane)
            planes[lane][work->texels[i]] = clamped((int)(LANES * index) + (int)lane,
                                                    vectors[X][LANES * i + lane] + vectors[CHANGE][LANES * i + lane]);
}

static void find_diagonal(seam_solver* work) {
    for (size_t i = 0; i < work->count; ++i) {
        work->regularisation[i] =
            work->atlas->receiver[work->texels[i]] >= 0 ? regularisation_valid : regularisation_padding;
        work->inverse[i] = work->regularisation[i];
    }
    for (size_t r = 0; r < work->row_count; ++r)
        for (int tap = 0; tap < TAPS; ++tap)
            work->inverse[work->rows[r].index[tap]] += work->rows[r].weight[tap] * work->rows[r].weight[tap];
    for (size_t i = 0; i < work->count; ++i) work->inverse[i] = 1.0f / work->inverse[i];
}

static bool close_all(seam_solver* work) {
    ty_context* context = work->atlas->context;
    const int32_t threads = ty_context_threads(context);
    const size_t workers = (size_t)(threads < GROUPS ? threads : GROUPS);
    const size_t scratch = workers * VECTORS * LANES * work->count;
    work->scratch = ty_alloc_array(context, scratch, sizeof *work->scratch, false);
    work->regularisation = ty_alloc_array(context, work->count, sizeof *work->regularisation, false);
    work->inverse = ty_alloc_array(context, work->count, sizeof *work->inverse, false);
    const bool ready = work->scratch != NULL && work->regularisation != NULL && work->inverse != NULL;
    if (ready) {
        find_diagonal(work);
        ty_parallel_for(context, GROUPS, close_planes, work);
    }
    ty_free_array(context, work->scratch, scratch, sizeof *work->scratch);
    ty_free_array(context, work->regularisation, work->count, sizeof *work->regularisation);
    ty_free_array(context, work->inverse, work->count, sizeof *work->inverse);
    return ready;
}

ty_result ty_atlas_close_seams(const ty_atlas* atlas, int32_t* source, float* const planes[TY_ATLAS_PLANES]) {
    if (atlas->seam_count == 0) return TY_OK;
    const size_t texels = ty_atlas_texels(atlas);
    seam_solver work = {.atlas = atlas, .source = source, .planes = planes};
    work.unknown = ty_alloc_array(atlas->context, texels, sizeof *work.unknown, false);
    bool success = work.unknown != NULL;
    if (success) memset(work.unknown, 0xff, texels * sizeof *work.unknown);
    for (size_t i = 0; i < atlas->seam_count && success; ++i) success = add_seam(&work, &atlas->seams[i]);
    if (success && work.count > 0) success = close_all(&work);
    for (size_t i = 0; i < work.count && success; ++i) source[work.texels[i]] = work.texels[i];
    ty_free_array(atlas->context, work.unknown, texels, sizeof *work.unknown);
    ty_free_array(atlas->context, work.texels, work.capacity, sizeof *work.texels);
    ty_free_array(atlas->context, work.rows, work.row_capacity, sizeof *work.rows);
    return success ? TY_OK : TY_ERROR_MEMORY;
}
