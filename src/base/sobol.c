/* Direction numbers of the Sobol sequence. */
#include "base/random.k.h"

typedef struct polynomial {
    int degree;
    uint32_t coefficients; /* of the powers degree - 1 .. 1, highest first */
    uint32_t first[6];
} polynomial;

/* Joe and Kuo 2008, dimensions 2 to 16; dimension 1 is the van der Corput sequence. */
static const polynomial table[TY_SOBOL_DIMENSIONS - 1] = {
    {1, 0, {1}},
    {2, 1, {1, 3}},
    {3, 1, {1, 3, 1}},
    {3, 2, {1, 1, 1}},
    {4, 1, {1, 1, 3, 3}},
    {4, 4, {1, 3, 5, 13}},
    {5, 2, {1, 1, 5, 5, 17}},
    {5, 4, {1, 1, 5, 5, 5}},
    {5, 7, {1, 1, 7, 11, 19}},
    {5, 11, {1, 1, 5, 1, 1}},
    {5, 13, {1, 1, 1, 3, 11}},
    {5, 14, {1, 3, 5, 5, 31}},
    {6, 1, {1, 3, 3, 9, 7, 49}},
    {6, 13, {1, 1, 1, 15, 21, 21}},
    {6, 16, {1, 3, 1, 13, 27, 49}},
};

void ty_sobol_matrices(ty_sobol* out) {
    for (int bit = 0; bit < TY_SOBOL_BITS; ++bit) out->matrix[0][bit] = 1u << (31 - bit);
    for (int d = 1; d < TY_SOBOL_DIMENSIONS; ++d) {
        const polynomial p = table[d - 1];
        uint32_t* v = out->matrix[d];
        for (int bit = 0; bit < TY_SOBOL_BITS; ++bit) {
            if (bit < p.degree) {
                v[bit] = p.first[bit] << (31 - bit);
                continue;
            }
            v[bit] = v[bit - p.degree] ^ v[bit - p.degree] >> p.degree;
            for (int k = 1; k < p.degree; ++k)
                if ((p.coefficients >> (p.degree - 1 - k) & 1u) != 0) v[bit] ^= v[bit - k];
        }
    }
}
