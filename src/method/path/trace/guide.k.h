/* Guide of paths: light that is known roughly, on cells. Directions at vertices and distances along rays are sampled in
 * proportion to it, in one mixture with the sampling that does without (balance heuristic). The mean stays the same
 * for any guide, also a wrong one. docs/method/path.md, "Guided by dom". */
#ifndef TY_METHOD_PATH_TRACE_GUIDE_K_H
#define TY_METHOD_PATH_TRACE_GUIDE_K_H

#include "base/octahedral.k.h"
#include "base/random.k.h"
#include "base/voxel_dda.h"
#include "scene/media/phase.k.h"

/* Defined as 1 in the build of the kernel that takes a guide. */
#ifndef TY_PATH_GUIDED
#define TY_PATH_GUIDED 0
#endif

/* Bins of directions, a square of the octahedral map. */
enum { TY_GUIDE_SIDE = 8, TY_GUIDE_BINS = TY_GUIDE_SIDE * TY_GUIDE_SIDE };
/* Cells of light along an axis, at most. */
enum { TY_GUIDE_CELLS_MAX = 16 };

/* A box of equal cells, x fastest. */
typedef struct ty_guide_cells {
    float lower[3];     /* m */
    float per_metre[3]; /* cells per metre */
    int32_t size[3];
} ty_guide_cells;

/* Light in a cell, in luminance. */
typedef struct ty_guide_light {
    float fluence;             /* W m^-2 */
    ty_vec axis;               /* unit vector of the flux */
    float mean_cosine;         /* flux over fluence, 0..1: the mean cosine of the light about the axis */
    float sigma_t, sigma_s, g; /* of the media there: 1/m, 1/m, mean cosine */
    float emission;            /* of the media, W m^-3 sr^-1 */
} ty_guide_light;

typedef struct ty_guide {
    ty_guide_cells cells;
    TY_GLOBAL const ty_guide_light* light; /* all light in a cell, uncollided and collided */
    TY_GLOBAL const float* radiance; /* TY_GUIDE_BINS per cell: integral over a bin's solid angle of the radiance that
                                        comes from there, W m^-2, less what next-event estimation finds of it */
    float x[TY_GUIDE_BINS], y[TY_GUIDE_BINS], z[TY_GUIDE_BINS]; /* the bins' centers, unit vectors */
    float directions;                                           /* fraction of guided directions at the first vertex */
    float fall;                                                 /* decrease of that fraction with depth */
    float distances;    /* fraction of guided distances along the camera's rays */
    float window;       /* contribution of a path over that of its pixel, both as expected, below which roulette decides
                           over it; 0: none */
    float light_window; /* the same of the contribution of a light */
} ty_guide;

/* ---- cells ---- */

/* The cell at a coordinate along an axis, clamped to the box. */
TY_FN int32_t ty_guide_clamp_cell(const ty_guide_cells* cells, int32_t axis, float coordinate) {
    const float inside = ty_clampf(coordinate, 0.0f, (float)cells->size[axis] - 0.5f);
    return (int32_t)inside;
}

TY_FN float ty_guide_coordinate(const ty_guide_cells* cells, int32_t axis, float position) {
    return (position - cells->lower[axis]) * cells->per_metre[axis];
}

TY_FN bool ty_guide_is_within(const ty_guide_cells* cells, const float coordinate[3]) {
    for (int a = 0; a < 3; ++a)
        if (!(coordinate[a] >= 0.0f && coordinate[a] <= (float)cells->size[a])) return false;
    return true;
}

/* The index of the cell around a point displaced by `offset` cells along each axis; -1: the point is outside. */
TY_FN int64_t ty_guide_cell_at(const ty_guide_cells* cells, ty_vec at, const float offset[3]) {
    float coordinate[3];
    const float position[3] = {at.x, at.y, at.z};
    int64_t index = 0;
    for (int a = 0; a < 3; ++a) coordinate[a] = ty_guide_coordinate(cells, a, position[a]);
    if (!ty_guide_is_within(cells, coordinate)) return -1;
    for (int a = 2; a >= 0; --a)
        index = index * cells->size[a] + ty_guide_clamp_cell(cells, a, coordinate[a] + offset[a]);
    return index;
}

/* A cell around a point, at random, so that the mean over choices is the trilinear interpolation. */
TY_FN int64_t ty_guide_jittered_cell(const ty_guide_cells* cells, ty_vec at, ty_sampler* random) {
    const uint64_t bits = ty_rng_bits(random);
    float offset[3];
    for (int a = 0; a < 3; ++a) offset[a] = (float)(bits >> (21 * a) & 0x1fffff) * 0x1p-21f - 0.5f;
    return ty_guide_cell_at(cells, at, offset);
}

/* Cells along a ray. */
typedef struct ty_guide_walk {
    ty_voxel_dda dda;
    float from, to, leave; /* m along the ray: the present cell, the end of all */
    int32_t size[3];
} ty_guide_walk;

TY_FN int64_t ty_guide_walk_cell(const ty_guide_walk* walk) {
    const int32_t* cell = walk->dda.voxel;
    return cell[0] + (int64_t)walk->size[0] * (cell[1] + (int64_t)walk->size[1] * cell[2]);
}

/* Sets the end of the present cell. */
TY_FN void ty_guide_walk_set_end(ty_guide_walk* walk) {
    const float face = (float)walk->dda.next[ty_voxel_dda_axis(&walk->dda)];
    walk->to = ty_minf(walk->leave, ty_maxf(walk->from, face));
}

/* False if the ray has no part of [enter, leave] in the box. */
TY_FN bool ty_guide_walk_begin(ty_guide_walk* walk, const ty_guide_cells* cells, ty_vec origin, ty_vec direction,
                               float enter, float leave) {
    const float o[3] = {origin.x, origin.y, origin.z}, d[3] = {direction.x, direction.y, direction.z};
    for (int a = 0; a < 3; ++a) {
        const float low = cells->lower[a], high = low + (float)cells->size[a] / cells->per_metre[a];
        if (d[a] == 0.0f) {
            if (!(o[a] >= low && o[a] <= high)) return false;
            continue;
        }
        const float inverse = 1.0f / d[a], one = (low - o[a]) * inverse, other = (high - o[a]) * inverse;
        enter = ty_maxf(enter, ty_minf(one, other));
        leave = ty_minf(leave, ty_maxf(one, other));
    }
    if (!(enter < leave)) return false;
    walk->from = enter;
    walk->leave = leave;
    for (int a = 0; a < 3; ++a) {
        const int32_t cell = ty_guide_clamp_cell(cells, a, ty_guide_coordinate(cells, a, o[a] + d[a] * enter));
        const double side = 1.0 / (double)cells->per_metre[a],
                     low = (double)cells->lower[a] + cell * side - (double)o[a];
        walk->size[a] = cells->size[a];
        ty_voxel_dda_set(&walk->dda, a, cell, (double)d[a], low, low + side, side);
    }
    ty_guide_walk_set_end(walk);
    return true;
}

/* Goes on to the next cell; false at the end. */
TY_FN bool ty_guide_walk_next(ty_guide_walk* walk) {
    if (!(walk->to < walk->leave)) return false;
    const int32_t axis = ty_voxel_dda_axis(&walk->dda);
    ty_voxel_dda_advance(&walk->dda, axis);
    if (walk->dda.voxel[axis] < 0 || walk->dda.voxel[axis] >= walk->size[axis]) return false;
    walk->from = walk->to;
    ty_guide_walk_set_end(walk);
    return true;
}

/* ---- light ---- */

/* Radiance that a cell's light scatters into a direction of travel, per scattering coefficient: its directions are
 * taken for a Henyey-Greenstein lobe of their mean cosine, which the phase function of mean cosine g widens to one of
 * g times that. */
TY_FN float ty_guide_scattered(const ty_guide_light* light, ty_vec travel, float g) {
    const float tilt = 2.0f * (1.0f - ty_dot(light->axis, travel));
    return light->fluence * ty_hg_approximate(ty_maxf(tilt, 0.0f), g * light->mean_cosine);
}

/* Irradiance of a surface with a normal: fluence / 4 - flux . n / 2, the first two moments (Marshak). */
TY_FN float ty_guide_irradiance(const ty_guide_light* light, ty_vec normal) {
    return light->fluence * ty_maxf(0.0f, 0.25f - 0.5f * light->mean_cosine * ty_dot(light->axis, normal));
}

/* The light in front of a surface; NULL: it is outside of the cells. */
TY_FN TY_GLOBAL const ty_guide_light* ty_guide_light_before(const ty_guide* guide, ty_vec position, ty_vec normal) {
    const float none[3] = {0.0f, 0.0f, 0.0f}, *per_metre = guide->cells.per_metre;
    const ty_vec at =
        ty_vec_make(position.x + 0.75f * normal.x / per_metre[0], position.y + 0.75f * normal.y / per_metre[1],
                    position.z + 0.75f * normal.z / per_metre[2]);
    const int64_t cell = ty_guide_cell_at(&guide->cells, at, none);
    return cell < 0 ? NULL : &guide->light[cell];
}

/* Expected radiance that media send along a ray up to `far`. *passed: their transmittance. */
TY_FN float ty_guide_media_radiance(const ty_guide* guide, ty_vec origin, ty_vec direction, float far, float* passed) {
    const ty_vec travel = ty_scale(direction, -1.0f);
    float radiance = 0.0f;
    ty_guide_walk walk;
    *passed = 1.0f;
    if (!ty_guide_walk_begin(&walk, &guide->cells, origin, direction, 0.0f, far)) return 0.0f;
    do {
        const ty_guide_light* light = &guide->light[ty_guide_walk_cell(&walk)];
        if (!(light->sigma_t > 0.0f)) continue;
        const float source = light->sigma_s * ty_guide_scattered(light, travel, light->g) + light->emission;
        const float after = *passed * ty_exp_neg(ty_minf(light->sigma_t * (walk.to - walk.from), 87.0f));
        radiance += source / light->sigma_t * (*passed - after);
        *passed = after;
    } while (*passed > 1e-3f && ty_guide_walk_next(&walk));
    return radiance;
}

/* Expected radiance that a diffuse surface of an albedo sends back at a point. */
TY_FN float ty_guide_surface_radiance(const ty_guide* guide, ty_vec position, ty_vec normal, float albedo) {
    TY_GLOBAL const ty_guide_light* light = ty_guide_light_before(guide, position, normal);
    return light == NULL ? 0.0f : albedo * (1.0f / TY_PI) * ty_guide_irradiance(light, normal);
}

/* ---- directions of a vertex ---- */

enum { TY_GUIDE_VERTEX_BINS = TY_PATH_GUIDED != 0 ? TY_GUIDE_BINS : 1 };

/* Bins of a vertex: the light that comes from each, times what the vertex makes of it. */
typedef struct ty_guide_vertex {
    float fraction;                  /* of guided directions; 0: none, and the rest has no meaning */
    TY_GLOBAL const float* radiance; /* of the bins, as in ty_guide */
    float sum;
    float column[TY_GUIDE_SIDE]; /* sums */
    float weight[TY_GUIDE_VERTEX_BINS];
} ty_guide_vertex;

/* Sums up the weight. depth: 1 at the first vertex. The fraction falls as that of lobes about lights does, which bounds
 * the weight of paths without guided directions. */
TY_FN void ty_guide_vertex_end(ty_guide_vertex* vertex, const ty_guide* guide, float fraction, int32_t depth) {
    for (int32_t j = 0; j < TY_GUIDE_SIDE; ++j) vertex->column[j] = 0.0f;
    for (int32_t i = 0; i < TY_GUIDE_SIDE; ++i)
        for (int32_t j = 0; j < TY_GUIDE_SIDE; ++j)
            vertex->column[j] += vertex->weight[(i * TY_GUIDE_SIDE + j) % TY_GUIDE_VERTEX_BINS];
    vertex->sum = 0.0f;
    for (int32_t j = 0; j < TY_GUIDE_SIDE; ++j) vertex->sum += vertex->column[j];
    const float fall = 1.0f / (1.0f + guide->fall * (float)(depth - 1));
    vertex->fraction = vertex->sum > 1e-30f ? fraction * fall * fall : 0.0f;
}

/* The bins at a point; NULL: there are none. */
TY_FN TY_GLOBAL const float* ty_guide_bins_at(const ty_guide* guide, ty_vec at, ty_sampler* random) {
    const int64_t cell = ty_guide_jittered_cell(&guide->cells, at, random);
    return cell < 0 ? NULL : guide->radiance + cell * TY_GUIDE_BINS;
}

/* Begins a vertex that is not guided yet; returns the bins at its point. */
TY_FN TY_GLOBAL const float* ty_guide_vertex_begin(ty_guide_vertex* vertex, const ty_guide* guide, ty_vec at,
                                                   ty_sampler* random) {
    vertex->fraction = 0.0f;
    vertex->radiance = TY_PATH_GUIDED != 0 ? ty_guide_bins_at(guide, at, random) : NULL;
    return vertex->radiance;
}

/* Guided directions of a vertex in a medium of mean cosine g. */
TY_FN void ty_guide_vertex_scatter(ty_guide_vertex* vertex, const ty_guide* guide, ty_vec at, ty_vec incoming, float g,
                                   int32_t depth, ty_sampler* random) {
    TY_GLOBAL const float* radiance = ty_guide_vertex_begin(vertex, guide, at, random);
    if (radiance == NULL) return;
    for (int32_t b = 0; b < TY_GUIDE_VERTEX_BINS; ++b) {
        const float mu = incoming.x * guide->x[b] + incoming.y * guide->y[b] + incoming.z * guide->z[b];
        vertex->weight[b] = radiance[b] * ty_hg_approximate(ty_maxf(2.0f - 2.0f * mu, 0.0f), g);
    }
    ty_guide_vertex_end(vertex, guide, guide->directions * (1.0f - g * g), depth);
}

/* Guided directions of a vertex on a diffuse surface. */
TY_FN void ty_guide_vertex_reflect(ty_guide_vertex* vertex, const ty_guide* guide, ty_vec at, ty_vec normal,
                                   int32_t depth, ty_sampler* random) {
    TY_GLOBAL const float* radiance = ty_guide_vertex_begin(vertex, guide, at, random);
    if (radiance == NULL) return;
    for (int32_t b = 0; b < TY_GUIDE_VERTEX_BINS; ++b) {
        const float mu = normal.x * guide->x[b] + normal.y * guide->y[b] + normal.z * guide->z[b];
        vertex->weight[b] = radiance[b] * ty_maxf(0.0f, mu);
    }
    ty_guide_vertex_end(vertex, guide, guide->directions, depth);
}

/* True if a random number chooses a guided direction; *u is remapped to [0, 1) in any case. */
TY_FN bool ty_guide_vertex_takes(const ty_guide_vertex* vertex, float* u) {
    if (TY_PATH_GUIDED == 0 || !(vertex->fraction > 0.0f)) return false;
    const bool takes = *u < vertex->fraction;
    *u = takes ? *u / vertex->fraction : (*u - vertex->fraction) / (1.0f - vertex->fraction);
    *u = ty_minf(*u, 0x1.fffffep-1f);
    return takes;
}

TY_FN ty_vec ty_guide_vertex_sample(const ty_guide_vertex* vertex, float u, float v) {
    const float side = 2.0f / (float)TY_GUIDE_SIDE;
    float target = u * vertex->sum;
    int32_t i = 0, j = 0;
    while (j + 1 < TY_GUIDE_SIDE && target >= vertex->column[j]) target -= vertex->column[j++];
    while (i + 1 < TY_GUIDE_SIDE && target >= vertex->weight[(i * TY_GUIDE_SIDE + j) % TY_GUIDE_VERTEX_BINS])
        target -= vertex->weight[(i++ * TY_GUIDE_SIDE + j) % TY_GUIDE_VERTEX_BINS];
    const float weight = vertex->weight[(i * TY_GUIDE_SIDE + j) % TY_GUIDE_VERTEX_BINS];
    const float rest = ty_clampf(target / ty_maxf(weight, 1e-37f), 0.0f, 1.0f);
    return ty_octahedral_direction(((float)j + rest) * side - 1.0f, ((float)i + v) * side - 1.0f);
}

/* The bin of a direction. */
TY_FN int32_t ty_guide_bin_of(ty_vec direction) {
    float u, v;
    ty_octahedral_map(direction, &u, &v);
    const float half = 0.5f * (float)TY_GUIDE_SIDE;
    int32_t i = (int32_t)((v + 1.0f) * half), j = (int32_t)((u + 1.0f) * half);
    i = i < 0 ? 0 : i >= TY_GUIDE_SIDE ? TY_GUIDE_SIDE - 1 : i;
    j = j < 0 ? 0 : j >= TY_GUIDE_SIDE ? TY_GUIDE_SIDE - 1 : j;
    return i * TY_GUIDE_SIDE + j;
}

/* The density of a direction in the mixture, 1/sr; unguided: that of the vertex without its guide. vertex: NULL:
 * none. */
TY_FN float ty_guide_vertex_pdf(const ty_guide_vertex* vertex, ty_vec direction, float unguided) {
    if (TY_PATH_GUIDED == 0 || vertex == NULL || !(vertex->fraction > 0.0f)) return unguided;
    const float weight = vertex->weight[ty_guide_bin_of(direction) % TY_GUIDE_VERTEX_BINS];
    const float density = weight / (vertex->sum * ty_octahedral_angle(direction, TY_GUIDE_SIDE));
    return ty_lerpf(unguided, density, vertex->fraction);
}

/* Expected radiance from a direction: of its bin, or the mean of all where that is more; W m^-2 sr^-1; negative:
 * unknown. */
TY_FN float ty_guide_vertex_radiance(const ty_guide_vertex* vertex, ty_vec direction) {
    if (TY_PATH_GUIDED == 0 || !(vertex->fraction > 0.0f)) return -1.0f;
    float mean = 0.0f;
    for (int32_t b = 0; b < TY_GUIDE_BINS; ++b) mean += vertex->radiance[b];
    const float own = vertex->radiance[ty_guide_bin_of(direction)] / ty_octahedral_angle(direction, TY_GUIDE_SIDE);
    return ty_maxf(own, mean * TY_INV_4PI);
}

#endif
