/* The camera with its film and sampler, and integrators. */
#include "io/interchange/mitsuba/mitsuba.h"

#include "base/constants.h"
#include "base/context.h"
#include "base/number.h"
#include "io/interchange/solids.h"
#include "io/json_text.h"

#include <math.h>
#include <string.h>

static json_t* render_of(ty_mitsuba* scene) {
    if (scene->conversion->render == NULL) scene->conversion->render = json_pack("{s:s}", "method", "path");
    return scene->conversion->render;
}

static ty_result read_film(ty_mitsuba* scene, int32_t node, int32_t size[2]) {
    const int32_t film = ty_mitsuba_child_of_tag(scene, node, "film");
    double numbers[2] = {768, 576};
    size[0] = 768;
    size[1] = 576;
    if (film < 0) return TY_OK;
    ty_result result = ty_mitsuba_float(scene, film, "width", &numbers[0]);
    if (result == TY_OK) result = ty_mitsuba_float(scene, film, "height", &numbers[1]);
    for (int a = 0; a < 2 && result == TY_OK; ++a) {
        if (!(numbers[a] >= 1 && numbers[a] <= 65536))
            return ty_mitsuba_fail(scene, film, "a resolution of %g is outside 1..65536", numbers[a]);
        size[a] = (int32_t)numbers[a];
    }
    if (ty_mitsuba_child(scene, film, "crop_width") >= 0 || ty_mitsuba_child(scene, film, "crop_height") >= 0)
        ty_conversion_approximate(scene->conversion, "film: the image is whole, without its crop window");
    return result;
}

/* Tangent of half the vertical angle, from an angle along an axis of the film. */
static double vertical_tangent(const char* axis, double degrees, double aspect) {
    const double tangent = tan(degrees * TY_PI_F64 / 360);
    if (ty_mitsuba_same(axis, "y") || (ty_mitsuba_same(axis, "smaller") && aspect > 1) ||
        (ty_mitsuba_same(axis, "larger") && aspect <= 1))
        return tangent;
    if (ty_mitsuba_same(axis, "diagonal")) return tangent / sqrt(1 + aspect * aspect);
    return tangent / aspect;
}

static ty_result read_angle(ty_mitsuba* scene, int32_t node, double aspect, double* fov_y) {
    const char *axis = ty_mitsuba_string(scene, node, "fov_axis"),
               *focal = ty_mitsuba_string(scene, node, "focal_length");
    double fov = -1;
    const ty_result result = ty_mitsuba_float(scene, node, "fov", &fov);
    if (result != TY_OK) return result;
    if (axis == NULL) axis = "x";
    if (fov < 0) { /* of a film of 36 x 24 mm, along its diagonal; 50 mm without anything */
        const char* end;
        const double length = focal != NULL ? ty_parse_number(focal, &end) : 50;
        fov = 2 * atan(0.5 * sqrt(36.0 * 36 + 24 * 24) / (length > 0 ? length : 50)) * 180 / TY_PI_F64;
        axis = "diagonal";
    }
    *fov_y = 2 * atan(vertical_tangent(axis, fov, aspect)) * 180 / TY_PI_F64;
    if (*fov_y > 0 && *fov_y < 180) return TY_OK;
    return ty_mitsuba_fail(scene, node, "the camera's angle of view, %g degrees, is outside (0, 180)", fov);
}

static ty_result read_sampler(ty_mitsuba* scene, int32_t node) {
    const int32_t sampler = ty_mitsuba_child_of_tag(scene, node, "sampler");
    double count = 16;
    if (sampler < 0) return TY_OK;
    const ty_result result = ty_mitsuba_float(scene, sampler, "sample_count", &count);
    if (result != TY_OK) return result;
    const json_int_t spp = (json_int_t)fmin(fmax(count, 1), 1 << 24);
    return ty_conversion_set(scene->conversion, render_of(scene), "spp", json_integer(spp));
}

/* Notes about all that a pinhole camera lacks. */
static void note_rest(ty_mitsuba* scene, int32_t node) {
    const char* type = ty_mitsuba_type(scene, node);
    if (strcmp(type, "thinlens") == 0)
        ty_conversion_leave_out(scene->conversion, "sensor \"thinlens\": depth of field");
    else if (strcmp(type, "perspective") != 0 && strcmp(type, "orthographic") != 0)
        ty_conversion_approximate(scene->conversion, "sensor \"%.60s\" became a pinhole camera", type);
    if (ty_mitsuba_child(scene, node, "principal_point_offset_x") >= 0 ||
        ty_mitsuba_child(scene, node, "principal_point_offset_y") >= 0)
        ty_conversion_leave_out(scene->conversion, "sensor: the offset of the principal point");
}

ty_result ty_mitsuba_sensor(ty_mitsuba* scene, int32_t node) {
    ty_affine map;
    int32_t size[2], medium = -1;
    double fov_y = 40, position[3], forward[3], up[3], target[3], length = 0, height = 0;
    if (scene->conversion->camera != NULL) {
        ty_conversion_approximate(scene->conversion, "of several sensors the first is taken");
        return TY_OK;
    }
    ty_result result = ty_mitsuba_transform(scene, node, "to_world", &map);
    if (result == TY_OK) result = read_film(scene, node, size);
    if (result != TY_OK) return result;
    const double aspect = (double)size[0] / size[1];
    const bool orthographic = strcmp(ty_mitsuba_type(scene, node), "orthographic") == 0;
    note_rest(scene, node);
    if (!orthographic) result = read_angle(scene, node, aspect, &fov_y);
    if (result == TY_OK) result = read_sampler(scene, node);
    const int32_t inner = ty_mitsuba_child_of_tag(scene, node, "medium");
    if (result == TY_OK && inner >= 0) result = ty_mitsuba_medium(scene, inner, &medium);
    if (result != TY_OK) return result;
    if (medium >= 0) scene->conversion->media[medium].outside = scene->conversion->media[medium].camera = true;
    if (ty_affine_determinant(&map) < 0)
        ty_conversion_approximate(scene->conversion, "sensor: its transform mirrors, and the image does not");
    ty_affine_point(&map, (const double[3]){0, 0, 0}, position);
    ty_affine_direction(&map, (const double[3]){0, 0, 1}, forward);
    ty_affine_direction(&map, (const double[3]){0, 1, 0}, up);
    for (int a = 0; a < 3; ++a) {
        length += forward[a] * forward[a];
        height += up[a] * up[a];
    }
    if (!(length > 0 && height > 0)) return ty_mitsuba_fail(scene, node, "the camera's transform has no direction");
    double back = 0;
    if (orthographic) { /* the film spans -1 to 1 in x */
        back = 1000 * sqrt(height) / aspect;
        fov_y = 2 * atan(1e-3) * 180 / TY_PI_F64;
        ty_conversion_approximate(scene->conversion,
                                  "sensor \"orthographic\": a distant one with a narrow view was taken");
    }
    for (int a = 0; a < 3; ++a) {
        forward[a] /= sqrt(length);
        up[a] /= sqrt(height);
        position[a] -= back * forward[a];
        target[a] = position[a] + forward[a];
    }
    scene->conversion->camera =
        json_pack("{s:o, s:o, s:o, s:o, s:[i, i]}", "position", ty_conversion_vector(position, 3), "target",
                  ty_conversion_vector(target, 3), "up", ty_conversion_vector(up, 3), "fov_y", ty_json_number(fov_y),
                  "resolution", (int)size[0], (int)size[1]);
    return scene->conversion->camera != NULL ? TY_OK : ty_conversion_no_memory(scene->conversion);
}

/* Mitsuba's depth of 1 is that of light seen directly, so that it is one more than the number of scatterings. */
ty_result ty_mitsuba_integrator(ty_mitsuba* scene, int32_t node) {
    double depth = -1;
    for (int nested = 0; nested < TY_MITSUBA_DEPTH_MAX; ++nested) { /* aov and moment hold the integrator */
        const int32_t inner = ty_mitsuba_child_of_tag(scene, node, "integrator");
        if (inner < 0) break;
        node = inner;
    }
    const ty_result result = ty_mitsuba_float(scene, node, "max_depth", &depth);
    if (result != TY_OK) return result;
    if (depth >= 0 && depth < 2)
        ty_conversion_approximate(scene->conversion, "integrator: a max_depth of %g became one scattering", depth);
    const json_int_t limit = depth < 0 ? 0 : depth < 2 ? 1 : (json_int_t)fmin(depth - 1, 1e9);
    json_t* path = json_pack("{s:I}", "max_depth", limit);
    return ty_conversion_set(scene->conversion, render_of(scene), "path", path);
}
