/* Irradiance of uncollided light on boundary faces, and cells that no light reaches. */
#include "direct/surfaces/boundary_faces.h"

#include "base/context.h"
#include "base/parallel.h"
#include "direct/media/attenuation.k.h"
#include "direct/shadow/grid_depth.h"
#include "scene/scene.h"

/* ---- light ---- */

typedef struct light_job {
    const ty_scene* scene;
    const ty_boundary_faces* faces;
    const ty_grid_medium* medium;
    float* const* extinction;
    const ty_discrete_light* sources;
    int32_t count;
    float offset; /* of shadow rays from the points of surface lights, m */
    float *const *irradiance, *const *forward;
} light_job;

/* Irradiance of a source on a side without occlusion and attenuation, per color. *ray: from the side to the source. */
static float unoccluded_irradiance(const light_job* job, const ty_discrete_light* source, const ty_boundary_side* side,
                                   ty_ray* ray) {
    ty_vec wi = ty_scale(source->direction, -1);
    float unoccluded = 1;
    ray->far = INFINITY;
    if (source->kind == TY_DISCRETE_POINT) {
        const ty_light_view* light = &job->scene->view.lights.lights[source->light];
        ty_vec off = ty_sub(source->position, side->position);
        float square = ty_dot(off, off);
        if (!(square > 0)) return 0;
        const float mu = -ty_dot(source->direction, off) / sqrtf(square);
        unoccluded = ty_light_profile_at(source->profile, light, mu) / (square + source->area / TY_PI);
        if (source->is_point == 0) off = ty_mad(off, source->direction, mu < 0 ? -job->offset : job->offset);
        square = ty_dot(off, off);
        ray->far = sqrtf(square);
        if (!(ray->far > 0)) return 0;
        wi = ty_scale(off, 1 / ray->far);
    }
    for (int a = 0; a < 3; ++a) {
        const float position[3] = {side->position.x, side->position.y, side->position.z};
        const float omega[3] = {wi.x, wi.y, wi.z};
        ray->origin[a] = position[a];
        ray->direction[a] = omega[a];
    }
    return unoccluded * ty_maxf(0, ty_dot(wi, side->normal));
}

/* Adds one source's irradiance on a packet of sides. */
static void light_sides(const light_job* job, const ty_discrete_light* source, int32_t begin, int32_t end) {
    ty_ray rays[TY_PACKET];
    bool shadowed[TY_PACKET];
    int32_t sides[TY_PACKET], count = 0;
    float unoccluded[TY_PACKET];
    for (int32_t i = begin; i < end; ++i) {
        unoccluded[count] = unoccluded_irradiance(job, source, &job->faces->sides[i], &rays[count]);
        sides[count] = i;
        if (unoccluded[count] > 0) ++count;
    }
    if (count == 0) return;
    ty_accel_occluded_packet(job->scene->view.mesh, rays, count, shadowed);
    for (int32_t i = 0; i < count; ++i) {
        const ty_vec origin = ty_vec_load(rays[i].origin), wi = ty_vec_load(rays[i].direction);
        const float far = ty_minf(rays[i].far, 1e30f);
        float depth[3], all[3];
        if (shadowed[i]) continue;
        ty_grid_depth(job->medium, job->extinction, origin, wi, far, depth);
        for (int c = 0; c < 3; ++c)
            job->irradiance[c][sides[i]] += unoccluded[i] * source->color[c] * ty_attenuation(depth[c]);
        if (job->forward == NULL) continue;
        ty_grid_depth(job->medium, NULL, origin, wi, far, all);
        for (int c = 0; c < 3; ++c)
            job->forward[c][sides[i]] +=
                unoccluded[i] * source->color[c] * (ty_attenuation(depth[c]) - ty_attenuation(all[c]));
    }
}

static void light_packet(void* user, int64_t index, int32_t worker) {
    (void)worker;
    const light_job* job = user;
    const int32_t begin = (int32_t)index * TY_PACKET, left = job->faces->count - begin;
    for (int32_t i = 0; i < job->count; ++i)
        light_sides(job, &job->sources[i], begin, begin + (left < TY_PACKET ? left : TY_PACKET));
}

void ty_boundary_irradiance_add(const ty_scene* scene, const ty_boundary_faces* faces, const ty_grid_medium* medium,
                                float* const extinction[3], const ty_discrete_light* sources, int32_t count,
                                float* const irradiance[3], float* const forward[3]) {
    const double* cell = medium->cell;
    const light_job job = {.scene = scene,
                           .faces = faces,
                           .medium = medium,
                           .extinction = extinction,
                           .sources = sources,
                           .count = count,
                           .offset = (float)(1e-3 * fmin(fmin(cell[0], cell[1]), cell[2])),
                           .irradiance = irradiance,
                           .forward = forward};
    ty_parallel_flushed(faces->context, (faces->count + TY_PACKET - 1) / TY_PACKET, light_packet, (void*)&job);
}

void ty_side_match_irradiance(const ty_boundary_side* side, float irradiance, size_t cell, float* const terms[4]) {
    const float normal[3] = {side->normal.x, side->normal.y, side->normal.z};
    float along = 0;
    for (int a = 0; a < 3; ++a) along += terms[1 + a][cell] * normal[a];
    /* The first two moments give the irradiance pi (phi_0 - 2/3 phi_n), phi_n along the normal. */
    const float difference = 1.5f * (terms[0][cell] - irradiance / TY_PI) - along;
    for (int a = 0; a < 3; ++a) terms[1 + a][cell] += difference * normal[a];
}

/* ---- unlit cells ---- */

typedef struct flood {
    const ty_boundary_faces* faces;
    uint8_t* unlit;
    int32_t* cells; /* stack of cells whose neighbours are still to be visited */
    int32_t count;
} flood;

static void reach(flood* f, size_t cell) {
    if (f->unlit[cell] == 0) return;
    f->unlit[cell] = 0;
    f->cells[f->count++] = (int32_t)cell;
}

/* Flood fill from all visited cells through open faces. */
static void spread(flood* f) {
    const int32_t* size = f->faces->size;
    const int32_t steps[3] = {1, size[0], size[0] * size[1]};
    while (f->count > 0) {
        const int32_t cell = f->cells[--f->count];
        const int32_t at[3] = {cell % size[0], cell / size[0] % size[1], cell / steps[2]};
        for (int face = 0; face < 6; ++face) {
            const int a = face / 2, up = face & 1;
            if ((f->faces->closed[cell] >> face & 1) != 0 || at[a] == (up != 0 ? size[a] - 1 : 0)) continue;
            reach(f, (size_t)(up != 0 ? cell + steps[a] : cell - steps[a]));
        }
    }
}

/* Reaches cells at open faces of the box, and emissive cells. */
static void reach_open(flood* f, const ty_grid_medium* medium) {
    const int32_t* size = f->faces->size;
    for (size_t i = 0; i < medium->cells; ++i) {
        const int32_t at[3] = {(int32_t)(i % (size_t)size[0]), (int32_t)(i / (size_t)size[0] % (size_t)size[1]),
                               (int32_t)(i / ((size_t)size[0] * (size_t)size[1]))};
        bool open = false;
        for (int face = 0; face < 6; ++face)
            open = open || (at[face / 2] == ((face & 1) != 0 ? size[face / 2] - 1 : 0) &&
                            (f->faces->closed[i] >> face & 1) == 0);
        for (int c = 0; c < 3 && medium->emission[0] != NULL; ++c) open = open || medium->emission[c][i] > 0;
        if (open) reach(f, i);
    }
}

/* Reaches the cells around a point light whose centers it sees. */
static void reach_point_light(flood* f, const ty_scene* scene, const ty_grid_medium* medium,
                              const ty_discrete_light* source) {
    const float position[3] = {source->position.x, source->position.y, source->position.z};
    const float normal[3] = {source->direction.x, source->direction.y, source->direction.z};
    int32_t home[3];
    for (int a = 0; a < 3; ++a)
        home[a] = (int32_t)fmin(fmax(floor(((double)position[a] - medium->box.lower[a]) / medium->cell[a]), -2),
                                f->faces->size[a] + 1);
    for (int i = 0; i < 27; ++i) {
        const int32_t at[3] = {home[0] + i % 3 - 1, home[1] + i / 3 % 3 - 1, home[2] + i / 9 - 1};
        float center[3], start[3];
        bool inside = true;
        for (int a = 0; a < 3; ++a) {
            inside = inside && at[a] >= 0 && at[a] < f->faces->size[a];
            center[a] = (float)(medium->box.lower[a] + (at[a] + 0.5) * medium->cell[a]);
        }
        if (!inside) continue;
        const ty_vec off = ty_sub(ty_vec_load(center), source->position);
        const float offset = source->is_point != 0 ? 0 : ty_dot(off, source->direction) < 0 ? -1e-3f : 1e-3f;
        for (int a = 0; a < 3; ++a) start[a] = position[a] + offset * (float)medium->cell[a] * normal[a];
        const ty_vec omega = ty_sub(ty_vec_load(center), ty_vec_load(start));
        const float length = sqrtf(ty_dot(omega, omega));
        if (length > 0 && ty_accel_occluded(scene->view.mesh, ty_vec_load(start), ty_scale(omega, 1 / length), length))
            continue;
        reach(f,
              ((size_t)at[2] * (size_t)f->faces->size[1] + (size_t)at[1]) * (size_t)f->faces->size[0] + (size_t)at[0]);
    }
}

ty_result ty_unlit_cells_find(const ty_scene* scene, const ty_boundary_faces* faces, const ty_grid_medium* medium,
                              const ty_discrete_light* sources, int32_t count, uint8_t* unlit) {
    flood f = {.faces = faces, .unlit = unlit};
    f.cells = ty_alloc_array(faces->context, medium->cells, sizeof *f.cells, false);
    if (f.cells == NULL) return TY_ERROR_MEMORY;
    memset(unlit, 1, medium->cells);
    reach_open(&f, medium);
    for (int32_t i = 0; i < count; ++i)
        if (sources[i].kind == TY_DISCRETE_POINT && sources[i].is_virtual == 0)
            reach_point_light(&f, scene, medium, &sources[i]);
    spread(&f);
    ty_free_array(faces->context, f.cells, medium->cells, sizeof *f.cells);
    return TY_OK;
}
