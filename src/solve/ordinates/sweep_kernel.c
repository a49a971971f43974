/* A block of a sweep: row by row, the emission towards all directions of a group, then light along the row, both ways
 * at once, then its moments. Lanes are directions, and moments when these are summed. Built once per instruction set,
 * with TY_ISA naming it. */
#include "solve/ordinates/sweep_kernel.h"

#include "base/kernel.h"

#include <string.h>

#if defined(__SSE2__)
#include <immintrin.h>
#endif

#if defined(__AVX512F__)
enum { BYTES = 64 };
#elif defined(__AVX__)
enum { BYTES = 32 };
#else
enum { BYTES = 16 };
#endif
enum { LANES = BYTES / sizeof(float) };

#define TY_JOIN_(a, b) a##b
#define TY_JOIN(a, b) TY_JOIN_(a, b)
#define TY_INLINE static inline __attribute__((always_inline))

typedef float lanes __attribute__((vector_size(BYTES), may_alias));
typedef int32_t whole_lanes __attribute__((vector_size(BYTES), may_alias));

/* All arrays of lanes are aligned. */
TY_INLINE lanes load(const float* from) {
    return *(const lanes*)from;
}

TY_INLINE void store(float* to, lanes value) {
    *(lanes*)to = value;
}

TY_INLINE void store_anywhere(float* to, lanes value) {
    memcpy(to, &value, sizeof value);
}

/* A bit for each lane that is below 0. */
TY_INLINE uint32_t signs(whole_lanes value) {
#if defined(__AVX512F__)
    return _mm512_movepi32_mask((__m512i)value);
#elif defined(__AVX__)
    return (uint32_t)_mm256_movemask_ps((__m256)value);
#elif defined(__SSE2__)
    return (uint32_t)_mm_movemask_ps((__m128)value);
#else
    uint32_t bits = 0;
    for (int i = 0; i < LANES; ++i) bits |= (uint32_t)(value[i] < 0) << i;
    return bits;
#endif
}

/* Which lanes: bits where processors have registers of them, else all or no bits of each. */
#if defined(__AVX512F__)
typedef __mmask16 choice;
#else
typedef whole_lanes choice;
#endif

TY_INLINE choice exceeds(lanes a, lanes b) {
#if defined(__AVX512F__)
    return _mm512_cmp_ps_mask((__m512)a, (__m512)b, _CMP_GT_OQ);
#else
    return a > b;
#endif
}

/* A bit for each lane. */
TY_INLINE uint32_t bits_of(choice which) {
#if defined(__AVX512F__)
    return which;
#else
    return signs(which);
#endif
}

/* What is not chosen is 0. */
TY_INLINE lanes keep(choice which, lanes value) {
#if defined(__AVX512F__)
    return (lanes)_mm512_maskz_mov_ps(which, (__m512)value);
#else
    return (lanes)((whole_lanes)value & which);
#endif
}

/* sum + a b, and sum + a, where chosen. */
TY_INLINE lanes add_product(choice which, lanes sum, lanes a, lanes b) {
#if defined(__AVX512F__)
    return (lanes)_mm512_mask3_fmadd_ps((__m512)a, (__m512)b, (__m512)sum, which);
#else
    return sum + keep(which, a) * b;
#endif
}

TY_INLINE lanes add(choice which, lanes sum, lanes a) {
#if defined(__AVX512F__)
    return (lanes)_mm512_mask_add_ps((__m512)sum, which, (__m512)sum, (__m512)a);
#else
    return sum + keep(which, a);
#endif
}

/* 1 / value to 2 ulp. */
TY_INLINE lanes invert(lanes value) {
#if defined(__AVX512F__)
    /* A division keeps the whole unit busy for as long as everything else of a cell takes. */
    const lanes guess = (lanes)_mm512_rcp14_ps((__m512)value);
    return guess * (2.0f - value * guess);
#else
    return 1.0f / value;
#endif
}

/* Scratch memory of one row and group. */
typedef struct row_scratch {
    float* inverse;  /* 1 / (extinction + what faces take), of each cell all lanes */
    float* light[2]; /* emission, then radiance, of both octants */
    float* sum;      /* moments, of each cell `padded` */
} row_scratch;

static size_t padded_cells(const ty_sweep_box* box) {
    return ((size_t)box->size[0] + TY_SWEEP_CELLS - 1) / TY_SWEEP_CELLS * TY_SWEEP_CELLS;
}

static size_t scratch_floats(const ty_sweep_box* box) {
    return padded_cells(box) * (3 * LANES + (size_t)box->padded);
}

static row_scratch lay_out(const ty_sweep_box* box, float* scratch) {
    const size_t row = padded_cells(box) * LANES;
    return (row_scratch){.inverse = scratch, .light = {scratch + row, scratch + 2 * row}, .sum = scratch + 3 * row};
}

/* ---- harmonics ---- */

/* Filled up to whole lanes. */
TY_INLINE ptrdiff_t pad(ptrdiff_t terms) {
    return (terms + LANES - 1) / LANES * LANES;
}

/* Harmonics that mirroring along x leaves as they are, and all, each kind in whole lanes. */
TY_INLINE ptrdiff_t even_terms(ptrdiff_t bands) {
    return bands * (bands + 1) / 2;
}

TY_INLINE ptrdiff_t split_terms(ptrdiff_t bands) {
    return pad(even_terms(bands)) + pad(even_terms(bands - 1));
}

/* ---- emission ---- */

typedef struct emission_view {
    const ty_sweep_box* box;
    const float* harmonics; /* of the group */
    ptrdiff_t pitch;        /* from one term to the next */
} emission_view;

TY_INLINE void emit_cells(const emission_view* view, const float* emission, float* up, float* down, const int count,
                          const int32_t bands) {
    const int32_t terms = bands * bands, evens = (int32_t)even_terms(bands);
    const int32_t* order = view->box->order;
    const float* y = view->harmonics;
    lanes even[TY_SWEEP_CELLS] = {{0}}, odd[TY_SWEEP_CELLS] = {{0}};
    int32_t t = 0;
    for (; t < evens; ++t, y += view->pitch) {
        const lanes at = load(y);
        const float* from = emission + order[t];
        for (int i = 0; i < count; ++i) even[i] += from[i * terms] * at;
    }
    for (; t < terms; ++t, y += view->pitch) {
        const lanes at = load(y);
        const float* from = emission + order[t];
        for (int i = 0; i < count; ++i) odd[i] += from[i * terms] * at;
    }
    for (int i = 0; i < count; ++i) {
        store(up + i * LANES, even[i] + odd[i]);
        store(down + i * LANES, even[i] - odd[i]);
    }
}

TY_INLINE void emit(const emission_view* view, const float* emission, float* up, float* down, const int32_t bands) {
    const int32_t nx = view->box->size[0], terms = bands * bands;
    int32_t x = 0;
    for (; x + TY_SWEEP_CELLS <= nx; x += TY_SWEEP_CELLS)
        emit_cells(view, emission + (ptrdiff_t)x * terms, up + x * LANES, down + x * LANES, TY_SWEEP_CELLS, bands);
    for (; x < nx; ++x) emit_cells(view, emission + (ptrdiff_t)x * terms, up + x * LANES, down + x * LANES, 1, bands);
}

/* ---- light ---- */

/* Light on its way along a row. */
typedef struct stream {
    lanes along; /* into the next cell */
    float *light, *face_y, *face_z;
} stream;

/* The cell balances again without the faces that fell below 0, until there are none: a face that is closed lets in half
 * of what it does otherwise, and nothing out. Returns twice the light in the middle. */
TY_INLINE lanes hold_faces(const lanes twice[3], float extinction, lanes source, const lanes in[3], lanes out[3],
                           int64_t* fixed) {
    const lanes none = {0};
    lanes twofold, all = source + source;
    choice open[3], low[3];
    for (int a = 0; a < 3; ++a) {
        all += twice[a] * in[a];
        low[a] = exceeds(none, out[a]);
        open[a] = (choice)~low[a];
    }
    do {
        lanes above = all, below = none + extinction;
        for (int a = 0; a < 3; ++a) {
            above = add_product(open[a], above, twice[a], in[a]);
            below = add(open[a], below, twice[a]);
        }
        twofold = keep(exceeds(below, none), above * invert(below));
        for (int a = 0; a < 3; ++a) {
            out[a] = keep(open[a], twofold - in[a]);
            low[a] = exceeds(none, out[a]);
            open[a] = (choice)(open[a] & ~low[a]);
        }
    } while (bits_of((choice)(low[0] | low[1] | low[2])) != 0);
    *fixed += LANES - __builtin_popcount(bits_of((choice)(open[0] & open[1] & open[2])));
    return twofold;
}

TY_INLINE void cross_cell(stream* s, const lanes twice[3], float extinction, lanes inverse, ptrdiff_t x,
                          int64_t* fixed) {
    const lanes source = load(s->light + x * LANES);
    const lanes in[3] = {s->along, load(s->face_y + x * LANES), load(s->face_z + x * LANES)};
    const lanes middle = (source + twice[1] * in[1] + twice[2] * in[2]) * inverse + twice[0] * inverse * in[0];
    lanes twofold = middle + middle;
    lanes out[3] = {twofold - in[0], twofold - in[1], twofold - in[2]};
    if (__builtin_expect(signs((whole_lanes)out[0] | (whole_lanes)out[1] | (whole_lanes)out[2]) != 0, 0))
        twofold = hold_faces(twice, extinction, source, in, out, fixed);
    s->along = out[0];
    store(s->face_y + x * LANES, out[1]);
    store(s->face_z + x * LANES, out[2]);
    store(s->light + x * LANES, 0.5f * twofold);
}

/* Through cells [begin, end) of a row, up and down. */
static void advance(const ty_sweep_box* box, int32_t group, const float* extinction, const row_scratch* scratch,
                    int32_t begin, int32_t end, stream streams[2], ty_sweep_sums* sums) {
    lanes twice[3];
    for (int a = 0; a < 3; ++a) twice[a] = load(box->twice[a] + group * LANES);
    const lanes faces = twice[0] + twice[1] + twice[2];
    for (int32_t x = begin; x < end; ++x) store(scratch->inverse + x * LANES, invert(extinction[x] + faces));
    stream up = streams[0], down = streams[1];
    for (int32_t x = begin; x < end; ++x) {
        const int32_t back = begin + end - 1 - x;
        cross_cell(&up, twice, extinction[x], load(scratch->inverse + x * LANES), x, &sums->fixed);
        cross_cell(&down, twice, extinction[back], load(scratch->inverse + back * LANES), back, &sums->fixed);
    }
    streams[0].along = up.along;
    streams[1].along = down.along;
}

TY_INLINE void add_leaving(const ty_sweep_box* box, int32_t group, lanes along, ty_sweep_sums* sums) {
    const lanes leaving = load(box->through[0] + group * LANES) * along;
    for (int i = 0; i < LANES; ++i) sums->leaving += (double)leaving[i];
}

/* ---- walls ---- */

/* The walls of a row, for one group of directions of two octants. */
typedef struct row_walls {
    const ty_sweep_box* box;
    int32_t group, octant;
    int32_t first, end; /* sides */
} row_walls;

/* The same in all directions. */
TY_INLINE lanes all_of(float value) {
    return (lanes){0} + value;
}

/* What a side sends into its cell. */
static lanes sent_by(const row_walls* row, int32_t side) {
    const ty_sweep_faces* walls = row->box->walls;
    const lanes even = all_of(walls->sent[side]);
    if (walls->tilt == NULL) return even;
    return even + walls->tilt[side] * load(row->box->twice[walls->face[side] / 2] + row->group * LANES);
}

static void arrive(const row_walls* row, int32_t side, int32_t axis, lanes light) {
    const lanes power = load(row->box->through[axis] + row->group * LANES) * light;
    float sum = 0;
    for (int i = 0; i < LANES; ++i) sum += power[i];
    row->box->walls->arrived[side] += sum;
}

/* Sides of faces along y and z: those that light leaves behind send into their cells; those that it comes to, after the
 * cells, take it. */
static void pass_sides(const row_walls* row, const stream streams[2], bool after) {
    const ty_sweep_faces* walls = row->box->walls;
    for (int32_t side = row->first; side < row->end; ++side) {
        const int32_t axis = walls->face[side] / 2, upper = walls->face[side] & 1;
        const bool comes = (row->octant >> axis & 1) != upper;
        if (axis == 0 || comes != after) continue;
        for (int o = 0; o < 2; ++o) {
            float* face = (axis == 1 ? streams[o].face_y : streams[o].face_z) + walls->x[side] * LANES;
            if (after) arrive(row, side, axis, load(face));
            store(face, after ? all_of(0) : sent_by(row, side));
        }
    }
}

/* The side of face 0 or 1 (along x) of the first cell from `x` on that has one; or `end`. */
static int32_t find_side(const row_walls* row, int32_t x, int32_t face) {
    const ty_sweep_faces* walls = row->box->walls;
    int32_t side = row->first;
    while (side < row->end && (walls->x[side] < x || walls->face[side] != face)) ++side;
    return side;
}

/* The row in parts between walls along x. */
static void advance_walls(const row_walls* row, const float* extinction, const row_scratch* scratch, stream streams[2],
                          ty_sweep_sums* sums) {
    const ty_sweep_box* box = row->box;
    const ty_sweep_faces* walls = box->walls;
    const lanes inflow[2] = {streams[0].along, streams[1].along};
    pass_sides(row, streams, false);
    for (int32_t begin = 0, end; begin < box->size[0]; begin = end) {
        const int32_t low = find_side(row, begin, 0), high = find_side(row, begin, 1);
        const bool low_is = low < row->end && walls->x[low] == begin, high_is = high < row->end;
        end = high_is ? walls->x[high] + 1 : box->size[0];
        streams[0].along = inflow[0];
        streams[1].along = inflow[1];
        if (low_is) streams[0].along = sent_by(row, low);
        if (high_is) streams[1].along = sent_by(row, high);
        advance(box, row->group, extinction, scratch, begin, end, streams, sums);
        if (high_is)
            arrive(row, high, 0, streams[0].along);
        else
            add_leaving(box, row->group, streams[0].along, sums);
        if (low_is)
            arrive(row, low, 0, streams[1].along);
        else
            add_leaving(box, row->group, streams[1].along, sums);
    }
    pass_sides(row, streams, true);
}

static row_walls walls_of(const ty_sweep_box* box, int32_t group, int32_t octant, ptrdiff_t row) {
    row_walls walls = {.box = box, .group = group, .octant = octant};
    if (box->walls == NULL) return walls;
    walls.first = box->walls->first[row];
    walls.end = box->walls->first[row + 1];
    return walls;
}

/* ---- moments ---- */

/* Light up and down becomes its sum, which even moments are made of, and its difference, which odd ones are. */
TY_INLINE void mirror(const row_scratch* scratch, int32_t cells) {
    for (ptrdiff_t i = 0; i < (ptrdiff_t)cells * LANES; i += LANES) {
        const lanes up = load(scratch->light[0] + i), down = load(scratch->light[1] + i);
        store(scratch->light[0] + i, up + down);
        store(scratch->light[1] + i, up - down);
    }
}

TY_INLINE void gather(const ty_sweep_box* box, int32_t group, int32_t octant, const row_scratch* scratch,
                      const ptrdiff_t bands) {
    const int32_t first = group * LANES, left = box->directions - first, directions = left < LANES ? left : LANES;
    const ptrdiff_t padded = split_terms(bands), odd = pad(even_terms(bands));
    const float* weighted = box->weighted[octant / 2] + first * padded;
    for (ptrdiff_t x = 0; x < box->size[0]; x += TY_SWEEP_CELLS)
        for (ptrdiff_t t = 0; t < padded; t += LANES) {
            const float* light = scratch->light[t < odd ? 0 : 1] + x * LANES;
            float* to = scratch->sum + x * padded + t;
            lanes sum[TY_SWEEP_CELLS] = {{0}};
            for (int i = 0; i < TY_SWEEP_CELLS && group > 0; ++i) sum[i] = load(to + i * padded);
            for (int32_t d = 0; d < directions; ++d) {
                const lanes w = load(weighted + d * padded + t);
                for (int i = 0; i < TY_SWEEP_CELLS; ++i) sum[i] += light[i * LANES + d] * w;
            }
            for (int i = 0; i < TY_SWEEP_CELLS; ++i) store(to + i * padded, sum[i]);
        }
}

/* Sums of a row without what fills up lanes, where they are. */
TY_INLINE void close_up(float* sum, ptrdiff_t cells, const ptrdiff_t bands) {
    const ptrdiff_t even = even_terms(bands), odd = even_terms(bands - 1);
    for (ptrdiff_t x = 0; x < cells; ++x) {
        const float* from = sum + x * split_terms(bands);
        float* to = sum + x * (even + odd);
        for (ptrdiff_t t = 0; t < even; t += LANES) store_anywhere(to + t, load(from + t));
        for (ptrdiff_t t = 0; t < odd; t += LANES) store_anywhere(to + even + t, load(from + pad(even) + t));
    }
}

/* A cell's moments, each in its place. */
TY_INLINE void order_cell(const ty_sweep_box* box, const float* sum, float* moments, const ptrdiff_t terms) {
#if defined(__AVX512F__)
    for (ptrdiff_t t = 0; t < terms; t += LANES) {
        const __m512i place = _mm512_load_si512(box->place + t), from = _mm512_srai_epi32(place, 4);
        __m512 whole = _mm512_setzero_ps();
        for (int32_t s = 0; s * LANES < terms; ++s)
            whole = _mm512_mask_permutexvar_ps(whole, _mm512_cmpeq_epi32_mask(from, _mm512_set1_epi32(s)), place,
                                               _mm512_loadu_ps(sum + s * LANES));
        _mm512_mask_storeu_ps(moments + t, (__mmask16)(terms - t < LANES ? (1 << (terms - t)) - 1 : 0xffff), whole);
    }
#else
    for (ptrdiff_t t = 0; t < terms; ++t) moments[t] = sum[box->place[t]];
#endif
}

/* Moments are even terms, then odd ones, until all light has come through. */
TY_INLINE void put_moments(const ty_sweep_box* box, const ty_sweep_block* block, float* sum, float* moments,
                           const ptrdiff_t bands) {
    const ptrdiff_t cells = box->size[0], terms = bands * bands, items = terms * cells;
    close_up(sum, cells, bands);
    if (block->first) {
        memcpy(moments, sum, sizeof *moments * (size_t)items);
    } else if (block->last) {
#pragma omp simd
        for (ptrdiff_t i = 0; i < items; ++i) sum[i] += moments[i];
        for (ptrdiff_t x = 0; x < cells; ++x) order_cell(box, sum + x * terms, moments + x * terms, terms);
    } else {
#pragma omp simd
        for (ptrdiff_t i = 0; i < items; ++i) moments[i] += sum[i];
    }
}

/* ---- rows ---- */

/* What all rows of a sweep share. */
typedef struct row_work {
    const ty_sweep_box* box;
    const float* emission;
    float* moments;
    row_scratch scratch;
    ty_sweep_sums* sums;
    const ty_sweep_block* block;
} row_work;

TY_INLINE void cross_row(const row_work* work, int32_t octant, int32_t y, int32_t z, const int32_t bands) {
    const ty_sweep_box* box = work->box;
    const row_scratch* scratch = &work->scratch;
    const ptrdiff_t nx = box->size[0], ny = box->size[1], nz = box->size[2], row = (z * ny + y) * nx;
    const ptrdiff_t pitch = (ptrdiff_t)box->groups * LANES;
    const int32_t terms = bands * bands;
    for (int32_t g = 0; g < box->groups; ++g) {
        const emission_view view = {box, box->harmonics[octant / 2] + g * LANES, pitch};
        emit(&view, work->emission + row * terms, scratch->light[0], scratch->light[1], bands);
        stream streams[2];
        for (int o = 0; o < 2; ++o)
            streams[o] = (stream){.along = load(box->inflow[octant + o] + g * LANES),
                                  .light = scratch->light[o],
                                  .face_y = box->faces_y[octant + o] + (g * nz + z) * nx * LANES,
                                  .face_z = box->faces_z[octant + o] + (g * ny + y) * nx * LANES};
        const row_walls walls = walls_of(box, g, octant, z * ny + y);
        if (walls.first < walls.end) {
            advance_walls(&walls, box->extinction + row, scratch, streams, work->sums);
        } else {
            advance(box, g, box->extinction + row, scratch, 0, (int32_t)nx, streams, work->sums);
            add_leaving(box, g, streams[0].along + streams[1].along, work->sums);
        }
        mirror(scratch, (int32_t)nx);
        gather(box, g, octant, scratch, bands);
    }
    put_moments(box, work->block, scratch->sum, work->moments + row * terms, bands);
}

/* A row of as many terms as the usual numbers of bands have: loops over them have no ends to look for, and addresses
 * of cells are constants. */
static void cross_any(const row_work* work, int32_t octant, int32_t y, int32_t z) {
    switch (work->box->terms) {
    case 1: cross_row(work, octant, y, z, 1); return;
    case 4: cross_row(work, octant, y, z, 2); return;
    case 9: cross_row(work, octant, y, z, 3); return;
    case 16: cross_row(work, octant, y, z, 4); return;
    case 25: cross_row(work, octant, y, z, 5); return;
    case 36: cross_row(work, octant, y, z, 6); return;
    default: cross_row(work, octant, y, z, 2 * work->box->even - work->box->terms);
    }
}

static void cross(const ty_sweep_box* box, const ty_sweep_block* block, const float* emission, float* moments,
                  float* scratch, ty_sweep_sums* sums) {
    const row_work work = {box, emission, moments, lay_out(box, scratch), sums, block};
    const bool down_y = (block->pair & 1) != 0, down_z = (block->pair & 2) != 0;
    const int32_t count_y = block->end[0] - block->begin[0], count_z = block->end[1] - block->begin[1];
    for (int32_t k = 0; k < count_z; ++k)
        for (int32_t j = 0; j < count_y; ++j)
            cross_any(&work, 2 * block->pair, down_y ? block->end[0] - 1 - j : block->begin[0] + j,
                      down_z ? block->end[1] - 1 - k : block->begin[1] + k);
}

const ty_sweep_kernels TY_JOIN(ty_sweep_kernels_, TY_ISA) = {
    .lanes = LANES,
    .scratch = scratch_floats,
    .cross = cross,
};
