/* Measurements of a rendering, for --stats and an image's metadata. */
#ifndef TY_CLI_METHODS_REPORT_H
#define TY_CLI_METHODS_REPORT_H

#include "cli/text/json.h"
#include "method/method.h"

#include <tyndall/tyndall.h>

typedef struct cli_report {
    char scene[17]; /* hash */
    size_t scene_bytes;
    const char* method;
    char choice[256];                        /* reason of method auto's choice; "": no choice was made */
    double expected_error, expected_seconds; /* of that choice, on so many threads; 0: none */
    double choice_seconds;                   /* that the choice took */
    const ty_method* ran; /* the method that rendered; NULL: none, or path tracing outside a method */
    ty_method_run run;
    uint64_t seed;
    int32_t width, height;
    double load_seconds;
    double fov_y; /* vertical field of view, degrees; 0: left out */
    bool resumed, complete;
    ty_denoise_stats denoised; /* cookie 0: it was not denoised */
} cli_report;

/* The expectations of a choice as text: "about 2 %, 0.3 s". */
void cli_expectation_text(const cli_report* report, char* out, size_t size);

enum { CLI_STAGES_MAX = 24 };

typedef struct cli_stage {
    char name[24]; /* "march" */
    double seconds;
} cli_stage;

/* Lists the stages of a rendering: path tracing, the stages of the method, and the remainder; returns their number. */
int cli_report_stages(const cli_report* report, cli_stage out[CLI_STAGES_MAX]);

/* Adds a cli_report to --stats (cli_session.stats). */
void cli_report_stats(json_writer* json, const void* user);
ty_result cli_report_metadata(ty_image* image, const cli_report* report);

#endif
