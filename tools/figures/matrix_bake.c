/* `tyndall bake` on the scenes of the matrix: irradiance at the vertices of their floors, against that by paths. */
#include "figures/matrix.h"
#include "cli/text/text_file.h"

#include <math.h>
#include <string.h>

const char* const matrix_bakes[MATRIX_BAKES] = {"cache", "impulse"};

enum { LINES = 9, RECEIVERS_MAX = (LINES + 2) * (LINES + 2) };

/* The floors of the surroundings, which are their first surfaces: vertices at equal distances, and at the corners of
 * a plain that reaches farther. */
typedef struct floor_mesh {
    const char* name;          /* of the file without its .obj */
    double lower[2], upper[2]; /* x, z */
    double beyond;             /* half of the plain's side; 0: none */
    const char* albedo;
} floor_mesh;

static const floor_mesh floors[] = {
    [MATRIX_ROOM] = {"floor_room", {-2, -2}, {2, 2}, 0, "0.6"},
    [MATRIX_TERRAIN] = {"floor_terrain", {-4, -4}, {4, 4}, 20, "[0.3, 0.35, 0.2]"},
    [MATRIX_LEVEL] = {"floor_level", {-5, -4}, {5, 4}, 0, "0.6"},
};

/* ---- the meshes ---- */

static int find_lines(const floor_mesh* from, int axis, double out[LINES + 2]) {
    int count = 0;
    if (from->beyond > 0) out[count++] = -from->beyond;
    for (int i = 0; i < LINES; ++i)
        out[count++] = from->lower[axis] + (from->upper[axis] - from->lower[axis]) * i / (LINES - 1);
    if (from->beyond > 0) out[count++] = from->beyond;
    return count;
}

static ty_result print_floor(ty_context* context, FILE* file, const void* user) {
    double x[LINES + 2], z[LINES + 2];
    const int columns = find_lines(user, 0, x), rows = find_lines(user, 1, z);
    (void)context;
    for (int j = 0; j < rows; ++j)
        for (int i = 0; i < columns; ++i) fprintf(file, "v %g 0 %g\n", x[i], z[j]);
    for (int j = 0; j + 1 < rows; ++j)
        for (int i = 0; i + 1 < columns; ++i) {
            const int a = j * columns + i + 1, b = a + columns;
            fprintf(file, "f %d %d %d\nf %d %d %d\n", a, b, a + 1, a + 1, b, b + 1);
        }
    return TY_OK;
}

ty_result matrix_write_floors(figure_run* run, const char* folder) {
    ty_result result = TY_OK;
    for (int i = MATRIX_ROOM; i <= MATRIX_LEVEL && result == TY_OK; ++i) {
        char path[MATRIX_PATH_SIZE];
        snprintf(path, sizeof path, "%s/%s.obj", folder, floors[i].name);
        result = cli_write_text_file(run->session->context, path, print_floor, &floors[i]);
    }
    return result;
}

/* ---- the bakes ---- */

/* Irradiance at the vertices, mean of the channels, and its variance; receivers without light are inside of walls. */
typedef struct bake_result {
    int32_t count;
    double irradiance[RECEIVERS_MAX], variance[RECEIVERS_MAX];
} bake_result;

static ty_result read_result(figure_run* run, const char* folder, const char* name, bake_result* out) {
    static const char* const names[2][3] = {{"R", "G", "B"}, {"variance.R", "variance.G", "variance.B"}};
    char path[MATRIX_PATH_SIZE];
    ty_image* image = NULL;
    snprintf(path, sizeof path, "%s/baked/%s_obj.exr", folder, name);
    const ty_result result = ty_image_read(run->session->context, path, &image);
    if (result != TY_OK) return result;
    const int32_t width = ty_image_width(image);
    *out = (bake_result){.count = width < RECEIVERS_MAX ? width : RECEIVERS_MAX};
    for (int c = 0; c < 3; ++c) {
        const float* mean = ty_image_plane_const(image, ty_image_find_channel(image, names[0][c]));
        const float* variance = ty_image_plane_const(image, ty_image_find_channel(image, names[1][c]));
        for (int32_t i = 0; i < out->count; ++i) {
            out->irradiance[i] += (double)mean[i] / 3;
            out->variance[i] += (double)variance[i] / 3;
        }
    }
    ty_image_destroy(image);
    return TY_OK;
}

/* The floor's mesh stands in the place of its quad. */
static ty_result bake(figure_run* run, const char* folder, const matrix_row* row, const char* method, bool quick,
                      figure_process* process, bake_result* out) {
    const floor_mesh* mesh = &floors[row->scene.values[MATRIX_SURROUNDINGS]];
    const bool reference = strcmp(method, "path") == 0;
    char scene[MATRIX_PATH_SIZE], target[MATRIX_PATH_SIZE], change[256];
    const char* const arguments[] = {"bake",     scene,
                                     "-o",       target,
                                     "-q",       "--threads",
                                     "1",        "--vertices",
                                     "--method", method,
                                     "--spp",    quick ? "16" : reference ? "4096" : "256",
                                     "--error",  reference ? "0.03" : "0.01",
                                     "--cache",  quick ? "8" : "16",
                                     "-D",       change,
                                     NULL};
    matrix_scene_path(folder, row, scene);
    snprintf(target, sizeof target, "%s/baked", folder);
    snprintf(change, sizeof change, "geometry[0]={\"file\": \"%s.obj\", \"material\": {\"albedo\": %s}}", mesh->name,
             mesh->albedo);
    ty_result result = matrix_run_tyndall(arguments, process);
    if (result == TY_OK && process->status == 0) result = read_result(run, folder, mesh->name, out);
    return result;
}

static void leave_out(matrix_cell* cell, const char* words) {
    *cell = (matrix_cell){.state = MATRIX_LEFT_OUT, .ratio = NAN, .rmse = NAN};
    snprintf(cell->words, sizeof cell->words, "%s", words);
}

/* Irradiance over pi times the mean radiance of the picture, below which the floor is dark, as beneath an opaque
 * medium. */
static const double dark = 1e-3;

/* Means and differences of receivers that have light. radiance: mean of the picture. */
static void compare(const bake_result* truth, const bake_result* baked, double radiance, matrix_cell* out,
                    double* noise) {
    double sum = 0, others = 0, squares = 0, variance = 0;
    int32_t count = 0;
    for (int32_t i = 0; i < truth->count; ++i) {
        if (!(truth->irradiance[i] > 0)) continue;
        const double difference = baked->irradiance[i] - truth->irradiance[i];
        ++count;
        sum += truth->irradiance[i];
        others += baked->irradiance[i];
        squares += difference * difference - baked->variance[i];
        variance += truth->variance[i];
    }
    const double mean = sum / (count > 0 ? count : 1);
    if (!(mean > dark * acos(-1) * radiance)) {
        leave_out(out, "hardly any light reaches the floor");
        return;
    }
    if (!isfinite(others)) {
        out->state = MATRIX_FAILED;
        snprintf(out->words, sizeof out->words, "irradiance is not finite");
        return;
    }
    out->ratio = others / sum;
    out->rmse = sqrt(fmax(squares - variance, 0) / count) / mean;
    *noise = sqrt(variance / count) / mean;
}

ty_result matrix_bake(figure_run* run, const char* folder, matrix_row* row) {
    const bool quick = run->options->quick;
    figure_process process;
    bake_result truth, baked;
    for (int i = 0; i < MATRIX_BAKES; ++i) leave_out(&row->bakes[i], "there are no surfaces to bake");
    if (row->scene.values[MATRIX_SURROUNDINGS] == MATRIX_OPEN) return TY_OK;
    ty_result result = bake(run, folder, row, "path", quick, &process, &truth);
    if (result == TY_OK && process.status != 0)
        for (int i = 0; i < MATRIX_BAKES; ++i) leave_out(&row->bakes[i], "path gives no reference");
    if (result != TY_OK || process.status != 0) return result;
    for (int i = 0; i < MATRIX_BAKES && result == TY_OK; ++i) {
        matrix_cell* cell = &row->bakes[i];
        *cell = (matrix_cell){.state = MATRIX_RENDERED, .ratio = NAN, .rmse = NAN};
        result = bake(run, folder, row, matrix_bakes[i], quick, &process, &baked);
        cell->seconds = process.seconds;
        if (result == TY_OK && process.status != 0) matrix_take_failure(&process, cell);
        if (result == TY_OK && process.status == 0)
            compare(&truth, &baked, matrix_mean(row->reference.mean), cell, &row->bake_noise);
    }
    return result;
}
