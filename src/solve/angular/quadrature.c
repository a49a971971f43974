/* Directions for discrete ordinates.
 *
 * A set is symmetric under mirroring and permutation of the axes: a direction comes with all its 48 (or 24, or 8)
 * images. For any weights, sums of harmonics then vanish except for the few invariant ones, about (L + 1)^2 / 48 up to
 * order L; directions and weights make these vanish too, as far as there are unknowns. With 24 or more directions the
 * set also satisfies the half-range flux condition (sum over mu > 0 of w mu = pi) exactly. Full-range sums cannot see
 * it, and without it the fluence at a boundary is 0.5 % low with 96 directions, 2 % with 24. All weights are positive,
 * no direction lies in a plane of the axes, and directions of an octant are contiguous.
 *
 * A set that is exact to order 2 L - 2 keeps L bands of harmonics orthogonal: scattering conserves energy and
 * direction. */
#include "solve/angular/quadrature.h"

#include "base/constants.h"
#include "base/context.h"
#include "solve/angular/quadrature_table.h"

/* Permutations of three components; an orbit's directions are the first of them that are distinct. */
static const int8_t orders[6][3] = {{0, 1, 2}, {1, 2, 0}, {2, 0, 1}, {1, 0, 2}, {0, 2, 1}, {2, 1, 0}};

static int32_t orbit_size(const double w[3]) {
    const int same = (w[0] == w[1]) + (w[1] == w[2]);
    return same == 2 ? 1 : same == 1 ? 3 : 6;
}

static int32_t fill_octant(const ty_octant_quadrature* octant, ty_angular_quadrature* out) {
    int32_t at = 0;
    for (int32_t i = 0; i < octant->count; ++i) {
        const ty_symmetry_orbit* orbit = &octant->orbits[i];
        const int32_t size = orbit_size(orbit->direction);
        for (int32_t p = 0; p < size; ++p, ++at) {
            for (int a = 0; a < 3; ++a) out->direction[a][at] = (float)orbit->direction[orders[p][a]];
            out->weight[at] = (float)(0.5 * TY_PI_F64 * orbit->weight);
        }
    }
    return at;
}

ty_result ty_angular_quadrature_create(ty_context* context, int32_t count, ty_angular_quadrature* out,
                                       int32_t* exactness_order) {
    if (count < 8 || count > TY_ORDINATES_MAX)
        return ty_fail(context, TY_ERROR_ARGUMENT, "%d ordinates: 8 to %d are possible", (int)count, TY_ORDINATES_MAX);
    const ty_octant_quadrature* octant = ty_octant_quadrature_near(count / 8.0);
    *out = (ty_angular_quadrature){.count = 8 * octant->directions};
    const int32_t each = fill_octant(octant, out);
    for (int32_t o = 0; o < 8; ++o) {
        out->first[o] = o * each;
        for (int32_t i = 0; i < each; ++i) {
            for (int a = 0; a < 3; ++a)
                out->direction[a][o * each + i] = (o >> a & 1) != 0 ? -out->direction[a][i] : out->direction[a][i];
            out->weight[o * each + i] = out->weight[i];
        }
    }
    out->first[8] = out->count;
    if (exactness_order != NULL) *exactness_order = octant->exactness_order;
    return TY_OK;
}
