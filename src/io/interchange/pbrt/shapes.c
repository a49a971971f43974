/* Shapes: spheres as they are, the rest as triangles. */
#include "base/constants.h"
#include "base/context.h"
#include "io/file.h"
#include "io/interchange/pbrt/pbrt.h"
#include "io/interchange/solids.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* The edges' cross product of a triangle: along its normal, twice as long as its area. */
static void find_normal(const ty_model_mesh* mesh, const uint32_t corner[3], double out[3]) {
    double u[3], v[3];
    for (int a = 0; a < 3; ++a) {
        const double origin = (double)mesh->positions[3 * (size_t)corner[0] + (size_t)a];
        u[a] = (double)mesh->positions[3 * (size_t)corner[1] + (size_t)a] - origin;
        v[a] = (double)mesh->positions[3 * (size_t)corner[2] + (size_t)a] - origin;
    }
    for (int a = 0; a < 3; ++a) out[a] = u[(a + 1) % 3] * v[(a + 2) % 3] - u[(a + 2) % 3] * v[(a + 1) % 3];
}

/* Area of a mesh's triangles. */
static double area_of(const ty_model_mesh* mesh) {
    double sum = 0;
    for (size_t t = 0; t < mesh->triangle_count; ++t) {
        double n[3];
        find_normal(mesh, mesh->indices + 3 * t, n);
        sum += 0.5 * sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
    }
    return sum;
}

/* The part of a shape with the current state; area in the units of the scene. */
static ty_result find_part(ty_pbrt* reader, double area, int32_t* part) {
    const ty_pbrt_state* state = ty_pbrt_now(reader);
    ty_conversion* conversion = reader->conversion;
    double emission[3] = {0, 0, 0};
    int32_t inside = state->reverse ? state->outside : state->inside;
    int32_t outside = state->reverse ? state->inside : state->outside;
    if (state->material >= 0 && conversion->materials[state->material].medium >= 0)
        inside = conversion->materials[state->material].medium;
    if (inside == outside) inside = -1;
    if (inside >= 0) conversion->media[inside].inside = true;
    if (outside >= 0) conversion->media[outside].outside = true;
    if (state->area.on && state->material < 0)
        ty_conversion_leave_out(conversion, "AreaLightSource: the light of a shape without a surface");
    if (state->area.on && state->material >= 0) {
        /* power: pi A L over the sides that emit (section 12.4.1 of the book) */
        const double sides = state->area.two_sided ? 2 : 1;
        const double factor = state->area.power > 0 ? state->area.power / (sides * TY_PI_F64 * area) : 1;
        for (int c = 0; c < 3; ++c) emission[c] = state->area.radiance[c] * factor;
        if (state->area.two_sided)
            ty_conversion_approximate(conversion, "AreaLightSource: of two sides that emit, the front is left");
    }
    return ty_conversion_find_part(conversion, state->material, inside, emission, part);
}

/* Texture coordinates as the material maps them, with v downwards. */
static void map_uv(ty_pbrt* reader, ty_model_mesh* mesh) {
    const int32_t material = ty_pbrt_now(reader)->material;
    static const double plain[4] = {1, 1, 0, 0};
    const double* map = plain;
    if (mesh->uv[0] == NULL) {
        if (material >= 0 && reader->conversion->materials[material].textured)
            ty_conversion_approximate(reader->conversion, "a mesh without texture coordinates has a textured material");
        return;
    }
    if (material >= 0 && reader->conversion->materials[material].textured)
        map = reader->conversion->materials[material].uv_map;
    for (size_t i = 0; i < mesh->vertex_count; ++i) {
        float* uv = mesh->uv[0] + 2 * i;
        uv[0] = (float)(map[0] * (double)uv[0] + map[2]);
        uv[1] = (float)(1 - (map[1] * (double)uv[1] + map[3]));
    }
}

/* Where a mesh has normals, its triangles face to their side. */
static void face_normals(ty_model_mesh* mesh) {
    for (size_t t = 0; t < mesh->triangle_count && mesh->normals != NULL; ++t) {
        uint32_t* corner = mesh->indices + 3 * t;
        double n[3], side = 0;
        find_normal(mesh, corner, n);
        for (int a = 0; a < 3; ++a)
            for (int k = 0; k < 3; ++k) side += n[a] * (double)mesh->normals[3 * (size_t)corner[k] + (size_t)a];
        if (side >= 0) continue;
        const uint32_t swapped = corner[1];
        corner[1] = corner[2];
        corner[2] = swapped;
    }
}

/* Takes over a mesh in object space. */
static ty_result add_mesh(ty_pbrt* reader, ty_model_mesh* mesh) {
    const ty_affine map = ty_pbrt_world(reader), identity = ty_affine_identity();
    int32_t part = -1;
    size_t index = 0;
    if (mesh->triangle_count == 0) {
        ty_model_free_mesh(reader->context, mesh);
        return TY_OK;
    }
    ty_map_mesh(&map, ty_pbrt_now(reader)->reverse, mesh);
    face_normals(mesh);
    map_uv(reader, mesh);
    ty_result result = find_part(reader, area_of(mesh), &part);
    if (result != TY_OK) {
        ty_model_free_mesh(reader->context, mesh);
        return result;
    }
    result = ty_conversion_add_mesh(reader->conversion, part, mesh, &index);
    if (result != TY_OK || !reader->in_object)
        return result == TY_OK ? ty_conversion_add_instance(reader->conversion, index, &identity) : result;
    if (!ty_grow_array(reader->context, (void**)&reader->recorded, &reader->recorded_capacity, reader->recorded_count,
                       sizeof *reader->recorded))
        return TY_ERROR_MEMORY;
    reader->recorded[reader->recorded_count++] = index;
    return TY_OK;
}

/* An object's meshes with the current transform, which follows their own into our scene. */
ty_result ty_pbrt_instance(ty_pbrt* reader, const ty_pbrt_object* object) {
    ty_affine back;
    if (!ty_affine_invert(&reader->mirror, &back)) return TY_OK;
    const ty_affine world = ty_pbrt_world(reader), map = ty_affine_multiply(&world, &back);
    ty_result result = TY_OK;
    for (size_t i = 0; i < object->count && result == TY_OK; ++i)
        result = ty_conversion_add_instance(reader->conversion, reader->recorded[object->first + i], &map);
    return result;
}

/* ---- quadrics ---- */

static ty_result read_sphere(ty_pbrt* reader, const ty_pbrt_parameters* parameters) {
    const double radius = ty_pbrt_float(parameters, "radius", 1);
    const double low = ty_pbrt_float(parameters, "zmin", -radius), high = ty_pbrt_float(parameters, "zmax", radius);
    const double turn = ty_pbrt_float(parameters, "phimax", 360) * TY_PI_F64 / 180;
    const ty_pbrt_state* state = ty_pbrt_now(reader);
    const ty_affine map = ty_pbrt_world(reader);
    const bool textured = state->material >= 0 && reader->conversion->materials[state->material].textured;
    double scale, center[3];
    if (!(radius > 0)) return ty_pbrt_refuse(parameters, "the radius of the sphere, %g, is not above 0", radius);
    const bool whole = low <= -radius && high >= radius && turn >= 2 * TY_PI_F64 - 1e-6;
    if (whole && !textured && !reader->in_object && !(state->reverse && state->area.on) &&
        ty_affine_is_similarity(&map, &scale)) {
        int32_t part = -1;
        ty_affine_point(&map, (const double[3]){0, 0, 0}, center);
        const double size = scale * radius;
        const ty_result result = find_part(reader, 4 * TY_PI_F64 * size * size, &part);
        return result == TY_OK ? ty_conversion_add_sphere(reader->conversion, part, center, size) : result;
    }
    ty_model_mesh mesh = {0};
    const ty_result result = ty_make_sphere(reader->context, radius, fmin(low, high), fmax(low, high), turn, &mesh);
    if (result == TY_OK)
        ty_conversion_approximate(
            reader->conversion,
            "Shape \"sphere\": those that are textured, cut or scaled unevenly, or in objects, became triangles");
    return result == TY_OK ? add_mesh(reader, &mesh) : result;
}

static ty_result read_disk(ty_pbrt* reader, const ty_pbrt_parameters* parameters) {
    ty_model_mesh mesh = {0};
    const ty_result result = ty_make_disk(
        reader->context, ty_pbrt_float(parameters, "radius", 1), ty_pbrt_float(parameters, "innerradius", 0),
        ty_pbrt_float(parameters, "height", 0), ty_pbrt_float(parameters, "phimax", 360) * TY_PI_F64 / 180, &mesh);
    return result == TY_OK ? add_mesh(reader, &mesh) : result;
}

static ty_result read_cylinder(ty_pbrt* reader, const ty_pbrt_parameters* parameters) {
    ty_model_mesh mesh = {0};
    const ty_result result = ty_make_cylinder(
        reader->context, ty_pbrt_float(parameters, "radius", 1), ty_pbrt_float(parameters, "zmin", -1),
        ty_pbrt_float(parameters, "zmax", 1), ty_pbrt_float(parameters, "phimax", 360) * TY_PI_F64 / 180, &mesh);
    return result == TY_OK ? add_mesh(reader, &mesh) : result;
}

/* ---- meshes ---- */

/* Copies an array of `width` numbers a vertex, if it fits the number of vertices. */
static bool copy_array(const ty_pbrt_parameter* parameter, size_t vertices, size_t width, float* to) {
    if (parameter == NULL || to == NULL || parameter->number_count != vertices * width) return false;
    for (size_t i = 0; i < vertices * width; ++i) to[i] = (float)parameter->numbers[i];
    return true;
}

/* Vertices of P, N and uv for a number of triangles. */
static ty_result alloc_vertices(ty_pbrt* reader, const ty_pbrt_parameters* parameters, size_t triangles,
                                ty_model_mesh* out) {
    const ty_pbrt_parameter *points = ty_pbrt_find(parameters, "P"), *normals = ty_pbrt_find(parameters, "N"),
                            *uv = ty_pbrt_find(parameters, "uv");
    if (uv == NULL) uv = ty_pbrt_find(parameters, "st");
    if (points == NULL || points->type != TY_PBRT_POINT3 || points->number_count == 0)
        return ty_pbrt_refuse(parameters, "the mesh has no \"point3 P\"");
    const size_t vertices = points->number_count / 3;
    if (vertices > UINT32_MAX) return ty_pbrt_refuse(parameters, "the mesh has too many vertices");
    if (normals != NULL && normals->number_count != points->number_count)
        return ty_pbrt_refuse(parameters, "the mesh has not as many normals as vertices");
    if (uv != NULL && uv->number_count != 2 * vertices)
        return ty_pbrt_refuse(parameters, "the mesh has not as many texture coordinates as vertices");
    *out = (ty_model_mesh){.vertex_count = vertices, .triangle_count = triangles, .material = -1, .primitive = -1};
    const ty_result result = ty_model_alloc_mesh(reader->context, out, normals != NULL, uv != NULL, false, false);
    if (result != TY_OK) return result;
    copy_array(points, vertices, 3, out->positions);
    copy_array(normals, vertices, 3, out->normals);
    copy_array(uv, vertices, 2, out->uv[0]);
    return TY_OK;
}

/* Indices for faces of `corners` vertices; without the parameter the first face alone. *count is the number of faces.
 */
static ty_result check_indices(const ty_pbrt_parameters* parameters, size_t corners, const ty_pbrt_parameter** indices,
                               size_t* count) {
    const ty_pbrt_parameter* points = ty_pbrt_find(parameters, "P");
    const size_t vertices = points == NULL ? 0 : points->number_count / 3;
    *indices = ty_pbrt_find(parameters, "indices");
    *count = 1;
    if (*indices == NULL) {
        if (vertices != corners) return ty_pbrt_refuse(parameters, "the mesh has no \"integer indices\"");
        return TY_OK;
    }
    if ((*indices)->number_count % corners != 0)
        return ty_pbrt_refuse(parameters, "the number of indices is not a multiple of %d", (int)corners);
    for (size_t i = 0; i < (*indices)->number_count; ++i)
        if (!((*indices)->numbers[i] >= 0 && (*indices)->numbers[i] < (double)vertices))
            return ty_pbrt_refuse(parameters, "the index %g is not that of a vertex", (*indices)->numbers[i]);
    *count = (*indices)->number_count / corners;
    return TY_OK;
}

static ty_result read_triangles(ty_pbrt* reader, const ty_pbrt_parameters* parameters) {
    const ty_pbrt_parameter* indices;
    size_t count;
    ty_model_mesh mesh = {0};
    ty_pbrt_find(parameters, "S");
    ty_pbrt_find(parameters, "faceIndices");
    ty_result result = check_indices(parameters, 3, &indices, &count);
    if (result == TY_OK) result = alloc_vertices(reader, parameters, count, &mesh);
    if (result != TY_OK) return result;
    for (size_t i = 0; i < 3 * count; ++i)
        mesh.indices[i] = indices != NULL ? (uint32_t)indices->numbers[i] : (uint32_t)i;
    return add_mesh(reader, &mesh);
}

/* Patches of corners 00, 10, 01, 11, as two triangles each; curved ones differ from that. */
static ty_result read_patches(ty_pbrt* reader, const ty_pbrt_parameters* parameters) {
    static const size_t corners[6] = {0, 1, 3, 0, 3, 2};
    const ty_pbrt_parameter* indices;
    size_t count;
    bool curved = false;
    ty_model_mesh mesh = {0};
    if (ty_pbrt_find(parameters, "emissionfilename") != NULL)
        ty_conversion_leave_out(reader->conversion, "Shape \"bilinearmesh\": the image of its emission");
    ty_pbrt_find(parameters, "faceIndices");
    ty_result result = check_indices(parameters, 4, &indices, &count);
    if (result == TY_OK) result = alloc_vertices(reader, parameters, 2 * count, &mesh);
    if (result != TY_OK) return result;
    for (size_t p = 0; p < count; ++p) {
        uint32_t own[4];
        for (size_t k = 0; k < 4; ++k) own[k] = indices != NULL ? (uint32_t)indices->numbers[4 * p + k] : (uint32_t)k;
        for (size_t k = 0; k < 6; ++k) mesh.indices[6 * p + k] = own[corners[k]];
        for (size_t a = 0; a < 3; ++a) {
            const float *q = mesh.positions, twist = q[3 * (size_t)own[0] + a] - q[3 * (size_t)own[1] + a] -
                                                     q[3 * (size_t)own[2] + a] + q[3 * (size_t)own[3] + a];
            curved = curved || fabsf(twist) > 1e-4f * (fabsf(q[3 * (size_t)own[0] + a]) + 1e-3f);
        }
    }
    if (curved)
        ty_conversion_approximate(
            reader->conversion, "Shape \"bilinearmesh\": patches that are no parallelograms became two triangles each");
    return add_mesh(reader, &mesh);
}

static ty_result read_ply(ty_pbrt* reader, const ty_pbrt_parameters* parameters) {
    char name[1024], location[512];
    uint8_t* bytes = NULL;
    size_t size = 0;
    if (!ty_pbrt_string(parameters, "filename", name, sizeof name))
        return ty_pbrt_refuse(parameters, "the mesh has no \"string filename\"");
    if (ty_pbrt_find(parameters, "displacement") != NULL)
        ty_conversion_leave_out(reader->conversion, "Shape \"plymesh\": displacement");
    ty_pbrt_find(parameters, "edgelength");
    ty_pbrt_location(reader, parameters->file, parameters->line, location, sizeof location);
    ty_result result = ty_conversion_read_file(reader->conversion, location, name, &bytes, &size);
    if (result != TY_OK || bytes == NULL) return result;
    ty_model model;
    result = ty_read_ply(reader->context, name, bytes, size, TY_MODEL_MESHES | TY_MODEL_SHADING, &model);
    ty_free_file(reader->context, bytes, size);
    for (size_t i = 0; i < model.mesh_count && result == TY_OK; ++i) {
        ty_model_mesh mesh = model.meshes[i];
        model.meshes[i] = (ty_model_mesh){0};
        if (mesh.colors != NULL) ty_conversion_leave_out(reader->conversion, "Shape \"plymesh\": colours of vertices");
        for (size_t k = 0; k < mesh.vertex_count && mesh.uv[0] != NULL; ++k) /* upwards, as they are in the file */
            mesh.uv[0][2 * k + 1] = 1 - mesh.uv[0][2 * k + 1];
        result = add_mesh(reader, &mesh);
    }
    ty_model_free(&model);
    return result;
}

/* ---- the directive ---- */

static const struct {
    const char* type;
    ty_result (*read)(ty_pbrt* reader, const ty_pbrt_parameters* parameters);
} readers[] = {{"sphere", read_sphere},        {"disk", read_disk},
               {"cylinder", read_cylinder},    {"trianglemesh", read_triangles},
               {"bilinearmesh", read_patches}, {"plymesh", read_ply}};

/* Alpha: a constant of 0 hides a shape, and lights it may have; other values are left out. */
static bool is_hidden(ty_pbrt* reader, const ty_pbrt_parameters* parameters) {
    const ty_pbrt_parameter* alpha = ty_pbrt_find(parameters, "alpha");
    if (alpha == NULL) return false;
    if (alpha->type == TY_PBRT_FLOAT && alpha->number_count > 0 && alpha->numbers[0] >= 1) return false;
    const bool hidden = alpha->type == TY_PBRT_FLOAT && alpha->number_count > 0 && alpha->numbers[0] <= 0;
    if (hidden && ty_pbrt_now(reader)->area.on)
        ty_conversion_approximate(reader->conversion, "Shape: a light with an alpha of 0 became visible");
    else
        ty_conversion_leave_out(reader->conversion,
                                hidden ? "Shape: one with an alpha of 0" : "Shape: alpha, so it is opaque");
    return hidden && !ty_pbrt_now(reader)->area.on;
}

ty_result ty_pbrt_shape(ty_pbrt* reader, const ty_pbrt_parameters* parameters) {
    if (reader->in_object && ty_pbrt_now(reader)->area.on)
        ty_conversion_approximate(reader->conversion, "area lights in objects shine from each of their instances");
    if (is_hidden(reader, parameters)) {
        for (size_t i = 0; i < parameters->count; ++i) parameters->items[i].used = true;
        return TY_OK;
    }
    for (size_t i = 0; i < sizeof readers / sizeof readers[0]; ++i)
        if (strcmp(parameters->type, readers[i].type) == 0) return readers[i].read(reader, parameters);
    if (strcmp(parameters->type, "curve") != 0 && strcmp(parameters->type, "loopsubdiv") != 0)
        return ty_pbrt_refuse(parameters, "the shape \"%s\" is not known", parameters->type);
    ty_conversion_leave_out(reader->conversion, "Shape \"%s\"", parameters->type);
    for (size_t i = 0; i < parameters->count; ++i) parameters->items[i].used = true;
    return TY_OK;
}
