/* Lights that belong to no shape. */
#include "io/interchange/mitsuba/mitsuba.h"

#include "base/constants.h"
#include "base/context.h"
#include "io/interchange/environment_map.h"
#include "io/interchange/solids.h"
#include "io/json_text.h"

#include <math.h>
#include <string.h>

static json_t* light_colour(const double rgb[3]) {
    return ty_conversion_colour(rgb, 0, 1e9);
}

static ty_result read_colour(ty_mitsuba* scene, int32_t node, const char* name, double rgb[3]) {
    bool found;
    rgb[0] = rgb[1] = rgb[2] = 1;
    return ty_mitsuba_colour(scene, node, name, true, rgb, &found);
}

static ty_result read_point(ty_mitsuba* scene, int32_t node) {
    double rgb[3], position[3] = {0, 0, 0}, place[3];
    ty_affine map;
    ty_result result = ty_mitsuba_transform(scene, node, "to_world", &map);
    if (result == TY_OK) result = read_colour(scene, node, "intensity", rgb);
    if (result == TY_OK) result = ty_mitsuba_vector(scene, node, "position", position);
    if (result != TY_OK) return result;
    ty_affine_point(&map, position, place);
    return ty_conversion_add_light(scene->conversion,
                                   json_pack("{s:s, s:o, s:o}", "type", "point", "position",
                                             ty_conversion_vector(place, 3), "intensity", light_colour(rgb)));
}

static ty_result read_spot(ty_mitsuba* scene, int32_t node) {
    double rgb[3], place[3], direction[3], cutoff = 20, beam = -1;
    ty_affine map;
    ty_result result = ty_mitsuba_transform(scene, node, "to_world", &map);
    if (result == TY_OK) result = read_colour(scene, node, "intensity", rgb);
    if (result == TY_OK) result = ty_mitsuba_float(scene, node, "cutoff_angle", &cutoff);
    if (result == TY_OK) result = ty_mitsuba_float(scene, node, "beam_width", &beam);
    if (result != TY_OK) return result;
    cutoff = fmin(fmax(cutoff, 1e-3), 90);
    if (beam < 0) beam = 0.75 * cutoff;
    ty_affine_point(&map, (const double[3]){0, 0, 0}, place);
    ty_affine_direction(&map, (const double[3]){0, 0, 1}, direction);
    ty_conversion_approximate(scene->conversion, "emitter \"spot\": it fades smoothly, not linearly in the angle");
    return ty_conversion_add_light(
        scene->conversion,
        json_pack("{s:s, s:o, s:o, s:o, s:o, s:o}", "type", "spot", "position", ty_conversion_vector(place, 3),
                  "direction", ty_conversion_vector(direction, 3), "intensity", light_colour(rgb), "cone",
                  ty_json_number(2 * cutoff), "penumbra", ty_json_number(fmin(fmax(1 - beam / cutoff, 0), 1))));
}

static ty_result read_directional(ty_mitsuba* scene, int32_t node) {
    double rgb[3], local[3] = {0, 0, 1}, direction[3];
    ty_affine map;
    ty_result result = ty_mitsuba_transform(scene, node, "to_world", &map);
    if (result == TY_OK) result = read_colour(scene, node, "irradiance", rgb);
    if (result == TY_OK) result = ty_mitsuba_vector(scene, node, "direction", local);
    if (result != TY_OK) return result;
    ty_affine_direction(&map, local, direction);
    return ty_conversion_add_light(scene->conversion,
                                   json_pack("{s:s, s:o, s:o}", "type", "directional", "direction",
                                             ty_conversion_vector(direction, 3), "irradiance", light_colour(rgb)));
}

static ty_result read_constant(ty_mitsuba* scene, int32_t node) {
    double rgb[3];
    const ty_result result = read_colour(scene, node, "radiance", rgb);
    return result != TY_OK ? result
                           : ty_conversion_add_light(scene->conversion, json_pack("{s:s, s:o}", "type", "environment",
                                                                                  "radiance", light_colour(rgb)));
}

/* Tells whether a map turns about y alone, and by how much, counter-clockwise seen from above. */
static bool is_turn(const ty_affine* map, double* degrees) {
    double scale;
    const double* m = map->m;
    if (!ty_affine_is_similarity(map, &scale) || ty_affine_determinant(map) < 0) return false;
    if (fabs(m[5] - scale) > 1e-6 * scale) return false;
    *degrees = atan2(m[2], m[10]) * 180 / TY_PI_F64;
    return true;
}

/* A map that is rotated otherwise is written anew. */
static ty_result write_map(ty_mitsuba* scene, const char* path, const ty_affine* map, char** reference) {
    ty_image *image = NULL, *rotated = NULL;
    ty_result result = ty_image_read(scene->context, path, &image);
    if (result == TY_OK) result = ty_convert_map(scene->context, image, TY_MAP_ANGLES, map, NULL, &rotated);
    ty_image_destroy(image);
    if (result != TY_OK) return result;
    result = ty_conversion_write_exr(scene->conversion, rotated, reference);
    ty_image_destroy(rotated);
    return result;
}

static ty_result read_map(ty_mitsuba* scene, int32_t node) {
    char location[TY_MITSUBA_LOCATION_SIZE];
    char *path = NULL, *reference = NULL;
    double scale = 1, degrees = 0;
    ty_affine map;
    const char* name = ty_mitsuba_string(scene, node, "filename");
    if (name == NULL) return ty_mitsuba_fail(scene, node, "the map has no filename");
    ty_result result = ty_mitsuba_transform(scene, node, "to_world", &map);
    if (result == TY_OK) result = ty_mitsuba_float(scene, node, "scale", &scale);
    if (result != TY_OK) return result;
    char* found = ty_mitsuba_file_name(scene, name);
    if (found == NULL) return TY_ERROR_MEMORY;
    ty_mitsuba_location(scene, node, location);
    result = ty_conversion_find_file(scene->conversion, location, found, &path, &reference);
    ty_free_text(scene->context, found);
    const bool turn = is_turn(&map, &degrees);
    if (result == TY_OK && path != NULL && !turn) {
        ty_free_text(scene->context, reference);
        reference = NULL;
        result = write_map(scene, path, &map, &reference);
    }
    ty_free_text(scene->context, path);
    if (result != TY_OK || reference == NULL) return result;
    /* The left edge is along -z there, and along -x here, with the same turn of the columns. */
    json_t* light =
        json_pack("{s:s, s:s, s:o, s:o}", "type", "environment", "file", reference, "scale",
                  ty_json_number(fmin(fmax(scale, 0), 1e6)), "rotation", ty_json_number(turn ? degrees - 90 : 0));
    ty_free_text(scene->context, reference);
    return ty_conversion_add_light(scene->conversion, light);
}

static const struct {
    const char* type;
    ty_result (*read)(ty_mitsuba* scene, int32_t node);
} readers[] = {{"point", read_point},
               {"spot", read_spot},
               {"directional", read_directional},
               {"constant", read_constant},
               {"envmap", read_map}};

ty_result ty_mitsuba_emitter(ty_mitsuba* scene, int32_t node) {
    for (size_t i = 0; i < sizeof readers / sizeof readers[0]; ++i)
        if (strcmp(readers[i].type, ty_mitsuba_type(scene, node)) == 0) return readers[i].read(scene, node);
    ty_conversion_leave_out(scene->conversion, "the emitter \"%.60s\"", ty_mitsuba_type(scene, node));
    return TY_OK;
}
