/* What `tyndall compare` writes. */
#ifndef TY_CLI_COMPARE_FILES_H
#define TY_CLI_COMPARE_FILES_H

#include "cli/session.h"

enum { CLI_COMPARE_NAME = 64 };

typedef struct cli_compared {
    char name[CLI_COMPARE_NAME]; /* of files: letters, digits and -_. */
    const char* source;          /* the method or the image's file */
    ty_image* image;
    double seconds, spp;      /* negative: not known */
    double own_seconds;       /* without the path-traced image that the method starts from; negative: not known */
    ty_difference difference; /* from the reference; not set for the reference itself */
} cli_compared;

typedef struct cli_comparison {
    const char* folder;
    const char* subject; /* the scene, or NULL */
    double exposure;
    cli_compared reference;
    cli_compared* entries;
    int count;
} cli_comparison;

/* report.html, errors.json, table.md, side.png, a heat_NAME.png for each entry and a view_NAME.png for each image, in
 * the folder; CLI_DONE or an exit status after a message. */
int cli_write_comparison(cli_session* session, const cli_comparison* comparison);

/* The members of errors.json, into the object that is open; user is the cli_comparison (cli_session.stats). */
void cli_comparison_json(json_writer* json, const void* user);

/* folder/prefix NAME extension, to be freed; NULL, after a message, when memory is short. */
char* cli_comparison_path(const char* folder, const char* prefix, const char* name, const char* extension);

#endif
