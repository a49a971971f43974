/* What a rendering did, for --stats and an image's metadata. */
#ifndef TY_CLI_REPORT_H
#define TY_CLI_REPORT_H

#include "cli/json.h"

#include <tyndall/tyndall.h>

typedef struct cli_report {
    char scene[17]; /* hash */
    size_t scene_bytes;
    const char* method;
    char choice[256];       /* why method auto chose it; "": nothing was to be chosen */
    ty_path_stats path;     /* seconds: of everything, also of what is done with the paths' image */
    double own_seconds;     /* without the path-traced image that the method starts from */
    ty_screen_stats screen; /* method screen alone */
    ty_fld_stats fld;       /* methods fld and cda alone */
    ty_pop_stats pop;       /* method pop alone */
    ty_lpv_stats lpv;       /* method lpv alone */
    ty_dom_stats dom;       /* method dom alone */
    uint64_t seed;
    int32_t width, height;
    double load_seconds;
    double fov_y; /* of the camera, degrees; 0: left out */
    bool resumed, complete;
} cli_report;

/* Parts of what lpv did: maps of lights and what comes of them; the lattice; the picture. */
double cli_lpv_injection_seconds(const ty_lpv_stats* lpv);
double cli_lpv_propagation_seconds(const ty_lpv_stats* lpv);
double cli_lpv_image_seconds(const ty_lpv_stats* lpv);

/* Adds a cli_report to --stats (cli_session.stats). */
void cli_report_stats(json_writer* json, const void* user);
ty_result cli_report_metadata(ty_image* image, const cli_report* report);

#endif
