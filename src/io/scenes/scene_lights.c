/* Lights of a scene file. */
#include "base/constants.h"
#include "io/scenes/scene_reader.h"
#include "scene/scene.h"

#include <math.h>
#include <string.h>

static ty_result add_light(const ty_scene_reader* reader, const ty_json_path* path, const ty_light_def* def) {
    return ty_reader_prefix_error(reader, path, ty_scene_add_light(reader->scene, def));
}

static ty_result add_environment(const ty_scene_reader* reader, const ty_json_path* path, const ty_light_def* def,
                                 ty_environment_map* map) {
    return ty_reader_prefix_error(reader, path, ty_scene_add_environment(reader->scene, def, map));
}

static ty_result read_sky(ty_scene_reader* reader, const json_t* sky, const ty_json_path* path,
                          const ty_light_def* environment) {
    ty_sky_def def = ty_default_sky_def();
    def.up_axis = reader->up_axis;
    ty_result result = ty_read_direction(reader, sky, path, "sun_direction", def.sun_direction);
    if (result != TY_OK) return result;
    ty_read_rgb(sky, "solar", def.solar);
    ty_read_number(sky, "haze", &def.haze);
    ty_read_rgb(sky, "ground", def.ground);
    ty_read_int(sky, "resolution", &def.width);
    ty_read_number(sky, "ozone", &def.ozone);
    if (json_object_get(sky, "air") != NULL) {
        double lower[3], upper[3];
        result = ty_read_box(reader, sky, path, "air", reader->unit, lower, upper);
        if (result != TY_OK) return result;
        def.height = upper[reader->up_axis] - lower[reader->up_axis];
    }
    const char* scattering = json_string_value(json_object_get(sky, "multiple_scattering"));
    if (scattering != NULL && strcmp(scattering, "isotropic") == 0) def.scattering = TY_SKY_ISOTROPIC;
    if (scattering != NULL && strcmp(scattering, "none") == 0) def.scattering = TY_SKY_SINGLE;
    ty_environment_map* map = NULL;
    float irradiance[3];
    result = ty_make_sky(reader, path, &def, &map, irradiance);
    if (result == TY_OK) result = add_environment(reader, path, environment, map);
    const bool shines = irradiance[0] > 0 || irradiance[1] > 0 || irradiance[2] > 0;
    if (result != TY_OK || !shines || json_is_false(json_object_get(sky, "sun"))) return result;
    ty_light_def sun = ty_default_light_def();
    sun.kind = TY_LIGHT_DIRECTIONAL;
    memcpy(sun.direction, def.sun_direction, sizeof sun.direction);
    for (int c = 0; c < 3; ++c) sun.color[c] = irradiance[c] * environment->scale;
    return add_light(reader, path, &sun);
}

static ty_result read_environment(ty_scene_reader* reader, const json_t* light, const ty_json_path* path) {
    ty_light_def def = ty_default_light_def();
    def.kind = TY_LIGHT_ENVIRONMENT;
    ty_read_float(light, "scale", &def.scale);
    ty_read_number(light, "rotation", &def.rotation);
    const json_t* sky = json_object_get(light, "sky");
    if (sky != NULL) {
        const ty_json_path json_path = ty_json_path_key(path, "sky");
        return read_sky(reader, sky, &json_path, &def);
    }
    const char* file = json_string_value(json_object_get(light, "file"));
    if (file != NULL) {
        const ty_json_path json_path = ty_json_path_key(path, "file");
        ty_environment_map* map = NULL;
        const ty_result result = ty_read_map(reader, &json_path, file, &map);
        return result == TY_OK ? add_environment(reader, &json_path, &def, map) : result;
    }
    ty_read_rgb(light, "radiance", def.color);
    for (int c = 0; c < 3; ++c) def.color[c] *= def.scale;
    def.scale = 1;
    return add_light(reader, path, &def);
}

/* A directional light that is given by where it stands. */
static ty_result read_sun(const ty_scene_reader* reader, const json_t* light, const ty_json_path* path) {
    ty_light_def def = ty_default_light_def();
    double zenith = 0, azimuth = 0;
    ty_read_number(light, "zenith", &zenith);
    ty_read_number(light, "azimuth", &azimuth);
    zenith *= TY_PI_F64 / 180;
    azimuth *= TY_PI_F64 / 180;
    const bool horizontal = json_object_get(light, "horizontal_irradiance") != NULL;
    if (horizontal == (json_object_get(light, "irradiance") != NULL))
        return ty_reader_fail(reader, path, TY_ERROR_INPUT,
                              "exactly one of \"irradiance\" and \"horizontal_irradiance\" is needed");
    ty_read_rgb(light, horizontal ? "horizontal_irradiance" : "irradiance", def.color);
    for (int c = 0; c < 3 && horizontal; ++c) def.color[c] = (float)((double)def.color[c] / cos(zenith));
    def.kind = TY_LIGHT_DIRECTIONAL;
    def.direction[0] = -sin(zenith) * cos(azimuth);
    def.direction[reader->up_axis == TY_AXIS_Z ? 1 : 2] =
        (reader->up_axis == TY_AXIS_Z ? -1 : 1) * sin(zenith) * sin(azimuth);
    def.direction[reader->up_axis] = -cos(zenith);
    return add_light(reader, path, &def);
}

static ty_result read_light(ty_scene_reader* reader, const json_t* light, const ty_json_path* path) {
    const char* type = json_string_value(json_object_get(light, "type"));
    if (strcmp(type, "environment") == 0) return read_environment(reader, light, path);
    if (json_object_get(light, "zenith") != NULL) return read_sun(reader, light, path);
    ty_light_def def = ty_default_light_def();
    const char* color = "intensity";
    if (strcmp(type, "directional") == 0) {
        def.kind = TY_LIGHT_DIRECTIONAL;
        color = "irradiance";
    } else if (strcmp(type, "area") == 0) {
        def.kind = TY_LIGHT_AREA;
        color = "radiance";
    } else {
        def.kind = strcmp(type, "spot") == 0 ? TY_LIGHT_SPOT : TY_LIGHT_POINT;
    }
    ty_read_rgb(light, color, def.color);
    ty_read_vector(light, "position", reader->unit, def.position);
    ty_read_number(light, "cone", &def.cone);
    ty_read_number(light, "penumbra", &def.penumbra);
    ty_read_number(light, "radius", &def.radius);
    def.radius *= reader->unit;
    const ty_result result = def.kind == TY_LIGHT_AREA
                                 ? ty_read_edges(reader, light, path, def.position, def.u, def.v)
                                 : ty_read_direction(reader, light, path, "direction", def.direction);
    return result == TY_OK ? add_light(reader, path, &def) : result;
}

ty_result ty_read_lights(ty_scene_reader* reader) {
    const ty_json_path root = {.depth = 0};
    const ty_json_path lights = ty_json_path_key(&root, "lights");
    size_t i;
    json_t* light;
    json_array_foreach(json_object_get(reader->root, "lights"), i, light) {
        const ty_json_path path = ty_json_path_index(&lights, i);
        const ty_result result = read_light(reader, light, &path);
        if (result != TY_OK) return result;
    }
    return TY_OK;
}

ty_result ty_read_sky_air(ty_scene_reader* reader) {
    const ty_json_path root = {.depth = 0};
    const ty_json_path lights = ty_json_path_key(&root, "lights");
    size_t i;
    json_t* light;
    ty_result result = TY_OK;
    json_array_foreach(json_object_get(reader->root, "lights"), i, light) {
        const json_t* sky = json_object_get(light, "sky");
        if (result != TY_OK || json_object_get(sky, "air") == NULL) continue;
        const ty_json_path light_path = ty_json_path_index(&lights, i);
        const ty_json_path path = ty_json_path_key(&light_path, "sky");
        ty_sky_def def = ty_default_sky_def();
        double lower[3], upper[3];
        ty_read_number(sky, "haze", &def.haze);
        result = ty_read_box(reader, sky, &path, "air", reader->unit, lower, upper);
        if (result == TY_OK)
            result = ty_reader_prefix_error(reader, &path, ty_scene_add_sky_air(reader->scene, &def, lower, upper));
    }
    return result;
}
