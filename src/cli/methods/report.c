/* Measurements of a rendering, in --stats and in an image's metadata. */
#include "cli/methods/report.h"
#include "cli/session/metadata.h"

#include <inttypes.h>
#include <string.h>

/* ---- Stats of a method ---- */

static double stat_number(const ty_stat* stat, const char* field, int32_t element) {
    switch (stat->type) {
    case TY_STAT_INT: return ((const int32_t*)field)[element];
    case TY_STAT_LONG: return (double)((const int64_t*)field)[element];
    case TY_STAT_NUMBER: return ((const double*)field)[element];
    default: return 0;
    }
}

static void write_lattices(json_writer* json, const ty_stat* stat, const char* stats) {
    const int32_t* size = (const int32_t*)(stats + stat->offset);
    const double* cell = (const double*)(stats + stat->second_offset);
    json_open_array(json, stat->name);
    for (int32_t i = 0; i < stat->count && size[3 * i] > 0; ++i) {
        json_open_object(json, NULL);
        json_numbers(json, "size", (const double[]){size[3 * i], size[3 * i + 1], size[3 * i + 2]}, 3);
        json_number(json, "cell", cell[i]);
        json_close_object(json);
    }
    json_close_array(json);
}

static void write_stat(json_writer* json, const ty_stat* stat, const char* stats) {
    enum { ELEMENTS_MAX = 8 };
    const char* field = stats + stat->offset;
    double values[ELEMENTS_MAX];
    switch (stat->type) {
    case TY_STAT_BOOL: json_bool(json, stat->name, *(const bool*)field); return;
    case TY_STAT_TEXT: json_text(json, stat->name, *(const char* const*)field); return;
    case TY_STAT_LATTICES: write_lattices(json, stat, stats); return;
    default: break;
    }
    for (int32_t i = 0; i < stat->count && i < ELEMENTS_MAX; ++i) values[i] = stat_number(stat, field, i);
    if (stat->count > 0)
        json_numbers(json, stat->name, values, stat->count);
    else if (stat->type == TY_STAT_NUMBER)
        json_number(json, stat->name, *(const double*)field);
    else
        json_int(json, stat->name, stat->type == TY_STAT_LONG ? *(const int64_t*)field : *(const int32_t*)field);
}

static void write_own_stats(json_writer* json, const cli_report* report) {
    const ty_method* method = report->ran;
    if (method == NULL || method->stat_count == 0) return;
    json_open_object(json, method->options->name);
    for (int32_t i = 0; i < method->stat_count; ++i) write_stat(json, &method->stats[i], report->run.stats);
    json_close_object(json);
}

/* ---- Stages ---- */

/* The stages of the method itself: "march" of the stat march_seconds. */
static int own_stages(const cli_report* report, cli_stage out[CLI_STAGES_MAX]) {
    static const char ending[] = "_seconds";
    const ty_method* method = report->ran;
    int count = 0;
    for (int32_t i = 0; method != NULL && i < method->stat_count && count < CLI_STAGES_MAX; ++i) {
        const ty_stat* stat = &method->stats[i];
        if (!stat->stage) continue;
        snprintf(out[count].name, sizeof out[count].name, "%.*s", (int)(strlen(stat->name) - (sizeof ending - 1)),
                 stat->name);
        out[count++].seconds = stat_number(stat, report->run.stats + stat->offset, 0);
    }
    return count;
}

int cli_report_stages(const cli_report* report, cli_stage out[CLI_STAGES_MAX]) {
    cli_stage own[CLI_STAGES_MAX];
    const int own_count = own_stages(report, own);
    int count = 0;
    const double seconds = report->run.path.seconds;
    double left = seconds;
    const double paths = own_count == 0 ? seconds : seconds - report->run.own_seconds;
    if (paths > 0) {
        snprintf(out[count].name, sizeof out[count].name, "%s", own_count == 0 ? "paths" : "surfaces");
        out[count++].seconds = paths;
        left -= paths;
    }
    for (int i = 0; i < own_count && count < CLI_STAGES_MAX - 1; ++i) {
        left -= own[i].seconds;
        if (own[i].seconds > 0) out[count++] = own[i];
    }
    if (left > 0.005 * seconds) out[count++] = (cli_stage){"other", left};
    return count;
}

/* ---- Reports ---- */

/* Two digits at most, because no more are known. */
void cli_expectation_text(const cli_report* report, char* out, size_t size) {
    const double percent = 100 * report->expected_error;
    snprintf(out, size, "about %.*f %%, %.*g s", percent < 1 ? 1 : 0, percent, report->expected_seconds < 10 ? 1 : 2,
             report->expected_seconds);
}

void cli_report_stats(json_writer* json, const void* user) {
    const cli_report* report = user;
    json_text(json, "method", report->method);
    if (report->choice[0] != '\0') {
        json_text(json, "choice", report->choice);
        json_number(json, "choice_seconds", report->choice_seconds);
    }
    if (report->expected_seconds > 0) {
        json_number(json, "expected_error", report->expected_error);
        json_number(json, "expected_seconds", report->expected_seconds);
    }
    json_text(json, "scene", report->scene);
    json_int(json, "scene_bytes", (int64_t)report->scene_bytes);
    json_int(json, "width", report->width);
    json_int(json, "height", report->height);
    json_unsigned(json, "seed", report->seed);
    json_bool(json, "resumed", report->resumed);
    json_bool(json, "complete", report->complete);
    json_number(json, "spp", report->run.path.spp);
    json_unsigned(json, "paths", report->run.path.paths);
    json_unsigned(json, "vertices", report->run.path.vertices);
    json_number(json, "error", report->run.path.error);
    json_number(json, "error_pixels", report->run.path.error_pixels);
    json_text(json, "guide", report->run.path.guide == TY_PATH_GUIDE_DOM ? "dom" : "none");
    json_text(json, "isa", report->run.path.isa == NULL ? "" : report->run.path.isa);
    write_own_stats(json, report);
    json_number(json, "load_seconds", report->load_seconds);
    json_number(json, "render_seconds", report->run.path.seconds);
    json_number(json, "render_cpu_seconds", report->run.path.cpu_seconds);
}

ty_result cli_report_metadata(ty_image* image, const cli_report* report) {
    char seed[24];
    snprintf(seed, sizeof seed, "%" PRIu64, report->seed);
    const struct {
        const char *key, *value;
    } texts[] = {
        {"tyndall.version", ty_version()},
        {"tyndall.method", report->method},
        {"tyndall.scene", report->scene},
        {"tyndall.seed", seed}, /* as a string, because a double does not hold 64 bits */
    };
    const struct {
        const char* key;
        double value;
    } numbers[] = {
        {"tyndall.spp", report->run.path.spp},
        {"tyndall.seconds", report->run.path.seconds},
        {"tyndall.own_seconds", report->run.own_seconds},
        {"tyndall.error", report->run.path.error},
        {"tyndall.error_pixels", report->run.path.error_pixels},
        {"tyndall.complete", report->complete ? 1 : 0},
    };
    ty_result result = TY_OK;
    for (size_t i = 0; result == TY_OK && i < sizeof texts / sizeof texts[0]; ++i)
        result = ty_image_set_text(image, texts[i].key, texts[i].value);
    for (size_t i = 0; result == TY_OK && i < sizeof numbers / sizeof numbers[0]; ++i)
        result = ty_image_set_number(image, numbers[i].key, numbers[i].value);
    if (result == TY_OK && report->choice[0] != '\0')
        result = ty_image_set_text(image, "tyndall.choice", report->choice);
    if (result == TY_OK && report->expected_seconds > 0)
        result = ty_image_set_number(image, "tyndall.expected_error", report->expected_error);
    if (result == TY_OK && report->expected_seconds > 0)
        result = ty_image_set_number(image, "tyndall.expected_seconds", report->expected_seconds);
    if (result == TY_OK && report->fov_y > 0) result = ty_image_set_number(image, cli_fov_key, report->fov_y);
    return result;
}
