/* References of the matrix: block means by path of each scene, as a text table of one line a scene. */
#define _GNU_SOURCE
#include "figures/matrix.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* The stored table: tools/scenes/matrix_reference.txt. */
extern const char matrix_reference_text[];

enum { LINE_SIZE = 1024 };

/* Limits of path for one scene, relative error of pixels and seconds; the second where the first leaves more noise. */
static const char *const error_limits[] = {"0.06", "0.015"}, *const time_limits[] = {"20", "40"};
static const double noise_max = 0.01;

/* ---- the table ---- */

/* NAME SAMPLES, the means, their standard errors. False for comments and broken lines. */
static bool read_line(const char* line, matrix_reference* out) {
    int used = 0;
    if (sscanf(line, "%55s %d%n", out->name, &out->samples, &used) != 2 || out->name[0] == '#') return false;
    for (int i = 0; i < 2 * MATRIX_BLOCKS; ++i) {
        char* end;
        const double value = strtod(line + used, &end);
        if (end == line + used) return false;
        *(i < MATRIX_BLOCKS ? &out->mean[i] : &out->error[i - MATRIX_BLOCKS]) = value;
        used = (int)(end - line);
    }
    return true;
}

static bool find_in_text(const char* text, const char* name, matrix_reference* out) {
    for (const char* line = text; *line != '\0';) {
        char copy[LINE_SIZE];
        const size_t length = strcspn(line, "\n");
        snprintf(copy, sizeof copy, "%.*s", (int)(length < LINE_SIZE ? length : LINE_SIZE - 1), line);
        if (read_line(copy, out) && strcmp(out->name, name) == 0) return true;
        line += length + (line[length] != '\0');
    }
    return false;
}

static bool find_in_file(const char* path, const char* name, matrix_reference* out) {
    char line[LINE_SIZE];
    bool found = false;
    FILE* file = fopen(path, "r");
    while (file != NULL && !found && fgets(line, sizeof line, file) != NULL)
        found = read_line(line, out) && strcmp(out->name, name) == 0;
    if (file != NULL) fclose(file);
    return found;
}

/* Comments at the top of a new table. */
static const char table_head[] =
    "# Scenes of the matrix by path (tyndall figure matrix --spp N): name, samples per pixel, means of R, G and B over "
    "12\n"
    "# blocks of 12 x 12 pixels, row by row from the top left, W m^-2 sr^-1, and their standard errors.\n";

static bool append(const char* path, const matrix_reference* reference) {
    FILE* file = fopen(path, "a");
    if (file == NULL) return false;
    if (fseek(file, 0, SEEK_END) == 0 && ftell(file) == 0) fputs(table_head, file);
    fprintf(file, "%s %d", reference->name, reference->samples);
    for (int i = 0; i < MATRIX_BLOCKS; ++i) fprintf(file, " %.5g", reference->mean[i]);
    for (int i = 0; i < MATRIX_BLOCKS; ++i) fprintf(file, " %.2g", reference->error[i]);
    fputc('\n', file);
    return fclose(file) == 0;
}

/* ---- path ---- */

static ty_result measure(figure_run* run, const char* folder, const char* scene, int limit, matrix_reference* out) {
    ty_context* context = run->session->context;
    char samples[16], path[MATRIX_PATH_SIZE];
    const char* const arguments[] = {"--method", "path",
                                     "--seed",   "1",
                                     "--spp",    samples,
                                     "--error",  error_limits[limit],
                                     "--time",   time_limits[limit],
                                     "--aov",    "variance,samples",
                                     NULL};
    figure_process process;
    ty_image* image = NULL;
    snprintf(samples, sizeof samples, "%d", run->options->samples);
    matrix_image_path(folder, path);
    ty_result result = matrix_render(folder, scene, arguments, &process);
    if (result == TY_OK && process.status != 0) {
        cli_fail(CLI_FAILED, "%s: path gives no reference: %s", scene, process.words);
        return TY_ERROR_INPUT;
    }
    if (result == TY_OK) result = ty_image_read(context, path, &image);
    if (result != TY_OK) return result;
    double variances[MATRIX_BLOCKS];
    matrix_block_means(image, out->mean, variances);
    for (int i = 0; i < MATRIX_BLOCKS; ++i) out->error[i] = sqrt(variances[i]);
    out->samples = (int32_t)ty_image_plane_const(image, ty_image_find_channel(image, "samples.N"))[0];
    ty_image_destroy(image);
    return TY_OK;
}

/* Noise of the blocks, relative to the mean of the image. */
static double relative_noise(const matrix_reference* reference) {
    double squares = 0, mean = 0;
    for (int i = 0; i < MATRIX_BLOCKS; ++i) {
        squares += reference->error[i] * reference->error[i] / MATRIX_BLOCKS;
        mean += reference->mean[i] / MATRIX_BLOCKS;
    }
    return sqrt(squares) / mean;
}

ty_result matrix_find_reference(figure_run* run, const char* folder, matrix_row* row) {
    char path[MATRIX_PATH_SIZE], scene[MATRIX_PATH_SIZE];
    bool found;
    ty_result result = TY_OK;
    snprintf(path, sizeof path, "%s/matrix_reference.txt", run->options->folder);
    snprintf(scene, sizeof scene, "%s/%s.json", folder, row->name);
    if (run->options->samples == 0) {
        found = find_in_text(matrix_reference_text, row->name, &row->reference);
    } else {
        found = find_in_file(path, row->name, &row->reference);
        if (!found) {
            memcpy(row->reference.name, row->name, sizeof row->name);
            result = measure(run, folder, scene, 0, &row->reference);
            if (result == TY_OK && relative_noise(&row->reference) > noise_max)
                result = measure(run, folder, scene, 1, &row->reference);
            if (result != TY_OK) return result;
            found = append(path, &row->reference);
        }
    }
    if (!found) cli_fail(CLI_FAILED, "%s: there is no reference; --spp 4096 makes them anew", row->name);
    if (found) row->noise = relative_noise(&row->reference);
    return found ? TY_OK : TY_ERROR_INPUT;
}
