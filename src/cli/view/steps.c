/* The steps from a change to its final image. */
#include "cli/view/live_state.h"

#include "cli/session/session.h"

#include <math.h>
#include <string.h>

static const double full_surface_seconds = 0.2; /* between two full images of noisy surfaces */
enum { COARSEST = 8, PATH_SPP_MAX = 1 << 20 };

/* ---- pieces ---- */

bool view_report(void* user, const ty_progress* progress) {
    view_live* live = user;
    live->stage = progress->stage;
    live->fraction = progress->fraction;
    view_tell_status(live, false);
    if (live->moved > 0 && live->shown == VIEW_SHOWN_NOTHING) return !atomic_load(&live->stop);
    return !atomic_load(&live->interrupted);
}

/* Keeps the refusal of a method for the status, until something changes. Returns true: the step is done. */
static bool fail(view_live* live, ty_result result) {
    const char* text = ty_take_error(live->context);
    if (result == TY_CANCELLED) return true;
    snprintf(live->message, sizeof live->message, "%s", text[0] != '\0' ? text : ty_result_text(result));
    live->failed = true;
    live->received = 0;
    return true;
}

bool view_adds_surfaces(const view_live* live) {
    return live->method->takes_surfaces && live->has_surfaces;
}

static int32_t divided(int32_t side, double divisor) {
    return side > divisor ? (int32_t)(side / divisor) : 1;
}

static ty_render_request request_of(view_live* live, double divisor) {
    return (ty_render_request){.spp = 1,
                               .seed = ty_scene_render_settings(live->scene).seed,
                               .width = divided(live->width, divisor),
                               .height = divided(live->height, divisor),
                               .progress = view_report,
                               .progress_user = live};
}

/* ---- stages' times ---- */

/* "march_seconds" as "march"; the names are literals of the methods' tables. */
static void note_stages(view_live* live, const ty_method_run* run) {
    for (int32_t i = 0; i < live->method->stat_count; ++i) {
        const ty_stat* stat = &live->method->stats[i];
        double seconds;
        memcpy(&seconds, run->stats + stat->offset, sizeof seconds);
        if (!stat->stage || stat->type != TY_STAT_NUMBER || seconds <= 0) continue;
        int32_t at = 0;
        while (at < live->times.count && live->times.stages[at].name != stat->name) ++at;
        if (at == VIEW_STAGES_MAX) continue;
        live->times.stages[at].name = stat->name;
        live->times.stages[at].ms = 1e3 * seconds;
        if (at == live->times.count) ++live->times.count;
    }
}

/* ---- methods that solve once and view often ---- */

void view_live_drop_light(view_live* live) {
    for (int i = 0; i < TY_SOLVE_QUALITIES; ++i) {
        if (live->lights[i].media != NULL) live->light_method->destroy(live->lights[i].media);
        ty_enclosed_destroy(live->lights[i].enclosed);
        live->lights[i] = (view_light){.solved = false};
    }
    live->surfaces.enclosed = NULL;
    live->light_method = NULL;
    live->times.count = 0;
}

/* True if the image of the surfaces shows all media. */
static bool shows_all_media(const view_live* live) {
    return view_adds_surfaces(live) && ty_enclosed_has_all_media(live->scene);
}

static ty_result solve(view_live* live, ty_solve_quality quality) {
    const ty_render_request request = request_of(live, 1);
    const double begun = cli_wall_seconds();
    ty_method_run run = {.own_seconds = 0};
    view_light light = {.solved = true};
    ty_result result = TY_OK;
    if (live->light_method != live->method) view_live_drop_light(live);
    if (view_adds_surfaces(live))
        result = live->method->enclose(live->scene, &request, quality, &light.enclosed, &run.interiors);
    if (result == TY_OK && !shows_all_media(live))
        result = live->method->solve(live->scene, &request, quality, &light.media, &run);
    if (result != TY_OK) {
        ty_enclosed_destroy(light.enclosed);
        return result;
    }
    live->light_method = live->method;
    live->lights[quality] = light;
    live->solve_seconds[quality] = cli_wall_seconds() - begun;
    live->times.solve = 1e3 * live->solve_seconds[quality];
    note_stages(live, &run);
    return TY_OK;
}

bool view_has_light(const view_live* live, ty_solve_quality quality) {
    return live->light_method == live->method && live->lights[quality].solved;
}

/* Adds samples to the surfaces' own light for some seconds, and at least once; from none where its size or the scene
 * changed. */
static ty_result trace_surfaces(view_live* live, ty_solve_quality quality, double divisor, bool anew, double seconds) {
    if (!view_adds_surfaces(live)) return TY_OK;
    const int32_t width = divided(live->width, divisor), height = divided(live->height, divisor);
    if (anew && !view_accumulation_reset(&live->surfaces, width, height, true)) return TY_ERROR_MEMORY;
    live->surfaces.enclosed = ty_enclosed_fields(live->lights[quality].enclosed);
    const double begun = cli_wall_seconds();
    double last, now = begun;
    ty_result result;
    do {
        last = now;
        result = view_accumulation_add(&live->surfaces, live->scene, PATH_SPP_MAX, view_report, live);
        now = cli_wall_seconds();
        if (last == begun && anew) live->surface_seconds = (now - begun) * divisor * divisor;
    } while (result == TY_OK && now + 2 * (now - last) < begun + seconds);
    live->times.surfaces = 1e3 * (now - begun);
    return result;
}

/* Views the light of media: all that the method shows but for the surfaces' own light. */
static ty_result view_media(view_live* live, ty_solve_quality quality, double divisor, int32_t ray_spacing) {
    ty_render_request request = request_of(live, divisor);
    ty_image *black = NULL, *image = NULL;
    ty_method_run run = {.own_seconds = 0};
    ty_result result = TY_OK;
    request.ray_spacing = ray_spacing;
    if (view_adds_surfaces(live)) result = ty_image_create_rgb(live->context, request.width, request.height, &black);
    const double begun = cli_wall_seconds();
    const view_light* light = &live->lights[quality];
    if (result == TY_OK && light->media != NULL)
        result = live->method->view(light->media, live->scene, &request, black, &image, &run);
    const double seconds = cli_wall_seconds() - begun;
    if (result == TY_OK) {
        live->times.view = 1e3 * seconds;
        if (ray_spacing == 0) live->view_seconds = seconds;
        note_stages(live, &run);
        float* rgb = view_make_room(&live->media, &live->media_capacity, request.width, request.height);
        if (rgb == NULL || !view_interleave(image != NULL ? image : black, rgb)) result = TY_ERROR_MEMORY;
    }
    ty_image_destroy(image);
    ty_image_destroy(black);
    return result;
}

/* Shows the light of media, and that of surfaces as far as it is traced in the same size. */
static ty_result show_sum(view_live* live, double divisor, bool final) {
    const int32_t width = divided(live->width, divisor), height = divided(live->height, divisor);
    const size_t values = 3 * (size_t)width * (size_t)height;
    float* rgb = view_pixels(live, width, height);
    if (rgb == NULL) return TY_ERROR_MEMORY;
    if (view_adds_surfaces(live))
        view_accumulation_mean(&live->surfaces, rgb);
    else
        memset(rgb, 0, values * sizeof *rgb);
    for (size_t i = 0; i < values; ++i) rgb[i] += live->media[i];
    view_show(live, VIEW_CHANNEL_METHOD, rgb, width, height, 0, final);
    return TY_OK;
}

/* Views the light of a quality in a coarse image, and learns what that takes with the surfaces. */
static ty_result view_coarse(view_live* live, ty_solve_quality quality, double divisor) {
    const double pixels = (double)divided(live->width, divisor) * divided(live->height, divisor);
    const ty_result result = view_media(live, quality, divisor, VIEW_COARSE_SPACING);
    if (result == TY_OK) view_coarse_note(live, quality, pixels, 1e-3 * live->times.view);
    return result;
}

/* The first image after a change: from the light that holds, or a coarse or quick solve. */
static ty_result show_coarse(view_live* live) {
    const ty_solve_quality quality = view_coarse_quality(live);
    const double divisor = view_coarse_divisor(live, quality);
    ty_result result = view_has_light(live, quality) ? TY_OK : solve(live, quality);
    if (result == TY_OK) result = trace_surfaces(live, quality, divisor, true, 0.5 * view_coarse_seconds);
    if (result == TY_OK) result = view_coarse(live, quality, divisor);
    if (result == TY_OK) result = show_sum(live, divisor, false);
    return result;
}

/* True while more samples of the surfaces would show in the image. */
static bool surfaces_are_noisy(const view_live* live) {
    if (!view_adds_surfaces(live)) return false;
    return view_accumulation_spp(&live->surfaces) < fmax(ty_scene_render_settings(live->scene).spp, 16);
}

/* At rest for a while: times a coarse view of the full light, and solves the coarse light if that view is slow, so that
 * the next move of the camera need not. Returns false if there is nothing to prepare. */
static bool prepare_coarse(view_live* live) {
    const view_times times = live->times;
    if (live->moved > 0 || live->coarse_seconds[TY_SOLVE_FULL] > 0 || !live->rested) return false;
    ty_result result = view_coarse(live, TY_SOLVE_FULL, view_coarse_divisor(live, TY_SOLVE_FULL));
    const ty_solve_quality quality = view_coarse_quality(live);
    if (result == TY_OK && !view_has_light(live, quality)) result = solve(live, quality);
    live->times = times;
    return result == TY_OK || fail(live, result);
}

/* Returns false when the method's image is final. */
static bool step_light(view_live* live) {
    if (live->shown == VIEW_SHOWN_NOTHING) {
        const ty_result result = show_coarse(live);
        if (result != TY_OK) return fail(live, result);
        live->shown = VIEW_SHOWN_COARSE;
        return true;
    }
    if (live->moved > 0) return false;
    ty_result result = TY_OK;
    if (!view_has_light(live, TY_SOLVE_FULL)) {
        result = solve(live, TY_SOLVE_FULL);
        return result == TY_OK || fail(live, result);
    }
    const bool first = live->shown == VIEW_SHOWN_COARSE;
    if (!first && !surfaces_are_noisy(live)) return prepare_coarse(live);
    if (first) result = view_media(live, TY_SOLVE_FULL, 1, 0);
    if (result == TY_OK) result = trace_surfaces(live, TY_SOLVE_FULL, 1, first, full_surface_seconds);
    if (result == TY_OK) result = show_sum(live, 1, !surfaces_are_noisy(live));
    if (result != TY_OK) return fail(live, result);
    live->shown = VIEW_SHOWN_FULL;
    live->has_difference = false;
    return true;
}

/* ---- methods that render at once ---- */

/* The divisor of both sides of their coarse images. */
static int32_t quick_divisor(const view_live* live) {
    if (live->view_seconds <= 0) return 4;
    const double divisor = ceil(pow(live->view_seconds / view_coarse_seconds, 1 / live->view_power));
    return (int32_t)fmax(1, fmin(divisor, COARSEST));
}

static void note_view(view_live* live, double seconds, int32_t divisor) {
    const double full = seconds * pow(divisor, live->view_power);
    live->view_seconds = live->view_seconds > 0 ? 0.5 * (live->view_seconds + full) : full;
}

static ty_result render_scene(view_live* live, int32_t divisor, ty_image** out, ty_method_run* run) {
    const ty_render_request request = request_of(live, divisor);
    return live->method->render(live->scene, &request, out, run);
}

bool view_step_render(view_live* live, view_render_fn render) {
    if (live->shown == VIEW_SHOWN_FULL || (live->shown == VIEW_SHOWN_COARSE && live->moved > 0)) return false;
    const bool coarse = live->shown == VIEW_SHOWN_NOTHING;
    const int32_t divisor = coarse ? quick_divisor(live) : 1;
    const bool lossy = live->remote && live->moved > 0; /* the image at rest follows, though it is the same */
    const bool full = divisor == 1 && !lossy;
    const double begun = cli_wall_seconds();
    ty_method_run run = {.own_seconds = 0};
    ty_image* image = NULL;
    ty_result result = render(live, divisor, &image, &run);
    const double seconds = cli_wall_seconds() - begun;
    if (result == TY_OK) {
        live->times.view = 1e3 * seconds;
        note_view(live, seconds, divisor);
        note_stages(live, &run);
        if (!view_show_image(live, image, full)) result = TY_ERROR_MEMORY;
    }
    ty_image_destroy(image);
    if (result != TY_OK) return fail(live, result);
    live->shown = full ? VIEW_SHOWN_FULL : VIEW_SHOWN_COARSE;
    return true;
}

/* ---- path: as the method, and as the reference ---- */

static bool show_path(view_live* live, bool as_method, bool final) {
    const view_accumulation* sum = &live->path;
    float* rgb = view_pixels(live, sum->width, sum->height);
    if (rgb == NULL) return fail(live, TY_ERROR_MEMORY);
    view_accumulation_mean(sum, rgb);
    const double spp = view_accumulation_spp(sum);
    if (as_method) view_show(live, VIEW_CHANNEL_METHOD, rgb, sum->width, sum->height, spp, final);
    view_show(live, VIEW_CHANNEL_PATH, rgb, sum->width, sum->height, spp, false);
    return true;
}

static void compare(view_live* live) {
    const view_picture* picture = &live->pictures[VIEW_CHANNEL_METHOD]; /* written by this thread alone */
    if (live->shown != VIEW_SHOWN_FULL || surfaces_are_noisy(live) || picture->rgb == NULL ||
        picture->revision != live->revision)
        return;
    if (picture->width != live->path.width || picture->height != live->path.height) return;
    live->has_difference = view_accumulation_compare(&live->path, picture->rgb, &live->difference);
}

/* Adds a pass of path at the size of a divisor; the sums begin anew where revision or size are others. */
static bool pass_path(view_live* live, int32_t divisor, bool as_method) {
    const int32_t width = divided(live->width, divisor), height = divided(live->height, divisor);
    const bool anew = live->path_revision != live->revision || live->path.width != width || live->path.height != height;
    if (anew && !view_accumulation_reset(&live->path, width, height, false)) return fail(live, TY_ERROR_MEMORY);
    if (anew) live->has_difference = false;
    live->path_revision = live->revision;
    const double begun = cli_wall_seconds();
    const ty_result result = view_accumulation_add(&live->path, live->scene, PATH_SPP_MAX, view_report, live);
    if (result == TY_CANCELLED) return true;
    if (result != TY_OK) return fail(live, result);
    const double seconds = cli_wall_seconds() - begun;
    if (as_method) live->times.view = 1e3 * seconds;
    if (anew) live->path_seconds = seconds * divisor * divisor;
    if (!as_method) compare(live);
    return show_path(live, as_method, false);
}

/* The divisor of a first image by path. */
static int32_t path_divisor(const view_live* live) {
    if (live->path_seconds <= 0) return 4;
    const double divisor = ceil(sqrt(live->path_seconds / view_coarse_seconds));
    return (int32_t)fmax(1, fmin(divisor, COARSEST));
}

static bool step_path(view_live* live) {
    if (live->shown == VIEW_SHOWN_NOTHING) {
        pass_path(live, path_divisor(live), true);
        if (live->path_revision == live->revision && view_accumulation_spp(&live->path) > 0)
            live->shown = VIEW_SHOWN_COARSE;
        return true;
    }
    if (live->moved > 0 || view_accumulation_spp(&live->path) >= PATH_SPP_MAX) return false;
    live->shown = VIEW_SHOWN_FULL;
    return pass_path(live, 1, true);
}

/* ---- the next step ---- */

static bool step_reference(view_live* live) {
    if (!live->compare) return false;
    const bool coarse = live->path_revision != live->revision && live->moved > 0;
    if (!coarse && live->moved > 0) return false;
    if (view_accumulation_spp(&live->path) >= PATH_SPP_MAX && live->path_revision == live->revision) return false;
    return pass_path(live, coarse ? path_divisor(live) : 1, false);
}

/* While the surfaces of a full image converge, every other step is one of path, which would wait for seconds else. */
static bool is_due_to_path(view_live* live) {
    if (live->shown != VIEW_SHOWN_FULL || !live->compare || live->paused || !surfaces_are_noisy(live)) return false;
    live->path_next = !live->path_next;
    return live->path_next;
}

bool view_step_scene(view_live* live) {
    if (live->method == &ty_method_path) return step_path(live);
    if (is_due_to_path(live) && step_reference(live)) return true;
    const bool worked =
        !live->failed && (live->method->solve != NULL ? step_light(live) : view_step_render(live, render_scene));
    return worked || (!live->paused && step_reference(live));
}

bool view_live_step(view_live* live) {
    if (live->paused && live->shown != VIEW_SHOWN_NOTHING) return false;
    return live->source->step(live);
}
