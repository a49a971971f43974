/* Impulse responses as they are kept: rows of vectors of zonal harmonics, a row for each emitter, angle and distance.
 * Unit: the canonical medium's, sigma_t = sigma_s = 1/m. */
#ifndef TY_METHOD_IMPULSE_TABLES_H
#define TY_METHOD_IMPULSE_TABLES_H

#include "base/context.h"

#include <tyndall/impulse.h>

enum {
    TY_IMPULSE_VECTOR = 12, /* floats of a vector: zonal harmonics and, in a row's first, of areas, the shift */
    TY_IMPULSE_SHIFT = TY_IMPULSE_TERMS, /* over the sine of the angle, which makes it smooth */
    TY_IMPULSE_PHASES = 3,               /* single scattering with g = -0.5, 0, 0.5: a row's first vectors */
    TY_IMPULSE_AREA_ROWS =
        2 * TY_IMPULSE_DISTANCES, /* the first row of areas: those of points and directions precede */
    TY_IMPULSE_ROWS = (2 + TY_IMPULSE_ANGLES) * TY_IMPULSE_DISTANCES
};

#define TY_IMPULSE_PHASE_G 0.5  /* of the outer single scattering tables */
#define TY_IMPULSE_NEAREST 1e-3 /* optical distance of the first bin */

/* How distances are shared out: bins are equally far apart in ln(d / nearest) + TY_IMPULSE_EVEN (d - nearest). So they
 * are a part of the distance apart where that is short, and of a mean free path where it is long. */
#define TY_IMPULSE_EVEN 0.6

struct ty_impulse {
    ty_context* context;
    int32_t bounces;
    double range;
    double density; /* bins per unit of the above */
    int32_t row;    /* floats: (TY_IMPULSE_PHASES + bounces - 1) vectors */
    size_t count;   /* floats in all */
    float* values;  /* aligned to 64 bytes; what is kept is scaled (ty_impulse_scale) */
};

/* Tables of zeros. */
ty_result ty_impulse_allocate(ty_context* context, const ty_impulse_def* def, ty_impulse** out);
/* Fills them. Errors: TY_ERROR_MEMORY, TY_CANCELLED. */
ty_result ty_impulse_build(ty_impulse* tables, const ty_impulse_def* def);

/* Where a distance lies among bins, and the distance of a place. */
double ty_impulse_place(const ty_impulse* tables, double distance);
double ty_impulse_distance(const ty_impulse* tables, double place);

/* What a response at a distance is multiplied by to be tabled, so that lines between bins are near to it: single
 * scattering near an emitter falls with distance, and all of it about as transmittance does. */
double ty_impulse_scale(ty_impulse_emitter emitter, bool single, double distance);

static inline float* ty_impulse_row(const ty_impulse* tables, ty_impulse_emitter emitter, int32_t angle, int32_t bin) {
    const int32_t first = emitter == TY_IMPULSE_AREA ? TY_IMPULSE_AREA_ROWS + angle * TY_IMPULSE_DISTANCES
                                                     : (int32_t)emitter * TY_IMPULSE_DISTANCES;
    return tables->values + (size_t)(first + bin) * (size_t)tables->row;
}

/* The cosines that the angles of areas stand for: closer together where the receiver is near the emitter's plane, since
 * there responses bend most. */
extern const float ty_impulse_cosines[TY_IMPULSE_ANGLES];

/* ---- the file ---- */

size_t ty_impulse_file_size(const ty_impulse* tables);
void ty_impulse_pack(const ty_impulse* tables, uint8_t* bytes);
/* Puts the checksum of a file's bytes in its place. */
void ty_impulse_seal(uint8_t* bytes, size_t size);
/* Fills tables from a file's bytes. NULL, or why they are not what is wanted; then tables hold nothing of use. */
const char* ty_impulse_unpack(ty_impulse* tables, const uint8_t* bytes, size_t size);
/* Where def's tables are kept; "" for nowhere. */
void ty_impulse_path(const ty_impulse_def* def, char path[1024]);
/* Whether they could be read. */
bool ty_impulse_load(ty_impulse* tables, const char* path);
/* Writes them; a failure is logged as a warning. */
bool ty_impulse_save(const ty_impulse* tables, const char* path);

#endif
