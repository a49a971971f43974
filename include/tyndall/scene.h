/* Tyndall: what is lit: media, lights, surfaces, camera. Apache-2.0.
 *
 * Units: metres, W m^-2 (irradiance), W sr^-1 (intensity), W m^-2 sr^-1 (radiance), 1/m (coefficients);
 * colours are linear Rec.709. Directions are the way the light travels. Right-handed axes.
 * A scene is filled with add calls, then committed once; committed scenes may be rendered from any thread. */
#ifndef TYNDALL_SCENE_H
#define TYNDALL_SCENE_H

#include <tyndall/base.h>
#include <tyndall/grid.h>
#include <tyndall/image.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct ty_scene ty_scene;

typedef enum ty_axis { TY_AXIS_Y = 1, TY_AXIS_Z = 2 } ty_axis;

typedef struct ty_camera_def {
    uint32_t cookie;       /* set by ty_default_camera_def; checked */
    double position[3];    /* m; default (0, 0, 5) */
    double target[3];      /* m, not at position; default (0, 0, 0) */
    double up[3];          /* not along the view; default (0, 1, 0) */
    double fov_y;          /* full vertical angle, degrees, (0, 180); default 40 */
    int32_t resolution[2]; /* width, height, 1..65536; default 800 x 600 */
    double exposure;       /* stops, for display only; default 0 */
} ty_camera_def;

typedef enum ty_bounds_kind { TY_BOUNDS_NONE = 0, TY_BOUNDS_BOX = 1, TY_BOUNDS_SPHERE = 2 } ty_bounds_kind;

/* Participating medium. sigma(x) = density(x) * scale * coefficient, and zero outside the bounds.
 * Media may overlap: their coefficients add. */
typedef struct ty_medium_def {
    uint32_t cookie;         /* set by ty_default_medium_def; checked */
    const char* name;        /* default ""; copied */
    ty_bounds_kind bounds;   /* what a homogeneous medium or an unplaced grid fills, and where a placed grid is cut;
                                default TY_BOUNDS_NONE (allowed for placed grids only) */
    double box_min[3];       /* m, before transform */
    double box_max[3];       /* m, each above box_min */
    double sphere_center[3]; /* m, before transform */
    double sphere_radius;    /* m, > 0 */
    ty_affine transform;     /* applied to bounds and grid; default identity */
    ty_grid* density_grid;   /* retained; NULL (default): density is 1 everywhere within bounds */
    float sigma_s[3];        /* scattering coefficient at density 1, 1/m, >= 0; default 0 */
    float sigma_a[3];        /* absorption coefficient at density 1, 1/m, >= 0; default 0 */
    float scale;             /* multiplies density, >= 0; default 1 */
    float g[3];              /* Henyey-Greenstein mean cosine, (-1, 1); default 0 */
} ty_medium_def;

/* Sets sigma_s, sigma_a and g from a measured medium by name ("wholemilk": letters and digits count, case does
 * not). The measurements give reduced scattering, so g is set to 0. Returns false, def untouched, if unknown. */
TY_API bool ty_medium_preset(const char* name, ty_medium_def* def);
TY_API int32_t ty_medium_preset_count(void);
/* The name of a preset as published ("Wholemilk"), in table order; NULL past the end. */
TY_API const char* ty_medium_preset_name(int32_t index);

typedef enum ty_light_kind {
    TY_LIGHT_DIRECTIONAL = 0, /* direction, color = irradiance on a plane facing it */
    TY_LIGHT_POINT = 1,       /* position, color = intensity */
    TY_LIGHT_SPOT = 2,        /* position, direction, cone, penumbra, color = intensity on the axis */
    TY_LIGHT_AREA = 3,        /* origin, u, v; emits on the u x v side; color = radiance */
    TY_LIGHT_ENVIRONMENT = 4  /* image or constant; color = radiance (constant) */
} ty_light_kind;

typedef struct ty_light_def {
    uint32_t cookie;       /* set by ty_default_light_def; checked */
    ty_light_kind kind;    /* default TY_LIGHT_DIRECTIONAL */
    float color[3];        /* see ty_light_kind; >= 0, finite; default 1 */
    double direction[3];   /* not zero; default (0, -1, 0) */
    double position[3];    /* m; default 0. Area lights: the corner u and v start from */
    double u[3], v[3];     /* m, area lights; default 0 */
    double cone;           /* full outer angle, degrees, (0, 180]; default 40 */
    double penumbra;       /* fraction of the half angle over which the spot fades, 0..1; default 0.15 */
    const ty_image* image; /* environment: equirectangular RGB, seen from inside, not mirrored, centre along +x; copied.
                              Default NULL: constant */
    float scale;           /* environment: multiplies the image or color, >= 0; default 1 */
    double rotation;       /* degrees about the up axis, counter-clockwise seen from above; default 0 */
} ty_light_def;

typedef enum ty_shape_kind { TY_SHAPE_QUAD = 0, TY_SHAPE_BOX = 1, TY_SHAPE_SPHERE = 2 } ty_shape_kind;

/* A Lambertian surface, reflecting on both sides, emitting on its front only (u x v, or outwards). */
typedef struct ty_shape_def {
    uint32_t cookie;     /* set by ty_default_shape_def; checked */
    ty_shape_kind kind;  /* default TY_SHAPE_QUAD */
    double origin[3];    /* m; quad: corner; box: lower corner; sphere: centre */
    double u[3], v[3];   /* m; quad: edges; box: u is the upper corner */
    double radius;       /* m, sphere, > 0 */
    ty_affine transform; /* default identity; spheres take rotation, translation and uniform scale only */
    float albedo[3];     /* 0..1; default 0.5 */
    float emission[3];   /* radiance, W m^-2 sr^-1, >= 0; default 0 */
} ty_shape_def;

/* Sky seen from the ground: sunlight scattered once in a spherical Rayleigh + Mie + ozone atmosphere (as Nishita et
 * al. 1993 set it up), and further times as if isotropically (Hillaire 2020); absolute radiance per channel for a given
 * solar irradiance. */
typedef struct ty_sky_def {
    uint32_t cookie;         /* set by ty_default_sky_def; checked */
    double sun_direction[3]; /* the way sunlight travels, not zero; default (-0.5, -0.6, -0.4) */
    float solar[3];          /* irradiance above the atmosphere, W m^-2 per channel; default (1.00, 1.00, 1.00) * 1.5 */
    double haze;             /* aerosol amount, 0 (clear) .. 10; default 1 */
    float ground[3];         /* ground albedo, seen below the horizon; 0..1; default 0.2 */
    ty_axis up_axis;         /* default TY_AXIS_Y */
    int32_t width;           /* of the equirectangular image, even, 16..8192; default 512; height is half */
} ty_sky_def;

TY_API ty_camera_def ty_default_camera_def(void);
TY_API ty_medium_def ty_default_medium_def(void);
TY_API ty_light_def ty_default_light_def(void);
TY_API ty_shape_def ty_default_shape_def(void);
TY_API ty_sky_def ty_default_sky_def(void);

/* Makes the sky image (R, G, B) for an environment light, and the sun's irradiance at the ground, W m^-2.
 * Errors: TY_ERROR_ARGUMENT, TY_ERROR_MEMORY. */
TY_API ty_result ty_sky_image(ty_context* context, const ty_sky_def* def, ty_image** out, float sun_irradiance[3]);

TY_API ty_result ty_scene_create(ty_context* context, ty_axis up_axis, ty_scene** out);
TY_API void ty_scene_destroy(ty_scene* scene);

/* Each copies its def. Errors: TY_ERROR_ARGUMENT (with the field and its range), TY_ERROR_MEMORY. */
TY_API ty_result ty_scene_set_camera(ty_scene* scene, const ty_camera_def* def);
TY_API ty_result ty_scene_add_medium(ty_scene* scene, const ty_medium_def* def);
TY_API ty_result ty_scene_add_light(ty_scene* scene, const ty_light_def* def);
TY_API ty_result ty_scene_add_shape(ty_scene* scene, const ty_shape_def* def);

/* Builds what rendering needs: ray tracing structures, majorants, light tables. Further add calls need another
 * commit. Errors: TY_ERROR_MEMORY, TY_ERROR_INTERNAL. */
TY_API ty_result ty_scene_commit(ty_scene* scene);

TY_API ty_context* ty_scene_context(const ty_scene* scene);
TY_API ty_axis ty_scene_up_axis(const ty_scene* scene);
TY_API ty_camera_def ty_scene_camera(const ty_scene* scene);

/* What `render` in a scene file asked for; defaults when a scene was built by calls. */
typedef struct ty_render_settings {
    char method[16];   /* "path" */
    int32_t spp;       /* samples per pixel, 1..2^24; default 64 */
    uint64_t seed;     /* default 0 */
    int32_t max_depth; /* path: scatterings and reflections at most; 0 (default) for unlimited */
} ty_render_settings;

TY_API ty_render_settings ty_scene_render_settings(const ty_scene* scene);
TY_API void ty_scene_set_render_settings(ty_scene* scene, const ty_render_settings* settings);

/* A hash of the scene's content (file text after overrides, and the bytes of every file it names); 0 when the
 * scene was built by calls. */
TY_API uint64_t ty_scene_hash(const ty_scene* scene);
TY_API void ty_scene_set_hash(ty_scene* scene, uint64_t hash);

/* Counts and memory, for reports. */
typedef struct ty_scene_info {
    int32_t media, lights, shapes;
    bool bounded;              /* whether anything has a place */
    double lower[3], upper[3]; /* box around media and surfaces, m */
    size_t bytes;              /* memory of grids, tables and ray tracing structures */
} ty_scene_info;

TY_API ty_scene_info ty_scene_get_info(const ty_scene* scene);
/* One medium as added, with its grid (not retained for the caller); TY_ERROR_ARGUMENT past the end. */
TY_API ty_result ty_scene_get_medium(const ty_scene* scene, int32_t index, ty_medium_def* out);

#ifdef __cplusplus
}
#endif
#endif
