/* The image's channels while it is being rendered. */
#include "method/lpv/image/output_planes.h"

#include "base/context.h"
#include "base/parallel.h"
#include "image/aovs.h"

#include <math.h>
#include <tyndall/path.h>

ty_result ty_lpv_output_planes_create(ty_context* context, int32_t width, int32_t height, uint32_t aovs,
                                      ty_lpv_output_planes* planes) {
    const char* names[TY_AOV_CHANNELS_MAX];
    const int32_t count = ty_aov_names(aovs, names);
    *planes = (ty_lpv_output_planes){.context = context, .width = width, .height = height};
    const ty_result result = ty_image_create(context, width, height, count, names, &planes->image);
    if (result != TY_OK) return result;
    float** const of[TY_AOV_GROUPS] = {
        planes->color,  NULL,           planes->transmittance, planes->depth, planes->normal,
        planes->albedo, planes->single, planes->multiple,      NULL};
    int32_t channel = 0;
    for (int g = 0; g < TY_AOV_GROUPS; ++g)
        for (int c = 0; ty_aov_is_requested(&ty_aov_groups[g], aovs) && c < ty_aov_groups[g].count; ++c) {
            float* plane = ty_image_plane(planes->image, channel++);
            if (of[g] != NULL) of[g][c] = plane;
        }
    if ((aovs & TY_AOV_DEPTH) == 0) return TY_OK;
    planes->hits = ty_alloc_array(context, (size_t)width * (size_t)height, sizeof(float), true);
    return planes->hits != NULL ? TY_OK : TY_ERROR_MEMORY;
}

void ty_lpv_output_planes_free(ty_lpv_output_planes* planes) {
    ty_free_array(planes->context, planes->hits, (size_t)planes->width * (size_t)planes->height, sizeof(float));
}

/* ---- from sums to means ---- */

typedef struct finish_job {
    const ty_lpv_output_planes* planes;
    int32_t samples;
} finish_job;

static void finish_normal(float* const normal[3], size_t at) {
    const float square = normal[0][at] * normal[0][at] + normal[1][at] * normal[1][at] + normal[2][at] * normal[2][at];
    for (int c = 0; c < 3; ++c) normal[c][at] = square > 0.0f ? normal[c][at] / sqrtf(square) : 0.0f;
}

static void finish_row(void* user, int64_t row, int32_t worker) {
    (void)worker;
    const finish_job* job = user;
    const ty_lpv_output_planes* planes = job->planes;
    float* const* means[] = {planes->color, planes->transmittance, planes->albedo, planes->single, planes->multiple};
    const size_t begin = (size_t)row * (size_t)planes->width, end = begin + (size_t)planes->width;
    const float per_sample = 1.0f / (float)job->samples;
    for (int m = 0; m < 5 && job->samples > 1; ++m)
        for (int c = 0; c < 3 && means[m][c] != NULL; ++c)
            for (size_t at = begin; at < end; ++at) means[m][c][at] *= per_sample;
    for (size_t at = begin; at < end && planes->normal[0] != NULL; ++at) finish_normal(planes->normal, at);
    for (size_t at = begin; at < end && planes->depth[0] != NULL; ++at)
        planes->depth[0][at] = planes->hits[at] > 0.0f ? planes->depth[0][at] / planes->hits[at] : 0.0f;
}

void ty_lpv_output_planes_finish(const ty_lpv_output_planes* planes, int32_t samples) {
    finish_job job = {planes, samples};
    ty_parallel_for(planes->context, planes->height, finish_row, &job);
}
