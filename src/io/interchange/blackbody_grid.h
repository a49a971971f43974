/* Temperatures of emitting media, of which formats have different conventions. */
#ifndef TY_IO_INTERCHANGE_BLACKBODY_GRID_H
#define TY_IO_INTERCHANGE_BLACKBODY_GRID_H

#include <stdbool.h>
#include <stddef.h>

/* Replaces temperatures, kelvin, by others for which a black body's radiance times *factor has the luminance of `scale`
 * times a black body of the old temperature whose largest spectral radiance is 1 per nm. The hottest keeps its
 * temperature, and so its colour. False if nothing emits. */
bool ty_normalize_temperatures(float* kelvin, size_t count, double scale, double* factor);

#endif
