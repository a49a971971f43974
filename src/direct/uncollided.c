/* Sources, one after the other, into fields. */
#include "direct/uncollided.h"

#include "base/context.h"
#include "base/float_mode.h"
#include "direct/beam.h"
#include "direct/lamp.h"
#include "scene/scene.h"

enum { CHUNK = 1 << 15 };

/* ---- fields ---- */

ty_result ty_light_field_create(const ty_grid_medium* medium, bool with_flux, ty_light_field** out) {
    ty_context* context = medium->context;
    ty_light_field* field = ty_alloc_array(context, 1, sizeof *field, true);
    if (field == NULL) return TY_ERROR_MEMORY;
    field->context = context;
    field->cells = medium->cells;
    bool whole = true;
    for (int c = 0; c < 3 && whole; ++c) {
        field->fluence[c] = ty_alloc_array(context, field->cells, sizeof(float), true);
        whole = field->fluence[c] != NULL;
        for (int a = 0; a < 3 && whole && with_flux; ++a) {
            field->flux[c][a] = ty_alloc_array(context, field->cells, sizeof(float), true);
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

void ty_light_field_destroy(ty_light_field* field) {
    if (field == NULL) return;
    for (int c = 0; c < 3; ++c) {
        ty_free_array(field->context, field->fluence[c], field->cells, sizeof(float));
        for (int a = 0; a < 3; ++a) ty_free_array(field->context, field->flux[c][a], field->cells, sizeof(float));
    }
    ty_free_array(field->context, field, 1, sizeof *field);
}

/* ---- beams ---- */

typedef struct add_job {
    const ty_source* source;
    const float* lit;
    ty_light_field* field;
    int32_t first, end; /* channels */
} add_job;

static void add_scaled(float* to, const float* lit, size_t count, float factor) {
#pragma omp simd
    for (size_t i = 0; i < count; ++i) to[i] += factor * lit[i];
}

static void add_chunk(void* user, int64_t index, int32_t worker) {
    (void)worker;
    const add_job* job = user;
    const size_t begin = (size_t)index * CHUNK, left = job->field->cells - begin, count = left < CHUNK ? left : CHUNK;
    const ty_vec way = job->source->direction;
    const float ways[3] = {way.x, way.y, way.z};
    const unsigned state = ty_flush_denormals();
    for (int32_t c = job->first; c < job->end; ++c) {
        const float color = job->source->color[c];
        add_scaled(job->field->fluence[c] + begin, job->lit + begin, count, color);
        for (int a = 0; a < 3 && job->field->flux[c][a] != NULL; ++a)
            add_scaled(job->field->flux[c][a] + begin, job->lit + begin, count, color * ways[a]);
    }
    ty_restore_denormals(state);
}

static ty_result begin_beam(const ty_scene* scene, const ty_grid_medium* medium, const ty_source* source,
                            ty_beam* beam) {
    double outside[2][3];
    ty_scene_surface_extent(scene, outside[0], outside[1]);
    return ty_beam_begin(ty_scene_get_view(scene), medium, outside, source->direction, beam);
}

/* lit: a plane to work in. */
static ty_result add_beam(const ty_scene* scene, const ty_grid_medium* medium, float* const extinction[3],
                          const ty_source* source, float* lit, ty_light_field* field) {
    ty_beam beam;
    ty_result result = begin_beam(scene, medium, source, &beam);
    const int32_t channels = 3 / medium->planes;
    for (int32_t p = 0; p < medium->planes && result == TY_OK; ++p) {
        result = ty_beam_pass(&beam, medium, extinction[p], lit, NULL);
        if (result != TY_OK) break;
        add_job job = {.source = source, .lit = lit, .field = field, .first = p, .end = p + channels};
        ty_parallel_for(medium->context, (int64_t)((medium->cells + CHUNK - 1) / CHUNK), add_chunk, &job);
    }
    ty_beam_end(&beam);
    return result;
}

static ty_result pass_beam(const ty_scene* scene, const ty_grid_medium* medium, float* const extinction[3],
                           const ty_source* source, float* const planes[3], ty_beam_power* power) {
    ty_beam beam;
    ty_result result = begin_beam(scene, medium, source, &beam);
    double passed[3][2] = {{0}};
    for (int32_t p = 0; p < medium->planes && result == TY_OK; ++p)
        result = ty_beam_pass(&beam, medium, extinction[p], planes[p], power != NULL ? passed[p] : NULL);
    for (int32_t c = 0; c < 3 && power != NULL; ++c) {
        power->entering[c] = passed[medium->planes == 3 ? c : 0][0];
        power->leaving[c] = passed[medium->planes == 3 ? c : 0][1];
    }
    ty_beam_end(&beam);
    return result;
}

/* ---- all ---- */

static bool has_beams(const ty_source* sources, int32_t count) {
    for (int32_t i = 0; i < count; ++i)
        if (sources[i].kind == TY_SOURCE_BEAM) return true;
    return false;
}

ty_result ty_uncollided_add(const ty_scene* scene, const ty_grid_medium* medium, float* const extinction[3],
                            const ty_source* sources, int32_t count, ty_light_field* field) {
    const ty_scene_view* view = ty_scene_get_view(scene);
    if (view == NULL) return TY_ERROR_ARGUMENT;
    if (extinction == NULL) extinction = medium->extinction;
    float* lit = NULL;
    if (has_beams(sources, count)) {
        lit = ty_alloc_array(medium->context, medium->cells, sizeof *lit, false);
        if (lit == NULL) return TY_ERROR_MEMORY;
    }
    const ty_lamp_out out = {.fluence = field->fluence, .flux = field->flux[0][0] != NULL ? field->flux : NULL};
    ty_result result = TY_OK;
    for (int32_t i = 0; i < count && result == TY_OK; ++i)
        result = sources[i].kind == TY_SOURCE_BEAM ? add_beam(scene, medium, extinction, &sources[i], lit, field)
                                                   : ty_lamp_add(view, medium, extinction, &sources[i], &out);
    ty_free_array(medium->context, lit, medium->cells, sizeof *lit);
    return result;
}

ty_result ty_uncollided_transmittance(const ty_scene* scene, const ty_grid_medium* medium, float* const extinction[3],
                                      const ty_source* source, float* const planes[3], ty_beam_power* power) {
    const ty_scene_view* view = ty_scene_get_view(scene);
    if (view == NULL) return TY_ERROR_ARGUMENT;
    if (extinction == NULL) extinction = medium->extinction;
    if (source->kind == TY_SOURCE_BEAM) return pass_beam(scene, medium, extinction, source, planes, power);
    const ty_lamp_out out = {.transmittance = planes};
    return ty_lamp_add(view, medium, extinction, source, &out);
}
