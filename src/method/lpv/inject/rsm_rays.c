/* Rays from lights through the texels of their maps. */
#include "method/lpv/inject/rsm_rays.h"

#include "direct/shadow/grid_depth.h"

/* ---- light and medium ---- */

/* Cells compared per block. */
enum { EVEN_BLOCK = 4096 };

static ty_vec vec_of(const double v[3]) {
    return ty_vec_make((float)v[0], (float)v[1], (float)v[2]);
}

static ty_rsm_face face_of(const ty_lpv_light* light, int32_t face) {
    const ty_rsm* rsm = light->rsm;
    const bool parallel = light->light->kind == TY_KIND_DIRECTIONAL;
    const ty_vec right = vec_of(rsm->right[face]), up = vec_of(rsm->up[face]);
    return (ty_rsm_face){.side = rsm->side,
                         .parallel = parallel,
                         .spot = light->light->kind == TY_KIND_SPOT,
                         .origin = parallel ? vec_of(rsm->origin) : light->light->position,
                         .forward = vec_of(rsm->forward[face]),
                         .right = right,
                         .up = up,
                         .axis = light->light->direction,
                         .cos_outer = light->light->cos_outer,
                         .cos_inner = light->light->cos_inner,
                         .area = 4.0f * sqrtf(ty_dot(right, right) * ty_dot(up, up)) /
                                 ((float)rsm->side * (float)rsm->side)};
}

static bool is_homogeneous(const float* plane, size_t count) {
    const float first = plane[0], tolerance = 1e-5f * fabsf(first);
    for (size_t from = 0; from < count; from += EVEN_BLOCK) {
        const size_t end = count - from < EVEN_BLOCK ? count : from + EVEN_BLOCK;
        int32_t others = 0;
#pragma omp simd reduction(+ : others)
        for (size_t i = from; i < end; ++i) others += !(fabsf(plane[i] - first) <= tolerance);
        if (others > 0) return false;
    }
    return true;
}

static ty_rsm_ray_medium medium_of(const ty_grid_medium* medium) {
    ty_rsm_ray_medium out = {.medium = medium, .homogeneous = true};
    if (medium == NULL) return out;
    for (int32_t c = 0; c < medium->planes && out.homogeneous; ++c)
        out.homogeneous = is_homogeneous(medium->extinction[c], medium->cells) &&
                          is_homogeneous(medium->scattering[c], medium->cells);
    for (int a = 0; a < 3; ++a) {
        out.lower[a] = (float)medium->box.lower[a];
        out.upper[a] = (float)medium->box.upper[a];
    }
    return out;
}

ty_rsm_ray_view ty_rsm_ray_view_of(const ty_lpv_light* light, const ty_grid_medium* medium) {
    ty_rsm_ray_view out = {.light = light, .medium = medium_of(medium), .kernels = TY_BEST_KERNELS(ty_rsm_ray_kernels)};
    for (int32_t face = 0; face < light->rsm->faces; ++face) out.faces[face] = face_of(light, face);
    return out;
}

/* ---- rays ---- */

int64_t ty_rsm_row_count(const ty_lpv_light* light) {
    return (int64_t)light->rsm->faces * light->rsm->side;
}

void ty_rsm_rays_at(const ty_rsm_ray_view* view, int64_t row, int32_t x, ty_rsm_rays* out) {
    const ty_rsm* rsm = view->light->rsm;
    out->count = rsm->side - x < TY_RSM_RAYS ? rsm->side - x : TY_RSM_RAYS;
    out->first = (size_t)row * (size_t)rsm->side + (size_t)x;
    memcpy(out->length, rsm->depth + out->first, (size_t)out->count * sizeof *out->length);
    view->kernels->rays(&view->faces[row / rsm->side], x, (int32_t)(row % rsm->side), out);
    for (int32_t i = 0; i < out->count; ++i)
        for (size_t a = 0; a < 3; ++a)
            out->normal[a][i] =
                rsm->normal != NULL ? rsm->normal[3 * (out->first + (size_t)i) + a] : -out->direction[a][i];
    if (view->medium.medium != NULL) {
        view->kernels->clip(out, view->medium.lower, view->medium.upper, out->enter, out->leave);
        return;
    }
    memset(out->enter, 0, sizeof out->enter);
    memset(out->leave, 0, sizeof out->leave);
}

void ty_rsm_ray_optical_depth(const ty_rsm_ray_medium* medium, const ty_rsm_rays* rays, int32_t i, float depth[3]) {
    for (int c = 0; c < 3; ++c) depth[c] = 0.0f;
    if (medium->medium == NULL) return;
    if (medium->homogeneous)
        for (int c = 0; c < 3; ++c) depth[c] = medium->medium->extinction[c][0] * (rays->leave[i] - rays->enter[i]);
    else
        ty_grid_depth(medium->medium, NULL, ty_rsm_ray_vec(rays->origin, i), ty_rsm_ray_vec(rays->direction, i),
                      rays->length[i], depth);
}

/* ---- heterogeneous media ---- */

ty_medium_walk ty_medium_walk_begin(const ty_grid_medium* medium, const ty_rsm_rays* rays, int32_t i) {
    ty_medium_walk walk = {.medium = medium, .cells = {.end = (double)rays->length[i]}};
    double origin[3], direction[3];
    for (int a = 0; a < 3; ++a) {
        origin[a] = (double)rays->origin[a][i];
        direction[a] = (double)rays->direction[a][i];
    }
    walk.inside = ty_cell_ray_clip(&medium->box, origin, direction, &walk.cells);
    if (walk.inside) ty_cell_ray_begin(medium, origin, direction, &walk.cells);
    return walk;
}

bool ty_medium_walk_step(ty_medium_walk* walk, double to, ty_medium_segment* out) {
    const double begin = walk->at;
    if (!(begin < to)) return false;
    *out = (ty_medium_segment){.begin = (float)begin};
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
