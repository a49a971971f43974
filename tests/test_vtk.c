/* Images of VTK: files of our own there and back, every form of data in .vti and legacy .vtk files, placement, the
 * choice of an array, and broken files. Files of VTK's own writers are compared by hand (docs/formats.md). */
#include "strict_fixture.h"

#include <tyndall/io.h>

#include <math.h>
#include <zlib.h>

static ty_grid* read_array(const char* path, const char* name, int32_t component) {
    ty_volume_def def = ty_default_volume_def();
    ty_grid* grid = NULL;
    if (name != NULL) def.grid = name;
    def.exact_grid = name != NULL;
    def.component = component;
    if (ty_volume_read(context, path, &def, &grid) != TY_OK) fail_msg("%s", ty_take_error(context));
    return grid;
}

static void assert_refused(const char* path, const char* matter) {
    const ty_volume_def def = ty_default_volume_def();
    ty_grid* grid = NULL;
    const ty_result result = ty_volume_read(context, path, &def, &grid);
    assert_null(grid);
    assert_failed(context, result, TY_ERROR_INPUT, path, matter);
}

static void put_text(const char* path, const char* text) {
    put_file(path, text, strlen(text));
}

/* ---- there and back ---- */

static ty_grid* make_grid(const ty_affine* map, float offset) {
    enum { NX = 70, NY = 41, NZ = 33 };
    static float values[NX * NY * NZ];
    for (int i = 0; i < NX * NY * NZ; ++i) values[i] = offset + (float)(i % 977) / 8;
    ty_grid_def def = ty_default_grid_def();
    def.size[0] = NX;
    def.size[1] = NY;
    def.size[2] = NZ;
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
    for (int i = 0; i < 12; ++i)
        assert_float_equal(x.index_to_local.m[i], y.index_to_local.m[i], 1e-14 * (1 + fabs(y.index_to_local.m[i])));
    for (int k = 0; k < x.size[2]; ++k)
        for (int j = 0; j < x.size[1]; ++j)
            for (int i = 0; i < x.size[0]; ++i) assert_true(ty_grid_voxel(a, i, j, k) == ty_grid_voxel(b, i, j, k));
}

static const double translate[3] = {-10, 20, 0.1}, rotate[3] = {30, -40, 110}, scale[3] = {0.1, 0.25, 3};

/* Three grids of one vector and one more, in blocks that are full and not. */
static void fields_come_back(void** state) {
    (void)state;
    const ty_affine map = ty_affine_compose(translate, rotate, scale);
    ty_grid* grids[4];
    for (int i = 0; i < 4; ++i) grids[i] = make_grid(&map, (float)(100 * i));
    const ty_volume_field fields[2] = {{"flu<e&n>ce \"1\"", 3, {grids[0], grids[1], grids[2]}},
                                       {"heat", 1, {grids[3]}}};
    static const char *const codecs[] = {"zip", "none"}, *const paths[] = {"a.vti", "a.vdb"};
    for (int i = 0; i < 4; ++i) {
        const char* path = paths[i / 2];
        assert_int_equal(ty_volume_write(context, fields, 2, codecs[i % 2], path), TY_OK);
        for (int c = 0; c < 4; ++c) {
            ty_grid* back = read_array(path, fields[c / 3].name, c % 3);
            assert_same(back, grids[c]);
            ty_grid_release(back);
        }
    }
    ty_vdb_entry entries[3];
    int32_t count = 0;
    assert_int_equal(ty_volume_write(context, fields, 2, NULL, "a.vti"), TY_OK);
    assert_int_equal(ty_volume_list(context, "a.vti", entries, 3, &count), TY_OK);
    assert_int_equal(count, 2);
    assert_string_equal(entries[0].name, fields[0].name);
    assert_string_equal(entries[0].type, "float[3]");
    assert_string_equal(entries[1].type, "float");
    assert_int_equal(entries[1].upper[2], 32);
    assert_int_equal(entries[1].active_voxels, 70 * 41 * 33);
    assert_float_equal(entries[1].voxel_size[2], 3, 1e-12);
    for (int i = 0; i < 4; ++i) ty_grid_release(grids[i]);
}

static void fields_are_checked(void** state) {
    (void)state;
    const ty_affine map = ty_affine_identity(), other = ty_affine_compose(translate, rotate, scale);
    ty_grid *a = make_grid(&map, 0), *b = make_grid(&other, 0);
    const ty_volume_field mixed = {"v", 3, {a, a, b}}, two = {"v", 2, {a, a}}, good = {"v", 1, {a}};
    const ty_volume_field vector = {"v", 3, {a, a, a}}, places[2] = {{"v", 1, {a}}, {"w", 1, {b}}},
                          nameless = {"", 1, {a}};
    const struct {
        const ty_volume_field* fields;
        int32_t count;
        const char *codec, *path, *matter;
    } cases[] = {{&mixed, 1, NULL, "x.vti", "differ in size, placement or type"},
                 {&two, 1, NULL, "x.vti", "2 components"},
                 {&nameless, 1, NULL, "x.vti", "1..127"},
                 {places, 2, NULL, "x.vti", "\"v\" and \"w\" differ"},
                 {&good, 0, NULL, "x.vti", "no fields"},
                 {&good, 1, "blosc", "x.vti", "no codec \"blosc\""},
                 {&good, 1, NULL, "x.txt", ".nrrd, .vti, .nii, .nii.gz, .vol or .bricks"},
                 {&vector, 1, NULL, "x.nrrd", "one value per voxel"},
                 {&good, 1, "lzma", "x.nrrd", "no codec"}};
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        assert_int_equal(ty_volume_write(context, cases[i].fields, cases[i].count, cases[i].codec, cases[i].path),
                         TY_ERROR_ARGUMENT);
        const char* message = ty_take_error(context);
        if (strstr(message, cases[i].matter) == NULL) fail_msg("%zu: %s", i, message);
    }
    assert_int_equal(remove_temporary_files(), 0);
    ty_grid_release(a);
    ty_grid_release(b);
}

static ty_result write_and_read(ty_context* own, void* user) {
    const ty_volume_field* field = user;
    const ty_volume_def def = ty_default_volume_def();
    ty_grid* grid = NULL;
    ty_result result = ty_volume_write(own, field, 1, "zip", "memory.vti");
    if (result == TY_OK) result = ty_volume_read(own, "memory.vti", &def, &grid);
    ty_grid_release(grid);
    return result;
}

static void short_memory_is_told(void** state) {
    (void)state;
    const ty_affine map = ty_affine_identity();
    ty_grid* grid = make_grid(&map, 0);
    ty_volume_field field = {"v", 1, {grid}};
    assert_true(check_short_memory(context, &memory, write_and_read, &field) >= 8);
    ty_grid_release(grid);
}

/* ---- forms of .vti files ---- */

/* A file of 2 x 2 x 2 bytes 0 to 7 at points. */
static void put_vti(const char* file_attributes, const char* array_attributes, const char* data, const char* behind) {
    char text[2048];
    snprintf(text, sizeof text,
             "<?xml version=\"1.0\"?>\n<VTKFile type=\"ImageData\" %s>\n<ImageData WholeExtent=\"0 1 0 1 0 1\" "
             "Origin=\"1 2 3\" Spacing=\"2 1 0.5\">\n<Piece Extent=\"0 1 0 1 0 1\"><PointData>"
             "<DataArray type=\"UInt8\" Name=\"v\" %s>%s</DataArray></PointData></Piece></ImageData>%s</VTKFile>",
             file_attributes, array_attributes, data, behind);
    put_text("form.vti", text);
}

static void assert_zero_to_seven(const char* path, int32_t component) {
    ty_grid* grid = read_array(path, NULL, component);
    for (int i = 0; i < 8; ++i) assert_float_equal(ty_grid_voxel(grid, i & 1, i >> 1 & 1, i >> 2), (double)i, 0);
    ty_grid_release(grid);
}

static void every_form_is_read(void** state) {
    (void)state;
    static const char* const forms[][4] = {
        {"", "format=\"ascii\"", " 0 1 2\n3 4 5 6 7 ", ""},
        {"", "", "0 1 2 3 4 5 6 7", ""},
        {"byte_order=\"LittleEndian\"", "format=\"binary\"", "\n  CAAAAAABAgMEBQYH\n ", ""},
        {"byte_order=\"BigEndian\"", "format=\"binary\"", "AAAACAABAgMEBQYH", ""},
        {"header_type=\"UInt64\"", "format=\"binary\"", "CAAAAAAAAAAAAQIDBAUGBw==", ""},
        {"", "format=\"binary\"", "CAAAAA==AAECAwQFBgc=", ""}, /* the size in base64 of its own */
        {"", "format=\"ascii\"",
         "0 1 2 3 4 5 6 7 <InformationKey name=\"L2_NORM_RANGE\"><Value>1</Value></InformationKey>", ""},
        {"", "format=\"binary\"", "<InformationKey name=\"n\"/>CAAAAAABAgMEBQYH", ""},
        {"", "format=\"appended\" offset=\"5\"", "",
         "<AppendedData encoding=\"base64\">\n _ABCDCAAAAAABAgMEBQYH</AppendedData>"},
        {"", "format=\"appended\" offset=\"4\"", "",
         "<AppendedData encoding=\"base64\">\n_ABCDCAAAAAABAgMEBQYH</AppendedData>"}};
    for (size_t i = 0; i < sizeof forms / sizeof forms[0]; ++i) {
        put_vti(forms[i][0], forms[i][1], forms[i][2], forms[i][3]);
        if (i == 8) /* its offset leads into the middle of a group */
            assert_refused("form.vti", "array \"v\"");
        else
            assert_zero_to_seven("form.vti", 0);
    }
}

/* Data that are no XML, behind the arrays. */
static void appended_bytes_are_read(void** state) {
    (void)state;
    static const uint8_t plain[] = {8, 0, 0, 0, 0, 1, 2, 3, 4, 5, 6, 7};
    uint8_t packed[256], file[4096];
    const char* head = "<VTKFile type=\"ImageData\" compressor=\"%s\"><ImageData WholeExtent=\"0 1 0 1 0 1\">"
                       "<Piece Extent=\"0 1 0 1 0 1\"><PointData><DataArray type=\"UInt8\" Name=\"v\" "
                       "format=\"appended\" offset=\"0\"/></PointData></Piece></ImageData>"
                       "<AppendedData encoding=\"raw\">_";
    size_t length = (size_t)snprintf((char*)file, sizeof file, head, "");
    memcpy(file + length, plain, sizeof plain);
    put_file("raw.vti", file, length + sizeof plain);
    assert_zero_to_seven("raw.vti", 0);
    put_file("cut.vti", file, length + sizeof plain - 1);
    assert_refused("cut.vti", "cut short");
    /* Blocks of 5 and 3 bytes. */
    uLongf sizes[2] = {100, 100};
    assert_int_equal(compress(packed, &sizes[0], plain + 4, 5), Z_OK);
    assert_int_equal(compress(packed + sizes[0], &sizes[1], plain + 9, 3), Z_OK);
    const uint32_t words[5] = {2, 5, 3, (uint32_t)sizes[0], (uint32_t)sizes[1]};
    length = (size_t)snprintf((char*)file, sizeof file, head, "vtkZLibDataCompressor");
    memcpy(file + length, words, sizeof words);
    memcpy(file + length + sizeof words, packed, sizes[0] + sizes[1]);
    put_file("packed.vti", file, length + sizeof words + sizes[0] + sizes[1]);
    assert_zero_to_seven("packed.vti", 0);
    file[length + sizeof words + 6] ^= 0x55;
    put_file("wrong.vti", file, length + sizeof words + sizes[0] + sizes[1]);
    assert_refused("wrong.vti", "damaged or cut short");
    const uint32_t lies[5] = {0x40000000, 0x40000000, 0, 1, 1};
    memcpy(file + length, lies, sizeof lies);
    put_file("lies.vti", file, length + sizeof lies);
    assert_refused("lies.vti", "bytes; the extent and its type take 8");
}

static void cells_and_directions_place(void** state) {
    (void)state;
    put_text(
        "cells.vti",
        "<VTKFile type=\"ImageData\"><ImageData WholeExtent=\"2 4 -1 0 0 0\" Origin=\"10 20 30\" Spacing=\"2 4 8\" "
        "Direction=\"0 -1 0 1 0 0 0 0 1\"><Piece Extent=\"2 4 -1 0 0 0\"><CellData Scalars=\"b\">"
        "<DataArray type=\"Float32\" Name=\"a\">5 6</DataArray><DataArray type=\"Float64\" Name=\"b\" "
        "NumberOfComponents=\"2\">1 2 3 4</DataArray></CellData><PointData><DataArray type=\"Int16\" "
        "Name=\"p\">1 2 3 4 5 6</DataArray></PointData></Piece></ImageData></VTKFile>");
    ty_grid* grid = read_array("cells.vti", NULL, 1); /* the section's own choice */
    const ty_grid_info info = ty_grid_get_info(grid);
    assert_int_equal(info.size[0], 2);
    assert_int_equal(info.size[1], 1);
    assert_int_equal(info.size[2], 1);
    assert_float_equal(ty_grid_voxel(grid, 0, 0, 0), 2, 0);
    assert_float_equal(ty_grid_voxel(grid, 1, 0, 0), 4, 0);
    const double expected[12] = {0, -4, 0, 10 + 2, 2, 0, 0, 20 + 5, 0, 0, 8, 30};
    for (int i = 0; i < 12; ++i) assert_float_equal(info.index_to_local.m[i], expected[i], 1e-12);
    ty_grid_release(grid);
    grid = read_array("cells.vti", "p", 0);
    assert_float_equal(ty_grid_get_info(grid).index_to_local.m[3], 10 + 4, 1e-12);
    assert_float_equal(ty_grid_voxel(grid, 2, 1, 0), 6, 0);
    ty_grid_release(grid);
    ty_volume_def def = ty_default_volume_def();
    def.grid = "smoke";
    def.exact_grid = true;
    grid = NULL;
    assert_failed(context, ty_volume_read(context, "cells.vti", &def, &grid), TY_ERROR_INPUT, "cells.vti",
                  "no array \"smoke\"; there are a, b, p");
    int32_t components = 0;
    def.grid = "b";
    assert_int_equal(ty_volume_components(context, "cells.vti", &def, &components), TY_OK);
    assert_int_equal(components, 2);
}

#define PIECE_OF(extent, values)                                                                                       \
    "<Piece Extent=\"" extent "\"><PointData><DataArray type=\"UInt8\" Name=\"v\">" values                             \
    "</DataArray></PointData></Piece>"
#define PIECES(a, x, b, y)                                                                                             \
    "<VTKFile type=\"ImageData\"><ImageData WholeExtent=\"0 1 0 1 0 1\">" PIECE_OF(a, x)                               \
        PIECE_OF(b, y) "</ImageData></VTKFile>"

/* Points that pieces share at a face are those of the later one; cells are in one piece alone. */
static void pieces_are_put_together(void** state) {
    (void)state;
    put_text("pieces.vti", PIECES("0 1 0 1 0 0", "0 1 2 3", "0 1 0 1 1 1", "4 5 6 7"));
    assert_zero_to_seven("pieces.vti", 0);
    put_text("shared.vti", PIECES("0 1 0 1 0 1", "9 9 9 9 4 5 6 7", "0 1 0 1 0 0", "0 1 2 3"));
    assert_zero_to_seven("shared.vti", 0);
    put_text("cells.vti",
             "<VTKFile type=\"ImageData\"><ImageData WholeExtent=\"3 5 2 4 0 2\" Origin=\"0 0 7\">"
             "<Piece Extent=\"3 5 2 3 0 2\"><CellData><DataArray type=\"UInt8\" Name=\"v\">0 1 4 5</DataArray>"
             "</CellData></Piece><Piece Extent=\"3 5 3 4 0 2\"><CellData><DataArray type=\"UInt8\" Name=\"v\">"
             "2 3 6 7</DataArray></CellData></Piece></ImageData></VTKFile>");
    assert_zero_to_seven("cells.vti", 0);
    ty_grid* grid = read_array("cells.vti", NULL, 0);
    const ty_grid_info info = ty_grid_get_info(grid);
    assert_float_equal(info.index_to_local.m[3], 3.5, 1e-12);
    assert_float_equal(info.index_to_local.m[7], 2.5, 1e-12);
    assert_float_equal(info.index_to_local.m[11], 7.5, 1e-12);
    ty_grid_release(grid);
    ty_vdb_entry entries[2];
    int32_t count = 0;
    assert_int_equal(ty_volume_list(context, "cells.vti", entries, 2, &count), TY_OK);
    assert_int_equal(count, 1);
    assert_int_equal(entries[0].active_voxels, 8);
}

static void broken_vti_files_are_refused(void** state) {
    (void)state;
#define HEAD "<VTKFile type=\"ImageData\"><ImageData WholeExtent=\"0 1 0 1 0 1\">"
#define PIECE HEAD "<Piece Extent=\"0 1 0 1 0 1\"><PointData>"
#define TAIL "</PointData></Piece></ImageData></VTKFile>"
#define ARRAY(attributes, data) PIECE "<DataArray Name=\"v\" " attributes ">" data "</DataArray>" TAIL
    static const char* const cases[][2] = {
        {"<VTKFile>", ":1: a VTK file of type"},
        {"<?xml version=\"1.0\"?>\n<svg/>", ":2: the document is \"svg\""},
        {"<VTKFile type=\"UnstructuredGrid\"/>", "of type \"UnstructuredGrid\"; ImageData"},
        {"<VTKFile type=\"ImageData\" byte_order=\"Middle\"/>", "byte order"},
        {"<VTKFile type=\"ImageData\" header_type=\"UInt16\"/>", "header type"},
        {"<VTKFile type=\"ImageData\" compressor=\"vtkLZ4DataCompressor\"/>", "vtkLZ4DataCompressor"},
        {"<VTKFile type=\"ImageData\"/>", "no ImageData with a Piece"},
        {HEAD "</ImageData></VTKFile>", "no ImageData with a Piece"},
        {HEAD, "not XML"},
        {"<VTKFile type=\"ImageData\"><ImageData/></VTKFile>", "WholeExtent is missing"},
        {"<VTKFile type=\"ImageData\"><ImageData WholeExtent=\"0 1 0 1 0\"/></VTKFile>", "list of the numbers"},
        {"<VTKFile type=\"ImageData\"><ImageData WholeExtent=\"0 1 0 1 0 1 2\"/></VTKFile>", "too many numbers"},
        {"<VTKFile type=\"ImageData\"><ImageData WholeExtent=\"0 1 1 0 0 1\"/></VTKFile>", "first and a last index"},
        {"<VTKFile type=\"ImageData\"><ImageData WholeExtent=\"0 1 0 1 0 .5\"/></VTKFile>", "first and a last index"},
        {"<VTKFile type=\"ImageData\"><ImageData WholeExtent=\"0 1 0 1 0 1\" Spacing=\"1 nan 1\"/></VTKFile>",
         "numbers"},
        {PIECES("0 1 0 1 0 0", "0 1 2 3", "0 1 0 1 0 0", "4 5 6 7"), "do not fill the whole extent"},
        {PIECES("0 1 0 1 0 0", "0 1 2 3", "0 1 0 1 1 2", "4 5 6 7 8 9 10 11"), "beyond the whole extent"},
        {PIECES("0 1 0 1 0 0", "0 1 2 3", "0 1 0 1 1 1", "4 5 6"), "array \"v\""},
        {HEAD "<Piece Extent=\"0 1 0 1 0 1\"><PointData><DataArray type=\"UInt8\" Name=\"v\">0 1 2 3 4 5 6 7"
              "</DataArray></PointData></Piece><Piece Extent=\"0 1 0 1 0 1\"/></ImageData></VTKFile>",
         "is not in all pieces"},
        {"<!DOCTYPE a [<!ENTITY b \"c\">]><VTKFile type=\"ImageData\"/>", "document type"},
        {PIECE TAIL, "no array \"density\"; there are none"},
        {ARRAY("type=\"String\"", ""), "not of numbers"},
        {ARRAY("type=\"UInt8\" format=\"hex\"", ""), "format \"hex\""},
        {ARRAY("type=\"UInt8\" NumberOfComponents=\"0\"", ""), "components"},
        {ARRAY("type=\"UInt8\" NumberOfComponents=\"many\"", ""), "whole number"},
        {ARRAY("type=\"UInt8\"", "1 2 3 4 5 6 7"), "array \"v\""},
        {ARRAY("type=\"UInt8\"", "1 2 3 4 5 6 7 x"), "7 numbers instead of 8"},
        {ARRAY("type=\"UInt8\"", "1 2 3 4 5 6 7 8 9"), "something behind its numbers"},
        {ARRAY("type=\"UInt8\" format=\"binary\"", "CAAAAAAB"), "cut short"},
        {ARRAY("type=\"UInt8\" format=\"binary\"", "CAAAAAAB!gMEBQYH"), "damaged"},
        {ARRAY("type=\"UInt8\" format=\"binary\"", "BwAAAAABAgMEBQYH"), "7 bytes; the extent and its type take 8"},
        {ARRAY("type=\"UInt8\" format=\"appended\" offset=\"0\"", ""), "there is no AppendedData"},
        {PIECE
         "<DataArray type=\"UInt8\" Name=\"v\" format=\"appended\" offset=\"99999\"/></PointData></Piece></ImageData>"
         "<AppendedData encoding=\"raw\">_",
         "cut short"},
        {PIECE "<DataArray type=\"UInt8\" Name=\"v\" format=\"appended\" offset=\"18446744073709551615\"/>" TAIL,
         "whole number"},
        {PIECE "</PointData></Piece></ImageData><AppendedData encoding=\"zebra\">_", "encoding \"zebra\""},
        {PIECE "</PointData></Piece></ImageData><AppendedData encoding=\"raw\">x", "underscore"},
        {"<VTKFile type=\"ImageData\"><ImageData WholeExtent=\"0 20000 0 1 0 1\"><Piece Extent=\"0 20000 0 1 0 1\">"
         "<PointData><DataArray type=\"UInt8\" Name=\"v\">1</DataArray>" TAIL,
         "20001 x 2 x 2"},
        {"<VTKFile type=\"ImageData\"><ImageData WholeExtent=\"0 1 0 1 0 1\" Direction=\"1 0 0 1 0 0 0 0 1\">"
         "<Piece Extent=\"0 1 0 1 0 1\"><PointData><DataArray type=\"UInt8\" Name=\"v\">1 2 3 4 5 6 7 "
         "8</DataArray>" TAIL,
         "span no volume"}};
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        put_text("broken.vti", cases[i][0]);
        assert_refused("broken.vti", cases[i][1]);
    }
    char deep[4096] = "<VTKFile type=\"ImageData\">";
    for (int i = 0; i < 100; ++i) strcat(deep, "<a>");
    put_text("deep.vti", deep);
    assert_refused("deep.vti", "nested too deep");
}

/* ---- legacy files ---- */

#define POINTS(kind)                                                                                                   \
    "# vtk DataFile Version 3.0\na title\n" kind "\nDATASET STRUCTURED_POINTS\nDIMENSIONS 2 2 2\nORIGIN 1 2 3\n"       \
    "SPACING 2 1 0.5\n"

static void legacy_files_are_read(void** state) {
    (void)state;
    put_text("a.vtk", POINTS("ASCII") "POINT_DATA 8\nSCALARS v unsigned_char\nLOOKUP_TABLE default\n0 1 2 3 4 5 6 7\n");
    assert_zero_to_seven("a.vtk", 0);
    ty_grid* grid = read_array("a.vtk", "v", 0);
    const ty_grid_info info = ty_grid_get_info(grid);
    assert_float_equal(info.index_to_local.m[0], 2, 0);
    assert_float_equal(info.index_to_local.m[7], 2, 0);
    assert_float_equal(info.index_to_local.m[10], 0.5, 0);
    ty_grid_release(grid);
    put_text("b.vtk",
             POINTS("ascii") "FIELD FieldData 1\nTIME 1 1 double\n0.5\nMETADATA\nINFORMATION 0\n\nCELL_DATA 1\n"
                             "VECTORS speed float\n9 8 7\nPOINT_DATA 8\nLOOKUP_TABLE colours 1\n1 1 1 1\n"
                             "FIELD FieldData 2\nmy%20field 1 8 int\n0 1 2 3 4 5 6 7\nother 1 3 float\n1 2 3\n");
    ty_volume_def def = ty_default_volume_def();
    def.grid = "my field";
    def.exact_grid = true;
    grid = NULL;
    assert_int_equal(ty_volume_read(context, "b.vtk", &def, &grid), TY_OK);
    assert_float_equal(ty_grid_voxel(grid, 1, 1, 1), 7, 0);
    ty_grid_release(grid);
    grid = read_array("b.vtk", "speed", 2);
    assert_float_equal(ty_grid_voxel(grid, 0, 0, 0), 7, 0);
    assert_float_equal(ty_grid_get_info(grid).index_to_local.m[3], 2, 0);
    ty_grid_release(grid);
    /* Big-endian values: two of 16 bits each. */
    uint8_t file[512];
    size_t length = (size_t)snprintf((char*)file, sizeof file, "%s",
                                     POINTS("BINARY") "POINT_DATA 8\nSCALARS v short 2\nLOOKUP_TABLE default\n");
    for (int i = 0; i < 8; ++i) {
        const uint8_t pair[4] = {0, (uint8_t)i, 0xff, (uint8_t)(255 - i)};
        memcpy(file + length, pair, sizeof pair);
        length += sizeof pair;
    }
    put_file("c.vtk", file, length);
    assert_zero_to_seven("c.vtk", 0);
    grid = read_array("c.vtk", "v", 1);
    assert_float_equal(ty_grid_voxel(grid, 1, 0, 0), -2, 0);
    ty_grid_release(grid);
    put_file("cut.vtk", file, length - 1);
    assert_refused("cut.vtk", "cut short");
}

static void broken_legacy_files_are_refused(void** state) {
    (void)state;
    static const char* const cases[][2] = {
        {"# vtk DataFile Version 3.0\nt\nEBCDIC\n", "\"EBCDIC\" is neither ASCII nor BINARY"},
        {"# vtk DataFile Version 3.0\nt\nASCII\n", "no DATASET with DIMENSIONS"},
        {"# vtk DataFile Version 3.0\nt\nASCII\nDATASET POLYDATA\n", "STRUCTURED_POINTS can be read"},
        {POINTS("ASCII") "POINT_DATA 9\n", "do not go with the DIMENSIONS"},
        {POINTS("ASCII") "POINT_DATA many\n", "whole number"},
        {POINTS("ASCII") "SCALARS v float\n", "not a keyword that can stand there"},
        {POINTS("ASCII") "POINT_DATA 8\nSCALARS v complex\nLOOKUP_TABLE default\n1 2 3 4 5 6 7 8", "not a type"},
        {POINTS("ASCII") "POINT_DATA 8\nSCALARS v float 0\nLOOKUP_TABLE default\n", "1 to 65536"},
        {POINTS("ASCII") "POINT_DATA 8\nSCALARS v float\nLOOKUP_TABLE default\n1 2 3 4 5 6 7", "cut short"},
        {POINTS("ASCII") "POINT_DATA 8\nSCALARS v float\nLOOKUP_TABLE default\n1 2 3 4 5 6 7 x",
         "7 numbers instead of 8"},
        {POINTS("BINARY") "POINT_DATA 8\nVECTORS v double\n12345678", "cut short"},
        {POINTS("ASCII") "POINT_DATA 8\nFIELD f 1\nv 18446744073709551615 9 float\n", "whole number"},
        {POINTS("ASCII") "POINT_DATA 8\nFIELD f 1\nv 65536 9223372036854775807 float\n", "cut short"},
        {POINTS("ASCII") "GARBAGE \x1b[31m\n", "\"GARBAGE\""},
        {"# vtk DataFile Version 3.0\nt\nASCII\nDATASET STRUCTURED_POINTS\nDIMENSIONS 0 2 2\n", "from 1 on"},
        {"# vtk DataFile Version 3.0\nt\nASCII\nDATASET STRUCTURED_POINTS\nPOINT_DATA 8\n", "before DIMENSIONS"},
        {"# vtk DataFile Version 3.0\nt\nASCII\nDATASET STRUCTURED_POINTS\nORIGIN 1 2 z\n", "not a number"}};
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        put_text("broken.vtk", cases[i][0]);
        assert_refused("broken.vtk", cases[i][1]);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(fields_come_back, start, stop),
        cmocka_unit_test_setup_teardown(fields_are_checked, start, stop),
        cmocka_unit_test_setup_teardown(short_memory_is_told, start, stop),
        cmocka_unit_test_setup_teardown(every_form_is_read, start, stop),
        cmocka_unit_test_setup_teardown(appended_bytes_are_read, start, stop),
        cmocka_unit_test_setup_teardown(cells_and_directions_place, start, stop),
        cmocka_unit_test_setup_teardown(pieces_are_put_together, start, stop),
        cmocka_unit_test_setup_teardown(broken_vti_files_are_refused, start, stop),
        cmocka_unit_test_setup_teardown(legacy_files_are_read, start, stop),
        cmocka_unit_test_setup_teardown(broken_legacy_files_are_refused, start, stop),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
