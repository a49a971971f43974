#include "comm/regroup.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { TAG_OF_REGROUP = 24 };

/* Cells [first, end) along each axis. */
typedef struct cell_box {
    int32_t first[3], end[3];
} cell_box;

/* A rank's cells; grid: some domain of the grid. */
static cell_box box_of(const ty_domain* domain, const ty_domain* grid, int32_t rank) {
    cell_box box = {{0, 0, 0}, {0, 0, 0}};
    int32_t at[3];
    if (domain == NULL && rank == 0) memcpy(box.end, grid->cells, sizeof box.end);
    if (domain == NULL) return box;
    ty_domain_place(domain, rank, at);
    for (int a = 0; a < 3; ++a) {
        box.first[a] = ty_domain_first(domain, a, at[a]);
        box.end[a] = ty_domain_first(domain, a, at[a] + 1);
    }
    return box;
}

/* The cells of both; returns their number. */
static size_t intersect(const cell_box* a, const cell_box* b, cell_box* out) {
    size_t cells = 1;
    for (int i = 0; i < 3; ++i) {
        out->first[i] = a->first[i] > b->first[i] ? a->first[i] : b->first[i];
        out->end[i] = a->end[i] < b->end[i] ? a->end[i] : b->end[i];
        if (out->end[i] <= out->first[i]) return 0;
        cells *= (size_t)(out->end[i] - out->first[i]);
    }
    return cells;
}

/* Copies cells between a box's array and a message. */
static void copy(const ty_halo* array, const cell_box* box, const cell_box* cells, char* message, bool out) {
    const size_t row = array->item * (size_t)(cells->end[0] - cells->first[0]);
    for (int32_t z = cells->first[2]; z < cells->end[2]; ++z)
        for (int32_t y = cells->first[1]; y < cells->end[1]; ++y, message += row) {
            const ptrdiff_t at = array->stride[0] * (cells->first[0] - box->first[0]) +
                                 array->stride[1] * (y - box->first[1]) + array->stride[2] * (z - box->first[2]);
            char* items = (char*)array->origin + at * (ptrdiff_t)array->item;
            memcpy(out ? message : items, out ? items : message, row);
        }
}

/* As in ty_buffer_add: without memory the program ends, since other ranks wait for the message. */
static char* make_message(size_t bytes) {
    char* message = malloc(bytes);
    if (message != NULL) return message;
    fputs("tyndall: not enough memory for a message to another rank\n", stderr);
    _exit(1);
}

bool ty_domain_regroup(ty_comm* comm, const ty_domain* from, const ty_domain* to, const ty_halo* in,
                       const ty_halo* out) {
    const ty_domain* grid = from != NULL ? from : to;
    const int32_t ranks = ty_comm_size(comm), own = ty_comm_rank(comm);
    const cell_box has = box_of(from, grid, own), wants = box_of(to, grid, own);
    bool good = true;
    cell_box cells;
    for (int32_t i = 0; i < ranks && good; ++i) {
        const int32_t rank = (own + i) % ranks;
        const cell_box wanted = box_of(to, grid, rank);
        const size_t bytes = in->item * intersect(&has, &wanted, &cells);
        if (bytes == 0) continue;
        char* message = make_message(bytes);
        copy(in, &has, &cells, message, true);
        if (rank == own)
            copy(out, &wants, &cells, message, false);
        else
            good = ty_comm_put(comm, rank, TAG_OF_REGROUP, message, bytes);
        free(message);
    }
    for (int32_t i = 1; i < ranks && good; ++i) {
        const int32_t rank = (own + i) % ranks;
        const cell_box there = box_of(from, grid, rank);
        const size_t bytes = out->item * intersect(&there, &wants, &cells);
        if (bytes == 0) continue;
        char* message = make_message(bytes);
        good = ty_comm_get(comm, rank, TAG_OF_REGROUP, message, bytes);
        if (good) copy(out, &wants, &cells, message, false);
        free(message);
    }
    return good;
}

uint64_t ty_domain_regroup_bytes(int32_t ranks, const ty_domain* from, const ty_domain* to) {
    const ty_domain* grid = from != NULL ? from : to;
    uint64_t bytes = 0;
    cell_box cells;
    for (int32_t r = 0; r < ranks; ++r) {
        const cell_box has = box_of(from, grid, r);
        for (int32_t s = 0; s < ranks; ++s) {
            const cell_box wants = box_of(to, grid, s);
            if (r != s) bytes += intersect(&has, &wants, &cells);
        }
    }
    return bytes;
}
