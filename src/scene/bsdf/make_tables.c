/* Program of the build that integrates the tables of bsdf/tables.k.h and writes them as C: make_tables OUT.c.
 *
 * Directional albedos of microfacets are means over directions of visible normals, sampled at the points of a grid
 * (Heitz 2018), whose weight is G2 / G1. */
#include "base/constants.h"
#include "scene/bsdf/dielectric.k.h"
#include "scene/bsdf/microfacet.k.h"
#include "scene/bsdf/tables.k.h"

#include <stdio.h>
#include <stdlib.h>

enum { CAP_STEPS = 192, TURN_STEPS = 64, MEAN_STEPS = 4096, SHEEN_STEPS = 128, VISIBLE_STEPS = 1024 };

/* Of a step in t^2 and in azimuth: elevations reach pi / 2, azimuths twice pi. */
#define SHEEN_STEP_AREA (TY_PI_F64 * TY_PI_F64 / (SHEEN_STEPS * SHEEN_STEPS))

static ty_bsdf_tables tables;

/* Direction towards the viewer. */
static ty_vec outgoing(float cosine) {
    return ty_vec_make(sqrtf(1.0f - cosine * cosine), 0.0f, cosine);
}

/* Adds light from a cosine to the nodes beside it. */
static void add_source(double source[TY_BSDF_NODES], float cosine, double light) {
    float fraction;
    const int node = ty_bsdf_node_below(cosine, &fraction);
    source[node] += light * (double)(1.0f - fraction);
    source[node + 1] += light * (double)fraction;
}

/* Albedo of microfacets of reflectance 1, and of (1 - v.h)^5; where the light of 1 - (1 - v.h)^5, and of (1 - v.h)^5,
 * comes from, if asked for. */
static void integrate_ggx(float cosine, float alpha, float* white, float* schlick, double (*source)[TY_BSDF_NODES]) {
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
            const float fresnel = ty_schlick_weight(projected);
            sums[0] += (double)weight;
            sums[1] += (double)(weight * fresnel);
            if (source == NULL) continue;
            add_source(source[TY_BELOW_WHITE], cos_i, (double)(weight * (1.0f - fresnel)) / (CAP_STEPS * TURN_STEPS));
            add_source(source[TY_BELOW_SCHLICK], cos_i, (double)(weight * fresnel) / (CAP_STEPS * TURN_STEPS));
        }
    *white = (float)(sums[0] / (CAP_STEPS * TURN_STEPS));
    *schlick = (float)(sums[1] / (CAP_STEPS * TURN_STEPS));
}

/* Albedo of white sheen, divided by ty_bsdf_sheen_bound if bounded, and where its light comes from, if asked for.
 * Elevations pi / 2 t^2 of equal steps in t are fine where sheen is brightest. */
static float integrate_sheen(float cosine, float roughness, bool bounded, double source[TY_BSDF_NODES]) {
    const ty_vec wo = outgoing(cosine);
    const float alpha = ty_sheen_alpha(roughness);
    double sum = 0;
    for (int i = 0; i < SHEEN_STEPS; ++i)
        for (int j = 0; j < SHEEN_STEPS; ++j) {
            const float t = ((float)i + 0.5f) / SHEEN_STEPS, elevation = 0.5f * TY_PI * t * t;
            const float turn = ((float)j + 0.5f) / SHEEN_STEPS * TY_PI, radius = cosf(elevation);
            const ty_vec wi = ty_vec_make(radius * cosf(turn), radius * sinf(turn), sinf(elevation));
            const float bound = bounded ? ty_bsdf_sheen_bound(&tables, wi.z, cosine, roughness) : 1.0f;
            const double light =
                (double)(ty_sheen_brdf(wi, wo, alpha) * wi.z * radius * 2.0f * t / bound) * SHEEN_STEP_AREA;
            sum += light;
            if (source != NULL) add_source(source, wi.z, light);
        }
    return (float)sum;
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

/* The mean of the interpolated table, so that the light left to energy compensation adds up. */
static float mean_of(const float* table, float roughness) {
    double sum = 0;
    for (int i = 0; i < MEAN_STEPS; ++i) {
        const float cosine = ((float)i + 0.5f) / MEAN_STEPS;
        sum += (double)(2.0f * cosine * ty_bsdf_albedo(table, cosine, roughness));
    }
    return (float)(sum / MEAN_STEPS);
}

static float clamp_cosine(float cosine) {
    return fminf(fmaxf(cosine, 1e-5f), 1.0f);
}

static void fill_tables(void) {
    for (int r = 0; r < TY_BSDF_ROUGHNESSES; ++r) {
        const float row = (float)r / (TY_BSDF_ROUGHNESSES - 1);
        for (int i = 0; i < TY_BSDF_COSINES; ++i) {
            const float x = (float)i / (TY_BSDF_COSINES - 1), cosine = ty_bsdf_coordinate_cosine(x, row);
            integrate_ggx(clamp_cosine(cosine), ty_ggx_alpha(row), &tables.reflected[r][i], &tables.schlick[r][i],
                          NULL);
            tables.sheen[r][i] = integrate_sheen(clamp_cosine(x * x), ty_bsdf_sheen_roughness(row), false, NULL);
        }
    }
    for (int r = 0; r < TY_BSDF_ROUGHNESSES; ++r) {
        const float row = (float)r / (TY_BSDF_ROUGHNESSES - 1);
        for (int i = 0; i < TY_BSDF_COSINES; ++i) {
            const float x = (float)i / (TY_BSDF_COSINES - 1);
            const float albedo = integrate_sheen(clamp_cosine(x * x), ty_bsdf_sheen_roughness(row), true, NULL);
            tables.sheen_kept[r][i] = fminf(albedo, 1.0f);
        }
        tables.reflected_mean[r] = mean_of(tables.reflected[0], row);
        tables.schlick_mean[r] = mean_of(tables.schlick[0], row);
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
        for (int r = 0; r < TY_BSDF_MEANS; ++r)
            tables.dielectric_mean[t * TY_BSDF_MEANS + r] = mean_of(table, (float)r / (TY_BSDF_MEANS - 1));
    }
}

/* Weights of the nodes in the integral of 2 c times values that are interpolated between them. */
static void fill_node_weights(void) {
    for (int j = 0; j + 1 < TY_BSDF_NODES; ++j) {
        const float a = ty_bsdf_node_cosine(j), b = ty_bsdf_node_cosine(j + 1);
        tables.node_weight[j] += (b - a) * (2 * a + b) / 3;
        tables.node_weight[j + 1] += (b - a) * (a + 2 * b) / 3;
    }
}

static void fill_nodes(void) {
    for (int r = 0; r < TY_BSDF_ROUGHNESSES; ++r)
        for (int j = 0; j < TY_BSDF_NODES; ++j) {
            const float row = (float)r / (TY_BSDF_ROUGHNESSES - 1), cosine = ty_bsdf_node_cosine(j);
            tables.node_reflected[r][j] = ty_bsdf_albedo(tables.reflected[0], cosine, row);
            tables.node_schlick[r][j] = ty_bsdf_albedo(tables.schlick[0], cosine, row);
            tables.node_sheen[r][j] = ty_bsdf_sheen_value(tables.sheen_kept[0], cosine, ty_bsdf_sheen_roughness(row));
        }
    for (int r = 0; r < TY_BSDF_NODE_ROUGHNESSES; ++r)
        for (int k = 0; k < TY_BSDF_NODES; ++k) {
            const float row = (float)r / (TY_BSDF_NODE_ROUGHNESSES - 1);
            const float cosine = clamp_cosine(ty_bsdf_node_cosine(k));
            double source[TY_BELOW_COUNT][TY_BSDF_NODES] = {{0}};
            float white, schlick;
            integrate_ggx(cosine, ty_ggx_alpha(row), &white, &schlick, source);
            integrate_sheen(cosine, ty_bsdf_sheen_roughness(row), true, source[TY_BELOW_SHEEN]);
            for (int lobe = 0; lobe < TY_BELOW_COUNT; ++lobe)
                for (int j = 0; j < TY_BSDF_NODES; ++j)
                    tables.source[lobe * TY_BSDF_NODE_ROUGHNESSES + r][k * TY_BSDF_NODES + j] = (float)source[lobe][j];
        }
    fill_node_weights();
}

static void write_row(FILE* file, const float* values, int count) {
    for (int i = 0; i < count; ++i)
        fprintf(file, "%s%.9ef", i == 0 ? "" : i % 8 == 0 ? ",\n" : ", ", (double)values[i]);
}

static void write_values(FILE* file, const char* name, const float* values, int count) {
    fprintf(file, "    .%s = {", name);
    write_row(file, values, count);
    fprintf(file, "},\n");
}

static void write_rows(FILE* file, const char* name, const float* values, int rows, int columns) {
    fprintf(file, "    .%s = {", name);
    for (int r = 0; r < rows; ++r) {
        fprintf(file, "%s{", r == 0 ? "" : ",\n");
        write_row(file, values + r * columns, columns);
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
    fill_nodes();
    fill_dielectric();
    fprintf(file, "#include \"scene/bsdf/tables.h\"\n\nconst ty_bsdf_tables ty_bsdf_default_tables = {\n");
    write_rows(file, "reflected", tables.reflected[0], TY_BSDF_ROUGHNESSES, TY_BSDF_COSINES);
    write_rows(file, "schlick", tables.schlick[0], TY_BSDF_ROUGHNESSES, TY_BSDF_COSINES);
    write_rows(file, "sheen", tables.sheen[0], TY_BSDF_ROUGHNESSES, TY_BSDF_COSINES);
    write_rows(file, "sheen_kept", tables.sheen_kept[0], TY_BSDF_ROUGHNESSES, TY_BSDF_COSINES);
    write_rows(file, "node_reflected", tables.node_reflected[0], TY_BSDF_ROUGHNESSES, TY_BSDF_NODES);
    write_rows(file, "node_schlick", tables.node_schlick[0], TY_BSDF_ROUGHNESSES, TY_BSDF_NODES);
    write_rows(file, "node_sheen", tables.node_sheen[0], TY_BSDF_ROUGHNESSES, TY_BSDF_NODES);
    write_rows(file, "source", tables.source[0], TY_BELOW_COUNT * TY_BSDF_NODE_ROUGHNESSES,
               TY_BSDF_NODES * TY_BSDF_NODES);
    write_values(file, "node_weight", tables.node_weight, TY_BSDF_NODES);
    write_values(file, "reflected_mean", tables.reflected_mean, TY_BSDF_ROUGHNESSES);
    write_values(file, "schlick_mean", tables.schlick_mean, TY_BSDF_ROUGHNESSES);
    write_values(file, "dielectric", tables.dielectric, 2 * TY_BSDF_IORS * TY_BSDF_ROUGHNESSES * TY_BSDF_COSINES);
    write_values(file, "dielectric_mean", tables.dielectric_mean, 2 * TY_BSDF_IORS * TY_BSDF_MEANS);
    fprintf(file, "};\n");
    return fclose(file) == 0 ? EXIT_SUCCESS : EXIT_FAILURE;
}
