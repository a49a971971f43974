/* Interface between the path tracer's driver and its kernel, which is compiled once per instruction set. */
#ifndef TY_METHOD_PATH_TRACE_KERNEL_H
#define TY_METHOD_PATH_TRACE_KERNEL_H

#include "base/dispatch.h"
#include "base/random.k.h"
#include "direct/single/enclosed_field.k.h"
#include "method/path/trace/guide.k.h"
#include "scene/camera.h"
#include "scene/interior_list.k.h"
#include "scene/scene.h"

enum { TY_GUIDES_MAX = 4 };

/* Rays of a sample for emission that the camera sees itself, in pixels that outlines of emitters cross, and the first
 * sample that has them: pixels with outlines need not be known for a first glance. */
enum { TY_OUTLINE_RAYS = 16, TY_OUTLINE_FIRST = 1 };

/* Start of paths: through a pixel, along a given ray, uniform in a cell and over directions, or for a quantity of a
 * column. */
enum { TY_PATH_PIXELS = 0, TY_PATH_RAYS = 1, TY_PATH_CELLS = 2, TY_PATH_COLUMNS = 3 };

/* Quantities of a level, in the order of ty_flux_quantity. */
enum { TY_COLUMN_UP = 0, TY_COLUMN_DOWN_DIFFUSE = 1, TY_COLUMN_DOWN_DIRECT = 2, TY_COLUMN_LEVEL_QUANTITIES = 3 };

/* Columns of a scene, and the quantities that are estimated for each (column.k.h). */
typedef struct ty_path_columns {
    int32_t axis[3]; /* both horizontal ones, and up */
    int32_t size[2]; /* columns along the horizontal axes */
    int32_t level_count, view_count;
    int32_t extended;          /* nonzero if directions may meet lights: environments and those with an area */
    double lower[2], cell[2];  /* of the columns, m */
    double absorbing[2];       /* lowest and highest point of the media that absorb, m */
    const double* levels;      /* where paths start, m */
    const double* view_levels; /* by view, m */
    const float* views;        /* by view: the direction of paths */
} ty_path_columns;

typedef struct ty_path_request {
    const ty_scene_view* scene;
    const ty_sobol* sobol;
    uint64_t seed;
    int32_t max_depth;                 /* 0: unlimited */
    int32_t max_run;                   /* max scatterings between two surfaces; 0: unlimited */
    int32_t unscattered;               /* nonzero if media only attenuate */
    int32_t deep;                      /* nonzero if environments, and no near lights, hardly light points deep within
                                          a medium */
    int32_t single_reflection;         /* nonzero if surfaces are without energy compensation */
    int32_t kind;                      /* TY_PATH_PIXELS, _RAYS, _CELLS or _COLUMNS */
    ty_camera_view camera;             /* pixels */
    ty_interior_list camera_inside;    /* the dielectrics around it, where the scene has any */
    const ty_enclosed_field* enclosed; /* light in interiors, by number, at which paths end; NULL: none */
    int32_t width;                     /* of the whole frame */
    int32_t crop[4];                   /* x, y, width, height: item i is pixel (x + i % width, y + i / width) */
    const double* rays;                /* rays: 6 per item, as ty_path_radiance has them */
    double lower[3], cell[3];          /* cells */
    int32_t size[3];
    const ty_path_columns* columns; /* columns */
    int32_t guide_count;            /* guiding lights of high-g media and their probabilities, which sum to 1 */
    int32_t guide_light[TY_GUIDES_MAX];
    float guide_weight[TY_GUIDES_MAX];
    float min_contribution;   /* contributions with a radiance below this are traced by chance (Russian roulette) */
    float point_light_rate;   /* lamp directions per vertex beside a lamp, at most 1; 0: equiangular sampling alone */
    float point_light_reach2; /* squared distance of a vertex to a lamp at which they are half as many, m^2 */
    float point_light_near;   /* factor of lamps' reach2 where rays sample the light that lamps send into them */
    float point_light_g;      /* mean cosine of the media's scattering, at least 0 */
    int32_t first_hit;        /* pixels: nonzero if first-hit channels are needed */
    const uint8_t* outlines;  /* pixels: nonzero for items that outlines of emitters cross; NULL: for none */
    const ty_guide* guide;    /* of the guided kernel, which needs one */
} ty_path_request;

/* Sums over an item's samples in sample order, so that the division into passes changes no result. */
typedef struct ty_path_sums {
    double mean[3];   /* sum of samples */
    double square[3]; /* sum of their squares */
} ty_path_sums;

/* Sums per path class and of first-hit channels; allocated only if needed. */
typedef struct ty_path_aov_sums {
    double uncollided[3]; /* light without scattering or reflection */
    double single[3], multiple[3];
    double transmittance[3], albedo[3], normal[3]; /* pixels only, see ty_path_def.aovs */
    double surface_albedo[3];                      /* times transmittance */
    double depth, hits;                            /* sum of distances, m, and number of samples that hit a surface */
} ty_path_aov_sums;

/* Adds samples [first_sample, first_sample + count) of items [begin, end) to sums[item - begin], and to
 * aov_sums[item - begin] unless aov_sums is NULL. Returns the number of path vertices. */
#define TY_PATH_KERNEL(name)                                                                                           \
    uint64_t name(const ty_path_request* request, int64_t begin, int64_t end, uint32_t first_sample, uint32_t count,   \
                  ty_path_sums* sums, ty_path_aov_sums* aov_sums)
typedef TY_PATH_KERNEL((*ty_path_kernel));
TY_DECLARE_KERNEL_FUNCTION(TY_PATH_KERNEL, ty_path_kernel);
TY_DECLARE_KERNEL_FUNCTION(TY_PATH_KERNEL, ty_path_guided_kernel);
TY_DECLARE_KERNEL_FUNCTION(TY_PATH_KERNEL, ty_path_periodic_kernel);

#endif
