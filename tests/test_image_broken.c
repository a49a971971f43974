/* Images that cannot be read: each is refused in one line that names the file and what is wrong with it. */
#define _GNU_SOURCE
#include "exr_maker.h"
#include "image_maker.h"
#include "strict_fixture.h"

#include "io/images/image_file.h"

#include <tyndall/io.h>

#include <zlib.h>

static void assert_refused(const char* path, const char* matter) {
    ty_image* image = NULL;
    ty_take_error(context); /* of a test that failed */
    const ty_result result = ty_image_read(context, path, &image);
    assert_failed(context, result, TY_ERROR_INPUT, path, matter);
    assert_null(image);
}

/* Overwrites bytes of a file, in place from an offset, or, with a key, so far behind where the key begins. */
typedef struct patch {
    const char* key;
    size_t key_size, offset;
    const char* bytes;
    size_t size;
} patch;

static void refuse_patched(const char* from, const char* path, const patch* p, bool checksum, const char* matter) {
    size_t size;
    uint8_t* bytes = get_file(from, &size);
    uint8_t* at = p->key == NULL ? bytes : memmem(bytes, size, p->key, p->key_size);
    assert_non_null(at);
    memcpy(at + p->offset, p->bytes, p->size);
    if (checksum) { /* of IHDR, which begins 12 bytes into the file */
        const uLong crc = crc32(0, bytes + 12, 17);
        for (int i = 0; i < 4; ++i) bytes[29 + i] = (uint8_t)(crc >> (24 - 8 * i));
    }
    put_file(path, bytes, size);
    free(bytes);
    assert_refused(path, matter);
}

static void refuse_beginning(const char* from, const char* path, size_t cut, const char* matter) {
    size_t size;
    uint8_t* bytes = get_file(from, &size);
    assert_true(cut < size);
    put_file(path, bytes, size - cut);
    free(bytes);
    assert_refused(path, matter);
}

static void broken_png_is_refused(void** state) {
    (void)state;
    const png_kind rgb = {PNG_COLOR_TYPE_RGB, 8, false, false}, palette = {PNG_COLOR_TYPE_PALETTE, 8, false, true};
    write_kind("good.png", &rgb);
    write_kind("palette.png", &palette);
    static const struct {
        const char* from;
        patch patch;
        bool checksum;
        const char* matter;
    } cases[] = {
        {"good.png", {NULL, 0, 16, "\0\0\0\0", 4}, true, "0 x 21 pixels"},
        {"good.png", {NULL, 0, 16, "\0\0\xea\x60\0\0\xea\x60", 8}, true, "cannot hold 60000 x 60000"},
        {"good.png", {NULL, 0, 16, "\xff\xff\xff\xff", 4}, true, "4294967295 x 21 pixels"},
        {"good.png", {NULL, 0, 24, "\3", 1}, true, "IHDR"}, /* depth */
        {"good.png", {NULL, 0, 25, "\5", 1}, true, "IHDR"}, /* colour type */
        {"good.png", {NULL, 0, 28, "\7", 1}, true, "IHDR"}, /* interlacing */
        {"good.png", {NULL, 0, 12, "JHDR", 4}, true, "the PNG header is damaged"},
        {"good.png", {NULL, 0, 29, "\0\0\0\0", 4}, false, "IHDR: CRC error"},
        {"good.png", {"IDAT", 4, 24, "\1\2\3\4", 4}, false, "IDAT"},
        {"good.png", {"IDAT", 4, 4, "\0\0", 2}, false, "IDAT"},
        {"good.png", {"IEND", 4, 4, "\0\0\0\0", 4}, false, "IEND: CRC error"},
        {"good.png", {"IDAT", 4, 0, "jDAT", 4}, false, "CRC error"},
        {"palette.png", {"PLTE", 4, 0, "pLTE", 4}, false, "CRC error"},
        {"palette.png", {"tRNS", 4, 4, "\1", 1}, false, "tRNS: CRC error"},
        {"good.png", {NULL, 0, 25, "\3", 1}, true, "Missing PLTE"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i)
        refuse_patched(cases[i].from, "broken.png", &cases[i].patch, cases[i].checksum, cases[i].matter);
    refuse_beginning("good.png", "broken.png", 1, "cut short");
    refuse_beginning("good.png", "broken.png", 12, "cut short");
    refuse_beginning("good.png", "broken.png", 100, "cut short");
}

static void broken_jpeg_is_refused(void** state) {
    (void)state;
    const jpeg_kind rgb = {.from = JCS_RGB, .to = JCS_YCbCr}, two = {.from = JCS_UNKNOWN, .to = JCS_UNKNOWN},
                    progressive = {.from = JCS_RGB, .to = JCS_YCbCr, .progressive = true};
    write_jpeg("good.jpg", &rgb);
    write_jpeg("progressive.jpg", &progressive);
    /* SOF0: length, depth, height, width, components */
    static const struct {
        patch patch;
        const char* matter;
    } cases[] = {
        {{"\xff\xc0", 2, 4, "\x0c", 1}, "precision 12"},
        {{"\xff\xc0", 2, 5, "\0\0", 2}, "Empty JPEG image"},
        {{"\xff\xc0", 2, 5, "\xff\x00\xff\x00", 4}, "cannot hold 65280 x 65280"},
        {{"\xff\xc0", 2, 9, "\x09", 1}, "marker length"},
        {{"\xff\xc0", 2, 0, "\xff\xcb", 2}, "0xcb"},
        {{"\xff\xc4", 2, 4, "\x3f", 1}, "DHT"},
        {{"\xff\xdb", 2, 0, "\xff\xfe", 2}, "Quantization table 0x00"},
        {{"\xff\xd8", 2, 2, "\xff\xd8", 2}, "two SOI"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i)
        refuse_patched("good.jpg", "broken.jpg", &cases[i].patch, false, cases[i].matter);
    refuse_beginning("good.jpg", "broken.jpg", 2, "Premature end");
    refuse_beginning("good.jpg", "broken.jpg", 500, "Premature end");
    refuse_beginning("progressive.jpg", "broken.jpg", 300, "Premature end");
    put_file("none.jpg", "\xff\xd8\xff\xd9", 4);
    assert_refused("none.jpg", "no image");
    write_jpeg("two.jpg", &two);
    assert_refused("two.jpg", "2 components");
}

/* A progressive file may take a scan for each bit of each coefficient, and each goes over all pixels. */
static void endless_jpeg_is_refused(void** state) {
    (void)state;
    const jpeg_kind many = {.from = JCS_GRAYSCALE, .to = JCS_GRAYSCALE, .many_scans = true};
    write_jpeg("endless.jpg", &many);
    assert_refused("endless.jpg", "more than 128 scans");
}

static void broken_exr_is_refused(void** state) {
    (void)state;
    const foreign f = {box(0, 0, 15, 15), box(0, 0, 15, 15), EXR_COMPRESSION_ZIP, false, EXR_TILE_ONE_LEVEL};
    write_foreign("good.exr", &f);
    /* Attributes are name, type, a 4-byte size and the value; the offsets follow the last one's end. */
    static const struct {
        patch patch;
        const char* matter;
    } cases[] = {
        {{NULL, 0, 4, "\x09", 1}, "version"},
        {{"compression\0compression", 24, 28, "\x01", 1}, NULL},
        {{"dataWindow\0box2i", 17, 21, "\x20\0\0\0\0\0\0\0\x05\0\0\0", 12}, NULL},
        {{"displayWindow\0box2i", 20, 24, "\0\0\0\0\0\0\0\0\xff\xff\xff\xff", 12}, "isplay window"},
        {{"channels\0chlist", 16, 16, "\xff\xff\xff\x7f", 4}, NULL},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i)
        refuse_patched("good.exr", "broken.exr", &cases[i].patch, false, cases[i].matter);
    refuse_beginning("good.exr", "broken.exr", 1, NULL);
    refuse_beginning("good.exr", "broken.exr", 600, NULL);
}

/* The table of offsets lies right before the first chunk, which one entry points to. */
static void exr_with_wrong_offsets_is_refused(void** state) {
    (void)state;
    const foreign f = {box(0, 0, 15, 15), box(0, 0, 15, 15), EXR_COMPRESSION_ZIP, false, EXR_TILE_ONE_LEVEL};
    write_foreign("good.exr", &f);
    static const uint64_t wrong[] = {0, 8, 1u << 20, (uint64_t)1 << 63, UINT64_MAX};
    size_t size;
    uint8_t* bytes = get_file("good.exr", &size);
    size_t table = 0;
    for (size_t at = 8; at + 8 < size && table == 0; ++at) {
        uint64_t offset;
        memcpy(&offset, bytes + at, sizeof offset);
        if (offset == at + sizeof offset) table = at;
    }
    assert_true(table > 0);
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; ++i) {
        memcpy(bytes + table, &wrong[i], sizeof wrong[i]);
        put_file("offsets.exr", bytes, size);
        assert_refused("offsets.exr", NULL);
    }
    free(bytes);
}

static const char* fixture(const char* name, char path[1024]) {
    snprintf(path, 1024, "%s/tests/fuzz/corpus/exr/%s", TYNDALL_SOURCE_DIR, name);
    return path;
}

static void deep_exr_and_broken_dwa_are_refused(void** state) {
    (void)state;
    char path[1024];
    assert_refused(fixture("deep.exr", path), "deep images cannot be read");
    const char* name = fixture("dwaa.exr", path);
    size_t size;
    uint8_t* bytes = get_file(name, &size);
    for (size_t length = 0; length < size; length += 7) {
        put_file("cut.exr", bytes, length);
        assert_refused("cut.exr", NULL);
    }
    free(bytes);
}

/* Half floats after a filter of chroma: constant colors come back within 1 %. */
static void luminance_and_chroma_become_colors(void** state) {
    (void)state;
    static const char* const names[] = {"A", "B", "G", "R"};
    static const float expected[] = {1, 1, 0.25f, 0.5f};
    char path[1024];
    ty_image* image = NULL;
    assert_int_equal(ty_image_read(context, fixture("chroma.exr", path), &image), TY_OK);
    assert_int_equal(ty_image_channel_count(image), 4);
    for (int32_t c = 0; c < 4; ++c) {
        assert_string_equal(ty_image_channel_name(image, c), names[c]);
        assert_true(fabsf(ty_image_plane_const(image, c)[0] - expected[c]) <= 0.01f * expected[c]);
    }
    assert_true(ty_image_plane_const(image, 0)[7] == 0.5f); /* alpha has every pixel */
    ty_image_destroy(image);
}

static void other_files_are_refused(void** state) {
    (void)state;
    put_file("empty.png", "", 0);
    assert_refused("empty.png", "empty");
    put_file("other.png", "GIF89a\1\0\1\0", 10);
    assert_refused("other.png", "neither");
    put_file("short.exr", "\x76\x2f\x31\x01", 4);
    assert_refused("short.exr", NULL);
    int32_t width = 0, height = 0;
    uint8_t* rgba8 = NULL;
    static const uint8_t hdr[] = "#?RADIANCE\n";
    assert_failed(context, ty_decode_rgba8(context, "texture", hdr, sizeof hdr, &width, &height, &rgba8),
                  TY_ERROR_INPUT, "texture", "neither a PNG, a JPEG nor a WebP");
    assert_null(rgba8);
    ty_image* image = NULL;
    assert_failed(context, ty_image_read_raw(context, "absent.png", &image), TY_ERROR_FILE, "absent.png",
                  "No such file");
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(broken_png_is_refused),
        cmocka_unit_test(broken_jpeg_is_refused),
        cmocka_unit_test(endless_jpeg_is_refused),
        cmocka_unit_test(broken_exr_is_refused),
        cmocka_unit_test(exr_with_wrong_offsets_is_refused),
        cmocka_unit_test(deep_exr_and_broken_dwa_are_refused),
        cmocka_unit_test(luminance_and_chroma_become_colors),
        cmocka_unit_test(other_files_are_refused),
    };
    return cmocka_run_group_tests(tests, start, stop);
}
