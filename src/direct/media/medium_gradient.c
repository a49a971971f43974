#include "direct/media/medium_gradient.h"

#include "base/context.h"
#include "base/kernel.h"

/* Relative difference of multiples. */
static const float MAX_DIFFERENCE = 1e-6f;

bool ty_is_multiple(const float* a, const float* b, size_t count, float* factor) {
    double product = 0, square = 0;
    for (size_t i = 0; i < count; ++i) {
        product += (double)a[i] * (double)b[i];
        square += (double)b[i] * (double)b[i];
    }
    *factor = square > 0 ? (float)(product / square) : 0;
    for (size_t i = 0; i < count; ++i)
        if (fabsf(a[i] - *factor * b[i]) > MAX_DIFFERENCE * ty_maxf(fabsf(a[i]), fabsf(*factor * b[i]))) return false;
    return true;
}

ty_result ty_medium_gradient_make(const ty_grid_medium* medium, ty_medium_gradient* out) {
    *out = (ty_medium_gradient){.context = medium->context, .cells = medium->cells, .planes = medium->planes};
    for (int32_t p = 0; p < medium->planes; ++p) {
        float** const planes[] = {&out->extinction[p], &out->scattering[p], &out->scattering_g[p]};
        for (int i = 0; i < 3; ++i) {
            *planes[i] = ty_alloc_array(medium->context, medium->cells, sizeof(float), true);
            if (*planes[i] == NULL) return TY_ERROR_MEMORY;
        }
    }
    return TY_OK;
}

void ty_medium_gradient_free(ty_medium_gradient* gradient) {
    for (int32_t p = 0; p < gradient->planes; ++p) {
        ty_free_array(gradient->context, gradient->extinction[p], gradient->cells, sizeof(float));
        ty_free_array(gradient->context, gradient->scattering[p], gradient->cells, sizeof(float));
        ty_free_array(gradient->context, gradient->scattering_g[p], gradient->cells, sizeof(float));
    }
    gradient->planes = 0;
}

void ty_medium_gradient_refine(const ty_medium_gradient* coarse, const int32_t coarse_size[3], const int32_t size[3],
                               ty_medium_gradient* out) {
    for (int32_t p = 0; p < coarse->planes; ++p) {
        ty_grid_spread(out->context, coarse->extinction[p], coarse_size, size, out->extinction[p]);
        ty_grid_spread(out->context, coarse->scattering[p], coarse_size, size, out->scattering[p]);
        ty_grid_spread(out->context, coarse->scattering_g[p], coarse_size, size, out->scattering_g[p]);
    }
}
