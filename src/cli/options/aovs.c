/* --aov: the channels beside R, G and B. */
#include "cli/options/aovs.h"
#include "cli/options/options.h"
#include "image/image.h"

#include <stdio.h>
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
    {"half", TY_AOV_HALF},         {"surface_albedo", TY_AOV_SURFACE_ALBEDO},
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

ty_result cli_drop_even_samples(ty_context* context, ty_image** image) {
    const int32_t channel = ty_image_find_channel(*image, "samples.N");
    const size_t pixels = (size_t)ty_image_width(*image) * (size_t)ty_image_height(*image);
    if (channel < 0 || !is_even(ty_image_plane_const(*image, channel), pixels)) return TY_OK;
    return ty_image_drop_channel(context, image, "samples.N");
}
