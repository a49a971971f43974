/* The whole image is on the device, and so are all levels: a launch for each pass over one of them. */
#include "method/screen/device/device.h"

#include "base/context.h"
#include "device/arrays.h"
#include "method/screen/device/launch.h"
#include "method/screen/pyramid.h"

/* Threads of screen_split at most: their counts are summed here. */
enum { THREADS_MAX = 1 << 16, IMAGE_PLANES = 4 };

typedef struct screen_device {
    ty_screen_job* job;
    ty_device_arrays arrays;
    ty_screen_pyramid pyramid;
    ty_screen_device_level levels[TY_SCREEN_LEVELS_MAX + 1];
    ty_screen_launch launch;
    ty_address arguments;
    float* planes; /* the image here, IMAGE_PLANES planes without gaps */
} screen_device;

static void* as_pointer(ty_address address) {
    return (void*)(uintptr_t)address;
}

static size_t texel_count(const ty_screen_level* level) {
    return (size_t)level->width * (size_t)level->height;
}

/* ---- images of callers ---- */

static void pack_row(void* user, int64_t y, int32_t worker) {
    (void)worker;
    const screen_device* on = user;
    const ty_screen_row row = ty_screen_image_row(on->job->image, (int32_t)y);
    const int64_t width = on->job->image->width, pixels = width * on->job->image->height;
    float* to = on->planes + y * width;
    for (int c = 0; c < 3; ++c)
        for (int64_t x = 0; x < width; ++x) to[c * pixels + x] = row.color[c][x * row.color_step];
    for (int64_t x = 0; x < width; ++x) to[3 * pixels + x] = row.distance[x * row.distance_step];
}

static void unpack_row(void* user, int64_t y, int32_t worker) {
    (void)worker;
    const screen_device* on = user;
    const ty_screen_planes* out = &on->job->image->out;
    const int64_t width = on->job->image->width, pixels = width * on->job->image->height;
    const float* from = on->planes + y * width;
    for (int c = 0; c < 3; ++c)
        for (int64_t x = 0; x < width; ++x) out->data[c][y * out->row + x * out->step] = from[c * pixels + x];
}

/* ---- levels ---- */

/* Weights of the texels of the next level along an axis. */
static ty_address place_weights(screen_device* on, int32_t k, int axis) {
    const ty_screen_level *level = &on->pyramid.levels[k], *next = level + 1;
    const int32_t fine = axis == 0 ? level->width : level->height, count = axis == 0 ? next->width : next->height;
    const size_t floats = (size_t)count * TY_SCREEN_DOWN_WEIGHTS;
    float* weights = ty_alloc_array(on->job->context, floats, sizeof *weights, false);
    if (weights == NULL) {
        on->arrays.result = TY_ERROR_MEMORY;
        return 0;
    }
    for (int32_t i = 0; i < count; ++i)
        ty_screen_down_weights(on->pyramid.taps, level->area[axis], fine, i, weights + i * TY_SCREEN_DOWN_WEIGHTS);
    const ty_address address = ty_device_place_constant(&on->arrays, weights, floats * sizeof *weights);
    ty_free_array(on->job->context, weights, floats, sizeof *weights);
    return address;
}

static void place_levels(screen_device* on) {
    for (int32_t k = 0; k <= on->pyramid.level_limit; ++k) {
        const ty_screen_level* level = &on->pyramid.levels[k];
        ty_screen_device_level* own = &on->levels[k];
        *own = (ty_screen_device_level){.width = level->width, .height = level->height};
        memcpy(own->down_fraction, level->down_fraction, sizeof own->down_fraction);
        const size_t bytes = TY_SCREEN_PLANES * texel_count(level) * sizeof(float);
        if (k > 0) own->planes = as_pointer(ty_device_place(&on->arrays, NULL, bytes));
        if (k == on->pyramid.level_limit) continue;
        own->across = as_pointer(place_weights(on, k, 0));
        own->down = as_pointer(place_weights(on, k, 1));
    }
}

static void place_image(screen_device* on) {
    ty_screen_launch* launch = &on->launch;
    const size_t pixels = texel_count(&on->pyramid.levels[0]);
    launch->threads = (int32_t)(pixels < THREADS_MAX ? pixels : THREADS_MAX);
    launch->image = as_pointer(ty_device_place(&on->arrays, on->planes, IMAGE_PLANES * pixels * sizeof(float)));
    launch->out = as_pointer(ty_device_place(&on->arrays, NULL, 3 * pixels * sizeof(float)));
    launch->passed = as_pointer(ty_device_place(&on->arrays, NULL, TY_SCREEN_PLANES * pixels * sizeof(float)));
    launch->counts = as_pointer(ty_device_place(&on->arrays, NULL, (size_t)launch->threads * sizeof *launch->counts));
    on->arguments = ty_device_place(&on->arrays, NULL, sizeof *launch);
}

/* Runs a program for `count` items of level k and the next. */
static void run(screen_device* on, const ty_program* program, int32_t k, size_t count) {
    on->launch.level = on->levels[k];
    if (k < on->pyramid.level_limit) on->launch.next = on->levels[k + 1];
    ty_device_write(&on->arrays, on->arguments, &on->launch, sizeof on->launch);
    ty_device_launch(&on->arrays, program, on->arguments, (int64_t)count);
}

/* Sums the counts of all threads. */
static void read_counts(screen_device* on, ty_screen_counts* sum) {
    const size_t count = (size_t)on->launch.threads;
    ty_context* context = on->job->context;
    ty_screen_device_counts* all = ty_alloc_array(context, count, sizeof *all, false);
    if (all == NULL) on->arrays.result = TY_ERROR_MEMORY;
    ty_device_read(&on->arrays, all, (ty_address)(uintptr_t)on->launch.counts, count * sizeof *all);
    for (size_t i = 0; i < count && on->arrays.result == TY_OK; ++i) {
        sum->nonfinite_fixed += all[i].nonfinite_fixed;
        sum->missing_depth += all[i].missing_depth;
        sum->oversized += all[i].oversized;
        for (int c = 0; c < 3; ++c) sum->largest[c] = ty_maxf(sum->largest[c], all[i].largest[c]);
    }
    ty_free_array(context, all, count, sizeof *all);
}

/* ---- passes ---- */

static void descend(screen_device* on, int32_t levels) {
    const ty_screen_level* level = on->pyramid.levels;
    for (int32_t k = 1; k < levels; ++k) {
        run(on, &ty_program_screen_pass, k, texel_count(&level[k]));
        run(on, &ty_program_screen_down, k, texel_count(&level[k + 1]));
    }
    for (int32_t k = levels - 1; k >= 1; --k) run(on, &ty_program_screen_up, k, texel_count(&level[k]));
}

static void scatter(screen_device* on) {
    ty_screen_job* job = on->job;
    ty_device_arrays* arrays = &on->arrays;
    const ty_screen_level* level = on->pyramid.levels;
    const size_t pixels = texel_count(&level[0]);
    ty_screen_counts counts = {0};
    const double start = ty_wall_seconds();
    ty_screen_parallel(job, job->image->height, pack_row, on);
    place_levels(on);
    place_image(on);
    run(on, &ty_program_screen_split, 0, (size_t)on->launch.threads);
    run(on, &ty_program_screen_down, 0, texel_count(&level[1]));
    read_counts(on, &counts);
    ty_screen_sum_counts(job, &counts, 1);
    const double split = ty_wall_seconds();
    const int32_t levels = ty_screen_pyramid_levels(&on->pyramid, job, &counts, 1);
    descend(on, levels);
    ty_device_wait(arrays);
    const double filtered = ty_wall_seconds();
    run(on, &ty_program_screen_finish, 0, pixels);
    ty_device_read(arrays, on->planes, (ty_address)(uintptr_t)on->launch.out, 3 * pixels * sizeof(float));
    if (arrays->result == TY_OK) ty_screen_parallel(job, job->image->height, unpack_row, on);
    job->stats.step_seconds[0] = split - start;
    job->stats.step_seconds[1] = filtered - split;
    job->stats.step_seconds[2] = ty_wall_seconds() - filtered;
    job->stats.levels = levels;
    job->stats.max_spread = ty_screen_pyramid_radius(&on->pyramid, job, levels);
    job->stats.memory_bytes = ty_screen_pyramid_bytes(&on->pyramid, levels);
    job->stats.isa = arrays->device->backend->name;
}

ty_result ty_screen_scatter_on_device(ty_screen_job* job, ty_device* device) {
    const size_t floats = IMAGE_PLANES * (size_t)job->image->width * (size_t)job->image->height;
    screen_device on = {.job = job, .arrays = {.device = device}};
    ty_arena memory = {.base = job->memory};
    ty_screen_pyramid_lay_out(&on.pyramid, job->def, job->image->width, job->image->height, &memory);
    ty_screen_pyramid_set(&on.pyramid, job);
    on.launch.params = job->params;
    on.launch.taps = on.pyramid.taps;
    memcpy(on.launch.limit, on.pyramid.limit, sizeof on.launch.limit);
    on.planes = ty_alloc_array(job->context, floats, sizeof(float), false);
    if (on.planes == NULL) return TY_ERROR_MEMORY;
    pthread_mutex_lock(&device->busy);
    scatter(&on);
    ty_device_free(&on.arrays);
    pthread_mutex_unlock(&device->busy);
    ty_free_array(job->context, on.planes, floats, sizeof(float));
    return on.arrays.result;
}
