/* tyndall bench load: time from a volume file to a renderable grid, by format. The files are generated from noise,
 * about half of it empty, and are in the page cache when read. */
#define _GNU_SOURCE
#include "bench/bench.h"

#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { RUNS_MAX = 99, PATH_SIZE = 4096 };

typedef struct load_case {
    const char *name, *extension, *codec;
    ty_grid_type type;
} load_case;

static const load_case cases[] = {
    {"vdb none float", "vdb", "none", TY_GRID_F32},   {"vdb none half", "vdb", "none", TY_GRID_F16},
    {"vdb zip float", "vdb", "zip", TY_GRID_F32},     {"vdb zip half", "vdb", "zip", TY_GRID_F16},
    {"vdb blosc float", "vdb", "blosc", TY_GRID_F32}, {"vdb blosc half", "vdb", "blosc", TY_GRID_F16},
    {"nvdb none", "nvdb", "none", TY_GRID_F32},       {"nvdb zip", "nvdb", "zip", TY_GRID_F32},
    {"nrrd raw", "nrrd", "raw", TY_GRID_F32},         {"nrrd gzip", "nrrd", "gzip", TY_GRID_F32},
};
enum { CASES = sizeof cases / sizeof cases[0] };

typedef struct load_result {
    double seconds, mvoxels, file_bytes; /* mvoxels: 1e6 voxels per second */
} load_result;

/* side^3 voxels of noise, half precision. */
static ty_result make_halves(ty_context* context, int32_t side, ty_grid** out) {
    ty_noise_def noise = ty_default_noise_def();
    noise.kind = TY_NOISE_FBM;
    noise.octaves = 2;
    for (int a = 0; a < 3; ++a) noise.size[a] = side;
    return ty_grid_create_noise(context, &noise, out);
}

/* The same values as float. */
static ty_result make_floats(ty_context* context, const ty_grid* halves, int32_t side, ty_grid** out) {
    ty_grid_def def = ty_default_grid_def();
    for (int a = 0; a < 3; ++a) def.size[a] = side;
    float* values = malloc(sizeof *values * (size_t)side * (size_t)side * (size_t)side);
    if (values == NULL) return TY_ERROR_MEMORY;
    size_t at = 0;
    for (int32_t k = 0; k < side; ++k)
        for (int32_t j = 0; j < side; ++j)
            for (int32_t i = 0; i < side; ++i) values[at++] = ty_grid_voxel(halves, i, j, k);
    def.values = values;
    const ty_result result = ty_grid_create(context, &def, out);
    free(values);
    return result;
}

static ty_result write_case(ty_context* context, const load_case* load, const ty_grid* grid, const char* path) {
    if (strcmp(load->extension, "vdb") == 0) return ty_vdb_write(context, grid, "density", load->codec, path);
    if (strcmp(load->extension, "nvdb") == 0) return ty_nanovdb_write(context, grid, "density", load->codec, path);
    return ty_nrrd_write(context, grid, strcmp(load->codec, "gzip") == 0 ? TY_NRRD_CODEC_GZIP : TY_NRRD_CODEC_RAW,
                         path);
}

/* The median time to read the file. */
static ty_result measure_case(const bench_session* bench, const char* path, load_result* out) {
    ty_context* context = bench->session->context;
    const ty_volume_def def = ty_default_volume_def();
    double seconds[RUNS_MAX];
    double voxels = 0;
    for (int run = 0; run < bench->options->runs; ++run) {
        ty_grid* grid = NULL;
        const double start = cli_wall_seconds();
        const ty_result result = ty_volume_read(context, path, &def, &grid);
        if (result != TY_OK) return result;
        seconds[run] = cli_wall_seconds() - start;
        const ty_grid_info info = ty_grid_get_info(grid);
        voxels = (double)info.size[0] * info.size[1] * info.size[2];
        ty_grid_release(grid);
    }
    out->seconds = bench_median(seconds, bench->options->runs);
    out->mvoxels = 1e-6 * voxels / out->seconds;
    return TY_OK;
}

static double file_bytes(const char* path) {
    FILE* file = fopen(path, "rb");
    if (file == NULL) return 0;
    const double bytes = fseeko(file, 0, SEEK_END) == 0 ? (double)ftello(file) : 0;
    fclose(file);
    return bytes;
}

static void print_result(const bench_session* bench, const load_case* load, const load_result* result) {
    json_open_object(bench->json, load->name);
    bench_numbers(bench->json, {"seconds", result->seconds}, {"mvoxels_per_second", result->mvoxels},
                  {"file_bytes", result->file_bytes});
    json_close_object(bench->json);
}

static ty_result run_case(const bench_session* bench, const load_case* load, ty_grid* const grids[2],
                          const char* folder) {
    char path[PATH_SIZE];
    load_result measured = {0};
    snprintf(path, sizeof path, "%s/volume.%s", folder, load->extension);
    ty_result result = write_case(bench->session->context, load, grids[load->type], path);
    measured.file_bytes = file_bytes(path);
    if (result == TY_OK) result = measure_case(bench, path, &measured);
    unlink(path);
    if (result == TY_OK) print_result(bench, load, &measured);
    return result;
}

static ty_result run_cases(const bench_session* bench, const char* folder) {
    ty_context* context = bench->session->context;
    const int32_t side = bench->options->side;
    ty_grid* grids[2] = {NULL, NULL};
    ty_result result = make_halves(context, side, &grids[TY_GRID_F16]);
    if (result == TY_OK) result = make_floats(context, grids[TY_GRID_F16], side, &grids[TY_GRID_F32]);
    json_int(bench->json, "side", side);
    for (int i = 0; i < CASES && result == TY_OK; ++i) result = run_case(bench, &cases[i], grids, folder);
    ty_grid_release(grids[0]);
    ty_grid_release(grids[1]);
    return result;
}

int bench_load(const bench_session* bench) {
    char folder[BENCH_PATH_SIZE];
    if (bench_make_folder(folder) != CLI_GO) return CLI_FAILED;
    const ty_result result = run_cases(bench, folder);
    rmdir(folder);
    return result == TY_OK ? CLI_DONE : cli_fail_running(bench->session, result);
}
