/* Textures that scene files name: where they lie on shapes and meshes, their colour spaces, maps of normals, messages.
 */
#include "fog.h"
#include "mesh_maker.h"

#include <string.h>
#include <tyndall/io.h>

enum { RED, GREEN, BLUE, WHITE };

/* A PNG of 4 x 4 texels, the same in each quarter; colours of the quarters from the top left, line by line. */
static void put_quarters(ty_context* context, const char* path, const float colors[4][3]) {
    ty_image* image = NULL;
    assert_int_equal(ty_image_create_rgb(context, 4, 4, &image), TY_OK);
    for (int c = 0; c < 3; ++c)
        for (int i = 0; i < 16; ++i) ty_image_plane(image, c)[i] = colors[i / 8 * 2 + i % 4 / 2][c];
    assert_int_equal(ty_image_write_png(context, image, 0, TY_TONE_CLIP, path), TY_OK);
    ty_image_destroy(image);
}

/* Linear value of a code of sRGB. */
static float linear(int code) {
    const double value = code / 255.0;
    return (float)(value <= 0.04045 ? value / 12.92 : pow((value + 0.055) / 1.055, 2.4));
}

static int start(void** state) {
    static const float colors[4][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 1, 1}};
    start_context(state);
    put_quarters(*state, "quarters.png", colors);
    float gray[4][3], tilt[4][3];
    for (int i = 0; i < 4; ++i)
        for (int c = 0; c < 3; ++c) {
            gray[i][c] = linear(128);
            tilt[i][c] = linear(c == 1 ? 128 : 218); /* half way from the normal to u */
        }
    put_quarters(*state, "gray.png", (const float(*)[3])gray);
    put_quarters(*state, "tilt.png", (const float(*)[3])tilt);
    put_text("no_image.png", "text");
    put_text("square.obj",
             "v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nf 1/1 2/2 3/3 4/4\n");
    return 0;
}

static ty_scene* load(ty_context* context, const char* format, const char* shape, const char* material) {
    char text[1024];
    snprintf(text, sizeof text, format, shape, material);
    const char* json = quoted(text);
    ty_scene* scene = NULL;
    if (ty_scene_parse(context, json, strlen(json), "s.json", "", NULL, 0, &scene) != TY_OK)
        fail_msg("%s", ty_take_error(context));
    assert_int_equal(ty_scene_commit(scene), TY_OK);
    return scene;
}

/* The light that travels from a point at the shape to another one. */
static void look(const ty_scene* scene, const double from[3], const double at[3], double radiance[3]) {
    double ray[6] = {from[0], from[1], from[2]}, length = 0;
    for (int a = 0; a < 3; ++a) ray[3 + a] = from[a] - at[a], length += ray[3 + a] * ray[3 + a];
    for (int a = 0; a < 3; ++a) ray[3 + a] /= sqrt(length);
    ty_path_def def = small_def(64);
    assert_int_equal(ty_path_radiance(scene, &def, ray, 1, radiance, NULL), TY_OK);
}

static const char under_sky[] = "{'tyndall':1,%s,'material':{%s}}],'lights':[{'type':'environment','radiance':1}],'"
                                "render':{'path':{'max_depth':2}}}";

static void expect_color(const ty_scene* scene, const double from[3], const double at[3], int color) {
    static const double colors[4][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 1, 1}};
    double radiance[3];
    look(scene, from, at, radiance);
    for (int c = 0; c < 3; ++c)
        if (!(fabs(radiance[c] - colors[color][c]) < 1e-3))
            fail_msg("from (%g, %g, %g): (%g, %g, %g), not colour %d", from[0], from[1], from[2], radiance[0],
                     radiance[1], radiance[2], color);
}

/* The four quarters of a face seen against `out`, with `right` and `up` half a side long to the middles of quarters. */
static void expect_quarters(const ty_scene* scene, const double middle[3], const double out[3], const double right[3],
                            const double up[3]) {
    for (int i = 0; i < 4; ++i) {
        double at[3], from[3];
        for (int a = 0; a < 3; ++a) {
            at[a] = middle[a] + (i % 2 != 0 ? 0.5 : -0.5) * right[a] + (i < 2 ? 0.5 : -0.5) * up[a];
            from[a] = at[a] + 3 * out[a];
        }
        expect_color(scene, from, at, i);
    }
}

#define V(x, y, z)                                                                                                     \
    (const double[3]) {                                                                                                \
        x, y, z                                                                                                        \
    }

static const char colored[] = "'base_color':{'file':'quarters.png'}";

static void quads_show_textures_upright(void** state) {
    ty_scene* scene =
        load(*state, under_sky, "'geometry':[{'quad':{'origin':[-1,-1,2],'u':[2,0,0],'v':[0.5,2,0]}", colored);
    expect_quarters(scene, V(0.25, 0, 2), V(0, 0, 1), V(1, 0, 0), V(0.25, 1, 0));
    /* The back shows it mirrored. */
    expect_color(scene, V(-0.3, 0.5, -1), V(-0.3, 0.5, 2), RED);
    ty_scene_destroy(scene);
}

static void boxes_show_textures_on_all_sides(void** state) {
    ty_scene* scene = load(*state, under_sky, "'geometry':[{'box':[[-1,-1,-1],[1,1,1]]", colored);
    expect_quarters(scene, V(0, 0, 1), V(0, 0, 1), V(1, 0, 0), V(0, 1, 0));
    expect_quarters(scene, V(1, 0, 0), V(1, 0, 0), V(0, 0, -1), V(0, 1, 0));
    expect_quarters(scene, V(0, 0, -1), V(0, 0, -1), V(-1, 0, 0), V(0, 1, 0));
    expect_quarters(scene, V(-1, 0, 0), V(-1, 0, 0), V(0, 0, 1), V(0, 1, 0));
    expect_quarters(scene, V(0, 1, 0), V(0, 1, 0), V(1, 0, 0), V(0, 0, -1));
    expect_quarters(scene, V(0, -1, 0), V(0, -1, 0), V(1, 0, 0), V(0, 0, 1));
    ty_scene_destroy(scene);
    scene = load(*state, under_sky, "'up_axis':'z','geometry':[{'box':[[-1,-1,-1],[1,1,1]]", colored);
    expect_quarters(scene, V(0, -1, 0), V(0, -1, 0), V(1, 0, 0), V(0, 0, 1));
    expect_quarters(scene, V(0, 0, 1), V(0, 0, 1), V(1, 0, 0), V(0, 1, 0));
    ty_scene_destroy(scene);
}

/* The centre of the texture is at +x, its right half towards -z. */
static void spheres_show_textures_from_pole_to_pole(void** state) {
    ty_scene* scene = load(*state, under_sky, "'geometry':[{'sphere':{'center':[1,2,3],'radius':0.5}", colored);
    const double middle[3] = {1, 2, 3};
    expect_color(scene, V(3, 4, 5), middle, RED);
    expect_color(scene, V(3, 4, 1), middle, GREEN);
    expect_color(scene, V(3, 0, 5), middle, BLUE);
    expect_color(scene, V(3, 0, 1), middle, WHITE);
    ty_scene_destroy(scene);
    scene = load(*state, under_sky,
                 "'up_axis':'z','geometry':[{'transform':{'rotate':[0,0,90],'scale':2},"
                 "'sphere':{'center':[0,0,0],'radius':0.5}",
                 colored);
    /* The centre is at +y after the turn. */
    expect_color(scene, V(2, 2, 2), V(0, 0, 0), RED);
    expect_color(scene, V(-2, 2, 2), V(0, 0, 0), GREEN);
    ty_scene_destroy(scene);
}

static void meshes_take_textures_of_the_scene(void** state) {
    ty_scene* scene = load(*state, under_sky, "'geometry':[{'file':'square.obj'", colored);
    expect_quarters(scene, V(0, 0, 0), V(0, 0, 1), V(1, 0, 0), V(0, 1, 0));
    ty_scene_destroy(scene);
}

/* Base colours are sRGB, other numbers linear, and a factor multiplies both. */
static void color_spaces_are_those_of_gltf(void** state) {
    double radiance[3];
    ty_scene* scene = load(*state, under_sky, "'geometry':[{'box':[[-1,-1,-1],[1,1,1]]",
                           "'base_color':{'file':'gray.png','factor':0.5,'repeat':[3,2]}");
    look(scene, V(0.3, 0.2, 4), V(0.3, 0.2, 0), radiance);
    assert_close(radiance[1], 0.5 * (double)linear(128), 1e-4);
    ty_scene_destroy(scene);
    /* White metal, mixed with a black base, in the proportion of the texture. */
    static const char* const metals[] = {
        "'specular':0,'roughness':0,'base_color':1,'transmission':1,'metallic':0.50196",
        "'specular':0,'roughness':0,'base_color':1,'transmission':1,"
        "'metallic':{'file':'gray.png'}"};
    double reflected[2];
    for (int i = 0; i < 2; ++i) {
        scene = load(*state,
                     "{'tyndall':1,'geometry':[{%s,'material':{%s}}],"
                     "'lights':[{'type':'area','origin':[-9,-9,3],'u':[0,18,0],'v':[18,0,0],'radiance':1}]}",
                     "'quad':{'origin':[-1,-1,0],'u':[2,0,0],'v':[0,2,0]}", metals[i]);
        look(scene, V(0.3, 0.2, 2), V(0.3, 0.2, 0), radiance);
        reflected[i] = radiance[1];
        ty_scene_destroy(scene);
    }
    assert_close(reflected[0], 128 / 255.0, 0.01);
    assert_close(reflected[1], reflected[0], 0.01);
}

static const char under_sun[] = "{'tyndall':1,'geometry':[{%s,'material':{'base_color':1,%s}}],"
                                "'lights':[{'type':'directional','direction':[-1,0,-0.2],'irradiance':1}]}";

/* A normal half way towards u sees the sun, which is low at +x: (1, 0, 0.2) . (1, 0, 1) over their lengths. */
static void maps_of_normals_bend_shapes(void** state) {
    static const char* const shapes[] = {"'quad':{'origin':[-1,-1,0],'u':[2,0,0],'v':[0,2,0]}",
                                         "'box':[[-1,-1,-1],[1,1,0]]", "'sphere':{'center':[0,0,-1],'radius':1}",
                                         "'file':'square.obj'",
                                         "'transform':[1,0,0,0,0,-1,0,0,0,0,1,0,0,0,0,1],'box':[[-1,-1,-1],[1,1,0]]"};
    for (int i = 0; i < 5; ++i)
        for (int scaled = 0; scaled < 2; ++scaled) {
            double radiance[3];
            ty_scene* scene =
                load(*state, under_sun, shapes[i],
                     scaled != 0 ? "'normal_map':{'file':'tilt.png','scale':-1}" : "'normal_map':{'file':'tilt.png'}");
            look(scene, V(0, 0, 3), V(0, 0, 0), radiance);
            if (!(fabs(radiance[0] - (scaled != 0 ? 0 : 0.83205 / 3.14159265)) < 3e-3))
                fail_msg("shape %d: %g", i, radiance[0]);
            ty_scene_destroy(scene);
        }
}

/* A clear coat's own map bends its reflection and nothing else. */
static void coats_have_their_own_normals(void** state) {
    double flat[3], bent[3];
    const char* shape = "'quad':{'origin':[-1,-1,0],'u':[2,0,0],'v':[0,2,0]}";
    const double mirror_of_sun[3] = {0, 0, 3};
    ty_scene* scene = load(*state, under_sun, shape, "'specular':0,'clearcoat':1,'clearcoat_roughness':0.5");
    look(scene, mirror_of_sun, V(0, 0, 0), flat);
    ty_scene_destroy(scene);
    scene = load(*state, under_sun, shape,
                 "'specular':0,'clearcoat':1,'clearcoat_roughness':0.5,'clearcoat_normal_map':{'file':'tilt.png'}");
    look(scene, mirror_of_sun, V(0, 0, 0), bent);
    /* The coat's normal is 6 degrees from the half way between eye and sun: F D G / (4 n.l n.v) n.l is about 0.1. */
    assert_true(bent[0] > flat[0] + 0.05);
    ty_scene_destroy(scene);
}

static void refuse(ty_context* context, const char* material, ty_result result, const char* message) {
    char text[1024];
    snprintf(text, sizeof text,
             "{'tyndall':1,\n'geometry':[{'sphere':{'center':[0,0,0],'radius':1},\n'material':{%s}}]}", material);
    const char* json = quoted(text);
    ty_scene* scene = NULL;
    assert_int_equal(ty_scene_parse(context, json, strlen(json), "s.json", "", NULL, 0, &scene), result);
    const char* told = ty_take_error(context);
    if (strstr(told, message) == NULL) fail_msg("%s", told);
}

static void wrong_textures_are_refused(void** state) {
    refuse(*state, "'base_color':{'file':'none.png'}", TY_ERROR_FILE,
           "s.json:3: geometry[0].material.base_color.file: cannot open none.png");
    refuse(*state, "'base_color':{'file':'no_image.png'}", TY_ERROR_INPUT,
           "s.json:3: geometry[0].material.base_color.file: ");
    refuse(*state, "'normal_map':{'file':'square.obj'}", TY_ERROR_INPUT,
           "s.json:3: geometry[0].material.normal_map.file: ");
    refuse(*state, "'normal_map':{'scale':2}", TY_ERROR_INPUT, "s.json:3: geometry[0].material.normal_map");
    refuse(*state, "'base_color':{'file':'gray.png','factr':1}", TY_ERROR_INPUT, "factor");
    refuse(*state, "'metallic':{'file':'gray.png','repeat':2},'roughness':{'file':'gray.png'}", TY_ERROR_INPUT,
           "s.json:3: geometry[0].material.metallic: its texture repeats otherwise than that of roughness");
}

/* Metallic and roughness of one image, of two, and of either alone. */
static void metal_and_roughness_share_a_texture(void** state) {
    static const char* const materials[] = {
        "'base_color':1,'metallic':{'file':'quarters.png'},'roughness':{'file':'gray.png'}",
        "'base_color':1,'metallic':{'file':'quarters.png'},'roughness':{'file':'quarters.png'}",
        "'base_color':1,'metallic':{'file':'quarters.png'}",
        "'base_color':1,'metallic':1,'roughness':{'file':'gray.png'}"};
    for (int i = 0; i < 4; ++i) {
        double radiance[3];
        ty_scene* scene = load(*state, under_sky, "'geometry':[{'sphere':{'center':[0,0,0],'radius':1}", materials[i]);
        look(scene, V(3, 3, 3), V(0, 0, 0), radiance);
        assert_close(radiance[0], 1, 0.03);
        ty_scene_destroy(scene);
    }
}

/* A quad as the program gives it, with a texture of its own: as the file's. */
static void textures_in_memory_are_those_of_files(void** state) {
    const float positions[] = {-1, -1, 0, 1, -1, 0, 1, 1, 0, -1, 1, 0}, uv[] = {0, 1, 1, 1, 1, 0, 0, 0};
    const uint32_t indices[] = {0, 1, 2, 0, 2, 3};
    ty_mesh_def mesh = ty_default_mesh_def();
    mesh.vertex_count = 4;
    mesh.triangle_count = 2;
    mesh.positions = positions;
    mesh.indices = indices;
    mesh.uv[0] = uv;
    ty_image* image = NULL;
    assert_int_equal(ty_image_read(*state, "quarters.png", &image), TY_OK);
    ty_scene_editor* editor = NULL;
    const char text[] = "{\"tyndall\":1,\"lights\":[{\"type\":\"environment\",\"radiance\":1}],\"render\":{\"path\":{"
                        "\"max_depth\":2}}}";
    assert_int_equal(ty_scene_editor_open_text(*state, text, strlen(text), "s", NULL, NULL, 0, &editor), TY_OK);
    assert_int_equal(ty_scene_editor_set_mesh(editor, "quad", &mesh), TY_OK);
    assert_int_equal(ty_scene_editor_set_image(editor, "quarters", image), TY_OK);
    ty_scene_change change = {
        "geometry", "[{\"file\":\"memory:quad\",\"material\":{\"base_color\":{\"file\":\"memory:quarters\"}}}]"};
    assert_int_equal(ty_scene_editor_apply(editor, &change, 1, NULL), TY_OK);
    expect_quarters(ty_scene_editor_scene(editor), V(0, 0, 0), V(0, 0, 1), V(1, 0, 0), V(0, 1, 0));
    change.value = "[{\"file\":\"memory:quad\",\"material\":{\"base_color\":{\"file\":\"memory:quad\"}}}]";
    assert_int_equal(ty_scene_editor_apply(editor, &change, 1, NULL), TY_ERROR_INPUT);
    assert_non_null(strstr(ty_take_error(*state), "geometry[0].material.base_color.file: memory:quad is a mesh"));
    ty_scene_editor_close(editor);
    ty_image_destroy(image);
}

/* Under no light but its own; a texture of the scene file is that of meshes, and refused for shapes. */
static void meshes_glow_by_textures(void** state) {
    const char format[] = "{'tyndall':1,%s,'material':{%s}}],'render':{'path':{'max_depth':2}}}";
    const char glow[] = "'base_color':0,'emission':{'file':'quarters.png','factor':[1,1,1]}";
    ty_scene* scene = load(*state, format, "'geometry':[{'file':'square.obj'", glow);
    expect_quarters(scene, V(0, 0, 0), V(0, 0, 1), V(1, 0, 0), V(0, 1, 0));
    ty_scene_destroy(scene);
    refuse(*state, glow, TY_ERROR_INPUT,
           "s.json:3: geometry[0].material.emission: shapes have no textures of emission");
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(quads_show_textures_upright),
        cmocka_unit_test(boxes_show_textures_on_all_sides),
        cmocka_unit_test(spheres_show_textures_from_pole_to_pole),
        cmocka_unit_test(meshes_take_textures_of_the_scene),
        cmocka_unit_test(color_spaces_are_those_of_gltf),
        cmocka_unit_test(maps_of_normals_bend_shapes),
        cmocka_unit_test(coats_have_their_own_normals),
        cmocka_unit_test(wrong_textures_are_refused),
        cmocka_unit_test(metal_and_roughness_share_a_texture),
        cmocka_unit_test(textures_in_memory_are_those_of_files),
        cmocka_unit_test(meshes_glow_by_textures),
    };
    return cmocka_run_group_tests(tests, start, stop_context);
}
