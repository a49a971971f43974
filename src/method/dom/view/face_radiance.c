/* Radiance of diffusive cells at their faces. Only the light near a face of theirs is seen, and their means do not hold
 * it. The radiance J_out / pi that leaves the face does, with all collided light; the marcher adds what has scattered
 * once from uncollided light, which is therefore subtracted. */
#include "base/constants.h"
#include "base/context.h"
#include "base/sh.k.h"
#include "method/dom/sources/sources.h"
#include "method/dom/view/view.h"

#include <math.h>

typedef struct face_job {
    const ty_dom* light;
    const ty_light_fluence* lights;
    int32_t light_count;
    const double* eye;
    float* const* radiance;
    uint8_t* at_face;
} face_job;

/* A face that the eye sees: the center of the fine cells behind it, and the cosine at which it is seen. */
typedef struct seen_face {
    ty_vec inside, normal, omega;
    float cosine, depth; /* depth: between faces of those fine cells, m */
} seen_face;

static seen_face see_face(const ty_dom* light, const int32_t cell[3], int face, const double omega[3]) {
    const ty_grid_box *box = &light->box, *fine = &light->fine_box;
    const int axis = face / 2;
    float at[3], normal[3] = {0, 0, 0};
    for (int a = 0; a < 3; ++a)
        at[a] = (float)(box->lower[a] + (cell[a] + 0.5) * (box->upper[a] - box->lower[a]) / box->size[a]);
    seen_face seen = {.depth = (float)((fine->upper[axis] - fine->lower[axis]) / fine->size[axis]),
                      .omega = ty_vec_make((float)omega[0], (float)omega[1], (float)omega[2])};
    const float side = (float)((box->upper[axis] - box->lower[axis]) / box->size[axis]);
    normal[axis] = (face & 1) != 0 ? 1.0f : -1.0f;
    at[axis] += normal[axis] * 0.5f * (side - ty_minf(side, seen.depth));
    seen.inside = ty_vec_load(at);
    seen.normal = ty_vec_load(normal);
    seen.cosine = ty_dot(seen.normal, seen.omega);
    return seen;
}

/* Part of the fine cells' mean fluence that scatters once to the eye: for light through the face phi / (1 + mu / mu_0)
 * of its fluence phi at the face, in a half-space (Chandrasekhar 1960). optical: depth of the fine cells. */
static float part_seen(const ty_light_fluence* light, const seen_face* seen, float optical) {
    if (light->kind >= TY_FLUENCE_P1) return 1;
    const float mu_0 = ty_light_fluence_cosine(light, seen->inside, ty_scale(seen->normal, -1));
    if (!(mu_0 > 0)) return 0;
    const float through = optical / mu_0;
    return 1 / (ty_mean_attenuation(through, ty_attenuation(through)) * (1 + seen->cosine / mu_0));
}

/* Directions out of a face that a flux through it is the mean of: two cosines, four azimuths. */
enum { AZIMUTHS = 4, DIRECTIONS = 2 * AZIMUTHS };
static const double square_cosine[2] = {0.2113248654051871, 0.7886751345948129};

static seen_face look_out(const seen_face* from, int axis, int direction) {
    const double square = square_cosine[direction / AZIMUTHS], sine = sqrt(1 - square);
    const double azimuth = 0.5 * TY_PI_F64 * (direction % AZIMUTHS + 0.5);
    const float along = (float)sqrt(square), normal[3] = {from->normal.x, from->normal.y, from->normal.z};
    float omega[3];
    omega[axis] = normal[axis] * along;
    omega[(axis + 1) % 3] = (float)(sine * cos(azimuth));
    omega[(axis + 2) % 3] = (float)(sine * sin(azimuth));
    seen_face seen = *from;
    seen.omega = ty_vec_load(omega);
    seen.cosine = along;
    return seen;
}

/* Adds the radiance that scatters once at a face, per scattering coefficient: of a light with a direction the mean over
 * the flux through the face, and of others that towards the eye. */
static void add_scattered_once(const face_job* job, const ty_light_fluence* fluence, size_t cell, const seen_face* seen,
                               int axis, float sums[3]) {
    const ty_dom* light = job->light;
    const double point[3] = {(double)seen->inside.x, (double)seen->inside.y, (double)seen->inside.z};
    const ty_cell_point at = ty_coverage_locate(&light->fine_box, point);
    const int count = fluence->kind < TY_FLUENCE_P1 ? DIRECTIONS : 1;
    ty_single_radiance once = {.first = {0}};
    for (int n = 0; n < count; ++n) {
        const seen_face out = count > 1 ? look_out(seen, axis, n) : *seen;
        float passing[TY_FLUENCE_COUNT][3], g[3];
        for (int32_t c = 0; c < 3; ++c) {
            const int32_t plane = light->planes == 3 ? c : 0;
            const float part = part_seen(fluence, &out, light->extinction[plane][cell] * seen->depth) / (float)count;
            for (int f = 0; f < TY_FLUENCE_COUNT; ++f) passing[f][c] = part;
            g[c] = light->g[plane][cell];
        }
        ty_single_scattered(fluence, seen->inside, &at, out.omega, passing, g, NULL, &light->fit, &once);
    }
    for (int c = 0; c < 3; ++c) sums[c] += once.first[c];
}

/* The same of all lights, in units of a channel's solution. */
static float scattered_once(const face_job* job, int32_t channel, size_t cell, const seen_face* seen, int axis) {
    const ty_dom* light = job->light;
    float sums[3] = {0, 0, 0};
    for (int32_t i = 0; i < job->light_count; ++i) add_scattered_once(job, &job->lights[i], cell, seen, axis, sums);
    if (!light->shared) return sums[channel];
    return (sums[0] + sums[1] + sums[2]) / (light->color[0] + light->color[1] + light->color[2]);
}

/* Radiance at a cosine over its mean over the flux, of even light that a half-space reflects: 1 / (1 + c mu), with c =
 * 2 s / (1 - g s)^2. By reciprocity it is the reflected fraction of light incident at that cosine. Without forward
 * scattering it is that of H(mu) = (1 + 2 mu) / (1 + 2 mu s) (Hapke 1981); the rest is a fit to paths in half-spaces of
 * g 0 to 0.9. */
static double even_shape(const ty_dom* light, int32_t plane, size_t cell, double cosine) {
    const double s = (double)light->similarity[plane][cell], g = fmax(0, (double)light->g[plane][cell]);
    const double c = 2 * s / ((1 - g * s) * (1 - g * s));
    const double mean = c > 1e-2 ? 2 * (1 / c - log1p(c) / (c * c)) : 1 - 2 * c / 3;
    return 1 / ((1 + c * cosine) * mean);
}

/* Mean over the faces that the eye sees, by their area in view; false: none. */
static bool mean_of_faces(const face_job* job, int32_t channel, const int32_t cell[3], size_t at, const double omega[3],
                          double* mean) {
    const ty_dom* light = job->light;
    const int32_t plane = light->planes == 3 ? channel : 0;
    double sum = 0, weights = 0;
    for (int face = 0; light->face_fluence[channel] != NULL && face < 6; ++face) {
        const double weight = (face & 1) != 0 ? omega[face / 2] : -omega[face / 2];
        const double leaving = (double)light->face_fluence[channel][6 * at + (size_t)face];
        if (leaving < 0 || weight <= 0) continue;
        const seen_face seen = see_face(light, cell, face, omega);
        const double radiance = (double)TY_SH_0 * leaving - (double)scattered_once(job, channel, at, &seen, face / 2);
        const double slope = (double)light->darkening[plane][at];
        const double even =
            fmin((double)(TY_SH_0 * light->face_even[channel][6 * at + (size_t)face]), fmax(radiance, 0));
        sum += weight * ((fmax(radiance, 0) - even) * (1 + slope * weight) / (1 + slope * (2.0 / 3)) +
                         even * even_shape(light, plane, at, weight));
        weights += weight;
    }
    *mean = weights > 0 ? sum / weights : 0;
    return weights > 0;
}

static void face_row(void* user, int64_t row, int32_t worker) {
    (void)worker;
    const face_job* job = user;
    const int32_t* size = job->light->box.size;
    for (int32_t i = 0; i < size[0]; ++i) {
        const int32_t cell[3] = {i, (int32_t)(row % size[1]), (int32_t)(row / size[1])};
        const size_t at = (size_t)row * (size_t)size[0] + (size_t)i;
        double omega[3], mean;
        ty_dom_direction_to_eye(job->light, cell, job->eye, omega);
        for (int32_t c = 0; c < ty_dom_channels(job->light); ++c) {
            if (!mean_of_faces(job, c, cell, at, omega, &mean)) continue;
            job->radiance[c][at] = (float)mean;
            job->at_face[at] = 1;
        }
    }
}

void ty_dom_show_faces(const ty_dom* light, const ty_light_fluence* lights, const double eye[3],
                       float* const radiance[3], uint8_t* at_face) {
    face_job job = {light, lights, light->fluence_count, eye, radiance, at_face};
    ty_parallel_for(light->context, (int64_t)light->box.size[1] * light->box.size[2], face_row, &job);
}
