/* Progress of work in parts, told as parts of the whole. */
#ifndef TY_BASE_PROGRESS_H
#define TY_BASE_PROGRESS_H

#include <tyndall/base.h>

typedef struct ty_part_progress {
    ty_progress_fn function; /* the caller's; may be NULL */
    void* user;
    double begun;       /* s */
    double reported;    /* s: when the caller was last told */
    double from, share; /* of the whole work */
} ty_part_progress;

/* For work that begins now and is from..from + share of the caller's. */
ty_part_progress ty_part_begin(ty_progress_fn function, void* user, double from, double share);
/* Goes on to the next part, up to the fraction `until` of the whole, and tells the caller. Errors: TY_CANCELLED. */
ty_result ty_part_next(ty_part_progress* progress, const char* stage, double until);
/* Tells the caller where this part begins, unless it was told of anything just now. Errors: TY_CANCELLED. */
ty_result ty_part_show(ty_part_progress* progress, const char* stage);
/* A ty_progress_fn whose user is a ty_part_progress. */
bool ty_part_report(void* user, const ty_progress* part);

#endif
