/* tyndall export: probes and light grids as lists of positions and coefficients. No array is in another, because
 * Unity's JsonUtility reads none. */
#include "base/context.h"
#include "cli/export/export.h"
#include "cli/text/text_file.h"
#include "io/textures/textures.h"

#include <stdlib.h>
#include <string.h>

/* Probes of which more rays met backs of surfaces are inside of walls. */
#define BLOCKED 0.5

typedef struct probe {
    double position[3];
    double blocked;
    double sh[3][EXPORT_TERMS]; /* [channel][term] */
} probe;

typedef struct probe_list {
    const export_run* run;
    probe* probes;
    int64_t count;
    int32_t grid[3];              /* 0: no grid */
    double origin[3], spacing[3]; /* of the grid, in the axes of the scene, m */
} probe_list;

static ty_result wrong(const export_run* run, const char* name) {
    return ty_fail(run->session->context, TY_ERROR_INPUT, "%s/%s: not what tyndall bake writes", run->from, name);
}

static bool take_numbers(const json_t* array, int count, double* out) {
    for (int i = 0; i < count; ++i) {
        const json_t* value = json_array_get(array, (size_t)i);
        if (!json_is_number(value)) return false;
        out[i] = json_number_value(value);
    }
    return true;
}

/* ---- Reading ---- */

static bool take_probe(const json_t* item, probe* out) {
    const json_t* sh = json_object_get(item, "sh");
    double rgb[3];
    out->blocked = json_number_value(json_object_get(item, "blocked"));
    if (!take_numbers(json_object_get(item, "position"), 3, out->position)) return false;
    for (int t = 0; t < EXPORT_TERMS; ++t) {
        if (!take_numbers(json_array_get(sh, (size_t)t), 3, rgb)) return false;
        for (int c = 0; c < 3; ++c) out->sh[c][t] = rgb[c];
    }
    return true;
}

static ty_result read_list(export_run* run, const char* name, probe_list* list) {
    char path[EXPORT_PATH_SIZE];
    snprintf(path, sizeof path, "%s/%s", run->from, name);
    json_t* root = json_load_file(path, 0, NULL);
    const json_t* items = json_object_get(root, "probes");
    const size_t count = json_array_size(items);
    list->probes = calloc(count + 1, sizeof *list->probes);
    bool good = count > 0 && list->probes != NULL;
    for (size_t i = 0; good && i < count; ++i) good = take_probe(json_array_get(items, i), &list->probes[i]);
    list->count = (int64_t)count;
    if (json_array_size(json_object_get(json_array_get(items, 0), "sh")) > EXPORT_TERMS) run->has_more_bands = true;
    json_decref(root);
    return good ? TY_OK : wrong(run, name);
}

/* The plane of a channel such as sh3.G. */
static const float* plane_of(const ty_image* image, int term, int channel) {
    char name[24];
    snprintf(name, sizeof name, "sh%d.%c", term, "RGB"[channel]);
    const int32_t index = ty_image_find_channel(image, name);
    return index < 0 ? NULL : ty_image_plane_const(image, index);
}

static bool take_grid(const json_t* entry, const ty_image* image, probe_list* list) {
    double count[3], origin[3], spacing[3];
    if (!take_numbers(json_object_get(entry, "count"), 3, count) ||
        !take_numbers(json_object_get(entry, "origin"), 3, origin) ||
        !take_numbers(json_object_get(entry, "spacing"), 3, spacing))
        return false;
    const int64_t pixels = (int64_t)ty_image_width(image) * ty_image_height(image);
    if (count[0] != ty_image_width(image) || count[1] * count[2] != ty_image_height(image)) return false;
    list->probes = calloc((size_t)pixels, sizeof *list->probes);
    if (list->probes == NULL) return false;
    list->count = pixels;
    for (int a = 0; a < 3; ++a) {
        list->grid[a] = (int32_t)count[a];
        list->origin[a] = origin[a];
        list->spacing[a] = spacing[a];
    }
    const int32_t blocked = ty_image_find_channel(image, "blocked.Z");
    const float* planes[3][EXPORT_TERMS];
    for (int c = 0; c < 3; ++c)
        for (int t = 0; t < EXPORT_TERMS; ++t) {
            planes[c][t] = plane_of(image, t, c);
            if (planes[c][t] == NULL) return false;
        }
    for (int64_t i = 0; i < pixels; ++i) {
        probe* p = &list->probes[i];
        const int64_t at[3] = {i % list->grid[0], i / list->grid[0] % list->grid[1], i / list->grid[0] / list->grid[1]};
        for (int a = 0; a < 3; ++a) p->position[a] = origin[a] + spacing[a] * (double)at[a];
        p->blocked = blocked < 0 ? 0 : (double)ty_image_plane_const(image, blocked)[i];
        for (int c = 0; c < 3; ++c)
            for (int t = 0; t < EXPORT_TERMS; ++t) p->sh[c][t] = (double)planes[c][t][i];
    }
    return true;
}

static ty_result read_grid(export_run* run, const json_t* entry, const char* name, probe_list* list) {
    char path[EXPORT_PATH_SIZE];
    ty_image* image = NULL;
    snprintf(path, sizeof path, "%s/%s", run->from, name);
    const ty_result result = ty_image_read(run->session->context, path, &image);
    if (result != TY_OK) return result;
    const bool good = take_grid(entry, image, list);
    if (plane_of(image, EXPORT_TERMS, 0) != NULL) run->has_more_bands = true;
    ty_image_destroy(image);
    return good ? TY_OK : wrong(run, name);
}

/* ---- Writing ---- */

static void put_probe(json_writer* json, const probe_list* list, const float axes[3][3], const probe* p) {
    double position[3] = {0}, rotated[3][EXPORT_TERMS], flat[3 * EXPORT_TERMS];
    for (int a = 0; a < 3; ++a)
        for (int i = 0; i < 3; ++i)
            position[a] += (double)axes[a][i] * p->position[i] * list->run->engine->units_per_meter;
    for (int c = 0; c < 3; ++c) export_harmonics(list->run->engine, axes, p->sh[c], rotated[c]);
    json_open_object(json, NULL);
    json_numbers(json, "position", position, 3);
    json_number(json, "blocked", p->blocked);
    for (int i = 0; i < 3 * EXPORT_TERMS; ++i) flat[i] = rotated[i % 3][i / 3];
    json_numbers(json, "coefficients", flat, 3 * EXPORT_TERMS);
    json_close_object(json);
}

static ty_result print_probes(ty_context* context, FILE* file, const void* user) {
    (void)context;
    const probe_list* list = user;
    float axes[3][3];
    export_axes(list->run->engine, list->run->z_up, axes);
    json_writer json = json_begin(file);
    json_open_object(&json, NULL);
    json_int(&json, "tyndall_engine_probes", 1);
    json_text(&json, "engine", list->run->engine->name);
    json_text(&json, "axes", list->run->engine->axes_text);
    json_text(&json, "coefficients", list->run->engine->probes_text);
    json_text(&json, "order",
              "1, y, z, x, xy, yz, 3zz - 1, xz, xx - yy, in the engine's axes; red, green and blue of each");
    if (list->grid[0] > 0) {
        json_numbers(&json, "grid", (const double[]){list->grid[0], list->grid[1], list->grid[2]}, 3);
        double lower[3], upper[3];
        for (int a = 0; a < 3; ++a) {
            lower[a] = list->origin[a] - list->spacing[a] / 2;
            upper[a] = lower[a] + list->spacing[a] * list->grid[a];
        }
        json_text(&json, "grid_order", "x fastest, then y, then z, in the axes of the scene");
        json_text(&json, "up", list->run->z_up ? "+z" : "+y");
        json_numbers(&json, "lower", lower, 3);
        json_numbers(&json, "upper", upper, 3);
        json_text(
            &json, "volumes",
            "grid_0 to grid_3: the first four terms times a weight, which is alpha; texels lie in the box from lower "
            "to upper, m, in the axes of the scene");
    }
    json_open_array(&json, "probes");
    for (int64_t i = 0; i < list->count; ++i) put_probe(&json, list, (const float(*)[3])axes, &list->probes[i]);
    json_close_array(&json);
    json_close_object(&json);
    return TY_OK;
}

/* ---- Volumes ---- */

/* A light grid's band 0 and 1 as four volumes, which hardware interpolates: red, green and blue of a term times the
 * probe's weight, and the weight as alpha, 0 inside of walls. */
static ty_result write_volume(const probe_list* list, const float axes[3][3], int term) {
    static const char* const names[] = {"R", "G", "B", "A"};
    const export_run* run = list->run;
    ty_context* context = run->session->context;
    ty_image* image = NULL;
    char path[EXPORT_PATH_SIZE];
    ty_result result = ty_image_create(context, list->grid[0], list->grid[1] * list->grid[2], 4, names, &image);
    for (int64_t i = 0; i < list->count && result == TY_OK; ++i) {
        const probe* p = &list->probes[i];
        const double weight = p->blocked > BLOCKED ? 0 : 1;
        for (int c = 0; c < 3; ++c) {
            double out[EXPORT_TERMS];
            export_harmonics(run->engine, axes, p->sh[c], out);
            ty_image_plane(image, c)[i] = (float)(weight * out[term]);
        }
        ty_image_plane(image, 3)[i] = (float)weight;
    }
    ty_texels_def def = ty_default_texels_def();
    const bool ktx2 = strcmp(run->engine->extension, "ktx2") == 0;
    def.format = TY_TEXELS_HALF;
    def.slices = list->grid[2];
    def.zstd = ktx2 ? run->zstd : 0;
    snprintf(path, sizeof path, "%s/grid_%d.%s", run->folder, term, ktx2 ? "ktx2" : "dds");
    if (result == TY_OK) result = ty_texels_write(context, image, &def, path);
    ty_image_destroy(image);
    return result;
}

static ty_result write_volumes(const probe_list* list) {
    float axes[3][3];
    ty_result result = TY_OK;
    export_axes(list->run->engine, list->run->z_up, axes);
    for (int32_t a = 0; a < 3; ++a)
        if (list->grid[a] > TY_TEXTURE_SIDE_MAX_3D) return TY_OK; /* no texture is as large */
    for (int term = 0; term < 4 && result == TY_OK; ++term) result = write_volume(list, (const float(*)[3])axes, term);
    return result;
}

ty_result export_probes(export_run* run, const json_t* entry, const char* name) {
    char path[EXPORT_PATH_SIZE];
    probe_list list = {.run = run};
    const bool grid = cli_has_extension(name, ".exr");
    ty_result result = grid ? read_grid(run, entry, name, &list) : read_list(run, name, &list);
    snprintf(path, sizeof path, "%s/%s.json", run->folder, grid ? "grid" : "probes");
    if (result == TY_OK) result = cli_write_text_file(run->session->context, path, print_probes, &list);
    if (result == TY_OK && grid) result = write_volumes(&list);
    if (result == TY_OK) run->probe_count += list.count;
    free(list.probes);
    return result;
}
