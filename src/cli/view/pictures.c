/* The viewer's last full images as files. */
#define _GNU_SOURCE
#include "cli/view/live_state.h"

#include "cli/session/session.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

void view_keep_picture(view_live* live, view_channel channel, const float* rgb, int32_t width, int32_t height,
                       double spp) {
    view_picture* picture = &live->pictures[channel];
    const size_t values = 3 * (size_t)width * (size_t)height;
    pthread_mutex_lock(&live->mutex);
    if (picture->width != width || picture->height != height || picture->rgb == NULL) {
        free(picture->rgb);
        picture->rgb = malloc(values * sizeof(float));
    }
    if (picture->rgb != NULL) {
        memcpy(picture->rgb, rgb, values * sizeof(float));
        picture->width = width;
        picture->height = height;
        picture->revision = live->revision;
        picture->spp = spp;
        snprintf(picture->method, sizeof picture->method, "%s",
                 channel == VIEW_CHANNEL_PATH ? live->source->reference : live->method->name);
    }
    pthread_mutex_unlock(&live->mutex);
}

void view_show_picture(view_live* live, view_channel channel) {
    const view_picture* picture = &live->pictures[channel]; /* written by this thread alone */
    if (picture->rgb == NULL || picture->revision != live->revision) return;
    const view_frame frame = {.channel = channel,
                              .revision = picture->revision,
                              .width = picture->width,
                              .height = picture->height,
                              .full_width = live->width,
                              .full_height = live->height,
                              .rgb = picture->rgb,
                              .spp = (float)picture->spp,
                              .exposure = (float)live->exposure,
                              .final = channel == VIEW_CHANNEL_METHOD};
    view_server_show(live->server, &frame);
}

static ty_result make_image(ty_context* context, const view_picture* picture, ty_image** out) {
    ty_result result = ty_image_create_rgb(context, picture->width, picture->height, out);
    if (result != TY_OK) return result;
    const size_t count = (size_t)picture->width * (size_t)picture->height;
    for (int32_t c = 0; c < 3; ++c) {
        float* plane = ty_image_plane(*out, c);
        for (size_t i = 0; i < count; ++i) plane[i] = picture->rgb[3 * i + (size_t)c];
    }
    result = ty_image_set_text(*out, "method", picture->method);
    if (result == TY_OK && picture->spp > 0) result = ty_image_set_number(*out, "spp", picture->spp);
    if (result != TY_OK) ty_image_destroy(*out);
    return result;
}

static ty_result write_image(ty_context* context, const view_picture* picture, double exposure, ty_tone_curve curve,
                             const char* path) {
    ty_image* image;
    ty_result result = make_image(context, picture, &image);
    if (result != TY_OK) return result;
    result = cli_has_extension(path, ".png") ? ty_image_write_png(context, image, exposure, curve, path)
                                             : ty_image_write_exr(context, image, path);
    ty_image_destroy(image);
    return result;
}

bool view_write_picture(view_live* live, view_channel channel, const char* path, char* text, size_t size) {
    ty_context_def def = ty_default_context_def();
    def.threads = 1;
    ty_context* context;
    ty_result result = ty_context_create(&def, &context);
    if (result != TY_OK) {
        snprintf(text, size, "%s", ty_result_text(result));
        return false;
    }
    pthread_mutex_lock(&live->mutex);
    const view_picture* picture = &live->pictures[channel];
    const bool there = picture->rgb != NULL;
    if (there) result = write_image(context, picture, live->exposure, live->curve, path);
    pthread_mutex_unlock(&live->mutex);
    if (!there) snprintf(text, size, "there is no image yet");
    if (result != TY_OK) snprintf(text, size, "%s", ty_take_error(context));
    ty_context_destroy(context);
    return there && result == TY_OK;
}

/* Reads a whole file; freed with free(). */
static bool read_file(const char* path, uint8_t** bytes, size_t* size) {
    FILE* file = fopen(path, "rb");
    if (file == NULL) return false;
    long length = -1;
    if (fseek(file, 0, SEEK_END) == 0) length = ftell(file);
    *bytes = length > 0 ? malloc((size_t)length) : NULL;
    *size = (size_t)length;
    const bool read = *bytes != NULL && fseek(file, 0, SEEK_SET) == 0 && fread(*bytes, 1, *size, file) == *size;
    fclose(file);
    if (!read) free(*bytes);
    return read;
}

bool view_live_image(void* user, view_channel channel, uint8_t** bytes, size_t* size) {
    view_live* live = user;
    enum { SIZE = 1024 };
    char folder[SIZE], path[SIZE + 16], text[512];
    if (!cli_make_temporary_folder("view", folder, sizeof folder)) return false;
    snprintf(path, sizeof path, "%s/image.exr", folder);
    const bool made = view_write_picture(live, channel, path, text, sizeof text) && read_file(path, bytes, size);
    unlink(path);
    rmdir(folder);
    return made;
}
