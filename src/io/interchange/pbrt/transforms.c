/* Directives that change the current transform. */
#include "base/constants.h"
#include "base/context.h"
#include "io/interchange/pbrt/pbrt.h"

#include <math.h>

ty_affine ty_pbrt_world(const ty_pbrt* reader) {
    return ty_affine_multiply(&reader->mirror, &ty_pbrt_now(reader)->ctm);
}

static void normalize(double v[3]) {
    const double length = sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
    for (int a = 0; a < 3 && length > 0; ++a) v[a] /= length;
}

static void cross(const double a[3], const double b[3], double out[3]) {
    for (int i = 0; i < 3; ++i) out[i] = a[(i + 1) % 3] * b[(i + 2) % 3] - a[(i + 2) % 3] * b[(i + 1) % 3];
}

/* Counter-clockwise by an angle about an axis (Rodrigues). */
static ty_affine rotate(double degrees, const double axis[3]) {
    double a[3] = {axis[0], axis[1], axis[2]};
    normalize(a);
    const double s = sin(degrees * TY_PI_F64 / 180), c = cos(degrees * TY_PI_F64 / 180);
    ty_affine map = ty_affine_identity();
    for (int r = 0; r < 3; ++r)
        for (int k = 0; k < 3; ++k) map.m[4 * r + k] = a[r] * a[k] * (1 - c) + (r == k ? c : 0);
    map.m[1] -= a[2] * s;
    map.m[2] += a[1] * s;
    map.m[4] += a[2] * s;
    map.m[6] -= a[0] * s;
    map.m[8] -= a[1] * s;
    map.m[9] += a[0] * s;
    return map;
}

/* The map from the world to a left-handed camera space: z along the view, y up. False if the axes are degenerate. */
static bool look_at(const double n[9], ty_affine* out) {
    double forward[3], up[3] = {n[6], n[7], n[8]}, right[3], new_up[3];
    for (int a = 0; a < 3; ++a) forward[a] = n[3 + a] - n[a];
    normalize(forward);
    normalize(up);
    cross(up, forward, right);
    normalize(right);
    cross(forward, right, new_up);
    ty_affine camera = ty_affine_identity();
    for (int a = 0; a < 3; ++a) {
        camera.m[4 * a] = right[a];
        camera.m[4 * a + 1] = new_up[a];
        camera.m[4 * a + 2] = forward[a];
        camera.m[4 * a + 3] = n[a];
    }
    return ty_affine_invert(&camera, out);
}

/* A matrix of 16 numbers, column by column. */
static ty_result from_matrix(ty_pbrt* reader, int32_t file, int32_t line, const double n[16], ty_affine* out) {
    if (n[3] != 0 || n[7] != 0 || n[11] != 0 || n[15] == 0)
        return ty_pbrt_fail(reader, file, line, "the transform is a projection, which is not known");
    for (int r = 0; r < 3; ++r)
        for (int c = 0; c < 4; ++c) out->m[4 * r + c] = n[4 * c + r] / n[15];
    return TY_OK;
}

static void apply(ty_pbrt* reader, const ty_affine* map) {
    if (!reader->later_time) ty_pbrt_now(reader)->ctm = ty_affine_multiply(&ty_pbrt_now(reader)->ctm, map);
}

ty_result ty_pbrt_numbers(ty_pbrt* reader, ty_pbrt_text* text, int count, double* out) {
    ty_pbrt_token token = ty_pbrt_next(text);
    const bool bracket = token.kind == TY_PBRT_OPEN;
    if (bracket) token = ty_pbrt_next(text);
    for (int i = 0; i < count; ++i, token = i < count ? ty_pbrt_next(text) : token)
        if (!ty_pbrt_number(&token, &out[i]) || fabs(out[i]) > 1e15)
            return ty_pbrt_fail(reader, text->file, token.line, "%d numbers should stand here", count);
    if (bracket && ty_pbrt_next(text).kind != TY_PBRT_CLOSE)
        return ty_pbrt_fail(reader, text->file, token.line, "\"]\" should stand behind %d numbers", count);
    return TY_OK;
}

ty_result ty_pbrt_transform(ty_pbrt* reader, ty_pbrt_text* text, const ty_pbrt_token* word, bool* known) {
    double n[16];
    ty_affine map = ty_affine_identity();
    ty_result result = TY_OK;
    *known = true;
    if (ty_pbrt_is(word, "Identity")) {
        if (!reader->later_time) ty_pbrt_now(reader)->ctm = map;
        return TY_OK;
    }
    if (ty_pbrt_is(word, "Translate")) {
        result = ty_pbrt_numbers(reader, text, 3, n);
        for (int a = 0; a < 3 && result == TY_OK; ++a) map.m[4 * a + 3] = n[a];
    } else if (ty_pbrt_is(word, "Scale")) {
        result = ty_pbrt_numbers(reader, text, 3, n);
        for (int a = 0; a < 3 && result == TY_OK; ++a) map.m[5 * a] = n[a];
    } else if (ty_pbrt_is(word, "Rotate")) {
        result = ty_pbrt_numbers(reader, text, 4, n);
        if (result == TY_OK) map = rotate(n[0], n + 1);
    } else if (ty_pbrt_is(word, "LookAt")) {
        result = ty_pbrt_numbers(reader, text, 9, n);
        if (result == TY_OK && !look_at(n, &map))
            return ty_pbrt_fail(reader, text->file, word->line, "LookAt has no direction, or it looks along up");
    } else if (ty_pbrt_is(word, "Transform") || ty_pbrt_is(word, "ConcatTransform")) {
        result = ty_pbrt_numbers(reader, text, 16, n);
        if (result == TY_OK) result = from_matrix(reader, text->file, word->line, n, &map);
        if (result == TY_OK && ty_pbrt_is(word, "Transform") && !reader->later_time) {
            ty_pbrt_now(reader)->ctm = map;
            return TY_OK;
        }
    } else {
        *known = false;
        return TY_OK;
    }
    if (result == TY_OK) apply(reader, &map);
    return result;
}
