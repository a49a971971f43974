/* Rasterisation of a lightmap: the texels that triangles touch, and their covered fractions. */
#include "base/context.h"
#include "bake/atlas/atlas.h"
#include "scene/surfaces/surface.k.h"

#include <math.h>

/* Texels are processed in bands of rows; each band visits all its triangles in order. */
enum { BAND = 32 };

/* Margin in texels by which a center must be inside all edges, above the rounding of coordinates. */
static const double covers_margin = 0.01;
/* Tolerance in texels for covering a center, so that no center on a shared edge is missed. */
static const double covers_tolerance = -1e-6;
/* Minimum covered fraction of a texel, or of the triangle's own area if that is smaller: charts drawn along texel edges
 * touch their neighbours by rounding. */
static const double min_coverage = 1e-4;
/* Distance of sample points from edges, texels. */
static const double edge_distance = 1.0 / 16;

enum { CLIPPED_MAX = 8 };

typedef struct polygon {
    int count;
    double at[CLIPPED_MAX][2];
} polygon;

/* Clips a polygon to sign * (coordinate - limit) <= 0. */
static polygon clip(const polygon* in, int axis, double limit, double sign) {
    polygon out = {.count = 0};
    for (int i = 0; i < in->count; ++i) {
        const double *a = in->at[i], *b = in->at[(i + 1) % in->count];
        const double side_a = sign * (a[axis] - limit), side_b = sign * (b[axis] - limit);
        if (side_a <= 0) {
            out.at[out.count][0] = a[0];
            out.at[out.count++][1] = a[1];
        }
        if ((side_a < 0 && side_b > 0) || (side_a > 0 && side_b < 0)) {
            const double t = side_a / (side_a - side_b);
            out.at[out.count][1 - axis] = a[1 - axis] + t * (b[1 - axis] - a[1 - axis]);
            out.at[out.count++][axis] = limit;
        }
    }
    return out;
}

static double area_of(const polygon* p) {
    double sum = 0;
    for (int i = 2; i < p->count; ++i)
        sum += (p->at[i - 1][0] - p->at[0][0]) * (p->at[i][1] - p->at[0][1]) -
               (p->at[i][0] - p->at[0][0]) * (p->at[i - 1][1] - p->at[0][1]);
    return 0.5 * fabs(sum);
}

static double area_left_of(const polygon* p, double x) {
    const polygon left = clip(p, 0, x, 1);
    return area_of(&left);
}

/* Twice the signed area. */
static double twice_area(const double corners[3][2]) {
    return (corners[1][0] - corners[0][0]) * (corners[2][1] - corners[0][1]) -
           (corners[2][0] - corners[0][0]) * (corners[1][1] - corners[0][1]);
}

/* Signed distance of a point from the edge opposite to a corner, positive inside. */
static double edge_side(const double corners[3][2], double double_area, int corner, const double point[2]) {
    const double *a = corners[(corner + 1) % 3], *b = corners[(corner + 2) % 3];
    const double along[2] = {b[0] - a[0], b[1] - a[1]};
    const double cross = along[0] * (point[1] - a[1]) - along[1] * (point[0] - a[0]);
    return (double_area < 0 ? -cross : cross) / hypot(along[0], along[1]);
}

static double min_edge_side(const double corners[3][2], double double_area, const double point[2]) {
    double minimum = INFINITY;
    for (int corner = 0; corner < 3; ++corner) minimum = fmin(minimum, edge_side(corners, double_area, corner, point));
    return minimum;
}

static ty_vec position_of(const ty_mesh_def* mesh, size_t triangle, double b1, double b2) {
    float at[3];
    ty_surface_interpolate(mesh->positions, 3, mesh->indices + 3 * triangle, (float)b1, (float)b2, at);
    return ty_vec_load(at);
}

static ty_vec normal_of(const ty_mesh_def* mesh, size_t triangle, float* area) {
    const uint32_t* corner = mesh->indices + 3 * triangle;
    const ty_vec a = ty_vec_load(mesh->positions + 3 * (size_t)corner[0]);
    const ty_vec ab = ty_sub(ty_vec_load(mesh->positions + 3 * (size_t)corner[1]), a);
    const ty_vec ac = ty_sub(ty_vec_load(mesh->positions + 3 * (size_t)corner[2]), a);
    return ty_triangle_normal(ab, ac, area);
}

bool ty_atlas_triangle(const ty_mesh_def* mesh, size_t triangle, int32_t width, int32_t height, double corners[3][2]) {
    const int32_t sides[2] = {width, height};
    for (int corner = 0; corner < 3; ++corner)
        for (int axis = 0; axis < 2; ++axis)
            corners[corner][axis] =
                (double)mesh->uv[1][2 * (size_t)mesh->indices[3 * triangle + (size_t)corner] + (size_t)axis] *
                sides[axis];
    float area;
    normal_of(mesh, triangle, &area);
    return fabs(twice_area(corners)) > 1e-12 && area > 0;
}

/* Barycentric coordinates of the second and third corner. */
static void weights_of(const double corners[3][2], const double point[2], double* b1, double* b2) {
    const double double_area = twice_area(corners);
    const double p[2] = {point[0] - corners[0][0], point[1] - corners[0][1]};
    const double u[2] = {corners[1][0] - corners[0][0], corners[1][1] - corners[0][1]};
    const double v[2] = {corners[2][0] - corners[0][0], corners[2][1] - corners[0][1]};
    *b1 = fmin(fmax((p[0] * v[1] - p[1] * v[0]) / double_area, 0), 1);
    *b2 = fmin(fmax((u[0] * p[1] - u[1] * p[0]) / double_area, 0), 1 - *b1);
}

static void nearest_on_edges(const double corners[3][2], const double point[2], double out[2]) {
    double minimum = INFINITY;
    for (int i = 0; i < 3; ++i) {
        const double *a = corners[i], *b = corners[(i + 1) % 3];
        const double along[2] = {b[0] - a[0], b[1] - a[1]};
        const double square = along[0] * along[0] + along[1] * along[1];
        double t = square > 0 ? ((point[0] - a[0]) * along[0] + (point[1] - a[1]) * along[1]) / square : 0;
        t = fmin(fmax(t, 0), 1);
        const double at[2] = {a[0] + t * along[0], a[1] + t * along[1]};
        const double distance = hypot(at[0] - point[0], at[1] - point[1]);
        if (!(distance < minimum)) continue;
        minimum = distance;
        out[0] = at[0];
        out[1] = at[1];
    }
}

void ty_atlas_texel_point(const double corners[3][2], const double center[2], double* b1, double* b2) {
    const double double_area = twice_area(corners);
    double at[2] = {center[0], center[1]};
    if (min_edge_side(corners, double_area, at) < 0) nearest_on_edges(corners, center, at);
    if (min_edge_side(corners, double_area, at) < edge_distance) {
        /* towards the center of the inscribed circle */
        double incenter[2] = {0, 0}, perimeter = 0;
        for (int i = 0; i < 3; ++i) {
            const double *a = corners[(i + 1) % 3], *b = corners[(i + 2) % 3];
            const double length = hypot(b[0] - a[0], b[1] - a[1]);
            for (int axis = 0; axis < 2; ++axis) incenter[axis] += length * corners[i][axis];
            perimeter += length;
        }
        const double to_center[2] = {incenter[0] / perimeter - at[0], incenter[1] / perimeter - at[1]};
        const double fraction = fmin(edge_distance / fmax(hypot(to_center[0], to_center[1]), 1e-30), 0.5);
        for (int axis = 0; axis < 2; ++axis) at[axis] += fraction * to_center[axis];
    }
    weights_of(corners, at, b1, b2);
}

/* ---- bands ---- */

typedef struct raster_job {
    const ty_mesh_def* mesh;
    int32_t width, height;
    int16_t* rows; /* per triangle: first and last row; first > last: none */
    ty_texel* texels;
    ty_raster* bands;
} raster_job;

enum { BLOCK = 4096 };

static void find_rows(void* user, int64_t index, int32_t worker) {
    (void)worker;
    raster_job* job = user;
    const int64_t end =
        (index + 1) * BLOCK < job->mesh->triangle_count ? (index + 1) * BLOCK : job->mesh->triangle_count;
    for (int64_t t = index * BLOCK; t < end; ++t) {
        double corners[3][2];
        const bool exists = ty_atlas_triangle(job->mesh, (size_t)t, job->width, job->height, corners);
        const double low = fmin(corners[0][1], fmin(corners[1][1], corners[2][1]));
        const double high = fmax(corners[0][1], fmax(corners[1][1], corners[2][1]));
        job->rows[2 * t] = exists ? (int16_t)fmin(fmax(floor(low), 0), job->height - 1) : 1;
        job->rows[2 * t + 1] = exists ? (int16_t)fmin(fmax(floor(high), 0), job->height - 1) : 0;
    }
}

/* True if two triangles that cover a texel center are separate there or face opposite ways. */
static bool are_separate(const raster_job* job, size_t first, size_t second, const double center[2]) {
    ty_vec at[2], normal[2];
    float area = 0;
    double extent = 0;
    for (int i = 0; i < 2; ++i) {
        const size_t triangle = i == 0 ? first : second;
        double corners[3][2], b1, b2;
        ty_atlas_triangle(job->mesh, triangle, job->width, job->height, corners);
        weights_of(corners, center, &b1, &b2);
        at[i] = position_of(job->mesh, triangle, b1, b2);
        normal[i] = normal_of(job->mesh, triangle, &area);
        extent = fmax(extent, sqrt((double)area / (0.5 * fabs(twice_area(corners)))));
    }
    const ty_vec between = ty_sub(at[0], at[1]);
    return sqrt((double)ty_dot(between, between)) > 0.5 * extent || ty_dot(normal[0], normal[1]) < 0;
}

static void cover_texel(const raster_job* job, size_t triangle, const double center[2], double inside, double area,
                        ty_texel* texel, ty_raster* counts) {
    float rank = (float)fmin(area, 1);
    if (inside >= covers_tolerance) rank += 1;
    if (inside > covers_margin) {
        rank += 1;
        if (texel->rank < 2)
            ++counts->centers;
        else if (are_separate(job, (size_t)texel->triangle, triangle, center))
            ++counts->overlaps;
    }
    if (rank > texel->rank) *texel = (ty_texel){.triangle = (int32_t)triangle, .rank = rank};
}

static void draw_row(const raster_job* job, size_t triangle, const double corners[3][2], int32_t y, ty_raster* counts) {
    polygon row = {.count = 3};
    for (int i = 0; i < 3; ++i)
        for (int axis = 0; axis < 2; ++axis) row.at[i][axis] = corners[i][axis];
    row = clip(&row, 1, y, -1);
    row = clip(&row, 1, y + 1, 1);
    if (row.count < 3) return;
    double low = INFINITY, high = -INFINITY;
    for (int i = 0; i < row.count; ++i) {
        low = fmin(low, row.at[i][0]);
        high = fmax(high, row.at[i][0]);
    }
    const int32_t first = (int32_t)fmax(floor(low), 0), last = (int32_t)fmin(floor(high), job->width - 1);
    const double double_area = twice_area(corners), minimum = min_coverage * fmin(0.5 * fabs(double_area), 1);
    double before = area_left_of(&row, first);
    for (int32_t x = first; x <= last; ++x) {
        const double until = area_left_of(&row, x + 1), area = until - before;
        const double center[2] = {x + 0.5, y + 0.5};
        before = until;
        if (area > minimum)
            cover_texel(job, triangle, center, min_edge_side(corners, double_area, center), area,
                        &job->texels[(size_t)y * (size_t)job->width + (size_t)x], counts);
    }
}

static void draw_band(void* user, int64_t index, int32_t worker) {
    (void)worker;
    raster_job* job = user;
    const int32_t low = (int32_t)index * BAND, high = low + BAND < job->height ? low + BAND : job->height;
    ty_raster counts = {0};
    for (size_t i = (size_t)low * (size_t)job->width; i < (size_t)high * (size_t)job->width; ++i)
        job->texels[i] = (ty_texel){.triangle = -1, .rank = 0};
    for (int64_t t = 0; t < job->mesh->triangle_count; ++t) {
        const int32_t first_row = job->rows[2 * t], last_row = job->rows[2 * t + 1];
        if (first_row > last_row || first_row >= high || last_row < low) continue;
        double corners[3][2];
        ty_atlas_triangle(job->mesh, (size_t)t, job->width, job->height, corners);
        for (int32_t y = first_row > low ? first_row : low; y < high && y <= last_row; ++y)
            draw_row(job, (size_t)t, corners, y, &counts);
    }
    job->bands[index] = counts;
}

ty_result ty_atlas_rasterise(ty_context* context, const ty_mesh_def* mesh, int32_t width, int32_t height,
                             ty_texel* texels, ty_raster* out) {
    const size_t rows = 2 * (size_t)mesh->triangle_count, bands = (size_t)(height + BAND - 1) / BAND;
    raster_job job = {.mesh = mesh, .width = width, .height = height, .texels = texels};
    job.rows = ty_alloc_array(context, rows, sizeof *job.rows, false);
    job.bands = ty_alloc_array(context, bands, sizeof *job.bands, true);
    const bool ready = job.rows != NULL && job.bands != NULL;
    *out = (ty_raster){0};
    if (ready) {
        ty_parallel_for(context, (mesh->triangle_count + BLOCK - 1) / BLOCK, find_rows, &job);
        ty_parallel_for(context, (int64_t)bands, draw_band, &job);
    }
    for (size_t i = 0; ready && i < bands; ++i) {
        out->centers += job.bands[i].centers;
        out->overlaps += job.bands[i].overlaps;
    }
    ty_free_array(context, job.rows, rows, sizeof *job.rows);
    ty_free_array(context, job.bands, bands, sizeof *job.bands);
    return ready ? TY_OK : TY_ERROR_MEMORY;
}
