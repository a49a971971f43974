/* Light of points and areas that scatters again, from what has scattered before.
 *
 * Fluence about an area is a sum of Legendre polynomials P_k of the angle to its normal. No order makes another when
 * light scatters, so each has a recursion of its own in distance alone; order 0 is that of points. With t the way from
 * the receiver to where light scatters, and r from there to the emitter, d^3 y = r t / d dr dt dphi, and radiance is
 * the integral of exp(-t) fluence / (4 pi) along the ray:
 *
 *     harmonics = 1 / d  integral over r of r fluence_k(r)  integral over t = |d - r|..d + r of exp(-t) / (4 pi t)
 *                 y_l^m(theta) y_k^m(alpha)  ...
 *
 * theta and alpha being the triangle's angles at receiver and emitter. Odd orders but the first are not there: a cosine
 * lobe has none. */
#include "method/impulse/build.h"

#include <string.h>

static const double reach = 30; /* mean free paths that light is followed for */

static double clamp(double cosine) {
    return fmin(1, fmax(-1, cosine));
}

/* Cosines of a triangle's angles between d and t, and between d and r. */
static double angle_between(double d, double t, double r) {
    return clamp(((d - r) * (d + r) + t * t) / (2 * d * t));
}

static void add_ways(double d, double r, ty_impulse_nodes* out) {
    const double least = fabs(d - r);
    out->count = 0;
    if (least > 0) ty_impulse_add_logarithmic(out, least, fmin(d + r, least + reach));
}

void ty_impulse_make_spread(void* user, int64_t place, int32_t worker) {
    ty_impulse_work* work = user;
    (void)worker;
    const double d = work->distances[place];
    double* rows = work->spread + (size_t)place * TY_IMPULSE_ORDERS * (size_t)work->places;
    ty_impulse_nodes radii = {0}, ways;
    ty_impulse_add_radii(work, d, &radii);
    for (int32_t i = 0; i < radii.count; ++i) {
        int32_t first;
        double weight[4], kernel[TY_IMPULSE_ORDERS] = {0}, there[TY_IMPULSE_SENT];
        if (!ty_impulse_around(work, radii.x[i], &first, weight)) continue;
        add_ways(d, radii.x[i], &ways);
        for (int32_t j = 0; j < ways.count; ++j) {
            const double t = ways.x[j], share = ways.weight[j] * exp(-t) / t;
            const double alpha = angle_between(d, radii.x[i], t);
            ty_impulse_legendre_sent(&work->recurrence, alpha, sqrt(1 - alpha * alpha), there);
            for (int32_t k = 0; k < TY_IMPULSE_ORDERS; ++k) kernel[k] += share * there[k];
        }
        for (int32_t k = 0; k < TY_IMPULSE_ORDERS; ++k) {
            const double polynomial = sqrt(4 * TY_PI_F64 / (2 * ty_impulse_orders[k] + 1)) * kernel[k];
            for (int32_t j = 0; j < 4; ++j)
                rows[k * work->places + first + j] += 0.5 * radii.weight[i] * weight[j] * polynomial;
        }
    }
}

/* Sums of y_l^m y_k^m over the ways to points at one distance from the emitter. */
static void add_products(const ty_impulse_recurrence* recurrence, double d, double r, const ty_impulse_nodes* ways,
                         double out[TY_IMPULSE_PRODUCTS]) {
    double here[TY_IMPULSE_PAIRS], there[TY_IMPULSE_SENT];
    memset(out, 0, TY_IMPULSE_PRODUCTS * sizeof *out);
    for (int32_t j = 0; j < ways->count; ++j) {
        const double t = ways->x[j], share = ways->weight[j] * exp(-t) / (4 * TY_PI_F64 * t);
        const double theta = angle_between(d, t, r), alpha = angle_between(d, r, t);
        ty_impulse_legendre(recurrence, theta, sqrt(1 - theta * theta), here);
        ty_impulse_legendre_sent(recurrence, alpha, sqrt(1 - alpha * alpha), there);
        double* product = out;
        const double *at_here = here, *at_there = there;
        for (int32_t m = 0; m < TY_IMPULSE_TERMS; ++m) {
            const int32_t count = ty_impulse_sent(m);
            for (int32_t l = m; l < TY_IMPULSE_TERMS; ++l, product += count) {
                const double factor = share * *at_here++;
                for (int32_t k = 0; k < count; ++k) product[k] += factor * at_there[k];
            }
            at_there += count;
        }
    }
}

/* Adds what the light of one distance gives, of every bounce. */
static void add_bounces(const ty_impulse_work* work, int32_t first, const double weight[4], double share,
                        const double kernel[TY_IMPULSE_PRODUCTS], double* sums) {
    for (int32_t bounce = 2; bounce <= work->tables->bounces; ++bounce) {
        double light[TY_IMPULSE_ORDERS];
        for (int32_t k = 0; k < TY_IMPULSE_ORDERS; ++k) {
            const double* fluence = ty_impulse_fluence(work, bounce - 1, k) + first;
            light[k] = share * (weight[0] * fluence[0] + weight[1] * fluence[1] + weight[2] * fluence[2] +
                                weight[3] * fluence[3]);
        }
        const double* from = kernel;
        for (int32_t m = 0; m < TY_IMPULSE_TERMS; ++m) {
            const int32_t count = ty_impulse_sent(m);
            const double* at = light + TY_IMPULSE_ORDERS - count;
            for (int32_t l = m; l < TY_IMPULSE_TERMS; ++l, from += count, sums += count)
                for (int32_t k = 0; k < count; ++k) sums[k] += at[k] * from[k];
        }
    }
}

/* From products to a response at an angle of areas. */
static void gather(const double angle[TY_IMPULSE_SENT], const double* products, ty_impulse_pairs* out) {
    double* to = out->at;
    for (int32_t m = 0; m < TY_IMPULSE_TERMS; ++m) {
        const int32_t count = ty_impulse_sent(m);
        const int32_t* orders = ty_impulse_orders + TY_IMPULSE_ORDERS - count;
        const double side = m == 0 ? 2 * TY_PI_F64 : 2 * sqrt(2) * TY_PI_F64;
        for (int32_t l = m; l < TY_IMPULSE_TERMS; ++l, products += count) {
            double sum = 0;
            for (int32_t k = 0; k < count; ++k) sum += products[k] * angle[k] * 4 * TY_PI_F64 / (2 * orders[k] + 1);
            *to++ = side * sum;
        }
        angle += count;
    }
}

static void keep_points(const ty_impulse_work* work, int32_t bin, const double* products) {
    /* Order 0 of an area is a quarter of its point. */
    const double factor = 4 * 2 * TY_PI_F64 * sqrt(4 * TY_PI_F64);
    for (int32_t bounce = 2; bounce <= work->tables->bounces; ++bounce, products += TY_IMPULSE_PRODUCTS) {
        double zonal[TY_IMPULSE_TERMS];
        for (int32_t l = 0; l < TY_IMPULSE_TERMS; ++l) zonal[l] = factor * products[l * TY_IMPULSE_ORDERS];
        ty_impulse_keep(work, TY_IMPULSE_POINT, 0, bin, TY_IMPULSE_PHASES + bounce - 2, zonal);
    }
}

/* One axis for all: that of all light together, at g = 0. */
static double fit_axis(const ty_impulse_work* work, int32_t angle, int32_t bin, const double* products) {
    ty_impulse_pairs all = work->singles[bin * TY_IMPULSE_PHASES + 1].angle[angle], more;
    for (int32_t bounce = 2; bounce <= work->tables->bounces; ++bounce, products += TY_IMPULSE_PRODUCTS) {
        gather(work->angles[angle], products, &more);
        for (int32_t pair = 0; pair < TY_IMPULSE_PAIRS; ++pair) all.at[pair] += more.at[pair];
    }
    return ty_impulse_fit(&work->recurrence, &all);
}

static void keep_area(const ty_impulse_work* work, int32_t angle, int32_t bin, const double* products) {
    const double shift = fit_axis(work, angle, bin, products);
    double zonal[TY_IMPULSE_TERMS];
    for (int32_t g = 0; g < TY_IMPULSE_PHASES; ++g) {
        ty_impulse_lean(&work->recurrence, &work->singles[bin * TY_IMPULSE_PHASES + g].angle[angle], shift, zonal);
        ty_impulse_keep(work, TY_IMPULSE_AREA, angle, bin, g, zonal);
    }
    for (int32_t bounce = 2; bounce <= work->tables->bounces; ++bounce, products += TY_IMPULSE_PRODUCTS) {
        ty_impulse_pairs response;
        gather(work->angles[angle], products, &response);
        ty_impulse_lean(&work->recurrence, &response, shift, zonal);
        ty_impulse_keep(work, TY_IMPULSE_AREA, angle, bin, TY_IMPULSE_PHASES + bounce - 2, zonal);
    }
    const double cosine = (double)ty_impulse_cosines[angle], sine = sqrt(1 - cosine * cosine);
    if (sine > 0) ty_impulse_row(work->tables, TY_IMPULSE_AREA, angle, bin)[TY_IMPULSE_SHIFT] = (float)(shift / sine);
}

/* Shift over sine where both are 0. */
static void keep_straight_shift(const ty_impulse_work* work, int32_t bin) {
    enum { LAST = TY_IMPULSE_ANGLES - 1 };
    const float* before = ty_impulse_row(work->tables, TY_IMPULSE_AREA, LAST - 2, bin);
    const float* next = ty_impulse_row(work->tables, TY_IMPULSE_AREA, LAST - 1, bin);
    const float steps = (ty_impulse_cosines[LAST] - ty_impulse_cosines[LAST - 1]) /
                        (ty_impulse_cosines[LAST - 1] - ty_impulse_cosines[LAST - 2]);
    ty_impulse_row(work->tables, TY_IMPULSE_AREA, LAST, bin)[TY_IMPULSE_SHIFT] =
        next[TY_IMPULSE_SHIFT] + steps * (next[TY_IMPULSE_SHIFT] - before[TY_IMPULSE_SHIFT]);
}

void ty_impulse_scatter_again(void* user, int64_t bin, int32_t worker) {
    ty_impulse_work* work = user;
    const size_t more = (size_t)work->tables->bounces - 1;
    double* sums = work->products + (size_t)worker * more * TY_IMPULSE_PRODUCTS;
    const double d = work->distances[bin];
    memset(sums, 0, more * TY_IMPULSE_PRODUCTS * sizeof *sums);
    ty_impulse_nodes radii = {0}, ways;
    if (more > 0) ty_impulse_add_radii(work, d, &radii);
    for (int32_t i = 0; i < radii.count; ++i) {
        int32_t first;
        double weight[4], kernel[TY_IMPULSE_PRODUCTS];
        if (!ty_impulse_around(work, radii.x[i], &first, weight)) continue;
        add_ways(d, radii.x[i], &ways);
        add_products(&work->recurrence, d, radii.x[i], &ways, kernel);
        add_bounces(work, first, weight, radii.weight[i] / d, kernel, sums);
    }
    keep_points(work, (int32_t)bin, sums);
    for (int32_t angle = 0; angle < TY_IMPULSE_ANGLES; ++angle) keep_area(work, angle, (int32_t)bin, sums);
    keep_straight_shift(work, (int32_t)bin);
}
