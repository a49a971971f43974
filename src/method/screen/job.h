/* One call of ty_screen_apply on its way through the parts of the method. */
#ifndef TY_METHOD_SCREEN_JOB_H
#define TY_METHOD_SCREEN_JOB_H

#include "method/screen/split.k.h"

#include <tyndall/screen.h>

enum { TY_SCREEN_SIDE_MAX = 65536, TY_SCREEN_LEVELS_USUAL = 6 };

ty_result ty_screen_check(ty_context* context, const ty_screen_def* def);
/* out: whether image->out must be there. */
ty_result ty_screen_check_image(ty_context* context, const ty_screen_image* image, bool out);

typedef struct ty_screen_job {
    ty_context* context;
    const ty_screen_def* def;
    const ty_screen_image* image;
    const struct ty_screen_kernels* kernels;
    ty_screen_params params; /* what kernels take */
    char* memory;            /* the workspace, aligned to 64 bytes */
    size_t memory_size;
    ty_screen_stats stats;
} ty_screen_job;

/* Each variant: the workspace it needs for a size, and its work. */
size_t ty_screen_scatter_size(const ty_context* context, const ty_screen_def* def, int32_t width, int32_t height);
ty_result ty_screen_scatter(ty_screen_job* job);
size_t ty_screen_gather_size(const ty_context* context, const ty_screen_def* def, int32_t width, int32_t height);
ty_result ty_screen_gather(ty_screen_job* job);
size_t ty_screen_reference_size(const ty_context* context, const ty_screen_def* def, int32_t width, int32_t height);
ty_result ty_screen_reference(ty_screen_job* job);

#endif
