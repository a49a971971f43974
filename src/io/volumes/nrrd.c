/* Voxels of NRRD files: after the header or in a separate file; raw, gzip or text. */
#include "io/volumes/nrrd.h"

#include "base/context.h"
#include "grid/grid.h"
#include "io/file.h"
#include "base/number.h"
#include "io/volumes/gzip_file.h"
#include "io/volumes/sample_file.h"
#include "io/volumes/volume_file.h"

#include <string.h>

enum { HEAD_SIZE = 1 << 20 };

static const size_t file_size_max = (size_t)1 << 36;

/* A file in memory and its unread rest. */
typedef struct source {
    ty_context* context;
    const char* path;
    uint8_t* bytes;
    size_t size, at;
} source;

static void close_source(source* s) {
    ty_free_file(s->context, s->bytes, s->size);
    s->bytes = NULL;
}

/* True for data files in the header's folder or below it; others are refused. */
static bool is_inside_folder(const char* relative) {
    if (relative[0] == '/' || relative[0] == '\0') return false;
    for (const char* part = relative; part != NULL; part = strchr(part, '/')) {
        part += *part == '/';
        if (strncmp(part, "..", 2) == 0 && (part[2] == '/' || part[2] == '\0')) return false;
    }
    return true;
}

/* Bytes that the data of a header may take: a packed or printed number has no more than 64, and others may follow. */
static uint64_t longest_data(const ty_nrrd* nrrd) {
    enum { NUMBER_MAX = 64 };
    const uint64_t count = (uint64_t)nrrd->voxels * (uint64_t)nrrd->components;
    const uint64_t size = nrrd->encoding == TY_NRRD_TEXT ? count * NUMBER_MAX : 2 * count * ty_sample_size(nrrd->type);
    const uint64_t skipped = nrrd->byte_skip > 0 ? (uint64_t)nrrd->byte_skip : 0;
    return skipped < file_size_max ? size + skipped + TY_FILE_SLACK : file_size_max;
}

/* As ty_file_form_fn. */
static ty_result inspect(ty_context* context, const char* path, uint8_t* head, size_t size, ty_file_form* form) {
    ty_nrrd nrrd;
    const ty_result result = ty_nrrd_parse(context, path, head, size, &nrrd);
    if (result != TY_OK) return result;
    form->longest = nrrd.data + (nrrd.data_file == NULL ? longest_data(&nrrd) : TY_FILE_SLACK);
    return TY_OK;
}

/* The path of a header's data file, freed by the caller. */
static ty_result find_data(const source* file, const ty_nrrd* nrrd, char** path) {
    if (strncmp(nrrd->data_file, "LIST", 4) == 0 || strchr(nrrd->data_file, '%') != NULL)
        return ty_fail(file->context, TY_ERROR_INPUT, "%s: data in more than one file cannot be read", file->path);
    if (!is_inside_folder(nrrd->data_file))
        return ty_fail(file->context, TY_ERROR_INPUT,
                       "%s: the data file %s is not in the folder of the header or below", file->path, nrrd->data_file);
    char* folder = ty_folder_of(file->context, file->path);
    *path = folder == NULL ? NULL : ty_join_path(file->context, folder, nrrd->data_file);
    ty_free_text(file->context, folder);
    return *path != NULL ? TY_OK : TY_ERROR_MEMORY;
}

static ty_result open_data(source* data, const ty_nrrd* nrrd) {
    const uint64_t longest = longest_data(nrrd);
    return ty_read_file(data->context, data->path, longest < file_size_max ? (size_t)longest : file_size_max,
                        &data->bytes, &data->size);
}

static ty_result wrong_size(const source* s, const ty_nrrd* nrrd, bool more, size_t found) {
    return ty_fail(s->context, TY_ERROR_INPUT, "%s: %s%zu bytes for %d x %d x %d voxels of %d %s", s->path,
                   more ? "more than " : "cut short: ", found, nrrd->size[0], nrrd->size[1], nrrd->size[2],
                   nrrd->components, ty_sample_name(nrrd->type));
}

static ty_result skip_lines(source* s, int64_t lines) {
    for (; lines > 0; --lines) {
        const uint8_t* newline = memchr(s->bytes + s->at, '\n', s->size - s->at);
        if (newline == NULL)
            return ty_fail(s->context, TY_ERROR_INPUT, "%s: has fewer lines than are to be skipped", s->path);
        s->at = (size_t)(newline - s->bytes) + 1;
    }
    return TY_OK;
}

/* Offset of raw samples of exactly the header's size among the `left` bytes from `begin` on. */
static ty_result find_raw(const source* s, const ty_nrrd* nrrd, size_t size, uint64_t begin, uint64_t left,
                          uint64_t* start) {
    const uint64_t skip = nrrd->byte_skip < 0 ? (left > size ? left - size : 0) : (uint64_t)nrrd->byte_skip;
    if (skip > left || left - skip < size) return wrong_size(s, nrrd, false, skip > left ? 0 : (size_t)(left - skip));
    if (left - skip > size) return wrong_size(s, nrrd, true, size);
    *start = begin + skip;
    return TY_OK;
}

/* Reads raw samples in parts from a file, in which they begin after `begin` bytes. */
static ty_result read_raw_parts(const source* s, const ty_nrrd* nrrd, uint64_t begin, ty_samples* samples,
                                const ty_grid_def* def, ty_grid** out) {
    const size_t size = nrrd->voxels * (size_t)nrrd->components * ty_sample_size(nrrd->type);
    uint64_t length = 0, start = 0;
    FILE* stream = NULL;
    ty_sample_file file;
    ty_result result = ty_open_file(s->context, s->path, &stream, &length);
    if (result != TY_OK) return result;
    fclose(stream);
    result = find_raw(s, nrrd, size, begin, length > begin ? length - begin : 0, &start);
    if (result == TY_OK) result = ty_sample_file_open(s->context, s->path, start, &file);
    if (result != TY_OK) return result;
    samples->read = ty_sample_file_read;
    samples->user = &file;
    result = ty_samples_make_grid(s->context, samples, def, out);
    ty_sample_file_close(&file);
    return result;
}

/* The error of a gzip file's end or fault; TY_OK for data of the right size. */
static ty_result check_inflated(const source* s, const ty_nrrd* nrrd, const ty_gzip_file* file, ty_inflated state) {
    switch (state) {
    case TY_INFLATED_MORE: return wrong_size(s, nrrd, true, (size_t)file->size);
    case TY_INFLATED_SHORT: return wrong_size(s, nrrd, false, (size_t)file->at);
    case TY_INFLATED_DAMAGED:
        return ty_fail(s->context, TY_ERROR_INPUT, "%s: the gzip data is damaged or cut short", s->path);
    default: return TY_OK;
    }
}

/* Reads gzip data in parts from a file, in which it begins after `begin` bytes. */
static ty_result read_gzip(const source* s, const ty_nrrd* nrrd, uint64_t begin, ty_samples* samples,
                           const ty_grid_def* def, ty_grid** out) {
    const size_t size = nrrd->voxels * (size_t)nrrd->components * ty_sample_size(nrrd->type);
    const uint64_t skip = (uint64_t)nrrd->byte_skip;
    ty_gzip_file file;
    ty_result result = ty_gzip_file_open(s->context, s->path, begin, skip, size, &file);
    if (result != TY_OK) return result;
    const uint64_t longest = longest_data(nrrd);
    if (file.packed > longest) {
        result = ty_fail(s->context, TY_ERROR_INPUT, "%s: %llu bytes, of which its header accounts for %llu at most",
                         s->path, (unsigned long long)(begin + file.packed), (unsigned long long)(begin + longest));
    } else if (skip > SIZE_MAX / 2 || size + skip > file.packed * TY_INFLATE_RATIO_MAX) {
        result = wrong_size(s, nrrd, false, (size_t)file.packed);
    } else {
        samples->read = ty_gzip_file_read;
        samples->user = &file;
        result = ty_samples_make_grid(s->context, samples, def, out);
        if (result == TY_ERROR_INPUT) check_inflated(s, nrrd, &file, file.fault);
    }
    if (result == TY_OK) {
        result = check_inflated(s, nrrd, &file, ty_gzip_file_finish(&file));
        if (result != TY_OK) {
            ty_grid_release(*out);
            *out = NULL;
        }
    }
    ty_gzip_file_close(&file);
    return result;
}

static const char* skip_separators(const char* text) {
    return text + strspn(text, " \t\r\n\v\f,");
}

static ty_result parse_text(const source* s, const ty_nrrd* nrrd, const ty_samples* layout, ty_grid_type type,
                            void* values) {
    const char* text = skip_separators((const char*)s->bytes + s->at);
    const size_t count = nrrd->voxels * (size_t)nrrd->components;
    for (size_t i = 0; i < count; ++i) {
        const char* end;
        const double value = ty_parse_number(text, &end);
        if (end == text)
            return ty_fail(s->context, TY_ERROR_INPUT, "%s: %zu numbers instead of %zu", s->path, i, count);
        text = skip_separators(end);
        const size_t past = i - layout->first;
        if (i >= layout->first && past % layout->step == 0 && past / layout->step < nrrd->voxels)
            ty_store_value(type, values, past / layout->step, value);
    }
    if (*text == '\0') return TY_OK;
    return ty_fail(s->context, TY_ERROR_INPUT, "%s: something follows the %zu numbers", s->path, count);
}

static ty_result read_text(source* s, const ty_nrrd* nrrd, const ty_samples* layout, ty_grid_def* def, ty_grid** out) {
    if ((uint64_t)nrrd->byte_skip > s->size - s->at) return wrong_size(s, nrrd, false, 0);
    s->at += (size_t)nrrd->byte_skip;
    const size_t left = s->size - s->at;
    if (nrrd->voxels * (size_t)nrrd->components > left / 2 + 1) return wrong_size(s, nrrd, false, left);
    def->type = ty_sample_grid_type(nrrd->type);
    void* values = ty_alloc_array(s->context, nrrd->voxels, ty_grid_value_size(def->type), false);
    if (values == NULL) return TY_ERROR_MEMORY;
    const ty_result result = parse_text(s, nrrd, layout, def->type, values);
    def->background = result == TY_OK ? ty_value_outside(def->type, values, nrrd->voxels) : 0;
    if (result == TY_OK) return ty_grid_adopt(s->context, def, values, out);
    ty_free_array(s->context, values, nrrd->voxels, ty_grid_value_size(def->type));
    return result;
}

static ty_samples describe_samples(const ty_nrrd* nrrd, int32_t component) {
    return (ty_samples){.type = nrrd->type,
                        .big_endian = nrrd->big_endian,
                        .first = nrrd->components_last ? nrrd->voxels * (size_t)component : (size_t)component,
                        .step = nrrd->components_last ? 1 : (size_t)nrrd->components};
}

static ty_grid_def describe_grid(const ty_nrrd* nrrd) {
    ty_grid_def def = ty_default_grid_def();
    memcpy(def.size, nrrd->size, sizeof def.size);
    def.index_to_local = nrrd->index_to_local;
    def.placed = true;
    return def;
}

static ty_result read_samples(source* s, const ty_nrrd* nrrd, int32_t component, ty_grid** out) {
    const size_t size = nrrd->voxels * (size_t)nrrd->components * ty_sample_size(nrrd->type);
    ty_samples samples = describe_samples(nrrd, component);
    ty_grid_def def = describe_grid(nrrd);
    uint64_t start = 0;
    ty_result result = skip_lines(s, nrrd->line_skip);
    if (result != TY_OK) return result;
    switch (nrrd->encoding) {
    case TY_NRRD_RAW:
        result = find_raw(s, nrrd, size, s->at, s->size - s->at, &start);
        if (result != TY_OK) return result;
        samples.bytes = s->bytes + start;
        return ty_samples_make_grid(s->context, &samples, &def, out);
    case TY_NRRD_GZIP: return read_gzip(s, nrrd, s->at, &samples, &def, out);
    case TY_NRRD_TEXT: return read_text(s, nrrd, &samples, &def, out);
    }
    return TY_ERROR_INTERNAL;
}

static bool in_parts(const ty_nrrd* nrrd) {
    return nrrd->encoding != TY_NRRD_TEXT && nrrd->line_skip == 0;
}

/* Reads what a header tells of the data behind it, or in a file of their own. */
static ty_result read_data(const source* file, const ty_nrrd* nrrd, int32_t component, const ty_grid_plan* plan,
                           ty_grid** out) {
    ty_samples samples = describe_samples(nrrd, component);
    const ty_grid_def def = describe_grid(nrrd);
    source data = *file;
    char* path = NULL;
    ty_result result = TY_OK;
    if (nrrd->data_file != NULL) {
        result = find_data(file, nrrd, &path);
        data = (source){.context = file->context, .path = path};
    }
    if (result != TY_OK) return result;
    if (in_parts(nrrd)) {
        samples.plan = *plan;
        const uint64_t begin = path == NULL ? nrrd->data : 0;
        result = nrrd->encoding == TY_NRRD_GZIP ? read_gzip(&data, nrrd, begin, &samples, &def, out)
                                                : read_raw_parts(&data, nrrd, begin, &samples, &def, out);
    } else if (path == NULL) {
        data.at = nrrd->data;
        result = read_samples(&data, nrrd, component, out);
    } else {
        result = open_data(&data, nrrd);
        if (result == TY_OK) result = read_samples(&data, nrrd, component, out);
        close_source(&data);
    }
    ty_free_text(file->context, path);
    return result;
}

static bool ends_header(const uint8_t* bytes, size_t size) {
    for (size_t i = 1; i < size; ++i)
        if (bytes[i] == '\n' && (bytes[i - 1] == '\n' || (i > 1 && bytes[i - 1] == '\r' && bytes[i - 2] == '\n')))
            return true;
    return false;
}

/* Reads the beginning of a file, as far as its header; *found tells whether it parsed and its data are read in parts.
 */
static ty_result read_head(source* file, ty_nrrd* nrrd, bool* found) {
    ty_result result = ty_read_part(file->context, file->path, 0, HEAD_SIZE, &file->bytes, &file->size);
    *found = result == TY_OK && ends_header(file->bytes, file->size);
    if (*found) result = ty_nrrd_parse(file->context, file->path, file->bytes, file->size, nrrd);
    *found = *found && result == TY_OK && in_parts(nrrd);
    return result;
}

ty_result ty_nrrd_read(ty_context* context, const char* path, int32_t component, const ty_grid_plan* plan,
                       ty_grid** out) {
    source file = {.context = context, .path = path};
    ty_nrrd nrrd;
    bool parts = false;
    ty_result result = read_head(&file, &nrrd, &parts);
    if (result == TY_OK && !parts) {
        close_source(&file);
        result = ty_read_inspected_file(context, path, file_size_max, inspect, &file.bytes, &file.size);
        if (result == TY_OK) result = ty_nrrd_parse(context, path, file.bytes, file.size, &nrrd);
    }
    if (result == TY_OK) result = ty_check_component(context, path, NULL, component, nrrd.components);
    if (result == TY_OK) result = read_data(&file, &nrrd, component, plan, out);
    close_source(&file);
    return result;
}

ty_result ty_nrrd_components(ty_context* context, const char* path, int32_t* out) {
    source file = {.context = context, .path = path};
    ty_result result = ty_read_part(context, path, 0, TY_FILE_SLACK, &file.bytes, &file.size);
    if (result != TY_OK) return result;
    ty_nrrd nrrd;
    result = ty_nrrd_parse(context, path, file.bytes, file.size, &nrrd);
    if (result == TY_OK) *out = nrrd.components;
    close_source(&file);
    return result;
}
