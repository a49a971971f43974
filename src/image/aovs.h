/* The channels that images of scenes may have: one list for all methods. */
#ifndef TY_IMAGE_AOVS_H
#define TY_IMAGE_AOVS_H

#include <tyndall/image.h>

enum { TY_AOV_COLOR = 0, TY_AOV_GROUPS = 9, TY_AOV_CHANNELS_MAX = 26 };

/* Channels that belong together, in the order of the image; aov: TY_AOV_..., or TY_AOV_COLOR. */
typedef struct ty_aov_group {
    uint32_t aov;
    int32_t count;
    const char* names[3];
} ty_aov_group;

extern const ty_aov_group ty_aov_groups[TY_AOV_GROUPS];

/* Whether a group is in an image with these TY_AOV_...; color always is. */
bool ty_aov_asked(const ty_aov_group* group, uint32_t aovs);
/* The names of all channels; returns how many there are. */
int32_t ty_aov_names(uint32_t aovs, const char* names[TY_AOV_CHANNELS_MAX]);

#endif
