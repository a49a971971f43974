/* Environment light, cut into parts. */
#include "direct/environment_parts.h"

#include "base/context.h"
#include "base/parallel.h"
#include "base/random.k.h"
#include "scene/environment_map.k.h"
#include "scene/scene.h"

/* Places along each side of a part where it may be cut. */
enum { CUTS = 24 };

/* Of a cell's mass, the part that importance does not decide: nothing bright is left to one part. */
static const double FLOOR = 0.03;

/* Importance counts to the power N / (N + 8): a few parts must stand for all light, whichever is seen most. */
static const double FEW = 8;

static const double pi = 3.14159265358979323846;

/* Sums over a stretch of the sphere. */
typedef struct light_sum {
    double color[3];    /* irradiance, W m^-2 */
    double flow[3];     /* luminance times the direction one looks along */
    double mass;        /* luminance times importance */
    double solid_angle; /* sr */
} light_sum;

typedef struct table_job {
    const ty_environment_view* environment;
    const ty_environment_parts_def* def;
    double power;    /* of importance */
    int32_t size[2]; /* cells */
    light_sum* sums; /* (size[0] + 1) x (size[1] + 1): first of cells, then of all up to a corner */
    int32_t shift;   /* of columns: where the sphere is cut open */
    double dark;     /* luminance that differences of sums cannot be told from 0 by */
} table_job;

typedef struct part {
    int32_t from[2], to[2]; /* cells */
    light_sum sum;
    double gain; /* light times the change of direction that a cut makes of it; 0: there is none */
    int32_t axis, cut;
} part;

static double luminance(const double color[3]) {
    return 0.2126 * color[0] + 0.7152 * color[1] + 0.0722 * color[2];
}

/* a + sign * b */
static light_sum sum_up(light_sum a, const light_sum* b, double sign) {
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
    const ty_environment_parts_def* def = job->def;
    if (def->importance == NULL) return 1;
    return pow((double)ty_environment_map_at(def->importance, def->width, def->height, u, v), job->power);
}

static void sum_row(void* user, int64_t index, int32_t worker) {
    (void)worker;
    const table_job* job = user;
    const ty_environment_view* env = job->environment;
    const int32_t row = (int32_t)index, width = job->size[0];
    light_sum* sums = job->sums + (size_t)(width + 1) * (size_t)(row + 1) + 1;
    const ty_environment_cell* cells = env->cells + (size_t)width * (size_t)row;
    const float v = ((float)row + 0.5f) / (float)job->size[1];
    for (int32_t column = 0; column < width; ++column) {
        const ty_environment_cell* cell = &cells[column];
        const double flow[3] = {(double)cell->vector_luminance[0], (double)cell->vector_luminance[1], (double)cell->vector_luminance[2]};
        const bool z_up = env->up == 2;
        light_sum* sum = &sums[(column + job->shift) % width];
        *sum = (light_sum){.color = {(double)cell->color[0], (double)cell->color[1], (double)cell->color[2]},
                           .flow = {flow[0], z_up ? flow[1] : flow[2], z_up ? flow[2] : -flow[1]},
                           .solid_angle = (double)cell->solid_angle};
        const float u = ((float)column + 0.5f) / (float)width - env->turns;
        sum->mass = luminance(sum->color) * (FLOOR + (1 - FLOOR) * weight_at(job, u, v));
    }
}

/* Turns sums of cells into sums of all cells up to a corner. */
static void accumulate(const table_job* job) {
    const size_t row = (size_t)job->size[0] + 1;
    for (size_t i = 0; i < row; ++i) job->sums[i] = (light_sum){.mass = 0};
    for (int32_t y = 1; y <= job->size[1]; ++y) {
        light_sum* at = job->sums + row * (size_t)y;
        light_sum along = at[0] = (light_sum){.mass = 0};
        for (size_t x = 1; x < row; ++x) {
            along = sum_up(along, &at[x], 1);
            at[x] = sum_up(along, &at[x - row], 1);
        }
    }
}

static light_sum sum_of(const table_job* job, const int32_t from[2], const int32_t to[2]) {
    const size_t row = (size_t)job->size[0] + 1;
    const light_sum* top = job->sums + row * (size_t)from[1];
    const light_sum* bottom = job->sums + row * (size_t)to[1];
    const light_sum above = sum_up(top[to[0]], &top[from[0]], -1);
    return sum_up(sum_up(bottom[to[0]], &bottom[from[0]], -1), &above, -1);
}

/* ---- parts ---- */

/* Where a part is best cut: the lengths of the halves' mean vectors say how much light goes which way. Ties go to cuts
 * along the first axis, so that rounding does not decide. */
static void find_cut(const table_job* job, part* p) {
    const double bright = luminance(p->sum.color), whole = length_of(p->sum.flow);
    double best = whole + 1e-7 * bright;
    p->gain = 0;
    if (!(bright > job->dark)) return;
    for (int32_t axis = 0; axis < 2; ++axis) {
        const int32_t cells = p->to[axis] - p->from[axis], cuts = cells < CUTS ? cells : CUTS;
        for (int32_t i = 1; i < cuts; ++i) {
            int32_t to[2] = {p->to[0], p->to[1]};
            to[axis] = p->from[axis] + (int32_t)((int64_t)i * cells / cuts);
            const light_sum first = sum_of(job, p->from, to), second = sum_up(p->sum, &first, -1);
            const double kept = length_of(first.flow) + length_of(second.flow);
            if (!(kept > best)) continue;
            best = kept + 1e-7 * bright;
            p->gain = (kept - whole) * p->sum.mass / bright;
            p->axis = axis;
            p->cut = to[axis];
        }
    }
}

static void cut(const table_job* job, part* p, part* rest) {
    *rest = *p;
    p->to[p->axis] = rest->from[p->axis] = p->cut;
    p->sum = sum_of(job, p->from, p->to);
    rest->sum = sum_of(job, rest->from, rest->to);
    find_cut(job, p);
    find_cut(job, rest);
}

/* Cuts the part whose cut gains most, again and again. */
static int32_t cut_up(const table_job* job, part* parts, int32_t wanted) {
    int32_t count = 1;
    parts[0] = (part){.to = {job->size[0], job->size[1]}};
    parts[0].sum = sum_of(job, parts[0].from, parts[0].to);
    find_cut(job, &parts[0]);
    while (count < wanted) {
        part* best = &parts[0];
        for (int32_t i = 1; i < count; ++i)
            if (parts[i].gain > best->gain) best = &parts[i];
        if (!(best->gain > job->dark)) break;
        cut(job, best, &parts[count++]);
    }
    return count;
}

/* The table sums what lookups blend, or misses it between cells: the light's own mean is what counts. */
static void find_scale(const table_job* job, const light_sum* all, double scale[3]) {
    for (int c = 0; c < 3; ++c) {
        const double total = 4 * pi * (double)job->environment->constant[c];
        scale[c] = all->color[c] > 0 ? total / all->color[c] : 0;
    }
}

static ty_light_part part_of(const ty_scene* scene, const ty_environment_parts_def* def, int32_t light,
                             const light_sum* sum, const double scale[3]) {
    ty_light_part out = {.kind = TY_LIGHT_PART_PARALLEL, .light = light, .shadowed = scene->view.mesh != NULL};
    const double bright = luminance(sum->color), length = length_of(sum->flow);
    const double even = fmax(0, 1 - sum->solid_angle / (4 * pi)), own = fmin(1, length / bright);
    out.cosine = (float)pow(def->by_share ? even : own, def->prefilter);
    out.direction = scene->up == TY_AXIS_Z ? ty_vec_make(0, 0, -1) : ty_vec_make(0, -1, 0);
    for (int c = 0; c < 3; ++c) out.color[c] = (float)fmax(0, scale[c] * sum->color[c]);
    if (length > 1e-6 * bright)
        out.direction = ty_normalize(ty_vec_make((float)(-sum->flow[0] / length), (float)(-sum->flow[1] / length),
                                                 (float)(-sum->flow[2] / length)));
    return out;
}

static int32_t write_parts(const ty_scene* scene, int32_t light, table_job* job, part* parts, ty_light_part* out) {
    double scale[3];
    int32_t written = 0;
    accumulate(job);
    const light_sum* all = &job->sums[(size_t)(job->size[0] + 1) * (size_t)(job->size[1] + 1) - 1];
    job->dark = 1e-9 * luminance(all->color);
    const int32_t count = cut_up(job, parts, job->def->parts);
    find_scale(job, all, scale);
    for (int32_t i = 0; i < count; ++i)
        if (luminance(parts[i].sum.color) > job->dark)
            out[written++] = part_of(scene, job->def, light, &parts[i].sum, scale);
    return written;
}

ty_result ty_environment_parts(const ty_scene* scene, const ty_environment_parts_def* def, int32_t light,
                               ty_light_part* out, int32_t* count) {
    ty_context* context = scene->context;
    const ty_environment_view* environment = &scene->view.lights.lights[light].environment;
    table_job job = {.environment = environment,
                     .def = def,
                     .power = def->parts / (def->parts + FEW),
                     .size = {environment->cells_width, environment->cells_height}};
    const size_t corners = (size_t)(job.size[0] + 1) * (size_t)(job.size[1] + 1), wanted = (size_t)def->parts;
    job.shift = (int32_t)(ty_mix64(def->seed + ty_mix64((uint64_t)light + 1)) % (uint64_t)job.size[0]);
    job.sums = ty_alloc_array(context, corners, sizeof *job.sums, false);
    part* parts = ty_alloc_array(context, wanted, sizeof *parts, false);
    const bool enough = job.sums != NULL && parts != NULL;
    *count = 0;
    if (enough) {
        ty_parallel_flushed(context, job.size[1], sum_row, &job);
        *count = write_parts(scene, light, &job, parts, out);
    }
    ty_free_array(context, job.sums, corners, sizeof *job.sums);
    ty_free_array(context, parts, wanted, sizeof *parts);
    return enough ? TY_OK : TY_ERROR_MEMORY;
}
