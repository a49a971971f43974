/* Construction of the light tree: top down, with binned splits that minimise power times extent times the solid angle
 * of emission (surface area orientation heuristic; Conty Estevez and Kulla 2018). */
#include "scene/lights/light_tree.h"

#include "base/context.h"

enum { BINS = 12 };

/* Minimum power fraction of a light: products of such fractions, distances and cosines stay normal floats. */
static const double min_fraction = 1e-9;

/* ---- bounds of a light ---- */

static float mean_color(const ty_light_view* light) {
    return (light->color[0] + light->color[1] + light->color[2]) / 3;
}

static void bound_point(ty_light_bounds* bounds, ty_vec point) {
    bounds->lower = ty_vec_make(ty_minf(bounds->lower.x, point.x), ty_minf(bounds->lower.y, point.y),
                                ty_minf(bounds->lower.z, point.z));
    bounds->upper = ty_vec_make(ty_maxf(bounds->upper.x, point.x), ty_maxf(bounds->upper.y, point.y),
                                ty_maxf(bounds->upper.z, point.z));
}

static void bound_cone(const ty_light_view* light, ty_light_bounds* out) {
    out->axis = light->direction;
    out->cos_o = light->cos_inner;
    /* Cosine of outer - inner, the angle of the falloff. */
    out->cos_e =
        light->cos_inner * light->cos_outer + ty_light_sin_of(light->cos_inner) * ty_light_sin_of(light->cos_outer);
}

bool ty_light_get_bounds(const ty_light_view* light, ty_light_bounds* out) {
    *out = (ty_light_bounds){.lower = light->position,
                             .upper = light->position,
                             .power = mean_color(light),
                             .axis = {0, 0, 1},
                             .cos_o = -1,
                             .is_local = light->kind != TY_KIND_SPHERE};
    const ty_vec radius = ty_vec_make(light->radius, light->radius, light->radius);
    switch (light->kind) {
    case TY_KIND_POINT: break;
    case TY_KIND_SPOT: bound_cone(light, out); break;
    case TY_KIND_SPHERE:
        out->lower = ty_sub(light->position, radius);
        out->upper = ty_add(light->position, radius);
        out->power *= TY_PI * light->radius * light->radius;
        if (light->cone != 0) bound_cone(light, out);
        break;
    case TY_KIND_AREA:
    case TY_KIND_TRIANGLE:
        bound_point(out, ty_add(light->position, light->u));
        bound_point(out, ty_add(light->position, light->v));
        if (light->kind == TY_KIND_AREA) bound_point(out, ty_add(ty_add(light->position, light->u), light->v));
        out->power *= light->area;
        out->axis = light->direction;
        out->cos_o = light->two_sided != 0 ? -1.0f : 1.0f;
        break;
    default: out->power = 0;
    }
    return out->power > 0;
}

/* ---- cones ---- */

/* Directions within angle o of the axis, and emission up to e beyond them (radians). */
typedef struct cone {
    ty_vec axis;
    float o, e;
} cone;

static float angle_between(ty_vec a, ty_vec b) {
    return acosf(ty_clampf(ty_dot(a, b), -1, 1));
}

/* Rotates a towards b by an angle. */
static ty_vec rotate_towards(ty_vec a, ty_vec b, float angle) {
    ty_vec side = ty_mad(b, a, -ty_dot(a, b)), other;
    if (ty_dot(side, side) < 1e-12f)
        ty_onb(a, &side, &other);
    else
        side = ty_normalize(side);
    return ty_normalize(ty_mad(ty_scale(a, cosf(angle)), side, sinf(angle)));
}

static cone cone_union(cone a, cone b) {
    if (a.o < b.o) {
        const cone wide_cone = b;
        b = a;
        a = wide_cone;
    }
    a.e = ty_maxf(a.e, b.e);
    if (a.o >= TY_PI) return a;
    const float between = angle_between(a.axis, b.axis);
    if (between + b.o <= a.o) return a;
    const float o = 0.5f * (a.o + between + b.o);
    a.axis = o < TY_PI ? rotate_towards(a.axis, b.axis, o - a.o) : a.axis;
    a.o = ty_minf(o, TY_PI);
    return a;
}

/* Integral of the cosine falloff over all directions of emission of a cone, sr. */
static float cone_measure(cone c) {
    if (c.o >= TY_PI) return 4 * TY_PI;
    const float w = ty_minf(c.o + c.e, TY_PI), sine = sinf(c.o), cosine = cosf(c.o);
    return 2 * TY_PI * (1 - cosine) + 0.5f * TY_PI * (2 * (w - c.o) * sine - cosf(c.o - 2 * w) + cosine);
}

/* ---- clusters ---- */

typedef struct cluster {
    ty_vec lower, upper;
    cone cone;
    float power, local_power;
    int32_t count;
} cluster;

/* Union of two clusters except for its cone, which remains a's. */
static cluster cluster_join(const cluster* a, const cluster* b) {
    if (b->count == 0) return *a;
    cluster out = *a;
    out.power += b->power;
    out.local_power += b->local_power;
    out.count += b->count;
    out.lower =
        ty_vec_make(ty_minf(a->lower.x, b->lower.x), ty_minf(a->lower.y, b->lower.y), ty_minf(a->lower.z, b->lower.z));
    out.upper =
        ty_vec_make(ty_maxf(a->upper.x, b->upper.x), ty_maxf(a->upper.y, b->upper.y), ty_maxf(a->upper.z, b->upper.z));
    return out;
}

static cluster cluster_union(const cluster* a, const cluster* b) {
    if (a->count == 0) return *b;
    cluster out = cluster_join(a, b);
    if (b->count > 0) out.cone = cone_union(a->cone, b->cone);
    return out;
}

static const cluster no_cluster = {.lower = {TY_FLOAT_MAX, TY_FLOAT_MAX, TY_FLOAT_MAX},
                                   .upper = {-TY_FLOAT_MAX, -TY_FLOAT_MAX, -TY_FLOAT_MAX}};

/* Cost of a cluster: the noise it causes grows with power, size and solid angle of emission. The squared diagonal
 * measures the size, because a row of point lights has no surface area. */
static float cluster_cost(const cluster* c) {
    const ty_vec size = ty_sub(c->upper, c->lower);
    return c->power * ty_dot(size, size) * cone_measure(c->cone);
}

/* ---- splits ---- */

typedef struct builder {
    const cluster* lights; /* one light each */
    const int32_t* numbers;
    int32_t* order; /* permutation of lights: a cluster is a range of it */
    ty_light_tree* tree;
} builder;

static float component(ty_vec v, int axis) {
    return axis == 0 ? v.x : axis == 1 ? v.y : v.z;
}

/* Bins along an axis, by the centers of lights. */
typedef struct binning {
    int axis;
    float low, high;
} binning;

static float center_of(const cluster* light, int axis) {
    return 0.5f * component(light->lower, axis) + 0.5f * component(light->upper, axis);
}

static int bin_of(const binning* bins, const cluster* light) {
    const float x = (center_of(light, bins->axis) - bins->low) / (bins->high - bins->low);
    return (int)ty_clampf(x * BINS, 0, BINS - 1);
}

static binning find_binning(const builder* b, int32_t begin, int32_t end, int axis) {
    binning bins = {axis, TY_FLOAT_MAX, -TY_FLOAT_MAX};
    for (int32_t i = begin; i < end; ++i) {
        const float center = center_of(&b->lights[b->order[i]], axis);
        bins.low = ty_minf(bins.low, center);
        bins.high = ty_maxf(bins.high, center);
    }
    return bins;
}

/* Clusters per bin. Their cones, about the mean axis, serve for costs only: unions light by light would be many times
 * slower. */
static void fill_bins(const builder* b, int32_t begin, int32_t end, const binning* bins, cluster out[BINS]) {
    float min_cosine[BINS], max_opening[BINS];
    for (int i = 0; i < BINS; ++i) {
        out[i] = no_cluster;
        min_cosine[i] = 1;
        max_opening[i] = 0;
    }
    for (int32_t i = begin; i < end; ++i) {
        const cluster* light = &b->lights[b->order[i]];
        const int bin = bin_of(bins, light);
        out[bin] = cluster_join(&out[bin], light);
        out[bin].cone.axis = ty_add(out[bin].cone.axis, light->cone.axis);
        out[bin].cone.e = ty_maxf(out[bin].cone.e, light->cone.e);
        max_opening[bin] = ty_maxf(max_opening[bin], light->cone.o);
    }
    for (int i = 0; i < BINS; ++i) {
        const float length2 = ty_dot(out[i].cone.axis, out[i].cone.axis);
        if (length2 > 1e-6f)
            out[i].cone.axis = ty_scale(out[i].cone.axis, 1 / sqrtf(length2));
        else
            max_opening[i] = TY_PI;
    }
    for (int32_t i = begin; i < end; ++i) {
        const cluster* light = &b->lights[b->order[i]];
        const int bin = bin_of(bins, light);
        min_cosine[bin] = ty_minf(min_cosine[bin], ty_dot(out[bin].cone.axis, light->cone.axis));
    }
    for (int i = 0; i < BINS; ++i) out[i].cone.o = ty_minf(acosf(ty_maxf(min_cosine[i], -1)) + max_opening[i], TY_PI);
}

/* The cheapest split along an axis: its cost and the number of bins in the first half. */
static float cheapest_split(const cluster bins[BINS], int* first_bins, int32_t* larger) {
    float below[BINS], best = INFINITY;
    int32_t count[BINS];
    cluster sum = no_cluster;
    for (int i = 0; i < BINS; ++i) {
        sum = cluster_union(&sum, &bins[i]);
        below[i] = cluster_cost(&sum);
        count[i] = sum.count;
    }
    const int32_t all = sum.count;
    sum = no_cluster;
    for (int i = BINS - 1; i > 0; --i) {
        sum = cluster_union(&sum, &bins[i]);
        if (bins[i].count == 0 || count[i - 1] == 0) continue;
        const float cost = below[i - 1] + cluster_cost(&sum);
        if (cost >= best) continue;
        best = cost;
        *first_bins = i;
        *larger = sum.count > all - sum.count ? sum.count : all - sum.count;
    }
    return best;
}

/* Moves the lights of the first bins to the front; returns the start of the others. */
static int32_t partition(const builder* b, int32_t begin, int32_t end, const binning* bins, int first_bins) {
    int32_t boundary = begin;
    for (int32_t i = begin; i < end; ++i) {
        const int32_t light = b->order[i];
        if (bin_of(bins, &b->lights[light]) >= first_bins) continue;
        b->order[i] = b->order[boundary];
        b->order[boundary++] = light;
    }
    return boundary;
}

/* Minimum depth of a tree of `count` lights. */
static int min_depth(int32_t count) {
    int depth = 0;
    while (depth < 31 && (int64_t)1 << depth < count) ++depth;
    return depth;
}

/* Splits a range of lights in two, for children at this depth; in halves if no split is better or the depth is
 * exhausted. */
static int32_t split(const builder* b, int32_t begin, int32_t end, int depth) {
    const int32_t half = begin + (end - begin) / 2;
    if (end - begin == 2) return half;
    binning axes[3], best_bins = {0, 0, 0};
    float longest = 0, best = INFINITY;
    int best_first = 0;
    for (int a = 0; a < 3; ++a) {
        axes[a] = find_binning(b, begin, end, a);
        longest = ty_maxf(longest, axes[a].high - axes[a].low);
    }
    for (int a = 0; a < 3; ++a) {
        const float length = axes[a].high - axes[a].low;
        if (!(length > 0)) continue;
        cluster bins[BINS];
        int first_bins = 0;
        int32_t larger = 0;
        fill_bins(b, begin, end, &axes[a], bins);
        /* Penalty for thin slices. */
        const float cost = cheapest_split(bins, &first_bins, &larger) * (longest / length);
        if (!(cost < best) || min_depth(larger) + depth > TY_LIGHT_TREE_DEPTH) continue;
        best = cost;
        best_bins = axes[a];
        best_first = first_bins;
    }
    return best_first > 0 ? partition(b, begin, end, &best_bins, best_first) : half;
}

/* ---- construction ---- */

static ty_light_node node_of(const cluster* c, int32_t next) {
    ty_light_node node = {.center = ty_add(ty_scale(c->lower, 0.5f), ty_scale(c->upper, 0.5f)),
                          .half = ty_sub(ty_scale(c->upper, 0.5f), ty_scale(c->lower, 0.5f)),
                          .axis = c->cone.axis,
                          .cos_o = c->cone.o < TY_PI ? cosf(c->cone.o) : -1,
                          .sin_o = c->cone.o < TY_PI ? sinf(c->cone.o) : 0,
                          .cos_e = ty_maxf(cosf(c->cone.e), 0),
                          .power = c->power,
                          .local_power = c->local_power,
                          .next = next};
    if (next >= 0) {
        const float rounding = 2e-7f * (fabsf(node.center.x) + fabsf(node.center.y) + fabsf(node.center.z));
        node.half = ty_add(node.half, ty_vec_make(rounding, rounding, rounding));
    }
    node.radius2 = ty_dot(node.half, node.half);
    return node;
}

/* Builds the subtree of a range of lights, at a depth and with a trail; returns its cluster. */
static cluster build(builder* b, int32_t begin, int32_t end, int depth, uint64_t trail) {
    ty_light_tree* tree = b->tree;
    const size_t at = tree->node_count++;
    if (end - begin == 1) {
        const int32_t light = b->order[begin];
        tree->nodes[at] = node_of(&b->lights[light], ~b->numbers[light]);
        tree->trails[b->numbers[light]] = trail;
        return b->lights[light];
    }
    const int32_t boundary = split(b, begin, end, depth + 1);
    const cluster first = build(b, begin, boundary, depth + 1, trail);
    const int32_t next = (int32_t)tree->node_count;
    const cluster second = build(b, boundary, end, depth + 1, trail | (uint64_t)1 << depth);
    const cluster joined = cluster_union(&first, &second);
    tree->nodes[at] = node_of(&joined, next);
    return joined;
}

static cluster light_cluster(const ty_light_bounds* bounds, double power) {
    const float fraction = (float)fmax((double)bounds->power / power, min_fraction);
    return (cluster){.lower = bounds->lower,
                     .upper = bounds->upper,
                     .cone = {bounds->axis, bounds->cos_o > -1 ? acosf(ty_minf(bounds->cos_o, 1)) : TY_PI,
                              acosf(ty_clampf(bounds->cos_e, -1, 1))},
                     .power = fraction,
                     .local_power = bounds->is_local != 0 ? fraction : 0,
                     .count = 1};
}

/* Builds the tree over the lights with power, `placed` in number. */
static ty_result fill_tree(ty_context* context, const ty_light_bounds* bounds, size_t placed, ty_light_tree* tree) {
    cluster* lights = ty_alloc_array(context, placed, sizeof *lights, false);
    int32_t* numbers = ty_alloc_array(context, placed, 2 * sizeof *numbers, false);
    tree->nodes = ty_alloc_array(context, 2 * placed - 1, sizeof *tree->nodes, false);
    const bool allocated = lights != NULL && numbers != NULL && tree->nodes != NULL;
    if (!allocated) {
        ty_free_array(context, tree->nodes, 2 * placed - 1, sizeof *tree->nodes);
        tree->nodes = NULL;
    } else {
        builder b = {.lights = lights, .numbers = numbers, .order = numbers + placed, .tree = tree};
        double power = 0;
        for (size_t i = 0; i < tree->light_count; ++i) power += (double)bounds[i].power;
        size_t at = 0;
        for (size_t i = 0; i < tree->light_count; ++i) {
            if (!(bounds[i].power > 0)) continue;
            lights[at] = light_cluster(&bounds[i], power);
            numbers[at] = (int32_t)i;
            b.order[at] = (int32_t)at;
            ++at;
        }
        build(&b, 0, (int32_t)placed, 0, 0);
    }
    ty_free_array(context, lights, placed, sizeof *lights);
    ty_free_array(context, numbers, placed, 2 * sizeof *numbers);
    return allocated ? TY_OK : TY_ERROR_MEMORY;
}

ty_result ty_light_tree_create(ty_context* context, const ty_light_bounds* bounds, size_t count, ty_light_tree** out) {
    if (count > INT32_MAX / 2) return ty_fail(context, TY_ERROR_MEMORY, "lights: %zu are too many", count);
    ty_light_tree* tree = ty_alloc_array(context, 1, sizeof *tree, true);
    if (tree == NULL) return TY_ERROR_MEMORY;
    tree->light_count = count;
    tree->trails = ty_alloc_array(context, count, sizeof *tree->trails, false);
    size_t placed = 0;
    for (size_t i = 0; i < count && tree->trails != NULL; ++i) {
        tree->trails[i] = TY_LIGHT_NO_TRAIL;
        placed += bounds[i].power > 0;
    }
    ty_result result = tree->trails != NULL ? TY_OK : TY_ERROR_MEMORY;
    if (result == TY_OK && placed > 0) result = fill_tree(context, bounds, placed, tree);
    if (result != TY_OK) {
        ty_light_tree_destroy(context, tree);
        return result;
    }
    *out = tree;
    return TY_OK;
}

void ty_light_tree_destroy(ty_context* context, ty_light_tree* tree) {
    if (tree == NULL) return;
    ty_free_array(context, tree->nodes, tree->node_count, sizeof *tree->nodes);
    ty_free_array(context, tree->trails, tree->light_count, sizeof *tree->trails);
    ty_free_array(context, tree, 1, sizeof *tree);
}

size_t ty_light_tree_bytes(const ty_light_tree* tree) {
    return tree == NULL
               ? 0
               : sizeof *tree + tree->node_count * sizeof *tree->nodes + tree->light_count * sizeof *tree->trails;
}
