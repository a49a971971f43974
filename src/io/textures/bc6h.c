/* The encoder of BC6H. Texels are taken as the integers that indices interpolate between, which are nearly logarithms
 * of the values: an error there is a relative error of the light. Each subset gets the line along the largest variance
 * of its texels; indices and endpoints are then fitted in turns by least squares, in the most precise mode that holds
 * the endpoints' differences. */
#include "io/textures/bc6h.h"

#include <float.h>
#include <math.h>
#include <string.h>

enum { TEXELS = 16, ROUNDS = 3, CANDIDATES = 4, POWER_STEPS = 6 };

typedef struct block {
    float texels[TEXELS][3];
    bool with_sign;
} block;

/* A fit of a block in one mode. */
typedef struct trial {
    int32_t mode, partition; /* partition: 0 for one subset */
    int32_t ends[4][3];      /* as they are before the transform */
    int32_t index[TEXELS];
    float error; /* sum of squares */
} trial;

/* ---- Values ---- */

/* The middle of the values that end as this half: the format's last step multiplies by 31/64, with signs by 31/32. */
static float widen(uint16_t half, bool with_sign) {
    const int32_t magnitude = half & 0x7fff;
    const int32_t bounded = magnitude < 0x7bff ? magnitude : 0x7bff;
    if (!with_sign) return half & 0x8000 ? 0 : fminf(((float)bounded + 0.5f) * (64.0f / 31.0f), 65535.0f);
    const float wide = fminf(((float)bounded + 0.5f) * (32.0f / 31.0f), 32767.0f);
    return bounded == 0 ? 0 : half & 0x8000 ? -wide : wide;
}

static int32_t quantize(float value, int32_t bits, bool with_sign) {
    const int32_t largest = with_sign ? (1 << (bits - 1)) - 1 : (1 << bits) - 1;
    const float scale = (float)largest + 1.0f, range = with_sign ? 32768.0f : 65536.0f;
    const int32_t steps = (int32_t)(fabsf(value) * (scale / range));
    const int32_t bounded = steps < largest ? steps : largest;
    return value >= 0 ? bounded : with_sign ? -bounded : 0;
}

/* ---- Lines ---- */

/* Mean, largest principal axis and the variance that it leaves, of the texels of a mask. */
static float find_axis(const block* b, uint32_t mask, float mean[3], float axis[3]) {
    float sum[3] = {0}, cov[6] = {0};
    float count = 0;
    for (int i = 0; i < TEXELS; ++i) {
        if (!(mask >> i & 1)) continue;
        for (int c = 0; c < 3; ++c) sum[c] += b->texels[i][c];
        ++count;
    }
    for (int c = 0; c < 3; ++c) mean[c] = sum[c] / count;
    for (int i = 0; i < TEXELS; ++i) {
        if (!(mask >> i & 1)) continue;
        const float x = b->texels[i][0] - mean[0], y = b->texels[i][1] - mean[1], z = b->texels[i][2] - mean[2];
        cov[0] += x * x;
        cov[1] += y * y;
        cov[2] += z * z;
        cov[3] += x * y;
        cov[4] += x * z;
        cov[5] += y * z;
    }
    /* Power iteration from the row of the largest diagonal element. */
    const int largest = cov[0] >= cov[1] && cov[0] >= cov[2] ? 0 : cov[1] >= cov[2] ? 1 : 2;
    float v[3] = {largest == 0   ? cov[0]
                  : largest == 1 ? cov[3]
                                 : cov[4],
                  largest == 0   ? cov[3]
                  : largest == 1 ? cov[1]
                                 : cov[5],
                  largest == 0   ? cov[4]
                  : largest == 1 ? cov[5]
                                 : cov[2]};
    float eigenvalue = 0;
    for (int step = 0; step < POWER_STEPS; ++step) {
        const float length = sqrtf(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
        if (!(length > 0)) break;
        for (int c = 0; c < 3; ++c) axis[c] = v[c] / length;
        v[0] = cov[0] * axis[0] + cov[3] * axis[1] + cov[4] * axis[2];
        v[1] = cov[3] * axis[0] + cov[1] * axis[1] + cov[5] * axis[2];
        v[2] = cov[4] * axis[0] + cov[5] * axis[1] + cov[2] * axis[2];
        eigenvalue = v[0] * axis[0] + v[1] * axis[1] + v[2] * axis[2];
    }
    return fmaxf(cov[0] + cov[1] + cov[2] - eigenvalue, 0);
}

/* The ends of the texels along their axis. */
static void find_ends(const block* b, uint32_t mask, float ends[2][3]) {
    float mean[3], axis[3] = {0}, low = FLT_MAX, high = -FLT_MAX;
    find_axis(b, mask, mean, axis);
    for (int i = 0; i < TEXELS; ++i) {
        if (!(mask >> i & 1)) continue;
        float along = 0;
        for (int c = 0; c < 3; ++c) along += (b->texels[i][c] - mean[c]) * axis[c];
        low = fminf(low, along);
        high = fmaxf(high, along);
    }
    const float bound = b->with_sign ? -32767.0f : 0, top = b->with_sign ? 32767.0f : 65535.0f;
    for (int c = 0; c < 3; ++c) {
        ends[0][c] = fminf(fmaxf(mean[c] + low * axis[c], bound), top);
        ends[1][c] = fminf(fmaxf(mean[c] + high * axis[c], bound), top);
    }
}

/* least squares of the ends, given the indices. False: all indices are alike. */
static bool refine_ends(const block* b, uint32_t mask, const int32_t* index, const int32_t* weights, float ends[2][3]) {
    float aa = 0, ab = 0, bb = 0, at[3] = {0}, bt[3] = {0};
    for (int i = 0; i < TEXELS; ++i) {
        if (!(mask >> i & 1)) continue;
        const float w = (float)weights[index[i]] / 64.0f, v = 1.0f - w;
        aa += v * v;
        ab += v * w;
        bb += w * w;
        for (int c = 0; c < 3; ++c) {
            at[c] += v * b->texels[i][c];
            bt[c] += w * b->texels[i][c];
        }
    }
    const float determinant = aa * bb - ab * ab;
    if (!(determinant > 1e-4f)) return false;
    const float bound = b->with_sign ? -32767.0f : 0, top = b->with_sign ? 32767.0f : 65535.0f;
    for (int c = 0; c < 3; ++c) {
        ends[0][c] = fminf(fmaxf((bb * at[c] - ab * bt[c]) / determinant, bound), top);
        ends[1][c] = fminf(fmaxf((aa * bt[c] - ab * at[c]) / determinant, bound), top);
    }
    return true;
}

/* ---- Trials ---- */

/* Orders the ends so that the anchor, whose index lacks its highest bit, is nearer to the first. */
static void orient(const block* b, int anchor, float ends[2][3]) {
    float along = 0, length = 0;
    for (int c = 0; c < 3; ++c) {
        const float d = ends[1][c] - ends[0][c];
        along += (b->texels[anchor][c] - ends[0][c]) * d;
        length += d * d;
    }
    if (2 * along <= length) return;
    for (int c = 0; c < 3; ++c) {
        const float swapped = ends[0][c];
        ends[0][c] = ends[1][c];
        ends[1][c] = swapped;
    }
}

/* Quantizes the ends. False: a mode's differences cannot hold them. */
static bool quantize_ends(const ty_bc6h_mode* mode, bool with_sign, float ends[4][3], int32_t out[4][3]) {
    for (int e = 0; e < 2 * mode->subsets; ++e)
        for (int c = 0; c < 3; ++c) {
            out[e][c] = quantize(ends[e][c], mode->bits, with_sign);
            const int32_t limit = 1 << (mode->delta[c] - 1), difference = out[e][c] - out[0][c];
            if (mode->transformed && e > 0 && (difference < -limit || difference >= limit)) return false;
        }
    return true;
}

/* The nearest indices of a subset's texels; adds their errors. */
static void choose_indices(const block* b, uint32_t mask, int anchor, const int32_t first[3], const int32_t second[3],
                           const ty_bc6h_mode* mode, trial* t) {
    const int32_t* weights = ty_bc6h_weights[mode->subsets - 1];
    const int32_t count = mode->subsets == 1 ? 16 : 8;
    float palette[16][3];
    for (int c = 0; c < 3; ++c) {
        const int32_t low = ty_bc6h_unquantize(first[c], mode->bits, b->with_sign);
        const int32_t high = ty_bc6h_unquantize(second[c], mode->bits, b->with_sign);
        for (int32_t k = 0; k < count; ++k)
            palette[k][c] = (float)((low * (64 - weights[k]) + high * weights[k] + 32) >> 6);
    }
    for (int i = 0; i < TEXELS; ++i) {
        if (!(mask >> i & 1)) continue;
        float smallest = FLT_MAX;
        for (int32_t k = 0; k < (i == anchor ? count / 2 : count); ++k) {
            const float x = b->texels[i][0] - palette[k][0], y = b->texels[i][1] - palette[k][1],
                        z = b->texels[i][2] - palette[k][2];
            const float error = x * x + y * y + z * z;
            if (error < smallest) {
                smallest = error;
                t->index[i] = k;
            }
        }
        t->error += smallest;
    }
}

/* Fits a block in the first of the modes [begin, end) that holds it, and keeps the fit in *best if it is better. */
static void fit(const block* b, const ty_bc6h_request* request, int32_t begin, int32_t end, int32_t partition,
                trial* best) {
    const int32_t subsets = request->tables->modes[begin].subsets;
    const uint32_t second = subsets == 2 ? ty_bc6h_partitions[partition] : 0;
    const uint32_t masks[2] = {0xffff & ~second, second};
    const int anchors[2] = {0, ty_bc6h_anchors[partition]};
    float ends[4][3];
    for (int s = 0; s < subsets; ++s) find_ends(b, masks[s], &ends[2 * s]);
    for (int round = 0; round < ROUNDS; ++round) {
        trial t = {.partition = partition, .mode = -1};
        for (int s = 0; s < subsets; ++s) orient(b, anchors[s], &ends[2 * s]);
        for (int32_t m = begin; m < end && t.mode < 0; ++m)
            if (request->modes >> m & 1 && quantize_ends(&request->tables->modes[m], b->with_sign, ends, t.ends))
                t.mode = m;
        if (t.mode < 0) return;
        const ty_bc6h_mode* mode = &request->tables->modes[t.mode];
        for (int s = 0; s < subsets; ++s)
            choose_indices(b, masks[s], anchors[s], t.ends[2 * s], t.ends[2 * s + 1], mode, &t);
        if (t.error < best->error) *best = t;
        for (int s = 0; s < subsets; ++s) refine_ends(b, masks[s], t.index, ty_bc6h_weights[subsets - 1], &ends[2 * s]);
    }
}

/* The partitions that leave the smallest variance beside their lines. */
static void find_partitions(const block* b, int32_t out[CANDIDATES]) {
    float smallest[CANDIDATES];
    for (int k = 0; k < CANDIDATES; ++k) smallest[k] = FLT_MAX;
    for (int32_t p = 0; p < TY_BC6H_PARTITIONS; ++p) {
        float mean[3], axis[3];
        const uint32_t second = ty_bc6h_partitions[p];
        float rest = find_axis(b, 0xffff & ~second, mean, axis) + find_axis(b, second, mean, axis);
        int32_t moved = p;
        for (int k = 0; k < CANDIDATES; ++k)
            if (rest < smallest[k]) {
                const float value = smallest[k];
                const int32_t index = out[k];
                smallest[k] = rest;
                out[k] = moved;
                rest = value;
                moved = index;
            }
    }
}

/* ---- Bits ---- */

typedef struct bits {
    uint8_t* bytes;
    int32_t at;
} bits;

static void put(bits* out, int32_t value, int32_t count) {
    for (int32_t i = 0; i < count; ++i, ++out->at)
        out->bytes[out->at / 8] |= (uint8_t)((value >> i & 1) << (out->at % 8));
}

static void write_block(const ty_bc6h_mode* mode, const trial* t, uint8_t* bytes) {
    bits out = {.bytes = bytes};
    memset(bytes, 0, TY_BC6H_BLOCK_BYTES);
    put(&out, mode->number, mode->number_bits);
    for (int32_t i = 0; i < mode->places; ++i) {
        const int32_t field = mode->place[i] / 16, bit = mode->place[i] % 16, e = field / 3, c = field % 3;
        const int32_t value = mode->transformed && e > 0 ? t->ends[e][c] - t->ends[0][c] : t->ends[e][c];
        put(&out, value >> bit, 1);
    }
    if (mode->subsets == 2) put(&out, t->partition, 5);
    const int32_t width = mode->subsets == 1 ? 4 : 3;
    for (int i = 0; i < TEXELS; ++i) {
        const bool anchor = i == 0 || (mode->subsets == 2 && i == ty_bc6h_anchors[t->partition]);
        put(&out, t->index[i], anchor ? width - 1 : width);
    }
}

/* ---- Blocks ---- */

static void read_block(const ty_bc6h_request* request, int32_t column, int32_t row, block* b) {
    b->with_sign = request->with_sign;
    for (int i = 0; i < TEXELS; ++i) {
        const int32_t x = 4 * column + i % 4, y = 4 * row + i / 4;
        const int32_t inside_x = x < request->width ? x : request->width - 1;
        const int32_t inside_y = y < request->height ? y : request->height - 1;
        const uint16_t* at = request->halves + 3 * ((size_t)inside_y * (size_t)request->width + (size_t)inside_x);
        for (int c = 0; c < 3; ++c) b->texels[i][c] = widen(at[c], b->with_sign);
    }
}

void ty_bc6h_encode_row(const ty_bc6h_request* request, int32_t row) {
    const ty_bc6h_mode* modes = request->tables->modes;
    const int32_t columns = (request->width + 3) / 4;
    int32_t single = 0;
    while (modes[single].subsets == 1) ++single;
    for (int32_t column = 0; column < columns; ++column) {
        block b;
        trial best = {.error = FLT_MAX, .mode = -1};
        read_block(request, column, row, &b);
        fit(&b, request, 0, single, 0, &best);
        /* Errors of half a step of the half floats cannot become smaller. */
        if (best.error > (float)TEXELS * 3 && request->modes >> single != 0) {
            int32_t partitions[CANDIDATES] = {0};
            find_partitions(&b, partitions);
            for (int k = 0; k < CANDIDATES; ++k) fit(&b, request, single, TY_BC6H_MODES, partitions[k], &best);
        }
        uint8_t* out = request->blocks + TY_BC6H_BLOCK_BYTES * ((size_t)row * (size_t)columns + (size_t)column);
        if (best.mode >= 0)
            write_block(&modes[best.mode], &best, out);
        else
            memset(out, 0, TY_BC6H_BLOCK_BYTES); /* no mode that may be used holds it */
    }
}
