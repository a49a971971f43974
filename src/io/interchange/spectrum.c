#include "io/interchange/spectrum.h"

#include "scene/media/observer.h"

#include <math.h>
#include <string.h>

/* ---- integration ---- */

/* Relative spectral power of the CIE standard illuminant D65 from 380 nm, every 10 nm. */
static const double d65[] = {49.9755, 54.6482, 82.7549, 91.4860, 93.4318, 86.6823, 104.865, 117.008, 117.812,
                             114.861, 115.923, 108.811, 109.354, 107.802, 104.790, 107.689, 104.405, 104.046,
                             100.000, 96.3342, 95.7880, 88.6856, 90.0062, 89.5991, 87.6987, 83.2886, 83.6992,
                             80.0268, 80.2146, 82.2778, 78.2842, 69.7213, 71.6091, 74.3490, 61.6040, 69.8856,
                             75.0870, 63.5927, 46.4182, 66.8054, 63.3828};

double ty_spectrum_at(ty_spectrum spectrum, double nm) {
    const double* pairs = spectrum.pairs;
    size_t low = 0, high = spectrum.count;
    if (high == 0) return 0;
    if (nm <= pairs[0]) return pairs[1];
    while (high - low > 1) {
        const size_t center = (low + high) / 2;
        if (pairs[2 * center] <= nm)
            low = center;
        else
            high = center;
    }
    if (high == spectrum.count || !(pairs[2 * high] > pairs[2 * low])) return pairs[2 * low + 1];
    const double t = (nm - pairs[2 * low]) / (pairs[2 * high] - pairs[2 * low]);
    return pairs[2 * low + 1] + t * (pairs[2 * high + 1] - pairs[2 * low + 1]);
}

/* Linear Rec.709 with its white D65 from CIE XYZ. */
static void from_xyz(const double xyz[3], double rgb[3]) {
    static const double m[3][3] = {{3.2409699419, -1.5373831776, -0.4986107603},
                                   {-0.9692436363, 1.8759675015, 0.0415550574},
                                   {0.0556300797, -0.2039769589, 1.0569715142}};
    for (int r = 0; r < 3; ++r) rgb[r] = m[r][0] * xyz[0] + m[r][1] * xyz[1] + m[r][2] * xyz[2];
}

static double d65_at(int sample) {
    const int low = sample / 2;
    return sample % 2 == 0 ? d65[low] : 0.5 * (d65[low] + d65[low + 1]);
}

/* XYZ of a spectrum, times D65 if weighted, in sums of 5 nm. */
static void integrate(ty_spectrum spectrum, bool weighted, double xyz[3]) {
    xyz[0] = xyz[1] = xyz[2] = 0;
    for (int i = 0; i < TY_OBSERVER_COUNT; ++i) {
        const double value = ty_spectrum_at(spectrum, TY_OBSERVER_FIRST + TY_OBSERVER_STEP * i);
        for (int c = 0; c < 3; ++c) xyz[c] += TY_OBSERVER_STEP * ty_observer[i][c] * value * (weighted ? d65_at(i) : 1);
    }
}

void ty_spectrum_light(ty_spectrum spectrum, double rgb[3]) {
    double xyz[3];
    integrate(spectrum, false, xyz);
    const double luminance = xyz[1];
    for (int c = 0; c < 3; ++c) xyz[c] = luminance > 0 ? xyz[c] / luminance : 0;
    from_xyz(xyz, rgb);
}

double ty_spectrum_mean(ty_spectrum spectrum) {
    static const double one[2] = {550, 1};
    double xyz[3], whole[3];
    integrate(spectrum, false, xyz);
    integrate((ty_spectrum){one, 1}, false, whole);
    return xyz[1] / whole[1];
}

void ty_spectrum_reflectance(ty_spectrum spectrum, double rgb[3]) {
    static const double one[2] = {550, 1};
    double xyz[3], white[3], white_rgb[3];
    integrate(spectrum, true, xyz);
    integrate((ty_spectrum){one, 1}, true, white);
    from_xyz(xyz, rgb);
    from_xyz(white, white_rgb);
    for (int c = 0; c < 3; ++c) rgb[c] /= white_rgb[c];
}

/* ---- black bodies ---- */

/* Spectral radiance of a black body over its largest: Planck's law, and Wien's displacement law. */
static double normalized_planck(double nm, double kelvin) {
    static const double c2 = 1.438776877e-2, wien = 2.897771955e-3; /* m K */
    const double peak = wien / kelvin, wavelength = nm * 1e-9;
    const double at = pow(wavelength, -5) / expm1(c2 / (wavelength * kelvin));
    return at / (pow(peak, -5) / expm1(c2 / wien));
}

static void blackbody_xyz(double kelvin, double xyz[3]) {
    xyz[0] = xyz[1] = xyz[2] = 0;
    for (int i = 0; i < TY_OBSERVER_COUNT; ++i) {
        const double value = normalized_planck(TY_OBSERVER_FIRST + TY_OBSERVER_STEP * i, kelvin);
        for (int c = 0; c < 3; ++c) xyz[c] += TY_OBSERVER_STEP * ty_observer[i][c] * value;
    }
}

void ty_blackbody_colour(double kelvin, double rgb[3]) {
    double xyz[3];
    blackbody_xyz(fmin(fmax(kelvin, 500), 1e6), xyz);
    const double luminance = xyz[1];
    for (int c = 0; c < 3; ++c) xyz[c] /= luminance;
    from_xyz(xyz, rgb);
}

double ty_normalized_blackbody_luminance(double kelvin) {
    double xyz[3];
    if (!(kelvin > 100)) return 0;
    blackbody_xyz(fmin(kelvin, 1e6), xyz);
    return xyz[1];
}

/* ---- colour spaces ---- */

bool ty_colour_from_space(const char* space, double rgb[3]) {
    static const struct {
        const char* name;
        double m[9];
    } spaces[] = {
        {"srgb", {1, 0, 0, 0, 1, 0, 0, 0, 1}},
        /* ITU-R BT.2087 */
        {"rec2020", {1.660491, -0.587641, -0.072850, -0.124550, 1.132900, -0.008349, -0.018151, -0.100579, 1.118730}},
        /* SMPTE EG 432-1, white D65 */
        {"dci-p3", {1.224940, -0.224940, 0, -0.042057, 1.042057, 0, -0.019638, -0.078636, 1.098274}},
        /* SMPTE ST 2065-1, white adapted from D60 to D65 by Bradford's method */
        {"aces2065-1",
         {2.521686, -1.134131, -0.387555, -0.276480, 1.372719, -0.096239, -0.015378, -0.152975, 1.168354}},
    };
    for (size_t i = 0; i < sizeof spaces / sizeof spaces[0]; ++i) {
        if (strcmp(space, spaces[i].name) != 0) continue;
        const double* m = spaces[i].m;
        const double in[3] = {rgb[0], rgb[1], rgb[2]};
        for (int r = 0; r < 3; ++r) rgb[r] = m[3 * r] * in[0] + m[3 * r + 1] * in[1] + m[3 * r + 2] * in[2];
        return true;
    }
    return false;
}

/* ---- matter ---- */

bool ty_named_ior(const char* name, double* ior) {
    /* At 587.6 nm, from the makers' data sheets, and of common liquids. */
    static const struct {
        const char* name;
        double ior;
    } glasses[] = {{"glass-BK7", 1.5168},
                   {"glass-BAF10", 1.67003},
                   {"glass-FK51A", 1.48656},
                   {"glass-LASF9", 1.85025},
                   {"glass-F5", 1.6727},
                   {"glass-SF5", 1.6727},
                   {"glass-F10", 1.72825},
                   {"glass-SF10", 1.72825},
                   {"glass-F11", 1.78472},
                   {"glass-SF11", 1.78472},
                   {"vacuum", 1},
                   {"helium", 1.000036},
                   {"hydrogen", 1.000132},
                   {"air", 1.000277},
                   {"carbon dioxide", 1.00045},
                   {"water", 1.333},
                   {"acetone", 1.36},
                   {"ethanol", 1.361},
                   {"carbon tetrachloride", 1.461},
                   {"glycerol", 1.4729},
                   {"benzene", 1.501},
                   {"silicone oil", 1.52045},
                   {"bromine", 1.661},
                   {"water ice", 1.31},
                   {"fused quartz", 1.458},
                   {"pyrex", 1.47},
                   {"acrylic glass", 1.49},
                   {"polypropylene", 1.49},
                   {"bk7", 1.5046},
                   {"sodium chloride", 1.544},
                   {"amber", 1.55},
                   {"pet", 1.575},
                   {"diamond", 2.419}};
    for (size_t i = 0; i < sizeof glasses / sizeof glasses[0]; ++i) {
        if (strcmp(name, glasses[i].name) != 0) continue;
        *ior = glasses[i].ior;
        return true;
    }
    return false;
}

bool ty_named_metal(const char* name, double eta[3], double k[3]) {
    /* Measured n and k at 650, 550 and 450 nm: Johnson and Christy 1972 (Au, Ag, Cu), Rakic 1995 (Al), and for brass,
     * CuZn, Querry 1985. */
    static const struct {
        const char* name;
        double eta[3], k[3];
    } metals[] = {{"Au", {0.143, 0.375, 1.442}, {3.983, 2.385, 1.603}},
                  {"Ag", {0.155, 0.117, 0.138}, {4.828, 3.122, 2.147}},
                  {"Cu", {0.200, 0.924, 1.102}, {3.912, 2.452, 2.142}},
                  {"Al", {1.345, 0.965, 0.617}, {7.474, 6.400, 5.303}},
                  {"CuZn", {0.444, 0.527, 1.094}, {3.695, 2.765, 1.829}}};
    for (size_t i = 0; i < sizeof metals / sizeof metals[0]; ++i) {
        if (strcmp(name, metals[i].name) != 0) continue;
        memcpy(eta, metals[i].eta, sizeof metals[i].eta);
        memcpy(k, metals[i].k, sizeof metals[i].k);
        return true;
    }
    return false;
}

double ty_conductor_reflectance(double eta, double k) {
    return ((eta - 1) * (eta - 1) + k * k) / ((eta + 1) * (eta + 1) + k * k);
}

bool ty_named_illuminant(const char* name, double rgb[3]) {
    /* Chromaticities x and y of CIE 15:2004, and of ACES' white. */
    static const struct {
        const char* name;
        double x, y;
    } lights[] = {
        {"stdillum-A", 0.44757, 0.40745},    {"stdillum-D50", 0.34567, 0.35850}, {"stdillum-D65", 0.31272, 0.32903},
        {"illum-acesD60", 0.32168, 0.33767}, {"stdillum-F1", 0.31310, 0.33727},  {"stdillum-F2", 0.37208, 0.37529},
        {"stdillum-F3", 0.40910, 0.39430},   {"stdillum-F4", 0.44018, 0.40329},  {"stdillum-F5", 0.31379, 0.34531},
        {"stdillum-F6", 0.37790, 0.38835},   {"stdillum-F7", 0.31292, 0.32933},  {"stdillum-F8", 0.34588, 0.35875},
        {"stdillum-F9", 0.37417, 0.37281},   {"stdillum-F10", 0.34609, 0.35986}, {"stdillum-F11", 0.38052, 0.37713},
        {"stdillum-F12", 0.43695, 0.40441}};
    for (size_t i = 0; i < sizeof lights / sizeof lights[0]; ++i) {
        if (strcmp(name, lights[i].name) != 0) continue;
        const double x = lights[i].x, y = lights[i].y, xyz[3] = {x / y, 1, (1 - x - y) / y};
        from_xyz(xyz, rgb);
        return true;
    }
    return false;
}
