/* What of environments is seen from a place. */
#ifndef TY_METHOD_DOM_SOURCES_ENVIRONMENT_H
#define TY_METHOD_DOM_SOURCES_ENVIRONMENT_H

#include "direct/single/forward.k.h"
#include "image/march.h"
#include "method/dom/view/view.h"

/* Mean cosines, from 0 to 1, that lobes are tabulated for; texels of the map of ways. */
enum {
    TY_DOM_ENVIRONMENT_LOBES = 5,
    TY_DOM_ENVIRONMENT_SIDE = TY_MARCH_BLURRED,
    TY_DOM_ENVIRONMENT_TEXELS = TY_DOM_ENVIRONMENT_SIDE * TY_DOM_ENVIRONMENT_SIDE
};

/* Of a part along a way: what its light is turned into, times 4 pi, if all of it arrives. */
typedef struct ty_dom_environment_weight {
    float lobe[TY_DOM_ENVIRONMENT_LOBES][3];
} ty_dom_environment_weight;

typedef struct ty_dom_environment {
    ty_dom_environment_weight* weights; /* way by way, of each part; NULL: there are no environments */
    size_t count;
    int32_t directions, texel[TY_DOM_ENVIRONMENT_TEXELS],
        index[TY_DOM_ENVIRONMENT_TEXELS]; /* texels that are ways, and which ones */
} ty_dom_environment;

typedef struct ty_dom_environment_view {
    const ty_dom_environment_weight* weights[4];
    float t[4];
    bool has_lobes; /* whether there is light that has scattered and kept its direction */
} ty_dom_environment_view;

/* Weights of all parts for an eye. Errors: TY_ERROR_MEMORY; ty_dom_environment_free may follow. */
ty_result ty_dom_environment_evaluate(const ty_dom* light, const double eye[3], ty_dom_environment* sky);
void ty_dom_environment_free(const ty_dom* light, ty_dom_environment* sky);

/* With a fit: environments' radiance through what scatters once within the peak, as ty_march_def.blurred has it: of
 * TY_DOM_ENVIRONMENT_TEXELS. */
void ty_dom_environment_blur(const ty_dom* light, float* map);

/* Along the way from a cell of ordinates to the eye; then what a part is turned into of which U, R and S arrive, times
 * 4 pi. */
void ty_dom_environment_lookup(const ty_dom* light, const ty_dom_environment* sky, ty_vec omega,
                               ty_dom_environment_view* view);
float ty_dom_environment_radiance(const ty_dom_environment_view* view, int32_t part, int32_t channel,
                                  const ty_forward* forward);

#endif
