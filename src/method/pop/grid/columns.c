/* Columns of a grid: rays, entry and exit distances, light profiles and shadow rays. */
#include "method/pop/grid/columns.h"

#include "scene/scene.h"

typedef struct column_ray {
    double origin[3], direction[3]; /* m; unit */
    double start;                   /* distance of the origin along the column, m */
} column_ray;

/* Ray along a column. u, v: position in its cross section, 0 to 1, 0.5 at the center. */
static column_ray ray_of(const ty_pop_grid* grid, int32_t column, double u, double v) {
    const double i = column % grid->size[0] + u, j = column / grid->size[0] + v;
    const float origin[3] = {grid->origin.x, grid->origin.y, grid->origin.z};
    column_ray ray = {.start = 0};
    ty_vec direction = grid->axis[2];
    if (grid->kind == TY_DISCRETE_POINT)
        direction = ty_octahedral_direction((float)(2 * i / grid->size[0] - 1), (float)(2 * j / grid->size[1] - 1));
    const float along[3] = {direction.x, direction.y, direction.z};
    const float first[3] = {grid->axis[0].x, grid->axis[0].y, grid->axis[0].z};
    const float second[3] = {grid->axis[1].x, grid->axis[1].y, grid->axis[1].z};
    for (int a = 0; a < 3; ++a) {
        ray.origin[a] = (double)origin[a];
        ray.direction[a] = (double)along[a];
        if (grid->kind == TY_DISCRETE_DIRECTIONAL)
            ray.origin[a] += i * (double)grid->step.x * (double)first[a] + j * (double)grid->step.y * (double)second[a];
    }
    return ray;
}

/* Distances at which a ray enters and leaves the medium's box. */
static void clip_to_box(const ty_grid_box* box, const column_ray* ray, float* enter, float* leave) {
    double range[2] = {0, INFINITY};
    for (int a = 0; a < 3; ++a) {
        if (fabs(ray->direction[a]) < 1e-12) {
            if (ray->origin[a] < box->lower[a] || ray->origin[a] > box->upper[a]) range[1] = 0;
            continue;
        }
        const double t0 = (box->lower[a] - ray->origin[a]) / ray->direction[a];
        const double t1 = (box->upper[a] - ray->origin[a]) / ray->direction[a];
        range[0] = fmax(range[0], fmin(t0, t1));
        range[1] = fmin(range[1], fmax(t0, t1));
    }
    const bool meets = range[0] < range[1];
    *enter = meets ? (float)range[0] : 0;
    *leave = meets ? (float)range[1] : 0;
}

/* ---- intensity ---- */

static float across_of(const ty_pop_grid* grid, int32_t column) {
    if (grid->kind == TY_DISCRETE_DIRECTIONAL) return grid->step.x * grid->step.y;
    return ty_octahedral_angle(ty_pop_direction(grid, column % grid->size[0], column / grid->size[0]), grid->size[0]);
}

static float profile_of(const ty_scene_view* view, const ty_discrete_light* ordinate, const column_ray* ray) {
    if (ordinate->kind == TY_DISCRETE_DIRECTIONAL) return 1;
    const ty_vec direction = ty_vec_make((float)ray->direction[0], (float)ray->direction[1], (float)ray->direction[2]);
    const float mu = ty_dot(direction, ordinate->direction);
    return ty_light_profile_at(ordinate->profile, &view->lights.lights[ordinate->light], mu);
}

/* Ray of the incident light. For a point light in a parallel grid it runs to the center of the column. */
static column_ray incident_ray(const ty_pop_grid* grid, const ty_discrete_light* ordinate, const column_ray* ray) {
    if (grid->kind == TY_DISCRETE_POINT || ordinate->kind == TY_DISCRETE_DIRECTIONAL) return *ray;
    const float point[3] = {ordinate->position.x, ordinate->position.y, ordinate->position.z};
    const double half = 0.5 * (double)grid->step.z * grid->size[2];
    column_ray from;
    double square = 0;
    for (int a = 0; a < 3; ++a) {
        from.origin[a] = (double)point[a];
        from.direction[a] = ray->origin[a] + half * ray->direction[a] - (double)point[a];
        square += from.direction[a] * from.direction[a];
    }
    for (int a = 0; a < 3; ++a) from.direction[a] /= sqrt(square);
    from.start = half - sqrt(square);
    return from;
}

/* ---- occlusion by surfaces ---- */

/* Upstream offset of shadow rays of parallel light, m: beyond all surfaces. */
static double upstream_offset(const ty_scene* scene, const ty_grid_box* box) {
    double outside[2][3], square = 0;
    ty_scene_surface_extent(scene, outside[0], outside[1]);
    for (int a = 0; a < 3; ++a)
        square += pow(fmax(box->upper[a], outside[1][a]) - fmin(box->lower[a], outside[0][a]), 2);
    return 2 * sqrt(square);
}

/* Offset from the surface on which a point light may lie, m. */
static double surface_offset(const ty_grid_box* box) {
    double min_edge = INFINITY;
    for (int a = 0; a < 3; ++a) min_edge = fmin(min_edge, box->upper[a] - box->lower[a]);
    return 1e-4 * min_edge;
}

/* Shadow ray of one sub-area of a column. */
static column_ray shadow_ray(const ty_scene* scene, const ty_grid_box* box, const ty_pop_light* light, int32_t column,
                             int32_t number) {
    const ty_discrete_light* ordinate = &light->ordinate;
    const double u = 0.25 + 0.5 * (number % 2), v = number < 2 ? 0.25 : 0.75;
    const column_ray along = ray_of(&light->grid, column, u, v);
    column_ray ray = incident_ray(&light->grid, ordinate, &along);
    if (ordinate->kind == TY_DISCRETE_DIRECTIONAL) {
        ray.start = -upstream_offset(scene, box);
        for (int a = 0; a < 3; ++a) ray.origin[a] += ray.start * ray.direction[a];
    } else if (ordinate->profile == TY_PROFILE_COSINE) {
        const float normal[3] = {ordinate->direction.x, ordinate->direction.y, ordinate->direction.z};
        for (int a = 0; a < 3; ++a) ray.origin[a] += surface_offset(box) * (double)normal[a];
    }
    return ray;
}

/* Traces one shadow ray for each of some columns, one packet at most. */
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
            rays[i].direction[a] = (float)ray.direction[a];
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

/* ---- setup of a block ---- */

float ty_pop_slab_begin(const ty_pop_grid* grid, int32_t k) {
    if (grid->kind == TY_DISCRETE_DIRECTIONAL) return (float)k * grid->step.z;
    return k < 0 ? 0 : ty_pop_radius(grid, (float)k);
}

static int32_t cell_with_ghosts(const ty_pop_grid* grid, int32_t column) {
    const int32_t n = grid->size[0], ghosts = ty_pop_ghost_width(grid);
    return column % n + ghosts + (n + 2 * ghosts) * (column / n + ghosts);
}

void ty_pop_columns_begin(const ty_scene* scene, const ty_grid_medium* medium, const ty_pop_light* light, int32_t first,
                          ty_pop_columns* columns) {
    const ty_pop_grid* grid = &light->grid;
    const ty_discrete_light* ordinate = &light->ordinate;
    const ty_scene_view* view = scene != NULL ? ty_scene_get_view(scene) : NULL;
    const int32_t all = grid->size[0] * grid->size[1], max_count = TY_POP_BLOCK / grid->size[0] * grid->size[0];
    columns->grid = grid;
    columns->first = first;
    columns->count = all - first < max_count ? all - first : max_count;
    columns->shaded = view != NULL && view->mesh != NULL && ordinate->shadowed != 0;
    columns->inverse_square = grid->kind == TY_DISCRETE_DIRECTIONAL && ordinate->kind == TY_DISCRETE_POINT;
    const float light_position[3] = {ordinate->position.x, ordinate->position.y, ordinate->position.z};
    for (int a = 0; a < 3; ++a) columns->light_position[a] = (float)((double)light_position[a] - medium->box.lower[a]);
    for (int32_t i = 0; i < columns->count; ++i) {
        const column_ray ray = ray_of(grid, first + i, 0.5, 0.5);
        clip_to_box(&medium->box, &ray, &columns->enter[i], &columns->leave[i]);
        columns->cell[i] = cell_with_ghosts(grid, first + i);
        for (int a = 0; a < 3; ++a) {
            columns->base[a][i] = (float)(ray.origin[a] - medium->box.lower[a]);
            columns->direction[a][i] = (float)ray.direction[a];
        }
        if (view == NULL) continue;
        const column_ray incident = incident_ray(grid, ordinate, &ray);
        columns->across[i] = across_of(columns->grid, first + i);
        columns->profile[i] = profile_of(view, ordinate, &incident);
    }
    if (columns->shaded != 0) trace_all(scene, &medium->box, light, columns);
}

void ty_pop_fill_ghost_cells(const ty_pop_light* light) {
    const ty_pop_grid* grid = &light->grid;
    const int32_t n = grid->size[0], row = n + 2;
    const size_t floats = (size_t)light->floats;
    if (ty_pop_ghost_width(grid) == 0) return;
    for (int32_t k = 0; k < grid->size[2]; ++k) {
        float* slice = light->accumulated + floats * (size_t)row * (size_t)row * (size_t)k;
        for (int32_t j = -1; j <= n; ++j)
            for (int32_t i = -1; i <= n; i += j < 0 || j >= n ? 1 : n + 1) {
                int32_t from_i = i, from_j = j;
                ty_octahedral_wrap(n, &from_i, &from_j);
                memcpy(slice + floats * (size_t)(i + 1 + row * (j + 1)),
                       slice + floats * (size_t)(from_i + 1 + row * (from_j + 1)), floats * sizeof *slice);
            }
    }
}
