/* Seeing a solve's light. */
#ifndef TY_METHOD_DOM_VIEW_VIEW_H
#define TY_METHOD_DOM_VIEW_VIEW_H

#include "direct/single/source_field.h"
#include "image/cuts.h"
#include "method/dom/job.h"

/* The unit vector from a cell's middle to the eye. */
void ty_dom_direction_to_eye(const ty_dom* light, const int32_t cell[3], const double eye[3], double way[3]);
/* Adds to what cells send to the eye what lights' lobes, which know nothing of light that moves sideways, are off by.
 */
void ty_dom_correct_lobes(const ty_dom* light, const double eye[3], float* const seen[3]);

/* What parts of lights without fields of their own are turned into for the eye, as fluence that scatters evenly would
 * be, and their fluence itself; either times the same colors. channels: 1: of all together, 3. Errors:
 * TY_ERROR_MEMORY. */
ty_result ty_dom_evaluate_clusters(const ty_dom* light, const double eye[3], int32_t channels, float* const sent[3],
                                   float* const all[3]);

/* Which cells surfaces hide from an eye; NULL where there are no walls. Freed with ty_free_array of as many bytes as
 * there are cells. Errors: TY_ERROR_MEMORY. */
ty_result ty_dom_find_hidden(const ty_dom* light, const ty_scene* scene, const double eye[3], uint8_t** hidden);
/* Gives hidden cells of a plane that are beside others what these have; cuts (NULL: none): those that are not behind
 * them, which interpolation keeps apart by itself. hidden: NULL: does nothing. */
void ty_dom_fill_hidden(const ty_dom* light, const ty_cuts* cuts, const uint8_t* hidden, float* plane);

/* Turns the light of cells beside walls (a channel's, as a source field has it) such that it brings to them what
 * arrives there, which the first moments alone do not say. */
void ty_dom_match_wall_irradiance(const ty_dom* light, int32_t channel, float* const terms[TY_FIELD_TERMS]);

/* What a scene's camera sees. stats may be NULL. Errors: TY_ERROR_ARGUMENT, TY_ERROR_MEMORY; TY_CANCELLED. */
ty_result ty_dom_march(const ty_dom* light, const ty_scene* scene, const ty_dom_def* def, ty_part_progress progress,
                       ty_image** out, ty_dom_stats* stats);

#endif
