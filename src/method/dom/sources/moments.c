/* The first-collision source of uncollided light as moments on coarse cells (Lewis and Miller 1984;
 * docs/method/dom.md): q_lm = sigma_s (g^l - g^L) phi Y_lm(omega) with delta-M, averaged over fine cells; near a point
 * light with each fine cell's own direction. */
#include "base/context.h"
#include "base/mapping.h"
#include "direct/media/coverage.h"
#include "method/dom/sources/sources.h"
#include "scene/scene.h"
#include "solve/angular/harmonics.h"

#include <math.h>
#include <string.h>

enum { CHUNK = 1 << 15, TERMS_MAX = TY_DOM_BANDS_MAX * TY_DOM_BANDS_MAX };

/* Light of a point has one direction in a cell whose diagonal is at most max_diagonal times its distance. Fine cells
 * within near_distance sides of the light are averaged over NEAR_POINTS^3 points. */
static const double max_diagonal = 0.25, near_distance = 2.5;
enum { NEAR_POINTS = 4 };

/* Tolerance for equal mean cosines, which are means over many samples. */
static const float g_tolerance = 1e-5f;

/* ---- memory ---- */

/* True if all that scatters on a plane of fine cells has the same g, which is returned. */
static bool find_uniform_g(const ty_grid_medium* fine, int32_t plane, float* g) {
    const float* scattering = fine->scattering[plane];
    size_t first = 0;
    while (first < fine->cells && !(scattering[first] > 0)) ++first;
    *g = first < fine->cells ? fine->g[plane][first] : 0;
    for (size_t i = first; i < fine->cells; ++i)
        if (scattering[i] > 0 && fabsf(fine->g[plane][i] - *g) > g_tolerance) return false;
    return true;
}

ty_result ty_dom_scratch_create(const ty_dom_job* job, ty_dom_scratch* scratch) {
    for (int32_t p = 0; p < job->fine->planes; ++p) scratch->uniform[p] = find_uniform_g(job->fine, p, &scratch->g[p]);
    scratch->scattered = ty_alloc_large(job->context, job->fine->cells, sizeof(float), false);
    scratch->means = ty_alloc_large(job->context, job->coarse->cells, TY_DOM_MEANS * sizeof(float), false);
    return scratch->scattered != NULL && scratch->means != NULL ? TY_OK : TY_ERROR_MEMORY;
}

void ty_dom_scratch_destroy(const ty_dom_job* job, ty_dom_scratch* scratch) {
    ty_free_large(job->context, scratch->scattered, job->fine->cells, sizeof(float));
    ty_free_large(job->context, scratch->means, job->coarse->cells, TY_DOM_MEANS * sizeof(float));
}

/* ---- means over coarse cells ---- */

/* The source of one plane of a field. */
typedef struct add_job {
    ty_dom_job* job;
    ty_dom_scratch* scratch;
    const ty_light_fluence* uncollided;
    float cosine;                    /* mean cosine of directional light */
    const float* fluence;            /* of fine cells */
    const float* scattering;         /* of fine cells */
    const float* g;                  /* of fine cells */
    bool uniform;                    /* all that scatters has the same g */
    float coefficient[TY_DOM_MEANS]; /* where uniform: the moments: g^l, or f + c_l of a fit; the last one is the
                                        forward fraction; else 1 */
    int32_t channel_count, channels[3];
    float factor[3]; /* of the fluence, per channel */
} add_job;

/* sigma_s phi of fine cells. */
static void scatter_chunk(void* user, int64_t index, int32_t worker) {
    (void)worker;
    const add_job* add = user;
    const size_t begin = (size_t)index * CHUNK, cells = add->job->fine->cells;
    const size_t end = cells - begin < CHUNK ? cells : begin + CHUNK;
    float* scattered = add->scratch->scattered;
    for (size_t i = begin; i < end; ++i) scattered[i] = add->scattering[i] * add->fluence[i];
}

/* One more factor g. */
static void multiply_g_chunk(void* user, int64_t index, int32_t worker) {
    (void)worker;
    const add_job* add = user;
    const size_t begin = (size_t)index * CHUNK, cells = add->job->fine->cells;
    const size_t end = cells - begin < CHUNK ? cells : begin + CHUNK;
    float* scattered = add->scratch->scattered;
    for (size_t i = begin; i < end; ++i) scattered[i] *= add->g[i];
}

/* means[l] of sigma_s g^l phi over coarse cells, l <= L; of l = 0 alone if g is uniform. */
static void find_means(const add_job* add) {
    const ty_dom_job* job = add->job;
    const int64_t chunks = (int64_t)((job->fine->cells + CHUNK - 1) / CHUNK);
    for (int32_t l = 0; l <= (add->uniform ? 0 : job->light->bands); ++l) {
        ty_parallel_for(job->context, chunks, l == 0 ? scatter_chunk : multiply_g_chunk, (void*)add);
        ty_grid_average(job->context, add->scratch->scattered, job->fine->box.size, job->coarse->box.size,
                        add->scratch->means + job->coarse->cells * (size_t)l);
    }
}

/* Means that, times coefficient[l], are those of sigma_s g^l phi. */
static const float* means_of(const add_job* add, int32_t l) {
    return add->scratch->means + (add->uniform ? 0 : add->job->coarse->cells * (size_t)l);
}

/* ---- moments of points ---- */

static void find_center(const ty_grid_medium* medium, const int32_t cell[3], double at[3]) {
    for (int a = 0; a < 3; ++a) at[a] = medium->box.lower[a] + (cell[a] + 0.5) * medium->cell[a];
}

static double unit_from(const double position[3], const double at[3], double omega[3]) {
    double square = 0;
    for (int a = 0; a < 3; ++a) {
        omega[a] = at[a] - position[a];
        square += omega[a] * omega[a];
    }
    const double length = sqrt(square);
    for (int a = 0; a < 3; ++a) omega[a] = length > 0 ? omega[a] / length : 0;
    return length;
}

/* Relative intensity of the light in a direction: 0 in most of a cell around a spot or a surface light. */
static double intensity_of(const add_job* add, const double omega[3]) {
    const ty_discrete_light* source = &add->uncollided->sample;
    const ty_light_view* light = &ty_scene_get_view(add->job->scene)->lights.lights[source->light];
    const ty_vec to = ty_vec_make((float)omega[0], (float)omega[1], (float)omega[2]);
    return (double)ty_light_profile_at(source->profile, light, ty_dot(source->direction, to));
}

/* Mean harmonics over a fine cell next to the light, weighted by its fluence without media. */
static void near_harmonics(const add_job* add, const double position[3], const double center[3], double* y) {
    const double* cell = add->job->fine->cell;
    const int32_t bands = add->job->light->bands;
    double harmonics[TERMS_MAX], total = 0;
    memset(y, 0, sizeof *y * (size_t)(bands * bands));
    for (int p = 0; p < NEAR_POINTS * NEAR_POINTS * NEAR_POINTS; ++p) {
        const int index[3] = {p % NEAR_POINTS, p / NEAR_POINTS % NEAR_POINTS, p / (NEAR_POINTS * NEAR_POINTS)};
        double at[3], omega[3];
        for (int a = 0; a < 3; ++a) at[a] = center[a] + cell[a] * ((index[a] + 0.5) / NEAR_POINTS - 0.5);
        const double distance = unit_from(position, at, omega);
        if (!(distance > 0)) continue;
        const double weight = intensity_of(add, omega) / (distance * distance);
        ty_harmonics_at(omega, bands, harmonics);
        for (int32_t t = 0; t < bands * bands; ++t) y[t] += weight * harmonics[t];
        total += weight;
    }
    for (int32_t t = 0; t < bands * bands && total > 0; ++t) y[t] /= total;
}

/* Adds a fine cell's contribution to a coarse cell's moments. */
static void add_fine_cell(const add_job* add, const double position[3], const int32_t index[3], double weight,
                          double* moments) {
    const ty_grid_medium* fine = add->job->fine;
    const int32_t bands = add->job->light->bands;
    const int32_t* size = fine->box.size;
    const size_t i = (size_t)index[0] + (size_t)size[0] * ((size_t)index[1] + (size_t)size[1] * (size_t)index[2]);
    const double collisions = weight * (double)add->scattering[i] * (double)add->fluence[i], g = (double)add->g[i];
    double center[3], omega[3], y[TERMS_MAX];
    if (!(collisions > 0)) return;
    find_center(fine, index, center);
    const double distance = unit_from(position, center, omega);
    if (distance < near_distance * fmax(fine->cell[0], fmax(fine->cell[1], fine->cell[2])))
        near_harmonics(add, position, center, y);
    else
        ty_harmonics_at(omega, bands, y);
    const double forward = add->uniform ? (double)add->coefficient[bands] : pow(g, bands);
    double coefficient = 1;
    for (int32_t l = 0; l < bands; ++l, coefficient *= g) {
        const double scattered = (add->uniform ? (double)add->coefficient[l] : coefficient) - forward;
        for (int32_t t = l * l; t < (l + 1) * (l + 1); ++t) moments[t] += collisions * scattered * y[t];
    }
}

/* Moments of a coarse cell near the light, summed over fine cells. */
static void add_near_cell(const add_job* add, const double position[3], const int32_t cell[3], double* moments) {
    const ty_grid_box* box = &add->job->coarse->box;
    const ty_coverage_box cells = {box->lower, box->upper, box->size};
    ty_coverage axes[3];
    memset(moments, 0, TERMS_MAX * sizeof *moments);
    ty_coverage_of_cell(&add->job->fine->box, &cells, cell, axes);
    for (int32_t k = axes[2].first; k < axes[2].first + axes[2].count; ++k)
        for (int32_t j = axes[1].first; j < axes[1].first + axes[1].count; ++j)
            for (int32_t i = axes[0].first; i < axes[0].first + axes[0].count; ++i) {
                const int32_t index[3] = {i, j, k};
                const double weight = ty_coverage_fraction(&axes[0], i) * ty_coverage_fraction(&axes[1], j) *
                                      ty_coverage_fraction(&axes[2], k);
                if (weight > 0) add_fine_cell(add, position, index, weight, moments);
            }
}

/* Moments of a cell with a single direction of light: (g^l - g^L) sigma_s phi Y_lm. */
static void add_far_cell(const add_job* add, const double* y, size_t cell, double* moments) {
    const int32_t bands = add->job->light->bands;
    const double forward = (double)(add->coefficient[bands] * means_of(add, bands)[cell]);
    for (int32_t l = 0; l < bands; ++l) {
        const double scattered = (double)(add->coefficient[l] * means_of(add, l)[cell]) - forward;
        for (int32_t t = l * l; t < (l + 1) * (l + 1); ++t) moments[t] = scattered * y[t];
    }
}

static void store_moments(const add_job* add, size_t cell, const double* moments) {
    const ty_dom* light = add->job->light;
    for (int32_t n = 0; n < add->channel_count; ++n) {
        float* source = add->job->source[add->channels[n]] + cell;
        for (int32_t t = 0; t < light->bands * light->bands; ++t)
            source[light->cells * (size_t)t] += (float)((double)add->factor[n] * moments[t]);
    }
}

static void add_point_row(void* user, int64_t row, int32_t worker) {
    (void)worker;
    const add_job* add = user;
    const ty_grid_medium* coarse = add->job->coarse;
    const int32_t* size = coarse->box.size;
    const double position[3] = {(double)add->uncollided->sample.position.x, (double)add->uncollided->sample.position.y,
                                (double)add->uncollided->sample.position.z};
    const double* side = coarse->cell;
    const double diagonal = sqrt(side[0] * side[0] + side[1] * side[1] + side[2] * side[2]);
    double moments[TERMS_MAX];
    for (int32_t i = 0; i < size[0]; ++i) {
        const int32_t cell[3] = {i, (int32_t)(row % size[1]), (int32_t)(row / size[1])};
        const size_t at = (size_t)row * (size_t)size[0] + (size_t)i;
        double center[3], omega[3], y[TERMS_MAX];
        if (!(add->scratch->means[at] > 0)) continue;
        find_center(coarse, cell, center);
        if (diagonal > max_diagonal * unit_from(position, center, omega)) {
            add_near_cell(add, position, cell, moments);
        } else {
            ty_harmonics_at(omega, add->job->light->bands, y);
            add_far_cell(add, y, at, moments);
        }
        store_moments(add, at, moments);
    }
}

/* ---- moments of directions ---- */

static void add_directional_row(void* user, int64_t row, int32_t worker) {
    (void)worker;
    const add_job* add = user;
    ty_dom* light = add->job->light;
    const int32_t width = light->box.size[0], bands = light->bands;
    const double omega[3] = {(double)add->uncollided->sample.direction.x, (double)add->uncollided->sample.direction.y,
                             (double)add->uncollided->sample.direction.z};
    const size_t at = (size_t)row * (size_t)width;
    const float* forward = means_of(add, bands) + at;
    float b_l = 1;
    double y[TERMS_MAX];
    ty_harmonics_at(omega, add->job->light->bands, y);
    for (int32_t n = 0; n < add->channel_count; ++n, b_l = 1)
        for (int32_t l = 0; l < bands; ++l, b_l *= add->cosine) {
            const float* collisions = means_of(add, l) + at;
            for (int32_t t = l * l; t < (l + 1) * (l + 1); ++t) {
                const float factor = add->factor[n] * b_l * (float)y[t];
                const float plus = factor * add->coefficient[l], minus = factor * add->coefficient[bands];
                float* out = add->job->source[add->channels[n]] + light->cells * (size_t)t + at;
                for (int32_t i = 0; i < width; ++i) out[i] += plus * collisions[i] - minus * forward[i];
            }
        }
}

/* ---- all planes of a field ---- */

float ty_dom_channel_factor(const ty_dom* light, const ty_light_field* field, int32_t plane, int32_t channel) {
    if (field->planes == 3) return plane == channel ? 1 : 0;
    if (!light->shared) return field->color[channel];
    return (field->color[0] + field->color[1] + field->color[2]) /
           (light->color[0] + light->color[1] + light->color[2]);
}

/* The channels that a plane of a field contributes to, and its factors. */
static void choose_channels(add_job* add, const ty_light_field* field, int32_t plane) {
    const ty_dom* light = add->job->light;
    add->channel_count = 0;
    for (int32_t c = 0; c < ty_dom_channels(light); ++c) {
        if (field->planes == 3 && c != plane) continue;
        add->factor[add->channel_count] = ty_dom_channel_factor(light, field, plane, c);
        add->channels[add->channel_count++] = c;
    }
}

static void find_coefficients(add_job* add, float g) {
    const ty_dom* light = add->job->light;
    add->coefficient[0] = 1;
    for (int32_t l = 1; l < TY_DOM_MEANS; ++l) add->coefficient[l] = add->uniform ? add->coefficient[l - 1] * g : 1;
    if (ty_dom_legendre(light) != NULL) {
        memcpy(add->coefficient, light->legendre, (size_t)light->bands * sizeof *add->coefficient);
        add->coefficient[light->bands] = ty_grid_medium_forward(add->job->fine, light->bands);
    }
    if (light->fit.bands == 0) return;
    const float forward = light->fit.forward_fraction;
    for (int32_t l = 0; l < light->bands; ++l) add->coefficient[l] = forward + light->fit.moments[l];
    add->coefficient[light->bands] = forward;
}

void ty_dom_add_first_collisions(ty_dom_job* job, const ty_light_field* field, const ty_light_fluence* uncollided,
                                 float cosine, ty_dom_scratch* scratch) {
    const ty_grid_medium* fine = job->fine;
    const ty_dom* light = job->light;
    const int64_t rows = (int64_t)light->box.size[1] * light->box.size[2];
    add_job add = {.job = job, .scratch = scratch, .uncollided = uncollided, .cosine = cosine};
    for (int32_t p = 0; p < field->planes; ++p) {
        const int32_t plane = fine->planes == 3 ? p : 0;
        add.fluence = field->fluence[p];
        add.scattering = fine->scattering[plane];
        add.g = fine->g[plane];
        add.uniform = scratch->uniform[plane] || light->fit.bands > 0 || ty_dom_legendre(light) != NULL;
        find_coefficients(&add, scratch->g[plane]);
        choose_channels(&add, field, p);
        find_means(&add);
        ty_parallel_for(job->context, rows, uncollided->kind == TY_FLUENCE_POINT ? add_point_row : add_directional_row,
                        &add);
    }
}
