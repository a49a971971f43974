/* Light in cells of the media, near walls: which cells see each other, and what is known within walls. */
#include "base/context.h"
#include "bake/cache_look.k.h"
#include "bake/gather.h"

enum { AROUND = 27, ROW_CELLS = 64 };

typedef struct walls {
    ty_bake_cache* cache;
    const ty_accel* mesh;
    uint8_t* cut; /* per cell: whether it cannot stand for what is around */
} walls;

/* The i-th of the cells around one and itself; -1: there is none. */
static int64_t neighbour(const int32_t size[3], int64_t cell, int32_t i) {
    const int64_t x = cell % size[0] + i % 3 - 1, y = cell / size[0] % size[1] + i / 3 % 3 - 1,
                  z = cell / ((int64_t)size[0] * size[1]) + i / 9 - 1;
    if (x < 0 || y < 0 || z < 0 || x >= size[0] || y >= size[1] || z >= size[2]) return -1;
    return x + size[0] * (y + size[1] * z);
}

/* A cell and all around it are whole, and its middle sees theirs: whoever is in it may look at any of them. */
static bool is_open(const walls* w, int64_t cell) {
    const ty_cache_view* view = &w->cache->view;
    const float* anchors = view->anchor;
    const ty_vec middle = ty_vec_load(anchors + cell * (3 * TY_CACHE_SIDES));
    for (int32_t i = 0; i < AROUND; ++i) {
        const int64_t other = neighbour(view->size, cell, i);
        if (other >= 0 && view->known[other] != 1) return false;
    }
    for (int32_t i = 0; i < AROUND && w->mesh != NULL; ++i) {
        const int64_t other = neighbour(view->size, cell, i);
        if (other >= 0 && !ty_cache_sees(w->mesh, middle, ty_vec_load(anchors + other * (3 * TY_CACHE_SIDES))))
            return false;
    }
    return true;
}

static void look_around(void* user, int64_t row, int32_t worker) {
    (void)worker;
    const walls* w = user;
    const int64_t begin = row * ROW_CELLS, cells = (int64_t)w->cache->cells;
    for (int64_t i = begin; i < begin + ROW_CELLS && i < cells; ++i) w->cut[i] = is_open(w, i) ? 0 : TY_CACHE_CUT;
}

/* The mean of what is known in the cells around one. */
static void take_around(ty_cache_view* view, int64_t cell) {
    const size_t floats = (size_t)(TY_CACHE_KINDS * view->floats);
    float* out = view->light + (size_t)cell * floats;
    int32_t count = 0;
    for (int32_t i = 0; i < AROUND; ++i) {
        const int64_t other = neighbour(view->size, cell, i);
        if (other < 0 || (view->known[other] & 1) == 0) continue;
        for (size_t f = 0; f < floats; ++f) out[f] += view->light[(size_t)other * floats + f];
        ++count;
    }
    for (size_t f = 0; f < floats && count > 0; ++f) out[f] /= (float)count;
}

ty_result ty_cache_part(ty_bake_cache* cache, const ty_accel* mesh) {
    walls w = {.cache = cache, .mesh = mesh};
    w.cut = ty_alloc_array(cache->context, cache->cells, 1, false);
    if (w.cut == NULL) return TY_ERROR_MEMORY;
    const int64_t rows = ((int64_t)cache->cells + ROW_CELLS - 1) / ROW_CELLS;
    ty_parallel_for(cache->context, rows, look_around, &w);
    for (size_t i = 0; i < cache->cells; ++i) {
        if (cache->known[i] == 0) take_around(&cache->view, (int64_t)i);
        cache->known[i] |= w.cut[i];
    }
    ty_free_array(cache->context, w.cut, cache->cells, 1);
    return TY_OK;
}
