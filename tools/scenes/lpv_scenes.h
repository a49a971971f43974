/* Scenes that benches and figures of light propagation volumes share. */
#ifndef TY_TOOLS_LPV_SCENES_H
#define TY_TOOLS_LPV_SCENES_H

#include <tyndall/tyndall.h>

typedef enum lpv_scene {
    LPV_ATRIUM = 0,  /* builtin:atrium */
    LPV_CORNELL = 1, /* builtin:fog_cornell */
    LPV_SPONZA = 2   /* third-party data: Sponza in fog, sun and two lamps */
} lpv_scene;

extern const char* const lpv_scene_names[3];   /* as texts say them */
extern const char lpv_sponza_file[];           /* below the folder of third-party data */
bool lpv_has_sponza(const char* data_or_null); /* the folder of third-party data */

/* data: that folder, of LPV_SPONZA alone. Errors: as of ty_scene_load. */
ty_result lpv_load_scene(ty_context* context, lpv_scene which, const char* data, const char* const* overrides,
                         int32_t override_count, ty_scene** out);

#endif
