/* The classical solver: no separate uncollided light, no delta scaling of phase functions; bands are weighted by a Hann
 * window against ringing. */
#include "figures/classical.h"

#include "base/constants.h"
#include "base/context.h"
#include "image/march/march.h"
#include "scene/scene.h"
#include "solve/angular/harmonics.h"
#include "solve/ordinates/sweep.h"

#include <math.h>
#include <string.h>

enum {
    TERMS_MAX = TY_SCATTERING_ORDER_MAX * TY_SCATTERING_ORDER_MAX,
    SKY_WIDTH = 512,
    SKY_HEIGHT = 256,
    ITERATIONS = 60
};

/* Convergence tolerance: relative change of the fluence. */
static const double tolerance = 1e-3;

typedef struct classical_job {
    ty_context* context;
    const ty_scene* scene;
    int32_t bands, terms;
    double window[TY_SCATTERING_ORDER_MAX];
    double sky[3][TERMS_MAX]; /* spherical harmonics of the incident radiance, by direction of travel */
    ty_angular_quadrature set;
    ty_grid_medium* medium;
    float *emission, *moments; /* interleaved, of one channel */
    float* sent[3];            /* radiance to the eye per scattering coefficient */
    int32_t iterations;        /* maximum over channels */
} classical_job;

/* ---- boundary source ---- */

static void add_sky(classical_job* job, const ty_environment_view* environment) {
    for (int row = 0; row < SKY_HEIGHT; ++row) {
        const double z = cos(TY_PI_F64 * (row + 0.5) / SKY_HEIGHT), across = sqrt(1 - z * z);
        const double solid_angle = 2 * TY_PI_F64 / SKY_WIDTH * across * TY_PI_F64 / SKY_HEIGHT;
        for (int column = 0; column < SKY_WIDTH; ++column) {
            const double angle = 2 * TY_PI_F64 * (column + 0.5) / SKY_WIDTH;
            const double wi[3] = {across * cos(angle), across * sin(angle), z};
            const double omega[3] = {-wi[0], -wi[1], -wi[2]};
            double y[TERMS_MAX];
            float radiance[3];
            ty_environment_radiance(environment, ty_vec_make((float)wi[0], (float)wi[1], (float)wi[2]), radiance);
            ty_harmonics_at(omega, job->bands, y);
            for (int c = 0; c < 3; ++c)
                for (int32_t t = 0; t < job->terms; ++t) job->sky[c][t] += solid_angle * (double)radiance[c] * y[t];
        }
    }
}

static void project_environments(classical_job* job) {
    const ty_light_set* lights = &ty_scene_get_view(job->scene)->lights;
    for (int32_t i = 0; i < lights->count; ++i)
        if (lights->lights[i].kind == TY_KIND_ENVIRONMENT) add_sky(job, &lights->lights[i].environment);
}

/* Incident radiance along each ordinate. */
static void evaluate_sky(const classical_job* job, int channel, float inflow[TY_ORDINATES_MAX]) {
    for (int32_t d = 0; d < job->set.count; ++d) {
        const double omega[3] = {(double)job->set.direction[0][d], (double)job->set.direction[1][d],
                                 (double)job->set.direction[2][d]};
        double y[TERMS_MAX], sum = 0;
        ty_harmonics_at(omega, job->bands, y);
        for (int32_t l = 0; l < job->bands; ++l)
            for (int32_t t = l * l; t < (l + 1) * (l + 1); ++t) sum += job->window[l] * job->sky[channel][t] * y[t];
        inflow[d] = (float)fmax(0, sum);
    }
}

/* ---- iterations ---- */

/* Scatters the moments into the source of the next iteration. */
static void scatter(const classical_job* job, int plane) {
    const ty_grid_medium* medium = job->medium;
    for (size_t i = 0; i < medium->cells; ++i) {
        double power = (double)medium->scattering[plane][i];
        for (int32_t l = 0; l < job->bands; ++l, power *= (double)medium->g[plane][i])
            for (int32_t t = l * l; t < (l + 1) * (l + 1); ++t) {
                const size_t at = i * (size_t)job->terms + (size_t)t;
                job->emission[at] = (float)(power * job->window[l]) * job->moments[at];
            }
    }
}

/* Relative RMS change of the fluence since last, which is updated. */
static double relative_change(const classical_job* job, float* last) {
    double squares = 0, all = 0;
    for (size_t i = 0; i < job->medium->cells; ++i) {
        const float now = job->moments[i * (size_t)job->terms];
        squares += pow((double)(now - last[i]), 2);
        all += pow((double)now, 2);
        last[i] = now;
    }
    return all > 0 ? sqrt(squares / all) : 0;
}

static ty_result iterate(classical_job* job, ty_sweep* sweep, int plane, float* last) {
    ty_result result = TY_OK;
    double change = 1;
    memset(last, 0, sizeof(float) * job->medium->cells);
    memset(job->emission, 0, sizeof(float) * job->medium->cells * (size_t)job->terms);
    for (int32_t i = 1; i <= ITERATIONS && change > tolerance && result == TY_OK; ++i) {
        result = ty_sweep_run(sweep, job->emission, job->moments, NULL, NULL);
        if (result == TY_OK) result = figure_check_interrupt();
        change = relative_change(job, last);
        scatter(job, plane);
        if (i > job->iterations) job->iterations = i;
    }
    return result;
}

static ty_result solve_channel(classical_job* job, int channel) {
    const ty_grid_medium* medium = job->medium;
    const int plane = medium->planes == 3 ? channel : 0;
    float inflow[TY_ORDINATES_MAX];
    ty_sweep* sweep = NULL;
    float* last = ty_alloc_array(job->context, medium->cells, sizeof(float), false);
    ty_result result = last != NULL ? TY_OK : TY_ERROR_MEMORY;
    evaluate_sky(job, channel, inflow);
    if (result == TY_OK)
        result = ty_sweep_create(job->context, medium->box.size, medium->cell, &job->set, job->bands,
                                 medium->extinction[plane], &sweep);
    const ty_boundary_radiance boundary = {.across = {inflow, inflow, inflow}};
    if (result == TY_OK) result = ty_sweep_set_boundary_radiance(sweep, &boundary);
    if (result == TY_OK) result = iterate(job, sweep, plane, last);
    ty_sweep_destroy(sweep);
    ty_free_array(job->context, last, medium->cells, sizeof(float));
    return result;
}

/* ---- radiance at the eye ---- */

static void send(classical_job* job, int channel, const double eye[3]) {
    const ty_grid_medium* medium = job->medium;
    const int32_t* size = medium->box.size;
    const int plane = medium->planes == 3 ? channel : 0;
    for (size_t i = 0; i < medium->cells; ++i) {
        const size_t row = i / (size_t)size[0];
        const double cell[3] = {(double)(i % (size_t)size[0]), (double)(row % (size_t)size[1]),
                                (double)(row / (size_t)size[1])};
        double omega[3], y[TERMS_MAX], sum = 0, power = 1;
        for (int a = 0; a < 3; ++a) omega[a] = eye[a] - (medium->box.lower[a] + (cell[a] + 0.5) * medium->cell[a]);
        const double length = hypot(hypot(omega[0], omega[1]), omega[2]);
        for (int a = 0; a < 3; ++a) omega[a] /= length;
        ty_harmonics_at(omega, job->bands, y);
        for (int32_t l = 0; l < job->bands; ++l, power *= (double)medium->g[plane][i])
            for (int32_t t = l * l; t < (l + 1) * (l + 1); ++t)
                sum += power * job->window[l] * y[t] * (double)job->moments[i * (size_t)job->terms + (size_t)t];
        job->sent[channel][i] = (float)fmax(0, sum);
    }
}

static ty_result march(figure_run* run, const classical_job* job, const int32_t size[2], ty_image** out) {
    ty_source_field field = {.box = job->medium->box, .term_count = 1};
    ty_march_def def = ty_default_march_def();
    for (int c = 0; c < 3; ++c) field.terms[c][0] = job->sent[c];
    def.width = size[0];
    def.height = size[1];
    def.field = &field;
    def.bilateral_sigma = 0;
    def.preserve_means = true;
    def.progress = cli_progress_report;
    def.progress_user = &run->session->progress;
    return ty_march(job->scene, &def, out, NULL);
}

/* ---- rendering ---- */

static ty_result open_job(classical_job* job, const classical_setting* setting) {
    ty_grid_box box;
    job->bands = setting->bands;
    job->terms = setting->bands * setting->bands;
    for (int32_t l = 0; l < job->bands; ++l) job->window[l] = 0.5 * (1 + cos(TY_PI_F64 * l / job->bands));
    ty_result result = ty_angular_quadrature_create(job->context, setting->directions, &job->set, NULL);
    if (result == TY_OK) result = ty_grid_box_fit(job->scene, setting->resolution, &box);
    if (result == TY_OK) result = ty_grid_medium_create(job->scene, &box, &job->medium);
    if (result != TY_OK) return result;
    const size_t values = job->medium->cells * (size_t)job->terms;
    job->emission = ty_alloc_array(job->context, values, sizeof(float), false);
    job->moments = ty_alloc_array(job->context, values, sizeof(float), false);
    bool allocated = job->emission != NULL && job->moments != NULL;
    for (int c = 0; c < 3; ++c) {
        job->sent[c] = ty_alloc_array(job->context, job->medium->cells, sizeof(float), false);
        allocated = allocated && job->sent[c] != NULL;
    }
    return allocated ? TY_OK : TY_ERROR_MEMORY;
}

static void close_job(classical_job* job) {
    const size_t cells = job->medium != NULL ? job->medium->cells : 0;
    ty_free_array(job->context, job->emission, cells * (size_t)job->terms, sizeof(float));
    ty_free_array(job->context, job->moments, cells * (size_t)job->terms, sizeof(float));
    for (int c = 0; c < 3; ++c) ty_free_array(job->context, job->sent[c], cells, sizeof(float));
    ty_grid_medium_destroy(job->medium);
    ty_free_array(job->context, job, 1, sizeof *job);
}

ty_result classical_render(figure_run* run, const char* item, ty_scene* scene, const int32_t size[2], const void* user,
                           figure_picture* out) {
    ty_context* context = run->session->context;
    const ty_camera_def camera = ty_scene_camera(scene);
    classical_job* job = ty_alloc_array(context, 1, sizeof *job, true);
    if (job == NULL) return TY_ERROR_MEMORY;
    const double begun = ty_wall_seconds();
    job->context = context;
    job->scene = scene;
    ty_result result = open_job(job, user);
    if (result == TY_OK) project_environments(job);
    for (int c = 0; c < 3 && result == TY_OK; ++c) {
        result = solve_channel(job, c);
        if (result == TY_OK) send(job, c, camera.position);
    }
    const double solved = ty_wall_seconds();
    ty_image* image = NULL;
    if (result == TY_OK) result = march(run, job, size, &image);
    const int32_t iterations = job->iterations;
    close_job(job);
    if (result == TY_OK) *out = (figure_picture){.image = image, .seconds = ty_wall_seconds() - begun, .samples = 1};
    if (result == TY_OK)
        figure_notes(run, item, {"time", "s", out->seconds}, {"time before the march", "s", solved - begun},
                     {"iterations", "1", iterations});
    return result;
}
