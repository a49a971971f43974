/* The lattice of rays in one section of one of a point light's six pyramids, about a cell apart at its far end. It
 * stores the mean extinction since each ray's entry into the box, which, unlike the optical depth, is smooth between
 * rays that enter through different sides. */
#ifndef TY_DIRECT_UNCOLLIDED_RAY_LATTICE_H
#define TY_DIRECT_UNCOLLIDED_RAY_LATTICE_H

#include "direct/uncollided/kernel.h"
#include "direct/uncollided/near_cells.h"

/* p and q are tangents along the axes u and v. */
typedef struct ty_ray_lattice {
    const ty_point_light_job* job;
    int32_t axis[3];        /* u, v, w */
    bool backwards;         /* towards lower w */
    int32_t slabs, begin;   /* number of slabs of the section; first slab along w */
    double near, far;       /* m along w from the light */
    double low[2], step[2]; /* of p and q */
    int32_t count[2];
    double entry;   /* near end of the box, m along w */
    float* mean[3]; /* mean extinction up to the near side of each slab and the far side of the last: (slabs + 1) x
                       count */
    float* hit;     /* distance along w to the first surface per ray, m; NULL: no surfaces */
} ty_ray_lattice;

/* A pyramid along w without a section, and its first slab. */
int32_t ty_ray_lattice_begin(const ty_point_light_job* point, int32_t w, bool backwards, ty_ray_lattice* l);
/* Places the section that starts with slab `begin`, within which the distance doubles. False: the pyramid misses the
 * box there, and l->slabs slabs are to be skipped. */
bool ty_ray_lattice_place(ty_ray_lattice* l, int32_t begin);
/* Allocates memory and traces the rays. before: the previous section towards the light; its slabs are 0 if there is
 * none. ty_ray_lattice_end may follow in any case. Errors: TY_ERROR_MEMORY. */
ty_result ty_ray_lattice_trace(ty_ray_lattice* l, const ty_ray_lattice* before);
void ty_ray_lattice_end(ty_ray_lattice* l);
/* The adjoint of tracing for a medium of one plane: from a loss's derivatives by l->mean[0], of the same layout, adds
 * those by the extinction of cells to `gradient`, and those by the previous section's means to by_mean_before. It uses
 * the scratch of the first worker. */
void ty_ray_lattice_return(const ty_ray_lattice* l, const ty_ray_lattice* before, float* by_mean, float* by_mean_before,
                           float* gradient);

/* Values per plane of the medium: rays at the near sides of all slabs and the far side of the last. */
size_t ty_ray_lattice_values(const ty_ray_lattice* l);
/* Floats of scratch per worker for any row of rays of this light. */
size_t ty_ray_lattice_scratch(const ty_point_light_job* point);
/* Number of rays in one slab. */
size_t ty_ray_lattice_rays(const ty_ray_lattice* l);
/* The near side of a slab, m along w from the light. */
double ty_ray_lattice_plane(const ty_ray_lattice* l, int32_t slab);
/* The cell along w of a slab. */
int32_t ty_ray_lattice_cell(const ty_ray_lattice* l, int32_t slab);
/* Interpolation of a tangent along u (0) or v (1): between ray *i and the next, whose weight is returned. */
float ty_ray_lattice_locate(const ty_ray_lattice* l, int32_t along, double tangent, int32_t* i);

#endif
