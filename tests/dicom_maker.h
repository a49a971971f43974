/* A writer of small DICOM files for tests: elements in any of the value representations and byte orders, native or
 * encapsulated pixel data. */
#ifndef TY_TESTS_DICOM_MAKER_H
#define TY_TESTS_DICOM_MAKER_H

#include "files.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { DICOM_BYTES_MAX = 1 << 18 };

#define UNDEFINED_LENGTH 0xffffffffu

typedef struct dicom_writer {
    uint8_t bytes[DICOM_BYTES_MAX];
    size_t size;
    bool implicit_vr, big_endian;
} dicom_writer;

static inline void dicom_put(dicom_writer* w, const void* bytes, size_t size) {
    assert_true(w->size + size <= sizeof w->bytes);
    if (size > 0) memcpy(w->bytes + w->size, bytes, size);
    w->size += size;
}

static inline void dicom_put_number(dicom_writer* w, uint64_t value, size_t size) {
    for (size_t i = 0; i < size; ++i) {
        const size_t byte = w->big_endian ? size - 1 - i : i;
        const uint8_t part = (uint8_t)(value >> (8 * byte));
        dicom_put(w, &part, 1);
    }
}

/* The head of an element; vr is NULL for items and delimiters. */
static inline void dicom_head(dicom_writer* w, uint32_t tag, const char* vr, uint32_t length) {
    dicom_put_number(w, tag >> 16, 2);
    dicom_put_number(w, tag & 0xffff, 2);
    if (w->implicit_vr || vr == NULL) {
        dicom_put_number(w, length, 4);
        return;
    }
    dicom_put(w, vr, 2);
    if (strstr("OB OD OF OW SQ UN UT", vr) != NULL) {
        dicom_put_number(w, 0, 2);
        dicom_put_number(w, length, 4);
    } else {
        dicom_put_number(w, length, 2);
    }
}

/* Text, padded to an even length. */
static inline void dicom_text(dicom_writer* w, uint32_t tag, const char* vr, const char* text) {
    const size_t length = strlen(text);
    dicom_head(w, tag, vr, (uint32_t)(length + length % 2));
    dicom_put(w, text, length);
    if (length % 2 != 0) dicom_put(w, strcmp(vr, "UI") == 0 ? "" : " ", 1);
}

static inline void dicom_short(dicom_writer* w, uint32_t tag, int value) {
    dicom_head(w, tag, "US", 2);
    dicom_put_number(w, (uint64_t)value, 2);
}

static inline void dicom_open_sequence(dicom_writer* w, uint32_t tag) {
    dicom_head(w, tag, "SQ", UNDEFINED_LENGTH);
}

static inline void dicom_open_item(dicom_writer* w) {
    dicom_head(w, 0xfffee000, NULL, UNDEFINED_LENGTH);
}

static inline void dicom_close_item(dicom_writer* w) {
    dicom_head(w, 0xfffee00d, NULL, 0);
}

static inline void dicom_close_sequence(dicom_writer* w) {
    dicom_head(w, 0xfffee0dd, NULL, 0);
}

/* Preamble and file meta information; what follows is in the syntax. */
static inline void dicom_begin(dicom_writer* w, const char* syntax) {
    static const uint8_t preamble[128];
    w->size = 0;
    w->implicit_vr = w->big_endian = false;
    dicom_put(w, preamble, sizeof preamble);
    dicom_put(w, "DICM", 4);
    dicom_text(w, 0x00020010, "UI", syntax);
    w->implicit_vr = strcmp(syntax, "1.2.840.10008.1.2") == 0;
    w->big_endian = strcmp(syntax, "1.2.840.10008.1.2.2") == 0;
}

/* The form of slices; a text that is NULL, or a number of bits that is 0, is left out. */
typedef struct dicom_form {
    const char *syntax, *series, *description, *orientation, *spacing, *slope, *intercept;
    int columns, rows, allocated, stored, high_bit, is_signed, frames;
} dicom_form;

static inline dicom_form dicom_default_form(void) {
    return (dicom_form){.syntax = "1.2.840.10008.1.2.1",
                        .series = "1.2.3",
                        .description = "axial",
                        .orientation = "1\\0\\0\\0\\1\\0",
                        .spacing = "0.75\\0.5",
                        .columns = 3,
                        .rows = 2,
                        .allocated = 16,
                        .stored = 16,
                        .high_bit = 15,
                        .is_signed = 1,
                        .frames = 1};
}

static inline void dicom_optional(dicom_writer* w, uint32_t tag, const char* vr, const char* text) {
    if (text != NULL) dicom_text(w, tag, vr, text);
}

/* All elements of a slice but its pixels. */
static inline void dicom_slice(dicom_writer* w, const dicom_form* form, const char* position) {
    char frames[16];
    snprintf(frames, sizeof frames, "%d", form->frames);
    dicom_begin(w, form->syntax);
    dicom_text(w, 0x00080060, "CS", "CT");
    dicom_optional(w, 0x0008103e, "LO", form->description);
    dicom_text(w, 0x00180050, "DS", "2");
    dicom_optional(w, 0x0020000e, "UI", form->series);
    dicom_text(w, 0x00200011, "IS", form->series != NULL ? form->series + strlen(form->series) - 1 : "0");
    dicom_optional(w, 0x00200032, "DS", position);
    dicom_optional(w, 0x00200037, "DS", form->orientation);
    dicom_short(w, 0x00280002, 1);
    dicom_text(w, 0x00280004, "CS", "MONOCHROME2");
    if (form->frames > 1) dicom_text(w, 0x00280008, "IS", frames);
    dicom_short(w, 0x00280010, form->rows);
    dicom_short(w, 0x00280011, form->columns);
    dicom_optional(w, 0x00280030, "DS", form->spacing);
    dicom_short(w, 0x00280100, form->allocated);
    dicom_short(w, 0x00280101, form->stored);
    dicom_short(w, 0x00280102, form->high_bit);
    dicom_short(w, 0x00280103, form->is_signed);
    dicom_optional(w, 0x00281052, "DS", form->intercept);
    dicom_optional(w, 0x00281053, "DS", form->slope);
}

/* Native pixels, of as many bits as the form allocates. */
static inline void dicom_pixels(dicom_writer* w, const dicom_form* form, const int64_t* samples) {
    const size_t size = (size_t)form->allocated / 8;
    const size_t count = (size_t)form->columns * (size_t)form->rows * (size_t)form->frames;
    dicom_head(w, 0x7fe00010, size == 1 ? "OB" : "OW", (uint32_t)(count * size));
    for (size_t i = 0; i < count; ++i) dicom_put_number(w, (uint64_t)samples[i], size);
}

/* Encapsulated pixels: a table of offsets, which may be empty, and fragments. */
static inline void dicom_open_fragments(dicom_writer* w, const uint32_t* table, uint32_t entries) {
    dicom_head(w, 0x7fe00010, "OB", UNDEFINED_LENGTH);
    dicom_head(w, 0xfffee000, NULL, 4 * entries);
    for (uint32_t i = 0; i < entries; ++i) dicom_put_number(w, table[i], 4);
}

static inline void dicom_fragment(dicom_writer* w, const void* bytes, size_t size) {
    dicom_head(w, 0xfffee000, NULL, (uint32_t)(size + size % 2));
    dicom_put(w, bytes, size);
    if (size % 2 != 0) dicom_put(w, "", 1);
}

#endif
