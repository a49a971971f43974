/* First-order regression in the window of one center (Bitterli et al. 2016). */
#ifndef TY_IMAGE_DENOISE_REGRESSION_K_H
#define TY_IMAGE_DENOISE_REGRESSION_K_H

#include "image/denoise/patch.k.h"

enum {
    TY_BASIS_MAX = TY_DENOISE_PLANES_MAX + 1,
    TY_COLUMNS_MAX = TY_BASIS_MAX + 3 + 3 /* with colors, and whole groups of four */
};

/* Columns and weights of the window of a center. */
typedef struct ty_regression {
    int32_t basis;                                    /* 1 and the features, less their values at the center */
    float column[TY_COLUMNS_MAX][TY_DENOISE_WEIGHTS]; /* basis, then R, G, B */
    float weight[2][TY_DENOISE_WEIGHTS];              /* narrow, wide */
} ty_regression;

/* A candidate's model: radiance[c] = beta[0][c] + sum of beta[i][c] basis i. */
typedef struct ty_linear_model {
    float beta[TY_BASIS_MAX][3];
    float mean[3];
} ty_linear_model;

TY_INLINE float ty_lanes_sum(ty_lanes value) {
    float parts[TY_LANES];
    memcpy(parts, &value, sizeof parts);
    for (int32_t half = TY_LANES / 2; half > 0; half /= 2)
        for (int32_t i = 0; i < half; ++i) parts[i] += parts[i + half];
    return parts[0];
}

/* Scalar products of two columns with four others. */
TY_INLINE void ty_products(const float (*a)[TY_DENOISE_WEIGHTS], const float (*b)[TY_DENOISE_WEIGHTS], float* first,
                           float* second) {
    ty_lanes sums[2][4] = {{{0}, {0}, {0}, {0}}, {{0}, {0}, {0}, {0}}};
    for (int32_t i = 0; i < TY_DENOISE_WEIGHTS; i += TY_LANES) {
        const ty_lanes factor = ty_lanes_load(a[0] + i), other = ty_lanes_load(a[1] + i);
        for (int32_t k = 0; k < 4; ++k) {
            const ty_lanes value = ty_lanes_load(b[k] + i);
            sums[0][k] += factor * value;
            sums[1][k] += other * value;
        }
    }
    for (int32_t k = 0; k < 4; ++k) {
        first[k] = ty_lanes_sum(sums[0][k]);
        second[k] = ty_lanes_sum(sums[1][k]);
    }
}

/* Sums over the window of weight times products of columns: out[i][j], j >= i. */
TY_INLINE void ty_normal_equations(const ty_regression* regression, const float* weight,
                                   float out[TY_BASIS_MAX + 1][TY_COLUMNS_MAX]) {
    float weighted[2][TY_DENOISE_WEIGHTS];
    for (int32_t i = 0; i < regression->basis; i += 2) {
        for (int32_t row = 0; row < 2; ++row)
            for (int32_t k = 0; k < TY_DENOISE_WEIGHTS; k += TY_LANES)
                ty_lanes_store(weighted[row] + k,
                               ty_lanes_load(weight + k) * ty_lanes_load(regression->column[i + row] + k));
        for (int32_t j = i; j < regression->basis + 3; j += 4)
            ty_products((const float(*)[TY_DENOISE_WEIGHTS])weighted, regression->column + j, out[i] + j,
                        out[i + 1] + j);
    }
}

/* Cholesky's decomposition of the covariances of features; a feature without variance of its own gets no part. */
TY_FN void ty_solve_covariance(int32_t count, float (*matrix)[TY_BASIS_MAX], float (*right)[3]) {
    for (int32_t j = 0; j < count; ++j) {
        float pivot = matrix[j][j];
        const float own = pivot;
        for (int32_t k = 0; k < j; ++k) pivot -= matrix[j][k] * matrix[j][k];
        const float inverse = pivot > 1e-5f * own && own > 0.0f ? 1.0f / sqrtf(pivot) : 0.0f;
        for (int32_t i = j + 1; i < count; ++i) {
            float sum = matrix[i][j];
            for (int32_t k = 0; k < j; ++k) sum -= matrix[i][k] * matrix[j][k];
            matrix[i][j] = sum * inverse;
        }
        matrix[j][j] = inverse;
        for (int32_t c = 0; c < 3; ++c) {
            float sum = right[j][c];
            for (int32_t k = 0; k < j; ++k) sum -= matrix[j][k] * right[k][c];
            right[j][c] = sum * inverse;
        }
    }
    for (int32_t j = count - 1; j >= 0; --j)
        for (int32_t c = 0; c < 3; ++c) {
            float sum = right[j][c];
            for (int32_t k = j + 1; k < count; ++k) sum -= matrix[k][j] * right[k][c];
            right[j][c] = sum * matrix[j][j];
        }
}

/* Weighted least squares with a ridge per feature, about the weighted means. */
TY_FN void ty_fit_model(const ty_regression* regression, const float* weight, const float* ridge,
                        ty_linear_model* model) {
    float products[TY_BASIS_MAX + 1][TY_COLUMNS_MAX], matrix[TY_BASIS_MAX][TY_BASIS_MAX], right[TY_BASIS_MAX][3];
    const int32_t basis = regression->basis, count = basis - 1;
    ty_normal_equations(regression, weight, products);
    const float inverse = 1.0f / products[0][0];
    for (int32_t c = 0; c < 3; ++c) model->mean[c] = model->beta[0][c] = products[0][basis + c] * inverse;
    for (int32_t i = 0; i < count; ++i) {
        const float mean = products[0][i + 1] * inverse;
        for (int32_t j = i; j < count; ++j)
            matrix[j][i] = products[i + 1][j + 1] * inverse - mean * products[0][j + 1] * inverse;
        matrix[i][i] = ty_maxf(matrix[i][i], 0.0f) + ridge[i];
        for (int32_t c = 0; c < 3; ++c) right[i][c] = products[i + 1][basis + c] * inverse - mean * model->mean[c];
    }
    ty_solve_covariance(count, matrix, right);
    for (int32_t i = 0; i < count; ++i)
        for (int32_t c = 0; c < 3; ++c) {
            model->beta[i + 1][c] = right[i][c];
            model->beta[0][c] -= right[i][c] * products[0][i + 1] * inverse;
        }
}

/* Adds the model's predictions in a window to sums, whose first value belongs to the window's. */
TY_INLINE void ty_add_predictions(const ty_regression* regression, const float* weight, int32_t basis,
                                  const float (*beta)[3], float (*sums)[TY_DENOISE_REACH * TY_DENOISE_REACH],
                                  int32_t at) {
    for (int32_t y = 0; y < TY_DENOISE_WINDOW; ++y)
        for (int32_t x = 0; x < TY_DENOISE_WINDOW; x += TY_LANES) {
            const int32_t from = y * TY_DENOISE_WINDOW + x, to = at + y * TY_DENOISE_REACH + x;
            const ty_lanes w = ty_lanes_load(weight + from);
            ty_lanes value[3] = {{0}, {0}, {0}};
            for (int32_t c = 0; c < 3; ++c) value[c] += beta[0][c];
            for (int32_t i = 1; i < basis; ++i) {
                const ty_lanes feature = ty_lanes_load(regression->column[i] + from);
                for (int32_t c = 0; c < 3; ++c) value[c] += beta[i][c] * feature;
            }
            for (int32_t c = 0; c < 3; ++c) ty_lanes_store(sums[c] + to, ty_lanes_load(sums[c] + to) + w * value[c]);
            ty_lanes_store(sums[3] + to, ty_lanes_load(sums[3] + to) + w);
        }
}

#endif
