/* Charts: triangles that a plane takes within a bound of the stretch. */
#include "base/context.h"
#include "bake/unwrap/unwrap.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- Faces ---- */

typedef struct corner {
    float position[3];
    uint32_t vertex;
} corner;

static int compare_corners(const void* a, const void* b) {
    const corner *p = a, *q = b;
    for (int i = 0; i < 3; ++i)
        if (p->position[i] != q->position[i]) return p->position[i] < q->position[i] ? -1 : 1;
    return p->vertex < q->vertex ? -1 : p->vertex > q->vertex;
}

/* The first vertex at each vertex's position. */
static ty_result weld(ty_context* context, const ty_unwrap_mesh* mesh, uint32_t* first) {
    const size_t count = (size_t)mesh->vertex_count;
    corner* corners = ty_alloc_array(context, count, sizeof *corners, false);
    if (corners == NULL) return TY_ERROR_MEMORY;
    for (size_t i = 0; i < count; ++i) {
        memcpy(corners[i].position, mesh->positions + 3 * i, sizeof corners[i].position);
        corners[i].vertex = (uint32_t)i;
    }
    qsort(corners, count, sizeof *corners, compare_corners);
    for (size_t i = 0, begin = 0; i < count; ++i) {
        for (int a = 0; a < 3; ++a)
            if (corners[i].position[a] != corners[begin].position[a]) begin = i;
        first[corners[i].vertex] = corners[begin].vertex;
    }
    ty_free_array(context, corners, count, sizeof *corners);
    return TY_OK;
}

typedef struct edge {
    uint32_t low, high;
    int32_t triangle, side;
} edge;

static int compare_edges(const void* a, const void* b) {
    const edge *p = a, *q = b;
    if (p->low != q->low) return p->low < q->low ? -1 : 1;
    if (p->high != q->high) return p->high < q->high ? -1 : 1;
    return p->triangle < q->triangle ? -1 : p->triangle > q->triangle;
}

static void join_edges(const edge* edges, size_t count, ty_unwrap_face* faces) {
    for (size_t i = 0, past; i < count; i = past) {
        for (past = i + 1; past < count && edges[past].low == edges[i].low && edges[past].high == edges[i].high;)
            ++past;
        if (past != i + 2 || edges[i].low == edges[i].high) continue;
        faces[edges[i].triangle].neighbour[edges[i].side] = edges[i + 1].triangle;
        faces[edges[i + 1].triangle].neighbour[edges[i + 1].side] = edges[i].triangle;
    }
}

static void measure_face(const ty_unwrap_mesh* mesh, int64_t triangle, ty_unwrap_face* face) {
    const float* p[3];
    double u[3], v[3], n[3];
    for (int k = 0; k < 3; ++k) p[k] = mesh->positions + 3 * (size_t)mesh->indices[3 * triangle + k];
    for (int a = 0; a < 3; ++a) {
        u[a] = (double)p[1][a] - (double)p[0][a];
        v[a] = (double)p[2][a] - (double)p[0][a];
    }
    for (int a = 0; a < 3; ++a) n[a] = u[(a + 1) % 3] * v[(a + 2) % 3] - u[(a + 2) % 3] * v[(a + 1) % 3];
    const double length = sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
    *face = (ty_unwrap_face){.area = (float)(0.5 * length), .neighbour = {-1, -1, -1}, .chart = -1};
    for (int a = 0; a < 3; ++a) face->normal[a] = length > 0 ? (float)(n[a] / length) : 0;
}

ty_result ty_unwrap_find_faces(ty_context* context, const ty_unwrap_mesh* mesh, ty_unwrap_face* faces,
                               uint32_t* welded) {
    const size_t triangles = (size_t)mesh->triangle_count;
    edge* edges = ty_alloc_array(context, 3 * triangles, sizeof *edges, false);
    ty_result result = edges == NULL ? TY_ERROR_MEMORY : weld(context, mesh, welded);
    for (size_t t = 0; t < triangles && result == TY_OK; ++t) {
        measure_face(mesh, (int64_t)t, &faces[t]);
        for (size_t k = 0; k < 3; ++k) {
            const uint32_t a = welded[mesh->indices[3 * t + k]], b = welded[mesh->indices[3 * t + (k + 1) % 3]];
            edges[3 * t + k] = (edge){a < b ? a : b, a < b ? b : a, (int32_t)t, (int32_t)k};
        }
    }
    if (result == TY_OK) {
        qsort(edges, 3 * triangles, sizeof *edges, compare_edges);
        join_edges(edges, 3 * triangles, faces);
    }
    if (edges != NULL) ty_free_array(context, edges, 3 * triangles, sizeof *edges);
    return result;
}

/* ---- Charts ---- */

static float cosine(const float a[3], const float b[3]) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* Flat neighbours come first: one pass takes faces almost parallel to the seed, the next all within the bound. */
static void grow_from(ty_unwrap_face* faces, int32_t seed, double stretch, int32_t chart, int32_t* queue) {
    const float limits[2] = {0.999f, (float)(1 / stretch)};
    int32_t count = 1;
    faces[seed].chart = chart;
    queue[0] = seed;
    for (int pass = 0; pass < 2; ++pass)
        for (int32_t i = 0; i < count; ++i)
            for (int side = 0; side < 3; ++side) {
                const int32_t next = faces[queue[i]].neighbour[side];
                if (next < 0 || faces[next].chart >= 0) continue;
                if (faces[next].area > 0 && cosine(faces[next].normal, faces[seed].normal) < limits[pass]) continue;
                faces[next].chart = chart;
                queue[count++] = next;
            }
}

void ty_unwrap_grow(ty_unwrap_face* faces, int64_t count, const int32_t* order, double stretch, int32_t* queue,
                    int32_t* charts) {
    for (int64_t i = 0; i < count; ++i)
        if (faces[order[i]].chart < 0) grow_from(faces, order[i], stretch, (*charts)++, queue);
}
