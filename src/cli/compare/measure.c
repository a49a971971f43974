/* Differences from the reference, and its noise. */
#include "cli/compare/measure.h"

#include <math.h>
#include <string.h>

typedef struct window {
    int32_t x0, y0, x1, y1; /* window in the frame */
} window;

static window common_window(const ty_image* a, const ty_image* b) {
    int32_t fa[4], fb[4];
    ty_image_get_frame(a, fa);
    ty_image_get_frame(b, fb);
    const int32_t ax = fa[0] + ty_image_width(a), ay = fa[1] + ty_image_height(a);
    const int32_t bx = fb[0] + ty_image_width(b), by = fb[1] + ty_image_height(b);
    return (window){fa[0] > fb[0] ? fa[0] : fb[0], fa[1] > fb[1] ? fa[1] : fb[1], ax < bx ? ax : bx, ay < by ? ay : by};
}

/* The mean of the finite values of a plane within the window. */
static double mean_within(const ty_image* image, const float* plane, const window* w) {
    int32_t frame[4];
    ty_image_get_frame(image, frame);
    double sum = 0;
    int64_t count = 0;
    for (int32_t y = w->y0; y < w->y1; ++y)
        for (int32_t x = w->x0; x < w->x1; ++x) {
            const double value = (double)plane[(int64_t)(y - frame[1]) * ty_image_width(image) + (x - frame[0])];
            if (!isfinite(value)) continue;
            sum += value;
            ++count;
        }
    return count > 0 ? sum / (double)count : 0;
}

bool cli_sample_range(const ty_image* reference, double* min_samples, double* max_samples) {
    const int32_t channel = ty_image_find_channel(reference, "samples.N");
    if (channel < 0) return false;
    const float* plane = ty_image_plane_const(reference, channel);
    const int64_t count = (int64_t)ty_image_width(reference) * ty_image_height(reference);
    *min_samples = *max_samples = (double)plane[0];
    for (int64_t i = 0; i < count; ++i) {
        *min_samples = fmin(*min_samples, (double)plane[i]);
        *max_samples = fmax(*max_samples, (double)plane[i]);
    }
    return true;
}

cli_noise cli_measure_noise(const ty_image* reference, const ty_image* other) {
    static const char* const names[3] = {"variance.R", "variance.G", "variance.B"};
    cli_noise noise = {.known = true};
    const float* planes[3];
    const window both = common_window(reference, other);
    double min_samples, max_samples;
    if (cli_sample_range(reference, &min_samples, &max_samples) && min_samples < 2) return (cli_noise){.known = false};
    if (!ty_image_rgb_planes(reference, planes)) return (cli_noise){.known = false};
    double variance = 0, mean = 0;
    for (int c = 0; c < 3; ++c) {
        const int32_t channel = ty_image_find_channel(reference, names[c]);
        if (channel < 0) return (cli_noise){.known = false};
        const double v = fmax(mean_within(reference, ty_image_plane_const(reference, channel), &both), 0);
        const double m = mean_within(reference, planes[c], &both);
        noise.rmse[c] = sqrt(v);
        noise.relative[c] = m > 0 ? noise.rmse[c] / m : 0;
        variance += v / 3;
        mean += m / 3;
    }
    noise.rmse[3] = sqrt(variance);
    noise.relative[3] = mean > 0 ? noise.rmse[3] / mean : 0;
    return noise;
}

static int compare(cli_session* session, const cli_comparison* comparison, const char* source, const ty_image* image,
                   ty_difference* out) {
    if (ty_image_compare(session->context, image, comparison->reference.image, 1, out) == TY_OK) return CLI_GO;
    cli_progress_clear(&session->progress);
    return cli_fail(CLI_USAGE, "%s and %s: %s", source, comparison->reference.source, ty_take_error(session->context));
}

int cli_measure_entry(cli_session* session, const cli_comparison* comparison, cli_compared* entry) {
    int status = compare(session, comparison, entry->source, entry->image, &entry->difference);
    if (status == CLI_GO) entry->noise = cli_measure_noise(comparison->reference.image, entry->image);
    for (int i = 0; i < entry->earlier_count && status == CLI_GO; ++i)
        status = compare(session, comparison, entry->source, entry->earlier[i].image, &entry->earlier[i].difference);
    return status;
}
