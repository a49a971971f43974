#include "cli/methods/help_paths.h"

#include "cli/session/ranks.h"
#include "method/joint.h"
#include "method/path/distributed.h"

int cli_help_paths(cli_session* session, const char* scene_path, const cli_list* overrides) {
    ty_scene* scene = NULL;
    ty_path_helper helper = {NULL, cli_progress_report, &session->progress};
    ty_joint_helper joint;
    ty_job_worker workers[TY_JOB_KINDS] = {0};
    if (scene_path != NULL) {
        const ty_result result =
            ty_scene_load(session->context, scene_path, overrides->items, overrides->count, &scene);
        cli_ranks_hello(session, result == TY_OK ? CLI_GO : cli_fail_reading(session, result), scene);
        helper.scene = scene;
        if (result == TY_OK) workers[TY_JOB_PATH] = ty_path_job_worker(&helper);
        if (result == TY_OK) workers[TY_JOB_JOINT] = ty_joint_worker(&joint, session->comm, scene);
    }
    const int status = cli_ranks_serve(session, workers);
    ty_scene_destroy(scene);
    return cli_session_close(session, status);
}
