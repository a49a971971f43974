/* Meshes: hits against closed forms, normals and their sides, alpha, what is refused, memory. */
#include "checks.h"
#include "files.h"
#include "triangle_maker.h"

#include "scene/scene.h"

#include <stddef.h>

static const double zero[3] = {0, 0, 0};
static const double moved[3] = {0.3, -0.2, 0.1}, turned[3] = {30, -50, 110};

static ty_scene* mesh_scene(ty_context* context, const ty_mesh_def* def) {
    ty_scene* scene = make_scene(context);
    if (ty_scene_add_mesh(scene, def) != TY_OK) fail_msg("%s", ty_take_error(context));
    if (ty_scene_commit(scene) != TY_OK) fail_msg("%s", ty_take_error(context));
    return scene;
}

static ty_surface_point point_at(const ty_scene* scene, const ty_hit* hit, ty_vec way) {
    ty_surface_point point;
    ty_surface_evaluate(&ty_scene_get_view(scene)->surfaces[hit->surface], hit, way, &point);
    return point;
}

static void random_ray(uint64_t* random, ty_vec* origin, ty_vec* way) {
    *origin = ty_scale(random_unit(random), (float)uniform_in(random, 1.5, 4));
    *way = ty_normalize(ty_sub(ty_scale(random_unit(random), (float)uniform_in(random, 0, 1)), *origin));
}

/* ---- hits ---- */

static void cross3(const double a[3], const double b[3], double out[3]) {
    for (int i = 0; i < 3; ++i) out[i] = a[(i + 1) % 3] * b[(i + 2) % 3] - a[(i + 2) % 3] * b[(i + 1) % 3];
}

static double dot3(const double a[3], const double b[3]) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* Distance and weights of a triangle's corners by Cramer's rule, in the world; negative where rounding may decide. */
static double meet(const made_mesh* mesh, const ty_affine* map, ty_vec origin, ty_vec way, double weight[3]) {
    double corner[3][3], ab[3], ac[3], normal[3], off[3], across[3];
    const double o[3] = {(double)origin.x, (double)origin.y, (double)origin.z};
    const double d[3] = {(double)way.x, (double)way.y, (double)way.z};
    for (int k = 0; k < 3; ++k) {
        const float* p = made_corner(mesh, 0, k);
        const double point[3] = {(double)p[0], (double)p[1], (double)p[2]};
        ty_affine_point(map, point, corner[k]);
    }
    for (int a = 0; a < 3; ++a) {
        ab[a] = corner[1][a] - corner[0][a];
        ac[a] = corner[2][a] - corner[0][a];
        off[a] = o[a] - corner[0][a];
    }
    cross3(ab, ac, normal);
    cross3(off, d, across);
    const double det = -dot3(normal, d);
    weight[1] = dot3(ac, across) / det;
    weight[2] = -dot3(ab, across) / det;
    weight[0] = 1 - weight[1] - weight[2];
    return dot3(normal, off) / det;
}

static void check_triangle(ty_context* context, const ty_affine* map) {
    static const double a[3] = {-0.9, -0.4, 0.2}, b[3] = {0.8, -0.5, -0.3}, c[3] = {0.1, 0.9, 0.4};
    made_mesh mesh = made_nothing();
    made_add(&mesh, a, b, c);
    ty_mesh_def def = made_def(&mesh);
    def.transform = *map;
    ty_scene* scene = mesh_scene(context, &def);
    const ty_accel* traced = ty_scene_get_view(scene)->mesh;
    const bool mirrored = map->m[0] * (map->m[5] * map->m[10] - map->m[6] * map->m[9]) -
                              map->m[1] * (map->m[4] * map->m[10] - map->m[6] * map->m[8]) +
                              map->m[2] * (map->m[4] * map->m[9] - map->m[5] * map->m[8]) <
                          0;
    uint64_t random = 4;
    int hits = 0;
    for (int i = 0; i < 4000; ++i) {
        ty_vec origin, way;
        double weight[3];
        random_ray(&random, &origin, &way);
        const double distance = meet(&mesh, map, origin, way, weight);
        const double slack = fmin(weight[0], fmin(weight[1], weight[2]));
        if (fabs(slack) < 1e-4 || fabs(distance) < 1e-4) continue;
        ty_hit hit;
        const bool expected = slack > 0 && distance > 0;
        assert_int_equal(ty_accel_intersect(traced, origin, way, TY_FLOAT_MAX, &hit), expected);
        assert_int_equal(ty_accel_occluded(traced, origin, way, TY_FLOAT_MAX), expected);
        if (!expected) continue;
        ++hits;
        assert_close(hit.distance, distance, 1e-4);
        assert_vec_close(hit.position, ty_mad(origin, way, (float)distance), 1e-5);
        /* Mirrored triangles have their second and third corner swapped. */
        assert_close(hit.b1, weight[mirrored ? 2 : 1], 2e-4);
        assert_close(hit.b2, weight[mirrored ? 1 : 2], 2e-4);
        assert_false(ty_accel_occluded(traced, origin, way, hit.distance * 0.999f));
        assert_true(ty_accel_occluded(traced, origin, way, hit.distance * 1.001f));
    }
    assert_true(hits > 200);
    ty_scene_destroy(scene);
    made_free(&mesh);
}

static void rays_meet_triangles(void** state) {
    ty_affine map = ty_affine_identity();
    check_triangle(*state, &map);
    double scale[3] = {0.7, 0.9, 1.3};
    for (int mirrored = 0; mirrored < 2; ++mirrored) {
        map = ty_affine_compose(moved, turned, scale);
        check_triangle(*state, &map);
        scale[0] = -0.7;
    }
}

/* A sphere's front is outside, whatever the transform; its smooth normals are those of the ellipsoid it becomes, on the
 * side of the ray. */
static void fronts_stay_outside(void** state) {
    made_mesh mesh = made_nothing();
    made_add_sphere(&mesh, zero, 1, 16);
    for (int mirrored = 0; mirrored < 2; ++mirrored) {
        const double scale[3] = {mirrored ? -0.7 : 0.7, 0.9, 1.1};
        ty_mesh_def def = made_def(&mesh);
        def.normals = mesh.normals;
        def.transform = ty_affine_compose(moved, turned, scale);
        ty_affine inverse;
        assert_true(ty_affine_invert(&def.transform, &inverse));
        ty_scene* scene = mesh_scene(*state, &def);
        const ty_accel* traced = ty_scene_get_view(scene)->mesh;
        uint64_t random = 8;
        for (int i = 0; i < 2000; ++i) {
            const bool within = i % 2 == 1;
            ty_vec origin, way;
            ty_hit hit;
            random_ray(&random, &origin, &way);
            if (within) origin = ty_vec_make(0.3f, -0.2f, 0.1f);
            if (!ty_accel_intersect(traced, origin, way, TY_FLOAT_MAX, &hit)) continue;
            const double at[3] = {(double)hit.position.x, (double)hit.position.y, (double)hit.position.z};
            double local[3];
            ty_affine_point(&inverse, at, local);
            ty_vec outside = ty_vec_make(0, 0, 0);
            for (int k = 0; k < 3; ++k)
                outside = ty_add(outside, ty_scale(ty_vec_make((float)inverse.m[4 * k], (float)inverse.m[4 * k + 1],
                                                               (float)inverse.m[4 * k + 2]),
                                                   (float)local[k]));
            outside = ty_normalize(outside);
            assert_true(ty_dot(hit.normal, outside) > 0.98f);
            assert_int_equal(ty_dot(hit.normal, way) > 0, within);
            const ty_surface_point point = point_at(scene, &hit, way);
            const float side = within ? -1.0f : 1.0f;
            assert_vec_close(point.ng, ty_scale(hit.normal, side), 1e-6);
            assert_vec_close(point.ns, ty_scale(outside, side), 3e-3);
            assert_close(ty_dot(point.ns, point.ns), 1, 1e-5);
        }
        ty_scene_destroy(scene);
    }
    made_free(&mesh);
}

/* Normals that are missing, not finite or beside the face count as the face's. */
static void bad_normals_count_as_none(void** state) {
    static const double corner[3] = {-1, 0, 1}, u[3] = {2, 0, 0}, v[3] = {0, 0, -2};
    static const float bad[4][3] = {{0, 0, 0}, {NAN, 1, 0}, {INFINITY, 0, 0}, {1, 0, 0}};
    for (int i = 0; i < 4; ++i) {
        made_mesh mesh = made_nothing();
        made_add_quad(&mesh, corner, u, v);
        for (int k = 0; k < 6; ++k) memcpy(mesh.normals + 3 * k, bad[i], sizeof bad[i]);
        ty_mesh_def def = made_def(&mesh);
        def.normals = mesh.normals;
        ty_scene* scene = mesh_scene(*state, &def);
        ty_hit hit;
        const ty_vec down = ty_vec_make(0, -1, 0);
        assert_true(ty_accel_intersect(ty_scene_get_view(scene)->mesh, ty_vec_make(0.1f, 1, 0.2f), down, 9, &hit));
        assert_vec_close(point_at(scene, &hit, down).ns, ty_vec_make(0, 1, 0), 1e-6);
        ty_scene_destroy(scene);
        made_free(&mesh);
    }
}

/* From a tenth of a micrometre to the width of a planet's orbit. */
static void triangles_of_any_size_have_normals(void** state) {
    static const double a[3] = {-1, -1, 0}, b[3] = {1, -1, 0}, c[3] = {0, 1, 0};
    for (double size = 1e-7; size < 1e12; size *= 100) {
        made_mesh mesh = made_nothing();
        made_add(&mesh, a, b, c);
        const double scale[3] = {size, size, size};
        ty_mesh_def def = made_def(&mesh);
        def.transform = ty_affine_compose(zero, zero, scale);
        def.material.emission[0] = 1;
        ty_scene* scene = mesh_scene(*state, &def);
        const ty_scene_view* view = ty_scene_get_view(scene);
        ty_hit hit;
        assert_true(
            ty_accel_intersect(view->mesh, ty_vec_make(0, 0, (float)size), ty_vec_make(0, 0, -1), TY_FLOAT_MAX, &hit));
        assert_vec_close(hit.normal, ty_vec_make(0, 0, 1), 1e-5);
        assert_close((double)hit.distance / size, 1, 1e-4);
        assert_int_equal(view->lights.count, 1);
        assert_vec_close(view->lights.lights[0].direction, ty_vec_make(0, 0, 1), 1e-5);
        assert_close((double)view->lights.lights[0].area / (2 * size * size), 1, 1e-4);
        ty_scene_destroy(scene);
        made_free(&mesh);
    }
}

/* Packets, full or not, say what single rays say; of shapes and meshes together. */
static void packets_are_single_rays(void** state) {
    static const double low[3] = {-1.5, -0.3, -0.2}, high[3] = {-0.6, 0.4, 0.3};
    made_mesh mesh = made_nothing();
    made_add_sphere(&mesh, zero, 0.7, 5);
    made_add_box(&mesh, low, high);
    ty_mesh_def def = made_def(&mesh);
    def.material.alpha = 0.5f;
    def.material.alpha_mode = TY_ALPHA_BLEND;
    ty_shape_def ball = ty_default_shape_def();
    ball.kind = TY_SHAPE_SPHERE;
    ball.origin[1] = 1;
    ball.radius = 0.5;
    ty_scene* scene = make_scene(*state);
    assert_int_equal(ty_scene_add_shape(scene, &ball), TY_OK);
    assert_int_equal(ty_scene_add_mesh(scene, &def), TY_OK);
    assert_int_equal(ty_scene_commit(scene), TY_OK);
    const ty_accel* traced = ty_scene_get_view(scene)->mesh;
    uint64_t random = 12;
    int meshes = 0, balls = 0, missed = 0;
    for (int i = 0; i < 400; ++i) {
        const int32_t count = 1 + i % TY_PACKET;
        ty_ray rays[TY_PACKET];
        ty_hit hits[TY_PACKET], single;
        bool occluded[TY_PACKET];
        float distances[TY_PACKET];
        ty_all_hits layers;
        for (int32_t k = 0; k < count; ++k) {
            ty_vec origin, direction;
            random_ray(&random, &origin, &direction);
            rays[k] = (ty_ray){.origin = {origin.x, origin.y, origin.z},
                               .direction = {direction.x, direction.y, direction.z}};
            rays[k].far = uniform(&random) < 0.5 ? 2 : TY_FLOAT_MAX;
        }
        ty_accel_intersect_packet(traced, rays, count, hits);
        ty_accel_occluded_packet(traced, rays, count, occluded);
        ty_accel_distance_packet(traced, rays, count, distances);
        ty_accel_all_hits_packet(traced, rays, count, &layers);
        for (int32_t k = 0; k < count; ++k) {
            const ty_ray* ray = &rays[k];
            const ty_vec origin = ty_vec_load(ray->origin), direction = ty_vec_load(ray->direction);
            const bool met = ty_accel_intersect(traced, origin, direction, ray->far, &single);
            assert_int_equal(hits[k].surface >= 0, met);
            assert_int_equal(occluded[k], met);
            assert_int_equal(isfinite(distances[k]), met);
            assert_int_equal(layers.count[k] > 0, met);
            assert_int_equal(ty_accel_occluded(traced, origin, direction, ray->far), met);
            meshes += met && single.surface == 1;
            balls += met && single.surface == 0;
            missed += !met;
            if (!met) continue;
            assert_int_equal(hits[k].surface, single.surface);
            assert_int_equal(hits[k].primitive_id, single.primitive_id);
            assert_close(hits[k].distance, single.distance, 1e-5);
            assert_close(distances[k], single.distance, 1e-5);
            assert_close(layers.layer[k][0].distance, single.distance, 1e-5);
            assert_vec_close(hits[k].position, single.position, 1e-5);
            assert_vec_close(hits[k].normal, single.normal, 1e-4);
            if (single.surface == 1) assert_close(hits[k].b1, single.b1, 1e-3);
            if (single.surface == 1) assert_close(hits[k].b2, single.b2, 1e-3);
        }
    }
    assert_true(meshes > 100 && balls > 100 && missed > 100);
    ty_scene_destroy(scene);
    made_free(&mesh);
}

/* A ray's layers are what it meets when it goes on behind each hit. */
static void layers_are_met_one_by_one(void** state) {
    static const double low[3] = {-1.5, -0.3, -0.2}, high[3] = {-0.6, 0.4, 0.3};
    made_mesh mesh = made_nothing();
    made_add_sphere(&mesh, zero, 0.7, 5);
    made_add_box(&mesh, low, high);
    const ty_mesh_def def = made_def(&mesh);
    ty_scene* scene = make_scene(*state);
    assert_int_equal(ty_scene_add_mesh(scene, &def), TY_OK);
    assert_int_equal(ty_scene_commit(scene), TY_OK);
    const ty_accel* traced = ty_scene_get_view(scene)->mesh;
    uint64_t random = 5;
    int met = 0, deep = 0;
    for (int i = 0; i < 1000; ++i) {
        ty_vec origin, direction;
        random_ray(&random, &origin, &direction);
        const ty_ray ray = {.origin = {origin.x, origin.y, origin.z},
                            .direction = {direction.x, direction.y, direction.z},
                            .far = TY_FLOAT_MAX};
        ty_all_hits layers;
        ty_hit hit, layer;
        ty_accel_all_hits_packet(traced, &ray, 1, &layers);
        int32_t count = 0;
        for (ty_vec from = origin; ty_accel_intersect(traced, from, direction, TY_FLOAT_MAX, &hit); ++count) {
            assert_true(count < layers.count[0]);
            ty_accel_complete_hit(traced, &ray, &layers.layer[0][count], &layer);
            assert_int_equal(layer.surface, hit.surface);
            assert_int_equal(layer.primitive_id, hit.primitive_id);
            assert_vec_close(layer.position, hit.position, 1e-3); /* rays that go on begin a margin aside */
            assert_vec_close(layer.normal, hit.normal, 1e-3);
            from = ty_hit_leave(&hit, direction);
        }
        assert_int_equal(layers.count[0], count);
        met += count > 0;
        deep += count > 2;
    }
    assert_true(met > 100 && deep > 10);
    ty_scene_destroy(scene);
    made_free(&mesh);
}

/* Of too many layers the nearest are kept, whichever way the ray goes. */
static void the_nearest_layers_are_kept(void** state) {
    enum { BOARDS = TY_ALL_HITS_MAX + 40 };
    ty_scene* scene = make_scene(*state);
    for (int i = 0; i < BOARDS; ++i) {
        ty_shape_def board = ty_default_shape_def();
        board.origin[0] = board.origin[1] = -1;
        board.origin[2] = i;
        board.u[0] = board.v[1] = 2;
        assert_int_equal(ty_scene_add_shape(scene, &board), TY_OK);
    }
    assert_int_equal(ty_scene_commit(scene), TY_OK);
    for (int way = -1; way <= 1; way += 2) {
        ty_all_hits layers;
        const float begin = way > 0 ? -0.5f : (float)BOARDS - 0.5f;
        const ty_ray ray = {.origin = {0.1f, 0.2f, begin}, .direction = {0, 0, (float)way}, .far = TY_FLOAT_MAX};
        ty_accel_all_hits_packet(ty_scene_get_view(scene)->mesh, &ray, 1, &layers);
        assert_int_equal(layers.count[0], TY_ALL_HITS_MAX);
        for (int i = 0; i < TY_ALL_HITS_MAX; ++i) assert_close(layers.layer[0][i].distance, i + 0.5, 1e-4);
    }
    ty_scene_destroy(scene);
}

/* ---- alpha ---- */

/* A board of side 2 at z = 0 that faces +z, u along x and v along y. */
static made_mesh made_board(void) {
    static const double corner[3] = {-1, -1, 0}, u[3] = {2, 0, 0}, v[3] = {0, 2, 0};
    made_mesh mesh = made_nothing();
    made_add_quad(&mesh, corner, u, v);
    return mesh;
}

/* The number of rays along -z and around it that meet something; each the same however often it is asked. */
static double share_met(const ty_scene* scene, float spread, bool random_depth) {
    enum { RAYS = 20000 };
    const ty_accel* traced = ty_scene_get_view(scene)->mesh;
    uint64_t random = 77;
    int met = 0;
    for (int i = 0; i < RAYS; ++i) {
        ty_hit hit;
        const ty_vec way = ty_normalize(ty_mad(ty_vec_make(0, 0, -1), random_unit(&random), spread));
        ty_vec origin = ty_vec_make(0.1f, -0.2f, 1);
        if (random_depth) origin.z += (float)uniform(&random);
        const bool once = ty_accel_intersect(traced, origin, way, TY_FLOAT_MAX, &hit);
        for (int again = 0; again < 2; ++again) {
            assert_int_equal(ty_accel_intersect(traced, origin, way, TY_FLOAT_MAX, &hit), once);
            assert_int_equal(ty_accel_occluded(traced, origin, way, TY_FLOAT_MAX), once);
        }
        met += once;
    }
    return (double)met / RAYS;
}

/* Factor, texture and vertex colours multiply. 5 standard errors: 0.018. */
static void blending_lets_a_fraction_through(void** state) {
    static const uint8_t texel[4] = {255, 255, 255, 204};
    float colors[6 * 4];
    made_mesh mesh = made_board();
    ty_mesh_def def = made_def(&mesh);
    ty_texture_def texture_def = ty_default_texture_def();
    texture_def.width = texture_def.height = 1;
    texture_def.rgba8 = texel;
    for (int i = 0; i < 24; ++i) colors[i] = 0.75f;
    def.material.alpha_mode = TY_ALPHA_BLEND;
    def.material.alpha = 0.5f;
    for (int kind = 0; kind < 3; ++kind) {
        static const double expected[3] = {0.5, 0.4, 0.3};
        if (kind == 1) assert_int_equal(ty_texture_create(*state, &texture_def, &def.material.albedo_texture), TY_OK);
        if (kind == 2) def.colors = colors;
        ty_scene* scene = mesh_scene(*state, &def);
        assert_close(share_met(scene, 0.2f, false), expected[kind], 0.018);
        assert_close(share_met(scene, 0, true), expected[kind], 0.018);
        ty_scene_destroy(scene);
    }
    ty_texture_release(def.material.albedo_texture);
    for (int whole = 0; whole < 2; ++whole) {
        def = made_def(&mesh);
        def.material.alpha_mode = TY_ALPHA_BLEND;
        def.material.alpha = (float)whole;
        ty_scene* scene = mesh_scene(*state, &def);
        assert_close(share_met(scene, 0.2f, false), whole, 0);
        ty_scene_destroy(scene);
    }
    made_free(&mesh);
}

/* Opaque surfaces do not look at alpha; two layers let the product through. */
static void layers_decide_apart(void** state) {
    static const double corner[3] = {-1, -1, -0.5}, u[3] = {2, 0, 0}, v[3] = {0, 2, 0};
    made_mesh mesh = made_board();
    made_add_quad(&mesh, corner, u, v);
    ty_mesh_def def = made_def(&mesh);
    def.material.alpha = 0.3f;
    ty_scene* scene = mesh_scene(*state, &def);
    assert_close(share_met(scene, 0.2f, false), 1, 0);
    ty_scene_destroy(scene);
    def.material.alpha_mode = TY_ALPHA_BLEND;
    scene = mesh_scene(*state, &def);
    assert_close(share_met(scene, 0.2f, false), 1 - 0.7 * 0.7, 0.018);
    ty_scene_destroy(scene);
    made_free(&mesh);
}

static void masks_cut_where_alpha_is_low(void** state) {
    static const uint8_t texels[16] = {9, 9, 9, 100, 9, 9, 9, 150, 9, 9, 9, 200, 9, 9, 9, 250};
    made_mesh mesh = made_board();
    ty_mesh_def def = made_def(&mesh);
    ty_texture_def texture_def = ty_default_texture_def();
    texture_def.width = texture_def.height = 2;
    texture_def.rgba8 = texels;
    texture_def.nearest = true;
    assert_int_equal(ty_texture_create(*state, &texture_def, &def.material.albedo_texture), TY_OK);
    def.material.alpha_mode = TY_ALPHA_MASK;
    def.material.alpha = 0.9f;
    def.material.alpha_cutoff = (float)(0.9 * 175 / 255);
    ty_scene* scene = mesh_scene(*state, &def);
    const ty_accel* traced = ty_scene_get_view(scene)->mesh;
    uint64_t random = 14;
    for (int i = 0; i < 2000; ++i) {
        ty_hit hit;
        const float x = (float)uniform_in(&random, -0.999, 0.999), y = (float)uniform_in(&random, -0.999, 0.999);
        if (fabsf(x) < 1e-3f || fabsf(y) < 1e-3f) continue;
        const bool met = ty_accel_intersect(traced, ty_vec_make(x, y, 1), ty_vec_make(0, 0, -1), TY_FLOAT_MAX, &hit);
        assert_int_equal(met, y > 0); /* rows 0 and 1 of the texture: v below and above 0.5 */
    }
    ty_scene_destroy(scene);
    ty_texture_release(def.material.albedo_texture);
    made_free(&mesh);
}

/* ---- what is refused, and what is counted ---- */

static void points_and_lines_are_not_met(void** state) {
    static const double a[3] = {-1, 0, 0}, b[3] = {1, 0, 0}, middle[3] = {0.25, 0, 0};
    made_mesh mesh = made_nothing();
    made_add(&mesh, a, a, a);
    made_add(&mesh, a, b, middle);
    made_add(&mesh, a, b, b);
    ty_mesh_def def = made_def(&mesh);
    def.material.emission[1] = 3;
    ty_scene* scene = mesh_scene(*state, &def);
    const ty_scene_view* view = ty_scene_get_view(scene);
    uint64_t random = 15;
    ty_hit hit;
    for (int i = 0; i < 1000; ++i) {
        const ty_vec target = ty_vec_make((float)uniform_in(&random, -1, 1), 0, 0), origin = random_unit(&random);
        const ty_vec way = ty_normalize(ty_sub(target, origin));
        assert_false(ty_accel_intersect(view->mesh, origin, way, TY_FLOAT_MAX, &hit));
    }
    assert_int_equal(view->lights.count, 0);
    ty_scene_destroy(scene);
    made_free(&mesh);
}

#define MESH(field, type, value, words)                                                                                \
    { offsetof(ty_mesh_def, field), type, value, words }

static void wrong_meshes_are_refused(void** state) {
    static const bad_field bad[] = {
        MESH(cookie, FIELD_INT, 0, "ty_default_mesh_def"),
        MESH(vertex_count, FIELD_INT, 0, "mesh: 0 vertices and 2 triangles"),
        MESH(triangle_count, FIELD_INT, -1, "triangles are not both in 1..2^31 - 1"),
        MESH(vertex_count, FIELD_INT, 5, "mesh: indices[5] is 5, and there are 5 vertices"),
        MESH(transform.m[5], FIELD_DOUBLE, 0, "mesh.transform: the map cannot be inverted"),
        MESH(transform.m[3], FIELD_DOUBLE, 2e15, "mesh: its transform takes it outside [-1e15, 1e15]"),
        MESH(material.cookie, FIELD_INT, 0, "ty_default_material_def"),
        MESH(material.albedo[1], FIELD_FLOAT, 1.5, "material.albedo[1]: 1.5 is outside [0, 1]"),
        MESH(material.emission[2], FIELD_FLOAT, -1, "material.emission[2]: -1"),
        MESH(material.emission[0], FIELD_FLOAT, NAN, "material.emission[0]"),
        MESH(material.alpha, FIELD_FLOAT, 2, "material.alpha: 2"),
        MESH(material.alpha_cutoff, FIELD_FLOAT, -0.5, "material.alpha_cutoff: -0.5"),
        MESH(material.alpha_mode, FIELD_INT, 3, "material.alpha_mode: 3"),
        MESH(material.albedo_uv, FIELD_INT, 2, "material.albedo_uv: 2"),
        MESH(material.emission_uv, FIELD_INT, -1, "material.emission_uv: -1"),
        MESH(material.albedo_map[4], FIELD_FLOAT, INFINITY, "material.albedo_map[4]"),
        MESH(material.emission_map[2], FIELD_FLOAT, NAN, "material.emission_map[2]"),
    };
    ty_scene* scene = make_scene(*state);
    made_mesh mesh = made_board();
    ty_mesh_def def;
    for (size_t i = 0; i < sizeof bad / sizeof *bad; ++i) {
        def = made_def(&mesh);
        set_field(&def, &bad[i]);
        assert_int_equal(ty_scene_add_mesh(scene, &def), TY_ERROR_ARGUMENT);
        assert_error(*state, bad[i].words);
    }
    def = made_def(&mesh);
    def.positions = NULL;
    assert_int_equal(ty_scene_add_mesh(scene, &def), TY_ERROR_ARGUMENT);
    assert_error(*state, "mesh: positions or indices are NULL");
    mesh.positions[7] = NAN;
    def.positions = mesh.positions;
    assert_int_equal(ty_scene_add_mesh(scene, &def), TY_ERROR_ARGUMENT);
    assert_error(*state, "mesh: the position of vertex 2 is outside [-1e15, 1e15]");
    assert_int_equal(ty_scene_get_info(scene).meshes, 0);
    ty_scene_destroy(scene);
    made_free(&mesh);
}

/* A texture that two meshes share counts once. */
static void memory_is_counted(void** state) {
    static uint8_t texels[4 * 64 * 64];
    made_mesh mesh = made_nothing();
    made_add_sphere(&mesh, zero, 2, 20);
    ty_texture_def texture_def = ty_default_texture_def();
    texture_def.width = texture_def.height = 64;
    texture_def.rgba8 = texels;
    ty_mesh_def def = made_def(&mesh);
    ty_scene* scene = make_scene(*state);
    const size_t before = ty_scene_get_info(scene).bytes;
    assert_int_equal(ty_scene_add_mesh(scene, &def), TY_OK);
    const size_t plain = ty_scene_get_info(scene).bytes - before;
    const size_t arrays = (size_t)mesh.triangles * 3 * (5 * sizeof(float) + sizeof(uint32_t));
    assert_true(plain >= arrays && plain < arrays + 4096);
    assert_int_equal(ty_texture_create(*state, &texture_def, &def.material.albedo_texture), TY_OK);
    def.material.emission_texture = def.material.albedo_texture;
    def.material.emission[0] = 1;
    assert_int_equal(ty_scene_add_mesh(scene, &def), TY_OK);
    assert_int_equal(ty_scene_add_mesh(scene, &def), TY_OK);
    const size_t shared = ty_scene_get_info(scene).bytes - before - 3 * plain;
    assert_true(shared >= sizeof texels && shared < sizeof texels + 8192);
    ty_texture_release(def.material.albedo_texture);
    const size_t added = ty_scene_get_info(scene).bytes;
    assert_int_equal(ty_scene_commit(scene), TY_OK);
    const ty_scene_info info = ty_scene_get_info(scene);
    assert_true(info.bytes > added + 32 * (size_t)info.triangles);
    assert_int_equal(info.meshes, 3);
    assert_int_equal(info.triangles, 3 * 8 * 400);
    assert_int_equal(info.emitters, 0); /* their texture is black */
    assert_true(info.bounded);
    for (int a = 0; a < 3; ++a) {
        assert_close(info.lower[a], -2, 1e-6);
        assert_close(info.upper[a], 2, 1e-6);
    }
    ty_scene_destroy(scene);
    made_free(&mesh);
}

/* ---- memory that is short ---- */

/* A scene with everything that meshes, textures and shells hold; frees all of it whatever happens. */
static ty_result work(ty_context* context, void* user) {
    (void)user;
    static const uint8_t texel[4] = {200, 200, 200, 200};
    made_mesh mesh = made_nothing();
    float colors[12 * 3 * 4] = {0};
    static const double low[3] = {-1, -1, -1}, high[3] = {1, 1, 1};
    made_add_box(&mesh, low, high);
    ty_mesh_def def = made_def(&mesh);
    ty_medium_def medium = ty_default_medium_def();
    ty_texture_def texture_def = ty_default_texture_def();
    texture_def.width = texture_def.height = 1;
    texture_def.rgba8 = texel;
    def.normals = mesh.normals;
    def.uv[1] = mesh.uv;
    def.colors = colors;
    def.material.emission[0] = 1;
    medium.bounds = TY_BOUNDS_SHELL;
    ty_scene* scene = NULL;
    ty_grid* coverage = NULL;
    const int32_t size[3] = {3, 3, 3};
    ty_result result = ty_texture_create(context, &texture_def, &def.material.albedo_texture);
    def.material.emission_texture = def.material.albedo_texture;
    if (result == TY_OK) result = made_shell(context, &mesh, &medium.shell);
    if (result == TY_OK) result = ty_scene_create(context, TY_AXIS_Y, &scene);
    if (result == TY_OK) result = ty_scene_add_mesh(scene, &def);
    if (result == TY_OK) result = ty_scene_add_medium(scene, &medium);
    if (result == TY_OK) result = ty_scene_commit(scene);
    if (result == TY_OK) result = ty_medium_create_coverage(scene, 0, low, high, size, 2, &coverage);
    ty_grid_release(coverage);
    ty_scene_destroy(scene);
    ty_closed_mesh_release(medium.shell);
    ty_texture_release(def.material.albedo_texture);
    made_free(&mesh);
    return result;
}

static void every_failed_allocation_is_reported(void** state) {
    (void)state;
    strict_memory memory = {.limit = (size_t)1 << 30, .until_refusal = -1};
    ty_context* context = strict_context(&memory);
    assert_true(check_short_memory(context, &memory, work, NULL) > 25);
    ty_context_destroy(context);
    assert_int_equal(memory.used, 0);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(rays_meet_triangles),
        cmocka_unit_test(fronts_stay_outside),
        cmocka_unit_test(bad_normals_count_as_none),
        cmocka_unit_test(triangles_of_any_size_have_normals),
        cmocka_unit_test(packets_are_single_rays),
        cmocka_unit_test(layers_are_met_one_by_one),
        cmocka_unit_test(the_nearest_layers_are_kept),
        cmocka_unit_test(blending_lets_a_fraction_through),
        cmocka_unit_test(layers_decide_apart),
        cmocka_unit_test(masks_cut_where_alpha_is_low),
        cmocka_unit_test(points_and_lines_are_not_met),
        cmocka_unit_test(wrong_meshes_are_refused),
        cmocka_unit_test(memory_is_counted),
        cmocka_unit_test(every_failed_allocation_is_reported),
    };
    return cmocka_run_group_tests(tests, start_context, stop_context);
}
