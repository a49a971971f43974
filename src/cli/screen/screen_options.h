/* The parsed command line of tyndall screen. */
#ifndef TY_CLI_SCREEN_SCREEN_OPTIONS_H
#define TY_CLI_SCREEN_SCREEN_OPTIONS_H

#include "cli/session/session.h"

/* The words of --variant: three variants, and two baselines derived from the second. */
typedef enum screen_kind { SCREEN_SCATTER, SCREEN_GATHER, SCREEN_PUBLISHED, SCREEN_NAIVE, SCREEN_EXACT } screen_kind;
#define SCREEN_KINDS "scatter|gather|published|naive|reference"

/* --aov. */
enum { SCREEN_ATTENUATED = 1, SCREEN_SCATTERED = 2, SCREEN_SPREAD = 4, SCREEN_DISTANCE = 8 };

typedef struct screen_options {
    const char* command; /* in messages */
    const char *output, *png, *aov;
    double exposure;
    int curve; /* 0 from the image, 1 none, 2 filmic */

    const char* medium;
    const char* environment; /* ambient light: numbers or a file; NULL: none */
    bool balance;

    double fov_y, focal[2], center[2];
    bool fov_y_given, focal_given, center_given;
    const char *focal_text, *center_text;

    const char* channel; /* channel of the distances; NULL: found by its name */
    double distance_scale;
    bool distance_scale_given;
    int depth_is; /* 0 radial, 1 planar */
    const char* sky;
    double sky_distance; /* m */
    bool fill;           /* --sky fill */

    int spread; /* ty_screen_spread */
    bool spread_given;
    int kind;   /* screen_kind */
    int filter; /* index into 2, 4, 6 */
    const char* levels;
    int32_t level_count; /* or TY_AUTO */
    int32_t window;
    bool window_given;

    /* Options of the gathering variants. */
    int mask; /* ty_screen_mask */
    double mask_width, level_scale;
    bool mask_given, mask_width_given, level_scale_given;
    bool uniform_weights, plain_distance, no_normalise;

    uint32_t aovs;
} screen_options;

/* The options of a command, "screen" or "view". */
screen_options screen_default_options(const char* command);
/* The options of input, medium and method; targets are the fields of *options. */
enum { SCREEN_OPTIONS = 21 };
void screen_list_options(screen_options* options, cli_option out[SCREEN_OPTIONS]);
/* The first of these options that is not at its default, or NULL. */
const char* screen_first_given(screen_options* options);
bool screen_is_given(const cli_option* option, const cli_option* preset);
/* The variants that have an option: bits 1 << screen_kind. */
unsigned screen_kinds_of(const char* name);

/* Checks of these options, as far as they need no file; parses the textual values. Returns an exit status. */
int screen_check_options(screen_options* options);
/* Checks --output, --png and --aov likewise. */
int screen_check_outputs(screen_options* options);
/* The variant and its details. */
void screen_set_variant(const screen_options* options, ty_screen_def* def);
/* Parses "1,2,3" as at least `min_count` and at most 3 numbers; returns their number, 0 on a syntax error. */
int screen_parse_numbers(const char* text, int min_count, double out[3]);

#endif
