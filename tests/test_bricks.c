/* Files of bricks: grids there and back, heads and tables that are damaged, files that change, and the bound on what is
 * in memory. */
#define _GNU_SOURCE
#include "fog.h"
#include "strict_fixture.h"

#include "base/context.h"
#include "base/mapping.h"
#include "grid/grid.h"

#include <tyndall/io.h>
#include <tyndall/method.h>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

enum { NX = 21, NY = 18, NZ = 13, HEAD_SPACE = 4096 };

static ty_grid* make_grid(ty_grid_type type) {
    float values[NX * NY * NZ];
    uint16_t halves[NX * NY * NZ];
    for (int i = 0; i < NX * NY * NZ; ++i) {
        values[i] = i % NX < 8 ? 0.25f : (float)(i % 37) / 32;
        halves[i] = ty_float_to_half(values[i]);
    }
    ty_grid_def def = ty_default_grid_def();
    def.size[0] = NX;
    def.size[1] = NY;
    def.size[2] = NZ;
    def.type = type;
    def.values = type == TY_GRID_F16 ? (const void*)halves : values;
    def.placed = true;
    def.background = -0.5f;
    def.index_to_local.m[3] = 2;
    ty_grid* grid = NULL;
    assert_int_equal(ty_grid_create(context, &def, &grid), TY_OK);
    return grid;
}

static ty_result write_as(const ty_grid* grid, const char* path) {
    const ty_volume_field field = {.name = "density", .components = 1, .grids = {grid}};
    return ty_volume_write(context, &field, 1, NULL, path);
}

static ty_result read_from(const char* path, ty_grid** out) {
    const ty_volume_def def = ty_default_volume_def();
    *out = NULL;
    return ty_volume_read(context, path, &def, out);
}

static void grids_come_back(void** state) {
    (void)state;
    for (int kind = 0; kind < 6; ++kind) {
        ty_grid *grid = make_grid(kind % 2 == 0 ? TY_GRID_F32 : TY_GRID_F16), *stored = NULL, *back = NULL;
        assert_int_equal(ty_grid_store(context, grid, (ty_grid_storage)(TY_GRID_DENSE + kind / 2), &stored), TY_OK);
        assert_int_equal(write_as(stored, "a.bricks"), TY_OK);
        assert_int_equal(read_from("a.bricks", &back), TY_OK);
        const ty_grid_info a = ty_grid_get_info(grid), b = ty_grid_get_info(back);
        assert_int_equal(b.storage, TY_GRID_PAGED);
        assert_true(a.type == b.type && b.placed && a.background == b.background && a.active == b.active);
        assert_true(a.min == b.min && a.max == b.max && a.mean == b.mean);
        assert_memory_equal(&a.index_to_local, &b.index_to_local, sizeof a.index_to_local);
        assert_memory_equal(grid->extremes, back->extremes, ty_grid_brick_count(grid) * 2 * sizeof(float));
        for (int i = 0; i < NX * NY * NZ; ++i)
            assert_true(ty_grid_voxel(grid, i % NX, i / NX % NY, i / NX / NY) ==
                        ty_grid_voxel(back, i % NX, i / NX % NY, i / NX / NY));
        ty_grid_release(grid);
        ty_grid_release(stored);
        ty_grid_release(back);
    }
}

/* Files of other formats, also those that are read without the dense array. */
static void other_formats_become_paged(void** state) {
    static const char* const names[] = {"a.vdb", "a.nvdb", "a.nrrd", "a.nii", "a.vol", "a.vti", "a.bricks"};
    (void)state;
    ty_grid* grid = make_grid(TY_GRID_F32);
    for (size_t i = 0; i < sizeof names / sizeof *names; ++i) {
        const char* codec = strcmp(names[i], "a.nrrd") == 0 ? "none" : NULL;
        const ty_volume_field field = {.name = "density", .components = 1, .grids = {grid}};
        ty_volume_def def = ty_default_volume_def();
        ty_grid *dense = NULL, *paged = NULL;
        const ty_result written = ty_volume_write(context, &field, 1, codec, names[i]);
        if (written == TY_ERROR_UNSUPPORTED) { /* a build without the format */
            ty_take_error(context);
            continue;
        }
        assert_int_equal(written, TY_OK);
        def.storage = TY_GRID_DENSE;
        assert_int_equal(ty_volume_read(context, names[i], &def, &dense), TY_OK);
        def.storage = TY_GRID_PAGED;
        assert_int_equal(ty_volume_read(context, names[i], &def, &paged), TY_OK);
        const ty_grid_info a = ty_grid_get_info(dense), b = ty_grid_get_info(paged);
        assert_int_equal(a.storage, TY_GRID_DENSE);
        assert_int_equal(b.storage, TY_GRID_PAGED);
        assert_true(a.background == b.background && a.min == b.min && a.max == b.max && a.active == b.active);
        assert_memory_equal(a.size, b.size, sizeof a.size);
        assert_memory_equal(dense->extremes, paged->extremes, ty_grid_brick_count(dense) * 2 * sizeof(float));
        for (int32_t k = 0; k < a.size[2]; ++k)
            for (int32_t j = 0; j < a.size[1]; ++j)
                for (int32_t x = 0; x < a.size[0]; ++x)
                    assert_true(ty_grid_voxel(dense, x, j, k) == ty_grid_voxel(paged, x, j, k));
        ty_grid_release(dense);
        ty_grid_release(paged);
    }
    ty_grid_release(grid);
}

static uint8_t* get_bytes(const char* path, size_t* size) {
    uint8_t* bytes = NULL;
    assert_int_equal(ty_bytes_read(context, path, (size_t)1 << 24, &bytes, size), TY_OK);
    return bytes;
}

static void assert_refused(const uint8_t* bytes, size_t size, const char* says) {
    ty_grid* grid = NULL;
    put_file("bad.bricks", bytes, size);
    assert_failed(context, read_from("bad.bricks", &grid), TY_ERROR_INPUT, "bad.bricks", says);
    assert_null(grid);
}

/* Every number of the head, and entries of the tables, with other values. */
static void damaged_files_are_refused(void** state) {
    enum { HASH = 224, HEAD = 232, EXTREMES = HEAD_SPACE, TABLE = 2 * HEAD_SPACE };
    /* whether it is placed, sizes and shifts (below), background, range, mean, active voxels, transform */
    static const int free_from[] = {20, 48, 64}, free_to[] = {36, 60, 192};
    (void)state;
    ty_grid *grid = make_grid(TY_GRID_F16), *out = NULL;
    size_t size = 0;
    assert_int_equal(write_as(grid, "good.bricks"), TY_OK);
    ty_grid_release(grid);
    uint8_t* bytes = get_bytes("good.bricks", &size);
    for (int at = 8; at < HASH; at += 4) {
        bool any = false;
        for (int i = 0; i < 3; ++i) any = any || (at >= free_from[i] && at < free_to[i]);
        if (any) continue;
        for (int delta = -1; delta <= 1; delta += 2) {
            bytes[at] = (uint8_t)(bytes[at] + delta);
            assert_refused(bytes, size, "");
            bytes[at] = (uint8_t)(bytes[at] - delta);
        }
    }
    bytes[48] = 8; /* a shift of a whole block */
    assert_refused(bytes, size, "table");
    bytes[48] = 0;
    bytes[24] = 0; /* no voxels */
    assert_refused(bytes, size, "0 x 18 x 13");
    bytes[24] = 64; /* more than the table has */
    assert_refused(bytes, size, "table");
    bytes[24] = NX;
    bytes[67] = 0x7f; /* a background of 3.4e38 is one, and of Inf, with 0x80 before it, none */
    bytes[66] = 0x80;
    assert_refused(bytes, size, "range");
    bytes[67] = 0xbf;
    bytes[66] = 0;
    memset(bytes + 96, 0, 24);
    assert_refused(bytes, size, "transform");
    ty_bytes_destroy(context, bytes, size);
    bytes = get_bytes("good.bricks", &size);
    bytes[TABLE + 4] = 200;
    assert_refused(bytes, size, "table");
    bytes[TABLE + 4] = 0;
    bytes[EXTREMES + 3] = 0x7f;
    bytes[EXTREMES + 2] = 0xc0;
    assert_refused(bytes, size, "table");
    ty_bytes_destroy(context, bytes, size);
    bytes = get_bytes("good.bricks", &size);
    for (size_t length = size - 1; length > HEAD; length /= 3) assert_refused(bytes, length, "");
    put_file("longer.bricks", bytes, size);
    assert_int_equal(truncate("longer.bricks", (off_t)size + 1), 0);
    assert_failed(context, read_from("longer.bricks", &out), TY_ERROR_INPUT, "longer.bricks", "accounts for");
    put_file("empty.bricks", bytes, 0);
    assert_failed(context, read_from("empty.bricks", &out), TY_ERROR_INPUT, "empty.bricks", "empty");
    ty_bytes_destroy(context, bytes, size);
}

static bool change_file(void* user, const ty_progress* progress) {
    const struct timespec times[2] = {{.tv_sec = 1000}, {.tv_sec = 1000}};
    (void)user;
    (void)progress;
    return utimensat(AT_FDCWD, "changes.bricks", times, 0) == 0;
}

static void a_file_that_changes_is_noticed(void** state) {
    static const double lower[3] = {-1, -1, -1}, upper[3] = {1, 1, 1};
    (void)state;
    for (int changes = 0; changes < 2; ++changes) {
        ty_grid *grid = make_grid(TY_GRID_F16), *back = NULL;
        assert_int_equal(write_as(grid, "changes.bricks"), TY_OK);
        assert_int_equal(read_from("changes.bricks", &back), TY_OK);
        ty_medium_def smoke = box_medium(lower, upper, 4, 0.4f);
        smoke.density_grid = back;
        ty_light_def sky = ty_default_light_def();
        sky.kind = TY_LIGHT_ENVIRONMENT;
        set3f(sky.color, 1, 1, 1);
        ty_camera_def camera = ty_default_camera_def();
        set3(camera.position, 0.4, 0.6, 4);
        ty_scene* scene = make_scene(context);
        assert_int_equal(ty_scene_add_medium(scene, &smoke), TY_OK);
        assert_int_equal(ty_scene_add_light(scene, &sky), TY_OK);
        assert_int_equal(ty_scene_set_camera(scene, &camera), TY_OK);
        assert_int_equal(ty_scene_commit(scene), TY_OK);
        ty_render_settings settings = ty_scene_render_settings(scene);
        snprintf(settings.method, sizeof settings.method, "path");
        settings.spp = 2;
        ty_render_def def = ty_default_render_def();
        def.settings = &settings;
        def.width = def.height = 16;
        def.progress = changes != 0 ? change_file : NULL;
        ty_image* image = NULL;
        if (changes == 0)
            assert_int_equal(ty_render(scene, &def, &image), TY_OK);
        else
            assert_failed(context, ty_render(scene, &def, &image), TY_ERROR_INPUT, "changes.bricks", "was changed");
        assert_true((image == NULL) == (changes != 0));
        ty_image_destroy(image);
        ty_scene_destroy(scene);
        ty_grid_release(grid);
        ty_grid_release(back);
    }
}

/* ---- the bound ---- */

enum { TASKS = 64, TASK_BYTES = 1 << 20 };

static void write_part(void* user, int64_t index, int32_t worker) {
    ty_mapping* mapping = user;
    (void)worker;
    memset(mapping->bytes + TASK_BYTES * index, 1 + (int)index, TASK_BYTES);
    usleep(2500); /* longer than from one look to the next */
}

static size_t bytes_of_files(void) {
    unsigned long long all, resident, shared;
    FILE* file = fopen("/proc/self/statm", "r");
    assert_non_null(file);
    assert_int_equal(fscanf(file, "%llu %llu %llu", &all, &resident, &shared), 3);
    fclose(file);
    return (size_t)shared * (size_t)sysconf(_SC_PAGESIZE);
}

/* 64 MiB, of which 8 may be in memory: after the loop are at most these and a body's 1 MiB for each of two threads, and
 * another 4 MiB by which the system's count may be wrong. Without a bound all are. */
static void a_bound_is_kept(void** state) {
    (void)state;
    for (int bounded = 0; bounded < 2; ++bounded) {
        ty_context_def def = ty_default_context_def();
        def.threads = 2;
        def.resident_bytes = bounded != 0 ? (int64_t)8 << 20 : 0;
        ty_context* own = NULL;
        ty_mapping* mapping = NULL;
        assert_int_equal(ty_context_create(&def, &own), TY_OK);
        const size_t before = bytes_of_files();
        assert_int_equal(ty_mapping_create(own, (size_t)TASKS * TASK_BYTES, &mapping), TY_OK);
        ty_parallel_for(own, TASKS, write_part, mapping);
        const size_t taken = bytes_of_files() - before;
        if (bounded != 0)
            assert_true(taken < (size_t)14 << 20);
        else
            assert_true(taken > (size_t)56 << 20);
        for (int64_t i = 0; i < (int64_t)TASKS * TASK_BYTES; i += 4096)
            assert_int_equal(mapping->bytes[i], 1 + i / TASK_BYTES);
        ty_mapping_close(mapping);
        ty_context_destroy(own);
    }
    ty_context_def def = ty_default_context_def();
    ty_context* none = NULL;
    def.resident_bytes = -1;
    assert_int_equal(ty_context_create(&def, &none), TY_ERROR_ARGUMENT);
    assert_non_null(strstr(ty_take_error(NULL), "resident_bytes"));
}

static void a_full_folder_is_an_error(void** state) {
    (void)state;
    ty_grid *grid = make_grid(TY_GRID_F32), *paged = NULL;
    assert_int_equal(setenv("TMPDIR", "no/folder", 1), 0);
    assert_failed(context, ty_grid_store(context, grid, TY_GRID_PAGED, &paged), TY_ERROR_FILE, "no/folder", "cannot");
    assert_int_equal(unsetenv("TMPDIR"), 0);
    ty_grid_release(grid);
}

/* Arrays of cells: in a file where there is a limit and they are large, else in memory, and freed either way. */
static void large_arrays_are_files_where_memory_is_bounded(void** state) {
    enum { COUNT = 1 << 21 };
    (void)state;
    for (int bounded = 0; bounded < 2; ++bounded) {
        ty_context_def def = ty_default_context_def();
        ty_context* own = NULL;
        def.resident_bytes = bounded ? 1000000 : 0;
        assert_int_equal(ty_context_create(&def, &own), TY_OK);
        const ty_mapping_ring* ring = ty_context_mappings(own);
        float* large = ty_alloc_large(own, COUNT, sizeof *large, true);
        float* small = ty_alloc_large(own, 100, sizeof *small, true);
        assert_non_null(large);
        assert_non_null(small);
        assert_int_equal(atomic_load(&ring->count), bounded);
        for (int i = 0; i < COUNT; ++i) {
            assert_true(large[i] == 0);
            large[i] = (float)i;
        }
        ty_mappings_trim(own);
        for (int i = 0; i < COUNT; ++i) assert_true(large[i] == (float)i);
        ty_free_large(own, small, 100, sizeof *small);
        ty_free_large(own, large, COUNT, sizeof *large);
        ty_free_large(own, NULL, COUNT, sizeof *large);
        assert_int_equal(atomic_load(&ring->count), 0);
        ty_context_destroy(own);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(grids_come_back, start, stop),
        cmocka_unit_test_setup_teardown(other_formats_become_paged, start, stop),
        cmocka_unit_test_setup_teardown(damaged_files_are_refused, start, stop),
        cmocka_unit_test_setup_teardown(a_file_that_changes_is_noticed, start, stop),
        cmocka_unit_test_setup_teardown(a_bound_is_kept, start, stop),
        cmocka_unit_test_setup_teardown(a_full_folder_is_an_error, start, stop),
        cmocka_unit_test_setup_teardown(large_arrays_are_files_where_memory_is_bounded, start, stop),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
