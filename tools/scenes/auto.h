/* Test scenes of method auto's choices. */
#ifndef TY_TOOLS_AUTO_H
#define TY_TOOLS_AUTO_H

#include "scenes/scenes.h"

enum { AUTO_OVERRIDES_MAX = 3, AUTO_SCENES_MAX = 32 };

typedef struct auto_scene {
    const char* name;
    const char* scene; /* argument of tools_load_scene */
    const char* file;  /* required third-party data; NULL: none */
    const char* overrides[AUTO_OVERRIDES_MAX];
    bool held_out; /* held out: not used for fitting the rules */
} auto_scene;

extern const auto_scene auto_scenes[];
extern const int32_t auto_scene_count; /* AUTO_SCENES_MAX at most */

/* data: the folder of third-party data, unused by scenes without a file. Errors: those of ty_scene_load. */
ty_result auto_load_scene(ty_context* context, const auto_scene* from, const char* data, ty_scene** out);

#endif
