#include "image/march/device/device.h"

#include "base/context.h"
#include "base/progress.h"
#include "device/arrays.h"
#include "image/image.h"
#include "image/march/device/launch.h"
#include "image/march/edges.h"
#include "image/march/froxels.h"
#include "image/march/gathered.h"
#include "image/march/march.k.h"
#include "scene/packed/packed.h"

/* Items of the first launch of a program whose items march rays, and of one whose items march many. */
enum { FIRST_RAYS = 1 << 16, FIRST_BUNDLES = 1 << 12, ITEMS_MIN = 64 };

typedef struct march_device {
    ty_device_arrays arrays;
    const ty_march_def* def;
    const ty_packed_request* packed;
    ty_packed_scene* scene;
    ty_march_request request; /* with the device's pointers */
    ty_march_launch launch;
    ty_address request_address, arguments, steps;
    size_t steps_capacity;
    ty_marched_on_device* out;
    double begun, reported;
    double done, work; /* items so far, and in all */
} march_device;

static void* as_pointer(ty_address address) {
    return (void*)(uintptr_t)address;
}

static size_t pixel_count(const march_device* on) {
    return (size_t)on->def->width * (size_t)on->def->height;
}

/* ---- the request ---- */

static void take_light(march_device* on, ty_light_fluence* light) {
    ty_device_arrays* arrays = &on->arrays;
    const int32_t* size = on->packed->request.light.size;
    const size_t cells = (size_t)size[0] * (size_t)size[1] * (size_t)size[2];
    for (int c = 0; c < 3; ++c) {
        const size_t count = c == 0 || light->shared == 0 ? cells : 0;
        ty_device_take(arrays, &light->fluence[c], count, sizeof(float));
        ty_device_take(arrays, &light->unscattered[c], count, sizeof(float));
        ty_device_take(arrays, &light->next_order[c], count, sizeof(float));
        for (int a = 0; a < 3; ++a) ty_device_take(arrays, &light->flux[c][a], count, sizeof(float));
    }
    ty_device_take(arrays, &light->legendre, (size_t)light->lobe_order + 2, sizeof(float));
}

static ty_address place_lights(march_device* on, const ty_light_fluence* lights, int32_t count) {
    ty_context* context = on->arrays.device->context;
    if (count == 0 || on->arrays.result != TY_OK) return 0;
    ty_light_fluence* own = ty_alloc_array(context, (size_t)count, sizeof *own, false);
    if (own == NULL) {
        on->arrays.result = TY_ERROR_MEMORY;
        return 0;
    }
    memcpy(own, lights, (size_t)count * sizeof *own);
    for (int32_t i = 0; i < count; ++i) take_light(on, &own[i]);
    const ty_address address = ty_device_place_constant(&on->arrays, own, (size_t)count * sizeof *own);
    ty_free_array(context, own, (size_t)count, sizeof *own);
    return address;
}

static void take_field(march_device* on, ty_upsample_view* view) {
    const int32_t* size = view->lattice.size;
    const size_t cells = (size_t)size[0] * (size_t)size[1] * (size_t)size[2];
    ty_device_take(&on->arrays, &view->cells, cells * (size_t)view->floats, sizeof(float));
    if (view->cuts.of_cell == NULL) return;
    ty_device_take(&on->arrays, &view->cuts.of_cell, on->def->cuts->cells, sizeof *view->cuts.of_cell);
    ty_device_take(&on->arrays, &view->cuts.cuts, (size_t)on->def->cuts->count, sizeof *view->cuts.cuts);
}

static void take_request(march_device* on) {
    ty_device_arrays* arrays = &on->arrays;
    ty_march_request* request = &on->request;
    ty_device_point(&request->scene, on->scene->view);
    ty_device_point(&request->lights, place_lights(on, request->lights, request->light_count));
    ty_march_octaves* octaves = &request->octaves;
    const int32_t octave_lights = octaves->count > 1 ? (octaves->count - 1) * request->light_count : 0;
    ty_device_point(&octaves->lights, place_lights(on, octaves->lights, octave_lights));
    ty_device_take(arrays, &request->blurred, 3 * TY_MARCH_BLUR_CELLS * TY_MARCH_BLUR_CELLS, sizeof(float));
    if (request->has_field != 0) {
        take_field(on, &request->field);
        take_field(on, &request->surface_field);
    }
    ty_irradiance_view* cache = &request->cache;
    if (cache->count == 0) return;
    ty_device_take(arrays, &cache->keys, (size_t)1 << cache->bits, sizeof *cache->keys);
    ty_device_take(arrays, &cache->points, (size_t)1 << cache->bits, sizeof *cache->points);
    ty_device_take(arrays, &cache->irradiance, 3 * (size_t)cache->count, sizeof *cache->irradiance);
}

/* Gives the request to the device anew, after a change. */
static void write_request(march_device* on) {
    ty_device_write(&on->arrays, on->request_address, &on->request, sizeof on->request);
}

static void place_planes(march_device* on) {
    ty_march_launch* launch = &on->launch;
    const uint32_t aovs = on->def->aovs;
    const float* unscattered[3];
    for (int g = 0; g < TY_AOV_GROUPS; ++g)
        for (int32_t c = 0; ty_aov_is_requested(&ty_aov_groups[g], aovs) && c < ty_aov_groups[g].count; ++c)
            launch->channels[launch->channel_count++] = (ty_march_channel){ty_aov_groups[g].aov, c};
    const size_t bytes = pixel_count(on) * sizeof(float);
    launch->planes = as_pointer(ty_device_place(&on->arrays, NULL, (size_t)launch->channel_count * bytes));
    if (on->def->unscattered == NULL) return;
    ty_image_rgb_planes(on->def->unscattered, unscattered);
    for (int c = 0; c < 3; ++c)
        launch->unscattered[c] = as_pointer(ty_device_place(&on->arrays, unscattered[c], bytes));
}

/* ---- launches ---- */

static ty_result report(march_device* on, bool always) {
    const ty_march_def* def = on->def;
    if (def->progress == NULL || !(ty_report_due(&on->reported) || always)) return TY_OK;
    const ty_progress progress = ty_progress_at("march", on->done / on->work, ty_wall_seconds() - on->begun);
    return def->progress(def->progress_user, &progress) ? TY_OK : TY_CANCELLED;
}

/* Adds the steps of the launch's items to the statistics. */
static void count_steps(march_device* on, size_t count) {
    ty_context* context = on->arrays.device->context;
    if (!on->out->stats || on->arrays.result != TY_OK) return;
    uint32_t* steps = ty_alloc_array(context, count, sizeof *steps, false);
    if (steps == NULL) {
        on->arrays.result = TY_ERROR_MEMORY;
        return;
    }
    ty_device_read(&on->arrays, steps, on->steps, count * sizeof *steps);
    for (size_t i = 0; i < count && on->arrays.result == TY_OK; ++i) on->out->steps += steps[i];
    ty_free_array(context, steps, count, sizeof *steps);
}

/* Runs a program for all its items, in launches that can be cancelled in between. */
static void run(march_device* on, const ty_program* program, int64_t count, uint32_t items) {
    ty_device_arrays* arrays = &on->arrays;
    ty_march_launch* launch = &on->launch;
    for (launch->begin = 0; launch->begin < count && arrays->result == TY_OK;) {
        const int64_t left = count - launch->begin, many = left < items ? left : items;
        if (on->out->stats && (size_t)many > on->steps_capacity) {
            on->steps = ty_device_place(arrays, NULL, (size_t)many * sizeof(uint32_t));
            on->steps_capacity = (size_t)many;
        }
        launch->steps = as_pointer(on->steps);
        const double begun = ty_wall_seconds();
        ty_device_write(arrays, on->arguments, launch, sizeof *launch);
        ty_device_launch(arrays, program, on->arguments, many);
        ty_device_wait(arrays);
        items = ty_device_next_launch(items, ty_wall_seconds() - begun, ITEMS_MIN);
        count_steps(on, (size_t)many);
        launch->begin += many;
        on->done += (double)many;
        if (arrays->result == TY_OK) arrays->result = report(on, false);
    }
}

/* ---- kinds of images ---- */

static void find_edges(march_device* on) {
    ty_edges_view* edges = &on->request.edges;
    const int32_t width = on->def->width, height = on->def->height;
    const size_t bordered = ((size_t)width + 2) * ((size_t)height + 2);
    if (!ty_edges_may_exist(&on->packed->request, width, height, on->def->edge_rays)) return;
    *edges = (ty_edges_view){.rays = on->def->edge_rays, .width = width, .pixels = pixel_count(on)};
    edges->marked = as_pointer(ty_device_place(&on->arrays, NULL, edges->pixels));
    on->launch.faces = as_pointer(ty_device_place(&on->arrays, NULL, bordered * sizeof *on->launch.faces));
    on->work += (double)bordered + (double)edges->pixels;
    write_request(on);
    run(on, &ty_program_march_faces, (int64_t)bordered, FIRST_RAYS);
    run(on, &ty_program_march_edges, (int64_t)edges->pixels, FIRST_RAYS);
}

static void gather(march_device* on, const ty_scene* scene) {
    ty_gathered_view* view = &on->request.gathered;
    const ty_gathered_view laid_out = ty_gathered_lay_out(scene, &on->packed->request, on->def->width, on->def->height);
    const size_t count = (size_t)laid_out.columns * (size_t)laid_out.rows;
    if (count == 0) return;
    *view = laid_out;
    view->points = as_pointer(ty_device_place(&on->arrays, NULL, count * sizeof *view->points));
    on->launch.smoothed = as_pointer(ty_device_place(&on->arrays, NULL, count * sizeof *view->points));
    on->work += 2 * (double)count;
    write_request(on);
    run(on, &ty_program_march_gathered, (int64_t)count, FIRST_BUNDLES);
    run(on, &ty_program_march_smoothed, (int64_t)count, FIRST_RAYS);
    view->points = on->launch.smoothed;
    write_request(on);
}

static void march_pixels(march_device* on, const ty_scene* scene) {
    if (ty_march_gathers(on->def, &on->packed->request)) gather(on, scene);
    find_edges(on);
    run(on, &ty_program_march_pixels, (int64_t)pixel_count(on), FIRST_RAYS);
}

static void march_spaced(march_device* on) {
    const ty_march_def* def = on->def;
    ty_march_launch* launch = &on->launch;
    ty_spaced_rays* lattice = &launch->lattice;
    *lattice = (ty_spaced_rays){.spacing = def->ray_spacing,
                                .width = def->width,
                                .height = def->height,
                                .columns = ty_spaced_count(def->width, def->ray_spacing),
                                .rows = ty_spaced_count(def->height, def->ray_spacing)};
    const size_t rays = (size_t)lattice->columns * (size_t)lattice->rows;
    lattice->rays = as_pointer(ty_device_place(&on->arrays, NULL, rays * sizeof *lattice->rays));
    if (def->spp > 1)
        launch->sums = as_pointer(ty_device_place(&on->arrays, NULL, pixel_count(on) * sizeof *launch->sums));
    on->work = def->spp * ((double)rays + (double)pixel_count(on));
    for (launch->sample = 0; launch->sample < def->spp; ++launch->sample) {
        launch->last = launch->sample + 1 == def->spp;
        run(on, &ty_program_march_rays, (int64_t)rays, FIRST_RAYS);
        run(on, &ty_program_march_between, (int64_t)pixel_count(on), FIRST_RAYS);
    }
}

/* Depths of the slices, from the ranges of all columns. */
static void set_slices(march_device* on, size_t columns) {
    ty_context* context = on->arrays.device->context;
    ty_froxel_view* grid = &on->request.froxels;
    const size_t end_count = (size_t)grid->size[2] + 1;
    float* ranges = ty_alloc_array(context, 2 * columns, sizeof *ranges, false);
    float* ends = ty_alloc_array(context, end_count, sizeof *ends, false);
    float range[2] = {TY_FLOAT_MAX, 0};
    if (ranges == NULL || ends == NULL) on->arrays.result = TY_ERROR_MEMORY;
    ty_device_read(&on->arrays, ranges, (ty_address)(uintptr_t)on->launch.ranges, 2 * columns * sizeof *ranges);
    for (size_t i = 0; i < columns && on->arrays.result == TY_OK; ++i) {
        range[0] = ty_minf(range[0], ranges[2 * i]);
        range[1] = ty_maxf(range[1], ranges[2 * i + 1]);
    }
    if (on->arrays.result == TY_OK) ty_froxels_set_ends(grid, range, ends);
    grid->ends = as_pointer(ty_device_place(&on->arrays, ends, end_count * sizeof *ends));
    ty_free_array(context, ranges, 2 * columns, sizeof *ranges);
    ty_free_array(context, ends, end_count, sizeof *ends);
}

static void march_froxels(march_device* on) {
    ty_froxel_view* grid = &on->request.froxels;
    *grid = ty_froxels_lay_out(on->def->froxels, on->def->width, on->def->height);
    const size_t columns = (size_t)grid->size[0] * (size_t)grid->size[1];
    on->launch.ranges = as_pointer(ty_device_place(&on->arrays, NULL, 2 * columns * sizeof *on->launch.ranges));
    grid->froxels = as_pointer(ty_device_place(&on->arrays, NULL, ty_froxels_count(grid) * sizeof *grid->froxels));
    on->work += 2 * (double)columns;
    write_request(on);
    run(on, &ty_program_march_ranges, (int64_t)columns, FIRST_RAYS);
    set_slices(on, columns);
    write_request(on);
    run(on, &ty_program_march_columns, (int64_t)columns, FIRST_BUNDLES);
    run(on, &ty_program_march_froxels, (int64_t)pixel_count(on), FIRST_RAYS);
}

/* ---- images ---- */

static void read_image(march_device* on, ty_image* image) {
    const size_t bytes = pixel_count(on) * sizeof(float);
    const ty_address planes = (ty_address)(uintptr_t)on->launch.planes;
    for (int32_t k = 0; k < on->launch.channel_count; ++k)
        ty_device_read(&on->arrays, ty_image_plane(image, k), planes + (size_t)k * bytes, bytes);
}

static void march(march_device* on, const ty_scene* scene, ty_image* image) {
    ty_device_arrays* arrays = &on->arrays;
    arrays->result = ty_scene_pack(arrays->device, scene, on->packed->request.scene, &on->scene);
    if (arrays->result != TY_OK) return;
    take_request(on);
    place_planes(on);
    on->request_address = ty_device_place(arrays, &on->request, sizeof on->request);
    on->arguments = ty_device_place(arrays, NULL, sizeof on->launch);
    on->launch.request = as_pointer(on->request_address);
    on->work = (double)pixel_count(on);
    if (ty_march_has_froxels(on->def))
        march_froxels(on);
    else if (on->def->ray_spacing > 1)
        march_spaced(on);
    else
        march_pixels(on, scene);
    read_image(on, image);
    if (arrays->result == TY_OK) arrays->result = report(on, true);
}

ty_result ty_march_on_device(const ty_scene* scene, const ty_march_def* def, const ty_packed_request* packed,
                             ty_image* image, ty_marched_on_device* out) {
    ty_device* device = NULL;
    const ty_result result = ty_context_device(packed->context, &device);
    if (result != TY_OK || device == NULL || packed->request.scene->medium_count > TY_MARCH_DEVICE_MEDIA) return result;
    march_device on = {.arrays = {.device = device},
                       .def = def,
                       .packed = packed,
                       .request = packed->request,
                       .launch = {.width = def->width, .height = def->height},
                       .out = out};
    on.begun = on.reported = ty_wall_seconds();
    out->kind = device->backend->name;
    pthread_mutex_lock(&device->busy);
    march(&on, scene, image);
    ty_device_free(&on.arrays);
    ty_packed_scene_destroy(on.scene);
    pthread_mutex_unlock(&device->busy);
    return on.arrays.result;
}
