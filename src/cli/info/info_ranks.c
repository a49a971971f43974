/* tyndall info --ranks: memory and messages of each rank of a divided solve. */
#include "cli/info/info.h"

#include "method/dom/solve/solve.h"
#include "method/fld/job.h"
#include "solve/diffusion/divided/plan.h"
#include "solve/ordinates/divided/plan.h"

static void write_sizes(json_writer* json, const char* name, const int32_t* sizes, int count) {
    double values[3];
    for (int i = 0; i < count; ++i) values[i] = sizes[i];
    json_numbers(json, name, values, count);
}

static void write_ordinates(json_writer* json, const ty_ordinates_def* def, const ty_ordinates_plan* plan) {
    json_open_object(json, "dom");
    write_sizes(json, "cells", def->size, 3);
    json_int(json, "directions", def->set->count);
    json_int(json, "bands", def->bands);
    write_sizes(json, "ranks_along_x_y", plan->ranks, 2);
    write_sizes(json, "cells_of_a_rank", plan->part, 3);
    json_number(json, "array_bytes", plan->arrays);
    json_number(json, "solver_bytes", plan->solve);
    json_number(json, "rank_0_bytes_besides", plan->whole);
    json_open_object(json, "sweep");
    json_int(json, "units", plan->units);
    json_int(json, "stages", plan->stages);
    json_int(json, "stages_corner_by_corner", ty_ordinates_stages_kba(plan));
    json_number(json, "messages", plan->messages);
    json_number(json, "message_bytes", plan->message_bytes);
    json_number(json, "acceleration_bytes_of_all", plan->cell_bytes);
    json_close_object(json);
    json_close_object(json);
}

static void write_diffusion(json_writer* json, const ty_diffusion_def* def, const ty_diffusion_plan* plan) {
    json_open_object(json, "fld");
    write_sizes(json, "cells", def->size, 3);
    write_sizes(json, "ranks_along_x_y_z", plan->ranks, 3);
    write_sizes(json, "cells_of_a_rank", plan->part, 3);
    json_number(json, "array_bytes", plan->arrays);
    json_number(json, "solver_bytes", plan->solve);
    json_number(json, "rank_0_bytes_besides", plan->whole);
    json_open_object(json, "cycle");
    json_int(json, "divided_levels", plan->levels);
    json_number(json, "cells_visited", plan->cells);
    json_number(json, "messages", plan->messages);
    json_number(json, "message_bytes", plan->halo_bytes);
    json_number(json, "gathered_bytes", plan->gather_bytes);
    json_close_object(json);
    json_close_object(json);
}

/* A method that cannot be divided so has the reason in its place. */
static ty_result write_refusal(const ty_scene* scene, const char* method, ty_result result, json_writer* json) {
    if (result != TY_ERROR_ARGUMENT) return result;
    json_open_object(json, method);
    json_text(json, "refused", ty_take_error(ty_scene_context(scene)));
    json_close_object(json);
    return TY_OK;
}

static ty_result plan_ordinates(const ty_scene* scene, int32_t ranks, json_writer* json) {
    ty_dom_def dom = ty_default_dom_def();
    ty_angular_quadrature set;
    ty_ordinates_def def;
    ty_ordinates_plan plan;
    ty_result result = ty_method_options(scene, "dom", &dom);
    if (result == TY_OK) result = ty_dom_plan(scene, &dom, &set, &def);
    if (result == TY_OK) result = ty_ordinates_plan_ranks(ty_scene_context(scene), &def, ranks, &plan);
    if (result == TY_OK) write_ordinates(json, &def, &plan);
    return write_refusal(scene, "dom", result, json);
}

static ty_result plan_diffusion(const ty_scene* scene, int32_t ranks, json_writer* json) {
    ty_fld_def fld = ty_default_fld_def();
    ty_diffusion_def def = ty_default_diffusion_def();
    ty_diffusion_plan plan;
    ty_grid_box direct;
    ty_result result = ty_method_options(scene, "fld", &fld);
    if (result == TY_OK) result = ty_fld_choose_cells(scene, &fld, &direct, def.size);
    for (int a = 0; a < 3 && result == TY_OK; ++a) def.cell[a] = (direct.upper[a] - direct.lower[a]) / def.size[a];
    if (result == TY_OK) result = ty_diffusion_plan_ranks(ty_scene_context(scene), &def, ranks, &plan);
    if (result == TY_OK) write_diffusion(json, &def, &plan);
    return write_refusal(scene, "fld", result, json);
}

int cli_info_ranks(cli_session* session, const char* path, const cli_list* overrides, int32_t ranks, bool as_json) {
    ty_scene* scene = NULL;
    ty_result result = ty_scene_load(session->context, path, overrides->items, overrides->count, &scene);
    if (result == TY_OK) result = ty_scene_commit(scene);
    if (result == TY_OK && ty_scene_get_info(scene).media == 0) {
        ty_scene_destroy(scene);
        return cli_fail(CLI_USAGE, "%s: there are no media to divide", path);
    }
    if (result == TY_OK) {
        json_writer json = as_json ? json_begin(stdout) : json_begin_plain(stdout);
        json_open_object(&json, NULL);
        json_text(&json, "kind", "plan");
        json_text(&json, "file", path);
        json_int(&json, "ranks", ranks);
        result = plan_ordinates(scene, ranks, &json);
        if (result == TY_OK) result = plan_diffusion(scene, ranks, &json);
        json_close_object(&json);
    }
    const int status = result == TY_OK ? CLI_DONE : cli_fail_reading(session, result);
    ty_scene_destroy(scene);
    return status;
}
