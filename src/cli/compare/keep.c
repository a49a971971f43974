/* Renderings of a comparison, and states of paths, kept. */
#include "cli/compare/keep.h"
#include "cli/compare/command_line.h"
#include "cli/compare/files.h"

#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

bool cli_keep_state(void* user, const void* state, size_t size) {
    cli_kept_state* kept = user;
    if (kept->size != size) {
        free(kept->bytes);
        kept->bytes = malloc(size);
        kept->size = kept->bytes != NULL ? size : 0;
    }
    if (kept->bytes != NULL) memcpy(kept->bytes, state, size);
    return kept->checkpoint != NULL ? cli_checkpoint_write(kept->checkpoint, state, size) : true;
}

cli_report cli_begin_report(const ty_scene* scene, const cli_method* method, uint64_t seed) {
    cli_report report = {.method = method->name, .seed = seed, .fov_y = ty_scene_camera(scene).fov_y, .complete = true};
    snprintf(report.scene, sizeof report.scene, "%016" PRIx64, ty_scene_hash(scene));
    return report;
}

int cli_keep_rendering(cli_session* session, const cli_comparison* comparison, const cli_report* report,
                       cli_compared* entry) {
    entry->source = report->method;
    entry->seconds = report->path.seconds;
    entry->own_seconds = report->own_seconds;
    entry->spp = report->path.spp;
    entry->stage_count = cli_report_stages(report, entry->stages);
    free(entry->command);
    entry->command = cli_render_command(comparison, entry, report->seed);
    char* path = cli_comparison_path(comparison->folder, "", entry->name, ".exr");
    if (path == NULL) return CLI_FAILED;
    ty_result result = cli_report_metadata(entry->image, report);
    if (result == TY_OK) result = ty_image_write_exr(session->context, entry->image, path);
    free(path);
    return result == TY_OK ? CLI_GO : cli_fail_running(session, result);
}
