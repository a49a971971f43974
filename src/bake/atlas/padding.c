/* Exact nearest valid texel: a scan along columns, then along rows over the column results. */
#include "base/context.h"
#include "bake/atlas/atlas.h"

enum { NONE = 127, COLUMNS = 64 };

typedef struct padder {
    const ty_atlas* atlas;
    int32_t reach;
    int8_t* up; /* per texel: signed rows to the nearest valid texel of its column */
    int32_t* source;
} padder;

static void scan_columns(const padder* work, int32_t low, int32_t high, bool down) {
    const ty_atlas* atlas = work->atlas;
    const size_t width = (size_t)atlas->width;
    for (int32_t row = 0; row < atlas->height; ++row) {
        const int32_t y = down ? row : atlas->height - 1 - row;
        for (int32_t x = low; x < high; ++x) {
            const size_t texel = (size_t)y * width + (size_t)x;
            int32_t found = atlas->receiver[texel] >= 0 ? 0 : NONE;
            const size_t last = down ? texel - width : texel + width;
            if (found != 0 && row > 0 && work->up[last] != NONE) found = work->up[last] + (down ? -1 : 1);
            if (found > work->reach || found < -work->reach) found = NONE;
            /* the second scan keeps the result of the first if it is no farther */
            const int32_t first = down ? NONE : work->up[texel];
            work->up[texel] = (int8_t)(first != NONE && -first <= found ? first : found);
        }
    }
}

static void pad_columns(void* user, int64_t index, int32_t worker) {
    (void)worker;
    const padder* work = user;
    const int32_t low = (int32_t)index * COLUMNS, width = work->atlas->width;
    const int32_t high = low + COLUMNS < width ? low + COLUMNS : width;
    scan_columns(work, low, high, true);
    scan_columns(work, low, high, false);
}

static void pad_row(void* user, int64_t index, int32_t worker) {
    (void)worker;
    const padder* work = user;
    const int32_t width = work->atlas->width;
    const int8_t* up = work->up + (size_t)index * (size_t)width;
    for (int32_t x = 0; x < width; ++x) {
        int32_t min_square = INT32_MAX, source = -1;
        for (int32_t offset = 0; offset <= work->reach && offset * offset < min_square; ++offset)
            for (int32_t side = x - offset;; side = x + offset) {
                const int32_t rows = side >= 0 && side < width ? up[side] : NONE;
                const int32_t square = offset * offset + rows * rows;
                if (rows != NONE && square < min_square) {
                    min_square = square;
                    source = ((int32_t)index + rows) * width + side;
                }
                if (side == x + offset) break;
            }
        work->source[(size_t)index * (size_t)width + (size_t)x] = source;
    }
}

ty_result ty_atlas_pad(const ty_atlas* atlas, int32_t reach, int32_t* source) {
    const size_t texels = ty_atlas_texels(atlas);
    padder work = {.atlas = atlas, .reach = reach, .source = source};
    work.up = ty_alloc_array(atlas->context, texels, sizeof *work.up, false);
    if (work.up == NULL) return TY_ERROR_MEMORY;
    ty_parallel_for(atlas->context, (atlas->width + COLUMNS - 1) / COLUMNS, pad_columns, &work);
    ty_parallel_for(atlas->context, atlas->height, pad_row, &work);
    ty_free_array(atlas->context, work.up, texels, sizeof *work.up);
    return TY_OK;
}
