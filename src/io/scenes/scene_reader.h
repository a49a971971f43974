/* Internal interface of the scene file reader: its state, messages, values, and referenced files. */
#ifndef TY_IO_SCENE_READER_H
#define TY_IO_SCENE_READER_H

#include "io/json_locate.h"
#include "io/scenes/asset_cache.h"

#include <jansson.h>
#include <tyndall/io.h>

typedef struct ty_scene_override {
    const char* text; /* "media[0].g=0.5", borrowed */
    char* keys;       /* storage of path's keys */
    size_t keys_size;
    ty_json_path path;
} ty_scene_override;

/* Sections of a scene file, in the order in which they are read. */
typedef enum ty_scene_section {
    TY_SECTION_CAMERA,
    TY_SECTION_MEDIA,
    TY_SECTION_LIGHTS,
    TY_SECTION_GEOMETRY,
    TY_SECTIONS
} ty_scene_section;

/* Digests of the files that a section names, in order of their first use. */
typedef struct ty_file_digests {
    uint64_t* values;
    size_t count, capacity;
} ty_file_digests;

/* Text of a scene file, or of a builtin scene. */
typedef struct ty_scene_source {
    const char* text;
    size_t length;
    char* folder;   /* owned; start of relative paths */
    uint8_t* bytes; /* of a file, owned; NULL: builtin */
} ty_scene_source;

/* ty_close_source must follow, also after a failure. */
ty_result ty_open_source(ty_context* context, const char* path, ty_scene_source* source);
void ty_close_source(ty_context* context, ty_scene_source* source);

typedef struct ty_scene_reader {
    ty_context* context;
    bool clean;         /* true if the thread had no unread message of the context before */
    bool bare;          /* messages name the JSON path, not the file */
    const char* name;   /* file name in messages */
    const char* folder; /* start of relative paths; NULL: references to files are refused */
    const char* text;
    size_t length;  /* 0 without text, and so without line numbers */
    json_t* root;   /* after overrides */
    json_t* schema; /* of scene files, borrowed; NULL: made where it is needed */
    ty_scene_override* overrides;
    int32_t override_count;
    ty_scene* scene;
    double unit; /* length unit, m */
    ty_axis up_axis;
    int32_t frame;                      /* frame number of volumes without their own */
    ty_scene_section section;           /* being read */
    ty_file_digests files[TY_SECTIONS]; /* of the sections read */
    size_t listed_lights;               /* number of the scene's lights that do not come from meshes' files */
    ty_asset_cache* assets;
} ty_scene_reader;

/* Sets root from text. */
ty_result ty_reader_parse(ty_scene_reader* reader);
/* Fails unless root conforms to the schema, or to the "$defs" entry named `part`. */
ty_result ty_reader_check(const ty_scene_reader* reader, const char* part);

/* Reads the sections whose bits are set, and the options of rendering, into a new scene, which is not committed: on
 * failure, too, it is the caller's. */
ty_result ty_read_sections(ty_scene_reader* reader, unsigned sections);
/* Hash of root and of the files of all sections, each content once. */
ty_result ty_reader_hash(const ty_scene_reader* reader, const ty_file_digests files[TY_SECTIONS], uint64_t* hash);

/* Commits the scene; its message names the boundary where the scene is periodic. */
ty_result ty_reader_commit(const ty_scene_reader* reader);

/* Fails with "FILE:LINE: PATH: message", or names the override that set the value. */
ty_result ty_reader_fail(const ty_scene_reader* reader, const ty_json_path* path, ty_result result, const char* format,
                         ...) __attribute__((format(printf, 4, 5)));
/* Prefixes the message of a failed call with the location; TY_ERROR_ARGUMENT becomes TY_ERROR_INPUT. TY_OK is
 * returned unchanged. */
ty_result ty_reader_prefix_error(const ty_scene_reader* reader, const ty_json_path* path, ty_result result);

/* Values of an object that conforms to the schema. Each reader leaves `out` unchanged if the key is absent. */
void ty_read_number(const json_t* object, const char* key, double* out);
void ty_read_float(const json_t* object, const char* key, float* out);
void ty_read_int(const json_t* object, const char* key, int32_t* out);
void ty_read_bool(const json_t* object, const char* key, bool* out);
void ty_read_vector(const json_t* object, const char* key, double factor, double out[3]);
/* One number for all channels, or three. */
void ty_read_rgb(const json_t* object, const char* key, float out[3]);
void ty_read_numbers(const json_t* object, const char* key, double out[3]);

/* Fails if the direction under key has length 0. */
ty_result ty_read_direction(const ty_scene_reader* reader, const json_t* object, const ty_json_path* path,
                            const char* key, double out[3]);
/* Two corners under key, times factor; fails unless the second is above the first. */
ty_result ty_read_box(const ty_scene_reader* reader, const json_t* object, const ty_json_path* path, const char* key,
                      double factor, double lower[3], double upper[3]);
/* origin, u and v in meters; fails if the edges span no area. */
ty_result ty_read_edges(const ty_scene_reader* reader, const json_t* object, const ty_json_path* path, double origin[3],
                        double u[3], double v[3]);
/* The map under "transform", identity if absent, from points in from_unit meters to points in to_unit meters. */
ty_result ty_read_transform(const ty_scene_reader* reader, const json_t* object, const ty_json_path* path,
                            double from_unit, double to_unit, ty_affine* out);

/* ---- files: located from the scene's folder, hashed, read once, kept by the reader's assets ---- */

/* True if the name ends with one of the extensions, such as ".vdb", in any case; the list ends with NULL. */
bool ty_has_extension(const char* file, const char* const* extensions);
/* Extensions: ".gltf" and ".glb"; all mesh formats; volumes. */
extern const char* const ty_gltf_extensions[];
extern const char* const ty_mesh_extensions[];
extern const char* const ty_volume_extensions[];
/* A file by its name in the scene; its digest goes into the scene's hash. json_path is that of the referencing key. */
ty_result ty_find_file(ty_scene_reader* reader, const ty_json_path* json_path, const char* name,
                       const ty_asset_file** file);
ty_result ty_find_mesh_file(ty_scene_reader* reader, const ty_json_path* json_path, const char* name,
                            const ty_asset_file** file);
/* json_path is that of the referencing key. */
ty_result ty_read_map(ty_scene_reader* reader, const ty_json_path* json_path, const char* name,
                      ty_environment_map** out);
/* sun: its irradiance. */
ty_result ty_make_sky(ty_scene_reader* reader, const ty_json_path* json_path, const ty_sky_def* def,
                      ty_environment_map** out, float sun[3]);
/* file: from ty_find_mesh_file. The transform of def maps the file's points to the medium's. */
ty_result ty_read_shell(ty_scene_reader* reader, const ty_json_path* json_path, const ty_asset_file* file,
                        const ty_mesh_file_def* def, ty_closed_mesh** out);
ty_result ty_make_exponential(ty_scene_reader* reader, const ty_json_path* json_path, const ty_exponential_density* def,
                              ty_grid** out);
ty_result ty_make_noise(ty_scene_reader* reader, const ty_json_path* json_path, const ty_noise_def* def, ty_grid** out);
/* Reads a grid of a volume, an object at json_path; grid_name applies unless the volume names a grid. Raw volumes
 * without spacing are refused unless `filling` is true: a box then gives their extent. */
ty_result ty_read_volume(ty_scene_reader* reader, const json_t* volume, const ty_json_path* json_path,
                         const char* grid_name, bool filling, ty_grid** out);
/* The same, with the mean effective radius of droplets, micrometres; unchanged if there are none. */
ty_result ty_read_droplets(ty_scene_reader* reader, const json_t* volume, const ty_json_path* json_path,
                           const char* grid_name, bool filling, double* radius, ty_grid** out);
/* The same for red, green and blue: one grid three times if the volume has one value per voxel. */
ty_result ty_read_volume_rgb(ty_scene_reader* reader, const json_t* volume, const ty_json_path* json_path,
                             const char* grid_name, bool filling, ty_grid* out[3]);
void ty_free_digests(ty_scene_reader* reader);

/* Hashes a file and the existing files that it references: buffers and images of a .gltf, materials and their images
 * of an .obj, the data of an .nhdr. */
ty_result ty_hash_file_and_names(ty_context* context, const char* path, uint64_t* hash);

/* ---- sections of a scene ---- */

/* The nodes of a phase function's table, which a def refers to. */
typedef struct ty_phase_table {
    double cosines[TY_PHASE_NODES_MAX], values[TY_PHASE_NODES_MAX];
} ty_phase_table;

/* Sets the phase function of a medium at path, if it is given otherwise than by g. */
ty_result ty_read_phase(ty_scene_reader* reader, const json_t* medium, const ty_json_path* path, ty_medium_def* def,
                        ty_phase_table* table);
/* Sets sigma_s, sigma_a, g and phase of a medium at path. */
ty_result ty_read_coefficients(ty_scene_reader* reader, const json_t* medium, const ty_json_path* path,
                               ty_medium_def* def, ty_phase_table* table);
/* Sets fields of albedo and g, emission and transfer function. points: an array of TY_TRANSFER_MAX. */
ty_result ty_read_fields(ty_scene_reader* reader, const json_t* medium, const ty_json_path* path, ty_medium_def* def,
                         ty_transfer_point* points);
/* True if the points of the transfer function give the albedo. */
bool ty_transfer_has_albedo(const json_t* medium);
/* Map of a mesh file's points to units of to_unit meters: units, up axis, and item's transform. */
ty_result ty_read_mesh_placement(const ty_scene_reader* reader, const json_t* item, const ty_json_path* path,
                                 double to_unit, ty_mesh_file_def* def);
/* The material under "material" of an item at path, if there is one; *out is a default one. ty_release_material must
 * follow, whatever the result. */
ty_result ty_read_material(ty_scene_reader* reader, const json_t* item, const ty_json_path* path, ty_material_def* out);
void ty_release_material(const ty_material_def* material);
ty_result ty_read_boundary(ty_scene_reader* reader);
ty_result ty_read_camera(ty_scene_reader* reader);
ty_result ty_read_media(ty_scene_reader* reader);
ty_result ty_read_lights(ty_scene_reader* reader);
/* Media of the key `air` of skies. */
ty_result ty_read_sky_air(ty_scene_reader* reader);
ty_result ty_read_geometry(ty_scene_reader* reader);

/* Parses overrides and sets their values in reader->root. ty_free_overrides must follow, even after a failure. */
ty_result ty_apply_overrides(ty_scene_reader* reader, const char* const* texts, int32_t count);
void ty_free_overrides(ty_scene_reader* reader);

#endif
