/* States of renders: the bytes as they are, and then with the checksum that they should have, so that what it guards is
 * reached too. A state that is taken up gives a whole image. */
#include "fuzz_target.h"

#include "method/path/state.h"

#include <string.h>
#include <tyndall/tyndall.h>

enum { WIDTH = 9, HEIGHT = 8, SPP = 4, SEED = 3 };

/* A black scene, so that all time goes into reading states. */
static ty_scene* empty_scene(ty_context* context) {
    ty_scene* scene = NULL;
    if (ty_scene_create(context, TY_AXIS_Y, &scene) != TY_OK || ty_scene_commit(scene) != TY_OK) abort();
    return scene;
}

static void resume(const ty_scene* scene, const uint8_t* bytes, size_t size, uint32_t aovs) {
    ty_path_def def = ty_default_path_def();
    def.width = WIDTH;
    def.height = HEIGHT;
    def.spp = SPP;
    def.seed = SEED;
    def.aovs = aovs | TY_AOV_SAMPLES;
    def.resume = bytes;
    def.resume_size = size;
    ty_image* image = NULL;
    if (ty_path_render(scene, &def, &image, NULL) != TY_OK) {
        if (image != NULL) abort();
        return;
    }
    const float* samples = ty_image_plane_const(image, ty_image_find_channel(image, "samples.N"));
    for (int i = 0; i < WIDTH * HEIGHT; ++i)
        if (samples[i] != SPP) abort();
    ty_image_destroy(image);
}

int LLVMFuzzerTestOneInput(const uint8_t* bytes, size_t size) {
    static const uint32_t aovs[] = {TY_AOV_VARIANCE, TY_AOV_ALL};
    size_t used = 0;
    ty_context* context = fuzz_context(&used);
    ty_scene* scene = empty_scene(context);
    uint8_t* sealed = malloc(size + 1);
    if (sealed == NULL) abort();
    memcpy(sealed, bytes, size);
    ty_path_state_seal(sealed, size);
    for (int i = 0; i < 2; ++i) {
        resume(scene, bytes, size, aovs[i]);
        resume(scene, sealed, size, aovs[i]);
    }
    free(sealed);
    ty_scene_destroy(scene);
    fuzz_finish(context, &used);
    return 0;
}
