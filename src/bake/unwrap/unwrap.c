/* Unwrapping: charts are grown, projected, freed from overlaps, joined, rotated, and packed. */
#include "bake/unwrap/conformal.h"
#include "base/context.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { TURNS = 32, ROUNDS = 16, OVERLAP_SIDE_MAX = 2048 };

/* Axes of a chart's plane, and the box of its triangles in it, m. */
typedef struct plane {
    float axes[2][3];
    float low[2], high[2];
    int64_t first, count; /* triangles in the list by chart */
} plane;

typedef struct job {
    ty_context* context;
    const ty_unwrap_mesh* mesh;
    const ty_unwrap_def* def;
    ty_unwrap_face* faces;
    int32_t *order, *queue, *by_chart;
    float* flat;      /* 6 per triangle: its place in the map of its chart, m */
    uint32_t* welded; /* the first vertex at each vertex's position */
    plane* planes;
    int32_t charts, plane_capacity;
} job;

/* ---- Planes ---- */

/* Triangles by chart, by counting. */
static void list_triangles(job* j) {
    const int64_t triangles = j->mesh->triangle_count;
    for (int32_t c = 0; c < j->charts; ++c) j->planes[c].count = 0;
    for (int64_t t = 0; t < triangles; ++t) ++j->planes[j->faces[t].chart].count;
    int64_t at = 0;
    for (int32_t c = 0; c < j->charts; ++c) {
        j->planes[c].first = at;
        at += j->planes[c].count;
        j->planes[c].count = 0;
    }
    for (int64_t t = 0; t < triangles; ++t) {
        plane* p = &j->planes[j->faces[t].chart];
        j->by_chart[p->first + p->count++] = (int32_t)t;
    }
}

static const float* corner(const job* j, int32_t triangle, int k) {
    return j->mesh->positions + 3 * (size_t)j->mesh->indices[3 * (size_t)triangle + (size_t)k];
}

static float along(const float axis[3], const float p[3]) {
    return axis[0] * p[0] + axis[1] * p[1] + axis[2] * p[2];
}

/* The plane across the mean normal, if all triangles stay within the stretch there, or across the largest one's, from
 * which the chart was grown. */
static void find_normal(const job* j, const plane* p, float normal[3]) {
    double sum[3] = {0};
    const ty_unwrap_face* largest = &j->faces[j->by_chart[p->first]];
    for (int64_t i = 0; i < p->count; ++i) {
        const ty_unwrap_face* face = &j->faces[j->by_chart[p->first + i]];
        for (int a = 0; a < 3; ++a) sum[a] += (double)(face->area * face->normal[a]);
        if (face->area > largest->area) largest = face;
    }
    const double length = sqrt(sum[0] * sum[0] + sum[1] * sum[1] + sum[2] * sum[2]);
    for (int a = 0; a < 3; ++a) normal[a] = length > 0 ? (float)(sum[a] / length) : a == 2;
    for (int64_t i = 0; i < p->count; ++i) {
        const ty_unwrap_face* face = &j->faces[j->by_chart[p->first + i]];
        if (face->area > 0 && along(normal, face->normal) < 1 / j->def->stretch) {
            memcpy(normal, largest->normal, sizeof largest->normal);
            return;
        }
    }
}

static void find_box(const job* j, plane* p) {
    for (int b = 0; b < 2; ++b) {
        p->low[b] = INFINITY;
        p->high[b] = -INFINITY;
    }
    for (int64_t i = 0; i < 3 * p->count; ++i)
        for (int b = 0; b < 2; ++b) {
            const float at = along(p->axes[b], corner(j, j->by_chart[p->first + i / 3], (int)(i % 3)));
            p->low[b] = fminf(p->low[b], at);
            p->high[b] = fmaxf(p->high[b], at);
        }
}

/* Right-handed axes, so that no chart is mirrored. */
static void find_axes(const job* j, plane* p) {
    float n[3], *u = p->axes[0], *v = p->axes[1];
    find_normal(j, p, n);
    const int minor = fabsf(n[0]) <= fabsf(n[1]) && fabsf(n[0]) <= fabsf(n[2]) ? 0 : fabsf(n[1]) <= fabsf(n[2]) ? 1 : 2;
    const float length = sqrtf(1 - n[minor] * n[minor]);
    for (int a = 0; a < 3; ++a) u[a] = ((a == minor) - n[minor] * n[a]) / length;
    for (int a = 0; a < 3; ++a) v[a] = n[(a + 1) % 3] * u[(a + 2) % 3] - n[(a + 2) % 3] * u[(a + 1) % 3];
    find_box(j, p);
}

static ty_result make_planes(job* j) {
    if (j->charts > j->plane_capacity) {
        if (j->planes != NULL) ty_free_array(j->context, j->planes, (size_t)j->plane_capacity, sizeof *j->planes);
        j->plane_capacity = j->charts;
        j->planes = ty_alloc_array(j->context, (size_t)j->charts, sizeof *j->planes, true);
        if (j->planes == NULL) {
            j->plane_capacity = 0;
            return TY_ERROR_MEMORY;
        }
    }
    list_triangles(j);
    for (int32_t c = 0; c < j->charts; ++c) find_axes(j, &j->planes[c]);
    return TY_OK;
}

/* ---- Overlaps ---- */

/* Takes triangles that lie over others, or are stretched too much, out of their chart. *taken: whether there were any.
 */
static ty_result separate(job* j, const plane* p, bool* taken) {
    const float sides[2] = {p->high[0] - p->low[0], p->high[1] - p->low[1]};
    const float scale =
        fminf((float)(2 * j->def->density), OVERLAP_SIDE_MAX / fmaxf(fmaxf(sides[0], sides[1]), 1e-20f));
    const int32_t width = (int32_t)(sides[0] * scale) + 1, height = (int32_t)(sides[1] * scale) + 1;
    uint8_t* owned = ty_alloc_array(j->context, (size_t)width * (size_t)height, 1, true);
    if (owned == NULL) return TY_ERROR_MEMORY;
    float normal[3];
    for (int a = 0; a < 3; ++a)
        normal[a] =
            p->axes[0][(a + 1) % 3] * p->axes[1][(a + 2) % 3] - p->axes[0][(a + 2) % 3] * p->axes[1][(a + 1) % 3];
    for (int64_t i = 0; i < p->count; ++i) {
        const int32_t triangle = j->by_chart[p->first + i];
        float at[3][2];
        for (int k = 0; k < 3; ++k)
            for (int b = 0; b < 2; ++b) at[k][b] = (along(p->axes[b], corner(j, triangle, k)) - p->low[b]) * scale;
        const ty_unwrap_face* face = &j->faces[triangle];
        const bool steep = face->area > 0 && along(normal, face->normal) < 0.9999 / j->def->stretch;
        if (!steep && !ty_unwrap_cover(at, width, height, owned)) continue;
        j->faces[triangle].chart = -1;
        *taken = true;
    }
    ty_free_array(j->context, owned, (size_t)width * (size_t)height, 1);
    return TY_OK;
}

static ty_result make_charts(job* j) {
    ty_result result = TY_OK;
    bool taken = true;
    for (int round = 0; taken && round < ROUNDS && result == TY_OK; ++round) {
        ty_unwrap_grow(j->faces, j->mesh->triangle_count, j->order, j->def->stretch, j->queue, &j->charts);
        result = make_planes(j);
        if (round == 0 && result == TY_OK) { /* later it would undo what was separated */
            result = ty_unwrap_merge(j->context, j->faces, j->mesh->triangle_count, j->by_chart, j->def->stretch,
                                     &j->charts);
            if (result == TY_OK) result = make_planes(j);
        }
        taken = false;
        for (int32_t c = 0; c < j->charts && result == TY_OK; ++c)
            if (j->planes[c].count > 1) result = separate(j, &j->planes[c], &taken);
    }
    if (taken && result == TY_OK) { /* what still overlaps becomes charts of one triangle */
        for (int64_t t = 0; t < j->mesh->triangle_count; ++t)
            if (j->faces[t].chart < 0) j->faces[t].chart = j->charts++;
        result = make_planes(j);
    }
    return result;
}

/* ---- The map ---- */

/* The projection of each triangle onto its chart's plane, from a corner of its chart on, so that floats hold it. */
static void flatten(job* j) {
    for (int64_t t = 0; t < j->mesh->triangle_count; ++t) {
        const plane* p = &j->planes[j->faces[t].chart];
        const float* from = corner(j, j->by_chart[p->first], 0);
        for (int i = 0; i < 6; ++i) {
            const float *axis = p->axes[i % 2], *at = corner(j, (int32_t)t, i / 2);
            double sum = 0;
            for (int a = 0; a < 3; ++a) sum += (double)axis[a] * ((double)at[a] - (double)from[a]);
            j->flat[6 * t + i] = (float)sum;
        }
    }
}

static void turn_by(const float at[2], float angle, float out[2]) {
    const float c = cosf(angle), s = sinf(angle);
    out[0] = c * at[0] + s * at[1];
    out[1] = c * at[1] - s * at[0];
}

static void find_chart_box(const job* j, float angle, ty_unwrap_chart* chart) {
    for (int b = 0; b < 2; ++b) {
        chart->low[b] = INFINITY;
        chart->high[b] = -INFINITY;
    }
    for (int64_t i = 0; i < 3 * chart->count; ++i) {
        float at[2];
        turn_by(j->flat + 6 * (size_t)chart->triangles[i / 3] + 2 * (i % 3), angle, at);
        for (int b = 0; b < 2; ++b) {
            chart->low[b] = fminf(chart->low[b], at[b]);
            chart->high[b] = fmaxf(chart->high[b], at[b]);
        }
    }
}

/* Turns the map of a chart to the smallest box. */
static void turn_chart(job* j, ty_unwrap_chart* chart) {
    float smallest = INFINITY, best = 0;
    for (int turn = 0; turn < TURNS; ++turn) {
        const float angle = 1.57079633f * (float)turn / TURNS;
        find_chart_box(j, angle, chart);
        const float area = (chart->high[0] - chart->low[0]) * (chart->high[1] - chart->low[1]);
        if (area >= 0.9999f * smallest) continue;
        smallest = area;
        best = angle;
    }
    for (int64_t i = 0; i < 3 * chart->count; ++i) {
        float* at = j->flat + 6 * (size_t)chart->triangles[i / 3] + 2 * (i % 3);
        const float from[2] = {at[0], at[1]};
        turn_by(from, best, at);
    }
    find_chart_box(j, 0, chart);
}

static ty_result pack(job* j, ty_unwrap_chart* charts, ty_unwrap* out) {
    out->density = j->def->density;
    for (;;) {
        const ty_result result = ty_unwrap_pack(j->context, j->flat, charts, j->charts, out->density, j->def->padding,
                                                &out->width, &out->height);
        const int32_t side = out->width > out->height ? out->width : out->height;
        if (result != TY_OK || side <= TY_UNWRAP_SIDE_MAX || out->density < 1e-9 * j->def->density) return result;
        out->density *= 0.95 * TY_UNWRAP_SIDE_MAX / side;
    }
}

static void place(const job* j, const ty_unwrap_chart* charts, ty_unwrap* out) {
    double covered = 0, surface = 0, stretched = 0, stretch[2];
    const double margin = 0.5 + (j->def->padding + 1) / 2; /* NOLINT(bugprone-integer-division) */
    for (int64_t t = 0; t < j->mesh->triangle_count; ++t) {
        const ty_unwrap_chart* chart = &charts[j->faces[t].chart];
        double at[3][2];
        for (int k = 0; k < 3; ++k) {
            ty_unwrap_turn(chart, chart->turns, out->density, j->flat + 6 * t + 2 * k, at[k]);
            at[k][0] += chart->x + margin;
            at[k][1] += chart->y + margin;
            for (int b = 0; b < 2; ++b)
                out->uv[6 * t + 2 * k + b] = (float)(at[k][b] / (b == 0 ? out->width : out->height));
        }
        const double texels =
            0.5 * fabs((at[1][0] - at[0][0]) * (at[2][1] - at[0][1]) - (at[1][1] - at[0][1]) * (at[2][0] - at[0][0]));
        covered += texels;
        out->chart[t] = j->faces[t].chart;
        if (!ty_unwrap_stretch_of(j->mesh, t, j->flat + 6 * t, stretch)) continue;
        out->stretch = fmax(out->stretch, stretch[0]);
        stretched += (double)j->faces[t].area * 0.5 * (stretch[0] * stretch[0] + stretch[1] * stretch[1]);
        surface += (double)j->faces[t].area;
    }
    out->fill = covered / ((double)out->width * out->height);
    out->mean_stretch = surface > 0 ? sqrt(stretched / surface * covered / (surface * out->density * out->density)) : 1;
}

/* ---- The whole ---- */

typedef struct sized {
    float area;
    int32_t triangle;
} sized;

static int compare_areas(const void* a, const void* b) {
    const sized *p = a, *q = b;
    if (p->area != q->area) return p->area > q->area ? -1 : 1;
    return p->triangle < q->triangle ? -1 : p->triangle > q->triangle;
}

/* All triangles by falling area. */
static ty_result sort_faces(job* j) {
    const size_t count = (size_t)j->mesh->triangle_count;
    sized* all = ty_alloc_array(j->context, count, sizeof *all, false);
    if (all == NULL) return TY_ERROR_MEMORY;
    for (size_t i = 0; i < count; ++i) all[i] = (sized){j->faces[i].area, (int32_t)i};
    qsort(all, count, sizeof *all, compare_areas);
    for (size_t i = 0; i < count; ++i) j->order[i] = all[i].triangle;
    ty_free_array(j->context, all, count, sizeof *all);
    return TY_OK;
}

static ty_result join_charts(job* j) {
    const size_t vertices = (size_t)j->mesh->vertex_count, triangles = (size_t)j->mesh->triangle_count;
    int32_t* number = ty_alloc_array(j->context, vertices, sizeof *number, false);
    uint8_t* member = ty_alloc_array(j->context, triangles, sizeof *member, true);
    ty_result result = number == NULL || member == NULL ? TY_ERROR_MEMORY : TY_OK;
    if (result == TY_OK) {
        const ty_unwrap_surface surface = {j->mesh, j->faces, j->welded, number, member};
        for (size_t v = 0; v < vertices; ++v) number[v] = -1;
        flatten(j);
        result = ty_unwrap_join(j->context, &surface, j->def, j->faces, j->flat, &j->charts);
    }
    if (member != NULL) ty_free_array(j->context, member, triangles, sizeof *member);
    if (number != NULL) ty_free_array(j->context, number, vertices, sizeof *number);
    return result;
}

static ty_result pack_and_place(job* j, ty_unwrap* out) {
    ty_unwrap_chart* charts = ty_alloc_array(j->context, (size_t)j->charts, sizeof *charts, true);
    if (charts == NULL) return TY_ERROR_MEMORY;
    list_triangles(j);
    for (int32_t c = 0; c < j->charts; ++c) {
        charts[c].triangles = j->by_chart + j->planes[c].first;
        charts[c].count = j->planes[c].count;
        turn_chart(j, &charts[c]);
    }
    const ty_result result = pack(j, charts, out);
    if (result == TY_OK) place(j, charts, out);
    ty_free_array(j->context, charts, (size_t)j->charts, sizeof *charts);
    out->charts = j->charts;
    return result;
}

ty_result ty_unwrap_mesh_create(ty_context* context, const ty_unwrap_mesh* mesh, const ty_unwrap_def* def,
                                ty_unwrap* out) {
    const size_t count = (size_t)mesh->triangle_count, vertices = (size_t)mesh->vertex_count;
    *out = (ty_unwrap){.triangle_count = mesh->triangle_count, .stretch = 1};
    job j = {.context = context, .mesh = mesh, .def = def};
    int32_t* lists = ty_alloc_array(context, 3 * count, sizeof *lists, false);
    j.faces = ty_alloc_array(context, count, sizeof *j.faces, false);
    j.flat = ty_alloc_array(context, 6 * count, sizeof *j.flat, false);
    j.welded = ty_alloc_array(context, vertices, sizeof *j.welded, false);
    out->uv = ty_alloc_array(context, 6 * count, sizeof *out->uv, false);
    out->chart = ty_alloc_array(context, count, sizeof *out->chart, false);
    const bool made =
        lists != NULL && j.faces != NULL && j.flat != NULL && j.welded != NULL && out->uv != NULL && out->chart != NULL;
    ty_result result = made ? ty_unwrap_find_faces(context, mesh, j.faces, j.welded) : TY_ERROR_MEMORY;
    if (result == TY_OK) {
        j.order = lists;
        j.queue = lists + count;
        j.by_chart = lists + 2 * count;
        result = sort_faces(&j);
    }
    if (result == TY_OK) result = make_charts(&j);
    if (result == TY_OK) result = join_charts(&j);
    if (result == TY_OK) result = pack_and_place(&j, out);
    if (j.planes != NULL) ty_free_array(context, j.planes, (size_t)j.plane_capacity, sizeof *j.planes);
    if (j.faces != NULL) ty_free_array(context, j.faces, count, sizeof *j.faces);
    if (j.flat != NULL) ty_free_array(context, j.flat, 6 * count, sizeof *j.flat);
    if (j.welded != NULL) ty_free_array(context, j.welded, vertices, sizeof *j.welded);
    if (lists != NULL) ty_free_array(context, lists, 3 * count, sizeof *lists);
    return result;
}

void ty_unwrap_free(ty_context* context, ty_unwrap* unwrap) {
    const size_t count = (size_t)unwrap->triangle_count;
    if (unwrap->uv != NULL) ty_free_array(context, unwrap->uv, 6 * count, sizeof *unwrap->uv);
    if (unwrap->chart != NULL) ty_free_array(context, unwrap->chart, count, sizeof *unwrap->chart);
    *unwrap = (ty_unwrap){.uv = NULL};
}
