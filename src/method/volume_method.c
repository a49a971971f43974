#include "method/volume_method.h"

#include "base/context.h"
#include "base/isa.h"
#include "scene/interiors.h"
#include "solve/enclosed/enclosed.h"

#include <string.h>

/* ---- defs ---- */

static ty_volume_options options_of(const ty_volume_method* method, const void* def) {
    ty_volume_options options;
    memcpy(&options, (const char*)def + method->options_at, sizeof options);
    return options;
}

static int32_t spacing_of(const ty_volume_method* method, const void* def) {
    int32_t spacing;
    memcpy(&spacing, (const char*)def + method->spacing_at, sizeof spacing);
    return spacing;
}

static ty_image_options image_options(const ty_volume_options* o) {
    return (ty_image_options){o->width, o->height, o->spp, o->seed, o->step, o->aovs};
}

ty_result ty_volume_take_def(const ty_volume_method* method, ty_context* context, const void* def, void* own) {
    ty_result result = ty_options_take(context, method->table, def, own);
    if (result == TY_OK && method->check != NULL) result = method->check(context, own);
    if (result != TY_OK) return result;
    const ty_volume_options options = options_of(method, own);
    const ty_image_options image = image_options(&options);
    return ty_check_image(context, method->name, &image, TY_MARCH_AOVS);
}

/* ---- solving and viewing ---- */

static double* seconds_at(void* stats, size_t offset) {
    return (double*)(void*)((char*)stats + offset);
}

static void set_isa(const ty_volume_method* method, void* stats) {
    const char* isa = ty_isa_name(ty_best_isa());
    memcpy((char*)stats + method->isa, &isa, sizeof isa);
}

/* own: TY_VOLUME_DEF_MAX bytes. stats: the caller's, or NULL. totals: the call's, TY_METHOD_STATS_MAX bytes. */
static ty_result begin_call(const ty_volume_method* method, const ty_scene* scene, const void* def, void* own,
                            const void* stats, void* totals, ty_volume_call* call) {
    ty_context* context = ty_scene_context(scene);
    ty_result result = ty_volume_take_def(method, context, def, own);
    if (result == TY_OK) result = ty_take_stats(context, stats, method->stats_function, totals, method->stats_bytes);
    *call = (ty_volume_call){.context = context, .scene = scene, .def = own, .fraction = 1, .stats = totals};
    if (result != TY_OK) return result;
    call->options = options_of(method, own);
    call->ray_spacing = spacing_of(method, own);
    return TY_OK;
}

static ty_result solve(const ty_volume_method* method, ty_volume_call* call) {
    ty_result result = ty_scene_check_media(call->scene, method->name, method->repeats);
    if (result != TY_OK) return result;
    if (!ty_enclosed_has_all_media(call->scene)) ty_interiors_warn(call->scene, method->name, TY_VOLUME_OF_INTERIORS);
    call->progress = ty_part_begin(call->options.progress, call->options.progress_user, 0, 0);
    call->light = ty_alloc_array(call->context, 1, method->light_bytes, true);
    if (call->light == NULL) return TY_ERROR_MEMORY;
    const double begun = call->progress.begun;
    result = method->solve(call);
    *seconds_at(call->stats, method->seconds) = ty_wall_seconds() - begun;
    set_isa(method, call->stats);
    if (result == TY_OK) return TY_OK;
    method->destroy(call->light);
    call->light = NULL;
    return result;
}

static ty_result view(const ty_volume_method* method, ty_volume_call* call, ty_image** out) {
    const double begun = ty_wall_seconds();
    ty_result result = ty_scene_check_open(call->scene, method->name);
    if (result == TY_OK) result = method->view(call, out);
    const double seconds = ty_wall_seconds() - begun;
    if (result != TY_OK) return result;
    *seconds_at(call->stats, method->march_seconds) = seconds;
    *seconds_at(call->stats, method->seconds) += seconds;
    set_isa(method, call->stats);
    return TY_OK;
}

ty_result ty_volume_solve_for(const ty_volume_method* method, const ty_scene* scene, const void* def, void* extra,
                              void** out, void* stats) {
    _Alignas(16) char own[TY_VOLUME_DEF_MAX], totals[TY_METHOD_STATS_MAX];
    ty_volume_call call;
    ty_result result = begin_call(method, scene, def, own, stats, totals, &call);
    call.extra = extra;
    if (result == TY_OK) result = solve(method, &call);
    *out = call.light;
    if (result == TY_OK) ty_give_stats(totals, method->stats_bytes, stats);
    return result;
}

ty_result ty_volume_solve(const ty_volume_method* method, const ty_scene* scene, const void* def, void** out,
                          void* stats) {
    return ty_volume_solve_for(method, scene, def, NULL, out, stats);
}

ty_result ty_volume_view(const ty_volume_method* method, const void* light, const ty_scene* scene, const void* def,
                         ty_image** out, void* stats) {
    _Alignas(16) char own[TY_VOLUME_DEF_MAX], totals[TY_METHOD_STATS_MAX];
    ty_volume_call call;
    *out = NULL;
    ty_result result = begin_call(method, scene, def, own, stats, totals, &call);
    if (result != TY_OK) return result;
    call.light = (void*)(uintptr_t)light; /* views leave it as it is */
    call.progress = ty_part_begin(call.options.progress, call.options.progress_user, 0, 1);
    result = view(method, &call, out);
    if (result == TY_OK) ty_give_stats(totals, method->stats_bytes, stats);
    return result;
}

/* kept: receives the light in place of what is there; NULL: it is freed. */
static ty_result render(const ty_volume_method* method, const ty_scene* scene, const void* def, void** kept,
                        ty_image** out, void* stats) {
    _Alignas(16) char own[TY_VOLUME_DEF_MAX], totals[TY_METHOD_STATS_MAX];
    const double begun = ty_wall_seconds(), fraction = method->solve_fraction;
    ty_volume_call call;
    *out = NULL;
    ty_result result = begin_call(method, scene, def, own, stats, totals, &call);
    call.fraction = fraction;
    if (result == TY_OK) result = ty_scene_check_open(scene, method->name);
    if (result == TY_OK) result = solve(method, &call);
    if (result != TY_OK) return result;
    call.progress = ty_part_begin(call.options.progress, call.options.progress_user, fraction, 1 - fraction);
    call.progress.begun = begun;
    result = view(method, &call, out);
    method->destroy(kept != NULL ? *kept : call.light);
    if (kept != NULL) *kept = call.light;
    ty_give_stats(totals, method->stats_bytes, stats);
    return result;
}

ty_result ty_volume_render(const ty_volume_method* method, const ty_scene* scene, const void* def, ty_image** out,
                           void* stats) {
    return render(method, scene, def, NULL, out, stats);
}

/* The same from the light of another frame, as far as the method can: not from that of another grid. */
static ty_result render_from(const ty_volume_method* method, const ty_scene* scene, char* def, void** light,
                             ty_image** out, void* stats) {
    void** kept = method->start_at > 0 ? light : NULL;
    if (kept == NULL || *kept == NULL) return render(method, scene, def, kept, out, stats);
    memcpy(def + method->start_at, kept, sizeof *kept);
    const ty_result result = render(method, scene, def, kept, out, stats);
    if (result != TY_ERROR_ARGUMENT) return result;
    ty_take_error(ty_scene_context(scene));
    method->destroy(*kept);
    *kept = NULL;
    memset(def + method->start_at, 0, sizeof *kept);
    return render(method, scene, def, kept, out, stats);
}

/* The def of a request, of TY_VOLUME_DEF_MAX bytes. */
static ty_result make_def(const ty_volume_method* method, void (*change)(void* def), const ty_scene* scene,
                          const ty_render_request* request, const ty_image* unscattered, char* def) {
    ty_options_init(method->table, def, method->table->bytes);
    const ty_result result = ty_method_options(scene, method->name, def);
    ty_volume_options options = options_of(method, def);
    TY_TAKE_REQUEST(&options, request);
    options.unscattered = unscattered;
    memcpy(def + method->options_at, &options, sizeof options);
    if (change != NULL) change(def);
    return result;
}

ty_result ty_volume_method_solve(const ty_volume_method* method, void (*change)(void* def), const ty_scene* scene,
                                 const ty_render_request* request, ty_solve_quality quality, void** light,
                                 ty_method_run* run) {
    _Alignas(16) char def[TY_VOLUME_DEF_MAX];
    *light = NULL;
    ty_result result = make_def(method, change, scene, request, NULL, def);
    if (method->free_camera != NULL) method->free_camera(def);
    if (quality != TY_SOLVE_FULL && method->coarsen != NULL) method->coarsen(def, quality);
    if (result == TY_OK) result = ty_volume_solve(method, scene, def, light, ty_method_stats(run, method->stats_bytes));
    return result;
}

ty_result ty_volume_method_view(const ty_volume_method* method, void (*change)(void* def), const void* light,
                                const ty_scene* scene, const ty_render_request* request, const ty_image* unscattered,
                                ty_image** out, ty_method_run* run) {
    _Alignas(16) char def[TY_VOLUME_DEF_MAX];
    *out = NULL;
    ty_result result = make_def(method, change, scene, request, unscattered, def);
    if (spacing_of(method, def) < request->ray_spacing)
        memcpy(def + method->spacing_at, &request->ray_spacing, sizeof request->ray_spacing);
    if (result == TY_OK)
        result = ty_volume_view(method, light, scene, def, out, ty_method_stats(run, method->stats_bytes));
    return result;
}

ty_result ty_volume_method_enclose(const ty_volume_method* method, const ty_scene* scene,
                                   const ty_render_request* request, ty_solve_quality quality, ty_enclosed** out,
                                   ty_enclosed_stats* stats) {
    _Alignas(16) char own[TY_VOLUME_DEF_MAX];
    ty_enclosed_def def = quality == TY_SOLVE_FULL ? ty_default_enclosed_def() : ty_coarse_enclosed_def();
    *out = NULL;
    ty_result result = make_def(method, NULL, scene, request, NULL, own);
    if (result != TY_OK) return result;
    def.diffusion = method->diffuses;
    if (method->interior_at > 0) {
        int32_t cells;
        memcpy(&cells, own + method->interior_at, sizeof cells);
        if (quality == TY_SOLVE_FULL)
            def.cells = cells;
        else if (cells != TY_AUTO && cells < def.cells)
            def.cells = cells;
    }
    if (quality == TY_SOLVE_COARSEST) def.cells = (def.cells + 1) / 2;
    return ty_solve_enclosed(scene, request, &def, out, stats);
}

ty_result ty_volume_method_render(const ty_volume_method* method, void (*change)(void* def), const ty_scene* scene,
                                  const ty_render_request* request, ty_image** out, ty_method_run* run) {
    _Alignas(16) char def[TY_VOLUME_DEF_MAX];
    ty_image* surfaces = NULL;
    ty_enclosed* enclosed = NULL;
    ty_result result = ty_scene_check_open(scene, method->name);
    if (result == TY_OK)
        result = ty_volume_method_enclose(method, scene, request, TY_SOLVE_FULL, &enclosed, &run->interiors);
    if (result == TY_OK) result = ty_trace_surfaces(scene, request, ty_enclosed_fields(enclosed), &surfaces, run);
    ty_enclosed_destroy(enclosed);
    run->own_seconds = run->interiors.seconds;
    run->path.seconds += run->interiors.seconds;
    /* The image of the surfaces shows media inside dielectrics already. */
    if (result == TY_OK && surfaces != NULL && (request->aovs & ~(uint32_t)TY_AOV_SAMPLES) == 0 &&
        ty_enclosed_has_all_media(scene)) {
        ty_method_stats(run, method->stats_bytes);
        set_isa(method, run->stats);
        run->enclosed = true;
        *out = surfaces;
        return TY_OK;
    }
    if (result == TY_OK) result = make_def(method, change, scene, request, surfaces, def);
    if (result == TY_OK)
        result = render_from(method, scene, def, request->light, out, ty_method_stats(run, method->stats_bytes));
    const double seconds = *seconds_at(run->stats, method->seconds);
    run->own_seconds += seconds;
    run->path.seconds += seconds;
    ty_image_destroy(surfaces);
    return result;
}

ty_march_def ty_volume_march_def(ty_volume_call* call) {
    const ty_image_options image = image_options(&call->options);
    ty_march_def march = ty_march_def_of(call->scene, &image);
    march.unscattered = call->options.unscattered;
    march.ray_spacing = call->ray_spacing;
    march.progress = ty_part_report;
    march.progress_user = &call->progress;
    return march;
}
