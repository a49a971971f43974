/* The automatic choice of a guide by a pilot: a few samples of some pixels, with and without it. */
#include "method/path/guide_choice.h"

#include "base/context.h"
#include "base/parallel.h"
#include "device/device.h"
#include "method/path/state.h"

#include <math.h>

/* Pixels of the pilot, groups of them whose gains tell how uncertain their mean is, and samples of a pixel. */
enum { ITEMS = 1024, GROUPS = 16, ROUND = 4, SAMPLES_MAX = 16 };

/* No more samples once a pilot has had so many vertices. */
static const uint64_t enough_vertices = 400000;

/* Paths of the frame below which a pilot and a solve are not worth their time, about 10 s of one thread, and a bound on
 * the time, s, likewise. A solve takes time by the number of lights, and where there are many a guide has not paid. */
static const double least_paths = 1 << 23, least_seconds = 10;
enum { LIGHTS_MAX = 64 };

/* Processor time of a vertex with a guide over that of one without. */
static const double vertex_time = 1.5;

/* Least gain, with one standard deviation less than was found. */
static const double least_gain = 1.1;

static const uint64_t pilot_seed = 0x6a09e667f3bcc909u;

typedef struct pilot_item {
    ty_path_sums sums;
    uint64_t vertices;
} pilot_item;

typedef struct pilot {
    ty_path_request request;
    ty_path_kernel kernel;
    int64_t pixels; /* of the frame */
    uint32_t samples;
    pilot_item items[ITEMS];
} pilot;

/* Pixels of a golden-ratio sequence, which are even over rows and scattered over columns. */
static void sample_item(void* user, int64_t index, int32_t worker) {
    (void)worker;
    pilot* p = user;
    const uint32_t place = (uint32_t)index * 0x9e3779b1u;
    const int64_t pixel = (int64_t)((uint64_t)place * (uint64_t)p->pixels >> 32);
    pilot_item* item = &p->items[index];
    item->vertices += p->kernel(&p->request, pixel, pixel + 1, p->samples, ROUND, &item->sums, NULL);
}

static uint64_t count_vertices(const pilot* p) {
    uint64_t sum = 0;
    for (int i = 0; i < ITEMS; ++i) sum += p->items[i].vertices;
    return sum;
}

static void sample_pilot(const ty_path_run* run, bool guided, pilot* p) {
    p->request = run->request;
    p->request.seed = pilot_seed;
    p->request.crop[0] = p->request.crop[1] = 0;
    p->request.crop[2] = run->request.width;
    p->request.crop[3] = run->height;
    p->request.first_hit = 0;
    p->request.outlines = NULL;
    p->pixels = (int64_t)run->request.width * run->height;
    p->kernel = guided ? TY_BEST_KERNELS(ty_path_guided_kernel) : TY_BEST_KERNELS(ty_path_kernel);
    if (!guided) p->request.guide = NULL;
    for (p->samples = 0; p->samples < SAMPLES_MAX && count_vertices(p) < enough_vertices; p->samples += ROUND)
        ty_parallel_for(run->context, ITEMS, sample_item, p);
}

/* Sums over the pixels of a group of the variances of a sample. */
static double group_variance(const pilot* p, int group) {
    const double n = p->samples;
    double sum = 0;
    for (int i = group; i < ITEMS; i += GROUPS)
        for (int c = 0; c < 3; ++c) {
            const double mean = p->items[i].sums.mean[c] / n;
            sum += fmax(p->items[i].sums.square[c] - n * mean * mean, 0) / (n - 1);
        }
    return sum;
}

/* Vertices of a path, with one for its start. */
static double path_length(const pilot* p) {
    return 1 + (double)count_vertices(p) / ((double)ITEMS * p->samples);
}

/* Gains by groups of pixels, as logarithms, because a few bright samples make the variance of a group. */
static bool gains(const pilot* without, const pilot* with) {
    const double time = log(vertex_time * path_length(with) / path_length(without));
    double sum = 0, square = 0;
    int count = 0;
    for (int group = 0; group < GROUPS; ++group) {
        const double before = group_variance(without, group), after = group_variance(with, group);
        if (!(before > 0 && after > 0)) continue;
        const double gain = log(before / after) - time;
        sum += gain;
        square += gain * gain;
        ++count;
    }
    if (count < GROUPS / 2) return false;
    const double mean = sum / count, variance = fmax(square / count - mean * mean, 0) / (count - 1);
    return mean - sqrt(variance) > log(least_gain);
}

ty_path_guide_kind ty_path_guide_expected(const ty_path_run* run) {
    const ty_path_def* def = run->def;
    ty_device* device = NULL;
    if (run->request.kind != TY_PATH_PIXELS || run->view.medium_count == 0 || run->request.unscattered != 0 ||
        run->request.enclosed != NULL)
        return TY_PATH_GUIDE_NONE;
    if (def->resume != NULL) return ty_path_state_guide(def->resume, def->resume_size);
    const double paths = (double)run->request.width * run->height * def->spp;
    const bool is_short = paths < least_paths || (def->seconds > 0 && def->seconds < least_seconds);
    if (is_short || run->view.lights.count > LIGHTS_MAX) return TY_PATH_GUIDE_NONE;
    const bool elsewhere = ty_context_device(run->context, &device) != TY_OK || device != NULL;
    return elsewhere ? TY_PATH_GUIDE_NONE : TY_PATH_GUIDE_AUTO;
}

bool ty_path_guide_pays(const ty_path_run* run) {
    pilot* both = ty_alloc_array(run->context, 2, sizeof *both, true);
    if (both == NULL) return false;
    sample_pilot(run, false, &both[0]);
    sample_pilot(run, true, &both[1]);
    const bool pays = gains(&both[0], &both[1]);
    ty_free_array(run->context, both, 2, sizeof *both);
    return pays;
}
