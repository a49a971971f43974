/* Images of VTK as volumes: arrays by name, as grids. */
#include "io/volumes/vtk/vtk.h"

#include "base/context.h"
#include "base/number.h"
#include "grid/grid.h"
#include "io/volumes/volume_file.h"

#include <math.h>
#include <string.h>

static const size_t file_size_max = (size_t)1 << 36;

/* Bytes beyond the beginning of a legacy file, whose arrays do not tell their number before: this many of nine doubles.
 */
enum { LEGACY_ARRAYS = 64, LEGACY_VALUE = 9 * sizeof(double) };

ty_result ty_vtk_damaged(const ty_vtk_image* image, const char* name, const char* what) {
    return ty_fail(image->context, TY_ERROR_INPUT, "%s: array \"%s\" %s", image->path, name, what);
}

ty_result ty_vtk_add_array(ty_vtk_image* image, const ty_vtk_array* array) {
    if (image->count >= TY_VTK_ARRAYS_MAX)
        return ty_fail(image->context, TY_ERROR_INPUT, "%s: there are more than %d arrays", image->path,
                       (int)TY_VTK_ARRAYS_MAX);
    if (!ty_grow_array(image->context, (void**)&image->arrays, &image->capacity, image->count, sizeof *array))
        return TY_ERROR_MEMORY;
    image->arrays[image->count++] = *array;
    return TY_OK;
}

void ty_vtk_close(ty_vtk_image* image) {
    ty_free_array(image->context, image->arrays, image->capacity, sizeof *image->arrays);
}

/* Along an axis of one point there is one layer of cells. */
void ty_vtk_sides(const int64_t extent[6], bool cells, int64_t sides[3]) {
    for (int a = 0; a < 3; ++a) {
        const int64_t last = extent[2 * a + 1] - extent[2 * a];
        sides[a] = cells && last > 0 ? last : last + 1;
    }
}

/* ---- files ---- */

static ty_result parse(ty_vtk_image* image) {
    return image->size > 0 && image->bytes[0] == '#' ? ty_vtk_legacy_parse(image) : ty_vti_parse(image);
}

/* Bytes that an array of a .vti file takes at most: compression does not enlarge much. */
static uint64_t longest_array(const ty_vtk_image* image, const ty_vtk_array* array) {
    int64_t sides[3];
    ty_vtk_sides(image->pieces > 1 ? array->extent : image->extent, array->cells, sides);
    const double values = (double)sides[0] * (double)sides[1] * (double)sides[2] * array->components;
    const double bytes = 3 * values * (array->type < TY_SAMPLE_TYPES ? (double)ty_sample_size(array->type) : 1);
    return bytes < (double)file_size_max ? (uint64_t)bytes : file_size_max;
}

/* As ty_file_form_fn. */
static ty_result inspect(ty_context* context, const char* path, uint8_t* head, size_t size, ty_file_form* form) {
    ty_vtk_image image = {.context = context, .path = path, .bytes = head, .size = size, .beginning = true};
    const bool legacy = size > 0 && head[0] == '#';
    const ty_result result = parse(&image);
    int64_t sides[3];
    ty_vtk_sides(image.extent, false, sides);
    if (legacy) {
        const double longest = (double)sides[0] * (double)sides[1] * (double)sides[2] * LEGACY_ARRAYS * LEGACY_VALUE;
        form->longest = longest < (double)file_size_max ? (uint64_t)longest + TY_FILE_SLACK : UINT64_MAX;
    } else if (image.complete) {
        form->longest = TY_FILE_SLACK;
        for (size_t i = 0; i < image.count && form->longest < file_size_max; ++i)
            form->longest += longest_array(&image, &image.arrays[i]);
    } else {
        form->text = true;
    }
    ty_vtk_close(&image);
    return result;
}

static ty_result open_image(ty_context* context, const char* path, ty_vtk_image* image) {
    *image = (ty_vtk_image){.context = context, .path = path};
    uint8_t* bytes = NULL;
    ty_result result = ty_read_inspected_file(context, path, file_size_max, inspect, &bytes, &image->size);
    image->bytes = bytes;
    return result == TY_OK ? parse(image) : result;
}

static void close_image(ty_vtk_image* image) {
    ty_vtk_close(image);
    ty_free_file(image->context, (uint8_t*)(uintptr_t)image->bytes, image->size);
}

/* ---- choice of an array ---- */

/* Arrays of the first piece, which stand before those of others. */
static size_t array_count(const ty_vtk_image* image) {
    size_t count = 0;
    while (count < image->count && image->arrays[count].piece == 0) ++count;
    return count;
}

static ty_result missing_array(const ty_vtk_image* image, const char* name) {
    const size_t count = array_count(image);
    char names[512] = "";
    size_t length = 0;
    for (size_t i = 0; i < count && length < sizeof names; ++i)
        length +=
            (size_t)snprintf(names + length, sizeof names - length, "%s%s", i > 0 ? ", " : "", image->arrays[i].name);
    return ty_fail(image->context, TY_ERROR_INPUT, "%s: no array \"%s\"; there %s %s", image->path, name,
                   count == 1 ? "is" : "are", count == 0 ? "none" : names);
}

/* The array of a name; unless the name is binding, else the section's own choice, or the only one. */
static ty_result choose_array(const ty_vtk_image* image, const ty_volume_def* def, const ty_vtk_array** out) {
    const size_t count = array_count(image);
    *out = NULL;
    for (size_t i = 0; i < count && *out == NULL; ++i)
        if (strcmp(image->arrays[i].name, def->grid) == 0) *out = &image->arrays[i];
    for (size_t i = 0; i < count && *out == NULL && !def->exact_grid; ++i)
        if (image->arrays[i].active) *out = &image->arrays[i];
    if (*out == NULL && count == 1 && !def->exact_grid) *out = image->arrays;
    if (*out == NULL) return missing_array(image, def->grid);
    return (*out)->type < TY_SAMPLE_TYPES ? TY_OK
                                          : ty_vtk_damaged(image, (*out)->name, "is not of numbers that can be read");
}

/* ---- values ---- */

/* Map from indices of values to places: their points, or the centres of their cells. */
static ty_result place(const ty_vtk_image* image, const ty_vtk_array* array, ty_affine* out) {
    int64_t sides[3];
    ty_affine inverse;
    ty_vtk_sides(image->extent, false, sides);
    for (int r = 0; r < 3; ++r) out->m[4 * r + 3] = image->origin[r];
    for (int a = 0; a < 3; ++a) {
        const double step = image->spacing[a] == 0 && sides[a] == 1 ? 1 : image->spacing[a];
        const double first = (double)image->extent[2 * a] + (array->cells && sides[a] > 1 ? 0.5 : 0);
        for (int r = 0; r < 3; ++r) {
            out->m[4 * r + a] = image->direction[3 * r + a] * step;
            out->m[4 * r + 3] += out->m[4 * r + a] * first;
        }
    }
    if (ty_affine_invert(out, &inverse)) return TY_OK;
    return ty_fail(image->context, TY_ERROR_INPUT, "%s: the spacing and the directions span no volume", image->path);
}

static const char* skip_blanks(const char* text, const char* end) {
    while (text < end && strchr(" \t\r\n\v\f", *text) != NULL && *text != '\0') ++text;
    return text;
}

/* Numbers in decimal; their end is found before, so that none reaches beyond. */
static ty_result parse_text(const ty_vtk_image* image, const ty_vtk_array* array, int32_t component, size_t voxels,
                            ty_grid_type type, void* values) {
    const char *end = (const char*)image->bytes + array->end, *rest;
    const char* text = skip_blanks((const char*)image->bytes + array->at, end);
    const size_t step = (size_t)array->components;
    for (size_t i = 0; i < voxels * step; ++i) {
        const double value = text < end ? ty_parse_number(text, &rest) : 0;
        if (text >= end || rest == text || rest > end)
            return ty_fail(image->context, TY_ERROR_INPUT, "%s: array \"%s\" has %zu numbers instead of %zu",
                           image->path, array->name, i, voxels * step);
        text = skip_blanks(rest, end);
        if (i % step == (size_t)component) ty_store_value(type, values, i / step, value);
    }
    return text >= end ? TY_OK : ty_vtk_damaged(image, array->name, "has something behind its numbers");
}

static ty_result read_text(const ty_vtk_image* image, const ty_vtk_array* array, int32_t component, size_t voxels,
                           ty_grid_def* def, ty_grid** out) {
    if (voxels * (size_t)array->components > (array->end - array->at) / 2 + 1)
        return ty_vtk_damaged(image, array->name, "has fewer numbers than the extent takes");
    def->type = ty_sample_grid_type(array->type);
    const size_t size = ty_grid_value_size(def->type);
    void* values = ty_alloc_array(image->context, voxels, size, false);
    if (values == NULL) return TY_ERROR_MEMORY;
    const ty_result result = parse_text(image, array, component, voxels, def->type, values);
    if (result == TY_OK) return ty_grid_adopt(image->context, def, values, out);
    ty_free_array(image->context, values, voxels, size);
    return result;
}

static ty_result read_bytes(const ty_vtk_image* image, const ty_vtk_array* array, int32_t component, size_t voxels,
                            const ty_grid_plan* plan, const ty_grid_def* def, ty_grid** out) {
    const size_t needed = voxels * (size_t)array->components * ty_sample_size(array->type);
    ty_vtk_reader* reader = NULL;
    ty_samples samples = {.type = array->type,
                          .big_endian = image->big_endian,
                          .first = (size_t)component,
                          .step = (size_t)array->components,
                          .plan = *plan};
    ty_result result = ty_vtk_open(image, array, needed, &samples, &reader);
    if (result == TY_OK) result = ty_samples_make_grid(image->context, &samples, def, out);
    if (result == TY_OK) {
        result = ty_vtk_finish(reader);
        if (result != TY_OK) {
            ty_grid_release(*out);
            *out = NULL;
        }
    }
    ty_vtk_close_reader(reader);
    return result;
}

ty_result ty_vtk_read_values(const ty_vtk_image* image, const ty_vtk_array* array, int32_t component,
                             const ty_grid_plan* plan, ty_grid_def* def, ty_grid** out) {
    const size_t voxels = (size_t)def->size[0] * (size_t)def->size[1] * (size_t)def->size[2];
    return array->form == TY_VTK_TEXT ? read_text(image, array, component, voxels, def, out)
                                      : read_bytes(image, array, component, voxels, plan, def, out);
}

static ty_result read_array(const ty_vtk_image* image, const ty_vtk_array* array, int32_t component,
                            const ty_grid_plan* plan, ty_grid** out) {
    int64_t sides[3];
    size_t voxels = 0;
    ty_grid_def def = ty_default_grid_def();
    ty_vtk_sides(image->extent, array->cells, sides);
    ty_result result = ty_check_volume_size(image->context, image->path, sides, &voxels);
    if (result == TY_OK)
        result = ty_check_component(image->context, image->path, array->name, component, array->components);
    if (result == TY_OK) result = place(image, array, &def.index_to_local);
    if (result != TY_OK) return result;
    for (int a = 0; a < 3; ++a) def.size[a] = (int32_t)sides[a];
    def.placed = true;
    def.type = ty_sample_grid_type(array->type);
    return image->pieces > 1 ? ty_vtk_read_pieces(image, array, component, &def, out)
                             : ty_vtk_read_values(image, array, component, plan, &def, out);
}

/* ---- entry points ---- */

ty_result ty_vtk_read(ty_context* context, const char* path, const ty_volume_def* def, ty_grid** out) {
    ty_vtk_image image;
    const ty_vtk_array* array = NULL;
    const ty_grid_plan plan = ty_volume_plan(def);
    ty_result result = open_image(context, path, &image);
    if (result == TY_OK) result = choose_array(&image, def, &array);
    if (result == TY_OK) result = read_array(&image, array, def->component, &plan, out);
    close_image(&image);
    return result;
}

ty_result ty_vtk_components(ty_context* context, const char* path, const ty_volume_def* def, int32_t* out) {
    ty_vtk_image image;
    const ty_vtk_array* array = NULL;
    ty_result result = open_image(context, path, &image);
    if (result == TY_OK) result = choose_array(&image, def, &array);
    if (result == TY_OK) *out = array->components;
    close_image(&image);
    return result;
}

static ty_vdb_entry entry_of(const ty_vtk_image* image, const ty_vtk_array* array) {
    ty_vdb_entry entry = {.active_voxels = 1};
    int64_t sides[3];
    const char* type = array->type < TY_SAMPLE_TYPES ? ty_sample_name(array->type) : "unknown";
    memcpy(entry.name, array->name, sizeof entry.name);
    if (array->components == 1)
        snprintf(entry.type, sizeof entry.type, "%s", type);
    else
        snprintf(entry.type, sizeof entry.type, "%s[%d]", type, array->components);
    ty_vtk_sides(image->extent, array->cells, sides);
    for (int a = 0; a < 3; ++a) {
        entry.upper[a] = sides[a] <= INT32_MAX ? (int32_t)sides[a] - 1 : INT32_MAX;
        entry.voxel_size[a] = fabs(image->spacing[a]);
        entry.active_voxels = entry.active_voxels <= INT64_MAX / sides[a] ? entry.active_voxels * sides[a] : INT64_MAX;
    }
    return entry;
}

ty_result ty_vtk_list(ty_context* context, const char* path, ty_vdb_entry* entries, int32_t capacity, int32_t* count) {
    ty_vtk_image image;
    const ty_result result = open_image(context, path, &image);
    const size_t arrays = array_count(&image);
    for (size_t i = 0; i < arrays && i < (size_t)capacity && result == TY_OK; ++i)
        entries[i] = entry_of(&image, &image.arrays[i]);
    if (result == TY_OK) *count = (int32_t)arrays;
    close_image(&image);
    return result;
}
