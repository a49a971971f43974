/// @file scene.h
/// Scenes: media, lights, surfaces, a camera, and rays through them.
///
/// Units: metres, W m^-2 (irradiance), W sr^-1 (intensity), W m^-2 sr^-1 (radiance), 1/m (coefficients). Colours are
/// linear Rec.709. Directions are those in which the light travels. Axes are right-handed.
///
/// A scene is filled by add calls, then committed. Committed scenes may be read from any thread. Add calls copy their
/// definitions with all arrays and images, and take references to grids, shells and textures, so that the caller may
/// free and release its own right after the call. Apache-2.0.
#ifndef TYNDALL_SCENE_H
#define TYNDALL_SCENE_H

#include <tyndall/base.h>
#include <tyndall/grid.h>
#include <tyndall/image.h>
#include <tyndall/phase.h>

#ifdef __cplusplus
extern "C" {
#endif

/// Media, lights, surfaces and a camera.
typedef struct ty_scene ty_scene;

/// The axis that points up.
typedef enum ty_axis {
    TY_AXIS_Y = 1, ///< y.
    TY_AXIS_Z = 2  ///< z.
} ty_axis;

/// A pinhole camera. Create it with ty_default_camera_def().
typedef struct ty_camera_def {
    uint32_t cookie;       ///< Set by ty_default_camera_def() and checked.
    uint32_t bytes;        ///< Set by ty_default_camera_def() to the size of the structure, and checked.
    double position[3];    ///< m; default (0, 0, 5).
    double target[3];      ///< A point at the center of the view, m, not at `position`; default (0, 0, 0).
    double up[3];          ///< A direction that points up in the image, not along the view; default (0, 1, 0).
    double fov_y;          ///< Full vertical angle of view, degrees, (0, 180); default 40.
    int32_t resolution[2]; ///< Width and height, pixels, 1..65536; default 800 x 600.
    double exposure;       ///< Exposure for display alone, stops; default 0.
    double shift[2]; ///< Shift of the view to the right and up, as off a lens that is moved in parallel to the film:
                     ///< fractions of the frame's height, [-100, 100]; default 0. `target` stays on the axis.
    double aperture_radius; ///< Radius of the thin lens, m, [0, 1e9]; default 0: a pinhole, which is sharp everywhere.
    double focus_distance; ///< Distance along the axis of the plane in focus, m, [0, 1e9]; default 0: through `target`.
    int32_t moves;         ///< Nonzero: the shutter is open while the camera goes from `position`, `target` and `up` to
                           ///< `end_position`, `end_target` and `end_up`, linearly; default 0.
    double end_position[3]; ///< m; default (0, 0, 5).
    double end_target[3];   ///< m; default (0, 0, 0).
    double end_up[3];       ///< Default (0, 1, 0).
} ty_camera_def;

/// The shape that bounds a medium.
typedef enum ty_bounds_kind {
    TY_BOUNDS_NONE = 0,   ///< No shape; for placed grids.
    TY_BOUNDS_BOX = 1,    ///< A box along the axes.
    TY_BOUNDS_SPHERE = 2, ///< A sphere.
    TY_BOUNDS_SHELL = 3   ///< A closed mesh.
} ty_bounds_kind;

/// A closed triangle mesh that a medium fills. A shell is immutable and reference counted. A ray from a point inside
/// leaves more surfaces than it enters, so orientation matters, and shells may nest or overlap.
typedef struct ty_closed_mesh ty_closed_mesh;

/// Creates a shell with one reference. positions: 3 floats per vertex. indices: 3 per triangle, counter-clockwise seen
/// from outside. Both are copied. A warning counts the edges that triangles do not pass equally often in both
/// directions: rays through such holes see the medium end late or early. Of the crossings of a ray with the mesh the
/// nearest 64 count. Errors: TY_ERROR_ARGUMENT (no triangle, an index past the end, a position that is not finite),
/// TY_ERROR_MEMORY.
TY_API ty_result ty_closed_mesh_create(ty_context* context, const float* positions, int64_t vertex_count,
                                       const uint32_t* indices, int64_t triangle_count, ty_closed_mesh** out);
/// Adds a reference and returns the shell; NULL is allowed.
TY_API ty_closed_mesh* ty_closed_mesh_retain(ty_closed_mesh* shell);
/// Drops a reference; the last one frees the shell. NULL is allowed.
TY_API void ty_closed_mesh_release(ty_closed_mesh* shell);

/// A point of a transfer function. Between points density and albedo are linear in the value; beyond the ends they are
/// constant.
typedef struct ty_transfer_point {
    float value;     ///< Value of the grid, above that of the point before.
    float density;   ///< Density that replaces the value of the grid, >= 0.
    float albedo[3]; ///< Single-scattering albedo, 0..1, if the medium's transfer_albedo is set.
} ty_transfer_point;

/// Largest number of points of a transfer function.
enum { TY_TRANSFER_MAX = 256 };

/// A participating medium: sigma(x) = density(x) * scale * coefficient, and 0 outside of the bounds. The density is the
/// trilinear value of the grid, or the transfer function of that value. Media may overlap: their coefficients add up.
/// Create it with ty_default_medium_def().
typedef struct ty_medium_def {
    uint32_t cookie;         ///< Set by ty_default_medium_def() and checked.
    uint32_t bytes;          ///< Set by ty_default_medium_def() to the size of the structure, and checked.
    const char* name;        ///< Default "".
    ty_bounds_kind bounds;   ///< The space that a homogeneous medium or an unplaced grid fills, and that cuts a placed
                             ///< grid; default TY_BOUNDS_NONE (placed grids only).
    double box_min[3];       ///< Lower corner of a box, before `transform`, m.
    double box_max[3];       ///< Upper corner of a box, above `box_min`, before `transform`, m.
    double sphere_center[3]; ///< Centre of a sphere, before `transform`, m.
    double sphere_radius;    ///< Radius of a sphere, m, > 0.
    ty_closed_mesh* shell;   ///< TY_BOUNDS_SHELL: the mesh, before `transform`, m; default NULL.
    ty_affine transform;     ///< Map of bounds and grids into the scene; default identity.
    ty_grid* density_grid;   ///< NULL (default): density is 1 within the bounds.
    float sigma_s[3];        ///< Scattering coefficient at density 1, 1/m, >= 0; default 0.
    float sigma_a[3];        ///< Absorption coefficient at density 1, 1/m, >= 0; default 0.
    float scale;             ///< Factor of the density, >= 0; default 1.
    float g[3];              ///< Mean cosine of the Henyey-Greenstein phase function, (-1, 1); default 0. Only
                             ///< without `phase`.

    const ty_transfer_point* transfer; ///< Transfer function of `density_grid`; default NULL.
    int32_t transfer_count;            ///< Number of its points: 0 (default), or 2..TY_TRANSFER_MAX.
    bool transfer_albedo;              ///< True: its points set the albedo; default false.

    ty_grid* albedo_grid[3]; ///< Single-scattering albedo per channel, clamped to 0..1, which splits sigma_s + sigma_a
                             ///< anew; default NULL. All three or none; they may be one grid. Not with
                             ///< `transfer_albedo`. This grid and the ones below are placed like the density grid;
                             ///< outside of a placed grid its background holds.
    ty_grid* g_grid;         ///< Mean cosine for all channels, clamped to (-1, 1), which replaces `g`; default NULL.

    float emission[3]; ///< Emitted radiance, W m^-2 sr^-1, >= 0; default 0. The medium emits absorption coefficient *
                       ///< emission per metre, W m^-3 sr^-1, so that a thick box of it has the radiance `emission`.
    ty_grid* temperature_grid; ///< Adds the radiance of a black body (ty_blackbody()) times `emission_scale` to
                               ///< `emission`; default NULL.
    double kelvin[2];          ///< Temperature where that grid is 0 and where it is 1, K, linear in between and beyond;
                               ///< default 0, 1: the grid holds temperatures.
    float emission_scale;      ///< Factor of the black body, >= 0; default 1.

    ty_phase_lobe phase[TY_PHASE_LOBES_MAX]; ///< The lobes of a phase function other than Henyey-Greenstein of `g`.
    int32_t phase_count;                     ///< Their number: 0 (default), or 1..TY_PHASE_LOBES_MAX.
} ty_medium_def;

/// The radiance of a black body at a temperature in linear Rec.709, W m^-2 sr^-1: Planck's law weighted by the CIE 1931
/// colour matching functions, so that 683 times its luminance is in cd m^-2. Negative channels, of colours outside
/// Rec.709, are clipped: blue below 1900 K; luminance grows by 1% at 1000 K and by 15% at 800 K. The result is 0 below
/// 200 K, and constant above 100000 K.
TY_API void ty_blackbody(double kelvin, float radiance[3]);

/// Sets `g` to the mean cosine of a medium's phase function per channel: that of `phase`, or `g` without it; where the
/// medium has a g_grid, `g`, too. Errors: TY_ERROR_ARGUMENT, TY_ERROR_MEMORY.
TY_API ty_result ty_medium_mean_cosine(ty_context* context, const ty_medium_def* medium, float g[3]);

/// Creates a grid of the fraction, 0..1, of each cell that lies within a medium's bounds, by which grid methods
/// multiply its density: an unplaced float grid of size[0] x size[1] x size[2] cells over the box [lower, upper] (m).
/// samples: rays along the side of each cell, 1..64. Errors: TY_ERROR_ARGUMENT, TY_ERROR_MEMORY.
TY_API ty_result ty_medium_create_coverage(const ty_scene* scene, int32_t medium, const double lower[3],
                                           const double upper[3], const int32_t size[3], int32_t samples,
                                           ty_grid** out);

/// The kind of a medium by name. Names compare by letters and digits, whatever the case ("wholemilk"); docs/scene.md
/// lists them with their sources.
typedef enum ty_preset_kind {
    TY_PRESET_MEASURED = 0,  ///< A liquid or solid, of which reduced scattering was measured, so that g is 0. It may be
                             ///< diluted.
    TY_PRESET_WATER = 1,     ///< Pure or natural water, with the phase function of its molecules and particles.
    TY_PRESET_VISIBILITY = 2 ///< Fog and haze, which need a visibility.
} ty_preset_kind;

/// Smallest visibility of fog, m.
#define TY_VISIBILITY_MIN 1e-3
/// Largest visibility of fog, m.
#define TY_VISIBILITY_MAX 1e9
/// Largest number of parts of a mixture that hold one part of a medium.
#define TY_DILUTION_MAX 1e12

/// Sets sigma_s, sigma_a and g from a preset. Returns false, and leaves def as it is, if the name is unknown or needs a
/// visibility.
TY_API bool ty_medium_preset(const char* name, ty_medium_def* def);
/// Sets sigma_s, sigma_a and g from a preset with a number. TY_PRESET_VISIBILITY: the distance, TY_VISIBILITY_MIN ..
/// TY_VISIBILITY_MAX m, at which 5% of the contrast in green light is left (meteorological optical range).
/// TY_PRESET_MEASURED: the number of parts of the mixture with pure water that hold one part of the medium, 1 ..
/// TY_DILUTION_MAX. Returns false, and leaves def as it is, for other presets and for numbers out of range.
TY_API bool ty_medium_preset_with(const char* name, double number, ty_medium_def* def);
/// Number of presets.
TY_API int32_t ty_medium_preset_count(void);
/// Index of the preset with a name; -1 without one.
TY_API int32_t ty_medium_preset_find(const char* name);
/// Published name of a preset ("Wholemilk"), in the order of the table; NULL past the end.
TY_API const char* ty_medium_preset_name(int32_t index);
/// Kind of a preset. index: 0 .. ty_medium_preset_count() - 1.
TY_API ty_preset_kind ty_medium_preset_kind(int32_t index);

/// The kind of a light, and the fields of ty_light_def that it uses.
typedef enum ty_light_kind {
    TY_LIGHT_DIRECTIONAL = 0, ///< direction; color is the irradiance on a plane that faces it, W m^-2.
    TY_LIGHT_POINT = 1,       ///< position; color is the intensity, W sr^-1.
    TY_LIGHT_SPOT = 2,        ///< position, direction, cone, penumbra; color is the intensity on the axis, W sr^-1.
    TY_LIGHT_AREA = 3,        ///< position, u, v; it emits on the side of u x v; color is the radiance, W m^-2 sr^-1.
    TY_LIGHT_ENVIRONMENT = 4  ///< image, or a constant; color is the radiance of a constant, W m^-2 sr^-1.
} ty_light_kind;

/// A light. Create it with ty_default_light_def().
typedef struct ty_light_def {
    uint32_t cookie;       ///< Set by ty_default_light_def() and checked.
    uint32_t bytes;        ///< Set by ty_default_light_def() to the size of the structure, and checked.
    ty_light_kind kind;    ///< Default TY_LIGHT_DIRECTIONAL.
    float color[3];        ///< In the unit of ty_light_kind, >= 0, finite; default 1.
    double direction[3];   ///< Direction in which the light travels, not zero; default (0, -1, 0).
    double position[3];    ///< m; default 0. Area lights: the corner at which u and v begin.
    double u[3];           ///< First edge of an area light, m; default 0.
    double v[3];           ///< Second edge of an area light, m; default 0.
    double cone;           ///< Full outer angle of a spot, degrees, (0, 180]; default 40.
    double penumbra;       ///< Fraction of the half angle over which a spot fades, 0..1; default 0.15.
    const ty_image* image; ///< Environment: equirectangular RGB, seen from inside, not mirrored, its centre along +x;
                           ///< copied. Default NULL: constant.
    float scale;           ///< Environment: factor of the image or color, >= 0; default 1.
    double rotation; ///< Environment: rotation about the up axis, degrees, counter-clockwise seen from above; default
                     ///< 0.
    double radius;   ///< Point, spot: radius of the black sphere that shines in its place, whose radiance times pi
                     ///< radius^2 is the intensity, m, >= 0; default 0: a point.
} ty_light_def;

/// The kind of a shape.
typedef enum ty_shape_kind {
    TY_SHAPE_QUAD = 0,  ///< A parallelogram.
    TY_SHAPE_BOX = 1,   ///< A box, along the axes before its transform.
    TY_SHAPE_SPHERE = 2 ///< A sphere.
} ty_shape_kind;

/// The colour and opacity of a surface. A texture is immutable and reference counted. Row 0 is at v = 0 (the top, as in
/// glTF).
typedef struct ty_texture ty_texture;

/// Textures of a glossy material, and the channels that multiply its numbers.
typedef enum ty_gloss_texture {
    TY_GLOSS_METALLIC_ROUGHNESS = 0,  ///< Roughness in green, metallic in blue; linear.
    TY_GLOSS_NORMAL = 1,              ///< Normals in the frame of tangent, bitangent and normal; linear.
    TY_GLOSS_SPECULAR = 2,            ///< In alpha.
    TY_GLOSS_SPECULAR_COLOR = 3,      ///< In red, green and blue.
    TY_GLOSS_TRANSMISSION = 4,        ///< In red; linear.
    TY_GLOSS_CLEARCOAT = 5,           ///< In red; linear.
    TY_GLOSS_CLEARCOAT_ROUGHNESS = 6, ///< In green; linear.
    TY_GLOSS_SHEEN_COLOR = 7,         ///< In red, green and blue.
    TY_GLOSS_SHEEN_ROUGHNESS = 8,     ///< In alpha.
    TY_GLOSS_CLEARCOAT_NORMAL = 9,    ///< As TY_GLOSS_NORMAL, of the clear coat, which bends by it alone.
    TY_GLOSS_TEXTURES = 10            ///< Their number.
} ty_gloss_texture;

/// A texture as a material uses it.
typedef struct ty_texture_use {
    ty_texture* texture; ///< Default NULL.
    int32_t uv;          ///< Texture coordinates for it, 0 or 1; default 0.
    float map[6];        ///< u' = m[0] u + m[1] v + m[2], v' = m[3] u + m[4] v + m[5]; default identity.
} ty_texture_use;

/// The reflection and transmission of a surface apart from its diffuse part: glTF's metallic-roughness model
/// (docs/materials.md). Without metal, specular reflection, coat, sheen, transmission and normals of a texture, which
/// is the default, the surface is Lambertian.
typedef struct ty_gloss_def {
    float metallic;          ///< Part of the surface that is bare metal, 0..1; default 0.
    float roughness;         ///< The square root of the microfacets' alpha, 0..1; default 1.
    float ior;               ///< Index of refraction of the dielectric part, 0 or 1..100; default 1.5; 0 reflects all.
    float specular;          ///< Strength of the dielectric's reflection, 0..1; default 0: none. Dielectrics have 1.
    float specular_color[3]; ///< Colour of it at normal incidence, 0..1e3; default 1.
    float transmission;      ///< Part of the light in the dielectric that passes the surface, which counts as a thin
                             ///< wall unless `solid`, in place of the diffuse reflection, 0..1; default 0.
    float clearcoat;         ///< Strength of a clear coat of ior 1.5, 0..1; default 0.
    float clearcoat_roughness;                  ///< 0..1; default 0.
    float sheen_color[3];                       ///< Colour of the sheen of cloth, 0..1; default 0.
    float sheen_roughness;                      ///< 0..1; default 0.
    float normal_scale;                         ///< Multiplies the slopes of normals, -1e3..1e3; default 1.
    float clearcoat_normal_scale;               ///< The same of the clear coat's; default 1.
    ty_texture_use textures[TY_GLOSS_TEXTURES]; ///< By ty_gloss_texture; shapes have the texture coordinates 0 alone.
    bool solid; ///< True: the surface is the closed boundary, normals outwards, of a dielectric of index ior, and what
                ///< passes it is refracted; default false: a thin wall. Quads cannot be. Without transmission, with
                ///< ior 0 or of metal alone it has no effect. Media whose bounds reach beyond it stay out.
    int32_t priority; ///< Of overlapping solids the one of highest priority fills the common part, and of equal ones
                      ///< the one that was added first, -1000..1000; default 0.
    float attenuation_color[3]; ///< Transmittance of the solid over attenuation_distance, 0..1, where less than 1e-6
                                ///< counts as that; default 1.
    float attenuation_distance; ///< m, >= 0; default 0: the solid does not absorb.
} ty_gloss_def;

/// A surface, which reflects on both sides and emits on its front (u x v, or outwards). Create it with
/// ty_default_shape_def().
///
/// Textures are seen unmirrored from the front. On a quad their lower left corner is at origin, u runs along its edge u
/// and v, which begins at the top of a texture, against its edge v. Each face of a box has the whole texture: on its
/// sides upright along the up axis; on top, and from below, with u along +x. On a sphere the poles are on the up axis
/// and the centre of the texture at +x (with y up u = 0.5 - atan2(z, x) / 2pi, with z up u = 0.5 + atan2(y, x) / 2pi).
/// Up axis and +x are those before the transform.
typedef struct ty_shape_def {
    uint32_t cookie;               ///< Set by ty_default_shape_def() and checked.
    uint32_t bytes;                ///< Set by ty_default_shape_def() to the size of the structure, and checked.
    ty_shape_kind kind;            ///< Default TY_SHAPE_QUAD.
    double origin[3];              ///< Corner of a quad, lower corner of a box, or centre of a sphere, m.
    double u[3];                   ///< First edge of a quad, or upper corner of a box, m.
    double v[3];                   ///< Second edge of a quad, m.
    double radius;                 ///< Radius of a sphere, m, > 0.
    ty_affine transform;           ///< Default identity; spheres take rotation, translation and uniform scale only.
    float albedo[3];               ///< Base colour, 0..1; default 0.5.
    float emission[3];             ///< Emitted radiance, W m^-2 sr^-1, >= 0; default 0.
    ty_gloss_def gloss;            ///< Default: Lambertian.
    ty_texture_use albedo_texture; ///< It multiplies albedo; its alpha has no effect. Default: none.
} ty_shape_def;

/// The continuation of a texture beyond 0..1.
typedef enum ty_wrap {
    TY_WRAP_REPEAT = 0, ///< It repeats.
    TY_WRAP_CLAMP = 1,  ///< Its edge continues.
    TY_WRAP_MIRROR = 2  ///< It repeats mirrored.
} ty_wrap;

/// The content of a texture: rgba8 or image. Create it with ty_default_texture_def().
typedef struct ty_texture_def {
    uint32_t cookie;       ///< Set by ty_default_texture_def() and checked.
    uint32_t bytes;        ///< Set by ty_default_texture_def() to the size of the structure, and checked.
    int32_t width;         ///< Width of rgba8, texels, 1..32768.
    int32_t height;        ///< Height of rgba8, texels, 1..32768.
    const uint8_t* rgba8;  ///< 4 bytes per texel: colour in sRGB unless `linear`, linear alpha; copied. Exactly one of
                           ///< rgba8 and image is set.
    const ty_image* image; ///< Linear R, G, B, or one channel, and A if there is one; copied.
    ty_wrap wrap[2];       ///< Along u and v; default TY_WRAP_REPEAT.
    bool nearest;          ///< True: lookups take the nearest texel; default false: bilinear.
    bool linear;           ///< True: rgba8 holds numbers, as maps of normals and roughness do; default false.
} ty_texture_def;

/// Sets the `bytes` bytes of a ty_texture_def to the defaults, as ty_init_context_def() does.
TY_API void ty_init_texture_def(void* def, size_t bytes);
/// A definition with all fields at their defaults.
static inline ty_texture_def ty_default_texture_def(void) {
    ty_texture_def def;
    ty_init_texture_def(&def, sizeof def);
    return def;
}
/// Creates a texture with one reference. Colours are clamped to [0, 1e15], and those that are not finite count as 0.
/// Errors: TY_ERROR_ARGUMENT, TY_ERROR_MEMORY.
TY_API ty_result ty_texture_create(ty_context* context, const ty_texture_def* def, ty_texture** out);
/// Adds a reference and returns the texture; NULL is allowed.
TY_API ty_texture* ty_texture_retain(ty_texture* texture);
/// Drops a reference; the last one frees the texture. NULL is allowed.
TY_API void ty_texture_release(ty_texture* texture);
/// Stores linear colour and alpha at (u, v).
TY_API void ty_texture_sample(const ty_texture* texture, double u, double v, float rgba[4]);

/// The effect of alpha.
typedef enum ty_alpha_mode {
    TY_ALPHA_OPAQUE = 0, ///< None.
    TY_ALPHA_MASK = 1,   ///< The surface exists where alpha >= cutoff.
    TY_ALPHA_BLEND = 2   ///< Alpha is the fraction of rays that meet the surface; the same ray always meets the same.
} ty_alpha_mode;

/// A material. Factor, texture, and for albedo the colour of vertices are multiplied. Create it with
/// ty_default_material_def().
typedef struct ty_material_def {
    uint32_t cookie;              ///< Set by ty_default_material_def() and checked.
    uint32_t bytes;               ///< Set by ty_default_material_def() to the size of the structure, and checked.
    float albedo[3];              ///< Base colour, 0..1; default 0.5.
    float alpha;                  ///< 0..1; default 1.
    ty_texture* albedo_texture;   ///< Its alpha multiplies `alpha`; default NULL.
    int32_t albedo_uv;            ///< Texture coordinates for it, 0 or 1; default 0.
    float albedo_map[6];          ///< u' = m[0] u + m[1] v + m[2], v' = m[3] u + m[4] v + m[5]; default identity.
    float emission[3];            ///< Emitted radiance, W m^-2 sr^-1, >= 0; default 0.
    ty_texture* emission_texture; ///< Default NULL.
    int32_t emission_uv;          ///< Texture coordinates for it, 0 or 1; default 0.
    float emission_map[6];        ///< As albedo_map; default identity.
    bool double_sided;        ///< True: both sides emit, instead of the front; both reflect in any case; default false.
    ty_alpha_mode alpha_mode; ///< Default TY_ALPHA_OPAQUE.
    float alpha_cutoff;       ///< 0..1; default 0.5.
    ty_gloss_def gloss;       ///< Default: Lambertian.
} ty_material_def;

/// The origin of a mesh in a file, for reports and for ty_mesh_file_write_colors().
typedef struct ty_mesh_origin {
    const char* file;     ///< Path of the file; NULL (default): none.
    const char* name;     ///< Name of the mesh in it, or of its node; NULL (default) or "": none.
    int32_t node;         ///< Node in a glTF file, as the fields below; -1 (default): unknown.
    int32_t primitive;    ///< Primitive of the node's mesh.
    int64_t first_vertex; ///< First of the primitive's positions that belong to the mesh.
    int64_t vertex_total; ///< Number of positions of the primitive.
} ty_mesh_origin;

/// Triangles, counter-clockwise seen from the front. Create it with ty_default_mesh_def().
typedef struct ty_mesh_def {
    uint32_t cookie;        ///< Set by ty_default_mesh_def() and checked.
    uint32_t bytes;         ///< Set by ty_default_mesh_def() to the size of the structure, and checked.
    int64_t vertex_count;   ///< 1..2^31 - 1.
    int64_t triangle_count; ///< 1..2^31 - 1.
    const float* positions; ///< 3 per vertex, m, before `transform`.
    const float* normals; ///< 3 per vertex, or NULL (default): flat triangles. A smooth surface loses the light that it
                          ///< would send behind its triangles: a white ball of 288 triangles 0.2%, of 4608 0.02%.
    const float* uv[2];   ///< 2 per vertex, or NULL (default): 0.
    const float* colors;  ///< 4 per vertex: linear R, G, B and alpha, 0..1; or NULL (default): 1.
    const uint32_t* indices;  ///< 3 per triangle.
    ty_affine transform;      ///< Default identity.
    ty_material_def material; ///< Material of all triangles; default that of ty_default_material_def().
    ty_mesh_origin origin;    ///< Default: none.
    const float*
        tangents; ///< 4 per vertex, the direction of u and the sign of the bitangent sign * (normal x tangent),
                  ///< for maps of normals; or NULL (default): from positions and texture coordinates.
} ty_mesh_def;

/// Light of a sky that was scattered more than once.
typedef enum ty_sky_scattering {
    TY_SKY_ORDERS = 0,    ///< Successive orders of scattering by the phase functions of air and haze (docs/sky.md).
    TY_SKY_ISOTROPIC = 1, ///< As if scattered isotropically, by height alone (Hillaire 2020).
    TY_SKY_SINGLE = 2     ///< None.
} ty_sky_scattering;

/// The sky seen from the ground: sunlight in a spherical atmosphere with Rayleigh and Mie scattering and ozone.
/// Radiance is absolute, per channel for a given solar irradiance. Create it with ty_default_sky_def().
typedef struct ty_sky_def {
    uint32_t cookie;         ///< Set by ty_default_sky_def() and checked.
    uint32_t bytes;          ///< Set by ty_default_sky_def() to the size of the structure, and checked.
    double sun_direction[3]; ///< Direction in which sunlight travels, not zero; default (-0.5, -0.6, -0.4).
    float solar[3];          ///< Irradiance above the atmosphere per channel, W m^-2; default (1.00, 1.00, 1.00) * 1.5.
    double haze;             ///< Amount of aerosol, 0 (clear) .. 10; default 1.
    float ground[3];         ///< Albedo of the ground, which is seen below the horizon, 0..1; default 0.2.
    ty_axis up_axis;         ///< Default TY_AXIS_Y.
    int32_t width; ///< Width of the equirectangular image, even, 16..8192; default 512; the height is half of it.
    double ozone;  ///< Amount of ozone, 0..10; default 1.
    ty_sky_scattering scattering; ///< Default TY_SKY_ORDERS.
    double height; ///< Height of the observer above the ground, m, 2..10000; default 2. Only what is above is seen.
} ty_sky_def;

/// Periodic lateral boundaries: the scene repeats along some axes. Light that leaves the cell by one of its faces comes
/// in by the opposite one, as if copies of the cell filled space without seams; grids that span the cell from face to
/// face are interpolated across the faces. Surfaces are cut off at the faces of the cell. Such scenes take directional
/// and environment lights, media that emit, and surfaces that are no dielectrics. ty_path_...() takes them; other
/// methods refuse them. Create it with ty_default_periodic_def().
typedef struct ty_periodic_def {
    uint32_t cookie; ///< Set by ty_default_periodic_def() and checked.
    uint32_t bytes;  ///< Set by ty_default_periodic_def() to the size of the structure, and checked.
    bool axes[3];    ///< True: the scene repeats along x, y, z; at most two of them; default none.
    double
        lower[3]; ///< Lower corner of the cell, m; other axes do not count. Default: that of the box around the media.
    double upper[3]; ///< Upper corner, m. Along an axis where it is not above `lower` (default) the media give both.
} ty_periodic_def;

/// Sets the `bytes` bytes of a ty_periodic_def to the defaults, as ty_init_context_def() does.
TY_API void ty_init_periodic_def(void* def, size_t bytes);
/// A definition with all fields at their defaults.
static inline ty_periodic_def ty_default_periodic_def(void) {
    ty_periodic_def def;
    ty_init_periodic_def(&def, sizeof def);
    return def;
}
/// Sets the `bytes` bytes of a ty_camera_def to the defaults, as ty_init_context_def() does.
TY_API void ty_init_camera_def(void* def, size_t bytes);
/// A definition with all fields at their defaults.
static inline ty_camera_def ty_default_camera_def(void) {
    ty_camera_def def;
    ty_init_camera_def(&def, sizeof def);
    return def;
}
/// Sets the `bytes` bytes of a ty_medium_def to the defaults, as ty_init_context_def() does.
TY_API void ty_init_medium_def(void* def, size_t bytes);
/// A definition with all fields at their defaults.
static inline ty_medium_def ty_default_medium_def(void) {
    ty_medium_def def;
    ty_init_medium_def(&def, sizeof def);
    return def;
}
/// Sets the `bytes` bytes of a ty_light_def to the defaults, as ty_init_context_def() does.
TY_API void ty_init_light_def(void* def, size_t bytes);
/// A definition with all fields at their defaults.
static inline ty_light_def ty_default_light_def(void) {
    ty_light_def def;
    ty_init_light_def(&def, sizeof def);
    return def;
}
/// Sets the `bytes` bytes of a ty_shape_def to the defaults, as ty_init_context_def() does.
TY_API void ty_init_shape_def(void* def, size_t bytes);
/// A definition with all fields at their defaults.
static inline ty_shape_def ty_default_shape_def(void) {
    ty_shape_def def;
    ty_init_shape_def(&def, sizeof def);
    return def;
}
/// Sets the `bytes` bytes of a ty_material_def to the defaults, as ty_init_context_def() does.
TY_API void ty_init_material_def(void* def, size_t bytes);
/// A definition with all fields at their defaults.
static inline ty_material_def ty_default_material_def(void) {
    ty_material_def def;
    ty_init_material_def(&def, sizeof def);
    return def;
}
/// Sets the `bytes` bytes of a ty_mesh_def to the defaults, as ty_init_context_def() does.
TY_API void ty_init_mesh_def(void* def, size_t bytes);
/// A definition with all fields at their defaults.
static inline ty_mesh_def ty_default_mesh_def(void) {
    ty_mesh_def def;
    ty_init_mesh_def(&def, sizeof def);
    return def;
}
/// Sets the `bytes` bytes of a ty_sky_def to the defaults, as ty_init_context_def() does.
TY_API void ty_init_sky_def(void* def, size_t bytes);
/// A definition with all fields at their defaults.
static inline ty_sky_def ty_default_sky_def(void) {
    ty_sky_def def;
    ty_init_sky_def(&def, sizeof def);
    return def;
}

/// Creates the image of a sky (R, G, B) for an environment light, and stores the irradiance of the sun at the ground,
/// W m^-2. Errors: TY_ERROR_ARGUMENT, TY_ERROR_MEMORY.
TY_API ty_result ty_sky_create_image(ty_context* context, const ty_sky_def* def, ty_image** out,
                                     float sun_irradiance[3]);

/// Adds the air and the haze of a sky as media that fill a box, with the ground at its lower face: aerial perspective.
/// Their densities fall off exponentially along the scene's up axis. The sky's image must hold no light of that air,
/// so that it is made with `height` = height of the box. Errors: as ty_scene_add_medium().
TY_API ty_result ty_scene_add_sky_air(ty_scene* scene, const ty_sky_def* sky, const double box_min[3],
                                      const double box_max[3]);

/// Creates an empty scene. Errors: TY_ERROR_ARGUMENT, TY_ERROR_MEMORY.
TY_API ty_result ty_scene_create(ty_context* context, ty_axis up_axis, ty_scene** out);
/// Destroys a scene; NULL is allowed. Light that was solved for the scene, images, caches and atlases may outlive it;
/// the arrays of ty_scene_get_mesh() and the names of ty_scene_get_medium() may not.
TY_API void ty_scene_destroy(ty_scene* scene);

/// Sets the camera, which needs no commit. Errors: TY_ERROR_ARGUMENT (the message has the field and its range).
TY_API ty_result ty_scene_set_camera(ty_scene* scene, const ty_camera_def* def);
/// Sets periodic boundaries. ty_scene_commit() refuses scenes with parts that cannot repeat.
/// Errors: TY_ERROR_ARGUMENT (the message has the field).
TY_API ty_result ty_scene_set_periodic(ty_scene* scene, const ty_periodic_def* def);
/// Adds a medium. Errors: TY_ERROR_ARGUMENT (the message has the field and its range), TY_ERROR_MEMORY.
TY_API ty_result ty_scene_add_medium(ty_scene* scene, const ty_medium_def* def);
/// Adds a light. Errors: as ty_scene_add_medium().
TY_API ty_result ty_scene_add_light(ty_scene* scene, const ty_light_def* def);
/// Adds a shape. Errors: as ty_scene_add_medium().
TY_API ty_result ty_scene_add_shape(ty_scene* scene, const ty_shape_def* def);
/// Adds a mesh. Errors: as ty_scene_add_medium().
TY_API ty_result ty_scene_add_mesh(ty_scene* scene, const ty_mesh_def* def);

/// Builds ray tracing structures, majorants and tables of lights, which rendering needs. It must be called again after
/// further add calls, and not while another thread reads the scene. Errors: TY_ERROR_ARGUMENT (a periodic scene with
/// parts that cannot repeat), TY_ERROR_MEMORY, TY_ERROR_INTERNAL.
TY_API ty_result ty_scene_commit(ty_scene* scene);

/// The context of a scene.
TY_API ty_context* ty_scene_context(const ty_scene* scene);
/// The axis that points up.
TY_API ty_axis ty_scene_up_axis(const ty_scene* scene);
/// Stores the camera in the `bytes` bytes of a ty_camera_def; ty_scene_camera() calls it.
TY_API void ty_scene_copy_camera(const ty_scene* scene, void* out, size_t bytes);
/// The camera, or the default one if none was set.
static inline ty_camera_def ty_scene_camera(const ty_scene* scene) {
    ty_camera_def camera;
    ty_scene_copy_camera(scene, &camera, sizeof camera);
    return camera;
}

/// Stores the periodic boundaries in the `bytes` bytes of a ty_periodic_def; ty_scene_periodic() calls it.
TY_API void ty_scene_copy_periodic(const ty_scene* scene, void* out, size_t bytes);
/// The periodic boundaries: of a committed scene with the cell that it has.
static inline ty_periodic_def ty_scene_periodic(const ty_scene* scene) {
    ty_periodic_def def;
    ty_scene_copy_periodic(scene, &def, sizeof def);
    return def;
}

/// The method of a scene, and the options that all methods share; ty_scene_set_option() sets the options of one method.
typedef struct ty_render_settings {
    char method[16]; ///< "auto" (default; ty_choose_method()), or the name of a method (ty_method_name()).
    int32_t spp;     ///< Samples per pixel, 1..2^24; default 64.
    uint64_t seed;   ///< Default 0.
} ty_render_settings;

/// The settings of a scene.
TY_API ty_render_settings ty_scene_render_settings(const ty_scene* scene);
/// Sets the settings of a scene, which are checked by the calls that use them.
TY_API void ty_scene_set_render_settings(ty_scene* scene, const ty_render_settings* settings);

/// Sets one option of a method, as `render.METHOD.KEY` in a scene file does: ty_scene_set_option(scene, "dom",
/// "directions", "48"). value: a number, "true", "false", "auto" or a word; NULL removes the option. Keys and values
/// are checked by the calls that use them (ty_method_options()).
/// Errors: TY_ERROR_ARGUMENT (a text that is too long), TY_ERROR_MEMORY.
TY_API ty_result ty_scene_set_option(ty_scene* scene, const char* method, const char* key, const char* value);
/// The value of an option that was set, valid until the next option is set; NULL if it was not set.
TY_API const char* ty_scene_get_option(const ty_scene* scene, const char* method, const char* key);

/// A hash of the content of a scene file: its text after overrides, and the bytes of every file that it names. Equal
/// hashes tell that results belong to the same scene: ty_path_def.resume refuses the state of another one. 0 for a
/// scene that was built by calls.
TY_API uint64_t ty_scene_hash(const ty_scene* scene);

/// The mesh file that a scene file takes its camera from, in words, for reports; "" for a camera of its own. Valid as
/// long as the scene.
TY_API const char* ty_scene_camera_source(const ty_scene* scene);

/// Counts and memory of a scene.
typedef struct ty_scene_info {
    int32_t media;        ///< Number of media.
    int32_t lights;       ///< Number of lights.
    int32_t shapes;       ///< Number of shapes.
    int32_t meshes;       ///< Number of meshes.
    int64_t triangles;    ///< Number of triangles of meshes.
    int64_t textures;     ///< Number of textures of meshes.
    int64_t emitters;     ///< Number of sampled lights: lights, and quads, spheres and triangles that emit.
    bool bounded;         ///< True: the box below is not empty.
    double lower[3];      ///< Lower corner of the box around media and surfaces, m.
    double upper[3];      ///< Upper corner of that box, m.
    size_t bytes;         ///< Memory of grids, textures, tables and ray tracing structures.
    size_t texture_bytes; ///< Part of it that textures take.
} ty_scene_info;

/// Counts and memory of a scene, which are complete once it is committed.
TY_API ty_scene_info ty_scene_get_info(const ty_scene* scene);
/// Stores a medium in the `bytes` bytes of a ty_medium_def. Errors: as ty_scene_get_medium(), which calls it.
TY_API ty_result ty_scene_copy_medium(const ty_scene* scene, int32_t index, void* out, size_t bytes);
/// Stores a medium as it was added. Its name, arrays, grids and shell belong to the scene; no reference is added.
/// Errors: TY_ERROR_ARGUMENT (an index past the end).
static inline ty_result ty_scene_get_medium(const ty_scene* scene, int32_t index, ty_medium_def* out) {
    return ty_scene_copy_medium(scene, index, out, sizeof *out);
}
/// Stores the radiance of all environment lights together, mean over all directions, W m^-2 sr^-1; 0 without one.
TY_API void ty_scene_environment(const ty_scene* scene, float radiance[3]);
/// Stores a mesh in the `bytes` bytes of a ty_mesh_def. Errors: as ty_scene_get_mesh(), which calls it.
TY_API ty_result ty_scene_copy_mesh(const ty_scene* scene, int32_t index, void* out, size_t bytes);
/// Stores a mesh in the coordinates of the scene, with an identity transform. Its arrays and textures belong to the
/// scene; no reference is added. Errors: TY_ERROR_ARGUMENT (an index past the end).
static inline ty_result ty_scene_get_mesh(const ty_scene* scene, int32_t index, ty_mesh_def* out) {
    return ty_scene_copy_mesh(scene, index, out, sizeof *out);
}

/// A ray.
typedef struct ty_ray {
    float origin[3];    ///< m, finite.
    float direction[3]; ///< Unit.
    float far;          ///< Length, m, > 0; infinity is allowed.
} ty_ray;

/// The first surface that a ray meets.
typedef struct ty_ray_hit {
    float distance;    ///< Distance from the origin, m; the ray's `far` without a surface.
    int32_t surface;   ///< Shapes in the order of their addition, then area lights, then meshes; -1 without a surface,
                       ///< and the fields below are 0.
    int32_t part;      ///< Side of a box (-x, +x, -y, ...), or triangle of a mesh; else 0.
    float b1;          ///< Triangles: weight of the second corner.
    float b2;          ///< Triangles: weight of the third corner.
    float position[3]; ///< m; exact to rounding, however long the ray.
    float normal[3];   ///< Unit normal of the flat face or the sphere, on its front.
    float margin;      ///< Distance along the normal, m, at which a new ray does not meet the surface again.
} ty_ray_hit;

/// The coherence of neighbouring rays in an array. It changes results by rounding at most.
typedef enum ty_ray_order {
    TY_RAYS_INCOHERENT = 0, ///< Rays are traced one by one.
    TY_RAYS_COHERENT = 1 ///< Neighbours are nearly parallel or share an end (a camera's pixels in small tiles, rays to
                         ///< one light), and are traced in packets of sixteen, which is faster.
} ty_ray_order;

/// Finds the first surface of a committed scene on each of many rays, on the threads of the context: hits[i] belongs to
/// rays[i]. A surface with alpha is met or not, as a function of the ray alone. Periodic boundaries do not count.
/// Errors: TY_ERROR_ARGUMENT (scene not committed, negative count).
TY_API ty_result ty_scene_trace(const ty_scene* scene, const ty_ray* rays, int64_t count, ty_ray_order order,
                                ty_ray_hit* hits);
/// Tells whether each ray meets any surface, which is faster. Errors: as ty_scene_trace().
TY_API ty_result ty_scene_trace_shadows(const ty_scene* scene, const ty_ray* rays, int64_t count, ty_ray_order order,
                                        bool* shadowed);

#ifdef __cplusplus
}
#endif
#endif
