/* Image files: OpenEXR and PNG out, OpenEXR and Radiance .hdr in. */
#define _GNU_SOURCE
#include "exr_maker.h"
#include "strict_fixture.h"

#include <tyndall/io.h>

#include <math.h>
#include <png.h>

/* Values of every size, in no order. */
static float scramble(uint32_t i) {
    i = i * 2654435761u + 12345u;
    i ^= i >> 15;
    return ldexpf((float)(i % 20001u) - 10000.0f, (int)(i >> 20 & 63u) - 40);
}

static ty_image* make_image(int32_t width, int32_t height, int32_t count, const char* const* names) {
    ty_image* image = NULL;
    assert_int_equal(ty_image_create(context, width, height, count, names, &image), TY_OK);
    for (int32_t c = 0; c < count; ++c)
        for (int32_t i = 0; i < width * height; ++i)
            ty_image_plane(image, c)[i] = scramble((uint32_t)(c * width * height + i));
    return image;
}

static void assert_same_planes(const ty_image* a, const ty_image* b) {
    assert_int_equal(ty_image_width(a), ty_image_width(b));
    assert_int_equal(ty_image_height(a), ty_image_height(b));
    assert_int_equal(ty_image_channel_count(a), ty_image_channel_count(b));
    const size_t bytes = (size_t)ty_image_width(a) * (size_t)ty_image_height(a) * sizeof(float);
    for (int32_t c = 0; c < ty_image_channel_count(a); ++c) {
        const int32_t other = ty_image_find_channel(b, ty_image_channel_name(a, c));
        assert_true(other >= 0);
        assert_memory_equal(ty_image_plane_const(a, c), ty_image_plane_const(b, other), bytes);
    }
}

static void exr_round_trip_is_exact(void** state) {
    (void)state;
    static const char* const names[] = {"R", "G", "B", "depth.Z",
                                        "a name of more than thirty-one characters, which needs long-name support"};
    static const int32_t sizes[][2] = {{1, 1}, {17, 33}, {64, 16}, {3, 100}};
    for (size_t i = 0; i < sizeof sizes / sizeof *sizes; ++i) {
        ty_image* image = make_image(sizes[i][0], sizes[i][1], i == 0 ? 4 : 5, names);
        ty_image_plane(image, 0)[0] = INFINITY;
        ty_image_plane(image, 1)[0] = NAN;
        ty_image_plane(image, 2)[0] = 1e-42f;
        ty_image* back = NULL;
        assert_int_equal(ty_image_write_exr(context, image, "trip.exr"), TY_OK);
        assert_int_equal(ty_image_read(context, "trip.exr", &back), TY_OK);
        assert_same_planes(image, back);
        ty_image_destroy(image);
        ty_image_destroy(back);
    }
    assert_int_equal(remove_temporary_files(), 0);
}

/* Noise that compresses about as badly as noise can: some chunks come out exactly as long as their pixels. */
static void exr_chunks_as_long_as_their_pixels_are_read(void** state) {
    (void)state;
    enum { WIDTH = 70, LINES = 16, IMAGES = 400 };
    static const char* const names[] = {"R", "G", "B"};
    for (int32_t n = 0; n < IMAGES; ++n) {
        ty_image *image = NULL, *read = NULL;
        assert_int_equal(ty_image_create(context, WIDTH, LINES, 3, names, &image), TY_OK);
        uint32_t seed = (uint32_t)n;
        for (int c = 0; c < 3; ++c)
            for (int i = c == 0 ? 8 + n % 20 : 0; i < WIDTH * LINES; ++i) {
                seed = seed * 1664525u + 1013904223u;
                const uint32_t bits = (seed ^ seed >> 15) * 2654435761u & 0xbfffffffu; /* no infinity */
                memcpy(&ty_image_plane(image, c)[i], &bits, sizeof bits);
            }
        assert_int_equal(ty_image_write_exr(context, image, "noise.exr"), TY_OK);
        assert_int_equal(ty_image_read(context, "noise.exr", &read), TY_OK);
        assert_same_planes(image, read);
        ty_image_destroy(image);
        ty_image_destroy(read);
    }
}

static void exr_keeps_metadata(void** state) {
    (void)state;
    static const char* const names[] = {"Y"};
    ty_image* image = make_image(4, 4, 1, names);
    assert_int_equal(ty_image_set_text(image, "method", "path"), TY_OK);
    assert_int_equal(ty_image_set_text(image, "tyndall.scene_hash", "0123456789abcdef"), TY_OK);
    assert_int_equal(ty_image_set_text(image, "empty", ""), TY_OK);
    assert_int_equal(ty_image_set_number(image, "third", 1.0 / 3.0), TY_OK);
    assert_int_equal(ty_image_set_number(image, "seed", 18446744073709549568.0), TY_OK);
    ty_image* back = NULL;
    assert_int_equal(ty_image_write_exr(context, image, "meta.exr"), TY_OK);
    assert_int_equal(ty_image_read(context, "meta.exr", &back), TY_OK);
    assert_int_equal(ty_image_metadata_count(back), 5);
    for (int32_t i = 0; i < ty_image_metadata_count(image); ++i) {
        const char* key = ty_image_metadata_key(image, i);
        assert_non_null(ty_image_get_metadata(back, key));
        assert_string_equal(ty_image_get_metadata(back, key), ty_image_get_metadata(image, key));
    }
    assert_true(strtod(ty_image_get_metadata(back, "third"), NULL) == 1.0 / 3.0);
    ty_image_destroy(image);
    ty_image_destroy(back);
}

/* Channel c of a part lies in an image over the union of all parts' windows, 0 beyond its own. */
static void check_foreign_channel(const ty_image* image, const char* name, int c, const foreign* f) {
    const float* plane = ty_image_plane_const(image, ty_image_find_channel(image, name));
    assert_non_null(plane);
    int32_t frame[4];
    ty_image_get_frame(image, frame);
    for (int32_t row = 0; row < ty_image_height(image); ++row)
        for (int32_t column = 0; column < ty_image_width(image); ++column) {
            const int32_t x = f->display.min.x + frame[0] + column, y = f->display.min.y + frame[1] + row;
            const bool inside = x >= f->data.min.x && x <= f->data.max.x && y >= f->data.min.y && y <= f->data.max.y;
            const float expected = inside ? foreign_value(c, x, y) : 0;
            if (*plane != expected) fail_msg("%s at %d, %d: %g, not %g", name, x, y, *plane, expected);
            ++plane;
        }
}

static void check_foreign(const foreign* f) {
    write_foreign("foreign.exr", f);
    ty_image *image = NULL, *filled = NULL;
    assert_int_equal(ty_image_read(context, "foreign.exr", &image), TY_OK);
    int32_t frame[4];
    ty_image_get_frame(image, frame);
    assert_int_equal(frame[0], f->data.min.x - f->display.min.x);
    assert_int_equal(frame[1], f->data.min.y - f->display.min.y);
    assert_int_equal(frame[2], f->display.max.x - f->display.min.x + 1);
    assert_int_equal(frame[3], f->display.max.y - f->display.min.y + 1);
    assert_int_equal(ty_image_width(image), f->data.max.x - f->data.min.x + 1);
    assert_int_equal(ty_image_height(image), f->data.max.y - f->data.min.y + 1);
    assert_int_equal(ty_image_create_full_frame(context, image, &filled), TY_OK);
    assert_int_equal(ty_image_width(filled), frame[2]);
    assert_int_equal(ty_image_height(filled), frame[3]);
    for (int c = 0; c < FOREIGN_CHANNELS; ++c) {
        check_foreign_channel(image, foreign_names[c], c, f);
        check_foreign_channel(filled, foreign_names[c], c, f);
    }
    ty_image_destroy(filled);
    ty_image_destroy(image);
}

static void exr_types_layouts_and_windows_are_read(void** state) {
    (void)state;
    const exr_attr_box2i_t full = box(0, 0, 49, 39);
    const exr_attr_box2i_t windows[][2] = {
        {full, full},                                  /* the same */
        {box(10, 5, 30, 37), full},                    /* data inside */
        {box(-7, -9, 70, 60), full},                   /* data all round */
        {box(-20, 20, 12, 90), box(-10, -10, 30, 50)}, /* data across corners, negative origin */
        {box(100, 100, 120, 120), full},               /* data elsewhere */
    };
    static const exr_compression_t lossless[] = {EXR_COMPRESSION_NONE, EXR_COMPRESSION_RLE, EXR_COMPRESSION_ZIPS,
                                                 EXR_COMPRESSION_ZIP, EXR_COMPRESSION_PIZ};
    for (size_t i = 0; i < sizeof windows / sizeof *windows; ++i)
        for (size_t k = 0; k < sizeof lossless / sizeof *lossless; ++k)
            for (int layout = 0; layout < 3; ++layout) {
                const foreign f = {windows[i][0], windows[i][1], lossless[k], layout > 0,
                                   layout == 2 ? EXR_TILE_MIPMAP_LEVELS : EXR_TILE_ONE_LEVEL};
                check_foreign(&f);
            }
}

static void exr_parts_lie_side_by_side(void** state) {
    (void)state;
    const exr_attr_box2i_t full = box(-3, -2, 36, 27);
    const foreign parts[] = {{box(2, 3, 20, 21), full, EXR_COMPRESSION_ZIP, false, EXR_TILE_ONE_LEVEL},
                             {box(-9, 5, 12, 50), full, EXR_COMPRESSION_PIZ, true, EXR_TILE_MIPMAP_LEVELS},
                             {full, full, EXR_COMPRESSION_RLE, false, EXR_TILE_ONE_LEVEL}};
    write_foreign_parts("parts.exr", parts, 3);
    ty_image *image = NULL, *layer = NULL;
    assert_int_equal(ty_image_read(context, "parts.exr", &image), TY_OK);
    int32_t frame[4];
    ty_image_get_frame(image, frame);
    assert_true(frame[0] == -6 && frame[1] == 0 && frame[2] == 40 && frame[3] == 30);
    assert_int_equal(ty_image_width(image), 46);
    assert_int_equal(ty_image_height(image), 53);
    assert_int_equal(ty_image_channel_count(image), 9);
    for (int c = 0; c < FOREIGN_CHANNELS; ++c) {
        char name[32];
        check_foreign_channel(image, foreign_names[c], c, &parts[0]);
        snprintf(name, sizeof name, "part1.%s", foreign_names[c]);
        check_foreign_channel(image, name, c, &parts[1]);
        snprintf(name, sizeof name, "part2.%s", foreign_names[c]);
        check_foreign_channel(image, name, c, &parts[2]);
    }
    assert_int_equal(ty_image_create_layer(context, image, "part1", &layer), TY_OK);
    assert_int_equal(ty_image_channel_count(layer), FOREIGN_CHANNELS);
    check_foreign_channel(layer, "C", 2, &parts[1]);
    ty_image_destroy(layer);
    ty_image_destroy(image);
}

/* Files of the C++ library: 20 x 12 pixels at (3, 5) of a window from (-4, -2) to (59, 29), in the largest level. */
static float fixture_value(int c, int32_t x, int32_t y) {
    return c == 3 ? (float)((x * 7 + y * 13) & 1023) : 0.25f * (float)(c + 1) + 0.01f * (float)x + 0.02f * (float)y;
}

static void check_fixture(const char* name, float tolerance) {
    static const char* const names[] = {"R", "G", "B", "Z"};
    static const int32_t expected[4] = {7, 7, 64, 32};
    char path[1024];
    snprintf(path, sizeof path, "%s/tests/fuzz/corpus/exr/%s.exr", TYNDALL_SOURCE_DIR, name);
    ty_image* image = NULL;
    assert_int_equal(ty_image_read(context, path, &image), TY_OK);
    assert_int_equal(ty_image_width(image), 20);
    assert_int_equal(ty_image_height(image), 12);
    int32_t frame[4];
    ty_image_get_frame(image, frame);
    assert_memory_equal(frame, expected, sizeof frame);
    for (int c = 0; c < 4; ++c)
        for (int32_t i = 0; i < 20 * 12; ++i) {
            const float value = ty_image_plane_const(image, ty_image_find_channel(image, names[c]))[i];
            const float error = fabsf(value - fixture_value(c, 3 + i % 20, 5 + i / 20));
            if (!(error <= (c == 3 ? 0 : tolerance))) fail_msg("%s: %s[%d] is off by %g", name, names[c], i, error);
        }
    ty_image_destroy(image);
}

static void exr_of_other_codecs_and_levels_are_read(void** state) {
    (void)state;
    const float half = 0x1p-11f, lossy = 0.01f; /* DWA at its usual quality; B44 keeps six bits of each difference */
    check_fixture("ripmap", half);
    check_fixture("pxr24", half);
    check_fixture("b44", lossy);
    check_fixture("b44a", lossy);
    check_fixture("dwaa", lossy);
    check_fixture("dwab", lossy);
    check_fixture("dwaa_mipmap", lossy);
}

static void exr_keeps_the_frame(void** state) {
    (void)state;
    static const char* const names[] = {"R", "G", "B"};
    static const int32_t frames[][4] = {{3, 40, 100, 200}, {-5, -60, 7, 3}, {1 << 20, -(1 << 20), 65536, 1}};
    for (size_t i = 0; i < sizeof frames / sizeof *frames; ++i) {
        const int32_t* frame = frames[i];
        ty_image *image = make_image(21, 37, 3, names), *back = NULL;
        int32_t found[4];
        assert_int_equal(ty_image_set_frame(image, frame[0], frame[1], frame[2], frame[3]), TY_OK);
        assert_int_equal(ty_image_write_exr(context, image, "frame.exr"), TY_OK);
        assert_int_equal(ty_image_read(context, "frame.exr", &back), TY_OK);
        assert_same_planes(image, back);
        ty_image_get_frame(back, found);
        assert_memory_equal(found, frame, sizeof found);
        ty_image_destroy(image);
        ty_image_destroy(back);
    }
}

/* Overwrites what follows key, after skip bytes, in the file small.exr and saves it as path. */
static void patch_small_exr(const char* path, const char* key, size_t key_size, size_t skip_bytes, const void* value,
                            size_t value_size) {
    size_t size;
    uint8_t* bytes = get_file("small.exr", &size);
    uint8_t* at = memmem(bytes, size, key, key_size);
    assert_non_null(at);
    memcpy(at + key_size + skip_bytes, value, value_size);
    put_file(path, bytes, size);
    free(bytes);
}

static void exr_that_cannot_be_shown_is_refused(void** state) {
    (void)state;
    const foreign f = {box(0, 0, 15, 15), box(0, 0, 15, 15), EXR_COMPRESSION_ZIP, false, EXR_TILE_ONE_LEVEL};
    write_foreign("small.exr", &f);
    ty_image* image = NULL;
    /* Each attribute is its name, its type, a 4-byte size and the value. */
    static const int32_t huge[] = {0, 0, 60000, 60000}, wide[] = {0, 0, 69999, 5}, far[] = {9999999, 0, 9999999, 0},
                         twice[] = {2, 2};
    patch_small_exr("wide.exr", "displayWindow\0box2i", 20, 4, wide, sizeof wide);
    assert_failed(context, ty_image_read(context, "wide.exr", &image), TY_ERROR_INPUT, "wide.exr", "70000 x 6 pixels");
    patch_small_exr("far.exr", "displayWindow\0box2i", 20, 4, far, sizeof far);
    assert_failed(context, ty_image_read(context, "far.exr", &image), TY_ERROR_INPUT, "far.exr", "(-9999999, 0)");
    patch_small_exr("huge.exr", "dataWindow\0box2i", 17, 4, huge, sizeof huge);
    assert_failed(context, ty_image_read(context, "huge.exr", &image), TY_ERROR_INPUT, "huge.exr", NULL);
    /* The first channel: "A", type, linearity, then the sampling. */
    patch_small_exr("sub.exr", "channels\0chlist", 16, 4 + 2 + 4 + 4, twice, sizeof twice);
    assert_failed(context, ty_image_read(context, "sub.exr", &image), TY_ERROR_INPUT, "sub.exr", "subsampled");
    assert_null(image);
}

/* Reads bytes as a file; any failure must name the file and hand out nothing. */
static ty_result read_bytes(const char* path, const uint8_t* bytes, size_t size) {
    put_file(path, bytes, size);
    ty_image* const untouched = (ty_image*)&memory;
    ty_image* image = untouched;
    const ty_result result = ty_image_read(context, path, &image);
    if (result == TY_OK) {
        ty_image_destroy(image);
    } else {
        assert_ptr_equal(image, untouched);
        const char* message = ty_take_error(context);
        if (result != TY_ERROR_MEMORY) assert_non_null(strstr(message, path));
    }
    return result;
}

/* Every beginning of the file is an error; flipped bits never do harm. */
static void torture(const char* path) {
    size_t size;
    uint8_t* bytes = get_file(path, &size);
    assert_int_equal(read_bytes("torture.bin", bytes, size), TY_OK);
    for (size_t length = 0; length < size; ++length)
        assert_int_equal(read_bytes("torture.bin", bytes, length), TY_ERROR_INPUT);
    for (size_t i = 0; i < 8 * size; i += 5) {
        bytes[i / 8] ^= (uint8_t)(1 << i % 8);
        read_bytes("torture.bin", bytes, size);
        bytes[i / 8] ^= (uint8_t)(1 << i % 8);
    }
    free(bytes);
}

static void broken_exr_is_refused(void** state) {
    (void)state;
    static const char* const names[] = {"R", "G", "B"};
    ty_image* image = make_image(5, 20, 3, names);
    assert_int_equal(ty_image_set_text(image, "method", "path"), TY_OK);
    assert_int_equal(ty_image_write_exr(context, image, "small.exr"), TY_OK);
    ty_image_destroy(image);
    torture("small.exr");
    const foreign f = {box(0, 0, 19, 19), box(0, 0, 19, 19), EXR_COMPRESSION_ZIP, true, EXR_TILE_ONE_LEVEL};
    write_foreign("small.exr", &f);
    torture("small.exr");
}

static const char hdr_head[] = "#?RADIANCE\n# comment\nEXPOSURE=2\nFORMAT=32-bit_rle_rgbe\n\n-Y 2 +X 9\n";

static size_t append(uint8_t* to, size_t size, const void* bytes, size_t count) {
    memcpy(to + size, bytes, count);
    return size + count;
}

/* Two rows of nine pixels: the first in planes with a run and a stretch, the second flat with a repeated pixel. */
static size_t make_hdr(uint8_t* bytes) {
    size_t size = append(bytes, 0, hdr_head, sizeof hdr_head - 1);
    static const uint8_t planes[] = {2, 2, 0, 9, 128 + 9, 128,     9,  0,       1, 2,       3,
                                     4, 5, 6, 7, 8,       128 + 4, 64, 128 + 5, 0, 128 + 9, 129};
    size = append(bytes, size, planes, sizeof planes);
    static const uint8_t flat[] = {128, 64, 32, 130, 1, 1, 1, 7, 0, 0, 0, 0};
    return append(bytes, size, flat, sizeof flat);
}

static void hdr_is_read_exactly(void** state) {
    (void)state;
    uint8_t bytes[256];
    put_file("made.hdr", bytes, make_hdr(bytes));
    ty_image* image = NULL;
    assert_int_equal(ty_image_read(context, "made.hdr", &image), TY_OK);
    assert_int_equal(ty_image_width(image), 9);
    assert_int_equal(ty_image_height(image), 2);
    const float* planes[3];
    assert_true(ty_image_rgb_planes(image, planes));
    for (int x = 0; x < 9; ++x) {
        /* mantissa * 2^(e - 136): e = 129 makes 128 a one */
        assert_true(planes[0][x] == 1.0f);
        assert_true(planes[1][x] == (float)x / 128);
        assert_true(planes[2][x] == (x < 4 ? 0.5f : 0));
        assert_true(planes[0][9 + x] == (x < 8 ? 2.0f : 0));
        assert_true(planes[1][9 + x] == (x < 8 ? 1.0f : 0));
        assert_true(planes[2][9 + x] == (x < 8 ? 0.5f : 0));
    }
    ty_image_destroy(image);
    torture("made.hdr");
}

static void broken_hdr_is_refused(void** state) {
    (void)state;
    static const struct {
        const char *text, *matter;
    } cases[] = {
        {"#?RADIANCE\nFORMAT=32-bit_rle_xyze\n\n-Y 2 +X 2\n", "xyze"},
        {"#?RADIANCE\n\n-Y 2 +X 2\n", "header"},
        {"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n+Y 2 +X 2\n12341234123412341234", "+Y 2"},
        {"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 0 +X 2\n12341234", "0 pixels"},
        {"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y -5 +X 2\n12341234", "-5"},
        {"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 99999999999999999999 +X 2\n12341234", "outside"},
        {"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 60000 +X 60000\n12341234", "cannot hold"},
        {"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 60 +X 60\n12341234", "cut short"},
        {"hello, world", "neither"},
        {"", "empty"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        put_file("broken.hdr", cases[i].text, strlen(cases[i].text));
        ty_image* image = NULL;
        assert_failed(context, ty_image_read(context, "broken.hdr", &image), TY_ERROR_INPUT, "broken.hdr",
                      cases[i].matter);
        assert_null(image);
    }
}

static void absent_files_are_reported(void** state) {
    (void)state;
    ty_image* image = NULL;
    assert_failed(context, ty_image_read(context, "sky.hdr", &image), TY_ERROR_FILE,
                  "cannot open sky.hdr: No such file or directory", NULL);
    assert_failed(context, ty_image_read(context, ".", &image), TY_ERROR_FILE, "cannot open .", NULL);
}

static void failed_writes_leave_the_old_file(void** state) {
    (void)state;
    static const char* const names[] = {"R", "G", "B"};
    static const char old[] = "the old content";
    ty_image* image = make_image(100, 100, 3, names);
    put_file("old.exr", old, sizeof old);
    put_file("old.png", old, sizeof old);
    little_space(2000);
    const ty_result exr = ty_image_write_exr(context, image, "old.exr");
    char exr_message[256];
    snprintf(exr_message, sizeof exr_message, "%s", ty_take_error(context));
    const ty_result png = ty_image_write_png(context, image, 0, TY_TONE_FILMIC, "old.png");
    all_space();
    assert_failed(context, png, TY_ERROR_FILE, "old.png", NULL);
    assert_int_equal(exr, TY_ERROR_FILE);
    assert_non_null(strstr(exr_message, "old.exr"));
    assert_file_holds("old.exr", old, sizeof old);
    assert_file_holds("old.png", old, sizeof old);
    assert_int_equal(remove_temporary_files(), 0);
    assert_failed(context, ty_image_write_exr(context, image, "no/such/folder.exr"), TY_ERROR_FILE,
                  "no/such/folder.exr", "No such file");
    assert_failed(context, ty_image_write_exr(context, image, "/dev/null"), TY_ERROR_FILE, "/dev/null", "regular");
    assert_failed(context, ty_image_write_png(context, image, 0, TY_TONE_FILMIC, "."), TY_ERROR_FILE, ".", "regular");
    assert_int_equal(ty_image_write_exr(context, image, "old.exr"), TY_OK);
    ty_image* back = NULL;
    assert_int_equal(ty_image_read(context, "old.exr", &back), TY_OK);
    assert_same_planes(image, back);
    ty_image_destroy(back);
    ty_image_destroy(image);
}

/* Space runs out within the header, at its end, in the table of offsets and in the pixels. The library calls its error
 * handler with a lock held in some of these places: a signal ends the test if it waits for itself. */
static void full_disks_are_reported_at_every_place(void** state) {
    (void)state;
    static const char* const names[] = {"R", "G", "B"};
    static const long spaces[] = {0, 8, 100, 250, 300, 350, 400, 500, 1000, 2000, 20000, 60000};
    ty_image* image = make_image(100, 100, 3, names);
    for (size_t i = 0; i < sizeof spaces / sizeof *spaces; ++i) {
        alarm(20);
        little_space(spaces[i]);
        const ty_result result = ty_image_write_exr(context, image, "full.exr");
        all_space();
        alarm(0);
        assert_failed(context, result, TY_ERROR_FILE, "full.exr", NULL);
        assert_int_not_equal(access("full.exr", F_OK), 0);
        assert_int_equal(remove_temporary_files(), 0);
    }
    ty_image_destroy(image);
}

static void bytes_are_written_and_read_whole(void** state) {
    (void)state;
    static const uint8_t content[] = {0, 1, 255, '\n', 0};
    uint8_t* bytes = NULL;
    size_t size = 0;
    assert_int_equal(ty_bytes_write(context, "some.bin", content, sizeof content), TY_OK);
    assert_int_equal(ty_bytes_read(context, "some.bin", sizeof content, &bytes, &size), TY_OK);
    assert_int_equal(size, sizeof content);
    assert_memory_equal(bytes, content, sizeof content);
    ty_bytes_destroy(context, bytes, size);
    assert_int_equal(ty_bytes_write(context, "some.bin", NULL, 0), TY_OK);
    assert_int_equal(ty_bytes_read(context, "some.bin", 0, &bytes, &size), TY_OK);
    assert_int_equal(size, 0);
    ty_bytes_destroy(context, bytes, size);
    ty_bytes_destroy(context, NULL, 0);
    assert_int_equal(ty_bytes_write(context, "some.bin", content, sizeof content), TY_OK);
    assert_failed(context, ty_bytes_read(context, "some.bin", sizeof content - 1, &bytes, &size), TY_ERROR_INPUT,
                  "some.bin", "limit of 4");
    assert_failed(context, ty_bytes_read(context, "absent.bin", 9, &bytes, &size), TY_ERROR_FILE, "absent.bin", NULL);
    assert_int_equal(ty_bytes_write(context, "some.bin", NULL, 1), TY_ERROR_ARGUMENT);
    ty_take_error(context);
    assert_failed(context, ty_bytes_write(context, "no/some.bin", content, 1), TY_ERROR_FILE, "no/some.bin", NULL);
    assert_file_holds("some.bin", content, sizeof content);
    assert_int_equal(remove_temporary_files(), 0);
}

static void png_holds_the_tone_mapped_bytes(void** state) {
    (void)state;
    static const char* const names[] = {"R", "G", "B"};
    ty_image* image = make_image(31, 7, 3, names);
    uint8_t expected[31 * 7 * 3], found[31 * 7 * 3];
    assert_int_equal(ty_image_tonemap(context, image, -1, TY_TONE_FILMIC, expected), TY_OK);
    assert_int_equal(ty_image_write_png(context, image, -1, TY_TONE_FILMIC, "out.png"), TY_OK);
    ty_image_destroy(image);
    png_image png = {.version = PNG_IMAGE_VERSION};
    assert_int_equal(png_image_begin_read_from_file(&png, "out.png"), 1);
    assert_int_equal(png.width, 31);
    assert_int_equal(png.height, 7);
    assert_int_equal(png.format, PNG_FORMAT_RGB);
    assert_int_equal(png_image_finish_read(&png, NULL, found, 0, NULL), 1);
    assert_memory_equal(found, expected, sizeof expected);
    size_t size;
    uint8_t* bytes = get_file("out.png", &size);
    assert_non_null(memmem(bytes, size, "sRGB", 4));
    free(bytes);
    static const char* const other[] = {"X", "Z"};
    image = make_image(2, 2, 2, other);
    assert_int_equal(ty_image_write_png(context, image, 0, TY_TONE_FILMIC, "none.png"), TY_ERROR_ARGUMENT);
    ty_take_error(context);
    ty_image_destroy(image);
}

static ty_result read_and_destroy(ty_context* strict, void* path) {
    ty_image* image = NULL;
    const ty_result result = ty_image_read(strict, path, &image);
    ty_image_destroy(image);
    return result;
}

static void short_memory_is_survived(void** state) {
    (void)state;
    static const char* const names[] = {"R", "G", "B"};
    uint8_t bytes[256];
    put_file("memory.hdr", bytes, make_hdr(bytes));
    ty_image* image = make_image(20, 20, 3, names);
    assert_int_equal(ty_image_set_text(image, "method", "path"), TY_OK);
    assert_int_equal(ty_image_write_exr(context, image, "memory.exr"), TY_OK);
    static char paths[][16] = {"memory.hdr", "memory.exr"};
    for (int i = 0; i < 2; ++i) assert_true(check_short_memory(context, &memory, read_and_destroy, paths[i]) > 0);
    for (int64_t n = 0; n < 5; ++n) {
        memory.until_refusal = n;
        const ty_result exr = ty_image_write_exr(context, image, "memory.exr");
        memory.until_refusal = n;
        const ty_result png = ty_image_write_png(context, image, 0, TY_TONE_FILMIC, "memory.png");
        memory.until_refusal = -1;
        assert_true(exr == (n < 3 ? TY_ERROR_MEMORY : TY_OK));
        assert_true(png == (n < 4 ? TY_ERROR_MEMORY : TY_OK));
    }
    assert_int_equal(remove_temporary_files(), 0);
    ty_take_error(context);
    ty_image_destroy(image);
}

static void real_environment_maps_are_read(void** state) {
    (void)state;
    static const struct {
        const char* name;
        double max;
    } maps[] = {{"hdri/potsdamer_platz_1k.hdr", 11.8},
                {"hdri/kiara_1_dawn_1k.hdr", 102},
                {"hdri/st_fagans_interior_1k.hdr", 1272}};
    for (size_t i = 0; i < sizeof maps / sizeof *maps; ++i) {
        char path[1024];
        ty_image* image = NULL;
        assert_int_equal(ty_image_read(context, data_path(maps[i].name, path), &image), TY_OK);
        assert_int_equal(ty_image_width(image), 1024);
        assert_int_equal(ty_image_height(image), 512);
        double max = 0;
        for (int c = 0; c < 3; ++c)
            for (int k = 0; k < 1024 * 512; ++k) max = fmax(max, ty_image_plane(image, c)[k]);
        assert_true(fabs(max / maps[i].max - 1) < 0.01);
        ty_image_destroy(image);
    }
}

static void real_half_image_is_read(void** state) {
    (void)state;
    char path[1024];
    ty_image* image = NULL;
    assert_int_equal(ty_image_read(context, data_path("scenes/wooden_staircase_reference.exr", path), &image), TY_OK);
    assert_int_equal(ty_image_width(image), 720);
    assert_int_equal(ty_image_height(image), 1280);
    const float* planes[3];
    assert_true(ty_image_rgb_planes(image, planes));
    double mean = 0;
    for (int k = 0; k < 720 * 1280; ++k) {
        assert_true(isfinite(planes[0][k]) && planes[0][k] >= 0);
        mean += planes[0][k] / (720.0 * 1280.0);
    }
    assert_true(mean > 0.01 && mean < 10);
    ty_image_destroy(image);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(exr_round_trip_is_exact),
        cmocka_unit_test(exr_chunks_as_long_as_their_pixels_are_read),
        cmocka_unit_test(exr_keeps_metadata),
        cmocka_unit_test(exr_types_layouts_and_windows_are_read),
        cmocka_unit_test(exr_parts_lie_side_by_side),
        cmocka_unit_test(exr_of_other_codecs_and_levels_are_read),
        cmocka_unit_test(exr_keeps_the_frame),
        cmocka_unit_test(exr_that_cannot_be_shown_is_refused),
        cmocka_unit_test(broken_exr_is_refused),
        cmocka_unit_test(hdr_is_read_exactly),
        cmocka_unit_test(broken_hdr_is_refused),
        cmocka_unit_test(absent_files_are_reported),
        cmocka_unit_test(failed_writes_leave_the_old_file),
        cmocka_unit_test(full_disks_are_reported_at_every_place),
        cmocka_unit_test(bytes_are_written_and_read_whole),
        cmocka_unit_test(png_holds_the_tone_mapped_bytes),
        cmocka_unit_test(short_memory_is_survived),
        cmocka_unit_test(real_environment_maps_are_read),
        cmocka_unit_test(real_half_image_is_read),
    };
    return cmocka_run_group_tests(tests, start, stop);
}
