#include "solve/diffusion/divided/joint_faces.h"

#include "base/context.h"

#include <string.h>

enum { FIRST, X, FACE, ALBEDO, STAIRCASE, RADIOSITY, CLOSED, FLUX, IRRADIANCE };
enum { INPUTS = CLOSED + 1 };

/* ---- boxes ---- */

/* The cells of a rank's box. */
typedef struct rank_box {
    int32_t first[3], end[3];
    size_t rows, cells;
} rank_box;

static rank_box box_of(const ty_domain* domain, int32_t rank) {
    rank_box b;
    int32_t at[3];
    ty_domain_place(domain, rank, at);
    for (int a = 0; a < 3; ++a) {
        b.first[a] = ty_domain_first(domain, a, at[a]);
        b.end[a] = ty_domain_first(domain, a, at[a] + 1);
    }
    b.rows = (size_t)(b.end[1] - b.first[1]) * (size_t)(b.end[2] - b.first[2]);
    b.cells = b.rows * (size_t)(b.end[0] - b.first[0]);
    return b;
}

/* Bytes of an array of so many sides. */
static size_t array_bytes(const ty_joint_faces* part, int array, const rank_box* box, int32_t sides) {
    switch (array) {
    case FIRST: return sizeof(int32_t) * (box->rows + 1);
    case X: return sizeof(int32_t) * (size_t)sides;
    case FACE: return (size_t)sides;
    case RADIOSITY: return part->has_radiosity ? sizeof(float) * (size_t)sides : 0;
    case CLOSED: return box->cells;
    default: return sizeof(float) * (size_t)sides;
    }
}

/* Bytes that an array takes on any rank. */
static size_t max_bytes(const ty_joint_faces* part, int array) {
    size_t max = 1;
    for (int32_t r = 0; r < ty_comm_size(part->domain->comm); ++r) {
        const rank_box box = box_of(part->domain, r);
        const size_t bytes = array_bytes(part, array, &box, part->max_sides);
        max = bytes > max ? bytes : max;
    }
    return max;
}

/* The row of the grid that is row i of a box; rows along x are whole. */
static size_t row_of(const ty_domain* domain, const rank_box* box, size_t i) {
    const size_t height = (size_t)(box->end[1] - box->first[1]);
    return ((size_t)box->first[2] + i / height) * (size_t)domain->cells[1] + (size_t)box->first[1] + i % height;
}

static int32_t count_sides(const ty_joint_faces* part, const rank_box* box) {
    int32_t count = 0;
    for (size_t i = 0; i < box->rows; ++i) {
        const int32_t* first = part->whole->first + row_of(part->domain, box, i);
        count += first[1] - first[0];
    }
    return count;
}

/* Copies the sides of a box out of those of the grid. */
static void fill(const ty_joint_faces* part, const rank_box* box, void* const arrays[TY_SIDE_ARRAYS]) {
    const ty_diffusion_faces* whole = part->whole;
    const size_t nx = (size_t)part->domain->cells[0];
    int32_t* starts = arrays[FIRST];
    size_t count = 0;
    for (size_t i = 0; i < box->rows; ++i) {
        const size_t row = row_of(part->domain, box, i), begin = (size_t)whole->first[row],
                     sides = (size_t)whole->first[row + 1] - begin;
        starts[i] = (int32_t)count;
        memcpy((int32_t*)arrays[X] + count, whole->x + begin, sizeof(int32_t) * sides);
        memcpy((uint8_t*)arrays[FACE] + count, whole->face + begin, sides);
        memcpy((float*)arrays[ALBEDO] + count, whole->albedo + begin, sizeof(float) * sides);
        memcpy((float*)arrays[STAIRCASE] + count, whole->staircase + begin, sizeof(float) * sides);
        if (part->has_radiosity)
            memcpy((float*)arrays[RADIOSITY] + count, whole->radiosity + begin, sizeof(float) * sides);
        memcpy((uint8_t*)arrays[CLOSED] + i * nx, whole->closed + row * nx, nx);
        count += sides;
    }
    starts[box->rows] = (int32_t)count;
}

/* ---- calls ---- */

static bool allocate(ty_joint_faces* part, void* arrays[TY_SIDE_ARRAYS]) {
    bool complete = true;
    for (int array = 0; array < TY_SIDE_ARRAYS; ++array) {
        arrays[array] = ty_alloc_array(part->context, max_bytes(part, array), 1, false);
        complete = complete && arrays[array] != NULL;
    }
    return complete;
}

static void use(ty_joint_faces* part, int32_t own) {
    part->faces = (ty_diffusion_faces){.count = part->counts[own],
                                       .first = part->own[FIRST],
                                       .x = part->own[X],
                                       .face = part->own[FACE],
                                       .closed = part->own[CLOSED],
                                       .albedo = part->own[ALBEDO],
                                       .radiosity = part->has_radiosity ? part->own[RADIOSITY] : NULL,
                                       .staircase = part->own[STAIRCASE]};
    part->flux = part->own[FLUX];
    part->irradiance = part->own[IRRADIANCE];
}

ty_result ty_joint_faces_take(ty_joint_faces* part) {
    ty_comm* comm = part->domain->comm;
    const int32_t ranks = ty_comm_size(comm), own = ty_comm_rank(comm);
    part->counts = ty_alloc_array(part->context, (size_t)ranks, sizeof(int32_t), true);
    double missing = part->counts == NULL ? 1 : 0;
    ty_comm_max(comm, &missing, 1);
    if (missing > 0) return TY_ERROR_MEMORY;
    for (int32_t r = 0; own == 0 && r < ranks; ++r) {
        const rank_box box = box_of(part->domain, r);
        part->counts[r] = count_sides(part, &box);
    }
    if (!ty_comm_broadcast(comm, part->counts, sizeof(int32_t) * (size_t)ranks)) return TY_ERROR_UNSUPPORTED;
    for (int32_t r = 0; r < ranks; ++r)
        part->max_sides = part->counts[r] > part->max_sides ? part->counts[r] : part->max_sides;
    missing = allocate(part, part->own) && (own > 0 || allocate(part, part->other)) ? 0 : 1;
    ty_comm_max(comm, &missing, 1);
    if (missing > 0) return TY_ERROR_MEMORY;
    for (int32_t r = 0; r < ranks; ++r) {
        const rank_box box = box_of(part->domain, r);
        if (own == 0) fill(part, &box, r == 0 ? part->own : part->other);
        for (int array = 0; array < INPUTS && r > 0 && (own == 0 || own == r); ++array)
            if (!ty_comm_move(comm, own == 0 ? r : 0, own > 0, own == 0 ? part->other[array] : part->own[array],
                              array_bytes(part, array, &box, part->counts[r])))
                return TY_ERROR_UNSUPPORTED;
    }
    use(part, own);
    return TY_OK;
}

/* Copies a result of a box's sides to those of the grid. */
static void scatter(const ty_joint_faces* part, const rank_box* box, const float* sides, float* out) {
    for (size_t i = 0; i < box->rows && out != NULL; ++i) {
        const int32_t* first = part->whole->first + row_of(part->domain, box, i);
        memcpy(out + first[0], sides, sizeof(float) * (size_t)(first[1] - first[0]));
        sides += first[1] - first[0];
    }
}

bool ty_joint_faces_give(const ty_joint_faces* part, float* flux, float* irradiance) {
    ty_comm* comm = part->domain->comm;
    const int32_t own = ty_comm_rank(comm);
    float* const outs[2] = {flux, irradiance};
    for (int32_t r = 0; r < ty_comm_size(comm); ++r) {
        const rank_box box = box_of(part->domain, r);
        for (int i = 0; i < 2 && (own == 0 || own == r); ++i) {
            float* sides = own == 0 && r > 0 ? part->other[FLUX + i] : part->own[FLUX + i];
            if (r > 0 && !ty_comm_move(comm, own == 0 ? r : 0, own == 0, sides,
                                       array_bytes(part, FLUX + i, &box, part->counts[r])))
                return false;
            if (own == 0) scatter(part, &box, sides, outs[i]);
        }
    }
    return true;
}

void ty_joint_faces_free(ty_joint_faces* part) {
    if (part->counts == NULL) return;
    for (int array = 0; array < TY_SIDE_ARRAYS; ++array) {
        const size_t bytes = max_bytes(part, array);
        ty_free_array(part->context, part->own[array], bytes, 1);
        ty_free_array(part->context, part->other[array], bytes, 1);
    }
    ty_free_array(part->context, part->counts, (size_t)ty_comm_size(part->domain->comm), sizeof(int32_t));
}
