/* Light cache near walls: visibility between cells, and the light of cells inside walls. */
#include "base/context.h"
#include "bake/cache/lookup.k.h"

enum { AROUND = 27, ROW_CELLS = 64 };

typedef struct visibility_job {
    ty_bake_cache* cache;
    const ty_accel* mesh;
    uint8_t* flags_out; /* per cell: TY_CACHE_TEST_VISIBILITY, or 0 */
} visibility_job;

/* The i-th of the 27 cells around and including a cell; -1: outside of the lattice. */
static int64_t neighbour(const int32_t size[3], int64_t cell, int32_t i) {
    const int64_t x = cell % size[0] + i % 3 - 1, y = cell / size[0] % size[1] + i / 3 % 3 - 1,
                  z = cell / ((int64_t)size[0] * size[1]) + i / 9 - 1;
    if (x < 0 || y < 0 || z < 0 || x >= size[0] || y >= size[1] || z >= size[2]) return -1;
    return x + size[0] * (y + size[1] * z);
}

/* True if a cell and its neighbours have a single side and its center sees theirs: any point in it may use any of them.
 */
static bool is_open(const visibility_job* w, int64_t cell) {
    const ty_cache_view* view = &w->cache->view;
    const float* anchors = view->anchor;
    const ty_vec center = ty_vec_load(anchors + cell * (3 * TY_CACHE_SIDES));
    for (int32_t i = 0; i < AROUND; ++i) {
        const int64_t other = neighbour(view->size, cell, i);
        if (other >= 0 && view->flags[other] != 1) return false;
    }
    for (int32_t i = 0; i < AROUND && w->mesh != NULL; ++i) {
        const int64_t other = neighbour(view->size, cell, i);
        if (other >= 0 && !ty_cache_visible(w->mesh, center, ty_vec_load(anchors + other * (3 * TY_CACHE_SIDES))))
            return false;
    }
    return true;
}

static void test_cells(void* user, int64_t row, int32_t worker) {
    (void)worker;
    const visibility_job* w = user;
    const int64_t begin = row * ROW_CELLS, cells = (int64_t)w->cache->cells;
    for (int64_t i = begin; i < begin + ROW_CELLS && i < cells; ++i)
        w->flags_out[i] = is_open(w, i) ? 0 : TY_CACHE_TEST_VISIBILITY;
}

/* Takes the mean light of the neighbouring cells. */
static void inpaint_cell(ty_cache_view* view, int64_t cell) {
    const size_t floats = (size_t)(TY_CACHE_KINDS * view->floats);
    float* out = view->light + (size_t)cell * floats;
    int32_t count = 0;
    for (int32_t i = 0; i < AROUND; ++i) {
        const int64_t other = neighbour(view->size, cell, i);
        if (other < 0 || (view->flags[other] & 1) == 0) continue;
        for (size_t f = 0; f < floats; ++f) out[f] += view->light[(size_t)other * floats + f];
        ++count;
    }
    for (size_t f = 0; f < floats && count > 0; ++f) out[f] /= (float)count;
}

ty_result ty_cache_find_visibility(ty_bake_cache* cache, const ty_accel* mesh) {
    visibility_job w = {.cache = cache, .mesh = mesh};
    w.flags_out = ty_alloc_array(cache->context, cache->cells, 1, false);
    if (w.flags_out == NULL) return TY_ERROR_MEMORY;
    const int64_t rows = ((int64_t)cache->cells + ROW_CELLS - 1) / ROW_CELLS;
    ty_parallel_for(cache->context, rows, test_cells, &w);
    for (size_t i = 0; i < cache->cells; ++i) {
        if (cache->flags[i] == 0) inpaint_cell(&cache->view, (int64_t)i);
        cache->flags[i] |= w.flags_out[i];
    }
    ty_free_array(cache->context, w.flags_out, cache->cells, 1);
    return TY_OK;
}
