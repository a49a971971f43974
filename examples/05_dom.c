/* A cloud that grows, lit anew in each frame from the light of the one before: discrete ordinates from C. */
#include <tyndall/tyndall.h>

#include <stdio.h>

enum { FRAMES = 3 };

/* A cumulus of noise, 1 m across, under a sun and a blue sky; from frame to frame there is more of it. */
static ty_result make_scene(ty_context* context, int frame, ty_scene** out) {
    ty_noise_def noise = ty_default_noise_def();
    noise.kind = TY_NOISE_CLOUD;
    noise.coverage = 0.5f + 0.02f * (float)frame;
    ty_medium_def cloud = ty_default_medium_def();
    cloud.bounds = TY_BOUNDS_BOX;
    ty_light_def sun = ty_default_light_def(), sky = ty_default_light_def();
    sun.direction[0] = -0.7;
    sun.direction[1] = -0.6;
    sky.kind = TY_LIGHT_ENVIRONMENT;
    for (int a = 0; a < 3; ++a) {
        noise.size[a] = 64;
        cloud.box_min[a] = -0.5;
        cloud.box_max[a] = 0.5;
        cloud.sigma_s[a] = 25;
        cloud.g[a] = 0.6f;
        sky.color[a] = 0.04f + 0.03f * (float)a;
    }
    ty_result result = ty_grid_create_noise(context, &noise, &cloud.density_grid);
    if (result == TY_OK) result = ty_scene_create(context, TY_AXIS_Y, out);
    if (result == TY_OK) result = ty_scene_add_medium(*out, &cloud);
    if (result == TY_OK) result = ty_scene_add_light(*out, &sun);
    if (result == TY_OK) result = ty_scene_add_light(*out, &sky);
    ty_grid_release(cloud.density_grid); /* the scene has a reference of its own */
    return result == TY_OK ? ty_scene_commit(*out) : result;
}

static ty_result render_view(ty_scene* scene, const ty_dom* light, const ty_dom_def* def, int frame, double x) {
    char path[64];
    ty_camera_def camera = ty_default_camera_def();
    camera.position[0] = x;
    camera.position[2] = 2;
    camera.fov_y = 30;
    ty_image* image = NULL;
    snprintf(path, sizeof path, "cloud_%d_%s.png", frame, x < 0 ? "left" : "right");
    ty_result result = ty_scene_set_camera(scene, &camera);
    if (result == TY_OK) result = ty_dom_view(light, scene, def, &image, NULL);
    if (result == TY_OK) result = ty_image_write_png(ty_scene_context(scene), image, 2, TY_TONE_FILMIC, path);
    ty_image_destroy(image);
    return result;
}

/* *light: of the frame before, or NULL; then this frame's. */
static ty_result render_frame(ty_context* context, int frame, ty_dom** light) {
    ty_scene* scene = NULL;
    ty_dom* now = NULL;
    ty_dom_stats stats = ty_default_dom_stats();
    ty_dom_def def = ty_default_dom_def();
    def.width = def.height = 192;
    def.directions = 48;
    def.start = *light;
    ty_result result = make_scene(context, frame, &scene);
    if (result == TY_OK) result = ty_dom_solve(scene, &def, &now, &stats);
    if (result == TY_OK)
        printf("frame %d: %d sweeps of %d directions over %dx%dx%d cells, %.3f s; %.3f W scattered, %.3f W left\n",
               frame, stats.sweeps[0], stats.directions, stats.size[0], stats.size[1], stats.size[2], stats.seconds,
               stats.emitted[0], stats.leaving[0]);
    if (result == TY_OK) result = render_view(scene, now, &def, frame, -1);
    if (result == TY_OK) result = render_view(scene, now, &def, frame, 1);

    /* The light at a point, for a probe or a particle. */
    const double center[3] = {0, 0, 0};
    const int32_t one[3] = {1, 1, 1};
    double fluence[3] = {0, 0, 0};
    if (result == TY_OK) result = ty_dom_fluence(now, center, center, one, fluence, NULL);
    if (result == TY_OK) printf("  fluence in the middle: %.3f W m^-2\n", fluence[0]);
    ty_scene_destroy(scene);
    ty_dom_destroy(*light);
    *light = now;
    return result;
}

int main(void) {
    ty_context* context = NULL;
    ty_dom* light = NULL;
    const ty_context_def context_def = ty_default_context_def();
    ty_result result = ty_context_create(&context_def, &context);
    for (int frame = 0; frame < FRAMES && result == TY_OK; ++frame) result = render_frame(context, frame, &light);
    if (result != TY_OK) fprintf(stderr, "%s: %s\n", ty_result_name(result), ty_take_error(context));
    ty_dom_destroy(light);
    ty_context_destroy(context);
    return result == TY_OK ? 0 : 1;
}
