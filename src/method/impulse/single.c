/* Single scattering of points and areas, and its fluence.
 *
 * The receiver x, the emitter s at distance d and the scattering point y form a triangle with angle theta at x and
 * alpha at s. The scattering angle is psi = theta + alpha, and the path length is d cos((theta - alpha) / 2) /
 * cos(psi / 2). At distance t along a ray, dt / |y - s|^2 = d alpha / (d sin theta): equiangular sampling (Kulla and
 * Fajardo 2012). The harmonics of the response are therefore
 *
 *     1 / d  integral over psi of p(cos psi)  integral over theta = 0..psi of exp(-length) y_l^m(theta) A_m(alpha) 2 pi
 *
 * where A_m are the Fourier coefficients of the emission around the axis. The integrand is singular only at the ends of
 * psi and theta, and one lattice of (psi, theta) serves all distances. */
#include "method/impulse/build.h"

#include <string.h>

enum { PSIS = 64, THETAS = 64, SUMS = TY_IMPULSE_ANGLES * TY_IMPULSE_PAIRS };

/* Optical depth beyond the direct path at which contributions are dropped. */
static const double max_extra_depth = 30; /* optical */

typedef struct lattice_point {
    double path_length;                /* path length divided by distance */
    double zonal[TY_IMPULSE_TERMS];    /* y_l^0 at the receiver times the weight */
    double emitted[TY_IMPULSE_ORDERS]; /* P_k at the emitter times the weight */
    ty_impulse_angles areas;           /* y_l^m A_m times the weight */
} lattice_point;

struct ty_impulse_lattice {
    double phase[PSIS][TY_IMPULSE_PHASES]; /* times the weight */
    double isotropic[PSIS];
    lattice_point points[PSIS][THETAS];
};

/* Fourier coefficients of max(0, level + swing cos phi) in cos(m phi); swing >= 0. */
static void clamped_cosine(double level, double swing, double out[TY_IMPULSE_TERMS]) {
    memset(out, 0, TY_IMPULSE_TERMS * sizeof *out);
    if (level <= -swing) return;
    if (level >= swing) {
        out[0] = level;
        out[1] = swing;
        return;
    }
    const double end = acos(-level / swing), over_pi = 1 / TY_PI_F64;
    out[0] = over_pi * (level * end + swing * sin(end));
    out[1] = over_pi * (2 * level * sin(end) + swing * (end + 0.5 * sin(2 * end)));
    for (int32_t m = 2; m < TY_IMPULSE_TERMS; ++m)
        out[m] = over_pi *
                 (2 * level * sin(m * end) / m + swing * (sin((m - 1) * end) / (m - 1) + sin((m + 1) * end) / (m + 1)));
}

static void make_point(const ty_impulse_recurrence* recurrence, double psi, double theta, double weight,
                       lattice_point* out) {
    const double alpha = psi - theta, full_circle = 2 * TY_PI_F64 * weight, half_circle = sqrt(2) * TY_PI_F64 * weight;
    double pairs[TY_IMPULSE_PAIRS], fourier[TY_IMPULSE_TERMS], emitted[TY_IMPULSE_EMITTED_PAIRS];
    out->path_length = cos(theta - 0.5 * psi) / cos(0.5 * psi);
    ty_impulse_legendre(recurrence, cos(theta), sin(theta), pairs);
    for (int32_t l = 0; l < TY_IMPULSE_TERMS; ++l) out->zonal[l] = full_circle * pairs[l];
    ty_impulse_legendre_emitted(recurrence, cos(alpha), sin(alpha), emitted);
    for (int32_t k = 0; k < TY_IMPULSE_ORDERS; ++k)
        out->emitted[k] = full_circle * ty_impulse_zonal_norm(ty_impulse_orders[k]) * emitted[k];
    for (int32_t angle = 0; angle < TY_IMPULSE_ANGLES; ++angle) {
        const double cosine = (double)ty_impulse_cosines[angle], sine = sqrt(1 - cosine * cosine);
        clamped_cosine(cosine * cos(alpha), sine * sin(alpha), fourier);
        for (int32_t m = 0; m < TY_IMPULSE_TERMS; ++m)
            for (int32_t l = m; l < TY_IMPULSE_TERMS; ++l) {
                const int32_t pair = ty_impulse_pair(l, m);
                out->areas.angle[angle].at[pair] = (m == 0 ? full_circle : half_circle) * fourier[m] * pairs[pair];
            }
    }
}

ty_result ty_impulse_make_lattice(ty_impulse_work* work) {
    work->lattice = ty_alloc_array(work->tables->context, 1, sizeof *work->lattice, true);
    if (work->lattice == NULL) return TY_ERROR_MEMORY;
    ty_impulse_nodes psi = {0};
    ty_impulse_add_singular(&psi, 0, TY_PI_F64, PSIS);
    for (int32_t i = 0; i < PSIS; ++i) {
        for (int32_t g = 0; g < TY_IMPULSE_PHASES; ++g)
            work->lattice->phase[i][g] = psi.weight[i] * ty_hg_f64(cos(psi.x[i]), TY_IMPULSE_PHASE_G * (g - 1));
        ty_impulse_nodes theta = {0};
        ty_impulse_add_singular(&theta, 0, psi.x[i], THETAS);
        for (int32_t j = 0; j < THETAS; ++j)
            make_point(&work->recurrence, psi.x[i], theta.x[j], theta.weight[j], &work->lattice->points[i][j]);
    }
    return TY_OK;
}

void ty_impulse_free_lattice(ty_impulse_work* work) {
    ty_free_array(work->tables->context, work->lattice, work->lattice != NULL, sizeof *work->lattice);
}

/* Sums over theta, for the distances of a block. */
typedef struct sums {
    double zonal[TY_IMPULSE_BLOCK][TY_IMPULSE_TERMS], emitted[TY_IMPULSE_BLOCK][TY_IMPULSE_ORDERS];
    double areas[TY_IMPULSE_BLOCK][SUMS];
} sums;

static void add_row(const lattice_point* row, const double* distances, int32_t count, bool areas, sums* out) {
    memset(out, 0, sizeof *out);
    for (int32_t j = 0; j < THETAS; ++j) {
        const lattice_point* point = &row[j];
        const double* all = point->areas.angle[0].at;
        for (int32_t k = 0; k < count; ++k) {
            if (distances[k] * (point->path_length - 1) > max_extra_depth) continue;
            const double transmittance = exp(-distances[k] * point->path_length);
            for (int32_t l = 0; l < TY_IMPULSE_TERMS; ++l) out->zonal[k][l] += transmittance * point->zonal[l];
            for (int32_t l = 0; l < TY_IMPULSE_ORDERS; ++l) out->emitted[k][l] += transmittance * point->emitted[l];
            if (!areas) continue;
            for (int32_t n = 0; n < SUMS; ++n) out->areas[k][n] += transmittance * all[n];
        }
    }
}

/* Single scattering of points, directions and areas: Eq. 14-16 (Dubouchet 2019). */
void ty_impulse_single_scattering(void* user, int64_t block, int32_t worker) {
    ty_impulse_work* work = user;
    (void)worker;
    const int32_t first = (int32_t)block * TY_IMPULSE_BLOCK;
    const int32_t left = work->distance_count - first, count = left < TY_IMPULSE_BLOCK ? left : TY_IMPULSE_BLOCK;
    const bool tabled = first < TY_IMPULSE_DISTANCES; /* the bins end at a block boundary */
    double points[TY_IMPULSE_BLOCK][TY_IMPULSE_PHASES][TY_IMPULSE_TERMS] = {0};
    sums row;
    for (int32_t i = 0; i < PSIS; ++i) {
        const double* phase = work->lattice->phase[i];
        add_row(work->lattice->points[i], work->distances + first, count, tabled, &row);
        for (int32_t k = 0; k < count; ++k) {
            const double inverse_distance = 1 / work->distances[first + k];
            /* The stored fluence is multiplied by distance. */
            for (int32_t l = 0; l < TY_IMPULSE_ORDERS; ++l)
                ty_impulse_fluence(work, 1, l)[first + k] +=
                    ty_impulse_cosine_coefficient(ty_impulse_orders[l]) * phase[1] * row.emitted[k][l];
            if (!tabled) continue;
            for (int32_t g = 0; g < TY_IMPULSE_PHASES; ++g) {
                double* areas = work->singles[(first + k) * TY_IMPULSE_PHASES + g].angle[0].at;
                for (int32_t l = 0; l < TY_IMPULSE_TERMS; ++l)
                    points[k][g][l] += inverse_distance * phase[g] * row.zonal[k][l];
                for (int32_t n = 0; n < SUMS; ++n) areas[n] += inverse_distance * phase[g] * row.areas[k][n];
            }
        }
    }
    for (int32_t k = 0; k < count && tabled; ++k)
        for (int32_t g = 0; g < TY_IMPULSE_PHASES; ++g)
            ty_impulse_store(work, TY_IMPULSE_POINT, 0, first + k, g, points[k][g]);
}
