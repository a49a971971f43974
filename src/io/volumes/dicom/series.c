/* Series of DICOM files: their slices in the order in which they lie along the normal, and the grid that they make. */
#include "io/volumes/dicom/dicom.h"

#include "base/context.h"
#include "grid/grid.h"
#include "io/file.h"
#include "io/volumes/samples.h"
#include "io/volumes/volume_file.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* A file that has frames; its texts are those of its elements. */
typedef struct series_file {
    const char* path;
    char series[65], description[65], modality[17], coding[65];
    int32_t number, columns, rows, frames, bits_stored;
    bool is_signed;
    double thickness; /* of a slice, or the spacing between slices where it is given, mm; 0: unknown */
} series_file;

/* A frame of a file, at its distance along the normal. */
typedef struct slice {
    size_t file;
    int32_t frame;
    double along;
    ty_dicom_frame place;
} slice;

typedef struct series {
    ty_context* context;
    const char* path; /* that was asked for */
    ty_dicom_list list;
    series_file* files;
    size_t file_count, file_capacity;
    slice* slices;
    size_t slice_count, slice_capacity;
    char chosen[65]; /* the series UID */
} series;

static void close_series(series* s) {
    ty_free_array(s->context, s->files, s->file_capacity, sizeof *s->files);
    ty_free_array(s->context, s->slices, s->slice_capacity, sizeof *s->slices);
    ty_dicom_free_list(s->context, &s->list);
}

static double dot(const double* a, const double* b) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void cross(const double* a, const double* b, double* out) {
    out[0] = a[1] * b[2] - a[2] * b[1];
    out[1] = a[2] * b[0] - a[0] * b[2];
    out[2] = a[0] * b[1] - a[1] * b[0];
}

/* ---- files ---- */

static ty_result file_length(ty_context* context, const char* path, uint64_t* length) {
    FILE* stream = NULL;
    const ty_result result = ty_open_file(context, path, &stream, length);
    if (result == TY_OK) fclose(stream);
    return result;
}

static ty_result add_file(series* s, const char* path, const ty_dicom* d) {
    if (!ty_grow_array(s->context, (void**)&s->files, &s->file_capacity, s->file_count, sizeof *s->files))
        return TY_ERROR_MEMORY;
    series_file* file = &s->files[s->file_count++];
    *file = (series_file){.path = path,
                          .number = d->series_number,
                          .columns = d->columns,
                          .rows = d->rows,
                          .frames = d->frames,
                          .bits_stored = d->bits_stored,
                          .is_signed = d->is_signed,
                          .thickness = d->between != 0 ? fabs(d->between) : d->thickness};
    memcpy(file->series, d->series, sizeof file->series);
    memcpy(file->description, d->description, sizeof file->description);
    memcpy(file->modality, d->modality, sizeof file->modality);
    snprintf(file->coding, sizeof file->coding, "%s", ty_dicom_coding_name(d));
    return TY_OK;
}

static ty_result add_slices(series* s, size_t index, const ty_dicom* d) {
    for (int32_t frame = 0; frame < d->frames; ++frame) {
        if (!ty_grow_array(s->context, (void**)&s->slices, &s->slice_capacity, s->slice_count, sizeof *s->slices))
            return TY_ERROR_MEMORY;
        s->slices[s->slice_count++] = (slice){.file = index, .frame = frame, .place = ty_dicom_place(d, frame)};
    }
    return TY_OK;
}

/* Looks into all files for their series; those without pixel data do not count. */
static ty_result find_files(series* s) {
    ty_result result = TY_OK;
    for (size_t i = 0; i < s->list.count && result == TY_OK; ++i) {
        ty_dicom d;
        result = ty_dicom_open(s->context, s->list.paths[i], false, &d);
        if (result == TY_OK && d.pixels > 0) result = add_file(s, s->list.paths[i], &d);
        ty_dicom_close(s->context, &d);
    }
    return result;
}

/* Slices of the files of the chosen series. */
static ty_result find_slices(series* s) {
    ty_result result = TY_OK;
    for (size_t i = 0; i < s->file_count && result == TY_OK; ++i) {
        const series_file* file = &s->files[i];
        if (strcmp(file->series, s->chosen) != 0) continue;
        uint64_t length = 0;
        ty_dicom d;
        result = ty_dicom_open(s->context, file->path, false, &d);
        if (result == TY_OK) result = file_length(s->context, file->path, &length);
        if (result == TY_OK) result = ty_dicom_check_pixels(s->context, file->path, &d, length);
        if (result == TY_OK) result = add_slices(s, i, &d);
        ty_dicom_close(s->context, &d);
    }
    return result;
}

/* ---- the choice of a series ---- */

static bool is_first_of_series(const series* s, size_t i) {
    for (size_t k = 0; k < i; ++k)
        if (strcmp(s->files[k].series, s->files[i].series) == 0) return false;
    return true;
}

static size_t count_files(const series* s, const char* uid) {
    size_t count = 0;
    for (size_t i = 0; i < s->file_count; ++i) count += strcmp(s->files[i].series, uid) == 0;
    return count;
}

/* A series goes by its UID, its number or its description; "" suits all. */
static bool suits(const series_file* file, const char* name) {
    char number[16];
    snprintf(number, sizeof number, "%d", file->number);
    return name[0] == '\0' || strcmp(file->series, name) == 0 || strcmp(number, name) == 0 ||
           strcmp(file->description, name) == 0;
}

static ty_result fail_to_choose(const series* s, const char* name, size_t found) {
    char text[1024] = "";
    size_t length = 0, count = 0;
    for (size_t i = 0; i < s->file_count; ++i) {
        if (!is_first_of_series(s, i)) continue;
        ++count;
        const series_file* f = &s->files[i];
        if (length < sizeof text - 256)
            length += (size_t)snprintf(text + length, sizeof text - length, "%s%d \"%s\" (%zu files, %s)",
                                       count > 1 ? ", " : "", f->number, f->description, count_files(s, f->series),
                                       f->series);
    }
    if (found == 0)
        return ty_fail(s->context, TY_ERROR_INPUT, "%s: no series \"%s\"; there is %s", s->path, name, text);
    return ty_fail(s->context, TY_ERROR_INPUT,
                   "%s: %zu series, of which one must be chosen by its number, description "
                   "or UID: %s",
                   s->path, count, text);
}

static ty_result choose_series(series* s, const char* name) {
    size_t found = 0;
    for (size_t i = 0; i < s->file_count; ++i) {
        if (!is_first_of_series(s, i) || !suits(&s->files[i], name)) continue;
        ++found;
        memcpy(s->chosen, s->files[i].series, sizeof s->chosen);
    }
    if (s->file_count == 0)
        return ty_fail(s->context, TY_ERROR_INPUT, "%s: a folder without DICOM files that have pixel data", s->path);
    return found == 1 ? TY_OK : fail_to_choose(s, name, found);
}

/* The series of the file that was named; it alone if it has several frames or no series. */
static ty_result take_named_file(series* s) {
    ty_dicom d;
    ty_result result = ty_dicom_open(s->context, s->path, false, &d);
    const bool single = d.frames > 1 || d.series[0] == '\0';
    if (result == TY_OK && d.pixels == 0) /* with its message */
        result = ty_dicom_check_pixels(s->context, s->path, &d, 0);
    memcpy(s->chosen, d.series, sizeof s->chosen);
    if (result == TY_OK && single) result = add_file(s, s->path, &d);
    ty_dicom_close(s->context, &d);
    if (result != TY_OK || single) return result;
    result = ty_dicom_list_files(s->context, s->path, &s->list);
    return result == TY_OK ? find_files(s) : result;
}

/* ---- order ---- */

static int compare_slices(const void* a, const void* b) {
    const slice *first = a, *second = b;
    if (first->along != second->along) return first->along < second->along ? -1 : 1;
    if (first->file != second->file) return first->file < second->file ? -1 : 1;
    return (first->frame > second->frame) - (first->frame < second->frame);
}

static int compare_numbers(const void* a, const void* b) {
    const double first = *(const double*)a, second = *(const double*)b;
    return (first > second) - (first < second);
}

/* Name of a slice in messages. */
static const char* slice_name(const series* s, const slice* one, char* text, size_t size) {
    const series_file* file = &s->files[one->file];
    const char* slash = strrchr(file->path, '/');
    const char* name = slash != NULL ? slash + 1 : file->path;
    if (file->frames > 1)
        snprintf(text, size, "frame %d of %s", one->frame + 1, name);
    else
        snprintf(text, size, "%s", name);
    return text;
}

static ty_result fail_pair(const series* s, const slice* a, const slice* b, const char* how) {
    char first[300], second[300];
    return ty_fail(s->context, TY_ERROR_INPUT, "%s: %s and %s %s", s->path, slice_name(s, a, first, sizeof first),
                   slice_name(s, b, second, sizeof second), how);
}

static bool is_close(const double* a, const double* b, int count, double tolerance) {
    for (int i = 0; i < count; ++i)
        if (!(fabs(a[i] - b[i]) <= tolerance)) return false;
    return true;
}

/* Slices are alike: in size, spacing and orientation. */
static ty_result check_alike(const series* s) {
    const double tolerance = 1e-3;
    const slice* first = &s->slices[0];
    const series_file* model = &s->files[first->file];
    const double* o = first->place.orientation;
    const double *spacing = first->place.spacing, unit[3] = {dot(o, o), dot(o + 3, o + 3), dot(o, o + 3)};
    char name[300];
    if (!is_close(unit, (const double[]){1, 1, 0}, 3, 0.02))
        return ty_fail(s->context, TY_ERROR_INPUT,
                       "%s: %s: ImageOrientationPatient is not of two perpendicular unit vectors", s->path,
                       slice_name(s, first, name, sizeof name));
    if (!(spacing[0] > 0) || !(spacing[1] > 0))
        return ty_fail(s->context, TY_ERROR_INPUT, "%s: %s: PixelSpacing is %g x %g mm", s->path,
                       slice_name(s, first, name, sizeof name), spacing[0], spacing[1]);
    for (size_t i = 1; i < s->slice_count; ++i) {
        const slice* other = &s->slices[i];
        const series_file* file = &s->files[other->file];
        if (file->columns != model->columns || file->rows != model->rows)
            return fail_pair(s, first, other, "have different numbers of pixels");
        if (!is_close(o, other->place.orientation, 6, tolerance))
            return fail_pair(s, first, other, "have different orientations");
        if (!is_close(spacing, other->place.spacing, 2, tolerance * spacing[0]))
            return fail_pair(s, first, other, "have different pixel spacings");
    }
    return TY_OK;
}

/* Slices of several files can be put in order by their positions alone. */
static ty_result check_positions(const series* s) {
    char name[300];
    bool several = false;
    for (size_t i = 1; i < s->slice_count; ++i) several = several || s->slices[i].file != s->slices[0].file;
    for (size_t i = 0; i < s->slice_count && several; ++i)
        if (!s->slices[i].place.has_position)
            return ty_fail(s->context, TY_ERROR_INPUT,
                           "%s: %s has no ImagePositionPatient, without which the slices have no order", s->path,
                           slice_name(s, &s->slices[i], name, sizeof name));
    return TY_OK;
}

static void sort_slices(series* s) {
    double normal[3];
    cross(s->slices[0].place.orientation, s->slices[0].place.orientation + 3, normal);
    for (size_t i = 0; i < s->slice_count; ++i) s->slices[i].along = dot(s->slices[i].place.position, normal);
    qsort(s->slices, s->slice_count, sizeof *s->slices, compare_slices);
}

/* Median distance between neighbours, of two slices at least. */
static ty_result median_distance(const series* s, double* median) {
    const size_t count = s->slice_count - 1;
    double* distances = ty_alloc_array(s->context, count, sizeof *distances, false);
    if (distances == NULL) return TY_ERROR_MEMORY;
    for (size_t i = 0; i < count; ++i) distances[i] = s->slices[i + 1].along - s->slices[i].along;
    qsort(distances, count, sizeof *distances, compare_numbers);
    *median = distances[count / 2];
    ty_free_array(s->context, distances, count, sizeof *distances);
    return TY_OK;
}

/* Slices are evenly spaced, each at its own place. */
static ty_result check_spacing(const series* s) {
    const double same = 1e-3, tolerance = 0.1;
    double median = 0;
    const ty_result result = median_distance(s, &median);
    if (result != TY_OK) return result;
    for (size_t i = 1; i < s->slice_count; ++i) {
        const slice *a = &s->slices[i - 1], *b = &s->slices[i];
        const double distance = b->along - a->along;
        char text[160];
        if (distance < same) return fail_pair(s, a, b, "lie at the same position; a volume has one slice there");
        snprintf(text, sizeof text,
                 "are %.6g mm apart, where others are %.6g mm: slices are missing, or not evenly spaced", distance,
                 median);
        if (fabs(distance - median) > tolerance * median) return fail_pair(s, a, b, text);
    }
    return TY_OK;
}

/* Step from slice to slice; gantry tilt makes it oblique to the slices. */
static ty_result find_step(const series* s, double step[3]) {
    const slice *first = &s->slices[0], *last = &s->slices[s->slice_count - 1];
    const series_file* file = &s->files[first->file];
    const double intervals = (double)(s->slice_count - 1), tolerance = 0.1;
    if (s->slice_count == 1) {
        cross(first->place.orientation, first->place.orientation + 3, step);
        for (int a = 0; a < 3; ++a) step[a] *= file->thickness > 0 ? file->thickness : 1;
        return TY_OK;
    }
    for (int a = 0; a < 3; ++a) step[a] = (last->place.position[a] - first->place.position[a]) / intervals;
    const double allowed = tolerance * (sqrt(dot(step, step)) + first->place.spacing[0]);
    for (size_t i = 1; i + 1 < s->slice_count; ++i) {
        double expected[3];
        for (int a = 0; a < 3; ++a) expected[a] = first->place.position[a] + step[a] * (double)i;
        if (!is_close(expected, s->slices[i].place.position, 3, allowed))
            return fail_pair(s, first, &s->slices[i], "do not lie in one row of evenly spaced slices");
    }
    return TY_OK;
}

/* Opens the series of a folder or a file; its slices are in order and its step is known. */
static ty_result open_series(ty_context* context, const char* path, const char* name, series* s, double step[3]) {
    *s = (series){.context = context, .path = path};
    ty_result result = TY_OK;
    if (ty_is_folder(path)) {
        result = ty_dicom_list_files(context, path, &s->list);
        if (result == TY_OK) result = find_files(s);
        if (result == TY_OK) result = choose_series(s, name);
    } else {
        result = take_named_file(s);
    }
    if (result == TY_OK) result = find_slices(s);
    if (result == TY_OK && s->slice_count == 0)
        result = ty_fail(context, TY_ERROR_INPUT, "%s: the series is not there any more", path);
    if (result == TY_OK) result = check_alike(s);
    if (result == TY_OK) result = check_positions(s);
    if (result == TY_OK) sort_slices(s);
    if (result == TY_OK && s->slice_count > 1) result = check_spacing(s);
    return result == TY_OK ? find_step(s, step) : result;
}

/* ---- the grid ---- */

static ty_grid_def place_grid(const series* s, const double step[3]) {
    const ty_dicom_frame* first = &s->slices[0].place;
    const series_file* file = &s->files[s->slices[0].file];
    ty_grid_def def = ty_default_grid_def();
    def.size[0] = file->columns;
    def.size[1] = file->rows;
    def.size[2] = (int32_t)s->slice_count;
    def.placed = true;
    for (int r = 0; r < 3; ++r) {
        double* row = def.index_to_local.m + 4 * r;
        row[0] = first->orientation[r] * first->spacing[1];
        row[1] = first->orientation[3 + r] * first->spacing[0];
        row[2] = step[r];
        row[3] = first->position[r];
    }
    return def;
}

/* Frames in the making: the file that is open, and slices of it. */
typedef struct frame_decoder {
    const series* s;
    ty_dicom d;
    size_t file;   /* index; file_count: none */
    float* values; /* of TY_GRID_BLOCK slices */
} frame_decoder;

static void close_file(frame_decoder* decoder) {
    if (decoder->file < decoder->s->file_count) ty_dicom_close(decoder->s->context, &decoder->d);
    decoder->file = decoder->s->file_count;
}

static ty_result open_file(frame_decoder* decoder, size_t index) {
    const series* s = decoder->s;
    const series_file* file = &s->files[index];
    if (decoder->file == index) return TY_OK;
    close_file(decoder);
    decoder->file = index;
    const ty_dicom* d = &decoder->d;
    ty_result result = ty_dicom_open(s->context, file->path, true, &decoder->d);
    if (result == TY_OK && (d->columns != file->columns || d->rows != file->rows || d->frames != file->frames))
        result = ty_fail(s->context, TY_ERROR_FILE, "cannot read %s: it changed meanwhile", file->path);
    return result == TY_OK ? ty_dicom_check_pixels(s->context, file->path, d, d->size) : result;
}

/* As ty_slice_source. */
static ty_result decode_slices(void* user, int32_t first, int32_t count, const void** values) {
    frame_decoder* decoder = user;
    const series* s = decoder->s;
    ty_result result = TY_OK;
    for (int32_t k = 0; k < count && result == TY_OK; ++k) {
        const slice* one = &s->slices[first + k];
        const series_file* file = &s->files[one->file];
        const size_t pixels = (size_t)file->columns * (size_t)file->rows;
        result = open_file(decoder, one->file);
        if (result == TY_OK)
            result =
                ty_dicom_decode(s->context, file->path, &decoder->d, one->frame, decoder->values + pixels * (size_t)k);
    }
    *values = decoder->values;
    return result;
}

static ty_result read_grid(const series* s, const double step[3], const ty_grid_plan* plan, ty_grid** out) {
    const ty_grid_def def = place_grid(s, step);
    size_t voxels = 0;
    ty_result result = ty_check_volume_size(
        s->context, s->path, (const int64_t[]){def.size[0], def.size[1], (int64_t)s->slice_count}, &voxels);
    if (result != TY_OK) return result;
    const size_t slab = s->slice_count < TY_GRID_BLOCK ? s->slice_count : (size_t)TY_GRID_BLOCK;
    const size_t count = voxels / s->slice_count * slab;
    frame_decoder decoder = {.s = s, .file = s->file_count};
    decoder.values = ty_alloc_array(s->context, count, sizeof *decoder.values, false);
    if (decoder.values == NULL) return TY_ERROR_MEMORY;
    const ty_slice_source source = {decode_slices, &decoder, 0, 0};
    result = ty_grid_create_from_slices(s->context, &def, plan, &source, true, out);
    close_file(&decoder);
    ty_free_array(s->context, decoder.values, count, sizeof *decoder.values);
    return result;
}

ty_result ty_dicom_read(ty_context* context, const char* path, const char* name, int32_t component,
                        const ty_grid_plan* plan, ty_grid** out) {
    series s;
    double step[3];
    ty_result result = ty_check_component(context, path, NULL, component, 1);
    if (result != TY_OK) return result;
    result = open_series(context, path, name, &s, step);
    if (result == TY_OK) result = read_grid(&s, step, plan, out);
    close_series(&s);
    return result;
}

void ty_dicom_describe(ty_context* context, const char* path, const char* name, ty_volume_notes* notes) {
    series s;
    double step[3];
    if (open_series(context, path, name, &s, step) == TY_OK) {
        const series_file* file = &s.files[s.slices[0].file];
        const ty_dicom_frame* place = &s.slices[0].place;
        ty_note(notes, "format", "DICOM, %s, %d bits %s", file->coding, file->bits_stored,
                file->is_signed ? "signed" : "unsigned");
        ty_note(notes, "modality", "%s", file->modality);
        ty_note(notes, "series", "%d \"%s\" %s", file->number, file->description, file->series);
        ty_note(notes, "slices", "%zu in %zu files", s.slice_count, count_files(&s, s.chosen));
        ty_note(notes, "spacing", "%.6g x %.6g x %.6g mm", place->spacing[1], place->spacing[0], sqrt(dot(step, step)));
        ty_note(notes, "scaling", "%.9g times the sample plus %.9g", place->slope, place->intercept);
        ty_note(notes, "placement", "left, posterior, superior of the patient");
    }
    close_series(&s);
}
