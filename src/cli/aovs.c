/* --aov: the channels beside R, G and B. */
#include "cli/aovs.h"
#include "cli/options.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { WORDS_MAX = 16 };

static int unknown_aov(const char* command, const char* word, const cli_aov_word* words, int count) {
    const char* names[WORDS_MAX];
    char known[256] = "";
    for (int i = 0; i < count; ++i) {
        names[i] = words[i].name;
        const size_t used = strlen(known);
        snprintf(known + used, sizeof known - used, "%s%s", i == 0 ? "" : ", ", words[i].name);
    }
    const char* nearest = cli_nearest(word, names, count);
    if (nearest != NULL) return cli_usage_error(command, "--aov: unknown '%s'; did you mean '%s'?", word, nearest);
    return cli_usage_error(command, "--aov: unknown '%s'; known: %s", word, known);
}

int cli_parse_aov_words(const char* command, const char* text, const cli_aov_word* words, int count, uint32_t* aovs) {
    *aovs = 0;
    for (const char* at = text; at != NULL;) {
        char word[32];
        const size_t length = strcspn(at, ",");
        snprintf(word, sizeof word, "%.*s", (int)(length < sizeof word ? length : sizeof word - 1), at);
        int found = 0;
        while (found < count && strcmp(word, words[found].name) != 0) ++found;
        if (found == count) return unknown_aov(command, word, words, count);
        *aovs |= words[found].aovs;
        at = at[length] == ',' ? at + length + 1 : NULL;
    }
    return CLI_GO;
}

static const cli_aov_word path_words[] = {
    {"depth", TY_AOV_DEPTH},       {"transmittance", TY_AOV_TRANSMITTANCE},
    {"single", TY_AOV_SINGLE},     {"multiple", TY_AOV_MULTIPLE},
    {"albedo", TY_AOV_ALBEDO},     {"normal", TY_AOV_NORMAL},
    {"variance", TY_AOV_VARIANCE}, {"samples", TY_AOV_SAMPLES},
    {"all", TY_AOV_ALL},
};
enum { PATH_WORDS = sizeof path_words / sizeof path_words[0] };

int cli_parse_aovs(const char* command, const char* text, uint32_t* aovs) {
    return cli_parse_aov_words(command, text, path_words, PATH_WORDS, aovs);
}

const char* cli_aov_outside(uint32_t aovs, uint32_t known) {
    for (int i = 0; i < PATH_WORDS; ++i)
        if (path_words[i].aovs != TY_AOV_ALL && (aovs & path_words[i].aovs & ~known) != 0) return path_words[i].name;
    return NULL;
}

static bool is_even(const float* plane, size_t count) {
    for (size_t i = 1; i < count; ++i)
        if (plane[i] != plane[0]) return false;
    return true;
}

/* A copy of the image without one of its channels; metadata stays behind. */
static ty_result copy_without(ty_context* context, const ty_image* image, int32_t left_out, ty_image** out) {
    const int32_t width = ty_image_width(image), height = ty_image_height(image);
    const int32_t count = ty_image_channel_count(image);
    const char** names = calloc((size_t)count, sizeof *names);
    if (names == NULL) return TY_ERROR_MEMORY;
    int32_t kept = 0;
    for (int32_t i = 0; i < count; ++i)
        if (i != left_out) names[kept++] = ty_image_channel_name(image, i);
    ty_result result = ty_image_create(context, width, height, kept, names, out);
    free(names);
    int32_t frame[4];
    ty_image_get_frame(image, frame);
    if (result == TY_OK) result = ty_image_set_frame(*out, frame[0], frame[1], frame[2], frame[3]);
    for (int32_t i = 0; result == TY_OK && i < kept; ++i)
        memcpy(ty_image_plane(*out, i), ty_image_plane_const(image, i < left_out ? i : i + 1),
               sizeof(float) * (size_t)width * (size_t)height);
    return result;
}

ty_result cli_drop_channel(ty_context* context, ty_image** image, const char* name) {
    const int32_t channel = ty_image_find_channel(*image, name);
    if (channel < 0) return TY_OK;
    ty_image* rest = NULL;
    const ty_result result = copy_without(context, *image, channel, &rest);
    if (result != TY_OK) {
        ty_image_destroy(rest);
        return result;
    }
    ty_image_destroy(*image);
    *image = rest;
    return TY_OK;
}

ty_result cli_drop_even_samples(ty_context* context, ty_image** image) {
    const int32_t channel = ty_image_find_channel(*image, "samples.N");
    const size_t pixels = (size_t)ty_image_width(*image) * (size_t)ty_image_height(*image);
    if (channel < 0 || !is_even(ty_image_plane_const(*image, channel), pixels)) return TY_OK;
    return cli_drop_channel(context, image, "samples.N");
}
