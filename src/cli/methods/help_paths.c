#include "cli/methods/help_paths.h"

#include "cli/session/ranks.h"
#include "io/scenes/scene_editor.h"
#include "method/joint.h"
#include "method/path/distributed.h"

/* The rank's scene: its own, or one that follows the changes of rank 0's. */
typedef struct helped_scene {
    cli_session* session;
    ty_scene* own;
    ty_scene_editor* editor;
    ty_path_helper paths;
    ty_joint_helper joint;
} helped_scene;

static ty_result open_scene(helped_scene* helped, const char* path, const cli_list* overrides, bool follows) {
    ty_context* context = helped->session->context;
    const ty_result result =
        follows ? ty_scene_editor_open(context, path, overrides->items, overrides->count, &helped->editor)
                : ty_scene_load(context, path, overrides->items, overrides->count, &helped->own);
    helped->paths.scene = result == TY_OK && follows ? ty_scene_editor_scene(helped->editor) : helped->own;
    return result;
}

/* The document that rank 0 has after changes. */
static bool follow(void* user, const char* text) {
    helped_scene* helped = user;
    if (ty_scene_editor_follow(helped->editor, text) != TY_OK) {
        ty_take_error(helped->session->context);
        return false;
    }
    helped->paths.scene = helped->joint.scene = ty_scene_editor_scene(helped->editor);
    return true;
}

int cli_help_paths(cli_session* session, const char* scene_path, const cli_list* overrides, bool follows) {
    helped_scene helped = {.session = session, .paths = {NULL, cli_progress_report, &session->progress}};
    const ty_queue_listener listener = {follow, &helped};
    ty_job_worker workers[TY_JOB_KINDS] = {0};
    if (scene_path != NULL) {
        const ty_result result = open_scene(&helped, scene_path, overrides, follows);
        cli_ranks_hello(session, result == TY_OK ? CLI_GO : cli_fail_reading(session, result), helped.paths.scene);
        if (result == TY_OK) workers[TY_JOB_PATH] = ty_path_job_worker(&helped.paths);
        if (result == TY_OK) workers[TY_JOB_JOINT] = ty_joint_worker(&helped.joint, session->comm, helped.paths.scene);
    }
    const int status = cli_ranks_serve(session, workers, helped.editor != NULL ? &listener : NULL);
    ty_scene_destroy(helped.own);
    ty_scene_editor_close(helped.editor);
    return cli_session_close(session, status);
}
