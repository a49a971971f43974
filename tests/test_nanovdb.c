/* NanoVDB files: round trips, files that NanoVDB's own converter made of every type, broken ones. */
#include "strict_fixture.h"

#include "small_volume.h"

#define CORPUS TYNDALL_SOURCE_DIR "/tests/fuzz/corpus/nvdb/"

static ty_grid* read_grid(const char* path, const char* name, int32_t component) {
    ty_volume_def def = ty_default_volume_def();
    def.grid = name;
    def.component = component;
    ty_grid* grid = NULL;
    if (ty_volume_read(context, path, &def, &grid) != TY_OK) fail_msg("%s", ty_take_error(context));
    return grid;
}

/* The small volume again, as a grid of ours. */
static ty_grid* make_small(ty_grid_type type) {
    static float values[29 * 11 * 12];
    static uint16_t ones[29 * 11 * 12];
    size_t at = 0;
    for (int z = 0; z < 12; ++z)
        for (int y = 0; y < 11; ++y)
            for (int x = 0; x < 29; ++x, ++at) {
                values[at] = small_density(x - 5, y - 3, z - 3);
                ones[at] = 0x3c00;
            }
    ty_grid_def def = ty_default_grid_def();
    def.size[0] = 29;
    def.size[1] = 11;
    def.size[2] = 12;
    def.type = type;
    def.values = type == TY_GRID_F32 ? (const void*)values : ones;
    def.background = 0.25f;
    def.placed = true;
    def.index_to_local = (ty_affine){{2, 0.5, 0, -1.5, 0, 3, 0, 11, 0, 0, 4, 18}};
    ty_grid* grid = NULL;
    assert_int_equal(ty_grid_create(context, &def, &grid), TY_OK);
    return grid;
}

static void round_trips_are_exact(void** state) {
    (void)state;
    static const char* const codecs[] = {"none", "zip"};
    for (int codec = 0; codec < 2; ++codec) {
        ty_grid* grid = make_small(TY_GRID_F32);
        assert_int_equal(ty_nanovdb_write(context, grid, "smoke", codecs[codec], "trip.nvdb"), TY_OK);
        ty_grid_release(grid);
        grid = read_grid("trip.nvdb", "smoke", 0);
        const ty_grid_info info = ty_grid_get_info(grid);
        assert_true(info.size[0] == 29 && info.size[1] == 11 && info.size[2] == 12);
        assert_int_equal(info.type, TY_GRID_F32);
        assert_true(info.background == 0.25f);
        assert_small_values(grid, 1, 0);
        assert_small_place(grid);
        ty_grid_release(grid);
    }
    assert_int_equal(remove_temporary_files(), 0);
}

static void half_and_empty_grids_are_written_as_float(void** state) {
    (void)state;
    ty_grid* grid = make_small(TY_GRID_F16);
    assert_int_equal(ty_nanovdb_write(context, grid, "ones", "none", "ones.nvdb"), TY_OK);
    ty_grid_release(grid);
    grid = read_grid("ones.nvdb", "ones", 0);
    assert_true(ty_grid_get_info(grid).min == 1 && ty_grid_get_info(grid).max == 1);
    ty_grid_release(grid);
    ty_grid_def def = ty_default_grid_def();
    for (int a = 0; a < 3; ++a) def.size[a] = 3;
    assert_int_equal(ty_grid_create(context, &def, &grid), TY_OK);
    assert_int_equal(ty_nanovdb_write(context, grid, "empty", "zip", "empty.nvdb"), TY_OK);
    ty_grid_release(grid);
    grid = read_grid("empty.nvdb", "empty", 0);
    assert_true(ty_grid_get_info(grid).size[0] == 1 && ty_grid_voxel(grid, 0, 0, 0) == 0);
    ty_grid_release(grid);
}

static void every_type_is_read(void** state) {
    (void)state;
    static const struct {
        const char *path, *grid;
        int32_t component;
        float scale, background;
        double tolerance; /* half a step of the quantization, which spans 0 to 1 */
    } cases[] = {
        {CORPUS "all.nvdb", "density", 0, 1, 0.25f, 0},    {CORPUS "all.nvdb", "velocity", 0, 1, 1, 0},
        {CORPUS "all.nvdb", "velocity", 1, -1, 2, 0},      {CORPUS "all.nvdb", "velocity", 2, 2, 3, 0},
        {CORPUS "all.nvdb", "wide", 0, 1, 0, 0},           {CORPUS "fp4.nvdb", "density", 0, 1, 0.25f, 0.034},
        {CORPUS "fp8.nvdb", "density", 0, 1, 0.25f, 2e-3}, {CORPUS "fp16.nvdb", "density", 0, 1, 0.25f, 1e-5},
        {CORPUS "fpn.nvdb", "density", 0, 1, 0.25f, 1e-2},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        ty_grid* grid = read_grid(cases[i].path, cases[i].grid, cases[i].component);
        const ty_grid_info info = ty_grid_get_info(grid);
        assert_int_equal(info.size[0], strcmp(cases[i].grid, "density") == 0 ? 29 : 16);
        assert_true(info.background == cases[i].background);
        assert_small_values(grid, cases[i].scale, cases[i].tolerance);
        assert_small_place(grid);
        ty_grid_release(grid);
    }
}

static void grids_are_listed(void** state) {
    (void)state;
    ty_vdb_entry entries[4];
    int32_t count = 0;
    assert_int_equal(ty_vdb_list(context, CORPUS "all.nvdb", entries, 4, &count), TY_OK);
    assert_int_equal(count, 3);
    assert_string_equal(entries[1].name, "velocity");
    assert_string_equal(entries[1].type, "vec3f");
    assert_int_equal(entries[0].active_voxels, 2048);
    assert_true(entries[0].lower[0] == -5 && entries[0].upper[0] == 23 && entries[0].upper[2] == 8);
    assert_true(entries[0].voxel_size[2] == 4);
}

static void assert_refused(const char* path, const char* name, int32_t component, const char* matter) {
    ty_volume_def def = ty_default_volume_def();
    def.grid = name;
    def.component = component;
    ty_grid* grid = NULL;
    assert_failed(context, ty_volume_read(context, path, &def, &grid), TY_ERROR_INPUT, path, matter);
    assert_null(grid);
}

/* The bytes of a plain file, changed at one place. */
static void assert_change_refused(size_t at, const void* bytes, size_t size, const char* matter) {
    size_t length;
    uint8_t* content = get_file("trip.nvdb", &length);
    memcpy(content + at, bytes, size);
    put_file("changed.nvdb", content, length);
    free(content);
    assert_refused("changed.nvdb", "smoke", 0, matter);
}

static void broken_files_are_refused(void** state) {
    (void)state;
    enum { HEAD = 16, GRID = HEAD + 176 + sizeof "smoke", TREE = GRID + 672, ROOT = TREE + 64 };
    assert_refused(CORPUS "all.nvdb", "smoke", 0, "no grid \"smoke\"; there are density, velocity, wide");
    assert_refused(CORPUS "all.nvdb", "velocity", 3, "component 3");
    assert_refused(CORPUS "all.nvdb", "wide", 1, "1 value per voxel");
    put_file("text.nvdb", "no volume at all", 16);
    assert_refused("text.nvdb", "smoke", 0, "not a NanoVDB file");
    ty_grid* grid = make_small(TY_GRID_F32);
    assert_int_equal(ty_nanovdb_write(context, grid, "smoke", "none", "trip.nvdb"), TY_OK);
    ty_grid_release(grid);
    const uint32_t version = 31u << 21, odd_type = 19, many = 0x7fffffff;
    const uint16_t blosc = 2, codec = 9;
    const uint64_t huge = (uint64_t)1 << 60;
    static const double flat[9];
    assert_change_refused(8, &version, sizeof version, "NanoVDB version 31");
    assert_change_refused(14, &blosc, sizeof blosc, "blosc");
    assert_change_refused(14, &codec, sizeof codec, "codec");
    assert_change_refused(HEAD, &huge, sizeof huge, "damaged");
    assert_change_refused(HEAD + 8, &huge, sizeof huge, "damaged");
    assert_change_refused(HEAD + 32, &odd_type, sizeof odd_type, "type index");
    assert_change_refused(HEAD + 136, &many, sizeof many, "damaged");
    assert_change_refused(GRID + 636, &odd_type, sizeof odd_type, "damaged");
    assert_change_refused(GRID + 296 + 88, flat, sizeof flat, "cannot be inverted");
    assert_change_refused(TREE + 24, &huge, sizeof huge, "damaged");
    assert_change_refused(ROOT + 24, &many, sizeof many, "damaged");
    assert_change_refused(ROOT + 64 + 8, &huge, sizeof huge, "damaged");
}

static void cut_files_are_refused(void** state) {
    (void)state;
    ty_grid* grid = make_small(TY_GRID_F32);
    for (int zip = 0; zip < 2; ++zip) {
        assert_int_equal(ty_nanovdb_write(context, grid, "smoke", zip ? "zip" : "none", "whole.nvdb"), TY_OK);
        size_t size;
        uint8_t* bytes = get_file("whole.nvdb", &size);
        for (size_t length = 0; length < size; length += length < 300 ? 7 : size / 40) {
            put_file("cut.nvdb", bytes, length);
            assert_refused("cut.nvdb", "smoke", 0, NULL);
        }
        free(bytes);
    }
    ty_grid_release(grid);
}

static void wrong_writes_are_refused(void** state) {
    (void)state;
    static const char old[] = "the old content";
    ty_grid* grid = make_small(TY_GRID_F32);
    put_file("old.nvdb", old, sizeof old);
    assert_int_equal(ty_nanovdb_write(context, grid, "smoke", "blosc", "old.nvdb"), TY_ERROR_ARGUMENT);
    assert_int_equal(ty_nanovdb_write(context, grid, "", "zip", "old.nvdb"), TY_ERROR_ARGUMENT);
    ty_take_error(context);
    little_space(2000);
    const ty_result result = ty_nanovdb_write(context, grid, "smoke", "none", "old.nvdb");
    all_space();
    assert_failed(context, result, TY_ERROR_FILE, "old.nvdb", NULL);
    assert_file_holds("old.nvdb", old, sizeof old);
    assert_int_equal(remove_temporary_files(), 0);
    ty_grid_release(grid);
}

static ty_result read_and_release(ty_context* strict, void* user) {
    const ty_volume_def def = ty_default_volume_def();
    ty_grid* grid = NULL;
    (void)user;
    const ty_result result = ty_volume_read(strict, CORPUS "all.nvdb", &def, &grid);
    ty_grid_release(grid);
    return result;
}

static void short_memory_is_survived(void** state) {
    (void)state;
    assert_true(check_short_memory(context, &memory, read_and_release, NULL) > 2);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(round_trips_are_exact),    cmocka_unit_test(half_and_empty_grids_are_written_as_float),
        cmocka_unit_test(every_type_is_read),       cmocka_unit_test(grids_are_listed),
        cmocka_unit_test(broken_files_are_refused), cmocka_unit_test(cut_files_are_refused),
        cmocka_unit_test(wrong_writes_are_refused), cmocka_unit_test(short_memory_is_survived),
    };
    return cmocka_run_group_tests(tests, start, stop);
}
