/* Options of denoising, and their checks. */
#include "image/denoise/job.h"
#include "option/option.h"

static const char* const denoisers[] = {"regression", "oidn", NULL};

static const ty_option options[] = {
    {TY_OPTION_FIELD(ty_denoise_def, parts), .type = TY_OPTION_BOOL, .preset = 1,
     .doc = "Single and multiple scattering, and the rest, are denoised apart."},
    {TY_OPTION_FIELD(ty_denoise_def, denoiser), .type = TY_OPTION_WORD, .words = denoisers, .max = TY_DENOISER_OIDN,
     .doc = "Which program removes the noise."},
};

static const ty_option_table table = TY_OPTION_TABLE("denoise", ty_denoise_def, "ty_default_denoise_def", options);

void ty_init_denoise_def(void* def, size_t bytes) {
    ty_options_init(&table, def, bytes);
}

ty_result ty_denoise_take_def(ty_context* context, const ty_denoise_def* def, ty_denoise_def* own) {
    return ty_options_take(context, &table, def, own);
}
