#include "base/progress.h"

#include "base/context.h"

static const double report_interval = 0.1; /* s */

ty_part_progress ty_part_begin(ty_progress_fn function, void* user, double from, double share) {
    return (ty_part_progress){
        .function = function, .user = user, .begun = ty_wall_seconds(), .from = from, .share = share};
}

ty_result ty_part_next(ty_part_progress* progress, const char* stage, double until) {
    progress->from += progress->share;
    progress->share = until - progress->from;
    progress->reported = 0;
    return ty_part_show(progress, stage);
}

ty_result ty_part_show(ty_part_progress* progress, const char* stage) {
    if (ty_wall_seconds() - progress->reported < report_interval) return TY_OK;
    const ty_progress begun = {.stage = stage};
    return ty_part_report(progress, &begun) ? TY_OK : TY_CANCELLED;
}

bool ty_part_report(void* user, const ty_progress* part) {
    ty_part_progress* progress = user;
    if (progress->function == NULL) return true;
    progress->reported = ty_wall_seconds();
    ty_progress whole = {.stage = part->stage, .seconds = progress->reported - progress->begun};
    whole.fraction = progress->from + progress->share * part->fraction;
    whole.remaining = whole.fraction > 0.02 ? whole.seconds * (1 - whole.fraction) / whole.fraction : -1;
    return progress->function(progress->user, &whole);
}
