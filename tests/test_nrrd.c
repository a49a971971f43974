/* NRRD files: round trips, every type, encoding and layout, placement, broken ones, and real ones. */
#include "strict_fixture.h"

#include <tyndall/io.h>

#include <locale.h>
#include <math.h>
#include <sys/stat.h>
#include <zlib.h>

/* Little memory: what files claim is not believed. */
static int start_small(void** state) {
    start(state);
    memory.limit = (size_t)1 << 28;
    return 0;
}

/* A file of a header and data behind it. */
static void put_nrrd(const char* path, const char* header, const void* data, size_t size) {
    uint8_t bytes[4096];
    const size_t length = strlen(header);
    assert_true(length + size <= sizeof bytes);
    memcpy(bytes, header, length);
    if (size > 0) memcpy(bytes + length, data, size);
    put_file(path, bytes, length + size);
}

static ty_grid* read_component(const char* path, int32_t component) {
    ty_volume_def def = ty_default_volume_def();
    def.component = component;
    ty_grid* grid = NULL;
    if (ty_volume_read(context, path, &def, &grid) != TY_OK) fail_msg("%s", ty_take_error(context));
    return grid;
}

static void assert_refused(const char* path, const char* matter) {
    const ty_volume_def def = ty_default_volume_def();
    ty_grid* grid = NULL;
    const ty_result result = ty_volume_read(context, path, &def, &grid);
    assert_null(grid);
    if (result != TY_ERROR_FILE && result != TY_ERROR_INPUT) fail_msg("%s: %s", path, ty_result_name(result));
    assert_failed(context, result, result, path, matter);
}

static ty_grid* make_grid(const ty_affine* map) {
    static float values[5 * 4 * 3];
    for (int i = 0; i < 5 * 4 * 3; ++i) values[i] = (float)(i - 20) / 3;
    ty_grid_def def = ty_default_grid_def();
    def.size[0] = 5;
    def.size[1] = 4;
    def.size[2] = 3;
    def.values = values;
    def.placed = true;
    def.index_to_local = *map;
    ty_grid* grid = NULL;
    assert_int_equal(ty_grid_create(context, &def, &grid), TY_OK);
    return grid;
}

static void assert_same(const ty_grid* a, const ty_grid* b) {
    const ty_grid_info x = ty_grid_get_info(a), y = ty_grid_get_info(b);
    assert_memory_equal(x.size, y.size, sizeof x.size);
    assert_memory_equal(x.index_to_local.m, y.index_to_local.m, sizeof x.index_to_local.m);
    for (int k = 0; k < x.size[2]; ++k)
        for (int j = 0; j < x.size[1]; ++j)
            for (int i = 0; i < x.size[0]; ++i) assert_true(ty_grid_voxel(a, i, j, k) == ty_grid_voxel(b, i, j, k));
}

static void round_trips_are_exact_in_every_locale(void** state) {
    (void)state;
    static const double translate[3] = {-10, 20, 0.1}, rotate[3] = {30, -40, 110}, scale[3] = {0.1, 0.25, 3};
    const ty_affine map = ty_affine_compose(translate, rotate, scale);
    ty_grid* grid = make_grid(&map);
    setlocale(LC_ALL, "de_DE.UTF-8"); /* where it is installed */
    for (int gzip = 0; gzip < 2; ++gzip) {
        assert_int_equal(ty_nrrd_write(context, grid, (ty_nrrd_codec)gzip, "trip.nrrd"), TY_OK);
        ty_grid* back = read_component("trip.nrrd", 0);
        assert_same(back, grid);
        assert_true(ty_grid_get_info(back).placed);
        ty_grid_release(back);
    }
    setlocale(LC_ALL, "C");
    ty_grid_release(grid);
}

/* VDB to NRRD and back: nothing changes but that surrounding background is cut off. */
static void the_way_through_vdb_is_exact(void** state) {
    (void)state;
    static const double translate[3] = {1, 2, 3}, rotate[3] = {0, 0, 0}, scale[3] = {0.5, 0.5, 0.25};
    const ty_affine map = ty_affine_compose(translate, rotate, scale);
    ty_grid *grid = make_grid(&map), *vdb = NULL, *back = NULL;
    assert_int_equal(ty_vdb_write(context, grid, "density", "zip", "way.vdb"), TY_OK);
    assert_int_equal(ty_vdb_read(context, "way.vdb", "density", &vdb), TY_OK);
    assert_int_equal(ty_nrrd_write(context, vdb, TY_NRRD_CODEC_GZIP, "way.nrrd"), TY_OK);
    ty_grid* nrrd = read_component("way.nrrd", 0);
    assert_same(nrrd, grid);
    assert_int_equal(ty_vdb_write(context, nrrd, "density", "none", "back.vdb"), TY_OK);
    assert_int_equal(ty_vdb_read(context, "back.vdb", "density", &back), TY_OK);
    assert_same(back, grid);
    ty_grid_release(grid);
    ty_grid_release(vdb);
    ty_grid_release(nrrd);
    ty_grid_release(back);
}

static void every_type_and_byte_order_is_read(void** state) {
    (void)state;
    static const struct {
        const char* name;
        size_t size;
        uint64_t bits[2];
        float values[2];
        ty_grid_type type;
    } cases[] = {
        {"signed char", 1, {0x80, 0x7f}, {-128, 127}, TY_GRID_F16},
        {"uchar", 1, {0xff, 1}, {255, 1}, TY_GRID_F16},
        {"short", 2, {0x8001, 300}, {-32767, 300}, TY_GRID_F32},
        {"uint16", 2, {0xffff, 7}, {65535, 7}, TY_GRID_F32},
        {"int", 4, {0xfffffffe, 5}, {-2, 5}, TY_GRID_F32},
        {"unsigned int", 4, {0xffffff00, 5}, {4294967040.0f, 5}, TY_GRID_F32},
        {"int64", 8, {UINT64_MAX, 9}, {-1, 9}, TY_GRID_F32},
        {"unsigned long long", 8, {(uint64_t)1 << 63, 9}, {0x1p63f, 9}, TY_GRID_F32},
        {"float", 4, {0x3fc00000, 0x7fc00000}, {1.5f, 0}, TY_GRID_F32}, /* NaN counts as 0 */
        {"double", 8, {0x3ff8000000000000, 0xc004000000000000}, {1.5f, -2.5f}, TY_GRID_F32},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i)
        for (int big = 0; big < 2; ++big) {
            uint8_t data[16];
            for (size_t v = 0; v < 2; ++v)
                for (size_t b = 0; b < cases[i].size; ++b)
                    data[v * cases[i].size + b] =
                        (uint8_t)(cases[i].bits[v] >> 8 * (big != 0 ? cases[i].size - 1 - b : b));
            char header[256];
            snprintf(header, sizeof header,
                     "NRRD0001\ntype: %s\ndimension: 3\nsizes: 2 1 1\nencoding: raw\nendian: %s\n\n", cases[i].name,
                     big != 0 ? "big" : "little");
            put_nrrd("type.nrrd", header, data, 2 * cases[i].size);
            ty_grid* grid = read_component("type.nrrd", 0);
            const ty_grid_info info = ty_grid_get_info(grid);
            assert_int_equal(info.type, cases[i].type);
            assert_true(info.placed && info.index_to_local.m[0] == 1 && info.index_to_local.m[3] == 0);
            for (int v = 0; v < 2; ++v)
                if (ty_grid_voxel(grid, v, 0, 0) != cases[i].values[v])
                    fail_msg("%s: %g, not %g", cases[i].name, (double)ty_grid_voxel(grid, v, 0, 0),
                             (double)cases[i].values[v]);
            ty_grid_release(grid);
        }
}

static void every_encoding_is_read(void** state) {
    (void)state;
    static const uint8_t plain[] = {1, 2, 3, 4, 5, 6};
    uint8_t packed[128];
    z_stream z = {.next_in = (Bytef*)plain, .avail_in = 6, .next_out = packed, .avail_out = sizeof packed};
    assert_int_equal(deflateInit2(&z, 6, Z_DEFLATED, 15 + 16, 8, Z_DEFAULT_STRATEGY), Z_OK);
    assert_int_equal(deflate(&z, Z_FINISH), Z_STREAM_END);
    deflateEnd(&z);
    static const char head[] =
        "NRRD0004\r\n# a comment\r\ntype: uint8\r\nsizes: 3 2 1\r\ndimension: 3\r\nkey:=value\r\n";
    static const struct {
        const char* rest;
        int kind; /* of data: 0 plain, 1 packed, 2 text */
    } cases[] = {{"encoding: raw\r\n\r\n", 0},
                 {"encoding: gzip\r\n\r\n", 1},
                 {"encoding: gz\nline skip: 1\n\nfirst line\n", 1},
                 {"encoding: raw\nline skip: 2\nbyte skip: 3\n\n\nx\nabc", 0},
                 {"encoding: raw\nbyte skip: -1\n\nof any length", 0},
                 {"encoding: ascii\n\n", 2},
                 {"encoding: TXT\nbyte skip: 4\n\n9 9 ", 2}};
    static const char text[] = "1 2,3\n4.0 \t 5e0\r\n6\n";
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        char header[512];
        snprintf(header, sizeof header, "%s%s", head, cases[i].rest);
        if (cases[i].kind == 0) put_nrrd("encoding.nrrd", header, plain, sizeof plain);
        if (cases[i].kind == 1) put_nrrd("encoding.nrrd", header, packed, z.total_out);
        if (cases[i].kind == 2) put_nrrd("encoding.nrrd", header, text, sizeof text - 1);
        ty_grid* grid = read_component("encoding.nrrd", 0);
        for (int v = 0; v < 6; ++v) assert_true(ty_grid_voxel(grid, v % 3, v / 3, 0) == (float)(v + 1));
        ty_grid_release(grid);
    }
}

static void components_come_first_or_last(void** state) {
    (void)state;
    static const struct {
        const char* fields;
        int32_t components;
        bool last;
    } cases[] = {{"sizes: 3 2 2 1\n", 3, false},
                 {"sizes: 2 5 6 3\n", 2, false},
                 {"sizes: 5 2 6 3\n", 3, true},
                 {"sizes: 2 5 6 7\nkinds: domain domain domain list\n", 7, true},
                 {"sizes: 9 2 2 2\nkinds: vector space space space\n", 9, false},
                 {"sizes: 3 2 2 2\nkinds: RGB-color domain domain domain\n"
                  "space directions: none (2,0,0) (0,3,0) (0,0,4)\nspace dimension: 3\n",
                  3, false},
                 {"sizes: 2 2 2 3\nkinds: domain domain domain vector\nspacings: 2 3 4 nan\n", 3, true}};
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        char header[512];
        snprintf(header, sizeof header, "NRRD0005\ntype: uchar\ndimension: 4\n%sencoding: raw\n\n", cases[i].fields);
        int sizes[4];
        assert_int_equal(sscanf(cases[i].fields, "sizes: %d %d %d %d", &sizes[0], &sizes[1], &sizes[2], &sizes[3]), 4);
        const int total = sizes[0] * sizes[1] * sizes[2] * sizes[3], voxels = total / cases[i].components;
        uint8_t data[512];
        for (int v = 0; v < total; ++v) data[v] = (uint8_t)v;
        put_nrrd("parts.nrrd", header, data, (size_t)total);
        const ty_volume_def def = ty_default_volume_def();
        int32_t components = 0;
        assert_int_equal(ty_volume_components(context, "parts.nrrd", &def, &components), TY_OK);
        assert_int_equal(components, cases[i].components);
        for (int32_t c = 0; c < components; ++c) {
            ty_grid* grid = read_component("parts.nrrd", c);
            const ty_grid_info info = ty_grid_get_info(grid);
            assert_int_equal(info.size[0], sizes[cases[i].last ? 0 : 1]);
            const int second = cases[i].last ? voxels * c + 1 : components + c;
            assert_true(ty_grid_voxel(grid, 1, 0, 0) == (float)(second % 256));
            if (i >= 5) assert_true(info.index_to_local.m[5] == 3 && info.index_to_local.m[10] == 4);
            ty_grid_release(grid);
        }
    }
    ty_volume_def def = ty_default_volume_def();
    def.component = 3;
    ty_grid* grid = NULL;
    assert_failed(context, ty_volume_read(context, "parts.nrrd", &def, &grid), TY_ERROR_INPUT, "parts.nrrd",
                  "component 3");
}

static void placement_is_the_files(void** state) {
    (void)state;
    static const struct {
        const char* fields;
        double map[12];
    } cases[] = {
        {"spacings: 1.5 nan 2e-1\n", {1.5, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0.2, 0}},
        {"space: LPS\nspace directions: (0,2,0) (-1, 0, 0) ( 0.5 ,0,3)\nspace origin: (7,-8,9.25)\n",
         {0, -1, 0.5, 7, 2, 0, 0, -8, 0, 0, 3, 9.25}},
        {"SPACE DIRECTIONS: (1,0,0) (0,1,0) (0,0,-2)\n", {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, -2, 0}},
        {"spacings: 2 2 2\nspace origin: (1,2,3)\nthicknesses: nan 1 1\ncenterings: cell cell cell\n",
         {2, 0, 0, 1, 0, 2, 0, 2, 0, 0, 2, 3}},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        char header[512];
        snprintf(header, sizeof header, "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 1 1 1\n%sencoding: raw\n\n",
                 cases[i].fields);
        put_nrrd("place.nrrd", header, "x", 1);
        ty_grid* grid = read_component("place.nrrd", 0);
        const ty_grid_info info = ty_grid_get_info(grid);
        for (int m = 0; m < 12; ++m) assert_true(info.index_to_local.m[m] == cases[i].map[m]);
        assert_true(info.placed);
        ty_grid_release(grid);
    }
}

static void data_lies_beside_or_below_the_header(void** state) {
    (void)state;
    static const char head[] = "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 2 1 1\nencoding: raw\ndata file: ";
    char header[512];
    mkdir("below", 0777);
    put_file("beside.raw", "AB", 2);
    put_file("below/deep..raw", "CD", 2);
    static const char* const names[] = {"beside.raw", "./beside.raw", "below/deep..raw"};
    for (int i = 0; i < 3; ++i) {
        snprintf(header, sizeof header, "%s%s\n", head, names[i]);
        put_nrrd("detached.nhdr", header, NULL, 0);
        ty_grid* grid = read_component("detached.nhdr", 0);
        assert_true(ty_grid_voxel(grid, 1, 0, 0) == (float)(i < 2 ? 'B' : 'D'));
        ty_grid_release(grid);
    }
    snprintf(header, sizeof header, "%sdeep..raw", head); /* without an end of line */
    put_nrrd("below/inside.nhdr", header, NULL, 0);
    ty_grid* grid = read_component("below/inside.nhdr", 0);
    assert_true(ty_grid_voxel(grid, 0, 0, 0) == 'C');
    ty_grid_release(grid);
    static const char* const outside[] = {"../beside.raw", "below/../../x.raw", "/etc/hostname", "..", ""};
    for (int i = 0; i < 5; ++i) {
        snprintf(header, sizeof header, "%s%s\n", head, outside[i]);
        put_nrrd("detached.nhdr", header, NULL, 0);
        assert_refused("detached.nhdr", "not in the folder of the header");
    }
    snprintf(header, sizeof header, "%sslice%%03d.raw 1 9 1\n", head);
    put_nrrd("detached.nhdr", header, NULL, 0);
    assert_refused("detached.nhdr", "more than one file");
    snprintf(header, sizeof header, "%sgone.raw\n", head);
    put_nrrd("detached.nhdr", header, NULL, 0);
    const ty_volume_def def = ty_default_volume_def();
    grid = NULL;
    assert_failed(context, ty_volume_read(context, "detached.nhdr", &def, &grid), TY_ERROR_FILE, "gone.raw",
                  "No such file");
}

/* Images are volumes one voxel deep; axes of times and axes without a direction are components. */
static void images_and_times_are_read(void** state) {
    (void)state;
    static const uint8_t data[] = {1, 2, 3, 4, 5, 6};
    put_nrrd("flat.nrrd",
             "NRRD0004\ntype: uint8\ndimension: 2\nsizes: 3 2\nspace dimension: 2\nspace directions: (2,0) (0,4)\n"
             "space origin: (5,6)\nencoding: raw\n\n",
             data, sizeof data);
    ty_grid* grid = read_component("flat.nrrd", 0);
    ty_grid_info info = ty_grid_get_info(grid);
    static const double map[] = {2, 0, 0, 5, 0, 4, 0, 6, 0, 0, 1, 0};
    assert_int_equal(info.size[0], 3);
    assert_int_equal(info.size[1], 2);
    assert_int_equal(info.size[2], 1);
    assert_memory_equal(info.index_to_local.m, map, sizeof map);
    assert_true(info.max == 6);
    ty_grid_release(grid);

    put_nrrd("colors.nrrd",
             "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 3 1 2\nkinds: RGB-color space space\n"
             "space directions: none none none\nencoding: raw\n\n",
             data, sizeof data);
    grid = read_component("colors.nrrd", 1);
    info = ty_grid_get_info(grid);
    assert_int_equal(info.size[1], 2);
    assert_true(info.min == 2 && info.max == 5);
    ty_grid_release(grid);

    put_nrrd("times.nrrd",
             "NRRD0004\ntype: uint8\ndimension: 4\nsizes: 1 1 1 6\n"
             "space directions: (1,0,0) (0,1,0) (0,0,1) none\nencoding: raw\n\n",
             data, sizeof data);
    grid = read_component("times.nrrd", 4);
    assert_true(ty_grid_get_info(grid).min == 5);
    ty_grid_release(grid);
}

static void broken_headers_are_refused(void** state) {
    (void)state;
    static const struct {
        const char *text, *matter;
    } cases[] = {
        {"NRRD0006\ntype: uint8\n\n", "version 0006"},
        {"NRRD", "not an NRRD file"},
        {"NRRD0004\ndimension: 3\nsizes: 1 1 1\nencoding: raw\n\nx", "field type is missing"},
        {"NRRD0004\ntype: block\ndimension: 3\nsizes: 1 1 1\nencoding: raw\n\nx", "\"block\" is not a type"},
        {"NRRD0004\ntype: uint8\ndimension: 5\nsizes: 1 1 1 1 1\nencoding: raw\n\nx", "is not 2, 3 or 4"},
        {"NRRD0004\ntype: uint8\ndimension: 3\nsizes: 1 1\nencoding: raw\n\nx", "one whole number per axis"},
        {"NRRD0004\ntype: uint8\ndimension: 3\nsizes: 1 1 1 1\nencoding: raw\n\nx", "one whole number per axis"},
        {"NRRD0004\ntype: uint8\ndimension: 3\nsizes: 1 0 1\nencoding: raw\n\nx", "without samples"},
        {"NRRD0004\ntype: uint8\ndimension: 3\nsizes: 1 -4 1\nencoding: raw\n\nx", "without samples"},
        {"NRRD0004\ntype: uint8\ndimension: 3\nsizes: 99999999999 1 1\nencoding: raw\n\nx", "spans"},
        {"NRRD0004\ntype: uint8\ndimension: 3\nsizes: 99999999999999999999 1 1\nencoding: raw\n\nx", "sizes"},
        {"NRRD0004\ntype: uint8\ndimension: 3\nsizes: 16000 16000 16000\nencoding: raw\n\nx", "spans"},
        {"NRRD0004\ntype: double\ndimension: 3\nsizes: 1500 1500 1500\nendian: big\nencoding: gzip\n\nx", "cut short"},
        {"NRRD0004\ntype: uint8\ndimension: 3\nsizes: 1500 1500 1500\nencoding: text\n\n1", "cut short"},
        {"NRRD0004\ntype: uint8\ndimension: 4\nsizes: 9 9 9 9\nencoding: raw\n\nx",
         "neither the first nor the last is one"},
        {"NRRD0004\ntype: uint8\ndimension: 3\nsizes: 1 1 1\nencoding: bzip2\n\nx", "\"bzip2\" is not one"},
        {"NRRD0004\ntype: float\ndimension: 3\nsizes: 1 1 1\nencoding: raw\n\nxxxx", "endian is missing"},
        {"NRRD0004\ntype: float\ndimension: 3\nsizes: 1 1 1\nendian: middle\nencoding: raw\n\nxxxx", "neither little"},
        {"NRRD0004\ntype: uint8\ndimension: 3\nsizes: 1 1 1\nspacings: 1 -1 1\nencoding: raw\n\nx", "outside (0, "},
        {"NRRD0004\ntype: uint8\ndimension: 3\nsizes: 1 1 1\nspacings: 1 1\nencoding: raw\n\nx", "one number per axis"},
        {"NRRD0004\ntype: uint8\ndimension: 3\nsizes: 1 1 1\nspace directions: (1,0,0) (2,0,0) (0,0,1)\n"
         "encoding: raw\n\nx",
         "cannot be inverted"},
        {"NRRD0004\ntype: uint8\ndimension: 3\nsizes: 1 1 1\nspace directions: (1,0) (0,1) (1,1)\nencoding: raw\n\nx",
         "vector of three numbers"},
        {"NRRD0004\ntype: uint8\ndimension: 3\nsizes: 1 1 1\nspace directions: (1,0,0) none none\n"
         "encoding: raw\n\nx",
         "vector of three numbers"},
        {"NRRD0004\ntype: uint8\ndimension: 3\nsizes: 1 1 1\nspace origin: (1,inf,0)\nencoding: raw\n\nx",
         "space origin"},
        {"NRRD0004\ntype: uint8\ntype: uint8\ndimension: 3\nsizes: 1 1 1\nencoding: raw\n\nx", "twice"},
        {"NRRD0004\ntype: uint8\nspaceings: 1\ndimension: 3\nsizes: 1 1 1\nencoding: raw\n\nx", "\"spaceings\""},
        {"NRRD0004\ntype: uint8\nnonsense\ndimension: 3\nsizes: 1 1 1\nencoding: raw\n\nx", "not a field"},
        {"NRRD0004\ntype: uint8\ndimension: 3\nsizes: 1 1 1\nline skip: 9\nencoding: raw\n\nx", "fewer lines"},
        {"NRRD0004\ntype: uint8\ndimension: 3\nsizes: 1 1 1\nline skip: -1\nencoding: raw\n\nx", "line skip"},
        {"NRRD0004\ntype: uint8\ndimension: 3\nsizes: 1 1 1\nbyte skip: -1\nencoding: gzip\n\nx", "raw data only"},
        {"NRRD0004\ntype: uint8\ndimension: 3\nsizes: 1 1 1\nbyte skip: 9999999999\nencoding: raw\n\nx", "cut short"},
        {"NRRD0004\ntype: uint8\ndimension: 3\nsizes: 2 1 1\nencoding: raw\n\nx", "cut short: 1 bytes"},
        {"NRRD0004\ntype: uint8\ndimension: 3\nsizes: 1 1 1\nencoding: raw\n\nxx", "more than 1 bytes"},
        {"NRRD0004\ntype: uint8\ndimension: 3\nsizes: 2 1 1\nencoding: text\n\n1 b", "1 numbers instead of 2"},
        {"NRRD0004\ntype: uint8\ndimension: 3\nsizes: 1 1 1\nencoding: text\n\n1 2", "follows"},
        {"NRRD0004\ntype: uint8\ndimension: 3\nsizes: 1 1 1\nencoding: gzip\n\nno gzip", "gzip data is damaged"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        put_nrrd("broken.nrrd", cases[i].text, NULL, 0);
        assert_refused("broken.nrrd", cases[i].matter);
    }
}

static void cut_gzip_is_refused(void** state) {
    (void)state;
    const ty_affine map = ty_affine_identity();
    ty_grid* grid = make_grid(&map);
    assert_int_equal(ty_nrrd_write(context, grid, TY_NRRD_CODEC_GZIP, "whole.nrrd"), TY_OK);
    ty_grid_release(grid);
    size_t size;
    uint8_t* bytes = get_file("whole.nrrd", &size);
    for (size_t length = 0; length < size; ++length) {
        put_file("cut.nrrd", bytes, length);
        assert_refused("cut.nrrd", NULL);
    }
    free(bytes);
}

static void failed_writes_leave_the_old_file(void** state) {
    (void)state;
    static const char old[] = "the old content";
    const ty_affine map = ty_affine_identity();
    ty_grid* grid = make_grid(&map);
    put_file("old.nrrd", old, sizeof old);
    little_space(100);
    const ty_result result = ty_nrrd_write(context, grid, TY_NRRD_CODEC_RAW, "old.nrrd");
    all_space();
    assert_failed(context, result, TY_ERROR_FILE, "old.nrrd", NULL);
    assert_file_holds("old.nrrd", old, sizeof old);
    assert_int_equal(remove_temporary_files(), 0);
    ty_grid_release(grid);
}

static void real_copies_of_a_cloud_agree(void** state) {
    (void)state;
    char path[1024];
    ty_grid* grids[2];
    grids[0] = read_component(data_path("volumes/wdas_cloud_sixteenth_126x86x154_f32.nrrd", path), 0);
    grids[1] = read_component(data_path("volumes/wdas_cloud_sixteenth.vdb", path), 0);
    const ty_grid_info nrrd = ty_grid_get_info(grids[0]), vdb = ty_grid_get_info(grids[1]);
    assert_memory_equal(nrrd.size, vdb.size, sizeof nrrd.size);
    for (int a = 0; a < 3; ++a) assert_true(fabs(nrrd.index_to_local.m[5 * a] - vdb.index_to_local.m[5 * a]) < 1e-4);
    size_t wrong = 0;
    for (int z = 0; z < nrrd.size[2]; ++z)
        for (int y = 0; y < nrrd.size[1]; ++y)
            for (int x = 0; x < nrrd.size[0]; ++x)
                wrong += ty_grid_voxel(grids[0], x, y, z) != ty_grid_voxel(grids[1], x, y, z);
    assert_int_equal(wrong, 0);
    ty_grid_release(grids[0]);
    ty_grid_release(grids[1]);
}

static void real_head_keeps_its_spacing(void** state) {
    (void)state;
    char path[1024];
    ty_grid* grid = read_component(data_path("volumes/headsq_ct_64x64x93_i16.nrrd", path), 0);
    const ty_grid_info info = ty_grid_get_info(grid);
    assert_true(info.size[0] == 64 && info.size[1] == 64 && info.size[2] == 93);
    static const double expected[12] = {3.2, 0, 0, 0, 0, 3.2, 0, 0, 0, 0, 1.5, 0};
    assert_memory_equal(info.index_to_local.m, expected, sizeof expected);
    assert_true(info.min == 0 && info.max == 3926);
    ty_grid_release(grid);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(round_trips_are_exact_in_every_locale),
        cmocka_unit_test(the_way_through_vdb_is_exact),
        cmocka_unit_test(every_type_and_byte_order_is_read),
        cmocka_unit_test(every_encoding_is_read),
        cmocka_unit_test(components_come_first_or_last),
        cmocka_unit_test(placement_is_the_files),
        cmocka_unit_test(data_lies_beside_or_below_the_header),
        cmocka_unit_test(images_and_times_are_read),
        cmocka_unit_test(broken_headers_are_refused),
        cmocka_unit_test(cut_gzip_is_refused),
        cmocka_unit_test(failed_writes_leave_the_old_file),
        cmocka_unit_test(real_copies_of_a_cloud_agree),
        cmocka_unit_test(real_head_keeps_its_spacing),
    };
    return cmocka_run_group_tests(tests, start_small, stop);
}
