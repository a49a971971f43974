/* tyndall screen: checks of options, and their conversion to a ty_screen_def. */
#include "cli/screen_options.h"
#include "cli/aovs.h"

#include <math.h>
#include <string.h>

int screen_parse_numbers(const char* text, int min_count, double out[3]) {
    int count = 0;
    for (const char* at = text; at != NULL; ++count) {
        char number[40];
        const size_t length = strcspn(at, ",");
        if (count == 3 || length >= sizeof number) return 0;
        memcpy(number, at, length);
        number[length] = '\0';
        if (!cli_parse_real(number, &out[count])) return 0;
        at = at[length] == ',' ? at + length + 1 : NULL;
    }
    return count >= min_count ? count : 0;
}

static int check_outputs(const screen_options* options) {
    if (options->output == NULL) return cli_usage_error("screen", "where to? Give -o OUT.exr or -o OUT.png");
    const bool png = cli_has_extension(options->output, ".png");
    if (!png && !cli_has_extension(options->output, ".exr"))
        return cli_usage_error("screen", "%s: the extension is not .exr or .png", options->output);
    if (options->png != NULL && !cli_has_extension(options->png, ".png"))
        return cli_usage_error("screen", "%s: the extension is not .png", options->png);
    if (options->aov != NULL && png)
        return cli_usage_error("screen", "--aov is for .exr images, and %s is none", options->output);
    const int status = cli_check_output("screen", options->output);
    return status != CLI_GO || options->png == NULL ? status : cli_check_output("screen", options->png);
}

static int check_aovs(screen_options* options) {
    static const cli_aov_word words[] = {
        {"attenuated", SCREEN_ATTENUATED},
        {"scattered", SCREEN_SCATTERED},
        {"spread", SCREEN_SPREAD},
        {"distance", SCREEN_DISTANCE},
        {"all", SCREEN_ATTENUATED | SCREEN_SCATTERED | SCREEN_SPREAD | SCREEN_DISTANCE},
    };
    if (options->aov == NULL) return CLI_GO;
    return cli_parse_aov_words("screen", options->aov, words, sizeof words / sizeof words[0], &options->aovs);
}

static int check_camera(screen_options* options) {
    double numbers[3] = {0};
    if (options->fov_y_given && options->focal_text != NULL)
        return cli_usage_error("screen", "--fov-y and --focal say the same thing; give one of them");
    if (options->focal_text != NULL) {
        const int count = screen_parse_numbers(options->focal_text, 1, numbers);
        for (int axis = 0; axis < 2; ++axis) options->focal[axis] = numbers[count == 2 ? axis : 0];
        if (count < 1 || count > 2 || !(options->focal[0] > 0 && options->focal[1] > 0) ||
            !(fmax(options->focal[0], options->focal[1]) <= 1e9))
            return cli_usage_error("screen", "--focal: '%s' is not FX or FX,FY, pixels above 0 and at most 1e9",
                                   options->focal_text);
        options->focal_given = true;
    }
    if (options->center_text != NULL) {
        if (screen_parse_numbers(options->center_text, 2, numbers) != 2 ||
            !(fmax(fabs(numbers[0]), fabs(numbers[1])) <= 1e6))
            return cli_usage_error("screen", "--center: '%s' is not CX,CY, pixels within -1e6..1e6",
                                   options->center_text);
        memcpy(options->center, numbers, sizeof options->center);
        options->center_given = true;
    }
    return CLI_GO;
}

static int check_sky(screen_options* options) {
    options->fill = options->sky != NULL && strcmp(options->sky, "fill") == 0;
    if (options->sky == NULL || options->fill) return CLI_GO;
    if (!cli_parse_real(options->sky, &options->sky_distance) ||
        !(options->sky_distance >= 1e-6 && options->sky_distance <= 1e15))
        return cli_usage_error("screen", "--sky: '%s' is neither fill nor a distance in metres from 1e-6 to 1e15",
                               options->sky);
    return CLI_GO;
}

static int check_levels(screen_options* options) {
    const bool all = options->levels != NULL && strcmp(options->levels, "all") == 0;
    double levels = all ? TY_SCREEN_LEVELS_ALL : TY_AUTO;
    if (options->levels != NULL && !all && strcmp(options->levels, "auto") != 0 &&
        (!cli_parse_real(options->levels, &levels) || levels != floor(levels) || levels < 1 ||
         levels > TY_SCREEN_LEVELS_MAX))
        return cli_usage_error("screen", "--levels: '%s' is none of auto, all and the whole numbers from 1 to %d",
                               options->levels, (int)TY_SCREEN_LEVELS_MAX);
    options->level_count = (int32_t)levels;
    return CLI_GO;
}

/* Options of one variant are refused with another, which would ignore them. */
static int check_variant(const screen_options* options) {
    const struct {
        const char* name;
        bool given;
    } of_gather[] = {
        {"mask", options->mask_given},
        {"mask-width", options->mask_width_given},
        {"level-scale", options->level_scale_given},
        {"uniform-weights", options->uniform_weights},
        {"plain-distance", options->plain_distance},
        {"no-normalise", options->no_normalise},
    };
    const bool gathers = options->kind != SCREEN_SCATTER && options->kind != SCREEN_EXACT;
    for (size_t i = 0; !gathers && i < sizeof of_gather / sizeof of_gather[0]; ++i)
        if (of_gather[i].given)
            return cli_usage_error("screen", "--%s is for --variant gather, published and naive", of_gather[i].name);
    if (options->spread_given && options->kind != SCREEN_SCATTER)
        return cli_usage_error("screen", "--spread is for --variant scatter; the others are Gaussian");
    if (options->window_given && options->kind != SCREEN_EXACT)
        return cli_usage_error("screen", "--window is for --variant reference");
    return CLI_GO;
}

int screen_check_options(screen_options* options) {
    if (options->medium == NULL)
        return cli_usage_error("screen", "through what? Give --medium, such as fog:50, wholemilk:1000 or "
                                         "'{\"sigma_s\": 0.1, \"g\": 0.9}'");
    int status = check_aovs(options);
    if (status == CLI_GO) status = check_camera(options);
    if (status == CLI_GO) status = check_sky(options);
    if (status == CLI_GO) status = check_levels(options);
    if (status == CLI_GO) status = check_variant(options);
    return status == CLI_GO ? check_outputs(options) : status;
}

static void set_gather_details(const screen_options* options, ty_screen_def* def) {
    if (options->mask_given) def->mask = (ty_screen_mask)options->mask;
    if (options->mask_width_given) def->mask_width = (float)options->mask_width;
    if (options->level_scale_given) def->level_scale = (float)options->level_scale;
    if (options->uniform_weights) def->luminance_weights = false;
    if (options->plain_distance) def->blurred_distance = false;
    if (options->no_normalise) def->normalise = false;
}

void screen_set_variant(const screen_options* options, ty_screen_def* def) {
    def->spread = (ty_screen_spread)options->spread;
    def->filter = 2 + 2 * options->filter;
    def->levels = options->level_count;
    def->window = options->window;
    switch ((screen_kind)options->kind) {
    case SCREEN_SCATTER: def->variant = TY_SCREEN_SCATTER; break;
    case SCREEN_GATHER: def->variant = TY_SCREEN_GATHER; break;
    case SCREEN_PUBLISHED: ty_screen_published_def(def); break;
    case SCREEN_NAIVE: ty_screen_naive_def(def); break;
    case SCREEN_EXACT: def->variant = TY_SCREEN_REFERENCE; break;
    }
    set_gather_details(options, def);
}
