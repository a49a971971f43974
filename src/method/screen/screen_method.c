/* Screen-space scattering as a method, applied to the path-traced image of the scene without media. */
#include "base/constants.h"
#include "base/context.h"
#include "image/image.h"
#include "method/method.h"
#include "method/screen/screen_options.h"

#include <string.h>

static const double full_sphere = 4 * TY_PI_F64;

_Static_assert(sizeof(ty_screen_stats) <= TY_METHOD_STATS_MAX, "ty_method_run holds the stats");

static const ty_stat stats[] = {
    {TY_STAT_FIELD(ty_screen_stats, seconds), TY_STAT_NUMBER},
    {.name = "attenuation_seconds",
     .offset = offsetof(ty_screen_stats, step_seconds[0]),
     TY_STAT_NUMBER,
     .stage = true},
    {.name = "filtering_seconds", .offset = offsetof(ty_screen_stats, step_seconds[1]), TY_STAT_NUMBER, .stage = true},
    {.name = "composition_seconds",
     .offset = offsetof(ty_screen_stats, step_seconds[2]),
     TY_STAT_NUMBER,
     .stage = true},
    {TY_STAT_FIELD(ty_screen_stats, levels), TY_STAT_INT},
    {TY_STAT_FIELD(ty_screen_stats, spread), TY_STAT_NUMBER},
    {TY_STAT_FIELD(ty_screen_stats, oversized), TY_STAT_LONG},
    {TY_STAT_FIELD(ty_screen_stats, nonfinite_fixed), TY_STAT_LONG},
    {.name = "bytes", .offset = offsetof(ty_screen_stats, memory_bytes), TY_STAT_NUMBER},
    {TY_STAT_FIELD(ty_screen_stats, isa), TY_STAT_TEXT},
};

static void choose_variant(ty_screen_variant_word word, ty_screen_def* def) {
    switch (word) {
    case TY_SCREEN_WORD_SCATTER: return;
    case TY_SCREEN_WORD_GATHER: def->variant = TY_SCREEN_GATHER; return;
    case TY_SCREEN_WORD_NAIVE: ty_screen_naive_def(def); return;
    case TY_SCREEN_WORD_PUBLISHED: ty_screen_published_def(def); return;
    case TY_SCREEN_WORD_REFERENCE: def->variant = TY_SCREEN_REFERENCE; return;
    }
}

/* The mean radiance of surfaces and lights at the camera, over all directions. */
static ty_result find_radiance_around(const ty_scene* scene, const ty_render_request* request, float radiance[3]) {
    static const int32_t parts[3] = {8, 8, 8}; /* receivers at one point, so that threads divide the paths */
    enum { PARTS = 512, SAMPLES = 64 };
    double fluence[PARTS][3];
    const ty_camera_def camera = ty_scene_camera(scene);
    ty_path_def def;
    ty_result result = ty_request_path_def(scene, request, &def);
    if (result != TY_OK) return result;
    def.ignore_media = true;
    def.spp = SAMPLES;
    def.seconds = def.error = 0;
    def.progress = NULL; /* short, and useless if incomplete */
    def.state = NULL;
    def.resume = NULL;
    def.resume_size = 0;
    result = ty_path_fluence(scene, &def, camera.position, camera.position, parts, fluence[0], NULL, NULL);
    for (int c = 0; c < 3 && result == TY_OK; ++c) {
        double sum = 0;
        for (int i = 0; i < PARTS; ++i) sum += fluence[i][c];
        radiance[c] = (float)(sum / (PARTS * full_sphere));
    }
    return result;
}

/* The def from the scene, its options and its camera. */
static ty_result make_def(const ty_scene* scene, const ty_render_request* request, ty_screen_def* def) {
    ty_screen_scene_def options;
    ty_options_init(&ty_screen_options, &options, sizeof options);
    ty_result result = ty_method_options(scene, "screen", &options);
    if (result != TY_OK) return result;
    *def = ty_default_screen_def();
    choose_variant(options.variant, def);
    def->spread = options.spread;
    def->filter = options.filter;
    def->levels = options.levels;
    def->progress = request->progress;
    def->progress_user = request->progress_user;
    result = ty_screen_set_scene(scene, request->height, def);
    float radiance[3] = {0, 0, 0};
    if (result == TY_OK && options.environment == TY_SCREEN_ENVIRONMENT_AROUND)
        result = find_radiance_around(scene, request, radiance);
    if (result != TY_OK) return result;
    if (options.environment == TY_SCREEN_ENVIRONMENT_LIGHTS) ty_scene_environment(scene, radiance);
    if (options.balance)
        ty_screen_balance(def, radiance);
    else
        memcpy(def->environment, radiance, sizeof radiance);
    return TY_OK;
}

/* Applies the media in place to the surface radiance, by depth. */
static ty_result scatter(const ty_scene* scene, const ty_screen_def* def, ty_image* image, ty_screen_stats* done) {
    ty_context* context = ty_scene_context(scene);
    const int32_t width = ty_image_width(image), height = ty_image_height(image);
    const size_t count = (size_t)width * (size_t)height;
    /* The depth channel is left unchanged for the caller. */
    float* distance = ty_alloc_array(context, count, sizeof *distance, false);
    if (distance == NULL) return TY_ERROR_MEMORY;
    memcpy(distance, ty_image_plane_const(image, ty_image_find_channel(image, "depth.Z")), count * sizeof *distance);
    ty_screen_image planes = ty_default_screen_image();
    planes.width = width;
    planes.height = height;
    planes.distance = distance;
    planes.distance_row = width;
    planes.color.row = width;
    for (int c = 0; c < 3; ++c) planes.color.data[c] = ty_image_plane(image, c);
    planes.out = planes.color;
    ty_result result = ty_screen_scene_distance(scene, width, height, distance);
    if (result == TY_OK) result = ty_screen_apply(context, def, &planes, NULL, 0, done);
    ty_free_array(context, distance, count, sizeof *distance);
    return result;
}

static ty_result render(const ty_scene* scene, const ty_render_request* request, ty_image** out, ty_method_run* run) {
    ty_screen_def def;
    ty_path_def surfaces;
    ty_image* image = NULL;
    const double begun = ty_wall_seconds();
    ty_result result = make_def(scene, request, &def);
    if (result == TY_OK) result = ty_request_path_def(scene, request, &surfaces);
    if (result != TY_OK) return result;
    surfaces.ignore_media = true;
    surfaces.aovs |= TY_AOV_DEPTH;
    run->own_seconds = ty_wall_seconds() - begun;
    run->path = ty_default_path_stats();
    const ty_result traced = ty_path_render(scene, &surfaces, &image, &run->path);
    if (traced != TY_OK && traced != TY_CANCELLED) return traced;
    const double finished = ty_wall_seconds();
    result = scatter(scene, &def, image, ty_method_stats(run, sizeof(ty_screen_stats)));
    if (result == TY_OK && (request->aovs & TY_AOV_DEPTH) == 0)
        result = ty_image_drop_channel(ty_scene_context(scene), &image, "depth.Z");
    if (result != TY_OK) {
        ty_image_destroy(image);
        return result;
    }
    run->own_seconds += ty_wall_seconds() - finished;
    run->path.seconds += run->own_seconds;
    *out = image;
    return traced;
}

static ty_result check(const ty_scene* scene) {
    ty_screen_def def = ty_default_screen_def();
    return ty_screen_set_scene(scene, 0, &def);
}

const ty_method ty_method_screen = {.name = "screen",
                                    .summary = "screen-space scattering over the surfaces' image",
                                    .options = &ty_screen_options,
                                    .aovs = TY_AOV_DEPTH | TY_AOV_NORMAL | TY_AOV_SAMPLES,
                                    .stats = stats,
                                    .stat_count = sizeof stats / sizeof stats[0],
                                    .check = check,
                                    .render = render};
