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

/* Mean over a point and those around it, by tent weights: each has other rays, and their errors differ. */
static void smooth_row(void* user, int64_t row, int32_t worker) {
    (void)worker;
    const smooth_job* job = user;
    const ty_gathered_view* view = job->view;
    for (int32_t i = 0; i < view->columns; ++i) {
        const ty_gathered_point* center = &view->points[row * view->columns + i];
        ty_gathered_point* out = &job->out[row * view->columns + i];
        float sum = 0;
        *out = *center;
        if (center->exists == 0) continue;
        for (int c = 0; c < 3; ++c) out->irradiance[c] = 0;
        for (int32_t k = 0; k < 9; ++k) {
            const int32_t right = k % 3 - 1, down = k / 3 - 1;
            if (i + right < 0 || i + right >= view->columns || row + down < 0 || row + down >= view->rows) continue;
            const ty_gathered_point* point = &view->points[(row + down) * view->columns + i + right];
            const float weight = (right == 0 ? 2.0f : 1.0f) * (down == 0 ? 2.0f : 1.0f) *
                                 ty_gathered_weight(point, center->position, center->normal, center->distance);
            if (!(weight > 0)) continue;
            sum += weight;
            for (int c = 0; c < 3; ++c) out->irradiance[c] += weight * point->irradiance[c];
        }
        for (int c = 0; c < 3; ++c) out->irradiance[c] *= 1 / sum;
    }
}

static int32_t count_along(int32_t pixels) {
    return (pixels + TY_GATHERED_SPACING - 2) / TY_GATHERED_SPACING + 1;
}

ty_result ty_gathered_create(const ty_scene* scene, ty_march_request* request, int32_t width, int32_t height,
                             uint64_t* steps) {
    ty_context* context = ty_scene_context(scene);
    *steps = 0;
    if (width < 2 || height < 2 || !has_outer_surfaces(scene, request)) return TY_OK;
    ty_gathered_view view = {
        .columns = count_along(width), .rows = count_along(height), .width = width, .height = height};
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
