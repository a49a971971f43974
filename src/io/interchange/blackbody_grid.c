#include "io/interchange/blackbody_grid.h"

#include "io/interchange/spectrum.h"

#include <math.h>
#include <tyndall/scene.h>

/* Luminances in steps of the temperature's logarithm. */
enum { STEPS = 1024 };

typedef struct table {
    double lowest, step; /* logarithms */
    double absolute[STEPS + 1], normalized[STEPS + 1];
} table;

static double luminance(double kelvin) {
    float rgb[3];
    ty_blackbody(kelvin, rgb);
    return 0.2126 * (double)rgb[0] + 0.7152 * (double)rgb[1] + 0.0722 * (double)rgb[2];
}

static void fill(table* t, double hottest) {
    t->lowest = log(200);
    t->step = (log(hottest) - t->lowest) / STEPS;
    for (int i = 0; i <= STEPS; ++i) {
        const double kelvin = exp(t->lowest + t->step * i);
        t->absolute[i] = luminance(kelvin);
        t->normalized[i] = ty_normalized_blackbody_luminance(kelvin);
    }
}

/* Linear between the steps; 0 below the lowest. */
static double normalized_at(const table* t, double kelvin) {
    const double x = (log(kelvin) - t->lowest) / t->step;
    const int i = x >= STEPS - 1 ? STEPS - 1 : (int)x;
    return x < 0 ? 0 : t->normalized[i] + (x - i) * (t->normalized[i + 1] - t->normalized[i]);
}

static double kelvin_of(const table* t, double absolute) {
    int low = 0, high = STEPS;
    while (high - low > 1) {
        const int center = (low + high) / 2;
        if (t->absolute[center] <= absolute)
            low = center;
        else
            high = center;
    }
    const double width = t->absolute[high] - t->absolute[low];
    const double fraction = width > 0 ? fmin(fmax((absolute - t->absolute[low]) / width, 0), 1) : 0;
    return exp(t->lowest + t->step * (low + fraction));
}

bool ty_normalize_temperatures(float* kelvin, size_t count, double scale, double* factor) {
    double hottest = 0;
    for (size_t i = 0; i < count; ++i) hottest = fmax(hottest, (double)kelvin[i]);
    hottest = fmin(hottest, 1e5);
    if (!(hottest > 210) || !(scale > 0)) return false;
    table t;
    fill(&t, hottest);
    const double ratio = t.normalized[STEPS] / t.absolute[STEPS];
    for (size_t i = 0; i < count; ++i) {
        const double old = fmin((double)kelvin[i], hottest);
        kelvin[i] = old > 200 ? (float)kelvin_of(&t, normalized_at(&t, old) / ratio) : 0;
    }
    *factor = scale * ratio;
    return true;
}
