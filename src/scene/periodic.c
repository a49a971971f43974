#include "scene/periodic.h"

#include "base/check.h"
#include "base/context.h"
#include "scene/media/medium.h"

#include <math.h>
#include <string.h>

void ty_init_periodic_def(void* def, size_t bytes) {
    const ty_periodic_def own = {.axes = {false, false, false}};
    ty_init_def(def, bytes, &own, sizeof own);
}

ty_result ty_scene_set_periodic(ty_scene* scene, const ty_periodic_def* def) {
    ty_periodic_def own = ty_default_periodic_def();
    ty_result result = ty_take_def(scene->context, def, "ty_default_periodic_def", &own, sizeof own);
    if (result == TY_OK) result = ty_check_point(scene->context, "periodic.cell[0]", own.lower);
    if (result == TY_OK) result = ty_check_point(scene->context, "periodic.cell[1]", own.upper);
    if (result != TY_OK) return result;
    if (own.axes[0] && own.axes[1] && own.axes[2])
        return ty_fail(scene->context, TY_ERROR_ARGUMENT,
                       "periodic: a scene that repeats along all three axes has no outside for its lights");
    scene->periodic = own;
    scene->committed = false;
    return TY_OK;
}

void ty_scene_copy_periodic(const ty_scene* scene, void* out, size_t bytes) {
    ty_periodic_def own = ty_default_periodic_def();
    memcpy(own.axes, scene->periodic.axes, sizeof own.axes);
    const bool repeats = own.axes[0] || own.axes[1] || own.axes[2];
    for (int a = 0; a < 3 && repeats; ++a) {
        own.lower[a] = scene->committed ? (double)scene->view.periodic.lower[a] : scene->periodic.lower[a];
        own.upper[a] = scene->committed ? (double)scene->view.periodic.upper[a] : scene->periodic.upper[a];
    }
    ty_init_def(out, bytes, &own, sizeof own);
}

ty_result ty_periodic_find_cell(ty_context* context, const ty_periodic_def* def, const ty_medium_def* media,
                                size_t count, ty_periodic_view* out) {
    double lower[3] = {INFINITY, INFINITY, INFINITY}, upper[3] = {-INFINITY, -INFINITY, -INFINITY};
    memset(out, 0, sizeof *out);
    for (size_t i = 0; i < count; ++i) ty_medium_voxel_extent(&media[i], lower, upper);
    for (int a = 0; a < 3; ++a) {
        if (!def->axes[a]) continue;
        if (def->upper[a] > def->lower[a]) {
            lower[a] = def->lower[a];
            upper[a] = def->upper[a];
        }
        if (!(upper[a] > lower[a]) || !(upper[a] - lower[a] < 1e12))
            return ty_fail(context, TY_ERROR_ARGUMENT, "periodic: cell: without media the cell along %c must be given",
                           "xyz"[a]);
        out->axes |= 1 << a;
        out->lower[a] = (float)lower[a];
        out->upper[a] = (float)upper[a];
    }
    return TY_OK;
}

void ty_periodic_bound_cell(const ty_scene* scene, ty_periodic_view* cell) {
    double lower[3], upper[3];
    if (cell->axes == 0) return;
    ty_scene_extent(scene, lower, upper);
    for (int a = 0; a < 3; ++a) {
        if ((cell->axes >> a & 1) != 0) continue;
        /* Room for the rounding of coordinates, and of rays that begin on a face. */
        const double room = 1e-3 * (upper[a] - lower[a]) + 1e-5 * fmax(fabs(lower[a]), fabs(upper[a])) + 1e-6;
        cell->lower[a] = (float)(lower[a] - room);
        cell->upper[a] = (float)(upper[a] + room);
    }
}

ty_result ty_periodic_check(const ty_scene* scene, const ty_periodic_view* cell, const ty_committed_lights* lights,
                            const ty_committed_interiors* interiors) {
    if (cell->axes == 0) return TY_OK;
    if (lights->set.distant_count < lights->set.count)
        return ty_fail(scene->context, TY_ERROR_ARGUMENT,
                       "periodic: lamps and glowing surfaces do not repeat; a periodic scene takes directional and "
                       "environment lights, and media that emit");
    if (interiors->count > 0)
        return ty_fail(scene->context, TY_ERROR_ARGUMENT,
                       "periodic: a periodic scene takes no dielectrics and no panes");
    return TY_OK;
}

ty_result ty_scene_check_open(const ty_scene* scene, const char* method) {
    const ty_periodic_def* def = &scene->periodic;
    if (!def->axes[0] && !def->axes[1] && !def->axes[2]) return TY_OK;
    return ty_fail(scene->context, TY_ERROR_ARGUMENT, "periodic: %s takes no periodic scenes; the method path does",
                   method);
}
