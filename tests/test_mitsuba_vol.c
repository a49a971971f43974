/* Mitsuba's .vol grids: encodings, components, placement, broken files. */
#include "strict_fixture.h"

#include <tyndall/io.h>

#include <math.h>

enum { NX = 4, NY = 3, NZ = 2, VOXELS = NX * NY * NZ, HEADER = 48 };

static uint8_t bytes[1024];

static void set_word(size_t at, uint32_t bits) {
    for (size_t i = 0; i < 4; ++i) bytes[at + i] = (uint8_t)(bits >> 8 * i);
}

static void set_float(size_t at, float value) {
    uint32_t bits;
    memcpy(&bits, &value, sizeof bits);
    set_word(at, bits);
}

/* A header of 4 x 3 x 2 voxels that fill the box from (-2, 0, 1) to (2, 6, 2). */
static void make_header(uint32_t encoding, uint32_t components) {
    static const float box[6] = {-2, 0, 1, 2, 6, 2};
    memset(bytes, 0, sizeof bytes);
    memcpy(bytes, "VOL\3", 4);
    set_word(4, encoding);
    set_word(8, NX);
    set_word(12, NY);
    set_word(16, NZ);
    set_word(20, components);
    for (size_t i = 0; i < 6; ++i) set_float(24 + 4 * i, box[i]);
}

static ty_grid* read_component(int component) {
    ty_volume_def def = ty_default_volume_def();
    def.component = component;
    ty_grid* grid = NULL;
    if (ty_volume_read(context, "a.vol", &def, &grid) != TY_OK) fail_msg("%s", ty_take_error(context));
    return grid;
}

static double voxel(const ty_grid* grid, int i) {
    return (double)ty_grid_voxel(grid, i % NX, i / NX % NY, i / (NX * NY));
}

static void floats_have_components(void** state) {
    (void)state;
    static const double expected[12] = {1, 0, 0, -1.5, 0, 2, 0, 1, 0, 0, 0.5, 1.25};
    make_header(1, 3);
    for (size_t i = 0; i < (size_t)3 * VOXELS; ++i) set_float(HEADER + 4 * i, (float)i / 4);
    put_file("a.vol", bytes, HEADER + (size_t)12 * VOXELS);
    ty_volume_def def = ty_default_volume_def();
    int32_t components = 0;
    assert_int_equal(ty_volume_components(context, "a.vol", &def, &components), TY_OK);
    assert_int_equal(components, 3);
    for (int c = 0; c < 3; ++c) {
        ty_grid* grid = read_component(c);
        for (int i = 0; i < VOXELS; ++i) assert_true(voxel(grid, i) == (3 * i + c) / 4.0);
        const ty_grid_info info = ty_grid_get_info(grid);
        assert_true(info.placed);
        for (int i = 0; i < 12; ++i) assert_true(fabs(info.index_to_local.m[i] - expected[i]) < 1e-12);
        ty_grid_release(grid);
    }
}

/* Files that are read and written again are the same; a grid that a box cannot place is refused. */
static void grids_are_written(void** state) {
    (void)state;
    make_header(1, 1);
    for (size_t i = 0; i < VOXELS; ++i) set_float(HEADER + 4 * i, (float)i / 3);
    put_file("a.vol", bytes, HEADER + (size_t)4 * VOXELS);
    ty_grid* grid = read_component(0);
    assert_int_equal(ty_mitsuba_write(context, grid, "b.vol"), TY_OK);
    assert_file_holds("b.vol", bytes, HEADER + (size_t)4 * VOXELS);
    ty_grid_release(grid);
    ty_grid_def def = ty_default_grid_def();
    for (int a = 0; a < 3; ++a) def.size[a] = 2;
    assert_int_equal(ty_grid_create(context, &def, &grid), TY_OK); /* unplaced: the unit cube */
    assert_int_equal(ty_mitsuba_write(context, grid, "b.vol"), TY_OK);
    ty_grid_release(grid);
    def.placed = true;
    def.index_to_local.m[5] = -1;
    assert_int_equal(ty_grid_create(context, &def, &grid), TY_OK);
    assert_failed(context, ty_mitsuba_write(context, grid, "b.vol"), TY_ERROR_INPUT, "b.vol", "reversed");
    ty_grid_release(grid);
    assert_failed(context, ty_mitsuba_write(context, NULL, "b.vol"), TY_ERROR_ARGUMENT, "ty_mitsuba_write", "NULL");
    assert_int_equal(remove_temporary_files(), 0);
}

static void bytes_are_fractions(void** state) {
    (void)state;
    make_header(3, 1);
    for (int i = 0; i < VOXELS; ++i) bytes[HEADER + i] = (uint8_t)(5 * i);
    put_file("a.vol", bytes, HEADER + VOXELS);
    ty_grid* grid = read_component(0);
    for (int i = 0; i < VOXELS; ++i) assert_true(voxel(grid, i) == (double)(float)(5 * i / 255.0));
    ty_grid_release(grid);
    make_header(2, 1); /* halves: 0x3c00 is 1 */
    for (int i = 0; i < VOXELS; ++i) bytes[HEADER + 2 * i + 1] = 0x3c;
    for (size_t i = 24; i < HEADER; ++i) bytes[i] = 0; /* a box of no volume */
    put_file("a.vol", bytes, HEADER + 2 * VOXELS);
    grid = read_component(0);
    for (int i = 0; i < VOXELS; ++i) assert_true(voxel(grid, i) == 1);
    assert_false(ty_grid_get_info(grid).placed);
    ty_grid_release(grid);
}

static void broken_files_are_refused(void** state) {
    (void)state;
    static const struct {
        size_t at;
        uint32_t bits;
        const char* words;
    } cases[] = {{0, 0x024c4f56, "version 2"},
                 {4, 4, "encoding 4"},
                 {8, 0, "0 x 3 x 2"},
                 {12, 0xfffffff0, "4 x -16 x 2"},
                 {8, 16385, "16385 x 3"},
                 {20, 0, "0 values per voxel"},
                 {20, 70000, "70000 values"},
                 {24, 0x7fc00000, "bounding box"},
                 {16, 3, "header accounts for"},
                 {16, 1, "header accounts for"}};
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        make_header(3, 1);
        set_word(cases[i].at, cases[i].bits);
        put_file("a.vol", bytes, HEADER + VOXELS);
        ty_volume_def def = ty_default_volume_def();
        ty_grid* grid = NULL;
        assert_failed(context, ty_volume_read(context, "a.vol", &def, &grid), TY_ERROR_INPUT, "a.vol", cases[i].words);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(floats_have_components),
        cmocka_unit_test(grids_are_written),
        cmocka_unit_test(bytes_are_fractions),
        cmocka_unit_test(broken_files_are_refused),
    };
    return cmocka_run_group_tests(tests, start, stop);
}
