/* Discrete ordinates against path tracing, and against what is known exactly: the unit cube in parallel light, a slab,
 * a point source. */
#include "transport.h"
#include "truth_cube.h"

#include <tyndall/dom.h>

/* ---- the unit cube ---- */

/* Of g 0.7, which three tests compare with: traced once. */
static const truth* truth_of_forward_cube(const ty_scene* scene) {
    static truth expected;
    static bool traced;
    if (!traced) trace(scene, 0.7, &expected);
    traced = true;
    return &expected;
}

static error measure(const ty_scene* scene, const ty_dom_def* def, const truth* expected) {
    ty_context* context = ty_scene_context(scene);
    double* fluence = new_numbers(3 * CELLS);
    ty_dom* light = NULL;
    ty_dom_stats stats = ty_default_dom_stats();
    must(context, ty_dom_solve(scene, def, &light, &stats));
    must(context, ty_dom_fluence(light, low, high, coarse, fluence, NULL));
    assert_true(stats.converged);
    if (!(fabs(stats.absorbed[0] + stats.leaving[0] - stats.emitted[0]) <= 1e-3 * stats.emitted[0]))
        fail_msg("emitted %g, absorbed %g, leaving %g", stats.emitted[0], stats.absorbed[0], stats.leaving[0]);
    const error result = error_of(fluence, expected);
    ty_dom_destroy(light);
    free(fluence);
    return result;
}

static void the_unit_cube(void** state) {
    static const double anisotropies[] = {0, 0.5, 0.7, 0.96};
    static const int32_t resolutions[] = {16, 32, 64};
    static truth traced;
    bool right = true;
    for (int i = 0; i < 4; ++i) {
        if (anisotropies[i] == 0.5 && !in_full()) continue; /* 0 and 0.7 enclose it */
        ty_scene* scene = cube_in_light(*state, anisotropies[i]);
        const truth* expected = &traced;
        if (anisotropies[i] == 0.7)
            expected = truth_of_forward_cube(scene);
        else
            trace(scene, anisotropies[i], &traced);
        for (int r = 0; r < (in_full() ? 3 : 2); ++r) {
            ty_dom_def def = ty_default_dom_def();
            def.resolution = resolutions[r];
            const error off = measure(scene, &def, expected);
            const bool peaked = anisotropies[i] > 0.9;
            printf("g %.2f, %2d^3: %.4f / %.4f (mean ratio / relative RMSE; noise %.4f)\n", anisotropies[i],
                   (int)resolutions[r], off.mean_ratio, off.rmse, expected->noise);
            right = right && fabs(off.mean_ratio - 1) <= (peaked ? 0.03 : 0.015) && off.rmse <= (peaked ? 0.06 : 0.03);
        }
        ty_scene_destroy(scene);
    }
    assert_true(right);
}

/* The walks that sharp lobes are held against tell what paths do. */
static void walks_are_paths(void** state) {
    ty_scene* scene = cube_in_light(*state, 0.7);
    double *walked = new_numbers(3 * CELLS), *fluence = new_numbers(3 * CELLS);
    const truth* expected = truth_of_forward_cube(scene);
    walk(0.7, fewer(8000000, 8), 7, walked);
    for (int i = 0; i < CELLS; ++i) fluence[3 * i] = mirrored(walked, i) + expected->uncollided[i];
    const error off = error_of(fluence, expected);
    printf("walks: %.4f / %.4f\n", off.mean_ratio, off.rmse);
    assert_true(fabs(off.mean_ratio - 1) <= 0.003 && off.rmse <= 0.02);
    free(walked);
    free(fluence);
    ty_scene_destroy(scene);
}

/* Whatever L is, the light is the same: the less of it is in the peak, the more ordinates carry. */
static void bands_agree(void** state) {
    ty_scene* scene = cube_in_light(*state, 0.7);
    const truth* expected = truth_of_forward_cube(scene);
    for (int32_t bands = 3; bands <= 6; ++bands) {
        ty_dom_def def = ty_default_dom_def();
        def.resolution = 16;
        def.bands = bands;
        const error off = measure(scene, &def, expected);
        printf("g 0.7, L = %d: %.4f / %.4f\n", (int)bands, off.mean_ratio, off.rmse);
        assert_true(fabs(off.mean_ratio - 1) <= 0.03 && off.rmse <= 0.05);
    }
    ty_scene_destroy(scene);
}

/* ---- a slab ---- */

/* Light of 1 W m^-2 comes down on a slab 1 m thick; of it R comes back and T goes through (with what does not scatter).
 */
typedef struct slab_case {
    double sigma_s, sigma_a, g, reflected, transmitted;
} slab_case;

/* So wide that what leaves by its sides is missed by less than the middle is measured to: 8 m lose 1 % of R, 6 m 4 %.
 */
enum { SLAB_WIDTH = 12, SLAB_CELLS = 192, SLAB_LAYERS = SLAB_CELLS / SLAB_WIDTH, WAYS = 4096 };

/* The net flux downwards at a point, of light that has scattered. */
static double flux_down(ty_context* context, const ty_dom* light, const double point[3]) {
    static double rays[6 * WAYS], radiance[3 * WAYS];
    double sum = 0;
    for (int i = 0; i < WAYS; ++i) {
        const double y = 1 - (2 * i + 1.0) / WAYS, angle = 2.399963229728653 * i, radius = sqrt(1 - y * y);
        memcpy(rays + 6 * i, point, 3 * sizeof *point);
        set3(rays + 6 * i + 3, radius * cos(angle), y, radius * sin(angle));
    }
    must(context, ty_dom_radiance(light, rays, WAYS, radiance));
    for (int i = 0; i < WAYS; ++i) sum -= radiance[3 * i] * rays[6 * i + 4] * 4 * pi / WAYS;
    return sum;
}

/* In the slab's middle: the flux through the middle of the first and the last layer, and what the halves of these that
 * are outside of it absorb. */
static void check_slab(ty_context* context, const slab_case* c) {
    static const int32_t layers[3] = {1, SLAB_LAYERS, 1}, one[3] = {1, 1, 1};
    const double half = 0.5 * SLAB_WIDTH / SLAB_CELLS;
    const double lower[3] = {half, 0, half}, upper[3] = {half, 1, half};
    ty_scene* scene = new_scene(context);
    ty_medium_def slab = medium_of(c->sigma_s, c->sigma_a, c->g);
    slab.bounds = TY_BOUNDS_BOX;
    set3(slab.box_min, -SLAB_WIDTH / 2, 0, -SLAB_WIDTH / 2);
    set3(slab.box_max, SLAB_WIDTH / 2, 1, SLAB_WIDTH / 2);
    add_medium(scene, &slab);
    ty_light_def sun = light_of(TY_LIGHT_DIRECTIONAL, 1);
    set3(sun.direction, 0, -1, 0);
    add_light(scene, &sun);
    commit(scene);
    ty_dom_def def = ty_default_dom_def();
    def.resolution = def.direct = SLAB_CELLS;
    ty_dom* light = NULL;
    must(context, ty_dom_solve(scene, &def, &light, NULL));
    double fluence[3 * SLAB_LAYERS], net[2];
    must(context, ty_dom_fluence(light, lower, upper, layers, fluence, NULL));
    for (int end = 0; end < 2; ++end) {
        const int layer = end == 0 ? SLAB_LAYERS - 1 : 0;
        const double y = (layer + 0.5) / SLAB_LAYERS, point[3] = {half, y, half};
        double at[3], beam[3];
        must(context, ty_dom_fluence(light, point, point, one, at, beam));
        const double absorbed = c->sigma_a * fluence[3 * layer] * 0.5 / SLAB_LAYERS;
        net[end] = flux_down(context, light, point) + beam[0] + (end == 0 ? absorbed : -absorbed);
    }
    printf("slab, sigma_s %g, sigma_a %g, g %g: R %.5f (%.5f), T %.5f (%.5f)\n", c->sigma_s, c->sigma_a, c->g,
           1 - net[0], c->reflected, net[1], c->transmitted);
    assert_true(fabs((1 - net[0]) / c->reflected - 1) <= 0.01 && fabs(net[1] / c->transmitted - 1) <= 0.01);
    ty_dom_destroy(light);
    ty_scene_destroy(scene);
}

/* van de Hulst 1980, Multiple Light Scattering, vol. 2, Table 35: a slab of optical thickness 2. */
static void slabs(void** state) {
    check_slab(*state, &(slab_case){1.8, 0.2, 0.75, 0.09739, 0.66096});
}

/* ---- a point source ---- */

enum { SOURCE_CELLS = 64 };

/* The exact fluence times tau^2, which is smooth, at many distances in mean free paths. */
enum { DISTANCES = 400 };
static const double table_end = 6.5;

static void tabulate(double albedo, double table[DISTANCES + 1]) {
    for (int i = 1; i <= DISTANCES; ++i) {
        const double tau = table_end * i / DISTANCES;
        table[i] = tau * tau * transport_in_ball(albedo, tau);
    }
    table[0] = table[1];
}

/* Its mean over a cell. */
static double exact_in_cell(const double table[DISTANCES + 1], const double middle[3], double cell) {
    enum { POINTS = 6 };
    double sum = 0;
    for (int p = 0; p < POINTS * POINTS * POINTS; ++p) {
        const int at[3] = {p % POINTS, p / POINTS % POINTS, p / (POINTS * POINTS)};
        double square = 0;
        for (int a = 0; a < 3; ++a) square += pow(middle[a] + cell * ((at[a] + 0.5) / POINTS - 0.5), 2);
        const double place = sqrt(square) * DISTANCES / table_end;
        const int i = (int)fmin(place, DISTANCES - 1);
        sum += (table[i] + (table[i + 1] - table[i]) * (place - i)) / square;
    }
    return sum / (POINTS * POINTS * POINTS);
}

/* Cells about the source, which is in a corner of some, by distance: shells half a mean free path thick. Ordinates miss
 * more of some cells the further from the source they are, and the less light scatters: rays. */
static void check_source(ty_context* context, double albedo, double most_rays) {
    enum { SHELLS = 12, HALF = SOURCE_CELLS / 2, COUNT = HALF * HALF * HALF };
    static const double lower[3] = {0, 0, 0}, upper[3] = {SOURCE_RADIUS, SOURCE_RADIUS, SOURCE_RADIUS};
    static const int32_t size[3] = {HALF, HALF, HALF};
    static const double shell = 0.5, cell = (double)SOURCE_RADIUS / HALF;
    static double table[DISTANCES + 1];
    double sum[SHELLS] = {0}, expected[SHELLS] = {0}, square[SHELLS] = {0}, count[SHELLS] = {0};
    tabulate(albedo, table);
    ty_scene* scene = new_scene(context);
    const ty_medium_def ball = medium_sphere(SOURCE_RADIUS, albedo, 1 - albedo, 0);
    add_medium(scene, &ball);
    const ty_light_def lamp = light_of(TY_LIGHT_POINT, 1);
    add_light(scene, &lamp);
    commit(scene);
    ty_dom_def def = ty_default_dom_def();
    def.resolution = def.direct = SOURCE_CELLS;
    ty_dom* light = NULL;
    double* fluence = new_numbers(3 * COUNT);
    must(context, ty_dom_solve(scene, &def, &light, NULL));
    must(context, ty_dom_fluence(light, lower, upper, size, fluence, NULL));
    for (int i = 0; i < COUNT; ++i) {
        const double middle[3] = {cell * (i % HALF + 0.5), cell * (i / HALF % HALF + 0.5),
                                  cell * (i / (HALF * HALF) + 0.5)};
        const double tau = sqrt(dot3(middle, middle));
        /* Cells that the symmetry of space repeats. */
        if (tau < 0.3 || tau >= SHELLS * shell || middle[1] > middle[0] || middle[2] > middle[1]) continue;
        const int at = (int)(tau / shell);
        const double exact = exact_in_cell(table, middle, cell);
        sum[at] += fluence[3 * i];
        expected[at] += exact;
        square[at] += pow(fluence[3 * i] / exact - 1, 2);
        ++count[at];
    }
    printf("point source, albedo %g, mean ratio (RMS over cells):", albedo);
    bool right = true;
    for (int i = 0; i < SHELLS; ++i) {
        if (count[i] == 0) continue;
        const double rays = sqrt(square[i] / count[i]);
        printf(" %.4f (%.3f)", sum[i] / expected[i], rays);
        right = right && fabs(sum[i] / expected[i] - 1) <= 0.03 && rays <= most_rays;
    }
    printf("\n");
    ty_dom_destroy(light);
    ty_scene_destroy(scene);
    free(fluence);
    assert_true(right);
}

static void point_sources(void** state) {
    check_source(*state, 0.5, 0.18);
    check_source(*state, 0.9, 0.05);
    check_source(*state, 1, 0.03);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(the_unit_cube), cmocka_unit_test(walks_are_paths),
                                       cmocka_unit_test(bands_agree), cmocka_unit_test(slabs),
                                       cmocka_unit_test(point_sources)};
    return cmocka_run_group_tests(tests, truth_start, truth_stop);
}
