/* Screen-space scattering as callers see it: layouts, in place, threads, instruction sets, memory, sizes, refusals. */
#include "files.h"
#include "screen_maker.h"

#include "base/isa.h"
#include "method/screen/job.h"

#include <stddef.h>

/* Light, distances and a fog that spreads it over a few pixels and over most of the picture. */
static picture scene_picture(int32_t width, int32_t height) {
    picture p = make_picture(width, height, 1);
    fill_random(&p, 0.5, 60, (uint64_t)(width * 1000 + height));
    return p;
}

static ty_screen_def scene_fog(variant v) {
    ty_screen_def def = gray_fog(0.05, 0.01, 0.8, 60);
    set3f(def.sigma_s, 0.05, 0.08, 0.01);
    set3f(def.g, 0.8, 0.9, 0.4);
    set3f(def.environment, 0.1, 0.2, 0.3);
    def.window = 9;
    set_variant(&def, v);
    return def;
}

static void assert_same_bits(const char* what, variant v, const float* a, const float* b, int64_t count) {
    for (int64_t i = 0; i < count; ++i)
        if (memcmp(&a[i], &b[i], sizeof(float)) != 0)
            fail_msg("%s, %s: value %d is %.9g, not %.9g", what, variant_names[v], (int)i, (double)a[i], (double)b[i]);
}

/* ---- layouts ---- */

enum { LAYOUT_COUNT = 6, PADDING = 13 };
static const char* const layout_names[LAYOUT_COUNT] = {"planar", "RGBA", "RGB", "padded", "bottom-up", "mirrored"};

/* Planes of one of the layouts in memory that holds 4 * (width + PADDING) * height floats. */
static ty_screen_planes lay_out(int layout, float* memory, int32_t width, int32_t height) {
    const ptrdiff_t step = layout == 1 ? 4 : layout == 2 ? 3 : layout == 5 ? -1 : 1;
    const ptrdiff_t length = layout == 1 ? 4 * width : layout == 2 ? 3 * width : layout == 3 ? width + PADDING : width;
    const ptrdiff_t first = layout == 4 ? (height - 1) * length : layout == 5 ? width - 1 : 0;
    const ptrdiff_t plane = layout == 1 || layout == 2 ? 1 : length * height;
    return (ty_screen_planes){
        {memory + first, memory + first + plane, memory + first + 2 * plane}, step, layout == 4 ? -length : length};
}

static float* at(const ty_screen_planes* planes, int c, int32_t x, int32_t y) {
    return planes->data[c] + y * planes->row + x * planes->step;
}

static void copy_planes(const ty_screen_planes* to, const ty_screen_planes* from, int32_t width, int32_t height) {
    for (int c = 0; c < 3; ++c)
        for (int32_t y = 0; y < height; ++y)
            for (int32_t x = 0; x < width; ++x) *at(to, c, x, y) = *at(from, c, x, y);
}

static float* layout_memory(const picture* p) {
    const size_t count = 4 * (size_t)(p->width + PADDING) * (size_t)p->height;
    float* memory = calloc(count, sizeof(float));
    assert_non_null(memory);
    for (size_t i = 0; i < count; ++i) memory[i] = -123;
    return memory;
}

/* Applies with pictures laid out in any way (out: LAYOUT_COUNT for in place), and holds the outcome against p->out. */
static void check_layout(ty_context* context, variant v, const picture* p, int color, int out) {
    float *color_memory = layout_memory(p), *out_memory = layout_memory(p), *distance_memory = layout_memory(p);
    const ty_screen_def def = scene_fog(v);
    const ty_screen_image plain = image_of(p);
    ty_screen_image image = plain;
    image.color = lay_out(color, color_memory, p->width, p->height);
    image.out = out < LAYOUT_COUNT ? lay_out(out, out_memory, p->width, p->height) : image.color;
    copy_planes(&image.color, &plain.color, p->width, p->height);
    const ty_screen_planes distance = lay_out(color, distance_memory, p->width, p->height);
    image.distance = distance.data[0];
    image.distance_step = distance.step;
    image.distance_row = distance.row;
    for (int32_t i = 0; i < pixel_count(p); ++i) *at(&distance, 0, i % p->width, i / p->width) = p->distance[i];
    assert_int_equal(ty_screen_apply(context, &def, &image, NULL, 0, NULL), TY_OK);
    for (int c = 0; c < 3; ++c)
        for (int32_t i = 0; i < pixel_count(p); ++i) {
            float* value = at(&image.out, c, i % p->width, i / p->width);
            if (memcmp(value, &p->out[c * pixel_count(p) + i], sizeof(float)) != 0)
                fail_msg("%s: %s to %s: %.9g is not %.9g", variant_names[v], layout_names[color],
                         out < LAYOUT_COUNT ? layout_names[out] : "the same place", (double)*value,
                         (double)p->out[c * pixel_count(p) + i]);
            *value = -123;
        }
    const float* touched = out < LAYOUT_COUNT ? out_memory : color_memory;
    for (int32_t i = 0; i < 4 * (p->width + PADDING) * p->height; ++i) assert_true(touched[i] == -123);
    free(color_memory);
    free(out_memory);
    free(distance_memory);
}

static void layouts_make_no_difference(void** state) {
    for (int v = 0; v < VARIANT_COUNT; ++v) {
        picture p = scene_picture(67, 141);
        const ty_screen_def def = scene_fog((variant)v);
        apply(*state, &def, &p);
        for (int color = 0; color < LAYOUT_COUNT; ++color)
            for (int out = 0; out <= LAYOUT_COUNT; ++out) check_layout(*state, (variant)v, &p, color, out);
        free_picture(&p);
    }
}

/* Out may be the picture's planes in another order. */
static void channels_may_change_places(void** state) {
    for (int medium = 0; medium < 2; ++medium)
        for (int v = 0; v < VARIANT_COUNT; ++v) {
            picture p = scene_picture(33, 140);
            ty_screen_def def = scene_fog((variant)v);
            if (medium == 0) def.sigma_s[0] = def.sigma_s[1] = def.sigma_s[2] = 0;
            if (medium == 0) def.sigma_a[0] = def.sigma_a[1] = def.sigma_a[2] = 0;
            apply(*state, &def, &p);
            ty_screen_image image = image_of(&p);
            for (int c = 0; c < 3; ++c) image.out.data[c] = image.color.data[2 - c];
            assert_int_equal(ty_screen_apply(*state, &def, &image, NULL, 0, NULL), TY_OK);
            for (int c = 0; c < 3; ++c)
                assert_same_bits("swapped", (variant)v, image.out.data[c], p.out + c * pixel_count(&p),
                                 pixel_count(&p));
            free_picture(&p);
        }
}

/* ---- threads and instruction sets ---- */

/* A picture whose first two levels are shared among threads. */
static void threads_make_no_difference(void** state) {
    (void)state;
    static const int32_t threads[] = {1, 2, 3, 7};
    for (int v = 0; v < VARIANT_COUNT; ++v) {
        picture p = scene_picture(530, 260);
        const size_t floats = 3 * (size_t)pixel_count(&p);
        float* first = malloc(floats * sizeof(float));
        assert_non_null(first);
        for (int i = 0; i < 4; ++i) {
            ty_context* context = make_context(threads[i]);
            ty_screen_def def = scene_fog((variant)v);
            def.window = 3;
            apply(context, &def, &p);
            if (i == 0) memcpy(first, p.out, floats * sizeof(float));
            assert_same_bits("threads", (variant)v, p.out, first, (int64_t)floats);
            ty_context_destroy(context);
        }
        free(first);
        free_picture(&p);
    }
}

static void instruction_sets_agree(void** state) {
    const ty_isa best = ty_best_isa();
    for (int v = 0; v < VARIANT_COUNT; ++v) {
        picture p = scene_picture(97, 61);
        ty_screen_def def = gray_fog(0.05, 0.01, 0, 60);
        def.window = 15;
        set_variant(&def, (variant)v);
        apply(*state, &def, &p);
        float* expected = p.out;
        p.out = calloc(3 * (size_t)pixel_count(&p), sizeof(float));
        for (int isa = 0; isa <= (int)best; ++isa) {
            ty_force_isa((ty_isa)isa);
            apply(*state, &def, &p);
            ty_force_isa(TY_ISA_COUNT);
            for (int32_t i = 0; i < 3 * pixel_count(&p); ++i)
                assert_close((double)p.out[i], (double)expected[i], 2e-5 * (double)expected[i]);
        }
        free(expected);
        free_picture(&p);
    }
}

/* ---- memory ---- */

static void workspace_is_exact(void** state) {
    enum { GUARD = 256 };
    static const int32_t sizes[][2] = {{1, 1}, {1, 90}, {90, 1}, {3, 5}, {64, 64}, {65, 129}, {131, 70}};
    for (int v = 0; v < VARIANT_COUNT; ++v)
        for (int i = 0; i < 7; ++i)
            for (int32_t filter = 2; filter <= 6; filter += 2)
                for (size_t guard = 0; guard <= GUARD; guard += GUARD) { /* without: for address sanitizers */
                    picture p = scene_picture(sizes[i][0], sizes[i][1]);
                    const ty_screen_image image = image_of(&p);
                    ty_screen_def def = scene_fog((variant)v);
                    def.filter = filter;
                    const size_t size = ty_screen_workspace(*state, &def, p.width, p.height);
                    assert_true(size > 0 && size % 64 == 0);
                    unsigned char* memory = aligned_alloc(64, size + guard);
                    assert_non_null(memory);
                    memset(memory, 0xff, size + guard); /* NaN */
                    assert_int_equal(ty_screen_apply(*state, &def, &image, memory, size, NULL), TY_OK);
                    for (size_t k = size; k < size + guard; ++k) assert_int_equal(memory[k], 0xff);
                    for (int32_t k = 0; k < 3 * pixel_count(&p); ++k) assert_true(p.out[k] >= 0);
                    assert_int_equal(ty_screen_apply(*state, &def, &image, memory, size - 1, NULL), TY_ERROR_ARGUMENT);
                    assert_error(*state, "workspace");
                    assert_int_equal(ty_screen_apply(*state, &def, &image, memory + 4, size, NULL), TY_ERROR_ARGUMENT);
                    assert_error(*state, "aligned to 64");
                    free(memory);
                    free_picture(&p);
                }
}

static void with_a_workspace_nothing_is_allocated(void** state) {
    (void)state;
    strict_memory memory = {.limit = SIZE_MAX, .until_refusal = -1};
    ty_context* context = strict_context(&memory);
    picture p = scene_picture(260, 150);
    const ty_screen_image image = image_of(&p);
    for (int v = 0; v < VARIANT_COUNT; ++v) {
        const ty_screen_def def = scene_fog((variant)v);
        const size_t size = ty_screen_workspace(context, &def, p.width, p.height);
        void* workspace = aligned_alloc(64, size);
        apply(context, &def, &p); /* threads, if any are kept, are there from here on */
        const size_t before = memory.used;
        memory.until_refusal = 9; /* each allocation takes 1 */
        assert_int_equal(ty_screen_apply(context, &def, &image, workspace, size, NULL), TY_OK);
        assert_int_equal(memory.until_refusal, 9);
        memory.until_refusal = 0;
        assert_int_equal(ty_screen_apply(context, &def, &image, workspace, size, NULL), TY_OK);
        assert_int_equal(ty_screen_apply(context, &def, &image, NULL, 0, NULL), TY_ERROR_MEMORY);
        assert_error(context, "not enough memory");
        float* const none[3] = {NULL, NULL, NULL};
        assert_int_equal(ty_screen_split(context, &def, &image, none, none, none), TY_ERROR_MEMORY);
        assert_error(context, "not enough memory");
        int64_t filled = 0;
        assert_int_equal(ty_screen_fill_distance(context, 9, 9, p.distance, &filled), TY_ERROR_MEMORY);
        assert_error(context, "not enough memory");
        memory.until_refusal = -1;
        assert_int_equal(memory.used, before);
        free(workspace);
    }
    free_picture(&p);
    ty_context_destroy(context);
    assert_int_equal(memory.used, 0);
}

/* ---- sizes ---- */

/* Every size has its own way to the edge: a uniform picture finds texels that are left out or counted twice. */
static void all_sizes_work(void** state) {
    static const int32_t sizes[][2] = {{1, 1},   {1, 2},   {2, 1},   {2, 2},   {1, 17},  {17, 1},  {3, 5},   {5, 3},
                                       {4, 4},   {6, 7},   {7, 6},   {8, 1},   {65, 1},  {1, 65},  {64, 63}, {63, 64},
                                       {65, 66}, {127, 3}, {3, 129}, {257, 2}, {255, 5}, {513, 1}, {31, 33}, {9, 9}};
    for (int v = 0; v < VARIANT_COUNT; ++v)
        for (size_t i = 0; i < sizeof sizes / sizeof *sizes; ++i)
            for (int32_t filter = 2; filter <= 6; filter += 2) {
                picture p = make_picture(sizes[i][0], sizes[i][1], 20);
                fill_color(&p, 1, 10, 100);
                ty_screen_def def = gray_fog(0.05, 0.02, 0.6, 200);
                def.filter = filter;
                def.levels = TY_SCREEN_LEVELS_ALL;
                set_variant(&def, (variant)v);
                const ty_screen_stats stats = apply(*state, &def, &p);
                if (v != PUBLISHED)
                    for (int32_t k = 0; k < 3 * pixel_count(&p); ++k) {
                        const double expected = (double)p.color[k] * exp(-0.02 * 20);
                        if (!(fabs((double)p.out[k] - expected) <= 1e-5 * expected))
                            fail_msg("%s, %d x %d, filter %d: %g is not %g", variant_names[v], p.width, p.height,
                                     filter, (double)p.out[k], expected);
                    }
                assert_true(stats.seconds >= 0 && strlen(stats.isa) > 0);
                free_picture(&p);
            }
}

static void longest_sides_work(void** state) {
    for (int v = 0; v < REFERENCE; ++v)
        for (int upright = 0; upright < 2; ++upright) {
            picture p = make_picture(upright ? 1 : TY_SCREEN_SIDE_MAX, upright ? TY_SCREEN_SIDE_MAX : 1, 20);
            fill_color(&p, 1, 10, 100);
            ty_screen_def def = gray_fog(0.05, 0, 0.6, 200);
            def.levels = TY_SCREEN_LEVELS_MAX;
            set_variant(&def, (variant)v);
            assert_int_equal(apply(*state, &def, &p).levels, TY_SCREEN_LEVELS_MAX);
            for (int32_t k = 0; v != PUBLISHED && k < 3 * pixel_count(&p); ++k)
                assert_close((double)p.out[k], (double)p.color[k], 1e-5 * (double)p.color[k]);
            free_picture(&p);
        }
}

/* ---- refusals ---- */

#define DOUBLE(field) offsetof(ty_screen_def, field), FIELD_DOUBLE
#define FLOAT(field) offsetof(ty_screen_def, field), FIELD_FLOAT
#define INT(field) offsetof(ty_screen_def, field), FIELD_INT

static const bad_field bad_fields[] = {
    {FLOAT(sigma_s[1]), -1, "sigma_s"},
    {FLOAT(sigma_s[2]), (double)NAN, "sigma_s"},
    {FLOAT(sigma_a[0]), (double)INFINITY, "sigma_a"},
    {FLOAT(g[2]), 1, "screen.g"},
    {FLOAT(g[0]), -1, "screen.g"},
    {FLOAT(g[1]), (double)NAN, "screen.g"},
    {FLOAT(environment[1]), -0.5, "environment"},
    {FLOAT(forward[0]), 1.5, "forward"},
    {FLOAT(forward[2]), -0.1, "forward"},
    {DOUBLE(focal[0]), 0, "focal"},
    {DOUBLE(focal[1]), -3, "focal"},
    {DOUBLE(focal[1]), (double)NAN, "focal"},
    {DOUBLE(focal[0]), 1e300, "focal"},
    {DOUBLE(center[0]), (double)INFINITY, "center"},
    {DOUBLE(center[1]), (double)NAN, "center"},
    {FLOAT(missing_depth), 0, "missing_depth"},
    {FLOAT(missing_depth), (double)INFINITY, "missing_depth"},
    {INT(filter), 3, "filter"},
    {INT(filter), 0, "filter"},
    {INT(levels), 0, "levels"},
    {INT(levels), 16, "levels"},
    {INT(levels), -3, "levels"},
    {INT(variant), 3, "variant"},
    {INT(variant), -1, "variant"},
    {INT(spread), 2, "spread"},
    {INT(mask), 3, "mask"},
    {FLOAT(mask_width), 0, "mask_width"},
    {FLOAT(mask_width), (double)NAN, "mask_width"},
    {FLOAT(level_scale), 0, "level_scale"},
    {INT(window), -1, "window"},
    {INT(window), 65537, "window"},
};

static void bad_fields_are_refused(void** state) {
    picture p = scene_picture(8, 8);
    const ty_screen_image image = image_of(&p);
    for (size_t i = 0; i < sizeof bad_fields / sizeof *bad_fields; ++i) {
        ty_screen_def def = scene_fog(GATHER);
        set_field(&def, &bad_fields[i]);
        assert_int_equal(ty_screen_apply(*state, &def, &image, NULL, 0, NULL), TY_ERROR_ARGUMENT);
        assert_error(*state, bad_fields[i].words);
        const bool decides = strcmp(bad_fields[i].words, "filter") == 0 || strcmp(bad_fields[i].words, "levels") == 0 ||
                             strcmp(bad_fields[i].words, "variant") == 0;
        if (decides) assert_int_equal(ty_screen_workspace(*state, &def, 8, 8), 0);
    }
    ty_screen_def unmade = scene_fog(GATHER);
    unmade.cookie = 0;
    assert_int_equal(ty_screen_apply(*state, &unmade, &image, NULL, 0, NULL), TY_ERROR_ARGUMENT);
    assert_error(*state, "ty_default_screen_def");
    assert_int_equal(ty_screen_workspace(*state, &unmade, 8, 8), 0);
    for (int32_t i = 0; i < 3 * pixel_count(&p); ++i) assert_true(p.out[i] == -1);
    free_picture(&p);
}

static void refuse(ty_context* context, const ty_screen_image* image, const char* words) {
    const ty_screen_def def = scene_fog(SMALL_ANGLE);
    assert_int_equal(ty_screen_apply(context, &def, image, NULL, 0, NULL), TY_ERROR_ARGUMENT);
    assert_error(context, words);
}

static void bad_images_are_refused(void** state) {
    picture p = scene_picture(8, 8);
    const ty_screen_def def = scene_fog(SMALL_ANGLE);
    static const int32_t sizes[] = {0, -1, 65537};
    for (int i = 0; i < 3; ++i) {
        ty_screen_image wide = image_of(&p), high = image_of(&p);
        wide.width = high.height = sizes[i];
        refuse(*state, &wide, "outside 1..65536");
        refuse(*state, &high, "outside 1..65536");
        assert_int_equal(ty_screen_workspace(*state, &def, sizes[i], 8), 0);
        assert_int_equal(ty_screen_workspace(*state, &def, 8, sizes[i]), 0);
    }
    ty_screen_image image = image_of(&p);
    image.color.data[1] = NULL;
    refuse(*state, &image, "color.data[1]");
    image = image_of(&p);
    image.out.data[2] = NULL;
    refuse(*state, &image, "out.data[2]");
    image = image_of(&p);
    image.color.step = 0;
    refuse(*state, &image, "color.step");
    image = image_of(&p);
    image.distance = NULL;
    refuse(*state, &image, "distance");
    image = (ty_screen_image){.width = 8, .height = 8};
    refuse(*state, &image, "ty_default_screen_image");
    refuse(*state, NULL, "ty_default_screen_image");
    assert_int_equal(ty_screen_apply(NULL, &def, &image, NULL, 0, NULL), TY_ERROR_ARGUMENT);
    free_picture(&p);
}

static bool stop_after_three(void* user, const ty_progress* progress) {
    assert_true(progress->fraction >= 0 && progress->fraction <= 1);
    assert_int_equal(progress->total, 0); /* not samples per pixel */
    return ++*(int*)user < 3;
}

static void the_reference_can_be_cancelled(void** state) {
    picture p = scene_picture(400, 200);
    ty_screen_def def = scene_fog(REFERENCE);
    int calls = 0;
    def.progress = stop_after_three;
    def.progress_user = &calls;
    const ty_screen_image image = image_of(&p);
    assert_int_equal(ty_screen_apply(*state, &def, &image, NULL, 0, NULL), TY_CANCELLED);
    assert_int_equal(calls, 3);
    free_picture(&p);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(layouts_make_no_difference),
        cmocka_unit_test(channels_may_change_places),
        cmocka_unit_test(threads_make_no_difference),
        cmocka_unit_test(instruction_sets_agree),
        cmocka_unit_test(workspace_is_exact),
        cmocka_unit_test(with_a_workspace_nothing_is_allocated),
        cmocka_unit_test(all_sizes_work),
        cmocka_unit_test(longest_sides_work),
        cmocka_unit_test(bad_fields_are_refused),
        cmocka_unit_test(bad_images_are_refused),
        cmocka_unit_test(the_reference_can_be_cancelled),
    };
    return cmocka_run_group_tests(tests, start_context, stop_context);
}
