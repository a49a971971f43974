/* The media of a scene file: each with its bounds, which in other formats are the surfaces whose inside has it. */
#include "io/interchange/conversion.h"

#include "base/context.h"
#include "io/json_text.h"

#include <float.h>
#include <math.h>
#include <string.h>

/* ---- boxes ---- */

static void include_point(double box[2][3], const double point[3]) {
    for (int a = 0; a < 3; ++a) {
        box[0][a] = fmin(box[0][a], point[a]);
        box[1][a] = fmax(box[1][a], point[a]);
    }
}

static void corner_of(const double box[2][3], int number, double out[3]) {
    for (int a = 0; a < 3; ++a) out[a] = box[number >> a & 1][a];
}

static void include_box(double box[2][3], const ty_affine* map, const double added[2][3]) {
    for (int i = 0; i < 8; ++i) {
        double corner[3], point[3];
        corner_of(added, i, corner);
        ty_affine_point(map, corner, point);
        include_point(box, point);
    }
}

static void mesh_box(const ty_model_mesh* mesh, double box[2][3]) {
    for (int a = 0; a < 3; ++a) {
        box[0][a] = DBL_MAX;
        box[1][a] = -DBL_MAX;
    }
    for (size_t i = 0; i < mesh->vertex_count; ++i) {
        const float* p = mesh->positions + 3 * i;
        include_point(box, (const double[3]){(double)p[0], (double)p[1], (double)p[2]});
    }
}

bool ty_conversion_box(const ty_conversion* conversion, double box[2][3]) {
    const ty_affine identity = ty_affine_identity();
    for (int a = 0; a < 3; ++a) {
        box[0][a] = DBL_MAX;
        box[1][a] = -DBL_MAX;
    }
    size_t measured = SIZE_MAX;
    double own[2][3];
    for (size_t i = 0; i < conversion->instance_count; ++i) {
        const ty_conversion_instance* instance = &conversion->instances[i];
        if (instance->mesh != measured) mesh_box(&conversion->meshes[instance->mesh].mesh, own);
        measured = instance->mesh;
        if (conversion->meshes[measured].mesh.vertex_count > 0) include_box(box, &instance->transform, own);
    }
    for (size_t i = 0; i < conversion->sphere_count; ++i) {
        const ty_conversion_sphere* sphere = &conversion->spheres[i];
        for (int a = 0; a < 3; ++a) {
            own[0][a] = sphere->center[a] - sphere->radius;
            own[1][a] = sphere->center[a] + sphere->radius;
        }
        include_box(box, &identity, own);
    }
    for (size_t i = 0; i < conversion->medium_count; ++i)
        if (conversion->media[i].grid) include_box(box, &conversion->media[i].transform, conversion->media[i].box);
    const json_t* position = json_object_get(conversion->camera, "position");
    if (json_array_size(position) == 3)
        include_point(box, (const double[3]){json_number_value(json_array_get(position, 0)),
                                             json_number_value(json_array_get(position, 1)),
                                             json_number_value(json_array_get(position, 2))});
    return box[0][0] <= box[1][0];
}

/* ---- containment ---- */

/* Tells whether a point is on the inner side of a mesh's every triangle, with a tolerance of a millionth of its size.
 */
static bool behind_mesh(const ty_model_mesh* mesh, const ty_affine* map, const double point[3]) {
    for (size_t t = 0; t < mesh->triangle_count; ++t) {
        double p[3][3], normal[3], size = 0, depth = 0, length = 0;
        for (int k = 0; k < 3; ++k) {
            const float* at = mesh->positions + 3 * (size_t)mesh->indices[3 * t + (size_t)k];
            ty_affine_point(map, (const double[3]){(double)at[0], (double)at[1], (double)at[2]}, p[k]);
        }
        for (int a = 0; a < 3; ++a) {
            const int b = (a + 1) % 3, c = (a + 2) % 3;
            normal[a] = (p[1][b] - p[0][b]) * (p[2][c] - p[0][c]) - (p[1][c] - p[0][c]) * (p[2][b] - p[0][b]);
            size = fmax(size, fabs(point[a] - p[0][a]));
            length += normal[a] * normal[a];
        }
        for (int a = 0; a < 3; ++a) depth += normal[a] * (point[a] - p[0][a]);
        if (depth > 1e-6 * size * sqrt(length)) return false;
    }
    return mesh->triangle_count > 0;
}

static bool in_sphere(const ty_conversion_sphere* sphere, const double point[3]) {
    double distance2 = 0;
    for (int a = 0; a < 3; ++a) distance2 += (point[a] - sphere->center[a]) * (point[a] - sphere->center[a]);
    return distance2 <= sphere->radius * sphere->radius * (1 + 1e-6);
}

/* Tells whether one convex surface that has the medium inside contains its whole grid. */
static bool holds_grid(const ty_conversion* conversion, int32_t number) {
    const ty_conversion_medium* medium = &conversion->media[number];
    double corners[8][3];
    for (int i = 0; i < 8; ++i) {
        double corner[3];
        corner_of(medium->box, i, corner);
        ty_affine_point(&medium->transform, corner, corners[i]);
    }
    for (size_t s = 0; s < conversion->sphere_count; ++s) {
        if (conversion->parts[conversion->spheres[s].part].medium != number) continue;
        int count = 0;
        for (int i = 0; i < 8; ++i) count += in_sphere(&conversion->spheres[s], corners[i]);
        if (count == 8) return true;
    }
    for (size_t m = 0; m < conversion->instance_count; ++m) {
        const ty_conversion_mesh* mesh = &conversion->meshes[conversion->instances[m].mesh];
        if (conversion->parts[mesh->part].medium != number) continue;
        int count = 0;
        for (int i = 0; i < 8 && count == i; ++i)
            count += behind_mesh(&mesh->mesh, &conversion->instances[m].transform, corners[i]);
        if (count == 8) return true;
    }
    return false;
}

/* The one mesh that has a medium inside, if there is no other boundary; NULL otherwise. */
static const ty_conversion_instance* only_boundary(const ty_conversion* conversion, int32_t number) {
    const ty_conversion_instance* found = NULL;
    for (size_t i = 0; i < conversion->sphere_count; ++i)
        if (conversion->parts[conversion->spheres[i].part].medium == number) return NULL;
    for (size_t i = 0; i < conversion->instance_count; ++i) {
        if (conversion->parts[conversion->meshes[conversion->instances[i].mesh].part].medium != number) continue;
        if (found != NULL) return NULL;
        found = &conversion->instances[i];
    }
    return found;
}

/* The box that a grid fills within the one surface around it, if that is a box along the axes of the grid. */
static bool cut_box(const ty_conversion* conversion, int32_t number, double box[2][3]) {
    const ty_conversion_medium* medium = &conversion->media[number];
    const ty_conversion_instance* instance = only_boundary(conversion, number);
    ty_affine inverse;
    double around[2][3] = {{0, 0, 0}, {0, 0, 0}};
    if (instance == NULL || !ty_affine_invert(&medium->transform, &inverse)) return false;
    const ty_affine map = ty_affine_multiply(&inverse, &instance->transform);
    const ty_model_mesh* mesh = &conversion->meshes[instance->mesh].mesh;
    for (int pass = 0; pass < 2; ++pass)
        for (size_t i = 0; i < mesh->vertex_count; ++i) {
            const float* at = mesh->positions + 3 * i;
            double p[3];
            ty_affine_point(&map, (const double[3]){(double)at[0], (double)at[1], (double)at[2]}, p);
            for (int a = 0; a < 3; ++a) {
                if (pass == 0) {
                    around[0][a] = i == 0 ? p[a] : fmin(around[0][a], p[a]);
                    around[1][a] = i == 0 ? p[a] : fmax(around[1][a], p[a]);
                } else if (fmin(p[a] - around[0][a], around[1][a] - p[a]) > 1e-5 * (around[1][a] - around[0][a])) {
                    return false;
                }
            }
        }
    for (int a = 0; a < 3; ++a) {
        box[0][a] = fmax(medium->box[0][a], around[0][a]);
        box[1][a] = fmin(medium->box[1][a], around[1][a]);
        if (!(box[1][a] > box[0][a])) return false;
    }
    return mesh->triangle_count == 12;
}

/* ---- media ---- */

static ty_result add(ty_conversion* conversion, json_t* media, const json_t* entry, json_t* bounds,
                     const ty_affine* transform) {
    json_t* medium = json_deep_copy(entry);
    bool done = medium != NULL;
    if (bounds != NULL) done = json_object_set_new(medium, "bounds", bounds) == 0 && done;
    if (transform != NULL)
        done = json_object_set_new(medium, "transform", ty_conversion_transform(transform)) == 0 && done;
    if (json_array_append_new(media, medium) == 0 && done) return TY_OK;
    return ty_fail(conversion->context, TY_ERROR_MEMORY, "%s: not enough memory", conversion->input);
}

static json_t* box_bounds(const double box[2][3]) {
    return json_pack("[o, o]", ty_conversion_vector(box[0], 3), ty_conversion_vector(box[1], 3));
}

static json_t* sphere_bounds(const ty_conversion_sphere* sphere) {
    return json_pack("{s:{s:o, s:o}}", "sphere", "center", ty_conversion_vector(sphere->center, 3), "radius",
                     ty_json_number(sphere->radius));
}

/* Adds the medium's entries with bounds, which are taken over. */
static ty_result add_entries(ty_conversion* conversion, const ty_conversion_medium* medium, json_t* media,
                             json_t* bounds) {
    ty_result result = TY_OK;
    size_t i;
    json_t* entry;
    json_array_foreach(medium->entries, i, entry) if (result == TY_OK) result =
        add(conversion, media, entry, json_incref(bounds), medium->grid ? &medium->transform : NULL);
    json_decref(bounds);
    return result;
}

/* Bounds in the space of a grid, which its transform moves back into the scene. */
static ty_result move_bounds(ty_conversion* conversion, const ty_conversion_medium* medium, json_t* bounds) {
    ty_affine inverse;
    if (!ty_affine_invert(&medium->transform, &inverse))
        return ty_fail(conversion->context, TY_ERROR_INPUT, "%s: the transform of the medium \"%s\" cannot be inverted",
                       conversion->input, medium->name);
    if (json_object_set_new(bounds, "transform", ty_conversion_transform(&inverse)) == 0) return TY_OK;
    return ty_fail(conversion->context, TY_ERROR_MEMORY, "%s: not enough memory", conversion->input);
}

/* The medium in each of the surfaces that have it inside. */
static ty_result add_bounded(ty_conversion* conversion, int32_t number, char* const* files, json_t* media) {
    const ty_conversion_medium* medium = &conversion->media[number];
    ty_result result = TY_OK;
    for (size_t s = 0; s < conversion->sphere_count && result == TY_OK; ++s) {
        if (conversion->parts[conversion->spheres[s].part].medium != number) continue;
        if (medium->grid)
            ty_conversion_approximate(conversion, "medium \"%s\": a sphere cuts its grid, which was left whole",
                                      medium->name);
        result = add_entries(conversion, medium, media,
                             medium->grid ? box_bounds(medium->box) : sphere_bounds(&conversion->spheres[s]));
    }
    for (size_t p = 0; p < conversion->part_count && result == TY_OK; ++p) {
        if (conversion->parts[p].medium != number || files[p] == NULL) continue;
        json_t* bounds = json_pack("{s:s}", "file", files[p]);
        if (medium->clipped)
            ty_conversion_approximate(
                conversion, "medium \"%s\": a surface cuts its grid, whose faces fade beyond its box", medium->name);
        if (medium->grid) result = move_bounds(conversion, medium, bounds);
        if (result == TY_OK)
            result = add_entries(conversion, medium, media, bounds);
        else
            json_decref(bounds);
    }
    return result;
}

/* A medium that no surface has inside fills the box around the scene. */
static ty_result add_around(ty_conversion* conversion, const ty_conversion_medium* medium, json_t* media) {
    double box[2][3];
    if (!ty_conversion_box(conversion, box)) return TY_OK;
    double size = 0;
    for (int a = 0; a < 3; ++a) size = fmax(size, box[1][a] - box[0][a]);
    if (!(size > 0)) size = 1;
    for (int a = 0; a < 3; ++a) {
        box[0][a] -= 0.01 * size;
        box[1][a] += 0.01 * size;
    }
    ty_conversion_approximate(
        conversion, "medium \"%s\" has no bounds: it fills the box around the scene, which ends 1 %% beyond it",
        medium->name);
    return add_entries(conversion, medium, media, box_bounds(box));
}

ty_result ty_conversion_place_media(ty_conversion* conversion, char* const* files, json_t* media) {
    ty_result result = TY_OK;
    for (size_t i = 0; i < conversion->medium_count && result == TY_OK; ++i) {
        const ty_conversion_medium* medium = &conversion->media[i];
        if (!medium->inside && !medium->outside) {
            ty_conversion_leave_out(conversion, "medium \"%s\", which is not used", medium->name);
            continue;
        }
        double box[2][3];
        if (medium->grid && (!medium->inside || holds_grid(conversion, (int32_t)i)))
            result = add_entries(conversion, medium, media, medium->clipped ? box_bounds(medium->box) : NULL);
        else if (medium->grid && cut_box(conversion, (int32_t)i, box))
            result = add_entries(conversion, medium, media, box_bounds(box));
        else if (medium->inside)
            result = add_bounded(conversion, (int32_t)i, files, media);
        else
            result = add_around(conversion, medium, media);
        if (result == TY_OK && medium->inside && !medium->grid && medium->camera)
            ty_conversion_approximate(
                conversion, "medium \"%s\": the camera is in it, and it fills only what surfaces bound", medium->name);
    }
    return result;
}
