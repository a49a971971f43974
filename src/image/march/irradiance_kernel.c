/* Light of media along the rays of a cache's points; built once per instruction set, with TY_ISA naming it. */
#include "image/march/irradiance_gather.h"

#include "base/float_mode.h"
#include "image/march/reflect.k.h"

TY_IRRADIANCE_KERNEL(TY_KERNEL_NAME(ty_irradiance_kernel)) {
    const unsigned state = ty_flush_denormals();
    const ty_cell_lattice* lattice = &request->surface_field.lattice;
    ty_march_ray ray;
    for (int c = 0; c < 3; ++c) irradiance[c] = 0.0f;
    if (point->inside != 0) {
        const ty_vec cells = ty_cell_coordinates(lattice, point->position);
        const ty_vec within = ty_vec_make(ty_clampf(cells.x, 0.0f, (float)lattice->size[0]),
                                          ty_clampf(cells.y, 0.0f, (float)lattice->size[1]),
                                          ty_clampf(cells.z, 0.0f, (float)lattice->size[2]));
        ty_upsample_irradiance(&request->surface_field, within, point->normal, irradiance);
    } else {
        ty_reflect_gather(request, &ray, point->position, point->normal, point->normal, TY_IRRADIANCE_GATHER_RAYS,
                          point->phase, irradiance);
    }
    ty_restore_denormals(state);
}
