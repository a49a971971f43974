/* tyndall bake: precomputed light on meshes and at points. */
#define _GNU_SOURCE
#include "cli/bake/bake.h"
#include "bake/receivers/distributed.h"
#include "cli/bake/mesh_scene.h"
#include "cli/commands.h"
#include "cli/session/ranks.h"
#include "method/joint.h"

#include <stdlib.h>
#include <string.h>

enum { SPP_MAX = 1 << 20, SPP_LOW = 64, SPP_HIGH = 1024, SPP_BOUNDED = 1 << 16 };

/* ---- The scene ---- */

static bool is_mesh_file(const char* path) {
    static const char* const extensions[] = {".glb", ".gltf", ".obj", ".ply"};
    for (size_t i = 0; i < sizeof extensions / sizeof *extensions; ++i)
        if (cli_has_extension(path, extensions[i])) return true;
    return false;
}

static ty_result load_scene(cli_session* session, const bake_options* options, ty_scene** out) {
    if (is_mesh_file(options->scene)) return cli_load_mesh_scene(session, options->scene, &options->overrides, out);
    return ty_scene_load(session->context, options->scene, options->overrides.items, options->overrides.count, out);
}

/* ---- Baking ---- */

static ty_bake_def make_def(bake_run* run) {
    const bake_options* options = run->options;
    ty_bake_def def = ty_default_bake_def();
    def.method = (ty_bake_method)options->method;
    def.spp = options->spp_given      ? options->spp
              : options->error > 0    ? SPP_BOUNDED
              : options->quality == 1 ? SPP_HIGH
                                      : SPP_LOW;
    def.error = options->error;
    def.bounces = options->bounces;
    def.scatterings = options->scatterings > 0        ? options->scatterings
                      : def.method == TY_BAKE_IMPULSE ? def.scatterings
                                                      : TY_IMPULSE_BOUNCES_MAX;
    def.cells = options->cells;
    def.cell_paths = options->cell_paths;
    def.back_scattering = !options->no_back_scattering;
    def.composition = (ty_bake_composition)options->composition;
    def.seed = run->session->common.seed_given ? run->session->common.seed : ty_scene_render_settings(run->scene).seed;
    def.progress = bake_report_progress;
    def.progress_user = run;
    return def;
}

/* A merge takes light that the parts have found. */
static bool is_merge(const bake_run* run) {
    return run->options->merge > 0;
}

static ty_result make_tables(bake_run* run) {
    if (is_merge(run) || run->def.method != TY_BAKE_IMPULSE || ty_scene_get_info(run->scene).media == 0) return TY_OK;
    ty_impulse_def def = ty_default_impulse_def();
    ty_impulse_stats stats = ty_default_impulse_stats();
    if (def.bounces < run->def.scatterings) def.bounces = run->def.scatterings;
    def.progress = cli_progress_report;
    def.progress_user = &run->session->progress;
    const ty_result result = ty_impulse_create(run->session->context, &def, &run->tables, &stats);
    run->def.tables = run->tables;
    run->table_seconds = stats.seconds;
    return result;
}

static ty_result make_cache(bake_run* run) {
    if (is_merge(run) || run->def.method != TY_BAKE_CACHE || ty_scene_get_info(run->scene).media == 0) return TY_OK;
    ty_bake_def def = run->def;
    def.progress = cli_progress_report;
    def.progress_user = &run->session->progress;
    const ty_result result = ty_bake_cache_create(run->scene, &def, &run->cache);
    if (result != TY_OK) return result;
    run->def.cache = run->cache;
    run->cached = true;
    run->cache_info = ty_bake_cache_get_info(run->cache);
    return TY_OK;
}

/* True while any unit is unfinished. */
static bool has_work(const bake_run* run) {
    for (int32_t i = 0; i < run->plan.count; ++i)
        if (!run->plan.units[i].done) return true;
    return false;
}

/* The state and what is done so far. A part writes its file at the end. */
static ty_result record(bake_run* run) {
    if (run->parts.part > 0) return TY_OK;
    const ty_result result = bake_write_state(run);
    return result == TY_OK ? bake_write_sidecar(run) : result;
}

static ty_result bake_units(bake_run* run) {
    ty_result result = TY_OK;
    for (int32_t i = 0; i < run->plan.count && result == TY_OK; ++i) {
        bake_unit* unit = &run->plan.units[i];
        if (unit->done) continue;
        result = cli_interrupted() ? TY_CANCELLED : bake_unit_run(run, unit);
        if (result != TY_OK) return result;
        unit->done = true;
        run->receivers_done += (double)unit->receivers;
        result = record(run);
    }
    return result;
}

static void print_closing_lines(const bake_run* run) {
    int32_t done = 0, resumed = 0;
    for (int32_t i = 0; i < run->plan.count; ++i) {
        done += run->plan.units[i].done;
        resumed += run->plan.units[i].resumed;
    }
    printf("bake (%s): %d of %d done", bake_method_names[run->options->method], (int)done, (int)run->plan.count);
    if (resumed > 0) printf(", %d of them before", (int)resumed);
    printf(", %.1f s", cli_wall_seconds() - run->started);
    if (run->tables != NULL) printf(" (tables %.1f s)", run->table_seconds);
    if (run->cached) printf(" (light in media %.1f s)", run->cache_info.seconds);
    printf("%s\nwrote %s/bake.json and what it lists\n", run->complete ? "" : ", interrupted", run->options->folder);
}

static int finish_part(bake_run* run, ty_result result) {
    if (result == TY_OK) result = bake_write_part(run);
    if (result == TY_OK) return CLI_DONE;
    if (result != TY_CANCELLED) return cli_fail_running(run->session, result);
    if (!run->session->common.quiet) printf("interrupted; nothing was written\n");
    return CLI_INTERRUPTED;
}

/* Returns the exit status. */
static int finish(bake_run* run, ty_result result) {
    cli_progress_clear(&run->session->progress);
    if (run->parts.part > 0) return finish_part(run, result);
    if (result == TY_ERROR_INPUT) return cli_fail_reading(run->session, result);
    if (result != TY_OK && result != TY_CANCELLED) return cli_fail_running(run->session, result);
    if (result == TY_OK) {
        const int status = bake_write_colors(run);
        if (status != CLI_GO) return status;
        run->complete = true;
        result = bake_write_sidecar(run);
        if (result != TY_OK) return cli_fail_running(run->session, result);
    }
    if (!run->session->common.quiet) print_closing_lines(run);
    return run->complete ? CLI_DONE : CLI_INTERRUPTED;
}

static int bake_scene(bake_run* run) {
    const bake_options* options = run->options;
    cli_session* session = run->session;
    run->def = make_def(run);
    int status = bake_make_plan(run);
    if (status != CLI_GO) return status;
    if (options->dry_run) {
        bake_print_plan(run);
        return CLI_DONE;
    }
    run->parts = (bake_parts){.part = options->part[0], .count = is_merge(run) ? options->merge : options->part[1]};
    status = cli_make_folder("bake", options->folder);
    if (status == CLI_GO && run->parts.part == 0) status = bake_lock(run);
    if (status == CLI_GO) status = bake_open_parts(run);
    if (status != CLI_GO) return status;
    run->copies = bake_list_copies(run, &run->copy_count);
    if (status == CLI_GO && run->copies == NULL) status = cli_fail_running(session, TY_ERROR_MEMORY);
    if (status == CLI_GO) status = bake_check_copies(run);
    if (status == CLI_GO && options->resume && run->parts.part == 0) status = bake_read_state(run);
    if (status != CLI_GO) return status;
    if (!session->common.quiet) bake_print_plan(run);
    fflush(stdout);
    session->stats = bake_report_stats;
    session->stats_user = run;
    run->started = cli_wall_seconds();
    ty_result result = record(run);
    if (result == TY_OK && has_work(run)) result = make_tables(run);
    if (result == TY_OK && has_work(run)) result = make_cache(run);
    run->started = cli_wall_seconds();
    if (result == TY_OK) result = bake_units(run);
    return finish(run, result);
}

/* A rank other than 0: it reads the scene, makes the same cache, and samples receivers for rank 0. */
static int help_baking(cli_session* session, const bake_options* options) {
    bake_run run = {.session = session, .options = options};
    const ty_result result = load_scene(session, options, &run.scene);
    cli_ranks_hello(session, result == TY_OK ? CLI_GO : cli_fail_reading(session, result), run.scene);
    if (result == TY_OK) {
        run.def = make_def(&run);
        run.def.progress = NULL;
        if (make_cache(&run) != TY_OK || make_tables(&run) != TY_OK)
            ty_take_error(session->context); /* and refuses jobs with a cache */
    }
    ty_bake_helper helper = {run.scene, run.cache, run.tables};
    ty_joint_helper joint;
    ty_job_worker workers[TY_JOB_KINDS] = {0};
    if (result == TY_OK) workers[TY_JOB_JOINT] = ty_joint_worker(&joint, session->comm, run.scene);
    workers[TY_JOB_BAKE] = ty_bake_job_worker(&helper);
    const int status = cli_ranks_serve(session, workers, NULL);
    ty_bake_cache_destroy(run.cache);
    ty_impulse_destroy(run.tables);
    ty_scene_destroy(run.scene);
    return cli_session_close(session, status);
}

static int load_and_bake(cli_session* session, const bake_options* options) {
    bake_run run = {.session = session, .options = options};
    cli_end_on_interrupt(true);
    const ty_result result = load_scene(session, options, &run.scene);
    cli_end_on_interrupt(false);
    int status = result != TY_OK ? cli_fail_reading(session, result) : cli_ranks_greet(session, run.scene);
    if (status == CLI_GO) status = bake_scene(&run);
    bake_close_parts(&run);
    cli_lock_release(&run.lock);
    bake_count_totals(&run);
    bake_free_plan(session, &run.plan);
    free(run.copies);
    ty_bake_cache_destroy(run.cache);
    ty_impulse_destroy(run.tables);
    ty_scene_destroy(run.scene);
    return cli_session_close(session, status);
}

/* ---- Options ---- */

/* Parses "8,4,8". */
static bool parse_counts(const char* text, int32_t counts[3]) {
    char rest;
    int values[3];
    if (sscanf(text, "%5d,%5d,%5d%c", &values[0], &values[1], &values[2], &rest) != 3) return false;
    for (int a = 0; a < 3; ++a) {
        if (values[a] < 1 || values[a] > 65536) return false;
        counts[a] = values[a];
    }
    return true;
}

static int check_options(bake_options* options) {
    if (options->folder == NULL && !options->dry_run) return cli_usage_error("bake", "where to? Give -o DIR");
    if (options->folder == NULL) options->folder = ".";
    if (strlen(options->folder) > BAKE_PATH_SIZE - 256) return cli_usage_error("bake", "the folder's name is too long");
    if (options->grid_text != NULL && !parse_counts(options->grid_text, options->grid))
        return cli_usage_error("bake", "--grid: '%s' is not three numbers of probes like 8,4,8", options->grid_text);
    if (options->grid_text != NULL && options->grid_spacing > 0)
        return cli_usage_error("bake", "--grid and --grid-spacing both say how many probes; give one");
    if (options->denoise && options->spp_given && options->spp < 2)
        return cli_usage_error("bake", "--denoise compares two halves of the paths, and there is one");
    if (options->part_text != NULL && options->merge > 0)
        return cli_usage_error("bake", "--part makes a part, and --merge takes all of them; give one");
    if (options->merge > 0 && options->resume)
        return cli_usage_error("bake", "--merge makes all again from the parts, without --resume");
    if ((options->part_text != NULL || options->merge > 0) && options->error > 0)
        return cli_usage_error("bake", "--error looks at all receivers of a mesh, and a part has some; give --spp");
    if ((options->part_text != NULL || options->merge > 0) && options->method == TY_BAKE_IMPULSE)
        return cli_usage_error("bake", "method impulse has virtual emitters from all receivers, and a part has some");
    if (options->part_text != NULL && cli_parse_part("bake", options->part_text, options->part) != CLI_GO)
        return CLI_USAGE;
    if (options->sh != 3 && options->sh != 5)
        return cli_usage_error("bake", "--sh: %d is neither 3 nor 5", (int)options->sh);
    return CLI_GO;
}

int cli_bake(int count, char** arguments) {
    const ty_atlas_def atlas = ty_default_atlas_def();
    bake_options options = {.cells = 32, .cell_paths = 64, .sh = 3, .padding = atlas.padding, .density = atlas.density};
    const cli_option table[] = {
        {"output", 'o', CLI_TEXT, "DIR", "the folder to write to; made if it is missing", &options.folder, 0, 0, NULL},
        {"method", 0, CLI_CHOICE, "cache|impulse|attenuation|surfaces|path", "how media count (default cache)",
         &options.method, 0, 0, NULL},
        {"quality", 0, CLI_CHOICE, "low|high", "64 or 1024 paths per receiver (default low)", &options.quality, 0, 0,
         NULL},
        {"spp", 0, CLI_INT, "N", "paths per receiver, in place of the quality's", &options.spp, 1, SPP_MAX,
         &options.spp_given},
        {"error", 0, CLI_REAL, "E", "stop where the relative error is below this, 0.01 for 1%", &options.error, 1e-6, 1,
         NULL},
        {"bounces", 0, CLI_INT, "N", "reflections at most (default 0: 16, and some paths end earlier)",
         &options.bounces, 0, 1024, NULL},
        {"scatterings", 0, CLI_INT, "N", "scatterings in a row at most (default 64, and 10 for impulse)",
         &options.scatterings, 1, TY_IMPULSE_BOUNCES_MAX, NULL},
        {"cache", 0, CLI_INT, "N", "cells of the media's light along their longest side (default 32)", &options.cells,
         1, 512, NULL},
        {"cache-paths", 0, CLI_INT, "N", "paths that gather light in each cell (default 64)", &options.cell_paths, 1,
         SPP_MAX, NULL},
        {"composition", 0, CLI_CHOICE, "collisions|published",
         "impulse: responses at a receiver, corrected at collisions or as published (default collisions)",
         &options.composition, 0, 0, NULL},
        {"no-back-scattering", 0, CLI_FLAG, NULL,
         "impulse: leave out what surfaces behind a receiver send into the medium", &options.no_back_scattering, 0, 0,
         NULL},
        {"denoise", 0, CLI_FLAG, NULL,
         "also write lightmaps without noise, NAME.denoised.exr and .png, from two halves of the paths",
         &options.denoise, 0, 0, NULL},
        {"lightmaps", 0, CLI_FLAG, NULL, "bake meshes by lightmap", &options.lightmaps, 0, 0, NULL},
        {"vertices", 0, CLI_FLAG, NULL, "bake meshes by vertex; with --lightmaps only those without UV2",
         &options.vertices, 0, 0, NULL},
        {"grid", 0, CLI_TEXT, "NX,NY,NZ", "bake a light grid of so many probes over the meshes", &options.grid_text, 0,
         0, NULL},
        {"grid-spacing", 0, CLI_REAL, "M", "the same, so many metres apart", &options.grid_spacing, 1e-6, 1e9, NULL},
        {"probes", 0, CLI_TEXT, "FILE.json", "bake probes at these points", &options.probes, 0, 0, NULL},
        {"sh", 0, CLI_INT, "3|5", "order of the probes' spherical harmonics: 9 or 25 terms (default 3)", &options.sh, 3,
         5, NULL},
        {"density", 0, CLI_REAL, "T", "texels per metre (default 8)", &options.density, 1e-6, 1e6, NULL},
        {"size", 0, CLI_SIZE, "WxH", "texels of every lightmap, in place of the density's", options.size, 0, 0, NULL},
        {"padding", 0, CLI_INT, "N", "texels around charts that are filled (default 4)", &options.padding, 0, 64, NULL},
        {"define", 'D', CLI_LIST, "KEY=VALUE", "change the scene: -D media[0].g=0.5 (again for more)",
         &options.overrides, 0, 0, NULL},
        {"resume", 0, CLI_FLAG, NULL, "keep what an interrupted bake into DIR finished, and go on", &options.resume, 0,
         0, NULL},
        {"part", 0, CLI_TEXT, "I/N", "sample part I of N of all receivers, for --merge", &options.part_text, 0, 0,
         NULL},
        {"merge", 0, CLI_INT, "N", "make the bake from N parts in DIR, given the same other options", &options.merge, 1,
         1 << 16, NULL},
        {"dry-run", 0, CLI_FLAG, NULL, "say what would be baked, and how much memory that takes", &options.dry_run, 0,
         0, NULL},
    };
    const cli_syntax syntax = {
        "bake",
        "SCENE -o DIR [options]",
        "Bakes light on meshes and at points.",
        "SCENE is a scene file, builtin:NAME, or a mesh file by itself. Unless told otherwise, meshes with a second "
        "set\n"
        "of texture coordinates (UV2) get lightmaps, the others light at their vertices. DIR/bake.json says what was\n"
        "written, in which units. Interrupting (Ctrl-C) keeps what is finished and exits with 130.\n"
        "One process at a time may write to DIR; a kill costs the mesh, or the probes, under way. Parts are for\n"
        "machines without MPI, and may be made at the same time: docs/farm.md.",
        table,
        sizeof table / sizeof table[0],
        1,
        1,
        NULL};
    cli_arguments given;
    int status = cli_parse(&syntax, count, arguments, &given);
    if (status != CLI_GO) return status;
    options.scene = given.positional[0];
    status = check_options(&options);
    cli_session session;
    if (status == CLI_GO) status = cli_session_open(&session, "bake", &given.common);
    if (status == CLI_GO) status = cli_ranks_open(&session);
    if (status != CLI_GO) return status;
    return cli_ranks_helps(&session) ? help_baking(&session, &options) : load_and_bake(&session, &options);
}
