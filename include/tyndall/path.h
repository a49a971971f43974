/* Tyndall: the truth, unbiased volumetric path tracing. Apache-2.0.
 *
 * docs/method/path.md explains what is computed and how. The result does not depend on the number of threads. */
#ifndef TYNDALL_PATH_H
#define TYNDALL_PATH_H

#include <tyndall/base.h>
#include <tyndall/grid.h>
#include <tyndall/image.h>
#include <tyndall/scene.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Channels beside R, G and B. All are means over a pixel's samples. */
enum {
    TY_AOV_VARIANCE = 1,      /* variance.R, .G, .B: of the pixel's mean */
    TY_AOV_TRANSMITTANCE = 2, /* transmittance.R, .G, .B: of the media as far as the first surface */
    TY_AOV_DEPTH = 4,         /* depth.Z: distance from the camera to the first surface along the ray, m; the mean over
                                 the samples that hit one, 0 where none did */
    TY_AOV_NORMAL = 8,        /* normal.X, .Y, .Z: of the first surface, facing the camera, unit length; 0 for none */
    TY_AOV_ALBEDO = 16,       /* albedo.R, .G, .B: the fraction of the light that media scatter before the first
                                 surface, so that (1 - transmittance - albedo) is absorbed and albedo /
                                 (1 - transmittance) is the volume albedo that is seen */
    TY_AOV_SINGLE = 32,       /* single.R, .G, .B: radiance scattered once by a medium and touched by nothing else */
    TY_AOV_MULTIPLE = 64,     /* multiple.R, .G, .B: all other radiance that a medium scattered. What is left of
                                 R, G, B after single and multiple never scattered: emission and surfaces */
    TY_AOV_SAMPLES = 128,     /* samples.N: how many; they differ between pixels only in a partial result */
    TY_AOV_ALL = 255
};

/* Takes the state of a render, bytes that only ty_path_def.resume understands; false cancels the work. Called from any
 * thread, but never twice at a time nor while the progress function runs; other threads go on meanwhile. */
typedef bool (*ty_path_state_fn)(void* user, const void* state, size_t size);

/* How paths are traced; made by ty_default_path_def. */
typedef struct ty_path_def {
    uint32_t cookie;       /* set by ty_default_path_def; checked */
    uint32_t bytes;        /* set by ty_default_path_def: size of the def */
    int32_t spp;           /* samples per pixel (ray, cell) at most, 1..2^24; default 64 */
    uint64_t seed;         /* any; images of different seeds are independent; default 0 */
    int32_t max_depth;     /* scatterings and reflections at most; 0 (default) for unlimited with Russian roulette */
    bool ignore_media;     /* everything as if the scene had no media, bit for bit; default false */
    bool unscattered;      /* only light that no medium scattered or sent: lamps, the sky and surfaces, which reflect
                              each other's light, all behind the media's extinction; R, G, B less single, multiple
                              and what media send. The channels single and multiple are 0. Without media, or with
                              ignore_media, it changes nothing; default false */
    double seconds;        /* stop after this time, > 0; 0 (default): no bound */
    double error;          /* stop when the estimated relative error (standard error of the pixels, root mean
                              square, over the mean) is below this, > 0; 0 (default): no bound */
    int32_t width, height; /* 0 (default): the camera's resolution. Both or neither */
    uint32_t aovs;         /* images: TY_AOV_... together; default TY_AOV_VARIANCE */
    int32_t crop[4];       /* images: x, y, width, height of the part of the frame to render; the pixels are those
                              of the whole frame, bit for bit. Default 0: the whole frame */
    /* Images: every state_seconds (and at the end) the state of the work is handed out; resume takes it up again.
     * A resumed render gives the same image, bit for bit, as one that was never interrupted, with the same spp, seed,
     * size, crop, aovs, max_depth, ignore_media, unscattered and scene, on a machine with the same instruction set
     * (ty_path_stats.isa); spp may also be larger than before. Time that earlier runs took counts for seconds and in
     * ty_path_stats. Memory: 56 bytes a pixel for the state, 216 with aovs other than variance and samples, and the
     * same for the work itself. */
    ty_path_state_fn state;  /* default NULL */
    void* state_user;        /* passed on to state; default NULL */
    double state_seconds;    /* default 60 */
    const void* resume;      /* default NULL; errors: TY_ERROR_INPUT (damaged, or of another render, told how) */
    size_t resume_size;      /* bytes; default 0 */
    ty_progress_fn progress; /* default NULL */
    void* progress_user;     /* default NULL */
} ty_path_def;

/* Fills in a ty_path_def of `bytes` bytes, as ty_init_context_def does. */
TY_API void ty_init_path_def(void* def, size_t bytes);
/* A def with every field at its default. */
static inline ty_path_def ty_default_path_def(void) {
    ty_path_def def;
    ty_init_path_def(&def, sizeof def);
    return def;
}

/* What a run did; with what runs did that it resumed. */
typedef struct ty_path_stats {
    double seconds;     /* wall clock */
    double cpu_seconds; /* over all threads */
    double spp;         /* mean samples per pixel */
    double error;       /* estimated relative error, as in ty_path_def */
    uint64_t paths;     /* paths traced */
    uint64_t vertices;  /* scatterings and reflections */
    const char* isa;    /* "x86-64", "x86-64-v3", "x86-64-v4" or "generic": which build of the kernel ran */
} ty_path_stats;

/* Radiance through each pixel of the scene's camera: R, G, B, and what def->aovs asks for. On TY_CANCELLED *out is a
 * valid image with fewer samples. stats may be NULL.
 * Errors: TY_ERROR_ARGUMENT, TY_ERROR_INPUT (def->resume), TY_ERROR_MEMORY. */
TY_API ty_result ty_path_render(const ty_scene* scene, const ty_path_def* def, ty_image** out, ty_path_stats* stats);

/* Radiance arriving along given rays. rays: count x 6 doubles (origin, m; direction of view, any length);
 * radiance: count x 3, mean over def->spp samples; variance: count x 3, variance of that mean, or NULL. A ray meets a
 * surface with TY_ALPHA_BLEND either in all samples or in none.
 * Errors: TY_ERROR_ARGUMENT, TY_ERROR_MEMORY; TY_CANCELLED leaves the outputs undefined. */
TY_API ty_result ty_path_radiance(const ty_scene* scene, const ty_path_def* def, int64_t count, const double* rays,
                                  double* radiance, double* variance);

/* Fluence (integral of radiance over all directions, W m^-2) averaged over each cell of a box of size[0] x size[1]
 * x size[2] cells from lower to upper (m): total, and uncollided light alone if uncollided is not NULL.
 * fluence, uncollided, variance (of the total; may be NULL): cells x 3, x fastest. A box without extent along an
 * axis (lower == upper) gives the fluence on that plane, line or point.
 * Errors: TY_ERROR_ARGUMENT, TY_ERROR_MEMORY; TY_CANCELLED leaves the outputs undefined. */
TY_API ty_result ty_path_fluence(const ty_scene* scene, const ty_path_def* def, const double lower[3],
                                 const double upper[3], const int32_t size[3], double* fluence, double* uncollided,
                                 double* variance);

/* Transmittance exp(-optical depth) per channel of the media between two points, surfaces ignored: the mean of
 * def->spp ratio-tracked estimates (exact where media are homogeneous).
 * Errors: TY_ERROR_ARGUMENT. */
TY_API ty_result ty_path_transmittance(const ty_scene* scene, const ty_path_def* def, const double from[3],
                                       const double to[3], double transmittance[3]);

#ifdef __cplusplus
}
#endif
#endif
