/* The path-traced reference of a scene, with samples added until its noise is well below the differences. Image and
 * resume state are stored in the folder, so that a later comparison of the same scene continues from them. */
#include "cli/compare/reference.h"
#include "cli/compare/files.h"
#include "cli/compare/keep.h"
#include "cli/compare/measure.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* The minimum samples per pixel of a usable variance, and the maximum growth of samples per step. */
enum { SPP_FIRST = 16, SPP_MAX = 1 << 24, GROWTH = 4 };

typedef struct refining {
    cli_session* session;
    cli_comparison* comparison;
    const ty_scene* scene;
    const cli_compare_request* options;
    cli_request request;
    cli_checkpoint checkpoint;
    cli_stored_state stored;
    cli_report report;
    double deadline;
} refining;

static bool report_progress(void* user, const ty_progress* progress) {
    ty_progress named = *progress;
    named.stage = "reference";
    return cli_progress_report(user, &named);
}

static int write_reference(refining* r, bool complete) {
    r->report.complete = complete;
    return cli_keep_rendering(r->session, r->comparison, &r->report, &r->comparison->reference);
}

/* Stores the current image and its resume state. */
static int interrupted(refining* r) {
    const int status = write_reference(r, false);
    if (status != CLI_GO) return status;
    cli_progress_clear(&r->session->progress);
    return cli_fail(CLI_INTERRUPTED, "interrupted; the same command goes on from the reference as far as it is");
}

/* Renders up to spp samples per pixel; bound > 0: time limit in seconds, summed over all runs. */
static ty_result sample(refining* r, int32_t spp, double bound) {
    ty_path_def def;
    ty_result result = cli_path_def(r->session, r->scene, &r->request, &def);
    if (result != TY_OK) return result;
    def.spp = spp;
    def.seconds = bound;
    def.aovs = TY_AOV_VARIANCE | TY_AOV_SAMPLES;
    def.progress = report_progress;
    def.state = cli_keep_state;
    def.state_user = &r->stored;
    def.resume = r->stored.bytes;
    def.resume_size = r->stored.size;
    ty_image* image = NULL;
    r->report.run.path = ty_default_path_stats();
    result = ty_path_render(r->scene, &def, &image, &r->report.run.path);
    if (image == NULL) return result;
    ty_image_destroy(r->comparison->reference.image);
    r->comparison->reference.image = image;
    r->report.run.own_seconds = r->report.run.path.seconds;
    return result;
}

/* Loads the state of an earlier run. A state of another render is reported and ignored. */
static int load_state(refining* r) {
    char* output = cli_comparison_path(r->comparison->folder, "", "reference", ".exr");
    if (output == NULL) return CLI_FAILED;
    const int status = cli_checkpoint_open(&r->checkpoint, r->session, output);
    free(output);
    if (status != CLI_GO || r->checkpoint.bytes == NULL) return status;
    r->stored.bytes = malloc(r->checkpoint.size);
    if (r->stored.bytes == NULL) return cli_fail(CLI_FAILED, "not enough memory");
    r->stored.size = r->checkpoint.size;
    memcpy(r->stored.bytes, r->checkpoint.bytes, r->stored.size);
    /* With the time limit already exceeded: the samples of the state, and the rest of an interrupted pass. */
    const ty_result result = sample(r, SPP_MAX, 1e-9);
    if (result == TY_OK) {
        r->comparison->reference_stored = true;
        return CLI_GO;
    }
    if (result == TY_CANCELLED) return interrupted(r);
    if (result != TY_ERROR_INPUT) return cli_fail_running(r->session, result);
    char text[CLI_COMPARE_REASON + 64];
    snprintf(text, sizeof text, "the stored reference is not used: %.*s", CLI_COMPARE_REASON,
             ty_take_error(r->session->context));
    if (!r->session->common.quiet) cli_progress_warn(&r->session->progress, text);
    free(r->stored.bytes);
    r->stored.bytes = NULL;
    r->stored.size = 0;
    return CLI_GO;
}

static int measure_all(refining* r) {
    cli_comparison* comparison = r->comparison;
    comparison->reference.source = "path";
    comparison->reference.noise = cli_measure_noise(comparison->reference.image, comparison->reference.image);
    int status = CLI_GO;
    for (int i = 0; i < comparison->count && status == CLI_GO; ++i)
        status = cli_measure_entry(r->session, comparison, &comparison->entries[i]);
    return status;
}

/* The samples per pixel estimated to reach the target noise; 0: no more. If all entries are path traced, their
 * differences are noise, too, and their own number of samples is the criterion. */
static double samples_needed(const refining* r) {
    const double have = r->report.run.path.spp, fraction = r->options->reference_noise;
    const cli_compared* nearest = cli_nearest_entry(r->comparison);
    if (nearest == NULL) {
        const double enough = r->request.spp / (fraction * fraction);
        return have < enough ? enough : 0;
    }
    if (have < SPP_FIRST) return SPP_FIRST;
    const double noise = r->comparison->reference.noise.rmse[3], wanted = fraction * nearest->difference.rmse[3];
    if (noise <= wanted) return 0;
    return fmin(1.05 * have * (noise / fmax(wanted, 1e-30)) * (noise / fmax(wanted, 1e-30)), GROWTH * have);
}

/* The next target of samples per pixel; 0: enough. The next pass completes an interrupted one. *bounded: the time limit
 * applies, which it does once each pixel has the two samples of a variance. */
static int32_t next_samples(const refining* r, bool* bounded) {
    const int32_t bound = r->options->reference_spp_given ? r->options->reference_spp : SPP_MAX;
    const double have = r->report.run.path.spp;
    double min_samples = 0, max_samples = 0;
    *bounded = true;
    if (r->comparison->reference.image == NULL) return bound < SPP_FIRST ? bound : SPP_FIRST;
    cli_sample_range(r->comparison->reference.image, &min_samples, &max_samples);
    if (min_samples < 2) {
        *bounded = false;
        const double next = fmax(fmin(2, bound), max_samples);
        return next <= min_samples ? 0 : (int32_t)next;
    }
    const double needed = samples_needed(r);
    const double next = fmax(fmin(fmax(ceil(needed), floor(have) + 1), bound), max_samples);
    return needed == 0 || next <= have ? 0 : (int32_t)next;
}

/* Alternates rendering and measuring until noise, samples or time reach their limit. */
static int refine(refining* r) {
    int status = r->stored.bytes != NULL ? measure_all(r) : CLI_GO;
    while (status == CLI_GO) {
        bool bounded;
        const int32_t next = next_samples(r, &bounded);
        const double left = r->deadline - cli_wall_seconds();
        if (next == 0 || (bounded && left <= 0 && r->comparison->reference.image != NULL)) break;
        const ty_result result = sample(r, next, bounded ? r->report.run.path.seconds + fmax(left, 1e-3) : 0);
        if (result == TY_CANCELLED) return interrupted(r);
        if (result != TY_OK) return cli_fail_running(r->session, result);
        status = measure_all(r);
    }
    return status == CLI_GO ? write_reference(r, true) : status;
}

int cli_refine_reference(cli_session* session, cli_comparison* comparison, const ty_scene* scene,
                         const cli_compare_request* options, const cli_request* request) {
    refining r = {.session = session,
                  .comparison = comparison,
                  .scene = scene,
                  .options = options,
                  .request = *request,
                  .checkpoint = {.session = session},
                  .deadline = cli_wall_seconds() + options->reference_seconds};
    ++r.request.seed; /* independent of the images under comparison */
    r.stored.checkpoint = &r.checkpoint;
    r.report = cli_begin_report(scene, &ty_method_path, r.request.seed);
    comparison->reference.source = "path";
    int status = load_state(&r);
    if (status == CLI_GO) status = refine(&r);
    free(r.stored.bytes);
    cli_checkpoint_close(&r.checkpoint);
    return status;
}
