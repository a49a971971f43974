/* TIFF stacks: types, compressions, strips and tiles, planes, descriptions of ImageJ and OME, broken files. */
#include "strict_fixture.h"

#include <tyndall/io.h>

#include <math.h>

#if TYNDALL_TIFF

#include "io/volumes/tiff_stack.h"

#include <tiffio.h>

enum { NX = 20, NY = 18, TILE = 16, SAMPLES_MAX = 3 };

/* The form of the pages of a stack, and what its value is at a place: a whole number below 200. */
typedef struct stack_form {
    int bits, format, compression, samples;
    bool tiled, separate, big_endian, float_predictor;
    int pages;
    const char* description;
    float resolution;
} stack_form;

static int value_at(int x, int y, int page, int sample) {
    return (x * 3 + y * 5 + page * 17 + sample * 29) % 200;
}

/* Stores a value as a sample of the form. */
static void store(const stack_form* form, void* row, int index, int value) {
    if (form->bits == 8) ((uint8_t*)row)[index] = (uint8_t)value;
    if (form->bits == 16 && form->format == SAMPLEFORMAT_IEEEFP)
        ((uint16_t*)row)[index] = (uint16_t)(value == 0 ? 0 : value % 2 == 0 ? 0x4000 : 0x3c00); /* 0, 2 or 1 */
    else if (form->bits == 16)
        ((uint16_t*)row)[index] = (uint16_t)(form->format == SAMPLEFORMAT_INT ? -value : value * 300);
    if (form->bits == 32 && form->format == SAMPLEFORMAT_IEEEFP) ((float*)row)[index] = (float)value / 8;
    if (form->bits == 32 && form->format != SAMPLEFORMAT_IEEEFP) ((uint32_t*)row)[index] = (uint32_t)value * 1000000u;
    if (form->bits == 64) ((double*)row)[index] = (double)value * 1e10;
}

/* The value that is read of it. */
static double expected(const stack_form* form, int value) {
    if (form->bits == 8) return value;
    if (form->bits == 16 && form->format == SAMPLEFORMAT_IEEEFP) return value == 0 ? 0 : value % 2 == 0 ? 2 : 1;
    if (form->bits == 16) return form->format == SAMPLEFORMAT_INT ? -value : value * 300;
    if (form->bits == 32) return form->format == SAMPLEFORMAT_IEEEFP ? value / 8.0 : value * 1e6;
    return value * 1e10;
}

static void set_fields(TIFF* tiff, const stack_form* form, int page) {
    TIFFSetField(tiff, TIFFTAG_IMAGEWIDTH, NX);
    TIFFSetField(tiff, TIFFTAG_IMAGELENGTH, NY);
    TIFFSetField(tiff, TIFFTAG_BITSPERSAMPLE, form->bits);
    TIFFSetField(tiff, TIFFTAG_SAMPLESPERPIXEL, form->samples);
    TIFFSetField(tiff, TIFFTAG_SAMPLEFORMAT, form->format);
    TIFFSetField(tiff, TIFFTAG_COMPRESSION, form->compression);
    TIFFSetField(tiff, TIFFTAG_PHOTOMETRIC, form->samples == 3 ? PHOTOMETRIC_RGB : PHOTOMETRIC_MINISBLACK);
    TIFFSetField(tiff, TIFFTAG_PLANARCONFIG, form->separate ? PLANARCONFIG_SEPARATE : PLANARCONFIG_CONTIG);
    if (form->float_predictor) TIFFSetField(tiff, TIFFTAG_PREDICTOR, PREDICTOR_FLOATINGPOINT);
    if (form->resolution > 0) {
        TIFFSetField(tiff, TIFFTAG_XRESOLUTION, (double)form->resolution);
        TIFFSetField(tiff, TIFFTAG_YRESOLUTION, (double)form->resolution / 2);
    }
    if (page == 0 && form->description != NULL) TIFFSetField(tiff, TIFFTAG_IMAGEDESCRIPTION, form->description);
    if (form->tiled) {
        TIFFSetField(tiff, TIFFTAG_TILEWIDTH, TILE);
        TIFFSetField(tiff, TIFFTAG_TILELENGTH, TILE);
    } else {
        TIFFSetField(tiff, TIFFTAG_ROWSPERSTRIP, 5);
    }
}

static void write_rows(TIFF* tiff, const stack_form* form, int page) {
    const int planes = form->separate ? form->samples : 1, together = form->separate ? 1 : form->samples;
    for (int plane = 0; plane < planes; ++plane)
        for (int y = 0; y < NY; ++y) {
            double row[NX * SAMPLES_MAX];
            for (int x = 0; x < NX; ++x)
                for (int s = 0; s < together; ++s) store(form, row, x * together + s, value_at(x, y, page, plane + s));
            assert_int_equal(TIFFWriteScanline(tiff, row, (uint32_t)y, (uint16_t)plane), 1);
        }
}

static void write_tiles(TIFF* tiff, const stack_form* form, int page) {
    const int planes = form->separate ? form->samples : 1, together = form->separate ? 1 : form->samples;
    for (int plane = 0; plane < planes; ++plane)
        for (int y = 0; y < NY; y += TILE)
            for (int x = 0; x < NX; x += TILE) {
                double tile[TILE * TILE * SAMPLES_MAX];
                for (int i = 0; i < TILE * TILE; ++i)
                    for (int s = 0; s < together; ++s)
                        store(form, tile, i * together + s, value_at(x + i % TILE, y + i / TILE, page, plane + s));
                assert_true(TIFFWriteTile(tiff, tile, (uint32_t)x, (uint32_t)y, 0, (uint16_t)plane) > 0);
            }
}

static void write_stack(const char* path, const stack_form* form) {
    remove(path);
    TIFF* tiff = TIFFOpen(path, form->big_endian ? "wb" : "wl");
    assert_non_null(tiff);
    for (int page = 0; page < form->pages; ++page) {
        set_fields(tiff, form, page);
        if (form->tiled)
            write_tiles(tiff, form, page);
        else
            write_rows(tiff, form, page);
        assert_int_equal(TIFFWriteDirectory(tiff), 1);
    }
    TIFFClose(tiff);
}

static ty_grid* read_component(const char* path, int component) {
    ty_volume_def def = ty_default_volume_def();
    def.component = component;
    ty_grid* grid = NULL;
    if (ty_volume_read(context, path, &def, &grid) != TY_OK) fail_msg("%s: %s", path, ty_take_error(context));
    return grid;
}

/* Page k of the grid is page first + step * k of the file. */
static void assert_pages(const ty_grid* grid, const stack_form* form, int first, int step, int sample) {
    const ty_grid_info info = ty_grid_get_info(grid);
    assert_int_equal(info.size[0], NX);
    assert_int_equal(info.size[1], NY);
    for (int k = 0; k < info.size[2]; ++k)
        for (int y = 0; y < NY; ++y)
            for (int x = 0; x < NX; ++x) {
                const double right = expected(form, value_at(x, y, first + step * k, sample));
                const double found = (double)ty_grid_voxel(grid, x, y, k);
                if (found != (double)(float)right) fail_msg("voxel %d %d %d is %g, not %g", x, y, k, found, right);
            }
}

static int32_t components_of(const char* path) {
    ty_volume_def def = ty_default_volume_def();
    int32_t components = 0;
    if (ty_volume_components(context, path, &def, &components) != TY_OK) fail_msg("%s", ty_take_error(context));
    return components;
}

static void every_kind_of_page_is_read(void** state) {
    (void)state;
    static const struct {
        int bits, format;
    } types[] = {{8, SAMPLEFORMAT_UINT},   {16, SAMPLEFORMAT_UINT},   {16, SAMPLEFORMAT_INT},
                 {32, SAMPLEFORMAT_UINT},  {16, SAMPLEFORMAT_IEEEFP}, {32, SAMPLEFORMAT_IEEEFP},
                 {64, SAMPLEFORMAT_IEEEFP}};
    static const int compressions[] = {COMPRESSION_NONE, COMPRESSION_LZW, COMPRESSION_ADOBE_DEFLATE,
                                       COMPRESSION_PACKBITS, COMPRESSION_ZSTD};
    int read = 0;
    for (size_t c = 0; c < sizeof compressions / sizeof compressions[0]; ++c) {
        if (!TIFFIsCODECConfigured((uint16_t)compressions[c])) continue;
        for (size_t t = 0; t < sizeof types / sizeof types[0]; ++t)
            for (int variant = 0; variant < 4; ++variant) {
                const stack_form form = {.bits = types[t].bits,
                                         .format = types[t].format,
                                         .compression = compressions[c],
                                         .samples = 1 + 2 * (variant / 2),
                                         .tiled = variant % 2 == 1,
                                         .separate = variant == 3,
                                         .big_endian = variant % 2 == 0,
                                         .pages = 2};
                write_stack("kinds.tif", &form);
                assert_int_equal(components_of("kinds.tif"), form.samples);
                for (int s = 0; s < form.samples; ++s) {
                    ty_grid* grid = read_component("kinds.tif", s);
                    assert_int_equal(ty_grid_get_info(grid).size[2], 2);
                    assert_false(ty_grid_get_info(grid).placed);
                    assert_pages(grid, &form, 0, 1, s);
                    ty_grid_release(grid);
                }
                ++read;
            }
    }
    assert_true(read >= 84);
}

static void assert_spacing(const ty_grid* grid, double x, double y, double z) {
    const ty_grid_info info = ty_grid_get_info(grid);
    const double right[3] = {x, y, z};
    assert_true(info.placed);
    for (int a = 0; a < 3; ++a) {
        if (!(fabs(info.index_to_local.m[5 * a] - right[a]) < 1e-6))
            fail_msg("spacing %g", info.index_to_local.m[5 * a]);
        assert_true(info.index_to_local.m[4 * a + 3] == 0);
    }
}

static void imagej_tells_spacing_and_channels(void** state) {
    (void)state;
    stack_form form = {.bits = 16,
                       .format = SAMPLEFORMAT_UINT,
                       .compression = COMPRESSION_NONE,
                       .samples = 1,
                       .pages = 6,
                       .resolution = 4,
                       .description = "ImageJ=1.53t\nimages=6\nchannels=2\nslices=3\nhyperstack=true\nunit=\\u00B5m\n"
                                      "spacing=1.5\nloop=false\n"};
    write_stack("imagej.tif", &form);
    assert_int_equal(components_of("imagej.tif"), 2);
    for (int c = 0; c < 2; ++c) {
        ty_grid* grid = read_component("imagej.tif", c);
        assert_int_equal(ty_grid_get_info(grid).size[2], 3);
        assert_pages(grid, &form, c, 2, 0); /* channels are the fastest */
        assert_spacing(grid, 0.25, 0.5, 1.5);
        ty_grid_release(grid);
    }
}

/* Large stacks of ImageJ have one page; the other planes follow its samples. */
static void planes_may_follow_one_page(void** state) {
    (void)state;
    enum { PLANES = 4, PLANE = 2 * NX * NY };
    for (int big = 0; big < 2; ++big) {
        const stack_form form = {.bits = 16,
                                 .format = SAMPLEFORMAT_UINT,
                                 .compression = COMPRESSION_NONE,
                                 .samples = 1,
                                 .big_endian = big == 1,
                                 .pages = 1,
                                 .description = "ImageJ=1.53t\nimages=4\nslices=4\n"};
        remove("one.tif");
        TIFF* tiff = TIFFOpen("one.tif", big == 1 ? "wb" : "wl");
        set_fields(tiff, &form, 0);
        TIFFSetField(tiff, TIFFTAG_ROWSPERSTRIP, NY);
        write_rows(tiff, &form, 0);
        TIFFWriteDirectory(tiff);
        TIFFClose(tiff);
        /* The page's samples again at the end of the file, with the others, and the strip's offset set to them. */
        size_t size;
        uint8_t* bytes = get_file("one.tif", &size);
        uint8_t* larger = calloc(1, size + PLANES * PLANE);
        assert_non_null(larger);
        memcpy(larger, bytes, size);
        for (int p = 0; p < PLANES; ++p)
            for (int i = 0; i < NX * NY; ++i) {
                uint16_t sample;
                store(&form, &sample, 0, value_at(i % NX, i / NX, p, 0));
                const size_t at = size + (size_t)p * PLANE + 2 * (size_t)i;
                larger[at] = (uint8_t)(big == 1 ? sample >> 8 : sample);
                larger[at + 1] = (uint8_t)(big == 1 ? sample : sample >> 8);
            }
        bool found = false;
        for (size_t at = 8; at + 12 <= size && !found; at += 2) { /* tag 273, StripOffsets, of one 32-bit number */
            static const uint8_t heads[2][8] = {{0x11, 1, 4, 0, 1, 0, 0, 0}, {1, 0x11, 0, 4, 0, 0, 0, 1}};
            if (memcmp(larger + at, heads[big], 8) != 0) continue;
            for (size_t i = 0; i < 4; ++i) larger[at + 8 + (big == 1 ? 3 - i : i)] = (uint8_t)(size >> 8 * i);
            found = true;
        }
        assert_true(found);
        put_file("one.tif", larger, size + PLANES * PLANE);
        ty_grid* grid = read_component("one.tif", 0);
        assert_int_equal(ty_grid_get_info(grid).size[2], PLANES);
        assert_pages(grid, &form, 0, 1, 0);
        ty_grid_release(grid);
        put_file("one.tif", larger, size + PLANES * PLANE - 1);
        ty_volume_def def = ty_default_volume_def();
        assert_failed(context, ty_volume_read(context, "one.tif", &def, &grid), TY_ERROR_INPUT, "one.tif", "cut short");
        free(bytes);
        free(larger);
    }
}

static void ome_tells_order_and_spacing(void** state) {
    (void)state;
    stack_form form = {
        .bits = 8,
        .format = SAMPLEFORMAT_UINT,
        .compression = COMPRESSION_LZW,
        .samples = 1,
        .pages = 6,
        .description = "<?xml version=\"1.0\"?><OME xmlns=\"http://www.openmicroscopy.org/Schemas/OME/2016-06\">"
                       "<Image ID=\"Image:0\"><Pixels ID=\"Pixels:0\" DimensionOrder=\"XYZCT\" SizeC=\"2\" SizeT=\"1\" "
                       "SizeX=\"20\" SizeY=\"18\" SizeZ=\"3\" Type=\"uint8\" PhysicalSizeX=\"200\" "
                       "PhysicalSizeXUnit=\"nm\" PhysicalSizeY=\"0.3\" PhysicalSizeZ=\"0.001\" "
                       "PhysicalSizeZUnit=\"mm\"><TiffData/></Pixels></Image></OME>"};
    write_stack("ome.tif", &form);
    assert_int_equal(components_of("ome.tif"), 2);
    for (int c = 0; c < 2; ++c) {
        ty_grid* grid = read_component("ome.tif", c);
        assert_pages(grid, &form, 3 * c, 1, 0); /* slices are the fastest */
        assert_spacing(grid, 0.2, 0.3, 1);
        ty_grid_release(grid);
    }
    form.pages = 4;
    write_stack("ome.tif", &form);
    ty_volume_def def = ty_default_volume_def();
    ty_grid* grid = NULL;
    assert_failed(context, ty_volume_read(context, "ome.tif", &def, &grid), TY_ERROR_INPUT, "ome.tif", "6 planes");
}

static void descriptions_are_parsed(void** state) {
    (void)state;
    static const char* const others[] = {NULL,
                                         "",
                                         "ImageJ",
                                         "<OME",
                                         "<OME><Pixels",
                                         "<OME><Pixels SizeZ=\"\">",
                                         "ImageJ=\nslices=-3\nchannels=x\nunit="};
    for (size_t i = 0; i < sizeof others / sizeof others[0]; ++i) {
        const ty_stack_layout layout = ty_stack_parse(others[i]);
        assert_true(layout.slices == 1 && layout.channels == 1 && layout.times == 1);
    }
    const ty_stack_layout layout = ty_stack_parse("ImageJ=1\nimages=12\nframes=3\nunit=micron\n");
    assert_true(layout.slices == 4 && layout.times == 3);
    assert_string_equal(layout.unit, "micron");
    assert_true(ty_stack_parse("ImageJ=1\nspacing=-1.5\n").spacing[2] == 1.5);
}

/* More planes than numbers of 32 bits count. */
static void impossible_planes_are_refused(void** state) {
    (void)state;
    const stack_form form = {.bits = 8,
                             .format = SAMPLEFORMAT_UINT,
                             .compression = COMPRESSION_NONE,
                             .samples = 1,
                             .pages = 1,
                             .description = "ImageJ=1\nslices=16777216\nchannels=16777216\nframes=16777216\n"};
    ty_volume_def def = ty_default_volume_def();
    ty_grid* grid = NULL;
    int32_t components;
    write_stack("planes.tif", &form);
    assert_failed(context, ty_volume_read(context, "planes.tif", &def, &grid), TY_ERROR_INPUT, "planes.tif",
                  "up to 65536 values");
    assert_failed(context, ty_volume_components(context, "planes.tif", &def, &components), TY_ERROR_INPUT, "planes.tif",
                  "up to 65536 values");
}

static void broken_files_are_refused(void** state) {
    (void)state;
    stack_form form = {
        .bits = 16, .format = SAMPLEFORMAT_UINT, .compression = COMPRESSION_LZW, .samples = 1, .pages = 2};
    write_stack("whole.tif", &form);
    size_t size;
    uint8_t* bytes = get_file("whole.tif", &size);
    ty_volume_def def = ty_default_volume_def();
    ty_grid* grid = NULL;
    for (size_t cut = 1; cut < size; cut += 97) {
        put_file("cut.tif", bytes, size - cut);
        assert_failed(context, ty_volume_read(context, "cut.tif", &def, &grid), TY_ERROR_INPUT, "cut.tif", NULL);
    }
    free(bytes);
    remove("mixed.tif");
    TIFF* tiff = TIFFOpen("mixed.tif", "w");
    for (int page = 0; page < 2; ++page) {
        form.bits = 8 + 8 * page;
        set_fields(tiff, &form, page);
        write_rows(tiff, &form, page);
        TIFFWriteDirectory(tiff);
    }
    TIFFClose(tiff);
    assert_failed(context, ty_volume_read(context, "mixed.tif", &def, &grid), TY_ERROR_INPUT, "mixed.tif",
                  "page 2 has 20 x 18 pixels");
    /* A page of 16000 x 16000 pixels in a file of a few bytes. */
    remove("huge.tif");
    tiff = TIFFOpen("huge.tif", "w");
    form.compression = COMPRESSION_NONE;
    set_fields(tiff, &form, 0);
    TIFFSetField(tiff, TIFFTAG_IMAGEWIDTH, 16000);
    TIFFSetField(tiff, TIFFTAG_IMAGELENGTH, 16000);
    TIFFSetField(tiff, TIFFTAG_ROWSPERSTRIP, 16000);
    TIFFWriteRawStrip(tiff, 0, (void*)(uintptr_t) "abcd", 4);
    TIFFWriteDirectory(tiff);
    TIFFClose(tiff);
    assert_failed(context, ty_volume_read(context, "huge.tif", &def, &grid), TY_ERROR_INPUT, "huge.tif", NULL);
}

/* Pages are read slab by slab: a stack that is nearly empty takes memory for what is in it. */
static void large_stacks_are_never_dense(void** state) {
    (void)state;
    enum { SIDE = 200, PAGES = 160 };
    static uint16_t row[SIDE];
    remove("large.tif");
    TIFF* tiff = TIFFOpen("large.tif", "wl");
    assert_non_null(tiff);
    for (int k = 0; k < PAGES; ++k) {
        TIFFSetField(tiff, TIFFTAG_IMAGEWIDTH, SIDE);
        TIFFSetField(tiff, TIFFTAG_IMAGELENGTH, SIDE);
        TIFFSetField(tiff, TIFFTAG_BITSPERSAMPLE, 16);
        TIFFSetField(tiff, TIFFTAG_COMPRESSION, COMPRESSION_PACKBITS);
        TIFFSetField(tiff, TIFFTAG_PHOTOMETRIC, PHOTOMETRIC_MINISBLACK);
        for (int j = 0; j < SIDE; ++j) {
            row[50] = (uint16_t)(j == 60 ? 1000 + k : 0);
            assert_int_equal(TIFFWriteScanline(tiff, row, (uint32_t)j, 0), 1);
        }
        assert_int_equal(TIFFWriteDirectory(tiff), 1);
    }
    TIFFClose(tiff);
    memory.limit = (size_t)8 << 20; /* the dense array has 24.4 MiB */
    ty_grid* grid = read_component("large.tif", 0);
    assert_int_equal(ty_grid_get_info(grid).storage, TY_GRID_SPARSE);
    assert_int_equal(ty_grid_get_info(grid).active, PAGES);
    for (int k = 0; k < PAGES; ++k) assert_true(ty_grid_voxel(grid, 50, 60, k) == (float)(1000 + k));
    ty_grid_release(grid);
    memory.limit = (size_t)1 << 30;
}

static void memory_may_run_out(void** state) {
    (void)state;
    const stack_form form = {
        .bits = 16, .format = SAMPLEFORMAT_UINT, .compression = COMPRESSION_LZW, .samples = 1, .pages = 2};
    write_stack("short.tif", &form);
    assert_true(check_short_memory(context, &memory, read_volume, (void*)(uintptr_t) "short.tif") > 2);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_kind_of_page_is_read), cmocka_unit_test(imagej_tells_spacing_and_channels),
        cmocka_unit_test(planes_may_follow_one_page), cmocka_unit_test(ome_tells_order_and_spacing),
        cmocka_unit_test(descriptions_are_parsed),    cmocka_unit_test(impossible_planes_are_refused),
        cmocka_unit_test(broken_files_are_refused),   cmocka_unit_test(large_stacks_are_never_dense),
        cmocka_unit_test(memory_may_run_out),
    };
    TIFFSetErrorHandler(NULL);
    TIFFSetWarningHandler(NULL);
    return cmocka_run_group_tests(tests, start, stop);
}

#else

/* A build without the library says so. */
static void stacks_are_refused(void** state) {
    (void)state;
    put_file("a.tif", "II*\0", 4);
    ty_volume_def def = ty_default_volume_def();
    ty_grid* grid = NULL;
    assert_failed(context, ty_volume_read(context, "a.tif", &def, &grid), TY_ERROR_INPUT, "a.tif", "without");
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(stacks_are_refused)};
    return cmocka_run_group_tests(tests, start, stop);
}

#endif
