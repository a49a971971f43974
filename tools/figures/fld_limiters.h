/* Names of the limiters in figures of flux-limited diffusion. */
#ifndef TY_FIGURES_FLD_LIMITERS_H
#define TY_FIGURES_FLD_LIMITERS_H

#include "solve/diffusion/diffusion.h"

/* Indexed by ty_limiter. */
extern const char* const fld_limiter_names[TY_LIMITER_COUNT];

#endif
