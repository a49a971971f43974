/* Making tables: fluence of every bounce first, from which radiance of the next follows at every bin. */
#include "base/parallel.h"
#include "base/progress.h"
#include "method/impulse/build.h"

/* Light comes back from so far behind the last bin. */
static const double behind = 20; /* mean free paths */

enum { PARTS = 16 }; /* of a step, after each of which it can be cancelled */

bool ty_impulse_around(const ty_impulse_work* work, double distance, int32_t* first, double weight[4]) {
    const double place = fmax(0, ty_impulse_place(work->tables, distance));
    if (place > work->places - 1) return false;
    const double from = fmin(work->places - 4, fmax(0, floor(place) - 1));
    const double x = place - from; /* among 0, 1, 2, 3 */
    *first = (int32_t)from;
    weight[0] = -(x - 1) * (x - 2) * (x - 3) / 6;
    weight[1] = x * (x - 2) * (x - 3) / 2;
    weight[2] = -x * (x - 1) * (x - 3) / 2;
    weight[3] = x * (x - 1) * (x - 2) / 6;
    return true;
}

void ty_impulse_add_radii(const ty_impulse_work* work, double distance, ty_impulse_nodes* out) {
    enum { SINGULAR = 32 };
    const double near = 1.5, step = 3, last = work->distances[work->places - 1]; /* mean free paths */
    if (distance <= 2 * near) {
        ty_impulse_add_singular(out, 0, distance, SINGULAR);
    } else {
        const double from = distance - near;
        ty_impulse_add_singular(out, 0, near, SINGULAR);
        const int32_t panels = (int32_t)ceil((from - near) / step);
        for (int32_t i = 0; i < panels; ++i)
            ty_impulse_add_gauss(out, near + (from - near) * i / panels, near + (from - near) * (i + 1) / panels);
        ty_impulse_add_singular(out, from, distance, SINGULAR);
    }
    const double beyond = distance + fmin(distance, near);
    ty_impulse_add_singular(out, distance, fmin(beyond, last), SINGULAR);
    if (beyond < last) ty_impulse_add_logarithmic(out, beyond, last);
}

void ty_impulse_keep(const ty_impulse_work* work, ty_impulse_emitter emitter, int32_t angle, int32_t bin,
                     int32_t vector, const double zonal[TY_IMPULSE_TERMS]) {
    float* out = ty_impulse_row(work->tables, emitter, angle, bin) + vector * TY_IMPULSE_VECTOR;
    const double scale = ty_impulse_scale(emitter, vector < TY_IMPULSE_PHASES, work->distances[bin]);
    for (int32_t l = 0; l < TY_IMPULSE_TERMS; ++l) out[l] = (float)(scale * zonal[l]);
}

/* ---- memory ---- */

/* Numbers of spread and sink, fluence, depth, products. */
typedef struct sizes {
    size_t spread, sink, fluence, depth, products, singles;
} sizes;

static sizes sizes_of(const ty_impulse_work* work) {
    const size_t places = (size_t)work->places, bounces = (size_t)work->tables->bounces;
    return (sizes){.spread = places * TY_IMPULSE_ORDERS * places,
                   .sink = places * TY_IMPULSE_TERMS * places,
                   .fluence = bounces * TY_IMPULSE_ORDERS * places,
                   .depth = bounces * places,
                   .products = (size_t)ty_context_threads(work->tables->context) * bounces * TY_IMPULSE_PRODUCTS,
                   .singles = (size_t)TY_IMPULSE_DISTANCES * TY_IMPULSE_PHASES};
}

static double* take(const ty_impulse_work* work, size_t count) {
    return ty_alloc_array(work->tables->context, count, sizeof(double), true);
}

static void put_back(const ty_impulse_work* work, double* numbers, size_t count) {
    ty_free_array(work->tables->context, numbers, count, sizeof(double));
}

static void finish(ty_impulse_work* work) {
    const sizes s = sizes_of(work);
    ty_impulse_free_lattice(work);
    ty_free_array(work->tables->context, work->singles, s.singles, sizeof *work->singles);
    put_back(work, work->products, s.products);
    put_back(work, work->depth, s.depth);
    put_back(work, work->fluence, s.fluence);
    put_back(work, work->sink, s.sink);
    put_back(work, work->spread, s.spread);
    put_back(work, work->distances, (size_t)work->places);
}

static ty_result prepare(ty_impulse_work* work) {
    work->places = (int32_t)ceil(ty_impulse_place(work->tables, work->tables->range + behind)) + 1;
    const sizes s = sizes_of(work);
    work->distances = take(work, (size_t)work->places);
    work->spread = take(work, s.spread);
    work->sink = take(work, s.sink);
    work->fluence = take(work, s.fluence);
    work->depth = take(work, s.depth);
    work->products = take(work, s.products);
    work->singles = ty_alloc_array(work->tables->context, s.singles, sizeof *work->singles, true);
    if (work->distances == NULL || work->spread == NULL || work->sink == NULL || work->fluence == NULL ||
        work->depth == NULL || work->products == NULL || work->singles == NULL)
        return TY_ERROR_MEMORY;
    for (int32_t i = 0; i < work->places; ++i) work->distances[i] = ty_impulse_distance(work->tables, i);
    ty_impulse_make_recurrence(&work->recurrence);
    for (int32_t i = 0; i < TY_IMPULSE_ANGLES; ++i) {
        const double cosine = (double)ty_impulse_cosines[i];
        ty_impulse_legendre_sent(&work->recurrence, cosine, sqrt(1 - cosine * cosine), work->angles[i]);
    }
    return ty_impulse_make_lattice(work);
}

/* ---- steps ---- */

/* Indices from..from + count of a loop. */
typedef struct part {
    ty_parallel_fn body;
    void* user;
    int64_t from;
} part;

static void run_index(void* user, int64_t index, int32_t worker) {
    const part* p = user;
    p->body(p->user, p->from + index, worker);
}

/* A loop that takes the next share of the whole, and can be cancelled. */
static ty_result run(ty_impulse_work* work, ty_parallel_fn body, int64_t count, double share,
                     ty_part_progress* progress) {
    progress->share = share;
    for (int64_t i = 0; i < PARTS; ++i) {
        part p = {body, work, count * i / PARTS};
        ty_parallel_flushed(work->tables->context, count * (i + 1) / PARTS - p.from, run_index, &p);
        const ty_progress done = {.stage = "impulse", .fraction = (double)(i + 1) / PARTS};
        if (!ty_part_report(progress, &done)) return TY_CANCELLED;
    }
    progress->from += share;
    return TY_OK;
}

/* Each bounce's fluence from that of the one before. */
static void bounce(ty_impulse_work* work) {
    const int32_t places = work->places;
    for (int32_t b = 1; b + 1 < work->tables->bounces; ++b)
        for (int32_t i = 0; i < places; ++i) {
            const double* spread = work->spread + (size_t)i * TY_IMPULSE_ORDERS * (size_t)places;
            const double* sink = work->sink + (size_t)i * TY_IMPULSE_TERMS * (size_t)places;
            double sum = 0;
            for (int32_t j = 0; j < places; ++j) sum += sink[j] * ty_impulse_depth(work, b)[j];
            ty_impulse_depth(work, b + 1)[i] = sqrt(4 * TY_PI_F64) * sum;
            for (int32_t k = 0; k < TY_IMPULSE_ORDERS; ++k, spread += places) {
                const double* fluence = ty_impulse_fluence(work, b, k);
                sum = 0;
                for (int32_t j = 0; j < places; ++j) sum += spread[j] * fluence[j];
                ty_impulse_fluence(work, b + 1, k)[i] = sum;
            }
        }
}

static ty_result build(ty_impulse_work* work, ty_part_progress* progress) {
    const int64_t blocks = (work->places + TY_IMPULSE_BLOCK - 1) / TY_IMPULSE_BLOCK;
    const int64_t bins = TY_IMPULSE_DISTANCES;
    ty_result result = run(work, ty_impulse_scatter_once, blocks, 0.3, progress);
    if (result == TY_OK) result = run(work, ty_impulse_sink_once, work->places, 0.01, progress);
    if (result == TY_OK) result = run(work, ty_impulse_make_spread, work->places, 0.1, progress);
    if (result == TY_OK) result = run(work, ty_impulse_make_sink, work->places, 0.05, progress);
    if (result == TY_OK) bounce(work);
    if (result == TY_OK) result = run(work, ty_impulse_sink_again, bins, 0.01, progress);
    if (result == TY_OK) result = run(work, ty_impulse_scatter_again, bins, 0.53, progress);
    return result;
}

ty_result ty_impulse_build(ty_impulse* tables, const ty_impulse_def* def) {
    ty_impulse_work* work = ty_alloc_array(tables->context, 1, sizeof *work, true);
    if (work == NULL) return TY_ERROR_MEMORY;
    work->tables = tables;
    ty_part_progress progress = ty_part_begin(def->progress, def->progress_user, 0, 0);
    ty_result result = prepare(work);
    if (result == TY_OK) result = build(work, &progress);
    finish(work);
    ty_free_array(tables->context, work, 1, sizeof *work);
    return result;
}
