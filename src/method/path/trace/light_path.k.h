/* The state of a light path. */
#ifndef TY_METHOD_PATH_TRACE_LIGHT_PATH_K_H
#define TY_METHOD_PATH_TRACE_LIGHT_PATH_K_H

#include "method/path/trace/kernel.h"
#include "scene/lights/light_tree.k.h"

/* Transmittance to the lights below which they are looked at by Russian roulette. */
#define TY_PATH_FAINT_TRANSMITTANCE 0.01f

/* Path depth from which Russian roulette ends even a path whose throughput does not fall. */
enum { TY_PATH_ROULETTE_DEPTH = 2000 };

/* The boundary of a solid dielectric, or a thin wall, as a path meets it. */
enum {
    TY_INTERFACE_NONE = 0,   /* other surfaces */
    TY_INTERFACE_PASSED = 1, /* light goes straight on: a dielectric of higher priority fills both sides, or both have
                                the same index of refraction */
    TY_INTERFACE_REFRACTS = 2,
    TY_INTERFACE_PANE = 3 /* a smooth thin wall: light goes straight on, or is reflected */
};

/* Path classes: the interactions of light between its source and the camera. */
enum {
    TY_PATH_UNCOLLIDED = 0, /* no interaction */
    TY_PATH_REFLECTED = 1,  /* reflections at surfaces only */
    TY_PATH_SINGLE = 2,     /* one scattering in a medium and no other interaction */
    TY_PATH_MULTIPLE = 3,   /* any other sequence */
    TY_PATH_CLASS_COUNT = 4
};

/* Emission at the end of the first ray of a path that others find. */
enum { TY_FOUND_NONE = 0, TY_FOUND_SURFACES = 1, TY_FOUND_ALL = 2 };

/* The last vertex whose next-event estimation looked through smooth interfaces (manifold.k.h). */
typedef struct ty_manifold_vertex {
    int32_t refractions;      /* of the path since; -1: it did something else, or there is no such vertex */
    ty_vec origin, direction; /* direction, and its density: after a refraction */
    ty_vec normal;            /* normal and lobe: as in ty_path */
    ty_light_lobe lobe;
    float pdf;
    ty_interior_list inside;
} ty_manifold_vertex;

typedef struct ty_path {
    const ty_path_request* request;
    ty_sampler random;
    ty_vec origin, direction;
    ty_vec normal;       /* unit normal of the last surface vertex, on the path's side; 0 in media and at the camera */
    ty_light_lobe lobe;  /* of that vertex, if it is glossy; otherwise its weight is 0 */
    float beta[3];       /* throughput */
    float rr_throughput; /* throughput without the weights of sampled directions; Russian roulette decides by it */
    float pdf;           /* solid-angle density of direction, 1/sr; 0 at the camera, where no light was sampled */
    int32_t scattered; /* nonzero if the last vertex is in a medium, where equiangular sampling shares the MIS weight */
    float phase;       /* phase function (green) of that vertex in direction, 1/sr */
    float point_light_rate; /* lamp directions per direction at that vertex, beside the lamp; 0: none were sampled */
    int32_t depth;          /* scatterings and reflections so far */
    int32_t run;            /* scatterings since the last reflection */
    int32_t path_class;     /* class of the light that the path finds next */
    float radiance[TY_PATH_CLASS_COUNT][3]; /* estimate so far per class, W m^-2 sr^-1 */
    const ty_medium_view* media;            /* that the path may meet before the next interface of dielectrics */
    int32_t medium_count;
    float expected; /* by a guide: radiance of the camera's ray, W m^-2 sr^-1; 0: unknown */
    float incident; /* by a guide: radiance along the present ray; negative: unknown */
    int32_t found;  /* by other rays: emission at the end of the path's first one, TY_FOUND_... */
    float passed;   /* distance of origin from the last vertex, m: rays go on at interfaces that change nothing */
    ty_interior_list inside;   /* the dielectrics around it, where the scene has any */
    ty_manifold_vertex vertex; /* where the scene has any */
} ty_path;

/* A ray's surface intersection and the material at that point. */
typedef struct ty_intersection {
    ty_hit hit;
    ty_surface_point point;
    int32_t interface;       /* of dielectrics: TY_INTERFACE_... */
    ty_interior_list beyond; /* where there is one: the dielectrics behind it */
    float tint[3];           /* what changes no direction: colour of the light that goes on; panes: the same over the
                                probability to pass, or 1 over that not to */
} ty_intersection;

/* The path class after one more scattering, or one more reflection. */
TY_FN int32_t ty_path_class_scattered(int32_t path_class) {
    return path_class == TY_PATH_UNCOLLIDED ? TY_PATH_SINGLE : TY_PATH_MULTIPLE;
}

TY_FN int32_t ty_path_class_reflected(int32_t path_class) {
    return path_class <= TY_PATH_REFLECTED ? TY_PATH_REFLECTED : TY_PATH_MULTIPLE;
}

/* True if no further scattering is allowed. */
TY_FN bool ty_path_is_last(const ty_path* path) {
    return (path->request->max_depth > 0 && path->depth >= path->request->max_depth) ||
           (path->request->max_run > 0 && path->run >= path->request->max_run);
}

TY_FN void ty_path_add(ty_path* path, const float radiance[3]) {
    for (int c = 0; c < 3; ++c) path->radiance[path->path_class][c] += radiance[c];
}

/* The same for light that interfaces refracted on its way to the path. */
TY_FN void ty_path_add_refracted(ty_path* path, const float radiance[3]) {
    for (int c = 0; c < 3; ++c) path->radiance[ty_path_class_reflected(path->path_class)][c] += radiance[c];
}

#endif
