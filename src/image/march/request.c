/* The kernel's request of a def, with the fields' cells packed for it. */
#include "image/march/request.h"

#include "base/context.h"
#include "image/march/irradiance_cache.h"
#include "image/march/deconvolve.h"

/* Transmittance below which a ray ends as opaque: one of its own for each pixel, and one for several. */
static const float black = 1e-5f, black_spaced = 2e-3f;

bool ty_march_has_froxels(const ty_march_def* def) {
    return def->froxels[0] != 0 || def->froxels[1] != 0 || def->froxels[2] != 0;
}

bool ty_march_gathers(const ty_march_def* def, const ty_march_request* request) {
    return ty_march_has_edges(def) && request->camera.sampled == 0;
}

bool ty_march_has_edges(const ty_march_def* def) {
    return def->ray_spacing == 1 && !ty_march_has_froxels(def);
}

static ty_cell_lattice lattice_of_box(const ty_grid_box* box) {
    ty_cell_lattice lattice;
    float lower[3], per_cell[3];
    for (int a = 0; a < 3; ++a) {
        lattice.size[a] = box->size[a];
        lower[a] = (float)box->lower[a];
        per_cell[a] = (float)(box->size[a] / (box->upper[a] - box->lower[a]));
    }
    lattice.lower = ty_vec_load(lower);
    lattice.per_cell = ty_vec_load(per_cell);
    return lattice;
}

typedef struct pack_job {
    const ty_source_field* field;
    ty_upsample_view* view;
    float* cells;
} pack_job;

static void pack_plane(void* user, int64_t z, int32_t worker) {
    (void)worker;
    const pack_job* pack = user;
    const ty_source_field* field = pack->field;
    const size_t plane = (size_t)field->box.size[0] * (size_t)field->box.size[1];
    const ty_upsample_view* view = pack->view;
    const int32_t terms = view->terms, guide = view->channels * terms;
    for (size_t i = (size_t)z * plane; i < (size_t)(z + 1) * plane; ++i) {
        float* cell = pack->cells + i * (size_t)view->floats;
        for (int c = 0; c < view->channels; ++c)
            for (int t = 0; t < terms; ++t) cell[c * terms + t] = field->terms[c][t][i];
        cell[guide] = field->guide != NULL ? field->guide[i] : 0;
        for (int32_t padding = guide + 1; padding < view->floats; ++padding) cell[padding] = 0;
    }
}

/* Packs the terms of a cell together, so that one lookup touches one cache line. */
static ty_result pack_field(const ty_packed_request* packed, const ty_march_def* def, const ty_source_field* field,
                            const ty_cuts* cuts, ty_packed_cells* cells, ty_upsample_view* view) {
    const int32_t* size = field->box.size;
    view->lattice = lattice_of_box(&field->box);
    view->channels = field->shared ? 1 : 3;
    view->cuts = ty_cuts_get_view(cuts);
    view->terms = field->term_count;
    view->floats = field->term_count == 1 ? TY_UPSAMPLE_PLAIN
                   : field->shared        ? TY_UPSAMPLE_SHARED
                                          : TY_UPSAMPLE_DIRECTED;
    for (int c = 0; c < 3; ++c) view->color[c] = field->shared ? field->color[c] : 1;
    const double sigma = def->bilateral_sigma;
    view->sharpness = sigma > 0 && field->guide != NULL ? (float)(1 / (2 * sigma * sigma)) : 0;
    cells->count = (size_t)size[0] * (size_t)size[1] * (size_t)size[2] * (size_t)view->floats;
    cells->floats = ty_alloc_array(packed->context, cells->count, sizeof(float), false);
    if (cells->floats == NULL) return TY_ERROR_MEMORY;
    view->cells = cells->floats;
    pack_job pack = {field, view, cells->floats};
    ty_parallel_for(packed->context, size[2], pack_plane, &pack);
    if (!def->preserve_means) return TY_OK;
    return ty_deconvolve_means(packed->context, size, view->floats, view->terms, view->channels * view->terms, cuts,
                               field->at_face, cells->floats);
}

static ty_result pack_fields(const ty_march_def* def, ty_packed_request* packed) {
    ty_march_request* request = &packed->request;
    if (def->field == NULL) return TY_OK;
    request->has_field = 1;
    const ty_result result = pack_field(packed, def, def->field, def->cuts, &packed->cells, &request->field);
    request->surface_field = request->field;
    if (result != TY_OK || def->surface_field == NULL) return result;
    return pack_field(packed, def, def->surface_field, NULL, &packed->surface_cells, &request->surface_field);
}

ty_result ty_march_request_make(const ty_scene* scene, const ty_march_def* def, ty_packed_request* out) {
    const ty_camera_def camera = ty_scene_camera(scene);
    ty_march_request* request = &out->request;
    *out = (ty_packed_request){.context = ty_scene_context(scene)};
    request->scene = ty_scene_get_view(scene);
    if (request->scene == NULL) return TY_ERROR_ARGUMENT;
    request->camera = ty_camera_get_view(&camera, def->width, def->height);
    request->spp = def->spp;
    request->step_offset = def->seed != 0 ? (float)(ty_mix64(def->seed) >> 40) * 0x1p-24f : 0;
    request->step = (float)def->step;
    request->black = def->ray_spacing == 1 || ty_march_has_froxels(def) ? black : black_spaced;
    request->has_background = def->unscattered == NULL;
    request->light = lattice_of_box(&def->light_box);
    request->lights = def->lights;
    request->light_count = def->light_count;
    request->reduced = def->reduced;
    for (int32_t l = 0; l < 2 && def->legendre != NULL; ++l)
        request->forward[l] = ty_maxf(0, def->legendre[def->reduced + l]);
    request->has_forward = def->legendre != NULL;
    request->traces_faces = def->traces_faces;
    if (def->fit != NULL) request->fit = *def->fit;
    if (def->octaves != NULL) request->octaves = *def->octaves;
    request->blurred = def->blurred;
    ty_irradiance_cache_get_view(def->cache, &request->cache);
    return pack_fields(def, out);
}

void ty_march_request_free(ty_packed_request* packed) {
    ty_free_array(packed->context, packed->cells.floats, packed->cells.count, sizeof(float));
    ty_free_array(packed->context, packed->surface_cells.floats, packed->surface_cells.count, sizeof(float));
}
