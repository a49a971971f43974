/* tyndall screen: reading images and distances. */
#include "cli/screen/screen_input.h"

#include "base/constants.h"
#include "cli/session/metadata.h"

#include <math.h>
#include <string.h>
#include <strings.h>

/* Common names of the channel of distances or depths, the most frequent first. */
static const char* const distance_names[] = {"depth.Z", "Z", "depth", "distance.Z", "distance", "depth.V", "ZBack"};
enum { DISTANCE_NAME_COUNT = sizeof distance_names / sizeof distance_names[0], LIST_SIZE = 400 };

static void list_channels(const ty_image* image, char out[LIST_SIZE]) {
    size_t used = 0;
    out[0] = '\0';
    for (int32_t i = 0; i < ty_image_channel_count(image); ++i) {
        const char* name = ty_image_channel_name(image, i);
        if (used + strlen(name) + 8 > LIST_SIZE) {
            snprintf(out + used, LIST_SIZE - used, " ...");
            return;
        }
        used += (size_t)snprintf(out + used, LIST_SIZE - used, "%s%s", i == 0 ? "" : ", ", name);
    }
}

/* True if a channel has a name, ignoring case, with or without a layer prefix. */
static bool is_called(const char* channel, const char* name) {
    const size_t length = strlen(channel), size = strlen(name);
    if (length < size || strcasecmp(channel + length - size, name) != 0) return false;
    return length == size || channel[length - size - 1] == '.';
}

static int32_t find_distance_channel(const ty_image* image) {
    for (int n = 0; n < DISTANCE_NAME_COUNT; ++n)
        for (int32_t i = 0; i < ty_image_channel_count(image); ++i)
            if (is_called(ty_image_channel_name(image, i), distance_names[n])) return i;
    return -1;
}

/* The plane of distances in the image of a path; alone: a single channel is accepted under any name. */
static int choose_channel(const screen_options* options, ty_image* image, const char* path, bool any_single,
                          float** distance) {
    char list[LIST_SIZE];
    list_channels(image, list);
    int32_t channel =
        options->channel != NULL ? ty_image_find_channel(image, options->channel) : find_distance_channel(image);
    if (channel < 0 && options->channel != NULL)
        return cli_fail(CLI_USAGE, "%s: no channel '%s'; there are: %s", path, options->channel, list);
    if (channel < 0 && any_single && ty_image_channel_count(image) == 1) channel = 0;
    if (channel < 0 && any_single)
        return cli_fail(CLI_USAGE, "%s: which channel is the distance? Give --distance-channel; there are: %s", path,
                        list);
    if (channel < 0)
        return cli_fail(CLI_USAGE,
                        "%s: no channel holds distances; give DISTANCE or --distance-channel; there "
                        "are: %s",
                        path, list);
    *distance = ty_image_plane(image, channel);
    return CLI_GO;
}

/* Adds the purpose to messages about memory. */
static int fail_reading(cli_session* session, const char* path, ty_result result) {
    if (result != TY_ERROR_MEMORY) return cli_fail_reading(session, result);
    return cli_fail(CLI_FAILED, "%s: %s", path, ty_take_error(session->context));
}

static int read_distances(cli_session* session, const screen_options* options, screen_input* input) {
    int32_t largest = 0;
    const ty_result result = ty_image_read_whole(session->context, input->distance_path, &input->distances, &largest);
    if (result != TY_OK) return fail_reading(session, input->distance_path, result);
    if (largest > 0 && !options->distance_scale_given)
        return cli_fail(CLI_USAGE,
                        "%s: distances are whole numbers, 0 to %d, here; say with --distance-scale "
                        "how many metres 1 is (0.001 if they are millimetres)",
                        input->distance_path, largest);
    return choose_channel(options, input->distances, input->distance_path, true, &input->distance);
}

static int check_sizes(const screen_input* input) {
    if (input->distances == NULL) return CLI_GO;
    const int32_t width = ty_image_width(input->distances), height = ty_image_height(input->distances);
    if (width != input->width || height != input->height)
        return cli_fail(CLI_USAGE, "%s is %dx%d pixels, and %s is %dx%d: an image and its distances have one size",
                        input->image_path, input->width, input->height, input->distance_path, width, height);
    int32_t a[4], b[4];
    ty_image_get_frame(input->image, a);
    ty_image_get_frame(input->distances, b);
    const bool whole = b[0] == 0 && b[1] == 0 && b[2] == width && b[3] == height;
    if (!whole && memcmp(a, b, sizeof a) != 0)
        return cli_fail(CLI_USAGE, "%s is at %d,%d of a frame of %dx%d, and %s is at %d,%d of one of %dx%d",
                        input->image_path, a[0], a[1], a[2], a[3], input->distance_path, b[0], b[1], b[2], b[3]);
    return CLI_GO;
}

static int check_color(screen_input* input) {
    char list[LIST_SIZE];
    if (ty_image_rgb_planes(input->image, input->color)) return CLI_GO;
    list_channels(input->image, list);
    return cli_fail(CLI_USAGE, "%s: neither R, G and B nor one channel alone to take as the image; there are: %s",
                    input->image_path, list);
}

/* Distances are converted to metres in place, so a color channel must not be converted. */
static int check_own_channel(const screen_input* input) {
    for (int c = 0; c < 3; ++c)
        if (input->distance == input->color[c])
            return cli_fail(CLI_USAGE, "%s: one channel cannot be both the image and its distances", input->image_path);
    return CLI_GO;
}

int screen_open_input(cli_session* session, const screen_options* options, const char* image_path,
                      const char* distance_path, screen_input* out) {
    /* A PNG is decoded from sRGB as an image, and not as distances. */
    const bool one_file =
        distance_path == NULL || (strcmp(image_path, distance_path) == 0 && cli_has_extension(image_path, ".exr"));
    *out = (screen_input){.image_path = image_path, .distance_path = one_file ? image_path : distance_path};
    const ty_result result = ty_image_read(session->context, image_path, &out->image);
    if (result != TY_OK) return fail_reading(session, image_path, result);
    out->width = ty_image_width(out->image);
    out->height = ty_image_height(out->image);
    int status = check_color(out);
    if (status == CLI_GO)
        status = one_file ? choose_channel(options, out->image, image_path, false, &out->distance)
                          : read_distances(session, options, out);
    if (status == CLI_GO) status = check_own_channel(out);
    return status == CLI_GO ? check_sizes(out) : status;
}

void screen_close_input(screen_input* input) {
    ty_image_destroy(input->image);
    ty_image_destroy(input->distances);
}

int screen_prepare_distances(cli_session* session, const screen_options* options, screen_input* input) {
    const int64_t pixels = (int64_t)input->width * input->height;
    for (int64_t i = 0; options->distance_scale != 1 && i < pixels; ++i)
        input->distance[i] = (float)(options->distance_scale * (double)input->distance[i]);
    if (!options->fill) return CLI_GO;
    const ty_result result =
        ty_screen_fill_distance(session->context, input->width, input->height, input->distance, &input->filled);
    return result == TY_OK ? CLI_GO : cli_fail_running(session, result);
}

/* Focal length and principal point, from the options or the image. */
static int set_camera(const screen_options* options, const screen_input* input, ty_screen_def* def) {
    int32_t frame[4];
    ty_image_get_frame(input->image, frame);
    double fov_y = options->fov_y;
    if (!options->fov_y_given && !options->focal_given && !cli_metadata_number(input->image, cli_fov_key, &fov_y))
        return cli_fail(CLI_USAGE, "%s: it does not say how it was seen; give --fov-y DEGREES or --focal PIXELS",
                        input->image_path);
    if (!options->focal_given && !(fov_y >= 1e-3 && fov_y < 180))
        return cli_fail(CLI_USAGE, "%s: its %s is %g, not an angle from 0.001 to 180 degrees", input->image_path,
                        cli_fov_key, fov_y);
    for (int axis = 0; axis < 2; ++axis) {
        def->focal[axis] = options->focal_given ? options->focal[axis] : ty_screen_focal(frame[3], fov_y);
        /* Camera of the full frame, of which the image can be a crop. */
        const double center = options->center_given ? options->center[axis] : 0.5 * frame[2 + axis];
        def->center[axis] = center - frame[axis];
    }
    def->distance_kind = (ty_screen_distance_kind)options->depth_is;
    return CLI_GO;
}

/* The mean over all directions of a latitude-longitude map, top row at the zenith. */
static void mean_radiance(const ty_image* map, const float* const planes[3], double out[3]) {
    const int32_t width = ty_image_width(map), height = ty_image_height(map);
    double total = 0;
    for (int32_t y = 0; y < height; ++y) {
        const double weight = cos(TY_PI_F64 * y / height) - cos(TY_PI_F64 * (y + 1) / height);
        for (int32_t x = 0; x < width; ++x)
            for (int c = 0; c < 3; ++c) {
                const double value = (double)planes[c][(int64_t)y * width + x];
                if (value > 0 && isfinite(value)) out[c] += weight * value;
            }
        total += weight * width;
    }
    for (int c = 0; c < 3; ++c) out[c] /= total;
}

static int read_map(cli_session* session, const char* path, double out[3]) {
    ty_image* map = NULL;
    const ty_result result = ty_image_read(session->context, path, &map);
    if (result != TY_OK) return cli_fail_reading(session, result);
    const float* planes[3];
    const bool colored = ty_image_rgb_planes(map, planes);
    if (colored) mean_radiance(map, planes, out);
    ty_image_destroy(map);
    return colored ? CLI_GO : cli_fail(CLI_USAGE, "%s: neither R, G and B nor one channel alone", path);
}

int screen_read_environment(cli_session* session, const screen_options* options, float out[3]) {
    double radiance[3] = {0};
    const int count = options->environment == NULL ? 0 : screen_parse_numbers(options->environment, 1, radiance);
    if (count == 2)
        return cli_usage_error(options->command, "--environment: '%s' is neither one number nor R,G,B",
                               options->environment);
    if (count == 1) radiance[1] = radiance[2] = radiance[0];
    for (int c = 0; c < count; ++c)
        if (!(radiance[c] >= 0 && radiance[c] <= 1e12))
            return cli_usage_error(options->command, "--environment: %g is outside 0..1e12", radiance[c]);
    if (options->environment != NULL && count == 0) {
        const int status = read_map(session, options->environment, radiance);
        if (status != CLI_GO) return status;
    }
    for (int c = 0; c < 3; ++c) out[c] = (float)radiance[c];
    return CLI_GO;
}

int screen_make_def(const screen_options* options, const screen_input* input, const ty_medium_def* medium,
                    const float around[3], ty_screen_def* def) {
    *def = ty_default_screen_def();
    memcpy(def->sigma_s, medium->sigma_s, sizeof def->sigma_s);
    memcpy(def->sigma_a, medium->sigma_a, sizeof def->sigma_a);
    memcpy(def->g, medium->g, sizeof def->g);
    def->missing_depth = (float)options->sky_distance;
    screen_set_variant(options, def);
    const int status = set_camera(options, input, def);
    if (status != CLI_GO) return status;
    if (options->balance)
        ty_screen_balance(def, around);
    else
        memcpy(def->environment, around, sizeof def->environment);
    return CLI_GO;
}

ty_screen_image screen_describe_image(const screen_input* input, float* const out[3]) {
    ty_screen_image image = ty_default_screen_image();
    image.width = input->width;
    image.height = input->height;
    image.distance = input->distance;
    /* A read-only view of an input. */
    for (int c = 0; c < 3; ++c) {
        image.color.data[c] = (float*)(uintptr_t)input->color[c];
        image.out.data[c] = out[c];
    }
    image.color.row = image.out.row = image.distance_row = input->width;
    return image;
}
