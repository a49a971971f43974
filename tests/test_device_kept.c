/* Scenes that stay in a device's memory between images, as `tyndall view` has them: what an edit did not change is not
 * copied again, and images are those of a device that keeps nothing. */
#define _POSIX_C_SOURCE 200809L
#include "checks.h"
#include "files.h"
#include "on_device.h"

#include "device/arrays.h"

#include <tyndall/fld.h>
#include <tyndall/io.h>
#include <tyndall/path.h>
#include <tyndall/scene_editor.h>

enum { WIDTH = 24, HEIGHT = 16, PIXELS = WIDTH * HEIGHT };

/* Bytes that change at each image: constants of the request and of each launch, the structures that hold pointers. */
enum { CONSTANTS = 8 << 10 };

typedef struct viewer {
    ty_context* context;
    ty_scene_editor* editor;
    ty_fld* light; /* solved once; NULL: images by path */
} viewer;

static ty_fld_def fld_def(void) {
    ty_fld_def def = ty_default_fld_def();
    def.width = WIDTH;
    def.height = HEIGHT;
    def.resolution = 12;
    return def;
}

static viewer open_viewer(const char* scene, bool solves, bool keeps) {
    viewer v = {.context = context_on("host", 2)};
    const ty_fld_def def = fld_def();
    if (keeps) assert_int_equal(ty_context_keep_on_device(v.context), TY_OK);
    if (ty_scene_editor_open(v.context, scene, NULL, 0, &v.editor) != TY_OK) fail_msg("%s", ty_take_error(v.context));
    if (solves) assert_int_equal(ty_fld_solve(ty_scene_editor_scene(v.editor), &def, &v.light, NULL), TY_OK);
    return v;
}

static void close_viewer(viewer* v) {
    ty_fld_destroy(v->light);
    ty_scene_editor_close(v->editor);
    ty_context_destroy(v->context);
}

/* One that keeps arrays, and one that does not. */
typedef struct pair {
    viewer keeps, forgets;
} pair;

static pair open_pair(const char* scene, bool solves) {
    return (pair){open_viewer(scene, solves, true), open_viewer(scene, solves, false)};
}

static void close_pair(pair* p) {
    close_viewer(&p->keeps);
    close_viewer(&p->forgets);
}

/* The image after an edit (NULL: none), and the bytes that it copied to the device. */
static ty_image* show(viewer* v, const char* path, const char* value, uint64_t* bytes) {
    const ty_scene_change change = {path, value};
    ty_device* device = NULL;
    ty_image* image = NULL;
    const ty_fld_def by_light = fld_def();
    ty_path_def by_path = ty_default_path_def();
    by_path.width = WIDTH;
    by_path.height = HEIGHT;
    by_path.spp = 1;
    ty_result result = path != NULL ? ty_scene_editor_apply(v->editor, &change, 1, NULL) : TY_OK;
    if (result == TY_OK) result = ty_context_device(v->context, &device);
    if (result != TY_OK) fail_msg("%s: %s", path, ty_take_error(v->context));
    *bytes = device->bytes_written;
    const ty_scene* scene = ty_scene_editor_scene(v->editor);
    result = v->light != NULL ? ty_fld_view(v->light, scene, &by_light, &image, NULL)
                              : ty_path_render(scene, &by_path, &image, NULL);
    if (result != TY_OK) fail_msg("%s", ty_take_error(v->context));
    *bytes = device->bytes_written - *bytes;
    return image;
}

/* Bytes that an edit copies to a device that keeps arrays; its image is that of the other. */
static uint64_t bytes_after(pair* p, const char* path, const char* value) {
    uint64_t bytes, all;
    ty_image *image = show(&p->keeps, path, value, &bytes), *anew = show(&p->forgets, path, value, &all);
    printf("%s, %s: %llu bytes of %llu\n", p->keeps.light != NULL ? "fld" : "path", path != NULL ? path : "at first",
           (unsigned long long)bytes, (unsigned long long)all);
    for (int32_t c = 0; c < ty_image_channel_count(image); ++c)
        assert_memory_equal(ty_image_plane_const(image, c), ty_image_plane_const(anew, c), PIXELS * sizeof(float));
    ty_image_destroy(image);
    ty_image_destroy(anew);
    return bytes;
}

/* A cloud of 1.8 MB, in blocks. Measured: 1 to 4 kB after an edit. */
static void edits_of_a_cloud_copy_what_changed(void** state) {
    (void)state;
    pair v = open_pair("builtin:cloud_sun", false);
    assert_true(bytes_after(&v, NULL, NULL) > 1500000);
    assert_true(bytes_after(&v, "camera.position", "[0.1, 0, 2.1]") <= CONSTANTS);
    assert_true(bytes_after(&v, "lights[0].irradiance", "2") <= CONSTANTS);
    assert_true(bytes_after(&v, "media[0].g", "0.4") <= CONSTANTS);
    assert_true(bytes_after(&v, "media[0].sigma_t", "21") <= CONSTANTS);
    close_pair(&v);
}

/* Its solved light stays, too. */
static void a_moved_camera_copies_no_light(void** state) {
    (void)state;
    pair v = open_pair("builtin:cloud_sun", true);
    const uint64_t first = bytes_after(&v, NULL, NULL);
    assert_true(first > 1500000);
    assert_true(bytes_after(&v, "camera.position", "[0.1, 0, 2.1]") <= CONSTANTS);
    assert_true(bytes_after(&v, "camera.position", "[0.2, 0, 2.1]") <= CONSTANTS);
    close_pair(&v);
}

/* Surfaces keep their hierarchy. The marched image takes that of the surfaces by path, three numbers a pixel. */
static void edits_between_surfaces_copy_what_changed(void** state) {
    (void)state;
    pair v = open_pair("builtin:cornell_fog", false);
    bytes_after(&v, NULL, NULL);
    assert_true(bytes_after(&v, "camera.position", "[0.1, -4.5, 0]") <= CONSTANTS);
    assert_true(bytes_after(&v, "lights[0].radiance", "11") <= CONSTANTS);
    assert_true(bytes_after(&v, "media[0].sigma_t", "0.6") <= CONSTANTS);
    assert_true(bytes_after(&v, "geometry[0].material.albedo", "0.5") <= CONSTANTS);
    close_pair(&v);
    v = open_pair("builtin:cornell_fog", true);
    bytes_after(&v, NULL, NULL);
    assert_true(bytes_after(&v, "camera.position", "[0.1, -4.5, 0]") <= 2 * CONSTANTS + 12 * PIXELS);
    close_pair(&v);
}

static ty_result show_twice(ty_context* context, void* user) {
    ty_device* device = NULL;
    ty_image* image = NULL;
    ty_path_def def = ty_default_path_def();
    def.width = def.height = 8;
    def.spp = 1;
    ty_result result = ty_context_device(context, &device);
    device->keep = 1;
    for (int i = 0; i < 2 && result == TY_OK; ++i) {
        result = ty_path_render(user, &def, &image, NULL);
        ty_image_destroy(image);
        image = NULL;
    }
    device->keep = 0;
    ty_device_free(&(ty_device_arrays){.device = device}); /* what is idle goes */
    return result;
}

/* Idle memory goes where more is asked for; without any left, a render fails and leaves nothing. */
static void memory_may_run_out(void** state) {
    (void)state;
    strict_memory memory = {.limit = 1 << 28, .until_refusal = -1};
    ty_scene* scene = strict_scene_on_host(&memory, "builtin:cube_g0");
    ty_context* context = ty_scene_context(scene);
    show_twice(context, scene); /* the list of pieces stays */
    assert_true(check_short_memory(context, &memory, show_twice, scene) > 10);
    ty_scene_destroy(scene);
    ty_context_destroy(context);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(edits_of_a_cloud_copy_what_changed),
        cmocka_unit_test(a_moved_camera_copies_no_light),
        cmocka_unit_test(edits_between_surfaces_copy_what_changed),
        cmocka_unit_test(memory_may_run_out),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
