/* Surfaces outside of the box return light of media to them. Its first return is solved as light that enters the box,
 * and stands for all further ones, which are in proportion. */
#include "method/diffuse/interreflection.h"

#include "base/context.h"
#include "method/diffuse/view.h"

#include <math.h>
#include <string.h>

/* The most that one return may be of the last. */
static const double MAX_RATIO = 0.9;

/* ---- light that enters ---- */

/* The patches on both sides of a cell along an axis, and the weight of the second. */
static int32_t patch_of(int32_t cell, int32_t cells, float* weight) {
    const double place = (cell + 0.5) / cells * TY_IRRADIANCE_PATCHES - 0.5;
    const int32_t first = (int32_t)fmin(fmax(floor(place), 0), TY_IRRADIANCE_PATCHES - 2);
    *weight = (float)fmin(fmax(place - first, 0), 1);
    return first;
}

static void fill_side(const float patches[TY_IRRADIANCE_FACE_PATCHES][3], int32_t channel, int32_t columns,
                      int32_t rows, float* out) {
    for (int32_t y = 0; y < rows; ++y)
        for (int32_t x = 0; x < columns; ++x) {
            float along, up;
            const int32_t first = patch_of(x, columns, &along) + TY_IRRADIANCE_PATCHES * patch_of(y, rows, &up);
            const float low = (1 - along) * patches[first][channel] + along * patches[first + 1][channel];
            const float high = (1 - along) * patches[first + TY_IRRADIANCE_PATCHES][channel] +
                               along * patches[first + TY_IRRADIANCE_PATCHES + 1][channel];
            out[(size_t)y * (size_t)columns + (size_t)x] = (1 - up) * low + up * high;
        }
}

ty_result ty_incident_flux_make(const ty_irradiance_cache* cache, ty_context* context, ty_reflected_light light,
                                const int32_t size[3], ty_incident_flux* out) {
    float patches[6][TY_IRRADIANCE_FACE_PATCHES][3];
    *out = (ty_incident_flux){.scattered = light != TY_REFLECTED_LAMPS};
    ty_irradiance_cache_faces(cache, light, patches);
    for (int side = 0; side < 6; ++side) {
        const int32_t columns = size[side / 2 == 0 ? 1 : 0], rows = size[side / 2 == 2 ? 1 : 2];
        for (int32_t c = 0; c < 3; ++c) {
            out->sides[side][c] = ty_alloc_array(context, (size_t)columns * (size_t)rows, sizeof(float), false);
            if (out->sides[side][c] == NULL) return TY_ERROR_MEMORY;
            fill_side((const float(*)[3])patches[side], c, columns, rows, out->sides[side][c]);
        }
    }
    return TY_OK;
}

void ty_incident_flux_free(ty_context* context, const int32_t size[3], ty_incident_flux* flux) {
    for (int side = 0; side < 6; ++side) {
        const size_t columns = (size_t)size[side / 2 == 0 ? 1 : 0], rows = (size_t)size[side / 2 == 2 ? 1 : 2];
        for (int c = 0; c < 3; ++c) ty_free_array(context, flux->sides[side][c], columns * rows, sizeof(float));
    }
    *flux = (ty_incident_flux){.scattered = false};
}

/* ---- returns ---- */

double ty_interreflection_series(const ty_irradiance_cache* cache) {
    const double first = ty_irradiance_cache_power(cache, TY_REFLECTED_MEDIA);
    const double ratio = first > 0 ? ty_irradiance_cache_power(cache, TY_REFLECTED_MORE) / first : 0;
    return 1 / (1 - fmin(ratio, MAX_RATIO));
}

static ty_result gather(const ty_interreflection_def* def, const ty_diffuse_light* light, ty_reflected_light which,
                        ty_irradiance_cache* cache) {
    const bool more = which == TY_REFLECTED_MORE;
    ty_diffuse_view fields;
    ty_march_def march = def->march;
    ty_result result = ty_diffuse_view_make(light, def->scene, NULL, more ? NULL : def->added, &fields);
    march.field = &fields.media;
    march.surface_field = &fields.surfaces;
    march.cuts = fields.cuts;
    if (more) march.light_count = 0;
    if (result == TY_OK) result = ty_irradiance_cache_gather(cache, def->scene, &march, !more, which);
    ty_diffuse_view_free(&fields);
    return result;
}

/* Diffuse light of the light that enters alone. */
static ty_result solve(const ty_interreflection_def* def, const ty_irradiance_cache* cache, ty_diffuse_light* light,
                       ty_diffuse_light** out, ty_diffuse_stats* stats) {
    const ty_grid_medium* medium = def->medium;
    ty_diffuse_surfaces* surfaces = def->surfaces;
    ty_incident_flux incident;
    float* dark = ty_alloc_array(light->context, medium->cells, sizeof *dark, true);
    float* const source[3] = {dark, dark, dark};
    ty_grid_medium unlit = *medium;
    for (int c = 0; c < 3; ++c) unlit.emission[c] = NULL;
    ty_result result = dark != NULL ? TY_OK : TY_ERROR_MEMORY;
    if (result == TY_OK)
        result = ty_incident_flux_make(cache, light->context, TY_REFLECTED_MEDIA, medium->box.size, &incident);
    for (int c = 0; c < 3 && light->faces != NULL; ++c) {
        memset(surfaces->radiosity[c], 0, sizeof(float) * surfaces->count);
        memset(surfaces->forward[c], 0, sizeof(float) * surfaces->count);
    }
    surfaces->faces = light->faces;
    if (result == TY_OK)
        result = ty_diffuse_light_solve_between(&def->solver, def->reduced, &unlit, surfaces, source, &incident,
                                                def->progress, out, stats);
    surfaces->faces = NULL;
    if (dark != NULL) ty_incident_flux_free(light->context, medium->box.size, &incident);
    ty_free_array(light->context, dark, medium->cells, sizeof *dark);
    return result;
}

static void scale_stats(ty_diffuse_stats* stats, double factor) {
    for (int c = 0; c < 3; ++c) {
        stats->emitted[c] *= factor;
        stats->absorbed[c] *= factor;
        stats->leaving[c] *= factor;
        stats->surfaces_absorbed[c] *= factor;
    }
}

ty_result ty_interreflect(const ty_interreflection_def* def, ty_irradiance_cache* cache, ty_diffuse_light* light,
                          ty_diffuse_stats* returned) {
    ty_diffuse_light* more = NULL;
    *returned = (ty_diffuse_stats){.converged = true};
    ty_result result = gather(def, light, TY_REFLECTED_MEDIA, cache);
    const bool same_cells = memcmp(light->box.size, def->medium->box.size, sizeof light->box.size) == 0;
    if (result != TY_OK || !same_cells || def->solver.boundary[0].kind != TY_BOUNDARY_MARSHAK ||
        ty_irradiance_cache_power(cache, TY_REFLECTED_MEDIA) < TY_INTERREFLECTION_MIN * def->emitted)
        return result;
    result = solve(def, cache, light, &more, returned);
    if (result == TY_OK) result = gather(def, more, TY_REFLECTED_MORE, cache);
    if (result == TY_OK) {
        const double series = ty_interreflection_series(cache);
        ty_diffuse_light_add(light, more, (float)series);
        ty_irradiance_cache_add_more(cache, series);
        scale_stats(returned, series);
    }
    if (more != NULL) more->faces = NULL; /* the light's */
    ty_diffuse_light_destroy(more);
    return result;
}
