/* Lights with extent, which have no shadow map: area lights, emissive surfaces and environments. Their direct light on
 * a surface is estimated by next-event estimation at low-discrepancy points.
 *
 * Neighbouring receivers take different points of one sequence: with receivers of all TY_LIGHT_PATTERN places of the
 * pattern, the mean over them has all points (interleaved sampling, Keller and Heidrich 2001). */
#ifndef TY_METHOD_LPV_EXTENDED_LIGHTS_H
#define TY_METHOD_LPV_EXTENDED_LIGHTS_H

#include "base/sh.k.h"
#include "method/lpv/lattice/lattice.h"
#include "scene/lights/light_tree.h"
#include "scene/scene.h"

/* Places of the pattern, along a side of pixels and in all; coordinates of a point: two on an environment, three for a
 * positioned light and its surface. */
enum { TY_LIGHT_PATTERN_SIDE = 4, TY_LIGHT_PATTERN = 16, TY_LIGHT_POINT_TERMS = 5 };

typedef struct ty_extended_lights {
    ty_context* context;
    ty_light_tree* tree;   /* of area lights and emissive surfaces */
    int32_t* environments; /* indices into ty_light_set.lights */
    int32_t environment_count;
    size_t environment_capacity;
} ty_extended_lights;

/* *out is NULL where the scene has none of them. Errors: TY_ERROR_MEMORY. */
ty_result ty_extended_lights_create(const ty_scene* scene, ty_extended_lights** out);
void ty_extended_lights_destroy(ty_extended_lights* lights);

/* TY_LIGHT_PATTERN times `count` points, place after place. */
typedef struct ty_light_points {
    ty_context* context;
    int32_t count; /* points at a place */
    float (*at)[TY_LIGHT_POINT_TERMS];
} ty_light_points;

/* sample: 0, 1 ... for images of several samples per pixel. Errors: TY_ERROR_MEMORY. */
ty_result ty_light_points_create(ty_context* context, int32_t count, uint64_t seed, int32_t sample,
                                 ty_light_points* out);
void ty_light_points_destroy(ty_light_points* points);

/* The scene around the receivers. */
typedef struct ty_extended_view {
    const ty_scene_view* scene;
    const ty_extended_lights* lights;
    const ty_light_points* points;
    const ty_medium_view* media;  /* attenuate the light where all of them are homogeneous */
    const ty_grid_medium* medium; /* attenuates it elsewhere; NULL: no medium attenuates */
    bool on_cells;                /* whether any medium is heterogeneous */
} ty_extended_view;

/* medium: on cells; NULL: no medium attenuates. reduced: in place of the scene's media, if it has any. */
ty_extended_view ty_extended_view_of(const ty_scene* scene, const ty_extended_lights* lights,
                                     const ty_light_points* points, const ty_grid_medium* medium,
                                     const ty_reduced_media* reduced);

/* A point on a surface, off it by the rounding error, with its geometric and shading normals, unit, on the lit side. */
typedef struct ty_light_receiver {
    ty_vec point, facing, normal;
} ty_light_receiver;

/* Irradiance of a receiver at a place of the pattern, W m^-2, attenuated by media and shadowed by surfaces. Returns the
 * number of shadow rays. */
int32_t ty_extended_irradiance(const ty_extended_view* view, const ty_light_receiver* receiver, int32_t place,
                               float irradiance[3]);
/* A cell of media. */
typedef struct ty_light_cell {
    ty_vec center;
    float side, extinction[3]; /* m; mean, 1/m */
    bool narrow; /* whether its phase function is too narrow for the bands: lights with a place go to a beam */
} ty_light_cell;

/* Spherical harmonics of the direction of travel of the uncollided radiance in a cell, per channel, W m^-2 sr^-1. */
typedef struct ty_cell_radiance {
    float mean[3][TY_SH_TERMS_MAX];    /* of the whole cell, attenuated by its own extinction: what scatters in it */
    float visible[3][TY_SH_TERMS_MAX]; /* of the part that an eye on the light's side sees; the mean of thin cells */
    float beam[3][TY_BEAM_TERMS];      /* the same of lights with a place, in narrow cells */
} ty_cell_radiance;

/* The radiance by the points of all places, whose rays are traced from the cell's center. Attenuation is exact up to
 * the cell's face and that of the cell's extinction within, so no more is scattered than enters. Returns the number of
 * shadow rays. */
int32_t ty_extended_radiance(const ty_extended_view* view, const ty_light_cell* cell, ty_cell_radiance* out);

#endif
