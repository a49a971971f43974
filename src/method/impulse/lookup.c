/* Table lookups. */
#include "base/legendre.k.h"
#include "method/impulse/harmonics.h"
#include "method/impulse/lookup.h"
#include "method/impulse/tables.h"

#include <float.h>
#include <string.h>

/* Minimum optical distance of a lookup: the response diverges at 0. */
static const float min_optical_distance = 1e-6f;

const float ty_impulse_cosines[TY_IMPULSE_ANGLES] = {0,     0.02f, 0.05f, 0.09f, 0.14f, 0.2f,  0.27f, 0.35f,
                                                     0.44f, 0.53f, 0.62f, 0.71f, 0.79f, 0.87f, 0.94f, 1};

double ty_impulse_bin_position(const ty_impulse* tables, double distance) {
    const double near = TY_IMPULSE_NEAREST;
    return tables->density * (log(fmax(distance, 1e-300) / near) + TY_IMPULSE_LINEAR_RATE * (distance - near));
}

double ty_impulse_distance(const ty_impulse* tables, double position) {
    const double near = TY_IMPULSE_NEAREST;
    double low = near, high = near + position / (tables->density * TY_IMPULSE_LINEAR_RATE);
    for (int i = 0; i < 200 && low < high; ++i) {
        const double center = 0.5 * (low + high);
        if (center <= low || center >= high) break;
        *(ty_impulse_bin_position(tables, center) < position ? &low : &high) = center;
    }
    return low;
}

double ty_impulse_scale(ty_impulse_emitter emitter, bool single, double distance) {
    if (!single) return exp(0.5 * distance);
    return (emitter == TY_IMPULSE_DIRECTIONAL ? 1 : distance) * exp(distance);
}

/* Interpolation nodes of a lookup: rows of one or two angles, two bins each, with their weights. */
typedef struct lookup_nodes {
    const float* rows[4];
    float weight[4];
    int32_t count;
    float optical; /* optical distance */
} lookup_nodes;

static lookup_nodes find_nodes(const ty_impulse* tables, ty_impulse_emitter emitter, float optical, float cosine) {
    const float near = (float)TY_IMPULSE_NEAREST, last = TY_IMPULSE_DISTANCES - 1;
    lookup_nodes out = {.optical = fmaxf(optical, min_optical_distance)};
    const float length =
        (float)tables->density * (logf(out.optical / near) + (float)TY_IMPULSE_LINEAR_RATE * (out.optical - near));
    const float bin = fminf(last, fmaxf(0, length));
    const int32_t low = bin < last ? (int32_t)bin : TY_IMPULSE_DISTANCES - 2;
    const float fraction = bin - (float)low;
    int32_t left = 0;
    while (left < TY_IMPULSE_ANGLES - 2 && cosine >= ty_impulse_cosines[left + 1]) ++left;
    const float right = (cosine - ty_impulse_cosines[left]) / (ty_impulse_cosines[left + 1] - ty_impulse_cosines[left]);
    const bool area = emitter == TY_IMPULSE_AREA;
    for (int32_t a = 0; a < (area ? 2 : 1); ++a) {
        const float angle_weight = !area ? 1 : a == 0 ? 1 - right : right;
        out.rows[out.count] = ty_impulse_row(tables, emitter, area ? left + a : 0, low);
        out.rows[out.count + 1] = out.rows[out.count] + tables->row;
        out.weight[out.count++] = angle_weight * (1 - fraction);
        out.weight[out.count++] = angle_weight * fraction;
    }
    return out;
}

/* Weighted sums of harmonics; each loop is three or six vector instructions. */
typedef struct harmonics {
    float at[TY_IMPULSE_VECTOR];
} harmonics;

static inline void add(harmonics* out, const float* restrict vector, float weight) {
    for (int32_t l = 0; l < TY_IMPULSE_VECTOR; ++l) out->at[l] += weight * vector[l];
}

/* The first bounce, interpolated between the tables of g = -0.5, 0 and 0.5: Sec. 4.5 (Dubouchet 2019). */
static harmonics lookup_single(const lookup_nodes* p, float g, float factor) {
    const float phase = fminf(1, fmaxf(-1, g / (float)TY_IMPULSE_PHASE_G));
    const int32_t other = phase < 0 ? 0 : 2 * TY_IMPULSE_VECTOR;
    harmonics out = {{0}};
    for (int32_t i = 0; i < p->count; ++i) {
        const float weight = factor * p->weight[i];
        add(&out, p->rows[i] + TY_IMPULSE_VECTOR, weight * (1 - fabsf(phase)));
        if (phase != 0) add(&out, p->rows[i] + other, weight * fabsf(phase));
    }
    return out;
}

static float lookup_axis_tilt(const lookup_nodes* p, float cosine) {
    const float sine = sqrtf(fmaxf(0, 1 - cosine * cosine));
    float shift = 0;
    for (int32_t i = 0; i < p->count; ++i) shift += p->weight[i] * p->rows[i][TY_IMPULSE_SHIFT];
    return sine * shift;
}

/* Sum of bounces 2.., each weighted by one more power of the albedo (Sec. 5.1 (Dubouchet 2019)), and each limited to
 * max_ratio times the previous one, starting from `single_dc` (constant terms). */
static harmonics lookup_multiple(const lookup_nodes* p, float albedo, int32_t bounces, float factor, float single_dc,
                                 float max_ratio) {
    harmonics out = {{0}};
    float scale = factor * albedo, before = single_dc, limit = 1;
    for (int32_t bounce = 2; bounce <= bounces; ++bounce) {
        const int32_t at = (TY_IMPULSE_PHASES + bounce - 2) * TY_IMPULSE_VECTOR;
        harmonics one = {{0}};
        scale *= albedo;
        for (int32_t i = 0; i < p->count; ++i) add(&one, p->rows[i] + at, scale * p->weight[i]);
        if (one.at[0] > max_ratio * before) limit *= max_ratio * before / one.at[0];
        before = one.at[0];
        add(&out, one.at, limit);
    }
    return out;
}

/* Transmittance exp(-optical), divided by the optical distance for emitters at a finite distance. */
static float single_factor(ty_impulse_emitter emitter, float optical) {
    return expf(-optical) / (emitter == TY_IMPULSE_DIRECTIONAL ? 1 : optical);
}

void ty_impulse_look(const ty_impulse* tables, ty_impulse_emitter emitter, const ty_impulse_medium* medium,
                     float distance, float cosine, int32_t bounces, ty_impulse_response* out) {
    ty_impulse_lookup_bounded(tables, emitter, medium, distance, cosine, bounces, FLT_MAX, out);
}

/* Change of medium, Sec. 4.3 (Dubouchet 2019): lookups are at optical distances d_q = sigma_r d, and responses to
 * points and areas are scaled by sigma_r^2. */
void ty_impulse_lookup_bounded(const ty_impulse* tables, ty_impulse_emitter emitter, const ty_impulse_medium* medium,
                               float distance, float cosine, int32_t bounces, float max_ratio,
                               ty_impulse_response* out) {
    *out = (ty_impulse_response){0};
    if (!(medium->sigma_t > 0) || !(medium->sigma_s > 0) || bounces < 1) return;
    const bool near = emitter != TY_IMPULSE_DIRECTIONAL;
    const float albedo = fminf(1, medium->sigma_s / medium->sigma_t), g = fminf(0.99f, fmaxf(-0.99f, medium->g));
    cosine = fminf(1, fmaxf(0, cosine));
    lookup_nodes p = find_nodes(tables, emitter, medium->sigma_t * distance, cosine);
    const float ratio = near ? medium->sigma_t * medium->sigma_t : 1;
    if (emitter == TY_IMPULSE_AREA) out->shift = lookup_axis_tilt(&p, cosine);
    const harmonics single = lookup_single(&p, g, albedo * ratio * single_factor(emitter, p.optical));
    memcpy(out->single, single.at, sizeof out->single);
    if (bounces < 2) return;
    /* Similarity relation: forward scattering is treated as no scattering. */
    const float reduced_scattering = (1 - g) * medium->sigma_s,
                reduced_extinction = medium->sigma_t - medium->sigma_s + reduced_scattering;
    if (g != 0) p = find_nodes(tables, emitter, reduced_extinction * distance, cosine);
    const harmonics multiple = lookup_multiple(
        &p, fminf(1, reduced_scattering / reduced_extinction), bounces < tables->bounces ? bounces : tables->bounces,
        expf(-0.5f * p.optical) * (near ? reduced_extinction * reduced_extinction : 1), out->single[0], max_ratio);
    memcpy(out->multiple, multiple.at, sizeof out->multiple);
}

size_t ty_impulse_merged_rows(void) {
    return TY_IMPULSE_ROWS;
}

/* Response of one bin for the canonical medium with this albedo, in tabulated form: without transmittance and inverse
 * distance. */
static void merge_row(const ty_impulse* tables, int32_t angle, int32_t bin, double distance,
                      const ty_impulse_medium* medium, int32_t bounces, float max_ratio, ty_impulse_sum* out) {
    const ty_impulse_emitter emitter = angle < 2 ? (ty_impulse_emitter)angle : TY_IMPULSE_AREA;
    const float cosine = angle < 2 ? 1 : ty_impulse_cosines[angle - 2];
    ty_impulse_response response;
    ty_impulse_lookup_bounded(tables, emitter, medium, (float)distance, cosine, bounces, max_ratio, &response);
    const float single_scale = (float)ty_impulse_scale(emitter, true, distance),
                multiple_scale = (float)ty_impulse_scale(emitter, false, distance);
    for (int32_t l = 0; l < TY_IMPULSE_TERMS; ++l) {
        out->single[l] = single_scale * response.single[l];
        out->multiple[l] = multiple_scale * response.multiple[l];
    }
    if (angle >= 2) out->single[TY_IMPULSE_SHIFT] = ty_impulse_row(tables, emitter, angle - 2, bin)[TY_IMPULSE_SHIFT];
}

void ty_impulse_merge(const ty_impulse* tables, float albedo, float g, int32_t bounces, float max_ratio,
                      ty_impulse_sum* rows, ty_impulse_merged* out) {
    const ty_impulse_medium medium = {1, albedo, g};
    for (int32_t bin = 0; bin < TY_IMPULSE_DISTANCES; ++bin) {
        const double distance = ty_impulse_distance(tables, bin);
        for (int32_t angle = 0; angle < 2 + TY_IMPULSE_ANGLES; ++angle) {
            ty_impulse_sum* row = &rows[angle * TY_IMPULSE_DISTANCES + bin];
            *row = (ty_impulse_sum){.single = {0}};
            merge_row(tables, angle, bin, distance, &medium, bounces, max_ratio, row);
        }
    }
    *out = (ty_impulse_merged){.rows = rows,
                               .cosines = ty_impulse_cosines,
                               .near = (float)TY_IMPULSE_NEAREST,
                               .density = (float)tables->density,
                               .linear_rate = (float)TY_IMPULSE_LINEAR_RATE};
}

ty_result ty_impulse_bin(const ty_impulse* tables, ty_impulse_emitter emitter, int32_t bounce, int32_t g, int32_t angle,
                         int32_t bin, double* distance, float zonal[TY_IMPULSE_TERMS]) {
    const bool area = emitter == TY_IMPULSE_AREA;
    if (emitter < TY_IMPULSE_POINT || emitter > TY_IMPULSE_AREA || bounce < 1 || bounce > tables->bounces || g < -1 ||
        g > 1 || (g != 0 && bounce > 1) || angle < 0 || angle >= (area ? TY_IMPULSE_ANGLES : 1) || bin < 0 ||
        bin >= TY_IMPULSE_DISTANCES)
        return ty_fail(tables->context, TY_ERROR_ARGUMENT,
                       "ty_impulse_bin: there is no bounce %d with g %d at angle %d in bin %d", bounce, g, angle, bin);
    const float* row = ty_impulse_row(tables, emitter, angle, bin);
    const int32_t vector = bounce == 1 ? 1 + g : TY_IMPULSE_PHASES + bounce - 2;
    *distance = ty_impulse_distance(tables, bin);
    const double scale = ty_impulse_scale(emitter, bounce == 1, *distance);
    for (int32_t l = 0; l < TY_IMPULSE_TERMS; ++l)
        zonal[l] = (float)((double)row[vector * TY_IMPULSE_VECTOR + l] / scale);
    return TY_OK;
}

/* App. A (Dubouchet 2019): sum of sqrt(4 pi / (2 l + 1)) lobe_l zonal_l y_l^0 with y_l^0 = sqrt((2 l + 1) / (4 pi))
 * P_l; only even orders and the first are nonzero. */
float ty_impulse_irradiance(const float zonal[TY_IMPULSE_TERMS], float cosine) {
    float before = 1, last = cosine,
          sum = ty_impulse_cosine_lobe[0] * zonal[0] + ty_impulse_cosine_lobe[1] * zonal[1] * cosine;
    for (int32_t l = 2; l < TY_IMPULSE_TERMS; ++l) {
        const float next = ty_legendre_next(l - 1, cosine, last, before);
        before = last;
        last = next;
        sum += ty_impulse_cosine_lobe[l] * zonal[l] * next;
    }
    return sum;
}
