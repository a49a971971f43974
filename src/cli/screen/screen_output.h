/* Outputs of tyndall screen: an image with channels beside R, G and B, messages, metadata. */
#ifndef TY_CLI_SCREEN_SCREEN_OUTPUT_H
#define TY_CLI_SCREEN_SCREEN_OUTPUT_H

#include "cli/screen/screen_input.h"

typedef struct screen_output {
    ty_image* image;
    /* Planes of the image; planes of --aov that were not requested are NULL. */
    float *color[3], *attenuated[3], *scattered[3], *spread[3], *distance;
    int32_t channels;
} screen_output;

/* Statistics of a call, for --stats and metadata. */
typedef struct screen_report {
    const screen_options* options;
    const screen_input* input;
    const ty_screen_def* def;
    ty_screen_stats stats;
    double load_seconds;
} screen_report;

/* Creates an image with the window, metadata and other channels of the input, the channels of --aov, and R, G and B set
 * to 0. */
int screen_create_output(cli_session* session, const screen_report* report, screen_output* out);
/* Like cli_fail_running; a memory error also states the total memory of images and work. */
int screen_fail_running(cli_session* session, const screen_report* report, int32_t channels_out, ty_result result);
/* Writes metadata, files and closing lines; returns an exit status. */
int screen_write_output(cli_session* session, const screen_report* report, const screen_output* output);

/* The curve of a PNG: none for an image from a display-referred file. */
ty_tone_curve screen_choose_curve(const screen_options* options, const char* image_path);

/* Prints one line for each anomaly of distances, values, spreads and alpha. */
void screen_print_notes(cli_session* session, const screen_report* report);
/* Adds a screen_report to --stats (cli_session.stats). */
void screen_report_stats(json_writer* json, const void* user);

#endif
