/* Discrete ordinates: transport with scattering on a box of cells along a set of directions, one colour channel per
 * call.
 *
 *     w . grad psi + sigma* psi = sum_lm s_l phi_lm Y_lm(w) + sum_lm q_lm Y_lm(w)
 *     sigma* = sigma_t - g^L sigma_s,   s_l = sigma_s (g^l - g^L),   l < L
 *
 * This is the transport equation with a Henyey-Greenstein phase function whose forward peak counts as unscattered
 * light (delta-M; Wiscombe 1977). phi_lm is the integral of psi Y_lm over all directions; Y_lm are real and
 * orthonormal, without Condon-Shortley sign, index l (l + 1) + m (base/sh.k.h), so that phi_00 sqrt(4 pi) is the
 * fluence. The radiance incident on the box's faces is given; opaque faces between cells or around the box reflect.
 * Cells hold means; diffusive cells hold fluence and flux only. The result does not depend on the number of threads. */
#ifndef TY_SOLVE_ORDINATES_ORDINATES_H
#define TY_SOLVE_ORDINATES_ORDINATES_H

#include "comm/domain.h"
#include "solve/angular/quadrature.h"

enum { TY_SCATTERING_ORDER_MAX = 12 };
/* Default minimum edge of a diffusive cell, mean free paths. */
enum { TY_DIFFUSIVE_FREE_PATHS = 6 };

/* Boundary faces, laid out as in ty_sweep_faces: opaque ones, whose reflection is diffuse, and smooth interfaces of
 * dielectrics, which reflect each direction into the one mirrored at the face, with Fresnel's reflectance at the angle
 * to the interface; what they do not reflect counts as absorbed by the faces. */
typedef struct ty_ordinates_faces {
    int32_t count;        /* number of sides; 0 (default): no faces */
    const int32_t* first; /* first side of each row of cells; the last entry is count */
    const int32_t* x;     /* cell of each side within its row */
    const uint8_t* face;  /* 2 * axis + (1 for the upper face) */
    const float*
        albedo; /* [0, 1]; of an interface R_eff, ty_fresnel_effective_reflectance of its index and staircase factor */
    const float* emission; /* emitted radiance besides reflection, W m^-2 sr^-1 */
    float* irradiance;     /* out: irradiance, W m^-2; may be NULL */
    const float* ior;    /* index of the side's cell relative to the other side of the interface, at least 1; 0: opaque.
                            NULL (default): all are opaque. Not together with final_set */
    const float* normal; /* with ior: three per side, the interface's unit normal out of the side's cell */
    float* absorbed;     /* out: what a side takes of its irradiance and does not return, W m^-2; may be NULL */
} ty_ordinates_faces;

/* Radiance that enters the box. Its faces are divided into patches, over each of which it is even. */
typedef struct ty_boundary_radiance {
    const float* across[3]; /* through the faces across each axis: patch by patch, the lower axis fastest, one number
                               per direction of the set, which enters through one of the two; all NULL: none */
    int32_t patches[3];     /* along each axis, at most as many as cells; 0: 1 */
} ty_boundary_radiance;

static inline int32_t ty_boundary_patches(const ty_boundary_radiance* boundary, int axis) {
    return boundary->patches[axis] > 0 ? boundary->patches[axis] : 1;
}

/* Patches of the faces across an axis. */
static inline int32_t ty_boundary_patch_count(const ty_boundary_radiance* boundary, int axis) {
    return ty_boundary_patches(boundary, axis == 0 ? 1 : 0) * ty_boundary_patches(boundary, axis == 2 ? 1 : 2);
}

/* The patch of a cell's face across an axis. */
static inline int32_t ty_boundary_patch(const ty_boundary_radiance* boundary, const int32_t size[3], int axis,
                                        const int32_t at[3]) {
    const int low = axis == 0 ? 1 : 0, high = axis == 2 ? 1 : 2;
    const int32_t columns = ty_boundary_patches(boundary, low), rows = ty_boundary_patches(boundary, high);
    return at[high] * rows / size[high] * columns + at[low] * columns / size[low];
}

typedef struct ty_ordinates_def {
    int32_t size[3]; /* cells along x, y, z: 1..1024 each */
    /* The box is this rank's part of a domain, which is cut along x and y alone; all arrays are of the part, but those
     * of boundary_radiance. The solve is then a call of all ranks, and stats are of the whole. NULL (default): the
     * whole. */
    ty_domain* domain;
    double cell[3]; /* cell edges, m */
    /* Axes along which the box repeats, bit a for axis a, without domain, walls, boundary_radiance, final_set, closed
     * and diffusive cells. Default 0. */
    uint32_t periodic;
    /* out, with it: of each cell the power through its lower face of light that goes down along passing_axis (y or z),
     * and through its upper face of light that goes up, W. NULL (default): no output */
    float* passing[2];
    int passing_axis;
    const ty_angular_quadrature* set;
    /* Directions of one final sweep with the converged source, against ray effects of small sets; not together with
     * boundary_radiance; NULL (default): no final sweep. */
    const ty_angular_quadrature* final_set;
    int32_t bands;           /* L, Legendre orders of scattering, 1..TY_SCATTERING_ORDER_MAX */
    int32_t output_order;    /* Legendre orders of the resulting moments, bands..TY_SCATTERING_ORDER_MAX */
    const float* extinction; /* sigma_t, 1/m, x fastest; 0: vacuum */
    const float* scattering; /* sigma_s, 1/m, at most sigma_t */
    const float* g;          /* mean cosine, (-1, 1) */
    const float* scattered;  /* s_l / sigma_s, l < bands, uniform, instead of the values from g: the first is at most 1,
                                and its complement is the forward peak; NULL (default): from g */
    const float* const* source; /* q_lm: `source_terms` planes */
    int32_t source_terms;       /* 1 or bands^2 */
    /* Four planes: the part of q_00 whose positions within cells are known, and that times their center along x, y and
     * z, -1..1; diffusive cells use them, and with bands^2 source terms all others where accelerated. NULL (default):
     * positions follow from the neighbours' sources. */
    const float* const* source_center;
    bool displaces_sources; /* the centers count in swept cells, too, by first moments */
    ty_ordinates_faces walls;
    ty_boundary_radiance boundary_radiance; /* default: 0 */
    bool accelerated;                       /* diffusion synthetic acceleration, 2 to 12 sweeps, with diffusive cells
                                               (solve/ordinates/diffusive_cells.h); false: source iteration, as many sweeps as scattering
                                               orders */
    double diffusive_paths; /* minimum edge of a diffusive cell, mean free paths; default TY_DIFFUSIVE_FREE_PATHS */
    double tolerance;       /* bound of the estimated remaining error, relative rms of the fluence; default 1e-3 */
    int32_t sweeps;         /* maximum; 0 (default): 100 accelerated, else 10000 */
    float* face_fluence;    /* out: per cell, six numbers, one per face (2 * axis + (1 for the upper face)). For a
                       diffusive cell that faces a transport cell: 4 J_out / sqrt(4 pi), i.e. the fluence a viewer in front
                       of that face would see. Negative elsewhere. NULL (default): no output */
    float* face_incident; /* out, with face_fluence: 4 J_in / sqrt(4 pi) at the same faces. NULL (default): no output */
    const uint16_t*
        closed; /* of the solution whose adjoint this is (solve/ordinates/adjoint.h); NULL (default): none */
    const float* const* start; /* initial moments, bands^2 planes; NULL (default): 0, or diffusion if accelerated */
    void* memory;              /* ty_ordinates_memory bytes, aligned to 64; NULL (default): from the context */
    ty_progress_fn progress;   /* default NULL */
    void* progress_user;
} ty_ordinates_def;

ty_ordinates_def ty_default_ordinates_def(void);
/* NULL where a solve of the whole can be divided among ranks; or the reason why not, in words that follow "because". */
const char* ty_ordinates_undivided(const ty_ordinates_def* whole);
/* Bytes of the cell arrays of a solve; depends on size, bands, source_terms, walls.count and accelerated. Sweeps and
 * DSA allocate their own memory. */
size_t ty_ordinates_memory(const ty_ordinates_def* def);

typedef struct ty_ordinates_stats {
    bool converged;
    int32_t sweeps, cycles;
    double change; /* estimated remaining error of the fluence, relative rms; with diffusive cells at least the relative
                      energy imbalance */
    double emitted, absorbed, leaving; /* W: by the source, by the medium, through the box's faces */
    double walls_emitted, walls_absorbed, entering;
    double seconds, sweep_seconds;
    double bytes;
} ty_ordinates_stats;

/* Solves for the moments: output_order^2 planes of one float per cell. history: the estimated remaining error after
 * each sweep, may be NULL. stats may be NULL. A solve that reaches its maximum of sweeps returns TY_OK with
 * stats->converged false; on TY_CANCELLED the moments hold the latest iterate. Errors: TY_ERROR_ARGUMENT,
 * TY_ERROR_MEMORY; TY_ERROR_INTERNAL: a rank does not answer. */
ty_result ty_ordinates_solve(ty_context* context, const ty_ordinates_def* def, float* const* moments, double* history,
                             int32_t history_capacity, ty_ordinates_stats* stats);

#endif
