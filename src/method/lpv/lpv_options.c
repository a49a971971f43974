/* Options of light propagation volumes, and checks of shadow maps. */
#include "base/context.h"
#include "image/march/march.h"
#include "method/lpv/job.h"
#include "scene/lights/light.h"

static const char* const modes[] = {"links", "published", NULL};
static const char* const places[] = {"scene", "camera", NULL};
static const char* const parts_words[] = {"all", "shadow_map", "plain", "plain_march", "single", "both", NULL};
static const uint32_t parts[] = {TY_LPV_ALL,    0,
                                 TY_LPV_PLAIN,  TY_LPV_PLAIN | TY_LPV_MARCH,
                                 TY_LPV_SINGLE, TY_LPV_PLAIN | TY_LPV_MARCH | TY_LPV_SINGLE};

static const ty_option options[] = {
    {TY_OPTION_FIELD(ty_lpv_def, mode), .type = TY_OPTION_WORD, .words = modes,
     .doc = "Form of the propagation: with links, surfaces block the links between cells that they cut, and steps "
            "diffuse as media do; published is the paper's, for its figures."},
    {TY_OPTION_FIELD(ty_lpv_def, parts), .type = TY_OPTION_WORD, .words = parts_words, .values = parts,
     .preset = TY_LPV_ALL, .max = TY_LPV_ALL, .flags = TY_OPTION_BITS,
     .doc = "Components that take part, for comparisons as in the paper's Fig. 5: all; (b) shadow_map, direct light; "
            "(c) plain, with light propagation volumes on surfaces that ignore media; (e) plain_march, these marched, "
            "too; (d) single, single scattering; (f) both, (e) and (d) together."},
    {TY_OPTION_FIELD(ty_lpv_def, resolution), .type = TY_OPTION_INT, .min = 4, .max = TY_LPV_CELLS_MAX, .preset = 32,
     .unit = "cells", .doc = "Cells of the lattice along its longest side; in landscapes along that of the media."},
    {TY_OPTION_FIELD(ty_lpv_def, place), .type = TY_OPTION_WORD, .words = places,
     .doc =
         "Position of the lattice: around media and surfaces, or a cube about the camera that moves by whole cells."},
    {TY_OPTION_FIELD(ty_lpv_def, extent), .type = TY_OPTION_DOUBLE, .min = 1e-6, .max = 1e9, .preset = 32, .unit = "m",
     .doc = "Side of the cube about the camera."},
    {TY_OPTION_FIELD(ty_lpv_def, cascades), .type = TY_OPTION_INT, .min = 1, .max = TY_LPV_CASCADES_MAX, .preset = 1,
     .doc = "Number of nested lattices, each twice as wide as the one within."},
    {TY_OPTION_FIELD(ty_lpv_def, bands), .type = TY_OPTION_INT, .min = 2, .max = TY_LPV_BANDS_MAX, .preset = 2,
     .doc = "Number of bands of spherical harmonics."},
    {TY_OPTION_FIELD(ty_lpv_def, window), .type = TY_OPTION_DOUBLE, .min = 0, .max = 1, .preset = TY_AUTO,
     .flags = TY_OPTION_AUTO,
     .doc = "Reduction of high bands at injection, against ringing; auto is 0 with 2 bands and 0.01 with 3; raise it "
            "where "
            "dark or negative rings surround small bright patches, which widens all lobes."},
    {TY_OPTION_FIELD(ty_lpv_def, iterations), .type = TY_OPTION_INT, .min = 1, .max = 4096, .preset = TY_AUTO,
     .flags = TY_OPTION_AUTO,
     .doc = "Iterations of propagation; auto goes on until tolerance is reached, and takes 8 in mode published."},
    {TY_OPTION_FIELD(ty_lpv_def, tolerance), .type = TY_OPTION_DOUBLE, .min = 0, .max = 1, .preset = 0.01,
     .flags = TY_OPTION_OPEN, .doc = "Fraction of the light that may still be under way when propagation ends."},
    {TY_OPTION_FIELD(ty_lpv_def, map_side), .type = TY_OPTION_INT, .min = 16, .max = 4096, .preset = 256,
     .unit = "texels", .doc = "Side of the reflective shadow maps."},
    {TY_OPTION_FIELD(ty_lpv_def, samples), .type = TY_OPTION_INT, .min = 1, .max = 64, .preset = 8,
     .doc = "Samples on each ray from a light to a texel at most."},
    {TY_OPTION_FIELD(ty_lpv_def, block_side), .type = TY_OPTION_INT, .min = 1, .max = 16, .preset = 3, .unit = "texels",
     .doc = "Texels per cell, along a side, of the depth maps that find blockers; raise it where light leaks past "
            "columns, "
            "railings or gaps finer than a third of a cell; time and memory of the blockers grow with its square."},
    {TY_OPTION_FIELD(ty_lpv_def, shadow_side), .type = TY_OPTION_INT, .min = 16, .max = 4096, .preset = 512,
     .unit = "texels", .doc = "Side of the shadow maps of single scattering."},
    {TY_OPTION_FIELD(ty_lpv_def, light_samples), .type = TY_OPTION_INT, .min = 1, .max = 256, .preset = 8,
     .doc = "Samples per pixel of each environment, and as many of area lights and emissive surfaces together, which "
            "blocks of 4 x 4 pixels on one surface share."},
    {TY_OPTION_FIELD(ty_lpv_def, shadow_rays), .type = TY_OPTION_BOOL, .preset = 1,
     .doc = "Traces rays from surfaces near edges of shadows; else the maps alone decide."},
    {TY_OPTION_KEY(ty_lpv_def, half_resolution_march, "half"), .type = TY_OPTION_BOOL, .preset = 1,
     .doc = "Marches through media at half of the resolution."},
    TY_OPTION_STEP(ty_lpv_def, "cells"),
    TY_OPTION_SPP(ty_lpv_def),
};

const ty_option_table ty_lpv_options = TY_OPTION_TABLE("lpv", ty_lpv_def, "ty_default_lpv_def", options);

void ty_init_lpv_def(void* def, size_t bytes) {
    ty_options_init(&ty_lpv_options, def, bytes);
}

void ty_init_lpv_view_def(void* def, size_t bytes) {
    const ty_lpv_view_def own = {0};
    ty_init_def(def, bytes, &own, sizeof own);
}

static ty_result check_image(ty_context* context, const ty_lpv_def* def) {
    const ty_image_options image = {def->width, def->height, def->spp, def->seed, def->step, def->aovs};
    const ty_result result = ty_check_image(context, "lpv", &image, TY_MARCH_AOVS | TY_AOV_NORMAL);
    if (result == TY_OK && def->view != NULL &&
        (def->view->distance == NULL || def->view->normal == NULL || def->view->albedo == NULL))
        return ty_fail(context, TY_ERROR_ARGUMENT, "lpv.view: distance, normal and albedo must all be there");
    return result;
}

ty_result ty_lpv_take_def(ty_context* context, const ty_lpv_def** def, ty_lpv_known* own) {
    ty_result result = ty_options_take(context, &ty_lpv_options, *def, &own->def);
    if (result != TY_OK) return result;
    *def = &own->def;
    if (own->def.view != NULL) {
        own->view = ty_default_lpv_view_def();
        result = ty_take_def(context, own->def.view, "ty_default_lpv_view_def", &own->view, sizeof own->view);
        own->def.view = &own->view;
    }
    return result == TY_OK ? check_image(context, &own->def) : result;
}

ty_result ty_lpv_check_maps(const ty_scene* scene, const ty_lpv_def* def) {
    if (def->maps == NULL) return TY_OK;
    if (def->map_count < 0 || (size_t)def->map_count != scene->light_count)
        return ty_fail(scene->context, TY_ERROR_ARGUMENT, "lpv.maps: %d maps for %zu lights", def->map_count,
                       scene->light_count);
    for (int32_t i = 0, committed = 0; i < def->map_count; ++i) {
        if (ty_light_is_surface(&scene->lights[i])) continue; /* committed after all others */
        const ty_light_view* light = &scene->view.lights.lights[committed++];
        const ty_result result = scene->lights[i].kind == TY_LIGHT_ENVIRONMENT
                                     ? TY_OK
                                     : ty_rsm_check(scene->context, light, &def->maps[i], i);
        if (result != TY_OK) return result;
    }
    return TY_OK;
}
