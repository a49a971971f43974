/* The row loops of parallel light and point lights, built once per instruction set. */
#ifndef TY_DIRECT_UNCOLLIDED_KERNEL_H
#define TY_DIRECT_UNCOLLIDED_KERNEL_H

#include "base/dispatch.h"
#include "direct/uncollided/point_light.k.h"

/* Shadow rays per tube. */
enum { TY_TUBE_RAYS = 4 };

/* Maximum number of planes to add to: fluence and flux of three channels. */
enum { TY_TUBE_PLANES_MAX = 12 };

/* A row of tubes through a slab: tube t overlaps cells t - 2, t - 1 and t. */
typedef struct ty_tube_row {
    int32_t count;                  /* cells in a row; there are two more tubes */
    float weight[2][3];             /* of each tube's three cells, and three rows */
    float length;                   /* path length of a tube within the slab, m */
    float start;                    /* distance to the slab's near side along the tubes, m */
    const float* cells[3];          /* extinction of the three rows, 1/m */
    const float* hit[TY_TUBE_RAYS]; /* distance to the first surface on each tube's rays, m; NULL: no surfaces */
    const float* in;                /* transmittance of each tube before the slab, without surfaces */
    float* out;                     /* transmittance behind the slab */
    float* mean;                    /* mean transmittance over the slab times the visible fraction */
    float* blend;                   /* scratch, count + 4 */
} ty_tube_row;

/* A row of cells of a slab. */
typedef struct ty_tube_cells {
    int32_t count;
    float weight[2][3];
    const float* mean[3]; /* rows of tubes whose first, second and third row of cells this is */
    float* transmittance; /* scratch: mean transmittance of cells */
    int32_t plane_count;
    float* planes[TY_TUBE_PLANES_MAX]; /* to add the transmittance to, times a factor each */
    const float* factor;
} ty_tube_cells;

/* A block of cells that is transposed, added to a plane, and cleared. */
enum { TY_TRANSPOSE_SIDE = 16 };
typedef struct ty_transpose_block {
    int32_t rows, columns; /* of `from`, each at most TY_TRANSPOSE_SIDE */
    float* from;
    size_t stride;     /* floats between rows */
    float* to;         /* destination, in which the first row is a column */
    size_t to_stride;  /* floats between its rows */
    int32_t backwards; /* the last row of `from` is the first column */
} ty_transpose_block;

/* A row of a point light's lattice of rays through one slab of cells. Lengths are m along w from the box's near end.
 * Pairs are linear in the ray's index: first + i * second. */
typedef struct ty_ray_row {
    int32_t begin, end;
    float near, far; /* sides of the slab */
    float at[2];     /* position along u on the far side, in cells from the first center */
    float slope[2];  /* cells along u per m along w */
    float row;       /* position along v on the far side, in cells from the first center */
    float row_slope;
    int32_t size[2], stride[2]; /* cells along u and v, and floats between them */
    const float* cells;         /* extinction of the slab, 1/m */
    const float* entry;         /* entry of each ray into the box; INFINITY: it misses */
    float* depth;               /* optical depth per direction cosine w, to the near side; updated to the far side */
    float* mean;                /* mean extinction from the entry to the near side, 1/m */
} ty_ray_row;

/* Interpolation between the rays around a row of cells: the lattice rows before and after it along v, on the near and
 * far side of its slab. */
typedef struct ty_ray_row_blend {
    int32_t begin, end;   /* rays */
    const float* mean[4]; /* near before, near after, far before, far after */
    const float* hit[2];  /* distance along w to the first surface, m; NULL: no surfaces */
    float row_t, far_t;
    float along;    /* w of the cells' centers, m */
    float* out;     /* mean extinction */
    float* visible; /* fraction of rays that reach the cells */
} ty_ray_row_blend;

/* Cells of a row along u within one pyramid of a point light. Pairs are linear in the cell's index: first + i * second.
 */
typedef struct ty_cell_row_means {
    int32_t begin, end;
    int32_t rays;
    float column[2];         /* lattice column at a cell's center */
    float off[2];            /* center, m along u from the light */
    float v, w;              /* the same along v and w; w > 0 */
    float side[2];           /* center, m along u from the side of the box towards the light */
    int32_t outside;         /* the light is beyond that side */
    float inside;            /* m along w from the entry of rays into the box across v or w */
    int32_t across_v;        /* that entry is across v */
    float cell[3];           /* sides along u, v, w, m */
    size_t stride;           /* floats between cells */
    const float* extinction; /* of the row, 1/m */
    const float* mean;       /* mean extinction along the rays */
    const float* visible;    /* visible fraction of the rays; NULL: 1 */
    int32_t spread;          /* means of transmittance / r^2 times the center's r^2, instead of transmittance */
    float* transmittance;    /* result of cell i at index i */
} ty_cell_row_means;

/* Directions and falloff from the light to those cells, without a medium. */
typedef struct ty_cell_row_directions {
    int32_t begin, end;
    float off[2], v, w;         /* as above, but w is signed */
    int32_t profile;            /* ty_light_profile */
    const ty_light_view* light; /* with the falloff of a spot */
    float axis_direction[3];    /* the light's axis along u, v, w */
    float* omega[3];            /* unit vectors from the light along u, v, w */
    float* falloff;             /* intensity profile over square distance, 1/m^2 */
} ty_cell_row_directions;

typedef struct ty_cell_row_sum {
    int32_t begin, end;
    size_t stride;
    float color;
    const float* transmittance;
    const float* falloff;
    const float* omega[3];
    float* fluence; /* of the row */
    float* flux[3]; /* along u, v, w; NULL: not computed */
} ty_cell_row_sum;

typedef struct ty_direct_kernels {
    void (*tubes)(const ty_tube_row* row);
    void (*cells)(const ty_tube_cells* cells);
    void (*transpose)(const ty_transpose_block* block);
    void (*trace_row)(const ty_ray_row* rays);
    void (*blend_rows)(const ty_ray_row_blend* blend);
    void (*cell_means)(const ty_cell_row_means* cells);
    void (*directions)(const ty_cell_row_directions* directions);
    void (*add_light)(const ty_cell_row_sum* sum);
} ty_direct_kernels;
TY_DECLARE_KERNELS(ty_direct_kernels);

#endif
