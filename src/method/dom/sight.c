/* What an eye sees of cells behind surfaces is the part before them, where light is that of the cells before them: so
 * it is taken to be, lest the light of walls' other sides, or the dark within solids, shine through. */
#include "base/context.h"
#include "base/parallel.h"
#include "method/dom/view.h"
#include "scene/scene.h"

/* Layers of cells that are looked at from before a surface: the second by what keeps means of cells. */
enum { LAYERS = 2 };

/* What a cell's middle is seen as. */
enum { SEEN = 0, HIDDEN = 1, FIRST_LAYER = 2 };

/* Off cells' middles by this much, in cells, as where walls are looked for. */
static const double aside[3] = {1e-3, 0.7e-3, 0.4e-3};

typedef struct sight_job {
    const ty_dom* light;
    const ty_accel* mesh;
    const double* eye;
    const ty_cuts* cuts;      /* NULL: none */
    uint8_t *hidden, *marked; /* as they are, and with another layer */
    int32_t layer;
    float* plane;
    void (*visit)(const struct sight_job* job, const int32_t at[3], size_t cell); /* of each cell of a row */
} sight_job;

static size_t cell_at(const int32_t size[3], const int32_t at[3]) {
    return ((size_t)at[2] * (size_t)size[1] + (size_t)at[1]) * (size_t)size[0] + (size_t)at[0];
}

static ty_ray ray_to(const sight_job* job, const int32_t cell[3]) {
    const ty_grid_box* box = &job->light->box;
    ty_ray ray;
    double way[3], square = 0;
    for (int a = 0; a < 3; ++a) {
        const double side = (box->upper[a] - box->lower[a]) / box->size[a];
        way[a] = box->lower[a] + (cell[a] + 0.5 + aside[a]) * side - job->eye[a];
        square += way[a] * way[a];
    }
    const double length = fmax(sqrt(square), 1e-30);
    for (int a = 0; a < 3; ++a) {
        ray.origin[a] = (float)job->eye[a];
        ray.direction[a] = square > 0 ? (float)(way[a] / length) : a == 2;
    }
    ray.far = (float)length;
    return ray;
}

static void look_row(void* user, int64_t row, int32_t worker) {
    (void)worker;
    const sight_job* job = user;
    const int32_t* size = job->light->box.size;
    for (int32_t begin = 0; begin < size[0]; begin += TY_PACKET) {
        const int32_t count = size[0] - begin < TY_PACKET ? size[0] - begin : TY_PACKET;
        ty_ray rays[TY_PACKET];
        bool occluded[TY_PACKET];
        for (int32_t i = 0; i < count; ++i)
            rays[i] = ray_to(job, (const int32_t[3]){begin + i, (int32_t)(row % size[1]), (int32_t)(row / size[1])});
        ty_accel_occluded_packet(job->mesh, rays, count, occluded);
        for (int32_t i = 0; i < count; ++i) job->hidden[row * size[0] + begin + i] = occluded[i] ? HIDDEN : SEEN;
    }
}

/* ---- layers ---- */

/* Whether a cell has light of its own, or that of a layer before `layer`. */
static bool is_before(uint8_t hidden, int32_t layer) {
    return hidden == SEEN || (hidden >= FIRST_LAYER && hidden < layer);
}

/* The weights of cells about one that it is joined to and that are before a layer, the larger the nearer they are;
 * *mean: of a plane by them (NULL: of none). */
static float sum_about(const sight_job* job, const int32_t at[3], int32_t layer, const float* plane, float* mean) {
    const int32_t* size = job->light->box.size;
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

static void mark(const sight_job* job, const int32_t at[3], size_t cell) {
    const bool next = job->hidden[cell] == HIDDEN && sum_about(job, at, job->layer, NULL, NULL) > 0;
    job->marked[cell] = next ? (uint8_t)job->layer : job->hidden[cell];
}

static void fill(const sight_job* job, const int32_t at[3], size_t cell) {
    if (job->hidden[cell] == job->layer) sum_about(job, at, job->layer, job->plane, &job->plane[cell]);
}

static void visit_row(void* user, int64_t row, int32_t worker) {
    (void)worker;
    const sight_job* job = user;
    const int32_t* size = job->light->box.size;
    int32_t at[3] = {0, (int32_t)(row % size[1]), (int32_t)(row / size[1])};
    for (; at[0] < size[0]; ++at[0]) job->visit(job, at, cell_at(size, at));
}

/* ---- all ---- */

static int64_t rows_of(const ty_dom* light) {
    return (int64_t)light->box.size[1] * light->box.size[2];
}

ty_result ty_dom_look(const ty_dom* light, const ty_scene* scene, const double eye[3], uint8_t** hidden) {
    const ty_accel* mesh = ty_scene_get_view(scene)->mesh;
    *hidden = NULL;
    if (mesh == NULL || light->dark == NULL) return TY_OK;
    sight_job job = {.light = light, .mesh = mesh, .eye = eye, .visit = mark};
    job.hidden = *hidden = ty_alloc_array(light->context, light->cells, 1, false);
    job.marked = ty_alloc_array(light->context, light->cells, 1, false);
    if (job.hidden != NULL && job.marked != NULL) {
        ty_parallel_flushed(light->context, rows_of(light), look_row, &job);
        for (job.layer = FIRST_LAYER; job.layer < FIRST_LAYER + LAYERS; ++job.layer) {
            ty_parallel_flushed(light->context, rows_of(light), visit_row, &job);
            memcpy(job.hidden, job.marked, light->cells);
        }
    }
    const bool whole = job.hidden != NULL && job.marked != NULL;
    ty_free_array(light->context, job.marked, light->cells, 1);
    return whole ? TY_OK : TY_ERROR_MEMORY;
}

void ty_dom_cover_hidden(const ty_dom* light, const ty_cuts* cuts, const uint8_t* hidden, float* plane) {
    sight_job job = {.light = light, .cuts = cuts, .hidden = (uint8_t*)hidden, .plane = plane, .visit = fill};
    if (hidden == NULL) return;
    for (job.layer = FIRST_LAYER; job.layer < FIRST_LAYER + LAYERS; ++job.layer)
        ty_parallel_flushed(light->context, rows_of(light), visit_row, &job);
}
