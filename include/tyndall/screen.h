/* Tyndall: screen-space scattering, fog or water over one HDR image and its distances. Apache-2.0.
 *
 * After Elek, Ritschel, Seidel: Real-Time Screen-Space Scattering in Homogeneous Environments (2013); equation numbers
 * are the paper's. docs/method/screen.md explains what is computed, how far it holds, and where it departs.
 *
 * The caller owns all memory: planes of colour and distance in, planes of colour out, and a workspace if it likes. */
#ifndef TYNDALL_SCREEN_H
#define TYNDALL_SCREEN_H

#include <tyndall/base.h>
#include <tyndall/scene.h>

#ifdef __cplusplus
extern "C" {
#endif

/* How light is spread. */
typedef enum ty_screen_variant {
    TY_SCREEN_SCATTER = 0,  /* ours: each pixel's light is spread by its own width, per channel, and none is lost */
    TY_SCREEN_GATHER = 1,   /* the paper's: each pixel looks up a masked pyramid at the level of its own distance */
    TY_SCREEN_REFERENCE = 2 /* the exact, spatially varying point spread function, pixel by pixel: slow */
} ty_screen_variant;

/* How far scattered light spreads. */
typedef enum ty_screen_spread {
    TY_SCREEN_SPREAD_SMALL_ANGLE = 0, /* multiple small-angle scattering by Henyey-Greenstein, in closed form: a sharp
                                         core and long tails, as measured against path (docs/method/screen.md). It grows
                                         up to a scattering optical thickness of 76 */
    TY_SCREEN_SPREAD_GAUSSIAN = 1     /* the paper's Gaussian (Eq. 2) */
} ty_screen_spread;

/* What keeps light from leaking out of near pixels into coarse levels (Eq. 7), TY_SCREEN_GATHER only. */
typedef enum ty_screen_mask {
    TY_SCREEN_MASK_NONE = 0,  /* a plain pyramid: the naive method */
    TY_SCREEN_MASK_STEP = 1,  /* all or nothing at the threshold T */
    TY_SCREEN_MASK_SMOOTH = 2 /* smoothstep from T to (1 + mask_width) T */
} ty_screen_mask;

enum { TY_SCREEN_LEVELS_ALL = -2, TY_SCREEN_LEVELS_MAX = 15 };

/* Medium, camera and filter; made by ty_default_screen_def. */
typedef struct ty_screen_def {
    uint32_t cookie; /* set by ty_default_screen_def; checked */
    uint32_t bytes;  /* set by ty_default_screen_def: size of the def */

    /* The medium that fills everything between the camera and what it sees. */
    float sigma_s[3]; /* scattering coefficient, 1/m, >= 0; default 0 */
    float sigma_a[3]; /* absorption coefficient, 1/m, >= 0; default 0 */
    float g[3];       /* mean cosine of the phase function, (-1, 1); default 0 */

    /* Light that the image does not show. environment is the radiance, W m^-2 sr^-1, that arrives at the medium from
     * all around; what of it one scattering sends to the camera is added: environment * sigma_s / sigma_t * (1 -
     * exp(-sigma_t D)). >= 0; default 0. forward is the fraction of the scattered light of the image that still
     * arrives, 0..1; default 1, as the paper has it. ty_screen_balance sets both so that a white furnace stays one. */
    float environment[3];
    float forward[3]; /* as above */

    /* The camera. */
    double focal[2];  /* focal length, pixels, along x and y, > 0; must be set (ty_screen_focal) */
    double center[2]; /* principal point, pixels from the left and top edge; default -1, -1: the middle. Parts of a
                         frame may have it outside */
    bool planar;      /* distances are along the camera's axis (depth), not along each pixel's ray; default false */
    float unknown;    /* m: what pixels without a distance (0, negative, Inf, NaN) are taken to have, such as sky;
                         > 0; default 1e6 */

    ty_screen_variant variant; /* default TY_SCREEN_SCATTER */
    ty_screen_spread spread;   /* TY_SCREEN_SCATTER; the other variants are Gaussian. Default small angles */
    int32_t filter;            /* taps along x and y from one level to the next: 2, 4 or 6; default 4 */
    int32_t levels;            /* K, 1..TY_SCREEN_LEVELS_MAX; TY_AUTO (default): as many as the largest spread needs,
                                  but of Gaussians 6 at most, as in the paper; TY_SCREEN_LEVELS_ALL: as many as it needs. Wider
                                  spreads are cut to what K levels hold. Sides of one pixel end the pyramid */

    /* TY_SCREEN_GATHER alone. The defaults are the paper's method with its masks normalised; ty_screen_naive_def and
     * ty_screen_published_def change them. */
    ty_screen_mask mask;    /* default TY_SCREEN_MASK_SMOOTH */
    float mask_width;       /* epsilon of Eq. 7, > 0; default 0.5 */
    bool luminance_weights; /* Y of Eq. 8 is luminance (else 1); default true */
    bool blurred_distance;  /* levels come from a distance map blurred by its own level (Eq. 11); default true */
    bool normalise;         /* divide by the filtered mask, so that masks take no light away; default true */
    float level_scale;      /* c of Eq. 7 and 10, pixels, > 0; default 0.8 */

    int32_t window; /* TY_SCREEN_REFERENCE: pixels along x and y that a pixel's light reaches, 1..65536; 0 (default):
                       all, to where single precision ends (6 standard deviations) */

    ty_progress_fn progress; /* TY_SCREEN_REFERENCE alone; default NULL */
    void* progress_user;     /* default NULL */
} ty_screen_def;

/* Fills in a ty_screen_def of `bytes` bytes, as ty_init_context_def does. */
TY_API void ty_init_screen_def(void* def, size_t bytes);
/* A def with every field at its default. */
static inline ty_screen_def ty_default_screen_def(void) {
    ty_screen_def def;
    ty_init_screen_def(&def, sizeof def);
    return def;
}
/* Makes a def TY_SCREEN_GATHER without masks, weights and blurred distances: the baseline that leaks. */
TY_API void ty_screen_naive_def(ty_screen_def* def);
/* Makes a def TY_SCREEN_GATHER to the paper's letter: masks that take light away. */
TY_API void ty_screen_published_def(ty_screen_def* def);
/* The focal length in pixels of a picture `height` pixels high with a full vertical angle of view, degrees. */
TY_API double ty_screen_focal(int32_t height, double fov_y);
/* Sets forward to the fraction of light that the phase function sends into the forward half space, and environment to
 * what is left of the radiance around. */
TY_API void ty_screen_balance(ty_screen_def* def, const float radiance[3]);

/* Where pixels lie: channel c of pixel (x, y) is data[c][y * row + x * step]. */
typedef struct ty_screen_planes {
    float* data[3];      /* R, G, B */
    ptrdiff_t step, row; /* floats; planar RGB: 1, width; interleaved RGBA: 4, 4 * width */
} ty_screen_planes;

/* What is read and written. */
typedef struct ty_screen_image {
    int32_t width, height;   /* 1..65536 */
    ty_screen_planes color;  /* I: radiance, linear Rec.709; read only. Negative values and NaN count as 0, +Inf
                                as the largest half, 65504; where there is a medium, so do values above 1e29 */
    const float* distance;   /* D, m */
    ptrdiff_t distance_step; /* floats; as in ty_screen_planes */
    ptrdiff_t distance_row;  /* floats from row to row */
    ty_screen_planes out;    /* J; may be the planes of color */
} ty_screen_image;

/* What a call did. */
typedef struct ty_screen_stats {
    double seconds;         /* wall clock, of the whole call */
    double step_seconds[3]; /* attenuation (Eq. 3-5), filtering (Eq. 6-9), composition (Eq. 10-12) */
    int32_t levels;         /* K that was used */
    double spread;          /* largest radius within which half of a pixel's scattered light falls, pixels, before it
                               was cut */
    double held;            /* the largest such radius that K levels hold; twice as large with each level more */
    int64_t cut;            /* pixels whose spread was wider than that: by variance (Gaussian), or for more than half of
                               the light (small angles) */
    int64_t mended;         /* pixels with a value that was negative or not finite */
    int64_t unknown;        /* pixels without a distance */
    double bytes;           /* that the passes read and wrote, each plane counted once a pass */
    const char* isa;        /* which build of the kernels ran, as in ty_path_stats */
} ty_screen_stats;

/* Bytes of workspace that a call needs; 0 if a size is wrong, or a field of the def that it depends on. */
TY_API size_t ty_screen_workspace(const ty_context* context, const ty_screen_def* def, int32_t width, int32_t height);

/* J of Eq. 12. workspace: at least ty_screen_workspace bytes, aligned to 64, and then nothing is allocated; or NULL,
 * and it is taken from the context. Without a medium and environment, valid pixels come back bit for bit. stats may be
 * NULL. Errors: TY_ERROR_ARGUMENT, TY_ERROR_MEMORY; TY_CANCELLED (reference) leaves out undefined. */
TY_API ty_result ty_screen_apply(ty_context* context, const ty_screen_def* def, const ty_screen_image* image,
                                 void* workspace, size_t workspace_size, ty_screen_stats* stats);

/* What the filter starts from: attenuated I' (Eq. 3), scattered I0 (Eq. 4), spread: the radius, pixels, within which
 * half of a pixel's scattered light falls, per channel (Eq. 5: 1.18 standard deviations). attenuated has in it what the
 * environment adds. Any may be NULL; planes as image->out is laid out, which itself is not touched. Errors:
 * TY_ERROR_ARGUMENT, TY_ERROR_MEMORY. */
TY_API ty_result ty_screen_split(ty_context* context, const ty_screen_def* def, const ty_screen_image* image,
                                 float* const attenuated[3], float* const scattered[3], float* const spread[3]);

/* Fills pixels without a distance from the known ones around them, the near ones first (a push-pull pyramid): for depth
 * sensors, whose holes are not sky. distance: width * height floats, changed in place. *filled: how many were, 0 when
 * none is known. Errors: TY_ERROR_ARGUMENT, TY_ERROR_MEMORY. */
TY_API ty_result ty_screen_fill_distance(ty_context* context, int32_t width, int32_t height, float* distance,
                                         int64_t* filled);

/* ---- Scenes: what is held against ty_path_render ---- */

/* Sets medium, focal length, principal point and planar as a committed scene has them, for pictures of its camera that
 * are `height` pixels high (0: its own resolution). Coefficients of media add; g is their mean, weighted by sigma_s.
 * That a medium glows is warned of and else ignored. Errors: TY_ERROR_ARGUMENT (a medium is not homogeneous). */
TY_API ty_result ty_screen_set_scene(const ty_scene* scene, int32_t height, ty_screen_def* def);
/* Turns distances from the camera to surfaces, m, along the rays through pixels' centres (0: to none) into the part of
 * them that is inside the scene's media; several media are weighted so that the optical depth stays. Warns where the
 * camera is outside of a medium, or media fill different spaces. distance: width * height floats, changed in place.
 * Errors: TY_ERROR_ARGUMENT. */
TY_API ty_result ty_screen_scene_distance(const ty_scene* scene, int32_t width, int32_t height, float* distance);

#ifdef __cplusplus
}
#endif
#endif
