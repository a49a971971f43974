/* tyndall bake: bake.json and probes.json, which list the baked objects, their files and their units. */
#include "cli/bake/bake.h"
#include "cli/text/text_file.h"

#include <inttypes.h>
#include <string.h>

const char* const bake_method_names[TY_BAKE_PATH + 1] = {"cache", "impulse", "attenuation", "surfaces", "path"};
static const char* const layer_names[TY_BAKE_LAYERS] = {"direct", "indirect", "single", "multiple"};

/* ---- Conventions ---- */

static void put_conventions(json_writer* json, const bake_run* run) {
    json_text(json, "up", ty_scene_up_axis(run->scene) == TY_AXIS_Z ? "+z" : "+y");
    json_text(json, "handedness", "right");
    json_text(json, "length_unit", "m");
    json_text(json, "color_space", "linear Rec.709");
}

static void put_harmonics(json_writer* json, const bake_run* run) {
    json_open_object(json, "spherical_harmonics");
    json_text(json, "quantity", "incident radiance, by the direction that it comes from");
    json_text(json, "unit", "W m^-2 sr^-1");
    json_text(json, "basis", "real, orthonormal");
    json_text(json, "condon_shortley", "none");
    json_text(json, "index", "l (l + 1) + m");
    json_text(json, "first_order", "1: y, 2: z, 3: x, each sqrt(3 / (4 pi)) times the coordinate");
    json_int(json, "order", run->options->sh);
    json_int(json, "terms", run->options->sh * run->options->sh);
    json_close_object(json);
}

/* ---- probes.json ---- */

typedef struct probe_set {
    const bake_run* run;
    const ty_bake_probe* probes;
} probe_set;

static void put_terms(json_writer* json, const char* name, const float sh[3][TY_BAKE_SH_TERMS], int32_t terms) {
    json_open_array(json, name);
    for (int32_t t = 0; t < terms; ++t)
        json_numbers(json, NULL, (const double[]){(double)sh[0][t], (double)sh[1][t], (double)sh[2][t]}, 3);
    json_close_array(json);
}

static void put_probe(json_writer* json, const bake_run* run, const float position[3], const ty_bake_probe* probe) {
    const int32_t terms = run->options->sh * run->options->sh;
    float sum[3][TY_BAKE_SH_TERMS];
    ty_bake_probe_sum(probe, sum);
    json_open_object(json, NULL);
    json_numbers(json, "position", (const double[]){(double)position[0], (double)position[1], (double)position[2]}, 3);
    json_number(json, "blocked", (double)probe->blocked);
    json_int(json, "samples", probe->samples);
    json_numbers(json, "variance",
                 (const double[]){(double)probe->variance[0], (double)probe->variance[1], (double)probe->variance[2]},
                 3);
    put_terms(json, "sh", (const float(*)[TY_BAKE_SH_TERMS])sum, terms);
    json_open_object(json, "layers");
    for (int layer = 0; layer < TY_BAKE_LAYERS; ++layer)
        put_terms(json, layer_names[layer], (const float(*)[TY_BAKE_SH_TERMS])probe->sh[layer], terms);
    json_close_object(json);
    json_close_object(json);
}

static ty_result print_probes(ty_context* context, FILE* file, const void* user) {
    (void)context;
    const probe_set* set = user;
    json_writer json = json_begin(file);
    json_open_object(&json, NULL);
    json_int(&json, "tyndall_probes", 1);
    put_conventions(&json, set->run);
    put_harmonics(&json, set->run);
    json_open_array(&json, "probes");
    for (int64_t i = 0; i < set->run->plan.probe_count; ++i)
        put_probe(&json, set->run, set->run->plan.probes + 3 * i, &set->probes[i]);
    json_close_array(&json);
    json_close_object(&json);
    return TY_OK;
}

ty_result bake_write_probes(bake_run* run, const ty_bake_probe* probes) {
    char path[BAKE_PATH_SIZE];
    const probe_set set = {run, probes};
    snprintf(path, sizeof path, "%s/probes.json", run->options->folder);
    return cli_write_text_file(run->session->context, path, print_probes, &set);
}

/* ---- bake.json ---- */

static void put_cache(json_writer* json, const bake_run* run) {
    const ty_bake_cache_info info = run->cache_info;
    json_open_object(json, "cache");
    json_numbers(json, "cells", (const double[]){info.size[0], info.size[1], info.size[2]}, 3);
    json_number(json, "cell", info.cell);
    json_int(json, "filled", info.filled);
    json_int(json, "paths", info.paths);
    json_int(json, "rays", info.rays);
    json_number(json, "bytes", info.bytes);
    json_number(json, "seconds", info.seconds);
    json_close_object(json);
}

static void put_options(json_writer* json, const bake_run* run) {
    const bake_options* options = run->options;
    json_text(json, "method", bake_method_names[options->method]);
    json_int(json, "spp", run->def.spp);
    json_number(json, "error", run->def.error);
    json_int(json, "bounces", run->def.bounces);
    json_int(json, "scatterings", run->def.scatterings);
    if (run->cached) put_cache(json, run);
    json_bool(json, "back_scattering", run->def.back_scattering);
    if (run->def.method == TY_BAKE_IMPULSE)
        json_text(json, "composition", run->def.composition == TY_BAKE_PUBLISHED ? "published" : "collisions");
    json_unsigned(json, "seed", run->def.seed);
}

/* The meshes of a unit; for vertex bakes also the first index of each. */
static void put_meshes(json_writer* json, const bake_run* run, const bake_unit* unit, int32_t first, int32_t count) {
    int64_t at = 0;
    json_open_array(json, "meshes");
    for (int32_t i = first; i < first + count; ++i) {
        ty_mesh_def mesh;
        if (ty_scene_get_mesh(run->scene, i, &mesh) != TY_OK) break;
        json_open_object(json, NULL);
        json_text(json, "name", bake_mesh_name(&mesh));
        json_int(json, "index", i);
        if (mesh.origin.file != NULL) json_text(json, "source", mesh.origin.file);
        if (mesh.origin.node >= 0) json_int(json, "node", mesh.origin.node);
        if (mesh.origin.node >= 0) json_int(json, "primitive", mesh.origin.primitive);
        if (unit->kind == BAKE_VERTICES) {
            json_int(json, "first_pixel", at);
            json_int(json, "first_vertex", mesh.origin.first_vertex);
            json_int(json, "vertices", mesh.vertex_count);
        }
        at += mesh.vertex_count;
        json_close_object(json);
    }
    json_close_array(json);
}

static void put_grid(json_writer* json, const bake_run* run) {
    const bake_grid* grid = &run->plan.grid;
    json_numbers(json, "count", (const double[]){grid->size[0], grid->size[1], grid->size[2]}, 3);
    json_numbers(json, "origin", grid->origin, 3);
    json_numbers(json, "spacing", grid->spacing, 3);
    json_text(json, "layout", "pixel (x, y + z * count[1]) is the probe at origin + spacing * (x, y, z)");
    json_text(json, "validity", "blocked.Z: the fraction of rays that met the back of a surface; near 1 within walls");
}

static void put_file(json_writer* json, const bake_run* run, const bake_unit* unit, int32_t primitive_index) {
    static const char* const kinds[] = {"lightmap", "vertices", "grid", "probes"};
    char number[16] = "", name[BAKE_NAME_SIZE + 32];
    if (primitive_index >= 0) snprintf(number, sizeof number, "-%d", (int)primitive_index);
    snprintf(name, sizeof name, "%s%s.%s", unit->name, number, unit->kind == BAKE_PROBES ? "json" : "exr");
    json_open_object(json, NULL);
    json_text(json, "file", name);
    if (run->options->denoise && unit->kind == BAKE_LIGHTMAP) {
        snprintf(name, sizeof name, "%s%s%s.exr", unit->name, number, BAKE_DENOISED);
        json_text(json, "denoised", name);
    }
    json_text(json, "kind", kinds[unit->kind]);
    if (unit->kind != BAKE_PROBES) json_int(json, "width", unit->size[0]);
    if (unit->kind != BAKE_PROBES) json_int(json, "height", unit->size[1]);
    if (unit->kind == BAKE_LIGHTMAP || unit->kind == BAKE_VERTICES) {
        json_text(json, "quantity", "irradiance");
        json_text(json, "unit", "W m^-2");
        json_number(json, "scale", 1);
        put_meshes(json, run, unit, primitive_index < 0 ? unit->first : unit->first + primitive_index,
                   primitive_index < 0 ? unit->count : 1);
    }
    if (unit->kind == BAKE_GRID) put_grid(json, run);
    json_number(json, "mean_samples", unit->mean_samples);
    json_number(json, "seconds", unit->seconds);
    json_close_object(json);
}

static void put_files(json_writer* json, const bake_run* run) {
    json_open_array(json, "files");
    for (int32_t i = 0; i < run->plan.count; ++i) {
        const bake_unit* unit = &run->plan.units[i];
        for (int32_t primitive_index = 0; unit->done && primitive_index < (unit->overlapping ? unit->count : 1);
             ++primitive_index)
            put_file(json, run, unit, unit->overlapping ? primitive_index : -1);
    }
    for (int32_t i = 0; run->complete && i < run->copy_count; ++i) {
        json_open_object(json, NULL);
        json_text(json, "file", run->copies[i].name);
        json_text(json, "kind", "gltf");
        json_text(json, "source", run->copies[i].file);
        json_text(json, "quantity", "irradiance");
        json_text(json, "unit", "W m^-2");
        json_number(json, "color_scale", run->copies[i].scale);
        json_text(json, "note", "COLOR_0 = color_scale * irradiance, linear");
        json_close_object(json);
    }
    json_close_array(json);
}

static ty_result print_sidecar(ty_context* context, FILE* file, const void* user) {
    (void)context;
    const bake_run* run = user;
    char hash[24];
    snprintf(hash, sizeof hash, "%016" PRIx64, ty_scene_hash(run->scene));
    json_writer json = json_begin(file);
    json_open_object(&json, NULL);
    json_int(&json, "tyndall_bake", 1);
    json_text(&json, "version", ty_version());
    json_bool(&json, "complete", run->complete);
    json_text(&json, "scene", run->options->scene);
    json_text(&json, "scene_hash", hash);
    put_conventions(&json, run);
    put_options(&json, run);
    json_open_array(&json, "layers");
    for (int layer = 0; layer < TY_BAKE_LAYERS; ++layer) json_text(&json, NULL, layer_names[layer]);
    json_close_array(&json);
    json_text(&json, "layers_note", "R, G, B are their sum");
    json_text(&json, "lightmap_rows", "the first row is at v = 0 of TEXCOORD_1, as glTF has it");
    json_text(&json, "l1",
              "L1.cA: the vector irradiance of colour c along A, towards where light comes from, over the integral of "
              "radiance; its length is 0..1");
    if (run->plan.grid.size[0] > 0 || run->plan.probe_count > 0) put_harmonics(&json, run);
    put_files(&json, run);
    json_number(&json, "table_seconds", run->table_seconds);
    json_close_object(&json);
    return TY_OK;
}

ty_result bake_write_sidecar(bake_run* run) {
    char path[BAKE_PATH_SIZE];
    snprintf(path, sizeof path, "%s/bake.json", run->options->folder);
    return cli_write_text_file(run->session->context, path, print_sidecar, run);
}

/* ---- --stats ---- */

void bake_count_totals(bake_run* run) {
    run->totals = (bake_totals){.units_done = 0};
    for (int32_t i = 0; i < run->plan.count; ++i) {
        const bake_unit* unit = &run->plan.units[i];
        if (!unit->done) continue;
        run->totals.seconds += unit->seconds;
        run->totals.rays += unit->rays;
        run->totals.paths += unit->paths;
        ++run->totals.units_done;
    }
}

void bake_report_stats(json_writer* json, const void* user) {
    const bake_run* run = user;
    put_options(json, run);
    json_bool(json, "complete", run->complete);
    json_int(json, "units", run->plan.count);
    json_int(json, "units_done", run->totals.units_done);
    json_int(json, "receivers", run->plan.receivers);
    json_number(json, "bytes", run->plan.bytes);
    json_int(json, "paths", run->totals.paths);
    json_int(json, "rays", run->totals.rays);
    json_number(json, "bake_seconds", run->totals.seconds);
    json_number(json, "table_seconds", run->table_seconds);
}
