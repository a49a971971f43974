/* Pixels through which edges of thick media pass. */
#include "image/march/edges.h"

#include "base/context.h"
#include "image/march/edges.k.h"

typedef struct edges_job {
    const ty_march_request* request;
    ty_edges_kernel kernel;
    int32_t width;
    int32_t* faces; /* with a border of one pixel */
    uint8_t* marked;
} edges_job;

static void find_faces(void* user, int64_t row, int32_t worker) {
    (void)worker;
    const edges_job* job = user;
    job->kernel(job->request, (int32_t)row - 1, job->width, job->faces + row * (job->width + 2));
}

static void mark_row(void* user, int64_t row, int32_t worker) {
    (void)worker;
    const edges_job* job = user;
    for (int32_t x = 0; x < job->width; ++x)
        job->marked[row * job->width + x] = ty_edges_are_at(job->faces, job->width, x, (int32_t)row);
}

/* Maximum of a medium's density. */
static float max_density(const ty_medium_view* medium) {
    const int32_t* bricks = medium->grid.bricks;
    const size_t count = (size_t)bricks[0] * (size_t)bricks[1] * (size_t)bricks[2];
    float max = 0;
    if (medium->has_grid == 0) return 1;
    for (size_t i = 0; i < count; ++i) max = ty_maxf(max, medium->extremes[2 * i + 1]);
    return max;
}

/* Distance of the camera from the farthest corner of the field's box, m. */
static float farthest(const ty_march_request* request) {
    const ty_cell_lattice* box = &request->field.lattice;
    const ty_vec lower = ty_sub(box->lower, request->camera.origin);
    const ty_vec upper =
        ty_vec_make(lower.x + (float)box->size[0] / box->per_cell.x, lower.y + (float)box->size[1] / box->per_cell.y,
                    lower.z + (float)box->size[2] / box->per_cell.z);
    const float x = ty_maxf(fabsf(lower.x), fabsf(upper.x)), y = ty_maxf(fabsf(lower.y), fabsf(upper.y));
    const float z = ty_maxf(fabsf(lower.z), fabsf(upper.z));
    return sqrtf(x * x + y * y + z * z);
}

bool ty_edges_may_exist(const ty_march_request* request, int32_t width, int32_t height, int32_t rays) {
    const ty_scene_view* scene = request->scene;
    if (rays <= request->spp || request->has_field == 0) return false;
    const float pixel = farthest(request) * ty_edges_pixel(&request->camera, 0.5f * (float)width, 0.5f * (float)height);
    for (int32_t m = 0; m < scene->medium_count; ++m) {
        const ty_medium_view* medium = &scene->media[m];
        if (pixel * medium->sigma_t_max * max_density(medium) > TY_EDGES_MIN_DEPTH) return true;
    }
    return false;
}

ty_result ty_edges_create(const ty_scene* scene, int32_t width, int32_t height, int32_t rays,
                          ty_march_request* request) {
    ty_context* context = ty_scene_context(scene);
    const size_t pixels = (size_t)width * (size_t)height, bordered = (size_t)(width + 2) * (size_t)(height + 2);
    if (!ty_edges_may_exist(request, width, height, rays)) return TY_OK;
    request->edges = (ty_edges_view){.rays = rays, .width = width, .pixels = pixels};
    request->edges.marked = ty_alloc_array(context, pixels, 1, false);
    int32_t* faces = ty_alloc_array(context, bordered, sizeof *faces, false);
    const bool whole = faces != NULL && request->edges.marked != NULL;
    if (whole) {
        edges_job job = {request, TY_BEST_KERNELS(ty_edges_kernel), width, faces, request->edges.marked};
        ty_parallel_for(context, height + 2, find_faces, &job);
        ty_parallel_for(context, height, mark_row, &job);
    }
    ty_free_array(context, faces, bordered, sizeof *faces);
    return whole ? TY_OK : TY_ERROR_MEMORY;
}

void ty_edges_destroy(ty_context* context, ty_edges_view* edges) {
    ty_free_array(context, edges->marked, edges->pixels, 1);
}
