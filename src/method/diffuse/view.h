/* Source fields of diffuse light between surfaces, for one image. */
#ifndef TY_METHOD_DIFFUSE_VIEW_H
#define TY_METHOD_DIFFUSE_VIEW_H

#include "image/march/cuts.h"
#include "solve/diffusion/light/diffuse_light.h"

typedef struct ty_diffuse_view {
    ty_context* context;
    ty_source_field media;    /* light that media scatter */
    ty_source_field surfaces; /* light that surfaces receive */
    ty_cuts* cuts;            /* surfaces between the cells; NULL: none */
    /* Copies with the cells that surfaces hide from the eye filled; NULL without surfaces. */
    float *media_terms[3][TY_FIELD_TERMS], *surface_terms[3][TY_FIELD_TERMS];
    uint8_t* hidden;
    size_t cells;
} ty_diffuse_view;

/* Fields of a light for an eye; NULL: for all directions, with no cells filled. added (NULL: none): radiance per
 * channel that is added to the isotropic term for media; then no channels are shared. Errors: TY_ERROR_MEMORY. Freed
 * with ty_diffuse_view_free, also after an error. */
ty_result ty_diffuse_view_make(const ty_diffuse_light* light, const ty_scene* scene, const double* eye,
                               float* const* added, ty_diffuse_view* out);
void ty_diffuse_view_free(ty_diffuse_view* view);

#endif
