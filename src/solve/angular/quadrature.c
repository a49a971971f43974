/* Directions for discrete ordinates.
 *
 * A set is mirrored along the three axes and the same along each of them: with a direction it has all 48 (or 24, or 8)
 * that swapping and mirroring axes makes of it. Whatever the weights, sums of harmonics then vanish but for the few
 * that look the same themselves, about (L + 1)^2 / 48 up to order L; directions and weights are such that these vanish
 * too, as far as there are unknowns. From 24 directions on they are also such that as much of even light flows through
 * planes across the axes as should: what leaves a box is light of half of the directions, of which sums over all know
 * nothing, and its fluence would be some 0.5% too small with 96 directions, 2% with 24. All weights are positive, no
 * direction lies in a plane of the axes, and an octant's are swept together.
 *
 * A set that is exact to order 2 L - 2 keeps L bands of harmonics apart: what scatters is neither lost nor turned. */
#include "base/context.h"
#include "solve/angular/quadrature_table.h"
#include "solve/ordinates/ordinates.h"

/* Orders of three components; an orbit's directions are the first of them, no two of which are the same. */
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
            out->weight[at] = (float)(0.5 * 3.141592653589793 * orbit->weight);
        }
    }
    return at;
}

ty_result ty_angular_quadrature_create(ty_context* context, int32_t count, ty_angular_quadrature* out, int32_t* exact) {
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
    if (exact != NULL) *exact = octant->exact;
    return TY_OK;
}
