/* Delta-scaled media. */
#include "method/lpv/lattice/reduced_media.h"

#include "base/context.h"

static bool any_above(const float* g, size_t count) {
    for (size_t i = 0; i < count; ++i)
        if (g[i] > TY_REDUCED_G_MAX) return true;
    return false;
}

static ty_result reduce_cells(const ty_grid_medium* medium, ty_grid_medium** out) {
    const ty_result result = ty_grid_medium_resize(medium, medium->box.size, out);
    if (result != TY_OK) return result;
    for (int32_t c = 0; c < medium->planes; ++c)
        for (size_t i = 0; i < medium->cells; ++i) {
            const float forward = ty_reduced_forward_fraction(medium->g[c][i]) * medium->scattering[c][i];
            (*out)->extinction[c][i] = medium->extinction[c][i] - forward;
            (*out)->scattering[c][i] = medium->scattering[c][i] - forward;
            (*out)->g[c][i] = ty_reduced_g(medium->g[c][i]);
        }
    return TY_OK;
}

static ty_result reduce_views(const ty_scene* scene, ty_reduced_media* out) {
    const ty_scene_view* view = &scene->view;
    out->views = ty_alloc_array(scene->context, (size_t)view->medium_count, sizeof *out->views, false);
    if (out->views == NULL) return TY_ERROR_MEMORY;
    out->view_count = view->medium_count;
    memcpy(out->views, view->media, (size_t)view->medium_count * sizeof *out->views);
    for (int32_t m = 0; m < view->medium_count; ++m)
        for (int c = 0; c < 3 && view->media[m].heterogeneous == 0; ++c) {
            const float forward = ty_reduced_forward_fraction(view->media[m].g[c]) * view->media[m].sigma_s[c];
            out->views[m].sigma_t[c] -= forward;
            out->views[m].sigma_s[c] -= forward;
            if (out->views[m].sigma_t[c] != out->views[m].sigma_t[0]) out->views[m].gray = 0;
        }
    return TY_OK;
}

ty_result ty_reduced_media_create(const ty_scene* scene, const ty_grid_medium* medium, ty_reduced_media* out) {
    bool any = false;
    *out = (ty_reduced_media){.medium = NULL};
    for (int32_t c = 0; c < medium->planes; ++c) any = any || any_above(medium->g[c], medium->cells);
    if (!any) return TY_OK;
    ty_result result = reduce_cells(medium, &out->medium);
    if (result == TY_OK) result = reduce_views(scene, out);
    if (result != TY_OK) ty_reduced_media_destroy(scene->context, out);
    return result;
}

void ty_reduced_media_destroy(ty_context* context, ty_reduced_media* media) {
    ty_grid_medium_destroy(media->medium);
    ty_free_array(context, media->views, (size_t)media->view_count, sizeof *media->views);
    *media = (ty_reduced_media){.medium = NULL};
}
