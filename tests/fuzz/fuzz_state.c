/* States of renders: the bytes as they are, and then as changes (exclusive or) to a true state, with and without the
 * checksum that belongs to it, so that what it guards is reached too. A state that is taken up gives a whole image. */
#include "fuzz_target.h"

#include "method/path/state.h"

#include <string.h>
#include <tyndall/tyndall.h>

enum { WIDTH = 9, HEIGHT = 8, SPP = 4 };

/* A black scene, so that all time goes into reading states. */
static ty_scene* empty_scene(ty_context* context) {
    ty_scene* scene = NULL;
    if (ty_scene_create(context, TY_AXIS_Y, &scene) != TY_OK || ty_scene_commit(scene) != TY_OK) abort();
    return scene;
}

typedef struct true_state {
    uint8_t* bytes;
    size_t size;
} true_state;

static bool keep(void* user, const void* state, size_t size) {
    true_state* kept = user;
    free(kept->bytes);
    kept->bytes = malloc(size);
    if (kept->bytes == NULL) abort();
    memcpy(kept->bytes, state, size);
    kept->size = size;
    return true;
}

static ty_path_def small_def(uint32_t aovs, int32_t spp) {
    ty_path_def def = ty_default_path_def();
    def.width = WIDTH;
    def.height = HEIGHT;
    def.spp = spp;
    def.aovs = aovs | TY_AOV_SAMPLES;
    return def;
}

static true_state make_state(const ty_scene* scene, uint32_t aovs) {
    true_state kept = {0};
    ty_path_def def = small_def(aovs, SPP / 2);
    def.state = keep;
    def.state_user = &kept;
    ty_image* image = NULL;
    if (ty_path_render(scene, &def, &image, NULL) != TY_OK) abort();
    ty_image_destroy(image);
    return kept;
}

static bool resume(const ty_scene* scene, const void* bytes, size_t size, uint32_t aovs) {
    ty_path_def def = small_def(aovs, SPP);
    def.resume = bytes;
    def.resume_size = size;
    ty_image* image = NULL;
    if (ty_path_render(scene, &def, &image, NULL) != TY_OK) {
        if (image != NULL) abort();
        return false;
    }
    const float* samples = ty_image_plane_const(image, ty_image_find_channel(image, "samples.N"));
    for (int i = 0; i < WIDTH * HEIGHT; ++i)
        if (samples[i] != SPP) abort();
    ty_image_destroy(image);
    return true;
}

static void resume_changed(const ty_scene* scene, const uint8_t* bytes, size_t size, uint32_t aovs) {
    true_state state = make_state(scene, aovs);
    bool changed = false;
    for (size_t i = 0; i < size && i < state.size; ++i) {
        state.bytes[i] ^= bytes[i];
        changed = changed || bytes[i] != 0;
    }
    /* The checksum notices what it guards, and the rest is checked by itself. */
    if (resume(scene, state.bytes, state.size, aovs) == changed) abort();
    ty_path_state_seal(state.bytes, state.size);
    resume(scene, state.bytes, state.size, aovs);
    free(state.bytes);
}

/* Changes behind a true state: what is no whole record is left out or refused, what is one is checked by itself. */
static void resume_with_changes(const ty_scene* scene, const uint8_t* bytes, size_t size, uint32_t aovs) {
    true_state state = make_state(scene, aovs);
    uint8_t* both = malloc(2 * state.size + size);
    if (both == NULL) abort();
    memcpy(both, state.bytes, state.size);
    memcpy(both + state.size, bytes, size);
    resume(scene, both, state.size + size, aovs);
    memcpy(both + state.size, state.bytes, state.size);
    for (size_t i = 0; i < size && i < state.size; ++i) both[state.size + i] ^= bytes[i];
    resume(scene, both, 2 * state.size, aovs);
    ty_path_state_seal(both + state.size, state.size);
    resume(scene, both, 2 * state.size, aovs);
    free(both);
    free(state.bytes);
}

int LLVMFuzzerTestOneInput(const uint8_t* bytes, size_t size) {
    static const uint32_t aovs[] = {TY_AOV_VARIANCE, TY_AOV_ALL};
    size_t used = 0;
    ty_context* context = fuzz_context(&used);
    ty_scene* scene = empty_scene(context);
    for (int i = 0; i < 2; ++i) {
        resume(scene, bytes, size, aovs[i]);
        resume_changed(scene, bytes, size, aovs[i]);
        resume_with_changes(scene, bytes, size, aovs[i]);
    }
    ty_scene_destroy(scene);
    fuzz_finish(context, &used);
    return 0;
}
