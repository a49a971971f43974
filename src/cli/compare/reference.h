/* The path-traced reference of a scene. */
#ifndef TY_CLI_COMPARE_REFERENCE_H
#define TY_CLI_COMPARE_REFERENCE_H

#include "cli/compare/comparison.h"
#include "cli/methods/methods.h"

/* Renders the reference until its noise is well below the differences, and measures all entries against it. CLI_GO, or
 * an exit status after a message. */
int cli_refine_reference(cli_session* session, cli_comparison* comparison, const ty_scene* scene,
                         const cli_compare_request* options, const cli_request* request);

#endif
