/* The cells of sharp lights, of ordinates and of the merged grid, and the media on them. */
#include "base/context.h"
#include "method/pop/job.h"

#include <math.h>
#include <string.h>

enum { VOXELS_MAX = 256, SMOOTH_CELLS = 64 };

static bool has_voxels(const ty_scene_view* view) {
    for (int32_t m = 0; m < view->medium_count; ++m)
        if (view->media[m].has_grid != 0) return true;
    return false;
}

static bool has_sharp_lights(const ty_pop_job* job) {
    const ty_light_set* lights = &ty_scene_get_view(job->scene)->lights;
    for (int32_t i = 0; i < lights->count; ++i)
        if (ty_pop_is_sharp(job->scene, job->def, i)) return true;
    return false;
}

/* The size of a box in about cubic cells, so many along its longest side. */
static void cut_box(const ty_grid_box* box, int32_t longest, int32_t size[3]) {
    double most = 0;
    for (int a = 0; a < 3; ++a) most = fmax(most, box->upper[a] - box->lower[a]);
    for (int a = 0; a < 3; ++a) size[a] = (int32_t)fmax(1, lround(longest * (box->upper[a] - box->lower[a]) / most));
}

static ty_result take_guide(ty_pop_job* job) {
    const ty_grid_medium* medium = job->medium;
    ty_pop* light = job->light;
    light->guide = ty_alloc_array(job->context, light->cells, sizeof(float), true);
    if (light->guide == NULL) return TY_ERROR_MEMORY;
    for (int32_t p = 0; p < medium->planes; ++p)
        for (size_t i = 0; i < light->cells; ++i) light->guide[i] += medium->extinction[p][i] / (float)medium->planes;
    return TY_OK;
}

static int32_t merged_cells(const ty_pop_def* def) {
    if (def->merged > 0) return def->merged;
    return def->mode == TY_POP_MODE_SPLIT ? def->resolution * 3 / 2 : def->resolution * 2;
}

/* Merged cells, and those that ordinates' grids sample. */
static ty_result resize_media(ty_pop_job* job, const ty_grid_medium* from) {
    const ty_pop_def* def = job->def;
    ty_pop* light = job->light;
    int32_t merged[3], own[3];
    cut_box(&from->box, merged_cells(def), merged);
    cut_box(&from->box, def->resolution, own);
    ty_result result = ty_grid_medium_resize(from, merged, &job->medium);
    if (result == TY_OK) result = ty_grid_medium_resize(from, own, &light->medium);
    if (result != TY_OK) return result;
    light->cells = job->medium->cells;
    memcpy(job->stats.merged_size, merged, sizeof merged);
    job->stats.planes = job->medium->planes;
    return take_guide(job);
}

ty_result ty_pop_sample_media(ty_pop_job* job) {
    const ty_scene_view* view = ty_scene_get_view(job->scene);
    const ty_pop_def* def = job->def;
    int32_t longest = def->direct;
    if (longest == 0) longest = has_voxels(view) ? VOXELS_MAX : SMOOTH_CELLS;
    ty_grid_medium* fine = NULL;
    ty_result result = ty_grid_box_fit(job->scene, longest, &job->light->fine_box);
    if (result == TY_OK) result = ty_grid_medium_create(job->scene, &job->light->fine_box, &fine);
    if (result == TY_OK) result = resize_media(job, fine);
    if (result == TY_OK && has_sharp_lights(job)) {
        job->fine = fine;
        return TY_OK;
    }
    ty_grid_medium_destroy(fine);
    return result;
}
