/* OpenVDB files built byte by byte, as other writers might make them: any map, type, metadata or instance, with or
 * without statistics. */
#ifndef TY_TESTS_VDB_MAKER_H
#define TY_TESTS_VDB_MAKER_H

#include "files.h"

typedef struct maker {
    uint8_t bytes[1 << 17];
    size_t size;
} maker;

static inline void put(maker* m, const void* bytes, size_t size) {
    assert_true(m->size + size <= sizeof m->bytes);
    memcpy(m->bytes + m->size, bytes, size);
    m->size += size;
}

static inline void put_zeros(maker* m, size_t size) {
    assert_true(m->size + size <= sizeof m->bytes);
    memset(m->bytes + m->size, 0, size);
    m->size += size;
}

static inline void put_u8(maker* m, uint8_t value) {
    put(m, &value, sizeof value);
}

static inline void put_i32(maker* m, int32_t value) {
    put(m, &value, sizeof value);
}

static inline void put_i64(maker* m, int64_t value) {
    put(m, &value, sizeof value);
}

static inline void put_f64(maker* m, double value) {
    put(m, &value, sizeof value);
}

static inline void put_text(maker* m, const char* text) {
    put_i32(m, (int32_t)strlen(text));
    put(m, text, strlen(text));
}

static inline void put_origin(maker* m, const int32_t origin[3]) {
    for (int a = 0; a < 3; ++a) put_i32(m, origin[a]);
}

static inline void put_bit_mask(maker* m, size_t bits, int on) {
    const size_t start_at = m->size;
    put_zeros(m, bits / 8);
    if (on >= 0) m->bytes[start_at + (size_t)on / 8] |= (uint8_t)(1 << on % 8);
}

/* Contents of a made file: one grid with a single active tile of 8^3 at tile (in voxels), background elsewhere. */
typedef struct made {
    const char *name, *type, *parent, *map;
    bool is_double, statistics;
    int32_t tile[3];
    double value, background;
} made;

static inline void put_value(maker* m, const made* d, double value) {
    const float narrow = (float)value;
    if (d->is_double)
        put_f64(m, value);
    else
        put(m, &narrow, sizeof narrow);
}

static inline void put_header(maker* m, uint32_t version, int32_t grids) {
    put_i64(m, 0x56444220);
    put_i32(m, (int32_t)version);
    put_i32(m, 5);
    put_i32(m, 1);
    put_u8(m, 1);
    put(m, "01234567-89ab-cdef-0123-456789abcdef", 36);
    put_i32(m, 1);
    put_text(m, "creator");
    put_text(m, "string");
    put_text(m, "a test");
    put_i32(m, grids);
}

static inline void put_metadata(maker* m, const made* d) {
    put_i32(m, d->statistics ? 4 : 1);
    put_text(m, "some_new_kind");
    put_text(m, "unheard_of");
    put_text(m, "opaque");
    if (!d->statistics) return;
    static const char* const keys[] = {"file_bbox_min", "file_bbox_max"};
    for (int k = 0; k < 2; ++k) {
        put_text(m, keys[k]);
        put_text(m, "vec3i");
        put_i32(m, 12);
        for (int a = 0; a < 3; ++a) put_i32(m, d->tile[a] + 7 * k);
    }
    put_text(m, "file_voxel_count");
    put_text(m, "int64");
    put_i32(m, 8);
    put_i64(m, 512);
}

/* Scale (2, 3, 4), translation (10, 20, 30), whichever map says. */
static inline void put_map(maker* m, const char* map) {
    put_text(m, map);
    static const double scale[3] = {2, 3, 4}, move[3] = {10, 20, 30};
    if (strstr(map, "Translat") != NULL)
        for (int a = 0; a < 3; ++a) put_f64(m, move[a]);
    if (strstr(map, "Scale") != NULL) {
        for (int k = 0; k < 2; ++k)
            for (int a = 0; a < 3; ++a) put_f64(m, scale[a]);
        for (int k = 0; k < 9; ++k) put_f64(m, 0.125);
    }
    if (strcmp(map, "AffineMap") == 0) /* rows: images of x, y, z, then the translation */
        for (int r = 0; r < 4; ++r)
            for (int c = 0; c < 4; ++c) put_f64(m, r == 3 && c < 3 ? move[c] : r == 3 ? 1 : r == c ? scale[c] : 0);
}

static inline int slot(const int32_t tile[3], int log2, int total) {
    int index = 0;
    for (int a = 0; a < 3; ++a) index = index << log2 | ((tile[a] >> total) & ((1 << log2) - 1));
    return index;
}

/* Root, one node of 32^3 slots, one of 16^3 slots with the tile; values mask-compressed, no codec. */
static inline void put_tree(maker* m, const made* d) {
    put_i32(m, 1);
    put_value(m, d, d->background);
    put_i32(m, 0);
    put_i32(m, 1);
    int32_t origin[3];
    for (int a = 0; a < 3; ++a) origin[a] = d->tile[a] & ~4095;
    put_origin(m, origin);
    put_bit_mask(m, 32768, slot(d->tile, 5, 7));
    put_bit_mask(m, 32768, -1);
    put_u8(m, 0); /* all inactive values are the background; none active */
    put_bit_mask(m, 4096, -1);
    put_bit_mask(m, 4096, slot(d->tile, 4, 3));
    put_u8(m, 0);
    put_value(m, d, d->value);
}

static inline void put_grid(maker* m, const made* d) {
    put_text(m, d->name);
    put_text(m, d->type);
    put_text(m, d->parent);
    const size_t offsets = m->size;
    put_zeros(m, 24);
    const int64_t head = (int64_t)m->size;
    put_i32(m, 2); /* active mask, no codec */
    put_metadata(m, d);
    put_map(m, d->map);
    const int64_t tree = (int64_t)m->size;
    if (d->parent[0] == '\0') put_tree(m, d);
    const int64_t places[3] = {head, tree, (int64_t)m->size};
    memcpy(m->bytes + offsets, places, sizeof places);
}

static const made plain = {.name = "density",
                           .type = "Tree_float_5_4_3",
                           .parent = "",
                           .map = "ScaleTranslateMap",
                           .tile = {-136, 8, -4096},
                           .value = 2.5,
                           .background = 0.25};

static maker making;

static inline void make_file(const char* path, const made* grids, int count) {
    making.size = 0;
    put_header(&making, 224, count);
    for (int i = 0; i < count; ++i) put_grid(&making, &grids[i]);
    put_file(path, making.bytes, making.size);
}

#endif
