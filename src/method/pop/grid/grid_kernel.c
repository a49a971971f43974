/* Loops over columns and cells of ordinates' grids; compiled once per instruction set, named by TY_ISA. */
#include "method/pop/grid/grid_kernel.h"

#include "direct/uncollided/first_collision_source.h"
#include "method/pop/grid/lobe.k.h"

/* ---- medium along columns ---- */

/* Trilinear cells around a point of each column: the lowest cell, offsets to the next ones, and fractions. */
typedef struct corners {
    int32_t base[TY_POP_BLOCK], next[3][TY_POP_BLOCK];
    float fraction[3][TY_POP_BLOCK];
} corners;

static void clip_lengths(ty_pop_slab* slab, float center[TY_POP_BLOCK]) {
    const float *enter = slab->columns->enter, *leave = slab->columns->leave;
    const float near = slab->ends[0], far = slab->ends[1];
    float* length = slab->length;
#pragma omp simd
    for (int32_t i = 0; i < slab->columns->count; ++i) {
        const float from = ty_clampf(enter[i], near, far), to = ty_clampf(leave[i], near, far);
        length[i] = ty_maxf(0.0f, to - from);
        center[i] = 0.5f * (from + to);
    }
}

static void find_corners(const ty_pop_slab* slab, const float center[TY_POP_BLOCK], corners* at) {
    int32_t stride = 1;
    for (int32_t a = 0; a < 3; ++a) {
        const int32_t last = slab->medium->box.size[a] - 1, step = stride;
        const float per_metre = slab->per_metre[a];
        const float *base = slab->columns->base[a], *direction = slab->columns->direction[a];
#pragma omp simd
        for (int32_t i = 0; i < slab->columns->count; ++i) {
            const float from = ty_clampf((base[i] + direction[i] * center[i]) * per_metre - 0.5f, 0.0f, (float)last);
            const int32_t cell = (int32_t)from;
            at->fraction[a][i] = from - (float)cell;
            at->base[i] = (a == 0 ? 0 : at->base[i]) + step * cell;
            at->next[a][i] = cell < last ? step : 0;
        }
        stride *= slab->medium->box.size[a];
    }
}

/* Trilinear coefficients; g is weighted by the scattering coefficient. */
static void interpolate_coefficients(ty_pop_slab* slab, int32_t plane, const corners* at) {
    const float *extinction = slab->medium->extinction[plane], *scattering = slab->medium->scattering[plane];
    const float *g = slab->medium->g[plane], usual = slab->default_g[plane];
#pragma omp simd
    for (int32_t i = 0; i < slab->columns->count; ++i) {
        float sigma_t = 0.0f, sigma_s = 1e-12f, sigma_s_g = 1e-12f * usual;
        for (int32_t corner = 0; corner < 8; ++corner) {
            const float x = at->fraction[0][i], y = at->fraction[1][i], z = at->fraction[2][i];
            const float weight = ((corner & 1) != 0 ? x : 1.0f - x) * ((corner & 2) != 0 ? y : 1.0f - y) *
                                 ((corner & 4) != 0 ? z : 1.0f - z);
            const int32_t cell = at->base[i] + ((corner & 1) != 0 ? at->next[0][i] : 0) +
                                 ((corner & 2) != 0 ? at->next[1][i] : 0) + ((corner & 4) != 0 ? at->next[2][i] : 0);
            sigma_t += weight * extinction[cell];
            sigma_s += weight * scattering[cell];
            sigma_s_g += weight * scattering[cell] * g[cell];
        }
        slab->extinction[plane][i] = sigma_t;
        slab->scattering[plane][i] = ty_minf(sigma_s, sigma_t);
        slab->g[plane][i] = sigma_s_g / sigma_s;
    }
}

/* Trilinear density of a medium whose coefficients are all proportional to one plane, with uniform g. */
static void interpolate_density(const ty_pop_slab* slab, const corners* at, float density[TY_POP_BLOCK]) {
    const float* plane = slab->medium->extinction[0];
#pragma omp simd
    for (int32_t i = 0; i < slab->columns->count; ++i) {
        float sum = 0.0f;
        for (int32_t corner = 0; corner < 8; ++corner) {
            const float x = at->fraction[0][i], y = at->fraction[1][i], z = at->fraction[2][i];
            const float weight = ((corner & 1) != 0 ? x : 1.0f - x) * ((corner & 2) != 0 ? y : 1.0f - y) *
                                 ((corner & 4) != 0 ? z : 1.0f - z);
            sum += weight * plane[at->base[i] + ((corner & 1) != 0 ? at->next[0][i] : 0) +
                                  ((corner & 2) != 0 ? at->next[1][i] : 0) + ((corner & 4) != 0 ? at->next[2][i] : 0)];
        }
        density[i] = sum;
    }
}

static void multiply_density(ty_pop_slab* slab, int32_t plane, const float density[TY_POP_BLOCK]) {
    const float sigma_t = slab->multiple[0][plane], sigma_s = slab->multiple[1][plane],
                uniform = slab->default_g[plane];
    float *extinction = slab->extinction[plane], *scattering = slab->scattering[plane], *g = slab->g[plane];
#pragma omp simd
    for (int32_t i = 0; i < slab->columns->count; ++i) {
        extinction[i] = sigma_t * density[i];
        scattering[i] = sigma_s * density[i];
        g[i] = uniform;
    }
}

static void sample(ty_pop_slab* slab) {
    float center[TY_POP_BLOCK], density[TY_POP_BLOCK];
    corners at;
    clip_lengths(slab, center);
    find_corners(slab, center, &at);
    if (slab->proportional != 0) interpolate_density(slab, &at, density);
    for (int32_t p = 0; p < slab->medium->planes; ++p)
        if (slab->proportional != 0)
            multiply_density(slab, p, density);
        else
            interpolate_coefficients(slab, p, &at);
}

/* A sum instead of an early exit, so that the loop vectorises. */
static float proportionality_error(const float* plane, const float* other, float multiple, float allowed,
                                   int32_t cells) {
    float sum = 0.0f;
#pragma omp simd reduction(+ : sum)
    for (int32_t i = 0; i < cells; ++i) sum += ty_maxf(0.0f, fabsf(plane[i] - multiple * other[i]) - allowed);
    return sum;
}

static float g_variation(const float* g, const float* scattering, float value, float allowed, int32_t cells) {
    float sum = 0.0f;
#pragma omp simd reduction(+ : sum)
    for (int32_t i = 0; i < cells; ++i)
        sum += scattering[i] > 0.0f ? ty_maxf(0.0f, fabsf(g[i] - value) - allowed) : 0.0f;
    return sum;
}

/* ---- incident light ---- */

/* Fraction of a slab in front of a surface. */
TY_FN float unoccluded_fraction(float hit, float start, float per_length) {
    return ty_clampf((hit - start) * per_length, 0.0f, 1.0f);
}

static void shade(ty_pop_slab* slab) {
    const float start = slab->ends[0], per_length = 1.0f / ty_maxf(slab->ends[1] - start, 1e-30f);
    for (int32_t ray = 0; ray < TY_POP_RAYS; ++ray) {
        const float* hit = slab->columns->hit[ray];
#pragma omp simd
        for (int32_t i = 0; i < slab->columns->count; ++i)
            slab->incident[i] = (ray == 0 ? 0.0f : slab->incident[i]) +
                                unoccluded_fraction(hit[i], start, per_length) * (1.0f / (float)TY_POP_RAYS);
    }
}

static void divide_by_distance2(ty_pop_slab* slab) {
    const ty_pop_columns* c = slab->columns;
    const float x = c->light_position[0], y = c->light_position[1], z = c->light_position[2], center = slab->center;
#pragma omp simd
    for (int32_t i = 0; i < c->count; ++i) {
        const ty_vec off = ty_vec_make(c->base[0][i] + c->direction[0][i] * center - x,
                                       c->base[1][i] + c->direction[1][i] * center - y,
                                       c->base[2][i] + c->direction[2][i] * center - z);
        slab->incident[i] /= ty_maxf(ty_dot(off, off), 1e-30f);
    }
}

static void incident_light(ty_pop_slab* slab) {
    const int32_t count = slab->columns->count;
    if (slab->columns->shaded != 0) shade(slab);
    for (int32_t i = 0; i < count && slab->columns->shaded == 0; ++i) slab->incident[i] = 1.0f;
#pragma omp simd
    for (int32_t i = 0; i < count; ++i) slab->incident[i] *= slab->columns->profile[i];
    if (slab->columns->inverse_square != 0) divide_by_distance2(slab);
}

/* ---- attenuation ---- */

/* Scaled extinction sigma_t - g^order sigma_s; for order 0 it is sigma_t. */
static void scaled_extinction(const ty_pop_slab* slab, int32_t plane, int32_t order, float sigma[TY_POP_BLOCK]) {
    const float *g = slab->g[plane], *extinction = slab->extinction[plane], *scattering = slab->scattering[plane];
    const float linear = order == 1 ? 1.0f : 0.0f, square = order == 2 ? 1.0f : 0.0f;
#pragma omp simd
    for (int32_t i = 0; i < slab->columns->count; ++i) {
        const float forward = ty_maxf(0.0f, g[i]);
        sigma[i] = ty_maxf(0.0f, extinction[i] - forward * (linear + square * forward) * scattering[i]);
    }
}

static void attenuate_order(const ty_pop_slab* slab, const float sigma[TY_POP_BLOCK], float* along, float* mean) {
    const float *length = slab->length, *incident = slab->incident;
#pragma omp simd
    for (int32_t i = 0; i < slab->columns->count; ++i) {
        const float depth = sigma[i] * length[i], transmittance = ty_attenuation(depth), incoming = along[i];
        mean[i] = incoming * ty_mean_attenuation(depth, transmittance) * incident[i];
        along[i] = incoming * transmittance;
    }
}

static void attenuate(const ty_pop_slab* slab, ty_pop_transmittance* t) {
    float sigma[TY_POP_BLOCK];
    for (int32_t p = 0; p < slab->medium->planes; ++p)
        for (int32_t order = 0; order < t->orders; ++order) {
            scaled_extinction(slab, p, order, sigma);
            attenuate_order(slab, sigma, t->along[p][order], t->mean[p][order]);
        }
}

static float diffuse_power(const ty_pop_slab* slab, int32_t plane, const float* fluence) {
    const float *scattering = slab->scattering[plane], *g = slab->g[plane];
    const float *length = slab->length, *across = slab->columns->across;
    float sum = 0.0f;
#pragma omp simd reduction(+ : sum)
    for (int32_t i = 0; i < slab->columns->count; ++i)
        sum += ty_reduced_scattering(scattering[i], g[i]) * fluence[i] * (length[i] * across[i]);
    return sum;
}

/* ---- radiance towards the eye ---- */

static void eye_cosines(const ty_pop_slab* slab, ty_pop_eye_view* l) {
    const ty_pop_columns* c = slab->columns;
    const float x = l->eye[0], y = l->eye[1], z = l->eye[2], center = slab->center;
#pragma omp simd
    for (int32_t i = 0; i < c->count; ++i) {
        const ty_vec direction = ty_vec_make(c->direction[0][i], c->direction[1][i], c->direction[2][i]);
        const ty_vec to =
            ty_vec_make(x - c->base[0][i] - direction.x * center, y - c->base[1][i] - direction.y * center,
                        z - c->base[2][i] - direction.z * center);
        l->mu[i] = ty_clampf(ty_dot(direction, to) / sqrtf(ty_maxf(ty_dot(to, to), 1e-30f)), -1.0f, 1.0f);
    }
}

/* Single-scattering lobes and their means under the disc's tent. */
typedef struct lobes {
    float lobe[TY_POP_BLOCK], mean[TY_POP_BLOCK];
} lobes;

static void find_lobes(const ty_pop_slab* slab, int32_t plane, const ty_pop_eye_view* view, lobes* out) {
    const float *g = slab->g[plane], width = view->width, cosine = view->cosine;
    const int32_t count = slab->columns->count;
    float *lobe = out->lobe, *mean = out->mean;
    if (slab->proportional != 0) {
        const float uniform = ty_pop_disc_lobe(fabsf(slab->default_g[plane]), cosine, width);
        const float center = ty_pop_disc_mean(uniform, width);
        for (int32_t i = 0; i < count; ++i) lobe[i] = uniform;
        for (int32_t i = 0; i < count; ++i) mean[i] = center;
        return;
    }
#pragma omp simd
    for (int32_t i = 0; i < count; ++i) {
        lobe[i] = ty_pop_disc_lobe(fabsf(g[i]), cosine, width);
        mean[i] = ty_pop_disc_mean(lobe[i], width);
    }
}

/* True if any column is viewed within the disc's tent. */
static bool is_near(const ty_pop_slab* slab, const ty_pop_eye_view* view) {
    const float *mu = view->mu, width = view->width;
    float max_weight = 0.0f;
#pragma omp simd reduction(max : max_weight)
    for (int32_t i = 0; i < slab->columns->count; ++i) {
        const float fraction = ty_pop_disc_tent_weight(fabsf(mu[i]), width); /* both signs, since g may have either */
        max_weight = max_weight > fraction ? max_weight : fraction;
    }
    return max_weight > 0.0f;
}

static void scatter_plane(const ty_pop_slab* slab, int32_t plane, const lobes* l, bool near, ty_pop_eye_view* view) {
    const float *u = view->mean[plane][0], *r = view->mean[plane][1], *s = view->mean[plane][2], *g = slab->g[plane];
    const float *lobe = l->lobe, *mean = l->mean, *mu = view->mu, width = view->width, cosine = view->cosine;
    float* radiance = view->radiance[plane];
    if (near) {
#pragma omp simd
        for (int32_t i = 0; i < slab->columns->count; ++i)
            radiance[i] = u[i] * ty_pop_disc_single(mu[i], g[i], width, lobe[i], mean[i]) +
                          ty_pop_disc_forward(mu[i], u[i], r[i], s[i], g[i], cosine, width, lobe[i]);
        return;
    }
#pragma omp simd
    for (int32_t i = 0; i < slab->columns->count; ++i)
        radiance[i] = u[i] * ty_pop_disc_single_far(mu[i], g[i], lobe[i]) +
                      ty_pop_disc_forward_far(mu[i], u[i], r[i], s[i], g[i], cosine, width, lobe[i]);
}

static void scatter(const ty_pop_slab* slab, ty_pop_eye_view* view) {
    const bool near = is_near(slab, view);
    lobes l;
    for (int32_t p = 0; p < slab->medium->planes; ++p) {
        find_lobes(slab, p, view, &l);
        scatter_plane(slab, p, &l, near, view);
    }
}

const ty_pop_grid_kernels TY_KERNEL_NAME(ty_pop_grid_kernels) = {.proportionality_error = proportionality_error,
                                                                 .g_variation = g_variation,
                                                                 .sample = sample,
                                                                 .incident_light = incident_light,
                                                                 .attenuate = attenuate,
                                                                 .diffuse_power = diffuse_power,
                                                                 .eye_cosines = eye_cosines,
                                                                 .scatter = scatter};
