/* Samples grouped by light, and the lights with a dedicated field, whose phase function stays sharp. */
#ifndef TY_DIRECT_UNCOLLIDED_LIGHT_GROUPS_H
#define TY_DIRECT_UNCOLLIDED_LIGHT_GROUPS_H

#include "base/progress.h"
#include "direct/single/single.k.h"
#include "direct/uncollided/uncollided.h"

/* Consecutive samples of one light. */
typedef struct ty_light_group {
    int32_t first, count;
    ty_vec center;  /* mean position of points, m */
    bool dedicated; /* it has a field of its own, as its light comes from one direction or one point */
} ty_light_group;

/* Groups all samples; at most max_dedicated of the groups are dedicated. box: region of interest. point_radius: radius
 * up to which area lights and spheres count as points at any distance from it, m; 0: they do where it is far away.
 * groups: room for one per sample. Returns the number of groups. */
int32_t ty_light_groups_find(const ty_scene* scene, const ty_grid_box* box, const ty_discrete_light* sources,
                             int32_t count, int32_t max_dedicated, float point_radius, ty_light_group* groups);
/* An empty field for the dedicated groups, or for the others; of one plane if their colors allow it. */
ty_result ty_light_groups_field(const ty_discrete_light* sources, const ty_light_group* groups, int32_t count,
                                bool dedicated, const ty_grid_medium* medium, bool with_flux, ty_light_field** out);
/* A field's fluence for single scattering: of a dedicated group, or (NULL) of the aggregate. */
ty_light_fluence ty_light_group_fluence(const ty_discrete_light* sources, const ty_light_group* group,
                                        const ty_light_field* field);

/* Computes the uncollided light of all samples: of the dedicated groups in fields[0], fields[1] ..., of all others,
 * with its flux, in fields[max_dedicated]. fluences: one per field, the aggregate's last; *count: their number. The
 * caller destroys the fields, after errors, too. Reports the stage "direct light". Errors: TY_ERROR_MEMORY,
 * TY_CANCELLED. */
ty_result ty_light_groups_solve(const ty_scene* scene, const ty_grid_medium* medium, float* const extinction[3],
                                const ty_discrete_light_set* samples, int32_t max_dedicated, ty_part_progress* progress,
                                ty_light_field** fields, ty_light_fluence* fluences, int32_t* count);

/* True if all samples' colors are multiples of `color`: one plane is enough for all channels. */
bool ty_discrete_lights_share_color(const ty_discrete_light* sources, int32_t count, const float color[3]);

#endif
