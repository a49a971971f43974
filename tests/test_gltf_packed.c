/* glTF files that viewers must work for: skins, morph targets, instances, compressed meshes, images of extensions. */
#include "mesh_fixture.h"

#define TRIANGLE_TAIL                                                                                                  \
    "'accessors':[{'bufferView':0,'componentType':5126,'count':3,'type':'VEC3'},"                                      \
    "{'bufferView':1,'componentType':5126,'count':3,'type':'VEC3'},"                                                   \
    "{'bufferView':2,'componentType':5121,'count':3,'type':'VEC4'},"                                                   \
    "{'bufferView':3,'componentType':5126,'count':3,'type':'VEC4'},"                                                   \
    "{'bufferView':4,'componentType':5126,'count':2,'type':'MAT4'}],"                                                  \
    "'bufferViews':[{'buffer':0,'byteLength':36},{'buffer':0,'byteOffset':36,'byteLength':36},"                        \
    "{'buffer':0,'byteOffset':72,'byteLength':12},{'buffer':0,'byteOffset':84,'byteLength':48},"                       \
    "{'buffer':0,'byteOffset':132,'byteLength':128}],'buffers':[{'byteLength':260}]}"

static const float triangle[] = {0, 0, 0, 1, 0, 0, 0, 1, 0};

/* Positions, displacements or translations, joints, weights, inverse bind matrices. */
typedef struct content {
    float positions[9], other[9];
    uint8_t joints[12];
    float weights[12], matrices[32];
} content;

static content make_content(void) {
    content c = {.other = {0, 0, 1, 0, 0, 2, 0, 0, 3}};
    memcpy(c.positions, triangle, sizeof triangle);
    for (size_t i = 0; i < 32; ++i) c.matrices[i] = i % 16 % 5 == 0;
    c.matrices[16 + 12] = -10; /* the second joint's bind position is x = 10 */
    for (size_t i = 0; i < 3; ++i) {
        c.joints[4 * i + 1] = 1;
        c.weights[4 * i] = 1;
    }
    return c;
}

static ty_result read_glb(const char* text, const void* data, size_t size, ty_model* model) {
    size_t glb_size = 0;
    uint8_t* glb = make_glb(text, data, size, &glb_size);
    const ty_result result = ty_read_gltf(context, "made.glb", NULL, glb, glb_size, TY_MODEL_ALL, model);
    free(glb);
    return result;
}

static void read_well(const char* text, const void* data, size_t size, ty_model* model) {
    book = (log_book){0};
    if (read_glb(text, data, size, model) != TY_OK) fail_msg("%s", ty_take_error(context));
    assert_true(model_is_whole(model));
}

static void assert_refused(const char* text, const void* data, size_t size, const char* message) {
    ty_model model;
    const ty_result result = read_glb(text, data, size, &model);
    ty_model_free(&model);
    assert_int_equal(result, TY_ERROR_INPUT);
    const char* found = ty_take_error(context);
    if (strstr(found, message) == NULL) fail_msg("%s, not %s", found, message);
}

/* ---- poses ---- */

static const char with_skin[] =
    "{'asset':{'version':'2.0'},'scene':0,'scenes':[{'nodes':[0,1]}],"
    "'nodes':[{'mesh':0,'skin':0,'translation':[99,99,99]},{'translation':[0,5,0],'children':[2]},"
    "{'translation':[10,0,0],'scale':[2,2,-2]}],"
    "'skins':[{'joints':[1,2],'inverseBindMatrices':4}],"
    "'meshes':[{'primitives':[{'attributes':{'POSITION':0,'NORMAL':1,'JOINTS_0':2,'WEIGHTS_0':3}}]}]," TRIANGLE_TAIL;

static void joints_place_vertices(void** state) {
    (void)state;
    content c = make_content();
    /* The second vertex follows the second joint: 2 (p - (10, 0, 0)) + (10, 5, 0); the third one is half of either. */
    c.weights[4] = 0;
    c.weights[5] = 3; /* weights are divided by their sum */
    c.weights[8] = c.weights[9] = 0.5f;
    static const float placed[] = {0, 5, 0, -8, 5, 0, -5, 6.5f, 0};
    ty_model model;
    read_well(with_skin, &c, sizeof c, &model);
    assert_int_equal(model.instance_count, 1);
    assert_floats(model.meshes[0].positions, placed, 9);
    assert_true(model.instances[0].transform.m[3] == 0); /* the node of the mesh does not count */
    assert_int_equal(book.warnings, 0);
    ty_model_free(&model);
}

static void mirrored_joints_keep_the_outside(void** state) {
    (void)state;
    content c = make_content();
    for (size_t i = 0; i < 3; ++i) {
        c.weights[4 * i] = 0;
        c.weights[4 * i + 1] = 1;
    }
    static const float placed[] = {-10, 5, 0, -8, 5, 0, -10, 7, 0}, normals[] = {0, 0, -1, 0, 0, -1, 0, 0, -1};
    static const uint32_t reversed[] = {0, 2, 1};
    ty_model model;
    read_well(with_skin, &c, sizeof c, &model);
    assert_floats(model.meshes[0].positions, placed, 9);
    assert_floats(model.meshes[0].normals, normals, 9);
    assert_memory_equal(model.meshes[0].indices, reversed, sizeof reversed);
    ty_model_free(&model);
}

static void broken_skins_are_refused(void** state) {
    (void)state;
    content c = make_content();
    c.joints[0] = 2;
    assert_refused(with_skin, &c, sizeof c, "accessors[2]: element 0 names joint 2 of 2");
    c = make_content();
    char* text = with_part(with_skin, "'joints':[1,2]", "'joints':[1,7]");
    assert_refused(text, &c, sizeof c, "skins[0].joints[1]: it is not the number of a node");
    free(text);
    text = with_part(with_skin, "'inverseBindMatrices':4", "'inverseBindMatrices':3");
    assert_refused(text, &c, sizeof c, "accessors[3]: not one 4 x 4 matrix for each of 2 joints");
    free(text);
    text = with_part(with_skin, "'skin':0", "'skin':1");
    assert_refused(text, &c, sizeof c, "nodes[0].skin: there is no skins[1]");
    free(text);
}

static const char morphed[] = "{'asset':{'version':'2.0'},'nodes':[{'mesh':0},{'mesh':0,'weights':[0.5]}],"
                              "'meshes':[{'weights':[2],'primitives':[{'attributes':{'POSITION':0},"
                              "'targets':[{'POSITION':1}]}]}]," TRIANGLE_TAIL;

static void morph_targets_have_the_weights_of_node_or_mesh(void** state) {
    (void)state;
    const content c = make_content();
    static const float twice[] = {0, 0, 2, 1, 0, 4, 0, 1, 6}, half[] = {0, 0, 0.5f, 1, 0, 1, 0, 1, 1.5f};
    ty_model model;
    read_well(morphed, &c, sizeof c, &model);
    assert_int_equal(model.mesh_count, 2);
    assert_floats(model.meshes[0].positions, twice, 9);
    assert_floats(model.meshes[1].positions, half, 9);
    ty_model_free(&model);
    char* text = with_part(morphed, "'targets':[{'POSITION':1}]", "'targets':[{'POSITION':4}]");
    assert_refused(text, &c, sizeof c, "accessors[4]: not three components for each of 3 vertices");
    free(text);
}

static void instances_are_placed(void** state) {
    (void)state;
    static const char text[] = "{'asset':{'version':'2.0'},'extensionsRequired':['EXT_mesh_gpu_instancing'],"
                               "'nodes':[{'mesh':0,'translation':[1,0,0],"
                               "'extensions':{'EXT_mesh_gpu_instancing':{'attributes':{'TRANSLATION':1}}}}],"
                               "'meshes':[{'primitives':[{'attributes':{'POSITION':0}}]}]," TRIANGLE_TAIL;
    const content c = make_content();
    ty_model model;
    read_well(text, &c, sizeof c, &model);
    assert_int_equal(model.mesh_count, 1);
    assert_int_equal(model.instance_count, 3);
    for (size_t i = 0; i < 3; ++i) {
        assert_true(model.instances[i].transform.m[3] == 1);
        assert_true(model.instances[i].transform.m[11] == 1 + (double)i);
    }
    ty_model_free(&model);
}

/* Instances of a skinned mesh are placed in the scene and not in the node, like the mesh itself. */
static void instances_of_skins_are_placed(void** state) {
    (void)state;
    const content c = make_content();
    char* text = with_part(with_skin, "'translation':[99,99,99]",
                           "'translation':[99,99,99],'extensions':{'EXT_mesh_gpu_instancing':{'attributes':"
                           "{'TRANSLATION':0}}}");
    ty_model model;
    read_well(text, &c, sizeof c, &model);
    free(text);
    assert_int_equal(model.instance_count, 3);
    for (size_t i = 0; i < 3; ++i)
        for (size_t a = 0; a < 3; ++a)
            assert_true(model.instances[i].transform.m[4 * a + 3] == (double)triangle[3 * i + a]);
    ty_model_free(&model);
}

/* A morph target whose displacements are sparse, of as many vertices as make a search of all for each take minutes. */
static void large_sparse_targets_are_read(void** state) {
    (void)state;
    enum { VERTICES = 400000, SIZE = 12 * VERTICES + 4 * VERTICES };
    uint8_t* data = calloc(1, SIZE);
    for (uint32_t i = 0; i < VERTICES; ++i) {
        const float displaced[3] = {0, 0, (float)i};
        memcpy(data + 4 * (size_t)i, &i, sizeof i);
        memcpy(data + 4 * (size_t)VERTICES + 12 * (size_t)i, displaced, sizeof displaced);
    }
    char text[1024];
    snprintf(text, sizeof text,
             "{'asset':{'version':'2.0'},'buffers':[{'byteLength':%d}],'nodes':[{'mesh':0,'weights':[0.5]}],"
             "'bufferViews':[{'buffer':0,'byteLength':%d},{'buffer':0,'byteOffset':%d,'byteLength':%d}],"
             "'accessors':[{'componentType':5126,'count':%d,'type':'VEC3'},{'componentType':5126,'count':%d,"
             "'type':'VEC3','sparse':{'count':%d,'indices':{'bufferView':0,'componentType':5125},"
             "'values':{'bufferView':1}}}],"
             "'meshes':[{'primitives':[{'attributes':{'POSITION':0},'mode':5,'targets':[{'POSITION':1}]}]}]}",
             SIZE, 4 * VERTICES, 4 * VERTICES, 12 * VERTICES, VERTICES, VERTICES, VERTICES);
    ty_model model;
    read_well(text, data, SIZE, &model);
    const float* positions = model.meshes[0].positions;
    assert_true(positions[2] == 0 && positions[5] == 0.5f && positions[3 * VERTICES - 1] == 0.5f * (VERTICES - 1));
    ty_model_free(&model);
    free(data);
}

/* ---- compression ---- */

/* The triangle and its indices 0, 1, 2 in meshoptimizer's formats of version 0 and 1. */
static const uint8_t packed_vertices[] = {
    0xa0, 0,    0, 1,    0x3c, 0, 0, 0,    0xff, 0xff, 1, 0x3c, 0, 0, 0, 0x7e, 0x7d, 0, 0, 1, 0x0c, 0, 0,
    0,    0xff, 1, 0x0c, 0,    0, 0, 0x7e, 0,    0,    0, 0,    0, 0, 0, 0,    0,    0, 0, 0, 0,    0, 0,
    0,    0,    0, 0,    0,    0, 0, 0,    0,    0,    0, 0,    0, 0, 0, 0,    0,    0, 0, 0, 0};
static const uint8_t packed_indices[] = {0xe1, 0xf0, 0x00, 0x76, 0x87, 0x56, 0x67, 0x78, 0xa9,
                                         0x86, 0x65, 0x89, 0x68, 0x98, 0x01, 0x69, 0x00, 0x00};

static const char meshopt[] =
    "{'asset':{'version':'2.0'},'extensionsRequired':['EXT_meshopt_compression'],'nodes':[{'mesh':0}],"
    "'meshes':[{'primitives':[{'attributes':{'POSITION':0},'indices':1}]}],"
    "'accessors':[{'bufferView':0,'componentType':5126,'count':3,'type':'VEC3'},"
    "{'bufferView':1,'componentType':5123,'count':3,'type':'SCALAR'}],"
    "'bufferViews':[{'buffer':1,'byteLength':36,'byteStride':12,'extensions':{'EXT_meshopt_compression':"
    "{'buffer':0,'byteLength':67,'byteStride':12,'count':3,'mode':'ATTRIBUTES'}}},"
    "{'buffer':1,'byteOffset':36,'byteLength':6,'extensions':{'EXT_meshopt_compression':"
    "{'buffer':0,'byteOffset':67,'byteLength':18,'byteStride':2,'count':3,'mode':'TRIANGLES'}}}],"
    "'buffers':[{'byteLength':85},{'byteLength':42}]}";

static void meshopt_is_decoded(void** state) {
    (void)state;
    uint8_t data[sizeof packed_vertices + sizeof packed_indices];
    memcpy(data, packed_vertices, sizeof packed_vertices);
    memcpy(data + sizeof packed_vertices, packed_indices, sizeof packed_indices);
    static const uint32_t corners[] = {0, 1, 2};
    ty_model model;
    read_well(meshopt, data, sizeof data, &model);
    assert_floats(model.meshes[0].positions, triangle, 9);
    assert_memory_equal(model.meshes[0].indices, corners, sizeof corners);
    ty_model_free(&model);

    static const struct {
        const char *part, *by, *message;
    } cases[] = {
        {"'mode':'ATTRIBUTES'", "'mode':'PIXELS'", "the mode is not ATTRIBUTES, TRIANGLES or INDICES"},
        {"'mode':'ATTRIBUTES'", "'mode':'ATTRIBUTES','filter':'OCTAHEDRAL'", "OCTAHEDRAL needs 4 or 8 bytes"},
        {"'byteLength':67,'byteStride':12", "'byteLength':67,'byteStride':13", "the byteStride is not 4, 8 ... 256"},
        {"'byteStride':2,'count':3", "'byteStride':2,'count':4", "not that of whole triangles"},
        {"'byteLength':67", "'byteLength':97", "EXT_meshopt_compression: reaches past the end of its buffer"},
        {"'byteLength':67", "'byteLength':30", "the compressed data are damaged"},
        {"'count':3,'mode':'ATT", "'count':300000,'mode':'ATT", "67 bytes cannot hold 300000 elements"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        char* text = with_part(meshopt, cases[i].part, cases[i].by);
        assert_refused(text, data, sizeof data, cases[i].message);
        free(text);
    }
}

/* The triangle as Draco's encoder writes it without quantization. */
static const char draco[] =
    "{'asset':{'version':'2.0'},'extensionsRequired':['KHR_draco_mesh_compression'],'nodes':[{'mesh':0}],"
    "'meshes':[{'primitives':[{'attributes':{'POSITION':0},'indices':1,'extensions':{'KHR_draco_mesh_compression':"
    "{'bufferView':0,'attributes':{'POSITION':0}}}}]}],"
    "'accessors':[{'componentType':5126,'count':3,'type':'VEC3'},{'componentType':5123,'count':3,'type':'SCALAR'}],"
    "'bufferViews':[{'buffer':0,'byteLength':70}],'buffers':[{'byteLength':70,'uri':'data:application/octet-stream;"
    "base64,RFJBQ08CAgEBAAAAAwEAAQAAAQf/AREB/wAAAQAJAwAAAAAAgD8AAAAAAAAAAAAAAAAAAIA/AAAAAAAAAAAAAAAAAAAAAAA='}]}";

static void draco_is_decoded(void** state) {
    (void)state;
    ty_model model;
    read_well(draco, "", 0, &model);
    assert_int_equal(model.meshes[0].vertex_count, 3);
    assert_int_equal(model.meshes[0].triangle_count, 1);
    const float* p = model.meshes[0].positions;
    const uint32_t* i = model.meshes[0].indices;
    const float *a = p + 3 * i[0], *b = p + 3 * i[1], *c = p + 3 * i[2];
    const float area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
    assert_true(area == 1); /* twice that of the triangle, counter-clockwise */
    ty_model_free(&model);

    static const struct {
        const char *part, *by, *message;
    } cases[] = {
        {"'count':3,'type':'VEC3'", "'count':4,'type':'VEC3'", "4 elements, but 3 vertices in the Draco mesh"},
        {"'attributes':{'POSITION':0}}", "'attributes':{'POSITION':5}}", "has no POSITION of 3 components"},
        {"RFJBQ08", "RFJBQ09", "meshes[0].primitives[0]: cannot decode this Draco mesh"},
        {"'bufferView':0,", "", "KHR_draco_mesh_compression: bufferView is missing"},
    };
    for (size_t k = 0; k < sizeof cases / sizeof *cases; ++k) {
        char* text = with_part(draco, cases[k].part, cases[k].by);
        assert_refused(text, "", 0, cases[k].message);
        free(text);
    }
}

/* ---- images ---- */

#define ONE_WEBP "UklGRhwAAABXRUJQVlA4TBAAAAAvAAAAEAdQwP5HgQIR0f8A" /* one pixel: 255, 128, 0, 64 */

static const char textured[] =
    "{'asset':{'version':'2.0'},'extensionsRequired':['EXT_texture_webp'],'nodes':[{'mesh':0}],"
    "'meshes':[{'primitives':[{'attributes':{'POSITION':0},'material':0}]}],"
    "'materials':[{'pbrMetallicRoughness':{'baseColorTexture':{'index':0}}}],"
    "'textures':[{'extensions':{'EXT_texture_webp':{'source':0}}}],"
    "'images':[{'uri':'data:image/webp;base64," ONE_WEBP "'},{'uri':'data:,'}]," TRIANGLE_TAIL;

static void webp_images_are_read(void** state) {
    (void)state;
    static const uint8_t pixel[] = {255, 128, 0, 64};
    const content c = make_content();
    ty_model model;
    read_well(textured, &c, sizeof c, &model);
    assert_int_equal(model.image_count, 1);
    assert_memory_equal(model.images[0].rgba8, pixel, sizeof pixel);
    ty_model_free(&model);
    char* text = with_part(textured, "UklGRhwAAABXRUJQVlA4TBAAAAAv", "UklGRhwAAABXRUJQVlA4TBAAAAAA");
    assert_refused(text, &c, sizeof c, "images[0]: the WebP header is damaged or cut short");
    free(text);
}

static void other_images_need_a_source(void** state) {
    (void)state;
    const content c = make_content();
    char* required = with_part(textured, "['EXT_texture_webp']", "['KHR_texture_basisu']");
    char* alone = with_part(required, "'textures':[{'extensions':{'EXT_texture_webp':{'source':0}}}]",
                            "'textures':[{'extensions':{'KHR_texture_basisu':{'source':1}}}]");
    assert_refused(alone, &c, sizeof c, "textures[0]: its only image is one of KHR_texture_basisu");
    char* both =
        with_part(alone, "{'extensions':{'KHR_texture_basisu'", "{'source':0,'extensions':{'KHR_texture_basisu'");
    ty_model model;
    read_well(both, &c, sizeof c, &model);
    assert_int_equal(model.texture_count, 1);
    ty_model_free(&model);
    free(required);
    free(alone);
    free(both);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(joints_place_vertices),
        cmocka_unit_test(mirrored_joints_keep_the_outside),
        cmocka_unit_test(broken_skins_are_refused),
        cmocka_unit_test(morph_targets_have_the_weights_of_node_or_mesh),
        cmocka_unit_test(instances_are_placed),
        cmocka_unit_test(meshopt_is_decoded),
        cmocka_unit_test(instances_of_skins_are_placed),
        cmocka_unit_test(large_sparse_targets_are_read),
        cmocka_unit_test(draco_is_decoded),
        cmocka_unit_test(webp_images_are_read),
        cmocka_unit_test(other_images_need_a_source),
    };
    return cmocka_run_group_tests(tests, start, stop);
}
