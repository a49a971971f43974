/* Fields of diffuse light: without surfaces the light's own arrays; with them copies, in which neither light behind a
 * surface nor the dark inside of a solid is left where interpolation for the eye reads it. */
#include "method/diffuse/view.h"

#include "base/context.h"
#include "image/march/hidden_cells.h"
#include "scene/scene.h"

#include <string.h>

static ty_result copy_terms(ty_diffuse_view* view, ty_source_field* field, const ty_cuts* cuts,
                            float* copies[3][TY_FIELD_TERMS], float* const* added) {
    if (added != NULL) field->shared = false;
    for (int c = 0; c < (field->shared ? 1 : 3); ++c)
        for (int t = 0; t < field->term_count; ++t) {
            float* copy = ty_alloc_array(view->context, view->cells, sizeof(float), false);
            copies[c][t] = copy;
            if (copy == NULL) return TY_ERROR_MEMORY;
            memcpy(copy, field->terms[c][t], view->cells * sizeof(float));
            for (size_t i = 0; i < view->cells && added != NULL && t == 0; ++i) copy[i] += added[c][i];
            ty_hidden_cells_fill(view->context, &field->box, cuts, view->hidden, copy);
            field->terms[c][t] = copy;
        }
    return TY_OK;
}

static ty_result make_between(const ty_diffuse_light* light, const ty_scene* scene, const double* eye,
                              float* const* added, ty_diffuse_view* view) {
    view->surfaces = ty_diffuse_light_surface_field(light);
    ty_result result = ty_cuts_find(light->context, light->faces, &light->box, &view->cuts);
    if (result == TY_OK && eye != NULL)
        result = ty_hidden_cells_find(light->context, scene, &light->box, eye, &view->hidden);
    if (result == TY_OK) result = copy_terms(view, &view->media, view->cuts, view->media_terms, added);
    if (result == TY_OK) result = copy_terms(view, &view->surfaces, NULL, view->surface_terms, NULL);
    return result;
}

ty_result ty_diffuse_view_make(const ty_diffuse_light* light, const ty_scene* scene, const double* eye,
                               float* const* added, ty_diffuse_view* out) {
    const bool directed = ty_scene_get_view(scene)->mesh != NULL;
    *out = (ty_diffuse_view){.context = light->context, .cells = light->cells};
    out->media = ty_diffuse_light_field(light, directed);
    out->surfaces = out->media;
    if (light->faces != NULL) return make_between(light, scene, eye, added, out);
    return added != NULL ? copy_terms(out, &out->media, NULL, out->media_terms, added) : TY_OK;
}

void ty_diffuse_view_free(ty_diffuse_view* view) {
    ty_cuts_destroy(view->cuts);
    ty_free_array(view->context, view->hidden, view->cells, 1);
    for (int c = 0; c < 3; ++c)
        for (int t = 0; t < TY_FIELD_TERMS; ++t) {
            ty_free_array(view->context, view->media_terms[c][t], view->cells, sizeof(float));
            ty_free_array(view->context, view->surface_terms[c][t], view->cells, sizeof(float));
        }
}
