/* The dielectrics around a point, on devices: as interiors.c finds them, by one closest hit after another. */
#ifndef TY_SCENE_INTERIORS_WALK_K_H
#define TY_SCENE_INTERIORS_WALK_K_H

#include "scene/interiors.h"

/* Hits that are looked at, and different boundaries among them. */
enum { TY_INTERIORS_STEPS = 256, TY_INTERIORS_MET = 16 };

TY_FN_APART void ty_interiors_around(const ty_scene_view* scene, ty_vec point, ty_interior_list* out) {
    const ty_vec direction = ty_vec_make(0.26726124f, 0.80178373f, -0.53452248f); /* along no edge that is likely */
    int32_t met[TY_INTERIORS_MET], met_count = 0;
    out->top = out->count = 0;
    for (int32_t step = 0; step < TY_INTERIORS_STEPS && met_count < TY_INTERIORS_MET; ++step) {
        ty_hit hit;
        if (!ty_accel_intersect(scene->mesh, point, direction, TY_FLOAT_MAX, &hit)) return;
        point = ty_hit_leave(&hit, direction);
        TY_GLOBAL const ty_surface_gloss* gloss = scene->surfaces[hit.surface].gloss;
        if (gloss == NULL || gloss->dielectric.solid == 0) continue;
        bool known = false;
        for (int32_t i = 0; i < met_count; ++i) known = known || met[i] == hit.surface;
        if (known) continue;
        met[met_count++] = hit.surface;
        if (ty_dot(hit.normal, direction) > 0.0f)
            ty_interior_list_enter(scene->interiors, gloss->dielectric.interior, out);
    }
}

#endif
