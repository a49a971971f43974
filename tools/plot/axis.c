/* Ticks of axes, and formats of numbers. */
#include "plot/axis.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* Rounds value > 0 down to 1, 2 or 5 times a power of ten; with up, rounds up. */
static double round_number(double value, bool up) {
    static const double steps[] = {1, 2, 5, 10};
    const double slack = 1e-9;
    const double power = pow(10, floor(log10(value) + slack));
    const double mantissa = value / power;
    for (int i = up ? 0 : 3; up ? i < 4 : i >= 0; i += up ? 1 : -1)
        if (up ? steps[i] >= mantissa * (1 - slack) : steps[i] <= mantissa * (1 + slack)) return steps[i] * power;
    return power;
}

static double linear_step(double range, int target_count) {
    return round_number(range / (target_count > 1 ? target_count - 1 : 1), true);
}

plot_axis plot_linear_axis(double min, double max) {
    if (!(max > min)) return (plot_axis){min - 0.5, min + 0.5, false};
    const double from = min > 0 && min < 0.4 * max ? 0 : min;
    const double step = linear_step(max - from, 6);
    return (plot_axis){step * floor(from / step + 1e-9), step * ceil(max / step - 1e-9), false};
}

plot_axis plot_log_axis(double min, double max) {
    return (plot_axis){round_number(min / 1.1, false), round_number(max * 1.1, true), true};
}

double plot_axis_position(const plot_axis* axis, double value) {
    if (axis->logarithmic) return log(value / axis->lower) / log(axis->upper / axis->lower);
    return (value - axis->lower) / (axis->upper - axis->lower);
}

static int log_ticks(const plot_axis* axis, int target_count, double ticks[PLOT_TICKS_MAX]) {
    const int min = (int)floor(log10(axis->lower) + 1e-9), max = (int)ceil(log10(axis->upper) - 1e-9);
    /* A long axis has only every n-th power of ten, a short one also 2 and 5 times each. */
    const int stride = (max - min) / (target_count > 0 ? target_count : 1) + 1;
    const bool between = 2 * (max - min) <= target_count;
    int count = 0;
    for (int exponent = min; exponent <= max; exponent += stride)
        for (int i = 0; i < (between ? 3 : 1); ++i) {
            const double value = (double[]){1, 2, 5}[i] * pow(10, exponent);
            if (value >= axis->lower * (1 - 1e-9) && value <= axis->upper * (1 + 1e-9) && count < PLOT_TICKS_MAX)
                ticks[count++] = value;
        }
    return count;
}

int plot_axis_ticks(const plot_axis* axis, int target_count, double ticks[PLOT_TICKS_MAX]) {
    if (axis->logarithmic) return log_ticks(axis, target_count, ticks);
    const double step = linear_step(axis->upper - axis->lower, target_count);
    const double first = ceil(axis->lower / step - 1e-9);
    int count = 0;
    for (double i = first; i * step <= axis->upper + 1e-9 * step && count < PLOT_TICKS_MAX; ++i)
        ticks[count++] = i * step + 0.0; /* not -0 */
    return count;
}

/* "-5" in superscript digits. */
static void append_superscript(char* out, size_t size, int number) {
    static const char* const digits[] = {"⁰", "¹", "²", "³", "⁴", "⁵", "⁶", "⁷", "⁸", "⁹"};
    char plain[16];
    snprintf(plain, sizeof plain, "%d", number);
    for (const char* c = plain; *c != '\0'; ++c) {
        const size_t used = strlen(out);
        snprintf(out + used, size - used, "%s", *c == '-' ? "⁻" : digits[*c - '0']);
    }
}

void plot_format_number(double value, int digits, char out[PLOT_NUMBER_SIZE]) {
    const double size = fabs(value);
    if (!isfinite(value) || size == 0 || (size >= 1e-3 && size < 1e6)) {
        /* Rounds to significant digits, but keeps all digits before the decimal point: 1234 stays 1234. */
        const int before = size >= 1 && isfinite(value) ? (int)floor(log10(size)) + 1 : 1;
        snprintf(out, PLOT_NUMBER_SIZE, "%.*g", digits > before ? digits : before, value);
        return;
    }
    int exponent = (int)floor(log10(size));
    char mantissa[16];
    snprintf(mantissa, sizeof mantissa, "%.*g", digits, value / pow(10, exponent));
    if (strcmp(mantissa, "10") == 0 || strcmp(mantissa, "-10") == 0) {
        mantissa[strlen(mantissa) - 1] = '\0';
        ++exponent;
    }
    snprintf(out, PLOT_NUMBER_SIZE, "%s%s10", strcmp(mantissa, "1") == 0 ? "" : mantissa,
             strcmp(mantissa, "1") == 0 ? "" : "×");
    append_superscript(out, PLOT_NUMBER_SIZE, exponent);
}
