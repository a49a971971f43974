/* Shared by comparisons of whole scenes' images with path tracing's. */
#ifndef TY_TESTS_TRUTH_SCENE_H
#define TY_TESTS_TRUTH_SCENE_H

#include "truth.h"

enum { BLOCK = 6, DETAILS = TY_AOV_SINGLE | TY_AOV_MULTIPLE | TY_AOV_TRANSMITTANCE };

/* Overrides of an image that make it read a file of TYNDALL_DATA. */
#define DENSITY "media[0].density.file=\"%s\""

/* A scene of the project's, and how near its images come. */
typedef struct scene_case {
    const char* path;
    const char* data;         /* the file of TYNDALL_DATA that its first medium is read from; NULL: none */
    const char* overrides[4]; /* "key=value", the first with %s for that file; NULL: none */
    int32_t width, height, spp;
    double rmse;    /* relative, at most */
    double quarter; /* the same of a quarter of the resolution against all of it; 0: not looked at */
    double ratio;   /* of means, as measured; 0: not looked at */
} scene_case;

static inline ty_scene* read_case(ty_context* context, const scene_case* c) {
    ty_scene* scene = NULL;
    char path[1024], data[1024], file[1200];
    const char* overrides[4];
    int32_t count = 0;
    if (c->data != NULL) {
        snprintf(file, sizeof file, c->overrides[0], data_path(c->data, data));
        overrides[count++] = file;
    }
    for (int i = 1; i < 4 && c->overrides[i] != NULL; ++i) overrides[count++] = c->overrides[i];
    snprintf(path, sizeof path, "%s%s", c->data == NULL ? "" : TYNDALL_SOURCE_DIR "/", c->path);
    must(context, ty_scene_load(context, path, overrides, count, &scene));
    return scene;
}

static inline ty_path_def path_def(const scene_case* c) {
    ty_path_def def = ty_default_path_def();
    def.width = c->width;
    def.height = c->height;
    def.spp = c->spp;
    return def;
}

static inline ty_image* path_image(const ty_scene* scene, const scene_case* c, uint64_t seed) {
    ty_path_def def = path_def(c);
    ty_image* image = NULL;
    def.aovs = DETAILS;
    def.seed = seed;
    must(ty_scene_context(scene), ty_path_render(scene, &def, &image, NULL));
    return image;
}

/* Light of surfaces through the media; NULL where there are none. */
static inline ty_image* surfaces_of(const ty_scene* scene, const scene_case* c) {
    const ty_scene_info info = ty_scene_get_info(scene);
    if (info.shapes + info.meshes == 0) return NULL;
    ty_path_def def = path_def(c);
    ty_image* image = NULL;
    def.unscattered = true;
    must(ty_scene_context(scene), ty_path_render(scene, &def, &image, NULL));
    return image;
}

/* Mean of a block's R, G and B. */
static inline double block_light(const ty_image* image, int x, int y) {
    const float* planes[3];
    double sum = 0;
    assert_true(ty_image_rgb_planes(image, planes));
    for (int i = 0; i < BLOCK * BLOCK; ++i) {
        const size_t at = (size_t)(y + i / BLOCK) * (size_t)ty_image_width(image) + (size_t)(x + i % BLOCK);
        for (int c = 0; c < 3; ++c) sum += (double)planes[c][at];
    }
    return sum / (3 * BLOCK * BLOCK);
}

#endif
