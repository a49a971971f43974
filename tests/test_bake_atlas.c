/* Lightmaps: which texels count and where they lie, and what is refused. */
#include "atlas_maker.h"

#include "bake/atlas/atlas.h"

static const double all[2] = {0, 1};

/* Texels that a chart covers whole are at the surface's places of their middles. */
static void texels_lie_on_the_surface(void** state) {
    mapped_mesh mesh = mapped_nothing();
    const double x[2] = {1, 3}, y[2] = {-1, 3}, u[2] = {0.25, 0.75}, v[2] = {0.25, 0.75};
    mapped_quad(&mesh, x, y, 2, u, v);
    ty_scene* scene = mapped_scene(*state, &mesh, false, true);
    const ty_atlas_def def = sized(64);
    ty_atlas* atlas = mapped_atlas(scene, &def);
    int64_t count;
    const ty_bake_receiver* receivers = ty_atlas_receivers(atlas, &count);
    assert_int_equal(ty_atlas_width(atlas), 64);
    assert_int_equal(ty_atlas_height(atlas), 64);
    assert_int_equal(count, 32 * 32);
    for (int64_t i = 0; i < count; ++i) {
        const double column = (double)(i % 32) + 0.5, row = (double)(i / 32) + 0.5;
        assert_close((double)receivers[i].position[0], 1 + column / 16, 1.0 / 16 / 16 + 1e-6); /* on the diagonal */
        assert_close((double)receivers[i].position[1], -1 + row / 8, 1.0 / 8 / 16 + 1e-6);
        assert_close((double)receivers[i].position[2], 2, 1e-6);
        for (int a = 0; a < 3; ++a) {
            assert_close((double)receivers[i].normal[a], a == 2, 1e-6);
            assert_close((double)receivers[i].face[a], a == 2, 1e-6);
        }
    }
    assert_close((double)receivers[5].position[0], 1 + 5.5 / 16, 1e-6);
    assert_close((double)receivers[5].position[1], -1 + 0.5 / 8, 1e-6);
    /* margins as of rays that hit there */
    const ty_ray ray = {.origin = {2.9f, -0.9f, 5}, .direction = {0, 0, -1}, .far = 10};
    ty_ray_hit hit;
    assert_int_equal(ty_scene_trace(scene, &ray, 1, TY_RAYS_INCOHERENT, &hit), TY_OK);
    assert_true(hit.margin > 0 && receivers[0].margin == hit.margin);
    ty_atlas_destroy(atlas);
    ty_scene_destroy(scene);
    mapped_free(&mesh);
}

/* Normals are between those of corners, but on the side of the face. */
static void normals_are_interpolated(void** state) {
    mapped_mesh mesh = mapped_nothing();
    mapped_quad(&mesh, all, all, 0, all, all);
    for (int i = 0; i < 4; ++i) {
        const float tilt = mesh.positions[3 * i] > 0 ? 0.6f : -0.6f;
        mesh.normals[3 * i] = -tilt; /* turned away: they count the other way round */
        mesh.normals[3 * i + 2] = -0.8f;
    }
    ty_scene* scene = mapped_scene(*state, &mesh, true, true);
    const ty_atlas_def def = sized(8);
    ty_atlas* atlas = mapped_atlas(scene, &def);
    int64_t count;
    const ty_bake_receiver* receivers = ty_atlas_receivers(atlas, &count);
    assert_int_equal(count, 64);
    for (int64_t i = 0; i < count; ++i) {
        const double tilt = 1.2 * (double)receivers[i].position[0] - 0.6, length = hypot(tilt, 0.8);
        assert_close((double)receivers[i].normal[0], tilt / length, 1e-5);
        assert_close((double)receivers[i].normal[2], 0.8 / length, 1e-5);
        assert_close((double)receivers[i].face[2], 1, 1e-6);
    }
    ty_atlas_destroy(atlas);
    ty_scene_destroy(scene);
    mapped_free(&mesh);
}

static bool inside(const float* uv, double x, double y) {
    int signs = 0;
    for (int i = 0; i < 3; ++i) {
        const float *a = uv + 2 * i, *b = uv + 2 * ((i + 1) % 3);
        const double cross = (double)(b[0] - a[0]) * (y - (double)a[1]) - (double)(b[1] - a[1]) * (x - (double)a[0]);
        signs += cross > 0 ? 1 : -1;
    }
    return signs == 3 || signs == -3;
}

/* Random triangles against points strewn over texels. */
static void texels_that_are_touched_count(void** state) {
    enum { SIDE = 16, POINTS = 40 };
    uint64_t random = 7;
    for (int trial = 0; trial < 60; ++trial) {
        mapped_mesh mesh = mapped_nothing();
        for (uint32_t i = 0; i < 3; ++i) {
            const double u = uniform(&random), v = uniform(&random);
            mapped_vertex(&mesh, 2 * u, 2 * v, 0, u, v); /* positions tell coordinates */
        }
        mapped_triangle(&mesh, 0, 1, 2);
        ty_scene* scene = mapped_scene(*state, &mesh, false, true);
        const ty_atlas_def def = sized(SIDE);
        ty_atlas* atlas = mapped_atlas(scene, &def);
        for (int texel = 0; texel < SIDE * SIDE; ++texel) {
            int points = 0;
            for (int p = 0; p < POINTS * POINTS; ++p)
                points += inside(mesh.uv, (texel % SIDE + (p % POINTS + 0.5) / POINTS) / SIDE,
                                 (texel / SIDE + (p / POINTS + 0.5) / POINTS) / SIDE);
            const int32_t i = atlas->receiver[texel];
            if (points > 1) assert_true(i >= 0);
            if (i < 0) continue;
            const bool middle = inside(mesh.uv, (texel % SIDE + 0.5) / SIDE, (texel / SIDE + 0.5) / SIDE);
            if (middle) assert_true(atlas->coverage[i] == 1);
            if (!middle) assert_close((double)atlas->coverage[i], (double)points / (POINTS * POINTS), 0.03);
            const float* at = atlas->receivers[i].position;
            if (fabs((double)(mesh.uv[0] - mesh.uv[2])) > 1e-2) {
                assert_true(inside(mesh.uv, (double)at[0] / 2, (double)at[1] / 2));
                const double away =
                    hypot((double)at[0] / 2 * SIDE - texel % SIDE - 0.5, (double)at[1] / 2 * SIDE - texel / SIDE - 0.5);
                assert_true(away < sqrt(0.5) + 1.0 / 16 + 1e-3);
                if (middle) assert_true(away < 1.0 / 16 + 1e-3);
            }
        }
        ty_atlas_destroy(atlas);
        ty_scene_destroy(scene);
        mapped_free(&mesh);
    }
}

/* The triangle that covers a middle has the texel, else the one that covers more of it. */
static void each_texel_has_one_triangle(void** state) {
    mapped_mesh mesh = mapped_nothing();
    mapped_vertex(&mesh, 0, 0, 0, 1.4 / 4, 0);
    mapped_vertex(&mesh, 0, 1, 0, 1.4 / 4, 1);
    mapped_vertex(&mesh, 0.5, 0, 0, 0, 0.5);
    mapped_vertex(&mesh, 1, 0, 0, 1.55 / 4, 0);
    mapped_vertex(&mesh, 1, 1, 0, 1.55 / 4, 1);
    mapped_vertex(&mesh, 1.5, 0, 0, 1, 0.5);
    mapped_triangle(&mesh, 0, 1, 2);
    mapped_triangle(&mesh, 3, 4, 5);
    ty_scene* scene = mapped_scene(*state, &mesh, false, true);
    const ty_atlas_def def = sized(4);
    ty_atlas* atlas = mapped_atlas(scene, &def);
    static const int owner[4] = {0, 1, 1, 1};
    static const double coverage[4] = {1, 0.45, 1, 1 / 2.45};
    for (int x = 0; x < 4; ++x) {
        const int32_t i = atlas->receiver[4 + x];
        assert_true(i >= 0);
        assert_int_equal((int)atlas->receivers[i].position[0], owner[x]);
        assert_close((double)atlas->coverage[i], coverage[x], 0.01);
    }
    ty_atlas_destroy(atlas);
    ty_scene_destroy(scene);
    mapped_free(&mesh);
}

static void sizes_follow_the_density(void** state) {
    mapped_mesh mesh = mapped_nothing();
    const double x[2] = {0, 2}, y[2] = {0, 3}, u[2] = {0, 0.5};
    mapped_quad(&mesh, x, y, 0, u, all);
    ty_scene* scene = mapped_scene(*state, &mesh, false, true);
    ty_atlas_def def = ty_default_atlas_def();
    ty_atlas_size size;
    assert_int_equal(ty_atlas_estimate(scene, 0, NULL, &def, &size), TY_OK);
    assert_int_equal(size.width, 28); /* sqrt(6 * 64 / 0.5) = 27.7 */
    assert_int_equal(size.height, 28);
    assert_true(size.texels >= 28 * 14 && size.texels < 28 * 28);
    def.height = 64;
    assert_int_equal(ty_atlas_estimate(scene, 0, NULL, &def, &size), TY_OK);
    assert_int_equal(size.width, 12);
    def.height = 0;
    def.density = 1e-3;
    assert_int_equal(ty_atlas_estimate(scene, 0, NULL, &def, &size), TY_OK);
    assert_int_equal(size.width, 4);
    def.density = 1e12;
    assert_int_equal(ty_atlas_estimate(scene, 0, NULL, &def, &size), TY_OK);
    assert_int_equal(size.width, 4096);
    assert_true(size.bytes > 4096.0 * 4096 * 29 * 4);
    ty_scene_destroy(scene);
    mapped_free(&mesh);
}

static void assert_refused(ty_context* context, const mapped_mesh* mesh, bool mapped, const char* words) {
    ty_scene* scene = mapped_scene(context, mesh, false, mapped);
    const ty_atlas_def def = sized(64);
    ty_atlas* atlas = NULL;
    assert_int_equal(ty_atlas_create(scene, 0, "wall", &def, &atlas), TY_ERROR_INPUT);
    assert_null(atlas);
    const char* message = ty_take_error(context);
    assert_non_null(strstr(message, "wall"));
    assert_non_null(strstr(message, words));
    ty_scene_destroy(scene);
}

static void overlapping_maps_are_refused(void** state) {
    mapped_mesh mesh = mapped_nothing();
    mapped_quad(&mesh, all, all, 0, all, all);
    assert_refused(*state, &mesh, false, "bake vertices instead (--vertices)");
    mesh.uv[0] = -0.5f;
    assert_refused(*state, &mesh, true, "2 of its 2 triangles leave 0..1 (u -0.5..1, v 0..1)");
    memset(mesh.uv, 0, 8 * sizeof *mesh.uv);
    assert_refused(*state, &mesh, true, "cover no area");
    mesh.vertices = mesh.triangles = 0;
    const double u[2] = {0, 0.5}, overlapping[2] = {0.25, 1};
    mapped_quad(&mesh, all, all, 0, u, all);
    mapped_quad(&mesh, all, all, 1, overlapping, all);
    assert_refused(*state, &mesh, true, "25% of the lightmap's texels");
    /* front and back */
    mesh.vertices = mesh.triangles = 0;
    mapped_quad(&mesh, all, all, 0, all, all);
    mapped_triangle(&mesh, 0, 2, 1);
    assert_refused(*state, &mesh, true, "overlap");
    mapped_free(&mesh);
}

/* Edges that triangles share through texels' middles, rounding out of 0..1, and triangles given twice. */
static void maps_within_rounding_are_tolerated(void** state) {
    mapped_mesh mesh = mapped_nothing();
    const double u[2] = {-1e-5, 1 + 1e-5};
    mapped_quad(&mesh, all, all, 0, u, all);
    mapped_triangle(&mesh, 0, 1, 2);
    mapped_triangle(&mesh, 0, 1, 1);
    ty_scene* scene = mapped_scene(*state, &mesh, false, true);
    const ty_atlas_def def = sized(64);
    ty_atlas* atlas = mapped_atlas(scene, &def);
    int64_t count;
    ty_atlas_receivers(atlas, &count);
    assert_int_equal(count, 64 * 64);
    assert_int_equal(atlas->seam_count, 0);
    for (int64_t i = 0; i < count; ++i) assert_int_equal(atlas->charts[i], 0);
    ty_atlas_destroy(atlas);
    ty_scene_destroy(scene);
    mapped_free(&mesh);
}

static void arguments_are_checked(void** state) {
    mapped_mesh mesh = mapped_nothing();
    mapped_quad(&mesh, all, all, 0, all, all);
    ty_scene* scene = mapped_scene(*state, &mesh, false, true);
    ty_atlas* atlas = NULL;
    ty_atlas_def def = {0};
    assert_int_equal(ty_atlas_create(scene, 0, NULL, &def, &atlas), TY_ERROR_ARGUMENT);
    assert_error(*state, "ty_default_atlas_def");
    const ty_atlas_def good = ty_default_atlas_def();
    def = good;
    assert_int_equal(ty_atlas_create(scene, 1, NULL, &def, &atlas), TY_ERROR_ARGUMENT);
    assert_error(*state, "no mesh 1");
    def.width = 3;
    assert_int_equal(ty_atlas_create(scene, 0, NULL, &def, &atlas), TY_ERROR_ARGUMENT);
    assert_error(*state, "atlas.width");
    def = good;
    def.height = 16385;
    assert_int_equal(ty_atlas_create(scene, 0, NULL, &def, &atlas), TY_ERROR_ARGUMENT);
    assert_error(*state, "atlas.height");
    def = good;
    def.padding = 65;
    assert_int_equal(ty_atlas_create(scene, 0, NULL, &def, &atlas), TY_ERROR_ARGUMENT);
    assert_error(*state, "atlas.padding");
    def = good;
    def.density = (double)NAN;
    assert_int_equal(ty_atlas_create(scene, 0, NULL, &def, &atlas), TY_ERROR_ARGUMENT);
    assert_error(*state, "atlas.density");
    assert_null(atlas);
    ty_scene_destroy(scene);
    mapped_free(&mesh);
}

/* Many triangles of a chart that is one. */
static void fine_meshes_keep_their_texels(void** state) {
    enum { SIDE = 200 };
    mapped_mesh mesh = mapped_nothing();
    for (int i = 0; i <= SIDE; ++i)
        for (int j = 0; j <= SIDE; ++j) {
            const double u = (double)j / SIDE, v = (double)i / SIDE;
            mapped_vertex(&mesh, u, v, 0.1 * sin(9 * u) * sin(7 * v), u, v);
        }
    for (uint32_t i = 0; i < SIDE; ++i)
        for (uint32_t j = 0; j < SIDE; ++j) {
            const uint32_t a = i * (SIDE + 1) + j, b = a + SIDE + 1;
            mapped_triangle(&mesh, a, a + 1, b + 1);
            mapped_triangle(&mesh, a, b + 1, b);
        }
    ty_scene* scene = mapped_scene(*state, &mesh, false, true);
    const ty_atlas_def def = sized(96); /* two triangles and more a texel, at odds with them */
    ty_atlas* atlas = mapped_atlas(scene, &def);
    int64_t count;
    ty_atlas_receivers(atlas, &count);
    assert_int_equal(count, 96 * 96);
    assert_int_equal(atlas->seam_count, 0);
    for (int64_t i = 0; i < count; ++i) {
        assert_int_equal(atlas->charts[i], 0);
        const float* at = atlas->receivers[i].position;
        assert_close((double)at[0] * 96, (double)(i % 96) + 0.5, 0.07);
        assert_close((double)at[1] * 96, (double)(i / 96) + 0.5, 0.07);
    }
    ty_atlas_destroy(atlas);
    ty_scene_destroy(scene);
    mapped_free(&mesh);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(texels_lie_on_the_surface),          cmocka_unit_test(normals_are_interpolated),
        cmocka_unit_test(each_texel_has_one_triangle),        cmocka_unit_test(texels_that_are_touched_count),
        cmocka_unit_test(sizes_follow_the_density),           cmocka_unit_test(overlapping_maps_are_refused),
        cmocka_unit_test(maps_within_rounding_are_tolerated), cmocka_unit_test(arguments_are_checked),
        cmocka_unit_test(fine_meshes_keep_their_texels),
    };
    return cmocka_run_group_tests(tests, start_context, stop_context);
}
