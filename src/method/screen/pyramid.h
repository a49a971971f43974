/* The levels of TY_SCREEN_SCATTER: their sizes, what they represent, and how many an image needs. */
#ifndef TY_METHOD_SCREEN_PYRAMID_H
#define TY_METHOD_SCREEN_PYRAMID_H

#include "method/screen/job.h"

/* Light and moment of three channels. */
enum { TY_SCREEN_PLANES = 6 };

typedef struct ty_screen_pyramid {
    ty_screen_taps taps;
    ty_screen_level levels[TY_SCREEN_LEVELS_MAX + 1]; /* [0] has only a size */
    float variance[TY_SCREEN_LEVELS_MAX + 2];         /* represented by each level, pixels^2 */
    float limit[3];                                   /* largest measure of spread that the last level represents */
    int32_t level_limit;                              /* levels with sizes and areas */
} ty_screen_pyramid;

/* Sizes of the levels, and memory for their areas. */
void ty_screen_pyramid_lay_out(ty_screen_pyramid* p, const ty_screen_def* def, int32_t width, int32_t height,
                               ty_arena* memory);
/* Areas, fractions and limits. */
void ty_screen_pyramid_set(ty_screen_pyramid* p, const ty_screen_job* job);
/* Number of levels required by the largest spread among some counts, or by the options. */
int32_t ty_screen_pyramid_levels(const ty_screen_pyramid* p, const ty_screen_job* job, const ty_screen_counts* counts,
                                 int32_t count);
/* Half-light radius that a level represents, for the channel of least spread. */
double ty_screen_pyramid_radius(const ty_screen_pyramid* p, const ty_screen_job* job, int32_t level);
/* Memory traffic in bytes, counting each plane once per pass: image in and out, pyramid down and up. */
double ty_screen_pyramid_bytes(const ty_screen_pyramid* p, int32_t levels);

#endif
