/* Images of VTK in several pieces, which share the points at their faces, put together. */
#include "io/volumes/vtk/vtk.h"

#include "base/context.h"
#include "grid/grid.h"

#include <string.h>

/* The array of a piece with the name of the first piece's; NULL if there is none like it. */
static const ty_vtk_array* find_array(const ty_vtk_image* image, const ty_vtk_array* first, int32_t piece) {
    for (size_t i = 0; i < image->count; ++i) {
        const ty_vtk_array* array = &image->arrays[i];
        if (array->piece == piece && array->cells == first->cells && array->type == first->type &&
            array->components == first->components && strcmp(array->name, first->name) == 0)
            return array;
    }
    return NULL;
}

/* Values in the making, and which of them a piece has given. */
typedef struct assembly {
    const ty_vtk_image* image;
    const ty_grid_def* def;
    uint8_t* values;
    uint8_t* given;
} assembly;

/* Size of a piece, and where it begins; fails if it is not a part of the whole. */
static ty_result place_piece(const assembly* a, const ty_vtk_array* array, int32_t size[3], int32_t first[3]) {
    const int64_t* whole = a->image->extent;
    int64_t sides[3];
    bool inside = true;
    ty_vtk_sides(array->extent, array->cells, sides);
    for (int axis = 0; axis < 3; ++axis) {
        const int64_t begin = array->extent[2 * axis] - whole[2 * axis];
        const bool flat = array->cells && array->extent[2 * axis] == array->extent[2 * axis + 1];
        inside = inside && begin >= 0 && begin + sides[axis] <= a->def->size[axis];
        inside = inside && (!flat || whole[2 * axis] == whole[2 * axis + 1]); /* else it has no cells */
        size[axis] = inside ? (int32_t)sides[axis] : 1;
        first[axis] = inside ? (int32_t)begin : 0;
    }
    return inside ? TY_OK : ty_vtk_damaged(a->image, array->name, "has a piece beyond the whole extent");
}

static size_t index_of(const int32_t size[3], int32_t i, int32_t j, int32_t k) {
    return (size_t)i + (size_t)size[0] * ((size_t)j + (size_t)size[1] * (size_t)k);
}

static void copy_piece(const assembly* a, const ty_grid* piece, const int32_t size[3], const int32_t first[3]) {
    for (int32_t k = 0; k < size[2]; ++k)
        for (int32_t j = 0; j < size[1]; ++j)
            for (int32_t i = 0; i < size[0]; ++i) {
                const size_t at = index_of(a->def->size, first[0] + i, first[1] + j, first[2] + k);
                ty_store_value(a->def->type, a->values, at, (double)ty_grid_voxel(piece, i, j, k));
                a->given[at] = 1;
            }
}

/* Adds the voxels of a piece to *sum; points of pieces that share their faces are in eight of them at the utmost. */
static ty_result add_piece(const assembly* a, const ty_vtk_array* array, int32_t component, double* sum) {
    ty_grid_def def = *a->def;
    int32_t first[3];
    ty_grid* piece = NULL;
    ty_result result = place_piece(a, array, def.size, first);
    *sum += (double)def.size[0] * def.size[1] * def.size[2];
    if (result == TY_OK && *sum > 8.0 * a->def->size[0] * a->def->size[1] * a->def->size[2])
        result = ty_vtk_damaged(a->image, array->name, "has pieces that overlap");
    const ty_grid_plan whole = {.storage = TY_GRID_AUTO};
    if (result == TY_OK) result = ty_vtk_read_values(a->image, array, component, &whole, &def, &piece);
    if (result == TY_OK) copy_piece(a, piece, def.size, first);
    ty_grid_release(piece);
    return result;
}

static ty_result add_pieces(const assembly* a, const ty_vtk_array* array, int32_t component, size_t voxels) {
    ty_result result = TY_OK;
    double sum = 0;
    for (int32_t p = 0; p < a->image->pieces && result == TY_OK; ++p) {
        const ty_vtk_array* part = find_array(a->image, array, p);
        result = part != NULL ? add_piece(a, part, component, &sum)
                              : ty_vtk_damaged(a->image, array->name, "is not in all pieces, or not of one type");
    }
    if (result == TY_OK && memchr(a->given, 0, voxels) != NULL)
        result = ty_vtk_damaged(a->image, array->name, "has pieces that do not fill the whole extent");
    return result;
}

ty_result ty_vtk_read_pieces(const ty_vtk_image* image, const ty_vtk_array* array, int32_t component,
                             const ty_grid_def* def, ty_grid** out) {
    ty_context* context = image->context;
    const size_t voxels = (size_t)def->size[0] * (size_t)def->size[1] * (size_t)def->size[2];
    const size_t size = ty_grid_value_size(def->type);
    const assembly a = {.image = image,
                        .def = def,
                        .values = ty_alloc_array(context, voxels, size, false),
                        .given = ty_alloc_array(context, voxels, 1, true)};
    const bool allocated = a.values != NULL && a.given != NULL;
    const ty_result result = allocated ? add_pieces(&a, array, component, voxels) : TY_ERROR_MEMORY;
    ty_free_array(context, a.given, voxels, 1);
    if (result == TY_OK) return ty_grid_adopt(context, def, a.values, out);
    ty_free_array(context, a.values, voxels, size);
    return result;
}
