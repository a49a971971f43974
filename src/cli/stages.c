/* What a rendering's time went into. */
#include "cli/stages.h"

#include <string.h>

static int copy_stages(const cli_stage* stages, size_t size, cli_stage out[CLI_STAGES_MAX]) {
    memcpy(out, stages, size);
    return (int)(size / sizeof *stages);
}

int cli_fld_stages(const ty_fld_stats* fld, cli_stage out[CLI_STAGES_MAX]) {
    const cli_stage stages[] = {
        {"medium", fld->medium_seconds},
        {"direct", fld->direct_seconds},
        {"solve", fld->solve_seconds},
        {"march", fld->march_seconds},
    };
    return copy_stages(stages, sizeof stages, out);
}

int cli_pop_stages(const ty_pop_stats* pop, cli_stage out[CLI_STAGES_MAX]) {
    const cli_stage stages[] = {
        {"medium", pop->medium_seconds},
        {"importance", pop->importance_seconds},
        {"ordinate", pop->ordinate_seconds},
        {"vpl", pop->vpl_seconds},
        {"direct", pop->direct_seconds},
        {"initial", pop->initial_seconds},
        {"propagation", pop->propagation_seconds},
        {"residuum", pop->residuum_seconds},
        {"merge", pop->merge_seconds},
        {"march", pop->march_seconds},
    };
    return copy_stages(stages, sizeof stages, out);
}

int cli_lpv_stages(const ty_lpv_stats* lpv, cli_stage out[CLI_STAGES_MAX]) {
    const cli_stage stages[] = {
        {"medium", lpv->medium_seconds},       {"map", lpv->map_seconds},
        {"shadow", lpv->shadow_seconds},       {"reflected", lpv->reflected_seconds},
        {"scattered", lpv->scattered_seconds}, {"blocker", lpv->blocker_seconds},
        {"prepare", lpv->prepare_seconds},     {"propagate", lpv->propagate_seconds},
        {"gather", lpv->gather_seconds},       {"view", lpv->view_seconds},
        {"surface", lpv->surface_seconds},     {"march", lpv->march_seconds},
        {"single", lpv->single_seconds},       {"compose", lpv->compose_seconds},
    };
    return copy_stages(stages, sizeof stages, out);
}

int cli_dom_stages(const ty_dom_stats* dom, cli_stage out[CLI_STAGES_MAX]) {
    const cli_stage stages[] = {
        {"medium", dom->medium_seconds}, {"direct", dom->direct_seconds}, {"source", dom->source_seconds},
        {"walls", dom->wall_seconds},    {"solve", dom->solve_seconds},   {"march", dom->march_seconds},
    };
    return copy_stages(stages, sizeof stages, out);
}

static int screen_stages(const ty_screen_stats* screen, cli_stage out[CLI_STAGES_MAX]) {
    const cli_stage stages[] = {{"attenuation", screen->step_seconds[0]},
                                {"filtering", screen->step_seconds[1]},
                                {"composition", screen->step_seconds[2]}};
    return copy_stages(stages, sizeof stages, out);
}

static int own_stages(const cli_report* report, cli_stage out[CLI_STAGES_MAX]) {
    if (report->fld.isa != NULL) return cli_fld_stages(&report->fld, out);
    if (report->pop.isa != NULL) return cli_pop_stages(&report->pop, out);
    if (report->lpv.isa != NULL) return cli_lpv_stages(&report->lpv, out);
    if (report->dom.isa != NULL) return cli_dom_stages(&report->dom, out);
    if (report->screen.isa != NULL) return screen_stages(&report->screen, out);
    return 0;
}

int cli_report_stages(const cli_report* report, cli_stage out[CLI_STAGES_MAX]) {
    cli_stage own[CLI_STAGES_MAX] = {0};
    const int own_count = own_stages(report, own);
    int count = 0;
    double left = report->path.seconds;
    const double paths = own_count == 0 ? report->path.seconds : report->path.seconds - report->own_seconds;
    if (paths > 0) {
        out[count++] = (cli_stage){own_count == 0 ? "paths" : "surfaces", paths};
        left -= paths;
    }
    for (int i = 0; i < own_count && count < CLI_STAGES_MAX - 1; ++i) {
        left -= own[i].seconds;
        if (own[i].seconds > 0) out[count++] = own[i];
    }
    if (left > 0.005 * report->path.seconds) out[count++] = (cli_stage){"other", left};
    return count;
}
