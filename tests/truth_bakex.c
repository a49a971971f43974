#include "bake_maker.h"
int main(int argc, char** argv) {
    if (argc < 4) return 1;
    const double sigma = atof(argv[1]), half = atof(argv[2]), shift = atof(argv[3]);
    ty_context* context = truth_context(0);
    ty_scene* scene = new_scene(context);
    (void)shift;
    double c[3], n[3], u[3], v[3];
    for (int a = 0; a < 3; ++a) { c[a] = atof(argv[3 + a]); n[a] = atof(argv[6 + a]); }
    normalize3(n);
    const double up[3] = {fabs(n[2]) < 0.9 ? 0 : 1, 0, fabs(n[2]) < 0.9 ? 1 : 0};
    cross3(up, n, u); normalize3(u); cross3(n, u, v);
    ty_shape_def square = square_shape(c, u, v, half, 0);
    gray(square.albedo, 1);
    add_shape(scene, &square);
    ty_medium_def fog = medium_of(sigma, 0, 0);
    fog.bounds = TY_BOUNDS_SPHERE;
    fog.sphere_radius = 30;
    add_medium(scene, &fog);
    ty_light_def light = light_of(TY_LIGHT_POINT, 100);
    for (int a = 0; a < 3; ++a) light.position[a] = c[a] + 2 * n[a];
    add_light(scene, &light);
    commit(scene);
    ty_bake_receiver r = {.normal = {0, 0, 1}, .face = {0, 0, 1}, .margin = 1e-4f};
    for (int b = 1; b < 2; ++b)
        for (int method = 0; method < 4; method += 3)
            for (int back = 1; back < 2; ++back) {
                ty_bake_def def = ty_default_bake_def();
                ty_bake_light out;
                def.method = method;
                def.scatterings = b;
                def.bounces = method ? 0 : 0;
                def.back_scattering = back;
                def.spp = 1 << 17;
                must(context, ty_bake_surfaces(scene, &def, &r, 1, &out, NULL));
                printf("b %d method %d back %d:", b, method, back);
                for (int l = 0; l < 4; ++l) printf(" %.5g", out.irradiance[l][1]);
                printf(" +- %.2g\n", sqrt(out.variance[1]));
            }
}
