/* Fluxes by columns of scenes that repeat: uncollided light through the faces of layers of fine cells, and partial
 * currents of the ordinates through those of coarse cells. Both are conserved, so that what comes in goes out or is
 * absorbed. */
#include "base/constants.h"
#include "base/context.h"
#include "direct/media/coverage.h"
#include "direct/single/source_field.h"
#include "direct/uncollided/repeated.h"
#include "method/dom/flux_request.h"
#include "method/dom/sources/sources.h"
#include "scene/scene.h"

#include <math.h>
#include <string.h>

/* ---- requests ---- */

static ty_result check_columns(const ty_dom_job* job, const ty_flux_def* def) {
    const ty_grid_box* box = &job->light->box;
    const int32_t axes[2] = {0, job->scene->up == TY_AXIS_Z ? 1 : 2};
    for (int i = 0; i < 2; ++i) {
        const int32_t a = axes[i];
        const double room = 1e-5 * (box->upper[a] - box->lower[a]);
        if ((job->coarse->periodic >> a & 1) == 0)
            return ty_fail(job->context, TY_ERROR_ARGUMENT,
                           "flux: dom gives fluxes of scenes that repeat along both horizontal axes; the method path "
                           "of all scenes");
        if (def->lower[i] < box->lower[a] - room || def->upper[i] > box->upper[a] + room)
            return ty_fail(job->context, TY_ERROR_ARGUMENT, "flux.lower[%d]: columns of dom lie in the scene's cell",
                           i);
    }
    return TY_OK;
}

ty_result ty_dom_flux_begin(ty_dom_job* job) {
    const ty_dom* light = job->light;
    ty_dom_flux_request* request = job->flux;
    if (request == NULL) return TY_OK;
    const ty_result result = check_columns(job, &request->table->def);
    if (result != TY_OK) return result;
    request->cells = light->cells;
    for (int32_t c = 0; c < ty_dom_channels(light); ++c)
        for (int rises = 0; rises < 2; ++rises) {
            request->passing[c][rises] = ty_alloc_array(job->context, light->cells, sizeof(float), true);
            if (request->passing[c][rises] == NULL) return TY_ERROR_MEMORY;
        }
    return TY_OK;
}

static void end_request(ty_context* context, ty_dom_flux_request* request) {
    for (int32_t c = 0; c < 3; ++c)
        for (int i = 0; i < 2; ++i)
            if (request->passing[c][i] != NULL)
                ty_free_array(context, request->passing[c][i], request->cells, sizeof(float));
}

/* ---- columns ---- */

typedef struct flux_job {
    const ty_dom_job* dom;
    ty_flux* flux;
    int32_t up; /* the axis */
    double lower[3], upper[3];
    int32_t size[3]; /* columns */
} flux_job;

/* Adds the means of a plane over all columns, times scale, to a channel of a quantity. */
static void add_columns(const flux_job* job, const ty_grid_box* box, const float* plane, double scale,
                        ty_flux_quantity quantity, int32_t index, int c) {
    const ty_coverage_box columns = {job->lower, job->upper, job->size};
    double* values = (double*)(uintptr_t)ty_flux_values(job->flux, quantity, index);
    const int second = job->up == 2 ? 1 : 2;
    for (int32_t i = 0; i < job->size[0] * job->size[second]; ++i) {
        int32_t cell[3] = {i % job->size[0], 0, 0};
        ty_coverage axes[3];
        cell[second] = i / job->size[0];
        ty_coverage_of_cell(box, &columns, cell, axes);
        ty_coverage_add(box, axes, &plane, 1, scale, &values[3 * i + c]);
    }
}

/* A box whose cells are the columns of another one's. */
static ty_grid_box flatten(const ty_grid_box* box, int32_t up) {
    ty_grid_box flat = *box;
    flat.size[up] = 1;
    return flat;
}

/* The faces below and above a level's height, and the weight of the upper one. */
static int32_t find_faces(const ty_grid_box* box, int32_t up, double height, float* weight) {
    const int32_t count = box->size[up];
    const double at = (height - box->lower[up]) / (box->upper[up] - box->lower[up]) * count;
    const double within = fmax(0, fmin(at, count));
    const int32_t below = within < count ? (int32_t)within : count - 1;
    *weight = (float)(within - below);
    return below;
}

/* ---- ordinates ---- */

/* Adds the power through face k of all columns of cells to a plane, times a factor. */
static void add_face(const flux_job* job, const float* const passing[2], bool rises, int32_t k, float factor,
                     float* plane) {
    const ty_grid_box* box = &job->dom->light->box;
    const int32_t *size = box->size, up = job->up, layer = rises ? k - 1 : k;
    if (layer < 0 || layer >= size[up]) return;
    for (int32_t j = 0; j < size[up == 2 ? 1 : 2]; ++j)
        for (int32_t i = 0; i < size[0]; ++i) {
            const int32_t y = up == 2 ? j : layer, z = up == 2 ? layer : j;
            plane[(size_t)j * (size_t)size[0] + (size_t)i] +=
                factor * passing[rises][((size_t)z * (size_t)size[1] + (size_t)y) * (size_t)size[0] + (size_t)i];
        }
}

static void add_collided(const flux_job* job, float* plane) {
    const ty_dom* light = job->dom->light;
    const ty_grid_box flat = flatten(&light->box, job->up);
    const double* edge = job->dom->coarse->cell;
    const double area = edge[0] * edge[job->up == 2 ? 1 : 2];
    const size_t faces = (size_t)flat.size[0] * (size_t)flat.size[1] * (size_t)flat.size[2];
    for (int32_t level = 0; level < job->flux->def.level_count; ++level)
        for (int rises = 0; rises < 2; ++rises)
            for (int c = 0; c < 3; ++c) {
                const float* const* passing = (const float* const*)job->dom->flux->passing[light->shared ? 0 : c];
                float weight;
                const int32_t below = find_faces(&light->box, job->up, job->flux->levels[level], &weight);
                memset(plane, 0, sizeof(float) * faces);
                add_face(job, passing, rises != 0, below, 1 - weight, plane);
                add_face(job, passing, rises != 0, below + 1, weight, plane);
                add_columns(job, &flat, plane, (double)light->color[c] / area,
                            rises != 0 ? TY_FLUX_UP : TY_FLUX_DOWN_DIFFUSE, level, c);
            }
}

/* ---- uncollided light ---- */

typedef struct beam_planes {
    float* extinction[2][3]; /* sigma_t, and that of the light that the ordinates take for uncollided */
    double* through;
    size_t faces;
    float* plane;
} beam_planes;

/* Adds a source's light through all levels, once for each channel of a plane of the medium. unscattered: by sigma_t;
 * else by the extinction of the ordinates, of which the light that scattered nearly straight on is diffuse. */
static void add_through(const flux_job* job, const beam_planes* beams, const ty_discrete_light* source, int32_t plane,
                        bool unscattered) {
    const ty_grid_medium* fine = job->dom->fine;
    const ty_grid_box flat = flatten(&fine->box, job->up);
    const float along[3] = {source->direction.x, source->direction.y, source->direction.z};
    const bool rises = along[job->up] > 0;
    if (unscattered && rises) return;
    for (int32_t level = 0; level < job->flux->def.level_count; ++level) {
        float weight;
        const int32_t below = find_faces(&fine->box, job->up, job->flux->levels[level], &weight);
        const double* low = beams->through + beams->faces * (size_t)below;
        for (size_t i = 0; i < beams->faces; ++i)
            beams->plane[i] = (float)(low[i] + (double)weight * (low[i + beams->faces] - low[i]));
        for (int32_t c = plane; c < (fine->planes == 3 ? plane + 1 : 3); ++c) {
            const double color = (double)source->color[c];
            if (rises) add_columns(job, &flat, beams->plane, color, TY_FLUX_UP, level, c);
            if (unscattered) add_columns(job, &flat, beams->plane, color, TY_FLUX_DOWN_DIRECT, level, c);
            if (!rises)
                add_columns(job, &flat, beams->plane, unscattered ? -color : color, TY_FLUX_DOWN_DIFFUSE, level, c);
        }
    }
}

static ty_result add_sources(const flux_job* job, const beam_planes* beams) {
    const ty_dom_job* dom = job->dom;
    ty_result result = TY_OK;
    for (int32_t i = 0; i < dom->sources.count; ++i)
        for (int32_t p = 0; p < dom->fine->planes; ++p)
            for (int scaled = 0; scaled < 2 && result == TY_OK; ++scaled) {
                const ty_repeated_beam beam = {.extinction = beams->extinction[scaled][p],
                                               .direction = dom->sources.items[i].direction,
                                               .through = beams->through};
                memset(beams->through, 0, sizeof(double) * beams->faces * (size_t)(dom->fine->box.size[job->up] + 1));
                result = ty_repeated_sweep(dom->fine, &beam);
                if (result == TY_OK) add_through(job, beams, &dom->sources.items[i], p, scaled == 0);
            }
    return result;
}

static ty_result add_uncollided(const flux_job* job) {
    const ty_grid_medium* fine = job->dom->fine;
    ty_context* context = job->dom->context;
    beam_planes beams = {.faces = fine->cells / (size_t)fine->box.size[job->up]};
    const size_t through = beams.faces * ((size_t)fine->box.size[job->up] + 1);
    ty_result result = TY_OK;
    beams.through = ty_alloc_array(context, through, sizeof(double), false);
    beams.plane = ty_alloc_array(context, beams.faces, sizeof(float), false);
    if (beams.through == NULL || beams.plane == NULL) result = TY_ERROR_MEMORY;
    for (int32_t p = 0; p < fine->planes && result == TY_OK; ++p) {
        beams.extinction[0][p] = fine->extinction[p];
        beams.extinction[1][p] = ty_alloc_array(context, fine->cells, sizeof(float), false);
        if (beams.extinction[1][p] == NULL) result = TY_ERROR_MEMORY;
    }
    if (result == TY_OK) ty_dom_uncollided_extinction(job->dom, beams.extinction[1]);
    if (result == TY_OK) result = add_sources(job, &beams);
    for (int32_t p = 0; p < fine->planes; ++p)
        ty_free_array(context, beams.extinction[1][p], fine->cells, sizeof(float));
    ty_free_array(context, beams.through, through, sizeof(double));
    ty_free_array(context, beams.plane, beams.faces, sizeof(float));
    return result;
}

/* ---- absorption ---- */

/* Adds the absorption of a fluence in a medium's cells. */
static void add_absorbed(const flux_job* job, const ty_grid_medium* medium, const float* fluence, double factor, int c,
                         float* plane) {
    const int32_t p = medium->planes == 3 ? c : 0;
    for (size_t i = 0; i < medium->cells; ++i)
        plane[i] = (medium->extinction[p][i] - medium->scattering[p][i]) * fluence[i];
    const double height = medium->box.upper[job->up] - medium->box.lower[job->up];
    add_columns(job, &medium->box, plane, factor * height, TY_FLUX_ABSORBED, 0, c);
}

static void add_all_absorbed(const flux_job* job, float* plane) {
    const ty_dom* light = job->dom->light;
    for (int c = 0; c < 3; ++c) {
        for (int32_t l = 0; l < light->fluence_count; ++l) {
            float factor;
            const float* fluence = ty_light_fluence_plane(&light->fluences[l], c, &factor);
            add_absorbed(job, job->dom->fine, fluence, (double)factor, c, plane);
        }
        add_absorbed(job, job->dom->coarse, light->moments[light->shared ? 0 : c],
                     TY_SQRT_4PI_F64 * (double)light->color[c], c, plane);
    }
}

/* ---- all ---- */

ty_result ty_dom_flux_fill(const ty_dom_job* dom) {
    if (dom->flux == NULL) return TY_OK;
    ty_flux* flux = dom->flux->table;
    flux_job job = {.dom = dom, .flux = flux, .up = dom->scene->up == TY_AXIS_Z ? 2 : 1};
    const int32_t second = job.up == 2 ? 1 : 2;
    for (int i = 0; i < 2; ++i) {
        const int32_t a = i == 0 ? 0 : second;
        job.lower[a] = flux->def.lower[i];
        job.upper[a] = flux->def.upper[i];
        job.size[a] = flux->def.columns[i];
    }
    job.lower[job.up] = dom->light->box.lower[job.up];
    job.upper[job.up] = dom->light->box.upper[job.up];
    job.size[job.up] = 1;
    const size_t largest = dom->fine->cells > dom->coarse->cells ? dom->fine->cells : dom->coarse->cells;
    float* plane = ty_alloc_array(dom->context, largest, sizeof(float), false);
    if (plane == NULL) return TY_ERROR_MEMORY;
    add_collided(&job, plane);
    add_all_absorbed(&job, plane);
    ty_free_array(dom->context, plane, largest, sizeof(float));
    return add_uncollided(&job);
}

ty_result ty_dom_flux(const ty_scene* scene, const ty_dom_def* dom, const ty_flux_def* def, ty_flux** out,
                      ty_dom_stats* stats) {
    ty_context* context = ty_scene_context(scene);
    ty_flux_def own = ty_default_flux_def();
    ty_dom_flux_request request = {.table = NULL};
    *out = NULL;
    ty_result result = ty_take_def(context, def, "ty_default_flux_def", &own, sizeof own);
    if (result == TY_OK) result = ty_flux_check(context, &own);
    if (result == TY_OK && own.view_count > 0)
        result =
            ty_fail(context, TY_ERROR_ARGUMENT, "flux.views: dom gives no radiance of views; the method path does");
    if (result == TY_OK) result = ty_flux_place_columns(scene, &own);
    if (result == TY_OK) result = ty_flux_create(context, &own, &request.table);
    if (result != TY_OK) return result;
    void* light = NULL;
    result = ty_volume_solve_for(&ty_volume_dom, scene, dom, &request, &light, stats);
    end_request(context, &request);
    ty_dom_destroy(light);
    if (result == TY_OK)
        *out = request.table;
    else
        ty_flux_destroy(request.table);
    return result;
}
