/* Data of a sweep, and its blocks of rows. */
#ifndef TY_SOLVE_ORDINATES_SWEEP_STATE_H
#define TY_SOLVE_ORDINATES_SWEEP_STATE_H

#include "solve/ordinates/sweep_kernel.h"
#include "solve/ordinates/sweep_schedule.h"

/* Rows of a block along y and z: the radiance at its faces fits in the cache. */
enum { TY_SWEEP_BLOCK_ROWS = 8 };

struct ty_sweep {
    ty_context* context;
    const ty_sweep_kernels* kernels;
    ty_sweep_box box;
    float* boundary; /* radiance of all patches; NULL: none enters, and that of one patch is */
    size_t boundary_floats;
    const float* dark[8];
    int32_t blocks[2];     /* along y, z */
    size_t scratch_floats; /* per thread */
    float* scratch;
    ty_sweep_sums* sums; /* one per block */
    double leaving[8];   /* per octant, through faces across y and z */
    void* memory;
    size_t bytes;
    const ty_domain* domain; /* of which the box is a part; NULL: the whole */
    ty_sweep_schedule schedule;
    float* message; /* of the largest face */
    float* inflow;  /* of a box that repeats */
    void* inflow_memory;
    size_t inflow_floats, inflow_bytes;
    void* division_memory;
    size_t division_bytes;
    struct ty_sweep_device* on_device; /* NULL: none, or not made yet */
};

/* Sets rows of upwind faces of a block that is the first along y, z to the boundary radiance. */
void ty_sweep_set_boundary(const ty_sweep_box* box, const ty_sweep_block* block, const bool first[2]);
/* Blocks and bytes of a part's sweep. */
void ty_sweep_plan_units(ty_sweep* sweep, const ty_domain* domain);
/* Frees what ty_sweep_divide made. */
void ty_sweep_free_division(ty_sweep* sweep);
/* Frees what ty_sweep_repeat made. */
void ty_sweep_free_inflow(ty_sweep* sweep);
/* Sweeps all units of this part in the order of its schedule. Errors: TY_ERROR_INTERNAL: a rank does not answer. */
ty_result ty_sweep_run_units(ty_sweep* sweep, const float* emission, float* moments);
/* True where the part's faces across y lie on the whole box, downwind in an octant. */
bool ty_sweep_leaves_across_y(const ty_sweep* sweep, int32_t octant);

#endif
