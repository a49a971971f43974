/* Scenes that are edited: each is as if the edited document had been loaded; a wrong edit changes nothing. */
#define _GNU_SOURCE
#include "mesh_maker.h"

#include "base/context.h"
#include "io/scenes/scene_editor.h"
#include "scene/scene.h"

#include <tyndall/tyndall.h>

#define COUNT(array) (int32_t)(sizeof(array) / sizeof(array)[0])

static ty_context* context;

static int start(void** state) {
    (void)state;
    ty_context_def def = ty_default_context_def();
    def.threads = 2;
    return ty_context_create(&def, &context) == TY_OK ? 0 : 1;
}

static int stop(void** state) {
    (void)state;
    ty_context_destroy(context);
    return 0;
}

static void expect_ok(ty_result result) {
    if (result != TY_OK) fail_msg("%s: %s", ty_result_name(result), ty_take_error(context));
}

static ty_scene_editor* open_scene(const char* path) {
    ty_scene_editor* editor = NULL;
    expect_ok(ty_scene_editor_open(context, path, NULL, 0, &editor));
    return editor;
}

static uint32_t apply(ty_scene_editor* editor, const char* path, const char* value) {
    uint32_t edited = 99;
    const ty_scene_change change = {path, value};
    const ty_result result = ty_scene_editor_apply(editor, &change, 1, &edited);
    if (result != TY_OK) fail_msg("%s = %s: %s", path, value, ty_take_error(context));
    return edited;
}

/* ---- comparison with a scene that is loaded anew ---- */

/* Images small enough to be made after every edit. */
#define SET_SIZE(def)                                                                                                  \
    do {                                                                                                               \
        (def).width = 24;                                                                                              \
        (def).height = 16;                                                                                             \
        (def).spp = 2;                                                                                                 \
    } while (false)

static ty_result render(const ty_scene* scene, const char* method, ty_image** out) {
    if (strcmp(method, "path") == 0) {
        ty_path_def def = ty_default_path_def();
        SET_SIZE(def);
        return ty_path_render(scene, &def, out, NULL);
    }
    if (strcmp(method, "fld") == 0) {
        ty_fld_def def = ty_default_fld_def();
        SET_SIZE(def);
        def.resolution = 12;
        def.environment_beams = 4;
        return ty_fld_render(scene, &def, out, NULL);
    }
    ty_pop_def def = ty_default_pop_def();
    SET_SIZE(def);
    def.resolution = def.merged = def.direct = 12;
    def.ordinates = 4;
    def.vpls = 4;
    return ty_pop_render(scene, &def, out, NULL);
}

static void expect_same_images(const ty_scene* a, const ty_scene* b, const char* method) {
    ty_image *first = NULL, *second = NULL;
    expect_ok(render(a, method, &first));
    expect_ok(render(b, method, &second));
    assert_int_equal(ty_image_channel_count(first), ty_image_channel_count(second));
    const size_t bytes = sizeof(float) * (size_t)ty_image_width(first) * (size_t)ty_image_height(first);
    for (int32_t c = 0; c < ty_image_channel_count(first); ++c)
        if (memcmp(ty_image_plane(first, c), ty_image_plane(second, c), bytes) != 0)
            fail_msg("%s: channel %d differs", method, c);
    ty_image_destroy(first);
    ty_image_destroy(second);
}

/* The edited scene is that of its document, loaded anew from the folder of the first. */
static void expect_as_loaded(const ty_scene_editor* editor, const char* folder) {
    const char* text = ty_scene_editor_text(editor);
    const ty_scene* edited = ty_scene_editor_scene(editor);
    ty_scene* loaded = NULL;
    expect_ok(ty_scene_parse(context, text, strlen(text), "loaded", folder, NULL, 0, &loaded));
    if (ty_scene_hash(edited) != ty_scene_hash(loaded)) fail_msg("another hash: %s", text);
    const ty_scene_info a = ty_scene_get_info(edited), b = ty_scene_get_info(loaded);
    assert_memory_equal(&a, &b, sizeof a);
    assert_memory_equal(&edited->camera, &loaded->camera, sizeof loaded->camera);
    assert_string_equal(ty_scene_camera_source(edited), ty_scene_camera_source(loaded));
    assert_string_equal(ty_scene_render_settings(edited).method, ty_scene_render_settings(loaded).method);
    assert_int_equal(ty_scene_render_settings(edited).spp, ty_scene_render_settings(loaded).spp);
    expect_same_images(edited, loaded, "path");
    if (a.media > 0) expect_same_images(edited, loaded, "fld");
    if (a.media > 0) expect_same_images(edited, loaded, "pop");
    ty_scene_destroy(loaded);
}

/* ---- edits of builtin scenes ---- */

typedef struct edit {
    const char *path, *value;
    uint32_t flags;
} edit;

static void expect_edits(ty_scene_editor* editor, const char* folder, const edit* edits, int32_t count) {
    for (int32_t i = 0; i < count; ++i) {
        const uint32_t flags = apply(editor, edits[i].path, edits[i].value);
        if (flags != edits[i].flags) fail_msg("%s: flags %u, not %u", edits[i].path, flags, edits[i].flags);
        expect_as_loaded(editor, folder);
    }
}

static void a_cloud_is_edited(void** state) {
    (void)state;
    static const edit edits[] = {
        {"media[0].g", "0.8", TY_EDIT_LIGHT},
        {"media[0].g", "0.80", TY_EDIT_NOTHING},
        {"media[0].sigma_t", "[10, 20, 30]", TY_EDIT_LIGHT},
        {"media[0].density.noise.resolution", "16", TY_EDIT_LIGHT},
        {"media[0].bounds[1][1]", "0.7", TY_EDIT_LIGHT},
        {"lights[0].irradiance", "[1, 0.5, 0]", TY_EDIT_LIGHT},
        {"lights[1]", "{\"type\": \"environment\", \"sky\": {\"resolution\": 32}}", TY_EDIT_LIGHT},
        {"lights[1].scale", "2", TY_EDIT_LIGHT},
        {"lights[1].sky.haze", "3", TY_EDIT_LIGHT},
        {"lights[0]", NULL, TY_EDIT_LIGHT},
        {"camera.fov_y", "40", TY_EDIT_CAMERA},
        {"camera.resolution", "[64, 32]", TY_EDIT_CAMERA},
        {"camera.fov_y", NULL, TY_EDIT_CAMERA},
        {"camera.fov_y", NULL, TY_EDIT_NOTHING},
        {"render.method", "\"fld\"", TY_EDIT_RENDER},
        {"render.fld.iterations", "5", TY_EDIT_RENDER},
        {"render.fld", NULL, TY_EDIT_RENDER},
        {"render", NULL, TY_EDIT_RENDER},
        {"media[1]", "{\"bounds\": [[-2, -2, -2], [2, 2, 2]], \"preset\": \"fog\", \"visibility\": 10}", TY_EDIT_LIGHT},
        {"media[1].visibility", "20", TY_EDIT_LIGHT},
        {"media[0]", NULL, TY_EDIT_LIGHT},
        {"geometry[0]", "{\"box\": [[-3, -3, -3], [3, -2.5, 3]]}", TY_EDIT_GEOMETRY},
        {"geometry[0].material.albedo", "0.9", TY_EDIT_GEOMETRY},
        {"media", NULL, TY_EDIT_LIGHT},
        {"geometry", NULL, TY_EDIT_GEOMETRY},
        {"up_axis", "\"z\"", TY_EDIT_CAMERA | TY_EDIT_LIGHT | TY_EDIT_GEOMETRY},
    };
    const char* coarse = "media[0].density.noise.resolution=12";
    ty_scene_editor* editor = NULL;
    expect_ok(ty_scene_editor_open(context, "builtin:cloud_sun", &coarse, 1, &editor));
    expect_as_loaded(editor, "");
    expect_edits(editor, "", edits, COUNT(edits));
    ty_scene_editor_close(editor);
}

static void a_room_is_edited(void** state) {
    (void)state;
    static const edit edits[] = {
        {"media[0].g", "0.3", TY_EDIT_LIGHT},
        {"lights[0].radiance", "[5, 4, 3]", TY_EDIT_LIGHT | TY_EDIT_GEOMETRY},
        {"lights[0].radiance", "0", TY_EDIT_LIGHT | TY_EDIT_GEOMETRY},
        {"lights[0].radiance", "7", TY_EDIT_LIGHT | TY_EDIT_GEOMETRY},
        {"lights[0].u", "[0, 0.2, 0]", TY_EDIT_LIGHT | TY_EDIT_GEOMETRY},
        {"lights[1]", "{\"type\": \"point\", \"position\": [0.1, 0.5, 0.2], \"intensity\": 1}", TY_EDIT_LIGHT},
        {"lights[1].position[0]", "-0.1", TY_EDIT_LIGHT},
        {"media[0].sigma_t", "1", TY_EDIT_LIGHT},
        {"lights[0]", NULL, TY_EDIT_LIGHT | TY_EDIT_GEOMETRY},
        {"camera.position[2]", "3", TY_EDIT_CAMERA},
    };
    ty_scene_editor* editor = open_scene("builtin:cornell_fog");
    expect_edits(editor, "", edits, COUNT(edits));
    ty_scene_editor_close(editor);
}

/* ---- wrong edits ---- */

static void refuse(ty_scene_editor* editor, const ty_scene_change* changes, int32_t count, const char* message) {
    char* text = strdup(ty_scene_editor_text(editor));
    const ty_scene* scene = ty_scene_editor_scene(editor);
    const uint64_t hash = ty_scene_hash(scene);
    uint32_t edited = 99;
    assert_int_not_equal(ty_scene_editor_apply(editor, changes, count, &edited), TY_OK);
    assert_string_equal(ty_take_error(context), message);
    assert_int_equal(edited, TY_EDIT_NOTHING);
    assert_string_equal(ty_scene_editor_text(editor), text);
    assert_ptr_equal(ty_scene_editor_scene(editor), scene);
    assert_int_equal(ty_scene_hash(scene), hash);
    free(text);
}

static void wrong_edits_change_nothing(void** state) {
    (void)state;
    static const struct {
        const char *path, *value, *message;
    } wrong[] = {
        {"media[0].g", "1.2", "media[0].g: 1.2 is outside (-1, 1)"},
        {"media[0].g", "bold", "media[0].g: the value is not valid JSON"},
        {"media[0].sigma_z", "0", "media[0].sigma_z: unknown key; did you mean \"sigma_s\"?"},
        {"media[2].g", "0", "media[2].g: media has 1 element"},
        {"media[2]", NULL, "media[2]: media has 1 element"},
        {"media.g", "0", "media.g: media is an array, not an object"},
        {"media..g", "0", "media..g: expected a path such as media[0].g"},
        {"media[0].sigma_s", "1",
         "media[0].sigma_t: does not go with \"sigma_s\"; give sigma_s and sigma_a, or sigma_t and albedo, or preset"},
        {"media[0].bounds", NULL, "media[0]: a homogeneous medium needs the key \"bounds\""},
        {"lights[0].u", "[0, 0, 0]", "lights[0]: the edges u and v span no area"},
        {"camera.target", "[0, -4.5, 0]", "camera: position and target are the same point"},
        {"geometry[0].quad.u", "[0, 0, 0]", "geometry[0].quad: the edges u and v span no area"},
        {"tyndall", NULL, "the key \"tyndall\" is missing"},
    };
    ty_scene_editor* editor = open_scene("builtin:cornell_fog");
    for (int32_t i = 0; i < COUNT(wrong); ++i) {
        const ty_scene_change changes[] = {
            {"camera.fov_y", "50"}, {"media[0].name", "\"mist\""}, {wrong[i].path, wrong[i].value}};
        refuse(editor, changes, 3, wrong[i].message);
    }
    expect_as_loaded(editor, "");
    ty_scene_editor_close(editor);
}

static void wrong_scenes_do_not_open(void** state) {
    (void)state;
    ty_scene_editor* editor = NULL;
    const char* override = "media[0].g=7";
    assert_int_not_equal(ty_scene_editor_open(context, "builtin:none", NULL, 0, &editor), TY_OK);
    assert_non_null(strstr(ty_take_error(context), "there is no scene \"builtin:none\""));
    assert_int_not_equal(ty_scene_editor_open(context, "builtin:cornell_fog", &override, 1, &editor), TY_OK);
    assert_string_equal(ty_take_error(context), "override \"media[0].g=7\": media[0].g: 7 is outside (-1, 1)");
    assert_null(editor);
    ty_scene_editor_close(NULL);
}

/* ---- saved text, and changes as overrides ---- */

static ty_scene_editor* open_text(const char* text) {
    put_text("edited.json", text);
    return open_scene("edited.json");
}

/* Both ways to keep the changes lead to the scene that is shown. */
static void expect_kept(const ty_scene_editor* editor, const char* path) {
    char *text = NULL, **overrides = NULL;
    int32_t count = 0;
    ty_scene* scene = NULL;
    const uint64_t hash = ty_scene_hash(ty_scene_editor_scene(editor));
    expect_ok(ty_scene_editor_save_text(editor, &text));
    expect_ok(ty_scene_parse(context, text, strlen(text), "saved", "", NULL, 0, &scene));
    if (ty_scene_hash(scene) != hash) fail_msg("saved as\n%s\nfor\n%s", text, ty_scene_editor_text(editor));
    ty_scene_destroy(scene);
    expect_ok(ty_scene_editor_overrides(editor, &overrides, &count));
    expect_ok(ty_scene_load(context, path, (const char* const*)overrides, count, &scene));
    for (int32_t i = 0; i < count && ty_scene_hash(scene) != hash; ++i) print_message("%s\n", overrides[i]);
    if (ty_scene_hash(scene) != hash) fail_msg("overrides for\n%s", ty_scene_editor_text(editor));
    ty_scene_destroy(scene);
    ty_scene_editor_free_overrides(editor, overrides, count);
    ty_free_text(context, text);
}

static void expect_text(const ty_scene_editor* editor, const char* expected) {
    char* text = NULL;
    expect_ok(ty_scene_editor_save_text(editor, &text));
    assert_string_equal(text, expected);
    ty_free_text(context, text);
}

static void expect_overrides(const ty_scene_editor* editor, const char* const* expected, int32_t expected_count) {
    char** overrides = NULL;
    int32_t count = 0;
    expect_ok(ty_scene_editor_overrides(editor, &overrides, &count));
    for (int32_t i = 0; i < count && i < expected_count; ++i) assert_string_equal(overrides[i], expected[i]);
    assert_int_equal(count, expected_count);
    ty_scene_editor_free_overrides(editor, overrides, count);
}

#define FOG "{ \"sigma_t\": 1.50, \"albedo\": 0.5, \"bounds\": [[0, 0, 0], [1, 1, 1]] }"

static void text_keeps_its_form(void** state) {
    (void)state;
    ty_scene_editor* editor = open_text("{\n"
                                        "    \"tyndall\": 1,\n"
                                        "    \"camera\": { \"position\": [0.0, 1e0, 5], \"fov_y\": 4.0e1 },\n"
                                        "    \"media\": [\n"
                                        "        " FOG "\n"
                                        "    ],\n"
                                        "    \"lights\": [\n"
                                        "        {\n"
                                        "            \"type\": \"point\",\n"
                                        "            \"position\": [0, 1, 0],\n"
                                        "            \"intensity\": 3\n"
                                        "        }\n"
                                        "    ]\n"
                                        "}\n");
    expect_kept(editor, "edited.json");
    apply(editor, "camera.position[2]", "5.25");
    apply(editor, "camera.exposure", "1");
    apply(editor, "media[0].g", "0.1");
    apply(editor, "media[1]", "{\"preset\": \"fog\", \"visibility\": 9, \"bounds\": [[0, 0, 0], [1, 1, 1]]}");
    apply(editor, "lights[1]", "{\"type\": \"environment\", \"radiance\": [1, 2, 3]}");
    apply(editor, "lights[0].intensity", "[3, 2, 1]");
    apply(editor, "render.spp", "5");
    expect_text(editor,
                "{\n"
                "    \"tyndall\": 1,\n"
                "    \"camera\": { \"position\": [0.0, 1e0, 5.25], \"fov_y\": 4.0e1, \"exposure\": 1 },\n"
                "    \"media\": [\n"
                "        { \"sigma_t\": 1.50, \"albedo\": 0.5, \"bounds\": [[0, 0, 0], [1, 1, 1]], \"g\": 0.1 },\n"
                "        { \"preset\": \"fog\", \"visibility\": 9, \"bounds\": [[0, 0, 0], [1, 1, 1]] }\n"
                "    ],\n"
                "    \"lights\": [\n"
                "        {\n"
                "            \"type\": \"point\",\n"
                "            \"position\": [0, 1, 0],\n"
                "            \"intensity\": [3, 2, 1]\n"
                "        },\n"
                "        {\n"
                "            \"type\": \"environment\",\n"
                "            \"radiance\": [1, 2, 3]\n"
                "        }\n"
                "    ],\n"
                "    \"render\": { \"spp\": 5 }\n"
                "}\n");
    static const char* const overrides[] = {
        "camera.position=[0.0,1.0,5.25]",
        "camera.exposure=1",
        "media[0].g=0.1",
        "media[1]={\"preset\":\"fog\",\"visibility\":9,\"bounds\":[[0,0,0],[1,1,1]]}",
        "lights[0].intensity=[3,2,1]",
        "lights[1]={\"type\":\"environment\",\"radiance\":[1,2,3]}",
        "render={\"spp\":5}",
    };
    expect_overrides(editor, overrides, COUNT(overrides));
    expect_kept(editor, "edited.json");
    apply(editor, "lights[0]", NULL);
    apply(editor, "camera.fov_y", NULL);
    apply(editor, "media", NULL);
    expect_text(editor, "{\n"
                        "    \"tyndall\": 1,\n"
                        "    \"camera\": { \"position\": [0.0, 1e0, 5.25], \"exposure\": 1 },\n"
                        "    \"lights\": [\n"
                        "        {\n"
                        "            \"type\": \"environment\",\n"
                        "            \"radiance\": [1, 2, 3]\n"
                        "        }\n"
                        "    ],\n"
                        "    \"render\": { \"spp\": 5 }\n"
                        "}\n");
    expect_kept(editor, "edited.json");
    ty_scene_editor_close(editor);
}

static void tabs_and_single_lines_stay(void** state) {
    (void)state;
    ty_scene_editor* editor = open_text("\xef\xbb\xbf{\r\n\t\"tyndall\" : 1,\r\n\t\"media\" : [" FOG "," FOG "]\r\n}");
    apply(editor, "media[0]", NULL);
    apply(editor, "camera", "{\"fov_y\": 30.0}");
    expect_text(editor, "\xef\xbb\xbf{\r\n\t\"tyndall\" : 1,\r\n\t\"media\" : [" FOG
                        "],\r\n\t\"camera\" : { \"fov_y\" : 30.0 }\r\n}");
    expect_kept(editor, "edited.json");
    ty_scene_editor_close(editor);
    editor = open_text("{\"tyndall\":1,\"camera\":{},\"media\":[],\"render\":{\"spp\":4}}");
    apply(editor, "camera.fov_y", "30");
    apply(editor, "media[0]", FOG);
    apply(editor, "render.spp", NULL);
    expect_text(editor, "{\"tyndall\":1,\"camera\":{\"fov_y\":30},\"media\":[{\"sigma_t\":1.5,\"albedo\":0.5,"
                        "\"bounds\":[[0,0,0],[1,1,1]]}],\"render\":{}}");
    expect_kept(editor, "edited.json");
    apply(editor, "media[0]", NULL);
    apply(editor, "camera", "{}");
    apply(editor, "render.spp", "4.0");
    expect_text(editor, "{\"tyndall\":1,\"camera\":{},\"media\":[],\"render\":{\"spp\":4}}");
    expect_overrides(editor, NULL, 0);
    ty_scene_editor_close(editor);
}

/* Elements put in, taken out and changed at every place of an array. */
static void arrays_change_everywhere(void** state) {
    (void)state;
    static const char* const values[] = {"1", "2", "3", "4", "5"};
    char text[512], list[256];
    for (unsigned before = 0; before < 32; ++before) {
        ty_scene_editor* editor = NULL;
        snprintf(text, sizeof text, "{ \"tyndall\": 1,\n  \"lights\": [");
        for (unsigned i = 0, n = 0; i < 5; ++i)
            if ((before >> i & 1) != 0)
                snprintf(text + strlen(text), 128, "%s{ \"type\": \"environment\", \"radiance\": %s }",
                         n++ > 0 ? ",\n    " : " ", values[i]);
        snprintf(text + strlen(text), 8, " ] }");
        editor = open_text(text);
        for (unsigned after = 0; after < 32; ++after) {
            snprintf(list, sizeof list, "[");
            for (unsigned i = 0, n = 0; i < 5; ++i)
                if ((after >> i & 1) != 0)
                    snprintf(list + strlen(list), 64, "%s{\"type\":\"environment\",\"radiance\":%s}",
                             n++ > 0 ? "," : "", values[i]);
            strcat(list, "]");
            apply(editor, "lights", list);
            expect_kept(editor, "edited.json");
        }
        ty_scene_editor_close(editor);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_cloud_is_edited),          cmocka_unit_test(a_room_is_edited),
        cmocka_unit_test(wrong_edits_change_nothing), cmocka_unit_test(wrong_scenes_do_not_open),
        cmocka_unit_test(text_keeps_its_form),        cmocka_unit_test(tabs_and_single_lines_stay),
        cmocka_unit_test(arrays_change_everywhere),
    };
    return cmocka_run_group_tests(tests, start, stop);
}
