/* Programs of devices other than path: the marcher, screen-space scattering and sweeps, their bits and times. Bytes and
 * operations are counted in the text of the kernels; most bytes of a march come from caches. */
#include "bench/device.h"

#include "image/march/march.h"
#include "scene/scene.h"

#include <tyndall/screen.h>

#include <stdlib.h>
#include <string.h>

enum { CELLS = 32, WIDTH = 1280, HEIGHT = 720, SCREEN_WIDTH = 2000, SCREEN_HEIGHT = 1000 };
enum { LATTICE = CELLS * CELLS * CELLS };

/* Of a step of the marcher: eight cells of a field of sixteen floats and of three planes of a light, and two times
 * eight voxels. Operations: interpolation of the field 240, its bilateral weights 190, its terms and their scattering
 * 90, the light 145, density 110, attenuation and the rest 75. */
static const double step_bytes = 8 * 16 * 4 + 3 * 8 * 4 + 2 * 8 * 4, step_operations = 850;
/* Of a pixel of screen: attenuation and spread of three channels 200, the filters of level 0 120, other levels 90. */
static const double screen_operations = 410;

static void print(const bench_session* bench, const char* name, const ty_device_properties* device,
                  const bench_measurement* m) {
    const double bandwidth = device->bandwidth > 0 ? m->bytes / m->launched / device->bandwidth : 0;
    const double flops = device->flops > 0 ? m->operations / m->launched / device->flops : 0;
    json_open_object(bench->json, name);
    bench_numbers(bench->json, {"device_seconds", m->seconds}, {"launched_seconds", m->launched},
                  {"cpu_seconds", m->cpu}, {"times_as_fast", m->cpu / m->seconds}, {"bytes", m->bytes},
                  {"operations", m->operations}, {"of_peak_bandwidth", bandwidth}, {"of_peak_flops", flops});
    json_int(bench->json, "unlike_values", m->unlike);
    json_close_object(bench->json);
}

/* ---- marching ---- */

static const struct march_case {
    const char *name, *scene;
    int32_t ray_spacing, froxels;
} march_cases[] = {
    {"march_pixels_cloud", "cloud_sun", 1, 0},
    {"march_spaced_cloud", "cloud_sun", 4, 0},
    {"march_froxels_cloud", "cloud_sun", 1, 160},
    {"march_pixels_box", "cornell_fog", 1, 0},
};
enum { MARCH_CASES = sizeof march_cases / sizeof *march_cases };

/* Light that varies evenly, in place of a solved one. */
typedef struct lit_lattice {
    float planes[3 * TY_FIELD_TERMS][LATTICE], guide[LATTICE], fluence[3][LATTICE];
    ty_source_field field;
    ty_light_fluence light;
} lit_lattice;

static lit_lattice* create_lattice(const ty_grid_box* box) {
    lit_lattice* lit = calloc(1, sizeof *lit);
    if (lit == NULL) return NULL;
    for (int32_t i = 0; i < LATTICE; ++i) {
        const float height = (float)(i / CELLS % CELLS) / CELLS;
        for (int c = 0; c < 3; ++c) {
            lit->planes[4 * c][i] = 0.1f + 0.1f * height;
            lit->planes[4 * c + 2][i] = 0.05f * height;
            lit->fluence[c][i] = 1 + height;
        }
        lit->guide[i] = 1 + height;
    }
    lit->field = (ty_source_field){.box = *box, .term_count = TY_FIELD_TERMS, .guide = lit->guide};
    for (int c = 0; c < 3; ++c) {
        for (int t = 0; t < TY_FIELD_TERMS; ++t) lit->field.terms[c][t] = lit->planes[4 * c + t];
        lit->light.fluence[c] = lit->fluence[c];
    }
    lit->light.kind = TY_FLUENCE_DIRECTIONAL;
    lit->light.anchor = ty_vec_make(0, -1, 0);
    return lit;
}

static ty_march_def march_def(const bench_session* bench, const struct march_case* of, const lit_lattice* lit,
                              bool test) {
    ty_march_def def = ty_default_march_def();
    int32_t size[2] = {96, 64};
    if (!test) bench_pixels(bench->options, WIDTH, HEIGHT, size);
    def.width = size[0];
    def.height = size[1];
    def.ray_spacing = of->ray_spacing;
    def.light_box = lit->field.box;
    def.lights = &lit->light;
    def.light_count = 1;
    if (of->froxels == 0) {
        def.field = &lit->field;
    } else {
        def.froxels[0] = of->froxels;
        def.froxels[1] = of->froxels * def.height / def.width;
        def.froxels[2] = 64;
    }
    if (test) def.aovs = TY_MARCH_AOVS;
    return def;
}

/* Median wall seconds of a march by one context, and on a device the seconds that its launches took. */
static ty_result time_march(const bench_session* bench, const ty_scene* scene, const ty_march_def* def, ty_device* gpu,
                            double* seconds, double* launched) {
    double all[BENCH_DEVICE_RUNS_MAX], on_device[BENCH_DEVICE_RUNS_MAX] = {0};
    for (int run = -1; run < bench->options->runs; ++run) {
        ty_image* image = NULL;
        if (gpu != NULL) gpu->backend->time(gpu);
        const double begun = cli_wall_seconds();
        const ty_result result = ty_march(scene, def, &image, NULL);
        if (result != TY_OK) return result;
        ty_image_destroy(image);
        if (run >= 0) all[run] = cli_wall_seconds() - begun;
        if (run >= 0 && gpu != NULL) on_device[run] = gpu->backend->time(gpu);
    }
    *seconds = bench_median(all, bench->options->runs);
    *launched = bench_median(on_device, bench->options->runs);
    return TY_OK;
}

/* The scene of each context is its own. */
static ty_result measure_march(const bench_session* bench, const bench_contexts* all, const struct march_case* of,
                               bench_measurement* m) {
    ty_context* const contexts[3] = {all->cpu, all->host, all->device};
    ty_scene* scenes[3] = {NULL, NULL, NULL};
    ty_image* images[3] = {NULL, NULL, NULL};
    ty_march_stats stats = {.steps = 0};
    ty_grid_box box = {.size = {CELLS, CELLS, CELLS}};
    lit_lattice* lit = NULL;
    ty_result result = TY_OK;
    for (int i = 0; i < 3 && result == TY_OK; ++i) result = bench_device_load(contexts[i], of->scene, &scenes[i]);
    if (result == TY_OK) {
        ty_scene_extent(scenes[0], box.lower, box.upper);
        lit = create_lattice(&box);
        if (lit == NULL) result = TY_ERROR_MEMORY;
    }
    if (result == TY_OK) {
        const ty_march_def test = march_def(bench, of, lit, true), def = march_def(bench, of, lit, false);
        double none;
        for (int i = 1; i < 3 && result == TY_OK; ++i) result = ty_march(scenes[i], &test, &images[i], NULL);
        if (result == TY_OK) m->unlike = bench_count_unlike(images[1], images[2]);
        if (result == TY_OK) result = ty_march(scenes[0], &def, &images[0], &stats);
        if (result == TY_OK) result = time_march(bench, scenes[2], &def, all->gpu, &m->seconds, &m->launched);
        if (result == TY_OK) result = time_march(bench, scenes[0], &def, NULL, &m->cpu, &none);
        m->bytes = step_bytes * (double)stats.steps + 12.0 * def.width * def.height;
        m->operations = step_operations * (double)stats.steps;
    }
    for (int i = 0; i < 3; ++i) {
        ty_image_destroy(images[i]);
        ty_scene_destroy(scenes[i]);
    }
    free(lit);
    return result;
}

/* ---- screen ---- */

typedef struct picture {
    int32_t width, height;
    float* floats; /* red, green, blue, distance, and three outputs */
} picture;

/* Lamps before a slope. */
static bool create_picture(int32_t width, int32_t height, picture* out) {
    const size_t pixels = (size_t)width * (size_t)height;
    *out = (picture){width, height, calloc(pixels, 7 * sizeof(float))};
    for (size_t i = 0; i < pixels && out->floats != NULL; ++i) {
        const size_t x = i % (size_t)width, y = i / (size_t)width;
        for (size_t c = 0; c < 3; ++c)
            out->floats[c * pixels + i] = x % 40 < 3 && y % 40 < 3 ? 50 : 0.1f * (float)(c + 1);
        out->floats[3 * pixels + i] = 3 + 0.1f * (float)(y % 400);
    }
    return out->floats != NULL;
}

static ty_result scatter(ty_context* context, const picture* from, ty_screen_stats* stats) {
    const size_t pixels = (size_t)from->width * (size_t)from->height;
    ty_screen_def def = ty_default_screen_def();
    ty_screen_image image = ty_default_screen_image();
    for (size_t c = 0; c < 3; ++c) {
        def.sigma_s[c] = 0.07f;
        def.sigma_a[c] = 0.002f;
        def.g[c] = 0.9f;
        image.color.data[c] = from->floats + c * pixels;
        image.out.data[c] = from->floats + (4 + c) * pixels;
    }
    def.focal[0] = def.focal[1] = ty_screen_focal(from->height, 40);
    image.width = from->width;
    image.height = from->height;
    image.distance = from->floats + 3 * pixels;
    image.color.row = image.out.row = image.distance_row = from->width;
    return ty_screen_apply(context, &def, &image, NULL, 0, stats);
}

static ty_result time_screen(const bench_session* bench, ty_context* context, ty_device* gpu, const picture* from,
                             ty_screen_stats* stats, double* seconds, double* launched) {
    double all[BENCH_DEVICE_RUNS_MAX], on_device[BENCH_DEVICE_RUNS_MAX] = {0};
    for (int run = -1; run < bench->options->runs; ++run) {
        *stats = ty_default_screen_stats();
        if (gpu != NULL) gpu->backend->time(gpu);
        const ty_result result = scatter(context, from, stats);
        if (result != TY_OK) return result;
        if (run >= 0) all[run] = stats->seconds;
        if (run >= 0 && gpu != NULL) on_device[run] = gpu->backend->time(gpu);
    }
    *seconds = bench_median(all, bench->options->runs);
    *launched = bench_median(on_device, bench->options->runs);
    return TY_OK;
}

static int64_t unlike_pictures(const picture* a, const picture* b) {
    const size_t pixels = (size_t)a->width * (size_t)a->height;
    int64_t unlike = 0;
    for (size_t i = 4 * pixels; i < 7 * pixels; ++i) unlike += memcmp(&a->floats[i], &b->floats[i], sizeof(float)) != 0;
    return unlike;
}

static ty_result measure_screen(const bench_session* bench, const bench_contexts* all, bench_measurement* m) {
    int32_t size[2];
    bench_pixels(bench->options, SCREEN_WIDTH, SCREEN_HEIGHT, size);
    picture on_device = {0}, on_host = {0};
    ty_screen_stats stats, other = ty_default_screen_stats();
    double none;
    ty_result result = TY_ERROR_MEMORY;
    if (create_picture(size[0], size[1], &on_device) && create_picture(size[0], size[1], &on_host))
        result = time_screen(bench, all->device, all->gpu, &on_device, &stats, &m->seconds, &m->launched);
    if (result == TY_OK) result = scatter(all->host, &on_host, &other);
    if (result == TY_OK) {
        const double pixels = (double)size[0] * size[1];
        m->unlike = unlike_pictures(&on_device, &on_host);
        m->operations = screen_operations * pixels;
        /* Light that is passed on is written and read in six planes of each level. */
        m->bytes = stats.memory_bytes + 4.0 / 3.0 * pixels * 12 * sizeof(float);
        result = time_screen(bench, all->cpu, NULL, &on_host, &stats, &m->cpu, &none);
    }
    free(on_device.floats);
    free(on_host.floats);
    return result;
}

/* ---- all ---- */

static const struct {
    const char* name;
    ty_result (*measure)(const bench_session* bench, const bench_contexts* all, bench_measurement* m);
} others[] = {{"screen_scatter", measure_screen},
              {"lpv_propagation", bench_measure_propagation},
              {"dom_solve_64", bench_measure_ordinates}};
enum { OTHERS = sizeof others / sizeof *others };

ty_result bench_device_programs(const bench_session* bench, const bench_contexts* all, int64_t* unlike) {
    ty_result result = TY_OK;
    json_open_object(bench->json, "programs");
    for (int i = 0; i < MARCH_CASES + OTHERS && result == TY_OK; ++i) {
        bench_measurement m = {.unlike = 0};
        result = i < MARCH_CASES ? measure_march(bench, all, &march_cases[i], &m)
                                 : others[i - MARCH_CASES].measure(bench, all, &m);
        if (result == TY_OK)
            print(bench, i < MARCH_CASES ? march_cases[i].name : others[i - MARCH_CASES].name, &all->gpu->properties,
                  &m);
        *unlike += m.unlike;
    }
    json_close_object(bench->json);
    return result;
}
