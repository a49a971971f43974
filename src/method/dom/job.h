/* What a solve leaves behind, and one call on its way through the parts of the method. */
#ifndef TY_METHOD_DOM_JOB_H
#define TY_METHOD_DOM_JOB_H

#include "base/progress.h"
#include "direct/group.h"
#include "direct/walls.h"
#include "image/options.h"
#include "solve/ordinates/ordinates.h"

#include <tyndall/dom.h>

/* Lights that keep a field of their own, so that their phase function stays sharp, beside all others together. */
enum { TY_DOM_OWN_MAX = 8 };

/* Beams or lamps of one light, or a share of them, that have about the same direction or place. Their fluence is
 * color times that of a plane: one for all channels, or one each. */
typedef struct ty_dom_part {
    int32_t kind;      /* TY_SINGLE_BEAM, TY_SINGLE_LAMP */
    bool sky;          /* whether it is part of an environment */
    int32_t light;     /* as in ty_source */
    ty_vec toward;     /* as in ty_single_light */
    float cosine;      /* beams: mean cosine about it */
    float area;        /* lamps: m^2 */
    float color[3];    /* without media, and 1 m from lamps */
    ty_vec middle;     /* while it is made: sum of the sources' directions or places, times their mean colors */
    float brightness;  /* sum of these mean colors */
    float* fluence[3]; /* of the cells of ordinates */
} ty_dom_part;

/* A piece of an environment, and the parts about it whose light in media it is dimmed as. */
enum { TY_DOM_PIECE_PARTS = 4 };

typedef struct ty_dom_piece {
    ty_vec way; /* that its light goes */
    float color[3];
    int32_t part[TY_DOM_PIECE_PARTS];
    float share[TY_DOM_PIECE_PARTS]; /* they add up to 1 */
} ty_dom_piece;

struct ty_dom {
    ty_context* context;
    int32_t bands, kept; /* L; of moments */
    ty_forward_fit fit;  /* no bands: phase functions are cut (delta-M); else they are fitted (peak.c) */
    /* Uncollided light, on fine cells. */
    ty_grid_box fine_box;
    bool lobes; /* whether what scatters nearly straight on is told from what has not scattered */
    ty_light_field* fields[TY_DOM_OWN_MAX][TY_SINGLE_FLUENCES];
    ty_light_field* coarse[TY_DOM_OWN_MAX][TY_SINGLE_FLUENCES]; /* their means on the cells of ordinates */
    ty_light_field* many;                                       /* of all lights that have no field of their own */
    ty_single_light lights[TY_DOM_OWN_MAX + 1];
    int32_t light_count;
    /* What ordinates go through. */
    ty_grid_box box;
    size_t cells;
    int32_t planes; /* of g: 1 or 3 */
    float* g[3];    /* mean cosines of cells */
    bool even;      /* whether all of them are 0 */
    /* Light: harmonic after harmonic, as many planes of cells as kept^2. */
    bool shared; /* whether all channels are the first one's, times color */
    float color[3];
    float* moments[3];  /* of what has scattered, W m^-2 */
    float* seen[3];     /* as ty_ordinates_def has it; NULL: no cell is so thick */
    float* surfaces[3]; /* of what surfaces sent and has not scattered since; NULL: of none, or part of sources */
    /* Sides of walls: irradiance that what has scattered brings in cells' faces, and of it, in the surface itself, what
       has scattered nearly straight on. */
    ty_walls* walls; /* NULL: there are none */
    float *arrived[3], *forward[3];
    uint8_t* dark; /* cells that no light gets to, within solids; NULL: there are no walls */
    /* Directions of light that is in `many`. */
    ty_dom_part* parts;
    int32_t part_capacity, part_count, part_planes;
    ty_dom_piece* pieces; /* of environments */
    int32_t piece_capacity, piece_count;
    float piece_cosine;         /* mean cosine of pieces about their directions */
    float mean_g[3];            /* of all that scatters, where there are pieces */
    float straight[3], bent[3]; /* per plane of the medium, over all cells: how much deeper media are for U and S of
                                   forward.k.h than for R */
};

typedef struct ty_dom_job {
    ty_context* context;
    const ty_scene* scene;
    const ty_dom_def* def;
    ty_part_progress progress;
    ty_angular_quadrature* set;
    ty_angular_quadrature* last;  /* of the last sweep; NULL: the same */
    ty_grid_medium* fine;   /* cells of uncollided light */
    ty_grid_medium* coarse; /* cells of ordinates */
    ty_source* sources;
    int32_t source_count, source_capacity;
    const ty_walls* walls; /* of the light, between coarse cells; NULL: there are none */
    float* wall_albedo[3]; /* of each side, for as many channels as are solved for */
    float* inflow[3];      /* radiance of surfaces outside of the box along each direction; NULL: there are none */
    float* wall_light[3];  /* radiance of uncollided light that walls send */
    float* source[3];      /* q_lm, W m^-3: bands^2 planes of coarse cells, of as many channels as are solved for */
    ty_dom* light;
    ty_dom_stats stats;
} ty_dom_job;

/* Bands below which nothing is fitted. */
enum { TY_DOM_LEAST_FITTED = 4 };

/* Fits a phase function with so many bands, at least TY_DOM_LEAST_FITTED. */
void ty_dom_fit_peak(double g, int32_t bands, ty_forward_fit* out);
/* Fails with the first field that is out of its range. */
ty_result ty_dom_check(ty_context* context, const ty_dom_def* def);
ty_image_options ty_dom_image_options(const ty_dom_def* def);

/* Directions, fine and coarse cells, the media on them, and how many bands they need. */
ty_result ty_dom_sample_media(ty_dom_job* job);
/* Beams and lamps, and whether all channels are multiples of one. */
ty_result ty_dom_take_sources(ty_dom_job* job);
/* Uncollided light of all sources on fine cells, and q_lm. */
ty_result ty_dom_light_directly(ty_dom_job* job);
/* Moments of all channels. */
ty_result ty_dom_scatter(ty_dom_job* job);

/* ---- surfaces between cells ---- */

ty_result ty_dom_find_walls(ty_dom_job* job);
void ty_dom_free_walls(ty_dom_job* job);
/* Whether walls, and surfaces outside of the box, reflect all channels alike and walls send nothing by themselves. */
bool ty_dom_walls_share(const ty_dom_job* job);
/* Whether any surface is outside of the box, and whether all of the scene's are gray. */
bool ty_dom_reaches_out(const ty_dom_job* job);
bool ty_dom_is_gray(const ty_dom_job* job);
/* Radiance that surfaces outside of the box send into it of all lights that virtual lamps do not stand for. Errors:
 * TY_ERROR_MEMORY. */
ty_result ty_dom_let_in(ty_dom_job* job);
/* Whether surfaces at a point are walls. */
bool ty_dom_is_walled(const ty_dom_job* job, ty_vec point);
/* What uncollided light walls send; and takes from q_lm what is in dark cells. */
ty_result ty_dom_light_walls(ty_dom_job* job);
/* Gives what is in cells' parts behind surfaces to the cells there. Errors: TY_ERROR_MEMORY. */
ty_result ty_dom_cut_sources(ty_dom_job* job);
bool ty_dom_walls_are_dark(const ty_dom_job* job, int32_t channel);

/* Of light that walls send and that has not scattered since, W: emitted and absorbed without what scatters, which is
 * the medium's source. */
typedef struct ty_dom_wall_power {
    double emitted, absorbed, by_walls, leaving, sweep_seconds;
    int32_t sweeps;
    bool converged;
} ty_dom_wall_power;

/* Carries a channel's light from wall to wall and adds what scatters of it to q_lm. def: as for what scatters. Errors:
 * TY_ERROR_MEMORY; TY_CANCELLED. */
ty_result ty_dom_carry_walls(ty_dom_job* job, int32_t channel, const ty_ordinates_def* def, ty_dom_wall_power* power);
/* Lets walls reflect what scatters. *none: of as many floats as there are sides, to be freed after the solve. */
ty_result ty_dom_reflect(ty_dom_job* job, int32_t channel, ty_ordinates_def* def, float** none);

/* Channels that are solved for. */
static inline int32_t ty_dom_channels(const ty_dom* light) {
    return light->shared ? 1 : 3;
}

/* Harmonic lm of a channel's planes. */
static inline float* ty_dom_plane(const ty_dom* light, float* planes, int32_t lm) {
    return planes + light->cells * (size_t)lm;
}

/* ---- one light's share of the source ---- */

enum { TY_DOM_MEANS = TY_DOM_BANDS_MAX + 1 };

/* Memory to work in, and what is known of fine cells. */
typedef struct ty_dom_scratch {
    float* turned;   /* of fine cells */
    float* means;    /* of coarse cells, TY_DOM_MEANS planes */
    bool uniform[3]; /* whether all that scatters on a plane of the medium has one g */
    float g[3];      /* that one */
} ty_dom_scratch;

ty_result ty_dom_scratch_create(const ty_dom_job* job, ty_dom_scratch* scratch);
void ty_dom_scratch_destroy(const ty_dom_job* job, ty_dom_scratch* scratch);
/* Adds what scatters of a field's light, which is that of `single` (TY_SINGLE_BEAM or _LAMP), to q_lm. source: one of
 * those it comes from. cosine: mean cosine of beams about their direction. */
void ty_dom_add_source(ty_dom_job* job, const ty_light_field* field, const ty_single_light* single,
                       const ty_source* source, float cosine, ty_dom_scratch* scratch);

/* Beams without fields of their own, whose light of cells is added to q_lm together: what all of them write is more
 * than what each of them brings. */
enum { TY_DOM_TOGETHER = 8 };

typedef struct ty_dom_beams {
    int32_t count;
    const ty_source* sources[TY_DOM_TOGETHER];
    float factor[TY_DOM_TOGETHER][3]; /* of the light, for each channel that is solved for */
    float* scattered[3]; /* per plane of the medium, beam by beam: sigma_s times their fluence on the cells of
                            ordinates */
} ty_dom_beams;

ty_result ty_dom_beams_create(const ty_dom_job* job, ty_dom_beams* beams);
void ty_dom_beams_destroy(const ty_dom_job* job, ty_dom_beams* beams);
/* Whether a field's light can be taken so: where one g is that of all that scatters. */
bool ty_dom_beams_can(const ty_dom_scratch* scratch, const ty_light_field* field);
/* Takes a beam's light, which is alone on `field`, and its fluence on the cells of ordinates, per plane of the field
 * (NULL: not asked for). */
void ty_dom_beams_take(ty_dom_job* job, ty_dom_beams* beams, const ty_source* source, const ty_light_field* field,
                       const ty_dom_scratch* scratch, float* const fluence[3]);
/* Adds what was taken and not added yet to q_lm. */
void ty_dom_beams_add(ty_dom_job* job, ty_dom_beams* beams, const ty_dom_scratch* scratch);

/* What of a field's light, per unit of a plane of it, a channel that is solved for gets; 0: nothing. */
float ty_dom_channel_factor(const ty_dom* light, const ty_light_field* field, int32_t plane, int32_t channel);

/* ---- lights that have no field of their own ---- */

/* Parts for `count` groups of lights, of which those that are own have none. Errors: TY_ERROR_MEMORY. */
ty_result ty_dom_parts_create(ty_dom_job* job, const ty_source_group* groups, int32_t count);
/* Adds one source's fluence, that of a group without a field of its own, to its part: as planes of the cells of
 * ordinates. */
void ty_dom_parts_add(ty_dom_job* job, const ty_source* source, int32_t planes, float* const fluence[3]);
/* Once all were added. */
void ty_dom_parts_end(ty_dom_job* job);
void ty_dom_parts_destroy(ty_dom* light);
/* Pieces of environments, once parts are there. Errors: TY_ERROR_MEMORY. */
ty_result ty_dom_sky_find(ty_dom_job* job);
void ty_dom_sky_destroy(ty_dom* light);

#endif
