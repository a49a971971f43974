/* Adds the light of samples to fields, one after another. */
#include "direct/uncollided/uncollided.h"

#include "base/context.h"
#include "base/mapping.h"
#include "direct/uncollided/collimated.h"
#include "direct/uncollided/point_light.h"
#include "direct/uncollided/repeated.h"
#include "scene/scene.h"

/* ---- fields ---- */

static ty_result create_field(const ty_grid_medium* medium, bool with_flux, int32_t planes, ty_light_field** out) {
    ty_context* context = medium->context;
    ty_light_field* field = ty_alloc_array(context, 1, sizeof *field, true);
    if (field == NULL) return TY_ERROR_MEMORY;
    field->context = context;
    field->cells = medium->cells;
    field->planes = planes;
    bool whole = true;
    for (int c = 0; c < planes && whole; ++c) {
        field->fluence[c] = ty_alloc_large(context, field->cells, sizeof(float), true);
        whole = field->fluence[c] != NULL;
        for (int a = 0; a < 3 && whole && with_flux; ++a) {
            field->flux[c][a] = ty_alloc_large(context, field->cells, sizeof(float), true);
            whole = field->flux[c][a] != NULL;
        }
    }
    if (!whole) {
        ty_light_field_destroy(field);
        return TY_ERROR_MEMORY;
    }
    *out = field;
    return TY_OK;
}

ty_result ty_light_field_create(const ty_grid_medium* medium, bool with_flux, ty_light_field** out) {
    return create_field(medium, with_flux, 3, out);
}

ty_result ty_light_field_create_shared(const ty_grid_medium* medium, bool with_flux, const float color[3],
                                       ty_light_field** out) {
    if (medium->planes != 1)
        return ty_fail(medium->context, TY_ERROR_ARGUMENT, "light: a plane for all channels of a coloured medium");
    ty_light_field* field = NULL;
    const ty_result result = create_field(medium, with_flux, 1, &field);
    if (result != TY_OK) return result;
    memcpy(field->color, color, sizeof field->color);
    *out = field;
    return TY_OK;
}

void ty_light_field_destroy(ty_light_field* field) {
    if (field == NULL) return;
    for (int c = 0; c < 3; ++c) {
        ty_free_large(field->context, field->fluence[c], field->cells, sizeof(float));
        for (int a = 0; a < 3; ++a) ty_free_large(field->context, field->flux[c][a], field->cells, sizeof(float));
    }
    ty_free_array(field->context, field, 1, sizeof *field);
}

/* ---- parallel light ---- */

typedef struct add_job {
    const ty_scene* scene;
    const ty_grid_medium* medium;
    float* const* extinction;
    ty_light_field* field;
    ty_transpose_scratch* buffer; /* per plane of the medium; NULL: allocated for each sweep */
    ty_part_progress progress;    /* its span: of one source */
} add_job;

/* A source's color in units of a field's planes. */
static void color_of_planes(const ty_light_field* field, const ty_discrete_light* source, float color[3]) {
    memcpy(color, source->color, 3 * sizeof *color);
    if (field->planes == 3) return;
    color[0] = (source->color[0] + source->color[1] + source->color[2]) /
               (field->color[0] + field->color[1] + field->color[2]);
}

/* A scene without surfaces, with one light whose values are not used. */
static const ty_light_view unused_light;
static const ty_scene_view empty_scene = {.lights = {.lights = &unused_light, .count = 1}};

/* scene: whose surfaces cast shadows; NULL: none. */
static ty_result begin_collimated(const ty_scene* scene, const ty_grid_medium* medium, const ty_discrete_light* source,
                                  ty_collimated* beam) {
    double outside[2][3] = {{0}};
    if (scene == NULL) return ty_collimated_begin(&empty_scene, medium, outside, source->direction, beam);
    ty_scene_surface_extent(scene, outside[0], outside[1]);
    return ty_collimated_begin(ty_scene_get_view(scene), medium, outside, source->direction, beam);
}

/* Lists the planes of the field that extinction plane p contributes to, with a source's factors. */
static int32_t choose_planes(const add_job* job, const ty_discrete_light* source, int32_t p,
                             float* planes[TY_TUBE_PLANES_MAX], float factor[TY_TUBE_PLANES_MAX]) {
    const ty_light_field* field = job->field;
    const int32_t end = job->medium->planes == 3 ? p + 1 : field->planes;
    const float direction[4] = {1, source->direction.x, source->direction.y, source->direction.z};
    float color[3];
    int32_t count = 0;
    color_of_planes(field, source, color);
    for (int32_t c = p; c < end; ++c)
        for (int32_t a = -1; a < 3; ++a) {
            float* plane = a < 0 ? field->fluence[c] : field->flux[c][a];
            if (plane == NULL) continue;
            planes[count] = plane;
            factor[count++] = color[c] * direction[a + 1];
        }
    return count;
}

/* Adds directions with one sweep axis. */
static ty_result add_collimated(add_job* job, const ty_discrete_light* const* sources, int32_t count) {
    ty_collimated passing[TY_COLLIMATED_MAX];
    ty_part_progress progress = job->progress;
    progress.span *= (double)count / job->medium->planes;
    ty_collimated_batch beams = {.beams = passing, .progress = &progress};
    ty_result result = TY_OK;
    for (int32_t begun = 0; begun < count && result == TY_OK; ++begun, ++beams.count)
        result = begin_collimated(job->scene, job->medium, sources[begun], &passing[begun]);
    for (int32_t p = 0; p < job->medium->planes && result == TY_OK; ++p) {
        beams.extinction = job->extinction[p];
        beams.scratch = job->buffer != NULL ? &job->buffer[p] : NULL;
        for (int32_t i = 0; i < count; ++i)
            beams.plane_count = choose_planes(job, sources[i], p, beams.planes, beams.factor[i]);
        result = ty_collimated_sweep(&beams, job->medium);
        progress.from += progress.span;
    }
    for (int32_t i = 0; i < beams.count; ++i) ty_collimated_end(&passing[i]);
    job->progress.from += count * job->progress.span;
    job->progress.reported = progress.reported;
    return result;
}

/* Adds all directions through a grid that repeats, one after another. */
static ty_result add_repeated(add_job* job, const ty_discrete_light* sources, int32_t count) {
    ty_result result = TY_OK;
    for (int32_t i = 0; i < count && result == TY_OK; ++i) {
        ty_repeated_beam beam = {.direction = sources[i].direction};
        for (int32_t p = 0; p < job->medium->planes && result == TY_OK; ++p) {
            beam.extinction = job->extinction[p];
            beam.plane_count = choose_planes(job, &sources[i], p, beam.planes, beam.factor);
            result = ty_repeated_sweep(job->medium, &beam);
        }
        if (result == TY_OK) result = ty_part_show(&job->progress, "direct light", 1);
        job->progress.from += job->progress.span;
    }
    return result;
}

/* Adds all directions, those with one sweep axis together. */
static ty_result add_all_collimated(add_job* job, const ty_discrete_light* sources, int32_t count) {
    ty_result result = TY_OK;
    if (job->medium->periodic != 0) return add_repeated(job, sources, count);
    for (int32_t sweep = 0; sweep < 6; ++sweep) {
        const ty_discrete_light* together[TY_COLLIMATED_MAX];
        int32_t found = 0;
        for (int32_t i = 0; i < count && result == TY_OK; ++i) {
            if (sources[i].kind != TY_DISCRETE_DIRECTIONAL ||
                ty_collimated_sweep_axis(job->medium, sources[i].direction) != sweep)
                continue;
            together[found++] = &sources[i];
            if (found < TY_COLLIMATED_MAX) continue;
            result = add_collimated(job, together, found);
            found = 0;
        }
        if (found > 0 && result == TY_OK) result = add_collimated(job, together, found);
    }
    return result;
}

static ty_result sweep_transmittance(const ty_scene* scene, const ty_grid_medium* medium, float* const extinction[3],
                                     const ty_discrete_light* source, float* const planes[3],
                                     ty_collimated_power* power) {
    ty_collimated beam;
    ty_collimated_batch beams = {.beams = &beam, .count = 1, .plane_count = 1, .factor = {{1}}};
    ty_result result = begin_collimated(scene, medium, source, &beam);
    double power_of_plane[3][2] = {{0}};
    for (int32_t p = 0; p < medium->planes && result == TY_OK; ++p) {
        memset(planes[p], 0, medium->cells * sizeof *planes[p]);
        beams.planes[0] = planes[p];
        beams.extinction = extinction[p];
        result = ty_collimated_sweep(&beams, medium);
        if (result == TY_OK && power != NULL) result = ty_collimated_power_of(&beam, power_of_plane[p]);
    }
    for (int32_t c = 0; c < 3 && power != NULL; ++c) {
        power->entering[c] = power_of_plane[medium->planes == 3 ? c : 0][0];
        power->leaving[c] = power_of_plane[medium->planes == 3 ? c : 0][1];
    }
    ty_collimated_end(&beam);
    return result;
}

/* ---- all ---- */

static ty_result add_point(add_job* job, const ty_discrete_light* source) {
    ty_light_field* field = job->field;
    ty_point_light_target out = {
        .planes = field->planes, .fluence = field->fluence, .flux = field->flux[0][0] != NULL ? field->flux : NULL};
    color_of_planes(field, source, out.color);
    const ty_result result =
        ty_point_light_add(ty_scene_get_view(job->scene), job->medium, job->extinction, source, &out, &job->progress);
    job->progress.from += job->progress.span;
    return result;
}

ty_result ty_uncollided_add_reusing(const ty_scene* scene, const ty_grid_medium* medium, float* const extinction[3],
                                    const ty_discrete_light* sources, int32_t count, ty_light_field* field,
                                    ty_transpose_scratch scratch[3], ty_progress_fn progress, void* progress_user) {
    if (ty_scene_get_view(scene) == NULL) return TY_ERROR_ARGUMENT;
    add_job job = {.scene = scene,
                   .medium = medium,
                   .extinction = extinction != NULL ? extinction : medium->extinction,
                   .field = field,
                   .buffer = scratch,
                   .progress = ty_part_begin(progress, progress_user, 0, 1.0 / count)};
    job.progress.reported = job.progress.begun;
    ty_result result = add_all_collimated(&job, sources, count);
    for (int32_t i = 0; i < count && result == TY_OK; ++i)
        if (sources[i].kind == TY_DISCRETE_POINT) result = add_point(&job, &sources[i]);
    return result;
}

ty_result ty_uncollided_add_with_progress(const ty_scene* scene, const ty_grid_medium* medium,
                                          float* const extinction[3], const ty_discrete_light* sources, int32_t count,
                                          ty_light_field* field, ty_progress_fn progress, void* progress_user) {
    return ty_uncollided_add_reusing(scene, medium, extinction, sources, count, field, NULL, progress, progress_user);
}

ty_result ty_uncollided_add(const ty_scene* scene, const ty_grid_medium* medium, float* const extinction[3],
                            const ty_discrete_light* sources, int32_t count, ty_light_field* field) {
    return ty_uncollided_add_with_progress(scene, medium, extinction, sources, count, field, NULL, NULL);
}

static ty_result point_transmittance(const ty_scene_view* view, const ty_grid_medium* medium,
                                     float* const extinction[3], const ty_discrete_light* source,
                                     float* const planes[3]) {
    const ty_point_light_target out = {.transmittance = planes};
    ty_part_progress progress = ty_part_begin(NULL, NULL, 0, 1);
    return ty_point_light_add(view, medium, extinction, source, &out, &progress);
}

ty_result ty_uncollided_transmittance(const ty_scene* scene, const ty_grid_medium* medium, float* const extinction[3],
                                      const ty_discrete_light* source, float* const planes[3],
                                      ty_collimated_power* power) {
    const ty_scene_view* view = ty_scene_get_view(scene);
    if (view == NULL) return TY_ERROR_ARGUMENT;
    if (extinction == NULL) extinction = medium->extinction;
    if (source->kind == TY_DISCRETE_DIRECTIONAL)
        return sweep_transmittance(scene, medium, extinction, source, planes, power);
    return point_transmittance(view, medium, extinction, source, planes);
}

ty_result ty_uncollided_in_media(const ty_grid_medium* medium, const ty_discrete_light* source,
                                 float* const planes[3]) {
    if (source->kind == TY_DISCRETE_DIRECTIONAL)
        return sweep_transmittance(NULL, medium, medium->extinction, source, planes, NULL);
    return point_transmittance(&empty_scene, medium, medium->extinction, source, planes);
}
