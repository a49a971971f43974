/* State of one solve by discrete ordinates: media, sources and boundary faces. */
#ifndef TY_METHOD_DOM_JOB_H
#define TY_METHOD_DOM_JOB_H

#include "method/dom/solution.h"
#include "solve/ordinates/ordinates.h"
#include "method/volume_method.h"

typedef struct ty_dom_flux_request ty_dom_flux_request;

typedef struct ty_dom_job {
    ty_context* context;
    const ty_scene* scene;
    const ty_dom_def* def;
    ty_part_progress progress;
    ty_angular_quadrature* set;
    ty_angular_quadrature* last_set; /* of the last sweep; NULL: the same */
    ty_grid_medium* fine;            /* cells of uncollided light */
    ty_grid_medium* coarse;          /* cells of ordinates */
    double diffusive_paths;          /* of ty_ordinates_def */
    bool is_narrow;                  /* the bands leave much of the phase function to the forward peak */
    bool tells_positions;            /* of first collisions within cells that are thick and yet swept */
    bool even_light;                 /* all lights are soft environments */
    ty_discrete_light_set sources;
    const ty_boundary_faces* boundary; /* the solution's, between coarse cells; NULL: there are none */
    float* wall_albedo[3];             /* per side, for each channel that is solved for */
    float* wall_radiance[3];           /* per side: radiance of reflected uncollided light and of emission */
    float* incident_radiance[3];       /* boundary source of surfaces outside of the box, for each channel: planes of
                                          ty_boundary_radiance, axis by axis; NULL: there are none */
    float* source[3];                  /* q_lm, W m^-3: bands^2 planes of coarse cells for each channel */
    float* centers[3]; /* q_00 that uncollided light makes in thick cells, and that times its center along
                          x, y and z, -1..1 in the cell: four planes; NULL: there are no such cells */
    ty_dom* light;
    ty_dom_stats stats;
    ty_dom_flux_request* flux; /* NULL: not asked for */
} ty_dom_job;

/* Thickness of cells, mean free paths of sigma*, above which the positions of first collisions within them are told
 * apart where media have no edges. */
#define TY_DOM_DISPLACED_PATHS 1.0

/* The longest edge of a cell in mean free paths. */
static inline double ty_dom_cell_thickness(const ty_dom_job* job, int32_t plane, size_t cell) {
    const double* edge = job->coarse->cell;
    const double longest = edge[0] > edge[1] ? edge[0] : edge[1];
    return (double)job->coarse->extinction[plane][cell] * (longest > edge[2] ? longest : edge[2]);
}

extern const ty_option_table ty_dom_options;
extern const ty_volume_method ty_volume_dom;

#endif
