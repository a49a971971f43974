/* `tyndall view` on the scenes of the matrix: its final picture against that of `tyndall render`. */
#include "figures/matrix.h"
#include "bench/view_client.h"

#include <math.h>
#include <string.h>

static const double timeout = 120; /* s */

/* The choice of auto; dom where that is path, which the viewer goes on with for as long as it runs. */
static int32_t find_method(const matrix_table* table, const char* choice) {
    const char* name = strcmp(choice, "path") == 0 ? "dom" : choice;
    for (int32_t m = 0; m < table->method_count; ++m)
        if (strcmp(table->methods[m], name) == 0) return m;
    return 0;
}

static void compare(const double rendered[MATRIX_BLOCKS], const double shown[MATRIX_BLOCKS], matrix_cell* out) {
    const double mean = matrix_mean(rendered);
    double squares = 0;
    for (int i = 0; i < MATRIX_BLOCKS; ++i) {
        const double error = (shown[i] - rendered[i]) / mean;
        squares += error * error / MATRIX_BLOCKS;
    }
    out->ratio = matrix_mean(shown) / mean;
    out->rmse = sqrt(squares);
}

static void fail(matrix_cell* out, const char* words) {
    out->state = MATRIX_FAILED;
    snprintf(out->words, sizeof out->words, "%s", words);
}

/* Waits for the final picture and stores it as a file. */
static bool keep_final(view_client* client, const char* path, matrix_cell* out) {
    view_arrival arrival;
    if (!view_client_wait(client, 0, 0, true, timeout, &arrival)) {
        const char* complaint = view_client_complaint(client);
        fail(out, complaint[0] != '\0' ? complaint : "no final picture came");
        return false;
    }
    if (view_client_fetch_image(client, path)) return true;
    fail(out, "the final picture cannot be fetched");
    return false;
}

ty_result matrix_view(figure_run* run, const char* folder, const matrix_table* table, matrix_row* row) {
    const int32_t method = find_method(table, row->choice);
    const matrix_cell* rendered = &row->cells[method];
    matrix_cell* out = &row->view;
    char scene[MATRIX_PATH_SIZE], image_path[MATRIX_PATH_SIZE], samples[48];
    double means[MATRIX_BLOCKS];
    ty_image* image = NULL;
    row->view_method = table->methods[method];
    /* Both pictures have the noise of their surfaces. */
    *out =
        (matrix_cell){.state = MATRIX_RENDERED, .ratio = NAN, .rmse = NAN, .deviation = sqrt(2) * rendered->deviation};
    if (rendered->state != MATRIX_RENDERED) {
        out->state = MATRIX_LEFT_OUT;
        snprintf(out->words, sizeof out->words, "%s renders no picture to compare with", row->view_method);
        return TY_OK;
    }
    matrix_scene_path(folder, row, scene);
    matrix_image_path(folder, image_path);
    snprintf(samples, sizeof samples, "render.spp=%d", table->samples);
    const char* const arguments[] = {scene,   "--method", row->view_method, "--no-compare", "--threads", "1", "-D",
                                     samples, NULL};
    view_client* client = view_client_open(arguments);
    if (client == NULL) {
        fail(out, "the viewer does not start");
        return figure_check_interrupt();
    }
    const bool kept = keep_final(client, image_path, out);
    view_client_close(client);
    ty_result result = figure_check_interrupt();
    if (result == TY_OK && kept) result = ty_image_read(run->session->context, image_path, &image);
    if (result == TY_OK && kept && !matrix_block_means(image, means, NULL)) fail(out, "pixels are not finite");
    if (result == TY_OK && kept && out->state == MATRIX_RENDERED) compare(rendered->means, means, out);
    ty_image_destroy(image);
    return result;
}
