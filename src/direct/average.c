/* Means of one cut of a box over the cells of another. */
#include "base/float_mode.h"
#include "base/context.h"
#include "direct/grid_medium.h"

#include <math.h>
#include <string.h>

typedef struct average_job {
    const float* from;
    float* to;
    int32_t from_size[3], to_size[3];
} average_job;

/* The stretch of old cells that a new one covers, and how much of the new one each end fills. */
typedef struct overlap {
    int32_t begin, end;
    double lower, upper, scale; /* of the new cell in old ones; new cells per old one */
} overlap;

static overlap overlap_of(int32_t index, int32_t from, int32_t to) {
    overlap o;
    o.scale = (double)to / from;
    o.lower = (double)index * from / to;
    o.upper = (double)(index + 1) * from / to;
    o.begin = (int32_t)floor(o.lower);
    o.end = (int32_t)ceil(o.upper);
    if (o.end > from) o.end = from;
    return o;
}

/* The share of the new cell that old cell `at` is. */
static double share_of(const overlap* o, int32_t at) {
    return (fmin(o->upper, at + 1) - fmax(o->lower, at)) * o->scale;
}

static double row_mean(const float* row, const overlap* o) {
    double sum = 0;
    for (int32_t i = o->begin; i < o->end; ++i) sum += share_of(o, i) * (double)row[i];
    return sum;
}

static void average_row(void* user, int64_t index, int32_t worker) {
    (void)worker;
    const average_job* job = user;
    const int32_t* size = job->from_size;
    const overlap y = overlap_of((int32_t)(index % job->to_size[1]), size[1], job->to_size[1]);
    const overlap z = overlap_of((int32_t)(index / job->to_size[1]), size[2], job->to_size[2]);
    const unsigned state = ty_flush_denormals();
    for (int32_t i = 0; i < job->to_size[0]; ++i) {
        const overlap x = overlap_of(i, size[0], job->to_size[0]);
        double sum = 0;
        for (int32_t k = z.begin; k < z.end; ++k)
            for (int32_t j = y.begin; j < y.end; ++j)
                sum += share_of(&y, j) * share_of(&z, k) *
                       row_mean(job->from + (size_t)size[0] * ((size_t)j + (size_t)size[1] * (size_t)k), &x);
        job->to[index * job->to_size[0] + i] = (float)sum;
    }
    ty_restore_denormals(state);
}

void ty_grid_average(ty_context* context, const float* from, const int32_t from_size[3], const int32_t to_size[3],
                     float* to) {
    average_job job = {.from = from, .to = to};
    memcpy(job.from_size, from_size, sizeof job.from_size);
    memcpy(job.to_size, to_size, sizeof job.to_size);
    ty_parallel_for(context, (int64_t)to_size[1] * to_size[2], average_row, &job);
}
