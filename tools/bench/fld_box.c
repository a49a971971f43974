/* Cubes of cells: memory and diffusion problem. */
#include "bench/fld_box.h"

#include "base/context.h"

void fld_free_box(ty_context* context, fld_box* box) {
    ty_free_array(context, box->extinction, box->cells, sizeof(float));
    ty_free_array(context, box->absorption, box->cells, sizeof(float));
    ty_free_array(context, box->source, box->cells, sizeof(float));
    ty_free_array(context, box->fluence, box->cells, sizeof(float));
    *box = (fld_box){0};
}

ty_result fld_make_box(ty_context* context, int32_t edge, double extent, fld_box* out) {
    fld_box box = {
        .edge = edge, .cells = (size_t)edge * (size_t)edge * (size_t)edge, .def = ty_default_diffusion_def()};
    box.extinction = ty_alloc_array(context, box.cells, sizeof(float), true);
    box.absorption = ty_alloc_array(context, box.cells, sizeof(float), true);
    box.source = ty_alloc_array(context, box.cells, sizeof(float), true);
    box.fluence = ty_alloc_array(context, box.cells, sizeof(float), true);
    if (box.extinction == NULL || box.absorption == NULL || box.source == NULL || box.fluence == NULL) {
        fld_free_box(context, &box);
        return TY_ERROR_MEMORY;
    }
    for (int axis = 0; axis < 3; ++axis) {
        box.def.size[axis] = edge;
        box.def.cell[axis] = extent / edge;
    }
    for (int side = 0; side < 6; ++side) box.def.boundary[side] = (ty_boundary){.kind = TY_BOUNDARY_DIRICHLET};
    box.def.extinction = box.extinction;
    box.def.absorption = box.absorption;
    box.def.source = box.source;
    *out = box;
    return TY_OK;
}
