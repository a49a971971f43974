#include "base/progress.h"

#include "base/context.h"

#include <math.h>

static const double report_interval = 0.02; /* s */
/* The fraction from which on the pace tells how long the rest takes. */
static const double min_fraction = 0.005;

bool ty_report_due(double* reported) {
    const double now = ty_wall_seconds();
    if (now - *reported < report_interval) return false;
    *reported = now;
    return true;
}

ty_progress ty_progress_at(const char* stage, double fraction, double seconds) {
    return (ty_progress){.stage = stage,
                         .fraction = fraction,
                         .seconds = seconds,
                         .remaining = fraction > min_fraction ? seconds * (1 - fraction) / fraction : -1};
}

ty_part_progress ty_part_begin(ty_progress_fn function, void* user, double from, double span) {
    return (ty_part_progress){
        .function = function, .user = user, .begun = ty_wall_seconds(), .from = from, .span = span};
}

ty_result ty_part_next(ty_part_progress* progress, const char* stage, double until) {
    progress->from += progress->span;
    progress->span = until - progress->from;
    progress->reported = 0;
    return ty_part_show(progress, stage, 0);
}

ty_result ty_part_show(ty_part_progress* progress, const char* stage, double fraction) {
    if (progress->function == NULL || !ty_report_due(&progress->reported)) return TY_OK;
    const ty_progress part = {.stage = stage, .fraction = fraction};
    return ty_part_report(progress, &part) ? TY_OK : TY_CANCELLED;
}

bool ty_part_report(void* user, const ty_progress* part) {
    ty_part_progress* progress = user;
    if (progress->function == NULL) return true;
    progress->reported = ty_wall_seconds();
    progress->shown = fmin(fmax(progress->shown, progress->from + progress->span * part->fraction), 1);
    const ty_progress whole = ty_progress_at(part->stage, progress->shown, progress->reported - progress->begun);
    return progress->function(progress->user, &whole);
}
