/* A scene of another renderer that becomes a scene file: readers of formats fill a ty_conversion, which writes the
 * scene file and the meshes, volumes and images beside it, and keeps notes about what is left out or approximated. */
#ifndef TY_IO_INTERCHANGE_CONVERSION_H
#define TY_IO_INTERCHANGE_CONVERSION_H

#include "io/meshes/model.h"

#include <jansson.h>
#include <tyndall/io.h>

/* A surface's material. */
typedef struct ty_conversion_material {
    json_t* keys;     /* of a scene file's material; NULL: no surface, only a boundary of media */
    bool textured;    /* its textures need texture coordinates */
    double uv_map[4]; /* scale of u and v, and their offsets */
    int32_t medium;   /* what fills the surface by the material itself, or -1 */
    uint64_t hash;    /* of the keys; set when it is added */
} ty_conversion_material;

/* A medium, which surfaces or its grid bound. */
typedef struct ty_conversion_medium {
    char* name;
    json_t* entries;      /* media of a scene file, without bounds and transform, whose coefficients add */
    bool grid;            /* its volume has a place of its own */
    bool clipped;         /* the box cuts the volume */
    double box[2][3];     /* what the grid fills, in its own space */
    ty_affine transform;  /* of the grid's space into the scene */
    bool inside, outside; /* where surfaces have it */
    bool camera;          /* the camera is in it */
} ty_conversion_medium;

/* Surfaces of one material, emission and medium inside; they become one file. A dielectric with a medium inside is a
 * part of its own. */
typedef struct ty_conversion_part {
    int32_t material, medium; /* medium: -1 without */
    double emission[3];
} ty_conversion_part;

typedef struct ty_conversion_mesh {
    ty_model_mesh mesh;
    int32_t part;
} ty_conversion_mesh;

typedef struct ty_conversion_instance {
    size_t mesh;
    ty_affine transform;
} ty_conversion_instance;

typedef struct ty_conversion_sphere {
    int32_t part;
    double center[3], radius;
} ty_conversion_sphere;

typedef struct ty_conversion_note {
    char* text;
    int32_t count;
} ty_conversion_note;

enum { TY_CONVERSION_NOTES_MAX = 500 };

typedef struct ty_conversion {
    ty_context* context;
    const char* input;  /* for messages */
    const char* folder; /* of the files that the input names; NULL: none may be named */
    const char* output; /* the scene file; NULL: nothing is written */
    bool partial;       /* files that cannot be read are left out */
    char* files;        /* the folder beside the output, and its name within the scene file */
    char* files_name;
    bool files_made;
    int32_t file_count;
    json_t *camera, *lights, *render; /* camera and render may be NULL */
    ty_conversion_material* materials;
    ty_conversion_medium* media;
    ty_conversion_part* parts;
    ty_conversion_mesh* meshes;
    ty_conversion_instance* instances;
    ty_conversion_sphere* spheres;
    ty_conversion_note* notes;
    size_t material_count, medium_count, part_count, mesh_count, instance_count, sphere_count, note_count;
    size_t material_capacity, medium_capacity, part_capacity, mesh_capacity, instance_capacity, sphere_capacity,
        note_capacity;
    int64_t triangles; /* over all instances */
} ty_conversion;

/* ---- conversion.c ---- */

/* The conversion is closed again if this fails. */
ty_result ty_conversion_open(ty_conversion* conversion, ty_context* context, const char* input, const char* folder,
                             const char* output);
void ty_conversion_close(ty_conversion* conversion);
/* Keep a note of a part that the scene file has not, or has only nearly; the same text again is counted. */
void ty_conversion_leave_out(ty_conversion* conversion, const char* format, ...) __attribute__((format(printf, 2, 3)));
void ty_conversion_approximate(ty_conversion* conversion, const char* format, ...)
    __attribute__((format(printf, 2, 3)));
/* A note as one line: "left out: shape "curve" (2 times)". */
void ty_conversion_print_note(const ty_conversion_note* note, char* line, size_t size);

/* Fails for want of memory. */
ty_result ty_conversion_no_memory(ty_conversion* conversion);
/* Sets a key of an object; takes over the value, also on failure, and fails without one. */
ty_result ty_conversion_set(ty_conversion* conversion, json_t* object, const char* key, json_t* value);

/* Each takes over what it is given, also on failure; *index is its index, which equal materials share. */
ty_result ty_conversion_add_material(ty_conversion* conversion, ty_conversion_material* material, int32_t* index);
ty_result ty_conversion_add_medium(ty_conversion* conversion, ty_conversion_medium* medium, int32_t* index);
ty_result ty_conversion_add_light(ty_conversion* conversion, json_t* light);
/* The part that surfaces belong to, made if there is none. */
ty_result ty_conversion_find_part(ty_conversion* conversion, int32_t material, int32_t medium, const double emission[3],
                                  int32_t* index);
/* Adds a mesh without instances. */
ty_result ty_conversion_add_mesh(ty_conversion* conversion, int32_t part, ty_model_mesh* mesh, size_t* index);
ty_result ty_conversion_add_instance(ty_conversion* conversion, size_t mesh, const ty_affine* transform);
ty_result ty_conversion_add_sphere(ty_conversion* conversion, int32_t part, const double center[3], double radius);

/* Numbers as JSON: one if all are equal (n above 1), and arrays. */
json_t* ty_conversion_colour(const double rgb[3], double low, double high);
json_t* ty_conversion_vector(const double* values, int count);
json_t* ty_conversion_transform(const ty_affine* transform);

/* ---- conversion_files.c ---- */

/* Reads a file that the input names, inflated if it is a gzip file; freed with ty_free_file. *bytes is NULL, and a note
 * tells, if it cannot be read and the conversion is partial. location stands before messages. */
ty_result ty_conversion_read_file(ty_conversion* conversion, const char* location, const char* name, uint8_t** bytes,
                                  size_t* size);
/* Path of a file that the input names, and its name in the scene file; freed with ty_free_text. With a partial
 * conversion *path is NULL, and a note tells, if there is no such file. */
ty_result ty_conversion_find_file(ty_conversion* conversion, const char* location, const char* name, char** path,
                                  char** reference);
/* A new file beside the output: its path and its name in the scene file; freed with ty_free_text. Both are NULL
 * without an output. */
ty_result ty_conversion_new_file(ty_conversion* conversion, const char* kind, const char* extension, char** path,
                                 char** reference);
/* Writes an environment's map, or the samples of a texture, as a new file; *reference as above. */
ty_result ty_conversion_write_exr(ty_conversion* conversion, const ty_image* image, char** reference);
/* linear: the image's values are stored as they are, not encoded as sRGB. */
ty_result ty_conversion_write_png(ty_conversion* conversion, ty_image* image, bool linear, char** reference);
/* Writes values x fastest, in a box, as a new volume named after its grid. */
ty_result ty_conversion_write_volume(ty_conversion* conversion, const char* grid, const int32_t size[3],
                                     const float* const values[3], int components, const double box[2][3],
                                     char** reference);

/* ---- conversion_glb.c ---- */

/* Writes the meshes of a part as a new GLB file; count is set to its triangles. */
ty_result ty_conversion_write_part(ty_conversion* conversion, int32_t part, char** reference);
/* A scene file's quad, if the part is a single parallelogram without textures; else NULL. */
json_t* ty_conversion_part_quad(const ty_conversion* conversion, int32_t part);

/* ---- conversion_media.c ---- */

/* Adds the media of the scene file. files: the name of the file of each part, or NULL. */
ty_result ty_conversion_place_media(ty_conversion* conversion, char* const* files, json_t* media);
/* The box around all that the scene holds; false if there is nothing. */
bool ty_conversion_box(const ty_conversion* conversion, double box[2][3]);

/* ---- conversion_write.c ---- */

/* Writes the meshes; *text is the scene file, freed with ty_free_text. */
ty_result ty_conversion_finish(ty_conversion* conversion, char** text);

#endif
