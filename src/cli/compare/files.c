/* Output files of `tyndall compare`. */
#define _GNU_SOURCE
#include "cli/compare/files.h"
#include "cli/compare/page.h"
#include "cli/images/difference.h"
#include "cli/images/side_by_side.h"
#include "cli/text/text_file.h"

#include <stdlib.h>

char* cli_comparison_path(const char* folder, const char* prefix, const char* name, const char* extension) {
    char* path = NULL;
    if (asprintf(&path, "%s/%s%s%s", folder, prefix, name, extension) >= 0) return path;
    cli_fail(CLI_FAILED, "not enough memory");
    return NULL;
}

static ty_result print_errors(ty_context* context, FILE* file, const void* user) {
    (void)context;
    json_writer json = json_begin(file);
    json_open_object(&json, NULL);
    json_text(&json, "version", ty_version());
    cli_comparison_json(&json, user);
    cli_comparison_scene_json(&json, user);
    json_close_object(&json);
    return TY_OK;
}

static int write_text(cli_session* session, const cli_comparison* comparison, const char* name, cli_print_fn print) {
    char* path = cli_comparison_path(comparison->folder, "", name, "");
    if (path == NULL) return CLI_FAILED;
    const ty_result result = cli_write_text_file(session->context, path, print, comparison);
    free(path);
    return result == TY_OK ? CLI_DONE : cli_fail_running(session, result);
}

static int write_heat_maps(cli_session* session, const cli_comparison* comparison) {
    int status = CLI_DONE;
    for (int i = 0; i < comparison->count && status == CLI_DONE; ++i) {
        const cli_compared* entry = &comparison->entries[i];
        char* path = cli_comparison_path(comparison->folder, "heat_", entry->name, ".png");
        if (path == NULL) return CLI_FAILED;
        const ty_result result = cli_write_heat_map(session->context, entry->image, comparison->reference.image, path);
        free(path);
        if (result != TY_OK) status = cli_fail_running(session, result);
    }
    return status;
}

/* A PNG view of an image at the common exposure. */
static int write_view(cli_session* session, const cli_comparison* comparison, const cli_compared* entry) {
    char* path = cli_comparison_path(comparison->folder, "view_", entry->name, ".png");
    if (path == NULL) return CLI_FAILED;
    const ty_result result =
        ty_image_write_png(session->context, entry->image, comparison->exposure, TY_TONE_FILMIC, path);
    free(path);
    return result == TY_OK ? CLI_DONE : cli_fail_running(session, result);
}

static int write_views(cli_session* session, const cli_comparison* comparison) {
    int status = write_view(session, comparison, &comparison->reference);
    for (int i = 0; i < comparison->count && status == CLI_DONE; ++i)
        status = write_view(session, comparison, &comparison->entries[i]);
    return status;
}

static void make_label(const cli_compared* entry, char* out, size_t size) {
    snprintf(out, size, "%s %.3g%%", entry->name, 100 * entry->difference.relative_rmse[3]);
}

static int write_side_by_side(cli_session* session, const cli_comparison* comparison) {
    enum { LABEL_SIZE = CLI_COMPARE_NAME + 24 };
    const size_t count = (size_t)comparison->count + 1;
    char* path = cli_comparison_path(comparison->folder, "", "side", ".png");
    if (path == NULL) return CLI_FAILED;
    cli_panel* panels = calloc(count, sizeof *panels);
    char* labels = calloc(count, LABEL_SIZE);
    ty_result result = TY_ERROR_MEMORY;
    if (panels != NULL && labels != NULL) {
        panels[0] = (cli_panel){comparison->reference.image, "reference"};
        for (int i = 0; i < comparison->count; ++i) {
            char* label = labels + (size_t)i * LABEL_SIZE;
            make_label(&comparison->entries[i], label, LABEL_SIZE);
            panels[i + 1] = (cli_panel){comparison->entries[i].image, label};
        }
        result = cli_write_side_by_side(session->context, panels, (int)count, comparison->exposure, path);
    }
    free(labels);
    free(panels);
    free(path);
    return result == TY_OK ? CLI_DONE : cli_fail_running(session, result);
}

int cli_write_comparison(cli_session* session, const cli_comparison* comparison) {
    int status = write_heat_maps(session, comparison);
    if (status == CLI_DONE) status = write_views(session, comparison);
    if (status == CLI_DONE) status = write_side_by_side(session, comparison);
    if (status == CLI_DONE) status = write_text(session, comparison, "report.html", cli_print_comparison_page);
    if (status == CLI_DONE) status = write_text(session, comparison, "table.md", cli_print_comparison_table);
    if (status == CLI_DONE) status = write_text(session, comparison, "errors.json", print_errors);
    return status;
}
