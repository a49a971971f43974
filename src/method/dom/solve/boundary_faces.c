/* Light of surfaces between the cells of ordinates. Reflected uncollided light and emission are carried from face to
 * face by sweeps without scattering; their first collisions are a source of the solve with scattering, in which faces
 * reflect collided light. */
#include "base/constants.h"
#include "base/context.h"
#include "direct/surfaces/cut_cells.h"
#include "method/dom/solve/solve.h"
#include "scene/scene.h"
#include "solve/ordinates/divided/joint_solve.h"

#include <math.h>
#include <string.h>

/* Light from surfaces is directional, so more bands are kept for the eye than the scattering source needs: enough that
 * g^l falls to min_power, at most the number that the directions resolve, and at least three for the irradiance of
 * slanted surfaces. */
static const double min_power = 0.02;
/* Of the light between surfaces that scatters nearly straight on: bands for slanted ones, and the tolerance. */
enum { FORWARD_BANDS = 3 };
static const double forward_tolerance = 0.01;
enum { MIN_OUTPUT_BANDS = 3, MAX_OUTPUT_BANDS = 6 };

static int32_t bands_for_boundary(const ty_dom_job* job, double g) {
    const double max_bands = fmin(MAX_OUTPUT_BANDS, fmax(MIN_OUTPUT_BANDS, sqrt(job->set->count / 2.0)));
    return (int32_t)fmin(max_bands, fmax(MIN_OUTPUT_BANDS, g > 0 ? ceil(log(min_power) / log(g)) : 0));
}

ty_result ty_dom_find_boundary(ty_dom_job* job) {
    ty_dom* light = job->light;
    const ty_result result = ty_boundary_faces_find(job->scene, job->coarse, &light->boundary);
    job->boundary = light->boundary;
    if (job->boundary == NULL) return result;
    double g = 0;
    for (int32_t p = 0; p < light->planes; ++p)
        for (size_t i = 0; i < light->cells; ++i) g = fmax(g, fabs((double)light->g[p][i]));
    const int32_t output_bands = bands_for_boundary(job, g);
    if (output_bands > light->output_bands) light->output_bands = output_bands;
    return result;
}

bool ty_dom_boundary_is_gray(const ty_dom_job* job) {
    for (int32_t i = 0; job->boundary != NULL && i < job->boundary->count; ++i) {
        const ty_boundary_side* side = &job->boundary->sides[i];
        for (int c = 0; c < 3; ++c)
            if (side->emission[c] > 0 || side->albedo[c] != side->albedo[0]) return false;
    }
    return !ty_dom_has_outer_surfaces(job) || ty_dom_surfaces_are_gray(job);
}

void ty_dom_free_boundary(ty_dom_job* job) {
    const size_t count = job->boundary != NULL ? (size_t)job->boundary->count : 0;
    for (int c = 0; c < 3; ++c) {
        ty_free_array(job->context, job->wall_albedo[c], count, sizeof(float));
        ty_free_array(job->context, job->wall_radiance[c], count, sizeof(float));
        if (job->incident_radiance[c] != NULL)
            ty_free_array(job->context, job->incident_radiance[c], ty_dom_incident_floats(job), sizeof(float));
    }
}

/* ---- uncollided light ---- */

bool ty_dom_is_within_boundary(const ty_dom_job* job, ty_vec point) {
    return job->boundary != NULL && ty_boundary_contains(job->coarse, point);
}

/* Irradiance of each side, per channel: all of it, and the part in the forward lobe. */
typedef struct side_irradiance {
    float *total[3], *forward[3];
} side_irradiance;

enum { IRRADIANCES = 6 };

static void add_irradiance(const ty_dom_job* job, float* const extinction[3], const side_irradiance* sums) {
    ty_boundary_irradiance_add(job->scene, job->boundary, job->coarse, extinction, job->sources.items,
                               job->sources.count, sums->total, job->light->isotropic ? NULL : sums->forward);
}

static float in_channel_units(const ty_dom* light, float* const rgb[3], int32_t channel, int32_t side) {
    const float total = light->color[0] + light->color[1] + light->color[2];
    return light->shared ? (rgb[0][side] + rgb[1][side] + rgb[2][side]) / total : rgb[channel][side];
}

/* Radiance of sides, in units of the channels: reflected uncollided light and emission. */
static void find_radiance(const ty_dom_job* job, int32_t channel, const side_irradiance* sums) {
    const ty_dom* light = job->light;
    for (int32_t i = 0; i < job->boundary->count; ++i) {
        const ty_boundary_side* side = &job->boundary->sides[i];
        const float irradiance = in_channel_units(light, sums->total, channel, i);
        float emission_factor;
        ty_staircase_albedo(side, side->albedo[channel], &job->wall_albedo[channel][i], &emission_factor);
        job->wall_radiance[channel][i] =
            emission_factor * (side->albedo[channel] * irradiance / TY_PI + side->emission[channel]);
        light->wall_forward[channel][i] = in_channel_units(light, sums->forward, channel, i);
    }
}

static ty_result allocate_memory(ty_dom_job* job, float** scaled, float** irradiance) {
    ty_context* context = job->context;
    const size_t count = (size_t)job->boundary->count, cells = job->coarse->cells;
    for (int32_t c = 0; c < ty_dom_channels(job->light); ++c) {
        job->wall_albedo[c] = ty_alloc_array(context, count, sizeof(float), false);
        job->wall_radiance[c] = ty_alloc_array(context, count, sizeof(float), false);
        job->light->wall_irradiance[c] = ty_alloc_array(context, count, sizeof(float), true);
        job->light->wall_forward[c] = ty_alloc_array(context, count, sizeof(float), true);
        if (job->wall_albedo[c] == NULL || job->wall_radiance[c] == NULL || job->light->wall_irradiance[c] == NULL ||
            job->light->wall_forward[c] == NULL)
            return TY_ERROR_MEMORY;
    }
    *scaled = ty_alloc_array(context, cells, sizeof(float) * (size_t)job->coarse->planes, false);
    *irradiance = ty_alloc_array(context, count, sizeof(float) * IRRADIANCES, true);
    return *scaled != NULL && *irradiance != NULL ? TY_OK : TY_ERROR_MEMORY;
}

/* Finds the cells inside of solids and removes their source: fine cells across a surface leak into it. */
static ty_result find_unlit(ty_dom_job* job) {
    ty_dom* light = job->light;
    const size_t terms = (size_t)(light->bands * light->bands);
    light->unlit = ty_alloc_array(job->context, light->cells, 1, false);
    if (light->unlit == NULL || ty_unlit_cells_find(job->scene, job->boundary, job->coarse, job->sources.items,
                                                    job->sources.count, light->unlit) != TY_OK)
        return TY_ERROR_MEMORY;
    for (int32_t c = 0; c < ty_dom_channels(light); ++c)
        for (size_t t = 0; t < terms; ++t)
            for (size_t i = 0; i < light->cells; ++i)
                if (light->unlit[i] != 0) job->source[c][t * light->cells + i] = 0;
    return TY_OK;
}

static ty_result correct_cut_cells(const ty_dom_job* job) {
    const ty_dom* light = job->light;
    ty_cut_source cut = {.faces = job->boundary,
                         .fine_box = light->fine_box,
                         .lights = light->fluences,
                         .light_count = light->fluence_count,
                         .channels = ty_dom_channels(light),
                         .terms = (size_t)(light->bands * light->bands),
                         .cells = light->cells};
    memcpy(cut.cell, job->coarse->cell, sizeof cut.cell);
    memcpy(cut.source, job->source, sizeof cut.source);
    return ty_cut_cells_correct(job->context, &cut);
}

static ty_result light_faces(ty_dom_job* job) {
    float *scaled = NULL, *irradiance = NULL;
    if (job->boundary == NULL) return TY_OK;
    const size_t count = (size_t)job->boundary->count, cells = job->coarse->cells;
    ty_result result = allocate_memory(job, &scaled, &irradiance);
    if (result == TY_OK) result = correct_cut_cells(job);
    if (result == TY_OK) result = find_unlit(job);
    if (result == TY_OK) {
        side_irradiance sums;
        for (size_t c = 0; c < 3; ++c) {
            sums.total[c] = irradiance + count * c;
            sums.forward[c] = irradiance + count * (3 + c);
        }
        float* planes[3] = {scaled, NULL, NULL};
        for (int32_t p = 1; p < job->coarse->planes; ++p) planes[p] = scaled + cells * (size_t)p;
        ty_grid_medium_reduce(job->coarse, job->light->bands, planes);
        add_irradiance(job, planes, &sums);
        for (int32_t c = 0; c < ty_dom_channels(job->light); ++c) find_radiance(job, c, &sums);
    }
    ty_free_array(job->context, scaled, cells, sizeof(float) * (size_t)job->coarse->planes);
    ty_free_array(job->context, irradiance, count, sizeof(float) * IRRADIANCES);
    return result;
}

ty_result ty_dom_light_boundary(ty_dom_job* job) {
    const ty_result result = light_faces(job);
    return result == TY_OK ? ty_dom_find_incident_radiance(job) : result;
}

bool ty_dom_boundary_is_dark(const ty_dom_job* job, int32_t channel) {
    for (size_t i = 0; job->incident_radiance[channel] != NULL && i < ty_dom_incident_floats(job); ++i)
        if (job->incident_radiance[channel][i] > 0) return false;
    for (int32_t i = 0; job->boundary != NULL && i < job->boundary->count; ++i)
        if (job->wall_radiance[channel][i] > 0) return false;
    return true;
}

/* ---- ordinates ---- */

/* emission: radiance of the sides besides reflection. */
static ty_ordinates_faces ordinates_walls_of(const ty_dom_job* job, int32_t channel, const float* emission) {
    const ty_boundary_faces* walls = job->boundary;
    if (walls == NULL) return (ty_ordinates_faces){.count = 0};
    return (ty_ordinates_faces){.count = walls->count,
                                .first = walls->first,
                                .x = walls->x,
                                .face = walls->face,
                                .albedo = job->wall_albedo[channel],
                                .emission = emission};
}

/* Planes of a problem without scattering, and the irradiance of its sides. */
typedef struct absorbing_planes {
    float *extinction, *zeros, *irradiance, *radiance;
    const float* source[1];
    float* moments[TY_DOM_BANDS_MAX * TY_DOM_BANDS_MAX];
    float* unscattered; /* moments without light that scattered nearly straight on */
} absorbing_planes;

/* Adds the first-collision source of light from surfaces to q_lm: sigma_s (g^l - g^L) phi_lm. Returns its power, W. */
static double add_first_collisions(ty_dom_job* job, int32_t channel, float* const* moments) {
    const ty_dom* light = job->light;
    const int32_t plane = light->planes == 3 ? channel : 0;
    const float *scattering = job->coarse->scattering[plane], *g = job->coarse->g[plane];
    const bool moments_given = ty_dom_legendre(light) != NULL;
    double sum = 0;
    for (size_t i = 0; i < light->cells; ++i) {
        const float forward =
            moments_given ? ty_grid_medium_forward(job->coarse, light->bands) : powf(g[i], (float)light->bands);
        float power = 1;
        for (int32_t l = 0; l < light->bands; ++l, power *= g[i])
            for (int32_t t = l * l; t < (l + 1) * (l + 1); ++t)
                job->source[channel][light->cells * (size_t)t + i] +=
                    scattering[i] * (moments_given ? light->scattered[l] : power - forward) * moments[t][i];
        sum += (double)(scattering[i] * (1 - forward) * moments[0][i]);
    }
    return sum * TY_SQRT_4PI_F64 * job->coarse->cell[0] * job->coarse->cell[1] * job->coarse->cell[2];
}

/* Carries light from side to side through planes->extinction. emission: radiance of the sides besides reflection. */
static ty_result carry_light(ty_dom_job* job, int32_t channel, const ty_ordinates_def* scattering,
                             absorbing_planes* planes, const float* emission, ty_ordinates_stats* stats) {
    ty_ordinates_def def = *scattering;
    planes->source[0] = planes->zeros;
    def.extinction = planes->extinction;
    def.scattering = def.g = planes->zeros;
    def.source = planes->source;
    def.source_terms = 1;
    def.start = NULL;
    def.walls = ordinates_walls_of(job, channel, emission);
    def.walls.irradiance = planes->irradiance;
    def.boundary_radiance = ty_dom_boundary_radiance(job, job->incident_radiance[channel]);
    if (def.boundary_radiance.across[0] != NULL) def.final_set = NULL;
    return ty_ordinates_solve_jointly(job->context, &def, planes->moments, stats);
}

static ty_result solve_without_scattering(ty_dom_job* job, int32_t channel, const ty_ordinates_def* def,
                                          absorbing_planes* planes, ty_dom_boundary_power* power) {
    ty_dom* light = job->light;
    const int32_t plane = light->planes == 3 ? channel : 0;
    const float *sigma = job->coarse->extinction[plane], *scattering = job->coarse->scattering[plane];
    const float* g = job->coarse->g[plane];
    const bool moments_given = ty_dom_legendre(light) != NULL;
    ty_ordinates_stats stats;
    for (size_t i = 0; i < light->cells; ++i) {
        const float forward =
            moments_given ? ty_grid_medium_forward(job->coarse, light->bands) : powf(g[i], (float)light->bands);
        planes->extinction[i] = sigma[i] - forward * scattering[i];
    }
    for (int32_t t = 0; t < light->output_bands * light->output_bands; ++t)
        planes->moments[t] = light->wall_moments[channel] + light->cells * (size_t)t;
    const ty_result result = carry_light(job, channel, def, planes, job->wall_radiance[channel], &stats);
    if (result != TY_OK) return result;
    const double scattered = add_first_collisions(job, channel, planes->moments);
    *power = (ty_dom_boundary_power){.emitted = stats.walls_emitted + stats.entering - scattered,
                                     .absorbed = stats.absorbed - scattered,
                                     .by_walls = stats.walls_absorbed,
                                     .leaving = stats.leaving,
                                     .sweeps = stats.sweeps,
                                     .sweep_seconds = stats.sweep_seconds,
                                     .converged = stats.converged};
    return TY_OK;
}

/* Adds sign times the irradiance that the light of `planes` makes to wall_forward. */
static void add_to_forward(const ty_dom_job* job, const absorbing_planes* planes, float sign, float* forward) {
    const ty_boundary_faces* faces = job->boundary;
    for (int64_t row = 0; row < (int64_t)faces->size[1] * faces->size[2]; ++row)
        for (int32_t i = faces->first[row]; i < faces->first[row + 1]; ++i) {
            const size_t cell = (size_t)row * (size_t)faces->size[0] + (size_t)faces->x[i];
            forward[i] += sign * ty_dom_side_irradiance(job->light, &faces->sides[i], planes->irradiance[i],
                                                        planes->moments[0], FORWARD_BANDS, cell);
        }
}

/* The light of surfaces without what scattered nearly straight on, in place of that of `planes`. */
static ty_result solve_unscattered(ty_dom_job* job, int32_t channel, const ty_ordinates_def* def,
                                   absorbing_planes* planes, ty_dom_boundary_power* power) {
    const ty_dom* light = job->light;
    ty_ordinates_def loose = *def;
    ty_ordinates_stats stats;
    loose.tolerance = fmax(def->tolerance, forward_tolerance);
    loose.bands = 1;
    loose.output_order = FORWARD_BANDS;
    for (int32_t i = 0; i < job->boundary->count; ++i) {
        const ty_boundary_side* side = &job->boundary->sides[i];
        const float reflected = side->albedo[channel] * (1 / TY_PI) * light->wall_forward[channel][i];
        float effective, emission_factor;
        ty_staircase_albedo(side, side->albedo[channel], &effective, &emission_factor);
        planes->radiance[i] = ty_maxf(0, job->wall_radiance[channel][i] - emission_factor * reflected);
    }
    memcpy(planes->extinction, job->coarse->extinction[light->planes == 3 ? channel : 0], light->cells * sizeof(float));
    for (size_t t = 0; t < FORWARD_BANDS * FORWARD_BANDS; ++t)
        planes->moments[t] = planes->unscattered + light->cells * t;
    const ty_result result = carry_light(job, channel, &loose, planes, planes->radiance, &stats);
    if (result != TY_OK) return result;
    power->sweeps += stats.sweeps;
    power->sweep_seconds += stats.sweep_seconds;
    return TY_OK;
}

/* Adds to wall_forward what reaches sides from other sides and has scattered nearly straight on: the light through
 * sigma*, less that through sigma_t, which is all that the paths' picture of surfaces has. */
static ty_result find_forward(ty_dom_job* job, int32_t channel, const ty_ordinates_def* def, absorbing_planes* planes,
                              ty_dom_boundary_power* power) {
    ty_context* context = job->context;
    const size_t sides = (size_t)job->boundary->count, cells = job->light->cells;
    const size_t bytes = sizeof(float) * FORWARD_BANDS * FORWARD_BANDS;
    float* forward = ty_alloc_array(context, sides, sizeof(float), true);
    planes->unscattered = ty_alloc_array(context, cells, bytes, true);
    planes->radiance = ty_alloc_array(context, sides, sizeof(float), false);
    ty_result result =
        planes->unscattered != NULL && planes->radiance != NULL && forward != NULL ? TY_OK : TY_ERROR_MEMORY;
    if (result == TY_OK) {
        add_to_forward(job, planes, 1, forward);
        result = solve_unscattered(job, channel, def, planes, power);
    }
    if (result == TY_OK) {
        add_to_forward(job, planes, -1, forward);
        for (size_t i = 0; i < sides; ++i) job->light->wall_forward[channel][i] += ty_maxf(0, forward[i]);
    }
    ty_free_array(context, forward, sides, sizeof(float));
    ty_free_array(context, planes->unscattered, cells, bytes);
    ty_free_array(context, planes->radiance, sides, sizeof(float));
    return result;
}

ty_result ty_dom_solve_boundary_light(ty_dom_job* job, int32_t channel, const ty_ordinates_def* def,
                                      ty_dom_boundary_power* power) {
    ty_dom* light = job->light;
    const size_t terms = (size_t)(light->output_bands * light->output_bands), cells = light->cells;
    *power = (ty_dom_boundary_power){.converged = true};
    if (ty_dom_boundary_is_dark(job, channel)) return TY_OK;
    absorbing_planes planes = {.extinction = ty_alloc_array(job->context, cells, sizeof(float), false),
                               .zeros = ty_alloc_array(job->context, cells, sizeof(float), true)};
    light->wall_moments[channel] = ty_alloc_array(job->context, cells, terms * sizeof(float), true);
    const size_t sides = job->boundary != NULL ? (size_t)job->boundary->count : 0;
    const bool tells_forward = job->is_narrow && sides > 0 && light->wall_forward[channel] != NULL;
    ty_result result = TY_ERROR_MEMORY;
    if (tells_forward) planes.irradiance = ty_alloc_array(job->context, sides, sizeof(float), true);
    if (planes.extinction != NULL && planes.zeros != NULL && light->wall_moments[channel] != NULL &&
        (!tells_forward || planes.irradiance != NULL))
        result = solve_without_scattering(job, channel, def, &planes, power);
    if (result == TY_OK && tells_forward) result = find_forward(job, channel, def, &planes, power);
    ty_free_array(job->context, planes.irradiance, sides, sizeof(float));
    ty_free_array(job->context, planes.extinction, cells, sizeof(float));
    ty_free_array(job->context, planes.zeros, cells, sizeof(float));
    return result;
}

ty_result ty_dom_set_reflection(ty_dom_job* job, int32_t channel, ty_ordinates_def* def, float** none) {
    *none = NULL;
    if (job->boundary == NULL) return TY_OK;
    *none = ty_alloc_array(job->context, (size_t)job->boundary->count, sizeof(float), true);
    if (*none == NULL) return TY_ERROR_MEMORY;
    def->walls = ordinates_walls_of(job, channel, *none);
    def->walls.irradiance = job->light->wall_irradiance[channel];
    return TY_OK;
}
