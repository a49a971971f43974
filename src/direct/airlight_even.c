/* Airlight of media that are the same everywhere within their bounds.
 *
 * A ray is cut where it enters and leaves media. In sunlight it is cut again where the side changes by which light came
 * into a box: between such places the optical depth from the sun is linear along the ray, so that lit stretches have a
 * closed form. Light of lamps is integrated over the angle under which the lamp is seen (Kulla and Fajardo 2012: the
 * 1 / r^2 cancels) by Gauss and Legendre's rule in a few panels. */
#include "direct/airlight_parts.h"
#include "direct/lit.k.h"
#include "direct/media/transmittance.k.h"

enum { PIECES_MAX = 2 * TY_SPANS_MAX, CUTS_MAX = 64, NODES = 4 };

static const float node[NODES] = {-0.861136312f, -0.339981044f, 0.339981044f, 0.861136312f};
static const float node_weight[NODES] = {0.173927423f, 0.326072577f, 0.326072577f, 0.173927423f};

/* A part of the ray in the same media. */
typedef struct air_piece {
    float from, to;
    uint64_t media; /* one bit each */
    float extinction[3];
    float depth[3]; /* from the eye to where it begins */
} air_piece;

typedef struct air_ray {
    const ty_airlight* airlight;
    ty_vec origin, direction;
    air_piece pieces[PIECES_MAX]; /* as far as anything is seen */
    int32_t count;
    ty_air_sum* sum;
} air_ray;

/* Where a light's depth or brightness along the ray may have a kink, in order. */
typedef struct air_cuts {
    int32_t count;
    float at[CUTS_MAX];
} air_cuts;

/* A lit part of a piece without a cut. */
typedef struct air_part {
    const air_piece* piece;
    float from, to;
    float weight[3]; /* what of the light goes towards the eye, per metre; of lamps without the phase function */
} air_part;

static void add_cut(air_cuts* cuts, float from, float to, float t) {
    if (!(t > from && t < to) || cuts->count == CUTS_MAX) return;
    int32_t at = cuts->count++;
    for (; at > 0 && cuts->at[at - 1] > t; --at) cuts->at[at] = cuts->at[at - 1];
    cuts->at[at] = t;
}

/* ---- pieces ---- */

static int32_t sort_ends(const ty_spans* spans, float ends[2 * TY_SPANS_MAX]) {
    int32_t count = 0;
    for (int32_t i = 0; i < 2 * spans->count; ++i) {
        const float end = i % 2 == 0 ? spans->enter[i / 2] : spans->leave[i / 2];
        int32_t at = count++;
        for (; at > 0 && ends[at - 1] > end; --at) ends[at] = ends[at - 1];
        ends[at] = end;
    }
    return count;
}

static uint64_t media_between(const ty_spans* spans, float from, float to) {
    uint64_t media = 0;
    for (int32_t i = 0; i < spans->count; ++i)
        if (spans->enter[i] <= from && spans->leave[i] >= to) media |= (uint64_t)1 << spans->medium[i];
    return media;
}

static float least3(const float values[3]) {
    return ty_minf(values[0], ty_minf(values[1], values[2]));
}

static float greatest3(const float values[3]) {
    return ty_maxf(values[0], ty_maxf(values[1], values[2]));
}

/* Finds the pieces, and the transmittance of them all. */
static void find_pieces(air_ray* ray, float far) {
    const ty_scene_view* scene = ray->airlight->scene;
    ty_spans spans;
    float ends[2 * TY_SPANS_MAX], depth[3] = {0, 0, 0};
    ty_spans_find(scene->media, scene->medium_count, ray->origin, ray->direction, far, &spans);
    const int32_t count = sort_ends(&spans, ends);
    ray->count = 0;
    for (int32_t i = 1; i < count; ++i) {
        air_piece* piece = &ray->pieces[ray->count];
        *piece = (air_piece){.from = ends[i - 1], .to = ends[i]};
        if (!(piece->from < piece->to)) continue;
        piece->media = media_between(&spans, piece->from, piece->to);
        if (piece->media == 0) continue;
        memcpy(piece->depth, depth, sizeof depth);
        for (int32_t m = 0; m < scene->medium_count; ++m)
            for (int c = 0; c < 3 && (piece->media >> m & 1) != 0; ++c)
                piece->extinction[c] += scene->media[m].sigma_t[c];
        if (least3(depth) < TY_AIR_UNSEEN) ++ray->count;
        for (int c = 0; c < 3; ++c) depth[c] += piece->extinction[c] * (ends[i] - ends[i - 1]);
    }
    for (int c = 0; c < 3; ++c) ray->sum->transmittance[c] = ty_decay(depth[c]);
}

/* Shortens the last piece to what is seen of it. */
static void leave_unseen(air_ray* ray) {
    if (ray->count == 0) return;
    air_piece* last = &ray->pieces[ray->count - 1];
    float seen = 0;
    for (int c = 0; c < 3; ++c)
        seen = ty_maxf(seen,
                       last->extinction[c] > 0 ? (TY_AIR_UNSEEN - last->depth[c]) / last->extinction[c] : TY_FLOAT_MAX);
    last->to = ty_minf(last->to, last->from + seen);
}

/* What a piece scatters of light that comes in at cosine mu. */
static void scattered_in(const air_ray* ray, const air_piece* piece, float mu, float out[3]) {
    const ty_scene_view* scene = ray->airlight->scene;
    out[0] = out[1] = out[2] = 0;
    for (int32_t m = 0; m < scene->medium_count; ++m) {
        if ((piece->media >> m & 1) == 0) continue;
        const ty_medium_view* medium = &scene->media[m];
        float phase = 0;
        for (int c = 0; c < 3; ++c) {
            if (c == 0 || medium->gray_g == 0) phase = ty_hg(mu, medium->g[c]);
            out[c] += medium->sigma_s[c] * phase;
        }
    }
}

/* ---- lit parts ---- */

typedef struct air_stretches {
    int32_t count, next;
    const float (*at)[2];
} air_stretches;

/* Calls for each lit part of each piece between cuts. */
typedef void (*part_fn)(const air_ray* ray, const void* user, const air_part* part);

static void each_lit(const air_ray* ray, const air_cuts* cuts, air_stretches* lit, const air_piece* piece, part_fn take,
                     const void* user, air_part* part) {
    part->piece = piece;
    for (; lit->next < lit->count; ++lit->next) {
        const float end = ty_minf(lit->at[lit->next][1], piece->to);
        float t = ty_maxf(lit->at[lit->next][0], piece->from);
        for (int32_t i = 0; i <= cuts->count && t < end; ++i) {
            const float cut = i < cuts->count ? cuts->at[i] : end;
            if (cut <= t) continue;
            part->from = t;
            part->to = t = ty_minf(cut, end);
            take(ray, user, part);
        }
        if (lit->at[lit->next][1] > piece->to) return;
    }
}

static void add_part(const air_ray* ray, const air_part* part, const float scattered[3], const float light[3]) {
    for (int c = 0; c < 3; ++c) ray->sum->radiance[c] += scattered[c] * part->weight[c] * light[c];
}

/* ---- sunlight ---- */

/* A box on the way back to the sun from where the ray is at t: along each axis it is left after leave + t slope
 * lengths, and was entered `across` before. */
typedef struct air_box {
    float leave[3], slope[3], across[3];
} air_box;

typedef struct air_sun {
    ty_vec back;
    int32_t curved; /* whether depth may not be linear between cuts */
    int32_t boxes;
    air_box box[TY_MEDIA_MAX];
    const ty_medium_view* of[TY_MEDIA_MAX];
} air_sun;

/* Ways that are along a side of a box are taken to be slanted a little. */
#define BOX_SLANT 1e-7f

static void find_box(const air_ray* ray, ty_vec back, const ty_medium_view* medium, air_box* box) {
    const ty_vec o = ty_map_point(medium->to_bounds, ray->origin);
    const ty_vec d = ty_map_direction(medium->to_bounds, ray->direction), e = ty_map_direction(medium->to_bounds, back);
    const float from[3] = {o.x, o.y, o.z}, way[3] = {d.x, d.y, d.z}, up[3] = {e.x, e.y, e.z};
    const float slant = BOX_SLANT * sqrtf(ty_dot(e, e));
    for (int a = 0; a < 3; ++a) {
        const float along = fabsf(up[a]) < slant ? slant : up[a], inverse = 1.0f / along;
        box->leave[a] = (copysignf(1.0f, along) - from[a]) * inverse;
        box->slope[a] = -way[a] * inverse;
        box->across[a] = 2.0f * fabsf(inverse);
    }
}

static float length_in(const air_box* box, float t) {
    float leave[3], enter[3];
    for (int a = 0; a < 3; ++a) {
        leave[a] = box->leave[a] + t * box->slope[a];
        enter[a] = leave[a] - box->across[a];
    }
    return ty_maxf(0.0f, least3(leave) - ty_maxf(0.0f, greatest3(enter)));
}

/* Where leave[a] + t slope[a] and a second such line meet. */
static void cut_where(air_cuts* cuts, const air_piece* first, const air_piece* last, float value, float slope) {
    if (slope != 0) add_cut(cuts, first->from, last->to, -value / slope);
}

/* Where it changes through which sides light comes to the ray; within the box all that counts is where it comes in. */
static void cut_box(const air_ray* ray, const air_box* box, bool within, air_cuts* cuts) {
    const air_piece *first = &ray->pieces[0], *last = &ray->pieces[ray->count - 1];
    for (int a = 0; a < 3; ++a) {
        const int b = (a + 1) % 3;
        const float value = box->leave[a] - box->leave[b], slope = box->slope[a] - box->slope[b];
        cut_where(cuts, first, last, value, slope);
        if (within) continue;
        cut_where(cuts, first, last, value - box->across[a] + box->across[b], slope);
        cut_where(cuts, first, last, value + box->across[b], slope);
        cut_where(cuts, first, last, value - box->across[a], slope);
        cut_where(cuts, first, last, box->leave[a], box->slope[a]);
        cut_where(cuts, first, last, box->leave[a] - box->across[a], box->slope[a]);
    }
}

static void find_sun(const air_ray* ray, const ty_light_view* light, air_sun* sun, air_cuts* cuts) {
    const ty_scene_view* scene = ray->airlight->scene;
    uint64_t throughout = ~(uint64_t)0;
    for (int32_t i = 0; i < ray->count; ++i) throughout &= ray->pieces[i].media;
    sun->back = ty_scale(light->direction, -1.0f);
    sun->curved = sun->boxes = 0;
    for (int32_t m = 0; m < scene->medium_count; ++m) {
        if ((ray->airlight->collide >> m & 1) == 0) continue;
        const ty_medium_view* medium = &scene->media[m];
        if (medium->bounds != TY_BOUNDED_BOX) {
            sun->curved = 1;
            continue;
        }
        sun->of[sun->boxes] = medium;
        find_box(ray, sun->back, medium, &sun->box[sun->boxes]);
        cut_box(ray, &sun->box[sun->boxes++], (throughout >> m & 1) != 0, cuts);
    }
}

/* Depth from the sun to the ray at t, if all media are boxes. */
static void depth_at(const air_sun* sun, float t, float depth[3]) {
    depth[0] = depth[1] = depth[2] = 0;
    for (int32_t i = 0; i < sun->boxes; ++i) {
        const float length = length_in(&sun->box[i], t);
        for (int c = 0; c < 3; ++c) depth[c] += sun->of[i]->sigma_t[c] * length;
    }
}

/* The integral over a part along which depths are linear. */
static void take_linear(const air_ray* ray, const air_sun* sun, const air_part* part) {
    static const float one[3] = {1, 1, 1};
    const air_piece* piece = part->piece;
    const float length = part->to - part->from;
    float first[3], second[3], light[3] = {0, 0, 0};
    /* Within, since media's sides may be at the ends. */
    depth_at(sun, part->from + 0.25f * length, first);
    depth_at(sun, part->from + 0.75f * length, second);
    for (int c = 0; c < ray->airlight->channels; ++c) {
        const float before = piece->depth[c] + piece->extinction[c] * (part->from - piece->from);
        const float slope = 2.0f * (second[c] - first[c]), start = ty_maxf(0.0f, first[c] - 0.25f * slope);
        const float change = slope + piece->extinction[c] * length, size = fabsf(change);
        light[c] = length * ty_decay(before + start + ty_minf(change, 0.0f)) * ty_mean_decay(size, ty_decay(size));
    }
    for (int c = ray->airlight->channels; c < 3; ++c) light[c] = light[0];
    add_part(ray, part, one, light);
}

/* The same where they are not. */
static void take_curved(const air_ray* ray, const air_sun* sun, const air_part* part) {
    static const float one[3] = {1, 1, 1};
    const air_piece* piece = part->piece;
    const ty_scene_view* scene = ray->airlight->scene;
    const int32_t panels = 1 + (int32_t)ty_minf(16.0f, greatest3(piece->extinction) * (part->to - part->from));
    const float size = (part->to - part->from) / (float)panels;
    float light[3] = {0, 0, 0};
    for (int32_t i = 0; i < panels * NODES; ++i) {
        const float t = part->from + size * ((float)(i / NODES) + 0.5f + 0.5f * node[i % NODES]);
        float passing[3];
        ty_transmittance(scene->media, scene->medium_count, ty_mad(ray->origin, ray->direction, t), sun->back,
                         TY_FLOAT_MAX, NULL, passing);
        for (int c = 0; c < 3; ++c)
            light[c] += size * node_weight[i % NODES] * passing[c] *
                        ty_decay(piece->depth[c] + piece->extinction[c] * (t - piece->from));
    }
    add_part(ray, part, one, light);
}

static void take_sun(const air_ray* ray, const void* user, const air_part* part) {
    const air_sun* sun = user;
    if (sun->curved != 0)
        take_curved(ray, sun, part);
    else
        take_linear(ray, sun, part);
}

static void add_sun(const air_ray* ray, const ty_air_light* light, air_stretches lit) {
    air_cuts cuts = {.count = 0};
    air_sun sun;
    find_sun(ray, light->light, &sun, &cuts);
    const float mu = ty_dot(sun.back, ray->direction);
    for (int32_t i = 0; i < ray->count && lit.next < lit.count; ++i) {
        air_part part;
        scattered_in(ray, &ray->pieces[i], mu, part.weight);
        for (int c = 0; c < 3; ++c) part.weight[c] *= light->light->color[c];
        each_lit(ray, &cuts, &lit, &ray->pieces[i], take_sun, &sun, &part);
    }
}

/* ---- lamps ---- */

/* Thickest panels, by optical depth along the ray; widest ones, rad, and where more changes than the way through one
 * medium: spots fade, and light from outside comes in by one side or another. */
#define PANEL_DEPTH 2.5f
#define PANEL_ANGLE 1.0f
#define PANEL_ANGLE_NARROW 0.4f

typedef struct air_lamp {
    const ty_air_light* of;
    ty_air_pass pass;
    float beside, along; /* of a spot's axis: towards the ray's nearest point, and along the ray */
    float panel;         /* widest, rad */
    float peak[2];       /* before and behind the lamp: how far off the angle 0 phase functions have a pole, rad */
} air_lamp;

/* The angle between the ray and the way to the lamp is where panels are: [low, high], rad, before the lamp (sign -1) or
 * behind it (1). */
typedef struct air_panel {
    float low, high, sign;
} air_panel;

static void passing_to(const air_ray* ray, const air_lamp* lamp, const air_part* part, float t, float distance,
                       float passing[3]) {
    const ty_scene_view* scene = ray->airlight->scene;
    const air_piece* piece = part->piece;
    const bool simple = lamp->of->inside != 0 && (ray->airlight->collide & ~piece->media) == 0;
    const float way = t - piece->from + (simple ? distance : 0.0f);
    for (int c = 0; c < ray->airlight->channels; ++c)
        passing[c] = ty_decay(piece->depth[c] + piece->extinction[c] * way);
    for (int c = ray->airlight->channels; c < 3; ++c) passing[c] = passing[0];
    if (simple) return;
    float from_lamp[3];
    const ty_vec off = ty_sub(ty_mad(ray->origin, ray->direction, t), lamp->of->light->position);
    const float length = ty_maxf(sqrtf(ty_dot(off, off)), 1e-30f);
    ty_transmittance(scene->media, scene->medium_count, lamp->of->light->position, ty_scale(off, 1.0f / length), length,
                     NULL, from_lamp);
    for (int c = 0; c < 3; ++c) passing[c] *= from_lamp[c];
}

static void take_panel(const air_ray* ray, const air_lamp* lamp, const air_part* part, const air_panel* panel) {
    const float middle = 0.5f * (panel->low + panel->high), half = 0.5f * (panel->high - panel->low);
    const ty_light_view* light = lamp->of->light;
    for (int i = 0; i < NODES; ++i) {
        float sine, cosine, scattered[3], passing[3];
        ty_sincos_2pi((middle + half * node[i]) * (0.5f / TY_PI), &sine, &cosine);
        const float ahead = panel->sign * cosine, distance = lamp->pass.off / sine;
        const float t = ty_clampf(lamp->pass.nearest + ahead * distance, part->from, part->to);
        float weight = node_weight[i] * 2.0f * half / lamp->pass.off;
        if (light->kind == TY_KIND_SPOT) weight *= ty_spot_falloff(light, sine * lamp->beside + ahead * lamp->along);
        scattered_in(ray, part->piece, -ahead, scattered);
        passing_to(ray, lamp, part, t, distance, passing);
        for (int c = 0; c < 3; ++c) passing[c] *= weight;
        add_part(ray, part, scattered, passing);
    }
}

/* A part on one side of the lamp, from `near` to `far` of its nearest point, in panels as narrow as phase functions are
 * peaked. */
static void take_side(const air_ray* ray, const air_lamp* lamp, const air_part* part, float near, float far,
                      float sign) {
    const float high = atan2f(lamp->pass.off, near), peak = lamp->peak[sign > 0];
    float low = atan2f(lamp->pass.off, far);
    while (low < high) {
        air_panel panel = {.low = low, .sign = sign};
        panel.high = ty_minf(high, low + ty_minf(lamp->panel, 2.0f * (low + peak)));
        if (high - panel.high < 0.25f * (panel.high - low)) panel.high = high;
        take_panel(ray, lamp, part, &panel);
        low = panel.high;
    }
}

static void take_lamp(const air_ray* ray, const void* user, const air_part* whole) {
    const air_lamp* lamp = user;
    const float nearest = lamp->pass.nearest, depth = greatest3(whole->piece->extinction) * (whole->to - whole->from);
    const int32_t count = 1 + (int32_t)ty_minf(depth * (1.0f / PANEL_DEPTH), 64.0f);
    for (int32_t i = 0; i < count; ++i) {
        air_part part = *whole;
        part.from = ty_lerpf(whole->from, whole->to, (float)i / (float)count);
        part.to = ty_lerpf(whole->from, whole->to, (float)(i + 1) / (float)count);
        if (part.from < nearest)
            take_side(ray, lamp, &part, ty_maxf(0.0f, nearest - part.to), nearest - part.from, -1.0f);
        if (part.to > nearest) take_side(ray, lamp, &part, ty_maxf(0.0f, part.from - nearest), part.to - nearest, 1.0f);
    }
}

/* Henyey-Greenstein's function of the angle has its pole ln(1 / g) off the real numbers. */
static void find_peaks(const ty_airlight* airlight, air_lamp* lamp) {
    float most[2] = {1e-3f, 1e-3f};
    for (int32_t m = 0; m < airlight->scene->medium_count; ++m)
        for (int c = 0; c < 3; ++c) {
            most[0] = ty_maxf(most[0], airlight->scene->media[m].g[c]);
            most[1] = ty_maxf(most[1], -airlight->scene->media[m].g[c]);
        }
    for (int i = 0; i < 2; ++i) lamp->peak[i] = -ty_logf(most[i]);
}

/* A spot fades from its inner cone on. */
static void cut_spot(const air_ray* ray, const ty_light_view* light, air_cuts* cuts) {
    const float from = ray->pieces[0].from, to = ray->pieces[ray->count - 1].to;
    ty_lit_part part = {from, to};
    if (!ty_lit_keep_cone(light, light->cos_inner, ray->origin, ray->direction, &part)) return;
    add_cut(cuts, from, to, part.from);
    add_cut(cuts, from, to, part.to);
}

static void add_lamp(const air_ray* ray, const ty_air_light* light, air_stretches lit) {
    air_cuts cuts = {.count = 0};
    air_lamp lamp = {.of = light, .pass = ty_air_pass_by(light->light->position, ray->origin, ray->direction)};
    find_peaks(ray->airlight, &lamp);
    lamp.panel = light->inside != 0 ? PANEL_ANGLE : PANEL_ANGLE_NARROW;
    if (light->light->kind == TY_KIND_SPOT) {
        lamp.panel = PANEL_ANGLE_NARROW;
        const ty_vec nearest = ty_mad(ray->origin, ray->direction, lamp.pass.nearest);
        const ty_vec beside = ty_sub(nearest, light->light->position);
        lamp.along = ty_dot(ray->direction, light->light->direction);
        lamp.beside = ty_dot(beside, light->light->direction) / lamp.pass.off;
        cut_spot(ray, light->light, &cuts);
    }
    air_part part;
    memcpy(part.weight, light->light->color, sizeof part.weight);
    for (int32_t i = 0; i < ray->count && lit.next < lit.count; ++i)
        each_lit(ray, &cuts, &lit, &ray->pieces[i], take_lamp, &lamp, &part);
}

/* ---- all ---- */

/* The stretches of all rays that a light reaches, and its light. */
static void add_light(const air_ray* rays, int32_t count, const ty_air_light* light, ty_lit_rays* lit) {
    lit->count = count;
    lit->origin = rays[0].origin;
    for (int32_t i = 0; i < count; ++i) {
        lit->direction[i] = rays[i].direction;
        lit->from[i] = rays[i].count > 0 ? rays[i].pieces[0].from : 0.0f;
        lit->to[i] = rays[i].count > 0 ? rays[i].pieces[rays[i].count - 1].to : 0.0f;
    }
    ty_lit_stretches_of(light->map, lit);
    for (int32_t i = 0; i < count; ++i) {
        const air_stretches stretches = {.count = lit->counts[i], .at = (const float(*)[2])lit->stretches[i]};
        if (stretches.count == 0) continue;
        if (light->light->kind == TY_KIND_DIRECTIONAL)
            add_sun(&rays[i], light, stretches);
        else
            add_lamp(&rays[i], light, stretches);
    }
}

void ty_air_even(const ty_airlight* airlight, ty_vec origin, const ty_air_ray* rays, int32_t count, ty_air_sum* sums) {
    air_ray own[TY_LIT_LINES];
    ty_lit_rays lit;
    bool any = false;
    for (int32_t i = 0; i < count; ++i) {
        own[i].airlight = airlight;
        own[i].origin = origin;
        own[i].direction = rays[i].direction;
        own[i].sum = &sums[i];
        find_pieces(&own[i], rays[i].far);
        leave_unseen(&own[i]);
        any = any || own[i].count > 0;
    }
    for (int32_t i = 0; i < airlight->count && any; ++i) add_light(own, count, &airlight->lights[i], &lit);
}
