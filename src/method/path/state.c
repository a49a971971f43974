/* Serialised state of a render: a header that identifies the render, then items and AOV sums as in memory. */
#include "method/path/state.h"

#include "base/context.h"

#include <inttypes.h>
#include <string.h>

enum { STATE_VERSION = 3, BYTE_ORDER_MARK = 0x01020304 };

static const char state_magic[8] = "tyndstat";

typedef struct state_header {
    char magic[8];
    uint32_t version, byte_order;
    uint32_t item_size, aov_sums_size; /* bytes of one element; aov_sums_size 0: no AOV sums */
    uint64_t size;                     /* of the whole state, bytes */
    uint64_t checksum;                 /* of all following bytes */
    char library[16];                  /* library version, since another one may trace other paths */
    uint64_t scene, seed;
    int32_t width, height, crop[4], max_depth;
    uint32_t aovs, ignore_media, unscattered, lamp_directions;
    double seconds, cpu_seconds; /* elapsed */
    uint64_t paths, vertices;
} state_header;

static uint32_t aov_sums_size(const ty_path_run* run) {
    return run->aov_sums != NULL ? sizeof *run->aov_sums : 0;
}

size_t ty_path_state_size(const ty_path_run* run) {
    return sizeof(state_header) + (size_t)run->item_count * (sizeof *run->items + aov_sums_size(run));
}

/* Checksum over 8-byte words: states are large, and threads wait for it. size is a multiple of 8. */
static uint64_t checksum(const uint8_t* bytes, size_t size) {
    uint64_t hash = 0xcbf29ce484222325u;
    for (size_t i = 0; i < size; i += sizeof hash) {
        uint64_t word;
        memcpy(&word, bytes + i, sizeof word);
        hash = (hash ^ word) * 0x9e3779b97f4a7c15u;
        hash ^= hash >> 29;
    }
    return hash;
}

static const size_t checked_from = offsetof(state_header, library);

/* Header of this run's state. */
static state_header make_header(const ty_path_run* run, const ty_path_stats* stats) {
    state_header header;
    memset(&header, 0, sizeof header);
    memcpy(header.magic, state_magic, sizeof header.magic);
    header.version = STATE_VERSION;
    header.byte_order = BYTE_ORDER_MARK;
    header.item_size = sizeof *run->items;
    header.aov_sums_size = aov_sums_size(run);
    header.size = ty_path_state_size(run);
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
    header.lamp_directions = run->def->lamp_directions;
    header.seconds = stats->seconds;
    header.cpu_seconds = stats->cpu_seconds;
    header.paths = stats->paths;
    header.vertices = stats->vertices;
    return header;
}

void ty_path_state_copy(const ty_path_run* run, const ty_path_stats* stats, uint8_t* state) {
    const state_header header = make_header(run, stats);
    const size_t count = (size_t)run->item_count;
    memcpy(state, &header, sizeof header);
    memcpy(state + sizeof header, run->items, count * sizeof *run->items);
    if (run->aov_sums != NULL)
        memcpy(state + sizeof header + count * sizeof *run->items, run->aov_sums, count * sizeof *run->aov_sums);
}

void ty_path_state_seal(uint8_t* state, size_t size) {
    if (size < sizeof(state_header) || size % sizeof(uint64_t) != 0) return;
    const uint64_t sum = checksum(state + checked_from, size - checked_from);
    memcpy(state + offsetof(state_header, checksum), &sum, sizeof sum);
}

/* Checks that the bytes are a complete state of a known layout. */
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
    if (header->size != size)
        return ty_fail(context, TY_ERROR_INPUT, "the state is cut short or damaged: %zu bytes, not %" PRIu64, size,
                       header->size);
    if (size % sizeof(uint64_t) != 0 || header->checksum != checksum(state + checked_from, size - checked_from))
        return ty_fail(context, TY_ERROR_INPUT, "the state is damaged: its checksum is wrong");
    if (memchr(header->library, '\0', sizeof header->library) == NULL || strcmp(header->library, TY_VERSION) != 0)
        return ty_fail(context, TY_ERROR_INPUT, "the state is of version %.15s, not %s", header->library, TY_VERSION);
    return TY_OK;
}

/* Checks that the state is of the same render. */
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
    if (was->lamp_directions != is->lamp_directions)
        return ty_fail(context, TY_ERROR_INPUT, "the state is with%s lamp directions",
                       was->lamp_directions != 0 ? "" : "out");
    if (was->aovs != is->aovs)
        return ty_fail(context, TY_ERROR_INPUT,
                       "the state has other channels beside R, G and B: aovs %" PRIu32 ", not %" PRIu32, was->aovs,
                       is->aovs);
    if (was->item_size != is->item_size || was->aov_sums_size != is->aov_sums_size || was->size != is->size)
        return ty_fail(context, TY_ERROR_INPUT, "the state is damaged: %" PRIu64 " bytes, not %" PRIu64, was->size,
                       is->size);
    return TY_OK;
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

ty_result ty_path_state_resume(ty_path_run* run) {
    const uint8_t* state = run->def->resume;
    state_header was;
    ty_result result = check_form(run->context, state, run->def->resume_size, &was);
    if (result != TY_OK) return result;
    const state_header is = make_header(run, &run->stats);
    result = check_render(run->context, &was, &is);
    if (result != TY_OK) return result;
    const size_t count = (size_t)run->item_count;
    memcpy(run->items, state + sizeof was, count * sizeof *run->items);
    if (run->aov_sums != NULL)
        memcpy(run->aov_sums, state + sizeof was + count * sizeof *run->items, count * sizeof *run->aov_sums);
    result = check_counts(run);
    if (result != TY_OK) return result;
    if (!(was.seconds >= 0 && was.seconds < 1e12 && was.cpu_seconds >= 0 && was.cpu_seconds < 1e15))
        return ty_fail(run->context, TY_ERROR_INPUT, "the state is damaged: it took %g s", was.seconds);
    run->stats.seconds = was.seconds;
    run->stats.cpu_seconds = was.cpu_seconds;
    run->stats.paths = was.paths;
    run->stats.vertices = was.vertices;
    return TY_OK;
}
