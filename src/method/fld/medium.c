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

ty_result ty_fld_sample_media(ty_fld_job* job) {
    ty_grid_box box;
    ty_result result = ty_grid_box_fit(job->scene, ty_grid_box_longest(job->scene, job->def->resolution), &box);
    if (result == TY_OK) result = ty_grid_medium_create(job->scene, &box, &job->fine);
    if (result != TY_OK) return result;
    const double ratio = choose_ratio(job->def, box.size);
    int32_t size[3];
    for (int a = 0; a < 3; ++a) size[a] = (int32_t)fmax(1, lround(box.size[a] / ratio));
    result = ty_grid_medium_resize(job->fine, size, &job->coarse);
    if (result != TY_OK) return result;
    job->light->direct_box = box;
    memcpy(job->stats.direct_size, box.size, sizeof box.size);
    memcpy(job->stats.diffusion_size, size, sizeof size);
    job->stats.planes = job->fine->planes;
    return TY_OK;
}
