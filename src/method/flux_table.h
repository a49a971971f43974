/* Tables of fluxes by columns, which methods fill in. */
#ifndef TY_METHOD_FLUX_TABLE_H
#define TY_METHOD_FLUX_TABLE_H

#include "scene/scene.h"

#include <tyndall/flux.h>

/* Quantities of a level: the first of ty_flux_quantity. */
enum { TY_FLUX_LEVEL_QUANTITIES = TY_FLUX_DOWN_DIRECT + 1 };

struct ty_flux {
    ty_context* context;
    ty_flux_def def;          /* levels and views are those below */
    double* levels;           /* def.level_count */
    ty_flux_view* views;      /* def.view_count */
    double *values, *errors;  /* quantities x columns x 3, the quantities of all levels, then absorption, then the
                                 radiance of all views */
    int64_t columns, numbers; /* columns, and numbers of all quantities */
};

/* Errors: TY_ERROR_ARGUMENT. */
ty_result ty_flux_check(ty_context* context, const ty_flux_def* def);
/* Sets the corners of all columns where a def has none. Errors: TY_ERROR_ARGUMENT. */
ty_result ty_flux_place_columns(const ty_scene* scene, ty_flux_def* def);
/* A table of zeros. Errors: TY_ERROR_MEMORY. */
ty_result ty_flux_create(ty_context* context, const ty_flux_def* def, ty_flux** out);

#endif
