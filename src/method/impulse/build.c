/* Construction of the tables: the fluence of every bounce first, then the radiance of the next bounce from it at every
 * bin. */
#include "base/parallel.h"
#include "base/progress.h"
#include "method/impulse/build.h"

/* Distance beyond the last bin from which light still returns. */
static const double return_distance = 20; /* mean free paths */

enum { STEPS = 16 }; /* progress steps per loop; cancellation is checked after each */

bool ty_impulse_cubic_weights(const ty_impulse_work* work, double distance, int32_t* first, double weight[4]) {
    const double position = fmax(0, ty_impulse_bin_position(work->tables, distance));
    if (position > work->distance_count - 1) return false;
    const double from = fmin(work->distance_count - 4, fmax(0, floor(position) - 1));
    const double x = position - from; /* relative to nodes 0, 1, 2, 3 */
    *first = (int32_t)from;
    weight[0] = -(x - 1) * (x - 2) * (x - 3) / 6;
    weight[1] = x * (x - 2) * (x - 3) / 2;
    weight[2] = -x * (x - 1) * (x - 3) / 2;
    weight[3] = x * (x - 1) * (x - 2) / 6;
    return true;
}

void ty_impulse_add_radii(const ty_impulse_work* work, double distance, ty_impulse_nodes* out) {
    enum { SINGULAR = 32 };
    const double near = 1.5, step = 3, last = work->distances[work->distance_count - 1]; /* mean free paths */
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

void ty_impulse_store(const ty_impulse_work* work, ty_impulse_emitter emitter, int32_t angle, int32_t bin,
                      int32_t vector, const double zonal[TY_IMPULSE_TERMS]) {
    float* out = ty_impulse_row(work->tables, emitter, angle, bin) + vector * TY_IMPULSE_VECTOR;
    const double scale = ty_impulse_scale(emitter, vector < TY_IMPULSE_PHASES, work->distances[bin]);
    for (int32_t l = 0; l < TY_IMPULSE_TERMS; ++l) out[l] = (float)(scale * zonal[l]);
}

/* ---- memory ---- */

/* Element counts of the work arrays. */
typedef struct sizes {
    size_t fluence_operator, half_space_operator, fluence, half_space_fluence, products, singles;
} sizes;

static sizes sizes_of(const ty_impulse_work* work) {
    const size_t count = (size_t)work->distance_count, bounces = (size_t)work->tables->bounces;
    return (sizes){.fluence_operator = count * TY_IMPULSE_ORDERS * count,
                   .half_space_operator = count * TY_IMPULSE_TERMS * count,
                   .fluence = bounces * TY_IMPULSE_ORDERS * count,
                   .half_space_fluence = bounces * count,
                   .products = (size_t)ty_context_threads(work->tables->context) * bounces * TY_IMPULSE_PRODUCTS,
                   .singles = (size_t)TY_IMPULSE_DISTANCES * TY_IMPULSE_PHASES};
}

static double* allocate(const ty_impulse_work* work, size_t count) {
    return ty_alloc_array(work->tables->context, count, sizeof(double), true);
}

static void release(const ty_impulse_work* work, double* numbers, size_t count) {
    ty_free_array(work->tables->context, numbers, count, sizeof(double));
}

static void finish(ty_impulse_work* work) {
    const sizes s = sizes_of(work);
    ty_impulse_free_lattice(work);
    ty_free_array(work->tables->context, work->singles, s.singles, sizeof *work->singles);
    release(work, work->products, s.products);
    release(work, work->half_space_fluence, s.half_space_fluence);
    release(work, work->fluence, s.fluence);
    release(work, work->half_space_operator, s.half_space_operator);
    release(work, work->fluence_operator, s.fluence_operator);
    release(work, work->distances, (size_t)work->distance_count);
}

static ty_result prepare(ty_impulse_work* work) {
    work->distance_count =
        (int32_t)ceil(ty_impulse_bin_position(work->tables, work->tables->range + return_distance)) + 1;
    const sizes s = sizes_of(work);
    work->distances = allocate(work, (size_t)work->distance_count);
    work->fluence_operator = allocate(work, s.fluence_operator);
    work->half_space_operator = allocate(work, s.half_space_operator);
    work->fluence = allocate(work, s.fluence);
    work->half_space_fluence = allocate(work, s.half_space_fluence);
    work->products = allocate(work, s.products);
    work->singles = ty_alloc_array(work->tables->context, s.singles, sizeof *work->singles, true);
    if (work->distances == NULL || work->fluence_operator == NULL || work->half_space_operator == NULL ||
        work->fluence == NULL || work->half_space_fluence == NULL || work->products == NULL || work->singles == NULL)
        return TY_ERROR_MEMORY;
    for (int32_t i = 0; i < work->distance_count; ++i) work->distances[i] = ty_impulse_distance(work->tables, i);
    ty_impulse_make_recurrence(&work->recurrence);
    for (int32_t i = 0; i < TY_IMPULSE_ANGLES; ++i) {
        const double cosine = (double)ty_impulse_cosines[i];
        ty_impulse_legendre_emitted(&work->recurrence, cosine, sqrt(1 - cosine * cosine), work->angles[i]);
    }
    return ty_impulse_make_lattice(work);
}

/* ---- steps ---- */

/* Iterations from..from + count of a loop. */
typedef struct loop_range {
    ty_parallel_fn body;
    void* user;
    int64_t from;
} loop_range;

static void run_index(void* user, int64_t index, int32_t worker) {
    const loop_range* p = user;
    p->body(p->user, p->from + index, worker);
}

/* Runs a loop as the next fraction of the progress, with cancellation. */
static ty_result run(ty_impulse_work* work, ty_parallel_fn body, int64_t count, double fraction,
                     ty_part_progress* progress) {
    progress->span = fraction;
    for (int64_t i = 0; i < STEPS; ++i) {
        loop_range p = {body, work, count * i / STEPS};
        ty_parallel_flushed(work->tables->context, count * (i + 1) / STEPS - p.from, run_index, &p);
        const ty_progress done = {.stage = "impulse", .fraction = (double)(i + 1) / STEPS};
        if (!ty_part_report(progress, &done)) return TY_CANCELLED;
    }
    progress->from += fraction;
    return TY_OK;
}

/* The fluence of each bounce from that of the previous one. */
static void bounce(ty_impulse_work* work) {
    const int32_t count = work->distance_count;
    for (int32_t b = 1; b + 1 < work->tables->bounces; ++b)
        for (int32_t i = 0; i < count; ++i) {
            const double* fluence_operator = work->fluence_operator + (size_t)i * TY_IMPULSE_ORDERS * (size_t)count;
            const double* half_space_operator =
                work->half_space_operator + (size_t)i * TY_IMPULSE_TERMS * (size_t)count;
            double sum = 0;
            for (int32_t j = 0; j < count; ++j)
                sum += half_space_operator[j] * ty_impulse_half_space_fluence(work, b)[j];
            ty_impulse_half_space_fluence(work, b + 1)[i] = ty_impulse_zonal_norm(0) * sum;
            for (int32_t k = 0; k < TY_IMPULSE_ORDERS; ++k, fluence_operator += count) {
                const double* fluence = ty_impulse_fluence(work, b, k);
                sum = 0;
                for (int32_t j = 0; j < count; ++j) sum += fluence_operator[j] * fluence[j];
                ty_impulse_fluence(work, b + 1, k)[i] = sum;
            }
        }
}

static ty_result build(ty_impulse_work* work, ty_part_progress* progress) {
    const int64_t blocks = (work->distance_count + TY_IMPULSE_BLOCK - 1) / TY_IMPULSE_BLOCK;
    const int64_t bins = TY_IMPULSE_DISTANCES;
    ty_result result = run(work, ty_impulse_single_scattering, blocks, 0.3, progress);
    if (result == TY_OK) result = run(work, ty_impulse_half_space_single, work->distance_count, 0.01, progress);
    if (result == TY_OK) result = run(work, ty_impulse_make_fluence_operator, work->distance_count, 0.1, progress);
    if (result == TY_OK) result = run(work, ty_impulse_make_half_space_operator, work->distance_count, 0.05, progress);
    if (result == TY_OK) bounce(work);
    if (result == TY_OK) result = run(work, ty_impulse_half_space_multiple, bins, 0.01, progress);
    if (result == TY_OK) result = run(work, ty_impulse_multiple_scattering, bins, 0.53, progress);
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
