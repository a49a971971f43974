/* Conversion of mesh files to scenes, closed meshes and cameras. */
#include "base/context.h"
#include "io/meshes/model.h"
#include "io/schema_text.h"
#include "scene/surfaces/gloss.h"

#include <math.h>
#include <stdio.h>
#include <string.h>
#include <tyndall/io.h>

enum { MESSAGE_SIZE = 1024 };

#define INTENSITY_MAX 1e15

void ty_init_mesh_file_def(void* def, size_t bytes) {
    const ty_mesh_file_def own = {.transform = ty_affine_identity(),
                                  .meshes = true,
                                  .lights = true,
                                  .gloss = true,
                                  .light_scale = 1,
                                  .emission_scale = 1};
    ty_init_def(def, bytes, &own, sizeof own);
}

static ty_result check_def(ty_context* context, const char* path, const ty_mesh_file_def** given,
                           ty_mesh_file_def* own) {
    *own = ty_default_mesh_file_def();
    const ty_result result = ty_take_def(context, *given, "ty_default_mesh_file_def", own, sizeof *own);
    const ty_mesh_file_def* def = *given = own;
    ty_affine inverse;
    if (result != TY_OK) return result;
    if (path == NULL) return ty_fail(context, TY_ERROR_ARGUMENT, "a file name is NULL");
    if (!ty_affine_invert(&def->transform, &inverse))
        return ty_fail(context, TY_ERROR_ARGUMENT, "transform: the map cannot be inverted");
    if (!(def->light_scale >= 0 && def->light_scale <= INTENSITY_MAX))
        return ty_fail(context, TY_ERROR_ARGUMENT, "light_scale: %g is outside [0, 1e15]", def->light_scale);
    if (!(def->emission_scale >= 0 && def->emission_scale <= INTENSITY_MAX))
        return ty_fail(context, TY_ERROR_ARGUMENT, "emission_scale: %g is outside [0, 1e15]", def->emission_scale);
    return TY_OK;
}

/* Turns a failure caused by the file's content into the file's error. clean: true if the context had no message
 * before. */
static ty_result file_error(ty_context* context, const char* path, bool clean, ty_result result) {
    if (result != TY_ERROR_ARGUMENT) return result;
    if (!clean) return TY_ERROR_INPUT;
    char text[MESSAGE_SIZE];
    snprintf(text, sizeof text, "%s", ty_take_error(context));
    return ty_fail(context, TY_ERROR_INPUT, "%s: %s", path, text);
}

/* Map from file space to scene space. */
static ty_affine scene_from_file(const ty_mesh_file_def* def) {
    static const ty_affine up = {{1, 0, 0, 0, 0, 0, -1, 0, 0, 1, 0, 0}}; /* (x, y, z) -> (x, -z, y) */
    return def->to_z_up ? ty_affine_multiply(&def->transform, &up) : def->transform;
}

/* Transforms a direction to scene space and normalises it. */
static void transform_direction(const ty_affine* map, const double in[3], double out[3]) {
    double transformed[3], length = 0;
    for (int r = 0; r < 3; ++r) {
        transformed[r] = map->m[4 * r] * in[0] + map->m[4 * r + 1] * in[1] + map->m[4 * r + 2] * in[2];
        length += transformed[r] * transformed[r];
    }
    for (int r = 0; r < 3; ++r) out[r] = transformed[r] / sqrt(length);
}

/* ---- scenes ---- */

typedef struct filler {
    ty_scene* scene;
    ty_context* context;
    const char* path;
    const ty_mesh_file_def* def;
    const ty_model* model;
    ty_affine map;
    bool clean;
    ty_texture** textures;
} filler;

static ty_result make_textures(filler* f) {
    f->textures = ty_alloc_array(f->context, f->model->texture_count, sizeof(ty_texture*), true);
    if (f->textures == NULL) return TY_ERROR_MEMORY;
    for (size_t i = 0; i < f->model->texture_count; ++i) {
        const ty_model_texture* texture = &f->model->textures[i];
        if (texture->image < 0) continue;
        const ty_model_image* image = &f->model->images[texture->image];
        ty_texture_def def = ty_default_texture_def();
        def.width = image->width;
        def.height = image->height;
        def.rgba8 = image->rgba8;
        def.wrap[0] = texture->wrap[0];
        def.wrap[1] = texture->wrap[1];
        def.nearest = texture->nearest;
        def.linear = texture->linear;
        const ty_result result = ty_texture_create(f->context, &def, &f->textures[i]);
        if (result != TY_OK) return file_error(f->context, image->name, f->clean, result);
    }
    return TY_OK;
}

static void free_textures(filler* f) {
    for (size_t i = 0; f->textures != NULL && i < f->model->texture_count; ++i) ty_texture_release(f->textures[i]);
    ty_free_array(f->context, f->textures, f->model->texture_count, sizeof(ty_texture*));
}

static ty_material_def make_material(const filler* f, int32_t index) {
    if (f->def->material != NULL) return *f->def->material;
    const ty_model_material* material = &f->model->materials[index];
    ty_material_def def = material->def;
    if (material->albedo_texture >= 0) def.albedo_texture = f->textures[material->albedo_texture];
    if (material->emission_texture >= 0) def.emission_texture = f->textures[material->emission_texture];
    if (!f->def->gloss) def.gloss = ty_default_material_def().gloss;
    for (int i = 0; f->def->gloss && i < TY_GLOSS_TEXTURES; ++i)
        if (material->gloss_textures[i] >= 0) def.gloss.textures[i].texture = f->textures[material->gloss_textures[i]];
    for (int c = 0; c < 3; ++c) def.emission[c] = (float)(def.emission[c] * f->def->emission_scale);
    return def;
}

/* Instances flattened by their map (to a plane or point) are skipped; some writers hide objects that way. */
static ty_result add_instance(const filler* f, const ty_model_instance* instance, size_t* flat) {
    const ty_model_mesh* mesh = &f->model->meshes[instance->mesh];
    ty_affine inverse;
    ty_mesh_def def = ty_default_mesh_def();
    def.transform = ty_affine_multiply(&f->map, &instance->transform);
    if (!ty_affine_invert(&def.transform, &inverse)) {
        ++*flat;
        return TY_OK;
    }
    def.vertex_count = (int64_t)mesh->vertex_count;
    def.triangle_count = (int64_t)mesh->triangle_count;
    def.positions = mesh->positions;
    def.normals = mesh->normals;
    def.uv[0] = mesh->uv[0];
    def.uv[1] = mesh->uv[1];
    def.colors = mesh->colors;
    def.tangents = mesh->tangents;
    def.indices = mesh->indices;
    def.origin = (ty_mesh_origin){.file = f->path,
                                  .name = instance->name,
                                  .node = instance->node,
                                  .primitive = mesh->primitive,
                                  .first_vertex = (int64_t)mesh->first_vertex,
                                  .vertex_total = (int64_t)mesh->vertex_total};
    def.material = make_material(f, mesh->material);
    return file_error(f->context, f->path, f->clean, ty_scene_add_mesh(f->scene, &def));
}

static ty_result add_light(const filler* f, const ty_light_def* light) {
    ty_light_def def = *light;
    for (int c = 0; c < 3; ++c) def.color[c] = (float)fmin(def.color[c] * f->def->light_scale, INTENSITY_MAX);
    ty_affine_point(&f->map, light->position, def.position);
    transform_direction(&f->map, light->direction, def.direction);
    return file_error(f->context, f->path, f->clean, ty_scene_add_light(f->scene, &def));
}

static ty_result fill_scene(filler* f) {
    size_t flat = 0;
    ty_result result = make_textures(f);
    for (size_t i = 0; i < f->model->instance_count && result == TY_OK; ++i)
        result = add_instance(f, &f->model->instances[i], &flat);
    for (size_t i = 0; i < f->model->light_count && result == TY_OK; ++i) result = add_light(f, &f->model->lights[i]);
    free_textures(f);
    if (result == TY_OK && flat > 0)
        ty_log(f->context, TY_LOG_WARNING, "%s: %zu primitives that are scaled to 0 are left out", f->path, flat);
    return result;
}

ty_result ty_scene_add_mesh_file(ty_scene* scene, const char* path, const ty_mesh_file_def* def) {
    if (scene == NULL) return TY_ERROR_ARGUMENT;
    ty_context* context = ty_scene_context(scene);
    ty_mesh_file_def own;
    ty_result result = check_def(context, path, &def, &own);
    if (result != TY_OK) return result;
    unsigned want = def->lights ? TY_MODEL_LIGHTS : 0;
    if (def->meshes) want |= TY_MODEL_MESHES | TY_MODEL_SHADING | (def->material == NULL ? TY_MODEL_MATERIALS : 0);
    const bool clean = !ty_has_error(context);
    ty_model model;
    result = ty_read_model(context, path, want, &model);
    filler f = {.scene = scene,
                .context = context,
                .path = path,
                .def = def,
                .model = &model,
                .map = scene_from_file(def),
                .clean = clean};
    if (result == TY_OK) result = fill_scene(&f);
    ty_model_free(&model);
    return result;
}

/* A committed scene of the model alone. */
static ty_result make_scene(const ty_model* model, const char* path, ty_scene** out) {
    const ty_mesh_file_def def = ty_default_mesh_file_def();
    filler f = {.context = model->context,
                .path = path,
                .def = &def,
                .model = model,
                .map = ty_affine_identity(),
                .clean = !ty_has_error(model->context)};
    ty_result result = ty_scene_create(model->context, TY_AXIS_Y, &f.scene);
    if (result == TY_OK) result = fill_scene(&f);
    if (result == TY_OK) result = ty_scene_commit(f.scene);
    if (result == TY_OK)
        *out = f.scene;
    else
        ty_scene_destroy(f.scene);
    return result;
}

static ty_result describe(const ty_model* model, const char* path, ty_scene_info* out) {
    ty_scene* scene = NULL;
    const ty_result result = make_scene(model, path, &scene);
    if (result == TY_OK) *out = ty_scene_get_info(scene);
    ty_scene_destroy(scene);
    return result;
}

static void add_entry(const ty_mesh_file_entry* entry, const char* name, ty_mesh_file_entry* entries, int32_t capacity,
                      int32_t* count) {
    if (*count < capacity) {
        entries[*count] = *entry;
        snprintf(entries[*count].name, sizeof entry->name, "%s", name);
    }
    ++*count;
}

static ty_mesh_file_entry material_entry(const ty_model_material* material) {
    ty_mesh_file_entry entry = {.material = material->def,
                                .glossy = ty_gloss_exists(&material->def.gloss),
                                .base_texture = material->albedo_texture >= 0,
                                .emission_texture = material->emission_texture >= 0};
    for (int i = 0; i < TY_GLOSS_TEXTURES; ++i) entry.textures[i] = material->gloss_textures[i] >= 0;
    entry.glossy = entry.glossy || entry.textures[TY_GLOSS_NORMAL];
    return entry;
}

static void list_entries(const ty_model* model, ty_mesh_file_entry* entries, int32_t capacity, int32_t* count) {
    *count = 0;
    for (size_t i = 0; i < model->material_count; ++i) {
        const ty_mesh_file_entry entry = material_entry(&model->materials[i]);
        if (!model->materials[i].plain) add_entry(&entry, model->materials[i].name, entries, capacity, count);
    }
    for (size_t i = 0; i < model->camera_count; ++i) {
        const ty_mesh_file_entry entry = {.camera = true, .fov_y = model->cameras[i].fov_y};
        add_entry(&entry, model->cameras[i].name, entries, capacity, count);
    }
}

ty_result ty_mesh_file_list(ty_context* context, const char* path, ty_scene_info* out, ty_mesh_file_entry* entries,
                            int32_t capacity, int32_t* count) {
    if (path == NULL || out == NULL || count == NULL || (entries == NULL && capacity > 0))
        return ty_fail(context, TY_ERROR_ARGUMENT, "ty_mesh_file_list: path, out, entries or count is NULL");
    ty_model model;
    ty_result result = ty_read_model(context, path, TY_MODEL_ALL, &model);
    if (result == TY_OK) result = describe(&model, path, out);
    if (result == TY_OK) list_entries(&model, entries, capacity, count);
    ty_model_free(&model);
    return result;
}

/* ---- closed meshes ---- */

static bool is_mirrored(const ty_affine* map) {
    const double* m = map->m;
    return m[0] * (m[5] * m[10] - m[6] * m[9]) - m[1] * (m[4] * m[10] - m[6] * m[8]) +
               m[2] * (m[4] * m[9] - m[5] * m[8]) <
           0;
}

/* Transforms a mesh to scene space and offsets its indices by `first`; mirrored maps reverse the corners, which
 * keeps the orientation outward. */
static void transform_mesh(const ty_model_mesh* mesh, const ty_affine* map, uint32_t first, float* positions,
                           uint32_t* indices) {
    for (size_t i = 0; i < mesh->vertex_count; ++i) {
        double point[3];
        for (size_t a = 0; a < 3; ++a) point[a] = (double)mesh->positions[3 * i + a];
        ty_affine_point(map, point, point);
        for (size_t a = 0; a < 3; ++a) positions[3 * i + a] = (float)point[a];
    }
    const size_t second = is_mirrored(map) ? 2 : 1;
    for (size_t i = 0; i < mesh->triangle_count; ++i) {
        indices[3 * i] = first + mesh->indices[3 * i];
        indices[3 * i + 1] = first + mesh->indices[3 * i + second];
        indices[3 * i + 2] = first + mesh->indices[3 * i + 3 - second];
    }
}

/* Concatenates all triangles of a model. */
static void join_instances(const ty_model* model, const ty_affine* to_scene, float* positions, uint32_t* indices) {
    uint32_t first = 0;
    size_t triangles = 0;
    for (size_t i = 0; i < model->instance_count; ++i) {
        const ty_model_mesh* mesh = &model->meshes[model->instances[i].mesh];
        const ty_affine map = ty_affine_multiply(to_scene, &model->instances[i].transform);
        transform_mesh(mesh, &map, first, positions + 3 * (size_t)first, indices + 3 * triangles);
        first += (uint32_t)mesh->vertex_count;
        triangles += mesh->triangle_count;
    }
}

static ty_result make_shell(const ty_model* model, const char* path, const ty_affine* map, ty_closed_mesh** out) {
    ty_context* context = model->context;
    const bool clean = !ty_has_error(context);
    const size_t triangles = (size_t)ty_model_triangles(model);
    uint64_t vertices = 0;
    for (size_t i = 0; i < model->instance_count; ++i) vertices += model->meshes[model->instances[i].mesh].vertex_count;
    if (triangles == 0) return ty_fail(context, TY_ERROR_INPUT, "%s: there are no triangles", path);
    if (vertices > INT32_MAX)
        return ty_fail(context, TY_ERROR_INPUT, "%s: more than 2^31 - 1 vertices in one shell", path);
    float* positions = ty_alloc_array(context, (size_t)vertices, 3 * sizeof(float), false);
    uint32_t* indices = ty_alloc_array(context, triangles, 3 * sizeof(uint32_t), false);
    ty_result result = TY_ERROR_MEMORY;
    if (positions != NULL && indices != NULL) {
        join_instances(model, map, positions, indices);
        result = ty_closed_mesh_create(context, positions, (int64_t)vertices, indices, (int64_t)triangles, out);
    }
    ty_free_array(context, positions, (size_t)vertices, 3 * sizeof(float));
    ty_free_array(context, indices, triangles, 3 * sizeof(uint32_t));
    return file_error(context, path, clean, result);
}

ty_result ty_mesh_file_create_closed_mesh(ty_context* context, const char* path, const ty_mesh_file_def* def,
                                          ty_closed_mesh** out) {
    ty_mesh_file_def own;
    ty_result result = check_def(context, path, &def, &own);
    if (result == TY_OK && out == NULL)
        result = ty_fail(context, TY_ERROR_ARGUMENT, "ty_mesh_file_create_closed_mesh: out is NULL");
    if (result != TY_OK) return result;
    const ty_affine map = scene_from_file(def);
    ty_model model;
    result = ty_read_model(context, path, TY_MODEL_MESHES, &model);
    if (result == TY_OK) result = make_shell(&model, path, &map, out);
    ty_model_free(&model);
    return result;
}

/* ---- cameras ---- */

static ty_result fail_name(const ty_model* model, const char* path, const char* name) {
    char text[MESSAGE_SIZE / 2] = "";
    ty_append(text, sizeof text, "no camera ");
    ty_append_quoted(text, sizeof text, name);
    ty_append(text, sizeof text, model->camera_count == 0 ? "; there is none" : "; known:");
    for (size_t i = 0; i < model->camera_count; ++i) {
        ty_append(text, sizeof text, i > 0 ? ", " : " ");
        ty_append_quoted(text, sizeof text, model->cameras[i].name);
    }
    return ty_fail(model->context, TY_ERROR_INPUT, "%s: %s", path, text);
}

/* Camera of the given name, or the first; perspective cameras take precedence. */
static const ty_model_camera* find_camera(const ty_model* model, const char* name) {
    const ty_model_camera* found = NULL;
    for (size_t i = 0; i < model->camera_count; ++i) {
        const ty_model_camera* camera = &model->cameras[i];
        if (name != NULL && strcmp(camera->name, name) != 0) continue;
        if (found == NULL || (found->orthographic && !camera->orthographic)) found = camera;
    }
    return found;
}

static void transform_camera(const ty_affine* map, const ty_model_camera* found, ty_camera_def* camera) {
    double forward[3];
    ty_affine_point(map, found->position, camera->position);
    transform_direction(map, found->forward, forward);
    transform_direction(map, found->up, camera->up);
    for (int a = 0; a < 3; ++a) camera->target[a] = camera->position[a] + forward[a];
    camera->fov_y = found->fov_y;
}

ty_result ty_mesh_file_camera(ty_context* context, const char* path, const ty_mesh_file_def* def, const char* name,
                              ty_camera_def* camera, bool* found) {
    ty_mesh_file_def own;
    ty_result result = check_def(context, path, &def, &own);
    if (result == TY_OK && (camera == NULL || found == NULL))
        result = ty_fail(context, TY_ERROR_ARGUMENT, "ty_mesh_file_camera: camera or found is NULL");
    if (result != TY_OK) return result;
    const ty_affine map = scene_from_file(def);
    ty_model model;
    result = ty_read_model(context, path, TY_MODEL_CAMERAS, &model);
    const ty_model_camera* chosen = result == TY_OK ? find_camera(&model, name) : NULL;
    if (chosen != NULL && chosen->orthographic)
        result = ty_fail(context, TY_ERROR_INPUT, "%s: the camera \"%.64s\" is orthographic; only perspective is known",
                         path, chosen->name);
    else if (result == TY_OK && chosen == NULL && name != NULL)
        result = fail_name(&model, path, name);
    if (result == TY_OK) *found = chosen != NULL;
    if (result == TY_OK && chosen != NULL) transform_camera(&map, chosen, camera);
    ty_model_free(&model);
    return result;
}
