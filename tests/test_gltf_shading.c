/* Tangents and normals that glTF files give: poses move tangents, textures of normals and of the clear coat bend what
 * they are for. */
#include "fog.h"
#include "mesh_fixture.h"

#include <png.h>
#include <string.h>
#include <tyndall/io.h>

/* ---- tangents in poses ---- */

/* Positions, normals, tangents, displacements of tangents, joints, weights. */
typedef struct content {
    float positions[9], normals[9], tangents[12], displacements[9];
    uint8_t joints[12];
    float weights[12];
} content;

#define CONTENT_TAIL                                                                                                   \
    "'accessors':[{'bufferView':0,'componentType':5126,'count':3,'type':'VEC3'},"                                      \
    "{'bufferView':0,'byteOffset':36,'componentType':5126,'count':3,'type':'VEC3'},"                                   \
    "{'bufferView':0,'byteOffset':72,'componentType':5126,'count':3,'type':'VEC4'},"                                   \
    "{'bufferView':0,'byteOffset':120,'componentType':5126,'count':3,'type':'VEC3'},"                                  \
    "{'bufferView':1,'componentType':5121,'count':3,'type':'VEC4'},"                                                   \
    "{'bufferView':2,'componentType':5126,'count':3,'type':'VEC4'}],"                                                  \
    "'bufferViews':[{'buffer':0,'byteLength':156},{'buffer':0,'byteOffset':156,'byteLength':12},"                      \
    "{'buffer':0,'byteOffset':168,'byteLength':48}],'buffers':[{'byteLength':216}]}"

/* A triangle in the plane z = 0 whose tangent is (3, 4, 0) / 5, the bitangent's sign -1. */
static content make_content(void) {
    content c = {.positions = {0, 0, 0, 1, 0, 0, 0, 1, 0}};
    for (size_t i = 0; i < 3; ++i) {
        c.normals[3 * i + 2] = 1;
        memcpy(c.tangents + 4 * i, (const float[]){0.6f, 0.8f, 0, -1}, 4 * sizeof(float));
        memcpy(c.displacements + 3 * i, (const float[]){-1.2f, 0, 1.6f}, 3 * sizeof(float));
        c.weights[4 * i] = 1;
    }
    return c;
}

static void expect_tangents(const char* text, const float expected[4]) {
    const content c = make_content();
    size_t size = 0;
    uint8_t* glb = make_glb(text, &c, sizeof c, &size);
    ty_model model;
    if (ty_read_gltf(context, "made.glb", NULL, glb, size, TY_MODEL_ALL, &model) != TY_OK)
        fail_msg("%s", ty_take_error(context));
    free(glb);
    assert_non_null(model.meshes[0].tangents);
    for (size_t i = 0; i < 3; ++i) assert_floats(model.meshes[0].tangents + 4 * i, expected, 4);
    ty_model_free(&model);
}

static const char skinned[] = "{'asset':{'version':'2.0'},'nodes':[{'mesh':0,'skin':0},{%s}],'skins':[{'joints':[1]}],"
                              "'meshes':[{'primitives':[{'attributes':{'POSITION':0,'NORMAL':1,'TANGENT':2,"
                              "'JOINTS_0':4,'WEIGHTS_0':5}}]}]," CONTENT_TAIL;

static void expect_skinned(const char* joint, const float expected[4]) {
    char text[4096];
    snprintf(text, sizeof text, skinned, joint);
    expect_tangents(text, expected);
}

static void skins_move_tangents(void** state) {
    (void)state;
    /* A quarter turn about z, and a shear by scale: (3 * 4, 4, 0) / sqrt(160). */
    expect_skinned("'rotation':[0,0,0.70710678,0.70710678],'translation':[9,9,9]", (const float[]){-0.8f, 0.6f, 0, -1});
    expect_skinned("'scale':[40,10,1]", (const float[]){0.94868330f, 0.31622777f, 0, -1});
}

/* A mirrored bitangent lies on the other side of normal and tangent. */
static void mirrored_skins_turn_the_bitangent(void** state) {
    (void)state;
    expect_skinned("'scale':[-1,1,1]", (const float[]){-0.6f, 0.8f, 0, 1});
    expect_skinned("'scale':[1,1,-2]", (const float[]){0.6f, 0.8f, 0, 1});
    expect_skinned("'scale':[-1,-1,1]", (const float[]){-0.6f, -0.8f, 0, -1});
}

static void morph_targets_move_tangents(void** state) {
    (void)state;
    /* (0.6, 0.8, 0) + (-1.2, 0, 1.6) / 2 = (0, 0.8, 0.8). */
    expect_tangents("{'asset':{'version':'2.0'},'nodes':[{'mesh':0,'weights':[0.5]}],'meshes':[{'primitives':["
                    "{'attributes':{'POSITION':0,'NORMAL':1,'TANGENT':2},'targets':[{'TANGENT':3}]}]}]," CONTENT_TAIL,
                    (const float[]){0, 0.70710678f, 0.70710678f, -1});
}

/* ---- textures of normals ---- */

enum { QUAD_SIZE = 4 * (3 + 2 + 4) * 4 };

/* A square of side 2 about the origin in z = 0: positions, texture coordinates and tangents. */
static void make_quad(float data[QUAD_SIZE / 4]) {
    static const float corners[4][2] = {{-1, -1}, {1, -1}, {-1, 1}, {1, 1}};
    memset(data, 0, QUAD_SIZE);
    for (size_t i = 0; i < 4; ++i) {
        const float x = corners[i][0], y = corners[i][1];
        memcpy(data + 3 * i, (const float[]){x, y, 0}, 12);
        memcpy(data + 12 + 2 * i, (const float[]){0.5f + 0.5f * x, 0.5f - 0.5f * y}, 8);
        memcpy(data + 20 + 4 * i, (const float[]){1, 0, 0, 1}, 16);
    }
}

/* A PNG of one texel: the normal half way between the surface's and u. */
static size_t make_tilt(uint8_t* png) {
    static const uint8_t rgb[] = {218, 128, 218};
    png_image image = {.version = PNG_IMAGE_VERSION, .width = 1, .height = 1, .format = PNG_FORMAT_RGB};
    png_alloc_size_t size = 512;
    assert_int_equal(png_image_write_to_memory(&image, png, &size, 0, rgb, 0, NULL), 1);
    return size;
}

/* The light of a low sun from `sun`, of irradiance 1, that the square sends upwards; with a material of the file, in
 * which %s of the attributes is left out where tangents are to be derived. */
static double look_down(const char* material, bool tangents, const double sun[3], const char* node) {
    static const char format[] =
        "{'asset':{'version':'2.0'},'nodes':[{'mesh':0%s}],"
        "'meshes':[{'primitives':[{'attributes':{'POSITION':0,'TEXCOORD_0':1%s},'mode':5,'material':0}]}],"
        "'materials':[{%s}],'textures':[{'source':0}],'images':[{'bufferView':1,'mimeType':'image/png'}],"
        "'accessors':[{'bufferView':0,'componentType':5126,'count':4,'type':'VEC3'},"
        "{'bufferView':0,'byteOffset':48,'componentType':5126,'count':4,'type':'VEC2'},"
        "{'bufferView':0,'byteOffset':80,'componentType':5126,'count':4,'type':'VEC4'}],"
        "'bufferViews':[{'buffer':0,'byteLength':%d},{'buffer':0,'byteOffset':%d,'byteLength':%zu}],"
        "'buffers':[{'byteLength':%zu}]}";
    uint8_t data[QUAD_SIZE + 512];
    float quad[QUAD_SIZE / 4];
    make_quad(quad);
    memcpy(data, quad, QUAD_SIZE);
    const size_t png_size = make_tilt(data + QUAD_SIZE);
    char text[4096];
    snprintf(text, sizeof text, format, node, tangents ? ",'TANGENT':2" : "", material, QUAD_SIZE, QUAD_SIZE, png_size,
             QUAD_SIZE + png_size);
    size_t size = 0;
    uint8_t* glb = make_glb(text, data, QUAD_SIZE + png_size, &size);
    put_file("quad.glb", glb, size);
    free(glb);
    ty_scene* scene = make_scene(context);
    ty_light_def light = ty_default_light_def();
    for (int a = 0; a < 3; ++a) light.direction[a] = -sun[a];
    const ty_mesh_file_def def = ty_default_mesh_file_def();
    if (ty_scene_add_mesh_file(scene, "quad.glb", &def) != TY_OK) fail_msg("%s", ty_take_error(context));
    assert_int_equal(ty_scene_add_light(scene, &light), TY_OK);
    assert_int_equal(ty_scene_commit(scene), TY_OK);
    static const double ray[6] = {0.3, 0.2, 0, 0, 0, 1};
    const ty_path_def path = small_def(4);
    double radiance[3];
    assert_int_equal(ty_path_radiance(scene, &path, ray, 1, radiance, NULL), TY_OK);
    ty_scene_destroy(scene);
    return radiance[0];
}

static const double east[3] = {1, 0, 0.2}, west[3] = {-1, 0, 0.2}, north[3] = {0, 1, 0.2}, south[3] = {0, -1, 0.2};

#define DIFFUSE                                                                                                        \
    "'pbrMetallicRoughness':{'metallicFactor':0},'extensions':{'KHR_materials_specular':{'specularFactor':0}}"

/* The tilted normal sees the sun in the direction in which the map's u increases: (1, 0, 0.2) . (1, 0, 1) over their
 * lengths, and no sun elsewhere. */
static void expect_tilt_towards(const double sun[3], const double against[3], const char* map, bool tangents,
                                const char* node) {
    char material[512];
    snprintf(material, sizeof material, DIFFUSE ",'normalTexture':{'index':0%s}", map);
    const double lit = look_down(material, tangents, sun, node), unlit = look_down(material, tangents, against, node);
    if (!(fabs(lit - 0.83205 / 3.14159265) < 3e-3 && unlit < 1e-6)) fail_msg("%s%s: %g, %g", map, node, lit, unlit);
}

static void normals_tilt_along_u(void** state) {
    (void)state;
    for (int tangents = 0; tangents < 2; ++tangents) {
        expect_tilt_towards(east, west, "", tangents, "");
        expect_tilt_towards(west, east, ",'scale':-1", tangents, "");
        expect_tilt_towards(west, east, "", tangents, ",'scale':[-1,1,1]");
        expect_tilt_towards(east, west, "", tangents, ",'scale':[1,-1,1]");
    }
}

/* Derived tangents follow KHR_texture_transform, whose quarter turn lets u increase downwards, along v. */
static void derived_tangents_follow_the_transform(void** state) {
    (void)state;
    static const char quarter[] = ",'extensions':{'KHR_texture_transform':{'rotation':1.5707963267948966}}",
                      mirrored[] = ",'extensions':{'KHR_texture_transform':{'scale':[-2,3]}}";
    expect_tilt_towards(south, north, quarter, false, "");
    expect_tilt_towards(west, east, mirrored, false, "");
}

/* The coat reflects the sun upwards where its own normal is half way to it, and the base does not see that normal. */
static void clear_coats_have_their_own_normals(void** state) {
    (void)state;
    static const char coated[] =
        "'pbrMetallicRoughness':{'metallicFactor':0,'baseColorFactor':[%d,%d,%d,1]},'extensions':{"
        "'KHR_materials_specular':{'specularFactor':0},'KHR_materials_clearcoat':{'clearcoatFactor':1,"
        "'clearcoatRoughnessFactor':0.5%s}}%s";
    static const char own[] = ",'clearcoatNormalTexture':{'index':0}",
                      negative[] = ",'clearcoatNormalTexture':{'index':0,'scale':-1}",
                      base[] = ",'normalTexture':{'index':0}";
    static const struct {
        const char *coat, *normal;
        bool bright;
    } cases[] = {{"", "", false}, {own, "", true}, {negative, "", false}, {"", base, false}, {own, base, true}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        char material[1024];
        snprintf(material, sizeof material, coated, 0, 0, 0, cases[i].coat, cases[i].normal);
        const double light = look_down(material, true, east, "");
        /* D F V at 6 degrees from the half way between eye and sun is about 0.1; flat, it is below 0.01. */
        if ((light > 0.05) != cases[i].bright) fail_msg("case %zu: %g", i, light);
    }
    /* A base of its own normals below a flat coat. */
    char flat[1024], bent[1024];
    snprintf(flat, sizeof flat, coated, 1, 1, 1, "", "");
    snprintf(bent, sizeof bent, coated, 1, 1, 1, "", base);
    assert_true(look_down(bent, true, east, "") > 2 * look_down(flat, true, east, ""));
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(skins_move_tangents),
        cmocka_unit_test(mirrored_skins_turn_the_bitangent),
        cmocka_unit_test(morph_targets_move_tangents),
        cmocka_unit_test(normals_tilt_along_u),
        cmocka_unit_test(derived_tangents_follow_the_transform),
        cmocka_unit_test(clear_coats_have_their_own_normals),
    };
    return cmocka_run_group_tests(tests, start, stop);
}
