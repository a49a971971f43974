/* Anderson-accelerated iteration. Each step forms a mixed iterate, sweeps it and corrects the result by DSA
 * (dsa_source.c). The Anderson weights minimise the change of the mixed iterate under the assumption that changes are
 * linear: diffusion cannot correct errors of forward-peaked scattering, and little of those in vacuum. */
#include "base/constants.h"
#include "base/context.h"
#include "base/progress.h"
#include "solve/ordinates/job.h"

#include <math.h>

/* Multigrid cycles per DSA solve, whose remaining error the following sweeps and Anderson steps remove. The initial
 * guess is solved to this reduction of the residual, or for at most FIRST_CYCLES. */
enum { CYCLES = 1, FIRST_CYCLES = 12 };
static const double FIRST_REDUCTION = 3e-3;
/* Bounds of the convergence factor of a sweep. */
static const double MAX_RATE = 0.9999, DSA_MAX_RATE = 0.9, DSA_MIN_RATE = 0.5;
/* Changes whose component orthogonal to the others is smaller than this, relative and squared, are treated as linearly
 * dependent. */
static const double MIN_INDEPENDENT = 1e-10;
/* Sweeps without a smaller change after which the iteration counts as stagnating: rounding errors and the set-to-zero
 * fix-up are then corrected as if they were changes. */
enum { MAX_STAGNATION = 12 };

typedef double matrix[TY_ANDERSON_DEPTH][TY_ANDERSON_DEPTH];

/* Number of sweeps for measuring the convergence factor: accelerated changes decrease irregularly, unaccelerated ones
 * can be so small that rounding dominates their ratio. */
enum { SPAN = 8, DSA_SPAN = 2 };

typedef struct iteration {
    ty_ordinates_job* job;
    matrix products;      /* inner products of changes */
    double changes[SPAN]; /* relative rms changes of the last sweeps */
    double min_change;    /* smallest change so far */
    int32_t stagnation;   /* sweeps since the smallest change */
} iteration;

/* ---- Anderson acceleration ---- */

/* Solves a symmetric positive semidefinite system; linearly dependent unknowns are set to 0. */
static void solve_symmetric(matrix a, double* b, int32_t n, double* x) {
    bool independent[TY_ANDERSON_DEPTH] = {false};
    double diagonal[TY_ANDERSON_DEPTH];
    for (int32_t i = 0; i < n; ++i) diagonal[i] = a[i][i];
    for (int32_t i = 0; i < n; ++i) {
        independent[i] = a[i][i] > MIN_INDEPENDENT * diagonal[i];
        for (int32_t j = i + 1; independent[i] && j < n; ++j) {
            const double factor = a[j][i] / a[i][i];
            for (int32_t k = i; k < n; ++k) a[j][k] -= factor * a[i][k];
            b[j] -= factor * b[i];
        }
    }
    for (int32_t i = n - 1; i >= 0; --i) {
        x[i] = 0;
        if (!independent[i]) continue;
        double sum = b[i];
        for (int32_t j = i + 1; j < n; ++j) sum -= a[i][j] * x[j];
        x[i] = sum / a[i][i];
    }
}

/* Weights that minimise the norm of the mixed change c_last - sum_i x_i (c_last - c_i). */
static void update_anderson_weights(const iteration* it) {
    ty_ordinates_job* job = it->job;
    const int32_t last = job->latest;
    const double* with_latest = it->products[last];
    matrix a;
    double b[TY_ANDERSON_DEPTH], x[TY_ANDERSON_DEPTH];
    int32_t others[TY_ANDERSON_DEPTH] = {0}, n = 0;
    for (int32_t i = 0; i < job->count; ++i)
        if (i != last) others[n++] = i;
    for (int32_t i = 0; i < n; ++i) {
        b[i] = with_latest[last] - with_latest[others[i]];
        for (int32_t j = 0; j < n; ++j)
            a[i][j] = with_latest[last] - with_latest[others[i]] - with_latest[others[j]] +
                      it->products[others[i]][others[j]];
    }
    solve_symmetric(a, b, n, x);
    job->anderson_weights[last] = 1;
    for (int32_t i = 0; i < n; ++i) {
        job->anderson_weights[others[i]] = x[i];
        job->anderson_weights[last] -= x[i];
    }
}

/* ---- sweeps ---- */

/* NULL: no correction. */
static const float* solve_dsa(ty_ordinates_job* job, bool first) {
    if (job->dsa == NULL) return NULL;
    const double squares = ty_ordinates_residual(job, first);
    ty_dsa_solve(job->dsa, squares, first ? FIRST_REDUCTION : 0, first ? FIRST_CYCLES : CYCLES);
    job->leaving[job->latest] += TY_SQRT_4PI_F64 * ty_dsa_leakage(job->dsa);
    return ty_dsa_fluence(job->dsa);
}

static void begin_from_guess(ty_ordinates_job* job) {
    job->anderson_weights[0] = 1;
    job->count = 1;
    job->from_guess = true;
}

void ty_ordinates_start(ty_ordinates_job* job) {
    job->latest = 0;
    ty_ordinates_gather_low_order(job);
    begin_from_guess(job);
}

void ty_ordinates_diffusion_initial_guess(ty_ordinates_job* job) {
    job->latest = 0;
    ty_ordinates_correct(job, solve_dsa(job, true));
    begin_from_guess(job);
}

/* Selects the slot of the next iterate: replaces the initial guess, or the iterate with the largest change. */
static void select_slot(const iteration* it) {
    ty_ordinates_job* job = it->job;
    if (job->from_guess) job->count = 0;
    job->from_guess = false;
    if (job->count < job->depth) {
        job->latest = job->count++;
        return;
    }
    job->latest = 0;
    for (int32_t i = 1; i < job->count; ++i)
        if (it->products[i][i] > it->products[job->latest][job->latest]) job->latest = i;
}

/* Relative loss of energy by rounding, uniform over most cells: negligible per sweep, but it accumulates over ten
 * thousand scattering orders. emitted, removed: sums over cells, W/m^3 / sqrt(4 pi); incident: on faces, W. */
static void measure_energy_deficit(ty_ordinates_job* job, double emitted, double incident, double removed) {
    if (job->def->closed != NULL) return; /* an adjoint has no energy */
    const double volume = job->def->cell[0] * job->def->cell[1] * job->def->cell[2];
    const double outgoing = (job->leaving[job->latest] + incident) / (volume * TY_SQRT_4PI_F64);
    job->energy_deficit = removed > 0 ? (emitted - outgoing) / removed - 1 : 0;
}

static ty_result sweep(const iteration* it) {
    ty_ordinates_job* job = it->job;
    const double emitted = ty_ordinates_emit(job);
    if (job->def->periodic != 0) ty_ordinates_images_emit(job, job->sweep);
    select_slot(it);
    ty_ordinates_set_sweep_faces(job, job->sweep, job->latest);
    const double started = ty_wall_seconds();
    const ty_result result =
        ty_sweep_run(job->sweep, job->emission, job->moments[job->latest], &job->leaving[job->latest], NULL);
    job->stats->sweep_seconds += ty_wall_seconds() - started;
    ++job->stats->sweeps;
    const double interfaces = ty_ordinates_diffusive_receive(job),
                 incident = interfaces + ty_ordinates_faces_receive(job) + ty_ordinates_images_receive(job);
    const double removed = ty_ordinates_gather_low_order(job), leakage = ty_ordinates_diffusive_leakage(job);
    double sums[5] = {emitted, job->leaving[job->latest], incident, removed, leakage};
    ty_ordinates_sum_ranks(job, sums, 5);
    job->leaving[job->latest] = sums[1];
    measure_energy_deficit(job, sums[0], sums[2], sums[3]);
    job->leaving[job->latest] += sums[4];
    return result;
}

static bool goes_on(ty_ordinates_job* job) {
    const double change = job->stats->change;
    if (job->def->progress == NULL || !ty_report_due(&job->reported)) return true;
    /* Changes decrease about geometrically. */
    const double done = change > 0 && change < 1 ? fmin(log(change) / log(job->def->tolerance), 1) : 0;
    const ty_progress progress = ty_progress_at("ordinates", done, job->reported - job->start);
    return job->def->progress(job->def->progress_user, &progress);
}

/* One rank that is cancelled cancels all. */
static ty_result report(ty_ordinates_job* job) {
    double cancelled = goes_on(job) ? 0 : 1;
    ty_ordinates_sum_ranks(job, &cancelled, 1);
    return cancelled > 0 ? TY_CANCELLED : ty_ordinates_check_ranks(job);
}

/* Convergence factor of a sweep. */
static double rate_of(const iteration* it, double change) {
    const ty_ordinates_job* job = it->job;
    const int32_t available = job->stats->sweeps - 1, longest = job->dsa != NULL ? DSA_SPAN : SPAN;
    const int32_t span = available < longest ? available : longest;
    if (span == 0) return MAX_RATE;
    const double first = it->changes[(available - span) % SPAN];
    const double rate = first > 0 ? fmin(pow(change / first, 1.0 / span), MAX_RATE) : MAX_RATE;
    return job->dsa != NULL ? fmin(fmax(rate, DSA_MIN_RATE), DSA_MAX_RATE) : rate;
}

/* Relative energy imbalance: in optically thick media little light leaves, so that a small error of the fluence is a
 * large one of the leakage. */
static double imbalance(const ty_ordinates_job* job, const ty_ordinates_sums* sums) {
    if (job->diffusive.count == 0 || !(job->emitted > 0)) return 0;
    const double volume = job->def->cell[0] * job->def->cell[1] * job->def->cell[2] * TY_SQRT_4PI_F64;
    return fabs((job->leaving[job->latest] + volume * sums->absorbed) / job->emitted - 1);
}

/* Estimates the remaining error as the sum of a geometric series of changes. */
static void estimate_convergence(iteration* it, const ty_ordinates_sums* sums) {
    ty_ordinates_stats* stats = it->job->stats;
    const double change = sums->change > 0 ? sqrt(sums->change / sums->fluence) : 0, rate = rate_of(it, change);
    stats->change = fmax(change * rate / (1 - rate), imbalance(it->job, sums));
    stats->converged = stats->change <= it->job->def->tolerance;
    it->stagnation = change < it->min_change ? 0 : it->stagnation + 1;
    it->min_change = fmin(it->min_change, change);
    it->changes[(stats->sweeps - 1) % SPAN] = change;
    if (stats->sweeps <= it->job->history_capacity) it->job->history[stats->sweeps - 1] = stats->change;
}

/* Selects the iterate with the smallest change after an iteration without convergence. */
static void select_best(const iteration* it) {
    ty_ordinates_job* job = it->job;
    for (int32_t i = 0; i < job->count; ++i)
        if (it->products[i][i] < it->products[job->latest][job->latest]) job->latest = i;
    for (int32_t i = 0; i < job->count; ++i) job->anderson_weights[i] = i == job->latest ? 1 : 0;
}

static bool continues(const iteration* it) {
    const ty_ordinates_def* def = it->job->def;
    const int32_t limit = def->sweeps > 0 ? def->sweeps : it->job->dsa != NULL ? 100 : 10000;
    const bool stagnating = it->job->dsa != NULL && it->stagnation >= MAX_STAGNATION;
    return !it->job->stats->converged && it->job->stats->sweeps < limit && !stagnating;
}

ty_result ty_ordinates_iterate(ty_ordinates_job* job) {
    iteration it = {.job = job, .min_change = INFINITY};
    ty_result result = TY_OK;
    while (result == TY_OK && continues(&it)) {
        result = sweep(&it);
        if (result != TY_OK) return result;
        const ty_ordinates_sums sums = ty_ordinates_correct(job, solve_dsa(job, false));
        for (int32_t i = 0; i < job->count; ++i)
            it.products[job->latest][i] = it.products[i][job->latest] = sums.products[i];
        estimate_convergence(&it, &sums);
        update_anderson_weights(&it);
        result = report(job);
    }
    if (!job->stats->converged && !job->from_guess) select_best(&it);
    return result;
}
