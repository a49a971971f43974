/* Tables of impulse responses against summing along rays, against exact transport about a point source, and against
 * what must be conserved. Distances and cosines lie on bins and between them. */
#include "checks.h"
#include "effort.h"

#include "figures/impulse_rays.h"
#include "figures/point_transport.h"

#include <stdio.h>

enum { TAUS = 10, COSINES = 14, RADII = 128, COLATITUDES = 33, BOUNCES = 4 };

static const double taus[TAUS] = {0.01, 0.034, 0.1, 0.37, 1, 2.3, 4.9, 9.1, 14.3, 20};
/* On angles of the tables, then between them. */
enum { ON = 6 };
static const double cosines[COSINES] = {0, 0.05, 0.2, 0.53, 0.79, 1, 0.01, 0.07, 0.115, 0.31, 0.48, 0.66, 0.83, 0.97};
static const double tolerance = 0.01; /* of the constant term */
/* Between angles, where axes differ, too: of the most irradiance. High harmonics at short distances go by the axis
 * alone there, and are not to be had from a few angles. */
static const double between_angles = 0.01;

/* With the most bounces that there are; made once. */
static ty_impulse* tables;

static int start(void** state) {
    ty_impulse_def def = ty_default_impulse_def();
    ty_impulse_stats stats = ty_default_impulse_stats();
    def.bounces = TY_IMPULSE_BOUNCES_MAX;
    def.folder = "";
    if (start_context(state) != 0 || ty_impulse_create(*state, &def, &tables, &stats) != TY_OK) return -1;
    printf("%d bounces: built in %.1f s\n", (int)def.bounces, stats.seconds);
    return 0;
}

static int stop(void** state) {
    ty_impulse_destroy(tables);
    return stop_context(state);
}

static double worst_of(const float is[TY_IMPULSE_TERMS], const double should[TY_IMPULSE_TERMS]) {
    double worst = 0;
    for (int l = 0; l < TY_IMPULSE_TERMS; ++l) worst = fmax(worst, fabs((double)is[l] - should[l]) / should[0]);
    return worst;
}

/* Error of the irradiance of a surface, over the largest irradiance of any. */
static double worst_irradiance(const float is[TY_IMPULSE_TERMS], const double should[TY_IMPULSE_TERMS]) {
    float expected[TY_IMPULSE_TERMS];
    double worst = 0, most = 0;
    for (int l = 0; l < TY_IMPULSE_TERMS; ++l) expected[l] = (float)should[l];
    for (int i = -10; i <= 10; ++i) {
        const double e = (double)ty_impulse_irradiance(expected, 0.1f * (float)i);
        worst = fmax(worst, fabs((double)ty_impulse_irradiance(is, 0.1f * (float)i) - e));
        most = fmax(most, e);
    }
    return worst / most;
}

static void once(ty_impulse_emitter emitter, int g, double tau, double cosine, ty_impulse_response* out) {
    const ty_impulse_medium medium = {1, 1, 0.5f * (float)(g - 1)};
    ty_impulse_look(tables, emitter, &medium, (float)tau, (float)cosine, 1, out);
}

/* One bounce alone. */
static void only(ty_impulse_emitter emitter, int32_t bounce, double tau, double cosine, float out[TY_IMPULSE_TERMS],
                 float* shift) {
    const ty_impulse_medium medium = {1, 1, 0};
    ty_impulse_response upto, before;
    ty_impulse_look(tables, emitter, &medium, (float)tau, (float)cosine, bounce, &upto);
    ty_impulse_look(tables, emitter, &medium, (float)tau, (float)cosine, bounce - 1, &before);
    for (int l = 0; l < TY_IMPULSE_TERMS; ++l) out[l] = upto.multiple[l] - before.multiple[l];
    *shift = upto.shift;
}

static void report(const char* name, double worst, double bound) {
    printf("%-40s within %.4f\n", name, worst);
    if (!(worst <= bound)) fail_msg("%s: off by %g", name, worst);
}

/* ---- single scattering ---- */

static void single_scattering_of_points_and_directions(void** state) {
    (void)state;
    const rays_scene point = {.source = rays_point, .top = HUGE_VAL};
    for (int g = 0; g < RAYS_PHASES; ++g) {
        double worst[2] = {0};
        for (int i = 0; i < TAUS; ++i) {
            const rays_scene beam = {.source = rays_directional, .emitter = {0, 0, -taus[i]}};
            const double at[3] = {0, 0, taus[i]}, below[3] = {0, 0, -taus[i]};
            double should[RAYS_PHASES][TY_IMPULSE_TERMS];
            ty_impulse_response is;
            rays_harmonics(&point, at, -1, 0, 8, 0, should);
            once(TY_IMPULSE_POINT, g, taus[i], 1, &is);
            worst[0] = fmax(worst[0], worst_of(is.single, should[g]));
            rays_harmonics(&beam, below, 1, 0, 24, 0, should);
            once(TY_IMPULSE_DIRECTIONAL, g, taus[i], 1, &is);
            worst[1] = fmax(worst[1], worst_of(is.single, should[g]));
        }
        char name[64];
        snprintf(name, sizeof name, "point, once, g %+.1f", 0.5 * (g - 1));
        report(name, worst[0], tolerance);
        snprintf(name, sizeof name, "directional, once, g %+.1f", 0.5 * (g - 1));
        report(name, worst[1], tolerance);
    }
}

static rays_area area_of(double cosine) {
    return (rays_area){{sqrt(1 - cosine * cosine), 0, cosine}};
}

static void single_scattering_of_areas(void** state) {
    (void)state;
    double worst[2][RAYS_PHASES] = {{0}};
    for (int c = 0; c < COSINES; ++c)
        for (int i = 0; i < TAUS; ++i) {
            const rays_area area = area_of(cosines[c]);
            const rays_scene scene = {.source = rays_area_light, .user = &area, .top = HUGE_VAL};
            const double at[3] = {0, 0, taus[i]};
            double should[RAYS_PHASES][TY_IMPULSE_TERMS];
            ty_impulse_response is;
            once(TY_IMPULSE_AREA, 1, taus[i], cosines[c], &is);
            rays_harmonics(&scene, at, -1, asin((double)is.shift), 4, 3, should);
            for (int g = 0; g < RAYS_PHASES; ++g) {
                once(TY_IMPULSE_AREA, g, taus[i], cosines[c], &is);
                const double off = c < ON ? worst_of(is.single, should[g]) : worst_irradiance(is.single, should[g]);
                worst[c >= ON][g] = fmax(worst[c >= ON][g], off);
            }
        }
    for (int g = 0; g < RAYS_PHASES; ++g) {
        char name[64];
        snprintf(name, sizeof name, "area, once, g %+.1f", 0.5 * (g - 1));
        report(name, worst[0][g], tolerance);
        snprintf(name, sizeof name, "area between angles, once, g %+.1f", 0.5 * (g - 1));
        report(name, worst[1][g], between_angles);
    }
}

/* ---- more ---- */

/* Fluence of one bounce, times exp(distance) and what makes it smooth near the emitter, on radii and, for areas,
 * colatitudes from the normal. */
typedef struct fluence {
    double normal[3];
    bool depth; /* by depth below z = 0, not by radius */
    double values[RADII][COLATITUDES];
} fluence;

static const double nearest = 1e-4, farthest = 60;

static double radius_of(double place) {
    return nearest * pow(farthest / nearest, place / (RADII - 1));
}

static double smooth(const fluence* f, double r) {
    return exp(r) * (f->depth ? 1 : r);
}

static double colatitude_of(int index) {
    return TY_PI_F64 * index / (COLATITUDES - 1);
}

/* Cubic through the four values about a place. */
static double cubic(const double* v, int stride, int count, double place) {
    const int from = (int)fmin(count - 4, fmax(0, floor(place) - 1));
    const double x = place - from;
    const double* p = v + from * stride;
    return -(x - 1) * (x - 2) * (x - 3) / 6 * p[0] + x * (x - 2) * (x - 3) / 2 * p[stride] -
           x * (x - 1) * (x - 3) / 2 * p[2 * stride] + x * (x - 1) * (x - 2) / 6 * p[3 * stride];
}

static double look_fluence(const void* user, const double point[3], double arrives[3]) {
    const fluence* f = user;
    (void)arrives;
    const double length = sqrt(point[0] * point[0] + point[1] * point[1] + point[2] * point[2]);
    const double r = fmax(nearest, f->depth ? -point[2] : length),
                 place = (RADII - 1) * log(r / nearest) / log(farthest / nearest);
    if (r >= farthest) return 0;
    if (f->depth || (f->normal[0] == 0 && f->normal[2] == 0))
        return cubic(&f->values[0][0], COLATITUDES, RADII, place) / smooth(f, r);
    const double cosine = (f->normal[0] * point[0] + f->normal[2] * point[2]) / length;
    const double across = acos(fmin(1, fmax(-1, cosine))) / TY_PI_F64 * (COLATITUDES - 1);
    const int low = (int)fmin(RADII - 4, fmax(0, floor(place) - 1));
    double near[4];
    for (int i = 0; i < 4; ++i) near[i] = cubic(f->values[low + i], 1, COLATITUDES, across);
    return cubic(near, 1, 4, place - low) / smooth(f, r);
}

/* The next bounce's fluence on the z axis. */
typedef struct step {
    rays_scene scene;
    fluence* to;
    int column;
    int tilts, turns;
} step;

static void fill_radius(void* user, int64_t index, int32_t worker) {
    const step* s = user;
    (void)worker;
    const double r = radius_of((double)index), at[3] = {0, 0, s->to->depth ? -r : r};
    double harmonics[RAYS_PHASES][TY_IMPULSE_TERMS];
    rays_scene scene = s->scene;
    if (s->to->depth) scene.emitter[2] = -r;
    rays_harmonics(&scene, at, s->to->depth ? 1 : -1, 0, s->tilts, s->turns, harmonics);
    s->to->values[index][s->column] = sqrt(4 * TY_PI_F64) * harmonics[1][0] * smooth(s->to, r);
}

static void more_scattering_of_points_and_directions(void** state) {
    static fluence light[2];
    for (int beam = 0; beam < 2; ++beam) {
        const ty_impulse_emitter emitter = beam ? TY_IMPULSE_DIRECTIONAL : TY_IMPULSE_POINT;
        rays_scene scene = {
            .source = beam ? rays_directional : rays_point, .top = beam ? 0 : HUGE_VAL, .isotropic = true};
        for (int bounce = 2; bounce <= BOUNCES; ++bounce) {
            fluence* to = &light[bounce % 2];
            *to = (fluence){.depth = beam};
            step s = {scene, to, 0, beam ? 12 : 4, 0};
            ty_parallel_for(*state, RADII, fill_radius, &s);
            scene.source = look_fluence;
            scene.user = to;
            double worst = 0;
            for (int i = 0; i < TAUS; ++i) {
                const double at[3] = {0, 0, beam ? -taus[i] : taus[i]};
                double should[RAYS_PHASES][TY_IMPULSE_TERMS];
                float is[TY_IMPULSE_TERMS], shift;
                if (beam) scene.emitter[2] = -taus[i];
                rays_harmonics(&scene, at, beam ? 1 : -1, 0, beam ? 24 : 8, 0, should);
                only(emitter, bounce, taus[i], 1, is, &shift);
                worst = fmax(worst, worst_of(is, should[1]));
            }
            char name[64];
            snprintf(name, sizeof name, "%s, bounce %d", beam ? "directional" : "point", bounce);
            report(name, worst, tolerance);
        }
    }
}

static void twice_scattered_light_of_areas(void** state) {
    static fluence light;
    for (int column = 0; column < COLATITUDES; ++column) {
        /* The receiver stays on the z axis; the emitter turns. */
        const rays_area area = {{sin(colatitude_of(column)), 0, cos(colatitude_of(column))}};
        step s = {{.source = rays_area_light, .user = &area, .top = HUGE_VAL, .isotropic = true}, &light, column, 2, 2};
        ty_parallel_for(*state, RADII, fill_radius, &s);
    }
    double worst[2] = {0};
    for (int c = 0; c < COSINES; ++c)
        for (int i = 1; i < TAUS; i += in_full() ? 2 : 8) {
            const double at[3] = {0, 0, taus[i]};
            double should[RAYS_PHASES][TY_IMPULSE_TERMS];
            float is[TY_IMPULSE_TERMS], shift;
            memcpy(light.normal, area_of(cosines[c]).normal, sizeof light.normal);
            const rays_scene scene = {.source = look_fluence, .user = &light, .top = HUGE_VAL, .isotropic = true};
            only(TY_IMPULSE_AREA, 2, taus[i], cosines[c], is, &shift);
            rays_harmonics(&scene, at, -1, asin((double)shift), 3, 2, should);
            const double off = c < ON ? worst_of(is, should[1]) : worst_irradiance(is, should[1]);
            worst[c >= ON] = fmax(worst[c >= ON], off);
        }
    report("area, bounce 2", worst[0], tolerance);
    report("area between angles, bounce 2", worst[1], between_angles);
}

/* ---- all of it ---- */

/* 64 bounces leave out less than albedo^65, and what has not come so far by then. */
static void all_bounces_are_exact_transport(void** state) {
    (void)state;
    static const struct { double albedo, farthest; } cases[] = {{0.3, 20}, {0.6, 20}, {0.8, 15}, {0.9, 10}};
    for (size_t c = 0; c < sizeof cases / sizeof cases[0]; ++c) {
        double worst = 0;
        for (int i = 0; i < TAUS && taus[i] <= cases[c].farthest; ++i) {
            const ty_impulse_medium medium = {1, (float)cases[c].albedo, 0};
            ty_impulse_response is;
            ty_impulse_look(tables, TY_IMPULSE_POINT, &medium, (float)taus[i], 1, TY_IMPULSE_BOUNCES_MAX, &is);
            const double scattered = sqrt(4 * TY_PI_F64) * (double)(is.single[0] + is.multiple[0]);
            const double should = transport_fluence(cases[c].albedo, taus[i]) - exp(-taus[i]) / (taus[i] * taus[i]);
            worst = fmax(worst, fabs(scattered / should - 1));
        }
        printf("albedo %g: scattered fluence is within %.4f of exact transport\n", cases[c].albedo, worst);
        assert_true(worst < tolerance);
    }
}

static void flux_through_spheres_is_the_power(void** state) {
    (void)state;
    static const double radii[] = {0.01, 0.1, 0.5, 1, 1.5, 2};
    static const float sigmas[] = {1, 0.25f, 8};
    for (size_t s = 0; s < 3; ++s)
        for (size_t i = 0; i < sizeof radii / sizeof radii[0]; ++i) {
            const ty_impulse_medium medium = {sigmas[s], sigmas[s], 0};
            const double r = radii[i] / (double)sigmas[s];
            ty_impulse_response is;
            ty_impulse_look(tables, TY_IMPULSE_POINT, &medium, (float)r, 1, TY_IMPULSE_BOUNCES_MAX, &is);
            /* Per unit of intensity and steradian. */
            const double net =
                exp(-radii[i]) + r * r * sqrt(4 * TY_PI_F64 / 3) * (double)(is.single[1] + is.multiple[1]);
            printf("sigma_t %g, tau %g: net flux is %.4f of the power\n", (double)sigmas[s], radii[i], net);
            assert_close(net, 1, 0.02);
        }
}

/* Fluence at the surface of a half space lit at right angles: H(1) of Chandrasekhar (1960), whose integral equation is
 * solved by repetition: 1 / H(mu) = sqrt(1 - albedo) + albedo / 2 integral of mu' H(mu') / (mu + mu'). */
static double h_function(double albedo) {
    enum { PANELS = 8 };
    double h[8 * PANELS], mu[8 * PANELS], weight[8 * PANELS], at_1 = 1;
    for (int i = 0; i < 8 * PANELS; ++i) {
        const double a = pow(i / 8 / (double)PANELS, 3), b = pow((i / 8 + 1) / (double)PANELS, 3);
        mu[i] = rays_at(a, b, i % 8, &weight[i]);
        h[i] = 1;
    }
    for (int round = 0; round < 300; ++round) {
        double next[8 * PANELS + 1];
        for (int i = 0; i <= 8 * PANELS; ++i) {
            const double x = i < 8 * PANELS ? mu[i] : 1;
            double sum = sqrt(1 - albedo);
            for (int j = 0; j < 8 * PANELS; ++j) sum += 0.5 * albedo * weight[j] * mu[j] * h[j] / (x + mu[j]);
            next[i] = 1 / sum;
        }
        memcpy(h, next, sizeof h);
        at_1 = next[8 * PANELS];
    }
    return at_1;
}

static void half_spaces_reflect_what_they_must(void** state) {
    (void)state;
    static const double albedos[] = {0.3, 0.6, 0.9};
    for (int i = 0; i < 3; ++i) {
        const ty_impulse_medium medium = {1, (float)albedos[i], 0};
        ty_impulse_response is;
        ty_impulse_look(tables, TY_IMPULSE_DIRECTIONAL, &medium, 1e-4f, 1, TY_IMPULSE_BOUNCES_MAX, &is);
        const double fluence_there = 1 + sqrt(4 * TY_PI_F64) * (double)(is.single[0] + is.multiple[0]);
        printf("albedo %g: fluence at the surface %.4f, H(1) = %.4f\n", albedos[i], fluence_there,
               h_function(albedos[i]));
        assert_close(fluence_there, h_function(albedos[i]), 0.01);
    }
}

/* Irradiance by eleven harmonics against rays, for surfaces that look all ways; of the most that there is. */
static void irradiance_is_that_of_rays(void** state) {
    (void)state;
    const rays_scene scene = {.source = rays_point, .top = HUGE_VAL, .isotropic = true};
    for (int i = 0; i < TAUS; i += 3) {
        double worst = 0, most = 0;
        for (int k = 0; k <= 6; ++k) {
            const double lean = TY_PI_F64 * k / 6, at[3] = {0, 0, taus[i]};
            ty_impulse_response is;
            once(TY_IMPULSE_POINT, 1, taus[i], 1, &is);
            double sum = 0;
            for (int a = 0; a < 8 * 8; ++a)
                for (int b = 0; b < 8 * 6; ++b) {
                    double by_theta, by_phi, radiance[RAYS_PHASES];
                    const double theta =
                        rays_at(TY_PI_F64 * (a / 8) / 8, TY_PI_F64 * (a / 8 + 1) / 8, a % 8, &by_theta);
                    const double phi = rays_at(TY_PI_F64 * (b / 8) / 6, TY_PI_F64 * (b / 8 + 1) / 6, b % 8, &by_phi);
                    const double way[3] = {sin(theta) * cos(phi), sin(theta) * sin(phi), -cos(theta)};
                    const double cosine = sin(lean) * way[0] - cos(lean) * way[2];
                    if (cosine <= 0) continue;
                    rays_radiance(&scene, at, way, radiance);
                    sum += 2 * by_theta * by_phi * sin(theta) * cosine * radiance[1];
                }
            worst = fmax(worst, fabs((double)ty_impulse_irradiance(is.single, (float)cos(lean)) - sum));
            most = fmax(most, sum);
        }
        printf("tau %g: irradiance is within %.4f of its most\n", taus[i], worst / most);
        assert_true(worst < 0.01 * most);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(single_scattering_of_points_and_directions),
        cmocka_unit_test(single_scattering_of_areas),
        cmocka_unit_test(more_scattering_of_points_and_directions),
        cmocka_unit_test(twice_scattered_light_of_areas),
        cmocka_unit_test(all_bounces_are_exact_transport),
        cmocka_unit_test(flux_through_spheres_is_the_power),
        cmocka_unit_test(half_spaces_reflect_what_they_must),
        cmocka_unit_test(irradiance_is_that_of_rays),
    };
    return cmocka_run_group_tests(tests, start, stop);
}
