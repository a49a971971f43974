/* TIFF stacks through libtiff: pages are slices. */
#define _POSIX_C_SOURCE 200809L
#include "io/volumes/tiff_stack.h"
#include "io/volumes/volume_file.h"

#include "base/context.h"

#if TYNDALL_TIFF

#include "grid/grid.h"
#include "io/file.h"
#include "io/volumes/samples.h"

#include <stdarg.h>
#include <string.h>
#include <tiffio.h>

/* Compression of blank pages; bytes of a table of the library; values per voxel. */
enum { RATIO_MAX = 1 << 16, MEMORY_MAX = 1 << 28, COMPONENTS_MAX = 65536 };

typedef struct page_form {
    uint32_t width, height;
    uint16_t bits, samples, format, planes, photometric, compression;
} page_form;

typedef struct stack {
    ty_context* context;
    const char* path;
    FILE* stream;
    uint64_t size;
    TIFF* tiff;
    char message[256]; /* the library's first one */
    page_form form;
    ty_sample_type type;
    ty_stack_layout layout;
    int32_t pages;
    bool contiguous; /* ImageJ: all planes follow the first one, which alone is a page */
    double resolution[2];
} stack;

/* ---- the library's view of the file ---- */

static tmsize_t read_bytes(thandle_t handle, void* to, tmsize_t size) {
    return (tmsize_t)fread(to, 1, (size_t)size, ((stack*)handle)->stream);
}

static tmsize_t write_nothing(thandle_t handle, void* from, tmsize_t size) {
    (void)handle;
    (void)from;
    (void)size;
    return -1;
}

static toff_t seek_bytes(thandle_t handle, toff_t offset, int whence) {
    FILE* stream = ((stack*)handle)->stream;
    if (fseeko(stream, (off_t)offset, whence) != 0) return (toff_t)-1;
    return (toff_t)ftello(stream);
}

static int close_nothing(thandle_t handle) {
    (void)handle;
    return 0;
}

static toff_t size_of(thandle_t handle) {
    return ((stack*)handle)->size;
}

static int take_error(TIFF* tiff, void* user, const char* module, const char* format, va_list arguments) {
    stack* s = user;
    (void)tiff;
    (void)module;
    if (s->message[0] == '\0') vsnprintf(s->message, sizeof s->message, format, arguments);
    return 1;
}

static int ignore_warning(TIFF* tiff, void* user, const char* module, const char* format, va_list arguments) {
    (void)tiff;
    (void)user;
    (void)module;
    (void)format;
    (void)arguments;
    return 1;
}

static ty_result damaged(const stack* s) {
    return ty_fail(s->context, TY_ERROR_INPUT, "%s: cannot read this TIFF: %s", s->path,
                   s->message[0] != '\0' ? s->message : "it is damaged or cut short");
}

static ty_result open_library(stack* s) {
    TIFFOpenOptions* options = TIFFOpenOptionsAlloc();
    if (options == NULL) return ty_fail(s->context, TY_ERROR_MEMORY, "%s: not enough memory", s->path);
    TIFFOpenOptionsSetMaxSingleMemAlloc(options, MEMORY_MAX);
    TIFFOpenOptionsSetErrorHandlerExtR(options, take_error, s);
    TIFFOpenOptionsSetWarningHandlerExtR(options, ignore_warning, s);
    s->tiff = TIFFClientOpenExt(s->path, "rm", s, read_bytes, write_nothing, seek_bytes, close_nothing, size_of, NULL,
                                NULL, options);
    TIFFOpenOptionsFree(options);
    return s->tiff != NULL ? TY_OK : damaged(s);
}

/* ---- pages ---- */

static page_form form_of_page(TIFF* tiff) {
    page_form f = {0};
    TIFFGetField(tiff, TIFFTAG_IMAGEWIDTH, &f.width);
    TIFFGetField(tiff, TIFFTAG_IMAGELENGTH, &f.height);
    TIFFGetFieldDefaulted(tiff, TIFFTAG_BITSPERSAMPLE, &f.bits);
    TIFFGetFieldDefaulted(tiff, TIFFTAG_SAMPLESPERPIXEL, &f.samples);
    TIFFGetFieldDefaulted(tiff, TIFFTAG_SAMPLEFORMAT, &f.format);
    TIFFGetFieldDefaulted(tiff, TIFFTAG_PLANARCONFIG, &f.planes);
    TIFFGetFieldDefaulted(tiff, TIFFTAG_COMPRESSION, &f.compression);
    TIFFGetField(tiff, TIFFTAG_PHOTOMETRIC, &f.photometric);
    return f;
}

/* Thumbnails, smaller copies and masks do not count. */
static bool is_slice(TIFF* tiff) {
    uint32_t kind = 0;
    TIFFGetField(tiff, TIFFTAG_SUBFILETYPE, &kind);
    return (kind & (FILETYPE_REDUCEDIMAGE | FILETYPE_MASK)) == 0;
}

static ty_result find_type(stack* s) {
    static const struct {
        uint16_t format, bits;
        ty_sample_type type;
    } types[] = {{SAMPLEFORMAT_UINT, 8, TY_SAMPLE_UINT8},    {SAMPLEFORMAT_UINT, 16, TY_SAMPLE_UINT16},
                 {SAMPLEFORMAT_UINT, 32, TY_SAMPLE_UINT32},  {SAMPLEFORMAT_UINT, 64, TY_SAMPLE_UINT64},
                 {SAMPLEFORMAT_INT, 8, TY_SAMPLE_INT8},      {SAMPLEFORMAT_INT, 16, TY_SAMPLE_INT16},
                 {SAMPLEFORMAT_INT, 32, TY_SAMPLE_INT32},    {SAMPLEFORMAT_INT, 64, TY_SAMPLE_INT64},
                 {SAMPLEFORMAT_IEEEFP, 16, TY_SAMPLE_HALF},  {SAMPLEFORMAT_IEEEFP, 32, TY_SAMPLE_FLOAT},
                 {SAMPLEFORMAT_IEEEFP, 64, TY_SAMPLE_DOUBLE}};
    const uint16_t format = s->form.format == SAMPLEFORMAT_VOID ? SAMPLEFORMAT_UINT : s->form.format;
    for (size_t i = 0; i < sizeof types / sizeof types[0]; ++i)
        if (types[i].format == format && types[i].bits == s->form.bits) {
            s->type = types[i].type;
            return TY_OK;
        }
    return ty_fail(s->context, TY_ERROR_INPUT,
                   "%s: TIFF samples of %d bits in format %d cannot be read (whole numbers of 8 to 64 bits, floats of "
                   "16 to 64 can)",
                   s->path, s->form.bits, s->form.format);
}

static ty_result check_form(stack* s) {
    if (s->form.photometric == PHOTOMETRIC_PALETTE)
        return ty_fail(s->context, TY_ERROR_INPUT, "%s: a TIFF of colours from a palette, not of values", s->path);
    if (s->form.photometric == PHOTOMETRIC_YCBCR && s->form.compression != COMPRESSION_JPEG)
        return ty_fail(s->context, TY_ERROR_INPUT, "%s: a TIFF of luminance and chroma, not of values", s->path);
    if (!TIFFIsCODECConfigured(s->form.compression))
        return ty_fail(s->context, TY_ERROR_INPUT, "%s: TIFF compression %d, which the library cannot decode", s->path,
                       s->form.compression);
    if (s->form.width < 1 || s->form.height < 1 || s->form.samples < 1) return damaged(s);
    return find_type(s);
}

static bool same_form(const page_form* a, const page_form* b) {
    return a->width == b->width && a->height == b->height && a->bits == b->bits && a->samples == b->samples &&
           a->format == b->format && a->planes == b->planes;
}

/* Counts the pages, which must be alike. */
static ty_result count_pages(stack* s) {
    do {
        if (!is_slice(s->tiff)) continue;
        const page_form form = form_of_page(s->tiff);
        if (s->pages == 0) {
            const char* description = NULL;
            float resolution[2] = {0, 0};
            TIFFGetField(s->tiff, TIFFTAG_IMAGEDESCRIPTION, &description);
            TIFFGetField(s->tiff, TIFFTAG_XRESOLUTION, &resolution[0]);
            TIFFGetField(s->tiff, TIFFTAG_YRESOLUTION, &resolution[1]);
            for (int a = 0; a < 2; ++a) s->resolution[a] = (double)resolution[a];
            s->layout = ty_stack_parse(description);
            s->form = form;
            const ty_result result = check_form(s);
            if (result != TY_OK) return result;
        } else if (!same_form(&form, &s->form)) {
            return ty_fail(
                s->context, TY_ERROR_INPUT,
                "%s: page %d has %u x %u pixels of %d samples of %d bits, the first one %u x %u of %d of %d; "
                "the pages of a volume are alike",
                s->path, s->pages + 1, form.width, form.height, form.samples, form.bits, s->form.width, s->form.height,
                s->form.samples, s->form.bits);
        }
        ++s->pages;
    } while (TIFFReadDirectory(s->tiff) == 1);
    if (s->pages == 0) return ty_fail(s->context, TY_ERROR_INPUT, "%s: a TIFF without pages", s->path);
    return s->message[0] == '\0' ? TY_OK : damaged(s);
}

/* The planes that the description tells of must be there; without one each page is a slice. */
static ty_result check_layout(stack* s) {
    ty_stack_layout* l = &s->layout;
    if (l->writer == TY_STACK_OME && l->channels % s->form.samples == 0) l->channels /= s->form.samples;
    const double planes = (double)l->slices * l->channels * l->times;
    s->contiguous = l->writer == TY_STACK_IMAGEJ && s->pages == 1 && planes > 1 &&
                    s->form.compression == COMPRESSION_NONE && s->form.samples == 1;
    if (l->writer == TY_STACK_OME && planes != s->pages)
        return ty_fail(
            s->context, TY_ERROR_INPUT,
            "%s: its OME description tells of %.0f planes, and the file has %d; those in other files are not "
            "read",
            s->path, planes, s->pages);
    if (planes != s->pages && !s->contiguous) {
        l->slices = s->pages;
        l->channels = l->times = 1;
    }
    if ((double)l->channels * l->times * s->form.samples <= COMPONENTS_MAX) return TY_OK;
    return ty_fail(s->context, TY_ERROR_INPUT, "%s: %d channels of %d samples at %d times; up to %d values can be read",
                   s->path, l->channels, s->form.samples, l->times, COMPONENTS_MAX);
}

static int32_t components_of(const stack* s) {
    return s->layout.channels * s->layout.times * s->form.samples;
}

static size_t plane_bytes(const stack* s) {
    return (size_t)s->form.width * s->form.height * s->form.samples * ty_sample_size(s->type);
}

static ty_result check_size(const stack* s, size_t* voxels) {
    const ty_stack_layout* l = &s->layout;
    const int64_t sides[3] = {s->form.width, s->form.height, l->slices};
    const ty_result result = ty_check_volume_size(s->context, s->path, sides, voxels);
    if (result != TY_OK) return result;
    const double bytes = (double)plane_bytes(s) * l->slices * l->channels * l->times;
    const double ratio = s->form.compression == COMPRESSION_NONE ? 1 : RATIO_MAX;
    if (bytes <= ratio * (double)s->size) return TY_OK;
    return ty_fail(s->context, TY_ERROR_INPUT,
                   "%s: cut short: %u x %u x %d voxels of %d values of %d bits do not fit in it", s->path,
                   s->form.width, s->form.height, l->slices, components_of(s), s->form.bits);
}

static ty_result open_stack(ty_context* context, const char* path, stack* s) {
    *s = (stack){.context = context, .path = path};
    ty_result result = ty_open_file(context, path, &s->stream, &s->size);
    if (result == TY_OK) result = open_library(s);
    if (result == TY_OK) result = count_pages(s);
    return result == TY_OK ? check_layout(s) : result;
}

static void close_stack(stack* s) {
    if (s->tiff != NULL) TIFFClose(s->tiff);
    if (s->stream != NULL) fclose(s->stream);
}

/* ---- pixels ---- */

/* Slices of the grid being filled, and the sample of each pixel that goes into them. */
typedef struct target {
    stack* s;
    ty_grid_type type;
    void* values;      /* of TY_GRID_BLOCK slices */
    uint64_t* offsets; /* of each slice: where its page's directory, or its plane, begins; 0: none */
    int32_t slice;     /* of the plane that was aimed at */
    size_t first;      /* voxel among the values */
    int32_t sample;
} target;

/* Stores a part of a plane: rows of `columns` pixels, `stride` samples apart; pixels beyond the plane are left out. */
static void store_part(const target* t, const uint8_t* bytes, uint32_t x, uint32_t y, uint32_t columns, uint32_t rows,
                       size_t step, size_t offset, bool big_endian) {
    const page_form* f = &t->s->form;
    const size_t size = ty_sample_size(t->s->type);
    for (uint32_t j = 0; j < rows && y + j < f->height; ++j)
        for (uint32_t i = 0; i < columns && x + i < f->width; ++i) {
            const size_t from = ((size_t)j * columns + i) * step + offset;
            ty_store_value(t->type, t->values, t->first + (size_t)(y + j) * f->width + x + i,
                           ty_sample_value(t->s->type, big_endian, bytes + size * from));
        }
}

static const bool host_is_big = __BYTE_ORDER__ == __ORDER_BIG_ENDIAN__;

/* Makes room for a strip or tile, which is not out of proportion to the plane. */
static ty_result make_room(const stack* s, uint64_t size, uint8_t** room) {
    enum { FREE_BYTES = 1 << 22 };
    if (size == 0 || size > 4 * (uint64_t)plane_bytes(s) + FREE_BYTES) return damaged(s);
    *room = ty_alloc_array(s->context, (size_t)size, 1, true);
    return *room != NULL ? TY_OK : TY_ERROR_MEMORY;
}

static ty_result read_strips(const target* t, uint8_t* room, uint64_t room_size) {
    const stack* s = t->s;
    const page_form* f = &s->form;
    const bool separate = f->planes == PLANARCONFIG_SEPARATE;
    uint32_t rows = f->height;
    TIFFGetFieldDefaulted(s->tiff, TIFFTAG_ROWSPERSTRIP, &rows);
    if (rows > f->height) rows = f->height;
    if (rows == 0) return damaged(s);
    for (uint32_t y = 0; y < f->height; y += rows) {
        const uint32_t count = f->height - y < rows ? f->height - y : rows;
        const uint64_t wanted = (uint64_t)count * f->width * (separate ? 1 : f->samples) * ty_sample_size(s->type);
        const uint32_t strip = TIFFComputeStrip(s->tiff, y, (uint16_t)(separate ? t->sample : 0));
        if (wanted > room_size || TIFFReadEncodedStrip(s->tiff, strip, room, (tmsize_t)wanted) != (tmsize_t)wanted)
            return damaged(s);
        store_part(t, room, 0, y, f->width, count, separate ? 1 : f->samples, separate ? 0 : (size_t)t->sample,
                   host_is_big);
    }
    return TY_OK;
}

static ty_result read_tiles(const target* t, uint8_t* room, uint64_t room_size) {
    const stack* s = t->s;
    const page_form* f = &s->form;
    const bool separate = f->planes == PLANARCONFIG_SEPARATE;
    uint32_t width = 0, height = 0;
    TIFFGetField(s->tiff, TIFFTAG_TILEWIDTH, &width);
    TIFFGetField(s->tiff, TIFFTAG_TILELENGTH, &height);
    const size_t step = separate ? 1 : f->samples;
    if (width == 0 || height == 0 || (uint64_t)width * height * step * ty_sample_size(s->type) > room_size)
        return damaged(s);
    for (uint32_t y = 0; y < f->height; y += height)
        for (uint32_t x = 0; x < f->width; x += width) {
            const uint32_t tile = TIFFComputeTile(s->tiff, x, y, 0, (uint16_t)(separate ? t->sample : 0));
            if (TIFFReadEncodedTile(s->tiff, tile, room, (tmsize_t)room_size) < 0) return damaged(s);
            store_part(t, room, x, y, width, height, step, separate ? 0 : (size_t)t->sample, host_is_big);
        }
    return TY_OK;
}

/* Reads the current page. */
static ty_result read_page(const target* t) {
    const stack* s = t->s;
    if (s->form.compression == COMPRESSION_JPEG) TIFFSetField(s->tiff, TIFFTAG_JPEGCOLORMODE, JPEGCOLORMODE_RGB);
    const bool tiled = TIFFIsTiled(s->tiff) != 0;
    const uint64_t size = tiled ? TIFFTileSize64(s->tiff) : TIFFStripSize64(s->tiff);
    uint8_t* room = NULL;
    ty_result result = make_room(s, size, &room);
    if (result != TY_OK) return result;
    result = tiled ? read_tiles(t, room, size) : read_strips(t, room, size);
    ty_free_array(s->context, room, (size_t)size, 1);
    return result;
}

/* Index of a plane along slices, channels and times. */
static void find_plane(const ty_stack_layout* l, int32_t plane, int32_t* slice, int32_t* channel, int32_t* time) {
    for (int i = 0; i < 3; ++i) {
        int32_t* index = l->order[i] == 'Z' ? slice : l->order[i] == 'C' ? channel : time;
        const int32_t count = l->order[i] == 'Z' ? l->slices : l->order[i] == 'C' ? l->channels : l->times;
        *index = plane % count;
        plane /= count;
    }
}

/* True if a plane belongs to the component; t->slice is then its slice. */
static bool aim(target* t, int32_t plane, int32_t component) {
    const stack* s = t->s;
    int32_t slice = 0, channel = 0, time = 0;
    find_plane(&s->layout, plane, &slice, &channel, &time);
    const int32_t rest = component / s->form.samples;
    t->sample = component % s->form.samples;
    t->slice = slice;
    return channel == rest % s->layout.channels && time == rest / s->layout.channels;
}

/* Notes where each page of the component begins: its directory. */
static ty_result find_pages(target* t, int32_t component) {
    stack* s = t->s;
    if (TIFFSetDirectory(s->tiff, 0) != 1) return damaged(s);
    int32_t plane = 0;
    do {
        if (is_slice(s->tiff) && aim(t, plane++, component)) t->offsets[t->slice] = TIFFCurrentDirOffset(s->tiff);
    } while (plane < s->pages && TIFFReadDirectory(s->tiff) == 1);
    return s->message[0] == '\0' ? TY_OK : damaged(s);
}

/* Notes where each plane of the component begins behind the first one. */
static ty_result find_contiguous(target* t, int32_t component) {
    const stack* s = t->s;
    const uint64_t* offsets = NULL;
    const int32_t planes = s->layout.slices * s->layout.channels * s->layout.times;
    if (TIFFSetDirectory(s->tiff, 0) != 1 || TIFFGetField(s->tiff, TIFFTAG_STRIPOFFSETS, &offsets) != 1 ||
        offsets == NULL)
        return damaged(s);
    const uint64_t start = offsets[0];
    for (int32_t plane = 0; plane < planes; ++plane)
        if (aim(t, plane, component)) t->offsets[t->slice] = start + (uint64_t)plane * plane_bytes(s);
    return TY_OK;
}

static ty_result read_contiguous(const target* t, uint64_t offset) {
    const stack* s = t->s;
    const size_t bytes = plane_bytes(s);
    uint8_t* room = NULL;
    ty_result result = make_room(s, bytes, &room);
    if (result != TY_OK) return result;
    if (offset > (uint64_t)INT64_MAX || fseeko(s->stream, (off_t)offset, SEEK_SET) != 0 ||
        fread(room, 1, bytes, s->stream) != bytes)
        result = damaged(s);
    else
        store_part(t, room, 0, 0, s->form.width, s->form.height, 1, 0, TIFFIsBigEndian(s->tiff) != 0);
    ty_free_array(s->context, room, bytes, 1);
    return result;
}

/* As ty_slice_source. */
static ty_result read_slices(void* user, int32_t first, int32_t count, const void** values) {
    target* t = user;
    const size_t pixels = (size_t)t->s->form.width * t->s->form.height;
    ty_result result = TY_OK;
    memset(t->values, 0, pixels * (size_t)count * ty_grid_value_size(t->type));
    for (int32_t k = 0; k < count && result == TY_OK; ++k) {
        const uint64_t offset = t->offsets[first + k];
        t->first = pixels * (size_t)k;
        if (offset == 0) continue;
        if (t->s->contiguous)
            result = read_contiguous(t, offset);
        else
            result = TIFFSetSubDirectory(t->s->tiff, offset) == 1 ? read_page(t) : damaged(t->s);
    }
    *values = t->values;
    return result;
}

/* ---- the grid ---- */

/* Spacings of the description; ImageJ keeps those within a slice as a resolution, in pixels per unit. */
static void place(const stack* s, ty_grid_def* def) {
    const ty_stack_layout* l = &s->layout;
    double spacing[3] = {l->spacing[0], l->spacing[1], l->spacing[2]};
    const bool unit = l->unit[0] != '\0' && strncmp(l->unit, "pixel", 5) != 0;
    for (int a = 0; a < 2 && l->writer == TY_STACK_IMAGEJ && unit; ++a)
        spacing[a] = s->resolution[a] > 0 ? 1 / s->resolution[a] : 0;
    for (int a = 0; a < 3; ++a) {
        def->placed = def->placed || spacing[a] > 0;
        def->index_to_local.m[5 * a] = spacing[a] > 0 ? spacing[a] : 1;
    }
}

static ty_result make_grid(stack* s, int32_t component, const ty_grid_def* def, const ty_grid_plan* plan,
                           ty_grid** out) {
    const size_t slices = (size_t)def->size[2], slab = slices < TY_GRID_BLOCK ? slices : (size_t)TY_GRID_BLOCK;
    const size_t count = slab * s->form.width * s->form.height, value = ty_grid_value_size(def->type);
    target t = {.s = s, .type = def->type};
    t.offsets = ty_alloc_array(s->context, slices, sizeof *t.offsets, true);
    t.values = t.offsets == NULL ? NULL : ty_alloc_array(s->context, count, value, false);
    ty_result result = t.values == NULL ? TY_ERROR_MEMORY
                       : s->contiguous  ? find_contiguous(&t, component)
                                        : find_pages(&t, component);
    const ty_slice_source source = {read_slices, &t, 0, 0};
    if (result == TY_OK) result = ty_grid_create_from_slices(s->context, def, plan, &source, def->placed, out);
    ty_free_array(s->context, t.values, count, value);
    ty_free_array(s->context, t.offsets, slices, sizeof *t.offsets);
    return result;
}

ty_result ty_tiff_read(ty_context* context, const char* path, int32_t component, const ty_grid_plan* plan,
                       ty_grid** out) {
    stack s;
    size_t voxels = 0;
    ty_grid_def def = ty_default_grid_def();
    ty_result result = open_stack(context, path, &s);
    if (result == TY_OK) result = ty_check_component(context, path, NULL, component, components_of(&s));
    if (result == TY_OK) result = check_size(&s, &voxels);
    if (result == TY_OK) {
        def.size[0] = (int32_t)s.form.width;
        def.size[1] = (int32_t)s.form.height;
        def.size[2] = s.layout.slices;
        def.type = ty_sample_grid_type(s.type);
        place(&s, &def);
        result = make_grid(&s, component, &def, plan, out);
    }
    close_stack(&s);
    return result;
}

ty_result ty_tiff_components(ty_context* context, const char* path, int32_t* out) {
    stack s;
    size_t voxels = 0;
    ty_result result = open_stack(context, path, &s);
    if (result == TY_OK) result = check_size(&s, &voxels);
    if (result == TY_OK) *out = components_of(&s);
    close_stack(&s);
    return result;
}

void ty_tiff_describe(ty_context* context, const char* path, ty_volume_notes* notes) {
    static const char* const writers[] = {"", ", by ImageJ", ", OME"};
    stack s;
    if (open_stack(context, path, &s) == TY_OK) {
        const TIFFCodec* codec = TIFFFindCODEC(s.form.compression);
        ty_note(notes, "format", "TIFF, %s, %s%s", ty_sample_name(s.type), codec != NULL ? codec->name : "?",
                writers[s.layout.writer]);
        ty_note(notes, "planes", "%d slices, %d channels, %d times", s.layout.slices, s.layout.channels,
                s.layout.times);
        if (s.layout.unit[0] != '\0') ty_note(notes, "unit", "%s", s.layout.unit);
    }
    close_stack(&s);
}

#else

ty_result ty_tiff_read(ty_context* context, const char* path, int32_t component, const ty_grid_plan* plan,
                       ty_grid** out) {
    int32_t components;
    (void)component;
    (void)out;
    return ty_tiff_components(context, path, &components);
}

ty_result ty_tiff_components(ty_context* context, const char* path, int32_t* out) {
    (void)out;
    return ty_fail(context, TY_ERROR_INPUT, "%s: a TIFF, which this build was made without", path);
}

void ty_tiff_describe(ty_context* context, const char* path, ty_volume_notes* notes) {
    (void)context;
    (void)path;
    (void)notes;
}

#endif
