/* Cells that a surface cuts belong to one side of it, that of their middles. What scatters in the rest of them for the
 * first time is a source of the cell that the rest is before. */
#include "base/context.h"
#include "direct/cover.h"
#include "method/dom/job.h"

#include <string.h>

/* Uncollided fluence, mean of the channels. */
typedef struct cut_job {
    ty_dom_job* job;
    float *fine, *mean; /* of fine cells, and of cells of ordinates */
} cut_job;

static void sum_lights(const ty_dom* light, size_t cells, float* sum) {
    memset(sum, 0, cells * sizeof *sum);
    for (int32_t l = 0; l < light->light_count; ++l)
        for (int c = 0; c < 3; ++c) {
            float factor;
            const float* plane = ty_single_plane(&light->lights[l], c, &factor);
            for (size_t i = 0; i < cells; ++i) sum[i] += factor * plane[i];
        }
}

/* In the middle of a cell. */
static float middle_of(const cut_job* cut, const int32_t cell[3]) {
    const ty_dom* light = cut->job->light;
    size_t at = 0;
    for (int a = 2; a >= 0; --a) {
        const int32_t size = light->fine_box.size[a];
        const double place = (cell[a] + 0.5) * size / light->box.size[a];
        at = at * (size_t)size + (size_t)(place < size - 1 ? place : size - 1);
    }
    return cut->fine[at];
}

/* Of what scatters in a cell, the part on its side of the surfaces that cut it; *beyond: sum of the parts of the cell
 * behind them. */
static float own_part(const cut_job* cut, const int32_t cell[3], size_t at, int32_t first, int32_t end, float* beyond) {
    const ty_walls* walls = cut->job->walls;
    float volume = 1;
    *beyond = 0;
    for (int32_t side = first; side < end; ++side) {
        const float behind = ty_maxf(0, 0.5f - walls->sides[side].depth);
        volume *= 1 - behind;
        *beyond += behind;
    }
    if (!(cut->mean[at] > 0)) return 1;
    return ty_minf(1, volume * middle_of(cut, cell) / cut->mean[at]);
}

/* Gives a share of a cell's source to the one behind a face. */
static void give(const cut_job* cut, size_t at, size_t next, float share) {
    const ty_dom* light = cut->job->light;
    const size_t terms = (size_t)(light->bands * light->bands);
    for (int32_t c = 0; c < ty_dom_channels(light); ++c)
        for (size_t t = 0; t < terms; ++t) {
            float* source = cut->job->source[c] + t * light->cells;
            source[next] += share * source[at];
        }
}

static void keep(const cut_job* cut, size_t at, float share) {
    const ty_dom* light = cut->job->light;
    const size_t terms = (size_t)(light->bands * light->bands);
    for (int32_t c = 0; c < ty_dom_channels(light); ++c)
        for (size_t t = 0; t < terms; ++t) cut->job->source[c][t * light->cells + at] *= share;
}

/* The sides [first, end) are those of one cell. */
static void cut_cell(const cut_job* cut, const int32_t cell[3], size_t at, int32_t first, int32_t end) {
    const ty_walls* walls = cut->job->walls;
    const int32_t* size = walls->size;
    const ptrdiff_t steps[3] = {1, size[0], (ptrdiff_t)size[0] * size[1]};
    float beyond, given = 0;
    const float own = own_part(cut, cell, at, first, end, &beyond);
    if (!(beyond > 0) || own >= 1) return;
    for (int32_t side = first; side < end; ++side) {
        const int axis = walls->face[side] / 2, way = (walls->face[side] & 1) != 0 ? 1 : -1;
        const float behind = ty_maxf(0, 0.5f - walls->sides[side].depth);
        if (!(behind > 0) || cell[axis] + way < 0 || cell[axis] + way >= size[axis]) continue;
        give(cut, at, (size_t)((ptrdiff_t)at + way * steps[axis]), (1 - own) * behind / beyond);
        given += behind / beyond;
    }
    keep(cut, at, 1 - (1 - own) * given);
}

static void cut_cells(const cut_job* cut) {
    const ty_walls* walls = cut->job->walls;
    const int64_t rows = (int64_t)walls->size[1] * walls->size[2];
    for (int64_t row = 0; row < rows; ++row)
        for (int32_t side = walls->first[row], end; side < walls->first[row + 1]; side = end) {
            const int32_t cell[3] = {walls->x[side], (int32_t)(row % walls->size[1]), (int32_t)(row / walls->size[1])};
            for (end = side; end < walls->first[row + 1] && walls->x[end] == cell[0];) ++end;
            cut_cell(cut, cell, (size_t)row * (size_t)walls->size[0] + (size_t)cell[0], side, end);
        }
}

ty_result ty_dom_cut_sources(ty_dom_job* job) {
    const ty_dom* light = job->light;
    const size_t cells = job->fine->cells;
    cut_job cut = {.job = job,
                   .fine = ty_alloc_array(job->context, cells, sizeof(float), false),
                   .mean = ty_alloc_array(job->context, light->cells, sizeof(float), false)};
    const bool whole = cut.fine != NULL && cut.mean != NULL;
    if (whole) {
        sum_lights(light, cells, cut.fine);
        ty_grid_average(job->context, cut.fine, light->fine_box.size, light->box.size, cut.mean);
        cut_cells(&cut);
    }
    ty_free_array(job->context, cut.fine, cells, sizeof(float));
    ty_free_array(job->context, cut.mean, light->cells, sizeof(float));
    return whole ? TY_OK : TY_ERROR_MEMORY;
}
