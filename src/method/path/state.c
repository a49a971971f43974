/* Serialised state of a render: one record after another, each of which has what changed since the one before it. A
 * record is a header that identifies the render, then blocks: an index, then items, AOV sums and halves as in memory.
 */
#include "method/path/state.h"

#include "base/context.h"

#include <inttypes.h>
#include <string.h>

enum { STATE_VERSION = 5, BYTE_ORDER_MARK = 0x01020304 };

static const char state_magic[8] = "tyndstat";

typedef struct state_header {
    char magic[8];
    uint32_t version, byte_order;
    uint32_t item_size, aov_sums_size; /* bytes of one element; aov_sums_size 0: no AOV sums */
    uint64_t size;                     /* of header and blocks, bytes */
    uint64_t checksum;                 /* of all following bytes */
    char library[16];                  /* library version, since another one may trace other paths */
    uint64_t scene, seed;
    int32_t width, height, crop[4], max_depth;
    uint32_t aovs, ignore_media, unscattered, point_light_directions, energy_compensation;
    uint32_t guide, reserved;
    double seconds, cpu_seconds; /* elapsed */
    uint64_t paths, vertices;
} state_header;

static uint32_t aov_sums_size(const ty_path_run* run) {
    return run->aov_sums != NULL ? sizeof *run->aov_sums : 0;
}

/* aovs tells whether there are halves, so that the header has no size of them. */
static size_t half_size(const ty_path_run* run) {
    return run->halves != NULL ? sizeof *run->halves : 0;
}

size_t ty_path_state_blocks(const ty_path_run* run) {
    return ((size_t)run->item_count + TY_PATH_BLOCK - 1) / TY_PATH_BLOCK;
}

size_t ty_path_state_room(const ty_path_run* run) {
    return sizeof(state_header) + ty_path_state_blocks(run) * sizeof(uint64_t) +
           (size_t)run->item_count * (sizeof *run->items + aov_sums_size(run) + half_size(run));
}

/* Items of a block: the last one may be short. */
static size_t block_items(const ty_path_run* run, size_t block) {
    const size_t left = (size_t)run->item_count - block * TY_PATH_BLOCK;
    return left < TY_PATH_BLOCK ? left : TY_PATH_BLOCK;
}

enum { LANES = 4 };

static uint64_t hash_word(uint64_t hash, const uint8_t* bytes) {
    uint64_t word;
    memcpy(&word, bytes, sizeof word);
    hash = (hash ^ word) * 0x9e3779b97f4a7c15u;
    return hash ^ hash >> 29;
}

/* Checksum over 8-byte words, in independent lanes, because states are large and a single chain of multiplications
 * waits for each of them. size is a multiple of 8. */
static uint64_t checksum(const uint8_t* bytes, size_t size) {
    uint64_t lanes[LANES] = {0xcbf29ce484222325u, 1, 2, 3};
    size_t i = 0;
    for (; i + LANES * sizeof *lanes <= size; i += LANES * sizeof *lanes)
        for (int k = 0; k < LANES; ++k) lanes[k] = hash_word(lanes[k], bytes + i + (size_t)k * sizeof *lanes);
    for (; i < size; i += sizeof *lanes) lanes[0] = hash_word(lanes[0], bytes + i);
    for (int k = 1; k < LANES; ++k) lanes[0] = hash_word(lanes[0], (const uint8_t*)&lanes[k]);
    return lanes[0];
}

static const size_t checked_from = offsetof(state_header, library);

/* Header of a record of this run. */
static state_header make_header(const ty_path_run* run, const ty_path_stats* stats, size_t size) {
    state_header header;
    memset(&header, 0, sizeof header);
    memcpy(header.magic, state_magic, sizeof header.magic);
    header.version = STATE_VERSION;
    header.byte_order = BYTE_ORDER_MARK;
    header.item_size = sizeof *run->items;
    header.aov_sums_size = aov_sums_size(run);
    header.size = size;
    memcpy(header.library, TY_VERSION, sizeof TY_VERSION);
    header.scene = run->scene_hash;
    header.seed = run->def->seed;
    header.width = run->request.width;
    header.height = run->height;
    memcpy(header.crop, run->request.crop, sizeof header.crop);
    header.max_depth = run->def->max_depth;
    header.aovs = run->def->aovs;
    header.ignore_media = run->def->ignore_media;
    header.unscattered = run->def->unscattered;
    header.point_light_directions = run->def->point_light_directions;
    header.energy_compensation = run->def->energy_compensation;
    header.guide = (uint32_t)run->def->guide;
    header.seconds = stats->seconds;
    header.cpu_seconds = stats->cpu_seconds;
    header.paths = stats->paths;
    header.vertices = stats->vertices;
    return header;
}

size_t ty_path_state_copy(const ty_path_run* run, const ty_path_stats* stats, uint32_t* saved, uint8_t* state) {
    uint8_t* end = state + sizeof(state_header);
    for (size_t b = 0; b < ty_path_state_blocks(run); ++b) {
        const size_t first = b * TY_PATH_BLOCK, items = block_items(run, b);
        if (saved[b] == run->items[first].count) continue;
        const uint64_t index = b;
        memcpy(end, &index, sizeof index);
        end += sizeof index;
        memcpy(end, run->items + first, items * sizeof *run->items);
        end += items * sizeof *run->items;
        if (run->aov_sums != NULL) memcpy(end, run->aov_sums + first, items * sizeof *run->aov_sums);
        end += items * aov_sums_size(run);
        if (run->halves != NULL) memcpy(end, run->halves + first, items * sizeof *run->halves);
        end += items * half_size(run);
        saved[b] = run->items[first].count;
    }
    const size_t size = (size_t)(end - state);
    const state_header header = make_header(run, stats, size);
    memcpy(state, &header, sizeof header);
    return size;
}

void ty_path_state_seal(uint8_t* state, size_t size) {
    if (size < sizeof(state_header) || size % sizeof(uint64_t) != 0) return;
    const uint64_t sum = checksum(state + checked_from, size - checked_from);
    memcpy(state + offsetof(state_header, checksum), &sum, sizeof sum);
}

/* True if the checksum is right; header->size bytes of state can be read. */
static bool is_sealed(const uint8_t* state, const state_header* header) {
    return header->size >= sizeof *header && header->size % sizeof(uint64_t) == 0 &&
           header->checksum == checksum(state + checked_from, header->size - checked_from);
}

/* Checks that the bytes begin with a complete record of a known layout. */
static ty_result check_form(ty_context* context, const uint8_t* state, size_t size, state_header* header) {
    if (size < sizeof *header)
        return ty_fail(context, TY_ERROR_INPUT, "the state of a render is cut short: %zu bytes", size);
    memcpy(header, state, sizeof *header);
    if (memcmp(header->magic, state_magic, sizeof header->magic) != 0)
        return ty_fail(context, TY_ERROR_INPUT, "this is not the state of a render");
    if (header->byte_order != BYTE_ORDER_MARK)
        return ty_fail(context, TY_ERROR_INPUT, "the state is of a machine with another byte order");
    if (header->version != STATE_VERSION)
        return ty_fail(context, TY_ERROR_INPUT, "the state has format %" PRIu32 ", not %d", header->version,
                       STATE_VERSION);
    if (header->size > size || header->size < sizeof *header)
        return ty_fail(context, TY_ERROR_INPUT, "the state is cut short or damaged: %zu bytes, not %" PRIu64, size,
                       header->size);
    if (!is_sealed(state, header))
        return ty_fail(context, TY_ERROR_INPUT, "the state is damaged: its checksum is wrong");
    if (memchr(header->library, '\0', sizeof header->library) == NULL || strcmp(header->library, TY_VERSION) != 0)
        return ty_fail(context, TY_ERROR_INPUT, "the state is of version %.15s, not %s", header->library, TY_VERSION);
    return TY_OK;
}

/* Checks that a record is of the same render. */
static ty_result check_render(ty_context* context, const state_header* was, const state_header* is) {
    if (was->scene != is->scene)
        return ty_fail(context, TY_ERROR_INPUT, "the state is of scene %016" PRIx64 ", not %016" PRIx64, was->scene,
                       is->scene);
    if (was->seed != is->seed)
        return ty_fail(context, TY_ERROR_INPUT, "the state is of seed %" PRIu64 ", not %" PRIu64, was->seed, is->seed);
    if (was->width != is->width || was->height != is->height)
        return ty_fail(context, TY_ERROR_INPUT, "the state is of %d x %d pixels, not %d x %d", was->width, was->height,
                       is->width, is->height);
    if (memcmp(was->crop, is->crop, sizeof is->crop) != 0)
        return ty_fail(context, TY_ERROR_INPUT, "the state is of the crop %d,%d,%dx%d, not %d,%d,%dx%d", was->crop[0],
                       was->crop[1], was->crop[2], was->crop[3], is->crop[0], is->crop[1], is->crop[2], is->crop[3]);
    if (was->max_depth != is->max_depth)
        return ty_fail(context, TY_ERROR_INPUT, "the state is of max_depth %d, not %d", was->max_depth, is->max_depth);
    if (was->ignore_media != is->ignore_media)
        return ty_fail(context, TY_ERROR_INPUT, "the state is of the scene with%s its media",
                       was->ignore_media != 0 ? "out" : "");
    if (was->unscattered != is->unscattered)
        return ty_fail(context, TY_ERROR_INPUT, "the state is of %s",
                       was->unscattered != 0 ? "light that no medium scattered" : "all light, scattered by media, too");
    if (was->point_light_directions != is->point_light_directions)
        return ty_fail(context, TY_ERROR_INPUT, "the state is with%s lamp directions",
                       was->point_light_directions != 0 ? "" : "out");
    if (was->energy_compensation != is->energy_compensation)
        return ty_fail(context, TY_ERROR_INPUT, "the state is with%s energy compensation",
                       was->energy_compensation != 0 ? "" : "out");
    if (was->guide != is->guide)
        return ty_fail(context, TY_ERROR_INPUT, "the state is with%s a guide", was->guide != 0 ? "" : "out");
    if (was->aovs != is->aovs)
        return ty_fail(context, TY_ERROR_INPUT,
                       "the state has other channels beside R, G and B: aovs %" PRIu32 ", not %" PRIu32, was->aovs,
                       is->aovs);
    if (was->item_size != is->item_size || was->aov_sums_size != is->aov_sums_size)
        return ty_fail(context, TY_ERROR_INPUT, "the state is damaged: %" PRIu32 " and %" PRIu32 " bytes per pixel",
                       was->item_size, was->aov_sums_size);
    return TY_OK;
}

ty_path_guide_kind ty_path_state_guide(const void* state, size_t size) {
    state_header header;
    if (size < sizeof header) return TY_PATH_GUIDE_NONE;
    memcpy(&header, state, sizeof header);
    return header.guide == (uint32_t)TY_PATH_GUIDE_DOM ? TY_PATH_GUIDE_DOM : TY_PATH_GUIDE_NONE;
}

/* Checks sample counts: equal within a block, at most the number wanted. */
static ty_result check_counts(const ty_path_run* run) {
    for (int64_t i = 0; i < run->item_count; ++i) {
        const uint32_t count = run->items[i].count;
        if (count != run->items[i - i % TY_PATH_BLOCK].count || count > TY_PATH_SPP_MAX)
            return ty_fail(run->context, TY_ERROR_INPUT, "the state is damaged: %" PRIu32 " samples of pixel %" PRId64,
                           count, i);
        if (count > (uint32_t)run->def->spp)
            return ty_fail(run->context, TY_ERROR_INPUT,
                           "the state has %" PRIu32 " samples per pixel, more than the %d asked for", count,
                           run->def->spp);
    }
    return TY_OK;
}

/* Sets the items of a record's blocks. */
static ty_result take_blocks(ty_path_run* run, const uint8_t* at, const uint8_t* end) {
    const size_t item_size = sizeof *run->items, aov_size = aov_sums_size(run), half = half_size(run);
    while (at < end) {
        uint64_t block = UINT64_MAX;
        if ((size_t)(end - at) >= sizeof block) memcpy(&block, at, sizeof block);
        const bool known = block < ty_path_state_blocks(run);
        const size_t first = known ? (size_t)block * TY_PATH_BLOCK : 0,
                     items = known ? block_items(run, (size_t)block) : 0;
        if (!known || (size_t)(end - at) < sizeof block + items * (item_size + aov_size + half))
            return ty_fail(run->context, TY_ERROR_INPUT, "the state is damaged: its blocks are not those of the image");
        at += sizeof block;
        memcpy(run->items + first, at, items * item_size);
        at += items * item_size;
        if (run->aov_sums != NULL) memcpy(run->aov_sums + first, at, items * aov_size);
        at += items * aov_size;
        if (run->halves != NULL) memcpy(run->halves + first, at, items * half);
        at += items * half;
    }
    return TY_OK;
}

/* True if the bytes are the beginning of a record. */
static bool begins_record(const uint8_t* bytes, size_t size) {
    return memcmp(bytes, state_magic, size < sizeof state_magic ? size : sizeof state_magic) == 0;
}

/* True for a record that is not whole because its writer was killed: a part of one, or one with a wrong checksum. */
static bool is_cut(const uint8_t* record, size_t size) {
    state_header header;
    if (size < sizeof header) return true;
    memcpy(&header, record, sizeof header);
    return header.size > size || !is_sealed(record, &header);
}

/* Takes one record; *size is that of the record. */
static ty_result take_record(ty_path_run* run, const uint8_t* record, size_t left, size_t* size) {
    state_header was;
    ty_result result = check_form(run->context, record, left, &was);
    if (result != TY_OK) return result;
    const state_header is = make_header(run, &run->stats, 0);
    result = check_render(run->context, &was, &is);
    if (result == TY_OK) result = take_blocks(run, record + sizeof was, record + was.size);
    if (result != TY_OK) return result;
    if (!(was.seconds >= 0 && was.seconds < 1e12 && was.cpu_seconds >= 0 && was.cpu_seconds < 1e15))
        return ty_fail(run->context, TY_ERROR_INPUT, "the state is damaged: it took %g s", was.seconds);
    run->stats.seconds = was.seconds;
    run->stats.cpu_seconds = was.cpu_seconds;
    run->stats.paths = was.paths;
    run->stats.vertices = was.vertices;
    *size = (size_t)was.size;
    return TY_OK;
}

static uint64_t count_paths(const ty_path_run* run) {
    uint64_t paths = 0;
    for (int64_t i = 0; i < run->item_count; ++i) paths += run->items[i].count;
    return paths;
}

ty_result ty_path_state_resume(ty_path_run* run) {
    const uint8_t* state = run->def->resume;
    size_t taken = 0;
    do {
        const size_t left = run->def->resume_size - taken;
        if (taken > 0 && !begins_record(state + taken, left))
            return ty_fail(run->context, TY_ERROR_INPUT,
                           "the state is cut short or damaged: %zu bytes behind it are not its changes", left);
        if (taken > 0 && is_cut(state + taken, left)) break;
        size_t size = 0;
        const ty_result result = take_record(run, state + taken, left, &size);
        if (result != TY_OK) return result;
        taken += size;
    } while (taken < run->def->resume_size);
    const ty_result result = check_counts(run);
    if (result == TY_OK) run->stats.paths = count_paths(run); /* also after a record in the middle was lost */
    return result;
}
