/* Parts of volume files: the voxels of the whole, in memory that does not hold it. */
#include "netcdf_maker.h"
#include "strict_fixture.h"

#include "grid/grid.h"

#include <tyndall/io.h>

#include <string.h>

typedef struct kind {
    const char *path, *codec;
    bool streamed; /* its parts are read without the whole */
} kind;

static const kind kinds[] = {
    {"a.vdb", "zip", true},     {"b.vdb", "blosc", true}, {"c.vdb", "none", true},  {"a.nvdb", "none", true},
    {"b.nvdb", "zip", true},    {"a.nrrd", "none", true}, {"b.nrrd", "gzip", true}, {"a.nii", "none", true},
    {"a.nii.gz", "gzip", true}, {"a.vol", "none", true},  {"a.bricks", NULL, true}, {"a.vti", "none", false},
    {"a.raw", NULL, true},
};
enum { KINDS = sizeof kinds / sizeof *kinds };

/* Values with runs of one value, and of another at an edge. */
static ty_grid* make_grid(const int32_t size[3]) {
    const size_t voxels = (size_t)size[0] * (size_t)size[1] * (size_t)size[2];
    float* values = malloc(voxels * sizeof *values);
    assert_non_null(values);
    for (size_t i = 0; i < voxels; ++i) {
        const size_t x = i % (size_t)size[0];
        const uint32_t mixed = (uint32_t)i * 2654435761u;
        values[i] = x < 9 && x > 0 ? 0 : x == (size_t)size[0] - 1 ? 0.25f : 1 + (float)(mixed >> 8) / 65536;
    }
    ty_grid_def def = ty_default_grid_def();
    memcpy(def.size, size, sizeof def.size);
    def.values = values;
    def.placed = true;
    def.index_to_local.m[0] = 2;
    ty_grid* grid = NULL;
    assert_int_equal(ty_grid_create(context, &def, &grid), TY_OK);
    free(values);
    return grid;
}

static void write_raw(const ty_grid* grid, const char* path) {
    const ty_grid_info info = ty_grid_get_info(grid);
    put_file(path, ty_grid_values(grid),
             (size_t)info.size[0] * (size_t)info.size[1] * (size_t)info.size[2] * sizeof(float));
}

/* False in a build without the format. */
static bool write_kind(const ty_grid* grid, const kind* k, ty_volume_def* def) {
    const ty_grid_info info = ty_grid_get_info(grid);
    const ty_volume_field field = {.name = "density", .components = 1, .grids = {grid}};
    *def = ty_default_volume_def();
    memcpy(def->raw_size, info.size, sizeof def->raw_size);
    memcpy(def->raw_type, "float", sizeof "float");
    for (int a = 0; a < 3; ++a) def->raw_spacing[a] = info.index_to_local.m[5 * a];
    if (strcmp(k->path, "a.raw") == 0) {
        write_raw(grid, k->path);
        return true;
    }
    const ty_result result = ty_volume_write(context, &field, 1, k->codec, k->path);
    if (result == TY_ERROR_UNSUPPORTED)
        ty_take_error(context);
    else
        assert_int_equal(result, TY_OK);
    return result == TY_OK;
}

static void set_part(ty_volume_def* def, const int32_t part[2][3]) {
    def->in_part = true;
    memcpy(def->part_first, part[0], sizeof def->part_first);
    memcpy(def->part_end, part[1], sizeof def->part_end);
}

static bool is_inside(const int32_t part[2][3], int32_t x, int32_t y, int32_t z) {
    const int32_t at[3] = {x, y, z};
    bool inside = true;
    for (int a = 0; a < 3; ++a) inside = inside && at[a] >= part[0][a] && at[a] < part[1][a];
    return inside;
}

/* Blocks that a part may touch, wherever the first block begins. */
static int64_t most_blocks(const int32_t size[3], const int32_t part[2][3]) {
    int64_t blocks = 1;
    for (int a = 0; a < 3; ++a) {
        const int32_t low = part[0][a] > 0 ? part[0][a] : 0, high = part[1][a] < size[a] ? part[1][a] : size[a];
        blocks *= high > low ? (high - low + TY_GRID_BLOCK - 2) / TY_GRID_BLOCK + 1 : 0;
    }
    return blocks;
}

static void assert_part(const char* path, const ty_grid* whole, const ty_grid* grid, const int32_t part[2][3]) {
    const ty_grid_info a = ty_grid_get_info(whole), b = ty_grid_get_info(grid);
    assert_memory_equal(a.size, b.size, sizeof a.size);
    assert_memory_equal(&a.index_to_local, &b.index_to_local, sizeof a.index_to_local);
    assert_true(a.placed == b.placed && a.type == b.type && a.background == b.background);
    assert_true(b.stored <= (1 + most_blocks(b.size, part)) * TY_GRID_BLOCK_VOXELS);
    for (int32_t z = 0; z < a.size[2]; ++z)
        for (int32_t y = 0; y < a.size[1]; ++y)
            for (int32_t x = 0; x < a.size[0]; ++x)
                if (is_inside(part, x, y, z) && ty_grid_voxel(whole, x, y, z) != ty_grid_voxel(grid, x, y, z))
                    fail_msg("%s: voxel %d %d %d is another one in a part", path, x, y, z);
}

static void check_parts(const char* path, ty_volume_def* def) {
    static const int32_t parts[][2][3] = {{{0, 0, 0}, {41, 35, 29}},    {{16, 8, 8}, {24, 16, 24}},
                                          {{13, 3, 11}, {30, 27, 12}},  {{-4, 20, 25}, {7, 99, 99}},
                                          {{40, 34, 28}, {41, 35, 29}}, {{8, 8, 8}, {8, 16, 16}}};
    ty_grid* whole = NULL;
    assert_int_equal(ty_volume_read(context, path, def, &whole), TY_OK);
    for (size_t p = 0; p < sizeof parts / sizeof *parts; ++p)
        for (int paged = 0; paged < 2; ++paged) {
            ty_grid* grid = NULL;
            ty_volume_def own = *def;
            set_part(&own, parts[p]);
            own.storage = paged ? TY_GRID_PAGED : TY_GRID_AUTO;
            assert_int_equal(ty_volume_read(context, path, &own, &grid), TY_OK);
            assert_int_equal(ty_grid_get_info(grid).storage, paged ? TY_GRID_PAGED : TY_GRID_SPARSE);
            assert_part(path, whole, grid, parts[p]);
            ty_grid_release(grid);
        }
    ty_grid_release(whole);
}

static void parts_are_those_of_the_whole(void** state) {
    static const int32_t size[3] = {41, 35, 29};
    (void)state;
    ty_grid* grid = make_grid(size);
    for (int i = 0; i < KINDS; ++i) {
        ty_volume_def def;
        if (write_kind(grid, &kinds[i], &def)) check_parts(kinds[i].path, &def);
    }
    ty_grid_release(grid);
    ty_volume_def def = ty_default_volume_def(); /* tiles, and an active box that begins at (-5, -3, -3) */
    def.grid = "velocity";
    def.component = 2;
    check_parts(TYNDALL_SOURCE_DIR "/tests/fuzz/corpus/vdb/vectors.vdb", &def);
}

/* A variable of NetCDF with the highest level first; its slices are read, not its rows. */
static void parts_of_netcdf_are_those_of_the_whole(void** state) {
    enum { NX = 20, NY = 17, NZ = 21 };
    static double xs[NX], ys[NY], zs[NZ], values[NX * NY * NZ];
    (void)state;
    for (int i = 0; i < NX; ++i) xs[i] = 2 * i;
    for (int i = 0; i < NY; ++i) ys[i] = i;
    for (int i = 0; i < NZ; ++i) zs[i] = NZ - i;
    for (int i = 0; i < NX * NY * NZ; ++i) values[i] = i % 97;
    const made_file file = {{"x", "y", "z"},
                            {NX, NY, NZ},
                            {{"x", {0}, 1, {{"units", "m"}, {"axis", "X"}}, MADE_DOUBLE, xs},
                             {"y", {1}, 1, {{"units", "m"}, {"axis", "Y"}}, MADE_DOUBLE, ys},
                             {"z", {2}, 1, {{"units", "m"}, {"standard_name", "altitude"}}, MADE_DOUBLE, zs},
                             {"q", {2, 1, 0}, 3, {{NULL}}, MADE_FLOAT, values}}};
    ty_volume_def def = ty_default_volume_def();
    ty_grid* grid = NULL;
    make_netcdf("part.nc", &file);
    if (ty_volume_read(context, "part.nc", &def, &grid) != TY_OK) { /* a build or a machine without the library */
        assert_non_null(strstr(ty_take_error(context), "libnetcdf"));
        skip();
    }
    ty_grid_release(grid);
    check_parts("part.nc", &def);
}

/* Memory at once: the part's blocks, the tables of all, and some slices; the whole does not fit. */
static void parts_take_the_memory_of_parts(void** state) {
    enum { X = 96, Y = 128, Z = 128, MEMORY = 2200000 };
    static const int32_t size[3] = {X, Y, Z}, part[2][3] = {{0, 64, 32}, {X, 128, 64}};
    (void)state;
    ty_grid* grid = make_grid(size);
    ty_volume_def defs[KINDS];
    bool written[KINDS];
    for (int i = 0; i < KINDS; ++i) written[i] = kinds[i].streamed && write_kind(grid, &kinds[i], &defs[i]);
    for (int i = 0; i < KINDS; ++i) {
        ty_grid *whole = NULL, *read = NULL;
        if (!written[i]) continue;
        memory.limit = memory.used + MEMORY;
        if (strcmp(kinds[i].path, "a.bricks") != 0) { /* which stay in their file */
            assert_int_equal(ty_volume_read(context, kinds[i].path, &defs[i], &whole), TY_ERROR_MEMORY);
            ty_take_error(context);
        }
        set_part(&defs[i], part);
        const ty_result result = ty_volume_read(context, kinds[i].path, &defs[i], &read);
        if (result != TY_OK) fail_msg("%s: %s", kinds[i].path, ty_take_error(context));
        memory.limit = (size_t)1 << 30;
        assert_part(kinds[i].path, grid, read, part);
        ty_grid_release(read);
    }
    ty_grid_release(grid);
}

static void parts_that_cannot_be_are_refused(void** state) {
    static const int32_t size[3] = {9, 9, 9}, part[2][3] = {{0, 0, 0}, {8, 8, 8}};
    ty_volume_def def;
    ty_grid *grid = make_grid(size), *out = NULL;
    (void)state;
    assert_true(write_kind(grid, &kinds[5], &def));
    ty_grid_release(grid);
    set_part(&def, part);
    def.storage = TY_GRID_DENSE;
    assert_failed(context, ty_volume_read(context, kinds[5].path, &def, &out), TY_ERROR_ARGUMENT, "part", "dense");
    assert_null(out);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(parts_are_those_of_the_whole, start, stop),
        cmocka_unit_test_setup_teardown(parts_of_netcdf_are_those_of_the_whole, start, stop),
        cmocka_unit_test_setup_teardown(parts_take_the_memory_of_parts, start, stop),
        cmocka_unit_test_setup_teardown(parts_that_cannot_be_are_refused, start, stop),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
