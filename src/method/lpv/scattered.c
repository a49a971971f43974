/* Light that media scatter for the first time.
 *
 * A ray's stretch within the lattice is cut into equal parts. What a part scatters is found exactly from cell to cell
 * of the medium, and goes on from one point of it, more likely one where more is scattered. Where in parts points are
 * belongs to texels, and neighbours' points lie evenly between one another's. */
#include "base/random.k.h"
#include "direct/beam.k.h"
#include "method/lpv/lamp_ray.h"
#include "method/lpv/splat.h"

/* Samples a cell, about, of rays that are short. */
static const float per_cell = 2.0f;

/* How far from a ray's end, in cells, samples may be moved off the surface there. */
static const float near_end = 2.0f;

/* Changes of the medium in one part of a ray that are told apart. */
enum { STRETCHES = 64 };

typedef struct scatter_job {
    const ty_lattice* lattice;
    const ty_lpv_lamp* lamp;
    ty_splat_cells cells;
    ty_lamp_medium medium;
    int32_t channels; /* of the medium, that are apart */
    int32_t samples;
    float offset; /* of the jitter */
} scatter_job;

/* Numbers in [0, 1) that are even among neighbouring texels (Roberts 2018: the plastic number's lattice). */
static float jitter_of(const scatter_job* job, int64_t row, int32_t x) {
    const double at = (double)job->offset + 0.7548776662466927 * x + 0.5698402909980532 * (double)row;
    return (float)(at - (double)(int64_t)at);
}

/* A part of a ray. */
typedef struct ray_part {
    ty_lamp_stretch stretches[STRETCHES];
    float until[STRETCHES]; /* what is scattered up to the end of each, all channels together */
    int32_t count;
    float scattered[3]; /* share of what the light sends along the ray */
} ray_part;

/* Takes a stretch, and dims what is left of the light. */
static void add_stretch(const scatter_job* job, ray_part* part, const ty_lamp_stretch* stretch, float left[3]) {
    float sum = part->count > 0 ? part->until[part->count - 1] : 0.0f;
    for (int32_t c = 0; c < job->channels; ++c) {
        const float across = stretch->extinction[c] * stretch->length, decay = ty_decay(across);
        const float scattered = left[c] * stretch->scattering[c] * stretch->length * ty_mean_decay(across, decay);
        part->scattered[c] += scattered;
        sum += scattered;
        left[c] *= decay;
    }
    if (part->count < STRETCHES) part->stretches[part->count++] = *stretch;
    part->until[part->count - 1] = sum;
}

/* The point of a part up to which a share of what it scatters comes from, m along the ray. */
static float place_of(const scatter_job* job, const ray_part* part, float share) {
    const float all = part->until[part->count - 1], wanted = share * all;
    int32_t i = 0;
    while (i < part->count - 1 && part->until[i] <= wanted) ++i;
    const ty_lamp_stretch* stretch = &part->stretches[i];
    const float before = i > 0 ? part->until[i - 1] : 0.0f, within = part->until[i] - before;
    const float u = within > 0.0f ? ty_clampf((wanted - before) / within, 0.0f, 1.0f) : share;
    float extinction = 0.0f;
    for (int32_t c = 0; c < job->channels; ++c) extinction += stretch->extinction[c] / (float)job->channels;
    const float across = extinction * stretch->length;
    if (across < 1e-2f) return stretch->begin + u * stretch->length;
    return stretch->begin - ty_logf(1.0f - u * (1.0f - ty_decay(across))) / extinction;
}

/* Off the surface that the ray ends on, so that the cell's middle is on the lit side. */
static ty_vec move_off(const scatter_job* job, const ty_lamp_ray* ray, float at) {
    const ty_vec point = ty_mad(ray->origin, ray->direction, at);
    const float before = ray->length - at;
    if (!(before < near_end * job->lattice->cell)) return point;
    const float* normals = job->lamp->map->normal;
    const ty_vec normal = normals != NULL ? ty_vec_load(normals + 3 * ray->texel) : ty_scale(ray->direction, -1.0f);
    const float height = -before * ty_dot(ray->direction, normal);
    const float missing = ty_splat_clearance(job->lattice, normal) - height;
    return missing > 0.0f ? ty_mad(point, normal, missing) : point;
}

/* The part of a ray within the lattice, up to what it meets. */
static bool clip(const scatter_job* job, const ty_lamp_ray* ray, ty_cell_ray* out) {
    const ty_vec o = ray->origin, d = ray->direction;
    const double origin[3] = {(double)o.x, (double)o.y, (double)o.z}, way[3] = {(double)d.x, (double)d.y, (double)d.z};
    *out = (ty_cell_ray){.end = (double)ray->length};
    return ty_cell_ray_clip(&job->lattice->box, origin, way, out);
}

static bool scatter_part(const scatter_job* job, const ty_lamp_ray* ray, const ray_part* part, float jitter,
                         ty_splat* out) {
    if (part->count == 0 || !(part->until[part->count - 1] > 0.0f)) return false;
    const float at = place_of(job, part, jitter);
    out->cell = ty_splat_cell(&job->cells, move_off(job, ray, at));
    /* Rounding, or a surface at the edge of the lattice. */
    if (out->cell < 0) out->cell = ty_splat_cell(&job->cells, ty_mad(ray->origin, ray->direction, at));
    if (out->cell < 0) return false;
    out->axis = ray->direction;
    for (int c = 0; c < 3; ++c) out->power[c] = ray->power[c] * part->scattered[job->channels == 1 ? 0 : c];
    return true;
}

static int32_t scatter_ray(const scatter_job* job, const ty_lamp_ray* ray, float jitter, ty_splat* out) {
    ty_cell_ray inside;
    ty_lamp_stretch stretch;
    if (!clip(job, ray, &inside)) return 0;
    const double length = inside.end - inside.at;
    const int32_t wanted = 1 + (int32_t)((double)per_cell * length / (double)job->lattice->cell);
    const int32_t parts = wanted < job->samples ? wanted : job->samples;
    ty_lamp_walk walk = ty_lamp_walk_begin(&job->medium, ray, (float)inside.end);
    float left[3] = {1, 1, 1};
    while (ty_lamp_walk_step(&walk, inside.at, &stretch))
        for (int32_t c = 0; c < job->channels; ++c) left[c] *= ty_decay(stretch.extinction[c] * stretch.length);
    int32_t count = 0;
    for (int32_t i = 0; i < parts; ++i) {
        ray_part part;
        part.count = 0;
        part.scattered[0] = part.scattered[1] = part.scattered[2] = 0.0f;
        while (ty_lamp_walk_step(&walk, inside.at + length * (i + 1) / parts, &stretch))
            add_stretch(job, &part, &stretch, left);
        count += scatter_part(job, ray, &part, jitter, &out[count]);
    }
    return count;
}

static int32_t scatter_row(const void* user, int64_t row, ty_splat* out) {
    const scatter_job* job = user;
    int32_t count = 0;
    for (int32_t x = 0; x < job->lamp->map->side; ++x) {
        ty_lamp_ray ray;
        if (ty_lamp_ray_at(job->lamp, row, x, &ray))
            count += scatter_ray(job, &ray, jitter_of(job, row, x), &out[count]);
    }
    return count;
}

ty_result ty_lattice_inject_scattered(ty_lattice* lattice, const ty_lpv_def* def, const ty_lpv_lamp* lamp,
                                      const ty_grid_medium* medium, double power[3]) {
    const scatter_job job = {.lattice = lattice,
                             .lamp = lamp,
                             .cells = ty_splat_cells_of(lattice),
                             .medium = ty_lamp_medium_of(medium),
                             .channels = medium != NULL ? medium->planes : 1,
                             .samples = def->samples,
                             .offset = ty_unit_float((uint32_t)(ty_mix64(def->seed) >> 32))};
    ty_splat_rows rows = {.rows = ty_lamp_rows(lamp),
                          .most = lamp->map->side * def->samples,
                          .user = &job,
                          .row = scatter_row,
                          .band = {1},
                          .turned = true};
    if (medium == NULL) return TY_OK;
    for (int32_t l = 1; l < lattice->bands; ++l) rows.band[l] = ty_lpv_window(def, l);
    return ty_splats_add(lattice, &rows, power);
}
