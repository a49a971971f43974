/* Modes published and collided: cells of an ordinate's grid pass their light on to their neighbours. */
#include "method/pop/slab.h"

#include "base/context.h"
#include "base/float_mode.h"
#include "method/pop/lobe.k.h"

#include <math.h>

enum { TY_POP_ITERATIONS_MAX = 10000 };

/* ---- sizes ---- */

/* Which band iteration m, from 1 on, is in. */
static int32_t band_of(int32_t m) {
    int32_t band = 0;
    while (band < TY_POP_BANDS - 1 && (1 << band) < m) ++band;
    return band;
}

size_t ty_pop_lobe_floats(const ty_pop_frame* frame, const ty_pop_def* def, int32_t planes, int32_t iterations) {
    const size_t bands = (size_t)band_of(iterations) + 1;
    const size_t arrays = def->mode == TY_POP_MODE_SPLIT ? 3 : 1 + 2 * bands;
    return (size_t)planes * arrays * ty_pop_cells(frame);
}

/* Slices have a ring of cells without medium around them, and cells of no meaning at the end, so that they begin where
 * vectors do. */
enum { LANES = 16 };

static size_t slice_floats(const ty_pop_frame* frame) {
    const size_t cells = ((size_t)frame->size[0] + 2) * ((size_t)frame->size[1] + 2);
    return (cells + LANES - 1) / LANES * LANES;
}

size_t ty_pop_scratch_floats(const ty_pop_frame* frame, const ty_pop_def* def, int32_t planes) {
    if (def->mode == TY_POP_MODE_SPLIT) return 0;
    const size_t slice = slice_floats(frame), slices = (size_t)frame->size[2];
    return slice * (slices * (TY_POP_WALK_PLANE_ARRAYS * (size_t)planes + TY_POP_WALK_ARRAYS) + TY_POP_WALK_SLICES);
}

/* ---- arrays ---- */

/* Of all cells, slices with a ring. */
typedef struct plane_arrays {
    float* light;             /* fluence not passed on yet, per color */
    float *pass[2], *keep[2]; /* ty_pop_half_cells */
    float* uncollided;
    float* again; /* mean cosine of what scatters towards the eye; 1: light is seen as it is (Eq. 8) */
} plane_arrays;

typedef struct walk {
    const ty_pop_grid_kernels* kernels;
    const ty_grid_medium* medium;
    ty_pop_light* light;
    ty_pop_mode mode;
    int32_t iterations, row;
    size_t slice, all; /* floats of a slice and of an array */
    plane_arrays planes[3];
    float *cosine, *fluence, *seen, *tilt;
    float* handed; /* slices of what is handed on (handed_by), and one of nothing */
    ty_pop_columns columns;
    ty_pop_slab slab;
    ty_pop_transmittance through;
    ty_pop_look look;
    float mean[3][TY_POP_BLOCK]; /* of each plane, in the slab */
} walk;

/* How far it is from a cell to the next beside it, as part of how far it is to the one in front. */
static float across_of(const ty_pop_frame* frame, int32_t k) {
    if (frame->kind == TY_LIGHT_PART_PARALLEL) return 0.5f * (frame->step.x + frame->step.y) / frame->step.z;
    return ty_pop_radius(frame, (float)k + 0.5f) * sqrtf(4 * TY_PI) / ((float)frame->size[0] * ty_pop_length(frame, k));
}

/* Whether cells are as good as cubes, so that factors are the same along and across. */
static bool is_cubic(const ty_pop_frame* frame) {
    return fabsf(across_of(frame, frame->size[2] / 2) - 1) < 0.01f;
}

static float* take_floats(float** next, size_t count) {
    float* floats = *next;
    *next += count;
    return floats;
}

static void lay_out(walk* w, float* scratch) {
    memset(scratch, 0,
           sizeof *scratch * (w->all * (TY_POP_WALK_PLANE_ARRAYS * (size_t)w->medium->planes + TY_POP_WALK_ARRAYS) +
                              w->slice * TY_POP_WALK_SLICES));
    for (int32_t p = 0; p < w->medium->planes; ++p) {
        plane_arrays* plane = &w->planes[p];
        float** const arrays[TY_POP_WALK_PLANE_ARRAYS] = {&plane->light,   &plane->pass[0], &plane->pass[1],
                                                          &plane->keep[0], &plane->keep[1], &plane->uncollided,
                                                          &plane->again};
        for (int a = 0; a < TY_POP_WALK_PLANE_ARRAYS; ++a) *arrays[a] = take_floats(&scratch, w->all);
        if (!is_cubic(&w->light->frame)) continue;
        plane->pass[1] = plane->pass[0];
        plane->keep[1] = plane->keep[0];
    }
    float** const shared[TY_POP_WALK_ARRAYS] = {&w->cosine, &w->fluence, &w->seen, &w->tilt};
    for (int a = 0; a < TY_POP_WALK_ARRAYS; ++a) *shared[a] = take_floats(&scratch, w->all);
    w->handed = scratch;
}

/* What slice k hands on is kept while others wait for it, three slices to the front, two to the sides and one to the
 * back: more of the rest stays in the caches. */
static ty_pop_handed handed_by(const walk* w, int32_t k) {
    enum { FRONTS = 3, SIDES = 2 };
    float *front = w->handed + 2 * w->slice * (size_t)(k % FRONTS), *sides = w->handed + 2 * FRONTS * w->slice;
    float *side = sides + 2 * w->slice * (size_t)(k % SIDES), *back = sides + 2 * SIDES * w->slice;
    return (ty_pop_handed){front, side, back, front + w->slice, side + w->slice, back + w->slice};
}

/* What comes from beyond the ends of the grid. */
static ty_pop_handed handed_by_nobody(const walk* w) {
    float* nothing = w->handed + (TY_POP_WALK_SLICES - 1) * w->slice;
    return (ty_pop_handed){nothing, nothing, nothing, nothing, nothing, nothing};
}

/* Where a row of cells is. */
static size_t place_of(const walk* w, int32_t j, int32_t k) {
    return w->slice * (size_t)k + (size_t)(w->row * (j + 1) + 1);
}

/* ---- what light starts from ---- */

/* The block's columns of slice k. */
static void store(const walk* w, const float* from, int32_t k, float* to) {
    const int32_t n = w->light->frame.size[0];
    for (int32_t i = 0; i < w->columns.count; i += n)
        memcpy(to + place_of(w, (w->columns.first + i) / n, k), from + i, (size_t)n * sizeof *to);
}

static void start_plane(walk* w, int32_t p, int32_t k) {
    const ty_pop_frame* frame = &w->light->frame;
    const plane_arrays* plane = &w->planes[p];
    ty_pop_start start;
    start.collided = w->mode == TY_POP_MODE_COLLIDED;
    start.plane = p;
    start.mean = w->mean[p];
    start.across = across_of(frame, k);
    w->kernels->start(&w->slab, &start);
    store(w, start.light, k, plane->light);
    store(w, start.again, k, plane->again);
    store(w, start.mean, k, plane->uncollided);
    for (int side = 0; side < (plane->pass[0] == plane->pass[1] ? 1 : 2); ++side) {
        store(w, start.pass[side], k, plane->pass[side]);
        store(w, start.keep[side], k, plane->keep[side]);
    }
}

static void start_columns(walk* w) {
    float tilt[TY_POP_BLOCK]; /* 2 (1 - mu) */
    const ty_pop_frame* frame = &w->light->frame;
    ty_pop_transmittance_begin(w->kernels, 1, &w->slab, &w->through);
    for (int32_t p = 0; p < w->medium->planes; ++p) w->through.mean[p][0] = w->mean[p];
    for (int32_t k = 0; k < frame->size[2]; ++k) {
        ty_pop_slab_enter(w->kernels, k, &w->slab);
        w->kernels->light(&w->slab);
        w->kernels->pass(&w->slab, &w->through);
        w->kernels->look(&w->slab, &w->look);
        for (int32_t i = 0; i < w->columns.count; ++i) tilt[i] = 2 * (1 - w->look.mu[i]);
        store(w, tilt, k, w->tilt);
        for (int32_t p = 0; p < w->medium->planes; ++p) start_plane(w, p, k);
    }
}

/* ---- iterations ---- */

/* What cells beyond the map's edges hand in is what lies there. */
static void wrap_side(const walk* w, float* side) {
    const int32_t n = w->light->frame.size[0], row = w->row;
    for (int32_t i = 0; i < n; ++i) {
        side[i + 1] = side[n - i + row];
        side[i + 1 + row * (n + 1)] = side[n - i + row * n];
        side[row * (i + 1)] = side[1 + row * (n - i)];
        side[n + 1 + row * (i + 1)] = side[n + row * (n - i)];
    }
}

static ty_pop_half_cells half_cells(const plane_arrays* plane, size_t at) {
    return (ty_pop_half_cells){{plane->pass[0] + at, plane->pass[1] + at}, {plane->keep[0] + at, plane->keep[1] + at}};
}

static void give_slice(const walk* w, const plane_arrays* plane, int32_t k) {
    const ty_pop_handed out = handed_by(w, k);
    const size_t at = w->slice * (size_t)k;
    const ty_pop_give give = {(int32_t)w->slice, half_cells(plane, at), plane->light + at, w->cosine + at, out};
    w->kernels->give(&give);
    if (w->light->frame.kind == TY_LIGHT_PART_PARALLEL) return;
    wrap_side(w, out.side);
    wrap_side(w, out.side_turned);
}

/* Whole vectors, about all rows but the first and last: what they read beyond a slice's sides is in arrays next to it,
 * and counts 0 times. */
static void take_slice(const walk* w, const plane_arrays* plane, int32_t k) {
    const size_t at = w->slice * (size_t)k;
    const int32_t end = w->row * (w->light->frame.size[1] + 1), last = w->light->frame.size[2] - 1;
    const ty_pop_take take = {.row = w->row,
                              .begin = w->row / LANES * LANES,
                              .end = (end + LANES - 1) / LANES * LANES,
                              .half = half_cells(plane, at),
                              .before = k > 0 ? handed_by(w, k - 1) : handed_by_nobody(w),
                              .beside = handed_by(w, k),
                              .after = k < last ? handed_by(w, k + 1) : handed_by_nobody(w),
                              .tilt = w->tilt + at,
                              .again = plane->again + at,
                              .light = plane->light + at,
                              .cosine = w->cosine + at,
                              .fluence = w->fluence + at,
                              .seen = w->seen + at};
    w->kernels->take(&take);
}

/* A slice takes once those around it have handed on what they had. */
static void iterate(const walk* w, const plane_arrays* plane) {
    give_slice(w, plane, 0);
    for (int32_t k = 0; k < w->light->frame.size[2]; ++k) {
        if (k + 1 < w->light->frame.size[2]) give_slice(w, plane, k + 1);
        take_slice(w, plane, k);
    }
}

/* ---- what comes of it ---- */

static float* lobe_array(const walk* w, int32_t p, int32_t number) {
    const size_t arrays = 1 + 2 * (size_t)w->light->bands;
    return w->light->lobes + ((size_t)p * arrays + (size_t)number) * ty_pop_cells(&w->light->frame);
}

static void copy_array(const walk* w, const float* from, float* to) {
    const int32_t* size = w->light->frame.size;
    for (int32_t row = 0; row < size[1] * size[2]; ++row, to += size[0])
        memcpy(to, from + place_of(w, row % size[1], row / size[1]), (size_t)size[0] * sizeof *to);
}

static void keep_band(const walk* w, int32_t p, int32_t band) {
    if (w->light->lobes == NULL) return;
    const int32_t* size = w->light->frame.size;
    float *passed = lobe_array(w, p, 1 + 2 * band), *turned = lobe_array(w, p, 2 + 2 * band);
    for (int32_t row = 0; row < size[1] * size[2]; ++row, passed += size[0], turned += size[0]) {
        const size_t at = place_of(w, row % size[1], row / size[1]);
        const float *light = w->planes[p].light + at, *cosine = w->cosine + at;
        for (int32_t i = 0; i < size[0]; ++i) {
            passed[i] += light[i];
            turned[i] += light[i] * cosine[i];
        }
    }
}

/* What a plane's light begins with. L_acc begins with 0 in mode published: what was in the cells before the first
 * iteration has not scattered. In mode collided it has, once, and is seen, and so is what has not. */
static void begin_plane(const walk* w, int32_t p) {
    const plane_arrays* plane = &w->planes[p];
    const bool collided = w->mode == TY_POP_MODE_COLLIDED;
    const ty_pop_begin begin = {.count = (int32_t)w->all,
                                .collided = collided,
                                .cosine = w->light->ordinate.cosine,
                                .uncollided = plane->uncollided,
                                .light = plane->light,
                                .again = plane->again,
                                .tilt = w->tilt,
                                .cosines = w->cosine,
                                .fluence = w->fluence,
                                .seen = w->seen};
    w->kernels->begin(&begin);
    if (w->light->lobes != NULL) copy_array(w, plane->uncollided, lobe_array(w, p, 0));
    if (collided) keep_band(w, p, 0);
}

/* A row of channel c's share of `seen`. */
static void write_row(const walk* w, int32_t c, size_t at, float* seen) {
    const ty_pop_light* light = w->light;
    const float* restrict left = w->planes[light->planes == 3 ? c : 0].light + at;
    const float* restrict radiance = w->seen + at, * restrict fluence = w->fluence + at;
    const float color = light->ordinate.color[c];
    float* restrict cell = seen + c;
    for (int32_t i = 0; i < light->frame.size[0]; ++i, cell += TY_POP_SEEN_LEFT) {
        cell[0] = color * radiance[i];
        cell[3] = color * fluence[i];
        cell[8] = color * left[i];
    }
}

static void end_plane(const walk* w, int32_t p) {
    const ty_pop_frame* frame = &w->light->frame;
    const int32_t ring = ty_pop_ring(frame), row = frame->size[0] + 2 * ring, end = w->light->planes == 3 ? p + 1 : 3;
    for (int32_t k = 0; k < frame->size[2]; ++k) {
        float* slab = ty_pop_seen_slab(w->light, k);
        for (int32_t j = 0; j < frame->size[1]; ++j)
            for (int32_t c = p; c < end; ++c)
                write_row(w, c, place_of(w, j, k), slab + (size_t)w->light->floats * (size_t)(ring + row * (j + ring)));
    }
}

/* Fluence times volume of what plane p has not passed on, over cells and the plane's channels. */
static double light_in(const walk* w, int32_t p) {
    const ty_pop_frame* frame = &w->light->frame;
    const float* color = w->light->ordinate.color;
    const double colors = w->light->planes == 3 ? (double)color[p] : (double)(color[0] + color[1] + color[2]);
    const double section = frame->kind == TY_LIGHT_PART_RADIAL
                               ? 4 * (double)TY_PI / ((double)frame->size[0] * frame->size[1])
                               : (double)frame->step.x * (double)frame->step.y;
    double sum = 0;
    for (int32_t k = 0; k < frame->size[2]; ++k) {
        const float* slice = w->planes[p].light + w->slice * (size_t)k;
        sum += (double)w->kernels->sum(slice, (int32_t)w->slice) * (double)ty_pop_length(frame, k);
    }
    return sum * section * colors;
}

static void walk_plane(walk* w, int32_t p, ty_pop_walk_stats* stats) {
    stats->entered += light_in(w, p);
    begin_plane(w, p);
    for (int32_t m = 1; m <= w->iterations; ++m) {
        iterate(w, &w->planes[p]);
        keep_band(w, p, band_of(m));
    }
    stats->left += light_in(w, p);
    end_plane(w, p);
}

static void begin_walk(const ty_scene* scene, const float eye[3], float* scratch, walk* w) {
    const ty_pop_frame* frame = &w->light->frame;
    w->row = frame->size[0] + 2;
    w->slice = slice_floats(frame);
    w->all = w->slice * (size_t)frame->size[2];
    lay_out(w, scratch);
    ty_pop_slab_setup(w->kernels, w->medium, &w->columns, &w->slab);
    ty_pop_look_setup(w->medium, eye, w->light, &w->look);
    for (int32_t first = 0; first < frame->size[0] * frame->size[1]; first += w->columns.count) {
        ty_pop_columns_begin(scene, w->medium, w->light, first, &w->columns);
        start_columns(w);
    }
}

/* Propagates L_i and a_i from cell to cell: Sec. 4.1 (Elek 2014). */
void ty_pop_walk(const ty_scene* scene, const ty_pop_def* def, const ty_grid_medium* medium, const float eye[3],
                 int32_t iterations, float* scratch, ty_pop_light* light, ty_pop_walk_stats* stats) {
    const double began = ty_wall_seconds();
    const unsigned state = ty_flush_denormals();
    walk w;
    w.kernels = ty_pop_grid_kernels_best();
    w.medium = medium;
    w.light = light;
    w.mode = def->mode;
    w.iterations = iterations;
    *stats = (ty_pop_walk_stats){0};
    light->mode = def->mode;
    light->planes = medium->planes;
    light->bands = band_of(iterations) + 1;
    memset(light->seen, 0, ty_pop_seen_floats(&light->frame, light->floats) * sizeof *light->seen);
    if (light->lobes != NULL)
        memset(light->lobes, 0,
               ty_pop_lobe_floats(&light->frame, def, light->planes, iterations) * sizeof *light->lobes);
    begin_walk(scene, eye, scratch, &w);
    stats->initial_seconds = ty_wall_seconds() - began;
    for (int32_t p = 0; p < medium->planes; ++p) walk_plane(&w, p, stats);
    ty_pop_fill_ring(light);
    stats->propagation_seconds = ty_wall_seconds() - began - stats->initial_seconds;
    ty_restore_denormals(state);
}

/* ---- how long ---- */

/* m' of Eq. 9 and 10 (Elek 2014), the larger of the coefficients'. */
int32_t ty_pop_walk_length(const ty_pop_def* def, const ty_grid_medium* medium, float cosine, float step) {
    double most = def->resolution;
    for (int32_t p = 0; p < medium->planes && def->residuum > 0; ++p) {
        double scattering = 0, turned = 0;
        size_t cells = 0;
        for (size_t i = 0; i < medium->cells; ++i) {
            const double sigma = (double)medium->scattering[p][i];
            scattering += sigma;
            turned += sigma * (double)medium->g[p][i];
            cells += sigma > 0 ? 1 : 0;
        }
        if (!(turned > 0)) continue;
        const double g = turned / scattering, per_metre = scattering / (double)cells;
        const double loss = def->mode == TY_POP_MODE_PUBLISHED ? -log(g) : 1 - g;
        const double iterations = (log((double)cosine) - log(def->residuum)) / (loss * per_metre * (double)step);
        if (iterations > most) most = iterations;
    }
    return (int32_t)fmin(ceil(most), TY_POP_ITERATIONS_MAX);
}
