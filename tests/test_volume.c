/* Volumes of any kind: which reader, file sequences, raw files; and how grids are surveyed. */
#include "strict_fixture.h"

#include "base/half.h"
#include "grid/lookup.k.h"

#include <tyndall/io.h>

/* Little memory: what files claim is not believed. */
static int start_small(void** state) {
    start(state);
    memory.limit = (size_t)1 << 28;
    return 0;
}

static void frames_take_the_place_of_hashes(void** state) {
    (void)state;
    static const struct {
        const char* path;
        int32_t frame;
        const char* expected;
    } cases[] = {{"plume_####.vdb", 42, "plume_0042.vdb"},
                 {"c#/plume_##.vdb", 7, "c#/plume_07.vdb"},
                 {"a#b", 7, "a7b"},
                 {"a##", 12345, "a12345"},
                 {"plain.vdb", 9, "plain.vdb"},
                 {"##/x", 0, "##/x"}};
    char out[64];
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        assert_int_equal(ty_volume_path(context, cases[i].path, cases[i].frame, out, sizeof out), TY_OK);
        assert_string_equal(out, cases[i].expected);
    }
    assert_failed(context, ty_volume_path(context, "a#", -1, out, sizeof out), TY_ERROR_ARGUMENT, "frame", "-1");
    assert_failed(context, ty_volume_path(context, "a#b#", 1, out, sizeof out), TY_ERROR_ARGUMENT, "a#b#", "place");
    assert_failed(context, ty_volume_path(context, "abcd#", 1, out, 5), TY_ERROR_ARGUMENT, "abcd#", "longer");
    assert_int_equal(ty_volume_path(context, "abcd#", 1, out, 6), TY_OK);
}

static ty_volume_def raw_def(int32_t x, int32_t y, int32_t z, const char* type) {
    ty_volume_def def = ty_default_volume_def();
    def.raw_size[0] = x;
    def.raw_size[1] = y;
    def.raw_size[2] = z;
    snprintf(def.raw_type, sizeof def.raw_type, "%s", type);
    return def;
}

static void raw_files_are_what_they_are_said_to_be(void** state) {
    (void)state;
    static const uint8_t bytes[] = {0x3c, 0x00, 0xc0, 0x00, 0x42, 0x00, 0x7c, 0x00};
    static const float values[4] = {1, -2, 3, 0}; /* big-endian halves; infinity counts as 0 */
    put_file("half.raw", bytes, sizeof bytes);
    ty_volume_def def = raw_def(2, 2, 1, "half");
    def.raw_big_endian = true;
    ty_grid* grid = NULL;
    assert_int_equal(ty_volume_read(context, "half.raw", &def, &grid), TY_OK);
    for (int i = 0; i < 4; ++i) assert_true(ty_grid_voxel(grid, i % 2, i / 2, 0) == values[i]);
    assert_int_equal(ty_grid_get_info(grid).type, TY_GRID_F16);
    assert_false(ty_grid_get_info(grid).placed);
    ty_grid_release(grid);

    def = raw_def(1, 2, 1, "uint16");
    def.raw_offset = 4;
    for (int a = 0; a < 3; ++a) def.raw_spacing[a] = 0.5 * (a + 1);
    for (int pass = 0; pass < 2; ++pass) {
        assert_int_equal(ty_volume_read(context, "half.raw", &def, &grid), TY_OK);
        assert_true(ty_grid_voxel(grid, 0, 0, 0) == 0x42 && ty_grid_voxel(grid, 0, 1, 0) == 0x7c);
        assert_true(ty_grid_get_info(grid).placed && ty_grid_get_info(grid).index_to_local.m[10] == 1.5);
        ty_grid_release(grid);
        def.raw_offset = -1;
    }
    int32_t components = 0;
    assert_int_equal(ty_volume_components(context, "half.raw", &def, &components), TY_OK);
    assert_int_equal(components, 1);
}

static void wrong_raw_files_are_explained(void** state) {
    (void)state;
    put_file("eight.raw", "12345678", 8);
    ty_volume_def good = raw_def(2, 2, 2, "uint8"), def;
    ty_grid* grid = NULL;
    def = ty_default_volume_def();
    assert_failed(context, ty_volume_read(context, "eight.raw", &def, &grid), TY_ERROR_INPUT, "eight.raw",
                  "needs its size");
    assert_failed(context, ty_volume_read(context, "gone.raw", &good, &grid), TY_ERROR_FILE, "gone.raw",
                  "No such file");
    def = raw_def(2, 2, 3, "uint8");
    assert_failed(context, ty_volume_read(context, "eight.raw", &def, &grid), TY_ERROR_INPUT, "eight.raw", "12");
    def = raw_def(2, 2, 1, "uint8");
    assert_failed(context, ty_volume_read(context, "eight.raw", &def, &grid), TY_ERROR_INPUT, "eight.raw", "8 bytes");
    def = raw_def(16384, 16384, 16384, "uint8");
    assert_failed(context, ty_volume_read(context, "eight.raw", &def, &grid), TY_ERROR_INPUT, "eight.raw", "spans");
    def = raw_def(2, 2, 2, "uint7");
    assert_failed(context, ty_volume_read(context, "eight.raw", &def, &grid), TY_ERROR_ARGUMENT, "raw_type", "uint7");
    def = good;
    def.raw_spacing[1] = -1;
    assert_failed(context, ty_volume_read(context, "eight.raw", &def, &grid), TY_ERROR_ARGUMENT, "raw_spacing", "-1");
    def.raw_spacing[1] = 2;
    assert_failed(context, ty_volume_read(context, "eight.raw", &def, &grid), TY_ERROR_ARGUMENT, "raw_spacing",
                  "not all");
    def = good;
    def.raw_offset = -2;
    assert_failed(context, ty_volume_read(context, "eight.raw", &def, &grid), TY_ERROR_ARGUMENT, "raw_offset", "-2");
    def = good;
    def.component = 1;
    assert_failed(context, ty_volume_read(context, "eight.raw", &def, &grid), TY_ERROR_INPUT, "eight.raw",
                  "component 1");
    def.component = -1;
    assert_failed(context, ty_volume_read(context, "eight.raw", &def, &grid), TY_ERROR_ARGUMENT, "component", "-1");
    def = good;
    def.cookie = 0;
    assert_int_equal(ty_volume_read(context, "eight.raw", &def, &grid), TY_ERROR_ARGUMENT);
    ty_take_error(context);
    /* A known extension counts before a raw size does. */
    put_file("eight.vdb", "12345678", 8);
    assert_failed(context, ty_volume_read(context, "eight.vdb", &good, &grid), TY_ERROR_INPUT, "eight.vdb",
                  "not an OpenVDB");
    put_file("eight.nhdr", "12345678", 8);
    assert_failed(context, ty_volume_read(context, "eight.nhdr", &good, &grid), TY_ERROR_INPUT, "eight.nhdr",
                  "not an NRRD");
    assert_null(grid);
}

/* A file's content counts before its extension does. */
static void kinds_are_told_by_content(void** state) {
    (void)state;
    ty_grid_def def = ty_default_grid_def();
    static const float values[8] = {1, 2, 3, 4, 5, 6, 7, 8};
    for (int a = 0; a < 3; ++a) def.size[a] = 2;
    def.values = values;
    ty_grid* grid = NULL;
    assert_int_equal(ty_grid_create(context, &def, &grid), TY_OK);
    assert_int_equal(ty_vdb_write(context, grid, "density", "none", "a.bin"), TY_OK);
    assert_int_equal(ty_nanovdb_write(context, grid, "density", "none", "b.vdb"), TY_OK);
    assert_int_equal(ty_nrrd_write(context, grid, TY_NRRD_CODEC_RAW, "c.nvdb"), TY_OK);
    ty_grid_release(grid);
    static const char* const paths[] = {"a.bin", "b.vdb", "c.nvdb"};
    const ty_volume_def volume = ty_default_volume_def();
    for (int i = 0; i < 3; ++i) {
        assert_int_equal(ty_volume_read(context, paths[i], &volume, &grid), TY_OK);
        assert_true(ty_grid_voxel(grid, 1, 1, 1) == 8);
        ty_grid_release(grid);
    }
}

/* The table of extremes against its definition, voxel by voxel, and the statistics. */
static void surveys_are_what_they_are_defined_to_be(void** state) {
    (void)state;
    static const int32_t sizes[][3] = {{1, 1, 1}, {7, 8, 9}, {8, 7, 16}, {17, 3, 23}, {40, 15, 1}};
    static uint16_t halves[17 * 40 * 23];
    static float floats[17 * 40 * 23];
    for (size_t i = 0; i < sizeof halves / sizeof halves[0]; ++i) {
        floats[i] = (float)((i * 7919) % 2003) / 64 - 9;
        halves[i] = ty_float_to_half(floats[i]);
        floats[i] = ty_half_to_float(halves[i]);
    }
    for (int c = 0; c < 20; ++c) {
        ty_grid_def def = ty_default_grid_def();
        memcpy(def.size, sizes[c / 4], sizeof def.size);
        def.type = c % 2 == 0 ? TY_GRID_F32 : TY_GRID_F16;
        def.values = c % 2 == 0 ? (const void*)floats : halves;
        def.placed = c % 4 < 2;
        def.background = 100;
        ty_grid* grid = NULL;
        assert_int_equal(ty_grid_create(context, &def, &grid), TY_OK);
        const ty_grid_view view = ty_grid_get_view(grid);
        const float* pair = view.extremes;
        for (int bk = 0; bk < view.bricks[2]; ++bk)
            for (int bj = 0; bj < view.bricks[1]; ++bj)
                for (int bi = 0; bi < view.bricks[0]; ++bi, pair += 2) {
                    float low = INFINITY, high = -INFINITY;
                    for (int k = 8 * bk - 1; k <= 8 * bk + 7; ++k)
                        for (int j = 8 * bj - 1; j <= 8 * bj + 7; ++j)
                            for (int i = 8 * bi - 1; i <= 8 * bi + 7; ++i) {
                                low = fminf(low, ty_grid_fetch(&view, i, j, k));
                                high = fmaxf(high, ty_grid_fetch(&view, i, j, k));
                            }
                    assert_true(pair[0] == low && pair[1] == high);
                }
        const ty_grid_info info = ty_grid_get_info(grid);
        float least = INFINITY, most = -INFINITY;
        double sum = 0;
        const size_t slice = (size_t)def.size[0] * (size_t)def.size[1];
        for (size_t k = 0; k < (size_t)def.size[2]; ++k) {
            double part = 0;
            for (size_t i = 0; i < slice; ++i) {
                part += (double)floats[slice * k + i];
                least = fminf(least, floats[slice * k + i]);
                most = fmaxf(most, floats[slice * k + i]);
            }
            sum += part;
        }
        assert_true(info.min == least && info.max == most && info.mean == sum / (double)(slice * (size_t)def.size[2]));
        ty_grid_release(grid);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(frames_take_the_place_of_hashes),
        cmocka_unit_test(raw_files_are_what_they_are_said_to_be),
        cmocka_unit_test(wrong_raw_files_are_explained),
        cmocka_unit_test(kinds_are_told_by_content),
        cmocka_unit_test(surveys_are_what_they_are_defined_to_be),
    };
    return cmocka_run_group_tests(tests, start_small, stop);
}
