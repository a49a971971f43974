/* One block of a transport sweep. Per row of cells and group of directions: the source in each direction from its
 * moments, diamond difference along the row in both directions of x at once, and the flux moments of the result. SIMD
 * lanes are directions, or moments while these are summed. Compiled once per instruction set, which TY_ISA names. */
#include "solve/ordinates/sweep_kernel.h"

#include "base/dispatch.h"
#include "base/kernel.h"
#include "solve/ordinates/diamond.k.h"

#include <string.h>

/* Scratch memory for one row and one group of directions. */
typedef struct row_scratch {
    float* inverse; /* 1 / (sigma* + sum of 2 |mu_a| / h_a), all lanes per cell */
    float* psi[2];  /* per cell: emission, then mean radiance, of both octants */
    float* sum;     /* moments, of each cell `padded` */
} row_scratch;

static size_t padded_cells(const ty_sweep_box* box) {
    return ((size_t)box->size[0] + TY_SWEEP_CELLS - 1) / TY_SWEEP_CELLS * TY_SWEEP_CELLS;
}

static size_t scratch_floats(const ty_sweep_box* box) {
    return padded_cells(box) * (3 * TY_LANES + (size_t)box->padded);
}

static row_scratch lay_out(const ty_sweep_box* box, float* scratch) {
    const size_t row = padded_cells(box) * TY_LANES;
    return (row_scratch){.inverse = scratch, .psi = {scratch + row, scratch + 2 * row}, .sum = scratch + 3 * row};
}

/* Sweeps cells [begin, end) of a row towards +x and -x. */
static void sweep_cells(const ty_sweep_box* box, int32_t group, const float* extinction, const row_scratch* scratch,
                        int32_t begin, int32_t end, stream streams[2], ty_sweep_sums* sums) {
    ty_lanes two_mu_over_h[3];
    for (int a = 0; a < 3; ++a) two_mu_over_h[a] = ty_lanes_load_aligned(box->two_mu_over_h[a] + group * TY_LANES);
    const ty_lanes faces = two_mu_over_h[0] + two_mu_over_h[1] + two_mu_over_h[2];
    for (int32_t x = begin; x < end; ++x)
        ty_lanes_store_aligned(scratch->inverse + x * TY_LANES, ty_lanes_invert(extinction[x] + faces));
    stream up = streams[0], down = streams[1];
    for (int32_t x = begin; x < end; ++x) {
        const int32_t back = begin + end - 1 - x;
        diamond_difference_step(&up, two_mu_over_h, extinction[x],
                                ty_lanes_load_aligned(scratch->inverse + x * TY_LANES), x, &sums->fixups);
        diamond_difference_step(&down, two_mu_over_h, extinction[back],
                                ty_lanes_load_aligned(scratch->inverse + back * TY_LANES), back, &sums->fixups);
    }
    streams[0].psi_x = up.psi_x;
    streams[1].psi_x = down.psi_x;
}

/* The same towards one side alone: o is 0 towards +x. */
static void sweep_cells_unpaired(const ty_sweep_box* box, int32_t group, const float* extinction, int32_t begin,
                                 int32_t end, int o, stream* light, ty_sweep_sums* sums) {
    ty_lanes two_mu_over_h[3];
    for (int a = 0; a < 3; ++a) two_mu_over_h[a] = ty_lanes_load_aligned(box->two_mu_over_h[a] + group * TY_LANES);
    const ty_lanes faces = two_mu_over_h[0] + two_mu_over_h[1] + two_mu_over_h[2];
    stream s = *light;
    for (int32_t i = begin; i < end; ++i) {
        const int32_t x = o == 0 ? i : begin + end - 1 - i;
        diamond_difference_step(&s, two_mu_over_h, extinction[x], ty_lanes_invert(extinction[x] + faces), x,
                                &sums->fixups);
    }
    light->psi_x = s.psi_x;
}

TY_INLINE void add_leakage(const ty_sweep_box* box, int32_t group, ty_lanes along, ty_sweep_sums* sums) {
    const ty_lanes leaving = ty_lanes_load_aligned(box->partial_current_weight[0] + group * TY_LANES) * along;
    for (int i = 0; i < TY_LANES; ++i) sums->leaving += (double)leaving[i];
}

/* Of a row's directions, the power through the downwind faces of its cells, which a sweep of the row leaves in the
 * radiance upwind of the next row. */
static void add_passing(const ty_sweep_box* box, int32_t octant, int32_t group, ptrdiff_t row,
                        const stream streams[2]) {
    const int32_t axis = box->passing_axis;
    float* passing = box->passing[(octant >> axis & 1) != 0 ? 0 : 1] + row;
    const float *up = axis == 1 ? streams[0].psi_y : streams[0].psi_z,
                *down = axis == 1 ? streams[1].psi_y : streams[1].psi_z;
    const ty_lanes weight = ty_lanes_load_aligned(box->partial_current_weight[axis] + group * TY_LANES);
    for (ptrdiff_t x = 0; x < box->size[0]; ++x) {
        const ty_lanes power =
            weight * (ty_lanes_load_aligned(up + x * TY_LANES) + ty_lanes_load_aligned(down + x * TY_LANES));
        float sum = 0;
        for (int i = 0; i < TY_LANES; ++i) sum += power[i];
        passing[x] += sum;
    }
}

/* ---- boundary faces ---- */

/* The boundary faces of a row, for one group of directions in two octants, or in one of them. */
typedef struct row_faces {
    const ty_sweep_box* box;
    int32_t group, octant;
    int32_t first, end;             /* range of sides */
    int octants_begin, octants_end; /* of 0 and 1 */
} row_faces;

/* The value in all lanes. */
TY_INLINE ty_lanes broadcast(float value) {
    return (ty_lanes){0} + value;
}

/* Index of a side's angular values for an octant of arriving or of emitted directions. */
TY_INLINE ptrdiff_t angular_index(const row_faces* row, int32_t octant, int32_t side) {
    const int32_t axis = row->box->walls->face[side] / 2;
    const int32_t index = (octant & ((1 << axis) - 1)) | (octant >> (axis + 1)) << axis;
    return (((ptrdiff_t)side * 4 + index) * row->box->groups + row->group) * TY_LANES;
}

/* Radiance that a side emits into its cell, per direction of an octant. */
static ty_lanes emitted_radiance(const row_faces* row, int32_t octant, int32_t side) {
    const ty_sweep_faces* walls = row->box->walls;
    ty_lanes even = broadcast(walls->emitted[side]);
    if (walls->reflected != NULL)
        even += walls->factor[side] * ty_lanes_load_aligned(walls->reflected + angular_index(row, octant, side));
    if (walls->emitted_slope == NULL) return even;
    return even + walls->emitted_slope[side] *
                      ty_lanes_load_aligned(row->box->two_mu_over_h[walls->face[side] / 2] + row->group * TY_LANES);
}

static void add_incident_power(const row_faces* row, int32_t octant, int32_t side, ty_lanes light) {
    const ty_sweep_faces* walls = row->box->walls;
    const ty_lanes power =
        ty_lanes_load_aligned(row->box->partial_current_weight[walls->face[side] / 2] + row->group * TY_LANES) * light;
    float sum = 0;
    for (int i = 0; i < TY_LANES; ++i) sum += power[i];
    walls->incident_power[side] += sum;
    if (walls->reflected != NULL) ty_lanes_store_aligned(walls->arriving + angular_index(row, octant, side), light);
}

/* Faces across y and z: before the cells are swept, upwind sides set the incoming radiance; after it, downwind sides
 * collect the incident power. */
static void exchange_face_radiance(const row_faces* row, const stream streams[2], bool after) {
    const ty_sweep_faces* walls = row->box->walls;
    for (int32_t side = row->first; side < row->end; ++side) {
        const int32_t axis = walls->face[side] / 2, upper = walls->face[side] & 1;
        const bool comes = (row->octant >> axis & 1) != upper;
        if (axis == 0 || comes != after) continue;
        for (int o = row->octants_begin; o < row->octants_end; ++o) {
            float* face = (axis == 1 ? streams[o].psi_y : streams[o].psi_z) + walls->x[side] * TY_LANES;
            if (after) add_incident_power(row, row->octant + o, side, ty_lanes_load_aligned(face));
            ty_lanes_store_aligned(face, after ? broadcast(0) : emitted_radiance(row, row->octant + o, side));
        }
    }
}

/* The first side from cell x on that lies on the lower (0) or upper (1) face across x; `end` if there is none. */
static int32_t find_face(const row_faces* row, int32_t x, int32_t face) {
    const ty_sweep_faces* walls = row->box->walls;
    int32_t side = row->first;
    while (side < row->end && (walls->x[side] < x || walls->face[side] != face)) ++side;
    return side;
}

/* Sweeps a row in segments between boundary faces across x. */
static void sweep_row_segments(const row_faces* row, const float* extinction, const row_scratch* scratch,
                               stream streams[2], ty_sweep_sums* sums) {
    const ty_sweep_box* box = row->box;
    const ty_sweep_faces* walls = box->walls;
    const ty_lanes upwind[2] = {streams[0].psi_x, streams[1].psi_x};
    exchange_face_radiance(row, streams, false);
    for (int32_t begin = 0, end; begin < box->size[0]; begin = end) {
        const int32_t low = find_face(row, begin, 0), high = find_face(row, begin, 1);
        const bool has_low = low < row->end && walls->x[low] == begin, has_high = high < row->end;
        end = has_high ? walls->x[high] + 1 : box->size[0];
        streams[0].psi_x = upwind[0];
        streams[1].psi_x = upwind[1];
        if (has_low) streams[0].psi_x = emitted_radiance(row, row->octant, low);
        if (has_high) streams[1].psi_x = emitted_radiance(row, row->octant + 1, high);
        sweep_cells(box, row->group, extinction, scratch, begin, end, streams, sums);
        if (has_high)
            add_incident_power(row, row->octant, high, streams[0].psi_x);
        else
            add_leakage(box, row->group, streams[0].psi_x, sums);
        if (has_low)
            add_incident_power(row, row->octant + 1, low, streams[1].psi_x);
        else
            add_leakage(box, row->group, streams[1].psi_x, sums);
    }
    exchange_face_radiance(row, streams, true);
}

/* The same of one octant; light->psi_x is what enters at one end of the row, and becomes what leaves at the other. */
static void sweep_row_segments_unpaired(const row_faces* row, const float* extinction, stream streams[2],
                                        ty_sweep_sums* sums) {
    const ty_sweep_box* box = row->box;
    const ty_sweep_faces* walls = box->walls;
    const int o = row->octants_begin;
    const int32_t octant = row->octant + o, nx = box->size[0];
    const ty_lanes upwind = streams[o].psi_x;
    ty_lanes leaving = broadcast(0);
    exchange_face_radiance(row, streams, false);
    for (int32_t begin = 0, end; begin < nx; begin = end) {
        const int32_t low = find_face(row, begin, 0), high = find_face(row, begin, 1);
        const bool has_low = low < row->end && walls->x[low] == begin, has_high = high < row->end;
        end = has_high ? walls->x[high] + 1 : nx;
        const bool lit = o == 0 ? has_low : has_high, stops = o == 0 ? has_high : has_low;
        const int32_t source = o == 0 ? low : high, target = o == 0 ? high : low;
        streams[o].psi_x = lit ? emitted_radiance(row, octant, source) : upwind;
        sweep_cells_unpaired(box, row->group, extinction, begin, end, o, &streams[o], sums);
        if (stops) add_incident_power(row, octant, target, streams[o].psi_x);
        if (!stops) leaving = streams[o].psi_x;
    }
    streams[o].psi_x = leaving;
    exchange_face_radiance(row, streams, true);
}

static row_faces faces_of_row(const ty_sweep_box* box, int32_t group, int32_t octant, ptrdiff_t row, int32_t unpaired) {
    row_faces walls = {.box = box, .group = group, .octant = octant, .octants_end = 2};
    if (unpaired >= 0) walls.octants_begin = unpaired;
    if (unpaired >= 0) walls.octants_end = unpaired + 1;
    if (box->walls == NULL) return walls;
    walls.first = box->walls->first[row];
    walls.end = box->walls->first[row + 1];
    return walls;
}

/* ---- moments ---- */

/* Replaces psi(+x), psi(-x) by their sum and difference: even moments depend on the sum, odd ones on the difference. */
TY_INLINE void split_parity(const row_scratch* scratch, int32_t cells) {
    for (ptrdiff_t i = 0; i < (ptrdiff_t)cells * TY_LANES; i += TY_LANES) {
        const ty_lanes up = ty_lanes_load_aligned(scratch->psi[0] + i),
                       down = ty_lanes_load_aligned(scratch->psi[1] + i);
        ty_lanes_store_aligned(scratch->psi[0] + i, up + down);
        ty_lanes_store_aligned(scratch->psi[1] + i, up - down);
    }
}

/* Adds a group's directions to the moments of a row: terms below `odd` are of psi[0], the others of psi[1]. */
TY_INLINE void gather_terms(const ty_sweep_box* box, int32_t group, const float* weighted_y_lm,
                            const float* const psi[2], float* row_sum, const ptrdiff_t padded, const ptrdiff_t odd) {
    const int32_t first = group * TY_LANES, left = box->directions - first,
                  directions = left < TY_LANES ? left : TY_LANES;
    const float* weighted = weighted_y_lm + first * padded;
    for (ptrdiff_t x = 0; x < box->size[0]; x += TY_SWEEP_CELLS)
        for (ptrdiff_t t = 0; t < padded; t += TY_LANES) {
            const float* light = psi[t < odd ? 0 : 1] + x * TY_LANES;
            float* to = row_sum + x * padded + t;
            ty_lanes sum[TY_SWEEP_CELLS] = {{0}};
            for (int i = 0; i < TY_SWEEP_CELLS && group > 0; ++i) sum[i] = ty_lanes_load_aligned(to + i * padded);
            for (int32_t d = 0; d < directions; ++d) {
                const ty_lanes w = ty_lanes_load_aligned(weighted + d * padded + t);
                for (int i = 0; i < TY_SWEEP_CELLS; ++i) sum[i] += light[i * TY_LANES + d] * w;
            }
            for (int i = 0; i < TY_SWEEP_CELLS; ++i) ty_lanes_store_aligned(to + i * padded, sum[i]);
        }
}

TY_INLINE void gather(const ty_sweep_box* box, int32_t group, int32_t octant, const row_scratch* scratch,
                      const ptrdiff_t bands) {
    const float* const psi[2] = {scratch->psi[0], scratch->psi[1]};
    gather_terms(box, group, box->weighted_y_lm[octant / 2], psi, scratch->sum, split_terms(bands),
                 padded_terms(even_terms(bands)));
}

/* Moments of one octant alone: terms of both parities in one sequence. */
TY_INLINE void gather_unpaired(const ty_sweep_box* box, int32_t group, int32_t octant, const row_scratch* scratch,
                               const ptrdiff_t terms) {
    const float* const psi[2] = {scratch->psi[octant & 1], scratch->psi[octant & 1]};
    const ptrdiff_t padded = padded_terms(terms);
    gather_terms(box, group, box->unpaired_y_lm[octant], psi, scratch->sum, padded, padded);
}

/* Compacts the sums of a row in place by removing the padding between parities. */
TY_INLINE void remove_padding(float* sum, ptrdiff_t cells, const ptrdiff_t bands) {
    const ptrdiff_t even = even_terms(bands), odd = even_terms(bands - 1);
    for (ptrdiff_t x = 0; x < cells; ++x) {
        const float* from = sum + x * split_terms(bands);
        float* to = sum + x * (even + odd);
        for (ptrdiff_t t = 0; t < even; t += TY_LANES) ty_lanes_store(to + t, ty_lanes_load_aligned(from + t));
        for (ptrdiff_t t = 0; t < odd; t += TY_LANES)
            ty_lanes_store(to + even + t, ty_lanes_load_aligned(from + padded_terms(even) + t));
    }
}

/* The same of one octant's sums. */
TY_INLINE void remove_padding_unpaired(float* sum, ptrdiff_t cells, const ptrdiff_t terms) {
    for (ptrdiff_t x = 1; x < cells && padded_terms(terms) != terms; ++x)
        for (ptrdiff_t t = 0; t < terms; t += TY_LANES)
            ty_lanes_store(sum + x * terms + t, ty_lanes_load_aligned(sum + x * padded_terms(terms) + t));
}

/* Moments of a cell from parity order to (l, m) order. */
TY_INLINE void reorder_cell(const ty_sweep_box* box, const float* sum, float* moments, const ptrdiff_t terms) {
#if defined(__AVX512F__)
    for (ptrdiff_t t = 0; t < terms; t += TY_LANES) {
        const __m512i position = _mm512_load_si512(box->position + t), from = _mm512_srai_epi32(position, 4);
        __m512 ordered = _mm512_setzero_ps();
        for (int32_t s = 0; s * TY_LANES < terms; ++s)
            ordered = _mm512_mask_permutexvar_ps(ordered, _mm512_cmpeq_epi32_mask(from, _mm512_set1_epi32(s)), position,
                                                 _mm512_loadu_ps(sum + s * TY_LANES));
        _mm512_mask_storeu_ps(moments + t, (__mmask16)(terms - t < TY_LANES ? (1 << (terms - t)) - 1 : 0xffff),
                              ordered);
    }
#else
    for (ptrdiff_t t = 0; t < terms; ++t) moments[t] = sum[box->position[t]];
#endif
}

/* Accumulates a row's moments, in parity order until the last of the octants has been swept. */
TY_INLINE void store_moments(const ty_sweep_box* box, const ty_sweep_block* block, float* sum, float* moments,
                             const ptrdiff_t bands) {
    const ptrdiff_t cells = box->size[0], terms = bands * bands, items = terms * cells;
    if (block->unpaired < 0)
        remove_padding(sum, cells, bands);
    else
        remove_padding_unpaired(sum, cells, terms);
    if (block->first) {
        memcpy(moments, sum, sizeof *moments * (size_t)items);
    } else if (block->last) {
#pragma omp simd
        for (ptrdiff_t i = 0; i < items; ++i) sum[i] += moments[i];
        for (ptrdiff_t x = 0; x < cells; ++x) reorder_cell(box, sum + x * terms, moments + x * terms, terms);
    } else {
#pragma omp simd
        for (ptrdiff_t i = 0; i < items; ++i) moments[i] += sum[i];
    }
}

/* ---- rows ---- */

/* Data shared by all rows of a block. */
typedef struct row_work {
    const ty_sweep_box* box;
    const float* emission;
    float* moments;
    row_scratch scratch;
    ty_sweep_sums* sums;
    const ty_sweep_block* block;
} row_work;

/* One group of directions of the octant of a block that is swept alone; streams, walls: of the row. */
TY_INLINE void sweep_unpaired(const row_work* work, const row_faces* walls, const float* extinction, float* across,
                              stream streams[2], const int32_t bands) {
    const ty_sweep_box* box = work->box;
    const int o = work->block->unpaired;
    streams[o].psi_x = ty_lanes_load_aligned(across);
    if (walls->first < walls->end)
        sweep_row_segments_unpaired(walls, extinction, streams, work->sums);
    else
        sweep_cells_unpaired(box, walls->group, extinction, 0, box->size[0], o, &streams[o], work->sums);
    if (work->block->leaves) add_leakage(box, walls->group, streams[o].psi_x, work->sums);
    ty_lanes_store_aligned(across, streams[o].psi_x);
    gather_unpaired(box, walls->group, walls->octant + o, &work->scratch, bands * bands);
}

TY_INLINE void sweep_row(const row_work* work, int32_t octant, int32_t y, int32_t z, const int32_t bands) {
    const ty_sweep_box* box = work->box;
    const row_scratch* scratch = &work->scratch;
    const ptrdiff_t nx = box->size[0], ny = box->size[1], nz = box->size[2], row = (z * ny + y) * nx;
    const ptrdiff_t pitch = (ptrdiff_t)box->groups * TY_LANES;
    const int32_t terms = bands * bands, at[3] = {0, y + box->origin[1], z + box->origin[2]};
    const int32_t unpaired = work->block->unpaired;
    const ptrdiff_t patch = ty_boundary_patch(&box->patches, box->whole, 0, at);
    for (int32_t g = 0; g < box->groups; ++g) {
        const emission_view view = {box->order, box->y_lm[octant / 2] + g * TY_LANES, pitch};
        emit(&view, work->emission + row * terms, (int32_t)nx, scratch->psi[0], scratch->psi[1], bands);
        stream streams[2];
        for (int o = 0; o < 2; ++o)
            streams[o] = (stream){
                .psi_x = ty_lanes_load_aligned(box->boundary_radiance[0][octant + o] + patch * pitch + g * TY_LANES),
                .psi = scratch->psi[o],
                .psi_y = box->faces_y[octant + o] + (g * nz + z) * nx * TY_LANES,
                .psi_z = box->faces_z[octant + o] + (g * ny + y) * nx * TY_LANES};
        const row_faces walls = faces_of_row(box, g, octant, z * ny + y, unpaired);
        if (unpaired >= 0) {
            float* across = box->faces_x[octant + unpaired] + ((g * nz + z) * ny + y) * TY_LANES;
            sweep_unpaired(work, &walls, box->extinction + row, across, streams, bands);
            continue;
        }
        if (box->closed != NULL) {
            transpose_row(box, octant, g, row, streams);
        } else if (walls.first < walls.end) {
            sweep_row_segments(&walls, box->extinction + row, scratch, streams, work->sums);
        } else {
            sweep_cells(box, g, box->extinction + row, scratch, 0, (int32_t)nx, streams, work->sums);
            if ((box->periodic & 1) == 0) add_leakage(box, g, streams[0].psi_x + streams[1].psi_x, work->sums);
            for (int o = 0; o < 2 && (box->periodic & 1) != 0; ++o)
                ty_lanes_store_aligned(box->faces_x[octant + o] + ((g * nz + z) * ny + y) * TY_LANES, streams[o].psi_x);
        }
        if (box->passing[0] != NULL) add_passing(box, octant, g, row, streams);
        split_parity(scratch, (int32_t)nx);
        gather(box, g, octant, scratch, bands);
    }
    store_moments(box, work->block, scratch->sum, work->moments + row * terms, bands);
}

/* Dispatches to a row sweep with a compile-time Legendre order for the usual orders, which unrolls the loops over
 * terms.
 */
static void sweep_row_of_order(const row_work* work, int32_t octant, int32_t y, int32_t z) {
    switch (work->box->terms) {
    case 1: sweep_row(work, octant, y, z, 1); return;
    case 4: sweep_row(work, octant, y, z, 2); return;
    case 9: sweep_row(work, octant, y, z, 3); return;
    case 16: sweep_row(work, octant, y, z, 4); return;
    case 25: sweep_row(work, octant, y, z, 5); return;
    case 36: sweep_row(work, octant, y, z, 6); return;
    default: sweep_row(work, octant, y, z, 2 * work->box->even - work->box->terms);
    }
}

static void cross(const ty_sweep_box* box, const ty_sweep_block* block, const float* emission, float* moments,
                  float* scratch, ty_sweep_sums* sums) {
    const row_work work = {box, emission, moments, lay_out(box, scratch), sums, block};
    const bool down_y = (block->pair & 1) != 0, down_z = (block->pair & 2) != 0;
    const int32_t count_y = block->end[0] - block->begin[0], count_z = block->end[1] - block->begin[1];
    for (int32_t k = 0; k < count_z; ++k)
        for (int32_t j = 0; j < count_y; ++j)
            sweep_row_of_order(&work, 2 * block->pair, down_y ? block->end[0] - 1 - j : block->begin[0] + j,
                               down_z ? block->end[1] - 1 - k : block->begin[1] + k);
}

const ty_sweep_kernels TY_KERNEL_NAME(ty_sweep_kernels) = {
    .lanes = TY_LANES,
    .scratch = scratch_floats,
    .cross = cross,
};
