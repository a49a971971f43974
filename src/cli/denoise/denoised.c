/* Denoised layers of images. */
#include "cli/denoise/denoised.h"
#include "image/image.h"

#include <stdlib.h>

static ty_result add_layers(cli_session* session, const ty_image* denoised, bool (*keep)(void* user, const char* name),
                            void* user, ty_image** image) {
    const int32_t own = ty_image_channel_count(*image), added = ty_image_channel_count(denoised);
    const char** names = calloc((size_t)(own + added), sizeof *names);
    if (names == NULL) return TY_ERROR_MEMORY;
    int32_t count = 0;
    for (int32_t i = 0; i < own; ++i) {
        const char* name = ty_image_channel_name(*image, i);
        if (ty_image_find_channel(denoised, name) < 0 && (keep == NULL || keep(user, name))) names[count++] = name;
    }
    for (int32_t i = 0; i < added; ++i) names[count++] = ty_image_channel_name(denoised, i);
    ty_image* all = NULL;
    const ty_result result = ty_image_select(session->context, *image, denoised, count, names, &all);
    free(names);
    if (result != TY_OK) return result;
    ty_image_destroy(*image);
    *image = all;
    return TY_OK;
}

int cli_check_denoiser(cli_session* session, int denoiser) {
    if (ty_denoiser_is_available(session->context, (ty_denoiser)denoiser) == TY_OK) return CLI_GO;
    return cli_fail(CLI_USAGE, "%s", ty_take_error(session->context));
}

ty_result cli_add_denoised(cli_session* session, const ty_denoise_def* def, bool (*keep)(void* user, const char* name),
                           void* user, ty_image** image, ty_denoise_stats* stats) {
    ty_image* denoised = NULL;
    ty_result result = ty_denoise_image(session->context, *image, def, &denoised, stats);
    cli_progress_clear(&session->progress);
    if (result == TY_OK) result = add_layers(session, denoised, keep, user, image);
    ty_image_destroy(denoised);
    return result;
}

ty_result cli_denoised_metadata(ty_image* image, const ty_denoise_stats* stats) {
    return ty_image_set_number(image, "tyndall.denoised_error", stats->error);
}

void cli_print_denoised(const ty_denoise_stats* stats) {
    printf("denoised: relative error %.3g%% by estimate%s, was %.3g%%, %d features, %.2g s\n", 100 * stats->error,
           stats->previous > 0 ? " without the previous image, whose traces it does not know" : "",
           100 * stats->raw_error, stats->features, stats->seconds);
}

void cli_denoised_json(json_writer* json, const ty_denoise_stats* stats) {
    json_open_object(json, "denoise");
    json_number(json, "error", stats->error);
    json_number(json, "raw_error", stats->raw_error);
    json_int(json, "parts", stats->parts);
    json_int(json, "features", stats->features);
    json_number(json, "previous", stats->previous);
    json_number(json, "seconds", stats->seconds);
    json_text(json, "isa", stats->isa == NULL ? "" : stats->isa);
    json_close_object(json);
}

ty_result cli_write_denoised_png(cli_session* session, const ty_image* image, double exposure, const char* path) {
    ty_image* layer = NULL;
    ty_result result = ty_image_create_layer(session->context, image, "denoised", &layer);
    if (result == TY_OK) result = ty_image_write_png(session->context, layer, exposure, TY_TONE_FILMIC, path);
    ty_image_destroy(layer);
    return result;
}
