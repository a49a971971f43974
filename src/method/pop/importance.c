/* How much the camera sees of light from each direction (Sec. 5.2). */
#include "scene/environment_map.k.h"

#include "base/context.h"
#include "base/parallel.h"
#include "image/options.h"
#include "method/pop/importance.k.h"
#include "method/pop/ordinate.h"
#include "scene/camera.h"
#include "scene/scene.h"

/* Cells of the grid in the camera's frustum: columns across, and layers along it, in steps of the march. */
enum { COLUMNS = 16, LAYERS = 16, STEPS = 2 };

/* Layers whose scattering is taken for one lobe; blocks of lobes that share ways out of the medium. */
enum { GROUP = 4, GROUPS = LAYERS / GROUP, ACROSS = 4, BLOCKS = COLUMNS / ACROSS * (COLUMNS / ACROSS) * GROUPS };

enum {
    WIDTH = TY_POP_IMPORTANCE_WIDTH,
    HEIGHT = TY_POP_IMPORTANCE_HEIGHT,
    DIRECTIONS = WIDTH * HEIGHT,
    WAYS_WIDTH = WIDTH / 2, /* of the map of ways out */
    WAYS_HEIGHT = HEIGHT / 2,
    WAY_STEPS = 8
};

/* The kernel that smooths the map falls to 1/e a texel (11.25 degrees) away. */
static const float SMOOTHNESS = 52.0f;

/* Of this frame in what is returned, where there was one before. */
static const float FRESH = 0.5f;

typedef struct frustum {
    ty_camera_view camera;
    float from[2], to[2]; /* the part of the image that sees the box, pixels */
    float near, far;      /* depths */
} frustum;

typedef struct gaze_job {
    const ty_scene* scene;
    ty_pop_murk_view murk;
    frustum view;
    float look[3][DIRECTIONS]; /* unit */
    ty_vec ray[COLUMNS * COLUMNS];
    ty_pop_glance glances[COLUMNS * COLUMNS][GROUPS];
    float aside[BLOCKS];               /* of glances */
    float out[BLOCKS][DIRECTIONS];     /* transmittance of the ways out, of light that keeps its direction */
    float outward[BLOCKS][DIRECTIONS]; /* and of light that has none */
    float seen[DIRECTIONS];
    float smooth[DIRECTIONS];
} gaze_job;

static float row_solid_angle(int32_t row) {
    const double pi = 3.14159265358979323846;
    return (float)(2 * pi / WIDTH * (cos(pi * row / HEIGHT) - cos(pi * (row + 1) / HEIGHT)));
}

/* Where one looks at the middle of a texel of a map, as in an environment that is not turned. */
static ty_vec look_at(ty_axis up, int32_t column, int32_t row, int32_t width, int32_t height) {
    const double pi = 3.14159265358979323846;
    const double angle = 2 * pi * (0.5 - (column + 0.5) / width), down = pi * (row + 0.5) / height;
    const float across = (float)(sin(down) * cos(angle)), along = (float)(sin(down) * sin(angle));
    return up == TY_AXIS_Z ? ty_vec_make(across, along, (float)cos(down))
                           : ty_vec_make(across, (float)cos(down), -along);
}

/* ---- the frustum ---- */

static void widen(frustum* view, float x, float y) {
    view->from[0] = ty_minf(view->from[0], x);
    view->from[1] = ty_minf(view->from[1], y);
    view->to[0] = ty_maxf(view->to[0], x);
    view->to[1] = ty_maxf(view->to[1], y);
}

/* Fits the grid to what the camera sees of the box; false where that is nothing. */
static bool fit_frustum(const ty_grid_box* box, int32_t width, int32_t height, frustum* view) {
    const ty_camera_view* camera = &view->camera;
    const ty_vec forward =
        ty_mad(ty_mad(camera->corner, camera->dx, 0.5f * (float)width), camera->dy, 0.5f * (float)height);
    const float per_x = 1.0f / ty_dot(camera->dx, camera->dx), per_y = 1.0f / ty_dot(camera->dy, camera->dy);
    bool behind = false;
    view->near = view->from[0] = view->from[1] = TY_FLOAT_MAX;
    view->far = view->to[0] = view->to[1] = -TY_FLOAT_MAX;
    for (int32_t i = 0; i < 8; ++i) {
        const ty_vec corner = ty_vec_make((float)((i & 1) != 0 ? box->upper[0] : box->lower[0]),
                                          (float)((i & 2) != 0 ? box->upper[1] : box->lower[1]),
                                          (float)((i & 4) != 0 ? box->upper[2] : box->lower[2]));
        const ty_vec off = ty_sub(corner, camera->origin);
        const float depth = ty_dot(off, forward);
        view->near = ty_minf(view->near, depth);
        view->far = ty_maxf(view->far, depth);
        behind |= !(depth > 0.0f);
        if (depth > 0.0f)
            widen(view, 0.5f * (float)width + ty_dot(off, camera->dx) * per_x / depth,
                  0.5f * (float)height + ty_dot(off, camera->dy) * per_y / depth);
    }
    if (behind) {
        widen(view, 0.0f, 0.0f);
        widen(view, (float)width, (float)height);
    }
    view->near = ty_maxf(0.0f, view->near);
    const float whole[2] = {(float)width, (float)height};
    for (int a = 0; a < 2; ++a) {
        view->from[a] = ty_clampf(view->from[a], 0.0f, whole[a]);
        view->to[a] = ty_clampf(view->to[a], 0.0f, whole[a]);
    }
    return view->far > view->near && view->to[0] > view->from[0] && view->to[1] > view->from[1];
}

/* ---- from the eye into the medium ---- */

/* One column; a ray's vector is a unit of depth long. */
static void follow_column(gaze_job* job, int32_t column, int32_t row) {
    const frustum* view = &job->view;
    const float x = ty_lerpf(view->from[0], view->to[0], ((float)column + 0.5f) / COLUMNS);
    const float y = ty_lerpf(view->from[1], view->to[1], ((float)row + 0.5f) / COLUMNS);
    const ty_vec along = ty_mad(ty_mad(view->camera.corner, view->camera.dx, x), view->camera.dy, y);
    const float stretch = sqrtf(ty_dot(along, along)), step = (view->far - view->near) / (LAYERS * STEPS);
    const ty_accel* mesh = job->scene->view.mesh;
    const int32_t at = COLUMNS * row + column;
    ty_pop_gaze gaze = {.straight = 1, .first = 1, .second = 1};
    float end = view->far;
    ty_hit hit;
    job->ray[at] = ty_scale(along, 1.0f / stretch);
    if (mesh != NULL && ty_accel_intersect(mesh, view->camera.origin, job->ray[at], stretch * end, &hit))
        end = hit.distance / stretch;
    for (int32_t k = 0; k < LAYERS * STEPS; ++k) {
        const float depth = view->near + step * (float)k, length = ty_minf(step, end - depth);
        if (!(length > 0.0f)) return;
        const ty_vec point = ty_mad(view->camera.origin, along, depth + 0.5f * length);
        const ty_pop_murk murk = ty_pop_murk_at(&job->murk, point);
        ty_pop_glance_add(&job->glances[at][k / (STEPS * GROUP)], &gaze, &murk, point, length * stretch);
    }
}

static void follow_row(void* user, int64_t row, int32_t worker) {
    (void)worker;
    for (int32_t column = 0; column < COLUMNS; ++column) follow_column(user, column, (int32_t)row);
}

/* ---- and out of it to where light comes from ---- */

static int32_t block_of(int32_t column, int32_t row, int32_t group) {
    const int32_t blocks = COLUMNS / ACROSS;
    return group + GROUPS * (column / ACROSS + blocks * (row / ACROSS));
}

/* Where a block's importance is, in the mean, and what turns aside; false where there is none. */
static bool place_block(gaze_job* job, int32_t block, ty_vec* place) {
    const int32_t blocks = COLUMNS / ACROSS, group = block % GROUPS;
    const int32_t left = ACROSS * (block / GROUPS % blocks), top = ACROSS * (block / GROUPS / blocks);
    float weight = 0.0f;
    *place = ty_vec_make(0.0f, 0.0f, 0.0f);
    for (int32_t row = top; row < top + ACROSS; ++row)
        for (int32_t column = left; column < left + ACROSS; ++column) {
            const ty_pop_glance* glance = &job->glances[COLUMNS * row + column][group];
            weight += glance->straight + glance->forward;
            *place = ty_add(*place, glance->place);
            job->aside[block] += glance->aside;
        }
    if (!(weight > 0.0f)) return false;
    *place = ty_scale(*place, 1.0f / weight);
    return true;
}

/* Distance to the box's sides from within. */
static float way_to_side(const ty_pop_murk_view* murk, ty_vec point, ty_vec way) {
    const float from[3] = {point.x, point.y, point.z}, along[3] = {way.x, way.y, way.z};
    const float lower[3] = {murk->lower.x, murk->lower.y, murk->lower.z};
    const float upper[3] = {murk->upper.x, murk->upper.y, murk->upper.z};
    float nearest = TY_FLOAT_MAX;
    for (int a = 0; a < 3; ++a) {
        const float side = along[a] > 0.0f ? upper[a] : lower[a];
        if (fabsf(along[a]) > 1e-6f) nearest = ty_minf(nearest, (side - from[a]) / along[a]);
    }
    return ty_maxf(0.0f, nearest);
}

/* Optical depth, reduced, as ordinates carry light; what surfaces are before counts as deep. */
static float depth_outward(const gaze_job* job, ty_vec point, ty_vec way) {
    const float length = way_to_side(&job->murk, point, way) / WAY_STEPS;
    float tau = 0.0f;
    if (job->scene->view.mesh != NULL && ty_accel_occluded(job->scene->view.mesh, point, way, TY_FLOAT_MAX))
        return TY_FLOAT_MAX;
    for (int32_t i = 0; i < WAY_STEPS; ++i) {
        const ty_pop_murk murk = ty_pop_murk_at(&job->murk, ty_mad(point, way, ((float)i + 0.5f) * length));
        tau += length * ty_pop_murk_reduced(&murk, 1);
    }
    return tau;
}

static void refine_ways(const float* coarse, float* out) {
    for (int32_t i = 0; i < DIRECTIONS; ++i)
        out[i] = ty_environment_map_at(coarse, WAYS_WIDTH, WAYS_HEIGHT, ((float)(i % WIDTH) + 0.5f) / WIDTH,
                                       ((float)(i / WIDTH) + 0.5f) / HEIGHT);
}

/* Light without a direction gets through a layer as in two-stream diffusion. */
static void follow_ways(void* user, int64_t index, int32_t worker) {
    (void)worker;
    gaze_job* job = user;
    float straight[WAYS_WIDTH * WAYS_HEIGHT], diffuse[WAYS_WIDTH * WAYS_HEIGHT];
    ty_vec place;
    if (!place_block(job, (int32_t)index, &place)) return;
    for (int32_t i = 0; i < WAYS_WIDTH * WAYS_HEIGHT; ++i) {
        const ty_vec way = look_at(job->scene->up, i % WAYS_WIDTH, i / WAYS_WIDTH, WAYS_WIDTH, WAYS_HEIGHT);
        const float tau = depth_outward(job, place, way);
        straight[i] = ty_decay(tau);
        diffuse[i] = 1.0f / (1.0f + 0.75f * tau);
    }
    refine_ways(straight, job->out[index]);
    refine_ways(diffuse, job->outward[index]);
}

/* Adds what one lobe sees of each direction of a row of the map. */
static void add_glance(gaze_job* job, const ty_pop_glance* glance, ty_vec ray, const float* out, int32_t row) {
    if (!(glance->straight + glance->forward > 0.0f)) return;
    const ty_pop_lobe lobe = ty_pop_lobe_of(glance);
    const int32_t first = WIDTH * row;
    const float *x = job->look[0] + first, *y = job->look[1] + first, *z = job->look[2] + first;
    float* seen = job->seen + first;
#pragma omp simd
    for (int32_t i = 0; i < WIDTH; ++i) {
        const float mu = x[i] * ray.x + y[i] * ray.y + z[i] * ray.z;
        seen[i] += ty_pop_lobe_at(&lobe, mu) * out[first + i];
    }
}

static void see_row(void* user, int64_t index, int32_t worker) {
    (void)worker;
    gaze_job* job = user;
    for (int32_t row = 0; row < COLUMNS; ++row)
        for (int32_t column = 0; column < COLUMNS; ++column)
            for (int32_t group = 0; group < GROUPS; ++group) {
                const int32_t at = COLUMNS * row + column;
                add_glance(job, &job->glances[at][group], job->ray[at], job->out[block_of(column, row, group)],
                           (int32_t)index);
            }
    for (int32_t block = 0; block < BLOCKS; ++block)
        for (int32_t i = WIDTH * (int32_t)index; i < WIDTH * ((int32_t)index + 1); ++i)
            job->seen[i] += TY_INV_4PI * job->aside[block] * job->outward[block][i];
}

/* ---- the map ---- */

/* Means about each direction of a row, on the sphere: poles are as any other place. */
static void smooth_row(void* user, int64_t index, int32_t worker) {
    (void)worker;
    gaze_job* job = user;
    float sum[WIDTH] = {0}, weight = 0.0f;
    const int32_t row = (int32_t)index;
    for (int32_t other = 0; other < HEIGHT; ++other) {
        const float solid_angle = row_solid_angle(other);
        for (int32_t shift = 0; shift < WIDTH; ++shift) {
            const int32_t a = WIDTH * row, b = WIDTH * other + shift;
            const float mu = job->look[0][a] * job->look[0][b] + job->look[1][a] * job->look[1][b] +
                             job->look[2][a] * job->look[2][b];
            const float share = solid_angle * ty_expf(SMOOTHNESS * (mu - 1.0f));
            weight += share;
            for (int32_t i = 0; i < WIDTH; ++i) sum[i] += share * job->seen[WIDTH * other + (i + shift) % WIDTH];
        }
    }
    for (int32_t i = 0; i < WIDTH; ++i) job->smooth[WIDTH * row + i] = sum[i] / weight;
}

static void make_even(float* map) {
    for (int32_t i = 0; i < DIRECTIONS; ++i) map[i] = 1.0f;
}

/* To a mean of 1 over the sphere; a map of nothing becomes even. */
static void normalize(float* map) {
    double sum = 0;
    for (int32_t i = 0; i < DIRECTIONS; ++i) sum += (double)(map[i] * row_solid_angle(i / WIDTH) * TY_INV_4PI);
    if (!(sum > 0 && isfinite(sum))) {
        make_even(map);
        return;
    }
    for (int32_t i = 0; i < DIRECTIONS; ++i) map[i] = (float)((double)map[i] / sum);
}

static void mix_with(float* history, float* map) {
    if (history == NULL) return;
    float most = 0.0f;
    for (int32_t i = 0; i < DIRECTIONS; ++i) most = ty_maxf(most, history[i]);
    for (int32_t i = 0; i < DIRECTIONS && most > 0.0f; ++i) map[i] = ty_lerpf(history[i], map[i], FRESH);
    normalize(map);
    memcpy(history, map, DIRECTIONS * sizeof *map);
}

static ty_pop_murk_view murk_of(const ty_grid_medium* medium) {
    const ty_grid_box* box = &medium->box;
    ty_pop_murk_view murk = {.planes = medium->planes};
    for (int c = 0; c < 3; ++c) {
        murk.extinction[c] = medium->extinction[c];
        murk.scattering[c] = medium->scattering[c];
        murk.g[c] = medium->g[c];
        murk.size[c] = box->size[c];
    }
    murk.lower = ty_vec_make((float)box->lower[0], (float)box->lower[1], (float)box->lower[2]);
    murk.upper = ty_vec_make((float)box->upper[0], (float)box->upper[1], (float)box->upper[2]);
    murk.per_cell =
        ty_vec_make((float)(1 / medium->cell[0]), (float)(1 / medium->cell[1]), (float)(1 / medium->cell[2]));
    return murk;
}

static void look_around(gaze_job* job, float* map) {
    ty_context* context = job->scene->context;
    for (int32_t i = 0; i < DIRECTIONS; ++i) {
        const ty_vec look = look_at(job->scene->up, i % WIDTH, i / WIDTH, WIDTH, HEIGHT);
        job->look[0][i] = look.x;
        job->look[1][i] = look.y;
        job->look[2][i] = look.z;
    }
    ty_parallel_flushed(context, COLUMNS, follow_row, job);
    ty_parallel_flushed(context, BLOCKS, follow_ways, job);
    ty_parallel_flushed(context, HEIGHT, see_row, job);
    ty_parallel_flushed(context, HEIGHT, smooth_row, job);
    memcpy(map, job->smooth, sizeof job->smooth);
    normalize(map);
}

ty_result ty_pop_importance_find(const ty_scene* scene, const ty_pop_def* def, const ty_grid_medium* medium,
                                 float* map) {
    gaze_job* job = ty_alloc_array(scene->context, 1, sizeof *job, true);
    if (job == NULL) return TY_ERROR_MEMORY;
    int32_t size[2];
    ty_image_resolution(scene, def->width, def->height, size);
    job->scene = scene;
    job->murk = murk_of(medium);
    job->view.camera = ty_camera_get_view(&scene->camera, size[0], size[1]);
    if (fit_frustum(&medium->box, size[0], size[1], &job->view))
        look_around(job, map);
    else
        make_even(map);
    mix_with(def->history, map);
    ty_free_array(scene->context, job, 1, sizeof *job);
    return TY_OK;
}
