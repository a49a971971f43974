/* Light of cells behind surfaces. They take the light of the cell in front, so that neither the far side of a wall nor
 * the inside of a solid bleeds through. */
#include "image/march/hidden_cells.h"

#include "base/context.h"
#include "base/parallel.h"
#include "scene/scene.h"

/* Number of layers of cells behind a surface that interpolation reads: the second one by mean-preserving upsampling. */
enum { LAYERS = 2 };

/* State of a cell; layers behind surfaces count from FIRST_LAYER. */
enum { VISIBLE = 0, HIDDEN = 1, FIRST_LAYER = 2 };

/* Offset from cell centers, in cells, as in the search for boundary faces. */
static const double offset[3] = {1e-3, 0.7e-3, 0.4e-3};

typedef struct hidden_job {
    ty_context* context;
    const ty_grid_box* box;
    const ty_accel* mesh;
    const double* eye;
    const ty_cuts* cuts;      /* NULL: none */
    uint8_t *hidden, *marked; /* state of the cells, and the state with another layer */
    int32_t layer;
    float* plane;
    void (*visit)(const struct hidden_job* job, const int32_t at[3], size_t cell); /* called for each cell of a row */
} hidden_job;

static size_t cell_at(const int32_t size[3], const int32_t at[3]) {
    return ((size_t)at[2] * (size_t)size[1] + (size_t)at[1]) * (size_t)size[0] + (size_t)at[0];
}

static ty_ray ray_to(const hidden_job* job, const int32_t cell[3]) {
    const ty_grid_box* box = job->box;
    ty_ray ray;
    double omega[3], square = 0;
    for (int a = 0; a < 3; ++a) {
        const double side = (box->upper[a] - box->lower[a]) / box->size[a];
        omega[a] = box->lower[a] + (cell[a] + 0.5 + offset[a]) * side - job->eye[a];
        square += omega[a] * omega[a];
    }
    const double length = fmax(sqrt(square), 1e-30);
    for (int a = 0; a < 3; ++a) {
        ray.origin[a] = (float)job->eye[a];
        ray.direction[a] = square > 0 ? (float)(omega[a] / length) : a == 2;
    }
    ray.far = (float)length;
    return ray;
}

static void find_row(void* user, int64_t row, int32_t worker) {
    (void)worker;
    const hidden_job* job = user;
    const int32_t* size = job->box->size;
    for (int32_t begin = 0; begin < size[0]; begin += TY_PACKET) {
        const int32_t count = size[0] - begin < TY_PACKET ? size[0] - begin : TY_PACKET;
        ty_ray rays[TY_PACKET];
        bool occluded[TY_PACKET];
        for (int32_t i = 0; i < count; ++i)
            rays[i] = ray_to(job, (const int32_t[3]){begin + i, (int32_t)(row % size[1]), (int32_t)(row / size[1])});
        ty_accel_occluded_packet(job->mesh, rays, count, occluded);
        for (int32_t i = 0; i < count; ++i) job->hidden[row * size[0] + begin + i] = occluded[i] ? HIDDEN : VISIBLE;
    }
}

/* ---- layers ---- */

/* True if a cell has light of its own, or of a layer before `layer`. */
static bool is_before(uint8_t hidden, int32_t layer) {
    return hidden == VISIBLE || (hidden >= FIRST_LAYER && hidden < layer);
}

/* Sum of inverse square distances of neighbours before `layer` that no surface separates; *mean: their weighted mean of
 * a plane (NULL: none). */
static float sum_about(const hidden_job* job, const int32_t at[3], int32_t layer, const float* plane, float* mean) {
    const int32_t* size = job->box->size;
    float sum = 0, total = 0;
    for (int32_t i = 0; i < 27; ++i) {
        const int32_t off[3] = {i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1};
        const int32_t next[3] = {at[0] + off[0], at[1] + off[1], at[2] + off[2]};
        const int32_t square = off[0] * off[0] + off[1] * off[1] + off[2] * off[2];
        bool inside = square > 0;
        for (int a = 0; a < 3; ++a) inside = inside && next[a] >= 0 && next[a] < size[a];
        if (!inside || !is_before(job->hidden[cell_at(size, next)], layer)) continue;
        if (job->cuts != NULL && !ty_cuts_join(job->cuts, at, next)) continue;
        if (plane != NULL) sum += plane[cell_at(size, next)] / (float)square;
        total += 1 / (float)square;
    }
    if (plane != NULL && total > 0) *mean = sum / total;
    return total;
}

static void mark(const hidden_job* job, const int32_t at[3], size_t cell) {
    const bool next = job->hidden[cell] == HIDDEN && sum_about(job, at, job->layer, NULL, NULL) > 0;
    job->marked[cell] = next ? (uint8_t)job->layer : job->hidden[cell];
}

static void fill(const hidden_job* job, const int32_t at[3], size_t cell) {
    if (job->hidden[cell] == job->layer) sum_about(job, at, job->layer, job->plane, &job->plane[cell]);
}

static void visit_row(void* user, int64_t row, int32_t worker) {
    (void)worker;
    const hidden_job* job = user;
    const int32_t* size = job->box->size;
    int32_t at[3] = {0, (int32_t)(row % size[1]), (int32_t)(row / size[1])};
    for (; at[0] < size[0]; ++at[0]) job->visit(job, at, cell_at(size, at));
}

/* ---- all ---- */

static int64_t rows_of(const hidden_job* job) {
    return (int64_t)job->box->size[1] * job->box->size[2];
}

static size_t cell_count(const ty_grid_box* box) {
    return (size_t)box->size[0] * (size_t)box->size[1] * (size_t)box->size[2];
}

ty_result ty_hidden_cells_find(ty_context* context, const ty_scene* scene, const ty_grid_box* box, const double eye[3],
                               uint8_t** hidden) {
    const ty_accel* mesh = ty_scene_get_view(scene)->mesh;
    const size_t cells = cell_count(box);
    *hidden = NULL;
    if (mesh == NULL) return TY_OK;
    hidden_job job = {.context = context, .box = box, .mesh = mesh, .eye = eye, .visit = mark};
    job.hidden = *hidden = ty_alloc_array(context, cells, 1, false);
    job.marked = ty_alloc_array(context, cells, 1, false);
    if (job.hidden != NULL && job.marked != NULL) {
        ty_parallel_flushed(context, rows_of(&job), find_row, &job);
        for (job.layer = FIRST_LAYER; job.layer < FIRST_LAYER + LAYERS; ++job.layer) {
            ty_parallel_flushed(context, rows_of(&job), visit_row, &job);
            memcpy(job.hidden, job.marked, cells);
        }
    }
    const bool whole = job.hidden != NULL && job.marked != NULL;
    ty_free_array(context, job.marked, cells, 1);
    return whole ? TY_OK : TY_ERROR_MEMORY;
}

void ty_hidden_cells_fill(ty_context* context, const ty_grid_box* box, const ty_cuts* cuts, const uint8_t* hidden,
                          float* plane) {
    hidden_job job = {
        .context = context, .box = box, .cuts = cuts, .hidden = (uint8_t*)hidden, .plane = plane, .visit = fill};
    if (hidden == NULL) return;
    for (job.layer = FIRST_LAYER; job.layer < FIRST_LAYER + LAYERS; ++job.layer)
        ty_parallel_flushed(context, rows_of(&job), visit_row, &job);
}
