/* Images from source fields: rays march through the original media, front to back. Once-scattered light uses uncollided
 * light on cells with the true phase function, multiply scattered light a source field; unscattered light is the
 * background: environment, emission of media, or an image of surfaces from the caller. */
#ifndef TY_IMAGE_MARCH_H
#define TY_IMAGE_MARCH_H

#include "direct/single/single.k.h"
#include "direct/single/source_field.h"
#include "image/march/cuts.h"
#include "image/options.h"

#include <tyndall/image.h>

enum { TY_MARCH_LIGHTS_MAX = 16, TY_MARCH_BLUR_CELLS = 32 };
enum { TY_MARCH_AOVS = TY_AOV_TRANSMITTANCE | TY_AOV_SINGLE | TY_AOV_MULTIPLE | TY_AOV_DEPTH };

/* Multiple scattering octaves (Wrenninge, Kulla, Lundqvist 2013, "Oz: The Great and Volumetric"): octave i is single
 * scattering by a^i sigma_s and a phase function of mean cosine c^i g behind b^i sigma_t. */
enum { TY_OCTAVES_MAX = 8 };
typedef struct ty_march_octaves {
    int32_t count;    /* N, octave 0 included, 0..TY_OCTAVES_MAX; below 2 there is single scattering alone */
    bool scales_view; /* b^i scales extinction towards the eye as well as towards the light; needs count >= 2 */
    float scattering[TY_OCTAVES_MAX], extinction[TY_OCTAVES_MAX], anisotropy[TY_OCTAVES_MAX]; /* a^i, b^i, c^i */
    const ty_light_fluence* lights; /* octaves 1 to N - 1, one after the other: each has as many lights as octave 0, of
                                      the same kinds in the same order; their fluence is attenuated by b^i sigma_t */
} ty_march_octaves;

typedef struct ty_irradiance_cache ty_irradiance_cache; /* image/march/irradiance_cache.h */

typedef struct ty_march_def {
    int32_t width, height; /* pixels; must be set */
    int32_t spp;           /* rays per pixel, stratified over it, 1..64; default 1: through its center */
    uint64_t seed;         /* seed of the step offsets */
    double step; /* distance between light lookups: in voxels of the medium, or in cells of the light where those are
                    larger and only density varies between voxels; 0.05..8; default 1. Optical depth is exact at any
                    step. docs/marching.md: cost and bias */
    double bilateral_sigma; /* width of the bilateral weights of cells by relative extinction, see docs/marching.md;
                               default 0.25; 0, or a field without a guide: trilinear interpolation */
    bool preserve_means;    /* true: the interpolant approximately preserves the cell means of the field, so that coarse
                               cells do not blur it, see docs/marching.md; meant for trilinear interpolation; default false
                             */
    uint32_t aovs;          /* of TY_MARCH_AOVS; default 0 */
    int32_t ray_spacing;    /* rays go through every n-th pixel along x and y, 1..8, and pixels between them are
                               interpolated, see docs/marching.md; default 1 */
    int32_t edge_rays;  /* rays of pixels through which edges of media pass that are opaque within about a pixel, 1..64,
                           where ray_spacing is 1; default 1; no fewer than spp */
    int32_t froxels[3]; /* columns, rows and slices of froxels from which pixels are interpolated, see
                           docs/marching.md; then `step`, `ray_spacing` and fields have no effect. 0 (default): rays of
                           pixels march */
    ty_grid_box light_box;          /* lattice of the lights' fluence; unused without lights */
    const ty_light_fluence* lights; /* uncollided light; default none */
    int32_t light_count;            /* 0..TY_MARCH_LIGHTS_MAX */
    bool traces_faces; /* traces these lights through the outer halves of outer cells to the box's faces; false
                          (default): their light there is the cells' mean */
    int32_t reduced; /* order L of the scaled extinction sigma_t - g^L sigma_s that attenuated that light, 1..12 (1, for
                        g above 0 only: a reduced beam); default 0: sigma_t */
    const float* legendre; /* orders 0..13 of the media's common phase function, by which reduced light was attenuated
                              in place of powers of g; NULL (default): none */
    const ty_forward_fit*
        fit; /* fit of a phase function common to all media that is too narrow for L bands: light is delta-scattered by
                fit->forward_fraction instead of g^L, and the field holds its radiance scattered by the fit towards the
                eye, per scattering coefficient, attenuated by the same scaled extinction; NULL (default): none */
    const float*
        blurred; /* with a fit: environment radiance blurred by one scattering within the peak; an octahedral map over
                    view directions, TY_MARCH_BLUR_CELLS cells per side, of R, G, B; NULL (default): none */
    const ty_march_octaves* octaves; /* octaves of the lights, which then have no lobes and are not reduced; light of
                                        octaves 1 and above counts as multiple scattering; NULL (default): none */
    const ty_source_field* field;    /* multiply scattered light; NULL (default): none */
    const ty_source_field* surface_field; /* field that lights surfaces; NULL (default): field */
    const ty_cuts* cuts; /* surfaces between the field's cells, across which it is not interpolated for media; NULL
                            (default): none */
    const ty_irradiance_cache* cache; /* light of media that surfaces outside of the field's box reflect, which lights
                                         other ones there; NULL (default): none */
    const ty_image* unscattered;      /* R, G, B: unscattered radiance, attenuated by media, in the same pixels; NULL
                                         (default): the environment times the transmittance of the media. Surfaces add their
                                         reflection of scattered light in both cases */
    ty_progress_fn progress;
    void* progress_user;
} ty_march_def;

typedef struct ty_march_stats {
    double seconds, cpu_seconds;
    uint64_t steps; /* of all rays together: number of light lookups */
    const char* isa;
} ty_march_stats;

ty_march_def ty_default_march_def(void);
/* Defaults with the given options, and the scene's camera where they do not override it. */
ty_march_def ty_march_def_of(const ty_scene* scene, const ty_image_options* options);

/* Renders the view of the scene's camera: R, G, B and given->aovs, as in ty_path_def.aovs; single holds the
 * once-scattered light of given->lights, multiple that of the field and all reflections. stats may be NULL. Errors:
 * TY_ERROR_ARGUMENT, TY_ERROR_MEMORY; on TY_CANCELLED *out is NULL. */
ty_result ty_march(const ty_scene* scene, const ty_march_def* given, ty_image** out, ty_march_stats* stats);

#endif
