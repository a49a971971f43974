/* Seeing a solve's light. */
#ifndef TY_METHOD_DOM_VIEW_H
#define TY_METHOD_DOM_VIEW_H

#include "method/dom/job.h"

/* What a scene's camera sees. stats may be NULL. Errors: TY_ERROR_ARGUMENT, TY_ERROR_MEMORY; TY_CANCELLED. */
ty_result ty_dom_march(const ty_dom* light, const ty_scene* scene, const ty_dom_def* def, ty_part_progress progress,
                       ty_image** out, ty_dom_stats* stats);

#endif
