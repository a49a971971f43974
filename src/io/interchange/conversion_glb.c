/* The meshes of a part as a GLB file: each mesh once, with a node for each of its instances. */
#include "io/interchange/conversion.h"

#include "base/context.h"
#include "io/file.h"
#include "io/json_text.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { ARRAY_BUFFER = 34962, ELEMENT_ARRAY_BUFFER = 34963, UNSIGNED_INT = 5125, FLOAT = 5126 };

/* The JSON of a file, and the length of its binary part. */
typedef struct glb {
    json_t *views, *accessors, *meshes, *nodes, *roots;
    size_t length;
    bool failed;
} glb;

static void append(glb* file, json_t* array, json_t* item) {
    if (json_array_append_new(array, item) != 0) file->failed = true;
}

/* An accessor of `count` elements of 1 to 3 numbers of four bytes each; returns its index. */
static json_int_t add_accessor(glb* file, size_t count, int width, bool indices, const float bounds[2][3]) {
    static const char* const types[] = {"", "SCALAR", "VEC2", "VEC3"};
    const size_t bytes = count * (size_t)width * 4;
    json_t* view = json_pack("{s:i, s:I, s:I, s:i}", "buffer", 0, "byteOffset", (json_int_t)file->length, "byteLength",
                             (json_int_t)bytes, "target", indices ? ELEMENT_ARRAY_BUFFER : ARRAY_BUFFER);
    json_t* accessor =
        json_pack("{s:I, s:i, s:I, s:s}", "bufferView", (json_int_t)json_array_size(file->views), "componentType",
                  indices ? UNSIGNED_INT : FLOAT, "count", (json_int_t)count, "type", types[width]);
    for (int side = 0; side < 2 && bounds != NULL; ++side) {
        const double corner[3] = {bounds[side][0], bounds[side][1], bounds[side][2]};
        if (json_object_set_new(accessor, side == 0 ? "min" : "max", ty_conversion_vector(corner, 3)) != 0)
            file->failed = true;
    }
    append(file, file->views, view);
    append(file, file->accessors, accessor);
    file->length += bytes;
    return (json_int_t)json_array_size(file->accessors) - 1;
}

static void bound(const ty_model_mesh* mesh, float bounds[2][3]) {
    for (int a = 0; a < 3; ++a) {
        bounds[0][a] = FLT_MAX;
        bounds[1][a] = -FLT_MAX;
    }
    for (size_t i = 0; i < mesh->vertex_count; ++i)
        for (int a = 0; a < 3; ++a) {
            bounds[0][a] = fminf(bounds[0][a], mesh->positions[3 * i + (size_t)a]);
            bounds[1][a] = fmaxf(bounds[1][a], mesh->positions[3 * i + (size_t)a]);
        }
}

static void add_mesh(glb* file, const ty_model_mesh* mesh) {
    float bounds[2][3];
    bound(mesh, bounds);
    json_t* attributes = json_object();
    bool done = json_object_set_new(attributes, "POSITION",
                                    json_integer(add_accessor(file, mesh->vertex_count, 3, false, bounds))) == 0;
    if (mesh->normals != NULL)
        done = json_object_set_new(attributes, "NORMAL",
                                   json_integer(add_accessor(file, mesh->vertex_count, 3, false, NULL))) == 0 &&
               done;
    if (mesh->uv[0] != NULL)
        done = json_object_set_new(attributes, "TEXCOORD_0",
                                   json_integer(add_accessor(file, mesh->vertex_count, 2, false, NULL))) == 0 &&
               done;
    const json_int_t indices = add_accessor(file, 3 * mesh->triangle_count, 1, true, NULL);
    append(file, file->meshes,
           json_pack("{s:[{s:o, s:I}]}", "primitives", "attributes", attributes, "indices", indices));
    file->failed = file->failed || !done;
}

static bool is_identity(const ty_affine* map) {
    const ty_affine identity = ty_affine_identity();
    return memcmp(map->m, identity.m, sizeof identity.m) == 0;
}

static void add_node(glb* file, json_int_t mesh, const ty_affine* map) {
    json_t* node = json_pack("{s:I}", "mesh", mesh);
    double columns[16] = {[15] = 1};
    for (int r = 0; r < 3; ++r)
        for (int c = 0; c < 4; ++c) columns[4 * c + r] = map->m[4 * r + c];
    if (!is_identity(map) && json_object_set_new(node, "matrix", ty_conversion_vector(columns, 16)) != 0)
        file->failed = true;
    append(file, file->roots, json_integer((json_int_t)json_array_size(file->nodes)));
    append(file, file->nodes, node);
}

/* Fills in the JSON. numbers has, for each mesh, its index in the file plus one, and behind these the meshes of the
 * file in order. */
static void describe(ty_conversion* conversion, int32_t part, size_t* numbers, glb* file) {
    size_t* order = numbers + conversion->mesh_count;
    for (size_t i = 0; i < conversion->instance_count; ++i) {
        const ty_conversion_instance* instance = &conversion->instances[i];
        const ty_conversion_mesh* mesh = &conversion->meshes[instance->mesh];
        if (mesh->part != part) continue;
        if (numbers[instance->mesh] == 0) {
            add_mesh(file, &mesh->mesh);
            order[json_array_size(file->meshes) - 1] = instance->mesh;
            numbers[instance->mesh] = json_array_size(file->meshes);
        }
        add_node(file, (json_int_t)numbers[instance->mesh] - 1, &instance->transform);
    }
}

static void write_u32(ty_output* output, uint32_t value) {
    const uint8_t bytes[4] = {(uint8_t)value, (uint8_t)(value >> 8), (uint8_t)(value >> 16), (uint8_t)(value >> 24)};
    ty_output_write(output, bytes, 4);
}

/* Writes the arrays in the order in which add_mesh numbers them. */
static void write_arrays(const ty_conversion* conversion, const size_t* order, size_t count, ty_output* output) {
    for (size_t i = 0; i < count; ++i) {
        const ty_model_mesh* mesh = &conversion->meshes[order[i]].mesh;
        ty_output_write(output, mesh->positions, mesh->vertex_count * 12);
        if (mesh->normals != NULL) ty_output_write(output, mesh->normals, mesh->vertex_count * 12);
        if (mesh->uv[0] != NULL) ty_output_write(output, mesh->uv[0], mesh->vertex_count * 8);
        ty_output_write(output, mesh->indices, mesh->triangle_count * 12);
    }
}

static ty_result write_glb(ty_conversion* conversion, const char* path, const char* text, const glb* file,
                           const size_t* order) {
    enum { HEAD = 12, CHUNK_HEAD = 8 };
    const size_t length = strlen(text), padded = (length + 3) & ~(size_t)3;
    const size_t total = HEAD + 2 * CHUNK_HEAD + padded + file->length;
    if (total > UINT32_MAX)
        return ty_fail(conversion->context, TY_ERROR_INPUT, "%s: its meshes of one material exceed 4 GiB",
                       conversion->input);
    ty_output output;
    const ty_result result = ty_output_open(conversion->context, path, &output);
    if (result != TY_OK) return result;
    ty_output_write(&output, "glTF", 4);
    write_u32(&output, 2);
    write_u32(&output, (uint32_t)total);
    write_u32(&output, (uint32_t)padded);
    ty_output_write(&output, "JSON", 4);
    ty_output_write(&output, text, length);
    ty_output_write(&output, "   ", padded - length);
    write_u32(&output, (uint32_t)file->length);
    ty_output_write(&output, "BIN\0", 4);
    write_arrays(conversion, order, json_array_size(file->meshes), &output);
    return ty_output_commit(conversion->context, &output);
}

/* The file's JSON as text, or NULL. It takes over the arrays of `file`, all but meshes. */
static char* finish_text(glb* file) {
    json_t* root =
        json_pack("{s:{s:s}, s:i, s:[{s:o}], s:o, s:O, s:o, s:o, s:[{s:I}]}", "asset", "version", "2.0", "scene", 0,
                  "scenes", "nodes", file->roots, "nodes", file->nodes, "meshes", file->meshes, "accessors",
                  file->accessors, "bufferViews", file->views, "buffers", "byteLength", (json_int_t)file->length);
    char* text = root == NULL || file->failed ? NULL : json_dumps(root, JSON_COMPACT | JSON_REAL_PRECISION(9));
    json_decref(root);
    return text;
}

ty_result ty_conversion_write_part(ty_conversion* conversion, int32_t part, char** reference) {
    char* path = NULL;
    ty_result result = ty_conversion_new_file(conversion, "mesh", ".glb", &path, reference);
    if (result != TY_OK || path == NULL) return result;
    size_t* numbers = ty_alloc_array(conversion->context, 2 * conversion->mesh_count, sizeof *numbers, true);
    glb file = {json_array(), json_array(), json_array(), json_array(), json_array(), 0, false};
    if (numbers == NULL) {
        result = TY_ERROR_MEMORY;
        json_decref(file.views);
        json_decref(file.accessors);
        json_decref(file.nodes);
        json_decref(file.roots);
    } else {
        describe(conversion, part, numbers, &file);
        char* text = finish_text(&file);
        result = text == NULL ? ty_fail(conversion->context, TY_ERROR_MEMORY, "%s: not enough memory", path)
                              : write_glb(conversion, path, text, &file, numbers + conversion->mesh_count);
        free(text);
        ty_free_array(conversion->context, numbers, 2 * conversion->mesh_count, sizeof *numbers);
    }
    json_decref(file.meshes);
    ty_free_text(conversion->context, path);
    if (result == TY_OK) return TY_OK;
    ty_free_text(conversion->context, *reference);
    *reference = NULL;
    return result;
}

/* ---- quads ---- */

/* Tells whether two triangles form a parallelogram: origin, u and v with its front on the side of u x v. */
static bool find_quad(const ty_model_mesh* mesh, double origin[3], double u[3], double v[3]) {
    if (mesh->triangle_count != 2 || mesh->vertex_count < 4) return false;
    for (int first = 0; first < 3; ++first) {
        const uint32_t a = mesh->indices[first], b = mesh->indices[(first + 1) % 3], c = mesh->indices[(first + 2) % 3];
        for (int other = 3; other < 6; ++other) { /* the second triangle has c, b and the fourth corner */
            const uint32_t d = mesh->indices[other], e = mesh->indices[3 + (other + 1 - 3) % 3],
                           f = mesh->indices[3 + (other + 2 - 3) % 3];
            const float *pa = mesh->positions + 3 * (size_t)a, *pb = mesh->positions + 3 * (size_t)b,
                        *pc = mesh->positions + 3 * (size_t)c, *pd = mesh->positions + 3 * (size_t)d;
            if (memcmp(pb, mesh->positions + 3 * (size_t)f, 12) != 0 ||
                memcmp(pc, mesh->positions + 3 * (size_t)e, 12) != 0)
                continue;
            double size = 0, error = 0;
            for (int k = 0; k < 3; ++k) {
                origin[k] = (double)pa[k];
                u[k] = (double)pb[k] - origin[k];
                v[k] = (double)pc[k] - origin[k];
                size = fmax(size, fmax(fabs(u[k]), fabs(v[k])));
                error = fmax(error, fabs(origin[k] + u[k] + v[k] - (double)pd[k]));
            }
            if (error <= 1e-5 * size) return true;
        }
    }
    return false;
}

json_t* ty_conversion_part_quad(const ty_conversion* conversion, int32_t part) {
    const ty_conversion_instance* only = NULL;
    const ty_conversion_part* own = &conversion->parts[part];
    if (own->medium >= 0 || own->material < 0 || conversion->materials[own->material].textured) return NULL;
    for (size_t i = 0; i < conversion->instance_count; ++i) {
        if (conversion->meshes[conversion->instances[i].mesh].part != part) continue;
        if (only != NULL) return NULL;
        only = &conversion->instances[i];
    }
    double origin[3], u[3], v[3];
    if (only == NULL || !is_identity(&only->transform)) return NULL;
    if (!find_quad(&conversion->meshes[only->mesh].mesh, origin, u, v)) return NULL;
    return json_pack("{s:{s:o, s:o, s:o}}", "quad", "origin", ty_conversion_vector(origin, 3), "u",
                     ty_conversion_vector(u, 3), "v", ty_conversion_vector(v, 3));
}
