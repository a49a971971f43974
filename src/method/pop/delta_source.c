/* Delta-Eddington source of a beam: the light that scatters out of its forward lobe, with the flux that it keeps. */
#include "method/pop/delta_source.h"

#include "base/context.h"

#include <math.h>

/* Limit of the directional flux, as a fraction of E* (delta_source.h), the flux of light with diffusion's first moment
 * in a homogeneous region: flux-limited diffusion lets less through. At 1, narrow media are too bright behind
 * (docs/method/pop.md). */
static const float max_flux_scale = 0.62f;

/* ---- upwind sweep over cells ---- */

typedef struct upwind_sweep {
    const ty_grid_medium* medium;
    float *source, *flux; /* per cell: source, W m^-3; directional flux, W m^-2 */
    bool backwards[3];
    ptrdiff_t step[3]; /* index offset to the next cell downstream, per axis */
    float rate[3];     /* |omega| / cell edge: source per unit of flux out of the cell, 1/m */
} upwind_sweep;

static upwind_sweep begin_sweep(const ty_grid_medium* medium, ty_vec direction, float* source, float* flux) {
    const float omega[3] = {direction.x, direction.y, direction.z};
    upwind_sweep m = {.medium = medium, .source = source, .flux = flux};
    ptrdiff_t stride = 1;
    for (int a = 0; a < 3; ++a) {
        m.backwards[a] = omega[a] < 0;
        m.step[a] = m.backwards[a] ? -stride : stride;
        m.rate[a] = fabsf(omega[a]) / (float)medium->cell[a];
        stride *= medium->box.size[a];
    }
    return m;
}

/* One cell's balance. rate: 0 along axes where the box ends. */
static void sweep_cell(const upwind_sweep* m, size_t cell, const float rate[3]) {
    const float max_outflow = m->flux[cell] * (rate[0] + rate[1] + rate[2]), emitted = m->source[cell];
    const float fraction = max_outflow > emitted ? emitted / max_outflow : 1.0f;
    float remaining = emitted;
    m->flux[cell] = max_outflow > 0 ? fraction * m->flux[cell] : 0.0f; /* no flux leaves the box */
    for (int a = 0; a < 3; ++a) {
        const float outflow = m->flux[cell] * rate[a];
        if (!(outflow > 0)) continue;
        m->source[(ptrdiff_t)cell + m->step[a]] += outflow;
        remaining -= outflow;
    }
    m->source[cell] = ty_maxf(0.0f, remaining);
}

/* One row of cells, downstream. rate: entries 1 and 2 (y and z) are read. */
static void sweep_row(const upwind_sweep* m, size_t first, const float rate[3]) {
    const int32_t count = m->medium->box.size[0];
    float each[3] = {m->rate[0], rate[1], rate[2]};
    for (int32_t i = 0; i < count; ++i) {
        if (i + 1 == count) each[0] = 0;
        sweep_cell(m, first + (size_t)(m->backwards[0] ? count - 1 - i : i), each);
    }
}

static void sweep_cells(const upwind_sweep* m) {
    const int32_t* size = m->medium->box.size;
    for (int32_t k = 0; k < size[2]; ++k)
        for (int32_t j = 0; j < size[1]; ++j) {
            const int32_t y = m->backwards[1] ? size[1] - 1 - j : j, z = m->backwards[2] ? size[2] - 1 - k : k;
            const float rate[3] = {0, j + 1 < size[1] ? m->rate[1] : 0, k + 1 < size[2] ? m->rate[2] : 0};
            sweep_row(m, (size_t)size[0] * ((size_t)y + (size_t)size[1] * (size_t)z), rate);
        }
}

/* ---- one light ---- */

/* One spectral plane of a light on fine cells. */
typedef struct plane_arrays {
    float *source, *flux;
} plane_arrays;

typedef struct delta_source_job {
    const ty_grid_medium* fine;
    const ty_light_fluence* light;
    int32_t count;
    plane_arrays planes[3];
} delta_source_job;

static void sweep_plane(void* user, int64_t plane, int32_t worker) {
    (void)worker;
    const delta_source_job* job = user;
    const ty_grid_medium* medium = job->fine;
    const int32_t p = medium->planes == 3 ? (int32_t)plane : 0;
    const float *phi_second_moment = job->light->next_order[plane], *extinction = medium->extinction[p];
    const plane_arrays* out = &job->planes[plane];
    for (size_t i = 0; i < medium->cells; ++i) {
        const float g = ty_maxf(0.0f, medium->g[p][i]), diffuse_scattering = (1.0f - g) * medium->scattering[p][i];
        const float transport_extinction = extinction[i] - g * medium->scattering[p][i];
        /* q_0 = (1 - g^2) sigma_s S; E* = q_1 / (sigma_t - g sigma_s), q_1 = g (1 - g) sigma_s S: delta-Eddington,
         * f = g^2 (Joseph, Wiscombe, Weinman 1976) */
        out->source[i] = (1.0f + g) * diffuse_scattering * phi_second_moment[i];
        out->flux[i] = transport_extinction > 0
                           ? max_flux_scale * g * diffuse_scattering * phi_second_moment[i] / transport_extinction
                           : 0.0f;
    }
    const upwind_sweep m = begin_sweep(medium, job->light->anchor, out->source, out->flux);
    sweep_cells(&m);
}

/* Overlap R - S of the light's lobes with the diffusion's light; it overwrites the source. */
static void find_overlap(void* user, int64_t plane, int32_t worker) {
    (void)worker;
    const delta_source_job* job = user;
    const float *phi_order_1 = job->light->fluence[plane], *phi_second_moment = job->light->next_order[plane];
    for (size_t i = 0; i < job->fine->cells; ++i) job->planes[plane].source[i] = phi_order_1[i] - phi_second_moment[i];
}

/* to += factor * from. */
static void add(const float* from, float factor, size_t count, float* to) {
    for (size_t i = 0; i < count; ++i) to[i] += factor * from[i];
}

/* Averages a plane over merged cells and adds it, times each array's factor, to the channels that the plane serves. */
static void add_means(const delta_source_job* job, int32_t plane, const float* from, const ty_grid_medium* merged,
                      float* mean, const float factor[TY_POP_DELTA_SOURCE_ARRAYS], ty_pop_delta_source* out) {
    ty_grid_average(merged->context, from, job->fine->box.size, merged->box.size, mean);
    for (int32_t c = 0; c < 3; ++c)
        for (int32_t i = 0; i < TY_POP_DELTA_SOURCE_ARRAYS && (c == plane || job->count == 1); ++i)
            if (factor[i] != 0) add(mean, factor[i] * job->light->color[c], merged->cells, out->arrays[c][i]);
}

static void add_light(delta_source_job* job, const ty_grid_medium* merged, float* mean, ty_pop_delta_source* out) {
    const ty_vec direction = job->light->anchor;
    const float emitted[TY_POP_DELTA_SOURCE_ARRAYS] = {1},
                flux[TY_POP_DELTA_SOURCE_ARRAYS] = {0, 0, direction.x, direction.y, direction.z};
    const float overlap[TY_POP_DELTA_SOURCE_ARRAYS] = {0, -1, -direction.x, -direction.y, -direction.z};
    ty_parallel_for(merged->context, job->count, sweep_plane, job);
    for (int32_t p = 0; p < job->count; ++p) {
        add_means(job, p, job->planes[p].source, merged, mean, emitted, out);
        add_means(job, p, job->planes[p].flux, merged, mean, flux, out);
    }
    ty_parallel_for(merged->context, job->count, find_overlap, job);
    for (int32_t p = 0; p < job->count; ++p) add_means(job, p, job->planes[p].source, merged, mean, overlap, out);
}

ty_result ty_pop_delta_source_add_light(const ty_grid_medium* fine, const ty_light_fluence* light,
                                        const ty_grid_medium* merged, ty_pop_delta_source* out) {
    ty_context* context = fine->context;
    delta_source_job job = {.fine = fine, .light = light, .count = light->shared != 0 ? 1 : 3};
    float* mean = ty_alloc_array(context, merged->cells, sizeof *mean, false);
    bool ok = mean != NULL;
    for (int32_t p = 0; p < job.count && ok; ++p) {
        job.planes[p].source = ty_alloc_array(context, fine->cells, sizeof(float), false);
        job.planes[p].flux = ty_alloc_array(context, fine->cells, sizeof(float), false);
        ok = job.planes[p].source != NULL && job.planes[p].flux != NULL;
    }
    if (ok) add_light(&job, merged, mean, out);
    for (int32_t p = 0; p < job.count; ++p) {
        ty_free_array(context, job.planes[p].source, fine->cells, sizeof(float));
        ty_free_array(context, job.planes[p].flux, fine->cells, sizeof(float));
    }
    ty_free_array(context, mean, merged->cells, sizeof *mean);
    return ok ? TY_OK : TY_ERROR_MEMORY;
}

/* ---- correction of the diffusion's light ---- */

ty_result ty_pop_delta_source_create(ty_context* context, size_t cells, ty_pop_delta_source* out) {
    *out = (ty_pop_delta_source){.cells = cells};
    for (int c = 0; c < 3; ++c)
        for (int i = 0; i < TY_POP_DELTA_SOURCE_ARRAYS; ++i) {
            out->arrays[c][i] = ty_alloc_array(context, cells, sizeof(float), true);
            if (out->arrays[c][i] == NULL) return TY_ERROR_MEMORY;
        }
    return TY_OK;
}

void ty_pop_delta_source_destroy(ty_context* context, ty_pop_delta_source* delta_source) {
    for (int c = 0; c < 3; ++c)
        for (int i = 0; i < TY_POP_DELTA_SOURCE_ARRAYS; ++i)
            ty_free_array(context, delta_source->arrays[c][i], delta_source->cells, sizeof(float));
    *delta_source = (ty_pop_delta_source){.cells = 0};
}

void ty_pop_delta_source_add_fluence(const ty_pop_delta_source* delta_source, ty_diffuse_light* light) {
    for (int c = 0; c < 3; ++c)
        for (int t = 0; t < TY_FIELD_TERMS; ++t)
            add(delta_source->arrays[c][1 + t], t == 0 ? TY_INV_4PI : 3 * TY_INV_4PI, delta_source->cells,
                light->terms[c][t]);
    for (int c = 0; c < 3; ++c)
        for (int t = 0; t < TY_FIELD_TERMS && light->faces != NULL; ++t)
            add(delta_source->arrays[c][1 + t], t == 0 ? TY_INV_4PI : 3 * TY_INV_4PI, delta_source->cells,
                light->surface_terms[c][t]);
}
