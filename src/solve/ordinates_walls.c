/* Walls between and around the cells of discrete ordinates. What they send is that of the mixture, as the emission of
 * cells is, and what arrives on them is part of an iterate: irradiance, one number a side. */
#include "base/kernel.h"
#include "solve/ordinates_job.h"

#include <string.h>

#define PI 3.141592653589793
#define SQRT_4PI 3.5449077018110318

/* In even light the irradiance is a quarter of the fluence, which is sqrt(4 pi) times the first harmonic: what makes a
 * side's number count as a cell's. */
static const double to_harmonic = 4 / SQRT_4PI;

void ty_ordinates_walls_lay_out(ty_ordinates_job* job, ty_arena* arena) {
    const size_t bytes = sizeof(float) * (size_t)job->def->walls.count;
    if (bytes == 0) return;
    job->walls_sent = ty_arena_take(arena, bytes);
    job->walls_before = ty_arena_take(arena, bytes);
    for (int32_t i = 0; i < job->depth; ++i) {
        job->walls_arrived[i] = ty_arena_take(arena, bytes);
        job->walls_changes[i] = ty_arena_take(arena, bytes);
    }
}

double ty_ordinates_wall_area(const ty_ordinates_def* def, int32_t side) {
    const int axis = def->walls.face[side] / 2;
    return def->cell[(axis + 1) % 3] * def->cell[(axis + 2) % 3];
}

static int64_t row_of_side(const ty_ordinates_walls* walls, int32_t side, int64_t row) {
    while (walls->first[row + 1] <= side) ++row;
    return row;
}

void ty_ordinates_walls_begin(ty_ordinates_job* job) {
    const ty_ordinates_walls* walls = &job->def->walls;
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

ty_sweep_walls ty_ordinates_walls_of_sweep(ty_ordinates_job* job, int32_t iterate) {
    const ty_ordinates_walls* walls = &job->def->walls;
    return (ty_sweep_walls){.count = walls->count,
                            .first = walls->first,
                            .x = walls->x,
                            .face = walls->face,
                            .sent = job->walls_sent,
                            .arrived = job->walls_arrived[iterate]};
}

double ty_ordinates_walls_send(ty_ordinates_job* job) {
    const ty_ordinates_walls* walls = &job->def->walls;
    double sum = 0;
    for (int32_t i = 0; i < walls->count; ++i) {
        double arrived = 0;
        for (int32_t k = 0; k < job->count; ++k)
            if (job->shares[k] != 0) arrived += job->shares[k] * (double)job->walls_arrived[k][i];
        const double sent = (double)walls->emission[i] + (double)walls->albedo[i] / PI * arrived;
        job->walls_before[i] = (float)arrived;
        job->walls_sent[i] = sent > 0 ? (float)sent : 0;
        sum += PI * (double)job->walls_sent[i] * ty_ordinates_wall_area(job->def, i);
    }
    return sum;
}

double ty_ordinates_walls_take(ty_ordinates_job* job) {
    const ty_ordinates_walls* walls = &job->def->walls;
    float* arrived = job->walls_arrived[job->latest];
    double sum = 0;
    for (int32_t i = 0; i < walls->count; ++i) {
        sum += (double)arrived[i];
        arrived[i] /= (float)ty_ordinates_wall_area(job->def, i);
    }
    return sum;
}

void ty_ordinates_walls_compare(ty_ordinates_job* job, ty_ordinates_sums* sums) {
    const ty_ordinates_walls* walls = &job->def->walls;
    if (walls->count == 0) return;
    const float *arrived = job->walls_arrived[job->latest], *before = job->walls_before;
    float* changes = job->walls_changes[job->latest];
    const double square = to_harmonic * to_harmonic;
    double change = 0, light = 0;
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

void ty_ordinates_walls_balance(ty_ordinates_job* job, const float* arrived, double* emitted, double* absorbed) {
    const ty_ordinates_walls* walls = &job->def->walls;
    *emitted = *absorbed = 0;
    for (int32_t i = 0; i < walls->count; ++i) {
        const double area = ty_ordinates_wall_area(job->def, i);
        *emitted += PI * area * (double)walls->emission[i];
        *absorbed += area * (1 - (double)walls->albedo[i]) * (double)arrived[i];
    }
}
