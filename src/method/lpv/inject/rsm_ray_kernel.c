/* Rays from lights; see rsm_ray_kernel.h. */
#include "method/lpv/inject/rsm_ray_kernel.h"

/* ---- rays ---- */

static void parallel_rays(const ty_rsm_face* face, float s0, float ds, float t, ty_rsm_rays* r) {
    const ty_vec base = ty_mad(face->origin, face->up, t);
    for (int32_t i = 0; i < r->count; ++i) {
        const float s = s0 + ds * (float)i;
        r->origin[0][i] = base.x + s * face->right.x;
        r->origin[1][i] = base.y + s * face->right.y;
        r->origin[2][i] = base.z + s * face->right.z;
        r->direction[0][i] = face->forward.x;
        r->direction[1][i] = face->forward.y;
        r->direction[2][i] = face->forward.z;
        r->measure[i] = face->area;
    }
}

/* Mean solid angle per area, as in ty_rsm_texel_measure. */
TY_FN float mean_density(float wide2, float s, float ds, float before, float after) {
    const float off = 0.288675135f * ds;
    const float a = wide2 * (s - off) * (s - off), b = wide2 * (s + off) * (s + off);
    const float q[4] = {before + a, before + b, after + a, after + b};
    return 0.25f * (1.0f / (q[0] * sqrtf(q[0])) + 1.0f / (q[1] * sqrtf(q[1])) + 1.0f / (q[2] * sqrtf(q[2])) +
                    1.0f / (q[3] * sqrtf(q[3])));
}

static void central_rays(const ty_rsm_face* face, float s0, float ds, float t, ty_rsm_rays* r) {
    const ty_vec base = ty_mad(face->forward, face->up, t), right = face->right, from = face->origin;
    const float wide2 = ty_dot(right, right), high2 = ty_dot(face->up, face->up), off = 0.288675135f * ds;
    const float before = 1.0f + high2 * (t - off) * (t - off), after = 1.0f + high2 * (t + off) * (t + off);
    const float area = face->area;
#pragma omp simd
    for (int32_t i = 0; i < r->count; ++i) {
        const float s = s0 + ds * (float)i;
        const float x = base.x + s * right.x, y = base.y + s * right.y, z = base.z + s * right.z;
        const float length = sqrtf(x * x + y * y + z * z), inverse = 1.0f / length;
        r->origin[0][i] = from.x;
        r->origin[1][i] = from.y;
        r->origin[2][i] = from.z;
        r->direction[0][i] = x * inverse;
        r->direction[1][i] = y * inverse;
        r->direction[2][i] = z * inverse;
        r->length[i] *= length;
        r->measure[i] = area * mean_density(wide2, s, ds, before, after);
    }
}

/* Spot falloff, as in ty_spot_falloff. */
static void fade(const ty_rsm_face* face, ty_rsm_rays* r) {
    const float outer = face->cos_outer, range = face->cos_inner - face->cos_outer, per_range = 1.0f / range;
    const ty_vec axis = face->axis;
#pragma omp simd
    for (int32_t i = 0; i < r->count; ++i) {
        const float above =
            r->direction[0][i] * axis.x + r->direction[1][i] * axis.y + r->direction[2][i] * axis.z - outer;
        const float x = above >= range ? 1.0f : above * per_range;
        r->measure[i] *= above > 0.0f ? x * x * (3.0f - 2.0f * x) : 0.0f;
    }
}

static void rays(const ty_rsm_face* face, int32_t x, int32_t y, ty_rsm_rays* r) {
    const float ds = 2.0f / (float)face->side;
    const float s0 = ((float)x + 0.5f) * ds - 1.0f, t = ((float)y + 0.5f) * ds - 1.0f;
    if (face->parallel != 0)
        parallel_rays(face, s0, ds, t, r);
    else
        central_rays(face, s0, ds, t, r);
    if (face->spot != 0) fade(face, r);
}

static void clip(const ty_rsm_rays* r, const float lower[3], const float upper[3], float* begin, float* end) {
    for (int32_t i = 0; i < r->count; ++i) {
        begin[i] = 0.0f;
        end[i] = r->length[i];
    }
    for (int a = 0; a < 3; ++a) {
        const float low = lower[a], high = upper[a], *origin = r->origin[a], *direction = r->direction[a];
#pragma omp simd
        for (int32_t i = 0; i < r->count; ++i) {
            const float per_direction = 1.0f / (fabsf(direction[i]) > 1e-12f ? direction[i] : 1e-12f);
            const float at_low = (low - origin[i]) * per_direction, at_high = (high - origin[i]) * per_direction;
            begin[i] = ty_maxf(begin[i], ty_minf(at_low, at_high));
            end[i] = ty_minf(end[i], ty_maxf(at_low, at_high));
        }
    }
    for (int32_t i = 0; i < r->count; ++i) end[i] = ty_maxf(begin[i], end[i]);
}

/* ---- scattering on segments ---- */

/* A cell index along an axis, clamped to the lattice. */
TY_FN int32_t inside_of(float place, int32_t size) {
    return (int32_t)ty_clampf(place, 0.0f, (float)(size - 1));
}

TY_FN int32_t is_inside(float place, int32_t size) {
    return (int32_t)(place >= 0.0f) & (int32_t)(place < (float)size);
}

/* The cells of points on rays. Points are moved away from the surface that the ray ends on, so that the center of the
 * cell is on the lit side, unless that leaves the lattice. */
static void find_cells(const ty_ray_segments* parts, const ty_rsm_rays* r, const float* along, int32_t* cells) {
    const ty_ray_segments p = *parts;
    const float per_cell = 1.0f / p.cell;
    const int32_t nx = p.size[0], ny = p.size[1], nz = p.size[2];
#pragma omp simd
    for (int32_t i = 0; i < r->count; ++i) {
        const float at = along[i], before = r->length[i] - at;
        const float u = r->normal[0][i], v = r->normal[1][i], w = r->normal[2][i];
        const float facing = -(r->direction[0][i] * u + r->direction[1][i] * v + r->direction[2][i] * w);
        const float clearance = 0.5f * p.cell * (fabsf(u) + fabsf(v) + fabsf(w));
        const float missing = before < p.near_end ? ty_maxf(0.0f, clearance - before * facing) * per_cell : 0.0f;
        const float x = (r->origin[0][i] + at * r->direction[0][i] - p.lower[0]) * per_cell;
        const float y = (r->origin[1][i] + at * r->direction[1][i] - p.lower[1]) * per_cell;
        const float z = (r->origin[2][i] + at * r->direction[2][i] - p.lower[2]) * per_cell;
        const float to_x = x + missing * u, to_y = y + missing * v, to_z = z + missing * w;
        const int32_t stays = is_inside(to_x, nx) & is_inside(to_y, ny) & is_inside(to_z, nz);
        const int32_t i_x = inside_of(stays != 0 ? to_x : x, nx), i_y = inside_of(stays != 0 ? to_y : y, ny);
        cells[i] = i_x + nx * (i_y + ny * inside_of(stays != 0 ? to_z : z, nz));
    }
}

static void part(const ty_ray_segments* given, const ty_rsm_rays* r, int32_t part, ty_segment_splats* out) {
    const ty_ray_segments p = *given;
    const float index = (float)part;
    float from[TY_RSM_RAYS], length[TY_RSM_RAYS], extinction = 0.0f;
    for (int32_t c = 0; c < p.channels; ++c) extinction += p.extinction[c] / (float)p.channels;
#pragma omp simd
    for (int32_t i = 0; i < r->count; ++i) {
        const float all = r->end[i] - r->begin[i];
        const float count = ty_minf(p.samples, (float)(1 + (int32_t)ty_minf(all * p.per_metre, 1e6f)));
        const float each = all / count, begin = r->begin[i] + index * each;
        const float enter = ty_clampf(begin, r->enter[i], r->leave[i]);
        const float leave = ty_clampf(begin + each, r->enter[i], r->leave[i]);
        from[i] = enter;
        length[i] = index < count ? leave - enter : 0.0f;
    }
    for (int32_t c = 0; c < p.channels; ++c) {
        const float sigma = p.extinction[c], scattering = p.scattering[c];
        float* weight = out->weight[c];
#pragma omp simd
        for (int32_t i = 0; i < r->count; ++i) {
            const float across = sigma * length[i], scattered = scattering * length[i];
            weight[i] = r->measure[i] * ty_attenuation(sigma * (from[i] - r->enter[i])) * scattered *
                        ty_mean_attenuation(across, ty_attenuation(across));
        }
    }
#pragma omp simd
    for (int32_t i = 0; i < r->count; ++i) from[i] += ty_scattering_distance(r->jitter[i], length[i], extinction);
    find_cells(&p, r, from, out->cell);
    for (int32_t i = 0; i < r->count; ++i)
        if (!(length[i] > 0.0f && r->measure[i] > 0.0f)) out->cell[i] = -1;
}

const ty_rsm_ray_kernels TY_KERNEL_NAME(ty_rsm_ray_kernels) = {.rays = rays, .clip = clip, .part = part};
