/* Airlight of media on cells: steps of a cell, in which coefficients and the transmittance from lights are those
 * between the cells' middles; how much of a step is lit, how it is dimmed, and 1 / r^2 are exact. */
#include "direct/single/airlight_parts.h"
#include "direct/single/single.k.h"

/* A light and the stretches that it reaches. */
typedef struct cell_light {
    const ty_air_light* of;
    ty_air_pass pass;
    int32_t count, next;
    float at[TY_LIT_STRETCHES][2];
} cell_light;

typedef struct cell_march {
    const ty_airlight* airlight;
    ty_vec origin, direction;
    ty_vec cells, cells_way; /* in cells of the box */
    float depth[3];          /* so far */
    ty_air_sum* sum;
    cell_light lights[TY_AIR_LIGHTS_MAX];
} cell_march;

/* Media along a step. */
typedef struct cell_step {
    float from, to;
    ty_cell_point at;
    float extinction[3], scattering[3], g[3];
} cell_step;

static ty_vec to_cells(const ty_grid_medium* medium, ty_vec v, bool is_point) {
    const double* lower = medium->box.lower;
    const double* cell = medium->cell;
    const double at[3] = {(double)v.x, (double)v.y, (double)v.z};
    float out[3];
    for (int a = 0; a < 3; ++a) out[a] = (float)((at[a] - (is_point ? lower[a] : 0)) / cell[a]);
    return ty_vec_load(out);
}

/* The part of a ray in the box; false where it misses. */
static bool clip_to_box(const ty_grid_medium* medium, ty_vec cells, ty_vec way, float* from, float* to) {
    const int32_t* size = medium->box.size;
    return ty_clip_box(cells, way, ty_vec_make(0, 0, 0), ty_vec_make((float)size[0], (float)size[1], (float)size[2]),
                       from, to);
}

/* A plane's values for all channels. */
static void values_at(const ty_grid_medium* medium, float* const planes[3], const ty_cell_point* at, float out[3]) {
    for (int32_t c = 0; c < 3; ++c) out[c] = c < medium->planes ? ty_cell_value(planes[c], at) : out[0];
}

/* ---- one step ---- */

/* Wider parts of a step, rad as a lamp sees them, are taken in two. */
#define WIDEST 0.25f

/* Light that comes to a part of a step: what it is over color, m or 1/m, the cosine between its way and the ray, and
 * where it is in the middle. */
typedef struct part_light {
    float amount, along, middle, angle;
} part_light;

/* By the angle under which a lamp sees the part; the middle is that of the angle. */
static part_light find_lamp(const cell_march* march, const cell_light* light, float from, float to) {
    const ty_light_view* view = light->of->light;
    const float off = light->pass.off, a = from - light->pass.nearest, b = to - light->pass.nearest;
    const float per_a = 1.0f / sqrtf(a * a + off * off), per_b = 1.0f / sqrtf(b * b + off * off);
    const float ahead = a * per_a + b * per_b, beside = off * (per_a + per_b);
    part_light out;
    out.angle = atan2f(off * (to - from), off * off + a * b);
    out.amount = out.angle / off;
    out.along = ahead / sqrtf(ahead * ahead + beside * beside);
    out.middle = ty_clampf(light->pass.nearest + off * ahead / beside, from, to);
    if (view->kind != TY_KIND_SPOT) return out;
    const ty_vec way = ty_sub(ty_mad(march->origin, march->direction, out.middle), view->position);
    out.amount *= ty_spot_falloff(view, ty_dot(way, view->direction) / sqrtf(ty_maxf(ty_dot(way, way), 1e-30f)));
    return out;
}

static void add_lit(cell_march* march, const cell_light* light, const cell_step* step, float from, float to) {
    const ty_grid_medium* medium = march->airlight->medium;
    const ty_light_view* view = light->of->light;
    part_light part = {.amount = to - from, .along = ty_dot(view->direction, march->direction)};
    float passing[3], phase = 0;
    if (view->kind != TY_KIND_DIRECTIONAL) part = find_lamp(march, light, from, to);
    if (part.angle > WIDEST && part.middle > from && part.middle < to) {
        add_lit(march, light, step, from, part.middle);
        add_lit(march, light, step, part.middle, to);
        return;
    }
    values_at(medium, light->of->planes, &step->at, passing);
    for (int c = 0; c < 3; ++c) {
        const float before = march->depth[c] + step->extinction[c] * (from - step->from);
        const float within = step->extinction[c] * (to - from);
        if (c == 0 || step->g[c] != step->g[c - 1]) phase = ty_hg(-part.along, step->g[c]);
        march->sum->radiance[c] += view->color[c] * part.amount * step->scattering[c] * phase * passing[c] *
                                   ty_decay(before) * ty_mean_decay(within, ty_decay(within));
    }
}

static void add_stretches(cell_march* march, cell_light* light, const cell_step* step) {
    for (; light->next < light->count; ++light->next) {
        const float* at = light->at[light->next];
        const float from = ty_maxf(at[0], step->from), to = ty_minf(at[1], step->to);
        if (from < to) add_lit(march, light, step, from, to);
        if (at[1] > step->to) return;
    }
}

static void take_step(cell_march* march, float from, float to) {
    const ty_airlight* airlight = march->airlight;
    const ty_grid_medium* medium = airlight->medium;
    cell_step step = {.from = from, .to = to};
    step.at = ty_cell_locate(medium->box.size, ty_mad(march->cells, march->cells_way, 0.5f * (from + to)));
    values_at(medium, medium->extinction, &step.at, step.extinction);
    if (!(step.extinction[0] + step.extinction[1] + step.extinction[2] > 0)) return;
    values_at(medium, medium->scattering, &step.at, step.scattering);
    values_at(medium, medium->g, &step.at, step.g);
    for (int32_t i = 0; i < airlight->count; ++i) add_stretches(march, &march->lights[i], &step);
    for (int c = 0; c < 3; ++c) march->depth[c] += step.extinction[c] * (to - from);
}

/* ---- rays ---- */

static void find_lights(cell_march* march, float from, float to) {
    for (int32_t i = 0; i < march->airlight->count; ++i) {
        cell_light* light = &march->lights[i];
        light->of = &march->airlight->lights[i];
        light->pass = ty_air_pass_by(light->of->light->position, march->origin, march->direction);
        light->next = 0;
        light->count = ty_lit_stretches(light->of->map, march->origin, march->direction, from, to, light->at);
    }
}

void ty_air_cells(const ty_airlight* airlight, ty_vec origin, ty_vec direction, float far, float offset,
                  ty_air_sum* sum) {
    cell_march march;
    float from = 0, to = far;
    march.airlight = airlight;
    march.origin = origin;
    march.direction = direction;
    march.cells = to_cells(airlight->medium, origin, true);
    march.cells_way = to_cells(airlight->medium, direction, false);
    march.sum = sum;
    memset(march.depth, 0, sizeof march.depth);
    if (!clip_to_box(airlight->medium, march.cells, march.cells_way, &from, &to)) return;
    find_lights(&march, from, to);
    const ty_vec way = march.cells_way;
    const float size = 1.0f / ty_maxf(fabsf(way.x), ty_maxf(fabsf(way.y), fabsf(way.z)));
    float t = from;
    for (int32_t i = 0; t < to; ++i) {
        const float end = ty_minf(to, from + ((float)i + offset) * size);
        if (end > t) take_step(&march, t, end);
        t = ty_maxf(t, end);
        if (ty_minf(march.depth[0], ty_minf(march.depth[1], march.depth[2])) > TY_AIR_UNSEEN) break;
    }
    for (int c = 0; c < 3; ++c) sum->transmittance[c] = ty_decay(march.depth[c]);
}

/* ---- points ---- */

void ty_air_cells_reach(const ty_airlight* airlight, const ty_air_light* light, ty_vec point, float transmittance[3]) {
    const ty_grid_medium* medium = airlight->medium;
    const bool sun = light->light->kind == TY_KIND_DIRECTIONAL;
    const ty_vec back = sun ? ty_scale(light->light->direction, -1.0f) : ty_sub(light->light->position, point);
    ty_vec cells = to_cells(medium, point, true);
    const ty_vec way = to_cells(medium, back, false);
    float from = 0, to = sun ? TY_FLOAT_MAX : 1.0f;
    for (int c = 0; c < 3; ++c) transmittance[c] = 1;
    if (!clip_to_box(medium, cells, way, &from, &to)) return;
    /* What lies between a point outside and the box does not dim. */
    cells = ty_mad(cells, way, from);
    const ty_cell_point at = ty_cell_locate(medium->box.size, cells);
    values_at(medium, light->planes, &at, transmittance);
}
