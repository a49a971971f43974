/* One interior: its cells, the faces between them and its surface, and its light. */
#ifndef TY_SOLVE_ENCLOSED_BODY_H
#define TY_SOLVE_ENCLOSED_BODY_H

#include "direct/lights/discrete_light.h"
#include "scene/scene.h"
#include "solve/enclosed/enclosed.h"
#include "solve/ordinates/ordinates.h"

/* A face of a cell, and the surface there. */
typedef struct ty_enclosed_side {
    int32_t cell;            /* inside; -1: the face is that of a cell outside, and the rest has no meaning */
    ty_vec position, normal; /* on the surface; unit, outwards */
    float margin;            /* of rays that leave it, m */
    float area;              /* of the surface, m^2: the face's over |nx| + |ny| + |nz| */
} ty_enclosed_side;

typedef struct ty_enclosed_body {
    ty_context* context;
    const ty_scene_view* scene;
    const ty_enclosed_def* def;
    int32_t interior; /* of the scene view */
    bool diffusion;   /* asked for, or because cells are too thick for ordinates */
    int32_t bands, terms;
    float legendre[3][TY_SH_BANDS_MAX];
    float forward[3]; /* part of the scattering that counts as unscattered */
    double lower[3], cell[3];
    int32_t size[3];
    size_t cells;
    uint8_t* inside; /* per cell */
    float *extinction[3], *scattering[3];
    /* Faces, as in ty_ordinates_faces. */
    int32_t side_count, *first, *x;
    uint8_t* face;
    float *albedo, *emission, *ior, *normal;
    ty_enclosed_side* sides;
    /* Moments, interleaved: `terms` per cell. Uncollided light of lights, and of other surfaces; the field. */
    float *of_lights[3], *of_surfaces[3], *field[3];
    float* solved[3];   /* moments of scattered light, planes of cells */
    float* exitance[3]; /* of scattered light, per side, W m^-2 of the face */
    uint8_t* near_cell;
    /* Light that enters, W: of lights and of surfaces; absorbed before its first collision, and leaving again. */
    double entering[2][3], leaving[2][3];
    double unscattered[2][3]; /* leaving without a collision of the true extinction */
} ty_enclosed_body;

static inline float ty_enclosed_scaled(const ty_enclosed_body* body, int channel, size_t cell) {
    return body->extinction[channel][cell] - body->forward[channel] * body->scattering[channel][cell];
}

/* Cells, media and faces. medium: of the scene view. Errors: TY_ERROR_MEMORY. */
ty_result ty_enclosed_body_create(const ty_scene* scene, const ty_enclosed_def* def, int32_t interior, int32_t medium,
                                  ty_enclosed_body* out);
void ty_enclosed_body_destroy(ty_enclosed_body* body);

/* The surface that ends a ray from within, behind those of solids that overlap the interior, whose space counts as
 * filled; false: there is none before `far`. */
bool ty_enclosed_meet_surface(const ty_enclosed_body* body, ty_vec origin, ty_vec w, float far, ty_hit* hit);

/* Uncollided light of one thread's beams. */
typedef struct ty_enclosed_sums {
    float* moments[3]; /* fluence times Y_lm, times the cell's volume, W m; `terms` per cell */
    double entering[3], leaving[3], unscattered[3];
} ty_enclosed_sums;

/* Carries a narrow beam in at a side: direction: of travel, outside; irradiance: across the beam, W m^-2. */
void ty_enclosed_trace_beam(const ty_enclosed_body* body, ty_enclosed_sums* sums, int32_t side, ty_vec direction,
                            const float irradiance[3]);
/* The light of all lights; the light of other surfaces, which replaces that found before. Errors: TY_ERROR_MEMORY;
 * those of the def's `radiance`. */
ty_result ty_enclosed_add_lights(ty_enclosed_body* body, const ty_discrete_light_set* lights);
ty_result ty_enclosed_add_surfaces(ty_enclosed_body* body, const ty_enclosed_field* fields, int32_t per_side,
                                   int64_t* rays);

/* Scattered light of the uncollided light; adds to the stats. again: from the last solution. */
ty_result ty_enclosed_solve_ordinates(ty_enclosed_body* body, bool again, double tolerance, ty_enclosed_stats* stats);
ty_result ty_enclosed_solve_diffusion(ty_enclosed_body* body, ty_enclosed_stats* stats);
/* Fills body->field with all light, continued beyond the surface. */
void ty_enclosed_fill_field(ty_enclosed_body* body);
/* Replaces it beside the surface of thick cells by the exitance, averaged along the surface. Errors: TY_ERROR_MEMORY.
 */
ty_result ty_enclosed_spread_exitance(ty_enclosed_body* body);
/* Scales the field so that the flux that paths find leaving is that of the balance, W. */
void ty_enclosed_balance_field(ty_enclosed_body* body, const ty_enclosed_field* field, const double leaving[3]);

#endif
