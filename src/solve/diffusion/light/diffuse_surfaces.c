/* Sides of closed faces with their radiosity, and the sources of cells beside them. */
#include "solve/diffusion/light/diffuse_surfaces.h"

#include "base/context.h"

#include <math.h>
#include <string.h>

static const float max_difference = 1e-6f; /* relative, of channels that are multiples of one */

ty_result ty_diffuse_surfaces_find(const ty_scene* scene, const ty_grid_medium* medium, ty_diffuse_surfaces* out) {
    *out = (ty_diffuse_surfaces){.context = medium->context, .cells = medium->cells};
    const ty_result result = ty_boundary_faces_find(scene, medium, &out->faces);
    if (out->faces != NULL) out->count = (size_t)out->faces->count;
    return result;
}

static ty_result allocate(ty_diffuse_surfaces* surfaces) {
    const size_t count = surfaces->count;
    ty_context* context = surfaces->context;
    bool complete = true;
    surfaces->staircase = ty_alloc_array(context, count, sizeof(float), false);
    surfaces->unlit = ty_alloc_array(context, surfaces->cells, 1, false);
    for (int c = 0; c < 3; ++c) {
        surfaces->albedo[c] = ty_alloc_array(context, count, sizeof(float), false);
        surfaces->radiosity[c] = ty_alloc_array(context, count, sizeof(float), true);
        surfaces->forward[c] = ty_alloc_array(context, count, sizeof(float), true);
        complete =
            complete && surfaces->albedo[c] != NULL && surfaces->radiosity[c] != NULL && surfaces->forward[c] != NULL;
    }
    return complete && surfaces->staircase != NULL && surfaces->unlit != NULL ? TY_OK : TY_ERROR_MEMORY;
}

/* Irradiance of uncollided light, in radiosity. */
static ty_result find_irradiance(const ty_scene* scene, const ty_grid_medium* medium, bool reduced,
                                 const ty_discrete_light_set* sources, ty_diffuse_surfaces* surfaces) {
    float* extinction[3] = {NULL, NULL, NULL};
    ty_result result = TY_OK;
    for (int32_t p = 0; p < medium->planes && reduced; ++p) {
        extinction[p] = ty_alloc_array(surfaces->context, medium->cells, sizeof(float), false);
        if (extinction[p] == NULL) result = TY_ERROR_MEMORY;
    }
    if (result == TY_OK && reduced) ty_grid_medium_reduce(medium, 1, extinction);
    if (result == TY_OK)
        ty_boundary_irradiance_add(scene, surfaces->faces, medium, reduced ? extinction : medium->extinction,
                                   sources->items, sources->count, surfaces->radiosity,
                                   reduced ? surfaces->forward : NULL);
    for (int32_t p = 0; p < medium->planes; ++p)
        ty_free_array(surfaces->context, extinction[p], medium->cells, sizeof(float));
    return result;
}

ty_result ty_diffuse_surfaces_light(const ty_scene* scene, const ty_grid_medium* medium, bool reduced,
                                    const ty_discrete_light_set* sources, ty_diffuse_surfaces* surfaces) {
    if (surfaces->faces == NULL) return TY_OK;
    ty_result result = allocate(surfaces);
    if (result == TY_OK)
        result = ty_unlit_cells_find(scene, surfaces->faces, medium, sources->items, sources->count, surfaces->unlit);
    if (result == TY_OK) result = find_irradiance(scene, medium, reduced, sources, surfaces);
    for (int32_t i = 0; i < surfaces->faces->count && result == TY_OK; ++i) {
        const ty_boundary_side* side = &surfaces->faces->sides[i];
        surfaces->staircase[i] = ty_maxf(1, side->staircase_factor);
        for (int c = 0; c < 3; ++c) {
            surfaces->albedo[c][i] = side->albedo[c];
            surfaces->radiosity[c][i] = side->albedo[c] * surfaces->radiosity[c][i] + TY_PI * side->emission[c];
        }
    }
    return result;
}

ty_result ty_diffuse_surfaces_correct_source(const ty_diffuse_surfaces* surfaces, const ty_grid_medium* medium,
                                             const ty_grid_box* fine_box, const ty_light_fluence* lights, int32_t count,
                                             float* const source[3]) {
    if (surfaces->faces == NULL) return TY_OK;
    ty_cut_source cut = {.faces = surfaces->faces,
                         .fine_box = *fine_box,
                         .lights = lights,
                         .light_count = count,
                         .channels = 3,
                         .terms = 1,
                         .cells = surfaces->cells};
    memcpy(cut.cell, medium->cell, sizeof cut.cell);
    for (int c = 0; c < 3; ++c) cut.source[c] = source[c];
    const ty_result result = count > 0 ? ty_cut_cells_correct(surfaces->context, &cut) : TY_OK;
    for (int c = 0; c < 3; ++c)
        for (size_t i = 0; i < surfaces->cells; ++i)
            if (surfaces->unlit[i] != 0) source[c][i] = 0;
    return result;
}

void ty_diffuse_surfaces_destroy(ty_diffuse_surfaces* surfaces) {
    const size_t count = surfaces->count;
    ty_free_array(surfaces->context, surfaces->staircase, count, sizeof(float));
    ty_free_array(surfaces->context, surfaces->unlit, surfaces->cells, 1);
    for (int c = 0; c < 3; ++c) {
        ty_free_array(surfaces->context, surfaces->albedo[c], count, sizeof(float));
        ty_free_array(surfaces->context, surfaces->radiosity[c], count, sizeof(float));
        ty_free_array(surfaces->context, surfaces->forward[c], count, sizeof(float));
    }
    ty_boundary_faces_destroy(surfaces->faces);
    *surfaces = (ty_diffuse_surfaces){.faces = NULL};
}

double ty_diffuse_surfaces_flux_factor(const ty_diffuse_surfaces* surfaces) {
    double sum = 0;
    for (int c = 0; c < 3; ++c)
        for (size_t i = 0; i < surfaces->count; ++i) sum += (double)surfaces->albedo[c][i] / 3;
    return surfaces->count > 0 ? 1 - 0.5 * sum / (double)surfaces->count : 1;
}

static bool are_equal(float a, float b) {
    return fabsf(a - b) <= max_difference * ty_maxf(a, b);
}

bool ty_diffuse_surfaces_are_multiple(const ty_diffuse_surfaces* surfaces, int32_t channel, int32_t of, float factor) {
    for (size_t i = 0; i < surfaces->count; ++i)
        if (!are_equal(surfaces->albedo[channel][i], surfaces->albedo[of][i]) ||
            !are_equal(surfaces->radiosity[channel][i], factor * surfaces->radiosity[of][i]) ||
            !are_equal(surfaces->forward[channel][i], factor * surfaces->forward[of][i]))
            return false;
    return true;
}

bool ty_diffuse_surfaces_are_dark(const ty_diffuse_surfaces* surfaces, int32_t channel) {
    for (size_t i = 0; i < surfaces->count; ++i)
        if (surfaces->radiosity[channel][i] > 0) return false;
    return true;
}

ty_diffusion_faces ty_diffuse_surfaces_faces(const ty_diffuse_surfaces* surfaces, int32_t channel,
                                             bool with_radiosity) {
    const ty_boundary_faces* faces = surfaces->faces;
    return (ty_diffusion_faces){.count = faces->count,
                                .first = faces->first,
                                .x = faces->x,
                                .face = faces->face,
                                .closed = faces->closed,
                                .albedo = surfaces->albedo[channel],
                                .radiosity = with_radiosity ? surfaces->radiosity[channel] : NULL,
                                .staircase = surfaces->staircase};
}
