/* Sizes of the fine, ordinates' and merged grids, and the media sampled on them. */
#include "base/context.h"
#include "method/pop/job.h"

#include <string.h>

/* Voxels along an axis that the sample points of one cell resolve (ty_grid_medium_create). */
enum { VOXELS_RESOLVED = 8 };

static bool all_media_are_grids(const ty_scene_view* view) {
    for (int32_t m = 0; m < view->medium_count; ++m)
        if (view->media[m].has_grid == 0) return false;
    return true;
}

static bool has_fine_lights(const ty_pop_job* job) {
    const ty_light_set* lights = &ty_scene_get_view(job->scene)->lights;
    for (int32_t i = 0; i < lights->count; ++i)
        if (ty_pop_uses_fine_grid(job->scene, job->def, i)) return true;
    return false;
}

static ty_result make_guide(ty_pop_job* job) {
    const ty_grid_medium* medium = job->medium;
    ty_pop* light = job->light;
    light->guide = ty_alloc_array(job->context, light->cells, sizeof(float), true);
    if (light->guide == NULL) return TY_ERROR_MEMORY;
    for (int32_t p = 0; p < medium->planes; ++p)
        for (size_t i = 0; i < light->cells; ++i) light->guide[i] += medium->extinction[p][i] / (float)medium->planes;
    return TY_OK;
}

/* Default resolution of an ordinate's grid: a third of the voxels, which images of clouds under a sky need, within
 * limits for smooth media (minimum) and time (maximum). */
enum { VOXELS_PER_CELL = 3, MIN_CELLS = 32, MAX_CELLS = 48 };

static int32_t ordinate_cells(const ty_pop_def* def, const ty_grid_box* fine) {
    if (def->resolution > 0) return def->resolution;
    if (def->mode != TY_POP_MODE_SPLIT) return MIN_CELLS;
    int32_t cells = MIN_CELLS * VOXELS_PER_CELL;
    for (int a = 0; a < 3; ++a) cells = fine->size[a] > cells ? fine->size[a] : cells;
    return cells / VOXELS_PER_CELL < MAX_CELLS ? cells / VOXELS_PER_CELL : MAX_CELLS;
}

/* Coarse grids are merged on finer cells, where directions mix well; fine ones resolve all visible detail already. */
static int32_t merged_cells(const ty_pop_def* def, int32_t ordinate_size) {
    if (def->merged > 0) return def->merged;
    if (def->mode != TY_POP_MODE_SPLIT) return ordinate_size * 2;
    const int32_t refined = ordinate_size * 3 / 2 < MAX_CELLS ? ordinate_size * 3 / 2 : MAX_CELLS;
    return refined > ordinate_size ? refined : ordinate_size;
}

/* True if merged cells need the fine medium as their source. Direct sampling is as exact only for grid media whose
 * fine cells are voxels, which a limit of `longest` cells prevents. */
static bool needs_fine_medium(const ty_pop_job* job, int32_t longest, const int32_t merged[3]) {
    if (!all_media_are_grids(ty_scene_get_view(job->scene)) || has_fine_lights(job)) return true;
    const int32_t* voxels = job->light->fine_box.size;
    for (int a = 0; a < 3; ++a)
        if (voxels[a] < merged[a] || voxels[a] >= longest || voxels[a] > VOXELS_RESOLVED * merged[a]) return true;
    return false;
}

static ty_result sample_merged(ty_pop_job* job, const int32_t merged[3]) {
    if (job->fine != NULL) return ty_grid_medium_resize(job->fine, merged, &job->medium);
    ty_grid_box box = job->light->fine_box;
    memcpy(box.size, merged, sizeof box.size);
    return ty_grid_medium_create(job->scene, &box, &job->medium);
}

/* The ordinates' medium is averaged from merged cells where these are whole multiples, which is exact. */
static ty_result sample_ordinates(ty_pop_job* job, const int32_t ordinate_size[3]) {
    bool divides = true;
    for (int a = 0; a < 3; ++a) divides = divides && job->medium->box.size[a] % ordinate_size[a] == 0;
    const ty_grid_medium* source = divides || job->fine == NULL ? job->medium : job->fine;
    return ty_grid_medium_resize(source, ordinate_size, &job->light->medium);
}

ty_result ty_pop_sample_media(ty_pop_job* job) {
    const ty_pop_def* def = job->def;
    ty_pop* light = job->light;
    const int32_t longest = ty_grid_box_longest(job->scene, def->direct);
    int32_t merged[3], ordinate_size[3];
    ty_result result = ty_grid_box_fit(job->scene, longest, &light->fine_box);
    if (result != TY_OK) return result;
    light->def.resolution = ordinate_cells(def, &light->fine_box);
    ty_grid_box_cut(&light->fine_box, merged_cells(def, light->def.resolution), merged);
    ty_grid_box_cut(&light->fine_box, light->def.resolution, ordinate_size);
    if (needs_fine_medium(job, longest, merged))
        result = ty_grid_medium_create(job->scene, &light->fine_box, &job->fine);
    if (result == TY_OK) result = sample_merged(job, merged);
    if (result == TY_OK) result = sample_ordinates(job, ordinate_size);
    if (!has_fine_lights(job)) {
        ty_grid_medium_destroy(job->fine);
        job->fine = NULL;
    }
    if (result != TY_OK) return result;
    light->cells = job->medium->cells;
    memcpy(job->stats.merged_size, merged, sizeof merged);
    job->stats.planes = job->medium->planes;
    return make_guide(job);
}
