/* Flux-limited diffusion of light on a box of cells, one colour channel a call:
 *
 *     div(D grad phi) = sigma_a phi - q,   D = F(R) / sigma_t,   R = |grad phi| / (sigma_t phi)
 *
 * (Koerner et al. 2014, Eq. 20; F = 1/3 is classical diffusion). Cells hold means; faces between cells have the mean D
 * of the two (Eq. 31), faces of the box what their boundary says. Both solvers solve the same equations. */
#ifndef TY_SOLVE_DIFFUSION_DIFFUSION_H
#define TY_SOLVE_DIFFUSION_DIFFUSION_H

#include <tyndall/base.h>

/* Table 2. */
typedef enum ty_limiter {
    TY_LIMITER_NONE = 0, /* F = 1/3: classical diffusion */
    TY_LIMITER_SUM = 1,
    TY_LIMITER_MAX = 2,
    TY_LIMITER_KERSHAW = 3,
    TY_LIMITER_LARSEN = 4,
    TY_LIMITER_LEVERMORE_POMRANING = 5,
    TY_LIMITER_COUNT = 6
} ty_limiter;

/* A Marshak boundary lets at most half of the fluence out. Light that streams towards it through vacuum with more than
 * that (ty_diffusion_def.streaming) piles up there, against what the limiter says; with a fluence of 0 on the faces it
 * streams out. */
typedef enum ty_boundary_kind {
    TY_BOUNDARY_MARSHAK = 0,   /* value: the flux that comes in, W m^-2 (irradiance of the face); 0 is vacuum */
    TY_BOUNDARY_DIRICHLET = 1, /* value: the fluence on the face, W m^-2 */
    TY_BOUNDARY_REFLECTING = 2,    /* nothing passes: a mirror; value is not used */
    TY_BOUNDARY_COUNT = 3
} ty_boundary_kind;

typedef struct ty_boundary {
    ty_boundary_kind kind;
    const float* value; /* one for each face of the side, the axis that comes first running fastest; NULL: 0 */
} ty_boundary;

typedef enum ty_diffusion_solver {
    TY_DIFFUSION_MULTIGRID = 0, /* Picard iterations, which coarser boxes correct; multigrid solves what they ask */
    TY_DIFFUSION_SOR = 1,       /* Algorithm 1, in double precision */
    TY_DIFFUSION_SOR_FLOAT = 2, /* the same in single precision: good for a tolerance of 1e-4 */
    TY_DIFFUSION_SOLVER_COUNT = 3
} ty_diffusion_solver;

enum { TY_DIFFUSION_SIDE_MAX = 4096 };

typedef struct ty_diffusion_def {
    int32_t size[3];         /* cells along x, y, z: 1..4096 each */
    double cell[3];          /* their edges, m */
    const float* extinction; /* sigma_t, 1/m, x fastest: of anisotropic media sigma_t (1 - albedo g) */
    const float* absorption; /* sigma_a, 1/m; NULL: 0 */
    const float* source;     /* q, W m^-3: light that scatters for the first time, and emission */
    double least_extinction; /* sigma_eps, 1/m, for extinctions below it; 0 (default): 1e-3 / the longest extent */
    ty_limiter limiter;      /* default Levermore-Pomraning */
    double larsen_power;     /* n of TY_LIMITER_LARSEN, 1..100; default 2 */
    double streaming; /* the most of its fluence that light flows with, (0, 1]: limiters see R / streaming, so that
                         R F(R) goes there. Default 1, the paper's: light far from where it comes from. 0.5 is
                         light that leaves surfaces of thick media for vacuum, and what Marshak boundaries let
                         out: nothing piles up before them then */
    ty_boundary boundary[6]; /* x low, x high, y low, ...; default Marshak, nothing comes in */
    ty_diffusion_solver solver;
    double relaxation;  /* SOR's omega, 0..2 exclusive; default 1.85 */
    double tolerance;   /* of rms(residual) / rms(source), where the source counts what comes in through boundaries;
                           default 1e-6. Fluences are good to about a tenth of it */
    int32_t iterations; /* at most; 0 (default): 500 of multigrid, 20000 of SOR */
    int32_t least_iterations; /* of multigrid, unless `iterations` is less: a few bright cells may hide behind their own
                                 source what is left elsewhere at first. Default 0 */
    const float* start; /* a fluence to start from, W m^-2, at least 0; NULL (default): the solver's own, of multigrid
                           what coarser boxes find */
    ty_progress_fn progress; /* default NULL */
    void* progress_user;
    void* memory; /* ty_diffusion_memory bytes, aligned to 64; NULL (default): from the context */
} ty_diffusion_def;

ty_diffusion_def ty_default_diffusion_def(void);

typedef struct ty_diffusion_out {
    float* fluence;     /* phi, W m^-2, a value a cell; must be there */
    float* flux[3];     /* each may be NULL. Net flux through faces towards +x, +y, +z, W m^-2: an array has one
                           more value along its own axis than there are cells */
    float* diffusivity; /* D, m, a value a cell; may be NULL */
    double* history;    /* rms(residual) / rms(source) before each iteration, and after the last; may be NULL */
    int32_t history_capacity;
} ty_diffusion_out;

typedef struct ty_diffusion_stats {
    bool converged;
    int32_t iterations;    /* SOR: sweeps of all cells; multigrid: Picard iterations */
    int32_t cycles;        /* of multigrid, on all cells */
    int32_t history_count; /* values written to out->history */
    double residual;       /* the last of the history */
    double work;           /* passes over all cells, as a relaxation of them is one; coarser grids by their cells */
    double seconds;
    double emitted, absorbed, leaving; /* W: by the source, by the medium, and net through the box's faces */
} ty_diffusion_stats;

/* What a def with this size and solver needs. */
size_t ty_diffusion_memory(const ty_diffusion_def* def);

/* Solves for the fluence. The result does not depend on the number of threads. stats may be NULL. A solve that runs out
 * of iterations is TY_OK with stats->converged false; on TY_CANCELLED out holds what there was. Sources are at least 0
 * unless the limiter is none. Errors: TY_ERROR_ARGUMENT, TY_ERROR_MEMORY. */
ty_result ty_diffusion_solve(ty_context* context, const ty_diffusion_def* def, const ty_diffusion_out* out,
                             ty_diffusion_stats* stats);

#endif
