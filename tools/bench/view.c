/* tyndall bench view: latency and frame rate of `tyndall view`, as a headless client sees them. */
#define _GNU_SOURCE
#include "bench/view_client.h"
#include "scenes/scenes.h"

#include <jansson.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

enum { CHANGES = 9, CHANGES_QUICK = 3, MOTION_HERTZ = 60, ARRIVALS_MAX = 4096 };
static const double motion_seconds = 3, timeout = 60;

enum { METHODS = 4 };

/* A scene, and the methods that take it. */
typedef struct view_case {
    const char *title, *scene; /* scene: builtin, or of scenes/tools with third-party data */
    const char* file;          /* of that data, as density of media[0]; NULL: none */
    const char* methods[METHODS];
} view_case;

/* --scenes names others. */
static const view_case cases[] = {
    {"cloud_sun", "builtin:cloud_sun", NULL, {"fld", "pop", "dom", "lpv"}},
    {"disney_cloud", "dom_disney_cloud", DISNEY_CLOUD_FILE, {"fld", "pop", "dom"}},
    {"plume", "auto_plume", PLUME_FILE, {"fld", "pop", "dom"}},
    {"atrium", "builtin:atrium", NULL, {"fld", "pop", "dom", "lpv"}},
    {"fog_cornell", "builtin:fog_cornell", NULL, {"fld", "pop", "dom", "lpv"}},
    {"screen_room", "builtin:screen_room", NULL, {"screen"}},
};
static const char* const volume_methods[METHODS] = {"fld", "pop", "dom", "lpv"};

typedef struct measured {
    double latency, latency_max; /* ms from a change of a medium to its first image; median and largest */
    double camera_latency;       /* ms, of the camera; median */
    double final_seconds;        /* from a change of a medium to its final image, of 16 spp of surfaces; median */
    double rate;                 /* images per second while the camera, or a photograph's medium, moves */
    double coarse;               /* width of those images over the full width, median */
    double solve, view;          /* ms of the server, at rest */
} measured;

/* ---- changes ---- */

/* Sends a text and waits for the image that answers it; ms. */
static bool time_change(view_client* client, const char* text, bool final, double* ms) {
    view_arrival arrival;
    const uint32_t frames = view_client_frames(client), revision = view_client_revision(client) + 1;
    const double begun = cli_wall_seconds();
    if (!view_client_send(client, text) || !view_client_wait(client, frames, revision, final, timeout, &arrival))
        return false;
    *ms = 1e3 * (arrival.seconds - begun);
    return true;
}

/* A change of the medium: by up to 7 % of `value`. */
typedef struct medium_value {
    const char* path;
    double value;
} medium_value;

static const medium_value first_scale = {"media[0].scale", 1};
static const medium_value photo_visibility = {"medium.visibility", 5};

static void medium_change(const medium_value* medium, int index, bool moving, char* out, size_t size) {
    snprintf(out, size, "{\"type\":\"set\",\"id\":%d,\"moving\":%s,\"changes\":[{\"path\":\"%s\",\"value\":%.3f}]}",
             index, moving ? "true" : "false", medium->path, medium->value * (1 + 0.01 * (1 + index % 7)));
}

static bool time_media(view_client* client, const medium_value* medium, int count, measured* out) {
    double ms[CHANGES], finals[CHANGES];
    char text[256];
    for (int i = 0; i < count; ++i) {
        medium_change(medium, i, false, text, sizeof text);
        const double begun = cli_wall_seconds();
        view_arrival arrival;
        if (!time_change(client, text, false, &ms[i])) return false;
        if (!view_client_wait(client, 0, view_client_revision(client), true, timeout, &arrival)) return false;
        finals[i] = arrival.seconds - begun;
        out->latency_max = fmax(out->latency_max, ms[i]);
    }
    out->latency = bench_median(ms, count);
    out->final_seconds = bench_median(finals, count);
    out->solve = view_client_status(client, "times", "solve");
    out->view = view_client_status(client, "times", "view");
    return true;
}

/* ---- the camera ---- */

typedef struct orbit {
    double target[3], offset[3];
    int up; /* axis */
} orbit;

static void read_vector(const json_t* camera, const char* key, const double otherwise[3], double out[3]) {
    const json_t* value = json_object_get(camera, key);
    for (size_t a = 0; a < 3; ++a)
        out[a] = json_is_array(value) ? json_number_value(json_array_get(value, a)) : otherwise[a];
}

static orbit read_orbit(const view_client* client) {
    static const double origin[3] = {0, 0, 0}, position[2][3] = {{0, 0, 5}, {0, -5, 0}};
    const json_t* document = view_client_document(client);
    const json_t* camera = json_object_get(document, "camera");
    const char* up = json_string_value(json_object_get(document, "up_axis"));
    orbit out = {.up = up != NULL && up[0] == 'z' ? 2 : 1};
    double eye[3];
    read_vector(camera, "target", origin, out.target);
    read_vector(camera, "position", position[out.up - 1], eye);
    for (int a = 0; a < 3; ++a) out.offset[a] = eye[a] - out.target[a];
    return out;
}

static void camera_change(const orbit* at, double degrees, bool moving, char* out, size_t size) {
    const double angle = degrees * acos(-1) / 180, c = cos(angle), s = sin(angle);
    const int i = (at->up + 1) % 3, j = (at->up + 2) % 3;
    double eye[3];
    for (int a = 0; a < 3; ++a) eye[a] = at->target[a] + at->offset[a];
    eye[i] = at->target[i] + c * at->offset[i] - s * at->offset[j];
    eye[j] = at->target[j] + s * at->offset[i] + c * at->offset[j];
    snprintf(out, size, "{\"type\":\"camera\",\"moving\":%s,\"position\":[%.9g,%.9g,%.9g]}", moving ? "true" : "false",
             eye[0], eye[1], eye[2]);
}

static void sleep_seconds(double seconds) {
    const struct timespec time = {.tv_nsec = (long)(1e9 * seconds)};
    nanosleep(&time, NULL);
}

/* The i-th of many changes, of the camera or of a medium; `moving` false: the last one. */
typedef void (*change_fn)(const void* user, int index, bool moving, char* out, size_t size);

static void turn_camera(const void* user, int index, bool moving, char* out, size_t size) {
    camera_change(user, moving ? 0.5 * (index + 1) : 0, moving, out, size);
}

static void change_medium(const void* user, int index, bool moving, char* out, size_t size) {
    medium_change(user, index, moving, out, size);
}

/* Sends MOTION_HERTZ changes a second, and counts the images that arrive. */
static bool time_motion(view_client* client, change_fn change, const void* user, double seconds, measured* out) {
    static double widths[ARRIVALS_MAX];
    char text[256];
    const uint32_t first = view_client_frames(client);
    const double begun = cli_wall_seconds();
    view_arrival arrival;
    uint32_t seen = first;
    int count = 0;
    for (int i = 0; cli_wall_seconds() - begun < seconds; ++i) {
        change(user, i, true, text, sizeof text);
        if (!view_client_send(client, text)) return false;
        for (; seen < view_client_frames(client) && count < ARRIVALS_MAX; ++seen)
            if (view_client_wait(client, seen, 0, false, 0, &arrival))
                widths[count++] = (double)arrival.width / arrival.full_width;
        sleep_seconds(1.0 / MOTION_HERTZ);
    }
    out->rate = (view_client_frames(client) - first) / (cli_wall_seconds() - begun);
    out->coarse = count > 0 ? bench_median(widths, count) : 0;
    change(user, 0, false, text, sizeof text);
    return view_client_send(client, text);
}

static bool time_camera(view_client* client, const orbit* at, int count, measured* out) {
    double ms[CHANGES];
    char text[256];
    for (int i = 0; i < count; ++i) {
        camera_change(at, 3 * (i + 1), false, text, sizeof text);
        if (!time_change(client, text, false, &ms[i])) return false;
        sleep_seconds(0.3);
    }
    out->camera_latency = bench_median(ms, count);
    return true;
}

/* ---- scenes ---- */

static bool measure(const bench_session* bench, view_client* client, measured* out) {
    const int count = bench->options->quick ? CHANGES_QUICK : CHANGES;
    const orbit at = read_orbit(client);
    view_arrival first;
    *out = (measured){.latency = 0};
    return view_client_wait(client, 0, 0, true, timeout, &first) && time_media(client, &first_scale, count, out) &&
           time_camera(client, &at, count, out) &&
           time_motion(client, turn_camera, &at, bench->options->quick ? 1 : motion_seconds, out);
}

/* ---- a photograph ---- */

/* A frame of a depth camera, 640 x 480, and how it is read (the figure screen-photo tells more). */
#define PHOTO_FILE "rgbd/tum_fr1_color.png"
#define DISTANCE_FILE "rgbd/tum_fr1_depth.png"

static const char* const photo_name = "photograph"; /* also in --scenes */

static bool measure_photo(const bench_session* bench, view_client* client, measured* out) {
    const int count = bench->options->quick ? CHANGES_QUICK : CHANGES;
    view_arrival first;
    *out = (measured){.latency = 0};
    return view_client_wait(client, 0, 0, true, timeout, &first) && time_media(client, &photo_visibility, count, out) &&
           time_motion(client, change_medium, &photo_visibility, bench->options->quick ? 1 : motion_seconds, out);
}

static int run_photo(const bench_session* bench) {
    char photo[BENCH_PATH_SIZE], distance[BENCH_PATH_SIZE], threads[16];
    snprintf(photo, sizeof photo, "%s/%s", bench->options->data, PHOTO_FILE);
    snprintf(distance, sizeof distance, "%s/%s", bench->options->data, DISTANCE_FILE);
    snprintf(threads, sizeof threads, "%d", (int)ty_context_threads(bench->session->context));
    const char* const arguments[] = {photo,      distance,      "--medium",  "fog:5",   "--distance-scale",
                                     "0.0002",   "--depth-is",  "planar",    "--focal", "517.3,516.5",
                                     "--center", "318.6,255.3", "--sky",     "fill",    "--environment",
                                     "0.4",      "--balance",   "--threads", threads,   NULL};
    view_client* client = view_client_open(arguments);
    if (client == NULL) return CLI_FAILED;
    measured m;
    const bool done = measure_photo(bench, client, &m);
    json_open_object(bench->json, "screen");
    if (done)
        bench_numbers(bench->json, {"latency_ms", m.latency}, {"latency_max_ms", m.latency_max},
                      {"final_seconds", m.final_seconds}, {"images_per_second", m.rate},
                      {"width_while_moving", m.coarse}, {"view_ms", m.view});
    else
        json_text(bench->json, "refused", view_client_complaint(client));
    json_close_object(bench->json);
    view_client_close(client);
    return CLI_DONE;
}

static int bench_photo(const bench_session* bench) {
    int status = CLI_DONE;
    const char* data = bench->options->data;
    json_open_object(bench->json, photo_name);
    if (tools_has_data(data, PHOTO_FILE) && tools_has_data(data, DISTANCE_FILE))
        status = run_photo(bench);
    else
        json_text(bench->json, "skipped", PHOTO_FILE " and " DISTANCE_FILE " are not in the folder of --data");
    json_close_object(bench->json);
    return status;
}

/* complaint: the viewer's; "": it sent nothing in time. */
static void tell_failure(const bench_session* bench, const char* complaint) {
    char late[64];
    snprintf(late, sizeof late, "no final image within %.0f s", timeout);
    json_text(bench->json, "refused", complaint[0] != '\0' ? complaint : late);
}

/* override: of the scene; NULL: none. */
static int measure_case(const bench_session* bench, const char* scene, const char* method, const char* override) {
    int32_t size[2];
    char pixels[32], threads[16];
    bench_pixels(bench->options, 640, 360, size);
    snprintf(pixels, sizeof pixels, "%dx%d", (int)size[0], (int)size[1]);
    snprintf(threads, sizeof threads, "%d", (int)ty_context_threads(bench->session->context));
    const char* const arguments[] = {scene,
                                     "--method",
                                     method,
                                     "--size",
                                     pixels,
                                     "--threads",
                                     threads,
                                     "--no-compare",
                                     "-D",
                                     "render.spp=16",
                                     override != NULL ? "-D" : NULL,
                                     override,
                                     NULL};
    view_client* client = view_client_open(arguments);
    if (client == NULL) return CLI_FAILED;
    measured m;
    const bool done = measure(bench, client, &m);
    json_open_object(bench->json, method);
    if (done)
        bench_numbers(bench->json, {"latency_ms", m.latency}, {"latency_max_ms", m.latency_max},
                      {"camera_latency_ms", m.camera_latency}, {"final_seconds", m.final_seconds},
                      {"images_per_second", m.rate}, {"width_while_moving", m.coarse}, {"solve_ms", m.solve},
                      {"view_ms", m.view});
    else
        tell_failure(bench, view_client_complaint(client));
    json_close_object(bench->json);
    view_client_close(client);
    return CLI_DONE;
}

/* The name of a scene without folders and extension. */
static void scene_name(const char* scene, char* out, size_t size) {
    const char* slash = strrchr(scene, '/');
    const char* name = slash != NULL ? slash + 1 : scene;
    if (strncmp(name, "builtin:", 8) == 0) name += 8;
    snprintf(out, size, "%.*s", (int)strcspn(name, "."), name);
}

static int measure_files(const bench_session* bench) {
    char scene[BENCH_PATH_SIZE], name[128];
    int status = CLI_DONE;
    for (const char* rest = bench->options->scenes; status == CLI_DONE && *rest != '\0' && !cli_interrupted();) {
        snprintf(scene, sizeof scene, "%.*s", (int)strcspn(rest, ","), rest);
        rest += strcspn(rest, ",");
        rest += *rest == ',';
        if (strcmp(scene, photo_name) == 0) {
            status = bench_photo(bench);
            continue;
        }
        scene_name(scene, name, sizeof name);
        json_open_object(bench->json, name);
        for (int m = 0; m < METHODS && status == CLI_DONE; ++m)
            status = measure_case(bench, scene, volume_methods[m], NULL);
        json_close_object(bench->json);
    }
    return status;
}

/* Measures a scene of scenes/tools, by way of a file. */
static int measure_tool_scene(const bench_session* bench, const view_case* item, const char* method) {
    bench_scene_file file;
    int status = bench_write_scene(bench->options, item->scene, "media[0].density.file", item->file, &file);
    if (status != CLI_GO) return status;
    status = measure_case(bench, file.path, method, file.override);
    bench_remove_scene(&file);
    return status;
}

static int measure_scene(const bench_session* bench, const view_case* item) {
    int status = CLI_DONE;
    json_open_object(bench->json, item->title);
    if (item->file != NULL && !tools_has_data(bench->options->data, item->file)) {
        char text[128];
        snprintf(text, sizeof text, "%s is not in the folder of --data", item->file);
        json_text(bench->json, "skipped", text);
    } else {
        for (int m = 0; m < METHODS && item->methods[m] != NULL && status == CLI_DONE && !cli_interrupted(); ++m)
            status = item->file != NULL ? measure_tool_scene(bench, item, item->methods[m])
                                        : measure_case(bench, item->scene, item->methods[m], NULL);
    }
    json_close_object(bench->json);
    return status;
}

int bench_view(const bench_session* bench) {
    if (bench->options->scenes_given) return measure_files(bench);
    int status = CLI_DONE;
    for (size_t i = 0; i < sizeof cases / sizeof cases[0] && status == CLI_DONE && !cli_interrupted(); ++i)
        status = measure_scene(bench, &cases[i]);
    return status == CLI_DONE && !cli_interrupted() ? bench_photo(bench) : status;
}
