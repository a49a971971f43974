/* Channels of images of scenes: one list for all methods. */
#ifndef TY_IMAGE_AOVS_H
#define TY_IMAGE_AOVS_H

#include <tyndall/image.h>

enum { TY_AOV_COLOR = 0, TY_AOV_GROUPS = 18, TY_AOV_CHANNELS_MAX = 48 };

/* A group of channels, in the order of the image; aov: TY_AOV_..., all of which ask for it, or TY_AOV_COLOR. */
typedef struct ty_aov_group {
    uint32_t aov;
    int32_t count;
    const char* names[3];
} ty_aov_group;

extern const ty_aov_group ty_aov_groups[TY_AOV_GROUPS];

/* True if a group is in an image with these TY_AOV_...; color always is. */
bool ty_aov_is_requested(const ty_aov_group* group, uint32_t aovs);
/* Writes the names of all channels and returns their number. */
int32_t ty_aov_names(uint32_t aovs, const char* names[TY_AOV_CHANNELS_MAX]);

#endif
