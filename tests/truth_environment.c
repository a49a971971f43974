/* Where an environment map's light comes from: seen by the camera, and cast on surfaces and media. */
#include "truth.h"

enum { WIDTH = 32, HEIGHT = 16 };

typedef struct placement {
    ty_axis up;
    int32_t column, row; /* of the bright texel */
    double rotation;     /* degrees */
} placement;

static const placement placements[] = {
    {TY_AXIS_Y, 16, 7, 0},  {TY_AXIS_Y, 24, 5, 0},   {TY_AXIS_Y, 3, 11, 0}, {TY_AXIS_Y, 24, 5, 90},
    {TY_AXIS_Y, 0, 6, -37}, {TY_AXIS_Z, 16, 7, 0},   {TY_AXIS_Z, 24, 5, 0}, {TY_AXIS_Z, 3, 11, 0},
    {TY_AXIS_Z, 24, 5, 90}, {TY_AXIS_Z, 31, 9, 200},
};

enum { PLACEMENTS = sizeof placements / sizeof *placements };

/* The map's coordinates, in texels, to the direction one looks along: by the convention in scene.h and docs/scene.md.
 */
static void look_of(const placement* p, double column, double row, double look[3]) {
    const double turn = 2 * pi * (column / WIDTH - 0.5), down = pi * row / HEIGHT;
    const double turned = p->rotation * pi / 180;
    if (p->up == TY_AXIS_Y) {
        /* u = 0.5 + atan2(z, x) / 2 pi; seen from above, from x counter-clockwise is towards -z. */
        set3(look, sin(down) * cos(turn - turned), cos(down), sin(down) * sin(turn - turned));
    } else {
        /* u = 0.5 - atan2(y, x) / 2 pi; from x counter-clockwise is towards y. */
        set3(look, sin(down) * cos(turned - turn), sin(down) * sin(turned - turn), cos(down));
    }
}

/* A map that is dark but for one texel, and one that is half as bright three columns to its right. */
static double texel(const placement* p, int32_t column, int32_t row) {
    if (row != p->row) return 0;
    return column == p->column ? 100 : column == (p->column + 3) % WIDTH ? 50 : 0;
}

static ty_scene* map_scene(ty_context* context, const placement* p) {
    ty_scene* scene = NULL;
    ty_image* image = NULL;
    must(context, ty_scene_create(context, p->up, &scene));
    must(context, ty_image_create_rgb(context, WIDTH, HEIGHT, &image));
    for (int c = 0; c < 3; ++c)
        for (int32_t y = 0; y < HEIGHT; ++y)
            for (int32_t x = 0; x < WIDTH; ++x)
                ty_image_plane(image, c)[y * WIDTH + x] = (float)(texel(p, x, y) * (c + 1));
    ty_light_def light = light_of(TY_LIGHT_ENVIRONMENT, 1);
    light.image = image;
    light.scale = 0.5f;
    light.rotation = p->rotation;
    add_light(scene, &light);
    ty_image_destroy(image);
    return scene;
}

/* The camera that looks along the bright texel has it in the middle of the picture, and the lesser one to its right. */
static void environments_are_seen_as_they_are(void** state) {
    enum { SIDE = 65 };
    for (int i = 0; i < PLACEMENTS; ++i) {
        const placement* p = &placements[i];
        ty_scene* scene = map_scene(*state, p);
        ty_camera_def camera = ty_default_camera_def();
        set3(camera.position, 5, -3, 2);
        set3(camera.up, 0, p->up == TY_AXIS_Y, p->up == TY_AXIS_Z);
        camera.fov_y = 75;
        double look[3];
        look_of(p, p->column + 0.5, p->row + 0.5, look);
        for (int a = 0; a < 3; ++a) camera.target[a] = camera.position[a] + look[a];
        must(*state, ty_scene_set_camera(scene, &camera));
        commit(scene);
        ty_image* image = render(scene, SIDE, 16, 1);
        const float* red = ty_image_plane_const(image, 0);
        int brightest = 0, right = SIDE / 2 + 8;
        for (int j = 0; j < SIDE * SIDE; ++j)
            if (red[j] > red[brightest]) brightest = j;
        for (int x = SIDE / 2 + 8; x < SIDE; ++x)
            if (red[SIDE / 2 * SIDE + x] > red[SIDE / 2 * SIDE + right]) right = x;
        double other[3], forward[3] = {look[0], look[1], look[2]}, side[3];
        look_of(p, p->column + 3.5, p->row + 0.5, other);
        cross3(forward, camera.up, side);
        normalize3(side);
        const double tangent = dot3(other, side) / dot3(other, forward) / tan(camera.fov_y * pi / 360);
        const double expected = SIDE / 2.0 * (1 + tangent) - 0.5;
        printf("up %c, texel %2d %2d, turned %4g: brightest pixel %d %d of %d %d, the lesser at %d of %.1f\n",
               p->up == TY_AXIS_Y ? 'y' : 'z', p->column, p->row, p->rotation, brightest % SIDE, brightest / SIDE,
               SIDE / 2, SIDE / 2, right, expected);
        assert_int_equal(brightest % SIDE, SIDE / 2);
        assert_int_equal(brightest / SIDE, SIDE / 2);
        assert_true(red[brightest] > 42 && red[brightest] <= 50);
        assert_true(tangent > 0 && fabs(right - expected) < 4);
        assert_true(ty_image_plane_const(image, 2)[brightest] > 2.9f * red[brightest]);
        ty_image_destroy(image);
        ty_scene_destroy(scene);
    }
}

/* The integral over the map of radiance times f(user, direction), by the midpoint rule in 16 x 16 parts of a texel. */
static double over_map(const placement* p, double (*f)(const void* user, const double look[3]), const void* user) {
    enum { PARTS = 16 };
    double sum = 0;
    for (int y = 0; y < HEIGHT * PARTS; ++y) {
        const double row = (y + 0.5) / PARTS,
                     solid = 2 * pi / (WIDTH * PARTS) *
                             (cos(pi * y / (HEIGHT * PARTS)) - cos(pi * (y + 1) / (HEIGHT * PARTS)));
        if (fabs(row - p->row - 0.5) > 1.5) continue;
        for (int x = 0; x < WIDTH * PARTS; ++x) {
            const double column = (x + 0.5) / PARTS;
            /* Bilinear between the centres of texels. */
            const int32_t left = (int32_t)floor(column - 0.5), top = (int32_t)floor(row - 0.5);
            const double across = column - 0.5 - left, down = row - 0.5 - top;
            double radiance = 0, look[3];
            for (int corner = 0; corner < 4; ++corner)
                radiance += texel(p, (left + corner % 2 + WIDTH) % WIDTH, top + corner / 2) *
                            (corner % 2 ? across : 1 - across) * (corner / 2 ? down : 1 - down);
            if (radiance <= 0) continue;
            look_of(p, column, row, look);
            sum += 0.5 * radiance * solid * f(user, look);
        }
    }
    return sum;
}

static double facing(const void* user, const double look[3]) {
    return fmax(0, dot3(user, look));
}

/* Boards that face six ways and one between get exactly the light of their side. */
static void environments_light_surfaces(void** state) {
    static const double ways[7][3] = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0},    {0, -1, 0},
                                      {0, 0, 1}, {0, 0, -1}, {0.6, 0, 0.8}};
    for (int i = 0; i < PLACEMENTS; ++i) {
        double worst = 0, sum = 0, expected_sum = 0;
        for (int w = 0; w < 7; ++w) {
            ty_scene* scene = map_scene(*state, &placements[i]);
            static const double center[3] = {0, 0, 0};
            double helper[3] = {ways[w][1], ways[w][2], ways[w][0]}, u[3], v[3], ray[6], radiance[3], variance[3];
            cross3(helper, ways[w], u);
            normalize3(u);
            cross3(ways[w], u, v);
            const ty_shape_def board = square_shape(center, u, v, 1, 0.6);
            add_shape(scene, &board);
            commit(scene);
            for (int a = 0; a < 3; ++a) {
                ray[a] = ways[w][a] + 0.3 * u[a];
                ray[3 + a] = -ways[w][a];
            }
            radiance_along(scene, 1, ray, 1 << 14, 0, radiance, variance);
            const double expected = 0.6 / pi * over_map(&placements[i], facing, ways[w]);
            worst = fmax(worst, fabs(radiance[0] - expected) / (4 * sqrt(variance[0]) + 1e-6));
            sum += radiance[0];
            expected_sum += expected;
            ty_scene_destroy(scene);
        }
        printf("boards, placement %d: sum %.5f of %.5f, worst at %.2f of four standard errors\n", i, sum, expected_sum,
               worst);
        assert_true(fabs(sum / expected_sum - 1) < 0.005);
        assert_true(worst < 1);
    }
}

/* A ray of the eye that begins in the middle of a ball of fog, which is looked at along `look`. */
typedef struct fog {
    double way[3], look[3];
    double sigma_s, g, radius;
} fog;

static double fog_at(const void* user, double t) {
    const fog* f = user;
    const double along = t * dot3(f->way, f->look);
    const double distance = sqrt(along * along + f->radius * f->radius - t * t) - along;
    return f->sigma_s * exp(-f->sigma_s * (t + distance));
}

static double scattered(const void* user, const double look[3]) {
    fog f = *(const fog*)user;
    memcpy(f.look, look, sizeof f.look);
    return henyey_greenstein(dot3(f.way, look), f.g) * ty_integrate(fog_at, &f, 0, f.radius, 1);
}

/* A ball of fog scatters the map's light once, as its phase function says. */
static void environments_light_media(void** state) {
    static const double ways[4][3] = {{0, 0.6, 0.8}, {0, -1, 0}, {-0.6, 0.8, 0}, {0.8, 0, -0.6}};
    for (int i = 0; i < PLACEMENTS; ++i) {
        double worst = 0, sum = 0, expected_sum = 0;
        for (int w = 0; w < 4; ++w) {
            fog f = {.sigma_s = 0.8, .g = 0.6, .radius = 1};
            memcpy(f.way, ways[w], sizeof f.way);
            ty_scene *scene = map_scene(*state, &placements[i]), *empty = map_scene(*state, &placements[i]);
            const ty_medium_def ball = medium_sphere(f.radius, f.sigma_s, 0, f.g);
            add_medium(scene, &ball);
            commit(scene);
            commit(empty);
            double ray[6] = {0, 0, 0, f.way[0], f.way[1], f.way[2]}, radiance[3], variance[3], behind[3];
            radiance_along(scene, 1, ray, 1 << 16, 1, radiance, variance);
            radiance_along(empty, 1, ray, 1, 1, behind, NULL);
            const double expected = over_map(&placements[i], scattered, &f) + behind[0] * exp(-f.sigma_s * f.radius);
            worst = fmax(worst, fabs(radiance[0] - expected) / (4 * sqrt(variance[0]) + 1e-6));
            sum += radiance[0];
            expected_sum += expected;
            ty_scene_destroy(scene);
            ty_scene_destroy(empty);
        }
        printf("fog, placement %d: sum %.5f of %.5f, worst at %.2f of four standard errors\n", i, sum, expected_sum,
               worst);
        assert_true(fabs(sum / expected_sum - 1) < 0.01);
        assert_true(worst < 1);
    }
}

static double anywhere(const void* user, const double look[3]) {
    (void)user;
    (void)look;
    return 1;
}

/* With nothing in the way, fluence is the integral of the map. */
static void fluence_is_the_integral(void** state) {
    for (int i = 0; i < PLACEMENTS; ++i) {
        ty_scene* scene = map_scene(*state, &placements[i]);
        commit(scene);
        static const double point[3] = {1, 2, 3};
        static const int32_t size[3] = {64, 1, 1};
        double fluence[3 * 64];
        ty_path_def def = ty_default_path_def();
        def.spp = 1024;
        must(*state, ty_path_fluence(scene, &def, point, point, size, fluence, NULL, NULL));
        assert_close("fluence of a map", estimate_of(fluence, 64, 3), over_map(&placements[i], anywhere, NULL), 0.005);
        ty_scene_destroy(scene);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(environments_are_seen_as_they_are),
        cmocka_unit_test(environments_light_surfaces),
        cmocka_unit_test(environments_light_media),
        cmocka_unit_test(fluence_is_the_integral),
    };
    return cmocka_run_group_tests(tests, truth_start, truth_stop);
}
