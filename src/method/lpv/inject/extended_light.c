/* Injection of light of area lights, emissive surfaces and environments, and of the media's own light. */
#include "base/context.h"
#include "base/parallel.h"
#include "direct/lights/discretize.h"
#include "direct/uncollided/uncollided.h"
#include "method/lpv/extended/extended_lights.h"
#include "method/lpv/inject/inject.h"
#include "method/lpv/inject/splat.h"
#include "method/lpv/lattice/lookup.k.h"

/* ---- light that surfaces reflect ---- */

/* Surfels of a row of splats; each surfel has two sides. */
enum { ROW_SURFELS = 64 };

/* Distance from the surface at which shadow rays begin, in cells. */
static const float off_surface = 1e-3f;

typedef struct surfel_job {
    const ty_lattice* lattice;
    const ty_surfel* surfels;
    size_t count;
    ty_extended_view view;
    ty_splat_cells cells;
    ty_ray_counter* counter;
} surfel_job;

/* The cosine lobe of one side of a surfel; false if it reflects nothing into the lattice. */
static bool reflect(const surfel_job* job, size_t index, ty_vec normal, int32_t* rays, ty_splat* out) {
    const ty_surfel* surfel = &job->surfels[index];
    const ty_vec point = surfel->position;
    out->cell = ty_splat_cell(&job->cells, ty_lattice_lit_side(job->lattice, point, normal));
    if (out->cell < 0) out->cell = ty_splat_cell(&job->cells, ty_lattice_lift(point, normal, job->lattice->cell));
    if (out->cell < 0) return false;
    const ty_light_receiver receiver = {ty_mad(point, normal, off_surface * job->lattice->cell), normal, normal};
    float irradiance[3];
    *rays += ty_extended_irradiance(&job->view, &receiver, (int32_t)(index % TY_LIGHT_PATTERN), irradiance);
    out->axis = normal;
    for (int c = 0; c < 3; ++c) out->power[c] = surfel->area * surfel->albedo[c] * irradiance[c];
    return out->power[0] + out->power[1] + out->power[2] > 0.0f;
}

static int32_t reflect_row(const void* user, int64_t row, ty_splat* out) {
    const surfel_job* job = user;
    const size_t first = (size_t)row * ROW_SURFELS;
    const double begun = ty_wall_seconds();
    int32_t count = 0, rays = 0;
    for (size_t i = first; i < job->count && i < first + ROW_SURFELS; ++i) {
        const ty_surfel* surfel = &job->surfels[i];
        if (!(surfel->albedo[0] + surfel->albedo[1] + surfel->albedo[2] > 0.0f)) continue;
        count += reflect(job, i, surfel->normal, &rays, &out[count]);
        count += reflect(job, i, ty_scale(surfel->normal, -1.0f), &rays, &out[count]);
    }
    ty_ray_counter_add(job->counter, rays, ty_wall_seconds() - begun);
    return count;
}

ty_result ty_lpv_inject_extended_reflected(ty_lpv_job* job, ty_lattice* lattice, const ty_surfel_list* surfels,
                                           double power[3]) {
    const bool dims = (job->def->parts & TY_LPV_SCATTERING) != 0;
    ty_light_points points;
    ty_result result =
        ty_light_points_create(job->context, (job->def->light_samples + 1) / 2, job->def->seed, 0, &points);
    if (result != TY_OK) return result;
    const surfel_job reflection = {
        .lattice = lattice,
        .surfels = surfels->items,
        .count = surfels->count,
        .view = ty_extended_view_of(job->scene, job->light->extended, &points, dims ? job->light->medium : NULL),
        .cells = ty_splat_cells_of(lattice),
        .counter = &job->counter};
    ty_splat_rows rows = {.rows = (int64_t)((surfels->count + ROW_SURFELS - 1) / ROW_SURFELS),
                          .max_splats = 2 * ROW_SURFELS,
                          .user = &reflection,
                          .row = reflect_row,
                          .band = {1}};
    /* A virtual light per surfel, as a clamped cosine lobe about its normal (Kaplanyan and Dachsbacher 2010). */
    for (int32_t l = 1; l < lattice->bands; ++l)
        rows.band[l] = ty_lpv_window(job->def, l) * ty_sh_cosine(l) / ty_sh_cosine(0);
    if (rows.rows > 0) result = ty_splats_add(lattice, &rows, power);
    ty_light_points_destroy(&points);
    return result;
}

/* ---- light that media scatter ---- */

/* Directions of an environment and points of an area light that stand for them in the lattice's cells; all emissive
 * triangles together have four times as many points. */
enum { DIRECTIONS = 64, POINTS = 16 };

/* Keeps the samples of lights with extent. */
static void keep_extended(const ty_scene* scene, ty_discrete_light_set* samples) {
    int32_t kept = 0;
    for (int32_t i = 0; i < samples->count; ++i)
        if (scene->view.lights.lights[samples->items[i].light].kind >= TY_KIND_AREA)
            samples->items[kept++] = samples->items[i];
    samples->count = kept;
}

static ty_result find_field(const ty_lpv_job* job, const ty_lattice* lattice, ty_light_field** field) {
    const ty_discretize_def def = {.environment = DIRECTIONS, .surface = POINTS, .seed = job->def->seed};
    ty_discrete_light_set samples;
    ty_result result = ty_discretize_lights(job->scene, &def, &samples);
    if (result == TY_OK) {
        keep_extended(job->scene, &samples);
        result = ty_light_field_create(lattice->medium, true, field);
    }
    if (result == TY_OK)
        result = ty_uncollided_add(job->scene, lattice->medium, NULL, samples.items, samples.count, *field);
    ty_discrete_light_set_destroy(job->context, &samples);
    return result;
}

typedef struct cell_job {
    ty_lattice* lattice;
    const ty_light_field* field; /* NULL: only the media's own light */
    float band1;                 /* window of band 1 */
    bool injects;                /* whether the light that media scatter enters the lattice */
    double* scattered;           /* 3 a slab, W */
    double* emitted;
} cell_job;

/* Terms of radiance with two moments: L_00 = phi Y_00, L_1m = sqrt(3 / (4 pi)) F, as (Y_1m) are (y, z, x). */
static void find_terms(const ty_light_field* field, int32_t c, size_t cell, float terms[4]) {
    terms[0] = TY_SH_0 * field->fluence[c][cell];
    terms[1] = TY_SH_1 * field->flux[c][1][cell];
    terms[2] = TY_SH_1 * field->flux[c][2][cell];
    terms[3] = TY_SH_1 * field->flux[c][0][cell];
}

static void fill_slab(void* user, int64_t slab, int32_t worker) {
    (void)worker;
    const cell_job* job = user;
    ty_lattice* lattice = job->lattice;
    const ty_grid_medium* medium = lattice->medium;
    const float volume = lattice->cell * lattice->cell * lattice->cell;
    const size_t plane = (size_t)lattice->box.size[0] * (size_t)lattice->box.size[1];
    for (size_t cell = (size_t)slab * plane; cell < ((size_t)slab + 1) * plane; ++cell)
        for (int32_t c = 0; c < 3; ++c) {
            float terms[4] = {0, 0, 0, 0};
            if (job->field != NULL) find_terms(job->field, c, cell, terms);
            for (int t = 0; t < 4 && lattice->uncollided[c][0] != NULL; ++t) lattice->uncollided[c][t][cell] = terms[t];
            if (!job->injects) continue;
            /* Power that the cell scatters by direction: volume * sigma_s times each term times its moment of the
             * phase function, g^l; and the power that it emits, volume * j, isotropically. */
            const float scattering = volume * medium->scattering[c][cell];
            const float emitted = medium->emission[0] != NULL ? volume * medium->emission[c][cell] : 0.0f;
            const float directed = scattering * medium->g[c][cell] * job->band1;
            lattice->propagated_sh[c][0][cell] += scattering * terms[0] + TY_SH_0 * emitted;
            for (int t = 1; t < 4; ++t) lattice->propagated_sh[c][t][cell] += directed * terms[t];
            job->scattered[3 * slab + c] += (double)(scattering * terms[0]) / (double)TY_SH_0;
            job->emitted[3 * slab + c] += (double)emitted;
        }
}

static ty_result allocate_uncollided(ty_lattice* lattice) {
    for (int c = 0; c < 3; ++c)
        for (int t = 0; t < TY_UNCOLLIDED_TERMS; ++t) {
            lattice->uncollided[c][t] = ty_alloc_array(lattice->context, lattice->cells, sizeof(float), false);
            if (lattice->uncollided[c][t] == NULL) return TY_ERROR_MEMORY;
        }
    return TY_OK;
}

ty_result ty_lpv_inject_in_media(ty_lpv_job* job, ty_lattice* lattice, double scattered[3], double emitted[3]) {
    const bool extended = job->light->extended != NULL;
    const size_t sums = 3 * (size_t)lattice->box.size[2];
    ty_light_field* field = NULL;
    if (lattice->medium == NULL || (!extended && lattice->medium->emission[0] == NULL)) return TY_OK;
    cell_job cells = {
        .lattice = lattice, .band1 = ty_lpv_window(job->def, 1), .injects = (job->def->parts & TY_LPV_SCATTERED) != 0};
    cells.scattered = ty_alloc_array(job->context, sums, sizeof(double), true);
    cells.emitted = ty_alloc_array(job->context, sums, sizeof(double), true);
    ty_result result = cells.scattered != NULL && cells.emitted != NULL ? TY_OK : TY_ERROR_MEMORY;
    if (result == TY_OK && extended) result = find_field(job, lattice, &field);
    if (result == TY_OK && extended && (job->def->parts & TY_LPV_SINGLE) != 0) result = allocate_uncollided(lattice);
    cells.field = field;
    if (result == TY_OK) ty_parallel_for(job->context, lattice->box.size[2], fill_slab, &cells);
    for (size_t i = 0; i < sums && result == TY_OK; ++i) {
        scattered[i % 3] += cells.scattered[i];
        emitted[i % 3] += cells.emitted[i];
    }
    ty_light_field_destroy(field);
    ty_free_array(job->context, cells.scattered, sums, sizeof(double));
    ty_free_array(job->context, cells.emitted, sums, sizeof(double));
    return result;
}
