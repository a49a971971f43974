/// @file io.h
/// Files of images, volumes, meshes, points and scenes.
///
/// A writer writes to a temporary name beside the target and renames it, so that the target is complete or untouched. A
/// reader checks every size before it allocates. Messages name the file and the fault. Apache-2.0.
#ifndef TYNDALL_IO_H
#define TYNDALL_IO_H

#include <tyndall/base.h>
#include <tyndall/grid.h>
#include <tyndall/image.h>
#include <tyndall/phase.h>
#include <tyndall/scene.h>

#ifdef __cplusplus
extern "C" {
#endif

/// Reads a Radiance .hdr, OpenEXR, PNG or JPEG file, told by its content.
///
/// OpenEXR: half, float and uint channels of any compression, scanlines or tiles (the largest level). The data window
/// in the display window becomes the frame of the image, and metadata is kept. In a multi-part file, channels of the
/// first part keep their names, and those of others are called "part.channel"; the image is the smallest one that holds
/// the data of all parts, with 0 where a part has none, and has the metadata of the first part. Subsampled channels and
/// deep parts are refused.
///
/// PNG and JPEG: R, G, B (or Y), and A where there is one, 8 or 16 bit, decoded from sRGB to linear. Alpha is linear,
/// and colour is not multiplied by it. Gamma values, colour profiles and EXIF orientation are ignored. Palettes become
/// R, G, B, and transparent colours A. CMYK becomes R, G, B without a profile.
///
/// Errors: TY_ERROR_FILE, TY_ERROR_INPUT, TY_ERROR_MEMORY.
TY_API ty_result ty_image_read(ty_context* context, const char* path, ty_image** out);
/// Reads an image as ty_image_read(), but PNG and JPEG samples as they are, 0..1, without decoding sRGB, as for depth
/// maps.
TY_API ty_result ty_image_read_raw(ty_context* context, const char* path, ty_image** out);
/// Reads an image as ty_image_read(), but PNG and JPEG samples as integers, which can be scaled to metres exactly.
/// `*largest` is 255 or 65535 (samples of fewer bits are scaled to 8), or 0 for other formats, which are read as they
/// are; it may be NULL.
TY_API ty_result ty_image_read_whole(ty_context* context, const char* path, ty_image** out, int32_t* largest);
/// Creates an image of one layer: the channels "layer.NAME" under the names NAME, which may contain dots; "" takes the
/// channels without a layer. Frame and metadata are kept. The message about a missing layer lists the existing ones.
/// Errors: TY_ERROR_ARGUMENT, TY_ERROR_MEMORY.
TY_API ty_result ty_image_create_layer(ty_context* context, const ty_image* image, const char* layer, ty_image** out);

/// Writes an OpenEXR file: all channels as 32-bit floats with ZIP compression, metadata and frame.
/// Errors: TY_ERROR_FILE, TY_ERROR_MEMORY.
TY_API ty_result ty_image_write_exr(ty_context* context, const ty_image* image, const char* path);
/// Writes one channel, by its index, as a 16-bit PNG file: value * scale, rounded and clamped to 0..65535 (NaN: 0), for
/// depth and masks. Errors: TY_ERROR_FILE, TY_ERROR_ARGUMENT, TY_ERROR_MEMORY.
TY_API ty_result ty_image_write_png16(ty_context* context, const ty_image* image, int32_t channel, double scale,
                                      const char* path);
/// Writes an 8-bit sRGB PNG file by way of ty_image_tonemap().
/// Errors: TY_ERROR_FILE, TY_ERROR_ARGUMENT (no RGB), TY_ERROR_MEMORY.
TY_API ty_result ty_image_write_png(ty_context* context, const ty_image* image, double exposure, ty_tone_curve curve,
                                    const char* path);

/// One grid of an OpenVDB or NanoVDB file.
typedef struct ty_vdb_entry {
    char name[128];        ///< Name in the file, cut to 127 bytes.
    char type[32];         ///< Type in the file: "float", "half", "vec3s", "fp16", ...
    int64_t active_voxels; ///< Number of active voxels; -1: unknown.
    int32_t lower[3];      ///< Lower corner of the box of active voxels, inclusive; above `upper` in an empty grid.
    int32_t upper[3];      ///< Upper corner of that box, inclusive.
    double voxel_size[3];  ///< Size of a voxel, units of the file.
} ty_vdb_entry;

/// Lists the grids of an OpenVDB or NanoVDB file, told by its content. At most `capacity` entries are stored; `*count`
/// is the number of grids. Errors: TY_ERROR_FILE, TY_ERROR_INPUT, TY_ERROR_MEMORY.
TY_API ty_result ty_vdb_list(ty_context* context, const char* path, ty_vdb_entry* entries, int32_t capacity,
                             int32_t* count);
/// Reads a float, half or double grid by name, dense over its active box, placed by the affine transform of the file
/// (index -> file units). An empty grid gives one voxel of background, and a half grid stays half. The message about a
/// missing grid lists the existing ones. Errors: TY_ERROR_FILE, TY_ERROR_INPUT, TY_ERROR_MEMORY.
TY_API ty_result ty_vdb_read(ty_context* context, const char* path, const char* grid_name, ty_grid** out);
/// Writes one grid to an OpenVDB file; values equal to the background are left inactive. codec: "none", "zip" or
/// "blosc". Errors: TY_ERROR_FILE, TY_ERROR_ARGUMENT.
TY_API ty_result ty_vdb_write(ty_context* context, const ty_grid* grid, const char* grid_name, const char* codec,
                              const char* path);

/// The part of a volume file to read, and its layout. Create it with ty_default_volume_def().
typedef struct ty_volume_def {
    uint32_t cookie;       ///< Set by ty_default_volume_def() and checked.
    uint32_t bytes;        ///< Set by ty_default_volume_def() to the size of the structure, and checked.
    const char* grid;      ///< OpenVDB, NanoVDB: name of the grid; default "density".
    int32_t component;     ///< Component of files with several values per voxel; default 0.
    int32_t frame;         ///< Number that replaces the `#` characters of the file's name, padded with zeros to as many
                           ///< digits; default 0.
    int32_t raw_size[3];   ///< Raw files: voxels along x, y, z, x fastest; must be set for these.
    char raw_type[8];      ///< Raw files: int8, uint8, ... uint64, half, float, double; default "uint8".
    bool raw_big_endian;   ///< Raw files: byte order; default false.
    int64_t raw_offset;    ///< Raw files: bytes to skip; -1: the bytes that the file has beyond its voxels; default 0.
    double raw_spacing[3]; ///< Raw files: units between voxels, the centre of the first one at 0; default 0: unplaced.
    const char* series;    ///< DICOM folders: number, description or UID of the series; default "": the only one.
    bool exact_grid;       ///< VTK, NetCDF: true: `grid` must be there. False (default): in a file without it, the
                           ///< active scalars or the only grid are read.
    double meters_per_unit;       ///< NetCDF: unit of placements, m, (0, 1e6]; default 1. Coordinates without units of
                                  ///< their own are taken as they are.
    const char* effective_radius; ///< NetCDF: with it or `droplet_radius` the grid is liquid water, and its extinction
                                  ///< is read, 1/m. Name of the effective radius of droplets; default NULL.
    double droplet_radius;        ///< NetCDF: effective radius, micrometres, (0, 1e4], in place of a grid; default 0.
    const char* air_density;      ///< NetCDF: name of the density of the air, for water in mass per mass; default NULL.
    double air_density_value;     ///< NetCDF: that density, kg m^-3, (0, 1e3], in place of a grid; default 0.
    ty_grid_storage storage;      ///< Storage of the grid in memory; default TY_GRID_AUTO.
    bool in_part;                 ///< True: only the blocks of 8^3 voxels that the part touches are read and stored,
                                  ///< sparse or paged; size and placement are of the whole grid, and all other voxels
                                  ///< have one value, as has a voxel outside of the grid. Default false: the whole.
    int32_t part_first[3];        ///< First voxel of the part along x, y, z; default 0.
    int32_t part_end[3];          ///< The voxel behind the part's last one; default 0. Voxels outside of the grid do
                                  ///< not count, and a part without voxels is allowed.
} ty_volume_def;

/// Sets the `bytes` bytes of a ty_volume_def to the defaults, as ty_init_context_def() does.
TY_API void ty_init_volume_def(void* def, size_t bytes);
/// A definition with all fields at their defaults.
static inline ty_volume_def ty_default_volume_def(void) {
    ty_volume_def def;
    ty_init_volume_def(&def, sizeof def);
    return def;
}
/// Reads a scalar grid, told by content where that is possible, from an OpenVDB file (.vdb: float, half, double, vec3s
/// by component), a NanoVDB file (.nvdb, plain or zip: float, half, double, fp4 to fp16, fpn, vec3f by component), an
/// NRRD file (.nrrd, .nhdr; raw, gzip, text; attached data, or one file in the header's folder or below it), a DICOM
/// series (its folder, or one of its files), a NIfTI file (.nii, .nii.gz, .hdr with .img), a TIFF stack, a .vol file of
/// Mitsuba or a raw file (any other extension, with raw_size). OpenVDB and NanoVDB grids are as by ty_vdb_read().
/// An image of VTK (.vti, .vtk with structured points) and a NetCDF file (.nc, .cdf) are read likewise.
///
/// DICOM: slices are in the order of their positions along the normal, evenly spaced, placed in mm (left, posterior,
/// superior); values are scaled by slope and intercept. NIfTI: placed by sform, qform or spacings in the file's unit
/// (right, anterior, superior), scaled. TIFF: pages are slices; ImageJ and OME place them. Mitsuba: voxels fill the
/// file's box. Outside of a placed volume of these kinds, an NRRD or a raw file, the value is the lowest one, or 0 if
/// none is below.
///
/// VTK files have arrays of values at points, which become the centres of voxels, or in cells, placed by extent,
/// origin, spacing and direction. NetCDF variables have three axes of space, in any order, which their coordinates
/// tell, and may have one of times, which `component` chooses; docs/formats.md has the conventions. Positions are in
/// `meters_per_unit` where coordinates have units. Coordinates that are not evenly spaced are resampled to even
/// ones with the same integral, which a warning tells. Missing values are 0.
///
/// Droplets have the extinction coefficient sigma_t = 3 LWC / (2 rho_w r_e), of liquid water content LWC, density of
/// water rho_w = 1000 kg m^-3 and effective radius r_e (Stephens 1978, for extinction by twice the cross section).
///
/// An NRRD file has three axes, or four of which the first or last holds components (by kinds, else the first or last
/// of at most 4). Its space directions, or spacings, and its origin place the grid in units of the file, axes in the
/// order of the file: with spacings but no origin the centre of the first voxel is at 0, and without both the spacing
/// is 1. Axis mins and maxs, thicknesses, centerings and the name of the space are ignored. Raw data must be exactly as
/// long as the header or raw_size tells.
///
/// A part is read without the rest of the grid in memory: raw, NRRD, NIfTI, Mitsuba and VTK files by their rows,
/// TIFF, DICOM and NetCDF by slices, OpenVDB, NanoVDB and bricks from the mapped file, compressed NanoVDB from a file
/// without a name in the folder that TMPDIR names. Exceptions are those below. A part's range, mean and active voxels
/// are of what is stored, and so is the lowest value where that is the one outside.
///
/// Values are stored as they are, as float, or as half for half, int8 and uint8, which half holds exactly. Files
/// become sparse grids without a dense array on the way, except for numbers in text, VTK files in pieces and NetCDF
/// variables whose z is behind x or y. Errors: TY_ERROR_FILE, TY_ERROR_INPUT, TY_ERROR_MEMORY,
/// TY_ERROR_ARGUMENT, TY_ERROR_UNSUPPORTED (NetCDF without its library).
TY_API ty_result ty_volume_read(ty_context* context, const char* path, const ty_volume_def* def, ty_grid** out);
/// Stores the path with the `#` characters of the file's name replaced by a frame number. They must stand next to each
/// other; those in names of folders are kept. size: size of out, bytes.
/// Errors: TY_ERROR_ARGUMENT (a path that is too long, a negative frame, several groups of `#`).
TY_API ty_result ty_volume_path(ty_context* context, const char* path, int32_t frame, char* out, size_t size);
/// Stores the number of values per voxel of a grid in a file: 1, or 3 for vec3s; of a NetCDF variable the number of
/// times. Errors: as ty_volume_read().
TY_API ty_result ty_volume_components(ty_context* context, const char* path, const ty_volume_def* def, int32_t* out);

/// Lists the grids of an OpenVDB, NanoVDB, VTK or NetCDF file as ty_vdb_list() does. Grids of VTK and NetCDF have the
/// box from 0 on, all of whose voxels are active, and the types int8, uint8, ... double, or float[3] for three values
/// per voxel. Errors: TY_ERROR_FILE, TY_ERROR_INPUT, TY_ERROR_MEMORY, TY_ERROR_ARGUMENT.
TY_API ty_result ty_volume_list(ty_context* context, const char* path, ty_vdb_entry* entries, int32_t capacity,
                                int32_t* count);

/// A named field of a volume file, for ty_volume_write().
typedef struct ty_volume_field {
    const char* name;        ///< Name in the file, 1 to 127 bytes.
    int32_t components;      ///< Values per voxel: 1, or 3 of a vector or of red, green and blue.
    const ty_grid* grids[3]; ///< A grid for each component, all of one size, placement and type.
} ty_volume_field;

/// Writes fields to a file whose format its extension tells. Codecs, of which NULL takes the first:
///
/// - .vdb, any number of fields: "zip", "blosc", "none". Vectors are vec3s grids; half grids are stored as half.
/// - .vti, any number of fields of one size and placement: "zip", "none". Floats at points, the centres of voxels.
/// - .nvdb, .nrrd, one field of one component: ty_nanovdb_write() with "zip", "none"; ty_nrrd_write() with "gzip",
///   "none".
/// - .vol, the same: ty_mitsuba_write() with "none".
/// - .nii ("none"), .nii.gz ("gzip"), one field: NIfTI-1 as float, placed by the sform in float; three components are a
///   vector. Units are not told.
///
/// Errors: TY_ERROR_FILE, TY_ERROR_ARGUMENT, TY_ERROR_MEMORY, and of .vol TY_ERROR_INPUT (voxels that are turned).
TY_API ty_result ty_volume_write(ty_context* context, const ty_volume_field* fields, int32_t count, const char* codec,
                                 const char* path);

/// The compression of data in an NRRD file.
typedef enum ty_nrrd_codec {
    TY_NRRD_CODEC_RAW = 0, ///< Plain bytes.
    TY_NRRD_CODEC_GZIP = 1 ///< Compressed bytes.
} ty_nrrd_codec;

/// Writes an NRRD file with space directions and origin, as float: NRRD has no half.
/// Errors: TY_ERROR_FILE, TY_ERROR_ARGUMENT, TY_ERROR_MEMORY.
TY_API ty_result ty_nrrd_write(ty_context* context, const ty_grid* grid, ty_nrrd_codec codec, const char* path);
/// Writes a .vol file of Mitsuba, version 3, as float, one value per voxel. Its voxels fill a box along the axes; an
/// unplaced grid fills the unit cube.
/// Errors: TY_ERROR_FILE, TY_ERROR_ARGUMENT, TY_ERROR_INPUT (a grid that is turned, sheared or reversed),
/// TY_ERROR_MEMORY.
TY_API ty_result ty_mitsuba_write(ty_context* context, const ty_grid* grid, const char* path);
/// Writes a NanoVDB file, as float; values equal to the background are inactive. codec: "none" or "zip".
/// Errors: TY_ERROR_FILE, TY_ERROR_ARGUMENT.
TY_API ty_result ty_nanovdb_write(ty_context* context, const ty_grid* grid, const char* grid_name, const char* codec,
                                  const char* path);

/// The parts of a mesh file to take, and their placement. Files are told by content (OBJ by its extension), and may
/// name others only in their own folder or below. Create it with ty_default_mesh_file_def().
///
/// glTF 2.0 (.gltf, .glb): the default scene, or the first one, or all nodes without scenes. Materials become
/// Lambertian surfaces of their base colour, with emission, alpha and double-sidedness; metal and roughness are
/// ignored. Triangles, strips and fans are taken. Primitives of other kinds, and meshes scaled to 0, are left out with
/// a warning; skins, animations and morph targets are ignored. Extensions: KHR_lights_punctual, KHR_texture_transform,
/// KHR_materials_emissive_strength, KHR_materials_unlit (ignored), KHR_mesh_quantization; a file that requires another
/// one is refused.
///
/// Wavefront OBJ (.obj with .mtl): polygons become fans about their first corner, which suits convex ones. Kd, Ke, d,
/// map_Kd and map_Ke count; colours of vertices are linear. A missing .mtl is a warning, a missing map an error.
///
/// PLY, text or binary: polygons as in OBJ; integer colours of vertices are sRGB, floats are linear.
///
/// A surface without material is grey 0.5, or has its vertices' colours; in glTF it is white, as its specification
/// says.
typedef struct ty_mesh_file_def {
    uint32_t cookie;       ///< Set by ty_default_mesh_file_def() and checked.
    uint32_t bytes;        ///< Set by ty_default_mesh_file_def() to the size of the structure, and checked.
    ty_affine transform;   ///< Map from file units to m, invertible; default identity.
    bool to_z_up;          ///< True: y-up files (glTF) are turned into a z-up scene, (x, y, z) -> (x, -z, y), before
                           ///< `transform`; default false.
    bool meshes;           ///< True (default): meshes are taken.
    bool lights;           ///< True (default): lights are taken.
    bool gloss;            ///< True (default): materials are glossy as they say; false: all are diffuse, of their base
                           ///< colour.
    double light_scale;    ///< Factor of intensity and irradiance of punctual lights, 0..1e15; default 1: a candela
                           ///< counts as 1 W sr^-1, and a lux as 1 W m^-2.
    double emission_scale; ///< Factor of the emission of materials, 0..1e15; default 1.
    const ty_material_def* material; ///< Replaces all materials, whose textures are then not read; colours of vertices
                                     ///< still multiply it; default NULL.
} ty_mesh_file_def;

/// Sets the `bytes` bytes of a ty_mesh_file_def to the defaults, as ty_init_context_def() does.
TY_API void ty_init_mesh_file_def(void* def, size_t bytes);
/// A definition with all fields at their defaults.
static inline ty_mesh_file_def ty_default_mesh_file_def(void) {
    ty_mesh_file_def def;
    ty_init_mesh_file_def(&def, sizeof def);
    return def;
}
/// Adds the meshes and lights of a file to a scene. After an error, some of them may have been added.
/// Errors: TY_ERROR_FILE, TY_ERROR_INPUT, TY_ERROR_MEMORY, TY_ERROR_ARGUMENT (definition).
TY_API ty_result ty_scene_add_mesh_file(ty_scene* scene, const char* path, const ty_mesh_file_def* def);
/// Reads a camera of a glTF file by its name, or its node's if it has none; NULL: the first one. It sets position,
/// target (1 m ahead), up and fov_y of `*camera`. `*found` tells whether there is a camera; without one `*camera` stays
/// as it is. OBJ and PLY files have none. The message about a wrong name lists the existing ones. Errors:
/// TY_ERROR_INPUT for an orthographic camera; otherwise as ty_scene_add_mesh_file().
TY_API ty_result ty_mesh_file_camera(ty_context* context, const char* path, const ty_mesh_file_def* def,
                                     const char* name, ty_camera_def* camera, bool* found);
/// Creates one shell of all triangles of a file, with one reference; to_z_up and transform apply.
/// Errors: TY_ERROR_INPUT (also without triangles); otherwise as ty_scene_add_mesh_file().
TY_API ty_result ty_mesh_file_create_closed_mesh(ty_context* context, const char* path, const ty_mesh_file_def* def,
                                                 ty_closed_mesh** out);

/// A material or a camera of a mesh file.
typedef struct ty_mesh_file_entry {
    bool camera;                      ///< True: a camera. False: a material.
    char name[128];                   ///< Name in the file, cut to 127 bytes; "" without one.
    double fov_y;                     ///< Cameras: vertical angle of view, degrees; 0: orthographic.
    bool glossy;                      ///< Materials: not Lambertian.
    ty_material_def material;         ///< Materials: the numbers; textures are NULL.
    bool base_texture;                ///< Materials: there is a texture of the base colour.
    bool emission_texture;            ///< Materials: there is one of the emission.
    bool textures[TY_GLOSS_TEXTURES]; ///< Materials: the others that there are, by ty_gloss_texture.
} ty_mesh_file_entry;

/// Lists the content of a file: counts as ty_scene_get_info() gives them for a scene of the file alone, and all
/// materials and cameras. At most `capacity` entries are stored; `*count` is their number in the file. Errors:
/// TY_ERROR_FILE, TY_ERROR_INPUT, TY_ERROR_MEMORY, TY_ERROR_ARGUMENT (out, count or, with a capacity, entries is NULL).
TY_API ty_result ty_mesh_file_list(ty_context* context, const char* path, ty_scene_info* out,
                                   ty_mesh_file_entry* entries, int32_t capacity, int32_t* count);

/// Colours for the vertices of one mesh of a glTF file.
typedef struct ty_mesh_colors {
    ty_mesh_origin origin; ///< The mesh, as ty_scene_get_mesh() gives it; its file is ignored.
    int64_t count;         ///< Number of vertices of the mesh.
    const float* rgb;      ///< 3 per vertex, linear, 0..1.
} ty_mesh_colors;

/// Copies a glTF file to a GLB file in which the given meshes have these colours (COLOR_0, floats). Colours that they
/// had become the next free COLOR_n. A mesh that several nodes share becomes one mesh per node, with shared arrays.
/// Buffers and images in separate files are taken into the GLB; all else stays as it is. extras: the text of a JSON
/// object that is stored at extras.tyndall of the file, or NULL. Errors: TY_ERROR_FILE, TY_ERROR_INPUT (also when the
/// file changed), TY_ERROR_MEMORY, TY_ERROR_ARGUMENT.
TY_API ty_result ty_mesh_file_write_colors(ty_context* context, const char* from, const ty_mesh_colors* colors,
                                           int64_t count, const char* extras, const char* path);

/// Second texture coordinates for one mesh of a glTF file, with the vertices that its charts need.
typedef struct ty_mesh_uv2 {
    ty_mesh_origin origin;   ///< The mesh, as ty_scene_get_mesh() gives it; its file is ignored.
    int64_t vertex_count;    ///< Number of new vertices.
    const int64_t* source;   ///< Per new vertex: the vertex of the mesh that it copies.
    const float* uv;         ///< 2 per new vertex, 0..1.
    int64_t triangle_count;  ///< Number of triangles.
    const uint32_t* indices; ///< 3 per triangle: new vertices.
} ty_mesh_uv2;

/// Copies a glTF file to a GLB file in which the given meshes have these vertices, with TEXCOORD_1, and these
/// triangles; all other attributes are copied. Of a mesh that several nodes share, the first node's counts. All else is
/// as in ty_mesh_file_write_colors(). Errors: TY_ERROR_FILE, TY_ERROR_INPUT (also meshes with morph targets or sparse
/// accessors), TY_ERROR_MEMORY, TY_ERROR_ARGUMENT.
TY_API ty_result ty_mesh_file_write_uv2(ty_context* context, const char* from, const ty_mesh_uv2* meshes, int64_t count,
                                        const char* path);

/// The content of a file with a phase function: text, with comments from # or ! to the end of the line.
typedef enum ty_phase_content {
    TY_PHASE_FILE_ANGLES = 0,       ///< Lines of an angle, degrees, and a value; further columns are ignored.
    TY_PHASE_FILE_COSINES = 1,      ///< The same with cosines.
    TY_PHASE_FILE_MOMENTS = 2,      ///< Legendre moments chi_l from l = 0 on, the first of which is 1.
    TY_PHASE_FILE_COEFFICIENTS = 3, ///< Coefficients of the Legendre series, (2 l + 1) chi_l, likewise.
    TY_PHASE_FILE_SHDOM = 4         ///< A scattering table of SHDOM: such coefficients for effective radii.
} ty_phase_content;

/// Reads a phase function into a table for a lobe TY_PHASE_TABLE: `cosines` and `values` have room for
/// TY_PHASE_NODES_MAX numbers, of which `*count` are set. A Legendre series is evaluated at angles so close that the
/// table resolves it; where it is below 0, as cut series are, the value is 0, with a warning if that adds more than
/// 1 % of the light. effective_radius: of TY_PHASE_FILE_SHDOM, micrometres, interpolated linearly between neighbours in
/// the table; 0 takes that of a table of one. Errors: TY_ERROR_FILE, TY_ERROR_INPUT, TY_ERROR_MEMORY,
/// TY_ERROR_ARGUMENT.
TY_API ty_result ty_phase_file_read(ty_context* context, const char* path, ty_phase_content content,
                                    double effective_radius, double* cosines, double* values, int32_t* count);

/// Reads points from a JSON file: an array of [x, y, z], m, or an object with such an array at "positions". `*out` has
/// 3 floats per point, for `*count` >= 1 points, and is freed with ty_points_destroy(). Errors: TY_ERROR_FILE,
/// TY_ERROR_INPUT, TY_ERROR_MEMORY.
TY_API ty_result ty_points_read(ty_context* context, const char* path, float** out, int64_t* count);
/// Frees the points of ty_points_read(); NULL is allowed.
TY_API void ty_points_destroy(ty_context* context, float* points, int64_t count);

/// Reads the bytes of a file, which are freed with ty_bytes_destroy().
/// Errors: TY_ERROR_FILE, TY_ERROR_INPUT (more than `limit` bytes), TY_ERROR_MEMORY, TY_ERROR_ARGUMENT.
TY_API ty_result ty_bytes_read(ty_context* context, const char* path, size_t limit, uint8_t** bytes, size_t* size);
/// Frees the bytes of ty_bytes_read(); NULL is allowed.
TY_API void ty_bytes_destroy(ty_context* context, uint8_t* bytes, size_t size);
/// Writes bytes to a file, completely or not at all. Errors: TY_ERROR_FILE, TY_ERROR_MEMORY, TY_ERROR_ARGUMENT.
TY_API ty_result ty_bytes_write(ty_context* context, const char* path, const void* bytes, size_t size);

/// Creates a committed scene from a scene file (docs/scene.md), or "builtin:NAME". overrides: override_count strings
/// such as "render.spp=16" or "media[0].g=0.5", a path of keys and then a JSON value or a bare word; they are applied
/// before the file is checked. Errors: TY_ERROR_FILE, TY_ERROR_INPUT, TY_ERROR_MEMORY, TY_ERROR_ARGUMENT (a malformed
/// override).
TY_API ty_result ty_scene_load(ty_context* context, const char* path, const char* const* overrides,
                               int32_t override_count, ty_scene** out);
/// Creates a committed scene from the text of a scene file. name stands for the file in messages. Relative paths start
/// at folder: "" is the current folder, and with NULL the scene may name no files. Errors: as ty_scene_load().
TY_API ty_result ty_scene_parse(ty_context* context, const char* text, size_t length, const char* name,
                                const char* folder, const char* const* overrides, int32_t override_count,
                                ty_scene** out);
/// Parses a homogeneous medium as on a command line: the name of a preset, for some with a number ("fog:50", visibility
/// in metres; "wholemilk:1000", one part in a thousand parts of a mixture with water: ty_medium_preset_with()), or a
/// JSON object with the keys of a medium in a scene file that give its coefficients (docs/scene.md), such as
/// {"sigma_s": 0.1, "g": 0.9}. It sets sigma_s, sigma_a (multiplied by scale) and g, and the rest of `*medium` to its
/// defaults. After an error `*medium` is unchanged. Messages begin with "medium".
/// Errors: TY_ERROR_INPUT, TY_ERROR_ARGUMENT, TY_ERROR_MEMORY.
TY_API ty_result ty_medium_parse(ty_context* context, const char* text, ty_medium_def* medium);
/// The JSON Schema of scene files.
TY_API const char* ty_scene_schema(void);

#ifdef __cplusplus
}
#endif
#endif
