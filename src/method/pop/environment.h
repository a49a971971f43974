/* Environment light as ordinates. */
#ifndef TY_METHOD_POP_ENVIRONMENT_H
#define TY_METHOD_POP_ENVIRONMENT_H

#include "method/pop/ordinate.h"

/* Cuts an environment light into at most def->ordinates parts and writes an ordinate for each: its irradiance is that
 * of its part, so that all together are the environment, channel by channel; its direction is the mean of the part's
 * light. Parts are cut where the most light changes direction, weighted by importance: a small sun is one part however
 * bright it is, and what is left over goes to where light comes from all over.
 *
 * The length of the mean vector of a part's light is its mean cosine, whatever the part's shape: what Sec. 5.1's
 * 1 - w / N stands for (w / N being the part's share of the sphere, in a sphere of even radiance). Published mode takes
 * the latter. Errors: TY_ERROR_MEMORY. */
ty_result ty_pop_environment_ordinates(const ty_scene* scene, const ty_pop_def* def, int32_t light,
                                       const float* importance, ty_pop_ordinate* out, int32_t* count);

#endif
