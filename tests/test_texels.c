/* Textures: BC6H in every mode, packed texels, and the files that hold them. */
#include "strict_fixture.h"

#include "bc6h_decoder.h"
#include "io/file.h"

#include <tyndall/texels.h>

#include <math.h>

enum { SIDE = 64, BLOCKS = SIDE / 4 * (SIDE / 4) };

static ty_bc6h_tables tables;

/* ---- BC6H ---- */

/* The published layouts have 77 bits before the partition, or 65 before the indices, and each bit of an endpoint once.
 */
static void every_mode_has_its_bits(void** state) {
    (void)state;
    for (int m = 0; m < TY_BC6H_MODES; ++m) {
        const ty_bc6h_mode* mode = &tables.modes[m];
        int32_t seen[256] = {0}, expected = 0;
        for (int32_t i = 0; i < mode->places; ++i) assert_int_equal(seen[mode->place[i]]++, 0);
        for (int e = 0; e < 2 * mode->subsets; ++e)
            for (int c = 0; c < 3; ++c) {
                const int32_t bits = e == 0 ? mode->bits : mode->delta[c];
                for (int32_t bit = 0; bit < bits; ++bit) assert_int_equal(seen[16 * (3 * e + c) + bit], 1);
                expected += bits;
            }
        assert_int_equal(mode->places, expected);
        assert_int_equal(mode->places + mode->number_bits, mode->subsets == 2 ? 77 : 65);
    }
}

static void partitions_have_their_anchors(void** state) {
    (void)state;
    for (int p = 0; p < TY_BC6H_PARTITIONS; ++p) {
        assert_false(ty_bc6h_partitions[p] & 1);
        assert_true(ty_bc6h_partitions[p] >> ty_bc6h_anchors[p] & 1);
    }
}

/* A soft picture of two colours, as lightmaps are, of two ranges that an edge divides; with signs where asked. */
static float scene_value(int x, int y, int c, bool with_sign) {
    const float soft = 1.0f + 0.6f * sinf(0.11f * (float)x + 0.3f * (float)c) * cosf(0.07f * (float)y);
    const float edge = x + 2 * y > 3 * SIDE / 2 ? 6.0f : 0.4f;
    return (with_sign && x > y ? -1.0f : 1.0f) * soft * edge * (1.0f + 0.2f * (float)c);
}

typedef struct quality {
    double relative_rmse;
    int used[TY_BC6H_MODES];
} quality;

/* Encodes the picture in the given modes and compares what the decoder makes of it; scale: of differences between
 * texels and their block's mean, which modes of few bits of difference need small. */
static quality measure(uint32_t modes, bool with_sign, float scale) {
    static uint16_t halves[SIDE * SIDE * 3];
    static uint8_t blocks[BLOCKS * TY_BC6H_BLOCK_BYTES];
    for (int i = 0; i < SIDE * SIDE; ++i) {
        const int x = i % SIDE, y = i / SIDE;
        for (int c = 0; c < 3; ++c) {
            const float middle = scene_value(x / 4 * 4 + 2, y / 4 * 4 + 2, c, with_sign);
            halves[3 * i + c] = ty_float_to_half(middle + scale * (scene_value(x, y, c, with_sign) - middle));
        }
    }
    const ty_bc6h_request request = {.tables = &tables,
                                     .halves = halves,
                                     .blocks = blocks,
                                     .width = SIDE,
                                     .height = SIDE,
                                     .with_sign = with_sign,
                                     .modes = modes};
    for (int row = 0; row < SIDE / 4; ++row) ty_bc6h_encode_row(&request, row);
    quality q = {.relative_rmse = 0};
    double count = 0;
    for (int b = 0; b < BLOCKS; ++b) {
        static const uint8_t none[TY_BC6H_BLOCK_BYTES] = {0};
        const uint8_t* block = blocks + (size_t)TY_BC6H_BLOCK_BYTES * (size_t)b;
        float texels[16][3];
        if (memcmp(block, none, sizeof none) == 0) continue;
        ++q.used[decode_bc6h(&tables, block, with_sign, texels)];
        for (int i = 0; i < 16; ++i)
            for (int c = 0; c < 3; ++c) {
                const int x = b % (SIDE / 4) * 4 + i % 4, y = b / (SIDE / 4) * 4 + i / 4;
                const float value = ty_half_to_float(halves[3 * (y * SIDE + x) + c]);
                const double error = (double)(texels[i][c] - value) / (double)value;
                q.relative_rmse += error * error;
                ++count;
            }
    }
    q.relative_rmse = sqrt(q.relative_rmse / fmax(count, 1));
    return q;
}

/* Measured: 1.26 % of each value, with signs 1.73 %; 1.56 % by modes of one subset alone. Most of it is in blocks that
 * the edge crosses, 15 times as bright on one side. */
static void a_soft_picture_keeps_its_light(void** state) {
    (void)state;
    const quality plain = measure(~0u, false, 1), with_sign = measure(~0u, true, 1);
    const quality single = measure(0xf, false, 1);
    print_message("relative RMSE: %.4f %%, with signs %.4f %%, one subset alone %.4f %%\n", 100 * plain.relative_rmse,
                  100 * with_sign.relative_rmse, 100 * single.relative_rmse);
    assert_true(plain.relative_rmse < 0.014);
    assert_true(with_sign.relative_rmse < 0.019);
    assert_true(plain.relative_rmse < single.relative_rmse);
}

/* Steps of the endpoints, in octaves of the value: 31 octaves have 2^16 steps. A wrong bit of a layout shifts whole
 * blocks by more. Measured: at most 0.24 of a step, and the half floats' own 0.02 %. */
static void every_mode_decodes(void** state) {
    (void)state;
    for (int s = 0; s < 2; ++s)
        for (int m = 0; m < TY_BC6H_MODES; ++m) {
            const ty_bc6h_mode* mode = &tables.modes[m];
            const int32_t smallest = (int32_t)fmin(fmin(mode->delta[0], mode->delta[1]), mode->delta[2]);
            const int32_t bits = mode->bits - s;
            const double step = log(2) * 31 / (1 << bits);
            const float scale = fminf(1, ldexpf(4, smallest - mode->bits));
            const quality q = measure(1u << m, s == 1, scale);
            print_message("mode %2d%s: %3d blocks, %.4f %%, %.3f steps\n", (int)mode->number, s == 1 ? " signed" : "",
                          q.used[m], 100 * q.relative_rmse, q.relative_rmse / step);
            assert_true(q.used[m] > BLOCKS / 8);
            assert_true(q.relative_rmse < 0.4 * step + 0.02 * (double)scale + (s == 1 ? 6e-4 : 0));
        }
}

/* ---- files ---- */

enum { WIDTH = 10, HEIGHT = 12 };

static ty_image* make_image(void) {
    ty_image* image = NULL;
    assert_int_equal(ty_image_create_rgb(context, WIDTH, HEIGHT, &image), TY_OK);
    for (int c = 0; c < 3; ++c)
        for (int i = 0; i < WIDTH * HEIGHT; ++i)
            ty_image_plane(image, c)[i] = 0.01f * powf(1.07f, (float)i) * (1.0f + 0.5f * (float)c);
    return image;
}

static uint8_t* write_texels(const ty_image* image, const ty_texels_def* def, const char* path, size_t* size) {
    uint8_t* bytes = NULL;
    if (ty_texels_write(context, image, def, path) != TY_OK) fail_msg("%s", ty_take_error(context));
    assert_int_equal(ty_read_file(context, path, 1 << 20, &bytes, size), TY_OK);
    return bytes;
}

static uint32_t word(const uint8_t* at) {
    return at[0] | (uint32_t)at[1] << 8 | (uint32_t)at[2] << 16 | (uint32_t)at[3] << 24;
}

static float unpack(ty_texel_format format, const uint8_t* at, int c, double range) {
    const uint32_t bits = word(at);
    if (format == TY_TEXELS_RGB9E5) return ldexpf((float)(bits >> 9 * c & 511), (int)(bits >> 27) - 24);
    if (format == TY_TEXELS_RGBE) return ldexpf(at[c], at[3] - 136);
    if (format == TY_TEXELS_RGBM) return (float)(at[c] * at[3] * range / (255 * 255));
    if (format == TY_TEXELS_FLOAT) return ty_float_from_bits(word(at + 4 * c));
    return ty_half_to_float((uint16_t)(at[2 * c] | at[2 * c + 1] << 8));
}

/* Errors relative to the largest channel: half a step of 9 bits, of 8 bits, of half floats; RGBM, whose multiplier has
 * 255 steps of the range (a ratio of 3000 here), relative to the range. */
static void packed_texels_keep_their_light(void** state) {
    (void)state;
    static const struct {
        ty_texel_format format;
        size_t each;
        double bound;
    } cases[] = {{TY_TEXELS_RGB9E5, 4, 1.001 / 512},
                 {TY_TEXELS_RGBE, 4, 1.001 / 256},
                 {TY_TEXELS_RGBM, 4, 0.6 / 255},
                 {TY_TEXELS_HALF, 8, 0.51 / 1024},
                 {TY_TEXELS_FLOAT, 16, 0}};
    ty_image* image = make_image();
    float top = 0;
    for (int c = 0; c < 3; ++c)
        for (int i = 0; i < WIDTH * HEIGHT; ++i) top = fmaxf(top, ty_image_plane(image, c)[i]);
    for (size_t k = 0; k < sizeof cases / sizeof *cases; ++k) {
        ty_texels_def def = ty_default_texels_def();
        size_t size;
        def.format = cases[k].format;
        uint8_t* bytes = write_texels(image, &def, "packed.dds", &size);
        assert_int_equal(size, 148 + cases[k].each * WIDTH * HEIGHT);
        for (int i = 0; i < WIDTH * HEIGHT; ++i) {
            const double largest = (double)ty_image_plane(image, 2)[i];
            for (int c = 0; c < 3; ++c) {
                const double value = (double)ty_image_plane(image, c)[i];
                const double found =
                    (double)unpack(def.format, bytes + 148 + cases[k].each * (size_t)i, c, (double)top);
                const double scale = def.format == TY_TEXELS_RGBM ? (double)top : largest;
                if (!(fabs(found - value) <= cases[k].bound * scale))
                    fail_msg("format %d, texel %d: %g, not %g", (int)def.format, i, found, value);
            }
        }
        ty_free_file(context, bytes, size);
    }
    ty_image_destroy(image);
}

static void ktx2_says_where_levels_are(void** state) {
    (void)state;
    ty_image* image = make_image();
    ty_texels_def def = ty_default_texels_def();
    size_t size;
    def.mipmaps = true;
    uint8_t* bytes = write_texels(image, &def, "levels.ktx2", &size);
    static const uint32_t header[] = {143, 1, WIDTH, HEIGHT, 0, 0, 1, 4, 0}; /* VK_FORMAT_BC6H_UFLOAT_BLOCK */
    assert_memory_equal(bytes, "\xabKTX 20\xbb\r\n\x1a\n", 12);
    for (size_t i = 0; i < sizeof header / sizeof *header; ++i) assert_int_equal(word(bytes + 12 + 4 * i), header[i]);
    static const uint32_t lengths[] = {9 * 16, 4 * 16, 16, 16}; /* 10 x 12, 5 x 6, 2 x 3, 1 x 1 texels */
    uint32_t past = (uint32_t)size;
    for (size_t level = 0; level < 4; ++level) {
        const uint8_t* entry = bytes + 80 + 24 * level;
        assert_int_equal(word(entry) % 16, 0);
        assert_int_equal(word(entry + 8), lengths[level]);
        assert_int_equal(word(entry + 16), lengths[level]);
        assert_int_equal(word(entry) + lengths[level], past);
        past = word(entry);
    }
    const uint32_t descriptor = word(bytes + 48), values = word(bytes + 56);
    assert_int_equal(word(bytes + descriptor), word(bytes + 52));
    assert_int_equal(bytes[descriptor + 12], 133); /* KHR_DF_MODEL_BC6H */
    assert_int_equal(values, descriptor + word(bytes + 52));
    assert_string_equal((const char*)bytes + values + 4, "KTXorientation");
    ty_free_file(context, bytes, size);
    ty_image_destroy(image);
}

static void dds_holds_volumes(void** state) {
    (void)state;
    ty_image* image = make_image();
    ty_texels_def def = ty_default_texels_def();
    size_t size;
    def.format = TY_TEXELS_HALF;
    def.slices = 3;
    uint8_t* bytes = write_texels(image, &def, "volume.dds", &size);
    assert_int_equal(word(bytes + 12), 4); /* rows */
    assert_int_equal(word(bytes + 24), 3); /* slices */
    assert_int_equal(word(bytes + 128), 10);
    assert_int_equal(word(bytes + 132), 4); /* three dimensions */
    assert_int_equal(size, 148 + 8 * WIDTH * HEIGHT);
    ty_free_file(context, bytes, size);
    ty_image_destroy(image);
}

static void refuse(const ty_image* image, const ty_texels_def* def, const char* path, const char* part) {
    assert_int_equal(ty_texels_write(context, image, def, path), TY_ERROR_ARGUMENT);
    const char* message = ty_take_error(context);
    if (strstr(message, part) == NULL) fail_msg("'%s' is not in '%s'", part, message);
}

static void wrong_requests_are_refused(void** state) {
    (void)state;
    ty_image* image = make_image();
    ty_texels_def def = ty_default_texels_def();
    refuse(image, &def, "a.tga", ".ktx2, .dds or .png");
    refuse(image, &def, "a.png", "rgbe and rgbm");
    refuse(NULL, &def, "a.dds", "NULL");
    def.zstd = 3;
    refuse(image, &def, "a.dds", "Zstandard");
    def.zstd = 23;
    refuse(image, &def, "a.ktx2", "zstd");
    def.zstd = 0;
    def.slices = 5;
    refuse(image, &def, "a.dds", "12 rows cannot be divided into 5 slices");
    ty_image_destroy(image);
}

static ty_result write_levels(ty_context* own, void* user) {
    ty_texels_def def = ty_default_texels_def();
    def.mipmaps = true;
    return ty_texels_write(own, user, &def, "short.ktx2");
}

static void short_memory_is_survived(void** state) {
    (void)state;
    ty_image* image = make_image();
    assert_true(check_short_memory(context, &memory, write_levels, image) > 4);
    ty_image_destroy(image);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_mode_has_its_bits),
        cmocka_unit_test(partitions_have_their_anchors),
        cmocka_unit_test(a_soft_picture_keeps_its_light),
        cmocka_unit_test(every_mode_decodes),
        cmocka_unit_test(packed_texels_keep_their_light),
        cmocka_unit_test(ktx2_says_where_levels_are),
        cmocka_unit_test(dds_holds_volumes),
        cmocka_unit_test(wrong_requests_are_refused),
        cmocka_unit_test(short_memory_is_survived),
    };
    ty_bc6h_fill_tables(&tables);
    return cmocka_run_group_tests(tests, start, stop);
}
