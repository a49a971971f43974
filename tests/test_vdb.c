/* OpenVDB files: round trips, files of other makes built byte by byte, broken ones, and real ones. */
#define _GNU_SOURCE
#include "small_volume.h"
#include "strict_fixture.h"
#include "vdb_maker.h"

#include <tyndall/io.h>

#include <fcntl.h>
#include <math.h>
#include <unistd.h>
#include <zlib.h>

enum { NX = 21, NY = 13, NZ = 30 };

static size_t at(int x, int y, int z) {
    return (size_t)x + NX * ((size_t)y + NY * (size_t)z);
}

/* Background all round, a constant block of 8^3 that is stored as a tile, varied values elsewhere: exact in half. */
static void fill_values(float* values, float background) {
    for (int z = 0; z < NZ; ++z)
        for (int y = 0; y < NY; ++y)
            for (int x = 0; x < NX; ++x) {
                float value = background;
                if (x >= 8 && x < 16 && y < 8 && z >= 8 && z < 16)
                    value = 3.5f;
                else if ((x * 5 + y * 3 + z) % 4 != 0)
                    value = (float)((x * 31 + y * 17 + z * 7) % 512) / 8 - 20;
                values[at(x, y, z)] = value;
            }
}

static uint16_t half_bits(float value) {
    int exponent = 0;
    const float mantissa = frexpf(fabsf(value), &exponent);
    const uint16_t bits = (uint16_t)((exponent + 14) << 10 | ((int)ldexpf(mantissa, 11) & 1023));
    return value == 0 ? 0 : (uint16_t)(bits | (value < 0 ? 0x8000 : 0));
}

/* A grid of NX x NY x NZ; the corner voxels are set so that the active box is all of it. */
static ty_grid* make_grid(ty_grid_type type, float background, const ty_affine* map, float values[NX * NY * NZ]) {
    static uint16_t halves[NX * NY * NZ];
    fill_values(values, background);
    values[at(0, 0, 0)] = 1;
    values[at(NX - 1, NY - 1, NZ - 1)] = 2;
    for (size_t i = 0; i < NX * NY * NZ; ++i) halves[i] = half_bits(values[i]);
    ty_grid_def def = ty_default_grid_def();
    def.size[0] = NX;
    def.size[1] = NY;
    def.size[2] = NZ;
    def.type = type;
    def.values = type == TY_GRID_F16 ? (const void*)halves : values;
    def.index_to_local = *map;
    def.background = background;
    def.placed = true;
    ty_grid* grid = NULL;
    assert_int_equal(ty_grid_create(context, &def, &grid), TY_OK);
    return grid;
}

static void assert_values(const ty_grid* grid, const float* values) {
    for (int z = 0; z < NZ; ++z)
        for (int y = 0; y < NY; ++y)
            for (int x = 0; x < NX; ++x)
                if (ty_grid_voxel(grid, x, y, z) != values[at(x, y, z)])
                    fail_msg("voxel %d %d %d is %g, not %g", x, y, z, ty_grid_voxel(grid, x, y, z),
                             values[at(x, y, z)]);
}

static void assert_near(const double* a, const double* b, size_t count) {
    for (size_t i = 0; i < count; ++i)
        if (!(fabs(a[i] - b[i]) <= 1e-12 * (1 + fabs(b[i])))) fail_msg("number %zu: %.17g, not %.17g", i, a[i], b[i]);
}

static ty_affine turned(void) {
    static const double translate[3] = {-10, 20, 0.5}, rotate[3] = {30, -40, 110}, scale[3] = {0.1, 0.25, 3};
    ty_affine map = ty_affine_compose(translate, rotate, scale);
    map.m[1] += 0.05; /* and sheared */
    return map;
}

static void round_trips_are_exact(void** state) {
    (void)state;
    static const char* const codecs[] = {"none", "zip", "blosc"};
    static float values[NX * NY * NZ];
    const ty_affine maps[] = {ty_affine_identity(), turned()};
    for (int codec = 0; codec < 3; ++codec)
        for (int type = 0; type < 2; ++type)
            for (int m = 0; m < 2; ++m) {
                const float background = m == 0 ? 0 : -1.25f;
                ty_grid* grid = make_grid(type == 0 ? TY_GRID_F32 : TY_GRID_F16, background, &maps[m], values);
                ty_grid* back = NULL;
                assert_int_equal(ty_vdb_write(context, grid, "density", codecs[codec], "trip.vdb"), TY_OK);
                assert_int_equal(ty_vdb_read(context, "trip.vdb", "density", &back), TY_OK);
                const ty_grid_info info = ty_grid_get_info(back);
                assert_int_equal(info.size[0], NX);
                assert_int_equal(info.size[1], NY);
                assert_int_equal(info.size[2], NZ);
                assert_int_equal(info.type, type == 0 ? TY_GRID_F32 : TY_GRID_F16);
                assert_true(info.placed);
                assert_true(info.background == background);
                assert_near(info.index_to_local.m, maps[m].m, 12);
                assert_values(back, values);
                ty_grid_release(grid);
                ty_grid_release(back);
            }
    assert_int_equal(remove_temporary_files(), 0);
}

static void surrounding_background_is_cut_off(void** state) {
    (void)state;
    static float values[NX * NY * NZ];
    const ty_affine map = turned();
    fill_values(values, 0);
    memset(values, 0, sizeof values);
    values[at(5, 6, 7)] = 1;
    values[at(9, 6, 20)] = 2;
    ty_grid_def def = ty_default_grid_def();
    def.size[0] = NX;
    def.size[1] = NY;
    def.size[2] = NZ;
    def.values = values;
    def.index_to_local = map;
    ty_grid *grid = NULL, *back = NULL;
    assert_int_equal(ty_grid_create(context, &def, &grid), TY_OK);
    assert_int_equal(ty_vdb_write(context, grid, "density", "zip", "cut.vdb"), TY_OK);
    assert_int_equal(ty_vdb_read(context, "cut.vdb", "density", &back), TY_OK);
    const ty_grid_info info = ty_grid_get_info(back);
    assert_int_equal(info.size[0], 5);
    assert_int_equal(info.size[1], 1);
    assert_int_equal(info.size[2], 14);
    assert_true(ty_grid_voxel(back, 0, 0, 0) == 1 && ty_grid_voxel(back, 4, 0, 13) == 2);
    /* The first voxel is still where it was. */
    static const double index[3] = {5, 6, 7}, zero[3] = {0, 0, 0};
    double before[3], after[3];
    ty_affine_point(&map, index, before);
    ty_affine_point(&info.index_to_local, zero, after);
    assert_near(after, before, 3);
    ty_grid_release(back);

    ty_vdb_entry entry;
    int32_t count = 0;
    assert_int_equal(ty_vdb_list(context, "cut.vdb", &entry, 1, &count), TY_OK);
    assert_int_equal(count, 1);
    assert_string_equal(entry.name, "density");
    assert_string_equal(entry.type, "float");
    assert_int_equal(entry.active_voxels, 2);
    assert_int_equal(entry.lower[0], 5);
    assert_int_equal(entry.upper[0], 9);
    assert_int_equal(entry.upper[2], 20);
    for (int a = 0; a < 3; ++a) {
        const double* m = map.m;
        const double size = sqrt(m[a] * m[a] + m[4 + a] * m[4 + a] + m[8 + a] * m[8 + a]);
        assert_near(&entry.voxel_size[a], &size, 1);
    }
    ty_grid_release(grid);
}

static void empty_grid_is_one_voxel_of_background(void** state) {
    (void)state;
    ty_grid_def def = ty_default_grid_def();
    for (int a = 0; a < 3; ++a) def.size[a] = 4;
    def.background = 0;
    ty_grid *grid = NULL, *back = NULL;
    assert_int_equal(ty_grid_create(context, &def, &grid), TY_OK);
    assert_int_equal(ty_vdb_write(context, grid, "flame", "blosc", "empty.vdb"), TY_OK);
    assert_int_equal(ty_vdb_read(context, "empty.vdb", "flame", &back), TY_OK);
    const ty_grid_info info = ty_grid_get_info(back);
    assert_true(info.size[0] == 1 && info.size[1] == 1 && info.size[2] == 1);
    assert_true(ty_grid_voxel(back, 0, 0, 0) == 0);
    ty_vdb_entry entry;
    int32_t count = 0;
    assert_int_equal(ty_vdb_list(context, "empty.vdb", &entry, 1, &count), TY_OK);
    assert_true(entry.active_voxels == 0 && entry.lower[0] > entry.upper[0]);
    ty_grid_release(grid);
    ty_grid_release(back);
}

static void assert_made_grid(const char* path, const char* name) {
    ty_grid* grid = NULL;
    const ty_result result = ty_vdb_read(context, path, name, &grid);
    if (result != TY_OK) fail_msg("%s", ty_take_error(context));
    const ty_grid_info info = ty_grid_get_info(grid);
    for (int a = 0; a < 3; ++a) assert_int_equal(info.size[a], 8);
    assert_true(info.min == 2.5f && info.max == 2.5f && info.background == 0.25f);
    assert_int_equal(info.type, TY_GRID_F32);
    static const double inside[3] = {3.5, 4, 7}, outside[3] = {-30, 4, 4};
    assert_true(ty_grid_sample(grid, inside) == 2.5f);
    assert_true(ty_grid_sample(grid, outside) == 0.25f);
    ty_grid_release(grid);
}

static void every_affine_map_and_negative_boxes_are_read(void** state) {
    (void)state;
    static const struct {
        const char* map;
        double scale[3], move[3];
    } cases[] = {{"ScaleMap", {2, 3, 4}, {0, 0, 0}},
                 {"UniformScaleMap", {2, 3, 4}, {0, 0, 0}},
                 {"TranslationMap", {1, 1, 1}, {10, 20, 30}},
                 {"ScaleTranslateMap", {2, 3, 4}, {10, 20, 30}},
                 {"UniformScaleTranslateMap", {2, 3, 4}, {10, 20, 30}},
                 {"AffineMap", {2, 3, 4}, {10, 20, 30}}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        made d = plain;
        d.map = cases[i].map;
        make_file("made.vdb", &d, 1);
        assert_made_grid("made.vdb", "density");
        ty_grid* grid = NULL;
        assert_int_equal(ty_vdb_read(context, "made.vdb", "density", &grid), TY_OK);
        const ty_grid_info info = ty_grid_get_info(grid);
        for (int a = 0; a < 3; ++a) {
            const double expected = d.tile[a] * cases[i].scale[a] + cases[i].move[a];
            assert_near(&info.index_to_local.m[4 * a + 3], &expected, 1);
            assert_near(&info.index_to_local.m[5 * a], &cases[i].scale[a], 1);
        }
        ty_grid_release(grid);
    }
}

static void double_grids_become_float(void** state) {
    (void)state;
    made d = plain;
    d.type = "Tree_double_5_4_3";
    d.is_double = true;
    make_file("double.vdb", &d, 1);
    assert_made_grid("double.vdb", "density");
}

static void instances_share_a_tree(void** state) {
    (void)state;
    made grids[3] = {plain, plain, plain};
    grids[1].name = "copy";
    grids[1].parent = "density";
    grids[1].map = "ScaleMap";
    grids[2].name = "orphan";
    grids[2].parent = "nobody";
    make_file("instance.vdb", grids, 3);
    assert_made_grid("instance.vdb", "copy");
    ty_grid* grid = NULL;
    assert_failed(context, ty_vdb_read(context, "instance.vdb", "orphan", &grid), TY_ERROR_INPUT, "instance.vdb",
                  "nobody");
}

static void statistics_come_from_the_file_or_the_tree(void** state) {
    (void)state;
    made grids[4] = {plain, plain, plain, plain};
    grids[0].statistics = true;
    grids[1].name = "density\x1e"
                    "1";
    grids[2].name = "motion";
    grids[2].type = "Tree_vec3d_5_4_3_HalfFloat";
    grids[3].name = "halved";
    grids[3].type = "Tree_float_5_4_3_HalfFloat";
    grids[3].statistics = true;
    make_file("list.vdb", grids, 4);
    ty_vdb_entry entries[4];
    int32_t count = 0;
    assert_int_equal(ty_vdb_list(context, "list.vdb", entries, 2, &count), TY_OK);
    assert_int_equal(count, 4);
    assert_int_equal(ty_vdb_list(context, "list.vdb", entries, 4, &count), TY_OK);
    assert_string_equal(entries[0].name, "density");
    assert_string_equal(entries[1].name, "density[1]");
    for (int i = 0; i < 2; ++i) {
        assert_int_equal(entries[i].active_voxels, 512);
        for (int a = 0; a < 3; ++a) {
            assert_int_equal(entries[i].lower[a], plain.tile[a]);
            assert_int_equal(entries[i].upper[a], plain.tile[a] + 7);
            assert_true(entries[i].voxel_size[a] == a + 2);
        }
    }
    assert_string_equal(entries[2].type, "vec3d");
    assert_int_equal(entries[2].active_voxels, -1);
    assert_string_equal(entries[3].type, "half");
    assert_made_grid("list.vdb", "density[1]");
}

static void grids_that_cannot_be_read_are_explained(void** state) {
    (void)state;
    made grids[3] = {plain, plain, plain};
    grids[1].name = "motion";
    grids[1].type = "Tree_vec3s_5_4_3";
    grids[2].name = "camera";
    grids[2].map = "NonlinearFrustumMap";
    make_file("many.vdb", grids, 3);
    ty_grid* const untouched = (ty_grid*)&memory;
    ty_grid* grid = untouched;
    assert_failed(context, ty_vdb_read(context, "many.vdb", "smoke", &grid), TY_ERROR_INPUT, "many.vdb",
                  "no grid \"smoke\"; there are density, motion, camera");
    assert_failed(context, ty_vdb_read(context, "many.vdb", "motion", &grid), TY_ERROR_INPUT, "many.vdb", "vec3s");
    assert_failed(context, ty_vdb_read(context, "many.vdb", "camera", &grid), TY_ERROR_INPUT, "many.vdb", "frustum");
    assert_failed(context, ty_vdb_read(context, "gone.vdb", "density", &grid), TY_ERROR_FILE, "gone.vdb",
                  "No such file");
    assert_int_equal(ty_vdb_read(context, "many.vdb", NULL, &grid), TY_ERROR_ARGUMENT);
    ty_take_error(context);
    assert_ptr_equal(grid, untouched);
}

/* Where the places of a grid's parts are to be written, and where its head lies. */
typedef struct grid_places {
    size_t offsets;
    int64_t head;
} grid_places;

/* A grid as far as what follows its root's numbers of tiles and children, 0; their places come last. */
static grid_places begin_root(const made* d, int32_t tiles) {
    making.size = 0;
    put_header(&making, 224, 1);
    put_text(&making, "density");
    put_text(&making, "Tree_float_5_4_3");
    put_text(&making, "");
    grid_places at = {.offsets = making.size};
    put_zeros(&making, 24);
    at.head = (int64_t)making.size;
    put_i32(&making, 2);
    put_metadata(&making, d);
    put_map(&making, "ScaleMap");
    put_i32(&making, 1);
    put_value(&making, d, 0);
    put_i32(&making, tiles);
    put_i32(&making, 0);
    return at;
}

static void end_root(const grid_places* at, const char* path) {
    const int64_t places[3] = {at->head, at->head, (int64_t)making.size};
    memcpy(making.bytes + at->offsets, places, sizeof places);
    put_file(path, making.bytes, making.size);
}

/* A single active tile of the root: 4096^3 voxels. */
static void boxes_too_large_are_refused_before_memory_is_taken(void** state) {
    (void)state;
    const made d = plain;
    const grid_places at = begin_root(&d, 1);
    static const int32_t origin[3] = {-4096, 0, 4096};
    put_origin(&making, origin);
    put_value(&making, &d, 1);
    put_u8(&making, 1);
    end_root(&at, "large.vdb");
    ty_grid* grid = NULL;
    assert_failed(context, ty_vdb_read(context, "large.vdb", "density", &grid), TY_ERROR_INPUT, "large.vdb",
                  "4096 x 4096 x 4096");
    ty_vdb_entry entry;
    int32_t count = 0;
    assert_int_equal(ty_vdb_list(context, "large.vdb", &entry, 1, &count), TY_OK);
    assert_true(entry.active_voxels == (int64_t)1 << 36);
}

static ty_result read_bytes(const uint8_t* bytes, size_t size) {
    put_file("torture.vdb", bytes, size);
    ty_grid* grid = NULL;
    const ty_result result = ty_vdb_read(context, "torture.vdb", "density", &grid);
    if (result == TY_OK) {
        ty_grid_release(grid);
    } else {
        assert_null(grid);
        const char* message = ty_take_error(context);
        if (result != TY_ERROR_MEMORY) assert_non_null(strstr(message, "torture.vdb"));
    }
    ty_vdb_entry entries[4];
    int32_t count;
    ty_vdb_list(context, "torture.vdb", entries, 4, &count);
    ty_take_error(context);
    return result;
}

static void broken_files_are_refused(void** state) {
    (void)state;
    static float values[NX * NY * NZ];
    const ty_affine map = ty_affine_identity();
    static const char* const codecs[] = {"none", "zip", "blosc"};
    for (int codec = 0; codec < 3; ++codec) {
        ty_grid* grid = make_grid(codec == 1 ? TY_GRID_F16 : TY_GRID_F32, 0, &map, values);
        assert_int_equal(ty_vdb_write(context, grid, "density", codecs[codec], "whole.vdb"), TY_OK);
        ty_grid_release(grid);
        size_t size;
        uint8_t* bytes = get_file("whole.vdb", &size);
        assert_int_equal(read_bytes(bytes, size), TY_OK);
        for (size_t length = 0; length < size; length += length < 400 ? 1 : 397)
            assert_int_equal(read_bytes(bytes, length), TY_ERROR_INPUT);
        assert_int_equal(read_bytes(bytes, size - 1), TY_ERROR_INPUT);
        for (size_t i = 0; i < size; i += i < 900 ? 1 : 211) {
            const uint8_t kept = bytes[i];
            bytes[i] ^= (uint8_t)(1 << i % 8);
            read_bytes(bytes, size);
            bytes[i] = 0xff;
            read_bytes(bytes, size);
            bytes[i] = kept;
        }
        free(bytes);
    }
    static const char garbage[] = "this is no volume at all, though it is long enough to hold a header of one";
    assert_int_equal(read_bytes((const uint8_t*)garbage, sizeof garbage), TY_ERROR_INPUT);
    making.size = 0;
    put_header(&making, 225, 0);
    assert_int_equal(read_bytes(making.bytes, making.size), TY_ERROR_INPUT);
    making.size = 0;
    put_header(&making, 224, 2000000000);
    assert_int_equal(read_bytes(making.bytes, making.size), TY_ERROR_INPUT);
}

static void failed_writes_leave_the_old_file(void** state) {
    (void)state;
    static float values[NX * NY * NZ];
    static const char old[] = "the old content";
    const ty_affine map = ty_affine_identity();
    ty_grid* grid = make_grid(TY_GRID_F32, 0, &map, values);
    put_file("old.vdb", old, sizeof old);
    little_space(2000);
    const ty_result result = ty_vdb_write(context, grid, "density", "none", "old.vdb");
    all_space();
    assert_failed(context, result, TY_ERROR_FILE, "old.vdb", NULL);
    assert_file_holds("old.vdb", old, sizeof old);
    assert_int_equal(remove_temporary_files(), 0);
    assert_int_equal(ty_vdb_write(context, grid, "density", "lzma", "old.vdb"), TY_ERROR_ARGUMENT);
    assert_int_equal(ty_vdb_write(context, grid, "", "zip", "old.vdb"), TY_ERROR_ARGUMENT);
    ty_take_error(context);
    assert_failed(context, ty_vdb_write(context, grid, "density", "zip", "no/such/folder.vdb"), TY_ERROR_FILE,
                  "no/such/folder.vdb", "No such file");
    assert_int_equal(ty_vdb_write(context, grid, "density", "none", "old.vdb"), TY_OK);
    ty_grid_release(grid);
}

static ty_result read_and_release(ty_context* strict, void* path) {
    ty_grid* grid = NULL;
    const ty_result result = ty_vdb_read(strict, path, "density", &grid);
    ty_grid_release(grid);
    return result;
}

static void short_memory_is_survived(void** state) {
    (void)state;
    static char path[] = "memory.vdb";
    make_file(path, &plain, 1);
    assert_true(check_short_memory(context, &memory, read_and_release, path) > 2);
}

/* The voxels of a gzip NRRD of floats: a plain header up to an empty line, then gzip data. */
static float* read_nrrd(const char* path, size_t voxels) {
    gzFile header = gzopen(path, "rb");
    assert_non_null(header);
    char line[256];
    while (gzgets(header, line, sizeof line) != NULL && line[0] != '\n') continue;
    const z_off_t offset = gztell(header);
    gzclose(header);
    const int descriptor = open(path, O_RDONLY);
    assert_int_equal(lseek(descriptor, offset, SEEK_SET), offset);
    gzFile packed = gzdopen(descriptor, "rb");
    assert_non_null(packed);
    float* values = malloc(voxels * sizeof *values);
    assert_non_null(values);
    assert_int_equal(gzread(packed, values, (unsigned)(voxels * sizeof *values)), voxels * sizeof *values);
    gzclose(packed);
    return values;
}

static void vectors_are_read_by_component(void** state) {
    (void)state;
    static const char path[] = TYNDALL_SOURCE_DIR "/tests/fuzz/corpus/vdb/vectors.vdb";
    static const float scales[3] = {1, -1, 2}; /* of the vectors' components */
    ty_volume_def def = ty_default_volume_def();
    def.grid = "velocity";
    int32_t components = 0;
    assert_int_equal(ty_volume_components(context, path, &def, &components), TY_OK);
    assert_int_equal(components, 3);
    for (def.component = 0; def.component < 3; ++def.component) {
        ty_grid* grid = NULL;
        assert_int_equal(ty_volume_read(context, path, &def, &grid), TY_OK);
        const ty_grid_info info = ty_grid_get_info(grid);
        assert_true(info.size[0] == 16 && info.size[1] == 8 && info.size[2] == 12);
        assert_true(info.background == (float)(def.component + 1));
        assert_small_values(grid, scales[def.component], 0);
        assert_small_place(grid);
        ty_grid_release(grid);
    }
    ty_grid* grid = NULL;
    assert_failed(context, ty_volume_read(context, path, &def, &grid), TY_ERROR_INPUT, path, "component 3");
    def.grid = "density";
    assert_failed(context, ty_volume_read(context, path, &def, &grid), TY_ERROR_INPUT, path, "1 value per voxel");
    def.component = 0;
    assert_int_equal(ty_volume_read(context, path, &def, &grid), TY_OK);
    assert_small_values(grid, 1, 0);
    ty_grid_release(grid);
}

/* Two children of the root for one place would be written over one another. */
static void a_place_given_twice_is_refused(void** state) {
    (void)state;
    const made d = plain;
    const grid_places at = begin_root(&d, 2);
    static const int32_t origin[3] = {0, 0, 0};
    for (int i = 0; i < 2; ++i) {
        put_origin(&making, origin);
        put_value(&making, &d, 1);
        put_u8(&making, 0);
    }
    end_root(&at, "twice.vdb");
    ty_grid* grid = NULL;
    assert_failed(context, ty_vdb_read(context, "twice.vdb", "density", &grid), TY_ERROR_INPUT, "twice.vdb", "damaged");
}

static void real_cloud_equals_its_dense_copy(void** state) {
    (void)state;
    char path[1024];
    data_path("volumes/wdas_cloud_sixteenth_126x86x154_f32.nrrd", path);
    float* expected = read_nrrd(path, 126 * 86 * 154);
    data_path("volumes/wdas_cloud_sixteenth.vdb", path);
    ty_grid* grid = NULL;
    assert_int_equal(ty_vdb_read(context, path, "density", &grid), TY_OK);
    const ty_grid_info info = ty_grid_get_info(grid);
    assert_true(info.size[0] == 126 && info.size[1] == 86 && info.size[2] == 154);
    size_t wrong = 0, i = 0;
    for (int z = 0; z < 154; ++z)
        for (int y = 0; y < 86; ++y)
            for (int x = 0; x < 126; ++x) wrong += ty_grid_voxel(grid, x, y, z) != expected[i++];
    assert_int_equal(wrong, 0);
    static const double lower[3] = {-66, -21, -90};
    for (int a = 0; a < 3; ++a) {
        const double scale = info.index_to_local.m[5 * a], origin = lower[a] * scale;
        assert_true(fabs(scale - 10.0 / 3.0) < 1e-4);
        assert_near(&info.index_to_local.m[4 * a + 3], &origin, 1);
    }
    free(expected);
    ty_grid_release(grid);
}

static void real_temperature_lies_where_density_does(void** state) {
    (void)state;
    char path[1024], frames[1024];
    data_path("volumes/plume/plume_0042.vdb", path);
    snprintf(frames, sizeof frames, "%.*splume_####.vdb", (int)(strlen(path) - strlen("plume_0042.vdb")), path);
    static const char* const names[] = {"density", "temperature"};
    ty_grid_info info[2];
    for (int i = 0; i < 2; ++i) {
        ty_volume_def def = ty_default_volume_def();
        def.grid = names[i];
        def.frame = 42;
        ty_grid* grid = NULL;
        assert_int_equal(ty_volume_read(context, frames, &def, &grid), TY_OK);
        info[i] = ty_grid_get_info(grid);
        ty_grid_release(grid);
    }
    assert_memory_equal(info[0].size, info[1].size, sizeof info[0].size);
    assert_near(info[1].index_to_local.m, info[0].index_to_local.m, 12);
}

static void real_plume_is_listed_and_stays_half(void** state) {
    (void)state;
    char path[1024];
    data_path("volumes/plume/plume_0042.vdb", path);
    ty_vdb_entry entries[8];
    int32_t count = 0;
    assert_int_equal(ty_vdb_list(context, path, entries, 8, &count), TY_OK);
    assert_int_equal(count, 5);
    bool flame = false, velocity = false;
    for (int i = 0; i < count; ++i) {
        if (strcmp(entries[i].name, "flame") == 0) flame = entries[i].active_voxels == 0;
        if (strcmp(entries[i].name, "velocity") == 0) velocity = strcmp(entries[i].type, "vec3s") == 0;
        if (strcmp(entries[i].name, "density") == 0) assert_string_equal(entries[i].type, "half");
        assert_true(fabs(entries[i].voxel_size[1] - 0.03125) < 1e-6);
    }
    assert_true(flame && velocity);
    static const char* const names[] = {"density", "temperature", "shadow", "flame"};
    for (int i = 0; i < 4; ++i) {
        ty_grid* grid = NULL;
        assert_int_equal(ty_vdb_read(context, path, names[i], &grid), TY_OK);
        const ty_grid_info info = ty_grid_get_info(grid);
        assert_int_equal(info.type, TY_GRID_F16);
        if (i == 0) assert_true(info.max > 0.01f && info.min >= 0 && info.size[2] > 20);
        if (i == 3) assert_true(info.size[0] == 1 && info.max == 0);
        ty_grid_release(grid);
    }
    ty_grid* grid = NULL;
    assert_failed(context, ty_vdb_read(context, path, "velocity", &grid), TY_ERROR_INPUT, "plume_0042.vdb", "vec3s");
    assert_failed(context, ty_vdb_read(context, path, "smoke", &grid), TY_ERROR_INPUT, "plume_0042.vdb", "temperature");
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(round_trips_are_exact),
        cmocka_unit_test(surrounding_background_is_cut_off),
        cmocka_unit_test(empty_grid_is_one_voxel_of_background),
        cmocka_unit_test(every_affine_map_and_negative_boxes_are_read),
        cmocka_unit_test(double_grids_become_float),
        cmocka_unit_test(instances_share_a_tree),
        cmocka_unit_test(statistics_come_from_the_file_or_the_tree),
        cmocka_unit_test(grids_that_cannot_be_read_are_explained),
        cmocka_unit_test(boxes_too_large_are_refused_before_memory_is_taken),
        cmocka_unit_test(broken_files_are_refused),
        cmocka_unit_test(failed_writes_leave_the_old_file),
        cmocka_unit_test(short_memory_is_survived),
        cmocka_unit_test(vectors_are_read_by_component),
        cmocka_unit_test(a_place_given_twice_is_refused),
        cmocka_unit_test(real_cloud_equals_its_dense_copy),
        cmocka_unit_test(real_temperature_lies_where_density_does),
        cmocka_unit_test(real_plume_is_listed_and_stays_half),
    };
    return cmocka_run_group_tests(tests, start, stop);
}
