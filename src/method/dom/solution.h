/* The solution by discrete ordinates: uncollided fluence on fine cells and moments on coarse ones. */
#ifndef TY_METHOD_DOM_SOLUTION_H
#define TY_METHOD_DOM_SOLUTION_H

#include "direct/surfaces/boundary_faces.h"
#include "direct/uncollided/light_groups.h"
#include "image/march/irradiance_cache.h"

#include <tyndall/dom.h>

/* Maximum number of lights with a dedicated uncollided field, which keeps their phase function sharp; all others share
 * an aggregate field. */
enum { TY_DOM_DEDICATED_MAX = 8 };

/* Samples of one light that lie close together, as one. Its fluence is sample.color times that of a plane: one for all
 * channels, or one each. sample: of directions the mean, its length the mean cosine; of points the mean position and
 * the sum of their areas; its color is that without media, for points at a distance of 1 m. */
typedef struct ty_dom_light_cluster {
    ty_discrete_light sample;
    bool environment;    /* the light is an environment */
    ty_vec weighted_sum; /* while samples are added: sum of their directions or positions, times brightness */
    float brightness;    /* sum of the samples' mean colors */
    float* fluence[3];   /* on the cells of ordinates */
} ty_dom_light_cluster;

/* Light clusters that a cluster of an environment takes its transmittance from. */
enum { TY_DOM_ENV_NEIGHBOURS = 4 };

/* A small region of an environment, finer than its light clusters. */
typedef struct ty_dom_env_cluster {
    ty_vec omega; /* direction of travel */
    float color[3];
    int32_t neighbour[TY_DOM_ENV_NEIGHBOURS]; /* light clusters */
    float weight[TY_DOM_ENV_NEIGHBOURS];      /* sum 1 */
} ty_dom_env_cluster;

struct ty_dom {
    ty_context* context;
    int32_t bands;        /* L: number of Legendre orders of the scattering source */
    int32_t output_bands; /* number of orders of the moments that are kept, at least L */
    ty_forward_fit fit;   /* of 0 bands: phase functions are truncated (delta-M); else they are fitted (delta-fit) */
    /* Uncollided light, on fine cells. */
    ty_grid_box fine_box;
    bool has_lobes; /* unscattered light and light in the forward lobe are told apart */
    ty_light_field* fields[TY_DOM_DEDICATED_MAX][TY_FLUENCE_COUNT];
    ty_light_field* coarse_fields[TY_DOM_DEDICATED_MAX][TY_FLUENCE_COUNT]; /* their means on the cells of ordinates */
    ty_light_field* aggregate;                                             /* of all lights without a dedicated field */
    ty_light_fluence fluences[TY_DOM_DEDICATED_MAX + 1];
    int32_t fluence_count;
    /* Cells of ordinates. */
    ty_grid_box box;
    size_t cells;
    int32_t planes;                         /* of g: 1 or 3 */
    float* g[3];                            /* mean cosines of cells */
    bool isotropic;                         /* all of them are 0, and the phase function, too */
    float legendre[TY_PHASE_ORDER_MAX + 1]; /* as in ty_grid_medium */
    float scattered[TY_DOM_BANDS_MAX];      /* with these: moments less the forward fraction */
    /* Collided light: output_bands^2 planes of cells, one per real spherical harmonic. */
    bool shared; /* all channels are the first one's planes, times color */
    float color[3];
    float* moments[3]; /* phi_lm of collided light, W m^-2 */
    float* source[3];  /* q_lm of first collisions, bands^2 planes of each channel, W m^-3, which gradients take; NULL:
                          the light is not differentiable */
    /* Of ty_ordinates_def.face_fluence, what scatters last in the cell: less the emission that is seen there, over the
       albedo. NULL: there are no diffusive cells; then extinction, per plane of g, is NULL, too. */
    float* face_fluence[3];
    float* face_even[3];    /* the part of it that comes from even light: what surfaces and media around send */
    float* extinction[3];   /* sigma_t, 1/m */
    float* darkening[3];    /* likewise: slope of the radiance of faces under other light in the cosine, over that at
                               cosine 0 */
    float* similarity[3];   /* likewise: s = sqrt(sigma_a / (sigma_t - g sigma_s)) */
    float* wall_moments[3]; /* of light from surfaces that has not scattered since; NULL: none */
    /* Boundary faces: per side, the irradiance of collided light on the cell's face, and on the surface itself the part
       of the uncollided light that is in the forward lobe. */
    ty_boundary_faces* boundary; /* NULL: there are none */
    float *wall_irradiance[3], *wall_forward[3];
    ty_irradiance_cache* cache; /* of surfaces outside of the box; NULL: none */
    uint8_t* unlit;             /* cells inside of solids, which no light reaches; NULL: there are no boundary faces */
    /* Directions of the aggregate field's light. */
    ty_dom_light_cluster* clusters;
    int32_t cluster_capacity, cluster_count, cluster_planes;
    ty_dom_env_cluster* env_clusters;
    int32_t env_capacity, env_count;
    float env_cosine; /* mean cosine of their light about their directions */
    float mean_g[3];  /* scattering-weighted mean of g, where there are environments */
    /* Per plane of the medium, over all cells: optical depth of sigma_t, and of sigma_t - g^(L+1) sigma_s, over that of
       sigma_t - g^L sigma_s. */
    float unscattered_ratio[3], next_order_ratio[3];
};

/* Moments in place of powers of g; NULL: there are none. */
static inline const float* ty_dom_legendre(const ty_dom* light) {
    return light->legendre[0] > 0 ? light->legendre : NULL;
}

/* The moments after light with a mean cosine about its direction has scattered; none without moments. */
static inline void ty_dom_blur_legendre(const ty_dom* light, float cosine, float out[TY_PHASE_ORDER_MAX + 1]) {
    float power = 1;
    for (int32_t l = 0; l <= TY_PHASE_ORDER_MAX; ++l, power *= cosine) out[l] = power * light->legendre[l];
}

/* Channels that are solved for. */
static inline int32_t ty_dom_channels(const ty_dom* light) {
    return light->shared ? 1 : 3;
}

/* The plane of harmonic lm among a channel's planes. */
static inline float* ty_dom_plane(const ty_dom* light, float* planes, int32_t lm) {
    return planes + light->cells * (size_t)lm;
}

/* The unit vector from a cell's center to the eye. */
void ty_dom_direction_to_eye(const ty_dom* light, const int32_t cell[3], const double eye[3], double omega[3]);

/* Irradiance on the surface of a side: that of the face, or where the surface slants, by harmonics along its normal
 * times those of the clamped cosine, from the first `bands` orders of its cell's moments. */
float ty_dom_side_irradiance(const ty_dom* light, const ty_boundary_side* side, float of_face, const float* moments,
                             int32_t bands, size_t cell);

#endif
