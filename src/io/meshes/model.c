/* Models: allocation, building and release of a mesh file's content. */
#include "io/meshes/model.h"

#include "base/context.h"
#include "io/file.h"
#include "io/images/image_file.h"
#include "io/schema_text.h"

#include <errno.h>
#include <math.h>
#include <string.h>

/* ---- allocation and release ---- */

ty_result ty_model_alloc_mesh(ty_context* context, ty_model_mesh* mesh, bool normals, bool uv0, bool uv1, bool colors) {
    const size_t count = mesh->vertex_count, vec2 = 2 * sizeof(float), vec3 = 3 * sizeof(float);
    bool done = (mesh->positions = ty_alloc_array(context, count, vec3, true)) != NULL;
    done = done && (mesh->indices = ty_alloc_array(context, mesh->triangle_count, 3 * sizeof(uint32_t), true)) != NULL;
    if (normals) done = done && (mesh->normals = ty_alloc_array(context, count, vec3, true)) != NULL;
    if (uv0) done = done && (mesh->uv[0] = ty_alloc_array(context, count, vec2, true)) != NULL;
    if (uv1) done = done && (mesh->uv[1] = ty_alloc_array(context, count, vec2, true)) != NULL;
    if (colors) done = done && (mesh->colors = ty_alloc_array(context, count, 4 * sizeof(float), true)) != NULL;
    if (done) return TY_OK;
    ty_model_free_mesh(context, mesh);
    return TY_ERROR_MEMORY;
}

void ty_model_free_mesh(ty_context* context, ty_model_mesh* mesh) {
    const size_t count = mesh->vertex_count;
    ty_free_array(context, mesh->positions, count, 3 * sizeof(float));
    ty_free_array(context, mesh->normals, count, 3 * sizeof(float));
    for (int i = 0; i < 2; ++i) ty_free_array(context, mesh->uv[i], count, 2 * sizeof(float));
    ty_free_array(context, mesh->colors, count, 4 * sizeof(float));
    ty_free_array(context, mesh->tangents, count, 4 * sizeof(float));
    ty_free_array(context, mesh->indices, mesh->triangle_count, 3 * sizeof(uint32_t));
    *mesh = (ty_model_mesh){0};
}

static void free_encoded(ty_context* context, ty_model_image* image) {
    if (image->encoded != NULL) ty_free_file(context, image->encoded, image->encoded_size);
    image->encoded = NULL;
}

static void free_image(ty_context* context, ty_model_image* image) {
    ty_free_text(context, image->name);
    free_encoded(context, image);
    ty_free_array(context, image->rgba8, (size_t)image->width * (size_t)image->height, 4);
}

void ty_model_free(ty_model* model) {
    ty_context* context = model->context;
    if (context == NULL) return;
    for (size_t i = 0; i < model->mesh_count; ++i) ty_model_free_mesh(context, &model->meshes[i]);
    for (size_t i = 0; i < model->instance_count; ++i) ty_free_text(context, model->instances[i].name);
    for (size_t i = 0; i < model->image_count; ++i) free_image(context, &model->images[i]);
    for (size_t i = 0; i < model->material_count; ++i) ty_free_text(context, model->materials[i].name);
    for (size_t i = 0; i < model->camera_count; ++i) ty_free_text(context, model->cameras[i].name);
    ty_free_array(context, model->meshes, model->mesh_capacity, sizeof *model->meshes);
    ty_free_array(context, model->instances, model->instance_capacity, sizeof *model->instances);
    ty_free_array(context, model->images, model->image_capacity, sizeof *model->images);
    ty_free_array(context, model->textures, model->texture_capacity, sizeof *model->textures);
    ty_free_array(context, model->materials, model->material_capacity, sizeof *model->materials);
    ty_free_array(context, model->lights, model->light_capacity, sizeof *model->lights);
    ty_free_array(context, model->cameras, model->camera_capacity, sizeof *model->cameras);
    *model = (ty_model){0};
}

/* ---- adding elements ---- */

#define GROW(model, items, singular)                                                                                   \
    ty_grow_array((model)->context, (void**)&(model)->items, &(model)->singular##_capacity, (model)->singular##_count, \
                  sizeof *(model)->items)

ty_result ty_model_add_mesh(ty_model* model, ty_model_mesh* mesh) {
    if (!GROW(model, meshes, mesh)) {
        ty_model_free_mesh(model->context, mesh);
        return TY_ERROR_MEMORY;
    }
    model->meshes[model->mesh_count++] = *mesh;
    return TY_OK;
}

ty_result ty_model_add_instance(ty_model* model, size_t mesh, const ty_affine* transform, int32_t node,
                                const char* name) {
    char* copy = ty_copy_text(model->context, name);
    if (copy == NULL || !GROW(model, instances, instance)) {
        ty_free_text(model->context, copy);
        return TY_ERROR_MEMORY;
    }
    model->instances[model->instance_count++] = (ty_model_instance){(int32_t)mesh, *transform, node, copy};
    return TY_OK;
}

ty_result ty_model_add_image(ty_model* model, ty_model_image* image) {
    if (image->name == NULL || !GROW(model, images, image)) {
        free_image(model->context, image);
        return TY_ERROR_MEMORY;
    }
    model->images[model->image_count++] = *image;
    return TY_OK;
}

ty_result ty_model_add_texture(ty_model* model, const ty_model_texture* texture) {
    if (!GROW(model, textures, texture)) return TY_ERROR_MEMORY;
    model->textures[model->texture_count++] = *texture;
    return TY_OK;
}

ty_result ty_model_add_material(ty_model* model, ty_model_material* material) {
    if (material->name == NULL || !GROW(model, materials, material)) {
        ty_free_text(model->context, material->name);
        return TY_ERROR_MEMORY;
    }
    model->materials[model->material_count++] = *material;
    return TY_OK;
}

ty_result ty_model_add_light(ty_model* model, const ty_light_def* light) {
    if (!GROW(model, lights, light)) return TY_ERROR_MEMORY;
    model->lights[model->light_count++] = *light;
    return TY_OK;
}

ty_result ty_model_add_camera(ty_model* model, ty_model_camera* camera) {
    if (camera->name == NULL || !GROW(model, cameras, camera)) {
        ty_free_text(model->context, camera->name);
        return TY_ERROR_MEMORY;
    }
    model->cameras[model->camera_count++] = *camera;
    return TY_OK;
}

ty_model_material ty_model_plain_material(float albedo) {
    ty_model_material material = {.def = ty_default_material_def(), .albedo_texture = -1, .emission_texture = -1};
    for (int c = 0; c < 3; ++c) material.def.albedo[c] = albedo;
    for (int i = 0; i < TY_GLOSS_TEXTURES; ++i) material.gloss_textures[i] = -1;
    for (int i = 0; i < TY_SINGLE_MAPS; ++i) material.single_textures[i] = -1;
    return material;
}

/* ---- finishing ---- */

static float finite_or_zero(float value) {
    return isfinite(value) ? value : 0;
}

/* Double precision, in which squares of floats neither overflow nor vanish. */
static void tidy_unit(float n[3]) {
    const double x = (double)n[0], y = (double)n[1], z = (double)n[2];
    const double length = sqrt(x * x + y * y + z * z);
    for (int a = 0; a < 3; ++a) n[a] = length > 0 && isfinite(length) ? (float)((double)n[a] / length) : 0;
}

void ty_model_tidy_shading(ty_model_mesh* mesh) {
    const size_t count = mesh->vertex_count;
    for (size_t i = 0; mesh->normals != NULL && i < count; ++i) tidy_unit(mesh->normals + 3 * i);
    for (int set = 0; set < 2; ++set)
        for (size_t i = 0; mesh->uv[set] != NULL && i < 2 * count; ++i)
            mesh->uv[set][i] = finite_or_zero(mesh->uv[set][i]);
    for (size_t i = 0; mesh->tangents != NULL && i < count; ++i) {
        tidy_unit(mesh->tangents + 4 * i);
        mesh->tangents[4 * i + 3] = mesh->tangents[4 * i + 3] < 0 ? -1 : 1;
    }
    for (size_t i = 0; mesh->colors != NULL && i < 4 * count; ++i)
        mesh->colors[i] = mesh->colors[i] > 0 ? fminf(mesh->colors[i], 1) : 0;
}

typedef struct decoding {
    ty_model* model;
    ty_result* results;
} decoding;

static void decode(void* user, int64_t index, int32_t worker) {
    (void)worker;
    const decoding* shared = user;
    ty_context* context = shared->model->context;
    ty_model_image* image = &shared->model->images[index];
    if (image->rgba8 != NULL) return;
    shared->results[index] = ty_decode_rgba8(context, image->name, image->encoded, image->encoded_size, &image->width,
                                             &image->height, &image->rgba8);
    free_encoded(context, image);
}

ty_result ty_model_decode_images(ty_model* model) {
    const size_t count = model->image_count;
    if (count == 0) return TY_OK;
    ty_result* results = ty_alloc_array(model->context, count, sizeof *results, true);
    if (results == NULL) return TY_ERROR_MEMORY;
    decoding shared = {model, results};
    ty_parallel_for(model->context, (int64_t)count, decode, &shared);
    ty_result result = TY_OK;
    for (size_t i = 0; i < count && result == TY_OK; ++i) result = results[i];
    ty_free_array(model->context, results, count, sizeof *results);
    return result;
}

int64_t ty_model_triangles(const ty_model* model) {
    int64_t sum = 0;
    for (size_t i = 0; i < model->instance_count; ++i)
        sum += (int64_t)model->meshes[model->instances[i].mesh].triangle_count;
    return sum;
}

/* ---- file names ---- */

/* True if the segments of a relative path never lead above its start. */
static bool is_inside_folder(const char* name) {
    int depth = 0;
    for (const char* at = name; *at != '\0';) {
        const size_t length = strcspn(at, "/");
        if (length == 2 && at[0] == '.' && at[1] == '.')
            --depth;
        else if (length > 0 && !(length == 1 && at[0] == '.'))
            ++depth;
        if (depth < 0) return false;
        at += length + (at[length] == '/');
    }
    return true;
}

ty_result ty_model_inner_path(ty_context* context, const char* location, const char* folder, const char* name,
                              char** out) {
    char quoted[128] = "";
    ty_append_quoted(quoted, sizeof quoted, name);
    if (folder == NULL)
        return ty_fail(context, TY_ERROR_INPUT, "%s: %s: other files may not be named here", location, quoted);
    const bool scheme = strcspn(name, ":") < strcspn(name, "/?#"); /* "http:", "C:" */
    if (name[0] == '\0' || name[0] == '/' || scheme)
        return ty_fail(context, TY_ERROR_INPUT, "%s: %s is not a path relative to the file", location, quoted);
    if (!is_inside_folder(name))
        return ty_fail(context, TY_ERROR_INPUT, "%s: %s leads out of the file's folder", location, quoted);
    *out = ty_join_path(context, folder, name);
    return *out == NULL ? TY_ERROR_MEMORY : TY_OK;
}

ty_result ty_model_read_reference(ty_context* context, const char* location, const char* path, size_t limit,
                                  ty_file_form_fn inspect, uint8_t** bytes, size_t* size) {
    uint64_t length = 0;
    FILE* stream = ty_open_regular(path, &length);
    if (stream == NULL)
        return ty_fail(context, TY_ERROR_FILE, "%s: cannot open %s: %s", location, path,
                       errno != 0 ? strerror(errno) : "not a regular file");
    fclose(stream);
    return ty_read_inspected_file(context, path, limit, inspect, bytes, size);
}
