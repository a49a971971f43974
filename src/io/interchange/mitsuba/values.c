/* Numbers, transforms and colours of elements. */
#include "io/interchange/mitsuba/mitsuba.h"

#include "base/constants.h"
#include "base/context.h"
#include "base/number.h"
#include "io/interchange/solids.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* ---- numbers ---- */

/* Reads up to `limit` numbers between commas and blanks; the number of them, or -1 if something else is there. */
static int parse_numbers(const char* text, int limit, double* out) {
    int count = 0;
    for (;;) {
        const char* end;
        text += strspn(text, " \t\r\n,");
        if (*text == '\0') return count;
        const double value = ty_parse_number(text, &end);
        if (end == text || !isfinite(value) || count == limit) return -1;
        out[count++] = value;
        text = end;
    }
}

static ty_result not_number(const ty_mitsuba* scene, int32_t node, const char* text) {
    return ty_mitsuba_fail(scene, node, "\"%.100s\" is not what should stand here in numbers", text);
}

ty_result ty_mitsuba_float(const ty_mitsuba* scene, int32_t node, const char* name, double* out) {
    const int32_t child = ty_mitsuba_child(scene, node, name);
    if (child < 0) return TY_OK;
    const char* value = ty_mitsuba_attribute(scene, child, "value");
    if (value == NULL) return TY_OK; /* an object in place of a number */
    double number;
    if (parse_numbers(value, 1, &number) != 1) return not_number(scene, child, value);
    *out = number;
    return TY_OK;
}

bool ty_mitsuba_bool(const ty_mitsuba* scene, int32_t node, const char* name, bool otherwise) {
    const char* value = ty_mitsuba_string(scene, node, name);
    return value == NULL ? otherwise : strcmp(value, "true") == 0;
}

const char* ty_mitsuba_string(const ty_mitsuba* scene, int32_t node, const char* name) {
    const int32_t child = ty_mitsuba_child(scene, node, name);
    return child < 0 ? NULL : ty_mitsuba_attribute(scene, child, "value");
}

/* Three numbers of the element itself: by x, y and z, or by value, of which one may stand for all. */
static ty_result read_triple(const ty_mitsuba* scene, int32_t node, double otherwise, double out[3]) {
    static const char* const keys[3] = {"x", "y", "z"};
    const char* value = ty_mitsuba_attribute(scene, node, "value");
    if (value != NULL) {
        const int count = parse_numbers(value, 3, out);
        if (count != 1 && count != 3) return not_number(scene, node, value);
        if (count == 1) out[1] = out[2] = out[0];
        return TY_OK;
    }
    for (int a = 0; a < 3; ++a) {
        const char* text = ty_mitsuba_attribute(scene, node, keys[a]);
        out[a] = otherwise;
        if (text != NULL && parse_numbers(text, 1, &out[a]) != 1) return not_number(scene, node, text);
    }
    return TY_OK;
}

ty_result ty_mitsuba_vector(const ty_mitsuba* scene, int32_t node, const char* name, double out[3]) {
    const int32_t child = ty_mitsuba_child(scene, node, name);
    return child < 0 ? TY_OK : read_triple(scene, child, 0, out);
}

/* ---- transforms ---- */

static void normalize(double v[3]) {
    const double length = sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
    for (int a = 0; a < 3 && length > 0; ++a) v[a] /= length;
}

static void cross(const double a[3], const double b[3], double out[3]) {
    for (int i = 0; i < 3; ++i) out[i] = a[(i + 1) % 3] * b[(i + 2) % 3] - a[(i + 2) % 3] * b[(i + 1) % 3];
}

/* Counter-clockwise about an axis (Rodrigues). */
static ty_result read_rotation(const ty_mitsuba* scene, int32_t node, ty_affine* out) {
    double axis[3], degrees = 0;
    const char* angle = ty_mitsuba_attribute(scene, node, "angle");
    const ty_result result = read_triple(scene, node, 0, axis);
    if (result != TY_OK) return result;
    if (angle == NULL || parse_numbers(angle, 1, &degrees) != 1) return not_number(scene, node, angle ? angle : "");
    normalize(axis);
    const double s = sin(degrees * TY_PI_F64 / 180), c = cos(degrees * TY_PI_F64 / 180);
    for (int r = 0; r < 3; ++r)
        for (int k = 0; k < 3; ++k) {
            const int other = 3 - r - k;
            const double turn = r == k ? c : (k == (r + 1) % 3 ? -1 : 1) * axis[other] * s;
            out->m[4 * r + k] = axis[r] * axis[k] * (1 - c) + turn;
        }
    return TY_OK;
}

/* The camera looks along +z, with +x to the left. */
static ty_result read_look_at(const ty_mitsuba* scene, int32_t node, ty_affine* out) {
    static const char* const keys[3] = {"origin", "target", "up"};
    double v[3][3] = {{0, 0, 0}, {0, 0, 1}, {0, 1, 0}}, left[3], forward[3], up[3];
    for (int i = 0; i < 3; ++i) {
        const char* text = ty_mitsuba_attribute(scene, node, keys[i]);
        if (text != NULL && parse_numbers(text, 3, v[i]) != 3) return not_number(scene, node, text);
    }
    for (int a = 0; a < 3; ++a) forward[a] = v[1][a] - v[0][a];
    normalize(forward);
    cross(v[2], forward, left);
    normalize(left);
    cross(forward, left, up);
    for (int a = 0; a < 3; ++a) {
        out->m[4 * a] = left[a];
        out->m[4 * a + 1] = up[a];
        out->m[4 * a + 2] = forward[a];
        out->m[4 * a + 3] = v[0][a];
    }
    return TY_OK;
}

static ty_result read_matrix(const ty_mitsuba* scene, int32_t node, ty_affine* out) {
    double n[16];
    const char* value = ty_mitsuba_attribute(scene, node, "value");
    const int count = value == NULL ? -1 : parse_numbers(value, 16, n);
    if (count == 9) {
        for (int r = 0; r < 3; ++r)
            for (int c = 0; c < 3; ++c) out->m[4 * r + c] = n[3 * r + c];
        return TY_OK;
    }
    if (count != 16) return not_number(scene, node, value != NULL ? value : "");
    memcpy(out->m, n, sizeof out->m);
    return TY_OK;
}

ty_result ty_mitsuba_transform(const ty_mitsuba* scene, int32_t node, const char* name, ty_affine* out) {
    const int32_t transform = ty_mitsuba_child(scene, node, name);
    *out = ty_affine_identity();
    if (transform < 0) return TY_OK;
    for (int32_t step = scene->nodes[transform].first_child; step >= 0; step = scene->nodes[step].next) {
        ty_affine map = ty_affine_identity();
        ty_result result = TY_OK;
        double v[3];
        if (ty_mitsuba_is(scene, step, "translate")) {
            result = read_triple(scene, step, 0, v);
            for (int a = 0; a < 3 && result == TY_OK; ++a) map.m[4 * a + 3] = v[a];
        } else if (ty_mitsuba_is(scene, step, "scale")) {
            result = read_triple(scene, step, 1, v);
            for (int a = 0; a < 3 && result == TY_OK; ++a) map.m[5 * a] = v[a];
        } else if (ty_mitsuba_is(scene, step, "rotate")) {
            result = read_rotation(scene, step, &map);
        } else if (ty_mitsuba_is(scene, step, "lookat")) {
            result = read_look_at(scene, step, &map);
        } else if (ty_mitsuba_is(scene, step, "matrix")) {
            result = read_matrix(scene, step, &map);
        } else {
            return ty_mitsuba_fail(scene, step, "\"%.60s\" is no part of a transform", scene->nodes[step].tag);
        }
        if (result != TY_OK) return result;
        *out = ty_affine_multiply(&map, out);
    }
    return TY_OK;
}

/* ---- colours ---- */

/* Decodes sRGB (IEC 61966-2-1). */
static double from_srgb(double x) {
    return x <= 0.04045 ? x / 12.92 : pow((x + 0.055) / 1.055, 2.4);
}

static int hex_digit(char c) {
    if (c >= '0' && c <= '9') return c - '0';
    c = (char)(c | 0x20);
    return c >= 'a' && c <= 'f' ? c - 'a' + 10 : -1;
}

/* "#rrggbb" in sRGB. */
static bool parse_hex(const char* text, double rgb[3]) {
    if (text[0] != '#' || strlen(text) != 7) return false;
    for (int c = 0; c < 3; ++c) {
        const int high = hex_digit(text[1 + 2 * c]), low = hex_digit(text[2 + 2 * c]);
        if (high < 0 || low < 0) return false;
        rgb[c] = from_srgb((16 * high + low) / 255.0);
    }
    return true;
}

/* A constant, or "400:0.1, 500:0.2". */
static ty_result read_spectrum(const ty_mitsuba* scene, int32_t node, const char* text, bool light, double rgb[3]) {
    enum { PAIRS_MAX = 512 };
    double pairs[2 * PAIRS_MAX];
    size_t count = 0;
    if (strchr(text, ':') == NULL) {
        const int numbers = parse_numbers(text, 3, rgb);
        if (numbers == 1) rgb[1] = rgb[2] = rgb[0];
        return numbers == 1 || numbers == 3 ? TY_OK : not_number(scene, node, text);
    }
    for (const char* at = text; *(at += strspn(at, " \t\r\n,")) != '\0';) {
        const char *colon, *end;
        if (count == PAIRS_MAX) return ty_mitsuba_fail(scene, node, "the spectrum has more than %d pairs", PAIRS_MAX);
        pairs[2 * count] = ty_parse_number(at, &colon);
        if (colon == at || *colon != ':') return not_number(scene, node, text);
        pairs[2 * count + 1] = ty_parse_number(colon + 1, &end);
        if (end == colon + 1 || !isfinite(pairs[2 * count]) || !isfinite(pairs[2 * count + 1]) ||
            (count > 0 && !(pairs[2 * count] > pairs[2 * count - 2])))
            return not_number(scene, node, text);
        ++count;
        at = end;
    }
    const ty_spectrum spectrum = {pairs, count};
    if (!light) {
        ty_spectrum_reflectance(spectrum, rgb);
        return TY_OK;
    }
    ty_spectrum_light(spectrum, rgb);
    for (int c = 0; c < 3; ++c) rgb[c] *= ty_spectrum_mean(spectrum);
    return TY_OK;
}

ty_result ty_mitsuba_colour(ty_mitsuba* scene, int32_t node, const char* name, bool light, double rgb[3], bool* found) {
    const int32_t child = ty_mitsuba_child(scene, node, name);
    const char* value = child < 0 ? NULL : ty_mitsuba_attribute(scene, child, "value");
    *found = value != NULL;
    if (child >= 0 && value == NULL && ty_mitsuba_is(scene, child, "spectrum")) {
        const char* file = ty_mitsuba_attribute(scene, child, "filename");
        ty_conversion_leave_out(scene->conversion, "the spectrum \"%.100s\"",
                                file != NULL ? file : ty_mitsuba_type(scene, child));
    }
    if (!*found) return TY_OK;
    ty_result result = TY_OK;
    if ((ty_mitsuba_is(scene, child, "rgb") || ty_mitsuba_is(scene, child, "srgb")) && value[0] == '#') {
        if (!parse_hex(value, rgb)) result = not_number(scene, child, value);
    } else {
        result = read_spectrum(scene, child, value, light, rgb);
        if (result == TY_OK && ty_mitsuba_is(scene, child, "srgb"))
            for (int c = 0; c < 3; ++c) rgb[c] = from_srgb(rgb[c]);
    }
    for (int c = 0; c < 3 && result == TY_OK; ++c) rgb[c] = fmax(rgb[c], 0);
    return result;
}
