/* The channels of images of scenes. */
#include "image/aovs.h"

const ty_aov_group ty_aov_groups[TY_AOV_GROUPS] = {
    {TY_AOV_COLOR, 3, {"R", "G", "B"}},
    {TY_AOV_VARIANCE, 3, {"variance.R", "variance.G", "variance.B"}},
    {TY_AOV_TRANSMITTANCE, 3, {"transmittance.R", "transmittance.G", "transmittance.B"}},
    {TY_AOV_DEPTH, 1, {"depth.Z"}},
    {TY_AOV_NORMAL, 3, {"normal.X", "normal.Y", "normal.Z"}},
    {TY_AOV_ALBEDO, 3, {"albedo.R", "albedo.G", "albedo.B"}},
    {TY_AOV_SINGLE, 3, {"single.R", "single.G", "single.B"}},
    {TY_AOV_MULTIPLE, 3, {"multiple.R", "multiple.G", "multiple.B"}},
    {TY_AOV_SAMPLES, 1, {"samples.N"}},
    {TY_AOV_SURFACE_ALBEDO, 3, {"surface_albedo.R", "surface_albedo.G", "surface_albedo.B"}},
    {TY_AOV_HALF | TY_AOV_COLOR, 3, {"half.R", "half.G", "half.B"}},
    {TY_AOV_HALF | TY_AOV_TRANSMITTANCE, 3, {"half.transmittance.R", "half.transmittance.G", "half.transmittance.B"}},
    {TY_AOV_HALF | TY_AOV_DEPTH, 1, {"half.depth.Z"}},
    {TY_AOV_HALF | TY_AOV_NORMAL, 3, {"half.normal.X", "half.normal.Y", "half.normal.Z"}},
    {TY_AOV_HALF | TY_AOV_ALBEDO, 3, {"half.albedo.R", "half.albedo.G", "half.albedo.B"}},
    {TY_AOV_HALF | TY_AOV_SINGLE, 3, {"half.single.R", "half.single.G", "half.single.B"}},
    {TY_AOV_HALF | TY_AOV_MULTIPLE, 3, {"half.multiple.R", "half.multiple.G", "half.multiple.B"}},
    {TY_AOV_HALF | TY_AOV_SURFACE_ALBEDO,
     3,
     {"half.surface_albedo.R", "half.surface_albedo.G", "half.surface_albedo.B"}},
};

bool ty_aov_is_requested(const ty_aov_group* group, uint32_t aovs) {
    return (group->aov & aovs) == group->aov;
}

int32_t ty_aov_names(uint32_t aovs, const char* names[TY_AOV_CHANNELS_MAX]) {
    int32_t count = 0;
    for (int g = 0; g < TY_AOV_GROUPS; ++g)
        for (int32_t c = 0; ty_aov_is_requested(&ty_aov_groups[g], aovs) && c < ty_aov_groups[g].count; ++c)
            names[count++] = ty_aov_groups[g].names[c];
    return count;
}
