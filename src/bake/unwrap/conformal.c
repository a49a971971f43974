/* Least squares conformal maps (Levy, Petitjean, Ray and Maillot 2002) of charts, and their stretch (Sander, Snyder,
 * Gortler and Hoppe 2001). */
#include "bake/unwrap/conformal.h"

#include "base/constants.h"
#include "base/context.h"

#include <math.h>
#include <string.h>

enum { ITERATIONS_MAX = 600 };

/* Squared norm of the residual, relative to the first, at which iterations end. */
static const double tolerance = 1e-10;

typedef struct complex_number {
    double re, im;
} complex_number;

/* A triangle in its own plane: the weights W_j of its corners, divided by the root of d = 2 A (Eq. 2 to 4 there). */
typedef struct row {
    int32_t vertex[3];
    complex_number weight[3];
} row;

typedef struct chart {
    ty_context* context;
    const ty_unwrap_surface* surface;
    const int32_t* triangles;
    int64_t count;
    const uint32_t* point_of; /* one mesh vertex of each vertex of the chart */
    int32_t vertices, pinned[2];
    row* rows;
    complex_number *place, *residual, *gradient, *direction, *image; /* image: 1 per triangle, others per vertex */
    double* diagonal;
} chart;

/* ---- Geometry ---- */

static const float* position(const ty_unwrap_mesh* mesh, int64_t corner) {
    return mesh->positions + 3 * (size_t)mesh->indices[corner];
}

void ty_unwrap_local_triangle(const ty_unwrap_mesh* mesh, int64_t triangle, double local[3]) {
    double u[3], v[3], uu = 0, uv = 0, vv = 0;
    for (int a = 0; a < 3; ++a) {
        u[a] = (double)position(mesh, 3 * triangle + 1)[a] - (double)position(mesh, 3 * triangle)[a];
        v[a] = (double)position(mesh, 3 * triangle + 2)[a] - (double)position(mesh, 3 * triangle)[a];
        uu += u[a] * u[a];
        uv += u[a] * v[a];
        vv += v[a] * v[a];
    }
    local[0] = sqrt(uu);
    local[1] = local[0] > 0 ? uv / local[0] : 0;
    local[2] = sqrt(fmax(vv - local[1] * local[1], 0));
}

bool ty_unwrap_stretch_of(const ty_unwrap_mesh* mesh, int64_t triangle, const float uv[6], double stretch[2]) {
    double local[3];
    ty_unwrap_local_triangle(mesh, triangle, local);
    const double d = local[0] * local[2]; /* twice the area */
    const double a[2] = {(double)uv[2] - (double)uv[0], (double)uv[3] - (double)uv[1]};
    const double b[2] = {(double)uv[4] - (double)uv[0], (double)uv[5] - (double)uv[1]};
    const double mapped = a[0] * b[1] - a[1] * b[0];
    if (!(d > 1e-12 * local[0] * local[0]) || !(fabs(mapped) > 1e-6 * d)) return false;
    /* Derivatives of the surface by u and v, whose lengths and product give the singular values (Sect. 3 there). */
    const double s[3] = {(b[1] * local[0] - a[1] * local[1]) / mapped, -a[1] * local[2] / mapped, 0};
    const double t[3] = {(a[0] * local[1] - b[0] * local[0]) / mapped, a[0] * local[2] / mapped, 0};
    const double ss = s[0] * s[0] + s[1] * s[1], st = s[0] * t[0] + s[1] * t[1], tt = t[0] * t[0] + t[1] * t[1];
    const double root = sqrt((ss - tt) * (ss - tt) + 4 * st * st);
    stretch[0] = sqrt(0.5 * (ss + tt + root));
    stretch[1] = sqrt(fmax(0.5 * (ss + tt - root), 0));
    return true;
}

/* ---- The chart's vertices ---- */

/* Numbers the welded vertices of the chart in surface->number, which holds -1 elsewhere. */
static int32_t number_vertices(const ty_unwrap_surface* s, const int32_t* triangles, int64_t count,
                               uint32_t* point_of) {
    int32_t vertices = 0;
    for (int64_t i = 0; i < 3 * count; ++i) {
        const uint32_t mesh_vertex = s->mesh->indices[3 * (size_t)triangles[i / 3] + (size_t)(i % 3)];
        int32_t* number = &s->number[s->welded[mesh_vertex]];
        if (*number >= 0) continue;
        point_of[vertices] = mesh_vertex;
        *number = vertices++;
    }
    return vertices;
}

static int32_t vertex_of(const ty_unwrap_surface* s, int64_t corner) {
    return s->number[s->welded[s->mesh->indices[corner]]];
}

/* Euler's characteristic V - E + F is 1 (with connected triangles: a disc), and the integral of the absolute Gaussian
 * curvature, which is 2 pi less the angles at each inner vertex, is at most that of a spherical cap which a conformal
 * map takes within the stretch: 4 pi (1 - 1 / stretch^2). */
static bool is_flat_disc(const chart* c, double stretch, double* angles) {
    const ty_unwrap_surface* s = c->surface;
    int64_t inner = 0, outer = 0;
    double curvature = 0;
    for (int32_t v = 0; v < c->vertices; ++v) angles[v] = 0;
    for (int64_t i = 0; i < c->count; ++i) {
        const int32_t triangle = c->triangles[i];
        double local[3];
        ty_unwrap_local_triangle(s->mesh, triangle, local);
        const double at[3][2] = {{0, 0}, {local[0], 0}, {local[1], local[2]}};
        for (int k = 0; k < 3; ++k) {
            const double *p = at[k], *q = at[(k + 1) % 3], *r = at[(k + 2) % 3];
            const double a[2] = {q[0] - p[0], q[1] - p[1]}, b[2] = {r[0] - p[0], r[1] - p[1]};
            angles[vertex_of(s, 3 * (int64_t)triangle + k)] +=
                atan2(fabs(a[0] * b[1] - a[1] * b[0]), a[0] * b[0] + a[1] * b[1]);
        }
        for (int k = 0; k < 3; ++k) {
            const int32_t across = s->faces[triangle].neighbour[k];
            const bool joined = across >= 0 && s->member[across] != 0;
            ++*(joined ? &inner : &outer);
            if (joined) continue;
            for (int end = 0; end < 2; ++end) /* on the outline, where angles are free */
                angles[vertex_of(s, 3 * (int64_t)triangle + (k + end) % 3)] = -INFINITY;
        }
    }
    for (int32_t v = 0; v < c->vertices; ++v)
        if (angles[v] >= 0) curvature += fabs(2 * TY_PI_F64 - angles[v]);
    return c->vertices - (inner / 2 + outer) + c->count == 1 &&
           curvature <= 4 * TY_PI_F64 * (1 - 1 / (stretch * stretch));
}

/* Two vertices far from each other. */
static void pin_vertices(chart* c) {
    const float* positions = c->surface->mesh->positions;
    int32_t from = 0;
    for (int pin = 0; pin < 2; ++pin) {
        double longest = -1;
        int32_t farthest = 0;
        for (int32_t v = 0; v < c->vertices; ++v) {
            const float *a = positions + 3 * (size_t)c->point_of[from], *b = positions + 3 * (size_t)c->point_of[v];
            double square = 0;
            for (int k = 0; k < 3; ++k) square += ((double)a[k] - (double)b[k]) * ((double)a[k] - (double)b[k]);
            if (square <= longest) continue;
            longest = square;
            farthest = v;
        }
        c->pinned[pin] = from = farthest;
    }
}

/* ---- The least squares ---- */

static void make_rows(chart* c) {
    for (int32_t v = 0; v < c->vertices; ++v) c->diagonal[v] = 0;
    for (int64_t i = 0; i < c->count; ++i) {
        double p[3];
        row* r = &c->rows[i];
        ty_unwrap_local_triangle(c->surface->mesh, c->triangles[i], p);
        const double d = p[0] * p[2], scale = d > 1e-12 * p[0] * p[0] ? 1 / sqrt(d) : 0;
        r->weight[0] = (complex_number){scale * (p[1] - p[0]), scale * p[2]};
        r->weight[1] = (complex_number){-scale * p[1], -scale * p[2]};
        r->weight[2] = (complex_number){scale * p[0], 0};
        for (int k = 0; k < 3; ++k) {
            r->vertex[k] = vertex_of(c->surface, 3 * (int64_t)c->triangles[i] + k);
            c->diagonal[r->vertex[k]] += r->weight[k].re * r->weight[k].re + r->weight[k].im * r->weight[k].im;
        }
    }
}

/* out = A x, one number a triangle. */
static void apply(const chart* c, const complex_number* x, complex_number* out) {
    for (int64_t i = 0; i < c->count; ++i) {
        const row* r = &c->rows[i];
        complex_number sum = {0, 0};
        for (int k = 0; k < 3; ++k) {
            const complex_number w = r->weight[k], u = x[r->vertex[k]];
            sum.re += w.re * u.re - w.im * u.im;
            sum.im += w.re * u.im + w.im * u.re;
        }
        out[i] = sum;
    }
}

/* out = A^H x, 0 for pinned vertices. */
static void apply_adjoint(const chart* c, const complex_number* x, complex_number* out) {
    memset(out, 0, (size_t)c->vertices * sizeof *out);
    for (int64_t i = 0; i < c->count; ++i)
        for (int k = 0; k < 3; ++k) {
            const complex_number w = c->rows[i].weight[k];
            complex_number* sum = &out[c->rows[i].vertex[k]];
            sum->re += w.re * x[i].re + w.im * x[i].im;
            sum->im += w.re * x[i].im - w.im * x[i].re;
        }
    for (int pin = 0; pin < 2; ++pin) out[c->pinned[pin]] = (complex_number){0, 0};
}

static double product(const complex_number* a, const complex_number* b, int64_t count) {
    double sum = 0;
    for (int64_t i = 0; i < count; ++i) sum += a[i].re * b[i].re + a[i].im * b[i].im;
    return sum;
}

/* residual, divided by the diagonal, in gradient. */
static void precondition(const chart* c) {
    for (int32_t v = 0; v < c->vertices; ++v) {
        const double scale = c->diagonal[v] > 0 ? 1 / c->diagonal[v] : 0;
        c->gradient[v] = (complex_number){scale * c->residual[v].re, scale * c->residual[v].im};
    }
}

/* Conjugate gradients on A^H A U = 0 with pinned vertices in place. */
static void solve(const chart* c) {
    apply(c, c->place, c->image);
    apply_adjoint(c, c->image, c->residual);
    for (int32_t v = 0; v < c->vertices; ++v) c->residual[v] = (complex_number){-c->residual[v].re, -c->residual[v].im};
    precondition(c);
    memcpy(c->direction, c->gradient, (size_t)c->vertices * sizeof *c->direction);
    double rho = product(c->residual, c->gradient, c->vertices);
    const double first = rho;
    for (int i = 0; i < ITERATIONS_MAX && rho > tolerance * first; ++i) {
        apply(c, c->direction, c->image);
        const double curvature = product(c->image, c->image, c->count);
        if (!(curvature > 0)) return;
        const double step = rho / curvature;
        for (int32_t v = 0; v < c->vertices; ++v) {
            c->place[v].re += step * c->direction[v].re;
            c->place[v].im += step * c->direction[v].im;
        }
        apply_adjoint(c, c->image, c->gradient);
        for (int32_t v = 0; v < c->vertices; ++v) {
            c->residual[v].re -= step * c->gradient[v].re;
            c->residual[v].im -= step * c->gradient[v].im;
        }
        precondition(c);
        const double before = rho;
        rho = product(c->residual, c->gradient, c->vertices);
        for (int32_t v = 0; v < c->vertices; ++v) {
            c->direction[v].re = c->gradient[v].re + rho / before * c->direction[v].re;
            c->direction[v].im = c->gradient[v].im + rho / before * c->direction[v].im;
        }
    }
}

/* The projection across the mean normal, which pins the two vertices and is the first guess. */
static bool project(chart* c) {
    double n[3] = {0, 0, 0}, u[3], v[3];
    for (int64_t i = 0; i < c->count; ++i) {
        const ty_unwrap_face* face = &c->surface->faces[c->triangles[i]];
        for (int a = 0; a < 3; ++a) n[a] += (double)(face->area * face->normal[a]);
    }
    const double length = sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
    for (int a = 0; a < 3; ++a) n[a] = length > 0 ? n[a] / length : a == 2;
    const int minor = fabs(n[0]) <= fabs(n[1]) && fabs(n[0]) <= fabs(n[2]) ? 0 : fabs(n[1]) <= fabs(n[2]) ? 1 : 2;
    for (int a = 0; a < 3; ++a) u[a] = ((a == minor) - n[minor] * n[a]) / sqrt(1 - n[minor] * n[minor]);
    for (int a = 0; a < 3; ++a) v[a] = n[(a + 1) % 3] * u[(a + 2) % 3] - n[(a + 2) % 3] * u[(a + 1) % 3];
    for (int32_t i = 0; i < c->vertices; ++i) {
        const float* p = c->surface->mesh->positions + 3 * (size_t)c->point_of[i];
        c->place[i] = (complex_number){u[0] * (double)p[0] + u[1] * (double)p[1] + u[2] * (double)p[2],
                                       v[0] * (double)p[0] + v[1] * (double)p[1] + v[2] * (double)p[2]};
    }
    const complex_number *a = &c->place[c->pinned[0]], *b = &c->place[c->pinned[1]];
    return hypot(a->re - b->re, a->im - b->im) > 0;
}

/* Scales the map to the surface's area; false where triangles are turned over or stretched too much. */
static bool scale_and_check(const chart* c, double stretch, float* uv) {
    const ty_unwrap_surface* s = c->surface;
    double surface = 0, map = 0, found[2];
    for (int64_t i = 0; i < c->count; ++i) {
        const complex_number *p = &c->place[c->rows[i].vertex[0]], *q = &c->place[c->rows[i].vertex[1]],
                             *r = &c->place[c->rows[i].vertex[2]];
        surface += (double)s->faces[c->triangles[i]].area;
        map += 0.5 * ((q->re - p->re) * (r->im - p->im) - (q->im - p->im) * (r->re - p->re));
    }
    if (!(map > 0) || !(surface > 0)) return false;
    const double scale = sqrt(surface / map);
    for (int64_t i = 0; i < c->count; ++i) {
        float* at = uv + 6 * i;
        for (int k = 0; k < 3; ++k) {
            at[2 * k] = (float)(scale * c->place[c->rows[i].vertex[k]].re);
            at[2 * k + 1] = (float)(scale * c->place[c->rows[i].vertex[k]].im);
        }
        if (!(s->faces[c->triangles[i]].area > 0)) continue;
        const float area = (at[2] - at[0]) * (at[5] - at[1]) - (at[3] - at[1]) * (at[4] - at[0]);
        if (!(area > 0)) return false;
        if (ty_unwrap_stretch_of(s->mesh, c->triangles[i], at, found) && (found[0] > stretch || found[1] * stretch < 1))
            return false;
    }
    return true;
}

/* ---- The whole ---- */

static ty_result allocate(chart* c, void** block, size_t* bytes) {
    const size_t n = (size_t)c->vertices, t = (size_t)c->count;
    *bytes = t * (sizeof(row) + sizeof(complex_number)) + n * (4 * sizeof(complex_number) + sizeof(double));
    char* at = *block = ty_alloc_array(c->context, *bytes, 1, true);
    if (at == NULL) return TY_ERROR_MEMORY;
    complex_number** const arrays[] = {&c->place, &c->residual, &c->gradient, &c->direction};
    c->image = (complex_number*)(void*)at;
    at += t * sizeof(complex_number);
    for (int i = 0; i < 4; ++i, at += n * sizeof(complex_number)) *arrays[i] = (complex_number*)(void*)at;
    c->diagonal = (double*)(void*)at;
    c->rows = (row*)(void*)(at + n * sizeof(double));
    return TY_OK;
}

ty_result ty_unwrap_conformal(ty_context* context, const ty_unwrap_surface* surface, const int32_t* triangles,
                              int64_t count, double stretch, float* uv, bool* made) {
    *made = false;
    uint32_t* point_of = ty_alloc_array(context, 3 * (size_t)count, sizeof *point_of, false);
    if (point_of == NULL) return TY_ERROR_MEMORY;
    chart c = {.context = context, .surface = surface, .triangles = triangles, .count = count, .point_of = point_of};
    void* block = NULL;
    size_t bytes = 0;
    for (int64_t i = 0; i < count; ++i) surface->member[triangles[i]] = 1;
    c.vertices = number_vertices(surface, triangles, count, point_of);
    const ty_result result = allocate(&c, &block, &bytes);
    if (result == TY_OK && is_flat_disc(&c, stretch, c.diagonal)) {
        pin_vertices(&c);
        make_rows(&c);
        if (project(&c)) {
            solve(&c);
            *made = scale_and_check(&c, stretch, uv);
        }
    }
    for (int64_t i = 0; i < count; ++i) surface->member[triangles[i]] = 0;
    for (int32_t v = 0; v < c.vertices; ++v) surface->number[surface->welded[point_of[v]]] = -1;
    if (block != NULL) ty_free_array(context, block, bytes, 1);
    ty_free_array(context, point_of, 3 * (size_t)count, sizeof *point_of);
    return result;
}
