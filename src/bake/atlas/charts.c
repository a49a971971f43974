/* Adjacency of triangles on the surface and in the map: charts, and the seams between them. */
#include "base/context.h"
#include "base/random.k.h"
#include "bake/atlas/atlas.h"
#include "scene/surfaces/surface.k.h"

#include <math.h>
#include <string.h>

/* Distance in texels below which corners of the map coincide. */
static const double same_position_texels = 0.01;
/* Cosine above which normals count as equal. */
static const float same_normal_cosine = 0.999f;
/* Maximum number of triangles tested around one edge. */
enum { AROUND_EDGE = 8 };

typedef struct chart_job {
    ty_context* context;
    const ty_mesh_def* mesh;
    ty_surface surface;    /* the mesh's, for its normals */
    double sides[2];       /* width and height of the map, texels */
    size_t table_size;     /* number of buckets, a power of two */
    int32_t* table;        /* per bucket: its last entry; -1: none */
    int32_t* first_vertex; /* per vertex: the first vertex at the same position */
    int32_t* next;         /* per edge (3 per triangle, starting at its corner): the previous edge in its bucket */
    int32_t* charts;       /* per triangle: its parent in the union-find forest of charts */
    ty_seam** seams;
    size_t *seam_count, *capacity;
} chart_job;

static size_t bucket_of(const chart_job* job, uint32_t a, uint32_t b, uint32_t c) {
    return ty_mix32(ty_mix32(ty_mix32(a) ^ b) ^ c) & (job->table_size - 1);
}

static void clear_table(chart_job* job) {
    memset(job->table, 0xff, job->table_size * sizeof *job->table);
}

/* Merges vertices at equal positions: open addressing with linear probing. */
static void merge_vertices(chart_job* job) {
    clear_table(job);
    for (int64_t vertex = 0; vertex < job->mesh->vertex_count; ++vertex) {
        float at[3];
        for (int axis = 0; axis < 3; ++axis) at[axis] = job->mesh->positions[3 * vertex + axis] + 0.0f; /* +0 for -0 */
        size_t bucket = bucket_of(job, ty_bits_from_float(at[0]), ty_bits_from_float(at[1]), ty_bits_from_float(at[2]));
        for (;; bucket = (bucket + 1) & (job->table_size - 1)) {
            const int32_t other = job->table[bucket];
            const float* other_position = other < 0 ? NULL : job->mesh->positions + 3 * (size_t)other;
            if (other_position != NULL &&
                (other_position[0] != at[0] || other_position[1] != at[1] || other_position[2] != at[2]))
                continue;
            job->first_vertex[vertex] = other_position == NULL ? (int32_t)vertex : other;
            if (other_position == NULL) job->table[bucket] = (int32_t)vertex;
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

/* Map position and normal at one end of a triangle's edge. */
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

/* Joins the charts of two triangles adjacent in the map, or records a seam. */
static bool join_or_add_seam(chart_job* job, int64_t edge, int64_t other) {
    const int64_t triangles[2] = {edge / 3, other / 3};
    double at[2][2][2]; /* [side][end][axis] */
    ty_vec normals[2][2];
    const int corner = (int)(edge % 3), of_other = (int)(other % 3);
    const bool reversed = job->first_vertex[vertex_of(job, triangles[0], corner)] !=
                          job->first_vertex[vertex_of(job, triangles[1], of_other)];
    for (int end = 0; end < 2; ++end) {
        end_of(job, triangles[0], (corner + end) % 3, at[0][end], &normals[0][end]);
        end_of(job, triangles[1], (of_other + (reversed ? 1 - end : end)) % 3, at[1][end], &normals[1][end]);
    }
    bool same = true, smooth = true;
    for (int end = 0; end < 2; ++end) {
        same &= hypot(at[0][end][0] - at[1][end][0], at[0][end][1] - at[1][end][1]) < same_position_texels;
        smooth &= ty_dot(normals[0][end], normals[1][end]) > same_normal_cosine;
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

/* The end vertices of an edge, the lower index first. */
static void ends_of(const chart_job* job, int64_t edge, int32_t ends[2]) {
    const int corner = (int)(edge % 3);
    const int32_t a = job->first_vertex[vertex_of(job, edge / 3, corner)];
    const int32_t b = job->first_vertex[vertex_of(job, edge / 3, (corner + 1) % 3)];
    ends[0] = a < b ? a : b;
    ends[1] = a < b ? b : a;
}

static bool exists(const chart_job* job, int64_t triangle) {
    double corners[3][2];
    return ty_atlas_triangle(job->mesh, (size_t)triangle, (int32_t)job->sides[0], (int32_t)job->sides[1], corners);
}

/* Buckets chain their edges, since several edges connect the same vertices. */
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
        int tested = 0;
        for (int32_t other = job->table[bucket]; other >= 0 && tested < AROUND_EDGE; other = job->next[other]) {
            ends_of(job, other, others);
            if (others[0] != ends[0] || others[1] != ends[1]) continue;
            if (!join_or_add_seam(job, edge, other)) return false;
            ++tested;
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
    job.first_vertex = ty_alloc_array(context, vertices, sizeof *job.first_vertex, false);
    job.next = ty_alloc_array(context, edges, sizeof *job.next, false);
    bool fine = job.table != NULL && job.first_vertex != NULL && job.next != NULL;
    for (int64_t t = 0; t < mesh->triangle_count; ++t) charts[t] = (int32_t)t;
    if (fine) {
        merge_vertices(&job);
        fine = find_neighbours(&job);
    }
    for (int64_t t = 0; t < mesh->triangle_count; ++t) charts[t] = root_of(charts, (int32_t)t);
    for (size_t i = 0; i < *seam_count; ++i)
        for (int side = 0; side < 2; ++side) (*seams)[i].chart[side] = charts[(*seams)[i].chart[side]];
    ty_free_array(context, job.table, job.table_size, sizeof *job.table);
    ty_free_array(context, job.first_vertex, vertices, sizeof *job.first_vertex);
    ty_free_array(context, job.next, edges, sizeof *job.next);
    return fine ? TY_OK : TY_ERROR_MEMORY;
}
