/* The results of `tyndall compare`, independent of the output formats. */
#include "cli/compare/comparison.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

const cli_compared* cli_nearest_entry(const cli_comparison* comparison) {
    const cli_compared* nearest = NULL;
    for (int i = 0; i < comparison->count; ++i) {
        const cli_compared* entry = &comparison->entries[i];
        if (strcmp(entry->source, "path") == 0) continue;
        if (nearest == NULL || entry->difference.rmse[3] < nearest->difference.rmse[3]) nearest = entry;
    }
    return nearest;
}

double cli_without_noise(double rmse, double noise) {
    return sqrt(fmax(rmse * rmse - noise * noise, 0));
}

void cli_without_noise_text(const cli_compared* entry, int slot, char out[24]) {
    const double noise = entry->noise.relative[slot], error = entry->difference.relative_rmse[slot];
    const double left = cli_without_noise(error, noise);
    if (!entry->noise.known)
        out[0] = '\0';
    else if (error > 0 && 3 * left < noise)
        snprintf(out, 24, "below noise");
    else
        snprintf(out, 24, "%.4g", left);
}

void cli_noise_sentence(const cli_comparison* comparison, char* out, size_t size) {
    const cli_noise* noise = &comparison->reference.noise;
    const cli_compared* nearest = cli_nearest_entry(comparison);
    out[0] = '\0';
    if (!noise->known) return;
    const int used = snprintf(out, size, "The reference's noise is %.3g %% of its mean", 100 * noise->relative[3]);
    if (used < 0 || (size_t)used >= size) return;
    out += used;
    size -= (size_t)used;
    if (nearest == NULL || nearest->difference.rmse[3] <= 0) {
        snprintf(out, size, ".");
        return;
    }
    const double fraction = noise->rmse[3] / nearest->difference.rmse[3];
    snprintf(out, size, ", %.2g of the smallest difference (%s, %.3g %%): %s", fraction, nearest->name,
             100 * nearest->difference.relative_rmse[3],
             fraction <= comparison->wanted ? "well below it." : "not well below it; more samples would tell more.");
}

static void free_images(cli_compared* entry) {
    ty_image_destroy(entry->image);
    entry->image = NULL;
    for (int i = 0; i < entry->earlier_count; ++i) {
        ty_image_destroy(entry->earlier[i].image);
        entry->earlier[i].image = NULL;
    }
}

void cli_comparison_free_images(cli_comparison* comparison) {
    free_images(&comparison->reference);
    for (int i = 0; comparison->entries != NULL && i < CLI_COMPARE_MAX; ++i) free_images(&comparison->entries[i]);
}

void cli_comparison_free(cli_comparison* comparison) {
    free(comparison->reference.command);
    for (int i = 0; comparison->entries != NULL && i < CLI_COMPARE_MAX; ++i) free(comparison->entries[i].command);
    free(comparison->entries);
    free(comparison->skipped);
    free(comparison->scene_text);
}
