/* Packing lattices. */
#include "method/lpv/look.h"

#include "base/context.h"

typedef struct pack_job {
    const ty_lattice* lattice;
    ty_look_lattice* look;
    float* light;
    uint8_t *closed, *near; /* NULL: everything is open */
} pack_job;

static size_t cell_count(const ty_look_lattice* lattice) {
    return (size_t)lattice->size[0] * (size_t)lattice->size[1] * (size_t)lattice->size[2];
}

static void pack_light(const pack_job* job, size_t cell) {
    const ty_lattice* lattice = job->lattice;
    float* to = job->light + cell * (size_t)job->look->floats;
    memset(to, 0, (size_t)job->look->floats * sizeof *to);
    for (int c = 0; c < 3; ++c)
        for (int32_t t = 0; t < lattice->terms; ++t)
            to[t < 4 ? 4 * c + t : TY_LOOK_FLOATS + 5 * c + t - 4] = lattice->light[c][t][cell];
}

/* What counts of a neighbour is what gets from there into the cell. */
static void pack_links(const pack_job* job, size_t cell) {
    uint8_t* near = job->near + cell * TY_LOOK_NEAR;
    uint8_t least = UINT8_MAX;
    near[TY_LOOK_SELF] = UINT8_MAX;
    for (int32_t i = 0; i < 2 * TY_LOOK_SELF + 1; ++i) {
        if (i == TY_LOOK_SELF) continue;
        near[i] = job->lattice->open[ty_lpv_link(1 - i % 3, 1 - i / 3 % 3, 1 - i / 9)][cell];
        least = near[i] < least ? near[i] : least;
    }
    job->closed[cell] = least < UINT8_MAX;
}

static void pack_plane(void* user, int64_t z, int32_t worker) {
    (void)worker;
    const pack_job* job = user;
    const size_t plane = (size_t)job->look->size[0] * (size_t)job->look->size[1];
    for (size_t cell = (size_t)z * plane; cell < (size_t)(z + 1) * plane; ++cell) {
        pack_light(job, cell);
        if (job->near != NULL) pack_links(job, cell);
    }
}

static ty_result pack(ty_context* context, const ty_lattice* lattice, ty_look_lattice* look) {
    const ty_grid_box* box = &lattice->box;
    memcpy(look->size, box->size, sizeof look->size);
    look->floats = lattice->terms > 4 ? TY_LOOK_FLOATS_MAX : TY_LOOK_FLOATS;
    look->fronts = lattice->fronts;
    look->front = lattice->front;
    look->cell = lattice->cell;
    look->per_metre = 1.0f / lattice->cell;
    look->lower = ty_vec_make((float)box->lower[0], (float)box->lower[1], (float)box->lower[2]);
    look->upper = ty_vec_make((float)box->upper[0], (float)box->upper[1], (float)box->upper[2]);
    const size_t cells = cell_count(look);
    pack_job job = {.lattice = lattice, .look = look};
    look->light = job.light = ty_alloc_array(context, cells * (size_t)look->floats, sizeof(float), false);
    if (job.light == NULL) return TY_ERROR_MEMORY;
    if (lattice->blocked) {
        look->closed = job.closed = ty_alloc_array(context, cells, 1, false);
        look->near = job.near = ty_alloc_array(context, cells, TY_LOOK_NEAR, true);
        if (job.closed == NULL || job.near == NULL) return TY_ERROR_MEMORY;
    }
    ty_parallel_for(context, look->size[2], pack_plane, &job);
    return TY_OK;
}

ty_result ty_look_begin(ty_context* context, ty_lattice* const* lattices, int32_t count, ty_lattice_look* out) {
    *out = (ty_lattice_look){0};
    ty_result result = TY_OK;
    while (out->count < count && result == TY_OK) {
        ty_look_lattice* look = &out->lattices[out->count];
        result = pack(context, lattices[out->count++], look);
    }
    return result;
}

void ty_look_end(ty_context* context, ty_lattice_look* look) {
    for (int32_t i = 0; i < look->count; ++i) {
        ty_look_lattice* lattice = &look->lattices[i];
        const size_t cells = cell_count(lattice);
        ty_free_array(context, (void*)lattice->light, cells * (size_t)lattice->floats, sizeof(float));
        ty_free_array(context, (void*)lattice->closed, cells, 1);
        ty_free_array(context, (void*)lattice->near, cells, TY_LOOK_NEAR);
    }
}
