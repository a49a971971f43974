/* Checks of figures' numbers against their tolerances, and the list of known misses. */
#include "figures/judge.h"

#include <math.h>
#include <string.h>

#define LEAKS "The paper's earlier stages let bright near pixels leak onto far ones, which adds light."
#define MASKED "The paper's masks keep light of near pixels from spreading, and so take some away."
#define PICTURE_EDGE "Without masks light leaks at edges of depth and is lost beyond the picture's edge."

static const figure_known_miss misses[] = {
    {"screen-leaking", "naive", "energy ratio", LEAKS},
    {"screen-leaking", "step", "energy ratio", LEAKS},
    {"screen-leaking", "smoothstep", "energy ratio", LEAKS},
    {"screen-leaking", "luminance", "energy ratio", "Weights by luminance take light from highlights."},
    {"screen-leaking", "gather", "energy ratio", MASKED},
    {"screen-leaking", "published", "energy ratio", "Masks that are not normalised take light from highlights."},
    {"screen-thickness", "gather, thickness 2", "energy ratio", MASKED},
    {"screen-thickness", "gather, thickness 4", "energy ratio", MASKED},
    {"screen-thickness", "gather, thickness 6", "energy ratio", MASKED},
    {"screen-thickness", "gather, thickness 8", "energy ratio", MASKED},
    {"screen-thickness", "naive, thickness 2", "energy ratio", PICTURE_EDGE},
    {"screen-thickness", "naive, thickness 4", "energy ratio", PICTURE_EDGE},
    {"screen-thickness", "naive, thickness 8", "energy ratio", PICTURE_EDGE},
    {"pop-residuum", "isotropic residuum, εa = 0.1", "times faster",
     "The paper's four times are a graphics card's; 37 iterations in one grid instead of 1000 save more here."},
    {"pop-residuum", "isotropic residuum, εa = 0.02", "times faster",
     "The paper's four times are a graphics card's; 63 iterations in one grid instead of 1000 save more here."},
    {"pop-sphere", "g 0.5, split", "mean ratio of fluence",
     "Beside a point light the limiter of the residual's diffusion streams too little, and no one limit mends it."},
    {"bake-staircase", "staircase, all light", "relative RMSE",
     "Light in cells is smoother than the smoke, which varies from place to place."},
};
enum { MISSES = sizeof misses / sizeof misses[0] };

static bool is_of(const figure_known_miss* miss, const char* figure, const figure_quantity* q) {
    return strcmp(miss->figure, figure) == 0 && strcmp(miss->item, q->item) == 0 &&
           strcmp(miss->quantity, q->name) == 0;
}

static const figure_known_miss* find_miss(const char* figure, const figure_quantity* q) {
    for (int i = 0; i < MISSES; ++i)
        if (is_of(&misses[i], figure, q)) return &misses[i];
    return NULL;
}

/* "screen-leaking: naive: energy ratio is 1.017, and should be 1 within 0.01" */
static void describe(const char* figure, const figure_quantity* q, char out[512]) {
    char measured[32] = "missing";
    if (!isnan(q->measured)) snprintf(measured, sizeof measured, "%.4g", q->measured);
    snprintf(out, 512, "%s: %s: %s is %s, and should be %.4g within %.4g", figure, q->item, q->name, measured,
             q->expected, q->tolerance);
}

/* A known miss that is now within its tolerance, or whose number no longer exists. */
static void warn_of_stale(cli_session* session, const figure_outcome* outcome) {
    char text[640];
    for (int i = 0; i < MISSES; ++i) {
        const figure_quantity* found = NULL;
        if (strcmp(misses[i].figure, outcome->entry->name) != 0) continue;
        for (size_t q = 0; q < outcome->count; ++q)
            if (is_of(&misses[i], outcome->entry->name, &outcome->quantities[q])) found = &outcome->quantities[q];
        if (found != NULL && !figure_is_within(found)) continue;
        snprintf(text, sizeof text, "%s: %s: %s is listed as a known miss and %s", misses[i].figure, misses[i].item,
                 misses[i].quantity, found != NULL ? "is within its tolerance now" : "is not there");
        cli_progress_warn(&session->progress, text);
    }
}

/* True of an error of which nothing remains without the noise (bench_without_noise). Any other number that is missing
 * is a miss. */
static bool is_below_noise(const figure_quantity* q) {
    return isnan(q->measured) && q->expected == 0;
}

size_t figure_judge(cli_session* session, const figure_outcome* outcome) {
    const char* figure = outcome->entry->name;
    const bool verbose = !session->common.quiet;
    size_t unknown = 0;
    if (!outcome->own_settings) return 0;
    cli_progress_clear(&session->progress);
    for (size_t i = 0; i < outcome->count; ++i) {
        const figure_quantity* q = &outcome->quantities[i];
        char text[512];
        if (isnan(q->expected) || isnan(q->tolerance) || is_below_noise(q) || figure_is_within(q)) continue;
        const figure_known_miss* miss = find_miss(figure, q);
        describe(figure, q, text);
        if (miss == NULL) {
            cli_fail(CLI_FAILED, "%s", text);
            ++unknown;
        } else if (verbose) {
            printf("known miss: %s. %s\n", text, miss->reason);
        }
    }
    if (verbose) warn_of_stale(session, outcome);
    return unknown;
}
