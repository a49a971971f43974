#include "solve/ordinates/divided/joint_solve.h"

#include "base/arena.h"
#include "base/context.h"
#include "base/mapping.h"
#include "comm/regroup.h"

#include <string.h>

enum { TERMS_MAX = TY_SCATTERING_ORDER_MAX * TY_SCATTERING_ORDER_MAX, PLANES_MAX = 2 * TERMS_MAX + 7 };
/* Fewer cells a rank are solved faster by one. */
enum { CELLS_MIN = 512 };
/* Up to so many ranks, and down to so many rows each, the box is cut along y alone: rows are then swept both ways at
 * once. */
enum { RANKS_IN_A_ROW = 8, ROWS_MIN = 8 };

/* The first message of rank 0. Of pointers in the def only whether they are NULL has a meaning. */
typedef struct joint_head {
    ty_ordinates_def def;
    float scattered[TY_SCATTERING_ORDER_MAX];
} joint_head;

typedef struct joint_solve {
    ty_context* context;
    ty_comm* comm;
    const ty_ordinates_def* whole; /* rank 0's def, or the head's */
    bool gives;                    /* this is rank 0 */
    ty_domain domain;
    ty_ordinates_def def; /* of the part */
    size_t cells;
    float* planes[PLANES_MAX]; /* of the part, in the order of list_planes */
    float* moments[TERMS_MAX];
    ty_angular_quadrature *set, *final_set;
    float* across[3];
    ty_ordinates_faces faces; /* of the whole */
    int32_t* own_side;        /* sides of the whole that are this part's; -1 ends them */
    int32_t *first, *x;       /* of the part */
    uint8_t* face;
    float *albedo, *emission, *irradiance, *absorbed;
    double* results; /* irradiance and absorbed flux per side of the whole */
    void* memory;
    size_t bytes;
} joint_solve;

/* ---- cuts ---- */

bool ty_ordinates_cut(ty_comm* comm, const int32_t size[3], ty_domain* out) {
    static const int32_t unit[3] = {2, 2, 1}; /* of the initial guess */
    const int32_t ranks = ty_comm_size(comm);
    const bool in_a_row = ranks <= RANKS_IN_A_ROW && size[1] >= ROWS_MIN * ranks;
    if ((int64_t)size[0] * size[1] * size[2] < (int64_t)CELLS_MIN * ranks) return false;
    return ty_domain_create(comm, size, in_a_row ? TY_CUT_Y : TY_CUT_X | TY_CUT_Y, unit, 2, out);
}

const char* ty_ordinates_why_undivided(const ty_context* context, const ty_ordinates_def* def) {
    ty_work_queue* queue = ty_context_queue(context);
    ty_domain domain;
    if (queue == NULL) return "";
    const char* why = ty_ordinates_undivided(def);
    if (why != NULL) return why;
    if (!ty_ordinates_cut(ty_queue_comm(queue), def->size, &domain)) return "it has too few cells for so many ranks";
    ty_domain_destroy(&domain);
    return NULL;
}

/* ---- arrays ---- */

/* Planes of cells that a def has; a NULL out counts them. Of a def without arrays the planes are NULL. */
static int32_t list_planes(const ty_ordinates_def* def, bool has_arrays, const float** out) {
    const float* const cells[3] = {def->extinction, def->scattering, def->g};
    const float* const* const groups[3] = {def->source, def->source_center, def->start};
    const int32_t counts[3] = {def->source_terms, 4, def->bands * def->bands};
    int32_t count = 0;
    for (int i = 0; i < 3; ++i, ++count)
        if (out != NULL) out[count] = has_arrays ? cells[i] : NULL;
    for (int i = 0; i < 3; ++i)
        for (int32_t t = 0; groups[i] != NULL && t < counts[i]; ++t, ++count)
            if (out != NULL) out[count] = has_arrays ? groups[i][t] : NULL;
    return count;
}

static size_t across_floats(const ty_ordinates_def* def, int axis) {
    if (def->boundary_radiance.across[axis] == NULL) return 0;
    return (size_t)ty_boundary_patch_count(&def->boundary_radiance, axis) * (size_t)def->set->count;
}

static void lay_out_faces(joint_solve* s, ty_arena* arena) {
    const size_t sides = (size_t)s->whole->walls.count, rows = (size_t)s->def.size[1] * (size_t)s->def.size[2];
    const size_t all_rows = (size_t)s->whole->size[1] * (size_t)s->whole->size[2];
    if (sides == 0) return;
    s->faces = s->whole->walls;
    if (!s->gives) {
        s->faces.first = ty_arena_take(arena, sizeof(int32_t) * (all_rows + 1));
        s->faces.x = ty_arena_take(arena, sizeof(int32_t) * sides);
        s->faces.face = ty_arena_take(arena, sides);
        s->faces.albedo = ty_arena_take(arena, sizeof(float) * sides);
        s->faces.emission = ty_arena_take(arena, sizeof(float) * sides);
    }
    s->own_side = ty_arena_take(arena, sizeof(int32_t) * (sides + 1));
    s->first = ty_arena_take(arena, sizeof(int32_t) * (rows + 1));
    s->x = ty_arena_take(arena, sizeof(int32_t) * sides);
    s->face = ty_arena_take(arena, sides);
    s->albedo = ty_arena_take(arena, sizeof(float) * sides);
    s->emission = ty_arena_take(arena, sizeof(float) * sides);
    s->irradiance = ty_arena_take(arena, sizeof(float) * sides);
    s->absorbed = ty_arena_take(arena, sizeof(float) * sides);
    s->results = ty_arena_take(arena, sizeof(double) * 2 * sides);
}

static void lay_out(joint_solve* s, ty_arena* arena) {
    const int32_t count = list_planes(s->whole, false, NULL), kept = s->def.output_order * s->def.output_order;
    for (int32_t i = 0; i < count; ++i) s->planes[i] = ty_arena_take(arena, sizeof(float) * s->cells);
    for (int32_t t = 0; t < kept; ++t) s->moments[t] = ty_arena_take(arena, sizeof(float) * s->cells);
    lay_out_faces(s, arena);
}

/* The sets first: the size of the rest depends on them. */
static ty_result take_sets(joint_solve* s) {
    const ty_angular_quadrature* const given[2] = {s->whole->set, s->whole->final_set};
    ty_angular_quadrature** const sets[2] = {&s->set, &s->final_set};
    for (int i = 0; i < 2; ++i) {
        if (given[i] == NULL) continue;
        if (s->gives) *sets[i] = (ty_angular_quadrature*)given[i];
        if (!s->gives) *sets[i] = ty_alloc_array(s->context, 1, sizeof **sets[i], false);
        if (*sets[i] == NULL) return TY_ERROR_MEMORY;
        if (!ty_comm_broadcast(s->comm, *sets[i], sizeof **sets[i])) return TY_ERROR_INTERNAL;
    }
    s->def.set = s->set;
    s->def.final_set = s->final_set;
    return TY_OK;
}

/* Radiance from around is small, and all ranks have all of it. */
static ty_result take_boundary(joint_solve* s) {
    for (int axis = 0; axis < 3; ++axis) {
        const size_t floats = across_floats(&s->def, axis);
        if (floats == 0) continue;
        if (s->gives) s->across[axis] = (float*)s->whole->boundary_radiance.across[axis];
        if (!s->gives) s->across[axis] = ty_alloc_array(s->context, floats, sizeof(float), false);
        if (s->across[axis] == NULL) return TY_ERROR_MEMORY;
        if (!ty_comm_broadcast(s->comm, s->across[axis], floats * sizeof(float))) return TY_ERROR_INTERNAL;
    }
    for (int axis = 0; axis < 3; ++axis) s->def.boundary_radiance.across[axis] = s->across[axis];
    return TY_OK;
}

static ty_halo array_of(const int32_t size[3], const float* cells) {
    return (ty_halo){
        .origin = (void*)(uintptr_t)cells, .item = sizeof(float), .stride = {1, size[0], (ptrdiff_t)size[0] * size[1]}};
}

/* Planes of the whole may be in files, of which little is to be in memory. */
static void trim(const joint_solve* s) {
    if (ty_mappings_are_bounded(s->context)) ty_mappings_trim(s->context);
}

static bool take_planes(joint_solve* s) {
    const float* whole[PLANES_MAX];
    const int32_t count = list_planes(s->whole, s->gives, whole);
    for (int32_t i = 0; i < count; ++i) {
        const ty_halo from = array_of(s->whole->size, whole[i]), to = array_of(s->def.size, s->planes[i]);
        if (!ty_domain_regroup(s->comm, NULL, &s->domain, &from, &to)) return false;
        trim(s);
    }
    const float* const* next = (const float* const*)s->planes;
    s->def.extinction = next[0];
    s->def.scattering = next[1];
    s->def.g = next[2];
    next += 3;
    s->def.source = next;
    next += s->def.source_terms;
    if (s->whole->source_center != NULL) s->def.source_center = next;
    if (s->whole->source_center != NULL) next += 4;
    if (s->whole->start != NULL) s->def.start = next;
    return true;
}

/* All ranks have all sides for a moment, and keep those of their cells. */
static bool take_faces(joint_solve* s) {
    const int32_t *size = s->def.size, *all = s->whole->size, *begin = s->domain.first;
    const size_t sides = (size_t)s->faces.count;
    if (sides == 0) return true;
    if (!ty_comm_broadcast(s->comm, (void*)s->faces.first, sizeof(int32_t) * ((size_t)all[1] * (size_t)all[2] + 1)) ||
        !ty_comm_broadcast(s->comm, (void*)s->faces.x, sizeof(int32_t) * sides) ||
        !ty_comm_broadcast(s->comm, (void*)s->faces.face, sides) ||
        !ty_comm_broadcast(s->comm, (void*)s->faces.albedo, sizeof(float) * sides) ||
        !ty_comm_broadcast(s->comm, (void*)s->faces.emission, sizeof(float) * sides))
        return false;
    int32_t count = 0;
    for (int32_t row = 0; row < size[1] * size[2]; ++row) {
        const int32_t there = row % size[1] + begin[1] + all[1] * (row / size[1] + begin[2]);
        s->first[row] = count;
        for (int32_t i = s->faces.first[there]; i < s->faces.first[there + 1]; ++i) {
            const int32_t x = s->faces.x[i] - begin[0];
            if (x < 0 || x >= size[0]) continue;
            s->own_side[count] = i;
            s->x[count] = x;
            s->face[count] = s->faces.face[i];
            s->albedo[count] = s->faces.albedo[i];
            s->emission[count++] = s->faces.emission[i];
        }
    }
    s->first[size[1] * size[2]] = count;
    s->def.walls = (ty_ordinates_faces){.count = count,
                                        .first = s->first,
                                        .x = s->x,
                                        .face = s->face,
                                        .albedo = s->albedo,
                                        .emission = s->emission,
                                        .irradiance = s->irradiance,
                                        .absorbed = s->absorbed};
    return true;
}

/* ---- results ---- */

/* Each side's results are those of one rank, and 0 on all others. */
static bool give_faces(const joint_solve* s) {
    const int32_t count = s->faces.count, own = s->def.walls.count;
    if (count == 0) return true;
    memset(s->results, 0, sizeof *s->results * 2 * (size_t)count);
    for (int32_t i = 0; i < own; ++i) {
        s->results[s->own_side[i]] = (double)s->irradiance[i];
        s->results[count + s->own_side[i]] = (double)s->absorbed[i];
    }
    if (!ty_comm_sum(s->comm, s->results, 2 * count)) return false;
    for (int32_t i = 0; s->gives && i < count; ++i) {
        if (s->faces.irradiance != NULL) s->faces.irradiance[i] = (float)s->results[i];
        if (s->faces.absorbed != NULL) s->faces.absorbed[i] = (float)s->results[count + i];
    }
    return true;
}

static bool give_moments(const joint_solve* s, float* const* moments) {
    for (int32_t t = 0; t < s->def.output_order * s->def.output_order; ++t) {
        const ty_halo from = array_of(s->def.size, s->moments[t]),
                      to = array_of(s->whole->size, s->gives ? moments[t] : NULL);
        if (!ty_domain_regroup(s->comm, &s->domain, NULL, &from, &to)) return false;
        trim(s);
    }
    /* No cell of a divided solve is diffusive. */
    const size_t cells = (size_t)s->whole->size[0] * (size_t)s->whole->size[1] * (size_t)s->whole->size[2];
    for (size_t i = 0; s->gives && s->whole->face_fluence != NULL && i < 6 * cells; ++i) s->whole->face_fluence[i] = -1;
    return true;
}

/* ---- solve ---- */

/* The same result on all ranks: an error where one has one. */
static ty_result agree(const joint_solve* s, ty_result result) {
    double failures = result == TY_OK ? 0 : 1;
    if (!ty_comm_sum(s->comm, &failures, 1)) return TY_ERROR_INTERNAL;
    return result != TY_OK || failures <= 0 ? result : TY_ERROR_MEMORY;
}

static ty_result begin(joint_solve* s, const float* scattered) {
    if (!ty_ordinates_cut(s->comm, s->whole->size, &s->domain)) return TY_ERROR_INTERNAL;
    s->def = *s->whole;
    for (int a = 0; a < 3; ++a) s->def.size[a] = s->domain.end[a] - s->domain.first[a];
    s->cells = (size_t)s->def.size[0] * (size_t)s->def.size[1] * (size_t)s->def.size[2];
    s->def.domain = &s->domain;
    s->def.memory = NULL;
    s->def.face_fluence = s->def.face_incident = NULL;
    s->def.progress = s->gives ? s->whole->progress : NULL;
    if (s->whole->scattered != NULL) s->def.scattered = scattered;
    ty_arena arena = {0};
    lay_out(s, &arena);
    s->bytes = arena.used;
    arena.base = s->memory = ty_alloc_array(s->context, s->bytes, 1, false);
    arena.used = 0;
    if (s->memory != NULL) lay_out(s, &arena);
    return agree(s, s->memory != NULL ? TY_OK : TY_ERROR_MEMORY);
}

static void end(joint_solve* s) {
    if (s->memory != NULL) ty_free_array(s->context, s->memory, s->bytes, 1);
    ty_domain_destroy(&s->domain);
    if (s->gives) return;
    for (int axis = 0; axis < 3; ++axis)
        ty_free_array(s->context, s->across[axis], s->across[axis] != NULL ? across_floats(&s->def, axis) : 0,
                      sizeof(float));
    ty_free_array(s->context, s->set, 1, sizeof *s->set);
    ty_free_array(s->context, s->final_set, 1, sizeof *s->final_set);
}

static ty_result run(joint_solve* s, const float* scattered, float* const* moments, ty_ordinates_stats* stats) {
    ty_result result = begin(s, scattered);
    if (result == TY_OK) result = agree(s, take_sets(s));
    if (result == TY_OK) result = agree(s, take_boundary(s));
    if (result == TY_OK && !(take_planes(s) && take_faces(s))) result = TY_ERROR_INTERNAL;
    if (result == TY_OK) result = ty_ordinates_solve(s->context, &s->def, s->moments, NULL, 0, stats);
    if (result == TY_OK && !(give_moments(s, moments) && give_faces(s))) result = TY_ERROR_INTERNAL;
    if (result == TY_ERROR_INTERNAL && s->gives)
        ty_fail(s->context, TY_ERROR_INTERNAL, "ordinates: rank %d does not answer", (int)ty_comm_lost(s->comm));
    end(s);
    return result;
}

ty_result ty_ordinates_solve_jointly(ty_context* context, const ty_ordinates_def* def, float* const* moments,
                                     ty_ordinates_stats* stats) {
    joint_head head = {.def = *def};
    if (def->scattered != NULL) memcpy(head.scattered, def->scattered, sizeof(float) * (size_t)def->bands);
    ty_comm* comm = NULL;
    if (ty_ordinates_why_undivided(context, def) == NULL)
        comm = ty_joint_begin(ty_context_queue(context), TY_JOINT_ORDINATES, &head, sizeof head);
    if (comm == NULL) return ty_ordinates_solve(context, def, moments, NULL, 0, stats);
    joint_solve s = {.context = context, .comm = comm, .whole = def, .gives = true};
    return run(&s, head.scattered, moments, stats);
}

void ty_ordinates_join(ty_context* context, ty_comm* comm, const uint8_t* bytes, size_t size) {
    joint_head head;
    ty_ordinates_stats stats;
    if (size != sizeof head) return;
    memcpy(&head, bytes, sizeof head);
    joint_solve s = {.context = context, .comm = comm, .whole = &head.def};
    if (run(&s, head.scattered, NULL, &stats) != TY_OK) ty_take_error(context);
}
