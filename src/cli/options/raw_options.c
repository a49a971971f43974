/* Options for the layout of a raw volume, and of droplets in a NetCDF file. */
#include "cli/options/raw_options.h"
#include "cli/options/options.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Parses "A,B,C" into numbers in (0, upper]. */
static bool parse_triple(const char* text, double upper, double out[3]) {
    for (int a = 0; a < 3; ++a) {
        char* end;
        out[a] = strtod(text, &end);
        if (end == text || *end != (a < 2 ? ',' : '\0') || !(out[a] > 0 && out[a] <= upper)) return false;
        text = end + 1;
    }
    return true;
}

static bool is_whole(const double numbers[3]) {
    return numbers[0] == floor(numbers[0]) && numbers[1] == floor(numbers[1]) && numbers[2] == floor(numbers[2]);
}

int cli_parse_raw(const char* command, const char* size, const char* type, const char* spacing, ty_volume_def* def) {
    double sides[3];
    if (size != NULL) {
        if (!parse_triple(size, 16384, sides) || !is_whole(sides))
            return cli_usage_error(command, "--raw-size: '%s' is not X,Y,Z from 1 to 16384", size);
        for (int a = 0; a < 3; ++a) def->raw_size[a] = (int32_t)sides[a];
    }
    if (spacing != NULL && !parse_triple(spacing, 1e15, def->raw_spacing))
        return cli_usage_error(command, "--raw-spacing: '%s' is not X,Y,Z above 0", spacing);
    if (type == NULL) return CLI_GO;
    if (strlen(type) >= sizeof def->raw_type)
        return cli_usage_error(command, "--raw-type: '%s' is not int8, uint8 ... uint64, half, float or double", type);
    memcpy(def->raw_type, type, strlen(type) + 1);
    return CLI_GO;
}

/* A number up to `max`, or else a name. */
static bool parse_companion(const char* text, double max, double* number, const char** name) {
    char* end;
    const double value = strtod(text, &end);
    if (end == text || *end != '\0') {
        *name = text;
        return text[0] != '\0';
    }
    *number = value;
    return value > 0 && value <= max;
}

int cli_parse_droplets(const char* command, const char* radius, const char* air, ty_volume_def* def) {
    if (radius != NULL && !parse_companion(radius, 1e4, &def->droplet_radius, &def->effective_radius))
        return cli_usage_error(command, "--effective-radius: '%s' is neither a name nor from 0 to 1e4 micrometres",
                               radius);
    if (air != NULL && radius == NULL) return cli_usage_error(command, "--air-density goes with --effective-radius");
    if (air != NULL && !parse_companion(air, 1e3, &def->air_density_value, &def->air_density))
        return cli_usage_error(command, "--air-density: '%s' is neither a name nor from 0 to 1000 kg/m3", air);
    return CLI_GO;
}
