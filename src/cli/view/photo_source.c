/* A photograph through tyndall screen as what the viewer shows; beside it the photograph itself. */
#include "cli/view/live_state.h"

#include "cli/screen/screen_output.h"

#include <string.h>

static ty_result apply(view_live* live, const ty_scene_change* changes, int32_t count, uint32_t* edited) {
    return view_photo_apply(live->photo, changes, count, edited);
}

/* Other variants take other times. */
static void take(view_live* live, uint32_t edited) {
    if ((edited & VIEW_PHOTO_FILTER) != 0) live->view_seconds = 0;
    live->view_power = view_photo_is_quadratic(live->photo) ? 4 : 2;
}

static bool set_method(view_live* live, const char* name) {
    return strcmp(name, live->method->name) == 0;
}

static ty_result render(view_live* live, int32_t divisor, ty_image** out, ty_method_run* run) {
    return view_photo_render(live->photo, divisor, view_report, live, out,
                             ty_method_stats(run, sizeof(ty_screen_stats)));
}

/* The photograph, once: its clients keep it. */
static bool show_photo(view_live* live) {
    if (live->photo_shown) return false;
    float* rgb = view_pixels(live, live->width, live->height);
    live->photo_shown = true;
    if (rgb == NULL) return false;
    view_photo_pixels(live->photo, rgb);
    view_show(live, VIEW_CHANNEL_PATH, rgb, live->width, live->height, 0, true);
    return true;
}

static bool step(view_live* live) {
    return (!live->failed && view_step_render(live, render)) || show_photo(live);
}

static const char* text(const view_live* live) {
    return view_photo_text_of(live->photo);
}

static void describe_view(const view_live* live, json_t* view) {
    (void)live; /* there is no camera to move */
    (void)view;
}

static void describe(const view_live* live, json_t* welcome) {
    json_t* parts = json_pack("{s:[{s:s, s:s}], s:o, s:o}", "methods", "name", live->method->name, "summary",
                              "the photograph through the medium", "schema",
                              json_deep_copy(view_photo_schema_of(live->photo)), "presets", view_presets());
    json_object_update(welcome, parts);
    json_decref(parts);
}

static ty_result save(view_live* live, char** json, char** command) {
    *json = view_photo_medium(live->photo);
    *command = view_photo_command(live->photo);
    return TY_OK;
}

static void close_photo(view_live* live) {
    view_photo_close(live->photo);
}

static const view_source photo_source = {.kind = "photograph",
                                         .reference = "photograph",
                                         .own_size = true,
                                         .apply = apply,
                                         .take = take,
                                         .set_method = set_method,
                                         .step = step,
                                         .text = text,
                                         .describe_view = describe_view,
                                         .describe = describe,
                                         .save = save,
                                         .close = close_photo};

int view_open_photo(view_live* live, const view_live_def* def) {
    live->source = &photo_source;
    live->method = &ty_method_screen;
    live->curve = screen_choose_curve(def->photo->options, def->path);
    live->compare = false;
    const int status = view_photo_open(def->session, def->photo, &live->photo);
    if (status != CLI_GO) return status;
    take(live, VIEW_PHOTO_FILTER);
    live->width = view_photo_width(live->photo);
    live->height = view_photo_height(live->photo);
    return CLI_GO;
}
