/* tyndall bake: computing one unit, from receivers to images. */
#include "cli/bake/bake.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- Progress ---- */

bool bake_report_progress(void* user, const ty_progress* progress) {
    bake_run* run = user;
    const bake_plan* plan = &run->plan;
    double current = 0;
    for (int32_t i = 0; i < plan->count; ++i)
        if (!plan->units[i].done) {
            current = (double)plan->units[i].receivers;
            break;
        }
    const double total = fmax((double)plan->receivers, 1), done = run->receivers_done + progress->fraction * current;
    const double own_done = done - run->receivers_skipped, seconds = cli_wall_seconds() - run->started;
    const ty_progress all = {.stage = "bake",
                             .fraction = fmin(done / total, 1),
                             .seconds = seconds,
                             .remaining = own_done > 0 ? seconds * fmax(total - done, 0) / own_done : -1};
    return cli_progress_report(&run->session->progress, &all);
}

/* ---- Images ---- */

static ty_result set_metadata(const bake_run* run, const bake_unit* unit, ty_image* image) {
    const bool surface = unit->kind == BAKE_LIGHTMAP || unit->kind == BAKE_VERTICES;
    const struct {
        const char *key, *value;
    } texts[] = {
        {"tyndall.version", ty_version()},
        {"tyndall.method", bake_method_names[run->options->method]},
        {"tyndall.bake.quantity", surface ? "irradiance" : "radiance"},
        {"tyndall.bake.unit", surface ? "W m^-2" : "W m^-2 sr^-1"},
        {"tyndall.bake.of", unit->name},
    };
    ty_result result = TY_OK;
    for (size_t i = 0; i < sizeof texts / sizeof *texts && result == TY_OK; ++i)
        result = ty_image_set_text(image, texts[i].key, texts[i].value);
    return result;
}

/* The exposure in stops that maps the mean of the lit texels to medium gray. */
static double preview_exposure(const ty_image* image) {
    const float* planes[3];
    double sum = 0, lit = 0;
    if (!ty_image_rgb_planes(image, planes)) return 0;
    const size_t count = (size_t)ty_image_width(image) * (size_t)ty_image_height(image);
    for (size_t i = 0; i < count; ++i) {
        const double value = (double)(planes[0][i] + planes[1][i] + planes[2][i]) / 3;
        if (!(value > 0)) continue;
        sum += value;
        lit += 1;
    }
    return sum > 0 ? fmin(fmax(log2(0.4 * lit / sum), -64), 64) : 0;
}

static ty_result write_image(const bake_run* run, const bake_unit* unit, int32_t primitive, bool denoised,
                             ty_image* image) {
    char path[BAKE_PATH_SIZE];
    ty_context* context = run->session->context;
    bake_image_path(run, unit, primitive, denoised ? BAKE_DENOISED ".exr" : ".exr", path);
    ty_result result = set_metadata(run, unit, image);
    if (result == TY_OK) result = ty_image_write_exr(context, image, path);
    if (result != TY_OK || unit->kind == BAKE_VERTICES) return result;
    bake_image_path(run, unit, primitive, denoised ? BAKE_DENOISED ".png" : ".png", path);
    return ty_image_write_png(context, image, preview_exposure(image), TY_TONE_FILMIC, path);
}

/* ---- Surfaces ---- */

/* True for a part of a bake, which makes no images. */
static bool is_part(const bake_run* run) {
    return run->parts.part > 0;
}

static void count_stats(bake_unit* unit, const ty_bake_stats* stats, double receivers) {
    unit->mean_samples += stats->mean_samples * receivers;
    unit->paths += stats->paths;
    unit->rays += stats->rays;
}

/* Irradiance at the receivers of a mesh; the caller frees it. The random sequence depends on the mesh alone, so that
 * results do not depend on the other meshes of a bake. */
static ty_result gather(const bake_run* run, bake_unit* unit, int32_t mesh, ty_bake_def def,
                        const ty_bake_receiver* receivers, int64_t count, ty_bake_light* light) {
    ty_bake_stats stats = ty_default_bake_stats();
    def.seed += 0x9e3779b97f4a7c15u * ((uint64_t)mesh + 1);
    const ty_result result = bake_light_surfaces(run, &def, receivers, count, light, &stats);
    count_stats(unit, &stats, (double)count);
    return result;
}

/* The image of the light at an atlas. */
static ty_result bake_plain(const bake_run* run, bake_unit* unit, int32_t mesh, const ty_atlas* atlas, ty_image** out) {
    int64_t count = 0;
    const ty_bake_receiver* targets = ty_atlas_receivers(atlas, &count);
    ty_bake_light* light = calloc((size_t)count + 1, sizeof *light);
    ty_result result = light == NULL ? TY_ERROR_MEMORY : gather(run, unit, mesh, run->def, targets, count, light);
    if (result == TY_OK && !is_part(run)) result = ty_atlas_create_image(atlas, light, out);
    free(light);
    return result;
}

/* The same, from two halves, and that of the light without noise. */
static ty_result bake_denoised(const bake_run* run, bake_unit* unit, int32_t mesh, const ty_atlas* atlas,
                               ty_image** out, ty_image** denoised) {
    int64_t count = 0;
    const ty_bake_receiver* targets = ty_atlas_receivers(atlas, &count);
    const size_t places = (size_t)count + 1;
    ty_bake_light* light = calloc(3 * places, sizeof *light);
    ty_bake_light *even = light, *odd = light + places, *result_light = light + 2 * places;
    ty_result result = light == NULL ? TY_ERROR_MEMORY : TY_OK;
    for (int half = 0; half < 2 && result == TY_OK; ++half)
        result = gather(run, unit, mesh, bake_half_def(&run->def, half), targets, count, half == 0 ? even : odd);
    if (result == TY_OK && !is_part(run)) {
        bake_join_halves(even, odd, count, result_light);
        result = ty_atlas_create_image(atlas, result_light, out);
        if (result == TY_OK) result = ty_atlas_denoise(atlas, even, odd, result_light);
        if (result == TY_OK) result = ty_atlas_create_image(atlas, result_light, denoised);
    }
    free(light);
    return result;
}

/* denoised: NULL if it is not asked for. */
static ty_result bake_map(const bake_run* run, bake_unit* unit, int32_t mesh, int64_t* receivers, ty_image** out,
                          ty_image** denoised) {
    ty_atlas_def def = ty_default_atlas_def();
    ty_mesh_def described;
    ty_atlas* atlas = NULL;
    def.width = unit->size[0];
    def.height = unit->size[1];
    def.padding = run->options->padding;
    ty_result result = ty_scene_get_mesh(run->scene, mesh, &described);
    if (result == TY_OK) result = ty_atlas_create(run->scene, mesh, bake_mesh_name(&described), &def, &atlas);
    if (result != TY_OK) return result;
    int64_t count = 0;
    ty_atlas_receivers(atlas, &count);
    result = denoised != NULL ? bake_denoised(run, unit, mesh, atlas, out, denoised)
                              : bake_plain(run, unit, mesh, atlas, out);
    ty_atlas_destroy(atlas);
    *receivers += count;
    return result;
}

static ty_result write_maps(const bake_run* run, bake_unit* unit, bool denoised, ty_image* const* images) {
    ty_result result = bake_merge(images, unit->count, &unit->overlapping);
    for (int32_t i = 0; i < (unit->overlapping ? unit->count : 1) && result == TY_OK; ++i)
        result = write_image(run, unit, unit->overlapping ? i : -1, denoised, images[i]);
    return result;
}

static ty_result bake_lightmap(const bake_run* run, bake_unit* unit) {
    int64_t receivers = 0;
    const bool denoise = run->options->denoise;
    ty_image** images = calloc(2 * (size_t)unit->count, sizeof(ty_image*)); /* and then the denoised ones */
    ty_result result = images == NULL ? TY_ERROR_MEMORY : TY_OK;
    for (int32_t i = 0; i < unit->count && result == TY_OK; ++i)
        result =
            bake_map(run, unit, unit->first + i, &receivers, &images[i], denoise ? &images[unit->count + i] : NULL);
    if (result == TY_OK && denoise && !is_part(run)) result = write_maps(run, unit, true, images + unit->count);
    if (result == TY_OK && !is_part(run)) result = write_maps(run, unit, false, images);
    for (int32_t i = 0; images != NULL && i < 2 * unit->count; ++i) ty_image_destroy(images[i]);
    free(images);
    unit->mean_samples /= fmax((double)receivers, 1);
    return result;
}

/* Vertex bakes: the vertices of all primitives, concatenated. */
static ty_result gather_vertices(const bake_run* run, bake_unit* unit, ty_bake_receiver* receivers,
                                 ty_bake_light* light) {
    ty_result result = TY_OK;
    int64_t at = 0;
    for (int32_t mesh = unit->first; mesh < unit->first + unit->count && result == TY_OK; ++mesh) {
        ty_mesh_def def;
        result = ty_scene_get_mesh(run->scene, mesh, &def);
        if (result == TY_OK) result = ty_bake_vertices(run->scene, mesh, receivers);
        if (result == TY_OK) result = gather(run, unit, mesh, run->def, receivers, def.vertex_count, light + at);
        at += def.vertex_count;
    }
    unit->mean_samples /= fmax((double)at, 1);
    return result;
}

static ty_result bake_vertices(const bake_run* run, bake_unit* unit) {
    ty_image* image = NULL;
    ty_bake_receiver* receivers = calloc((size_t)unit->receivers, sizeof *receivers);
    ty_bake_light* light = calloc((size_t)unit->receivers, sizeof *light);
    ty_result result = receivers == NULL || light == NULL ? TY_ERROR_MEMORY : TY_OK;
    if (result == TY_OK) result = gather_vertices(run, unit, receivers, light);
    if (result == TY_OK && !is_part(run))
        result = ty_bake_create_light_image(run->session->context, light, unit->receivers, unit->size[0], &image);
    free(receivers);
    free(light);
    if (result == TY_OK && image != NULL) result = write_image(run, unit, -1, false, image);
    ty_image_destroy(image);
    return result;
}

/* ---- Probes ---- */

float* bake_grid_points(const bake_grid* grid) {
    const size_t across = (size_t)grid->size[0], rows = (size_t)grid->size[1], slices = (size_t)grid->size[2];
    float* points = calloc(across * rows * slices, 3 * sizeof *points);
    for (size_t i = 0; points != NULL && i < across * rows * slices; ++i) {
        const size_t place[3] = {i % across, i / across % rows, i / (across * rows)};
        for (int a = 0; a < 3; ++a)
            points[3 * i + (size_t)a] = (float)(grid->origin[a] + grid->spacing[a] * (double)place[a]);
    }
    return points;
}

static ty_result write_grid(const bake_run* run, const bake_unit* unit, const ty_bake_probe* probes) {
    ty_image* image = NULL;
    ty_result result = ty_bake_create_probe_image(run->session->context, probes, run->plan.grid.size,
                                                  run->options->sh * run->options->sh, &image);
    if (result == TY_OK) result = write_image(run, unit, -1, false, image);
    ty_image_destroy(image);
    return result;
}

static ty_result bake_points(bake_run* run, bake_unit* unit) {
    const bool grid = unit->kind == BAKE_GRID;
    float* made = grid ? bake_grid_points(&run->plan.grid) : NULL;
    const float* points = grid ? made : run->plan.probes;
    ty_bake_probe* probes = calloc((size_t)unit->receivers, sizeof *probes);
    ty_bake_stats stats = ty_default_bake_stats();
    ty_result result = points == NULL || probes == NULL ? TY_ERROR_MEMORY : TY_OK;
    if (result == TY_OK) result = bake_light_points(run, points, unit->receivers, probes, &stats);
    count_stats(unit, &stats, 1);
    if (result == TY_OK && !is_part(run))
        result = grid ? write_grid(run, unit, probes) : bake_write_probes(run, probes);
    free(probes);
    free(made);
    return result;
}

ty_result bake_unit_run(bake_run* run, bake_unit* unit) {
    const double started = cli_wall_seconds();
    ty_result result = TY_OK;
    switch (unit->kind) {
    case BAKE_LIGHTMAP: result = bake_lightmap(run, unit); break;
    case BAKE_VERTICES: result = bake_vertices(run, unit); break;
    case BAKE_GRID:
    case BAKE_PROBES: result = bake_points(run, unit); break;
    }
    unit->seconds = cli_wall_seconds() - started;
    return result;
}
