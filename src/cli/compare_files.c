/* What `tyndall compare` writes. */
#define _GNU_SOURCE
#include "cli/compare_files.h"
#include "cli/compare_page.h"
#include "cli/difference.h"
#include "cli/side_by_side.h"
#include "cli/text_file.h"

#include <stdlib.h>
#include <string.h>

char* cli_comparison_path(const char* folder, const char* prefix, const char* name, const char* extension) {
    char* path = NULL;
    if (asprintf(&path, "%s/%s%s%s", folder, prefix, name, extension) >= 0) return path;
    cli_fail(CLI_FAILED, "not enough memory");
    return NULL;
}

static void image_json(json_writer* json, const cli_compared* image) {
    json_text(json, "name", image->name);
    json_text(json, "source", image->source);
    if (image->seconds >= 0) json_number(json, "seconds", image->seconds);
    if (image->own_seconds >= 0) json_number(json, "own_seconds", image->own_seconds);
    if (image->spp >= 0) json_number(json, "spp", image->spp);
}

void cli_comparison_json(json_writer* json, const void* user) {
    const cli_comparison* comparison = user;
    if (comparison->subject != NULL) json_text(json, "scene", comparison->subject);
    json_open_object(json, "reference");
    image_json(json, &comparison->reference);
    json_close_object(json);
    json_open_array(json, "images");
    for (int i = 0; i < comparison->count; ++i) {
        json_open_object(json, NULL);
        image_json(json, &comparison->entries[i]);
        cli_difference_json(json, &comparison->entries[i].difference);
        json_close_object(json);
    }
    json_close_array(json);
}

static ty_result print_errors(ty_context* context, FILE* file, const void* user) {
    (void)context;
    json_writer json = json_begin(file);
    json_open_object(&json, NULL);
    json_text(&json, "version", ty_version());
    cli_comparison_json(&json, user);
    json_close_object(&json);
    return TY_OK;
}

static void write_amount(FILE* file, double amount) {
    if (amount >= 0)
        fprintf(file, " %.4g |", amount);
    else
        fputs(" |", file);
}

static ty_result print_table(ty_context* context, FILE* file, const void* user) {
    (void)context;
    const cli_comparison* comparison = user;
    const cli_compared* reference = &comparison->reference;
    if (comparison->subject != NULL) fprintf(file, "Scene: %s\n\n", comparison->subject);
    fprintf(file, "Reference: %s (%s)", reference->name, reference->source);
    if (reference->spp >= 0) fprintf(file, ", %.6g spp", reference->spp);
    if (reference->seconds >= 0) fprintf(file, ", %.4g s", reference->seconds);
    fprintf(file, "\n\n| image | channel | mean ratio | RMSE | relative RMSE | relMSE | spp | seconds |\n"
                  "|---|---|---|---|---|---|---|---|\n");
    for (int i = 0; i < comparison->count; ++i) {
        const cli_compared* entry = &comparison->entries[i];
        const ty_difference* d = &entry->difference;
        for (int channel = 0; channel < 4; ++channel) {
            fprintf(file, "| %s | %s | %.6g | %.6g | %.6g | %.6g |", entry->name, cli_difference_names[channel],
                    d->mean_ratio[channel], d->rmse[channel], d->relative_rmse[channel], d->rel_mse[channel]);
            write_amount(file, entry->spp);
            write_amount(file, entry->seconds);
            fputc('\n', file);
        }
    }
    fprintf(file,
            "\nMean ratio: mean / mean of the reference. Relative RMSE: RMSE / mean of the reference. relMSE: mean "
            "of error^2 / (reference^2 + 0.01 mean^2).\n\nHeat maps: red where the image is brighter than the "
            "reference, blue where it is darker; full colour at 100 percent of the reference, or of a tenth of its "
            "mean where that is more. Green: not finite.\n");
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

/* An image as it is shown, at the exposure of all. */
static int write_view(cli_session* session, const cli_comparison* comparison, const cli_compared* entry) {
    char* path = cli_comparison_path(comparison->folder, "view_", entry->name, ".png");
    if (path == NULL) return CLI_FAILED;
    const ty_result result = ty_image_write_png(session->context, entry->image, comparison->exposure, true, path);
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
    cli_panel* panels = calloc(count, sizeof *panels);
    char* labels = calloc(count, LABEL_SIZE);
    ty_result result = TY_ERROR_MEMORY;
    if (path != NULL && panels != NULL && labels != NULL) {
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
    if (status == CLI_DONE) status = write_text(session, comparison, "table.md", print_table);
    if (status == CLI_DONE) status = write_text(session, comparison, "errors.json", print_errors);
    return status;
}
