/* Joint bilateral upsampling of half-resolution media samples by ray distance. */
#ifndef TY_METHOD_LPV_IMAGE_UPSAMPLE_K_H
#define TY_METHOD_LPV_IMAGE_UPSAMPLE_K_H

#include "image/march/similarity.k.h"

enum { TY_LPV_UPSAMPLE_PERIOD = 8, TY_LPV_UPSAMPLE_FLOATS = 16 };

/* Radiance and transmittance of the media in front of a pixel; TY_LPV_UPSAMPLE_FLOATS floats. */
typedef struct ty_lpv_media_radiance {
    float transmittance[3], multiple[3], scattered[3], emission[3], single[3];
    float distance; /* length of the ray, m; INFINITY: unbounded */
} ty_lpv_media_radiance;

/* A ray's radiance and its derivatives with respect to distance; see ty_ray_march_result. */
typedef struct ty_lpv_media_sample {
    ty_lpv_media_radiance radiance;
    float extinction[3], multiple_rise[3], scattered_rise[3];
    float unused[TY_LPV_UPSAMPLE_FLOATS - 9]; /* 0 */
} ty_lpv_media_sample;

typedef struct ty_lpv_upsample {
    TY_GLOBAL const ty_lpv_media_sample* media_samples; /* NULL: vacuum */
    int32_t width, height;
    int32_t mask; /* number of rows stored, a power of two, minus 1: rows wrap around */
    float weights[TY_LPV_UPSAMPLE_PERIOD][TY_LPV_UPSAMPLE_PERIOD][4]; /* of the four rays around a pixel */
} ty_lpv_upsample;

/* The two rays around a pixel along one axis, and the weight of the second. A ray represents two pixels and lies
 * between them. */
TY_FN float ty_lpv_upsample_pair(int32_t pixel, int32_t count, int32_t pair[2]) {
    const int32_t first = (pixel + 1) / 2 - 1;
    pair[0] = first > 0 ? first : 0;
    pair[1] = first + 1 < count ? first + 1 : count - 1;
    return (pixel & 1) != 0 ? 0.25f : 0.75f;
}

TY_FN void ty_lpv_upsample_bilinear(float along, float down, float weight[4]) {
    for (int i = 0; i < 4; ++i) weight[i] = (i % 2 != 0 ? along : 1.0f - along) * (i / 2 != 0 ? down : 1.0f - down);
}

/* Per float: half of the channel's extinction applies, 1 where the derivative is added as it is, and 1 where it is
 * multiplied by the value (transmittance). */
typedef struct ty_lpv_upsample_lanes {
    float channel[3][TY_LPV_UPSAMPLE_FLOATS], rises[TY_LPV_UPSAMPLE_FLOATS], fades[TY_LPV_UPSAMPLE_FLOATS];
} ty_lpv_upsample_lanes;

TY_FN ty_lpv_upsample_lanes ty_lpv_upsample_lanes_make(void) {
    ty_lpv_upsample_lanes lanes;
    for (int j = 0; j < TY_LPV_UPSAMPLE_FLOATS; ++j) {
        for (int c = 0; c < 3; ++c) lanes.channel[c][j] = j < 9 && j % 3 == c ? 0.5f : 0.0f;
        lanes.rises[j] = j >= 3 && j < 9 ? 1.0f : 0.0f;
        lanes.fades[j] = j < 3 ? 1.0f : 0.0f;
    }
    return lanes;
}

/* Weighted mean of the rays, each extrapolated by the small distance `farther`, m. */
TY_FN void ty_lpv_upsample_mean(const ty_lpv_upsample_lanes* lanes,
                                TY_GLOBAL const ty_lpv_media_sample* const media_samples[4], const float weight[4],
                                const float farther[4], float mean[TY_LPV_UPSAMPLE_FLOATS]) {
    TY_GLOBAL const float *radiance[4], *change[4];
    float x[4], y[4], z[4];
    for (int i = 0; i < 4; ++i) {
        radiance[i] = media_samples[i]->radiance.transmittance;
        change[i] = media_samples[i]->extinction;
        x[i] = farther[i] * change[i][0];
        y[i] = farther[i] * change[i][1];
        z[i] = farther[i] * change[i][2];
    }
#pragma omp simd
    for (int j = 0; j < TY_LPV_UPSAMPLE_FLOATS; ++j) {
        const float a = lanes->channel[0][j], b = lanes->channel[1][j], c = lanes->channel[2][j];
        float sum = 0.0f;
        for (int i = 0; i < 4; ++i) {
            const float half = x[i] * a + y[i] * b + z[i] * c;
            const float rise = change[i][j] * (lanes->rises[j] - lanes->fades[j] * radiance[i][j]);
            sum += weight[i] * (radiance[i][j] + farther[i] * (1.0f - half) * rise);
        }
        const float min = lanes->rises[j] > 0.0f ? 0.0f : -TY_FLOAT_MAX;
        const float max = lanes->fades[j] > 0.0f ? 1.0f : TY_FLOAT_MAX;
        mean[j] = ty_clampf(sum, min, max);
    }
}

/* Range of single scattering among the rays with nonzero weight, sum of all channels. */
TY_FN float ty_lpv_upsample_contrast(TY_GLOBAL const ty_lpv_media_sample* const media_samples[4],
                                     const float weight[4]) {
    float min = TY_FLOAT_MAX, max = 0.0f;
    for (int i = 0; i < 4; ++i) {
        TY_GLOBAL const float* single = media_samples[i]->radiance.single;
        const float sum = single[0] + single[1] + single[2];
        min = weight[i] != 0.0f ? ty_minf(min, sum) : min;
        max = weight[i] != 0.0f ? ty_maxf(max, sum) : max;
    }
    return max - min;
}

/* Pixels of a row that are processed together. */
enum { TY_LPV_UPSAMPLE_WIDTH = 16 };

/* The four rays around each pixel of a batch. */
typedef struct ty_lpv_upsample_neighbours {
    TY_GLOBAL const ty_lpv_media_sample* media_samples[TY_LPV_UPSAMPLE_WIDTH][4];
    float far[TY_LPV_UPSAMPLE_WIDTH];
    float marched[4][TY_LPV_UPSAMPLE_WIDTH], weight[4][TY_LPV_UPSAMPLE_WIDTH], farther[4][TY_LPV_UPSAMPLE_WIDTH];
    float sum[TY_LPV_UPSAMPLE_WIDTH]; /* of weights */
} ty_lpv_upsample_neighbours;

TY_FN void ty_lpv_upsample_find(const ty_lpv_upsample* from, int32_t x, int32_t y, int32_t count, const float* distance,
                                ty_lpv_upsample_neighbours* row) {
    int32_t columns[2], rows[2];
    ty_lpv_upsample_pair(y, from->height, rows);
    TY_GLOBAL const ty_lpv_media_sample* lines[2];
    for (int j = 0; j < 2; ++j) lines[j] = from->media_samples + (size_t)(rows[j] & from->mask) * (size_t)from->width;
    for (int32_t k = 0; k < TY_LPV_UPSAMPLE_WIDTH; ++k) {
        ty_lpv_upsample_pair(x + (k < count ? k : 0), from->width, columns);
        row->far[k] = ty_minf(distance[k < count ? k : 0], TY_FLOAT_MAX);
        for (int i = 0; i < 4; ++i) {
            row->media_samples[k][i] = lines[i / 2] + columns[i % 2];
            row->marched[i][k] = row->media_samples[k][i]->radiance.distance;
        }
    }
}

/* Weights by position times similarity. Where all rays are similar, the positional weights are those whose mean
 * position is the pixel. */
TY_FN void ty_lpv_upsample_weigh(const ty_lpv_upsample* from, int32_t x, int32_t y, int32_t count,
                                 ty_lpv_upsample_neighbours* row) {
    float like[4][TY_LPV_UPSAMPLE_WIDTH], min[TY_LPV_UPSAMPLE_WIDTH];
    int32_t columns[2], rows[2];
    const float down = ty_lpv_upsample_pair(y, from->height, rows);
    for (int i = 0; i < 4; ++i) {
#pragma omp simd
        for (int32_t k = 0; k < TY_LPV_UPSAMPLE_WIDTH; ++k) {
            row->marched[i][k] = ty_minf(row->marched[i][k], TY_FLOAT_MAX);
            like[i][k] = ty_similarity(row->far[k], row->marched[i][k]);
        }
    }
#pragma omp simd
    for (int32_t k = 0; k < TY_LPV_UPSAMPLE_WIDTH; ++k)
        min[k] = ty_minf(ty_minf(like[0][k], like[1][k]), ty_minf(like[2][k], like[3][k]));
    for (int32_t k = 0; k < TY_LPV_UPSAMPLE_WIDTH; ++k) {
        float weight[4];
        const int32_t at = x + (k < count ? k : 0);
        const float along = ty_lpv_upsample_pair(at, from->width, columns);
        const bool centred = min[k] > 0.5f && columns[0] < columns[1] && rows[0] < rows[1];
        ty_lpv_upsample_bilinear(along, down, weight);
        TY_GLOBAL const float* table = from->weights[y % TY_LPV_UPSAMPLE_PERIOD][at % TY_LPV_UPSAMPLE_PERIOD];
        for (int i = 0; i < 4; ++i) row->weight[i][k] = centred ? table[i] : weight[i];
    }
#pragma omp simd
    for (int32_t k = 0; k < TY_LPV_UPSAMPLE_WIDTH; ++k) {
        float sum = 0.0f;
        for (int i = 0; i < 4; ++i) {
            row->weight[i][k] *= like[i][k];
            sum += row->weight[i][k];
        }
        const float scale = 1.0f / sum;
        for (int i = 0; i < 4; ++i) {
            row->weight[i][k] *= scale;
            row->farther[i][k] = row->weight[i][k] != 0.0f ? row->far[k] - row->marched[i][k] : 0.0f;
        }
        row->sum[k] = sum;
    }
}

/* Upsamples up to TY_LPV_UPSAMPLE_WIDTH pixels of a row. contrast: range of single scattering among the rays around
 * each pixel; negative if no ray has a similar distance. */
TY_FN void ty_lpv_upsample_row(const ty_lpv_upsample_lanes* lanes, const ty_lpv_upsample* from, int32_t x, int32_t y,
                               int32_t count, const float* distance, ty_lpv_media_radiance* out, float* contrast) {
    ty_lpv_upsample_neighbours row;
    ty_lpv_upsample_find(from, x, y, count, distance, &row);
    ty_lpv_upsample_weigh(from, x, y, count, &row);
    for (int32_t k = 0; k < count; ++k) {
        float weight[4], farther[4], mean[TY_LPV_UPSAMPLE_FLOATS];
        contrast[k] = -1.0f;
        if (!(row.sum[k] >= TY_SIMILARITY_WEIGHT_MIN)) continue;
        for (int i = 0; i < 4; ++i) {
            weight[i] = row.weight[i][k];
            farther[i] = row.farther[i][k];
        }
        ty_lpv_upsample_mean(lanes, row.media_samples[k], weight, farther, mean);
        memcpy(&out[k], mean, sizeof *out);
        out[k].distance = distance[k];
        contrast[k] = ty_lpv_upsample_contrast(row.media_samples[k], weight);
    }
}

#endif
