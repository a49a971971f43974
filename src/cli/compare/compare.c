/* tyndall compare: methods, or finished images, against a reference. */
#define _POSIX_C_SOURCE 200809L
#include "cli/commands.h"
#include "cli/compare/files.h"
#include "cli/compare/measure.h"
#include "cli/compare/read.h"
#include "cli/compare/scene.h"
#include "cli/methods/help_paths.h"
#include "cli/session/ranks.h"
#include "io/scenes/builtin.h"

#include <stdlib.h>
#include <string.h>

enum { SPP_MAX = 1 << 24, SCENE_TEXT_MAX = 1 << 18 };

typedef struct compare_options {
    const char* folder;
    cli_compare_request scene;
    double exposure;
    bool exposure_given, seconds_given, noise_given;
    cli_list overrides;
} compare_options;

/* ---- images ---- */

static int compare_images(cli_session* session, cli_comparison* comparison, const cli_arguments* given) {
    cli_compared* reference = &comparison->reference;
    snprintf(reference->name, CLI_COMPARE_NAME, "reference");
    int status = cli_read_compared(session, given->positional[0], reference);
    if (status == CLI_GO) reference->noise = cli_measure_noise(reference->image, reference->image);
    for (int i = 1; i < given->positional_count && status == CLI_GO; ++i) {
        cli_compared* entry = &comparison->entries[comparison->count];
        cli_choose_name(comparison, given->positional[i], entry->name);
        status = cli_read_compared(session, given->positional[i], entry);
        if (status != CLI_GO) break;
        ++comparison->count;
        status = cli_measure_entry(session, comparison, entry);
    }
    return status == CLI_GO ? cli_make_folder("compare", comparison->folder) : status;
}

/* ---- scenes ---- */

/* The text of the scene file for the page; unreadable and very long files are left out. */
static char* read_scene_text(cli_session* session, const char* path) {
    static const char prefix[] = "builtin:";
    if (strncmp(path, prefix, sizeof prefix - 1) == 0) {
        for (const ty_builtin_scene* scene = ty_builtin_scenes; scene->name != NULL; ++scene)
            if (strcmp(scene->name, path + sizeof prefix - 1) == 0) return strdup(scene->text);
        return NULL;
    }
    uint8_t* bytes = NULL;
    size_t size = 0;
    if (ty_bytes_read(session->context, path, SCENE_TEXT_MAX, &bytes, &size) != TY_OK) {
        ty_take_error(session->context);
        return NULL;
    }
    char* text = strndup((const char*)bytes, size);
    ty_bytes_destroy(session->context, bytes, size);
    return text;
}

static int load_and_compare(cli_session* session, cli_comparison* comparison, const char* path,
                            const compare_options* options) {
    ty_scene* scene = NULL;
    cli_end_on_interrupt(true);
    const ty_result result =
        ty_scene_load(session->context, path, options->overrides.items, options->overrides.count, &scene);
    cli_end_on_interrupt(false);
    int status = result != TY_OK ? cli_fail_reading(session, result) : cli_ranks_greet(session, scene);
    if (status != CLI_GO) {
        ty_scene_destroy(scene);
        return status;
    }
    comparison->subject = path;
    comparison->overrides = &options->overrides;
    comparison->scene_text = read_scene_text(session, path);
    if (!options->exposure_given) comparison->exposure = ty_scene_camera(scene).exposure;
    status = cli_compare_scene(session, comparison, scene, &options->scene);
    ty_scene_destroy(scene);
    return status;
}

/* ---- the command ---- */

static void print_result(const cli_comparison* comparison) {
    printf("%-24s %14s %14s %14s %14s %14s\n", "", "mean ratio", "RMSE", "relative RMSE", "without noise", "relMSE");
    for (int i = 0; i < comparison->count; ++i) {
        const cli_compared* entry = &comparison->entries[i];
        const ty_difference* d = &entry->difference;
        char without[24];
        cli_without_noise_text(entry, 3, without);
        printf("%-24s %14.8g %14.6g %14.6g %14s %14.6g\n", entry->name, d->mean_ratio[3], d->rmse[3],
               d->relative_rmse[3], without, d->rel_mse[3]);
    }
    char sentence[256];
    cli_noise_sentence(comparison, sentence, sizeof sentence);
    if (sentence[0] != '\0') printf("%s\n", sentence);
    printf("wrote %s/report.html, errors.json, table.md, side.png and heat maps\n", comparison->folder);
}

static bool is_image(const char* path) {
    static const char* const extensions[] = {".exr", ".hdr", ".png", ".jpg", ".jpeg", ".webp"};
    for (size_t i = 0; i < sizeof extensions / sizeof *extensions; ++i)
        if (cli_has_extension(path, extensions[i])) return true;
    return false;
}

static int run_comparison(cli_session* session, const cli_arguments* given, const compare_options* options) {
    cli_comparison comparison = {
        .folder = options->folder, .exposure = options->exposure, .wanted = options->scene.reference_noise};
    comparison.entries = calloc(CLI_COMPARE_MAX, sizeof *comparison.entries);
    comparison.skipped = calloc(CLI_COMPARE_MAX, sizeof *comparison.skipped);
    int status = CLI_FAILED;
    if (comparison.entries == NULL || comparison.skipped == NULL)
        cli_fail(CLI_FAILED, "not enough memory");
    else
        status = is_image(given->positional[0]) ? compare_images(session, &comparison, given)
                                                : load_and_compare(session, &comparison, given->positional[0], options);
    cli_progress_clear(&session->progress);
    if (status == CLI_GO) status = cli_write_comparison(session, &comparison);
    if (status == CLI_DONE && !session->common.quiet) print_result(&comparison);
    cli_comparison_free_images(&comparison);
    session->stats = cli_comparison_json;
    session->stats_user = &comparison;
    status = cli_session_close(session, status);
    cli_comparison_free(&comparison);
    return status;
}

/* Checks of options that need no file. */
static int check_options(const cli_arguments* given, const compare_options* options) {
    const cli_compare_request* scene = &options->scene;
    const bool images = is_image(given->positional[0]);
    const bool renders_reference = scene->reference_spp_given || options->seconds_given || options->noise_given;
    if (options->folder == NULL) return cli_usage_error("compare", "where to? Give -o DIR");
    if (images && given->positional_count < 2)
        return cli_usage_error("compare", "what to compare with %s? Give images", given->positional[0]);
    if (images && (scene->methods != NULL || scene->reference != NULL || scene->spp_given || renders_reference ||
                   scene->size[0] > 0 || options->overrides.count > 0))
        return cli_usage_error("compare", "only --exposure goes with finished images, and %s is one",
                               given->positional[0]);
    if (!images && given->positional_count > 1)
        return cli_usage_error("compare", "'%s' is one argument too many after a scene", given->positional[1]);
    if (scene->reference != NULL && renders_reference)
        return cli_usage_error("compare", "%s is for rendering a reference; do not give --reference",
                               scene->reference_spp_given ? "--reference-spp"
                               : options->seconds_given   ? "--reference-time"
                                                          : "--reference-noise");
    const ty_method* methods[CLI_COMPARE_MAX];
    return images || cli_name_methods(scene->methods, methods) >= 0 ? CLI_GO : CLI_USAGE;
}

int cli_compare(int count, char** arguments) {
    compare_options options = {.scene = {.reference_seconds = 300, .reference_noise = 0.25}};
    cli_compare_request* scene = &options.scene;
    const cli_option table[] = {
        {"output", 'o', CLI_TEXT, "DIR", "the folder to write to; made if it is missing", &options.folder, 0, 0, NULL},
        {"methods", 0, CLI_TEXT, "NAME,...", "what to render the scene with (default: all, as far as they apply)",
         &scene->methods, 0, 0, NULL},
        {"reference", 0, CLI_TEXT, "FILE", "the true image (default: path, rendered for longer)", &scene->reference, 0,
         0, NULL},
        {"spp", 0, CLI_INT, "N", "samples per pixel (default: what the scene says)", &scene->spp, 1, SPP_MAX,
         &scene->spp_given},
        {"reference-noise", 0, CLI_REAL, "F",
         "the reference's noise, as a fraction of the smallest difference (default 0.25)", &scene->reference_noise,
         1e-3, 10, &options.noise_given},
        {"reference-time", 0, CLI_REAL, "SECONDS", "what a run spends on the reference at most (default 300)",
         &scene->reference_seconds, 1e-3, 1e7, &options.seconds_given},
        {"reference-spp", 0, CLI_INT, "N", "samples of the reference at most, of all runs (default: no bound)",
         &scene->reference_spp, 1, SPP_MAX, &scene->reference_spp_given},
        {"size", 0, CLI_SIZE, "WxH", "pixels (default: the reference's or what the scene says)", scene->size, 0, 0,
         NULL},
        {"define", 'D', CLI_LIST, "KEY=VALUE", "change the scene: -D media[0].g=0.5 (again for more)",
         &options.overrides, 0, 0, NULL},
        {"exposure", 0, CLI_REAL, "STOPS", "of what is shown (default: the camera's, or 0)", &options.exposure, -64, 64,
         &options.exposure_given},
    };
    const cli_syntax syntax = {
        "compare",
        "SCENE -o DIR [--methods NAME,...] | REFERENCE.exr IMAGE.exr... -o DIR",
        "Compares methods, or finished images, with a reference.",
        "Methods that are not made for the scene are left out, and it is said why. The reference is path-traced until\n"
        "its own noise is a quarter of the smallest difference of the other methods (among paths alone: 16 times as\n"
        "many samples), or until time or samples are used up. DIR/reference.exr.state keeps it: the same command goes\n"
        "on from there. Its seed is its own, one more than the others'.\n\n"
        "Writes report.html (a page by itself: any two images with a slider or flipped, exposure, false colours,\n"
        "a magnifier, error against time, stages), errors.json and table.md (as 'tyndall diff' measures, and times),\n"
        "side.png and view_NAME.png (all at one exposure), and heat_NAME.png (red where brighter than the reference,\n"
        "blue where darker, full at 100 percent of it or of a tenth of its mean, whichever is more); of scenes also\n"
        "the images.",
        table,
        sizeof table / sizeof table[0],
        1,
        CLI_POSITIONAL_MAX,
        NULL};
    cli_arguments given;
    int status = cli_parse(&syntax, count, arguments, &given);
    if (status == CLI_GO) status = check_options(&given, &options);
    cli_session session;
    if (status == CLI_GO) status = cli_session_open(&session, "compare", &given.common);
    if (status == CLI_GO) status = cli_ranks_open(&session);
    if (status != CLI_GO) return status;
    const char* path = is_image(given.positional[0]) ? NULL : given.positional[0];
    return cli_ranks_helps(&session) ? cli_help_paths(&session, path, &options.overrides, false)
                                     : run_comparison(&session, &given, &options);
}
