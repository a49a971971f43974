/* Iterations. Each mixes what there was so far, sweeps, and corrects what came out by diffusion of what it scatters
 * more than what went in (diffusion synthetic acceleration). The mixture is that whose change would be the least if
 * changes were linear (Anderson acceleration): the correction, on cells, is not quite that of diamond differences, and
 * where cells are thick, or light is scattered forward, iterations that just repeat it take long or grow. */
#include "base/context.h"
#include "solve/ordinates_job.h"

#include <math.h>

/* Between two reports, s. */
static const double REPORT_SECONDS = 0.1;
/* What a correction's solve leaves of its residual, and its cycles at most. */
static const double REDUCTION = 0.1;
enum { CYCLES = 4 };
/* What iterations are expected to leave of a change, at most. */
static const double SLOWEST = 0.999;
/* Changes whose part across others is less than this share of them tell nothing. */
static const double LEAST_PART = 1e-10;

typedef struct iteration {
    ty_ordinates_job* job;
    double products[TY_ORDINATES_DEPTH][TY_ORDINATES_DEPTH]; /* of changes */
    double change;                                           /* rms, relative; of the sweep before */
} iteration;

/* ---- mixing ---- */

/* Solves the symmetric n x n system a x = b by elimination from the last unknown on; unknowns that others make up for
 * are 0. */
static void solve_symmetric(double a[TY_ORDINATES_DEPTH][TY_ORDINATES_DEPTH], double* b, int32_t n, double* x) {
    bool known[TY_ORDINATES_DEPTH] = {false};
    double first[TY_ORDINATES_DEPTH];
    for (int32_t i = 0; i < n; ++i) first[i] = a[i][i];
    for (int32_t i = 0; i < n; ++i) {
        known[i] = a[i][i] > LEAST_PART * first[i];
        for (int32_t j = i + 1; known[i] && j < n; ++j) {
            const double factor = a[j][i] / a[i][i];
            for (int32_t k = i; k < n; ++k) a[j][k] -= factor * a[i][k];
            b[j] -= factor * b[i];
        }
    }
    for (int32_t i = n - 1; i >= 0; --i) {
        x[i] = 0;
        if (!known[i]) continue;
        double sum = b[i];
        for (int32_t j = i + 1; j < n; ++j) sum -= a[i][j] * x[j];
        x[i] = sum / a[i][i];
    }
}

/* Shares that make the least of the mixed change: the latest's, less x times its difference from each other's. */
static void mix(iteration* it) {
    ty_ordinates_job* job = it->job;
    const int32_t last = job->latest;
    double a[TY_ORDINATES_DEPTH][TY_ORDINATES_DEPTH], b[TY_ORDINATES_DEPTH], x[TY_ORDINATES_DEPTH];
    int32_t others[TY_ORDINATES_DEPTH] = {0}, n = 0;
    for (int32_t age = 1; age < job->count; ++age) others[n++] = (last + job->depth - age) % job->depth;
    for (int32_t i = 0; i < n; ++i) {
        const int32_t p = others[i];
        b[i] = it->products[last][last] - it->products[last][p];
        for (int32_t j = 0; j < n; ++j) {
            const int32_t q = others[j];
            a[i][j] = it->products[last][last] - it->products[last][p] - it->products[last][q] + it->products[p][q];
        }
    }
    solve_symmetric(a, b, n, x);
    job->shares[last] = 1;
    for (int32_t i = 0; i < n; ++i) {
        job->shares[others[i]] = x[i];
        job->shares[last] -= x[i];
    }
}

/* ---- sweeps ---- */

/* Where the next iterate goes: over the oldest, or over a start. */
static void make_room(ty_ordinates_job* job) {
    if (job->count == 0 || job->given) {
        job->given = false;
        job->count = 1;
        job->latest = 0;
        return;
    }
    if (job->count < job->depth) ++job->count;
    job->latest = (job->latest + 1) % job->depth;
}

static const float* correction(ty_ordinates_job* job) {
    if (job->correction == NULL) return NULL;
    const double squares = ty_ordinates_excess(job);
    return ty_correction_solve(job->correction, squares, REDUCTION, CYCLES);
}

static ty_result sweep(iteration* it) {
    ty_ordinates_job* job = it->job;
    ty_ordinates_emit(job);
    make_room(job);
    const double begun = ty_wall_seconds();
    const ty_result result =
        ty_sweep_run(job->sweep, job->emission, job->iterates[job->latest], &job->stats->leaving, NULL);
    job->stats->sweep_seconds += ty_wall_seconds() - begun;
    ++job->stats->sweeps;
    return result;
}

static ty_result report(ty_ordinates_job* job) {
    const double now = ty_wall_seconds(), change = job->stats->change;
    if (job->def->progress == NULL || now - job->reported < REPORT_SECONDS) return TY_OK;
    job->reported = now;
    /* Changes fall about geometrically. */
    const double done = change > 0 && change < 1 ? fmin(log(change) / log(job->def->tolerance), 1) : 0;
    const ty_progress progress = {.stage = "ordinates",
                                  .fraction = done,
                                  .seconds = now - job->start,
                                  .remaining = done > 0 ? (now - job->start) * (1 / done - 1) : -1};
    return job->def->progress(job->def->progress_user, &progress) ? TY_OK : TY_CANCELLED;
}

/* Estimates what is still to come: what changes so shrink to, added up. */
static void judge(iteration* it, const ty_ordinates_sums* sums) {
    ty_ordinates_job* job = it->job;
    ty_ordinates_stats* stats = job->stats;
    const double change = sums->fluence > 0 ? sqrt(sums->change / sums->fluence) : 0;
    const double rate = it->change > 0 ? fmin(change / it->change, SLOWEST) : SLOWEST;
    stats->change = change * rate / (1 - rate);
    stats->converged = stats->change <= job->def->tolerance;
    it->change = change;
    if (stats->sweeps <= job->history_capacity) job->history[stats->sweeps - 1] = stats->change;
}

ty_result ty_ordinates_iterate(ty_ordinates_job* job) {
    iteration it = {.job = job};
    const int32_t limit = job->def->sweeps > 0 ? job->def->sweeps : job->correction != NULL ? 100 : 10000;
    ty_result result = TY_OK;
    while (result == TY_OK && !job->stats->converged && job->stats->sweeps < limit) {
        result = sweep(&it);
        if (result != TY_OK) return result;
        const ty_ordinates_sums sums = ty_ordinates_correct(job, correction(job));
        for (int32_t i = 0; i < job->count; ++i)
            it.products[job->latest][i] = it.products[i][job->latest] = sums.products[i];
        judge(&it, &sums);
        mix(&it);
        result = report(job);
    }
    return result;
}
