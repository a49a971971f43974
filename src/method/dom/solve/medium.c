/* Directions, fine and coarse cells with their media, and the number of Legendre bands. */
#include "base/context.h"
#include "base/mapping.h"
#include "method/dom/solve/solve.h"
#include "scene/scene.h"

#include <math.h>
#include <string.h>

/* Default resolution of ordinates: a third of that of uncollided light, within MIN_CELLS and MAX_CELLS. Cells thicker
 * than MAX_THICKNESS mean free paths are refined, up to MAX_REFINEMENT times: light that leaves dense media comes from
 * their first mean free path. Media with edges have their full density at the edge, so their limits are finer, down to
 * the voxels. */
enum { FINE_PER_CELL = 3, MIN_CELLS = 24, MAX_CELLS = 64, MAX_THICKNESS = 4, MAX_REFINEMENT = 2 };
enum { MAX_EDGED_CELLS = 96, MAX_EDGED_THICKNESS = 2, MAX_EDGED_REFINEMENT = 3 };

/* Fine cells per voxel side for media with edges, and the maximum side up to which this is affordable: the smaller one
 * with many lights, each of which is swept through all cells. */
enum { EDGE_REFINEMENT = 2, MAX_FINE_FEW_LIGHTS = 256, MAX_FINE_MANY_LIGHTS = 192 };

static bool is_directional_or_point(int32_t kind) {
    return kind == TY_KIND_DIRECTIONAL || kind == TY_KIND_POINT || kind == TY_KIND_SPOT;
}

/* True if all lights are directional, point or spot lights, and few enough for dedicated fields. */
static bool has_few_lights(const ty_scene* scene) {
    const ty_light_set* lights = &ty_scene_get_view(scene)->lights;
    for (int32_t i = 0; i < lights->count; ++i)
        if (!is_directional_or_point(lights->lights[i].kind)) return false;
    return lights->count <= TY_DOM_DEDICATED_MAX;
}

/* Maximum fraction of an environment's light in one cell of 1.4 degrees that may be seen through a fit's peak: a sun is
 * too sharp for the map that it is seen on. */
static const double max_cell_fraction = 0.02;

static bool is_soft(const ty_environment_view* environment) {
    double max = 0, sum = 0;
    if (environment->pixels == NULL) return true;
    for (int32_t i = 0; i < environment->cells_width * environment->cells_height; ++i) {
        const float* color = environment->cells[i].color;
        const double luminous = (double)(color[0] + color[1] + color[2]);
        max = fmax(max, luminous);
        sum += luminous;
    }
    return max <= max_cell_fraction * sum;
}

/* True if all lights are soft environments. */
static bool has_even_light(const ty_scene* scene) {
    const ty_light_set* lights = &ty_scene_get_view(scene)->lights;
    for (int32_t i = 0; i < lights->count; ++i)
        if (lights->lights[i].kind != TY_KIND_ENVIRONMENT || !is_soft(&lights->lights[i].environment)) return false;
    return true;
}

/* True if all lights are soft environments and few directional, point or spot lights. */
static bool has_fitted_lights(const ty_scene* scene) {
    const ty_light_set* lights = &ty_scene_get_view(scene)->lights;
    int32_t dedicated = 0;
    for (int32_t i = 0; i < lights->count; ++i) {
        const ty_light_view* light = &lights->lights[i];
        const bool environment = light->kind == TY_KIND_ENVIRONMENT;
        if (environment ? !is_soft(&light->environment) : !is_directional_or_point(light->kind)) return false;
        dedicated += environment ? 0 : 1;
    }
    return dedicated <= TY_DOM_DEDICATED_MAX;
}

/* ---- bands ---- */

static double largest_g(const ty_grid_medium* medium) {
    double max = 0;
    for (int32_t p = 0; p < medium->planes; ++p)
        for (size_t i = 0; i < medium->cells; ++i) max = fmax(max, fabs((double)medium->g[p][i]));
    return max;
}

/* Maximum forward fraction g^L of scattering that delta-M may count as unscattered, where the directions suffice. */
static const double max_peak = 0.2;

/* Minimum forward fraction for which unscattered light and the lobe are told apart. */
static const double min_lobe_peak = 0.02;

static int32_t choose_bands(const ty_dom_def* def, double g, int32_t exact) {
    const int32_t max = exact / 2 + 1 < TY_DOM_BANDS_MAX ? exact / 2 + 1 : TY_DOM_BANDS_MAX;
    if (def->bands > 0) return def->bands;
    if (!(g > 0)) return 1;
    return (int32_t)fmin(max, fmax(2, ceil(log(max_peak) / log(g))));
}

/* The same for moments: at least as many bands as Rayleigh scattering has. */
enum { MIN_LEGENDRE_BANDS = 3 };

static int32_t choose_legendre_bands(const ty_dom_job* job, const float* legendre, int32_t exact) {
    const int32_t max = exact / 2 + 1 < TY_DOM_BANDS_MAX ? exact / 2 + 1 : TY_DOM_BANDS_MAX;
    int32_t bands = MIN_LEGENDRE_BANDS;
    if (job->def->bands > 0) return job->def->bands;
    while (bands < max && (double)fabsf(legendre[bands]) > max_peak) ++bands;
    return bands < max ? bands : max;
}

/* Relative tolerance for equal mean cosines, which are means over many samples. */
static const double g_tolerance = 1e-4;

static bool is_uniform_g(const ty_grid_medium* medium, double g) {
    for (int32_t p = 0; p < medium->planes; ++p)
        for (size_t i = 0; i < medium->cells; ++i)
            if (medium->scattering[p][i] > 0 && fabs((double)medium->g[p][i] / g - 1) > g_tolerance) return false;
    return true;
}

/* True if a fit may replace delta-M: too few bands, and neither area lights, surfaces nor emission, whose treatment
 * assumes delta-M. */
static bool may_fit(const ty_dom_job* job, double g) {
    return pow(g, job->light->bands) > max_peak + g_tolerance && job->coarse->emission[0] == NULL &&
           ty_scene_get_view(job->scene)->mesh == NULL && has_fitted_lights(job->scene) && is_uniform_g(job->fine, g) &&
           is_uniform_g(job->coarse, g);
}

/* Moments of a fit fall off to nearly nothing, so that the directions support more of them than of a truncated
 * function: the square root of their number. */
static void fit_bands(ty_dom_job* job, double g) {
    ty_dom* light = job->light;
    if (!may_fit(job, g)) return;
    const int32_t supported = (int32_t)lround(sqrt(job->set->count));
    const int32_t bands = job->def->bands > 0            ? job->def->bands
                          : supported < TY_DOM_BANDS_MAX ? supported
                                                         : TY_DOM_BANDS_MAX;
    if (bands < TY_DOM_MIN_FITTED_BANDS) return;
    light->bands = bands;
    ty_dom_fit_phase(g, bands, &light->fit);
}

/* Minimum number of bands that are kept for the eye; surfaces need two. */
enum { MIN_OUTPUT_BANDS = 2 };

/* Minimum thickness of diffusive cells, mean free paths; the larger one for media with edges, whose cells are full in
 * part. */
static const double diffusive_paths = 2, diffusive_paths_edged = TY_DIFFUSIVE_FREE_PATHS;

static bool has_voxels(const ty_scene* scene) {
    const ty_scene_view* view = ty_scene_get_view(scene);
    for (int32_t m = 0; m < view->medium_count; ++m)
        if (view->media[m].has_grid != 0) return true;
    return false;
}

/* True if media are even within cells, as the moment that stands for the position of a source takes them. Voxels vary
 * there, and a source that is displaced as if they did not loses light. */
static bool has_even_cells(const ty_dom_job* job) {
    return job->diffusive_paths <= diffusive_paths && !has_voxels(job->scene);
}

/* True if some cells are thick and yet swept. */
static bool has_thick_swept_cells(const ty_dom_job* job) {
    if (!has_even_cells(job)) return false;
    for (int32_t p = 0; p < job->coarse->planes; ++p)
        for (size_t i = 0; i < job->coarse->cells; ++i) {
            const double paths = ty_dom_cell_thickness(job, p, i);
            if (paths > TY_DOM_DISPLACED_PATHS && paths <= job->diffusive_paths) return true;
        }
    return false;
}

static void choose_all_bands(ty_dom_job* job, int32_t exact) {
    ty_dom* light = job->light;
    const double g = largest_g(job->coarse);
    const float* legendre = ty_dom_legendre(light);
    light->isotropic = !(g > 0) && legendre == NULL;
    light->bands = legendre != NULL ? choose_legendre_bands(job, legendre, exact) : choose_bands(job->def, g, exact);
    if (light->bands == 1 && job->def->bands == TY_AUTO && has_thick_swept_cells(job)) light->bands = 2;
    if (legendre == NULL) fit_bands(job, g);
    job->tells_positions = light->bands > 1 && has_even_cells(job);
    const double peak = legendre != NULL ? (double)legendre[light->bands] : pow(g, light->bands);
    light->has_lobes = peak > min_lobe_peak;
    job->is_narrow = peak > max_peak + g_tolerance;
    for (int32_t l = 0; l < light->bands && legendre != NULL; ++l)
        light->scattered[l] = legendre[l] - ty_grid_medium_forward(job->fine, light->bands);
    light->output_bands = light->bands < MIN_OUTPUT_BANDS ? MIN_OUTPUT_BANDS : light->bands;
    job->stats.bands = light->bands;
    job->stats.directions = job->set->count;
}

/* ---- cells ---- */

static int32_t longest_side(const int32_t size[3]) {
    const int32_t max = size[0] > size[1] ? size[0] : size[1];
    return max > size[2] ? max : size[2];
}

/* Scattering-weighted mean of the extinction, or of (1 - g) sigma_s, 1/m. */
static double mean_extinction(const ty_grid_medium* medium, bool of_transport) {
    double sums[2] = {0, 0};
    for (int32_t p = 0; p < medium->planes; ++p)
        for (size_t i = 0; i < medium->cells; ++i) {
            const double scattering = (double)medium->scattering[p][i];
            sums[0] += scattering;
            sums[1] += scattering * (of_transport ? (1 - fmax(0, (double)medium->g[p][i])) * scattering
                                                  : (double)medium->extinction[p][i]);
        }
    return sums[0] > 0 ? sums[1] / sums[0] : 0;
}

/* refinement: fine cells per side, relative to media without edges. Of few voxels there are more cells than a third
 * where light diffuses and they would be thicker than MAX_THICKNESS by (1 - g) sigma_s. */
static int32_t choose_cells(const ty_dom_def* def, const ty_grid_medium* fine, int32_t refinement, bool has_voxels) {
    const ty_grid_box* box = &fine->box;
    if (def->resolution > 0) return def->resolution;
    int32_t cells = longest_side(box->size) / (FINE_PER_CELL * refinement);
    double longest = 0;
    for (int a = 0; a < 3; ++a) longest = fmax(longest, box->upper[a] - box->lower[a]);
    const double thickness = mean_extinction(fine, false) * longest / fmax(cells, MIN_CELLS);
    const bool edged = refinement > 1;
    const int32_t max = edged ? MAX_EDGED_CELLS : MAX_CELLS;
    cells = (int32_t)(cells * fmin(edged ? MAX_EDGED_REFINEMENT : MAX_REFINEMENT,
                                   fmax(1, thickness / (edged ? MAX_EDGED_THICKNESS : MAX_THICKNESS))));
    int32_t min = MIN_CELLS;
    if (has_voxels && !edged && cells < MIN_CELLS * MAX_REFINEMENT)
        min = (int32_t)(MIN_CELLS * fmin(MAX_REFINEMENT,
                                         fmax(1, mean_extinction(fine, true) * longest / (MIN_CELLS * MAX_THICKNESS))));
    return cells < min ? min : cells > max ? max : cells;
}

/* True if a transfer function maps values to density, with edges sharper than voxels. */
static bool has_edges(const ty_scene* scene) {
    const ty_scene_view* view = ty_scene_get_view(scene);
    for (int32_t m = 0; m < view->medium_count; ++m)
        if (view->media[m].transfer != NULL) return true;
    return false;
}

/* True if point or spot lights shine on voxels. */
static bool has_points_over_voxels(const ty_scene* scene) {
    const ty_scene_view* view = ty_scene_get_view(scene);
    bool points = false;
    for (int32_t i = 0; i < view->lights.count; ++i)
        points = points || ty_light_is_point_or_spot(view->lights.lights[i].kind);
    return points && has_voxels(scene);
}

/* Parts of a voxel's side, so that fine cells are at most MAX_FINE_THICKNESS mean free paths thick: in thicker ones,
 * the light of points that cells scatter does not add up to what reaches them, because it is found from the optical
 * depths of their centers. At most MAX_THICK_REFINEMENT, and MAX_FINE_THICK cells along the longest side. */
enum { MAX_THICK_REFINEMENT = 4, MAX_FINE_THICK = 128 };
static const double MAX_FINE_THICKNESS = 1.5;

static int32_t find_thick_refinement(const ty_dom_job* job) {
    const ty_grid_medium* fine = job->fine;
    if (job->def->direct != TY_AUTO || !has_few_lights(job->scene) || !has_points_over_voxels(job->scene)) return 1;
    const double thickness = mean_extinction(fine, false) * fmax(fine->cell[0], fmax(fine->cell[1], fine->cell[2]));
    const int32_t max = MAX_FINE_THICK / longest_side(fine->box.size);
    return (int32_t)fmax(
        1, fmin(ceil(thickness / MAX_FINE_THICKNESS), max < MAX_THICK_REFINEMENT ? max : MAX_THICK_REFINEMENT));
}

/* Fine cells per cell of a box without refinement. */
static int32_t find_refinement(const ty_dom_job* job, const int32_t size[3]) {
    const int32_t max = has_few_lights(job->scene) ? MAX_FINE_FEW_LIGHTS : MAX_FINE_MANY_LIGHTS;
    const bool finer =
        job->def->direct == TY_AUTO && EDGE_REFINEMENT * longest_side(size) <= max && has_edges(job->scene);
    return finer ? EDGE_REFINEMENT : 1;
}

/* Samples the media on finer cells where they are thick. */
static ty_result refine_thick(ty_dom_job* job, ty_grid_box* box) {
    const int32_t refinement = find_thick_refinement(job);
    if (refinement == 1) return TY_OK;
    for (int a = 0; a < 3; ++a) box->size[a] *= refinement;
    ty_grid_medium_destroy(job->fine);
    job->fine = NULL;
    return ty_grid_medium_create(job->scene, box, &job->fine);
}

static ty_result sample(ty_dom_job* job) {
    const ty_dom_def* def = job->def;
    int32_t longest = ty_grid_box_longest(job->scene, def->direct), size[3];
    ty_grid_box box;
    if (def->direct == TY_AUTO && longest < def->resolution) longest = def->resolution;
    ty_result result = ty_grid_box_fit(job->scene, longest, &box);
    if (result != TY_OK) return result;
    const int32_t refinement = find_refinement(job, box.size);
    for (int a = 0; a < 3; ++a) box.size[a] *= refinement;
    result = ty_grid_medium_create(job->scene, &box, &job->fine);
    if (result != TY_OK) return result;
    ty_grid_box_cut(&box, choose_cells(def, job->fine, refinement, has_voxels(job->scene)), size);
    result = refine_thick(job, &box);
    if (result != TY_OK) return result;
    return ty_grid_medium_resize(job->fine, size, &job->coarse);
}

static ty_result keep_medium(ty_dom_job* job) {
    ty_dom* light = job->light;
    const ty_grid_medium* coarse = job->coarse;
    light->fine_box = job->fine->box;
    light->box = coarse->box;
    light->cells = coarse->cells;
    light->planes = coarse->planes;
    memcpy(light->legendre, coarse->legendre, sizeof light->legendre);
    for (int32_t p = 0; p < light->planes; ++p) {
        light->g[p] = ty_alloc_large(job->context, light->cells, sizeof(float), false);
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
    job->even_light = has_even_light(job->scene);
    const bool swept = job->def->differentiable || ty_scene_get_view(job->scene)->periodic.axes != 0;
    job->diffusive_paths = swept ? (double)INFINITY : has_edges(job->scene) ? diffusive_paths_edged : diffusive_paths;
    ty_result result = make_set(job, job->def->directions, &job->set, &exact);
    if (result == TY_OK && job->def->last_directions > 0)
        result = make_set(job, job->def->last_directions, &job->last_set, NULL);
    if (result == TY_OK) result = sample(job);
    if (result == TY_OK) result = keep_medium(job);
    if (result == TY_OK) choose_all_bands(job, exact);
    return result;
}

/* ---- plans ---- */

/* Largest mean cosine of any medium. */
static ty_result find_largest_g(const ty_scene* scene, double* max) {
    const int32_t media = ty_scene_get_info(scene).media;
    ty_result result = TY_OK;
    *max = 0;
    for (int32_t i = 0; i < media && result == TY_OK; ++i) {
        ty_medium_def medium;
        float g[3];
        result = ty_scene_get_medium(scene, i, &medium);
        if (result == TY_OK) result = ty_medium_mean_cosine(ty_scene_context(scene), &medium, g);
        for (int c = 0; c < 3 && result == TY_OK; ++c) *max = fmax(*max, fabs((double)g[c]));
    }
    return result;
}

ty_result ty_dom_plan(const ty_scene* scene, const ty_dom_def* def, ty_angular_quadrature* set, ty_ordinates_def* out) {
    ty_grid_box box;
    int32_t exact = 0;
    double g = 0;
    *out = ty_default_ordinates_def();
    ty_result result = ty_angular_quadrature_create(ty_scene_context(scene), def->directions, set, &exact);
    if (result == TY_OK) result = find_largest_g(scene, &g);
    if (result == TY_OK) result = ty_grid_box_fit(scene, ty_grid_box_longest(scene, TY_AUTO), &box);
    if (result != TY_OK) return result;
    ty_grid_box_cut(&box, def->resolution > 0 ? def->resolution : MAX_CELLS, out->size);
    for (int a = 0; a < 3; ++a) out->cell[a] = (box.upper[a] - box.lower[a]) / out->size[a];
    out->set = set;
    out->bands = choose_bands(def, g, exact);
    out->output_order = out->bands < MIN_OUTPUT_BANDS ? MIN_OUTPUT_BANDS : out->bands;
    out->source_terms = out->bands * out->bands;
    out->accelerated = def->acceleration == TY_DOM_ACCELERATION_DIFFUSION;
    return TY_OK;
}
