/* Mesh files as scenes, shells and cameras. */
#define _GNU_SOURCE
#include "mesh_fixture.h"

#include "scene/scene.h"

#include <tyndall/io.h>

/* The tetrahedron of the origin and the unit points, twice: mirrored and stretched, and as it is under a turned node;
 * a third one is scaled to 0. A sun and a camera hang on the turned node. */
static const char tetrahedra[] =
    "{'asset':{'version':'2.0'},'scenes':[{'nodes':[0,1,2]}],"
    "'nodes':[{'mesh':0,'scale':[-2,1,1]},"
    "{'mesh':0,'translation':[10,0,0],'children':[3]},{'mesh':0,'scale':[0,0,0]},"
    "{'camera':0,'translation':[0,5,0],'rotation':[0,0.7071067811865476,0,0.7071067811865476],"
    "'extensions':{'KHR_lights_punctual':{'light':0}}}],"
    "'cameras':[{'type':'perspective','name':'main','perspective':{'yfov':1,'znear':0.1}}],"
    "'extensions':{'KHR_lights_punctual':{'lights':[{'type':'directional','intensity':3,'color':[1,0.5,0.25]}]}},"
    "'meshes':[{'primitives':[{'attributes':{'POSITION':0},'indices':1,'material':0}]}],"
    "'materials':[{'pbrMetallicRoughness':{'baseColorFactor':[1,0.5,0.25,1]},'emissiveFactor':[1,2,0]}],"
    "'accessors':[{'bufferView':0,'componentType':5126,'count':4,'type':'VEC3'},"
    "{'bufferView':1,'componentType':5121,'count':12,'type':'SCALAR'}],"
    "'bufferViews':[{'buffer':0,'byteLength':48},{'buffer':0,'byteOffset':48,'byteLength':12}],"
    "'buffers':[{'byteLength':60}]}";

static void put_tetrahedra(const char* path, const char* text) {
    static const float positions[] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1};
    static const uint8_t indices[] = {0, 2, 1, 0, 3, 2, 0, 1, 3, 1, 2, 3};
    uint8_t data[60];
    memcpy(data, positions, 48);
    memcpy(data + 48, indices, 12);
    size_t size = 0;
    uint8_t* glb = make_glb(text, data, sizeof data, &size);
    put_file(path, glb, size);
    free(glb);
}

static ty_scene* make_scene(const char* path, const ty_mesh_file_def* def) {
    ty_scene* scene = NULL;
    assert_int_equal(ty_scene_create(context, TY_AXIS_Y, &scene), TY_OK);
    if (ty_scene_add_mesh_file(scene, path, def) != TY_OK) fail_msg("%s", ty_take_error(context));
    if (ty_scene_commit(scene) != TY_OK) fail_msg("%s", ty_take_error(context));
    return scene;
}

static void scenes_take_all_of_a_file(void** state) {
    (void)state;
    book = (log_book){0};
    put_tetrahedra("scene.glb", tetrahedra);
    ty_mesh_file_def def = ty_default_mesh_file_def();
    def.light_scale = 2;
    def.emission_scale = 10;
    ty_scene* scene = make_scene("scene.glb", &def);
    const ty_scene_info info = ty_scene_get_info(scene);
    assert_int_equal(info.meshes, 2);
    assert_int_equal(info.triangles, 8);
    assert_int_equal(info.lights, 1);
    assert_int_equal(info.emitters, 9); /* the sun and the triangles */
    static const double lower[] = {-2, 0, 0}, upper[] = {11, 1, 1};
    assert_doubles(info.lower, lower, 3);
    assert_doubles(info.upper, upper, 3);
    assert_int_equal(book.warnings, 1); /* what is scaled to 0 */
    static const float color[] = {6, 3, 1.5f}, albedo[] = {1, 0.5f, 0.25f}, emission[] = {10, 20, 0};
    static const double direction[] = {-1, 0, 0};
    assert_floats(scene->lights[0].color, color, 3);
    assert_doubles(scene->lights[0].direction, direction, 3);
    assert_floats(scene->meshes[0]->material.albedo, albedo, 3);
    assert_floats(scene->meshes[0]->material.emission, emission, 3);
    ty_scene_destroy(scene);
}

static void scenes_take_what_is_asked_for(void** state) {
    (void)state;
    put_tetrahedra("part.glb", tetrahedra);
    ty_mesh_file_def def = ty_default_mesh_file_def();
    ty_material_def grey = ty_default_material_def();
    def.lights = false;
    def.material = &grey;
    def.to_z_up = true;
    def.transform.m[11] = 100; /* upwards */
    ty_scene* scene = make_scene("part.glb", &def);
    const ty_scene_info info = ty_scene_get_info(scene);
    static const double lower[] = {-2, -1, 100}, upper[] = {11, 0, 101};
    assert_int_equal(info.lights, 0);
    assert_int_equal(info.emitters, 0);
    assert_doubles(info.lower, lower, 3);
    assert_doubles(info.upper, upper, 3);
    assert_true(scene->meshes[0]->material.albedo[0] == 0.5f);
    ty_scene_destroy(scene);
    def = ty_default_mesh_file_def();
    def.meshes = false;
    scene = make_scene("part.glb", &def);
    assert_int_equal(ty_scene_get_info(scene).meshes, 0);
    assert_int_equal(ty_scene_get_info(scene).lights, 1);
    ty_scene_destroy(scene);
}

/* Files of text share the way into a scene. */
static void other_kinds_become_scenes(void** state) {
    (void)state;
    put_text("kind.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    put_text("kind.ply", "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
                         "property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n"
                         "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n");
    const ty_mesh_file_def def = ty_default_mesh_file_def();
    static const char* const names[] = {"kind.obj", "kind.ply"};
    for (int i = 0; i < 2; ++i) {
        ty_scene* scene = make_scene(names[i], &def);
        assert_int_equal(ty_scene_get_info(scene).triangles, 1);
        ty_scene_destroy(scene);
    }
}

/* The part of its bounding box that a tetrahedron fills is a sixth, wherever fronts would be the wrong way round it
 * would be nothing. */
static void shells_are_closed(void** state) {
    (void)state;
    book = (log_book){0};
    put_tetrahedra("shell.glb", tetrahedra);
    ty_mesh_file_def def = ty_default_mesh_file_def();
    ty_closed_mesh* shell = NULL;
    if (ty_mesh_file_create_closed_mesh(context, "shell.glb", &def, &shell) != TY_OK)
        fail_msg("%s", ty_take_error(context));
    ty_medium_def medium = ty_default_medium_def();
    medium.bounds = TY_BOUNDS_SHELL;
    medium.shell = shell;
    ty_scene* scene = NULL;
    assert_int_equal(ty_scene_create(context, TY_AXIS_Y, &scene), TY_OK);
    assert_int_equal(ty_scene_add_medium(scene, &medium), TY_OK);
    assert_int_equal(ty_scene_commit(scene), TY_OK);
    static const double boxes[][2][3] = {{{-2, 0, 0}, {0, 1, 1}}, {{10, 0, 0}, {11, 1, 1}}};
    static const int32_t size[3] = {8, 8, 8};
    for (int i = 0; i < 2; ++i) {
        ty_grid* grid = NULL;
        assert_int_equal(ty_medium_create_coverage(scene, 0, boxes[i][0], boxes[i][1], size, 8, &grid), TY_OK);
        const double mean = ty_grid_get_info(grid).mean;
        if (!(fabs(mean - 1.0 / 6) < 0.003)) fail_msg("box %d: %g is filled, not a sixth", i, mean);
        ty_grid_release(grid);
    }
    ty_scene_destroy(scene);
    ty_closed_mesh_release(shell);
}

static void cameras_are_found_by_name(void** state) {
    (void)state;
    put_tetrahedra("camera.glb", tetrahedra);
    ty_mesh_file_def def = ty_default_mesh_file_def();
    ty_camera_def camera = ty_default_camera_def();
    camera.exposure = 3;
    bool found = false;
    assert_int_equal(ty_mesh_file_camera(context, "camera.glb", &def, NULL, &camera, &found), TY_OK);
    assert_true(found);
    static const double position[] = {10, 5, 0}, target[] = {9, 5, 0}, up[] = {0, 1, 0};
    assert_doubles(camera.position, position, 3);
    assert_doubles(camera.target, target, 3);
    assert_doubles(camera.up, up, 3);
    assert_true(fabs(camera.fov_y - 57.29577951308232) < 1e-9 && camera.exposure == 3);
    def.to_z_up = true;
    assert_int_equal(ty_mesh_file_camera(context, "camera.glb", &def, "main", &camera, &found), TY_OK);
    static const double z_position[] = {10, 0, 5}, z_up[] = {0, 0, 1};
    assert_doubles(camera.position, z_position, 3);
    assert_doubles(camera.up, z_up, 3);
    assert_failed(context, ty_mesh_file_camera(context, "camera.glb", &def, "other", &camera, &found), TY_ERROR_INPUT,
                  "camera.glb: no camera \"other\"; known: \"main\"", NULL);
    char* flat = with_part(tetrahedra, "'perspective','name'", "'orthographic','name'");
    char* orthographic = with_part(flat, "'perspective':{'yfov':1,'znear':0.1}", "'orthographic':{}");
    put_tetrahedra("flat.glb", orthographic);
    assert_failed(context, ty_mesh_file_camera(context, "flat.glb", &def, NULL, &camera, &found), TY_ERROR_INPUT,
                  "flat.glb: the camera \"main\" is orthographic", NULL);
    free(flat);
    free(orthographic);
    put_text("none.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    assert_int_equal(ty_mesh_file_camera(context, "none.obj", &def, NULL, &camera, &found), TY_OK);
    assert_false(found);
}

static void what_a_file_holds_is_listed(void** state) {
    (void)state;
    book = (log_book){0};
    put_tetrahedra("list.glb", tetrahedra);
    ty_scene_info info;
    ty_mesh_file_entry entries[3];
    int32_t count = 0;
    assert_int_equal(ty_mesh_file_list(context, "list.glb", &info, entries, 3, &count), TY_OK);
    assert_int_equal(info.triangles, 8);
    assert_int_equal(info.lights, 1);
    assert_true(info.bytes > 0);
    assert_int_equal(book.warnings, 1); /* once, of what is scaled to 0 */
    assert_int_equal(count, 2);
    assert_false(entries[0].camera);
    assert_string_equal(entries[0].name, "");
    assert_true(entries[1].camera);
    assert_string_equal(entries[1].name, "main");
    assert_true(fabs(entries[1].fov_y - 57.29577951308232) < 1e-9);
    /* No more than there is room for. */
    memset(entries, 0x55, sizeof entries);
    assert_int_equal(ty_mesh_file_list(context, "list.glb", &info, entries, 1, &count), TY_OK);
    assert_int_equal(count, 2);
    assert_false(entries[0].camera);
    assert_int_equal(entries[1].name[0], 0x55);
    assert_int_equal(ty_mesh_file_list(context, "list.glb", &info, NULL, 0, &count), TY_OK);
    assert_int_equal(count, 2);
    assert_int_equal(ty_mesh_file_list(context, "list.glb", &info, NULL, 1, &count), TY_ERROR_ARGUMENT);
    assert_int_equal(ty_mesh_file_list(context, "missing.glb", &info, entries, 1, &count), TY_ERROR_FILE);
    ty_take_error(context);
}

static void wrong_calls_are_refused(void** state) {
    (void)state;
    put_tetrahedra("call.glb", tetrahedra);
    put_text("call.txt", "hello");
    ty_scene* scene = NULL;
    assert_int_equal(ty_scene_create(context, TY_AXIS_Y, &scene), TY_OK);
    ty_mesh_file_def def = ty_default_mesh_file_def();
    assert_failed(context, ty_scene_add_mesh_file(scene, "call.txt", &def), TY_ERROR_INPUT, "call.txt",
                  "neither a glTF, an OBJ nor a PLY file");
    assert_failed(context, ty_scene_add_mesh_file(scene, "gone.glb", &def), TY_ERROR_FILE, "gone.glb", "No such file");
    assert_failed(context, ty_scene_add_mesh_file(scene, NULL, &def), TY_ERROR_ARGUMENT, "NULL", NULL);
    assert_failed(context, ty_scene_add_mesh_file(scene, "call.glb", &(ty_mesh_file_def){0}), TY_ERROR_ARGUMENT,
                  "ty_default_mesh_file_def", NULL);
    def.light_scale = -1;
    assert_failed(context, ty_scene_add_mesh_file(scene, "call.glb", &def), TY_ERROR_ARGUMENT, "light_scale", NULL);
    def = ty_default_mesh_file_def();
    def.emission_scale = (double)NAN;
    assert_failed(context, ty_scene_add_mesh_file(scene, "call.glb", &def), TY_ERROR_ARGUMENT, "emission_scale", NULL);
    def = ty_default_mesh_file_def();
    memset(def.transform.m, 0, sizeof def.transform.m);
    assert_failed(context, ty_scene_add_mesh_file(scene, "call.glb", &def), TY_ERROR_ARGUMENT, "transform", NULL);
    def = ty_default_mesh_file_def();
    def.transform.m[3] = 1e30; /* what the scene itself refuses names the file */
    assert_failed(context, ty_scene_add_mesh_file(scene, "call.glb", &def), TY_ERROR_INPUT, "call.glb: ", NULL);
    ty_closed_mesh* shell = NULL;
    assert_failed(context, ty_mesh_file_create_closed_mesh(context, "call.glb", &def, NULL), TY_ERROR_ARGUMENT,
                  "out is NULL", NULL);
    char* empty = with_part(tetrahedra, "[{'nodes':[0,1,2]}]", "[{'nodes':[3]}]");
    put_tetrahedra("empty.glb", empty);
    def = ty_default_mesh_file_def();
    assert_failed(context, ty_mesh_file_create_closed_mesh(context, "empty.glb", &def, &shell), TY_ERROR_INPUT,
                  "empty.glb: there are no triangles", NULL);
    free(empty);
    ty_scene_destroy(scene);
}

static void real_files_become_scenes(void** state) {
    (void)state;
    static const struct {
        const char* name;
        int64_t triangles;
    } files[] = {{"scenes/cornell_box_lightmap_uv.glb", 36},
                 {"scenes/sponza_atrium.glb", 33663},
                 {"scenes/wooden_staircase.glb", 262508}};
    const ty_mesh_file_def def = ty_default_mesh_file_def();
    for (size_t i = 0; i < sizeof files / sizeof *files; ++i) {
        char path[1024];
        ty_scene* scene = make_scene(data_path(files[i].name, path), &def);
        const ty_scene_info info = ty_scene_get_info(scene);
        printf("%s: %d meshes, %d lights, %lld emitters, %g %g %g to %g %g %g\n", files[i].name, info.meshes,
               info.lights, (long long)info.emitters, info.lower[0], info.lower[1], info.lower[2], info.upper[0],
               info.upper[1], info.upper[2]);
        assert_int_equal(info.triangles, files[i].triangles);
        ty_scene_destroy(scene);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(scenes_take_all_of_a_file),   cmocka_unit_test(scenes_take_what_is_asked_for),
        cmocka_unit_test(other_kinds_become_scenes),   cmocka_unit_test(shells_are_closed),
        cmocka_unit_test(cameras_are_found_by_name),   cmocka_unit_test(wrong_calls_are_refused),
        cmocka_unit_test(what_a_file_holds_is_listed), cmocka_unit_test(real_files_become_scenes),
    };
    return cmocka_run_group_tests(tests, start, stop);
}
