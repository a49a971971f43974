/* DICOM: order of slices, placement, samples, multi-frame files, series, compressed frames, broken files. */
#include "dicom_maker.h"
#include "strict_fixture.h"

#include "dicom_encoders.h"

#include <tyndall/io.h>

#include <math.h>
#include <sys/stat.h>
#include <unistd.h>
#include <zlib.h>

static dicom_writer writer;

/* An empty folder. */
static const char* fresh_folder(const char* name) {
    mkdir(name, 0777);
    DIR* folder = opendir(name);
    assert_non_null(folder);
    for (struct dirent* entry; (entry = readdir(folder)) != NULL;) {
        char path[512];
        snprintf(path, sizeof path, "%s/%s", name, entry->d_name);
        if (entry->d_name[0] != '.') unlink(path);
    }
    closedir(folder);
    return name;
}

static void put_slice(const char* path) {
    put_file(path, writer.bytes, writer.size);
}

/* A slice of 3 x 2 samples first, first + 1, ... */
static void make_slice(const dicom_form* form, const char* position, int64_t first) {
    int64_t samples[64];
    for (int i = 0; i < form->columns * form->rows * form->frames; ++i) samples[i] = first + i;
    dicom_slice(&writer, form, position);
    dicom_pixels(&writer, form, samples);
}

static ty_grid* read_series(const char* path, const char* series) {
    ty_volume_def def = ty_default_volume_def();
    def.series = series;
    ty_grid* grid = NULL;
    const ty_result result = ty_volume_read(context, path, &def, &grid);
    if (result != TY_OK) fail_msg("%s: %s", path, ty_take_error(context));
    return grid;
}

static void assert_refused(const char* path, const char* series, const char* words) {
    ty_volume_def def = ty_default_volume_def();
    def.series = series;
    ty_grid* grid = NULL;
    assert_failed(context, ty_volume_read(context, path, &def, &grid), TY_ERROR_INPUT, path, words);
    assert_null(grid);
}

/* Values slope * (first + index) + intercept of slices in order. */
static void assert_values(const ty_grid* grid, const int64_t* firsts, int slices, double slope, double intercept) {
    const ty_grid_info info = ty_grid_get_info(grid);
    assert_int_equal(info.size[2], slices);
    for (int k = 0; k < slices; ++k)
        for (int j = 0; j < info.size[1]; ++j)
            for (int i = 0; i < info.size[0]; ++i) {
                const double expected = slope * (double)(firsts[k] + i + info.size[0] * j) + intercept;
                const double found = (double)ty_grid_voxel(grid, i, j, k);
                if (fabs(found - expected) > 1e-6 * fabs(expected))
                    fail_msg("voxel %d %d %d is %g, not %g", i, j, k, found, expected);
            }
}

static void assert_place(const ty_grid* grid, const double expected[12]) {
    const ty_grid_info info = ty_grid_get_info(grid);
    assert_true(info.placed);
    for (int i = 0; i < 12; ++i)
        if (fabs(info.index_to_local.m[i] - expected[i]) > 1e-9)
            fail_msg("entry %d of the placement is %g, not %g", i, info.index_to_local.m[i], expected[i]);
}

/* ---- order and placement ---- */

static void slices_are_sorted_along_the_normal(void** state) {
    (void)state;
    static const int64_t firsts[] = {-100, 0, 100};
    static const char* const syntaxes[] = {"1.2.840.10008.1.2", "1.2.840.10008.1.2.1", "1.2.840.10008.1.2.2"};
    for (size_t s = 0; s < 3; ++s) {
        dicom_form form = dicom_default_form();
        form.syntax = syntaxes[s];
        form.slope = "0.5";
        form.intercept = "-1024";
        fresh_folder("ct");
        make_slice(&form, "10\\20\\-5", 100); /* named against the order of positions */
        put_slice("ct/a");
        make_slice(&form, "10\\20\\-9", -100);
        put_slice("ct/b");
        make_slice(&form, "10\\20\\-7", 0);
        put_slice("ct/c");
        put_file("ct/notes.txt", "no image", 8);
        ty_grid* grid = read_series("ct", "");
        assert_values(grid, firsts, 3, 0.5, -1024);
        assert_place(grid, (const double[]){0.5, 0, 0, 10, 0, 0.75, 0, 20, 0, 0, 2, -9});
        assert_true(ty_grid_get_info(grid).background == -1074); /* the lowest value, not 0, which is water */
        ty_grid_release(grid);
        grid = read_series("ct/c", ""); /* a file stands for its series */
        assert_values(grid, firsts, 3, 0.5, -1024);
        ty_grid_release(grid);
    }
}

/* A coronal series: rows to the left, columns to the feet; the normal points to the back of the head. */
static void orientation_turns_the_grid(void** state) {
    (void)state;
    static const int64_t firsts[] = {10, 20};
    dicom_form form = dicom_default_form();
    form.orientation = "1\\0\\0\\0\\0\\-1";
    fresh_folder("coronal");
    make_slice(&form, "-50\\3\\70", 20);
    put_slice("coronal/1");
    make_slice(&form, "-50\\-1\\70", 10);
    put_slice("coronal/2");
    ty_grid* grid = read_series("coronal", "");
    assert_values(grid, firsts, 2, 1, 0);
    assert_place(grid, (const double[]){0.5, 0, 0, -50, 0, 0, 4, -1, 0, -0.75, 0, 70});
    ty_grid_release(grid);
    /* Rows to the right: the normal, and so the order, are reversed. */
    static const int64_t reversed[] = {20, 10};
    form.orientation = "-1\\0\\0\\0\\0\\-1";
    make_slice(&form, "-50\\3\\70", 20);
    put_slice("coronal/1");
    make_slice(&form, "-50\\-1\\70", 10);
    put_slice("coronal/2");
    grid = read_series("coronal", "");
    assert_values(grid, reversed, 2, 1, 0);
    assert_place(grid, (const double[]){-0.5, 0, 0, -50, 0, 0, -4, 3, 0, -0.75, 0, 70});
    ty_grid_release(grid);
}

/* A tilted gantry: slices move within their planes from one to the next. */
static void tilted_series_are_sheared(void** state) {
    (void)state;
    static const int64_t firsts[] = {0, 10, 20};
    dicom_form form = dicom_default_form();
    fresh_folder("tilted");
    for (int k = 0; k < 3; ++k) {
        char position[64], path[64];
        snprintf(position, sizeof position, "0\\%g\\%g", 0.3 * k, 2.5 * k);
        make_slice(&form, position, firsts[k]);
        snprintf(path, sizeof path, "tilted/%d", k);
        put_slice(path);
    }
    ty_grid* grid = read_series("tilted", "");
    assert_values(grid, firsts, 3, 1, 0);
    assert_place(grid, (const double[]){0.5, 0, 0, 0, 0, 0.75, 0.3, 0, 0, 0, 2.5, 0});
    ty_grid_release(grid);
}

/* ---- samples ---- */

static void samples_have_their_bits(void** state) {
    (void)state;
    static const struct {
        int allocated, stored, high_bit, is_signed;
        int64_t sample;
        double value;
    } cases[] = {{8, 8, 7, 0, 200, 200},
                 {8, 8, 7, 1, 200, -56},
                 {16, 12, 11, 1, 0xf800, -2048}, /* overlays lie in the bits above */
                 {16, 12, 11, 0, 0xf801, 2049},
                 {16, 12, 15, 0, 0x8010, 0x801},
                 {32, 32, 31, 0, 0xfffffffe, 4294967294.0},
                 {32, 32, 31, 1, 0xfffffffe, -2},
                 {32, 20, 19, 1, 0x80000, -524288}};
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i)
        for (int big = 0; big < 2; ++big) {
            dicom_form form = dicom_default_form();
            form.syntax = big == 1 ? "1.2.840.10008.1.2.2" : "1.2.840.10008.1.2";
            form.allocated = cases[i].allocated;
            form.stored = cases[i].stored;
            form.high_bit = cases[i].high_bit;
            form.is_signed = cases[i].is_signed;
            form.series = NULL;
            form.rows = 1;
            form.columns = 1;
            dicom_slice(&writer, &form, NULL);
            dicom_pixels(&writer, &form, &cases[i].sample);
            put_slice("bits.dcm");
            ty_grid* grid = read_series("bits.dcm", "");
            const double found = (double)ty_grid_voxel(grid, 0, 0, 0);
            if (found != (double)(float)cases[i].value) fail_msg("case %zu is %g, not %g", i, found, cases[i].value);
            ty_grid_release(grid);
        }
}

/* Samples of floats, of their own element. */
static void floats_are_read(void** state) {
    (void)state;
    dicom_form form = dicom_default_form();
    form.series = NULL;
    form.rows = 1;
    form.columns = 2;
    form.allocated = 32;
    form.stored = form.high_bit = 0;
    dicom_slice(&writer, &form, "0\\0\\0");
    static const float values[2] = {1.5f, -3e7f};
    dicom_head(&writer, 0x7fe00008, "OF", sizeof values);
    dicom_put(&writer, values, sizeof values);
    put_slice("floats.dcm");
    ty_grid* grid = read_series("floats.dcm", "");
    for (int i = 0; i < 2; ++i) assert_true(ty_grid_voxel(grid, i, 0, 0) == values[i]);
    ty_grid_release(grid);
}

static void deflated_files_are_inflated(void** state) {
    (void)state;
    static const int64_t firsts[] = {7};
    dicom_form form = dicom_default_form();
    form.syntax = "1.2.840.10008.1.2.1.99";
    make_slice(&form, "0\\0\\0", 7);
    const size_t start = 132 + 8 + 22; /* behind the preamble and the syntax */
    static uint8_t packed[4096];
    z_stream z = {.next_in = writer.bytes + start,
                  .avail_in = (uInt)(writer.size - start),
                  .next_out = packed,
                  .avail_out = sizeof packed};
    assert_int_equal(deflateInit2(&z, 6, Z_DEFLATED, -15, 8, Z_DEFAULT_STRATEGY), Z_OK);
    assert_int_equal(deflate(&z, Z_FINISH), Z_STREAM_END);
    const size_t size = z.total_out;
    deflateEnd(&z);
    writer.size = start;
    dicom_put(&writer, packed, size);
    fresh_folder("deflated");
    put_slice("deflated/a");
    ty_grid* grid = read_series("deflated", "");
    assert_values(grid, firsts, 1, 1, 0);
    ty_grid_release(grid);
    writer.size -= 5;
    put_slice("deflated/a");
    assert_refused("deflated/a", "", "deflated data is damaged");
}

/* ---- several frames ---- */

static void put_frame_item(const char* position, const char* slope) {
    dicom_open_item(&writer);
    dicom_open_sequence(&writer, 0x00209113);
    dicom_open_item(&writer);
    dicom_text(&writer, 0x00200032, "DS", position);
    dicom_close_item(&writer);
    dicom_close_sequence(&writer);
    dicom_open_sequence(&writer, 0x00289145);
    dicom_open_item(&writer);
    dicom_text(&writer, 0x00281052, "DS", "-1000");
    dicom_text(&writer, 0x00281053, "DS", slope);
    dicom_close_item(&writer);
    dicom_close_sequence(&writer);
    dicom_close_item(&writer);
}

/* An enhanced file: what frames share, and each frame's place and scale; frames are not in order. */
static void make_enhanced(const char* syntax) {
    dicom_form form = dicom_default_form();
    form.syntax = syntax;
    form.frames = 3;
    form.orientation = form.spacing = NULL;
    dicom_slice(&writer, &form, NULL);
    dicom_open_sequence(&writer, 0x52009229);
    dicom_open_item(&writer);
    dicom_open_sequence(&writer, 0x00209116);
    dicom_open_item(&writer);
    dicom_text(&writer, 0x00200037, "DS", "0\\1\\0\\0\\0\\1");
    dicom_close_item(&writer);
    dicom_close_sequence(&writer);
    dicom_open_sequence(&writer, 0x00289110);
    dicom_open_item(&writer);
    dicom_text(&writer, 0x00280030, "DS", "3\\2");
    dicom_close_item(&writer);
    dicom_close_sequence(&writer);
    dicom_close_item(&writer);
    dicom_close_sequence(&writer);
    dicom_open_sequence(&writer, 0x52009230);
    put_frame_item("8\\0\\0", "4");
    put_frame_item("4\\0\\0", "2");
    put_frame_item("0\\0\\0", "1");
    dicom_close_sequence(&writer);
    int64_t samples[18];
    for (int i = 0; i < 18; ++i) samples[i] = i % 6;
    dicom_pixels(&writer, &form, samples);
}

static void enhanced_files_hold_a_series(void** state) {
    (void)state;
    static const char* const syntaxes[] = {"1.2.840.10008.1.2", "1.2.840.10008.1.2.1", "1.2.840.10008.1.2.2"};
    for (size_t s = 0; s < 3; ++s) {
        make_enhanced(syntaxes[s]);
        put_slice("enhanced.dcm");
        ty_grid* grid = read_series("enhanced.dcm", "");
        assert_place(grid, (const double[]){0, 0, 4, 0, 2, 0, 0, 0, 0, 3, 0, 0});
        for (int k = 0; k < 3; ++k)
            for (int i = 0; i < 6; ++i)
                assert_true(ty_grid_voxel(grid, i % 3, i / 3, k) == (float)((1 << k) * i - 1000));
        ty_grid_release(grid);
    }
}

/* A sequence of unknown representation has implicit ones inside (PS3.5 section 6.2.2). */
static void sequences_of_unknown_kind_are_passed(void** state) {
    (void)state;
    static const int64_t firsts[] = {5};
    dicom_form form = dicom_default_form();
    form.series = NULL;
    dicom_slice(&writer, &form, "0\\0\\0");
    dicom_head(&writer, 0x00291010, "UN", UNDEFINED_LENGTH);
    dicom_open_item(&writer);
    writer.implicit_vr = true;
    dicom_text(&writer, 0x00080060, "CS", "AB");
    writer.implicit_vr = false;
    dicom_close_item(&writer);
    dicom_close_sequence(&writer);
    dicom_pixels(&writer, &form, (const int64_t[6]){5, 6, 7, 8, 9, 10});
    put_slice("unknown.dcm");
    ty_grid* grid = read_series("unknown.dcm", "");
    assert_values(grid, firsts, 1, 1, 0);
    ty_grid_release(grid);
}

/* A dose: frames at offsets along the normal, in units of a scale. */
static void doses_are_scaled(void** state) {
    (void)state;
    static const int64_t firsts[] = {0, 6};
    dicom_form form = dicom_default_form();
    form.frames = 2;
    form.series = NULL;
    dicom_slice(&writer, &form, "1\\2\\3");
    dicom_text(&writer, 0x3004000c, "DS", "0\\2.5");
    dicom_text(&writer, 0x3004000e, "DS", "0.001");
    int64_t samples[12];
    for (int i = 0; i < 12; ++i) samples[i] = i;
    dicom_pixels(&writer, &form, samples);
    put_slice("dose.dcm");
    ty_grid* grid = read_series("dose.dcm", "");
    assert_values(grid, firsts, 2, 0.001, 0);
    assert_place(grid, (const double[]){0.5, 0, 0, 1, 0, 0.75, 0, 2, 0, 0, 2.5, 3});
    ty_grid_release(grid);
}

/* Nuclear medicine: the item of a detector places the first frame, and the others stand in front of it. */
static void detectors_place_frames(void** state) {
    (void)state;
    static const int64_t firsts[] = {6, 0};
    dicom_form form = dicom_default_form();
    form.frames = 2;
    form.series = form.orientation = NULL;
    int64_t samples[12];
    for (int i = 0; i < 12; ++i) samples[i] = i;
    for (int grouped = 0; grouped < 2; ++grouped) { /* the spacing stands alone, or in a functional group */
        dicom_slice(&writer, &form, NULL);
        if (grouped == 1) {
            dicom_open_sequence(&writer, 0x52009229);
            dicom_open_item(&writer);
            dicom_open_sequence(&writer, 0x00289110);
            dicom_open_item(&writer);
        }
        dicom_text(&writer, 0x00180088, "DS", "-2.5");
        for (int depth = 0; depth < 2 * grouped; ++depth) {
            dicom_close_item(&writer);
            dicom_close_sequence(&writer);
        }
        dicom_open_sequence(&writer, 0x00540022);
        dicom_open_item(&writer);
        dicom_text(&writer, 0x00200032, "DS", "10\\20\\30");
        dicom_text(&writer, 0x00200037, "DS", "0\\1\\0\\0\\0\\-1");
        dicom_close_item(&writer);
        dicom_close_sequence(&writer);
        dicom_pixels(&writer, &form, samples);
        put_slice("nuclear.dcm");
        ty_grid* grid = read_series("nuclear.dcm", "");
        assert_values(grid, firsts, 2, 1, 0);
        assert_place(grid, (const double[]){0, 0, -2.5, 12.5, 0.5, 0, 0, 20, 0, -0.75, 0, 30});
        ty_grid_release(grid);
    }
}

/* ---- several series ---- */

static void series_are_chosen(void** state) {
    (void)state;
    static const int64_t first[] = {1}, second[] = {2};
    dicom_form form = dicom_default_form();
    fresh_folder("several");
    make_slice(&form, "0\\0\\0", 1);
    put_slice("several/a");
    form.series = "1.2.4";
    form.description = "sagittal";
    make_slice(&form, "0\\0\\0", 2);
    put_slice("several/b");
    assert_refused("several", "", "2 series");
    assert_refused("several", "", "3 \"axial\" (1 files, 1.2.3), 4 \"sagittal\" (1 files, 1.2.4)");
    assert_refused("several", "coronal", "no series \"coronal\"");
    static const char* const names[] = {"4", "1.2.4", "sagittal"};
    for (size_t i = 0; i < 3; ++i) {
        ty_grid* grid = read_series("several", names[i]);
        assert_values(grid, second, 1, 1, 0);
        ty_grid_release(grid);
    }
    ty_grid* grid = read_series("several/a", "");
    assert_values(grid, first, 1, 1, 0);
    ty_grid_release(grid);
}

static void put_at(const char* path, const dicom_form* form, const char* position) {
    make_slice(form, position, 0);
    put_slice(path);
}

static void gaps_and_duplicates_are_told(void** state) {
    (void)state;
    dicom_form form = dicom_default_form();
    fresh_folder("gaps");
    put_at("gaps/a", &form, "0\\0\\0");
    put_at("gaps/b", &form, "0\\0\\2");
    put_at("gaps/c", &form, "0\\0\\4");
    put_at("gaps/d", &form, "0\\0\\8");
    assert_refused("gaps", "", "c and d are 4 mm apart, where others are 2 mm: slices are missing");
    put_at("gaps/d", &form, "0\\0\\2.0000001");
    assert_refused("gaps", "", "b and d lie at the same position");
    put_at("gaps/d", &form, "9\\0\\6");
    assert_refused("gaps", "", "do not lie in one row");
    form.columns = 2;
    put_at("gaps/d", &form, "0\\0\\6");
    assert_refused("gaps", "", "a and d have different numbers of pixels");
    form.columns = 3;
    form.spacing = "0.75\\0.6";
    put_at("gaps/d", &form, "0\\0\\6");
    assert_refused("gaps", "", "a and d have different pixel spacings");
    form.spacing = "0.75\\0.5";
    form.orientation = "1\\0\\0\\0\\0.8\\0.6";
    put_at("gaps/d", &form, "0\\0\\6");
    assert_refused("gaps", "", "a and d have different orientations");
    form.orientation = "1\\0\\0\\0\\1\\0";
    put_at("gaps/d", &form, NULL);
    assert_refused("gaps", "", "d has no ImagePositionPatient");
    put_at("gaps/d", &form, "0\\0\\6");
    ty_grid_release(read_series("gaps", ""));
    form.orientation = "1\\0\\0\\1\\0\\0";
    fresh_folder("gaps");
    put_at("gaps/a", &form, "0\\0\\0");
    assert_refused("gaps", "", "two perpendicular unit vectors");
    fresh_folder("gaps");
    assert_refused("gaps", "", "a folder without DICOM files");
}

/* ---- compressed frames ---- */

/* 16 x 12 samples of `bits` bits: a ramp with steps. */
static void make_samples(int bits, int64_t* samples) {
    for (int i = 0; i < ENCODED_PIXELS; ++i) samples[i] = (i * 37 + (i / 16) * (1 << (bits - 3))) & ((1 << bits) - 1);
}

/* Encapsulates one frame in `fragments` fragments. */
static void put_encoded(const dicom_form* form, const uint8_t* bytes, size_t size, size_t fragments) {
    dicom_slice(&writer, form, "0\\0\\0");
    dicom_open_fragments(&writer, NULL, 0);
    const size_t part = (size / fragments + 1) / 2 * 2;
    for (size_t i = 0; i < fragments; ++i)
        dicom_fragment(&writer, bytes + i * part, i + 1 < fragments ? part : size - i * part);
    dicom_close_sequence(&writer);
}

static const struct {
    const char* syntax;
    size_t (*encode)(const int64_t* samples, int bits, uint8_t* out, size_t size);
    int bits, tolerance;
} encodings[] = {{"1.2.840.10008.1.2.5", encode_rle, 8, 0},
                 {"1.2.840.10008.1.2.5", encode_rle, 16, 0},
                 {"1.2.840.10008.1.2.4.80", encode_jpeg_ls, 8, 0},
                 {"1.2.840.10008.1.2.4.80", encode_jpeg_ls, 12, 0},
                 {"1.2.840.10008.1.2.4.80", encode_jpeg_ls, 16, 0},
                 {"1.2.840.10008.1.2.4.90", encode_jpeg_2000, 8, 0},
                 {"1.2.840.10008.1.2.4.90", encode_jpeg_2000, 12, 0},
                 {"1.2.840.10008.1.2.4.90", encode_jpeg_2000, 16, 0},
                 {"1.2.840.10008.1.2.4.70", encode_jpeg_lossless8, 8, 0},
                 {"1.2.840.10008.1.2.4.70", encode_jpeg_lossless12, 12, 0},
                 {"1.2.840.10008.1.2.4.70", encode_jpeg_lossless16, 16, 0},
                 {"1.2.840.10008.1.2.4.50", encode_jpeg_lossy8, 8, 3},
                 {"1.2.840.10008.1.2.4.51", encode_jpeg_lossy12, 12, 24}};
enum { ENCODINGS = sizeof encodings / sizeof encodings[0] };

static dicom_form encoded_form(int encoding) {
    dicom_form form = dicom_default_form();
    form.syntax = encodings[encoding].syntax;
    form.columns = ENCODED_WIDTH;
    form.rows = ENCODED_HEIGHT;
    form.allocated = encodings[encoding].bits > 8 ? 16 : 8;
    form.stored = encodings[encoding].bits;
    form.high_bit = form.stored - 1;
    form.is_signed = encodings[encoding].tolerance == 0;
    form.series = NULL;
    return form;
}

static double value_of(int64_t sample, const dicom_form* form) {
    return (double)(form->is_signed && sample >> (form->stored - 1) != 0 ? sample - (1 << form->stored) : sample);
}

static void compressed_frames_are_decoded(void** state) {
    (void)state;
    int decoded = 0;
    for (int e = 0; e < ENCODINGS; ++e) {
        static uint8_t bytes[1 << 16];
        int64_t samples[ENCODED_PIXELS];
        make_samples(encodings[e].bits, samples);
        const size_t size = encodings[e].encode(samples, encodings[e].bits, bytes, sizeof bytes);
        if (size == 0) continue; /* a build without the encoder's library */
        const dicom_form form = encoded_form(e);
        for (size_t fragments = 1; fragments <= 2; ++fragments) {
            put_encoded(&form, bytes, size, fragments);
            put_slice("packed.dcm");
            ty_grid* grid = read_series("packed.dcm", "");
            for (int i = 0; i < ENCODED_PIXELS; ++i) {
                const double found = (double)ty_grid_voxel(grid, i % ENCODED_WIDTH, i / ENCODED_WIDTH, 0);
                if (fabs(found - value_of(samples[i], &form)) > encodings[e].tolerance)
                    fail_msg("encoding %d: pixel %d is %g, not %g", e, i, found, value_of(samples[i], &form));
            }
            ty_grid_release(grid);
        }
        ++decoded;
        put_encoded(&form, bytes, size / 2, 1); /* cut short: no pixels are made up */
        put_slice("packed.dcm");
        assert_refused("packed.dcm", "", "cannot decode this");
        dicom_form wide = form;
        wide.columns += 1;
        put_encoded(&wide, bytes, size, 1);
        put_slice("packed.dcm");
        assert_refused("packed.dcm", "", encodings[e].encode == encode_rle ? "damaged" : "16 x 12 pixels");
    }
    assert_true(decoded >= 2);
    printf("%d of %d encodings\n", decoded, (int)ENCODINGS);
}

/* Frames have a fragment each, or a table of where they begin. */
static void fragments_belong_to_frames(void** state) {
    (void)state;
    int64_t samples[2][ENCODED_PIXELS];
    uint8_t bytes[2][1 << 12];
    size_t sizes[2];
    dicom_form form = encoded_form(1);
    form.frames = 2;
    for (int f = 0; f < 2; ++f) {
        make_samples(16, samples[f]);
        samples[f][0] = 77 + f;
        sizes[f] = encode_rle(samples[f], 16, bytes[f], sizeof bytes[f]);
    }
    for (int variant = 0; variant < 3; ++variant) {
        const size_t half = sizes[0] / 4 * 2, even = sizes[0] + sizes[0] % 2;
        const uint32_t table[2] = {0, (uint32_t)(even + 16)};
        dicom_slice(&writer, &form, "0\\0\\0");
        dicom_open_fragments(&writer, table, variant == 1 ? 2 : 0);
        if (variant == 0) {
            dicom_fragment(&writer, bytes[0], sizes[0]);
        } else {
            dicom_fragment(&writer, bytes[0], half);
            dicom_fragment(&writer, bytes[0] + half, sizes[0] - half);
        }
        dicom_fragment(&writer, bytes[1], sizes[1]);
        dicom_close_sequence(&writer);
        put_slice("frames.dcm");
        if (variant == 2) {
            assert_refused("frames.dcm", "", "3 fragments for 2 frames");
            continue;
        }
        ty_grid* grid = read_series("frames.dcm", "");
        for (int f = 0; f < 2; ++f)
            for (int i = 0; i < ENCODED_PIXELS; ++i)
                assert_true((double)ty_grid_voxel(grid, i % 16, i / 16, f) == value_of(samples[f][i], &form));
        ty_grid_release(grid);
    }
}

/* ---- broken files ---- */

static void broken_files_are_refused(void** state) {
    (void)state;
    static const struct {
        int allocated, stored, high_bit, columns;
        const char* words;
    } cases[] = {{12, 12, 11, 3, "12 bits allocated"}, {16, 17, 15, 3, "do not fit in 16 bits"},
                 {16, 12, 16, 3, "do not fit in 16"},  {16, 12, 10, 3, "do not fit in 16"},
                 {16, 0, 0, 3, "0 bits stored"},       {16, 16, 15, 0, "0 x 2 pixels"},
                 {16, 16, 15, 60000, "60000 x 2 x 1"}, {16, 16, 15, 16000, "cut short: 16000 x 2"}};
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        dicom_form form = dicom_default_form();
        form.allocated = cases[i].allocated;
        form.stored = cases[i].stored;
        form.high_bit = cases[i].high_bit;
        form.columns = cases[i].columns;
        dicom_slice(&writer, &form, "0\\0\\0");
        dicom_head(&writer, 0x7fe00010, "OW", 12);
        dicom_put(&writer, "abcdefghijkl", 12);
        put_slice("broken.dcm");
        assert_refused("broken.dcm", "", cases[i].words);
    }
    dicom_form form = dicom_default_form();
    make_slice(&form, "0\\0\\0", 0);
    for (size_t size = writer.size - 1; size > 140; size -= 7) { /* wherever it is cut */
        ty_volume_def def = ty_default_volume_def();
        ty_grid* grid = NULL;
        put_file("broken.dcm", writer.bytes, size);
        assert_failed(context, ty_volume_read(context, "broken.dcm", &def, &grid), TY_ERROR_INPUT, "broken.dcm", NULL);
    }
    form.syntax = "1.2.840.10008.1.2.4.100";
    make_slice(&form, "0\\0\\0", 0);
    put_slice("broken.dcm");
    assert_refused("broken.dcm", "", "transfer syntax 1.2.840.10008.1.2.4.100 cannot be read");
    form.syntax = "1.2.840.10008.1.2.5";
    make_slice(&form, "0\\0\\0", 0);
    put_slice("broken.dcm");
    assert_refused("broken.dcm", "", "not in fragments");
    /* A million frames of one pixel, for which there is one fragment. */
    form.columns = form.rows = 1;
    form.allocated = form.stored = 8;
    form.high_bit = 7;
    form.frames = 1000000;
    dicom_slice(&writer, &form, "0\\0\\0");
    dicom_open_fragments(&writer, NULL, 0);
    dicom_fragment(&writer, (const uint8_t*)"frag", 4);
    dicom_close_sequence(&writer);
    put_slice("broken.dcm");
    assert_refused("broken.dcm", "", "cut short: 1 x 1 pixels");
    form = dicom_default_form();
    form.syntax = "1.2.840.10008.1.2.1";
    dicom_slice(&writer, &form, "0\\0\\0");
    for (int i = 0; i < 20; ++i) {
        dicom_open_sequence(&writer, 0x00081115);
        dicom_open_item(&writer);
    }
    put_slice("broken.dcm");
    assert_refused("broken.dcm", "", "sequences more than 16 deep");
    dicom_slice(&writer, &form, "0\\0\\0");
    dicom_short(&writer, 0x00280002, 3);
    dicom_pixels(&writer, &form, (const int64_t[6]){0});
    put_slice("broken.dcm");
    assert_refused("broken.dcm", "", "a colour image");
}

static ty_result read_ct(ty_context* own, void* user) {
    ty_volume_def def = ty_default_volume_def();
    ty_grid* grid = NULL;
    const ty_result result = ty_volume_read(own, user, &def, &grid);
    if (result == TY_OK) ty_grid_release(grid);
    return result;
}

/* Slices are decoded slab by slab: a series that is nearly empty takes memory for what is in it. */
static void large_series_are_never_dense(void** state) {
    (void)state;
    enum { SIDE = 200, SLICES = 160, BRIGHT = 60 * SIDE + 50 };
    static int64_t samples[SIDE * SIDE];
    dicom_form form = dicom_default_form();
    form.columns = form.rows = SIDE;
    fresh_folder("large");
    for (int k = 0; k < SLICES; ++k) {
        char position[32], path[32];
        snprintf(position, sizeof position, "0\\0\\%d", k);
        snprintf(path, sizeof path, "large/%03d", (k * 37) % SLICES);
        samples[BRIGHT] = 1000 + k;
        dicom_slice(&writer, &form, position);
        dicom_pixels(&writer, &form, samples);
        put_slice(path);
    }
    memory.limit = (size_t)8 << 20; /* the dense array has 24.4 MiB */
    ty_grid* grid = read_series("large", "");
    memory.limit = (size_t)1 << 30;
    assert_int_equal(ty_grid_get_info(grid).storage, TY_GRID_SPARSE);
    assert_int_equal(ty_grid_get_info(grid).active, SLICES);
    for (int k = 0; k < SLICES; ++k) assert_true(ty_grid_voxel(grid, 50, 60, k) == (float)(1000 + k));
    ty_grid_release(grid);
    fresh_folder("large");
}

static void memory_may_run_out(void** state) {
    (void)state;
    dicom_form form = dicom_default_form();
    fresh_folder("short");
    put_at("short/a", &form, "0\\0\\0");
    put_at("short/b", &form, "0\\0\\1");
    assert_true(check_short_memory(context, &memory, read_ct, (void*)(uintptr_t) "short") > 10);
    make_enhanced("1.2.840.10008.1.2");
    put_slice("enhanced.dcm");
    assert_true(check_short_memory(context, &memory, read_ct, (void*)(uintptr_t) "enhanced.dcm") > 5);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(slices_are_sorted_along_the_normal),
        cmocka_unit_test(orientation_turns_the_grid),
        cmocka_unit_test(tilted_series_are_sheared),
        cmocka_unit_test(samples_have_their_bits),
        cmocka_unit_test(floats_are_read),
        cmocka_unit_test(deflated_files_are_inflated),
        cmocka_unit_test(enhanced_files_hold_a_series),
        cmocka_unit_test(sequences_of_unknown_kind_are_passed),
        cmocka_unit_test(doses_are_scaled),
        cmocka_unit_test(detectors_place_frames),
        cmocka_unit_test(series_are_chosen),
        cmocka_unit_test(gaps_and_duplicates_are_told),
        cmocka_unit_test(compressed_frames_are_decoded),
        cmocka_unit_test(fragments_belong_to_frames),
        cmocka_unit_test(broken_files_are_refused),
        cmocka_unit_test(large_series_are_never_dense),
        cmocka_unit_test(memory_may_run_out),
    };
    return cmocka_run_group_tests(tests, start, stop);
}
