/* Directions, the cells of uncollided light and of ordinates, the media on them, and how many bands they need. */
#include "base/context.h"
#include "method/dom/job.h"
#include "scene/scene.h"

#include <math.h>
#include <string.h>

/* Cells of ordinates where nothing is asked for: a third of those of uncollided light, so many at least and at most.
 * Where they are thicker than so many mean free paths they are finer, up to twice: what is within them is not known,
 * and light that leaves dense things leaves from the first mean free path. Media with edges are as
 * dense as they get where they begin: two mean free paths, up to three times, which is as fine as voxels. */
enum { SHARE = 3, LEAST_CELLS = 24, MOST_CELLS = 64, THICK = 4, MOST_TIMES = 2 };
enum { EDGED_CELLS = 96, EDGED_THICK = 2, EDGED_TIMES = 3 };

/* Cells of uncollided light for each voxel's side where media have edges, as long as these are no more along a side:
 * the latter where lights are many, each of which is followed through all cells. */
enum { EDGES = 2, MOST_EDGED = 256, MOST_EDGED_MANY = 192 };

static bool is_beam_or_lamp(int32_t kind) {
    return kind == TY_KIND_DIRECTIONAL || kind == TY_KIND_POINT || kind == TY_KIND_SPOT;
}

/* Whether a beam or lamp each is all of the scene's lights, and they are few. */
static bool has_few_lights(const ty_scene* scene) {
    const ty_light_set* lights = &ty_scene_get_view(scene)->lights;
    for (int32_t i = 0; i < lights->count; ++i)
        if (!is_beam_or_lamp(lights->lights[i].kind)) return false;
    return lights->count <= TY_DOM_OWN_MAX;
}

/* How much of an environment's light a cell of 1.4 degrees may bring at most where it is to be seen through a fit's
 * peak: a sun among it is too sharp for the map it is seen on. */
static const double most_in_cell = 0.02;

static bool is_soft(const ty_environment_view* environment) {
    double most = 0, sum = 0;
    if (environment->pixels == NULL) return true;
    for (int32_t i = 0; i < environment->cells_width * environment->cells_height; ++i) {
        const float* color = environment->cells[i].color;
        const double bright = (double)(color[0] + color[1] + color[2]);
        most = fmax(most, bright);
        sum += bright;
    }
    return most <= most_in_cell * sum;
}

/* Whether all light is few beams or lamps, and soft environments. */
static bool has_fitted_lights(const ty_scene* scene) {
    const ty_light_set* lights = &ty_scene_get_view(scene)->lights;
    int32_t own = 0;
    for (int32_t i = 0; i < lights->count; ++i) {
        const ty_light_view* light = &lights->lights[i];
        const bool environment = light->kind == TY_KIND_ENVIRONMENT;
        if (environment ? !is_soft(&light->environment) : !is_beam_or_lamp(light->kind)) return false;
        own += environment ? 0 : 1;
    }
    return own <= TY_DOM_OWN_MAX;
}

/* ---- bands ---- */

static double largest_g(const ty_grid_medium* medium) {
    double most = 0;
    for (int32_t p = 0; p < medium->planes; ++p)
        for (size_t i = 0; i < medium->cells; ++i) most = fmax(most, fabs((double)medium->g[p][i]));
    return most;
}

/* What of the light that scatters may be left to the peak that goes straight on, where directions are enough. */
static const double peak = 0.2;

/* Below this it need not be told from light that has not scattered. */
static const double least_peak = 0.02;

static int32_t choose_bands(const ty_dom_job* job, double g, int32_t exact) {
    const int32_t most = exact / 2 + 1 < TY_DOM_BANDS_MAX ? exact / 2 + 1 : TY_DOM_BANDS_MAX;
    if (job->def->bands > 0) return job->def->bands;
    if (!(g > 0)) return 1;
    return (int32_t)fmin(most, fmax(2, ceil(log(peak) / log(g))));
}

/* Relative difference up to which mean cosines are the same: they are means of many. */
static const double alike = 1e-4;

static bool is_all(const ty_grid_medium* medium, double g) {
    for (int32_t p = 0; p < medium->planes; ++p)
        for (size_t i = 0; i < medium->cells; ++i)
            if (medium->scattering[p][i] > 0 && fabs((double)medium->g[p][i] / g - 1) > alike) return false;
    return true;
}

/* Where the bands are not enough: what is done about area lights, surfaces and media that glow is for phase functions
 * that are cut. */
static bool is_fitted(const ty_dom_job* job, double g) {
    return pow(g, job->light->bands) > peak + alike && job->coarse->emission[0] == NULL &&
           ty_scene_get_view(job->scene)->mesh == NULL && has_fitted_lights(job->scene) && is_all(job->fine, g) &&
           is_all(job->coarse, g);
}

/* Moments of a fit fall off to next to nothing, so that directions bear more than of cut ones: as many as they are. */
static void fit_bands(ty_dom_job* job, double g) {
    ty_dom* light = job->light;
    if (!is_fitted(job, g)) return;
    const int32_t borne = (int32_t)lround(sqrt(job->set->count));
    const int32_t bands = job->def->bands > 0 ? job->def->bands : borne < TY_DOM_BANDS_MAX ? borne : TY_DOM_BANDS_MAX;
    if (bands < TY_DOM_LEAST_FITTED) return;
    light->bands = bands;
    ty_dom_fit_peak(g, bands, &light->fit);
}

/* Bands of moments that are kept for the eye, which phase functions tell apart as far as g^l is worth it; two for
 * surfaces. */
enum { LEAST_KEPT = 2 };

static void choose_all_bands(ty_dom_job* job, int32_t exact) {
    ty_dom* light = job->light;
    const double g = largest_g(job->coarse);
    light->even = !(g > 0);
    light->bands = choose_bands(job, g, exact);
    fit_bands(job, g);
    light->lobes = pow(g, light->bands) > least_peak;
    light->kept = light->bands < LEAST_KEPT ? LEAST_KEPT : light->bands;
    job->stats.bands = light->bands;
    job->stats.directions = job->set->count;
}

/* ---- cells ---- */

static int32_t longest_side(const int32_t size[3]) {
    const int32_t most = size[0] > size[1] ? size[0] : size[1];
    return most > size[2] ? most : size[2];
}

/* Extinction where light scatters, in the mean of all that does, 1/m. */
static double mean_extinction(const ty_grid_medium* medium) {
    double sums[2] = {0, 0};
    for (int32_t p = 0; p < medium->planes; ++p)
        for (size_t i = 0; i < medium->cells; ++i) {
            sums[0] += (double)medium->scattering[p][i];
            sums[1] += (double)medium->scattering[p][i] * (double)medium->extinction[p][i];
        }
    return sums[0] > 0 ? sums[1] / sums[0] : 0;
}

/* times: cells of uncollided light for each that there would be without edges. */
static int32_t choose_cells(const ty_dom_def* def, const ty_grid_medium* fine, int32_t times) {
    const ty_grid_box* box = &fine->box;
    if (def->resolution > 0) return def->resolution;
    int32_t cells = longest_side(box->size) / (SHARE * times);
    double longest = 0;
    for (int a = 0; a < 3; ++a) longest = fmax(longest, box->upper[a] - box->lower[a]);
    const double thickness = mean_extinction(fine) * longest / fmax(cells, LEAST_CELLS);
    const bool edged = times > 1;
    const int32_t most = edged ? EDGED_CELLS : MOST_CELLS;
    cells =
        (int32_t)(cells * fmin(edged ? EDGED_TIMES : MOST_TIMES, fmax(1, thickness / (edged ? EDGED_THICK : THICK))));
    return cells < LEAST_CELLS ? LEAST_CELLS : cells > most ? most : cells;
}

/* Whether transfer functions make densities of values, whose edges are sharper than voxels. */
static bool has_edges(const ty_scene* scene) {
    const ty_scene_view* view = ty_scene_get_view(scene);
    for (int32_t m = 0; m < view->medium_count; ++m)
        if (view->media[m].transfer != NULL) return true;
    return false;
}

/* How many cells of uncollided light there are for each of a box. */
static int32_t find_times(const ty_dom_job* job, const int32_t size[3]) {
    const int32_t most = has_few_lights(job->scene) ? MOST_EDGED : MOST_EDGED_MANY;
    const bool finer = job->def->direct == 0 && EDGES * longest_side(size) <= most && has_edges(job->scene);
    return finer ? EDGES : 1;
}

static ty_result sample(ty_dom_job* job) {
    const ty_dom_def* def = job->def;
    int32_t longest = ty_grid_box_longest(job->scene, def->direct), size[3];
    ty_grid_box box;
    if (def->direct == 0 && longest < def->resolution) longest = def->resolution;
    ty_result result = ty_grid_box_fit(job->scene, longest, &box);
    if (result != TY_OK) return result;
    const int32_t times = find_times(job, box.size);
    for (int a = 0; a < 3; ++a) box.size[a] *= times;
    result = ty_grid_medium_create(job->scene, &box, &job->fine);
    if (result != TY_OK) return result;
    ty_grid_box_cut(&box, choose_cells(def, job->fine, times), size);
    return ty_grid_medium_resize(job->fine, size, &job->coarse);
}

static ty_result keep_medium(ty_dom_job* job) {
    ty_dom* light = job->light;
    const ty_grid_medium* coarse = job->coarse;
    light->fine_box = job->fine->box;
    light->box = coarse->box;
    light->cells = coarse->cells;
    light->planes = coarse->planes;
    for (int32_t p = 0; p < light->planes; ++p) {
        light->g[p] = ty_alloc_array(job->context, light->cells, sizeof(float), false);
        if (light->g[p] == NULL) return TY_ERROR_MEMORY;
        memcpy(light->g[p], coarse->g[p], light->cells * sizeof(float));
    }
    memcpy(job->stats.direct_size, job->fine->box.size, sizeof job->stats.direct_size);
    memcpy(job->stats.size, coarse->box.size, sizeof job->stats.size);
    return TY_OK;
}

static ty_result make_set(const ty_dom_job* job, int32_t count, ty_angular_quadrature** set, int32_t* exact) {
    *set = ty_alloc_array(job->context, 1, sizeof **set, true);
    return *set != NULL ? ty_angular_quadrature_create(job->context, count, *set, exact) : TY_ERROR_MEMORY;
}

ty_result ty_dom_sample_media(ty_dom_job* job) {
    int32_t exact = 0;
    ty_result result = make_set(job, job->def->directions, &job->set, &exact);
    if (result == TY_OK && job->def->last_directions > 0)
        result = make_set(job, job->def->last_directions, &job->last, NULL);
    if (result == TY_OK) result = sample(job);
    if (result == TY_OK) result = keep_medium(job);
    if (result == TY_OK) choose_all_bands(job, exact);
    return result;
}
