/* Figs. 8 and 9 of the paper, with volumes that are free: a CT scan seen through a transfer function, and a plume of
 * smoke that glows where it is hot. */
#include "figures/fld_volumes.h"
#include "figures/fld_view.h"

#include <string.h>

enum { CT_WIDTH = 256, FIRE_WIDTH = 216, FIRE_HEIGHT = 288 };

const char fld_ct_file[] = "volumes/headsq_ct_64x64x93_i16.nrrd";
static const char fire_file[] = "volumes/plume/plume_0042.vdb";

/* Tissue and bone have albedos of their own, and one light, as in the paper. */
const char fld_ct_scene[] =
    "{\"tyndall\": 1, \"meters_per_unit\": 0.001, \"up_axis\": \"z\","
    " \"camera\": {\"position\": [-250, -360, 120], \"target\": [101, 108, 66], \"fov_y\": 23,"
    "  \"resolution\": [256, 256], \"exposure\": 3},"
    " \"media\": [{\"name\": \"head\", \"density\": {\"file\": \"volumes/headsq_ct_64x64x93_i16.nrrd\"},"
    "  \"transform\": {\"rotate\": [180, 0, 0], \"translate\": [0, 202, 138]},"
    "  \"transfer\": ["
    "   {\"value\": 500, \"density\": 0, \"albedo\": [0.98, 0.9, 0.84]},"
    "   {\"value\": 900, \"density\": 0.03, \"albedo\": [0.98, 0.9, 0.84]},"
    "   {\"value\": 1150, \"density\": 0.04, \"albedo\": [0.97, 0.85, 0.78]},"
    "   {\"value\": 1260, \"density\": 1, \"albedo\": [0.985, 0.97, 0.93]},"
    "   {\"value\": 3000, \"density\": 1, \"albedo\": [0.985, 0.975, 0.95]}],"
    "  \"sigma_t\": 1500}],"
    " \"lights\": [{\"type\": \"directional\", \"direction\": [0.7, 0.5, -0.6], \"irradiance\": 1}]}";

static const char fire_scene[] =
    "{\"tyndall\": 1, \"up_axis\": \"z\","
    " \"camera\": {\"position\": [4.4, -5.4, 1.5], \"target\": [1, 1, 1.9], \"fov_y\": 38,"
    "  \"resolution\": [216, 288], \"exposure\": 2.5},"
    " \"media\": [{\"name\": \"burning smoke\","
    "  \"density\": {\"file\": \"volumes/plume/plume_0042.vdb\", \"grid\": \"density\"},"
    "  \"sigma_t\": 14, \"albedo\": [0.8, 0.78, 0.75],"
    "  \"emission\": {\"temperature\": {\"file\": \"volumes/plume/plume_0042.vdb\", \"grid\": \"temperature\"},"
    "   \"kelvin\": [300, 1000], \"scale\": 0.012}}],"
    " \"lights\": [{\"type\": \"directional\", \"direction\": [-0.6, 0.5, -0.6], \"irradiance\": 0.3}]}";

/* file: what the text names, below the folder of third-party data. Errors: those of ty_scene_parse. */
static ty_result show(figure_run* run, const char* file, const char* text, const char* item, int32_t width,
                      int32_t height) {
    char path[FIGURE_PATH_SIZE];
    if (!figure_find_data(run, file, path)) return TY_OK;
    ty_scene* scene = NULL;
    ty_result result =
        ty_scene_parse(run->session->context, text, strlen(text), item, run->options->data, NULL, 0, &scene);
    if (result == TY_OK) result = fld_show_scene(run, scene, item, width, height);
    ty_scene_destroy(scene);
    return result;
}

ty_result figure_fld_ct(figure_run* run) {
    const ty_result result = show(run, fld_ct_file, fld_ct_scene, "CT head", CT_WIDTH, CT_WIDTH);
    snprintf(
        run->caption, sizeof run->caption,
        "A head of 64 × 64 × 93 voxels (the paper's is not free), extinction and albedo by transfer functions, lit "
        "from one side. Errors are of means over %d × %d pixels, the relative RMSE without the truth's own noise.",
        FIGURE_BLOCK, FIGURE_BLOCK);
    return result;
}

ty_result figure_fld_fire(figure_run* run) {
    const ty_result result = show(run, fire_file, fire_scene, "plume", FIRE_WIDTH, FIRE_HEIGHT);
    snprintf(
        run->caption, sizeof run->caption,
        "Simulated smoke with an external light that glows as black bodies do (the paper's is not free, and has an "
        "albedo of 1, with which nothing glows). Errors are of means over %d × %d pixels, the relative RMSE without "
        "the truth's own noise.",
        FIGURE_BLOCK, FIGURE_BLOCK);
    return result;
}
