/* Spherical harmonics of bands 0 to 2 in the conventions of engines (docs/engines.md). */
#include "cli/export/export.h"

#include <math.h>
#include <string.h>

#define PI 3.14159265358979323846
/* Factors of the real orthonormal harmonics: sqrt(1 / (4 pi)), sqrt(3 / (4 pi)), sqrt(15 / (4 pi)), sqrt(5 / (16 pi)).
 */
#define K0 0.28209479177387814
#define K1 0.48860251190291992
#define K2 1.09254843059207907
#define K20 0.31539156525252001

const export_engine export_engines[EXPORT_ENGINES] = {
    {.name = "three",
     .extension = "ktx2",
     .format = TY_TEXELS_RGB9E5,
     .axes = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}},
     .units_per_meter = 1,
     .axes_text = "right-handed, y up",
     .probes_text = "radiance: SphericalHarmonics3.fromArray takes them"},
    {.name = "godot",
     .extension = "dds",
     .format = TY_TEXELS_BC6H,
     .per_pi = true,
     .axes = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}},
     .units_per_meter = 1,
     .axes_text = "right-handed, y up",
     .probes_text = "radiance over pi, as LightmapGI's light probes hold it"},
    {.name = "unity",
     .extension = "dds",
     .format = TY_TEXELS_BC6H,
     .per_pi = true,
     .flipped = true,
     .axes = {{-1, 0, 0}, {0, 1, 0}, {0, 0, 1}},
     .units_per_meter = 1,
     .axes_text = "left-handed, y up: x is that of glTF reversed, as Unity's and glTFast's importers do",
     .probes_text = "SphericalHarmonicsL2: irradiance over pi as a polynomial of the normal"},
    {.name = "unreal",
     .extension = "exr",
     .per_pi = true,
     .axes = {{1, 0, 0}, {0, 0, 1}, {0, 1, 0}},
     .units_per_meter = 100,
     .axes_text = "left-handed, z up, cm: glTF's (x, z, y), as Unreal's importer does",
     .probes_text = "radiance: FSHVectorRGB3, whose basis has the Condon-Shortley phase"},
};

void export_axes(const export_engine* engine, bool z_up, float axes[3][3]) {
    memcpy(axes, engine->axes, sizeof engine->axes);
    if (!z_up) return;
    /* (x, y, z) with z up is (x, z, -y) with y up. */
    for (int a = 0; a < 3; ++a) {
        axes[a][1] = -engine->axes[a][2];
        axes[a][2] = engine->axes[a][1];
    }
}

/* Turns the coefficients: band 1 as a vector, band 2 as the symmetric matrix Q without trace of w . Q w. */
static void turn(const float axes[3][3], const double in[EXPORT_TERMS], double out[EXPORT_TERMS]) {
    const double v[3] = {in[3], in[1], in[2]};
    const double q[3][3] = {{K2 / 2 * in[8] - K20 * in[6], K2 / 2 * in[4], K2 / 2 * in[7]},
                            {K2 / 2 * in[4], -K2 / 2 * in[8] - K20 * in[6], K2 / 2 * in[5]},
                            {K2 / 2 * in[7], K2 / 2 * in[5], 2 * K20 * in[6]}};
    double w[3] = {0}, p[3][3] = {{0}};
    for (int a = 0; a < 3; ++a)
        for (int i = 0; i < 3; ++i) {
            w[a] += (double)axes[a][i] * v[i];
            for (int b = 0; b < 3; ++b)
                for (int j = 0; j < 3; ++j) p[a][b] += (double)axes[a][i] * q[i][j] * (double)axes[b][j];
        }
    out[0] = in[0];
    out[1] = w[1];
    out[2] = w[2];
    out[3] = w[0];
    out[4] = 2 / K2 * p[0][1];
    out[5] = 2 / K2 * p[1][2];
    out[6] = p[2][2] / (2 * K20);
    out[7] = 2 / K2 * p[0][2];
    out[8] = (p[0][0] - p[1][1]) / K2;
}

/* The factor of each term. */
static double factor_of(const export_engine* engine, int term) {
    /* A_l / pi, of the cosine lobe (Ramamoorthi and Hanrahan 2001), times the harmonic's own factor. */
    static const double unity[EXPORT_TERMS] = {K0,        2.0 / 3 * K1, 2.0 / 3 * K1, 2.0 / 3 * K1, 0.25 * K2,
                                               0.25 * K2, 0.25 * K20,   0.25 * K2,    0.125 * K2};
    if (strcmp(engine->name, "unity") == 0) return unity[term];
    if (strcmp(engine->name, "unreal") == 0) return term == 1 || term == 3 || term == 5 || term == 7 ? -1 : 1;
    return strcmp(engine->name, "godot") == 0 ? 1 / PI : 1;
}

void export_harmonics(const export_engine* engine, const float axes[3][3], const double in[EXPORT_TERMS],
                      double out[EXPORT_TERMS]) {
    turn(axes, in, out);
    for (int t = 0; t < EXPORT_TERMS; ++t) out[t] *= factor_of(engine, t);
}
