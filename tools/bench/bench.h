/* Benches: each has a name and a function; all share the options of `tyndall bench`. */
#ifndef TY_BENCH_H
#define TY_BENCH_H

#include "cli/session/session.h"

enum { BENCH_PATH_SIZE = 1024 };

typedef struct bench_options {
    bool json, quick;
    int32_t spp, size[2], runs, side;
    bool size_given, scenes_given, full, guide;
    const char* scenes;    /* names or paths, comma-separated */
    const char* mesh;      /* file, or NULL */
    const char* reference; /* folder of NAME.exr, or NULL */
    const char* data;      /* folder of third-party data, or NULL */
} bench_options;

typedef struct bench_session {
    cli_session* session;
    const bench_options* options;
    json_writer* json; /* measurements as JSON or YAML; inside an open object of the bench */
} bench_session;

/* Writes numbers as members of the open object: bench_numbers(json, {"cells", cells}, {"seconds", seconds}). */
typedef struct bench_member {
    const char* name;
    double value;
} bench_member;

void bench_write_numbers(json_writer* json, const bench_member* members, size_t count);
#define bench_numbers(json, ...)                                                                                       \
    bench_write_numbers(json, (const bench_member[]){__VA_ARGS__},                                                     \
                        sizeof((const bench_member[]){__VA_ARGS__}) / sizeof(bench_member))

/* Each returns CLI_DONE or an exit status after a message. */
int bench_machine(const bench_session* bench);
int bench_path(const bench_session* bench);
int bench_direct(const bench_session* bench);
int bench_rays(const bench_session* bench);
int bench_screen(const bench_session* bench);
int bench_fld(const bench_session* bench);
int bench_pop(const bench_session* bench);
int bench_lpv(const bench_session* bench);
int bench_dom(const bench_session* bench);
int bench_octaves(const bench_session* bench);
int bench_gradient(const bench_session* bench);
int bench_denoise(const bench_session* bench);
/* Its errors over many scenes, with --full. */
int bench_denoise_errors(const bench_session* bench);
int bench_impulse(const bench_session* bench);
int bench_bake(const bench_session* bench);
int bench_view(const bench_session* bench);
int bench_load(const bench_session* bench);
int bench_edit(const bench_session* bench);
int bench_device(const bench_session* bench);

/* Multiply-add throughput of all threads, 1e9 operations/s: the median of a few runs. 0: no memory. */
double bench_fma_gflops(ty_context* context);
/* The instruction set of the kernels on this machine: "x86-64-v3". */
const char* bench_isa(void);
/* The median of count values; sorts them. */
double bench_median(double* values, int count);
/* Creates a folder for files of a bench, in TMPDIR or /tmp: CLI_GO, or CLI_FAILED after a message. */
int bench_make_folder(char out[BENCH_PATH_SIZE]);
/* A file of scenes/tools in a folder of its own, and the override by which it finds third-party data. */
typedef struct bench_scene_file {
    char folder[BENCH_PATH_SIZE], path[BENCH_PATH_SIZE + 16], override[BENCH_PATH_SIZE + 4096];
} bench_scene_file;
/* Writes a scene whose value `key`, such as "media[0].density.file", is a file of --data: CLI_GO, or CLI_FAILED after a
 * message. */
int bench_write_scene(const bench_options* options, const char* scene, const char* key, const char* file,
                      bench_scene_file* out);
void bench_remove_scene(const bench_scene_file* scene);
/* Size of a bench's images, pixels: --size, else width x height, a quarter of each with --quick. */
void bench_pixels(const bench_options* options, int32_t width, int32_t height, int32_t size[2]);

/* Seconds of path tracing at BENCH_TRUTH_SPP samples a pixel, extrapolated from BENCH_PATH_SPP; size as bench_pixels.
 */
enum { BENCH_PATH_SPP = 4, BENCH_TRUTH_SPP = 1000 };
ty_result bench_time_path(const bench_session* bench, const ty_scene* scene, int32_t width, int32_t height,
                          double* seconds);

#endif
