/* A point source by the diffusion solver. The unit of length is the mean free path. */
#include "figures/fld_point_solve.h"

#include "base/context.h"
#include "bench/fld_box.h"
#include "figures/point_transport.h"

#include <math.h>

static const int steps_along[POINT_DIRECTIONS][3] = {{1, 0, 0}, {1, 1, 0}, {1, 1, 1}};

static void fill_box(const point_case* which, fld_box* box) {
    const double cell = box->def.cell[0];
    const int32_t center = box->edge / 2;
    for (size_t i = 0; i < box->cells; ++i) {
        box->extinction[i] = 1;
        box->absorption[i] = (float)(1 - which->albedo);
    }
    box->source[fld_box_at(box, center, center, center)] = (float)(1 / (cell * cell * cell));
}

/* Fluence of classical diffusion on a face of the cube; from the source all six look alike. */
static void fill_face(const point_case* which, const fld_box* box, float* face) {
    const int32_t n = box->edge, center = n / 2;
    const double cell = box->def.cell[0], dz = POINT_EXTENT / 2;
    for (int32_t y = 0; y < n; ++y)
        for (int32_t x = 0; x < n; ++x) {
            const double dx = (x - center) * cell, dy = (y - center) * cell;
            face[(size_t)y * (size_t)n + (size_t)x] =
                (float)(transport_diffusion(which->albedo, sqrt(dx * dx + dy * dy + dz * dz)) / (4 * TY_PI_F64));
        }
}

static void collect_samples(const fld_box* box, point_profile* out) {
    const int32_t center = box->edge / 2;
    out->count = 0;
    for (int d = 0; d < POINT_DIRECTIONS; ++d) {
        const int* step = steps_along[d];
        const double length = box->def.cell[0] * sqrt(step[0] + step[1] + step[2]);
        for (int32_t i = 1; i <= center; ++i) {
            const size_t at = fld_box_at(box, center + i * step[0], center + i * step[1], center + i * step[2]);
            out->samples[out->count++] = (point_sample){i * length, 4 * TY_PI_F64 * (double)box->fluence[at]};
        }
    }
}

ty_result point_solve(ty_context* context, const point_case* which, ty_progress_fn progress, void* progress_user,
                      point_profile* out) {
    fld_box box;
    ty_result result = fld_make_box(context, which->cells, POINT_EXTENT, &box);
    if (result != TY_OK) return result;
    const size_t faces = (size_t)box.edge * (size_t)box.edge;
    float* face = ty_alloc_array(context, faces, sizeof *face, false);
    if (face == NULL) {
        fld_free_box(context, &box);
        return TY_ERROR_MEMORY;
    }
    fill_box(which, &box);
    fill_face(which, &box, face);
    for (int side = 0; side < 6 && which->diffusive_faces; ++side) box.def.boundary[side].value = face;
    box.def.limiter = which->limiter;
    box.def.progress = progress;
    box.def.progress_user = progress_user;
    const ty_diffusion_out fields = {.fluence = box.fluence};
    result = ty_diffusion_solve(context, &box.def, &fields, &out->stats);
    if (result == TY_OK) collect_samples(&box, out);
    ty_free_array(context, face, faces, sizeof *face);
    fld_free_box(context, &box);
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
