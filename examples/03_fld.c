/* A cloud lit once and looked at from two sides: flux-limited diffusion from C. */
#include <tyndall/tyndall.h>

#include <stdio.h>

/* A cumulus of noise, 1 m across, under a sun. */
static ty_result make_scene(ty_context* context, ty_scene** out) {
    ty_noise_def noise = ty_default_noise_def();
    noise.kind = TY_NOISE_CLOUD;
    ty_medium_def cloud = ty_default_medium_def();
    cloud.bounds = TY_BOUNDS_BOX;
    for (int a = 0; a < 3; ++a) {
        noise.size[a] = 64;
        cloud.box_min[a] = -0.5;
        cloud.box_max[a] = 0.5;
        cloud.sigma_s[a] = 19;
        cloud.sigma_a[a] = 0.2f;
        cloud.g[a] = 0.6f;
    }
    ty_light_def sun = ty_default_light_def();
    sun.direction[0] = -0.7;
    sun.direction[1] = -0.6;
    ty_result result = ty_grid_create_noise(context, &noise, &cloud.density_grid);
    if (result == TY_OK) result = ty_scene_create(context, TY_AXIS_Y, out);
    if (result == TY_OK) result = ty_scene_add_medium(*out, &cloud);
    if (result == TY_OK) result = ty_scene_add_light(*out, &sun);
    ty_grid_release(cloud.density_grid); /* the scene has a reference of its own */
    return result == TY_OK ? ty_scene_commit(*out) : result;
}

static ty_result render_view(ty_scene* scene, const ty_fld* light, const ty_fld_def* def, double x, const char* path) {
    ty_camera_def camera = ty_default_camera_def();
    camera.position[0] = x;
    camera.position[2] = 2;
    camera.fov_y = 30;
    ty_image* image = NULL;
    ty_fld_stats stats = ty_default_fld_stats();
    ty_result result = ty_scene_set_camera(scene, &camera);
    if (result == TY_OK) result = ty_fld_view(light, scene, def, &image, &stats);
    if (result == TY_OK) result = ty_image_write_png(ty_scene_context(scene), image, 2, TY_TONE_FILMIC, path);
    if (result == TY_OK) printf("%s in %.2f s\n", path, stats.march_seconds);
    ty_image_destroy(image);
    return result;
}

int main(void) {
    ty_context* context = NULL;
    ty_scene* scene = NULL;
    ty_fld* light = NULL;
    ty_fld_stats stats = ty_default_fld_stats();
    const ty_context_def context_def = ty_default_context_def();
    ty_result result = ty_context_create(&context_def, &context);
    if (result == TY_OK) result = make_scene(context, &scene);

    ty_fld_def def = ty_default_fld_def();
    def.width = def.height = 256;
    if (result == TY_OK) result = ty_fld_solve(scene, &def, &light, &stats);
    if (result == TY_OK)
        printf("%dx%dx%d cells in %.2f s: %.3f W scattered, %.3f W absorbed, %.3f W left\n", stats.diffusion_size[0],
               stats.diffusion_size[1], stats.diffusion_size[2], stats.seconds, stats.emitted[0], stats.absorbed[0],
               stats.leaving[0]);

    /* The light at a point, for a probe or a particle. */
    const double center[3] = {0, 0, 0};
    const int32_t one[3] = {1, 1, 1};
    double fluence[3] = {0, 0, 0};
    if (result == TY_OK) result = ty_fld_fluence(light, center, center, one, fluence, NULL, NULL);
    if (result == TY_OK) printf("fluence in the middle: %.3f W m^-2\n", fluence[0]);

    if (result == TY_OK) result = render_view(scene, light, &def, -1, "cloud_left.png");
    if (result == TY_OK) result = render_view(scene, light, &def, 1, "cloud_right.png");
    if (result != TY_OK) fprintf(stderr, "%s: %s\n", ty_result_name(result), ty_take_error(context));
    ty_fld_destroy(light);
    ty_scene_destroy(scene);
    ty_context_destroy(context);
    return result == TY_OK ? 0 : 1;
}
