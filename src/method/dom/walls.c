/* Surfaces as walls between the cells of ordinates: what they send of light that has not scattered, which sweeps carry
 * from wall to wall until it does, and what they send of the rest. */
#include "base/context.h"
#include "method/dom/job.h"
#include "scene/scene.h"

#include <math.h>
#include <string.h>

static const double sqrt_four_pi = 3.5449077018110318;

/* Walls send light one way, of which phase functions make more than of what has scattered: so many bands are kept for
 * the eye that what is left of g^l is about this, but no more than directions tell apart; three at least, which is what
 * surfaces that are slanted take. */
static const double least_power = 0.02;
enum { LEAST_KEPT = 3, MOST_KEPT = 6 };

static int32_t bands_for_walls(const ty_dom_job* job, double g) {
    const double most = fmin(MOST_KEPT, fmax(LEAST_KEPT, sqrt(job->set->count / 2.0)));
    return (int32_t)fmin(most, fmax(LEAST_KEPT, g > 0 ? ceil(log(least_power) / log(g)) : 0));
}

ty_result ty_dom_find_walls(ty_dom_job* job) {
    ty_dom* light = job->light;
    const ty_result result = ty_walls_find(job->scene, job->coarse, &light->walls);
    job->walls = light->walls;
    if (job->walls == NULL) return result;
    double g = 0;
    for (int32_t p = 0; p < light->planes; ++p)
        for (size_t i = 0; i < light->cells; ++i) g = fmax(g, fabs((double)light->g[p][i]));
    const int32_t kept = bands_for_walls(job, g);
    if (kept > light->kept) light->kept = kept;
    return result;
}

bool ty_dom_walls_share(const ty_dom_job* job) {
    for (int32_t i = 0; job->walls != NULL && i < job->walls->count; ++i) {
        const ty_wall* side = &job->walls->sides[i];
        for (int c = 0; c < 3; ++c)
            if (side->emission[c] > 0 || side->albedo[c] != side->albedo[0]) return false;
    }
    return !ty_dom_reaches_out(job) || ty_dom_is_gray(job);
}

void ty_dom_free_walls(ty_dom_job* job) {
    const size_t count = job->walls != NULL ? (size_t)job->walls->count : 0;
    for (int c = 0; c < 3; ++c) {
        ty_free_array(job->context, job->wall_albedo[c], count, sizeof(float));
        ty_free_array(job->context, job->wall_light[c], count, sizeof(float));
        ty_free_array(job->context, job->inflow[c], TY_ORDINATES_MAX, sizeof(float));
    }
}

/* ---- uncollided light ---- */

bool ty_dom_is_walled(const ty_dom_job* job, ty_vec point) {
    const float at[3] = {point.x, point.y, point.z};
    const ty_grid_medium* medium = job->coarse;
    bool inside = job->walls != NULL;
    for (int a = 0; a < 3; ++a)
        inside = inside && (double)at[a] > medium->box.lower[a] - 0.5 * medium->cell[a] &&
                 (double)at[a] < medium->box.upper[a] + 0.5 * medium->cell[a];
    return inside;
}

/* What each side gets, of all channels, and the part of it that has scattered nearly straight on. */
typedef struct wall_sums {
    float *all[3], *forward[3];
} wall_sums;

enum { SUMS = 6 };

static void light_walls(const ty_dom_job* job, float* const extinction[3], const wall_sums* sums) {
    ty_walls_light(job->scene, job->walls, job->coarse, extinction, job->sources, job->source_count, sums->all,
                   job->light->even ? NULL : sums->forward);
}

static float in_units(const ty_dom* light, float* const rgb[3], int32_t channel, int32_t side) {
    const float total = light->color[0] + light->color[1] + light->color[2];
    return light->shared ? (rgb[0][side] + rgb[1][side] + rgb[2][side]) / total : rgb[channel][side];
}

/* What walls send besides what they reflect of light that ordinates carry, in units of the channels. */
static void send_light(const ty_dom_job* job, int32_t channel, const wall_sums* sums) {
    const ty_dom* light = job->light;
    for (int32_t i = 0; i < job->walls->count; ++i) {
        const ty_wall* side = &job->walls->sides[i];
        const float arrived = in_units(light, sums->all, channel, i);
        float share;
        ty_wall_of_stairs(side, side->albedo[channel], &job->wall_albedo[channel][i], &share);
        job->wall_light[channel][i] = share * (side->albedo[channel] * arrived / TY_PI + side->emission[channel]);
        light->forward[channel][i] = in_units(light, sums->forward, channel, i);
    }
}

static ty_result take_memory(ty_dom_job* job, float** reduced, float** irradiance) {
    ty_context* context = job->context;
    const size_t count = (size_t)job->walls->count, cells = job->coarse->cells;
    for (int32_t c = 0; c < ty_dom_channels(job->light); ++c) {
        job->wall_albedo[c] = ty_alloc_array(context, count, sizeof(float), false);
        job->wall_light[c] = ty_alloc_array(context, count, sizeof(float), false);
        job->light->arrived[c] = ty_alloc_array(context, count, sizeof(float), true);
        job->light->forward[c] = ty_alloc_array(context, count, sizeof(float), true);
        if (job->wall_albedo[c] == NULL || job->wall_light[c] == NULL || job->light->arrived[c] == NULL ||
            job->light->forward[c] == NULL)
            return TY_ERROR_MEMORY;
    }
    *reduced = ty_alloc_array(context, cells, sizeof(float) * (size_t)job->coarse->planes, false);
    *irradiance = ty_alloc_array(context, count, sizeof(float) * SUMS, true);
    return *reduced != NULL && *irradiance != NULL ? TY_OK : TY_ERROR_MEMORY;
}

/* Nothing comes from cells that no light gets to, whatever fine cells at their edges have. */
static ty_result darken(ty_dom_job* job) {
    ty_dom* light = job->light;
    const size_t terms = (size_t)(light->bands * light->bands);
    light->dark = ty_alloc_array(job->context, light->cells, 1, false);
    if (light->dark == NULL ||
        ty_walls_find_dark(job->scene, job->walls, job->coarse, job->sources, job->source_count, light->dark) != TY_OK)
        return TY_ERROR_MEMORY;
    for (int32_t c = 0; c < ty_dom_channels(light); ++c)
        for (size_t t = 0; t < terms; ++t)
            for (size_t i = 0; i < light->cells; ++i)
                if (light->dark[i] != 0) job->source[c][t * light->cells + i] = 0;
    return TY_OK;
}

static ty_result light_all_walls(ty_dom_job* job) {
    float *reduced = NULL, *irradiance = NULL;
    if (job->walls == NULL) return TY_OK;
    const size_t count = (size_t)job->walls->count, cells = job->coarse->cells;
    ty_result result = take_memory(job, &reduced, &irradiance);
    if (result == TY_OK) result = ty_dom_cut_sources(job);
    if (result == TY_OK) result = darken(job);
    if (result == TY_OK) {
        wall_sums sums;
        for (size_t c = 0; c < 3; ++c) {
            sums.all[c] = irradiance + count * c;
            sums.forward[c] = irradiance + count * (3 + c);
        }
        float* planes[3] = {reduced, NULL, NULL};
        for (int32_t p = 1; p < job->coarse->planes; ++p) planes[p] = reduced + cells * (size_t)p;
        ty_grid_medium_reduce(job->coarse, job->light->bands, planes);
        light_walls(job, planes, &sums);
        for (int32_t c = 0; c < ty_dom_channels(job->light); ++c) send_light(job, c, &sums);
    }
    ty_free_array(job->context, reduced, cells, sizeof(float) * (size_t)job->coarse->planes);
    ty_free_array(job->context, irradiance, count, sizeof(float) * SUMS);
    return result;
}

ty_result ty_dom_light_walls(ty_dom_job* job) {
    const ty_result result = light_all_walls(job);
    return result == TY_OK ? ty_dom_let_in(job) : result;
}

bool ty_dom_walls_are_dark(const ty_dom_job* job, int32_t channel) {
    for (int32_t d = 0; job->inflow[channel] != NULL && d < job->set->count; ++d)
        if (job->inflow[channel][d] > 0) return false;
    for (int32_t i = 0; job->walls != NULL && i < job->walls->count; ++i)
        if (job->wall_light[channel][i] > 0) return false;
    return true;
}

/* ---- ordinates ---- */

/* sent: what they send besides what they reflect. */
static ty_ordinates_faces walls_of(const ty_dom_job* job, int32_t channel, const float* sent) {
    const ty_walls* walls = job->walls;
    if (walls == NULL) return (ty_ordinates_faces){.count = 0};
    return (ty_ordinates_faces){.count = walls->count,
                                .first = walls->first,
                                .x = walls->x,
                                .face = walls->face,
                                .albedo = job->wall_albedo[channel],
                                .emission = sent};
}

/* Planes of the problem without scattering. */
typedef struct bare_planes {
    float *extinction, *zeros;
    const float* source[1];
    float* moments[TY_DOM_BANDS_MAX * TY_DOM_BANDS_MAX];
} bare_planes;

/* What light that walls sent and that has not scattered yet will: into q_lm. Returns it, W. */
static double scatter_first(ty_dom_job* job, int32_t channel, float* const* moments) {
    const ty_dom* light = job->light;
    const int32_t plane = light->planes == 3 ? channel : 0;
    const float *scattering = job->coarse->scattering[plane], *g = job->coarse->g[plane];
    double sum = 0;
    for (size_t i = 0; i < light->cells; ++i) {
        const float forward = powf(g[i], (float)light->bands);
        float power = 1;
        for (int32_t l = 0; l < light->bands; ++l, power *= g[i])
            for (int32_t t = l * l; t < (l + 1) * (l + 1); ++t)
                job->source[channel][light->cells * (size_t)t + i] += scattering[i] * (power - forward) * moments[t][i];
        sum += (double)(scattering[i] * (1 - forward) * moments[0][i]);
    }
    return sum * sqrt_four_pi * job->coarse->cell[0] * job->coarse->cell[1] * job->coarse->cell[2];
}

static ty_result carry(ty_dom_job* job, int32_t channel, ty_ordinates_def* def, bare_planes* planes,
                       ty_dom_wall_power* power) {
    ty_dom* light = job->light;
    const int32_t plane = light->planes == 3 ? channel : 0;
    const float *sigma = job->coarse->extinction[plane], *scattering = job->coarse->scattering[plane];
    const float* g = job->coarse->g[plane];
    ty_ordinates_stats stats;
    for (size_t i = 0; i < light->cells; ++i)
        planes->extinction[i] = sigma[i] - powf(g[i], (float)light->bands) * scattering[i];
    planes->source[0] = planes->zeros;
    for (int32_t t = 0; t < light->kept * light->kept; ++t)
        planes->moments[t] = light->surfaces[channel] + light->cells * (size_t)t;
    def->extinction = planes->extinction;
    def->scattering = def->g = planes->zeros;
    def->source = planes->source;
    def->source_terms = 1;
    def->start = NULL;
    def->walls = walls_of(job, channel, job->wall_light[channel]);
    def->boundary_radiance = job->inflow[channel];
    if (def->boundary_radiance != NULL) def->final_set = NULL;
    const ty_result result = ty_ordinates_solve(job->context, def, planes->moments, NULL, 0, &stats);
    if (result != TY_OK) return result;
    const double scattered = scatter_first(job, channel, planes->moments);
    *power = (ty_dom_wall_power){.emitted = stats.walls_emitted + stats.entering - scattered,
                                 .absorbed = stats.absorbed - scattered,
                                 .by_walls = stats.walls_absorbed,
                                 .leaving = stats.leaving,
                                 .sweeps = stats.sweeps,
                                 .sweep_seconds = stats.sweep_seconds,
                                 .converged = stats.converged};
    return TY_OK;
}

ty_result ty_dom_carry_walls(ty_dom_job* job, int32_t channel, const ty_ordinates_def* def, ty_dom_wall_power* power) {
    ty_dom* light = job->light;
    const size_t terms = (size_t)(light->kept * light->kept), cells = light->cells;
    *power = (ty_dom_wall_power){.converged = true};
    if (ty_dom_walls_are_dark(job, channel)) return TY_OK;
    bare_planes planes = {.extinction = ty_alloc_array(job->context, cells, sizeof(float), false),
                          .zeros = ty_alloc_array(job->context, cells, sizeof(float), true)};
    light->surfaces[channel] = ty_alloc_array(job->context, cells, terms * sizeof(float), true);
    ty_ordinates_def bare = *def;
    ty_result result = TY_ERROR_MEMORY;
    if (planes.extinction != NULL && planes.zeros != NULL && light->surfaces[channel] != NULL)
        result = carry(job, channel, &bare, &planes, power);
    ty_free_array(job->context, planes.extinction, cells, sizeof(float));
    ty_free_array(job->context, planes.zeros, cells, sizeof(float));
    return result;
}

ty_result ty_dom_reflect(ty_dom_job* job, int32_t channel, ty_ordinates_def* def, float** none) {
    *none = NULL;
    if (job->walls == NULL) return TY_OK;
    *none = ty_alloc_array(job->context, (size_t)job->walls->count, sizeof(float), true);
    if (*none == NULL) return TY_ERROR_MEMORY;
    def->walls = walls_of(job, channel, *none);
    def->walls.irradiance = job->light->arrived[channel];
    return TY_OK;
}
