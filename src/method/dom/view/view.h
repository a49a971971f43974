/* Images of a solution. */
#ifndef TY_METHOD_DOM_VIEW_VIEW_H
#define TY_METHOD_DOM_VIEW_VIEW_H

#include "direct/single/source_field.h"
#include "image/march/cuts.h"
#include "method/dom/job.h"

/* Replaces the radiance of diffusive cells, per scattering coefficient, by that which their faces show the eye besides
 * what the lights scatter once, and marks these cells. */
void ty_dom_show_faces(const ty_dom* light, const ty_light_fluence* lights, const double eye[3],
                       float* const radiance[3], uint8_t* at_face);

/* Corrects the outgoing radiance for lateral spread, which the lights' lobes neglect. */
void ty_dom_correct_lobes(const ty_dom* light, const double eye[3], float* const radiance[3]);

/* Adjusts the flux of cells at boundary faces, in a channel's terms of a source field, so that their first two moments
 * give the faces' irradiance. */
void ty_dom_match_wall_irradiance(const ty_dom* light, int32_t channel, float* const terms[TY_FIELD_TERMS]);

/* Image of the scene's camera. Errors: TY_ERROR_ARGUMENT, TY_ERROR_MEMORY; TY_CANCELLED. */
ty_result ty_dom_march(ty_volume_call* call, ty_image** out);

/* The lights of a march, and how it reads the fields. */
void ty_dom_set_march(const ty_dom* light, ty_march_def* march);
/* The radiance that surfaces receive, as a source field: its terms are the arrays in incident, which the caller frees,
 * also after an error. hidden: as in ty_hidden_cells_fill. Errors: TY_ERROR_MEMORY. */
ty_result ty_dom_make_incident(const ty_dom* light, const uint8_t* hidden, float* incident[3][TY_FIELD_TERMS],
                               ty_source_field* surfaces);

#endif
