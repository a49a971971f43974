/* Closed meshes: creation, and a check for open edges. */
#include "scene/surfaces/closed_mesh.h"

#include "base/context.h"

#include <stdatomic.h>

/* Slots of a hash table with open addressing, at least twice the entries; a power of two. */
static size_t slot_count(size_t entries) {
    size_t slots = 16;
    while (slots < 2 * entries) slots *= 2;
    return slots;
}

static uint64_t mix(uint64_t x) {
    x = (x ^ x >> 30) * 0xbf58476d1ce4e5b9u;
    x = (x ^ x >> 27) * 0x94d049bb133111ebu;
    return x ^ x >> 31;
}

static uint64_t hash_position(const float p[3]) {
    uint64_t hash = 0;
    for (int a = 0; a < 3; ++a) {
        const float value = p[a] == 0 ? 0 : p[a]; /* -0 is 0 */
        uint32_t bits;
        memcpy(&bits, &value, sizeof bits);
        hash = mix(hash ^ bits);
    }
    return hash;
}

static bool same_position(const float a[3], const float b[3]) {
    return a[0] == b[0] && a[1] == b[1] && a[2] == b[2];
}

/* First vertex at each position: files duplicate vertices where normals or texture coordinates differ. */
static bool weld(ty_context* context, const ty_triangle_mesh* t, uint32_t* first) {
    const size_t slots = slot_count(t->vertex_count);
    uint32_t* table = ty_alloc_array(context, slots, sizeof *table, true); /* vertex + 1 */
    if (table == NULL) return false;
    for (uint32_t v = 0; v < t->vertex_count; ++v) {
        const float* p = t->positions + 3 * (size_t)v;
        size_t slot = hash_position(p) & (slots - 1);
        while (table[slot] != 0 && !same_position(t->positions + 3 * (size_t)(table[slot] - 1), p))
            slot = (slot + 1) & (slots - 1);
        if (table[slot] == 0) table[slot] = v + 1;
        first[v] = table[slot] - 1;
    }
    ty_free_array(context, table, slots, sizeof *table);
    return true;
}

/* Edge between two positions, the lower index first. */
typedef struct mesh_edge {
    uint32_t low, high;
    int32_t triangles; /* number of triangles; 0: an empty slot */
    int32_t balance;   /* triangles that traverse it from low to high minus the others */
} mesh_edge;

static void insert_edge(mesh_edge* table, size_t slots, uint32_t from, uint32_t to) {
    const uint32_t low = from < to ? from : to, high = from < to ? to : from;
    size_t slot = mix((uint64_t)low << 32 | high) & (slots - 1);
    while (table[slot].triangles != 0 && (table[slot].low != low || table[slot].high != high))
        slot = (slot + 1) & (slots - 1);
    table[slot].low = low;
    table[slot].high = high;
    ++table[slot].triangles;
    table[slot].balance += from < to ? 1 : -1;
}

size_t ty_count_open_edges(ty_context* context, const ty_triangle_mesh* t) {
    const size_t slots = slot_count(3 * t->triangle_count);
    uint32_t* first = ty_alloc_array(context, t->vertex_count, sizeof *first, false);
    mesh_edge* table = ty_alloc_array(context, slots, sizeof *table, true);
    size_t open = SIZE_MAX;
    if (first != NULL && table != NULL && weld(context, t, first)) {
        open = 0;
        for (size_t i = 0; i < t->triangle_count; ++i) {
            uint32_t corner[3];
            for (size_t k = 0; k < 3; ++k) corner[k] = first[t->indices[3 * i + k]];
            if (corner[0] == corner[1] || corner[1] == corner[2] || corner[2] == corner[0]) continue;
            for (int k = 0; k < 3; ++k) insert_edge(table, slots, corner[k], corner[(k + 1) % 3]);
        }
        for (size_t i = 0; i < slots; ++i) open += table[i].triangles != 0 && table[i].balance != 0;
    }
    ty_free_array(context, first, t->vertex_count, sizeof *first);
    ty_free_array(context, table, slots, sizeof *table);
    return open;
}

ty_result ty_closed_mesh_create(ty_context* context, const float* positions, int64_t vertex_count,
                                const uint32_t* indices, int64_t triangle_count, ty_closed_mesh** out) {
    ty_mesh_def def = ty_default_mesh_def();
    def.vertex_count = vertex_count;
    def.triangle_count = triangle_count;
    def.positions = positions;
    def.indices = indices;
    ty_result result = ty_triangle_mesh_check(context, "shell", positions, vertex_count, indices, triangle_count);
    if (result != TY_OK) return result;
    ty_closed_mesh* closed = ty_alloc_array(context, 1, sizeof *closed, true);
    if (closed == NULL) return TY_ERROR_MEMORY;
    closed->context = context;
    atomic_init(&closed->owners, 1);
    size_t open = 0;
    result = ty_triangle_mesh_create(context, &def, &closed->triangles);
    if (result == TY_OK) {
        open = ty_count_open_edges(context, closed->triangles);
        if (open == SIZE_MAX) result = TY_ERROR_MEMORY;
    }
    if (result == TY_OK) result = ty_accel_create_closed(context, closed->triangles, &closed->mesh);
    if (result != TY_OK) {
        ty_closed_mesh_release(closed);
        return result;
    }
    if (open > 0)
        ty_log(context, TY_LOG_WARNING, "a shell is not closed: %zu of its edges do not join two triangles", open);
    *out = closed;
    return TY_OK;
}

ty_closed_mesh* ty_closed_mesh_retain(ty_closed_mesh* closed) {
    if (closed != NULL) atomic_fetch_add(&closed->owners, 1);
    return closed;
}

void ty_closed_mesh_release(ty_closed_mesh* closed) {
    if (closed == NULL || atomic_fetch_sub(&closed->owners, 1) > 1) return;
    ty_accel_destroy(closed->mesh);
    ty_triangle_mesh_destroy(closed->context, closed->triangles);
    ty_free_array(closed->context, closed, 1, sizeof *closed);
}

size_t ty_closed_mesh_bytes(const ty_closed_mesh* closed) {
    return sizeof *closed + ty_triangle_mesh_bytes(closed->triangles) + ty_accel_bytes(closed->mesh);
}
