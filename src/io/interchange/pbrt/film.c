/* Cameras, films, samplers and integrators. */
#include "base/constants.h"
#include "base/context.h"
#include "io/interchange/pbrt/pbrt.h"
#include "io/interchange/solids.h"
#include "io/json_text.h"

#include <math.h>
#include <string.h>

static double dot(const double a[3], const double b[3]) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* The half height of the screen window in units of which 1 is half the field of view; with a note about the rest. */
static void read_screen(ty_pbrt* reader, const ty_pbrt_parameters* parameters) {
    const ty_pbrt_parameter* window = ty_pbrt_find(parameters, "screenwindow");
    reader->frame_aspect = ty_pbrt_float(parameters, "frameaspectratio", 0);
    if (window == NULL || window->number_count < 4) return;
    const double* n = window->numbers;
    reader->screen_height = 0.5 * fabs(n[3] - n[2]);
    if (fabs(n[0] + n[1]) > 1e-3 * fabs(n[1] - n[0]) || fabs(n[2] + n[3]) > 1e-3 * fabs(n[3] - n[2]))
        ty_conversion_approximate(reader->conversion, "Camera: the screen window is off centre, and was centred");
}

ty_result ty_pbrt_camera(ty_pbrt* reader, const ty_pbrt_parameters* parameters) {
    if (reader->has_camera) return ty_pbrt_refuse(parameters, "there is a second camera");
    ty_affine world;
    if (!ty_affine_invert(&ty_pbrt_now(reader)->ctm, &world))
        return ty_pbrt_refuse(parameters, "the camera's transform cannot be inverted");
    ty_pbrt_frame frame = {.name = "camera", .ctm = world};
    if (!ty_grow_array(reader->context, (void**)&reader->frames, &reader->frame_capacity, reader->frame_count,
                       sizeof *reader->frames))
        return TY_ERROR_MEMORY;
    reader->frames[reader->frame_count++] = frame;
    if (ty_affine_determinant(&world) > 0) reader->mirror.m[0] = -1; /* x, y and z of the view are left-handed */
    const ty_affine view = ty_affine_multiply(&reader->mirror, &world);
    double position[3], forward[3], up[3], target[3];
    ty_affine_point(&view, (const double[3]){0, 0, 0}, position);
    ty_affine_direction(&view, (const double[3]){0, 0, 1}, forward);
    ty_affine_direction(&view, (const double[3]){0, 1, 0}, up);
    const double length = sqrt(dot(forward, forward)), height = sqrt(dot(up, up));
    reader->has_camera = true;
    read_screen(reader, parameters);
    reader->fov = ty_pbrt_float(parameters, "fov", 90);
    const double open = ty_pbrt_float(parameters, "shutteropen", 0),
                 close = ty_pbrt_float(parameters, "shutterclose", 1);
    reader->exposure_time = close > open ? close - open : 1;
    double back = 0;
    if (strcmp(parameters->type, "orthographic") == 0) {
        reader->fov = 2 * atan(1e-3) * 180 / TY_PI_F64;
        back = 1000 * height;
        ty_conversion_approximate(reader->conversion,
                                  "Camera \"orthographic\": a distant one with a narrow view was taken");
    } else if (strcmp(parameters->type, "perspective") != 0) {
        ty_conversion_approximate(reader->conversion, "Camera \"%s\": a pinhole camera of %g degrees was taken",
                                  parameters->type, reader->fov);
    }
    if (ty_pbrt_float(parameters, "lensradius", 0) > 0)
        ty_conversion_leave_out(reader->conversion, "Camera: depth of field (lensradius)");
    ty_pbrt_float(parameters, "focaldistance", 0);
    for (int a = 0; a < 3; ++a) {
        forward[a] /= length;
        up[a] /= height;
        position[a] -= back * forward[a];
        target[a] = position[a] + forward[a];
    }
    const int32_t medium = ty_pbrt_now(reader)->outside;
    if (medium >= 0) reader->conversion->media[medium].outside = reader->conversion->media[medium].camera = true;
    json_t* camera = json_pack("{s:o, s:o, s:o}", "position", ty_conversion_vector(position, 3), "target",
                               ty_conversion_vector(target, 3), "up", ty_conversion_vector(up, 3));
    if (camera == NULL) return ty_conversion_no_memory(reader->conversion);
    reader->conversion->camera = camera;
    return TY_OK;
}

ty_result ty_pbrt_film(ty_pbrt* reader, const ty_pbrt_parameters* parameters) {
    char sensor[TY_PBRT_NAME_SIZE];
    static const char* const ignored[] = {"filename",         "savefp16", "maxcomponentvalue", "diagonal",
                                          "coordinatesystem", "nbuckets", "lambdamin",         "lambdamax"};
    for (size_t i = 0; i < sizeof ignored / sizeof ignored[0]; ++i) ty_pbrt_find(parameters, ignored[i]);
    reader->has_film = true;
    reader->resolution[0] = ty_pbrt_int(parameters, "xresolution", 1280);
    reader->resolution[1] = ty_pbrt_int(parameters, "yresolution", 720);
    for (int a = 0; a < 2; ++a)
        if (reader->resolution[a] < 1 || reader->resolution[a] > 65536)
            return ty_pbrt_refuse(parameters, "a resolution of %d is outside 1..65536", (int)reader->resolution[a]);
    if (ty_pbrt_find(parameters, "cropwindow") != NULL || ty_pbrt_find(parameters, "pixelbounds") != NULL)
        ty_conversion_approximate(reader->conversion, "Film: the image is whole, without its crop window");
    reader->iso = fmax(ty_pbrt_float(parameters, "iso", 100), 1e-6);
    if (ty_pbrt_string(parameters, "sensor", sensor, sizeof sensor) && strcmp(sensor, "cie1931") != 0)
        ty_conversion_leave_out(reader->conversion, "Film: the colours of the sensor \"%s\"", sensor);
    if (ty_pbrt_float(parameters, "whitebalance", 0) != 0)
        ty_conversion_leave_out(reader->conversion, "Film: white balance");
    return TY_OK;
}

static json_t* render_of(ty_pbrt* reader) {
    ty_conversion* conversion = reader->conversion;
    if (conversion->render == NULL)
        conversion->render = json_pack("{s:s, s:i, s:{s:i}}", "method", "path", "spp", 16, "path", "max_depth", 5);
    return conversion->render;
}

ty_result ty_pbrt_sampler(ty_pbrt* reader, const ty_pbrt_parameters* parameters) {
    ty_pbrt_int(parameters, "seed", 0);
    ty_pbrt_bool(parameters, "jitter", true);
    ty_pbrt_find(parameters, "randomization");
    const bool stratified = strcmp(parameters->type, "stratified") == 0;
    const double x = ty_pbrt_int(parameters, "xsamples", 4), y = ty_pbrt_int(parameters, "ysamples", 4);
    const double spp = ty_pbrt_int(parameters, "pixelsamples", 16), count = stratified ? x * y : spp;
    if (json_object_set_new(render_of(reader), "spp", json_integer((json_int_t)fmin(fmax(count, 1), 1 << 24))) == 0)
        return TY_OK;
    return ty_conversion_no_memory(reader->conversion);
}

ty_result ty_pbrt_integrator(ty_pbrt* reader, const ty_pbrt_parameters* parameters) {
    static const char* const ignored[] = {"lightsampler", "rouletteThreshold", "regularize", "visiblesurface"};
    for (size_t i = 0; i < sizeof ignored / sizeof ignored[0]; ++i) ty_pbrt_find(parameters, ignored[i]);
    const int32_t depth = ty_pbrt_int(parameters, "maxdepth", 5);
    json_t* path = json_object_get(render_of(reader), "path");
    if (json_object_set_new(path, "max_depth", json_integer(depth < 1 ? 1 : depth)) == 0) return TY_OK;
    return ty_conversion_no_memory(reader->conversion);
}

/* Vertical angle of view: fov is that of the shorter axis, or of 1 in units of the screen window. */
ty_result ty_pbrt_finish_camera(ty_pbrt* reader) {
    const int32_t* size = reader->resolution;
    if (!reader->has_film) {
        reader->resolution[0] = 1280;
        reader->resolution[1] = 720;
    }
    const double aspect = reader->frame_aspect > 0 ? reader->frame_aspect : (double)size[0] / size[1];
    const double height = reader->screen_height > 0 ? reader->screen_height : aspect > 1 ? 1 : 1 / aspect;
    const double half = atan(tan(reader->fov * TY_PI_F64 / 360) * height);
    if (!(half > 0 && half < TY_PI_F64 / 2))
        return ty_fail(reader->context, TY_ERROR_INPUT,
                       "%s: the camera's angle of view, %g degrees, is outside (0, 180)", reader->conversion->input,
                       reader->fov);
    json_t* camera = reader->conversion->camera;
    bool done = json_object_set_new(camera, "fov_y", ty_json_number(half * 360 / TY_PI_F64)) == 0;
    done = json_object_set_new(camera, "resolution", json_pack("[i, i]", (int)size[0], (int)size[1])) == 0 && done;
    /* Imaging ratio: exposure time times ISO / 100 (section 5.4.2 of the book, with the reference of 100). */
    const double ratio = reader->exposure_time * reader->iso / 100;
    if (ratio != 1) {
        const double stops = fmin(fmax(log2(ratio), -100), 100);
        done = json_object_set_new(camera, "exposure", ty_json_number(stops)) == 0 && done;
    }
    return render_of(reader) != NULL && done ? TY_OK : ty_conversion_no_memory(reader->conversion);
}
