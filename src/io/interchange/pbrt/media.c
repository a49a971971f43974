/* Participating media. Coefficients are per unit of length, which counts as a metre. */
#include "base/context.h"
#include "io/file.h"
#include "io/interchange/blackbody_grid.h"
#include "io/interchange/pbrt/pbrt.h"
#include "io/json_text.h"

#include <float.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

/* A medium that is being read. */
typedef struct maker {
    ty_pbrt* reader;
    const ty_pbrt_parameters* parameters;
    ty_conversion_medium medium;
    double sigma_a[3], sigma_s[3];
} maker;

/* Adds an entry, which is taken over. */
static ty_result add_entry(maker* m, json_t* entry) {
    if (json_object_set_new(entry, "name", json_string(m->medium.name)) == 0 &&
        json_array_append_new(m->medium.entries, entry) == 0)
        return TY_OK;
    return ty_conversion_no_memory(m->reader->conversion);
}

static json_t* asymmetry(const maker* m) {
    return ty_json_number(fmin(fmax(ty_pbrt_float(m->parameters, "g", 0), -0.9999), 0.9999));
}

static ty_result read_coefficients(maker* m) {
    char preset[TY_PBRT_NAME_SIZE];
    bool found;
    for (int c = 0; c < 3; ++c) m->sigma_a[c] = m->sigma_s[c] = 1;
    if (ty_pbrt_string(m->parameters, "preset", preset, sizeof preset)) {
        ty_medium_def def = ty_default_medium_def();
        if (!ty_medium_preset(preset, &def)) {
            ty_conversion_approximate(m->reader->conversion, "the medium \"%s\" is not known", preset);
        } else {
            /* The same measurements, which are in 1/mm there. */
            for (int c = 0; c < 3; ++c) {
                m->sigma_a[c] = (double)def.sigma_a[c] / 1000;
                m->sigma_s[c] = (double)def.sigma_s[c] / 1000;
            }
        }
    }
    ty_result result = ty_pbrt_spectrum(m->parameters, "sigma_a", TY_PBRT_REFLECTANCE, m->sigma_a, &found);
    if (result == TY_OK) result = ty_pbrt_spectrum(m->parameters, "sigma_s", TY_PBRT_REFLECTANCE, m->sigma_s, &found);
    const double scale = ty_pbrt_float(m->parameters, "scale", 1);
    for (int c = 0; c < 3; ++c) {
        m->sigma_a[c] *= scale;
        m->sigma_s[c] *= scale;
    }
    return result;
}

/* An entry with the coefficients, and emission of constant radiance if there is some. */
static json_t* make_entry(const maker* m, const double radiance[3]) {
    json_t* entry = json_pack("{s:o, s:o, s:o}", "sigma_s", ty_conversion_colour(m->sigma_s, 0, 1e9), "sigma_a",
                              ty_conversion_colour(m->sigma_a, 0, 1e9), "g", asymmetry(m));
    if (radiance[0] > 0 || radiance[1] > 0 || radiance[2] > 0)
        json_object_set_new(entry, "emission", json_pack("{s:o}", "radiance", ty_conversion_colour(radiance, 0, 1e9)));
    return entry;
}

/* Le times a scale; black without. */
static ty_result read_emission(maker* m, double scale, double radiance[3]) {
    bool found;
    const ty_result result = ty_pbrt_spectrum(m->parameters, "Le", TY_PBRT_LIGHT, radiance, &found);
    for (int c = 0; c < 3; ++c) radiance[c] = found ? radiance[c] * scale : 0;
    return result;
}

static ty_result read_homogeneous(maker* m) {
    double radiance[3] = {0, 0, 0};
    ty_result result = read_coefficients(m);
    if (result == TY_OK) result = read_emission(m, ty_pbrt_float(m->parameters, "Lescale", 1), radiance);
    return result == TY_OK ? add_entry(m, make_entry(m, radiance)) : result;
}

/* ---- grids ---- */

static ty_result read_size(maker* m, size_t count, int32_t size[3]) {
    static const char* const names[3] = {"nx", "ny", "nz"};
    double product = 1;
    for (int a = 0; a < 3; ++a) {
        size[a] = ty_pbrt_int(m->parameters, names[a], 1);
        if (size[a] < 1 || size[a] > 16384)
            return ty_pbrt_refuse(m->parameters, "%s: %d is outside 1..16384", names[a], (int)size[a]);
        product *= size[a];
    }
    if (product != (double)count)
        return ty_pbrt_refuse(m->parameters, "the medium \"%s\" has %zu values, not nx ny nz = %.0f", m->medium.name,
                              count, product);
    return TY_OK;
}

static ty_result read_box(maker* m) {
    static const double unit[2][3] = {{0, 0, 0}, {1, 1, 1}};
    memcpy(m->medium.box, unit, sizeof unit);
    ty_pbrt_point(m->parameters, "p0", m->medium.box[0]);
    ty_pbrt_point(m->parameters, "p1", m->medium.box[1]);
    for (int a = 0; a < 3; ++a)
        if (!(m->medium.box[1][a] > m->medium.box[0][a]))
            return ty_pbrt_refuse(m->parameters, "the medium \"%s\" has p1 not above p0", m->medium.name);
    m->medium.grid = m->medium.clipped = true;
    return TY_OK;
}

/* A plane of every `stride`th number; freed with ty_free_array. */
static float* make_plane(maker* m, const double* numbers, size_t stride, size_t count, double factor) {
    float* plane = ty_alloc_array(m->reader->context, count, sizeof *plane, false);
    for (size_t i = 0; i < count && plane != NULL; ++i) plane[i] = (float)fmax(factor * numbers[i * stride], 0);
    return plane;
}

/* Writes one plane as a volume and refers to it under a key of the entry. */
static ty_result set_volume(maker* m, json_t* entry, const char* key, const char* grid, const int32_t size[3],
                            const float* plane) {
    char* reference = NULL;
    const float* const planes[3] = {plane, NULL, NULL};
    const ty_result result = ty_conversion_write_volume(m->reader->conversion, grid, size, planes, 1,
                                                        (const double(*)[3])m->medium.box, &reference);
    if (result != TY_OK) return result;
    json_t* value = json_pack("{s:s, s:s}", "file", reference != NULL ? reference : "", "grid", grid);
    ty_free_text(m->reader->context, reference);
    return ty_conversion_set(m->reader->conversion, entry, key, value);
}

/* Emission by temperatures, as black bodies whose largest spectral radiance is Lescale; plane is changed. */
static ty_result set_temperature(maker* m, json_t* entry, const int32_t size[3], float* plane, double scale) {
    char* reference = NULL;
    double factor = 0;
    const size_t count = (size_t)size[0] * (size_t)size[1] * (size_t)size[2];
    const double offset =
        ty_pbrt_float(m->parameters, "temperatureoffset", ty_pbrt_float(m->parameters, "temperaturecutoff", 0));
    const double slope = ty_pbrt_float(m->parameters, "temperaturescale", 1);
    for (size_t i = 0; i < count; ++i) plane[i] = (float)(((double)plane[i] - offset) * slope);
    if (!ty_normalize_temperatures(plane, count, scale, &factor)) return TY_OK;
    ty_conversion_approximate(
        m->reader->conversion,
        "medium \"%s\": temperatures were replaced by those that emit the luminance of pbrt's normalized black bodies",
        m->medium.name);
    const float* const planes[3] = {plane, NULL, NULL};
    const ty_result result = ty_conversion_write_volume(m->reader->conversion, "temperature", size, planes, 1,
                                                        (const double(*)[3])m->medium.box, &reference);
    if (result != TY_OK) return result;
    json_t* emission = json_pack("{s:{s:s, s:s}, s:o}", "temperature", "file", reference != NULL ? reference : "",
                                 "grid", "temperature", "scale", ty_json_number(fmin(factor, 1e6)));
    ty_free_text(m->reader->context, reference);
    return ty_conversion_set(m->reader->conversion, entry, "emission", emission);
}

/* The scale of Le, which may be a grid: its mean, if that is not constant. */
static double read_emission_scale(maker* m) {
    const ty_pbrt_parameter* scale = ty_pbrt_find(m->parameters, "Lescale");
    double sum = 0, low = DBL_MAX, high = -DBL_MAX;
    if (scale == NULL || scale->number_count == 0) return 1;
    for (size_t i = 0; i < scale->number_count; ++i) {
        sum += scale->numbers[i];
        low = fmin(low, scale->numbers[i]);
        high = fmax(high, scale->numbers[i]);
    }
    if (high > low)
        ty_conversion_approximate(m->reader->conversion, "medium \"%s\": the grid of Lescale became its mean",
                                  m->medium.name);
    return sum / (double)scale->number_count;
}

static ty_result read_uniform_grid(maker* m) {
    const ty_pbrt_parameter *density = ty_pbrt_find(m->parameters, "density"),
                            *temperature = ty_pbrt_find(m->parameters, "temperature");
    double radiance[3] = {0, 0, 0};
    int32_t size[3];
    if (density == NULL || density->number_count == 0)
        return ty_pbrt_refuse(m->parameters, "the medium \"%s\" has no \"float density\"", m->medium.name);
    const size_t count = density->number_count;
    ty_result result = read_size(m, count, size);
    if (result == TY_OK) result = read_box(m);
    if (result == TY_OK) result = read_coefficients(m);
    const double scale = read_emission_scale(m);
    if (result == TY_OK) result = read_emission(m, scale, radiance);
    if (result != TY_OK) return result;
    json_t* entry = make_entry(m, radiance);
    float* plane = make_plane(m, density->numbers, 1, count, 1);
    result = plane == NULL ? TY_ERROR_MEMORY : set_volume(m, entry, "density", "density", size, plane);
    ty_free_array(m->reader->context, plane, count, sizeof *plane);
    if (result == TY_OK && temperature != NULL && temperature->number_count == count) {
        plane = make_plane(m, temperature->numbers, 1, count, 1);
        result = plane == NULL ? TY_ERROR_MEMORY : set_temperature(m, entry, size, plane, scale);
        ty_free_array(m->reader->context, plane, count, sizeof *plane);
    }
    if (result == TY_OK) return add_entry(m, entry);
    json_decref(entry);
    return result;
}

/* One channel of one coefficient, or all channels if they are alike (channel -1), as a medium of its own: coefficients
 * of overlapping media add up, and each is interpolated as pbrt does. */
static ty_result add_channel(maker* m, const char* key, const double* numbers, size_t count, const int32_t size[3],
                             int channel, double scale) {
    ty_context* context = m->reader->context;
    float* plane = make_plane(m, numbers + (channel < 0 ? 0 : channel), 3, count, scale);
    if (plane == NULL) return TY_ERROR_MEMORY;
    float highest = 0;
    for (size_t i = 0; i < count; ++i) highest = fmaxf(highest, plane[i]);
    ty_result result = TY_OK;
    json_t* entry = NULL;
    if (highest > 0) {
        double unit[3] = {channel < 0, channel < 0, channel < 0};
        if (channel >= 0) unit[channel] = 1;
        entry = json_pack("{s:o, s:o}", key, ty_conversion_colour(unit, 0, 1), "g", asymmetry(m));
        result = set_volume(m, entry, "density", "density", size, plane);
    }
    ty_free_array(context, plane, count, sizeof *plane);
    if (result == TY_OK && entry != NULL) return add_entry(m, entry);
    json_decref(entry);
    return result;
}

/* A coefficient on a grid; without one it is 1 throughout the box. */
static ty_result add_coefficient(maker* m, const char* key, const double* numbers, size_t count, const int32_t size[3],
                                 double scale) {
    if (numbers == NULL) return add_entry(m, json_pack("{s:o, s:o}", key, ty_json_number(scale), "g", asymmetry(m)));
    bool grey = true;
    for (size_t i = 0; i < count && grey; ++i)
        grey = numbers[3 * i] == numbers[3 * i + 1] && numbers[3 * i] == numbers[3 * i + 2];
    if (grey) return add_channel(m, key, numbers, count, size, -1, scale);
    ty_result result = TY_OK;
    for (int c = 0; c < 3 && result == TY_OK; ++c) result = add_channel(m, key, numbers, count, size, c, scale);
    return result;
}

static ty_result read_rgb_grid(maker* m) {
    const ty_pbrt_parameter *absorption = ty_pbrt_find(m->parameters, "sigma_a"),
                            *scattering = ty_pbrt_find(m->parameters, "sigma_s");
    int32_t size[3];
    const ty_pbrt_parameter* any = absorption != NULL ? absorption : scattering;
    if (any == NULL || any->type != TY_PBRT_RGB)
        return ty_pbrt_refuse(m->parameters, "the medium \"%s\" has no \"rgb sigma_a\" or \"rgb sigma_s\"",
                              m->medium.name);
    if (absorption != NULL && scattering != NULL && absorption->number_count != scattering->number_count)
        return ty_pbrt_refuse(m->parameters, "the medium \"%s\" has different numbers of sigma_a and sigma_s",
                              m->medium.name);
    if (ty_pbrt_find(m->parameters, "Le") != NULL)
        ty_conversion_leave_out(m->reader->conversion, "medium \"%s\": its grid of emission", m->medium.name);
    ty_pbrt_find(m->parameters, "Lescale");
    const size_t count = any->number_count / 3;
    ty_result result = read_size(m, count, size);
    if (result == TY_OK) result = read_box(m);
    const double scale = ty_pbrt_float(m->parameters, "scale", 1);
    if (result == TY_OK)
        result = add_coefficient(m, "sigma_s", scattering != NULL ? scattering->numbers : NULL, count, size, scale);
    if (result == TY_OK)
        result = add_coefficient(m, "sigma_a", absorption != NULL ? absorption->numbers : NULL, count, size, scale);
    return result;
}

/* ---- files ---- */

static void grid_box(const ty_grid* grid, double box[2][3]) {
    const ty_grid_info info = ty_grid_get_info(grid);
    for (int a = 0; a < 3; ++a) {
        box[0][a] = DBL_MAX;
        box[1][a] = -DBL_MAX;
    }
    for (int i = 0; i < 8; ++i) {
        double corner[3], point[3];
        for (int a = 0; a < 3; ++a) corner[a] = (i >> a & 1) != 0 ? info.size[a] - 0.5 : -0.5;
        ty_affine_point(&info.index_to_local, corner, point);
        for (int a = 0; a < 3; ++a) {
            box[0][a] = fmin(box[0][a], point[a]);
            box[1][a] = fmax(box[1][a], point[a]);
        }
    }
}

static bool has_grid(ty_context* context, const char* path, const char* name) {
    ty_vdb_entry entries[16];
    int32_t count = 0;
    if (ty_vdb_list(context, path, entries, 16, &count) != TY_OK) return false;
    for (int32_t i = 0; i < count && i < 16; ++i)
        if (strcmp(entries[i].name, name) == 0) return true;
    return false;
}

/* Lescale, which older files spell LeScale. */
static double file_scale(const maker* m) {
    return ty_pbrt_float(m->parameters, "Lescale", ty_pbrt_float(m->parameters, "LeScale", 1));
}

/* The name of a grid that a parameter may give. */
static void read_grid_name(const maker* m, const char* parameter, const char* otherwise, char out[TY_PBRT_NAME_SIZE]) {
    if (!ty_pbrt_string(m->parameters, parameter, out, TY_PBRT_NAME_SIZE))
        snprintf(out, TY_PBRT_NAME_SIZE, "%s", otherwise);
}

/* Temperatures of a file, replaced by those that emit as pbrt has it, as a new volume with the same place. */
static ty_result add_file_temperature(maker* m, const char* path, const char* name, json_t* entry) {
    ty_context* context = m->reader->context;
    ty_volume_def def = ty_default_volume_def();
    ty_grid* grid = NULL;
    def.grid = name;
    ty_result result = ty_volume_read(context, path, &def, &grid);
    if (result != TY_OK) return result;
    const ty_grid_info info = ty_grid_get_info(grid);
    const size_t count = (size_t)info.size[0] * (size_t)info.size[1] * (size_t)info.size[2];
    float* plane = ty_alloc_array(context, count, sizeof *plane, false);
    size_t at = 0;
    for (int32_t k = 0; k < info.size[2] && plane != NULL; ++k)
        for (int32_t j = 0; j < info.size[1]; ++j)
            for (int32_t i = 0; i < info.size[0]; ++i) plane[at++] = ty_grid_voxel(grid, i, j, k);
    double box[2][3];
    memcpy(box, m->medium.box, sizeof box);
    grid_box(grid, m->medium.box); /* VDB files of renderers are not rotated */
    result = plane == NULL ? TY_ERROR_MEMORY : set_temperature(m, entry, info.size, plane, file_scale(m));
    memcpy(m->medium.box, box, sizeof box);
    ty_free_array(context, plane, count, sizeof *plane);
    ty_grid_release(grid);
    return result;
}

static ty_result add_file(maker* m, const char* path, const char* reference) {
    ty_context* context = m->reader->context;
    static const double dark[3] = {0, 0, 0};
    ty_volume_def def = ty_default_volume_def();
    ty_grid* grid = NULL;
    char name[TY_PBRT_NAME_SIZE], heat[TY_PBRT_NAME_SIZE];
    read_grid_name(m, "gridname", "density", name);
    read_grid_name(m, "temperaturename", "temperature", heat);
    def.grid = name;
    ty_result result = ty_volume_read(context, path, &def, &grid);
    if (result != TY_OK) return result;
    grid_box(grid, m->medium.box);
    ty_grid_release(grid);
    m->medium.grid = true;
    json_t* entry = make_entry(m, dark);
    json_t* density = json_pack("{s:s, s:s}", "file", reference, "grid", name);
    result = ty_conversion_set(m->reader->conversion, entry, "density", density);
    if (result == TY_OK && has_grid(context, path, heat)) result = add_file_temperature(m, path, heat, entry);
    if (result == TY_OK) return add_entry(m, entry);
    json_decref(entry);
    return result;
}

static ty_result read_nanovdb(maker* m) {
    char name[1024], location[512];
    char *path = NULL, *reference = NULL;
    static const char* const ignored[] = {"Lescale",          "LeScale",  "temperatureoffset", "temperaturecutoff",
                                          "temperaturescale", "gridname", "temperaturename"};
    for (size_t i = 0; i < sizeof ignored / sizeof ignored[0]; ++i) ty_pbrt_find(m->parameters, ignored[i]);
    if (!ty_pbrt_string(m->parameters, "filename", name, sizeof name))
        return ty_pbrt_refuse(m->parameters, "the medium \"%s\" has no \"string filename\"", m->medium.name);
    ty_result result = read_coefficients(m);
    ty_pbrt_float(m->parameters, "g", 0);
    ty_pbrt_location(m->reader, m->parameters->file, m->parameters->line, location, sizeof location);
    if (result == TY_OK) result = ty_conversion_find_file(m->reader->conversion, location, name, &path, &reference);
    if (result == TY_OK && path != NULL) result = add_file(m, path, reference);
    ty_free_text(m->reader->context, path);
    ty_free_text(m->reader->context, reference);
    return result;
}

static ty_result leave_out(maker* m) {
    ty_conversion_leave_out(m->reader->conversion, "medium \"%s\": it is a \"%s\", which is procedural", m->medium.name,
                            m->parameters->type);
    for (size_t i = 0; i < m->parameters->count; ++i) m->parameters->items[i].used = true;
    return TY_OK;
}

static const struct {
    const char* type;
    ty_result (*read)(maker* m);
} readers[] = {{"homogeneous", read_homogeneous},
               {"uniformgrid", read_uniform_grid},
               {"rgbgrid", read_rgb_grid},
               {"nanovdb", read_nanovdb},
               {"cloud", leave_out}};

ty_result ty_pbrt_medium(ty_pbrt* reader, const ty_pbrt_parameters* parameters, const char* name) {
    maker m = {.reader = reader, .parameters = parameters, .medium = {.transform = ty_pbrt_world(reader)}};
    int32_t index;
    char text[TY_PBRT_NAME_SIZE];
    snprintf(text, sizeof text, "%s", name);
    for (char* at = text; *at != '\0'; ++at)
        if (*at < ' ' || *at > '~') *at = '?';
    m.medium.name = ty_copy_text(reader->context, text);
    m.medium.entries = json_array();
    ty_result result =
        m.medium.name == NULL || m.medium.entries == NULL ? ty_conversion_no_memory(reader->conversion) : TY_OK;
    size_t i = 0;
    while (i < sizeof readers / sizeof readers[0] && strcmp(readers[i].type, parameters->type) != 0) ++i;
    if (i == sizeof readers / sizeof readers[0])
        result = ty_pbrt_refuse(parameters, "the medium \"%s\" has the type \"%s\", which is not known", name,
                                parameters->type);
    if (result == TY_OK) result = readers[i].read(&m);
    if (result == TY_OK) return ty_conversion_add_medium(reader->conversion, &m.medium, &index);
    ty_free_text(reader->context, m.medium.name);
    json_decref(m.medium.entries);
    return result;
}
