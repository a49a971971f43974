/* Progress of work on many sources, and the caller's word to stop it. */
#ifndef TY_DIRECT_UNCOLLIDED_PROGRESS_METER_H
#define TY_DIRECT_UNCOLLIDED_PROGRESS_METER_H

#include <tyndall/base.h>

typedef struct ty_progress_meter {
    ty_progress_fn progress; /* NULL: nobody asks */
    void* user;
    int32_t count, done; /* sources */
    double begun, reported;
} ty_progress_meter;

ty_progress_meter ty_progress_meter_begin(ty_progress_fn progress, void* user, int32_t count);
/* Tells how far things are, if it is time to; part: of the source at work. TY_CANCELLED when the caller wishes. */
ty_result ty_progress_meter_report(ty_progress_meter* meter, double fraction);

#endif
