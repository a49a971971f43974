/* Loops over columns and cells of ordinates' grids; built once per instruction set, with TY_ISA naming it. */
#include "method/pop/grid_kernel.h"

#include "direct/turned.h"
#include "method/pop/lobe.k.h"

#define TY_JOIN_(a, b) a##b
#define TY_JOIN(a, b) TY_JOIN_(a, b)

/* ---- the medium along columns ---- */

/* Eight cells around a point of each column: the lowest, how far it is to the next ones, and shares. */
typedef struct corners {
    int32_t base[TY_POP_BLOCK], next[3][TY_POP_BLOCK];
    float share[3][TY_POP_BLOCK];
} corners;

static void find_lengths(ty_pop_slab* slab, float middle[TY_POP_BLOCK]) {
    const float *enter = slab->columns->enter, *leave = slab->columns->leave;
    const float near = slab->ends[0], far = slab->ends[1];
    float* length = slab->length;
#pragma omp simd
    for (int32_t i = 0; i < slab->columns->count; ++i) {
        const float from = ty_clampf(enter[i], near, far), to = ty_clampf(leave[i], near, far);
        length[i] = ty_maxf(0.0f, to - from);
        middle[i] = 0.5f * (from + to);
    }
}

static void find_corners(const ty_pop_slab* slab, const float middle[TY_POP_BLOCK], corners* at) {
    int32_t stride = 1;
    for (int32_t a = 0; a < 3; ++a) {
        const int32_t last = slab->medium->box.size[a] - 1, step = stride;
        const float per_metre = slab->per_metre[a];
        const float *base = slab->columns->base[a], *way = slab->columns->way[a];
#pragma omp simd
        for (int32_t i = 0; i < slab->columns->count; ++i) {
            const float from = ty_clampf((base[i] + way[i] * middle[i]) * per_metre - 0.5f, 0.0f, (float)last);
            const int32_t cell = (int32_t)from;
            at->share[a][i] = from - (float)cell;
            at->base[i] = (a == 0 ? 0 : at->base[i]) + step * cell;
            at->next[a][i] = cell < last ? step : 0;
        }
        stride *= slab->medium->box.size[a];
    }
}

/* Means between cells; g is weighted by scattering. */
static void find_coefficients(ty_pop_slab* slab, int32_t plane, const corners* at) {
    const float *extinction = slab->medium->extinction[plane], *scattering = slab->medium->scattering[plane];
    const float *g = slab->medium->g[plane], usual = slab->usual_g[plane];
#pragma omp simd
    for (int32_t i = 0; i < slab->columns->count; ++i) {
        float sigma_t = 0.0f, sigma_s = 1e-12f, turned = 1e-12f * usual;
        for (int32_t corner = 0; corner < 8; ++corner) {
            const float x = at->share[0][i], y = at->share[1][i], z = at->share[2][i];
            const float weight = ((corner & 1) != 0 ? x : 1.0f - x) * ((corner & 2) != 0 ? y : 1.0f - y) *
                                 ((corner & 4) != 0 ? z : 1.0f - z);
            const int32_t cell = at->base[i] + ((corner & 1) != 0 ? at->next[0][i] : 0) +
                                 ((corner & 2) != 0 ? at->next[1][i] : 0) + ((corner & 4) != 0 ? at->next[2][i] : 0);
            sigma_t += weight * extinction[cell];
            sigma_s += weight * scattering[cell];
            turned += weight * scattering[cell] * g[cell];
        }
        slab->extinction[plane][i] = sigma_t;
        slab->scattering[plane][i] = ty_minf(sigma_s, sigma_t);
        slab->g[plane][i] = turned / sigma_s;
    }
}

/* The same where all coefficients are multiples of one plane, and g is even. */
static void find_density(const ty_pop_slab* slab, const corners* at, float density[TY_POP_BLOCK]) {
    const float* plane = slab->medium->extinction[0];
#pragma omp simd
    for (int32_t i = 0; i < slab->columns->count; ++i) {
        float sum = 0.0f;
        for (int32_t corner = 0; corner < 8; ++corner) {
            const float x = at->share[0][i], y = at->share[1][i], z = at->share[2][i];
            const float weight = ((corner & 1) != 0 ? x : 1.0f - x) * ((corner & 2) != 0 ? y : 1.0f - y) *
                                 ((corner & 4) != 0 ? z : 1.0f - z);
            sum += weight * plane[at->base[i] + ((corner & 1) != 0 ? at->next[0][i] : 0) +
                                  ((corner & 2) != 0 ? at->next[1][i] : 0) + ((corner & 4) != 0 ? at->next[2][i] : 0)];
        }
        density[i] = sum;
    }
}

static void multiply_density(ty_pop_slab* slab, int32_t plane, const float density[TY_POP_BLOCK]) {
    const float sigma_t = slab->multiple[0][plane], sigma_s = slab->multiple[1][plane], even = slab->usual_g[plane];
    float *extinction = slab->extinction[plane], *scattering = slab->scattering[plane], *g = slab->g[plane];
#pragma omp simd
    for (int32_t i = 0; i < slab->columns->count; ++i) {
        extinction[i] = sigma_t * density[i];
        scattering[i] = sigma_s * density[i];
        g[i] = even;
    }
}

static void sample(ty_pop_slab* slab) {
    float middle[TY_POP_BLOCK], density[TY_POP_BLOCK];
    corners at;
    find_lengths(slab, middle);
    find_corners(slab, middle, &at);
    if (slab->multiples != 0) find_density(slab, &at, density);
    for (int32_t p = 0; p < slab->medium->planes; ++p)
        if (slab->multiples != 0)
            multiply_density(slab, p, density);
        else
            find_coefficients(slab, p, &at);
}

/* Sums, as compilers have vectors for those. */
static float misfit(const float* plane, const float* other, float multiple, float allowed, int32_t cells) {
    float sum = 0.0f;
#pragma omp simd reduction(+ : sum)
    for (int32_t i = 0; i < cells; ++i) sum += ty_maxf(0.0f, fabsf(plane[i] - multiple * other[i]) - allowed);
    return sum;
}

static float unevenness(const float* g, const float* scattering, float value, float allowed, int32_t cells) {
    float sum = 0.0f;
#pragma omp simd reduction(+ : sum)
    for (int32_t i = 0; i < cells; ++i)
        sum += scattering[i] > 0.0f ? ty_maxf(0.0f, fabsf(g[i] - value) - allowed) : 0.0f;
    return sum;
}

/* ---- light before the medium ---- */

/* The share of a slab that is before a surface. */
TY_FN float open_share(float hit, float start, float per_length) {
    return ty_clampf((hit - start) * per_length, 0.0f, 1.0f);
}

static void shade(ty_pop_slab* slab) {
    const float start = slab->ends[0], per_length = 1.0f / ty_maxf(slab->ends[1] - start, 1e-30f);
    for (int32_t ray = 0; ray < TY_POP_RAYS; ++ray) {
        const float* hit = slab->columns->hit[ray];
#pragma omp simd
        for (int32_t i = 0; i < slab->columns->count; ++i)
            slab->lit[i] =
                (ray == 0 ? 0.0f : slab->lit[i]) + open_share(hit[i], start, per_length) * (1.0f / (float)TY_POP_RAYS);
    }
}

static void spread(ty_pop_slab* slab) {
    const ty_pop_columns* c = slab->columns;
    const float x = c->lamp[0], y = c->lamp[1], z = c->lamp[2], middle = slab->middle;
#pragma omp simd
    for (int32_t i = 0; i < c->count; ++i) {
        const ty_vec off =
            ty_vec_make(c->base[0][i] + c->way[0][i] * middle - x, c->base[1][i] + c->way[1][i] * middle - y,
                        c->base[2][i] + c->way[2][i] * middle - z);
        slab->lit[i] /= ty_maxf(ty_dot(off, off), 1e-30f);
    }
}

static void light(ty_pop_slab* slab) {
    const int32_t count = slab->columns->count;
    if (slab->columns->shaded != 0) shade(slab);
    for (int32_t i = 0; i < count && slab->columns->shaded == 0; ++i) slab->lit[i] = 1.0f;
#pragma omp simd
    for (int32_t i = 0; i < count; ++i) slab->lit[i] *= slab->columns->profile[i];
    if (slab->columns->spreads != 0) spread(slab);
}

/* ---- in the medium ---- */

/* Extinction less what scattering sends on: sigma_t - g^order sigma_s, of order 0 sigma_t. */
static void reduce(const ty_pop_slab* slab, int32_t plane, int32_t order, float sigma[TY_POP_BLOCK]) {
    const float *g = slab->g[plane], *extinction = slab->extinction[plane], *scattering = slab->scattering[plane];
    const float linear = order == 1 ? 1.0f : 0.0f, square = order == 2 ? 1.0f : 0.0f;
#pragma omp simd
    for (int32_t i = 0; i < slab->columns->count; ++i) {
        const float forward = ty_maxf(0.0f, g[i]);
        sigma[i] = ty_maxf(0.0f, extinction[i] - forward * (linear + square * forward) * scattering[i]);
    }
}

static void pass_order(const ty_pop_slab* slab, const float sigma[TY_POP_BLOCK], float* along, float* mean) {
    const float *length = slab->length, *lit = slab->lit;
#pragma omp simd
    for (int32_t i = 0; i < slab->columns->count; ++i) {
        const float depth = sigma[i] * length[i], decay = ty_decay(depth), before = along[i];
        mean[i] = before * ty_mean_decay(depth, decay) * lit[i];
        along[i] = before * decay;
    }
}

static void pass(const ty_pop_slab* slab, ty_pop_transmittance* t) {
    float sigma[TY_POP_BLOCK];
    for (int32_t p = 0; p < slab->medium->planes; ++p)
        for (int32_t order = 0; order < t->orders; ++order) {
            reduce(slab, p, order, sigma);
            pass_order(slab, sigma, t->along[p][order], t->mean[p][order]);
        }
}

static float turned(const ty_pop_slab* slab, int32_t plane, const float* kept) {
    const float *scattering = slab->scattering[plane], *g = slab->g[plane];
    const float *length = slab->length, *across = slab->columns->across;
    float sum = 0.0f;
#pragma omp simd reduction(+ : sum)
    for (int32_t i = 0; i < slab->columns->count; ++i)
        sum += ty_turned_coefficient(scattering[i], g[i]) * kept[i] * (length[i] * across[i]);
    return sum;
}

/* ---- what is seen ---- */

static void look(const ty_pop_slab* slab, ty_pop_look* l) {
    const ty_pop_columns* c = slab->columns;
    const float x = l->eye[0], y = l->eye[1], z = l->eye[2], middle = slab->middle;
#pragma omp simd
    for (int32_t i = 0; i < c->count; ++i) {
        const ty_vec way = ty_vec_make(c->way[0][i], c->way[1][i], c->way[2][i]);
        const ty_vec to = ty_vec_make(x - c->base[0][i] - way.x * middle, y - c->base[1][i] - way.y * middle,
                                      z - c->base[2][i] - way.z * middle);
        l->mu[i] = ty_clampf(ty_dot(way, to) / sqrtf(ty_maxf(ty_dot(to, to), 1e-30f)), -1.0f, 1.0f);
    }
}

/* Lobes of what scatters once, and their means under the disc's tent. */
typedef struct lobes {
    float lobe[TY_POP_BLOCK], mean[TY_POP_BLOCK];
} lobes;

static void find_lobes(const ty_pop_slab* slab, int32_t plane, const ty_pop_look* look, lobes* out) {
    const float *g = slab->g[plane], width = look->width, cosine = look->cosine;
    const int32_t count = slab->columns->count;
    float *lobe = out->lobe, *mean = out->mean;
    if (slab->multiples != 0) {
        const float even = ty_pop_disc_lobe(fabsf(slab->usual_g[plane]), cosine, width);
        const float middle = ty_pop_disc_mean(even, width);
        for (int32_t i = 0; i < count; ++i) lobe[i] = even;
        for (int32_t i = 0; i < count; ++i) mean[i] = middle;
        return;
    }
#pragma omp simd
    for (int32_t i = 0; i < count; ++i) {
        lobe[i] = ty_pop_disc_lobe(fabsf(g[i]), cosine, width);
        mean[i] = ty_pop_disc_mean(lobe[i], width);
    }
}

/* Whether any column is seen from under the disc's tent. */
static bool is_near(const ty_pop_slab* slab, const ty_pop_look* look) {
    const float *mu = look->mu, width = look->width;
    float most = 0.0f;
#pragma omp simd reduction(max : most)
    for (int32_t i = 0; i < slab->columns->count; ++i) {
        const float share = ty_pop_disc_share(fabsf(mu[i]), width); /* of either side: g may be of either sign */
        most = most > share ? most : share;
    }
    return most > 0.0f;
}

static void scatter_plane(const ty_pop_slab* slab, int32_t plane, const lobes* l, bool near, ty_pop_look* look) {
    const float *u = look->mean[plane][0], *r = look->mean[plane][1], *s = look->mean[plane][2], *g = slab->g[plane];
    const float *lobe = l->lobe, *mean = l->mean, *mu = look->mu, width = look->width, cosine = look->cosine;
    float* radiance = look->radiance[plane];
    if (near) {
#pragma omp simd
        for (int32_t i = 0; i < slab->columns->count; ++i)
            radiance[i] = u[i] * ty_pop_disc_once(mu[i], g[i], width, lobe[i], mean[i]) +
                          ty_pop_disc_forward(mu[i], u[i], r[i], s[i], g[i], cosine, width, lobe[i]);
        return;
    }
#pragma omp simd
    for (int32_t i = 0; i < slab->columns->count; ++i)
        radiance[i] = u[i] * ty_pop_disc_once_far(mu[i], g[i], lobe[i]) +
                      ty_pop_disc_forward_far(mu[i], u[i], r[i], s[i], g[i], cosine, width, lobe[i]);
}

static void scatter(const ty_pop_slab* slab, ty_pop_look* look) {
    const bool near = is_near(slab, look);
    lobes l;
    for (int32_t p = 0; p < slab->medium->planes; ++p) {
        find_lobes(slab, p, look, &l);
        scatter_plane(slab, p, &l, near, look);
    }
}

/* ---- from cell to cell ---- */

static void fill_half(const ty_pop_slab* slab, float share, const float* loss, const float* absorption,
                      float* pass_half, float* keep_half) {
    const float* length = slab->length;
#pragma omp simd
    for (int32_t i = 0; i < slab->columns->count; ++i) {
        const float half = 0.5f * share * length[i];
        pass_half[i] = ty_decay(absorption[i] * half);
        keep_half[i] = ty_decay(loss[i] * half);
    }
}

/* Absorption over half a step, and the anisotropy retained over it: g^(sigma_s dx), Eq. 4 (Elek 2014), or the exact
 * exp(-sigma_s (1 - g) dx). */
static void start(const ty_pop_slab* slab, ty_pop_start* s) {
    float loss[TY_POP_BLOCK], absorption[TY_POP_BLOCK];
    const float *extinction = slab->extinction[s->plane], *scattering = slab->scattering[s->plane];
    const float *g = slab->g[s->plane], *mean = s->mean, *length = slab->length;
    const float eq4 = s->collided != 0 ? 0.0f : 1.0f;
    float *light = s->light, *again = s->again;
#pragma omp simd
    for (int32_t i = 0; i < slab->columns->count; ++i) {
        const float by_power = -ty_logf(ty_clampf(g[i], 1e-35f, 1.0f));
        const float exactly = 1.0f - g[i], sigma = scattering[i];
        absorption[i] = extinction[i] - sigma;
        loss[i] = sigma * (eq4 * by_power + (1.0f - eq4) * exactly);
        light[i] = mean[i] * (eq4 + (1.0f - eq4) * sigma * length[i]);
        again[i] = eq4 + (1.0f - eq4) * g[i];
    }
    fill_half(slab, 1.0f, loss, absorption, s->pass[0], s->keep[0]);
    fill_half(slab, s->across, loss, absorption, s->pass[1], s->keep[1]);
}

static void begin(const ty_pop_begin* b) {
    const float *uncollided = b->uncollided, *light = b->light, *again = b->again, *tilt = b->tilt, start = b->cosine;
    float *cosine = b->cosines, *fluence = b->fluence, *seen = b->seen;
    const float collided = b->collided != 0 ? 1.0f : 0.0f;
#pragma omp simd
    for (int32_t i = 0; i < b->count; ++i) {
        const float once = start * again[i], new = collided *light[i];
        cosine[i] = once;
        fluence[i] = uncollided[i] + new;
        seen[i] = collided * uncollided[i] * ty_pop_hg_tilted(tilt[i], once) +
                  new* ty_pop_hg_tilted(tilt[i], once * again[i]);
    }
}

static float sum(const float* values, int32_t count) {
    float total = 0.0f;
#pragma omp simd reduction(+ : total)
    for (int32_t i = 0; i < count; ++i) total += values[i];
    return total;
}

/* dL and dL a that cells send to their neighbours: the terms of Eq. 5 and 6 (Elek 2014). */
static void give(const ty_pop_give* give) {
    const float *light = give->light, *cosine = give->cosine;
    const float *pass_along = give->half.pass[0], *pass_across = give->half.pass[1];
    const float *keep_along = give->half.keep[0], *keep_across = give->half.keep[1];
    const ty_pop_handed out = give->out;
#pragma omp simd
    for (int32_t i = 0; i < give->count; ++i) {
        float front, side, back;
        ty_pop_patches(cosine[i], &front, &side, &back);
        const float along = light[i] * pass_along[i], across = light[i] * pass_across[i];
        const float turned_along = along * cosine[i] * keep_along[i];
        const float turned_across = across * cosine[i] * keep_across[i];
        out.front[i] = along * front;
        out.back[i] = along * back;
        out.side[i] = across * side;
        out.front_turned[i] = turned_along * front;
        out.back_turned[i] = turned_along * back;
        out.side_turned[i] = turned_across * side;
    }
}

/* L = sum dL and a = sum dL a / sum dL over the neighbours: Eq. 5 and 6 (Elek 2014). */
static void take(const ty_pop_take* take) {
    const int32_t row = take->row;
    const float *pass_along = take->half.pass[0], *pass_across = take->half.pass[1];
    const float *keep_along = take->half.keep[0], *keep_across = take->half.keep[1];
    const float *front = take->before.front, *front_turned = take->before.front_turned;
    const float *back = take->after.back, *back_turned = take->after.back_turned;
    const float *side = take->beside.side, *side_turned = take->beside.side_turned;
    const float *tilt = take->tilt, *again = take->again;
    float *light = take->light, *cosine = take->cosine, *fluence = take->fluence, *seen = take->seen;
#pragma omp simd
    for (int32_t i = take->begin; i < take->end; ++i) {
        const float across = pass_across[i] * (side[i - 1] + side[i + 1] + side[i - row] + side[i + row]);
        const float turned_across =
            keep_across[i] * pass_across[i] *
            (side_turned[i - 1] + side_turned[i + 1] + side_turned[i - row] + side_turned[i + row]);
        const float along = pass_along[i] * (front[i] + back[i]);
        const float turned_along = keep_along[i] * pass_along[i] * (front_turned[i] + back_turned[i]);
        const float all = along + across;
        const float a = (turned_along + turned_across) / (all + 1e-30f);
        light[i] = all;
        cosine[i] = a;
        fluence[i] += all;
        seen[i] += all * ty_pop_hg_tilted(tilt[i], a * again[i]);
    }
}

const ty_pop_grid_kernels TY_JOIN(ty_pop_grid_kernels_, TY_ISA) = {.misfit = misfit,
                                                                   .unevenness = unevenness,
                                                                   .sample = sample,
                                                                   .light = light,
                                                                   .pass = pass,
                                                                   .turned = turned,
                                                                   .look = look,
                                                                   .scatter = scatter,
                                                                   .start = start,
                                                                   .begin = begin,
                                                                   .sum = sum,
                                                                   .give = give,
                                                                   .take = take};
