/* Adjoint of parallel light: derivatives of a weighted sum of its mean fluence in cells by the extinction of each cell
 * and by the strength of the light. It is exact for the tubes of collimated.h, without surfaces. */
#ifndef TY_DIRECT_UNCOLLIDED_COLLIMATED_ADJOINT_H
#define TY_DIRECT_UNCOLLIDED_COLLIMATED_ADJOINT_H

#include "base/progress.h"
#include "direct/lights/discrete_light.h"
#include "direct/media/grid_medium.h"

/* Memory of directions, which later calls reuse: fresh pages cost more than the light. */
typedef struct ty_collimated_scratch {
    float* floats; /* NULL: none yet */
    size_t count;
} ty_collimated_scratch;

void ty_collimated_scratch_free(ty_context* context, ty_collimated_scratch* scratch);

/* The loss is the sum over directions, channels and cells of weight[c] color T, with T the mean transmittance from one
 * direction through one plane of extinction; of points (point_light_adjoint.h) of weight[c] color T / r^2. */
typedef struct ty_uncollided_loss {
    const ty_discrete_light* sources; /* of which each adjoint takes its own kind */
    int32_t count;
    const float* extinction;        /* 1/m */
    int32_t first, channels;        /* channels [first, first + channels) of the colors */
    const float* weight[3];         /* of each of these channels, one per cell */
    const float* multiples;         /* of all three channels over weight[0], which is then the only one; NULL: none */
    float* transmittance;           /* of each cell: receives the sum of T over the directions; NULL: not asked for */
    ty_collimated_scratch* scratch; /* NULL: the call's own */
    ty_part_progress* progress;
} ty_uncollided_loss;

/* The color of a source that a channel's weights are of. */
float ty_uncollided_loss_color(const ty_uncollided_loss* loss, const ty_discrete_light* source, int32_t channel);
/* Adds a channel's part of the loss to the light's, divided among the channels that share its weights. */
void ty_uncollided_loss_add(const ty_uncollided_loss* loss, const ty_discrete_light* source, int32_t channel,
                            double part, double strength[3]);

/* Adds the derivatives by extinction to `gradient`, one per cell, and the parts of the loss that each direction has in
 * each channel, its derivatives by a factor of the direction's color, to strength[index of its light]. Errors:
 * TY_ERROR_MEMORY; TY_CANCELLED. */
ty_result ty_collimated_adjoint(const ty_grid_medium* medium, const ty_uncollided_loss* loss, float* gradient,
                                double (*strength)[3]);

#endif
