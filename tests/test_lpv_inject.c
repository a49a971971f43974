/* Injection into lattices. */
#include "base/context.h"
#include "direct_maker.h"
#include "files.h"
#include "method/lpv/inject/inject.h"
#include "method/lpv/lattice/irradiance.h"
#include "method/lpv/propagate/propagate.h"
#include "method/lpv/propagate/transfer.h"

static const double pi = 3.14159265358979323846;

/* ---- scenes and lattices ---- */

static ty_grid_box cube_box(double half, int32_t cells) {
    return (ty_grid_box){.lower = {-half, -half, -half}, .upper = {half, half, half}, .size = {cells, cells, cells}};
}

static ty_lattice* lattice_of(ty_context* context, const ty_grid_box* box, int32_t bands) {
    ty_lattice* lattice = NULL;
    check_result(context, ty_lattice_create(context, box, bands, &lattice));
    return lattice;
}

static void add_quad(ty_scene* scene, const double origin[3], const double u[3], const double v[3]) {
    ty_shape_def def = ty_default_shape_def();
    for (int a = 0; a < 3; ++a) {
        def.origin[a] = origin[a];
        def.u[a] = u[a];
        def.v[a] = v[a];
    }
    set3f(def.albedo, 0.2f, 0.4f, 0.8f);
    check_result(ty_scene_context(scene), ty_scene_add_shape(scene, &def));
}

static void add_solid(ty_scene* scene, ty_shape_kind kind, double size) {
    ty_shape_def def = ty_default_shape_def();
    def.kind = kind;
    set3f(def.albedo, 0.5f, 0.5f, 0.5f);
    if (kind == TY_SHAPE_BOX) {
        set3(def.origin, -size + 0.013, -size, -size);
        set3(def.u, size + 0.013, size, size);
    } else {
        set3(def.origin, 0.02, 0, 0.01);
        def.radius = size;
    }
    check_result(ty_scene_context(scene), ty_scene_add_shape(scene, &def));
}

static void add_light(ty_scene* scene, ty_light_kind kind, const double at[3], const double way[3]) {
    ty_light_def def = ty_default_light_def();
    def.kind = kind;
    def.cone = 60;
    for (int a = 0; a < 3; ++a) {
        def.position[a] = at[a];
        def.direction[a] = way[a];
    }
    set3f(def.color, 3, 2, 1);
    check_result(ty_scene_context(scene), ty_scene_add_light(scene, &def));
}

static const double origin[3] = {0, 0, 0}, down[3] = {0.1, -1, 0.2};

/* Power that flows in a lattice. */
static double flowing(const ty_lattice* lattice, int c) {
    double sum = 0;
    for (size_t i = 0; i < lattice->cells; ++i) sum += (double)lattice->propagated_sh[c][0][i];
    return sum * sqrt(4 * pi);
}

/* ---- surfels ---- */

static double area_of(ty_scene* scene, const ty_grid_box* box, int32_t side) {
    ty_surfel* surfels = NULL;
    size_t count = 0, capacity = 0;
    double area = 0;
    check_result(ty_scene_context(scene), ty_scene_commit(scene));
    check_result(ty_scene_context(scene), ty_surfels_trace(scene, box, side, &surfels, &count, &capacity, NULL));
    for (size_t i = 0; i < count; ++i) area += (double)surfels[i].area;
    ty_free_array(ty_scene_context(scene), surfels, capacity, sizeof *surfels);
    return area;
}

static void surfels_have_the_area(void** state) {
    const ty_grid_box box = cube_box(2, 16);
    ty_scene* scene = make_scene(*state);
    add_solid(scene, TY_SHAPE_SPHERE, 1.3);
    assert_close(area_of(scene, &box, 3) / (4 * pi * 1.69), 1, 0.02);
    add_solid(scene, TY_SHAPE_SPHERE, 0.6);
    assert_close(area_of(scene, &box, 3) / (4 * pi * (1.69 + 0.36)), 1, 0.02);
    ty_scene_destroy(scene);
    scene = make_scene(*state);
    add_solid(scene, TY_SHAPE_BOX, 1.21);
    assert_close(area_of(scene, &box, 3) / (6 * 2.42 * 2.42), 1, 0.02);
    ty_scene_destroy(scene);
    /* A wall of its own, at any angle; and what is outside of the box does not count. */
    scene = make_scene(*state);
    add_quad(scene, (const double[3]){-1, -1, 0.1}, (const double[3]){2, 0.5, 1}, (const double[3]){0, 1.5, 0.7});
    const double cross[3] = {0.5 * 0.7 - 1 * 1.5, 1 * 0 - 2 * 0.7, 2 * 1.5};
    assert_close(area_of(scene, &box, 4) / sqrt(cross[0] * cross[0] + cross[1] * cross[1] + cross[2] * cross[2]), 1,
                 0.02);
    add_quad(scene, (const double[3]){-1, 3, 0.1}, (const double[3]){2, 0, 0}, (const double[3]){0, 0, 2});
    assert_close(area_of(scene, &box, 4) / sqrt(cross[0] * cross[0] + cross[1] * cross[1] + cross[2] * cross[2]), 1,
                 0.02);
    ty_scene_destroy(scene);
}

/* ---- blockers ---- */

static ty_lattice* blocked_by(ty_scene* scene, const ty_grid_box* box, ty_lpv_mode mode, int32_t side) {
    ty_context* context = ty_scene_context(scene);
    ty_lattice* lattice = lattice_of(context, box, 2);
    ty_surfel* surfels = NULL;
    size_t count = 0, capacity = 0;
    check_result(context, ty_scene_commit(scene));
    check_result(context, ty_surfels_trace(scene, box, side, &surfels, &count, &capacity, NULL));
    check_result(context, ty_lattice_find_blockers(lattice, mode, surfels, count));
    ty_free_array(context, surfels, capacity, sizeof *surfels);
    return lattice;
}

/* Where a floor cuts through cells above their middles, walls are lit down to it, and not below it. */
static void corners_are_lit(void** state) {
    static const double floor_height = 0.2, wall = 0.03;
    const ty_grid_box box = cube_box(2, 16);
    ty_scene* scene = make_scene(*state);
    add_quad(scene, (const double[3]){-3, floor_height, -3}, (const double[3]){0, 0, 6}, (const double[3]){6, 0, 0});
    add_quad(scene, (const double[3]){wall, -3, -3}, (const double[3]){0, 6, 0}, (const double[3]){0, 0, 6});
    ty_lattice* lattice = blocked_by(scene, &box, TY_LPV_MODE_LINKS, 3);
    for (int32_t i = 0; i < 16 * 16 * 16; ++i)
        for (int c = 0; c < 3; ++c)
            lattice->light[c][0][i] = i % 16 * 0.25 - 1.875 > wall && i / 16 % 16 * 0.25 - 1.875 > floor_height;
    const ty_lpv_light_view view = {&lattice, 1};
    const ty_vec right = ty_vec_make(1, 0, 0);
    float transmission[3];
    ty_lpv_irradiance_at(&view, ty_vec_make((float)wall, 1.5f, 0.1f), right, transmission);
    assert_true(transmission[0] > 0);
    for (float height = -0.15f; height < 0.6f; height += 0.02f) {
        float here[3];
        ty_lpv_irradiance_at(&view, ty_vec_make((float)wall, (float)floor_height + height, 0.1f), right, here);
        if (fabsf(height) > 0.01f) assert_close(here[0], height > 0 ? transmission[0] : 0, 1e-4);
    }
    ty_lattice_destroy(lattice);
    ty_scene_destroy(scene);
}

/* A wall across the whole box, wherever it is: exactly the links that cross it are closed, and entirely. */
static void walls_close_links(void** state) {
    static const double places[5] = {0, 0.125, 0.03, -0.25, 0.2};
    const ty_grid_box box = cube_box(2, 16);
    ty_lpv_transfer transfer;
    ty_lpv_transfer_make(2, true, &transfer);
    for (int axis = 0; axis < 3; ++axis)
        for (int i = 0; i < 5; ++i) {
            ty_scene* scene = make_scene(*state);
            double at[3] = {-3, -3, -3}, u[3] = {0}, v[3] = {0};
            at[axis] = places[i];
            u[(axis + 1) % 3] = v[(axis + 2) % 3] = 6;
            add_quad(scene, at, u, v);
            ty_lattice* lattice = blocked_by(scene, &box, TY_LPV_MODE_LINKS, 3);
            assert_true(lattice->blocked);
            /* Between the middles of two layers of cells; at a middle, on either side. */
            const double layer = (places[i] + 2) / 0.25 + 1e-3;
            const int32_t after = (int32_t)floor(layer + 0.5);
            for (int32_t link = 0; link < TY_LPV_LINKS; ++link)
                for (size_t cell = 0; cell < lattice->cells; ++cell) {
                    const int32_t place[3] = {(int32_t)(cell % 16), (int32_t)(cell / 16 % 16), (int32_t)(cell / 256)};
                    const int32_t step = transfer.step[link][axis];
                    const bool closed = (step > 0 && place[axis] == after) || (step < 0 && place[axis] == after - 1);
                    assert_int_equal(lattice->transmission[link][cell], closed ? 0 : 255);
                }
            const size_t beside = (size_t)(axis == 0 ? after : 5) + 16 * (size_t)(axis == 1 ? after : 5) +
                                  256 * (size_t)(axis == 2 ? after : 5);
            assert_close((double)lattice->albedo[2][beside], 0.8, 1e-5);
            assert_close((double)lattice->albedo[2][0], axis >= 0 && after > 2 ? 0 : 0.8, 1e-5);
            ty_lattice_destroy(lattice);
            ty_scene_destroy(scene);
        }
}

/* Both ways through a link are alike, whatever is in it. */
static void links_are_alike_both_ways(void** state) {
    const ty_grid_box box = cube_box(2, 8);
    ty_lpv_transfer transfer;
    ty_lpv_transfer_make(2, true, &transfer);
    ty_scene* scene = make_scene(*state);
    add_solid(scene, TY_SHAPE_SPHERE, 1.3);
    ty_lattice* lattice = blocked_by(scene, &box, TY_LPV_MODE_LINKS, 4);
    int partly = 0;
    for (int32_t link = 0; link < TY_LPV_HALF_LINKS; ++link)
        for (int32_t z = 0; z < 8; ++z)
            for (int32_t y = 0; y < 8; ++y)
                for (int32_t x = 0; x < 8; ++x) {
                    const int32_t* step = transfer.step[link];
                    const int32_t to[3] = {x + step[0], y + step[1], z + step[2]};
                    if (to[0] < 0 || to[1] < 0 || to[2] < 0 || to[0] > 7 || to[1] > 7 || to[2] > 7) continue;
                    const uint8_t transmission = lattice->transmission[link][to[0] + 8 * (to[1] + 8 * to[2])];
                    assert_int_equal(transmission, lattice->transmission[link + 13][x + 8 * (y + 8 * z)]);
                    partly += transmission > 0 && transmission < 255;
                }
    assert_true(partly > 100);
    ty_lattice_destroy(lattice);
    ty_scene_destroy(scene);
}

/* The paper's blockers stop light that meets a surface's front more than what runs along it. */
static void fuzzy_blockers(void** state) {
    const ty_grid_box box = cube_box(2, 16);
    ty_lpv_transfer transfer;
    ty_scene* scene = make_scene(*state);
    add_quad(scene, (const double[3]){-3, 0, -3}, (const double[3]){0, 0, 6}, (const double[3]){6, 0, 0});
    ty_lattice* lattice = blocked_by(scene, &box, TY_LPV_MODE_PUBLISHED, 3);
    ty_lpv_transfer_make(2, false, &transfer);
    for (int32_t link = 0; link < TY_LPV_LINKS; ++link) {
        const int32_t* step = transfer.step[link];
        const int32_t from = step[1] < 0 ? 7 : 8; /* the plane is between cells 7 and 8 */
        const uint8_t transmission = lattice->transmission[link][5 + 16 * from + 256 * 5];
        if (step[1] < 0 && step[0] == 0 && step[2] == 0) assert_close((double)transmission / 255, 0.25, 0.06);
        if (step[1] > 0 && step[0] == 0 && step[2] == 0) assert_int_equal(transmission, 255);
        assert_int_equal(lattice->transmission[link][5 + 16 * 2 + 256 * 5], 255);
    }
    ty_lattice_destroy(lattice);
    ty_scene_destroy(scene);
}

/* ---- leaks ---- */

/* The walls of a room, a cell thick: its inside and its outside. */
static void add_room(ty_scene* scene, double half, double thickness, double turn) {
    for (int i = 0; i < 2; ++i) {
        ty_shape_def def = ty_default_shape_def();
        const double size = half + i * thickness, rotate[3] = {turn, 2 * turn, 0}, unit[3] = {1, 1, 1};
        def.kind = TY_SHAPE_BOX;
        set3(def.origin, -size, -size, -size);
        set3(def.u, size, size, size);
        set3f(def.albedo, 0.5f, 0.5f, 0.5f);
        def.transform = ty_affine_compose((const double[3]){0.041, -0.027, 0.013}, rotate, unit);
        check_result(ty_scene_context(scene), ty_scene_add_shape(scene, &def));
    }
}

/* Distance of a cell from the center of a lattice of 24, in cells. */
static int32_t cells_out(size_t cell) {
    int32_t out = 0;
    for (int a = 0; a < 3; ++a) {
        const int32_t place = (int32_t)(a == 0 ? cell % 24 : a == 1 ? cell / 24 % 24 : cell / 576) - 12;
        out = place >= 0 ? (place > out ? place : out) : (-1 - place > out ? -1 - place : out);
    }
    return out;
}

/* All around is lit, and the room stays dark, however it is turned. */
static void sealed_rooms_stay_dark(void** state) {
    static const double turns[3] = {0, 10, 33};
    const ty_grid_box box = cube_box(3, 24);
    for (int i = 0; i < 3; ++i) {
        ty_scene* scene = make_scene(*state);
        add_room(scene, 1, 0.25, turns[i]);
        ty_lattice* lattice = blocked_by(scene, &box, TY_LPV_MODE_LINKS, 3);
        const ty_lpv_def def = {.parts = TY_LPV_ALL, .bands = 2, .window = -1, .tolerance = 0.01};
        ty_lattice_power power = {.iterations = 0};
        double inside = 0, outside = 0;
        ty_ray_counter rays = {.rays = 0};
        check_result(*state, ty_lattice_find_crossings(lattice, scene, &rays));
        assert_true(rays.rays > 1000);
        for (size_t cell = 0; cell < lattice->cells; ++cell)
            for (int c = 0; c < 3; ++c) lattice->propagated_sh[c][0][cell] = cells_out(cell) > 9 ? 1 : 0;
        check_result(*state, ty_lattice_propagate(lattice, &def, NULL, NULL, NULL, NULL, &power));
        for (size_t cell = 0; cell < lattice->cells; ++cell) {
            const double light = (double)lattice->light[1][0][cell];
            if (cells_out(cell) < 2) inside = fmax(inside, light);
            if (cells_out(cell) == 8) outside = fmax(outside, light);
        }
        assert_true(outside > 0);
        assert_true(inside < 1e-4 * outside);
        ty_lattice_destroy(lattice);
        ty_scene_destroy(scene);
    }
}

/* ---- light ---- */

typedef struct lit_case {
    ty_scene* scene;
    ty_lattice* lattice;
    ty_grid_medium* medium;
    ty_rsm* map;
    ty_lpv_light lamp;
    ty_lpv_def def;
} lit_case;

/* Commits the scene, which it takes over. */
static lit_case lit(ty_scene* scene, const ty_grid_box* box, int32_t bands, int32_t side) {
    ty_context* context = ty_scene_context(scene);
    lit_case made = {.scene = scene,
                     .def = {.parts = TY_LPV_ALL, .bands = bands, .window = TY_AUTO, .samples = 8, .map_side = side}};
    const ty_rsm_def def = {.side = side, .reflective = true, .lower = box->lower, .upper = box->upper};
    check_result(context, ty_scene_commit(scene));
    made.lattice = lattice_of(context, box, bands);
    if (ty_scene_get_view(scene)->medium_count > 0) {
        ty_grid_box fit;
        check_result(context, ty_grid_box_fit(scene, 24, &fit));
        check_result(context, ty_grid_medium_create(scene, &fit, &made.medium));
        check_result(context, ty_grid_medium_create(scene, box, &made.lattice->medium));
    }
    check_result(context, ty_rsm_trace(scene, &def, 0, &made.map, NULL));
    made.lamp = (ty_lpv_light){.light = &ty_scene_get_view(scene)->lights.lights[0], .rsm = made.map};
    return made;
}

static void forget(lit_case* made) {
    ty_rsm_destroy(ty_scene_context(made->scene), made->map);
    ty_lattice_destroy(made->lattice);
    ty_grid_medium_destroy(made->medium);
    ty_scene_destroy(made->scene);
}

/* A lamp above a floor as wide as the lattice: the floor's share of what it sends is reflected, upwards. */
static void floors_reflect(void** state) {
    for (int32_t bands = 2; bands <= 3; ++bands) {
        const ty_grid_box box = cube_box(2, 16);
        ty_scene* scene = make_scene(*state);
        double power[3] = {1, 0, 0}, moment = 0;
        add_quad(scene, (const double[3]){-2, -1.03, -2}, (const double[3]){0, 0, 4}, (const double[3]){4, 0, 0});
        add_light(scene, TY_LIGHT_SPOT, (const double[3]){0.1, 0.5, 0}, (const double[3]){0, -1, 0});
        lit_case made = lit(scene, &box, bands, 128);
        check_result(*state, ty_lattice_inject_reflected(made.lattice, &made.def, &made.lamp, NULL, power));
        const double cone = 2 * pi * (1 - 0.5 * (cos(pi / 6) + (double)made.lamp.light->cos_inner));
        assert_close((power[0] - 1) / (3 * 0.2 * cone), 1, 3e-3);
        assert_close(power[2] / (1 * 0.8 * cone), 1, 3e-3);
        assert_close(flowing(made.lattice, 0) / (power[0] - 1), 1, 1e-4);
        /* All of it in the first layer above the floor: cell 4 is from -1 to -0.75. */
        for (size_t i = 0; i < made.lattice->cells; ++i) {
            if (i / 16 % 16 != 4) assert_close((double)made.lattice->propagated_sh[1][0][i], 0, 0);
            moment += (double)made.lattice->propagated_sh[1][1][i];
        }
        /* The mean cosine about the normal is 2/3. */
        const double factor = (double)ty_lpv_window(&made.def, 1) * 2 / 3;
        assert_close(moment * sqrt(4 * pi / 3) / power[1], factor, 1e-3);
        forget(&made);
    }
}

static void windows(void** state) {
    (void)state;
    ty_lpv_def def = {.bands = 2, .window = -1};
    assert_close((double)ty_lpv_window(&def, 1), 1, 0);
    def.bands = 3;
    assert_close((double)ty_lpv_window(&def, 0), 1, 0);
    assert_close((double)ty_lpv_window(&def, 2), 1 / 1.36, 1e-6);
    def.window = 0.5;
    assert_close((double)ty_lpv_window(&def, 1), 1.0 / 3, 1e-6);
}

/* Fog attenuates what reaches the floor, if it takes part. */
static void fog_is_on_the_way(void** state) {
    const double lower[3] = {-2, -2, -2}, upper[3] = {2, 2, 2};
    const ty_grid_box box = cube_box(2, 16);
    ty_scene* scene = make_scene(*state);
    const ty_medium_def fog = box_medium(lower, upper, 0.3f, 0.1f);
    double power[3] = {0, 0, 0}, clear[3] = {0, 0, 0};
    check_result(*state, ty_scene_add_medium(scene, &fog));
    add_quad(scene, (const double[3]){-2, -1, -2}, (const double[3]){0, 0, 4}, (const double[3]){4, 0, 0});
    direct_add_sun(scene, 0, -1, 0, 2);
    lit_case made = lit(scene, &box, 2, 64);
    check_result(*state, ty_lattice_inject_reflected(made.lattice, &made.def, &made.lamp, made.medium, power));
    made.def.parts &= ~(uint32_t)TY_LPV_SCATTERING;
    check_result(*state, ty_lattice_inject_reflected(made.lattice, &made.def, &made.lamp, made.medium, clear));
    assert_close(clear[1] / (0.4 * 2 * 16), 1, 1e-4);
    assert_close(power[1] / clear[1], exp(-0.4 * 3), 1e-4);
    forget(&made);
}

/* A point lamp in a ball of air, as far as the lattice reaches: 1 - e^-depth of each ray is scattered. */
static void fog_scatters(void** state) {
    static const float sigma[4] = {0.01f, 0.2f, 3, 40};
    static const ty_light_kind kinds[3] = {TY_LIGHT_POINT, TY_LIGHT_SPOT, TY_LIGHT_DIRECTIONAL};
    for (int kind = 0; kind < 3; ++kind)
        for (int i = 0; i < 4; ++i) {
            const double lower[3] = {-2, -2, -2}, upper[3] = {2, 2, 2};
            const ty_grid_box box = cube_box(2, 16);
            ty_scene* scene = make_scene(*state);
            ty_medium_def fog = box_medium(lower, upper, sigma[i], 0.5f * sigma[i]);
            double power[3] = {0, 0, 0}, expected = 0;
            fog.g[0] = fog.g[1] = fog.g[2] = 0.6f;
            check_result(*state, ty_scene_add_medium(scene, &fog));
            add_light(scene, kinds[kind], origin, down);
            lit_case made = lit(scene, &box, 3, 64);
            check_result(*state, ty_lattice_inject_scattered(made.lattice, &made.def, &made.lamp, made.medium, power));
            /* The same rays, by a box's closed form. */
            for (int32_t face = 0; face < made.map->faces; ++face)
                for (int32_t t = 0; t < 64 * 64; ++t) {
                    ty_vec from, way;
                    ty_rsm_ray(made.map, made.lamp.light, face, (float)(t % 64) + 0.5f, (float)(t / 64) + 0.5f, &from,
                               &way);
                    way = ty_normalize(way);
                    double profile = (double)ty_rsm_texel_measure(made.map, made.lamp.light, face, t % 64, t / 64);
                    if (kind == 1)
                        profile *= (double)ty_spot_falloff(made.lamp.light, ty_dot(way, made.lamp.light->direction));
                    const double o[3] = {(double)from.x, (double)from.y, (double)from.z};
                    const double w[3] = {(double)way.x, (double)way.y, (double)way.z};
                    double near = 0, far = 1e9;
                    for (int a = 0; a < 3; ++a) {
                        near = fmax(near, fmin((-2 - o[a]) / w[a], (2 - o[a]) / w[a]));
                        far = fmin(far, fmax((-2 - o[a]) / w[a], (2 - o[a]) / w[a]));
                    }
                    if (far > near) expected += 3 * profile * (1 - exp(-1.5 * (double)sigma[i] * (far - near))) / 1.5;
                }
            assert_close(power[0] / expected, 1, 2e-3);
            assert_close(power[2] / power[0], 1.0 / 3, 1e-5);
            assert_close(flowing(made.lattice, 0) / power[0], 1, 1e-4);
            forget(&made);
        }
}

/* Where it lands, and how it is turned: a thin beam of sun through fog. */
static void fog_scatters_forward(void** state) {
    const double lower[3] = {-2, -2, -2}, upper[3] = {2, 2, 2};
    const ty_grid_box box = cube_box(2, 8);
    ty_scene* scene = make_scene(*state);
    ty_medium_def fog = box_medium(lower, upper, 0.5f, 0);
    double power[3] = {0, 0, 0};
    fog.g[0] = fog.g[1] = fog.g[2] = 0.6f;
    check_result(*state, ty_scene_add_medium(scene, &fog));
    direct_add_sun(scene, 0, -1, 0, 1);
    lit_case made = lit(scene, &box, 2, 64);
    check_result(*state, ty_lattice_inject_scattered(made.lattice, &made.def, &made.lamp, made.medium, power));
    for (int32_t y = 0; y < 8; ++y) {
        double layer = 0, moment = 0;
        for (int32_t i = 0; i < 64; ++i) {
            const size_t cell = (size_t)(i % 8 + 8 * (y + 8 * (i / 8)));
            layer += sqrt(4 * pi) * (double)made.lattice->propagated_sh[0][0][cell];
            moment += sqrt(4 * pi / 3) * (double)made.lattice->propagated_sh[0][1][cell];
        }
        assert_close(layer / (16 * exp(-0.5 * (3.5 - 0.5 * y)) * (1 - exp(-0.25))), 1, 0.02);
        assert_close(moment / layer, -0.6, 1e-3);
    }
    forget(&made);
}

/* Media that vary: what a ray scatters is exact, whatever cells are like. */
static void smoke_scatters(void** state) {
    ty_scene* scene = make_scene(*state);
    ty_grid* grid = direct_noise(*state, 8, 8, 8, 3);
    ty_medium_def smoke = box_medium((const double[3]){-2, -2, -2}, (const double[3]){2, 2, 2}, 1, 0.25f);
    const ty_grid_box box = cube_box(2, 16);
    double power[3] = {0, 0, 0}, expected = 0;
    smoke.density_grid = grid;
    check_result(*state, ty_scene_add_medium(scene, &smoke));
    ty_grid_release(grid);
    direct_add_sun(scene, 0, -1, 0, 1);
    lit_case made = lit(scene, &box, 2, 64);
    const ty_grid_medium* m = made.medium;
    check_result(*state, ty_lattice_inject_scattered(made.lattice, &made.def, &made.lamp, m, power));
    for (int32_t z = 0; z < m->box.size[2]; ++z)
        for (int32_t x = 0; x < m->box.size[0]; ++x) {
            double depth = 0;
            for (int32_t y = 0; y < m->box.size[1]; ++y)
                depth += m->cell[1] * (double)m->extinction[0][x + m->box.size[0] * (y + m->box.size[1] * z)];
            expected += m->cell[0] * m->cell[2] * (1 - exp(-depth)) * 0.8;
        }
    assert_close(power[1] / expected, 1, 0.01);
    forget(&made);
}

/* Light that ends on a floor does not land in cells whose middle is below it. */
static void samples_stay_on_the_lit_side(void** state) {
    const ty_grid_box box = cube_box(2, 8);
    ty_scene* scene = make_scene(*state);
    const ty_medium_def fog = box_medium(box.lower, box.upper, 0.5f, 0);
    double power[3] = {0, 0, 0};
    check_result(*state, ty_scene_add_medium(scene, &fog));
    add_quad(scene, (const double[3]){-4, -0.15, -4}, (const double[3]){0, 0, 8}, (const double[3]){8, 0, 0});
    direct_add_sun(scene, 0.3, -1, 0.1, 1);
    lit_case made = lit(scene, &box, 2, 64);
    check_result(*state, ty_lattice_inject_scattered(made.lattice, &made.def, &made.lamp, made.medium, power));
    for (size_t i = 0; i < made.lattice->cells; ++i)
        if (i / 8 % 8 < 4) assert_close((double)made.lattice->propagated_sh[0][0][i], 0, 0);
    forget(&made);
}

/* A lamp that moves a little changes cells a little. */
static void small_steps(void** state) {
    ty_lattice* lattices[2];
    double change = 0, largest = 0;
    for (int i = 0; i < 2; ++i) {
        const ty_grid_box box = cube_box(2, 16);
        ty_scene* scene = make_scene(*state);
        const ty_medium_def fog = box_medium(box.lower, box.upper, 0.3f, 0);
        double power[3] = {0, 0, 0};
        check_result(*state, ty_scene_add_medium(scene, &fog));
        add_solid(scene, TY_SHAPE_SPHERE, 0.7);
        add_light(scene, TY_LIGHT_SPOT, (const double[3]){0.1 + 0.002 * i, 1.5, 0.2}, (const double[3]){0, -1, 0});
        lit_case made = lit(scene, &box, 2, 256);
        check_result(*state, ty_lattice_inject_reflected(made.lattice, &made.def, &made.lamp, made.medium, power));
        check_result(*state, ty_lattice_inject_scattered(made.lattice, &made.def, &made.lamp, made.medium, power));
        lattices[i] = made.lattice;
        made.lattice = NULL;
        forget(&made);
    }
    for (size_t i = 0; i < lattices[0]->cells; ++i) {
        change += fabs((double)(lattices[1]->propagated_sh[0][0][i] - lattices[0]->propagated_sh[0][0][i]));
        largest =
            fmax(largest, fabs((double)(lattices[1]->propagated_sh[0][0][i] - lattices[0]->propagated_sh[0][0][i])));
    }
    /* The lamp moved by 1/125 of a cell. */
    assert_true(change * sqrt(4 * pi) < 0.05 * flowing(lattices[0], 0));
    assert_true(largest * sqrt(4 * pi) < 0.003 * flowing(lattices[0], 0));
    for (int i = 0; i < 2; ++i) ty_lattice_destroy(lattices[i]);
}

static void threads_do_not_matter(void** state) {
    (void)state;
    ty_lattice* lattices[2];
    ty_context* contexts[2];
    for (int i = 0; i < 2; ++i) {
        const ty_grid_box box = cube_box(2, 16);
        contexts[i] = make_context(1 + 2 * i);
        ty_scene* scene = make_scene(contexts[i]);
        const ty_medium_def fog = box_medium(box.lower, box.upper, 0.3f, 0);
        double power[3] = {0, 0, 0};
        check_result(contexts[i], ty_scene_add_medium(scene, &fog));
        add_solid(scene, TY_SHAPE_SPHERE, 1.3);
        add_light(scene, TY_LIGHT_POINT, (const double[3]){0.1, 1.5, 0.2}, down);
        lit_case made = lit(scene, &box, 3, 64);
        check_result(contexts[i], ty_lattice_inject_reflected(made.lattice, &made.def, &made.lamp, made.medium, power));
        check_result(contexts[i], ty_lattice_inject_scattered(made.lattice, &made.def, &made.lamp, made.medium, power));
        ty_lattice* blocked = blocked_by(scene, &box, TY_LPV_MODE_LINKS, 3);
        for (int k = 0; k < TY_LPV_LINKS; ++k)
            memcpy(made.lattice->transmission[k], blocked->transmission[k], blocked->cells);
        ty_lattice_destroy(blocked);
        lattices[i] = made.lattice;
        made.lattice = NULL;
        forget(&made);
    }
    for (int t = 0; t < 9; ++t)
        assert_memory_equal(lattices[0]->propagated_sh[1][t], lattices[1]->propagated_sh[1][t],
                            lattices[0]->cells * sizeof(float));
    for (int k = 0; k < TY_LPV_LINKS; ++k)
        assert_memory_equal(lattices[0]->transmission[k], lattices[1]->transmission[k], lattices[0]->cells);
    for (int i = 0; i < 2; ++i) {
        ty_lattice_destroy(lattices[i]);
        ty_context_destroy(contexts[i]);
    }
}

/* Whatever is refused, nothing is lost. */
static void no_memory(void** state) {
    (void)state;
    strict_memory memory = {.limit = (size_t)1 << 30, .until_refusal = -1};
    ty_context* context = strict_context(&memory);
    const ty_grid_box box = cube_box(2, 8);
    ty_scene* scene = make_scene(context);
    const ty_medium_def fog = box_medium(box.lower, box.upper, 0.3f, 0);
    check_result(context, ty_scene_add_medium(scene, &fog));
    add_solid(scene, TY_SHAPE_SPHERE, 1.3);
    add_light(scene, TY_LIGHT_SPOT, (const double[3]){0, 1.8, 0}, down);
    lit_case made = lit(scene, &box, 2, 32);
    const size_t surface_depth_index =
        made.lattice->surface_depth_index != NULL ? made.lattice->cells * sizeof(int32_t) : 0;
    const size_t surface_depths = made.lattice->surface_depth_count * sizeof *made.lattice->surface_depths;
    size_t before = memory.used;
    for (int call = 0; call < 5; ++call) {
        if (call == 1) before -= surface_depth_index + surface_depths; /* what another call found */
        ty_result result = TY_ERROR_MEMORY;
        for (int64_t n = 0; result != TY_OK; ++n) {
            ty_surfel* surfels = NULL;
            size_t count = 0, capacity = 0;
            double power[3] = {0, 0, 0};
            const ty_surfel surfel = {.normal = {1, 0, 0}, .area = 0.01f};
            assert_true(n < 100);
            memory.until_refusal = n;
            if (call == 0) result = ty_surfels_trace(scene, &box, 3, &surfels, &count, &capacity, NULL);
            if (call == 1) result = ty_lattice_find_blockers(made.lattice, TY_LPV_MODE_LINKS, &surfel, 1);
            if (call == 2) result = ty_lattice_find_crossings(made.lattice, scene, NULL);
            if (call == 3)
                result = ty_lattice_inject_reflected(made.lattice, &made.def, &made.lamp, made.medium, power);
            if (call == 4)
                result = ty_lattice_inject_scattered(made.lattice, &made.def, &made.lamp, made.medium, power);
            memory.until_refusal = -1;
            if (result != TY_OK) assert_int_equal(result, TY_ERROR_MEMORY);
            if (n == 0) assert_int_equal(result, TY_ERROR_MEMORY);
            ty_free_array(context, surfels, capacity, sizeof *surfels);
            assert_int_equal(memory.used, before);
            ty_take_error(context);
        }
    }
    forget(&made);
    ty_context_destroy(context);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(surfels_have_the_area, start_context, stop_context),
        cmocka_unit_test_setup_teardown(walls_close_links, start_context, stop_context),
        cmocka_unit_test_setup_teardown(corners_are_lit, start_context, stop_context),
        cmocka_unit_test_setup_teardown(links_are_alike_both_ways, start_context, stop_context),
        cmocka_unit_test_setup_teardown(fuzzy_blockers, start_context, stop_context),
        cmocka_unit_test_setup_teardown(sealed_rooms_stay_dark, start_context, stop_context),
        cmocka_unit_test_setup_teardown(floors_reflect, start_context, stop_context),
        cmocka_unit_test(windows),
        cmocka_unit_test_setup_teardown(fog_is_on_the_way, start_context, stop_context),
        cmocka_unit_test_setup_teardown(fog_scatters, start_context, stop_context),
        cmocka_unit_test_setup_teardown(fog_scatters_forward, start_context, stop_context),
        cmocka_unit_test_setup_teardown(smoke_scatters, start_context, stop_context),
        cmocka_unit_test_setup_teardown(samples_stay_on_the_lit_side, start_context, stop_context),
        cmocka_unit_test_setup_teardown(small_steps, start_context, stop_context),
        cmocka_unit_test(threads_do_not_matter),
        cmocka_unit_test(no_memory),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
