/* tyndall bake: copies of glTF files with vertex colors from the baked irradiance. */
#include "cli/bake/bake.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

/* ---- File names ---- */

/* The glTF file of a unit that was baked by vertex, or NULL. */
static const char* file_of(const bake_run* run, const bake_unit* unit) {
    ty_mesh_def mesh;
    if (unit->kind != BAKE_VERTICES || ty_scene_get_mesh(run->scene, unit->first, &mesh) != TY_OK) return NULL;
    return mesh.origin.node >= 0 ? mesh.origin.file : NULL;
}

static bool is_listed(const bake_copy* copies, int32_t count, const char* file) {
    for (int32_t i = 0; i < count; ++i)
        if (strcmp(copies[i].file, file) == 0) return true;
    return false;
}

/* The base name of the file with .glb, numbered where several files have the same name. */
static void name_copy(const bake_copy* copies, int32_t count, const char* file, char name[BAKE_NAME_SIZE]) {
    const char* slash = strrchr(file, '/');
    const char* start = slash == NULL ? file : slash + 1;
    const char* dot = strrchr(start, '.');
    const int length = (int)fmin(dot == NULL ? (double)strlen(start) : (double)(dot - start), BAKE_NAME_SIZE - 16);
    snprintf(name, BAKE_NAME_SIZE, "%.*s.glb", length, start);
    for (int32_t i = 0, number = 2; i < count; ++i)
        if (strcmp(copies[i].name, name) == 0) {
            snprintf(name, BAKE_NAME_SIZE, "%.*s_%d.glb", length, start, number++);
            i = -1;
        }
}

bake_copy* bake_list_copies(const bake_run* run, int32_t* count) {
    *count = 0;
    bake_copy* copies = calloc((size_t)run->plan.count + 1, sizeof *copies);
    for (int32_t i = 0; copies != NULL && i < run->plan.count; ++i) {
        const char* file = file_of(run, &run->plan.units[i]);
        if (file == NULL || is_listed(copies, *count, file)) continue;
        bake_copy* copy = &copies[*count];
        copy->file = file;
        name_copy(copies, *count, file, copy->name);
        ++*count;
    }
    return copies;
}

/* ---- Vertex colors ---- */

/* Irradiance at the vertices of a unit, read from its image, 3 floats per vertex; the caller frees it. */
static ty_result read_light(const bake_run* run, const bake_unit* unit, float** out) {
    char path[BAKE_PATH_SIZE];
    ty_image* image = NULL;
    const float* planes[3];
    bake_image_path(run, unit, -1, ".exr", path);
    const ty_result result = ty_image_read(run->session->context, path, &image);
    if (result != TY_OK) return result;
    const bool fits = ty_image_width(image) == unit->size[0] && ty_image_height(image) == unit->size[1] &&
                      ty_image_rgb_planes(image, planes);
    float* light = fits ? malloc((size_t)unit->receivers * 3 * sizeof *light) : NULL;
    for (int64_t i = 0; light != NULL && i < unit->receivers; ++i)
        for (int c = 0; c < 3; ++c) light[3 * i + c] = planes[c][i];
    ty_image_destroy(image);
    *out = light;
    return !fits ? TY_ERROR_INTERNAL : light == NULL ? TY_ERROR_MEMORY : TY_OK;
}

/* The sources of one file's copy. */
typedef struct colors {
    float** light; /* per unit; NULL: the unit belongs to another file */
    ty_mesh_colors* meshes;
    int64_t count;
    float largest;
} colors;

static ty_result add_unit(const bake_run* run, int32_t index, colors* all) {
    const bake_unit* unit = &run->plan.units[index];
    ty_result result = read_light(run, unit, &all->light[index]);
    const float* at = all->light[index];
    for (int64_t i = 0; i < 3 * unit->receivers && result == TY_OK; ++i) all->largest = fmaxf(all->largest, at[i]);
    for (int32_t mesh = unit->first; mesh < unit->first + unit->count && result == TY_OK; ++mesh) {
        ty_mesh_def def;
        result = ty_scene_get_mesh(run->scene, mesh, &def);
        all->meshes[all->count++] = (ty_mesh_colors){.origin = def.origin, .count = def.vertex_count, .rgb = at};
        at += 3 * def.vertex_count;
    }
    return result;
}

/* Normalization: the brightest component becomes 1, the maximum of a glTF vertex color. */
static void scale_light(const bake_run* run, colors* all, double scale) {
    for (int32_t u = 0; u < run->plan.count; ++u)
        for (int64_t i = 0; all->light[u] != NULL && i < 3 * run->plan.units[u].receivers; ++i)
            all->light[u][i] = fminf(fmaxf((float)(scale * (double)all->light[u][i]), 0), 1);
}

static ty_result write_copy(const bake_run* run, bake_copy* copy, colors* all) {
    char path[BAKE_PATH_SIZE], extras[256];
    ty_result result = TY_OK;
    for (int32_t u = 0; u < run->plan.count && result == TY_OK; ++u) {
        const char* file = file_of(run, &run->plan.units[u]);
        if (file != NULL && strcmp(file, copy->file) == 0) result = add_unit(run, u, all);
    }
    if (result != TY_OK) return result;
    copy->scale = all->largest > 0 ? 1 / (double)all->largest : 1;
    scale_light(run, all, copy->scale);
    snprintf(path, sizeof path, "%s/%s", run->options->folder, copy->name);
    snprintf(extras, sizeof extras,
             "{\"quantity\": \"irradiance\", \"unit\": \"W m^-2\", \"color_scale\": %.9g, \"sidecar\": \"bake.json\"}",
             copy->scale);
    return ty_mesh_file_write_colors(run->session->context, copy->file, all->meshes, all->count, extras, path);
}

static ty_result make_copy(const bake_run* run, bake_copy* copy) {
    colors all = {.light = calloc((size_t)run->plan.count, sizeof(float*)),
                  .meshes = calloc((size_t)ty_scene_get_info(run->scene).meshes, sizeof *all.meshes)};
    const ty_result result = all.light == NULL || all.meshes == NULL ? TY_ERROR_MEMORY : write_copy(run, copy, &all);
    for (int32_t u = 0; all.light != NULL && u < run->plan.count; ++u) free(all.light[u]);
    free(all.light);
    free(all.meshes);
    return result;
}

int bake_write_colors(bake_run* run) {
    ty_result result = TY_OK;
    for (int32_t i = 0; i < run->copy_count && result == TY_OK; ++i) result = make_copy(run, &run->copies[i]);
    return result == TY_OK ? CLI_GO : cli_fail_running(run->session, result);
}

int bake_check_copies(const bake_run* run) {
    for (int32_t i = 0; i < run->copy_count; ++i) {
        char path[BAKE_PATH_SIZE];
        struct stat source, target;
        snprintf(path, sizeof path, "%s/%s", run->options->folder, run->copies[i].name);
        if (stat(run->copies[i].file, &source) == 0 && stat(path, &target) == 0 && source.st_dev == target.st_dev &&
            source.st_ino == target.st_ino)
            return cli_fail(CLI_USAGE, "%s would be overwritten with its own copy; name another folder with -o", path);
    }
    return CLI_GO;
}
