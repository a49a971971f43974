/* A scene, rendered by methods. */
#ifndef TY_CLI_COMPARE_SCENE_H
#define TY_CLI_COMPARE_SCENE_H

#include "cli/compare/comparison.h"
#include "cli/methods.h"

/* What a comparison of methods is asked for. */
typedef struct cli_compare_request {
    const char* methods;   /* "path,fld"; NULL or "all": all there are */
    const char* reference; /* a file; NULL: by path */
    int32_t spp, reference_spp, size[2];
    double reference_seconds, reference_noise;
    bool spp_given, reference_spp_given;
} cli_compare_request;

/* A ty_path_state_fn that keeps the last state in memory, and hands it on; user is a cli_kept_state. */
typedef struct cli_kept_state {
    void* bytes;
    size_t size;
    cli_checkpoint* checkpoint; /* NULL: memory alone */
} cli_kept_state;
bool cli_keep_state(void* user, const void* state, size_t size);

/* The methods that "path,fld" names: how many; -1, after a message, when one is not known. */
int cli_name_methods(const char* words, const ty_method* out[CLI_COMPARE_MAX]);

/* Renders the scene by what applies to it, takes down why others do not, and compares all with the reference, which is
 * read or rendered; images are in the folder then. CLI_GO, or an exit status after a message. */
int cli_compare_scene(cli_session* session, cli_comparison* comparison, const ty_scene* scene,
                      const cli_compare_request* options);

/* The parts of that: images of all methods, in the order of the words; and the reference, in reference.c. */
int cli_render_methods(cli_session* session, cli_comparison* comparison, const ty_scene* scene,
                       const cli_compare_request* options, const cli_request* request);
int cli_refine_reference(cli_session* session, cli_comparison* comparison, const ty_scene* scene,
                         const cli_compare_request* options, const cli_request* request);

/* Sets what is known of an entry from a rendering's report, and writes its image into the folder. */
int cli_keep_rendering(cli_session* session, const cli_comparison* comparison, const cli_report* report,
                       cli_compared* entry);
cli_report cli_begin_report(const ty_scene* scene, const ty_method* method, uint64_t seed);

/* Reads an image with what its metadata tells. */
int cli_read_compared(cli_session* session, const char* path, cli_compared* out);
/* A name of its own for the next entry, from a method or from a path without folder and extension. */
void cli_choose_name(const cli_comparison* comparison, const char* source, char out[CLI_COMPARE_NAME]);

#endif
