/* What the parts of the scene file reader share: where they read, how they report, and the files a scene names. */
#ifndef TY_IO_SCENE_READER_H
#define TY_IO_SCENE_READER_H

#include "io/json_locate.h"

#include <jansson.h>
#include <tyndall/io.h>

typedef struct ty_scene_override {
    const char* text; /* "media[0].g=0.5", borrowed */
    char* keys;       /* what path's keys lie in */
    size_t keys_size;
    ty_json_path path;
} ty_scene_override;

/* What was read of a file that the scene names: one of grid, image and shell, owned; none when only the hash took it.
 */
typedef struct ty_scene_asset {
    char* path;
    ty_grid* grid;
    ty_volume_def volume; /* what of the file the grid is; texts are borrowed from root */
    ty_image* image;
    ty_closed_mesh* shell;
    ty_affine placement; /* of the shell */
} ty_scene_asset;

typedef struct ty_scene_reader {
    ty_context* context;
    bool clean;         /* the context had no message before */
    const char* name;   /* of the file, in messages */
    const char* folder; /* where relative paths start; NULL: the scene may name no files */
    const char* text;
    size_t length; /* 0 where there is no text, and so no lines */
    json_t* root;  /* after overrides */
    ty_scene_override* overrides;
    int32_t override_count;
    ty_scene* scene;
    double unit; /* metres */
    ty_axis up_axis;
    int32_t frame; /* of volumes that do not say theirs */
    uint64_t hash;
    ty_scene_asset* assets;
    size_t asset_count, asset_capacity;
} ty_scene_reader;

/* Sets root from text. */
ty_result ty_reader_parse(ty_scene_reader* reader);
/* Fails unless root keeps to the schema, or to the part of it that "$defs" has under a name. */
ty_result ty_reader_check(const ty_scene_reader* reader, const char* part);

/* Fails with "FILE:LINE: PATH: message", or names the override that the value came from. */
ty_result ty_reader_fail(const ty_scene_reader* reader, const ty_json_path* path, ty_result result, const char* format,
                         ...) __attribute__((format(printf, 4, 5)));
/* Puts the place in front of the message that a call below just failed with; TY_ERROR_ARGUMENT becomes
 * TY_ERROR_INPUT. TY_OK stays. */
ty_result ty_reader_below(const ty_scene_reader* reader, const ty_json_path* path, ty_result result);

/* Values of an object that kept to the schema. Each leaves out as it was when the key is absent. */
void ty_read_number(const json_t* object, const char* key, double* out);
void ty_read_float(const json_t* object, const char* key, float* out);
void ty_read_int(const json_t* object, const char* key, int32_t* out);
void ty_read_bool(const json_t* object, const char* key, bool* out);
void ty_read_vector(const json_t* object, const char* key, double factor, double out[3]);
/* One number for all channels, or three. */
void ty_read_rgb(const json_t* object, const char* key, float out[3]);
void ty_read_numbers(const json_t* object, const char* key, double out[3]);

/* Fails when the direction under key has no length. */
ty_result ty_read_direction(const ty_scene_reader* reader, const json_t* object, const ty_json_path* path,
                            const char* key, double out[3]);
/* Two corners under key, times factor; fails unless the second is above the first. */
ty_result ty_read_box(const ty_scene_reader* reader, const json_t* object, const ty_json_path* path, const char* key,
                      double factor, double lower[3], double upper[3]);
/* origin, u and v, in metres; fails when the edges span no area. */
ty_result ty_read_edges(const ty_scene_reader* reader, const json_t* object, const ty_json_path* path, double origin[3],
                        double u[3], double v[3]);
/* The map under "transform", identity when absent, taking points in units of from_unit metres to units of to_unit. */
ty_result ty_read_transform(const ty_scene_reader* reader, const json_t* object, const ty_json_path* path,
                            double from_unit, double to_unit, ty_affine* out);

/* ---- Files: found from the scene's folder, hashed, read once and kept by the reader ---- */

/* Whether the name ends like one of the extensions, ".vdb", whatever the case; the list ends with NULL. */
bool ty_has_extension(const char* file, const char* const* extensions);
/* ".gltf" and ".glb"; these and the other kinds of files with meshes; volumes. */
extern const char* const ty_gltf_extensions[];
extern const char* const ty_mesh_extensions[];
extern const char* const ty_volume_extensions[];
/* The path of a file that is neither image nor volume; its bytes are in the hash. place is that of the key that names
 * the file. The path is the reader's. */
ty_result ty_find_file(ty_scene_reader* reader, const ty_json_path* place, const char* file, const char** path);
ty_result ty_find_mesh_file(ty_scene_reader* reader, const ty_json_path* place, const char* file, const char** path);
/* place is that of the key that names the file. */
ty_result ty_read_map(ty_scene_reader* reader, const ty_json_path* place, const char* file, const ty_image** out);
/* file: a path that ty_find_mesh_file gave. placement takes the file's points to the medium's. */
ty_result ty_read_shell(ty_scene_reader* reader, const ty_json_path* place, const char* path,
                        const ty_mesh_file_def* def, ty_closed_mesh** out);
/* A grid of a volume, an object at place; grid_name counts unless the volume names one. Raw volumes
 * without spacing are refused unless filling is true: there is a box to fill. */
ty_result ty_read_volume(ty_scene_reader* reader, const json_t* volume, const ty_json_path* place,
                         const char* grid_name, bool filling, ty_grid** out);
/* The same for red, green and blue: one grid three times when the volume has one value per voxel. */
ty_result ty_read_volume_rgb(ty_scene_reader* reader, const json_t* volume, const ty_json_path* place,
                             const char* grid_name, bool filling, ty_grid* out[3]);
void ty_free_assets(ty_scene_reader* reader);

/* A file and, as far as they are there, the files that it names: buffers and images of a .gltf, materials and their
 * images of an .obj, the data of an .nhdr. */
ty_result ty_hash_file_and_names(ty_context* context, const char* path, uint64_t* hash);

/* ---- The sections of a scene ---- */

/* Sets sigma_s, sigma_a and g of a medium at path. */
ty_result ty_read_coefficients(const ty_scene_reader* reader, const json_t* medium, const ty_json_path* path,
                               ty_medium_def* def);
/* Sets what goes with coefficients and density: fields of albedo and g, emission, transfer function. points: room for
 * TY_TRANSFER_MAX. */
ty_result ty_read_fields(ty_scene_reader* reader, const json_t* medium, const ty_json_path* path, ty_medium_def* def,
                         ty_transfer_point* points);
/* Whether the points of the transfer function give the albedo. */
bool ty_transfer_has_albedo(const json_t* medium);
/* What takes a mesh file's points to units of to_unit metres: units, turning up, and item's transform. */
ty_result ty_read_mesh_placement(const ty_scene_reader* reader, const json_t* item, const ty_json_path* path,
                                 double to_unit, ty_mesh_file_def* def);
ty_result ty_read_camera(ty_scene_reader* reader);
ty_result ty_read_media(ty_scene_reader* reader);
ty_result ty_read_lights(ty_scene_reader* reader);
ty_result ty_read_geometry(ty_scene_reader* reader);

/* Takes overrides apart and sets their values in reader->root. Failed or not, ty_free_overrides follows. */
ty_result ty_apply_overrides(ty_scene_reader* reader, const char* const* texts, int32_t count);
void ty_free_overrides(ty_scene_reader* reader);

#endif
