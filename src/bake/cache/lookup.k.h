/* Interpolation of the light cache. */
#ifndef TY_BAKE_CACHE_LOOKUP_K_H
#define TY_BAKE_CACHE_LOOKUP_K_H

#include "bake/cache/cache.h"
#include "scene/media/phase.k.h"

TY_FN int32_t ty_cache_cell(const ty_cache_view* view, ty_vec at) {
    const int32_t* size = view->size;
    const float m = view->per_metre;
    const int32_t x = (int32_t)ty_clampf((at.x - view->lower[0]) * m, 0.0f, (float)(size[0] - 1));
    const int32_t y = (int32_t)ty_clampf((at.y - view->lower[1]) * m, 0.0f, (float)(size[1] - 1));
    const int32_t z = (int32_t)ty_clampf((at.z - view->lower[2]) * m, 0.0f, (float)(size[2] - 1));
    return x + size[0] * (y + size[1] * z);
}

TY_FN bool ty_cache_visible(const ty_accel* mesh, ty_vec from, ty_vec to) {
    const ty_vec axis = ty_sub(to, from);
    const float distance = sqrtf(ty_dot(axis, axis));
    return !(distance > 0.0f) || !ty_accel_occluded(mesh, from, ty_scale(axis, 1.0f / distance), distance);
}

/* The side of a cell visible from a point; -1: none. */
TY_FN int32_t ty_cache_side(const ty_cache_view* view, const ty_accel* mesh, int32_t cell, ty_vec at) {
    const float* anchor = view->anchor + (size_t)cell * (3 * TY_CACHE_SIDES);
    const uint8_t flags = view->flags[cell];
    if ((flags & 1) != 0 && ty_cache_visible(mesh, at, ty_vec_load(anchor))) return 0;
    if ((flags & 2) != 0 && ty_cache_visible(mesh, at, ty_vec_load(anchor + 3))) return 1;
    return -1;
}

/* A random offset of up to half a cell per axis that selects one of the eight cells around a point: the expected value
 * is the trilinear interpolation between cell centers, constant beyond the outermost. */
TY_FN ty_vec ty_cache_jitter(const ty_cache_view* view, ty_sampler* random) {
    const uint64_t bits = ty_rng_bits(random);
    const float half = 0.5f, metres = 1.0f / view->per_metre;
    const ty_vec jitter = ty_vec_make((float)(uint32_t)(bits >> 43) * 0x1p-21f - half,
                                      (float)(uint32_t)(bits >> 22 & 0x1fffffu) * 0x1p-21f - half,
                                      (float)(uint32_t)(bits & 0x1fffffu) * 0x1p-21f - half);
    return ty_scale(jitter, metres);
}

/* Light of one of the eight cells around a point, chosen at random. Near surfaces only light whose anchor is visible
 * from the point counts. */
TY_FN const float* ty_cache_lookup(const ty_cache_view* view, const ty_accel* mesh, ty_vec at, ty_sampler* random) {
    int32_t cell = ty_cache_cell(view, ty_add(at, ty_cache_jitter(view, random))), side = 0;
    const int32_t own_cell = ty_cache_cell(view, at);
    const size_t each = (size_t)(TY_CACHE_KINDS * view->floats);
    const bool single = (view->flags[own_cell] & ~TY_CACHE_TEST_VISIBILITY) == 1; /* only the first side exists */
    if ((view->flags[own_cell] & TY_CACHE_TEST_VISIBILITY) != 0 && !(cell == own_cell && single)) {
        side = ty_cache_side(view, mesh, cell, at);
        if (side < 0) {
            side = cell != own_cell && !single ? ty_cache_side(view, mesh, own_cell, at) : 0;
            cell = own_cell;
        }
    }
    return (side == 1 ? view->second_light : view->light) + (size_t)cell * each;
}

/* ---- on surfaces ---- */

/* Cosines between the normals of a surface point and a surfel: below the first the surfel has no weight, from the
 * second on its full weight. */
#define TY_SURFEL_MIN_COSINE 0.7f
#define TY_SURFEL_FULL_COSINE 0.95f
/* Tolerance of coplanarity, in cell widths; of parallel surfaces closer than this only one gets a surfel. */
#define TY_SURFEL_FLATNESS 0.05f

/* True if the cache covers a point. */
TY_FN bool ty_cache_contains(const ty_cache_view* view, ty_vec at) {
    const float m = view->per_metre, slack = 1e-3f;
    const float x = (at.x - view->lower[0]) * m, y = (at.y - view->lower[1]) * m, z = (at.z - view->lower[2]) * m;
    return x > -slack && y > -slack && z > -slack && x < (float)view->size[0] + slack &&
           y < (float)view->size[1] + slack && z < (float)view->size[2] + slack;
}

/* The dominant axis of a normal: +x, +y, +z, -x, -y, -z. */
TY_FN int32_t ty_surfel_axis(ty_vec normal) {
    const float x = fabsf(normal.x), y = fabsf(normal.y), z = fabsf(normal.z);
    if (x >= y && x >= z) return normal.x < 0.0f ? 3 : 0;
    if (y >= z) return normal.y < 0.0f ? 4 : 1;
    return normal.z < 0.0f ? 5 : 2;
}

/* The surfel of a cell for a normal axis; NULL: none. */
TY_FN float* ty_surfel_of_cell(const ty_cache_view* view, int32_t cell, int32_t axis) {
    const uint32_t surfel_axes = view->surfel_axes[cell];
    if ((surfel_axes >> axis & 1u) == 0) return NULL;
    const int32_t index_in_cell = __builtin_popcount(surfel_axes & ((1u << axis) - 1u));
    return view->surfels + (size_t)(view->first_surfel[cell] + index_in_cell) * TY_SURFEL_FLOATS;
}

/* True if a point lies in the plane of a surfel. */
TY_FN bool ty_surfel_is_coplanar(const ty_cache_view* view, ty_vec position, ty_vec normal, ty_vec at) {
    return fabsf(ty_dot(ty_sub(at, position), normal)) * view->per_metre < TY_SURFEL_FLATNESS;
}

/* Weight of a surfel at a surface point, 0..1. unoccluded: no surface separates the neighbouring cells. */
TY_FN float ty_surfel_weight(const ty_cache_view* view, const ty_accel* mesh, const float* surfel, ty_vec at,
                             ty_vec normal, bool unoccluded) {
    if (surfel == NULL || !(surfel[TY_SURFEL_PATHS] > 0.0f)) return 0.0f;
    const ty_vec own_cell = ty_vec_load(surfel + TY_SURFEL_NORMAL);
    const ty_vec position = ty_vec_load(surfel + TY_SURFEL_POSITION);
    const float cosine = ty_dot(own_cell, normal);
    if (!(cosine > TY_SURFEL_MIN_COSINE) || !ty_surfel_is_coplanar(view, position, own_cell, at)) return 0.0f;
    if (!unoccluded) {
        /* Visibility is tested off the surfaces, which may be curved. */
        const float off = 0.1f / view->per_metre;
        if (!ty_cache_visible(mesh, ty_mad(at, normal, off), ty_mad(position, own_cell, off))) return 0.0f;
    }
    return ty_minf(1.0f, (cosine - TY_SURFEL_MIN_COSINE) / (TY_SURFEL_FULL_COSINE - TY_SURFEL_MIN_COSINE));
}

TY_FN bool ty_cache_is_unoccluded(const ty_cache_view* view, ty_vec at) {
    return (view->flags[ty_cache_cell(view, at)] & TY_CACHE_TEST_VISIBILITY) == 0;
}

/* A surfel near a surface point, chosen at random among the cells along the surface; NULL: none. */
TY_FN const float* ty_cache_lookup_surfel(const ty_cache_view* view, const ty_accel* mesh, ty_vec at, ty_vec normal,
                                          ty_sampler* random) {
    if (view->surfel_axes == NULL || !ty_cache_contains(view, at)) return NULL;
    const int32_t axis = ty_surfel_axis(normal), own_cell = ty_cache_cell(view, at);
    const bool unoccluded = ty_cache_is_unoccluded(view, at);
    const ty_vec jitter = ty_cache_jitter(view, random);
    const int32_t cell = ty_cache_cell(view, ty_mad(ty_add(at, jitter), normal, -ty_dot(normal, jitter)));
    const float* surfel = ty_surfel_of_cell(view, cell, axis);
    if (ty_surfel_weight(view, mesh, surfel, at, normal, unoccluded) > 0.0f) return surfel;
    surfel = cell != own_cell ? ty_surfel_of_cell(view, own_cell, axis) : NULL;
    return ty_surfel_weight(view, mesh, surfel, at, normal, unoccluded) > 0.0f ? surfel : NULL;
}

/* Trilinear interpolation of the surfels around a surface point: light[kind][channel][term] and its variance. Returns
 * the number of paths from the point itself that would be equally noisy; 0: no data. */
TY_FN float ty_cache_mean_surfel(const ty_cache_view* view, const ty_accel* mesh, ty_vec at, ty_vec normal,
                                 float light[TY_SURFEL_IRRADIANCE_FLOATS], float variance[3]) {
    float fraction[3], weights = 0.0f, squares = 0.0f;
    int32_t base[3];
    if (view->surfel_axes == NULL || !ty_cache_contains(view, at)) return 0.0f;
    const float position[3] = {at.x, at.y, at.z};
    for (int a = 0; a < 3; ++a) {
        const float p = (position[a] - view->lower[a]) * view->per_metre - 0.5f, last = (float)(view->size[a] - 1);
        base[a] = (int32_t)floorf(ty_clampf(p, 0.0f, last));
        fraction[a] = ty_clampf(p - (float)base[a], 0.0f, (float)(view->size[a] - 1 - base[a]));
    }
    const bool unoccluded = ty_cache_is_unoccluded(view, at);
    const int32_t axis = ty_surfel_axis(normal);
    for (int t = 0; t < TY_SURFEL_IRRADIANCE_FLOATS; ++t) light[t] = 0.0f;
    for (int c = 0; c < 3; ++c) variance[c] = 0.0f;
    for (int corner = 0; corner < 8; ++corner) {
        float weight = 1.0f;
        int32_t cell = 0;
        for (int a = 2; a >= 0; --a) {
            const int32_t up = corner >> a & 1;
            weight *= up != 0 ? fraction[a] : 1.0f - fraction[a];
            cell = cell * view->size[a] + base[a] + up;
        }
        const float* surfel = weight > 0.0f ? ty_surfel_of_cell(view, cell, axis) : NULL;
        weight *= ty_surfel_weight(view, mesh, surfel, at, normal, unoccluded);
        if (!(weight > 0.0f)) continue;
        weights += weight;
        squares += weight * weight / surfel[TY_SURFEL_PATHS];
        for (int t = 0; t < TY_SURFEL_IRRADIANCE_FLOATS; ++t) light[t] += weight * surfel[TY_SURFEL_IRRADIANCE + t];
        for (int c = 0; c < 3; ++c) variance[c] += weight * weight * surfel[TY_SURFEL_VARIANCE + c];
    }
    if (!(weights > 0.0f)) return 0.0f;
    for (int t = 0; t < TY_SURFEL_IRRADIANCE_FLOATS; ++t) light[t] /= weights;
    for (int c = 0; c < 3; ++c) variance[c] /= weights * weights;
    /* A flat surface lies in half of the eight cells. */
    return ty_minf(1.0f, 2.0f * weights) * weights * weights / squares;
}

/* ---- scattering ---- */

/* Radiance scattered against a ray's direction, per unit scattering coefficient, of one kind of light. Incident light
 * whose mean direction has length R is taken for a Henyey-Greenstein lobe of mean cosine R about that direction, so
 * scattering convolves it to mean cosine g R: exact for light from a single direction, for isotropic light and for all
 * zonal light up to its first harmonic, and never negative. */
TY_FN void ty_cache_scatter(const ty_cache_view* view, const float* light, ty_vec direction, const float g[3],
                            float out[3]) {
    for (int c = 0; c < 3; ++c) out[c] = light[c];
    if (view->floats == TY_CACHE_ISOTROPIC) return;
    const float mu = ty_clampf(ty_dot(ty_vec_load(light + 3), direction), -1.0f, 1.0f);
    float lobe = ty_hg(mu, g[0] * light[6]) * (1.0f / TY_INV_4PI);
    for (int c = 0; c < 3; ++c) {
        if (c > 0 && view->floats == TY_CACHE_COLORED) lobe = ty_hg(mu, g[c] * light[6 + c]) * (1.0f / TY_INV_4PI);
        out[c] *= lobe;
    }
}

#endif
