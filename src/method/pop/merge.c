/* All ordinates' light in one grid, block by block: what a block needs of a light stays in the caches. */
#include "base/isa.h"
#include "base/parallel.h"
#include "method/pop/merge.h"
#include "method/pop/merge_kernel.h"

enum { SIDE = 4, ROWS = SIDE * SIDE, LEFT = 4 };

const ty_pop_merge_kernels* ty_pop_merge_kernels_best(void) {
#if TY_ISA_X86
    static const ty_pop_merge_kernels* const kernels[TY_ISA_COUNT] = {
        &ty_pop_merge_kernels_v1, &ty_pop_merge_kernels_v3, &ty_pop_merge_kernels_v4};
    return kernels[ty_best_isa()];
#else
    return &ty_pop_merge_kernels_v1;
#endif
}

typedef struct work {
    const ty_pop_merge_kernels* kernels;
    const ty_pop_light* lights;
    int32_t count;
    ty_pop_merged* merged;
    int32_t runs, length; /* rows are cut into as many, of so many cells at most */
    int32_t blocks;       /* along y */
} work;

/* A block of up to SIDE x SIDE rows of cells from x0, y0, z0 on. */
typedef struct block {
    int32_t lower[3], size[3];
    _Alignas(64) float sums[ROWS][TY_POP_MERGE_RUN * TY_POP_MERGE_SUMS];
    float left[ROWS][TY_POP_MERGE_RUN * LEFT];
} block;

static float middle(const ty_grid_box* box, int axis, int32_t cell) {
    const double step = (box->upper[axis] - box->lower[axis]) / box->size[axis];
    return (float)(box->lower[axis] + (cell + 0.5) * step);
}

static void add_light(const work* w, const ty_pop_light* light, block* b) {
    const ty_grid_box* box = &w->merged->box;
    for (int32_t row = 0; row < b->size[1] * b->size[2]; ++row) {
        const int32_t y = b->lower[1] + row % b->size[1], z = b->lower[2] + row / b->size[1];
        const ty_pop_merge_row cells = {
            .count = b->size[0],
            .first = ty_vec_make(middle(box, 0, b->lower[0]), middle(box, 1, y), middle(box, 2, z)),
            .step = (float)((box->upper[0] - box->lower[0]) / box->size[0]),
            .sums = b->sums[row],
            .left = w->merged->left[0] != NULL ? b->left[row] : NULL,
        };
        w->kernels->merge(light, &cells);
    }
}

static void add_row(const float* sums, int32_t stride, int32_t place, int32_t count, float* out) {
    for (int32_t n = 0; n < count; ++n) out[n] += sums[n * stride + place];
}

/* Where a channel's flux along x, y and z is among a cell's sums. */
static int32_t flux_place(int axis, int channel) {
    return axis == 2 && channel == 2 ? 6 : 8 + 3 * axis + channel;
}

static void add_block(const block* b, ty_pop_merged* merged) {
    const int32_t* size = merged->box.size;
    for (int32_t row = 0; row < b->size[1] * b->size[2]; ++row) {
        const int32_t y = b->lower[1] + row % b->size[1], z = b->lower[2] + row / b->size[1];
        const size_t first = ((size_t)z * (size_t)size[1] + (size_t)y) * (size_t)size[0] + (size_t)b->lower[0];
        for (int c = 0; c < 3; ++c) {
            add_row(b->sums[row], TY_POP_MERGE_SUMS, c, b->size[0], merged->seen[c] + first);
            add_row(b->sums[row], TY_POP_MERGE_SUMS, 3 + c, b->size[0], merged->fluence[c] + first);
            if (merged->left[c] != NULL) add_row(b->left[row], LEFT, c, b->size[0], merged->left[c] + first);
            for (int a = 0; a < 3 && merged->flux[c][a] != NULL; ++a)
                add_row(b->sums[row], TY_POP_MERGE_SUMS, flux_place(a, c), b->size[0], merged->flux[c][a] + first);
        }
    }
}

static int32_t least(int32_t a, int32_t b) {
    return a < b ? a : b;
}

static void merge_block(void* user, int64_t index, int32_t worker) {
    const work* w = user;
    const int32_t* size = w->merged->box.size;
    const int32_t run = (int32_t)(index % w->runs), rest = (int32_t)(index / w->runs);
    block b = {.lower = {run * w->length, rest % w->blocks * SIDE, rest / w->blocks * SIDE}};
    (void)worker;
    b.size[0] = least(w->length, size[0] - b.lower[0]);
    for (int a = 1; a < 3; ++a) b.size[a] = least(SIDE, size[a] - b.lower[a]);
    for (int32_t l = 0; l < w->count; ++l) add_light(w, &w->lights[l], &b);
    add_block(&b, w->merged);
}

void ty_pop_merge(ty_context* context, const ty_pop_light* lights, int32_t count, ty_pop_merged* merged) {
    const int32_t* size = merged->box.size;
    work w = {ty_pop_merge_kernels_best(), lights, count, merged, 0, 0, (size[1] + SIDE - 1) / SIDE};
    const int32_t runs = (size[0] + TY_POP_MERGE_RUN - 1) / TY_POP_MERGE_RUN;
    w.length = (size[0] + runs - 1) / runs;
    w.runs = (size[0] + w.length - 1) / w.length;
    const int64_t slabs = (size[2] + SIDE - 1) / SIDE;
    ty_parallel_flushed(context, slabs * w.blocks * w.runs, merge_block, &w);
}
