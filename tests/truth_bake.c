/* Bakes of fog by impulse responses against path tracing. */
#include "bake_maker.h"

/* The author's Cornell box, 5.56 m wide, full of fog. */
static ty_scene* cornell(ty_context* context, double sigma_s, double sigma_a) {
    char path[1024];
    ty_scene* scene = new_scene(context);
    ty_mesh_file_def file = ty_default_mesh_file_def();
    for (int a = 0; a < 3; ++a)
        for (int b = 0; b < 4; ++b) file.transform.m[4 * a + b] *= 0.01;
    must(context, ty_scene_add_mesh_file(scene, data_path("scenes/cornell_box_lightmap_uv.glb", path), &file));
    ty_medium_def fog = medium_of(sigma_s, sigma_a, 0);
    fog.bounds = TY_BOUNDS_BOX;
    set3(fog.box_min, -5.56, 0, -5.592);
    set3(fog.box_max, 0, 5.488, 0);
    if (sigma_s > 0) add_medium(scene, &fog);
    commit(scene);
    return scene;
}

int main(int argc, char** argv) {
    const double sigma = argc > 1 ? atof(argv[1]) : 0.1;
    const int spp = argc > 2 ? atoi(argv[2]) : 256, truth_spp = argc > 3 ? atoi(argv[3]) : 1024;
    const int first = argc > 4 ? atoi(argv[4]) : 0, detail = argc > 5;
    ty_context* context = truth_context(0);
    ty_scene* scene = cornell(context, sigma, 0);
    int64_t count;
    ty_bake_receiver* receivers = receivers_on_meshes(scene, 12, &count);
    int64_t kept = 0;
    for (int64_t i = 0; i < count; ++i) /* not what the lamp, two-sided and 8 mm below the ceiling, lights from there */
        if (receivers[i].position[1] < 5.487f || fabsf(receivers[i].position[0] + 2.78f) > 1 || fabsf(receivers[i].position[2] + 2.8f) > 1) receivers[kept++] = receivers[i];
    count = kept;
    ty_bake_light* is = calloc((size_t)count, sizeof *is);
    ty_bake_light* should = calloc((size_t)count, sizeof *should);
    ty_impulse* tables;
    ty_impulse_def impulse = ty_default_impulse_def();
    must(context, ty_impulse_create(context, &impulse, &tables, NULL));
    static const int scatterings[3] = {1, 2, 10};
    ty_bake_stats stats;
    for (int b = first; b < 3; ++b) {
        ty_bake_def def = ty_default_bake_def();
        def.method = TY_BAKE_PATH;
        def.scatterings = scatterings[b];
        def.spp = truth_spp;
        def.seed = 1;
        def.bounces = getenv("B") ? 2 : 0;
        must(context, ty_bake_surfaces(scene, &def, receivers, count, should, &stats));
        printf("%d receivers, truth %.1f s; ", (int)count, stats.seconds);
        def.spp = spp;
        def.bounces = getenv("B") ? 1 : 0;
        def.tables = tables;
        for (int back = 0; back < 2; ++back) {
            def.method = TY_BAKE_IMPULSE;
            def.back_scattering = back;
            must(context, ty_bake_surfaces(scene, &def, receivers, count, is, &stats));
            const bake_difference d = compare_bakes(is, should, count);
            printf("%d scatterings, back %d: ratio %.4f rmse %.4f noise %.4f scattered ratio %.4f part %.4f (%.2f s)\n",
                   scatterings[b], back, d.ratio, d.rmse, d.noise, d.scattered_ratio, d.scattered_part, stats.seconds);
            for (int layer = 0; layer < 4; ++layer) {
                double a = 0, t = 0;
                for (int64_t i = 0; i < count; ++i) {
                    a += is[i].irradiance[layer][1];
                    t += should[i].irradiance[layer][1];
                }
                printf("   layer %d: %.5g against %.5g, %.4f\n", layer, a / (double)count, t / (double)count, a / t);
            }
            if (detail && back)
                for (int64_t i = 0; i < count; i += 12) {
                    double s[2][4] = {{0}};
                    for (int64_t k = i; k < i + 12; ++k)
                        for (int layer = 0; layer < 4; ++layer) {
                            s[0][layer] += is[k].irradiance[layer][1] / 12;
                            s[1][layer] += should[k].irradiance[layer][1] / 12;
                        }
                    printf("%3d (%5.2f %5.2f %5.2f) n (%.1f %.1f %.1f): ", (int)(i / 12), receivers[i].position[0],
                           receivers[i].position[1], receivers[i].position[2], receivers[i].normal[0],
                           receivers[i].normal[1], receivers[i].normal[2]);
                    for (int layer = 0; layer < 4; ++layer) printf(" %.4g/%.4g", s[0][layer], s[1][layer]);
                    printf("\n");
                }
        }
    }

    for (int method = 0; method < 3; ++method) {
        ty_bake_def def = ty_default_bake_def();
        def.method = (ty_bake_method)method;
        def.spp = spp;
        def.tables = tables;
        must(context, ty_bake_surfaces(scene, &def, receivers, count, is, &stats));
        printf("method %d: %.3f s, %.3g rays/s, %.3g rays\n", method, stats.seconds, stats.rays / stats.seconds, (double)stats.rays);
    }
    return 0;
}
