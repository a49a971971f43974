/* Scenes that are edited: each is as if the edited document had been loaded; a wrong edit changes nothing. */
#define _GNU_SOURCE
#include "effort.h"
#include "level_maker.h"

#include "base/context.h"
#include "io/scenes/asset_cache.h"
#include "io/scenes/scene_editor.h"
#include "scene/scene.h"

#include <tyndall/tyndall.h>

#define COUNT(array) (int32_t)(sizeof(array) / sizeof(array)[0])

static ty_context* context;

static int start(void** state) {
    (void)state;
    ty_context_def def = ty_default_context_def();
    def.threads = 2;
    put_nrrd("gray.nrrd", 1, "0.25 0.75");
    put_nrrd("rgb.nrrd", 3, "0.1 0.2 0.3 0.4 0.5 0.6");
    put_nrrd("smoke_0003.nrrd", 1, "0 3");
    put_nrrd("smoke_0004.nrrd", 1, "0 4");
    put_tetrahedron("tetra.obj");
    put_level();
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
    /* Bits are compared after every edit where that is fast; sanitizers see the two methods in turn. */
    static unsigned compared;
    const bool both = !UNDER_ADDRESS_SANITIZER;
    ++compared;
    if (a.media > 0 && (both || compared % 2 == 0)) expect_same_images(edited, loaded, "fld");
    if (a.media > 0 && (both || compared % 2 == 1)) expect_same_images(edited, loaded, "pop");
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
        {"lights[1]", "{\"type\": \"environment\", \"sky\": {\"resolution\": 32, \"multiple_scattering\": \"none\"}}",
         TY_EDIT_LIGHT},
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

/* ---- edits of scenes that name files ---- */

static ty_scene_editor* open_text(const char* text) {
    put_text("edited.json", text);
    return open_scene("edited.json");
}

static void a_level_is_edited(void** state) {
    (void)state;
    static const edit edits[] = {
        {"media[0].g", "0.5", TY_EDIT_LIGHT},
        {"camera", "{\"resolution\": [16, 16]}", TY_EDIT_CAMERA},
        {"geometry[0].transform", "{\"translate\": [0, 0.5, 0]}", TY_EDIT_GEOMETRY | TY_EDIT_CAMERA},
        {"camera.file", "\"level.gltf\"", TY_EDIT_CAMERA},
        {"camera.name", "\"side\"", TY_EDIT_CAMERA},
        {"camera.position", "[0.5, 0.5, 6]", TY_EDIT_CAMERA},
        {"lights[0]", "{\"type\": \"point\", \"position\": [1, 1, 1], \"intensity\": 2}", TY_EDIT_LIGHT},
        {"lights[1]",
         "{\"type\": \"area\", \"origin\": [2, 0, 0], \"u\": [0, 1, 0], \"v\": [0, 0, 1], \"radiance\": 0}",
         TY_EDIT_LIGHT | TY_EDIT_GEOMETRY},
        {"lights[1].radiance", "[1, 2, 3]", TY_EDIT_LIGHT | TY_EDIT_GEOMETRY},
        {"media[0].sigma_t", "0.25", TY_EDIT_LIGHT},
        {"lights[0]", NULL, TY_EDIT_LIGHT},
        {"lights[0].origin[0]", "3", TY_EDIT_LIGHT | TY_EDIT_GEOMETRY},
        {"geometry[0].emission_scale", "2", TY_EDIT_GEOMETRY},
        {"geometry[1]", "{\"file\": \"tetra.obj\", \"transform\": {\"translate\": [0, 2, 0]}}", TY_EDIT_GEOMETRY},
        {"geometry[0].lights", "false", TY_EDIT_GEOMETRY},
        {"lights", NULL, TY_EDIT_LIGHT | TY_EDIT_GEOMETRY},
        {"meters_per_unit", "0.5", TY_EDIT_CAMERA | TY_EDIT_LIGHT | TY_EDIT_GEOMETRY},
        {"geometry[0]", NULL, TY_EDIT_GEOMETRY | TY_EDIT_CAMERA},
        {"media[0].bounds", "{\"file\": \"tetra.obj\", \"transform\": {\"scale\": 3}}", TY_EDIT_LIGHT},
        {"media[0].g", "0.6", TY_EDIT_LIGHT},
    };
    ty_scene_editor* editor = open_text("{\"tyndall\": 1, \"geometry\": [{\"file\": \"level.gltf\"}], \"media\": ["
                                        "{\"sigma_t\": 1, \"albedo\": 0.9, \"bounds\": [[-1, -1, -1], [3, 3, 3]]}]}");
    expect_as_loaded(editor, "");
    expect_edits(editor, "", edits, COUNT(edits));
    ty_scene_editor_close(editor);
}

static void an_environment_is_edited(void** state) {
    (void)state;
    static const edit edits[] = {
        {"lights[0].scale", "2", TY_EDIT_LIGHT},
        {"lights[0].rotation", "45", TY_EDIT_LIGHT},
        {"lights[1].scale", "0.1", TY_EDIT_LIGHT},
        {"lights[1].sky.solar", "[1, 2, 3]", TY_EDIT_LIGHT},
        {"lights[1].sky.sun", "false", TY_EDIT_LIGHT},
        {"lights[0]", NULL, TY_EDIT_LIGHT},
        {"lights[0].sky.air", "[[-500, -1, -500], [500, 900, 500]]", TY_EDIT_LIGHT},
        {"lights[0].sky.haze", "9", TY_EDIT_LIGHT},
        {"lights[0].sky.air", NULL, TY_EDIT_LIGHT},
    };
    ty_image* image = NULL;
    expect_ok(ty_image_create_rgb(context, 300, 150, &image));
    for (int c = 0; c < 3; ++c)
        for (int i = 0; i < 300 * 150; ++i) ty_image_plane(image, c)[i] = (float)(i % (7 + c));
    expect_ok(ty_image_write_exr(context, image, "map.exr"));
    ty_image_destroy(image);
    ty_scene_editor* editor = open_text("{\"tyndall\": 1, \"media\": [{\"sigma_t\": 1, \"albedo\": 0.9, \"bounds\": "
                                        "[[-1, -1, -1], [1, 1, 1]]}], \"lights\": [{\"type\": \"environment\", "
                                        "\"file\": \"map.exr\"}, {\"type\": \"environment\", \"sky\": {\"resolution\": "
                                        "32, \"multiple_scattering\": \"none\"}}]}");
    expect_edits(editor, "", edits, COUNT(edits));
    ty_scene_editor_close(editor);
}

static void frames_are_loaded_as_they_are_named(void** state) {
    (void)state;
    static const edit edits[] = {
        {"frame", "4", TY_EDIT_LIGHT},
        {"frame", "3", TY_EDIT_LIGHT},
        {"media[0].transform", "{\"scale\": 2}", TY_EDIT_LIGHT},
        {"media[0].density", "{\"file\": \"gray.nrrd\"}", TY_EDIT_LIGHT},
        {"media[0].albedo", "{\"file\": \"gray.nrrd\"}", TY_EDIT_LIGHT},
        {"media[0].albedo", "{\"file\": \"rgb.nrrd\"}", TY_EDIT_LIGHT},
    };
    ty_scene_editor* editor = open_text("{\"tyndall\": 1, \"frame\": 3, \"media\": [{\"sigma_t\": 1, \"albedo\": 0.5, "
                                        "\"density\": {\"file\": \"smoke_####.nrrd\"}}], \"lights\": [{\"type\": "
                                        "\"point\", \"position\": [0, 3, 0], \"intensity\": 5}]}");
    expect_edits(editor, "", edits, COUNT(edits));
    const ty_scene_change missing = {"media[0].density.file", "\"smoke_####.nrrd\""},
                          frames[] = {missing, {"frame", "77"}};
    const uint64_t hash = ty_scene_hash(ty_scene_editor_scene(editor));
    assert_int_equal(ty_scene_editor_apply(editor, frames, 2, NULL), TY_ERROR_FILE);
    assert_non_null(strstr(ty_take_error(context), "media[0].density.file: "));
    assert_int_equal(ty_scene_hash(ty_scene_editor_scene(editor)), hash);
    put_nrrd("rgb.nrrd", 3, "0.15 0.25 0.35 0.45 0.55 0.65"); /* is read again */
    assert_int_equal(apply(editor, "media[0].g", "0.1"), TY_EDIT_LIGHT);
    expect_as_loaded(editor, "");
    ty_scene_editor_close(editor);
}

/* Many volumes, most of which no scene holds any more: the cache stays within its limits. */
static void old_frames_are_dropped(void** state) {
    (void)state;
    ty_asset_cache cache = {.context = context, .reading = 1};
    for (int32_t i = 0; i < TY_ASSETS_SPARE_COUNT + 20; ++i) {
        char path[64];
        snprintf(path, sizeof path, "many_%04d.nrrd", i);
        put_nrrd(path, 1, "0 1");
        ty_asset volume = {.kind = TY_ASSET_GRID, .volume = ty_default_volume_def()};
        expect_ok(ty_assets_file(&cache, path, &volume.file));
        expect_ok(ty_volume_read(context, path, &volume.volume, &volume.grid));
        ty_grid* used = i < 3 ? ty_grid_retain(volume.grid) : NULL;
        expect_ok(ty_assets_keep(&cache, &volume));
        ty_assets_trim(&cache);
        ++cache.reading;
        if (used != NULL) {
            assert_ptr_equal(ty_assets_find(&cache, &volume)->grid, used);
            ty_grid_release(used);
        }
        remove(path);
    }
    assert_int_equal(cache.asset_count, TY_ASSETS_SPARE_COUNT);
    assert_int_equal(cache.file_count, TY_ASSETS_SPARE_COUNT);
    ty_assets_release(&cache);
}

/* Large scenes with data that the project does not ship. */
static void edit_large(const char* data, const char* path, const edit* edits, int32_t count) {
    char file[1024];
    data_path(data, file);
    ty_scene_editor* editor = open_scene(path);
    for (int32_t i = 0; i < count; ++i) assert_int_equal(apply(editor, edits[i].path, edits[i].value), edits[i].flags);
    expect_as_loaded(editor, TYNDALL_SOURCE_DIR "/scenes");
    ty_scene_editor_close(editor);
}

static void a_cloud_from_a_file_is_edited(void** state) {
    (void)state;
    static const edit edits[] = {
        {"media[0].g", "0.7", TY_EDIT_LIGHT},
        {"lights[0].sky.sun_direction", "[0.1, -1, 0.2]", TY_EDIT_LIGHT},
        {"lights[0].scale", "1.5", TY_EDIT_LIGHT},
        {"camera.fov_y", "30", TY_EDIT_CAMERA},
    };
    edit_large("volumes/wdas_cloud_sixteenth.vdb", TYNDALL_SOURCE_DIR "/scenes/disney_cloud_sun.json", edits,
               COUNT(edits));
}

static void an_atrium_from_a_file_is_edited(void** state) {
    skip_under_sanitizers();
    (void)state;
    static const edit edits[] = {
        {"media[0].g", "0.7", TY_EDIT_LIGHT},
        {"lights[1]",
         "{\"type\": \"area\", \"origin\": [0, 5, 0], \"u\": [1, 0, 0], \"v\": [0, 0, 1], \"radiance\": 9}",
         TY_EDIT_LIGHT | TY_EDIT_GEOMETRY},
        {"lights[1].radiance", "20", TY_EDIT_LIGHT | TY_EDIT_GEOMETRY},
        {"lights[0].sky.haze", "2", TY_EDIT_LIGHT},
        {"camera.exposure", "0", TY_EDIT_CAMERA},
    };
    edit_large("scenes/sponza_atrium.glb", TYNDALL_SOURCE_DIR "/scenes/sponza_fog.json", edits, COUNT(edits));
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

/* An edit for which memory runs out, at every allocation in turn, changes nothing. */
static void edits_without_memory_change_nothing(void** state) {
    (void)state;
    static const ty_scene_change changes[] = {
        {"media[0].sigma_t", "0.9"},
        {"media[1]", "{\"preset\": \"fog\", \"visibility\": 9, \"bounds\": [[0, 0, 0], [1, 1, 1]]}"},
        {"lights[0].origin[0]", "-0.2"},
        {"lights[1]", "{\"type\": \"environment\", \"sky\": {\"resolution\": 16, \"multiple_scattering\": \"none\"}}"},
        {"camera.fov_y", "50"},
        {"render.fld.iterations", "3"},
    };
    strict_memory memory = {.limit = (size_t)1 << 30, .until_refusal = -1};
    ty_context* strict = strict_context(&memory);
    const size_t before = memory.used;
    ty_scene_editor* editor = NULL;
    assert_int_equal(ty_scene_editor_open(strict, "builtin:cornell_fog", NULL, 0, &editor), TY_OK);
    const uint64_t hash = ty_scene_hash(ty_scene_editor_scene(editor));
    ty_result result = TY_ERROR_MEMORY;
    int64_t refused = 0;
    for (; result != TY_OK; ++refused) {
        assert_int_equal(ty_scene_hash(ty_scene_editor_scene(editor)), hash);
        assert_non_null(strstr(ty_scene_editor_text(editor), "\"sigma_t\":0.5"));
        assert_int_equal(ty_scene_get_info(ty_scene_editor_scene(editor)).media, 1);
        memory.until_refusal = refused;
        result = ty_scene_editor_apply(editor, changes, COUNT(changes), NULL);
        memory.until_refusal = -1;
        if (result != TY_OK) assert_string_not_equal(ty_take_error(strict), "");
        if (result != TY_OK) assert_int_equal(result, TY_ERROR_MEMORY);
        assert_true(refused < 1000);
    }
    assert_true(refused > 10);
    const char* text = ty_scene_editor_text(editor);
    ty_scene* loaded = NULL;
    expect_ok(ty_scene_parse(context, text, strlen(text), "loaded", "", NULL, 0, &loaded));
    assert_int_equal(ty_scene_hash(ty_scene_editor_scene(editor)), ty_scene_hash(loaded));
    expect_same_images(ty_scene_editor_scene(editor), loaded, "path");
    ty_scene_destroy(loaded);
    ty_scene_editor_close(editor);
    assert_int_equal(memory.used, before);
    ty_context_destroy(strict);
}

/* ---- saved text, and changes as overrides ---- */

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
    const unsigned step = in_full() ? 1 : UNDER_ADDRESS_SANITIZER ? 15 : 5;
    for (unsigned before = 0; before < 32; before += step) {
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

/* ---- content in memory ---- */

static ty_grid* two_voxels(float first, float second) {
    ty_grid_def def = ty_default_grid_def();
    const float values[] = {first, second};
    ty_grid* grid = NULL;
    def.size[0] = 2;
    def.size[1] = def.size[2] = 1;
    def.values = values;
    def.placed = true;
    expect_ok(ty_grid_create(context, &def, &grid));
    return grid;
}

static void set_volume(ty_scene_editor* editor, const char* name, float first, float second) {
    ty_grid* grid = two_voxels(first, second);
    expect_ok(ty_scene_editor_set_volume(editor, name, &grid, 1));
    ty_grid_release(grid);
}

/* The mean of R. */
static double mean_of(const ty_scene_editor* editor, const char* method) {
    ty_image* image = NULL;
    expect_ok(render(ty_scene_editor_scene(editor), method, &image));
    const float* plane = ty_image_plane_const(image, 0);
    double sum = 0;
    for (int i = 0; i < 24 * 16; ++i) sum += (double)plane[i];
    ty_image_destroy(image);
    return sum / (24 * 16);
}

static void refuse_one(ty_scene_editor* editor, const char* path, const char* value, const char* message) {
    const ty_scene_change change = {path, value};
    assert_int_equal(ty_scene_editor_apply(editor, &change, 1, NULL), TY_ERROR_INPUT);
    const char* text = ty_take_error(context);
    if (strstr(text, message) == NULL) fail_msg("\"%s\" lacks \"%s\"", text, message);
}

static ty_scene_editor* open_in_memory(const char* text) {
    ty_scene_editor* editor = NULL;
    expect_ok(ty_scene_editor_open_text(context, text, strlen(text), "scene", NULL, NULL, 0, &editor));
    return editor;
}

/* A volume in memory is the same as its file. */
static void volumes_are_in_memory(void** state) {
    (void)state;
    static const char medium[] = "[{\"density\":{\"file\":\"%s\"},\"sigma_t\":2,\"albedo\":0.5}]";
    static const char lights[] = "[{\"type\":\"environment\",\"radiance\":1}]";
    char text[256];
    ty_scene_editor* file = open_text("{ \"tyndall\": 1 }");
    apply(file, "lights", lights);
    snprintf(text, sizeof text, medium, "gray.nrrd");
    apply(file, "media", text);
    ty_scene_editor* editor = open_in_memory("{\"tyndall\":1}");
    apply(editor, "lights", lights);
    snprintf(text, sizeof text, medium, "memory:gray");
    refuse_one(editor, "media", text, "media[0].density.file: \"memory:gray\": the program has given nothing");
    set_volume(editor, "gray", 0.25f, 0.75f);
    assert_int_equal(apply(editor, "media", text), TY_EDIT_LIGHT);
    assert_true(mean_of(editor, "path") == mean_of(file, "path"));
    assert_true(mean_of(editor, "fld") == mean_of(file, "fld"));

    /* other content under the same name shows after the next change */
    const double before = mean_of(editor, "path");
    const uint64_t hash = ty_scene_hash(ty_scene_editor_scene(editor));
    set_volume(editor, "gray", 3, 3);
    assert_true(mean_of(editor, "path") == before);
    uint32_t edited = 0;
    expect_ok(ty_scene_editor_apply(editor, NULL, 0, &edited));
    assert_int_equal(edited, TY_EDIT_LIGHT);
    assert_true(mean_of(editor, "path") != before);
    assert_true(ty_scene_hash(ty_scene_editor_scene(editor)) != hash);
    expect_ok(ty_scene_editor_apply(editor, NULL, 0, &edited));
    assert_int_equal(edited, TY_EDIT_NOTHING);

    /* what was forgotten stays in the scene until it is made anew */
    ty_scene_editor_drop(editor, "gray");
    assert_int_equal(apply(editor, "camera", "{\"fov_y\":30}"), TY_EDIT_CAMERA);
    refuse_one(editor, "media[0].albedo", "0.25", "the program has given nothing");
    ty_scene_editor_close(editor);
    ty_scene_editor_close(file);
}

/* Three grids are red, green and blue of an albedo; one of another kind or name is refused. */
static void colors_meshes_and_maps_are_in_memory(void** state) {
    (void)state;
    ty_scene_editor* editor = open_in_memory("{\"tyndall\":1}");
    ty_grid* grids[3] = {two_voxels(1, 1), two_voxels(0.5f, 0.5f), two_voxels(0, 0)};
    expect_ok(ty_scene_editor_set_volume(editor, "albedo", grids, 3));
    assert_int_equal(ty_scene_editor_set_volume(editor, "two", grids, 2), TY_ERROR_ARGUMENT);
    assert_int_equal(ty_scene_editor_set_volume(editor, "a name", grids, 1), TY_ERROR_ARGUMENT);
    assert_int_equal(ty_scene_editor_set_volume(editor, "", grids, 1), TY_ERROR_ARGUMENT);
    ty_take_error(context);
    for (int c = 0; c < 3; ++c) ty_grid_release(grids[c]);
    set_volume(editor, "gray", 1, 1);
    apply(editor, "media",
          "[{\"density\":{\"file\":\"memory:gray\"},\"sigma_t\":2,\"albedo\":{\"file\":\"memory:albedo\"}}]");
    ty_medium_def medium;
    expect_ok(ty_scene_get_medium(ty_scene_editor_scene(editor), 0, &medium));
    assert_float_equal(ty_grid_get_info(medium.albedo_grid[1]).max, 0.5, 0);
    refuse_one(editor, "media[0].density.file", "\"memory:albedo\"", "has 3 values per voxel");
    refuse_one(editor, "media[0].density.grid", "\"density\"", "others hold one grid");

    static const float positions[] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1};
    static const uint32_t indices[] = {0, 2, 1, 0, 3, 2, 0, 1, 3, 1, 2, 3};
    ty_mesh_def mesh = ty_default_mesh_def();
    mesh.vertex_count = mesh.triangle_count = 4;
    mesh.positions = positions;
    mesh.indices = indices;
    expect_ok(ty_scene_editor_set_mesh(editor, "tetra", &mesh));
    assert_int_equal(apply(editor, "geometry", "[{\"file\":\"memory:tetra\",\"transform\":{\"scale\":2}}]"),
                     TY_EDIT_GEOMETRY);
    ty_mesh_def placed;
    expect_ok(ty_scene_get_mesh(ty_scene_editor_scene(editor), 0, &placed));
    assert_float_equal(placed.positions[3], 2, 0);
    apply(editor, "media", "[{\"bounds\":{\"file\":\"memory:tetra\"},\"sigma_s\":1}]");
    refuse_one(editor, "media[0].bounds.file", "\"memory:gray\"", "memory:gray is a volume, not a mesh");
    mesh.triangle_count = 0;
    assert_int_equal(ty_scene_editor_set_mesh(editor, "none", &mesh), TY_ERROR_ARGUMENT);
    ty_take_error(context);

    ty_image* image = NULL;
    expect_ok(ty_image_create_rgb(context, 8, 4, &image));
    for (int c = 0; c < 3; ++c)
        for (int i = 0; i < 32; ++i) ty_image_plane(image, c)[i] = 2;
    expect_ok(ty_scene_editor_set_image(editor, "sky", image));
    ty_image_destroy(image);
    apply(editor, "lights", "[{\"type\":\"environment\",\"file\":\"memory:sky\"}]");
    float radiance[3];
    ty_scene_environment(ty_scene_editor_scene(editor), radiance);
    assert_float_equal(radiance[1], 2, 1e-4);
    refuse_one(editor, "lights[0].file", "\"memory:tetra\"", "is a mesh, not an image");
    ty_scene_editor_close(editor);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_cloud_is_edited),
        cmocka_unit_test(a_room_is_edited),
        cmocka_unit_test(a_level_is_edited),
        cmocka_unit_test(an_environment_is_edited),
        cmocka_unit_test(frames_are_loaded_as_they_are_named),
        cmocka_unit_test(old_frames_are_dropped),
        cmocka_unit_test(a_cloud_from_a_file_is_edited),
        cmocka_unit_test(an_atrium_from_a_file_is_edited),
        cmocka_unit_test(wrong_edits_change_nothing),
        cmocka_unit_test(wrong_scenes_do_not_open),
        cmocka_unit_test(edits_without_memory_change_nothing),
        cmocka_unit_test(text_keeps_its_form),
        cmocka_unit_test(tabs_and_single_lines_stay),
        cmocka_unit_test(arrays_change_everywhere),
        cmocka_unit_test(volumes_are_in_memory),
        cmocka_unit_test(colors_meshes_and_maps_are_in_memory),
    };
    return cmocka_run_group_tests(tests, start, stop);
}
