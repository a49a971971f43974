#include "direct/uncollided/transpose.h"

#include "base/context.h"
#include "base/parallel.h"
#include "direct/uncollided/kernel.h"

void ty_transpose_scratch_free(ty_context* context, ty_transpose_scratch* scratch) {
    ty_free_array(context, scratch->floats, scratch->count, sizeof *scratch->floats);
    *scratch = (ty_transpose_scratch){.floats = NULL};
}

typedef struct exchange_job {
    const float* from;
    float* to;
    int32_t size[3];
    bool adds;
} exchange_job;

/* Layer y, in blocks that fit the cache. */
static void exchange_layer(void* user, int64_t y, int32_t worker) {
    (void)worker;
    const exchange_job* job = user;
    const size_t nx = (size_t)job->size[0], ny = (size_t)job->size[1], nz = (size_t)job->size[2];
    for (size_t z0 = 0; z0 < nz; z0 += TY_TRANSPOSE_SIDE)
        for (size_t x0 = 0; x0 < nx; x0 += TY_TRANSPOSE_SIDE)
            for (size_t z = z0; z < nz && z < z0 + TY_TRANSPOSE_SIDE; ++z)
                for (size_t x = x0; x < nx && x < x0 + TY_TRANSPOSE_SIDE; ++x) {
                    float* to = &job->to[z + nz * ((size_t)y + ny * x)];
                    const float value = job->from[x + nx * ((size_t)y + ny * z)];
                    *to = job->adds ? *to + value : value;
                }
}

void ty_exchange_axes(ty_context* context, const int32_t size[3], const float* from, float* to, bool adds) {
    exchange_job job = {.from = from, .to = to, .size = {size[0], size[1], size[2]}, .adds = adds};
    ty_parallel_for(context, size[1], exchange_layer, &job);
}
