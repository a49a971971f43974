/* The methods that render scenes, as one table for the library and the command line. A method lives in its own folder,
 * which defines one ty_method, and has one line in registry.h. */
#ifndef TY_METHOD_METHOD_H
#define TY_METHOD_METHOD_H

#include "option/option.h"
#include "solve/enclosed/enclosed.h"

#include <tyndall/method.h>
#include <tyndall/path.h>

/* A request common to all methods; options of single methods come from the scene. */
typedef struct ty_render_request {
    int32_t spp; /* path samples per pixel: of method path, and of the surfaces of other methods */
    uint64_t seed;
    double seconds, error;   /* limits of method path; 0: none */
    int32_t width, height;   /* 0: the camera's resolution */
    int32_t ray_spacing;     /* of `view`, pixels, where the method's own is smaller and it has one; 0: its own */
    int32_t crop[4];         /* x, y, width, height; 0: the whole frame */
    uint32_t aovs;           /* TY_AOV_... */
    ty_progress_fn progress; /* NULL: none */
    void* progress_user;
    ty_path_state_fn state; /* method path, as in ty_path_def */
    void* state_user;
    ty_path_state_fn state_change;
    double state_seconds;
    const void* resume;
    size_t resume_size;
    ty_path_partial_fn partial; /* method path, as in ty_path_def */
    void* partial_user;
    void** light; /* methods that start from the light of another frame: that light, or NULL, and then this frame's,
                     which is freed with `destroy`; one that another grid makes useless is freed, too. NULL: none */
} ty_render_request;

/* The accuracy of a solve: TY_SOLVE_COARSE, for a scene that changes while it is shown, takes the method's options with
 * fewer cells, directions and samples where they ask for more; TY_SOLVE_COARSEST with half as many along each axis. */
typedef enum ty_solve_quality {
    TY_SOLVE_COARSEST,
    TY_SOLVE_COARSE,
    TY_SOLVE_FULL,
    TY_SOLVE_QUALITIES
} ty_solve_quality;

/* The bound of a number of cells along an axis in a solve of a coarse quality. */
static inline int32_t ty_coarse_bound(ty_solve_quality quality, int32_t bound) {
    return quality == TY_SOLVE_COARSEST ? bound / 2 : bound;
}

enum { TY_METHOD_STATS_MAX = 1024 };

/* Measurements of one rendering. */
typedef struct ty_method_run {
    ty_path_stats path;          /* stats of the path tracer; its seconds are those of the whole rendering */
    double own_seconds;          /* seconds without the path-traced image of the surfaces */
    bool enclosed;               /* all media fill dielectrics, which that image shows, and nothing else was computed */
    ty_enclosed_stats interiors; /* of media in dielectrics */
    _Alignas(16) char stats[TY_METHOD_STATS_MAX]; /* the method's own stats struct */
} ty_method_run;

/* The method's own stats struct, of `bytes`, all 0. */
static inline void* ty_method_stats(ty_method_run* run, size_t bytes) {
    ty_init_stats(run->stats, bytes);
    return run->stats;
}

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
    bool stage;           /* seconds of a stage of the rendering, disjoint from all other stages */
    size_t second_offset; /* TY_STAT_LATTICES: double cells[count] */
} ty_stat;

typedef struct ty_method {
    const char* name;
    const char* summary;
    const ty_option_table* options; /* option table, whose name is the key in `render`; NULL: none */
    uint32_t aovs;                  /* supported channels, TY_AOV_... */
    bool crops;                     /* supports crops of the frame */
    const ty_stat* stats;           /* fields of the own stats struct, in the order of reports; NULL: none */
    int32_t stat_count;
    /* Fails for scenes that the method does not support; NULL: supports all. */
    ty_result (*check)(const ty_scene* scene);
    /* Results like ty_path_render, except that *out is NULL on TY_CANCELLED where a partial result is no image. */
    ty_result (*render)(const ty_scene* scene, const ty_render_request* request, ty_image** out, ty_method_run* run);
    /* `render` in two parts, for images of one light from many cameras: NULL in methods that cannot. solve: *light is
     * freed with destroy, and NULL on failure. view: scene is the solved one, or one like it except for its camera;
     * unscattered: the surfaces as by ty_trace_surfaces in the request's size, or NULL. run receives the stats of the
     * part. follows_camera: true if the light holds for the scene's present camera alone; NULL: never. */
    ty_result (*solve)(const ty_scene* scene, const ty_render_request* request, ty_solve_quality quality, void** light,
                       ty_method_run* run);
    ty_result (*view)(const void* light, const ty_scene* scene, const ty_render_request* request,
                      const ty_image* unscattered, ty_image** out, ty_method_run* run);
    void (*destroy)(void* light);
    bool (*follows_camera)(const ty_scene* scene);
    const char* of_interiors; /* a sentence on what it does not see of solid dielectrics; NULL: nothing */
    bool divides;             /* all ranks of a command solve together */
    bool takes_surfaces;      /* view shows surfaces by `unscattered` alone */
    /* Solves media inside dielectrics, which the surfaces of such a method show (ty_trace_surfaces): *out is freed with
     * ty_enclosed_destroy, and NULL on failure and without any. NULL in methods without `takes_surfaces`. */
    ty_result (*enclose)(const ty_scene* scene, const ty_render_request* request, ty_solve_quality quality,
                         ty_enclosed** out, ty_enclosed_stats* stats);
    /* Writes the closing line's text, for example "32x32x32 cells, 1.2 s"; NULL: a line about paths. */
    void (*describe)(const ty_method_run* run, char* text, size_t size);
} ty_method;

/* The name and the offset of a field, for tables of ty_stat. */
#define TY_STAT_FIELD(type, field) .name = #field, .offset = offsetof(type, field)

/* All methods, ended by NULL. */
extern const ty_method* const ty_methods[];
/* The method of a name, or NULL. */
const ty_method* ty_method_find(const char* name);

/* The sentence on what a method does not see of the scene's solid dielectrics; NULL: it sees all. */
const char* ty_method_of_interiors(const ty_method* method, const ty_scene* scene);

/* Copies from a request the fields that all methods' defs have under the same names. */
#define TY_TAKE_REQUEST(def, request)                                                                                  \
    do {                                                                                                               \
        (def)->seed = (request)->seed;                                                                                 \
        (def)->width = (request)->width;                                                                               \
        (def)->height = (request)->height;                                                                             \
        (def)->aovs = (request)->aovs & ~(uint32_t)TY_AOV_SAMPLES;                                                     \
        (def)->progress = (request)->progress;                                                                         \
        (def)->progress_user = (request)->progress_user;                                                               \
    } while (0)

/* The def of the path tracer from the scene's options and the request. Errors: those of ty_method_options. */
ty_result ty_request_path_def(const ty_scene* scene, const ty_render_request* request, ty_path_def* def);
/* Media inside dielectrics, as ty_path_solve_enclosed, with the request's seed and progress. */
ty_result ty_solve_enclosed(const ty_scene* scene, const ty_render_request* request, const ty_enclosed_def* def,
                            ty_enclosed** out, ty_enclosed_stats* stats);
/* The image of the surfaces, attenuated by the media, for ty_fld_def.unscattered and the like; *out stays NULL without
 * surfaces, and after an interruption, because a partial result is no image. Media that fill dielectrics show the light
 * of `fields`. Sets run->path. */
ty_result ty_trace_surfaces(const ty_scene* scene, const ty_render_request* request, const ty_enclosed_field* fields,
                            ty_image** out, ty_method_run* run);

#endif
