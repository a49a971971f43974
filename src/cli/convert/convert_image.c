/* tyndall convert: images. */
#include "cli/convert/convert.h"

static int write_png16(cli_session* session, const ty_image* image, const convert_image_options* options,
                       const char* output) {
    int32_t channel = 0;
    if (options->channel != NULL) {
        channel = ty_image_find_channel(image, options->channel);
        if (channel < 0) return cli_usage_error("convert", "the image has no channel '%s'", options->channel);
    }
    const ty_result result = ty_image_write_png16(session->context, image, channel, options->scale, output);
    return result == TY_OK ? CLI_DONE : cli_fail_running(session, result);
}

/* ---- textures ---- */

static bool is_texture(const char* path) {
    return cli_has_extension(path, ".ktx2") || cli_has_extension(path, ".dds");
}

static int write_texture(cli_session* session, const ty_image* image, const convert_image_options* options,
                         const char* output) {
    ty_texels_def def = ty_default_texels_def();
    const bool ktx2 = cli_has_extension(output, ".ktx2");
    if (options->texels >= 0) def.format = (ty_texel_format)options->texels;
    def.slices = options->slices;
    def.mipmaps = options->mipmaps;
    def.range = options->range;
    def.zstd = ktx2 ? options->zstd : 0;
    const ty_result result = ty_texels_write(session->context, image, &def, output);
    return result == TY_OK               ? CLI_DONE
           : result == TY_ERROR_ARGUMENT ? cli_fail_reading(session, result)
                                         : cli_fail_running(session, result);
}

static int write_image(cli_session* session, const ty_image* image, const convert_image_options* options,
                       const char* output) {
    if (options->bits == 16) return write_png16(session, image, options, output);
    if (is_texture(output) || options->texels >= 0) return write_texture(session, image, options, output);
    const ty_result result =
        cli_has_extension(output, ".exr")
            ? ty_image_write_exr(session->context, image, output)
            : ty_image_write_png(session->context, image, options->exposure, (ty_tone_curve)options->curve, output);
    return result == TY_OK ? CLI_DONE : cli_fail_running(session, result);
}

static int check_options(const convert_image_options* options, const char* output) {
    const bool png = cli_has_extension(output, ".png");
    if (!png && !cli_has_extension(output, ".exr") && !is_texture(output))
        return cli_usage_error("convert", "%s: an image goes to .exr, .png, .ktx2 or .dds", output);
    if (!is_texture(output) && !(png && options->texels >= 0) &&
        (options->texels >= 0 || options->slices > 0 || options->mipmaps))
        return cli_usage_error("convert", "--texels, --slices and --mipmaps are for textures, and %s is none", output);
    if (options->bits != 0 && options->texels >= 0)
        return cli_usage_error("convert", "--bits and --texels exclude one another");
    if (options->bits != 0 && options->bits != 8 && options->bits != 16)
        return cli_usage_error("convert", "--bits: %d is neither 8 nor 16", options->bits);
    if (options->bits == 16 && !png) return cli_usage_error("convert", "--bits is for .png, and %s is none", output);
    return CLI_GO;
}

/* With --bits 16 samples are not tone mapped, so that depth survives. */
static ty_result read_image(cli_session* session, const convert_image_options* options, const char* input,
                            ty_image** out) {
    ty_result result = options->bits == 16 ? ty_image_read_raw(session->context, input, out)
                                           : ty_image_read(session->context, input, out);
    if (result != TY_OK || options->layer == NULL) return result;
    ty_image* layer = NULL;
    result = ty_image_create_layer(session->context, *out, options->layer, &layer);
    ty_image_destroy(*out);
    *out = layer;
    return result;
}

int cli_convert_image(cli_session* session, const convert_image_options* options, const char* input,
                      const char* output) {
    const int status = check_options(options, output);
    if (status != CLI_GO) return status;
    ty_image* image = NULL;
    const ty_result result = read_image(session, options, input, &image);
    if (result != TY_OK) return cli_fail_reading(session, result);
    cli_end_on_interrupt(false);
    const int written = write_image(session, image, options, output);
    ty_image_destroy(image);
    return written;
}
