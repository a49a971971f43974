/* Rays from lights. */
#include "method/lpv/lamp_ray.h"

#include "direct/shadow/grid_depth.h"

const ty_lamp_kernels* ty_lamp_kernels_best(void) {
#if TY_ISA_X86
    static const ty_lamp_kernels* const kernels[TY_ISA_COUNT] = {&ty_lamp_kernels_v1, &ty_lamp_kernels_v3,
                                                                 &ty_lamp_kernels_v4};
    return kernels[ty_best_isa()];
#else
    return &ty_lamp_kernels_v1;
#endif
}

/* ---- the light and the medium ---- */

/* Cells that are compared at a time. */
enum { EVEN_BLOCK = 4096 };

static ty_vec vec_of(const double v[3]) {
    return ty_vec_make((float)v[0], (float)v[1], (float)v[2]);
}

static ty_lamp_face face_of(const ty_lpv_lamp* lamp, int32_t face) {
    const ty_light_map* map = lamp->map;
    const bool parallel = lamp->light->kind == TY_KIND_DIRECTIONAL;
    const ty_vec right = vec_of(map->right[face]), up = vec_of(map->up[face]);
    return (ty_lamp_face){.side = map->side,
                          .parallel = parallel,
                          .spot = lamp->light->kind == TY_KIND_SPOT,
                          .origin = parallel ? vec_of(map->origin) : lamp->light->position,
                          .forward = vec_of(map->forward[face]),
                          .right = right,
                          .up = up,
                          .axis = lamp->light->direction,
                          .cos_outer = lamp->light->cos_outer,
                          .cos_inner = lamp->light->cos_inner,
                          .area = 4.0f * sqrtf(ty_dot(right, right) * ty_dot(up, up)) /
                                  ((float)map->side * (float)map->side)};
}

static bool is_even(const float* plane, size_t count) {
    const float first = plane[0], most = 1e-5f * fabsf(first);
    for (size_t from = 0; from < count; from += EVEN_BLOCK) {
        const size_t end = count - from < EVEN_BLOCK ? count : from + EVEN_BLOCK;
        int32_t others = 0;
#pragma omp simd reduction(+ : others)
        for (size_t i = from; i < end; ++i) others += !(fabsf(plane[i] - first) <= most);
        if (others > 0) return false;
    }
    return true;
}

static ty_lamp_medium medium_of(const ty_grid_medium* medium) {
    ty_lamp_medium out = {.medium = medium, .even = true};
    if (medium == NULL) return out;
    for (int32_t c = 0; c < medium->planes && out.even; ++c)
        out.even = is_even(medium->extinction[c], medium->cells) && is_even(medium->scattering[c], medium->cells);
    for (int a = 0; a < 3; ++a) {
        out.lower[a] = (float)medium->box.lower[a];
        out.upper[a] = (float)medium->box.upper[a];
    }
    return out;
}

ty_lamp_view ty_lamp_view_of(const ty_lpv_lamp* lamp, const ty_grid_medium* medium) {
    ty_lamp_view out = {.lamp = lamp, .medium = medium_of(medium), .kernels = ty_lamp_kernels_best()};
    for (int32_t face = 0; face < lamp->map->faces; ++face) out.faces[face] = face_of(lamp, face);
    return out;
}

/* ---- rays ---- */

int64_t ty_lamp_rows(const ty_lpv_lamp* lamp) {
    return (int64_t)lamp->map->faces * lamp->map->side;
}

void ty_lamp_rays_at(const ty_lamp_view* view, int64_t row, int32_t x, ty_ray_row* out) {
    const ty_light_map* map = view->lamp->map;
    out->count = map->side - x < TY_LAMP_RAYS ? map->side - x : TY_LAMP_RAYS;
    out->first = (size_t)row * (size_t)map->side + (size_t)x;
    memcpy(out->length, map->depth + out->first, (size_t)out->count * sizeof *out->length);
    view->kernels->rays(&view->faces[row / map->side], x, (int32_t)(row % map->side), out);
    for (int32_t i = 0; i < out->count; ++i)
        for (size_t a = 0; a < 3; ++a)
            out->normal[a][i] = map->normal != NULL ? map->normal[3 * (out->first + (size_t)i) + a] : -out->way[a][i];
    if (view->medium.medium != NULL) {
        view->kernels->clip(out, view->medium.lower, view->medium.upper, out->enter, out->leave);
        return;
    }
    memset(out->enter, 0, sizeof out->enter);
    memset(out->leave, 0, sizeof out->leave);
}

static ty_vec column(const float rows[3][TY_LAMP_RAYS], int32_t i) {
    return ty_vec_make(rows[0][i], rows[1][i], rows[2][i]);
}

void ty_cell_depth(const ty_lamp_medium* medium, const ty_ray_row* rays, int32_t i, float depth[3]) {
    for (int c = 0; c < 3; ++c) depth[c] = 0.0f;
    if (medium->medium == NULL) return;
    if (medium->even)
        for (int c = 0; c < 3; ++c) depth[c] = medium->medium->extinction[c][0] * (rays->leave[i] - rays->enter[i]);
    else
        ty_grid_depth(medium->medium, NULL, column(rays->origin, i), column(rays->way, i), rays->length[i], depth);
}

/* ---- media that are not the same everywhere ---- */

ty_lamp_walk ty_lamp_walk_begin(const ty_grid_medium* medium, const ty_ray_row* rays, int32_t i) {
    ty_lamp_walk walk = {.medium = medium, .cells = {.end = (double)rays->length[i]}};
    double origin[3], way[3];
    for (int a = 0; a < 3; ++a) {
        origin[a] = (double)rays->origin[a][i];
        way[a] = (double)rays->way[a][i];
    }
    walk.inside = ty_cell_ray_clip(&medium->box, origin, way, &walk.cells);
    if (walk.inside) ty_cell_ray_begin(medium, origin, way, &walk.cells);
    return walk;
}

bool ty_lamp_walk_step(ty_lamp_walk* walk, double to, ty_lamp_stretch* out) {
    const double begin = walk->at;
    if (!(begin < to)) return false;
    *out = (ty_lamp_stretch){.begin = (float)begin};
    if (!walk->inside || begin < walk->cells.at) {
        walk->at = walk->inside ? ty_cell_min(to, walk->cells.at) : to;
    } else {
        const size_t index = ty_cell_ray_index(walk->medium, &walk->cells);
        const double end = ty_cell_ray_leave(&walk->cells);
        walk->at = ty_cell_max(begin, ty_cell_min(to, end));
        for (int c = 0; c < 3; ++c) {
            out->extinction[c] = walk->medium->extinction[c][index];
            out->scattering[c] = walk->medium->scattering[c][index];
        }
        if (walk->at >= end) walk->inside = ty_cell_ray_advance(walk->medium, &walk->cells);
    }
    out->length = (float)(walk->at - begin);
    return true;
}
