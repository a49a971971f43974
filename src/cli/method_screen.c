/* Screen-space scattering over what paths see of the scene without its media. */
#include "cli/aovs.h"
#include "cli/methods.h"

#include <stdlib.h>
#include <string.h>

static const double full_sphere = 4 * 3.14159265358979323846;

static void choose_variant(const ty_screen_settings* settings, ty_screen_def* def) {
    if (strcmp(settings->variant, "naive") == 0) ty_screen_naive_def(def);
    if (strcmp(settings->variant, "published") == 0) ty_screen_published_def(def);
    if (strcmp(settings->variant, "gather") == 0) def->variant = TY_SCREEN_GATHER;
    if (strcmp(settings->variant, "reference") == 0) def->variant = TY_SCREEN_REFERENCE;
}

/* The mean radiance that surfaces and lights send to the camera from all directions. */
static ty_result find_radiance_around(cli_session* session, const ty_scene* scene, const cli_request* request,
                                      float radiance[3]) {
    static const int32_t parts[3] = {8, 8, 8}; /* of one point, so that threads share the work */
    enum { PARTS = 512, SAMPLES = 64 };
    double fluence[PARTS][3];
    const ty_camera_def camera = ty_scene_camera(scene);
    ty_path_def def = cli_path_def(session, scene, request);
    def.ignore_media = true;
    def.spp = SAMPLES;
    def.seconds = def.error = 0;
    def.progress = NULL; /* it is short, and half of it would be of no use */
    def.state = NULL;
    def.resume = NULL;
    def.resume_size = 0;
    const ty_result result =
        ty_path_fluence(scene, &def, camera.position, camera.position, parts, fluence[0], NULL, NULL);
    for (int c = 0; c < 3 && result == TY_OK; ++c) {
        double sum = 0;
        for (int i = 0; i < PARTS; ++i) sum += fluence[i][c];
        radiance[c] = (float)(sum / (PARTS * full_sphere));
    }
    return result;
}

/* What the scene and its settings make of a picture of its camera. */
static ty_result make_def(cli_session* session, const ty_scene* scene, const cli_request* request, ty_screen_def* def) {
    const ty_screen_settings settings = ty_scene_render_settings(scene).screen;
    *def = ty_default_screen_def();
    choose_variant(&settings, def);
    if (strcmp(settings.spread, "gaussian") == 0) def->spread = TY_SCREEN_SPREAD_GAUSSIAN;
    def->filter = settings.filter;
    if (settings.levels > 0) def->levels = settings.levels;
    def->progress = cli_progress_report;
    def->progress_user = &session->progress;
    ty_result result = ty_screen_set_scene(scene, request->height, def);
    float radiance[3] = {0, 0, 0};
    if (result == TY_OK && strcmp(settings.environment, "around") == 0)
        result = find_radiance_around(session, scene, request, radiance);
    if (result != TY_OK) return result;
    if (strcmp(settings.environment, "lights") == 0) ty_scene_environment(scene, radiance);
    if (settings.balance)
        ty_screen_balance(def, radiance);
    else
        memcpy(def->environment, radiance, sizeof radiance);
    return TY_OK;
}

/* Turns what surfaces send, with its depth, into what arrives through the media, in place. */
static ty_result scatter(cli_session* session, const ty_scene* scene, const ty_screen_def* def, ty_image* image,
                         ty_screen_stats* stats) {
    const int32_t width = ty_image_width(image), height = ty_image_height(image);
    const size_t size = sizeof(float) * (size_t)width * (size_t)height;
    /* The depth stays as it is, for those who asked for it. */
    float* distance = malloc(size);
    if (distance == NULL) return TY_ERROR_MEMORY;
    memcpy(distance, ty_image_plane_const(image, ty_image_find_channel(image, "depth.Z")), size);
    ty_screen_image planes = ty_default_screen_image();
    planes.width = width;
    planes.height = height;
    planes.distance = distance;
    planes.distance_row = width;
    planes.color.row = width;
    for (int c = 0; c < 3; ++c) planes.color.data[c] = ty_image_plane(image, c);
    planes.out = planes.color;
    ty_result result = ty_screen_scene_distance(scene, width, height, distance);
    if (result == TY_OK) result = ty_screen_apply(session->context, def, &planes, NULL, 0, stats);
    free(distance);
    return result;
}

static ty_result render(cli_session* session, const ty_scene* scene, const cli_request* request, ty_image** out,
                        cli_report* report) {
    ty_path_def surfaces = cli_path_def(session, scene, request);
    surfaces.ignore_media = true;
    surfaces.aovs |= TY_AOV_DEPTH;
    ty_screen_def def;
    ty_image* image = NULL;
    const double begun = cli_wall_seconds();
    ty_result result = make_def(session, scene, request, &def);
    if (result != TY_OK) return result;
    report->own_seconds = cli_wall_seconds() - begun;
    const ty_result traced = ty_path_render(scene, &surfaces, &image, &report->path);
    if (traced != TY_OK && traced != TY_CANCELLED) return traced;
    const double finished = cli_wall_seconds();
    result = scatter(session, scene, &def, image, &report->screen);
    if (result == TY_OK && (request->aovs & TY_AOV_DEPTH) == 0)
        result = cli_drop_channel(session->context, &image, "depth.Z");
    if (result != TY_OK) {
        ty_image_destroy(image);
        return result;
    }
    report->own_seconds += cli_wall_seconds() - finished;
    report->path.seconds += report->own_seconds;
    *out = image;
    return traced;
}

static ty_result check(const ty_scene* scene) {
    ty_screen_def def = ty_default_screen_def();
    return ty_screen_set_scene(scene, 0, &def);
}

const cli_method cli_method_screen = {.name = "screen",
                                      .summary = "screen-space scattering over the surfaces' image",
                                      .aovs = TY_AOV_DEPTH | TY_AOV_NORMAL | TY_AOV_SAMPLES,
                                      .crops = false,
                                      .check = check,
                                      .render = render};
