#include "solve/ordinates/fresnel_faces.h"

#include "base/arena.h"
#include "base/constants.h"
#include "base/context.h"
#include "scene/bsdf/fresnel.k.h"
#include "solve/diffusion/fresnel_boundary.h"

#include <math.h>

/* Cosine of a face to its interface above which the interface lies along the face. */
static const float min_aligned = 0.9999f;

struct ty_fresnel_faces {
    ty_context* context;
    const ty_ordinates_def* def;
    int32_t pitch;                             /* directions of an octant, padded */
    int32_t count;                             /* sides of the sweep */
    int32_t* side;                             /* of each wall: its side of the sweep; -1: it does not mirror */
    float *reflectance, *arriving, *reflected; /* angular values of the sweep's sides */
    float* factor;                             /* per side of the sweep */
    double ior, c1;                            /* of the last side */
    float *swept, *albedo, *emitted_albedo;    /* per wall: irradiance of the last sweep, and its reflected fraction */
    void* memory;
    size_t bytes;
};

/* ---- memory ---- */

static void lay_out(ty_fresnel_faces* f, ty_arena* arena) {
    const size_t walls = (size_t)f->def->walls.count, angular = (size_t)f->count * 4 * (size_t)f->pitch;
    f->side = ty_arena_take(arena, sizeof(int32_t) * walls);
    f->swept = ty_arena_take(arena, sizeof(float) * walls);
    f->albedo = ty_arena_take(arena, sizeof(float) * walls);
    f->emitted_albedo = ty_arena_take(arena, sizeof(float) * walls);
    f->factor = ty_arena_take(arena, sizeof(float) * (size_t)f->count);
    f->reflectance = ty_arena_take(arena, sizeof(float) * angular);
    f->arriving = ty_arena_take(arena, sizeof(float) * angular);
    f->reflected = ty_arena_take(arena, sizeof(float) * angular);
}

void ty_fresnel_faces_destroy(ty_fresnel_faces* f) {
    if (f == NULL) return;
    if (f->memory != NULL) ty_free_array(f->context, f->memory, f->bytes, 1);
    ty_free_array(f->context, f, 1, sizeof *f);
}

/* ---- directions ---- */

/* A direction that arrives at a side: its number in the set, and its place among the side's angular values. */
typedef struct arriving_direction {
    int32_t direction;
    ptrdiff_t at;
} arriving_direction;

/* Direction i of the four octants that arrive at a face; index: octant without the bit of the face's axis. */
static arriving_direction find_direction(const ty_fresnel_faces* f, int32_t wall, int32_t index, int32_t i) {
    const int32_t face = f->def->walls.face[wall], axis = face / 2;
    const int32_t bit = (face & 1) != 0 ? 0 : 1 << axis;
    const int32_t octant = (index & ((1 << axis) - 1)) | bit | (index >> axis) << (axis + 1);
    return (arriving_direction){f->def->set->first[octant] + i, ((ptrdiff_t)f->side[wall] * 4 + index) * f->pitch + i};
}

static double face_cosine(const ty_fresnel_faces* f, int32_t wall, int32_t direction) {
    return fabs((double)f->def->set->direction[f->def->walls.face[wall] / 2][direction]);
}

/* Cosine of a direction to a side's interface; *outward: the sum over axes of what its staircase passes. */
static float interface_cosine(const ty_fresnel_faces* f, int32_t wall, int32_t direction, float* outward) {
    const float* n = f->def->walls.normal + 3 * (ptrdiff_t)wall;
    float cosine = 0;
    *outward = 0;
    for (int a = 0; a < 3; ++a) {
        const float part = n[a] * f->def->set->direction[a][direction];
        cosine += part;
        *outward += ty_maxf(part, 0);
    }
    return ty_minf(cosine, 1);
}

/* The factor of 1 - R by which even light passes the interface as it should, pi (1 - 2 C1) of its radiance: few
 * directions lie near the critical angle. */
static float transmittance_factor(ty_fresnel_faces* f, int32_t wall) {
    const double n = (double)f->def->walls.ior[wall];
    double passed = 0;
    if (n != f->ior) f->c1 = ty_fresnel_moments_of(n).c1;
    f->ior = n;
    for (int32_t d = 0; d < f->def->set->count; ++d) {
        float outward;
        const float cosine = interface_cosine(f, wall, d, &outward);
        if (cosine > 0)
            passed += (double)(f->def->set->weight[d] * cosine * (1 - ty_fresnel_dielectric(cosine, (float)(1 / n))));
    }
    return passed > 0 ? (float)(TY_PI_F64 * fmax(1 - 2 * f->c1, 0) / passed) : 1;
}

static float reflectance_at(const ty_fresnel_faces* f, int32_t wall, int32_t direction, float factor) {
    float outward;
    const float cosine = interface_cosine(f, wall, direction, &outward);
    if (!(cosine > 0)) return 1;
    const float reflected = ty_fresnel_dielectric(cosine, 1 / f->def->walls.ior[wall]);
    return ty_maxf(0, 1 - factor * (1 - reflected) * cosine / outward);
}

/* Reflectances, and light from everywhere as the first distribution. */
static void fill_wall(ty_fresnel_faces* f, int32_t wall) {
    const float factor = transmittance_factor(f, wall);
    for (int32_t index = 0; index < 4; ++index)
        for (int32_t i = 0; i < f->def->set->first[1]; ++i) {
            const arriving_direction d = find_direction(f, wall, index, i);
            f->reflectance[d.at] = reflectance_at(f, wall, d.direction, factor);
            f->arriving[d.at] = 1;
        }
}

/* True where the interface lies along the face. */
static bool is_aligned(const ty_ordinates_def* def, int32_t wall) {
    return fabsf(def->walls.normal[3 * (ptrdiff_t)wall + def->walls.face[wall] / 2]) > min_aligned;
}

/* Irradiance of the arriving radiance, its reflected fraction, and the reflected radiance. */
static void reflect_wall(ty_fresnel_faces* f, int32_t wall) {
    const bool aligned = is_aligned(f->def, wall);
    double all = 0, reflected = 0, even = 0;
    for (int32_t index = 0; index < 4; ++index)
        for (int32_t i = 0; i < f->def->set->first[1]; ++i) {
            const arriving_direction d = find_direction(f, wall, index, i);
            const double weight = (double)f->def->set->weight[d.direction] * face_cosine(f, wall, d.direction);
            all += weight * (double)f->arriving[d.at];
            reflected += weight * (double)(f->arriving[d.at] * f->reflectance[d.at]);
            even += weight * (double)f->reflectance[d.at];
        }
    f->swept[wall] = (float)all;
    f->albedo[wall] = all > 0 ? (float)(reflected / all) : 0;
    for (int32_t index = 0; index < 4; ++index)
        for (int32_t i = 0; i < f->pitch; ++i) {
            const ptrdiff_t first = (ptrdiff_t)f->side[wall] * 4;
            const ptrdiff_t at = (first + index) * f->pitch + i, opposite = (first + 3 - index) * f->pitch + i;
            f->reflected[at] = aligned    ? f->arriving[at] * f->reflectance[at]
                               : even > 0 ? (float)(reflected / even) * f->reflectance[opposite]
                                          : 0;
        }
}

/* ---- calls ---- */

static void number_sides(ty_fresnel_faces* f, const ty_diffusive_cells* diffusive) {
    const ty_ordinates_faces* walls = &f->def->walls;
    for (int32_t i = 0; i < walls->count; ++i) f->side[i] = diffusive->count == 0 && walls->ior[i] > 0 ? i : -1;
    for (int32_t s = 0; diffusive->count > 0 && s < f->count; ++s) {
        const int32_t wall = diffusive->source[s];
        if (wall >= 0 && walls->ior[wall] > 0) f->side[wall] = s;
    }
}

ty_result ty_fresnel_faces_create(ty_context* context, const ty_ordinates_def* def, const ty_sweep* sweep,
                                  const ty_diffusive_cells* diffusive, ty_fresnel_faces** out) {
    *out = NULL;
    if (def->walls.count == 0 || def->walls.ior == NULL) return TY_OK;
    ty_fresnel_faces* f = ty_alloc_array(context, 1, sizeof *f, true);
    if (f == NULL) return TY_ERROR_MEMORY;
    f->context = context;
    f->def = def;
    f->pitch = ty_sweep_pitch(sweep);
    f->count = diffusive->count > 0 ? diffusive->sides.count : def->walls.count;
    ty_arena arena = {0};
    lay_out(f, &arena);
    f->bytes = arena.used;
    f->memory = arena.base = ty_alloc_array(context, f->bytes, 1, true);
    if (f->memory == NULL) {
        ty_fresnel_faces_destroy(f);
        return TY_ERROR_MEMORY;
    }
    arena.used = 0;
    lay_out(f, &arena);
    number_sides(f, diffusive);
    for (int32_t i = 0; i < def->walls.count; ++i) {
        if (f->side[i] < 0) continue;
        fill_wall(f, i);
        reflect_wall(f, i);
    }
    *out = f;
    return TY_OK;
}

bool ty_fresnel_faces_mirror(const ty_fresnel_faces* f, int32_t wall) {
    return f != NULL && f->side[wall] >= 0;
}

double ty_fresnel_faces_albedo(const ty_fresnel_faces* f, int32_t wall) {
    return (double)f->albedo[wall];
}

double ty_fresnel_faces_emit(ty_fresnel_faces* f, int32_t wall, double irradiance) {
    const double lit = fmax(irradiance, 0), swept = (double)f->swept[wall];
    f->emitted_albedo[wall] = f->albedo[wall];
    f->factor[f->side[wall]] = swept > 0 ? (float)(lit / swept) : 0;
    return swept > 0 ? lit * (double)f->albedo[wall] : 0;
}

float ty_fresnel_faces_change(const ty_fresnel_faces* f, int32_t wall, float irradiance, float before) {
    return f->albedo[wall] * irradiance - f->emitted_albedo[wall] * ty_maxf(before, 0);
}

void ty_fresnel_faces_diffuse(const ty_ordinates_def* def, float* albedo) {
    const ty_ordinates_faces* walls = &def->walls;
    double ior = 0, c1 = 0;
    for (int32_t i = 0; i < walls->count; ++i) {
        const float* n = walls->normal + 3 * (ptrdiff_t)i;
        albedo[i] = walls->albedo[i];
        if (!(walls->ior[i] > 0) || is_aligned(def, i)) continue;
        if ((double)walls->ior[i] != ior) c1 = ty_fresnel_moments_of((double)walls->ior[i]).c1;
        ior = (double)walls->ior[i];
        albedo[i] = (float)(1 - (1 - 2 * c1) / (double)(fabsf(n[0]) + fabsf(n[1]) + fabsf(n[2])));
    }
}

void ty_fresnel_faces_attach(ty_fresnel_faces* f, ty_sweep_faces* faces) {
    if (f == NULL) return;
    faces->reflected = f->reflected;
    faces->factor = f->factor;
    faces->arriving = f->arriving;
}

void ty_fresnel_faces_receive(ty_fresnel_faces* f) {
    if (f == NULL) return;
    for (int32_t i = 0; i < f->def->walls.count; ++i)
        if (f->side[i] >= 0) reflect_wall(f, i);
}
