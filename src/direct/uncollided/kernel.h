/* The row loops of beams and lamps, built once per instruction set. */
#ifndef TY_DIRECT_UNCOLLIDED_KERNEL_H
#define TY_DIRECT_UNCOLLIDED_KERNEL_H

#include "direct/uncollided/point_light.k.h"

/* Rays along each tube that find where surfaces are. */
enum { TY_TUBE_RAYS = 4 };

/* Planes that a beam may add to at once: fluence and flux of three channels. */
enum { TY_TUBE_PLANES_MAX = 12 };

/* Tubes through a slab: tube t of a row overlaps its cells t - 2, t - 1 and t. */
typedef struct ty_tube_row {
    int32_t count;                  /* cells in a row; tubes are two more */
    float weight[2][3];             /* of each tube's three cells, and three rows */
    float length;                   /* of a tube within the slab, m */
    float start;                    /* how far the slab's near side is along the tubes, m */
    const float* cells[3];          /* extinction of the three rows, 1/m */
    const float* hit[TY_TUBE_RAYS]; /* how far along each tube its rays meet a surface, m; NULL: there is none */
    const float* in;                /* transmittance of each tube up to the slab, surfaces ignored */
    float* out;                     /* and up to its far side */
    float* mean;                    /* transmittance over the slab, times the share of it before surfaces */
    float* blend;                   /* scratch, count + 4 */
} ty_tube_row;

/* Cells of a slab. */
typedef struct ty_tube_cells {
    int32_t count;
    float weight[2][3];
    const float* mean[3]; /* of the rows of tubes that have these cells as their first, second and third row */
    float* transmittance; /* scratch: mean transmittance of cells */
    int32_t plane_count;
    float* planes[TY_TUBE_PLANES_MAX]; /* what that is added to, times a factor each */
    const float* factor;
} ty_tube_cells;

/* A block of cells to add to a plane in which rows and columns have changed places; leaves zeros behind. */
enum { TY_TRANSPOSE_SIDE = 16 };
typedef struct ty_transpose_block {
    int32_t rows, columns; /* of `from`, each TY_TRANSPOSE_SIDE at most */
    float* from;
    size_t stride;     /* floats from row to row */
    float* to;         /* where the first row is a column */
    size_t to_stride;  /* floats from row to row there */
    int32_t backwards; /* whether the last row of `from` is the first column */
} ty_transpose_block;

/* A row of a lamp's lattice of rays through one slab of cells. Lengths are m along w from where the box begins; ray i
 * is where two numbers say, first + i * second. */
typedef struct ty_ray_row {
    int32_t begin, end;
    float near, far; /* of the slab */
    float at[2];     /* along u on its far side, in cells from the first one's middle */
    float slope[2];  /* cells along u per m along w */
    float row;       /* along v on the far side, in cells from the first one's middle */
    float row_slope;
    int32_t size[2], stride[2]; /* cells along u and v, and floats from one to the next */
    const float* cells;         /* extinction of the slab, 1/m */
    const float* entry;         /* where each ray enters the box; INFINITY: nowhere */
    float* depth;               /* up to the near side, and then the far side, as if lengths were taken along w */
    float* mean;                /* extinction from where the ray enters up to the near side, 1/m */
} ty_ray_row;

/* Rows of rays about a row of cells: the rays before and after it along v, on the near and the far side of its slab. */
typedef struct ty_ray_row_blend {
    int32_t begin, end;   /* rays */
    const float* mean[4]; /* near before, near after, far before, far after */
    const float* hit[2];  /* how far along w each meets a surface, m; NULL: there is none */
    float row_t, far_t;
    float along;    /* of the cells' middles, m along w */
    float* out;     /* mean extinction */
    float* visible; /* share of the rays that get there */
} ty_ray_row_blend;

/* Cells of a row along u that one pyramid of a lamp's has; cell i is where two numbers say, first + i * second. */
typedef struct ty_cell_row_means {
    int32_t begin, end;
    int32_t rays;
    float column[2];         /* which ray is at a cell's middle */
    float off[2];            /* of the middle, m along u from the lamp */
    float v, w;              /* the same along v and w; w > 0 */
    float side[2];           /* middles, m along u from the box's side that is towards the lamp */
    int32_t outside;         /* whether the lamp is beyond that side */
    float inside;            /* m along w from where rays enter the box across v or w */
    int32_t across_v;        /* whether it is across v */
    float cell[3];           /* sides along u, v, w, m */
    size_t stride;           /* floats from cell to cell */
    const float* extinction; /* of the row, 1/m */
    const float* mean;       /* of rays */
    const float* visible;    /* NULL: all are */
    int32_t spread;          /* whether the mean is that of transmittance / r^2, times r^2 in the middle */
    float* transmittance;    /* cell i's goes to lit[i] */
} ty_cell_row_means;

/* What comes to those cells without a medium. */
typedef struct ty_cell_row_directions {
    int32_t begin, end;
    float off[2], v, w;         /* as above, but w has its sign */
    int32_t profile;            /* ty_light_profile */
    const ty_light_view* light; /* that a spot's falloff is read from */
    float axis_direction[3];    /* the lamp's direction along u, v, w */
    float* omega[3];            /* unit vectors from the lamp along u, v, w */
    float* falloff;             /* of intensity, by direction and distance, 1/m^2 */
} ty_cell_row_directions;

typedef struct ty_cell_row_sum {
    int32_t begin, end;
    size_t stride;
    float color;
    const float* transmittance;
    const float* falloff;
    const float* omega[3];
    float* fluence; /* rows */
    float* flux[3]; /* along u, v, w; NULL: not asked for */
} ty_cell_row_sum;

typedef struct ty_direct_kernels {
    void (*tubes)(const ty_tube_row* row);
    void (*cells)(const ty_tube_cells* cells);
    void (*transpose)(const ty_transpose_block* block);
    void (*trace_row)(const ty_ray_row* rays);
    void (*blend_rows)(const ty_ray_row_blend* blend);
    void (*cell_means)(const ty_cell_row_means* cells);
    void (*directions)(const ty_cell_row_directions* ways);
    void (*add_light)(const ty_cell_row_sum* sum);
} ty_direct_kernels;

extern const ty_direct_kernels ty_direct_kernels_v1;
extern const ty_direct_kernels ty_direct_kernels_v3;
extern const ty_direct_kernels ty_direct_kernels_v4;

/* Those for this processor. */
const ty_direct_kernels* ty_direct_kernels_best(void);

#endif
