/* Tyndall: files. Apache-2.0.
 *
 * Writers write to a temporary name beside the target and rename, so that a target is whole or untouched.
 * Readers check every size before they allocate. Messages name the file and what is wrong with it. */
#ifndef TYNDALL_IO_H
#define TYNDALL_IO_H

#include <tyndall/base.h>
#include <tyndall/grid.h>
#include <tyndall/image.h>
#include <tyndall/scene.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Radiance .hdr, OpenEXR, PNG or JPEG, told by content.
 * EXR: half, float and uint channels of any compression, scanlines or tiles (the largest level). The data window's
 * place in the display window becomes the image's frame; metadata comes along. In a multi-part file, the first part's
 * channels keep their names and those of the others are called "part.channel"; the image is the smallest that holds the
 * data of all parts, 0 where a part has none, and has the first part's metadata. Subsampled channels and deep parts are
 * refused.
 * PNG and JPEG: R, G, B (or Y), and A where there is one, 8 or 16 bit, decoded from sRGB to linear (alpha is linear,
 * and colour is not multiplied by it); gamma values and colour profiles in the file are not used. Palettes become R, G,
 * B, and transparent colours A. CMYK becomes R, G, B without a profile. Orientation marks (EXIF) are not applied.
 * Errors: TY_ERROR_FILE, TY_ERROR_INPUT, TY_ERROR_MEMORY. */
TY_API ty_result ty_image_read(ty_context* context, const char* path, ty_image** out);
/* The same without decoding sRGB: PNG and JPEG samples as they are, 0..1, as for depth maps. */
TY_API ty_result ty_image_read_raw(ty_context* context, const char* path, ty_image** out);
/* The same with PNG and JPEG samples as the whole numbers that they are, so that scaling them to metres is exact.
 * *largest: 255 or 65535 (samples of fewer bits are scaled to 8), or 0 for the other formats, which are read as they
 * are; may be NULL. */
TY_API ty_result ty_image_read_whole(ty_context* context, const char* path, ty_image** out, int32_t* largest);
/* One layer of an image: the channels "layer.NAME" under the names NAME, which may have dots; "" takes those without a
 * layer. Frame and metadata come along. A missing layer's message lists those that are there.
 * Errors: TY_ERROR_ARGUMENT, TY_ERROR_MEMORY. */
TY_API ty_result ty_image_layer(ty_context* context, const ty_image* image, const char* layer, ty_image** out);

/* OpenEXR: all channels as 32-bit float, ZIP, with metadata and frame. Errors: TY_ERROR_FILE, TY_ERROR_MEMORY. */
TY_API ty_result ty_image_write_exr(ty_context* context, const ty_image* image, const char* path);
/* PNG, 16-bit, one channel by its index, value * scale rounded and clamped to 0..65535 (NaN is 0); for depth and masks.
 * Errors: TY_ERROR_FILE, TY_ERROR_ARGUMENT, TY_ERROR_MEMORY. */
TY_API ty_result ty_image_write_png16(ty_context* context, const ty_image* image, int32_t channel, double scale,
                                      const char* path);
/* PNG, 8-bit sRGB, through ty_image_tonemap. Errors: TY_ERROR_FILE, TY_ERROR_ARGUMENT (no RGB), TY_ERROR_MEMORY. */
TY_API ty_result ty_image_write_png(ty_context* context, const ty_image* image, double exposure, bool curve,
                                    const char* path);

/* One grid of an OpenVDB or NanoVDB file. */
typedef struct ty_vdb_entry {
    char name[128];             /* as the file says, cut */
    char type[32];              /* "float", "half", "vec3s", "fp16", ... as the file says */
    int64_t active_voxels;      /* -1: not known */
    int32_t lower[3], upper[3]; /* index box of active voxels, inclusive; lower > upper when empty */
    double voxel_size[3];       /* units of the file */
} ty_vdb_entry;

/* The grids of an OpenVDB or NanoVDB file, told by content. At most capacity entries are written; *count is how many
 * there are. Errors: TY_ERROR_FILE, TY_ERROR_INPUT, TY_ERROR_MEMORY. */
TY_API ty_result ty_vdb_list(ty_context* context, const char* path, ty_vdb_entry* entries, int32_t capacity,
                             int32_t* count);
/* A float, half or double grid by name, dense over its active box, placed by the file's affine transform (index ->
 * file units). A missing grid's message lists those that are there; an empty grid gives one voxel of background.
 * Half grids stay half. Errors: TY_ERROR_FILE, TY_ERROR_INPUT, TY_ERROR_MEMORY. */
TY_API ty_result ty_vdb_read(ty_context* context, const char* path, const char* grid_name, ty_grid** out);
/* Writes one grid (values equal to background are left inactive), codec "none", "zip" or "blosc".
 * Errors: TY_ERROR_FILE, TY_ERROR_ARGUMENT. */
TY_API ty_result ty_vdb_write(ty_context* context, const ty_grid* grid, const char* grid_name, const char* codec,
                              const char* path);

/* ---- Volumes of any kind ---- */

/* What of a volume file is read, and how; made by ty_default_volume_def. */
typedef struct ty_volume_def {
    uint32_t cookie;       /* set by ty_default_volume_def; checked */
    const char* grid;      /* VDB, NanoVDB: the grid's name; default "density" */
    int32_t component;     /* of grids and NRRDs with several values per voxel; default 0 */
    int32_t frame;         /* takes the place of the #s in the file's name, zero-padded to as many digits; default 0 */
    int32_t raw_size[3];   /* raw: x, y, z, x fastest; default 0 (must be set for raw) */
    char raw_type[8];      /* raw: int8, uint8, ... uint64, half, float, double; default "uint8" */
    bool raw_big_endian;   /* default false */
    int64_t raw_offset;    /* raw: bytes to skip; -1: as many as the file has too many; default 0 */
    double raw_spacing[3]; /* raw: units between voxels, the first one's centre at 0; default 0: unplaced */
} ty_volume_def;

/* A def with every field at its default. */
TY_API ty_volume_def ty_default_volume_def(void);
/* A scalar grid from an OpenVDB (.vdb: float, half, double, vec3s by component), NanoVDB (.nvdb, plain or zip: float,
 * half, double, fp4 to fp16, fpn, vec3f by component), NRRD (.nrrd, .nhdr; raw, gzip, text; attached data, or one file
 * in the header's folder or below it) or raw file (any other extension, with raw_size), told by content where that is
 * possible. VDB and NanoVDB grids come as by ty_vdb_read.
 * NRRDs have three axes, or four of which the first or last holds components (by kinds, else the first or last of at
 * most 4). They are placed by their space directions or spacings and origin (spacings without an origin: the first
 * voxel's centre at 0; neither: spacing 1), in the file's units, axes in the order of the file; axis mins and maxs,
 * thicknesses, centerings and the name of the space are not looked at. Raw data must be exactly as long as the header
 * or raw_size says.
 * Values are kept as they are, as float (half when the file has half, and for int8 and uint8, which it holds exactly).
 * Errors: TY_ERROR_FILE, TY_ERROR_INPUT, TY_ERROR_MEMORY, TY_ERROR_ARGUMENT. */
TY_API ty_result ty_volume_read(ty_context* context, const char* path, const ty_volume_def* def, ty_grid** out);
/* The path with the #s of the file's name, which stand in one place there, replaced; those of folders are kept; size:
 * of out. Errors: TY_ERROR_ARGUMENT (too long, negative frame, #s in several places). */
TY_API ty_result ty_volume_path(ty_context* context, const char* path, int32_t frame, char* out, size_t size);
/* How many values per voxel a grid of the file has (1, or 3 for vec3s); errors as ty_volume_read. */
TY_API ty_result ty_volume_components(ty_context* context, const char* path, const ty_volume_def* def, int32_t* out);
/* NRRD with space directions and origin; float (half grids too: NRRD has no half), gzip or raw.
 * Errors: TY_ERROR_FILE, TY_ERROR_ARGUMENT, TY_ERROR_MEMORY. */
TY_API ty_result ty_nrrd_write(ty_context* context, const ty_grid* grid, bool gzip, const char* path);
/* NanoVDB, float, values equal to the background inactive, codec "none" or "zip". Errors as ty_vdb_write. */
TY_API ty_result ty_nanovdb_write(ty_context* context, const ty_grid* grid, const char* grid_name, const char* codec,
                                  const char* path);

/* ---- Meshes ---- */

/* Files are told by content (OBJ by its extension), and may name others only in their own folder or below.
 *
 * glTF 2.0 (.gltf, .glb): the default scene, or the first, or without scenes all nodes. Materials become Lambertian
 * surfaces of their base colour (metal and roughness are not looked at) with emission, alpha and double-sidedness.
 * Triangles, strips and fans are taken, a primitive of anything else is left out with a warning, as are meshes scaled
 * to 0; skins, animations and morph targets are ignored. Extensions: KHR_lights_punctual, KHR_texture_transform,
 * KHR_materials_emissive_strength, KHR_materials_unlit (ignored), KHR_mesh_quantization; a file that requires another
 * is refused.
 *
 * Wavefront OBJ (.obj with .mtl): polygons become fans about their first corner, which suits convex ones. Kd, Ke, d,
 * map_Kd and map_Ke count; colours of vertices are taken as linear. A missing .mtl is a warning, a missing map an
 * error.
 *
 * PLY, text or binary: polygons as in OBJ; integer colours of vertices are taken as sRGB, floats as linear.
 *
 * What has no material is grey 0.5, or its vertices' colours; in glTF it is white, as its specification says. */
typedef struct ty_mesh_file_def {
    uint32_t cookie;                 /* set by ty_default_mesh_file_def; checked */
    ty_affine transform;             /* file units to m, invertible; default identity */
    bool to_z_up;                    /* turn y-up files (glTF) into a z-up scene, (x, y, z) -> (x, -z, y), before
                                        transform; default false */
    bool meshes, lights;             /* what to take; default true */
    double light_scale;              /* multiplies intensity and irradiance of punctual lights, 0..1e15; default 1: a
                                        candela counts as 1 W sr^-1, a lux as 1 W m^-2 */
    double emission_scale;           /* multiplies emission of materials, 0..1e15; default 1 */
    const ty_material_def* material; /* takes the place of all materials, whose textures are then not read; vertex
                                        colours still multiply it; default NULL */
} ty_mesh_file_def;

/* A def with every field at its default. */
TY_API ty_mesh_file_def ty_default_mesh_file_def(void);
/* Adds the meshes and lights of a file to a scene; when it fails, some may have been added.
 * Errors: TY_ERROR_FILE, TY_ERROR_INPUT, TY_ERROR_MEMORY, TY_ERROR_ARGUMENT (def). */
TY_API ty_result ty_scene_add_mesh_file(ty_scene* scene, const char* path, const ty_mesh_file_def* def);
/* A camera of a glTF file by name (its own, or its node's when it has none), or the first when name is NULL: position,
 * target (1 m ahead), up and fov_y are set, the rest of *camera stays; *found tells whether there was one, and *camera
 * stays as it is when not. OBJ and PLY files have none. A wrong name's message lists those that are there; an
 * orthographic camera is TY_ERROR_INPUT. Errors otherwise as ty_scene_add_mesh_file. */
TY_API ty_result ty_mesh_file_camera(ty_context* context, const char* path, const ty_mesh_file_def* def,
                                     const char* name, ty_camera_def* camera, bool* found);
/* All triangles of a file as one shell; to_z_up and transform are applied to it. Errors: TY_ERROR_INPUT (also when
 * there are no triangles), the rest as ty_scene_add_mesh_file. */
TY_API ty_result ty_mesh_file_create_closed_mesh(ty_context* context, const char* path, const ty_mesh_file_def* def,
                                                 ty_closed_mesh** out);

/* A material or a camera of a mesh file. */
typedef struct ty_mesh_file_entry {
    bool camera;    /* else a material */
    char name[128]; /* as the file says, cut; "" where it has none */
    double fov_y;   /* of cameras, degrees; 0: orthographic */
} ty_mesh_file_entry;

/* What a file holds: a scene of it alone, as ty_scene_get_info tells of it, then all materials and cameras. At most
 * capacity entries are written; *count is how many there are. Errors: TY_ERROR_FILE, TY_ERROR_INPUT, TY_ERROR_MEMORY,
 * TY_ERROR_ARGUMENT (out, count or, with a capacity, entries is NULL). */
TY_API ty_result ty_mesh_file_list(ty_context* context, const char* path, ty_scene_info* out,
                                   ty_mesh_file_entry* entries, int32_t capacity, int32_t* count);

/* Colours for the vertices of one mesh of a glTF file. */
typedef struct ty_mesh_colors {
    ty_mesh_origin origin; /* as ty_scene_get_mesh tells it; file is not looked at */
    int64_t count;         /* vertices, as many as the mesh has */
    const float* rgb;      /* 3 per vertex, linear, 0..1 */
} ty_mesh_colors;

/* Copies a glTF file to a GLB in which the given meshes have these colours (COLOR_0, floats); colours that they had
 * become the next COLOR_n that is free. Where several nodes share a mesh, each gets its own, with the arrays shared.
 * Buffers and images in files of their own are taken into the GLB; all else stays as it is. extras: the text of a JSON
 * object, which is put at extras.tyndall of the file, or NULL.
 * Errors: TY_ERROR_FILE, TY_ERROR_INPUT (also when the file is no longer what it was), TY_ERROR_MEMORY,
 * TY_ERROR_ARGUMENT. */
TY_API ty_result ty_mesh_file_write_colors(ty_context* context, const char* from, const ty_mesh_colors* colors,
                                           int64_t count, const char* extras, const char* path);

/* ---- Points ---- */

/* Points from a JSON file: an array of [x, y, z], or an object that has such an array at "positions"; m. 3 floats a
 * point, *count points, at least one; freed with ty_points_free. Errors: TY_ERROR_FILE, TY_ERROR_INPUT,
 * TY_ERROR_MEMORY. */
TY_API ty_result ty_points_read(ty_context* context, const char* path, float** out, int64_t* count);
/* Frees what ty_points_read gave. */
TY_API void ty_points_free(ty_context* context, float* points, int64_t count);

/* ---- Any file ---- */

/* A file's bytes, freed with ty_bytes_free. Errors: TY_ERROR_FILE, TY_ERROR_INPUT (more than limit bytes),
 * TY_ERROR_MEMORY, TY_ERROR_ARGUMENT. */
TY_API ty_result ty_bytes_read(ty_context* context, const char* path, size_t limit, uint8_t** bytes, size_t* size);
/* Frees what ty_bytes_read gave. */
TY_API void ty_bytes_free(ty_context* context, uint8_t* bytes, size_t size);
/* Writes bytes to a file, whole or not at all. Errors: TY_ERROR_FILE, TY_ERROR_MEMORY, TY_ERROR_ARGUMENT. */
TY_API ty_result ty_bytes_write(ty_context* context, const char* path, const void* bytes, size_t size);

/* A scene file (docs/scene.md). overrides: override_count strings "render.spp=16", "media[0].g=0.5": a path of
 * keys, then a JSON value or a bare word; applied before the file is checked. The scene comes committed.
 * Errors: TY_ERROR_FILE, TY_ERROR_INPUT, TY_ERROR_MEMORY, TY_ERROR_ARGUMENT (an override that is not one). */
TY_API ty_result ty_scene_load(ty_context* context, const char* path, const char* const* overrides,
                               int32_t override_count, ty_scene** out);
/* The same from text; name stands for the file in messages. folder is where relative paths start: "" is the current
 * folder, and with NULL the scene may name no files. */
TY_API ty_result ty_scene_parse(ty_context* context, const char* text, size_t length, const char* name,
                                const char* folder, const char* const* overrides, int32_t override_count,
                                ty_scene** out);
/* A homogeneous medium in words, as on a command line: the name of a preset, some with a number ("fog:50", visibility
 * in metres; "wholemilk:1000", one part in a thousand parts of a mixture with water: ty_medium_preset_with), or a JSON
 * object with the keys of a medium in a scene file that say what it is made of (docs/scene.md), such as
 * {"sigma_s": 0.1, "g": 0.9}. Sets sigma_s, sigma_a (scale is multiplied in) and g; the rest of *medium is the default.
 * *medium stays as it is when it fails, and messages begin with "medium". Errors: TY_ERROR_INPUT, TY_ERROR_ARGUMENT,
 * TY_ERROR_MEMORY. */
TY_API ty_result ty_medium_parse(ty_context* context, const char* text, ty_medium_def* medium);
/* The JSON Schema that scene files are checked against. */
TY_API const char* ty_scene_schema(void);

#ifdef __cplusplus
}
#endif
#endif
