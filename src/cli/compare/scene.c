/* Rendering a scene by several methods. */
#include "cli/compare/scene.h"
#include "cli/compare/keep.h"
#include "cli/compare/measure.h"
#include "cli/compare/read.h"
#include "cli/compare/reference.h"
#include "cli/text/text.h"

#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

/* ---- selection of methods ---- */

/* Method auto is excluded, because it runs one of the others. */
static int name_all_methods(const ty_method* out[CLI_COMPARE_MAX]) {
    int count = 0;
    for (int i = 0; ty_methods[i] != NULL; ++i) out[count++] = ty_methods[i];
    return count;
}

int cli_name_methods(const char* words, const ty_method* out[CLI_COMPARE_MAX]) {
    if (words == NULL || strcmp(words, "all") == 0) return name_all_methods(out);
    int count = 0;
    for (const char* rest = words; rest != NULL; ++count) {
        char word[32];
        const size_t length = strcspn(rest, ",");
        snprintf(word, sizeof word, "%.*s", (int)(length < sizeof word ? length : sizeof word - 1), rest);
        rest = rest[length] == ',' ? rest + length + 1 : NULL;
        const ty_method* method = cli_find_method("compare", word);
        if (method != NULL && count == CLI_COMPARE_MAX)
            cli_usage_error("compare", "more than %d methods", CLI_COMPARE_MAX);
        if (method == NULL || count == CLI_COMPARE_MAX) return -1;
        out[count] = method;
    }
    return count;
}

static void skip(cli_session* session, cli_comparison* comparison, const ty_method* method) {
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

/* True if a method's error means that it does not support the scene. */
static bool does_not_apply(const ty_method* method, ty_result result) {
    return method != &ty_method_path &&
           (result == TY_ERROR_ARGUMENT || result == TY_ERROR_INPUT || result == TY_ERROR_UNSUPPORTED);
}

static int fail_without_methods(const cli_comparison* comparison) {
    const cli_skipped* first = &comparison->skipped[0];
    return cli_fail(CLI_USAGE, "%s: no method applies; %s: %s", comparison->subject, first->name, first->reason);
}

/* Removes the methods that do not support the scene, before any rendering. CLI_GO, or an exit status. */
static int choose_methods(cli_session* session, cli_comparison* comparison, const ty_scene* scene,
                          const ty_method** methods, int* count) {
    int supported = 0;
    for (int i = 0; i < *count; ++i) {
        const ty_result result = methods[i]->check != NULL ? methods[i]->check(scene) : TY_OK;
        if (result == TY_OK)
            methods[supported++] = methods[i];
        else if (does_not_apply(methods[i], result))
            skip(session, comparison, methods[i]);
        else
            return cli_fail_reading(session, result);
    }
    *count = supported;
    return supported > 0 ? CLI_GO : fail_without_methods(comparison);
}

/* ---- rendering ---- */

/* Path tracing with intermediate images at 1/4, 1/16, ... of the samples, for error against time. The final image is
 * bit-identical to that of a single render. */
static ty_result render_paths(cli_session* session, const ty_scene* scene, const cli_request* request,
                              cli_compared* entry, cli_report* report) {
    cli_stored_state stored = {0};
    ty_path_def def;
    ty_result result = cli_path_def(session, scene, request, &def);
    def.state = cli_keep_state;
    def.state_user = &stored;
    def.state_seconds = 1e9; /* stored only at the end */
    int steps = 0;
    while (steps < CLI_EARLIER_MAX && request->spp >> 2 * (steps + 1) > 0) ++steps;
    for (; steps >= 0 && result == TY_OK; --steps) {
        ty_image* image = NULL;
        def.spp = request->spp >> 2 * steps;
        def.resume = stored.bytes;
        def.resume_size = stored.size;
        report->run.path = ty_default_path_stats();
        result = ty_path_render(scene, &def, &image, &report->run.path);
        if (result != TY_OK)
            ty_image_destroy(image);
        else if (steps == 0)
            entry->image = image;
        else
            entry->earlier[entry->earlier_count++] =
                (cli_earlier){.spp = report->run.path.spp, .seconds = report->run.path.seconds, .image = image};
    }
    report->run.own_seconds = report->run.path.seconds;
    free(stored.bytes);
    return result;
}

static int render_method(cli_session* session, cli_comparison* comparison, const ty_method* method,
                         const ty_scene* scene, const cli_request* request) {
    cli_compared* entry = &comparison->entries[comparison->count];
    cli_report report = cli_begin_report(scene, method, request->seed);
    cli_choose_name(comparison, method->name, entry->name);
    ty_image* image = NULL;
    const ty_result result = method == &ty_method_path
                                 ? render_paths(session, scene, request, entry, &report)
                                 : cli_render_method(session, scene, method, request, &image, &report);
    if (does_not_apply(method, result)) {
        skip(session, comparison, method);
        return CLI_GO;
    }
    if (image != NULL) entry->image = image;
    ++comparison->count;
    if (result != TY_OK) return cli_fail_running(session, result);
    return cli_keep_rendering(session, comparison, &report, entry);
}

/* Renders the images of all methods, in the order of the list. */
static int render_methods(cli_session* session, cli_comparison* comparison, const ty_scene* scene,
                          const cli_compare_request* options, const cli_request* request) {
    const ty_method* methods[CLI_COMPARE_MAX];
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

/* Reads the reference from a file, whose size all other images get. */
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
    if (status == CLI_GO) status = render_methods(session, comparison, scene, options, &request);
    if (status == CLI_GO && options->reference == NULL)
        return cli_refine_reference(session, comparison, scene, options, &request);
    for (int i = 0; i < comparison->count && status == CLI_GO; ++i)
        status = cli_measure_entry(session, comparison, &comparison->entries[i]);
    return status;
}
