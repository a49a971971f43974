/* What comes out of tyndall screen: an image with channels beside R, G and B, messages, metadata. */
#ifndef TY_CLI_SCREEN_OUTPUT_H
#define TY_CLI_SCREEN_OUTPUT_H

#include "cli/screen_input.h"

typedef struct screen_output {
    ty_image* image;
    /* Planes of the image; those of --aov are NULL where they are not asked for. */
    float *color[3], *attenuated[3], *scattered[3], *spread[3], *distance;
    int32_t channels;
} screen_output;

/* What a call did, for --stats and metadata. */
typedef struct screen_report {
    const screen_options* options;
    const screen_input* input;
    const ty_screen_def* def;
    ty_screen_stats stats;
    double load_seconds;
} screen_report;

/* An image like the input's in place and metadata, R, G and B still 0, with its other channels and those of --aov. */
int screen_create_output(cli_session* session, const screen_report* report, screen_output* out);
/* As cli_fail_running; where memory is short, with what all images and the work take together. */
int screen_fail_running(cli_session* session, const screen_report* report, int32_t channels_out, ty_result result);
/* Metadata, files and closing lines; an exit status. */
int screen_write_output(cli_session* session, const screen_report* report, const screen_output* output);

/* One line each on what was not as it should be: distances, values, spreads, alpha. */
void screen_print_notes(cli_session* session, const screen_report* report);
/* Adds a screen_report to --stats (cli_session.stats). */
void screen_report_stats(json_writer* json, const void* user);

#endif
