/* OpenVDB files: listing, reading and writing grids. */
#include "io/volumes/vdb.h"

#include "base/context.h"
#include "io/file.h"
#include "io/volumes/volume_file.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* "Tree_vec3s_5_4_3" -> "vec3s"; a float grid stored as half is "half". */
static void format_type(const ty_vdb_grid* grid, char* text, size_t size) {
    const char* start = strncmp(grid->type, "Tree_", 5) == 0 ? grid->type + 5 : grid->type;
    if (grid->half && strcmp(start, "float_5_4_3") == 0) start = "half";
    snprintf(text, size, "%.*s", (int)strcspn(start, "_"), start);
}

static const ty_vdb_grid* find_grid(const ty_vdb_file* file, const char* name) {
    for (size_t i = 0; i < file->count; ++i)
        if (strcmp(file->grids[i].name, name) == 0) return &file->grids[i];
    return NULL;
}

/* The grid that stores the tree: the grid itself, or the one that it is an instance of. */
static const ty_vdb_grid* tree_owner(const ty_vdb_file* file, const ty_vdb_grid* grid) {
    if (grid->parent[0] == '\0') return grid;
    const ty_vdb_grid* parent = find_grid(file, grid->parent);
    return parent != NULL && parent->parent[0] == '\0' ? parent : NULL;
}

/* Missing statistics are computed from the tree; -1 voxels if it cannot be read. */
static ty_result complete_statistics(const ty_vdb_file* file, ty_vdb_grid* grid) {
    if (grid->has_statistics) return TY_OK;
    const ty_vdb_grid* owner = tree_owner(file, grid);
    if (owner == NULL || owner->tree == 0 || ty_vdb_value_of(owner).bytes == 0) {
        grid->active_voxels = -1;
        for (int a = 0; a < 3; ++a) {
            grid->lower[a] = 1;
            grid->upper[a] = 0;
        }
        return TY_OK;
    }
    return ty_vdb_measure(file, owner, grid);
}

ty_result ty_vdb_list(ty_context* context, const char* path, ty_vdb_entry* entries, int32_t capacity, int32_t* count) {
    if (count == NULL || capacity < 0 || (entries == NULL && capacity > 0))
        return ty_fail(context, TY_ERROR_ARGUMENT, "ty_vdb_list: entries or count is NULL, or capacity negative");
    if (ty_is_nanovdb(path)) return ty_nanovdb_list(context, path, entries, capacity, count);
    ty_vdb_file file;
    ty_result result = ty_vdb_open(context, path, &file);
    if (result != TY_OK) return result;
    for (size_t i = 0; i < file.count && i < (size_t)capacity && result == TY_OK; ++i) {
        ty_vdb_grid* grid = &file.grids[i];
        result = complete_statistics(&file, grid);
        ty_vdb_entry entry = {.active_voxels = grid->active_voxels};
        memcpy(entry.name, grid->name, sizeof entry.name);
        format_type(grid, entry.type, sizeof entry.type);
        memcpy(entry.lower, grid->lower, sizeof entry.lower);
        memcpy(entry.upper, grid->upper, sizeof entry.upper);
        if (grid->active_voxels == 0)
            for (int a = 0; a < 3; ++a) entry.upper[a] = entry.lower[a] - 1;
        for (int a = 0; a < 3; ++a) {
            const double* m = grid->index_to_world.m;
            entry.voxel_size[a] = sqrt(m[a] * m[a] + m[4 + a] * m[4 + a] + m[8 + a] * m[8 + a]);
        }
        entries[i] = entry;
    }
    if (result == TY_OK) *count = (int32_t)file.count;
    ty_vdb_close(&file);
    return result;
}

static ty_result missing_grid(const ty_vdb_file* file, const char* name) {
    char names[512] = "";
    size_t length = 0;
    for (size_t i = 0; i < file->count && length < sizeof names; ++i)
        length +=
            (size_t)snprintf(names + length, sizeof names - length, "%s%s", i > 0 ? ", " : "", file->grids[i].name);
    return ty_fail(file->context, TY_ERROR_INPUT, "%s: no grid \"%s\"; there %s %s", file->path, name,
                   file->count == 1 ? "is" : "are", file->count == 0 ? "none" : names);
}

static ty_result find_readable(const ty_vdb_file* file, const char* name, const ty_vdb_grid** grid) {
    *grid = find_grid(file, name);
    if (*grid == NULL) return missing_grid(file, name);
    char type[32];
    format_type(*grid, type, sizeof type);
    if (ty_vdb_value_of(*grid).bytes == 0)
        return ty_fail(file->context, TY_ERROR_INPUT, "%s: grid \"%s\" is of type %s, not float, half, double or vec3s",
                       file->path, name, type);
    return TY_OK;
}

/* Finds a grid that can be read as density, and the owner of its tree. */
static ty_result choose_grid(const ty_vdb_file* file, const char* name, int32_t component, const ty_vdb_grid** grid,
                             const ty_vdb_grid** owner) {
    ty_result result = find_readable(file, name, grid);
    if (result == TY_OK)
        result = ty_check_component(file->context, file->path, name, component, ty_vdb_value_of(*grid).components);
    if (result != TY_OK) return result;
    ty_affine inverse;
    if (!(*grid)->affine)
        return ty_fail(file->context, TY_ERROR_INPUT,
                       "%s: grid \"%s\" has a frustum transform; only affine transforms can be read", file->path, name);
    if (!ty_affine_invert(&(*grid)->index_to_world, &inverse))
        return ty_fail(file->context, TY_ERROR_INPUT, "%s: the transform of grid \"%s\" cannot be inverted", file->path,
                       name);
    *owner = tree_owner(file, *grid);
    if (*owner == NULL || (*owner)->tree == 0 || strcmp((*owner)->type, (*grid)->type) != 0)
        return ty_fail(file->context, TY_ERROR_INPUT, "%s: grid \"%s\" shares the tree of \"%s\", which cannot be read",
                       file->path, name, (*grid)->parent);
    return TY_OK;
}

ty_result ty_vdb_read_component(ty_context* context, const char* path, const char* name, int32_t component,
                                const ty_grid_plan* plan, ty_grid** out) {
    ty_vdb_file file;
    ty_result result = ty_vdb_open(context, path, &file);
    if (result != TY_OK) return result;
    const ty_vdb_grid *grid = NULL, *owner = NULL;
    result = choose_grid(&file, name, component, &grid, &owner);
    if (result == TY_OK)
        result = ty_vdb_read_tree(&file, owner, component < 0 ? 0 : component, &grid->index_to_world, plan, out);
    ty_vdb_close(&file);
    return result;
}

ty_result ty_vdb_components(ty_context* context, const char* path, const char* name, int32_t* out) {
    ty_vdb_file file;
    ty_result result = ty_vdb_open(context, path, &file);
    if (result != TY_OK) return result;
    const ty_vdb_grid* grid = NULL;
    result = find_readable(&file, name, &grid);
    if (result == TY_OK) *out = ty_vdb_value_of(grid).components;
    ty_vdb_close(&file);
    return result;
}

ty_result ty_vdb_read(ty_context* context, const char* path, const char* grid_name, ty_grid** out) {
    if (grid_name == NULL || out == NULL)
        return ty_fail(context, TY_ERROR_ARGUMENT, "ty_vdb_read: grid_name or out is NULL");
    const ty_grid_plan whole = {.storage = TY_GRID_AUTO};
    return ty_vdb_read_component(context, path, grid_name, -1, &whole, out);
}

bool ty_vdb_find_codec(ty_context* context, const char* name, uint32_t* codec) {
    static const struct {
        const char* name;
        uint32_t codec;
    } codecs[] = {{"none", 0}, {"zip", TY_VDB_ZIP}, {"blosc", TY_VDB_BLOSC}};
    for (size_t i = 0; i < sizeof codecs / sizeof codecs[0] && name != NULL; ++i) {
        *codec = codecs[i].codec;
        if (strcmp(name, codecs[i].name) == 0) return true;
    }
    ty_fail(context, TY_ERROR_ARGUMENT, "the VDB codec is \"%s\", not none, zip or blosc", name == NULL ? "" : name);
    return false;
}

ty_result ty_vdb_write(ty_context* context, const ty_grid* grid, const char* grid_name, const char* codec,
                       const char* path) {
    if (grid == NULL || grid_name == NULL || grid_name[0] == '\0' || strlen(grid_name) >= TY_VDB_NAME_SIZE)
        return ty_fail(context, TY_ERROR_ARGUMENT, "ty_vdb_write: the grid is NULL or its name not 1..%d characters",
                       (int)TY_VDB_NAME_SIZE - 1);
    const ty_volume_field field = {.name = grid_name, .components = 1, .grids = {grid}};
    uint32_t compression = 0;
    if (!ty_vdb_find_codec(context, codec, &compression)) return TY_ERROR_ARGUMENT;
    ty_output output;
    ty_result result = ty_output_open(context, path, &output);
    if (result != TY_OK) return result;
    result = ty_vdb_write_file(context, &field, 1, compression, &output);
    if (result == TY_OK) return ty_output_commit(context, &output);
    ty_output_discard(context, &output);
    return result;
}
