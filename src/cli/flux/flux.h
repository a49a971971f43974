/* tyndall flux: what its files share. */
#ifndef TY_CLI_FLUX_FLUX_H
#define TY_CLI_FLUX_FLUX_H

#include "cli/session/session.h"

enum { FLUX_BANDS_MAX = 256, FLUX_BAND_CHANGES_MAX = 64 };

/* A spectral band: changes of the scene, and its weight in the sum. */
typedef struct flux_band {
    const char* name; /* "": the only one */
    double weight;
    char* changes[FLUX_BAND_CHANGES_MAX]; /* "media[0].sigma_t=0.3"; owned */
    int32_t change_count;
    double spp;    /* samples of each number, the mean */
    ty_flux* flux; /* of this band, owned */
} flux_band;

typedef struct flux_bands {
    flux_band* bands;
    int32_t count;
    void* document; /* that names are in */
} flux_bands;

/* Reads a file of bands; without a path there is one, which changes nothing. CLI_GO, or CLI_USAGE after a message.
 * flux_free_bands must follow, also after a failure. */
int flux_read_bands(const char* path, flux_bands* out);
void flux_free_bands(flux_bands* bands);

/* A finished run. */
typedef struct flux_result {
    const char* scene; /* path as given */
    uint64_t seed;
    bool z_up;
    const flux_bands* bands;
} flux_result;

/* Writes .json or .csv, by the extension. */
ty_result flux_write(cli_session* session, const char* path, const flux_result* result);
/* Prints means over all columns. */
void flux_print(const flux_result* result);

#endif
