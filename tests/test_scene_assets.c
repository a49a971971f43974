/* Scene files that name other files: volumes of every kind, fields, sequences, closed meshes, mesh files, cameras, and
 * the hash over all of them. */
#define _GNU_SOURCE
#include "dicom_maker.h"
#include "level_maker.h"
#include "netcdf_maker.h"

#include "scene/scene.h"
#include "scene/surfaces/closed_mesh.h"

#include <sys/stat.h>
#include <tyndall/io.h>

#define HEAD "{'tyndall':1,"
#define BOX "'bounds':[[0,0,0],[1,1,1]]"

static log_book book;
static ty_context* context;

static int start(void** state) {
    (void)state;
    context = logged_context(&book, 2);
    put_nrrd("gray.nrrd", 1, "0.25 0.75");
    put_nrrd("rgb.nrrd", 3, "0.1 0.2 0.3 0.4 0.5 0.6");
    put_nrrd("pair.nrrd", 2, "1 2 3 4");
    put_nrrd("smoke_0003.nrrd", 1, "0 3");
    put_nrrd("smoke_0004.nrrd", 1, "0 4");
    put_file("bytes.raw", "x\0\1\0\2", 5);
    put_tetrahedron("tetra.obj");
    put_level();
    return 0;
}

static int stop(void** state) {
    (void)state;
    ty_context_destroy(context);
    return 0;
}

static ty_scene* load_with(const char* text, const char* override) {
    ty_scene* scene = NULL;
    const char* json = quoted(text);
    book = (log_book){0};
    if (ty_scene_parse(context, json, strlen(json), "s.json", "", &override, override != NULL, &scene) != TY_OK)
        fail_msg("%s", ty_take_error(context));
    return scene;
}

static ty_scene* load(const char* text) {
    return load_with(text, NULL);
}

static ty_medium_def medium_of(const ty_scene* scene, int32_t index) {
    ty_medium_def medium;
    assert_int_equal(ty_scene_get_medium(scene, index, &medium), TY_OK);
    return medium;
}

static void refuse(const char* text, const char* message) {
    ty_scene* scene = NULL;
    const char* json = quoted(text);
    assert_int_equal(ty_scene_parse(context, json, strlen(json), "s.json", "", NULL, 0, &scene), TY_ERROR_INPUT);
    assert_string_equal(ty_take_error(context), message);
    assert_null(scene);
}

static void expect_point(const double v[3], double x, double y, double z) {
    const double expected[3] = {x, y, z};
    for (int a = 0; a < 3; ++a)
        if (!(fabs(v[a] - expected[a]) < 1e-5)) fail_msg("(%g, %g, %g), not (%g, %g, %g)", v[0], v[1], v[2], x, y, z);
}

static void expect_color(const float c[3], float r, float g, float b) {
    expect_point((const double[]){(double)c[0], (double)c[1], (double)c[2]}, (double)r, (double)g, (double)b);
}

/* ---- Volumes ---- */

static void frames_pick_files(void** state) {
    (void)state;
    const char* text = HEAD "'frame':3,'media':[{'sigma_s':1,'density':{'file':'smoke_####.nrrd'}},"
                            "{'sigma_s':1,'density':{'file':'smoke_####.nrrd','frame':4}},"
                            "{'sigma_s':1,'density':{'file':'smoke_0003.nrrd'}}]}";
    ty_scene* scene = load(text);
    assert_float_equal(ty_grid_get_info(medium_of(scene, 0).density_grid).max, 3, 0);
    assert_float_equal(ty_grid_get_info(medium_of(scene, 1).density_grid).max, 4, 0);
    assert_ptr_equal(medium_of(scene, 0).density_grid, medium_of(scene, 2).density_grid);
    const uint64_t hash = ty_scene_hash(scene);
    ty_scene_destroy(scene);
    scene = load_with(text, "frame=4");
    assert_ptr_equal(medium_of(scene, 0).density_grid, medium_of(scene, 1).density_grid);
    assert_float_equal(ty_grid_get_info(medium_of(scene, 0).density_grid).max, 4, 0);
    assert_true(ty_scene_hash(scene) != hash);
    ty_scene_destroy(scene);
}

static void folders_keep_their_signs(void** state) {
    (void)state;
    mkdir("a#b", 0777);
    put_nrrd("a#b/smoke_12.nrrd", 1, "0 12");
    put_text("a#b/scene.json", quoted(HEAD "'frame':12,'media':[{'sigma_s':1,'density':{'file':'smoke_##.nrrd'}}]}"));
    ty_scene* scene = NULL;
    if (ty_scene_load(context, "a#b/scene.json", NULL, 0, &scene) != TY_OK) fail_msg("%s", ty_take_error(context));
    assert_float_equal(ty_grid_get_info(medium_of(scene, 0).density_grid).max, 12, 0);
    ty_scene_destroy(scene);
}

static void raw_volumes_are_read(void** state) {
    (void)state;
    ty_scene* scene =
        load(HEAD "'media':[{'sigma_s':1," BOX ",'density':{'file':'bytes.raw','raw':{'size':[2,1,1],'type':'uint16',"
                  "'offset':1}}},{'sigma_s':1,'density':{'file':'bytes.raw','raw':{'size':[2,1,1],'type':'uint16',"
                  "'offset':-1,'big_endian':true,'spacing':[1,2,3]}}}]}");
    const ty_grid_info little = ty_grid_get_info(medium_of(scene, 0).density_grid);
    const ty_grid_info big = ty_grid_get_info(medium_of(scene, 1).density_grid);
    assert_false(little.placed);
    assert_float_equal(little.max, 512, 0);
    assert_float_equal(little.min, 256, 0);
    assert_true(big.placed);
    assert_float_equal(big.max, 2, 0);
    assert_float_equal(big.index_to_local.m[5], 2, 0);
    ty_scene_destroy(scene);
}

static void components_are_chosen(void** state) {
    (void)state;
    ty_scene* scene = load(HEAD "'media':[{'sigma_s':1,'density':{'file':'pair.nrrd','component':1}},"
                                "{'sigma_s':1,'density':{'file':'pair.nrrd','component':0}},"
                                "{'sigma_s':1,'density':{'file':'pair.nrrd','component':1}}]}");
    assert_float_equal(ty_grid_get_info(medium_of(scene, 0).density_grid).max, 4, 0);
    assert_float_equal(ty_grid_get_info(medium_of(scene, 1).density_grid).max, 3, 0);
    assert_ptr_equal(medium_of(scene, 0).density_grid, medium_of(scene, 2).density_grid);
    ty_scene_destroy(scene);
}

static void albedo_and_g_come_from_volumes(void** state) {
    (void)state;
    ty_scene* scene = load(HEAD "'media':["
                                "{'sigma_t':2," BOX ",'albedo':{'file':'gray.nrrd'},'g':{'file':'gray.nrrd'}},"
                                "{'sigma_t':2," BOX ",'albedo':{'file':'rgb.nrrd'},'density':{'file':'gray.nrrd'}},"
                                "{'sigma_t':2," BOX ",'albedo':{'file':'rgb.nrrd','component':2}}]}");
    const ty_medium_def gray = medium_of(scene, 0), rgb = medium_of(scene, 1), blue = medium_of(scene, 2);
    expect_color(gray.sigma_s, 0, 0, 0);
    expect_color(gray.sigma_a, 2, 2, 2);
    assert_ptr_equal(gray.albedo_grid[0], gray.albedo_grid[2]);
    assert_ptr_equal(gray.albedo_grid[0], gray.g_grid);
    assert_ptr_equal(gray.g_grid, rgb.density_grid);
    for (int c = 0; c < 3; ++c) assert_float_equal(ty_grid_get_info(rgb.albedo_grid[c]).max, 0.4 + 0.1 * c, 1e-6);
    for (int c = 0; c < 3; ++c) assert_ptr_equal(blue.albedo_grid[c], rgb.albedo_grid[2]);
    ty_scene_destroy(scene);
}

static void emission_comes_from_files(void** state) {
    (void)state;
    ty_scene* scene =
        load(HEAD "'media':[{'sigma_a':1," BOX ",'emission':{'radiance':[1,2,3]}},"
                  "{'sigma_a':1,'density':{'file':'gray.nrrd'},'emission':{'temperature':{'file':"
                  "'gray.nrrd'},'kelvin':[300,1500],'scale':0.5,'radiance':4}},"
                  "{'sigma_a':1," BOX ",'emission':{'temperature':{'file':'bytes.raw','raw':{'size':[5,1,1]}}}}]}");
    const ty_medium_def steady = medium_of(scene, 0), burning = medium_of(scene, 1), plain = medium_of(scene, 2);
    expect_color(steady.emission, 1, 2, 3);
    assert_null(steady.temperature_grid);
    expect_color(burning.emission, 4, 4, 4);
    assert_ptr_equal(burning.temperature_grid, burning.density_grid);
    assert_float_equal(burning.kelvin[0], 300, 0);
    assert_float_equal(burning.kelvin[1], 1500, 0);
    assert_float_equal(burning.emission_scale, 0.5, 0);
    assert_float_equal(plain.kelvin[1], 1, 0);
    assert_float_equal(plain.emission_scale, 1, 0);
    ty_scene_destroy(scene);
}

static void transfer_functions_are_read(void** state) {
    (void)state;
    ty_scene* scene =
        load(HEAD "'media':[{'sigma_t':[1,2,3],'density':{'file':'gray.nrrd'},'transfer':["
                  "{'value':-1,'density':0,'albedo':1},{'value':0.5,'density':2,'albedo':[0.1,0.2,0.3]}]},"
                  "{'sigma_s':1,'sigma_a':2," BOX ",'density':{'noise':{'resolution':4}},'transfer':["
                  "{'value':0,'density':0},{'value':0.1,'density':1},{'value':0.2,'density':0}]}]}");
    const ty_medium_def tissue = medium_of(scene, 0), layer = medium_of(scene, 1);
    expect_color(tissue.sigma_a, 1, 2, 3);
    assert_int_equal(tissue.transfer_count, 2);
    assert_true(tissue.transfer_albedo);
    assert_float_equal(tissue.transfer[0].value, -1, 0);
    assert_float_equal(tissue.transfer[1].density, 2, 0);
    expect_color(tissue.transfer[0].albedo, 1, 1, 1);
    expect_color(tissue.transfer[1].albedo, 0.1f, 0.2f, 0.3f);
    expect_color(layer.sigma_s, 1, 1, 1);
    assert_int_equal(layer.transfer_count, 3);
    assert_false(layer.transfer_albedo);
    ty_scene_destroy(scene);
}

static void fields_are_placed_in_units(void** state) {
    (void)state;
    ty_scene* scene = load(HEAD "'meters_per_unit':0.5,'media':[{'sigma_a':1,'bounds':[[0,0,0],[2,4,8]],"
                                "'transform':{'translate':[2,0,0]},'emission':{'temperature':{'file':'gray.nrrd'}}}]}");
    const ty_medium_def medium = medium_of(scene, 0);
    double corner[3];
    ty_affine_point(&medium.transform, medium.box_max, corner);
    expect_point(corner, 2, 2, 4);
    const double index[3] = {1, 0, 0};
    const ty_affine place = ty_grid_get_info(medium.temperature_grid).index_to_local;
    ty_affine_point(&place, index, corner);
    ty_affine_point(&medium.transform, corner, corner);
    expect_point(corner, 1.5, 0, 0);
    ty_scene_destroy(scene);
}

static void wrong_volumes_are_refused(void** state) {
    (void)state;
    refuse(HEAD "'media':[{'sigma_s':1,'density':{'file':'pair.nrrd'}}]}",
           "s.json:1: media[0].density: the volume has 2 values per voxel; the key \"component\" is missing");
    refuse(
        HEAD "'media':[{'sigma_t':1," BOX ",'albedo':{'file':'pair.nrrd'}}]}",
        "s.json:1: media[0].albedo: the volume has 2 values per voxel, not 1 or 3; the key \"component\" is missing");
    refuse(HEAD "'media':[{'sigma_s':1,'density':{'file':'pair.nrrd','component':2}}]}",
           "s.json:1: media[0].density.file: pair.nrrd has 2 values per voxel; component 2 is not among them");
    refuse(HEAD "'media':[{'sigma_s':1,'bounds':{'sphere':{'center':[0,0,0],'radius':1}},"
                "'g':{'file':'bytes.raw','raw':{'size':[5,1,1]}}}]}",
           "s.json:1: media[0].g: a raw volume without spacing needs bounds that are a box, [[x,y,z],[x,y,z]]");
    refuse(HEAD "'media':[{'sigma_s':1," BOX ",'density':{'file':'bytes.raw','raw':{'size':[6,1,1]}}}]}",
           "s.json:1: media[0].density.file: bytes.raw: 5 bytes; 6 x 1 x 1 voxels of uint8 after 0 bytes are 6");
}

/* ---- Meshes ---- */

static void closed_meshes_bound_media(void** state) {
    (void)state;
    ty_scene* scene =
        load(HEAD "'meters_per_unit':0.5,'up_axis':'z','camera':{'position':[9,9,9]},'media':["
                  "{'sigma_s':1,'bounds':{'file':'tetra.obj','transform':{'translate':[2,0,0],'scale':4}},"
                  "'transform':{'translate':[0,0,6]}},"
                  "{'sigma_s':1,'bounds':{'file':'tetra.obj','transform':{'scale':4,'translate':[2,0,0]}}},"
                  "{'sigma_s':1,'bounds':{'file':'level.gltf'}},"
                  "{'sigma_s':1,'density':{'file':'gray.nrrd'},'bounds':{'file':'tetra.obj'},"
                  "'transform':{'scale':2}}]}");
    const ty_medium_def first = medium_of(scene, 0), turned = medium_of(scene, 2), cut = medium_of(scene, 3);
    double corner[3];
    assert_int_equal(first.bounds, TY_BOUNDS_SHELL);
    ty_affine_point(&first.transform, first.shell->triangles->upper, corner);
    expect_point(corner, 3, 2, 5);
    assert_ptr_equal(first.shell, medium_of(scene, 1).shell);
    ty_affine_point(&turned.transform, turned.shell->triangles->lower, corner);
    expect_point(corner, 0, -0.5, 0);
    ty_affine_point(&cut.transform, cut.shell->triangles->upper, corner);
    expect_point(corner, 1, 1, 1);
    ty_scene_destroy(scene);
}

static void mesh_files_are_geometry(void** state) {
    (void)state;
    ty_scene* scene = load(HEAD "'meters_per_unit':2,'geometry':[{'file':'level.gltf','light_scale':10,"
                                "'emission_scale':5,'transform':{'translate':[1,0,0]}},"
                                "{'file':'level.gltf','lights':false,'material':{'albedo':0.25}},"
                                "{'file':'level.gltf','meshes':false},{'file':'tetra.obj'}]}");
    const ty_scene_info info = ty_scene_get_info(scene);
    assert_int_equal(info.meshes, 3);
    assert_int_equal(info.triangles, 12);
    assert_int_equal(info.lights, 2);
    expect_point(info.upper, 4, 2, 2);
    expect_color(scene->lights[0].color, 30, 30, 30);
    expect_point(scene->lights[0].position, 2, 4, 0);
    expect_color(scene->lights[1].color, 3, 3, 3);
    expect_color(scene->meshes[0]->material.emission, 5, 5, 5);
    expect_color(scene->meshes[1]->material.emission, 0, 0, 0);
    expect_color(scene->meshes[1]->material.albedo, 0.25f, 0.25f, 0.25f);
    ty_scene_destroy(scene);
}

static void gltf_turns_into_z_up(void** state) {
    (void)state;
    ty_scene* scene = load(HEAD "'up_axis':'z','geometry':[{'file':'level.gltf'},{'file':'tetra.obj'}]}");
    expect_point(scene->lights[0].position, 0, 0, 2);
    expect_point(scene->meshes[0]->lower, 0, -1, 0);
    expect_point(scene->meshes[1]->lower, 0, 0, 0);
    expect_point(ty_scene_camera(scene).position, 0, -5, 0);
    expect_point(ty_scene_camera(scene).up, 0, 0, 1);
    ty_scene_destroy(scene);
}

/* ---- Cameras ---- */

static void cameras_come_from_files(void** state) {
    (void)state;
    ty_scene* scene = load(HEAD "'meters_per_unit':2,'camera':{'file':'level.gltf','name':'side','exposure':1,"
                                "'resolution':[8,4]}}");
    ty_camera_def camera = ty_scene_camera(scene);
    expect_point(camera.position, 2, 4, 6);
    expect_point(camera.target, 2, 4, 5);
    assert_float_equal(camera.fov_y, 28.6478897, 1e-5);
    assert_float_equal(camera.exposure, 1, 0);
    assert_int_equal(camera.resolution[0], 8);
    assert_string_equal(ty_scene_camera_source(scene), "\"side\" of level.gltf");
    ty_scene_destroy(scene);
    scene = load(HEAD "'camera':{'file':'level.gltf','position':[1,1,1],'target':[1,1,0],'up':[1,0,0],'fov_y':10},"
                      "'geometry':[{'file':'level.gltf','transform':{'translate':[0,0,9]}}]}");
    camera = ty_scene_camera(scene);
    expect_point(camera.position, 1, 1, 1);
    expect_point(camera.target, 1, 1, 0);
    expect_point(camera.up, 1, 0, 0);
    assert_float_equal(camera.fov_y, 10, 0);
    ty_scene_destroy(scene);
    scene = load(HEAD "'camera':{'file':'level.gltf'},"
                      "'geometry':[{'file':'level.gltf','transform':{'translate':[0,0,9]}}]}");
    expect_point(ty_scene_camera(scene).position, 0, 0, 14);
    ty_scene_destroy(scene);
}

static void the_geometrys_camera_is_used(void** state) {
    (void)state;
    ty_scene* scene = load(HEAD "'geometry':[{'file':'tetra.obj'},{'file':'level.gltf'}]}");
    expect_point(ty_scene_camera(scene).target, 0, 0, 4);
    assert_float_equal(ty_scene_camera(scene).fov_y, 57.2957795, 1e-5);
    assert_string_equal(ty_scene_camera_source(scene), "the first of level.gltf");
    const int infos = book.infos;
    ty_scene_destroy(scene);
    scene = load_with(HEAD "'geometry':[{'file':'level.gltf'}]}", "camera.fov_y=10");
    expect_point(ty_scene_camera(scene).target, 0, 0, 4);
    assert_float_equal(ty_scene_camera(scene).fov_y, 10, 0);
    ty_scene_destroy(scene);
    scene = load_with(HEAD "'geometry':[{'file':'level.gltf'}]}", "camera.position=[0,0,7]");
    expect_point(ty_scene_camera(scene).target, 0, 0, 0);
    assert_string_equal(ty_scene_camera_source(scene), "");
    ty_scene_destroy(scene);
    scene = load_with(HEAD "'geometry':[{'file':'tetra.obj'},{'file':'level.gltf'}]}", "camera.position=[0,0,7]");
    assert_int_equal(book.infos, infos - 1); /* all but the line about the camera */
    ty_scene_destroy(scene);
    refuse(HEAD "'camera':{'file':'level.gltf','name':'back'}}",
           "s.json:1: camera.name: level.gltf: no camera \"back\"; known: \"front\", \"side\"");
}

/* ---- Hash ---- */

static uint64_t hash_of(const char* text) {
    ty_scene* scene = load(text);
    const uint64_t hash = ty_scene_hash(scene);
    ty_scene_destroy(scene);
    return hash;
}

static void the_hash_follows_files_within_files(void** state) {
    (void)state;
    const char* level = HEAD "'geometry':[{'file':'level.gltf'}]}";
    uint64_t before = hash_of(level);
    assert_true(before == hash_of(level));
    size_t size = 0;
    uint8_t* bytes = get_file("level .bin", &size);
    bytes[2] = 1;
    put_file("level .bin", bytes, size);
    free(bytes);
    assert_true(before != hash_of(level));

    const char* model = HEAD "'geometry':[{'file':'painted.obj'}]}";
    put_text("painted.obj", "mtllib painted.mtl\nusemtl red\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    put_text("painted.mtl", "newmtl red\nKd 1 0 0\n");
    before = hash_of(model);
    put_text("painted.mtl", "newmtl red\nKd 1 0 1\n");
    assert_true(before != hash_of(model));

    const char* scan = HEAD "'media':[{'sigma_s':1,'density':{'file':'scan.nhdr'}}]}";
    put_text("scan.nhdr", "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 2 1 1\nspacings: 1 1 1\nencoding: raw\n"
                          "data file: scan.bytes\n");
    put_file("scan.bytes", "\1\2", 2);
    before = hash_of(scan);
    put_file("scan.bytes", "\1\3", 2);
    assert_true(before != hash_of(scan));
}

/* ---- The manual ---- */

static void put_vdb(const char* path, const char* grid_name) {
    const float values[] = {0, 1};
    ty_grid_def def = ty_default_grid_def();
    def.size[0] = 2;
    def.size[1] = def.size[2] = 1;
    def.values = values;
    def.placed = true;
    ty_grid* grid = NULL;
    assert_int_equal(ty_grid_create(context, &def, &grid), TY_OK);
    assert_int_equal(ty_vdb_write(context, grid, grid_name, "none", path), TY_OK);
    ty_grid_release(grid);
}

/* The files that the examples name. */
static void put_map(const char* path) {
    ty_image* image = NULL;
    assert_int_equal(ty_image_create_rgb(context, 2, 2, &image), TY_OK);
    for (int c = 0; c < 3; ++c)
        for (int i = 0; i < 4; ++i) ty_image_plane(image, c)[i] = 0.5f;
    assert_int_equal(ty_image_write_png(context, image, 0, TY_TONE_CLIP, path), TY_OK);
    ty_image_destroy(image);
}

static void put_ct(void) {
    static dicom_writer writer;
    dicom_form form = dicom_default_form();
    form.series = "1.2.4"; /* number 4 */
    mkdir("ct_head", 0777);
    dicom_slice(&writer, &form, "0\\0\\0");
    dicom_pixels(&writer, &form, (const int64_t[6]){-1000, -400, 0, 100, 150, 1000});
    put_file("ct_head/1", writer.bytes, writer.size);
}

/* Liquid water of 2 x 2 x 2 cells. */
static void put_les(void) {
    static const double places[2] = {0, 100}, water[8] = {1e-4, 2e-4, 3e-4, 0, 0, 0, 1e-4, 1e-4},
                        radius[8] = {8, 9, 10, 8, 8, 8, 9, 9}, air[8] = {1, 1, 1, 1, 1, 1, 1, 1};
    const made_file file = {
        {"z", "y", "x"},
        {2, 2, 2},
        {{"z", {0}, 1, {{"units", "m"}}, MADE_FLOAT, places},
         {"y", {1}, 1, {{"units", "m"}}, MADE_FLOAT, places},
         {"x", {2}, 1, {{"units", "m"}}, MADE_FLOAT, places},
         {"ql", {0, 1, 2}, 3, {{"units", "kg/kg"}}, MADE_FLOAT, water},
         {"reff", {0, 1, 2}, 3, {{"units", "um"}}, MADE_FLOAT, radius},
         {"rho", {0, 1, 2}, 3, {{"units", "kg m-3"}}, MADE_FLOAT, air}},
    };
    make_netcdf("les.nc", &file);
}

/* False in a build without NetCDF, or where its library is not installed. */
static bool reads_netcdf(void) {
    ty_volume_def def = ty_default_volume_def();
    int32_t components = 0;
    def.grid = "ql";
    return ty_volume_components(context, "les.nc", &def, &components) == TY_OK;
}

static void put_examples(void) {
    put_vdb("plume_0030.vdb", "density");
    put_vdb("smoke.vdb", "density");
    put_vdb("heat.vdb", "temperature");
    put_nrrd("head.nrrd", 1, "400 1500");
    put_ct();
    put_les();
    put_map("planks.png");
    put_map("planks_rough.png");
    put_map("planks_normal.png");
    put_text("level.glb", "{\"asset\":{\"version\":\"2.0\"}}");
    put_text("dragon.ply", "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n"
                           "property float z\nelement face 4\nproperty list uchar int vertex_indices\nend_header\n"
                           "0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 3 2\n3 0 1 3\n3 1 2 3\n");
}

static void the_manuals_examples_load(void** state) {
    (void)state;
    static const char fence[] = "\n```json\n";
    put_examples();
    size_t size = 0;
    uint8_t* bytes = get_file(TYNDALL_SOURCE_DIR "/docs/scene.md", &size);
    char* manual = (char*)bytes;
    manual[size] = '\0';
    int loaded = 0;
    for (char* at = manual; (at = strstr(at, fence)) != NULL;) {
        at += strlen(fence);
        char* end = strstr(at, "\n```");
        assert_non_null(end);
        *end = '\0';
        if (strstr(at, "\"tyndall\": 1") != NULL) {
            if (strstr(at, "les.nc") == NULL || reads_netcdf()) ty_scene_destroy(load(at));
            ++loaded;
        }
        at = end + 1;
    }
    assert_int_equal(loaded, 10);
    free(bytes);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(frames_pick_files),
        cmocka_unit_test(folders_keep_their_signs),
        cmocka_unit_test(raw_volumes_are_read),
        cmocka_unit_test(components_are_chosen),
        cmocka_unit_test(albedo_and_g_come_from_volumes),
        cmocka_unit_test(emission_comes_from_files),
        cmocka_unit_test(transfer_functions_are_read),
        cmocka_unit_test(fields_are_placed_in_units),
        cmocka_unit_test(wrong_volumes_are_refused),
        cmocka_unit_test(closed_meshes_bound_media),
        cmocka_unit_test(mesh_files_are_geometry),
        cmocka_unit_test(gltf_turns_into_z_up),
        cmocka_unit_test(cameras_come_from_files),
        cmocka_unit_test(the_geometrys_camera_is_used),
        cmocka_unit_test(the_hash_follows_files_within_files),
        cmocka_unit_test(the_manuals_examples_load),
    };
    return cmocka_run_group_tests(tests, start, stop);
}
