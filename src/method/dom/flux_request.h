/* A solve that fills in fluxes by columns, too. */
#ifndef TY_METHOD_DOM_FLUX_REQUEST_H
#define TY_METHOD_DOM_FLUX_REQUEST_H

#include "method/dom/job.h"
#include "method/flux_table.h"

struct ty_dom_flux_request {
    ty_flux* table;
    float* passing[3][2]; /* of ty_ordinates_def, for each channel that is solved for */
    size_t cells;
};

/* Before the channels are solved, and after it; without a request they do nothing. Errors: TY_ERROR_ARGUMENT,
 * TY_ERROR_MEMORY. */
ty_result ty_dom_flux_begin(ty_dom_job* job);
ty_result ty_dom_flux_fill(const ty_dom_job* job);

#endif
