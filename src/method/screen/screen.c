/* Entry points: what every variant begins and ends with. */
#include "method/screen/job.h"

#include "base/context.h"

size_t ty_screen_workspace(const ty_context* context, const ty_screen_def* def, int32_t width, int32_t height) {
    (void)context, (void)def, (void)width, (void)height;
    return 0;
}

ty_result ty_screen_apply(ty_context* context, const ty_screen_def* def, const ty_screen_image* image, void* workspace,
                          size_t workspace_size, ty_screen_stats* stats) {
    (void)def, (void)image, (void)workspace, (void)workspace_size, (void)stats;
    return ty_fail(context, TY_ERROR_UNSUPPORTED, "not yet");
}
