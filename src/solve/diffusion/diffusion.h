/* Flux-limited diffusion of light on a box of cells, one colour channel per call:
 *
 *     div(D grad phi) = sigma_a phi - q,   D = F(R) / sigma_t,   R = |grad phi| / (sigma_t phi)
 *
 * (Eq. 20 (Koerner 2014); F = 1/3 is classical diffusion). Cells hold means; a face between cells has the mean D of the
 * two (Eq. 31), a face of the box its boundary condition. All solvers solve the same discrete equations. */
#ifndef TY_SOLVE_DIFFUSION_DIFFUSION_H
#define TY_SOLVE_DIFFUSION_DIFFUSION_H

#include "comm/domain.h"

#include <tyndall/base.h>

/* Table 2 (Koerner 2014). */
typedef enum ty_limiter {
    TY_LIMITER_NONE = 0, /* F = 1/3: classical diffusion */
    TY_LIMITER_SUM = 1,
    TY_LIMITER_MAX = 2,
    TY_LIMITER_KERSHAW = 3,
    TY_LIMITER_LARSEN = 4,
    TY_LIMITER_LEVERMORE_POMRANING = 5,
    TY_LIMITER_COUNT = 6
} ty_limiter;

/* The outflow through a Marshak boundary is at most half of the fluence. Light that streams towards it through vacuum
 * with a larger flux (ty_diffusion_def.streaming) accumulates there, contrary to the limiter; a fluence of 0 on the
 * faces lets it leave. */
typedef enum ty_boundary_kind {
    TY_BOUNDARY_MARSHAK = 0,    /* value: incident flux, W m^-2 (irradiance of the face); 0 is vacuum */
    TY_BOUNDARY_DIRICHLET = 1,  /* value: fluence on the face, W m^-2 */
    TY_BOUNDARY_REFLECTING = 2, /* zero flux, as at a mirror; value is unused */
    TY_BOUNDARY_COUNT = 3
} ty_boundary_kind;

typedef struct ty_boundary {
    ty_boundary_kind kind;
    const float* value; /* one per face of the side, the lower axis fastest; NULL: 0 */
} ty_boundary;

/* Surfaces between cells: faces that they close, one side per cell (closed_faces.c). Laid out as ty_boundary_faces. */
typedef struct ty_diffusion_faces {
    int32_t count;
    const int32_t *first, *x;
    const uint8_t *face, *closed;
    const float* albedo;    /* per side, 0..1 */
    const float* radiosity; /* besides reflection, W m^-2; NULL: 0 */
    const float* staircase; /* total area of the faces over that of the slanted surface, at least 1 */
} ty_diffusion_faces;

typedef enum ty_diffusion_solver {
    TY_DIFFUSION_MULTIGRID = 0, /* Picard iterations by multigrid, with FAS corrections from coarser levels */
    TY_DIFFUSION_SOR = 1,       /* Algorithm 1 (Koerner 2014), in double precision */
    TY_DIFFUSION_SOR_FLOAT = 2, /* the same in single precision: sufficient for a tolerance of 1e-4 */
    TY_DIFFUSION_SOLVER_COUNT = 3
} ty_diffusion_solver;

enum { TY_DIFFUSION_SIDE_MAX = 4096 };

typedef struct ty_diffusion_def {
    int32_t size[3];         /* cells along x, y, z: 1..4096 each */
    double cell[3];          /* cell edges, m */
    const float* extinction; /* sigma_t, 1/m, x fastest; in anisotropic media sigma_t (1 - albedo g) */
    const float* absorption; /* sigma_a, 1/m; NULL: 0 */
    const float* source;     /* q, W m^-3: singly scattered light, and emission */
    double min_extinction;   /* sigma_eps, 1/m, lower bound of the extinction; 0 (default): 1e-3 / the longest extent */
    ty_limiter limiter;      /* default Levermore-Pomraning */
    double larsen_power;     /* n of TY_LIMITER_LARSEN, 1..100; default 2 */
    double streaming; /* maximum of |flux| / fluence, (0, 1]: limiters get R / streaming, so that the flux tends to
                         streaming times phi. Default 1, as in the paper: light far from its sources. 0.5 is light
                         leaving surfaces of thick media for vacuum, and the outflow of Marshak boundaries: it does not
                         accumulate before them */
    ty_boundary boundary[6];         /* lower x, upper x, lower y, ...; default Marshak with no incident flux */
    const ty_diffusion_faces* faces; /* surfaces; NULL (default): none. With them the solver is
                                        TY_DIFFUSION_MULTIGRID */
    ty_diffusion_solver solver;
    double relaxation;      /* omega of SOR, 0..2 exclusive; default 1.85 */
    double tolerance;       /* bound of rms(residual) / rms(source), where the source includes the incident flux of
                               boundaries; default 1e-6. Fluences are accurate to about a tenth of it */
    int32_t iterations;     /* maximum; 0 (default): 500 of multigrid, 20000 of SOR */
    int32_t min_iterations; /* minimum of multigrid, unless `iterations` is smaller: the source of a few bright cells
                                 can initially dominate the norm and hide residuals elsewhere. Default 0 */
    const float* start;     /* initial fluence, W m^-2, at least 0; NULL (default): the solver's own, for multigrid from
                               coarser levels */
    ty_progress_fn progress; /* default NULL */
    void* progress_user;
    ty_domain* domain; /* NULL (default): none. Of ty_diffusion_divide: size, arrays and results are those of this
                          rank's box, with boundary values of its faces, and faces (on all ranks or on none); all ranks
                          call ty_diffusion_solve */
    void* memory;      /* ty_diffusion_memory bytes, aligned to 64; NULL (default): from the context */
    uint32_t periodic; /* axes along which the box repeats, bit a for axis a: the boundaries there have no effect. With
                          it the solver is TY_DIFFUSION_MULTIGRID, and domain and faces are NULL. Default 0 */
} ty_diffusion_def;

ty_diffusion_def ty_default_diffusion_def(void);

typedef struct ty_diffusion_out {
    float* fluence; /* phi, W m^-2, one per cell; required */
    float* flux[3]; /* each may be NULL. Net flux through faces towards +x, +y, +z, W m^-2: an array has one more entry
                       along its own axis than there are cells */
    float* diffusivity;                 /* D, m, one per cell; may be NULL */
    float *side_flux, *side_irradiance; /* per side of def->faces: net flux through the face to the surface, and partial
                                           current towards it (its irradiance), W m^-2; may be NULL */
    double* history; /* rms(residual) / rms(source) before each iteration, and after the last; may be NULL */
    int32_t history_capacity;
} ty_diffusion_out;

typedef struct ty_diffusion_stats {
    bool converged;
    int32_t iterations;    /* SOR: sweeps of all cells; multigrid: Picard iterations */
    int32_t cycles;        /* multigrid cycles on the finest level */
    int32_t history_count; /* number of values written to out->history */
    double residual;       /* last value of the history */
    double work; /* passes over all cells, in units of one relaxation; coarser grids count by their number of cells */
    double seconds;
    double emitted, absorbed, leaving; /* W: by the source, by the medium, and net through the box's open faces */
    int32_t ranks;                     /* that solved together, each for its box */
    double bytes;                      /* memory of the solver on this rank */
    double surfaces_emitted, surfaces_absorbed; /* W: besides what they reflect */
} ty_diffusion_stats;

/* Cuts the grid of a def among ranks, along y and z. False: it has too few cells for so many. */
bool ty_diffusion_divide(ty_comm* comm, const ty_diffusion_def* def, ty_domain* out);

/* Bytes required by a def with this size, solver and domain. */
size_t ty_diffusion_memory(const ty_diffusion_def* def);

/* Solves for the fluence. The result does not depend on the number of threads. stats may be NULL. A solve that reaches
 * its maximum of iterations returns TY_OK with stats->converged false; on TY_CANCELLED out holds the latest iterate.
 * Sources are at least 0 unless the limiter is none. Errors: TY_ERROR_ARGUMENT, TY_ERROR_MEMORY; of a
 * divided grid, on all ranks that are left, TY_ERROR_UNSUPPORTED: a rank does not answer. */
ty_result ty_diffusion_solve(ty_context* context, const ty_diffusion_def* def, const ty_diffusion_out* out,
                             ty_diffusion_stats* stats);

#endif
