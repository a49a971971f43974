/* Requests to the marcher's kernels, and the memory that they point into. */
#ifndef TY_IMAGE_REQUEST_H
#define TY_IMAGE_REQUEST_H

#include "image/march/kernel.h"

/* Cells of a field in the layout of ty_upsample_view. */
typedef struct ty_packed_cells {
    float* floats;
    size_t count;
} ty_packed_cells;

typedef struct ty_packed_request {
    ty_context* context;
    ty_march_request request;
    ty_packed_cells cells, surface_cells; /* of the fields */
} ty_packed_request;

/* The request of a checked def. Errors: TY_ERROR_ARGUMENT (the scene is not committed), TY_ERROR_MEMORY. Freed with
 * ty_march_request_free, also after an error. */
ty_result ty_march_request_make(const ty_scene* scene, const ty_march_def* def, ty_packed_request* out);
void ty_march_request_free(ty_packed_request* packed);

bool ty_march_has_froxels(const ty_march_def* def);
/* True where pixels march rays of their own, all of one origin: then irradiance may be gathered at points. */
bool ty_march_gathers(const ty_march_def* def, const ty_march_request* request);
/* True where pixels at edges may have more rays than others. */
bool ty_march_has_edges(const ty_march_def* def);

#endif
