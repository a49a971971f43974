/* Progress of work on many sources, with cancellation. */
#ifndef TY_DIRECT_UNCOLLIDED_PROGRESS_METER_H
#define TY_DIRECT_UNCOLLIDED_PROGRESS_METER_H

#include <tyndall/base.h>

typedef struct ty_progress_meter {
    ty_progress_fn progress; /* NULL: no reports */
    void* user;
    int32_t count, done; /* sources */
    double begun, reported;
} ty_progress_meter;

ty_progress_meter ty_progress_meter_begin(ty_progress_fn progress, void* user, int32_t count);
/* Reports progress if it is due; fraction_of_source: of the current source. Errors: TY_CANCELLED on the caller's
 * request. */
ty_result ty_progress_meter_report(ty_progress_meter* meter, double fraction_of_source);

#endif
