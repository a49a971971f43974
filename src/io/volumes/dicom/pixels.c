/* Frames of DICOM files: where they lie, their decoding, and their samples as values. */
#include "io/volumes/dicom/dicom.h"

#include "base/context.h"
#include "io/volumes/dicom/codec.h"
#include "io/volumes/samples.h"
#include "io/volumes/volume_file.h"

#include <string.h>

size_t ty_dicom_sample_size(const ty_dicom* dicom) {
    return (size_t)dicom->bits_allocated / 8;
}

static uint64_t frame_bytes(const ty_dicom* dicom) {
    return (uint64_t)dicom->columns * (uint64_t)dicom->rows * ty_dicom_sample_size(dicom);
}

/* ---- checks ---- */

static ty_result check_kind(ty_context* context, const char* path, const ty_dicom* d) {
    if (d->pixels == 0) return ty_fail(context, TY_ERROR_INPUT, "%s: a DICOM file without pixel data", path);
    if (d->coding == TY_DICOM_UNKNOWN)
        return ty_fail(context, TY_ERROR_INPUT,
                       "%s: its transfer syntax %s cannot be read; \"gdcmconv --raw\" may convert it", path, d->syntax);
    if (d->samples != 1 || strcmp(d->photometric, "PALETTE COLOR") == 0)
        return ty_fail(context, TY_ERROR_INPUT, "%s: a colour image (%s), not one value per voxel", path,
                       d->photometric);
    if (d->rows < 1 || d->columns < 1 || d->frames < 1)
        return ty_fail(context, TY_ERROR_INPUT, "%s: %d x %d pixels in %d frames", path, d->columns, d->rows,
                       d->frames);
    return TY_OK;
}

static ty_result check_bits(ty_context* context, const char* path, const ty_dicom* d) {
    const bool known = d->floats ? d->bits_allocated == 32 || d->bits_allocated == 64
                                 : d->bits_allocated == 8 || d->bits_allocated == 16 || d->bits_allocated == 32;
    if (!known)
        return ty_fail(context, TY_ERROR_INPUT,
                       "%s: %d bits allocated to a sample cannot be read (8, 16 and 32; 32 and 64 of floats)", path,
                       d->bits_allocated);
    if (d->floats || (d->bits_stored >= 1 && d->bits_stored <= d->bits_allocated && d->high_bit < d->bits_allocated &&
                      d->high_bit >= d->bits_stored - 1))
        return TY_OK;
    return ty_fail(context, TY_ERROR_INPUT, "%s: %d bits stored up to bit %d do not fit in %d bits", path,
                   d->bits_stored, d->high_bit, d->bits_allocated);
}

ty_result ty_dicom_check_pixels(ty_context* context, const char* path, const ty_dicom* d, uint64_t file_size) {
    /* Of blank frames, larger than any decoder needs; bytes of the head of a fragment, of which each frame has one. */
    enum { FREE_BYTES = 1 << 20, RATIO_MAX = 1 << 16, FRAGMENT_HEAD = 8 };
    ty_result result = check_kind(context, path, d);
    if (result == TY_OK) result = check_bits(context, path, d);
    size_t voxels;
    if (result == TY_OK)
        result = ty_check_volume_size(context, path, (const int64_t[]){d->columns, d->rows, 1}, &voxels);
    if (result != TY_OK) return result;
    if (d->encapsulated != (d->coding != TY_DICOM_RAW))
        return ty_fail(context, TY_ERROR_INPUT, "%s: its pixel data is %s, which its transfer syntax (%s) excludes",
                       path, d->encapsulated ? "in fragments" : "not in fragments", ty_dicom_coding_name(d));
    const uint64_t all = d->deflated ? d->size : file_size, left = all > d->pixels ? all - d->pixels : 0;
    const uint64_t found = d->encapsulated        ? left * RATIO_MAX + FREE_BYTES
                           : d->pixel_size < left ? d->pixel_size
                                                  : left;
    uint64_t frames = found / frame_bytes(d);
    if (d->encapsulated && left / FRAGMENT_HEAD < frames) frames = left / FRAGMENT_HEAD;
    if ((uint64_t)d->frames <= frames) return TY_OK;
    return ty_fail(context, TY_ERROR_INPUT, "%s: cut short: %d x %d pixels of %d bits in %d frames do not fit in it",
                   path, d->columns, d->rows, d->bits_allocated, d->frames);
}

/* ---- fragments (PS3.5 annex A.4) ---- */

typedef struct fragment {
    size_t start, size; /* of its data in the file */
} fragment;

/* Reads the fragment at *at and moves on; false at the end of the sequence or of the bytes. */
static bool next_fragment(const ty_dicom* d, size_t* at, fragment* out) {
    static const uint8_t item[4] = {0xfe, 0xff, 0x00, 0xe0};
    enum { HEAD = 8 };
    if (d->size - *at < HEAD || memcmp(d->bytes + *at, item, sizeof item) != 0) return false;
    out->start = *at + HEAD;
    out->size = (size_t)ty_sample_value(TY_SAMPLE_UINT32, false, d->bytes + *at + 4);
    if (out->size > d->size - out->start) return false;
    *at = out->start + out->size;
    return true;
}

/* The fragments of a frame: the first, and how many. */
typedef struct frame_fragments {
    size_t at, count, bytes;
} frame_fragments;

static uint64_t table_entry(const ty_dicom* d, const fragment* table, int32_t frame) {
    return (uint64_t)ty_sample_value(TY_SAMPLE_UINT32, false, d->bytes + table->start + 4 * (size_t)frame);
}

/* Fragments that begin within [low, high) of what follows the table. */
static frame_fragments select_range(const ty_dicom* d, size_t first, uint64_t low, uint64_t high) {
    frame_fragments out = {0};
    size_t at = first, here = first;
    for (fragment f; next_fragment(d, &at, &f); here = at) {
        if (here - first < low || here - first >= high) continue;
        if (out.count == 0) out.at = here;
        ++out.count;
        out.bytes += f.size;
    }
    return out;
}

static frame_fragments select_one(const ty_dicom* d, size_t first, int32_t index) {
    frame_fragments out = {0};
    size_t at = first, here = first;
    fragment f;
    for (int32_t i = 0; next_fragment(d, &at, &f); ++i, here = at)
        if (i == index) out = (frame_fragments){here, 1, f.size};
    return out;
}

static ty_result find_frame(ty_context* context, const char* path, const ty_dicom* d, int32_t frame,
                            frame_fragments* out) {
    size_t at = d->pixels;
    fragment table;
    if (!next_fragment(d, &at, &table))
        return ty_fail(context, TY_ERROR_INPUT, "%s: its fragments are damaged or cut short", path);
    const frame_fragments all = select_range(d, at, 0, UINT64_MAX);
    const size_t frames = (size_t)d->frames;
    if (frames == 1)
        *out = all;
    else if (all.count == frames)
        *out = select_one(d, at, frame);
    else if (table.size / 4 >= frames)
        *out = select_range(d, at, table_entry(d, &table, frame),
                            frame + 1 < d->frames ? table_entry(d, &table, frame + 1) : UINT64_MAX);
    else
        return ty_fail(context, TY_ERROR_INPUT, "%s: %zu fragments for %d frames, without a table of their offsets",
                       path, all.count, d->frames);
    if (out->count > 0) return TY_OK;
    return ty_fail(context, TY_ERROR_INPUT, "%s: frame %d has no fragments", path, frame);
}

static ty_result unpack(const ty_dicom* d, const ty_dicom_packed* packed, uint8_t* samples) {
    switch (d->coding) {
    case TY_DICOM_RLE: return ty_dicom_decode_rle(packed, samples);
    case TY_DICOM_JPEG: return ty_dicom_decode_jpeg(packed, samples);
    case TY_DICOM_JPEG_LS: return ty_dicom_decode_jpeg_ls(packed, samples);
    case TY_DICOM_JPEG_2000: return ty_dicom_decode_jpeg_2000(packed, samples);
    default: return TY_ERROR_INTERNAL;
    }
}

/* Behind the fragments comes an end-of-image marker, without which CharLS 2.4 reads 2^31 zero bits from data that is
 * cut short. */
static const uint8_t end_marker[2] = {0xff, 0xd9};

static ty_result decode_fragments(ty_context* context, const char* path, const ty_dicom* d, int32_t frame,
                                  uint8_t* samples) {
    frame_fragments found = {0};
    ty_result result = find_frame(context, path, d, frame, &found);
    if (result != TY_OK) return result;
    const size_t room = found.bytes + sizeof end_marker;
    uint8_t* joined = ty_alloc_array(context, room, 1, false);
    if (joined == NULL) return TY_ERROR_MEMORY;
    size_t at = found.at, got = 0;
    for (size_t i = 0; i < found.count; ++i) {
        fragment f;
        if (!next_fragment(d, &at, &f)) break;
        memcpy(joined + got, d->bytes + f.start, f.size);
        got += f.size;
    }
    if (d->coding == TY_DICOM_JPEG_LS) {
        memcpy(joined + got, end_marker, sizeof end_marker);
        got += sizeof end_marker;
    }
    const ty_dicom_packed packed = {context, path, joined, got, d->columns, d->rows, ty_dicom_sample_size(d)};
    result = unpack(d, &packed, samples);
    ty_free_array(context, joined, room, 1);
    return result;
}

/* ---- values ---- */

/* The stored bits of a sample as a number (PS3.5 section 8.1.1). */
static double stored_value(const ty_dicom* d, uint32_t sample) {
    const uint32_t bits = (uint32_t)d->bits_stored, mask = bits == 32 ? UINT32_MAX : (1u << bits) - 1;
    const uint32_t value = sample >> ((uint32_t)d->high_bit + 1 - bits) & mask;
    const bool negative = d->is_signed && (value >> (bits - 1) & 1) != 0;
    return negative ? (double)value - (double)mask - 1 : (double)value;
}

static void scale_samples(const ty_dicom* d, const ty_dicom_frame* place, const uint8_t* samples, bool big_endian,
                          bool swapped_bytes, float* out) {
    const size_t pixels = (size_t)d->columns * (size_t)d->rows, size = ty_dicom_sample_size(d);
    const ty_sample_type type = d->floats   ? (size == 4 ? TY_SAMPLE_FLOAT : TY_SAMPLE_DOUBLE)
                                : size == 1 ? TY_SAMPLE_UINT8
                                : size == 2 ? TY_SAMPLE_UINT16
                                            : TY_SAMPLE_UINT32;
    for (size_t i = 0; i < pixels; ++i) {
        const size_t at = swapped_bytes ? i ^ 1 : i;
        const double sample = ty_sample_value(type, big_endian, samples + size * at);
        const double value = d->floats ? sample : stored_value(d, (uint32_t)sample);
        out[i] = (float)(place->slope * value + place->intercept);
    }
}

ty_result ty_dicom_decode(ty_context* context, const char* path, const ty_dicom* d, int32_t frame, float* out) {
    const ty_dicom_frame place = ty_dicom_place(d, frame);
    const size_t bytes = (size_t)frame_bytes(d);
    if (d->coding == TY_DICOM_RAW) {
        const uint8_t* samples = d->bytes + d->pixels + (size_t)frame * bytes;
        const bool swapped = d->big_endian && d->words && d->bits_allocated == 8 && bytes % 2 == 0;
        scale_samples(d, &place, samples, d->big_endian, swapped, out);
        return TY_OK;
    }
    uint8_t* samples = ty_alloc_array(context, bytes, 1, true);
    if (samples == NULL) return TY_ERROR_MEMORY;
    const ty_result result = decode_fragments(context, path, d, frame, samples);
    if (result == TY_OK) scale_samples(d, &place, samples, __BYTE_ORDER__ == __ORDER_BIG_ENDIAN__, false, out);
    ty_free_array(context, samples, bytes, 1);
    return result;
}
