/* Options for the layout of a raw volume, and of droplets in a NetCDF file. */
#ifndef TY_CLI_OPTIONS_RAW_OPTIONS_H
#define TY_CLI_OPTIONS_RAW_OPTIONS_H

#include <tyndall/io.h>

/* size and spacing: "X,Y,Z"; type: "uint8"; each may be NULL. CLI_GO, or CLI_USAGE after a message. */
int cli_parse_raw(const char* command, const char* size, const char* type, const char* spacing, ty_volume_def* def);

/* Effective radius, micrometres, and density of air, kg/m3: numbers or names, each of which may be NULL. As above. */
int cli_parse_droplets(const char* command, const char* radius, const char* air, ty_volume_def* def);

#endif
