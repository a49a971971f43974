/* tyndall compare: methods, or finished images, against a reference. */
#include "cli/commands.h"
#include "cli/compare_files.h"
#include "cli/metadata.h"
#include "cli/methods.h"
#include "cli/report.h"

#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

enum { SPP_MAX = 1 << 24, IMAGES_MAX = CLI_POSITIONAL_MAX, REFERENCE_FACTOR = 16 };

typedef struct compare_options {
    const char *folder, *methods, *reference;
    int32_t spp, reference_spp, size[2];
    double exposure;
    bool spp_given, reference_spp_given, exposure_given;
    cli_list overrides;
} compare_options;

/* ---- names ---- */

static bool name_taken(const cli_comparison* comparison, const char* name) {
    for (int i = 0; i < comparison->count; ++i)
        if (strcmp(comparison->entries[i].name, name) == 0) return true;
    return strcmp(name, "reference") == 0;
}

/* A name of its own for the next entry, from a method or from a path without folder and extension. */
static void choose_name(const cli_comparison* comparison, const char* source, char out[CLI_COMPARE_NAME]) {
    char base[CLI_COMPARE_NAME - 16];
    const char* slash = strrchr(source, '/');
    snprintf(base, sizeof base, "%.*s", (int)sizeof base - 1, slash != NULL ? slash + 1 : source);
    char* dot = strrchr(base, '.');
    if (dot != NULL && dot != base) *dot = '\0';
    for (char* c = base; *c != '\0'; ++c)
        if (strchr("ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789-_.", *c) == NULL) *c = '_';
    snprintf(out, CLI_COMPARE_NAME, "%s", base);
    for (int n = 2; name_taken(comparison, out); ++n) snprintf(out, CLI_COMPARE_NAME, "%s-%d", base, n);
}

/* ---- images ---- */

static int read_image(cli_session* session, const char* path, cli_compared* out) {
    const ty_result result = ty_image_read(session->context, path, &out->image);
    if (result != TY_OK) return cli_fail_reading(session, result);
    out->source = path;
    out->seconds = out->own_seconds = out->spp = -1; /* unknown */
    cli_metadata_number(out->image, "tyndall.seconds", &out->seconds);
    cli_metadata_number(out->image, "tyndall.own_seconds", &out->own_seconds);
    cli_metadata_number(out->image, "tyndall.spp", &out->spp);
    return CLI_GO;
}

static int compare_entry(cli_session* session, const cli_comparison* comparison, cli_compared* entry) {
    const ty_result result =
        ty_image_compare(session->context, entry->image, comparison->reference.image, 1, &entry->difference);
    if (result == TY_OK) return CLI_GO;
    cli_progress_clear(&session->progress);
    return cli_fail(CLI_USAGE, "%s and %s: %s", entry->source, comparison->reference.source,
                    ty_last_error(session->context));
}

static int compare_images(cli_session* session, cli_comparison* comparison, const cli_arguments* given) {
    snprintf(comparison->reference.name, CLI_COMPARE_NAME, "reference");
    int status = read_image(session, given->positional[0], &comparison->reference);
    for (int i = 1; i < given->positional_count && status == CLI_GO; ++i) {
        cli_compared* entry = &comparison->entries[comparison->count];
        choose_name(comparison, given->positional[i], entry->name);
        status = read_image(session, given->positional[i], entry);
        if (status != CLI_GO) break;
        ++comparison->count;
        status = compare_entry(session, comparison, entry);
    }
    return status == CLI_GO ? cli_make_folder("compare", comparison->folder) : status;
}

/* ---- scenes ---- */

static int write_rendering(cli_session* session, const cli_comparison* comparison, const cli_compared* entry,
                           const cli_report* report) {
    char* path = cli_comparison_path(comparison->folder, "", entry->name, ".exr");
    if (path == NULL) return CLI_FAILED;
    ty_result result = cli_report_metadata(entry->image, report);
    if (result == TY_OK) result = ty_image_write_exr(session->context, entry->image, path);
    free(path);
    return result == TY_OK ? CLI_GO : cli_fail_running(session, result);
}

/* Renders, and writes the image to the folder. */
static int render_entry(cli_session* session, const cli_comparison* comparison, const cli_method* method,
                        const ty_scene* scene, const cli_request* request, cli_compared* entry) {
    cli_report report = {
        .method = method->name, .seed = request->seed, .fov_y = ty_scene_camera(scene).fov_y, .complete = true};
    snprintf(report.scene, sizeof report.scene, "%016" PRIx64, ty_scene_hash(scene));
    const ty_result result = method->render(session, scene, request, &entry->image, &report);
    if (result != TY_OK) return cli_fail_running(session, result);
    entry->source = method->name;
    entry->seconds = report.path.seconds;
    entry->own_seconds = report.own_seconds;
    entry->spp = report.path.spp;
    return write_rendering(session, comparison, entry, &report);
}

static cli_request make_request(const cli_session* session, const ty_scene* scene, const compare_options* options) {
    const ty_render_settings settings = ty_scene_render_settings(scene);
    return (cli_request){
        .spp = options->spp_given ? options->spp : settings.spp,
        .seed = session->common.seed_given ? session->common.seed : settings.seed,
        .width = options->size[0],
        .height = options->size[1],
    };
}

/* Reads the reference or renders it, with a seed of its own; all other images get its size. The folder is made once
 * nothing that goes in can be wrong any more. */
static int get_reference(cli_session* session, cli_comparison* comparison, const ty_scene* scene,
                         const compare_options* options, cli_request* request) {
    cli_compared* reference = &comparison->reference;
    snprintf(reference->name, sizeof reference->name, "reference");
    if (options->reference != NULL) {
        const int status = read_image(session, options->reference, reference);
        if (status != CLI_GO) return status;
        int32_t frame[4];
        ty_image_get_frame(reference->image, frame);
        if (request->width == 0) {
            request->width = frame[2];
            request->height = frame[3];
        }
        return cli_make_folder("compare", options->folder);
    }
    const int status = cli_make_folder("compare", options->folder);
    if (status != CLI_GO) return status;
    cli_request better = *request;
    const int32_t more = request->spp < SPP_MAX / REFERENCE_FACTOR ? REFERENCE_FACTOR * request->spp : SPP_MAX;
    better.spp = options->reference_spp_given ? options->reference_spp : more;
    better.seed = request->seed + 1;
    return render_entry(session, comparison, &cli_method_path, scene, &better, reference);
}

/* The next word of "path,fld" as a method; NULL, after a message, when there is none of that name. */
static const cli_method* next_method(const char** words) {
    char word[32];
    const size_t length = strcspn(*words, ",");
    snprintf(word, sizeof word, "%.*s", (int)(length < sizeof word ? length : sizeof word - 1), *words);
    *words = (*words)[length] == ',' ? *words + length + 1 : NULL;
    return cli_find_method("compare", word);
}

/* Before the reference takes its time. */
static int check_methods(cli_session* session, const ty_scene* scene, const compare_options* options,
                         const cli_request* request) {
    int status = CLI_GO;
    for (const char* words = options->methods; words != NULL && status == CLI_GO;)
        status = cli_check_request(session, scene, next_method(&words), request);
    return status;
}

static int compare_methods(cli_session* session, cli_comparison* comparison, const ty_scene* scene,
                           const compare_options* options) {
    cli_request request = make_request(session, scene, options);
    int status = check_methods(session, scene, options, &request);
    if (status == CLI_GO) status = get_reference(session, comparison, scene, options, &request);
    for (const char* words = options->methods; words != NULL && status == CLI_GO;) {
        const cli_method* method = next_method(&words);
        if (method == NULL) return CLI_USAGE;
        cli_compared* entry = &comparison->entries[comparison->count];
        choose_name(comparison, method->name, entry->name);
        status = render_entry(session, comparison, method, scene, &request, entry);
        if (status != CLI_GO) break;
        ++comparison->count;
        status = compare_entry(session, comparison, entry);
    }
    return status;
}

static int load_and_compare(cli_session* session, cli_comparison* comparison, const char* path,
                            const compare_options* options) {
    ty_scene* scene = NULL;
    const ty_result result =
        ty_scene_load(session->context, path, options->overrides.items, options->overrides.count, &scene);
    if (result != TY_OK) return cli_fail_reading(session, result);
    comparison->subject = path;
    if (!options->exposure_given) comparison->exposure = ty_scene_camera(scene).exposure;
    const int status = compare_methods(session, comparison, scene, options);
    ty_scene_destroy(scene);
    return status;
}

/* ---- the command ---- */

static void print_result(const cli_comparison* comparison) {
    printf("%-24s %14s %14s %14s %14s\n", "", "mean ratio", "RMSE", "relative RMSE", "relMSE");
    for (int i = 0; i < comparison->count; ++i) {
        const ty_difference* d = &comparison->entries[i].difference;
        printf("%-24s %14.8g %14.6g %14.6g %14.6g\n", comparison->entries[i].name, d->mean_ratio[3], d->rmse[3],
               d->relative_rmse[3], d->rel_mse[3]);
    }
    printf("wrote %s/report.html, errors.json, table.md, side.png and heat maps\n", comparison->folder);
}

static bool is_image(const char* path) {
    static const char* const extensions[] = {".exr", ".hdr", ".png", ".jpg", ".jpeg"};
    for (size_t i = 0; i < sizeof extensions / sizeof *extensions; ++i)
        if (cli_has_extension(path, extensions[i])) return true;
    return false;
}

static int run_comparison(cli_session* session, const cli_arguments* given, const compare_options* options) {
    cli_comparison comparison = {.folder = options->folder, .exposure = options->exposure};
    comparison.entries = calloc(IMAGES_MAX, sizeof *comparison.entries);
    if (comparison.entries == NULL) return cli_session_close(session, cli_fail(CLI_FAILED, "not enough memory"));
    int status = is_image(given->positional[0]) ? compare_images(session, &comparison, given)
                                                : load_and_compare(session, &comparison, given->positional[0], options);
    cli_progress_clear(&session->progress);
    if (status == CLI_GO) status = cli_write_comparison(session, &comparison);
    if (status == CLI_DONE && !session->common.quiet) print_result(&comparison);
    ty_image_destroy(comparison.reference.image);
    for (int i = 0; i < IMAGES_MAX; ++i) ty_image_destroy(comparison.entries[i].image);
    session->stats = cli_comparison_json;
    session->stats_user = &comparison;
    status = cli_session_close(session, status);
    free(comparison.entries);
    return status;
}

/* What can be known to be wrong before any work. */
static int check_options(const cli_arguments* given, const compare_options* options) {
    const bool images = is_image(given->positional[0]);
    if (options->folder == NULL) return cli_usage_error("compare", "where to? Give -o DIR");
    if (images && given->positional_count < 2)
        return cli_usage_error("compare", "what to compare with %s? Give images", given->positional[0]);
    if (images && (options->methods != NULL || options->reference != NULL || options->spp_given ||
                   options->reference_spp_given || options->size[0] > 0 || options->overrides.count > 0))
        return cli_usage_error("compare", "only --exposure goes with finished images, and %s is one",
                               given->positional[0]);
    if (!images && given->positional_count > 1)
        return cli_usage_error("compare", "'%s' is one argument too many after a scene", given->positional[1]);
    if (!images && options->methods == NULL)
        return cli_usage_error("compare", "which methods? Give --methods NAME,...");
    if (options->reference != NULL && options->reference_spp_given)
        return cli_usage_error("compare", "--reference-spp is for rendering a reference; do not give --reference");
    int count = 0;
    for (const char* words = options->methods; words != NULL; ++count)
        if (next_method(&words) == NULL) return CLI_USAGE;
    if (count > IMAGES_MAX) return cli_usage_error("compare", "more than %d methods", IMAGES_MAX);
    return CLI_GO;
}

int cli_compare(int count, char** arguments) {
    compare_options options = {0};
    const cli_option table[] = {
        {"output", 'o', CLI_TEXT, "DIR", "the folder to write to; made if it is missing", &options.folder, 0, 0, NULL},
        {"methods", 0, CLI_TEXT, "NAME,...", "what to render the scene with: path, screen, fld, cda, pop, lpv, dom",
         &options.methods, 0, 0, NULL},
        {"reference", 0, CLI_TEXT, "FILE", "the true image (default: path, rendered for longer)", &options.reference, 0,
         0, NULL},
        {"spp", 0, CLI_INT, "N", "samples per pixel (default: what the scene says)", &options.spp, 1, SPP_MAX,
         &options.spp_given},
        {"reference-spp", 0, CLI_INT, "N", "of the reference (default: 16 times as many)", &options.reference_spp, 1,
         SPP_MAX, &options.reference_spp_given},
        {"size", 0, CLI_SIZE, "WxH", "pixels (default: the reference's or what the scene says)", options.size, 0, 0,
         NULL},
        {"define", 'D', CLI_LIST, "KEY=VALUE", "change the scene, as for render", &options.overrides, 0, 0, NULL},
        {"exposure", 0, CLI_REAL, "STOPS", "of what is shown (default: the camera's, or 0)", &options.exposure, -64, 64,
         &options.exposure_given},
    };
    const cli_syntax syntax = {
        "compare",
        "SCENE --methods NAME,... -o DIR | REFERENCE.exr IMAGE.exr... -o DIR",
        "Compares methods, or finished images, with a reference.",
        "Writes report.html (a page by itself, with a slider between the reference and each image), errors.json and\n"
        "table.md (as 'tyndall diff' measures, and times), side.png and view_NAME.png (all at one exposure), and\n"
        "heat_NAME.png (red where brighter than the reference, blue where darker, full at 100 percent of it or of a\n"
        "tenth of its mean, whichever is more); of scenes also the images. A reference that is rendered has a seed of\n"
        "its own: one more than the others'.",
        table,
        sizeof table / sizeof table[0],
        1,
        CLI_POSITIONAL_MAX};
    cli_arguments given;
    int status = cli_parse(&syntax, count, arguments, &given);
    if (status == CLI_GO) status = check_options(&given, &options);
    cli_session session;
    if (status == CLI_GO) status = cli_session_open(&session, "compare", &given.common);
    return status == CLI_GO ? run_comparison(&session, &given, &options) : status;
}
