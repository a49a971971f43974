/* Entry points of discrete ordinates: argument checks, memory, set-up and final sweep. */
#include "base/context.h"
#include "solve/ordinates/job.h"

#include <math.h>
#include <string.h>

/* For DSA, void cells are given enough extinction that the whole box is at least this optically thick: in a void light
 * streams, and the D of a thinner medium (or none) makes the correction overshoot. The minimum number of sweeps lies
 * between 3 and 12, for any cell size. */
static const double MIN_BOX_THICKNESS = 6;

ty_ordinates_def ty_default_ordinates_def(void) {
    return (ty_ordinates_def){.bands = 4,
                              .output_order = 4,
                              .source_terms = 1,
                              .accelerated = true,
                              .diffusive_paths = TY_DIFFUSIVE_FREE_PATHS,
                              .tolerance = 1e-3};
}

/* ---- checks ---- */

static ty_result check_size(ty_context* context, const ty_ordinates_def* def) {
    for (int axis = 0; axis < 3; ++axis) {
        if (def->size[axis] < 1 || def->size[axis] > TY_ORDINATES_SIDE_MAX)
            return ty_fail(context, TY_ERROR_ARGUMENT, "ordinates: size[%d]: %d cells are outside 1..%d", axis,
                           (int)def->size[axis], TY_ORDINATES_SIDE_MAX);
        if (!(def->cell[axis] > 0 && def->cell[axis] < 1e12))
            return ty_fail(context, TY_ERROR_ARGUMENT, "ordinates: cell[%d]: %g m is no edge of a cell", axis,
                           def->cell[axis]);
    }
    return TY_OK;
}

static bool have_planes(const float* const* planes, int32_t count) {
    for (int32_t i = 0; i < count; ++i)
        if (planes[i] == NULL) return false;
    return true;
}

static bool is_valid_set(const ty_angular_quadrature* set) {
    return set != NULL && set->count >= 8 && set->count <= TY_ORDINATES_MAX;
}

static ty_result check(ty_context* context, const ty_ordinates_def* def, float* const* moments) {
    const ty_result result = check_size(context, def);
    if (result != TY_OK) return result;
    if (!is_valid_set(def->set)) return ty_fail(context, TY_ERROR_ARGUMENT, "ordinates: set: there are no directions");
    if (def->final_set != NULL && (!is_valid_set(def->final_set) || def->boundary_radiance.across[0] != NULL))
        return ty_fail(context, TY_ERROR_ARGUMENT,
                       "ordinates: final_set: it has no directions, or boundary_radiance needs those of set");
    if (def->bands < 1 || def->bands > TY_SCATTERING_ORDER_MAX)
        return ty_fail(context, TY_ERROR_ARGUMENT, "ordinates: bands: %d are outside 1..%d", (int)def->bands,
                       TY_SCATTERING_ORDER_MAX);
    if (def->output_order < def->bands || def->output_order > TY_SCATTERING_ORDER_MAX)
        return ty_fail(context, TY_ERROR_ARGUMENT, "ordinates: output_order: %d is outside %d..%d",
                       (int)def->output_order, (int)def->bands, TY_SCATTERING_ORDER_MAX);
    if (def->source_terms != 1 && def->source_terms != def->bands * def->bands)
        return ty_fail(context, TY_ERROR_ARGUMENT, "ordinates: source_terms: %d is neither 1 nor bands^2, %d",
                       (int)def->source_terms, (int)(def->bands * def->bands));
    if (def->extinction == NULL || def->scattering == NULL || def->g == NULL || def->source == NULL ||
        moments == NULL || !have_planes(def->source, def->source_terms) ||
        !have_planes((const float* const*)moments, def->output_order * def->output_order) ||
        (def->start != NULL && !have_planes(def->start, def->bands * def->bands)))
        return ty_fail(context, TY_ERROR_ARGUMENT,
                       "ordinates: there is no medium, source, start or place for the moments");
    if (!(def->tolerance > 0 && def->tolerance < 1))
        return ty_fail(context, TY_ERROR_ARGUMENT, "ordinates: tolerance: %g is outside (0, 1)", def->tolerance);
    if (def->walls.count < 0 ||
        (def->walls.count > 0 && (def->walls.first == NULL || def->walls.x == NULL || def->walls.face == NULL ||
                                  def->walls.albedo == NULL || def->walls.emission == NULL ||
                                  (def->walls.ior != NULL && (def->walls.normal == NULL || def->final_set != NULL)))))
        return ty_fail(context, TY_ERROR_ARGUMENT, "ordinates: walls: %d sides are not all there",
                       (int)def->walls.count);
    if (def->periodic != 0 &&
        (def->domain != NULL || def->walls.count > 0 || def->boundary_radiance.across[0] != NULL ||
         def->final_set != NULL || def->closed != NULL || isfinite(def->diffusive_paths)))
        return ty_fail(context, TY_ERROR_ARGUMENT,
                       "ordinates: periodic: a box that repeats has no walls, boundary_radiance, domain, final_set or "
                       "diffusive cells");
    if (def->sweeps < 0) return ty_fail(context, TY_ERROR_ARGUMENT, "ordinates: sweeps are at least 0");
    return TY_OK;
}

/* ---- memory ---- */

/* Array of `items` floats per cell. */
static float* allocate_cells(const ty_ordinates_job* job, ty_arena* arena, int32_t items) {
    return ty_arena_take(arena, sizeof(float) * (size_t)job->cells * (size_t)items);
}

static void lay_out(ty_ordinates_job* job, ty_arena* arena) {
    job->sums = ty_arena_take(arena, sizeof *job->sums * (size_t)job->def->size[2]);
    job->extinction = allocate_cells(job, arena, 1);
    job->emission = allocate_cells(job, arena, job->terms);
    job->mixed = allocate_cells(job, arena, job->low_order_terms);
    for (int32_t i = 0; i < job->depth; ++i) {
        job->moments[i] = allocate_cells(job, arena, job->terms);
        job->low_order[i] = allocate_cells(job, arena, job->low_order_terms);
        job->changes[i] = allocate_cells(job, arena, job->low_order_terms);
    }
    if (job->def->source_terms > 1) job->source_lm = allocate_cells(job, arena, job->terms);
    ty_ordinates_faces_lay_out(job, arena);
}

ty_ordinates_job ty_ordinates_begin_job(const ty_ordinates_def* def) {
    return (ty_ordinates_job){.def = def,
                              .cells = (int64_t)def->size[0] * def->size[1] * def->size[2],
                              .terms = def->bands * def->bands,
                              .low_order_terms = def->bands > 1 ? 4 : 1,
                              .depth = def->accelerated ? TY_ANDERSON_DEPTH : 1};
}

size_t ty_ordinates_memory(const ty_ordinates_def* def) {
    ty_ordinates_job job = ty_ordinates_begin_job(def);
    ty_arena arena = {0};
    lay_out(&job, &arena);
    return arena.used;
}

/* A single block: several would be returned to the system after each solve and paged in again for the next. */
static ty_result allocate(ty_ordinates_job* job) {
    const ty_ordinates_def* def = job->def;
    const size_t bytes = ty_ordinates_memory(def);
    job->stats->bytes = (double)bytes;
    ty_arena arena = {.base = def->memory};
    if (def->memory == NULL) {
        arena.base = job->memory = ty_alloc_array(job->context, bytes, 1, false);
        job->bytes = bytes;
        if (job->memory == NULL) return TY_ERROR_MEMORY;
    }
    lay_out(job, &arena);
    return TY_OK;
}

void ty_ordinates_end_job(ty_ordinates_job* job) {
    if (job->memory != NULL) ty_free_array(job->context, job->memory, job->bytes, 1);
    ty_sweep_destroy(job->sweep);
    ty_dsa_destroy(job->dsa);
    ty_ordinates_diffusive_free(job);
    ty_fresnel_faces_destroy(job->fresnel);
    ty_ordinates_parts_destroy(job);
    ty_ordinates_images_destroy(job);
    ty_free_array(job->context, job->displaced, (size_t)job->cells, 3 * sizeof(float));
    ty_free_array(job->context, job->dsa_albedo, (size_t)job->def->walls.count, sizeof(float));
}

/* ---- solve ---- */

static bool scatters(const ty_ordinates_job* job) {
    double scatters = 0;
    for (int64_t i = 0; i < job->cells && scatters <= 0; ++i)
        if (job->def->scattering[i] > 0) scatters = 1;
    ty_ordinates_sum_ranks(job, &scatters, 1);
    return scatters > 0;
}

/* Computes sigma* and sets up DSA; without scattering there is no DSA. */
static ty_result scale(ty_ordinates_job* job) {
    const ty_ordinates_def* def = job->def;
    /* Arrays that are reused later for other quantities. */
    float* reduced = def->accelerated ? job->changes[0] : NULL;
    float* absorption = def->accelerated ? job->mixed : NULL;
    if (!ty_ordinates_scale(job, reduced, absorption))
        return ty_fail(job->context, TY_ERROR_ARGUMENT,
                       "ordinates: extinction, scattering, g or source of a cell is outside its range or not finite");
    if (!def->accelerated || !scatters(job)) return TY_OK;
    const ty_result result = ty_ordinates_diffusive_find(job, reduced, absorption);
    if (result != TY_OK) return result;
    ty_diffusion_def diffusion = ty_default_diffusion_def();
    double longest = 0;
    for (int axis = 0; axis < 3; ++axis) {
        diffusion.size[axis] = def->size[axis];
        diffusion.cell[axis] = def->cell[axis];
        longest = fmax(longest, def->cell[axis] * (def->domain != NULL ? def->domain->cells[axis] : def->size[axis]));
    }
    diffusion.periodic = def->periodic;
    diffusion.extinction = reduced;
    diffusion.absorption = absorption;
    diffusion.min_extinction = MIN_BOX_THICKNESS / longest;
    job->dsa_walls = def->walls;
    if (def->walls.count > 0 && def->walls.ior != NULL) {
        job->dsa_albedo = ty_alloc_array(job->context, (size_t)def->walls.count, sizeof(float), false);
        if (job->dsa_albedo == NULL) return TY_ERROR_MEMORY;
        ty_fresnel_faces_diffuse(def, job->dsa_albedo);
        job->dsa_walls.albedo = job->dsa_albedo;
    }
    return ty_dsa_create(job->context, &diffusion, &job->dsa_walls, def->domain, &job->dsa);
}

/* Initial guess: the caller's moments, or the solution on coarser cells, or the diffusion solution. */
static ty_result begin(ty_ordinates_job* job) {
    const ty_ordinates_def* def = job->def;
    ty_result result = TY_OK;
    if (def->start != NULL) {
        ty_ordinates_gather(job, def->start, job->terms, job->moments[0]);
        ty_ordinates_start(job);
        ty_ordinates_diffusive_begin(job);
    } else if (job->dsa != NULL) {
        result = ty_ordinates_coarse_initial_guess(job);
        if (result == TY_OK && job->count == 0) ty_ordinates_diffusion_initial_guess(job);
    }
    if (result != TY_OK) return result;
    ty_ordinates_faces_begin(job);
    ty_ordinates_images_begin(job);
    if (job->diffusive.count == 0) return TY_OK;
    double emitted, absorbed;
    ty_ordinates_faces_balance(job, job->face_irradiance[0], &emitted, &absorbed);
    job->emitted = ty_ordinates_balance(job, job->moments[0], job->terms).emitted + emitted + job->stats->entering;
    return TY_OK;
}

ty_result ty_ordinates_prepare(ty_ordinates_job* job) {
    const ty_ordinates_def* def = job->def;
    ty_result result = allocate(job);
    if (result == TY_OK) result = ty_ordinates_parts_create(job);
    if (result == TY_OK) result = scale(job);
    if (result == TY_OK)
        result =
            ty_sweep_create(job->context, def->size, def->cell, def->set, def->bands, job->extinction, &job->sweep);
    if (result == TY_OK) result = ty_sweep_divide(job->sweep, def->domain);
    if (result == TY_OK) result = ty_sweep_set_boundary_radiance(job->sweep, &def->boundary_radiance);
    if (result == TY_OK) result = ty_ordinates_images_create(job);
    if (result != TY_OK) return result;
    ty_sweep_set_closed(job->sweep, def->closed);
    job->stats->entering = ty_ordinates_entering(def);
    if (job->source_lm != NULL) ty_ordinates_gather(job, def->source, job->terms, job->source_lm);
    result = ty_ordinates_displace(job, job->dsa != NULL ? job->changes[0] : NULL);
    if (result != TY_OK) return result;
    job->stats->bytes += (double)ty_sweep_bytes(job->sweep);
    result = ty_fresnel_faces_create(job->context, def, job->sweep, &job->diffusive, &job->fresnel);
    if (result != TY_OK) return result;
    if (job->dsa != NULL) job->stats->bytes += (double)ty_dsa_bytes(job->dsa);
    return begin(job);
}

/* irradiance: on boundary faces. */
static void note_balance(ty_ordinates_job* job, const float* moments, int32_t terms, const float* irradiance) {
    const ty_ordinates_sums sums = ty_ordinates_balance(job, moments, terms);
    const ty_ordinates_faces* walls = &job->def->walls;
    ty_ordinates_stats* stats = job->stats;
    double powers[5] = {sums.emitted, sums.absorbed, stats->entering};
    ty_ordinates_faces_balance(job, irradiance, &powers[3], &powers[4]);
    ty_ordinates_sum_ranks(job, powers, 5);
    stats->emitted = powers[0];
    stats->absorbed = powers[1];
    stats->entering = powers[2];
    stats->walls_emitted = powers[3];
    stats->walls_absorbed = powers[4];
    if (walls->irradiance != NULL && walls->count > 0)
        memcpy(walls->irradiance, irradiance, sizeof *irradiance * (size_t)walls->count);
    for (int32_t i = 0; walls->absorbed != NULL && i < walls->count; ++i)
        walls->absorbed[i] = (float)ty_ordinates_face_absorbs(job, i, irradiance[i]);
}

/* A final sweep, for more moments than the iteration needs or for more directions; emission and moments have `terms`
 * floats per cell. */
static ty_result run_final_sweep(ty_ordinates_job* job, ty_sweep* sweep, float* emission, float* swept,
                                 float* const* moments) {
    const int32_t terms = job->def->output_order * job->def->output_order;
    ty_ordinates_emit(job);
    ty_ordinates_widen(job, job->emission, terms, emission);
    ty_ordinates_set_sweep_faces(job, sweep, job->latest);
    ty_result result = ty_sweep_divide(sweep, job->def->domain);
    if (result == TY_OK) result = ty_sweep_set_boundary_radiance(sweep, &job->def->boundary_radiance);
    if (result == TY_OK) result = ty_sweep_repeat(sweep, job->def->periodic);
    if (result != TY_OK) return result;
    if (job->def->periodic != 0) ty_ordinates_images_emit(job, sweep);
    ty_sweep_set_passing(sweep, job->def->passing_axis, job->def->passing);
    const double started = ty_wall_seconds();
    result = ty_sweep_run(sweep, emission, swept, &job->stats->leaving, NULL);
    job->stats->sweep_seconds += ty_wall_seconds() - started;
    ++job->stats->sweeps;
    if (result != TY_OK) return result;
    ty_ordinates_diffusive_receive(job);
    ty_ordinates_faces_receive(job);
    ty_ordinates_diffusive_reach_faces(job);
    job->stats->leaving += ty_ordinates_diffusive_leakage(job);
    ty_ordinates_sum_ranks(job, &job->stats->leaving, 1);
    ty_ordinates_diffusive_fill(job, swept, terms);
    ty_ordinates_scatter(job, swept, terms, moments);
    note_balance(job, swept, terms, job->face_irradiance[job->latest]);
    return TY_OK;
}

static ty_result sweep_final(ty_ordinates_job* job, float* const* moments) {
    const ty_ordinates_def* def = job->def;
    const size_t count = (size_t)job->cells * (size_t)(def->output_order * def->output_order);
    const ty_angular_quadrature* set = def->final_set != NULL ? def->final_set : def->set;
    ty_sweep* sweep = NULL;
    ty_result result =
        ty_sweep_create(job->context, def->size, def->cell, set, def->output_order, job->extinction, &sweep);
    if (result != TY_OK) return result;
    float* both = ty_alloc_array(job->context, 2 * count, sizeof(float), false);
    job->stats->bytes += (double)ty_sweep_bytes(sweep) + 2 * sizeof(float) * (double)count;
    result = both != NULL ? run_final_sweep(job, sweep, both, both + count, moments) : TY_ERROR_MEMORY;
    if (both != NULL) ty_free_array(job->context, both, 2 * count, sizeof(float));
    ty_sweep_destroy(sweep);
    return result;
}

static void set_dark(const ty_ordinates_job* job, float* const* moments, int32_t from) {
    for (int32_t t = from; t < job->def->output_order * job->def->output_order; ++t)
        memset(moments[t], 0, sizeof(float) * (size_t)job->cells);
}

/* Stores the latest iterate without a final sweep. */
static void store(ty_ordinates_job* job, float* const* moments) {
    set_dark(job, moments, job->count > 0 ? job->terms : 0);
    if (job->count == 0) return;
    float* latest = job->moments[job->latest];
    ty_ordinates_scatter_low_order(job);
    ty_ordinates_diffusive_fill(job, latest, job->terms);
    ty_ordinates_scatter(job, latest, job->terms, moments);
    job->stats->leaving = job->leaving[job->latest];
    note_balance(job, latest, job->terms, job->face_irradiance[job->latest]);
}

static ty_result solve(ty_ordinates_job* job, float* const* moments) {
    ty_result result = ty_ordinates_prepare(job);
    if (result != TY_OK) return result;
    result = ty_ordinates_iterate(job);
    if (job->dsa != NULL) job->stats->cycles += ty_dsa_cycles(job->dsa);
    const bool needs_sweep =
        job->def->output_order > job->def->bands || job->def->final_set != NULL || job->def->passing[0] != NULL;
    if (result == TY_OK && needs_sweep)
        result = sweep_final(job, moments);
    else if (result == TY_OK || result == TY_CANCELLED)
        store(job, moments);
    return result == TY_OK ? ty_ordinates_check_ranks(job) : result;
}

ty_result ty_ordinates_solve(ty_context* context, const ty_ordinates_def* def, float* const* moments, double* history,
                             int32_t history_capacity, ty_ordinates_stats* stats) {
    ty_result result = check(context, def, moments);
    if (result != TY_OK) return result;
    ty_ordinates_stats ignored;
    ty_ordinates_job job = ty_ordinates_begin_job(def);
    job.context = context;
    job.stats = stats != NULL ? stats : &ignored;
    job.history = history;
    job.history_capacity = history != NULL ? history_capacity : 0;
    *job.stats = (ty_ordinates_stats){0};
    job.start = job.reported = ty_wall_seconds();
    result = solve(&job, moments);
    ty_ordinates_undo_displaced_flux(&job, moments);
    ty_ordinates_end_job(&job);
    job.stats->seconds = ty_wall_seconds() - job.start;
    return result;
}
