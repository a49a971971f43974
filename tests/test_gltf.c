/* glTF files: accessors, primitives, nodes, materials, textures, lights, cameras; broken files; real ones. */
#define _GNU_SOURCE
#include "mesh_fixture.h"

#include <tyndall/io.h>

#include <png.h>

/* A triangle with a material, a spot light and a camera. */
static const char triangle[] =
    "{'asset':{'version':'2.0'},'scene':0,'scenes':[{'nodes':[0]}],"
    "'nodes':[{'mesh':0,'children':[1]},{'name':'n','camera':0,'extensions':{'KHR_lights_punctual':{'light':0}}}],"
    "'cameras':[{'type':'perspective','perspective':{'yfov':1,'znear':0.1}}],"
    "'extensions':{'KHR_lights_punctual':{'lights':[{'type':'spot','intensity':2,'color':[1,0.5,0],"
    "'spot':{'innerConeAngle':0.25,'outerConeAngle':0.5}}]}},"
    "'meshes':[{'primitives':[{'attributes':{'POSITION':0},'indices':1,'material':0}]}],"
    "'materials':[{'pbrMetallicRoughness':{'baseColorFactor':[1,0.5,0.25,1]},'emissiveFactor':[1,1,1]}],"
    "'accessors':[{'bufferView':0,'componentType':5126,'count':3,'type':'VEC3'},"
    "{'bufferView':1,'componentType':5121,'count':3,'type':'SCALAR'}],"
    "'bufferViews':[{'buffer':0,'byteLength':36},{'buffer':0,'byteOffset':36,'byteLength':3}],"
    "'buffers':[{'byteLength':39,'uri':'data:application/"
    "octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAAAAEC'}]}";

static const float triangle_positions[] = {0, 0, 0, 1, 0, 0, 0, 1, 0};

/* Reads JSON (with ' for ") without files. */
static ty_result read_text(const char* text, ty_model* model) {
    const char* json = quoted(text);
    return ty_read_gltf(context, "made.gltf", NULL, (const uint8_t*)json, strlen(json), TY_MODEL_ALL, model);
}

static void read_well(const char* text, ty_model* model) {
    book = (log_book){0};
    if (read_text(text, model) != TY_OK) fail_msg("%s", ty_take_error(context));
    assert_true(model_is_whole(model));
}

static void read_data(const char* text, const void* data, size_t size, ty_model* model) {
    size_t glb_size = 0;
    uint8_t* glb = make_glb(text, data, size, &glb_size);
    book = (log_book){0};
    if (ty_read_gltf(context, "made.glb", NULL, glb, glb_size, TY_MODEL_ALL, model) != TY_OK)
        fail_msg("%s", ty_take_error(context));
    free(glb);
    assert_true(model_is_whole(model));
}

static void assert_indices(const ty_model_mesh* mesh, const uint32_t* expected, size_t triangles) {
    assert_int_equal(mesh->triangle_count, triangles);
    for (size_t i = 0; i < 3 * triangles; ++i) assert_int_equal(mesh->indices[i], expected[i]);
}

/* ---- reading ---- */

static void a_triangle_is_read(void** state) {
    (void)state;
    static const uint32_t corners[] = {0, 1, 2};
    static const float albedo[] = {1, 0.5f, 0.25f}, emission[] = {1, 1, 1};
    ty_model model;
    read_well(triangle, &model);
    assert_int_equal(model.mesh_count, 1);
    assert_int_equal(model.meshes[0].vertex_count, 3);
    assert_floats(model.meshes[0].positions, triangle_positions, 9);
    assert_indices(&model.meshes[0], corners, 1);
    assert_null(model.meshes[0].normals);
    assert_int_equal(model.meshes[0].material, 0);
    assert_int_equal(model.material_count, 2); /* and the one for primitives without */
    assert_floats(model.materials[0].def.albedo, albedo, 3);
    assert_floats(model.materials[0].def.emission, emission, 3);
    assert_int_equal(model.materials[0].def.alpha_mode, TY_ALPHA_OPAQUE);
    assert_false(model.materials[0].def.double_sided);
    const ty_gloss_def* gloss = &model.materials[0].def.gloss;
    assert_true(gloss->metallic == 1 && gloss->roughness == 1 && gloss->specular == 1 && gloss->ior == 1.5f);
    assert_int_equal(book.warnings, 0);
    assert_int_equal(book.infos, 0);
    ty_model_free(&model);
}

static void a_spot_is_read(void** state) {
    (void)state;
    static const double down[] = {0, 0, -1};
    static const float intensity[] = {2, 1, 0};
    ty_model model;
    read_well(triangle, &model);
    assert_int_equal(model.light_count, 1);
    const ty_light_def* light = &model.lights[0];
    assert_int_equal(light->kind, TY_LIGHT_SPOT);
    assert_floats(light->color, intensity, 3);
    assert_doubles(light->direction, down, 3);
    assert_true(fabs(light->cone - 57.29577951308232) < 1e-9); /* twice 0.5 rad */
    assert_true(fabs(light->penumbra - 0.5) < 1e-12);
    ty_model_free(&model);
}

static void other_lights_are_read(void** state) {
    (void)state;
    static const double side[] = {-1, 0, 0}, place[] = {7, 8, 9};
    char* turned = with_part(triangle, "'name':'n'",
                             "'translation':[7,8,9],'rotation':[0,0.7071067811865476,0,"
                             "0.7071067811865476]"); /* -z becomes -x */
    char* sun = with_part(turned, "'spot','intensity'", "'directional','intensity'");
    char* point = with_part(turned, "'spot','intensity'", "'point','intensity'");
    ty_model model;
    read_well(sun, &model);
    assert_int_equal(model.lights[0].kind, TY_LIGHT_DIRECTIONAL);
    assert_doubles(model.lights[0].direction, side, 3);
    ty_model_free(&model);
    read_well(point, &model);
    assert_int_equal(model.lights[0].kind, TY_LIGHT_POINT);
    assert_doubles(model.lights[0].position, place, 3);
    ty_model_free(&model);
    free(turned);
    free(sun);
    free(point);
}

/* Interleaved vertices with integer attributes, 24 bytes apart. */
static void interleaved_and_normalized_attributes_are_read(void** state) {
    (void)state;
    static const char text[] =
        "{'asset':{'version':'2.0'},'buffers':[{'byteLength':84}],'nodes':[{'mesh':0}],"
        "'bufferViews':[{'buffer':0,'byteLength':72,'byteStride':24},{'buffer':0,'byteOffset':72,'byteLength':12}],"
        "'accessors':[{'bufferView':0,'componentType':5126,'count':3,'type':'VEC3'},"
        "{'bufferView':0,'byteOffset':12,'componentType':5120,'normalized':true,'count':3,'type':'VEC3'},"
        "{'bufferView':0,'byteOffset':16,'componentType':5123,'normalized':true,'count':3,'type':'VEC2'},"
        "{'bufferView':0,'byteOffset':20,'componentType':5121,'normalized':true,'count':3,'type':'VEC3'},"
        "{'bufferView':1,'componentType':5125,'count':3,'type':'SCALAR'}],"
        "'meshes':[{'primitives':[{'attributes':{'POSITION':0,'NORMAL':1,'TEXCOORD_1':2,'COLOR_0':3},"
        "'indices':4}]}]}";
    uint8_t data[84] = {0};
    static const uint16_t uv[] = {0, 65535, 13107, 32768, 65535, 0};
    static const uint32_t corners[] = {2, 1, 0};
    for (size_t i = 0; i < 3; ++i) {
        memcpy(data + 24 * i, triangle_positions + 3 * i, 12);
        data[24 * i + 14] = i == 0 ? 0x81 : 0x7f; /* z of the normal: -127 and 127 */
        memcpy(data + 24 * i + 16, uv + 2 * i, 4);
        data[24 * i + 20] = (uint8_t)(51 * i);
        data[24 * i + 22] = 255;
    }
    memcpy(data + 72, corners, sizeof corners);
    ty_model model;
    read_data(text, data, sizeof data, &model);
    const ty_model_mesh* mesh = &model.meshes[0];
    static const float normals[] = {0, 0, -1, 0, 0, 1, 0, 0, 1};
    static const float expected_uv[] = {0, 1, 0.2f, 32768.0f / 65535, 1, 0};
    static const float colors[] = {0, 0, 1, 1, 0.2f, 0, 1, 1, 0.4f, 0, 1, 1};
    assert_floats(mesh->positions, triangle_positions, 9);
    assert_floats(mesh->normals, normals, 9);
    assert_null(mesh->uv[0]);
    assert_floats(mesh->uv[1], expected_uv, 6);
    assert_floats(mesh->colors, colors, 12);
    assert_indices(mesh, corners, 1);
    assert_int_equal(mesh->material, 0); /* the plain one: white */
    assert_true(model.materials[0].def.albedo[0] == 1);
    ty_model_free(&model);
}

/* Without a view all is zero but what is sparse; with one, sparse values take the place of its own. */
static void sparse_accessors_are_read(void** state) {
    (void)state;
    static const char text[] =
        "{'asset':{'version':'2.0'},'buffers':[{'byteLength':72}],'nodes':[{'mesh':0},{'mesh':1}],"
        "'bufferViews':[{'buffer':0,'byteLength':36},{'buffer':0,'byteOffset':36,'byteLength':8},"
        "{'buffer':0,'byteOffset':48,'byteLength':24}],"
        "'accessors':[{'componentType':5126,'count':3,'type':'VEC3','sparse':{'count':2,'indices':{'bufferView':1,"
        "'componentType':5125},'values':{'bufferView':2}}},"
        "{'bufferView':0,'componentType':5126,'count':3,'type':'VEC3','sparse':{'count':1,'indices':{'bufferView':1,"
        "'byteOffset':4,'componentType':5125},'values':{'bufferView':2,'byteOffset':12}}}],"
        "'meshes':[{'primitives':[{'attributes':{'POSITION':0}}]},{'primitives':[{'attributes':{'POSITION':1}}]}]}";
    uint8_t data[72] = {0};
    static const uint32_t indices[] = {0, 2};
    static const float values[] = {1, 2, 3, 4, 5, 6};
    memcpy(data, triangle_positions, 36);
    memcpy(data + 36, indices, sizeof indices);
    memcpy(data + 48, values, sizeof values);
    ty_model model;
    read_data(text, data, sizeof data, &model);
    static const float zeros[] = {1, 2, 3, 0, 0, 0, 4, 5, 6}, dense[] = {0, 0, 0, 1, 0, 0, 4, 5, 6};
    assert_floats(model.meshes[0].positions, zeros, 9);
    assert_floats(model.meshes[1].positions, dense, 9);
    ty_model_free(&model);
}

/* Five vertices as strip and fan, and one primitive of points; each takes only the vertices it uses. */
static void strips_and_fans_are_read(void** state) {
    (void)state;
    static const char text[] =
        "{'asset':{'version':'2.0'},'buffers':[{'byteLength':68}],'nodes':[{'mesh':0}],"
        "'bufferViews':[{'buffer':0,'byteLength':60},{'buffer':0,'byteOffset':60,'byteLength':8}],"
        "'accessors':[{'bufferView':0,'componentType':5126,'count':5,'type':'VEC3'},"
        "{'bufferView':1,'componentType':5123,'count':4,'type':'SCALAR'}],"
        "'meshes':[{'primitives':[{'attributes':{'POSITION':0},'mode':5},{'attributes':{'POSITION':0},'mode':6},"
        "{'attributes':{'POSITION':0},'indices':1,'mode':5},{'attributes':{'POSITION':0},'mode':0},"
        "{'attributes':{'POSITION':0},'mode':3}]}]}";
    uint8_t data[68];
    float positions[15];
    for (int i = 0; i < 15; ++i) positions[i] = (float)(i * i);
    static const uint16_t corners[] = {4, 2, 3, 2};
    memcpy(data, positions, 60);
    memcpy(data + 60, corners, 8);
    ty_model model;
    read_data(text, data, sizeof data, &model);
    static const uint32_t strip[] = {0, 1, 2, 1, 3, 2, 2, 3, 4}, fan[] = {1, 2, 0, 2, 3, 0, 3, 4, 0};
    static const uint32_t indexed[] = {2, 0, 1, 0, 0, 1};
    assert_int_equal(model.mesh_count, 3);
    assert_indices(&model.meshes[0], strip, 3);
    assert_indices(&model.meshes[1], fan, 3);
    assert_indices(&model.meshes[2], indexed, 2);
    assert_int_equal(model.meshes[2].vertex_count, 3);
    assert_floats(model.meshes[2].positions, positions + 6, 9);
    assert_int_equal(book.warnings, 1);
    assert_non_null(strstr(book.text, "2 primitives"));
    ty_model_free(&model);
}

static void nodes_are_multiplied(void** state) {
    (void)state;
    char* text = with_part(triangle, "'nodes':[{'mesh':0,'children':[1]},{'name':'n'",
                           "'nodes':[{'matrix':[0,2,0,0,-2,0,0,0,0,0,2,0,1,2,3,1],'children':[1,2]},"
                           "{'mesh':0,'translation':[10,0,0],'scale':[1,-1,3]},{'mesh':0,'name':'n'");
    ty_model model;
    read_well(text, &model);
    free(text);
    assert_int_equal(model.mesh_count, 1); /* read once, shown twice */
    assert_int_equal(model.instance_count, 2);
    assert_int_equal(ty_model_triangles(&model), 2);
    static const double first[] = {0, 2, 0, 1, 2, 0, 0, 22, 0, 0, 6, 3},
                        second[] = {0, -2, 0, 1, 2, 0, 0, 2, 0, 0, 2, 3};
    assert_doubles(model.instances[0].transform.m, first, 12);
    assert_doubles(model.instances[1].transform.m, second, 12);
    ty_model_free(&model);
}

/* ---- Textures ---- */

/* A PNG of w x h texels, each with its number in red; returns its size. */
static size_t make_png(uint32_t width, uint32_t height, uint8_t png[4096]) {
    uint8_t rgba[4 * 64];
    for (uint32_t i = 0; i < width * height; ++i) memcpy(rgba + 4 * i, (uint8_t[]){(uint8_t)i, 7, 8, 255}, 4);
    png_image image = {.version = PNG_IMAGE_VERSION, .width = width, .height = height, .format = PNG_FORMAT_RGBA};
    png_alloc_size_t size = 4096;
    assert_int_equal(png_image_write_to_memory(&image, png, &size, 0, rgba, 0, NULL), 1);
    return size;
}

static const char textured[] =
    "{'asset':{'version':'2.0'},'extensionsUsed':['KHR_texture_transform','KHR_materials_iridescence','X_y'],"
    "'buffers':[{'byteLength':%zu}],'bufferViews':[{'buffer':0,'byteLength':%zu}],"
    "'images':[{'bufferView':0,'mimeType':'image/png'},{'uri':'some%%20image.png'}],"
    "'samplers':[{'wrapS':33071,'wrapT':33648,'magFilter':9728}],"
    "'textures':[{'source':0,'sampler':0},{'source':1},{'source':0}],"
    "'materials':[{'name':'first','pbrMetallicRoughness':{'baseColorTexture':{'index':0,'texCoord':0,'extensions':"
    "{'KHR_texture_transform':{'offset':[0.25,0.5],'rotation':1.5707963267948966,'scale':[2,3],'texCoord':1}}}},"
    "'alphaMode':'MASK','alphaCutoff':0.25,'doubleSided':true},"
    "{'pbrMetallicRoughness':{'baseColorFactor':[1,1,1,0.5],'baseColorTexture':{'index':2}},'alphaMode':'BLEND',"
    "'emissiveFactor':[1,2,3],'emissiveTexture':{'index':1},"
    "'extensions':{'KHR_materials_emissive_strength':{'emissiveStrength':10}}}]}";

/* The textured file with numbers for gloss in its first material. */
static const char glossy[] =
    "{'asset':{'version':'2.0'},'materials':[{'pbrMetallicRoughness':{'metallicFactor':0.25,'roughnessFactor':0.5},"
    "'extensions':{'KHR_materials_ior':{'ior':1.75},'KHR_materials_specular':{'specularFactor':0.5,"
    "'specularColorFactor':[1,2,3]},'KHR_materials_transmission':{'transmissionFactor':0.75},"
    "'KHR_materials_clearcoat':{'clearcoatFactor':1,'clearcoatRoughnessFactor':0.125},"
    "'KHR_materials_sheen':{'sheenColorFactor':[0.25,0.5,1],'sheenRoughnessFactor':0.375}}}]}";

static void gloss_is_read(void** state) {
    (void)state;
    ty_model model;
    read_well(glossy, &model);
    const ty_gloss_def* gloss = &model.materials[0].def.gloss;
    static const float color[] = {1, 2, 3}, sheen[] = {0.25f, 0.5f, 1};
    assert_true(gloss->metallic == 0.25f && gloss->roughness == 0.5f && gloss->ior == 1.75f);
    assert_true(gloss->specular == 0.5f && gloss->transmission == 0.75f);
    assert_true(gloss->clearcoat == 1 && gloss->clearcoat_roughness == 0.125f && gloss->sheen_roughness == 0.375f);
    assert_floats(gloss->specular_color, color, 3);
    assert_floats(gloss->sheen_color, sheen, 3);
    ty_model_free(&model);
}

static void textures_are_read(void** state) {
    (void)state;
    uint8_t inner[4096], outer[4096];
    const size_t inner_size = make_png(2, 3, inner), outer_size = make_png(4, 1, outer);
    char text[4096];
    snprintf(text, sizeof text, textured, inner_size, inner_size);
    put_file("some image.png", outer, outer_size);
    size_t size = 0;
    uint8_t* glb = make_glb(text, inner, inner_size, &size);
    put_file("textured.glb", glb, size);
    free(glb);
    ty_model model;
    book = (log_book){0};
    if (ty_read_model(context, "textured.glb", TY_MODEL_ALL, &model) != TY_OK) fail_msg("%s", ty_take_error(context));
    assert_true(model_is_whole(&model));
    assert_int_equal(book.warnings, 1);
    assert_non_null(strstr(book.text, "\"KHR_materials_iridescence\", \"X_y\""));
    assert_int_equal(model.image_count, 2); /* one of them for two textures */
    assert_int_equal(model.texture_count, 3);
    const ty_model_texture* texture = &model.textures[model.materials[0].albedo_texture];
    assert_true(texture->nearest && texture->wrap[0] == TY_WRAP_CLAMP && texture->wrap[1] == TY_WRAP_MIRROR);
    assert_int_equal(model.images[texture->image].width, 2);
    assert_int_equal(model.images[texture->image].height, 3);
    assert_int_equal(model.images[texture->image].rgba8[4 * 5], 5);
    /* A quarter turn counter-clockwise with v down takes u to -v and v to u. */
    static const float map[] = {0, 3, 0.25f, -2, 0, 0.5f}, emission[] = {10, 20, 30};
    assert_floats(model.materials[0].def.albedo_map, map, 6);
    assert_int_equal(model.materials[0].def.albedo_uv, 1);
    assert_int_equal(model.materials[0].def.alpha_mode, TY_ALPHA_MASK);
    assert_true(model.materials[0].def.alpha_cutoff == 0.25f && model.materials[0].def.double_sided);
    assert_string_equal(model.materials[0].name, "first");
    texture = &model.textures[model.materials[1].emission_texture];
    assert_true(!texture->nearest && texture->wrap[0] == TY_WRAP_REPEAT);
    assert_int_equal(model.images[texture->image].width, 4);
    assert_floats(model.materials[1].def.emission, emission, 3);
    assert_int_equal(model.materials[1].def.alpha_mode, TY_ALPHA_BLEND);
    assert_true(model.materials[1].def.alpha == 0.5f);
    ty_model_free(&model);
}

/* ---- Files beside the file ---- */

static void buffers_may_be_files(void** state) {
    (void)state;
    uint8_t data[39] = {0};
    memcpy(data, triangle_positions, 36);
    data[37] = 1;
    data[38] = 2;
    put_file("some data.bin", data, sizeof data);
    char* start_of_uri = strstr(triangle, "data:");
    char* text = strndup(triangle, (size_t)(start_of_uri - triangle));
    char* whole = malloc(strlen(text) + 64);
    sprintf(whole, "%s./some%%20data.bin'}]}", text);
    put_text("beside.gltf", quoted(whole));
    ty_model model;
    if (ty_read_model(context, "beside.gltf", TY_MODEL_ALL, &model) != TY_OK) fail_msg("%s", ty_take_error(context));
    assert_floats(model.meshes[0].positions, triangle_positions, 9);
    ty_model_free(&model);
    static const char* const refused[] = {"../secret.bin", "a/../../secret.bin", "/etc/passwd",  "http://x/y.bin",
                                          "C:/x.bin",      "%2e%2e/secret.bin",  "%2fetc/passwd"};
    for (size_t i = 0; i < sizeof refused / sizeof *refused; ++i) {
        sprintf(whole, "%s%s'}]}", text, refused[i]);
        put_text("beside.gltf", quoted(whole));
        const ty_result result = ty_read_model(context, "beside.gltf", TY_MODEL_ALL, &model);
        assert_failed(context, result, TY_ERROR_INPUT, "beside.gltf: buffers[0].uri: ", NULL);
        ty_model_free(&model);
    }
    sprintf(whole, "%smissing.bin'}]}", text);
    put_text("beside.gltf", quoted(whole));
    assert_failed(context, ty_read_model(context, "beside.gltf", TY_MODEL_ALL, &model), TY_ERROR_FILE, "missing.bin",
                  "No such file");
    ty_model_free(&model);
    free(text);
    free(whole);
}

/* ---- Broken files ---- */

static void broken_files_are_refused(void** state) {
    (void)state;
    static const struct {
        const char *part, *by, *message;
    } cases[] = {
        {"'asset'", "asset", "made.gltf:1: "},
        {"'asset'", "'Asset'", "asset.version is missing"},
        {"'2.0'", "'1.0'", "glTF version \"1.0\""},
        {"'scene':0", "'extensionsRequired':['KHR_materials_dispersion'],'scene':0", "\"KHR_materials_dispersion\""},
        {"'scene':0", "'scene':7", "scene: there is no scenes[7]"},
        {"'scene':0", "'scene':'a'", "scene: expected a whole number, found \"a\""},
        {"[{'nodes':[0]}]", "[3]", "scenes[0]: expected an object"},
        {"'nodes':[0]", "'nodes':[5]", "scenes[0].nodes[0]: it is not the number of a node"},
        {"'children':[1]", "'children':[0]", "nodes[0]: it is the child of two nodes, or of itself"},
        {"'children':[1]", "'children':[1,1]", "nodes[1]: it is the child of two nodes, or of itself"},
        {"'mesh':0", "'mesh':1", "nodes[0].mesh: there is no meshes[1]"},
        {"'mesh':0", "'mesh':0,'matrix':[1,0,0,0,0,1,0,0,0,0,1,0,0,0,0,2]", "last row of the matrix"},
        {"'mesh':0", "'mesh':0,'translation':[1,2]", "nodes[0].translation: expected 3 numbers, found 2"},
        {"'mesh':0", "'mesh':0,'scale':[1,'x',1]", "nodes[0].scale[1]: expected a number, found \"x\""},
        {"'yfov':1", "'yfov':4", "cameras[0].yfov: 4 is outside"},
        {"'yfov':1,", "", "perspective.yfov is missing"},
        {"'light':0", "'light':3", "nodes[1]: there is no light 3"},
        {"'outerConeAngle':0.5", "'outerConeAngle':0.1", "the inner cone is not inside the outer one"},
        {"'type':'spot'", "'type':'lamp'", "lights[0]: the type is not point, spot or directional"},
        {"'POSITION':0", "'POSITION':1", "POSITION: an accessor of 1 components, not 3"},
        {"'POSITION':0", "'POSITION':0,'NORMAL':1", "NORMAL: an accessor of 1 components, not 3"},
        {"'indices':1", "'indices':0", "accessors[0]: indices must be single unsigned integers"},
        {"'material':0", "'material':2", "primitives[0].material: there is no materials[2]"},
        {"'material':0", "'mode':9", "mode: 9 is outside [0, 6]"},
        {"[1,0.5,0.25,1]", "[1,2,0.25,1]", "baseColorFactor[1]: 2 is outside [0, 1]"},
        {"[1,0.5,0.25,1]", "[1,2,0.25]", "materials[0].pbrMetallicRoughness.baseColorFactor: expected 4 numbers"},
        {"'emissiveFactor'", "'alphaMode':'GLASS','emissiveFactor'", "there is no alphaMode \"GLASS\""},
        {"'count':3,'type':'VEC3'", "'count':4,'type':'VEC3'", "accessors[0]: reaches past the end of its bufferView"},
        {"'count':3,'type':'VEC3'", "'type':'VEC3'", "accessors[0]: count is missing"},
        {"'count':3,'type':'VEC3'", "'byteOffset':4,'count':3,'type':'VEC3'", "accessors[0]: reaches past the end"},
        {"'count':3,'type':'SCALAR'", "'count':2,'type':'SCALAR'", "2 corners do not make whole triangles"},
        {"'componentType':5126", "'componentType':1", "accessors[0]: 1 is not a componentType"},
        {"'VEC3'", "'MAT3'", "accessors[0]: the type is not SCALAR, VEC2, VEC3, VEC4 or MAT4"},
        {"'bufferView':0", "'bufferView':2", "accessors[0].bufferView: there is no bufferViews[2]"},
        {"'bufferView':0,'componentType':5126,'count':3", "'componentType':5126,'count':2000000000",
         "accessors[0]: 2000000000 elements without a bufferView"},
        {"'byteLength':36", "'byteLength':99", "bufferViews[0]: reaches past the end of its buffer"},
        {"'byteLength':36", "'byteLength':36,'byteStride':8", "more than the byteStride of 8"},
        {"'byteOffset':36", "'byteOffset':29", "accessors[1]: index 128 is past the end of 3 vertices"},
        {"'byteLength':39", "'byteLength':400", "buffers[0]: byteLength is 400, but there are 39 bytes"},
        {"'byteLength':39", "'byteLength':-1", "buffers[0].byteLength: -1 is outside"},
        {"base64,AAAAAAAA", "base64,*", "buffers[0].uri: a data: URI with damaged base64"},
        {";base64,", ",", "buffers[0].uri: a data: URI that is not base64"},
        {"base64,AAAAAAAA", "base64,////////", "accessors[0]: element 0 is not finite"},
        {"'data:application", "'x:application", "buffers[0].uri: \"x:application"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        char* text = with_part(triangle, cases[i].part, cases[i].by);
        ty_model model;
        const ty_result result = read_text(text, &model);
        assert_failed(context, result, TY_ERROR_INPUT, "made.gltf:", cases[i].message);
        ty_model_free(&model);
        free(text);
    }
}

static void broken_sparse_accessors_are_refused(void** state) {
    (void)state;
    static const char sparse[] = "'componentType':5126,'count':3,'type':'VEC3','sparse':{'count':1,'indices':"
                                 "{'bufferView':1,'componentType':5121},'values':{'bufferView':0}}";
    static const struct {
        const char *part, *by, *message;
    } cases[] = {
        {"'count':1", "'count':4", "sparse.count: 4 is outside [1, 3]"},
        {"'bufferView':1,", "", "indices or values have no bufferView"},
        {"5121", "5126", "the componentType is not that of unsigned integers"},
        {"'bufferView':1", "'bufferView':0,'byteOffset':30", "accessors[0].sparse.indices: index 128 is past the end"},
        {"'values':{'bufferView':0", "'values':{'bufferView':0,'byteOffset':30", "sparse.values: reaches past the end"},
        {"'count':1,'indices':{'bufferView':1", "'count':2,'indices':{'bufferView':0",
         "accessors[0].sparse.indices: index 0 follows 0: they do not increase"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        char* accessor = with_part(sparse, cases[i].part, cases[i].by);
        char* text = with_part(triangle, "'bufferView':0,'componentType':5126,'count':3,'type':'VEC3'", accessor);
        ty_model model;
        assert_failed(context, read_text(text, &model), TY_ERROR_INPUT, "made.gltf:", cases[i].message);
        ty_model_free(&model);
        free(accessor);
        free(text);
    }
}

static void deep_nodes_are_refused(void** state) {
    (void)state;
    enum { NODES = 600 };
    char text[64 * NODES] = "{'asset':{'version':'2.0'},'nodes':[";
    size_t used = strlen(text);
    for (int i = 0; i < NODES - 1; ++i)
        used += (size_t)snprintf(text + used, sizeof text - used, "{'children':[%d]},", i + 1);
    snprintf(text + used, sizeof text - used, "{}]}");
    ty_model model;
    assert_failed(context, read_text(text, &model), TY_ERROR_INPUT, "made.gltf: nodes[512]", "nested");
    ty_model_free(&model);
}

static void broken_containers_are_refused(void** state) {
    (void)state;
    size_t size = 0;
    uint8_t* glb = make_glb("{'asset':{'version':'2.0'}}", "data", 4, &size);
    static const struct {
        size_t at;
        uint8_t value;
        const char* message;
    } cases[] = {{4, 1, "a GLB of version 1"},
                 {9, 1, "cut short"},
                 {13, 1, "reaches past the end"},
                 {16, 'X', "there is no JSON chunk"},
                 {20, 'X', "broken.glb:1: "}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        ty_model model;
        const uint8_t kept = glb[cases[i].at];
        glb[cases[i].at] = cases[i].value;
        assert_failed(context, ty_read_gltf(context, "broken.glb", "", glb, size, TY_MODEL_ALL, &model), TY_ERROR_INPUT,
                      "broken.glb", cases[i].message);
        ty_model_free(&model);
        glb[cases[i].at] = kept;
    }
    free(glb);
}

/* Every beginning of a file is refused, and no flipped bit does harm. */
static void torn_files_do_no_harm(void** state) {
    (void)state;
    const char* json = quoted(triangle);
    const size_t size = strlen(json);
    uint8_t* bytes = malloc(size + 1);
    memcpy(bytes, json, size + 1);
    for (size_t length = 0; length < size; ++length) {
        ty_model model;
        assert_failed(context, ty_read_gltf(context, "torn.gltf", NULL, bytes, length, TY_MODEL_ALL, &model),
                      TY_ERROR_INPUT, "torn.gltf", NULL);
        ty_model_free(&model);
    }
    for (size_t i = 0; i < 8 * size; i += 3) {
        bytes[i / 8] ^= (uint8_t)(1 << i % 8);
        ty_model model;
        const ty_result result = ty_read_gltf(context, "torn.gltf", NULL, bytes, size, TY_MODEL_ALL, &model);
        assert_true(result == TY_OK ? model_is_whole(&model) : ty_take_error(context)[0] != '\0');
        ty_model_free(&model);
        bytes[i / 8] ^= (uint8_t)(1 << i % 8);
    }
    free(bytes);
}

static ty_result read_and_free(ty_context* strict, void* user) {
    ty_model model;
    const char* json = user;
    const ty_result result =
        ty_read_gltf(strict, "made.gltf", NULL, (const uint8_t*)json, strlen(json), TY_MODEL_ALL, &model);
    ty_model_free(&model);
    return result;
}

static void short_memory_is_survived(void** state) {
    (void)state;
    const char* json = quoted(triangle);
    strict_memory memory = {.limit = (size_t)1 << 30, .until_refusal = -1};
    ty_context* strict = strict_context(&memory);
    assert_true(check_short_memory(strict, &memory, read_and_free, (void*)(uintptr_t)json) > 5);
    ty_context_destroy(strict);
}

/* ---- Real files ---- */

static double seconds_since(const struct timespec* begin) {
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)(now.tv_sec - begin->tv_sec) + 1e-9 * (double)(now.tv_nsec - begin->tv_nsec);
}

static void real_files_are_read(void** state) {
    (void)state;
    static const struct {
        const char* name;
        int64_t triangles;
    } files[] = {{"scenes/cornell_box_lightmap_uv.glb", 36},
                 {"scenes/sponza_atrium.glb", 33663},
                 {"scenes/wooden_staircase.glb", 262508}};
    for (size_t i = 0; i < sizeof files / sizeof *files; ++i) {
        char path[1024];
        ty_model model;
        data_path(files[i].name, path);
        struct timespec begin;
        clock_gettime(CLOCK_MONOTONIC, &begin);
        if (ty_read_model(context, path, TY_MODEL_MESHES | TY_MODEL_SHADING, &model) != TY_OK)
            fail_msg("%s", ty_take_error(context));
        const double shapes = seconds_since(&begin);
        ty_model_free(&model);
        clock_gettime(CLOCK_MONOTONIC, &begin);
        if (ty_read_model(context, path, TY_MODEL_ALL, &model) != TY_OK) fail_msg("%s", ty_take_error(context));
        printf("%s: %zu meshes, %zu materials, %zu images, %zu lights, %zu cameras; %.3f s, with textures %.3f s\n",
               files[i].name, model.mesh_count, model.material_count, model.image_count, model.light_count,
               model.camera_count, shapes, seconds_since(&begin));
        assert_true(model_is_whole(&model));
        assert_int_equal(ty_model_triangles(&model), files[i].triangles);
        ty_model_free(&model);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_triangle_is_read),        cmocka_unit_test(a_spot_is_read),
        cmocka_unit_test(other_lights_are_read),     cmocka_unit_test(interleaved_and_normalized_attributes_are_read),
        cmocka_unit_test(sparse_accessors_are_read), cmocka_unit_test(strips_and_fans_are_read),
        cmocka_unit_test(nodes_are_multiplied),      cmocka_unit_test(gloss_is_read),
        cmocka_unit_test(textures_are_read),         cmocka_unit_test(buffers_may_be_files),
        cmocka_unit_test(broken_files_are_refused),  cmocka_unit_test(broken_sparse_accessors_are_refused),
        cmocka_unit_test(deep_nodes_are_refused),    cmocka_unit_test(broken_containers_are_refused),
        cmocka_unit_test(torn_files_do_no_harm),     cmocka_unit_test(short_memory_is_survived),
        cmocka_unit_test(real_files_are_read),
    };
    return cmocka_run_group_tests(tests, start, stop);
}
