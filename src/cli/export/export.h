/* tyndall export: what `tyndall bake` wrote, as engines load it. */
#ifndef TY_CLI_EXPORT_EXPORT_H
#define TY_CLI_EXPORT_EXPORT_H

#include "cli/session/session.h"

#include <jansson.h>

enum { EXPORT_PATH_SIZE = 4096, EXPORT_TERMS = 9 };

/* The conventions of an engine. Axes are given for scenes with y up, as glTF has them, right-handed. */
typedef struct export_engine {
    const char* name;
    const char* extension;  /* of lightmaps */
    ty_texel_format format; /* of lightmaps where the extension is not .exr */
    bool per_pi;            /* lightmaps and coefficients hold what a white Lambertian surface reflects, E / pi */
    bool flipped;           /* the first row of a lightmap is v = 1 */
    float axes[3][3];       /* rows: the engine's axes */
    double units_per_meter;
    const char* axes_text;
    const char* probes_text; /* what the coefficients are multiplied with */
} export_engine;

enum { EXPORT_ENGINES = 4 };
extern const export_engine export_engines[EXPORT_ENGINES];

/* ---- harmonics.c ---- */

/* The axes of an engine for scenes with another axis up. */
void export_axes(const export_engine* engine, bool z_up, float axes[3][3]);
/* Radiance's nine coefficients of one channel, as `tyndall bake` stores them, in the engine's axes, order, signs and
 * factors. */
void export_harmonics(const export_engine* engine, const float axes[3][3], const double in[EXPORT_TERMS],
                      double out[EXPORT_TERMS]);

/* ---- export.c ---- */

typedef struct export_run {
    cli_session* session;
    const export_engine* engine;
    const char *from, *folder;
    bool denoised;
    int texels; /* a ty_texel_format; -1: the engine's */
    int zstd;
    bool mipmaps;
    json_t* bake; /* bake.json */
    bool z_up;
    int64_t probe_count; /* written so far */
    int32_t lightmaps;
    bool has_more_bands; /* probes have terms that are not exported */
} export_run;

/* ---- probes.c ---- */

/* Writes probes.json of a file that bake.json lists as a grid or as probes; name: of the file. */
ty_result export_probes(export_run* run, const json_t* entry, const char* name);

#endif
