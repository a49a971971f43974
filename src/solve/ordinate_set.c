/* Directions for discrete ordinates: an octant's, mirrored into all the others. */
#include "base/context.h"
#include "solve/harmonics.h"
#include "solve/ordinates.h"

#include <math.h>

enum { EXACT_MAX = 63 };
/* Of a weighted sum of harmonics, over 4 pi, that counts as none: directions are floats. */
#define NEARLY_NONE 1e-6

/* Directions of an octant as a lattice of golden angles lays them, all of the same weight. */
static void fill_octant(int32_t count, double (*direction)[3]) {
    for (int32_t i = 0; i < count; ++i) {
        const double z = (i + 0.5) / count, turn = fmod(0.5 + i * 0.6180339887498949, 1.0);
        const double radius = sqrt(1 - z * z), angle = 0.5 * 3.141592653589793 * turn;
        direction[i][0] = radius * cos(angle);
        direction[i][1] = radius * sin(angle);
        direction[i][2] = z;
    }
}

/* The highest order up to which all weighted sums of harmonics vanish, but the first. */
static int32_t exact_order(const ty_ordinate_set* set) {
    static const int32_t terms = (EXACT_MAX + 1) * (EXACT_MAX + 1);
    double sum[(EXACT_MAX + 1) * (EXACT_MAX + 1)] = {0}, y[(EXACT_MAX + 1) * (EXACT_MAX + 1)];
    for (int32_t d = 0; d < set->count; ++d) {
        const double w[3] = {(double)set->direction[0][d], (double)set->direction[1][d], (double)set->direction[2][d]};
        ty_harmonics_at(w, EXACT_MAX + 1, y);
        for (int32_t i = 0; i < terms; ++i) sum[i] += (double)set->weight[d] * y[i];
    }
    for (int32_t l = 1; l <= EXACT_MAX; ++l)
        for (int32_t i = l * l; i < (l + 1) * (l + 1); ++i)
            if (fabs(sum[i]) > NEARLY_NONE * 4 * 3.141592653589793) return l - 1;
    return EXACT_MAX;
}

ty_result ty_ordinate_set_make(ty_context* context, int32_t count, ty_ordinate_set* out, int32_t* exact) {
    if (count < 8 || count > TY_ORDINATES_MAX)
        return ty_fail(context, TY_ERROR_ARGUMENT, "%d ordinates: 8 to %d are possible", (int)count, TY_ORDINATES_MAX);
    const int32_t each = (count + 4) / 8;
    double octant[TY_ORDINATES_MAX / 8][3];
    fill_octant(each, octant);
    *out = (ty_ordinate_set){.count = 8 * each};
    for (int32_t o = 0; o < 8; ++o) {
        out->first[o] = o * each;
        for (int32_t i = 0; i < each; ++i) {
            for (int a = 0; a < 3; ++a)
                out->direction[a][o * each + i] = (float)((o >> a & 1) != 0 ? -octant[i][a] : octant[i][a]);
            out->weight[o * each + i] = (float)(4 * 3.141592653589793 / (8 * each));
        }
    }
    out->first[8] = out->count;
    if (exact != NULL) *exact = exact_order(out);
    return TY_OK;
}
