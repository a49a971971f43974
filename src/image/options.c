#include "image/options.h"

#include "base/context.h"
#include "image/aovs.h"
#include "image/image.h"

#include <stdio.h>
#include <string.h>

enum { LIST_MAX = 128 };

ty_result ty_check_resolution(ty_context* context, const char* method, int32_t width, int32_t height) {
    if (width == 0 && height == 0) return TY_OK;
    if (width > 0 && height > 0 && width <= TY_IMAGE_SIDE_MAX && height <= TY_IMAGE_SIDE_MAX) return TY_OK;
    return ty_fail(context, TY_ERROR_ARGUMENT, "%s: %d x %d is not a resolution in 1..%d", method, (int)width,
                   (int)height, (int)TY_IMAGE_SIDE_MAX);
}

void ty_image_resolution(const ty_scene* scene, int32_t width, int32_t height, int32_t size[2]) {
    const ty_camera_def camera = ty_scene_camera(scene);
    size[0] = width > 0 ? width : camera.resolution[0];
    size[1] = width > 0 ? height : camera.resolution[1];
}

/* "a, b and c": the groups of channels among `aovs`. */
static void list_aovs(uint32_t aovs, char list[LIST_MAX]) {
    size_t length = 0;
    list[0] = '\0';
    for (int g = 0; g < TY_AOV_GROUPS && length < LIST_MAX; ++g) {
        const ty_aov_group* group = &ty_aov_groups[g];
        if (group->aov == TY_AOV_COLOR || !ty_aov_is_requested(group, aovs)) continue;
        const bool last = aovs < 2 * group->aov;
        const char* between = length == 0 ? "" : last ? " and " : ", ";
        length += (size_t)snprintf(list + length, LIST_MAX - length, "%s%.*s", between,
                                   (int)strcspn(group->names[0], "."), group->names[0]);
    }
}

ty_result ty_check_image(ty_context* context, const char* method, const ty_image_options* options, uint32_t known) {
    char list[LIST_MAX];
    if ((options->aovs & ~known) != 0) {
        list_aovs(known, list);
        return ty_fail(context, TY_ERROR_ARGUMENT, "%s.aovs: %s are all", method, list);
    }
    return ty_check_resolution(context, method, options->width, options->height);
}
