/* Images on their way from the rendering thread: to clients, to files, to tev. */
#include "cli/view/live_state.h"

#include "cli/session/session.h"

#include <stdlib.h>

float* view_make_room(float** pixels, size_t* capacity, int32_t width, int32_t height) {
    const size_t values = 3 * (size_t)width * (size_t)height;
    if (values > *capacity) {
        free(*pixels);
        *pixels = malloc(values * sizeof(float));
        *capacity = *pixels != NULL ? values : 0;
    }
    return *pixels;
}

float* view_pixels(view_live* live, int32_t width, int32_t height) {
    return view_make_room(&live->rgb, &live->rgb_capacity, width, height);
}

bool view_interleave(const ty_image* image, float* rgb) {
    const size_t count = (size_t)ty_image_width(image) * (size_t)ty_image_height(image);
    const float* planes[3];
    if (!ty_image_rgb_planes(image, planes)) return false;
    for (size_t i = 0; i < count; ++i)
        for (size_t c = 0; c < 3; ++c) rgb[3 * i + c] = planes[c][i];
    return true;
}

static void note_image(view_live* live) {
    live->shown_times[live->shown_count++ % (sizeof live->shown_times / sizeof live->shown_times[0])] =
        cli_wall_seconds();
}

/* tev makes an image anew for another size: coarse ones are enlarged to the full frame, pixel by pixel. */
static void show_in_tev(view_live* live, const float* rgb, int32_t width, int32_t height) {
    if (live->tev == NULL || live->tev->socket <= 0) return;
    if (width == live->width && height == live->height) {
        cli_tev_show_pixels(live->tev, rgb, width, height);
        return;
    }
    float* large = view_make_room(&live->enlarged, &live->enlarged_capacity, live->width, live->height);
    if (large == NULL) return;
    for (int64_t y = 0; y < live->height; ++y) {
        const float* row = rgb + 3 * width * (y * height / live->height);
        for (int64_t x = 0; x < live->width; ++x, large += 3) {
            const float* pixel = row + 3 * (x * width / live->width);
            for (int c = 0; c < 3; ++c) large[c] = pixel[c];
        }
    }
    cli_tev_show_pixels(live->tev, live->enlarged, live->width, live->height);
}

void view_show(view_live* live, view_channel channel, const float* rgb, int32_t width, int32_t height, double spp,
               bool final) {
    const double now = cli_wall_seconds();
    if (channel == VIEW_CHANNEL_METHOD) {
        if (live->received > 0) live->times.latency = 1e3 * (now - live->received);
        live->received = 0;
        note_image(live);
    }
    const view_frame frame = {.channel = channel,
                              .revision = live->revision,
                              .width = width,
                              .height = height,
                              .full_width = live->width,
                              .full_height = live->height,
                              .rgb = rgb,
                              .spp = (float)spp,
                              .latency = (float)live->times.latency,
                              .exposure = (float)live->exposure,
                              .final = final,
                              .moving = width < live->width || live->moved > 0};
    const bool whole = width == live->width && height == live->height;
    const bool first = channel == VIEW_CHANNEL_METHOD && live->shown == VIEW_SHOWN_NOTHING && !final; /* coarse */
    if (whole && !first) view_keep_picture(live, channel, rgb, width, height, spp);
    view_server_show(live->server, &frame);
    if (channel == VIEW_CHANNEL_METHOD) show_in_tev(live, rgb, width, height);
}

bool view_show_image(view_live* live, const ty_image* image, bool final) {
    const int32_t width = ty_image_width(image), height = ty_image_height(image);
    float* rgb = view_pixels(live, width, height);
    if (rgb == NULL || !view_interleave(image, rgb)) return false;
    view_show(live, VIEW_CHANNEL_METHOD, rgb, width, height, 0, final);
    return true;
}
