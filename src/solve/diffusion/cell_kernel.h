/* The kernels of the diffusion solvers, built once per instruction set. Each works on one plane of cells. */
#ifndef TY_SOLVE_DIFFUSION_CELL_KERNEL_H
#define TY_SOLVE_DIFFUSION_CELL_KERNEL_H

#include "solve/diffusion/box.h"

/* A side of the box: what flows out through its faces is a D / (1 + b D) (phi - value), per volume of its cells. */
typedef struct ty_side {
    ty_boundary_kind kind;
    float a, b;         /* 1/m^2, 1/m; a is 0 where nothing passes */
    const float* value; /* fluence that nothing would flow at, times `scale`; one for each face */
    ptrdiff_t step;     /* from one row of faces to the next */
} ty_side;

/* The problem as the kernels take it: sources have an rms of about 1, and fluences are multiplied by the same scale. */
typedef struct ty_cells {
    ty_box box;
    float half_inverse[3];   /* 1 / (2 cell), over the def's streaming, 1/m: for R alone */
    float coupling[3];       /* 1 / (2 cell^2), 1/m^2: times the sum of two D */
    const float* extinction; /* as given */
    const float* absorption; /* as given; may be NULL */
    const float* source;     /* as given */
    float least_extinction;
    const float* zeros; /* a row of them */
    float scale;        /* of sources and fluences */
    ty_limiter limiter;
    float larsen_power;
    ty_side sides[6];
} ty_cells;

/* The non-linear problem on a box, and its fluence. Coarser stages hold what theirs are made of. */
typedef struct ty_fas_level {
    ty_cells cells;
    int32_t children[3]; /* cells of the finer stage along each axis that make one here: 1 or 2 */
    double* phi;
    float* diffusivity;                      /* D */
    float *extinction, *absorption, *source; /* without ghosts, as `before` */
    float* before;                           /* phi before a correction; then what it changes by, relative to that */
} ty_fas_level;

/* A level of multigrid: sum over neighbours of g (e - e_s) + d e = f, all of it per volume of the cells of the level
 * that a cycle begins on. That level makes g of D, the coarser ones store it: g[a] holds the faces below each cell
 * along axis a, 0 where nothing is below. */
typedef struct ty_level {
    ty_box box;
    int32_t children[3];      /* cells of the finer level along each axis that make one here: 1 or 2 */
    const float* diffusivity; /* D, its ghosts such that nothing passes; NULL: g is stored */
    float coupling[3];        /* of D, as in ty_cells */
    float* g[3];
    float* d;
    float* e; /* ghosts are 0 */
    float* f;
} ty_level;

/* Sums over a plane. */
typedef struct ty_plane_sums {
    double a, b, c;
} ty_plane_sums;

/* The non-linear problem (kernel.c). */
typedef struct ty_cell_kernels {
    /* Ghosts of phi in and around plane z, such that central differences hold at boundaries. */
    void (*ghosts)(const ty_cells* cells, double* phi, int32_t z);
    void (*ghosts_float)(const ty_cells* cells, float* phi, int32_t z);
    /* D of a plane, and its ghosts as levels want them. */
    void (*diffuse)(const ty_cells* cells, const double* phi, float* diffusivity, int32_t z);
    /* Of D, what a step of Picard's had better take for it; with its ghosts. */
    void (*soften)(const ty_cells* cells, const float* diffusivity, float share, float* out, int32_t z);
    /* Sinks d of the first level, and f = q - A phi; returns the sum of f^2. */
    double (*assemble)(const ty_cells* cells, const double* phi, const float* diffusivity, const ty_level* level,
                       int32_t z);
    /* Algorithm 1: a pass over the cells of a colour that are among the `depth` nearest to a face of the box; returns
     * the sum of the squares of what their residuals were. */
    double (*sor)(const ty_cells* cells, double* phi, float* diffusivity, double omega, int32_t color, int32_t depth,
                  int32_t z);
    double (*sor_float)(const ty_cells* cells, float* phi, float* diffusivity, double omega, int32_t color,
                        int32_t depth, int32_t z);

    /* phi += x, and kept above a share of what it was when limited. */
    void (*update)(const ty_cells* cells, const float* x, double* phi, int32_t z);
} ty_cell_kernels;

/* Its linearisation, on all levels (level_kernel.c). */
typedef struct ty_level_kernels {
    /* Gauss-Seidel over the cells of a colour; the first, where e is 0 so far whatever is stored. alone: no one else
     * writes the planes on either side, so that their cells of the same colour may be read. */
    void (*begin)(const ty_level* level, int32_t color, int32_t z);
    void (*relax)(const ty_level* level, int32_t color, int32_t z, bool alone);
    /* f of a plane of the coarser level: the sum of what is left on the finer one, of which it returns the sum of
     * squares. */
    double (*restrict_residual)(const ty_level* fine, const ty_level* coarse, int32_t z);
    /* Adds to e of a plane of the finer level what the coarser one says. */
    void (*prolong)(const ty_level* fine, const ty_level* coarse, int32_t z);
    /* g and d of a plane of the coarser level. */
    void (*coarsen)(const ty_level* fine, const ty_level* coarse, int32_t z);

    /* Conjugate gradients: f.e. */
    double (*dot)(const ty_level* level, int32_t z);
    /* p = e + beta p. */
    void (*direct)(const ty_level* level, float beta, float* p, int32_t z);
    /* e = A p; returns p.e. */
    double (*apply)(const ty_level* level, const float* p, int32_t z);
    /* x += alpha p, f -= alpha e; returns f.f. */
    double (*step)(const ty_level* level, float alpha, const float* p, float* x, int32_t z);
} ty_level_kernels;

/* Between stages (stage_kernel.c). */
typedef struct ty_fas_kernels {
    /* A plane of the coarser stage's media and sources: means, of extinction that of mean free paths. */
    void (*thin)(const ty_fas_level* fine, const ty_fas_level* coarse, int32_t z);
    /* Means of the finer phi, as phi and `before`, and of its residuals f, as source. */
    void (*restrict_phi)(const ty_fas_level* fine, const float* f, const ty_fas_level* coarse, int32_t z);
    /* From a source r and f = r - A phi, the source r + A phi, with which phi solves the problem where r is 0. */
    void (*balance)(const ty_fas_level* stage, const float* f, int32_t z);
    /* `before` becomes phi / before - 1. */
    void (*compare)(const ty_fas_level* stage, int32_t z);
    /* A plane of the finer phi times 1 + `before` of the coarser stage, linear between centres. */
    void (*correct)(const ty_fas_level* fine, const ty_fas_level* coarse, int32_t z);
} ty_fas_kernels;

extern const ty_cell_kernels ty_cell_kernels_v1;
extern const ty_cell_kernels ty_cell_kernels_v3;
extern const ty_cell_kernels ty_cell_kernels_v4;
extern const ty_level_kernels ty_level_kernels_v1;
extern const ty_level_kernels ty_level_kernels_v3;
extern const ty_level_kernels ty_level_kernels_v4;
extern const ty_fas_kernels ty_fas_kernels_v1;
extern const ty_fas_kernels ty_fas_kernels_v3;
extern const ty_fas_kernels ty_fas_kernels_v4;

#endif
