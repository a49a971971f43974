/* Program of the build that integrates the tables of bsdf/tables.k.h and writes them as C: make_tables OUT.c.
 *
 * Directional albedos of microfacets are means over directions of visible normals, sampled at the points of a grid
 * (Heitz 2018), whose weight is G2 / G1. */
#include "scene/bsdf/dielectric.k.h"
#include "scene/bsdf/microfacet.k.h"
#include "scene/bsdf/sheen.k.h"
#include "scene/bsdf/tables.k.h"

#include <stdio.h>
#include <stdlib.h>

enum { CAP_STEPS = 192, TURN_STEPS = 64, MEAN_STEPS = 4096, SHEEN_STEPS = 128, VISIBLE_STEPS = 1024 };

static ty_bsdf_tables tables;

/* Direction towards the viewer. */
static ty_vec outgoing(float cosine) {
    return ty_vec_make(sqrtf(1.0f - cosine * cosine), 0.0f, cosine);
}

/* Albedo of microfacets of reflectance 1, and of (1 - v.h)^5. */
static void integrate_ggx(float cosine, float alpha, float* white, float* schlick) {
    const ty_vec wo = outgoing(cosine);
    const ty_vec stretched = ty_normalize(ty_vec_make(alpha * wo.x, 0.0f, wo.z));
    double sums[2] = {0, 0};
    for (int i = 0; i < CAP_STEPS; ++i)
        for (int j = 0; j < TURN_STEPS; ++j) {
            const float z = 1.0f - ((float)i + 0.5f) / CAP_STEPS * (1.0f + stretched.z);
            const float radius = sqrtf(fmaxf(0.0f, 1.0f - z * z));
            float sine, cosine_turn;
            ty_sincos_2pi(((float)j + 0.5f) / TURN_STEPS, &sine, &cosine_turn);
            const ty_vec cap = ty_add(ty_vec_make(radius * cosine_turn, radius * sine, z), stretched);
            const ty_vec h = ty_normalize(ty_vec_make(alpha * cap.x, alpha * cap.y, cap.z));
            const float projected = ty_dot(wo, h), cos_i = 2.0f * projected * h.z - wo.z;
            if (!(cos_i > 0.0f)) continue;
            /* G2 / G1 = 4 cos_i cos_o V (cos_o + root) / (2 cos_o) */
            const float weight =
                2.0f * cos_i * ty_ggx_visibility(cos_i, wo.z, alpha) * (wo.z + ty_ggx_smith_root(wo.z, alpha));
            sums[0] += (double)weight;
            sums[1] += (double)(weight * ty_schlick_weight(projected));
        }
    *white = (float)(sums[0] / (CAP_STEPS * TURN_STEPS));
    *schlick = (float)(sums[1] / (CAP_STEPS * TURN_STEPS));
}

/* Albedo of white sheen; directions are uniform in elevation, which is fine where sheen is brightest. */
static float integrate_sheen(float cosine, float alpha) {
    const ty_vec wo = outgoing(cosine);
    double sum = 0;
    for (int i = 0; i < SHEEN_STEPS; ++i)
        for (int j = 0; j < SHEEN_STEPS; ++j) {
            const float elevation = ((float)i + 0.5f) / SHEEN_STEPS * 0.5f * TY_PI;
            const float turn = ((float)j + 0.5f) / SHEEN_STEPS * TY_PI, radius = cosf(elevation);
            const ty_vec wi = ty_vec_make(radius * cosf(turn), radius * sinf(turn), sinf(elevation));
            sum += (double)(ty_sheen_brdf(wi, wo, alpha) * wi.z * radius);
        }
    return (float)(sum * 3.14159265358979323846 * 3.14159265358979323846 / (SHEEN_STEPS * SHEEN_STEPS));
}

/* Albedo of a rough dielectric interface for directions of single scattering. */
static float integrate_dielectric(float cosine, float alpha, float eta) {
    const ty_vec wo = outgoing(cosine);
    double sum = 0;
    for (int i = 0; i < VISIBLE_STEPS; ++i) {
        /* A lattice by the golden ratio. */
        const float u = ((float)i + 0.5f) / VISIBLE_STEPS, v = (float)fmod(i * 0.6180339887498949, 1);
        const ty_vec h = ty_ggx_sample_visible(wo, alpha, u, v);
        const float fresnel = ty_fresnel_dielectric(ty_dot(wo, h), eta);
        const ty_vec reflected = ty_reflect(wo, h), refracted = ty_refract(wo, h, eta);
        /* G2 / G1 = 4 cos_i cos_o V (cos_o + root) / (2 cos_o) */
        if (reflected.z > 0.0f)
            sum += (double)(fresnel * 2.0f * reflected.z * ty_ggx_visibility(reflected.z, wo.z, alpha) *
                            (wo.z + ty_ggx_smith_root(wo.z, alpha)));
        if (refracted.z < 0.0f && fresnel < 1.0f)
            sum += (double)((1.0f - fresnel) * -2.0f * refracted.z /
                            (ty_ggx_smith_root(refracted.z, alpha) - refracted.z));
    }
    return fminf((float)(sum / VISIBLE_STEPS), 1.0f);
}

/* The mean of the interpolated table, so that what is left to energy compensation adds up. */
static float mean_of(const float* table, float roughness) {
    double sum = 0;
    for (int i = 0; i < MEAN_STEPS; ++i) {
        const float cosine = ((float)i + 0.5f) / MEAN_STEPS;
        sum += (double)(2.0f * cosine * ty_bsdf_albedo(table, cosine, roughness));
    }
    return (float)(sum / MEAN_STEPS);
}

static void fill_tables(void) {
    for (int r = 0; r < TY_BSDF_ROUGHNESSES; ++r) {
        const float roughness = (float)r / (TY_BSDF_ROUGHNESSES - 1);
        for (int i = 0; i < TY_BSDF_COSINES; ++i) {
            const float cosine =
                fminf(fmaxf(ty_bsdf_coordinate_cosine((float)i / (TY_BSDF_COSINES - 1), roughness), 1e-5f), 1.0f);
            integrate_ggx(cosine, ty_ggx_alpha(roughness), &tables.reflected[r][i], &tables.schlick[r][i]);
            tables.sheen[r][i] = fminf(integrate_sheen(cosine, ty_sheen_alpha(roughness)), 1.0f);
        }
    }
    for (int r = 0; r < TY_BSDF_ROUGHNESSES; ++r) {
        const float roughness = (float)r / (TY_BSDF_ROUGHNESSES - 1);
        tables.reflected_mean[r] = mean_of(tables.reflected[0], roughness);
        tables.schlick_mean[r] = mean_of(tables.schlick[0], roughness);
    }
}

static void fill_dielectric(void) {
    for (int t = 0; t < 2 * TY_BSDF_IORS; ++t) {
        const float ior = fmaxf(ty_dielectric_table_ior(t % TY_BSDF_IORS), 1 + 1e-5f);
        float* table = tables.dielectric + t * TY_BSDF_ROUGHNESSES * TY_BSDF_COSINES;
        for (int r = 0; r < TY_BSDF_ROUGHNESSES; ++r) {
            const float roughness = (float)r / (TY_BSDF_ROUGHNESSES - 1);
            for (int i = 0; i < TY_BSDF_COSINES; ++i) {
                const float cosine =
                    fminf(fmaxf(ty_bsdf_coordinate_cosine((float)i / (TY_BSDF_COSINES - 1), roughness), 1e-5f), 1.0f);
                table[r * TY_BSDF_COSINES + i] =
                    integrate_dielectric(cosine, ty_ggx_alpha(roughness), t < TY_BSDF_IORS ? ior : 1 / ior);
            }
        }
        for (int r = 0; r < TY_BSDF_ROUGHNESSES; ++r)
            tables.dielectric_mean[t * TY_BSDF_ROUGHNESSES + r] = mean_of(table, (float)r / (TY_BSDF_ROUGHNESSES - 1));
    }
}

static void write_values(FILE* file, const char* name, const float* values, int count) {
    fprintf(file, "    .%s = {", name);
    for (int i = 0; i < count; ++i)
        fprintf(file, "%s%.9ef", i == 0 ? "" : i % 8 == 0 ? ",\n" : ", ", (double)values[i]);
    fprintf(file, "},\n");
}

static void write_rows(FILE* file, const char* name, const float (*rows)[TY_BSDF_COSINES]) {
    fprintf(file, "    .%s = {", name);
    for (int r = 0; r < TY_BSDF_ROUGHNESSES; ++r) {
        fprintf(file, "%s{", r == 0 ? "" : ",\n");
        for (int i = 0; i < TY_BSDF_COSINES; ++i)
            fprintf(file, "%s%.9ef", i == 0 ? "" : i % 8 == 0 ? ",\n" : ", ", (double)rows[r][i]);
        fprintf(file, "}");
    }
    fprintf(file, "},\n");
}

int main(int count, char** arguments) {
    FILE* file = count == 2 ? fopen(arguments[1], "w") : NULL;
    if (file == NULL) {
        fprintf(stderr, "usage: make_tables OUT.c\n");
        return EXIT_FAILURE;
    }
    fill_tables();
    fill_dielectric();
    fprintf(file, "#include \"scene/bsdf/tables.h\"\n\nconst ty_bsdf_tables ty_bsdf_default_tables = {\n");
    write_rows(file, "reflected", tables.reflected);
    write_rows(file, "schlick", tables.schlick);
    write_rows(file, "sheen", tables.sheen);
    write_values(file, "reflected_mean", tables.reflected_mean, TY_BSDF_ROUGHNESSES);
    write_values(file, "schlick_mean", tables.schlick_mean, TY_BSDF_ROUGHNESSES);
    write_values(file, "dielectric", tables.dielectric, 2 * TY_BSDF_IORS * TY_BSDF_ROUGHNESSES * TY_BSDF_COSINES);
    write_values(file, "dielectric_mean", tables.dielectric_mean, 2 * TY_BSDF_IORS * TY_BSDF_ROUGHNESSES);
    fprintf(file, "};\n");
    return fclose(file) == 0 ? EXIT_SUCCESS : EXIT_FAILURE;
}
