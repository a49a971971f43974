/* Scenes of the matrix at a size that pictures have: errors of means over 4 x 4 pixels, which have more structure than
 * the twelve means of the small pictures. */
#define _GNU_SOURCE
#include "figures/auto_model.h"
#include "figures/view.h"
#include "cli/text/text_file.h"

#include <jansson.h>
#include <math.h>
#include <string.h>

/* The stored table: tools/scenes/matrix_fine.txt. */
extern const char matrix_fine_text[];

enum { SCENES = 12, LINE_SIZE = 256 };

static const char* const names[SCENES] = {"point_terrain_emissive_moderate_g0.5_a0.5",
                                          "constant_level_grid_moderate_g0_a1",
                                          "spot_room_homogeneous_thin_g0.9_a0.9",
                                          "sky_level_emissive_dense_g0.96_a0.9",
                                          "area_room_grid_thin_g0.5_a1",
                                          "sky_open_homogeneous_moderate_g0.5_a0.9",
                                          "directional_terrain_emissive_thin_g0.9_a0.9",
                                          "map_level_grid_dense_g0.5_a0.9",
                                          "point_level_several_dense_g0_a0.5",
                                          "directional_open_homogeneous_thin_g0_a1",
                                          "mesh_level_homogeneous_dense_g0.9_a0.9",
                                          "mesh_room_grid_moderate_g0.5_a1"};
static const char size_text[] = "160x120";

typedef struct fine_cell {
    bool rendered;
    double error, seconds;
} fine_cell;

typedef struct fine_table {
    fine_cell cells[SCENES][AUTO_METHODS];
} fine_table;

/* ---- measuring ---- */

static ty_result render(figure_run* run, const char* folder, const char* name, const char* const* arguments,
                        figure_process* process, ty_image** out) {
    char path[MATRIX_PATH_SIZE];
    snprintf(path, sizeof path, "%s/%s.json", folder, name);
    ty_result result = matrix_render(folder, path, arguments, process);
    matrix_image_path(folder, path);
    if (result == TY_OK && process->status == 0) result = ty_image_read(run->session->context, path, out);
    return result;
}

/* Noise of means over 4 x 4 pixels of the last picture, relative to its mean. */
static double read_noise(const char* folder) {
    char path[MATRIX_PATH_SIZE];
    matrix_stats_path(folder, path);
    json_t* root = json_load_file(path, 0, NULL);
    const double error = json_number_value(json_object_get(root, "error"));
    json_decref(root);
    return error / FIGURE_BLOCK;
}

static ty_result measure(figure_run* run, const char* folder, const char* name, int32_t method, const ty_image* truth,
                         double noise, fine_cell* out) {
    const char* const arguments[] = {"--method", auto_methods[method], "--size", size_text, "--spp", "32", NULL};
    figure_process process;
    ty_image* image = NULL;
    ty_difference difference;
    ty_result result = render(run, folder, name, arguments, &process, &image);
    if (result == TY_OK && image != NULL)
        result = ty_image_compare(run->session->context, image, truth, FIGURE_BLOCK, &difference);
    if (result == TY_OK && image != NULL) {
        const double error = difference.relative_rmse[3];
        *out = (fine_cell){true, sqrt(fmax(error * error - noise * noise, 0)), process.seconds};
    }
    ty_image_destroy(image);
    return result;
}

static ty_result measure_scene(figure_run* run, const char* folder, const char* name, fine_cell out[AUTO_METHODS]) {
    static const char* const arguments[] = {"--method", "path", "--size", size_text, "--seed", "1",
                                            "--spp",    "4096", "--time", "15",      NULL};
    figure_process process;
    ty_image* truth = NULL;
    ty_result result = render(run, folder, name, arguments, &process, &truth);
    const double noise = read_noise(folder);
    for (int32_t m = 0; m < AUTO_METHODS && truth != NULL && result == TY_OK; ++m)
        result = measure(run, folder, name, m, truth, noise, &out[m]);
    ty_image_destroy(truth);
    return result;
}

static ty_result print_table(ty_context* context, FILE* file, const void* user) {
    const fine_table* table = user;
    (void)context;
    fputs("# Scenes of the matrix at 160 x 120 pixels (tyndall figure matrix-fine): scene, method, relative RMSE of "
          "means "
          "over 4 x 4\n# pixels, processor time in s.\n",
          file);
    for (int i = 0; i < SCENES; ++i)
        for (int32_t m = 0; m < AUTO_METHODS; ++m)
            if (table->cells[i][m].rendered)
                fprintf(file, "%s %s %.4f %.3g\n", names[i], auto_methods[m], table->cells[i][m].error,
                        table->cells[i][m].seconds);
    return TY_OK;
}

ty_result figure_matrix_fine(figure_run* run) {
    char folder[FIGURE_PATH_SIZE], path[MATRIX_PATH_SIZE];
    matrix_table scenes = {0};
    fine_table table;
    memset(&table, 0, sizeof table);
    const int count = run->options->quick ? 0 : SCENES;
    ty_result result = matrix_open(run, folder, &scenes);
    for (int i = 0; i < count && result == TY_OK; ++i) {
        result = measure_scene(run, folder, names[i], table.cells[i]);
        for (int32_t m = 0; m < AUTO_METHODS && result == TY_OK; ++m) {
            char item[FIGURE_NAME_SIZE];
            snprintf(item, sizeof item, "%.48s, %s", names[i], auto_methods[m]);
            figure_notes(run, item, {"relative RMSE", "1", table.cells[i][m].error},
                         {"time", "s", table.cells[i][m].seconds});
        }
    }
    matrix_close(&scenes);
    snprintf(path, sizeof path, "%s/fine.txt", folder);
    if (result == TY_OK) result = cli_write_text_file(run->session->context, path, print_table, &table);
    figure_caption(run, "Scenes of the matrix at %s pixels: relative RMSE of means over %d × %d pixels against path.",
                   size_text, FIGURE_BLOCK, FIGURE_BLOCK);
    return result;
}

/* ---- the stored table ---- */

bool matrix_find_fine(const char* scene, const char* method, ty_expectation* out) {
    for (const char* line = matrix_fine_text; *line != '\0';) {
        char copy[LINE_SIZE], name[MATRIX_NAME_SIZE], of[MATRIX_USE_SIZE];
        const size_t length = strcspn(line, "\n");
        snprintf(copy, sizeof copy, "%.*s", (int)(length < LINE_SIZE ? length : LINE_SIZE - 1), line);
        ty_expectation read;
        const bool whole = sscanf(copy, "%55s %15s %lf %lf", name, of, &read.error, &read.seconds) == 4;
        if (whole && strcmp(name, scene) == 0 && strcmp(of, method) == 0) {
            *out = read;
            return true;
        }
        line += length + (line[length] != '\0');
    }
    return false;
}
