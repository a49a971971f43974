/* Airlight of heterogeneous media on cells, in steps of one cell. Coefficients and the transmittance from the lights
 * are interpolated between cell centers; the lit part of a step, its attenuation and 1 / r^2 are exact. */
#include "method/lpv/image/airlight_ray.h"
#include "direct/single/single.k.h"

/* A light and the lit segments of the ray. */
typedef struct grid_light {
    const ty_airlight_source* of;
    ty_closest_approach approach;
    int32_t count, next;
    float at[TY_LIT_SEGMENTS_MAX][2];
} grid_light;

typedef struct grid_march {
    const ty_airlight* airlight;
    ty_vec origin, direction;
    ty_vec cells, cells_direction; /* in cell coordinates of the box */
    float depth[3];                /* optical depth so far */
    ty_airlight_sum* sum;
    grid_light lights[TY_AIRLIGHT_SOURCES_MAX];
} grid_march;

/* The media on a step. */
typedef struct grid_step {
    float from, to;
    ty_cell_point at;
    float extinction[3], scattering[3], g[3];
} grid_step;

static ty_vec to_cells(const ty_grid_medium* medium, ty_vec v, bool is_point) {
    const double* lower = medium->box.lower;
    const double* cell = medium->cell;
    const double at[3] = {(double)v.x, (double)v.y, (double)v.z};
    float out[3];
    for (int a = 0; a < 3; ++a) out[a] = (float)((at[a] - (is_point ? lower[a] : 0)) / cell[a]);
    return ty_vec_load(out);
}

/* The interval of a ray in the box; false if it misses. */
static bool clip_to_box(const ty_grid_medium* medium, ty_vec cells, ty_vec direction, float* from, float* to) {
    const int32_t* size = medium->box.size;
    return ty_clip_box(cells, direction, ty_vec_make(0, 0, 0),
                       ty_vec_make((float)size[0], (float)size[1], (float)size[2]), from, to);
}

/* Interpolated values of all channels. */
static void values_at(const ty_grid_medium* medium, float* const planes[3], const ty_cell_point* at, float out[3]) {
    for (int32_t c = 0; c < 3; ++c) out[c] = c < medium->planes ? ty_cell_value(planes[c], at) : out[0];
}

/* ---- one step ---- */

/* Angle, rad, under which a local light sees a part of a step; parts with a wider angle are split in two. */
#define WIDEST 0.25f

/* Light that reaches a part of a step: its integral along the ray per unit of color, m or 1/m, the cosine between its
 * direction and the ray, the distance of its mean, and the angle it subtends. */
typedef struct part_light {
    float amount, along, center, angle;
} part_light;

/* The integral of 1 / r^2 over the part is its angle seen from the light over the light's distance from the ray; the
 * mean is the bisector's. */
static part_light find_local_light(const grid_march* march, const grid_light* light, float from, float to) {
    const ty_light_view* view = light->of->light;
    const float off = light->approach.off, a = from - light->approach.nearest, b = to - light->approach.nearest;
    const float per_a = 1.0f / sqrtf(a * a + off * off), per_b = 1.0f / sqrtf(b * b + off * off);
    const float ahead = a * per_a + b * per_b, beside = off * (per_a + per_b);
    part_light out;
    out.angle = atan2f(off * (to - from), off * off + a * b);
    out.amount = out.angle / off;
    out.along = ahead / sqrtf(ahead * ahead + beside * beside);
    out.center = ty_clampf(light->approach.nearest + off * ahead / beside, from, to);
    if (view->kind != TY_KIND_SPOT) return out;
    const ty_vec from_light = ty_sub(ty_mad(march->origin, march->direction, out.center), view->position);
    out.amount *= ty_spot_falloff(view, ty_dot(from_light, view->direction) /
                                            sqrtf(ty_maxf(ty_dot(from_light, from_light), 1e-30f)));
    return out;
}

static void add_lit_part(grid_march* march, const grid_light* light, const grid_step* step, float from, float to) {
    const ty_grid_medium* medium = march->airlight->medium;
    const ty_light_view* view = light->of->light;
    part_light part = {.amount = to - from, .along = ty_dot(view->direction, march->direction)};
    float passing[3], phase = 0;
    if (view->kind != TY_KIND_DIRECTIONAL) part = find_local_light(march, light, from, to);
    if (part.angle > WIDEST && part.center > from && part.center < to) {
        add_lit_part(march, light, step, from, part.center);
        add_lit_part(march, light, step, part.center, to);
        return;
    }
    values_at(medium, light->of->planes, &step->at, passing);
    for (int c = 0; c < 3; ++c) {
        const float before = march->depth[c] + step->extinction[c] * (from - step->from);
        const float within = step->extinction[c] * (to - from);
        if (c == 0 || step->g[c] != step->g[c - 1]) phase = ty_hg(-part.along, step->g[c]);
        march->sum->radiance[c] += view->color[c] * part.amount * step->scattering[c] * phase * passing[c] *
                                   ty_attenuation(before) * ty_mean_attenuation(within, ty_attenuation(within));
    }
}

static void add_lit_segments(grid_march* march, grid_light* light, const grid_step* step) {
    for (; light->next < light->count; ++light->next) {
        const float* at = light->at[light->next];
        const float from = ty_maxf(at[0], step->from), to = ty_minf(at[1], step->to);
        if (from < to) add_lit_part(march, light, step, from, to);
        if (at[1] > step->to) return;
    }
}

static void take_step(grid_march* march, float from, float to) {
    const ty_airlight* airlight = march->airlight;
    const ty_grid_medium* medium = airlight->medium;
    grid_step step = {.from = from, .to = to};
    step.at = ty_cell_locate(medium->box.size, ty_mad(march->cells, march->cells_direction, 0.5f * (from + to)));
    values_at(medium, medium->extinction, &step.at, step.extinction);
    if (!(step.extinction[0] + step.extinction[1] + step.extinction[2] > 0)) return;
    values_at(medium, medium->scattering, &step.at, step.scattering);
    values_at(medium, medium->g, &step.at, step.g);
    for (int32_t i = 0; i < airlight->count; ++i) add_lit_segments(march, &march->lights[i], &step);
    for (int c = 0; c < 3; ++c) march->depth[c] += step.extinction[c] * (to - from);
}

/* ---- rays ---- */

static void find_lights(grid_march* march, float from, float to) {
    for (int32_t i = 0; i < march->airlight->count; ++i) {
        grid_light* light = &march->lights[i];
        light->of = &march->airlight->lights[i];
        light->approach = ty_closest_approach_to(light->of->light->position, march->origin, march->direction);
        light->next = 0;
        light->count = ty_shadow_lit_segments(light->of->map, march->origin, march->direction, from, to, light->at);
    }
}

void ty_airlight_heterogeneous(const ty_airlight* airlight, ty_vec origin, ty_vec direction, float far, float offset,
                               ty_airlight_sum* sum) {
    grid_march march;
    float from = 0, to = far;
    march.airlight = airlight;
    march.origin = origin;
    march.direction = direction;
    march.cells = to_cells(airlight->medium, origin, true);
    march.cells_direction = to_cells(airlight->medium, direction, false);
    march.sum = sum;
    memset(march.depth, 0, sizeof march.depth);
    if (!clip_to_box(airlight->medium, march.cells, march.cells_direction, &from, &to)) return;
    find_lights(&march, from, to);
    const ty_vec cells_direction = march.cells_direction;
    const float size =
        1.0f / ty_maxf(fabsf(cells_direction.x), ty_maxf(fabsf(cells_direction.y), fabsf(cells_direction.z)));
    float t = from;
    for (int32_t i = 0; t < to; ++i) {
        const float end = ty_minf(to, from + ((float)i + offset) * size);
        if (end > t) take_step(&march, t, end);
        t = ty_maxf(t, end);
        if (ty_minf(march.depth[0], ty_minf(march.depth[1], march.depth[2])) > TY_AIRLIGHT_OPAQUE) break;
    }
    for (int c = 0; c < 3; ++c) sum->transmittance[c] = ty_attenuation(march.depth[c]);
}

/* ---- points ---- */

void ty_airlight_heterogeneous_transmittance(const ty_airlight* airlight, const ty_airlight_source* light, ty_vec point,
                                             float transmittance[3]) {
    const ty_grid_medium* medium = airlight->medium;
    const bool sun = light->light->kind == TY_KIND_DIRECTIONAL;
    const ty_vec back = sun ? ty_scale(light->light->direction, -1.0f) : ty_sub(light->light->position, point);
    ty_vec cells = to_cells(medium, point, true);
    const ty_vec direction = to_cells(medium, back, false);
    float from = 0, to = sun ? TY_FLOAT_MAX : 1.0f;
    for (int c = 0; c < 3; ++c) transmittance[c] = 1;
    if (!clip_to_box(medium, cells, direction, &from, &to)) return;
    /* The path between the box and a point outside it is vacuum. */
    cells = ty_mad(cells, direction, from);
    const ty_cell_point at = ty_cell_locate(medium->box.size, cells);
    values_at(medium, light->planes, &at, transmittance);
}
