/* Scattered radiance of environments towards an eye. */
#ifndef TY_METHOD_DOM_SOURCES_ENVIRONMENT_H
#define TY_METHOD_DOM_SOURCES_ENVIRONMENT_H

#include "direct/single/forward.k.h"
#include "image/march/march.h"
#include "method/dom/solution.h"

/* Number of tabulated mean cosines from 0 to 1; texels of the map of directions. */
enum {
    TY_DOM_ENVIRONMENT_LOBES = 5,
    TY_DOM_ENVIRONMENT_SIDE = TY_MARCH_BLUR_CELLS,
    TY_DOM_ENVIRONMENT_TEXELS = TY_DOM_ENVIRONMENT_SIDE * TY_DOM_ENVIRONMENT_SIDE
};

/* Radiance that a light cluster scatters into a direction, times 4 pi, at full transmittance. */
typedef struct ty_dom_environment_weight {
    float lobe[TY_DOM_ENVIRONMENT_LOBES][3];
} ty_dom_environment_weight;

typedef struct ty_dom_environment {
    ty_dom_environment_weight* weights; /* per direction and light cluster; NULL: there are no environments */
    size_t count;
    int32_t directions, texel[TY_DOM_ENVIRONMENT_TEXELS],
        index[TY_DOM_ENVIRONMENT_TEXELS]; /* texels in use, and their directions' numbers */
} ty_dom_environment;

typedef struct ty_dom_environment_view {
    const ty_dom_environment_weight* weights[4];
    float t[4];
    bool has_lobes; /* light in the forward lobe is told apart */
} ty_dom_environment_view;

/* Weights of all clusters for an eye. ty_dom_environment_free may follow in any case. Errors: TY_ERROR_MEMORY. */
ty_result ty_dom_environment_evaluate(const ty_dom* light, const double eye[3], ty_dom_environment* sky);
void ty_dom_environment_free(const ty_dom* light, ty_dom_environment* sky);

/* With a fit: the environments' radiance after one scattering within the peak, for ty_march_def.blurred, with
 * TY_DOM_ENVIRONMENT_TEXELS texels. */
void ty_dom_environment_blur(const ty_dom* light, float* map);

/* Looks up a direction from a cell to the eye; then evaluates the radiance of a cluster whose fluences U, R and S
 * arrive, times 4 pi. */
void ty_dom_environment_lookup(const ty_dom* light, const ty_dom_environment* sky, ty_vec omega,
                               ty_dom_environment_view* view);
float ty_dom_environment_radiance(const ty_dom_environment_view* view, int32_t cluster, int32_t channel,
                                  const ty_forward* forward);

#endif
