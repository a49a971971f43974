/* Light sources. Their spectra have the luminance 1, times scale, or such that the light has the power asked for
 * (section 12.1 of the book, and the documentation's "power" and "illuminance"). */
#include "base/constants.h"
#include "base/context.h"
#include "io/file.h"
#include "io/interchange/pbrt/pbrt.h"
#include "io/interchange/solids.h"
#include "io/json_text.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* The colour of `name` times scale. */
static ty_result read_colour(const ty_pbrt_parameters* parameters, const char* name, double rgb[3]) {
    bool found;
    rgb[0] = rgb[1] = rgb[2] = 1;
    const ty_result result = ty_pbrt_spectrum(parameters, name, TY_PBRT_LIGHT, rgb, &found);
    const double scale = ty_pbrt_float(parameters, "scale", 1);
    for (int c = 0; c < 3; ++c) rgb[c] *= scale;
    return result;
}

static void multiply(double rgb[3], double factor) {
    for (int c = 0; c < 3; ++c) rgb[c] *= factor;
}

static json_t* light_colour(const double rgb[3]) {
    return ty_conversion_colour(rgb, 0, 1e9);
}

/* from and to in light space, moved into the scene: a position and a direction. */
static void read_ends(ty_pbrt* reader, const ty_pbrt_parameters* parameters, double position[3], double direction[3]) {
    double from[3] = {0, 0, 0}, to[3] = {0, 0, 1}, axis[3];
    ty_pbrt_point(parameters, "from", from);
    ty_pbrt_point(parameters, "to", to);
    const ty_affine map = ty_pbrt_world(reader);
    for (int a = 0; a < 3; ++a) axis[a] = to[a] - from[a];
    ty_affine_point(&map, from, position);
    ty_affine_direction(&map, axis, direction);
}

static ty_result read_point(ty_pbrt* reader, const ty_pbrt_parameters* parameters) {
    double rgb[3], position[3], from[3] = {0, 0, 0};
    const ty_result result = read_colour(parameters, "I", rgb);
    if (result != TY_OK) return result;
    const double power = ty_pbrt_float(parameters, "power", -1);
    if (power > 0) multiply(rgb, power / (4 * TY_PI_F64));
    const ty_affine map = ty_pbrt_world(reader);
    ty_pbrt_point(parameters, "from", from);
    ty_affine_point(&map, from, position);
    return ty_conversion_add_light(reader->conversion,
                                   json_pack("{s:s, s:o, s:o}", "type", "point", "position",
                                             ty_conversion_vector(position, 3), "intensity", light_colour(rgb)));
}

static ty_result read_spot(ty_pbrt* reader, const ty_pbrt_parameters* parameters) {
    double rgb[3], position[3], direction[3];
    const ty_result result = read_colour(parameters, "I", rgb);
    if (result != TY_OK) return result;
    read_ends(reader, parameters, position, direction);
    const double cone = fmin(fmax(ty_pbrt_float(parameters, "coneangle", 30), 1e-3), 90);
    const double delta = fmin(fmax(ty_pbrt_float(parameters, "conedeltaangle", 5), 0), cone);
    const double power = ty_pbrt_float(parameters, "power", -1);
    const double outer = cos(cone * TY_PI_F64 / 180), inner = cos((cone - delta) * TY_PI_F64 / 180);
    if (power > 0) multiply(rgb, power / (2 * TY_PI_F64 * ((1 - inner) + (inner - outer) / 2)));
    return ty_conversion_add_light(reader->conversion,
                                   json_pack("{s:s, s:o, s:o, s:o, s:o, s:o}", "type", "spot", "position",
                                             ty_conversion_vector(position, 3), "direction",
                                             ty_conversion_vector(direction, 3), "intensity", light_colour(rgb), "cone",
                                             ty_json_number(2 * cone), "penumbra", ty_json_number(delta / cone)));
}

static ty_result read_distant(ty_pbrt* reader, const ty_pbrt_parameters* parameters) {
    double rgb[3], position[3], direction[3];
    const ty_result result = read_colour(parameters, "L", rgb);
    if (result != TY_OK) return result;
    read_ends(reader, parameters, position, direction);
    const double illuminance = ty_pbrt_float(parameters, "illuminance", -1);
    if (illuminance > 0) multiply(rgb, illuminance);
    return ty_conversion_add_light(reader->conversion,
                                   json_pack("{s:s, s:o, s:o}", "type", "directional", "direction",
                                             ty_conversion_vector(direction, 3), "irradiance", light_colour(rgb)));
}

static ty_result read_map(ty_pbrt* reader, const ty_pbrt_parameters* parameters, const char* name) {
    char location[512];
    char* reference = NULL;
    double illuminance = 0;
    ty_pbrt_location(reader, parameters->file, parameters->line, location, sizeof location);
    const ty_affine map = ty_pbrt_world(reader);
    double scale = ty_pbrt_float(parameters, "scale", 1);
    const ty_result result = ty_pbrt_environment(reader, location, name, &map, &illuminance, &reference);
    if (result != TY_OK || reference == NULL) return result;
    const double asked = ty_pbrt_float(parameters, "illuminance", -1);
    if (asked > 0 && illuminance > 0) scale *= asked / illuminance;
    json_t* light = json_pack("{s:s, s:s, s:o}", "type", "environment", "file", reference, "scale",
                              ty_json_number(fmin(fmax(scale, 0), 1e6)));
    ty_free_text(reader->context, reference);
    return ty_conversion_add_light(reader->conversion, light);
}

static ty_result read_infinite(ty_pbrt* reader, const ty_pbrt_parameters* parameters) {
    char name[1024];
    if (ty_pbrt_find(parameters, "portal") != NULL)
        ty_conversion_leave_out(reader->conversion,
                                "LightSource \"infinite\": its portal, so it shines from all sides");
    if (ty_pbrt_string(parameters, "filename", name, sizeof name)) return read_map(reader, parameters, name);
    double rgb[3];
    const ty_result result = read_colour(parameters, "L", rgb);
    if (result != TY_OK) return result;
    const double illuminance = ty_pbrt_float(parameters, "illuminance", -1);
    if (illuminance > 0) multiply(rgb, illuminance / TY_PI_F64);
    return ty_conversion_add_light(reader->conversion,
                                   json_pack("{s:s, s:o}", "type", "environment", "radiance", light_colour(rgb)));
}

ty_result ty_pbrt_light(ty_pbrt* reader, const ty_pbrt_parameters* parameters) {
    const int32_t medium = ty_pbrt_now(reader)->outside;
    if (medium >= 0) reader->conversion->media[medium].outside = true;
    if (strcmp(parameters->type, "point") == 0) return read_point(reader, parameters);
    if (strcmp(parameters->type, "spot") == 0) return read_spot(reader, parameters);
    if (strcmp(parameters->type, "distant") == 0) return read_distant(reader, parameters);
    if (strcmp(parameters->type, "infinite") == 0) return read_infinite(reader, parameters);
    if (strcmp(parameters->type, "goniometric") != 0 && strcmp(parameters->type, "projection") != 0)
        return ty_pbrt_refuse(parameters, "the light \"%s\" is not known", parameters->type);
    ty_conversion_leave_out(reader->conversion, "LightSource \"%s\"", parameters->type);
    for (size_t i = 0; i < parameters->count; ++i) parameters->items[i].used = true;
    return TY_OK;
}

ty_result ty_pbrt_area(ty_pbrt* reader, const ty_pbrt_parameters* parameters) {
    char name[1024];
    if (strcmp(parameters->type, "diffuse") != 0)
        return ty_pbrt_refuse(parameters, "the area light \"%s\" is not known", parameters->type);
    ty_pbrt_area_light* area = &ty_pbrt_now(reader)->area;
    area->on = true;
    area->two_sided = ty_pbrt_bool(parameters, "twosided", false);
    area->power = fmax(ty_pbrt_float(parameters, "power", 0), 0);
    if (ty_pbrt_string(parameters, "filename", name, sizeof name))
        ty_conversion_leave_out(reader->conversion, "AreaLightSource: the image \"%s\": the light is white", name);
    return read_colour(parameters, "L", area->radiance);
}
