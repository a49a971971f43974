/* What the path tracer's driver hands to its kernel, which is built once per instruction set. */
#ifndef TY_PATH_KERNEL_H
#define TY_PATH_KERNEL_H

#include "base/random.k.h"
#include "scene/camera.h"
#include "scene/scene.h"

enum { TY_GUIDES_MAX = 4 };

/* What a path starts as: through a pixel, along a given ray, or anywhere in a cell in any direction. */
enum { TY_PATH_PIXELS = 0, TY_PATH_RAYS = 1, TY_PATH_CELLS = 2 };

typedef struct ty_path_request {
    const ty_scene_view* scene;
    const ty_sobol* sobol;
    uint64_t seed;
    int32_t max_depth;        /* 0: unlimited */
    int32_t max_run;          /* scatterings between two surfaces at most; 0: unlimited */
    int32_t unscattered;      /* whether media only take light away */
    int32_t kind;             /* TY_PATH_... */
    ty_camera_view camera;    /* pixels */
    int32_t width;            /* of the whole frame */
    int32_t crop[4];          /* x, y, width, height: item i is pixel (x + i % width, y + i / width) */
    const double* rays;       /* rays: 6 per item */
    double lower[3], cell[3]; /* cells */
    int32_t size[3];
    int32_t guide_count; /* lights that high-g media are guided towards, and their shares, which add up to 1 */
    int32_t guide_light[TY_GUIDES_MAX];
    float guide_share[TY_GUIDES_MAX];
    float min_contribution; /* radiance below which a light's contribution is traced by chance */
    int32_t look;           /* pixels: whether what the first ray meets is wanted, too */
} ty_path_request;

/* Sums over an item's samples, one after another, so that how samples fall into passes changes nothing. */
typedef struct ty_path_sums {
    double mean[3];   /* sum of samples */
    double square[3]; /* sum of their squares */
} ty_path_sums;

/* Sums of what light did and of what the first ray met; kept only where somebody asks. */
typedef struct ty_path_aov_sums {
    double uncollided[3]; /* light that did not scatter and was not reflected */
    double single[3], multiple[3];
    double transmittance[3], albedo[3], normal[3]; /* pixels only, see ty_path_def.aovs */
    double depth, hits;                            /* sum of distances, and how many samples hit a surface */
} ty_path_aov_sums;

/* Adds samples [first_sample, first_sample + count) of items [begin, end) to sums[item - begin], and to
 * parts[item - begin] unless parts is NULL; returns vertices. */
#define TY_PATH_KERNEL(name)                                                                                           \
    uint64_t name(const ty_path_request* request, int64_t begin, int64_t end, uint32_t first_sample, uint32_t count,   \
                  ty_path_sums* sums, ty_path_aov_sums* parts)
typedef TY_PATH_KERNEL((*ty_path_kernel));
TY_PATH_KERNEL(ty_path_kernel_v1);
TY_PATH_KERNEL(ty_path_kernel_v3);
TY_PATH_KERNEL(ty_path_kernel_v4);

#endif
