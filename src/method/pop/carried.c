/* What of a beam's light scatters out of its forward lobe, and how far that is carried before it is diffuse. */
#include "method/pop/carried.h"

#include "base/context.h"

#include <math.h>

/* Of the flux that light of diffusion's first moment has where it is even, E* (carried.h): limited diffusion lets less
 * through. With all of it narrow media are too bright behind (docs/method/pop.md). */
static const float most_carried = 0.62f;

/* ---- from cell to cell ---- */

typedef struct march {
    const ty_grid_medium* medium;
    float *source, *flux; /* of its cells */
    bool backwards[3];
    ptrdiff_t step[3]; /* from a cell to the next downstream */
    float rate[3];     /* of what is emitted within a cell per flux out of it, 1/m */
} march;

static march begin_march(const ty_grid_medium* medium, ty_vec direction, float* source, float* flux) {
    const float way[3] = {direction.x, direction.y, direction.z};
    march m = {.medium = medium, .source = source, .flux = flux};
    ptrdiff_t stride = 1;
    for (int a = 0; a < 3; ++a) {
        m.backwards[a] = way[a] < 0;
        m.step[a] = m.backwards[a] ? -stride : stride;
        m.rate[a] = fabsf(way[a]) / (float)medium->cell[a];
        stride *= medium->box.size[a];
    }
    return m;
}

/* rate: 0 along axes where the box ends. */
static void pass_cell(const march* m, size_t cell, const float rate[3]) {
    const float most = m->flux[cell] * (rate[0] + rate[1] + rate[2]), have = m->source[cell];
    const float share = most > have ? have / most : 1.0f;
    float left = have;
    m->flux[cell] = most > 0 ? share * m->flux[cell] : 0.0f; /* nothing flows out of the box */
    for (int a = 0; a < 3; ++a) {
        const float passed = m->flux[cell] * rate[a];
        if (!(passed > 0)) continue;
        m->source[(ptrdiff_t)cell + m->step[a]] += passed;
        left -= passed;
    }
    m->source[cell] = ty_maxf(0.0f, left);
}

/* A row, downstream; rate: along y and z. */
static void pass_row(const march* m, size_t first, const float rate[3]) {
    const int32_t count = m->medium->box.size[0];
    float each[3] = {m->rate[0], rate[1], rate[2]};
    for (int32_t i = 0; i < count; ++i) {
        if (i + 1 == count) each[0] = 0;
        pass_cell(m, first + (size_t)(m->backwards[0] ? count - 1 - i : i), each);
    }
}

static void pass_all(const march* m) {
    const int32_t* size = m->medium->box.size;
    for (int32_t k = 0; k < size[2]; ++k)
        for (int32_t j = 0; j < size[1]; ++j) {
            const int32_t y = m->backwards[1] ? size[1] - 1 - j : j, z = m->backwards[2] ? size[2] - 1 - k : k;
            const float rate[3] = {0, j + 1 < size[1] ? m->rate[1] : 0, k + 1 < size[2] ? m->rate[2] : 0};
            pass_row(m, (size_t)size[0] * ((size_t)y + (size_t)size[1] * (size_t)z), rate);
        }
}

/* ---- a light ---- */

/* A plane of a light on fine cells. */
typedef struct carried_plane {
    float *source, *flux;
} carried_plane;

typedef struct carried_job {
    const ty_grid_medium* fine;
    const ty_light_fluence* light;
    int32_t count;
    carried_plane planes[3];
} carried_job;

static void carry_plane(void* user, int64_t plane, int32_t worker) {
    (void)worker;
    const carried_job* job = user;
    const ty_grid_medium* medium = job->fine;
    const int32_t p = medium->planes == 3 ? (int32_t)plane : 0;
    const float *bent = job->light->next_order[plane], *extinction = medium->extinction[p];
    const carried_plane* out = &job->planes[plane];
    for (size_t i = 0; i < medium->cells; ++i) {
        const float g = ty_maxf(0.0f, medium->g[p][i]), scattered = (1.0f - g) * medium->scattering[p][i];
        const float reduced = extinction[i] - g * medium->scattering[p][i];
        out->source[i] = (1.0f + g) * scattered * bent[i];
        out->flux[i] = reduced > 0 ? most_carried * g * scattered * bent[i] / reduced : 0.0f;
    }
    const march m = begin_march(medium, job->light->anchor, out->source, out->flux);
    pass_all(&m);
}

/* What R has that S has not, where the source was. */
static void find_overlap(void* user, int64_t plane, int32_t worker) {
    (void)worker;
    const carried_job* job = user;
    const float *kept = job->light->fluence[plane], *bent = job->light->next_order[plane];
    for (size_t i = 0; i < job->fine->cells; ++i) job->planes[plane].source[i] = kept[i] - bent[i];
}

/* Adds times a factor. */
static void add(const float* from, float factor, size_t count, float* to) {
    for (size_t i = 0; i < count; ++i) to[i] += factor * from[i];
}

/* Adds means of a plane over merged cells to those of each channel that it is for, by a factor for each array. */
static void add_means(const carried_job* job, int32_t plane, const float* from, const ty_grid_medium* merged,
                      float* mean, const float factor[TY_POP_CARRIED], ty_pop_carried* out) {
    ty_grid_average(merged->context, from, job->fine->box.size, merged->box.size, mean);
    for (int32_t c = 0; c < 3; ++c)
        for (int32_t i = 0; i < TY_POP_CARRIED && (c == plane || job->count == 1); ++i)
            if (factor[i] != 0) add(mean, factor[i] * job->light->color[c], merged->cells, out->of[c][i]);
}

static void add_light(carried_job* job, const ty_grid_medium* merged, float* mean, ty_pop_carried* out) {
    const ty_vec way = job->light->anchor;
    const float emitted[TY_POP_CARRIED] = {1}, flux[TY_POP_CARRIED] = {0, 0, way.x, way.y, way.z};
    const float overlap[TY_POP_CARRIED] = {0, -1, -way.x, -way.y, -way.z};
    ty_parallel_for(merged->context, job->count, carry_plane, job);
    for (int32_t p = 0; p < job->count; ++p) {
        add_means(job, p, job->planes[p].source, merged, mean, emitted, out);
        add_means(job, p, job->planes[p].flux, merged, mean, flux, out);
    }
    ty_parallel_for(merged->context, job->count, find_overlap, job);
    for (int32_t p = 0; p < job->count; ++p) add_means(job, p, job->planes[p].source, merged, mean, overlap, out);
}

ty_result ty_pop_carry(const ty_grid_medium* fine, const ty_light_fluence* light, const ty_grid_medium* merged,
                       ty_pop_carried* out) {
    ty_context* context = fine->context;
    carried_job job = {.fine = fine, .light = light, .count = light->shared != 0 ? 1 : 3};
    float* mean = ty_alloc_array(context, merged->cells, sizeof *mean, false);
    bool whole = mean != NULL;
    for (int32_t p = 0; p < job.count && whole; ++p) {
        job.planes[p].source = ty_alloc_array(context, fine->cells, sizeof(float), false);
        job.planes[p].flux = ty_alloc_array(context, fine->cells, sizeof(float), false);
        whole = job.planes[p].source != NULL && job.planes[p].flux != NULL;
    }
    if (whole) add_light(&job, merged, mean, out);
    for (int32_t p = 0; p < job.count; ++p) {
        ty_free_array(context, job.planes[p].source, fine->cells, sizeof(float));
        ty_free_array(context, job.planes[p].flux, fine->cells, sizeof(float));
    }
    ty_free_array(context, mean, merged->cells, sizeof *mean);
    return whole ? TY_OK : TY_ERROR_MEMORY;
}

/* ---- the diffusion's light ---- */

ty_result ty_pop_carried_create(ty_context* context, size_t cells, ty_pop_carried* out) {
    *out = (ty_pop_carried){.cells = cells};
    for (int c = 0; c < 3; ++c)
        for (int i = 0; i < TY_POP_CARRIED; ++i) {
            out->of[c][i] = ty_alloc_array(context, cells, sizeof(float), true);
            if (out->of[c][i] == NULL) return TY_ERROR_MEMORY;
        }
    return TY_OK;
}

void ty_pop_carried_destroy(ty_context* context, ty_pop_carried* carried) {
    for (int c = 0; c < 3; ++c)
        for (int i = 0; i < TY_POP_CARRIED; ++i)
            ty_free_array(context, carried->of[c][i], carried->cells, sizeof(float));
    *carried = (ty_pop_carried){.cells = 0};
}

void ty_pop_carried_add(const ty_pop_carried* carried, ty_diffuse_light* light) {
    for (int c = 0; c < 3; ++c)
        for (int t = 0; t < TY_FIELD_TERMS; ++t)
            add(carried->of[c][1 + t], t == 0 ? TY_INV_4PI : 3 * TY_INV_4PI, carried->cells, light->terms[c][t]);
}
