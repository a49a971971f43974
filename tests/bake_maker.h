/* Receivers on surfaces, and comparing bakes. */
#ifndef TY_TESTS_BAKE_MAKER_H
#define TY_TESTS_BAKE_MAKER_H

#include "truth.h"

#include <tyndall/bake.h>

#include <stdio.h>
#include <stdlib.h>

/* Receivers evenly on a scene's meshes that do not glow, `per` of them on each triangle, on the side that its normals
 * point to. */
static inline ty_bake_receiver* receivers_on_meshes(const ty_scene* scene, int32_t per, int64_t* count) {
    const ty_scene_info info = ty_scene_get_info(scene);
    ty_bake_receiver* out = NULL;
    *count = 0;
    for (int32_t m = 0; m < info.meshes; ++m) {
        ty_mesh_def mesh;
        if (ty_scene_get_mesh(scene, m, &mesh) != TY_OK) break;
        if (mesh.material.emission[1] > 0) continue;
        out = realloc(out, (size_t)(*count + mesh.triangle_count * per) * sizeof *out);
        assert_non_null(out);
        for (int64_t t = 0; t < mesh.triangle_count; ++t) {
            const float* at[3];
            double ab[3], ac[3], normal[3];
            for (int k = 0; k < 3; ++k) at[k] = mesh.positions + 3 * (size_t)mesh.indices[3 * t + k];
            for (int a = 0; a < 3; ++a) {
                ab[a] = (double)at[1][a] - (double)at[0][a];
                ac[a] = (double)at[2][a] - (double)at[0][a];
            }
            cross3(ab, ac, normal);
            normalize3(normal);
            for (int32_t i = 0; i < per; ++i) {
                double x[4];
                even_point(*count, x);
                const double u = 1 - sqrt(x[0]), v = sqrt(x[0]) * x[1];
                ty_bake_receiver* r = &out[(*count)++];
                *r = (ty_bake_receiver){.margin = 1e-4f};
                for (int a = 0; a < 3; ++a) {
                    r->position[a] = (float)((double)at[0][a] + u * ab[a] + v * ac[a]);
                    r->normal[a] = r->face[a] = (float)normal[a];
                }
            }
        }
    }
    return out;
}

static inline double total_of(const ty_bake_light* light, int channel) {
    double sum = 0;
    for (int layer = 0; layer < TY_BAKE_LAYERS; ++layer) sum += (double)light->irradiance[layer][channel];
    return sum;
}

static inline double scattered_of(const ty_bake_light* light, int channel) {
    return (double)light->irradiance[TY_BAKE_SINGLE][channel] + (double)light->irradiance[TY_BAKE_MULTIPLE][channel];
}

/* Of green irradiance: sum over sum, and the relative root mean square difference, the truth's noise taken off. */
typedef struct bake_difference {
    double ratio, rmse, scattered_ratio, scattered_part, noise;
} bake_difference;

static inline bake_difference compare_bakes(const ty_bake_light* is, const ty_bake_light* should, int64_t count) {
    double sum[2] = {0}, scattered[2] = {0}, square = 0, noise = 0;
    for (int64_t i = 0; i < count; ++i) {
        const double a = total_of(&is[i], 1), b = total_of(&should[i], 1);
        sum[0] += a;
        sum[1] += b;
        scattered[0] += scattered_of(&is[i], 1);
        scattered[1] += scattered_of(&should[i], 1);
        square += (a - b) * (a - b);
        noise += (double)is[i].variance[1] + (double)should[i].variance[1];
    }
    const double mean = sum[1] / (double)count;
    return (bake_difference){sum[0] / sum[1], sqrt(fmax(0, square - noise) / (double)count) / mean,
                             scattered[0] / scattered[1], scattered[1] / sum[1], sqrt(noise / (double)count) / mean};
}

#endif
