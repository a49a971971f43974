/* Row loops over the items of *.k.h; built once per instruction set, with TY_ISA naming it. */
#include "method/screen/kernel.h"

#define TY_JOIN_(a, b) a##b
#define TY_JOIN(a, b) TY_JOIN_(a, b)

/* Pixels that are worked on at a time: their planes stay in the nearest cache. */
enum { CHUNK = 256 };

typedef struct chunk {
    float radiance[3][CHUNK], distance[CHUNK];
    float attenuated[3][CHUNK], scattered[3][CHUNK], measure[3][CHUNK];
} chunk;

static int32_t least(int32_t a, int32_t b) {
    return a < b ? a : b;
}

static int32_t most(int32_t a, int32_t b) {
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
        for (int32_t i = 0; i < count; ++i) distance[i] *= ty_screen_slant(p, x0 + i, row->y);
    }
    const float replacement = params->unknown;
    int32_t unknown = 0;
#pragma omp simd reduction(+ : unknown)
    for (int32_t i = 0; i < count; ++i) {
        int32_t missing;
        distance[i] = ty_screen_distance(from[i], replacement, &missing);
        unknown += missing;
    }
    counts->unknown += unknown;
}

static void mend(const ty_screen_row* row, int32_t x0, int32_t count, chunk* c, ty_screen_counts* counts) {
    const float* from[3];
    for (int channel = 0; channel < 3; ++channel) {
        from[channel] = row->color[channel] + x0 * row->color_step;
        if (row->color_step == 1) continue;
        load(from[channel], row->color_step, count, c->radiance[channel]);
        from[channel] = c->radiance[channel];
    }
    const float *red = from[0], *green = from[1], *blue = from[2];
    float *r = c->radiance[0], *g = c->radiance[1], *b = c->radiance[2];
    int32_t mended = 0;
#pragma omp simd reduction(+ : mended)
    for (int32_t i = 0; i < count; ++i) {
        int32_t changed = 0;
        r[i] = ty_screen_mend(red[i], TY_SCREEN_RADIANCE_MAX, &changed);
        g[i] = ty_screen_mend(green[i], TY_SCREEN_RADIANCE_MAX, &changed);
        b[i] = ty_screen_mend(blue[i], TY_SCREEN_RADIANCE_MAX, &changed);
        mended += changed;
    }
    counts->mended += mended;
}

static void measure_spread(const ty_screen_params* params, int channel, const chunk* c, int32_t count, float* measure) {
    const float slope = params->slope[channel], bend = params->bend[channel];
    const float* distance = c->distance;
    if (bend > 0) {
#pragma omp simd
        for (int32_t i = 0; i < count; ++i) measure[i] = ty_screen_variance(slope, bend, distance[i]);
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
        const ty_screen_parts parts =
            ty_screen_split_light(sigma_s, sigma_a, airlight, forward, radiance[i], distance[i]);
        attenuated[i] = parts.attenuated + parts.airlight;
        scattered[i] = parts.scattered;
    }
}

static void note_largest(const chunk* c, int32_t count, const float limit[3], ty_screen_counts* counts) {
    const float *r = c->measure[0], *g = c->measure[1], *b = c->measure[2];
    const float most_r = limit[0], most_g = limit[1], most_b = limit[2];
    float largest_r = counts->largest[0], largest_g = counts->largest[1], largest_b = counts->largest[2];
    int32_t cut = 0;
#pragma omp simd reduction(+ : cut) reduction(max : largest_r, largest_g, largest_b)
    for (int32_t i = 0; i < count; ++i) {
        cut += (r[i] > most_r) | (g[i] > most_g) | (b[i] > most_b);
        largest_r = ty_maxf(largest_r, r[i]);
        largest_g = ty_maxf(largest_g, g[i]);
        largest_b = ty_maxf(largest_b, b[i]);
    }
    counts->cut += cut;
    counts->largest[0] = largest_r;
    counts->largest[1] = largest_g;
    counts->largest[2] = largest_b;
}

/* Distances, mended radiance, and how far light spreads. */
static void load_chunk(const ty_screen_params* params, const ty_screen_row* row, int32_t x0, int32_t count,
                       const float limit[3], chunk* c, ty_screen_counts* counts) {
    find_distances(params, row, x0, count, c, counts);
    mend(row, x0, count, c, counts);
    for (int channel = 0; channel < 3; ++channel) measure_spread(params, channel, c, count, c->measure[channel]);
    note_largest(c, count, limit, counts);
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
        const int32_t count = least(CHUNK, params->width - x0);
        split_chunk(params, row, x0, count, limit, &c, counts);
        for (int channel = 0; channel < 3; ++channel) {
            store_if(c.attenuated[channel], count, out->attenuated[channel], x0);
            store_if(c.scattered[channel], count, out->scattered[channel], x0);
            store_if(c.measure[channel], count, out->measure[channel], x0);
        }
    }
}

/* ---- scattering ---- */

/* What becomes of a channel's light in a chunk: the part that goes on to level 1, the part that does not, and what the
 * environment adds. */
typedef struct fates {
    float on[CHUNK], stays[CHUNK], airlight[CHUNK];
} fates;

static void find_fates(const ty_screen_params* params, ty_screen_share share, int channel, int32_t count,
                       const chunk* c, fates* f) {
    const float sigma_s = params->sigma_s[channel], sigma_a = params->sigma_a[channel];
    const float airlight = params->airlight[channel], forward = params->forward[channel];
    const float *distance = c->distance, *measure = c->measure[channel];
#pragma omp simd
    for (int32_t i = 0; i < count; ++i) {
        const ty_screen_parts parts = ty_screen_split_light(sigma_s, sigma_a, airlight, forward, 1.0f, distance[i]);
        const float on = ty_screen_onward(share, measure[i]) * parts.scattered;
        f->on[i] = on;
        f->stays[i] = parts.attenuated + (parts.scattered - on);
        f->airlight[i] = parts.airlight;
    }
}

/* One channel of a chunk: what goes on into light and moment, all else into base. */
static void scatter_light(const fates* f, int channel, int32_t count, const chunk* c, float* base, float* light,
                          float* moment) {
    const float *radiance = c->radiance[channel], *measure = c->measure[channel];
#pragma omp simd
    for (int32_t i = 0; i < count; ++i) {
        const float on = f->on[i] * radiance[i];
        base[i] = f->stays[i] * radiance[i] + f->airlight[i];
        light[i] = on;
        moment[i] = on * measure[i];
    }
}

/* Whether the medium treats a channel as it does the one before. */
static bool same_fate(const ty_screen_params* params, int channel) {
    if (channel == 0) return false;
    const int before = channel - 1;
    return params->sigma_s[channel] == params->sigma_s[before] && params->sigma_a[channel] == params->sigma_a[before] &&
           params->airlight[channel] == params->airlight[before] &&
           params->forward[channel] == params->forward[before] && params->slope[channel] == params->slope[before] &&
           params->bend[channel] == params->bend[before] && params->angle[channel] == params->angle[before];
}

static void scatter(const ty_screen_params* params, const ty_screen_row* row, const ty_screen_share shares[3],
                    const float limit[3], float* const out[3], ptrdiff_t out_step, float* const onward[6],
                    ty_screen_counts* counts) {
    chunk c;
    fates f;
    float base[CHUNK];
    ty_screen_counts ignored = {0};
    for (int32_t x0 = 0; x0 < params->width; x0 += CHUNK) {
        const int32_t count = least(CHUNK, params->width - x0);
        load_chunk(params, row, x0, count, limit, &c, out != NULL ? counts : &ignored);
        for (int channel = 0; channel < 3; ++channel) {
            if (!same_fate(params, channel)) find_fates(params, shares[channel], channel, count, &c, &f);
            float* const to = out != NULL ? out[channel] + x0 * out_step : base;
            float* const stays = out_step == 1 ? to : base;
            scatter_light(&f, channel, count, &c, stays, onward[channel] + x0, onward[3 + channel] + x0);
            if (stays != to) store(base, count, to, out_step);
        }
    }
}

static void onward(const ty_screen_level* level, int32_t y, float* const out[6]) {
    for (int channel = 0; channel < 3; ++channel) {
        const ty_screen_share share = level->share[channel];
        const float* light = level->plane[channel] + y * level->stride;
        const float* moment = level->plane[3 + channel] + y * level->stride;
        float *light_on = out[channel], *moment_on = out[3 + channel];
#pragma omp simd
        for (int32_t i = 0; i < level->width; ++i) {
            const float part = ty_screen_onward(share, ty_screen_mean_measure(light[i], moment[i]));
            light_on[i] = part * light[i];
            moment_on[i] = part * moment[i];
        }
    }
}

/* ---- from level to level ---- */

/* One texel of a narrower row, anywhere in it: what lies outside counts as the edge. */
static float narrow_item(const ty_screen_taps* taps, const float* row, int32_t width, int32_t x) {
    float sum = 0;
    for (int32_t pair = 0; pair < taps->reach; ++pair)
        sum +=
            taps->down[pair] * (row[most(least(2 * x - pair, width - 1), 0)] + row[least(2 * x + 1 + pair, width - 1)]);
    return sum;
}

/* The same with weights of its own. */
static float narrow_edge(const float* weights, const float* row, int32_t x) {
    float sum = 0;
    for (int32_t i = 0; i < TY_SCREEN_DOWN_WEIGHTS; ++i)
        if (weights[i] > 0) sum += weights[i] * row[2 * x - 2 + i];
    return sum;
}

/* Texels begin..end - 1 of a narrower row, away from its ends; at most CHUNK of them. */
static void narrow_middle(const ty_screen_taps* taps, const float* row, int32_t begin, int32_t end, float* out) {
    float even[CHUNK + 2], odd[CHUNK + 2]; /* from one texel before on */
    const int32_t count = end - begin;
    const float* from = row + 2 * (begin - 1);
#pragma omp simd
    for (int32_t i = 0; i < count + 2; ++i) {
        even[i] = from[2 * i];
        odd[i] = from[2 * i + 1];
    }
    const float inner = taps->down[0], outer = taps->down[1], outmost = taps->down[2];
    if (taps->reach <= 2) {
#pragma omp simd
        for (int32_t i = 0; i < count; ++i)
            out[begin + i] = inner * (even[i + 1] + odd[i + 1]) + outer * (odd[i] + even[i + 2]);
    } else {
#pragma omp simd
        for (int32_t i = 0; i < count; ++i)
            out[begin + i] =
                inner * (even[i + 1] + odd[i + 1]) + outer * (odd[i] + even[i + 2]) + outmost * (even[i] + odd[i + 2]);
    }
}

static void narrow(const ty_screen_taps* taps, const float* row, int32_t width, const float* edges, float* out) {
    const int32_t half = (width + 1) / 2, begin = ty_screen_edge_begin(half), end = ty_screen_edge_end(half);
    for (int32_t x = begin; x < end; x += CHUNK) narrow_middle(taps, row, x, least(x + CHUNK, end), out);
    const float* weights = edges;
    for (int32_t x = 0; x < half; x = x + 1 == begin ? end : x + 1) {
        out[x] = edges != NULL ? narrow_edge(weights, row, x) : narrow_item(taps, row, width, x);
        weights = edges != NULL ? weights + TY_SCREEN_DOWN_WEIGHTS : NULL;
    }
}

static void join(const float weights[TY_SCREEN_DOWN_WEIGHTS], const float* const rows[TY_SCREEN_DOWN_WEIGHTS],
                 int32_t width, float* out) {
    const float *a = rows[1], *b = rows[2], *c = rows[3], *d = rows[4];
    const float of_a = weights[1], of_b = weights[2], of_c = weights[3], of_d = weights[4];
    if (weights[0] <= 0 && weights[5] <= 0) {
#pragma omp simd
        for (int32_t i = 0; i < width; ++i) out[i] = of_a * a[i] + of_b * b[i] + (of_c * c[i] + of_d * d[i]);
        return;
    }
    const float *first = rows[0], *last = rows[5];
    const float of_first = weights[0], of_last = weights[5];
#pragma omp simd
    for (int32_t i = 0; i < width; ++i)
        out[i] = of_a * a[i] + of_b * b[i] + (of_c * c[i] + of_d * d[i]) + (of_first * first[i] + of_last * last[i]);
}

/* The rows of the next level that row y lies between, mixed: `width` texels. */
static void mix_rows(const ty_screen_taps* taps, const ty_screen_level* next, int32_t channel, int32_t y, float* out) {
    const int32_t middle = y / 2, towards = (y & 1) != 0 ? 1 : -1, last = next->height - 1;
    const float* a = next->plane[channel] + middle * next->stride;
    const float* b = next->plane[channel] + most(least(middle + towards, last), 0) * next->stride;
    const float* c = next->plane[channel] + most(least(middle - towards, last), 0) * next->stride;
    const float near = taps->up[0], far = taps->up[1], behind = taps->up[2];
    if (taps->reach_up <= 2) {
#pragma omp simd
        for (int32_t i = 0; i < next->width; ++i) out[i] = near * a[i] + far * b[i];
    } else {
#pragma omp simd
        for (int32_t i = 0; i < next->width; ++i) out[i] = near * a[i] + far * b[i] + behind * c[i];
    }
}

static float up_item(const ty_screen_taps* taps, const float* row, int32_t width, int32_t x) {
    const int32_t middle = x / 2, towards = (x & 1) != 0 ? 1 : -1;
    return taps->up[0] * row[middle] + taps->up[1] * row[most(least(middle + towards, width - 1), 0)] +
           taps->up[2] * row[most(least(middle - towards, width - 1), 0)];
}

/* Adds to a row of `width` pixels what the mixed row of the next level holds for them. */
static void add_up(const ty_screen_taps* taps, const float* row, int32_t next_width, int32_t width, float* out,
                   ptrdiff_t step) {
    const int32_t begin = least(1, next_width), end = most(least(next_width - 1, width / 2), begin);
    for (int32_t x = 0; x < least(2 * begin, width); ++x) out[x * step] += up_item(taps, row, next_width, x);
    const float near = taps->up[0], far = taps->up[1], behind = taps->up[2];
    if (step == 1) {
#pragma omp simd
        for (int32_t i = begin; i < end; ++i) {
            const float here = near * row[i];
            out[2 * i] += here + far * row[i - 1] + behind * row[i + 1];
            out[2 * i + 1] += here + far * row[i + 1] + behind * row[i - 1];
        }
    } else {
        for (int32_t i = begin; i < end; ++i) {
            const float here = near * row[i];
            out[2 * i * step] += here + far * row[i - 1] + behind * row[i + 1];
            out[(2 * i + 1) * step] += here + far * row[i + 1] + behind * row[i - 1];
        }
    }
    for (int32_t x = 2 * end; x < width; ++x) out[x * step] += up_item(taps, row, next_width, x);
}

static void up(const ty_screen_taps* taps, const ty_screen_level* level, const ty_screen_level* next, int32_t y,
               float* scratch) {
    for (int channel = 0; channel < 3; ++channel) {
        const ty_screen_share share = level->share[channel];
        float* light = level->plane[channel] + y * level->stride;
        const float* moment = level->plane[3 + channel] + y * level->stride;
#pragma omp simd
        for (int32_t i = 0; i < level->width; ++i) {
            light[i] -= ty_screen_onward(share, ty_screen_mean_measure(light[i], moment[i])) * light[i];
        }
        mix_rows(taps, next, channel, y, scratch);
        add_up(taps, scratch, next->width, level->width, light, 1);
    }
}

static void add(const ty_screen_taps* taps, const ty_screen_level* first, int32_t channel, int32_t y, int32_t width,
                float* out, ptrdiff_t step, float* scratch) {
    mix_rows(taps, first, channel, y, scratch);
    add_up(taps, scratch, first->width, width, out, step);
}

/* ---- the paper's pyramid ---- */

static void gather_split(const ty_screen_params* params, const ty_screen_gather_params* gather,
                         const ty_screen_row* row, const float limit[3], float* const out[3], ptrdiff_t out_step,
                         float* texels, float* spread, ty_screen_counts* counts) {
    chunk c;
    const float slope = params->mean_slope, bend = params->mean_bend, farthest = gather->farthest;
    for (int32_t x0 = 0; x0 < params->width; x0 += CHUNK) {
        const int32_t count = least(CHUNK, params->width - x0);
        split_chunk(params, row, x0, count, limit, &c, counts);
        for (int channel = 0; channel < 3; ++channel)
            store(c.attenuated[channel], count, out[channel] + x0 * out_step, out_step);
        float *texel = texels + 4 * x0, *w = spread + x0;
#pragma omp simd
        for (int32_t i = 0; i < count; ++i) w[i] = sqrtf(ty_screen_variance(slope, bend, c.distance[i]));
        for (int32_t i = 0; i < count; ++i) {
            texel[4 * i] = c.scattered[0][i];
            texel[4 * i + 1] = c.scattered[1][i];
            texel[4 * i + 2] = c.scattered[2][i];
            texel[4 * i + 3] = ty_minf(c.distance[i], farthest);
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
        const float open = ty_screen_mask_at(mask, spread[i]);
        weight[i] = luminance ? ty_screen_luminance(r[i], g[i], b[i]) : 1.0f;
        weighted[i] = weight[i] * spread[i];
        m[i] = open;
        r[i] *= open;
        g[i] *= open;
        b[i] *= open;
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
    const float slope = params->mean_slope, bend = params->mean_bend, scale = gather->level_scale;
    const float top = (float)(gather->level_count - 1);
    const float* row = levels[0].texels + (ptrdiff_t)y * 4 * levels[0].width;
    float distance[CHUNK], level[CHUNK], light[4];
    for (int32_t x0 = 0; x0 < params->width; x0 += CHUNK) {
        const int32_t count = least(CHUNK, params->width - x0);
        for (int32_t i = 0; i < count; ++i) distance[i] = row[4 * (x0 + i) + 3];
        for (int pass = 0; pass < (gather->blurred_distance ? 2 : 1); ++pass) {
            for (int32_t i = 0; pass == 1 && i < count; ++i) {
                ty_screen_fetch(levels, gather->level_count, level[i], x0 + i, y, light);
                distance[i] = light[3];
            }
#pragma omp simd
            for (int32_t i = 0; i < count; ++i)
                level[i] = ty_screen_level_of(ty_screen_variance(slope, bend, distance[i]), scale, top);
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
            sharpness[x] = 0.5f / ty_maxf(sharpness[x], TY_SCREEN_LEAST_VARIANCE);
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
            const int32_t begin = most(source_x - sources->before - x, 0);
            const int32_t end = least(source_x + sources->after + 1 - x, count);
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
    const int32_t above = least(after, y), below = least(before, sources->height - 1 - y);
    for (int32_t i = 0; i < count; ++i) {
        const int32_t left = least(after, x + i), right = least(before, sources->width - 1 - x - i);
        const float whole = ty_screen_gaussian_sum(sharpness[i], before, after);
        coverage[i] = ty_screen_gaussian_sum(sharpness[i], left, right) *
                      ty_screen_gaussian_sum(sharpness[i], above, below) / (whole * whole);
    }
}

const ty_screen_kernels TY_JOIN(ty_screen_kernels_, TY_ISA) = {
    .split = split,
    .scatter = scatter,
    .onward = onward,
    .narrow = narrow,
    .join = join,
    .up = up,
    .add = add,
    .gather_split = gather_split,
    .gather_rows = gather_rows,
    .gather_store = gather_store,
    .gather_add = gather_add,
    .reference_prepare = reference_prepare,
    .reference_add = reference_add,
    .reference_coverage = reference_coverage,
};
