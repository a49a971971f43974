/* Scattered light of an interior by diffusion with the partial-reflection boundary. */
#include "base/constants.h"
#include "base/context.h"
#include "solve/diffusion/diffusion.h"
#include "solve/enclosed/body.h"
#include "solve/ordinates/dsa.h"

#include <math.h>
#include <string.h>

/* Reduction of the residual, and multigrid cycles at most. */
static const double reduction = 1e-4;
enum { CYCLES = 60 };

typedef struct channel {
    ty_enclosed_body* body;
    int c;
    ty_dsa* dsa;
    ty_ordinates_faces walls;
    float *reduced, *absorption; /* planes of cells */
} channel;

/* Index of a cell in the solver's arrays. */
static ptrdiff_t box_index(const channel* ch, size_t cell) {
    const int32_t* size = ch->body->size;
    const size_t row = cell / (size_t)size[0];
    return ty_box_at(ty_dsa_box(ch->dsa), (int32_t)(row % (size_t)size[1]), (int32_t)(row / (size_t)size[1])) +
           (ptrdiff_t)(cell % (size_t)size[0]);
}

static float uncollided_fluence(const channel* ch, size_t cell) {
    const size_t at = cell * (size_t)ch->body->terms;
    return (float)TY_SQRT_4PI_F64 * (ch->body->of_lights[ch->c][at] + ch->body->of_surfaces[ch->c][at]);
}

/* Number of a cell's sides. */
static int32_t sides_of(const ty_enclosed_body* body, int32_t side) {
    int32_t count = 0;
    for (int32_t i = side; i >= 0 && body->sides[i].cell == body->sides[side].cell; --i) ++count;
    for (int32_t i = side + 1; i < body->side_count && body->sides[i].cell == body->sides[side].cell; ++i) ++count;
    return count;
}

/* Takes the part of the source that leaves before it fills its cell from the cells beside the surface: light collides
 * within a free path behind a face, and not at the center of a thick cell. Of a source that falls off as exp(-sigma' z)
 * the fraction 1 - (1 - exp(-x)) / x, x = sigma' h / 2, counts as on the face, as a linear fluence between face and
 * center divides it; from there it leaves through the interface or enters the half cell, in proportion to their
 * conductances. */
static void offset_faces(const channel* ch) {
    const ty_enclosed_body* body = ch->body;
    float *f = ty_dsa_source(ch->dsa), *offset = ty_dsa_face_offset(ch->dsa);
    const float *slope = ty_dsa_face_slope(ch->dsa), *d = ty_dsa_diffusivity(ch->dsa);
    for (int32_t i = 0; i < body->side_count; ++i) {
        offset[i] = 0;
        if (body->sides[i].cell < 0) continue;
        const ptrdiff_t at = box_index(ch, (size_t)body->sides[i].cell);
        const float edge = (float)body->cell[body->face[i] / 2], x = edge / (6 * d[at]);
        const float on_face = x > 1e-3f ? 1 - (1 - expf(-x)) / x : x / 2;
        offset[i] = f[at] * edge * on_face / (float)sides_of(body, i) * slope[i] * edge / (2 * d[at]);
    }
    for (int32_t i = 0; i < body->side_count; ++i)
        if (body->sides[i].cell >= 0)
            f[box_index(ch, (size_t)body->sides[i].cell)] -= offset[i] / (float)body->cell[body->face[i] / 2];
}

/* Writes the source (sigma_s - g sigma_s) Phi; returns its sum of squares. */
static double set_source(const channel* ch) {
    const ty_enclosed_body* body = ch->body;
    float* f = ty_dsa_source(ch->dsa);
    double squares = 0;
    for (size_t i = 0; i < body->cells; ++i)
        f[box_index(ch, i)] = (1 - body->forward[ch->c]) * body->scattering[ch->c][i] * uncollided_fluence(ch, i);
    offset_faces(ch);
    for (size_t i = 0; i < body->cells; ++i) {
        const double q = (double)f[box_index(ch, i)];
        squares += q * q;
    }
    return squares;
}

/* ---- results ---- */

/* Adds half the flow through a cell's face to its flux moment along the axis. */
static void add_flow(const channel* ch, size_t cell, int axis, float flow) {
    static const size_t terms[3] = {3, 1, 2};
    ch->body->solved[ch->c][terms[axis] * ch->body->cells + cell] += 0.5f * flow * (float)(sqrt(3) / TY_SQRT_4PI_F64);
}

static void add_flows_between(const channel* ch, size_t cell, const float* phi) {
    const ty_enclosed_body* body = ch->body;
    const size_t steps[3] = {1, (size_t)body->size[0], (size_t)body->size[0] * (size_t)body->size[1]};
    const float* d = ty_dsa_diffusivity(ch->dsa);
    for (int a = 0; a < 3; ++a) {
        const bool last = cell / steps[a] % (size_t)body->size[a] == (size_t)body->size[a] - 1;
        if (last || body->inside[cell + steps[a]] == 0) continue;
        const ptrdiff_t here = box_index(ch, cell), there = box_index(ch, cell + steps[a]);
        const float series = 2 * d[here] * d[there] / (d[here] + d[there]);
        const float flow = series * (phi[here] - phi[there]) / (float)body->cell[a];
        add_flow(ch, cell, a, flow);
        add_flow(ch, cell + steps[a], a, flow);
    }
}

/* Fluence and flux as moments, and the balance. */
static void take_results(channel* ch, ty_enclosed_stats* stats) {
    ty_enclosed_body* body = ch->body;
    const float *phi = ty_dsa_fluence(ch->dsa), *slope = ty_dsa_face_slope(ch->dsa);
    const float* offset = ty_dsa_face_offset(ch->dsa);
    const double volume = body->cell[0] * body->cell[1] * body->cell[2];
    double absorbed = 0, leaving = 0;
    memset(body->solved[ch->c], 0, sizeof(float) * body->cells * (size_t)body->terms);
    for (size_t i = 0; i < body->cells; ++i) {
        if (body->inside[i] == 0) continue;
        const float here = phi[box_index(ch, i)];
        body->solved[ch->c][i] = here / (float)TY_SQRT_4PI_F64;
        absorbed += (double)ch->absorption[i] * (double)(here + uncollided_fluence(ch, i)) * volume;
        add_flows_between(ch, i, phi);
    }
    for (int32_t i = 0; i < body->side_count; ++i) {
        const int axis = body->face[i] / 2;
        if (body->sides[i].cell < 0) continue;
        const size_t cell = (size_t)body->sides[i].cell;
        const float flow = slope[i] * phi[box_index(ch, cell)] + offset[i];
        leaving += (double)flow * volume / body->cell[axis];
        body->exitance[ch->c][i] = flow;
        add_flow(ch, cell, axis, (body->face[i] & 1) != 0 ? flow : -flow);
    }
    stats->absorbed[ch->c] += absorbed;
    stats->leaving[ch->c] += leaving + body->leaving[0][ch->c] + body->leaving[1][ch->c];
}

static ty_result solve_channel(channel* ch, ty_enclosed_stats* stats) {
    ty_enclosed_body* body = ch->body;
    ty_diffusion_def def = ty_default_diffusion_def();
    memcpy(def.size, body->size, sizeof def.size);
    memcpy(def.cell, body->cell, sizeof def.cell);
    for (size_t i = 0; i < body->cells; ++i) {
        ch->reduced[i] = ty_enclosed_scaled(body, ch->c, i);
        ch->absorption[i] = body->extinction[ch->c][i] - body->scattering[ch->c][i];
    }
    def.extinction = ch->reduced;
    def.absorption = ch->absorption;
    const ty_result result = ty_dsa_create(body->context, &def, &ch->walls, NULL, &ch->dsa);
    if (result != TY_OK) return result;
    ty_dsa_solve(ch->dsa, set_source(ch), reduction, CYCLES);
    take_results(ch, stats);
    stats->sweeps += ty_dsa_cycles(ch->dsa);
    ty_dsa_destroy(ch->dsa);
    ch->dsa = NULL;
    return TY_OK;
}

ty_result ty_enclosed_solve_diffusion(ty_enclosed_body* body, ty_enclosed_stats* stats) {
    float* planes = ty_alloc_array(body->context, body->cells, 2 * sizeof(float), false);
    channel ch = {.body = body,
                  .walls = {.count = body->side_count,
                            .first = body->first,
                            .x = body->x,
                            .face = body->face,
                            .albedo = body->albedo,
                            .emission = body->emission},
                  .reduced = planes};
    ty_result result = planes != NULL ? TY_OK : TY_ERROR_MEMORY;
    if (planes != NULL) ch.absorption = planes + body->cells;
    for (ch.c = 0; ch.c < 3 && result == TY_OK; ++ch.c) result = solve_channel(&ch, stats);
    ty_free_array(body->context, planes, body->cells, 2 * sizeof(float));
    return result;
}
