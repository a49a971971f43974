/* The iterations of propagation and their energy balance. */
#include "method/lpv/propagate/propagate.h"

#include "base/constants.h"
#include "base/context.h"
#include "base/progress.h"
#include "method/lpv/propagate/device/device.h"

enum { ITERATIONS_MAX = 4096, ITERATIONS_PUBLISHED = 8 };

static const double power_of_term = TY_SQRT_4PI_F64;

/* Books the light that entered, and its absorption before the first step. */
static void enter(const ty_lpv_sums* sums, double scale, ty_lattice_power* power, double size[3], double absorbed[3]) {
    for (int c = 0; c < 3; ++c) {
        power->entered[c] += scale * sums->arrived[c];
        power->left[c] += scale * sums->arrived[c];
        absorbed[c] += scale * (sums->arrived[c] - sums->goes_on[c]);
        size[c] += scale * sums->size[c];
    }
}

/* Books a step; true when less than the tolerated fraction of the entered light is still in flight. */
static bool book(const ty_lpv_sums* sums, const double size[3], double tolerance, ty_lattice_power* power,
                 double absorbed[3]) {
    bool done = true;
    for (int c = 0; c < 3; ++c) {
        power->absorbed[c] += absorbed[c];
        absorbed[c] = power_of_term * (sums->arrived[c] - sums->goes_on[c]);
        power->blocked[c] += power_of_term * sums->blocked[c];
        power->escaped[c] += power_of_term * sums->left[c];
        power->left[c] = power_of_term * sums->arrived[c];
        done = done && power_of_term * sums->size[c] <= tolerance * size[c];
    }
    return done;
}

typedef struct iteration_plan {
    int32_t max;
    double tolerance; /* negative: none */
} iteration_plan;

static iteration_plan plan_iterations(const ty_lpv_def* def) {
    if (def->iterations > 0) return (iteration_plan){.max = def->iterations, .tolerance = -1};
    if (def->mode == TY_LPV_MODE_PUBLISHED) return (iteration_plan){.max = ITERATIONS_PUBLISHED, .tolerance = -1};
    return (iteration_plan){.max = ITERATIONS_MAX, .tolerance = def->tolerance};
}

/* on: NULL: by the processor. */
static ty_result step(ty_lpv_propagation* propagation, ty_lpv_device* on, bool adds, ty_lpv_sums* sums) {
    if (on != NULL) return ty_lpv_device_step(on, adds, sums);
    *sums = ty_lpv_propagation_step(propagation, adds);
    return TY_OK;
}

static ty_result iterate(ty_lpv_propagation* propagation, ty_lpv_device* on, const ty_lpv_def* def,
                         const double size[3], double absorbed[3], ty_part_progress* progress,
                         ty_lattice_power* power) {
    const iteration_plan plan = plan_iterations(def);
    for (bool done = false; !done && power->iterations < plan.max; ++power->iterations) {
        if (ty_part_show(progress, "propagation", (double)power->iterations / plan.max) != TY_OK) return TY_CANCELLED;
        ty_lpv_sums sums;
        const ty_result result = step(propagation, on, power->iterations % 2 == 0, &sums);
        if (result != TY_OK) return result;
        done = book(&sums, size, plan.tolerance, power, absorbed);
    }
    return TY_OK;
}

ty_result ty_lattice_propagate(ty_lattice* lattice, const ty_lpv_def* def, float* const own_cell_sh[3][TY_SH_TERMS],
                               const ty_lattice* outer, ty_progress_fn progress, void* progress_user,
                               ty_lattice_power* power) {
    ty_part_progress part = ty_part_begin(progress, progress_user, 0, 1);
    const double begun = ty_wall_seconds();
    *power = (ty_lattice_power){.iterations = 0};
    ty_lpv_propagation propagation;
    ty_result result = ty_lpv_propagation_create(lattice, def, &propagation);
    if (result != TY_OK) return result;
    double size[3] = {0, 0, 0}, absorbed[3] = {0, 0, 0};
    if (outer != NULL) {
        const ty_lpv_sums inflow = ty_lpv_propagation_inflow(&propagation, outer);
        enter(&inflow, power_of_term, power, size, absorbed);
    }
    const ty_lpv_sums injected = ty_lpv_propagation_inject(&propagation, own_cell_sh);
    enter(&injected, power_of_term, power, size, absorbed);
    const double prepared = ty_wall_seconds();
    ty_lpv_device* on = NULL;
    result = ty_lpv_device_create(&propagation, &on);
    if (result == TY_OK) result = iterate(&propagation, on, def, size, absorbed, &part, power);
    if (result == TY_OK && on != NULL) result = ty_lpv_device_finish(on);
    ty_lpv_device_destroy(on);
    const double arrived = ty_wall_seconds();
    ty_lpv_propagation_gather(&propagation, own_cell_sh, power->iterations % 2 == 0);
    ty_lpv_propagation_destroy(&propagation);
    power->prepare_seconds = prepared - begun;
    power->propagate_seconds = arrived - prepared;
    power->gather_seconds = ty_wall_seconds() - arrived;
    return result;
}

int32_t ty_lattice_step_operations(int32_t bands) {
    if (bands > 2) return 3 * TY_LPV_LINKS * 2 * bands * bands;
    /* Band 0 and one component of band 1 per axis of the link, once to project and once to add. */
    return 3 * 2 * (6 * 2 + 12 * 3 + 8 * 4);
}
