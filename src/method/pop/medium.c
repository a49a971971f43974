/* The cells of sharp lights, of ordinates and of the merged grid, and the media on them. */
#include "base/context.h"
#include "method/pop/job.h"

#include <math.h>
#include <string.h>

/* Voxels along an axis that one cell's sample points tell apart (ty_grid_medium_create). */
enum { VOXELS_SEEN = 8 };

static bool has_voxels_alone(const ty_scene_view* view) {
    for (int32_t m = 0; m < view->medium_count; ++m)
        if (view->media[m].has_grid == 0) return false;
    return true;
}

static bool has_sharp_lights(const ty_pop_job* job) {
    const ty_light_set* lights = &ty_scene_get_view(job->scene)->lights;
    for (int32_t i = 0; i < lights->count; ++i)
        if (ty_pop_is_sharp(job->scene, job->def, i)) return true;
    return false;
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

/* Cells of an ordinate's grid where nothing is asked for: about a third of the voxels, which pictures of clouds lit by
 * the sky need, but so many at least (smooth media) and at most (time). */
enum { OWN_SHARE = 3, OWN_LEAST = 32, OWN_MOST = 48 };

static int32_t own_cells(const ty_pop_def* def, const ty_grid_box* fine) {
    if (def->resolution > 0) return def->resolution;
    if (def->mode != TY_POP_MODE_SPLIT) return OWN_LEAST;
    int32_t cells = OWN_LEAST * OWN_SHARE;
    for (int a = 0; a < 3; ++a) cells = fine->size[a] > cells ? fine->size[a] : cells;
    return cells / OWN_SHARE < OWN_MOST ? cells / OWN_SHARE : OWN_MOST;
}

/* Light of few cells is brought together in finer ones, so that directions mix well; many hold what can be seen. */
static int32_t merged_cells(const ty_pop_def* def, int32_t own) {
    if (def->merged > 0) return def->merged;
    if (def->mode != TY_POP_MODE_SPLIT) return own * 2;
    const int32_t finer = own * 3 / 2 < OWN_MOST ? own * 3 / 2 : OWN_MOST;
    return finer > own ? finer : own;
}

/* Whether merged cells cannot be sampled from the scene as exactly as from fine cells: these are voxels, unless
 * `longest` cells cut them off. */
static bool needs_fine(const ty_pop_job* job, int32_t longest, const int32_t merged[3]) {
    if (!has_voxels_alone(ty_scene_get_view(job->scene)) || has_sharp_lights(job)) return true;
    const int32_t* voxels = job->light->fine_box.size;
    for (int a = 0; a < 3; ++a)
        if (voxels[a] < merged[a] || voxels[a] >= longest || voxels[a] > VOXELS_SEEN * merged[a]) return true;
    return false;
}

static ty_result sample_merged(ty_pop_job* job, const int32_t merged[3]) {
    if (job->fine != NULL) return ty_grid_medium_resize(job->fine, merged, &job->medium);
    ty_grid_box box = job->light->fine_box;
    memcpy(box.size, merged, sizeof box.size);
    return ty_grid_medium_create(job->scene, &box, &job->medium);
}

/* Where merged cells are whole numbers of those that ordinates' grids sample, nothing is lost on the way. */
static ty_result sample_own(ty_pop_job* job, const int32_t own[3]) {
    bool whole = true;
    for (int a = 0; a < 3; ++a) whole = whole && job->medium->box.size[a] % own[a] == 0;
    const ty_grid_medium* from = whole || job->fine == NULL ? job->medium : job->fine;
    return ty_grid_medium_resize(from, own, &job->light->medium);
}

ty_result ty_pop_sample_media(ty_pop_job* job) {
    const ty_pop_def* def = job->def;
    ty_pop* light = job->light;
    const int32_t longest = ty_grid_box_longest(job->scene, def->direct);
    int32_t merged[3], own[3];
    ty_result result = ty_grid_box_fit(job->scene, longest, &light->fine_box);
    if (result != TY_OK) return result;
    light->def.resolution = own_cells(def, &light->fine_box);
    ty_grid_box_cut(&light->fine_box, merged_cells(def, light->def.resolution), merged);
    ty_grid_box_cut(&light->fine_box, light->def.resolution, own);
    if (needs_fine(job, longest, merged)) result = ty_grid_medium_create(job->scene, &light->fine_box, &job->fine);
    if (result == TY_OK) result = sample_merged(job, merged);
    if (result == TY_OK) result = sample_own(job, own);
    if (!has_sharp_lights(job)) {
        ty_grid_medium_destroy(job->fine);
        job->fine = NULL;
    }
    if (result != TY_OK) return result;
    light->cells = job->medium->cells;
    memcpy(job->stats.merged_size, merged, sizeof merged);
    job->stats.planes = job->medium->planes;
    return take_guide(job);
}
