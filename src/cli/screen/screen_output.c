/* tyndall screen: the output image, messages and reports. */
#include "cli/screen/screen_output.h"

#include "base/constants.h"
#include "cli/session/metadata.h"
#include "cli/text/text.h"

#include <inttypes.h>
#include <math.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

enum { OWN_CHANNELS_MAX = 13 };

/* ---- channels ---- */

/* The computed channels: R, G, B and --aov. */
typedef struct own_channel {
    const char* name;
    float** plane;
} own_channel;

static int list_own_channels(uint32_t aovs, screen_output* output, own_channel own[OWN_CHANNELS_MAX]) {
    const struct {
        uint32_t aov;
        const char* names[3];
        float** planes;
    } groups[] = {
        {0, {"R", "G", "B"}, output->color},
        {SCREEN_ATTENUATED, {"attenuated.R", "attenuated.G", "attenuated.B"}, output->attenuated},
        {SCREEN_SCATTERED, {"scattered.R", "scattered.G", "scattered.B"}, output->scattered},
        {SCREEN_SPREAD, {"spread.R", "spread.G", "spread.B"}, output->spread},
    };
    int count = 0;
    for (size_t g = 0; g < sizeof groups / sizeof groups[0]; ++g)
        for (int c = 0; (groups[g].aov & ~aovs) == 0 && c < 3; ++c)
            own[count++] = (own_channel){groups[g].names[c], &groups[g].planes[c]};
    if ((aovs & SCREEN_DISTANCE) != 0) own[count++] = (own_channel){"distance.Z", &output->distance};
    return count;
}

/* True if a channel of the input is copied to the output: all except the computed ones. */
static bool is_carried(const screen_input* input, int32_t channel, const own_channel* own, int own_count) {
    const float* plane = ty_image_plane_const(input->image, channel);
    if (plane == input->color[0] || plane == input->color[1] || plane == input->color[2]) return false;
    for (int i = 0; i < own_count; ++i)
        if (strcmp(own[i].name, ty_image_channel_name(input->image, channel)) == 0) return false;
    return true;
}

/* The input's render metadata is removed, because it does not describe the output. */
static ty_result carry_metadata(const ty_image* from, ty_image* to) {
    ty_result result = TY_OK;
    for (int32_t i = 0; result == TY_OK && i < ty_image_metadata_count(from); ++i) {
        const char* key = ty_image_metadata_key(from, i);
        double number = 0;
        if (strncmp(key, "tyndall.", 8) == 0) continue;
        result = ty_image_metadata_is_number(from, i) && cli_metadata_number(from, key, &number)
                     ? ty_image_set_number(to, key, number)
                     : ty_image_set_text(to, key, ty_image_get_metadata(from, key));
    }
    return result;
}

int screen_fail_running(cli_session* session, const screen_report* report, int32_t channels_out, ty_result result) {
    const screen_input* input = report->input;
    if (result != TY_ERROR_MEMORY) return cli_fail_running(session, result);
    int32_t channels = channels_out + ty_image_channel_count(input->image);
    if (input->distances != NULL) channels += ty_image_channel_count(input->distances);
    const double images = (double)sizeof(float) * channels * input->width * input->height;
    const size_t work = ty_screen_workspace(session->context, report->def, input->width, input->height);
    char all[24];
    cli_format_bytes(images + (double)work, all);
    cli_progress_clear(&session->progress);
    return cli_fail(CLI_FAILED, "%s: %dx%d pixels need %s in all; %s", input->image_path, input->width, input->height,
                    all, ty_take_error(session->context));
}

/* Creates the image from channel names: computed channels, then copied channels. */
static ty_result create_image(cli_session* session, const screen_input* input, const own_channel* own, int own_count,
                              const char** names, screen_output* out) {
    const int32_t channels = ty_image_channel_count(input->image);
    int32_t count = 0, frame[4];
    for (int i = 0; i < own_count; ++i) names[count++] = own[i].name;
    for (int32_t i = 0; i < channels; ++i)
        if (is_carried(input, i, own, own_count)) names[count++] = ty_image_channel_name(input->image, i);
    out->channels = count;
    ty_result result = ty_image_create(session->context, input->width, input->height, count, names, &out->image);
    if (result != TY_OK) return result;
    for (int i = 0; i < own_count; ++i) *own[i].plane = ty_image_plane(out->image, i);
    const size_t bytes = (size_t)input->width * (size_t)input->height * sizeof(float);
    for (int32_t i = own_count; i < count; ++i)
        memcpy(ty_image_plane(out->image, i),
               ty_image_plane_const(input->image, ty_image_find_channel(input->image, names[i])), bytes);
    ty_image_get_frame(input->image, frame);
    result = ty_image_set_frame(out->image, frame[0], frame[1], frame[2], frame[3]);
    return result == TY_OK ? carry_metadata(input->image, out->image) : result;
}

int screen_create_output(cli_session* session, const screen_report* report, screen_output* out) {
    const screen_input* input = report->input;
    own_channel own[OWN_CHANNELS_MAX];
    *out = (screen_output){0};
    const int own_count = list_own_channels(report->options->aovs, out, own);
    const char** names = calloc((size_t)(own_count + ty_image_channel_count(input->image)), sizeof *names);
    if (names == NULL) return cli_fail(CLI_FAILED, "not enough memory");
    const ty_result result = create_image(session, input, own, own_count, names, out);
    free(names);
    return result == TY_OK ? CLI_GO : screen_fail_running(session, report, out->channels, result);
}

/* ---- messages ---- */

static const char* kind_name(const screen_options* options) {
    static const char* const names[] = {"scatter", "gather", "published", "naive", "reference"};
    return names[options->kind];
}

__attribute__((format(printf, 2, 3))) static void note(cli_session* session, const char* format, ...) {
    char text[1024];
    va_list arguments;
    if (session->common.quiet) return;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    cli_progress_clear(&session->progress);
    cli_print_message(text);
}

static void note_distances(cli_session* session, const screen_report* report) {
    const screen_input* input = report->input;
    const int64_t pixels = (int64_t)input->width * input->height;
    if (input->filled > 0)
        note(session, "%s: %" PRId64 " of %" PRId64 " pixels have no distance; they get one from those around them",
             input->distance_path, input->filled, pixels);
    if (report->stats.missing_depth > 0)
        note(session, "%s: %" PRId64 " of %" PRId64 " pixels have no distance; they count as %.7g m away (--sky)",
             input->distance_path, report->stats.missing_depth, pixels, (double)report->def->missing_depth);
}

static void note_oversized(cli_session* session, const screen_report* report) {
    const ty_screen_stats* stats = &report->stats;
    const double needed = stats->levels + ceil(log2(stats->spread / stats->max_spread));
    /* The pyramid ends at one pixel. */
    const double side = fmax(report->input->width, report->input->height);
    const double max_levels = fmin(TY_SCREEN_LEVELS_MAX, ceil(log2(side)));
    char advice[64] = "the image is too small for more";
    if (needed <= max_levels)
        snprintf(advice, sizeof advice, "--levels %.0f would hold them", needed);
    else if (stats->levels < max_levels)
        snprintf(advice, sizeof advice, "--levels %.0f, the maximum, would hold more", max_levels);
    note(session, "%" PRId64 " pixels spread up to %.3g pixels wide, more than %d levels hold, and are cut to that; %s",
         stats->oversized, stats->spread, stats->levels, advice);
}

void screen_print_notes(cli_session* session, const screen_report* report) {
    const screen_input* input = report->input;
    const ty_screen_stats* stats = &report->stats;
    note_distances(session, report);
    if (stats->nonfinite_fixed > 0)
        note(session, "%s: %" PRId64 " pixels were negative or not finite, and are replaced", input->image_path,
             stats->nonfinite_fixed);
    if (stats->oversized > 0 && stats->levels > 0) note_oversized(session, report);
    if (cli_has_extension(report->options->output, ".png") && ty_image_find_channel(input->image, "A") >= 0)
        note(session, "%s: alpha is left out of a PNG; .exr keeps it", input->image_path);
}

void screen_report_stats(json_writer* json, const void* user) {
    const screen_report* report = user;
    const ty_screen_stats* stats = &report->stats;
    json_text(json, "method", "screen");
    json_text(json, "variant", kind_name(report->options));
    json_int(json, "width", report->input->width);
    json_int(json, "height", report->input->height);
    json_int(json, "levels", stats->levels);
    json_number(json, "spread", stats->spread);
    json_number(json, "max_spread", stats->max_spread);
    json_int(json, "oversized", stats->oversized);
    json_int(json, "nonfinite_fixed", stats->nonfinite_fixed);
    json_int(json, "missing_depth", stats->missing_depth);
    json_int(json, "filled", report->input->filled);
    json_number(json, "bytes", stats->memory_bytes);
    json_text(json, "isa", stats->isa == NULL ? "" : stats->isa);
    json_number(json, "load_seconds", report->load_seconds);
    json_number(json, "screen_seconds", stats->seconds);
    json_numbers(json, "step_seconds", stats->step_seconds, 3);
}

/* ---- metadata and files ---- */

static ty_result set_triple(ty_image* image, const char* key, const float values[3]) {
    char text[64];
    snprintf(text, sizeof text, "%.9g %.9g %.9g", (double)values[0], (double)values[1], (double)values[2]);
    return ty_image_set_text(image, key, text);
}

static ty_result set_texts(ty_image* image, const screen_report* report) {
    const bool gaussian = report->def->spread == TY_SCREEN_SPREAD_GAUSSIAN || report->def->variant != TY_SCREEN_SCATTER;
    const struct {
        const char *key, *value;
    } texts[] = {
        {"tyndall.version", ty_version()},
        {"tyndall.method", "screen"},
        {"tyndall.screen.variant", kind_name(report->options)},
        {"tyndall.screen.spread", gaussian ? "gaussian" : "small-angle"},
        {"tyndall.screen.medium", report->options->medium},
    };
    ty_result result = TY_OK;
    for (size_t i = 0; result == TY_OK && i < sizeof texts / sizeof texts[0]; ++i)
        result = ty_image_set_text(image, texts[i].key, texts[i].value);
    return result;
}

static ty_result set_numbers(ty_image* image, const screen_report* report) {
    const ty_screen_def* def = report->def;
    int32_t frame[4];
    ty_image_get_frame(image, frame);
    const struct {
        const char* key;
        double value;
    } numbers[] = {
        {cli_fov_key, atan(0.5 * frame[3] / def->focal[1]) * (360 / TY_PI_F64)},
        {"tyndall.screen.filter", def->filter},
        {"tyndall.screen.levels", report->stats.levels},
        {"tyndall.screen.missing_depth", (double)def->missing_depth},
        {"tyndall.seconds", report->stats.seconds},
    };
    ty_result result = TY_OK;
    for (size_t i = 0; result == TY_OK && i < sizeof numbers / sizeof numbers[0]; ++i)
        result = ty_image_set_number(image, numbers[i].key, numbers[i].value);
    return result;
}

static ty_result set_metadata(ty_image* image, const screen_report* report) {
    const ty_screen_def* def = report->def;
    ty_result result = set_texts(image, report);
    if (result == TY_OK) result = set_numbers(image, report);
    if (result == TY_OK) result = set_triple(image, "tyndall.screen.sigma_s", def->sigma_s);
    if (result == TY_OK) result = set_triple(image, "tyndall.screen.sigma_a", def->sigma_a);
    if (result == TY_OK) result = set_triple(image, "tyndall.screen.g", def->g);
    if (result == TY_OK) result = set_triple(image, "tyndall.screen.forward", def->forward);
    return result == TY_OK ? set_triple(image, "tyndall.screen.environment", def->environment) : result;
}

ty_tone_curve screen_choose_curve(const screen_options* options, const char* image_path) {
    if (options->curve != 0) return options->curve == 2 ? TY_TONE_FILMIC : TY_TONE_CLIP;
    const bool display_ready = cli_has_extension(image_path, ".png") || cli_has_extension(image_path, ".jpg") ||
                               cli_has_extension(image_path, ".jpeg");
    return display_ready ? TY_TONE_CLIP : TY_TONE_FILMIC;
}

static ty_result write_files(cli_session* session, const screen_report* report, const ty_image* image) {
    const screen_options* options = report->options;
    const char* const paths[] = {options->output, options->png};
    const ty_tone_curve curve = screen_choose_curve(options, report->input->image_path);
    for (int i = 0; i < 2; ++i) {
        if (paths[i] == NULL) continue;
        const ty_result result = cli_has_extension(paths[i], ".png")
                                     ? ty_image_write_png(session->context, image, options->exposure, curve, paths[i])
                                     : ty_image_write_exr(session->context, image, paths[i]);
        if (result != TY_OK) return result;
    }
    return TY_OK;
}

static void print_closing_lines(const screen_report* report) {
    const ty_screen_stats* stats = &report->stats;
    printf("screen (%s): %dx%d, spread up to %.3g pixels", kind_name(report->options), report->input->width,
           report->input->height, stats->spread);
    if (stats->levels > 0) printf(", %d levels", stats->levels);
    printf(", %.1f ms\nwrote %s\n", 1000 * stats->seconds, report->options->output);
    if (report->options->png != NULL) printf("wrote %s\n", report->options->png);
}

int screen_write_output(cli_session* session, const screen_report* report, const screen_output* output) {
    ty_result result = set_metadata(output->image, report);
    if (result == TY_OK) result = write_files(session, report, output->image);
    if (result != TY_OK) return cli_fail_running(session, result);
    if (!session->common.quiet) print_closing_lines(report);
    return CLI_DONE;
}
