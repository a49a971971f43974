/* Phase functions of media, in scene files and as short text. */
#include "io/phase_file.h"
#include "io/scenes/scene_reader.h"
#include "scene/media/phase.h"

#include <string.h>

static ty_result read_table(const ty_scene_reader* reader, const json_t* phase, const ty_json_path* path,
                            ty_phase_lobe* lobe, ty_phase_table* table) {
    const json_t* angles = json_object_get(phase, "angles");
    const json_t *nodes = angles != NULL ? angles : json_object_get(phase, "cosines"),
                 *values = json_object_get(phase, "values");
    const size_t count = json_array_size(nodes);
    if (json_array_size(values) != count) {
        const ty_json_path key = ty_json_path_key(path, "values");
        return ty_reader_fail(reader, &key, TY_ERROR_INPUT, "%zu values do not go with %zu %s", json_array_size(values),
                              count, angles != NULL ? "angles" : "cosines");
    }
    for (size_t i = 0; i < count; ++i) {
        const double node = json_number_value(json_array_get(nodes, i));
        table->cosines[i] = angles != NULL ? ty_phase_cosine(node) : node;
        table->values[i] = json_number_value(json_array_get(values, i));
    }
    lobe->kind = TY_PHASE_TABLE;
    lobe->cosines = table->cosines;
    lobe->values = table->values;
    lobe->count = (int32_t)count;
    return TY_OK;
}

static ty_result read_file(ty_scene_reader* reader, const json_t* phase, const ty_json_path* path, ty_phase_lobe* lobe,
                           ty_phase_table* table) {
    static const char* const contents[] = {"angles", "cosines", "moments", "coefficients", "shdom"};
    const char* content = json_string_value(json_object_get(phase, "content"));
    const ty_json_path key = ty_json_path_key(path, "file");
    const ty_asset_file* file = NULL;
    double radius = 0;
    int chosen = 0;
    while (content != NULL && strcmp(content, contents[chosen]) != 0) ++chosen;
    ty_read_number(phase, "effective_radius", &radius);
    ty_result result = ty_find_file(reader, &key, json_string_value(json_object_get(phase, "file")), &file);
    if (result != TY_OK) return result;
    lobe->kind = TY_PHASE_TABLE;
    lobe->cosines = table->cosines;
    lobe->values = table->values;
    result = ty_phase_file_read(reader->context, file->path, (ty_phase_content)chosen, radius, table->cosines,
                                table->values, &lobe->count);
    return ty_reader_prefix_error(reader, &key, result);
}

static void read_lobe(const json_t* object, ty_phase_lobe* lobe) {
    double weight = 1;
    ty_read_number(object, "weight", &weight);
    for (int c = 0; c < 3; ++c) lobe->weight[c] = (float)weight;
    ty_read_number(object, "g", &lobe->g);
    ty_read_number(object, "alpha", &lobe->alpha);
    ty_read_number(object, "diameter", &lobe->diameter);
    ty_read_number(object, "n", &lobe->n);
    ty_read_number(object, "mu", &lobe->mu);
    ty_read_number(object, "backscatter", &lobe->backscatter);
}

ty_result ty_read_phase(ty_scene_reader* reader, const json_t* medium, const ty_json_path* path, ty_medium_def* def,
                        ty_phase_table* table) {
    const json_t* phase = json_object_get(medium, "phase");
    if (phase == NULL) return TY_OK;
    const ty_json_path json_path = ty_json_path_key(path, "phase");
    if (json_object_get(medium, "g") != NULL)
        return ty_reader_fail(reader, &json_path, TY_ERROR_INPUT, "does not go with \"g\"; give one of them");
    const char* type = json_string_value(json_object_get(phase, "type"));
    const json_t* lobes = json_object_get(phase, "lobes");
    memset(def->phase, 0, sizeof def->phase);
    memset(def->g, 0, sizeof def->g);
    def->phase_count = lobes != NULL ? (int32_t)json_array_size(lobes) : 1;
    for (int32_t i = 0; i < def->phase_count; ++i)
        read_lobe(lobes != NULL ? json_array_get(lobes, (size_t)i) : phase, &def->phase[i]);
    ty_phase_lobe* first = &def->phase[0];
    if (strcmp(type, "hg") == 0) {
        for (int c = 0; c < 3; ++c) def->g[c] = (float)first->g;
        def->phase_count = 0;
        return TY_OK;
    }
    if (strcmp(type, "rayleigh") == 0) first->alpha = 1;
    if (strcmp(type, "mie") == 0) first->kind = TY_PHASE_MIE;
    if (strcmp(type, "fournier_forand") == 0) first->kind = TY_PHASE_FOURNIER_FORAND;
    ty_result result = TY_OK;
    if (json_object_get(phase, "file") != NULL)
        result = read_file(reader, phase, &json_path, first, table);
    else if (strcmp(type, "table") == 0)
        result = read_table(reader, phase, &json_path, first, table);
    if (result != TY_OK) return result;
    result = ty_phase_check(reader->context, type, def->phase, def->phase_count);
    return ty_reader_prefix_error(reader, &json_path, result);
}
