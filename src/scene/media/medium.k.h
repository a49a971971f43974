/* Media along a ray: intervals inside the bounds, and a DDA over bricks with majorants. */
#ifndef TY_SCENE_MEDIA_MEDIUM_K_H
#define TY_SCENE_MEDIA_MEDIUM_K_H

#include "base/random.k.h"
#include "base/vector.k.h"
#include "grid/lookup.k.h"
#include "scene/media/blackbody.k.h"
#include "scene/media/phase_lobes.k.h"
#include "scene/surfaces/accel.h"

enum { TY_MEDIA_MAX = 64 };

/* Minimum step between tentative collisions, relative to the distance: the resolution of single precision. */
#define TY_MIN_COLLISION_STEP 6e-8f

/* A grid other than the density. */
typedef struct ty_field_view {
    ty_grid_view grid;
    float to_index[12]; /* world to the grid's index space */
} ty_field_view;

/* Bounds of a medium: ty_bounds_kind. */
enum { TY_BOUNDED_NOT = 0, TY_BOUNDED_BOX = 1, TY_BOUNDED_SPHERE = 2, TY_BOUNDED_MESH = 3 };

typedef struct ty_medium_view {
    ty_grid_view grid; /* valid if has_grid */
    int32_t has_grid;
    int32_t heterogeneous; /* density, albedo or emission vary: no closed-form transmittance */
    int32_t bounds;
    int32_t dielectric;    /* 1 + index of the surface, of a solid dielectric, that its bounds coincide with; 0: none */
    float to_bounds[12];   /* world to the space where the bounds are the cube [-1, 1]^3, the unit sphere or the closed
                              mesh */
    const ty_accel* shell; /* TY_BOUNDED_MESH */
    float to_index[12];    /* world to the grid's index space */
    TY_GLOBAL const float* extremes; /* extremes of the density per brick, as in ty_grid_view */
    int32_t owns_extremes;           /* nonzero if they are not the grid's */
    float sigma_s[3];                /* scale included, at density 1 */
    float sigma_t[3];
    float sigma_t_max;                    /* maximum over channels */
    float uniform_albedo[3];              /* sigma_s / sigma_t, used without albedo fields; 0 without collisions */
    float g[3];                           /* mean cosine */
    int32_t gray;                         /* equal sigma_t in all channels */
    int32_t gray_g;                       /* equal phase functions in all channels */
    TY_GLOBAL const ty_phase_view* phase; /* NULL: Henyey-Greenstein of g */
    TY_GLOBAL const ty_transfer_point* transfer; /* density by value; NULL: the value itself */
    int32_t transfer_count;
    int32_t transfer_albedo;
    int32_t albedo_fields; /* 0: sigma_s / sigma_t; 1: albedo[0] for all channels; 3 */
    ty_field_view albedo[3];
    int32_t has_g_field;
    ty_field_view g_field;
    int32_t emits;
    float emission_majorant; /* least density of tentative collisions in a thin medium that emits; 0: any */
    float emission[3];       /* radiance */
    int32_t has_temperature;
    ty_field_view temperature;
    float kelvin[2]; /* temperature = kelvin[0] + kelvin[1] * value */
    float blackbody_scale;
    TY_GLOBAL const ty_blackbody_table* blackbody;
} ty_medium_view;

/* Clips [*enter, *leave] to one coordinate in [low, high]; false if nothing remains. */
TY_FN bool ty_clip_slab(float origin, float direction, float low, float high, float* enter, float* leave) {
    if (direction == 0.0f) return origin >= low && origin <= high;
    const float inverse = 1.0f / direction;
    const float a = (low - origin) * inverse, b = (high - origin) * inverse;
    *enter = ty_maxf(*enter, ty_minf(a, b));
    *leave = ty_minf(*leave, ty_maxf(a, b));
    return *enter < *leave;
}

TY_FN bool ty_clip_box(ty_vec o, ty_vec d, ty_vec low, ty_vec high, float* enter, float* leave) {
    return ty_clip_slab(o.x, d.x, low.x, high.x, enter, leave) && ty_clip_slab(o.y, d.y, low.y, high.y, enter, leave) &&
           ty_clip_slab(o.z, d.z, low.z, high.z, enter, leave);
}

TY_FN bool ty_clip_unit_sphere(ty_vec o, ty_vec d, float* enter, float* leave) {
    const float dd = ty_dot(d, d);
    const float closest = -ty_dot(o, d) / dd;
    const ty_vec at = ty_mad(o, d, closest);
    const float half_square = (1.0f - ty_dot(at, at)) / dd;
    if (half_square <= 0.0f) return false;
    const float half = sqrtf(half_square);
    *enter = ty_maxf(*enter, closest - half);
    *leave = ty_minf(*leave, closest + half);
    return *enter < *leave;
}

/* Clips [*enter, *leave] to the medium's convex bounds and grid, ignoring its closed mesh; false if nothing remains. */
TY_FN bool ty_medium_interval(TY_GLOBAL const ty_medium_view* medium, ty_vec origin, ty_vec direction, float* enter,
                              float* leave) {
    if (medium->bounds == TY_BOUNDED_BOX || medium->bounds == TY_BOUNDED_SPHERE) {
        const ty_vec o = ty_map_point(medium->to_bounds, origin), d = ty_map_direction(medium->to_bounds, direction);
        if (medium->bounds == TY_BOUNDED_BOX) {
            if (!ty_clip_box(o, d, ty_vec_make(-1, -1, -1), ty_vec_make(1, 1, 1), enter, leave)) return false;
        } else if (!ty_clip_unit_sphere(o, d, enter, leave)) {
            return false;
        }
    }
    if (medium->has_grid == 0) return *enter < *leave;
    const ty_vec o = ty_map_point(medium->to_index, origin), d = ty_map_direction(medium->to_index, direction);
    const ty_vec high =
        ty_vec_make((float)medium->grid.size[0], (float)medium->grid.size[1], (float)medium->grid.size[2]);
    return ty_clip_box(o, d, ty_vec_make(-1, -1, -1), high, enter, leave);
}

/* DDA over the bricks of a grid along a ray; densities within [enter, leave] lie in [minorant, majorant]. */
typedef struct ty_majorant_dda {
    TY_GLOBAL const ty_medium_view* medium;
    ty_vec origin, direction; /* index space; the parameter is that of the world */
    float enter, leave, minorant, majorant;
    float next[3], step_t[3];
    float end; /* end of the whole interval */
    int32_t cell[3], step[3];
    int32_t done;
} ty_majorant_dda;

TY_FN void ty_majorant_dda_begin_axis(ty_majorant_dda* b, int32_t axis, float o, float d, float enter) {
    const int32_t count = b->medium->grid.bricks[axis];
    const float inverse_brick = 1.0f / (float)TY_BRICK;
    const float position = (o + d * enter + 1.0f) * inverse_brick;
    int32_t cell = (int32_t)floorf(position);
    cell = cell < 0 ? 0 : cell >= count ? count - 1 : cell;
    b->cell[axis] = cell;
    b->step[axis] = d > 0.0f ? 1 : -1;
    if (d == 0.0f) {
        b->next[axis] = b->step_t[axis] = TY_FLOAT_MAX;
        return;
    }
    const float inverse = 1.0f / d;
    const float face = (float)(TY_BRICK * (d > 0.0f ? cell + 1 : cell) - 1);
    b->next[axis] = (face - o) * inverse;
    b->step_t[axis] = fabsf((float)TY_BRICK * inverse);
}

TY_FN void ty_majorant_dda_begin(ty_majorant_dda* b, TY_GLOBAL const ty_medium_view* medium, ty_vec origin,
                                 ty_vec direction, float enter, float leave) {
    b->medium = medium;
    b->enter = b->leave = enter;
    b->end = leave;
    b->done = 0;
    b->minorant = b->majorant = 0.0f;
    if (medium->has_grid == 0) return;
    b->origin = ty_map_point(medium->to_index, origin);
    b->direction = ty_map_direction(medium->to_index, direction);
    ty_majorant_dda_begin_axis(b, 0, b->origin.x, b->direction.x, enter);
    ty_majorant_dda_begin_axis(b, 1, b->origin.y, b->direction.y, enter);
    ty_majorant_dda_begin_axis(b, 2, b->origin.z, b->direction.z, enter);
}

/* Advances to the next brick with nonzero majorant; false at the end of the interval. A homogeneous medium is one
 * brick. */
TY_FN bool ty_majorant_dda_next(ty_majorant_dda* b) {
    if (b->medium->has_grid == 0) {
        if (b->done != 0) return false;
        b->done = 1;
        b->leave = b->end;
        b->minorant = b->majorant = 1.0f;
        return true;
    }
    TY_GLOBAL const ty_grid_view* grid = &b->medium->grid;
    while (b->done == 0) {
        const int32_t xy = b->next[0] < b->next[1] ? 0 : 1;
        const int32_t axis = b->next[xy] < b->next[2] ? xy : 2;
        const float face = b->next[axis];
        TY_GLOBAL const float* extremes =
            b->medium->extremes +
            2 * ((size_t)b->cell[0] +
                 (size_t)grid->bricks[0] * ((size_t)b->cell[1] + (size_t)grid->bricks[1] * (size_t)b->cell[2]));
        b->minorant = ty_maxf(extremes[0], 0.0f);
        b->majorant = extremes[1];
        b->enter = b->leave;
        b->leave = ty_maxf(b->enter, ty_minf(face, b->end));
        b->cell[axis] += b->step[axis];
        b->next[axis] += b->step_t[axis];
        if (face >= b->end || (uint32_t)b->cell[axis] >= (uint32_t)grid->bricks[axis]) {
            b->done = 1;
            b->leave = b->end;
        }
        if (b->majorant > 0.0f && b->leave > b->enter) return true;
    }
    return false;
}

/* Unbiased estimate of the trilinear grid value at a point in index space: the voxel selected by a uniform jitter of
 * one voxel's width. Null-collision methods are linear in the density, so they remain unbiased. */
TY_FN float ty_grid_jittered(TY_GLOBAL const ty_grid_view* grid, ty_vec p, ty_sampler* random) {
    const uint64_t bits = ty_rng_bits(random);
    const float scale = 0x1p-21f;
    const int32_t i = (int32_t)floorf(p.x + (float)(uint32_t)(bits >> 43) * scale);
    const int32_t j = (int32_t)floorf(p.y + (float)(uint32_t)(bits >> 22 & 0x1fffffu) * scale);
    const int32_t k = (int32_t)floorf(p.z + (float)(uint32_t)(bits & 0x1fffffu) * scale);
    return ty_grid_fetch(grid, i, j, k);
}

/* Trilinear value at a point in index space. */
TY_FN float ty_grid_value(TY_GLOBAL const ty_grid_view* grid, ty_vec p) {
    const ty_vec low = ty_vec_make(floorf(p.x), floorf(p.y), floorf(p.z));
    const int32_t base[3] = {(int32_t)low.x, (int32_t)low.y, (int32_t)low.z};
    const float weight[3] = {p.x - low.x, p.y - low.y, p.z - low.z};
    return ty_grid_trilinear(grid, base, weight);
}

/* Field value at a world point. */
TY_FN float ty_field_value(TY_GLOBAL const ty_field_view* field, ty_vec point) {
    ty_vec p = ty_map_point(field->to_index, point);
    /* Clamped so that far outside, beyond the integer range, the value is that just outside. */
    p.x = ty_clampf(p.x, -2.0f, (float)field->grid.size[0] + 1.0f);
    p.y = ty_clampf(p.y, -2.0f, (float)field->grid.size[1] + 1.0f);
    p.z = ty_clampf(p.z, -2.0f, (float)field->grid.size[2] + 1.0f);
    return ty_grid_value(&field->grid, p);
}

/* Interval of a value in a transfer function: between point *i and the next; returns the weight of the next. */
TY_FN float ty_transfer_locate(TY_GLOBAL const ty_transfer_point* points, int32_t count, float value, int32_t* i) {
    int32_t low = 0, high = count - 1;
    while (high - low > 1) {
        const int32_t mid = (low + high) / 2;
        if (points[mid].value <= value)
            low = mid;
        else
            high = mid;
    }
    *i = low;
    return ty_clampf((value - points[low].value) / (points[high].value - points[low].value), 0.0f, 1.0f);
}

TY_FN float ty_transfer_density(TY_GLOBAL const ty_transfer_point* points, int32_t count, float value) {
    int32_t i;
    const float weight = ty_transfer_locate(points, count, value, &i);
    return ty_lerpf(points[i].density, points[i + 1].density, weight);
}

/* Unbiased estimate of the density at a point in index space, without bounds. Transfer functions are nonlinear, so they
 * use the trilinear value itself. */
TY_FN float ty_medium_density_at(TY_GLOBAL const ty_medium_view* medium, ty_vec p, ty_sampler* random) {
    if (medium->transfer != NULL)
        return ty_transfer_density(medium->transfer, medium->transfer_count, ty_grid_value(&medium->grid, p));
    return ty_grid_jittered(&medium->grid, p, random);
}

/* Estimate of the density at parameter t, clamped to the brick's bounds. */
TY_FN float ty_majorant_dda_density(const ty_majorant_dda* b, float t, ty_sampler* random) {
    if (b->medium->has_grid == 0) return 1.0f;
    const ty_vec p = ty_mad(b->origin, b->direction, t);
    return ty_clampf(ty_medium_density_at(b->medium, p, random), b->minorant, b->majorant);
}

/* The same at a world point inside the medium. */
TY_FN float ty_medium_density(TY_GLOBAL const ty_medium_view* medium, ty_vec point, ty_sampler* random) {
    if (medium->has_grid == 0) return 1.0f;
    return ty_maxf(0.0f, ty_medium_density_at(medium, ty_map_point(medium->to_index, point), random));
}

/* Single-scattering albedo at a world point, per channel; 0 without collisions. */
TY_FN void ty_medium_albedo(TY_GLOBAL const ty_medium_view* medium, ty_vec point, float albedo[3]) {
    if (medium->albedo_fields > 0) {
        for (int32_t c = 0; c < 3; ++c)
            albedo[c] = c < medium->albedo_fields ? ty_clampf(ty_field_value(&medium->albedo[c], point), 0.0f, 1.0f)
                                                  : albedo[0];
        return;
    }
    if (medium->transfer_albedo != 0) {
        int32_t i;
        const float value = ty_grid_value(&medium->grid, ty_map_point(medium->to_index, point));
        const float weight = ty_transfer_locate(medium->transfer, medium->transfer_count, value, &i);
        for (int32_t c = 0; c < 3; ++c)
            albedo[c] = ty_lerpf(medium->transfer[i].albedo[c], medium->transfer[i + 1].albedo[c], weight);
        return;
    }
    for (int32_t c = 0; c < 3; ++c) albedo[c] = medium->uniform_albedo[c];
}

/* Scattering coefficient at density 1 at a world point. */
TY_FN void ty_medium_sigma_s(TY_GLOBAL const ty_medium_view* medium, ty_vec point, float sigma_s[3]) {
    for (int32_t c = 0; c < 3; ++c) sigma_s[c] = medium->sigma_s[c];
    if (medium->albedo_fields == 0 && medium->transfer_albedo == 0) return;
    ty_medium_albedo(medium, point, sigma_s);
    for (int32_t c = 0; c < 3; ++c) sigma_s[c] *= medium->sigma_t[c];
}

/* Mean cosine at a world point, per channel. */
TY_FN void ty_medium_g(TY_GLOBAL const ty_medium_view* medium, ty_vec point, float g[3]) {
    if (medium->has_g_field == 0) {
        for (int32_t c = 0; c < 3; ++c) g[c] = medium->g[c];
        return;
    }
    const float value = ty_clampf(ty_field_value(&medium->g_field, point), -0.9999f, 0.9999f);
    for (int32_t c = 0; c < 3; ++c) g[c] = value;
}

/* The phase function per channel at a world point, for cosine mu in [-1, 1], 1/sr. */
TY_FN void ty_medium_phase(TY_GLOBAL const ty_medium_view* medium, ty_vec point, float mu, float phase[3]) {
    if (medium->phase != NULL) {
        ty_phase_evaluate(medium->phase, mu, phase);
        return;
    }
    float g[3];
    ty_medium_g(medium, point, g);
    for (int32_t c = 0; c < 3; ++c) phase[c] = ty_hg(mu, g[c]);
}

/* Emitted radiance of an optically thick body of the medium's state at a world point. */
TY_FN void ty_medium_emission(TY_GLOBAL const ty_medium_view* medium, ty_vec point, float emission[3]) {
    for (int32_t c = 0; c < 3; ++c) emission[c] = medium->emission[c];
    if (medium->has_temperature == 0) return;
    float thermal[3];
    const float value = ty_field_value(&medium->temperature, point);
    ty_blackbody_lookup(medium->blackbody, medium->kelvin[0] + medium->kelvin[1] * value, thermal);
    for (int32_t c = 0; c < 3; ++c) emission[c] += medium->blackbody_scale * thermal[c];
}

/* The same times the absorption coefficient at density 1: emission coefficient, W m^-3 sr^-1. */
TY_FN void ty_medium_emission_coefficient(TY_GLOBAL const ty_medium_view* medium, ty_vec point, float coefficient[3]) {
    float sigma_s[3];
    ty_medium_sigma_s(medium, point, sigma_s);
    ty_medium_emission(medium, point, coefficient);
    for (int32_t c = 0; c < 3; ++c) coefficient[c] *= ty_maxf(0.0f, medium->sigma_t[c] - sigma_s[c]);
}

#endif
