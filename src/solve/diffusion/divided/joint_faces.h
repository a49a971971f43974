/* Surfaces of a solve that all ranks make together: rank 0 hands every rank the sides of its rows of cells. */
#ifndef TY_SOLVE_DIFFUSION_DIVIDED_JOINT_FACES_H
#define TY_SOLVE_DIFFUSION_DIVIDED_JOINT_FACES_H

#include "solve/diffusion/diffusion.h"

/* Sides of a box: their rows, cells, faces, albedos, staircases, radiosities and results, and the cells' closed faces.
 */
enum { TY_SIDE_ARRAYS = 9 };

typedef struct ty_joint_faces {
    ty_context* context;
    ty_domain* domain;
    const ty_diffusion_faces* whole; /* of the grid, on rank 0 */
    bool has_radiosity;
    int32_t *counts, max_sides;  /* sides of each rank; the most of any */
    void* own[TY_SIDE_ARRAYS];   /* of this rank's box */
    void* other[TY_SIDE_ARRAYS]; /* on rank 0: of another rank's */
    ty_diffusion_faces faces;    /* of this rank's box */
    float *flux, *irradiance;    /* results of its sides, for the solve */
} ty_joint_faces;

/* Calls of all ranks. context, domain, whole and has_radiosity are set. Take: TY_ERROR_MEMORY, TY_ERROR_UNSUPPORTED (a
 * rank does not answer). Give brings the sides' results to rank 0; each may be NULL there. False: a rank does not
 * answer. */
ty_result ty_joint_faces_take(ty_joint_faces* part);
bool ty_joint_faces_give(const ty_joint_faces* part, float* flux, float* irradiance);
void ty_joint_faces_free(ty_joint_faces* part);

#endif
