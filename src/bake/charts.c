/* Which triangles are neighbours, on the surface and in the map: charts, and seams between them. */
#include "base/context.h"
#include "base/random.k.h"
#include "bake/atlas.h"
#include "scene/surface.k.h"

#include <math.h>
#include <string.h>

/* Corners of the map closer than this are one, texels. */
static const double same_place = 0.01;
/* Cosine between normals that count as one. */
static const float same_normal = 0.999f;
/* Of more triangles around one edge than this, the later ones do not meet the first. */
enum { AROUND_EDGE = 8 };

typedef struct chart_job {
    ty_context* context;
    const ty_mesh_def* mesh;
    ty_surface surface; /* the mesh's, for its normals */
    double sides[2];    /* of the map, texels */
    size_t table_size;  /* a power of two, of buckets */
    int32_t* table;     /* per bucket: the last entry; -1: none */
    int32_t* place;     /* per vertex: the first with the same position */
    int32_t* next;      /* per edge (3 a triangle, from its corner): the one before it in its bucket */
    int32_t* charts;    /* per triangle: another of its chart, or itself */
    ty_seam** seams;
    size_t *seam_count, *capacity;
} chart_job;

static size_t bucket_of(const chart_job* job, uint32_t a, uint32_t b, uint32_t c) {
    return ty_mix32(ty_mix32(ty_mix32(a) ^ b) ^ c) & (job->table_size - 1);
}

static void clear_table(chart_job* job) {
    memset(job->table, 0xff, job->table_size * sizeof *job->table);
}

/* Tables of buckets with open ends: probing runs on until an empty one. */
static void find_places(chart_job* job) {
    clear_table(job);
    for (int64_t vertex = 0; vertex < job->mesh->vertex_count; ++vertex) {
        float at[3];
        for (int axis = 0; axis < 3; ++axis) at[axis] = job->mesh->positions[3 * vertex + axis] + 0.0f; /* no -0 */
        size_t bucket = bucket_of(job, ty_bits_from_float(at[0]), ty_bits_from_float(at[1]), ty_bits_from_float(at[2]));
        for (;; bucket = (bucket + 1) & (job->table_size - 1)) {
            const int32_t other = job->table[bucket];
            const float* there = other < 0 ? NULL : job->mesh->positions + 3 * (size_t)other;
            if (there != NULL && (there[0] != at[0] || there[1] != at[1] || there[2] != at[2])) continue;
            job->place[vertex] = there == NULL ? (int32_t)vertex : other;
            if (there == NULL) job->table[bucket] = (int32_t)vertex;
            break;
        }
    }
}

static uint32_t vertex_of(const chart_job* job, int64_t triangle, int corner) {
    return job->mesh->indices[3 * triangle + corner];
}

static int32_t root_of(int32_t* charts, int32_t triangle) {
    while (charts[triangle] != triangle) {
        charts[triangle] = charts[charts[triangle]];
        triangle = charts[triangle];
    }
    return triangle;
}

static void join(int32_t* charts, int32_t a, int32_t b) {
    a = root_of(charts, a);
    b = root_of(charts, b);
    charts[a > b ? a : b] = a > b ? b : a;
}

/* One end of an edge of a triangle. */
static void end_of(const chart_job* job, int64_t triangle, int corner, double at[2], ty_vec* normal) {
    const uint32_t vertex = vertex_of(job, triangle, corner);
    for (int axis = 0; axis < 2; ++axis)
        at[axis] = (double)job->mesh->uv[1][2 * (size_t)vertex + (size_t)axis] * job->sides[axis];
    ty_hit hit = {.primitive_id = (int32_t)triangle, .b1 = corner == 1 ? 1.0f : 0.0f, .b2 = corner == 2 ? 1.0f : 0.0f};
    const ty_vec a = ty_vec_load(job->mesh->positions + 3 * (size_t)vertex_of(job, triangle, 0));
    const ty_vec b = ty_vec_load(job->mesh->positions + 3 * (size_t)vertex_of(job, triangle, 1));
    const ty_vec c = ty_vec_load(job->mesh->positions + 3 * (size_t)vertex_of(job, triangle, 2));
    float area;
    hit.normal = ty_triangle_normal(ty_sub(b, a), ty_sub(c, a), &area);
    ty_surface_point point;
    ty_surface_evaluate(&job->surface, &hit, ty_scale(hit.normal, -1.0f), &point);
    *normal = point.ns;
}

/* Joins two triangles that share an edge on the surface, or notes a seam. */
static bool meet(chart_job* job, int64_t edge, int64_t other) {
    const int64_t triangles[2] = {edge / 3, other / 3};
    double at[2][2][2]; /* [side][end][axis] */
    ty_vec normals[2][2];
    const int corner = (int)(edge % 3), of_other = (int)(other % 3);
    const bool turned =
        job->place[vertex_of(job, triangles[0], corner)] != job->place[vertex_of(job, triangles[1], of_other)];
    for (int end = 0; end < 2; ++end) {
        end_of(job, triangles[0], (corner + end) % 3, at[0][end], &normals[0][end]);
        end_of(job, triangles[1], (of_other + (turned ? 1 - end : end)) % 3, at[1][end], &normals[1][end]);
    }
    bool same = true, smooth = true;
    for (int end = 0; end < 2; ++end) {
        same &= hypot(at[0][end][0] - at[1][end][0], at[0][end][1] - at[1][end][1]) < same_place;
        smooth &= ty_dot(normals[0][end], normals[1][end]) > same_normal;
    }
    if (same) join(job->charts, (int32_t)triangles[0], (int32_t)triangles[1]);
    if (same || !smooth) return true;
    if (!ty_grow_array(job->context, (void**)job->seams, job->capacity, *job->seam_count, sizeof **job->seams))
        return false;
    ty_seam* seam = &(*job->seams)[(*job->seam_count)++];
    for (int side = 0; side < 2; ++side) {
        for (int axis = 0; axis < 2; ++axis) {
            seam->from[side][axis] = (float)at[side][0][axis];
            seam->to[side][axis] = (float)at[side][1][axis];
        }
        seam->chart[side] = (int32_t)triangles[side];
    }
    return true;
}

/* An edge's ends, the lower one first. */
static void ends_of(const chart_job* job, int64_t edge, int32_t ends[2]) {
    const int corner = (int)(edge % 3);
    const int32_t a = job->place[vertex_of(job, edge / 3, corner)];
    const int32_t b = job->place[vertex_of(job, edge / 3, (corner + 1) % 3)];
    ends[0] = a < b ? a : b;
    ends[1] = a < b ? b : a;
}

static bool exists(const chart_job* job, int64_t triangle) {
    double corners[3][2];
    return ty_atlas_triangle(job->mesh, (size_t)triangle, (int32_t)job->sides[0], (int32_t)job->sides[1], corners);
}

/* Buckets chain their edges here: several edges lie between the same ends. */
static bool find_neighbours(chart_job* job) {
    clear_table(job);
    for (int64_t edge = 0; edge < 3 * job->mesh->triangle_count; ++edge) {
        if (edge % 3 == 0 && !exists(job, edge / 3)) {
            edge += 2;
            continue;
        }
        int32_t ends[2], others[2];
        ends_of(job, edge, ends);
        const size_t bucket = bucket_of(job, (uint32_t)ends[0], (uint32_t)ends[1], 0);
        int met = 0;
        for (int32_t other = job->table[bucket]; other >= 0 && met < AROUND_EDGE; other = job->next[other]) {
            ends_of(job, other, others);
            if (others[0] != ends[0] || others[1] != ends[1]) continue;
            if (!meet(job, edge, other)) return false;
            ++met;
        }
        job->next[edge] = job->table[bucket];
        job->table[bucket] = (int32_t)edge;
    }
    return true;
}

ty_result ty_atlas_find_charts(ty_context* context, const ty_mesh_def* mesh, int32_t width, int32_t height,
                               int32_t* charts, ty_seam** seams, size_t* seam_count, size_t* capacity) {
    const size_t vertices = (size_t)mesh->vertex_count, edges = 3 * (size_t)mesh->triangle_count;
    chart_job job = {.context = context,
                     .mesh = mesh,
                     .sides = {width, height},
                     .charts = charts,
                     .seams = seams,
                     .seam_count = seam_count,
                     .capacity = capacity,
                     .table_size = 16,
                     .surface = {.indices = mesh->indices, .positions = mesh->positions, .normals = mesh->normals}};
    if (edges > INT32_MAX)
        return ty_fail(context, TY_ERROR_ARGUMENT,
                       "mesh: %lld triangles are too many for a lightmap, of which one can "
                       "have 715827882",
                       (long long)mesh->triangle_count);
    while (job.table_size < 2 * (vertices > edges / 2 ? vertices : edges / 2)) job.table_size *= 2;
    job.table = ty_alloc_array(context, job.table_size, sizeof *job.table, false);
    job.place = ty_alloc_array(context, vertices, sizeof *job.place, false);
    job.next = ty_alloc_array(context, edges, sizeof *job.next, false);
    bool fine = job.table != NULL && job.place != NULL && job.next != NULL;
    for (int64_t t = 0; t < mesh->triangle_count; ++t) charts[t] = (int32_t)t;
    if (fine) {
        find_places(&job);
        fine = find_neighbours(&job);
    }
    for (int64_t t = 0; t < mesh->triangle_count; ++t) charts[t] = root_of(charts, (int32_t)t);
    for (size_t i = 0; i < *seam_count; ++i)
        for (int side = 0; side < 2; ++side) (*seams)[i].chart[side] = charts[(*seams)[i].chart[side]];
    ty_free_array(context, job.table, job.table_size, sizeof *job.table);
    ty_free_array(context, job.place, vertices, sizeof *job.place);
    ty_free_array(context, job.next, edges, sizeof *job.next);
    return fine ? TY_OK : TY_ERROR_MEMORY;
}
