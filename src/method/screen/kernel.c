/* Row loops over the item functions of *.k.h; built once per instruction set, with TY_ISA naming it. */
#include "method/screen/kernel.h"

/* Pixels processed together: their planes fit the first-level cache. */
enum { CHUNK = 256 };

typedef struct chunk {
    float radiance[3][CHUNK], distance[CHUNK];
    float attenuated[3][CHUNK], scattered[3][CHUNK], measure[3][CHUNK];
} chunk;

static int32_t min_index(int32_t a, int32_t b) {
    return a < b ? a : b;
}

static int32_t max_index(int32_t a, int32_t b) {
    return a > b ? a : b;
}

/* ---- splitting ---- */

static void load(const float* from, ptrdiff_t step, int32_t count, float* to) {
    if (step == 1) {
#pragma omp simd
        for (int32_t i = 0; i < count; ++i) to[i] = from[i];
        return;
    }
    for (int32_t i = 0; i < count; ++i) to[i] = from[i * step];
}

static void store(const float* from, int32_t count, float* to, ptrdiff_t step) {
    if (step == 1) {
#pragma omp simd
        for (int32_t i = 0; i < count; ++i) to[i] = from[i];
        return;
    }
    for (int32_t i = 0; i < count; ++i) to[i * step] = from[i];
}

static void find_distances(const ty_screen_params* params, const ty_screen_row* row, int32_t x0, int32_t count,
                           chunk* c, ty_screen_counts* counts) {
    float* distance = c->distance;
    const float* from = row->distance + x0 * row->distance_step;
    if (row->distance_step != 1 || params->planar) {
        load(from, row->distance_step, count, distance);
        from = distance;
    }
    if (params->planar) {
        const ty_screen_params p = *params;
#pragma omp simd
        for (int32_t i = 0; i < count; ++i) distance[i] *= ty_screen_distance_per_depth(p, x0 + i, row->y);
    }
    const float replacement = params->unknown;
    int32_t missing_depth = 0;
#pragma omp simd reduction(+ : missing_depth)
    for (int32_t i = 0; i < count; ++i) {
        int32_t missing;
        distance[i] = ty_screen_distance(from[i], replacement, &missing);
        missing_depth += missing;
    }
    counts->missing_depth += missing_depth;
}

static void sanitize_radiance(const ty_screen_row* row, int32_t x0, int32_t count, chunk* c, ty_screen_counts* counts) {
    const float* from[3];
    for (int channel = 0; channel < 3; ++channel) {
        from[channel] = row->color[channel] + x0 * row->color_step;
        if (row->color_step == 1) continue;
        load(from[channel], row->color_step, count, c->radiance[channel]);
        from[channel] = c->radiance[channel];
    }
    const float *red = from[0], *green = from[1], *blue = from[2];
    float *r = c->radiance[0], *g = c->radiance[1], *b = c->radiance[2];
    int32_t nonfinite_fixed = 0;
#pragma omp simd reduction(+ : nonfinite_fixed)
    for (int32_t i = 0; i < count; ++i) {
        int32_t changed = 0;
        r[i] = ty_screen_sanitize(red[i], TY_SCREEN_RADIANCE_MAX, &changed);
        g[i] = ty_screen_sanitize(green[i], TY_SCREEN_RADIANCE_MAX, &changed);
        b[i] = ty_screen_sanitize(blue[i], TY_SCREEN_RADIANCE_MAX, &changed);
        nonfinite_fixed += changed;
    }
    counts->nonfinite_fixed += nonfinite_fixed;
}

static void measure_spread(const ty_screen_params* params, int channel, const chunk* c, int32_t count, float* measure) {
    const float slope = params->slope[channel], curvature = params->curvature[channel];
    const float* distance = c->distance;
    if (curvature > 0) {
#pragma omp simd
        for (int32_t i = 0; i < count; ++i) measure[i] = ty_screen_variance(slope, curvature, distance[i]);
    } else {
#pragma omp simd
        for (int32_t i = 0; i < count; ++i) measure[i] = ty_screen_variance(slope, 0.0f, distance[i]);
    }
}

static void split_light(const ty_screen_params* params, int channel, int32_t count, chunk* c) {
    const float sigma_s = params->sigma_s[channel], sigma_a = params->sigma_a[channel];
    const float airlight = params->airlight[channel], forward = params->forward[channel];
    const float *radiance = c->radiance[channel], *distance = c->distance;
    float *attenuated = c->attenuated[channel], *scattered = c->scattered[channel];
#pragma omp simd
    for (int32_t i = 0; i < count; ++i) {
        const ty_screen_light_split light =
            ty_screen_split_light(sigma_s, sigma_a, airlight, forward, radiance[i], distance[i]);
        attenuated[i] = light.attenuated + light.airlight;
        scattered[i] = light.scattered;
    }
}

static void update_largest(const chunk* c, int32_t count, const float limit[3], ty_screen_counts* counts) {
    const float *r = c->measure[0], *g = c->measure[1], *b = c->measure[2];
    const float limit_r = limit[0], limit_g = limit[1], limit_b = limit[2];
    float largest_r = counts->largest[0], largest_g = counts->largest[1], largest_b = counts->largest[2];
    int32_t oversized = 0;
#pragma omp simd reduction(+ : oversized) reduction(max : largest_r, largest_g, largest_b)
    for (int32_t i = 0; i < count; ++i) {
        oversized += (r[i] > limit_r) | (g[i] > limit_g) | (b[i] > limit_b);
        largest_r = ty_maxf(largest_r, r[i]);
        largest_g = ty_maxf(largest_g, g[i]);
        largest_b = ty_maxf(largest_b, b[i]);
    }
    counts->oversized += oversized;
    counts->largest[0] = largest_r;
    counts->largest[1] = largest_g;
    counts->largest[2] = largest_b;
}

/* Loads distances, sanitised radiance, and the measures of spread. */
static void load_chunk(const ty_screen_params* params, const ty_screen_row* row, int32_t x0, int32_t count,
                       const float limit[3], chunk* c, ty_screen_counts* counts) {
    find_distances(params, row, x0, count, c, counts);
    sanitize_radiance(row, x0, count, c, counts);
    for (int channel = 0; channel < 3; ++channel) measure_spread(params, channel, c, count, c->measure[channel]);
    update_largest(c, count, limit, counts);
}

static void split_chunk(const ty_screen_params* params, const ty_screen_row* row, int32_t x0, int32_t count,
                        const float limit[3], chunk* c, ty_screen_counts* counts) {
    load_chunk(params, row, x0, count, limit, c, counts);
    for (int channel = 0; channel < 3; ++channel) split_light(params, channel, count, c);
}

static void store_if(const float* from, int32_t count, float* to, int32_t x0) {
    if (to != NULL) memcpy(to + x0, from, sizeof(float) * (size_t)count);
}

static void split(const ty_screen_params* params, const ty_screen_row* row, const float limit[3],
                  const ty_screen_split_out* out, ty_screen_counts* counts) {
    chunk c;
    for (int32_t x0 = 0; x0 < params->width; x0 += CHUNK) {
        const int32_t count = min_index(CHUNK, params->width - x0);
        split_chunk(params, row, x0, count, limit, &c, counts);
        for (int channel = 0; channel < 3; ++channel) {
            store_if(c.attenuated[channel], count, out->attenuated[channel], x0);
            store_if(c.scattered[channel], count, out->scattered[channel], x0);
            store_if(c.measure[channel], count, out->measure[channel], x0);
        }
    }
}

/* ---- scattering ---- */

/* Transport of one channel in a chunk per unit radiance: the fraction passed to level 1, the fraction that stays, and
 * the airlight. */
typedef struct transport {
    float passed[CHUNK], stays[CHUNK], airlight[CHUNK];
} transport;

static void find_transport(const ty_screen_params* params, ty_screen_down_fraction down_fraction, int channel,
                           int32_t count, const chunk* c, transport* f) {
    const float sigma_s = params->sigma_s[channel], sigma_a = params->sigma_a[channel];
    const float airlight = params->airlight[channel], forward = params->forward[channel];
    const float *distance = c->distance, *measure = c->measure[channel];
#pragma omp simd
    for (int32_t i = 0; i < count; ++i) {
        const ty_screen_transport t =
            ty_screen_transport_at(sigma_s, sigma_a, airlight, forward, down_fraction, distance[i], measure[i]);
        f->passed[i] = t.passed;
        f->stays[i] = t.stays;
        f->airlight[i] = t.airlight;
    }
}

/* Splits one channel of a chunk: light passed on into light and moment, the rest into base. */
static void scatter_light(const transport* f, int channel, int32_t count, const chunk* c, float* base, float* light,
                          float* moment) {
    const float *radiance = c->radiance[channel], *measure = c->measure[channel];
#pragma omp simd
    for (int32_t i = 0; i < count; ++i) {
        const float passed = f->passed[i] * radiance[i];
        base[i] = f->stays[i] * radiance[i] + f->airlight[i];
        light[i] = passed;
        moment[i] = passed * measure[i];
    }
}

/* True if the medium treats a channel like the previous one. */
static bool same_transport(const ty_screen_params* params, int channel) {
    if (channel == 0) return false;
    const int before = channel - 1;
    return params->sigma_s[channel] == params->sigma_s[before] && params->sigma_a[channel] == params->sigma_a[before] &&
           params->airlight[channel] == params->airlight[before] &&
           params->forward[channel] == params->forward[before] && params->slope[channel] == params->slope[before] &&
           params->curvature[channel] == params->curvature[before] && params->angle[channel] == params->angle[before];
}

static void scatter(const ty_screen_params* params, const ty_screen_row* row,
                    const ty_screen_down_fraction fractions[3], const float limit[3], float* const out[3],
                    ptrdiff_t out_step, float* const split_level[6], ty_screen_counts* counts) {
    chunk c;
    transport f;
    float base[CHUNK];
    ty_screen_counts ignored = {0};
    for (int32_t x0 = 0; x0 < params->width; x0 += CHUNK) {
        const int32_t count = min_index(CHUNK, params->width - x0);
        load_chunk(params, row, x0, count, limit, &c, out != NULL ? counts : &ignored);
        for (int channel = 0; channel < 3; ++channel) {
            if (!same_transport(params, channel)) find_transport(params, fractions[channel], channel, count, &c, &f);
            float* const to = out != NULL ? out[channel] + x0 * out_step : base;
            float* const stays = out_step == 1 ? to : base;
            scatter_light(&f, channel, count, &c, stays, split_level[channel] + x0, split_level[3 + channel] + x0);
            if (stays != to) store(base, count, to, out_step);
        }
    }
}

static void split_level(const ty_screen_level* level, int32_t y, float* const out[6]) {
    for (int channel = 0; channel < 3; ++channel) {
        const ty_screen_down_fraction down_fraction = level->down_fraction[channel];
        const float* light = level->plane[channel] + y * level->stride;
        const float* moment = level->plane[3 + channel] + y * level->stride;
        float *light_passed = out[channel], *moment_passed = out[3 + channel];
#pragma omp simd
        for (int32_t i = 0; i < level->width; ++i) {
            const float fraction = ty_screen_passed_fraction(down_fraction, light[i], moment[i]);
            light_passed[i] = fraction * light[i];
            moment_passed[i] = fraction * moment[i];
        }
    }
}

/* ---- resampling between levels ---- */

/* One downsampled texel anywhere in the row, clamped at the edges. */
static float downsample_texel(const ty_screen_taps* taps, const float* row, int32_t width, int32_t x) {
    float sum = 0;
    for (int32_t pair = 0; pair < taps->reach; ++pair)
        sum += taps->down[pair] *
               (row[max_index(min_index(2 * x - pair, width - 1), 0)] + row[min_index(2 * x + 1 + pair, width - 1)]);
    return sum;
}

/* One downsampled texel with explicit weights. */
static float downsample_edge(const float* weights, const float* row, int32_t x) {
    float sum = 0;
    for (int32_t i = 0; i < TY_SCREEN_DOWN_WEIGHTS; ++i)
        if (weights[i] > 0) sum += weights[i] * row[2 * x - 2 + i];
    return sum;
}

/* Downsampled texels begin..end - 1, away from the ends; at most CHUNK of them. */
static void downsample_interior(const ty_screen_taps* taps, const float* row, int32_t begin, int32_t end, float* out) {
    float even[CHUNK + 2], odd[CHUNK + 2]; /* starting one texel earlier */
    const int32_t count = end - begin;
    const float* from = row + 2 * (begin - 1);
#pragma omp simd
    for (int32_t i = 0; i < count + 2; ++i) {
        even[i] = from[2 * i];
        odd[i] = from[2 * i + 1];
    }
    const float inner = taps->down[0], outer = taps->down[1], outermost = taps->down[2];
    if (taps->reach <= 2) {
#pragma omp simd
        for (int32_t i = 0; i < count; ++i)
            out[begin + i] = inner * (even[i + 1] + odd[i + 1]) + outer * (odd[i] + even[i + 2]);
    } else {
#pragma omp simd
        for (int32_t i = 0; i < count; ++i)
            out[begin + i] = inner * (even[i + 1] + odd[i + 1]) + outer * (odd[i] + even[i + 2]) +
                             outermost * (even[i] + odd[i + 2]);
    }
}

static void downsample(const ty_screen_taps* taps, const float* row, int32_t width, const float* edges, float* out) {
    const int32_t half = (width + 1) / 2, begin = ty_screen_edge_begin(half), end = ty_screen_edge_end(half);
    for (int32_t x = begin; x < end; x += CHUNK) downsample_interior(taps, row, x, min_index(x + CHUNK, end), out);
    const float* weights = edges;
    for (int32_t x = 0; x < half; x = x + 1 == begin ? end : x + 1) {
        out[x] = edges != NULL ? downsample_edge(weights, row, x) : downsample_texel(taps, row, width, x);
        weights = edges != NULL ? weights + TY_SCREEN_DOWN_WEIGHTS : NULL;
    }
}

static void combine_rows(const float weights[TY_SCREEN_DOWN_WEIGHTS], const float* const rows[TY_SCREEN_DOWN_WEIGHTS],
                         int32_t width, float* out) {
    const float *a = rows[1], *b = rows[2], *c = rows[3], *d = rows[4];
    const float weight_a = weights[1], weight_b = weights[2], weight_c = weights[3], weight_d = weights[4];
    if (weights[0] <= 0 && weights[5] <= 0) {
#pragma omp simd
        for (int32_t i = 0; i < width; ++i)
            out[i] = weight_a * a[i] + weight_b * b[i] + (weight_c * c[i] + weight_d * d[i]);
        return;
    }
    const float *first = rows[0], *last = rows[5];
    const float weight_first = weights[0], weight_last = weights[5];
#pragma omp simd
    for (int32_t i = 0; i < width; ++i)
        out[i] = weight_a * a[i] + weight_b * b[i] + (weight_c * c[i] + weight_d * d[i]) +
                 (weight_first * first[i] + weight_last * last[i]);
}

/* Interpolates the rows of the next level around row y: `width` texels. */
static void interpolate_rows(const ty_screen_taps* taps, const ty_screen_level* next, int32_t channel, int32_t y,
                             float* out) {
    const int32_t nearest = y / 2, second_offset = (y & 1) != 0 ? 1 : -1, last = next->height - 1;
    const float* a = next->plane[channel] + nearest * next->stride;
    const float* b = next->plane[channel] + max_index(min_index(nearest + second_offset, last), 0) * next->stride;
    const float* c = next->plane[channel] + max_index(min_index(nearest - second_offset, last), 0) * next->stride;
    const float nearest_weight = taps->up[0], second_weight = taps->up[1], third_weight = taps->up[2];
    if (taps->reach_up <= 2) {
#pragma omp simd
        for (int32_t i = 0; i < next->width; ++i) out[i] = nearest_weight * a[i] + second_weight * b[i];
    } else {
#pragma omp simd
        for (int32_t i = 0; i < next->width; ++i)
            out[i] = nearest_weight * a[i] + second_weight * b[i] + third_weight * c[i];
    }
}

/* Adds the upsampled row of the next level to a row of `width` pixels. */
static void add_upsampled_row(const ty_screen_taps* taps, const float* row, int32_t next_width, int32_t width,
                              float* out, ptrdiff_t step) {
    const int32_t begin = min_index(1, next_width), end = max_index(min_index(next_width - 1, width / 2), begin);
    for (int32_t x = 0; x < min_index(2 * begin, width); ++x)
        out[x * step] += ty_screen_upsample(taps, row, next_width, x);
    const float nearest_weight = taps->up[0], second_weight = taps->up[1], third_weight = taps->up[2];
    if (step == 1) {
#pragma omp simd
        for (int32_t i = begin; i < end; ++i) {
            const float nearest_term = nearest_weight * row[i];
            out[2 * i] += nearest_term + second_weight * row[i - 1] + third_weight * row[i + 1];
            out[2 * i + 1] += nearest_term + second_weight * row[i + 1] + third_weight * row[i - 1];
        }
    } else {
        for (int32_t i = begin; i < end; ++i) {
            const float nearest_term = nearest_weight * row[i];
            out[2 * i * step] += nearest_term + second_weight * row[i - 1] + third_weight * row[i + 1];
            out[(2 * i + 1) * step] += nearest_term + second_weight * row[i + 1] + third_weight * row[i - 1];
        }
    }
    for (int32_t x = 2 * end; x < width; ++x) out[x * step] += ty_screen_upsample(taps, row, next_width, x);
}

static void merge_up(const ty_screen_taps* taps, const ty_screen_level* level, const ty_screen_level* next, int32_t y,
                     float* scratch) {
    for (int channel = 0; channel < 3; ++channel) {
        const ty_screen_down_fraction down_fraction = level->down_fraction[channel];
        float* light = level->plane[channel] + y * level->stride;
        const float* moment = level->plane[3 + channel] + y * level->stride;
#pragma omp simd
        for (int32_t i = 0; i < level->width; ++i)
            light[i] -= ty_screen_passed_fraction(down_fraction, light[i], moment[i]) * light[i];
        interpolate_rows(taps, next, channel, y, scratch);
        add_upsampled_row(taps, scratch, next->width, level->width, light, 1);
    }
}

static void add_upsampled(const ty_screen_taps* taps, const ty_screen_level* first, int32_t channel, int32_t y,
                          int32_t width, float* out, ptrdiff_t step, float* scratch) {
    interpolate_rows(taps, first, channel, y, scratch);
    add_upsampled_row(taps, scratch, first->width, width, out, step);
}

/* ---- the pyramid of Elek 2013 ---- */

static void gather_split(const ty_screen_params* params, const ty_screen_gather_params* gather,
                         const ty_screen_row* row, const float limit[3], float* const out[3], ptrdiff_t out_step,
                         float* texels, float* spread, ty_screen_counts* counts) {
    chunk c;
    const float slope = params->mean_slope, curvature = params->mean_curvature, max_distance = gather->max_distance;
    for (int32_t x0 = 0; x0 < params->width; x0 += CHUNK) {
        const int32_t count = min_index(CHUNK, params->width - x0);
        split_chunk(params, row, x0, count, limit, &c, counts);
        for (int channel = 0; channel < 3; ++channel)
            store(c.attenuated[channel], count, out[channel] + x0 * out_step, out_step);
        float *texel = texels + 4 * x0, *w = spread + x0;
#pragma omp simd
        for (int32_t i = 0; i < count; ++i) w[i] = sqrtf(ty_screen_variance(slope, curvature, c.distance[i]));
        for (int32_t i = 0; i < count; ++i) {
            texel[4 * i] = c.scattered[0][i];
            texel[4 * i + 1] = c.scattered[1][i];
            texel[4 * i + 2] = c.scattered[2][i];
            texel[4 * i + 3] = ty_minf(c.distance[i], max_distance);
        }
    }
}

/* The sums of Eq. 8 (Elek 2013) over the taps of one axis. */
static void gather_rows(const ty_screen_gather_params* gather, const float* texels, const float* spread, int32_t width,
                        float* const rows[TY_GATHER_ROWS]) {
    const ty_screen_mask_params mask = gather->mask;
    float *r = rows[0], *g = rows[1], *b = rows[2], *d = rows[TY_GATHER_DISTANCE];
    float *m = rows[TY_GATHER_MASK], *weight = rows[TY_GATHER_WEIGHT], *weighted = rows[TY_GATHER_SPREAD];
#pragma omp simd
    for (int32_t i = 0; i < width; ++i) {
        r[i] = texels[4 * i];
        g[i] = texels[4 * i + 1];
        b[i] = texels[4 * i + 2];
        d[i] = texels[4 * i + 3];
    }
    if (mask.kind == 0) return;
    const bool luminance = gather->luminance_weights != 0;
#pragma omp simd
    for (int32_t i = 0; i < width; ++i) {
        const float mask_value = ty_screen_mask_at(mask, spread[i]);
        weight[i] = luminance ? ty_screen_luminance(r[i], g[i], b[i]) : 1.0f;
        weighted[i] = weight[i] * spread[i];
        m[i] = mask_value;
        r[i] *= mask_value;
        g[i] *= mask_value;
        b[i] *= mask_value;
    }
}

/* The next level's texels and spread W[k]: the ratio of Eq. 8 (Elek 2013), with the weights Y of Eq. 9 (Elek 2013). */
static void gather_store(const ty_screen_gather_params* gather, const float* const rows[TY_GATHER_ROWS], int32_t width,
                         float* texels, float* spread) {
    const float *r = rows[0], *g = rows[1], *b = rows[2], *d = rows[TY_GATHER_DISTANCE];
    const float *m = rows[TY_GATHER_MASK], *weight = rows[TY_GATHER_WEIGHT], *weighted = rows[TY_GATHER_SPREAD];
    const bool masked = gather->mask.kind != 0, divide = masked && gather->normalise != 0;
    for (int32_t i = 0; i < width; ++i) {
        const float scale = divide ? 1.0f / ty_maxf(m[i], 1e-6f) : 1.0f;
        texels[4 * i] = scale * r[i];
        texels[4 * i + 1] = scale * g[i];
        texels[4 * i + 2] = scale * b[i];
        texels[4 * i + 3] = d[i];
        if (masked) spread[i] = weighted[i] / weight[i];
    }
}

/* Adds a row of the scattered image at the level L of each pixel's blurred distance: Eq. 11 (Elek 2013). */
static void gather_add(const ty_screen_params* params, const ty_screen_gather_params* gather,
                       const ty_screen_texels* levels, int32_t y, float* const out[3], ptrdiff_t out_step) {
    const float slope = params->mean_slope, curvature = params->mean_curvature, scale = gather->level_scale;
    const float top = (float)(gather->level_count - 1);
    const float* row = levels[0].texels + (ptrdiff_t)y * 4 * levels[0].width;
    float distance[CHUNK], level[CHUNK], light[4];
    for (int32_t x0 = 0; x0 < params->width; x0 += CHUNK) {
        const int32_t count = min_index(CHUNK, params->width - x0);
        for (int32_t i = 0; i < count; ++i) distance[i] = row[4 * (x0 + i) + 3];
        for (int pass = 0; pass < (gather->blurred_distance ? 2 : 1); ++pass) {
            for (int32_t i = 0; pass == 1 && i < count; ++i) {
                ty_screen_fetch(levels, gather->level_count, level[i], x0 + i, y, light);
                distance[i] = light[3];
            }
#pragma omp simd
            for (int32_t i = 0; i < count; ++i)
                level[i] = ty_screen_level_at(ty_screen_variance(slope, curvature, distance[i]), scale, top);
        }
        for (int32_t i = 0; i < count; ++i) {
            ty_screen_fetch(levels, gather->level_count, level[i], x0 + i, y, light);
            for (int c = 0; c < 3; ++c) out[c][(x0 + i) * out_step] += light[c];
        }
    }
}

/* ---- the exact point spread function ---- */

static void reference_prepare(const ty_screen_sources* sources, int32_t y) {
    for (int channel = 0; channel < 3; ++channel) {
        float* light = sources->light[channel] + (ptrdiff_t)y * sources->width;
        float* sharpness = sources->sharpness[channel] + (ptrdiff_t)y * sources->width;
        for (int32_t x = 0; x < sources->width; ++x) {
            sharpness[x] = 0.5f / ty_maxf(sharpness[x], TY_SCREEN_MIN_VARIANCE);
            const float sum = ty_screen_gaussian_sum(sharpness[x], sources->before, sources->after);
            light[x] /= sum * sum;
        }
    }
}

static void reference_add(const ty_screen_sources* sources, const int32_t from[2], const int32_t to[2], int32_t x,
                          int32_t y, int32_t count, float* sums) {
    for (int32_t source_y = from[1]; source_y < to[1]; ++source_y) {
        const float rise = (float)(y - source_y) * (float)(y - source_y);
        for (int32_t source_x = from[0]; source_x < to[0]; ++source_x) {
            const ptrdiff_t source = (ptrdiff_t)source_y * sources->width + source_x;
            const int32_t begin = max_index(source_x - sources->before - x, 0);
            const int32_t end = min_index(source_x + sources->after + 1 - x, count);
            for (int channel = 0; channel < 3; ++channel) {
                const float light = sources->light[channel][source], sharpness = sources->sharpness[channel][source];
                float* sum = sums + (ptrdiff_t)channel * count;
#pragma omp simd
                for (int32_t i = begin; i < end; ++i) {
                    const float run = (float)(x + i - source_x);
                    sum[i] += light * ty_screen_gaussian(sharpness, run * run + rise);
                }
            }
        }
    }
}

static void reference_coverage(const ty_screen_sources* sources, int channel, int32_t x, int32_t y, int32_t count,
                               float* coverage) {
    const float* sharpness = sources->sharpness[channel] + (ptrdiff_t)y * sources->width + x;
    const int32_t before = sources->before, after = sources->after;
    const int32_t above = min_index(after, y), below = min_index(before, sources->height - 1 - y);
    for (int32_t i = 0; i < count; ++i) {
        const int32_t left = min_index(after, x + i), right = min_index(before, sources->width - 1 - x - i);
        const float total = ty_screen_gaussian_sum(sharpness[i], before, after);
        coverage[i] = ty_screen_gaussian_sum(sharpness[i], left, right) *
                      ty_screen_gaussian_sum(sharpness[i], above, below) / (total * total);
    }
}

const ty_screen_kernels TY_KERNEL_NAME(ty_screen_kernels) = {
    .split = split,
    .scatter = scatter,
    .split_level = split_level,
    .downsample = downsample,
    .combine_rows = combine_rows,
    .merge_up = merge_up,
    .add_upsampled = add_upsampled,
    .gather_split = gather_split,
    .gather_rows = gather_rows,
    .gather_store = gather_store,
    .gather_add = gather_add,
    .reference_prepare = reference_prepare,
    .reference_add = reference_add,
    .reference_coverage = reference_coverage,
};
