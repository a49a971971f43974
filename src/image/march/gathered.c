/* Points of an image at which irradiance is gathered. */
#include "image/march/gathered.h"

#include "base/context.h"

#include <stdatomic.h>

typedef struct gathered_job {
    const ty_march_request* request;
    ty_gathered_kernel kernel;
    _Atomic uint64_t steps;
} gathered_job;

typedef struct smooth_job {
    const ty_gathered_view* view;
    ty_gathered_point* out;
} smooth_job;

static bool has_outer_surfaces(const ty_scene* scene, const ty_march_request* request) {
    const ty_cell_lattice* lattice = &request->surface_field.lattice;
    double lower[3], upper[3];
    if (request->scene->mesh == NULL || request->has_field == 0) return false;
    ty_scene_surface_extent(scene, lower, upper);
    const ty_vec first = ty_vec_make((float)lower[0], (float)lower[1], (float)lower[2]);
    const ty_vec last = ty_vec_make((float)upper[0], (float)upper[1], (float)upper[2]);
    return !ty_cell_inside(lattice, ty_cell_coordinates(lattice, first)) ||
           !ty_cell_inside(lattice, ty_cell_coordinates(lattice, last));
}

static void gather_row(void* user, int64_t row, int32_t worker) {
    (void)worker;
    gathered_job* job = user;
    atomic_fetch_add(&job->steps, job->kernel(job->request, (int32_t)row));
}

static void smooth_row(void* user, int64_t row, int32_t worker) {
    (void)worker;
    const smooth_job* job = user;
    for (int32_t i = 0; i < job->view->columns; ++i)
        ty_gathered_smooth(job->view, i, (int32_t)row, &job->out[row * job->view->columns + i]);
}

static int32_t count_along(int32_t pixels) {
    return (pixels + TY_GATHERED_SPACING - 2) / TY_GATHERED_SPACING + 1;
}

ty_gathered_view ty_gathered_lay_out(const ty_scene* scene, const ty_march_request* request, int32_t width,
                                     int32_t height) {
    if (width < 2 || height < 2 || !has_outer_surfaces(scene, request)) return (ty_gathered_view){.columns = 0};
    return (ty_gathered_view){
        .columns = count_along(width), .rows = count_along(height), .width = width, .height = height};
}

ty_result ty_gathered_create(const ty_scene* scene, ty_march_request* request, int32_t width, int32_t height,
                             uint64_t* steps) {
    ty_context* context = ty_scene_context(scene);
    *steps = 0;
    ty_gathered_view view = ty_gathered_lay_out(scene, request, width, height);
    if (view.columns == 0) return TY_OK;
    view.points = ty_alloc_array(context, (size_t)view.columns * (size_t)view.rows, sizeof *view.points, false);
    if (view.points == NULL) return TY_ERROR_MEMORY;
    request->gathered = view;
    gathered_job job = {.request = request, .kernel = TY_BEST_KERNELS(ty_gathered_kernel)};
    ty_parallel_for(context, view.rows, gather_row, &job);
    *steps = atomic_load(&job.steps);
    smooth_job smoothed = {&request->gathered, NULL};
    smoothed.out = ty_alloc_array(context, (size_t)view.columns * (size_t)view.rows, sizeof *view.points, false);
    if (smoothed.out == NULL) return TY_ERROR_MEMORY;
    ty_parallel_for(context, view.rows, smooth_row, &smoothed);
    ty_gathered_destroy(context, &request->gathered);
    request->gathered.points = smoothed.out;
    return TY_OK;
}

void ty_gathered_destroy(ty_context* context, ty_gathered_view* gathered) {
    ty_free_array(context, gathered->points, (size_t)gathered->columns * (size_t)gathered->rows,
                  sizeof *gathered->points);
}
