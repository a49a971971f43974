/* Diffusive cells within discrete ordinates. The sweep treats them as reflecting faces emitting phi of the mixed
 * iterate; the incident partial current on their interfaces is part of an iterate, as on boundary faces. The imbalance
 * of a diffusive cell goes directly into the DSA source, so no cancellation of large numbers is needed, and no wave
 * passes such cells. Quantities are in units of the first harmonic (over sqrt(4 pi)), except those of the sweep. */
#include "base/constants.h"
#include "base/context.h"
#include "base/kernel.h"
#include "solve/ordinates/job.h"

#include <math.h>
#include <string.h>

#define SQRT_3 1.7320508075688772f

/* Index of the P1 term along an axis. */
static const int32_t term_of[3] = {3, 1, 2};

/* Offsets of a cell in low-order arrays (its flux terms follow at one row each) and in DSA arrays. */
typedef struct cell_offsets {
    ptrdiff_t low_order, box;
} cell_offsets;

static cell_offsets offsets_of(const ty_ordinates_job* job, int64_t cell) {
    const int32_t* size = job->def->size;
    const ptrdiff_t row = (ptrdiff_t)(cell / size[0]), x = (ptrdiff_t)(cell % size[0]);
    const ty_box* box = ty_dsa_box(job->dsa);
    return (cell_offsets){.low_order = row * size[0] * job->low_order_terms + x,
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
    const size_t bytes = sizeof(float) * (size_t)job->diffusive.interface_count;
    job->interface_current_mixed = ty_arena_take(arena, bytes);
    job->interface_residual = ty_arena_take(arena, bytes);
    for (int32_t i = 0; i < job->depth; ++i) {
        job->interface_current[i] = ty_arena_take(arena, bytes);
        job->interface_changes[i] = ty_arena_take(arena, bytes);
    }
}

/* Boundary irradiance of a cell's face of the box by the def. */
static float boundary_irradiance(const ty_ordinates_def* def, int32_t cell, int face) {
    const ty_boundary_radiance* boundary = &def->boundary_radiance;
    const int32_t at[3] = {cell % def->size[0], cell / def->size[0] % def->size[1],
                           cell / (def->size[0] * def->size[1])};
    if (boundary->across[0] == NULL) return 0;
    const float* radiance =
        boundary->across[face / 2] + (ptrdiff_t)ty_ordinates_patch(def, face / 2, at) * def->set->count;
    double sum = 0;
    for (int32_t d = 0; d < def->set->count; ++d) {
        const double cosine = (double)def->set->direction[face / 2][d] * ((face & 1) != 0 ? -1 : 1);
        sum += fmax(cosine, 0) * (double)def->set->weight[d] * (double)radiance[d];
    }
    return (float)(sum / TY_SQRT_4PI_F64);
}

ty_result ty_ordinates_diffusive_find(ty_ordinates_job* job, float* reduced, const float* absorption) {
    ty_diffusive_cells* diffusive = &job->diffusive;
    ty_result result = ty_diffusive_cells_find(job->context, job->def, job->extinction, reduced, absorption, diffusive);
    if (result != TY_OK || diffusive->count == 0) return result;
    ty_arena arena = {0};
    lay_out(job, &arena);
    job->interface_bytes = arena.used;
    job->interface_memory = ty_alloc_array(job->context, job->interface_bytes, 1, true);
    if (job->interface_memory == NULL) return TY_ERROR_MEMORY;
    arena = (ty_arena){.base = job->interface_memory};
    lay_out(job, &arena);
    job->stats->bytes += (double)(job->interface_bytes + diffusive->bytes + diffusive->side_bytes);
    for (int32_t i = 0; i < diffusive->interface_count; ++i) {
        const ty_interface_face* iface = &diffusive->interfaces[i];
        if (!iface->outer) continue;
        const float in = boundary_irradiance(job->def, diffusive->cells[iface->cell].index, iface->face);
        for (int32_t k = 0; k < job->depth; ++k) job->interface_current[k][i] = in;
        job->interface_inflow += TY_SQRT_4PI_F64 * (double)in * area_of(job->def, iface->face);
    }
    return TY_OK;
}

void ty_ordinates_diffusive_free(ty_ordinates_job* job) {
    ty_diffusive_cells_free(&job->diffusive);
    if (job->interface_memory != NULL) ty_free_array(job->context, job->interface_memory, job->interface_bytes, 1);
}

void ty_ordinates_diffusive_begin(ty_ordinates_job* job) {
    const ty_diffusive_cells* diffusive = &job->diffusive;
    for (int32_t i = 0; i < diffusive->interface_count; ++i) {
        const ty_interface_face* iface = &diffusive->interfaces[i];
        if (iface->outer) continue;
        const int64_t transport = diffusive->cells[iface->cell].index + step_of(job, iface->face);
        const float* low_order = job->low_order[0] + offsets_of(job, transport).low_order;
        const float flux =
            job->low_order_terms > 1 ? low_order[term_of[iface->face / 2] * job->def->size[0]] / SQRT_3 : 0;
        job->interface_current[0][i] =
            ty_maxf(0.25f * low_order[0] + ((iface->face & 1) != 0 ? -0.5f : 0.5f) * flux, 0);
    }
}

/* ---- outflow through faces ---- */

/* Irradiance of the boundary face. */
static float wall_irradiance(const ty_ordinates_job* job, const ty_diffusive_cell* cell, int face, float phi) {
    const ty_ordinates_faces* walls = &job->def->walls;
    const int32_t side = TY_LINK_BOUNDARY_FACE - cell->link[face];
    const float c = conductance(job, cell, face), e = (float)(TY_PI_F64 / TY_SQRT_4PI_F64) * walls->emission[side];
    return ty_outgoing_partial_current(c, phi, cell->interface_source[face], e) /
           (1 - walls->albedo[side] * (1 - 2 * c) / (1 + 2 * c));
}

/* Net outflow per area through a face that is not an interface. */
static float flow_without_interface(const ty_ordinates_job* job, const ty_diffusive_cell* cell, int face, float phi,
                                    const float* low_order) {
    const ty_ordinates_faces* walls = &job->def->walls;
    const float c = conductance(job, cell, face);
    if (cell->link[face] != TY_LINK_DIFFUSIVE) {
        const int32_t side = TY_LINK_BOUNDARY_FACE - cell->link[face];
        const float e = (float)(TY_PI_F64 / TY_SQRT_4PI_F64) * walls->emission[side];
        return (1 - walls->albedo[side]) * wall_irradiance(job, cell, face, phi) - e;
    }
    const int64_t next = cell->index + step_of(job, face);
    const ty_diffusive_cell* other = &job->diffusive.cells[job->diffusive.slots[next]];
    const float d = conductance(job, other, face ^ 1), there = low_order[offsets_of(job, next).low_order];
    return (d * (c * phi + cell->interface_source[face]) - c * (d * there + other->interface_source[face ^ 1])) /
           (c + d);
}

static float flow_out(const ty_ordinates_job* job, const ty_diffusive_cell* cell, int face, const float* low_order,
                      const float* incident) {
    const float phi = low_order[offsets_of(job, cell->index).low_order];
    const int32_t link = cell->link[face];
    if (link < 0) return flow_without_interface(job, cell, face, phi, low_order);
    return ty_outgoing_partial_current(conductance(job, cell, face), phi, cell->interface_source[face],
                                       incident[link]) -
           incident[link];
}

/* ---- sweeps ---- */

/* Partial current out of an interface, per area. */
static float outgoing_current(const ty_ordinates_job* job, int32_t interface_index) {
    const ty_interface_face* s = &job->diffusive.interfaces[interface_index];
    const ty_diffusive_cell* cell = &job->diffusive.cells[s->cell];
    const float phi = job->mixed[offsets_of(job, cell->index).low_order];
    return ty_maxf(0, ty_outgoing_partial_current(conductance(job, cell, s->face), phi, cell->interface_source[s->face],
                                                  job->interface_current_mixed[interface_index]));
}

/* Radiance of an interface, isotropic plus linear in the cosine: the P1 slope, weighted by p1_weight and limited to
 * keep the radiance from being negative. */
static void set_radiance(const ty_ordinates_job* job, int32_t side, int32_t interface_index, float out) {
    const ty_diffusive_cells* diffusive = &job->diffusive;
    const ty_interface_face* s = &diffusive->interfaces[interface_index];
    const float isotropic = out / (float)TY_PI_F64, net = out - job->interface_current_mixed[interface_index];
    const float p1_slope = diffusive->cells[s->cell].p1_weight * (float)(0.75 / TY_PI_F64) * net;
    const float slope = ty_clampf(p1_slope, -3 * isotropic, 1.5f * isotropic);
    diffusive->radiance[side] = (float)TY_SQRT_4PI_F64 * (isotropic - slope * (2 / 3.0f));
    diffusive->radiance_slope[side] = (float)(TY_SQRT_4PI_F64 * job->def->cell[s->face / 2] / 2) * slope;
}

double ty_ordinates_diffusive_emit(ty_ordinates_job* job) {
    const ty_diffusive_cells* diffusive = &job->diffusive;
    double sum = -job->interface_inflow;
    for (int32_t i = 0; i < diffusive->interface_count; ++i) {
        double incident = 0;
        for (int32_t k = 0; k < job->count; ++k)
            if (job->anderson_weights[k] != 0)
                incident += job->anderson_weights[k] * (double)job->interface_current[k][i];
        job->interface_current_mixed[i] = (float)incident;
    }
    for (int32_t side = 0; side < diffusive->sides.count; ++side) {
        const int32_t source = diffusive->source[side], interface_index = TY_LINK_BOUNDARY_FACE - source;
        if (source >= 0) diffusive->radiance[side] = job->face_radiance[source];
        if (interface_index < 0 || source >= 0) continue;
        const float out = outgoing_current(job, interface_index);
        set_radiance(job, side, interface_index, out);
        sum += TY_SQRT_4PI_F64 * (double)out * area_of(job->def, diffusive->interfaces[interface_index].face);
    }
    return sum;
}

double ty_ordinates_diffusive_receive(ty_ordinates_job* job) {
    const ty_diffusive_cells* diffusive = &job->diffusive;
    float *interfaces = job->interface_current[job->latest], *walls = job->face_irradiance[job->latest];
    double sum = 0;
    if (diffusive->count > 0 && walls != NULL) memset(walls, 0, sizeof *walls * (size_t)job->def->walls.count);
    for (int32_t side = 0; side < diffusive->sides.count; ++side) {
        const int32_t source = diffusive->source[side];
        const float incident = diffusive->sides.incident_power[side];
        if (source >= 0) walls[source] = incident;
        if (source > TY_LINK_BOUNDARY_FACE) continue;
        const int32_t interface_index = TY_LINK_BOUNDARY_FACE - source;
        interfaces[interface_index] =
            incident / (float)(TY_SQRT_4PI_F64 * area_of(job->def, diffusive->interfaces[interface_index].face));
        sum += (double)incident;
    }
    return sum;
}

double ty_ordinates_diffusive_leakage(const ty_ordinates_job* job) {
    const ty_diffusive_cells* diffusive = &job->diffusive;
    double sum = 0;
    for (int32_t i = 0; i < diffusive->interface_count; ++i)
        if (diffusive->interfaces[i].outer)
            sum +=
                TY_SQRT_4PI_F64 * (double)outgoing_current(job, i) * area_of(job->def, diffusive->interfaces[i].face);
    return sum;
}

/* ---- corrections ---- */

/* P1 data on both sides of an interface: conductance of the diffusive and of the transport cell. */
typedef struct interface_cells {
    const ty_diffusive_cell* cell;
    cell_offsets diffusive, transport;
    float c, c_transport, edge;
} interface_cells;

static interface_cells make_interface(const ty_ordinates_job* job, int32_t interface_index) {
    const ty_interface_face* s = &job->diffusive.interfaces[interface_index];
    interface_cells p = {.cell = &job->diffusive.cells[s->cell], .edge = (float)job->def->cell[s->face / 2]};
    p.diffusive = offsets_of(job, p.cell->index);
    p.transport = offsets_of(job, p.cell->index + step_of(job, s->face));
    p.c = conductance(job, p.cell, s->face);
    p.c_transport = 2 * ty_dsa_diffusivity(job->dsa)[p.transport.box] / p.edge;
    return p;
}

static double add_source(float* f, float increase) {
    const float previous = *f;
    *f += increase;
    return (double)*f * (double)*f - (double)previous * (double)previous;
}

/* The interface emits a fraction of the change of its incident partial current. In DSA that is a source on the face,
 * whose flow back into the diffusive cell is subtracted, since the cell's balance already contains it. first: the
 * emission due to interface_source only. */
static double interface_residuals(ty_ordinates_job* job, bool first) {
    const ty_diffusive_cells* diffusive = &job->diffusive;
    float* f = ty_dsa_source(job->dsa);
    double squares = 0;
    for (int32_t i = 0; i < diffusive->interface_count; ++i) {
        if (diffusive->interfaces[i].outer) continue;
        const interface_cells p = make_interface(job, i);
        const float increase = first ? 0 : job->interface_current[job->latest][i] - job->interface_current_mixed[i];
        const float source = first ? p.cell->interface_source[diffusive->interfaces[i].face] : (1 - 2 * p.c) * increase;
        const float fraction = p.c_transport / (p.c + p.c_transport);
        if (first) job->interface_current[job->latest][i] = 0;
        job->interface_residual[i] = source;
        squares += add_source(f + p.transport.box, fraction * source / p.edge);
        squares += add_source(f + p.diffusive.box, (source / (1 + 2 * p.c) - fraction * source) / p.edge);
    }
    return squares;
}

/* Imbalance of the cells with the incident partial currents. */
static void residual_plane(void* user, int64_t z, int32_t worker) {
    (void)worker;
    ty_ordinates_job* job = user;
    const ty_ordinates_def* def = job->def;
    const float *low_order = job->low_order[job->latest], *incident = job->interface_current[job->latest];
    double squares = 0;
    for (int32_t i = job->diffusive.first[z]; i < job->diffusive.first[z + 1]; ++i) {
        const ty_diffusive_cell* cell = &job->diffusive.cells[i];
        const cell_offsets at = offsets_of(job, cell->index);
        float imbalance = def->source[0][cell->index];
        imbalance -= (def->extinction[cell->index] - def->scattering[cell->index]) * low_order[at.low_order];
        for (int face = 0; face < 6; ++face)
            imbalance -= flow_out(job, cell, face, low_order, incident) / (float)def->cell[face / 2];
        squares += add_source(ty_dsa_source(job->dsa) + at.box, imbalance);
    }
    job->sums[z] = (ty_ordinates_sums){.change = squares};
}

double ty_ordinates_diffusive_residual(ty_ordinates_job* job, bool first) {
    if (job->diffusive.count == 0) return 0;
    const double squares = interface_residuals(job, first);
    ty_ordinates_planes(job, residual_plane, job);
    return squares + ty_ordinates_total(job).change;
}

void ty_ordinates_diffusive_reach_faces(ty_ordinates_job* job) {
    const float* low_order = job->low_order[job->latest];
    for (int32_t i = 0; job->def->walls.count > 0 && i < job->diffusive.count; ++i) {
        const ty_diffusive_cell* cell = &job->diffusive.cells[i];
        const float phi = low_order[offsets_of(job, cell->index).low_order];
        for (int face = 0; face < 6; ++face)
            if (cell->link[face] <= TY_LINK_BOUNDARY_FACE)
                job->face_irradiance[job->latest][TY_LINK_BOUNDARY_FACE - cell->link[face]] =
                    (float)TY_SQRT_4PI_F64 * wall_irradiance(job, cell, face, phi);
    }
}

void ty_ordinates_diffusive_correct(ty_ordinates_job* job, const float* e) {
    for (int32_t i = 0; i < job->diffusive.interface_count; ++i) {
        if (job->diffusive.interfaces[i].outer) continue;
        const interface_cells p = make_interface(job, i);
        const float transport = e[p.transport.box], diffusive = e[p.diffusive.box];
        const float face =
            (p.c_transport * transport + p.c * diffusive + job->interface_residual[i]) / (p.c_transport + p.c);
        job->interface_current[job->latest][i] += 0.25f * face + 0.5f * p.c_transport * (transport - face);
    }
    ty_ordinates_diffusive_reach_faces(job);
}

void ty_ordinates_diffusive_compare(ty_ordinates_job* job, ty_ordinates_sums* sums) {
    const float *incident = job->interface_current[job->latest], *mixed = job->interface_current_mixed;
    float* changes = job->interface_changes[job->latest];
    /* In isotropic light the partial current is a quarter of the fluence. */
    for (int32_t i = 0; i < job->diffusive.interface_count; ++i) {
        changes[i] = 4 * (incident[i] - mixed[i]);
        sums->change += (double)changes[i] * (double)changes[i];
        sums->fluence += 16 * (double)incident[i] * (double)incident[i];
    }
    for (int32_t k = 0; k < job->count; ++k)
        for (int32_t i = 0; i < job->diffusive.interface_count; ++i)
            sums->products[k] += (double)changes[i] * (double)job->interface_changes[k][i];
}

/* ---- output ---- */

typedef struct fill_loop {
    const ty_ordinates_job* job;
    float *cells, *face_fluence, *face_incident;
    int32_t terms;
} fill_loop;

static void fill_plane(void* user, int64_t z, int32_t worker) {
    (void)worker;
    const fill_loop* l = user;
    const ty_ordinates_job* job = l->job;
    const float *low_order = job->low_order[job->latest], *incident = job->interface_current[job->latest];
    for (int32_t i = job->diffusive.first[z]; i < job->diffusive.first[z + 1]; ++i) {
        const ty_diffusive_cell* cell = &job->diffusive.cells[i];
        float* to = l->cells + (size_t)cell->index * (size_t)l->terms;
        memset(to, 0, sizeof *to * (size_t)l->terms);
        to[0] = low_order[offsets_of(job, cell->index).low_order];
        for (int face = 0; l->face_fluence != NULL && face < 6; ++face) {
            const int32_t interface_index = cell->link[face];
            if (interface_index < 0) continue;
            const float leaving = flow_out(job, cell, face, low_order, incident) + incident[interface_index];
            l->face_fluence[6 * (size_t)cell->index + (size_t)face] = 4 * ty_maxf(leaving, 0);
            if (l->face_incident != NULL)
                l->face_incident[6 * (size_t)cell->index + (size_t)face] = 4 * ty_maxf(incident[interface_index], 0);
        }
        for (int axis = 0; axis < 3 && l->terms > 1; ++axis)
            to[term_of[axis]] = 0.5f * SQRT_3 *
                                (flow_out(job, cell, 2 * axis + 1, low_order, incident) -
                                 flow_out(job, cell, 2 * axis, low_order, incident));
    }
}

void ty_ordinates_diffusive_fill(const ty_ordinates_job* job, float* cells, int32_t terms) {
    float* face_fluence = job->def->face_fluence;
    for (int64_t i = 0; face_fluence != NULL && i < 6 * job->cells; ++i) face_fluence[i] = -1;
    if (job->diffusive.count == 0) return;
    fill_loop l = {.job = job,
                   .cells = cells,
                   .face_fluence = face_fluence,
                   .face_incident = job->def->face_incident,
                   .terms = terms};
    ty_ordinates_planes(job, fill_plane, &l);
}
