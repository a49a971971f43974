/* Corrections for cells that a surface cuts. Such a cell belongs to the side of its center. The first-collision source
 * in the rest of it is moved to the cell on the other side of the surface; the source between a surface and the box's
 * own face is outside of all cells and removed. */
#include "direct/surfaces/cut_cells.h"

#include "base/context.h"

#include <math.h>
#include <string.h>

/* Offset, in fine cells, beyond which fine cells are neither cut nor partly shadowed by the surface. */
static const double FINE_OFFSET = 2;

/* Minimum thickness, in fine cells, of layers between surfaces and the box's faces, and minimum cosine between them. */
#define MIN_LAYER 1e-2f
#define MIN_FACING 0.9f

typedef struct cut_job {
    const ty_cut_source* in;
    float* fine; /* uncollided fluence of fine cells, summed over channels */
} cut_job;

static void sum_lights(const ty_cut_source* in, size_t cells, float* sum) {
    memset(sum, 0, cells * sizeof *sum);
    for (int32_t l = 0; l < in->light_count; ++l)
        for (int c = 0; c < 3; ++c) {
            float factor;
            const float* plane = ty_light_fluence_plane(&in->lights[l], c, &factor);
            for (size_t i = 0; i < cells; ++i) sum[i] += factor * plane[i];
        }
}

/* Fine fluence FINE_OFFSET cells from the center of a cell along omega (unit), away from the surface. */
static float fluence_at(const cut_job* cut, const int32_t cell[3], ty_vec omega) {
    const ty_cut_source* in = cut->in;
    const float off[3] = {omega.x, omega.y, omega.z};
    size_t at = 0;
    for (int a = 2; a >= 0; --a) {
        const int32_t size = in->fine_box.size[a];
        const double position = (cell[a] + 0.5) * size / in->faces->size[a] + FINE_OFFSET * (double)off[a];
        at = at * (size_t)size + (size_t)fmin(fmax(position, 0), size - 1);
    }
    return cut->fine[at];
}

/* The fraction of a cell behind a plane at `depth` cells from its center along an axis: the tetrahedron that the plane
 * cuts off the farthest corner, minus the tetrahedra beyond the cell's other faces. normal: times the cell's edges. */
static float fraction_behind_plane(const double normal[3], int axis, double depth) {
    double m[3], reach = 0, volume = 0;
    for (int a = 0; a < 3; ++a) m[a] = fabs(normal[a]);
    const double max_outside = fmax(m[0], fmax(m[1], m[2]));
    for (int a = 0; a < 3; ++a) {
        m[a] = fmax(m[a], 1e-2 * max_outside);
        reach += m[a] / 2;
    }
    const double off = reach - m[axis] * depth;
    for (int corner = 0; corner < 8; ++corner) {
        double from = off;
        for (int a = 0; a < 3; ++a) from -= (corner >> a & 1) != 0 ? m[a] : 0;
        const int odd = (corner & 1) ^ (corner >> 1 & 1) ^ (corner >> 2);
        if (from > 0) volume += (odd != 0 ? -1 : 1) * from * from * from;
    }
    return (float)fmin(1, fmax(0, volume / (6 * m[0] * m[1] * m[2])));
}

/* The fraction of a cell behind a side's surface. A surface with several sides in the cell is divided among them by the
 * components of its normal. */
static float fraction_behind_side(const ty_cut_source* in, int32_t side) {
    const ty_boundary_side* boundary_side = &in->faces->sides[side];
    const double* edge = in->cell;
    const double normal[3] = {(double)boundary_side->normal.x * edge[0], (double)boundary_side->normal.y * edge[1],
                              (double)boundary_side->normal.z * edge[2]};
    const int axis = in->faces->face[side] / 2;
    const double sum = fabs(normal[0]) + fabs(normal[1]) + fabs(normal[2]);
    if (!(fabs(normal[axis]) > 0.05 * sum)) return 0;
    return (float)(fabs(normal[axis]) / sum) * fraction_behind_plane(normal, axis, (double)boundary_side->depth);
}

/* Adds a fraction of a cell's source to the cell behind a face. */
static void move_source(const cut_job* cut, size_t at, size_t next, float fraction) {
    const ty_cut_source* in = cut->in;
    for (int32_t c = 0; c < in->channels; ++c)
        for (size_t t = 0; t < in->terms; ++t) {
            float* source = in->source[c] + t * in->cells;
            source[next] += fraction * source[at];
        }
}

static void scale_source(const cut_job* cut, size_t at, float fraction) {
    const ty_cut_source* in = cut->in;
    for (int32_t c = 0; c < in->channels; ++c)
        for (size_t t = 0; t < in->terms; ++t) in->source[c][t * in->cells + at] *= fraction;
}

/* Fluence of the fine cell at a distance from the side's face of the box, on the line through the center of the side's
 * cell. */
static float fine_fluence_from_face(const cut_job* cut, const int32_t cell[3], int face, int32_t off) {
    const ty_cut_source* in = cut->in;
    size_t at = 0;
    for (int a = 2; a >= 0; --a) {
        const int32_t size = in->fine_box.size[a];
        int32_t position = (int32_t)((cell[a] + 0.5) * size / in->faces->size[a]);
        if (a == face / 2) {
            const int32_t within = off < size ? off : size - 1;
            position = (face & 1) != 0 ? size - 1 - within : within;
        }
        at = at * (size_t)size + (size_t)position;
    }
    return cut->fine[at];
}

/* Fraction of a cell's source between the box's face and a surface in front of it: the excess over a source that starts
 * at the surface, bounded by the outermost fine cell so that a light near the surface does not count. Fine cells next
 * to the surface mix both sides. */
static float fraction_outside(const cut_job* cut, const int32_t cell[3], int32_t side) {
    const ty_cut_source* in = cut->in;
    const ty_vec normal = in->faces->sides[side].normal;
    const int face = cut->in->faces->face[side];
    const float facing = fabsf(face / 2 == 0 ? normal.x : face / 2 == 1 ? normal.y : normal.z);
    const float across = (float)in->fine_box.size[face / 2] / (float)in->faces->size[face / 2];
    const float layer = (0.5f - cut->in->faces->sides[side].depth) * across;
    if (!(layer > MIN_LAYER && facing > MIN_FACING)) return 0;
    const int32_t mixed = (int32_t)ceilf(layer) + 1;
    float all = 0, before = 0;
    for (int32_t i = 0; (float)i < across; ++i)
        all += ty_minf(1, across - (float)i) * fine_fluence_from_face(cut, cell, face, i);
    for (int32_t i = 0; i < mixed; ++i) before += fine_fluence_from_face(cut, cell, face, i);
    const float outside = before - ((float)mixed - layer) * fine_fluence_from_face(cut, cell, face, mixed);
    const float max_outside = ty_maxf(layer + 0.5f, 1) * fine_fluence_from_face(cut, cell, face, 0);
    return all > 0 ? ty_clampf(ty_minf(outside, max_outside) / all, 0, 1) : 0;
}

static bool is_outside(const cut_job* cut, const int32_t cell[3], int32_t face) {
    return cell[face / 2] == ((face & 1) != 0 ? cut->in->faces->size[face / 2] - 1 : 0);
}

/* Removes the source outside of the box's surfaces from a cell with the sides [first, end). */
static void remove_outside(const cut_job* cut, const int32_t cell[3], size_t at, int32_t first, int32_t end) {
    float remaining = 1;
    for (int32_t side = first; side < end; ++side)
        if (is_outside(cut, cell, cut->in->faces->face[side])) remaining *= 1 - fraction_outside(cut, cell, side);
    if (remaining < 1) scale_source(cut, at, remaining);
}

/* Moves the source behind the sides [first, end) of a cell to the cells there. */
static void cut_cell(const cut_job* cut, const int32_t cell[3], size_t at, int32_t first, int32_t end) {
    const ty_boundary_faces* faces = cut->in->faces;
    const int32_t* size = faces->size;
    const ptrdiff_t steps[3] = {1, size[0], (ptrdiff_t)size[0] * size[1]};
    float light[6], all = 0, rest = 1;
    ty_vec normal_sum = ty_vec_make(0, 0, 0);
    for (int32_t side = first; side < end; ++side) {
        const int axis = faces->face[side] / 2, sign = (faces->face[side] & 1) != 0 ? 1 : -1;
        int32_t next[3] = {cell[0], cell[1], cell[2]};
        next[axis] += sign;
        light[side - first] = 0;
        if (next[axis] < 0 || next[axis] >= size[axis]) continue;
        const float behind = fraction_behind_side(cut->in, side);
        const ty_vec normal = faces->sides[side].normal;
        light[side - first] = behind * fluence_at(cut, next, ty_scale(normal, -1));
        normal_sum = ty_add(normal_sum, normal);
        all += light[side - first];
        rest -= behind;
    }
    if (!(all > 0)) return;
    const float square = ty_dot(normal_sum, normal_sum);
    all += ty_maxf(0, rest) * fluence_at(cut, cell, square > 0 ? ty_scale(normal_sum, 1 / sqrtf(square)) : normal_sum);
    float remaining = 1;
    for (int32_t side = first; side < end; ++side) {
        const float fraction = light[side - first] / all;
        const ptrdiff_t step = steps[faces->face[side] / 2];
        if (!(fraction > 0)) continue;
        move_source(cut, at, (size_t)((ptrdiff_t)at + ((faces->face[side] & 1) != 0 ? step : -step)), fraction);
        remaining -= fraction;
    }
    scale_source(cut, at, ty_maxf(0, remaining));
}

static void cut_cells(const cut_job* cut) {
    const ty_boundary_faces* faces = cut->in->faces;
    const int64_t rows = (int64_t)faces->size[1] * faces->size[2];
    for (int64_t row = 0; row < rows; ++row)
        for (int32_t side = faces->first[row], end; side < faces->first[row + 1]; side = end) {
            const int32_t cell[3] = {faces->x[side], (int32_t)(row % faces->size[1]), (int32_t)(row / faces->size[1])};
            for (end = side; end < faces->first[row + 1] && faces->x[end] == cell[0];) ++end;
            const size_t at = (size_t)row * (size_t)faces->size[0] + (size_t)cell[0];
            remove_outside(cut, cell, at, side, end);
            cut_cell(cut, cell, at, side, end);
        }
}

ty_result ty_cut_cells_correct(ty_context* context, const ty_cut_source* source) {
    const int32_t* size = source->fine_box.size;
    const size_t cells = (size_t)size[0] * (size_t)size[1] * (size_t)size[2];
    cut_job cut = {.in = source, .fine = ty_alloc_array(context, cells, sizeof(float), false)};
    if (cut.fine == NULL) return TY_ERROR_MEMORY;
    sum_lights(source, cells, cut.fine);
    cut_cells(&cut);
    ty_free_array(context, cut.fine, cells, sizeof(float));
    return TY_OK;
}
