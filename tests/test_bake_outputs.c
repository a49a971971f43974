/* Outputs of baking: copies of glTF files with colours at their vertices, receivers of vertices, images of probes. */
#include "mesh_maker.h"
#include "strict_fixture.h"

#include <tyndall/bake.h>
#include <tyndall/io.h>

/* Two triangles of one array of positions, the second with colours, and a second node with the same mesh. */
static const char pair[] =
    "{'asset':{'version':'2.0'},'nodes':[{'mesh':0,'name':'one'},{'mesh':0,'translation':[0,0,3]}],"
    "'meshes':[{'primitives':[{'attributes':{'POSITION':0},'indices':1},"
    "{'attributes':{'POSITION':0,'COLOR_0':3},'indices':2}]}],"
    "'accessors':[{'bufferView':0,'componentType':5126,'count':6,'type':'VEC3'},"
    "{'bufferView':1,'componentType':5121,'count':3,'type':'SCALAR'},"
    "{'bufferView':2,'componentType':5121,'count':3,'type':'SCALAR'},"
    "{'bufferView':0,'componentType':5126,'count':6,'type':'VEC3'}],"
    "'bufferViews':[{'buffer':0,'byteLength':72},{'buffer':0,'byteOffset':72,'byteLength':3},"
    "{'buffer':0,'byteOffset':75,'byteLength':3}],'buffers':[{'byteLength':78}],'extras':{'own':7}}";

typedef struct pair_bytes {
    float positions[18];
    uint8_t indices[6];
    uint8_t rest[2];
} pair_bytes;

static const pair_bytes pair_data = {
    {0, 0, 0, 1, 0, 0, 0, 0.5f, 0, 0, 0, 1, 1, 0, 1, 0, 0.5f, 1}, {0, 1, 2, 3, 4, 5}, {0}};

static ty_scene* load_scene(const char* path) {
    const ty_mesh_file_def def = ty_default_mesh_file_def();
    ty_scene* scene = NULL;
    assert_int_equal(ty_scene_create(context, TY_AXIS_Y, &scene), TY_OK);
    assert_int_equal(ty_scene_add_mesh_file(scene, path, &def), TY_OK);
    return scene;
}

static ty_scene* load_pair(void) {
    size_t size = 0;
    uint8_t* glb = make_glb(pair, &pair_data, 78, &size);
    put_file("pair.glb", glb, size);
    free(glb);
    return load_scene("pair.glb");
}

/* Colours that tell where they belong. */
static void make_colors(const ty_scene* scene, float rgb[4][9], ty_mesh_colors colors[4]) {
    for (int32_t m = 0; m < 4; ++m) {
        ty_mesh_def mesh;
        assert_int_equal(ty_scene_get_mesh(scene, m, &mesh), TY_OK);
        assert_int_equal(mesh.vertex_count, 3);
        for (int i = 0; i < 9; ++i) rgb[m][i] = (float)(9 * m + i) / 64;
        colors[m] = (ty_mesh_colors){.origin = mesh.origin, .count = 3, .rgb = rgb[m]};
    }
}

static void meshes_know_where_they_come_from(void** state) {
    (void)state;
    ty_scene* scene = load_pair();
    for (int32_t m = 0; m < 4; ++m) {
        ty_mesh_def mesh;
        assert_int_equal(ty_scene_get_mesh(scene, m, &mesh), TY_OK);
        assert_string_equal(mesh.origin.file, "pair.glb");
        assert_string_equal(mesh.origin.name, m < 2 ? "one" : "");
        assert_int_equal(mesh.origin.node, m / 2);
        assert_int_equal(mesh.origin.primitive, m % 2);
        assert_int_equal(mesh.origin.first_vertex, 3 * (m % 2));
        assert_int_equal(mesh.origin.vertex_total, 6);
    }
    ty_scene_destroy(scene);
}

static void colors_are_read_back(void** state) {
    (void)state;
    float rgb[4][9];
    ty_mesh_colors colors[4];
    ty_scene* scene = load_pair();
    make_colors(scene, rgb, colors);
    assert_int_equal(ty_mesh_file_write_colors(context, "pair.glb", colors, 4, "{\"scale\": 2}", "colored.glb"), TY_OK);
    ty_scene* copy = load_scene("colored.glb");
    assert_int_equal(ty_scene_get_info(copy).meshes, 4);
    for (int32_t m = 0; m < 4; ++m) {
        ty_mesh_def before, after;
        assert_int_equal(ty_scene_get_mesh(scene, m, &before), TY_OK);
        assert_int_equal(ty_scene_get_mesh(copy, m, &after), TY_OK);
        assert_memory_equal(before.positions, after.positions, 9 * sizeof(float));
        assert_memory_equal(before.indices, after.indices, 3 * sizeof(uint32_t));
        for (int i = 0; i < 9; ++i) assert_true(after.colors[4 * (i / 3) + i % 3] == rgb[m][i]); /* exactly */
    }
    ty_scene_destroy(copy);
    ty_scene_destroy(scene);
    size_t size = 0;
    uint8_t* bytes = get_file("colored.glb", &size);
    bytes[size] = 0;
    const char* text = (const char*)bytes + 20;
    assert_non_null(strstr(text, "\"COLOR_1\":3"));
    assert_non_null(strstr(text, "\"own\":7"));
    assert_non_null(strstr(text, "\"tyndall\":{\"scale\":2}"));
    /* Both primitives of a node share an array: 6 colours for each node, and no more. */
    assert_non_null(strstr(text, "\"byteLength\":224"));
    free(bytes);
    assert_int_equal(remove_temporary_files(), 0);
}

static void files_that_changed_are_refused(void** state) {
    (void)state;
    float rgb[4][9];
    ty_mesh_colors colors[4];
    ty_scene* scene = load_pair();
    make_colors(scene, rgb, colors);
    remove("colored.glb");
    const struct {
        int32_t node, primitive;
        int64_t first, total;
        ty_result expected;
        const char* matter;
    } cases[] = {{7, 0, 0, 6, TY_ERROR_INPUT, "node 7"},
                 {0, 5, 0, 6, TY_ERROR_INPUT, "primitive 5"},
                 {0, 0, 0, 9, TY_ERROR_INPUT, "9 positions"},
                 {-1, 0, 0, 6, TY_ERROR_ARGUMENT, "colors[0]"},
                 {0, 0, 4, 6, TY_ERROR_ARGUMENT, "colors[0]"},
                 {0, 0, -1, 6, TY_ERROR_ARGUMENT, "colors[0]"},
                 {0, 0, INT64_MAX, 6, TY_ERROR_ARGUMENT, "colors[0]"}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        ty_mesh_colors one = colors[0];
        one.origin.node = cases[i].node;
        one.origin.primitive = cases[i].primitive;
        one.origin.first_vertex = cases[i].first;
        one.origin.vertex_total = cases[i].total;
        const ty_result result = ty_mesh_file_write_colors(context, "pair.glb", &one, 1, NULL, "colored.glb");
        assert_failed(context, result, cases[i].expected, cases[i].expected == TY_ERROR_INPUT ? "pair.glb" : "",
                      cases[i].matter);
    }
    ty_result result = ty_mesh_file_write_colors(context, "pair.glb", colors, 4, "[1]", "colored.glb");
    assert_failed(context, result, TY_ERROR_ARGUMENT, "extras", NULL);
    result = ty_mesh_file_write_colors(context, "none.glb", colors, 4, NULL, "colored.glb");
    assert_failed(context, result, TY_ERROR_FILE, "none.glb", NULL);
    put_text("text.glb", "{\"asset\": 3}");
    result = ty_mesh_file_write_colors(context, "text.glb", colors, 4, NULL, "colored.glb");
    assert_failed(context, result, TY_ERROR_INPUT, "text.glb", NULL);
    assert_null(fopen("colored.glb", "rb"));
    ty_scene_destroy(scene);
}

static ty_result write_colors(ty_context* strict, void* colors) {
    return ty_mesh_file_write_colors(strict, "pair.glb", colors, 4, NULL, "colored.glb");
}

static void little_memory_is_told(void** state) {
    (void)state;
    float rgb[4][9];
    ty_mesh_colors colors[4];
    ty_scene* scene = load_pair();
    make_colors(scene, rgb, colors);
    assert_true(check_short_memory(context, &memory, write_colors, colors) > 5);
    ty_scene_destroy(scene);
}

static void vertices_stand_in_their_largest_triangles(void** state) {
    (void)state;
    static const float positions[] = {0, 0, 0, 3, 0, 0, 0, 0, -3, 0, 1, 0, 9, 9, 9};
    static const uint32_t indices[] = {0, 1, 2, 0, 3, 1};
    ty_mesh_def def = ty_default_mesh_def();
    def.vertex_count = 5;
    def.triangle_count = 2;
    def.positions = positions;
    def.indices = indices;
    ty_scene* scene = NULL;
    ty_bake_receiver receivers[5];
    assert_int_equal(ty_scene_create(context, TY_AXIS_Y, &scene), TY_OK);
    assert_int_equal(ty_scene_add_mesh(scene, &def), TY_OK);
    assert_int_equal(ty_bake_vertices(scene, 0, receivers), TY_OK);
    static const float up[] = {0, 1, 0}, back[] = {0, 0, -1}, first[] = {0.01f, 0, -0.01f};
    assert_floats(receivers[0].face, up, 3);
    assert_floats(receivers[0].position, first, 3);
    assert_true(receivers[0].normal[1] > 0.9f && receivers[0].normal[2] < -0.3f); /* the mean by area, 9 to 3 */
    assert_floats(receivers[2].normal, up, 3);
    assert_floats(receivers[3].face, back, 3);
    assert_true(receivers[0].margin > 0 && receivers[3].margin > 0);
    assert_floats(receivers[4].position, positions + 12, 3); /* no triangle has it */
    assert_failed(context, ty_bake_vertices(scene, 1, receivers), TY_ERROR_ARGUMENT, "mesh", NULL);
    ty_scene_destroy(scene);
}

static void probes_become_images(void** state) {
    (void)state;
    static ty_bake_probe probes[12];
    static const int32_t size[3] = {2, 3, 2};
    for (int i = 0; i < 12; ++i)
        for (int layer = 0; layer < TY_BAKE_LAYERS; ++layer)
            for (int c = 0; c < 3; ++c)
                for (int t = 0; t < TY_BAKE_SH_TERMS; ++t)
                    probes[i].sh[layer][c][t] = (float)(1000 * i + 100 * layer + 25 * c + t);
    ty_image* image = NULL;
    assert_int_equal(ty_bake_create_probe_image(context, probes, size, 9, &image), TY_OK);
    assert_int_equal(ty_image_width(image), 2);
    assert_int_equal(ty_image_height(image), 6);
    const int pixel = 1 + 2 * (2 + 3 * 1); /* (1, 2, 1) */
    const struct {
        const char* name;
        float expected;
    } channels[] = {{"sh3.G", 4 * (1000.0f * pixel + 25 + 3) + 600},
                    {"multiple.sh8.B", 1000.0f * pixel + 300 + 50 + 8},
                    {"R", 0.28209479f * (4000.0f * pixel + 600)}};
    for (size_t i = 0; i < sizeof channels / sizeof *channels; ++i) {
        const int32_t channel = ty_image_find_channel(image, channels[i].name);
        assert_true(channel >= 0);
        assert_floats(&ty_image_plane_const(image, channel)[pixel], &channels[i].expected, 1);
    }
    assert_int_equal(ty_image_find_channel(image, "sh9.R"), -1);
    ty_image_destroy(image);
    assert_failed(context, ty_bake_create_probe_image(context, probes, size, 10, &image), TY_ERROR_ARGUMENT, "terms",
                  NULL);
}

static void light_becomes_images(void** state) {
    (void)state;
    ty_bake_light light[3] = {{.samples = 4}, {.samples = 5}, {.samples = 6}};
    for (int layer = 0; layer < TY_BAKE_LAYERS; ++layer) light[2].irradiance[layer][1] = (float)(1 << layer);
    light[2].irradiance[0][0] = NAN;
    light[2].vector_irradiance[1][2][0] = 3;
    light[2].fluence[2] = 6;
    ty_image* image = NULL;
    assert_int_equal(ty_bake_create_light_image(context, light, 3, 2, &image), TY_OK);
    assert_int_equal(ty_image_height(image), 2);
    const struct {
        const char* name;
        float expected;
    } channels[] = {{"R", 0}, {"G", 15}, {"single.G", 4}, {"L1.BX", 0.5f}, {"samples.N", 6}};
    for (size_t i = 0; i < sizeof channels / sizeof *channels; ++i) {
        const int32_t channel = ty_image_find_channel(image, channels[i].name);
        assert_true(channel >= 0);
        assert_floats(&ty_image_plane_const(image, channel)[2], &channels[i].expected, 1);
    }
    ty_image_destroy(image);
    assert_failed(context, ty_bake_create_light_image(context, light, 3, 0, &image), TY_ERROR_ARGUMENT, "sides", NULL);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(meshes_know_where_they_come_from, start, stop),
        cmocka_unit_test_setup_teardown(colors_are_read_back, start, stop),
        cmocka_unit_test_setup_teardown(files_that_changed_are_refused, start, stop),
        cmocka_unit_test_setup_teardown(little_memory_is_told, start, stop),
        cmocka_unit_test_setup_teardown(vertices_stand_in_their_largest_triangles, start, stop),
        cmocka_unit_test_setup_teardown(probes_become_images, start, stop),
        cmocka_unit_test_setup_teardown(light_becomes_images, start, stop),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
