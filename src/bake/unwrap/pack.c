/* Packing: rectangles from the highest to the lowest, each where the skyline lets it lie lowest. */
#include "base/context.h"
#include "bake/unwrap/unwrap.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { WIDTHS = 8 };

typedef struct entry {
    int32_t height, width, index;
} entry;

static int compare_entries(const void* a, const void* b) {
    const entry *p = a, *q = b;
    if (p->height != q->height) return p->height > q->height ? -1 : 1;
    if (p->width != q->width) return p->width > q->width ? -1 : 1;
    return p->index < q->index ? -1 : p->index > q->index;
}

/* Places all of them in a map of this width; the height that they need. */
static int32_t place(ty_unwrap_rectangle* rectangles, const entry* entries, int32_t count, int32_t width,
                     int32_t* skyline) {
    int32_t height = 0;
    memset(skyline, 0, (size_t)width * sizeof *skyline);
    for (int32_t i = 0; i < count; ++i) {
        ty_unwrap_rectangle* r = &rectangles[entries[i].index];
        int32_t smallest = INT32_MAX;
        for (int32_t x = 0; x + r->width <= width;) {
            int32_t top = 0, highest = x;
            for (int32_t k = x; k < x + r->width && top < smallest; ++k)
                if (skyline[k] >= top) {
                    top = skyline[k];
                    highest = k;
                }
            if (top < smallest) {
                smallest = top;
                r->x = x;
                r->y = top;
            }
            x = highest + 1; /* left of it the rectangle would lie as high */
        }
        for (int32_t k = r->x; k < r->x + r->width; ++k) skyline[k] = r->y + r->height;
        height = r->y + r->height > height ? r->y + r->height : height;
    }
    return height;
}

ty_result ty_unwrap_pack(ty_context* context, ty_unwrap_rectangle* rectangles, int32_t count, int32_t* width,
                         int32_t* height) {
    double area = 0;
    int32_t widest = 1;
    entry* entries = ty_alloc_array(context, (size_t)count, sizeof *entries, false);
    if (entries == NULL) return TY_ERROR_MEMORY;
    for (int32_t i = 0; i < count; ++i) {
        entries[i] = (entry){rectangles[i].height, rectangles[i].width, i};
        area += (double)rectangles[i].width * rectangles[i].height;
        widest = rectangles[i].width > widest ? rectangles[i].width : widest;
    }
    qsort(entries, (size_t)count, sizeof *entries, compare_entries);
    /* Of several widths about the root of the area, the one with the smallest area. */
    const int32_t largest = (int32_t)ceil(1.5 * sqrt(area)) > widest ? (int32_t)ceil(1.5 * sqrt(area)) : widest;
    int32_t* skyline = ty_alloc_array(context, (size_t)largest, sizeof *skyline, false);
    double smallest = INFINITY;
    int32_t best = widest;
    for (int i = 0; i <= WIDTHS && skyline != NULL; ++i) {
        const bool last = i == WIDTHS; /* places them again */
        const int32_t wanted = (int32_t)ceil(sqrt(area) * (1 + 0.5 * i / WIDTHS));
        const int32_t tried = last ? best : wanted > widest ? wanted : widest;
        const int32_t needed = place(rectangles, entries, count, tried, skyline);
        if (!last && (double)tried * needed < smallest) {
            smallest = (double)tried * needed;
            best = tried;
        }
        *width = tried;
        *height = needed;
    }
    const ty_result result = skyline == NULL ? TY_ERROR_MEMORY : TY_OK;
    if (skyline != NULL) ty_free_array(context, skyline, (size_t)largest, sizeof *skyline);
    ty_free_array(context, entries, (size_t)count, sizeof *entries);
    return result;
}
