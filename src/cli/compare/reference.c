/* The reference of a scene: paths, as many as it takes until their noise is well below the differences. It lies in the
 * folder with its state, so that a later comparison of the same scene goes on from it. */
#include "cli/compare/command_line.h"
#include "cli/compare/files.h"
#include "cli/compare/measure.h"
#include "cli/compare/scene.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Below this a variance is not worth much; and one step takes at most so many times the samples before it. */
enum { SPP_FIRST = 16, SPP_MAX = 1 << 24, GROWTH = 4 };

typedef struct refining {
    cli_session* session;
    cli_comparison* comparison;
    const ty_scene* scene;
    const cli_compare_request* options;
    cli_request request;
    cli_checkpoint checkpoint;
    cli_kept_state kept;
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

/* What there is stays, as an image and as a state to go on from. */
static int interrupted(refining* r) {
    const int status = write_reference(r, false);
    if (status != CLI_GO) return status;
    cli_progress_clear(&r->session->progress);
    return cli_fail(CLI_INTERRUPTED, "interrupted; the same command goes on from the reference as far as it is");
}

/* Samples up to spp; bound > 0: ends after so many seconds, of all runs together. */
static ty_result sample(refining* r, int32_t spp, double bound) {
    ty_path_def def = cli_path_def(r->session, r->scene, &r->request);
    def.spp = spp;
    def.seconds = bound;
    def.aovs = TY_AOV_VARIANCE | TY_AOV_SAMPLES;
    def.progress = report_progress;
    def.state = cli_keep_state;
    def.state_user = &r->kept;
    def.resume = r->kept.bytes;
    def.resume_size = r->kept.size;
    ty_image* image = NULL;
    const ty_result result = ty_path_render(r->scene, &def, &image, &r->report.path);
    if (image == NULL) return result;
    ty_image_destroy(r->comparison->reference.image);
    r->comparison->reference.image = image;
    r->report.own_seconds = r->report.path.seconds;
    return result;
}

/* Takes up what an earlier run left. A state of another render is told of, and forgotten. */
static int take_up(refining* r) {
    char* output = cli_comparison_path(r->comparison->folder, "", "reference", ".exr");
    if (output == NULL) return CLI_FAILED;
    const int status = cli_checkpoint_open(&r->checkpoint, r->session, output);
    free(output);
    if (status != CLI_GO || r->checkpoint.bytes == NULL) return status;
    r->kept.bytes = malloc(r->checkpoint.size);
    if (r->kept.bytes == NULL) return cli_fail(CLI_FAILED, "not enough memory");
    r->kept.size = r->checkpoint.size;
    memcpy(r->kept.bytes, r->checkpoint.bytes, r->kept.size);
    /* A bound that is over already: what is in the state, and the rest of a pass that was interrupted. */
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
    free(r->kept.bytes);
    r->kept.bytes = NULL;
    r->kept.size = 0;
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

/* Samples that the noise needs, as far as one can tell now; 0: no more. Between paths, whose differences are noise,
 * too, it is their own number of samples that counts. */
static double samples_needed(const refining* r) {
    const double have = r->report.path.spp, fraction = r->options->reference_noise;
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

/* Samples per pixel to have next; 0: there are enough. A pass that was cut short is ended with the next one. *bounded:
 * whether time counts, which it does not before each pixel has the two samples that a variance takes. */
static int32_t next_samples(const refining* r, bool* bounded) {
    const int32_t bound = r->options->reference_spp_given ? r->options->reference_spp : SPP_MAX;
    const double have = r->report.path.spp;
    double fewest = 0, most = 0;
    *bounded = true;
    if (r->comparison->reference.image == NULL) return bound < SPP_FIRST ? bound : SPP_FIRST;
    cli_sample_range(r->comparison->reference.image, &fewest, &most);
    if (fewest < 2) {
        *bounded = false;
        const double next = fmax(fmin(2, bound), most);
        return next <= fewest ? 0 : (int32_t)next;
    }
    const double needed = samples_needed(r);
    const double next = fmax(fmin(fmax(ceil(needed), floor(have) + 1), bound), most);
    return needed == 0 || next <= have ? 0 : (int32_t)next;
}

/* Samples, measures and looks again, until noise, samples or time say that it is enough. */
static int refine(refining* r) {
    int status = r->kept.bytes != NULL ? measure_all(r) : CLI_GO;
    while (status == CLI_GO) {
        bool bounded;
        const int32_t next = next_samples(r, &bounded);
        const double left = r->deadline - cli_wall_seconds();
        if (next == 0 || (bounded && left <= 0 && r->comparison->reference.image != NULL)) break;
        const ty_result result = sample(r, next, bounded ? r->report.path.seconds + fmax(left, 1e-3) : 0);
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
    ++r.request.seed; /* independent of what is compared with it */
    r.kept.checkpoint = &r.checkpoint;
    r.report = cli_begin_report(scene, &cli_method_path, r.request.seed);
    comparison->reference.source = "path";
    int status = take_up(&r);
    if (status == CLI_GO) status = refine(&r);
    free(r.kept.bytes);
    cli_checkpoint_close(&r.checkpoint);
    return status;
}
