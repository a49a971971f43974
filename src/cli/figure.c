/* tyndall figure: papers' figures and tables, made anew. */
#include "cli/commands.h"
#include "cli/figures/figure.h"
#include "cli/figures/output.h"
#include "cli/text.h"

#include <stdlib.h>
#include <string.h>

typedef struct figure_entry {
    const char* name; /* the paper's method, a dash, what it shows */
    const char* title;
    ty_result (*make)(figure_run* run);
} figure_entry;

static const figure_entry figures[] = {
    {"auto-choice", "Method auto: what its choices cost against the best in their time", figure_auto_choice},
    {"bake-cornell", "Impulse responses: lightmaps in fog, back-scattering (Fig. 9)", figure_bake_cornell},
    {"bake-lights", "Impulse responses: a lamp and the sun in fog (Fig. 12)", figure_bake_lights},
    {"bake-staircase", "Impulse responses: by vertex, media that vary (Fig. 8)", figure_bake_staircase},
    {"fld-limiters", "Flux-limited diffusion: flux limiters (Table 2)", figure_fld_limiters},
    {"fld-point", "Flux-limited diffusion: a point source, theory and solvers (Figs. 3, 5)", figure_fld_point},
    {"fld-convergence", "Flux-limited diffusion: how fast solvers converge (Fig. 4)", figure_fld_convergence},
    {"fld-nebulae", "Flux-limited diffusion: a nebula in vacuum (Fig. 1)", figure_fld_nebulae},
    {"fld-resolution", "Flux-limited diffusion: full against quarter resolution (Fig. 6)", figure_fld_resolution},
    {"fld-albedo", "Flux-limited diffusion: albedo 0.1 to 1 (Fig. 7)", figure_fld_albedo},
    {"fld-ct", "Flux-limited diffusion: a CT scan with a transfer function (Fig. 8)", figure_fld_ct},
    {"fld-fire", "Flux-limited diffusion: a plume that glows (Fig. 9)", figure_fld_fire},
    {"pop-prefilter", "Principal-ordinates propagation: thin slabs, prefiltered (Fig. 6)", figure_pop_prefilter},
    {"pop-importance", "Principal-ordinates propagation: few ordinates, where they count (Fig. 7)",
     figure_pop_importance},
    {"pop-residuum", "Principal-ordinates propagation: isotropic light in one grid (Fig. 8)", figure_pop_residuum},
    {"pop-sphere", "Principal-ordinates propagation: a point light in a sphere (Fig. 10)", figure_pop_sphere},
    {"pop-smoke", "Principal-ordinates propagation: smoke in an environment (Fig. 11)", figure_pop_smoke},
    {"pop-lobes", "Principal-ordinates propagation: where light goes in a cube (Fig. 12)", figure_pop_lobes},
    {"pop-iterations", "Principal-ordinates propagation: how the propagation converges (Fig. 13)",
     figure_pop_iterations},
    {"pop-ordinates", "Principal-ordinates propagation: numbers of ordinates and importance (Fig. 14)",
     figure_pop_ordinates},
    {"pop-clouds", "Principal-ordinates propagation: clouds, anisotropic and not (Fig. 15)", figure_pop_clouds},
    {"pop-animation", "Principal-ordinates propagation: a plume, frame by frame (Fig. 16)", figure_pop_animation},
    {"pop-surfaces", "Principal-ordinates propagation: a solid in a medium (Fig. 17)", figure_pop_surfaces},
    {"lpv-parts", "Light propagation volumes: what each part adds (Fig. 5)", figure_lpv_parts},
    {"lpv-leaking", "Light propagation volumes: thin walls, small lights, few iterations (Fig. 6)", figure_lpv_leaking},
    {"lpv-truth", "Light propagation volumes: against path tracing (Figs. 7, 8)", figure_lpv_truth},
    {"lpv-shafts", "Light propagation volumes: single scattering against path tracing", figure_lpv_shafts},
    {"lpv-animation", "Light propagation volumes: sun and camera in small steps", figure_lpv_animation},
    {"lpv-energy", "Light propagation volumes: where the energy goes", figure_lpv_energy},
    {"lpv-dense", "Light propagation volumes: thin to dense fog around a lamp", figure_lpv_dense},
    {"dom-cube", "Discrete ordinates: fluence of a cube in a beam", figure_dom_cube},
    {"dom-convergence", "Discrete ordinates: sweeps against thickness, with diffusion's help and without",
     figure_dom_convergence},
    {"dom-rays", "Discrete ordinates: ray effects and false scattering", figure_dom_rays},
    {"dom-images", "Discrete ordinates: images beside those of other methods", figure_dom_images},
    {"impulse-tables", "Impulse responses: zonal harmonics over distance (Fig. 10)", figure_impulse_tables},
    {"screen-leaking", "Screen-space scattering: what keeps light from leaking (Fig. 6)", figure_screen_leaking},
    {"screen-thickness", "Screen-space scattering: optical thickness 2 to 8 (Fig. 7)", figure_screen_thickness},
    {"screen-truth", "Screen-space scattering: against path tracing (Fig. 8)", figure_screen_truth},
    {"screen-photo", "Screen-space scattering: a photograph in three media (Fig. 9)", figure_screen_photo},
    {"screen-table", "Screen-space scattering: milliseconds (Table 1)", figure_screen_table},
};
enum { FIGURE_COUNT = sizeof figures / sizeof figures[0] };

static bool wanted(const figure_entry* figure, const char* name) {
    const size_t length = strlen(name);
    return strcmp(name, "all") == 0 || strcmp(name, figure->name) == 0 ||
           (strncmp(name, figure->name, length) == 0 && figure->name[length] == '-');
}

static int count_wanted(const char* name) {
    int count = 0;
    for (int i = 0; i < FIGURE_COUNT; ++i) count += wanted(&figures[i], name) ? 1 : 0;
    return count;
}

static int unknown_figure(const char* name) {
    const char* names[FIGURE_COUNT];
    for (int i = 0; i < FIGURE_COUNT; ++i) names[i] = figures[i].name;
    const char* nearest = cli_nearest(name, names, FIGURE_COUNT);
    if (nearest != NULL)
        return cli_usage_error("figure", "unknown figure '%s'; did you mean '%s'? 'tyndall figure list' lists all",
                               name, nearest);
    return cli_usage_error("figure", "unknown figure '%s'; 'tyndall figure list' lists all", name);
}

static int print_list(void) {
    for (int i = 0; i < FIGURE_COUNT; ++i) {
        cli_print_text(stdout, figures[i].name, 18);
        printf(" %s\n", figures[i].title);
    }
    return CLI_DONE;
}

/* Makes and writes one; *made tells whether, if it was not skipped. */
static int make_figure(cli_session* session, const figure_options* options, const figure_entry* figure, bool* made) {
    const double started = cli_wall_seconds();
    figure_run run = {.session = session, .options = options, .name = figure->name};
    ty_result result = plot_create_page(session->context, &run.page);
    if (result == TY_OK) result = figure->make(&run);
    cli_progress_clear(&session->progress);
    int status = CLI_DONE;
    if (result != TY_OK) status = cli_fail_running(session, result);
    *made = result == TY_OK && !run.skipped;
    if (*made) status = figure_write(&run, figure->title, cli_wall_seconds() - started);
    if (*made && status == CLI_DONE && !session->common.quiet)
        printf("wrote %s/%s.png, .csv and .json\n", options->folder, figure->name);
    free(run.quantities);
    plot_free_page(&run.page);
    return status;
}

static int make_figures(cli_session* session, const figure_options* options, const char* name) {
    int status = CLI_DONE, count = 0;
    for (int i = 0; status == CLI_DONE && i < FIGURE_COUNT; ++i) {
        if (!wanted(&figures[i], name)) continue;
        bool made = false;
        status = make_figure(session, options, &figures[i], &made);
        fflush(stdout);
        count += made ? 1 : 0;
    }
    /* All that was asked for was skipped: that is not what was asked for. */
    return status == CLI_DONE && count == 0 ? CLI_USAGE : status;
}

static void list_figures(char* details, size_t size) {
    snprintf(details, size,
             "Writes DIR/NAME.png, and what was measured and, where it is known, expected as DIR/NAME.csv and .json.\n"
             "'all' makes all, the first word of a name those of a paper, and 'list' lists them:");
    for (int i = 0; i < FIGURE_COUNT; ++i) {
        const size_t used = strlen(details);
        snprintf(details + used, size - used, "\n  %-18s %s", figures[i].name, figures[i].title);
    }
}

int cli_figure(int count, char** arguments) {
    figure_options options = {.data = getenv("TYNDALL_DATA")};
    const cli_option table[] = {
        {"output", 'o', CLI_TEXT, "DIR", "the folder to write to; made if it is missing", &options.folder, 0, 0, NULL},
        {"size", 0, CLI_SIZE, "WxH", "pixels of the pictures (default: the figure's choice)", options.size, 0, 0, NULL},
        {"spp", 0, CLI_INT, "N", "samples per pixel of path-traced pictures (default: the figure's choice)",
         &options.samples, 1, 1 << 24, NULL},
        {"quick", 0, CLI_FLAG, NULL, "small pictures and few samples", &options.quick, 0, 0, NULL},
        {"data", 0, CLI_TEXT, "DIR", "third-party images and volumes (default: the environment variable TYNDALL_DATA)",
         &options.data, 0, 0, NULL},
    };
    char details[4096];
    list_figures(details, sizeof details);
    const cli_syntax syntax = {"figure",
                               "NAME|all|list -o DIR",
                               "Makes figures and tables of papers anew.",
                               details,
                               table,
                               sizeof table / sizeof table[0],
                               1,
                               1};
    cli_arguments given;
    int status = cli_parse(&syntax, count, arguments, &given);
    if (status != CLI_GO) return status;
    const char* name = given.positional[0];
    if (strcmp(name, "list") == 0) return print_list();
    if (count_wanted(name) == 0) return unknown_figure(name);
    if (options.folder == NULL) return cli_usage_error("figure", "where to? Give -o DIR");
    status = cli_make_folder("figure", options.folder);
    cli_session session;
    if (status == CLI_GO) status = cli_session_open(&session, "figure", &given.common);
    return status == CLI_GO ? cli_session_close(&session, make_figures(&session, &options, name)) : status;
}
