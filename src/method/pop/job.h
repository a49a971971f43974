/* State of one call across the stages of the method. */
#ifndef TY_METHOD_POP_JOB_H
#define TY_METHOD_POP_JOB_H

#include "method/pop/delta_source.h"
#include "method/pop/solution.h"
#include "method/volume_method.h"
#include "scene/scene.h"

typedef struct ty_pop_job {
    ty_context* context;
    const ty_scene* scene;
    const ty_pop_def* def;
    ty_part_progress progress;
    ty_grid_medium* fine;             /* for fine-grid lights; NULL if there are none */
    ty_grid_medium* medium;           /* merged cells */
    float* source[3];                 /* diffusion source on merged cells, W m^-3 */
    ty_pop_delta_source delta_source; /* of fine-grid beams with lobes; without cells if there are none */
    ty_diffuse_surfaces surfaces;     /* split mode: between merged cells */
    ty_incident_flux incident;        /* split mode: from surfaces outside of them, of lamps */
    double initial_light;             /* published modes: initial light */
    float importance[TY_POP_IMPORTANCE_WIDTH * TY_POP_IMPORTANCE_HEIGHT];
    ty_pop* light;
    ty_pop_stats stats;
} ty_pop_job;

extern const ty_option_table ty_pop_options;
extern const ty_volume_method ty_volume_pop;

/* Sizes all grids and samples the media on them. */
ty_result ty_pop_sample_media(ty_pop_job* job);
/* Lights the fine grid, and adds its diffusion source. */
ty_result ty_pop_inject_fine_grid(ty_pop_job* job);
/* Ordinates of all other lights: their light on their own grids, merged. */
ty_result ty_pop_light_ordinates(ty_pop_job* job);
/* Split mode: diffusion source of the ordinates' light, and the diffusion solve. */
ty_result ty_pop_diffuse(ty_pop_job* job);
/* Lights surfaces outside of the box by the lamps. */
ty_result ty_pop_light_outside(ty_pop_job* job, const ty_discrete_light_set* sources);
/* Lights them by the media, and the media by them. solver, solved: of the diffuse light so far. */
ty_result ty_pop_interreflect(ty_pop_job* job, const ty_diffusion_def* solver, const ty_diffuse_stats* solved);
/* The lights of a march, and how it reads the fields. */
void ty_pop_set_march(const ty_pop* light, ty_march_def* march);

#endif
