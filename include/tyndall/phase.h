/// @file phase.h
/// Phase functions: the distribution of the directions into which a medium scatters light, per steradian, as a function
/// of the cosine between the directions of travel before and after. docs/phase.md has formulas and sources. Apache-2.0.
#ifndef TYNDALL_PHASE_H
#define TYNDALL_PHASE_H

#include <tyndall/base.h>

#ifdef __cplusplus
extern "C" {
#endif

/// The form of a lobe, and the fields of ty_phase_lobe that it reads beside `weight`.
typedef enum ty_phase_kind {
    TY_PHASE_DRAINE = 0,          ///< Draine (2003): Henyey-Greenstein of `g` times 1 + `alpha` cos^2, normalised.
    TY_PHASE_MIE = 1,             ///< Fog and cloud droplets of a `diameter`, fitted by Jendersie and d'Eon (2023).
    TY_PHASE_FOURNIER_FORAND = 2, ///< Particles in water: `n` and `mu`, or `backscatter`.
    TY_PHASE_TABLE = 3            ///< `values` at `cosines`.
} ty_phase_kind;

/// Largest `alpha`.
#define TY_PHASE_ALPHA_MAX 1e6
/// Smallest and largest `diameter`, micrometres.
#define TY_PHASE_DIAMETER_MIN 0.001
/// See TY_PHASE_DIAMETER_MIN.
#define TY_PHASE_DIAMETER_MAX 50.0
/// Smallest and largest `n`.
#define TY_PHASE_INDEX_MIN 1.001
/// See TY_PHASE_INDEX_MIN.
#define TY_PHASE_INDEX_MAX 1.5
/// Smallest and largest `mu`.
#define TY_PHASE_SLOPE_MIN 3.01
/// See TY_PHASE_SLOPE_MIN.
#define TY_PHASE_SLOPE_MAX 4.99
/// Smallest and largest `backscatter`.
#define TY_PHASE_BACKSCATTER_MIN 1e-4
/// See TY_PHASE_BACKSCATTER_MIN.
#define TY_PHASE_BACKSCATTER_MAX 0.2

/// Largest number of lobes of a phase function, and of nodes of a table.
enum { TY_PHASE_LOBES_MAX = 8, TY_PHASE_NODES_MAX = 4096 };

/// A part of a phase function. Fields that its kind does not read are ignored.
typedef struct ty_phase_lobe {
    ty_phase_kind kind; ///< Draine, of which Henyey-Greenstein (`alpha` 0) and Rayleigh (`g` 0, `alpha` 1) are cases.
    float weight[3];    ///< Shares of the scattered light per channel, >= 0, relative to the sum over all lobes, > 0.
    double g;           ///< (-1, 1). The mean cosine if `alpha` is 0.
    double alpha;       ///< 0..TY_PHASE_ALPHA_MAX.
    double diameter;    ///< Micrometres, TY_PHASE_DIAMETER_MIN..TY_PHASE_DIAMETER_MAX.
    double n;           ///< Relative refractive index of the particles, 1.001 to 1.5; 0: by `backscatter`.
    double mu;          ///< Slope of the distribution of the particles' radii, 3.01 to 4.99, if `n` is not 0.
    double backscatter; ///< Fraction of the light that is scattered back, 1e-4 to 0.2, if `n` is 0.
    const double* cosines; ///< From -1 up to 1, or from 1 down to -1.
    const double* values;  ///< Relative phase function there, >= 0 and not all 0; linear in the cosine in between.
    int32_t count;         ///< Number of nodes, 2..TY_PHASE_NODES_MAX.
} ty_phase_lobe;

/// Sets `values` to the phase function of `count` lobes at `cosine_count` cosines, -1..1, per steradian: red, green and
/// blue for each. Errors: TY_ERROR_ARGUMENT, TY_ERROR_MEMORY.
TY_API ty_result ty_phase_values(ty_context* context, const ty_phase_lobe* lobes, int32_t count, int32_t cosine_count,
                                 const double* cosines, float* values);

/// Largest order of ty_phase_moments().
enum { TY_PHASE_ORDER_MAX = 13 };

/// Sets `moments` to the Legendre moments 0..`order` of the phase function of `count` lobes, the integrals of the
/// function times P_l over the sphere: all of red, then of green, then of blue. The first is 1 and the second the mean
/// cosine. Errors: TY_ERROR_ARGUMENT, TY_ERROR_MEMORY.
TY_API ty_result ty_phase_moments(ty_context* context, const ty_phase_lobe* lobes, int32_t count, int32_t order,
                                  double* moments);

#ifdef __cplusplus
}
#endif

#endif
