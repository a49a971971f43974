/* What figures of flux-limited diffusion call the limiters. */
#ifndef TY_CLI_FIGURES_FLD_LIMITERS_H
#define TY_CLI_FIGURES_FLD_LIMITERS_H

#include "solve/diffusion/diffusion.h"

/* By ty_limiter. */
extern const char* const fld_limiter_names[TY_LIMITER_COUNT];

#endif
