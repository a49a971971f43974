/* Multiple scattering of points and areas, from the fluence of the previous bounce.
 *
 * Fluence about an area is a sum of Legendre polynomials P_k of the angle to its normal. Scattering does not couple
 * orders, so each has a recursion of its own in distance alone; order 0 is that of points. With t the distance from the
 * receiver to the scattering point, and r from there to the emitter, d^3 y = r t / d dr dt dphi, and radiance is the
 * integral of exp(-t) fluence / (4 pi) along the ray:
 *
 *     harmonics = 1 / d  integral over r of r fluence_k(r)  integral over t = |d - r|..d + r of exp(-t) / (4 pi t)
 *                 y_l^m(theta) y_k^m(alpha)  ...
 *
 * theta and alpha are the angles of the triangle at receiver and emitter. A cosine lobe has no odd orders but the
 * first. */
#include "method/impulse/build.h"

#include <string.h>

static const double reach = 30; /* maximum path length, mean free paths */

static double clamp(double cosine) {
    return fmin(1, fmax(-1, cosine));
}

/* Cosine of a triangle's angle between sides d and t, opposite to r. */
static double angle_between(double d, double t, double r) {
    return clamp(((d - r) * (d + r) + t * t) / (2 * d * t));
}

static void add_path_lengths(double d, double r, ty_impulse_nodes* out) {
    const double min_length = fabs(d - r);
    out->count = 0;
    if (min_length > 0) ty_impulse_add_logarithmic(out, min_length, fmin(d + r, min_length + reach));
}

void ty_impulse_make_fluence_operator(void* user, int64_t index, int32_t worker) {
    ty_impulse_work* work = user;
    (void)worker;
    const double d = work->distances[index];
    double* rows = work->fluence_operator + (size_t)index * TY_IMPULSE_ORDERS * (size_t)work->distance_count;
    ty_impulse_nodes radii = {0}, path_lengths;
    ty_impulse_add_radii(work, d, &radii);
    for (int32_t i = 0; i < radii.count; ++i) {
        int32_t first;
        double weight[4], kernel[TY_IMPULSE_ORDERS] = {0}, at_emitter[TY_IMPULSE_EMITTED_PAIRS];
        if (!ty_impulse_cubic_weights(work, radii.x[i], &first, weight)) continue;
        add_path_lengths(d, radii.x[i], &path_lengths);
        for (int32_t j = 0; j < path_lengths.count; ++j) {
            const double t = path_lengths.x[j], path_weight = path_lengths.weight[j] * exp(-t) / t;
            const double alpha = angle_between(d, radii.x[i], t);
            ty_impulse_legendre_emitted(&work->recurrence, alpha, sqrt(1 - alpha * alpha), at_emitter);
            for (int32_t k = 0; k < TY_IMPULSE_ORDERS; ++k) kernel[k] += path_weight * at_emitter[k];
        }
        for (int32_t k = 0; k < TY_IMPULSE_ORDERS; ++k) {
            const double polynomial = ty_impulse_zonal_norm(ty_impulse_orders[k]) * kernel[k];
            for (int32_t j = 0; j < 4; ++j)
                rows[k * work->distance_count + first + j] += 0.5 * radii.weight[i] * weight[j] * polynomial;
        }
    }
}

/* Sums of y_l^m y_k^m over the path lengths to points at one distance from the emitter. */
static void add_products(const ty_impulse_recurrence* recurrence, double d, double r,
                         const ty_impulse_nodes* path_lengths, double out[TY_IMPULSE_PRODUCTS]) {
    double at_receiver[TY_IMPULSE_PAIRS], at_emitter[TY_IMPULSE_EMITTED_PAIRS];
    memset(out, 0, TY_IMPULSE_PRODUCTS * sizeof *out);
    for (int32_t j = 0; j < path_lengths->count; ++j) {
        const double t = path_lengths->x[j], path_weight = path_lengths->weight[j] * exp(-t) / (4 * TY_PI_F64 * t);
        const double theta = angle_between(d, t, r), alpha = angle_between(d, r, t);
        ty_impulse_legendre(recurrence, theta, sqrt(1 - theta * theta), at_receiver);
        ty_impulse_legendre_emitted(recurrence, alpha, sqrt(1 - alpha * alpha), at_emitter);
        double* product = out;
        const double *receiver_value = at_receiver, *emitter_value = at_emitter;
        for (int32_t m = 0; m < TY_IMPULSE_TERMS; ++m) {
            const int32_t count = ty_impulse_emitted_orders(m);
            for (int32_t l = m; l < TY_IMPULSE_TERMS; ++l, product += count) {
                const double factor = path_weight * *receiver_value++;
                for (int32_t k = 0; k < count; ++k) product[k] += factor * emitter_value[k];
            }
            emitter_value += count;
        }
    }
}

/* Adds the contribution of the fluence at one distance, for every bounce. */
static void add_bounces(const ty_impulse_work* work, int32_t first, const double weight[4], double path_weight,
                        const double kernel[TY_IMPULSE_PRODUCTS], double* sums) {
    for (int32_t bounce = 2; bounce <= work->tables->bounces; ++bounce) {
        double light[TY_IMPULSE_ORDERS];
        for (int32_t k = 0; k < TY_IMPULSE_ORDERS; ++k) {
            const double* fluence = ty_impulse_fluence(work, bounce - 1, k) + first;
            light[k] = path_weight * (weight[0] * fluence[0] + weight[1] * fluence[1] + weight[2] * fluence[2] +
                                      weight[3] * fluence[3]);
        }
        const double* from = kernel;
        for (int32_t m = 0; m < TY_IMPULSE_TERMS; ++m) {
            const int32_t count = ty_impulse_emitted_orders(m);
            const double* at = light + TY_IMPULSE_ORDERS - count;
            for (int32_t l = m; l < TY_IMPULSE_TERMS; ++l, from += count, sums += count)
                for (int32_t k = 0; k < count; ++k) sums[k] += at[k] * from[k];
        }
    }
}

/* Response of an area at one angle from the products. */
static void gather(const double angle[TY_IMPULSE_EMITTED_PAIRS], const double* products, ty_impulse_pairs* out) {
    double* to = out->at;
    for (int32_t m = 0; m < TY_IMPULSE_TERMS; ++m) {
        const int32_t count = ty_impulse_emitted_orders(m);
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

static void store_points(const ty_impulse_work* work, int32_t bin, const double* products) {
    /* Order 0 of an area is a quarter of its point. */
    const double factor = 4 * 2 * TY_PI_F64 * ty_impulse_zonal_norm(0);
    for (int32_t bounce = 2; bounce <= work->tables->bounces; ++bounce, products += TY_IMPULSE_PRODUCTS) {
        double zonal[TY_IMPULSE_TERMS];
        for (int32_t l = 0; l < TY_IMPULSE_TERMS; ++l) zonal[l] = factor * products[l * TY_IMPULSE_ORDERS];
        ty_impulse_store(work, TY_IMPULSE_POINT, 0, bin, TY_IMPULSE_PHASES + bounce - 2, zonal);
    }
}

/* Fits one axis for all bounces: that of their sum, at g = 0. */
static double fit_axis(const ty_impulse_work* work, int32_t angle, int32_t bin, const double* products) {
    ty_impulse_pairs all = work->singles[bin * TY_IMPULSE_PHASES + 1].angle[angle], more;
    for (int32_t bounce = 2; bounce <= work->tables->bounces; ++bounce, products += TY_IMPULSE_PRODUCTS) {
        gather(work->angles[angle], products, &more);
        for (int32_t pair = 0; pair < TY_IMPULSE_PAIRS; ++pair) all.at[pair] += more.at[pair];
    }
    return ty_impulse_fit_axis(&work->recurrence, &all);
}

static void store_area(const ty_impulse_work* work, int32_t angle, int32_t bin, const double* products) {
    const double axis_tilt = fit_axis(work, angle, bin, products);
    double zonal[TY_IMPULSE_TERMS];
    for (int32_t g = 0; g < TY_IMPULSE_PHASES; ++g) {
        ty_impulse_project(&work->recurrence, &work->singles[bin * TY_IMPULSE_PHASES + g].angle[angle], axis_tilt,
                           zonal);
        ty_impulse_store(work, TY_IMPULSE_AREA, angle, bin, g, zonal);
    }
    for (int32_t bounce = 2; bounce <= work->tables->bounces; ++bounce, products += TY_IMPULSE_PRODUCTS) {
        ty_impulse_pairs response;
        gather(work->angles[angle], products, &response);
        ty_impulse_project(&work->recurrence, &response, axis_tilt, zonal);
        ty_impulse_store(work, TY_IMPULSE_AREA, angle, bin, TY_IMPULSE_PHASES + bounce - 2, zonal);
    }
    const double cosine = (double)ty_impulse_cosines[angle], sine = sqrt(1 - cosine * cosine);
    if (sine > 0)
        ty_impulse_row(work->tables, TY_IMPULSE_AREA, angle, bin)[TY_IMPULSE_SHIFT] = (float)(axis_tilt / sine);
}

/* Extrapolates the axis tilt over sine to normal incidence, where both are 0. */
static void extrapolate_axis_tilt(const ty_impulse_work* work, int32_t bin) {
    enum { LAST = TY_IMPULSE_ANGLES - 1 };
    const float* before = ty_impulse_row(work->tables, TY_IMPULSE_AREA, LAST - 2, bin);
    const float* next = ty_impulse_row(work->tables, TY_IMPULSE_AREA, LAST - 1, bin);
    const float steps = (ty_impulse_cosines[LAST] - ty_impulse_cosines[LAST - 1]) /
                        (ty_impulse_cosines[LAST - 1] - ty_impulse_cosines[LAST - 2]);
    ty_impulse_row(work->tables, TY_IMPULSE_AREA, LAST, bin)[TY_IMPULSE_SHIFT] =
        next[TY_IMPULSE_SHIFT] + steps * (next[TY_IMPULSE_SHIFT] - before[TY_IMPULSE_SHIFT]);
}

void ty_impulse_multiple_scattering(void* user, int64_t bin, int32_t worker) {
    ty_impulse_work* work = user;
    const size_t more = (size_t)work->tables->bounces - 1;
    double* sums = work->products + (size_t)worker * more * TY_IMPULSE_PRODUCTS;
    const double d = work->distances[bin];
    memset(sums, 0, more * TY_IMPULSE_PRODUCTS * sizeof *sums);
    ty_impulse_nodes radii = {0}, path_lengths;
    if (more > 0) ty_impulse_add_radii(work, d, &radii);
    for (int32_t i = 0; i < radii.count; ++i) {
        int32_t first;
        double weight[4], kernel[TY_IMPULSE_PRODUCTS];
        if (!ty_impulse_cubic_weights(work, radii.x[i], &first, weight)) continue;
        add_path_lengths(d, radii.x[i], &path_lengths);
        add_products(&work->recurrence, d, radii.x[i], &path_lengths, kernel);
        add_bounces(work, first, weight, radii.weight[i] / d, kernel, sums);
    }
    store_points(work, (int32_t)bin, sums);
    for (int32_t angle = 0; angle < TY_IMPULSE_ANGLES; ++angle) store_area(work, angle, (int32_t)bin, sums);
    extrapolate_axis_tilt(work, (int32_t)bin);
}
