/* Thick cells among those of discrete ordinates. Sweeps see closed faces there, which send what the mixture's phi makes
 * of them; what arrives on skins is part of an iterate, as it is on walls. What of a thick cell's balance is amiss is
 * the correction's source there, as it is: nothing has to be told from differences of large numbers, and no wave passes
 * such cells. Light is in units of the first harmonic (over sqrt(4 pi)) but for what sweeps see. */
#include "base/context.h"
#include "base/kernel.h"
#include "solve/ordinates/job.h"

#include <math.h>
#include <string.h>

#define PI 3.141592653589793
#define SQRT_4PI 3.5449077018110318
#define SQRT_3 1.7320508075688772f

/* The term of band 1 along an axis. */
static const int32_t term_of[3] = {3, 1, 2};

/* Where a cell's numbers are in low terms, of which its flux follows a row later each, and in the correction's. */
typedef struct thick_place {
    ptrdiff_t low, box;
} thick_place;

static thick_place place_of(const ty_ordinates_job* job, int64_t cell) {
    const int32_t* size = job->def->size;
    const ptrdiff_t row = (ptrdiff_t)(cell / size[0]), x = (ptrdiff_t)(cell % size[0]);
    const ty_box* box = ty_dsa_box(job->correction);
    return (thick_place){.low = row * size[0] * job->lows + x,
                         .box = ty_box_at(box, (int32_t)(row % size[1]), (int32_t)(row / size[1])) + x};
}

static int64_t step_of(const ty_ordinates_job* job, int face) {
    const int32_t* size = job->def->size;
    const int64_t steps[3] = {1, size[0], (int64_t)size[0] * size[1]};
    return (face & 1) != 0 ? steps[face / 2] : -steps[face / 2];
}

static float conductance(const ty_ordinates_job* job, const ty_diffusive_cell* cell, int face) {
    return ty_diffusive_conductance(cell, job->def->cell, face);
}

static double area_of(const ty_ordinates_def* def, int face) {
    return def->cell[(face / 2 + 1) % 3] * def->cell[(face / 2 + 2) % 3];
}

/* ---- memory ---- */

static void lay_out(ty_ordinates_job* job, ty_arena* arena) {
    const size_t bytes = sizeof(float) * (size_t)job->thick.skin_count;
    job->skin_before = ty_arena_take(arena, bytes);
    job->skin_excess = ty_arena_take(arena, bytes);
    for (int32_t i = 0; i < job->depth; ++i) {
        job->skin_arrived[i] = ty_arena_take(arena, bytes);
        job->skin_changes[i] = ty_arena_take(arena, bytes);
    }
}

/* What comes in through the box's face by the def, per area. */
static float inflow_of(const ty_ordinates_def* def, int face) {
    if (def->inflow == NULL) return 0;
    double sum = 0;
    for (int32_t d = 0; d < def->set->count; ++d) {
        const double along = (double)def->set->direction[face / 2][d] * ((face & 1) != 0 ? -1 : 1);
        sum += fmax(along, 0) * (double)def->set->weight[d] * (double)def->inflow[d];
    }
    return (float)(sum / SQRT_4PI);
}

ty_result ty_ordinates_diffusive_find(ty_ordinates_job* job, float* reduced, const float* absorption) {
    ty_diffusive_cells* thick = &job->thick;
    ty_result result = ty_diffusive_cells_find(job->context, job->def, job->extinction, reduced, absorption, thick);
    if (result != TY_OK || thick->count == 0) return result;
    ty_arena arena = {0};
    lay_out(job, &arena);
    job->skin_bytes = arena.used;
    job->skin_memory = ty_alloc_array(job->context, job->skin_bytes, 1, true);
    if (job->skin_memory == NULL) return TY_ERROR_MEMORY;
    arena = (ty_arena){.base = job->skin_memory};
    lay_out(job, &arena);
    job->stats->bytes += (double)(job->skin_bytes + thick->bytes + thick->side_bytes);
    for (int32_t i = 0; i < thick->skin_count; ++i) {
        const ty_interface_face* skin = &thick->skins[i];
        if (!skin->outer) continue;
        const float in = inflow_of(job->def, skin->face);
        for (int32_t k = 0; k < job->depth; ++k) job->skin_arrived[k][i] = in;
        job->skin_inflow += SQRT_4PI * (double)in * area_of(job->def, skin->face);
    }
    return TY_OK;
}

void ty_ordinates_diffusive_free(ty_ordinates_job* job) {
    ty_diffusive_cells_free(&job->thick);
    if (job->skin_memory != NULL) ty_free_array(job->context, job->skin_memory, job->skin_bytes, 1);
}

void ty_ordinates_diffusive_begin(ty_ordinates_job* job) {
    const ty_diffusive_cells* thick = &job->thick;
    for (int32_t i = 0; i < thick->skin_count; ++i) {
        const ty_interface_face* skin = &thick->skins[i];
        if (skin->outer) continue;
        const int64_t thin = thick->cells[skin->cell].index + step_of(job, skin->face);
        const float* low = job->low[0] + place_of(job, thin).low;
        const float flux = job->lows > 1 ? low[term_of[skin->face / 2] * job->def->size[0]] / SQRT_3 : 0;
        job->skin_arrived[0][i] = ty_maxf(0.25f * low[0] + ((skin->face & 1) != 0 ? -0.5f : 0.5f) * flux, 0);
    }
}

/* ---- what flows out of faces ---- */

/* Irradiance on the wall at a face. */
static float onto_wall(const ty_ordinates_job* job, const ty_diffusive_cell* cell, int face, float phi) {
    const ty_ordinates_faces* walls = &job->def->walls;
    const int32_t side = TY_LINK_BOUNDARY_FACE - cell->link[face];
    const float c = conductance(job, cell, face), e = (float)(PI / SQRT_4PI) * walls->emission[side];
    return ty_outgoing_partial_current(c, phi, cell->push[face], e) /
           (1 - walls->albedo[side] * (1 - 2 * c) / (1 + 2 * c));
}

/* Through a face that no skin is, per area. low: phi. */
static float flow_inside(const ty_ordinates_job* job, const ty_diffusive_cell* cell, int face, float phi,
                         const float* low) {
    const ty_ordinates_faces* walls = &job->def->walls;
    const float c = conductance(job, cell, face);
    if (cell->link[face] != TY_LINK_DIFFUSIVE) {
        const int32_t side = TY_LINK_BOUNDARY_FACE - cell->link[face];
        const float e = (float)(PI / SQRT_4PI) * walls->emission[side];
        return (1 - walls->albedo[side]) * onto_wall(job, cell, face, phi) - e;
    }
    const int64_t next = cell->index + step_of(job, face);
    const ty_diffusive_cell* other = &job->thick.cells[job->thick.slots[next]];
    const float d = conductance(job, other, face ^ 1), there = low[place_of(job, next).low];
    return (d * (c * phi + cell->push[face]) - c * (d * there + other->push[face ^ 1])) / (c + d);
}

static float flow_out(const ty_ordinates_job* job, const ty_diffusive_cell* cell, int face, const float* low,
                      const float* arrived) {
    const float phi = low[place_of(job, cell->index).low];
    const int32_t link = cell->link[face];
    if (link < 0) return flow_inside(job, cell, face, phi, low);
    return ty_outgoing_partial_current(conductance(job, cell, face), phi, cell->push[face], arrived[link]) -
           arrived[link];
}

/* ---- sweeps ---- */

/* Of a skin, per area. */
static float sent_by(const ty_ordinates_job* job, int32_t skin) {
    const ty_interface_face* s = &job->thick.skins[skin];
    const ty_diffusive_cell* cell = &job->thick.cells[s->cell];
    const float phi = job->before[place_of(job, cell->index).low];
    return ty_maxf(0, ty_outgoing_partial_current(conductance(job, cell, s->face), phi, cell->push[s->face],
                                                  job->skin_before[skin]));
}

/* The radiance of a skin, an even part and one that goes with the cosine: P1's, as far as the medium scatters, and
 * nowhere below 0. */
static void lean(const ty_ordinates_job* job, int32_t side, int32_t skin, float out) {
    const ty_diffusive_cells* thick = &job->thick;
    const ty_interface_face* s = &thick->skins[skin];
    const float even = out / (float)PI, flow = out - job->skin_before[skin];
    const float leaning = thick->cells[s->cell].lean * (float)(0.75 / PI) * flow;
    const float along = ty_clampf(leaning, -3 * even, 1.5f * even);
    thick->sent[side] = (float)SQRT_4PI * (even - along * (2 / 3.0f));
    thick->tilt[side] = (float)(SQRT_4PI * job->def->cell[s->face / 2] / 2) * along;
}

double ty_ordinates_diffusive_emit(ty_ordinates_job* job) {
    const ty_diffusive_cells* thick = &job->thick;
    double sum = -job->skin_inflow;
    for (int32_t i = 0; i < thick->skin_count; ++i) {
        double arrived = 0;
        for (int32_t k = 0; k < job->count; ++k)
            if (job->shares[k] != 0) arrived += job->shares[k] * (double)job->skin_arrived[k][i];
        job->skin_before[i] = (float)arrived;
    }
    for (int32_t side = 0; side < thick->sides.count; ++side) {
        const int32_t source = thick->source[side], skin = TY_LINK_BOUNDARY_FACE - source;
        if (source >= 0) thick->sent[side] = job->walls_sent[source];
        if (skin < 0 || source >= 0) continue;
        const float out = sent_by(job, skin);
        lean(job, side, skin, out);
        sum += SQRT_4PI * (double)out * area_of(job->def, thick->skins[skin].face);
    }
    return sum;
}

double ty_ordinates_diffusive_receive(ty_ordinates_job* job) {
    const ty_diffusive_cells* thick = &job->thick;
    float *skins = job->skin_arrived[job->latest], *walls = job->walls_arrived[job->latest];
    double sum = 0;
    if (thick->count > 0 && walls != NULL) memset(walls, 0, sizeof *walls * (size_t)job->def->walls.count);
    for (int32_t side = 0; side < thick->sides.count; ++side) {
        const int32_t source = thick->source[side];
        const float arrived = thick->sides.incident_power[side];
        if (source >= 0) walls[source] = arrived;
        if (source > TY_LINK_BOUNDARY_FACE) continue;
        const int32_t skin = TY_LINK_BOUNDARY_FACE - source;
        skins[skin] = arrived / (float)(SQRT_4PI * area_of(job->def, thick->skins[skin].face));
        sum += (double)arrived;
    }
    return sum;
}

double ty_ordinates_diffusive_leakage(const ty_ordinates_job* job) {
    const ty_diffusive_cells* thick = &job->thick;
    double sum = 0;
    for (int32_t i = 0; i < thick->skin_count; ++i)
        if (thick->skins[i].outer) sum += SQRT_4PI * (double)sent_by(job, i) * area_of(job->def, thick->skins[i].face);
    return sum;
}

/* ---- corrections ---- */

/* What P1 has on both sides of a skin: c of the thick cell and of the other. */
typedef struct skin_place {
    const ty_diffusive_cell* cell;
    thick_place thick, thin;
    float c, other, edge;
} skin_place;

static skin_place skin_of(const ty_ordinates_job* job, int32_t skin) {
    const ty_interface_face* s = &job->thick.skins[skin];
    skin_place p = {.cell = &job->thick.cells[s->cell], .edge = (float)job->def->cell[s->face / 2]};
    p.thick = place_of(job, p.cell->index);
    p.thin = place_of(job, p.cell->index + step_of(job, s->face));
    p.c = conductance(job, p.cell, s->face);
    p.other = 2 * ty_dsa_diffusivity(job->correction)[p.thin.box] / p.edge;
    return p;
}

static double add_source(float* f, float more) {
    const float was = *f;
    *f += more;
    return (double)*f * (double)*f - (double)was * (double)was;
}

/* A skin sends more than it did by a share of what arrives on it more than it did. In the correction that is a source
 * on the face, which must not flow back into the thick cell: its balance knows already. first: all that it sends of
 * what is pushed there. */
static double skins_excess(ty_ordinates_job* job, bool first) {
    const ty_diffusive_cells* thick = &job->thick;
    float* f = ty_dsa_source(job->correction);
    double squares = 0;
    for (int32_t i = 0; i < thick->skin_count; ++i) {
        if (thick->skins[i].outer) continue;
        const skin_place p = skin_of(job, i);
        const float more = first ? 0 : job->skin_arrived[job->latest][i] - job->skin_before[i];
        const float source = first ? p.cell->push[thick->skins[i].face] : (1 - 2 * p.c) * more;
        const float share = p.other / (p.c + p.other);
        if (first) job->skin_arrived[job->latest][i] = 0;
        job->skin_excess[i] = source;
        squares += add_source(f + p.thin.box, share * source / p.edge);
        squares += add_source(f + p.thick.box, (source / (1 + 2 * p.c) - share * source) / p.edge);
    }
    return squares;
}

/* What is amiss of cells' balances, with what arrived. */
static void excess_plane(void* user, int64_t z, int32_t worker) {
    (void)worker;
    ty_ordinates_job* job = user;
    const ty_ordinates_def* def = job->def;
    const float *low = job->low[job->latest], *arrived = job->skin_arrived[job->latest];
    double squares = 0;
    for (int32_t i = job->thick.first[z]; i < job->thick.first[z + 1]; ++i) {
        const ty_diffusive_cell* cell = &job->thick.cells[i];
        const thick_place at = place_of(job, cell->index);
        float more = def->source[0][cell->index];
        more -= (def->extinction[cell->index] - def->scattering[cell->index]) * low[at.low];
        for (int face = 0; face < 6; ++face)
            more -= flow_out(job, cell, face, low, arrived) / (float)def->cell[face / 2];
        squares += add_source(ty_dsa_source(job->correction) + at.box, more);
    }
    job->sums[z] = (ty_ordinates_sums){.change = squares};
}

double ty_ordinates_diffusive_residual(ty_ordinates_job* job, bool first) {
    if (job->thick.count == 0) return 0;
    const double squares = skins_excess(job, first);
    ty_ordinates_planes(job, excess_plane, job);
    return squares + ty_ordinates_total(job).change;
}

void ty_ordinates_diffusive_reach_faces(ty_ordinates_job* job) {
    const float* low = job->low[job->latest];
    for (int32_t i = 0; job->def->walls.count > 0 && i < job->thick.count; ++i) {
        const ty_diffusive_cell* cell = &job->thick.cells[i];
        const float phi = low[place_of(job, cell->index).low];
        for (int face = 0; face < 6; ++face)
            if (cell->link[face] <= TY_LINK_BOUNDARY_FACE)
                job->walls_arrived[job->latest][TY_LINK_BOUNDARY_FACE - cell->link[face]] =
                    (float)SQRT_4PI * onto_wall(job, cell, face, phi);
    }
}

void ty_ordinates_diffusive_correct(ty_ordinates_job* job, const float* e) {
    for (int32_t i = 0; i < job->thick.skin_count; ++i) {
        if (job->thick.skins[i].outer) continue;
        const skin_place p = skin_of(job, i);
        const float thin = e[p.thin.box], thick = e[p.thick.box];
        const float face = (p.other * thin + p.c * thick + job->skin_excess[i]) / (p.other + p.c);
        job->skin_arrived[job->latest][i] += 0.25f * face + 0.5f * p.other * (thin - face);
    }
    ty_ordinates_diffusive_reach_faces(job);
}

void ty_ordinates_diffusive_compare(ty_ordinates_job* job, ty_ordinates_sums* sums) {
    const float *arrived = job->skin_arrived[job->latest], *before = job->skin_before;
    float* changes = job->skin_changes[job->latest];
    /* In even light a quarter of the fluence arrives. */
    for (int32_t i = 0; i < job->thick.skin_count; ++i) {
        changes[i] = 4 * (arrived[i] - before[i]);
        sums->change += (double)changes[i] * (double)changes[i];
        sums->fluence += 16 * (double)arrived[i] * (double)arrived[i];
    }
    for (int32_t k = 0; k < job->count; ++k)
        for (int32_t i = 0; i < job->thick.skin_count; ++i)
            sums->products[k] += (double)changes[i] * (double)job->skin_changes[k][i];
}

/* ---- what comes out ---- */

typedef struct fill_loop {
    const ty_ordinates_job* job;
    float *cells, *seen;
    int32_t terms;
} fill_loop;

static void fill_plane(void* user, int64_t z, int32_t worker) {
    (void)worker;
    const fill_loop* l = user;
    const ty_ordinates_job* job = l->job;
    const float *low = job->low[job->latest], *arrived = job->skin_arrived[job->latest];
    for (int32_t i = job->thick.first[z]; i < job->thick.first[z + 1]; ++i) {
        const ty_diffusive_cell* cell = &job->thick.cells[i];
        float* to = l->cells + (size_t)cell->index * (size_t)l->terms;
        memset(to, 0, sizeof *to * (size_t)l->terms);
        to[0] = low[place_of(job, cell->index).low];
        for (int face = 0; l->seen != NULL && face < 6; ++face) {
            const int32_t skin = cell->link[face];
            if (skin < 0) continue;
            const float leaving = flow_out(job, cell, face, low, arrived) + arrived[skin];
            l->seen[6 * (size_t)cell->index + (size_t)face] = 4 * ty_maxf(leaving, 0);
        }
        for (int axis = 0; axis < 3 && l->terms > 1; ++axis)
            to[term_of[axis]] =
                0.5f * SQRT_3 *
                (flow_out(job, cell, 2 * axis + 1, low, arrived) - flow_out(job, cell, 2 * axis, low, arrived));
    }
}

void ty_ordinates_diffusive_fill(const ty_ordinates_job* job, float* cells, int32_t terms) {
    float* seen = job->def->seen;
    for (int64_t i = 0; seen != NULL && i < 6 * job->cells; ++i) seen[i] = -1;
    if (job->thick.count == 0) return;
    fill_loop l = {.job = job, .cells = cells, .seen = seen, .terms = terms};
    ty_ordinates_planes(job, fill_plane, &l);
}
