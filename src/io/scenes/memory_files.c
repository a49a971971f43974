#include "io/scenes/memory_files.h"

#include "base/context.h"
#include "grid/grid.h"
#include "image/image.h"
#include "io/file.h"
#include "io/schema_text.h"

#include <ctype.h>
#include <string.h>

static const char prefix[] = "memory:";
enum { NAME_SIZE_MAX = 64 };

bool ty_is_memory_name(const char* path) {
    return strncmp(path, prefix, sizeof prefix - 1) == 0;
}

/* ---- the list ---- */

static void destroy(ty_context* context, ty_memory_file* memory) {
    if (memory == NULL) return;
    for (int c = 0; c < 3; ++c) ty_grid_release(memory->grids[c]);
    ty_image_destroy(memory->image);
    ty_scene_destroy(memory->mesh);
    ty_free_text(context, memory->file.path);
    ty_free_array(context, memory, 1, sizeof *memory);
}

static size_t index_of(const ty_asset_cache* cache, const char* path) {
    size_t i = 0;
    while (i < cache->memory_count && strcmp(cache->memory[i]->file.path, path) != 0) ++i;
    return i;
}

ty_result ty_memory_find(const ty_asset_cache* cache, const char* path, const ty_asset_file** out) {
    const size_t i = index_of(cache, path);
    if (i < cache->memory_count) {
        *out = &cache->memory[i]->file;
        return TY_OK;
    }
    char text[512] = "";
    ty_append_quoted(text, sizeof text, path);
    ty_append(text, sizeof text, ": the program has given nothing of this name");
    for (size_t k = 0; k < cache->memory_count; ++k)
        ty_append(text, sizeof text, "%s %s", k == 0 ? "; known:" : ",", cache->memory[k]->file.path);
    return ty_fail(cache->context, TY_ERROR_INPUT, "%s", text);
}

static ty_result check_name(ty_context* context, const char* name) {
    size_t length = 0;
    if (name != NULL)
        while (isalnum((unsigned char)name[length]) || (name[length] != '\0' && strchr("_.-", name[length]) != NULL))
            ++length;
    if (length > 0 && length <= NAME_SIZE_MAX && name[length] == '\0') return TY_OK;
    return ty_fail(context, TY_ERROR_ARGUMENT, "names of content in memory are 1..%d letters, digits and _.-",
                   (int)NAME_SIZE_MAX);
}

static ty_result start(ty_asset_cache* cache, const char* name, ty_memory_file** out) {
    ty_context* context = cache->context;
    const ty_result result = check_name(context, name);
    if (result != TY_OK) return result;
    ty_memory_file* memory = ty_alloc_array(context, 1, sizeof *memory, true);
    if (memory == NULL) return TY_ERROR_MEMORY;
    char path[sizeof prefix + NAME_SIZE_MAX] = "";
    ty_append(path, sizeof path, "%s%s", prefix, name);
    memory->file.path = ty_copy_text(context, path);
    memory->file.memory = memory;
    memory->file.digest = TY_HASH_START;
    if (memory->file.path == NULL) {
        destroy(context, memory);
        return TY_ERROR_MEMORY;
    }
    *out = memory;
    return TY_OK;
}

/* Takes over complete content, or destroys it after a failure. */
static ty_result finish(ty_asset_cache* cache, ty_memory_file* memory, ty_result result, bool* replaced) {
    *replaced = false;
    const size_t i = result == TY_OK ? index_of(cache, memory->file.path) : 0;
    if (result == TY_OK && i == cache->memory_count &&
        !ty_grow_array(cache->context, (void**)&cache->memory, &cache->memory_capacity, cache->memory_count,
                       sizeof(ty_memory_file*)))
        result = TY_ERROR_MEMORY;
    if (result != TY_OK) {
        destroy(cache->context, memory);
        return result;
    }
    *replaced = i < cache->memory_count;
    if (*replaced) {
        ty_assets_drop_content(cache, &cache->memory[i]->file);
        destroy(cache->context, cache->memory[i]);
    } else {
        ++cache->memory_count;
    }
    cache->memory[i] = memory;
    return TY_OK;
}

void ty_memory_drop(ty_asset_cache* cache, const char* name) {
    char path[sizeof prefix + NAME_SIZE_MAX] = "";
    ty_append(path, sizeof path, "%s%s", prefix, name);
    const size_t i = index_of(cache, path);
    if (i == cache->memory_count) return;
    ty_assets_drop_content(cache, &cache->memory[i]->file);
    destroy(cache->context, cache->memory[i]);
    cache->memory[i] = cache->memory[--cache->memory_count];
}

void ty_memory_release(ty_asset_cache* cache) {
    for (size_t i = 0; i < cache->memory_count; ++i) destroy(cache->context, cache->memory[i]);
    ty_free_array(cache->context, cache->memory, cache->memory_capacity, sizeof(ty_memory_file*));
}

/* ---- content ---- */

static void hash(ty_memory_file* memory, const void* bytes, size_t size) {
    if (bytes != NULL) memory->file.digest = ty_hash_bytes(memory->file.digest, bytes, size);
}

static void hash_grid(ty_memory_file* memory, const ty_grid* grid) {
    const ty_grid_info info = ty_grid_get_info(grid);
    const int32_t numbers[] = {info.size[0], info.size[1], info.size[2], (int32_t)info.type, info.placed};
    hash(memory, numbers, sizeof numbers);
    hash(memory, &info.background, sizeof info.background);
    hash(memory, info.index_to_local.m, sizeof info.index_to_local.m);
    hash(memory, grid->blocks.table, ty_grid_table_count(&grid->blocks) * sizeof *grid->blocks.table);
    hash(memory, grid->values, grid->stored * ty_grid_value_size(grid->type));
}

ty_result ty_memory_set_volume(ty_asset_cache* cache, const char* name, ty_grid* const* grids, int32_t count,
                               bool* replaced) {
    bool given = (count == 1 || count == 3) && grids != NULL;
    for (int32_t c = 0; given && c < count; ++c) given = grids[c] != NULL;
    if (!given) return ty_fail(cache->context, TY_ERROR_ARGUMENT, "a volume in memory has one grid or three");
    ty_memory_file* memory = NULL;
    const ty_result result = start(cache, name, &memory);
    if (result != TY_OK) return result;
    memory->grid_count = count;
    for (int32_t c = 0; c < count; ++c) {
        memory->grids[c] = ty_grid_retain(grids[c]);
        hash_grid(memory, grids[c]);
    }
    return finish(cache, memory, TY_OK, replaced);
}

static void hash_mesh(ty_memory_file* memory, const ty_mesh_def* def) {
    const size_t vertices = (size_t)def->vertex_count;
    hash(memory, def->positions, 3 * vertices * sizeof(float));
    hash(memory, def->normals, 3 * vertices * sizeof(float));
    for (int i = 0; i < 2; ++i) hash(memory, def->uv[i], 2 * vertices * sizeof(float));
    hash(memory, def->colors, 4 * vertices * sizeof(float));
    hash(memory, def->tangents, 4 * vertices * sizeof(float));
    hash(memory, def->indices, 3 * (size_t)def->triangle_count * sizeof(uint32_t));
}

ty_result ty_memory_set_mesh(ty_asset_cache* cache, const char* name, const ty_mesh_def* def, bool* replaced) {
    ty_memory_file* memory = NULL;
    ty_mesh_def kept = ty_default_mesh_def();
    ty_result result = start(cache, name, &memory);
    if (result != TY_OK) return result;
    result = ty_scene_create(cache->context, TY_AXIS_Y, &memory->mesh);
    if (result == TY_OK) result = ty_scene_add_mesh(memory->mesh, def);
    if (result == TY_OK) result = ty_scene_get_mesh(memory->mesh, 0, &kept);
    if (result == TY_OK) hash_mesh(memory, &kept);
    return finish(cache, memory, result, replaced);
}

/* A copy of the colour channels, and with `alpha` of A where the image has one. */
static ty_result copy_colors(ty_context* context, const ty_image* image, bool alpha, ty_image** out) {
    static const char* const names[] = {"R", "G", "B", "A"};
    const float* planes[4];
    if (image == NULL || !ty_image_rgb_planes(image, planes))
        return ty_fail(context, TY_ERROR_ARGUMENT, "an image in memory has no R, G, B");
    const int32_t width = ty_image_width(image), height = ty_image_height(image);
    const int32_t a = alpha ? ty_image_find_channel(image, names[3]) : -1;
    if (a >= 0) planes[3] = ty_image_plane_const(image, a);
    const int32_t count = a >= 0 ? 4 : 3;
    const ty_result result = ty_image_create(context, width, height, count, names, out);
    if (result != TY_OK) return result;
    for (int c = 0; c < count; ++c)
        memcpy(ty_image_plane(*out, c), planes[c], (size_t)width * (size_t)height * sizeof(float));
    return TY_OK;
}

ty_result ty_memory_set_image(ty_asset_cache* cache, const char* name, const ty_image* image, bool* replaced) {
    ty_memory_file* memory = NULL;
    ty_result result = start(cache, name, &memory);
    if (result != TY_OK) return result;
    result = copy_colors(cache->context, image, true, &memory->image);
    if (result == TY_OK) {
        const int32_t size[] = {ty_image_width(image), ty_image_height(image)};
        hash(memory, size, sizeof size);
        for (int c = 0; c < ty_image_channel_count(memory->image); ++c)
            hash(memory, ty_image_plane_const(memory->image, c), (size_t)size[0] * (size_t)size[1] * sizeof(float));
    }
    return finish(cache, memory, result, replaced);
}

/* ---- uses ---- */

static ty_result fail_kind(const ty_asset_cache* cache, const ty_asset_file* file, const char* wanted) {
    const ty_memory_file* memory = file->memory;
    const char* kind = memory->image != NULL ? "an image" : memory->mesh != NULL ? "a mesh" : "a volume";
    return ty_fail(cache->context, TY_ERROR_INPUT, "%s is %s, not %s", file->path, kind, wanted);
}

ty_result ty_memory_components(const ty_asset_cache* cache, const ty_asset_file* file, int32_t* components) {
    *components = file->memory->grid_count;
    return *components > 0 ? TY_OK : fail_kind(cache, file, "a volume");
}

ty_result ty_memory_grid(const ty_asset_cache* cache, const ty_asset_file* file, int32_t component, ty_grid** out) {
    const ty_memory_file* memory = file->memory;
    if (memory->grid_count == 0) return fail_kind(cache, file, "a volume");
    if (component < 0 || component >= memory->grid_count)
        return ty_fail(cache->context, TY_ERROR_INPUT, "%s has the components 0..%d, not %d", file->path,
                       (int)memory->grid_count - 1, (int)component);
    *out = memory->grids[component];
    return TY_OK;
}

ty_result ty_memory_image(const ty_asset_cache* cache, const ty_asset_file* file, ty_image** out) {
    if (file->memory->image == NULL) return fail_kind(cache, file, "an image");
    return copy_colors(cache->context, file->memory->image, false, out);
}

/* A number of 0..1 in a byte; NaN: 0. */
static uint8_t byte_of(float value) {
    return value > 0 ? (uint8_t)(255 * (value < 1 ? value : 1) + 0.5f) : 0;
}

ty_result ty_memory_texels(const ty_asset_cache* cache, const ty_asset_file* file, bool colors, int32_t* width,
                           int32_t* height, uint8_t** rgba8) {
    const ty_image* image = file->memory->image;
    if (image == NULL) return fail_kind(cache, file, "an image");
    *width = ty_image_width(image);
    *height = ty_image_height(image);
    const size_t pixels = (size_t)*width * (size_t)*height;
    *rgba8 = ty_alloc_array(cache->context, pixels, 4, false);
    if (*rgba8 == NULL) return TY_ERROR_MEMORY;
    const bool alpha = ty_image_channel_count(image) == 4;
    for (int c = 0; c < 4; ++c) {
        const float* plane = c < 3 || alpha ? ty_image_plane_const(image, c) : NULL;
        for (size_t i = 0; i < pixels; ++i)
            (*rgba8)[4 * i + (size_t)c] = plane == NULL     ? 255
                                          : colors && c < 3 ? ty_tone_byte(plane[i], 1, TY_TONE_CLIP)
                                                            : byte_of(plane[i]);
    }
    return TY_OK;
}

ty_result ty_memory_add_mesh(const ty_asset_cache* cache, const ty_asset_file* file, const ty_mesh_file_def* def,
                             ty_scene* scene) {
    if (file->memory->mesh == NULL) return fail_kind(cache, file, "a mesh");
    ty_mesh_def mesh = ty_default_mesh_def();
    const ty_result result = ty_scene_get_mesh(file->memory->mesh, 0, &mesh);
    if (result != TY_OK || !def->meshes) return result;
    mesh.transform = def->transform;
    if (def->material != NULL) mesh.material = *def->material;
    return ty_scene_add_mesh(scene, &mesh);
}

ty_result ty_memory_closed_mesh(const ty_asset_cache* cache, const ty_asset_file* file, const ty_mesh_file_def* def,
                                ty_closed_mesh** out) {
    ty_context* context = cache->context;
    if (file->memory->mesh == NULL) return fail_kind(cache, file, "a mesh");
    ty_mesh_def mesh = ty_default_mesh_def();
    ty_result result = ty_scene_get_mesh(file->memory->mesh, 0, &mesh);
    if (result != TY_OK) return result;
    const size_t floats = 3 * (size_t)mesh.vertex_count;
    float* positions = ty_alloc_array(context, floats, sizeof *positions, false);
    if (positions == NULL) return TY_ERROR_MEMORY;
    for (size_t i = 0; i < floats; i += 3) {
        const double point[3] = {mesh.positions[i], mesh.positions[i + 1], mesh.positions[i + 2]};
        double mapped[3];
        ty_affine_point(&def->transform, point, mapped);
        for (int a = 0; a < 3; ++a) positions[i + (size_t)a] = (float)mapped[a];
    }
    result = ty_closed_mesh_create(context, positions, mesh.vertex_count, mesh.indices, mesh.triangle_count, out);
    ty_free_array(context, positions, floats, sizeof *positions);
    return result;
}
