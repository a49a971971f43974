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

/* Media, lights, surfaces and a camera. */
typedef struct ty_scene ty_scene;

/* Which way is up. */
typedef enum ty_axis { TY_AXIS_Y = 1, TY_AXIS_Z = 2 } ty_axis;

/* A pinhole camera; made by ty_default_camera_def. */
typedef struct ty_camera_def {
    uint32_t cookie;       /* set by ty_default_camera_def; checked */
    double position[3];    /* m; default (0, 0, 5) */
    double target[3];      /* m, not at position; default (0, 0, 0) */
    double up[3];          /* not along the view; default (0, 1, 0) */
    double fov_y;          /* full vertical angle, degrees, (0, 180); default 40 */
    int32_t resolution[2]; /* width, height, 1..65536; default 800 x 600 */
    double exposure;       /* stops, for display only; default 0 */
} ty_camera_def;

/* What shape a medium is bounded by. */
typedef enum ty_bounds_kind {
    TY_BOUNDS_NONE = 0,
    TY_BOUNDS_BOX = 1,
    TY_BOUNDS_SPHERE = 2,
    TY_BOUNDS_SHELL = 3
} ty_bounds_kind;

/* A closed triangle mesh that a medium fills. A point is inside where more surfaces lead out than in, so orientation
 * matters and shells may nest or overlap. */
typedef struct ty_closed_mesh ty_closed_mesh;

/* positions: 3 floats per vertex; indices: 3 per triangle, counter-clockwise seen from outside. Both are copied. Edges
 * that triangles do not pass as often one way as the other are counted in a warning: rays through such holes see the
 * medium end late or early. Of the places where a ray crosses the mesh the nearest 64 count.
 * Errors: TY_ERROR_ARGUMENT (no triangle, an index past the end, a position not finite), TY_ERROR_MEMORY. */
TY_API ty_result ty_closed_mesh_create(ty_context* context, const float* positions, int64_t vertex_count,
                                       const uint32_t* indices, int64_t triangle_count, ty_closed_mesh** out);
/* Adds an owner, and returns the shell. NULL is allowed. */
TY_API ty_closed_mesh* ty_closed_mesh_retain(ty_closed_mesh* shell);
/* Removes an owner; the last one frees the shell. NULL is allowed. */
TY_API void ty_closed_mesh_release(ty_closed_mesh* shell);

/* One point of a transfer function. Between points density and albedo are linear in the value; beyond the ends they
 * stay as they are there. */
typedef struct ty_transfer_point {
    float value;     /* of the grid; each above the one before */
    float density;   /* >= 0; takes the place of the grid's value */
    float albedo[3]; /* 0..1; takes the place of sigma_s / (sigma_s + sigma_a) if the def says so */
} ty_transfer_point;

enum { TY_TRANSFER_MAX = 256 };

/* Participating medium. sigma(x) = density(x) * scale * coefficient, and zero outside the bounds. density is the
 * grid's trilinear value, or the transfer function of that value. Media may overlap: their coefficients add. */
typedef struct ty_medium_def {
    uint32_t cookie;         /* set by ty_default_medium_def; checked */
    const char* name;        /* default ""; copied */
    ty_bounds_kind bounds;   /* what a homogeneous medium or an unplaced grid fills, and where a placed grid is cut;
                                default TY_BOUNDS_NONE (allowed for placed grids only) */
    double box_min[3];       /* m, before transform */
    double box_max[3];       /* m, each above box_min */
    double sphere_center[3]; /* m, before transform */
    double sphere_radius;    /* m, > 0 */
    ty_closed_mesh* shell;   /* TY_BOUNDS_SHELL, m, before transform; retained; default NULL */
    ty_affine transform;     /* applied to bounds and grids; default identity */
    ty_grid* density_grid;   /* retained; NULL (default): density is 1 everywhere within bounds */
    float sigma_s[3];        /* scattering coefficient at density 1, 1/m, >= 0; default 0 */
    float sigma_a[3];        /* absorption coefficient at density 1, 1/m, >= 0; default 0 */
    float scale;             /* multiplies density, >= 0; default 1 */
    float g[3];              /* Henyey-Greenstein mean cosine, (-1, 1); default 0 */

    const ty_transfer_point* transfer; /* density_grid only; copied; default NULL */
    int32_t transfer_count;            /* 0 (default), or 2..TY_TRANSFER_MAX */
    bool transfer_albedo;              /* whether the points' albedo counts; default false */

    /* Fields, each retained, each placed like the density grid; default NULL. Outside a placed field its background
     * holds. */
    ty_grid* albedo_grid[3]; /* single-scattering albedo per channel, clamped to 0..1: splits sigma_s + sigma_a anew.
                                All three or none; they may be one grid. Not together with transfer_albedo */
    ty_grid* g_grid;         /* mean cosine for all channels, clamped to (-1, 1); takes the place of g */

    /* Emission: absorbing matter glows, sending absorption coefficient * emission per metre, W m^-3 sr^-1; a thick
     * box of it has the radiance `emission`. */
    float emission[3];         /* radiance, W m^-2 sr^-1, >= 0; default 0 */
    ty_grid* temperature_grid; /* adds black-body radiance (ty_blackbody) times emission_scale; default NULL */
    double kelvin[2];          /* temperature where the grid is 0 and where it is 1, linear in between and beyond;
                                  default 0, 1: the grid holds kelvin */
    float emission_scale;      /* of the black body, >= 0; default 1 */
} ty_medium_def;

/* Radiance of a black body at a temperature, seen as linear Rec.709: Planck's law weighted by the CIE 1931 colour
 * matching functions (so that 683 times its luminance is in cd m^-2), W m^-2 sr^-1. Channels below 0, of colours
 * outside Rec.709, are clipped (blue below 1900 K; luminance gains 1% by it at 1000 K and 15% at 800 K). 0 below 200 K;
 * above 100000 K as at 100000 K. */
TY_API void ty_blackbody(double kelvin, float radiance[3]);

/* The fraction of each cell of a grid that lies within a medium's bounds, 0..1: what grid methods multiply its density
 * by. The box [lower, upper] (m) is cut into size[0] x size[1] x size[2] cells; the result is an unplaced float grid.
 * samples: rays along each cell's side, 1..64. Errors: TY_ERROR_ARGUMENT, TY_ERROR_MEMORY. */
TY_API ty_result ty_medium_coverage(const ty_scene* scene, int32_t medium, const double lower[3], const double upper[3],
                                    const int32_t size[3], int32_t samples, ty_grid** out);

/* Media by name ("wholemilk": letters and digits count, case does not); docs/scene.md lists them with their sources. */
typedef enum ty_preset_kind {
    TY_PRESET_MEASURED = 0, /* a liquid or solid. The measurements give reduced scattering, so g is 0. May be diluted */
    TY_PRESET_WATER = 1,    /* pure or natural water, with the g of its molecules and particles */
    TY_PRESET_VISIBILITY = 2 /* fog and haze: needs a visibility */
} ty_preset_kind;

#define TY_VISIBILITY_MIN 1e-3 /* the least visibility of fog, m */
#define TY_VISIBILITY_MAX 1e9  /* the greatest, m */
#define TY_DILUTION_MAX 1e12   /* parts of a mixture that hold one part of a medium, at most */

/* Sets sigma_s, sigma_a and g from a preset. Returns false, def untouched, if the name is unknown or needs a
 * visibility. */
TY_API bool ty_medium_preset(const char* name, ty_medium_def* def);
/* The same from a preset that takes a number. TY_PRESET_VISIBILITY: the distance in metres, TY_VISIBILITY_MIN ..
 * TY_VISIBILITY_MAX, at which 5% of the contrast in green light is left (meteorological optical range).
 * TY_PRESET_MEASURED: how many parts of the mixture with pure water hold one part of the medium, 1 .. TY_DILUTION_MAX.
 * Returns false, def untouched, for others and for numbers out of range. */
TY_API bool ty_medium_preset_with(const char* name, double number, ty_medium_def* def);
/* How many presets there are. */
TY_API int32_t ty_medium_preset_count(void);
/* The index of a preset; -1 if there is none of the name. */
TY_API int32_t ty_medium_preset_find(const char* name);
/* The name of a preset as published ("Wholemilk"), in table order; NULL past the end. */
TY_API const char* ty_medium_preset_name(int32_t index);
/* What a preset takes; index: 0 .. ty_medium_preset_count() - 1. */
TY_API ty_preset_kind ty_medium_preset_kind(int32_t index);

/* What light comes from, and which fields of ty_light_def say where and how much. */
typedef enum ty_light_kind {
    TY_LIGHT_DIRECTIONAL = 0, /* direction, color = irradiance on a plane facing it */
    TY_LIGHT_POINT = 1,       /* position, color = intensity */
    TY_LIGHT_SPOT = 2,        /* position, direction, cone, penumbra, color = intensity on the axis */
    TY_LIGHT_AREA = 3,        /* origin, u, v; emits on the u x v side; color = radiance */
    TY_LIGHT_ENVIRONMENT = 4  /* image or constant; color = radiance (constant) */
} ty_light_kind;

/* A light; made by ty_default_light_def. */
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

/* A parallelogram, a box along the axes before its transform, or a sphere. */
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

/* Texels of a surface: colour and opacity. Row 0 is at v = 0 (the top, as glTF has it). */
typedef struct ty_texture ty_texture;

/* What a texture is beyond 0..1. */
typedef enum ty_wrap { TY_WRAP_REPEAT = 0, TY_WRAP_CLAMP = 1, TY_WRAP_MIRROR = 2 } ty_wrap;

/* What a texture is made of; made by ty_default_texture_def. */
typedef struct ty_texture_def {
    uint32_t cookie;       /* set by ty_default_texture_def; checked */
    int32_t width, height; /* 1..32768; of rgba8 */
    const uint8_t* rgba8;  /* 4 bytes a texel, colour coded as sRGB, alpha linear; copied. Exactly one of rgba8 and */
    const ty_image* image; /* image is given: linear R, G, B, or one channel, and A if there is one; copied */
    ty_wrap wrap[2];       /* along u and v; default TY_WRAP_REPEAT */
    bool nearest;          /* default false: bilinear */
} ty_texture_def;

/* A def with every field at its default. */
TY_API ty_texture_def ty_default_texture_def(void);
/* Makes a texture with one owner. Colours are clamped to [0, 1e15], not finite ones count as 0. Errors:
 * TY_ERROR_ARGUMENT, TY_ERROR_MEMORY. */
TY_API ty_result ty_texture_create(ty_context* context, const ty_texture_def* def, ty_texture** out);
/* Adds an owner, and returns the texture. NULL is allowed. */
TY_API ty_texture* ty_texture_retain(ty_texture* texture);
/* Removes an owner; the last one frees the texture. NULL is allowed. */
TY_API void ty_texture_destroy(ty_texture* texture);
/* Linear colour and alpha at (u, v). */
TY_API void ty_texture_sample(const ty_texture* texture, double u, double v, float rgba[4]);

/* What alpha does. */
typedef enum ty_alpha_mode {
    TY_ALPHA_OPAQUE = 0, /* alpha is not looked at */
    TY_ALPHA_MASK = 1,   /* there is a surface where alpha >= cutoff */
    TY_ALPHA_BLEND = 2   /* alpha is the fraction of rays that meet the surface; the same ray always meets the same */
} ty_alpha_mode;

/* A Lambertian surface. Colours multiply: factor, texture, and for albedo the vertex colour. */
typedef struct ty_material_def {
    uint32_t cookie;              /* set by ty_default_material_def; checked */
    float albedo[3];              /* 0..1; default 0.5 */
    float alpha;                  /* 0..1; default 1 */
    ty_texture* albedo_texture;   /* its alpha multiplies alpha; retained; default NULL */
    int32_t albedo_uv;            /* which texture coordinates, 0 or 1; default 0 */
    float albedo_map[6];          /* u' = m[0] u + m[1] v + m[2], v' = m[3] u + m[4] v + m[5]; default identity */
    float emission[3];            /* radiance, W m^-2 sr^-1, >= 0; default 0 */
    ty_texture* emission_texture; /* retained; default NULL */
    int32_t emission_uv;          /* default 0 */
    float emission_map[6];        /* default identity */
    bool double_sided;            /* emits on both sides, else on the front; reflects on both anyway; default false */
    ty_alpha_mode alpha_mode;     /* default TY_ALPHA_OPAQUE */
    float alpha_cutoff;           /* 0..1; default 0.5 */
} ty_material_def;

/* Where a mesh was read from, for reports and for writing to a copy of it (ty_mesh_file_write_colors). */
typedef struct ty_mesh_origin {
    const char* file;     /* its path; NULL (default): none. Copied, as is */
    const char* name;     /* of the mesh there, or of its node; NULL (default) or "": none */
    int32_t node;         /* of glTF, as are the others; -1 (default): not known */
    int32_t primitive;    /* of the node's mesh */
    int64_t first_vertex; /* vertices from this one of the primitive's positions are the mesh's */
    int64_t vertex_total; /* positions that the primitive has */
} ty_mesh_origin;

/* Triangles, counter-clockwise seen from the front. All arrays are copied. */
typedef struct ty_mesh_def {
    uint32_t cookie;          /* set by ty_default_mesh_def; checked */
    int64_t vertex_count;     /* 1..2^31 - 1 */
    int64_t triangle_count;   /* 1..2^31 - 1 */
    const float* positions;   /* 3 per vertex, m, before transform */
    const float* normals;     /* 3 per vertex, or NULL (default): flat triangles. Smoothed surfaces lose what they would
                                 send behind their triangles: a white ball of 288 triangles 0.2%, of 4608 0.02% */
    const float* uv[2];       /* 2 per vertex, or NULL (default): 0 */
    const float* colors;      /* 4 per vertex: linear R, G, B and alpha, 0..1; or NULL (default): 1 */
    const uint32_t* indices;  /* 3 per triangle */
    ty_affine transform;      /* default identity */
    ty_material_def material; /* of all triangles; default as by ty_default_material_def */
    ty_mesh_origin origin;    /* default: none */
} ty_mesh_def;

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

/* A def with every field at its default. */
TY_API ty_camera_def ty_default_camera_def(void);
/* A def with every field at its default. */
TY_API ty_medium_def ty_default_medium_def(void);
/* A def with every field at its default. */
TY_API ty_light_def ty_default_light_def(void);
/* A def with every field at its default. */
TY_API ty_shape_def ty_default_shape_def(void);
/* A def with every field at its default. */
TY_API ty_material_def ty_default_material_def(void);
/* A def with every field at its default. */
TY_API ty_mesh_def ty_default_mesh_def(void);
/* A def with every field at its default. */
TY_API ty_sky_def ty_default_sky_def(void);

/* Makes the sky image (R, G, B) for an environment light, and the sun's irradiance at the ground, W m^-2.
 * Errors: TY_ERROR_ARGUMENT, TY_ERROR_MEMORY. */
TY_API ty_result ty_sky_image(ty_context* context, const ty_sky_def* def, ty_image** out, float sun_irradiance[3]);

/* An empty scene. Errors: TY_ERROR_ARGUMENT, TY_ERROR_MEMORY. */
TY_API ty_result ty_scene_create(ty_context* context, ty_axis up_axis, ty_scene** out);
/* Frees a scene; NULL is allowed. */
TY_API void ty_scene_destroy(ty_scene* scene);

/* Sets the camera. This and the calls below copy their defs. Errors: TY_ERROR_ARGUMENT (with the field and its range),
 * TY_ERROR_MEMORY. */
TY_API ty_result ty_scene_set_camera(ty_scene* scene, const ty_camera_def* def);
/* Adds a medium; its coefficients add to those of others at the same place. Errors as above. */
TY_API ty_result ty_scene_add_medium(ty_scene* scene, const ty_medium_def* def);
/* Adds a light. Errors as above. */
TY_API ty_result ty_scene_add_light(ty_scene* scene, const ty_light_def* def);
/* Adds a surface. Errors as above. */
TY_API ty_result ty_scene_add_shape(ty_scene* scene, const ty_shape_def* def);
/* Adds a mesh. Errors as above. */
TY_API ty_result ty_scene_add_mesh(ty_scene* scene, const ty_mesh_def* def);

/* Builds what rendering needs: ray tracing structures, majorants, light tables. Further add calls need another
 * commit. Errors: TY_ERROR_MEMORY, TY_ERROR_INTERNAL. */
TY_API ty_result ty_scene_commit(ty_scene* scene);

/* The context that the scene was made with. */
TY_API ty_context* ty_scene_context(const ty_scene* scene);
/* The axis that points up. */
TY_API ty_axis ty_scene_up_axis(const ty_scene* scene);
/* The camera, or the default one where none was set. */
TY_API ty_camera_def ty_scene_camera(const ty_scene* scene);

/* What a method is asked for under its own name in `render`. */
typedef struct ty_path_settings {
    int32_t max_depth; /* scatterings and reflections at most; 0 (default) for unlimited */
} ty_path_settings;

/* ty_screen_def in words. */
typedef struct ty_screen_settings {
    char variant[16]; /* "scatter" (default), "gather", "naive", "published" or "reference" */
    char spread[16];  /* of variant "scatter" and "reference": "small_angle" (default) or "gaussian" (the paper's) */
    int32_t filter;   /* taps, 2, 4 (default) or 6 */
    int32_t levels;   /* of the pyramid, 1..15; 0 (default): as many as are needed */
    char environment[16]; /* what light from outside the picture counts: "around" (default): the mean radiance that
                             arrives at the camera from all directions, without media; "lights": that of environment
                             lights alone; "none" */
    bool balance;         /* whether it is put in only for what the picture's own light loses to backward scattering
                             (ty_screen_balance), default, or in full; without "none" full is far too bright */
} ty_screen_settings;

/* ty_fld_def in words; 0 for what it calls its own choice. */
typedef struct ty_fld_settings {
    char limiter[24];  /* "levermore_pomraning" (default), "sum", "max", "kershaw", "larsen" or "none" */
    char boundary[16]; /* "marshak" (default) or "dirichlet" (the paper's) */
    char solver[16];   /* "multigrid" (default), "sor" (the paper's) or "sor_float" */
    char beam[16];     /* "reduced" (default) or "published" */
    double larsen_power, streaming, relaxation, tolerance, sigma_eps, ratio, step; /* as in ty_fld_def */
    int32_t resolution, iterations, environment_beams, surface_points;             /* as in ty_fld_def */
    int32_t spp;                                                                   /* rays per pixel */
} ty_fld_settings;

/* ty_pop_def in words; 0 for what it calls its own choice. */
typedef struct ty_pop_settings {
    char mode[16];                               /* "split" (default), "published" (the paper's) or "collided" */
    int32_t resolution, merged, direct;          /* as in ty_pop_def, as are all below */
    bool sharp;                                  /* as in ty_pop_def */
    int32_t ordinates;                           /* as in ty_pop_def */
    double prefilter;                            /* as in ty_pop_def */
    bool importance;                             /* as in ty_pop_def */
    int32_t surface_points, vpls, shadow_texels; /* as in ty_pop_def */
    double clamp;                                /* as in ty_pop_def */
    int32_t iterations, residuum_iterations;     /* as in ty_pop_def */
    double residuum, streaming, tolerance, step; /* as in ty_pop_def */
    int32_t spp;                                 /* rays per pixel */
} ty_pop_settings;

/* ty_lpv_def in words; 0 for what it calls its own choice. */
typedef struct ty_lpv_settings {
    char mode[16];  /* "links" (default) or "published" (the paper's) */
    char parts[16]; /* what takes part: "all" (default), or as in the paper's Fig. 5 "shadow_map", "plain",
                       "plain_march", "single" or "both" */
    char place[16]; /* of the lattice: "scene" (default) or "camera" */
    int32_t resolution, cascades, bands;   /* as in ty_lpv_def */
    double extent;                         /* m */
    double window;                         /* -1: its own choice */
    int32_t iterations;                    /* as in ty_lpv_def */
    double tolerance;                      /* as in ty_lpv_def */
    int32_t map_side, samples, block_side; /* as in ty_lpv_def */
    int32_t shadow_side;                   /* as in ty_lpv_def */
    bool shadow_rays, half;                /* as in ty_lpv_def */
    double step;                           /* as in ty_lpv_def */
    int32_t spp;                           /* rays per pixel */
} ty_lpv_settings;

/* ty_dom_def in words; 0 for what it calls its own choice. */
typedef struct ty_dom_settings {
    char acceleration[16];                                          /* "diffusion" (default) or "none" */
    int32_t resolution, direct, directions, last_directions, bands; /* as in ty_dom_def */
    double tolerance;                                               /* as in ty_dom_def */
    int32_t iterations, environment_beams, surface_points;          /* as in ty_dom_def */
    double step;                                                    /* as in ty_dom_def */
    int32_t spp;                                                    /* rays per pixel */
} ty_dom_settings;

/* What `render` in a scene file asked for; defaults when a scene was built by calls. */
typedef struct ty_render_settings {
    char method[16]; /* "auto" (default; ty_choose_method), "path", "screen", "fld", "cda" (fld without limiter), "pop",
                        "lpv" or "dom" */
    int32_t spp;     /* samples per pixel, 1..2^24; default 64 */
    uint64_t seed;   /* default 0 */
    ty_path_settings path;     /* of method path, as below of others */
    ty_screen_settings screen; /* of method screen */
    ty_fld_settings fld;       /* of methods fld and cda */
    ty_pop_settings pop;       /* of method pop */
    ty_lpv_settings lpv;       /* of method lpv */
    ty_dom_settings dom;       /* of method dom */
} ty_render_settings;

/* What the scene asks for. */
TY_API ty_render_settings ty_scene_render_settings(const ty_scene* scene);
/* Sets what the scene asks for; checked where it is used. */
TY_API void ty_scene_set_render_settings(ty_scene* scene, const ty_render_settings* settings);

/* A hash of the scene's content (file text after overrides, and the bytes of every file it names); 0 when the
 * scene was built by calls. */
TY_API uint64_t ty_scene_hash(const ty_scene* scene);
/* Sets that hash. */
TY_API void ty_scene_set_hash(ty_scene* scene, uint64_t hash);

/* Where the camera comes from, for reports: "" (default) or the camera of a file that a scene file named. Copied, cut
 * to 255 bytes. */
TY_API const char* ty_scene_camera_source(const ty_scene* scene);
/* Sets that text. */
TY_API void ty_scene_set_camera_source(ty_scene* scene, const char* source);

/* Counts and memory, for reports. */
typedef struct ty_scene_info {
    int32_t media, lights, shapes, meshes; /* how many were added */
    int64_t triangles;                     /* of meshes */
    int64_t textures;                      /* of meshes */
    int64_t emitters;          /* lights that are sampled: lights, and quads, spheres and triangles that glow */
    bool bounded;              /* whether anything has a place */
    double lower[3], upper[3]; /* box around media and surfaces, m */
    size_t bytes;              /* memory of grids, textures, tables and ray tracing structures */
    size_t texture_bytes;      /* the part of it that textures take */
} ty_scene_info;

/* Counts and memory of a scene; those of a committed one are complete. */
TY_API ty_scene_info ty_scene_get_info(const ty_scene* scene);
/* One medium as added, with its grid (not retained for the caller); TY_ERROR_ARGUMENT past the end. */
TY_API ty_result ty_scene_get_medium(const ty_scene* scene, int32_t index, ty_medium_def* out);
/* Radiance of the environment lights together, mean over all directions, W m^-2 sr^-1; 0 without any. */
TY_API void ty_scene_environment(const ty_scene* scene, float radiance[3]);
/* One mesh as it stands in the world (its transform is the identity); the arrays are the scene's own and last as long
 * as it; textures are not retained for the caller. TY_ERROR_ARGUMENT past the end. */
TY_API ty_result ty_scene_get_mesh(const ty_scene* scene, int32_t index, ty_mesh_def* out);

/* ---- Rays ---- */

/* A ray of light or sight. */
typedef struct ty_ray {
    float origin[3];    /* m, finite */
    float direction[3]; /* unit */
    float far;          /* how far the ray goes, m, > 0; infinity is allowed */
} ty_ray;

/* What a ray meets first. */
typedef struct ty_ray_hit {
    float distance;    /* from the origin, m; the ray's far where it meets nothing */
    int32_t surface;   /* shapes as they were added, then area lights, then meshes; -1: the ray meets nothing, and what
                          follows is 0 */
    int32_t part;      /* which side of a box (-x, +x, -y, ...), which triangle of a mesh; else 0 */
    float b1, b2;      /* of triangles: weights of the second and third corner */
    float position[3]; /* m, on the surface to rounding, however long the ray was */
    float normal[3];   /* unit, of the flat face or the sphere, on its front */
    float margin;      /* m; a ray that starts this far off the surface, along its normal, does not meet it again */
} ty_ray_hit;

/* What each of many rays meets first in a committed scene, over the context's threads: hits[i] belongs to rays[i].
 * coherent: whether neighbours in the array go nearly the same way (a camera's pixels in small tiles, rays to one
 * lamp): they then travel in packets of sixteen, which is quicker; rays that scatter go one by one. What
 * is met does not depend on it, but for rounding. Surfaces with alpha are met or not as the ray itself decides.
 * Errors: TY_ERROR_ARGUMENT (scene not committed, count negative). */
TY_API ty_result ty_scene_trace(const ty_scene* scene, const ty_ray* rays, int64_t count, bool coherent,
                                ty_ray_hit* hits);
/* Whether each ray meets anything at all, which is quicker to find out. Errors as ty_scene_trace. */
TY_API ty_result ty_scene_trace_shadows(const ty_scene* scene, const ty_ray* rays, int64_t count, bool coherent,
                                        bool* shadowed);

#ifdef __cplusplus
}
#endif
#endif
