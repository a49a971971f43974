/* Methods whose light is solved once and rendered from any camera: the parts of ty_NAME_solve, ty_NAME_view,
 * ty_NAME_render and of the registry's render that are the same in all of them. */
#ifndef TY_METHOD_VOLUME_METHOD_H
#define TY_METHOD_VOLUME_METHOD_H

#include "base/progress.h"
#include "image/march/march.h"
#include "method/method.h"

/* Fields that the defs of these methods have in this order, from `seed` to `progress_user`. */
typedef struct ty_volume_options {
    uint64_t seed;
    int32_t width, height, spp;
    double step;
    uint32_t aovs;
    const ty_image* unscattered;
    ty_progress_fn progress;
    void* progress_user;
} ty_volume_options;

/* One call in progress. */
typedef struct ty_volume_call {
    ty_context* context;
    const ty_scene* scene;
    const void* def; /* checked copy of the caller's */
    ty_volume_options options;
    int32_t ray_spacing; /* pixels */
    ty_part_progress progress;
    double fraction; /* the solve's fraction of the caller's progress */
    void* light;     /* the method's; all zero when a solve begins */
    void* stats;     /* the method's */
    void* extra;     /* what the method's own calls ask for besides; NULL */
} ty_volume_call;

typedef struct ty_volume_method {
    const char* name;
    const ty_option_table* table;
    size_t options_at;                                        /* offset of ty_volume_options in the def */
    size_t spacing_at;                                        /* offset of ray_spacing in the def */
    size_t light_bytes;                                       /* size of the light */
    const char* stats_function;                               /* name of the function that makes the stats */
    size_t stats_bytes, seconds, march_seconds, isa;          /* size of the stats, and offsets of their fields */
    double solve_fraction;                                    /* the solve's fraction of a render's progress */
    ty_result (*check)(ty_context* context, const void* def); /* beyond ranges; NULL: nothing */
    ty_result (*solve)(ty_volume_call* call);
    ty_result (*view)(ty_volume_call* call, ty_image** out);
    void (*free_camera)(void* def); /* the def of light that other cameras view, too; NULL: the same */
    void (*coarsen)(void* def,
                    ty_solve_quality quality); /* the def of a solve coarser than TY_SOLVE_FULL; NULL: the same */
    void (*destroy)(void* light);
    bool diffuses;      /* media inside dielectrics are solved by diffusion; false: by ordinates */
    size_t start_at;    /* offset of the light to start from in the def; 0: none */
    size_t interior_at; /* offset of interior_resolution in the def; 0: none, and TY_AUTO */
    bool repeats;       /* solves scenes that repeat, of which it makes no images */
} ty_volume_method;

/* The fields of a ty_volume_method that follow from the method's name. */
#define TY_VOLUME_METHOD(method)                                                                                       \
    .name = #method, .table = &ty_##method##_options, .options_at = offsetof(ty_##method##_def, seed),                 \
    .spacing_at = offsetof(ty_##method##_def, ray_spacing), .light_bytes = sizeof(ty_##method),                        \
    .stats_function = "ty_default_" #method "_stats", .stats_bytes = sizeof(ty_##method##_stats),                      \
    .seconds = offsetof(ty_##method##_stats, seconds), .march_seconds = offsetof(ty_##method##_stats, march_seconds),  \
    .isa = offsetof(ty_##method##_stats, isa), .destroy = destroy_volume

enum { TY_VOLUME_DEF_MAX = 512 };

/* Copies a caller's def to own, of the library's size, with all ranges checked. Errors: TY_ERROR_ARGUMENT. */
ty_result ty_volume_take_def(const ty_volume_method* method, ty_context* context, const void* def, void* own);

/* ty_NAME_solve, ty_NAME_view and ty_NAME_render without their types. stats may be NULL, and is written on success
 * (by ty_volume_render, once the light is solved). */
ty_result ty_volume_solve(const ty_volume_method* method, const ty_scene* scene, const void* def, void** out,
                          void* stats);
/* The same with ty_volume_call.extra. */
ty_result ty_volume_solve_for(const ty_volume_method* method, const ty_scene* scene, const void* def, void* extra,
                              void** out, void* stats);
ty_result ty_volume_view(const ty_volume_method* method, const void* light, const ty_scene* scene, const void* def,
                         ty_image** out, void* stats);
ty_result ty_volume_render(const ty_volume_method* method, const ty_scene* scene, const void* def, ty_image** out,
                           void* stats);
/* ty_method.render: path-traced surfaces under the light of media. change: alters the def; NULL: nothing. */
ty_result ty_volume_method_render(const ty_volume_method* method, void (*change)(void* def), const ty_scene* scene,
                                  const ty_render_request* request, ty_image** out, ty_method_run* run);

/* ty_method.solve and view. */
ty_result ty_volume_method_solve(const ty_volume_method* method, void (*change)(void* def), const ty_scene* scene,
                                 const ty_render_request* request, ty_solve_quality quality, void** light,
                                 ty_method_run* run);
ty_result ty_volume_method_view(const ty_volume_method* method, void (*change)(void* def), const void* light,
                                const ty_scene* scene, const ty_render_request* request, const ty_image* unscattered,
                                ty_image** out, ty_method_run* run);
/* ty_method.enclose. */
ty_result ty_volume_method_enclose(const ty_volume_method* method, const ty_scene* scene,
                                   const ty_render_request* request, ty_solve_quality quality, ty_enclosed** out,
                                   ty_enclosed_stats* stats);
#define TY_VOLUME_OF_INTERIORS "media in dielectrics light other media as without a surface"
/* Defines ty_method's functions of the method `name` on ty_volume_method `volume`; change: see above. */
#define TY_DEFINE_VOLUME_METHOD(name, volume, change)                                                                  \
    static ty_result render_##name(const ty_scene* scene, const ty_render_request* request, ty_image** out,            \
                                   ty_method_run* run) {                                                               \
        return ty_volume_method_render(&(volume), change, scene, request, out, run);                                   \
    }                                                                                                                  \
    static ty_result solve_##name(const ty_scene* scene, const ty_render_request* request, ty_solve_quality quality,   \
                                  void** light, ty_method_run* run) {                                                  \
        return ty_volume_method_solve(&(volume), change, scene, request, quality, light, run);                         \
    }                                                                                                                  \
    static ty_result view_##name(const void* light, const ty_scene* scene, const ty_render_request* request,           \
                                 const ty_image* unscattered, ty_image** out, ty_method_run* run) {                    \
        return ty_volume_method_view(&(volume), change, light, scene, request, unscattered, out, run);                 \
    }                                                                                                                  \
    static ty_result enclose_##name(const ty_scene* scene, const ty_render_request* request, ty_solve_quality quality, \
                                    ty_enclosed** out, ty_enclosed_stats* done) {                                      \
        return ty_volume_method_enclose(&(volume), scene, request, quality, out, done);                                \
    }                                                                                                                  \
    static void destroy_##name(void* light) {                                                                          \
        (volume).destroy(light);                                                                                       \
    }                                                                                                                  \
    _Static_assert(true, "")
/* The fields of ty_method that TY_DEFINE_VOLUME_METHOD makes. */
#define TY_VOLUME_METHOD_CALLS(name)                                                                                   \
    .render = render_##name, .solve = solve_##name, .view = view_##name, .destroy = destroy_##name,                    \
    .takes_surfaces = true, .enclose = enclose_##name, .of_interiors = TY_VOLUME_OF_INTERIORS

/* Defines ty_NAME_solve, ty_NAME_view and ty_NAME_render of a method whose ty_volume_method is ty_volume_NAME, and
 * checks what TY_VOLUME_METHOD assumes of its def and stats. */
#define TY_DEFINE_VOLUME_CALLS(method)                                                                                 \
    ty_result ty_##method##_solve(const ty_scene* scene, const ty_##method##_def* def, ty_##method** out,              \
                                  ty_##method##_stats* stats) {                                                        \
        void* light;                                                                                                   \
        const ty_result result = ty_volume_solve(&ty_volume_##method, scene, def, &light, stats);                      \
        *out = light;                                                                                                  \
        return result;                                                                                                 \
    }                                                                                                                  \
    ty_result ty_##method##_view(const ty_##method* light, const ty_scene* scene, const ty_##method##_def* def,        \
                                 ty_image** out, ty_##method##_stats* stats) {                                         \
        return ty_volume_view(&ty_volume_##method, light, scene, def, out, stats);                                     \
    }                                                                                                                  \
    ty_result ty_##method##_render(const ty_scene* scene, const ty_##method##_def* def, ty_image** out,                \
                                   ty_##method##_stats* stats) {                                                       \
        return ty_volume_render(&ty_volume_##method, scene, def, out, stats);                                          \
    }                                                                                                                  \
    static void destroy_volume(void* light) {                                                                          \
        ty_##method##_destroy(light);                                                                                  \
    }                                                                                                                  \
    _Static_assert(sizeof(ty_##method##_def) <= TY_VOLUME_DEF_MAX, "a call holds the def");                            \
    _Static_assert(sizeof(ty_##method##_stats) <= TY_METHOD_STATS_MAX, "ty_method_run holds the stats");               \
    _Static_assert(offsetof(ty_##method##_def, unscattered) - offsetof(ty_##method##_def, seed) ==                     \
                       offsetof(ty_volume_options, unscattered),                                                       \
                   "the order of ty_volume_options");                                                                  \
    _Static_assert(offsetof(ty_##method##_def, progress_user) - offsetof(ty_##method##_def, seed) ==                   \
                       offsetof(ty_volume_options, progress_user),                                                     \
                   "the order of ty_volume_options")

/* Defines run_stage of a method's job, which has a member `progress`: one stage of a solve, up to the fraction `until`
 * of the caller's progress, and its time in seconds. */
#define TY_DEFINE_RUN_STAGE(job_type)                                                                                  \
    static ty_result run_stage(job_type* job, const char* stage, double until, ty_result (*run)(job_type * job),       \
                               double* seconds) {                                                                      \
        const double begun = ty_wall_seconds();                                                                        \
        ty_result result = ty_part_next(&job->progress, stage, until);                                                 \
        if (result == TY_OK) result = run(job);                                                                        \
        *seconds = ty_wall_seconds() - begun;                                                                          \
        return result;                                                                                                 \
    }                                                                                                                  \
    _Static_assert(true, "")

/* The marcher's def with the camera, channels, surfaces and progress of a call. */
ty_march_def ty_volume_march_def(ty_volume_call* call);

#endif
