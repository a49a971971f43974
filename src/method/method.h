/* The methods that render scenes, as one table for the library and the command line. A method lives in its own folder,
 * which defines one ty_method, and has one line in registry.h. */
#ifndef TY_METHOD_METHOD_H
#define TY_METHOD_METHOD_H

#include "option/option.h"

#include <tyndall/method.h>
#include <tyndall/path.h>

/* A request that every method understands; options of single methods come from the scene. */
typedef struct ty_render_request {
    int32_t spp; /* of paths: those of method path, and of the surfaces that other methods start from */
    uint64_t seed;
    double seconds, error;   /* bounds of method path; 0: none */
    int32_t width, height;   /* 0: the camera's resolution */
    int32_t crop[4];         /* x, y, width, height; 0: the whole frame */
    uint32_t aovs;           /* TY_AOV_... */
    ty_progress_fn progress; /* NULL: none */
    void* progress_user;
    ty_path_state_fn state; /* method path, as in ty_path_def */
    void* state_user;
    double state_seconds;
    const void* resume;
    size_t resume_size;
} ty_render_request;

enum { TY_METHOD_STATS_MAX = 1024 };

/* Measurements of one rendering. */
typedef struct ty_method_run {
    ty_path_stats path; /* of the paths that were traced; its seconds are those of everything */
    double own_seconds; /* without the path-traced image that the method starts from */
    _Alignas(16) char stats[TY_METHOD_STATS_MAX]; /* the method's own stats struct */
} ty_method_run;

typedef enum ty_stat_type {
    TY_STAT_INT,     /* int32_t */
    TY_STAT_LONG,    /* int64_t */
    TY_STAT_NUMBER,  /* double */
    TY_STAT_BOOL,    /* bool */
    TY_STAT_TEXT,    /* const char* */
    TY_STAT_LATTICES /* `count` lattices: int32_t sizes[count][3], and their cells at second_offset */
} ty_stat_type;

/* One field of a method's stats struct. */
typedef struct ty_stat {
    const char* name; /* "march_seconds"; of a stage it ends in "_seconds" */
    size_t offset;
    ty_stat_type type;
    int32_t count;        /* of an array; 0: a single value */
    bool stage;           /* seconds that are part of the whole, and of no other stage */
    size_t second_offset; /* TY_STAT_LATTICES: double cells[count] */
} ty_stat;

typedef struct ty_method {
    const char* name;
    const char* summary;
    const ty_option_table* options; /* its name is the key in `render`; NULL: none */
    uint32_t aovs;                  /* channels that the method has */
    bool crops;                     /* renders parts of the frame */
    const ty_stat* stats;           /* fields of the own stats struct, in the order of reports; NULL: none */
    int32_t stat_count;
    /* Refuses scenes that the method is not made for; NULL: takes all. */
    ty_result (*check)(const ty_scene* scene);
    /* Results as of ty_path_render, but for TY_CANCELLED with *out NULL when a part is no picture. */
    ty_result (*render)(const ty_scene* scene, const ty_render_request* request, ty_image** out, ty_method_run* run);
    /* Writes the closing line's text, for example "32x32x32 cells, 1.2 s"; NULL: a line about paths. */
    void (*describe)(const ty_method_run* run, char* text, size_t size);
} ty_method;

/* The name and the place of a field, for tables of ty_stat. */
#define TY_STAT_FIELD(type, field) .name = #field, .offset = offsetof(type, field)

/* All methods, ended by NULL. */
extern const ty_method* const ty_methods[];
/* The method of a name; NULL if there is none. */
const ty_method* ty_method_find(const char* name);

/* Fields that the defs of all methods have under the same names, taken from a request. */
#define TY_TAKE_REQUEST(def, request)                                                                                  \
    do {                                                                                                               \
        (def)->seed = (request)->seed;                                                                                 \
        (def)->width = (request)->width;                                                                               \
        (def)->height = (request)->height;                                                                             \
        (def)->aovs = (request)->aovs & ~(uint32_t)TY_AOV_SAMPLES;                                                     \
        (def)->progress = (request)->progress;                                                                         \
        (def)->progress_user = (request)->progress_user;                                                               \
    } while (0)

/* The def that paths are traced with: the scene's options and the request. Errors: those of ty_method_options. */
ty_result ty_request_path_def(const ty_scene* scene, const ty_render_request* request, ty_path_def* def);
/* The light that the scene's surfaces send through its media, for ty_fld_def.unscattered and the like; *out stays NULL
 * where there are no surfaces, and when the work is interrupted, since a part is no picture. Fills in run->path. */
ty_result ty_trace_surfaces(const ty_scene* scene, const ty_render_request* request, ty_image** out,
                            ty_method_run* run);

#endif
