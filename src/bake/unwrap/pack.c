/* Packing: the texels of charts, from the longest chart to the shortest, each in one of four turns where it lies lowest
 * between those that are there. */
#include "base/context.h"
#include "bake/unwrap/unwrap.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { TURNS = 4, WIDTHS = 4, MANY_CHARTS = 1024, SIDE_CELLS = 1024, WORD = 64 };

/* Cells of a row that a chart needs. */
typedef struct run {
    int32_t row, begin, end;
} run;

typedef struct shape {
    int32_t width[TURNS], height[TURNS]; /* cells */
    int32_t first[TURNS], count[TURNS];  /* its runs */
    int64_t cells;
    int32_t index;
} shape;

typedef struct packer {
    ty_context* context;
    const float* flat;
    ty_unwrap_chart* charts;
    int32_t count;
    double density;
    int32_t margin, unit; /* texels around a chart; texels a cell is wide */
    shape* shapes;        /* by length */
    run* runs;
    int32_t run_count, run_capacity;
    uint64_t* map; /* rows of cells that are taken */
    int32_t *taken, words, rows;
} packer;

/* ---- Shapes ---- */

void ty_unwrap_turn(const ty_unwrap_chart* chart, int32_t turns, double density, const float at[2], double out[2]) {
    const double x = density * ((double)at[0] - (double)chart->low[0]),
                 y = density * ((double)at[1] - (double)chart->low[1]);
    const double w = density * ((double)chart->high[0] - (double)chart->low[0]),
                 h = density * ((double)chart->high[1] - (double)chart->low[1]);
    out[0] = turns == 0 ? x : turns == 1 ? h - y : turns == 2 ? w - x : y;
    out[1] = turns == 0 ? y : turns == 1 ? x : turns == 2 ? h - y : w - x;
}

/* The range in x of a triangle between two heights; false: it is not there. */
static bool range_between(double p[3][2], double low, double high, double range[2]) {
    range[0] = INFINITY;
    range[1] = -INFINITY;
    for (int k = 0; k < 3; ++k) {
        const double *a = p[k], *b = p[(k + 1) % 3];
        for (int end = 0; end < 3; ++end) { /* a corner, and where its edge enters and leaves */
            const double level = end == 1 ? low : high;
            double x = a[0];
            if (end == 0) {
                if (a[1] < low || a[1] > high) continue;
            } else {
                if ((a[1] - level) * (b[1] - level) >= 0) continue;
                x = a[0] + (b[0] - a[0]) * (level - a[1]) / (b[1] - a[1]);
            }
            range[0] = fmin(range[0], x);
            range[1] = fmax(range[1], x);
        }
    }
    return range[0] <= range[1];
}

/* Marks the cells of a triangle and of a square of half a texel and the margin around each of its points. */
static void mark(const packer* k, double p[3][2], int32_t width, int32_t height, uint8_t* cells) {
    static const double rounding = 1e-4;
    const double around = 2 * k->margin + 1, unit = k->unit;
    const double lowest = fmin(fmin(p[0][1], p[1][1]), p[2][1]), highest = fmax(fmax(p[0][1], p[1][1]), p[2][1]);
    const int32_t last = (int32_t)((highest + around - rounding) / unit);
    double range[2];
    for (int32_t y = (int32_t)fmax(lowest / unit, 0); y <= last && y < height; ++y) {
        if (!range_between(p, y * unit - around + rounding, (y + 1) * unit - rounding, range)) continue;
        const int32_t end = (int32_t)((range[1] + around - rounding) / unit);
        for (int32_t x = (int32_t)fmax(range[0] / unit, 0); x <= end && x < width; ++x)
            cells[(size_t)y * (size_t)width + (size_t)x] = 1;
    }
}

static ty_result add_run(packer* k, run added) {
    if (k->run_count == k->run_capacity) {
        const int32_t capacity = 2 * k->run_capacity + 256;
        run* runs = ty_alloc_array(k->context, (size_t)capacity, sizeof *runs, false);
        if (runs == NULL) return TY_ERROR_MEMORY;
        if (k->runs != NULL) {
            memcpy(runs, k->runs, (size_t)k->run_count * sizeof *runs);
            ty_free_array(k->context, k->runs, (size_t)k->run_capacity, sizeof *runs);
        }
        k->runs = runs;
        k->run_capacity = capacity;
    }
    k->runs[k->run_count++] = added;
    return TY_OK;
}

static ty_result find_runs(packer* k, const uint8_t* cells, shape* s, int turns) {
    ty_result result = TY_OK;
    s->first[turns] = k->run_count;
    for (int32_t y = 0; y < s->height[turns]; ++y)
        for (int32_t x = 0, end; x < s->width[turns] && result == TY_OK; x = end) {
            const uint8_t* row = cells + (size_t)y * (size_t)s->width[turns];
            for (end = x + 1; end < s->width[turns] && row[end] == row[x];) ++end;
            if (row[x] != 0) result = add_run(k, (run){y, x, end});
            if (row[x] != 0 && turns == 0) s->cells += end - x;
        }
    s->count[turns] = k->run_count - s->first[turns];
    return result;
}

static ty_result make_shape(packer* k, const ty_unwrap_chart* chart, int turns, shape* s) {
    double size[2], p[3][2];
    for (int b = 0; b < 2; ++b) size[(b + turns) % 2] = k->density * ((double)chart->high[b] - (double)chart->low[b]);
    for (int b = 0; b < 2; ++b) size[b] = fmax(size[b], 0) + 2 * k->margin + 1;
    s->width[turns] = (int32_t)((size[0] - 1e-4) / k->unit) + 1;
    s->height[turns] = (int32_t)((size[1] - 1e-4) / k->unit) + 1;
    const size_t cells = (size_t)s->width[turns] * (size_t)s->height[turns];
    uint8_t* marked = ty_alloc_array(k->context, cells, 1, true);
    if (marked == NULL) return TY_ERROR_MEMORY;
    for (int64_t i = 0; i < chart->count; ++i) {
        const float* at = k->flat + 6 * (size_t)chart->triangles[i];
        for (int c = 0; c < 3; ++c) ty_unwrap_turn(chart, turns, k->density, at + 2 * c, p[c]);
        mark(k, p, s->width[turns], s->height[turns], marked);
    }
    const ty_result result = find_runs(k, marked, s, turns);
    ty_free_array(k->context, marked, cells, 1);
    return result;
}

static int compare_shapes(const void* a, const void* b) {
    const shape *p = a, *q = b;
    const int32_t m = p->width[0] > p->height[0] ? p->width[0] : p->height[0],
                  n = q->width[0] > q->height[0] ? q->width[0] : q->height[0];
    if (m != n) return m > n ? -1 : 1;
    if (p->cells != q->cells) return p->cells > q->cells ? -1 : 1;
    return p->index < q->index ? -1 : p->index > q->index;
}

/* ---- Places ---- */

/* The last taken cell of a row in begin .. end - 1; -1: there is none. */
static int32_t last_taken(const uint64_t* row, int32_t begin, int32_t end) {
    for (int32_t word = (end - 1) / WORD; word >= begin / WORD; --word) {
        uint64_t bits = row[word];
        if (word == (end - 1) / WORD) bits &= ~0ULL >> (WORD - 1 - (end - 1) % WORD);
        if (word == begin / WORD) bits &= ~0ULL << begin % WORD;
        if (bits != 0) return word * WORD + (WORD - 1 - __builtin_clzll(bits));
    }
    return -1;
}

/* The first free place of a shape in a row of places; -1: there is none. */
static int32_t find_in_row(const packer* k, const shape* s, int turns, int32_t y, int32_t width) {
    const run* runs = k->runs + s->first[turns];
    for (int32_t x = 0; x + s->width[turns] <= width;) {
        int32_t next = x;
        for (int32_t i = 0; i < s->count[turns] && next == x; ++i) {
            const uint64_t* row = k->map + (size_t)(y + runs[i].row) * (size_t)k->words;
            const int32_t hit = last_taken(row, x + runs[i].begin, x + runs[i].end);
            if (hit >= 0) next = hit - runs[i].begin + 1; /* up to there the run would still hold that cell */
        }
        if (next == x) return x;
        x = next;
    }
    return -1;
}

static void take(packer* k, const shape* s, int turns, int32_t x, int32_t y) {
    for (int32_t i = 0; i < s->count[turns]; ++i) {
        const run* r = &k->runs[s->first[turns] + i];
        uint64_t* row = k->map + (size_t)(y + r->row) * (size_t)k->words;
        for (int32_t c = x + r->begin; c < x + r->end; ++c) row[c / WORD] |= 1ULL << c % WORD;
        k->taken[y + r->row] += r->end - r->begin;
    }
}

/* Places all shapes in a map of this width; the height that they need. */
static int32_t place_all(packer* k, int32_t width) {
    int32_t height = 0;
    memset(k->map, 0, (size_t)k->words * (size_t)k->rows * sizeof *k->map);
    memset(k->taken, 0, (size_t)k->rows * sizeof *k->taken);
    for (int32_t i = 0; i < k->count; ++i) {
        const shape* s = &k->shapes[i];
        int32_t top = INT32_MAX, at[3] = {0, 0, 0};
        for (int turns = 0; turns < TURNS; ++turns)
            for (int32_t y = 0; y + s->height[turns] < top; ++y) {
                const run* first = &k->runs[s->first[turns]];
                if (k->taken[y] + first->end - first->begin > width) continue;
                const int32_t x = find_in_row(k, s, turns, y, width);
                if (x < 0 && s->width[turns] <= width) continue;
                if (x < 0) break;
                top = y + s->height[turns];
                at[0] = x;
                at[1] = y;
                at[2] = turns;
            }
        take(k, s, at[2], at[0], at[1]);
        k->charts[s->index].turns = at[2];
        k->charts[s->index].x = at[0] * k->unit;
        k->charts[s->index].y = at[1] * k->unit;
        height = top > height ? top : height;
    }
    return height;
}

static ty_result search(packer* k, int32_t widest, double area, int32_t* width, int32_t* height) {
    const int32_t largest = (int32_t)fmax(ceil(1.3 * sqrt(area)), widest) + 1;
    k->words = largest / WORD + 1;
    k->map = ty_alloc_array(k->context, (size_t)k->words * (size_t)k->rows, sizeof *k->map, false);
    k->taken = ty_alloc_array(k->context, (size_t)k->rows, sizeof *k->taken, false);
    ty_result result = k->map == NULL || k->taken == NULL ? TY_ERROR_MEMORY : TY_OK;
    const int widths = k->count > MANY_CHARTS ? 1 : WIDTHS;
    double smallest = INFINITY;
    int32_t best = widest;
    for (int i = 0; i <= widths && result == TY_OK; ++i) { /* and once more at the best width */
        const int32_t wanted = (int32_t)ceil(sqrt(area) * (1 + 0.08 * i));
        const int32_t tried = i == widths ? best : wanted > widest ? wanted : widest;
        if (i == widths && widths == 1) break;
        const int32_t needed = place_all(k, tried);
        if (i < widths && (double)tried * needed < smallest) {
            smallest = (double)tried * needed;
            best = tried;
        }
        *width = tried * k->unit;
        *height = needed * k->unit;
    }
    if (k->map != NULL) ty_free_array(k->context, k->map, (size_t)k->words * (size_t)k->rows, sizeof *k->map);
    if (k->taken != NULL) ty_free_array(k->context, k->taken, (size_t)k->rows, sizeof *k->taken);
    return result;
}

ty_result ty_unwrap_pack(ty_context* context, const float* flat, ty_unwrap_chart* charts, int32_t count, double density,
                         int32_t padding, int32_t* width, int32_t* height) {
    packer k = {context, flat, charts, count, density, (padding + 1) / 2, 1, NULL, NULL, 0, 0, NULL, NULL, 0, 1};
    double boxes = 0, area = 0;
    int32_t widest = 1;
    for (int32_t i = 0; i < count; ++i)
        boxes += (density * (double)(charts[i].high[0] - charts[i].low[0]) + 2 * k.margin + 1) *
                 (density * (double)(charts[i].high[1] - charts[i].low[1]) + 2 * k.margin + 1);
    k.unit = (int32_t)fmax(1, ceil(sqrt(boxes) / SIDE_CELLS));
    k.shapes = ty_alloc_array(context, (size_t)count, sizeof *k.shapes, true);
    ty_result result = k.shapes == NULL ? TY_ERROR_MEMORY : TY_OK;
    for (int32_t i = 0; i < count && result == TY_OK; ++i) {
        shape* s = &k.shapes[i];
        s->index = i;
        for (int turns = 0; turns < TURNS && result == TY_OK; ++turns) result = make_shape(&k, &charts[i], turns, s);
        const int32_t narrow = s->width[0] < s->height[0] ? s->width[0] : s->height[0];
        widest = narrow > widest ? narrow : widest;
        area += (double)s->cells;
        k.rows += s->height[0] > s->width[0] ? s->height[0] : s->width[0];
    }
    if (result == TY_OK) {
        qsort(k.shapes, (size_t)count, sizeof *k.shapes, compare_shapes);
        result = search(&k, widest, 1.05 * area, width, height);
    }
    if (k.runs != NULL) ty_free_array(context, k.runs, (size_t)k.run_capacity, sizeof *k.runs);
    if (k.shapes != NULL) ty_free_array(context, k.shapes, (size_t)count, sizeof *k.shapes);
    return result;
}
