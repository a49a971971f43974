/* Images of method lpv: surfaces, shadows, the lattice marched, upsampling, from lattices that tests make. */
#include "checks.h"

#include "base/sh.k.h"
#include "method/lpv/lattice/packed_lattice.h"
#include "method/lpv/image/image.h"
#include "scene/camera.h"

#include <stdio.h>

enum { WIDE = 96, HIGH = 64 };

/* ---- scenes ---- */

typedef struct view_case {
    ty_scene* scene;
    ty_lpv_def def;
    ty_lattice* lattice;
    ty_grid_medium* medium;
    ty_rsm* map;
    ty_shadow_hierarchy* lit;
    ty_airlight* airlight;
    ty_lpv_image_job job;
} view_case;

static void check(const ty_scene* scene, ty_result result) {
    if (result != TY_OK) fail_msg("%s", ty_take_error(ty_scene_context(scene)));
}

static ty_lpv_def small_def(void) {
    return (ty_lpv_def){.parts = TY_LPV_ALL,
                        .width = WIDE,
                        .height = HIGH,
                        .spp = 1,
                        .step = 1,
                        .shadow_rays = true,
                        .half_resolution_march = true,
                        .aovs = TY_AOV_TRANSMITTANCE | TY_AOV_SINGLE | TY_AOV_MULTIPLE | TY_AOV_DEPTH | TY_AOV_NORMAL |
                                TY_AOV_ALBEDO};
}

static void look_from(ty_scene* scene, double x, double y, double z, double tx, double ty, double tz, double fov) {
    ty_camera_def camera = ty_default_camera_def();
    set3(camera.position, x, y, z);
    set3(camera.target, tx, ty, tz);
    camera.fov_y = fov;
    camera.resolution[0] = WIDE;
    camera.resolution[1] = HIGH;
    check(scene, ty_scene_set_camera(scene, &camera));
}

static void add_box(ty_scene* scene, double x, double y, double z, double size, float albedo) {
    ty_shape_def box = ty_default_shape_def();
    box.kind = TY_SHAPE_BOX;
    set3(box.origin, x, y, z);
    set3(box.u, x + size, y + size, z + size);
    set3f(box.albedo, albedo, albedo, albedo);
    check(scene, ty_scene_add_shape(scene, &box));
}

static void add_ball(ty_scene* scene, double x, double y, double z, double radius) {
    ty_shape_def ball = ty_default_shape_def();
    ball.kind = TY_SHAPE_SPHERE;
    set3(ball.origin, x, y, z);
    ball.radius = radius;
    check(scene, ty_scene_add_shape(scene, &ball));
}

static void add_floor(ty_scene* scene, double half, float albedo) {
    ty_shape_def floor = quad_shape((const double[3][3]){{-half, 0, half}, {2 * half, 0, 0}, {0, 0, -2 * half}});
    set3f(floor.albedo, albedo, albedo, albedo);
    check(scene, ty_scene_add_shape(scene, &floor));
}

static void add_sun(ty_scene* scene, double x, double y, double z) {
    ty_light_def sun = ty_default_light_def();
    set3(sun.direction, x, y, z);
    set3f(sun.color, 3, 2, 1);
    check(scene, ty_scene_add_light(scene, &sun));
}

/* Commits, and makes what an image is made from: a lattice of `cells` cells a side and the maps of one light. */
static void begin_case(view_case* at, ty_scene* scene, const double lower[3], double side, int32_t cells,
                       int32_t bands) {
    ty_context* context = ty_scene_context(scene);
    memset(at, 0, sizeof *at);
    at->scene = scene;
    at->def = small_def();
    check(scene, ty_scene_commit(scene));
    const ty_scene_view* view = ty_scene_get_view(scene);
    ty_grid_box box;
    double upper[3];
    for (int a = 0; a < 3; ++a) {
        box.lower[a] = lower[a];
        box.upper[a] = upper[a] = lower[a] + side;
        box.size[a] = cells;
    }
    check(scene, ty_lattice_create(context, &box, bands, &at->lattice));
    if (view->medium_count > 0) check(scene, ty_grid_medium_create(scene, &box, &at->medium));
    if (view->lights.count > 0) {
        const ty_rsm_def map = {.side = 256, .lower = lower, .upper = upper};
        check(scene, ty_rsm_trace(scene, &map, 0, &at->map, NULL));
        check(scene, ty_shadow_hierarchy_create(context, &view->lights.lights[0], at->map, &at->lit));
    }
    const ty_airlight_def air = {
        .medium = at->medium, .maps = (const ty_shadow_hierarchy* const*)&at->lit, .count = at->lit != NULL ? 1 : 0};
    if (at->medium != NULL) check(scene, ty_airlight_create(scene, &air, &at->airlight));
    at->job = (ty_lpv_image_job){.scene = scene,
                                 .def = &at->def,
                                 .light = {&at->lattice, 1},
                                 .medium = at->medium,
                                 .airlight = at->airlight,
                                 .shadow_maps = (const ty_shadow_hierarchy* const*)&at->lit,
                                 .shadow_map_count = at->lit != NULL ? 1 : 0};
}

static void end_case(view_case* at) {
    ty_context* context = ty_scene_context(at->scene);
    ty_airlight_destroy(at->airlight);
    ty_shadow_hierarchy_destroy(at->lit);
    ty_rsm_destroy(context, at->map);
    ty_grid_medium_destroy(at->medium);
    ty_lattice_destroy(at->lattice);
    ty_scene_destroy(at->scene);
}

static ty_image* image_of(view_case* at, ty_lpv_stats* stats) {
    ty_image* image = NULL;
    ty_lpv_stats own = ty_default_lpv_stats();
    check(at->scene, ty_lpv_image(&at->job, &image, stats != NULL ? stats : &own));
    return image;
}

static const float* plane_of(const ty_image* image, const char* name) {
    const int32_t channel = ty_image_find_channel(image, name);
    assert_true(channel >= 0);
    return ty_image_plane_const(image, channel);
}

/* The same light in all cells: terms of one channel times 1, 2, 3. */
static void fill(ty_lattice* lattice, const float terms[TY_SH_TERMS]) {
    for (int c = 0; c < 3; ++c)
        for (int32_t t = 0; t < lattice->terms; ++t)
            for (size_t i = 0; i < lattice->cells; ++i) lattice->light[c][t][i] = (float)(c + 1) * terms[t];
}

/* ---- surfaces ---- */

static void plane_in_sun(void** state) {
    static const double low[3] = {-8, -8, -8};
    ty_scene* scene = make_scene(*state);
    look_from(scene, 0, 5, 0.01, 0, 0, 0, 60);
    add_floor(scene, 50, 0.8f);
    add_sun(scene, 1, -2, 0.5);
    view_case at;
    begin_case(&at, scene, low, 16, 8, 2);
    const double cosine = 2 / sqrt(1 + 4 + 0.25);
    for (int rays = 0; rays < 2; ++rays) {
        at.def.shadow_rays = rays != 0;
        ty_image* image = image_of(&at, NULL);
        const float *r = plane_of(image, "R"), *b = plane_of(image, "B"), *y = plane_of(image, "normal.Y");
        for (int i = 0; i < WIDE * HIGH; ++i) {
            assert_close(r[i], 3 * 0.8 * cosine / 3.14159265358979, 1e-5);
            assert_close(b[i], 1 * 0.8 * cosine / 3.14159265358979, 1e-5);
            assert_close(y[i], 1, 1e-6);
        }
        assert_close(plane_of(image, "depth.Z")[HIGH / 2 * WIDE + WIDE / 2], 5, 0.01);
        assert_close(plane_of(image, "transmittance.G")[0], 1, 0);
        ty_image_destroy(image);
    }
    end_case(&at);
}

/* Radiance L + D . w gives irradiance pi L - 2 pi / 3 D . n, and a third band has its part, too. */
static void lattice_on_surfaces(void** state) {
    static const double low[3] = {-8, -8, -8};
    for (int32_t bands = 2; bands <= 3; ++bands) {
        ty_scene* scene = make_scene(*state);
        look_from(scene, 0, 5, 0.01, 0, 0, 0, 60);
        add_floor(scene, 7, 0.5f);
        view_case at;
        begin_case(&at, scene, low, 16, 8, bands);
        const float terms[TY_SH_TERMS] = {1, -0.4f, 0.1f, 0.1f, 0.3f, 0.2f, -0.1f, 0.2f, -0.15f};
        fill(at.lattice, terms);
        const double pi = 3.14159265358979;
        const double third = bands == 3 ? pi / 4 * (-0.1 * 0.315391565 * -1 - 0.15 * -0.5 * 1.092548431) : 0;
        const double expected = pi * 0.282094792 + 2 * pi / 3 * 0.4 * 0.488602512 + third;
        ty_image* image = image_of(&at, NULL);
        assert_close(plane_of(image, "R")[HIGH / 2 * WIDE + WIDE / 2], 0.5 / pi * expected, 1e-5);
        assert_close(plane_of(image, "B")[HIGH / 2 * WIDE + WIDE / 2], 3 * 0.5 / pi * expected, 1e-5);
        ty_image_destroy(image);
        at.def.parts &= ~(uint32_t)TY_LPV_SURFACES;
        image = image_of(&at, NULL);
        assert_close(plane_of(image, "R")[HIGH / 2 * WIDE + WIDE / 2], 0, 0);
        ty_image_destroy(image);
        end_case(&at);
    }
}

/* ---- fog ---- */

static ty_medium_def fog_def(const double low[3], const double high[3], float g) {
    ty_medium_def def = box_medium(low, high, 0.3f, 0.1f);
    for (int c = 0; c < 3; ++c) def.g[c] = g;
    return def;
}

/* Radiance alike everywhere: albedo (L + g D . w)(1 - e^-tau) in front of what is dark. */
static void even_light_in_fog(void** state) {
    static const double low[3] = {-2, -2, -2}, high[3] = {2, 2, 2};
    const double steps[] = {0.3, 1, 5};
    for (int s = 0; s < 3; ++s) {
        ty_scene* scene = make_scene(*state);
        look_from(scene, 0, 0, 50, 0, 0, 0, 1e-3);
        const ty_medium_def fog = fog_def(low, high, 0.6f);
        check(scene, ty_scene_add_medium(scene, &fog));
        view_case at;
        begin_case(&at, scene, low, 4, 9, 2);
        const float terms[TY_SH_TERMS] = {2, 0.3f, 0.7f, 0.2f};
        fill(at.lattice, terms);
        at.def.step = steps[s];
        ty_image* image = image_of(&at, NULL);
        const double light = 2 * 0.282094792 + 0.6 * 0.7 * 0.488602512; /* towards +z */
        for (int i = 0; i < WIDE * HIGH; ++i) {
            assert_close(plane_of(image, "multiple.R")[i], 0.75 * light * -expm1(-1.6), 2e-5);
            assert_close(plane_of(image, "B")[i], 3 * 0.75 * light * -expm1(-1.6), 6e-5);
            assert_close(plane_of(image, "transmittance.G")[i], exp(-1.6), 1e-5);
            assert_close(plane_of(image, "albedo.G")[i], 0.75 * -expm1(-1.6), 1e-5);
        }
        ty_image_destroy(image);
        at.def.parts &= ~(uint32_t)TY_LPV_MARCH;
        image = image_of(&at, NULL);
        assert_close(plane_of(image, "multiple.R")[0], 0, 0);
        assert_close(plane_of(image, "transmittance.G")[0], exp(-1.6), 1e-5);
        ty_image_destroy(image);
        end_case(&at);
    }
}

/* The same where the medium is a grid, whose cells count; and what lies beyond the lattice is dark. */
static void even_light_in_voxels(void** state) {
    static const double low[3] = {-2, -2, -2}, high[3] = {2, 2, 2};
    ty_scene* scene = make_scene(*state);
    look_from(scene, 0, 0, 50, 0, 0, 0, 1e-3);
    ty_medium_def fog = fog_def(low, high, 0.6f);
    static float values[4 * 4 * 4];
    for (int i = 0; i < 64; ++i) values[i] = 1;
    ty_grid_def grid = ty_default_grid_def();
    grid.size[0] = grid.size[1] = grid.size[2] = 4;
    grid.values = values;
    check(scene, ty_grid_create(*state, &grid, &fog.density_grid));
    check(scene, ty_scene_add_medium(scene, &fog));
    view_case at;
    begin_case(&at, scene, low, 4, 8, 2);
    assert_true(ty_scene_get_view(scene)->media[0].heterogeneous);
    const float terms[TY_SH_TERMS] = {2, 0.3f, 0.7f, 0.2f};
    fill(at.lattice, terms);
    ty_image* image = image_of(&at, NULL);
    const double light = 2 * 0.282094792 + 0.6 * 0.7 * 0.488602512;
    assert_close(plane_of(image, "multiple.R")[7], 0.75 * light * -expm1(-1.6), 2e-5);
    assert_close(plane_of(image, "transmittance.G")[7], exp(-1.6), 1e-5);
    ty_image_destroy(image);
    end_case(&at);
    ty_grid_release(fog.density_grid);
}

/* ---- surfaces in fog ---- */

/* Balls and boxes over a floor, fog all around, light that rises along x and flows along y. */
static void begin_still(view_case* at, ty_context* context) {
    static const double low[3] = {-8, -1, -12}, fog_low[3] = {-80, -1, -80}, fog_high[3] = {80, 40, 80};
    ty_scene* scene = make_scene(context);
    look_from(scene, 0, 3, 10, 0, 2, 0, 50);
    add_floor(scene, 60, 0.6f);
    for (int i = 0; i < 5; ++i) {
        add_ball(scene, -5 + 2.5 * i, 1 + 0.7 * i, -4 + i, 0.5 + 0.1 * i);
        add_box(scene, 4 - 2 * i, 0, -7 + 0.8 * i, 0.4 + 0.3 * i, 0.5f);
    }
    add_sun(scene, -1, -2, -1);
    const ty_medium_def fog = box_medium(fog_low, fog_high, 0.06f, 0.01f);
    check(scene, ty_scene_add_medium(scene, &fog));
    begin_case(at, scene, low, 16, 16, 2);
    for (int c = 0; c < 3; ++c)
        for (size_t i = 0; i < at->lattice->cells; ++i) {
            at->lattice->light[c][0][i] = 0.2f + 0.1f * (float)(i % 16);
            at->lattice->light[c][1][i] = 0.1f;
        }
}

static void compare(const ty_image* a, const ty_image* b, double* rmse, double* largest) {
    const float *p = plane_of(a, "R"), *q = plane_of(b, "R");
    double sum = 0, mean = 0;
    *largest = 0;
    for (int i = 0; i < WIDE * HIGH; ++i) {
        const double off = fabs((double)(p[i] - q[i]));
        sum += off * off;
        mean += (double)q[i];
        *largest = fmax(*largest, off);
    }
    mean /= WIDE * HIGH;
    *rmse = sqrt(sum / (WIDE * HIGH)) / mean;
    *largest /= mean;
}

/* Media at half of the resolution, edges of surfaces included. */
static void half_resolution(void** state) {
    view_case at;
    double rmse, largest;
    ty_lpv_stats stats = ty_default_lpv_stats();
    begin_still(&at, *state);
    at.def.half_resolution_march = false;
    ty_image* full = image_of(&at, NULL);
    at.def.half_resolution_march = true;
    ty_image* half = image_of(&at, &stats);
    compare(half, full, &rmse, &largest);
    const double alone = (double)stats.marched / (WIDE * HIGH) - 0.25;
    printf("half of the resolution: relative RMSE %.5f, largest error %.5f of the mean, %.1f %% of pixels alone\n",
           rmse, largest, 100 * alone);
    assert_true(rmse < 0.01 && largest < 0.1 && alone < 0.05);
    ty_image_destroy(half);
    ty_image_destroy(full);
    end_case(&at);
}

/* A caller's arrays, taken from the traced image's channels, give the same image. */
static void views_of_callers(void** state) {
    view_case at;
    double rmse, largest;
    begin_still(&at, *state);
    ty_image* traced = image_of(&at, NULL);
    static float distance[WIDE * HIGH], normal[3 * WIDE * HIGH], albedo[3 * WIDE * HIGH], emission[3 * WIDE * HIGH];
    ty_lpv_view_def view = ty_default_lpv_view_def();
    view.distance = distance;
    view.normal = normal;
    view.albedo = albedo;
    view.emission = emission;
    const ty_camera_def camera = ty_scene_camera(at.scene);
    const ty_camera_view rays = ty_camera_get_view(&camera, WIDE, HIGH);
    for (int i = 0; i < WIDE * HIGH; ++i) {
        const ty_vec d = ty_camera_direction(&rays, (float)(i % WIDE) + 0.5f, (float)(i / WIDE) + 0.5f);
        const ty_ray ray = {{rays.origin.x, rays.origin.y, rays.origin.z}, {d.x, d.y, d.z}, INFINITY};
        ty_ray_hit hit;
        check(at.scene, ty_scene_trace(at.scene, &ray, 1, TY_RAYS_INCOHERENT, &hit));
        distance[i] = hit.surface >= 0 ? hit.distance : INFINITY;
        for (int c = 0; c < 3; ++c) {
            albedo[3 * i + c] = hit.surface == 0 ? 0.6f : 0.5f;
            normal[3 * i + c] = hit.normal[c];
            emission[3 * i + c] = 0;
        }
    }
    at.def.view = &view;
    ty_image* taken = image_of(&at, NULL);
    compare(taken, traced, &rmse, &largest);
    printf("caller's view against traced: relative RMSE %.6f, largest error %.6f\n", rmse, largest);
    assert_true(rmse < 2e-4 && largest < 0.01);
    ty_image_destroy(taken);
    /* Whatever is in them, no pixel is other than a number. */
    uint64_t seed = 1;
    const float odd[] = {NAN, INFINITY, -INFINITY, -1, 0, 1e-40f, 3e38f, -3e38f};
    for (int i = 0; i < WIDE * HIGH; ++i) {
        if (uniform(&seed) < 0.5) distance[i] = odd[(int)(8 * uniform(&seed))];
        for (int c = 0; c < 3; ++c) {
            if (uniform(&seed) < 0.5) normal[3 * i + c] = odd[(int)(8 * uniform(&seed))];
            if (uniform(&seed) < 0.5) albedo[3 * i + c] = odd[(int)(8 * uniform(&seed))];
            if (uniform(&seed) < 0.5) emission[3 * i + c] = odd[(int)(8 * uniform(&seed))];
        }
    }
    taken = image_of(&at, NULL);
    for (int32_t c = 0; c < ty_image_channel_count(taken); ++c)
        for (int i = 0; i < WIDE * HIGH; ++i) assert_true(isfinite(ty_image_plane_const(taken, c)[i]));
    ty_image_destroy(taken);
    ty_image_destroy(traced);
    end_case(&at);
}

static ty_scene* lit_fog(ty_context* context) {
    ty_scene* scene = make_scene(context);
    const ty_medium_def fog = box_medium((double[3]){-2, 0, -2}, (double[3]){2, 2, 2}, 0.3f, 0);
    check(scene, ty_scene_add_medium(scene, &fog));
    add_floor(scene, 2, 0.5f);
    add_box(scene, -0.5, 0, -0.5, 1, 0.6f);
    add_sun(scene, 0.3, -1, 0.2);
    look_from(scene, 0, 1, 6, 0, 1, 0, 40);
    check(scene, ty_scene_commit(scene));
    return scene;
}

/* Light does not refer to the scene that it was solved for: lookups work without it, and views of a scene like it. */
static void light_outlives_its_scene(void** state) {
    static const double lower[3] = {-2, 0, -2}, upper[3] = {2, 2, 2};
    static const int32_t size[3] = {3, 2, 3};
    double fluence[2][3 * 18];
    ty_image* images[2] = {NULL};
    ty_lpv* light = NULL;
    ty_lpv_def def = ty_default_lpv_def();
    def.resolution = 8;
    def.map_side = 64;
    def.shadow_side = 64;
    ty_scene* scene = lit_fog(*state);
    check(scene, ty_lpv_solve(scene, &def, &light, NULL));
    check(scene, ty_lpv_fluence(light, lower, upper, size, fluence[0]));
    check(scene, ty_lpv_view(light, scene, &def, &images[0], NULL));
    ty_scene_destroy(scene);
    scene = lit_fog(*state);
    check(scene, ty_lpv_fluence(light, lower, upper, size, fluence[1]));
    check(scene, ty_lpv_view(light, scene, &def, &images[1], NULL));
    assert_memory_equal(fluence[0], fluence[1], sizeof fluence[0]);
    assert_true(fluence[0][0] > 0);
    const size_t bytes = sizeof(float) * WIDE * HIGH;
    for (int32_t c = 0; c < 3; ++c)
        assert_memory_equal(ty_image_plane_const(images[0], c), ty_image_plane_const(images[1], c), bytes);
    for (int i = 0; i < 2; ++i) ty_image_destroy(images[i]);
    ty_lpv_destroy(light);
    ty_scene_destroy(scene);
}

/* ---- shadows ---- */

static void shadows(void** state) {
    view_case at;
    begin_still(&at, *state);
    at.def.parts = 0;
    at.job.medium = NULL;
    const ty_scene_view* view = ty_scene_get_view(at.scene);
    const ty_camera_def camera = ty_scene_camera(at.scene);
    const ty_camera_view rays = ty_camera_get_view(&camera, WIDE, HIGH);
    for (int asks = 0; asks < 2; ++asks) {
        at.def.shadow_rays = asks != 0;
        ty_lpv_stats stats = ty_default_lpv_stats();
        ty_image* image = image_of(&at, &stats);
        const float* r = plane_of(image, "R");
        int wrong = 0, dark = 0;
        double off = 0;
        for (int i = 0; i < WIDE * HIGH; ++i) {
            const ty_vec d = ty_camera_direction(&rays, (float)(i % WIDE) + 0.5f, (float)(i / WIDE) + 0.5f);
            ty_hit hit;
            if (!ty_accel_intersect(view->mesh, rays.origin, d, TY_FLOAT_MAX, &hit)) continue;
            ty_surface_point point;
            ty_surface_evaluate(&view->surfaces[hit.surface], &hit, d, &point);
            const ty_vec look = ty_scale(view->lights.lights[0].direction, -1);
            const double facing = fmax(0, (double)ty_dot(point.ns, look));
            const bool lit = !ty_accel_occluded(view->mesh, ty_hit_leave(&hit, point.ng), look, TY_FLOAT_MAX);
            const double expected = lit ? 3 * (double)point.albedo[0] * facing / 3.14159265358979 : 0;
            wrong += fabs((double)r[i] - expected) > 1e-4;
            off += fabs((double)r[i] - expected);
            dark += !lit;
        }
        printf("shadows by %s: %d of %d dark pixels, %d of %d others than by rays, mean error %.5f, %d rays\n",
               asks ? "maps and rays" : "maps", dark, WIDE * HIGH, wrong, WIDE * HIGH, off / (WIDE * HIGH),
               (int)stats.rays - WIDE * HIGH);
        assert_true(asks ? wrong <= 3 : wrong < WIDE * HIGH / 25);
        assert_true(asks ? stats.rays < WIDE * HIGH * 5 / 4 : stats.rays == WIDE * HIGH);
        ty_image_destroy(image);
    }
    end_case(&at);
}

/* ---- lookups ---- */

/* Lookups of images are those of single points, in nested lattices with closed links, too. */
static void lookups_agree(void** state) {
    uint64_t seed = 5;
    ty_lattice* lattices[2];
    for (int i = 0; i < 2; ++i) {
        const double half = i == 0 ? 4 : 8;
        const ty_grid_box box = {{-half, -half, -half}, {half, half, half}, {8, 8, 8}};
        assert_int_equal(ty_lattice_create(*state, &box, 3, &lattices[i]), TY_OK);
        lattices[i]->blocked = true;
        for (size_t cell = 0; cell < lattices[i]->cells; ++cell) {
            for (int c = 0; c < 3; ++c)
                for (int t = 0; t < 9; ++t)
                    lattices[i]->light[c][t][cell] = (float)uniform_in(&seed, t == 0 ? 1 : -0.2, t == 0 ? 3 : 0.2);
            const int32_t at[3] = {(int32_t)cell % 8, (int32_t)cell / 8 % 8, (int32_t)cell / 64};
            for (int32_t k = 0; k < TY_LPV_HALF_LINKS; ++k) {
                const int32_t step[3] = {k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1};
                bool inside = true;
                for (int a = 0; a < 3; ++a) inside = inside && at[a] + step[a] >= 0 && at[a] + step[a] < 8;
                if (!inside || uniform(&seed) < 0.8) continue;
                const size_t other = cell + (size_t)(step[0] + 8 * step[1] + 64 * step[2]);
                const uint8_t transmission = (uint8_t)(200 * uniform(&seed));
                lattices[i]->transmission[ty_lpv_link(step[0], step[1], step[2])][other] = transmission;
                lattices[i]->transmission[ty_lpv_link(-step[0], -step[1], -step[2])][cell] = transmission;
            }
        }
    }
    ty_packed_lattices look;
    assert_int_equal(ty_packed_lattices_create(*state, lattices, 2, NULL, &look), TY_OK);
    const ty_lpv_light_view view = {lattices, 2};
    for (int i = 0; i < 20000; ++i) {
        const ty_vec point = ty_vec_make((float)uniform_in(&seed, -9.5, 9.5), (float)uniform_in(&seed, -9.5, 9.5),
                                         (float)uniform_in(&seed, -9.5, 9.5));
        const ty_vec normal = random_unit(&seed);
        float fast[3], slow[3];
        ty_packed_irradiance(&look, point, normal, fast);
        ty_lpv_irradiance_at(&view, point, normal, slow);
        for (int c = 0; c < 3; ++c) assert_close(fast[c], slow[c], 2e-4);
    }
    ty_packed_lattices_destroy(*state, &look);
    ty_lattice_destroy(lattices[0]);
    ty_lattice_destroy(lattices[1]);
}

/* Of two halves of a lattice, one bright, and closed links in between: what lies in the dark one sees nothing. */
static void closed_links(void** state) {
    static const double low[3] = {-4, -4, -4}, high[3] = {4, 4, 4};
    for (int closed = 0; closed < 2; ++closed) {
        ty_scene* scene = make_scene(*state);
        look_from(scene, -0.4, 0, 50, -0.4, 0, 0, 1e-3);
        const ty_medium_def fog = fog_def(low, high, 0);
        check(scene, ty_scene_add_medium(scene, &fog));
        view_case at;
        begin_case(&at, scene, low, 8, 8, 2);
        for (size_t i = 0; i < at.lattice->cells; ++i) {
            at.lattice->light[0][0][i] = i % 8 >= 4 ? 1 : 0;
            if (closed == 0 || (i % 8 != 3 && i % 8 != 4)) continue;
            for (int32_t y = -1; y <= 1; ++y)
                for (int32_t z = -1; z <= 1; ++z)
                    at.lattice->transmission[ty_lpv_link(i % 8 == 3 ? -1 : 1, y, z)][i] = 0;
        }
        at.lattice->blocked = closed != 0;
        ty_image* image = image_of(&at, NULL);
        const double share = closed != 0 ? 0 : 0.1;
        assert_close(plane_of(image, "multiple.R")[0], share * 0.75 * 0.282094792 * -expm1(-3.2), 3e-4);
        ty_image_destroy(image);
        end_case(&at);
    }
}

/* ---- the rest ---- */

/* The image is the same for any number of threads, and for rays per pixel close to what one gives. */
static void threads_and_samples(void** state) {
    (void)state;
    ty_image* images[3];
    ty_context* contexts[3];
    view_case cases[3];
    double rmse, largest;
    for (int i = 0; i < 3; ++i) {
        contexts[i] = make_context(i == 0 ? 1 : 2);
        begin_still(&cases[i], contexts[i]);
        cases[i].def.spp = i == 2 ? 4 : 1;
        images[i] = image_of(&cases[i], NULL);
    }
    for (int32_t c = 0; c < ty_image_channel_count(images[0]); ++c)
        assert_memory_equal(ty_image_plane_const(images[0], c), ty_image_plane_const(images[1], c),
                            WIDE * HIGH * sizeof(float));
    compare(images[2], images[0], &rmse, &largest);
    assert_true(rmse > 0.001 && rmse < 0.2);
    for (int i = 0; i < 3; ++i) {
        ty_image_destroy(images[i]);
        end_case(&cases[i]);
        ty_context_destroy(contexts[i]);
    }
}

typedef struct told {
    int calls, until;
    double fraction;
} told;

static bool listen(void* user, const ty_progress* progress) {
    told* so_far = user;
    assert_true(progress->fraction >= so_far->fraction && progress->fraction <= 1);
    so_far->fraction = progress->fraction;
    return ++so_far->calls != so_far->until;
}

static void progress_and_cancelling(void** state) {
    view_case at;
    begin_still(&at, *state);
    told so_far = {0};
    at.def.spp = 2; /* two parts each */
    at.def.progress = listen;
    at.def.progress_user = &so_far;
    ty_image_destroy(image_of(&at, NULL));
    const int calls = so_far.calls;
    assert_true(calls >= 3);
    for (int until = 1; until <= 3; ++until) {
        so_far = (told){.until = until};
        ty_image* image = (ty_image*)&at;
        ty_lpv_stats stats = ty_default_lpv_stats();
        assert_int_equal(ty_lpv_image(&at.job, &image, &stats), TY_CANCELLED);
        assert_null(image);
        assert_int_equal(so_far.calls, until);
    }
    end_case(&at);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(plane_in_sun),
        cmocka_unit_test(lattice_on_surfaces),
        cmocka_unit_test(even_light_in_fog),
        cmocka_unit_test(even_light_in_voxels),
        cmocka_unit_test(half_resolution),
        cmocka_unit_test(views_of_callers),
        cmocka_unit_test(light_outlives_its_scene),
        cmocka_unit_test(shadows),
        cmocka_unit_test(lookups_agree),
        cmocka_unit_test(closed_links),
        cmocka_unit_test(threads_and_samples),
        cmocka_unit_test(progress_and_cancelling),
    };
    return cmocka_run_group_tests(tests, start_context, stop_context);
}
