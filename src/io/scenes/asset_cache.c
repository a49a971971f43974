#define _GNU_SOURCE
#include "io/scenes/asset_cache.h"

#include "base/context.h"
#include "grid/grid.h"
#include "io/file.h"
#include "io/scenes/memory_files.h"
#include "io/scenes/scene_reader.h"
#include "io/volumes/dicom/dicom.h"
#include "scene/surfaces/closed_mesh.h"
#include "scene/surfaces/texture.h"

#include <stdatomic.h>
#include <string.h>
#include <sys/stat.h>

/* ---- content ---- */

static void release_content(ty_asset* asset) {
    ty_grid_release(asset->grid);
    ty_environment_map_release(asset->map);
    ty_closed_mesh_release(asset->shell);
    ty_texture_release(asset->texture);
}

static void destroy_asset(ty_context* context, ty_asset* asset) {
    release_content(asset);
    ty_free_text(context, (char*)asset->volume.grid);
    ty_free_text(context, (char*)asset->volume.series);
    ty_free_text(context, (char*)asset->volume.effective_radius);
    ty_free_text(context, (char*)asset->volume.air_density);
    ty_free_text(context, (char*)asset->camera_name);
    ty_free_array(context, asset, 1, sizeof *asset);
}

static bool same_name(const char* a, const char* b) {
    return a == NULL || b == NULL ? a == b : strcmp(a, b) == 0;
}

/* True if two defs request the same grid of one file. */
static bool same_volume(const ty_volume_def* a, const ty_volume_def* b) {
    return strcmp(a->grid, b->grid) == 0 && strcmp(a->series, b->series) == 0 && a->exact_grid == b->exact_grid &&
           a->meters_per_unit == b->meters_per_unit && same_name(a->effective_radius, b->effective_radius) &&
           a->droplet_radius == b->droplet_radius && same_name(a->air_density, b->air_density) &&
           a->air_density_value == b->air_density_value && a->component == b->component && a->storage == b->storage &&
           memcmp(a->raw_size, b->raw_size, sizeof a->raw_size) == 0 && strcmp(a->raw_type, b->raw_type) == 0 &&
           a->raw_big_endian == b->raw_big_endian && a->raw_offset == b->raw_offset &&
           memcmp(a->raw_spacing, b->raw_spacing, sizeof a->raw_spacing) == 0;
}

static bool same_sky(const ty_sky_def* a, const ty_sky_def* b) {
    return memcmp(a->sun_direction, b->sun_direction, sizeof a->sun_direction) == 0 &&
           memcmp(a->solar, b->solar, sizeof a->solar) == 0 && memcmp(a->ground, b->ground, sizeof a->ground) == 0 &&
           a->haze == b->haze && a->up_axis == b->up_axis && a->width == b->width && a->ozone == b->ozone &&
           a->scattering == b->scattering && a->height == b->height;
}

static bool same_source(const ty_asset* a, const ty_asset* b) {
    if (a->kind != b->kind || a->file != b->file) return false;
    switch (a->kind) {
    case TY_ASSET_COMPONENTS:
    case TY_ASSET_GRID: return same_volume(&a->volume, &b->volume);
    case TY_ASSET_NOISE: return memcmp(&a->noise, &b->noise, sizeof a->noise) == 0;
    case TY_ASSET_EXPONENTIAL: return memcmp(&a->exponential, &b->exponential, sizeof a->exponential) == 0;
    case TY_ASSET_SKY: return same_sky(&a->sky, &b->sky);
    case TY_ASSET_MAP: return true;
    case TY_ASSET_TEXTURE: return a->content == b->content;
    case TY_ASSET_SHELL:
    case TY_ASSET_CAMERA:
        return a->to_z_up == b->to_z_up && memcmp(&a->placement, &b->placement, sizeof a->placement) == 0 &&
               (a->camera_name == NULL || strcmp(a->camera_name, b->camera_name) == 0);
    }
    return false;
}

const ty_asset* ty_assets_find(ty_asset_cache* cache, const ty_asset* key) {
    for (size_t i = 0; i < cache->asset_count; ++i) {
        if (!same_source(cache->assets[i], key)) continue;
        cache->assets[i]->used = cache->reading;
        return cache->assets[i];
    }
    return NULL;
}

/* False, with a message, on allocation failure; NULL stays NULL. */
static bool copy_name(ty_context* context, const char* name, const char** out) {
    *out = name != NULL ? ty_copy_text(context, name) : NULL;
    return name == NULL || *out != NULL;
}

ty_result ty_assets_keep(ty_asset_cache* cache, const ty_asset* asset) {
    ty_context* context = cache->context;
    ty_asset* kept = ty_alloc_array(context, 1, sizeof *kept, true);
    if (kept == NULL) {
        ty_asset content = *asset;
        release_content(&content);
        return TY_ERROR_MEMORY;
    }
    *kept = *asset;
    kept->used = cache->reading;
    const bool volume = copy_name(context, asset->volume.grid, &kept->volume.grid);
    const bool series = copy_name(context, asset->volume.series, &kept->volume.series);
    const bool radius = copy_name(context, asset->volume.effective_radius, &kept->volume.effective_radius);
    const bool air = copy_name(context, asset->volume.air_density, &kept->volume.air_density);
    const bool camera = copy_name(context, asset->camera_name, &kept->camera_name);
    if (!volume || !series || !radius || !air || !camera ||
        !ty_grow_array(context, (void**)&cache->assets, &cache->asset_capacity, cache->asset_count,
                       sizeof(ty_asset*))) {
        destroy_asset(context, kept);
        return TY_ERROR_MEMORY;
    }
    cache->assets[cache->asset_count++] = kept;
    return TY_OK;
}

/* ---- limits ---- */

void ty_assets_drop_content(ty_asset_cache* cache, const ty_asset_file* file) {
    size_t kept = 0;
    for (size_t i = 0; i < cache->asset_count; ++i)
        if (cache->assets[i]->file == file)
            destroy_asset(cache->context, cache->assets[i]);
        else
            cache->assets[kept++] = cache->assets[i];
    cache->asset_count = kept;
}

static void drop_file(ty_asset_cache* cache, const ty_asset_file* file) {
    ty_assets_drop_content(cache, file);
    size_t at = 0;
    while (cache->files[at] != file) ++at;
    ty_free_text(cache->context, cache->files[at]->path);
    ty_free_array(cache->context, cache->files[at], 1, sizeof(ty_asset_file));
    cache->files[at] = cache->files[--cache->file_count];
}

/* True if no scene holds the content: this cache is its only owner. */
static bool is_spare(const ty_asset* asset) {
    if (asset->grid != NULL) return atomic_load(&asset->grid->owners) == 1;
    if (asset->shell != NULL) return atomic_load(&asset->shell->owners) == 1;
    if (asset->texture != NULL) return ty_texture_owners(asset->texture) == 1;
    return asset->map != NULL && atomic_load(&asset->map->owners) == 1;
}

static size_t bytes_of(const ty_asset* asset) {
    size_t bytes = sizeof *asset;
    if (asset->grid != NULL) bytes += ty_grid_get_info(asset->grid).bytes;
    if (asset->shell != NULL) bytes += ty_closed_mesh_bytes(asset->shell);
    if (asset->map != NULL) bytes += ty_environment_map_bytes(asset->map);
    if (asset->texture != NULL) bytes += ty_texture_bytes(asset->texture);
    return bytes;
}

/* True if content was made of the file, other than the number of its components. */
static bool has_content(const ty_asset_cache* cache, const ty_asset_file* file) {
    for (size_t i = 0; i < cache->asset_count; ++i)
        if (cache->assets[i]->file == file && cache->assets[i]->kind != TY_ASSET_COMPONENTS) return true;
    return false;
}

static void drop_asset(ty_asset_cache* cache, size_t index) {
    const ty_asset_file* file = cache->assets[index]->file;
    destroy_asset(cache->context, cache->assets[index]);
    cache->assets[index] = cache->assets[--cache->asset_count];
    if (file != NULL && file->memory == NULL && !has_content(cache, file)) drop_file(cache, file);
}

void ty_assets_trim(ty_asset_cache* cache) {
    for (;;) {
        size_t bytes = 0, count = 0, oldest = 0;
        for (size_t i = 0; i < cache->asset_count; ++i) {
            if (!is_spare(cache->assets[i])) continue;
            if (count == 0 || cache->assets[i]->used < cache->assets[oldest]->used) oldest = i;
            bytes += bytes_of(cache->assets[i]);
            ++count;
        }
        if (bytes <= TY_ASSETS_SPARE_BYTES && count <= TY_ASSETS_SPARE_COUNT) return;
        drop_asset(cache, oldest);
    }
}

/* ---- files ---- */

static bool is_later(const ty_asset_file* file, const struct stat* status) {
    return status->st_mtim.tv_sec != file->seconds ? status->st_mtim.tv_sec > file->seconds
                                                   : status->st_mtim.tv_nsec > file->nanoseconds;
}

/* Adds a file of the disk to a record: the sum of sizes, and the latest change. */
static bool add_stamp(const char* path, ty_asset_file* file) {
    struct stat status;
    if (stat(path, &status) != 0) return false;
    file->size += status.st_size;
    if (is_later(file, &status)) {
        file->seconds = status.st_mtim.tv_sec;
        file->nanoseconds = status.st_mtim.tv_nsec;
    }
    return true;
}

/* State of a file, or of all files of a DICOM series; false if there is none. */
static bool stamp(ty_context* context, const char* path, ty_asset_file* file) {
    *file = (ty_asset_file){.seconds = INT64_MIN};
    if (!add_stamp(path, file)) return false;
    if (!ty_is_folder(path) && !ty_is_dicom_file(path)) return true;
    ty_dicom_list list;
    bool known = ty_dicom_list_files(context, path, &list) == TY_OK;
    for (size_t i = 0; i < list.count && known; ++i) known = add_stamp(list.paths[i], file);
    ty_dicom_free_list(context, &list);
    return known;
}

static bool is_unchanged(ty_context* context, const ty_asset_file* file) {
    ty_asset_file now;
    return stamp(context, file->path, &now) && now.size == file->size && now.seconds == file->seconds &&
           now.nanoseconds == file->nanoseconds;
}

/* The file's state is taken before its content, so that a file that changes meanwhile counts as changed. */
static ty_result hash_file(ty_asset_cache* cache, ty_asset_file* file) {
    ty_asset_file now;
    uint64_t digest = TY_HASH_START;
    const bool known = stamp(cache->context, file->path, &now);
    const ty_result result = ty_hash_file_and_names(cache->context, file->path, &digest);
    if (result != TY_OK) return result;
    file->size = known ? now.size : -1;
    file->seconds = now.seconds;
    file->nanoseconds = now.nanoseconds;
    file->digest = digest;
    return TY_OK;
}

static ty_result add_file(ty_asset_cache* cache, const char* path, ty_asset_file** out) {
    ty_context* context = cache->context;
    if (!ty_grow_array(context, (void**)&cache->files, &cache->file_capacity, cache->file_count,
                       sizeof(ty_asset_file*)))
        return TY_ERROR_MEMORY;
    ty_asset_file* file = ty_alloc_array(context, 1, sizeof *file, true);
    if (file == NULL) return TY_ERROR_MEMORY;
    file->path = ty_copy_text(context, path);
    const ty_result result = file->path != NULL ? hash_file(cache, file) : TY_ERROR_MEMORY;
    if (result != TY_OK) {
        ty_free_text(context, file->path);
        ty_free_array(context, file, 1, sizeof *file);
        return result;
    }
    cache->files[cache->file_count++] = file;
    *out = file;
    return TY_OK;
}

/* Hashes a file again that was changed; what was made of it before goes. */
static ty_result refresh_file(ty_asset_cache* cache, ty_asset_file* file) {
    if (file->used == cache->reading || is_unchanged(cache->context, file)) return TY_OK;
    ty_assets_drop_content(cache, file);
    file->size = -1;
    return hash_file(cache, file);
}

ty_result ty_assets_file(ty_asset_cache* cache, const char* path, const ty_asset_file** out) {
    ty_asset_file* file = NULL;
    if (ty_is_memory_name(path)) return ty_memory_find(cache, path, out);
    for (size_t i = 0; i < cache->file_count && file == NULL; ++i)
        if (strcmp(cache->files[i]->path, path) == 0) file = cache->files[i];
    const ty_result result = file != NULL ? refresh_file(cache, file) : add_file(cache, path, &file);
    if (result != TY_OK) return result;
    file->used = cache->reading;
    *out = file;
    return TY_OK;
}

void ty_assets_release(ty_asset_cache* cache) {
    ty_sky_table_release(cache->context, &cache->sky_table);
    ty_memory_release(cache);
    for (size_t i = 0; i < cache->asset_count; ++i) destroy_asset(cache->context, cache->assets[i]);
    for (size_t i = 0; i < cache->file_count; ++i) {
        ty_free_text(cache->context, cache->files[i]->path);
        ty_free_array(cache->context, cache->files[i], 1, sizeof(ty_asset_file));
    }
    ty_free_array(cache->context, cache->assets, cache->asset_capacity, sizeof(ty_asset*));
    ty_free_array(cache->context, cache->files, cache->file_capacity, sizeof(ty_asset_file*));
}
