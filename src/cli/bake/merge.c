/* tyndall bake: merging the lightmaps of a mesh's primitives into one. */
#include "cli/bake/bake.h"

/* Two primitives do not share a map if more than this fraction of a primitive's texels is covered by the other, too. */
static const double overlap_tolerance = 0.05;

static size_t pixel_count(const ty_image* image) {
    return (size_t)ty_image_width(image) * (size_t)ty_image_height(image);
}

static const float* coverage_of(const ty_image* image) {
    const int32_t channel = ty_image_find_channel(image, "coverage.A");
    return channel < 0 ? NULL : ty_image_plane_const(image, channel);
}

/* True if the charts of two primitives overlap. */
static bool overlap(const ty_image* a, const ty_image* b) {
    const float *of_a = coverage_of(a), *of_b = coverage_of(b);
    double own_a = 0, own_b = 0, common = 0;
    for (size_t i = 0; i < pixel_count(a); ++i) {
        own_a += of_a[i] >= 1;
        own_b += of_b[i] >= 1;
        common += of_a[i] >= 1 && of_b[i] >= 1;
    }
    return common > overlap_tolerance * (own_a < own_b ? own_a : own_b);
}

/* True if a texel holds irradiance; padding does without coverage. */
static bool is_filled(const ty_image* image, size_t texel) {
    for (int32_t channel = 0; channel < ty_image_channel_count(image); ++channel)
        if (ty_image_plane_const(image, channel)[texel] != 0) return true;
    return false;
}

/* The owner of a texel: the primitive with the largest coverage, or else the first whose padding reaches it. */
static int32_t find_owner(ty_image* const* images, int32_t count, size_t texel) {
    int32_t owner = 0;
    float max_coverage = 0;
    for (int32_t primitive = 0; primitive < count; ++primitive) {
        const float covered = coverage_of(images[primitive])[texel];
        if (covered > max_coverage) owner = primitive;
        max_coverage = covered > max_coverage ? covered : max_coverage;
    }
    for (int32_t primitive = 0; max_coverage == 0 && primitive < count; ++primitive)
        if (is_filled(images[primitive], texel)) return primitive;
    return owner;
}

ty_result bake_merge(ty_image* const* images, int32_t count, bool* overlapping) {
    *overlapping = false;
    for (int32_t primitive = 0; primitive < count; ++primitive)
        if (coverage_of(images[primitive]) == NULL) return TY_ERROR_INTERNAL;
    for (int32_t a = 0; a < count && !*overlapping; ++a)
        for (int32_t b = 0; b < a && !*overlapping; ++b) *overlapping = overlap(images[a], images[b]);
    for (size_t texel = 0; !*overlapping && count > 1 && texel < pixel_count(images[0]); ++texel) {
        const int32_t owner = find_owner(images, count, texel);
        for (int32_t channel = 0; owner > 0 && channel < ty_image_channel_count(images[0]); ++channel)
            ty_image_plane(images[0], channel)[texel] = ty_image_plane_const(images[owner], channel)[texel];
    }
    return TY_OK;
}
