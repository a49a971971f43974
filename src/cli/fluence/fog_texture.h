/* The light on cells as textures of three dimensions, for shaders that march through them. */
#ifndef TY_CLI_FLUENCE_FOG_TEXTURE_H
#define TY_CLI_FLUENCE_FOG_TEXTURE_H

#include "method/cell_light.h"

#include <tyndall/tyndall.h>

/* The quantity in red, green and blue of a texel; its alpha is the extinction, 1/m, the mean of the channels. */
typedef enum cli_fog_quantity {
    CLI_FOG_SCATTER = 0, /* radiance that media scatter, isotropically, and emit per metre, W m^-3 sr^-1 */
    CLI_FOG_FLUENCE = 1, /* fluence, W m^-2 */
    CLI_FOG_PHASE = 2    /* the first, without the unscattered light of lamps; and two more textures: sigma_s times the
                            fluence of that light, with g as alpha, and the directions of all other light */
} cli_fog_quantity;

typedef struct cli_fog_texture {
    cli_fog_quantity quantity;
    const double *lower, *upper; /* box, m */
    const int32_t* size;         /* cells */
    bool scattered;              /* fluence is without uncollided light */
    const double* fluence;       /* cells x 3, x fastest; not with CLI_FOG_PHASE */
    ty_cell_moments split;       /* with CLI_FOG_PHASE */
    int32_t zstd;                /* of .ktx2 */
} cli_fog_texture;

/* Writes half floats to .ktx2 or .dds, and beside it a file .json with the box and the units. The other textures of
 * CLI_FOG_PHASE are NAME_uncollided and NAME_directions. */
ty_result cli_write_fog_texture(ty_context* context, const ty_scene* scene, const cli_fog_texture* fog,
                                const char* path);

#endif
