/* Light of media at a cache's points. */
#include "image/march/irradiance_gather.h"

#include "base/context.h"
#include "image/march/request.h"

typedef struct gather_job {
    const ty_march_request* request;
    const ty_irradiance_cache* cache;
    ty_irradiance_kernel kernel;
    float* out;
} gather_job;

static void gather_point(void* user, int64_t index, int32_t worker) {
    (void)worker;
    const gather_job* job = user;
    job->kernel(job->request, &job->cache->points[index], job->out + 3 * index);
}

ty_result ty_irradiance_cache_gather(ty_irradiance_cache* cache, const ty_scene* scene, const ty_march_def* march,
                                     bool emission, ty_reflected_light light) {
    ty_packed_request packed;
    ty_march_def def = *march;
    def.cache = NULL;
    ty_result result = ty_march_request_make(scene, &def, &packed);
    if (result == TY_OK) {
        packed.request.without_emission = !emission;
        gather_job job = {&packed.request, cache, TY_BEST_KERNELS(ty_irradiance_kernel), cache->irradiance[light]};
        ty_parallel_for(cache->context, cache->view.count, gather_point, &job);
        result = ty_irradiance_reflect(cache, cache->irradiance[light]);
    }
    ty_march_request_free(&packed);
    return result;
}
