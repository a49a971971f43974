/* What the parts of the scene file reader share: where they read, how they report, and the files a scene names. */
#ifndef TY_IO_SCENE_READER_H
#define TY_IO_SCENE_READER_H

#include "io/json_locate.h"

#include <jansson.h>
#include <tyndall/grid.h>
#include <tyndall/image.h>
#include <tyndall/scene.h>

typedef struct ty_scene_override {
    const char* text; /* "media[0].g=0.5", borrowed */
    char* keys;       /* what path's keys lie in */
    size_t keys_size;
    ty_json_path path;
} ty_scene_override;

/* A file the scene names, read once. */
typedef struct ty_scene_asset {
    char* path;
    char* grid_name; /* of volumes */
    ty_grid* grid;   /* owned; NULL for images */
    ty_image* image; /* owned; NULL for volumes */
} ty_scene_asset;

typedef struct ty_scene_reader {
    ty_context* context;
    bool clean;         /* the context had no message before */
    const char* name;   /* of the file, in messages */
    const char* folder; /* where relative paths start; NULL: the scene may name no files */
    const char* text;
    size_t length;
    json_t* root; /* after overrides */
    ty_scene_override* overrides;
    int32_t override_count;
    ty_scene* scene;
    double unit; /* metres */
    ty_axis up_axis;
    uint64_t hash;
    ty_scene_asset* assets;
    size_t asset_count, asset_capacity;
} ty_scene_reader;

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
/* The map under "transform", identity when absent, taking points in units of from_unit metres to metres. */
ty_result ty_read_transform(const ty_scene_reader* reader, const json_t* object, const ty_json_path* path,
                            double from_unit, ty_affine* out);

/* Files, read once and kept by the reader. path is the place of the key that names the file. */
ty_result ty_read_volume(ty_scene_reader* reader, const ty_json_path* path, const char* file, const char* grid_name,
                         ty_grid** out);
ty_result ty_read_map(ty_scene_reader* reader, const ty_json_path* path, const char* file, const ty_image** out);

/* The sections of a scene. */
ty_result ty_read_media(ty_scene_reader* reader);
ty_result ty_read_lights(ty_scene_reader* reader);
ty_result ty_read_geometry(ty_scene_reader* reader);

/* Takes overrides apart and sets their values in reader->root. Failed or not, ty_free_overrides follows. */
ty_result ty_apply_overrides(ty_scene_reader* reader, const char* const* texts, int32_t count);
void ty_free_overrides(ty_scene_reader* reader);

#endif
