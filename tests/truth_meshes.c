/* Meshes: as lights against the shapes that they stand for, textures, alpha, and white furnaces. */
#include "truth_cases.h"
#include "triangle_maker.h"

enum { ITEMS = 64 };

static const double floor_albedo = 0.6;

static void add_mesh(ty_scene* scene, const ty_mesh_def* def) {
    must(ty_scene_context(scene), ty_scene_add_mesh(scene, def));
}

static ty_scene* floor_scene(ty_context* context) {
    static const double center[3] = {0, 0, 0}, u[3] = {0, 0, 1}, v[3] = {1, 0, 0};
    ty_scene* scene = new_scene(context);
    const ty_shape_def board = square_shape(center, u, v, 3, floor_albedo);
    add_shape(scene, &board);
    return scene;
}

static estimate seen_within(ty_scene* scene, const double from[3], const double way[3], int32_t spp,
                            int32_t max_depth) {
    double rays[6 * ITEMS], radiance[3 * ITEMS];
    for (int i = 0; i < ITEMS; ++i) {
        memcpy(rays + 6 * i, from, 3 * sizeof *from);
        memcpy(rays + 6 * i + 3, way, 3 * sizeof *way);
    }
    radiance_along(scene, ITEMS, rays, spp, max_depth, radiance, NULL);
    return estimate_of(radiance, ITEMS, 3);
}

static estimate seen_along(ty_scene* scene, const double from[3], const double way[3], int32_t spp) {
    return seen_within(scene, from, way, spp, 0);
}

/* Irradiance at (x, 0, z). */
static estimate irradiance_at(ty_scene* scene, double x, double z) {
    const double from[3] = {x - 0.1, 0.25, z + 0.05}, way[3] = {0.1, -0.25, -0.05};
    const estimate seen = seen_along(scene, from, way, fewer(1 << 13, 2));
    return (estimate){seen.mean * pi / floor_albedo, seen.error * pi / floor_albedo};
}

/* ---- glowing meshes are glowing shapes ---- */

typedef enum body { QUAD, BOX, BALL } body;

static const double corner[3] = {-0.5, 0.9, -0.3}, edge_u[3] = {1, 0.2, 0.1}, edge_v[3] = {0.2, 0.1, 1.5};
static const double low[3] = {-0.3, 0.5, -0.2}, high[3] = {0.6, 1.2, 0.7}, middle[3] = {0.2, 1.1, -0.1};

static ty_shape_def shape_of(body kind) {
    ty_shape_def def = ty_default_shape_def();
    def.kind = kind == QUAD ? TY_SHAPE_QUAD : kind == BOX ? TY_SHAPE_BOX : TY_SHAPE_SPHERE;
    memcpy(def.origin, kind == QUAD ? corner : kind == BOX ? low : middle, sizeof def.origin);
    memcpy(def.u, kind == QUAD ? edge_u : high, sizeof def.u);
    memcpy(def.v, edge_v, sizeof def.v);
    def.radius = 0.4;
    gray(def.albedo, 0.3);
    gray(def.emission, 4);
    return def;
}

static made_mesh mesh_of(body kind) {
    made_mesh mesh = made_nothing();
    if (kind == QUAD) made_add_quad(&mesh, corner, edge_u, edge_v);
    if (kind == BOX) made_add_box(&mesh, low, high);
    if (kind == BALL) made_add_sphere(&mesh, middle, 0.4 * 1.0004, 32); /* of equal area */
    return mesh;
}

static ty_scene* lit_scene(ty_context* context, body kind, bool meshed, bool foggy) {
    ty_scene* scene = floor_scene(context);
    const ty_shape_def shape = shape_of(kind);
    made_mesh mesh = mesh_of(kind);
    ty_mesh_def def = made_def(&mesh);
    gray(def.material.albedo, 0.3);
    gray(def.material.emission, 4);
    if (meshed)
        add_mesh(scene, &def);
    else
        add_shape(scene, &shape);
    const ty_medium_def fog = medium_cube(2.5, 0.4, 0.1, 0.3);
    if (foggy) add_medium(scene, &fog);
    commit(scene);
    made_free(&mesh);
    return scene;
}

static void meshes_are_their_bodies(void** state) {
    static const char* const names[] = {"quad", "box", "ball"};
    static const double from[3] = {-3, 0.3, 0.3}, way[3] = {1, 0.02, -0.1};
    for (int kind = QUAD; kind <= BALL; ++kind)
        for (int foggy = in_full() ? 0 : 1; foggy < 2; ++foggy) {
            ty_scene* shaped = lit_scene(*state, (body)kind, false, foggy);
            ty_scene* meshed = lit_scene(*state, (body)kind, true, foggy);
            char name[64];
            snprintf(name, sizeof name, "mesh of a %s, %s, floor", names[kind], foggy ? "fog" : "clear");
            assert_close(name, irradiance_at(meshed, -0.8, 0.4), irradiance_at(shaped, -0.8, 0.4).mean, 0.006);
            snprintf(name, sizeof name, "mesh of a %s, fog around it", names[kind]);
            if (foggy)
                assert_close(name, seen_along(meshed, from, way, 1 << 12), seen_along(shaped, from, way, 1 << 12).mean,
                             0.015);
            ty_scene_destroy(shaped);
            ty_scene_destroy(meshed);
        }
}

/* ---- boards over the floor ---- */

/* A board two wide at a height above the floor, facing down, u along x and v along z. */
static made_mesh board_mesh(double height, double x, double z) {
    const double at[3] = {x - 1, height, z - 1}, u[3] = {2, 0, 0}, v[3] = {0, 0, 2};
    made_mesh mesh = made_nothing();
    made_add_quad(&mesh, at, u, v);
    return mesh;
}

/* Irradiance at (x, 0, z) from the board's rectangle [u0, u1] x [v0, v1] of texture coordinates, by midpoints. */
static double rectangle_irradiance(double height, double u0, double u1, double v0, double v1, double x, double z) {
    enum { STEPS = 200 };
    double sum = 0;
    for (int i = 0; i < STEPS; ++i)
        for (int j = 0; j < STEPS; ++j) {
            const double dx = 2 * (u0 + (u1 - u0) * (i + 0.5) / STEPS) - 1 - x;
            const double dz = 2 * (v0 + (v1 - v0) * (j + 0.5) / STEPS) - 1 - z;
            const double d2 = dx * dx + dz * dz + height * height;
            sum += height * height / (d2 * d2);
        }
    return sum * 4 * (u1 - u0) * (v1 - v0) / (STEPS * STEPS);
}

static ty_texture* texture_of(ty_context* context, const ty_image* image, bool nearest) {
    ty_texture_def def = ty_default_texture_def();
    ty_texture* texture = NULL;
    def.image = image;
    def.nearest = nearest;
    def.wrap[0] = def.wrap[1] = TY_WRAP_CLAMP;
    must(context, ty_texture_create(context, &def, &texture));
    return texture;
}

/* width x height gray texels with alpha. */
static ty_texture* texels_of(ty_context* context, const float* values, const float* alphas, int32_t width,
                             int32_t height) {
    static const char* const names[] = {"R", "G", "B", "A"};
    ty_image* image = NULL;
    must(context, ty_image_create(context, width, height, 4, names, &image));
    for (int c = 0; c < 4; ++c)
        for (int i = 0; i < width * height; ++i)
            ty_image_plane(image, c)[i] = c < 3 ? values[i] : alphas != NULL ? alphas[i] : 1;
    ty_texture* texture = texture_of(context, image, true);
    ty_image_destroy(image);
    return texture;
}

/* A coarse picture that glows: the sum over its texels. */
static void emissive_textures_light_the_scene(void** state) {
    static const float values[12] = {5, 0, 2, 0, 0, 3, 0, 1, 0.5f, 0, 0, 8};
    made_mesh mesh = board_mesh(1, 0, 0);
    ty_mesh_def def = made_def(&mesh);
    def.material.emission_texture = texels_of(*state, values, NULL, 4, 3);
    gray(def.material.emission, 2);
    gray(def.material.albedo, 0);
    ty_scene* scene = floor_scene(*state);
    add_mesh(scene, &def);
    commit(scene);
    double expected = 0;
    for (int i = 0; i < 12; ++i)
        expected += 2 * (double)values[i] *
                    rectangle_irradiance(1, i % 4 / 4.0, (i % 4 + 1) / 4.0, i / 4 / 3.0, (i / 4 + 1) / 3.0, 0.3, -0.4);
    assert_close("glowing picture", irradiance_at(scene, 0.3, -0.4), expected, 0.005);
    ty_scene_destroy(scene);
    ty_texture_release(def.material.emission_texture);
    made_free(&mesh);
}

/* One bright texel of very many is seen, whoever samples it. */
static void a_lonely_texel_is_sampled(void** state) {
    enum { SIDE = 512, LONELY = 200 };
    float* values = calloc((size_t)SIDE * SIDE, sizeof *values);
    assert_non_null(values);
    values[LONELY * SIDE + LONELY] = 7;
    made_mesh mesh = board_mesh(1, 0, 0);
    ty_mesh_def def = made_def(&mesh);
    def.material.emission_texture = texels_of(*state, values, NULL, SIDE, SIDE);
    gray(def.material.emission, 1);
    ty_scene* scene = new_scene(*state);
    add_mesh(scene, &def);
    commit(scene);
    const double at = 2 * (LONELY + 0.5) / SIDE - 1, up[3] = {0, 1, 0};
    const double under[3] = {at, 0, at}, beside[3] = {at + 0.01, 0, at};
    assert_close("lonely texel", seen_along(scene, under, up, 1), 7, 1e-5);
    assert_true(seen_along(scene, beside, up, 1).mean == 0);
    ty_scene_destroy(scene);
    ty_texture_release(def.material.emission_texture);
    made_free(&mesh);
    free(values);
}

/* Glowing boards light what is in front of them, or both sides. */
static void boards_light_one_side_or_both(void** state) {
    static const double x[3] = {1, 0, 0}, y[3] = {0, 1, 0}, back[3] = {0, 0, -2}, front[3] = {0, 0, 2};
    static const double at[3] = {-1, -1, 0}, u[3] = {2, 0, 0}, v[3] = {0, 2, 0}, forth[3] = {0, 0, 1};
    made_mesh mesh = made_nothing();
    made_add_quad(&mesh, at, u, v);
    estimate seen[2][2];
    for (int both = 0; both < 2; ++both) {
        ty_scene* scene = new_scene(*state);
        ty_mesh_def def = made_def(&mesh);
        const ty_shape_def walls[2] = {square_shape(back, x, y, 3, 0.5), square_shape(front, x, y, 3, 0.5)};
        gray(def.material.albedo, 0);
        gray(def.material.emission, 2);
        def.material.double_sided = both;
        add_mesh(scene, &def);
        add_shape(scene, &walls[0]);
        add_shape(scene, &walls[1]);
        commit(scene);
        const double from[3] = {0.2, 0.1, 1}, from_back[3] = {0.2, 0.1, -1}, backwards[3] = {0, 0, -1};
        seen[both][0] = seen_within(scene, from, forth, 1 << 12, 1);
        seen[both][1] = seen_within(scene, from_back, backwards, 1 << 12, 1);
        const double towards[3] = {0.2, 0.1, -1.5};
        assert_close("the board from behind", (estimate){1 + seen_along(scene, towards, forth, 4).mean, 0},
                     both ? 3 : 1, 1e-6);
        ty_scene_destroy(scene);
    }
    /* A square of half side 1 at distance 2 sees all its light on the middle axis; here a little beside. */
    double expected = 0;
    for (int i = 0; i < 200 * 200; ++i) {
        const double dx = (i % 200 + 0.5) / 100 - 1 - 0.2, dy = (i / 200 + 0.5) / 100 - 1 - 0.1;
        const double d2 = dx * dx + dy * dy + 4;
        expected += 4 / (d2 * d2) / 1e4;
    }
    expected *= 2 * 0.5 / pi;
    assert_close("wall in front, one side", seen[0][0], expected, 0.004);
    assert_close("wall in front, both sides", seen[1][0], expected, 0.004);
    assert_close("wall behind, both sides", seen[1][1], expected, 0.004);
    assert_true(seen[0][1].mean == 0);
    made_free(&mesh);
}

/* ---- what surfaces reflect ---- */

/* Texels and vertex colours of a floor under uniform light, and a texture placed by a map. */
static void textures_lie_where_they_should(void** state) {
    static const float values[4] = {0.2f, 0.9f, 0.5f, 0.7f};
    float colors[24];
    made_mesh mesh = board_mesh(0, 0, 0);
    for (int i = 0; i < 24; ++i) colors[i] = i % 4 == 0 ? (mesh.positions[3 * (i / 4)] > 0 ? 1 : 0.5f) : 0.25f;
    ty_mesh_def def = made_def(&mesh);
    def.material.albedo_texture = texels_of(*state, values, NULL, 2, 2);
    def.colors = colors;
    gray(def.material.albedo, 0.8);
    static const float swapped[6] = {0, 1, 0, 1, 0, 0};
    memcpy(def.material.albedo_map, swapped, sizeof swapped);
    ty_scene* scene = new_scene(*state);
    add_mesh(scene, &def);
    const ty_light_def sky = light_of(TY_LIGHT_ENVIRONMENT, 3);
    add_light(scene, &sky);
    commit(scene);
    for (int i = 0; i < 4; ++i) {
        const double x = i % 2 ? 0.4 : -0.6, z = i / 2 ? 0.3 : -0.7;
        const double from[3] = {x, -1, z}, up[3] = {0, 1, 0};
        const double texel = (double)values[2 * (x > 0) + (z > 0)], color = 0.75 + 0.25 * x;
        assert_close("painted floor", seen_along(scene, from, up, 64), 3 * 0.8 * texel * color, 1e-4);
    }
    ty_scene_destroy(scene);
    ty_texture_release(def.material.albedo_texture);
    made_free(&mesh);
}

/* ---- alpha ---- */

static const float fence[8] = {1, 0, 0, 1, 0, 0, 0, 1}; /* 3 of 8 are there */

static ty_material_def fence_material(ty_context* context, ty_alpha_mode mode, ty_texture** texture) {
    ty_material_def material = ty_default_material_def();
    *texture = NULL;
    if (mode == TY_ALPHA_MASK) *texture = texels_of(context, fence, fence, 4, 2);
    material.albedo_texture = *texture;
    material.alpha_mode = mode;
    if (mode == TY_ALPHA_BLEND) material.alpha = 0.35f;
    gray(material.albedo, 0);
    return material;
}

/* The mean over what the board shades of the sun from above; of many rays, as one ray always meets the same. */
static void alpha_shadows_are_right(void** state) {
    for (int mode = TY_ALPHA_MASK; mode <= TY_ALPHA_BLEND; ++mode) {
        enum { RAYS = 1 << 17 };
        made_mesh mesh = board_mesh(1, 0, 0);
        ty_mesh_def def = made_def(&mesh);
        ty_texture* texture;
        def.material = fence_material(*state, (ty_alpha_mode)mode, &texture);
        ty_scene* scene = floor_scene(*state);
        ty_light_def sun = light_of(TY_LIGHT_DIRECTIONAL, 3);
        set3(sun.direction, 0, -1, 0);
        add_mesh(scene, &def);
        add_light(scene, &sun);
        commit(scene);
        double* rays = new_numbers(6 * RAYS);
        double* radiance = new_numbers(3 * RAYS);
        for (int64_t i = 0; i < RAYS; ++i) {
            double x[4];
            even_point(i, x);
            set3(rays + 6 * i, 2 * x[0] - 1, 0.5, 2 * x[1] - 1);
            set3(rays + 6 * i + 3, 0, -1, 0);
        }
        radiance_along(scene, RAYS, rays, 1, 0, radiance, NULL);
        const double open = mode == TY_ALPHA_MASK ? 5.0 / 8 : 0.65;
        assert_close(mode == TY_ALPHA_MASK ? "shadow of a fence" : "shadow of a veil", estimate_of(radiance, RAYS, 3),
                     open * 3 * floor_albedo / pi, 0.01);
        free(rays);
        free(radiance);
        ty_scene_destroy(scene);
        ty_texture_release(texture);
        made_free(&mesh);
    }
}

/* Holes do not emit: light sampling and rays that meet the board agree. */
static void emissive_fences_are_right(void** state) {
    for (int mode = TY_ALPHA_MASK; mode <= TY_ALPHA_BLEND; ++mode) {
        made_mesh mesh = board_mesh(1, 0, 0);
        ty_mesh_def def = made_def(&mesh);
        ty_texture* texture;
        def.material = fence_material(*state, (ty_alpha_mode)mode, &texture);
        gray(def.material.emission, 3);
        ty_scene* scene = floor_scene(*state);
        add_mesh(scene, &def);
        commit(scene);
        double expected = 0;
        for (int i = 0; i < 8; ++i)
            expected +=
                3 * (mode == TY_ALPHA_MASK ? (double)fence[i] : 0.35) *
                rectangle_irradiance(1, i % 4 / 4.0, (i % 4 + 1) / 4.0, i / 4 / 2.0, (i / 4 + 1) / 2.0, 0.2, 0.3);
        assert_close(mode == TY_ALPHA_MASK ? "glowing fence" : "glowing veil", irradiance_at(scene, 0.2, 0.3), expected,
                     0.005);
        ty_scene_destroy(scene);
        ty_texture_release(texture);
        made_free(&mesh);
    }
}

/* ---- white furnaces ---- */

static const float white[3] = {1, 1, 1};

static double furnace_off(ty_context* context, const char* name, const made_mesh* mesh, bool smooth, bool map,
                          int32_t spp) {
    ty_scene* scene = new_scene(context);
    ty_mesh_def def = made_def(mesh);
    gray(def.material.albedo, 1);
    if (smooth) def.normals = mesh->normals;
    add_mesh(scene, &def);
    add_furnace_light(scene, white, map);
    set_camera(scene, 1.5, 2, 4, 20);
    commit(scene);
    if (!smooth) assert_furnace(name, scene, white, 24, spp);
    ty_image* image = render(scene, 24, spp, 7);
    const double off = image_mean(image, 0).mean - 1;
    ty_image_destroy(image);
    ty_scene_destroy(scene);
    return off;
}

/* Flat triangles keep all light, in niches as well. */
static void flat_meshes_are_white(void** state) {
    static const double zero[3] = {0, 0, 0}, arm_low[3] = {0.1, -0.6, -0.6}, arm_high[3] = {0.9, 0, 0.9};
    made_mesh mesh = made_nothing();
    made_add_sphere(&mesh, zero, 0.6, 4);
    made_add_box(&mesh, arm_low, arm_high);
    furnace_off(*state, "flat mesh, constant", &mesh, false, false, 64);
    furnace_off(*state, "flat mesh, map", &mesh, false, true, 256);
    made_free(&mesh);
}

/* Smoothed normals lose a little, the less the finer the mesh: light whose way is above the smooth horizon but below
 * that of the face. */
static void smooth_meshes_are_white(void** state) {
    static const double zero[3] = {0, 0, 0};
    static const int fineness[3] = {2, 6, 24};
    static const double most[3] = {0.1, 0.03, 0.005};
    for (int i = 0; i < 3; ++i) {
        made_mesh mesh = made_nothing();
        made_add_sphere(&mesh, zero, 1, fineness[i]);
        const double off = furnace_off(*state, "smooth mesh", &mesh, true, false, 256);
        printf("smooth ball of %d triangles: %+.3f%%\n", (int)mesh.triangles, 100 * off);
        assert_true(off < 0.002 && off > -most[i]);
        made_free(&mesh);
    }
}

/* A closed room whose walls glow by 1 and reflect half: radiance 2 everywhere. */
static void a_closed_room_is_white(void** state) {
    static const double room_low[3] = {-2, -1, -3}, room_high[3] = {1, 2, 2};
    made_mesh mesh = made_nothing();
    made_add_box(&mesh, room_low, room_high);
    made_turn(&mesh, 0);
    ty_mesh_def def = made_def(&mesh);
    gray(def.material.albedo, 0.5);
    gray(def.material.emission, 1);
    ty_scene* scene = new_scene(*state);
    add_mesh(scene, &def);
    commit(scene);
    static const double from[3] = {0.3, 0.4, -0.5}, way[3] = {0.3, -0.7, 0.4};
    assert_close("closed room", seen_along(scene, from, way, 1 << 12), 2, 0.002);
    ty_scene_destroy(scene);
    made_free(&mesh);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(meshes_are_their_bodies),        cmocka_unit_test(emissive_textures_light_the_scene),
        cmocka_unit_test(a_lonely_texel_is_sampled),      cmocka_unit_test(boards_light_one_side_or_both),
        cmocka_unit_test(textures_lie_where_they_should), cmocka_unit_test(alpha_shadows_are_right),
        cmocka_unit_test(emissive_fences_are_right),      cmocka_unit_test(flat_meshes_are_white),
        cmocka_unit_test(smooth_meshes_are_white),        cmocka_unit_test(a_closed_room_is_white),
    };
    return cmocka_run_group_tests(tests, truth_start, truth_stop);
}
