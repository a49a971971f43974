/* Injection of light of area lights, emissive surfaces and environments, and of the media's own light. */
#include "base/context.h"
#include "base/parallel.h"
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
    const surfel_job reflection = {.lattice = lattice,
                                   .surfels = surfels->items,
                                   .count = surfels->count,
                                   .view = ty_extended_view_of(job->scene, job->light->extended, &points,
                                                               dims ? job->light->medium : NULL, &job->light->reduced),
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

typedef struct cell_job {
    ty_lattice* lattice;
    const ty_extended_view* view; /* NULL: only the media's own light */
    ty_ray_counter* counter;
    float band1;       /* window of band 1 */
    bool injects;      /* whether the light that media scatter enters the lattice */
    double* scattered; /* 3 a row, W */
    double* emitted;
} cell_job;

static bool scatters_or_emits(const ty_grid_medium* medium, size_t cell) {
    float sum = 0.0f;
    for (int c = 0; c < 3; ++c)
        sum += medium->scattering[c][cell] + (medium->emission[0] != NULL ? medium->emission[c][cell] : 0.0f);
    return sum > 0.0f;
}

/* True if a cell or one around it scatters: images interpolate between them. */
static bool scatters_nearby(const ty_lattice* lattice, int32_t x, int32_t y, int32_t z) {
    const int32_t* size = lattice->box.size;
    for (int32_t i = 0; i < 27; ++i) {
        const int32_t at[3] = {x + i % 3 - 1, y + i / 3 % 3 - 1, z + i / 9 - 1};
        bool inside = true;
        for (int a = 0; a < 3; ++a) inside = inside && at[a] >= 0 && at[a] < size[a];
        if (inside && scatters_or_emits(lattice->medium, (size_t)(at[0] + size[0] * (at[1] + size[1] * at[2]))))
            return true;
    }
    return false;
}

/* Injects the power that a cell scatters by direction, its volume times sigma_s times each term times its moment g^l of
 * the phase function, and the power that it emits, its volume times j, isotropically. */
static void inject(const cell_job* job, size_t cell, int64_t row, float (*terms)[TY_SH_TERMS_MAX]) {
    ty_lattice* lattice = job->lattice;
    const ty_grid_medium* medium = lattice->medium;
    const float volume = lattice->cell * lattice->cell * lattice->cell;
    for (int32_t c = 0; c < 3; ++c) {
        const float g = medium->g[c][cell], kept = lattice->reduces ? 1.0f - ty_reduced_forward_fraction(g) : 1.0f;
        const float scattering = volume * kept * medium->scattering[c][cell];
        const float* border_scale = lattice->border_scale[medium->planes == 1 ? 0 : c];
        const float emitting = border_scale != NULL ? volume * border_scale[cell] : volume;
        const float emitted = medium->emission[0] != NULL ? emitting * medium->emission[c][cell] : 0.0f;
        const float directed = scattering * (lattice->reduces ? ty_reduced_g(g) : g) * job->band1;
        lattice->propagated_sh[c][0][cell] += scattering * terms[c][0] + TY_SH_0 * emitted;
        for (int t = 1; t < 4; ++t) lattice->propagated_sh[c][t][cell] += directed * terms[c][t];
        job->scattered[3 * row + c] += (double)(scattering * terms[c][0]) / (double)TY_SH_0;
        job->emitted[3 * row + c] += (double)emitted;
    }
}

/* Extinction of the light of lights, 1/m. */
static float extinction_in(const ty_lattice* lattice, int32_t c, size_t cell) {
    const ty_grid_medium* medium = lattice->medium;
    const float fraction = lattice->reduces ? ty_reduced_forward_fraction(medium->g[c][cell]) : 0.0f;
    return medium->extinction[c][cell] - fraction * medium->scattering[c][cell];
}

/* Mean cosine above which five bands blur a phase function. */
static const float narrow_g = 0.8f;

static ty_light_cell cell_at(const ty_lattice* lattice, int32_t x, int32_t y, int32_t z) {
    const double *lower = lattice->box.lower, side = (double)lattice->cell;
    const size_t cell = (size_t)(x + lattice->box.size[0] * (y + lattice->box.size[1] * z));
    ty_light_cell out = {.side = lattice->cell,
                         .center =
                             ty_vec_make((float)(lower[0] + side * (x + 0.5)), (float)(lower[1] + side * (y + 0.5)),
                                         (float)(lower[2] + side * (z + 0.5)))};
    for (int32_t c = 0; c < 3; ++c) {
        out.extinction[c] = extinction_in(lattice, c, cell);
        out.narrow = out.narrow || lattice->medium->g[c][cell] > narrow_g;
    }
    return out;
}

static void store_visible(ty_lattice* lattice, int c, size_t cell, const ty_cell_radiance* radiance) {
    for (int t = 0; t < TY_SH_TERMS_MAX; ++t) lattice->uncollided[c][t][cell] = radiance->visible[c][t];
    for (int t = 0; t < TY_BEAM_TERMS; ++t) lattice->beam[c][t][cell] = radiance->beam[c][t];
}

static void fill_row(void* user, int64_t row, int32_t worker) {
    (void)worker;
    const cell_job* job = user;
    ty_lattice* lattice = job->lattice;
    const int32_t *size = lattice->box.size, y = (int32_t)(row % size[1]), z = (int32_t)(row / size[1]);
    const double begun = ty_wall_seconds();
    const bool is_seen = lattice->uncollided[0][0] != NULL;
    int64_t rays = 0;
    for (int32_t x = 0; x < size[0]; ++x) {
        const size_t cell = (size_t)row * (size_t)size[0] + (size_t)x;
        const bool scatters = scatters_or_emits(lattice->medium, cell);
        if (!scatters && !(is_seen && scatters_nearby(lattice, x, y, z))) continue;
        const ty_light_cell light_cell = cell_at(lattice, x, y, z);
        ty_cell_radiance radiance = {.mean = {{0}}};
        if (job->view != NULL) rays += ty_extended_radiance(job->view, &light_cell, &radiance);
        for (int c = 0; c < 3 && is_seen; ++c) store_visible(lattice, c, cell, &radiance);
        if (job->injects && scatters) inject(job, cell, row, radiance.mean);
    }
    ty_ray_counter_add(job->counter, rays, ty_wall_seconds() - begun);
}

static ty_result allocate_uncollided(ty_lattice* lattice) {
    const double bytes = 3.0 * (TY_SH_TERMS_MAX + TY_BEAM_TERMS) * sizeof(float) * (double)lattice->cells;
    const ty_result result = ty_check_memory(lattice->context, bytes, "the light of extended lights in a lattice");
    if (result != TY_OK) return result;
    for (int c = 0; c < 3; ++c)
        for (int t = 0; t < TY_SH_TERMS_MAX; ++t) {
            lattice->uncollided[c][t] = ty_alloc_array(lattice->context, lattice->cells, sizeof(float), true);
            if (lattice->uncollided[c][t] == NULL) return TY_ERROR_MEMORY;
        }
    for (int c = 0; c < 3; ++c)
        for (int t = 0; t < TY_BEAM_TERMS; ++t) {
            lattice->beam[c][t] = ty_alloc_array(lattice->context, lattice->cells, sizeof(float), true);
            if (lattice->beam[c][t] == NULL) return TY_ERROR_MEMORY;
        }
    return TY_OK;
}

/* Fills in all rows; the sums of power are in their order. */
static ty_result fill_cells(const ty_lpv_job* job, cell_job* cells, double scattered[3], double emitted[3]) {
    const int64_t rows = (int64_t)cells->lattice->box.size[1] * cells->lattice->box.size[2];
    const size_t sums = 3 * (size_t)rows;
    cells->scattered = ty_alloc_array(job->context, sums, sizeof(double), true);
    cells->emitted = ty_alloc_array(job->context, sums, sizeof(double), true);
    const bool taken = cells->scattered != NULL && cells->emitted != NULL;
    if (taken) ty_parallel_flushed(job->context, rows, fill_row, cells);
    for (size_t i = 0; i < sums && taken; ++i) {
        scattered[i % 3] += cells->scattered[i];
        emitted[i % 3] += cells->emitted[i];
    }
    ty_free_array(job->context, cells->scattered, sums, sizeof(double));
    ty_free_array(job->context, cells->emitted, sums, sizeof(double));
    return taken ? TY_OK : TY_ERROR_MEMORY;
}

ty_result ty_lpv_inject_in_media(ty_lpv_job* job, ty_lattice* lattice, double scattered[3], double emitted[3]) {
    const bool extended = job->light->extended != NULL, is_seen = (job->def->parts & TY_LPV_SINGLE) != 0;
    cell_job cells = {.lattice = lattice,
                      .counter = &job->counter,
                      .band1 = ty_lpv_window(job->def, 1),
                      .injects = (job->def->parts & TY_LPV_SCATTERED) != 0};
    ty_light_points points = {.context = job->context};
    if (lattice->medium == NULL || (!extended && lattice->medium->emission[0] == NULL)) return TY_OK;
    /* Half of the points of all pixels of a pattern. */
    ty_result result =
        ty_light_points_create(job->context, (job->def->light_samples + 1) / 2, job->def->seed, 0, &points);
    const ty_extended_view view =
        ty_extended_view_of(job->scene, job->light->extended, &points, job->light->medium, &job->light->reduced);
    if (extended) cells.view = &view;
    if (result == TY_OK && extended && is_seen) result = allocate_uncollided(lattice);
    if (result == TY_OK) result = fill_cells(job, &cells, scattered, emitted);
    ty_light_points_destroy(&points);
    return result;
}
