/* Unwrapping: charts are grown, projected, freed from overlaps, rotated, and packed. */
#include "bake/unwrap/unwrap.h"
#include "base/context.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { TURNS = 32, ROUNDS = 16, OVERLAP_SIDE_MAX = 2048 };

/* Rows of a chart's plane, and the box of its triangles in it, m. */
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

/* The turn about the normal with the smallest box. Right-handed, so that no chart is mirrored. */
static void find_axes(const job* j, plane* p) {
    float n[3], u[3], v[3];
    find_normal(j, p, n);
    const int minor = fabsf(n[0]) <= fabsf(n[1]) && fabsf(n[0]) <= fabsf(n[2]) ? 0 : fabsf(n[1]) <= fabsf(n[2]) ? 1 : 2;
    const float length = sqrtf(1 - n[minor] * n[minor]);
    for (int a = 0; a < 3; ++a) u[a] = ((a == minor) - n[minor] * n[a]) / length;
    for (int a = 0; a < 3; ++a) v[a] = n[(a + 1) % 3] * u[(a + 2) % 3] - n[(a + 2) % 3] * u[(a + 1) % 3];
    plane best = *p;
    float smallest = INFINITY;
    for (int turn = 0; turn < TURNS; ++turn) {
        const float angle = 1.57079633f * (float)turn / TURNS, c = cosf(angle), s = sinf(angle);
        for (int a = 0; a < 3; ++a) {
            p->axes[0][a] = c * u[a] + s * v[a];
            p->axes[1][a] = c * v[a] - s * u[a];
        }
        find_box(j, p);
        const float area = (p->high[0] - p->low[0]) * (p->high[1] - p->low[1]);
        if (area < 0.9999f * smallest) {
            smallest = area;
            best = *p;
        }
    }
    *p = best;
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

/* Marks the points of a raster that are within a triangle; true if another triangle was there. */
static bool cover(float p[3][2], int32_t width, int32_t height, uint8_t* owned) {
    float low[2], high[2];
    for (int b = 0; b < 2; ++b) {
        low[b] = fminf(fminf(p[0][b], p[1][b]), p[2][b]);
        high[b] = fmaxf(fmaxf(p[0][b], p[1][b]), p[2][b]);
    }
    const float area = (p[1][0] - p[0][0]) * (p[2][1] - p[0][1]) - (p[1][1] - p[0][1]) * (p[2][0] - p[0][0]);
    if (!(fabsf(area) > 1e-12f)) return false;
    bool met = false;
    for (int pass = 0; pass < 2 && !met; ++pass)
        for (int32_t y = (int32_t)fmaxf(low[1], 0); y <= (int32_t)high[1] && y < height; ++y)
            for (int32_t x = (int32_t)fmaxf(low[0], 0); x <= (int32_t)high[0] && x < width; ++x) {
                const float at[2] = {(float)x + 0.5f, (float)y + 0.5f};
                float smallest = INFINITY;
                for (int k = 0; k < 3; ++k) {
                    const float *a = p[k], *b = p[(k + 1) % 3];
                    const float side = (b[0] - a[0]) * (at[1] - a[1]) - (b[1] - a[1]) * (at[0] - a[0]);
                    smallest = fminf(smallest, side / area);
                }
                if (!(smallest > 1e-4f)) continue; /* points on edges belong to nobody */
                if (pass == 0)
                    met = met || owned[(size_t)y * (size_t)width + (size_t)x];
                else
                    owned[(size_t)y * (size_t)width + (size_t)x] = 1;
            }
    return met;
}

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
        if (!steep && !cover(at, width, height, owned)) continue;
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

static ty_result pack(job* j, ty_unwrap* out, ty_unwrap_rectangle* rectangles) {
    out->density = j->def->density;
    for (;;) {
        for (int32_t c = 0; c < j->charts; ++c) {
            const plane* p = &j->planes[c];
            rectangles[c].width = (int32_t)ceil((double)(p->high[0] - p->low[0]) * out->density) + 1 + j->def->padding;
            rectangles[c].height = (int32_t)ceil((double)(p->high[1] - p->low[1]) * out->density) + 1 + j->def->padding;
        }
        const ty_result result = ty_unwrap_pack(j->context, rectangles, j->charts, &out->width, &out->height);
        const int32_t side = out->width > out->height ? out->width : out->height;
        if (result != TY_OK || side <= TY_UNWRAP_SIDE_MAX || out->density < 1e-9 * j->def->density) return result;
        out->density *= 0.95 * TY_UNWRAP_SIDE_MAX / side;
    }
}

static void place(const job* j, const ty_unwrap_rectangle* rectangles, ty_unwrap* out) {
    double covered = 0, surface = 0;
    const double half = 0.5 * (1 + j->def->padding);
    for (int32_t c = 0; c < j->charts; ++c) {
        const plane* p = &j->planes[c];
        for (int64_t i = 0; i < p->count; ++i) {
            const int32_t triangle = j->by_chart[p->first + i];
            const ty_unwrap_face* face = &j->faces[triangle];
            double at[3][2];
            for (int k = 0; k < 3; ++k)
                for (int b = 0; b < 2; ++b) {
                    at[k][b] = (b == 0 ? rectangles[c].x : rectangles[c].y) + half +
                               (double)(along(p->axes[b], corner(j, triangle, k)) - p->low[b]) * out->density;
                    out->uv[6 * (size_t)triangle + 2 * (size_t)k + (size_t)b] =
                        (float)(at[k][b] / (b == 0 ? out->width : out->height));
                }
            const double texels = 0.5 * fabs((at[1][0] - at[0][0]) * (at[2][1] - at[0][1]) -
                                             (at[1][1] - at[0][1]) * (at[2][0] - at[0][0]));
            /* A plane shortens lengths at most by the cosine between the normals, which is the ratio of the areas. */
            const double flat = (double)face->area * out->density * out->density;
            if (texels > 1e-6 * flat && texels > 1e-9) {
                out->stretch = fmax(out->stretch, flat / texels);
                out->mean_stretch += (double)face->area * flat / texels;
                surface += (double)face->area;
            }
            covered += texels;
            out->chart[triangle] = c;
        }
    }
    out->fill = covered / ((double)out->width * out->height);
    out->mean_stretch = surface > 0 ? out->mean_stretch / surface : 1;
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

static ty_result pack_and_place(job* j, ty_unwrap* out) {
    ty_unwrap_rectangle* rectangles = ty_alloc_array(j->context, (size_t)j->charts, sizeof *rectangles, false);
    ty_result result = rectangles == NULL ? TY_ERROR_MEMORY : pack(j, out, rectangles);
    if (result == TY_OK) place(j, rectangles, out);
    if (rectangles != NULL) ty_free_array(j->context, rectangles, (size_t)j->charts, sizeof *rectangles);
    out->charts = j->charts;
    return result;
}

ty_result ty_unwrap_mesh_create(ty_context* context, const ty_unwrap_mesh* mesh, const ty_unwrap_def* def,
                                ty_unwrap* out) {
    const size_t count = (size_t)mesh->triangle_count;
    *out = (ty_unwrap){.triangle_count = mesh->triangle_count, .stretch = 1};
    job j = {.context = context, .mesh = mesh, .def = def};
    int32_t* lists = ty_alloc_array(context, 3 * count, sizeof *lists, false);
    j.faces = ty_alloc_array(context, count, sizeof *j.faces, false);
    out->uv = ty_alloc_array(context, 6 * count, sizeof *out->uv, false);
    out->chart = ty_alloc_array(context, count, sizeof *out->chart, false);
    const bool made = lists != NULL && j.faces != NULL && out->uv != NULL && out->chart != NULL;
    ty_result result = made ? ty_unwrap_find_faces(context, mesh, j.faces) : TY_ERROR_MEMORY;
    if (result == TY_OK) {
        j.order = lists;
        j.queue = lists + count;
        j.by_chart = lists + 2 * count;
        result = sort_faces(&j);
    }
    if (result == TY_OK) result = make_charts(&j);
    if (result == TY_OK) result = pack_and_place(&j, out);
    if (j.planes != NULL) ty_free_array(context, j.planes, (size_t)j.plane_capacity, sizeof *j.planes);
    if (j.faces != NULL) ty_free_array(context, j.faces, count, sizeof *j.faces);
    if (lists != NULL) ty_free_array(context, lists, 3 * count, sizeof *lists);
    return result;
}

void ty_unwrap_free(ty_context* context, ty_unwrap* unwrap) {
    const size_t count = (size_t)unwrap->triangle_count;
    if (unwrap->uv != NULL) ty_free_array(context, unwrap->uv, 6 * count, sizeof *unwrap->uv);
    if (unwrap->chart != NULL) ty_free_array(context, unwrap->chart, count, sizeof *unwrap->chart);
    *unwrap = (ty_unwrap){.uv = NULL};
}
