#include "solve/enclosed/enclosed.h"

#include "base/context.h"
#include "base/progress.h"
#include "direct/lights/discretize.h"
#include "solve/enclosed/body.h"

struct ty_enclosed {
    ty_context* context;
    const ty_enclosed_def* def; /* of the solve that runs */
    int32_t count, body_count;
    ty_enclosed_field* fields; /* per interior */
    ty_enclosed_body* bodies;  /* count at most */
};

ty_enclosed_def ty_default_enclosed_def(void) {
    return (ty_enclosed_def){
        .cells = TY_AUTO, .directions = 96, .environment_beams = 64, .surface_points = 16, .rays = 16, .rounds = 2};
}

ty_enclosed_def ty_coarse_enclosed_def(void) {
    return (ty_enclosed_def){
        .cells = 16, .directions = 24, .environment_beams = 16, .surface_points = 4, .rays = 2, .rounds = 1};
}

/* ---- interiors ---- */

/* The scattering medium that fills an interior; -1: none. A rough surface counts as a smooth one here. */
static int32_t filling_medium(const ty_scene_view* scene, int32_t interior) {
    const int32_t surface = scene->interiors[interior].surface;
    if (surface < 0) return -1;
    for (int32_t m = 0; m < scene->medium_count; ++m) {
        const ty_medium_view* medium = &scene->media[m];
        const float scattering = medium->sigma_s[0] + medium->sigma_s[1] + medium->sigma_s[2];
        if (medium->dielectric == surface + 1 && scattering > 0 && medium->emits == 0) return m;
    }
    return -1;
}

bool ty_enclosed_exists(const ty_scene* scene) {
    for (int32_t i = 0; i < scene->view.interior_count; ++i)
        if (filling_medium(&scene->view, i) >= 0) return true;
    return false;
}

bool ty_enclosed_fills(const ty_scene* scene, int32_t medium) {
    bool fills = false;
    for (int32_t i = 0; i < scene->view.interior_count && !fills; ++i)
        fills = filling_medium(&scene->view, i) == medium;
    return fills;
}

bool ty_enclosed_has_all_media(const ty_scene* scene) {
    for (int32_t m = 0; m < scene->view.medium_count; ++m)
        if (!ty_enclosed_fills(scene, m)) return false;
    return scene->view.medium_count > 0;
}

static void set_field(ty_enclosed* enclosed, const ty_enclosed_body* body) {
    ty_enclosed_field* field = &enclosed->fields[body->interior];
    field->bands = body->bands;
    field->near_cell = body->near_cell;
    for (int a = 0; a < 3; ++a) {
        field->size[a] = body->size[a];
        field->lower[a] = (float)body->lower[a];
        field->per_cell[a] = (float)(1 / body->cell[a]);
        field->moments[a] = body->field[a];
        for (int32_t l = 0; l < TY_SH_BANDS_MAX; ++l) field->legendre[a][l] = body->legendre[a][l];
    }
}

static ty_result make_bodies(const ty_scene* scene, const ty_enclosed_def* def, ty_enclosed* enclosed) {
    for (int32_t i = 0; i < enclosed->count; ++i) {
        const int32_t medium = filling_medium(&scene->view, i);
        if (medium < 0) continue;
        ty_enclosed_body* body = &enclosed->bodies[enclosed->body_count++];
        const ty_result result = ty_enclosed_body_create(scene, def, i, medium, body);
        if (result != TY_OK) return result;
        if (body->side_count == 0)
            --enclosed->body_count, ty_enclosed_body_destroy(body);
        else
            set_field(enclosed, body);
    }
    return TY_OK;
}

/* ---- solve ---- */

/* A round in which surfaces receive and return light of the media. */
typedef struct round_of_light {
    bool first, last;
} round_of_light;

/* The tolerance of ordinates, and before the last round, where a fraction of the rays does as well. */
static const double last_tolerance = 1e-3, first_tolerance = 0.03;
enum { FEWER_RAYS = 4 };
/* Rays of an interior at most, where that leaves each face a few. */
enum { MAX_RAYS = 40000, MIN_PER_SIDE = 4 };

/* Rays of each face. */
static int32_t rays_of(const ty_enclosed_body* body, bool last) {
    const int32_t max_rays = MAX_RAYS / (body->side_count / 2 + 1);
    int32_t rays = body->def->rays;
    if (rays > max_rays) rays = max_rays;
    if (rays < MIN_PER_SIDE) rays = body->def->rays < MIN_PER_SIDE ? body->def->rays : MIN_PER_SIDE;
    return last ? rays : (rays + FEWER_RAYS - 1) / FEWER_RAYS;
}

static ty_result report(const ty_enclosed* enclosed) {
    const ty_enclosed_def* def = enclosed->def;
    ty_part_progress progress = ty_part_begin(def->progress, def->progress_user, 0, 0);
    return ty_part_next(&progress, "media in dielectrics", 0);
}

static ty_result enter(ty_enclosed* enclosed, const ty_discrete_light_set* lights, round_of_light round,
                       ty_enclosed_stats* stats) {
    const double begun = ty_wall_seconds();
    ty_result result = TY_OK;
    int64_t rays = 0;
    for (int32_t i = 0; i < enclosed->body_count && result == TY_OK; ++i) {
        ty_enclosed_body* body = &enclosed->bodies[i];
        if (round.first) result = ty_enclosed_add_lights(body, lights);
        if (result == TY_OK && body->def->radiance != NULL)
            result = ty_enclosed_add_surfaces(body, enclosed->fields, rays_of(body, round.last), &rays);
    }
    stats->rays = (int32_t)rays;
    stats->entering_seconds += ty_wall_seconds() - begun;
    return result;
}

static ty_result scatter(ty_enclosed* enclosed, round_of_light round, ty_enclosed_stats* stats) {
    const double tolerance = round.last ? last_tolerance : first_tolerance;
    const double begun = ty_wall_seconds();
    ty_result result = TY_OK;
    stats->sides = 0;
    stats->converged = true;
    for (int c = 0; c < 3; ++c) stats->entering[c] = stats->absorbed[c] = stats->leaving[c] = 0;
    for (int32_t i = 0; i < enclosed->body_count && result == TY_OK; ++i) {
        ty_enclosed_body* body = &enclosed->bodies[i];
        stats->sides += body->side_count;
        for (int c = 0; c < 3; ++c) stats->entering[c] += body->entering[0][c] + body->entering[1][c];
        const double before[3] = {stats->leaving[0], stats->leaving[1], stats->leaving[2]};
        result = body->diffusion ? ty_enclosed_solve_diffusion(body, stats)
                                 : ty_enclosed_solve_ordinates(body, !round.first, tolerance, stats);
        if (result != TY_OK) break;
        double leaving[3];
        for (int c = 0; c < 3; ++c) leaving[c] = stats->leaving[c] - before[c];
        ty_enclosed_fill_field(body);
        result = ty_enclosed_spread_exitance(body);
        ty_enclosed_balance_field(body, &enclosed->fields[body->interior], leaving);
    }
    stats->interiors = enclosed->body_count;
    stats->solve_seconds += ty_wall_seconds() - begun;
    return result;
}

static ty_result solve(const ty_scene* scene, const ty_enclosed_def* def, ty_enclosed* enclosed,
                       ty_enclosed_stats* stats) {
    const ty_discretize_def samples = {
        .environment = def->environment_beams, .surface = def->surface_points, .seed = def->seed};
    ty_discrete_light_set lights = {.items = NULL};
    const int32_t rounds = def->radiance != NULL ? def->rounds : 1;
    ty_result result = make_bodies(scene, def, enclosed);
    if (result == TY_OK) result = ty_discretize_lights(scene, &samples, &lights);
    for (int32_t i = 0; i < rounds && result == TY_OK; ++i) {
        const round_of_light round = {.first = i == 0, .last = i == rounds - 1};
        result = report(enclosed);
        if (result == TY_OK) result = enter(enclosed, &lights, round, stats);
        if (result == TY_OK) result = report(enclosed);
        if (result == TY_OK) result = scatter(enclosed, round, stats);
    }
    ty_discrete_light_set_destroy(scene->context, &lights);
    return result;
}

ty_result ty_enclosed_solve(const ty_scene* scene, const ty_enclosed_def* def, ty_enclosed** out,
                            ty_enclosed_stats* stats) {
    ty_enclosed_stats totals = {.interiors = 0};
    const double begun = ty_wall_seconds();
    *out = NULL;
    if (!ty_enclosed_exists(scene)) return TY_OK;
    if ((def->cells != TY_AUTO && (def->cells < 4 || def->cells > 256)) || def->rays < 1 || def->rounds < 1)
        return ty_fail(scene->context, TY_ERROR_ARGUMENT, "enclosed: cells, rays or rounds are outside their ranges");
    ty_enclosed* enclosed = ty_alloc_array(scene->context, 1, sizeof *enclosed, true);
    if (enclosed == NULL) return TY_ERROR_MEMORY;
    enclosed->context = scene->context;
    enclosed->def = def;
    enclosed->count = scene->view.interior_count;
    enclosed->fields = ty_alloc_array(scene->context, (size_t)enclosed->count, sizeof *enclosed->fields, true);
    enclosed->bodies = ty_alloc_array(scene->context, (size_t)enclosed->count, sizeof *enclosed->bodies, true);
    ty_result result = enclosed->fields != NULL && enclosed->bodies != NULL ? TY_OK : TY_ERROR_MEMORY;
    if (result == TY_OK) result = solve(scene, def, enclosed, &totals);
    if (result != TY_OK) {
        ty_enclosed_destroy(enclosed);
        return result;
    }
    enclosed->def = NULL;
    totals.seconds = ty_wall_seconds() - begun;
    if (stats != NULL) *stats = totals;
    *out = enclosed;
    return TY_OK;
}

void ty_enclosed_destroy(ty_enclosed* enclosed) {
    if (enclosed == NULL) return;
    for (int32_t i = 0; i < enclosed->body_count; ++i) ty_enclosed_body_destroy(&enclosed->bodies[i]);
    ty_free_array(enclosed->context, enclosed->bodies, (size_t)enclosed->count, sizeof *enclosed->bodies);
    ty_free_array(enclosed->context, enclosed->fields, (size_t)enclosed->count, sizeof *enclosed->fields);
    ty_free_array(enclosed->context, enclosed, 1, sizeof *enclosed);
}

const ty_enclosed_field* ty_enclosed_fields(const ty_enclosed* enclosed) {
    return enclosed != NULL ? enclosed->fields : NULL;
}
