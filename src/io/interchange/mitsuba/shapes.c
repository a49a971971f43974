/* Shapes: spheres as they are, the rest as triangles. */
#include "io/interchange/mitsuba/mitsuba.h"

#include "base/constants.h"
#include "base/context.h"
#include "io/file.h"
#include "io/interchange/mitsuba/serialized.h"
#include "io/interchange/solids.h"

#include <math.h>
#include <string.h>

/* A shape with its material, media and place. */
typedef struct holder {
    ty_mitsuba* scene;
    int32_t node;
    ty_affine to_world;
    bool flipped;
    int32_t material, part;
} holder;

static ty_result find_medium(ty_mitsuba* scene, int32_t node, const char* name, int32_t* index) {
    const int32_t medium = ty_mitsuba_child(scene, node, name);
    *index = -1;
    return medium >= 0 ? ty_mitsuba_medium(scene, medium, index) : TY_OK;
}

/* Material, emission and media, which give the part. */
static ty_result read_holder(holder* h) {
    ty_mitsuba* scene = h->scene;
    ty_conversion* conversion = scene->conversion;
    int32_t inside, outside;
    double emission[3] = {0, 0, 0};
    bool found;
    const int32_t bsdf = ty_mitsuba_child_of_tag(scene, h->node, "bsdf");
    const int32_t emitter = ty_mitsuba_child_of_tag(scene, h->node, "emitter");
    ty_result result = find_medium(scene, h->node, "interior", &inside);
    if (result == TY_OK) result = find_medium(scene, h->node, "exterior", &outside);
    if (result == TY_OK && bsdf >= 0) {
        result = ty_mitsuba_bsdf(scene, bsdf, &h->material);
    } else if (result == TY_OK && (inside >= 0 || outside >= 0)) {
        h->material = -1; /* a shape with media and without a bsdf is their boundary */
    } else if (result == TY_OK) {
        ty_conversion_material grey = {.keys = json_pack("{s:f}", "base_color", emitter >= 0 ? 0.0 : 0.5),
                                       .medium = -1};
        result = ty_conversion_add_material(conversion, &grey, &h->material);
    }
    if (result == TY_OK && emitter >= 0) {
        result = ty_mitsuba_colour(scene, emitter, "radiance", true, emission, &found);
        if (!found) {
            emission[0] = emission[1] = emission[2] = 1;
            ty_conversion_approximate(conversion, "an area light of a texture shines evenly");
        }
    }
    if (result != TY_OK) return result;
    if (inside == outside) inside = -1;
    if (inside >= 0) conversion->media[inside].inside = true;
    if (outside >= 0) conversion->media[outside].outside = true;
    return ty_conversion_find_part(conversion, h->material, inside, emission, &h->part);
}

/* Texture coordinates as the material maps them; in the mesh v points down already, and textures map those that point
 * up. */
static void map_uv(const holder* h, ty_model_mesh* mesh) {
    const ty_conversion* conversion = h->scene->conversion;
    if (mesh->uv[0] == NULL || h->material < 0 || !conversion->materials[h->material].textured) return;
    const double* map = conversion->materials[h->material].uv_map;
    for (size_t i = 0; i < mesh->vertex_count; ++i) {
        float* uv = mesh->uv[0] + 2 * i;
        uv[0] = (float)(map[0] * (double)uv[0] + map[2]);
        uv[1] = (float)(1 - (map[1] * (1 - (double)uv[1]) + map[3]));
    }
}

/* Takes over a mesh in the space of the shape. */
static ty_result add_mesh(const holder* h, ty_model_mesh* mesh) {
    const ty_affine identity = ty_affine_identity();
    size_t index;
    if (mesh->triangle_count == 0) {
        ty_model_free_mesh(h->scene->context, mesh);
        return TY_OK;
    }
    ty_map_mesh(&h->to_world, h->flipped, mesh);
    map_uv(h, mesh);
    const ty_result result = ty_conversion_add_mesh(h->scene->conversion, h->part, mesh, &index);
    return result == TY_OK ? ty_conversion_add_instance(h->scene->conversion, index, &identity) : result;
}

/* A solid of ours, whose v points up. */
static ty_result add_solid(const holder* h, ty_model_mesh* mesh) {
    for (size_t i = 0; i < mesh->vertex_count; ++i) mesh->uv[0][2 * i + 1] = 1 - mesh->uv[0][2 * i + 1];
    return add_mesh(h, mesh);
}

/* ---- files ---- */

/* Angle at the first of three points. */
static double angle_at(const float* a, const float* b, const float* c) {
    double bb = 0, cc = 0, bc = 0;
    for (int k = 0; k < 3; ++k) {
        const double u = (double)b[k] - (double)a[k], v = (double)c[k] - (double)a[k];
        bb += u * u;
        cc += v * v;
        bc += u * v;
    }
    return bb > 0 && cc > 0 ? acos(fmin(fmax(bc / sqrt(bb * cc), -1), 1)) : 0;
}

/* Normals of vertices from those of their triangles, weighted by their angles (Thuermer and Wuethrich 1998). */
static ty_result smooth(ty_context* context, ty_model_mesh* mesh) {
    mesh->normals = ty_alloc_array(context, mesh->vertex_count, 3 * sizeof(float), true);
    if (mesh->normals == NULL) return TY_ERROR_MEMORY;
    for (size_t t = 0; t < mesh->triangle_count; ++t) {
        const uint32_t* corner = mesh->indices + 3 * t;
        const float* p[3];
        double normal[3], length = 0;
        for (int k = 0; k < 3; ++k) p[k] = mesh->positions + 3 * (size_t)corner[k];
        for (int a = 0; a < 3; ++a) {
            const int b = (a + 1) % 3, c = (a + 2) % 3;
            normal[a] = ((double)p[1][b] - (double)p[0][b]) * ((double)p[2][c] - (double)p[0][c]) -
                        ((double)p[1][c] - (double)p[0][c]) * ((double)p[2][b] - (double)p[0][b]);
            length += normal[a] * normal[a];
        }
        for (int k = 0; k < 3 && length > 0; ++k) {
            const double weight = angle_at(p[k], p[(k + 1) % 3], p[(k + 2) % 3]) / sqrt(length);
            for (int a = 0; a < 3; ++a) mesh->normals[3 * (size_t)corner[k] + (size_t)a] += (float)(weight * normal[a]);
        }
    }
    ty_model_tidy_shading(mesh);
    return TY_OK;
}

/* Takes over a mesh from a file, with flat faces or smooth ones as the shape asks for. */
static ty_result add_file_mesh(const holder* h, ty_model_mesh* mesh) {
    ty_context* context = h->scene->context;
    ty_result result = TY_OK;
    if (ty_mitsuba_bool(h->scene, h->node, "face_normals", false)) {
        ty_free_array(context, mesh->normals, mesh->vertex_count, 3 * sizeof(float));
        mesh->normals = NULL;
    } else if (mesh->normals == NULL) {
        result = smooth(context, mesh);
    }
    if (result == TY_OK) return add_mesh(h, mesh);
    ty_model_free_mesh(context, mesh);
    return result;
}

static ty_result add_model(const holder* h, ty_model* model) {
    ty_result result = TY_OK;
    for (size_t i = 0; i < model->mesh_count && result == TY_OK; ++i) {
        ty_model_mesh mesh = model->meshes[i];
        model->meshes[i] = (ty_model_mesh){0};
        result = add_file_mesh(h, &mesh);
    }
    return result;
}

static ty_result add_serialized(const holder* h, const char* name, const uint8_t* bytes, size_t size) {
    double index = 0;
    ty_model_mesh mesh;
    ty_result result = ty_mitsuba_float(h->scene, h->node, "shape_index", &index);
    if (result == TY_OK && !(index >= 0 && index < 1e9))
        return ty_mitsuba_fail(h->scene, h->node, "the shape_index %g is not that of a shape", index);
    if (result == TY_OK) result = ty_read_serialized(h->scene->context, name, bytes, size, (int32_t)index, &mesh);
    return result == TY_OK ? add_file_mesh(h, &mesh) : result;
}

static ty_result read_file(holder* h) {
    uint8_t* bytes = NULL;
    size_t size = 0;
    const char* name = ty_mitsuba_string(h->scene, h->node, "filename");
    const bool obj = ty_mitsuba_same(ty_mitsuba_type(h->scene, h->node), "obj");
    if (name == NULL) return ty_mitsuba_fail(h->scene, h->node, "the shape has no filename");
    ty_result result = ty_mitsuba_read_file(h->scene, h->node, name, &bytes, &size);
    if (result != TY_OK || bytes == NULL) return result;
    if (ty_mitsuba_same(ty_mitsuba_type(h->scene, h->node), "serialized")) {
        result = add_serialized(h, name, bytes, size);
        ty_free_file(h->scene->context, bytes, size);
        return result;
    }
    ty_model model;
    const unsigned want = TY_MODEL_MESHES | TY_MODEL_SHADING;
    result = obj ? ty_read_obj(h->scene->context, name, NULL, bytes, size, want, &model)
                 : ty_read_ply(h->scene->context, name, bytes, size, want, &model);
    ty_free_file(h->scene->context, bytes, size);
    if (result == TY_OK) result = add_model(h, &model);
    ty_model_free(&model);
    return result;
}

/* ---- solids ---- */

static ty_result read_sphere(holder* h) {
    double center[3] = {0, 0, 0}, radius = 1, scale, place[3];
    ty_result result = ty_mitsuba_vector(h->scene, h->node, "center", center);
    if (result == TY_OK) result = ty_mitsuba_float(h->scene, h->node, "radius", &radius);
    if (result != TY_OK) return result;
    if (!(radius > 0))
        return ty_mitsuba_fail(h->scene, h->node, "the radius of the sphere, %g, is not above 0", radius);
    const bool textured = h->material >= 0 && h->scene->conversion->materials[h->material].textured;
    if (!textured && !h->flipped && ty_affine_is_similarity(&h->to_world, &scale)) {
        ty_affine_point(&h->to_world, center, place);
        return ty_conversion_add_sphere(h->scene->conversion, h->part, place, scale * radius);
    }
    ty_model_mesh mesh = {0};
    result = ty_make_sphere(h->scene->context, radius, -radius, radius, 2 * TY_PI_F64, &mesh);
    for (size_t i = 0; i < mesh.vertex_count && result == TY_OK; ++i)
        for (size_t a = 0; a < 3; ++a) mesh.positions[3 * i + a] += (float)center[a];
    return result == TY_OK ? add_solid(h, &mesh) : result;
}

static ty_result read_cylinder(holder* h) {
    double ends[2][3] = {{0, 0, 0}, {0, 0, 1}}, radius = 1, axis[3], length = 0;
    ty_result result = ty_mitsuba_vector(h->scene, h->node, "p0", ends[0]);
    if (result == TY_OK) result = ty_mitsuba_vector(h->scene, h->node, "p1", ends[1]);
    if (result == TY_OK) result = ty_mitsuba_float(h->scene, h->node, "radius", &radius);
    if (result != TY_OK) return result;
    for (int a = 0; a < 3; ++a) {
        axis[a] = ends[1][a] - ends[0][a];
        length += axis[a] * axis[a];
    }
    if (!(length > 0)) return ty_mitsuba_fail(h->scene, h->node, "the cylinder has no length");
    /* x along the axis' smallest coordinate, made perpendicular */
    int smallest = 0;
    for (int a = 1; a < 3; ++a)
        if (fabs(axis[a]) < fabs(axis[smallest])) smallest = a;
    ty_affine place = ty_affine_identity();
    double x[3], y[3], size = 0;
    for (int a = 0; a < 3; ++a) x[a] = (a == smallest) - axis[a] * axis[smallest] / length;
    for (int a = 0; a < 3; ++a) size += x[a] * x[a];
    for (int a = 0; a < 3; ++a) x[a] /= sqrt(size);
    for (int a = 0; a < 3; ++a)
        y[a] = (axis[(a + 1) % 3] * x[(a + 2) % 3] - axis[(a + 2) % 3] * x[(a + 1) % 3]) / sqrt(length);
    for (int a = 0; a < 3; ++a) {
        place.m[4 * a] = radius * x[a];
        place.m[4 * a + 1] = radius * y[a];
        place.m[4 * a + 2] = axis[a];
        place.m[4 * a + 3] = ends[0][a];
    }
    h->to_world = ty_affine_multiply(&h->to_world, &place);
    ty_model_mesh mesh = {0};
    result = ty_make_cylinder(h->scene->context, 1, 0, 1, 2 * TY_PI_F64, &mesh);
    return result == TY_OK ? add_solid(h, &mesh) : result;
}

static ty_result read_square(holder* h) {
    ty_model_mesh mesh = {0};
    const ty_result result = ty_make_square(h->scene->context, &mesh);
    return result == TY_OK ? add_solid(h, &mesh) : result;
}

static ty_result read_cube(holder* h) {
    ty_model_mesh mesh = {0};
    const ty_result result = ty_make_cube(h->scene->context, &mesh);
    return result == TY_OK ? add_solid(h, &mesh) : result;
}

static ty_result read_disk(holder* h) {
    ty_model_mesh mesh = {0};
    const ty_result result = ty_make_disk(h->scene->context, 1, 0, 0, 2 * TY_PI_F64, &mesh);
    return result == TY_OK ? add_solid(h, &mesh) : result;
}

/* ---- groups ---- */

/* The shapes of a group, or an instance of one, each with its own copies. */
static ty_result read_group(ty_mitsuba* scene, int32_t node, const ty_affine* map) {
    ty_result result = TY_OK;
    for (int32_t child = scene->nodes[node].first_child; child >= 0 && result == TY_OK;
         child = scene->nodes[child].next) {
        const int32_t object = ty_mitsuba_resolve(scene, child);
        if (object >= 0 && ty_mitsuba_is(scene, object, "shape")) result = ty_mitsuba_shape(scene, object, map);
    }
    return result;
}

static ty_result read_instance(ty_mitsuba* scene, int32_t node, const ty_affine* map) {
    const int32_t group = ty_mitsuba_child_of_tag(scene, node, "shape");
    if (group < 0) return ty_mitsuba_fail(scene, node, "the instance names no group");
    if (scene->depth >= TY_MITSUBA_DEPTH_MAX) return ty_mitsuba_fail(scene, node, "groups are nested too deep");
    ++scene->depth;
    const ty_result result = read_group(scene, group, map);
    --scene->depth;
    return result;
}

static const struct {
    const char* type;
    ty_result (*read)(holder* h);
} readers[] = {{"obj", read_file},         {"ply", read_file},  {"serialized", read_file},   {"sphere", read_sphere},
               {"rectangle", read_square}, {"cube", read_cube}, {"cylinder", read_cylinder}, {"disk", read_disk}};

ty_result ty_mitsuba_shape(ty_mitsuba* scene, int32_t node, const ty_affine* around) {
    holder h = {.scene = scene, .node = node, .material = -1, .part = -1};
    const char* type = ty_mitsuba_type(scene, node);
    ty_result result = ty_mitsuba_transform(scene, node, "to_world", &h.to_world);
    if (result != TY_OK) return result;
    h.to_world = ty_affine_multiply(around, &h.to_world);
    h.flipped = ty_mitsuba_bool(scene, node, "flip_normals", false);
    if (strcmp(type, "instance") == 0) return read_instance(scene, node, &h.to_world);
    if (strcmp(type, "merge") == 0) {
        if (scene->depth >= TY_MITSUBA_DEPTH_MAX) return ty_mitsuba_fail(scene, node, "groups are nested too deep");
        ++scene->depth;
        result = read_group(scene, node, &h.to_world);
        --scene->depth;
        return result;
    }
    for (size_t i = 0; i < sizeof readers / sizeof readers[0]; ++i) {
        if (!ty_mitsuba_same(readers[i].type, type)) continue;
        result = read_holder(&h);
        return result == TY_OK ? readers[i].read(&h) : result;
    }
    ty_conversion_leave_out(scene->conversion, "the shape \"%.60s\"", type);
    return TY_OK;
}
