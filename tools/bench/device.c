/* tyndall bench device: whether a GPU gives the bits of its host twin, and how fast it is beside the processor: paths
 * here, other programs in device_programs.c. */
#include "bench/device.h"

#include <stdlib.h>
#include <string.h>

enum { WIDTH = 1280, HEIGHT = 720, TEST_WIDTH = 96, TEST_HEIGHT = 64, TEST_SPP = 4 };
/* Bytes that are copied for a bandwidth, and samples a pixel on the processor, whose time grows with them evenly. */
enum { COPIED = 1 << 28, CPU_SPP = 2, DEVICE_SPP = 16 };

static const char* const scenes[] = {"cube_g0.7", "cornell_fog", "cloud_sky", "lamps", "atrium", "demo"};
enum { SCENES = sizeof scenes / sizeof *scenes };

static ty_result open_context(const bench_session* bench, const char* device, ty_context** out) {
    ty_context_def def = ty_default_context_def();
    def.threads = ty_context_threads(bench->session->context);
    def.device = device;
    return ty_context_create(&def, out);
}

static ty_result open_contexts(const bench_session* bench, bench_contexts* out) {
    *out = (bench_contexts){.device = bench->session->context};
    ty_result result = ty_context_device(out->device, &out->gpu);
    if (result == TY_OK) result = open_context(bench, "cpu", &out->cpu);
    if (result == TY_OK) result = open_context(bench, "host", &out->host);
    return result;
}

static void close_contexts(bench_contexts* all) {
    ty_context_destroy(all->cpu);
    ty_context_destroy(all->host);
}

ty_result bench_device_load(ty_context* context, const char* name, ty_scene** out) {
    char path[64];
    snprintf(path, sizeof path, "builtin:%s", name);
    return ty_scene_load(context, path, NULL, 0, out);
}

static ty_path_def path_def(const bench_session* bench, int32_t width, int32_t height, int32_t spp) {
    ty_path_def def = ty_default_path_def();
    def.width = width;
    def.height = height;
    def.spp = spp;
    def.progress = cli_progress_report;
    def.progress_user = &bench->session->progress;
    return def;
}

/* ---- equal bits ---- */

static ty_result render_test(const bench_session* bench, ty_context* context, const char* name, ty_image** out) {
    ty_path_def def = path_def(bench, TEST_WIDTH, TEST_HEIGHT, TEST_SPP);
    ty_scene* scene = NULL;
    def.aovs = TY_AOV_ALL;
    ty_result result = bench_device_load(context, name, &scene);
    if (result == TY_OK) result = ty_path_render(scene, &def, out, NULL);
    ty_scene_destroy(scene);
    return result;
}

int64_t bench_count_unlike(const ty_image* a, const ty_image* b) {
    const size_t pixels = (size_t)ty_image_width(a) * (size_t)ty_image_height(a);
    int64_t unlike = 0;
    for (int32_t c = 0; c < ty_image_channel_count(a); ++c)
        for (size_t i = 0; i < pixels; ++i)
            unlike += memcmp(ty_image_plane_const(a, c) + i, ty_image_plane_const(b, c) + i, sizeof(float)) != 0;
    return unlike;
}

/* Values of all channels that differ in any bit from the host twin's. */
static ty_result test_scene(const bench_session* bench, const bench_contexts* all, const char* name, int64_t* unlike) {
    ty_image *image = NULL, *expected = NULL;
    ty_result result = render_test(bench, all->device, name, &image);
    if (result == TY_OK) result = render_test(bench, all->host, name, &expected);
    if (result == TY_OK) *unlike = bench_count_unlike(image, expected);
    ty_image_destroy(image);
    ty_image_destroy(expected);
    return result;
}

static ty_result test_all(const bench_session* bench, const bench_contexts* all, int64_t* sum) {
    json_open_object(bench->json, "unlike_values");
    ty_result result = TY_OK;
    *sum = 0;
    for (int i = 0; i < SCENES && result == TY_OK; ++i) {
        int64_t unlike = 0;
        result = test_scene(bench, all, scenes[i], &unlike);
        cli_progress_clear(&bench->session->progress);
        if (result == TY_OK) json_int(bench->json, scenes[i], unlike);
        *sum += unlike;
    }
    json_close_object(bench->json);
    return result;
}

/* ---- times ---- */

/* Median wall seconds of a render by one context, and on a device the seconds that its launches took. */
static ty_result time_scene(const bench_session* bench, ty_context* context, ty_device* gpu, const char* name,
                            int32_t spp, double* seconds, double* launched, uint64_t* vertices) {
    double all[BENCH_DEVICE_RUNS_MAX], on_device[BENCH_DEVICE_RUNS_MAX];
    int32_t size[2];
    bench_pixels(bench->options, WIDTH, HEIGHT, size);
    const ty_path_def def = path_def(bench, size[0], size[1], spp);
    ty_scene* scene = NULL;
    ty_result result = bench_device_load(context, name, &scene);
    for (int run = -1; run < bench->options->runs && result == TY_OK; ++run) {
        ty_path_stats stats = ty_default_path_stats();
        ty_image* image = NULL;
        if (gpu != NULL) gpu->backend->time(gpu);
        result = ty_path_render(scene, &def, &image, &stats);
        if (run >= 0) all[run] = stats.seconds;
        if (run >= 0 && gpu != NULL) on_device[run] = gpu->backend->time(gpu);
        *vertices = stats.vertices;
        ty_image_destroy(image);
    }
    ty_scene_destroy(scene);
    if (result != TY_OK) return result;
    *seconds = bench_median(all, bench->options->runs);
    *launched = gpu != NULL ? bench_median(on_device, bench->options->runs) : 0;
    return TY_OK;
}

/* All times are those of one sample a pixel. */
static ty_result time_all(const bench_session* bench, const bench_contexts* all) {
    json_writer* json = bench->json;
    json_open_object(json, "scenes");
    ty_result result = TY_OK;
    for (int i = 0; i < SCENES && result == TY_OK; ++i) {
        double seconds = 0, launched = 0, cpu = 0, none = 0;
        uint64_t vertices = 0, cpu_vertices = 0;
        const int32_t spp = bench->options->quick ? CPU_SPP : DEVICE_SPP;
        result = time_scene(bench, all->device, all->gpu, scenes[i], spp, &seconds, &launched, &vertices);
        if (result == TY_OK) result = time_scene(bench, all->cpu, NULL, scenes[i], CPU_SPP, &cpu, &none, &cpu_vertices);
        cli_progress_clear(&bench->session->progress);
        if (result != TY_OK) break;
        json_open_object(json, scenes[i]);
        bench_numbers(json, {"device_seconds", seconds / spp}, {"launched_seconds", launched / spp},
                      {"cpu_seconds", cpu / CPU_SPP}, {"mvertices_per_second", 1e-6 * (double)vertices / launched},
                      {"times_as_fast", cpu / CPU_SPP / (seconds / spp)});
        json_close_object(json);
    }
    json_close_object(json);
    return result;
}

/* Copies to the device and back, 1e9 bytes a second. */
static ty_result time_copies(const bench_session* bench, ty_device* gpu) {
    const ty_device_backend* backend = gpu->backend;
    const size_t bytes = bench->options->quick ? COPIED / 64 : COPIED;
    double to[BENCH_DEVICE_RUNS_MAX], from[BENCH_DEVICE_RUNS_MAX];
    void* memory = malloc(bytes);
    ty_address address = 0;
    ty_result result = memory != NULL ? backend->alloc(gpu, bytes, &address) : TY_ERROR_MEMORY;
    if (memory != NULL) memset(memory, 1, bytes);
    for (int run = 0; run < bench->options->runs && result == TY_OK; ++run) {
        const double begun = cli_wall_seconds();
        result = backend->write(gpu, address, memory, bytes);
        const double written = cli_wall_seconds();
        if (result == TY_OK) result = backend->read(gpu, memory, address, bytes);
        to[run] = 1e-9 * (double)bytes / (written - begun);
        from[run] = 1e-9 * (double)bytes / (cli_wall_seconds() - written);
    }
    if (address != 0) backend->free(gpu, address);
    free(memory);
    if (result == TY_OK)
        bench_numbers(bench->json, {"to_device_gb_per_second", bench_median(to, bench->options->runs)},
                      {"from_device_gb_per_second", bench_median(from, bench->options->runs)});
    return result;
}

static void print_device(const bench_session* bench, const ty_device_properties* device) {
    json_text(bench->json, "device", device->name);
    bench_numbers(bench->json, {"memory_bytes", device->memory}, {"processors", device->processors},
                  {"peak_bandwidth", device->bandwidth}, {"peak_flops", device->flops});
}

int bench_device(const bench_session* bench) {
    bench_contexts all;
    int64_t unlike = 0;
    ty_result result = open_contexts(bench, &all);
    if (result == TY_OK && all.gpu == NULL) {
        close_contexts(&all);
        return cli_fail(CLI_USAGE, "bench device: name one, as by --device cuda:0");
    }
    if (result == TY_OK) print_device(bench, &all.gpu->properties);
    if (result == TY_OK) result = time_copies(bench, all.gpu);
    if (result == TY_OK) result = test_all(bench, &all, &unlike);
    if (result == TY_OK) result = time_all(bench, &all);
    if (result == TY_OK) result = bench_device_programs(bench, &all, &unlike);
    close_contexts(&all);
    if (result != TY_OK) return cli_fail_running(bench->session, result);
    if (unlike == 0) return CLI_DONE;
    return cli_fail(CLI_FAILED, "bench device: %lld values differ from those of the host twin", (long long)unlike);
}
