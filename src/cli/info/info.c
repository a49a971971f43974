/* tyndall info: the contents of a file, and media by name. */
#include "cli/info/info.h"
#include "cli/commands.h"
#include "cli/options/raw_options.h"
#include "cli/text/text.h"
#include "io/file.h"
#include "io/volumes/volume_file.h"

#include <errno.h>
#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Memory of one component of a grid read densely; 0 for types that are not read. */
static double dense_bytes(const ty_vdb_entry* entry) {
    static const char* const floats[] = {"float", "double", "vec3s",  "vec3f", "fp4",    "fp8",   "fp16",
                                         "fpn",   "int16",  "uint16", "int32", "uint32", "int64", "uint64"};
    static const char* const halves[] = {"half", "int8", "uint8"};
    const size_t length = strcspn(entry->type, "[");
    double value = 0;
    for (size_t i = 0; i < sizeof floats / sizeof floats[0]; ++i)
        if (strlen(floats[i]) == length && strncmp(entry->type, floats[i], length) == 0) value = 4;
    for (size_t i = 0; i < sizeof halves / sizeof halves[0]; ++i)
        if (strlen(halves[i]) == length && strncmp(entry->type, halves[i], length) == 0) value = 2;
    double voxels = 1;
    for (int axis = 0; axis < 3; ++axis)
        voxels *= entry->lower[axis] > entry->upper[axis] ? 0 : (double)entry->upper[axis] - entry->lower[axis] + 1;
    return voxels * value;
}

static void print_grid(const ty_vdb_entry* entry) {
    char bytes[24];
    cli_format_bytes(dense_bytes(entry), bytes);
    cli_print_text(stdout, entry->name, 17);
    cli_print_text(stdout, entry->type, 8);
    printf(" %12" PRId64 " active voxels", entry->active_voxels);
    if (entry->lower[0] <= entry->upper[0])
        printf(" in (%d, %d, %d) to (%d, %d, %d)", entry->lower[0], entry->lower[1], entry->lower[2], entry->upper[0],
               entry->upper[1], entry->upper[2]);
    printf(", voxel %.6g x %.6g x %.6g", entry->voxel_size[0], entry->voxel_size[1], entry->voxel_size[2]);
    if (dense_bytes(entry) > 0) printf(", %s when dense", bytes);
    printf("\n");
}

static void print_grids_json(const char* path, const ty_vdb_entry* entries, int32_t count) {
    json_writer json = json_begin(stdout);
    json_open_object(&json, NULL);
    json_text(&json, "kind", "volume");
    json_text(&json, "file", path);
    json_open_array(&json, "grids");
    for (int32_t i = 0; i < count; ++i) {
        const ty_vdb_entry* entry = &entries[i];
        json_open_object(&json, NULL);
        json_text(&json, "name", entry->name);
        json_text(&json, "type", entry->type);
        json_int(&json, "active_voxels", entry->active_voxels);
        json_numbers(&json, "lower", (const double[]){entry->lower[0], entry->lower[1], entry->lower[2]}, 3);
        json_numbers(&json, "upper", (const double[]){entry->upper[0], entry->upper[1], entry->upper[2]}, 3);
        json_numbers(&json, "voxel_size", entry->voxel_size, 3);
        json_number(&json, "dense_bytes", dense_bytes(entry));
        json_close_object(&json);
    }
    json_close_array(&json);
    json_close_object(&json);
}

int cli_info_volume(cli_session* session, const char* path, bool json) {
    int32_t capacity = 16, count = 0;
    ty_vdb_entry* entries = NULL;
    do {
        if (count > capacity) capacity = count;
        free(entries);
        entries = calloc((size_t)capacity, sizeof *entries);
        if (entries == NULL) return cli_fail(CLI_FAILED, "not enough memory");
        const ty_result result = ty_volume_list(session->context, path, entries, capacity, &count);
        if (result != TY_OK) {
            free(entries);
            return cli_fail_reading(session, result);
        }
    } while (count > capacity);
    if (json) {
        print_grids_json(path, entries, count);
    } else {
        printf("volume           %s\n", path);
        for (int32_t i = 0; i < count; ++i) print_grid(&entries[i]);
    }
    free(entries);
    return CLI_DONE;
}

/* The voxels of a volume, and what its file tells beside them. */
typedef struct dense_volume {
    const char* path;
    ty_grid_info info;
    int32_t components;
    ty_volume_notes notes;
} dense_volume;

const char* cli_storage_name(ty_grid_storage storage) {
    return storage == TY_GRID_PAGED ? "paged" : storage == TY_GRID_SPARSE ? "sparse" : "dense";
}

const char* cli_storage_note(ty_grid_storage storage) {
    return storage == TY_GRID_PAGED ? "paged, with tables of " : storage == TY_GRID_SPARSE ? "sparse, " : "";
}

static void print_dense(const dense_volume* volume) {
    const ty_grid_info* info = &volume->info;
    char bytes[24];
    cli_format_bytes((double)info->bytes, bytes);
    printf("volume           %s\n", volume->path);
    for (int32_t i = 0; i < volume->notes.count; ++i) {
        printf("%-16s ", volume->notes.items[i].name);
        cli_print_text(stdout, volume->notes.items[i].text, 0);
        printf("\n");
    }
    printf("size             %dx%dx%d\nvalues           %d per voxel, %s when read, %s%s each\n", info->size[0],
           info->size[1], info->size[2], volume->components, info->type == TY_GRID_F16 ? "half" : "float",
           cli_storage_note(info->storage), bytes);
    printf("active           %" PRId64 " voxels\n", info->active);
    printf("range            %.6g to %.6g, mean %.6g\n", (double)info->min, (double)info->max, info->mean);
    if (!info->placed) printf("placed           no\n");
    for (int r = 0; r < 3 && info->placed; ++r) {
        const double* row = info->index_to_local.m + 4 * r;
        printf("%-16s %.9g %.9g %.9g %+.9g\n", r == 0 ? "index to place" : "", row[0], row[1], row[2], row[3]);
    }
}

/* Memory of a grid if it is dense. */
static double grid_dense_bytes(const ty_grid_info* info) {
    if (info->storage == TY_GRID_DENSE) return (double)info->bytes;
    const double voxels = (double)info->size[0] * info->size[1] * info->size[2];
    return voxels * (info->type == TY_GRID_F16 ? 2 : 4);
}

static void print_dense_json(const dense_volume* volume) {
    const ty_grid_info* info = &volume->info;
    json_writer json = json_begin(stdout);
    json_open_object(&json, NULL);
    json_text(&json, "kind", "volume");
    json_text(&json, "file", volume->path);
    json_open_object(&json, "notes");
    for (int32_t i = 0; i < volume->notes.count; ++i)
        json_text(&json, volume->notes.items[i].name, volume->notes.items[i].text);
    json_close_object(&json);
    json_numbers(&json, "size", (const double[]){info->size[0], info->size[1], info->size[2]}, 3);
    json_int(&json, "components", volume->components);
    json_text(&json, "type", info->type == TY_GRID_F16 ? "half" : "float");
    json_number(&json, "dense_bytes", grid_dense_bytes(info));
    json_int(&json, "bytes", (int64_t)info->bytes);
    json_text(&json, "storage", cli_storage_name(info->storage));
    json_int(&json, "active_voxels", info->active);
    json_number(&json, "min", (double)info->min);
    json_number(&json, "max", (double)info->max);
    json_number(&json, "mean", info->mean);
    json_bool(&json, "placed", info->placed);
    json_numbers(&json, "index_to_local", info->index_to_local.m, 12);
    json_close_object(&json);
}

/* One grid: of files with a single one, or one that is asked for. */
static int info_dense(cli_session* session, const char* path, const ty_volume_def* def, bool json) {
    ty_grid* grid = NULL;
    dense_volume volume = {.path = path};
    ty_result result = ty_volume_components(session->context, path, def, &volume.components);
    if (result == TY_OK) result = ty_volume_read(session->context, path, def, &grid);
    if (result != TY_OK) return cli_fail_reading(session, result);
    volume.info = ty_grid_get_info(grid);
    ty_grid_release(grid);
    ty_volume_describe(session->context, path, def, &volume.notes);
    if (json)
        print_dense_json(&volume);
    else
        print_dense(&volume);
    return CLI_DONE;
}

typedef struct channel_summary {
    double min, max, mean; /* statistics of the finite values */
    int64_t nan, infinite;
} channel_summary;

static channel_summary summarise(const float* values, int64_t count) {
    channel_summary summary = {.min = INFINITY, .max = -INFINITY};
    double sum = 0;
    int64_t finite = 0;
    for (int64_t i = 0; i < count; ++i) {
        const double value = (double)values[i];
        if (isnan(value)) {
            ++summary.nan;
        } else if (isinf(value)) {
            ++summary.infinite;
        } else {
            if (value < summary.min) summary.min = value;
            if (value > summary.max) summary.max = value;
            sum += value;
            ++finite;
        }
    }
    summary.mean = finite > 0 ? sum / (double)finite : NAN;
    return summary;
}

static void print_image(const ty_image* image, const char* path) {
    const int32_t width = ty_image_width(image), height = ty_image_height(image);
    int32_t frame[4];
    ty_image_get_frame(image, frame);
    printf("image            %s\nsize             %dx%d\n", path, width, height);
    if (frame[0] != 0 || frame[1] != 0 || frame[2] != width || frame[3] != height)
        printf("frame            %dx%d, from pixel (%d, %d) on\n", frame[2], frame[3], frame[0], frame[1]);
    printf("%-16s %12s %12s %12s\n", "channel", "min", "mean", "max");
    for (int32_t i = 0; i < ty_image_channel_count(image); ++i) {
        const channel_summary summary = summarise(ty_image_plane_const(image, i), (int64_t)width * height);
        cli_print_text(stdout, ty_image_channel_name(image, i), 16);
        printf(" %12.6g %12.6g %12.6g", summary.min, summary.mean, summary.max);
        if (summary.nan > 0) printf("  %" PRId64 " NaN", summary.nan);
        if (summary.infinite > 0) printf("  %" PRId64 " Inf", summary.infinite);
        printf("\n");
    }
    for (int32_t i = 0; i < ty_image_metadata_count(image); ++i) {
        const char* key = ty_image_metadata_key(image, i);
        printf("%-16s ", key);
        cli_print_text(stdout, ty_image_get_metadata(image, key), 0);
        printf("\n");
    }
}

static void print_image_json(const ty_image* image, const char* path) {
    const int32_t width = ty_image_width(image), height = ty_image_height(image);
    int32_t frame[4];
    ty_image_get_frame(image, frame);
    json_writer json = json_begin(stdout);
    json_open_object(&json, NULL);
    json_text(&json, "kind", "image");
    json_text(&json, "file", path);
    json_int(&json, "width", width);
    json_int(&json, "height", height);
    json_numbers(&json, "frame", (const double[]){frame[0], frame[1], frame[2], frame[3]}, 4);
    json_open_array(&json, "channels");
    for (int32_t i = 0; i < ty_image_channel_count(image); ++i) {
        const channel_summary summary = summarise(ty_image_plane_const(image, i), (int64_t)width * height);
        json_open_object(&json, NULL);
        json_text(&json, "name", ty_image_channel_name(image, i));
        json_number(&json, "min", summary.min);
        json_number(&json, "mean", summary.mean);
        json_number(&json, "max", summary.max);
        json_int(&json, "nan", summary.nan);
        json_int(&json, "inf", summary.infinite);
        json_close_object(&json);
    }
    json_close_array(&json);
    json_open_object(&json, "metadata");
    for (int32_t i = 0; i < ty_image_metadata_count(image); ++i) {
        const char* key = ty_image_metadata_key(image, i);
        json_text(&json, key, ty_image_get_metadata(image, key));
    }
    json_close_object(&json);
    json_close_object(&json);
}

int cli_info_image(cli_session* session, const char* path, bool json) {
    ty_image* image = NULL;
    const ty_result result = ty_image_read(session->context, path, &image);
    if (result != TY_OK) return cli_fail_reading(session, result);
    if (json)
        print_image_json(image, path);
    else
        print_image(image, path);
    ty_image_destroy(image);
    return CLI_DONE;
}

typedef enum file_kind { FILE_UNKNOWN, FILE_SCENE, FILE_VOLUME, FILE_DENSE, FILE_IMAGE, FILE_MESH } file_kind;

/* Detection by the first bytes; JSON by a brace after blanks, OBJ by the extension. */
static file_kind kind_of(const char* path, const unsigned char* head, size_t size) {
    static const struct {
        const char* magic;
        size_t size;
        file_kind kind;
    } known[] = {{" BDV", 4, FILE_VOLUME},     {"NanoVDB", 7, FILE_VOLUME}, {"# vtk Da", 8, FILE_VOLUME},
                 {"<VTKFile", 8, FILE_VOLUME}, {"<?xml", 5, FILE_VOLUME},   {"CDF", 3, FILE_VOLUME},
                 {"\x89HDF", 4, FILE_VOLUME},  {"NRRD", 4, FILE_DENSE},     {"\x76\x2f\x31\x01", 4, FILE_IMAGE},
                 {"#?", 2, FILE_IMAGE},        {"\x89PNG", 4, FILE_IMAGE},  {"\xff\xd8\xff", 3, FILE_IMAGE},
                 {"RIFF", 4, FILE_IMAGE},      {"glTF", 4, FILE_MESH},      {"ply\n", 4, FILE_MESH},
                 {"ply\r", 4, FILE_MESH},      {"TYBRICKS", 8, FILE_DENSE}};
    for (size_t i = 0; i < sizeof known / sizeof *known; ++i)
        if (size >= known[i].size && memcmp(head, known[i].magic, known[i].size) == 0) return known[i].kind;
    if (cli_has_extension(path, ".obj") || cli_has_extension(path, ".gltf")) return FILE_MESH;
    size_t i = size >= 3 && memcmp(head, "\xef\xbb\xbf", 3) == 0 ? 3 : 0;
    while (i < size && memchr(" \t\r\n", head[i], 4) != NULL) ++i;
    if (i < size && head[i] == '{') return FILE_SCENE;
    return ty_volume_format_of(path, head, size) != TY_VOLUME_RAW ? FILE_DENSE : FILE_UNKNOWN;
}

enum { HEAD_SIZE = TY_VOLUME_HEAD };

/* Reads the first bytes of a regular file: CLI_GO, or a status after a message. A pipe is refused because reading could
 * block. */
static int read_head(const char* path, unsigned char head[HEAD_SIZE], size_t* size) {
    uint64_t length = 0;
    FILE* file = ty_open_regular(path, &length);
    if (file == NULL && errno == 0) return cli_fail(CLI_USAGE, "%s: not a regular file", path);
    if (file == NULL) return cli_fail(CLI_USAGE, "cannot open %s: %s", path, strerror(errno));
    *size = fread(head, 1, HEAD_SIZE, file);
    const bool failed = ferror(file) != 0;
    fclose(file);
    if (failed) return cli_fail(CLI_USAGE, "%s: cannot be read", path);
    return *size > 0 ? CLI_GO : cli_fail(CLI_USAGE, "%s: the file is empty", path);
}

/* A scene, or its plan for so many ranks; 0: the scene. */
static int info_of_scene(cli_session* session, const char* path, const cli_list* overrides, int32_t ranks, bool json) {
    return ranks > 0 ? cli_info_ranks(session, path, overrides, ranks, json)
                     : cli_info_scene(session, path, overrides, json);
}

static int info_of_file(cli_session* session, const char* path, const cli_list* overrides, const ty_volume_def* raw,
                        int32_t ranks, bool json) {
    if (strncmp(path, "builtin:", 8) == 0) return info_of_scene(session, path, overrides, ranks, json);
    if (ty_is_folder(path)) return info_dense(session, path, raw, json);
    unsigned char head[HEAD_SIZE];
    size_t size = 0;
    const int status = read_head(path, head, &size);
    if (status != CLI_GO) return status;
    file_kind kind = raw->raw_size[0] > 0 ? FILE_DENSE : kind_of(path, head, size);
    if (raw->exact_grid && kind != FILE_VOLUME)
        return cli_usage_error("info", "--grid is for volumes of named grids, and %s is none", path);
    if (raw->exact_grid) kind = FILE_DENSE;
    if (overrides->count > 0 && kind != FILE_SCENE)
        return cli_usage_error("info", "-D is for scenes, and %s is none", path);
    if (ranks > 0 && kind != FILE_SCENE) return cli_usage_error("info", "--ranks is for scenes, and %s is none", path);
    switch (kind) {
    case FILE_SCENE: return info_of_scene(session, path, overrides, ranks, json);
    case FILE_VOLUME: return cli_info_volume(session, path, json);
    case FILE_DENSE: return info_dense(session, path, raw, json);
    case FILE_IMAGE: return cli_info_image(session, path, json);
    case FILE_MESH: return cli_info_mesh(session, path, json);
    case FILE_UNKNOWN: break;
    }
    return cli_fail(CLI_USAGE,
                    "%s: neither a scene (.json) nor a volume (.vdb, .nvdb, .nrrd, .vti, .vtk, .nc, .dcm, .nii, .tif, "
                    ".vol, .bricks), an image (.exr, .hdr, .png, .jpg, .webp) or a mesh (.gltf, .glb, .obj, .ply)",
                    path);
}

int cli_info(int count, char** arguments) {
    bool json = false, media = false;
    int32_t ranks = 0;
    cli_list overrides = {0};
    ty_volume_def raw = ty_default_volume_def();
    const char *raw_size = NULL, *raw_type = NULL, *grid = NULL;
    const cli_option table[] = {
        {"json", 0, CLI_FLAG, NULL, "print JSON", &json, 0, 0, NULL},
        {"media", 0, CLI_FLAG, NULL, "the media that have names, or one: wholemilk:1000, fog:50, JSON", &media, 0, 0,
         NULL},
        {"define", 'D', CLI_LIST, "KEY=VALUE", "change the scene: -D media[0].g=0.5 (again for more)", &overrides, 0, 0,
         NULL},
        {"ranks", 0, CLI_INT, "N",
         "plan of a scene's dom and fld among N ranks (mpirun): cells, memory, messages and stages of each", &ranks, 1,
         16384, NULL},
        {"grid", 0, CLI_TEXT, "NAME", "one grid of a volume: its range and its place", &grid, 0, 0, NULL},
        {"component", 0, CLI_INT, "N", "which of several values per voxel (default 0)", &raw.component, 0, 65535, NULL},
        {"raw-size", 0, CLI_TEXT, "X,Y,Z", "voxels of a raw file", &raw_size, 0, 0, NULL},
        {"raw-type", 0, CLI_TEXT, "TYPE", "int8, uint8 (default) ... uint64, half, float, double", &raw_type, 0, 0,
         NULL},
        {"big-endian", 0, CLI_FLAG, NULL, "of a raw file", &raw.raw_big_endian, 0, 0, NULL},
        {"series", 0, CLI_TEXT, "NAME", "of a folder of DICOM files: its number, description or UID", &raw.series, 0, 0,
         NULL},
    };
    const cli_syntax syntax = {
        "info",
        "FILE | --media [MEDIUM] [options]",
        "Tells what a scene, a volume, an image or a mesh file holds.",
        "Scenes: .json, builtin:NAME. Volumes: .vdb, .nvdb, .nrrd, .nhdr, .vti, .vtk, .nc,\n"
        "DICOM (a folder or a file of a series), NIfTI (.nii, .nii.gz, .hdr), .tif, .vol,\n"
        ".bricks and raw files. Images: .exr, .hdr, .png, .jpg, .webp. Meshes: .gltf, .glb, .obj, .ply, in\n"
        "the units of the file. Memory is what a render takes for what is in the file.",
        table,
        sizeof table / sizeof table[0],
        0,
        1,
        NULL};
    cli_arguments given;
    int status = cli_parse(&syntax, count, arguments, &given);
    if (status == CLI_GO && given.positional_count == 0 && !media)
        status = cli_usage_error("info", "expected: tyndall info %s", syntax.usage);
    if (status == CLI_GO) status = cli_parse_raw("info", raw_size, raw_type, NULL, &raw);
    if (grid != NULL) raw.grid = grid;
    raw.exact_grid = grid != NULL;
    cli_session session;
    if (status == CLI_GO) status = cli_session_open(&session, "info", &given.common);
    if (status != CLI_GO) return status;
    const char* subject = given.positional[0];
    cli_end_on_interrupt(true);
    status = media ? cli_info_media(&session, subject, json)
                   : info_of_file(&session, subject, &overrides, &raw, ranks, json);
    cli_end_on_interrupt(false);
    return cli_session_close(&session, status);
}
