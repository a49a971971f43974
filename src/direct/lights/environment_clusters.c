/* Clusters of an environment light, by recursive splits of its latitude-longitude table. */
#include "direct/lights/environment_clusters.h"

#include "base/constants.h"
#include "base/context.h"
#include "base/luminance.k.h"
#include "base/parallel.h"
#include "base/random.k.h"
#include "scene/lights/environment_map.k.h"
#include "scene/scene.h"

/* Candidate split positions along each side of a region. */
enum { MAX_SPLITS = 24 };

/* Minimum importance relative to its maximum: no bright region is left to one cluster. */
static const double MIN_IMPORTANCE = 0.03;

/* Importance is raised to the power N / (N + 8) for N clusters: a few clusters have to represent all light, seen or
 * not. */
static const double IMPORTANCE_HALF_COUNT = 8;

/* Sums over a rectangle of the latitude-longitude table. */
typedef struct moments {
    double color[3];    /* irradiance, W m^-2 */
    double flow[3];     /* first moment: luminance times the direction towards the light */
    double mass;        /* luminance times importance */
    double solid_angle; /* sr */
} moments;

typedef struct table_job {
    const ty_environment_view* environment;
    const ty_environment_clusters_def* def;
    double power;         /* exponent of the importance */
    int32_t size[2];      /* cells */
    moments* sums;        /* summed-area table, (size[0] + 1) x (size[1] + 1); at first one entry per cell */
    int32_t shift;        /* column at which the sphere is cut open */
    double min_luminance; /* luminance below the rounding error of differences of the table */
} table_job;

typedef struct region {
    int32_t from[2], to[2]; /* cells */
    moments sum;
    double gain; /* luminance-weighted gain of mean vector length by the best split; 0: no split */
    int32_t axis, split;
} region;

/* a + sign * b */
static moments add_scaled(moments a, const moments* b, double sign) {
    for (int i = 0; i < 3; ++i) {
        a.color[i] += sign * b->color[i];
        a.flow[i] += sign * b->flow[i];
    }
    a.mass += sign * b->mass;
    a.solid_angle += sign * b->solid_angle;
    return a;
}

static double length_of(const double v[3]) {
    return sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
}

/* ---- the table ---- */

static double weight_at(const table_job* job, float u, float v) {
    const ty_environment_clusters_def* def = job->def;
    if (def->importance == NULL) return 1;
    return pow((double)ty_environment_map_at(def->importance, def->width, def->height, u, v), job->power);
}

static void sum_row(void* user, int64_t index, int32_t worker) {
    (void)worker;
    const table_job* job = user;
    const ty_environment_view* env = job->environment;
    const int32_t row = (int32_t)index, width = job->size[0];
    moments* sums = job->sums + (size_t)(width + 1) * (size_t)(row + 1) + 1;
    const ty_environment_cell* cells = env->cells + (size_t)width * (size_t)row;
    const float v = ((float)row + 0.5f) / (float)job->size[1];
    for (int32_t column = 0; column < width; ++column) {
        const ty_environment_cell* cell = &cells[column];
        const double flow[3] = {(double)cell->vector_luminance[0], (double)cell->vector_luminance[1],
                                (double)cell->vector_luminance[2]};
        const bool z_up = env->up == 2;
        moments* sum = &sums[(column + job->shift) % width];
        *sum = (moments){.color = {(double)cell->color[0], (double)cell->color[1], (double)cell->color[2]},
                         .flow = {flow[0], z_up ? flow[1] : flow[2], z_up ? flow[2] : -flow[1]},
                         .solid_angle = (double)cell->solid_angle};
        const float u = ((float)column + 0.5f) / (float)width - env->turns;
        sum->mass = ty_luminance_f64(sum->color) * (MIN_IMPORTANCE + (1 - MIN_IMPORTANCE) * weight_at(job, u, v));
    }
}

/* Replaces sums of cells by sums of all cells up to each corner. */
static void accumulate(const table_job* job) {
    const size_t row = (size_t)job->size[0] + 1;
    for (size_t i = 0; i < row; ++i) job->sums[i] = (moments){.mass = 0};
    for (int32_t y = 1; y <= job->size[1]; ++y) {
        moments* at = job->sums + row * (size_t)y;
        moments along = at[0] = (moments){.mass = 0};
        for (size_t x = 1; x < row; ++x) {
            along = add_scaled(along, &at[x], 1);
            at[x] = add_scaled(along, &at[x - row], 1);
        }
    }
}

static moments sum_of(const table_job* job, const int32_t from[2], const int32_t to[2]) {
    const size_t row = (size_t)job->size[0] + 1;
    const moments* top = job->sums + row * (size_t)from[1];
    const moments* bottom = job->sums + row * (size_t)to[1];
    const moments above = add_scaled(top[to[0]], &top[from[0]], -1);
    return add_scaled(add_scaled(bottom[to[0]], &bottom[from[0]], -1), &above, -1);
}

/* ---- regions ---- */

/* Finds the split that maximises the sum of the halves' mean vector lengths. Ties go to the first axis, so that
 * rounding does not decide. */
static void find_split(const table_job* job, region* p) {
    const double lum = ty_luminance_f64(p->sum.color), whole_length = length_of(p->sum.flow);
    double best = whole_length + 1e-7 * lum;
    p->gain = 0;
    if (!(lum > job->min_luminance)) return;
    for (int32_t axis = 0; axis < 2; ++axis) {
        const int32_t cells = p->to[axis] - p->from[axis], cuts = cells < MAX_SPLITS ? cells : MAX_SPLITS;
        for (int32_t i = 1; i < cuts; ++i) {
            int32_t to[2] = {p->to[0], p->to[1]};
            to[axis] = p->from[axis] + (int32_t)((int64_t)i * cells / cuts);
            const moments first = sum_of(job, p->from, to), second = add_scaled(p->sum, &first, -1);
            const double split_length = length_of(first.flow) + length_of(second.flow);
            if (!(split_length > best)) continue;
            best = split_length + 1e-7 * lum;
            p->gain = (split_length - whole_length) * p->sum.mass / lum;
            p->axis = axis;
            p->split = to[axis];
        }
    }
}

static void split(const table_job* job, region* p, region* rest) {
    *rest = *p;
    p->to[p->axis] = rest->from[p->axis] = p->split;
    p->sum = sum_of(job, p->from, p->to);
    rest->sum = sum_of(job, rest->from, rest->to);
    find_split(job, p);
    find_split(job, rest);
}

/* Splits the region of the largest gain until there are max_regions. */
static int32_t split_regions(const table_job* job, region* regions, int32_t max_regions) {
    int32_t count = 1;
    regions[0] = (region){.to = {job->size[0], job->size[1]}};
    regions[0].sum = sum_of(job, regions[0].from, regions[0].to);
    find_split(job, &regions[0]);
    while (count < max_regions) {
        region* best = &regions[0];
        for (int32_t i = 1; i < count; ++i)
            if (regions[i].gain > best->gain) best = &regions[i];
        if (!(best->gain > job->min_luminance)) break;
        split(job, best, &regions[count++]);
    }
    return count;
}

/* Scales the sums to the environment's own mean: bilinear lookups blend neighbouring texels, which the table does not.
 */
static void find_scale(const table_job* job, const moments* all, double scale[3]) {
    for (int c = 0; c < 3; ++c) {
        const double total = 4 * TY_PI_F64 * (double)job->environment->constant[c];
        scale[c] = all->color[c] > 0 ? total / all->color[c] : 0;
    }
}

static ty_discrete_light sample_of(const ty_scene* scene, const ty_environment_clusters_def* def, int32_t light,
                                   const moments* sum, const double scale[3]) {
    ty_discrete_light out = {.kind = TY_DISCRETE_DIRECTIONAL, .light = light, .shadowed = scene->view.mesh != NULL};
    const double lum = ty_luminance_f64(sum->color), length = length_of(sum->flow);
    const double by_angle = fmax(0, 1 - sum->solid_angle / (4 * TY_PI_F64)), by_length = fmin(1, length / lum);
    out.mean_cosine = (float)pow(def->by_solid_angle ? by_angle : by_length, def->prefilter);
    out.direction = scene->up == TY_AXIS_Z ? ty_vec_make(0, 0, -1) : ty_vec_make(0, -1, 0);
    for (int c = 0; c < 3; ++c) out.color[c] = (float)fmax(0, scale[c] * sum->color[c]);
    if (length > 1e-6 * lum)
        out.direction = ty_normalize(ty_vec_make((float)(-sum->flow[0] / length), (float)(-sum->flow[1] / length),
                                                 (float)(-sum->flow[2] / length)));
    return out;
}

static void add_samples(const ty_scene* scene, int32_t light, table_job* job, region* regions,
                        ty_discrete_light_set* out) {
    double scale[3];
    accumulate(job);
    const moments* all = &job->sums[(size_t)(job->size[0] + 1) * (size_t)(job->size[1] + 1) - 1];
    job->min_luminance = 1e-9 * ty_luminance_f64(all->color);
    const int32_t count = split_regions(job, regions, job->def->count);
    find_scale(job, all, scale);
    for (int32_t i = 0; i < count; ++i)
        if (ty_luminance_f64(regions[i].sum.color) > job->min_luminance)
            out->items[out->count++] = sample_of(scene, job->def, light, &regions[i].sum, scale);
}

/* Principal ordinates of an environment, prefiltered: Sec. 5.1 (Elek 2014). */
ty_result ty_environment_clusters_add(const ty_scene* scene, const ty_environment_clusters_def* def, int32_t light,
                                      ty_discrete_light_set* out) {
    ty_context* context = scene->context;
    const ty_environment_view* environment = &scene->view.lights.lights[light].environment;
    table_job job = {.environment = environment,
                     .def = def,
                     .power = def->count / (def->count + IMPORTANCE_HALF_COUNT),
                     .size = {environment->cells_width, environment->cells_height}};
    const size_t corners = (size_t)(job.size[0] + 1) * (size_t)(job.size[1] + 1), max_regions = (size_t)def->count;
    job.shift = (int32_t)(ty_mix64(def->seed + ty_mix64((uint64_t)light + 1)) % (uint64_t)job.size[0]);
    job.sums = ty_alloc_array(context, corners, sizeof *job.sums, false);
    region* regions = ty_alloc_array(context, max_regions, sizeof *regions, false);
    const bool allocated = job.sums != NULL && regions != NULL;
    if (allocated) {
        ty_parallel_flushed(context, job.size[1], sum_row, &job);
        add_samples(scene, light, &job, regions, out);
    }
    ty_free_array(context, job.sums, corners, sizeof *job.sums);
    ty_free_array(context, regions, max_regions, sizeof *regions);
    return allocated ? TY_OK : TY_ERROR_MEMORY;
}
