/* Surfels of all layers of surfaces, along three axes. */
#include "base/context.h"
#include "base/parallel.h"
#include "method/lpv/inject/inject.h"
#include "scene/surfaces/fetch.h"
#include "scene/scene.h"

#include <stdatomic.h>

/* A task is a strip of BLOCK rows of rays; a packet is a block of BLOCK x BLOCK. */
enum { BLOCK = 4 };

/* Hits that are shaded per batch. */
enum { BATCH = 64 };

/* Position of a ray in its part of a cell, the same for all rays, so that every cube as large as a cell contains `side`
 * x `side` rays. The two numbers differ and are no simple fractions, so that rays do not run along the edges of models
 * built on a grid. */
static const double offset[2] = {0.382, 0.271};

typedef struct surfel_list {
    ty_surfel* items;
    size_t count, capacity;
} surfel_list;

/* The location of a strip's surfels. */
typedef struct surfel_strip {
    int32_t list;
    size_t first, count, place;
} surfel_strip;

typedef struct surfel_job {
    const ty_scene* scene;
    const ty_grid_box* box;
    int32_t side;
    double cell[3];
    int64_t begin[4];    /* the first strip of each axis */
    surfel_list* lists;  /* per worker */
    ty_all_hits* layers; /* per worker; too large for a stack */
    surfel_strip* strips;
    ty_surfel* out;
    ty_ray_counter* counter;
    _Atomic bool failed;
} surfel_job;

/* ---- rays ---- */

/* The rays parallel to an axis. */
typedef struct ray_field {
    int32_t axis, across[2];
    int32_t count[2];
    double spacing[2];
    double begin, end; /* along the axis, m */
    float area;        /* cross section per ray, m^2 */
} ray_field;

static ray_field field_along(const surfel_job* job, int32_t axis) {
    ray_field field = {.axis = axis, .across = {(axis + 1) % 3, (axis + 2) % 3}};
    for (int i = 0; i < 2; ++i) {
        const int a = field.across[i];
        field.count[i] = (job->box->size[a] + 1) * job->side;
        field.spacing[i] = job->cell[a] / job->side;
    }
    field.begin = job->box->lower[axis] - 0.5 * job->cell[axis];
    field.end = job->box->upper[axis] + 0.5 * job->cell[axis];
    field.area = (float)(field.spacing[0] * field.spacing[1]);
    return field;
}

static ty_ray ray_at(const surfel_job* job, const ray_field* field, int32_t i, int32_t j) {
    const int32_t at[2] = {i, j};
    ty_ray ray = {.far = (float)(field->end - field->begin)};
    for (int k = 0; k < 2; ++k) {
        const int a = field->across[k];
        const double begin = job->box->lower[a] - 0.5 * job->cell[a];
        ray.origin[a] = (float)(begin + (at[k] + offset[k]) * field->spacing[k]);
    }
    ray.origin[field->axis] = (float)field->begin;
    ray.direction[field->axis] = 1.0f;
    return ray;
}

static void add_surfel(surfel_job* job, const ray_field* field, const ty_ray* ray, const ty_hit* hit, int32_t worker) {
    const float normal[3] = {hit->normal.x, hit->normal.y, hit->normal.z};
    const float facing = fabsf(normal[field->axis]);
    surfel_list* list = &job->lists[worker];
    if (!(facing > 1e-3f)) return;
    if (!ty_grow_array(job->scene->context, (void**)&list->items, &list->capacity, list->count, sizeof *list->items)) {
        atomic_store(&job->failed, true);
        return;
    }
    ty_surface_point point;
    ty_surface_evaluate_fetched(&job->scene->view.surfaces[hit->surface], hit, ty_vec_load(ray->direction), &point);
    /* A hit represents the surface area `area / facing`. Weighted by facing^2, the three axes together count it once.
     */
    ty_surfel* surfel = &list->items[list->count++];
    *surfel = (ty_surfel){.position = hit->position, .normal = hit->normal, .area = field->area * facing};
    memcpy(surfel->albedo, point.albedo, sizeof surfel->albedo);
}

/* Minimum cosine between ray and surface in the distance test between layers. */
static const float least_along = 0.1f;

/* True if a layer lies behind the last counted one, and is not the same surface hit twice, at a shared edge or a
 * coincident triangle. */
static bool is_behind(const ty_ray* ray, const ty_hit* last, float distance) {
    const float along = ty_maxf(fabsf(ty_dot(last->normal, ty_vec_load(ray->direction))), least_along);
    return (distance - last->distance) * along > last->margin;
}

/* A batch of hits that become surfels. */
typedef struct hit_batch {
    ty_hit hits[BATCH];
    int32_t count;
} hit_batch;

/* Adds a batch of hits; ray: any ray of the field. */
static void add_batch(surfel_job* job, const ray_field* field, const ty_ray* ray, hit_batch* batch, int32_t worker) {
    ty_surfaces_fetch(job->scene->view.surfaces, batch->hits, batch->count);
    for (int32_t i = 0; i < batch->count; ++i) add_surfel(job, field, ray, &batch->hits[i], worker);
    batch->count = 0;
}

static void add_layers(surfel_job* job, const ray_field* field, const ty_ray* ray, const ty_hit_record* layers,
                       int32_t count, hit_batch* batch, int32_t worker) {
    ty_hit last = {.distance = -INFINITY, .normal = ty_vec_load(ray->direction)};
    for (int32_t i = 0; i < count; ++i) {
        if (!is_behind(ray, &last, layers[i].distance)) continue;
        if (batch->count == BATCH) add_batch(job, field, ray, batch, worker);
        ty_accel_complete_hit(job->scene->view.mesh, ray, &layers[i], &last);
        batch->hits[batch->count++] = last;
    }
}

/* Traces the rays of a block; returns their number. */
static int64_t trace_block(surfel_job* job, const ray_field* field, int32_t left, int32_t top, int32_t worker,
                           double* seconds) {
    ty_ray rays[TY_PACKET];
    ty_all_hits* layers = &job->layers[worker];
    int32_t count = 0;
    for (int32_t j = top; j < top + BLOCK && j < field->count[1]; ++j)
        for (int32_t i = left; i < left + BLOCK && i < field->count[0]; ++i) rays[count++] = ray_at(job, field, i, j);
    const double begun = ty_wall_seconds();
    ty_accel_all_hits_packet(job->scene->view.mesh, rays, count, layers);
    *seconds += ty_wall_seconds() - begun;
    hit_batch batch;
    batch.count = 0;
    for (int32_t i = 0; i < count; ++i)
        add_layers(job, field, &rays[i], layers->layer[i], layers->count[i], &batch, worker);
    add_batch(job, field, &rays[0], &batch, worker);
    return count;
}

static void trace_strip(void* user, int64_t index, int32_t worker) {
    surfel_job* job = user;
    const int32_t axis = index >= job->begin[2] ? 2 : index >= job->begin[1] ? 1 : 0;
    const ray_field field = field_along(job, axis);
    surfel_strip* strip = &job->strips[index];
    int64_t traced = 0;
    double seconds = 0;
    *strip = (surfel_strip){.list = worker, .first = job->lists[worker].count};
    for (int32_t left = 0; left < field.count[0]; left += BLOCK)
        traced += trace_block(job, &field, left, BLOCK * (int32_t)(index - job->begin[axis]), worker, &seconds);
    strip->count = job->lists[worker].count - strip->first;
    ty_ray_counter_add(job->counter, traced, seconds);
}

/* ---- all strips ---- */

static void copy_strip(void* user, int64_t index, int32_t worker) {
    (void)worker;
    const surfel_job* job = user;
    const surfel_strip* strip = &job->strips[index];
    if (strip->count > 0)
        memcpy(job->out + strip->place, job->lists[strip->list].items + strip->first, strip->count * sizeof *job->out);
}

/* Concatenates the surfels of all strips in order. */
static ty_result gather(surfel_job* job, ty_surfel** out, size_t* count) {
    ty_context* context = job->scene->context;
    size_t total = 0;
    for (int64_t i = 0; i < job->begin[3]; ++i) {
        job->strips[i].place = total;
        total += job->strips[i].count;
    }
    job->out = ty_alloc_array(context, total, sizeof *job->out, false);
    if (job->out == NULL) return TY_ERROR_MEMORY;
    ty_parallel_for(context, job->begin[3], copy_strip, job);
    *out = job->out;
    *count = total;
    return TY_OK;
}

ty_result ty_surfels_trace(const ty_scene* scene, const ty_grid_box* box, int32_t side, ty_surfel** out, size_t* count,
                           size_t* capacity, ty_ray_counter* counter) {
    ty_context* context = scene->context;
    const int32_t workers = ty_context_threads(context);
    surfel_job job = {.scene = scene, .box = box, .side = side, .counter = counter};
    for (int a = 0; a < 3; ++a) job.cell[a] = (box->upper[a] - box->lower[a]) / box->size[a];
    for (int a = 0; a < 3; ++a) job.begin[a + 1] = job.begin[a] + (field_along(&job, a).count[1] + BLOCK - 1) / BLOCK;
    *out = NULL;
    *count = 0;
    job.lists = ty_alloc_array(context, (size_t)workers, sizeof *job.lists, true);
    job.layers = ty_alloc_array(context, (size_t)workers, sizeof *job.layers, false);
    job.strips = ty_alloc_array(context, (size_t)job.begin[3], sizeof *job.strips, true);
    const bool ready = job.lists != NULL && job.layers != NULL && job.strips != NULL;
    if (ready && scene->view.mesh != NULL) ty_parallel_flushed(context, job.begin[3], trace_strip, &job);
    const bool failed = !ready || atomic_load(&job.failed);
    const ty_result result = failed ? TY_ERROR_MEMORY : gather(&job, out, count);
    for (int32_t i = 0; i < workers && job.lists != NULL; ++i)
        ty_free_array(context, job.lists[i].items, job.lists[i].capacity, sizeof *job.lists[i].items);
    ty_free_array(context, job.strips, (size_t)job.begin[3], sizeof *job.strips);
    ty_free_array(context, job.layers, (size_t)workers, sizeof *job.layers);
    ty_free_array(context, job.lists, (size_t)workers, sizeof *job.lists);
    *capacity = *count;
    return result;
}
