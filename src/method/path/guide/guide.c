/* Cells of a guide, and the radiance from each bin of directions. */
#include "method/path/guide/guide.h"

#include "base/context.h"
#include "base/luminance.k.h"
#include "method/cell_light.h"
#include "scene/lights/light_tree.k.h"

#include <math.h>

/* Rays per bin. More of them, and finer cells and more rays cost more than they save. */
enum { RAYS = 2 };

/* Fractions of guided directions at the first vertex and of guided distances, and the decrease of the former with
 * depth, which bounds the weights of long paths. */
static const float directions = 0.6f, fall = 0.2f, distances = 0.5f;

/* Roulette: below this fraction of the pixel's expected radiance a path's contribution is left to chance, below another
 * one the shadow ray of a light. Cells of more free paths than max_thickness know too little of the light within them
 * for roulette of paths. */
static const float path_window = 0.15f, light_window = 0.4f, max_thickness = 2;

/* Of a direction that phase functions and surfaces sample, 1/sr. */
static const float typical_pdf = 1 / (2 * TY_PI);

typedef struct build {
    const ty_scene_view* scene;
    ty_path_guide* guide;
    ty_sobol sobol;
    uint64_t seed;
} build;

static float mean_of(float* const planes[3], int32_t count, size_t cell) {
    return count == 1 ? planes[0][cell] : ty_luminance(planes[0][cell], planes[1][cell], planes[2][cell]);
}

static void set_cells(const ty_grid_box* box, ty_guide_cells* out) {
    for (int a = 0; a < 3; ++a) {
        out->size[a] = box->size[a];
        out->lower[a] = (float)box->lower[a];
        out->per_metre[a] = (float)(box->size[a] / (box->upper[a] - box->lower[a]));
    }
}

static size_t count_cells(const ty_guide_cells* cells) {
    return (size_t)cells->size[0] * (size_t)cells->size[1] * (size_t)cells->size[2];
}

/* ---- radiance along rays ---- */

/* The part of emission that sampled directions find, of solid-angle density typical_pdf, by their MIS weight against
 * light sampling of density `sampled`. */
static float found_fraction(float sampled) {
    return typical_pdf / (typical_pdf + sampled);
}

static float environment_radiance(const ty_scene_view* scene, ty_vec direction) {
    float sum = 0;
    for (int32_t i = 0; i < scene->lights.distant_count; ++i) {
        const ty_light_view* light = &scene->lights.lights[scene->lights.distant[i]];
        float radiance[3];
        if (light->kind != TY_KIND_ENVIRONMENT) continue;
        ty_environment_radiance(&light->environment, direction, radiance);
        const float sampled =
            light->chosen > 0 ? light->chosen * ty_environment_pdf(&light->environment, direction) : 0;
        sum += ty_luminance_of(radiance) * found_fraction(sampled);
    }
    return sum;
}

/* Radiance that a surface sends to the origin of a ray. */
static float surface_radiance(const build* b, const ty_hit* hit, ty_vec origin, ty_vec direction) {
    const ty_light_set* lights = &b->scene->lights;
    ty_surface_point point;
    ty_surface_evaluate(&b->scene->surfaces[hit->surface], hit, direction, &point);
    float sampled = 0;
    if (point.light >= 0)
        sampled = ty_lights_probability(lights, point.light, origin, ty_vec_make(0, 0, 0), NULL) *
                  ty_light_pdf(&lights->lights[point.light], origin, direction, hit->distance);
    return ty_luminance_of(point.emission) * found_fraction(sampled) +
           ty_guide_surface_radiance(&b->guide->view, hit->position, point.ng, ty_luminance_of(point.albedo));
}

static float incident_radiance(const build* b, ty_vec origin, ty_vec direction) {
    ty_hit hit;
    float passed;
    const bool hits =
        b->scene->mesh != NULL && ty_accel_intersect(b->scene->mesh, origin, direction, TY_FLOAT_MAX, &hit);
    const float far = hits ? hit.distance : TY_FLOAT_MAX;
    const float media = ty_guide_media_radiance(&b->guide->view, origin, direction, far, &passed);
    return media +
           passed * (hits ? surface_radiance(b, &hit, origin, direction) : environment_radiance(b->scene, direction));
}

/* ---- bins ---- */

/* Integral of the radiance from a bin, from rays of random origin in the cell and direction in the bin. */
static float bin_radiance(const build* b, const int32_t cell[3], int32_t bin, ty_sampler* random) {
    const ty_guide_cells* cells = &b->guide->view.cells;
    const float side = 2.0f / TY_GUIDE_SIDE;
    float sum = 0;
    for (int ray = 0; ray < RAYS; ++ray) {
        float origin[3];
        for (int a = 0; a < 3; ++a)
            origin[a] = cells->lower[a] + ((float)cell[a] + ty_rng_uniform(random)) / cells->per_metre[a];
        const float u = ((float)(bin % TY_GUIDE_SIDE) + ty_rng_uniform(random)) * side - 1.0f;
        const float v = ((float)(bin / TY_GUIDE_SIDE) + ty_rng_uniform(random)) * side - 1.0f;
        const ty_vec direction = ty_octahedral_direction(u, v);
        sum += incident_radiance(b, ty_vec_load(origin), direction) * ty_octahedral_angle(direction, TY_GUIDE_SIDE);
    }
    return sum / RAYS;
}

static void fill_bins(void* user, int64_t index, int32_t worker) {
    (void)worker;
    const build* b = user;
    const int32_t* size = b->guide->view.cells.size;
    const int32_t cell[3] = {(int32_t)(index % size[0]), (int32_t)(index / size[0] % size[1]),
                             (int32_t)(index / size[0] / size[1])};
    ty_sampler random = ty_sampler_begin(&b->sobol, b->seed, (uint64_t)index, 0);
    float* radiance = b->guide->radiance + index * TY_GUIDE_BINS;
    for (int32_t bin = 0; bin < TY_GUIDE_BINS; ++bin) radiance[bin] = bin_radiance(b, cell, bin, &random);
}

/* ---- cells ---- */

static void set_light(const ty_cell_light* from, const ty_grid_medium* medium, ty_path_guide* guide) {
    for (size_t i = 0; i < guide->cells; ++i) {
        const ty_vec flux = ty_vec_make(from->flux[0][i], from->flux[1][i], from->flux[2][i]);
        const float fluence = ty_maxf(from->fluence[i], 0), length = sqrtf(ty_dot(flux, flux));
        guide->light[i] = (ty_guide_light){.fluence = fluence, .axis = ty_vec_make(0, 0, 1)};
        guide->light[i].sigma_t = mean_of(medium->extinction, medium->planes, i);
        guide->light[i].sigma_s = mean_of(medium->scattering, medium->planes, i);
        guide->light[i].g = medium->g[medium->planes == 3 ? 1 : 0][i];
        if (medium->emission[0] != NULL) guide->light[i].emission = TY_INV_4PI * mean_of(medium->emission, 3, i);
        if (!(length > 1e-30f) || !(fluence > 1e-30f)) continue;
        guide->light[i].axis = ty_scale(flux, 1 / length);
        guide->light[i].mean_cosine = ty_minf(length / fluence, 0.95f);
    }
}

static ty_result allocate(ty_path_guide* guide) {
    guide->cells = count_cells(&guide->view.cells);
    guide->radiance = ty_alloc_array(guide->context, guide->cells, TY_GUIDE_BINS * sizeof(float), true);
    guide->light = ty_alloc_array(guide->context, guide->cells, sizeof *guide->light, true);
    guide->view.radiance = guide->radiance;
    guide->view.light = guide->light;
    return guide->radiance != NULL && guide->light != NULL ? TY_OK : TY_ERROR_MEMORY;
}

/* Roulette of paths where cells are thin enough for it. */
static void set_window(ty_path_guide* guide) {
    const float* per_metre = guide->view.cells.per_metre;
    const float edge = 1 / ty_maxf(per_metre[0], ty_maxf(per_metre[1], per_metre[2]));
    float thickest = 0;
    for (size_t i = 0; i < guide->cells; ++i) thickest = ty_maxf(thickest, guide->light[i].sigma_t * edge);
    guide->view.window = thickest <= max_thickness ? path_window : 0;
}

static void set_bins(ty_guide* view) {
    for (int32_t bin = 0; bin < TY_GUIDE_BINS; ++bin) {
        const ty_vec center = ty_octahedral_texel(TY_GUIDE_SIDE, bin);
        view->x[bin] = center.x;
        view->y[bin] = center.y;
        view->z[bin] = center.z;
    }
}

/* Solves, and follows rays through the light. */
static ty_result fill(const ty_scene* scene, const ty_grid_box* box, build* b) {
    ty_cell_light light;
    ty_grid_medium* medium = NULL;
    ty_result result = ty_dom_cell_light(scene, box, b->seed, &light);
    if (result != TY_OK) return result;
    result = ty_grid_medium_create(scene, box, &medium);
    if (result == TY_OK) {
        set_light(&light, medium, b->guide);
        set_window(b->guide);
        ty_parallel_for(b->guide->context, (int64_t)b->guide->cells, fill_bins, b);
    }
    ty_cell_light_free(&light);
    ty_grid_medium_destroy(medium);
    return result;
}

ty_result ty_path_guide_create(const ty_scene* scene, const ty_scene_view* view, uint64_t seed, ty_path_guide** out) {
    ty_context* context = ty_scene_context(scene);
    ty_grid_box box;
    ty_result result = ty_grid_box_fit(scene, TY_GUIDE_CELLS_MAX, &box);
    if (result != TY_OK) return result;
    ty_path_guide* guide = ty_alloc_array(context, 1, sizeof *guide, true);
    if (guide == NULL) return TY_ERROR_MEMORY;
    build b = {.scene = view, .guide = guide, .seed = seed};
    ty_sobol_matrices(&b.sobol);
    guide->context = context;
    set_cells(&box, &guide->view.cells);
    set_bins(&guide->view);
    guide->view.directions = directions;
    guide->view.fall = fall;
    guide->view.distances = distances;
    guide->view.light_window = light_window;
    result = allocate(guide);
    if (result == TY_OK) result = fill(scene, &box, &b);
    *out = guide;
    if (result == TY_OK) return TY_OK;
    ty_path_guide_destroy(guide);
    *out = NULL;
    return result;
}

void ty_path_guide_destroy(ty_path_guide* guide) {
    if (guide == NULL) return;
    ty_free_array(guide->context, guide->radiance, guide->cells, TY_GUIDE_BINS * sizeof(float));
    ty_free_array(guide->context, guide->light, guide->cells, sizeof *guide->light);
    ty_free_array(guide->context, guide, 1, sizeof *guide);
}
