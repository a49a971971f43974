/* Uncollided light on walls, and cells that no light gets to. */
#include "direct/walls.h"

#include "base/context.h"
#include "base/parallel.h"
#include "direct/beam.k.h"
#include "direct/grid_depth.h"
#include "scene/scene.h"

/* ---- light ---- */

typedef struct light_job {
    const ty_scene* scene;
    const ty_walls* walls;
    const ty_grid_medium* medium;
    float* const* extinction;
    const ty_source* sources;
    int32_t count;
    float lift; /* of points on surfaces, m */
    float *const *irradiance, *const *forward;
} light_job;

/* Irradiance that a source would bring to a wall if nothing were between them, per color; the ray to it. */
static float bare_light(const light_job* job, const ty_source* source, const ty_wall* wall, ty_ray* ray) {
    ty_vec toward = ty_scale(source->direction, -1);
    float bare = 1;
    ray->far = INFINITY;
    if (source->kind == TY_SOURCE_LAMP) {
        const ty_light_view* light =
            source->stand_in != NULL ? source->stand_in : &job->scene->view.lights.lights[source->light];
        ty_vec off = ty_sub(source->position, wall->position);
        float square = ty_dot(off, off);
        if (!(square > 0)) return 0;
        const float mu = -ty_dot(source->direction, off) / sqrtf(square);
        bare = ty_source_profile(light, mu) / (square + source->area / TY_PI);
        if (source->alone == 0) off = ty_mad(off, source->direction, mu < 0 ? -job->lift : job->lift);
        square = ty_dot(off, off);
        ray->far = sqrtf(square);
        if (!(ray->far > 0)) return 0;
        toward = ty_scale(off, 1 / ray->far);
    }
    for (int a = 0; a < 3; ++a) {
        const float place[3] = {wall->position.x, wall->position.y, wall->position.z};
        const float way[3] = {toward.x, toward.y, toward.z};
        ray->origin[a] = place[a];
        ray->direction[a] = way[a];
    }
    return bare * ty_maxf(0, ty_dot(toward, wall->normal));
}

/* One source's light on a few sides. */
static void light_sides(const light_job* job, const ty_source* source, int32_t begin, int32_t end) {
    ty_ray rays[TY_PACKET];
    bool shadowed[TY_PACKET];
    int32_t sides[TY_PACKET], count = 0;
    float bare[TY_PACKET];
    for (int32_t i = begin; i < end; ++i) {
        bare[count] = bare_light(job, source, &job->walls->sides[i], &rays[count]);
        sides[count] = i;
        if (bare[count] > 0) ++count;
    }
    if (count == 0) return;
    ty_accel_occluded_packet(job->scene->view.mesh, rays, count, shadowed);
    for (int32_t i = 0; i < count; ++i) {
        const ty_vec origin = ty_vec_load(rays[i].origin), toward = ty_vec_load(rays[i].direction);
        const float far = ty_minf(rays[i].far, 1e30f);
        float depth[3], all[3];
        if (shadowed[i]) continue;
        ty_grid_depth(job->medium, job->extinction, origin, toward, far, depth);
        for (int c = 0; c < 3; ++c) job->irradiance[c][sides[i]] += bare[i] * source->color[c] * ty_decay(depth[c]);
        if (job->forward == NULL) continue;
        ty_grid_depth(job->medium, NULL, origin, toward, far, all);
        for (int c = 0; c < 3; ++c)
            job->forward[c][sides[i]] += bare[i] * source->color[c] * (ty_decay(depth[c]) - ty_decay(all[c]));
    }
}

static void light_some(void* user, int64_t index, int32_t worker) {
    (void)worker;
    const light_job* job = user;
    const int32_t begin = (int32_t)index * TY_PACKET, left = job->walls->count - begin;
    for (int32_t i = 0; i < job->count; ++i)
        light_sides(job, &job->sources[i], begin, begin + (left < TY_PACKET ? left : TY_PACKET));
}

void ty_walls_light(const ty_scene* scene, const ty_walls* walls, const ty_grid_medium* medium,
                    float* const extinction[3], const ty_source* sources, int32_t count, float* const irradiance[3],
                    float* const forward[3]) {
    const double* cell = medium->cell;
    const light_job job = {.scene = scene,
                           .walls = walls,
                           .medium = medium,
                           .extinction = extinction,
                           .sources = sources,
                           .count = count,
                           .lift = (float)(1e-3 * fmin(fmin(cell[0], cell[1]), cell[2])),
                           .irradiance = irradiance,
                           .forward = forward};
    ty_parallel_flushed(walls->context, (walls->count + TY_PACKET - 1) / TY_PACKET, light_some, (void*)&job);
}

/* ---- dark cells ---- */

typedef struct flood {
    const ty_walls* walls;
    uint8_t* dark;
    int32_t* cells; /* that are to be looked at */
    int32_t count;
} flood;

static void reach(flood* f, size_t cell) {
    if (f->dark[cell] == 0) return;
    f->dark[cell] = 0;
    f->cells[f->count++] = (int32_t)cell;
}

/* From all cells reached on through open faces. */
static void spread(flood* f) {
    const int32_t* size = f->walls->size;
    const int32_t steps[3] = {1, size[0], size[0] * size[1]};
    while (f->count > 0) {
        const int32_t cell = f->cells[--f->count];
        const int32_t at[3] = {cell % size[0], cell / size[0] % size[1], cell / steps[2]};
        for (int face = 0; face < 6; ++face) {
            const int a = face / 2, up = face & 1;
            if ((f->walls->closed[cell] >> face & 1) != 0 || at[a] == (up != 0 ? size[a] - 1 : 0)) continue;
            reach(f, (size_t)(up != 0 ? cell + steps[a] : cell - steps[a]));
        }
    }
}

/* Cells at the box's open faces, and that emit. */
static void reach_open(flood* f, const ty_grid_medium* medium) {
    const int32_t* size = f->walls->size;
    for (size_t i = 0; i < medium->cells; ++i) {
        const int32_t at[3] = {(int32_t)(i % (size_t)size[0]), (int32_t)(i / (size_t)size[0] % (size_t)size[1]),
                               (int32_t)(i / ((size_t)size[0] * (size_t)size[1]))};
        bool open = false;
        for (int face = 0; face < 6; ++face)
            open = open || (at[face / 2] == ((face & 1) != 0 ? size[face / 2] - 1 : 0) &&
                            (f->walls->closed[i] >> face & 1) == 0);
        for (int c = 0; c < 3 && medium->emission[0] != NULL; ++c) open = open || medium->emission[c][i] > 0;
        if (open) reach(f, i);
    }
}

/* The cells about a lamp whose middles it shines on. */
static void reach_lamp(flood* f, const ty_scene* scene, const ty_grid_medium* medium, const ty_source* source) {
    const float place[3] = {source->position.x, source->position.y, source->position.z};
    const float normal[3] = {source->direction.x, source->direction.y, source->direction.z};
    int32_t home[3];
    for (int a = 0; a < 3; ++a)
        home[a] = (int32_t)fmin(fmax(floor(((double)place[a] - medium->box.lower[a]) / medium->cell[a]), -2),
                                f->walls->size[a] + 1);
    for (int i = 0; i < 27; ++i) {
        const int32_t at[3] = {home[0] + i % 3 - 1, home[1] + i / 3 % 3 - 1, home[2] + i / 9 - 1};
        float middle[3], start[3];
        bool inside = true;
        for (int a = 0; a < 3; ++a) {
            inside = inside && at[a] >= 0 && at[a] < f->walls->size[a];
            middle[a] = (float)(medium->box.lower[a] + (at[a] + 0.5) * medium->cell[a]);
        }
        if (!inside) continue;
        const ty_vec off = ty_sub(ty_vec_load(middle), source->position);
        const float lift = source->alone != 0 ? 0 : ty_dot(off, source->direction) < 0 ? -1e-3f : 1e-3f;
        for (int a = 0; a < 3; ++a) start[a] = place[a] + lift * (float)medium->cell[a] * normal[a];
        const ty_vec way = ty_sub(ty_vec_load(middle), ty_vec_load(start));
        const float length = sqrtf(ty_dot(way, way));
        if (length > 0 && ty_accel_occluded(scene->view.mesh, ty_vec_load(start), ty_scale(way, 1 / length), length))
            continue;
        reach(f,
              ((size_t)at[2] * (size_t)f->walls->size[1] + (size_t)at[1]) * (size_t)f->walls->size[0] + (size_t)at[0]);
    }
}

ty_result ty_walls_find_dark(const ty_scene* scene, const ty_walls* walls, const ty_grid_medium* medium,
                             const ty_source* sources, int32_t count, uint8_t* dark) {
    flood f = {.walls = walls, .dark = dark};
    f.cells = ty_alloc_array(walls->context, medium->cells, sizeof *f.cells, false);
    if (f.cells == NULL) return TY_ERROR_MEMORY;
    memset(dark, 1, medium->cells);
    reach_open(&f, medium);
    for (int32_t i = 0; i < count; ++i)
        if (sources[i].kind == TY_SOURCE_LAMP && sources[i].stand_in == NULL)
            reach_lamp(&f, scene, medium, &sources[i]);
    spread(&f);
    ty_free_array(walls->context, f.cells, medium->cells, sizeof *f.cells);
    return TY_OK;
}
