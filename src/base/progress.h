/* Reports of progress: at most fifty a second, and those of a part of the work as fractions of the whole. */
#ifndef TY_BASE_PROGRESS_H
#define TY_BASE_PROGRESS_H

#include <tyndall/base.h>

/* True once a fiftieth of a second has passed since *reported (s of ty_wall_seconds), which then becomes the present.
 */
bool ty_report_due(double* reported);
/* The report of a fraction that took so many seconds, with the time that remains at the same pace. */
ty_progress ty_progress_at(const char* stage, double fraction, double seconds);

typedef struct ty_part_progress {
    ty_progress_fn function; /* the caller's; may be NULL */
    void* user;
    double begun;      /* s */
    double reported;   /* s: time of the last report */
    double from, span; /* of the whole work */
    double shown;      /* the largest fraction that was reported */
} ty_part_progress;

/* For work that begins now and is from..from + span of the caller's. */
ty_part_progress ty_part_begin(ty_progress_fn function, void* user, double from, double span);
/* Goes on to the next part, up to the fraction `until` of the whole, and reports it. Errors: TY_CANCELLED. */
ty_result ty_part_next(ty_part_progress* progress, const char* stage, double until);
/* Reports a fraction of this part, if a report is due. Errors: TY_CANCELLED. */
ty_result ty_part_show(ty_part_progress* progress, const char* stage, double fraction);
/* A ty_progress_fn whose user is a ty_part_progress. Fractions that it reports never fall: parts that begin again (each
 * fluence of a light), and errors that grow between iterations, stay at what was reported. */
bool ty_part_report(void* user, const ty_progress* part);

#endif
