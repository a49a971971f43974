#include "solve/ordinates/divided/plan.h"

#include "base/context.h"
#include "comm/regroup.h"
#include "solve/ordinates/job.h"
#include "solve/ordinates/divided/joint_solve.h"

/* ---- a part ---- */

static ty_diffusion_def diffusion_of(const ty_ordinates_def* part) {
    ty_diffusion_def def = ty_default_diffusion_def();
    for (int axis = 0; axis < 3; ++axis) {
        def.size[axis] = part->size[axis];
        def.cell[axis] = part->cell[axis];
    }
    return def;
}

/* Cells of the part's sides beside cuts, of a rank that has neighbours on all sides along an axis that is cut. */
static double side_cells(const ty_ordinates_def* part, int axis) {
    return (double)part->size[1 - axis] * (double)part->size[2];
}

static double solve_bytes(ty_context* context, const ty_ordinates_def* part, ty_sweep_schedule* schedule) {
    const ty_diffusion_def diffusion = diffusion_of(part);
    double bytes = (double)ty_ordinates_memory(part);
    bytes += (double)ty_sweep_plan(context, part->size, part->set, part->bands, part->domain, schedule);
    if (part->accelerated) bytes += (double)ty_dsa_plan(context, &diffusion, &part->walls, part->domain);
    for (int side = 0; side < 4; ++side)
        if (!ty_ordinates_ends(part, side)) bytes += 2 * sizeof(float) * side_cells(part, side / 2);
    return bytes;
}

/* Messages of a rank in the middle: each unit's faces go to one neighbour along each axis that is cut. */
static void plan_messages(const ty_ordinates_def* part, ty_ordinates_plan* plan) {
    for (int axis = 0; axis < 2; ++axis) {
        if (plan->ranks[axis] == 1) continue;
        plan->messages += plan->units;
        plan->message_bytes += sizeof(float) * side_cells(part, axis) * (double)part->set->count;
    }
}

static double acceleration_bytes(const ty_ordinates_def* whole, const ty_domain* domain, ty_comm* comm) {
    const ty_diffusion_def diffusion = diffusion_of(whole);
    ty_domain solver;
    if (!whole->accelerated) return 0;
    const bool divided = ty_diffusion_divide(comm, &diffusion, &solver);
    const uint64_t cells = ty_domain_regroup_bytes(ty_comm_size(comm), domain, divided ? &solver : NULL);
    if (divided) ty_domain_destroy(&solver);
    return 2 * sizeof(float) * (double)cells;
}

static ty_result plan_parts(ty_context* context, const ty_ordinates_def* whole, ty_comm* comm,
                            ty_ordinates_plan* plan) {
    ty_domain domain;
    if (!ty_ordinates_cut(comm, whole->size, &domain))
        return ty_fail(context, TY_ERROR_ARGUMENT, "ordinates: there are too few cells for %d ranks",
                       (int)ty_comm_size(comm));
    ty_ordinates_def part = *whole;
    const double floats = 3 + whole->source_terms + whole->output_order * whole->output_order;
    double cells = 1, all = 1;
    for (int axis = 0; axis < 3; ++axis) {
        part.size[axis] = plan->part[axis] = domain.end[axis] - domain.first[axis];
        cells *= part.size[axis];
        all *= whole->size[axis];
    }
    part.domain = comm != NULL ? &domain : NULL;
    ty_sweep_schedule schedule;
    plan->arrays = sizeof(float) * floats * cells;
    plan->whole = sizeof(float) * floats * all;
    plan->solve = solve_bytes(context, &part, &schedule);
    ty_result result = TY_OK;
    for (int axis = 0; axis < 2; ++axis) plan->ranks[axis] = domain.ranks[axis];
    plan->units = schedule.count;
    if (part.domain != NULL) {
        result = ty_sweep_schedule_make(context, domain.ranks, domain.at, &schedule);
        plan->stages = (int32_t)schedule.stages;
        ty_sweep_schedule_free(context, &schedule);
        plan_messages(&part, plan);
        plan->cell_bytes = acceleration_bytes(whole, &domain, comm);
    }
    ty_domain_destroy(&domain);
    return result;
}

ty_result ty_ordinates_plan_ranks(ty_context* context, const ty_ordinates_def* whole, int32_t ranks,
                                  ty_ordinates_plan* out) {
    ty_comm* comm = ty_comm_plan(ranks);
    *out = (ty_ordinates_plan){.ranks = {1, 1}};
    if (ranks > 1 && comm == NULL) return TY_ERROR_MEMORY;
    const ty_result result = plan_parts(context, whole, comm, out);
    ty_comm_close(comm, true, 0);
    return result;
}

int32_t ty_ordinates_stages_kba(const ty_ordinates_plan* plan) {
    return plan->units + 4 * (plan->ranks[0] - 1 + plan->ranks[1] - 1);
}
