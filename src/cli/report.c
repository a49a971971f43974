/* What a rendering did, in --stats and in an image's metadata. */
#include "cli/report.h"
#include "cli/metadata.h"
#include "cli/stages.h"

#include <inttypes.h>

/* "march_seconds" of a stage "march". */
static void stage_seconds(json_writer* json, const cli_stage* stages, int count) {
    for (int i = 0; i < count; ++i) {
        char name[40];
        snprintf(name, sizeof name, "%s_seconds", stages[i].name);
        json_number(json, name, stages[i].seconds);
    }
}

static void fld_stats(json_writer* json, const ty_fld_stats* fld) {
    json_open_object(json, "fld");
    json_numbers(json, "direct_size", (const double[]){fld->direct_size[0], fld->direct_size[1], fld->direct_size[2]},
                 3);
    json_numbers(json, "diffusion_size",
                 (const double[]){fld->diffusion_size[0], fld->diffusion_size[1], fld->diffusion_size[2]}, 3);
    json_bool(json, "converged", fld->converged);
    json_numbers(json, "iterations", (const double[]){fld->iterations[0], fld->iterations[1], fld->iterations[2]}, 3);
    json_numbers(json, "cycles", (const double[]){fld->cycles[0], fld->cycles[1], fld->cycles[2]}, 3);
    json_numbers(json, "work", fld->work, 3);
    json_numbers(json, "residual", fld->residual, 3);
    json_numbers(json, "emitted", fld->emitted, 3);
    json_numbers(json, "absorbed", fld->absorbed, 3);
    json_numbers(json, "leaving", fld->leaving, 3);
    cli_stage stages[CLI_STAGES_MAX];
    stage_seconds(json, stages, cli_fld_stages(fld, stages));
    json_number(json, "bytes", fld->bytes);
    json_text(json, "isa", fld->isa);
    json_close_object(json);
}

static void pop_stats(json_writer* json, const ty_pop_stats* pop) {
    cli_stage stages[CLI_STAGES_MAX];
    json_open_object(json, "pop");
    json_integer(json, "ordinates", pop->ordinates);
    json_integer(json, "vpls", pop->vpls);
    json_numbers(json, "size", (const double[]){pop->size[0], pop->size[1], pop->size[2]}, 3);
    json_numbers(json, "merged_size", (const double[]){pop->merged_size[0], pop->merged_size[1], pop->merged_size[2]},
                 3);
    json_integer(json, "planes", pop->planes);
    json_integer(json, "iterations", pop->iterations);
    json_integer(json, "residuum_iterations", pop->residuum_iterations);
    json_bool(json, "converged", pop->converged);
    json_number(json, "left", pop->left);
    stage_seconds(json, stages, cli_pop_stages(pop, stages));
    json_number(json, "bytes", pop->bytes);
    json_text(json, "isa", pop->isa);
    json_close_object(json);
}

double cli_lpv_injection_seconds(const ty_lpv_stats* lpv) {
    return lpv->map_seconds + lpv->reflected_seconds + lpv->scattered_seconds + lpv->blocker_seconds;
}

double cli_lpv_propagation_seconds(const ty_lpv_stats* lpv) {
    return lpv->prepare_seconds + lpv->propagate_seconds + lpv->gather_seconds;
}

double cli_lpv_image_seconds(const ty_lpv_stats* lpv) {
    return lpv->view_seconds + lpv->surface_seconds + lpv->march_seconds + lpv->single_seconds + lpv->compose_seconds;
}

static void lpv_lattices(json_writer* json, const ty_lpv_stats* lpv) {
    json_open_array(json, "lattices");
    for (int i = 0; i < TY_LPV_CASCADES_MAX && lpv->size[i][0] > 0; ++i) {
        json_open_object(json, NULL);
        json_numbers(json, "size", (const double[]){lpv->size[i][0], lpv->size[i][1], lpv->size[i][2]}, 3);
        json_number(json, "cell", lpv->cell[i]);
        json_close_object(json);
    }
    json_close_array(json);
}

static void lpv_stats(json_writer* json, const ty_lpv_stats* lpv) {
    const struct {
        const char* name;
        const double* power;
    } powers[] = {{"reflected", lpv->reflected}, {"scattered", lpv->scattered}, {"absorbed", lpv->absorbed},
                  {"blocked", lpv->blocked},     {"escaped", lpv->escaped},     {"left", lpv->left}};
    cli_stage stages[CLI_STAGES_MAX];
    json_open_object(json, "lpv");
    lpv_lattices(json, lpv);
    json_integer(json, "iterations", lpv->iterations);
    for (size_t i = 0; i < sizeof powers / sizeof powers[0]; ++i)
        json_numbers(json, powers[i].name, powers[i].power, 3);
    stage_seconds(json, stages, cli_lpv_stages(lpv, stages));
    json_integer(json, "rays", lpv->rays);
    json_number(json, "ray_seconds", lpv->ray_seconds);
    json_text(json, "isa", lpv->isa);
    json_close_object(json);
}

static void dom_stats(json_writer* json, const ty_dom_stats* dom) {
    const int32_t *direct = dom->direct_size, *size = dom->size;
    cli_stage stages[CLI_STAGES_MAX];
    json_open_object(json, "dom");
    json_numbers(json, "direct_size", (const double[]){direct[0], direct[1], direct[2]}, 3);
    json_numbers(json, "size", (const double[]){size[0], size[1], size[2]}, 3);
    json_integer(json, "planes", dom->planes);
    json_integer(json, "directions", dom->directions);
    json_integer(json, "bands", dom->bands);
    json_bool(json, "converged", dom->converged);
    json_numbers(json, "sweeps", (const double[]){dom->sweeps[0], dom->sweeps[1], dom->sweeps[2]}, 3);
    json_numbers(json, "cycles", (const double[]){dom->cycles[0], dom->cycles[1], dom->cycles[2]}, 3);
    json_numbers(json, "change", dom->change, 3);
    json_numbers(json, "emitted", dom->emitted, 3);
    json_numbers(json, "absorbed", dom->absorbed, 3);
    json_numbers(json, "absorbed_by_surfaces", dom->absorbed_by_surfaces, 3);
    json_numbers(json, "leaving", dom->leaving, 3);
    stage_seconds(json, stages, cli_dom_stages(dom, stages));
    json_number(json, "sweep_seconds", dom->sweep_seconds);
    json_number(json, "bytes", dom->bytes);
    json_text(json, "isa", dom->isa);
    json_close_object(json);
}

void cli_report_stats(json_writer* json, const void* user) {
    const cli_report* report = user;
    json_text(json, "method", report->method);
    if (report->choice[0] != '\0') json_text(json, "choice", report->choice);
    json_text(json, "scene", report->scene);
    json_integer(json, "scene_bytes", (int64_t)report->scene_bytes);
    json_integer(json, "width", report->width);
    json_integer(json, "height", report->height);
    json_unsigned(json, "seed", report->seed);
    json_bool(json, "resumed", report->resumed);
    json_bool(json, "complete", report->complete);
    json_number(json, "spp", report->path.spp);
    json_unsigned(json, "paths", report->path.paths);
    json_unsigned(json, "vertices", report->path.vertices);
    json_number(json, "error", report->path.error);
    json_text(json, "isa", report->path.isa == NULL ? "" : report->path.isa);
    if (report->screen.isa != NULL) {
        json_open_object(json, "screen");
        json_number(json, "seconds", report->screen.seconds);
        json_numbers(json, "step_seconds", report->screen.step_seconds, 3);
        json_integer(json, "levels", report->screen.levels);
        json_number(json, "spread", report->screen.spread);
        json_integer(json, "oversized", report->screen.oversized);
        json_integer(json, "nonfinite_fixed", report->screen.nonfinite_fixed);
        json_number(json, "bytes", report->screen.bytes);
        json_text(json, "isa", report->screen.isa);
        json_close_object(json);
    }
    if (report->fld.isa != NULL) fld_stats(json, &report->fld);
    if (report->pop.isa != NULL) pop_stats(json, &report->pop);
    if (report->lpv.isa != NULL) lpv_stats(json, &report->lpv);
    if (report->dom.isa != NULL) dom_stats(json, &report->dom);
    json_number(json, "load_seconds", report->load_seconds);
    json_number(json, "render_seconds", report->path.seconds);
    json_number(json, "render_cpu_seconds", report->path.cpu_seconds);
}

ty_result cli_report_metadata(ty_image* image, const cli_report* report) {
    char seed[24];
    snprintf(seed, sizeof seed, "%" PRIu64, report->seed);
    const struct {
        const char *key, *value;
    } texts[] = {
        {"tyndall.version", ty_version()},
        {"tyndall.method", report->method},
        {"tyndall.scene", report->scene},
        {"tyndall.seed", seed}, /* text: a double does not hold 64 bits */
    };
    const struct {
        const char* key;
        double value;
    } numbers[] = {
        {"tyndall.spp", report->path.spp},
        {"tyndall.seconds", report->path.seconds},
        {"tyndall.own_seconds", report->own_seconds},
        {"tyndall.error", report->path.error},
        {"tyndall.complete", report->complete ? 1 : 0},
    };
    ty_result result = TY_OK;
    for (size_t i = 0; result == TY_OK && i < sizeof texts / sizeof texts[0]; ++i)
        result = ty_image_set_text(image, texts[i].key, texts[i].value);
    for (size_t i = 0; result == TY_OK && i < sizeof numbers / sizeof numbers[0]; ++i)
        result = ty_image_set_number(image, numbers[i].key, numbers[i].value);
    if (result == TY_OK && report->choice[0] != '\0')
        result = ty_image_set_text(image, "tyndall.choice", report->choice);
    if (result == TY_OK && report->fov_y > 0) result = ty_image_set_number(image, cli_fov_key, report->fov_y);
    return result;
}
