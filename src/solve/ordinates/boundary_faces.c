/* Opaque faces between and around cells. Their emitted radiance is that of the mixed iterate, like the emission of
 * cells; their irradiance, one number per side, is part of an iterate. */
#include "base/constants.h"
#include "base/kernel.h"
#include "solve/ordinates/job.h"

#include <math.h>
#include <string.h>

#define SQRT_3 1.7320508075688772f

/* In isotropic light the irradiance is a quarter of the fluence, which is sqrt(4 pi) times the first harmonic: this
 * factor makes a side's number comparable with a cell's. */
static const double to_harmonic = 4 / TY_SQRT_4PI_F64;

void ty_ordinates_faces_lay_out(ty_ordinates_job* job, ty_arena* arena) {
    const size_t bytes = sizeof(float) * (size_t)job->def->walls.count;
    if (bytes == 0) return;
    job->face_radiance = ty_arena_take(arena, bytes);
    job->face_irradiance_mixed = ty_arena_take(arena, bytes);
    for (int32_t i = 0; i < job->depth; ++i) {
        job->face_irradiance[i] = ty_arena_take(arena, bytes);
        job->face_changes[i] = ty_arena_take(arena, bytes);
    }
}

double ty_ordinates_face_area(const ty_ordinates_def* def, int32_t side) {
    const int axis = def->walls.face[side] / 2;
    return def->cell[(axis + 1) % 3] * def->cell[(axis + 2) % 3];
}

static int64_t row_of_side(const ty_ordinates_faces* walls, int32_t side, int64_t row) {
    while (walls->first[row + 1] <= side) ++row;
    return row;
}

void ty_ordinates_faces_begin(ty_ordinates_job* job) {
    const ty_ordinates_faces* walls = &job->def->walls;
    const size_t bytes = sizeof(float) * (size_t)walls->count;
    if (bytes == 0) return;
    memset(job->face_irradiance_mixed, 0, bytes);
    int64_t row = 0;
    for (int32_t i = 0; i < walls->count; ++i) {
        row = row_of_side(walls, i, row);
        const int64_t at = row * job->def->size[0] * job->low_order_terms + walls->x[i];
        const float isotropic = job->count > 0 ? job->low_order[job->latest][at] : 0;
        job->face_irradiance[job->latest][i] = ty_maxf(0, isotropic) / (float)to_harmonic;
    }
}

void ty_ordinates_set_sweep_faces(ty_ordinates_job* job, ty_sweep* sweep, int32_t iterate) {
    const ty_ordinates_faces* walls = &job->def->walls;
    job->walls = (ty_sweep_faces){.count = walls->count,
                                  .first = walls->first,
                                  .x = walls->x,
                                  .face = walls->face,
                                  .emitted = job->face_radiance,
                                  .incident_power = job->face_irradiance[iterate]};
    if (job->diffusive.count > 0) job->walls = job->diffusive.sides;
    ty_fresnel_faces_attach(job->fresnel, &job->walls);
    if (job->walls.count > 0) ty_sweep_set_faces(sweep, &job->walls);
}

/* True for sides of diffusive cells, which sweeps skip. */
static bool is_diffusive(const ty_ordinates_job* job, int32_t side, int64_t row) {
    return job->diffusive.count > 0 && job->diffusive.slots[row * job->def->size[0] + job->def->walls.x[side]] >= 0;
}

double ty_ordinates_faces_emit(ty_ordinates_job* job) {
    const ty_ordinates_faces* walls = &job->def->walls;
    double sum = 0;
    int64_t row = 0;
    for (int32_t i = 0; i < walls->count; ++i) {
        double irradiance = 0;
        row = row_of_side(walls, i, row);
        for (int32_t k = 0; k < job->count; ++k)
            if (job->anderson_weights[k] != 0)
                irradiance += job->anderson_weights[k] * (double)job->face_irradiance[k][i];
        const bool mirrors = ty_fresnel_faces_mirror(job->fresnel, i);
        const double reflected = mirrors ? 0 : (double)walls->albedo[i] / TY_PI_F64 * irradiance;
        const double radiance = (double)walls->emission[i] + reflected;
        job->face_irradiance_mixed[i] = (float)irradiance;
        if (mirrors) sum += ty_ordinates_face_area(job->def, i) * ty_fresnel_faces_emit(job->fresnel, i, irradiance);
        job->face_radiance[i] = radiance > 0 ? (float)radiance : 0;
        if (!is_diffusive(job, i, row))
            sum += TY_PI_F64 * (double)job->face_radiance[i] * ty_ordinates_face_area(job->def, i);
    }
    return sum;
}

double ty_ordinates_faces_receive(ty_ordinates_job* job) {
    const ty_ordinates_faces* walls = &job->def->walls;
    float* irradiance = job->face_irradiance[job->latest];
    double sum = 0;
    for (int32_t i = 0; i < walls->count; ++i) {
        sum += (double)irradiance[i];
        irradiance[i] /= (float)ty_ordinates_face_area(job->def, i);
    }
    ty_fresnel_faces_receive(job->fresnel);
    return sum;
}

static double entering_through(const ty_ordinates_def* def, int face, const int32_t at[3]) {
    const ty_boundary_radiance* boundary = &def->boundary_radiance;
    const int axis = face / 2;
    const float* radiance = boundary->across[axis] + (ptrdiff_t)ty_ordinates_patch(def, axis, at) * def->set->count;
    double sum = 0;
    for (int32_t d = 0; d < def->set->count; ++d) {
        const double cosine = (double)def->set->direction[axis][d] * ((face & 1) != 0 ? -1 : 1);
        sum += fmax(cosine, 0) * (double)def->set->weight[d] * (double)radiance[d];
    }
    return sum * def->cell[(axis + 1) % 3] * def->cell[(axis + 2) % 3];
}

/* Power through all faces of the box but those that surfaces close; of a part, its own. */
double ty_ordinates_entering(const ty_ordinates_def* def) {
    const ty_ordinates_faces* walls = &def->walls;
    const int32_t* size = def->size;
    double power = 0;
    if (def->boundary_radiance.across[0] == NULL) return 0;
    for (int face = 0; face < 6; ++face) {
        const int axis = face / 2, low = axis == 0 ? 1 : 0, high = axis == 2 ? 1 : 2;
        int32_t at[3] = {0, 0, 0};
        if (!ty_ordinates_ends(def, face)) continue;
        for (at[high] = 0; at[high] < size[high]; ++at[high])
            for (at[low] = 0; at[low] < size[low]; ++at[low]) power += entering_through(def, face, at);
    }
    for (int64_t row = 0, side = 0; side < walls->count; ++row)
        for (; side < walls->first[row + 1]; ++side) {
            const int32_t at[3] = {walls->x[side], (int32_t)(row % size[1]), (int32_t)(row / size[1])};
            const int face = walls->face[side];
            if (ty_ordinates_ends(def, face) && at[face / 2] == ((face & 1) != 0 ? size[face / 2] - 1 : 0))
                power -= entering_through(def, face, at);
        }
    return power;
}

/* ---- corrections ---- */

/* Cell of a side and its diffusion data. */
typedef struct face_cell {
    ptrdiff_t box, step; /* index in the DSA arrays; step to the cell behind the face */
    ptrdiff_t flux;      /* index of the flux along the axis in low-order arrays; negative: no flux */
    const float* behind; /* the latest change of it in the cell behind the face; NULL: outside the box */
    float sign;          /* 1: upper face, -1: lower face */
    float edge, d;
} face_cell;

static face_cell make_face_cell(const ty_ordinates_job* job, int32_t side, int64_t row) {
    const ty_ordinates_def* def = job->def;
    const int axis = def->walls.face[side] / 2, term = axis == 0 ? 3 : axis;
    const bool up = (def->walls.face[side] & 1) != 0;
    const int32_t *size = def->size, at[3] = {def->walls.x[side], (int32_t)(row % size[1]), (int32_t)(row / size[1])};
    const ptrdiff_t low_row = (ptrdiff_t)size[0] * job->low_order_terms, steps[3] = {1, low_row, low_row * size[1]};
    face_cell c = {.flux = -1, .sign = up ? 1 : -1, .edge = (float)def->cell[axis]};
    c.box = ty_dsa_face_cell(job->dsa, side, row, &c.step);
    c.d = ty_dsa_diffusivity(job->dsa)[c.box];
    if (job->low_order_terms == 1) return c;
    c.flux = row * low_row + (ptrdiff_t)term * size[0] + at[0];
    if (at[axis] != (up ? size[axis] - 1 : 0))
        c.behind = job->changes[job->latest] + c.flux + (up ? steps[axis] : -steps[axis]);
    else if (!ty_ordinates_ends(def, def->walls.face[side]))
        c.behind = job->flux_beyond[def->walls.face[side]] + (axis == 0 ? row : at[2] * (int64_t)size[0] + at[0]);
    return c;
}

/* Outflow through the cell's face due to the change of flux alone, as for a transparent face. */
static float transparent_outflow(const face_cell* c, const float* change) {
    if (c->flux < 0) return 0;
    const float value = c->sign * change[c->flux];
    return c->behind == NULL ? value / (1 + 4 * c->d / c->edge) : 0.5f * (value + c->sign * *c->behind);
}

double ty_ordinates_faces_residual(ty_ordinates_job* job, bool first) {
    const ty_ordinates_faces* walls = &job->dsa_walls;
    const float* change_lm = job->changes[job->latest];
    double squares = 0;
    for (int64_t row = 0, side = 0; side < walls->count; ++row)
        for (; side < walls->first[row + 1]; ++side) {
            const face_cell c = make_face_cell(job, (int32_t)side, row);
            ty_dsa_face_offset(job->dsa)[side] = 0;
            if (is_diffusive(job, (int32_t)side, row)) continue;
            const float albedo = walls->albedo[side], slope = ty_dsa_face_slope(job->dsa)[side];
            const float irradiance = job->face_irradiance[job->latest][side];
            const float before = job->face_irradiance_mixed[side];
            const float change = ty_fresnel_faces_mirror(job->fresnel, (int32_t)side)
                                     ? ty_fresnel_faces_change(job->fresnel, (int32_t)side, irradiance, before)
                                     : albedo * (irradiance - before);
            const float radiosity =
                (first ? (float)TY_PI_F64 * walls->emission[side] : change) / (float)TY_SQRT_4PI_F64;
            const float kappa = 0.5f * (1 - albedo) / (1 + albedo), half = c.edge / (2 * c.d);
            float offset = -2 * radiosity / ((1 + albedo) * (1 + kappa * half));
            if (c.flux >= 0) offset += slope * half * c.sign * change_lm[c.flux];
            float* f = ty_dsa_source(job->dsa) + c.box;
            const float previous = *f;
            ty_dsa_face_offset(job->dsa)[side] = offset;
            *f += (transparent_outflow(&c, change_lm) - offset) / c.edge;
            squares += (double)*f * (double)*f - (double)previous * (double)previous;
        }
    return squares;
}

void ty_ordinates_faces_correct(ty_ordinates_job* job, const float* e) {
    const ty_ordinates_faces* walls = &job->def->walls;
    const float *change = job->changes[job->latest], *diffusivity = ty_dsa_diffusivity(job->dsa);
    for (int64_t row = 0, side = 0; side < walls->count; ++row)
        for (; side < walls->first[row + 1]; ++side) {
            const face_cell c = make_face_cell(job, (int32_t)side, row);
            if (is_diffusive(job, (int32_t)side, row)) continue;
            const float flux = c.flux >= 0 ? change[c.flux] : 0, value = e[c.box];
            const float flow = ty_dsa_face_slope(job->dsa)[side] * value + ty_dsa_face_offset(job->dsa)[side];
            const float face = value + (c.sign * flux - flow) * c.edge / (2 * c.d);
            job->face_irradiance[job->latest][side] += (float)TY_SQRT_4PI_F64 * (0.25f * face + 0.5f * flow);
            if (c.flux < 0) continue;
            const float behind = fabsf(diffusivity[c.box + c.step]), weight = behind / (behind + c.d);
            const float without = c.sign / c.edge * c.d * weight * (value - e[c.box + c.step]);
            job->low_order[job->latest][c.flux] += SQRT_3 * (0.5f * (c.sign * flow - flux) - without);
        }
}

void ty_ordinates_faces_compare(ty_ordinates_job* job, ty_ordinates_sums* sums) {
    const ty_ordinates_faces* walls = &job->def->walls;
    if (walls->count == 0) return;
    const float *irradiance = job->face_irradiance[job->latest], *mixed = job->face_irradiance_mixed;
    float* changes = job->face_changes[job->latest];
    const double square = to_harmonic * to_harmonic;
    double change = 0, squares_sum = 0, emitted, absorbed;
    ty_ordinates_faces_balance(job, irradiance, &emitted, &absorbed);
    sums->absorbed += absorbed / (job->def->cell[0] * job->def->cell[1] * job->def->cell[2] * TY_SQRT_4PI_F64);
    for (int32_t i = 0; i < walls->count; ++i) {
        changes[i] = irradiance[i] - mixed[i];
        change += (double)changes[i] * (double)changes[i];
        squares_sum += (double)irradiance[i] * (double)irradiance[i];
    }
    sums->change += square * change;
    sums->fluence += square * squares_sum;
    for (int32_t k = 0; k < job->count; ++k) {
        const float* other = job->face_changes[k];
        double product = 0;
        for (int32_t i = 0; i < walls->count; ++i) product += (double)changes[i] * (double)other[i];
        sums->products[k] += square * product;
    }
}

void ty_ordinates_faces_balance(ty_ordinates_job* job, const float* irradiance, double* emitted, double* absorbed) {
    const ty_ordinates_faces* walls = &job->def->walls;
    *emitted = *absorbed = 0;
    for (int32_t i = 0; i < walls->count; ++i) {
        const double area = ty_ordinates_face_area(job->def, i);
        *emitted += TY_PI_F64 * area * (double)walls->emission[i];
        *absorbed += area * ty_ordinates_face_absorbs(job, i, irradiance[i]);
    }
}

double ty_ordinates_face_absorbs(const ty_ordinates_job* job, int32_t side, float irradiance) {
    const double albedo = ty_fresnel_faces_mirror(job->fresnel, side) ? ty_fresnel_faces_albedo(job->fresnel, side)
                                                                      : (double)job->def->walls.albedo[side];
    return (1 - albedo) * (double)irradiance;
}
