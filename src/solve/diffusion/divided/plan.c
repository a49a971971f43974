#include "solve/diffusion/divided/plan.h"

#include "base/context.h"
#include "solve/diffusion/divided/divided.h"

/* Exchanges of a layer on a visit of a divided level: after each colour of a sweep before and two after the correction
 * from the coarser level, and after the correction itself. */
enum { EXCHANGES = 7 };
/* Arrays of cells: extinction, absorption, source and fluence; and of faces: the fluxes. */
enum { CELL_ARRAYS = 4, FACE_ARRAYS = 3 };

static double count_cells(const int32_t size[3]) {
    return (double)size[0] * size[1] * size[2];
}

static double array_bytes(const int32_t size[3]) {
    double items = CELL_ARRAYS * count_cells(size);
    for (int a = 0; a < FACE_ARRAYS; ++a) items += count_cells(size) / size[a] * (size[a] + 1);
    return sizeof(float) * items;
}

/* Layers of a divided level. */
static void plan_layers(const ty_domain* domain, const ty_box* box, double visits, ty_diffusion_plan* plan) {
    for (int a = 0; a < 3; ++a) {
        if (!ty_domain_is_cut(domain, a)) continue;
        const double layers = EXCHANGES * visits * (domain->ranks[a] > 2 ? 2 : 1);
        plan->messages += layers;
        plan->halo_bytes += layers * sizeof(float) * (double)ty_box_cells(box) / box->size[a];
    }
}

/* A visit of the last divided level gathers the next one in steps, of which each doubles what a rank has. */
static void plan_gathering(const ty_domain* domain, const ty_box* box, double visits, ty_diffusion_plan* plan) {
    const int32_t ranks = ty_comm_size(domain->comm);
    for (int32_t had = 1; had < ranks; had *= 2) plan->messages += visits;
    plan->gather_bytes = visits * sizeof(float) * (double)ty_box_cells(box) * (1 - 1.0 / ranks);
}

/* A cycle visits level i 2^i times. */
static void plan_cycle(const ty_diffusion_job* job, const ty_domain* domain, ty_diffusion_plan* plan) {
    double visits = 1;
    for (int32_t i = 0; i < job->level_count; ++i, visits *= 2) {
        const ty_box* box = &job->levels[i].box;
        plan->cells += visits * (double)ty_box_cells(box);
        if (i < job->divided) plan_layers(domain, box, visits, plan);
        if (i + 1 == job->divided) plan_gathering(domain, &job->levels[i + 1].box, visits, plan);
    }
}

static ty_result plan_part(ty_context* context, const ty_diffusion_def* whole, ty_comm* comm, ty_diffusion_plan* plan) {
    ty_domain domain;
    ty_diffusion_def part = *whole;
    if (!ty_diffusion_divide(comm, whole, &domain))
        return ty_fail(context, TY_ERROR_ARGUMENT, "diffusion: %d x %d x %d cells are too few for %d ranks",
                       (int)whole->size[0], (int)whole->size[1], (int)whole->size[2], (int)ty_comm_size(comm));
    for (int a = 0; a < 3; ++a) {
        part.size[a] = plan->part[a] = domain.end[a] - domain.first[a];
        plan->ranks[a] = domain.ranks[a];
    }
    part.domain = &domain;
    ty_diffusion_job job = {.def = &part};
    ty_arena arena = {0};
    ty_solve_lay_out(&job, &arena);
    plan->solve = (double)arena.used;
    plan->levels = job.divided;
    plan->arrays = array_bytes(plan->part);
    plan->whole = array_bytes(whole->size);
    plan_cycle(&job, &domain, plan);
    ty_domain_destroy(&domain);
    return TY_OK;
}

ty_result ty_diffusion_plan_ranks(ty_context* context, const ty_diffusion_def* whole, int32_t ranks,
                                  ty_diffusion_plan* out) {
    ty_comm* comm = ty_comm_plan(ranks);
    *out = (ty_diffusion_plan){.ranks = {1, 1, 1}};
    if (ranks > 1 && comm == NULL) return TY_ERROR_MEMORY;
    const ty_result result = plan_part(context, whole, comm, out);
    ty_comm_close(comm, true, 0);
    return result;
}
