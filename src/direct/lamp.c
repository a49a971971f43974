/* Lamps: six pyramids about the lamp, one for each way along an axis, each cut into lengths within which the distance
 * doubles. Within such a length a lattice of rays, about a cell apart at its far end, keeps the mean extinction from
 * where each enters the box: unlike the optical depth it is even between rays, however they enter. */
#include "direct/lamp.h"

#include "base/context.h"
#include "base/float_mode.h"
#include "direct/lamp.k.h"
#include "direct/lamp_near.h"

enum { FIRST_SLABS = 4 };

/* The lattice of one length of one pyramid. p and q: tangents along the axes u and v. */
typedef struct lattice {
    const ty_lamp_job* of;
    int32_t axis[3];        /* u, v, w */
    bool backwards;         /* along w */
    int32_t slabs, begin;   /* of the length; the first, counted along w */
    double near, far;       /* m along w from the lamp */
    double low[2], step[2]; /* of p and q */
    int32_t count[2];
    double entry;   /* m along w: where the box begins */
    float* mean[3]; /* extinction up to the near side of each slab, and the far side of the last: (slabs + 1) x count */
    float* hit;     /* per ray: how far along w a surface is, m; NULL: there are none */
} lattice;

static size_t ray_count(const lattice* l) {
    return (size_t)l->count[0] * (size_t)l->count[1];
}

static size_t value_count(const lattice* l) {
    return ray_count(l) * (size_t)(l->slabs + 1);
}

static void end_lattice(lattice* l) {
    ty_context* context = l->of->medium->context;
    for (int32_t c = 0; c < l->of->medium->planes; ++c)
        ty_free_array(context, l->mean[c], value_count(l), sizeof *l->mean[c]);
    ty_free_array(context, l->hit, ray_count(l), sizeof *l->hit);
    l->slabs = 0;
    l->hit = l->mean[0] = l->mean[1] = l->mean[2] = NULL;
}

static ty_result take_lattice(lattice* l) {
    const ty_grid_medium* medium = l->of->medium;
    for (int32_t c = 0; c < medium->planes; ++c) {
        l->mean[c] = ty_alloc_array(medium->context, value_count(l), sizeof *l->mean[c], false);
        if (l->mean[c] == NULL) return TY_ERROR_MEMORY;
    }
    if (l->of->scene->mesh == NULL) return TY_OK;
    l->hit = ty_alloc_array(medium->context, ray_count(l), sizeof *l->hit, false);
    return l->hit != NULL ? TY_OK : TY_ERROR_MEMORY;
}

/* ---- rays of a lattice ---- */

/* The near side of a slab of the lattice, m along w from the lamp. */
static double plane_at(const lattice* l, int32_t slab) {
    const int32_t w = l->axis[2];
    const double cell = l->of->medium->cell[w];
    const double from = l->backwards ? -l->of->upper[w] : l->of->lower[w];
    return fmax(l->near, from + cell * (l->begin + slab));
}

/* The cell along w that a slab is. */
static int32_t slab_cell(const lattice* l, int32_t slab) {
    const int32_t at = l->begin + slab;
    return l->backwards ? l->of->medium->box.size[l->axis[2]] - 1 - at : at;
}

/* Where along w a ray comes to be within [low, high], m; INFINITY: nowhere. */
static double entry_of(double p, double low, double high) {
    if (low <= 0 && high >= 0) return 0;
    const double at = p != 0 ? (low > 0 ? low : high) / p : -1;
    return at > 0 ? at : INFINITY;
}

/* Where along w a ray enters the box, m, and through a side across which of u, v, w. It is not said to leave it again:
 * at the box's sides, rays go on as if the outer cells did. Nothing there is lit, and between a ray there and one
 * inside values stay right. */
static double enters_at(const lattice* l, double p, double q, int32_t* across) {
    const ty_lamp_job* lamp = l->of;
    const double u = entry_of(p, lamp->lower[l->axis[0]], lamp->upper[l->axis[0]]);
    const double v = entry_of(q, lamp->lower[l->axis[1]], lamp->upper[l->axis[1]]);
    *across = l->entry >= u && l->entry >= v ? 2 : u >= v ? 0 : 1;
    return fmax(l->entry, fmax(u, v));
}

/* The gradient of the length from the box's side to a point. to: unit, from the lamp; outside: the share of the way
 * before that side. */
static ty_vec length_gradient(const double to[3], double outside, int32_t across) {
    double slope[3];
    for (int a = 0; a < 3; ++a) slope[a] = to[a] * (1 - outside);
    slope[across] += outside / to[across];
    return ty_vec_make((float)slope[0], (float)slope[1], (float)slope[2]);
}

/* Cells around a coordinate that is in cells from the box's lower side, and the share of the upper one. */
static void neighbours(double at, int32_t size, int32_t cells[2], float* share) {
    const double from = fmin(fmax(at - 0.5, 0), size - 1);
    cells[0] = (int32_t)from;
    cells[1] = cells[0] + 1 < size ? cells[0] + 1 : cells[0];
    *share = (float)(from - cells[0]);
}

/* Extinction that a ray meets in a slab, `along` m along w; beyond the box's sides as in the outer cells. */
static void slab_extinction(const lattice* l, int32_t slab, double p, double q, double along, float sigma[3]) {
    const ty_lamp_job* lamp = l->of;
    const ty_grid_medium* medium = lamp->medium;
    const double tangent[2] = {p, q};
    const size_t row_size = (size_t)medium->box.size[0];
    const size_t stride[3] = {1, row_size, row_size * (size_t)medium->box.size[1]};
    int32_t cells[2][2];
    float share[2];
    for (int i = 0; i < 2; ++i) {
        const int32_t a = l->axis[i];
        neighbours((tangent[i] * along - lamp->lower[a]) / medium->cell[a], medium->box.size[a], cells[i], &share[i]);
    }
    const size_t base = stride[l->axis[2]] * (size_t)slab_cell(l, slab);
    const size_t u = stride[l->axis[0]], v = stride[l->axis[1]];
    for (int32_t c = 0; c < medium->planes; ++c) {
        const float* plane = lamp->extinction[c] + base;
        const float* row[2] = {plane + v * (size_t)cells[1][0], plane + v * (size_t)cells[1][1]};
        const size_t i = u * (size_t)cells[0][0], j = u * (size_t)cells[0][1];
        sigma[c] = ty_share_between(ty_share_between(row[0][i], row[0][j], share[0]),
                                    ty_share_between(row[1][i], row[1][j], share[0]), share[1]);
    }
}

/* Where a tangent is on a lattice: between ray *i and the next, at the returned share of the next. */
static float locate(const lattice* l, int32_t along, double tangent, int32_t* i) {
    const double at = fmin(fmax((tangent - l->low[along]) / l->step[along], 0), l->count[along] - 1);
    *i = (int32_t)fmin(at, l->count[along] - 2);
    return (float)(at - *i);
}

static float between_rays(const lattice* l, const float* plane, const int32_t at[2], const float share[2]) {
    const float* row = plane + (size_t)at[1] * (size_t)l->count[0] + (size_t)at[0];
    const float* next = row + l->count[0];
    return ty_share_between(ty_share_between(row[0], row[1], share[0]), ty_share_between(next[0], next[1], share[0]),
                            share[1]);
}

typedef struct trace_job {
    lattice* l;
    const lattice* before; /* the length nearer to the lamp; slabs 0: there is none */
} trace_job;

/* The mean extinction up to the near side of a lattice, from that before it. */
static void begin_mean(const lattice* before, double p, double q, float mean[3]) {
    int32_t i[2];
    const float share[2] = {locate(before, 0, p, &i[0]), locate(before, 1, q, &i[1])};
    const size_t last = ray_count(before) * (size_t)before->slabs;
    for (int32_t c = 0; c < before->of->medium->planes; ++c)
        mean[c] = between_rays(before, before->mean[c] + last, i, share);
}

/* How far along a ray a surface is, as a distance along w. */
static float hit_along(const lattice* l, double p, double q) {
    const double length = sqrt(1 + p * p + q * q);
    float way[3];
    way[l->axis[0]] = (float)(p / length);
    way[l->axis[1]] = (float)(q / length);
    way[l->axis[2]] = (float)((l->backwards ? -1 : 1) / length);
    return ty_lamp_reach(l->of, ty_vec_load(way), TY_FLOAT_MAX) / (float)length;
}

static void trace_ray(const trace_job* job, int32_t column, int32_t row) {
    lattice* l = job->l;
    const double p = l->low[0] + l->step[0] * column, q = l->low[1] + l->step[1] * row;
    int32_t across;
    const double entry = enters_at(l, p, q, &across);
    const size_t rays = ray_count(l), at = (size_t)row * (size_t)l->count[0] + (size_t)column;
    double depth[3] = {0, 0, 0}; /* as if lengths were taken along w */
    float value[3] = {0, 0, 0};
    if (job->before->slabs > 0 && l->near > entry) {
        begin_mean(job->before, p, q, value);
        for (int c = 0; c < 3; ++c) depth[c] = (double)value[c] * (l->near - entry);
    }
    for (int32_t slab = 0; slab <= l->slabs; ++slab) {
        const double near = plane_at(l, slab), far = slab < l->slabs ? fmin(l->far, plane_at(l, slab + 1)) : near;
        const double from = fmin(far, fmax(near, entry));
        float sigma[3] = {0, 0, 0};
        slab_extinction(l, slab < l->slabs ? slab : l->slabs - 1, p, q, 0.5 * (from + far), sigma);
        for (int32_t c = 0; c < l->of->medium->planes; ++c) {
            const double passed = near - entry;
            l->mean[c][rays * (size_t)slab + at] = passed > 0 ? (float)(depth[c] / passed) : sigma[c];
            depth[c] += (double)sigma[c] * (far - from);
        }
    }
    if (l->hit != NULL) l->hit[at] = hit_along(l, p, q);
}

static void trace_row(void* user, int64_t row, int32_t worker) {
    (void)worker;
    const trace_job* job = user;
    const unsigned state = ty_flush_denormals();
    for (int32_t column = 0; column < job->l->count[0]; ++column) trace_ray(job, column, (int32_t)row);
    ty_restore_denormals(state);
}

/* ---- cells ---- */

static void add_light(const ty_lamp_job* lamp, size_t at, ty_vec to, float distance, const float mean[3]) {
    const ty_lamp_out* out = &lamp->out;
    const float falloff = ty_source_profile(lamp->light, ty_dot(to, lamp->source->direction)) / (distance * distance);
    for (int32_t c = 0; c < 3; ++c) {
        const float fluence = lamp->source->color[c] * falloff * mean[c];
        out->fluence[c][at] += fluence;
        if (out->flux == NULL) continue;
        out->flux[c][0][at] += fluence * to.x;
        out->flux[c][1][at] += fluence * to.y;
        out->flux[c][2][at] += fluence * to.z;
    }
}

/* Whether the way to a cell's middle is along this lattice's pyramid: exactly one of the six has it. */
static bool is_owned(const lattice* l, const double off[3]) {
    const double x = fabs(off[0]), y = fabs(off[1]), z = fabs(off[2]);
    const int32_t w = x >= y && x >= z ? 0 : y >= z ? 1 : 2;
    return w == l->axis[2] && (off[w] < 0) == l->backwards;
}

/* The share of the rays around a point that reach it. */
static float open_share(const lattice* l, const int32_t at[2], const float share[2], double along) {
    if (l->hit == NULL) return 1;
    const float* row = l->hit + (size_t)at[1] * (size_t)l->count[0] + (size_t)at[0];
    const float* next = row + l->count[0];
    const float w = (float)along;
    return ty_share_between(ty_share_between(row[0] > w ? 1 : 0, row[1] > w ? 1 : 0, share[0]),
                            ty_share_between(next[0] > w ? 1 : 0, next[1] > w ? 1 : 0, share[0]), share[1]);
}

/* Optical depths of a cell's middle, off[3] m from the lamp. */
static void find_depths(const lattice* l, int32_t slab, size_t cell_at, const double off[3], const int32_t at[2],
                        const float share[2], ty_lamp_depth depths[3]) {
    const double along = fabs(off[l->axis[2]]);
    const double p = off[l->axis[0]] / along, q = off[l->axis[1]] / along;
    const double distance = along * sqrt(1 + p * p + q * q);
    const double to[3] = {off[0] / distance, off[1] / distance, off[2] / distance};
    const double near = plane_at(l, slab), far = fmin(l->far, plane_at(l, slab + 1));
    const float passed = (float)fmin(fmax((along - near) / (far - near), 0), 1);
    int32_t across;
    const double outside = fmin(1, enters_at(l, p, q, &across) / along);
    const ty_vec slope = length_gradient(to, outside, l->axis[across]);
    const size_t rays = ray_count(l);
    for (int32_t c = 0; c < l->of->medium->planes; ++c) {
        const float* plane = l->mean[c] + rays * (size_t)slab;
        const float mean =
            ty_share_between(between_rays(l, plane, at, share), between_rays(l, plane + rays, at, share), passed);
        depths[c] = (ty_lamp_depth){.depth = mean * (float)((1 - outside) * distance),
                                    .extinction = l->of->extinction[c][cell_at],
                                    .slope = slope};
    }
}

static void light_cell(const lattice* l, int32_t slab, size_t cell_at, const double off[3]) {
    const ty_lamp_job* lamp = l->of;
    const ty_grid_medium* medium = lamp->medium;
    const double along = fabs(off[l->axis[2]]);
    const double distance = sqrt(off[0] * off[0] + off[1] * off[1] + off[2] * off[2]);
    const ty_vec to = ty_vec_make((float)(off[0] / distance), (float)(off[1] / distance), (float)(off[2] / distance));
    const float size[3] = {(float)medium->cell[0], (float)medium->cell[1], (float)medium->cell[2]};
    int32_t at[2];
    const float share[2] = {locate(l, 0, off[l->axis[0]] / along, &at[0]),
                            locate(l, 1, off[l->axis[1]] / along, &at[1])};
    const float open = open_share(l, at, share, along);
    float* const* transmittance = lamp->out.transmittance;
    ty_lamp_depth depths[3];
    float mean[3] = {0, 0, 0};
    if (open > 0) find_depths(l, slab, cell_at, off, at, share, depths);
    for (int32_t c = 0; c < medium->planes && open > 0; ++c)
        mean[c] = open * (transmittance != NULL ? ty_lamp_mean_transmittance(depths[c], size)
                                                : ty_lamp_mean(depths[c], to, (float)distance, size));
    for (int32_t c = medium->planes; c < 3; ++c) mean[c] = mean[0];
    for (int32_t c = 0; c < medium->planes && transmittance != NULL; ++c) transmittance[c][cell_at] = mean[c];
    if (transmittance == NULL) add_light(lamp, cell_at, to, (float)distance, mean);
}

/* A cell's middle along an axis, m from the lamp. */
static double middle_of(const ty_lamp_job* lamp, int32_t axis, int32_t cell) {
    return lamp->lower[axis] + lamp->medium->cell[axis] * (cell + 0.5);
}

/* One row of cells of a slab, as far as it is in the pyramid. */
static void light_row(void* user, int64_t index, int32_t worker) {
    (void)worker;
    const lattice* l = user;
    const ty_lamp_job* lamp = l->of;
    const ty_grid_medium* medium = lamp->medium;
    const int32_t *axis = l->axis, *size = medium->box.size;
    const int32_t rows = size[axis[1]], slab = (int32_t)(index / rows);
    int32_t cell[3];
    cell[axis[1]] = (int32_t)(index % rows);
    cell[axis[2]] = slab_cell(l, slab);
    double off[3];
    for (int i = 1; i < 3; ++i) off[axis[i]] = middle_of(lamp, axis[i], cell[axis[i]]);
    const double wide = fabs(off[axis[2]]);
    if (fabs(off[axis[1]]) > wide) return;
    const double low = lamp->lower[axis[0]], per_cell = 1 / medium->cell[axis[0]];
    const int32_t begin = (int32_t)fmax(0, fmin(size[axis[0]], floor((-wide - low) * per_cell) - 1));
    const int32_t end = (int32_t)fmax(0, fmin(size[axis[0]], ceil((wide - low) * per_cell) + 1));
    const unsigned state = ty_flush_denormals();
    for (int32_t u = begin; u < end; ++u) {
        cell[axis[0]] = u;
        off[axis[0]] = middle_of(lamp, axis[0], u);
        if (!is_owned(l, off) || (lamp->out.transmittance == NULL && ty_lamp_is_near(lamp, cell))) continue;
        light_cell(l, slab, (size_t)cell[0] + (size_t)size[0] * ((size_t)cell[1] + (size_t)size[1] * (size_t)cell[2]),
                   off);
    }
    ty_restore_denormals(state);
}

/* ---- pyramids ---- */

/* The tangents at which the box is seen between the lattice's near and far side; false: nowhere in the pyramid. */
static bool place_rays(lattice* l) {
    for (int i = 0; i < 2; ++i) {
        const int32_t a = l->axis[i];
        const double low = l->of->lower[a], high = l->of->upper[a];
        const double at_low = low < 0 ? l->near : l->far, at_high = high > 0 ? l->near : l->far;
        l->low[i] = at_low > 0 ? fmax(-1, low / at_low) : -1;
        const double end = at_high > 0 ? fmin(1, high / at_high) : 1;
        if (!(end > l->low[i])) return false;
        const double rays = ceil((end - l->low[i]) * l->far / l->of->medium->cell[a]) + 1;
        l->count[i] = (int32_t)fmin(fmax(2, rays), 4 * l->of->medium->box.size[a] + 64);
        l->step[i] = (end - l->low[i]) / (l->count[i] - 1);
    }
    return true;
}

/* The next length from slab `begin` on; distances double within it. */
static void place_slabs(lattice* l, int32_t begin) {
    const int32_t size = l->of->medium->box.size[l->axis[2]];
    const double cell = l->of->medium->cell[l->axis[2]];
    l->begin = begin;
    l->near = 0;
    l->near = plane_at(l, 0);
    l->slabs = (int32_t)fmin(size - begin, fmax(FIRST_SLABS, ceil(l->near / cell)));
    l->far = INFINITY;
    l->far = plane_at(l, l->slabs);
}

static ty_result light_length(const ty_lamp_job* lamp, lattice* l, const lattice* before) {
    const ty_result result = take_lattice(l);
    if (result != TY_OK) return result;
    trace_job job = {.l = l, .before = before};
    ty_parallel_for(lamp->medium->context, l->count[1], trace_row, &job);
    ty_parallel_for(lamp->medium->context, (int64_t)l->slabs * lamp->medium->box.size[l->axis[1]], light_row, l);
    return TY_OK;
}

static ty_result light_pyramid(const ty_lamp_job* lamp, int32_t w, bool backwards) {
    const ty_grid_medium* medium = lamp->medium;
    const double from = backwards ? -lamp->upper[w] : lamp->lower[w];
    lattice before = {.of = lamp},
            l = {.of = lamp, .axis = {w == 0 ? 1 : 0, w == 2 ? 1 : 2, w}, .backwards = backwards};
    l.entry = fmax(0, from);
    ty_result result = TY_OK;
    int32_t begin = (int32_t)fmin(medium->box.size[w], fmax(0, floor(-from / medium->cell[w])));
    for (; begin < medium->box.size[w] && result == TY_OK; begin += l.slabs) {
        place_slabs(&l, begin);
        if (!(l.far > l.near) || !place_rays(&l)) continue;
        result = light_length(lamp, &l, &before);
        const lattice done = l;
        end_lattice(&before);
        before = done;
        l.hit = l.mean[0] = l.mean[1] = l.mean[2] = NULL;
    }
    end_lattice(&before);
    return result;
}

ty_result ty_lamp_add(const ty_scene_view* scene, const ty_grid_medium* medium, float* const extinction[3],
                      const ty_source* source, const ty_lamp_out* out) {
    ty_lamp_job lamp = {.scene = scene, .medium = medium, .source = source, .extinction = extinction, .out = *out};
    lamp.light = &scene->lights.lights[source->light];
    const double position[3] = {(double)source->position.x, (double)source->position.y, (double)source->position.z};
    double least = INFINITY;
    for (int a = 0; a < 3; ++a) {
        lamp.lower[a] = medium->box.lower[a] - position[a];
        lamp.upper[a] = medium->box.upper[a] - position[a];
        lamp.home[a] = (int32_t)fmin(fmax(floor(-lamp.lower[a] / medium->cell[a]), -1e6), 1e6);
        least = fmin(least, medium->cell[a]);
    }
    if (source->alone == 0) lamp.lift = (float)(1e-3 * least);
    ty_result result = TY_OK;
    for (int32_t w = 0; w < 3 && result == TY_OK; ++w) {
        result = light_pyramid(&lamp, w, false);
        if (result == TY_OK) result = light_pyramid(&lamp, w, true);
    }
    if (result == TY_OK && out->transmittance == NULL) result = ty_lamp_add_near(&lamp);
    return result;
}
