/* Default render settings. */
#include "scene/settings.h"

#include <string.h>

const ty_render_settings ty_default_settings = {
    .method = "auto",
    .spp = 64,
    .screen = {.variant = "scatter", .spread = "small_angle", .filter = 4, .environment = "around", .balance = true},
    .fld = {.limiter = "levermore_pomraning",
            .boundary = "marshak",
            .solver = "multigrid",
            .beam = "reduced",
            .larsen_power = 2,
            .relaxation = 1.85,
            .tolerance = 1e-3,
            .step = 1,
            .environment_beams = 64,
            .surface_points = 16,
            .spp = 1},
    .pop = {.mode = "split",
            .sharp = true,
            .ordinates = 64,
            .prefilter = 1,
            .importance = true,
            .surface_points = 16,
            .vpls = 64,
            .shadow_texels = 128,
            .clamp = 0.05,
            .residuum = 0.1,
            .tolerance = 1e-2,
            .step = 1,
            .spp = 1},
    .lpv = {.mode = "links",
            .parts = "all",
            .place = "scene",
            .resolution = 32,
            .cascades = 1,
            .bands = 2,
            .extent = 32,
            .window = -1,
            .tolerance = 0.01,
            .map_side = 256,
            .samples = 8,
            .block_side = 3,
            .shadow_side = 512,
            .shadow_rays = true,
            .half = true,
            .step = 1,
            .spp = 1},
    .dom = {.acceleration = "diffusion",
            .directions = 96,
            .tolerance = 1e-3,
            .environment_beams = 64,
            .surface_points = 16,
            .step = 1,
            .spp = 1}};

int32_t ty_setting_index(const char* word, const char* const* words, int32_t count) {
    for (int32_t i = 0; i < count; ++i)
        if (strcmp(word, words[i]) == 0) return i;
    return 0;
}
