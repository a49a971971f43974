/* Joining of charts by conformal maps: curved surfaces, which planes cut into many, get few charts. */
#include "bake/unwrap/conformal.h"

#include "base/context.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { TRIES = 2, PASSES = 4, TRIANGLES_MAX = 20000, SIDE_MAX = 2048 };

/* Cosine between normals beyond which an edge is a crease, which stays between charts: light is not the same on its two
 * sides, and filtering would mix it. */
static const float crease_cosine = 0.7f;

/* Charts of one map, as a list of triangles. */
typedef struct group {
    int32_t root, index;
    int32_t head, tail; /* triangles */
    int64_t count;
    double area;
} group;

typedef struct joiner {
    ty_context* context;
    const ty_unwrap_surface* surface;
    const ty_unwrap_def* def;
    ty_unwrap_face* faces;
    float* flat;       /* 6 per triangle, m */
    group* groups;     /* one per chart */
    int32_t* next;     /* per triangle */
    int32_t* together; /* triangles of two groups */
    float* uv;         /* of these */
} joiner;

static int32_t root_of(const joiner* j, int32_t chart) {
    while (j->groups[chart].root != chart) chart = j->groups[chart].root;
    return chart;
}

static int compare_groups(const void* a, const void* b) {
    const group *p = *(const group*const*)a, *q = *(const group*const*)b;
    if (p->area != q->area) return p->area < q->area ? -1 : 1;
    return p->index < q->index ? -1 : p->index > q->index;
}

static int64_t list_group(const joiner* j, int32_t chart, int64_t at) {
    for (int32_t t = j->groups[chart].head; t >= 0; t = j->next[t]) j->together[at++] = t;
    return at;
}

/* True if no triangles of a map lie over one another. */
static ty_result lies_flat(const joiner* j, int64_t count, bool* flat) {
    float low[2] = {INFINITY, INFINITY}, high[2] = {-INFINITY, -INFINITY};
    for (int64_t i = 0; i < 6 * count; ++i) {
        low[i % 2] = fminf(low[i % 2], j->uv[i]);
        high[i % 2] = fmaxf(high[i % 2], j->uv[i]);
    }
    const float longest = fmaxf(fmaxf(high[0] - low[0], high[1] - low[1]), 1e-20f);
    const float scale = fminf((float)(2 * j->def->density), SIDE_MAX / longest);
    const int32_t width = (int32_t)((high[0] - low[0]) * scale) + 1, height = (int32_t)((high[1] - low[1]) * scale) + 1;
    uint8_t* owned = ty_alloc_array(j->context, (size_t)width * (size_t)height, 1, true);
    if (owned == NULL) return TY_ERROR_MEMORY;
    *flat = true;
    for (int64_t i = 0; i < count && *flat; ++i) {
        float at[3][2];
        for (int k = 0; k < 6; ++k) at[k / 2][k % 2] = (j->uv[6 * i + k] - low[k % 2]) * scale;
        *flat = !ty_unwrap_cover(at, width, height, owned);
    }
    ty_free_array(j->context, owned, (size_t)width * (size_t)height, 1);
    return TY_OK;
}

/* Maps the triangles in j->together; *made: the map is kept. */
static ty_result map_together(joiner* j, int64_t count, bool* made) {
    ty_result result = ty_unwrap_conformal(j->context, j->surface, j->together, count, j->def->stretch, j->uv, made);
    if (result == TY_OK && *made) result = lies_flat(j, count, made);
    if (result != TY_OK || !*made) return result;
    for (int64_t i = 0; i < count; ++i) memcpy(j->flat + 6 * (size_t)j->together[i], j->uv + 6 * i, 6 * sizeof(float));
    return TY_OK;
}

/* Neighbours across edges that are no creases. */
static ty_unwrap_borders find_neighbours(const joiner* j, int32_t chart) {
    ty_unwrap_borders found = {0};
    for (int32_t t = j->groups[chart].head; t >= 0; t = j->next[t])
        for (int side = 0; side < 3; ++side) {
            const int32_t across = j->faces[t].neighbour[side];
            if (across < 0) continue;
            const float *a = j->faces[t].normal, *b = j->faces[across].normal;
            const int32_t other = root_of(j, j->faces[across].chart);
            if (other == chart || a[0] * b[0] + a[1] * b[1] + a[2] * b[2] < crease_cosine) continue;
            ty_unwrap_count_edge(&found, other);
        }
    return found;
}

static void link(joiner* j, int32_t from, int32_t to) {
    group *a = &j->groups[from], *b = &j->groups[to];
    j->next[b->tail] = a->head;
    b->tail = a->tail;
    b->count += a->count;
    b->area += a->area;
    a->root = to;
}

/* Joins a group to one of the neighbours with the longest borders. */
static ty_result join(joiner* j, int32_t chart, bool* joined) {
    ty_unwrap_borders found = find_neighbours(j, chart);
    for (int attempt = 0; attempt < TRIES; ++attempt) {
        int best = -1;
        for (int k = 0; k < found.count; ++k)
            if (found.edges[k] > 0 && (best < 0 || found.edges[k] > found.edges[best])) best = k;
        if (best < 0) return TY_OK;
        found.edges[best] = 0;
        if (j->groups[chart].count + j->groups[found.chart[best]].count > TRIANGLES_MAX) continue;
        bool made;
        const int64_t total = list_group(j, chart, list_group(j, found.chart[best], 0));
        const ty_result result = map_together(j, total, &made);
        if (result != TY_OK) return result;
        if (!made) continue;
        link(j, chart, found.chart[best]);
        *joined = true;
        return TY_OK;
    }
    return TY_OK;
}

/* A chart by itself, if its plane stretches it. */
static ty_result relax(joiner* j, int32_t chart) {
    static const double little = 1.02;
    const int64_t count = list_group(j, chart, 0);
    double largest = 1, stretch[2];
    bool made;
    for (int64_t i = 0; i < count; ++i)
        if (ty_unwrap_stretch_of(j->surface->mesh, j->together[i], j->flat + 6 * (size_t)j->together[i], stretch))
            largest = fmax(largest, stretch[0]);
    return largest > little && count <= TRIANGLES_MAX ? map_together(j, count, &made) : TY_OK;
}

static ty_result join_all(joiner* j, group** order, int32_t charts) {
    ty_result result = TY_OK;
    bool joined = true;
    for (int32_t c = 0; c < charts && result == TY_OK; ++c) result = relax(j, c);
    for (int pass = 0; pass < PASSES && joined; ++pass) {
        joined = false;
        for (int32_t c = 0; c < charts; ++c) order[c] = &j->groups[c];
        qsort(order, (size_t)charts, sizeof *order, compare_groups);
        for (int32_t c = 0; c < charts && result == TY_OK; ++c)
            if (order[c]->root == order[c]->index) result = join(j, order[c]->index, &joined);
    }
    return result;
}

static void make_groups(joiner* j, int32_t charts) {
    for (int32_t c = 0; c < charts; ++c) j->groups[c] = (group){.root = c, .index = c, .head = -1, .tail = -1};
    for (int64_t t = j->surface->mesh->triangle_count - 1; t >= 0; --t) {
        group* g = &j->groups[j->faces[t].chart];
        j->next[t] = g->head;
        if (g->head < 0) g->tail = (int32_t)t;
        g->head = (int32_t)t;
        g->area += (double)j->faces[t].area;
        ++g->count;
    }
}

/* Numbers what is left from 0 on. */
static int32_t number_groups(joiner* j, int32_t charts) {
    int32_t left = 0;
    for (int32_t c = 0; c < charts; ++c)
        if (j->groups[c].root == c) j->groups[c].index = left++;
    for (int64_t t = 0; t < j->surface->mesh->triangle_count; ++t)
        j->faces[t].chart = j->groups[root_of(j, j->faces[t].chart)].index;
    return left;
}

ty_result ty_unwrap_join(ty_context* context, const ty_unwrap_surface* surface, const ty_unwrap_def* def,
                         ty_unwrap_face* faces, float* flat, int32_t* charts) {
    const size_t triangles = (size_t)surface->mesh->triangle_count, count = (size_t)*charts;
    group* groups = ty_alloc_array(context, count, sizeof *groups, false);
    group** order = ty_alloc_array(context, count, sizeof *order, false);
    int32_t* lists = ty_alloc_array(context, 2 * triangles, sizeof *lists, false);
    float* uv = ty_alloc_array(context, 6 * triangles, sizeof *uv, false);
    ty_result result = groups == NULL || order == NULL || lists == NULL || uv == NULL ? TY_ERROR_MEMORY : TY_OK;
    if (result == TY_OK) {
        joiner j = {context, surface, def, faces, flat, groups, lists, lists + triangles, uv};
        make_groups(&j, *charts);
        result = join_all(&j, order, *charts);
        if (result == TY_OK) *charts = number_groups(&j, *charts);
    }
    if (uv != NULL) ty_free_array(context, uv, 6 * triangles, sizeof *uv);
    if (lists != NULL) ty_free_array(context, lists, 2 * triangles, sizeof *lists);
    if (order != NULL) ty_free_array(context, order, count, sizeof *order);
    if (groups != NULL) ty_free_array(context, groups, count, sizeof *groups);
    return result;
}
