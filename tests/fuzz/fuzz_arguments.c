/* The command line: one argument a line, parsed by a table with options of every kind. Accepted values lie in the
 * ranges of the table. Help goes nowhere, and is not asked to write files. */
#include "fuzz_target.h"

#include "cli/options/options.h"
#include "cli/options/raw_options.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

enum { TEXT_MAX = 4096, ARGUMENTS_MAX = 600, POSITIONAL_MAX = 3, LIMIT = 1000 };

typedef struct values {
    bool flag, given;
    const char *text, *raw_size, *raw_type, *raw_spacing;
    cli_list list;
    int32_t number, size[2], crop[4];
    uint64_t seed;
    double real;
    int choice;
} values;

static void check_values(const values* v, const cli_arguments* parsed) {
    if (v->number < -LIMIT || v->number > LIMIT || !(fabs(v->real) <= LIMIT)) abort();
    if (v->choice < 0 || v->choice > 2 || v->list.count < 0 || v->list.count > CLI_LIST_MAX) abort();
    for (int i = 0; i < 2; ++i)
        if (v->size[i] < 1 || v->size[i] > 65536 || v->crop[i] < 0 || v->crop[2 + i] < 1) abort();
    if (parsed->positional_count < 1 || parsed->positional_count > POSITIONAL_MAX) abort();
    if (parsed->common.threads < 0 || parsed->common.threads > 1024) abort();
}

static int parse(int count, char** arguments) {
    values v = {.size = {1, 1}, .crop = {0, 0, 1, 1}};
    const cli_option options[] = {
        {"flag", 'f', CLI_FLAG, NULL, "no value", &v.flag, 0, 0, NULL},
        {"output", 'o', CLI_TEXT, "FILE", "a text", &v.text, 0, 0, NULL},
        {"define", 'D', CLI_LIST, "KEY=VALUE", "a list", &v.list, 0, 0, NULL},
        {"spp", 0, CLI_INT, "N", "a whole number", &v.number, -LIMIT, LIMIT, &v.given},
        {"hash", 0, CLI_SEED, "N", "a seed", &v.seed, 0, 0, NULL},
        {"exposure", 0, CLI_REAL, "STOPS", "a number", &v.real, -LIMIT, LIMIT, NULL},
        {"size", 0, CLI_SIZE, "WxH", "a size", v.size, 0, 0, NULL},
        {"crop", 0, CLI_CROP, "X,Y,WxH", "a part of the frame", v.crop, 0, 0, NULL},
        {"curve", 0, CLI_CHOICE, "none|filmic|linear", "a word", &v.choice, 0, 0, NULL},
        {"raw-size", 0, CLI_TEXT, "X,Y,Z", "voxels", &v.raw_size, 0, 0, NULL},
        {"raw-type", 0, CLI_TEXT, "TYPE", "type", &v.raw_type, 0, 0, NULL},
        {"raw-spacing", 0, CLI_TEXT, "X,Y,Z", "spacing", &v.raw_spacing, 0, 0, NULL},
    };
    const cli_syntax syntax = {"fuzz", "FILE",         "Parses.", NULL, options, sizeof options / sizeof options[0],
                               1,      POSITIONAL_MAX, NULL};
    cli_arguments parsed;
    const int status = cli_parse(&syntax, count, arguments, &parsed);
    if (status == CLI_GO) {
        ty_volume_def def = ty_default_volume_def();
        check_values(&v, &parsed);
        const int raw = cli_parse_raw("fuzz", v.raw_size, v.raw_type, v.raw_spacing, &def);
        if (raw != CLI_GO && raw != CLI_USAGE) abort();
        for (int a = 0; raw == CLI_GO && v.raw_size != NULL && a < 3; ++a)
            if (def.raw_size[a] < 1 || def.raw_size[a] > 16384) abort();
    } else if (status != CLI_USAGE && status != CLI_DONE) {
        abort();
    }
    return status;
}

int LLVMFuzzerTestOneInput(const uint8_t* bytes, size_t size) {
    static FILE* nowhere;
    if (size > TEXT_MAX || (size > 0 && memmem(bytes, size, "help-to", 7) != NULL)) return 0;
    if (nowhere == NULL) {
        nowhere = fopen("/dev/null", "w");
        if (nowhere == NULL) abort();
    }
    char text[TEXT_MAX + 1];
    char* arguments[ARGUMENTS_MAX + 1];
    int count = 0;
    if (size > 0) memcpy(text, bytes, size);
    text[size] = '\0';
    for (char* line = text; line != NULL && count < ARGUMENTS_MAX;) arguments[count++] = strsep(&line, "\n");
    arguments[count] = NULL;
    FILE *const kept_out = stdout, *const kept_error = stderr;
    stdout = nowhere;
    stderr = nowhere;
    parse(count, arguments);
    stdout = kept_out;
    stderr = kept_error;
    return 0;
}
