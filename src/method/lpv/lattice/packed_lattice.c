/* Packing lattices for lookups. */
#include "method/lpv/lattice/packed_lattice.h"

#include "base/context.h"
#include "scene/media/phase.k.h"

typedef struct pack_job {
    const ty_lattice* lattice;
    ty_packed_lattice* packed;
    const ty_vec* eye; /* NULL: propagated light */
    float* light;
    uint8_t *blocked, *links; /* NULL: no blockers */
} pack_job;

static size_t cell_count(const ty_packed_lattice* lattice) {
    return (size_t)lattice->size[0] * (size_t)lattice->size[1] * (size_t)lattice->size[2];
}

/* The radiance that a cell scatters out of its beam in a direction per scattering coefficient: by Henyey-Greenstein of
 * the product of the mean cosines, which is exact in two moments. */
static float scattered_beam(const ty_lattice* lattice, int c, size_t cell, ty_vec to_eye, float distance2) {
    float* const* beam = lattice->beam[c];
    const ty_vec flux = ty_vec_make(beam[1][cell], beam[2][cell], beam[3][cell]);
    const float fluence = beam[0][cell], size = sqrtf(ty_dot(flux, flux));
    if (!(fluence > 0.0f && size > 0.0f)) return fluence * TY_INV_4PI;
    const float cosine =
        ty_minf(1.0f, size / fluence) * ty_beam_cosine(lattice->cell, distance2) * lattice->medium->g[c][cell];
    return fluence * ty_hg(ty_dot(flux, to_eye) / size, cosine);
}

/* The radiance that a cell scatters towards the eye per scattering coefficient, sum over l of its phase function's
 * moment g^l times the uncollided radiance's band l in that direction, as an isotropic term. */
static void pack_in_scattered(const pack_job* job, size_t cell, float* to) {
    const ty_lattice* lattice = job->lattice;
    const size_t nx = (size_t)lattice->box.size[0], ny = (size_t)lattice->box.size[1];
    const ty_vec place =
        ty_vec_make((float)(cell % nx) + 0.5f, (float)(cell / nx % ny) + 0.5f, (float)(cell / (nx * ny)) + 0.5f);
    const ty_vec off = ty_sub(*job->eye, ty_mad(job->packed->lower, place, lattice->cell));
    const float distance2 = ty_dot(off, off);
    float y[TY_SH_TERMS_MAX];
    const ty_vec to_eye = distance2 > 0.0f ? ty_scale(off, 1.0f / sqrtf(distance2)) : ty_vec_make(0, 0, 1);
    ty_sh_all(to_eye, y);
    for (int c = 0; c < 3; ++c) {
        float sum = 0.0f, moment = 1.0f;
        for (int l = 0; l < TY_SH_BANDS_MAX; ++l, moment *= lattice->medium->g[c][cell])
            for (int t = l * l; t < (l + 1) * (l + 1); ++t) sum += moment * lattice->uncollided[c][t][cell] * y[t];
        to[4 * c] = (ty_maxf(0.0f, sum) + scattered_beam(lattice, c, cell, to_eye, distance2)) / TY_SH_0;
    }
}

static void pack_light(const pack_job* job, size_t cell) {
    const ty_lattice* lattice = job->lattice;
    float* to = job->light + cell * (size_t)job->packed->floats;
    memset(to, 0, (size_t)job->packed->floats * sizeof *to);
    if (job->eye != NULL) {
        pack_in_scattered(job, cell, to);
        return;
    }
    for (int c = 0; c < 3; ++c)
        for (int32_t t = 0; t < lattice->terms; ++t)
            to[t < 4 ? 4 * c + t : TY_PACKED_FLOATS + 5 * c + t - 4] = lattice->light[c][t][cell];
}

/* A neighbour's weight is the transmission from it into the cell. */
static void pack_links(const pack_job* job, size_t cell) {
    uint8_t* links = job->links + cell * TY_PACKED_LINKS;
    uint8_t min = UINT8_MAX;
    links[TY_PACKED_SELF] = UINT8_MAX;
    for (int32_t i = 0; i < 2 * TY_PACKED_SELF + 1; ++i) {
        if (i == TY_PACKED_SELF) continue;
        links[i] = job->lattice->transmission[ty_lpv_link(1 - i % 3, 1 - i / 3 % 3, 1 - i / 9)][cell];
        min = links[i] < min ? links[i] : min;
    }
    job->blocked[cell] = min < UINT8_MAX;
}

static void pack_plane(void* user, int64_t z, int32_t worker) {
    (void)worker;
    const pack_job* job = user;
    const size_t plane = (size_t)job->packed->size[0] * (size_t)job->packed->size[1];
    for (size_t cell = (size_t)z * plane; cell < (size_t)(z + 1) * plane; ++cell) {
        pack_light(job, cell);
        if (job->links != NULL) pack_links(job, cell);
    }
}

static ty_result pack(ty_context* context, const ty_lattice* lattice, const ty_vec* eye, ty_packed_lattice* packed) {
    const ty_grid_box* box = &lattice->box;
    memcpy(packed->size, box->size, sizeof packed->size);
    packed->floats = lattice->terms > 4 && eye == NULL ? TY_PACKED_FLOATS_MAX : TY_PACKED_FLOATS;
    packed->surface_depth_index = lattice->surface_depth_index;
    packed->surface_depths = lattice->surface_depths;
    packed->cell = lattice->cell;
    packed->per_metre = 1.0f / lattice->cell;
    packed->lower = ty_vec_make((float)box->lower[0], (float)box->lower[1], (float)box->lower[2]);
    packed->upper = ty_vec_make((float)box->upper[0], (float)box->upper[1], (float)box->upper[2]);
    const size_t cells = cell_count(packed);
    pack_job job = {.lattice = lattice, .packed = packed, .eye = eye};
    packed->light = job.light = ty_alloc_array(context, cells * (size_t)packed->floats, sizeof(float), false);
    if (job.light == NULL) return TY_ERROR_MEMORY;
    if (lattice->blocked) {
        packed->blocked = job.blocked = ty_alloc_array(context, cells, 1, false);
        packed->links = job.links = ty_alloc_array(context, cells, TY_PACKED_LINKS, true);
        if (job.blocked == NULL || job.links == NULL) return TY_ERROR_MEMORY;
    }
    ty_parallel_for(context, packed->size[2], pack_plane, &job);
    return TY_OK;
}

ty_result ty_packed_lattices_create(ty_context* context, ty_lattice* const* lattices, int32_t count, const ty_vec* eye,
                                    ty_packed_lattices* out) {
    *out = (ty_packed_lattices){0};
    ty_result result = TY_OK;
    while (out->count < count && result == TY_OK) {
        ty_packed_lattice* packed = &out->lattices[out->count];
        result = pack(context, lattices[out->count++], eye, packed);
    }
    return result;
}

void ty_packed_lattices_destroy(ty_context* context, ty_packed_lattices* packed) {
    for (int32_t i = 0; i < packed->count; ++i) {
        ty_packed_lattice* lattice = &packed->lattices[i];
        const size_t cells = cell_count(lattice);
        ty_free_array(context, (void*)lattice->light, cells * (size_t)lattice->floats, sizeof(float));
        ty_free_array(context, (void*)lattice->blocked, cells, 1);
        ty_free_array(context, (void*)lattice->links, cells, TY_PACKED_LINKS);
    }
}
