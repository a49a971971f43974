/* NetCDF files: axes in any order, units, edges, uneven levels, times, missing values, the extinction of droplets, and
 * broken files. The files are made here, without the library. */
#include "netcdf_maker.h"
#include "strict_fixture.h"

#include <tyndall/io.h>

#include <dlfcn.h>
#include <math.h>

/* Skips the tests where the library is missing. */
static int start_with_library(void** state) {
    static const double values[8] = {0};
    start(state);
    const made_file file = {{"z", "y", "x"}, {2, 2, 2}, {{"q", {0, 1, 2}, 3, {{NULL}}, MADE_FLOAT, values}}};
    make_netcdf("probe.nc", &file);
    const ty_volume_def def = ty_default_volume_def();
    ty_grid* grid = NULL;
    const ty_result result = ty_volume_read(context, "probe.nc", &def, &grid);
    ty_grid_release(grid);
    const char* message = ty_take_error(context);
    if (result == TY_OK) return 0;
    printf("skipped: %s\n", message);
    assert_true(result == TY_ERROR_UNSUPPORTED || strstr(message, "this build reads no NetCDF") != NULL);
    *state = "skipped";
    return 0;
}

static bool is_skipped(void** state) {
    return *state != NULL;
}

static ty_grid* read_def(const char* path, const ty_volume_def* def) {
    ty_grid* grid = NULL;
    if (ty_volume_read(context, path, def, &grid) != TY_OK) fail_msg("%s", ty_take_error(context));
    return grid;
}

static ty_grid* read_named(const char* path, const char* name) {
    ty_volume_def def = ty_default_volume_def();
    def.grid = name;
    def.exact_grid = true;
    return read_def(path, &def);
}

static void assert_refused(const char* path, const ty_volume_def* def, const char* matter) {
    ty_grid* grid = NULL;
    const ty_result result = ty_volume_read(context, path, def, &grid);
    assert_null(grid);
    assert_failed(context, result, TY_ERROR_INPUT, path, matter);
}

static const double xs[] = {0.05, 0.15}, ys[] = {30, 10, -10}, zs[] = {1, 2, 3, 4};

/* Values are 100 i + 10 j + k of ascending coordinates; y descends in the file. */
static void axes_may_have_any_order(void** state) {
    if (is_skipped(state)) skip();
    static const int orders[][3] = {{2, 1, 0}, {0, 1, 2}, {1, 2, 0}, {2, 0, 1}};
    for (size_t o = 0; o < sizeof orders / sizeof orders[0]; ++o) {
        double values[24];
        const int lengths[3] = {2, 3, 4};
        const int* order = orders[o];
        int at[3];
        for (int n = 0; n < 24; ++n) {
            int rest = n;
            for (int d = 2; d >= 0; --d) {
                at[order[d]] = rest % lengths[order[d]];
                rest /= lengths[order[d]];
            }
            values[n] = 100 * at[0] + 10 * (2 - at[1]) + at[2];
        }
        const made_file file = {{"west", "row", "level"},
                                {2, 3, 4},
                                {{"west", {0}, 1, {{"units", "km"}, {"axis", "X"}}, MADE_DOUBLE, xs},
                                 {"row", {1}, 1, {{"units", "meters"}, {"axis", "Y"}}, MADE_FLOAT, ys},
                                 {"level", {2}, 1, {{"units", "m"}, {"standard_name", "altitude"}}, MADE_DOUBLE, zs},
                                 {"q", {order[0], order[1], order[2]}, 3, {{NULL}}, MADE_FLOAT, values}}};
        make_netcdf("order.nc", &file);
        ty_volume_def def = ty_default_volume_def();
        def.meters_per_unit = 10;
        ty_grid* grid = read_def("order.nc", &def);
        const ty_grid_info info = ty_grid_get_info(grid);
        const double expected[12] = {10, 0, 0, 5, 0, 2, 0, -1, 0, 0, 0.1, 0.1};
        for (int i = 0; i < 12; ++i) assert_float_equal(info.index_to_local.m[i], expected[i], 1e-12);
        for (int i = 0; i < 2; ++i)
            for (int j = 0; j < 3; ++j)
                for (int k = 0; k < 4; ++k)
                    assert_float_equal(ty_grid_voxel(grid, i, j, k), (double)(100 * i + 10 * j + k), 0);
        ty_grid_release(grid);
    }
}

/* Levels of 1, 1, 2 and 4 m; the integral of each column stays, and even cells of 1 m hold the value they lie in. */
static void uneven_levels_keep_their_integral(void** state) {
    if (is_skipped(state)) skip();
    static const double centres[] = {0.5, 1.5, 3, 6}, bounds[] = {0, 1, 1, 2, 2, 4, 4, 8},
                        gaps[] = {0, 1, 1, 2, 3, 4, 4, 8};
    static const double values[] = {1, 2, 3, 4, 5, 6, 7, 8}, line[] = {0, 1};
    made_file file = {{"z", "y", "x", "two"},
                      {4, 1, 2, 2},
                      {{"z", {0}, 1, {{"units", "m"}, {"bounds", "z_bnds"}}, MADE_DOUBLE, centres},
                       {"z_bnds", {0, 3}, 2, {{NULL}}, MADE_DOUBLE, bounds},
                       {"y", {1}, 1, {{"units", "m"}}, MADE_DOUBLE, line},
                       {"x", {2}, 1, {{"units", "m"}}, MADE_DOUBLE, line},
                       {"q", {0, 1, 2}, 3, {{NULL}}, MADE_FLOAT, values}}};
    make_netcdf("levels.nc", &file);
    ty_grid* grid = read_named("levels.nc", "q");
    const ty_grid_info info = ty_grid_get_info(grid);
    assert_int_equal(info.size[2], 8);
    assert_float_equal(info.index_to_local.m[10], 1, 1e-12);
    assert_float_equal(info.index_to_local.m[11], 0.5, 1e-12);
    assert_float_equal(info.index_to_local.m[5], 1, 1e-12); /* a single row is as wide as the narrowest cell */
    static const double expected[8] = {1, 3, 5, 5, 7, 7, 7, 7};
    for (int k = 0; k < 8; ++k) assert_float_equal(ty_grid_voxel(grid, 0, 0, k), expected[k], 1e-6);
    ty_grid_release(grid);
    file.variables[1].values = gaps;
    make_netcdf("gaps.nc", &file);
    const ty_volume_def def = ty_default_volume_def();
    assert_refused("gaps.nc", &def, "\"z\" have bounds between which there are gaps");
    /* Edges halfway between coordinates: 0, 1, 2.25, 4.5, 7.5, of which the narrowest cell is 1 m. */
    file.variables[0].attributes[1][0] = NULL;
    make_netcdf("halfway.nc", &file);
    grid = read_named("halfway.nc", "q");
    const ty_grid_info halfway = ty_grid_get_info(grid);
    double column = 0;
    for (int k = 0; k < halfway.size[2]; ++k) column += (double)ty_grid_voxel(grid, 1, 0, k);
    column *= halfway.index_to_local.m[10];
    assert_float_equal(column, 2 * 1 + 4 * 1.25 + 6 * 2.25 + 8 * 3, 1e-5);
    ty_grid_release(grid);
}

/* Cells between edges, as in domains of I3RC, without units: taken as they are. */
static void edges_of_domains_are_read(void** state) {
    if (is_skipped(state)) skip();
    static const double x_edges[] = {0, 2, 4}, y_edges[] = {1, 2}, z_edges[] = {0, 0.5, 1}, values[] = {1, 2, 3, 4};
    const made_file file = {{"x-Edges", "y-Edges", "z-Edges", "x-Grid", "y-Grid", "z-Grid"},
                            {3, 2, 3, 2, 1, 2},
                            {{"x-Edges", {0}, 1, {{NULL}}, MADE_FLOAT, x_edges},
                             {"y-Edges", {1}, 1, {{NULL}}, MADE_FLOAT, y_edges},
                             {"z-Edges", {2}, 1, {{NULL}}, MADE_FLOAT, z_edges},
                             {"Component1_Extinction", {5, 4, 3}, 3, {{NULL}}, MADE_FLOAT, values}}};
    make_netcdf("domain.dom.nc", &file);
    ty_volume_def def = ty_default_volume_def();
    def.meters_per_unit = 1000;
    ty_grid* grid = read_def("domain.dom.nc", &def);
    const double expected[12] = {2, 0, 0, 1, 0, 1, 0, 1.5, 0, 0, 0.5, 0.25};
    const ty_grid_info info = ty_grid_get_info(grid);
    for (int i = 0; i < 12; ++i) assert_float_equal(info.index_to_local.m[i], expected[i], 1e-12);
    assert_float_equal(ty_grid_voxel(grid, 1, 0, 1), 4, 0);
    ty_grid_release(grid);
}

/* Depths of 0.5, 1.5 and 2.5 m are heights below 0, of which the deepest comes first. */
static void depths_go_down(void** state) {
    if (is_skipped(state)) skip();
    static const double depths[] = {0.5, 1.5, 2.5}, line[] = {0, 1};
    static const double values[] = {1, 1, 1, 1, 2, 2, 2, 2, 3, 3, 3, 3};
    const made_file file = {{"depth", "y", "x"},
                            {3, 2, 2},
                            {{"depth", {0}, 1, {{"units", "m"}, {"positive", "down"}}, MADE_DOUBLE, depths},
                             {"y", {1}, 1, {{"units", "m"}}, MADE_DOUBLE, line},
                             {"x", {2}, 1, {{"units", "m"}}, MADE_DOUBLE, line},
                             {"q", {0, 1, 2}, 3, {{NULL}}, MADE_FLOAT, values}}};
    make_netcdf("depth.nc", &file);
    ty_grid* grid = read_named("depth.nc", "q");
    const ty_grid_info info = ty_grid_get_info(grid);
    assert_float_equal(info.index_to_local.m[10], 1, 1e-12);
    assert_float_equal(info.index_to_local.m[11], -2.5, 1e-12);
    for (int k = 0; k < 3; ++k) assert_float_equal(ty_grid_voxel(grid, 0, 1, k), (double)(3 - k), 0);
    ty_grid_release(grid);
}

static void missing_values_are_zero(void** state) {
    if (is_skipped(state)) skip();
    static const double values[] = {-999, 1, 2, 3, 4, 5, NAN, 7};
    static const char* const limits[][4] = {{"_FillValue", "=-999", NULL},
                                            {"missing_value", "=-999", NULL},
                                            {"valid_min", "=0", "valid_max", "=5"},
                                            {"valid_range", "=0,5", NULL}};
    for (size_t i = 0; i < sizeof limits / sizeof limits[0]; ++i) {
        const char* const* limit = limits[i];
        const made_file file = {
            {"a", "b", "c"},
            {2, 2, 2},
            {{"q",
              {0, 1, 2},
              3,
              {{"scale_factor", "=2"}, {"add_offset", "=1"}, {limit[0], limit[1]}, {limit[2], limit[3]}},
              MADE_FLOAT,
              values}}};
        make_netcdf("missing.nc", &file);
        ty_grid* grid = read_named("missing.nc", "q");
        assert_float_equal(ty_grid_voxel(grid, 0, 0, 0), 0, 0);
        assert_float_equal(ty_grid_voxel(grid, 1, 0, 1), 11, 0);
        assert_float_equal(ty_grid_voxel(grid, 0, 1, 1), 0, 0);
        assert_float_equal(ty_grid_voxel(grid, 1, 1, 1), i < 2 ? 15 : 0, 0);
        ty_grid_release(grid);
    }
}

/* Files of version 4 may have texts as strings, such as those that h5netcdf writes. */
static void units_may_be_strings(void** state) {
    if (is_skipped(state)) skip();
    static const char* const names[] = {"libnetcdf.so.22", "libnetcdf.so.19", "libnetcdf.so.18", "libnetcdf.so"};
    static const char *const axes[] = {"z", "y", "x"}, *const units[] = {"km"};
    static const double line[] = {0, 1}, values[8] = {0, 1, 2, 3, 4, 5, 6, 7};
    enum { NETCDF4 = 0x1000, DOUBLE = 6 };
    void* library = NULL;
    for (size_t i = 0; i < sizeof names / sizeof names[0] && library == NULL; ++i) library = dlopen(names[i], RTLD_NOW);
    if (library == NULL) skip();
    int (*create)(const char*, int, int*), (*close)(int), (*end)(int);
    int (*add_dimension)(int, const char*, size_t, int*), (*put)(int, int, const double*);
    int (*add_variable)(int, const char*, int, int, const int*, int*);
    int (*add_strings)(int, int, const char*, size_t, const char**);
    *(void**)&create = dlsym(library, "nc_create");
    *(void**)&close = dlsym(library, "nc_close");
    *(void**)&end = dlsym(library, "nc_enddef");
    *(void**)&add_dimension = dlsym(library, "nc_def_dim");
    *(void**)&put = dlsym(library, "nc_put_var_double");
    *(void**)&add_variable = dlsym(library, "nc_def_var");
    *(void**)&add_strings = dlsym(library, "nc_put_att_string");
    int file, dimensions[3], lines[3], variable;
    if (create("strings.nc", NETCDF4, &file) != 0) skip();
    for (int a = 0; a < 3; ++a) {
        const char* unit[] = {units[0]};
        assert_int_equal(add_dimension(file, axes[a], 2, &dimensions[a]), 0);
        assert_int_equal(add_variable(file, axes[a], DOUBLE, 1, &dimensions[a], &lines[a]), 0);
        assert_int_equal(add_strings(file, lines[a], "units", 1, unit), 0);
    }
    assert_int_equal(add_variable(file, "q", DOUBLE, 3, dimensions, &variable), 0);
    assert_int_equal(end(file), 0);
    for (int a = 0; a < 3; ++a) assert_int_equal(put(file, lines[a], line), 0);
    assert_int_equal(put(file, variable, values), 0);
    assert_int_equal(close(file), 0);
    ty_grid* grid = read_named("strings.nc", "q");
    assert_float_equal(ty_grid_get_info(grid).index_to_local.m[0], 1000, 1e-9);
    assert_float_equal(ty_grid_voxel(grid, 1, 1, 0), 3, 0);
    ty_grid_release(grid);
    dlclose(library);
}

static void times_are_components(void** state) {
    if (is_skipped(state)) skip();
    static double values[2 * 8];
    for (int i = 0; i < 16; ++i) values[i] = i;
    values[9] = 9.969209968386869e36; /* not written */
    const made_file file = {
        {"time", "a", "b", "c"}, {2, 2, 2, 2}, {{"q", {0, 1, 2, 3}, 4, {{NULL}}, MADE_FLOAT, values}}};
    make_netcdf("times.nc", &file);
    ty_volume_def def = ty_default_volume_def();
    int32_t times = 0;
    assert_int_equal(ty_volume_components(context, "times.nc", &def, &times), TY_OK);
    assert_int_equal(times, 2);
    def.component = 1;
    ty_grid* grid = read_def("times.nc", &def);
    assert_false(ty_grid_get_info(grid).placed);
    assert_float_equal(ty_grid_voxel(grid, 1, 0, 0), 0, 0);
    assert_float_equal(ty_grid_voxel(grid, 0, 1, 1), 14, 0);
    ty_grid_release(grid);
    def.component = 2;
    assert_refused("times.nc", &def, "component 2");
    ty_vdb_entry entry;
    int32_t count = 0;
    assert_int_equal(ty_volume_list(context, "times.nc", &entry, 1, &count), TY_OK);
    assert_int_equal(count, 1);
    assert_string_equal(entry.type, "float[2]");
}

/* ---- droplets ---- */

static const double water[] = {0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7}, radii[] = {8, 12},
                    ratios[] = {0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7};
static const double airs[] = {1.25, 1}, ones[] = {0, 1};

static const made_file cloud = {{"z", "y", "x"},
                                {2, 2, 2},
                                {{"z", {0}, 1, {{"units", "m"}}, MADE_DOUBLE, ones},
                                 {"y", {1}, 1, {{"units", "m"}}, MADE_DOUBLE, ones},
                                 {"x", {2}, 1, {{"units", "m"}}, MADE_DOUBLE, ones},
                                 {"lwc", {0, 1, 2}, 3, {{"units", "g m**-3"}}, MADE_FLOAT, water},
                                 {"qc", {0, 1, 2}, 3, {{"units", "g/kg"}}, MADE_FLOAT, ratios},
                                 {"odd", {0, 1, 2}, 3, {{"units", "furlong"}}, MADE_FLOAT, ratios},
                                 {"reff", {0}, 1, {{"units", "um"}}, MADE_FLOAT, radii},
                                 {"rho", {0}, 1, {{"units", "kg m-3"}}, MADE_FLOAT, airs},
                                 {"one_radius", {0}, 0, {{"units", "um"}}, MADE_FLOAT, radii}}};

/* sigma_t = 3 LWC / (2 rho_w r_e): 0.4 g/m^3 of droplets of 12 micrometres have 0.05/m. */
static void droplets_have_their_extinction(void** state) {
    if (is_skipped(state)) skip();
    make_netcdf("cloud.nc", &cloud);
    ty_volume_def def = ty_default_volume_def();
    def.grid = "lwc";
    def.effective_radius = "reff";
    ty_grid* grid = read_def("cloud.nc", &def);
    assert_float_equal(ty_grid_voxel(grid, 0, 0, 1), 0.05, 1e-8);
    for (int i = 0; i < 8; ++i)
        assert_float_equal(ty_grid_voxel(grid, i & 1, i >> 1 & 1, i >> 2), 1.5 * water[i] / radii[i >> 2], 1e-7);
    ty_grid_release(grid);
    def.effective_radius = "one_radius"; /* a scalar */
    grid = read_def("cloud.nc", &def);
    for (int i = 0; i < 8; ++i)
        assert_float_equal(ty_grid_voxel(grid, i & 1, i >> 1 & 1, i >> 2), 1.5 * water[i] / radii[0], 1e-7);
    ty_grid_release(grid);
    def.effective_radius = NULL;
    def.droplet_radius = 10;
    def.grid = "qc";
    def.air_density = "rho";
    grid = read_def("cloud.nc", &def);
    for (int i = 0; i < 8; ++i)
        assert_float_equal(ty_grid_voxel(grid, i & 1, i >> 1 & 1, i >> 2), 1.5 * ratios[i] * airs[i >> 2] / 10, 1e-7);
    ty_grid_release(grid);
    def.air_density = NULL;
    assert_refused("cloud.nc", &def, "whose density (air_density) is not given");
    def.air_density_value = 1;
    def.effective_radius = "gone";
    assert_refused("cloud.nc", &def, "no variable \"gone\"");
    def.effective_radius = "rho";
    assert_refused("cloud.nc", &def, "\"rho\" is in \"kg m-3\"");
    def.effective_radius = "reff";
    def.grid = "odd";
    assert_refused("cloud.nc", &def, "\"furlong\", which is no content of water");
}

/* ---- broken files ---- */

static void broken_files_are_refused(void** state) {
    if (is_skipped(state)) skip();
    static const double line[] = {1, 2}, back[] = {1, 1}, values[8] = {1, 2, 3, 4, 5, 6, 7, 8};
    made_file file = {{"z", "y", "x"},
                      {2, 2, 2},
                      {{"z", {0}, 1, {{"units", "hPa"}}, MADE_DOUBLE, line},
                       {"y", {1}, 1, {{"units", "m"}}, MADE_DOUBLE, line},
                       {"x", {2}, 1, {{"units", "m"}}, MADE_DOUBLE, line},
                       {"q", {0, 1, 2}, 3, {{NULL}}, MADE_FLOAT, values}}};
    ty_volume_def def = ty_default_volume_def();
    make_netcdf("broken.nc", &file);
    assert_refused("broken.nc", &def, "\"z\" are in \"hPa\", which is no length");
    file.variables[0].attributes[0][1] = "m";
    file.variables[0].values = back;
    make_netcdf("broken.nc", &file);
    assert_refused("broken.nc", &def, "\"z\" do not ascend or descend");
    file.variables[0] = (made_variable){"unused", {0}, 1, {{NULL}}, MADE_DOUBLE, line};
    make_netcdf("broken.nc", &file);
    assert_refused("broken.nc", &def, "along some of its axes");
    const made_file twins = {{"x"}, {2}, {{"q", {0, 0, 0}, 3, {{NULL}}, MADE_FLOAT, values}}};
    make_netcdf("twins.nc", &twins);
    assert_refused("twins.nc", &def, "no variable \"density\" of three axes; those that are: none");
    def.grid = "smoke";
    def.exact_grid = true;
    assert_refused("broken.nc", &def, "no variable \"smoke\" of three axes; those that are: q");
    def = ty_default_volume_def();
    size_t size = 0;
    make_netcdf("whole.nc", &cloud);
    uint8_t* bytes = get_file("whole.nc", &size);
    put_file("cut.nc", bytes, size - 1);
    assert_refused("cut.nc", &def, "cut short");
    put_file("head.nc", bytes, 90);
    assert_refused("head.nc", &def, "the header is damaged or cut short");
    put_file("none.nc", "not one", 7);
    assert_refused("none.nc", &def, "none.nc");
    free(bytes);
}

static ty_result read_again(ty_context* own, void* user) {
    ty_grid* grid = NULL;
    const ty_result result = ty_volume_read(own, "memory.nc", user, &grid);
    ty_grid_release(grid);
    return result;
}

/* ---- large files ---- */

enum { FIELD_SIDE = 200, FIELD_LEVELS = 160, FIELD_LAYER = FIELD_SIDE * FIELD_SIDE };

/* A field of liquid water in one column, with a radius for each cell, behind a head of the maker's. */
static void make_field(const char* path, bool descending, bool uneven) {
    static double axis[FIELD_SIDE], levels[FIELD_LEVELS];
    static made_bytes head;
    static uint8_t layer[4 * FIELD_LAYER];
    const made_file file = {{"z", "y", "x"},
                            {FIELD_LEVELS, FIELD_SIDE, FIELD_SIDE},
                            {{"x", {2}, 1, {{"units", "m"}}, MADE_DOUBLE, axis},
                             {"y", {1}, 1, {{"units", "m"}}, MADE_DOUBLE, axis},
                             {"z", {0}, 1, {{"units", "m"}}, MADE_DOUBLE, levels},
                             {"lwc", {0, 1, 2}, 3, {{"units", "g m-3"}}, MADE_FLOAT, NULL},
                             {"reff", {0, 1, 2}, 3, {{"units", "um"}}, MADE_FLOAT, NULL}}};
    made_file lines = file;
    double level = 0, width = 10;
    for (int i = 0; i < FIELD_SIDE; ++i) axis[i] = 10.0 * i;
    for (int k = 0; k < FIELD_LEVELS; ++k) {
        const double next = uneven && k >= FIELD_LEVELS / 2 ? 20 : 10;
        level += k == 0 ? 0 : (width + next) / 2;
        width = next;
        levels[descending ? FIELD_LEVELS - 1 - k : k] = level;
    }
    lines.variables[3].name = NULL;
    made_head(&head, &file, made_head(&head, &file, 0));
    made_data(&head, &lines);
    FILE* stream = fopen(path, "wb");
    assert_non_null(stream);
    assert_int_equal(fwrite(head.bytes, 1, head.size, stream), head.size);
    for (int v = 0; v < 2; ++v)
        for (int k = 0; k < FIELD_LEVELS; ++k) {
            const int height = descending ? FIELD_LEVELS - 1 - k : k;
            const float value = v == 0 ? 0.01f * (float)(1 + height) : 10;
            uint32_t bits;
            memset(layer, 0, sizeof layer);
            memcpy(&bits, &value, sizeof bits);
            for (int b = 0; b < 4; ++b) layer[4 * (60 * FIELD_SIDE + 50) + b] = (uint8_t)(bits >> (24 - 8 * b));
            assert_int_equal(fwrite(layer, 1, sizeof layer, stream), sizeof layer);
        }
    assert_int_equal(fclose(stream), 0);
}

/* Water and radii are read slab by slab: a field that is nearly empty takes memory for what is in it. */
static void large_fields_are_never_dense(void** state) {
    if (is_skipped(state)) skip();
    for (int kind = 0; kind < 2; ++kind) {
        const bool uneven = kind == 1;
        ty_volume_def def = ty_default_volume_def();
        def.grid = "lwc";
        def.effective_radius = "reff";
        make_field("field.nc", uneven, uneven);
        memory.limit =
            (size_t)18 << 20; /* the head takes 16 MiB; the dense array has 24.4, and 36.6 with even levels */
        ty_grid* grid = read_def("field.nc", &def);
        memory.limit = (size_t)1 << 30;
        const ty_grid_info info = ty_grid_get_info(grid);
        assert_int_equal(info.storage, TY_GRID_SPARSE);
        assert_int_equal(info.size[2], uneven ? FIELD_LEVELS * 3 / 2 : FIELD_LEVELS);
        assert_int_equal(info.active, info.size[2]);
        assert_float_equal(info.index_to_local.m[10], 10, 1e-9);
        double found = 0, integral = 0;
        for (int k = 0; k < info.size[2]; ++k) {
            const double value = (double)ty_grid_voxel(grid, 50, 60, k);
            if (!uneven) assert_float_equal(value, 0.0015 * (1 + k), 1e-7);
            found += 10 * value;
        }
        /* Edges are halfway between levels: 2.5 m are of the last narrow one. */
        for (int k = 0; k < FIELD_LEVELS; ++k) {
            const double width = !uneven || k < FIELD_LEVELS / 2 ? 10 : 20;
            const double moved = !uneven ? 0 : k == FIELD_LEVELS / 2 - 1 ? 2.5 : k == FIELD_LEVELS / 2 ? -2.5 : 0;
            integral += 0.0015 * (1 + k) * (width + moved);
        }
        assert_float_equal(found, integral, 1e-5 * integral);
        ty_grid_release(grid);
    }
    remove("field.nc");
}

static void short_memory_is_told(void** state) {
    if (is_skipped(state)) skip();
    make_netcdf("memory.nc", &cloud);
    ty_volume_def def = ty_default_volume_def();
    def.grid = "qc";
    def.effective_radius = "reff";
    def.air_density = "rho";
    assert_true(check_short_memory(context, &memory, read_again, &def) >= 8);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(axes_may_have_any_order, start_with_library, stop),
        cmocka_unit_test_setup_teardown(uneven_levels_keep_their_integral, start_with_library, stop),
        cmocka_unit_test_setup_teardown(edges_of_domains_are_read, start_with_library, stop),
        cmocka_unit_test_setup_teardown(depths_go_down, start_with_library, stop),
        cmocka_unit_test_setup_teardown(missing_values_are_zero, start_with_library, stop),
        cmocka_unit_test_setup_teardown(units_may_be_strings, start_with_library, stop),
        cmocka_unit_test_setup_teardown(times_are_components, start_with_library, stop),
        cmocka_unit_test_setup_teardown(droplets_have_their_extinction, start_with_library, stop),
        cmocka_unit_test_setup_teardown(broken_files_are_refused, start_with_library, stop),
        cmocka_unit_test_setup_teardown(large_fields_are_never_dense, start_with_library, stop),
        cmocka_unit_test_setup_teardown(short_memory_is_told, start_with_library, stop),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
