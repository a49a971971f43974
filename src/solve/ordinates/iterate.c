/* Iterations. Each mixes what there was so far, sweeps, and corrects what came out by diffusion of what it scatters
 * more than what went in (ordinates_correct.c). The mixture is that whose change would be the least if changes were
 * linear (Anderson acceleration): diffusion knows nothing of what light scattered forward does, and little of vacuum.
 */
#include "base/context.h"
#include "solve/ordinates/job.h"

#include <math.h>

/* Between two reports, s. */
static const double REPORT_SECONDS = 0.1;
/* Cycles of multigrid in a correction, whose solve sweeps and mixtures go on with. What iterations start from is solved
 * until this share of the residual is left, or for so many. */
enum { CYCLES = 1, FIRST_CYCLES = 12 };
static const double FIRST_REDUCTION = 3e-3;
/* Bounds of what sweeps are expected to leave of a change. */
static const double SLOWEST = 0.9999, CORRECTED_SLOWEST = 0.9, CORRECTED_FASTEST = 0.5;
/* Changes whose part across others is less than this share of them tell nothing. */
static const double LEAST_PART = 1e-10;
/* Sweeps in a row that find no smaller change before it is clear that there will be none: what rounding does, and
 * keeping radiance from falling below 0, are corrected as if they were changes. */
enum { PATIENCE = 12 };

#define SQRT_4PI 3.5449077018110318

typedef double matrix[TY_ANDERSON_DEPTH][TY_ANDERSON_DEPTH];

/* Sweeps that a rate is measured over: with corrections changes do not fall evenly, without they may be next to
 * nothing, and rounding theirs. */
enum { SPAN = 8, CORRECTED_SPAN = 2 };

typedef struct iteration {
    ty_ordinates_job* job;
    matrix products;      /* of changes */
    double changes[SPAN]; /* rms, relative; of the last sweeps */
    double least;         /* of all so far */
    int32_t futile;       /* sweeps since then */
} iteration;

/* ---- mixing ---- */

/* Solves a symmetric system; unknowns that others make up for are 0. */
static void solve_symmetric(matrix a, double* b, int32_t n, double* x) {
    bool known[TY_ANDERSON_DEPTH] = {false};
    double first[TY_ANDERSON_DEPTH];
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
static void mix(const iteration* it) {
    ty_ordinates_job* job = it->job;
    const int32_t last = job->latest;
    const double* own = it->products[last];
    matrix a;
    double b[TY_ANDERSON_DEPTH], x[TY_ANDERSON_DEPTH];
    int32_t others[TY_ANDERSON_DEPTH] = {0}, n = 0;
    for (int32_t i = 0; i < job->count; ++i)
        if (i != last) others[n++] = i;
    for (int32_t i = 0; i < n; ++i) {
        b[i] = own[last] - own[others[i]];
        for (int32_t j = 0; j < n; ++j)
            a[i][j] = own[last] - own[others[i]] - own[others[j]] + it->products[others[i]][others[j]];
    }
    solve_symmetric(a, b, n, x);
    job->shares[last] = 1;
    for (int32_t i = 0; i < n; ++i) {
        job->shares[others[i]] = x[i];
        job->shares[last] -= x[i];
    }
}

/* ---- sweeps ---- */

/* NULL: there is none. */
static const float* correction(ty_ordinates_job* job, bool first) {
    if (job->correction == NULL) return NULL;
    const double squares = ty_ordinates_residual(job, first);
    ty_dsa_solve(job->correction, squares, first ? FIRST_REDUCTION : 0, first ? FIRST_CYCLES : CYCLES);
    job->leaving[job->latest] += SQRT_4PI * ty_dsa_leakage(job->correction);
    return ty_dsa_fluence(job->correction);
}

static void begin_with_first(ty_ordinates_job* job) {
    job->shares[0] = 1;
    job->count = 1;
    job->given = true;
}

void ty_ordinates_start(ty_ordinates_job* job) {
    job->latest = 0;
    ty_ordinates_gather_low_order(job);
    begin_with_first(job);
}

void ty_ordinates_diffusion_initial_guess(ty_ordinates_job* job) {
    job->latest = 0;
    ty_ordinates_correct(job, correction(job, true));
    begin_with_first(job);
}

/* Where the next iterate goes: over a start, or over the one that changed the most. */
static void make_room(const iteration* it) {
    ty_ordinates_job* job = it->job;
    if (job->given) job->count = 0;
    job->given = false;
    if (job->count < job->depth) {
        job->latest = job->count++;
        return;
    }
    job->latest = 0;
    for (int32_t i = 1; i < job->count; ++i)
        if (it->products[i][i] > it->products[job->latest][job->latest]) job->latest = i;
}

/* What rounding took from the light or gave it, alike in most cells: next to nothing, but light that scatters ten
 * thousand times meets it as often. emitted, taken: sums over cells, W/m^3 / sqrt(4 pi); arrived: on walls, W. */
static void account(ty_ordinates_job* job, double emitted, double arrived, double taken) {
    const double volume = job->def->cell[0] * job->def->cell[1] * job->def->cell[2];
    const double left = (job->leaving[job->latest] + arrived) / (volume * SQRT_4PI);
    job->missing = taken > 0 ? (emitted - left) / taken - 1 : 0;
}

static ty_result sweep(const iteration* it) {
    ty_ordinates_job* job = it->job;
    const double emitted = ty_ordinates_emit(job);
    make_room(it);
    ty_ordinates_set_sweep_faces(job, job->sweep, job->latest);
    const double begun = ty_wall_seconds();
    const ty_result result =
        ty_sweep_run(job->sweep, job->emission, job->moments[job->latest], &job->leaving[job->latest], NULL);
    job->stats->sweep_seconds += ty_wall_seconds() - begun;
    ++job->stats->sweeps;
    const double skins = ty_ordinates_diffusive_receive(job), arrived = skins + ty_ordinates_faces_receive(job);
    account(job, emitted, arrived, ty_ordinates_gather_low_order(job));
    job->leaving[job->latest] += ty_ordinates_diffusive_leakage(job);
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

/* What a sweep leaves of a change. */
static double rate_of(const iteration* it, double change) {
    const ty_ordinates_job* job = it->job;
    const int32_t before = job->stats->sweeps - 1, longest = job->correction != NULL ? CORRECTED_SPAN : SPAN;
    const int32_t span = before < longest ? before : longest;
    if (span == 0) return SLOWEST;
    const double first = it->changes[(before - span) % SPAN];
    const double rate = first > 0 ? fmin(pow(change / first, 1.0 / span), SLOWEST) : SLOWEST;
    return job->correction != NULL ? fmin(fmax(rate, CORRECTED_FASTEST), CORRECTED_SLOWEST) : rate;
}

/* Of the energy, what is amiss: in thick media little of the light leaves, and little of it is much of what does. */
static double imbalance(const ty_ordinates_job* job, const ty_ordinates_sums* sums) {
    if (job->thick.count == 0 || !(job->emitted > 0)) return 0;
    const double volume = job->def->cell[0] * job->def->cell[1] * job->def->cell[2] * SQRT_4PI;
    return fabs((job->leaving[job->latest] + volume * sums->absorbed) / job->emitted - 1);
}

/* Estimates what is still to come: what changes so shrink to, added up. */
static void judge(iteration* it, const ty_ordinates_sums* sums) {
    ty_ordinates_stats* stats = it->job->stats;
    const double change = sums->change > 0 ? sqrt(sums->change / sums->fluence) : 0, rate = rate_of(it, change);
    stats->change = fmax(change * rate / (1 - rate), imbalance(it->job, sums));
    stats->converged = stats->change <= it->job->def->tolerance;
    it->futile = change < it->least ? 0 : it->futile + 1;
    it->least = fmin(it->least, change);
    it->changes[(stats->sweeps - 1) % SPAN] = change;
    if (stats->sweeps <= it->job->history_capacity) it->job->history[stats->sweeps - 1] = stats->change;
}

/* Of iterations that found no end: what changed the least. */
static void take_best(const iteration* it) {
    ty_ordinates_job* job = it->job;
    for (int32_t i = 0; i < job->count; ++i)
        if (it->products[i][i] < it->products[job->latest][job->latest]) job->latest = i;
    for (int32_t i = 0; i < job->count; ++i) job->shares[i] = i == job->latest ? 1 : 0;
}

static bool goes_on(const iteration* it) {
    const ty_ordinates_def* def = it->job->def;
    const int32_t limit = def->sweeps > 0 ? def->sweeps : it->job->correction != NULL ? 100 : 10000;
    const bool hopeless = it->job->correction != NULL && it->futile >= PATIENCE;
    return !it->job->stats->converged && it->job->stats->sweeps < limit && !hopeless;
}

ty_result ty_ordinates_iterate(ty_ordinates_job* job) {
    iteration it = {.job = job, .least = INFINITY};
    ty_result result = TY_OK;
    while (result == TY_OK && goes_on(&it)) {
        result = sweep(&it);
        if (result != TY_OK) return result;
        const ty_ordinates_sums sums = ty_ordinates_correct(job, correction(job, false));
        for (int32_t i = 0; i < job->count; ++i)
            it.products[job->latest][i] = it.products[i][job->latest] = sums.products[i];
        judge(&it, &sums);
        mix(&it);
        result = report(job);
    }
    if (!job->stats->converged && !job->given) take_best(&it);
    return result;
}
