/* Interpolation of diffuse light to finer cells, as an initial guess. */
#include "solve/diffusion/light/diffuse_light.h"

#include "base/context.h"
#include "base/kernel.h"

typedef struct prolong_job {
    const ty_diffuse_light* from;
    const float* term;
    const int32_t* size;
    float* out;
} prolong_job;

/* The two coarse cells whose centers enclose the center of a finer cell; returns the weight of the second. */
static float neighbours(int32_t index, int32_t size, int32_t from, int32_t at[2]) {
    const float position = ((float)index + 0.5f) * (float)from / (float)size - 0.5f;
    const float x = ty_clampf(position, 0.0f, (float)(from - 1));
    at[0] = (int32_t)x;
    at[1] = at[0] + 1 < from ? at[0] + 1 : at[0];
    return x - (float)at[0];
}

static void fill_plane(void* user, int64_t z, int32_t worker) {
    (void)worker;
    const prolong_job* job = user;
    const int32_t *size = job->size, *from = job->from->box.size;
    int32_t xs[2], ys[2], zs[2];
    const float weight_z = neighbours((int32_t)z, size[2], from[2], zs);
    float* out = job->out + (size_t)z * (size_t)size[0] * (size_t)size[1];
    for (int32_t y = 0; y < size[1]; ++y) {
        const float weight_y = neighbours(y, size[1], from[1], ys);
        const float* rows[4];
        for (int i = 0; i < 4; ++i)
            rows[i] = job->term + (size_t)from[0] * ((size_t)ys[i & 1] + (size_t)from[1] * (size_t)zs[i >> 1]);
        for (int32_t x = 0; x < size[0]; ++x) {
            const float weight_x = neighbours(x, size[0], from[0], xs);
            float edge[4];
            for (int i = 0; i < 4; ++i) edge[i] = ty_lerpf(rows[i][xs[0]], rows[i][xs[1]], weight_x);
            *out++ = 4 * TY_PI *
                     ty_lerpf(ty_lerpf(edge[0], edge[1], weight_y), ty_lerpf(edge[2], edge[3], weight_y), weight_z);
        }
    }
}

void ty_diffuse_light_prolong(const ty_diffuse_light* light, int32_t channel, const int32_t size[3], float* fluence) {
    prolong_job job = {light, light->terms[channel][0], size, fluence};
    ty_parallel_for(light->context, size[2], fill_plane, &job);
}
