/* Internal interface of the files that read scenes of pbrt, version 4. Facts about the format and its units are those
 * of "Physically Based Rendering", 4th edition, and of pbrt-v4's documentation of its input files. */
#ifndef TY_IO_INTERCHANGE_PBRT_H
#define TY_IO_INTERCHANGE_PBRT_H

#include "io/interchange/conversion.h"
#include "io/interchange/spectrum.h"

enum { TY_PBRT_DEPTH_MAX = 32, TY_PBRT_NAME_SIZE = 128, TY_PBRT_STACK_MAX = 4096 };

/* ---- tokens.c ---- */

typedef struct ty_pbrt_text {
    const char *at, *end;
    int32_t line;
    int32_t file; /* index of the file, for messages */
} ty_pbrt_text;

typedef enum ty_pbrt_token_kind {
    TY_PBRT_END,
    TY_PBRT_WORD,
    TY_PBRT_STRING,
    TY_PBRT_OPEN,
    TY_PBRT_CLOSE,
    TY_PBRT_BROKEN /* a string without an end */
} ty_pbrt_token_kind;

typedef struct ty_pbrt_token {
    ty_pbrt_token_kind kind;
    const char* text; /* strings: what stands between the quotes */
    size_t length;
    int32_t line;
} ty_pbrt_token;

ty_pbrt_token ty_pbrt_next(ty_pbrt_text* text);
bool ty_pbrt_is(const ty_pbrt_token* token, const char* word);
/* The number that a whole word is; false for others. */
bool ty_pbrt_number(const ty_pbrt_token* token, double* out);

/* ---- parameters.c ---- */

typedef enum ty_pbrt_type {
    TY_PBRT_INTEGER,
    TY_PBRT_FLOAT,
    TY_PBRT_POINT2,
    TY_PBRT_POINT3,
    TY_PBRT_VECTOR2,
    TY_PBRT_VECTOR3,
    TY_PBRT_NORMAL,
    TY_PBRT_RGB,
    TY_PBRT_BLACKBODY,
    TY_PBRT_SPECTRUM,
    TY_PBRT_TEXT,
    TY_PBRT_BOOL,
    TY_PBRT_TEXTURE,
    TY_PBRT_TYPES
} ty_pbrt_type;

typedef struct ty_pbrt_parameter {
    ty_pbrt_type type;
    char name[TY_PBRT_NAME_SIZE];
    int32_t file, line;
    double* numbers;
    ty_pbrt_token* strings; /* also of bools */
    size_t number_count, number_capacity, string_count, string_capacity;
    bool used;
} ty_pbrt_parameter;

struct ty_pbrt;

/* The parameters of one directive, and behind them those that Attribute set for its kind. */
typedef struct ty_pbrt_parameters {
    struct ty_pbrt* reader;
    int32_t file, line; /* of the directive */
    char type[TY_PBRT_NAME_SIZE];
    ty_pbrt_parameter* items;
    size_t count, capacity;
} ty_pbrt_parameters;

/* Appends the parameters that follow in the text. */
ty_result ty_pbrt_read_parameters(struct ty_pbrt* reader, ty_pbrt_text* text, ty_pbrt_parameters* out);
void ty_pbrt_free_parameters(ty_pbrt_parameters* parameters);
/* Notes those that nothing has read. kind: "Shape". */
void ty_pbrt_note_unused(const ty_pbrt_parameters* parameters, const char* kind);

/* The first parameter of a name, which is marked as used; NULL without. */
const ty_pbrt_parameter* ty_pbrt_find(const ty_pbrt_parameters* parameters, const char* name);
double ty_pbrt_float(const ty_pbrt_parameters* parameters, const char* name, double otherwise);
int32_t ty_pbrt_int(const ty_pbrt_parameters* parameters, const char* name, int32_t otherwise);
bool ty_pbrt_bool(const ty_pbrt_parameters* parameters, const char* name, bool otherwise);
/* A string, cut to size; otherwise "". True if there is one. */
bool ty_pbrt_string(const ty_pbrt_parameters* parameters, const char* name, char* out, size_t size);
void ty_pbrt_point(const ty_pbrt_parameters* parameters, const char* name, double out[3]);

/* ---- spectra.c ---- */

typedef enum ty_pbrt_role {
    TY_PBRT_LIGHT,      /* luminance 1, but for rgb, which is as given */
    TY_PBRT_REFLECTANCE /* also coefficients */
} ty_pbrt_role;

/* The colour of a spectrum; *found tells whether there is one, and rgb is as it was if not. */
ty_result ty_pbrt_spectrum(const ty_pbrt_parameters* parameters, const char* name, ty_pbrt_role role, double rgb[3],
                           bool* found);
/* Its values at 650, 550 and 450 nm, as for indices of refraction. */
ty_result ty_pbrt_spectrum_at(const ty_pbrt_parameters* parameters, const char* name, double values[3], bool* found);

/* ---- reader.c, transforms.c ---- */

/* The kinds of directives for which Attribute may set parameters. */
typedef enum ty_pbrt_target {
    TY_PBRT_SHAPE,
    TY_PBRT_LIGHTS,
    TY_PBRT_MATERIAL,
    TY_PBRT_MEDIUM,
    TY_PBRT_TEXTURES,
    TY_PBRT_TARGETS
} ty_pbrt_target;

enum { TY_PBRT_ATTRIBUTES_MAX = 8 };

/* An area light: emitted radiance, or with `power` a colour to scale to that power. */
typedef struct ty_pbrt_area_light {
    bool on, two_sided;
    double radiance[3], power; /* power: 0 without */
} ty_pbrt_area_light;

typedef struct ty_pbrt_state {
    ty_affine ctm;
    bool transform_only; /* pushed by TransformBegin */
    bool reverse;
    int32_t material;
    int32_t inside, outside; /* media, or -1 */
    ty_pbrt_area_light area;
    char color_space[16];
    ty_pbrt_text attributes[TY_PBRT_TARGETS][TY_PBRT_ATTRIBUTES_MAX];
    int32_t attribute_counts[TY_PBRT_TARGETS];
} ty_pbrt_state;

typedef struct ty_pbrt_source {
    char* name;
    uint8_t* bytes; /* NULL: they belong to the caller */
    size_t size;
} ty_pbrt_source;

/* A texture's value: a colour, or an image times a colour. */
typedef struct ty_pbrt_texture {
    char name[TY_PBRT_NAME_SIZE];
    bool number; /* a float texture */
    char* file;  /* NULL: constant */
    double color[3];
    bool inverted, linear;
    double uv_map[4];
} ty_pbrt_texture;

typedef struct ty_pbrt_name {
    char name[TY_PBRT_NAME_SIZE];
    int32_t index;
} ty_pbrt_name;

typedef struct ty_pbrt_frame {
    char name[TY_PBRT_NAME_SIZE];
    ty_affine ctm;
} ty_pbrt_frame;

/* A range of recorded meshes of an object. */
typedef struct ty_pbrt_object {
    char name[TY_PBRT_NAME_SIZE];
    size_t first, count; /* of `recorded` */
} ty_pbrt_object;

typedef struct ty_pbrt {
    ty_conversion* conversion;
    ty_context* context;
    ty_pbrt_source* sources;
    ty_pbrt_state* stack; /* the current state is the last */
    ty_pbrt_texture* textures;
    ty_pbrt_name* materials;
    ty_pbrt_name* media;
    ty_pbrt_frame* frames;
    ty_pbrt_object* objects;
    size_t* recorded; /* meshes */
    size_t source_count, stack_count, texture_count, material_count, medium_count, frame_count, object_count,
        recorded_count;
    size_t source_capacity, stack_capacity, texture_capacity, material_capacity, medium_capacity, frame_capacity,
        object_capacity, recorded_capacity;
    int32_t depth;
    bool world; /* after WorldBegin */
    bool has_camera, has_film;
    bool in_object;
    bool later_time;           /* transforms of the end time alone */
    ty_affine mirror;          /* of the world, so that it is right-handed */
    double fov, screen_height; /* of the perspective camera: angle of the shorter axis, and half height of the screen */
    double frame_aspect;
    int32_t resolution[2];
    double crop[4];
    double exposure_time, iso;
} ty_pbrt;

static inline ty_pbrt_state* ty_pbrt_now(const ty_pbrt* reader) {
    return &reader->stack[reader->stack_count - 1];
}
/* The current transform into our scene. */
ty_affine ty_pbrt_world(const ty_pbrt* reader);
/* Reads `count` numbers, which may stand in brackets. */
ty_result ty_pbrt_numbers(ty_pbrt* reader, ty_pbrt_text* text, int count, double* out);
/* Carries out a directive of a transform; *known is false for other directives. */
ty_result ty_pbrt_transform(ty_pbrt* reader, ty_pbrt_text* text, const ty_pbrt_token* word, bool* known);
/* Fails with "file:line: ...". */
ty_result ty_pbrt_fail(const ty_pbrt* reader, int32_t file, int32_t line, const char* format, ...)
    __attribute__((format(printf, 4, 5)));
/* The same of a directive. */
ty_result ty_pbrt_refuse(const ty_pbrt_parameters* parameters, const char* format, ...)
    __attribute__((format(printf, 2, 3)));
/* "file:line" of a directive or a parameter. */
void ty_pbrt_location(const ty_pbrt* reader, int32_t file, int32_t line, char* out, size_t size);
/* The index that belongs to a name, the latest one; -1 without. */
int32_t ty_pbrt_find_name(const ty_pbrt_name* names, size_t count, const char* name);

/* Reads a scene; text is followed by a zero byte. */
ty_result ty_read_pbrt(ty_conversion* conversion, const char* text, size_t size);

/* ---- directives by file: shapes.c, lights.c, media.c, materials.c, textures.c, film.c ---- */

ty_result ty_pbrt_shape(ty_pbrt* reader, const ty_pbrt_parameters* parameters);
ty_result ty_pbrt_instance(ty_pbrt* reader, const ty_pbrt_object* object);
ty_result ty_pbrt_light(ty_pbrt* reader, const ty_pbrt_parameters* parameters);
ty_result ty_pbrt_area(ty_pbrt* reader, const ty_pbrt_parameters* parameters);
ty_result ty_pbrt_medium(ty_pbrt* reader, const ty_pbrt_parameters* parameters, const char* name);
/* *index is -1 for the interface material. */
ty_result ty_pbrt_material(ty_pbrt* reader, const ty_pbrt_parameters* parameters, int32_t* index);
ty_result ty_pbrt_read_texture(ty_pbrt* reader, const ty_pbrt_parameters* parameters, const char* name, bool number);
const ty_pbrt_texture* ty_pbrt_find_texture(const ty_pbrt* reader, const char* name, bool number);
ty_result ty_pbrt_camera(ty_pbrt* reader, const ty_pbrt_parameters* parameters);
ty_result ty_pbrt_film(ty_pbrt* reader, const ty_pbrt_parameters* parameters);
ty_result ty_pbrt_sampler(ty_pbrt* reader, const ty_pbrt_parameters* parameters);
ty_result ty_pbrt_integrator(ty_pbrt* reader, const ty_pbrt_parameters* parameters);
/* Completes the camera once its film is known. */
ty_result ty_pbrt_finish_camera(ty_pbrt* reader);

/* ---- environment.c ---- */

/* A square image in equal-area octahedral mapping as an equirectangular map; light: of light space into our scene. */
ty_result ty_pbrt_environment(ty_pbrt* reader, const char* location, const char* name, const ty_affine* light,
                              double* upper_illuminance, char** reference);

#endif
