/* Layout of the tables: rows of vectors of zonal harmonics, one row per emitter, angle and distance. Unit: the
 * canonical medium's, sigma_t = sigma_s = 1/m. */
#ifndef TY_METHOD_IMPULSE_TABLES_H
#define TY_METHOD_IMPULSE_TABLES_H

#include "base/context.h"

#include <tyndall/impulse.h>

enum {
    TY_IMPULSE_VECTOR =
        12, /* floats per vector: zonal harmonics; the last float of an area row's first vector is the axis tilt */
    TY_IMPULSE_SHIFT = TY_IMPULSE_TERMS, /* divided by the sine of the angle, which makes it smooth */
    TY_IMPULSE_PHASES = 3,               /* single scattering with g = -0.5, 0, 0.5: the first vectors of a row */
    TY_IMPULSE_AREA_ROWS = 2 * TY_IMPULSE_DISTANCES, /* first row of areas, after those of points and directions */
    TY_IMPULSE_ROWS = (2 + TY_IMPULSE_ANGLES) * TY_IMPULSE_DISTANCES
};

#define TY_IMPULSE_PHASE_G                                                                                             \
    0.5 /* magnitude of g in the outer single scattering tables: g_range, Sec. 4.5 (Dubouchet 2019) */
#define TY_IMPULSE_NEAREST 1e-3 /* optical distance of the first bin */

/* Distances of bins: uniform in ln(d / nearest) + TY_IMPULSE_LINEAR_RATE (d - nearest), so spacing is proportional to
 * distance where that is short, and to a mean free path where it is long. */
#define TY_IMPULSE_LINEAR_RATE 0.6

struct ty_impulse {
    ty_context* context;
    int32_t bounces;
    double range;
    double density; /* bins per unit of that coordinate */
    int32_t row;    /* floats: (TY_IMPULSE_PHASES + bounces - 1) vectors */
    size_t count;   /* number of floats */
    float* values;  /* aligned to 64 bytes; stored with ty_impulse_scale */
};

/* Allocates tables of zeros. */
ty_result ty_impulse_allocate(ty_context* context, const ty_impulse_def* def, ty_impulse** out);
/* Builds the tables. Errors: TY_ERROR_MEMORY, TY_CANCELLED. */
ty_result ty_impulse_build(ty_impulse* tables, const ty_impulse_def* def);

/* Bin position of a distance, and distance of a bin position. */
double ty_impulse_bin_position(const ty_impulse* tables, double distance);
double ty_impulse_distance(const ty_impulse* tables, double position);

/* Scale of a stored response, chosen for accurate linear interpolation between bins: it compensates transmittance, and
 * the inverse distance of single scattering near an emitter. */
double ty_impulse_scale(ty_impulse_emitter emitter, bool single, double distance);

static inline float* ty_impulse_row(const ty_impulse* tables, ty_impulse_emitter emitter, int32_t angle, int32_t bin) {
    const int32_t first = emitter == TY_IMPULSE_AREA ? TY_IMPULSE_AREA_ROWS + angle * TY_IMPULSE_DISTANCES
                                                     : (int32_t)emitter * TY_IMPULSE_DISTANCES;
    return tables->values + (size_t)(first + bin) * (size_t)tables->row;
}

/* Cosines of the tabulated angles of areas, denser near the emitter's plane, where responses vary most. */
extern const float ty_impulse_cosines[TY_IMPULSE_ANGLES];

/* ---- the file ---- */

size_t ty_impulse_file_size(const ty_impulse* tables);
void ty_impulse_pack(const ty_impulse* tables, uint8_t* bytes);
/* Writes the checksum into a file's bytes. */
void ty_impulse_seal(uint8_t* bytes, size_t size);
/* Reads tables from a file's bytes. Returns NULL, or the reason for a mismatch, which leaves the tables undefined. */
const char* ty_impulse_unpack(ty_impulse* tables, const uint8_t* bytes, size_t size);
/* Path of the table file for def; "" for none. */
void ty_impulse_path(const ty_impulse_def* def, char path[1024]);
/* Reads the tables; false: the file is missing or does not match. */
bool ty_impulse_load(ty_impulse* tables, const char* path);
/* Writes the tables; a failure is logged as a warning. */
bool ty_impulse_save(const ty_impulse* tables, const char* path);

#endif
