/* tyndall screen: checks of options, and their conversion to a ty_screen_def. */
#include "cli/screen/screen_options.h"
#include "cli/options/aovs.h"

#include <math.h>
#include <string.h>

enum { EVERY_KIND = ~0u, GATHERS = 1 << SCREEN_GATHER | 1 << SCREEN_PUBLISHED | 1 << SCREEN_NAIVE };

/* ---- the table ---- */

screen_options screen_default_options(const char* command) {
    return (screen_options){
        .command = command, .filter = 1, .distance_scale = 1, .sky_distance = 1e6, .level_count = -1};
}

void screen_list_options(screen_options* options, cli_option out[SCREEN_OPTIONS]) {
    const cli_option table[] = {
        {"medium", 0, CLI_TEXT, "NAME|JSON", "what lies between the camera and what it sees (see above)",
         &options->medium, 0, 0, NULL},
        {"distance-channel", 0, CLI_TEXT, "NAME", "of the distances (default: depth.Z, Z, depth, ...)",
         &options->channel, 0, 0, NULL},
        {"distance-scale", 0, CLI_REAL, "METRES", "what 1 in the file of distances is (default 1)",
         &options->distance_scale, 1e-12, 1e12, &options->distance_scale_given},
        {"depth-is", 0, CLI_CHOICE, "radial|planar", "distances are along rays (default) or along the camera's axis",
         &options->depth_is, 0, 0, NULL},
        {"sky", 0, CLI_TEXT, "METRES|fill", "pixels without a distance: so far away (default 1e6), or as those around",
         &options->sky, 0, 0, NULL},
        {"fov-y", 0, CLI_REAL, "DEGREES", "full vertical angle of view", &options->fov_y, 1e-3, 179.999,
         &options->fov_y_given},
        {"focal", 0, CLI_TEXT, "FX[,FY]", "focal length, pixels", &options->focal_text, 0, 0, NULL},
        {"center", 0, CLI_TEXT, "CX,CY", "principal point, pixels from the corner (default: the center)",
         &options->center_text, 0, 0, NULL},
        {"environment", 0, CLI_TEXT, "L|R,G,B|FILE", "radiance around, W m^-2 sr^-1, or a map of it (default 0)",
         &options->environment, 0, 0, NULL},
        {"balance", 0, CLI_FLAG, NULL, "what scatters backwards comes from --environment, not from the image",
         &options->balance, 0, 0, NULL},
        {"variant", 0, CLI_CHOICE, SCREEN_KINDS, "ours (default), the paper's, and baselines", &options->kind, 0, 0,
         NULL},
        {"spread", 0, CLI_CHOICE, "small-angle|gaussian", "scatter: by phase function (default), or the paper's",
         &options->spread, 0, 0, &options->spread_given},
        {"filter", 0, CLI_CHOICE, "2|4|6", "taps along x and y between levels (default 4)", &options->filter, 0, 0,
         NULL},
        {"levels", 0, CLI_TEXT, "N|auto|all", "of the pyramid (default auto: what it takes, of Gaussians 6 at most)",
         &options->levels, 0, 0, NULL},
        {"window", 0, CLI_INT, "N", "reference: pixels that light reaches along x and y (default: all)",
         &options->window, 1, 65536, &options->window_given},
        {"mask", 0, CLI_CHOICE, "none|step|smooth",
         "gather: what keeps near pixels out of wide levels (default smooth)", &options->mask, 0, 0,
         &options->mask_given},
        {"mask-width", 0, CLI_REAL, "E", "gather: epsilon of the smooth mask (default 0.5)", &options->mask_width, 1e-6,
         1e6, &options->mask_width_given},
        {"level-scale", 0, CLI_REAL, "C", "gather: pixels of spread at level 0 (default 0.8)", &options->level_scale,
         1e-3, 1e3, &options->level_scale_given},
        {"uniform-weights", 0, CLI_FLAG, NULL, "gather: spreads are averaged without luminance",
         &options->uniform_weights, 0, 0, NULL},
        {"plain-distance", 0, CLI_FLAG, NULL, "gather: levels from distances that are not blurred",
         &options->plain_distance, 0, 0, NULL},
        {"no-normalise", 0, CLI_FLAG, NULL, "gather: masks take light away", &options->no_normalise, 0, 0, NULL},
    };
    _Static_assert(sizeof table / sizeof table[0] == SCREEN_OPTIONS, "SCREEN_OPTIONS is the length of the table");
    memcpy(out, table, sizeof table);
}

bool screen_is_given(const cli_option* option, const cli_option* preset) {
    switch (option->kind) {
    case CLI_FLAG: return *(bool*)option->target;
    case CLI_REAL: return *(double*)option->target != *(double*)preset->target;
    case CLI_INT: return *(int32_t*)option->target != *(int32_t*)preset->target;
    case CLI_CHOICE: return *(int*)option->target != *(int*)preset->target;
    default: return *(const char**)option->target != NULL;
    }
}

const char* screen_first_given(screen_options* options) {
    screen_options presets = screen_default_options(options->command);
    cli_option table[SCREEN_OPTIONS], preset[SCREEN_OPTIONS];
    screen_list_options(options, table);
    screen_list_options(&presets, preset);
    for (int i = 0; i < SCREEN_OPTIONS; ++i)
        if (screen_is_given(&table[i], &preset[i])) return table[i].name;
    return NULL;
}

/* The options that only some variants have. */
static const struct {
    const char* name;
    unsigned kinds;
} limited[] = {
    {"mask", GATHERS},
    {"mask-width", GATHERS},
    {"level-scale", GATHERS},
    {"uniform-weights", GATHERS},
    {"plain-distance", GATHERS},
    {"no-normalise", GATHERS},
    {"spread", 1 << SCREEN_SCATTER},
    {"window", 1 << SCREEN_EXACT},
};

unsigned screen_kinds_of(const char* name) {
    for (size_t i = 0; i < sizeof limited / sizeof limited[0]; ++i)
        if (strcmp(limited[i].name, name) == 0) return limited[i].kinds;
    return EVERY_KIND;
}

/* ---- checks ---- */

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

static int check_camera(screen_options* options) {
    double numbers[3] = {0};
    if (options->fov_y_given && options->focal_text != NULL)
        return cli_usage_error(options->command, "--fov-y and --focal say the same thing; give one of them");
    if (options->focal_text != NULL) {
        const int count = screen_parse_numbers(options->focal_text, 1, numbers);
        for (int axis = 0; axis < 2; ++axis) options->focal[axis] = numbers[count == 2 ? axis : 0];
        if (count < 1 || count > 2 || !(options->focal[0] > 0 && options->focal[1] > 0) ||
            !(fmax(options->focal[0], options->focal[1]) <= 1e9))
            return cli_usage_error(options->command, "--focal: '%s' is not FX or FX,FY, pixels above 0 and at most 1e9",
                                   options->focal_text);
        options->focal_given = true;
    }
    if (options->center_text != NULL) {
        if (screen_parse_numbers(options->center_text, 2, numbers) != 2 ||
            !(fmax(fabs(numbers[0]), fabs(numbers[1])) <= 1e6))
            return cli_usage_error(options->command, "--center: '%s' is not CX,CY, pixels within -1e6..1e6",
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
        return cli_usage_error(options->command,
                               "--sky: '%s' is neither fill nor a distance in metres from 1e-6 to 1e15", options->sky);
    return CLI_GO;
}

static int check_levels(screen_options* options) {
    const bool all = options->levels != NULL && strcmp(options->levels, "all") == 0;
    double levels = all ? TY_SCREEN_LEVELS_ALL : TY_AUTO;
    if (options->levels != NULL && !all && strcmp(options->levels, "auto") != 0 &&
        (!cli_parse_real(options->levels, &levels) || levels != floor(levels) || levels < 1 ||
         levels > TY_SCREEN_LEVELS_MAX))
        return cli_usage_error(options->command,
                               "--levels: '%s' is none of auto, all and the whole numbers from 1 to %d",
                               options->levels, (int)TY_SCREEN_LEVELS_MAX);
    options->level_count = (int32_t)levels;
    return CLI_GO;
}

/* Options of one variant are refused with another, which would ignore them. */
static int check_variant(screen_options* options) {
    cli_option table[SCREEN_OPTIONS];
    screen_list_options(options, table);
    for (int i = 0; i < SCREEN_OPTIONS; ++i) {
        const unsigned kinds = screen_kinds_of(table[i].name);
        const bool* given = table[i].given != NULL ? table[i].given : table[i].target;
        if ((kinds & 1u << options->kind) != 0 || !*given) continue;
        return cli_usage_error(options->command, "--%s is for --variant %s", table[i].name,
                               kinds == GATHERS               ? "gather, published and naive"
                               : kinds == 1 << SCREEN_SCATTER ? "scatter; the others are Gaussian"
                                                              : "reference");
    }
    return CLI_GO;
}

int screen_check_options(screen_options* options) {
    if (options->medium == NULL)
        return cli_usage_error(options->command, "through what? Give --medium, such as fog:50, wholemilk:1000 or "
                                                 "'{\"sigma_s\": 0.1, \"g\": 0.9}'");
    int status = check_camera(options);
    if (status == CLI_GO) status = check_sky(options);
    if (status == CLI_GO) status = check_levels(options);
    return status == CLI_GO ? check_variant(options) : status;
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

int screen_check_outputs(screen_options* options) {
    if (options->output == NULL) return cli_usage_error(options->command, "where to? Give -o OUT.exr or -o OUT.png");
    const bool png = cli_has_extension(options->output, ".png");
    if (!png && !cli_has_extension(options->output, ".exr"))
        return cli_usage_error(options->command, "%s: the extension is not .exr or .png", options->output);
    if (options->png != NULL && !cli_has_extension(options->png, ".png"))
        return cli_usage_error(options->command, "%s: the extension is not .png", options->png);
    if (options->aov != NULL && png)
        return cli_usage_error(options->command, "--aov is for .exr images, and %s is none", options->output);
    int status = check_aovs(options);
    if (status == CLI_GO) status = cli_check_output("screen", options->output);
    return status != CLI_GO || options->png == NULL ? status : cli_check_output("screen", options->png);
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
