/* The choices of method auto on the scenes of the matrix. */
#include "figures/matrix.h"

ty_result matrix_choose(figure_run* run, const char* path, matrix_row* row) {
    const ty_choose_def def = ty_default_choose_def();
    ty_scene* scene = NULL;
    ty_choice choice;
    ty_result result = ty_scene_load(run->session->context, path, NULL, 0, &scene);
    if (result == TY_OK) result = ty_choose_method(scene, &def, &choice);
    if (result == TY_OK) {
        row->choice = choice.method;
        row->features = choice.features;
    }
    ty_scene_destroy(scene);
    return result;
}
