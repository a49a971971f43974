/* Placement of the lattices. */
#include "base/context.h"
#include "method/lpv/lattice/lattice.h"
#include "scene/media/medium.h"
#include "scene/scene.h"

/* Relative margin of a lattice around the scene's extent, so that surfaces on its faces are inside. */
static const double margin = 1e-3;

/* The extent of media and surfaces; false if there are none. */
static bool find_extent(const ty_scene* scene, const ty_scene_view* view, double lower[3], double upper[3]) {
    for (int a = 0; a < 3; ++a) {
        lower[a] = INFINITY;
        upper[a] = -INFINITY;
    }
    if (view->mesh != NULL) ty_scene_surface_extent(scene, lower, upper);
    for (size_t m = 0; m < scene->medium_count; ++m) ty_medium_extent(&scene->media[m], lower, upper);
    return lower[0] <= upper[0];
}

static void set_upper(ty_grid_box* box, double cell) {
    for (int a = 0; a < 3; ++a) box->upper[a] = box->lower[a] + cell * box->size[a];
}

/* Scenes that fill less than this fraction of a cube are flat. */
static const double flat = 0.25;

/* Number of cells along the longest side of a box. In a flat scene, a landscape, whose media fill less than half of
 * its length, the media have `resolution` cells along theirs as far as no more than resolution^3 cells are needed. */
static int32_t cells_along(const ty_scene* scene, const double lower[3], const double upper[3], int32_t resolution) {
    double from[3] = {INFINITY, INFINITY, INFINITY}, to[3] = {-INFINITY, -INFINITY, -INFINITY};
    double longest = 0, media = 0, filled = 1;
    for (size_t m = 0; m < scene->medium_count; ++m) ty_medium_extent(&scene->media[m], from, to);
    for (int a = 0; a < 3; ++a) {
        longest = fmax(longest, upper[a] - lower[a]);
        media = fmax(media, to[a] - from[a]);
    }
    for (int a = 0; a < 3; ++a) filled *= fmax((upper[a] - lower[a]) / longest, 1.0 / resolution);
    if (!(media > 0 && 2 * media < longest && filled < flat)) return resolution;
    const double fitting = floor(resolution / cbrt(filled)), wanted = ceil(resolution * longest / media);
    return (int32_t)fmin(fmin(fitting, wanted), TY_LPV_CELLS_MAX);
}

/* The lattice around a whole scene. */
static void place_about(const double lower[3], const double upper[3], int32_t resolution, ty_grid_box* box) {
    double longest = 0;
    for (int a = 0; a < 3; ++a) longest = fmax(longest, upper[a] - lower[a]);
    if (!(longest > 0)) longest = 1;
    const double cell = longest * (1 + margin) / resolution;
    for (int a = 0; a < 3; ++a) {
        const double side = fmin((upper[a] - lower[a]) * (1 + margin), longest * (1 + margin));
        box->size[a] = (int32_t)fmin(resolution, fmax(1, ceil(side / cell - 1e-6)));
        box->lower[a] = 0.5 * (lower[a] + upper[a] - cell * box->size[a]);
    }
    set_upper(box, cell);
}

/* A finer lattice inside another: half as wide, centered on a point as far as it fits, aligned to its own cells. */
static void place_within(const ty_grid_box* outer, const double point[3], ty_grid_box* box) {
    *box = *outer;
    const double cell = 0.5 * (outer->upper[0] - outer->lower[0]) / outer->size[0];
    for (int a = 0; a < 3; ++a) {
        const double before = floor((point[a] - outer->lower[a]) / cell) - box->size[a] / 2;
        box->lower[a] = outer->lower[a] + cell * fmin(fmax(before, 0), outer->size[a]);
    }
    set_upper(box, cell);
}

/* A cube around the camera, aligned to whole cells from the origin of the world. */
static void place_camera(const double camera[3], double extent, int32_t resolution, ty_grid_box* box) {
    const double cell = extent / resolution;
    for (int a = 0; a < 3; ++a) {
        box->size[a] = resolution;
        box->lower[a] = cell * (floor(camera[a] / cell) - resolution / 2);
    }
    set_upper(box, cell);
}

ty_result ty_lattice_place(const ty_scene* scene, const ty_lpv_def* def, ty_grid_box boxes[TY_LPV_CASCADES_MAX],
                           int32_t* count) {
    const ty_scene_view* view = ty_scene_get_view(scene);
    if (view == NULL) return TY_ERROR_ARGUMENT;
    *count = def->cascades;
    if (def->place == TY_LPV_PLACE_CAMERA) {
        for (int32_t i = 0; i < def->cascades; ++i)
            place_camera(scene->camera.position, ldexp(def->extent, i), def->resolution, &boxes[i]);
        return TY_OK;
    }
    double lower[3], upper[3];
    if (!find_extent(scene, view, lower, upper))
        return ty_fail(scene->context, TY_ERROR_ARGUMENT, "lpv: the scene has neither media nor surfaces");
    place_about(lower, upper, cells_along(scene, lower, upper, def->resolution), &boxes[def->cascades - 1]);
    for (int32_t i = def->cascades - 2; i >= 0; --i) place_within(&boxes[i + 1], scene->camera.position, &boxes[i]);
    return TY_OK;
}
