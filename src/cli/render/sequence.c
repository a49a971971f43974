/* Sequences: chains of frames, which are tasks of all ranks. */
#define _GNU_SOURCE
#include "cli/render/render.h"

#include "base/context.h"
#include "cli/session/ranks.h"
#include "comm/blocks.h"

#include <inttypes.h>
#include <pthread.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

enum { NAME_SIZE = 4096, KEY_SIZE = 64, MESSAGE_SIZE = 1024 };

/* ---- options ---- */

/* Replaces the last run of # in a name by a number with as many digits: false if there is none, or no room. */
static bool name_frame(const char* pattern, int32_t frame, char out[NAME_SIZE]) {
    const char* end = strrchr(pattern, '#');
    if (end == NULL) return false;
    const char* begin = end;
    while (begin > pattern && begin[-1] == '#') --begin;
    const int written = snprintf(out, NAME_SIZE, "%.*s%0*d%s", (int)(begin - pattern), pattern, (int)(end + 1 - begin),
                                 (int)frame, end + 1);
    return written > 0 && written < NAME_SIZE;
}

int render_check_sequence(render_options* options) {
    char name[NAME_SIZE], rest;
    int from, to, step = 1;
    if (options->frames_text == NULL) return cli_usage_error("render", "--chain is of frames; give --frames, too");
    const int read = sscanf(options->frames_text, "%9d-%9d:%9d%c", &from, &to, &step, &rest);
    const char* colon = strchr(options->frames_text, ':');
    if ((read != 2 || colon != NULL) && read != 3)
        return cli_usage_error("render", "--frames: '%s' is not like 1-240 or 1-240:2", options->frames_text);
    if (from < 0 || to < from || step < 1)
        return cli_usage_error("render", "--frames: there are no frames in '%s'", options->frames_text);
    options->frames[0] = from;
    options->frames[1] = to;
    options->frames[2] = step;
    const char* const patterns[] = {options->output, options->png, options->denoised_png};
    for (int i = 0; i < 3; ++i)
        if (patterns[i] != NULL && !name_frame(patterns[i], to, name))
            return cli_usage_error("render", "--frames: %s has no #### for the frame's number", patterns[i]);
    if (options->tev != NULL || options->checkpoint_given)
        return cli_usage_error("render", "--%s is for one image, and --frames are several",
                               options->tev != NULL ? "tev" : "checkpoint");
    if (options->resume && !cli_has_extension(options->output, ".exr"))
        return cli_usage_error("render", "--resume knows finished frames by what .exr images say, and %s is none",
                               options->output);
    return CLI_GO;
}

/* ---- a sequence ---- */

typedef struct sequence {
    cli_session* session;
    const char* path; /* of the scene */
    render_options* options;
    char key[KEY_SIZE];
    const ty_method* method;
    int32_t* chains; /* numbers of those that are left */
    int32_t chain_count, frame_count, finished, before;
    ty_blocks blocks;     /* the chains that are left */
    pthread_mutex_t lock; /* of the fields below, and of stdout */
    _Atomic int status;   /* of the first failure; CLI_GO: none */
} sequence;

static int32_t frames_of(const sequence* s) {
    const int32_t* f = s->options->frames;
    return (f[1] - f[0]) / f[2] + 1;
}

/* Frames [*first, *end) of a chain, counted from 0. */
static void chain_frames(const sequence* s, int32_t chain, int32_t* first, int32_t* end) {
    *first = chain * s->options->chain;
    *end = *first + s->options->chain < frames_of(s) ? *first + s->options->chain : frames_of(s);
}

static int32_t frame_number(const sequence* s, int32_t index) {
    return s->options->frames[0] + index * s->options->frames[2];
}

static uint64_t hash_text(uint64_t hash, const char* text, size_t size) {
    for (size_t i = 0; i <= size; ++i) hash = (hash ^ (i < size ? (uint8_t)text[i] : 0xffu)) * 0x100000001b3u;
    return hash;
}

/* A name of the command: what changes its images, and the scene file's text. */
static void make_key(sequence* s) {
    const render_options* o = s->options;
    char text[512];
    uint64_t hash = 0xcbf29ce484222325u;
    const int size =
        snprintf(text, sizeof text, "%s %s %d %d %" PRIu64 " %d %dx%d %d,%d,%dx%d %.17g %.17g %" PRIu32 " %d %d %d",
                 ty_version(), s->method->name, o->spp_given, (int)o->spp, s->session->common.seed,
                 s->session->common.seed_given, (int)o->size[0], (int)o->size[1], (int)o->crop[0], (int)o->crop[1],
                 (int)o->crop[2], (int)o->crop[3], o->time, o->error, o->aovs, o->denoise, o->denoiser, (int)o->chain);
    hash = hash_text(hash, text, (size_t)size);
    for (int32_t i = 0; i < o->overrides.count; ++i)
        hash = hash_text(hash, o->overrides.items[i], strlen(o->overrides.items[i]));
    uint8_t* bytes = NULL;
    size_t length = 0;
    if (ty_bytes_read(s->session->context, s->path, (size_t)1 << 28, &bytes, &length) == TY_OK)
        hash = hash_text(hash, (const char*)bytes, length);
    else
        hash = hash_text(hash, s->path, strlen(s->path)); /* builtin:NAME, or a file that rendering will tell of */
    ty_bytes_destroy(s->session->context, bytes, length);
    ty_take_error(s->session->context);
    snprintf(s->key, sizeof s->key, "%016" PRIx64, hash);
}

/* True if the frame's image is whole and of this command. Images are renamed into place, so that a part of one is none.
 */
static bool is_finished(sequence* s, int32_t frame) {
    char name[NAME_SIZE];
    ty_image* image = NULL;
    const char* const others[] = {s->options->png, s->options->denoised_png};
    for (int i = 0; i < 2; ++i)
        if (others[i] != NULL && (!name_frame(others[i], frame, name) || access(name, R_OK) != 0)) return false;
    if (!name_frame(s->options->output, frame, name) || access(name, R_OK) != 0) return false;
    const ty_result result = ty_image_read(s->session->context, name, &image);
    const char* key = result == TY_OK ? ty_image_get_metadata(image, RENDER_KEY) : NULL;
    const bool finished = key != NULL && strcmp(key, s->key) == 0;
    ty_image_destroy(image);
    ty_take_error(s->session->context);
    return finished;
}

/* ---- frames ---- */

static ty_result load_frame(const sequence* s, int32_t frame, ty_scene** out) {
    cli_list overrides = s->options->overrides;
    char text[32];
    snprintf(text, sizeof text, "frame=%d", (int)frame);
    overrides.items[overrides.count++] = text;
    return ty_scene_load(s->session->context, s->path, overrides.items, overrides.count, out);
}

/* Returns the exit status; *light: of the frame before, and then of this one. */
static int render_frame(sequence* s, int32_t frame, void** light) {
    char names[3][NAME_SIZE];
    const char* const patterns[] = {s->options->output, s->options->png, s->options->denoised_png};
    render_options options = *s->options;
    ty_scene* scene = NULL;
    for (int i = 0; i < 3; ++i)
        if (patterns[i] != NULL) name_frame(patterns[i], frame, names[i]);
    options.output = names[0];
    options.png = patterns[1] != NULL ? names[1] : NULL;
    options.denoised_png = patterns[2] != NULL ? names[2] : NULL;
    options.resume = false;
    options.part[1] = 0;
    options.key = s->key;
    options.light = light;
    const ty_result result = load_frame(s, frame, &scene);
    if (result != TY_OK) return cli_fail_reading(s->session, result);
    cli_checkpoint none = {.session = s->session};
    cli_report report = {.method = "", .complete = false};
    const int status = render_scene(s->session, scene, &options, &none, NULL, &report);
    ty_scene_destroy(scene);
    return status == CLI_DONE ? CLI_GO : status;
}

static int render_chain(sequence* s, int32_t chain) {
    void* light = NULL;
    int32_t first, end;
    int status = CLI_GO;
    chain_frames(s, chain, &first, &end);
    for (int32_t i = first; i < end && status == CLI_GO; ++i) {
        status = cli_interrupted() ? CLI_INTERRUPTED : render_frame(s, frame_number(s, i), &light);
    }
    if (light != NULL) s->method->destroy(light);
    return status;
}

/* A chain of this rank, or of another one, has come to an end. */
static void end_chain(sequence* s, int32_t chain, int32_t rank, int status) {
    int32_t first, end;
    chain_frames(s, chain, &first, &end);
    pthread_mutex_lock(&s->lock);
    if (status == CLI_GO) s->finished += end - first;
    if (status != CLI_GO && s->status == CLI_GO) s->status = status;
    if (status == CLI_GO && !s->session->common.quiet) {
        cli_progress_clear(&s->session->progress);
        printf("frames %d to %d: rank %d; %d of %d frames\n", (int)frame_number(s, first),
               (int)frame_number(s, end - 1), (int)rank, (int)(s->before + s->finished), (int)s->frame_count);
        fflush(stdout);
    }
    pthread_mutex_unlock(&s->lock);
}

/* ---- rank 0 ---- */

static int64_t lend(void* user, int64_t max_count, int64_t* first) {
    (void)max_count;
    sequence* s = user;
    if (s->status != CLI_GO || cli_interrupted()) return 0;
    return ty_blocks_lend(&s->blocks, 1, ty_queue_ranks(s->session->queue), first);
}

static void pack(void* user, int64_t first, int64_t count, ty_buffer* out) {
    (void)count;
    const sequence* s = user;
    ty_buffer_add(out, &s->chains[first], sizeof *s->chains);
}

/* The result of a chain: the exit status, the rank, and a message. */
typedef struct chain_result {
    int32_t status, rank;
    char message[MESSAGE_SIZE];
} chain_result;

static void accept(void* user, int64_t first, int64_t count, const uint8_t* bytes, size_t size) {
    (void)count;
    sequence* s = user;
    chain_result result;
    if (size != sizeof result || first < 0 || first >= s->blocks.count || !ty_blocks_return(&s->blocks, first)) return;
    memcpy(&result, bytes, sizeof result);
    result.message[MESSAGE_SIZE - 1] = '\0';
    if (result.status != CLI_GO && s->status == CLI_GO) cli_fail(result.status, "%s", result.message);
    end_chain(s, s->chains[first], result.rank, result.status);
    ty_blocks_settle(&s->blocks);
}

static void render_own(sequence* s, int64_t block) {
    end_chain(s, s->chains[block], 0, render_chain(s, s->chains[block]));
}

static bool goes_on(const sequence* s) {
    return s->status == CLI_GO && !cli_interrupted();
}

/* The chains of other ranks that do not come back are rendered here. */
static void wait_for_others(sequence* s) {
    const double begun = ty_wall_seconds();
    while (goes_on(s) && atomic_load(&s->blocks.away) > 0) {
        const struct timespec pause = {.tv_nsec = 5000000};
        nanosleep(&pause, NULL);
        if (ty_wall_seconds() - begun < ty_queue_patience(s->session->queue)) continue;
        for (int64_t i = 0; i < s->blocks.count && goes_on(s); ++i)
            if (ty_blocks_take_back(&s->blocks, i)) render_own(s, i);
    }
}

static int render_chains(sequence* s) {
    const ty_job job = {TY_JOB_FRAMES, s, lend, pack, accept};
    if (!ty_blocks_create(&s->blocks, s->chain_count)) return cli_fail(CLI_FAILED, "not enough memory");
    const bool shared = s->session->queue != NULL && ty_queue_begin(s->session->queue, &job, NULL, 0);
    for (int64_t i = 0; i < s->blocks.count && goes_on(s); ++i)
        if (ty_blocks_take(&s->blocks, i)) render_own(s, i);
    if (shared) wait_for_others(s);
    if (shared) ty_queue_end(s->session->queue);
    ty_blocks_destroy(&s->blocks);
    if (cli_interrupted()) return CLI_INTERRUPTED;
    return s->status;
}

/* Lists the chains of this part that have an unfinished frame: a chain starts at its beginning, so that its light is
 * the same. */
static int list_chains(sequence* s) {
    const int32_t chains = (frames_of(s) + s->options->chain - 1) / s->options->chain, *part = s->options->part;
    s->chains = calloc((size_t)chains, sizeof *s->chains);
    if (s->chains == NULL) return cli_fail(CLI_FAILED, "not enough memory");
    for (int32_t c = 0; c < chains; ++c) {
        int32_t first, end;
        if (part[1] > 0 && c % part[1] != part[0] - 1) continue;
        chain_frames(s, c, &first, &end);
        bool finished = s->options->resume;
        for (int32_t i = first; i < end && finished; ++i) finished = is_finished(s, frame_number(s, i));
        s->frame_count += end - first;
        if (finished)
            s->before += end - first;
        else
            s->chains[s->chain_count++] = c;
    }
    return CLI_GO;
}

static void report_stats(json_writer* json, const void* user) {
    const sequence* s = user;
    json_text(json, "method", s->method->name);
    json_int(json, "frames", s->frame_count);
    json_int(json, "frames_rendered", s->finished);
    json_int(json, "frames_before", s->before);
}

static int run_rank_0(sequence* s, const ty_scene* scene) {
    int status = cli_ranks_greet(s->session, scene);
    if (status == CLI_GO) status = list_chains(s);
    if (status != CLI_GO) return status;
    s->session->stats = report_stats;
    s->session->stats_user = s;
    if (s->before > 0 && !s->session->common.quiet)
        printf("%d of %d frames were finished before\n", (int)s->before, (int)s->frame_count);
    status = render_chains(s);
    return status == CLI_GO ? CLI_DONE : status;
}

/* ---- the other ranks ---- */

static bool begin_job(void* user, const uint8_t* bytes, size_t size, void** job) {
    (void)bytes;
    (void)size;
    *job = user;
    return true;
}

static bool do_task(void* user, int64_t first, int64_t count, const uint8_t* bytes, size_t size, ty_buffer* out) {
    (void)first;
    (void)count;
    sequence* s = user;
    int32_t chain;
    if (size != sizeof chain) return false;
    memcpy(&chain, bytes, sizeof chain);
    chain_result result = {.rank = ty_comm_rank(s->session->comm)};
    result.status = render_chain(s, chain);
    if (result.status != CLI_GO)
        snprintf(result.message, sizeof result.message, "rank %d: %s", (int)result.rank, cli_last_message());
    ty_buffer_add(out, &result, sizeof result);
    return true;
}

static void end_job(void* job) {
    (void)job;
}

static int run_other_rank(sequence* s, int status, const ty_scene* scene) {
    const ty_job_worker workers[TY_JOB_KINDS] = {[TY_JOB_FRAMES] = {begin_job, do_task, end_job, s}};
    cli_ranks_hello(s->session, status, scene);
    return cli_ranks_serve(s->session, workers, NULL);
}

/* Trials by time would choose other methods for other frames. */
static int choose_method(sequence* s, const ty_scene* scene) {
    const ty_render_settings settings = ty_scene_render_settings(scene);
    s->method = cli_find_method("render", s->options->method != NULL ? s->options->method : settings.method);
    if (s->method == NULL) return CLI_USAGE;
    if (s->method == &cli_method_auto)
        return cli_usage_error("render", "--frames: which method? Method auto may choose another for each frame");
    s->options->method = s->method->name;
    if (s->method->destroy == NULL && !s->options->chain_given) s->options->chain = 1;
    make_key(s);
    return CLI_GO;
}

int render_sequence(cli_session* session, const char* path, render_options* options) {
    sequence s = {.session = session, .path = path, .options = options, .status = CLI_GO};
    ty_scene* scene = NULL;
    if (options->overrides.count == CLI_LIST_MAX)
        return cli_session_close(session, cli_usage_error("render", "there are too many -D beside --frames"));
    pthread_mutex_init(&s.lock, NULL);
    if (session->progress.mode != CLI_JSON) session->progress.mode = CLI_NONE; /* chains are progress enough */
    cli_end_on_interrupt(true);
    const ty_result result = load_frame(&s, options->frames[0], &scene);
    cli_end_on_interrupt(false);
    int status = result == TY_OK ? choose_method(&s, scene) : cli_fail_reading(session, result);
    if (cli_ranks_helps(session))
        status = run_other_rank(&s, status, scene);
    else if (status == CLI_GO)
        status = run_rank_0(&s, scene);
    ty_scene_destroy(scene);
    status = cli_session_close(session, status);
    pthread_mutex_destroy(&s.lock);
    free(s.chains);
    return status;
}
