#include "solve/diffusion/divided/joint.h"

#include "base/context.h"
#include "solve/diffusion/divided/joint_faces.h"

#include <stdlib.h>
#include <string.h>

/* Arrays of a box: coefficients, what the solve starts from, values of the sides, and results. */
enum {
    EXTINCTION,
    ABSORPTION,
    SOURCE,
    START,
    SIDES,
    INPUTS = SIDES + 6,
    FLUENCE = INPUTS,
    DIFFUSIVITY,
    FLUX,
    ARRAYS = FLUX + 3
};

/* The message that describes a solve; its pointers only tell which arrays there are. */
typedef struct joint_head {
    ty_diffusion_def def;
    bool has[ARRAYS];
    bool has_faces, has_radiosity;
} joint_head;

/* Rows of items of one array, of the whole grid or of a box: cells, faces along an axis, or those of a side. */
typedef struct rows {
    int32_t first[3], end[3]; /* of a rank, in the grid */
    int32_t items[3];         /* of the grid */
} rows;

/* ---- boxes ---- */

/* The items of an array that a rank has. */
static rows rows_of(const ty_domain* domain, int array, int32_t rank) {
    rows r;
    int32_t at[3];
    ty_domain_place(domain, rank, at);
    for (int a = 0; a < 3; ++a) {
        r.items[a] = domain->cells[a] + (array == FLUX + a ? 1 : 0);
        r.first[a] = ty_domain_first(domain, a, at[a]);
        r.end[a] = ty_domain_first(domain, a, at[a] + 1) + (array == FLUX + a ? 1 : 0);
    }
    if (array >= SIDES && array < INPUTS) {
        const int axis = (array - SIDES) / 2;
        r.items[axis] = r.end[axis] = 1;
        r.first[axis] = 0;
    }
    return r;
}

static size_t count_items(const rows* r) {
    size_t items = 1;
    for (int a = 0; a < 3; ++a) items *= (size_t)(r->end[a] - r->first[a]);
    return items;
}

/* Copies items between the grid and a box. */
static void copy_rows(const rows* r, float* whole, float* box, bool out) {
    const size_t items = (size_t)(r->end[0] - r->first[0]);
    for (int32_t z = r->first[2]; z < r->end[2]; ++z)
        for (int32_t y = r->first[1]; y < r->end[1]; ++y, box += items) {
            float* row = whole + ((size_t)z * (size_t)r->items[1] + (size_t)y) * (size_t)r->items[0] + r->first[0];
            memcpy(out ? row : box, out ? box : row, sizeof(float) * items);
        }
}

/* ---- a rank's part ---- */

typedef struct part {
    ty_context* context;
    ty_domain domain;
    joint_head head;
    float* arrays[ARRAYS];
    float* message; /* on rank 0: the largest box of another rank */
    ty_joint_faces faces;
} part;

static size_t items_of(const part* p, int array, int32_t rank) {
    const rows r = rows_of(&p->domain, array, rank);
    return count_items(&r);
}

static bool allocate(part* p) {
    bool complete = true;
    size_t largest = 0;
    for (int array = 0; array < ARRAYS; ++array) {
        if (!p->head.has[array]) continue;
        const size_t items = items_of(p, array, ty_comm_rank(p->domain.comm));
        p->arrays[array] = ty_alloc_array(p->context, items, sizeof(float), false);
        complete = complete && p->arrays[array] != NULL;
        for (int32_t r = 1; r < ty_comm_size(p->domain.comm); ++r) {
            const size_t others = items_of(p, array, r);
            largest = others > largest ? others : largest;
        }
    }
    if (ty_comm_rank(p->domain.comm) == 0) p->message = malloc(sizeof(float) * largest);
    return complete && (p->message != NULL || ty_comm_rank(p->domain.comm) > 0);
}

static void free_part(part* p) {
    for (int array = 0; array < ARRAYS; ++array)
        if (p->arrays[array] != NULL)
            ty_free_array(p->context, p->arrays[array], items_of(p, array, ty_comm_rank(p->domain.comm)),
                          sizeof(float));
    free(p->message);
    ty_joint_faces_free(&p->faces);
    ty_domain_destroy(&p->domain);
}

/* Moves an array between the grid of rank 0 and the boxes of all; whole: on rank 0. */
static void move_array(part* p, int array, float* whole, bool to_boxes) {
    ty_comm* comm = p->domain.comm;
    if (ty_comm_rank(comm) > 0) {
        ty_comm_move(comm, 0, to_boxes, p->arrays[array], sizeof(float) * items_of(p, array, ty_comm_rank(comm)));
        return;
    }
    for (int32_t r = 0; r < ty_comm_size(comm); ++r) {
        const rows own = rows_of(&p->domain, array, r);
        float* box = r == 0 ? p->arrays[array] : p->message;
        if (to_boxes) copy_rows(&own, whole, box, false);
        if (r > 0) ty_comm_move(comm, r, !to_boxes, box, sizeof(float) * count_items(&own));
        if (!to_boxes && ty_comm_lost(comm) < 0) copy_rows(&own, whole, box, true);
    }
}

static ty_result solve_part(part* p, ty_diffusion_stats* stats) {
    ty_diffusion_def def = p->head.def;
    for (int a = 0; a < 3; ++a) def.size[a] = p->domain.end[a] - p->domain.first[a];
    def.extinction = p->arrays[EXTINCTION];
    def.absorption = p->arrays[ABSORPTION];
    def.source = p->arrays[SOURCE];
    def.start = p->arrays[START];
    for (int side = 0; side < 6; ++side) def.boundary[side].value = p->arrays[SIDES + side];
    def.domain = &p->domain;
    def.memory = NULL;
    def.faces = p->head.has_faces ? &p->faces.faces : NULL;
    const ty_diffusion_out out = {.side_flux = p->faces.flux,
                                  .side_irradiance = p->faces.irradiance,
                                  .fluence = p->arrays[FLUENCE],
                                  .diffusivity = p->arrays[DIFFUSIVITY],
                                  .flux = {p->arrays[FLUX], p->arrays[FLUX + 1], p->arrays[FLUX + 2]}};
    return ty_diffusion_solve(p->context, &def, &out, stats);
}

/* On all ranks, with the arrays of the whole grid, its surfaces and the place of their results on rank 0. */
static ty_result solve_together(part* p, float* const whole[ARRAYS], const ty_diffusion_faces* faces,
                                const ty_diffusion_out* out, ty_diffusion_stats* stats) {
    double status = allocate(p) ? 0 : 1;
    ty_comm_max(p->domain.comm, &status, 1);
    ty_result result = status > 0 ? TY_ERROR_MEMORY : TY_OK;
    for (int array = 0; array < INPUTS && result == TY_OK; ++array)
        if (p->head.has[array]) move_array(p, array, whole[array], true);
    p->faces = (ty_joint_faces){
        .context = p->context, .domain = &p->domain, .whole = faces, .has_radiosity = p->head.has_radiosity};
    if (result == TY_OK && p->head.has_faces) result = ty_joint_faces_take(&p->faces);
    if (result == TY_OK) result = solve_part(p, stats);
    for (int array = INPUTS; array < ARRAYS && (result == TY_OK || result == TY_CANCELLED); ++array)
        if (p->head.has[array]) move_array(p, array, whole[array], false);
    if ((result == TY_OK || result == TY_CANCELLED) && p->head.has_faces)
        ty_joint_faces_give(&p->faces, out->side_flux, out->side_irradiance);
    const int32_t lost = ty_comm_lost(p->domain.comm);
    return result != TY_CANCELLED && result != TY_ERROR_MEMORY && lost >= 0
               ? ty_fail(p->context, TY_ERROR_UNSUPPORTED, "rank %d does not answer", (int)lost)
               : result;
}

/* ---- rank 0 ---- */

bool ty_diffusion_is_joint(const ty_context* context, const ty_diffusion_def* def, const char** why) {
    ty_work_queue* queue = ty_context_queue(context);
    ty_domain domain;
    const char* because = NULL;
    const bool others = queue != NULL && ty_queue_ranks(queue) > 1;
    if ((int64_t)def->size[0] * def->size[1] * def->size[2] < TY_DIFFUSION_JOINT_CELLS)
        because = "there are too few cells to divide";
    else if (others && !ty_diffusion_divide(ty_queue_comm(queue), def, &domain))
        because = "there are too few cells to divide among so many ranks";
    if (why != NULL) *why = others ? because : NULL;
    return others && because == NULL;
}

ty_result ty_diffusion_solve_jointly(ty_context* context, const ty_diffusion_def* def, const ty_diffusion_out* out,
                                     ty_diffusion_stats* stats) {
    if (!ty_diffusion_is_joint(context, def, NULL)) return ty_diffusion_solve(context, def, out, stats);
    part p = {.context = context, .head = {.def = *def}};
    float* whole[ARRAYS] = {(float*)(uintptr_t)def->extinction, (float*)(uintptr_t)def->absorption,
                            (float*)(uintptr_t)def->source, (float*)(uintptr_t)def->start};
    for (int side = 0; side < 6; ++side) whole[SIDES + side] = (float*)(uintptr_t)def->boundary[side].value;
    whole[FLUENCE] = out->fluence;
    whole[DIFFUSIVITY] = out->diffusivity;
    for (int a = 0; a < 3; ++a) whole[FLUX + a] = out->flux[a];
    for (int array = 0; array < ARRAYS; ++array) p.head.has[array] = whole[array] != NULL;
    p.head.has_faces = def->faces != NULL;
    p.head.has_radiosity = def->faces != NULL && def->faces->radiosity != NULL;
    ty_comm* comm = ty_joint_begin(ty_context_queue(context), TY_JOINT_DIFFUSION, &p.head, sizeof p.head);
    if (comm == NULL || !ty_diffusion_divide(comm, def, &p.domain)) return ty_diffusion_solve(context, def, out, stats);
    const ty_result result = solve_together(&p, whole, def->faces, out, stats);
    free_part(&p);
    return result;
}

/* ---- the others ---- */

void ty_diffusion_take_part(ty_comm* comm, ty_context* context, const uint8_t* bytes, size_t size) {
    float* const none[ARRAYS] = {NULL};
    const ty_diffusion_out out = {.fluence = NULL};
    ty_diffusion_stats stats;
    part p = {.context = context};
    if (size != sizeof p.head) return;
    memcpy(&p.head, bytes, sizeof p.head);
    p.head.def.progress = NULL;
    if (!ty_diffusion_divide(comm, &p.head.def, &p.domain)) return;
    solve_together(&p, none, NULL, &out, &stats);
    free_part(&p);
}
