/* A point source by the diffusion solver. The unit of length is the mean free path. */
#include "cli/figures/fld_point_solve.h"

#include "base/context.h"
#include "cli/figures/point_transport.h"

#include <math.h>

static const int steps_along[POINT_DIRECTIONS][3] = {{1, 0, 0}, {1, 1, 0}, {1, 1, 1}};

/* Arrays of a solve, and how large they are. */
typedef struct point_arrays {
    size_t cells, faces;
    float *extinction, *absorption, *source, *fluence, *face;
} point_arrays;

static size_t cell_index(int32_t n, int32_t x, int32_t y, int32_t z) {
    return ((size_t)z * (size_t)n + (size_t)y) * (size_t)n + (size_t)x;
}

static void free_arrays(ty_context* context, point_arrays* arrays) {
    ty_free_array(context, arrays->extinction, arrays->cells, sizeof(float));
    ty_free_array(context, arrays->absorption, arrays->cells, sizeof(float));
    ty_free_array(context, arrays->source, arrays->cells, sizeof(float));
    ty_free_array(context, arrays->fluence, arrays->cells, sizeof(float));
    ty_free_array(context, arrays->face, arrays->faces, sizeof(float));
}

static ty_result make_arrays(ty_context* context, int32_t n, point_arrays* out) {
    *out = (point_arrays){.cells = (size_t)n * (size_t)n * (size_t)n, .faces = (size_t)n * (size_t)n};
    out->extinction = ty_alloc_array(context, out->cells, sizeof(float), false);
    out->absorption = ty_alloc_array(context, out->cells, sizeof(float), false);
    out->source = ty_alloc_array(context, out->cells, sizeof(float), true);
    out->fluence = ty_alloc_array(context, out->cells, sizeof(float), false);
    out->face = ty_alloc_array(context, out->faces, sizeof(float), false);
    const bool complete = out->extinction != NULL && out->absorption != NULL && out->source != NULL &&
                          out->fluence != NULL && out->face != NULL;
    if (!complete) free_arrays(context, out);
    return complete ? TY_OK : TY_ERROR_MEMORY;
}

static void fill_arrays(const point_case* which, const point_arrays* arrays) {
    const int32_t n = which->cells, middle = n / 2;
    const double cell = POINT_EXTENT / n;
    for (size_t i = 0; i < arrays->cells; ++i) {
        arrays->extinction[i] = 1;
        arrays->absorption[i] = (float)(1 - which->albedo);
    }
    arrays->source[cell_index(n, middle, middle, middle)] = (float)(1 / (cell * cell * cell));
    /* One face stands for all six: the problem looks alike from everywhere. */
    for (int32_t y = 0; y < n; ++y)
        for (int32_t x = 0; x < n; ++x) {
            const double dx = (x - middle) * cell, dy = (y - middle) * cell, dz = POINT_EXTENT / 2;
            arrays->face[(size_t)y * (size_t)n + (size_t)x] =
                (float)(transport_diffusion(which->albedo, sqrt(dx * dx + dy * dy + dz * dz)) / (4 * TRANSPORT_PI));
        }
}

static void take_samples(const point_case* which, const float* fluence, point_profile* out) {
    const int32_t n = which->cells, middle = n / 2;
    out->count = 0;
    for (int d = 0; d < POINT_DIRECTIONS; ++d) {
        const int* step = steps_along[d];
        const double length = POINT_EXTENT / n * sqrt(step[0] + step[1] + step[2]);
        for (int32_t i = 1; i <= middle; ++i) {
            const size_t at = cell_index(n, middle + i * step[0], middle + i * step[1], middle + i * step[2]);
            out->samples[out->count++] = (point_sample){i * length, 4 * TRANSPORT_PI * (double)fluence[at]};
        }
    }
}

ty_result point_solve(ty_context* context, const point_case* which, ty_progress_fn progress, void* progress_user,
                      point_profile* out) {
    point_arrays arrays;
    ty_result result = make_arrays(context, which->cells, &arrays);
    if (result != TY_OK) return result;
    fill_arrays(which, &arrays);
    ty_diffusion_def def = ty_default_diffusion_def();
    for (int axis = 0; axis < 3; ++axis) {
        def.size[axis] = which->cells;
        def.cell[axis] = POINT_EXTENT / which->cells;
    }
    for (int side = 0; side < 6; ++side)
        def.boundary[side] = (ty_boundary){TY_BOUNDARY_DIRICHLET, which->diffusive_faces ? arrays.face : NULL};
    def.extinction = arrays.extinction;
    def.absorption = arrays.absorption;
    def.source = arrays.source;
    def.limiter = which->limiter;
    def.progress = progress;
    def.progress_user = progress_user;
    const ty_diffusion_out fields = {.fluence = arrays.fluence};
    result = ty_diffusion_solve(context, &def, &fields, &out->stats);
    if (result == TY_OK) take_samples(which, arrays.fluence, out);
    free_arrays(context, &arrays);
    return result;
}

static bool within(const point_sample* sample, double from, double to) {
    return sample->tau >= from && sample->tau <= to;
}

point_difference point_compare(const point_profile* profile, double (*theory)(double albedo, double tau), double albedo,
                               double from, double to) {
    point_difference difference = {0, 0};
    int32_t count = 0;
    for (int32_t i = 0; i < profile->count; ++i) {
        const point_sample* sample = &profile->samples[i];
        if (!within(sample, from, to)) continue;
        const double error = fabs(sample->fluence / theory(albedo, sample->tau) - 1);
        difference.mean += error;
        difference.largest = fmax(difference.largest, error);
        ++count;
    }
    difference.mean /= count;
    return difference;
}

double point_slope(const point_profile* profile, double from, double to) {
    double n = 0, x = 0, y = 0, xx = 0, xy = 0;
    for (int32_t i = 0; i < profile->count; ++i) {
        const point_sample* sample = &profile->samples[i];
        if (!within(sample, from, to)) continue;
        const double u = log(sample->tau), v = log(sample->fluence);
        n += 1;
        x += u;
        y += v;
        xx += u * u;
        xy += u * v;
    }
    return (n * xy - x * y) / (n * xx - x * x);
}
