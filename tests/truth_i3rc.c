/* The step cloud of the intercomparison of 3D radiation codes (I3RC phase I, case 1; Cahalan et al. 2005) against the
 * consensus of the participating codes: domain means here, and pixel by pixel where its files are in the folder of
 * third-party data, i3rc/I3RC_cons_res_case1_exp*.txt; and the radar cloud of case 2, whose field is there. */
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

static ty_flux* estimate_cloud(ty_context* context, const struct experiment* e, int32_t columns, int32_t spp) {
    static const double levels[2] = {0, 250};
    char zenith[64], thin[64], thick[64];
    snprintf(zenith, sizeof zenith, "lights[0].zenith=%g", e->zenith);
    snprintf(thin, sizeof thin, "media[0].albedo=%g", e->albedo);
    snprintf(thick, sizeof thick, "media[1].albedo=%g", e->albedo);
    const char* const overrides[] = {zenith, thin, thick};
    const ty_flux_view views[2] = {{0, 0}, {60, e->azimuth}};
    ty_scene* scene = NULL;
    ty_flux* flux = NULL;
    ty_path_def path = ty_default_path_def();
    ty_flux_def def = ty_default_flux_def();
    must(context, ty_scene_load(context, "builtin:step_cloud", overrides, 3, &scene));
    path.spp = spp;
    def.levels = levels;
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

static ty_scene* radar_scene(ty_context* context, ty_grid* grid, double zenith, double albedo) {
    ty_medium_def cloud = medium_of(albedo, 1 - albedo, 0.85);
    ty_light_def sun = light_of(TY_LIGHT_DIRECTIONAL, 1 / cos(zenith * pi / 180));
    ty_periodic_def periodic = ty_default_periodic_def();
    ty_scene* scene = NULL;
    must(context, ty_scene_create(context, TY_AXIS_Z, &scene));
    cloud.bounds = TY_BOUNDS_BOX;
    set3(cloud.box_max, 50 * RADAR_COLUMNS, 1000, 45 * RADAR_LAYERS);
    cloud.density_grid = grid;
    set3(sun.direction, sin(zenith * pi / 180), 0, -cos(zenith * pi / 180));
    periodic.axes[0] = periodic.axes[1] = true;
    must(context, ty_scene_set_periodic(scene, &periodic));
    add_medium(scene, &cloud);
    add_light(scene, &sun);
    commit(scene);
    return scene;
}

static void a_radar_cloud_is_the_consensus(void** state) {
    static const struct {
        double zenith, albedo, reflectance, transmittance, absorptance, nadir;
    } cases[] = {{0, 1, 0.559548, 0.441245, 0, 0.566647}, {60, 0.99, 0.551782, 0.200599, 0.247517, 0.412455}};
    static const double levels[2] = {0, 45 * RADAR_LAYERS};
    static const ty_flux_view nadir = {0, 0};
    char path[1024];
    data_path("i3rc/mmcr_tau_32km_020898", path);
    leave_to_full_runs();
    ty_grid* grid = read_radar_cloud(*state);
    for (int i = 0; i < 2; ++i) {
        ty_scene* scene = radar_scene(*state, grid, cases[i].zenith, cases[i].albedo);
        ty_path_def def = ty_default_path_def();
        ty_flux_def places = ty_default_flux_def();
        ty_flux* flux = NULL;
        def.spp = 1 << 18;
        places.levels = levels;
        places.level_count = 2;
        places.views = &nadir;
        places.view_count = 1;
        must(*state, ty_path_flux(scene, &def, &places, &flux, NULL));
        printf("radar cloud: sun at %g degrees, albedo %g\n", cases[i].zenith, cases[i].albedo);
        assert_agrees("reflectance", flux_mean(flux, TY_FLUX_UP, 1), cases[i].reflectance, 0.025);
        assert_agrees("transmittance", transmitted(flux), cases[i].transmittance, 0.025);
        if (cases[i].absorptance > 0)
            assert_agrees("absorptance", flux_mean(flux, TY_FLUX_ABSORBED, 0), cases[i].absorptance, 0.025);
        assert_agrees("nadir reflectivity", reflectivity(flux, 0), cases[i].nadir, 0.025);
        ty_flux_destroy(flux);
        ty_scene_destroy(scene);
    }
    ty_grid_release(grid);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(domain_means_are_the_consensus),
        cmocka_unit_test(pixels_are_the_consensus),
        cmocka_unit_test(a_radar_cloud_is_the_consensus),
    };
    return cmocka_run_group_tests(tests, truth_start, truth_stop);
}
