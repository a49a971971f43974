#include "device/store.h"

#include "base/context.h"

#include <string.h>

struct ty_device_piece {
    ty_address address;
    size_t bytes;
    bool shared; /* has contents that stay */
    int32_t users;
    uint64_t used;      /* ty_device.uses when it was last taken or released */
    uint64_t digest[2]; /* of the contents */
    const void* from;   /* what they were last copied from or compared with */
    ty_device_origin origin;
};

/* ---- digests ---- */

static uint64_t mixed(uint64_t h, uint64_t word) {
    h = (h ^ word) * 0x9e3779b97f4a7c15u;
    return h ^ (h >> 29);
}

/* Of 128 bits, by four chains of invertible steps, so that it takes about as long as reading. Nobody chooses contents
 * so that digests meet: equal ones by chance are out of the question. */
static void digest_bytes(const void* from, size_t bytes, uint64_t out[2]) {
    const unsigned char* at = from;
    uint64_t h[4] = {bytes, 0xd1b54a32d192ed03u, 0x8cb92ba72f3d8dd7u, 0xaaaaaaaaaaaaaaabu}, words[4];
    size_t i = 0;
    for (; i + sizeof words <= bytes; i += sizeof words) {
        memcpy(words, at + i, sizeof words);
        for (int k = 0; k < 4; ++k) h[k] = mixed(h[k], words[k]);
    }
    memset(words, 0, sizeof words);
    memcpy(words, at + i, bytes - i);
    for (int k = 0; k < 4; ++k) h[k] = mixed(h[k], words[k]);
    out[0] = mixed(mixed(h[0], h[1]), mixed(h[2], h[3]));
    out[1] = mixed(mixed(h[3], h[0]), mixed(h[1], h[2]));
}

/* ---- pieces ---- */

/* Takes another origin. */
static void set_origin(ty_device_piece* piece, const void* from, const ty_device_origin* origin) {
    const ty_device_origin before = piece->origin, none = {.version = 0};
    piece->from = from;
    piece->origin = origin != NULL ? *origin : none;
    if (piece->origin.retain != NULL) piece->origin.retain(piece->origin.owner);
    if (before.release != NULL) before.release(before.owner);
}

static void drop(ty_device* device, size_t i) {
    set_origin(&device->pieces[i], NULL, NULL);
    device->backend->free(device, device->pieces[i].address);
    device->pieces[i] = device->pieces[--device->piece_count];
}

static void drop_idle(ty_device* device, uint64_t uses) {
    for (size_t i = device->piece_count; i-- > 0;)
        if (device->pieces[i].users == 0 && device->pieces[i].used + uses <= device->uses) drop(device, i);
}

static void take(ty_device* device, ty_device_piece* piece, ty_address* out) {
    ++piece->users;
    piece->used = device->uses;
    *out = piece->address;
}

/* A new piece, with one user. */
static ty_result add(ty_device* device, size_t bytes, ty_device_piece** piece) {
    ty_device_piece new = {.bytes = bytes};
    if (!ty_grow_array(device->context, (void**)&device->pieces, &device->piece_capacity, device->piece_count,
                       sizeof *device->pieces))
        return TY_ERROR_MEMORY;
    ty_result result = device->backend->alloc(device, bytes, &new.address);
    const size_t before = device->piece_count;
    if (result == TY_ERROR_MEMORY) drop_idle(device, 0);
    if (result == TY_ERROR_MEMORY && device->piece_count < before) {
        ty_take_error(device->context);
        result = device->backend->alloc(device, bytes, &new.address);
    }
    if (result != TY_OK) return result;
    *piece = &device->pieces[device->piece_count++];
    **piece = new;
    return TY_OK;
}

ty_result ty_device_store_alloc(ty_device* device, size_t bytes, ty_address* out) {
    ty_device_piece* piece = NULL;
    if (device->keep == 0) return device->backend->alloc(device, bytes, out);
    for (size_t i = 0; i < device->piece_count && piece == NULL; ++i) {
        ty_device_piece* spare = &device->pieces[i];
        if (!spare->shared && spare->users == 0 && spare->bytes == bytes) piece = spare;
    }
    const ty_result result = piece != NULL ? TY_OK : add(device, bytes, &piece);
    if (result == TY_OK) take(device, piece, out);
    return result;
}

/* A piece that was last compared with this very array. */
static ty_device_piece* find_origin(ty_device* device, const void* from, size_t bytes, const ty_device_origin* origin) {
    for (size_t i = 0; i < device->piece_count && origin != NULL; ++i) {
        ty_device_piece* piece = &device->pieces[i];
        if (piece->from == from && piece->origin.version == origin->version && piece->bytes == bytes) return piece;
    }
    return NULL;
}

static ty_device_piece* find_contents(ty_device* device, size_t bytes, const uint64_t digest[2]) {
    for (size_t i = 0; i < device->piece_count; ++i) {
        ty_device_piece* piece = &device->pieces[i];
        if (piece->shared && piece->bytes == bytes && memcmp(piece->digest, digest, sizeof piece->digest) == 0)
            return piece;
    }
    return NULL;
}

static ty_result write(ty_device* device, ty_address to, const void* from, size_t bytes) {
    device->bytes_written += bytes;
    return device->backend->write(device, to, from, bytes);
}

ty_result ty_device_store_copy(ty_device* device, const void* from, size_t bytes, const ty_device_origin* origin,
                               ty_address* out) {
    if (device->keep == 0) {
        const ty_result result = device->backend->alloc(device, bytes, out);
        if (result != TY_OK) return result;
        const ty_result written = write(device, *out, from, bytes);
        if (written != TY_OK) device->backend->free(device, *out);
        return written;
    }
    ty_device_piece* piece = find_origin(device, from, bytes, origin);
    uint64_t digest[2];
    ty_result result = TY_OK;
    if (piece == NULL) {
        digest_bytes(from, bytes, digest);
        piece = find_contents(device, bytes, digest);
        if (piece == NULL) {
            result = add(device, bytes, &piece);
            if (result != TY_OK) return result;
            result = write(device, piece->address, from, bytes);
            if (result != TY_OK) {
                drop(device, (size_t)(piece - device->pieces));
                return result;
            }
            piece->shared = true;
            memcpy(piece->digest, digest, sizeof digest);
        }
        set_origin(piece, from, origin);
    }
    take(device, piece, out);
    return TY_OK;
}

void ty_device_store_release(ty_device* device, ty_address address) {
    for (size_t i = 0; i < device->piece_count; ++i)
        if (device->pieces[i].address == address) {
            --device->pieces[i].users;
            device->pieces[i].used = device->uses;
            return;
        }
    device->backend->free(device, address);
}

void ty_device_store_end_use(ty_device* device) {
    ++device->uses;
    drop_idle(device, (uint64_t)device->keep + 1);
}

void ty_device_store_close(ty_device* device) {
    while (device->piece_count > 0) drop(device, device->piece_count - 1);
    ty_free_array(device->context, device->pieces, device->piece_capacity, sizeof *device->pieces);
    device->pieces = NULL;
    device->piece_capacity = 0;
}
