/* Images from source fields: rays through the scene's media as they are, front to back. What media scatter once comes
 * from uncollided light on cells with the true phase function, the rest from a source field; what never scattered is
 * the background: the sky, the media's own light, or an image of surfaces that a caller hands in. */
#ifndef TY_IMAGE_MARCH_H
#define TY_IMAGE_MARCH_H

#include "direct/single/single.k.h"
#include "direct/single/source_field.h"
#include "image/cuts.h"
#include "image/options.h"

#include <tyndall/path.h>

enum { TY_MARCH_LIGHTS_MAX = 16, TY_MARCH_BLURRED = 32 };
enum { TY_MARCH_AOVS = TY_AOV_TRANSMITTANCE | TY_AOV_SINGLE | TY_AOV_MULTIPLE | TY_AOV_DEPTH };

typedef struct ty_march_def {
    int32_t width, height;          /* pixels; must be set */
    int32_t spp;                    /* rays per pixel, stratified over it, 1..64; default 1: through its middle */
    uint64_t seed;                  /* of where in each ray steps begin */
    double step;                    /* how far apart light is looked up: in voxels of the medium, or in the light's
                                       cells where those are larger and nothing but the density varies from voxel to
                                       voxel; 0.05..8; default 1. Optical depth is exact whatever it is.
                                       docs/marching.md: cost and bias */
    double guided;                  /* how like a cell's extinction must be to that of a place which takes light from
                                       it, see docs/marching.md; default 0.25; 0, or a field without a guide: plain
                                       interpolation */
    bool keeps_means;               /* whether the field's interpolant has, nearly, the means over cells that the field
                                       has, so that coarse cells do not blur it, see docs/marching.md; meant for plain
                                       interpolation; default false */
    uint32_t aovs;                  /* of TY_MARCH_AOVS; default 0 */
    ty_grid_box light_box;          /* the cells that lights lie on; looked at if there are any */
    const ty_light_fluence* lights; /* uncollided light; default none */
    int32_t light_count;            /* 0..TY_MARCH_LIGHTS_MAX */
    int32_t reduced; /* whether that light lost only what scatters aside on its way: L of sigma_t - g^L sigma_s, 1..12
                        (1, g above 0 alone: a reduced beam); default 0: sigma_t */
    const ty_forward_fit*
        fit;              /* the phase function where all media have the same, too narrow for L bands: light goes
                             straight on by fit->forward_fraction, not g^L, and the field has what the fit scatters to the
                             eye, per scattering coefficient, to be seen through the same; NULL (default): none */
    const float* blurred; /* with a fit: environments' radiance, blurred as much as scattering once within the peak
                             does; an octahedral map of ways that one looks along, TY_MARCH_BLURRED cells a side, of
                             R, G, B; NULL (default): none is seen */
    const ty_source_field* field;         /* multiply scattered light; NULL (default): none */
    const ty_source_field* surface_field; /* what of it surfaces are lit by; NULL (default): field */
    const ty_cuts* cuts; /* surfaces between field's cells, across which nothing of it is interpolated for media; NULL
                            (default): none that are known of */
    const ty_image* unscattered; /* R, G, B: radiance that no medium scattered, extinction by media included, in the
                                    same pixels; NULL (default): the environment behind the media's transmittance,
                                    and surfaces show only the scattered light that they reflect, which is there with
                                    an image, too */
    ty_progress_fn progress;
    void* progress_user;
} ty_march_def;

typedef struct ty_march_stats {
    double seconds, cpu_seconds;
    uint64_t steps; /* of all rays together: places where light was looked up */
    const char* isa;
} ty_march_stats;

ty_march_def ty_default_march_def(void);
/* The same with what options say, and the scene's camera where they leave it to that. */
ty_march_def ty_march_def_of(const ty_scene* scene, const ty_image_options* options);

/* Renders what the scene's camera sees: R, G, B and def->aovs, as ty_path_def.aovs has them; single is what lights
 * bring, multiple what the field does, and all that surfaces reflect. stats may be NULL. Errors: TY_ERROR_ARGUMENT,
 * TY_ERROR_MEMORY; on TY_CANCELLED *out is NULL. */
ty_result ty_march(const ty_scene* scene, const ty_march_def* def, ty_image** out, ty_march_stats* stats);

#endif
