/* Rays from lights. */
#include "method/lpv/lamp_ray.h"

#include "direct/grid_depth.h"

int64_t ty_lamp_rows(const ty_lpv_lamp* lamp) {
    return (int64_t)lamp->map->faces * lamp->map->side;
}

bool ty_lamp_ray_at(const ty_lpv_lamp* lamp, int64_t row, int32_t x, ty_lamp_ray* out) {
    const ty_light_map* map = lamp->map;
    const int32_t face = (int32_t)(row / map->side), y = (int32_t)(row % map->side);
    ty_vec along;
    ty_light_map_ray(map, lamp->light, face, (float)x + 0.5f, (float)y + 0.5f, &out->origin, &along);
    const float stretch = sqrtf(ty_dot(along, along));
    out->direction = ty_scale(along, 1.0f / stretch);
    float share = 1.0f;
    if (lamp->light->kind == TY_KIND_SPOT)
        share = ty_spot_falloff(lamp->light, ty_dot(out->direction, lamp->light->direction));
    if (!(share > 0.0f)) return false;
    share *= ty_light_map_share(map, lamp->light, face, x, y);
    out->texel = (size_t)row * (size_t)map->side + (size_t)x;
    out->length = map->depth[out->texel] * stretch;
    for (int c = 0; c < 3; ++c) out->power[c] = share * lamp->light->color[c];
    return true;
}

/* ---- media ---- */

static bool is_even(const float* plane, size_t count) {
    for (size_t i = 1; i < count; ++i)
        if (!(fabsf(plane[i] - plane[0]) <= 1e-5f * fabsf(plane[0]))) return false;
    return true;
}

ty_lamp_medium ty_lamp_medium_of(const ty_grid_medium* medium) {
    ty_lamp_medium out = {.medium = medium, .even = true};
    for (int32_t c = 0; medium != NULL && c < medium->planes && out.even; ++c)
        out.even = is_even(medium->extinction[c], medium->cells) && is_even(medium->scattering[c], medium->cells);
    return out;
}

/* The part of a ray in the medium's box. */
static bool clip(const ty_lamp_medium* medium, const ty_lamp_ray* ray, float far, double origin[3], double way[3],
                 ty_cell_ray* cells) {
    const ty_vec o = ray->origin, d = ray->direction;
    const double from[3] = {(double)o.x, (double)o.y, (double)o.z}, along[3] = {(double)d.x, (double)d.y, (double)d.z};
    memcpy(origin, from, sizeof from);
    memcpy(way, along, sizeof along);
    *cells = (ty_cell_ray){.end = (double)far};
    return medium->medium != NULL && ty_cell_ray_clip(&medium->medium->box, origin, way, cells);
}

void ty_lamp_depth(const ty_lamp_medium* medium, const ty_lamp_ray* ray, float far, float depth[3]) {
    double origin[3], way[3];
    ty_cell_ray cells;
    for (int c = 0; c < 3; ++c) depth[c] = 0.0f;
    if (medium->medium == NULL) return;
    if (!medium->even) {
        ty_grid_depth(medium->medium, NULL, ray->origin, ray->direction, far, depth);
        return;
    }
    if (!clip(medium, ray, far, origin, way, &cells)) return;
    for (int c = 0; c < 3; ++c) depth[c] = medium->medium->extinction[c][0] * (float)(cells.end - cells.at);
}

ty_lamp_walk ty_lamp_walk_begin(const ty_lamp_medium* medium, const ty_lamp_ray* ray, float far) {
    double origin[3], way[3];
    ty_lamp_walk walk = {.medium = medium};
    walk.inside = clip(medium, ray, far, origin, way, &walk.cells);
    if (walk.inside && !medium->even) ty_cell_ray_begin(medium->medium, origin, way, &walk.cells);
    return walk;
}

bool ty_lamp_walk_step(ty_lamp_walk* walk, double to, ty_lamp_stretch* out) {
    if (!(walk->at < to)) return false;
    *out = (ty_lamp_stretch){.begin = (float)walk->at};
    const double begin = walk->at;
    if (!walk->inside || begin < walk->cells.at) {
        walk->at = walk->inside ? ty_cell_min(to, walk->cells.at) : to;
    } else {
        const bool even = walk->medium->even;
        const ty_grid_medium* medium = walk->medium->medium;
        const size_t index = even ? 0 : ty_cell_ray_index(medium, &walk->cells);
        const double end = even ? walk->cells.end : ty_cell_ray_leave(&walk->cells);
        walk->at = ty_cell_max(begin, ty_cell_min(to, end));
        for (int c = 0; c < 3; ++c) {
            out->extinction[c] = medium->extinction[c][index];
            out->scattering[c] = medium->scattering[c][index];
        }
        if (walk->at >= end) walk->inside = !even && ty_cell_ray_advance(medium, &walk->cells);
    }
    out->length = (float)(walk->at - begin);
    return true;
}
