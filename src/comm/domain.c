#define _GNU_SOURCE
#include "comm/domain.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* Tag of the faces that cross a cut towards the lower side, and + 1 towards the upper one. */
enum { TAG_OF_FACES = 16 };

/* ---- cuts ---- */

/* First cell of place p of so many ranks: their units are as equal as they can be, the first ones have more. */
static int32_t first_cell(int32_t cells, int32_t unit, int32_t ranks, int32_t p) {
    if (p == ranks) return cells;
    const int32_t units = (cells + unit - 1) / unit, rest = units % ranks;
    return unit * (units / ranks * p + (p < rest ? p : rest));
}

/* Cells of the largest box along an axis, with the layers beyond its cuts; 0: some box has fewer than `min_cells`. */
static int32_t largest(int32_t cells, int32_t unit, int32_t ranks, int32_t min_cells) {
    if (ranks == 1) return cells;
    int32_t max_size = 0;
    for (int32_t p = 0; p < ranks; ++p) {
        const int32_t size = first_cell(cells, unit, ranks, p + 1) - first_cell(cells, unit, ranks, p);
        const int32_t all = size + (p > 0 ? 1 : 0) + (p + 1 < ranks ? 1 : 0);
        if (size < min_cells || size < 1) return 0;
        if (all > max_size) max_size = all;
    }
    return max_size;
}

/* Cells of the largest box of a way to share the ranks; 0: that way is not open. */
static int64_t cost(const ty_domain* domain, const int32_t ranks[3], unsigned cuts, int32_t min_cells) {
    int64_t cells = 1;
    for (int axis = 0; axis < 3; ++axis) {
        if (ranks[axis] > 1 && (cuts >> axis & 1) == 0) return 0;
        cells *= largest(domain->cells[axis], domain->unit[axis], ranks[axis], min_cells);
    }
    return cells;
}

static bool share_ranks(ty_domain* domain, int32_t size, unsigned cuts, int32_t min_cells) {
    int64_t best = 0;
    for (int32_t x = 1; x <= size; ++x)
        for (int32_t y = 1; y <= size / x; ++y) {
            const int32_t ranks[3] = {x, y, size / x / y};
            if (ranks[0] * ranks[1] * ranks[2] != size) continue;
            const int64_t now = cost(domain, ranks, cuts, min_cells);
            if (now == 0 || (best > 0 && now >= best)) continue;
            best = now;
            memcpy(domain->ranks, ranks, sizeof ranks);
        }
    return best > 0;
}

bool ty_domain_create(ty_comm* comm, const int32_t cells[3], unsigned cuts, const int32_t unit[3], int32_t min_cells,
                      ty_domain* out) {
    *out = (ty_domain){.comm = comm};
    memcpy(out->cells, cells, sizeof out->cells);
    memcpy(out->unit, unit, sizeof out->unit);
    if (!share_ranks(out, ty_comm_size(comm), cuts, min_cells)) return false;
    ty_domain_place(out, ty_comm_rank(comm), out->at);
    for (int axis = 0; axis < 3; ++axis) {
        out->first[axis] = ty_domain_first(out, axis, out->at[axis]);
        out->end[axis] = ty_domain_first(out, axis, out->at[axis] + 1);
    }
    return true;
}

void ty_domain_destroy(ty_domain* domain) {
    free(domain->buffer);
    domain->buffer = NULL;
    domain->capacity = 0;
}

int32_t ty_domain_first(const ty_domain* domain, int axis, int32_t p) {
    return first_cell(domain->cells[axis], domain->unit[axis], domain->ranks[axis], p);
}

void ty_domain_place(const ty_domain* domain, int32_t rank, int32_t at[3]) {
    at[0] = rank % domain->ranks[0];
    at[1] = rank / domain->ranks[0] % domain->ranks[1];
    at[2] = rank / domain->ranks[0] / domain->ranks[1];
}

int32_t ty_domain_rank(const ty_domain* domain, const int32_t at[3]) {
    return (at[2] * domain->ranks[1] + at[1]) * domain->ranks[0] + at[0];
}

int32_t ty_domain_neighbour(const ty_domain* domain, int side) {
    int32_t at[3] = {domain->at[0], domain->at[1], domain->at[2]};
    const int axis = side / 2;
    at[axis] += (side & 1) != 0 ? 1 : -1;
    return at[axis] < 0 || at[axis] >= domain->ranks[axis] ? -1 : ty_domain_rank(domain, at);
}

bool ty_domain_is_cut(const ty_domain* domain, int axis) {
    return domain->ranks[axis] > 1;
}

/* ---- faces ---- */

/* The items of a layer: [first, end) along each axis. */
typedef struct layer {
    int32_t first[3], end[3];
} layer;

/* The layer at index `at` along an axis, with those beyond the cuts of the axes before. */
static layer layer_at(const ty_domain* domain, const int32_t size[3], int axis, int32_t at) {
    layer l = {{0, 0, 0}, {size[0], size[1], size[2]}};
    for (int a = 0; a < axis; ++a) {
        l.first[a] -= ty_domain_neighbour(domain, 2 * a) >= 0;
        l.end[a] += ty_domain_neighbour(domain, 2 * a + 1) >= 0;
    }
    l.first[axis] = at;
    l.end[axis] = at + 1;
    return l;
}

static size_t layer_items(const layer* l) {
    size_t items = 1;
    for (int a = 0; a < 3; ++a) items *= (size_t)(l->end[a] - l->first[a]);
    return items;
}

/* Copies a row of items between a box and a message. */
static void copy_row(const ty_halo* halo, char* row, int32_t count, char* message, bool out) {
    const size_t step = halo->item * (size_t)halo->stride[0];
    if (halo->stride[0] == 1 || count == 1) {
        memcpy(out ? message : row, out ? row : message, halo->item * (size_t)count);
        return;
    }
    for (int32_t i = 0; i < count; ++i, row += step, message += halo->item)
        memcpy(out ? message : row, out ? row : message, halo->item);
}

/* Copies the items of a layer; returns the end of them in the message. */
static char* copy_layer(const ty_halo* halo, const layer* l, char* message, bool out) {
    const int32_t count = l->end[0] - l->first[0];
    for (int32_t z = l->first[2]; z < l->end[2]; ++z)
        for (int32_t y = l->first[1]; y < l->end[1]; ++y) {
            const ptrdiff_t at = halo->stride[0] * l->first[0] + halo->stride[1] * y + halo->stride[2] * z;
            copy_row(halo, (char*)halo->origin + at * (ptrdiff_t)halo->item, count, message, out);
            message += halo->item * (size_t)count;
        }
    return message;
}

/* As in ty_buffer_add: without memory the program ends, since the neighbours wait for the message. */
static void reserve(ty_domain* domain, size_t bytes) {
    if (bytes <= domain->capacity) return;
    free(domain->buffer);
    domain->buffer = malloc(bytes);
    domain->capacity = bytes;
    if (domain->buffer != NULL) return;
    fputs("tyndall: not enough memory for a message to another rank\n", stderr);
    _exit(1);
}

/* Sends the outermost layers along an axis, and receives those of the neighbours. */
static bool exchange_axis(ty_domain* domain, const int32_t size[3], const ty_halo* halos, int32_t count, int axis) {
    size_t item = 0;
    for (int32_t i = 0; i < count; ++i) item += halos[i].item;
    const layer first = layer_at(domain, size, axis, 0);
    const size_t bytes = item * layer_items(&first);
    reserve(domain, 4 * bytes);
    ty_comm_transfer transfers[4];
    int32_t made = 0;
    for (int upper = 0; upper < 2; ++upper) {
        const int32_t neighbour = ty_domain_neighbour(domain, 2 * axis + upper);
        if (neighbour < 0) continue;
        const layer l = layer_at(domain, size, axis, upper != 0 ? size[axis] - 1 : 0);
        char *in = domain->buffer + (size_t)(2 * upper) * bytes, *out = in + bytes, *at = out;
        for (int32_t i = 0; i < count; ++i) at = copy_layer(&halos[i], &l, at, true);
        transfers[made++] = (ty_comm_transfer){
            .rank = neighbour, .tag = TAG_OF_FACES + 1 - upper, .bytes = in, .size = bytes, .receives = true};
        transfers[made++] =
            (ty_comm_transfer){.rank = neighbour, .tag = TAG_OF_FACES + upper, .bytes = out, .size = bytes};
    }
    domain->halos.messages += (uint64_t)made;
    domain->halos.bytes += (uint64_t)made * bytes;
    if (!ty_comm_post(domain->comm, transfers, made) || !ty_comm_finish(domain->comm, transfers, made)) return false;
    for (int upper = 0; upper < 2; ++upper) {
        if (ty_domain_neighbour(domain, 2 * axis + upper) < 0) continue;
        const layer l = layer_at(domain, size, axis, upper != 0 ? size[axis] : -1);
        char* at = domain->buffer + (size_t)(2 * upper) * bytes;
        for (int32_t i = 0; i < count; ++i) at = copy_layer(&halos[i], &l, at, false);
    }
    return true;
}

bool ty_domain_exchange(ty_domain* domain, const int32_t size[3], const ty_halo* halos, int32_t count) {
    for (int axis = 0; axis < 3; ++axis)
        if (ty_domain_is_cut(domain, axis) && !exchange_axis(domain, size, halos, count, axis)) return false;
    return true;
}
