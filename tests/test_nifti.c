/* NIfTI-1 and NIfTI-2: types, byte orders, scaling, sform and qform, pairs, gzip, volumes, broken files. */
#include "strict_fixture.h"

#include <tyndall/io.h>

#include <math.h>
#include <zlib.h>

enum { NX = 3, NY = 2, NZ = 2, VOXELS = NX * NY * NZ, FILE_MAX = 4096 };

/* A file being made; the fields of headers are set by their offsets in nifti1.h and nifti2.h. */
typedef struct nifti_maker {
    uint8_t bytes[FILE_MAX];
    size_t size;
    int version;
    bool big_endian;
} nifti_maker;

static nifti_maker maker;

static void set_bits(size_t at, uint64_t bits, size_t size) {
    assert_true(at + size <= FILE_MAX);
    for (size_t i = 0; i < size; ++i)
        maker.bytes[at + i] = (uint8_t)(bits >> 8 * (maker.big_endian ? size - 1 - i : i));
}

static void set_float(size_t at, double value) {
    const float narrow = (float)value;
    uint32_t bits;
    memcpy(&bits, &narrow, sizeof bits);
    set_bits(at, bits, sizeof bits);
}

static void set_double(size_t at, double value) {
    uint64_t bits;
    memcpy(&bits, &value, sizeof bits);
    set_bits(at, bits, sizeof bits);
}

/* A real number of a header: a float in version 1, a double in version 2; the i-th of a field. */
static void set_real(size_t first, size_t second, int i, double value) {
    if (maker.version == 1)
        set_float(first + 4 * (size_t)i, value);
    else
        set_double(second + 8 * (size_t)i, value);
}

static void set_dim(int i, int64_t value) {
    if (maker.version == 1)
        set_bits(40 + 2 * (size_t)i, (uint64_t)value, 2);
    else
        set_bits(16 + 8 * (size_t)i, (uint64_t)value, 8);
}

/* A code: 16 bits in version 1, 32 in version 2. */
static void set_code(size_t first, size_t second, int value) {
    set_bits(maker.version == 1 ? first : second, (uint64_t)value, maker.version == 1 ? 2 : 4);
}

static void set_scaling(double slope, double intercept) {
    set_real(112, 176, 0, slope);
    set_real(116, 184, 0, intercept);
}

/* A header of 3 x 2 x 2 voxels, 1.5 x 2 x 2.5 mm apart, of a datatype, that ends where the voxels begin. */
static void begin(int version, bool big_endian, int datatype) {
    maker = (nifti_maker){.version = version, .big_endian = big_endian, .size = version == 1 ? 352 : 544};
    set_bits(0, version == 1 ? 348 : 540, 4);
    memcpy(maker.bytes + (version == 1 ? 344 : 4), version == 1 ? "n+1" : "n+2\0\r\n\032\n", version == 1 ? 4 : 8);
    static const int dims[] = {3, NX, NY, NZ, 1, 1, 1, 1};
    for (int i = 0; i < 8; ++i) set_dim(i, dims[i]);
    set_bits(version == 1 ? 70 : 12, (uint64_t)datatype, 2);
    static const double spacings[] = {1, 1.5, 2, 2.5};
    for (int i = 0; i < 4; ++i) set_real(76, 104, i, spacings[i]);
    if (version == 1)
        set_float(108, (double)maker.size);
    else
        set_bits(168, maker.size, 8);
    if (version == 1)
        maker.bytes[123] = 2; /* mm */
    else
        set_bits(500, 2, 4);
}

/* Appends a sample of a datatype. */
static void append(int datatype, double value) {
    const size_t at = maker.size;
    switch (datatype) {
    case 2:
    case 256:
        set_bits(at, (uint64_t)(int64_t)value, 1);
        maker.size += 1;
        break;
    case 4:
    case 512:
        set_bits(at, (uint64_t)(int64_t)value, 2);
        maker.size += 2;
        break;
    case 8:
    case 768:
        set_bits(at, (uint64_t)(int64_t)value, 4);
        maker.size += 4;
        break;
    case 16:
        set_float(at, value);
        maker.size += 4;
        break;
    case 64:
        set_double(at, value);
        maker.size += 8;
        break;
    default:
        set_bits(at, (uint64_t)(int64_t)value, 8);
        maker.size += 8;
        break;
    }
}

static void append_ramp(int datatype, double first) {
    for (int i = 0; i < VOXELS; ++i) append(datatype, first + i);
}

static void put(const char* path) {
    put_file(path, maker.bytes, maker.size);
}

static ty_grid* read_component(const char* path, int component) {
    ty_volume_def def = ty_default_volume_def();
    def.component = component;
    ty_grid* grid = NULL;
    if (ty_volume_read(context, path, &def, &grid) != TY_OK) fail_msg("%s: %s", path, ty_take_error(context));
    return grid;
}

static void assert_ramp(const ty_grid* grid, double first, double slope) {
    for (int i = 0; i < VOXELS; ++i) {
        const double found = (double)ty_grid_voxel(grid, i % NX, i / NX % NY, i / (NX * NY));
        if (found != (double)(float)(first + slope * i))
            fail_msg("voxel %d is %g, not %g", i, found, first + slope * i);
    }
}

static void assert_place(const ty_grid* grid, const double expected[12], double tolerance) {
    const ty_grid_info info = ty_grid_get_info(grid);
    assert_true(info.placed);
    for (int i = 0; i < 12; ++i)
        if (!(fabs(info.index_to_local.m[i] - expected[i]) <= tolerance))
            fail_msg("entry %d of the placement is %g, not %g", i, info.index_to_local.m[i], expected[i]);
}

static void every_datatype_is_read(void** state) {
    (void)state;
    static const struct {
        int datatype;
        double first;
    } cases[] = {{2, 240},  {4, -5},      {8, -70000}, {16, 0.25},    {64, -1e9},
                 {256, -6}, {512, 65000}, {768, 4e9},  {1024, -1e12}, {1280, 1e12}};
    for (int version = 1; version <= 2; ++version)
        for (int big = 0; big < 2; ++big)
            for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
                begin(version, big == 1, cases[i].datatype);
                append_ramp(cases[i].datatype, cases[i].first);
                put("types.nii");
                ty_grid* grid = read_component("types.nii", 0);
                assert_ramp(grid, cases[i].first, 1);
                assert_place(grid, (const double[]){1.5, 0, 0, 0, 0, 2, 0, 0, 0, 0, 2.5, 0}, 0);
                ty_grid_release(grid);
            }
}

static void samples_are_scaled(void** state) {
    (void)state;
    for (int version = 1; version <= 2; ++version) {
        begin(version, false, 2);
        set_scaling(0.5, -1024);
        append_ramp(2, 10);
        put("scaled.nii");
        ty_grid* grid = read_component("scaled.nii", 0);
        assert_ramp(grid, -1019, 0.5);
        assert_int_equal(ty_grid_get_info(grid).type, TY_GRID_F32);
        ty_grid_release(grid);
        set_scaling(0, 7); /* a slope of 0 means that nothing is scaled */
        put("scaled.nii");
        grid = read_component("scaled.nii", 0);
        assert_ramp(grid, 10, 1);
        ty_grid_release(grid);
    }
}

static void sform_comes_before_qform(void** state) {
    (void)state;
    static const double rows[12] = {-1.5, 0, 0.25, 90, 0, 2, 0, -126, 0, 0.125, 2.5, -72};
    for (int version = 1; version <= 2; ++version)
        for (int big = 0; big < 2; ++big) {
            begin(version, big == 1, 4);
            append_ramp(4, 0);
            /* A quarter turn about z: x goes to y. */
            set_code(252, 344, 1);
            set_real(256, 352, 2, sqrt(0.5));
            static const double offset[3] = {1, 2, 3};
            for (int a = 0; a < 3; ++a) set_real(268, 376, a, offset[a]);
            put("placed.nii");
            ty_grid* grid = read_component("placed.nii", 0);
            assert_place(grid, (const double[]){0, -2, 0, 1, 1.5, 0, 0, 2, 0, 0, 2.5, 3}, 1e-6);
            ty_grid_release(grid);
            set_real(76, 104, 0, -1); /* qfac: the third axis is reversed */
            put("placed.nii");
            grid = read_component("placed.nii", 0);
            assert_place(grid, (const double[]){0, -2, 0, 1, 1.5, 0, 0, 2, 0, 0, -2.5, 3}, 1e-6);
            ty_grid_release(grid);
            set_real(76, 104, 0, 0);
            set_real(76, 104, 3, 0); /* a spacing that a single slice may lack */
            put("placed.nii");
            grid = read_component("placed.nii", 0);
            assert_place(grid, (const double[]){0, -2, 0, 1, 1.5, 0, 0, 2, 0, 0, 1, 3}, 1e-6);
            ty_grid_release(grid);
            set_code(254, 348, 2);
            for (int i = 0; i < 12; ++i) set_real(280, 400, i, rows[i]);
            put("placed.nii");
            grid = read_component("placed.nii", 0);
            assert_place(grid, rows, 0);
            ty_grid_release(grid);
        }
}

static void pairs_and_gzip_are_read(void** state) {
    (void)state;
    begin(1, false, 4);
    const size_t header = maker.size;
    append_ramp(4, 3);
    gzFile packed = gzopen("a.nii.gz", "wb");
    assert_int_equal(gzwrite(packed, maker.bytes, (unsigned)maker.size), maker.size);
    gzclose(packed);
    ty_grid* grid = read_component("a.nii.gz", 0);
    assert_ramp(grid, 3, 1);
    ty_grid_release(grid);
    maker.bytes[345] = 'i';
    set_float(108, 0);
    put_file("Pair.HDR", maker.bytes, 348);
    put_file("Pair.IMG", maker.bytes + header, maker.size - header);
    grid = read_component("Pair.HDR", 0);
    assert_ramp(grid, 3, 1);
    ty_grid_release(grid);
    size_t size;
    uint8_t* bytes = get_file("a.nii.gz", &size);
    put_file("cut.nii.gz", bytes, size - 12);
    free(bytes);
    ty_volume_def def = ty_default_volume_def();
    assert_failed(context, ty_volume_read(context, "cut.nii.gz", &def, &grid), TY_ERROR_INPUT, "cut.nii.gz", "damaged");
}

static void volumes_are_components(void** state) {
    (void)state;
    begin(1, true, 4);
    set_dim(0, 5);
    set_dim(4, 2);
    set_dim(5, 3);
    for (int v = 0; v < 6; ++v) append_ramp(4, 100 * v);
    put("times.nii");
    gzFile packed = gzopen("times.nii.gz", "wb");
    assert_int_equal(gzwrite(packed, maker.bytes, (unsigned)maker.size), maker.size);
    gzclose(packed);
    static const char* const names[] = {"times.nii", "times.nii.gz"};
    for (int n = 0; n < 2; ++n) {
        ty_volume_def def = ty_default_volume_def();
        int32_t components = 0;
        assert_int_equal(ty_volume_components(context, names[n], &def, &components), TY_OK);
        assert_int_equal(components, 6);
        for (int v = 0; v < 6; ++v) {
            ty_grid* grid = read_component(names[n], v);
            assert_ramp(grid, 100 * v, 1);
            ty_grid_release(grid);
        }
        ty_grid* grid = NULL;
        def.component = 6;
        assert_failed(context, ty_volume_read(context, names[n], &def, &grid), TY_ERROR_INPUT, names[n], "component 6");
    }
    begin(1, false, 128); /* RGB: components side by side */
    for (int i = 0; i < 3 * VOXELS; ++i) append(2, i);
    put("rgb.nii");
    for (int c = 0; c < 3; ++c) {
        ty_grid* grid = read_component("rgb.nii", c);
        assert_ramp(grid, c, 3);
        ty_grid_release(grid);
    }
}

static void assert_refused(const char* words) {
    ty_volume_def def = ty_default_volume_def();
    ty_grid* grid = NULL;
    put("broken.nii");
    assert_failed(context, ty_volume_read(context, "broken.nii", &def, &grid), TY_ERROR_INPUT, "broken.nii", words);
}

static void broken_files_are_refused(void** state) {
    (void)state;
    begin(1, false, 4);
    append_ramp(4, 0);
    maker.size -= 1;
    assert_refused("cut short");
    maker.size = 300;
    assert_refused("cut short in its header");
    begin(1, false, 1536);
    assert_refused("datatype 1536");
    begin(1, false, 4);
    set_dim(0, 8);
    assert_refused("dim[0] is 8");
    set_dim(0, 3);
    set_dim(2, -4);
    assert_refused("dim[2] is -4");
    set_dim(2, 32767);
    assert_refused("3 x 32767 x 2");
    set_dim(2, 16000);
    set_dim(1, 16000);
    assert_refused("cut short");
    begin(1, false, 4);
    set_float(108, 100);
    assert_refused("vox_offset is 100");
    set_float(108, (double)NAN);
    assert_refused("vox_offset");
    begin(1, false, 4);
    set_code(254, 348, 1);
    assert_refused("sform does not place");
    begin(2, false, 4);
    set_dim(0, 7);
    set_dim(6, (int64_t)1 << 40);
    assert_refused("dim[6]");
    set_dim(6, 70000);
    assert_refused("70000 volumes");
    begin(1, false, 4);
    memset(maker.bytes + 344, 0, 4);
    assert_refused("ANALYZE 7.5");
}

static void memory_may_run_out(void** state) {
    (void)state;
    begin(1, false, 4);
    append_ramp(4, 3);
    gzFile packed = gzopen("short.nii.gz", "wb");
    gzwrite(packed, maker.bytes, (unsigned)maker.size);
    gzclose(packed);
    assert_true(check_short_memory(context, &memory, read_volume, (void*)(uintptr_t) "short.nii.gz") > 4);
}

/* Written files are read as they were: values to the last bit, places to the precision of the sform's floats. */
static void written_volumes_come_back(void** state) {
    (void)state;
    static const float values[VOXELS] = {0, 1, -2, 3.5f, 4, 5, 6e-20f, 7, 8, 9, 10, 1e30f};
    static const char* const paths[] = {"out.nii", "out.nii.gz"};
    ty_grid_def def = ty_default_grid_def();
    def.size[0] = NX;
    def.size[1] = NY;
    def.size[2] = NZ;
    def.values = values;
    def.placed = true;
    def.index_to_local = (ty_affine){{0, -2, 0, 10, 1.5, 0, 0, 20, 0, 0, 2.5, -30}};
    ty_grid* grid = NULL;
    assert_int_equal(ty_grid_create(context, &def, &grid), TY_OK);
    for (int i = 0; i < 4; ++i) {
        const ty_volume_field field = {.name = "v", .components = i < 2 ? 1 : 3, .grids = {grid, grid, grid}};
        assert_int_equal(ty_volume_write(context, &field, 1, NULL, paths[i % 2]), TY_OK);
        ty_volume_def file = ty_default_volume_def();
        int32_t components = 0;
        assert_int_equal(ty_volume_components(context, paths[i % 2], &file, &components), TY_OK);
        assert_int_equal(components, field.components);
        for (file.component = 0; file.component < components; ++file.component) {
            ty_grid* back = NULL;
            assert_int_equal(ty_volume_read(context, paths[i % 2], &file, &back), TY_OK);
            for (int v = 0; v < VOXELS; ++v)
                assert_true(ty_grid_voxel(back, v % NX, v / NX % NY, v / NX / NY) == values[v]);
            const ty_grid_info info = ty_grid_get_info(back);
            for (int m = 0; m < 12; ++m) assert_float_equal(info.index_to_local.m[m], def.index_to_local.m[m], 1e-6);
            ty_grid_release(back);
        }
    }
    const ty_volume_field fields[2] = {{.name = "a", .components = 1, .grids = {grid}},
                                       {.name = "b", .components = 1, .grids = {grid}}};
    assert_failed(context, ty_volume_write(context, fields, 1, "gzip", "a.nii"), TY_ERROR_ARGUMENT, "codec", "gzip");
    assert_failed(context, ty_volume_write(context, fields, 2, NULL, "a.nii"), TY_ERROR_ARGUMENT, "a.nii", "one field");
    ty_grid_release(grid);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_datatype_is_read),   cmocka_unit_test(samples_are_scaled),
        cmocka_unit_test(sform_comes_before_qform), cmocka_unit_test(pairs_and_gzip_are_read),
        cmocka_unit_test(volumes_are_components),   cmocka_unit_test(broken_files_are_refused),
        cmocka_unit_test(memory_may_run_out),       cmocka_unit_test(written_volumes_come_back),
    };
    return cmocka_run_group_tests(tests, start, stop);
}
