/* Progress reports at most ten times a second. */
#include "direct/uncollided/progress_meter.h"

#include "base/context.h"

static const double report_interval = 0.1;

ty_progress_meter ty_progress_meter_begin(ty_progress_fn progress, void* user, int32_t count) {
    const double now = ty_wall_seconds();
    return (ty_progress_meter){.progress = progress, .user = user, .count = count, .begun = now, .reported = now};
}

ty_result ty_progress_meter_report(ty_progress_meter* meter, double fraction_of_source) {
    if (meter->progress == NULL) return TY_OK;
    const double now = ty_wall_seconds(), seconds = now - meter->begun;
    if (now - meter->reported < report_interval) return TY_OK;
    meter->reported = now;
    const double fraction = (meter->done + fraction_of_source) / meter->count;
    const ty_progress progress = {
        .stage = "direct light",
        .fraction = fraction,
        .seconds = seconds,
        .remaining = fraction > 0.005 ? seconds * (1 - fraction) / fraction : -1,
    };
    return meter->progress(meter->user, &progress) ? TY_OK : TY_CANCELLED;
}
