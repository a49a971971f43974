/* A point source in a medium: what path tracing says, and what it should. */
#ifndef TY_TESTS_TRANSPORT_H
#define TY_TESTS_TRANSPORT_H

#include "figures/point_transport.h"
#include "truth.h"

enum { SOURCE_RADIUS = 10 }; /* of the medium, mean free paths */

/* The exact fluence in a ball of SOURCE_RADIUS mean free paths about the source. tau phi solves the slab problem of
 * thickness 2 R with an odd source in its middle (the two have the same kernel, E1). So far from the surface, in mean
 * free paths, its discrete part is A sinh(x / nu0), x: from a point outside that is known from Milne's problem:
 * 0.710446 for albedo 1, and to 1% that over the albedo where light gets as far. Its difference from the endless
 * medium's exp(-tau / nu0):
 */
static inline double transport_in_ball(double albedo, double tau) {
    const double y = transport_decay(albedo), end = SOURCE_RADIUS + 0.710446 / albedo;
    const double lost = y > 0 ? exp(-y * end) * sinh(y * tau) / sinh(y * end) : tau / end;
    return transport_fluence(albedo, tau) - transport_discrete(albedo) * lost / tau;
}

/* Fluence by path tracing at tau mean free paths from a source of unit intensity, over sigma_t^2; its uncollided part
 * is checked on the way. */
static inline estimate measure_source(ty_context* context, double albedo, double tau, int32_t items, int32_t spp) {
    const double sigma_t = 2.5, radius = tau / sigma_t;
    const double point[3] = {0.36 * radius, 0.8 * radius, -0.48 * radius};
    ty_scene* scene = new_scene(context);
    const ty_medium_def medium = medium_sphere(SOURCE_RADIUS / sigma_t, albedo * sigma_t, (1 - albedo) * sigma_t, 0);
    add_medium(scene, &medium);
    const ty_light_def light = light_of(TY_LIGHT_POINT, 1);
    add_light(scene, &light);
    commit(scene);
    double* fluence = new_numbers(3 * items);
    double* uncollided = new_numbers(3 * items);
    const int32_t size[3] = {items, 1, 1};
    ty_path_def def = ty_default_path_def();
    def.spp = spp;
    must(context, ty_path_fluence(scene, &def, point, point, size, fluence, uncollided, NULL));
    estimate result = estimate_of(fluence, items, 3);
    result.mean /= sigma_t * sigma_t;
    result.error /= sigma_t * sigma_t;
    for (int32_t item = 0; item < items; ++item)
        assert_true(fabs(uncollided[3 * item] / (exp(-tau) / (radius * radius)) - 1) < 1e-4);
    free(fluence);
    free(uncollided);
    ty_scene_destroy(scene);
    return result;
}

#endif
