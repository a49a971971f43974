/* Rays several pixels apart, on devices. */
#include "image/march/device/item.k.h"
#include "image/march/spaced.k.h"

TY_DEVICE_ENTRY(march_rays, ty_march_launch) {
    TY_GLOBAL const ty_spaced_rays* lattice = &arguments->lattice;
    ty_march_ray ray;
    ty_march_count(arguments, index,
                   ty_spaced_march(arguments->request, &ray, lattice, arguments->sample,
                                   ty_march_column(arguments, index, lattice->columns),
                                   ty_march_row(arguments, index, lattice->columns)));
}
