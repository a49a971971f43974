/* The step cloud of the intercomparison of 3D radiation codes (I3RC phase I, case 1; Cahalan et al. 2005) against the
 * consensus of the participating codes: domain means here, and pixel by pixel where its files are in the folder of
 * third-party data, i3rc/I3RC_cons_res_case1_exp*.txt; and the clouds of cases 2 and 3, whose fields are there. */
#include "truth.h"

enum { PIXELS = 32, EXPERIMENTS = 3 };

/* Means over the 32 pixels of the consensus files, which have five digits. Reflectivities are pi I / (mu0 F0). */
static const struct experiment {
    int number;
    double zenith, albedo;
    double reflectance, transmittance, absorptance, nadir; /* NaN: no consensus */
    const char* view;                                      /* slanted view */
    double azimuth, slanted;                               /* azimuth of the sensor, our way */
} experiments[EXPERIMENTS] = {
    {1, 0, 1, 0.327595, 0.672398, 0, 0.256396, "I602", 180, 0.404250},
    {2, 60, 1, 0.580444, NAN, 0, 0.406070, "I602", 180, 0.566741},
    {4, 60, 0.99, 0.476539, 0.324903, 0.198577, 0.322559, "I601", 0, 0.886163},
};

static const double cloud_levels[2] = {0, 250};

static ty_scene* load_cloud(ty_context* context, const struct experiment* e) {
    char zenith[64], thin[64], thick[64];
    snprintf(zenith, sizeof zenith, "lights[0].zenith=%g", e->zenith);
    snprintf(thin, sizeof thin, "media[0].albedo=%g", e->albedo);
    snprintf(thick, sizeof thick, "media[1].albedo=%g", e->albedo);
    const char* const overrides[] = {zenith, thin, thick};
    ty_scene* scene = NULL;
    must(context, ty_scene_load(context, "builtin:step_cloud", overrides, 3, &scene));
    return scene;
}

static ty_flux* estimate_cloud(ty_context* context, const struct experiment* e, int32_t columns, int32_t spp) {
    const ty_flux_view views[2] = {{0, 0}, {60, e->azimuth}};
    ty_scene* scene = load_cloud(context, e);
    ty_flux* flux = NULL;
    ty_path_def path = ty_default_path_def();
    ty_flux_def def = ty_default_flux_def();
    path.spp = spp;
    def.levels = cloud_levels;
    def.level_count = 2;
    def.columns[0] = columns;
    def.views = views;
    def.view_count = 2;
    must(context, ty_path_flux(scene, &path, &def, &flux, NULL));
    ty_scene_destroy(scene);
    return flux;
}

static estimate flux_mean(const ty_flux* flux, ty_flux_quantity quantity, int32_t index) {
    double mean[3], error[3];
    ty_flux_mean(flux, quantity, index, mean, error);
    return (estimate){mean[0], error[0]};
}

/* Down to the ground in all. */
static estimate transmitted(const ty_flux* flux) {
    const estimate diffuse = flux_mean(flux, TY_FLUX_DOWN_DIFFUSE, 0), direct = flux_mean(flux, TY_FLUX_DOWN_DIRECT, 0);
    return (estimate){diffuse.mean + direct.mean, hypot(diffuse.error, direct.error)};
}

static estimate reflectivity(const ty_flux* flux, int32_t view) {
    const estimate radiance = flux_mean(flux, TY_FLUX_RADIANCE, view);
    return (estimate){pi * radiance.mean, pi * radiance.error};
}

/* Within 3.5 standard errors and 0.1 % of the consensus, whose codes differ by as much; the standard error is at most
 * `noise`, relative. */
static void assert_agrees(const char* name, estimate measured, double expected, double noise) {
    printf("%-28s %.5f +- %.5f, consensus %.5f: %+.2f%%, %+.1f standard errors\n", name, measured.mean, measured.error,
           expected, 100 * (measured.mean / expected - 1), (measured.mean - expected) / measured.error);
    if (!(fabs(measured.mean - expected) <= 3.5 * measured.error + 0.001 * expected))
        fail_msg("%s: %.6g, not %.6g", name, measured.mean, expected);
    if (!(measured.error <= noise * expected)) fail_msg("%s: too noisy to tell", name);
}

static void domain_means_are_the_consensus(void** state) {
    const double noise = in_full() ? 0.006 : 0.03;
    for (int i = 0; i < EXPERIMENTS; ++i) {
        const struct experiment* e = &experiments[i];
        ty_flux* flux = estimate_cloud(*state, e, 1, fewer(1 << 20, 32));
        printf("experiment %d: sun at %g degrees, albedo %g\n", e->number, e->zenith, e->albedo);
        assert_agrees("reflectance", flux_mean(flux, TY_FLUX_UP, 1), e->reflectance, noise);
        if (isfinite(e->transmittance)) assert_agrees("transmittance", transmitted(flux), e->transmittance, noise);
        if (e->absorptance > 0)
            assert_agrees("absorptance", flux_mean(flux, TY_FLUX_ABSORBED, 0), e->absorptance, noise);
        assert_agrees("nadir reflectivity", reflectivity(flux, 0), e->nadir, noise);
        assert_agrees("reflectivity at 60 degrees", reflectivity(flux, 1), e->slanted, noise);
        ty_flux_destroy(flux);
    }
}

/* Within 1.5 % of the consensus: measured 1.03 % at most. */
static void assert_solved(const char* name, double value, double expected) {
    printf("%-28s %.5f, consensus %.5f: %+.2f%%\n", name, value, expected, 100 * (value / expected - 1));
    if (!(fabs(value - expected) <= 0.015 * expected)) fail_msg("%s: %.6g, not %.6g", name, value, expected);
}

static void dom_has_the_domain_means(void** state) {
    for (int i = 0; i < EXPERIMENTS; ++i) {
        const struct experiment* e = &experiments[i];
        ty_scene* scene = load_cloud(*state, e);
        const ty_dom_def dom = ty_default_dom_def();
        ty_flux_def def = ty_default_flux_def();
        ty_dom_stats stats = ty_default_dom_stats();
        ty_flux* flux = NULL;
        def.levels = cloud_levels;
        def.level_count = 2;
        must(*state, ty_dom_flux(scene, &dom, &def, &flux, &stats));
        printf("dom, experiment %d: %d sweeps\n", e->number, (int)stats.sweeps[0]);
        const double up = flux_mean(flux, TY_FLUX_UP, 1).mean, down = transmitted(flux).mean,
                     absorbed = flux_mean(flux, TY_FLUX_ABSORBED, 0).mean;
        assert_solved("reflectance", up, e->reflectance);
        if (isfinite(e->transmittance)) assert_solved("transmittance", down, e->transmittance);
        if (e->absorptance > 0) assert_solved("absorptance", absorbed, e->absorptance);
        if (!(fabs(up + down + absorbed - 1) <= 1e-3)) fail_msg("energy: %g is not 1", up + down + absorbed);
        ty_flux_destroy(flux);
        ty_scene_destroy(scene);
    }
}

static void read_consensus(const struct experiment* e, const char* quantity, double out[PIXELS]) {
    char name[96], path[1024];
    snprintf(name, sizeof name, "i3rc/I3RC_cons_res_case1_exp%d_%s.txt", e->number, quantity);
    FILE* stream = fopen(data_path(name, path), "r");
    assert_non_null(stream);
    for (int i = 0; i < PIXELS; ++i) assert_int_equal(fscanf(stream, "%lf", &out[i]), 1);
    fclose(stream);
}

/* Prints and checks the differences of pixels. noise: of the consensus itself, relative. */
static void compare_pixels(const char* name, const double* values, const double* errors, double factor,
                           const double expected[PIXELS], double noise) {
    double square = 0, worst = 0, off = 0, mean = 0;
    for (int i = 0; i < PIXELS; ++i) {
        const double difference = factor * values[3 * i] - expected[i];
        const double z = difference / hypot(factor * errors[3 * i], noise * expected[i]);
        square += z * z / PIXELS;
        worst = fmax(worst, fabs(z));
        off += difference * difference / PIXELS;
        mean += expected[i] / PIXELS;
    }
    printf("%-28s relative RMSE %.2f%%, mean z^2 %.2f, worst |z| %.2f\n", name, 100 * sqrt(off) / mean, square, worst);
    if (!(square < 2 && worst < 4.5)) fail_msg("%s: pixels differ by more than their noise", name);
}

/* Samples have heavy tails, so that few of them do not tell their own error. */
static void pixels_are_the_consensus(void** state) {
    char path[1024];
    data_path("i3rc/I3RC_cons_res_case1_exp1_R.txt", path);
    leave_to_full_runs();
    for (int i = 0; i < EXPERIMENTS; ++i) {
        const struct experiment* e = &experiments[i];
        double expected[PIXELS];
        read_consensus(e, "R", expected);
        ty_flux* flux = estimate_cloud(*state, e, PIXELS, 32768);
        printf("experiment %d\n", e->number);
        compare_pixels("reflectance", ty_flux_values(flux, TY_FLUX_UP, 1), ty_flux_errors(flux, TY_FLUX_UP, 1), 1,
                       expected, 0.003);
        read_consensus(e, "Iu", expected);
        compare_pixels("nadir reflectivity", ty_flux_values(flux, TY_FLUX_RADIANCE, 0),
                       ty_flux_errors(flux, TY_FLUX_RADIANCE, 0), pi, expected, 0.005);
        read_consensus(e, e->view, expected);
        compare_pixels("reflectivity at 60 degrees", ty_flux_values(flux, TY_FLUX_RADIANCE, 1),
                       ty_flux_errors(flux, TY_FLUX_RADIANCE, 1), pi, expected, 0.005);
        if (e->absorptance > 0) {
            read_consensus(e, "A", expected);
            compare_pixels("absorptance", ty_flux_values(flux, TY_FLUX_ABSORBED, 0),
                           ty_flux_errors(flux, TY_FLUX_ABSORBED, 0), 1, expected, 0.005);
        }
        ty_flux_destroy(flux);
    }
}

/* ---- case 2: a field of the ARM cloud radar, 640 columns of 50 m, 54 layers of 45 m, tau of each cell ---- */

enum { RADAR_COLUMNS = 640, RADAR_LAYERS = 54, FINE = 4 };

/* Extinction, 1/m. Cells are constant, and grids are interpolated linearly: FINE voxels per cell keep its steps. */
static ty_grid* read_radar_cloud(ty_context* context) {
    enum { NX = FINE * RADAR_COLUMNS, NZ = FINE * RADAR_LAYERS };
    char path[1024];
    FILE* stream = fopen(data_path("i3rc/mmcr_tau_32km_020898", path), "r");
    float* values = calloc((size_t)NX * NZ, sizeof *values);
    assert_true(stream != NULL && values != NULL);
    for (int layer = RADAR_LAYERS - 1; layer >= 0; --layer)
        for (int column = 0; column < RADAR_COLUMNS; ++column) {
            float tau;
            assert_int_equal(fscanf(stream, "%f", &tau), 1);
            for (int k = 0; k < FINE * FINE; ++k)
                values[(FINE * layer + k / FINE) * NX + FINE * column + k % FINE] = tau / 45;
        }
    fclose(stream);
    ty_grid_def def = ty_default_grid_def();
    def.size[0] = NX;
    def.size[1] = 1;
    def.size[2] = NZ;
    def.values = values;
    ty_grid* grid = NULL;
    must(context, ty_grid_create(context, &def, &grid));
    free(values);
    return grid;
}

/* A field that repeats across its box, over a Lambertian ground at height 0. */
static ty_scene* field_scene(ty_context* context, ty_grid* grid, const double lower[3], const double upper[3],
                             double zenith, double albedo, double ground) {
    ty_medium_def cloud = medium_of(albedo, 1 - albedo, 0.85);
    ty_light_def sun = light_of(TY_LIGHT_DIRECTIONAL, 1 / cos(zenith * pi / 180));
    ty_periodic_def periodic = ty_default_periodic_def();
    ty_scene* scene = NULL;
    must(context, ty_scene_create(context, TY_AXIS_Z, &scene));
    cloud.bounds = TY_BOUNDS_BOX;
    memcpy(cloud.box_min, lower, sizeof cloud.box_min);
    memcpy(cloud.box_max, upper, sizeof cloud.box_max);
    cloud.density_grid = grid;
    set3(sun.direction, sin(zenith * pi / 180), 0, -cos(zenith * pi / 180));
    periodic.axes[0] = periodic.axes[1] = true;
    must(context, ty_scene_set_periodic(scene, &periodic));
    add_medium(scene, &cloud);
    add_light(scene, &sun);
    if (ground > 0) {
        ty_shape_def plane = ty_default_shape_def();
        plane.kind = TY_SHAPE_QUAD;
        set3(plane.origin, -upper[0], -upper[1], 0);
        set3(plane.u, 3 * upper[0], 0, 0);
        set3(plane.v, 0, 3 * upper[1], 0);
        for (int c = 0; c < 3; ++c) plane.albedo[c] = (float)ground;
        must(context, ty_scene_add_shape(scene, &plane));
    }
    commit(scene);
    return scene;
}

/* Consensus of one experiment with a field; 0: there is none. */
typedef struct field_case {
    int number;
    double zenith, albedo, ground, reflectance, transmittance, absorptance, nadir;
} field_case;

static void assert_field(ty_context* context, const char* name, ty_grid* grid, const double lower[3],
                         const double upper[3], const field_case* c, int32_t spp, double noise) {
    const double levels[2] = {0, upper[2]};
    static const ty_flux_view nadir = {0, 0};
    ty_scene* scene = field_scene(context, grid, lower, upper, c->zenith, c->albedo, c->ground);
    ty_path_def def = ty_default_path_def();
    ty_flux_def places = ty_default_flux_def();
    ty_flux* flux = NULL;
    def.spp = spp;
    places.levels = levels;
    places.level_count = 2;
    places.views = &nadir;
    places.view_count = 1;
    must(context, ty_path_flux(scene, &def, &places, &flux, NULL));
    printf("%s, experiment %d: sun at %g degrees, albedo %g, ground %g\n", name, c->number, c->zenith, c->albedo,
           c->ground);
    if (c->reflectance > 0) assert_agrees("reflectance", flux_mean(flux, TY_FLUX_UP, 1), c->reflectance, noise);
    if (c->transmittance > 0) assert_agrees("transmittance", transmitted(flux), c->transmittance, noise);
    if (c->absorptance > 0) assert_agrees("absorptance", flux_mean(flux, TY_FLUX_ABSORBED, 0), c->absorptance, noise);
    if (c->nadir > 0) assert_agrees("nadir reflectivity", reflectivity(flux, 0), c->nadir, noise);
    ty_flux_destroy(flux);
    ty_scene_destroy(scene);
}

static void a_radar_cloud_is_the_consensus(void** state) {
    static const field_case cases[] = {{1, 0, 1, 0, 0.559548, 0.441245, 0, 0.566647},
                                       {4, 60, 0.99, 0, 0.551782, 0.200599, 0.247517, 0.412455},
                                       {5, 60, 1, 0.4, 0.757418, 0.405080, 0, 0.637617}};
    static const double lower[3] = {0, 0, 0}, upper[3] = {50 * RADAR_COLUMNS, 1000, 45 * RADAR_LAYERS};
    char path[1024];
    data_path("i3rc/mmcr_tau_32km_020898", path);
    leave_to_full_runs();
    ty_grid* grid = read_radar_cloud(*state);
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i)
        assert_field(*state, "radar cloud", grid, lower, upper, &cases[i], 1 << 18, 0.025);
    ty_grid_release(grid);
}

/* ---- case 3: a field of Landsat, 128 x 128 columns of 30 m, each of one extinction from 200 m up to its top ---- */

enum { LANDSAT_SIDE = 128, LANDSAT_LAYERS = 119, LANDSAT_FINE = 2 };
static const double landsat_layer = 20;

/* Extinction, 1/m, in layers of 20 m, the nearest number of which makes a column's thickness; LANDSAT_FINE voxels per
 * cell and axis. Lines of the file follow one another along y. */
static ty_grid* read_landsat_cloud(ty_context* context) {
    enum { SIDE = LANDSAT_FINE * LANDSAT_SIDE, NZ = LANDSAT_FINE * LANDSAT_LAYERS };
    char path[1024];
    FILE* depths = fopen(data_path("i3rc/scene43.tau.128x128", path), "r");
    FILE* heights = fopen(data_path("i3rc/scene43.dz.128x128", path), "r");
    float* values = calloc((size_t)SIDE * SIDE * NZ, sizeof *values);
    assert_true(depths != NULL && heights != NULL && values != NULL);
    for (int y = 0; y < LANDSAT_SIDE; ++y)
        for (int x = 0; x < LANDSAT_SIDE; ++x) {
            double tau, thickness; /* km */
            assert_int_equal(fscanf(depths, "%lf", &tau), 1);
            assert_int_equal(fscanf(heights, "%lf", &thickness), 1);
            const int layers = (int)lround(1000 * thickness / landsat_layer);
            for (int k = 0; k < LANDSAT_FINE * layers; ++k)
                for (int j = 0; j < LANDSAT_FINE; ++j)
                    for (int i = 0; i < LANDSAT_FINE; ++i)
                        values[((size_t)k * SIDE + (size_t)(LANDSAT_FINE * y + j)) * SIDE +
                               (size_t)(LANDSAT_FINE * x + i)] = (float)(tau / (layers * landsat_layer));
        }
    fclose(depths);
    fclose(heights);
    ty_grid_def def = ty_default_grid_def();
    def.size[0] = def.size[1] = SIDE;
    def.size[2] = NZ;
    def.values = values;
    ty_grid* grid = NULL;
    must(context, ty_grid_create(context, &def, &grid));
    free(values);
    return grid;
}

static void a_landsat_cloud_is_the_consensus(void** state) {
    static const field_case cases[] = {{1, 0, 1, 0, 0.304493, 0.695526, 0, 0.215210},
                                       {2, 60, 1, 0, 0, 0, 0, 0.330714},
                                       {3, 0, 0.99, 0, 0.242403, 0.627893, 0, 0.169844},
                                       {4, 60, 0.99, 0, 0.424553, 0.404369, 0.171110, 0}};
    const double lower[3] = {0, 0, 200}, upper[3] = {3840, 3840, 200 + LANDSAT_LAYERS * landsat_layer};
    char path[1024];
    data_path("i3rc/scene43.tau.128x128", path);
    if (!in_full()) skip();
    ty_grid* grid = read_landsat_cloud(*state);
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i)
        assert_field(*state, "Landsat cloud", grid, lower, upper, &cases[i], 1 << 17, 0.025);
    ty_grid_release(grid);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(domain_means_are_the_consensus),   cmocka_unit_test(dom_has_the_domain_means),
        cmocka_unit_test(pixels_are_the_consensus),         cmocka_unit_test(a_radar_cloud_is_the_consensus),
        cmocka_unit_test(a_landsat_cloud_is_the_consensus),
    };
    return cmocka_run_group_tests(tests, truth_start, truth_stop);
}
