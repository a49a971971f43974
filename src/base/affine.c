/* Affine maps. */
#include <tyndall/grid.h>

#include <math.h>

ty_affine ty_affine_identity(void) {
    return (ty_affine){{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}};
}

ty_affine ty_affine_multiply(const ty_affine* a, const ty_affine* b) {
    ty_affine product;
    for (int r = 0; r < 3; ++r)
        for (int c = 0; c < 4; ++c) {
            double sum = c == 3 ? a->m[4 * r + 3] : 0;
            for (int k = 0; k < 3; ++k) sum += a->m[4 * r + k] * b->m[4 * k + c];
            product.m[4 * r + c] = sum;
        }
    return product;
}

bool ty_affine_invert(const ty_affine* a, ty_affine* out) {
    const double* m = a->m;
    double cofactor[9], largest = 0;
    for (int r = 0; r < 3; ++r)
        for (int c = 0; c < 3; ++c) {
            const int r1 = (r + 1) % 3, r2 = (r + 2) % 3, c1 = (c + 1) % 3, c2 = (c + 2) % 3;
            cofactor[3 * r + c] = m[4 * r1 + c1] * m[4 * r2 + c2] - m[4 * r1 + c2] * m[4 * r2 + c1];
            largest = fmax(largest, fabs(m[4 * r + c]));
        }
    const double determinant = m[0] * cofactor[0] + m[1] * cofactor[1] + m[2] * cofactor[2];
    if (!(fabs(determinant) > 1e-18 * largest * largest * largest) || !isfinite(determinant)) return false;
    ty_affine inverse;
    for (int r = 0; r < 3; ++r)
        for (int c = 0; c < 3; ++c) inverse.m[4 * r + c] = cofactor[3 * c + r] / determinant;
    for (int r = 0; r < 3; ++r) {
        inverse.m[4 * r + 3] = -(inverse.m[4 * r] * m[3] + inverse.m[4 * r + 1] * m[7] + inverse.m[4 * r + 2] * m[11]);
        if (!isfinite(inverse.m[4 * r + 3])) return false;
    }
    *out = inverse;
    return true;
}

void ty_affine_point(const ty_affine* a, const double point[3], double out[3]) {
    double result[3];
    for (int r = 0; r < 3; ++r)
        result[r] = a->m[4 * r] * point[0] + a->m[4 * r + 1] * point[1] + a->m[4 * r + 2] * point[2] + a->m[4 * r + 3];
    for (int r = 0; r < 3; ++r) out[r] = result[r];
}

ty_affine ty_affine_compose(const double translate[3], const double rotate_deg[3], const double scale[3]) {
    ty_affine result = ty_affine_identity();
    for (int r = 0; r < 3; ++r) result.m[5 * r] = scale[r];
    for (int axis = 0; axis < 3; ++axis) {
        const double angle = rotate_deg[axis] * 0.017453292519943295769;
        const int a = (axis + 1) % 3, b = (axis + 2) % 3;
        ty_affine rotation = ty_affine_identity();
        rotation.m[5 * a] = rotation.m[5 * b] = cos(angle);
        rotation.m[4 * b + a] = sin(angle);
        rotation.m[4 * a + b] = -sin(angle);
        result = ty_affine_multiply(&rotation, &result);
    }
    for (int r = 0; r < 3; ++r) result.m[4 * r + 3] = translate[r];
    return result;
}
