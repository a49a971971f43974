/* Heterogeneous properties of a scene file's media, and their emission. */
#include "io/scenes/scene_reader.h"
#include "io/schema_text.h"

static bool has_albedo(const json_t* point) {
    return json_object_get(point, "albedo") != NULL;
}

bool ty_transfer_has_albedo(const json_t* medium) {
    return has_albedo(json_array_get(json_object_get(medium, "transfer"), 0));
}

static ty_result fail_order(const ty_scene_reader* reader, const json_t* points, size_t i, const ty_json_path* path) {
    char text[128] = "";
    ty_append_value(text, sizeof text, json_object_get(json_array_get(points, i), "value"));
    ty_append(text, sizeof text, " is not above the value of the point before, ");
    ty_append_value(text, sizeof text, json_object_get(json_array_get(points, i - 1), "value"));
    const ty_json_path json_path = ty_json_path_key(path, "value");
    return ty_reader_fail(reader, &json_path, TY_ERROR_INPUT, "%s", text);
}

static ty_result read_transfer(const ty_scene_reader* reader, const json_t* medium, const ty_json_path* path,
                               ty_medium_def* def, ty_transfer_point* points) {
    const json_t* transfer = json_object_get(medium, "transfer");
    if (transfer == NULL) return TY_OK;
    const ty_json_path json_path = ty_json_path_key(path, "transfer");
    if (!json_is_object(json_object_get(medium, "density")))
        return ty_reader_fail(reader, &json_path, TY_ERROR_INPUT,
                              "there is nothing to look it up with; \"density\" must be a volume or noise");
    def->transfer = points;
    def->transfer_count = (int32_t)json_array_size(transfer);
    def->transfer_albedo = ty_transfer_has_albedo(medium);
    size_t i;
    json_t* point;
    json_array_foreach(transfer, i, point) {
        const ty_json_path here = ty_json_path_index(&json_path, i);
        if (has_albedo(point) != def->transfer_albedo)
            return ty_reader_fail(reader, &here, TY_ERROR_INPUT, "give \"albedo\" in all points or in none");
        points[i] = (ty_transfer_point){.value = 0};
        ty_read_float(point, "value", &points[i].value);
        ty_read_float(point, "density", &points[i].density);
        ty_read_rgb(point, "albedo", points[i].albedo);
        if (i > 0 && !(points[i].value > points[i - 1].value)) return fail_order(reader, transfer, i, &here);
    }
    return TY_OK;
}

static ty_result read_emission(ty_scene_reader* reader, const json_t* emission, const ty_json_path* path,
                               ty_medium_def* def) {
    ty_read_rgb(emission, "radiance", def->emission);
    const json_t* temperature = json_object_get(emission, "temperature");
    if (temperature == NULL) return TY_OK;
    const json_t* kelvin = json_object_get(emission, "kelvin");
    for (size_t i = 0; i < 2 && kelvin != NULL; ++i) def->kelvin[i] = json_number_value(json_array_get(kelvin, i));
    ty_read_float(emission, "scale", &def->emission_scale);
    const ty_json_path json_path = ty_json_path_key(path, "temperature");
    return ty_read_volume(reader, temperature, &json_path, "temperature", def->bounds == TY_BOUNDS_BOX,
                          &def->temperature_grid);
}

ty_result ty_read_fields(ty_scene_reader* reader, const json_t* medium, const ty_json_path* path, ty_medium_def* def,
                         ty_transfer_point* points) {
    const json_t* albedo = json_object_get(medium, "albedo");
    const json_t* g = json_object_get(medium, "g");
    const json_t* emission = json_object_get(medium, "emission");
    const bool filling = def->bounds == TY_BOUNDS_BOX;
    ty_result result = read_transfer(reader, medium, path, def, points);
    if (result == TY_OK && json_is_object(albedo)) {
        const ty_json_path json_path = ty_json_path_key(path, "albedo");
        result = ty_read_volume_rgb(reader, albedo, &json_path, "albedo", filling, def->albedo_grid);
    }
    if (result == TY_OK && json_is_object(g)) {
        const ty_json_path json_path = ty_json_path_key(path, "g");
        result = ty_read_volume(reader, g, &json_path, "g", filling, &def->g_grid);
    }
    if (result == TY_OK && emission != NULL) {
        const ty_json_path json_path = ty_json_path_key(path, "emission");
        result = read_emission(reader, emission, &json_path, def);
    }
    return result;
}
