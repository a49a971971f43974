/* tyndall fluence: the fluence of a scene's light on a grid, as a volume. */
#include "base/context.h"
#include "cli/commands.h"
#include "cli/convert/convert.h"
#include "cli/fluence/fog_texture.h"
#include "cli/methods/help_paths.h"
#include "cli/methods/methods.h"
#include "cli/session/ranks.h"
#include "grid/grid.h"
#include "io/textures/textures.h"
#include "method/cell_light.h"
#include "scene/media/medium.h"
#include "scene/scene.h"

#include <tyndall/tyndall.h>

#include <math.h>
#include <string.h>

enum { SPP_MAX = 1 << 24, LONGEST_SIDE = 64, ZSTD_LEVEL = 9, FLUENCE = 0, UNCOLLIDED = 1, PARTS = 2 };

typedef struct fluence_options {
    const char *output, *method, *size_text, *box_text, *codec;
    int32_t spp, size[3];
    int quantity; /* a cli_fog_quantity */
    bool spp_given, half, plain, scattered;
    cli_list overrides;
    double lower[3], upper[3];
} fluence_options;

/* Fluence, then its uncollided part: three channels in each cell, x fastest. moments: as in ty_cell_moments, with
 * CLI_FOG_PHASE, for which the first is all but the second; else NULL. */
typedef struct fluence_cells {
    double* values[PARTS];
    float *moments, *cosines;
    size_t cells;
} fluence_cells;

/* ---- options ---- */

/* Reads `count` numbers between commas. */
static bool parse_list(const char* text, int count, double* out) {
    for (int i = 0; i < count; ++i) {
        char part[64];
        const size_t length = strcspn(text, ",");
        if (length >= sizeof part || (text[length] == ',') != (i + 1 < count)) return false;
        memcpy(part, text, length);
        part[length] = '\0';
        if (!cli_parse_real(part, &out[i])) return false;
        text += length + 1;
    }
    return true;
}

static bool is_texture(const char* path) {
    return cli_has_extension(path, ".ktx2") || cli_has_extension(path, ".dds");
}

static int check_options(fluence_options* options) {
    double sides[3], box[6];
    if (options->output == NULL) return cli_usage_error("fluence", "-o FILE is missing");
    if (!cli_has_extension(options->output, ".vti") && !cli_has_extension(options->output, ".vdb") &&
        !is_texture(options->output))
        return cli_usage_error("fluence", "%s: the extension is not .vti, .vdb, .ktx2 or .dds", options->output);
    if ((options->quantity != CLI_FOG_SCATTER || options->scattered) && !is_texture(options->output))
        return cli_usage_error("fluence", "--texture and --scattered are for .ktx2 and .dds, and %s is neither",
                               options->output);
    if (options->quantity == CLI_FOG_PHASE && (strcmp(options->method, "dom") != 0 || options->scattered))
        return cli_usage_error(
            "fluence", options->scattered ? "--texture phase leaves out uncollided light anyway, and --scattered is "
                                            "for the other textures"
                                          : "--texture phase is of --method dom, which knows directions of light");
    if (options->half && !cli_has_extension(options->output, ".vdb"))
        return cli_usage_error("fluence", "--half is for .vdb, and %s is none", options->output);
    if (options->size_text != NULL) {
        const bool numbers = parse_list(options->size_text, 3, sides);
        for (int a = 0; a < 3; ++a) {
            if (!numbers || !(sides[a] >= 1 && sides[a] <= TY_GRID_SIDE_MAX) || sides[a] != floor(sides[a]))
                return cli_usage_error("fluence", "--size: '%s' is not X,Y,Z from 1 to %d", options->size_text,
                                       TY_GRID_SIDE_MAX);
            options->size[a] = (int32_t)sides[a];
        }
    }
    if (options->box_text != NULL) {
        const bool numbers = parse_list(options->box_text, 6, box);
        for (int a = 0; a < 3; ++a) {
            if (!numbers || !(box[a] < box[3 + a]))
                return cli_usage_error("fluence", "--box: '%s' is not X,Y,Z,X,Y,Z, the lower corner and the upper one",
                                       options->box_text);
            options->lower[a] = box[a];
            options->upper[a] = box[3 + a];
        }
    }
    if (options->codec != NULL && is_texture(options->output))
        return cli_usage_error("fluence", "--codec is for .vti and .vdb, and %s is neither", options->output);
    const int status =
        is_texture(options->output) ? CLI_GO : cli_check_codec("fluence", &options->codec, options->output);
    return status == CLI_GO ? cli_check_output("fluence", options->output) : status;
}

/* The box around the media, and cubes in it, where neither is given. */
static int complete_options(const ty_scene* scene, fluence_options* options) {
    double longest = 0;
    if (options->box_text == NULL) {
        if (scene->medium_count == 0)
            return cli_fail(CLI_USAGE, "the scene has no media, and so no box; --box X,Y,Z,X,Y,Z gives one");
        for (int a = 0; a < 3; ++a) {
            options->lower[a] = INFINITY;
            options->upper[a] = -INFINITY;
        }
        for (size_t m = 0; m < scene->medium_count; ++m)
            ty_medium_extent(&scene->media[m], options->lower, options->upper);
    }
    for (int a = 0; a < 3; ++a) longest = fmax(longest, options->upper[a] - options->lower[a]);
    for (int a = 0; a < 3 && options->size_text == NULL; ++a)
        options->size[a] = (int32_t)fmax(1, round(LONGEST_SIDE * (options->upper[a] - options->lower[a]) / longest));
    return CLI_GO;
}

/* ---- light ---- */

#define SOLVE(name, call)                                                                                              \
    static ty_result solve_##name(cli_session* session, const ty_scene* scene, const fluence_options* options,         \
                                  fluence_cells* out) {                                                                \
        ty_##name##_def def = ty_default_##name##_def();                                                               \
        ty_##name* light = NULL;                                                                                       \
        ty_result result = ty_method_options(scene, #name, &def);                                                      \
        def.progress = cli_progress_report;                                                                            \
        def.progress_user = &session->progress;                                                                        \
        if (result == TY_OK) result = ty_##name##_solve(scene, &def, &light, NULL);                                    \
        if (result == TY_OK) result = call;                                                                            \
        ty_##name##_destroy(light);                                                                                    \
        return result;                                                                                                 \
    }

static ty_result split_light(const ty_dom* light, const fluence_options* options, fluence_cells* out) {
    ty_cell_moments split = {out->values[UNCOLLIDED], out->values[FLUENCE], out->moments, out->cosines};
    if (out->moments != NULL) return ty_dom_cell_moments(light, options->lower, options->upper, options->size, &split);
    return ty_dom_fluence(light, options->lower, options->upper, options->size, out->values[FLUENCE],
                          out->values[UNCOLLIDED]);
}

SOLVE(dom, split_light(light, options, out))
SOLVE(fld, ty_fld_fluence(light, options->lower, options->upper, options->size, out->values[FLUENCE],
                          out->values[UNCOLLIDED], NULL))

static ty_result trace(cli_session* session, const ty_scene* scene, const fluence_options* options,
                       fluence_cells* out) {
    const ty_render_settings settings = ty_scene_render_settings(scene);
    const cli_request request = {.spp = options->spp_given ? options->spp : settings.spp,
                                 .seed = session->common.seed_given ? session->common.seed : settings.seed};
    ty_path_def def;
    const ty_result result = cli_path_def(session, scene, &request, &def);
    return result == TY_OK ? ty_path_fluence(scene, &def, options->lower, options->upper, options->size,
                                             out->values[FLUENCE], out->values[UNCOLLIDED], NULL)
                           : result;
}

static ty_result find_light(cli_session* session, const ty_scene* scene, const fluence_options* options,
                            fluence_cells* out) {
    if (strcmp(options->method, "path") == 0) return trace(session, scene, options, out);
    return strcmp(options->method, "fld") == 0 ? solve_fld(session, scene, options, out)
                                               : solve_dom(session, scene, options, out);
}

/* ---- the file ---- */

/* One channel as a grid whose voxels are the cells. */
static ty_result make_grid(ty_context* context, const fluence_options* options, const fluence_cells* cells, int part,
                           int channel, ty_grid** out) {
    ty_grid_def def = ty_default_grid_def();
    def.placed = true;
    def.type = options->half ? TY_GRID_F16 : TY_GRID_F32;
    for (int a = 0; a < 3; ++a) {
        const double step = (options->upper[a] - options->lower[a]) / options->size[a];
        def.size[a] = options->size[a];
        def.index_to_local.m[5 * a] = step;
        def.index_to_local.m[4 * a + 3] = options->lower[a] + step / 2;
    }
    const size_t size = ty_grid_value_size(def.type);
    void* values = ty_alloc_array(context, cells->cells, size, false);
    if (values == NULL) return TY_ERROR_MEMORY;
    for (size_t i = 0; i < cells->cells; ++i) {
        const float value = (float)cells->values[part][3 * i + (size_t)channel];
        if (options->half)
            ((uint16_t*)values)[i] = ty_float_to_half(value);
        else
            ((float*)values)[i] = value;
    }
    return ty_grid_adopt(context, &def, values, out);
}

static ty_result write_cells(ty_context* context, const fluence_options* options, const fluence_cells* cells) {
    static const char* const names[PARTS] = {"fluence", "uncollided"};
    ty_grid* grids[PARTS][3] = {{NULL}};
    ty_volume_field fields[PARTS];
    ty_result result = TY_OK;
    for (int part = 0; part < PARTS; ++part) {
        fields[part] = (ty_volume_field){.name = names[part], .components = 3};
        for (int c = 0; c < 3 && result == TY_OK; ++c) {
            result = make_grid(context, options, cells, part, c, &grids[part][c]);
            fields[part].grids[c] = grids[part][c];
        }
    }
    if (result == TY_OK) result = ty_volume_write(context, fields, PARTS, options->codec, options->output);
    for (int part = 0; part < PARTS; ++part)
        for (int c = 0; c < 3; ++c) ty_grid_release(grids[part][c]);
    return result;
}

static ty_result write_light(ty_context* context, const ty_scene* scene, const fluence_options* options,
                             fluence_cells* cells) {
    if (!is_texture(options->output)) return write_cells(context, options, cells);
    for (size_t i = 0; options->scattered && i < 3 * cells->cells; ++i)
        cells->values[FLUENCE][i] = fmax(cells->values[FLUENCE][i] - cells->values[UNCOLLIDED][i], 0);
    const cli_fog_texture fog = {
        .quantity = (cli_fog_quantity)options->quantity,
        .lower = options->lower,
        .upper = options->upper,
        .size = options->size,
        .scattered = options->scattered,
        .fluence = cells->values[FLUENCE],
        .split = {cells->values[UNCOLLIDED], cells->values[FLUENCE], cells->moments, cells->cosines},
        .zstd = ty_has_zstd() && !options->plain ? ZSTD_LEVEL : 0};
    return cli_write_fog_texture(context, scene, &fog, options->output);
}

static int run(cli_session* session, const char* scene_path, fluence_options* options) {
    ty_context* context = session->context;
    ty_scene* scene = NULL;
    cli_end_on_interrupt(true);
    ty_result result = ty_scene_load(context, scene_path, options->overrides.items, options->overrides.count, &scene);
    cli_end_on_interrupt(false);
    int status = result != TY_OK ? cli_fail_reading(session, result) : cli_ranks_greet(session, scene);
    if (status == CLI_GO) status = complete_options(scene, options);
    fluence_cells cells = {.cells = (size_t)options->size[0] * (size_t)options->size[1] * (size_t)options->size[2]};
    for (int part = 0; part < PARTS && status == CLI_GO; ++part) {
        cells.values[part] = ty_alloc_array(context, 3 * cells.cells, sizeof(double), true);
        if (cells.values[part] == NULL) status = cli_fail_running(session, TY_ERROR_MEMORY);
    }
    if (status == CLI_GO && options->quantity == CLI_FOG_PHASE) {
        cells.moments = ty_alloc_array(context, TY_CELL_TERMS * cells.cells, sizeof(float), true);
        cells.cosines = ty_alloc_array(context, 3 * cells.cells, sizeof(float), true);
        if (cells.moments == NULL || cells.cosines == NULL) status = cli_fail_running(session, TY_ERROR_MEMORY);
    }
    if (status == CLI_GO) {
        result = find_light(session, scene, options, &cells);
        cli_progress_clear(&session->progress);
        if (result == TY_OK) result = write_light(context, scene, options, &cells);
        status = result == TY_OK ? CLI_DONE : cli_fail_running(session, result);
    }
    for (int part = 0; part < PARTS; ++part)
        ty_free_array(context, cells.values[part], 3 * cells.cells, sizeof(double));
    ty_free_array(context, cells.moments, TY_CELL_TERMS * cells.cells, sizeof(float));
    ty_free_array(context, cells.cosines, 3 * cells.cells, sizeof(float));
    ty_scene_destroy(scene);
    if (status == CLI_DONE && !session->common.quiet)
        printf("wrote %s: %d x %d x %d cells by %s\n", options->output, options->size[0], options->size[1],
               options->size[2], options->method);
    return status;
}

int cli_fluence(int count, char** arguments) {
    static const char* const methods[] = {"dom", "fld", "path"};
    int method = 0;
    fluence_options options = {.output = NULL};
    const cli_option table[] = {
        {"output", 'o', CLI_TEXT, "FILE", "the volume: .vti (ParaView), .vdb, or a texture, .ktx2 or .dds",
         &options.output, 0, 0, NULL},
        {"method", 'm', CLI_CHOICE, "dom|fld|path", "how the light is found (default dom)", &method, 0, 0, NULL},
        {"size", 0, CLI_TEXT, "X,Y,Z", "cells along each axis (default: cubes, 64 along the longest side)",
         &options.size_text, 0, 0, NULL},
        {"box", 0, CLI_TEXT, "X,Y,Z,X,Y,Z", "lower and upper corner, m (default: around the media)", &options.box_text,
         0, 0, NULL},
        {"spp", 0, CLI_INT, "N", "samples of each cell, of path (default: what the scene says)", &options.spp, 1,
         SPP_MAX, &options.spp_given},
        {"codec", 0, CLI_TEXT, "NAME", ".vdb: zip, blosc, none; .vti: zip, none (default: zip)", &options.codec, 0, 0,
         NULL},
        {"half", 0, CLI_FLAG, NULL, "store values as half floats (.vdb)", &options.half, 0, 0, NULL},
        {"texture", 0, CLI_CHOICE, "scatter|fluence|phase",
         "a texture's quantity: light that media scatter and emit per metre (default), fluence, or with two more "
         "textures light to be scattered by the phase function (dom)",
         &options.quantity, 0, 0, NULL},
        {"scattered", 0, CLI_FLAG, NULL, "a texture without uncollided light, for engines that add their lights' own",
         &options.scattered, 0, 0, NULL},
        {"no-zstd", 0, CLI_FLAG, NULL, "a .ktx2 without compression", &options.plain, 0, 0, NULL},
        {"define", 'D', CLI_LIST, "KEY=VALUE", "change the scene: -D media[0].g=0.5 (again for more)",
         &options.overrides, 0, 0, NULL},
    };
    const cli_syntax syntax = {
        "fluence",
        "SCENE -o OUT.vti|OUT.vdb|OUT.ktx2|OUT.dds [options]",
        "Writes the fluence of the light on a grid, as a volume.",
        "SCENE is a JSON file, or builtin:NAME. Fluence is the integral of radiance over all directions, W m^-2, as "
        "the\n"
        "mean of each cell: red, green and blue of the vectors fluence, of all light, and uncollided, of light that\n"
        "nothing scattered. Cells are placed in metres, as voxels around their centres. A texture has four half "
        "floats,\n"
        "of which alpha is the extinction, 1/m, and OUT.json has its box (docs/engines.md).",
        table,
        sizeof table / sizeof table[0],
        1,
        1,
        NULL};
    cli_arguments given;
    int status = cli_parse(&syntax, count, arguments, &given);
    options.method = methods[method];
    if (status == CLI_GO) status = check_options(&options);
    cli_session session;
    if (status == CLI_GO) status = cli_session_open(&session, "fluence", &given.common);
    if (status == CLI_GO) status = cli_ranks_open(&session);
    if (status != CLI_GO) return status;
    if (cli_ranks_helps(&session)) return cli_help_paths(&session, given.positional[0], &options.overrides, false);
    return cli_session_close(&session, run(&session, given.positional[0], &options));
}
