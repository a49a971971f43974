/* Merging of charts: small ones join a neighbour where a plane across the mean normal of both stays within the stretch.
 */
#include "base/context.h"
#include "bake/unwrap/unwrap.h"

#include <math.h>
#include <stdlib.h>

/* A chart, which may hold others after it. */
typedef struct group {
    double normal[3]; /* sum of areas times normals, of all in it */
    double area;
    int32_t index, root;  /* root: the group that holds this one, or itself */
    int32_t next, last;   /* charts of the group in a list; last: of roots */
    int64_t first, count; /* its own faces in the list by chart */
} group;

typedef struct merger {
    const ty_unwrap_face* faces;
    const int32_t* by_chart;
    group* groups;
    double cosine;
} merger;

static int compare_areas(const void* a, const void* b) {
    const group *p = *(const group*const*)a, *q = *(const group*const*)b;
    if (p->area != q->area) return p->area < q->area ? -1 : 1;
    return p->index < q->index ? -1 : p->index > q->index;
}

static int32_t root_of(const merger* m, int32_t chart) {
    while (m->groups[chart].root != chart) chart = m->groups[chart].root;
    return chart;
}

static bool fits(const merger* m, int32_t chart, const double normal[3]) {
    for (int32_t c = chart; c >= 0; c = m->groups[c].next)
        for (int64_t i = 0; i < m->groups[c].count; ++i) {
            const ty_unwrap_face* face = &m->faces[m->by_chart[m->groups[c].first + i]];
            const double cosine = (double)face->normal[0] * normal[0] + (double)face->normal[1] * normal[1] +
                                  (double)face->normal[2] * normal[2];
            if (face->area > 0 && cosine < m->cosine) return false;
        }
    return true;
}

static bool fit_together(const merger* m, int32_t a, int32_t b) {
    double normal[3], length = 0;
    for (int k = 0; k < 3; ++k) {
        normal[k] = m->groups[a].normal[k] + m->groups[b].normal[k];
        length += normal[k] * normal[k];
    }
    if (!(length > 0)) return false;
    for (int k = 0; k < 3; ++k) normal[k] /= sqrt(length);
    return fits(m, a, normal) && fits(m, b, normal);
}

static ty_unwrap_borders find_neighbours(const merger* m, int32_t chart) {
    ty_unwrap_borders found = {0};
    for (int32_t c = chart; c >= 0; c = m->groups[c].next)
        for (int64_t i = 0; i < 3 * m->groups[c].count; ++i) {
            const int32_t across = m->faces[m->by_chart[m->groups[c].first + i / 3]].neighbour[i % 3];
            const int32_t other = across < 0 ? chart : root_of(m, m->faces[across].chart);
            if (other != chart) ty_unwrap_count_edge(&found, other);
        }
    return found;
}

/* Joins a group to the neighbour with the longest border, counted in edges, that it fits. */
static void join(const merger* m, int32_t chart) {
    const ty_unwrap_borders found = find_neighbours(m, chart);
    int32_t best = -1;
    for (int k = 0; k < found.count; ++k)
        if ((best < 0 || found.edges[k] > found.edges[best]) && fit_together(m, chart, found.chart[k])) best = k;
    if (best < 0) return;
    group *to = &m->groups[found.chart[best]], *from = &m->groups[chart];
    for (int k = 0; k < 3; ++k) to->normal[k] += from->normal[k];
    to->area += from->area;
    from->root = found.chart[best];
    m->groups[to->last].next = chart;
    to->last = from->last;
}

ty_result ty_unwrap_merge(ty_context* context, ty_unwrap_face* faces, int64_t count, const int32_t* by_chart,
                          double stretch, int32_t* charts) {
    const size_t total = (size_t)*charts;
    group* groups = ty_alloc_array(context, total, sizeof *groups, true);
    group** order = ty_alloc_array(context, total, sizeof *order, false);
    const ty_result result = groups == NULL || order == NULL ? TY_ERROR_MEMORY : TY_OK;
    if (result == TY_OK) {
        const merger m = {faces, by_chart, groups, 1 / stretch};
        for (int64_t i = 0; i < count; ++i) {
            const ty_unwrap_face* face = &faces[by_chart[i]];
            group* g = &groups[face->chart];
            if (g->count++ == 0) g->first = i;
            g->area += (double)face->area;
            for (int k = 0; k < 3; ++k) g->normal[k] += (double)(face->area * face->normal[k]);
        }
        for (size_t c = 0; c < total; ++c) {
            groups[c].index = groups[c].root = groups[c].last = (int32_t)c;
            groups[c].next = -1;
            order[c] = &groups[c];
        }
        qsort(order, total, sizeof(group*), compare_areas);
        for (size_t c = 0; c < total; ++c) join(&m, order[c]->index);
        int32_t left = 0; /* numbers in `index` */
        for (size_t c = 0; c < total; ++c)
            if (groups[c].root == (int32_t)c) groups[c].index = left++;
        for (int64_t i = 0; i < count; ++i) faces[i].chart = groups[root_of(&m, faces[i].chart)].index;
        *charts = left;
    }
    if (order != NULL) ty_free_array(context, order, total, sizeof *order);
    if (groups != NULL) ty_free_array(context, groups, total, sizeof *groups);
    return result;
}
