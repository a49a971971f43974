/* Coarse images of methods that solve once and view often: their light and their size, such that the first image
 * follows a change within 100 ms on any machine. Both follow from what earlier ones took. */
#include "cli/view/live_state.h"

#include <math.h>
#include <string.h>

/* Times within which a coarse image is aimed to be there: of the change of the document and the solve, and of the view
 * with the surfaces. The rest of 100 ms is for the encoding and the way to the client. */
static const double light_seconds = 0.04;
const double view_coarse_seconds = 0.03;
/* Factor by which a view is slower than aimed for before a coarser light takes its place. */
static const double slow_view = 1.7;
/* A view with rays VIEW_COARSE_SPACING pixels apart takes at most this part of one with a ray per pixel. */
static const double spaced_part = 0.5;
/* Part that remains of a solve's time each time that a coarser one takes its place: the machine may be less busy. */
static const double fading = 0.97;
/* Largest factors by which an image's number of pixels changes from one to the next. */
static const double shrink_max = 4, grow_max = 2;
enum { COARSEST = 8, STEPS = 4 /* of the divisor, between whole numbers */ };

void view_coarse_forget(view_live* live) {
    live->view_seconds = live->surface_seconds = 0;
    memset(live->solve_seconds, 0, sizeof live->solve_seconds);
    memset(live->coarse_seconds, 0, sizeof live->coarse_seconds);
    memset(live->coarse_pixels, 0, sizeof live->coarse_pixels);
}

static bool is_slow_to_view(const view_live* live, ty_solve_quality quality) {
    return live->coarse_seconds[quality] > slow_view * view_coarse_seconds;
}

static bool is_quick_to_solve(const view_live* live, ty_solve_quality quality) {
    return live->solve_seconds[quality] + 1e-3 * live->times.load <= light_seconds;
}

/* The light to view: the full one, unless it takes long to solve or to view; else the better of the coarse ones that
 * does not. */
ty_solve_quality view_coarse_quality(view_live* live) {
    const bool full = !is_slow_to_view(live, TY_SOLVE_FULL);
    if (full && view_has_light(live, TY_SOLVE_FULL)) return TY_SOLVE_FULL;
    if (full && live->solve_seconds[TY_SOLVE_FULL] > 0 && is_quick_to_solve(live, TY_SOLVE_FULL)) return TY_SOLVE_FULL;
    const bool coarse = !is_slow_to_view(live, TY_SOLVE_COARSE);
    if (coarse && (view_has_light(live, TY_SOLVE_COARSE) || is_quick_to_solve(live, TY_SOLVE_COARSE)))
        return TY_SOLVE_COARSE;
    live->solve_seconds[TY_SOLVE_COARSE] *= fading;
    live->coarse_seconds[TY_SOLVE_COARSE] *= fading;
    return TY_SOLVE_COARSEST;
}

static double frame_pixels(const view_live* live) {
    return (double)live->width * live->height;
}

double view_coarse_divisor(const view_live* live, ty_solve_quality quality) {
    double pixels = live->coarse_pixels[quality];
    for (int q = 0; q < TY_SOLVE_QUALITIES && pixels <= 0; ++q) pixels = live->coarse_pixels[q];
    if (pixels <= 0 && live->view_seconds > 0)
        pixels = frame_pixels(live) * view_coarse_seconds / (spaced_part * live->view_seconds + live->surface_seconds);
    if (pixels <= 0) return STEPS;
    const double divisor = ceil(STEPS * sqrt(frame_pixels(live) / pixels) - 0.5) / STEPS;
    return fmax(1, fmin(divisor, COARSEST));
}

void view_coarse_note(view_live* live, ty_solve_quality quality, double pixels, double seconds) {
    double* known = &live->coarse_pixels[quality];
    const double surfaces = view_adds_surfaces(live) ? live->surface_seconds * pixels / frame_pixels(live) : 0;
    const double fitting = pixels * view_coarse_seconds / fmax(seconds + surfaces, 1e-4);
    live->coarse_seconds[quality] = seconds;
    *known = *known > 0 ? fmax(*known / shrink_max, fmin(sqrt(*known * fitting), *known * grow_max)) : fitting;
    *known = fmin(*known, 4 * frame_pixels(live));
}
