/* Irradiance by the propagated light at single surface points. */
#include "method/lpv/lattice/irradiance.h"

#include "method/lpv/lattice/packed_lattice.k.h"

void ty_lpv_irradiance_at(const ty_lpv_light_view* light, ty_vec point, ty_vec normal, float irradiance[3]) {
    const ty_lattice_cascade_weights mix = ty_lattice_choose_cascades(light->lattices, light->count, point);
    float y[TY_SH_TERMS], terms[TY_SH_TERMS];
    ty_sh_at(ty_scale(normal, -1.0f), TY_SH_BANDS, y);
    for (int c = 0; c < 3; ++c) irradiance[c] = 0.0f;
    for (int i = 0; i < 2 && mix.lattice[i] >= 0; ++i) {
        const ty_lattice* lattice = light->lattices[mix.lattice[i]];
        ty_lattice_cells cells;
        if (!ty_lattice_find(lattice, ty_lattice_lit_side(lattice, point, normal), &cells)) continue;
        for (int c = 0; c < 3; ++c) {
            ty_lattice_values(lattice, &cells, c, lattice->terms, terms);
            irradiance[c] += mix.weight[i] * ty_packed_clamped_cosine(terms, lattice->terms > 4 ? terms + 4 : NULL, y);
        }
    }
}
