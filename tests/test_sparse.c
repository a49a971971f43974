/* Sparse and paged grids: voxels, statistics, extremes and images as of the dense grid, memory for what is stored, and
 * files. */
#define _GNU_SOURCE
#include "fog.h"
#include "strict_fixture.h"

#include "base/mapping.h"
#include "grid/grid.h"
#include "grid/lookup.k.h"

#include <tyndall/io.h>
#include <tyndall/octaves.h>
#include <tyndall/path.h>

#include <pthread.h>
#include <stdatomic.h>
#include <sys/mman.h>

/* Little memory: a dense grid of the larger sizes here fits once. */
static int start_small(void** state) {
    start(state);
    memory.limit = (size_t)1 << 27;
    return 0;
}

/* Blobs in a constant, with values on all sides of blocks, and some that are not finite. */
static ty_grid* make_blobs(const int32_t size[3], ty_grid_type type, bool placed, float constant) {
    const size_t voxels = (size_t)size[0] * (size_t)size[1] * (size_t)size[2];
    const size_t bytes = type == TY_GRID_F16 ? sizeof(uint16_t) : sizeof(float);
    void* values = malloc(voxels * bytes);
    assert_non_null(values);
    uint64_t seed = 11;
    for (size_t i = 0; i < voxels; ++i) {
        const int32_t x = (int32_t)(i % (size_t)size[0]), y = (int32_t)(i / (size_t)size[0] % (size_t)size[1]);
        const int32_t z = (int32_t)(i / (size_t)size[0] / (size_t)size[1]);
        const bool inside = (x / 5 + y / 7 + z / 9) % 11 == 3 || (x == size[0] - 1 && y == size[1] - 1);
        float value = inside ? (float)uniform(&seed) : constant;
        if (inside && x == 1) value = INFINITY;
        if (size[1] > 40 && y >= 16 && y < 32) value = 2; /* blocks of another value */
        if (type == TY_GRID_F16)
            ((uint16_t*)values)[i] = ty_float_to_half(value);
        else
            ((float*)values)[i] = value;
    }
    ty_grid_def def = ty_default_grid_def();
    memcpy(def.size, size, sizeof def.size);
    def.type = type;
    def.values = values;
    def.placed = placed;
    def.background = placed ? -0.25f : 0;
    ty_grid* grid = NULL;
    assert_int_equal(ty_grid_create(context, &def, &grid), TY_OK);
    free(values);
    return grid;
}

static ty_grid* stored(ty_grid* grid, ty_grid_storage storage) {
    ty_grid* out = NULL;
    assert_int_equal(ty_grid_store(context, grid, storage, &out), TY_OK);
    return out;
}

/* Values in and around the grid, with every combination of axes that wrap, and all that is derived from them. */
static void assert_same(const ty_grid* a, const ty_grid* b) {
    const ty_grid_info x = ty_grid_get_info(a), y = ty_grid_get_info(b);
    ty_grid_view u = ty_grid_get_view(a), v = ty_grid_get_view(b);
    assert_memory_equal(x.size, y.size, sizeof x.size);
    assert_true(x.type == y.type && x.placed == y.placed && x.background == y.background);
    assert_true(x.min == y.min && x.max == y.max && x.mean == y.mean && x.active == y.active);
    assert_memory_equal(&x.index_to_local, &y.index_to_local, sizeof x.index_to_local);
    assert_memory_equal(u.extremes, v.extremes, ty_grid_brick_count(a) * 2 * sizeof(float));
    for (int32_t k = -2; k < x.size[2] + 2; ++k)
        for (int32_t j = -2; j < x.size[1] + 2; ++j)
            for (int32_t i = -2; i < x.size[0] + 2; ++i) {
                u.wraps = v.wraps = (i + j + k) & 7;
                assert_true(ty_grid_fetch(&u, i, j, k) == ty_grid_fetch(&v, i, j, k));
            }
}

static void storage_changes_nothing_else(void** state) {
    static const int32_t sizes[][3] = {{19, 8, 33}, {16, 24, 7}, {1, 1, 1}, {40, 41, 9}};
    (void)state;
    for (size_t s = 0; s < sizeof sizes / sizeof *sizes; ++s)
        for (int kind = 0; kind < 4; ++kind) {
            ty_grid* dense =
                make_blobs(sizes[s], (kind & 1) != 0 ? TY_GRID_F16 : TY_GRID_F32, (kind & 2) != 0, s == 3 ? 0.5f : 0);
            ty_grid* sparse = stored(dense, TY_GRID_SPARSE);
            ty_grid* again = stored(sparse, TY_GRID_DENSE);
            const ty_grid_info info = ty_grid_get_info(sparse);
            assert_int_equal(info.storage, TY_GRID_SPARSE);
            assert_int_equal(ty_grid_get_info(again).storage, TY_GRID_DENSE);
            assert_null(ty_grid_values(sparse));
            assert_int_equal(info.stored % 512, 0);
            assert_same(dense, sparse);
            assert_same(dense, again);
            ty_grid *paged = stored(dense, TY_GRID_PAGED), *copied = stored(sparse, TY_GRID_PAGED);
            ty_grid *back = stored(paged, TY_GRID_SPARSE), *same = stored(paged, TY_GRID_AUTO);
            assert_int_equal(ty_grid_get_info(paged).storage, TY_GRID_PAGED);
            assert_int_equal(ty_grid_get_info(back).storage, TY_GRID_SPARSE);
            assert_ptr_equal(same, paged);
            assert_same(dense, paged);
            assert_same(dense, copied);
            assert_same(dense, back);
            ty_grid_release(paged);
            ty_grid_release(copied);
            ty_grid_release(back);
            ty_grid_release(same);
            ty_grid_release(dense);
            ty_grid_release(sparse);
            ty_grid_release(again);
        }
}

/* 200 x 200 x 160 floats, 24.4 MiB, of which a cube of 40^3 varies, and one of 64^3 has one value: a twentieth of the
 * voxels. */
enum { LARGE_X = 200, LARGE_Y = 200, LARGE_Z = 160, LARGE = LARGE_X * LARGE_Y * LARGE_Z };
enum { CORNER = 40, TILES = 64, ACTIVE = CORNER * CORNER * CORNER + TILES * TILES * TILES + 2 };

static float large_value(int32_t i, int32_t j, int32_t k) {
    /* The box of active voxels begins inside a block. */
    if ((i == 3 && j == 5 && k == 6) || (i == 196 && j == 197 && k == 158)) return 1;
    const bool inside = i >= 100 && i < 100 + CORNER && j >= 90 && j < 90 + CORNER && k >= 80 && k < 80 + CORNER;
    if (i >= 8 && i < 8 + TILES && j >= 8 && j < 8 + TILES && k >= 8 && k < 8 + TILES) return 3;
    return inside ? (float)(1 + (i * 7 + j * 5 + k * 3) % 64) : 0;
}

static float* large_values(void) {
    float* values = malloc(LARGE * sizeof *values);
    assert_non_null(values);
    for (size_t i = 0; i < LARGE; ++i)
        values[i] =
            large_value((int32_t)(i % LARGE_X), (int32_t)(i / LARGE_X % LARGE_Y), (int32_t)(i / LARGE_X / LARGE_Y));
    return values;
}

static void assert_large(const ty_grid* grid, int32_t x, int32_t y, int32_t z) {
    const ty_grid_info info = ty_grid_get_info(grid);
    int64_t active = 0;
    for (int32_t k = 0; k < info.size[2]; ++k)
        for (int32_t j = 0; j < info.size[1]; ++j)
            for (int32_t i = 0; i < info.size[0]; ++i) {
                const float value = large_value(i + x, j + y, k + z);
                active += value != 0;
                if (ty_grid_voxel(grid, i, j, k) != value) fail_msg("voxel %d %d %d", i, j, k);
            }
    assert_int_equal(info.active, active);
    assert_int_equal(active, ACTIVE);
}

static void memory_is_for_what_is_active(void** state) {
    (void)state;
    ty_grid_def def = ty_default_grid_def();
    float* values = large_values();
    def.size[0] = LARGE_X;
    def.size[1] = LARGE_Y;
    def.size[2] = LARGE_Z;
    def.values = values;
    def.placed = true;
    ty_grid *dense = NULL, *sparse = NULL, *noise = NULL, *kept = NULL, *back = NULL;
    assert_int_equal(ty_grid_create(context, &def, &dense), TY_OK);
    sparse = stored(dense, TY_GRID_AUTO);
    const ty_grid_info info = ty_grid_get_info(sparse);
    assert_int_equal(info.storage, TY_GRID_SPARSE);
    assert_large(sparse, 0, 0, 0);
    /* at most 6^3 blocks of the cube that varies, 8^3 of the other, 2 beside them and the common one; 12 bytes for each
     * of 25 x 25 x 20 */
    assert_true(info.stored <= (6 * 6 * 6 + 8 * 8 * 8 + 3) * 512);
    assert_true(info.bytes < ty_grid_get_info(dense).bytes / 12);
    ty_grid_release(dense);

    assert_int_equal(ty_vdb_write(context, sparse, "density", "zip", "large.vdb"), TY_OK);
    ty_grid_release(sparse);
    for (size_t i = 0; i < LARGE; ++i) values[i] = (float)(i % 97);
    assert_int_equal(ty_grid_create(context, &def, &noise), TY_OK);
    kept = stored(noise, TY_GRID_AUTO); /* nothing is saved */
    assert_ptr_equal(kept, noise);
    ty_grid_release(kept);
    ty_grid_release(noise);
    free(values);

    /* less memory than the dense array has, 24.4 MiB */
    memory.limit = (size_t)16 << 20;
    assert_int_equal(ty_vdb_read(context, "large.vdb", "density", &back), TY_OK);
    assert_int_equal(ty_grid_get_info(back).storage, TY_GRID_SPARSE);
    assert_large(back, 3, 5, 6);
    assert_true(ty_grid_get_info(back).stored <= (6 * 6 * 6 + 4) * 512); /* tiles share a block */
    ty_volume_def file = ty_default_volume_def();
    file.storage = TY_GRID_DENSE;
    assert_failed(context, ty_volume_read(context, "large.vdb", &file, &dense), TY_ERROR_MEMORY, "memory", "MiB");
    memory.limit = (size_t)1 << 27;
    assert_int_equal(ty_volume_read(context, "large.vdb", &file, &dense), TY_OK);
    assert_int_equal(ty_grid_get_info(dense).storage, TY_GRID_DENSE);
    assert_memory_equal(ty_grid_get_view(dense).extremes, ty_grid_get_view(back).extremes,
                        ty_grid_brick_count(back) * 2 * sizeof(float));
    assert_true(ty_grid_get_info(dense).mean == ty_grid_get_info(back).mean);
    ty_grid_release(dense);
    ty_grid_release(back);
}

/* A raw file and one of NRRD are read in parts: the array is never in memory. */
static void raw_files_are_read_in_parts(void** state) {
    (void)state;
    static const char header[] = "NRRD0004\ntype: float\ndimension: 3\nsizes: 200 200 160\nendian: little\n"
                                 "encoding: raw\n\n";
    const size_t start = sizeof header - 1, size = LARGE * sizeof(float);
    float* values = large_values();
    uint8_t* bytes = malloc(start + size);
    assert_non_null(bytes);
    memcpy(bytes, header, start);
    memcpy(bytes + start, values, size);
    put_file("large.nrrd", bytes, start + size);
    put_file("large.raw", values, size);
    free(bytes);
    free(values);
    memory.limit = (size_t)16 << 20;
    ty_volume_def def = ty_default_volume_def();
    def.raw_size[0] = LARGE_X;
    def.raw_size[1] = LARGE_Y;
    def.raw_size[2] = LARGE_Z;
    snprintf(def.raw_type, sizeof def.raw_type, "float");
    for (int i = 0; i < 2; ++i) {
        ty_grid* grid = NULL;
        assert_int_equal(ty_volume_read(context, i == 0 ? "large.raw" : "large.nrrd", &def, &grid), TY_OK);
        assert_int_equal(ty_grid_get_info(grid).storage, TY_GRID_SPARSE);
        assert_large(grid, 0, 0, 0);
        ty_grid_release(grid);
    }
}

/* Every block of these varies: sparse, the grid would take as much as dense, 24.4 MiB. */
static void paged_files_need_little_memory(void** state) {
    (void)state;
    float* values = malloc(LARGE * sizeof *values);
    assert_non_null(values);
    for (size_t i = 0; i < LARGE; ++i) values[i] = (float)(i % 97);
    put_file("paged.raw", values, LARGE * sizeof *values);
    memory.limit = (size_t)8 << 20;
    ty_volume_def def = ty_default_volume_def();
    def.raw_size[0] = LARGE_X;
    def.raw_size[1] = LARGE_Y;
    def.raw_size[2] = LARGE_Z;
    snprintf(def.raw_type, sizeof def.raw_type, "float");
    ty_grid *grid = NULL, *bricks = NULL;
    assert_failed(context, ty_volume_read(context, "paged.raw", &def, &grid), TY_ERROR_MEMORY, "memory", "MiB");
    def.storage = TY_GRID_PAGED;
    assert_int_equal(ty_volume_read(context, "paged.raw", &def, &grid), TY_OK);
    const ty_volume_field field = {.name = "density", .components = 1, .grids = {grid}};
    assert_int_equal(ty_volume_write(context, &field, 1, NULL, "paged.bricks"), TY_OK);
    ty_volume_def plain = ty_default_volume_def();
    assert_int_equal(ty_volume_read(context, "paged.bricks", &plain, &bricks), TY_OK);
    for (const ty_grid* each = grid; each != NULL; each = each == grid ? bricks : NULL) {
        const ty_grid_info info = ty_grid_get_info(each);
        assert_int_equal(info.storage, TY_GRID_PAGED);
        assert_true(info.bytes < 12 * 26 * 26 * 21 + 1024 && info.stored == 512 * (25 * 25 * 20 + 1));
        for (int32_t k = 0; k < LARGE_Z; ++k)
            for (int32_t j = 0; j < LARGE_Y; ++j)
                for (int32_t i = 0; i < LARGE_X; ++i)
                    if (ty_grid_voxel(each, i, j, k) != values[(size_t)i + LARGE_X * ((size_t)j + LARGE_Y * (size_t)k)])
                        fail_msg("voxel %d %d %d", i, j, k);
    }
    ty_grid_release(grid);
    ty_grid_release(bricks);
    free(values);
}

/* Packed files are inflated in parts, and again for the voxels that are stored. */
static void packed_files_are_read_in_parts(void** state) {
    (void)state;
    static const char* const paths[] = {"large_packed.nrrd", "large_packed.nii.gz", "large_packed.vti"};
    static const char* const codecs[] = {"gzip", "gzip", "zip"};
    ty_grid_def def = ty_default_grid_def();
    float* values = large_values();
    def.size[0] = LARGE_X;
    def.size[1] = LARGE_Y;
    def.size[2] = LARGE_Z;
    def.values = values;
    def.placed = true;
    ty_volume_field field = {.name = "density", .components = 1};
    ty_grid* grid = NULL;
    assert_int_equal(ty_grid_create(context, &def, &grid), TY_OK);
    free(values);
    field.grids[0] = grid;
    for (int i = 0; i < 3; ++i) assert_int_equal(ty_volume_write(context, &field, 1, codecs[i], paths[i]), TY_OK);
    ty_grid_release(grid);
    memory.limit = (size_t)12 << 20; /* the dense array has 24.4 MiB */
    const ty_volume_def file = ty_default_volume_def();
    for (int i = 0; i < 3; ++i) {
        grid = NULL;
        if (ty_volume_read(context, paths[i], &file, &grid) != TY_OK)
            fail_msg("%s: %s", paths[i], ty_take_error(context));
        assert_int_equal(ty_grid_get_info(grid).storage, TY_GRID_SPARSE);
        assert_large(grid, 0, 0, 0);
        ty_grid_release(grid);
    }
}

/* ---- images ---- */

static ty_scene* make_smoke(ty_grid* grid, bool transfer) {
    static const double lower[3] = {-1, -1, -1}, upper[3] = {1, 1, 1};
    static const ty_transfer_point points[] = {{.value = 0, .density = 0}, {.value = 1, .density = 2}};
    ty_medium_def smoke = box_medium(lower, upper, 4, 0.4f);
    smoke.density_grid = grid;
    if (transfer) {
        smoke.transfer = points;
        smoke.transfer_count = 2;
    }
    ty_light_def sun = ty_default_light_def(), sky = sun;
    set3(sun.direction, -0.4, -1, -0.3);
    set3f(sun.color, 3, 3, 3);
    sky.kind = TY_LIGHT_ENVIRONMENT;
    set3f(sky.color, 0.3f, 0.4f, 0.6f);
    ty_camera_def camera = ty_default_camera_def();
    set3(camera.position, 0.4, 0.6, 4);
    camera.fov_y = 45;
    ty_scene* scene = make_scene(context);
    assert_int_equal(ty_scene_add_medium(scene, &smoke), TY_OK);
    assert_int_equal(ty_scene_add_light(scene, &sun), TY_OK);
    assert_int_equal(ty_scene_add_light(scene, &sky), TY_OK);
    assert_int_equal(ty_scene_set_camera(scene, &camera), TY_OK);
    assert_int_equal(ty_scene_commit(scene), TY_OK);
    return scene;
}

/* An image by paths, on the context's device, or of the marcher over cells. */
static ty_image* draw(ty_grid* grid, bool transfer, bool marched) {
    ty_scene* scene = make_smoke(grid, transfer);
    ty_image* image = NULL;
    ty_path_def path = ty_default_path_def();
    ty_octaves_def octaves = ty_default_octaves_def();
    path.width = octaves.width = WIDTH;
    path.height = octaves.height = HEIGHT;
    path.spp = 4;
    octaves.resolution = 12;
    octaves.environment_beams = 4;
    assert_int_equal(
        marched ? ty_octaves_render(scene, &octaves, &image, NULL) : ty_path_render(scene, &path, &image, NULL), TY_OK);
    ty_scene_destroy(scene);
    return image;
}

/* A thread that takes the pages of a paged grid out of memory, again and again. */
typedef struct evictor {
    pthread_t thread;
    const ty_grid* grid;
    _Atomic bool ends;
    _Atomic int64_t times;
} evictor;

static void* evict(void* user) {
    evictor* e = user;
    const ty_mapping* mapping = e->grid->blocks.mapping;
    while (!atomic_load(&e->ends)) {
        if (madvise(mapping->bytes, mapping->size, MADV_DONTNEED) != 0) return NULL;
        atomic_fetch_add(&e->times, 1);
    }
    return NULL;
}

static ty_image* draw_evicted(ty_grid* grid, bool transfer, bool marched) {
    evictor e = {.grid = grid};
    assert_int_equal(ty_grid_get_info(grid).storage, TY_GRID_PAGED);
    assert_int_equal(pthread_create(&e.thread, NULL, evict, &e), 0);
    ty_image* image = NULL;
    int64_t before = 0;
    /* again where the system has given the thread no time meanwhile; on an idle machine, pages go thousands of times */
    for (int i = 0; i < 200 && (image == NULL || atomic_load(&e.times) <= before + 3); ++i) {
        ty_image_destroy(image);
        before = atomic_load(&e.times);
        image = draw(grid, transfer, marched);
    }
    assert_true(atomic_load(&e.times) > before + 3);
    atomic_store(&e.ends, true);
    pthread_join(e.thread, NULL);
    return image;
}

static void assert_same_image(const ty_image* a, const ty_image* b, int kind) {
    float sum = 0;
    for (int32_t c = 0; c < 3; ++c) {
        const float *x = ty_image_plane_const(a, c), *y = ty_image_plane_const(b, c);
        for (int i = 0; i < PIXELS; ++i) {
            if (x[i] != y[i]) fail_msg("kind %d, pixel %d: %g, not %g", kind, i, (double)y[i], (double)x[i]);
            sum += x[i];
        }
    }
    assert_true(sum > 1);
}

static void compare_images(bool marched) {
    static const int32_t size[3] = {37, 26, 30};
    for (int kind = 0; kind < 4; ++kind) {
        ty_grid* dense = make_blobs(size, (kind & 1) != 0 ? TY_GRID_F16 : TY_GRID_F32, false, 0);
        ty_grid* sparse = stored(dense, TY_GRID_SPARSE);
        ty_image *a = draw(dense, (kind & 2) != 0, marched), *b = draw(sparse, (kind & 2) != 0, marched);
        ty_grid* paged = stored(dense, TY_GRID_PAGED);
        ty_image* c = draw_evicted(paged, (kind & 2) != 0, marched);
        assert_same_image(a, b, kind);
        assert_same_image(a, c, kind);
        ty_image_destroy(a);
        ty_image_destroy(b);
        ty_image_destroy(c);
        ty_grid_release(paged);
        ty_grid_release(dense);
        ty_grid_release(sparse);
    }
}

static void images_are_the_same(void** state) {
    (void)state;
    compare_images(false);
    compare_images(true);
}

static int start_on_host(void** state) {
    (void)state;
    ty_context_def def = ty_default_context_def();
    def.device = "host";
    def.threads = 2;
    memory = (strict_memory){.until_refusal = -1};
    return ty_context_create(&def, &context) == TY_OK ? 0 : -1;
}

/* A packed scene has the blocks, too. */
static void images_of_devices_are_the_same(void** state) {
    (void)state;
    compare_images(false);
}

static void wrong_calls_are_refused(void** state) {
    static const int32_t size[3] = {2, 2, 2};
    (void)state;
    ty_grid *grid = make_blobs(size, TY_GRID_F32, false, 0), *out = NULL;
    assert_failed(context, ty_grid_store(context, grid, (ty_grid_storage)7, &out), TY_ERROR_ARGUMENT, "storage",
                  "store");
    assert_failed(context, ty_grid_store(context, NULL, TY_GRID_AUTO, &out), TY_ERROR_ARGUMENT, "NULL", "store");
    ty_volume_def def = ty_default_volume_def();
    def.storage = (ty_grid_storage)-1;
    assert_failed(context, ty_volume_read(context, "none.vdb", &def, &out), TY_ERROR_ARGUMENT, "storage", "-1");
    ty_grid_release(grid);
}

int main(int argc, char** argv) {
    (void)argc;
    (void)argv;
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(storage_changes_nothing_else, start, stop),
        cmocka_unit_test_setup_teardown(memory_is_for_what_is_active, start_small, stop),
        cmocka_unit_test_setup_teardown(raw_files_are_read_in_parts, start_small, stop),
        cmocka_unit_test_setup_teardown(paged_files_need_little_memory, start_small, stop),
        cmocka_unit_test_setup_teardown(packed_files_are_read_in_parts, start_small, stop),
        cmocka_unit_test_setup_teardown(images_are_the_same, start, stop),
        cmocka_unit_test_setup_teardown(images_of_devices_are_the_same, start_on_host, stop),
        cmocka_unit_test_setup_teardown(wrong_calls_are_refused, start, stop),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
