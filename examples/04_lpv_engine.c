/* Fog in an engine's scene: its own shadow map with normals and albedo, and its own depth, normals and albedo of what
 * the camera sees, go in; no mesh does. Here a formula stands for the engine: a box on a plane. */
#include <tyndall/tyndall.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

enum { WIDTH = 480, HEIGHT = 270, SIDE = 256, VIEWS = 2 };

typedef struct vec {
    double x, y, z;
} vec;

static vec add_scaled(vec a, double s, vec b) {
    return (vec){a.x + s * b.x, a.y + s * b.y, a.z + s * b.z};
}

static vec cross(vec a, vec b) {
    return (vec){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

static vec unit(vec a) {
    const double length = sqrt(a.x * a.x + a.y * a.y + a.z * a.z);
    return (vec){a.x / length, a.y / length, a.z / length};
}

/* ---- the engine ---- */

/* Buffers of maps and views, a value per pixel. */
typedef struct buffers {
    float *depth, *normal, *albedo;
} buffers;

static bool make_buffers(size_t count, buffers* out) {
    out->depth = malloc(count * sizeof(float));
    out->normal = malloc(3 * count * sizeof(float));
    out->albedo = malloc(3 * count * sizeof(float));
    return out->depth != NULL && out->normal != NULL && out->albedo != NULL;
}

static void free_buffers(buffers* b) {
    free(b->depth);
    free(b->normal);
    free(b->albedo);
}

/* The first surface along a ray: the plane y = 0, or a box that stands on it, 1.6 m wide and 3 m high. */
static void cast(vec origin, vec direction, const buffers* out, size_t i) {
    const double o[3] = {origin.x, origin.y, origin.z}, d[3] = {direction.x, direction.y, direction.z};
    const double lower[3] = {-0.8, 0, -0.8}, upper[3] = {0.8, 3, 0.8};
    const double plane = d[1] < 0 ? -o[1] / d[1] : INFINITY;
    double enter = -INFINITY, leave = INFINITY;
    int axis = 0;
    for (int a = 0; a < 3; ++a) {
        const double to = ((d[a] > 0 ? lower[a] : upper[a]) - o[a]) / d[a];
        const double from = ((d[a] > 0 ? upper[a] : lower[a]) - o[a]) / d[a];
        if (to > enter) axis = a;
        enter = fmax(enter, to);
        leave = fmin(leave, from);
    }
    const bool box = enter < leave && enter > 0 && enter < plane;
    out->depth[i] = (float)(box ? enter : plane);
    for (int c = 0; c < 3; ++c) {
        out->normal[3 * i + (size_t)c] = box ? (c != axis ? 0.0f : d[axis] > 0 ? -1.0f : 1.0f) : c == 1 ? 1.0f : 0.0f;
        out->albedo[3 * i + (size_t)c] = box ? (c == 0 ? 0.7f : 0.15f) : 0.5f;
    }
}

/* A map of 16 m by 16 m for a sun that shines along forward. */
static void draw_shadow_map(const vec forward, const buffers* b, ty_rsm* map) {
    const vec right = unit(cross(forward, (vec){0, 1, 0})), up = cross(right, forward);
    const vec origin = add_scaled((vec){0, 1, 0}, -30, forward);
    const double half = 8;
    *map = (ty_rsm){.side = SIDE, .faces = 1, .depth = b->depth, .normal = b->normal, .albedo = b->albedo};
    const double vectors[4][3] = {{origin.x, origin.y, origin.z},
                                  {forward.x, forward.y, forward.z},
                                  {half * right.x, half * right.y, half * right.z},
                                  {half * up.x, half * up.y, half * up.z}};
    for (int a = 0; a < 3; ++a) {
        map->origin[a] = vectors[0][a];
        map->forward[0][a] = vectors[1][a];
        map->right[0][a] = vectors[2][a];
        map->up[0][a] = vectors[3][a];
    }
    for (int y = 0; y < SIDE; ++y)
        for (int x = 0; x < SIDE; ++x) {
            const double s = half * (2 * (x + 0.5) / SIDE - 1), t = half * (2 * (y + 0.5) / SIDE - 1);
            cast(add_scaled(add_scaled(origin, s, right), t, up), forward, b, (size_t)(y * SIDE + x));
        }
}

/* The surfaces that the camera sees through the centers of its pixels, with distances along their rays. */
static void draw_view(const ty_camera_def* camera, const buffers* b) {
    const vec eye = {camera->position[0], camera->position[1], camera->position[2]};
    const vec target = {camera->target[0], camera->target[1], camera->target[2]};
    const vec forward = unit(add_scaled(target, -1, eye));
    const vec right = unit(cross(forward, (vec){0, 1, 0})), up = cross(right, forward);
    const double tall = tan(camera->fov_y * 3.14159265358979323846 / 360), wide = tall * WIDTH / HEIGHT;
    for (int y = 0; y < HEIGHT; ++y)
        for (int x = 0; x < WIDTH; ++x) {
            const double s = wide * (2 * (x + 0.5) / WIDTH - 1), t = tall * (1 - 2 * (y + 0.5) / HEIGHT);
            const vec direction = unit(add_scaled(add_scaled(forward, s, right), t, up));
            cast(eye, direction, b, (size_t)(y * WIDTH + x));
        }
}

/* ---- the fog ---- */

/* Fog over the plane, and the sun: all that the scene holds. */
static ty_result make_scene(ty_context* context, vec forward, ty_scene** out) {
    ty_medium_def fog = ty_default_medium_def();
    fog.bounds = TY_BOUNDS_BOX;
    for (int a = 0; a < 3; ++a) {
        fog.box_min[a] = a == 1 ? 0 : -7;
        fog.box_max[a] = a == 1 ? 5 : 7;
        fog.sigma_s[a] = 0.04f;
        fog.g[a] = 0.5f;
    }
    ty_light_def sun = ty_default_light_def();
    sun.direction[0] = forward.x;
    sun.direction[1] = forward.y;
    sun.direction[2] = forward.z;
    for (int c = 0; c < 3; ++c) sun.color[c] = 6;
    ty_result result = ty_scene_create(context, TY_AXIS_Y, out);
    if (result == TY_OK) result = ty_scene_add_medium(*out, &fog);
    if (result == TY_OK) result = ty_scene_add_light(*out, &sun);
    return result == TY_OK ? ty_scene_commit(*out) : result;
}

/* One frame from elsewhere: the light stays as it is. */
static ty_result render_view(ty_scene* scene, const ty_lpv* light, ty_lpv_def* def, const buffers* b, int frame) {
    char path[32];
    ty_lpv_view_def view = ty_default_lpv_view_def();
    view.distance = b->depth;
    view.normal = b->normal;
    view.albedo = b->albedo;
    ty_camera_def camera = ty_default_camera_def();
    ty_image* image = NULL;
    ty_lpv_stats stats = ty_default_lpv_stats();
    camera.position[0] = -5 + 9 * frame;
    camera.position[1] = 1.7;
    camera.position[2] = 6;
    camera.target[1] = 1.4;
    camera.fov_y = 45;
    camera.resolution[0] = WIDTH;
    camera.resolution[1] = HEIGHT;
    snprintf(path, sizeof path, "engine_%d.png", frame);
    draw_view(&camera, b);
    def->view = &view;
    ty_result result = ty_scene_set_camera(scene, &camera);
    if (result == TY_OK) result = ty_lpv_view(light, scene, def, &image, &stats);
    if (result == TY_OK) result = ty_image_write_png(ty_scene_context(scene), image, -1, TY_TONE_FILMIC, path);
    if (result == TY_OK)
        printf("%s: surfaces %.1f ms, lattice marched %.1f ms, single scattering %.1f ms\n", path,
               1e3 * stats.surface_seconds, 1e3 * stats.march_seconds, 1e3 * stats.single_seconds);
    ty_image_destroy(image);
    def->view = NULL;
    return result;
}

static ty_result run(ty_context* context, const buffers* shadow, const buffers* seen) {
    const vec forward = unit((vec){-0.6, -1, 0.35});
    ty_rsm map;
    ty_scene* scene = NULL;
    ty_lpv* light = NULL;
    ty_lpv_stats stats = ty_default_lpv_stats();
    ty_lpv_def def = ty_default_lpv_def();
    draw_shadow_map(forward, shadow, &map);
    def.maps = &map;
    def.map_count = 1;
    ty_result result = make_scene(context, forward, &scene);
    if (result == TY_OK) result = ty_lpv_solve(scene, &def, &light, &stats);
    if (result == TY_OK)
        printf("%dx%dx%d cells of %.2f m in %.1f ms: %.2f W reflected, %.2f W scattered into the lattice\n",
               stats.size[0][0], stats.size[0][1], stats.size[0][2], stats.cell[0], 1e3 * stats.seconds,
               stats.reflected[0], stats.scattered[0]);

    /* The look-up that a shader would do for surfaces, at two points on the plane: in the sun, and in the box's shadow.
     */
    const float points[6] = {2.5f, 0, 0, -1.8f, 0, 0.6f}, normals[6] = {0, 1, 0, 0, 1, 0};
    float irradiance[6] = {0};
    if (result == TY_OK) result = ty_lpv_irradiance(light, points, normals, 2, irradiance);
    if (result == TY_OK)
        printf("irradiance by fog and surfaces: %.3f W m^-2 in the sun, %.3f in the shadow\n", (double)irradiance[0],
               (double)irradiance[3]);

    for (int frame = 0; frame < VIEWS && result == TY_OK; ++frame)
        result = render_view(scene, light, &def, seen, frame);
    ty_lpv_destroy(light);
    ty_scene_destroy(scene);
    return result;
}

int main(void) {
    const ty_context_def context_def = ty_default_context_def();
    ty_context* context = NULL;
    buffers shadow = {0}, seen = {0};
    if (ty_context_create(&context_def, &context) != TY_OK) return 1;
    ty_result result = TY_ERROR_MEMORY;
    if (make_buffers((size_t)SIDE * SIDE, &shadow) && make_buffers((size_t)WIDTH * HEIGHT, &seen))
        result = run(context, &shadow, &seen);
    if (result != TY_OK) fprintf(stderr, "%s: %s\n", ty_result_name(result), ty_take_error(context));
    free_buffers(&seen);
    free_buffers(&shadow);
    ty_context_destroy(context);
    return result == TY_OK ? 0 : 1;
}
