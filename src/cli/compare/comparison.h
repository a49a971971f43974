/* The results of `tyndall compare`, independent of the output formats. */
#ifndef TY_CLI_COMPARE_COMPARISON_H
#define TY_CLI_COMPARE_COMPARISON_H

#include "cli/session/session.h"
#include "cli/methods/report.h"

enum { CLI_COMPARE_NAME = 64, CLI_COMPARE_REASON = 512, CLI_COMPARE_MAX = CLI_POSITIONAL_MAX, CLI_EARLIER_MAX = 5 };

/* The noise of a reference from its variance channels: the root mean square of the pixels' standard errors in the slots
 * of a ty_difference, comparable with an RMSE. */
typedef struct cli_noise {
    bool known; /* the reference has variance channels */
    double rmse[4], relative[4];
} cli_noise;

/* An intermediate image with fewer samples. */
typedef struct cli_earlier {
    double spp, seconds;
    ty_image* image;
    ty_difference difference;
} cli_earlier;

typedef struct cli_compared {
    char name[CLI_COMPARE_NAME]; /* for file names: letters, digits and -_. */
    const char* source;          /* the method or the image file */
    ty_image* image;
    double seconds, spp;      /* negative: unknown */
    double own_seconds;       /* seconds without the path-traced image that the method starts from; negative: unknown */
    ty_difference difference; /* difference from the reference; not set for the reference itself */
    cli_noise noise;          /* noise of the reference in the common pixels; for the reference itself: in all pixels */
    cli_earlier earlier[CLI_EARLIER_MAX]; /* intermediate images by samples; method path only */
    int earlier_count;
    cli_stage stages[CLI_STAGES_MAX];
    int stage_count;
    char* command; /* command line that reproduces the image; NULL: unknown */
} cli_compared;

typedef struct cli_skipped {
    const char* name;
    char reason[CLI_COMPARE_REASON];
} cli_skipped;

typedef struct cli_comparison {
    const char* folder;
    const char* subject; /* the scene, or NULL */
    char hash[17];       /* the scene's hash */
    const cli_list* overrides;
    char* scene_text; /* NULL: none */
    double exposure;
    cli_compared reference;
    bool reference_stored; /* the reference was resumed from an earlier run */
    cli_compared* entries;
    int count;
    cli_skipped* skipped;
    int skipped_count;
    double wanted; /* target of the reference's noise as a fraction of the smallest difference */
} cli_comparison;

/* The entry, path excluded, with the smallest difference from the reference, which bounds the acceptable noise; NULL
 * when all entries are path traced. */
const cli_compared* cli_nearest_entry(const cli_comparison* comparison);

/* The relative RMSE (or RMSE) after subtracting the variance of the reference: sqrt(max(0, rmse^2 - noise^2)). */
double cli_without_noise(double rmse, double noise);

/* The noise-corrected relative RMSE of a slot of an entry's difference as text: "" when the noise is unknown, "below
 * noise" where the corrected value is less than a third of the noise, whose square is not known to a tenth. */
void cli_without_noise_text(const cli_compared* entry, int slot, char out[24]);

/* One sentence on the ratio of the reference's noise to the differences; "" if the noise is unknown. */
void cli_noise_sentence(const cli_comparison* comparison, char* out, size_t size);

/* Images are freed before the session, which owns their context; the rest is freed after the session has written
 * --stats. */
void cli_comparison_free_images(cli_comparison* comparison);
void cli_comparison_free(cli_comparison* comparison);

/* The request of a comparison of methods. */
typedef struct cli_compare_request {
    const char* methods;   /* "path,fld"; NULL or "all": all methods */
    const char* reference; /* reference image file; NULL: path traced */
    int32_t spp, reference_spp, size[2];
    double reference_seconds, reference_noise;
    bool spp_given, reference_spp_given;
} cli_compare_request;

#endif
