/* tyndall bake: what its parts share. A bake is a list of units, each of which is baked and written whole. */
#ifndef TY_CLI_BAKE_H
#define TY_CLI_BAKE_H

#include "cli/session.h"

#include <tyndall/bake.h>

enum { BAKE_NAME_SIZE = 96, BAKE_PATH_SIZE = 4096, BAKE_KEY_SIZE = 2048, BAKE_ROW = 4096 };

typedef struct bake_options {
    const char *scene, *folder, *probes;
    int method, quality;
    int32_t spp, bounces, scatterings, cells, cell_paths, sh, padding, size[2], grid[3];
    double error, density, grid_spacing;
    const char* grid_text; /* --grid as given */
    bool spp_given, no_back_scattering, lightmaps, vertices, resume, dry_run;
    cli_list overrides;
} bake_options;

typedef enum bake_kind { BAKE_LIGHTMAP, BAKE_VERTICES, BAKE_GRID, BAKE_PROBES } bake_kind;

/* What is baked and written in one go: the primitives of a node, or all points of a grid or a file. */
typedef struct bake_unit {
    bake_kind kind;
    int32_t first, count;      /* meshes of the scene */
    char name[BAKE_NAME_SIZE]; /* of its files, without extension */
    int32_t size[2];           /* pixels of the image, lightmaps and vertices */
    int64_t receivers;         /* about, for lightmaps that are not baked yet */
    double bytes;              /* while it is baked, about */
    bool done, resumed;
    bool apart; /* lightmaps: its primitives' charts overlap, and each has an image of its own */
    double seconds, mean_samples;
    int64_t paths, rays;
} bake_unit;

/* Where the probes of a light grid are: origin + spacing * (x, y, z). */
typedef struct bake_grid {
    int32_t size[3];
    double origin[3], spacing[3];
} bake_grid;

typedef struct bake_plan {
    bake_unit* units;
    int32_t count, capacity;
    bake_grid grid;
    float* probes; /* of --probes */
    int64_t probe_count;
    int32_t lightmapped, by_vertex; /* meshes */
    int64_t receivers, texels;
    double bytes;             /* of the largest unit */
    ty_bake_cache_info cache; /* bytes 0: there will be none */
} bake_plan;

/* A glTF file whose meshes are baked by vertex. */
typedef struct bake_copy {
    const char* file;
    char name[BAKE_NAME_SIZE]; /* of its copy in the folder */
    double scale;              /* irradiance times it is the colour */
} bake_copy;

/* Of all units that are done. */
typedef struct bake_totals {
    int32_t units_done;
    double seconds;
    int64_t paths, rays;
} bake_totals;

/* A bake under way. */
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
    double table_seconds, cache_seconds, started;
    double receivers_done, receivers_skipped; /* skipped: of units that were done before */
    bool complete;
    bake_totals totals;
} bake_run;

/* ---- plan.c ---- */

/* Finds what is to be baked. CLI_GO, or an exit status after a message. Either way the plan is to be freed. */
int bake_make_plan(bake_run* run);
void bake_free_plan(cli_session* session, bake_plan* plan);
void bake_print_plan(const bake_run* run);
/* A mesh's name for messages and files. */
const char* bake_mesh_name(const ty_mesh_def* mesh);
/* The file names of a unit: part -1 for all of it together, or one primitive of a lightmap. */
void bake_image_path(const bake_run* run, const bake_unit* unit, int32_t part, const char* extension,
                     char path[BAKE_PATH_SIZE]);

/* ---- unit.c ---- */

/* Bakes a unit and writes its images. TY_CANCELLED: nothing was written. */
ty_result bake_unit_run(bake_run* run, bake_unit* unit);
/* A ty_progress_fn of the whole work; user is the bake_run. */
bool bake_report_progress(void* user, const ty_progress* progress);
/* The positions of a grid's probes, 3 floats each, to be freed; NULL: no memory. */
float* bake_grid_points(const bake_grid* grid);

/* ---- merge.c ---- */

/* Joins the lightmaps of a mesh's primitives, which share a map, into the first. *apart: their charts overlap, and
 * nothing was done. */
ty_result bake_merge(ty_image* const* images, int32_t count, bool* apart);

/* ---- colors.c ---- */

/* The copies that the plan asks for, to be freed; NULL: no memory. */
bake_copy* bake_list_copies(const bake_run* run, int32_t* count);
/* Whether none of them would take its original's place: CLI_GO, or CLI_USAGE after a message. */
int bake_check_copies(const bake_run* run);
/* Writes them, and sets their scales. */
int bake_write_colors(bake_run* run);

/* ---- state.c ---- */

/* --resume: marks units that an earlier run finished. CLI_GO, or an exit status after a message. */
int bake_read_state(bake_run* run);
ty_result bake_write_state(const bake_run* run);

/* ---- sidecar.c ---- */

/* bake.json. */
ty_result bake_write_sidecar(bake_run* run);
ty_result bake_write_probes(bake_run* run, const ty_bake_probe* probes);
/* For --stats, which are written when the plan is gone. */
void bake_count_totals(bake_run* run);
void bake_report_stats(json_writer* json, const void* user);
extern const char* const bake_method_names[TY_BAKE_PATH + 1];

#endif
