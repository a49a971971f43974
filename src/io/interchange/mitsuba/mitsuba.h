/* Internal interface of the files that read Mitsuba's scenes: XML of versions 0.5 to 3. Facts about the format are
 * those of Mitsuba's documentation of its plugins. */
#ifndef TY_IO_INTERCHANGE_MITSUBA_H
#define TY_IO_INTERCHANGE_MITSUBA_H

#include "io/interchange/conversion.h"
#include "io/interchange/spectrum.h"

enum { TY_MITSUBA_DEPTH_MAX = 24, TY_MITSUBA_LOCATION_SIZE = 512 };

/* ---- tree.c ---- */

/* An element with its attributes: "key\0value\0key\0value\0\0". */
typedef struct ty_mitsuba_node {
    char* tag;
    char* attributes;
    size_t attribute_size;
    int32_t first_child, last_child, next; /* -1: none */
    int32_t file, line;
} ty_mitsuba_node;

typedef struct ty_mitsuba_default {
    char *name, *value;
} ty_mitsuba_default;

typedef struct ty_mitsuba {
    ty_conversion* conversion;
    ty_context* context;
    ty_mitsuba_node* nodes; /* the first is the scene */
    char** files;           /* their names */
    ty_mitsuba_default* defaults;
    char** folders; /* where files are looked for, besides that of the scene */
    int32_t* bsdfs; /* nodes of materials that were made, and their indices */
    int32_t* media; /* likewise */
    size_t node_count, file_count, default_count, folder_count, bsdf_count, medium_count;
    size_t node_capacity, file_capacity, default_capacity, folder_capacity, bsdf_capacity, medium_capacity;
    int32_t depth; /* of references between objects */
} ty_mitsuba;

/* Reads the text with all that it includes. */
ty_result ty_mitsuba_parse(ty_mitsuba* scene, const char* text, size_t size);
void ty_mitsuba_free(ty_mitsuba* scene);
ty_result ty_mitsuba_fail(const ty_mitsuba* scene, int32_t node, const char* format, ...)
    __attribute__((format(printf, 3, 4)));
void ty_mitsuba_location(const ty_mitsuba* scene, int32_t node, char out[TY_MITSUBA_LOCATION_SIZE]);

/* The value of an attribute; NULL without. */
const char* ty_mitsuba_attribute(const ty_mitsuba* scene, int32_t node, const char* key);
/* As is_tag: names compare without underscores and case, so that toWorld is to_world. */
bool ty_mitsuba_same(const char* a, const char* b);
bool ty_mitsuba_is(const ty_mitsuba* scene, int32_t node, const char* tag);
/* The type of an object, "" without. */
const char* ty_mitsuba_type(const ty_mitsuba* scene, int32_t node);
/* The object that a ref names, or the node itself; -1 if there is none. */
int32_t ty_mitsuba_resolve(const ty_mitsuba* scene, int32_t node);
/* The child with a name, resolved; -1 without. */
int32_t ty_mitsuba_child(const ty_mitsuba* scene, int32_t node, const char* name);
/* The first child with a tag, resolved; -1 without. */
int32_t ty_mitsuba_child_of_tag(const ty_mitsuba* scene, int32_t node, const char* tag);
/* Reads a file in the scene's folder, or those of <path>; as ty_conversion_read_file and ty_conversion_find_file. */
ty_result ty_mitsuba_read_file(ty_mitsuba* scene, int32_t node, const char* name, uint8_t** bytes, size_t* size);
/* The name under which the conversion finds a file; freed with ty_free_text. */
char* ty_mitsuba_file_name(const ty_mitsuba* scene, const char* name);

/* ---- values.c ---- */

ty_result ty_mitsuba_float(const ty_mitsuba* scene, int32_t node, const char* name, double* out);
bool ty_mitsuba_bool(const ty_mitsuba* scene, int32_t node, const char* name, bool otherwise);
/* The text of a string, NULL without. */
const char* ty_mitsuba_string(const ty_mitsuba* scene, int32_t node, const char* name);
/* A point or vector by x, y and z or by value. */
ty_result ty_mitsuba_vector(const ty_mitsuba* scene, int32_t node, const char* name, double out[3]);
/* The transform under a name; the identity without. */
ty_result ty_mitsuba_transform(const ty_mitsuba* scene, int32_t node, const char* name, ty_affine* out);
/* A colour under a name: rgb, spectrum or float; light tells that it is emitted. *found is false without, or for other
 * objects. */
ty_result ty_mitsuba_colour(ty_mitsuba* scene, int32_t node, const char* name, bool light, double rgb[3], bool* found);

/* ---- objects ---- */

/* bsdfs.c: index of the material, -1 for none (null). */
ty_result ty_mitsuba_bsdf(ty_mitsuba* scene, int32_t node, int32_t* index);
/* media.c */
ty_result ty_mitsuba_medium(ty_mitsuba* scene, int32_t node, int32_t* index);
/* shapes.c: a shape, whose transform `around` follows. */
ty_result ty_mitsuba_shape(ty_mitsuba* scene, int32_t node, const ty_affine* around);
/* emitters.c: one that is not of a shape. */
ty_result ty_mitsuba_emitter(ty_mitsuba* scene, int32_t node);
/* sensor.c: the camera, and the integrator's and the sampler's numbers. */
ty_result ty_mitsuba_sensor(ty_mitsuba* scene, int32_t node);
ty_result ty_mitsuba_integrator(ty_mitsuba* scene, int32_t node);

/* ---- scene.c ---- */

ty_result ty_read_mitsuba(ty_conversion* conversion, const char* text, size_t size);

#endif
