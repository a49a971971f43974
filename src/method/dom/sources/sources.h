/* Samples of all lights, their uncollided fluence, and the moments of its first-collision source. */
#ifndef TY_METHOD_DOM_SOURCES_SOURCES_H
#define TY_METHOD_DOM_SOURCES_SOURCES_H

#include "method/dom/job.h"

/* Fills job->sources, and finds out if all channels are multiples of one. */
ty_result ty_dom_collect_lights(ty_dom_job* job);
/* The uncollided fluence of all sources on fine cells, and q_lm. */
ty_result ty_dom_find_uncollided(ty_dom_job* job);

/* sigma* of fine cells, per plane of the medium, by which uncollided light is attenuated. */
void ty_dom_uncollided_extinction(const ty_dom_job* job, float* const planes[3]);

/* ---- the first-collision source of one light ---- */

enum { TY_DOM_MEANS = TY_DOM_BANDS_MAX + 1 };

/* Work memory, and the mean cosines of fine cells. */
typedef struct ty_dom_scratch {
    float* scattered; /* of fine cells: sigma_s g^l times fluence */
    float* means;     /* of coarse cells, TY_DOM_MEANS planes */
    bool uniform[3];  /* all that scatters on a plane of the medium has one g */
    float g[3];       /* that g */
} ty_dom_scratch;

ty_result ty_dom_scratch_create(const ty_dom_job* job, ty_dom_scratch* scratch);
void ty_dom_scratch_destroy(const ty_dom_job* job, ty_dom_scratch* scratch);
/* Adds the first-collision source of a field to q_lm. uncollided: the field's fluence, TY_FLUENCE_DIRECTIONAL or
 * _POINT. mean_cosine: of directional light about its direction. */
void ty_dom_add_first_collisions(ty_dom_job* job, const ty_light_field* field, const ty_light_fluence* uncollided,
                                 float mean_cosine, ty_dom_scratch* scratch);

/* Fills job->centers, from the uncollided fluence of all lights. Errors: TY_ERROR_MEMORY. */
ty_result ty_dom_find_centers(ty_dom_job* job);

/* Several directional samples without dedicated fields, whose moments are added to q_lm in one pass over its planes. */
enum { TY_DOM_BATCH = 8 };

typedef struct ty_dom_collimated_batch {
    int32_t count;
    const ty_discrete_light* sources[TY_DOM_BATCH];
    float factor[TY_DOM_BATCH][3]; /* of the fluence, for each channel that is solved for */
    float* scattered[3];           /* per plane of the medium, sample by sample: sigma_s times the fluence, on coarse
                                      cells */
} ty_dom_collimated_batch;

ty_result ty_dom_collimated_batch_create(const ty_dom_job* job, ty_dom_collimated_batch* batch);
void ty_dom_collimated_batch_destroy(const ty_dom_job* job, ty_dom_collimated_batch* batch);
/* Says if the batch can take a field: all that scatters must have one g. */
bool ty_dom_collimated_batch_accepts(const ty_dom_scratch* scratch, const ty_light_field* field);
/* Takes a sample whose light alone is on `field`. fluence: receives its means on coarse cells, per plane of the field
 * (NULL: not asked for). */
void ty_dom_collimated_batch_take(ty_dom_job* job, ty_dom_collimated_batch* batch, const ty_discrete_light* source,
                                  const ty_light_field* field, const ty_dom_scratch* scratch, float* const fluence[3]);
/* Adds the samples that were taken to q_lm and empties the batch. */
void ty_dom_collimated_batch_flush(ty_dom_job* job, ty_dom_collimated_batch* batch, const ty_dom_scratch* scratch);

/* The factor from a plane of a field to a channel that is solved for; 0: the channel has no light of that plane. */
float ty_dom_channel_factor(const ty_dom* light, const ty_light_field* field, int32_t plane, int32_t channel);

/* ---- lights without a dedicated field ---- */

/* Empty clusters for the groups of lights without a dedicated field. Errors: TY_ERROR_MEMORY. */
ty_result ty_dom_clusters_create(ty_dom_job* job, const ty_light_group* groups, int32_t count);
/* Adds a sample's fluence, as planes of coarse cells, to the nearest cluster. */
void ty_dom_clusters_add(ty_dom_job* job, const ty_discrete_light* source, int32_t planes, float* const fluence[3]);
/* Normalises the clusters once all samples were added. */
void ty_dom_clusters_end(ty_dom_job* job);
void ty_dom_clusters_destroy(ty_dom* light);
/* Radiance that the clusters scatter towards the eye, as the fluence of an isotropic scatterer, and their fluence; both
 * times the clusters' colors. channels: 1: the sum of all, 3. Errors: TY_ERROR_MEMORY,
 * TY_CANCELLED. */
ty_result ty_dom_evaluate_clusters(const ty_dom* light, const double eye[3], int32_t channels,
                                   ty_part_progress* progress, float* const radiance_sum[3],
                                   float* const fluence_sum[3]);
/* Clusters of environments, after ty_dom_clusters_end. Errors: TY_ERROR_MEMORY. */
ty_result ty_dom_environment_find(ty_dom_job* job);
void ty_dom_environment_destroy(ty_dom* light);

#endif
