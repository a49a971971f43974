/* Creation and destruction of lattices. */
#include "method/lpv/lattice/lattice.h"

#include "base/context.h"

/* ---- memory ---- */

static bool take_planes(const ty_lattice* lattice, float** planes, int32_t count) {
    for (int32_t i = 0; i < count; ++i) {
        planes[i] = ty_alloc_array(lattice->context, lattice->cells, sizeof **planes, true);
        if (planes[i] == NULL) return false;
    }
    return true;
}

static void give_planes(const ty_lattice* lattice, float** planes, int32_t count) {
    for (int32_t i = 0; i < count; ++i) ty_free_array(lattice->context, planes[i], lattice->cells, sizeof **planes);
}

static bool take_all(ty_lattice* lattice) {
    for (int c = 0; c < 3; ++c)
        if (!take_planes(lattice, lattice->propagated_sh[c], lattice->terms) ||
            !take_planes(lattice, lattice->light[c], lattice->terms))
            return false;
    if (!take_planes(lattice, lattice->albedo, 3)) return false;
    for (int32_t k = 0; k < TY_LPV_LINKS; ++k) {
        lattice->transmission[k] = ty_alloc_array(lattice->context, lattice->cells, 1, false);
        if (lattice->transmission[k] == NULL) return false;
        memset(lattice->transmission[k], 255, lattice->cells);
    }
    return true;
}

ty_result ty_lattice_create(ty_context* context, const ty_grid_box* box, int32_t bands, ty_lattice** out) {
    *out = NULL;
    const size_t cells = (size_t)box->size[0] * (size_t)box->size[1] * (size_t)box->size[2];
    const int32_t terms = bands * bands;
    const double bytes = (double)cells * (sizeof(float) * (6.0 * terms + 3) + TY_LPV_LINKS);
    const ty_result result = ty_check_memory(context, bytes, "a lattice");
    if (result != TY_OK) return result;
    ty_lattice* lattice = ty_alloc_array(context, 1, sizeof *lattice, true);
    if (lattice == NULL) return TY_ERROR_MEMORY;
    lattice->context = context;
    lattice->box = *box;
    lattice->cell = (float)((box->upper[0] - box->lower[0]) / box->size[0]);
    lattice->cells = cells;
    lattice->bands = bands;
    lattice->terms = terms;
    if (!take_all(lattice)) {
        ty_lattice_destroy(lattice);
        return TY_ERROR_MEMORY;
    }
    *out = lattice;
    return TY_OK;
}

void ty_lattice_destroy(ty_lattice* lattice) {
    if (lattice == NULL) return;
    for (int c = 0; c < 3; ++c) {
        give_planes(lattice, lattice->propagated_sh[c], lattice->terms);
        give_planes(lattice, lattice->light[c], lattice->terms);
        give_planes(lattice, lattice->uncollided[c], TY_SH_TERMS_MAX);
        give_planes(lattice, lattice->beam[c], TY_BEAM_TERMS);
    }
    give_planes(lattice, lattice->albedo, 3);
    ty_free_array(lattice->context, lattice->surface_depth_index, lattice->cells, sizeof *lattice->surface_depth_index);
    ty_free_array(lattice->context, lattice->surface_depths, lattice->surface_depth_count,
                  sizeof *lattice->surface_depths);
    for (int32_t k = 0; k < TY_LPV_LINKS; ++k)
        ty_free_array(lattice->context, lattice->transmission[k], lattice->cells, 1);
    give_planes(lattice, lattice->border_scale, 3);
    ty_grid_medium_destroy(lattice->medium);
    ty_free_array(lattice->context, lattice->extinction_floor, lattice->cells, sizeof *lattice->extinction_floor);
    ty_free_array(lattice->context, lattice, 1, sizeof *lattice);
}

/* ---- a lattice for benchmarks ---- */

/* True if a cell is in a pseudo-random subset of one in `one_of` cells. */
static bool is_picked(size_t cell, uint32_t one_of) {
    return (uint32_t)cell * 2654435761u / one_of % one_of == 0;
}

/* Walls across x over half the lattice, which block links partly. */
static void add_walls(ty_lattice* lattice) {
    const int32_t *size = lattice->box.size, apart = 6;
    for (int32_t k = 0; k < TY_LPV_LINKS; ++k)
        for (size_t i = 0; i < lattice->cells; ++i) {
            const int32_t x = (int32_t)(i % (size_t)size[0]), y = (int32_t)(i / (size_t)size[0] % (size_t)size[1]);
            if (x % apart < 2 && y < size[1] / 2) lattice->transmission[k][i] = (uint8_t)(x % 2 == 0 ? 0 : 128);
        }
    for (int c = 0; c < 3; ++c)
        for (size_t i = 0; i < lattice->cells; ++i) lattice->albedo[c][i] = 0.5f;
    lattice->blocked = true;
}

ty_result ty_lattice_create_sample(ty_context* context, int32_t side, int32_t bands, bool blocked, ty_lattice** out) {
    ty_grid_box box = {.size = {side, side, side}};
    for (int a = 0; a < 3; ++a) box.upper[a] = side;
    const ty_result result = ty_lattice_create(context, &box, bands, out);
    if (result != TY_OK) return result;
    for (size_t i = 0; i < (*out)->cells; ++i)
        for (int c = 0; c < 3 && is_picked(i, 5); ++c) {
            (*out)->propagated_sh[c][0][i] = 1.0f;
            (*out)->propagated_sh[c][1][i] = 0.5f;
        }
    if (blocked) add_walls(*out);
    return TY_OK;
}
