/* Images of a solution. */
#ifndef TY_METHOD_DOM_VIEW_VIEW_H
#define TY_METHOD_DOM_VIEW_VIEW_H

#include "direct/single/source_field.h"
#include "image/cuts.h"
#include "method/dom/job.h"

/* Corrects the outgoing radiance for lateral spread, which the lights' lobes neglect. */
void ty_dom_correct_lobes(const ty_dom* light, const double eye[3], float* const radiance[3]);

/* State of cells that surfaces hide from an eye; NULL without boundary faces. The caller frees one byte per cell.
 * Errors: TY_ERROR_MEMORY. */
ty_result ty_dom_find_hidden(const ty_dom* light, const ty_scene* scene, const double eye[3], uint8_t** hidden);
/* Fills hidden cells of a plane from visible neighbours. cuts (NULL: none): surfaces that must not lie between them, as
 * interpolation respects these itself. A NULL hidden does nothing. */
void ty_dom_fill_hidden(const ty_dom* light, const ty_cuts* cuts, const uint8_t* hidden, float* plane);

/* Adjusts the flux of cells at boundary faces, in a channel's terms of a source field, so that their first two moments
 * give the faces' irradiance. */
void ty_dom_match_wall_irradiance(const ty_dom* light, int32_t channel, float* const terms[TY_FIELD_TERMS]);

/* Image of the scene's camera. Errors: TY_ERROR_ARGUMENT, TY_ERROR_MEMORY; TY_CANCELLED. */
ty_result ty_dom_march(ty_volume_call* call, ty_image** out);

#endif
