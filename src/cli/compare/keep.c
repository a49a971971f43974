/* Stored images of a comparison and resume states of the path tracer. */
#include "cli/compare/keep.h"
#include "cli/compare/command_line.h"
#include "cli/compare/files.h"

#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

bool cli_keep_state(void* user, const void* state, size_t size) {
    cli_stored_state* stored = user;
    if (stored->size != size) {
        free(stored->bytes);
        stored->bytes = malloc(size);
        stored->size = stored->bytes != NULL ? size : 0;
    }
    if (stored->bytes != NULL) memcpy(stored->bytes, state, size);
    return stored->checkpoint != NULL ? cli_checkpoint_write(stored->checkpoint, state, size) : true;
}

cli_report cli_begin_report(const ty_scene* scene, const ty_method* method, uint64_t seed) {
    cli_report report = {.method = method->name, .seed = seed, .fov_y = ty_scene_camera(scene).fov_y, .complete = true};
    snprintf(report.scene, sizeof report.scene, "%016" PRIx64, ty_scene_hash(scene));
    return report;
}

int cli_keep_rendering(cli_session* session, const cli_comparison* comparison, const cli_report* report,
                       cli_compared* entry) {
    entry->source = report->method;
    entry->seconds = report->run.path.seconds;
    entry->own_seconds = report->run.own_seconds;
    entry->spp = report->run.path.spp;
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
