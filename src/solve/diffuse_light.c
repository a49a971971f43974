/* The diffuse light: one solve a channel (Eq. 20), and the field that is made of it. */
#include "solve/diffuse_light.h"

#include "base/context.h"
#include "base/kernel.h"
#include "scene/phase.k.h"

#include <math.h>
#include <string.h>

/* Relative difference of sources up to which one channel is a multiple of another. */
static const float alike = 1e-6f;

/* Light that enters a cell many free paths thick scatters within one of its surface and mostly leaves again, but for
 * the equations it comes from the cell's middle and piles up there: fluence would grow with thickness, without bound.
 * What a thick medium sends back depends on its albedo alone, so cells of more than this many transport mean free paths
 * are made that thin. Their fluence is then that of a surface; what passes through a medium of such cells is too much,
 * of little. It is the faces of the box that hold light back most; within, vacuum next to a thick cell takes it. */
static const double thickest_inside = 2.5, thickest_at_faces = 1.5;

/* What the solves of all channels share. */
typedef struct solve_work {
    ty_context* context;
    const ty_grid_medium* medium;
    float* const* source; /* W m^-3 */
    bool reduced;
    float* extinction[3]; /* sigma_t (1 - albedo g), 1/m */
    float* absorption[3];
    void* memory;
    size_t memory_size;
    ty_diffusion_def def;
    ty_part_progress* progress;
    ty_diffuse_light* light;
    ty_diffuse_stats* stats;
} solve_work;

static ty_result begin_work(solve_work* work) {
    const ty_grid_medium* medium = work->medium;
    memcpy(work->def.size, medium->box.size, sizeof work->def.size);
    memcpy(work->def.cell, medium->cell, sizeof work->def.cell);
    work->def.progress = ty_part_report;
    work->def.progress_user = work->progress;
    bool whole = true;
    for (int32_t p = 0; p < medium->planes && whole; ++p) {
        work->extinction[p] = ty_alloc_array(work->context, medium->cells, sizeof(float), false);
        work->absorption[p] = ty_alloc_array(work->context, medium->cells, sizeof(float), false);
        whole = work->extinction[p] != NULL && work->absorption[p] != NULL;
    }
    work->memory_size = ty_diffusion_memory(&work->def);
    if (whole) work->memory = ty_alloc_array(work->context, work->memory_size, 1, false);
    return work->memory != NULL ? TY_OK : TY_ERROR_MEMORY;
}

static void end_work(solve_work* work) {
    for (int32_t p = 0; p < work->medium->planes; ++p) {
        ty_free_array(work->context, work->extinction[p], work->medium->cells, sizeof(float));
        ty_free_array(work->context, work->absorption[p], work->medium->cells, sizeof(float));
    }
    ty_free_array(work->context, work->memory, work->memory_size, 1);
}

static bool is_at_face(const ty_grid_box* box, size_t cell) {
    for (int a = 0; a < 3; ++a) {
        const size_t size = (size_t)box->size[a], at = cell % size;
        if (at == 0 || at + 1 == size) return true;
        cell /= size;
    }
    return false;
}

/* Makes a plane of cells at most so thick, with their albedo as it is, and gives channels first..end what they emit. */
static void thin_cells(const solve_work* work, int32_t plane, int32_t first, int32_t end) {
    const ty_grid_medium* medium = work->medium;
    const double side = fmin(medium->cell[0], fmin(medium->cell[1], medium->cell[2]));
    const float most_inside = (float)(thickest_inside / side), most_at_faces = (float)(thickest_at_faces / side);
    for (size_t i = 0; i < medium->cells; ++i) {
        const float most = is_at_face(&medium->box, i) ? most_at_faces : most_inside;
        const float extinction = work->extinction[plane][i], part = extinction > most ? most / extinction : 1.0f;
        work->extinction[plane][i] = extinction * part;
        work->absorption[plane][i] *= part;
        for (int32_t c = first; c < end && medium->emission[c] != NULL; ++c)
            work->source[c][i] += medium->emission[c][i] * part;
    }
}

/* The paper takes media as isotropic. */
static void find_coefficients(const solve_work* work) {
    const ty_grid_medium* medium = work->medium;
    if (work->reduced) ty_grid_medium_reduce(medium, 1, work->extinction);
    for (int32_t p = 0; p < medium->planes; ++p) {
        if (!work->reduced) memcpy(work->extinction[p], medium->extinction[p], medium->cells * sizeof(float));
        for (size_t i = 0; i < medium->cells; ++i)
            work->absorption[p][i] = ty_maxf(0.0f, medium->extinction[p][i] - medium->scattering[p][i]);
        if (medium->planes == 3)
            thin_cells(work, p, p, p + 1);
        else
            thin_cells(work, p, 0, 3);
    }
}

/* Whether a channel's light is `factor` times that of another: its source is, and the media are gray. */
static bool is_multiple(const solve_work* work, int32_t channel, int32_t of, float* factor) {
    const float* a = work->source[channel];
    const float* b = work->source[of];
    double sums[2] = {0, 0};
    if (work->medium->planes == 3) return false;
    for (size_t i = 0; i < work->medium->cells; ++i) {
        sums[0] += (double)a[i];
        sums[1] += (double)b[i];
    }
    if (!(sums[1] > 0)) return false;
    *factor = (float)(sums[0] / sums[1]);
    for (size_t i = 0; i < work->medium->cells; ++i)
        if (fabsf(a[i] - *factor * b[i]) > alike * ty_maxf(a[i], *factor * b[i])) return false;
    return true;
}

static void scale_channel(solve_work* work, int32_t channel, int32_t of, float factor) {
    ty_diffuse_stats* stats = work->stats;
    const ty_diffuse_light* light = work->light;
    for (int t = 0; t < TY_FIELD_TERMS; ++t)
        for (size_t i = 0; i < light->cells; ++i) light->terms[channel][t][i] = factor * light->terms[of][t][i];
    stats->emitted[channel] = (double)factor * stats->emitted[of];
    stats->absorbed[channel] = (double)factor * stats->absorbed[of];
    stats->leaving[channel] = (double)factor * stats->leaving[of];
    stats->residual[channel] = stats->residual[of];
}

/* Limiters bound what flows by what there is (R F <= 1) with the gradient between a cell's neighbours; the mean of what
 * its faces let through can be a little more. */
static void limit_flux(float* const terms[TY_FIELD_TERMS], size_t cells) {
    for (size_t i = 0; i < cells; ++i) {
        const float square = terms[1][i] * terms[1][i] + terms[2][i] * terms[2][i] + terms[3][i] * terms[3][i];
        const float most = 3 * terms[0][i];
        if (square <= most * most) continue;
        const float factor = most / sqrtf(square);
        for (int t = 1; t < TY_FIELD_TERMS; ++t) terms[t][i] *= factor;
    }
}

/* The diffuse radiance (phi + 3 E . way) / (4 pi) (Eq. 9) from fluence and the flux through faces that are where the
 * terms will be: a cell's is the mean of its two faces along each axis. */
static void make_terms(const solve_work* work, int32_t channel) {
    const int32_t* size = work->medium->box.size;
    float* const* terms = work->light->terms[channel];
    const size_t step[3] = {1, (size_t)size[0], (size_t)size[0] * (size_t)size[1]};
    for (size_t i = 0; i < work->light->cells; ++i) terms[0][i] *= TY_INV_4PI;
    for (int a = 0; a < 3; ++a) {
        /* Along its own axis an array of faces is one longer, so that no face is overwritten before it is read. */
        const size_t slab = step[a] * (size_t)size[a];
        for (size_t i = 0; i < work->light->cells; ++i) {
            const size_t face = i + i / slab * step[a];
            terms[1 + a][i] = 1.5f * TY_INV_4PI * (terms[1 + a][face] + terms[1 + a][face + step[a]]);
        }
    }
    limit_flux(terms, work->light->cells);
}

static ty_result solve_channel(solve_work* work, int32_t channel) {
    const int32_t plane = work->medium->planes == 3 ? channel : 0;
    ty_diffuse_stats* stats = work->stats;
    ty_diffusion_def* def = &work->def;
    def->extinction = work->extinction[plane];
    def->absorption = work->absorption[plane];
    def->source = work->source[channel];
    def->memory = work->memory;
    float* const* terms = work->light->terms[channel];
    const ty_diffusion_out out = {.fluence = terms[0], .flux = {terms[1], terms[2], terms[3]}};
    ty_diffusion_stats solved = {0};
    const ty_result result = ty_diffusion_solve(work->context, def, &out, &solved);
    if (result != TY_OK) return result;
    stats->converged = stats->converged && solved.converged;
    stats->iterations[channel] = solved.iterations;
    stats->cycles[channel] = solved.cycles;
    stats->residual[channel] = solved.residual;
    stats->work[channel] = solved.work;
    stats->emitted[channel] = solved.emitted;
    stats->absorbed[channel] = solved.absorbed;
    stats->leaving[channel] = solved.leaving;
    make_terms(work, channel);
    return TY_OK;
}

static ty_result solve_channels(solve_work* work) {
    const double from = work->progress->from, share = work->progress->share;
    ty_result result = TY_OK;
    work->stats->converged = true;
    work->light->shared = true;
    for (int32_t c = 0; c < 3 && result == TY_OK; ++c) {
        float factor = 1;
        work->progress->from = from + share * c / 3;
        work->progress->share = share / 3;
        bool solved = false;
        for (int32_t of = 0; of < c && !solved; ++of) {
            solved = is_multiple(work, c, of, &factor);
            if (solved) scale_channel(work, c, of, factor);
            if (!solved && of == 0) work->light->shared = false;
        }
        work->light->color[c] = factor;
        if (!solved) result = ty_part_show(work->progress, "fluence");
        if (!solved && result == TY_OK) result = solve_channel(work, c);
    }
    return result;
}

static bool scatters_evenly(const ty_grid_medium* medium) {
    for (int32_t p = 0; p < medium->planes; ++p)
        for (size_t i = 0; i < medium->cells; ++i)
            if (medium->g[p][i] != 0) return false;
    return true;
}

/* Floats of a term's array: room for the faces along its axis, where its flux comes from. */
static size_t term_size(const ty_diffuse_light* light, int term) {
    if (term == 0 || light->cells == 0) return light->cells;
    return light->cells + light->cells / (size_t)light->box.size[term - 1];
}

static ty_result take_light(ty_context* context, const ty_grid_medium* medium, ty_diffuse_light** out) {
    ty_diffuse_light* light = ty_alloc_array(context, 1, sizeof *light, true);
    *out = light;
    if (light == NULL) return TY_ERROR_MEMORY;
    light->context = context;
    light->box = medium->box;
    light->cells = medium->cells;
    light->even = scatters_evenly(medium);
    for (int c = 0; c < 3; ++c) {
        for (int t = 0; t < TY_FIELD_TERMS; ++t) {
            light->terms[c][t] = ty_alloc_array(context, term_size(light, t), sizeof(float), true);
            if (light->terms[c][t] == NULL) return TY_ERROR_MEMORY;
        }
    }
    return TY_OK;
}

void ty_diffuse_light_destroy(ty_diffuse_light* light) {
    if (light == NULL) return;
    for (int c = 0; c < 3; ++c)
        for (int t = 0; t < TY_FIELD_TERMS; ++t)
            ty_free_array(light->context, light->terms[c][t], term_size(light, t), sizeof(float));
    ty_free_array(light->context, light, 1, sizeof *light);
}

ty_result ty_diffuse_light_solve(const ty_diffusion_def* solver, bool reduced, const ty_grid_medium* medium,
                                 float* const source[3], ty_part_progress* progress, ty_diffuse_light** out,
                                 ty_diffuse_stats* stats) {
    solve_work work = {.context = medium->context,
                       .medium = medium,
                       .source = source,
                       .reduced = reduced,
                       .def = *solver,
                       .progress = progress,
                       .stats = stats};
    ty_result result = take_light(medium->context, medium, &work.light);
    if (result == TY_OK) result = begin_work(&work);
    if (result == TY_OK) {
        find_coefficients(&work);
        result = solve_channels(&work);
    }
    stats->bytes = (double)work.memory_size;
    end_work(&work);
    *out = result == TY_OK ? work.light : NULL;
    if (result != TY_OK) ty_diffuse_light_destroy(work.light);
    return result;
}

ty_source_field ty_diffuse_light_field(const ty_diffuse_light* light, bool directed) {
    ty_source_field field = {
        .box = light->box, .term_count = directed || !light->even ? TY_FIELD_TERMS : 1, .shared = light->shared};
    for (int c = 0; c < 3; ++c) {
        field.color[c] = light->color[c];
        for (int t = 0; t < TY_FIELD_TERMS; ++t) field.terms[c][t] = light->terms[c][t];
    }
    return field;
}
