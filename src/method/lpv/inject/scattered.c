/* Injection of light that media scatter for the first time.
 *
 * A ray's interval in the lattice is divided into equal parts. The power that a part scatters is integrated exactly
 * over the cells of the medium, and is injected at one point of the part, sampled in proportion to the scattering. The
 * jitter of that point is low-discrepancy over neighbouring texels. */
#include "base/random.k.h"
#include "direct/media/attenuation.k.h"
#include "method/lpv/inject/rsm_rays.h"
#include "method/lpv/inject/splat.h"

/* Samples per cell on short rays. */
static const float per_cell = 2.0f;

/* Distance from a ray's end, in cells, within which samples are moved off the surface. */
static const float near_end = 2.0f;

/* Maximum number of segments of the medium stored per part of a ray. */
enum { SEGMENTS_MAX = 64 };

typedef struct scatter_job {
    const ty_lattice* lattice;
    ty_rsm_ray_view view;
    ty_splat_cells cells;
    ty_ray_segments parts;
    float lower[3], upper[3]; /* of the lattice */
    int32_t samples;
    float offset; /* of the jitter */
} scatter_job;

/* Low-discrepancy numbers in [0, 1) over neighbouring texels (the R2 sequence, Roberts 2018). */
static float jitter_of(const scatter_job* job, int64_t row, int32_t x) {
    const double at = (double)job->offset + 0.7548776662466927 * x + 0.5698402909980532 * (double)row;
    return (float)(at - (double)(int64_t)at);
}

static void take_splat(const scatter_job* job, const ty_rsm_rays* rays, int32_t i, int32_t cell, const float weight[3],
                       ty_splat* out) {
    const float* color = job->view.light->light->color;
    out->cell = cell;
    out->axis = ty_rsm_ray_vec(rays->direction, i);
    for (int c = 0; c < 3; ++c) out->power[c] = weight[job->parts.channels == 1 ? 0 : c] * color[c];
}

/* ---- homogeneous media ---- */

static int32_t scatter_evenly(const scatter_job* job, const ty_rsm_rays* rays, ty_splat* out) {
    int32_t count = 0;
    ty_segment_splats splats;
    for (int32_t part = 0; part < job->samples; ++part) {
        job->view.kernels->part(&job->parts, rays, part, &splats);
        for (int32_t i = 0; i < rays->count; ++i) {
            const float weight[3] = {splats.weight[0][i], splats.weight[1][i], splats.weight[2][i]};
            if (splats.cell[i] >= 0) take_splat(job, rays, i, splats.cell[i], weight, &out[count++]);
        }
    }
    return count;
}

/* ---- heterogeneous media ---- */

/* A part of a ray. */
typedef struct ray_part {
    ty_medium_segment segments[SEGMENTS_MAX];
    float until[SEGMENTS_MAX]; /* cumulative scattering at the end of each segment, sum of all channels */
    int32_t count;
    float scattered[3]; /* fraction of the light along the ray that is scattered */
} ray_part;

/* Adds a segment and attenuates the remaining light. */
static void add_segment(const scatter_job* job, ray_part* part, const ty_medium_segment* segment, float left[3]) {
    float sum = part->count > 0 ? part->until[part->count - 1] : 0.0f;
    for (int32_t c = 0; c < job->parts.channels; ++c) {
        const float across = segment->extinction[c] * segment->length, decay = ty_attenuation(across);
        const float scattered = left[c] * segment->scattering[c] * segment->length * ty_mean_attenuation(across, decay);
        part->scattered[c] += scattered;
        sum += scattered;
        left[c] *= decay;
    }
    if (part->count < SEGMENTS_MAX) part->segments[part->count++] = *segment;
    part->until[part->count - 1] = sum;
}

/* The distance along the ray below which a fraction of the part's scattering lies, m. */
static float place_of(const scatter_job* job, const ray_part* part, float fraction) {
    const float wanted = fraction * part->until[part->count - 1];
    int32_t i = 0;
    while (i < part->count - 1 && part->until[i] <= wanted) ++i;
    const ty_medium_segment* segment = &part->segments[i];
    const float before = i > 0 ? part->until[i - 1] : 0.0f, within = part->until[i] - before;
    const float u = within > 0.0f ? ty_clampf((wanted - before) / within, 0.0f, 1.0f) : fraction;
    float extinction = 0.0f;
    for (int32_t c = 0; c < job->parts.channels; ++c) extinction += segment->extinction[c] / (float)job->parts.channels;
    return segment->begin + ty_scattering_distance(u, segment->length, extinction);
}

/* The cell of a point, moved off the surface that the ray ends on, so that the cell's center is on the lit side. */
static int32_t cell_of(const scatter_job* job, const ty_rsm_rays* rays, int32_t i, float at) {
    const ty_vec direction = ty_rsm_ray_vec(rays->direction, i);
    const ty_vec normal = ty_rsm_ray_vec(rays->normal, i);
    const ty_vec origin = ty_rsm_ray_vec(rays->origin, i);
    const ty_vec point = ty_mad(origin, direction, at);
    const float before = rays->length[i] - at;
    if (!(before < job->parts.near_end)) return ty_splat_cell(&job->cells, point);
    const float missing = ty_splat_clearance(job->lattice, normal) + before * ty_dot(direction, normal);
    const int32_t cell = ty_splat_cell(&job->cells, ty_mad(point, normal, ty_maxf(0.0f, missing)));
    return cell >= 0 ? cell : ty_splat_cell(&job->cells, point);
}

static bool scatter_part(const scatter_job* job, const ty_rsm_rays* rays, int32_t i, const ray_part* part,
                         ty_splat* out) {
    if (part->count == 0 || !(part->until[part->count - 1] > 0.0f)) return false;
    const int32_t cell = cell_of(job, rays, i, place_of(job, part, rays->jitter[i]));
    if (cell < 0) return false;
    float weight[3];
    for (int c = 0; c < 3; ++c) weight[c] = rays->measure[i] * part->scattered[c];
    take_splat(job, rays, i, cell, weight, out);
    return true;
}

static int32_t scatter_ray(const scatter_job* job, const ty_rsm_rays* rays, int32_t i, ty_splat* out) {
    const double begin = (double)rays->begin[i], length = (double)(rays->end[i] - rays->begin[i]);
    if (!(length > 0) || !(rays->measure[i] > 0.0f)) return 0;
    const int32_t wanted = 1 + (int32_t)((float)length * job->parts.per_metre);
    const int32_t parts = wanted < job->samples ? wanted : job->samples;
    ty_medium_walk walk = ty_medium_walk_begin(job->view.medium.medium, rays, i);
    ty_medium_segment segment;
    float left[3] = {1, 1, 1};
    while (ty_medium_walk_step(&walk, begin, &segment))
        for (int32_t c = 0; c < job->parts.channels; ++c)
            left[c] *= ty_attenuation(segment.extinction[c] * segment.length);
    int32_t count = 0;
    for (int32_t k = 0; k < parts; ++k) {
        ray_part part;
        part.count = 0;
        part.scattered[0] = part.scattered[1] = part.scattered[2] = 0.0f;
        while (ty_medium_walk_step(&walk, begin + length * (k + 1) / parts, &segment))
            add_segment(job, &part, &segment, left);
        count += scatter_part(job, rays, i, &part, &out[count]);
    }
    return count;
}

/* ---- rows ---- */

static int32_t scatter_row(const void* user, int64_t row, ty_splat* out) {
    const scatter_job* job = user;
    int32_t count = 0;
    ty_rsm_rays rays;
    for (int32_t x = 0; x < job->view.light->rsm->side; x += TY_RSM_RAYS) {
        ty_rsm_rays_at(&job->view, row, x, &rays);
        job->view.kernels->clip(&rays, job->lower, job->upper, rays.begin, rays.end);
        for (int32_t i = 0; i < rays.count; ++i) rays.jitter[i] = jitter_of(job, row, x + i);
        if (job->view.medium.homogeneous) count += scatter_evenly(job, &rays, &out[count]);
        for (int32_t i = 0; i < rays.count && !job->view.medium.homogeneous; ++i)
            count += scatter_ray(job, &rays, i, &out[count]);
    }
    return count;
}

static scatter_job make_job(const ty_lattice* lattice, const ty_lpv_def* def, const ty_lpv_light* light,
                            const ty_grid_medium* medium) {
    scatter_job job = {.lattice = lattice,
                       .view = ty_rsm_ray_view_of(light, medium),
                       .cells = ty_splat_cells_of(lattice),
                       .samples = def->samples,
                       .offset = ty_unit_float((uint32_t)(ty_mix64(def->seed) >> 32)),
                       .parts = {.channels = medium->planes,
                                 .samples = (float)def->samples,
                                 .per_metre = per_cell / lattice->cell,
                                 .cell = lattice->cell,
                                 .near_end = near_end * lattice->cell}};
    for (int a = 0; a < 3; ++a) {
        job.parts.extinction[a] = medium->extinction[a][0];
        job.parts.scattering[a] = medium->scattering[a][0];
        job.parts.size[a] = lattice->box.size[a];
        job.parts.lower[a] = job.lower[a] = (float)lattice->box.lower[a];
        job.upper[a] = (float)lattice->box.upper[a];
    }
    return job;
}

ty_result ty_lattice_inject_scattered(ty_lattice* lattice, const ty_lpv_def* def, const ty_lpv_light* light,
                                      const ty_grid_medium* medium, double power[3]) {
    if (medium == NULL) return TY_OK;
    const scatter_job job = make_job(lattice, def, light, medium);
    ty_splat_rows rows = {.rows = ty_rsm_row_count(light),
                          .max_splats = light->rsm->side * def->samples,
                          .user = &job,
                          .row = scatter_row,
                          .band = {1},
                          .anisotropic = true};
    /* The paper injects band 0 only (isotropic); bands above it are g^l of Henyey-Greenstein about the ray. */
    for (int32_t l = 1; l < lattice->bands; ++l) rows.band[l] = ty_lpv_window(def, l);
    return ty_splats_add(lattice, &rows, power);
}
