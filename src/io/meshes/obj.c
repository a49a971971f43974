/* Wavefront OBJ files: positions, texture coordinates, normals and polygons. Polygons are split into triangle fans
 * about their first corner, which is right for convex ones. */
#define _POSIX_C_SOURCE 200809L
#include "io/meshes/obj.h"

#include "base/context.h"
#include "io/file.h"
#include "base/number.h"

#include <math.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

enum { LIBRARY_SIZE_MAX = 64 << 20, NUMBERS_MAX = 8 };

#define GROW(obj, items, singular)                                                                                     \
    ty_grow_array((obj)->context, (void**)&(obj)->items, &(obj)->singular##_capacity, (obj)->singular##_count,         \
                  sizeof *(obj)->items)

static ty_result fail(const ty_obj* obj, const char* text) {
    return ty_fail(obj->context, TY_ERROR_INPUT, "%s:%zu: %s", obj->path, obj->line, text);
}

/* ---- vertices ---- */

/* Reads low to high finite numbers of a line. */
static ty_result read_numbers(const ty_obj* obj, ty_words* line, size_t low, size_t high, double numbers[NUMBERS_MAX],
                              size_t* count) {
    *count = 0;
    while (*count < high && ty_next_number(line, &numbers[*count])) ++*count;
    ty_word word;
    if (*count < low || (*count < high && ty_next_word(line, &word)))
        return fail(obj, "numbers are missing or damaged");
    for (size_t i = 0; i < *count; ++i)
        if (!(fabs(numbers[i]) <= 3e38)) return fail(obj, "a number is not finite");
    return TY_OK;
}

/* "v x y z", "v x y z w", "v x y z r g b" */
static ty_result read_position(ty_obj* obj, ty_words* line) {
    double numbers[NUMBERS_MAX];
    size_t count = 0;
    const ty_result result = read_numbers(obj, line, 3, 7, numbers, &count);
    if (result != TY_OK) return result;
    if (!GROW(obj, positions, position) || !GROW(obj, colors, color)) return TY_ERROR_MEMORY;
    float* position = obj->positions[obj->position_count++];
    float* color = obj->colors[obj->color_count++];
    for (int a = 0; a < 3; ++a) position[a] = (float)numbers[a];
    for (int c = 0; c < 3; ++c) color[c] = count >= 6 ? (float)numbers[3 + c] : 1;
    obj->colored = obj->colored || count >= 6;
    return TY_OK;
}

/* v points up in the file. */
static ty_result read_uv(ty_obj* obj, ty_words* line) {
    double numbers[NUMBERS_MAX] = {0};
    size_t count = 0;
    const ty_result result = read_numbers(obj, line, 1, 3, numbers, &count);
    if (result != TY_OK) return result;
    if (!GROW(obj, uv, uv)) return TY_ERROR_MEMORY;
    float* uv = obj->uv[obj->uv_count++];
    uv[0] = (float)numbers[0];
    uv[1] = (float)(1 - (count > 1 ? numbers[1] : 0));
    return TY_OK;
}

static ty_result read_normal(ty_obj* obj, ty_words* line) {
    double numbers[NUMBERS_MAX];
    size_t count = 0;
    const ty_result result = read_numbers(obj, line, 3, 3, numbers, &count);
    if (result != TY_OK) return result;
    if (!GROW(obj, normals, normal)) return TY_ERROR_MEMORY;
    float* normal = obj->normals[obj->normal_count++];
    for (int a = 0; a < 3; ++a) normal[a] = (float)numbers[a];
    return TY_OK;
}

/* ---- faces ---- */

/* References count from 1, or backwards from the last element with -1. They may lead to later lines. */
static ty_result read_index(const ty_obj* obj, const char** at, size_t count, const char* what, int32_t* out) {
    const char* after = *at;
    const int64_t number = ty_parse_integer(*at, &after);
    if (after == *at) return fail(obj, "a face is damaged");
    *at = after;
    const int64_t index = number < 0 ? (int64_t)count + number : number - 1;
    if (index < 0 || index > INT32_MAX)
        return ty_fail(obj->context, TY_ERROR_INPUT, "%s:%zu: there is no %s %lld, but %zu so far", obj->path,
                       obj->line, what, (long long)number, count);
    *out = (int32_t)index;
    return TY_OK;
}

/* Keeps the line of the first reference to the farthest position, for the check once all are known. */
static void note_position(ty_obj* obj, int32_t position) {
    if ((size_t)position < obj->position_reach) return;
    obj->position_reach = (size_t)position + 1;
    obj->position_reach_line = obj->line;
}

/* "7", "7/3", "7/3/5", "7//5" */
static ty_result read_corner(ty_obj* obj, ty_word word, ty_obj_corner* corner) {
    const char *at = word.text, *end = word.text + word.length;
    *corner = (ty_obj_corner){-1, -1, -1};
    ty_result result = read_index(obj, &at, obj->position_count, "vertex", &corner->position);
    if (result == TY_OK && at < end && *at == '/') {
        ++at;
        if (at < end && *at != '/') result = read_index(obj, &at, obj->uv_count, "texture vertex", &corner->uv);
    }
    if (result == TY_OK && at < end && *at == '/') {
        ++at;
        result = at < end ? read_index(obj, &at, obj->normal_count, "normal", &corner->normal) : TY_OK;
    }
    if (result == TY_OK) note_position(obj, corner->position);
    return result == TY_OK && at != end ? fail(obj, "a face is damaged") : result;
}

/* Faces must name positions that are there. Without the normal or the texture vertex that it names, a corner has
 * none. */
static ty_result check_references(ty_obj* obj) {
    if (obj->position_reach > obj->position_count)
        return ty_fail(obj->context, TY_ERROR_INPUT, "%s:%zu: there is no vertex %zu, but %zu", obj->path,
                       obj->position_reach_line, obj->position_reach, obj->position_count);
    for (size_t i = 0; i < 3 * obj->triangle_count; ++i) {
        ty_obj_corner* corner = &obj->triangles[i / 3].corners[i % 3];
        const bool uv = corner->uv >= 0 && (size_t)corner->uv >= obj->uv_count;
        const bool normal = corner->normal >= 0 && (size_t)corner->normal >= obj->normal_count;
        if (uv) corner->uv = -1;
        if (normal) corner->normal = -1;
        obj->dangling += uv || normal;
    }
    return TY_OK;
}

static ty_result read_face(ty_obj* obj, ty_words* line) {
    ty_obj_triangle triangle = {.material = obj->material};
    ty_word word;
    size_t count = 0;
    for (; ty_next_word(line, &word); ++count) {
        ty_obj_corner* corner = &triangle.corners[count < 2 ? count : 2];
        const ty_result result = read_corner(obj, word, corner);
        if (result != TY_OK) return result;
        if (count < 2) continue;
        if (obj->triangle_count >= INT32_MAX / 3) return fail(obj, "more triangles than can be counted");
        if (!GROW(obj, triangles, triangle)) return TY_ERROR_MEMORY;
        obj->triangles[obj->triangle_count++] = triangle;
        triangle.corners[1] = *corner;
    }
    if (count < 3) ++obj->skipped;
    return TY_OK;
}

/* ---- materials ---- */

static ty_result use_material(ty_obj* obj, ty_words* line) {
    if ((obj->want & TY_MODEL_MATERIALS) == 0) return TY_OK;
    const ty_word name = ty_rest_of_line(line);
    const ty_model* model = obj->model;
    for (size_t i = 1; i < model->material_count; ++i)
        if (ty_word_is(name, model->materials[i].name)) {
            obj->material = (int32_t)i;
            return TY_OK;
        }
    obj->material = 0;
    ++obj->unknown;
    return TY_OK;
}

static ty_result read_library(ty_obj* obj, const char* name) {
    char place[512], *path = NULL, *folder = NULL;
    snprintf(place, sizeof place, "%s:%zu", obj->path, obj->line);
    ty_result result = ty_model_inner_path(obj->context, place, obj->folder, name, &path);
    if (result != TY_OK) return result;
    /* A missing material file is a warning: the shapes are still usable. */
    if (access(path, R_OK) != 0) {
        ty_log(obj->context, TY_LOG_WARNING, "%s: there is no material file %s", obj->path, path);
        ty_free_text(obj->context, path);
        return TY_OK;
    }
    uint8_t* bytes = NULL;
    size_t size = 0;
    result = ty_read_file(obj->context, path, LIBRARY_SIZE_MAX, &bytes, &size);
    folder = result == TY_OK ? ty_folder_of(obj->context, path) : NULL;
    if (result == TY_OK)
        result = folder == NULL ? TY_ERROR_MEMORY
                                : ty_read_mtl(obj->context, path, folder, (const char*)bytes, size, obj->model);
    if (bytes != NULL) ty_free_file(obj->context, bytes, size);
    ty_free_text(obj->context, folder);
    ty_free_text(obj->context, path);
    return result;
}

static ty_result use_library(ty_obj* obj, ty_words* line) {
    if ((obj->want & TY_MODEL_MATERIALS) == 0) return TY_OK;
    const ty_word rest = ty_rest_of_line(line);
    char name[1024];
    if (rest.length == 0 || rest.length >= sizeof name) return fail(obj, "the name of a material file is damaged");
    memcpy(name, rest.text, rest.length);
    name[rest.length] = '\0';
    return read_library(obj, name);
}

/* ---- whole file ---- */

static ty_result read_line(ty_obj* obj, ty_words* line) {
    static const char* const left_out[] = {"p", "l", "curv", "curv2", "surf"};
    ty_word word;
    if (!ty_next_word(line, &word)) return TY_OK;
    if (ty_word_is(word, "v")) return read_position(obj, line);
    if (ty_word_is(word, "vt")) return read_uv(obj, line);
    if (ty_word_is(word, "vn")) return read_normal(obj, line);
    if (ty_word_is(word, "f") || ty_word_is(word, "fo")) return read_face(obj, line);
    if (ty_word_is(word, "usemtl")) return use_material(obj, line);
    if (ty_word_is(word, "mtllib")) return use_library(obj, line);
    for (size_t i = 0; i < sizeof left_out / sizeof *left_out; ++i)
        if (ty_word_is(word, left_out[i])) ++obj->skipped;
    return TY_OK;
}

static void warn(const ty_obj* obj) {
    if (obj->skipped > 0)
        ty_log(obj->context, TY_LOG_WARNING, "%s: %zu elements that are no polygons are left out", obj->path,
               obj->skipped);
    if (obj->dangling > 0)
        ty_log(obj->context, TY_LOG_WARNING, "%s: %zu corners name normals or texture vertices that are not there",
               obj->path, obj->dangling);
    if (obj->unknown > 0)
        ty_log(obj->context, TY_LOG_WARNING, "%s: %zu uses of materials that are in no material file", obj->path,
               obj->unknown);
}

static ty_result add_plain_material(ty_obj* obj) {
    if ((obj->want & TY_MODEL_MATERIALS) == 0) {
        obj->material = -1;
        return TY_OK;
    }
    ty_model_material plain = ty_model_plain_material(ty_default_material_def().albedo[0]);
    plain.plain = true;
    plain.name = ty_copy_text(obj->context, "");
    return ty_model_add_material(obj->model, &plain);
}

static void free_obj(ty_obj* obj) {
    ty_free_array(obj->context, obj->positions, obj->position_capacity, sizeof *obj->positions);
    ty_free_array(obj->context, obj->colors, obj->color_capacity, sizeof *obj->colors);
    ty_free_array(obj->context, obj->uv, obj->uv_capacity, sizeof *obj->uv);
    ty_free_array(obj->context, obj->normals, obj->normal_capacity, sizeof *obj->normals);
    ty_free_array(obj->context, obj->triangles, obj->triangle_capacity, sizeof *obj->triangles);
}

ty_result ty_read_obj(ty_context* context, const char* path, const char* folder, const uint8_t* bytes, size_t size,
                      unsigned want, ty_model* model) {
    *model = (ty_model){.context = context};
    ty_obj obj = {.context = context, .path = path, .folder = folder, .want = want, .model = model};
    ty_words text = {(const char*)bytes, (const char*)bytes + size}, line;
    ty_result result = add_plain_material(&obj);
    for (size_t line_count = 0; result == TY_OK;) {
        obj.line = line_count + 1;
        if (!ty_next_line(&text, &line, &line_count)) break;
        result = read_line(&obj, &line);
    }
    if (result == TY_OK && obj.triangle_count == 0)
        result = ty_fail(context, TY_ERROR_INPUT, "%s: there are no faces", path);
    if (result == TY_OK) result = check_references(&obj);
    /* Vertex colors replace those of the material. */
    if (result == TY_OK && obj.colored && model->material_count > 0)
        for (int c = 0; c < 3; ++c) model->materials[0].def.albedo[c] = 1;
    if (result == TY_OK) result = ty_obj_build_meshes(&obj);
    if (result == TY_OK) warn(&obj);
    free_obj(&obj);
    if (result == TY_OK) result = ty_model_decode_images(model);
    return result == TY_OK ? ty_obj_join_maps(model, path) : result;
}
