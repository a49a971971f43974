/* What `tyndall compare` finds out, before anything of it is written. */
#ifndef TY_CLI_COMPARE_COMPARISON_H
#define TY_CLI_COMPARE_COMPARISON_H

#include "cli/session.h"
#include "cli/stages.h"

enum { CLI_COMPARE_NAME = 64, CLI_COMPARE_REASON = 512, CLI_COMPARE_MAX = CLI_POSITIONAL_MAX, CLI_EARLIER_MAX = 5 };

/* The noise of a reference, from its channels of variance: standard errors of pixels, root mean square, in the slots of
 * a ty_difference, so that it is to be held against an rmse. */
typedef struct cli_noise {
    bool known; /* whether there are such channels */
    double rmse[4], relative[4];
} cli_noise;

/* What an image was on its way: with fewer samples. */
typedef struct cli_earlier {
    double spp, seconds;
    ty_image* image;
    ty_difference difference;
} cli_earlier;

typedef struct cli_compared {
    char name[CLI_COMPARE_NAME]; /* of files: letters, digits and -_. */
    const char* source;          /* the method or the image's file */
    ty_image* image;
    double seconds, spp;      /* negative: not known */
    double own_seconds;       /* without the path-traced image that the method starts from; negative: not known */
    ty_difference difference; /* from the reference; not set for the reference itself */
    cli_noise noise;          /* of the reference, where both have pixels; of the reference itself: everywhere */
    cli_earlier earlier[CLI_EARLIER_MAX]; /* by samples; of path alone */
    int earlier_count;
    cli_stage stages[CLI_STAGES_MAX];
    int stage_count;
    char* command; /* renders it again; NULL: not known */
} cli_compared;

typedef struct cli_skipped {
    const char* name;
    char reason[CLI_COMPARE_REASON];
} cli_skipped;

typedef struct cli_comparison {
    const char* folder;
    const char* subject; /* the scene, or NULL */
    char hash[17];       /* the scene's */
    const cli_list* overrides;
    char* scene_text; /* NULL: there is none */
    double exposure;
    cli_compared reference;
    bool reference_stored; /* whether it went on from an earlier run's */
    cli_compared* entries;
    int count;
    cli_skipped* skipped;
    int skipped_count;
    double wanted; /* the reference's noise is wanted below this fraction of the smallest difference */
} cli_comparison;

/* The entry other than paths that differs least from the reference, since noise is to be held against that; NULL when
 * there are only paths. */
const cli_compared* cli_nearest_entry(const cli_comparison* comparison);

/* The relative RMSE, or RMSE, that is left when the noise of the reference is taken out of it; 0 when that is all. */
double cli_without_noise(double rmse, double noise);

/* That of an entry's relative RMSE in a slot of its difference, as text: "" when the noise is not known, "below noise"
 * where what is left is less than a third of it, since noise is not known to a tenth of its square. */
void cli_without_noise_text(const cli_compared* entry, int slot, char out[24]);

/* One sentence on how large the reference's noise is beside the differences; "" if it is not known. */
void cli_noise_sentence(const cli_comparison* comparison, char* out, size_t size);

/* Images go before the session does, whose context they are of; the rest after it, since --stats tells of it. */
void cli_comparison_free_images(cli_comparison* comparison);
void cli_comparison_free(cli_comparison* comparison);

/* What a comparison of methods is asked for. */
typedef struct cli_compare_request {
    const char* methods;   /* "path,fld"; NULL or "all": all there are */
    const char* reference; /* a file; NULL: by path */
    int32_t spp, reference_spp, size[2];
    double reference_seconds, reference_noise;
    bool spp_given, reference_spp_given;
} cli_compare_request;

#endif
