/* What volume methods take from paths: surfaces, seen through media. */
#ifndef TY_CLI_SURFACES_H
#define TY_CLI_SURFACES_H

#include "cli/methods.h"

/* What the scene's surfaces send through its media, for ty_fld_def.unscattered and the like; *out stays NULL where
 * there are none, and when the work is interrupted, since a part is no picture. Fills in report->path. */
ty_result cli_trace_surfaces(cli_session* session, const ty_scene* scene, const cli_request* request, ty_image** out,
                             cli_report* report);

#endif
