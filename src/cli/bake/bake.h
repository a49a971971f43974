/* tyndall bake: shared types. A bake is a list of units, each of which is baked and written as one. */
#ifndef TY_CLI_BAKE_H
#define TY_CLI_BAKE_H

#include "cli/session/lock.h"

#include <tyndall/bake.h>

/* In the names of denoised lightmaps, before the extension. */
#define BAKE_DENOISED ".denoised"

enum { BAKE_NAME_SIZE = 96, BAKE_PATH_SIZE = 4096, BAKE_KEY_SIZE = 2048, BAKE_ROW = 4096 };

typedef struct bake_options {
    const char *scene, *folder, *probes;
    int method, quality, composition;
    int32_t spp, bounces, scatterings, cells, cell_paths, sh, padding, size[2], grid[3];
    double error, density, grid_spacing;
    const char* grid_text; /* the argument of --grid */
    const char* part_text; /* of --part */
    int32_t part[2];       /* I of N; N 0: all */
    int32_t merge;         /* parts that a merge takes; 0: none */
    bool spp_given, no_back_scattering, lightmaps, vertices, denoise, resume, dry_run;
    cli_list overrides;
} bake_options;

typedef enum bake_kind { BAKE_LIGHTMAP, BAKE_VERTICES, BAKE_GRID, BAKE_PROBES } bake_kind;

/* A unit, baked and written at once: the primitives of a node, or all points of a grid or a file. */
typedef struct bake_unit {
    bake_kind kind;
    int32_t first, count;      /* meshes of the scene */
    char name[BAKE_NAME_SIZE]; /* file name without extension */
    int32_t size[2];           /* pixels of the image, lightmaps and vertices */
    int64_t receivers;         /* estimate for lightmaps that are not baked yet */
    double bytes;              /* estimated peak memory of the bake, bytes */
    bool done, resumed;
    bool overlapping; /* lightmaps: the primitives' charts overlap, so each primitive has its own image */
    double seconds, mean_samples;
    int64_t paths, rays;
} bake_unit;

/* Probe positions of a light grid: origin + spacing * (x, y, z). */
typedef struct bake_grid {
    int32_t size[3];
    double origin[3], spacing[3];
} bake_grid;

typedef struct bake_plan {
    bake_unit* units;
    int32_t count, capacity;
    bake_grid grid;
    float* probes; /* points of --probes, 3 floats each */
    int64_t probe_count;
    int32_t lightmapped, by_vertex; /* number of meshes */
    int64_t receivers, texels;
    double bytes;             /* memory of the largest unit, bytes */
    ty_bake_cache_info cache; /* files to be written; bytes 0: none */
} bake_plan;

/* A glTF file whose meshes are baked by vertex. */
typedef struct bake_copy {
    const char* file;
    char name[BAKE_NAME_SIZE]; /* file name of the copy in the folder */
    double scale;              /* color = scale * irradiance */
} bake_copy;

/* Totals over all finished units. */
typedef struct bake_totals {
    int32_t units_done;
    double seconds;
    int64_t paths, rays;
} bake_totals;

/* The file of a part, in memory. */
typedef struct bake_part_file {
    uint8_t* bytes;
    size_t size, capacity, at; /* at: bytes that were taken, of a file that was read */
} bake_part_file;

/* Of --part, and of --merge. */
typedef struct bake_parts {
    int32_t part, count;   /* part 1..count; 0: all of them, which a merge takes; count 0: a bake in one */
    bake_part_file* files; /* count of them */
} bake_parts;

/* The state of a running bake. */
typedef struct bake_run {
    cli_session* session;
    const bake_options* options;
    ty_scene* scene;
    bake_plan plan;
    bake_copy* copies;
    int32_t copy_count;
    ty_bake_def def;
    ty_impulse* tables;
    ty_bake_cache* cache;
    bool cached; /* there was a cache; its properties outlive it, for --stats */
    ty_bake_cache_info cache_info;
    double table_seconds, started;
    double receivers_done, receivers_skipped; /* skipped: units that an earlier run finished */
    bool complete;
    cli_lock lock; /* of the state, so that two bakes do not mix in one folder */
    bake_totals totals;
    bake_parts parts;
} bake_run;

/* ---- plan.c ---- */

/* Lists the units to be baked. CLI_GO, or an exit status after a message. Either way the caller frees the plan. */
int bake_make_plan(bake_run* run);
void bake_free_plan(cli_session* session, bake_plan* plan);
void bake_print_plan(const bake_run* run);
/* A mesh's name for messages and files. */
const char* bake_mesh_name(const ty_mesh_def* mesh);
/* The file names of a unit: primitive -1 for the whole unit, or one primitive of a lightmap. */
void bake_image_path(const bake_run* run, const bake_unit* unit, int32_t primitive, const char* extension,
                     char path[BAKE_PATH_SIZE]);

/* ---- unit.c ---- */

/* Bakes a unit and writes its images. TY_CANCELLED: nothing was written. */
ty_result bake_unit_run(bake_run* run, bake_unit* unit);
/* A ty_progress_fn over the whole bake; user is the bake_run. */
bool bake_report_progress(void* user, const ty_progress* progress);
/* The probe positions of a grid, 3 floats each; the caller frees them. NULL: no memory. */
float* bake_grid_points(const bake_grid* grid);

/* ---- halves.c ---- */

/* The def of the even (0) or the odd half (1) of the paths. */
ty_bake_def bake_half_def(const ty_bake_def* def, int half);
/* Means of both halves, by their samples. */
void bake_join_halves(const ty_bake_light* even, const ty_bake_light* odd, int64_t count, ty_bake_light* out);

/* ---- merge.c ---- */

/* Merges the lightmaps of a mesh's primitives, which share a map, into the first. *overlapping: their charts overlap,
 * and nothing was merged. */
ty_result bake_merge(ty_image* const* images, int32_t count, bool* overlapping);

/* ---- colors.c ---- */

/* The glTF copies of the plan; the caller frees them. NULL: no memory. */
bake_copy* bake_list_copies(const bake_run* run, int32_t* count);
/* Checks that no copy would overwrite its original: CLI_GO, or CLI_USAGE after a message. */
int bake_check_copies(const bake_run* run);
/* Writes the copies and sets their scales. */
int bake_write_colors(bake_run* run);

/* ---- parts.c ---- */

/* --part, --merge: takes a part's lock, or reads the files of all parts. CLI_GO; CLI_DONE: the part was finished
 * before; or an exit status after a message. Either way the caller closes. */
int bake_open_parts(bake_run* run);
void bake_close_parts(bake_run* run);
/* Writes the file of this part. Errors: TY_ERROR_FILE. */
ty_result bake_write_part(bake_run* run);
/* Light at receivers, or points, as by ty_bake_surfaces and ty_bake_probes: all, those of this part, or what the parts
 * have found. Errors: also TY_ERROR_INPUT. */
ty_result bake_light_surfaces(const bake_run* run, const ty_bake_def* def, const ty_bake_receiver* receivers,
                              int64_t count, ty_bake_light* light, ty_bake_stats* stats);
ty_result bake_light_points(const bake_run* run, const float* points, int64_t count, ty_bake_probe* probes,
                            ty_bake_stats* stats);

/* ---- state.c ---- */

/* The settings that a bake must have in common with an earlier run, or with the other parts, as one line. */
void bake_make_key(const bake_run* run, char key[BAKE_KEY_SIZE]);
/* Takes the lock of the folder's state: CLI_GO, or an exit status after a message. */
int bake_lock(bake_run* run);
/* --resume: marks units that an earlier run finished. CLI_GO, or an exit status after a message. */
int bake_read_state(bake_run* run);
ty_result bake_write_state(const bake_run* run);

/* ---- state_text.c ---- */

typedef enum bake_state_kind {
    BAKE_STATE_TAKEN,
    BAKE_STATE_NONE, /* the text is not a state */
    BAKE_STATE_OTHER /* the state of a bake with another key */
} bake_state_kind;

/* key: the settings as one line, with its end. */
void bake_print_state(FILE* file, const bake_run* run, const char* key);
/* Marks the units that the text lists, once each, and whose files exist. */
bake_state_kind bake_take_state(bake_run* run, const char* key, const char* text);

/* ---- sidecar.c ---- */

/* Writes bake.json. */
ty_result bake_write_sidecar(bake_run* run);
ty_result bake_write_probes(bake_run* run, const ty_bake_probe* probes);
/* The report for --stats, which are written after the plan is freed. */
void bake_count_totals(bake_run* run);
void bake_report_stats(json_writer* json, const void* user);
extern const char* const bake_method_names[TY_BAKE_PATH + 1];

#endif
