/* tyndall convert: conversion of a volume, an image or a scene to another file format, chosen by the extensions. */
#include "cli/convert/convert.h"
#include "cli/commands.h"
#include "cli/options/raw_options.h"
#include "io/interchange/convert.h"
#include "io/textures/textures.h"
#include "io/volumes/nifti/nifti.h"

#include <string.h>

enum { ZSTD_LEVEL = 9 };

static bool has_one_of(const char* path, const char* const* extensions) {
    for (; *extensions != NULL; ++extensions)
        if (cli_has_extension(path, *extensions)) return true;
    return false;
}

/* By the extension; .hdr is also that of NIfTI headers. */
static bool is_image(const char* path) {
    static const char* const extensions[] = {".exr", ".hdr", ".png", ".jpg", ".jpeg", ".webp", NULL};
    return has_one_of(path, extensions) && !ty_is_nifti_file(path);
}

static int choose_codec(const char* command, const char** codec, const char* const* known, const char* output) {
    char list[64] = "";
    if (*codec == NULL) *codec = known[0];
    for (int i = 0; known[i] != NULL; ++i) {
        if (strcmp(*codec, known[i]) == 0) return CLI_GO;
        const size_t used = strlen(list);
        snprintf(list + used, sizeof list - used, "%s%s", i > 0 ? ", " : "", known[i]);
    }
    return cli_usage_error(command, "%s: the codec '%s' is not one of %s", output, *codec, list);
}

int cli_check_codec(const char* command, const char** codec, const char* output) {
    static const char* const vdb[] = {"zip", "blosc", "none", NULL};
    static const char* const nanovdb[] = {"zip", "none", NULL};
    static const char* const nrrd[] = {"gzip", "none", NULL};
    static const char* const vti[] = {"zip", "none", NULL};
    static const char* const plain[] = {"none", NULL};
    static const char* const packed[] = {"gzip", NULL};
    if (cli_has_extension(output, ".vdb")) return choose_codec(command, codec, vdb, output);
    if (cli_has_extension(output, ".nvdb")) return choose_codec(command, codec, nanovdb, output);
    if (cli_has_extension(output, ".nrrd")) return choose_codec(command, codec, nrrd, output);
    if (cli_has_extension(output, ".vti")) return choose_codec(command, codec, vti, output);
    if (cli_has_extension(output, ".nii.gz")) return choose_codec(command, codec, packed, output);
    if (cli_has_extension(output, ".nii") || cli_has_extension(output, ".vol") || cli_has_extension(output, ".bricks"))
        return choose_codec(command, codec, plain, output);
    return cli_usage_error(command, "%s: a volume goes to .vdb, .nvdb, .nrrd, .vti, .nii, .nii.gz, .vol or .bricks",
                           output);
}

static int convert(cli_session* session, convert_volume_options* volume, const convert_image_options* image,
                   bool partial, const char* const paths[2]) {
    cli_end_on_interrupt(true);
    if (ty_scene_language_of(paths[0]) != TY_LANGUAGE_NONE)
        return cli_convert_scene(session, partial, paths[0], paths[1]);
    if (is_image(paths[0])) return cli_convert_image(session, image, paths[0], paths[1]);
    const int status = cli_check_codec("convert", &volume->codec, paths[1]);
    return status == CLI_GO ? cli_convert_volume(session, volume, paths[0], paths[1]) : status;
}

int cli_convert(int count, char** arguments) {
    convert_volume_options volume = {.def = ty_default_volume_def()};
    ty_volume_def* def = &volume.def;
    bool partial = false;
    const char *raw_size = NULL, *raw_type = NULL, *raw_spacing = NULL, *radius = NULL, *air = NULL;
    convert_image_options image = {.scale = 65535, .texels = -1, .zstd = ty_has_zstd() ? ZSTD_LEVEL : 0};
    bool plain = false;
    const cli_option table[] = {
        {"grid", 0, CLI_TEXT, "NAME", "grid of a VDB, NanoVDB, VTK or NetCDF file (default density, or the only one)",
         &volume.grid, 0, 0, NULL},
        {"component", 0, CLI_INT, "N", "which of several values per voxel (default 0)", &def->component, 0, 65535,
         NULL},
        {"vector", 0, CLI_FLAG, NULL, "all three values per voxel as a vector (.vdb, .vti, .nii)", &volume.vector, 0, 0,
         NULL},
        {"half", 0, CLI_FLAG, NULL, "store values as half floats (.vdb)", &volume.half, 0, 0, NULL},
        {"frame", 0, CLI_INT, "N", "takes the place of the #s in IN (default 0)", &def->frame, 0, INT32_MAX, NULL},
        {"codec", 0, CLI_TEXT, "NAME",
         ".vdb: zip, blosc, none; .nvdb, .vti: zip, none; .nrrd: gzip, none; others: one alone (default: the first)",
         &volume.codec, 0, 0, NULL},
        {"effective-radius", 0, CLI_TEXT, "NAME|UM", "NetCDF: makes liquid water the extinction of droplets, 1/m",
         &radius, 0, 0, NULL},
        {"air-density", 0, CLI_TEXT, "NAME|KG_M3", "NetCDF: for liquid water per mass of air", &air, 0, 0, NULL},
        {"raw-size", 0, CLI_TEXT, "X,Y,Z", "voxels of a raw file", &raw_size, 0, 0, NULL},
        {"raw-type", 0, CLI_TEXT, "TYPE", "int8, uint8 (default) ... uint64, half, float, double", &raw_type, 0, 0,
         NULL},
        {"raw-spacing", 0, CLI_TEXT, "X,Y,Z", "units between voxels of a raw file (default: no position)", &raw_spacing,
         0, 0, NULL},
        {"big-endian", 0, CLI_FLAG, NULL, "of a raw file", &def->raw_big_endian, 0, 0, NULL},
        {"series", 0, CLI_TEXT, "NAME", "of a folder of DICOM files: its number, description or UID", &def->series, 0,
         0, NULL},
        {"layer", 0, CLI_TEXT, "NAME", "layer of an EXR (default: all channels)", &image.layer, 0, 0, NULL},
        {"channel", 0, CLI_TEXT, "NAME", "of an image, for --bits 16 (default: the first)", &image.channel, 0, 0, NULL},
        {"exposure", 0, CLI_REAL, "STOPS", "exposure of a PNG (default 0)", &image.exposure, -64, 64, NULL},
        {"curve", 0, CLI_CHOICE, "none|filmic", "curve of a PNG (default none)", &image.curve, 0, 0, NULL},
        {"bits", 0, CLI_INT, "8|16", "of a PNG's values; 16: one channel, linear (default 8)", &image.bits, 8, 16,
         NULL},
        {"texels", 0, CLI_CHOICE, "bc6h|bc6h-signed|half|float|rgb9e5|rgbe|rgbm",
         "of a .ktx2 or .dds texture (default bc6h); of a .png, rgbe or rgbm", &image.texels, 0, 0, NULL},
        {"slices", 0, CLI_INT, "N", "a texture of three dimensions, from so many slices one below the other",
         &image.slices, 1, 4096, NULL},
        {"mipmaps", 0, CLI_FLAG, NULL, "a texture's smaller levels, too", &image.mipmaps, 0, 0, NULL},
        {"range", 0, CLI_REAL, "V", "largest value of rgbm (default: the image's)", &image.range, 1e-30, 1e30, NULL},
        {"zstd", 0, CLI_INT, "LEVEL", "compression of a .ktx2 by Zstandard (default 9)", &image.zstd, 1, 22, NULL},
        {"no-zstd", 0, CLI_FLAG, NULL, "a .ktx2 without compression", &plain, 0, 0, NULL},
        {"scale", 0, CLI_REAL, "S", "what 1 becomes with --bits 16 (default 65535)", &image.scale, 1e-30, 1e30, NULL},
        {"partial", 0, CLI_FLAG, NULL, "of a scene: leave out files that are missing", &partial, 0, 0, NULL},
    };
    const cli_syntax syntax = {
        "convert",
        "IN OUT [options]",
        "Converts a volume, an image or a scene into a file of another kind.",
        "Volumes: .vdb, .nvdb, .nrrd, .nhdr, .vti, .vtk, .nc, DICOM (a folder or a file of a\n"
        "series), NIfTI (.nii, .nii.gz, .hdr), .tif, .vol, .bricks and raw files to .vdb,\n"
        ".nvdb, .nrrd, .vti, .nii, .nii.gz, .vol and, for volumes larger than memory, .bricks.\n"
        "Images: .exr, .hdr, .png, .jpg, .webp to .exr, .png, and to textures, .ktx2, .dds.\n"
        "Scenes: of pbrt-v4 (.pbrt, .pbrt.gz) and Mitsuba (.xml) to .json, with meshes, volumes\n"
        "and maps in a folder beside it.",
        table,
        sizeof table / sizeof table[0],
        2,
        2,
        NULL};
    cli_arguments given;
    int status = cli_parse(&syntax, count, arguments, &given);
    if (status == CLI_GO) status = cli_parse_raw("convert", raw_size, raw_type, raw_spacing, def);
    if (status == CLI_GO) status = cli_parse_droplets("convert", radius, air, def);
    if (status == CLI_GO) status = cli_check_output("convert", given.positional[1]);
    if (plain) image.zstd = 0;
    cli_session session;
    if (status == CLI_GO) status = cli_session_open(&session, "convert", &given.common);
    if (status != CLI_GO) return status;
    return cli_session_close(&session, convert(&session, &volume, &image, partial, given.positional));
}
