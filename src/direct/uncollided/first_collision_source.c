#include "direct/uncollided/first_collision_source.h"

enum { CHUNK = 1 << 15 };

void ty_scaled_extinction(const ty_grid_medium* medium, int32_t order, float* const planes[3]) {
    for (int32_t p = 0; p < medium->planes; ++p)
        for (size_t i = 0; i < medium->cells; ++i) {
            const float g = ty_maxf(medium->g[p][i], 0.0f);
            const float kept_fraction = order == 0 ? 0.0f : order == 1 ? g : g * g;
            planes[p][i] = ty_maxf(0.0f, medium->extinction[p][i] - kept_fraction * medium->scattering[p][i]);
        }
}

typedef struct source_job {
    const ty_grid_medium* medium;
    const ty_light_fluence* lights;
    int32_t count, channel;
    bool reduced;
    float* out;
} source_job;

static void find_chunk(void* user, int64_t index, int32_t worker) {
    (void)worker;
    const source_job* job = user;
    const ty_grid_medium* medium = job->medium;
    const int32_t plane = medium->planes == 3 ? job->channel : 0;
    const float* scattering = medium->scattering[plane];
    const float* g = medium->g[plane];
    const size_t begin = (size_t)index * CHUNK;
    const size_t end = medium->cells - begin < CHUNK ? medium->cells : begin + CHUNK;
    for (size_t i = begin; i < end; ++i) job->out[i] = 0;
    for (int32_t l = 0; l < job->count; ++l) {
        float factor;
        const float* fluence = ty_light_fluence_plane(&job->lights[l], job->channel, &factor);
        for (size_t i = begin; i < end; ++i) job->out[i] += factor * fluence[i];
    }
    for (size_t i = begin; i < end; ++i)
        job->out[i] *= ty_reduced_scattering(scattering[i], job->reduced ? g[i] : 0.0f);
}

void ty_first_collision_source(const ty_grid_medium* medium, const ty_light_fluence* lights, int32_t count,
                               int32_t channel, bool reduced, float* out) {
    source_job job = {medium, lights, count, channel, reduced, out};
    ty_parallel_for(medium->context, (int64_t)((medium->cells + CHUNK - 1) / CHUNK), find_chunk, &job);
}
