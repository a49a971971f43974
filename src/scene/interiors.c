#include "scene/interiors.h"

#include "base/context.h"
#include "scene/surfaces/closed_mesh.h"
#include "scene/media/medium.h"
#include "scene/surfaces/shape.h"

#include <math.h>
#include <string.h>

/* Bounds and surfaces coincide if their points are no farther apart than this part of their size. */
static const double coincidence = 1e-5;

/* ---- media that fill a dielectric ---- */

/* True if a box shape is the box of the medium's bounds. */
static bool same_boxes(const ty_affine* bounds, const ty_shape_def* shape) {
    double center[3], half[3], size = 0, difference = 0;
    const double none[3] = {0, 0, 0};
    for (int a = 0; a < 3; ++a) {
        center[a] = (shape->origin[a] + shape->u[a]) / 2;
        half[a] = (shape->u[a] - shape->origin[a]) / 2;
    }
    const ty_affine local = ty_affine_compose(center, none, half);
    const ty_affine place = ty_affine_multiply(&shape->transform, &local);
    for (int i = 0; i < 12; ++i) {
        if (i % 4 != 3) size = fmax(size, fabs(place.m[i]));
        difference = fmax(difference, fabs(bounds->m[i] - place.m[i]));
    }
    return difference <= coincidence * size;
}

/* True if a sphere is the image of the unit sphere by the medium's bounds. */
static bool same_spheres(const ty_affine* bounds, const ty_shape_def* shape) {
    double center[3];
    const double radius = ty_shape_sphere(shape, center);
    for (int a = 0; a < 3; ++a) {
        const double* m = bounds->m + a;
        const double length = sqrt(m[0] * m[0] + m[4] * m[4] + m[8] * m[8]);
        if (fabs(length - radius) > coincidence * radius ||
            fabs(bounds->m[4 * a + 3] - center[a]) > coincidence * radius)
            return false;
    }
    return true;
}

static bool fills_shape(const ty_medium_def* medium, const ty_shape_def* shape) {
    const bool sphere = shape->kind == TY_SHAPE_SPHERE && medium->bounds == TY_BOUNDS_SPHERE;
    if (!sphere && (shape->kind != TY_SHAPE_BOX || medium->bounds != TY_BOUNDS_BOX)) return false;
    const ty_affine bounds = ty_medium_bounds_map(medium);
    return sphere ? same_spheres(&bounds, shape) : same_boxes(&bounds, shape);
}

/* True if a closed mesh has the triangles of a surface, in their order. */
static bool fills_mesh(const ty_medium_def* medium, const ty_triangle_mesh* mesh) {
    if (medium->bounds != TY_BOUNDS_SHELL) return false;
    const ty_triangle_mesh* shell = medium->shell->triangles;
    if (shell->triangle_count != mesh->triangle_count) return false;
    double size = 0;
    for (int a = 0; a < 3; ++a) size = fmax(size, mesh->upper[a] - mesh->lower[a]);
    for (size_t i = 0; i < 3 * mesh->triangle_count; ++i) {
        const float *own = shell->positions + 3 * (size_t)shell->indices[i],
                    *other = mesh->positions + 3 * (size_t)mesh->indices[i];
        double point[3] = {(double)own[0], (double)own[1], (double)own[2]};
        ty_affine_point(&medium->transform, point, point);
        for (int a = 0; a < 3; ++a)
            if (fabs(point[a] - (double)other[a]) > coincidence * size) return false;
    }
    return true;
}

static bool fills(const ty_interiors_input* input, size_t medium, size_t surface) {
    const size_t shapes = input->surfaces->shape_count;
    const ty_medium_def* def = &input->defs[medium];
    return surface < shapes ? fills_shape(def, &input->surfaces->shapes[surface])
                            : fills_mesh(def, input->meshes[surface - shapes]);
}

/* ---- interiors ---- */

/* The dielectric of a surface; NULL: none. */
static ty_dielectric* dielectric_of(const ty_committed_surfaces* surfaces, size_t i) {
    ty_surface_gloss* gloss = (ty_surface_gloss*)surfaces->surfaces[i].gloss; /* one of surfaces->gloss */
    return gloss != NULL && gloss->dielectric.solid != 0 ? &gloss->dielectric : NULL;
}

/* True for a smooth thin wall of one layer, which emits nothing. */
static bool is_pane(const ty_surface* surface) {
    const ty_surface_gloss* gloss = surface->gloss;
    if (gloss == NULL || gloss->dielectric.solid != 0 || gloss->textured != 0) return false;
    const ty_bsdf_parameters* p = &gloss->factor;
    for (int c = 0; c < 3; ++c)
        if (p->sheen_color[c] > 0 || surface->emission[c] > 0) return false;
    return p->transmission > 0 && p->metallic < 1 && !(p->roughness > 0) && !(p->clearcoat > 0);
}

/* Marks them, and returns their number. */
static size_t mark_panes(const ty_committed_surfaces* surfaces) {
    size_t count = 0;
    for (size_t i = 0; i < surfaces->count; ++i) {
        ty_surface_gloss* gloss = (ty_surface_gloss*)surfaces->surfaces[i].gloss; /* one of surfaces->gloss */
        if (gloss == NULL) continue;
        gloss->pane = is_pane(&surfaces->surfaces[i]);
        count += gloss->pane != 0;
    }
    return count;
}

/* Where alpha leaves holes, nothing is solid. */
static void drop_perforated(const ty_committed_surfaces* surfaces) {
    for (size_t i = 0; i < surfaces->count; ++i) {
        ty_dielectric* dielectric = dielectric_of(surfaces, i);
        if (dielectric != NULL && surfaces->surfaces[i].alpha_mode != TY_ALPHA_OPAQUE) dielectric->solid = 0;
    }
}

/* The absorption of a dielectric, as a medium without bounds. */
static bool add_absorption(const ty_dielectric* dielectric, ty_medium_view* out) {
    memset(out, 0, sizeof *out);
    for (int c = 0; c < 3; ++c) {
        out->sigma_t[c] = dielectric->sigma_a[c];
        out->sigma_t_max = fmaxf(out->sigma_t_max, dielectric->sigma_a[c]);
    }
    out->gray = out->sigma_t[0] == out->sigma_t[1] && out->sigma_t[1] == out->sigma_t[2];
    out->gray_g = 1;
    return out->sigma_t_max > 0;
}

/* True if the bounds of a medium lie within the box around a surface. */
static bool is_within(const ty_interiors_input* input, size_t medium, size_t surface) {
    double box[2][3] = {{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}};
    double own[2][3] = {{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}};
    ty_medium_extent(&input->defs[medium], own[0], own[1]);
    if (surface < input->surfaces->shape_count)
        ty_shape_extent(&input->surfaces->shapes[surface], box[0], box[1]);
    else
        for (int a = 0; a < 3; ++a) {
            box[0][a] = input->meshes[surface - input->surfaces->shape_count]->lower[a];
            box[1][a] = input->meshes[surface - input->surfaces->shape_count]->upper[a];
        }
    for (int a = 0; a < 3; ++a) {
        const double near = coincidence * (box[1][a] - box[0][a]);
        if (own[0][a] < box[0][a] - near || own[1][a] > box[1][a] + near) return false;
    }
    return true;
}

/* The media in an interior: those that fill it, which its surface bounds, and others that are not larger than it. All
 * that fill no dielectric are outside. */
static void add_media(const ty_interiors_input* input, ty_interior* interior, ty_medium_view* room) {
    for (size_t m = 0; m < input->media->count; ++m) {
        const ty_medium_view* view = &input->media->views[m];
        const bool filling = view->dielectric != 0, outside = interior->surface < 0;
        if (filling && view->dielectric != interior->surface + 1) continue;
        if (!filling && !outside && !is_within(input, m, (size_t)interior->surface)) continue;
        ty_medium_view* own = &room[interior->medium_count++];
        *own = *view;
        if (filling) own->bounds = TY_BOUNDED_NOT;
        for (int c = 0; c < 3; ++c) interior->scatters |= view->sigma_s[c] > 0 || view->emits != 0;
    }
}

static void warn_if_open(ty_context* context, const ty_interiors_input* input, size_t surface) {
    if (surface < input->surfaces->shape_count) return;
    const ty_triangle_mesh* mesh = input->meshes[surface - input->surfaces->shape_count];
    const size_t open = ty_count_open_edges(context, mesh);
    if (open > 0 && open != SIZE_MAX)
        ty_log(context, TY_LOG_WARNING,
               "the boundary of a solid dielectric%s%s is not closed: %zu of its edges do not join two triangles",
               mesh->origin.name != NULL ? ", " : "", mesh->origin.name != NULL ? mesh->origin.name : "", open);
}

ty_result ty_interiors_create(ty_context* context, const ty_interiors_input* input, bool warns,
                              ty_committed_interiors* out) {
    const ty_committed_surfaces* surfaces = input->surfaces;
    size_t count = 0;
    drop_perforated(surfaces);
    for (size_t i = 0; i < surfaces->count; ++i) count += dielectric_of(surfaces, i) != NULL;
    const size_t panes = mark_panes(surfaces);
    if (count + panes == 0) return TY_OK;
    out->count = count + 1;
    out->medium_capacity = out->count * (input->media->count + 1);
    out->interiors = ty_alloc_array(context, out->count, sizeof *out->interiors, true);
    out->media = ty_alloc_array(context, out->medium_capacity, sizeof *out->media, true);
    if (out->interiors == NULL || out->media == NULL) return TY_ERROR_MEMORY;
    for (size_t m = 0; m < input->media->count; ++m) {
        int32_t* dielectric = &input->media->views[m].dielectric;
        *dielectric = 0;
        for (size_t i = 0; i < surfaces->count && *dielectric == 0; ++i)
            if (dielectric_of(surfaces, i) != NULL && fills(input, m, i)) *dielectric = (int32_t)i + 1;
    }
    out->interiors[0] = (ty_interior){.media = out->media, .surface = -1, .priority = INT32_MIN, .ior = 1};
    add_media(input, &out->interiors[0], out->media);
    size_t number = 0;
    for (size_t i = 0; i < surfaces->count; ++i) {
        ty_dielectric* dielectric = dielectric_of(surfaces, i);
        if (dielectric == NULL) continue;
        ty_medium_view* room = out->media + ++number * (input->media->count + 1);
        ty_interior* interior = &out->interiors[number];
        *interior = (ty_interior){
            .media = room, .surface = (int32_t)i, .priority = dielectric->priority, .ior = dielectric->ior};
        dielectric->interior = (int32_t)number;
        interior->absorbs = interior->medium_count = add_absorption(dielectric, room);
        add_media(input, interior, room);
        if (warns) warn_if_open(context, input, i);
    }
    return TY_OK;
}

/* True if `surface` is among the first records. */
static bool was_met(const ty_scene_view* scene, const ty_ray* ray, const ty_hit_record* records, int32_t count,
                    int32_t surface) {
    ty_hit hit;
    for (int32_t i = 0; i < count; ++i) {
        ty_accel_complete_hit(scene->mesh, ray, &records[i], &hit);
        if (hit.surface == surface) return true;
    }
    return false;
}

void ty_interiors_around(const ty_scene_view* scene, ty_vec point, ty_interior_list* out) {
    /* A direction along no edge that is likely in a scene. */
    const ty_ray ray = {{point.x, point.y, point.z}, {0.26726124f, 0.80178373f, -0.53452248f}, TY_FLOAT_MAX};
    ty_all_hits hits;
    out->top = out->count = 0;
    ty_accel_all_hits_packet(scene->mesh, &ray, 1, &hits);
    for (int32_t i = 0; i < hits.count[0]; ++i) {
        ty_hit hit;
        ty_accel_complete_hit(scene->mesh, &ray, &hits.layer[0][i], &hit);
        const ty_surface_gloss* gloss = scene->surfaces[hit.surface].gloss;
        if (gloss == NULL || gloss->dielectric.solid == 0) continue;
        const bool leaves =
            hit.normal.x * ray.direction[0] + hit.normal.y * ray.direction[1] + hit.normal.z * ray.direction[2] > 0;
        if (leaves && !was_met(scene, &ray, hits.layer[0], i, hit.surface))
            ty_interior_list_enter(scene->interiors, gloss->dielectric.interior, out);
    }
}

void ty_interiors_warn(const ty_scene* scene, const char* method, const char* does) {
    if (scene->view.interior_count > 1) ty_log(scene->context, TY_LOG_WARNING, "%s: %s", method, does);
}

void ty_interiors_destroy(ty_context* context, ty_committed_interiors* interiors) {
    ty_free_array(context, interiors->interiors, interiors->count, sizeof *interiors->interiors);
    ty_free_array(context, interiors->media, interiors->medium_capacity, sizeof *interiors->media);
    *interiors = (ty_committed_interiors){.interiors = NULL};
}
