/* Airlight of homogeneous media.
 *
 * A ray is split where it enters and leaves media. For a directional light it is split again where the face through
 * which the light entered a box changes: between such points the optical depth from the light is linear along the ray,
 * so that lit segments have a closed form. Local lights are integrated over the equiangular variable (Kulla and Fajardo
 * 2012), which cancels 1 / r^2, by Gauss-Legendre quadrature in a few panels. */
#include "method/lpv/image/airlight_ray.h"
#include "direct/shadow/shadow_hierarchy.k.h"
#include "direct/media/transmittance.k.h"

enum { PIECES_MAX = 2 * TY_SPANS_MAX, CUTS_MAX = 64, NODES = 4 };

static const float node[NODES] = {-0.861136312f, -0.339981044f, 0.339981044f, 0.861136312f};
static const float node_weight[NODES] = {0.173927423f, 0.326072577f, 0.326072577f, 0.173927423f};

/* An interval of the ray within the same media. */
typedef struct media_interval {
    float from, to;
    uint64_t media; /* one bit each */
    float extinction[3];
    float depth[3]; /* optical depth from the eye to its start */
} media_interval;

typedef struct airlight_ray {
    const ty_airlight* airlight;
    ty_vec origin, direction;
    media_interval intervals[PIECES_MAX]; /* up to the opaque depth */
    int32_t count;
    ty_airlight_sum* sum;
} airlight_ray;

/* Sorted distances at which the light's optical depth or intensity along the ray may have a kink. */
typedef struct kink_list {
    int32_t count;
    float at[CUTS_MAX];
} kink_list;

/* A lit part of an interval without a kink. */
typedef struct lit_segment {
    const media_interval* interval;
    float from, to;
    float weight[3]; /* fraction of the light scattered towards the eye per metre; for local lights without the phase
                        function */
} lit_segment;

static void add_kink(kink_list* kinks, float from, float to, float t) {
    if (!(t > from && t < to) || kinks->count == CUTS_MAX) return;
    int32_t at = kinks->count++;
    for (; at > 0 && kinks->at[at - 1] > t; --at) kinks->at[at] = kinks->at[at - 1];
    kinks->at[at] = t;
}

/* ---- media intervals ---- */

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

/* Finds the media intervals and the transmittance of the whole ray. */
static void find_media_intervals(airlight_ray* ray, float far) {
    const ty_scene_view* scene = ray->airlight->scene;
    ty_spans spans;
    float ends[2 * TY_SPANS_MAX], depth[3] = {0, 0, 0};
    ty_spans_find(scene->media, scene->medium_count, ray->origin, ray->direction, far, &spans);
    const int32_t count = sort_ends(&spans, ends);
    ray->count = 0;
    for (int32_t i = 1; i < count; ++i) {
        media_interval* interval = &ray->intervals[ray->count];
        *interval = (media_interval){.from = ends[i - 1], .to = ends[i]};
        if (!(interval->from < interval->to)) continue;
        interval->media = media_between(&spans, interval->from, interval->to);
        if (interval->media == 0) continue;
        memcpy(interval->depth, depth, sizeof depth);
        for (int32_t m = 0; m < scene->medium_count; ++m)
            for (int c = 0; c < 3 && (interval->media >> m & 1) != 0; ++c)
                interval->extinction[c] += scene->media[m].sigma_t[c];
        if (least3(depth) < TY_AIRLIGHT_OPAQUE) ++ray->count;
        for (int c = 0; c < 3; ++c) depth[c] += interval->extinction[c] * (ends[i] - ends[i - 1]);
    }
    for (int c = 0; c < 3; ++c) ray->sum->transmittance[c] = ty_attenuation(depth[c]);
}

/* Shortens the last interval to the opaque depth. */
static void clip_opaque(airlight_ray* ray) {
    if (ray->count == 0) return;
    media_interval* last = &ray->intervals[ray->count - 1];
    float visible_length = 0;
    for (int c = 0; c < 3; ++c)
        visible_length = ty_maxf(visible_length, last->extinction[c] > 0
                                                     ? (TY_AIRLIGHT_OPAQUE - last->depth[c]) / last->extinction[c]
                                                     : TY_FLOAT_MAX);
    last->to = ty_minf(last->to, last->from + visible_length);
}

/* Scattering coefficient times phase function of an interval at cosine mu. */
static void scattered_in(const airlight_ray* ray, const media_interval* interval, float mu, float out[3]) {
    const ty_scene_view* scene = ray->airlight->scene;
    out[0] = out[1] = out[2] = 0;
    for (int32_t m = 0; m < scene->medium_count; ++m) {
        if ((interval->media >> m & 1) == 0) continue;
        const ty_medium_view* medium = &scene->media[m];
        float phase[3];
        if (medium->phase != NULL) ty_phase_evaluate(medium->phase, ty_clampf(mu, -1, 1), phase);
        for (int c = 0; c < 3; ++c) {
            if (medium->phase == NULL) phase[c] = c > 0 && medium->gray_g != 0 ? phase[c - 1] : ty_hg(mu, medium->g[c]);
            out[c] += medium->sigma_s[c] * phase[c];
        }
    }
}

/* ---- lit segments ---- */

typedef struct lit_segments {
    int32_t count, next;
    const float (*at)[2];
} lit_segments;

/* Callback for each lit segment between two kinks. */
typedef void (*segment_fn)(const airlight_ray* ray, const void* user, const lit_segment* segment);

static void for_each_lit_segment(const airlight_ray* ray, const kink_list* kinks, lit_segments* lit,
                                 const media_interval* interval, segment_fn take, const void* user,
                                 lit_segment* segment) {
    segment->interval = interval;
    for (; lit->next < lit->count; ++lit->next) {
        const float end = ty_minf(lit->at[lit->next][1], interval->to);
        float t = ty_maxf(lit->at[lit->next][0], interval->from);
        for (int32_t i = 0; i <= kinks->count && t < end; ++i) {
            const float kink = i < kinks->count ? kinks->at[i] : end;
            if (kink <= t) continue;
            segment->from = t;
            segment->to = t = ty_minf(kink, end);
            take(ray, user, segment);
        }
        if (lit->at[lit->next][1] > interval->to) return;
    }
}

static void add_segment(const airlight_ray* ray, const lit_segment* segment, const float scattered[3],
                        const float light[3]) {
    for (int c = 0; c < 3; ++c) ray->sum->radiance[c] += scattered[c] * segment->weight[c] * light[c];
}

/* ---- directional lights ---- */

/* The path from the ray at t back to the light through a box: along each axis it leaves the box after leave + t slope
 * metres, and entered it `across` metres before. */
typedef struct sun_box {
    float leave[3], slope[3], across[3];
} sun_box;

typedef struct sun_paths {
    ty_vec back;
    int32_t curved; /* whether the optical depth may be nonlinear between kinks */
    int32_t boxes;
    sun_box box[TY_MEDIA_MAX];
    const ty_medium_view* of[TY_MEDIA_MAX];
} sun_paths;

/* Directions parallel to a face of a box are tilted by this much. */
#define BOX_SLANT 1e-7f

static void find_box(const airlight_ray* ray, ty_vec back, const ty_medium_view* medium, sun_box* box) {
    const ty_vec o = ty_map_point(medium->to_bounds, ray->origin);
    const ty_vec d = ty_map_direction(medium->to_bounds, ray->direction), e = ty_map_direction(medium->to_bounds, back);
    const float from[3] = {o.x, o.y, o.z}, direction[3] = {d.x, d.y, d.z}, up[3] = {e.x, e.y, e.z};
    const float slant = BOX_SLANT * sqrtf(ty_dot(e, e));
    for (int a = 0; a < 3; ++a) {
        const float along = fabsf(up[a]) < slant ? slant : up[a], inverse = 1.0f / along;
        box->leave[a] = (copysignf(1.0f, along) - from[a]) * inverse;
        box->slope[a] = -direction[a] * inverse;
        box->across[a] = 2.0f * fabsf(inverse);
    }
}

static float length_in(const sun_box* box, float t) {
    float leave[3], enter[3];
    for (int a = 0; a < 3; ++a) {
        leave[a] = box->leave[a] + t * box->slope[a];
        enter[a] = leave[a] - box->across[a];
    }
    return ty_maxf(0.0f, least3(leave) - ty_maxf(0.0f, greatest3(enter)));
}

/* Adds the kink where two linear functions of t are equal, given their difference value + t slope. */
static void add_crossing_kink(kink_list* kinks, const media_interval* first, const media_interval* last, float value,
                              float slope) {
    if (slope != 0) add_kink(kinks, first->from, last->to, -value / slope);
}

/* Adds the kinks where the entry or exit face of the path changes; inside the box only the entry face matters. */
static void add_box_kinks(const airlight_ray* ray, const sun_box* box, bool within, kink_list* kinks) {
    const media_interval *first = &ray->intervals[0], *last = &ray->intervals[ray->count - 1];
    for (int a = 0; a < 3; ++a) {
        const int b = (a + 1) % 3;
        const float value = box->leave[a] - box->leave[b], slope = box->slope[a] - box->slope[b];
        add_crossing_kink(kinks, first, last, value, slope);
        if (within) continue;
        add_crossing_kink(kinks, first, last, value - box->across[a] + box->across[b], slope);
        add_crossing_kink(kinks, first, last, value + box->across[b], slope);
        add_crossing_kink(kinks, first, last, value - box->across[a], slope);
        add_crossing_kink(kinks, first, last, box->leave[a], box->slope[a]);
        add_crossing_kink(kinks, first, last, box->leave[a] - box->across[a], box->slope[a]);
    }
}

static void find_sun(const airlight_ray* ray, const ty_light_view* light, sun_paths* sun, kink_list* kinks) {
    const ty_scene_view* scene = ray->airlight->scene;
    uint64_t throughout = ~(uint64_t)0;
    for (int32_t i = 0; i < ray->count; ++i) throughout &= ray->intervals[i].media;
    sun->back = ty_scale(light->direction, -1.0f);
    sun->curved = sun->boxes = 0;
    for (int32_t m = 0; m < scene->medium_count; ++m) {
        if ((ray->airlight->collide >> m & 1) == 0) continue;
        const ty_medium_view* medium = &scene->media[m];
        if (medium->bounds != TY_BOUNDED_BOX) {
            sun->curved = 1;
            continue;
        }
        sun->of[sun->boxes] = &ray->airlight->light_media[m];
        find_box(ray, sun->back, medium, &sun->box[sun->boxes]);
        add_box_kinks(ray, &sun->box[sun->boxes++], (throughout >> m & 1) != 0, kinks);
    }
}

/* Optical depth from the light to the ray at t through box-shaped media. */
static void depth_at(const sun_paths* sun, float t, float depth[3]) {
    depth[0] = depth[1] = depth[2] = 0;
    for (int32_t i = 0; i < sun->boxes; ++i) {
        const float length = length_in(&sun->box[i], t);
        for (int c = 0; c < 3; ++c) depth[c] += sun->of[i]->sigma_t[c] * length;
    }
}

/* Closed-form integral over a part with linear optical depth. */
static void take_linear(const airlight_ray* ray, const sun_paths* sun, const lit_segment* segment) {
    static const float one[3] = {1, 1, 1};
    const media_interval* interval = segment->interval;
    const float length = segment->to - segment->from;
    float first[3], second[3], light[3] = {0, 0, 0};
    /* Sampled inside the part, because faces of media may lie at its ends. */
    depth_at(sun, segment->from + 0.25f * length, first);
    depth_at(sun, segment->from + 0.75f * length, second);
    for (int c = 0; c < ray->airlight->channels; ++c) {
        const float before = interval->depth[c] + interval->extinction[c] * (segment->from - interval->from);
        const float slope = 2.0f * (second[c] - first[c]), start = ty_maxf(0.0f, first[c] - 0.25f * slope);
        const float change = slope + interval->extinction[c] * length, size = fabsf(change);
        light[c] = length * ty_attenuation(before + start + ty_minf(change, 0.0f)) *
                   ty_mean_attenuation(size, ty_attenuation(size));
    }
    for (int c = ray->airlight->channels; c < 3; ++c) light[c] = light[0];
    add_segment(ray, segment, one, light);
}

/* Quadrature over a part with nonlinear optical depth. */
static void take_curved(const airlight_ray* ray, const sun_paths* sun, const lit_segment* segment) {
    static const float one[3] = {1, 1, 1};
    const media_interval* interval = segment->interval;
    const ty_scene_view* scene = ray->airlight->scene;
    const int32_t panels = 1 + (int32_t)ty_minf(16.0f, greatest3(interval->extinction) * (segment->to - segment->from));
    const float size = (segment->to - segment->from) / (float)panels;
    float light[3] = {0, 0, 0};
    for (int32_t i = 0; i < panels * NODES; ++i) {
        const float t = segment->from + size * ((float)(i / NODES) + 0.5f + 0.5f * node[i % NODES]);
        float passing[3];
        ty_transmittance(ray->airlight->light_media, scene->medium_count, ty_mad(ray->origin, ray->direction, t),
                         sun->back, TY_FLOAT_MAX, NULL, passing);
        for (int c = 0; c < 3; ++c)
            light[c] += size * node_weight[i % NODES] * passing[c] *
                        ty_attenuation(interval->depth[c] + interval->extinction[c] * (t - interval->from));
    }
    add_segment(ray, segment, one, light);
}

static void take_sun(const airlight_ray* ray, const void* user, const lit_segment* segment) {
    const sun_paths* sun = user;
    if (sun->curved != 0)
        take_curved(ray, sun, segment);
    else
        take_linear(ray, sun, segment);
}

static void add_sun(const airlight_ray* ray, const ty_airlight_source* light, lit_segments lit) {
    kink_list kinks = {.count = 0};
    sun_paths sun;
    find_sun(ray, light->light, &sun, &kinks);
    const float mu = ty_dot(sun.back, ray->direction);
    for (int32_t i = 0; i < ray->count && lit.next < lit.count; ++i) {
        lit_segment segment;
        scattered_in(ray, &ray->intervals[i], mu, segment.weight);
        for (int c = 0; c < 3; ++c) segment.weight[c] *= light->light->color[c];
        for_each_lit_segment(ray, &kinks, &lit, &ray->intervals[i], take_sun, &sun, &segment);
    }
}

/* ---- local lights ---- */

/* Maximum optical depth of a panel along the ray; maximum angle of a panel, rad, and the same for spot lights, which
 * fade, and for lights outside the media, whose entry face changes. */
#define PANEL_DEPTH 2.5f
#define PANEL_ANGLE 1.0f
#define PANEL_ANGLE_NARROW 0.4f

typedef struct local_light {
    const ty_airlight_source* of;
    ty_closest_approach approach;
    float beside, along; /* components of a spot light's axis: towards the ray's closest point, and along the ray */
    float panel;         /* maximum angle, rad */
    float peak[2];       /* distance of the phase functions' pole from angle 0 in front of and behind the light, rad */
} local_light;

/* A quadrature panel [low, high], rad, of the angle between the ray and the direction to the light; sign -1 in front of
 * the closest point, 1 behind it. */
typedef struct quadrature_panel {
    float low, high, sign;
} quadrature_panel;

static void passing_to(const airlight_ray* ray, const local_light* local, const lit_segment* segment, float t,
                       float distance, float passing[3]) {
    const ty_scene_view* scene = ray->airlight->scene;
    const media_interval* interval = segment->interval;
    const bool simple = local->of->inside != 0 && (ray->airlight->collide & ~interval->media) == 0 &&
                        ray->airlight->light_media == scene->media;
    const float travelled = t - interval->from + (simple ? distance : 0.0f);
    for (int c = 0; c < ray->airlight->channels; ++c)
        passing[c] = ty_attenuation(interval->depth[c] + interval->extinction[c] * travelled);
    for (int c = ray->airlight->channels; c < 3; ++c) passing[c] = passing[0];
    if (simple) return;
    float from_light[3];
    const ty_vec off = ty_sub(ty_mad(ray->origin, ray->direction, t), local->of->light->position);
    const float length = ty_maxf(sqrtf(ty_dot(off, off)), 1e-30f);
    ty_transmittance(ray->airlight->light_media, scene->medium_count, local->of->light->position,
                     ty_scale(off, 1.0f / length), length, NULL, from_light);
    for (int c = 0; c < 3; ++c) passing[c] *= from_light[c];
}

static void take_panel(const airlight_ray* ray, const local_light* local, const lit_segment* segment,
                       const quadrature_panel* panel) {
    const float center = 0.5f * (panel->low + panel->high), half = 0.5f * (panel->high - panel->low);
    const ty_light_view* light = local->of->light;
    for (int i = 0; i < NODES; ++i) {
        float sine, cosine, scattered[3], passing[3];
        ty_sincos_2pi((center + half * node[i]) * (0.5f / TY_PI), &sine, &cosine);
        const float ahead = panel->sign * cosine, distance = local->approach.off / sine;
        const float t = ty_clampf(local->approach.nearest + ahead * distance, segment->from, segment->to);
        float weight = node_weight[i] * 2.0f * half / local->approach.off;
        if (light->kind == TY_KIND_SPOT) weight *= ty_spot_falloff(light, sine * local->beside + ahead * local->along);
        scattered_in(ray, segment->interval, -ahead, scattered);
        passing_to(ray, local, segment, t, distance, passing);
        for (int c = 0; c < 3; ++c) passing[c] *= weight;
        add_segment(ray, segment, scattered, passing);
    }
}

/* A part on one side of the closest point, between `near` and `far` metres from it, in panels narrower than the peak of
 * the phase functions. */
static void take_side(const airlight_ray* ray, const local_light* local, const lit_segment* segment, float near,
                      float far, float sign) {
    const float high = atan2f(local->approach.off, near), peak = local->peak[sign > 0];
    float low = atan2f(local->approach.off, far);
    while (low < high) {
        quadrature_panel panel = {.low = low, .sign = sign};
        panel.high = ty_minf(high, low + ty_minf(local->panel, 2.0f * (low + peak)));
        if (high - panel.high < 0.25f * (panel.high - low)) panel.high = high;
        take_panel(ray, local, segment, &panel);
        low = panel.high;
    }
}

static void integrate_local_light(const airlight_ray* ray, const void* user, const lit_segment* whole) {
    const local_light* local = user;
    const float nearest = local->approach.nearest,
                depth = greatest3(whole->interval->extinction) * (whole->to - whole->from);
    const int32_t count = 1 + (int32_t)ty_minf(depth * (1.0f / PANEL_DEPTH), 64.0f);
    for (int32_t i = 0; i < count; ++i) {
        lit_segment segment = *whole;
        segment.from = ty_lerpf(whole->from, whole->to, (float)i / (float)count);
        segment.to = ty_lerpf(whole->from, whole->to, (float)(i + 1) / (float)count);
        if (segment.from < nearest)
            take_side(ray, local, &segment, ty_maxf(0.0f, nearest - segment.to), nearest - segment.from, -1.0f);
        if (segment.to > nearest)
            take_side(ray, local, &segment, ty_maxf(0.0f, segment.from - nearest), segment.to - nearest, 1.0f);
    }
}

static void widen(float g, float max_g[2]) {
    max_g[0] = ty_maxf(max_g[0], g);
    max_g[1] = ty_maxf(max_g[1], -g);
}

/* The Henyey-Greenstein function of the angle has its pole at imaginary distance ln(1 / g). */
static void find_peaks(const ty_airlight* airlight, local_light* local) {
    float max_g[2] = {1e-3f, 1e-3f};
    for (int32_t m = 0; m < airlight->scene->medium_count; ++m) {
        const ty_medium_view* medium = &airlight->scene->media[m];
        for (int c = 0; c < 3; ++c) widen(medium->g[c], max_g);
        for (int32_t i = 0; medium->phase != NULL && i < medium->phase->count; ++i)
            widen(medium->phase->terms[i].g, max_g);
    }
    for (int i = 0; i < 2; ++i) local->peak[i] = -ty_logf(max_g[i]);
}

/* A spot light's intensity has kinks at its inner cone. */
static void add_spot_kinks(const airlight_ray* ray, const ty_light_view* light, kink_list* kinks) {
    const float from = ray->intervals[0].from, to = ray->intervals[ray->count - 1].to;
    ty_ray_interval segment = {from, to};
    if (!ty_ray_interval_clip_cone(light, light->cos_inner, ray->origin, ray->direction, &segment)) return;
    add_kink(kinks, from, to, segment.from);
    add_kink(kinks, from, to, segment.to);
}

static void add_local_light(const airlight_ray* ray, const ty_airlight_source* light, lit_segments lit) {
    kink_list kinks = {.count = 0};
    local_light local = {.of = light,
                         .approach = ty_closest_approach_to(light->light->position, ray->origin, ray->direction)};
    find_peaks(ray->airlight, &local);
    local.panel = light->inside != 0 ? PANEL_ANGLE : PANEL_ANGLE_NARROW;
    if (light->light->kind == TY_KIND_SPOT) {
        local.panel = PANEL_ANGLE_NARROW;
        const ty_vec nearest = ty_mad(ray->origin, ray->direction, local.approach.nearest);
        const ty_vec beside = ty_sub(nearest, light->light->position);
        local.along = ty_dot(ray->direction, light->light->direction);
        local.beside = ty_dot(beside, light->light->direction) / local.approach.off;
        add_spot_kinks(ray, light->light, &kinks);
    }
    lit_segment segment;
    memcpy(segment.weight, light->light->color, sizeof segment.weight);
    for (int32_t i = 0; i < ray->count && lit.next < lit.count; ++i)
        for_each_lit_segment(ray, &kinks, &lit, &ray->intervals[i], integrate_local_light, &local, &segment);
}

/* ---- all lights ---- */

/* Finds the lit segments of all rays for one light and integrates them. */
static void add_light(const airlight_ray* rays, int32_t count, const ty_airlight_source* light, ty_shadow_rays* lit) {
    lit->count = count;
    lit->origin = rays[0].origin;
    for (int32_t i = 0; i < count; ++i) {
        lit->direction[i] = rays[i].direction;
        lit->from[i] = rays[i].count > 0 ? rays[i].intervals[0].from : 0.0f;
        lit->to[i] = rays[i].count > 0 ? rays[i].intervals[rays[i].count - 1].to : 0.0f;
    }
    ty_shadow_lit_segments_of(light->map, lit);
    for (int32_t i = 0; i < count; ++i) {
        const lit_segments segments = {.count = lit->counts[i], .at = (const float(*)[2])lit->segments[i]};
        if (segments.count == 0) continue;
        if (light->light->kind == TY_KIND_DIRECTIONAL)
            add_sun(&rays[i], light, segments);
        else
            add_local_light(&rays[i], light, segments);
    }
}

void ty_airlight_homogeneous(const ty_airlight* airlight, ty_vec origin, const ty_eye_ray* rays, int32_t count,
                             ty_airlight_sum* sums) {
    airlight_ray own[TY_SHADOW_RAYS_MAX];
    ty_shadow_rays lit;
    bool any = false;
    for (int32_t i = 0; i < count; ++i) {
        own[i].airlight = airlight;
        own[i].origin = origin;
        own[i].direction = rays[i].direction;
        own[i].sum = &sums[i];
        find_media_intervals(&own[i], rays[i].far);
        clip_opaque(&own[i]);
        any = any || own[i].count > 0;
    }
    for (int32_t i = 0; i < airlight->count && any; ++i) add_light(own, count, &airlight->lights[i], &lit);
}
