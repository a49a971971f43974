#define _GNU_SOURCE
#include "cli/view/photo.h"

#include "base/context.h"
#include "cli/screen/screen_input.h"
#include "cli/text/text.h"
#include "cli/view/photo_schema.h"
#include "io/json_edit.h"
#include "io/json_text.h"
#include "io/scenes/schema.h"

#include <stdlib.h>
#include <string.h>

enum { MESSAGE_SIZE = 1024, PATH_SIZE = 512, WORKSPACE_ALIGNMENT = 64 };

/* A document, and all that is made of it. */
typedef struct photo_state {
    json_t* root;
    char* text;                  /* of the document */
    char* texts[SCREEN_OPTIONS]; /* of the options, NULL where they are not given */
    screen_options options;      /* points to the texts */
    screen_input input;
    bool shares_input; /* with the state before */
    float around[3];
    ty_screen_def def;
} photo_state;

struct view_photo {
    cli_session* session;
    ty_context* context;
    const char *image_path, *distance_path, *medium_text; /* as given */
    json_t *schema, *medium;                              /* medium: that of the text */
    photo_state now;
    screen_input small; /* the input with its sides divided by `divisor`; 0: none. Its planes are in `pixels` */
    int32_t divisor;
    float* pixels;
    void* workspace;
    size_t workspace_size;
};

/* ---- states ---- */

/* Frees a state; an input that it shares stays. */
static void free_state(view_photo* photo, photo_state* state) {
    json_decref(state->root);
    ty_free_text(photo->context, state->text);
    for (int i = 0; i < SCREEN_OPTIONS; ++i) free(state->texts[i]);
    if (!state->shares_input) screen_close_input(&state->input);
    *state = (photo_state){.root = NULL};
}

static int fail_memory(void) {
    return cli_fail(CLI_FAILED, "not enough memory");
}

static int check_schema(const view_photo* photo, const json_t* root) {
    ty_schema_issue issue;
    char path[PATH_SIZE];
    if (ty_schema_check(photo->schema, root, &issue)) return CLI_GO;
    ty_json_path_text(&issue.path, path, sizeof path);
    return cli_fail(CLI_USAGE, "%s%s%s", path, path[0] != '\0' ? ": " : "", issue.text);
}

/* A medium that was not changed has the text that was given. */
static char* text_of(const view_photo* photo, const json_t* root, const cli_option* option) {
    if (strcmp(option->name, "medium") == 0 && ty_json_same(json_object_get(root, "medium"), photo->medium))
        return strdup(photo->medium_text);
    return view_photo_text(photo->context, root, option);
}

static int set_options(const view_photo* photo, photo_state* state) {
    cli_option table[SCREEN_OPTIONS];
    int status = CLI_GO;
    state->options = screen_default_options("view");
    screen_list_options(&state->options, table);
    for (int i = 0; i < SCREEN_OPTIONS && status == CLI_GO; ++i) {
        state->texts[i] = text_of(photo, state->root, &table[i]);
        if (state->texts[i] != NULL) status = cli_set_option("view", &table[i], state->texts[i]);
    }
    return status == CLI_GO ? screen_check_options(&state->options) : status;
}

static bool same_text(const char* a, const char* b) {
    return a == b || (a != NULL && b != NULL && strcmp(a, b) == 0);
}

/* Takes the input of the state before where the same would be read. */
static int take_input(const view_photo* photo, const photo_state* before, photo_state* state) {
    const screen_options *a = &before->options, *b = &state->options;
    if (before->root != NULL && same_text(a->channel, b->channel) && a->distance_scale == b->distance_scale &&
        a->distance_scale_given == b->distance_scale_given && a->fill == b->fill) {
        state->input = before->input;
        state->shares_input = true;
        return CLI_GO;
    }
    const int status = screen_open_input(photo->session, b, photo->image_path, photo->distance_path, &state->input);
    if (status == CLI_GO && before->root != NULL &&
        (state->input.width != before->input.width || state->input.height != before->input.height))
        return cli_fail(CLI_USAGE, "%s: the file has another size now; start anew", photo->image_path);
    return status == CLI_GO ? screen_prepare_distances(photo->session, b, &state->input) : status;
}

static int take_around(const view_photo* photo, const photo_state* before, photo_state* state) {
    if (before->root == NULL || !same_text(before->options.environment, state->options.environment))
        return screen_read_environment(photo->session, &state->options, state->around);
    memcpy(state->around, before->around, sizeof state->around);
    return CLI_GO;
}

static int finish_state(const view_photo* photo, photo_state* state) {
    ty_medium_def medium = ty_default_medium_def();
    ty_result result = ty_medium_parse(photo->context, state->options.medium, &medium);
    if (result == TY_OK) result = ty_medium_mean_cosine(photo->context, &medium, medium.g);
    if (result != TY_OK) return cli_fail_reading(photo->session, result);
    ty_text text = {.context = photo->context};
    ty_text_add_compact(&text, state->root);
    state->text = ty_text_finish(&text);
    if (state->text == NULL) return fail_memory();
    return screen_make_def(&state->options, &state->input, &medium, state->around, &state->def);
}

/* Makes a state of a document, which it takes over; what it has in common with the one before is not made again. */
static int make_state(view_photo* photo, json_t* root, const photo_state* before, photo_state* out) {
    *out = (photo_state){.root = root};
    int status = root != NULL ? check_schema(photo, root) : fail_memory();
    if (status == CLI_GO) status = set_options(photo, out);
    if (status == CLI_GO) status = take_input(photo, before, out);
    if (status == CLI_GO) status = take_around(photo, before, out);
    if (status == CLI_GO) status = finish_state(photo, out);
    if (status != CLI_GO) free_state(photo, out);
    return status;
}

/* ---- opening and changes ---- */

static int open_document(view_photo* photo, const view_photo_def* def) {
    json_t* root = NULL;
    photo->schema = view_photo_schema();
    if (photo->schema == NULL) return fail_memory();
    const int status = view_photo_document(photo->session, photo->schema, def->options, &root);
    if (status != CLI_GO) return status;
    photo->medium = json_deep_copy(json_object_get(root, "medium"));
    const photo_state nothing = {.root = NULL};
    return make_state(photo, root, &nothing, &photo->now);
}

int view_photo_open(cli_session* session, const view_photo_def* def, view_photo** out) {
    view_photo* photo = calloc(1, sizeof *photo);
    if (photo == NULL) return fail_memory();
    photo->session = session;
    photo->context = session->context;
    photo->image_path = def->image;
    photo->distance_path = def->distance;
    photo->medium_text = def->options->medium;
    const int status = open_document(photo, def);
    if (status == CLI_GO)
        *out = photo;
    else
        view_photo_close(photo);
    return status;
}

void view_photo_close(view_photo* photo) {
    if (photo == NULL) return;
    free_state(photo, &photo->now);
    json_decref(photo->schema);
    json_decref(photo->medium);
    free(photo->pixels);
    free(photo->workspace);
    free(photo);
}

static uint32_t edits(const json_t* before, const json_t* after) {
    static const char* const cheap[] = {"medium", "environment", "balance"};
    json_t *a = json_copy((json_t*)(uintptr_t)before), *b = json_copy((json_t*)(uintptr_t)after);
    uint32_t flags = 0;
    for (size_t i = 0; i < sizeof cheap / sizeof cheap[0]; ++i) {
        if (!ty_json_same(json_object_get(a, cheap[i]), json_object_get(b, cheap[i]))) flags |= VIEW_PHOTO_MEDIUM;
        json_object_del(a, cheap[i]);
        json_object_del(b, cheap[i]);
    }
    if (!ty_json_same(a, b)) flags |= VIEW_PHOTO_FILTER;
    json_decref(a);
    json_decref(b);
    return flags;
}

/* The state takes the place of the one before. */
static void exchange(view_photo* photo, photo_state* state) {
    if (state->shares_input)
        photo->now.shares_input = true; /* it is the new state's now */
    else
        photo->divisor = 0;
    state->shares_input = false;
    free_state(photo, &photo->now);
    photo->now = *state;
}

ty_result view_photo_apply(view_photo* photo, const ty_scene_change* changes, int32_t count, uint32_t* edited) {
    char message[MESSAGE_SIZE];
    photo_state state;
    json_t* root = json_deep_copy(photo->now.root);
    if (root == NULL) return TY_ERROR_MEMORY;
    for (int32_t i = 0; i < count; ++i) {
        const ty_result result = ty_change_document(photo->context, root, &changes[i]);
        if (result == TY_OK) continue;
        json_decref(root);
        return result;
    }
    const uint32_t flags = edits(photo->now.root, root);
    if (flags == 0) {
        json_decref(root);
        return TY_OK;
    }
    cli_keep_messages(message, sizeof message);
    const int status = make_state(photo, root, &photo->now, &state);
    cli_keep_messages(NULL, 0);
    if (status != CLI_GO) /* options are keys here */
        return ty_fail(photo->context, TY_ERROR_INPUT, "%s", message + 2 * (strncmp(message, "--", 2) == 0));
    exchange(photo, &state);
    *edited = flags;
    return TY_OK;
}

/* ---- what it says ---- */

const char* view_photo_text_of(const view_photo* photo) {
    return photo->now.text;
}

const json_t* view_photo_schema_of(const view_photo* photo) {
    return photo->schema;
}

char* view_photo_medium(const view_photo* photo) {
    return json_dumps(json_object_get(photo->now.root, "medium"), JSON_INDENT(2) | JSON_REAL_PRECISION(9));
}

char* view_photo_command(const view_photo* photo) {
    screen_options options = photo->now.options;
    cli_option table[SCREEN_OPTIONS];
    char *command = NULL, name[64];
    size_t size = 0;
    screen_list_options(&options, table);
    cli_append_word(&command, &size, "tyndall");
    cli_append_word(&command, &size, "screen");
    cli_append_word(&command, &size, photo->image_path);
    if (photo->distance_path != NULL) cli_append_word(&command, &size, photo->distance_path);
    for (int i = 0; i < SCREEN_OPTIONS; ++i) {
        if (photo->now.texts[i] == NULL) continue;
        snprintf(name, sizeof name, "--%s", table[i].name);
        cli_append_word(&command, &size, name);
        if (table[i].kind != CLI_FLAG) cli_append_word(&command, &size, photo->now.texts[i]);
    }
    cli_append_word(&command, &size, "-o");
    cli_append_word(&command, &size, "out.exr");
    return command;
}

/* ---- images ---- */

int32_t view_photo_width(const view_photo* photo) {
    return photo->now.input.width;
}

int32_t view_photo_height(const view_photo* photo) {
    return photo->now.input.height;
}

bool view_photo_is_quadratic(const view_photo* photo) {
    return photo->now.def.variant == TY_SCREEN_REFERENCE;
}

void view_photo_pixels(const view_photo* photo, float* rgb) {
    const screen_input* input = &photo->now.input;
    const size_t count = (size_t)input->width * (size_t)input->height;
    for (size_t i = 0; i < count; ++i)
        for (size_t c = 0; c < 3; ++c) rgb[3 * i + c] = input->color[c][i];
}

/* Means of colours over squares; of distances the central one, since means of near and far are neither. */
static void shrink(const screen_input* from, int32_t by, float* const color[3], screen_input* to) {
    const float weight = 1 / (float)(by * by);
    for (int32_t y = 0; y < to->height; ++y)
        for (int32_t x = 0; x < to->width; ++x) {
            const size_t at = (size_t)y * (size_t)to->width + (size_t)x;
            const int64_t corner = (int64_t)y * by * from->width + (int64_t)x * by;
            for (int c = 0; c < 3; ++c) {
                float sum = 0;
                for (int32_t i = 0; i < by; ++i)
                    for (int32_t k = 0; k < by; ++k) sum += from->color[c][corner + (int64_t)i * from->width + k];
                color[c][at] = weight * sum;
            }
            to->distance[at] = from->distance[corner + (int64_t)(by / 2) * from->width + by / 2];
        }
}

/* The input with its sides divided; NULL without memory. */
static const screen_input* input_of(view_photo* photo, int32_t divisor) {
    if (divisor == 1) return &photo->now.input;
    if (photo->divisor == divisor) return &photo->small;
    screen_input* small = &photo->small;
    *small = photo->now.input;
    small->width /= divisor;
    small->height /= divisor;
    const size_t count = (size_t)small->width * (size_t)small->height;
    free(photo->pixels);
    photo->pixels = malloc(4 * count * sizeof(float));
    photo->divisor = photo->pixels != NULL ? divisor : 0;
    if (photo->pixels == NULL) return NULL;
    float* const color[3] = {photo->pixels, photo->pixels + count, photo->pixels + 2 * count};
    for (int c = 0; c < 3; ++c) small->color[c] = color[c];
    small->distance = photo->pixels + 3 * count;
    shrink(&photo->now.input, divisor, color, small);
    return small;
}

static ty_screen_def def_of(const view_photo* photo, int32_t divisor) {
    ty_screen_def def = photo->now.def;
    for (int axis = 0; axis < 2; ++axis) {
        def.focal[axis] /= divisor;
        def.center[axis] /= divisor;
    }
    if (def.window > 0) def.window = def.window / divisor > 1 ? def.window / divisor : 1;
    return def;
}

/* Room for the call, kept from image to image; without memory the call makes its own, or says so. */
static void make_workspace(view_photo* photo, const ty_screen_def* def, const screen_input* input) {
    const size_t size = ty_screen_workspace(photo->context, def, input->width, input->height);
    if (size <= photo->workspace_size) return;
    const size_t rounded = (size + WORKSPACE_ALIGNMENT - 1) / WORKSPACE_ALIGNMENT * WORKSPACE_ALIGNMENT;
    free(photo->workspace);
    photo->workspace = aligned_alloc(WORKSPACE_ALIGNMENT, rounded);
    photo->workspace_size = photo->workspace != NULL ? rounded : 0;
}

ty_result view_photo_render(view_photo* photo, int32_t divisor, ty_progress_fn progress, void* user, ty_image** out,
                            ty_screen_stats* stats) {
    while (divisor > 1 && (photo->now.input.width < divisor || photo->now.input.height < divisor)) --divisor;
    const screen_input* input = input_of(photo, divisor);
    ty_screen_def def = def_of(photo, divisor);
    *out = NULL;
    if (input == NULL) return TY_ERROR_MEMORY;
    def.progress = progress;
    def.progress_user = user;
    ty_result result = ty_image_create_rgb(photo->context, input->width, input->height, out);
    if (result != TY_OK) return result;
    float* const planes[3] = {ty_image_plane(*out, 0), ty_image_plane(*out, 1), ty_image_plane(*out, 2)};
    const ty_screen_image image = screen_describe_image(input, planes);
    make_workspace(photo, &def, input);
    result = ty_screen_apply(photo->context, &def, &image, photo->workspace, photo->workspace_size, stats);
    if (result == TY_OK) return TY_OK;
    ty_image_destroy(*out);
    *out = NULL;
    return result;
}
