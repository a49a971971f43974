/* The automatic choice of a guide. */
#ifndef TY_PATH_GUIDE_CHOICE_H
#define TY_PATH_GUIDE_CHOICE_H

#include "method/path/driver.h"

/* The guide of a run whose def leaves it open, before anything is known of the light: that of the state that it
 * resumes, none for work so short or of so many lights that a solve cannot pay, or TY_PATH_GUIDE_AUTO, where a pilot is
 * to tell. The crop does not matter, so that pixels are those of the whole frame. */
ty_path_guide_kind ty_path_guide_expected(const ty_path_run* run);

/* True if a pilot of the whole frame by the run's request, which has a guide, and by one without finds less variance
 * in the same time with it. Its samples are none of the image's, whose mean therefore stays as it is. */
bool ty_path_guide_pays(const ty_path_run* run);

#endif
