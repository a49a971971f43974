/* Data elements of DICOM files (PS3.5 chapter 7), with explicit or implicit value representations, in either byte
 * order. Sequences are followed only where they may hold what places the frames. */
#include "io/volumes/dicom/dicom.h"

#include "base/context.h"
#include "base/number.h"
#include "io/file.h"
#include "io/volumes/inflate.h"
#include "io/volumes/samples.h"
#include "io/volumes/volume_file.h"

#include <math.h>
#include <string.h>

enum { PREAMBLE = 128, HEAD_SIZE = 1 << 16, DEPTH_MAX = 16, VALUE_MAX = 256 };

#define UNDEFINED_LENGTH UINT32_MAX

static const size_t file_size_max = (size_t)1 << 32;

#define TAG(group, element) ((uint32_t)(group) << 16 | (uint32_t)(element))

enum {
    TAG_SYNTAX = TAG(0x0002, 0x0010),
    TAG_ITEM = (int)TAG(0xfffe, 0xe000),
    TAG_ITEM_END = (int)TAG(0xfffe, 0xe00d),
    TAG_SEQUENCE_END = (int)TAG(0xfffe, 0xe0dd),
    TAG_DETECTORS = TAG(0x0054, 0x0022), /* that place the frames of nuclear medicine (PS3.3 C.8.4.11) */
    TAG_SHARED_GROUPS = TAG(0x5200, 0x9229),
    TAG_FRAME_GROUPS = TAG(0x5200, 0x9230),
    TAG_FLOATS = TAG(0x7fe0, 0x0008),
    TAG_DOUBLES = TAG(0x7fe0, 0x0009),
    TAG_PIXELS = TAG(0x7fe0, 0x0010)
};

/* Owner of the elements of an item: the file, all frames, a frame, or nothing of interest. */
typedef enum scope { SCOPE_FILE, SCOPE_SHARED, SCOPE_FRAME, SCOPE_OTHER } scope;

typedef struct reader {
    ty_context* context;
    const char* path;
    ty_dicom* out;
    const uint8_t* bytes;
    size_t size, at;
    bool explicit_vr, big_endian;
    bool cut; /* an element goes past the end of the bytes */
} reader;

typedef struct element {
    uint32_t tag, length;
    char vr[3]; /* "" without */
    size_t value;
} element;

/* ---- elements ---- */

static uint32_t integer(const reader* r, size_t at, ty_sample_type type) {
    return (uint32_t)ty_sample_value(type, r->big_endian, r->bytes + at);
}

static bool has_long_length(const char* vr) {
    static const char names[] = "OB OD OF OL OV OW SQ SV UC UN UR UT UV";
    return strstr(names, vr) != NULL;
}

/* Reads the head of the next element; false at the end of the bytes. */
static bool next_element(reader* r, size_t end, element* e) {
    enum { SHORT_HEAD = 8, LONG_HEAD = 12 };
    if (end - r->at < SHORT_HEAD) {
        r->cut = r->cut || (end == r->size && r->at < end);
        return false;
    }
    *e = (element){.tag = TAG(integer(r, r->at, TY_SAMPLE_UINT16), integer(r, r->at + 2, TY_SAMPLE_UINT16))};
    size_t head = SHORT_HEAD;
    if (!r->explicit_vr || e->tag >> 16 == 0xfffe) {
        e->length = integer(r, r->at + 4, TY_SAMPLE_UINT32);
    } else {
        memcpy(e->vr, r->bytes + r->at + 4, 2);
        if (has_long_length(e->vr)) {
            head = LONG_HEAD;
            if (end - r->at < LONG_HEAD) {
                r->cut = true;
                return false;
            }
            e->length = integer(r, r->at + 8, TY_SAMPLE_UINT32);
        } else {
            e->length = integer(r, r->at + 6, TY_SAMPLE_UINT16);
        }
    }
    r->at += head;
    e->value = r->at;
    return true;
}

/* ---- values ---- */

/* The value as text, without the blanks and zeros around it. */
static void take_text(const reader* r, const element* e, char* text, size_t size) {
    size_t length = e->length < size - 1 ? e->length : size - 1;
    const char* from = (const char*)r->bytes + e->value;
    while (length > 0 && *from == ' ') {
        ++from;
        --length;
    }
    while (length > 0 && (from[length - 1] == ' ' || from[length - 1] == '\0')) --length;
    memcpy(text, from, length);
    text[length] = '\0';
}

/* Numbers of a decimal string, separated by backslashes; true if there are `count` finite ones. */
static bool take_numbers(const reader* r, const element* e, double* out, int count) {
    char text[VALUE_MAX];
    take_text(r, e, text, sizeof text);
    const char *at = text, *end = text;
    for (int i = 0; i < count; ++i) {
        const double value = ty_parse_number(at, &end);
        if (end == at || !(fabs(value) <= 1e15)) return false;
        end += strspn(end, " ");
        if (i < count - 1 && *end != '\\') return false;
        out[i] = value;
        at = end + 1;
    }
    return true;
}

static int32_t take_integer_text(const reader* r, const element* e) {
    char text[VALUE_MAX];
    const char* end;
    take_text(r, e, text, sizeof text);
    const int64_t value = ty_parse_integer(text, &end);
    return end == text || value < INT32_MIN || value > INT32_MAX ? 0 : (int32_t)value;
}

static int32_t take_short(const reader* r, const element* e) {
    return e->length >= 2 ? (int32_t)integer(r, e->value, TY_SAMPLE_UINT16) : 0;
}

/* Decimal strings of any number. */
static ty_result take_offsets(reader* r, const element* e) {
    ty_dicom* out = r->out;
    const char *at = (const char*)r->bytes + e->value, *end = at + e->length;
    while (at < end) {
        char text[32];
        const char* separator = memchr(at, '\\', (size_t)(end - at));
        const size_t length = (size_t)((separator != NULL ? separator : end) - at);
        const size_t kept = length < sizeof text ? length : sizeof text - 1;
        memcpy(text, at, kept);
        text[kept] = '\0';
        const char* stop;
        const double value = ty_parse_number(text, &stop);
        if (stop == text || !(fabs(value) <= 1e15)) return TY_OK; /* fewer than there are frames */
        if (!ty_grow_array(r->context, (void**)&out->offsets, &out->offset_capacity, out->offset_count, sizeof(double)))
            return TY_ERROR_MEMORY;
        out->offsets[out->offset_count++] = value;
        at += length + 1;
    }
    return TY_OK;
}

static void take_place(const reader* r, const element* e, ty_dicom_frame* f) {
    switch (e->tag) {
    case TAG(0x0020, 0x0032): f->has_position = take_numbers(r, e, f->position, 3); break;
    case TAG(0x0020, 0x0037): f->has_orientation = take_numbers(r, e, f->orientation, 6); break;
    case TAG(0x0028, 0x0030): f->has_spacing = take_numbers(r, e, f->spacing, 2); break;
    case TAG(0x0028, 0x1052): f->has_intercept = take_numbers(r, e, &f->intercept, 1); break;
    case TAG(0x0028, 0x1053): f->has_slope = take_numbers(r, e, &f->slope, 1); break;
    case TAG(0x0018, 0x0050): take_numbers(r, e, &r->out->thickness, 1); break;
    case TAG(0x0018, 0x0088): take_numbers(r, e, &r->out->between, 1); break;
    default: break;
    }
}

static ty_result take_file_value(reader* r, const element* e) {
    ty_dicom* out = r->out;
    switch (e->tag) {
    case TAG(0x0008, 0x0060): take_text(r, e, out->modality, sizeof out->modality); break;
    case TAG(0x0008, 0x103e): take_text(r, e, out->description, sizeof out->description); break;
    case TAG(0x0020, 0x000e): take_text(r, e, out->series, sizeof out->series); break;
    case TAG(0x0020, 0x0011): out->series_number = take_integer_text(r, e); break;
    case TAG(0x0028, 0x0002): out->samples = take_short(r, e); break;
    case TAG(0x0028, 0x0004): take_text(r, e, out->photometric, sizeof out->photometric); break;
    case TAG(0x0028, 0x0008): out->frames = take_integer_text(r, e); break;
    case TAG(0x0028, 0x0010): out->rows = take_short(r, e); break;
    case TAG(0x0028, 0x0011): out->columns = take_short(r, e); break;
    case TAG(0x0028, 0x0100): out->bits_allocated = take_short(r, e); break;
    case TAG(0x0028, 0x0101): out->bits_stored = take_short(r, e); break;
    case TAG(0x0028, 0x0102): out->high_bit = take_short(r, e); break;
    case TAG(0x0028, 0x0103): out->is_signed = take_short(r, e) == 1; break;
    case TAG(0x3004, 0x000c): return take_offsets(r, e);
    case TAG(0x3004, 0x000e): take_numbers(r, e, &out->dose_scale, 1); break;
    default: take_place(r, e, &out->shared); break;
    }
    return TY_OK;
}

/* ---- sequences ---- */

static ty_result read_elements(reader* r, size_t end, scope in, int depth);

/* Scope of a sequence's items; frames and what they share have their values in sequences of one item. */
static scope scope_of(uint32_t tag, scope in) {
    if (in == SCOPE_FILE && (tag == TAG_SHARED_GROUPS || tag == TAG_DETECTORS)) return SCOPE_SHARED;
    if (in == SCOPE_FILE && tag == TAG_FRAME_GROUPS) return SCOPE_FRAME;
    if (in == SCOPE_FILE || in == SCOPE_OTHER) return SCOPE_OTHER;
    switch (tag) {
    case TAG(0x0020, 0x9113): /* plane position */
    case TAG(0x0020, 0x9116): /* plane orientation */
    case TAG(0x0028, 0x9110): /* pixel measures */
    case TAG(0x0028, 0x9145): /* pixel value transformation */ return in;
    default: return SCOPE_OTHER;
    }
}

static ty_result too_deep(const reader* r) {
    return ty_fail(r->context, TY_ERROR_INPUT, "%s: DICOM sequences more than %d deep", r->path, DEPTH_MAX);
}

/* Items up to `end`, or up to the delimiter of a sequence of undefined length. Those of pixel data are fragments. */
static ty_result read_items(reader* r, const element* sequence, size_t end, scope in, int depth) {
    const bool fragments = sequence->tag == TAG_PIXELS || (sequence->vr[0] == 'O' && sequence->vr[1] != '\0');
    element item;
    while (r->at < end && next_element(r, end, &item)) {
        if (item.tag == (uint32_t)TAG_SEQUENCE_END) return TY_OK;
        if (item.tag != (uint32_t)TAG_ITEM)
            return ty_fail(r->context, TY_ERROR_INPUT, "%s: a DICOM sequence is damaged at byte %zu", r->path, r->at);
        if (item.length != UNDEFINED_LENGTH && item.length > end - r->at) {
            r->cut = true;
            return TY_OK;
        }
        const size_t item_end = item.length == UNDEFINED_LENGTH ? end : r->at + item.length;
        if (sequence->tag == TAG_FRAME_GROUPS && in == SCOPE_FRAME) {
            ty_dicom* out = r->out;
            if (!ty_grow_array(r->context, (void**)&out->places, &out->place_capacity, out->place_count,
                               sizeof *out->places))
                return TY_ERROR_MEMORY;
            out->places[out->place_count++] = (ty_dicom_frame){0};
        }
        const ty_result result = fragments ? TY_OK : read_elements(r, item_end, in, depth);
        if (result != TY_OK || r->cut) return result;
        if (item.length != UNDEFINED_LENGTH) r->at = item_end;
    }
    return TY_OK;
}

/* Follows a sequence, or passes over it. */
static ty_result read_sequence(reader* r, const element* e, size_t end, scope in, int depth) {
    if (depth >= DEPTH_MAX) return too_deep(r);
    const bool explicit_vr = r->explicit_vr, big_endian = r->big_endian;
    if (strcmp(e->vr, "UN") == 0) r->explicit_vr = r->big_endian = false; /* PS3.5 section 6.2.2, note 2 */
    const size_t sequence_end = e->length == UNDEFINED_LENGTH ? end : r->at + e->length;
    const ty_result result = read_items(r, e, sequence_end, scope_of(e->tag, in), depth + 1);
    r->explicit_vr = explicit_vr;
    r->big_endian = big_endian;
    if (result == TY_OK && !r->cut && e->length != UNDEFINED_LENGTH) r->at = sequence_end;
    return result;
}

static void find_pixels(reader* r, const element* e) {
    ty_dicom* out = r->out;
    out->pixels = e->value;
    out->encapsulated = e->length == UNDEFINED_LENGTH;
    out->pixel_size = out->encapsulated ? r->size - e->value : e->length;
    out->floats = e->tag != TAG_PIXELS;
    out->words = strcmp(e->vr, "OB") != 0;
}

static bool holds_pixels(const element* e) {
    return e->tag == TAG_PIXELS || e->tag == TAG_FLOATS || e->tag == TAG_DOUBLES;
}

static ty_result read_elements(reader* r, size_t end, scope in, int depth) {
    element e;
    while (r->at < end && next_element(r, end, &e)) {
        if (e.tag == (uint32_t)TAG_ITEM_END) return TY_OK;
        if (in == SCOPE_FILE && holds_pixels(&e)) {
            find_pixels(r, &e);
            return TY_OK;
        }
        const bool undefined = e.length == UNDEFINED_LENGTH;
        if (!undefined && e.length > end - r->at) {
            r->cut = true;
            return TY_OK;
        }
        ty_result result = TY_OK;
        if (undefined || scope_of(e.tag, in) != SCOPE_OTHER) {
            result = read_sequence(r, &e, end, in, depth);
        } else {
            if (in == SCOPE_FILE) result = take_file_value(r, &e);
            if (in == SCOPE_SHARED) take_place(r, &e, &r->out->shared);
            if (in == SCOPE_FRAME) take_place(r, &e, &r->out->places[r->out->place_count - 1]);
            r->at += e.length;
        }
        if (result != TY_OK || r->cut) return result;
    }
    return TY_OK;
}

/* ---- files ---- */

bool ty_is_dicom(const uint8_t* bytes, size_t size) {
    return size >= PREAMBLE + 4 && memcmp(bytes + PREAMBLE, "DICM", 4) == 0;
}

static const struct {
    const char* uid;
    const char* name;
    ty_dicom_coding coding;
} syntaxes[] = {{"1.2.840.10008.1.2", "not compressed", TY_DICOM_RAW},
                {"1.2.840.10008.1.2.1", "not compressed", TY_DICOM_RAW},
                {"1.2.840.10008.1.2.1.99", "deflated", TY_DICOM_RAW},
                {"1.2.840.10008.1.2.2", "not compressed, big-endian", TY_DICOM_RAW},
                {"1.2.840.10008.1.2.4.50", "JPEG baseline", TY_DICOM_JPEG},
                {"1.2.840.10008.1.2.4.51", "JPEG extended", TY_DICOM_JPEG},
                {"1.2.840.10008.1.2.4.57", "JPEG lossless", TY_DICOM_JPEG},
                {"1.2.840.10008.1.2.4.70", "JPEG lossless, first order", TY_DICOM_JPEG},
                {"1.2.840.10008.1.2.4.80", "JPEG-LS", TY_DICOM_JPEG_LS},
                {"1.2.840.10008.1.2.4.81", "JPEG-LS, near-lossless", TY_DICOM_JPEG_LS},
                {"1.2.840.10008.1.2.4.90", "JPEG 2000 lossless", TY_DICOM_JPEG_2000},
                {"1.2.840.10008.1.2.4.91", "JPEG 2000", TY_DICOM_JPEG_2000},
                {"1.2.840.10008.1.2.5", "RLE", TY_DICOM_RLE}};
enum { SYNTAXES = sizeof syntaxes / sizeof syntaxes[0], SYNTAX_DEFLATED = 2, SYNTAX_BIG_ENDIAN = 3 };

static int find_syntax(const char* uid) {
    int i = 0;
    while (i < SYNTAXES && strcmp(syntaxes[i].uid, uid) != 0) ++i;
    return i;
}

const char* ty_dicom_coding_name(const ty_dicom* dicom) {
    const int syntax = find_syntax(dicom->syntax);
    return syntax < SYNTAXES ? syntaxes[syntax].name : dicom->syntax;
}

/* A file without meta information has implicit value representations, unless two letters stand where one would be. */
static void guess_syntax(reader* r) {
    const uint8_t* vr = r->bytes + r->at + 4;
    const bool letters = r->size - r->at >= 8 && vr[0] >= 'A' && vr[0] <= 'Z' && vr[1] >= 'A' && vr[1] <= 'Z';
    snprintf(r->out->syntax, sizeof r->out->syntax, "%s", syntaxes[letters ? 1 : 0].uid);
}

/* File meta information (PS3.10 chapter 7), always explicit and little-endian. */
static void read_meta(reader* r) {
    element e;
    r->explicit_vr = true;
    for (;;) {
        const size_t start = r->at;
        if (!next_element(r, r->size, &e) || e.tag >> 16 != 0x0002 || e.length > r->size - r->at) {
            r->at = start;
            break;
        }
        if (e.tag == TAG_SYNTAX) take_text(r, &e, r->out->syntax, sizeof r->out->syntax);
        r->at += e.length;
    }
    if (r->out->syntax[0] == '\0') guess_syntax(r);
    const int syntax = find_syntax(r->out->syntax);
    r->out->coding = syntax < SYNTAXES ? syntaxes[syntax].coding : TY_DICOM_UNKNOWN;
    r->out->explicit_vr = r->explicit_vr = syntax != 0;
    r->out->big_endian = r->big_endian = syntax == SYNTAX_BIG_ENDIAN;
    r->out->deflated = syntax == SYNTAX_DEFLATED;
}

/* Exchanges the bytes for what they inflate to. */
static ty_result inflate_rest(reader* r) {
    uint8_t* plain = NULL;
    size_t size = 0;
    const ty_result result =
        ty_inflate_bare(r->context, r->path, r->bytes + r->at, r->size - r->at, file_size_max, &plain, &size);
    if (result != TY_OK) return result;
    ty_free_file(r->context, r->out->bytes, r->out->size);
    r->out->bytes = plain;
    r->out->size = size;
    r->bytes = plain;
    r->size = size;
    r->at = 0;
    return TY_OK;
}

static ty_result parse(ty_context* context, const char* path, ty_dicom* out, bool* incomplete) {
    reader r = {.context = context, .path = path, .out = out, .bytes = out->bytes, .size = out->size};
    r.at = ty_is_dicom(r.bytes, r.size) ? PREAMBLE + 4 : 0;
    read_meta(&r);
    *incomplete = out->deflated && !out->whole;
    if (*incomplete) return TY_OK;
    r.cut = false;
    ty_result result = out->deflated ? inflate_rest(&r) : TY_OK;
    if (result == TY_OK) result = read_elements(&r, r.size, SCOPE_FILE, 0);
    if (result != TY_OK) return result;
    *incomplete = out->pixels == 0 && !out->whole;
    if (r.cut && out->whole) return ty_fail(context, TY_ERROR_INPUT, "%s: cut short in its DICOM elements", path);
    return TY_OK;
}

static void forget(ty_context* context, ty_dicom* dicom) {
    ty_dicom_close(context, dicom);
    *dicom = (ty_dicom){.frames = 1, .samples = 1};
}

/* As ty_file_form_fn: what is not compressed is as long as its elements say. */
static ty_result inspect(ty_context* context, const char* path, uint8_t* head, size_t size, ty_file_form* form) {
    ty_dicom dicom = {.bytes = head, .size = size};
    bool incomplete = false;
    const ty_result result = parse(context, path, &dicom, &incomplete);
    if (result == TY_OK && dicom.pixels > 0 && !dicom.encapsulated)
        form->longest = (uint64_t)dicom.pixels + dicom.pixel_size + TY_FILE_SLACK;
    dicom.bytes = NULL;
    ty_dicom_close(context, &dicom);
    return result;
}

ty_result ty_dicom_open(ty_context* context, const char* path, bool pixels, ty_dicom* out) {
    bool incomplete = !pixels;
    ty_result result = TY_OK;
    *out = (ty_dicom){.frames = 1, .samples = 1};
    if (!pixels) {
        result = ty_read_part(context, path, 0, HEAD_SIZE, &out->bytes, &out->size);
        out->whole = out->size < HEAD_SIZE;
        if (result == TY_OK) result = parse(context, path, out, &incomplete);
        if (result != TY_OK || !incomplete) return result;
        forget(context, out);
    }
    result = ty_read_inspected_file(context, path, file_size_max, inspect, &out->bytes, &out->size);
    out->whole = true;
    return result == TY_OK ? parse(context, path, out, &incomplete) : result;
}

void ty_dicom_close(ty_context* context, ty_dicom* dicom) {
    if (dicom->bytes != NULL) ty_free_file(context, dicom->bytes, dicom->size);
    ty_free_array(context, dicom->places, dicom->place_capacity, sizeof *dicom->places);
    ty_free_array(context, dicom->offsets, dicom->offset_capacity, sizeof *dicom->offsets);
    *dicom = (ty_dicom){0};
}

/* ---- frames ---- */

static void inherit(ty_dicom_frame* frame, const ty_dicom_frame* shared) {
    if (!frame->has_position) memcpy(frame->position, shared->position, sizeof frame->position);
    if (!frame->has_orientation) memcpy(frame->orientation, shared->orientation, sizeof frame->orientation);
    if (!frame->has_spacing) memcpy(frame->spacing, shared->spacing, sizeof frame->spacing);
    if (!frame->has_slope) frame->slope = shared->slope;
    if (!frame->has_intercept) frame->intercept = shared->intercept;
    frame->has_position = frame->has_position || shared->has_position;
    frame->has_orientation = frame->has_orientation || shared->has_orientation;
    frame->has_spacing = frame->has_spacing || shared->has_spacing;
    frame->has_slope = frame->has_slope || shared->has_slope;
}

/* Frames without places of their own follow one another along the normal, or against it where the spacing between them
 * is negative (PS3.3 C.8.4.15). */
static void step_along_normal(const ty_dicom* dicom, int32_t frame, ty_dicom_frame* f) {
    const double* o = f->orientation;
    const double normal[3] = {o[1] * o[5] - o[2] * o[4], o[2] * o[3] - o[0] * o[5], o[0] * o[4] - o[1] * o[3]};
    const double between = dicom->between != 0 ? dicom->between : dicom->thickness > 0 ? dicom->thickness : 1;
    const bool listed = (size_t)frame < dicom->offset_count;
    const double distance = listed ? dicom->offsets[frame] - dicom->offsets[0] : between * frame;
    for (int a = 0; a < 3; ++a) f->position[a] += normal[a] * distance;
}

ty_dicom_frame ty_dicom_place(const ty_dicom* dicom, int32_t frame) {
    const bool own = (size_t)frame < dicom->place_count;
    ty_dicom_frame f = own ? dicom->places[frame] : dicom->shared;
    const bool placed = own && f.has_position;
    if (own) inherit(&f, &dicom->shared);
    if (!f.has_orientation) memcpy(f.orientation, (const double[]){1, 0, 0, 0, 1, 0}, sizeof f.orientation);
    if (!f.has_spacing) f.spacing[0] = f.spacing[1] = 1;
    if (!f.has_slope) f.slope = dicom->dose_scale > 0 ? dicom->dose_scale : 1;
    if (dicom->frames > 1 && !placed) step_along_normal(dicom, frame, &f);
    return f;
}
