/* Sources of one light together: which lights are worth a field of their own, so that their phase function stays sharp.
 */
#ifndef TY_DIRECT_UNCOLLIDED_LIGHT_GROUPS_H
#define TY_DIRECT_UNCOLLIDED_LIGHT_GROUPS_H

#include "direct/single/single.k.h"
#include "direct/uncollided/uncollided.h"

/* Consecutive sources of one light. */
typedef struct ty_light_group {
    int32_t first, count;
    ty_vec center;  /* of lamps, m */
    bool dedicated; /* whether it keeps its field: the phase function can be met from one direction, or one point */
} ty_light_group;

/* All groups; the first `most` that can be met so are own. box: where light is looked at. groups: room for one a
 * source. Returns how many there are. */
int32_t ty_light_groups_find(const ty_scene* scene, const ty_grid_box* box, const ty_discrete_light* sources,
                             int32_t count, int32_t max_dedicated, ty_light_group* groups);
/* A dark field for those of the groups that are own, or for the others: of one plane where that will do. */
ty_result ty_light_groups_field(const ty_discrete_light* sources, const ty_light_group* groups, int32_t count,
                                bool dedicated, const ty_grid_medium* medium, bool with_flux, ty_light_field** out);
/* A field's light as whoever scatters it has it: of an own group, or (NULL) of many. */
ty_light_fluence ty_light_group_fluence(const ty_discrete_light* sources, const ty_light_group* group,
                                        const ty_light_field* field);

/* Whether sources' light differs between channels by `color` alone: then one plane will do for all. */
bool ty_discrete_lights_share_color(const ty_discrete_light* sources, int32_t count, const float color[3]);

#endif
