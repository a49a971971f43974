/* A material's numbers at a point, and a BSDF prepared from them. */
#ifndef TY_SCENE_BSDF_STATE_K_H
#define TY_SCENE_BSDF_STATE_K_H

#include "scene/bsdf/tables.k.h"

/* A material at a point. */
typedef struct ty_bsdf_parameters {
    float base_color[3];
    float metallic, roughness;
    float ior, specular, specular_color[3]; /* of the dielectric: reflectance at normal incidence from ior and colour */
    float transmission; /* part of the dielectric's base that light passes instead of a diffuse one */
    float clearcoat, clearcoat_roughness;
    float sheen_color[3], sheen_roughness;
} ty_bsdf_parameters;

/* Unit normal and tangents. */
typedef struct ty_frame {
    ty_vec s, t, n;
} ty_frame;

/* Sampled lobes. */
enum {
    TY_LOBE_SPECULAR = 0,         /* reflection at microfacets */
    TY_LOBE_MULTIPLE = 1,         /* light that microfacets scatter several times */
    TY_LOBE_DIFFUSE = 2,          /* diffuse base, sheen */
    TY_LOBE_COAT = 3,             /* reflection at the clear coat */
    TY_LOBE_THROUGH = 4,          /* transmission: reflection at microfacets, mirrored to the other side */
    TY_LOBE_THROUGH_MULTIPLE = 5, /* the same after several times */
    TY_LOBE_COUNT = 6
};

/* A BSDF for one direction wo, towards the viewer, prepared for any number of directions wi, towards the light. */
typedef struct ty_bsdf {
    TY_GLOBAL const ty_bsdf_tables* tables;
    ty_frame frame, coat_frame;
    ty_vec wo, coat_wo; /* in the frames */
    float roughness, alpha;
    float f0[3], f90;        /* Schlick's reflectance of the microfacets, mixed from dielectric and metal */
    float film_f0, film_f90; /* that of the dielectric alone, in its brightest channel; it attenuates the base */
    float diffuse[3];        /* albedo of the base */
    float transmitted[3];    /* colour of the light that passes */
    float multiple[3];       /* fraction of the light that single scattering loses which returns; 0: no compensation */
    float film_multiple;     /* the same of the dielectric alone */
    float lost, lost_mean;   /* 1 - E(wo), and its mean times the transmittance of layers */
    float film, below_mean;  /* albedo of the dielectric alone, at wo; mean transmittance of it and layers */
    float coat, coat_roughness;
    float sheen[3], sheen_roughness, sheen_scale; /* sheen_scale: its largest channel */
    float below_sheen, below_coat; /* parts of the light that sheen, and the clear coat, let down at wo */
    int32_t layered;               /* nonzero: there is sheen or a clear coat */
    /* Residual albedo of each lobe below layers (layers.k.h): at the nodes' cosines, at wo, its mean. */
    float residual[TY_BELOW_COUNT][TY_BSDF_NODES], residual_out[TY_BELOW_COUNT], residual_mean[TY_BELOW_COUNT];
    float albedo[3]; /* directional albedo of the side of wo */
    float total[3];  /* the same with the transmitted light */
    float probability[TY_LOBE_COUNT];
    int32_t compensated;
} ty_bsdf;

/* True if light passes the surface. */
TY_FN bool ty_bsdf_transmits(const ty_bsdf* b) {
    return b->probability[TY_LOBE_THROUGH] > 0.0f;
}

#endif
