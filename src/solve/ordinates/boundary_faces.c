/* Walls between and around the cells of discrete ordinates. What they send is that of the mixture, as the emission of
 * cells is, and what arrives on them is part of an iterate: irradiance, one number a side. */
#include "base/kernel.h"
#include "solve/ordinates/job.h"

#include <math.h>
#include <string.h>

#define PI 3.141592653589793
#define SQRT_4PI 3.5449077018110318
#define SQRT_3 1.7320508075688772f

/* In even light the irradiance is a quarter of the fluence, which is sqrt(4 pi) times the first harmonic: what makes a
 * side's number count as a cell's. */
static const double to_harmonic = 4 / SQRT_4PI;

void ty_ordinates_faces_lay_out(ty_ordinates_job* job, ty_arena* arena) {
    const size_t bytes = sizeof(float) * (size_t)job->def->walls.count;
    if (bytes == 0) return;
    job->walls_sent = ty_arena_take(arena, bytes);
    job->walls_before = ty_arena_take(arena, bytes);
    for (int32_t i = 0; i < job->depth; ++i) {
        job->walls_arrived[i] = ty_arena_take(arena, bytes);
        job->walls_changes[i] = ty_arena_take(arena, bytes);
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
    memset(job->walls_before, 0, bytes);
    int64_t row = 0;
    for (int32_t i = 0; i < walls->count; ++i) {
        row = row_of_side(walls, i, row);
        const int64_t at = row * job->def->size[0] * job->lows + walls->x[i];
        const float even = job->count > 0 ? job->low[job->latest][at] : 0;
        job->walls_arrived[job->latest][i] = ty_maxf(0, even) / (float)to_harmonic;
    }
}

void ty_ordinates_set_sweep_faces(ty_ordinates_job* job, ty_sweep* sweep, int32_t iterate) {
    const ty_ordinates_faces* walls = &job->def->walls;
    job->walls = (ty_sweep_faces){.count = walls->count,
                                  .first = walls->first,
                                  .x = walls->x,
                                  .face = walls->face,
                                  .emitted = job->walls_sent,
                                  .incident_power = job->walls_arrived[iterate]};
    if (job->thick.count > 0) job->walls = job->thick.sides;
    if (job->walls.count > 0) ty_sweep_set_faces(sweep, &job->walls);
}

/* Whether a side is a thick cell's, of which sweeps know nothing. */
static bool is_thick(const ty_ordinates_job* job, int32_t side, int64_t row) {
    return job->thick.count > 0 && job->thick.slots[row * job->def->size[0] + job->def->walls.x[side]] >= 0;
}

double ty_ordinates_faces_emit(ty_ordinates_job* job) {
    const ty_ordinates_faces* walls = &job->def->walls;
    double sum = 0;
    int64_t row = 0;
    for (int32_t i = 0; i < walls->count; ++i) {
        double arrived = 0;
        row = row_of_side(walls, i, row);
        for (int32_t k = 0; k < job->count; ++k)
            if (job->shares[k] != 0) arrived += job->shares[k] * (double)job->walls_arrived[k][i];
        const double sent = (double)walls->emission[i] + (double)walls->albedo[i] / PI * arrived;
        job->walls_before[i] = (float)arrived;
        job->walls_sent[i] = sent > 0 ? (float)sent : 0;
        if (!is_thick(job, i, row)) sum += PI * (double)job->walls_sent[i] * ty_ordinates_face_area(job->def, i);
    }
    return sum;
}

double ty_ordinates_faces_receive(ty_ordinates_job* job) {
    const ty_ordinates_faces* walls = &job->def->walls;
    float* arrived = job->walls_arrived[job->latest];
    double sum = 0;
    for (int32_t i = 0; i < walls->count; ++i) {
        sum += (double)arrived[i];
        arrived[i] /= (float)ty_ordinates_face_area(job->def, i);
    }
    return sum;
}

double ty_ordinates_entering(const ty_ordinates_def* def) {
    const ty_ordinates_faces* walls = &def->walls;
    const int32_t* size = def->size;
    double open[6], power = 0;
    if (def->inflow == NULL) return 0;
    for (int face = 0; face < 6; ++face) open[face] = (double)size[(face / 2 + 1) % 3] * size[(face / 2 + 2) % 3];
    for (int64_t row = 0, side = 0; side < walls->count; ++row)
        for (; side < walls->first[row + 1]; ++side) {
            const int32_t at[3] = {walls->x[side], (int32_t)(row % size[1]), (int32_t)(row / size[1])};
            const int axis = walls->face[side] / 2;
            if (at[axis] == ((walls->face[side] & 1) != 0 ? size[axis] - 1 : 0)) open[walls->face[side]] -= 1;
        }
    for (int32_t d = 0; d < def->set->count; ++d)
        for (int a = 0; a < 3; ++a) {
            const double along = (double)def->set->direction[a][d], edge = def->cell[(a + 1) % 3];
            power += (double)def->inflow[d] * (double)def->set->weight[d] * fabs(along) * edge *
                     def->cell[(a + 2) % 3] * open[2 * a + (along < 0 ? 1 : 0)];
        }
    return power;
}

/* ---- corrections ---- */

/* A side's cell, and what diffusion has there. */
typedef struct wall_cell {
    ptrdiff_t box, step; /* in the correction's arrays; to the cell behind */
    ptrdiff_t flux;      /* its flux along the axis, in low terms and changes; below 0: there is none */
    ptrdiff_t behind;    /* the same of the cell behind; below 0: there is none */
    float way;           /* 1: the upper face, -1 */
    float edge, d;
} wall_cell;

static wall_cell cell_of(const ty_ordinates_job* job, int32_t side, int64_t row) {
    const ty_ordinates_def* def = job->def;
    const int axis = def->walls.face[side] / 2, term = axis == 0 ? 3 : axis;
    const bool up = (def->walls.face[side] & 1) != 0;
    const int32_t *size = def->size, at[3] = {def->walls.x[side], (int32_t)(row % size[1]), (int32_t)(row / size[1])};
    const ptrdiff_t low_row = (ptrdiff_t)size[0] * job->lows, steps[3] = {1, low_row, low_row * size[1]};
    wall_cell c = {.flux = -1, .behind = -1, .way = up ? 1 : -1, .edge = (float)def->cell[axis]};
    c.box = ty_dsa_face_cell(job->correction, side, row, &c.step);
    c.d = ty_dsa_diffusivity(job->correction)[c.box];
    if (job->lows == 1) return c;
    c.flux = row * low_row + (ptrdiff_t)term * size[0] + at[0];
    if (at[axis] != (up ? size[axis] - 1 : 0)) c.behind = c.flux + (up ? steps[axis] : -steps[axis]);
    return c;
}

/* What flows out of the cell's face by the change of flux alone, as cells have it where there is no wall. */
static float flow_without(const wall_cell* c, const float* change) {
    if (c->flux < 0) return 0;
    const float here = c->way * change[c->flux];
    return c->behind < 0 ? here / (1 + 4 * c->d / c->edge) : 0.5f * (here + c->way * change[c->behind]);
}

double ty_ordinates_faces_residual(ty_ordinates_job* job, bool first) {
    const ty_ordinates_faces* walls = &job->def->walls;
    const float* change = job->changes[job->latest];
    double squares = 0;
    for (int64_t row = 0, side = 0; side < walls->count; ++row)
        for (; side < walls->first[row + 1]; ++side) {
            const wall_cell c = cell_of(job, (int32_t)side, row);
            ty_dsa_face_offset(job->correction)[side] = 0;
            if (is_thick(job, (int32_t)side, row)) continue;
            const float albedo = walls->albedo[side], slope = ty_dsa_face_slope(job->correction)[side];
            const float more = job->walls_arrived[job->latest][side] - job->walls_before[side];
            const float sent = (first ? (float)PI * walls->emission[side] : albedo * more) / (float)SQRT_4PI;
            const float kappa = 0.5f * (1 - albedo) / (1 + albedo), half = c.edge / (2 * c.d);
            float rest = -2 * sent / ((1 + albedo) * (1 + kappa * half));
            if (c.flux >= 0) rest += slope * half * c.way * change[c.flux];
            float* f = ty_dsa_source(job->correction) + c.box;
            const float was = *f;
            ty_dsa_face_offset(job->correction)[side] = rest;
            *f += (flow_without(&c, change) - rest) / c.edge;
            squares += (double)*f * (double)*f - (double)was * (double)was;
        }
    return squares;
}

void ty_ordinates_faces_correct(ty_ordinates_job* job, const float* e) {
    const ty_ordinates_faces* walls = &job->def->walls;
    const float *change = job->changes[job->latest], *diffusivity = ty_dsa_diffusivity(job->correction);
    for (int64_t row = 0, side = 0; side < walls->count; ++row)
        for (; side < walls->first[row + 1]; ++side) {
            const wall_cell c = cell_of(job, (int32_t)side, row);
            if (is_thick(job, (int32_t)side, row)) continue;
            const float flux = c.flux >= 0 ? change[c.flux] : 0, here = e[c.box];
            const float flow =
                ty_dsa_face_slope(job->correction)[side] * here + ty_dsa_face_offset(job->correction)[side];
            const float face = here + (c.way * flux - flow) * c.edge / (2 * c.d);
            job->walls_arrived[job->latest][side] += (float)SQRT_4PI * (0.25f * face + 0.5f * flow);
            if (c.flux < 0) continue;
            const float behind = fabsf(diffusivity[c.box + c.step]), share = behind / (behind + c.d);
            const float without = c.way / c.edge * c.d * share * (here - e[c.box + c.step]);
            job->low[job->latest][c.flux] += SQRT_3 * (0.5f * (c.way * flow - flux) - without);
        }
}

void ty_ordinates_faces_compare(ty_ordinates_job* job, ty_ordinates_sums* sums) {
    const ty_ordinates_faces* walls = &job->def->walls;
    if (walls->count == 0) return;
    const float *arrived = job->walls_arrived[job->latest], *before = job->walls_before;
    float* changes = job->walls_changes[job->latest];
    const double square = to_harmonic * to_harmonic;
    double change = 0, light = 0, emitted, absorbed;
    ty_ordinates_faces_balance(job, arrived, &emitted, &absorbed);
    sums->absorbed += absorbed / (job->def->cell[0] * job->def->cell[1] * job->def->cell[2] * SQRT_4PI);
    for (int32_t i = 0; i < walls->count; ++i) {
        changes[i] = arrived[i] - before[i];
        change += (double)changes[i] * (double)changes[i];
        light += (double)arrived[i] * (double)arrived[i];
    }
    sums->change += square * change;
    sums->fluence += square * light;
    for (int32_t k = 0; k < job->count; ++k) {
        const float* other = job->walls_changes[k];
        double product = 0;
        for (int32_t i = 0; i < walls->count; ++i) product += (double)changes[i] * (double)other[i];
        sums->products[k] += square * product;
    }
}

void ty_ordinates_faces_balance(ty_ordinates_job* job, const float* arrived, double* emitted, double* absorbed) {
    const ty_ordinates_faces* walls = &job->def->walls;
    *emitted = *absorbed = 0;
    for (int32_t i = 0; i < walls->count; ++i) {
        const double area = ty_ordinates_face_area(job->def, i);
        *emitted += PI * area * (double)walls->emission[i];
        *absorbed += area * (1 - (double)walls->albedo[i]) * (double)arrived[i];
    }
}
