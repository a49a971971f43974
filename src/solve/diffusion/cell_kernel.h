/* Kernels of the diffusion solvers, one plane of cells per call. Compiled once per instruction set. */
#ifndef TY_SOLVE_DIFFUSION_CELL_KERNEL_H
#define TY_SOLVE_DIFFUSION_CELL_KERNEL_H

#include "base/dispatch.h"
#include "solve/diffusion/box.h"

/* Side of the box: the outflow through its faces is a D / (1 + b D) (phi - value) per volume of the cell. */
typedef struct ty_side {
    ty_boundary_kind kind;
    float a, b;         /* 1/m^2, 1/m; a is 0 for reflecting sides */
    const float* value; /* fluence of zero flux, times `scale`; one per face */
    ptrdiff_t step;     /* stride between rows of faces */
} ty_side;

/* The problem in the kernels' units: sources have an rms of about 1, fluences are scaled by the same factor. */
typedef struct ty_cells {
    ty_box box;
    float half_inverse[3];   /* 1 / (2 cell), over the def's streaming, 1/m; for R only */
    float coupling[3];       /* 1 / (2 cell^2), 1/m^2; multiplies the sum of two D */
    const float* extinction; /* unscaled */
    const float* absorption; /* unscaled; may be NULL */
    const float* source;     /* unscaled */
    float min_extinction;
    const float* zeros; /* a row of zeros */
    float scale;        /* of sources and fluences */
    ty_limiter limiter;
    float larsen_power;
    ty_side sides[6];
} ty_cells;

/* A level of the full approximation scheme (FAS): the nonlinear problem on a box, and its fluence. Coarser levels own
 * their media. */
typedef struct ty_fas_level {
    ty_cells cells;
    int32_t children[3]; /* cells of the finer stage per cell along each axis: 1 or 2 */
    double* phi;
    float* diffusivity;                      /* D */
    float *extinction, *absorption, *source; /* without ghosts */
    float* restricted;                       /* phi before a correction; afterwards its relative change */
} ty_fas_level;

/* A multigrid level: sum over neighbours of g (e - e_s) + d e = f, per volume of a cell of the level on which a cycle
 * begins. That level derives g from D, coarser ones store it: g[a] holds the lower faces of cells along axis a, 0 at
 * the box's faces. */
typedef struct ty_level {
    ty_box box;
    int32_t children[3];      /* cells of the finer level per cell along each axis: 1 or 2 */
    const float* diffusivity; /* D with ghosts that make couplings at the box's faces 0; NULL: g is stored */
    float coupling[3];        /* factor of D, as in ty_cells */
    float* g[3];
    float* d;
    float* e; /* with ghosts 0 */
    float* f;
} ty_level;

/* Sums over a plane. */
typedef struct ty_plane_sums {
    double a, b, c;
} ty_plane_sums;

/* Nonlinear problem (cell_kernel.c). */
typedef struct ty_cell_kernels {
    /* Ghosts of phi in and around plane z that make central differences exact at boundaries. */
    void (*ghosts)(const ty_cells* cells, double* phi, int32_t z);
    void (*ghosts_float)(const ty_cells* cells, float* phi, int32_t z);
    /* D of a plane, with ghosts as required by levels. */
    void (*diffuse)(const ty_cells* cells, const double* phi, float* diffusivity, int32_t z);
    /* Damped D of a Picard iteration, with ghosts. */
    void (*damp)(const ty_cells* cells, const float* diffusivity, float lambda, float* out, int32_t z);
    /* Sinks d of the first level, and f = q - A phi; returns the sum of f^2. */
    double (*assemble)(const ty_cells* cells, const double* phi, const float* diffusivity, const ty_level* level,
                       int32_t z);
    /* Algorithm 1 (Koerner 2014): a pass over the cells of a colour within `depth` cells of a face of the box; returns
     * the sum of squared residuals. */
    double (*sor)(const ty_cells* cells, double* phi, float* diffusivity, double omega, int32_t color, int32_t depth,
                  int32_t z);
    double (*sor_float)(const ty_cells* cells, float* phi, float* diffusivity, double omega, int32_t color,
                        int32_t depth, int32_t z);

    /* phi += x, with a lower bound relative to phi if a limiter is used. */
    void (*update)(const ty_cells* cells, const float* x, double* phi, int32_t z);
} ty_cell_kernels;
TY_DECLARE_KERNELS(ty_cell_kernels);

/* Linearised problem, on all levels (level_kernel.c). */
typedef struct ty_level_kernels {
    /* Gauss-Seidel over the cells of a colour in rows [rows[0], rows[1]); `begin` is the first half-sweep, which takes
     * e as 0. alone: no other thread writes the adjacent planes, so that their cells of the same colour may be read. */
    void (*begin)(const ty_level* level, int32_t color, const int32_t rows[2], int32_t z);
    void (*relax)(const ty_level* level, int32_t color, const int32_t rows[2], int32_t z, bool alone);
    /* f of a plane of the coarser level: sums of the finer level's residuals; returns their sum of squares. */
    double (*restrict_residual)(const ty_level* fine, const ty_level* coarse, int32_t z);
    /* Adds the coarser level's correction to e of a plane of the finer one. */
    void (*prolong)(const ty_level* fine, const ty_level* coarse, int32_t z);
    /* g and d of a plane of the coarser level. */
    void (*coarsen)(const ty_level* fine, const ty_level* coarse, int32_t z);

    /* Conjugate gradients: f.e. */
    double (*dot)(const ty_level* level, int32_t z);
    /* p = e + beta p. */
    void (*update_direction)(const ty_level* level, float beta, float* p, int32_t z);
    /* e = A p; returns p.e. */
    double (*apply)(const ty_level* level, const float* p, int32_t z);
    /* x += alpha p, f -= alpha e; returns f.f. */
    double (*step)(const ty_level* level, float alpha, const float* p, float* x, int32_t z);
} ty_level_kernels;
TY_DECLARE_KERNELS(ty_level_kernels);

/* Transfer between FAS stages (fas_kernel.c). */
typedef struct ty_fas_kernels {
    /* Media and sources of a plane of the coarser stage: means, for extinction the mean of mean free paths. */
    void (*restrict_media)(const ty_fas_level* fine, const ty_fas_level* coarse, int32_t z);
    /* Restricts phi to phi and `restricted`, and the residuals f to source, by means. */
    void (*restrict_phi)(const ty_fas_level* fine, const float* f, const ty_fas_level* coarse, int32_t z);
    /* From a source r and f = r - A phi, the source r + A phi, for which phi is the solution where r is 0. */
    void (*set_fas_source)(const ty_fas_level* stage, const float* f, int32_t z);
    /* `restricted` becomes phi / restricted - 1. */
    void (*relative_change)(const ty_fas_level* stage, int32_t z);
    /* A plane of the finer phi times 1 + `restricted` of the coarser stage, interpolated linearly between centers. */
    void (*correct)(const ty_fas_level* fine, const ty_fas_level* coarse, int32_t z);
} ty_fas_kernels;
TY_DECLARE_KERNELS(ty_fas_kernels);

#endif
