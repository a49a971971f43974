/* Media presets by name.
 *
 * Data without three channels are evaluated at 620, 550 and 450 nm for red, green and blue. */
#include <tyndall/scene.h>

#include <math.h>
#include <stddef.h>

/* ---- measured media ---- */

typedef struct measured_preset {
    const char* name;
    double reduced_scattering[3]; /* sigma_s', 1/mm */
    double absorption[3];         /* sigma_a, 1/mm */
} measured_preset;

/* Jensen, Marschner, Levoy, Hanrahan: A Practical Model for Subsurface Light Transport, SIGGRAPH 2001, figure 5 (the
 * first twelve), and Narasimhan et al.: Acquiring Scattering Properties of Participating Media by Dilution, SIGGRAPH
 * 2006. Both in 1/mm, per channel, reduced scattering: sigma_s' = (1 - g) sigma_s. */
static const measured_preset measured[] = {
    {"Apple", {2.29, 2.39, 1.97}, {0.0030, 0.0034, 0.046}},
    {"Chicken1", {0.15, 0.21, 0.38}, {0.015, 0.077, 0.19}},
    {"Chicken2", {0.19, 0.25, 0.32}, {0.018, 0.088, 0.20}},
    {"Cream", {7.38, 5.47, 3.15}, {0.0002, 0.0028, 0.0163}},
    {"Ketchup", {0.18, 0.07, 0.03}, {0.061, 0.97, 1.45}},
    {"Marble", {2.19, 2.62, 3.00}, {0.0021, 0.0041, 0.0071}},
    {"Potato", {0.68, 0.70, 0.55}, {0.0024, 0.0090, 0.12}},
    {"Skimmilk", {0.70, 1.22, 1.90}, {0.0014, 0.0025, 0.0142}},
    {"Skin1", {0.74, 0.88, 1.01}, {0.032, 0.17, 0.48}},
    {"Skin2", {1.09, 1.59, 1.79}, {0.013, 0.070, 0.145}},
    {"Spectralon", {11.6, 20.4, 14.9}, {0.00, 0.00, 0.00}},
    {"Wholemilk", {2.55, 3.21, 3.77}, {0.0011, 0.0024, 0.014}},
    {"Lowfat Milk", {0.89187, 1.5136, 2.532}, {0.002875, 0.00575, 0.0115}},
    {"Reduced Milk", {2.4858, 3.1669, 4.5214}, {0.0025556, 0.0051111, 0.012778}},
    {"Regular Milk", {4.5513, 5.8294, 7.136}, {0.0015333, 0.0046, 0.019933}},
    {"Espresso", {0.72378, 0.84557, 1.0247}, {4.7984, 6.5751, 8.8493}},
    {"Mint Mocha Coffee", {0.31602, 0.38538, 0.48131}, {3.772, 5.8228, 7.82}},
    {"Lowfat Soy Milk", {0.30576, 0.34233, 0.61664}, {0.0014375, 0.0071875, 0.035937}},
    {"Regular Soy Milk", {0.59223, 0.73866, 1.4693}, {0.0019167, 0.0095833, 0.065167}},
    {"Lowfat Chocolate Milk", {0.64925, 0.83916, 1.1057}, {0.0115, 0.0368, 0.1564}},
    {"Regular Chocolate Milk", {1.4585, 2.1289, 2.9527}, {0.010063, 0.043125, 0.14375}},
    {"Coke", {8.9053e-05, 8.372e-05, 0}, {0.10014, 0.16503, 0.2468}},
    {"Pepsi", {6.1697e-05, 4.2564e-05, 0}, {0.091641, 0.14158, 0.20729}},
    {"Sprite", {6.0306e-06, 6.4139e-06, 6.5504e-06}, {0.001886, 0.0018308, 0.0020025}},
    {"Gatorade", {0.0024574, 0.003007, 0.0037325}, {0.024794, 0.019289, 0.008878}},
    {"Chardonnay", {1.7982e-05, 1.3758e-05, 1.2023e-05}, {0.010782, 0.011855, 0.023997}},
    {"White Zinfandel", {1.7501e-05, 1.9069e-05, 1.288e-05}, {0.012072, 0.016184, 0.019843}},
    {"Merlot", {2.1129e-05, 0, 0}, {0.11632, 0.25191, 0.29434}},
    {"Budweiser Beer", {2.4356e-05, 2.4079e-05, 1.0564e-05}, {0.011492, 0.024911, 0.057786}},
    {"Coors Light Beer", {5.0922e-05, 4.301e-05, 0}, {0.006164, 0.013984, 0.034983}},
    {"Clorox", {0.0024035, 0.0031373, 0.003991}, {0.0033542, 0.014892, 0.026297}},
    {"Apple Juice", {0.00013612, 0.00015836, 0.000227}, {0.012957, 0.023741, 0.052184}},
    {"Cranberry Juice", {0.00010402, 0.00011646, 7.8139e-05}, {0.039437, 0.094223, 0.12426}},
    {"Grape Juice", {5.382e-05, 0, 0}, {0.10404, 0.23958, 0.29325}},
    {"Ruby Grapefruit Juice", {0.011002, 0.010927, 0.011036}, {0.085867, 0.18314, 0.25262}},
    {"White Grapefruit Juice", {0.22826, 0.23998, 0.32748}, {0.0138, 0.018831, 0.056781}},
    {"Shampoo", {0.0007176, 0.0008303, 0.0009016}, {0.014107, 0.045693, 0.061717}},
    {"Strawberry Shampoo", {0.00015671, 0.00015947, 1.518e-05}, {0.01449, 0.05796, 0.075823}},
    {"Head & Shoulders Shampoo", {0.023805, 0.028804, 0.034306}, {0.084621, 0.15688, 0.20365}},
    {"Lemon Tea Powder", {0.040224, 0.045264, 0.051081}, {2.4288, 4.5757, 7.2127}},
    {"Orange Powder", {0.00015617, 0.00017482, 0.0001762}, {0.001449, 0.003441, 0.007863}},
    {"Pink Lemonade Powder", {0.00012103, 0.00013073, 0.00012528}, {0.001165, 0.002366, 0.003195}},
    {"Cappuccino Powder", {1.8436, 2.5851, 2.1662}, {35.844, 49.547, 61.084}},
    {"Salt Powder", {0.027333, 0.032451, 0.031979}, {0.28415, 0.3257, 0.34148}},
    {"Sugar Powder", {0.00022272, 0.00025513, 0.000271}, {0.012638, 0.031051, 0.050124}},
    {"Suisse Mocha Powder", {2.7979, 3.5452, 4.3365}, {17.502, 27.004, 35.433}},
    {"Pacific Ocean Surface Water", {0.0001764, 0.00032095, 0.00019617}, {0.031845, 0.031324, 0.030147}},
};

enum { MEASURED_COUNT = sizeof measured / sizeof measured[0] };

/* ---- water ---- */

typedef struct water_preset {
    const char* name;
    double scattering[3]; /* of water and particles, 1/m */
    double absorption[3]; /* 1/m */
} water_preset;

/* Petzold's average particle scatters 1.83 % back (Mobley, Sundman and Boss 2002). */
#define PARTICLE_BACKSCATTER 0.0183

/* Density fluctuations of water scatter by 1 + 0.835 cos^2: their depolarisation is 0.09 (Morel 1974). */
#define MOLECULAR_ALPHA 0.835

enum { PURE_WATER = 0 };

/* Pure water: absorption measured by Pope and Fry (1997), scattering by Morel (1974) in Haltrin's fit (1999): 0.005826
 * (400 nm / wavelength)^4.322. Jerlov's oceanic (I to III) and coastal (1C to 9C) types are from the tables of
 * Solonenko and Mobley: Inherent optical properties of Jerlov water types, 2015; red is interpolated between their
 * columns for 600 and 625 nm. Their values for 5C from 600 nm on repeat other rows: scattering follows from their
 * equation 8, absorption is interpolated between the types, as by Williamson and Hollins (2022). */
static const water_preset waters[] = {
    {"Pure Water", {0.0008765, 0.001471, 0.003502}, {0.2755, 0.0565, 0.00922}},
    {"Jerlov I", {0.001076, 0.0017, 0.00381}, {0.2816, 0.062, 0.018}},
    {"Jerlov IA", {0.002614, 0.00354, 0.00631}, {0.2816, 0.0622, 0.0221}},
    {"Jerlov IB", {0.0472, 0.0536, 0.068}, {0.2824, 0.0623, 0.0235}},
    {"Jerlov II", {0.2922, 0.358, 0.504}, {0.2824, 0.0622, 0.0241}},
    {"Jerlov III", {0.7994, 0.98, 1.38}, {0.2834, 0.0646, 0.0388}},
    {"Jerlov 1C", {0.2972, 0.365, 0.514}, {0.2904, 0.076, 0.105}},
    {"Jerlov 3C", {0.8672, 1.06, 1.5}, {0.2934, 0.082, 0.154}},
    {"Jerlov 5C", {1.086, 1.33, 1.87}, {0.3134, 0.117, 0.297}},
    {"Jerlov 7C", {1.918, 2.35, 3.3}, {0.3538, 0.195, 0.542}},
    {"Jerlov 9C", {2.546, 3.12, 4.39}, {0.4268, 0.348, 0.943}},
};

enum { WATER_COUNT = sizeof waters / sizeof waters[0] };

/* ---- fog and haze ---- */

typedef struct aerosol_preset {
    const char* name;
    double spectrum[3]; /* extinction relative to 550 nm */
    double albedo;
    double diameter; /* of droplets, micrometres; 0: Henyey-Greenstein of g */
    double g;
} aerosol_preset;

/* Fog droplets are large, 10 micrometres: wavelength-independent, absorption of the order of 1e-6 (Hu and Stamnes
 * 1993). Haze: (550 nm / wavelength)^1.3, as for average visibility by Kruse et al. (1962), albedo and g between clean
 * and average continental aerosol (Hess, Koepke, Schult 1998). */
static const aerosol_preset aerosols[] = {
    {"Fog", {1, 1, 1}, 1, 10, 0},
    {"Haze", {0.8558, 1, 1.298}, 0.95, 0, 0.7},
};

enum { AEROSOL_COUNT = sizeof aerosols / sizeof aerosols[0] };

/* ---- names ---- */

/* The next letter or digit of *text, letters in lower case; '\0' at the end. */
static char next_character(const char** text) {
    for (; **text != '\0'; ++*text) {
        const char c = **text;
        if (c >= 'A' && c <= 'Z') {
            ++*text;
            return (char)(c - 'A' + 'a');
        }
        if ((c >= 'a' && c <= 'z') || (c >= '0' && c <= '9')) {
            ++*text;
            return c;
        }
    }
    return '\0';
}

static bool same_name(const char* a, const char* b) {
    for (;;) {
        const char c = next_character(&a);
        if (c != next_character(&b)) return false;
        if (c == '\0') return true;
    }
}

int32_t ty_medium_preset_count(void) {
    return MEASURED_COUNT + WATER_COUNT + AEROSOL_COUNT;
}

ty_preset_kind ty_medium_preset_kind(int32_t index) {
    if (index < MEASURED_COUNT) return TY_PRESET_MEASURED;
    return index < MEASURED_COUNT + WATER_COUNT ? TY_PRESET_WATER : TY_PRESET_VISIBILITY;
}

const char* ty_medium_preset_name(int32_t index) {
    if (index < 0 || index >= ty_medium_preset_count()) return NULL;
    switch (ty_medium_preset_kind(index)) {
    case TY_PRESET_MEASURED: return measured[index].name;
    case TY_PRESET_WATER: return waters[index - MEASURED_COUNT].name;
    case TY_PRESET_VISIBILITY: break;
    }
    return aerosols[index - MEASURED_COUNT - WATER_COUNT].name;
}

int32_t ty_medium_preset_find(const char* name) {
    if (name == NULL) return -1;
    int32_t index = ty_medium_preset_count() - 1;
    while (index >= 0 && !same_name(name, ty_medium_preset_name(index))) --index;
    return index;
}

/* ---- coefficients ---- */

static void set_water(const water_preset* water, ty_medium_def* def) {
    def->phase[0] = (ty_phase_lobe){.kind = TY_PHASE_DRAINE, .alpha = MOLECULAR_ALPHA};
    def->phase[1] = (ty_phase_lobe){.kind = TY_PHASE_FOURNIER_FORAND, .backscatter = PARTICLE_BACKSCATTER};
    def->phase_count = water == &waters[PURE_WATER] ? 1 : 2;
    for (int c = 0; c < 3; ++c) {
        const double particles = water->scattering[c] - waters[PURE_WATER].scattering[c];
        def->sigma_s[c] = (float)water->scattering[c];
        def->sigma_a[c] = (float)water->absorption[c];
        def->g[c] = 0;
        def->phase[0].weight[c] = (float)waters[PURE_WATER].scattering[c];
        def->phase[1].weight[c] = (float)particles;
    }
}

/* One part of the medium in `parts` parts of the mixture, the rest of which is pure water. */
static void set_diluted(const measured_preset* medium, double parts, ty_medium_def* def) {
    const water_preset* water = &waters[PURE_WATER];
    for (int c = 0; c < 3; ++c) {
        def->sigma_s[c] =
            (float)(1000 * medium->reduced_scattering[c] / parts + (1 - 1 / parts) * water->scattering[c]);
        def->sigma_a[c] = (float)(1000 * medium->absorption[c] / parts + (1 - 1 / parts) * water->absorption[c]);
        def->g[c] = 0;
    }
    def->phase_count = 0;
}

/* Koschmieder's law: at the visibility the contrast is 5 %. */
static void set_aerosol(const aerosol_preset* aerosol, double visibility, ty_medium_def* def) {
    const double extinction = -log(0.05) / visibility;
    def->phase_count = aerosol->diameter > 0 ? 1 : 0;
    def->phase[0] = (ty_phase_lobe){.kind = TY_PHASE_MIE, .weight = {1, 1, 1}, .diameter = aerosol->diameter};
    for (int c = 0; c < 3; ++c) {
        def->sigma_s[c] = (float)(extinction * aerosol->spectrum[c] * aerosol->albedo);
        def->sigma_a[c] = (float)(extinction * aerosol->spectrum[c] * (1 - aerosol->albedo));
        def->g[c] = (float)aerosol->g;
    }
}

bool ty_medium_preset(const char* name, ty_medium_def* def) {
    const int32_t index = ty_medium_preset_find(name);
    if (index < 0 || def == NULL) return false;
    switch (ty_medium_preset_kind(index)) {
    case TY_PRESET_MEASURED: set_diluted(&measured[index], 1, def); return true;
    case TY_PRESET_WATER: set_water(&waters[index - MEASURED_COUNT], def); return true;
    case TY_PRESET_VISIBILITY: break;
    }
    return false;
}

bool ty_medium_preset_with(const char* name, double number, ty_medium_def* def) {
    const int32_t index = ty_medium_preset_find(name);
    if (index < 0 || def == NULL) return false;
    const ty_preset_kind kind = ty_medium_preset_kind(index);
    if (kind == TY_PRESET_MEASURED && number >= 1 && number <= TY_DILUTION_MAX) {
        set_diluted(&measured[index], number, def);
        return true;
    }
    if (kind == TY_PRESET_VISIBILITY && number >= TY_VISIBILITY_MIN && number <= TY_VISIBILITY_MAX) {
        set_aerosol(&aerosols[index - MEASURED_COUNT - WATER_COUNT], number, def);
        return true;
    }
    return false;
}
