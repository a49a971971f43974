/* Many rays at once against rays one by one, and meshes as a scene gives them back. */
#include "checks.h"

#include "scene/scene.h"

enum { RAYS = 5003 }; /* no whole number of packets or blocks */

static const float positions[] = {-4, 0, -4, 4, 0, -4, 4, 0, 4, -4, 0, 4};
static const uint32_t indices[] = {0, 2, 1, 0, 3, 2};

/* A floor of two triangles, half a metre down. */
static void add_floor(ty_scene* scene) {
    const double move[3] = {0, -0.5, 0}, turn[3] = {0, 0, 0}, one[3] = {1, 1, 1};
    ty_mesh_def mesh = ty_default_mesh_def();
    mesh.vertex_count = 4;
    mesh.triangle_count = 2;
    mesh.positions = positions;
    mesh.indices = indices;
    mesh.transform = ty_affine_compose(move, turn, one);
    assert_int_equal(ty_scene_add_mesh(scene, &mesh), TY_OK);
}

/* A box (surface 0), a ball (1), a lamp above (2) and the floor (3). */
static ty_scene* furnished_scene(ty_context* context) {
    ty_scene* scene = make_scene(context);
    ty_shape_def shape = ty_default_shape_def();
    shape.kind = TY_SHAPE_BOX;
    set3(shape.origin, -2, -0.25, -1);
    set3(shape.u, -1, 1, 1);
    assert_int_equal(ty_scene_add_shape(scene, &shape), TY_OK);
    shape.kind = TY_SHAPE_SPHERE;
    set3(shape.origin, 1.5, 0.5, 0);
    shape.radius = 0.75;
    assert_int_equal(ty_scene_add_shape(scene, &shape), TY_OK);
    ty_light_def light = ty_default_light_def();
    light.kind = TY_LIGHT_AREA;
    set3(light.position, -1.5, 2.5, -1.5);
    set3(light.u, 3, 0, 0);
    set3(light.v, 0, 0, 3);
    assert_int_equal(ty_scene_add_light(scene, &light), TY_OK);
    add_floor(scene);
    assert_int_equal(ty_scene_commit(scene), TY_OK);
    return scene;
}

/* From all around towards the middle; every third ray ends early. */
static ty_ray* make_rays(void) {
    ty_ray* rays = malloc(RAYS * sizeof *rays);
    assert_non_null(rays);
    uint64_t random = 5;
    for (int i = 0; i < RAYS; ++i) {
        const ty_vec origin = ty_scale(random_unit(&random), (float)uniform_in(&random, 1, 6));
        const ty_vec target = ty_scale(random_unit(&random), (float)uniform_in(&random, 0, 3));
        const ty_vec direction = ty_normalize(ty_sub(target, origin));
        memcpy(rays[i].origin, &origin, sizeof rays[i].origin);
        memcpy(rays[i].direction, &direction, sizeof rays[i].direction);
        rays[i].far = i % 3 == 0 ? (float)uniform_in(&random, 0.5, 4) : INFINITY;
    }
    return rays;
}

static void check_hit(const ty_accel* mesh, const ty_ray* ray, const ty_ray_hit* hit, double tolerance) {
    ty_hit expected = {.surface = -1};
    if (!ty_accel_intersect(mesh, ty_vec_load(ray->origin), ty_vec_load(ray->direction), ray->far, &expected)) {
        assert_int_equal(hit->surface, -1);
        assert_true(hit->distance == ray->far);
        assert_true(hit->part == 0 && hit->margin == 0);
        return;
    }
    assert_int_equal(hit->surface, expected.surface);
    assert_int_equal(hit->part, expected.primitive_id);
    assert_close(hit->distance, expected.distance, tolerance);
    assert_vec_close(ty_vec_load(hit->position), expected.position, tolerance);
    assert_vec_close(ty_vec_load(hit->normal), expected.normal, tolerance);
    assert_close(hit->b1, expected.b1, tolerance);
    assert_close(hit->b2, expected.b2, tolerance);
    assert_true(hit->margin > 0 && hit->margin == expected.margin);
}

static void many_rays_meet_what_single_rays_meet(void** state) {
    ty_scene* scene = furnished_scene(*state);
    const ty_accel* mesh = ty_scene_get_view(scene)->mesh;
    ty_ray* rays = make_rays();
    ty_ray_hit* hits = malloc(RAYS * sizeof *hits);
    bool* shadowed = malloc(RAYS);
    assert_true(hits != NULL && shadowed != NULL);
    for (int coherent = 0; coherent < 2; ++coherent) {
        int met[5] = {0};
        assert_int_equal(ty_scene_trace(scene, rays, RAYS, (ty_ray_order)coherent, hits), TY_OK);
        assert_int_equal(ty_scene_trace_shadows(scene, rays, RAYS, (ty_ray_order)coherent, shadowed), TY_OK);
        for (int i = 0; i < RAYS; ++i) {
            check_hit(mesh, &rays[i], &hits[i], coherent ? 2e-5 : 0);
            assert_int_equal(shadowed[i], hits[i].surface >= 0);
            ++met[hits[i].surface + 1];
        }
        for (int surface = 0; surface < 5; ++surface) assert_true(met[surface] > 50);
    }
    free(shadowed);
    free(hits);
    free(rays);
    ty_scene_destroy(scene);
}

static void no_rays_and_no_surfaces(void** state) {
    ty_scene* scene = make_scene(*state);
    ty_ray ray = {.direction = {0, 0, 1}, .far = 3};
    ty_ray_hit hit = {.surface = 7};
    bool shadowed = true;
    assert_int_equal(ty_scene_trace(scene, &ray, 1, TY_RAYS_COHERENT, &hit), TY_ERROR_ARGUMENT); /* not committed */
    assert_int_equal(ty_scene_commit(scene), TY_OK);
    assert_int_equal(ty_scene_trace(scene, &ray, -1, TY_RAYS_COHERENT, &hit), TY_ERROR_ARGUMENT);
    assert_int_equal(ty_scene_trace_shadows(scene, &ray, -1, TY_RAYS_COHERENT, &shadowed), TY_ERROR_ARGUMENT);
    assert_int_equal(ty_scene_trace(scene, NULL, 0, TY_RAYS_COHERENT, NULL), TY_OK);
    assert_int_equal(hit.surface, 7);
    assert_int_equal(ty_scene_trace(scene, &ray, 1, TY_RAYS_COHERENT, &hit), TY_OK);
    assert_int_equal(ty_scene_trace_shadows(scene, &ray, 1, TY_RAYS_INCOHERENT, &shadowed), TY_OK);
    assert_int_equal(hit.surface, -1);
    assert_true(hit.distance == 3);
    assert_false(shadowed);
    ty_scene_destroy(scene);
}

static void a_scene_gives_its_meshes_back_in_world_space(void** state) {
    ty_scene* scene = make_scene(*state);
    ty_mesh_def mesh;
    assert_int_equal(ty_scene_get_mesh(scene, 0, &mesh), TY_ERROR_ARGUMENT);
    add_floor(scene);
    assert_int_equal(ty_scene_get_mesh(scene, 0, &mesh), TY_OK);
    assert_int_equal(ty_scene_get_mesh(scene, -1, &mesh), TY_ERROR_ARGUMENT);
    assert_int_equal(ty_scene_get_mesh(scene, 1, &mesh), TY_ERROR_ARGUMENT);
    assert_int_equal(mesh.vertex_count, 4);
    assert_int_equal(mesh.triangle_count, 2);
    assert_null(mesh.normals);
    assert_memory_equal(mesh.indices, indices, sizeof indices);
    for (int i = 0; i < 4; ++i)
        assert_vec_close(ty_vec_load(mesh.positions + 3 * i),
                         ty_vec_make(positions[3 * i], positions[3 * i + 1] - 0.5f, positions[3 * i + 2]), 0);
    assert_int_equal(ty_scene_add_mesh(scene, &mesh), TY_OK); /* as it is */
    assert_int_equal(ty_scene_get_info(scene).triangles, 4);
    ty_scene_destroy(scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(many_rays_meet_what_single_rays_meet),
        cmocka_unit_test(no_rays_and_no_surfaces),
        cmocka_unit_test(a_scene_gives_its_meshes_back_in_world_space),
    };
    return cmocka_run_group_tests(tests, start_context, stop_context);
}
