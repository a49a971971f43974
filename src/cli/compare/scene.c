/* A scene, rendered by methods. */
#include "cli/compare/scene.h"
#include "cli/compare/command_line.h"
#include "cli/compare/files.h"
#include "cli/compare/measure.h"
#include "cli/text.h"

#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

bool cli_keep_state(void* user, const void* state, size_t size) {
    cli_kept_state* kept = user;
    if (kept->size != size) {
        free(kept->bytes);
        kept->bytes = malloc(size);
        kept->size = kept->bytes != NULL ? size : 0;
    }
    if (kept->bytes != NULL) memcpy(kept->bytes, state, size);
    return kept->checkpoint != NULL ? cli_checkpoint_write(kept->checkpoint, state, size) : true;
}

/* ---- which methods ---- */

/* But for auto, which is one of the others. */
static int name_all_methods(const cli_method* out[CLI_COMPARE_MAX]) {
    int count = 0;
    for (int i = 0; cli_method_at(i) != NULL; ++i)
        if (strcmp(cli_method_at(i)->name, "auto") != 0) out[count++] = cli_method_at(i);
    return count;
}

int cli_name_methods(const char* words, const cli_method* out[CLI_COMPARE_MAX]) {
    if (words == NULL || strcmp(words, "all") == 0) return name_all_methods(out);
    int count = 0;
    for (const char* rest = words; rest != NULL; ++count) {
        char word[32];
        const size_t length = strcspn(rest, ",");
        snprintf(word, sizeof word, "%.*s", (int)(length < sizeof word ? length : sizeof word - 1), rest);
        rest = rest[length] == ',' ? rest + length + 1 : NULL;
        const cli_method* method = cli_find_method("compare", word);
        if (method != NULL && count == CLI_COMPARE_MAX)
            cli_usage_error("compare", "more than %d methods", CLI_COMPARE_MAX);
        if (method == NULL || count == CLI_COMPARE_MAX) return -1;
        out[count] = method;
    }
    return count;
}

static void skip(cli_session* session, cli_comparison* comparison, const cli_method* method) {
    cli_skipped* skipped = &comparison->skipped[comparison->skipped_count++];
    const char* reason = ty_take_error(session->context);
    const size_t length = strlen(method->name);
    if (strncmp(reason, method->name, length) == 0 && strncmp(reason + length, ": ", 2) == 0) reason += length + 2;
    skipped->name = method->name;
    snprintf(skipped->reason, sizeof skipped->reason, "%s", reason);
    if (session->common.quiet) return;
    char line[CLI_COMPARE_REASON + 64];
    snprintf(line, sizeof line, "%s is left out: %s", method->name, skipped->reason);
    cli_progress_clear(&session->progress);
    cli_print_message(line);
}

/* Whether what a method said of a scene means that it is not made for it. */
static bool does_not_apply(const cli_method* method, ty_result result) {
    return method != &cli_method_path &&
           (result == TY_ERROR_ARGUMENT || result == TY_ERROR_INPUT || result == TY_ERROR_UNSUPPORTED);
}

static int fail_without_methods(const cli_comparison* comparison) {
    const cli_skipped* first = &comparison->skipped[0];
    return cli_fail(CLI_USAGE, "%s: no method applies; %s: %s", comparison->subject, first->name, first->reason);
}

/* Takes out those that are not made for the scene, before anything takes its time. CLI_GO, or an exit status. */
static int choose_methods(cli_session* session, cli_comparison* comparison, const ty_scene* scene,
                          const cli_method** methods, int* count) {
    int kept = 0;
    for (int i = 0; i < *count; ++i) {
        const ty_result result = methods[i]->check != NULL ? methods[i]->check(scene) : TY_OK;
        if (result == TY_OK)
            methods[kept++] = methods[i];
        else if (does_not_apply(methods[i], result))
            skip(session, comparison, methods[i]);
        else
            return cli_fail_reading(session, result);
    }
    *count = kept;
    return kept > 0 ? CLI_GO : fail_without_methods(comparison);
}

/* ---- names and files ---- */

static bool name_taken(const cli_comparison* comparison, const char* name) {
    for (int i = 0; i < comparison->count; ++i)
        if (strcmp(comparison->entries[i].name, name) == 0) return true;
    return strcmp(name, "reference") == 0;
}

void cli_choose_name(const cli_comparison* comparison, const char* source, char out[CLI_COMPARE_NAME]) {
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

cli_report cli_begin_report(const ty_scene* scene, const cli_method* method, uint64_t seed) {
    cli_report report = {.method = method->name, .seed = seed, .fov_y = ty_scene_camera(scene).fov_y, .complete = true};
    snprintf(report.scene, sizeof report.scene, "%016" PRIx64, ty_scene_hash(scene));
    return report;
}

int cli_keep_rendering(cli_session* session, const cli_comparison* comparison, const cli_report* report,
                       cli_compared* entry) {
    entry->source = report->method;
    entry->seconds = report->path.seconds;
    entry->own_seconds = report->own_seconds;
    entry->spp = report->path.spp;
    entry->stage_count = cli_report_stages(report, entry->stages);
    free(entry->command);
    entry->command = cli_render_command(comparison, entry, report->seed);
    char* path = cli_comparison_path(comparison->folder, "", entry->name, ".exr");
    if (path == NULL) return CLI_FAILED;
    ty_result result = cli_report_metadata(entry->image, report);
    if (result == TY_OK) result = ty_image_write_exr(session->context, entry->image, path);
    free(path);
    return result == TY_OK ? CLI_GO : cli_fail_running(session, result);
}

/* ---- rendering ---- */

/* Paths, with images kept at a quarter of the samples, a sixteenth and so on: for error against time. The image is that
 * of one render, bit for bit. */
static ty_result render_paths(cli_session* session, const ty_scene* scene, const cli_request* request,
                              cli_compared* entry, cli_report* report) {
    cli_kept_state kept = {0};
    ty_path_def def = cli_path_def(session, scene, request);
    def.state = cli_keep_state;
    def.state_user = &kept;
    def.state_seconds = 1e9; /* only at the end */
    int steps = 0;
    while (steps < CLI_EARLIER_MAX && request->spp >> 2 * (steps + 1) > 0) ++steps;
    ty_result result = TY_OK;
    for (; steps >= 0 && result == TY_OK; --steps) {
        ty_image* image = NULL;
        def.spp = request->spp >> 2 * steps;
        def.resume = kept.bytes;
        def.resume_size = kept.size;
        result = ty_path_render(scene, &def, &image, &report->path);
        if (result != TY_OK)
            ty_image_destroy(image);
        else if (steps == 0)
            entry->image = image;
        else
            entry->earlier[entry->earlier_count++] =
                (cli_earlier){.spp = report->path.spp, .seconds = report->path.seconds, .image = image};
    }
    report->own_seconds = report->path.seconds;
    free(kept.bytes);
    return result;
}

static int render_method(cli_session* session, cli_comparison* comparison, const cli_method* method,
                         const ty_scene* scene, const cli_request* request) {
    cli_compared* entry = &comparison->entries[comparison->count];
    cli_report report = cli_begin_report(scene, method, request->seed);
    cli_choose_name(comparison, method->name, entry->name);
    ty_image* image = NULL;
    const ty_result result = method == &cli_method_path ? render_paths(session, scene, request, entry, &report)
                                                        : method->render(session, scene, request, &image, &report);
    if (does_not_apply(method, result)) {
        skip(session, comparison, method);
        return CLI_GO;
    }
    if (image != NULL) entry->image = image;
    ++comparison->count;
    if (result != TY_OK) return cli_fail_running(session, result);
    return cli_keep_rendering(session, comparison, &report, entry);
}

int cli_render_methods(cli_session* session, cli_comparison* comparison, const ty_scene* scene,
                       const cli_compare_request* options, const cli_request* request) {
    const cli_method* methods[CLI_COMPARE_MAX];
    int count = cli_name_methods(options->methods, methods);
    if (count < 0) return CLI_USAGE;
    int status = choose_methods(session, comparison, scene, methods, &count);
    if (status == CLI_GO) status = cli_make_folder("compare", comparison->folder);
    for (int i = 0; i < count && status == CLI_GO; ++i)
        status = render_method(session, comparison, methods[i], scene, request);
    if (status == CLI_GO && comparison->count == 0) status = fail_without_methods(comparison);
    return status;
}

static cli_request make_request(const cli_session* session, const ty_scene* scene, const cli_compare_request* options) {
    const ty_render_settings settings = ty_scene_render_settings(scene);
    return (cli_request){
        .spp = options->spp_given ? options->spp : settings.spp,
        .seed = session->common.seed_given ? session->common.seed : settings.seed,
        .width = options->size[0],
        .height = options->size[1],
    };
}

/* A reference from a file; all other images get its size. */
static int read_reference(cli_session* session, cli_comparison* comparison, const char* path, cli_request* request) {
    const int status = cli_read_compared(session, path, &comparison->reference);
    if (status != CLI_GO) return status;
    comparison->reference.noise = cli_measure_noise(comparison->reference.image, comparison->reference.image);
    if (request->width > 0) return CLI_GO;
    int32_t frame[4];
    ty_image_get_frame(comparison->reference.image, frame);
    request->width = frame[2];
    request->height = frame[3];
    return CLI_GO;
}

int cli_compare_scene(cli_session* session, cli_comparison* comparison, const ty_scene* scene,
                      const cli_compare_request* options) {
    cli_request request = make_request(session, scene, options);
    snprintf(comparison->reference.name, CLI_COMPARE_NAME, "reference");
    snprintf(comparison->hash, sizeof comparison->hash, "%016" PRIx64, ty_scene_hash(scene));
    int status = CLI_GO;
    if (options->reference != NULL) status = read_reference(session, comparison, options->reference, &request);
    if (status == CLI_GO) status = cli_render_methods(session, comparison, scene, options, &request);
    if (status == CLI_GO && options->reference == NULL)
        return cli_refine_reference(session, comparison, scene, options, &request);
    for (int i = 0; i < comparison->count && status == CLI_GO; ++i)
        status = cli_measure_entry(session, comparison, &comparison->entries[i]);
    return status;
}
