/* Depths and memory of froxels. */
#include "image/march/froxels.h"

#include "base/context.h"

#include <math.h>
#include <string.h>

/* Bounds of r of ty_froxel_slice: below, slices are as good as even; above, which is where the camera is in or close to
 * the media, the slices next to it are thin enough. */
static const float growth_min = 1.1f, growth_max = 4;

typedef struct range_job {
    const ty_march_request* request;
    const ty_froxel_kernels* kernels;
    float (*ranges)[2]; /* of each row, m */
} range_job;

static void add_row(void* user, int64_t row, int32_t worker) {
    (void)worker;
    const range_job* job = user;
    float* range = job->ranges[row];
    range[0] = TY_FLOAT_MAX;
    range[1] = 0;
    job->kernels->add_range(job->request, (int32_t)row, range);
}

/* First and last depth of the media in view, m. */
static ty_result find_range(ty_context* context, const ty_march_request* request, float range[2]) {
    const size_t rows = (size_t)request->froxels.size[1];
    range_job job = {request, TY_BEST_KERNELS(ty_froxel_kernels), NULL};
    job.ranges = ty_alloc_array(context, rows, sizeof *job.ranges, false);
    if (job.ranges == NULL) return TY_ERROR_MEMORY;
    ty_parallel_for(context, (int64_t)rows, add_row, &job);
    range[0] = TY_FLOAT_MAX;
    range[1] = 0;
    for (size_t row = 0; row < rows; ++row) {
        range[0] = ty_minf(range[0], job.ranges[row][0]);
        range[1] = ty_maxf(range[1], job.ranges[row][1]);
    }
    ty_free_array(context, job.ranges, rows, sizeof *job.ranges);
    return TY_OK;
}

static size_t end_count(const ty_froxel_view* grid) {
    return (size_t)grid->size[2] + 1;
}

size_t ty_froxels_count(const ty_froxel_view* grid) {
    return (size_t)grid->size[0] * (size_t)grid->size[1] * end_count(grid);
}

/* z(s) of ty_froxel_slice with r = far / near, for which froxels are as deep as wide in proportion: z = near
 * (far / near)^(s / slices) (Wronski 2014). */
void ty_froxels_set_ends(ty_froxel_view* grid, const float range[2], float* ends) {
    const float depth = range[1] > range[0] ? range[1] - range[0] : 1;
    const int32_t slices = grid->size[2];
    grid->near = range[1] > range[0] ? range[0] : 0;
    grid->inverse_range = 1 / depth;
    grid->growth = growth_max;
    if (grid->near * growth_max > grid->near + depth) grid->growth = (grid->near + depth) / grid->near;
    grid->growth = ty_maxf(grid->growth, growth_min);
    for (int32_t k = 0; k <= slices; ++k) {
        const double power = pow((double)grid->growth, (double)k / slices);
        ends[k] = grid->near + depth * (float)((power - 1) / ((double)grid->growth - 1));
    }
}

ty_froxel_view ty_froxels_lay_out(const int32_t size[3], int32_t width, int32_t height) {
    ty_froxel_view grid = {.pixels = {(float)width / (float)size[0], (float)height / (float)size[1]}};
    memcpy(grid.size, size, sizeof grid.size);
    return grid;
}

ty_result ty_froxels_create(ty_context* context, ty_march_request* request, const int32_t size[3], int32_t width,
                            int32_t height) {
    ty_froxel_view* grid = &request->froxels;
    float range[2];
    *grid = ty_froxels_lay_out(size, width, height);
    const ty_result result = find_range(context, request, range);
    if (result != TY_OK) return result;
    float* ends = ty_alloc_array(context, end_count(grid), sizeof *ends, false);
    grid->ends = ends;
    grid->froxels = ty_alloc_array(context, ty_froxels_count(grid), sizeof *grid->froxels, false);
    if (ends == NULL || grid->froxels == NULL) return TY_ERROR_MEMORY;
    ty_froxels_set_ends(grid, range, ends);
    return TY_OK;
}

void ty_froxels_destroy(ty_context* context, ty_froxel_view* grid) {
    ty_free_array(context, (float*)(uintptr_t)grid->ends, end_count(grid), sizeof *grid->ends);
    ty_free_array(context, grid->froxels, ty_froxels_count(grid), sizeof *grid->froxels);
}
