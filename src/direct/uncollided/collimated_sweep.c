/* Sweeps of parallel light through slabs of cells. */
#include "base/context.h"
#include "base/float_mode.h"
#include "direct/uncollided/collimated.h"

/* Rows of cells that stay in the cache while all directions add to them. */
enum { BLOCK_ROWS = 16 };

/* Slabs with fewer cells times directions are swept by one thread: waking others takes longer. */
enum { CELLS_FOR_THREADS = 1 << 12 };

typedef struct pass_job {
    const ty_collimated_batch* batch;
    const float* extinction;        /* transposed where u and w change places */
    float* out[TY_TUBE_PLANES_MAX]; /* planes to add to; where transposed, blocks of TY_TRANSPOSE_SIDE slabs */
    int32_t slab;                   /* in the order of travel */
    float* scratch;                 /* of all workers */
    size_t scratch_size;            /* floats of each worker */
    ty_transpose_scratch* buffer;
    float* transposed; /* the buffer's cells; NULL: no transposition */
} pass_job;

/* ---- one slab ---- */

static size_t slab_offset(const ty_collimated* beam, int32_t slab) {
    return beam->stride[2] * (size_t)(beam->backwards ? beam->size[2] - 1 - slab : slab);
}

/* Offset of a slab's cells in job->out. */
static size_t out_offset(const pass_job* job) {
    const ty_collimated* beam = job->batch->beams;
    return job->transposed != NULL ? beam->stride[2] * (size_t)(job->slab % TY_TRANSPOSE_SIDE)
                                   : slab_offset(beam, job->slab);
}

/* Extinction of row v of a slab, or `empty` outside of the box. */
static const float* cell_row(const ty_collimated* beam, const float* slab, int32_t v, const float* empty) {
    return v >= 0 && v < beam->size[1] ? slab + beam->stride[1] * (size_t)v : empty;
}

/* Advances the row of tubes over rows v, v + 1 and v + 2 of cells, v from -2 on. writes_out: stores the transmittance
 * behind the slab, which only one block of rows may do. */
static void pass_tubes(const pass_job* job, const ty_collimated* beam, int32_t v, bool writes_out, float* scratch,
                       float* mean) {
    const int32_t slab = job->slab, width = beam->size[0] + 4;
    const float* cells = job->extinction + slab_offset(beam, slab);
    const int32_t row = v - beam->shift[1][slab] - beam->first[1];
    const int32_t column = -2 - beam->shift[0][slab] - beam->first[0];
    const size_t at = (size_t)row * (size_t)beam->tubes[0] + (size_t)column;
    ty_tube_row tubes = {
        .count = beam->size[0],
        .length = beam->length,
        .start = beam->length * (float)slab,
        .in = beam->along[slab % 2] + at,
        .out = writes_out ? beam->along[(slab + 1) % 2] + at : scratch + 6 * width,
        .mean = mean,
        .blend = scratch + width,
    };
    for (int32_t i = 0; i < 3; ++i) tubes.cells[i] = cell_row(beam, cells, v + i, scratch);
    for (int32_t i = 0; i < 2; ++i) memcpy(tubes.weight[i], beam->weight[i][slab], sizeof tubes.weight[i]);
    for (int32_t i = 0; i < TY_TUBE_RAYS && beam->hit != NULL; ++i)
        tubes.hit[i] = beam->hit + ty_collimated_tubes(beam) * (size_t)i + at;
    beam->kernels->tubes(&tubes);
}

/* Sweeps rows [begin, end) of a slab for one direction. scratch: an empty row, a row of blended extinction, three rows
 * of tubes, a row of cells, and a row of tubes for discarded output. */
static void pass_rows(const pass_job* job, int32_t index, int32_t begin, int32_t end, float* scratch) {
    const ty_collimated_batch* batch = job->batch;
    const ty_collimated* beam = &batch->beams[index];
    const int32_t width = beam->size[0] + 4;
    for (int32_t v = begin - 2; v < end; ++v) {
        float* mean[3];
        for (int32_t i = 0; i < 3; ++i) mean[i] = scratch + (2 + (v + 6 - i) % 3) * width;
        pass_tubes(job, beam, v, v >= begin || begin == 0, scratch, mean[0]);
        if (v < begin) continue;
        ty_tube_cells cells = {
            .count = beam->size[0],
            .mean = {mean[0], mean[1], mean[2]},
            .transmittance = scratch + 5 * width,
            .plane_count = batch->plane_count,
            .factor = batch->factor[index],
        };
        const size_t at = out_offset(job) + beam->stride[1] * (size_t)v;
        for (int32_t p = 0; p < batch->plane_count; ++p) cells.planes[p] = job->out[p] + at;
        for (int32_t i = 0; i < 2; ++i) memcpy(cells.weight[i], beam->weight[i][job->slab], sizeof cells.weight[i]);
        beam->kernels->cells(&cells);
    }
}

static void pass_block(void* user, int64_t block, int32_t worker) {
    const pass_job* job = user;
    const int32_t begin = (int32_t)block * BLOCK_ROWS, rows = job->batch->beams->size[1];
    const int32_t end = rows - begin < BLOCK_ROWS ? rows : begin + BLOCK_ROWS;
    const unsigned state = ty_flush_denormals();
    for (int32_t i = 0; i < job->batch->count; ++i)
        pass_rows(job, i, begin, end, job->scratch + job->scratch_size * (size_t)worker);
    ty_restore_denormals(state);
}

/* ---- transposed cells ---- */

/* Transposes the last block of slabs in layer y back, adds it to the planes, and clears it. */
static void add_transposed(void* user, int64_t y, int32_t worker) {
    (void)worker;
    const pass_job* job = user;
    const ty_collimated* beam = job->batch->beams;
    const size_t nz = (size_t)beam->size[0], ny = (size_t)beam->size[1], nx = (size_t)beam->size[2];
    const size_t first = (size_t)(job->slab / TY_TRANSPOSE_SIDE * TY_TRANSPOSE_SIDE),
                 count = (size_t)job->slab + 1 - first;
    const size_t first_column = beam->backwards ? nx - first - count : first;
    ty_transpose_block block = {.rows = (int32_t)count, .stride = nz * ny, .to_stride = nx * ny};
    block.backwards = beam->backwards;
    for (int32_t p = 0; p < job->batch->plane_count; ++p)
        for (size_t z = 0; z < nz; z += TY_TRANSPOSE_SIDE) {
            block.columns = (int32_t)(nz - z < TY_TRANSPOSE_SIDE ? nz - z : TY_TRANSPOSE_SIDE);
            block.from = job->out[p] + z + nz * (size_t)y;
            block.to = job->batch->planes[p] + first_column + nx * ((size_t)y + ny * z);
            beam->kernels->transpose(&block);
        }
}

/* ---- all slabs ---- */

static void pass_slab(pass_job* job) {
    const ty_collimated* beam = job->batch->beams;
    const int64_t blocks = (beam->size[1] + BLOCK_ROWS - 1) / BLOCK_ROWS;
    if ((int64_t)beam->size[0] * beam->size[1] * job->batch->count >= CELLS_FOR_THREADS) {
        ty_parallel_for(beam->context, blocks, pass_block, job);
        return;
    }
    for (int64_t block = 0; block < blocks; ++block) pass_block(job, block, 0);
}

static ty_result pass_slabs(pass_job* job) {
    const ty_collimated* beam = job->batch->beams;
    ty_result result = TY_OK;
    for (job->slab = 0; job->slab < beam->size[2] && result == TY_OK; ++job->slab) {
        pass_slab(job);
        if (job->transposed != NULL &&
            (job->slab % TY_TRANSPOSE_SIDE == TY_TRANSPOSE_SIDE - 1 || job->slab + 1 == beam->size[2]))
            ty_parallel_for(beam->context, beam->size[1], add_transposed, job);
        if (job->batch->progress != NULL)
            result = ty_part_show(job->batch->progress, "direct light", (double)job->slab / beam->size[2]);
    }
    return result;
}

static ty_result fill_buffer(const pass_job* job, const ty_grid_medium* medium, size_t count) {
    ty_context* context = job->batch->beams->context;
    ty_transpose_scratch* buffer = job->buffer;
    ty_transpose_scratch_free(context, buffer);
    buffer->floats = ty_alloc_array(context, count, sizeof *buffer->floats, true);
    if (buffer->floats == NULL) return TY_ERROR_MEMORY;
    buffer->count = count;
    ty_exchange_axes(context, medium->box.size, job->batch->extinction, buffer->floats, false);
    return TY_OK;
}

/* Transposes the cells where rows are along w. */
static ty_result transpose_cells(pass_job* job, const ty_grid_medium* medium) {
    const ty_collimated* beam = job->batch->beams;
    const size_t block = TY_TRANSPOSE_SIDE * (size_t)beam->size[0] * (size_t)beam->size[1];
    const size_t count = medium->cells + block * (size_t)job->batch->plane_count;
    const ty_result result = job->buffer->count < count ? fill_buffer(job, medium, count) : TY_OK;
    if (result != TY_OK) return result;
    job->transposed = job->buffer->floats;
    for (int32_t p = 0; p < job->batch->plane_count; ++p)
        job->out[p] = job->transposed + medium->cells + block * (size_t)p;
    job->extinction = job->transposed;
    return TY_OK;
}

ty_result ty_collimated_sweep(const ty_collimated_batch* beams, const ty_grid_medium* medium) {
    const ty_collimated* beam = beams->beams;
    ty_context* context = beam->context;
    ty_transpose_scratch temporary = {.floats = NULL};
    pass_job job = {.batch = beams,
                    .extinction = beams->extinction,
                    .buffer = beams->scratch != NULL ? beams->scratch : &temporary};
    memcpy(job.out, beams->planes, sizeof job.out);
    int32_t widest = 0;
    for (int32_t i = 0; i < beams->count; ++i) {
        const size_t tubes = ty_collimated_tubes(&beams->beams[i]);
        for (int side = 0; side < 2; ++side)
            for (size_t t = 0; t < tubes; ++t) beams->beams[i].along[side][t] = 1;
        if (beams->beams[i].tubes[0] > widest) widest = beams->beams[i].tubes[0];
    }
    job.scratch_size = 6 * ((size_t)beam->size[0] + 4) + (size_t)widest;
    const size_t scratch_count = job.scratch_size * (size_t)ty_context_threads(context);
    job.scratch = ty_alloc_array(context, scratch_count, sizeof *job.scratch, true);
    ty_result result = job.scratch != NULL ? TY_OK : TY_ERROR_MEMORY;
    if (result == TY_OK && beam->axis[2] == 0) result = transpose_cells(&job, medium);
    if (result == TY_OK) result = pass_slabs(&job);
    ty_transpose_scratch_free(context, &temporary);
    ty_free_array(context, job.scratch, scratch_count, sizeof *job.scratch);
    return result;
}

/* ---- power ---- */

/* The last slab in which a tube's column (or row) overlaps cells; -1: none. */
static int32_t last_slab(const ty_collimated* beam, int32_t i, int32_t tube) {
    int32_t last = -1;
    for (int32_t slab = 0; slab < beam->size[2]; ++slab) {
        const int32_t cell = tube + beam->first[i] + beam->shift[i][slab];
        if (cell >= -2 && cell < beam->size[i]) last = slab;
    }
    return last;
}

/* Tubes start with transmittance 1 and keep the one behind their last slab; surfaces are ignored. */
ty_result ty_collimated_power_of(const ty_collimated* beam, double power[2]) {
    int32_t* last = ty_alloc_array(beam->context, (size_t)beam->tubes[0], sizeof *last, false);
    if (last == NULL) return TY_ERROR_MEMORY;
    for (int32_t column = 0; column < beam->tubes[0]; ++column) last[column] = last_slab(beam, 0, column);
    double sum = 0;
    for (int32_t row = 0; row < beam->tubes[1]; ++row) {
        const int32_t of_row = last_slab(beam, 1, row);
        for (int32_t column = 0; column < beam->tubes[0]; ++column) {
            const int32_t slab = last[column] < of_row ? last[column] : of_row;
            sum += (double)beam->along[(slab + 1) % 2][(size_t)row * (size_t)beam->tubes[0] + (size_t)column];
        }
    }
    ty_free_array(beam->context, last, (size_t)beam->tubes[0], sizeof *last);
    power[0] = beam->section * (double)ty_collimated_tubes(beam);
    power[1] = beam->section * sum;
    return TY_OK;
}
