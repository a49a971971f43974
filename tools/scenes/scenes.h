/* Scenes of benches and figures: files of scenes/tools embedded in the programs. */
#ifndef TY_TOOLS_SCENES_H
#define TY_TOOLS_SCENES_H

#include <tyndall/tyndall.h>

/* Files that scenes need, relative to the folder of third-party data. */
#define DISNEY_CLOUD_FILE "volumes/wdas_cloud_sixteenth.vdb"
#define PLUME_FILE "volumes/plume/plume_0042.vdb"
#define CT_HEAD_FILE "volumes/headsq_ct_64x64x93_i16.nrrd"
#define SPONZA_FILE "scenes/sponza_atrium.glb"
#define STAIRCASE_FILE "scenes/wooden_staircase.glb"
#define CORNELL_FILE "scenes/cornell_box_lightmap_uv.glb"

/* name: a file of scenes/tools without .json, or "builtin:NAME", or a path. data: the folder of third-party data, or
 * NULL for scenes without. Errors: those of ty_scene_load. */
ty_result tools_load_scene(ty_context* context, const char* name, const char* data, const char* const* overrides,
                           int32_t override_count, ty_scene** out);

/* Writes a file of scenes/tools to a path, for a program of its own. False if that fails. */
bool tools_write_scene(const char* name, const char* path);

/* True if the folder of third-party data has a file. */
bool tools_has_data(const char* data_or_null, const char* name);

/* The scenes of light propagation volumes. */
typedef enum lpv_scene {
    LPV_ATRIUM = 0,
    LPV_CORNELL = 1,
    LPV_SPONZA = 2 /* third-party data: Sponza in fog, sun and two local lights */
} lpv_scene;

extern const char* const lpv_scene_names[3]; /* title for readers */
extern const char* const lpv_scene_files[3]; /* argument of tools_load_scene */

#endif
