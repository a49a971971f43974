/* Trials of methods: coarse solves, whose pictures are compared with a pilot of path tracing. */
#ifndef TY_CHOOSE_TRIAL_H
#define TY_CHOOSE_TRIAL_H

#include "choose/pilot.h"
#include "method/method.h"

/* Noise of the pilot's means of 4 x 3 blocks, relative to its mean. */
double ty_trial_noise(const ty_pilot* pilot);
/* Relative RMSE of the means of those blocks by a coarse solve; ty_trial_failed where the method fails, or where it is
 * larger. */
double ty_trial(const ty_scene* scene, const ty_method* method, const ty_pilot* pilot);
extern const double ty_trial_failed;

#endif
