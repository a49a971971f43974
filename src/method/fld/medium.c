/* The grids of direct light and of diffusion, and the media on them. */
#include "method/fld/job.h"

#include "scene/scene.h"

#include <math.h>
#include <string.h>

enum { RATIO = 3, FEW_RATIO = 2, FEW_CELLS = 48 };

static int32_t longest_side(const int32_t size[3]) {
    const int32_t longest = size[0] > size[1] ? size[0] : size[1];
    return longest > size[2] ? longest : size[2];
}

static double choose_ratio(const ty_fld_def* def, const int32_t size[3]) {
    if (def->ratio > 0) return def->ratio;
    return longest_side(size) >= RATIO * FEW_CELLS ? RATIO : FEW_RATIO;
}

ty_result ty_fld_choose_cells(const ty_scene* scene, const ty_fld_def* def, ty_grid_box* direct, int32_t diffusion[3]) {
    const ty_result result = ty_grid_box_fit(scene, ty_grid_box_longest(scene, def->resolution), direct);
    if (result != TY_OK) return result;
    const double ratio = choose_ratio(def, direct->size);
    for (int a = 0; a < 3; ++a) diffusion[a] = (int32_t)fmax(1, lround(direct->size[a] / ratio));
    return TY_OK;
}

ty_result ty_fld_sample_media(ty_fld_job* job) {
    ty_grid_box box;
    int32_t size[3];
    ty_result result = ty_fld_choose_cells(job->scene, job->def, &box, size);
    if (result == TY_OK) result = ty_grid_medium_create(job->scene, &box, &job->fine);
    if (result == TY_OK) result = ty_grid_medium_resize(job->fine, size, &job->coarse);
    if (result != TY_OK) return result;
    job->light->direct_box = box;
    memcpy(job->stats.direct_size, box.size, sizeof box.size);
    memcpy(job->stats.diffusion_size, size, sizeof size);
    job->stats.planes = job->fine->planes;
    return TY_OK;
}
