/* Where columns of a grid go, and what they meet. */
#include "method/pop/columns.h"

#include "direct/source.h"
#include "scene/scene.h"

typedef struct column_ray {
    double origin[3], way[3]; /* m; unit */
    double start;             /* where along the column its origin is, m */
} column_ray;

/* A ray along a column; u, v: where in it, 0.5 in the middle. */
static column_ray ray_of(const ty_pop_frame* frame, int32_t column, double u, double v) {
    const double i = column % frame->size[0] + u, j = column / frame->size[0] + v;
    const float origin[3] = {frame->origin.x, frame->origin.y, frame->origin.z};
    column_ray ray = {.start = 0};
    ty_vec way = frame->axis[2];
    if (frame->kind == TY_LIGHT_PART_RADIAL)
        way = ty_octahedral_direction((float)(2 * i / frame->size[0] - 1), (float)(2 * j / frame->size[1] - 1));
    const float along[3] = {way.x, way.y, way.z};
    const float first[3] = {frame->axis[0].x, frame->axis[0].y, frame->axis[0].z};
    const float second[3] = {frame->axis[1].x, frame->axis[1].y, frame->axis[1].z};
    for (int a = 0; a < 3; ++a) {
        ray.origin[a] = (double)origin[a];
        ray.way[a] = (double)along[a];
        if (frame->kind == TY_LIGHT_PART_PARALLEL)
            ray.origin[a] +=
                i * (double)frame->step.x * (double)first[a] + j * (double)frame->step.y * (double)second[a];
    }
    return ray;
}

/* Where a ray is within the medium's box. */
static void cut(const ty_grid_box* box, const column_ray* ray, float* enter, float* leave) {
    double range[2] = {0, INFINITY};
    for (int a = 0; a < 3; ++a) {
        if (fabs(ray->way[a]) < 1e-12) {
            if (ray->origin[a] < box->lower[a] || ray->origin[a] > box->upper[a]) range[1] = 0;
            continue;
        }
        const double t0 = (box->lower[a] - ray->origin[a]) / ray->way[a];
        const double t1 = (box->upper[a] - ray->origin[a]) / ray->way[a];
        range[0] = fmax(range[0], fmin(t0, t1));
        range[1] = fmin(range[1], fmax(t0, t1));
    }
    const bool meets = range[0] < range[1];
    *enter = meets ? (float)range[0] : 0;
    *leave = meets ? (float)range[1] : 0;
}

/* ---- intensity ---- */

static float across_of(const ty_pop_frame* frame, int32_t column) {
    if (frame->kind == TY_LIGHT_PART_PARALLEL) return frame->step.x * frame->step.y;
    return ty_octahedral_angle(ty_pop_way(frame, column % frame->size[0], column / frame->size[0]), frame->size[0]);
}

static float profile_of(const ty_scene_view* view, const ty_light_part* ordinate, const column_ray* ray) {
    if (ordinate->kind == TY_LIGHT_PART_PARALLEL || ordinate->profile == TY_LIGHT_PART_EVEN) return 1;
    const ty_vec way = ty_vec_make((float)ray->way[0], (float)ray->way[1], (float)ray->way[2]);
    const float mu = ty_dot(way, ordinate->direction);
    if (ordinate->profile == TY_LIGHT_PART_COSINE) return ty_maxf(0, mu);
    return ty_source_profile(&view->lights.lights[ordinate->light], mu);
}

/* The ray on which light comes: from a lamp afar, to the middle of the column's length. */
static column_ray lit_ray(const ty_pop_frame* frame, const ty_light_part* ordinate, const column_ray* ray) {
    if (frame->kind == TY_LIGHT_PART_RADIAL || ordinate->kind == TY_LIGHT_PART_PARALLEL) return *ray;
    const float point[3] = {ordinate->position.x, ordinate->position.y, ordinate->position.z};
    const double half = 0.5 * (double)frame->step.z * frame->size[2];
    column_ray from;
    double square = 0;
    for (int a = 0; a < 3; ++a) {
        from.origin[a] = (double)point[a];
        from.way[a] = ray->origin[a] + half * ray->way[a] - (double)point[a];
        square += from.way[a] * from.way[a];
    }
    for (int a = 0; a < 3; ++a) from.way[a] /= sqrt(square);
    from.start = half - sqrt(square);
    return from;
}

/* ---- surfaces ---- */

/* How far upstream of the grid rays of parallel light begin: before all surfaces. */
static double reach_back(const ty_scene* scene, const ty_grid_box* box) {
    double outside[2][3], square = 0;
    ty_scene_surface_extent(scene, outside[0], outside[1]);
    for (int a = 0; a < 3; ++a)
        square += pow(fmax(box->upper[a], outside[1][a]) - fmin(box->lower[a], outside[0][a]), 2);
    return 2 * sqrt(square);
}

/* Off the surface that a lamp may be a point of, m. */
static double lift_of(const ty_grid_box* box) {
    double least = INFINITY;
    for (int a = 0; a < 3; ++a) least = fmin(least, box->upper[a] - box->lower[a]);
    return 1e-4 * least;
}

/* The ray on which a part of a column is shaded. */
static column_ray shadow_ray(const ty_scene* scene, const ty_grid_box* box, const ty_pop_light* light, int32_t column,
                             int32_t number) {
    const ty_light_part* ordinate = &light->ordinate;
    const double u = 0.25 + 0.5 * (number % 2), v = number < 2 ? 0.25 : 0.75;
    const column_ray along = ray_of(&light->frame, column, u, v);
    column_ray ray = lit_ray(&light->frame, ordinate, &along);
    if (ordinate->kind == TY_LIGHT_PART_PARALLEL) {
        ray.start = -reach_back(scene, box);
        for (int a = 0; a < 3; ++a) ray.origin[a] += ray.start * ray.way[a];
    } else if (ordinate->profile == TY_LIGHT_PART_COSINE) {
        const float normal[3] = {ordinate->direction.x, ordinate->direction.y, ordinate->direction.z};
        for (int a = 0; a < 3; ++a) ray.origin[a] += lift_of(box) * (double)normal[a];
    }
    return ray;
}

/* One ray of each of some columns, a packet at most. */
static void trace(const ty_scene* scene, const ty_grid_box* box, const ty_pop_light* light, const int32_t columns[2],
                  int32_t number, float* hit) {
    const int32_t count = columns[1] - columns[0];
    ty_ray rays[TY_PACKET];
    ty_hit hits[TY_PACKET];
    double start[TY_PACKET];
    for (int32_t i = 0; i < count; ++i) {
        const column_ray ray = shadow_ray(scene, box, light, columns[0] + i, number);
        for (int a = 0; a < 3; ++a) {
            rays[i].origin[a] = (float)ray.origin[a];
            rays[i].direction[a] = (float)ray.way[a];
        }
        rays[i].far = TY_FLOAT_MAX;
        start[i] = ray.start;
    }
    ty_accel_intersect_packet(ty_scene_get_view(scene)->mesh, rays, count, hits);
    for (int32_t i = 0; i < count; ++i)
        hit[i] = hits[i].surface < 0 ? TY_FLOAT_MAX : (float)((double)hits[i].distance + start[i]);
}

static void trace_all(const ty_scene* scene, const ty_grid_box* box, const ty_pop_light* light,
                      ty_pop_columns* columns) {
    const int32_t end = columns->first + columns->count;
    for (int32_t ray = 0; ray < TY_POP_RAYS; ++ray)
        for (int32_t first = columns->first; first < end; first += TY_PACKET) {
            const int32_t range[2] = {first, end - first < TY_PACKET ? end : first + TY_PACKET};
            trace(scene, box, light, range, ray, columns->hit[ray] + (first - columns->first));
        }
}

/* ---- all of it ---- */

float ty_pop_slab_begin(const ty_pop_frame* frame, int32_t k) {
    if (frame->kind == TY_LIGHT_PART_PARALLEL) return (float)k * frame->step.z;
    return k < 0 ? 0 : ty_pop_radius(frame, (float)k);
}

static int32_t ringed_cell(const ty_pop_frame* frame, int32_t column) {
    const int32_t n = frame->size[0], ring = ty_pop_ring(frame);
    return column % n + ring + (n + 2 * ring) * (column / n + ring);
}

void ty_pop_columns_begin(const ty_scene* scene, const ty_grid_medium* medium, const ty_pop_light* light, int32_t first,
                          ty_pop_columns* columns) {
    const ty_pop_frame* frame = &light->frame;
    const ty_light_part* ordinate = &light->ordinate;
    const ty_scene_view* view = scene != NULL ? ty_scene_get_view(scene) : NULL;
    const int32_t all = frame->size[0] * frame->size[1], whole = TY_POP_BLOCK / frame->size[0] * frame->size[0];
    columns->frame = frame;
    columns->first = first;
    columns->count = all - first < whole ? all - first : whole;
    columns->shaded = view != NULL && view->mesh != NULL && ordinate->shadowed != 0;
    columns->spreads = frame->kind == TY_LIGHT_PART_PARALLEL && ordinate->kind == TY_LIGHT_PART_RADIAL;
    const float lamp[3] = {ordinate->position.x, ordinate->position.y, ordinate->position.z};
    for (int a = 0; a < 3; ++a) columns->lamp[a] = (float)((double)lamp[a] - medium->box.lower[a]);
    for (int32_t i = 0; i < columns->count; ++i) {
        const column_ray ray = ray_of(frame, first + i, 0.5, 0.5);
        cut(&medium->box, &ray, &columns->enter[i], &columns->leave[i]);
        columns->cell[i] = ringed_cell(frame, first + i);
        for (int a = 0; a < 3; ++a) {
            columns->base[a][i] = (float)(ray.origin[a] - medium->box.lower[a]);
            columns->way[a][i] = (float)ray.way[a];
        }
        if (view == NULL) continue;
        const column_ray lit = lit_ray(frame, ordinate, &ray);
        columns->across[i] = across_of(columns->frame, first + i);
        columns->profile[i] = profile_of(view, ordinate, &lit);
    }
    if (columns->shaded != 0) trace_all(scene, &medium->box, light, columns);
}

void ty_pop_fill_ring(const ty_pop_light* light) {
    const ty_pop_frame* frame = &light->frame;
    const int32_t n = frame->size[0], row = n + 2;
    const size_t floats = (size_t)light->floats;
    if (ty_pop_ring(frame) == 0) return;
    for (int32_t k = 0; k < frame->size[2]; ++k) {
        float* slice = light->seen + floats * (size_t)row * (size_t)row * (size_t)k;
        for (int32_t j = -1; j <= n; ++j)
            for (int32_t i = -1; i <= n; i += j < 0 || j >= n ? 1 : n + 1) {
                int32_t from_i = i, from_j = j;
                ty_octahedral_wrap(n, &from_i, &from_j);
                memcpy(slice + floats * (size_t)(i + 1 + row * (j + 1)),
                       slice + floats * (size_t)(from_i + 1 + row * (from_j + 1)), floats * sizeof *slice);
            }
    }
}
