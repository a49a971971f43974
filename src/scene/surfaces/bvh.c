/* Building of hierarchies by the binned surface area heuristic (Wald 2007), by one thread, so that a scene always has
 * the same one. */
#include "scene/surfaces/bvh.h"

#include "base/context.h"
#include "scene/surfaces/traced_shapes.h"

#include <string.h>

/* Primitives of a leaf at most, bins along an axis, and the level from which ranges are halved, so that the hierarchy
 * is no deeper than TY_BVH_DEPTH: 2^28 primitives have 26 further levels. */
enum { LEAF_MAX = 4, BINS = 16, HALVED_FROM = 18 };

static const size_t primitives_max = (size_t)1 << 28; /* of a scene, by the layout of ty_bvh_walk */

/* Time of a node's two boxes over that of a primitive. */
static const float node_cost = 1.0f;

typedef struct box {
    float low[3], high[3];
} box;

/* A range of primitives that becomes a node. */
typedef struct range {
    size_t first, count;
    int32_t node, level;
} range;

typedef struct build {
    ty_bvh_data* data;
    box* boxes;      /* by primitive */
    uint32_t* order; /* primitives as the leaves have them */
} build;

/* ---- primitives ---- */

static void set_corner(ty_bvh_primitive* p, int corner, const float* from) {
    for (int a = 0; a < 3; ++a) p->corner[corner][a] = from[a];
}

/* A quad is two triangles, cut along its second and fourth corner. */
static void add_quad_halves(ty_bvh_primitive* two, const float* corners, uint32_t quad) {
    static const size_t halves[2][3] = {{0, 1, 3}, {2, 3, 1}};
    for (int half = 0; half < 2; ++half) {
        two[half] = (ty_bvh_primitive){.kind = TY_BVH_QUAD, .element = quad};
        for (int corner = 0; corner < 3; ++corner) set_corner(&two[half], corner, corners + 3 * halves[half][corner]);
    }
}

static void add_triangles(ty_bvh_primitive* to, const ty_triangle_mesh* mesh, int32_t number) {
    for (size_t i = 0; i < mesh->triangle_count; ++i) {
        to[i] = (ty_bvh_primitive){.kind = TY_BVH_TRIANGLE, .mesh = number, .element = (uint32_t)i};
        for (int corner = 0; corner < 3; ++corner)
            set_corner(&to[i], corner, mesh->positions + 3 * (size_t)mesh->indices[3 * i + (size_t)corner]);
    }
}

static void bound_sphere(const ty_bvh_primitive* p, box* out) {
    for (int a = 0; a < 3; ++a) {
        out->low[a] = p->corner[0][a] - p->corner[1][0];
        out->high[a] = p->corner[0][a] + p->corner[1][0];
    }
}

static void bound_triangle(const ty_bvh_primitive* p, box* out) {
    for (int a = 0; a < 3; ++a) {
        out->low[a] = ty_minf(p->corner[0][a], ty_minf(p->corner[1][a], p->corner[2][a]));
        out->high[a] = ty_maxf(p->corner[0][a], ty_maxf(p->corner[1][a], p->corner[2][a]));
    }
}

/* Boxes of all primitives. closed: the mesh whose crossings are asked for, or NULL. */
static void bound_primitives(build* b, const ty_triangle_mesh* closed) {
    for (size_t i = 0; i < b->data->primitive_count; ++i) {
        const ty_bvh_primitive* p = &b->data->primitives[i];
        b->order[i] = (uint32_t)i;
        if (closed != NULL)
            ty_closed_triangle_bounds(closed, i, b->boxes[i].low, b->boxes[i].high);
        else if (p->kind == TY_BVH_SPHERE)
            bound_sphere(p, &b->boxes[i]);
        else
            bound_triangle(p, &b->boxes[i]);
    }
}

/* ---- boxes ---- */

static box empty_box(void) {
    return (box){{TY_FLOAT_MAX, TY_FLOAT_MAX, TY_FLOAT_MAX}, {-TY_FLOAT_MAX, -TY_FLOAT_MAX, -TY_FLOAT_MAX}};
}

static void grow(box* all, const box* one) {
    for (int a = 0; a < 3; ++a) {
        all->low[a] = ty_minf(all->low[a], one->low[a]);
        all->high[a] = ty_maxf(all->high[a], one->high[a]);
    }
}

/* Half of the surface; 0 for an empty box. */
static float half_area(const box* b) {
    const float x = b->high[0] - b->low[0], y = b->high[1] - b->low[1], z = b->high[2] - b->low[2];
    return x >= 0.0f ? x * y + y * z + z * x : 0.0f;
}

/* Twice the center. */
static float center(const box* b, int axis) {
    return b->low[axis] + b->high[axis];
}

static box range_box(const build* b, size_t first, size_t count) {
    box all = empty_box();
    for (size_t i = first; i < first + count; ++i) grow(&all, &b->boxes[b->order[i]]);
    return all;
}

/* ---- splits ---- */

/* A plane between two bins of centers along an axis. */
typedef struct split {
    int axis, bin; /* the last bin before it; axis -1: none */
    float low, scale, cost;
} split;

static int bin_of(const split* s, const box* b) {
    const int bin = (int)((center(b, s->axis) - s->low) * s->scale);
    return bin < BINS - 1 ? bin : BINS - 1;
}

/* Improves *best by the planes along one axis. cost: area times primitives on both sides. */
static void try_axis(const build* b, const range* r, int axis, float low, float high, split* best) {
    split s = {.axis = axis, .low = low, .scale = (float)BINS / (high - low)};
    box boxes[BINS], left = empty_box(), right = empty_box();
    size_t counts[BINS] = {0}, before = 0;
    float after_cost[BINS];
    if (!(high > low) || !(high - low < TY_FLOAT_MAX) || !(s.scale < TY_FLOAT_MAX)) return;
    for (int i = 0; i < BINS; ++i) boxes[i] = empty_box();
    for (size_t i = r->first; i < r->first + r->count; ++i) {
        const box* one = &b->boxes[b->order[i]];
        const int bin = bin_of(&s, one);
        ++counts[bin];
        grow(&boxes[bin], one);
    }
    size_t after = 0;
    for (int i = BINS - 1; i > 0; --i) {
        grow(&right, &boxes[i]);
        after += counts[i];
        after_cost[i] = half_area(&right) * (float)after;
    }
    for (int i = 0; i < BINS - 1; ++i) {
        grow(&left, &boxes[i]);
        before += counts[i];
        s.bin = i;
        s.cost = half_area(&left) * (float)before + after_cost[i + 1];
        if (before > 0 && before < r->count && (best->axis < 0 || s.cost < best->cost)) *best = s;
    }
}

static split find_split(const build* b, const range* r) {
    split best = {.axis = -1};
    box centers = empty_box();
    for (size_t i = r->first; i < r->first + r->count; ++i) {
        const box* one = &b->boxes[b->order[i]];
        for (int a = 0; a < 3; ++a) {
            centers.low[a] = ty_minf(centers.low[a], center(one, a));
            centers.high[a] = ty_maxf(centers.high[a], center(one, a));
        }
    }
    for (int a = 0; a < 3; ++a) try_axis(b, r, a, centers.low[a], centers.high[a], &best);
    return best;
}

/* Orders a range by the sides of a plane; returns the primitives before it. */
static size_t partition(build* b, const range* r, const split* s) {
    size_t front = r->first, back = r->first + r->count;
    while (front < back) {
        if (bin_of(s, &b->boxes[b->order[front]]) <= s->bin) {
            ++front;
            continue;
        }
        const uint32_t other = b->order[--back];
        b->order[back] = b->order[front];
        b->order[front] = other;
    }
    return front - r->first;
}

/* Primitives of a range's first part; 0: it is a leaf. */
static size_t divide(build* b, const range* r, const box* all) {
    if (r->count == 1) return 0;
    const split s = r->level < HALVED_FROM ? find_split(b, r) : (split){.axis = -1};
    const bool small = r->count <= LEAF_MAX;
    if (s.axis < 0) return small ? 0 : r->count / 2;
    if (small && node_cost * half_area(all) + s.cost >= half_area(all) * (float)r->count) return 0;
    return partition(b, r, &s);
}

/* ---- nodes ---- */

/* Sets a child of a node: a leaf, or an inner node whose range is *r then, with true. */
static bool set_child(build* b, int32_t node, int32_t i, range* r, size_t* first_part) {
    ty_bvh_data* data = b->data;
    const box all = range_box(b, r->first, r->count);
    ty_bvh_node* out = &data->nodes[node];
    memcpy(out->lower[i], all.low, sizeof all.low);
    memcpy(out->upper[i], all.high, sizeof all.high);
    *first_part = divide(b, r, &all);
    if (*first_part == 0) {
        out->child[i] = (int32_t)r->first;
        out->count[i] = (int32_t)r->count;
        return false;
    }
    r->node = (int32_t)data->node_count++;
    out->child[i] = r->node;
    out->count[i] = 0;
    return true;
}

/* A range in two parts, for the two children of a node. */
typedef struct parted_range {
    range r;
    size_t first_part;
} parted_range;

/* Divides ranges from the whole one on, depth first. */
static void divide_all(build* b) {
    parted_range todo[TY_BVH_DEPTH + 2];
    int32_t size = 0;
    range whole = {.count = b->data->primitive_count};
    size_t first_part = 0;
    b->data->node_count = 1;
    /* The root has the whole range as its one child, below which there may be nodes. */
    b->data->nodes[0].count[1] = -1;
    if (set_child(b, 0, 0, &whole, &first_part)) todo[size++] = (parted_range){whole, first_part};
    while (size > 0) {
        const parted_range from = todo[--size];
        for (int32_t i = 0; i < 2; ++i) {
            range child = {.level = from.r.level + 1};
            child.first = i == 0 ? from.r.first : from.r.first + from.first_part;
            child.count = i == 0 ? from.first_part : from.r.count - from.first_part;
            if (set_child(b, from.r.node, i, &child, &first_part)) todo[size++] = (parted_range){child, first_part};
        }
    }
}

/* Builds the hierarchy over data->primitives, and puts them in the order of the leaves. */
static ty_result build_hierarchy(ty_bvh_data* data, const ty_triangle_mesh* closed) {
    ty_context* context = data->context;
    const size_t count = data->primitive_count;
    build b = {.data = data};
    b.boxes = ty_alloc_array(context, count, sizeof *b.boxes, false);
    b.order = ty_alloc_array(context, count, sizeof *b.order, false);
    ty_bvh_primitive* ordered = ty_alloc_array(context, count, sizeof *ordered, false);
    data->node_capacity = count + 1;
    data->nodes = ty_alloc_array(context, data->node_capacity, sizeof *data->nodes, true);
    const bool done = b.boxes != NULL && b.order != NULL && ordered != NULL && data->nodes != NULL;
    if (done) {
        bound_primitives(&b, closed);
        divide_all(&b);
        for (size_t i = 0; i < count; ++i) ordered[i] = data->primitives[b.order[i]];
        ty_free_array(context, data->primitives, count, sizeof *data->primitives);
        data->primitives = ordered;
        data->bvh.nodes = data->nodes;
        data->bvh.primitives = data->primitives;
    } else {
        ty_free_array(context, ordered, count, sizeof *ordered);
    }
    ty_free_array(context, b.boxes, count, sizeof *b.boxes);
    ty_free_array(context, b.order, count, sizeof *b.order);
    return done ? TY_OK : TY_ERROR_MEMORY;
}

static ty_result finish(ty_bvh_data* data, ty_result result, ty_bvh_data** out) {
    if (result == TY_OK)
        *out = data;
    else
        ty_bvh_destroy(data);
    return result;
}

/* Quads, spheres and triangles, one after another. */
static ty_result take_input(ty_bvh_data* data, const ty_accel_input* input) {
    ty_context* context = data->context;
    data->quad_count = ty_traced_quad_count(input->shapes, input->shape_count);
    data->sphere_count = ty_traced_sphere_count(input->shapes, input->shape_count);
    data->primitive_count = 2 * data->quad_count + data->sphere_count;
    for (size_t i = 0; i < input->mesh_count; ++i) data->primitive_count += input->meshes[i]->triangle_count;
    if (data->primitive_count > primitives_max)
        return ty_fail(context, TY_ERROR_UNSUPPORTED, "a device takes no scene of %zu triangles",
                       data->primitive_count);
    data->primitives = ty_alloc_array(context, data->primitive_count, sizeof *data->primitives, false);
    data->quads = ty_alloc_array(context, data->quad_count, sizeof *data->quads, false);
    data->spheres = ty_alloc_array(context, data->sphere_count, sizeof *data->spheres, false);
    const size_t numbers = 12 * data->quad_count + 4 * data->sphere_count;
    float* places = ty_alloc_array(context, numbers, sizeof *places, false);
    const bool done = data->primitives != NULL && data->quads != NULL && data->spheres != NULL && places != NULL;
    if (done) {
        float* points = places + 12 * data->quad_count;
        ty_bvh_primitive* at = data->primitives;
        ty_traced_quads(input->shapes, input->shape_count, data->quads, places);
        ty_traced_spheres(input->shapes, input->shape_count, data->spheres, points);
        for (size_t q = 0; q < data->quad_count; ++q, at += 2) add_quad_halves(at, places + 12 * q, (uint32_t)q);
        for (size_t s = 0; s < data->sphere_count; ++s, ++at) {
            *at = (ty_bvh_primitive){.kind = TY_BVH_SPHERE, .element = (uint32_t)s};
            set_corner(at, 0, points + 4 * s);
            at->corner[1][0] = points[4 * s + 3];
        }
        for (size_t i = 0; i < input->mesh_count; at += input->meshes[i++]->triangle_count)
            add_triangles(at, input->meshes[i], (int32_t)i);
    }
    ty_free_array(context, places, numbers, sizeof *places);
    return done ? TY_OK : TY_ERROR_MEMORY;
}

ty_result ty_bvh_create(ty_context* context, const ty_accel_input* input, ty_bvh_data** out) {
    *out = NULL;
    if (input->shape_count + input->mesh_count == 0) return TY_OK;
    ty_bvh_data* data = ty_alloc_array(context, 1, sizeof *data, true);
    if (data == NULL) return TY_ERROR_MEMORY;
    data->context = context;
    ty_result result = take_input(data, input);
    if (result == TY_OK) result = build_hierarchy(data, NULL);
    data->bvh.quads = data->quads;
    data->bvh.spheres = data->spheres;
    data->bvh.surfaces = input->surfaces + input->shape_count;
    data->bvh.first_mesh = (int32_t)input->shape_count;
    return finish(data, result, out);
}

ty_result ty_bvh_create_closed(ty_context* context, const ty_triangle_mesh* triangles, ty_bvh_data** out) {
    *out = NULL;
    ty_bvh_data* data = ty_alloc_array(context, 1, sizeof *data, true);
    if (data == NULL) return TY_ERROR_MEMORY;
    data->context = context;
    data->primitive_count = triangles->triangle_count;
    data->primitives = ty_alloc_array(context, data->primitive_count, sizeof *data->primitives, false);
    if (data->primitives == NULL) return finish(data, TY_ERROR_MEMORY, out);
    add_triangles(data->primitives, triangles, 0);
    return finish(data, build_hierarchy(data, triangles), out);
}

void ty_bvh_destroy(ty_bvh_data* data) {
    if (data == NULL) return;
    ty_context* context = data->context;
    ty_free_array(context, data->nodes, data->node_capacity, sizeof *data->nodes);
    ty_free_array(context, data->primitives, data->primitive_count, sizeof *data->primitives);
    ty_free_array(context, data->quads, data->quad_count, sizeof *data->quads);
    ty_free_array(context, data->spheres, data->sphere_count, sizeof *data->spheres);
    ty_free_array(context, data, 1, sizeof *data);
}
