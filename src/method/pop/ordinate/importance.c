/* Importance of each direction of incident light for the camera: Sec. 5.2 (Elek 2014). */
#include "scene/lights/environment_map.k.h"

#include "base/constants.h"
#include "base/context.h"
#include "base/parallel.h"
#include "image/options.h"
#include "method/pop/ordinate/importance.k.h"
#include "method/pop/ordinate/ordinate.h"
#include "scene/camera.h"
#include "scene/scene.h"

/* Grid in the camera's frustum: columns across, layers in depth, ray-march steps per layer. */
enum { COLUMNS = 16, LAYERS = 16, STEPS = 2 };

/* Layers merged into one lobe; blocks of lobes that share transmittances out of the medium. */
enum { GROUP = 4, GROUPS = LAYERS / GROUP, ACROSS = 4, BLOCKS = COLUMNS / ACROSS * (COLUMNS / ACROSS) * GROUPS };

enum {
    WIDTH = TY_POP_IMPORTANCE_WIDTH,
    HEIGHT = TY_POP_IMPORTANCE_HEIGHT,
    DIRECTIONS = WIDTH * HEIGHT,
    OUT_WIDTH = WIDTH / 2, /* resolution of the map of transmittances */
    OUT_HEIGHT = HEIGHT / 2,
    OUT_STEPS = 8
};

/* Smoothing kernel of the map: it falls to 1/e at one texel (11.25 degrees). */
static const float SMOOTHNESS = 52.0f;

/* Weight of the new map against the history. */
static const float NEW_WEIGHT = 0.5f;

typedef struct frustum {
    ty_camera_view camera;
    float from[2], to[2]; /* image rectangle that covers the box, pixels */
    float near, far;      /* depth range */
} view_frustum;

typedef struct importance_job {
    const ty_scene* scene;
    ty_pop_occlusion_view medium;
    view_frustum frustum;
    float direction_of[3][DIRECTIONS]; /* unit */
    ty_vec ray[COLUMNS * COLUMNS];
    ty_pop_visibility_sample samples[COLUMNS * COLUMNS][GROUPS];
    float diffuse[BLOCKS];                 /* sum over the block's samples */
    float out[BLOCKS][DIRECTIONS];         /* transmittance out of the medium of directional light */
    float diffuse_out[BLOCKS][DIRECTIONS]; /* the same for diffuse light */
    float importance[DIRECTIONS];
    float smoothed[DIRECTIONS];
} importance_job;

static float row_solid_angle(int32_t row) {
    return (float)(2 * TY_PI_F64 / WIDTH * (cos(TY_PI_F64 * row / HEIGHT) - cos(TY_PI_F64 * (row + 1) / HEIGHT)));
}

/* Direction of a texel's center, as in an environment without rotation. */
static ty_vec texel_direction(ty_axis up, int32_t column, int32_t row, int32_t width, int32_t height) {
    const double angle = 2 * TY_PI_F64 * (0.5 - (column + 0.5) / width), down = TY_PI_F64 * (row + 0.5) / height;
    const float across = (float)(sin(down) * cos(angle)), along = (float)(sin(down) * sin(angle));
    return up == TY_AXIS_Z ? ty_vec_make(across, along, (float)cos(down))
                           : ty_vec_make(across, (float)cos(down), -along);
}

/* ---- frustum ---- */

static void widen(view_frustum* frustum, float x, float y) {
    frustum->from[0] = ty_minf(frustum->from[0], x);
    frustum->from[1] = ty_minf(frustum->from[1], y);
    frustum->to[0] = ty_maxf(frustum->to[0], x);
    frustum->to[1] = ty_maxf(frustum->to[1], y);
}

/* Fits the grid to the visible part of the box; false if there is none. */
static bool fit_frustum(const ty_grid_box* box, int32_t width, int32_t height, view_frustum* frustum) {
    const ty_camera_view* camera = &frustum->camera;
    const ty_vec forward =
        ty_mad(ty_mad(camera->corner, camera->dx, 0.5f * (float)width), camera->dy, 0.5f * (float)height);
    const float per_x = 1.0f / ty_dot(camera->dx, camera->dx), per_y = 1.0f / ty_dot(camera->dy, camera->dy);
    bool behind = false;
    frustum->near = frustum->from[0] = frustum->from[1] = TY_FLOAT_MAX;
    frustum->far = frustum->to[0] = frustum->to[1] = -TY_FLOAT_MAX;
    for (int32_t i = 0; i < 8; ++i) {
        const ty_vec corner = ty_vec_make((float)((i & 1) != 0 ? box->upper[0] : box->lower[0]),
                                          (float)((i & 2) != 0 ? box->upper[1] : box->lower[1]),
                                          (float)((i & 4) != 0 ? box->upper[2] : box->lower[2]));
        const ty_vec off = ty_sub(corner, camera->origin);
        const float depth = ty_dot(off, forward);
        frustum->near = ty_minf(frustum->near, depth);
        frustum->far = ty_maxf(frustum->far, depth);
        behind |= !(depth > 0.0f);
        if (depth > 0.0f)
            widen(frustum, 0.5f * (float)width + ty_dot(off, camera->dx) * per_x / depth,
                  0.5f * (float)height + ty_dot(off, camera->dy) * per_y / depth);
    }
    if (behind) {
        widen(frustum, 0.0f, 0.0f);
        widen(frustum, (float)width, (float)height);
    }
    frustum->near = ty_maxf(0.0f, frustum->near);
    const float image_size[2] = {(float)width, (float)height};
    for (int a = 0; a < 2; ++a) {
        frustum->from[a] = ty_clampf(frustum->from[a], 0.0f, image_size[a]);
        frustum->to[a] = ty_clampf(frustum->to[a], 0.0f, image_size[a]);
    }
    return frustum->far > frustum->near && frustum->to[0] > frustum->from[0] && frustum->to[1] > frustum->from[1];
}

/* ---- ray march from the eye ---- */

/* One column. The ray's vector has unit depth. */
static void march_column(importance_job* job, int32_t column, int32_t row) {
    const view_frustum* frustum = &job->frustum;
    const float x = ty_lerpf(frustum->from[0], frustum->to[0], ((float)column + 0.5f) / COLUMNS);
    const float y = ty_lerpf(frustum->from[1], frustum->to[1], ((float)row + 0.5f) / COLUMNS);
    const ty_vec along = ty_mad(ty_mad(frustum->camera.corner, frustum->camera.dx, x), frustum->camera.dy, y);
    const float per_depth = sqrtf(ty_dot(along, along)), step = (frustum->far - frustum->near) / (LAYERS * STEPS);
    const ty_accel* mesh = job->scene->view.mesh;
    const int32_t at = COLUMNS * row + column;
    ty_pop_importance_transmittance transmittance = {.uncollided = 1, .first = 1, .second = 1};
    float end = frustum->far;
    ty_hit hit;
    job->ray[at] = ty_scale(along, 1.0f / per_depth);
    if (mesh != NULL && ty_accel_intersect(mesh, frustum->camera.origin, job->ray[at], per_depth * end, &hit))
        end = hit.distance / per_depth;
    for (int32_t k = 0; k < LAYERS * STEPS; ++k) {
        const float depth = frustum->near + step * (float)k, length = ty_minf(step, end - depth);
        if (!(length > 0.0f)) return;
        const ty_vec point = ty_mad(frustum->camera.origin, along, depth + 0.5f * length);
        const ty_pop_occlusion_medium medium = ty_pop_occlusion_medium_at(&job->medium, point);
        ty_pop_visibility_sample_add(&job->samples[at][k / (STEPS * GROUP)], &transmittance, &medium, point,
                                     length * per_depth);
    }
}

static void march_row(void* user, int64_t row, int32_t worker) {
    (void)worker;
    for (int32_t column = 0; column < COLUMNS; ++column) march_column(user, column, (int32_t)row);
}

/* ---- transmittance out of the medium ---- */

static int32_t block_of(int32_t column, int32_t row, int32_t group) {
    const int32_t blocks = COLUMNS / ACROSS;
    return group + GROUPS * (column / ACROSS + blocks * (row / ACROSS));
}

/* Importance-weighted mean position of a block, and its sum of diffuse light; false if its importance is 0. */
static bool block_position(importance_job* job, int32_t block, ty_vec* position) {
    const int32_t blocks = COLUMNS / ACROSS, group = block % GROUPS;
    const int32_t left = ACROSS * (block / GROUPS % blocks), top = ACROSS * (block / GROUPS / blocks);
    float weight = 0.0f;
    *position = ty_vec_make(0.0f, 0.0f, 0.0f);
    for (int32_t row = top; row < top + ACROSS; ++row)
        for (int32_t column = left; column < left + ACROSS; ++column) {
            const ty_pop_visibility_sample* sample = &job->samples[COLUMNS * row + column][group];
            weight += sample->uncollided + sample->forward;
            *position = ty_add(*position, sample->weighted_position);
            job->diffuse[block] += sample->diffuse;
        }
    if (!(weight > 0.0f)) return false;
    *position = ty_scale(*position, 1.0f / weight);
    return true;
}

/* Distance from an inside point to the box's side. */
static float distance_to_side(const ty_pop_occlusion_view* medium, ty_vec point, ty_vec direction) {
    const float from[3] = {point.x, point.y, point.z}, along[3] = {direction.x, direction.y, direction.z};
    const float lower[3] = {medium->lower.x, medium->lower.y, medium->lower.z};
    const float upper[3] = {medium->upper.x, medium->upper.y, medium->upper.z};
    float nearest = TY_FLOAT_MAX;
    for (int a = 0; a < 3; ++a) {
        const float side = along[a] > 0.0f ? upper[a] : lower[a];
        if (fabsf(along[a]) > 1e-6f) nearest = ty_minf(nearest, (side - from[a]) / along[a]);
    }
    return ty_maxf(0.0f, nearest);
}

/* Optical depth to the box's side with first-order scaled extinction, as for ordinates' light; infinite behind
 * surfaces. */
static float optical_depth_out(const importance_job* job, ty_vec point, ty_vec direction) {
    const float length = distance_to_side(&job->medium, point, direction) / OUT_STEPS;
    float tau = 0.0f;
    if (job->scene->view.mesh != NULL && ty_accel_occluded(job->scene->view.mesh, point, direction, TY_FLOAT_MAX))
        return TY_FLOAT_MAX;
    for (int32_t i = 0; i < OUT_STEPS; ++i) {
        const ty_pop_occlusion_medium medium =
            ty_pop_occlusion_medium_at(&job->medium, ty_mad(point, direction, ((float)i + 0.5f) * length));
        tau += length * ty_pop_occlusion_scaled_extinction(&medium, 1);
    }
    return tau;
}

static void upsample_map(const float* coarse, float* out) {
    for (int32_t i = 0; i < DIRECTIONS; ++i)
        out[i] = ty_environment_map_at(coarse, OUT_WIDTH, OUT_HEIGHT, ((float)(i % WIDTH) + 0.5f) / WIDTH,
                                       ((float)(i / WIDTH) + 0.5f) / HEIGHT);
}

/* Diffuse light crosses a layer with the transmittance of two-stream diffusion, 1 / (1 + 3/4 tau). */
static void find_out_transmittances(void* user, int64_t index, int32_t worker) {
    (void)worker;
    importance_job* job = user;
    float directional[OUT_WIDTH * OUT_HEIGHT], diffuse[OUT_WIDTH * OUT_HEIGHT];
    ty_vec position;
    if (!block_position(job, (int32_t)index, &position)) return;
    for (int32_t i = 0; i < OUT_WIDTH * OUT_HEIGHT; ++i) {
        const ty_vec direction = texel_direction(job->scene->up, i % OUT_WIDTH, i / OUT_WIDTH, OUT_WIDTH, OUT_HEIGHT);
        const float tau = optical_depth_out(job, position, direction);
        directional[i] = ty_attenuation(tau);
        diffuse[i] = 1.0f / (1.0f + 0.75f * tau);
    }
    upsample_map(directional, job->out[index]);
    upsample_map(diffuse, job->diffuse_out[index]);
}

/* Adds one lobe's importance to each direction in a row of the map. */
static void add_sample(importance_job* job, const ty_pop_visibility_sample* sample, ty_vec ray, const float* out,
                       int32_t row) {
    if (!(sample->uncollided + sample->forward > 0.0f)) return;
    const ty_pop_importance_lobe lobe = ty_pop_importance_lobe_of(sample);
    const int32_t first = WIDTH * row;
    const float *x = job->direction_of[0] + first, *y = job->direction_of[1] + first, *z = job->direction_of[2] + first;
    float* importance = job->importance + first;
#pragma omp simd
    for (int32_t i = 0; i < WIDTH; ++i) {
        const float mu = x[i] * ray.x + y[i] * ray.y + z[i] * ray.z;
        importance[i] += ty_pop_importance_lobe_at(&lobe, mu) * out[first + i];
    }
}

static void sum_row(void* user, int64_t index, int32_t worker) {
    (void)worker;
    importance_job* job = user;
    for (int32_t row = 0; row < COLUMNS; ++row)
        for (int32_t column = 0; column < COLUMNS; ++column)
            for (int32_t group = 0; group < GROUPS; ++group) {
                const int32_t at = COLUMNS * row + column;
                add_sample(job, &job->samples[at][group], job->ray[at], job->out[block_of(column, row, group)],
                           (int32_t)index);
            }
    for (int32_t block = 0; block < BLOCKS; ++block)
        for (int32_t i = WIDTH * (int32_t)index; i < WIDTH * ((int32_t)index + 1); ++i)
            job->importance[i] += TY_INV_4PI * job->diffuse[block] * job->diffuse_out[block][i];
}

/* ---- map ---- */

/* Spherical convolution for one row of the map; the kernel is isotropic at the poles too. */
static void smooth_map_row(void* user, int64_t index, int32_t worker) {
    (void)worker;
    importance_job* job = user;
    float sum[WIDTH] = {0}, weight = 0.0f;
    const int32_t row = (int32_t)index;
    for (int32_t other = 0; other < HEIGHT; ++other) {
        const float solid_angle = row_solid_angle(other);
        for (int32_t shift = 0; shift < WIDTH; ++shift) {
            const int32_t a = WIDTH * row, b = WIDTH * other + shift;
            const float mu = job->direction_of[0][a] * job->direction_of[0][b] +
                             job->direction_of[1][a] * job->direction_of[1][b] +
                             job->direction_of[2][a] * job->direction_of[2][b];
            const float kernel = solid_angle * ty_expf(SMOOTHNESS * (mu - 1.0f));
            weight += kernel;
            for (int32_t i = 0; i < WIDTH; ++i) sum[i] += kernel * job->importance[WIDTH * other + (i + shift) % WIDTH];
        }
    }
    for (int32_t i = 0; i < WIDTH; ++i) job->smoothed[WIDTH * row + i] = sum[i] / weight;
}

static void make_uniform(float* map) {
    for (int32_t i = 0; i < DIRECTIONS; ++i) map[i] = 1.0f;
}

/* Scales to a mean of 1 over the sphere; a map of zeros becomes uniform. */
static void normalize(float* map) {
    double sum = 0;
    for (int32_t i = 0; i < DIRECTIONS; ++i) sum += (double)(map[i] * row_solid_angle(i / WIDTH) * TY_INV_4PI);
    if (!(sum > 0 && isfinite(sum))) {
        make_uniform(map);
        return;
    }
    for (int32_t i = 0; i < DIRECTIONS; ++i) map[i] = (float)((double)map[i] / sum);
}

static void blend_history(float* history, float* map) {
    if (history == NULL) return;
    float max_importance = 0.0f;
    for (int32_t i = 0; i < DIRECTIONS; ++i) max_importance = ty_maxf(max_importance, history[i]);
    for (int32_t i = 0; i < DIRECTIONS && max_importance > 0.0f; ++i) map[i] = ty_lerpf(history[i], map[i], NEW_WEIGHT);
    normalize(map);
    memcpy(history, map, DIRECTIONS * sizeof *map);
}

static ty_pop_occlusion_view occlusion_view(const ty_grid_medium* medium) {
    const ty_grid_box* box = &medium->box;
    ty_pop_occlusion_view view = {.planes = medium->planes};
    for (int c = 0; c < 3; ++c) {
        view.extinction[c] = medium->extinction[c];
        view.scattering[c] = medium->scattering[c];
        view.g[c] = medium->g[c];
        view.size[c] = box->size[c];
    }
    view.lower = ty_vec_make((float)box->lower[0], (float)box->lower[1], (float)box->lower[2]);
    view.upper = ty_vec_make((float)box->upper[0], (float)box->upper[1], (float)box->upper[2]);
    view.per_cell =
        ty_vec_make((float)(1 / medium->cell[0]), (float)(1 / medium->cell[1]), (float)(1 / medium->cell[2]));
    return view;
}

static void find_importance(importance_job* job, float* map) {
    ty_context* context = job->scene->context;
    for (int32_t i = 0; i < DIRECTIONS; ++i) {
        const ty_vec direction = texel_direction(job->scene->up, i % WIDTH, i / WIDTH, WIDTH, HEIGHT);
        job->direction_of[0][i] = direction.x;
        job->direction_of[1][i] = direction.y;
        job->direction_of[2][i] = direction.z;
    }
    ty_parallel_flushed(context, COLUMNS, march_row, job);
    ty_parallel_flushed(context, BLOCKS, find_out_transmittances, job);
    ty_parallel_flushed(context, HEIGHT, sum_row, job);
    ty_parallel_flushed(context, HEIGHT, smooth_map_row, job);
    memcpy(map, job->smoothed, sizeof job->smoothed);
    normalize(map);
}

/* Sec. 5.2 (Elek 2014). */
ty_result ty_pop_importance_find(const ty_scene* scene, const ty_pop_def* def, const ty_grid_medium* medium,
                                 float* map) {
    importance_job* job = ty_alloc_array(scene->context, 1, sizeof *job, true);
    if (job == NULL) return TY_ERROR_MEMORY;
    int32_t size[2];
    ty_image_resolution(scene, def->width, def->height, size);
    job->scene = scene;
    job->medium = occlusion_view(medium);
    job->frustum.camera = ty_camera_get_view(&scene->camera, size[0], size[1]);
    if (fit_frustum(&medium->box, size[0], size[1], &job->frustum))
        find_importance(job, map);
    else
        make_uniform(map);
    blend_history(def->history, map);
    ty_free_array(scene->context, job, 1, sizeof *job);
    return TY_OK;
}
