/* Colors of lines, and color maps in Oklab, which is perceptually uniform. */
#include "plot/color.h"

#include "base/constants.h"

#include <math.h>

const plot_color plot_ink = {0.13, 0.13, 0.15};
const plot_color plot_faint = {0.55, 0.55, 0.58};

plot_color plot_series_color(int index) {
    static const plot_color colors[] = {{0.00, 0.36, 0.66}, {0.85, 0.37, 0.01}, {0.11, 0.55, 0.33}, {0.62, 0.22, 0.58},
                                        {0.35, 0.35, 0.38}, {0.75, 0.57, 0.00}, {0.10, 0.65, 0.75}, {0.70, 0.15, 0.18}};
    return colors[index % (int)(sizeof colors / sizeof *colors)];
}

/* Oklab (Ottosson 2020) lightness, chroma and hue (radians) to linear Rec.709, clamped to the gamut. */
static void from_oklab(double lightness, double chroma, double hue, float rgb[3]) {
    const double a = chroma * cos(hue), b = chroma * sin(hue);
    const double l = pow(lightness + 0.3963377774 * a + 0.2158037573 * b, 3);
    const double m = pow(lightness - 0.1055613458 * a - 0.0638541728 * b, 3);
    const double s = pow(lightness - 0.0894841775 * a - 1.2914855480 * b, 3);
    const double linear[3] = {4.0767416621 * l - 3.3077115913 * m + 0.2309699292 * s,
                              -1.2684380046 * l + 2.6097574011 * m - 0.3413193965 * s,
                              -0.0041960863 * l - 0.7034186147 * m + 1.7076147010 * s};
    for (int c = 0; c < 3; ++c) rgb[c] = (float)fmin(fmax(linear[c], 0), 1);
}

/* From nearly black over violet and orange to a light yellow. */
static void sequential(double t, float rgb[3]) {
    const double hue = -1.35 + 3.25 * t;
    from_oklab(0.16 + 0.8 * t, 0.03 + 0.16 * sin(TY_PI_F64 * pow(t, 0.8)), hue, rgb);
}

static void diverging(double t, float rgb[3]) {
    const double side = 2 * t - 1, amount = fabs(side);
    from_oklab(0.98 - 0.52 * pow(amount, 1.1), 0.17 * pow(amount, 0.8), side < 0 ? 4.5 : 0.45, rgb);
}

void plot_map_color(plot_map map, double t, float rgb[3]) {
    if (isnan(t)) {
        rgb[0] = rgb[2] = 0;
        rgb[1] = 1;
        return;
    }
    const double clamped = fmin(fmax(t, 0), 1);
    if (map == PLOT_DIVERGING)
        diverging(clamped, rgb);
    else
        sequential(clamped, rgb);
}
