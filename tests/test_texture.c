/* Textures: decoding, filtering, wrapping, owners, errors. */
#include "checks.h"

#include "scene/surfaces/texture.h"

#include <stddef.h>

static ty_texture* make_texture(ty_context* context, const ty_texture_def* def) {
    ty_texture* texture = NULL;
    if (ty_texture_create(context, def, &texture) != TY_OK) fail_msg("%s", ty_take_error(context));
    assert_non_null(texture);
    return texture;
}

/* One row of gray texels, alpha 255. */
static ty_texture* make_row(ty_context* context, const uint8_t* codes, int32_t width, ty_wrap wrap, bool nearest) {
    uint8_t* texels = malloc(4 * (size_t)width);
    assert_non_null(texels);
    for (int32_t i = 0; i < width; ++i) {
        memset(texels + 4 * i, codes[i], 3);
        texels[4 * i + 3] = 255;
    }
    ty_texture_def def = ty_default_texture_def();
    def.width = width;
    def.height = 1;
    def.rgba8 = texels;
    def.wrap[0] = def.wrap[1] = wrap;
    def.nearest = nearest;
    ty_texture* texture = make_texture(context, &def);
    free(texels);
    return texture;
}

static double decoded(int code) {
    const double value = code / 255.0;
    return value <= 0.04045 ? value / 12.92 : pow((value + 0.055) / 1.055, 2.4);
}

static double red_at(const ty_texture* texture, double u, double v) {
    float rgba[4];
    ty_texture_sample(texture, u, v, rgba);
    return (double)rgba[0];
}

/* Colour goes by sRGB's curve, alpha does not. */
static void codes_are_decoded(void** state) {
    uint8_t texels[256 * 4];
    for (int i = 0; i < 256; ++i) {
        texels[4 * i] = (uint8_t)i;
        texels[4 * i + 1] = (uint8_t)(255 - i);
        texels[4 * i + 2] = 188;
        texels[4 * i + 3] = (uint8_t)i;
    }
    ty_texture_def def = ty_default_texture_def();
    def.width = def.height = 16;
    def.rgba8 = texels;
    ty_texture* texture = make_texture(*state, &def);
    memset(texels, 0, sizeof texels); /* it has a copy */
    for (int i = 0; i < 256; ++i) {
        float rgba[4];
        ty_texture_sample(texture, (i % 16 + 0.5) / 16, (i / 16 + 0.5) / 16, rgba);
        assert_close(rgba[0], decoded(i), 1e-6);
        assert_close(rgba[1], decoded(255 - i), 1e-6);
        assert_close(rgba[2], 0.5028864, 1e-6);
        assert_close(rgba[3], i / 255.0, 1e-6);
    }
    ty_texture_release(texture);
}

/* Between centres, colour is linear in linear light. */
static void values_between_centres_are_bilinear(void** state) {
    const uint8_t texels[16] = {0, 0, 0, 0, 255, 0, 0, 255, 0, 255, 0, 255, 255, 255, 255, 51};
    ty_texture_def def = ty_default_texture_def();
    def.width = def.height = 2;
    def.rgba8 = texels;
    def.wrap[0] = def.wrap[1] = TY_WRAP_CLAMP;
    ty_texture* texture = make_texture(*state, &def);
    uint64_t random = 3;
    for (int i = 0; i < 1000; ++i) {
        const double u = uniform(&random), v = uniform(&random);
        const double x = fmin(fmax(2 * u - 0.5, 0), 1), y = fmin(fmax(2 * v - 0.5, 0), 1);
        float rgba[4];
        ty_texture_sample(texture, u, v, rgba);
        assert_close(rgba[0], x * (1 - y) + x * y, 1e-5);
        assert_close(rgba[1], y, 1e-5);
        assert_close(rgba[2], x * y, 1e-5);
        assert_close(rgba[3], x * (1 - y) + (1 - x) * y + 0.2 * x * y, 1e-5);
    }
    ty_texture_release(texture);
}

/* The texel that a coordinate's texel number stands for. */
static int wrapped(long number, int count, ty_wrap wrap) {
    if (wrap == TY_WRAP_CLAMP) return number < 0 ? 0 : number >= count ? count - 1 : (int)number;
    const long period = wrap == TY_WRAP_MIRROR ? 2 * count : count;
    const long rest = (number % period + period) % period;
    return (int)(rest < count ? rest : period - 1 - rest);
}

static void coordinates_wrap(void** state) {
    static const uint8_t codes[5] = {0, 60, 120, 180, 240};
    for (int wrap = TY_WRAP_REPEAT; wrap <= TY_WRAP_MIRROR; ++wrap) {
        ty_texture* sharp = make_row(*state, codes, 5, (ty_wrap)wrap, true);
        ty_texture* smooth = make_row(*state, codes, 5, (ty_wrap)wrap, false);
        for (int i = -60; i <= 60; ++i) {
            const double u = i * 0.097 + 0.0123, x = u * 5;
            assert_close(red_at(sharp, u, 0.5), decoded(codes[wrapped((long)floor(x), 5, (ty_wrap)wrap)]), 1e-6);
            const long left = (long)floor(x - 0.5);
            const double low = decoded(codes[wrapped(left, 5, (ty_wrap)wrap)]);
            const double high = decoded(codes[wrapped(left + 1, 5, (ty_wrap)wrap)]);
            assert_close(red_at(smooth, u, 0.5), low + (x - 0.5 - (double)left) * (high - low), 1e-5);
            assert_close(red_at(smooth, u, -3.7), red_at(smooth, u, 8.1), 0);
        }
        ty_texture_release(sharp);
        ty_texture_release(smooth);
    }
}

/* Far out, on wide textures, where a texel's number would not fit 32 bits. */
static void far_coordinates_wrap(void** state) {
    enum { WIDTH = 8192 };
    static uint8_t codes[WIDTH];
    for (int i = 0; i < WIDTH; ++i) codes[i] = (uint8_t)(i < WIDTH / 2 ? 40 : 200);
    const double low = decoded(40), high = decoded(200);
    for (int nearest = 0; nearest < 2; ++nearest) {
        ty_texture* repeat = make_row(*state, codes, WIDTH, TY_WRAP_REPEAT, nearest);
        ty_texture* clamp = make_row(*state, codes, WIDTH, TY_WRAP_CLAMP, nearest);
        ty_texture* mirror = make_row(*state, codes, WIDTH, TY_WRAP_MIRROR, nearest);
        for (double far = 10; far < 2e6; far *= 10) {
            assert_close(red_at(repeat, far + 0.25, 0), low, 1e-6);
            assert_close(red_at(repeat, -far + 0.75, 0), high, 1e-6);
            assert_close(red_at(mirror, far + 0.25, 0), low, 1e-6);
            assert_close(red_at(mirror, -far + 0.75, 0), high, 1e-6);
            assert_close(red_at(mirror, far + 1.25, 0), high, 1e-6);
            assert_close(red_at(clamp, far, 0), high, 1e-6);
            assert_close(red_at(clamp, -far, 0), low, 1e-6);
        }
        static const double strange[] = {1e9, 1e30, 1e300, INFINITY, NAN};
        for (int i = 0; i < 5; ++i) {
            if (i < 4) {
                assert_close(red_at(clamp, strange[i], 0), high, 1e-6);
                assert_close(red_at(clamp, -strange[i], 0), low, 1e-6);
            }
            ty_texture* all[3] = {repeat, clamp, mirror};
            for (int t = 0; t < 3; ++t)
                for (int sign = -1; sign <= 1; sign += 2) {
                    const double value = red_at(all[t], sign * strange[i], strange[i]);
                    assert_true(value >= low - 1e-6 && value <= high + 1e-6);
                }
        }
        ty_texture_release(repeat);
        ty_texture_release(clamp);
        ty_texture_release(mirror);
    }
}

static ty_image* make_image(ty_context* context, int32_t width, int32_t height, int32_t count,
                            const char* const* names) {
    ty_image* image = NULL;
    assert_int_equal(ty_image_create(context, width, height, count, names, &image), TY_OK);
    return image;
}

/* Linear as they are, mended where they must be. */
static void images_become_textures(void** state) {
    static const char* const names[] = {"A", "B", "G", "R"};
    ty_image* image = make_image(*state, 3, 2, 4, names);
    for (int c = 0; c < 4; ++c)
        for (int i = 0; i < 6; ++i) ty_image_plane(image, c)[i] = 0.1f * (float)(c + 1) + 1.5f * (float)i;
    float* red = ty_image_plane(image, 3);
    red[1] = NAN;
    red[2] = -3;
    red[3] = INFINITY;
    red[4] = 1e20f;
    ty_image_plane(image, 0)[5] = NAN;
    ty_texture_def def = ty_default_texture_def();
    def.image = image;
    ty_texture* texture = make_texture(*state, &def);
    assert_true(ty_texture_bytes(texture) > 6 * 4 * sizeof(float));
    ty_image_destroy(image);
    static const double expected_red[6] = {0.4, 0, 0, 0, 1e15, 7.9}, alpha[6] = {0.1, 1, 1, 1, 1, 0};
    for (int i = 0; i < 6; ++i) {
        float rgba[4];
        ty_texture_sample(texture, (i % 3 + 0.5) / 3, (i / 3 + 0.5) / 2, rgba);
        assert_close(rgba[0], expected_red[i], 1e-6 * fmax(1, expected_red[i]));
        assert_close(rgba[1], 0.3 + 1.5 * i, 1e-5);
        assert_close(rgba[2], 0.2 + 1.5 * i, 1e-5);
        assert_close(rgba[3], alpha[i], 1e-6);
    }
    ty_texture_release(texture);
}

static void one_channel_is_gray(void** state) {
    static const char* const names[] = {"density"};
    ty_image* image = make_image(*state, 1, 1, 1, names);
    ty_image_plane(image, 0)[0] = 2.5f;
    ty_texture_def def = ty_default_texture_def();
    def.image = image;
    ty_texture* texture = make_texture(*state, &def);
    float rgba[4];
    ty_texture_sample(texture, 0.3, -7, rgba);
    for (int c = 0; c < 3; ++c) assert_close(rgba[c], 2.5, 0);
    assert_close(rgba[3], 1, 0);
    ty_image_destroy(image);
    ty_texture_release(texture);
}

static void textures_are_shared(void** state) {
    static const uint8_t codes[2] = {255, 255};
    ty_texture* texture = make_row(*state, codes, 2, TY_WRAP_REPEAT, true);
    assert_ptr_equal(ty_texture_retain(texture), texture);
    assert_null(ty_texture_retain(NULL));
    ty_texture_release(texture);
    assert_close(red_at(texture, 0.5, 0.5), 1, 1e-6);
    ty_texture_release(texture);
    ty_texture_release(NULL);
}

#define TEXTURE(field, value, words)                                                                                   \
    { offsetof(ty_texture_def, field), FIELD_INT, value, words }

static void wrong_defs_are_refused(void** state) {
    static const bad_field bad[] = {
        TEXTURE(cookie, 0, "ty_default_texture_def"),
        TEXTURE(width, 0, "texture: 0 x 2"),
        TEXTURE(width, -4, "texture: -4 x 2"),
        TEXTURE(height, 0, "texture: 2 x 0"),
        TEXTURE(height, 32769, "texture: 2 x 32769 is not a size in 1..32768"),
        TEXTURE(wrap[0], 3, "texture.wrap[0]: 3 is not a ty_wrap"),
        TEXTURE(wrap[1], -1, "texture.wrap[1]: -1 is not a ty_wrap"),
    };
    static const uint8_t texels[16] = {0};
    ty_texture* texture = NULL;
    ty_texture_def def;
    for (size_t i = 0; i < sizeof bad / sizeof *bad; ++i) {
        def = ty_default_texture_def();
        def.width = def.height = 2;
        def.rgba8 = texels;
        set_field(&def, &bad[i]);
        assert_int_equal(ty_texture_create(*state, &def, &texture), TY_ERROR_ARGUMENT);
        assert_error(*state, bad[i].words);
    }
    assert_int_equal(ty_texture_create(*state, NULL, &texture), TY_ERROR_ARGUMENT);
    ty_take_error(*state);
    def = ty_default_texture_def();
    assert_int_equal(ty_texture_create(*state, &def, &texture), TY_ERROR_ARGUMENT);
    assert_error(*state, "one of rgba8 and image");
    static const char* const names[] = {"X", "Q"};
    ty_image* image = make_image(*state, 1, 1, 2, names);
    def.image = image;
    assert_int_equal(ty_texture_create(*state, &def, &texture), TY_ERROR_ARGUMENT);
    assert_error(*state, "neither R, G and B nor one channel");
    def.rgba8 = texels;
    assert_int_equal(ty_texture_create(*state, &def, &texture), TY_ERROR_ARGUMENT);
    assert_error(*state, "one of rgba8 and image");
    ty_image_destroy(image);
    assert_null(texture);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(codes_are_decoded),      cmocka_unit_test(values_between_centres_are_bilinear),
        cmocka_unit_test(coordinates_wrap),       cmocka_unit_test(far_coordinates_wrap),
        cmocka_unit_test(images_become_textures), cmocka_unit_test(one_channel_is_gray),
        cmocka_unit_test(textures_are_shared),    cmocka_unit_test(wrong_defs_are_refused),
    };
    return cmocka_run_group_tests(tests, start_context, stop_context);
}
