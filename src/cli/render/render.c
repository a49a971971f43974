/* tyndall render: renders a scene to an image. */
#include "cli/render/render.h"
#include "cli/denoise/denoised.h"
#include "cli/options/aovs.h"
#include "cli/session/checkpoint.h"
#include "cli/commands.h"
#include "cli/methods/help_paths.h"
#include "cli/methods/method_help.h"
#include "cli/methods/methods.h"
#include "cli/methods/report.h"
#include "cli/session/ranks.h"
#include "cli/images/tev.h"
#include "image/aovs.h"
#include "image/options.h"

#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

static ty_result write_images(cli_session* session, const render_options* options, const ty_image* image,
                              double exposure) {
    const char* const paths[] = {options->output, options->png};
    for (int i = 0; i < 2; ++i) {
        if (paths[i] == NULL) continue;
        const ty_result result = cli_has_extension(paths[i], ".png")
                                     ? ty_image_write_png(session->context, image, exposure, TY_TONE_FILMIC, paths[i])
                                     : ty_image_write_exr(session->context, image, paths[i]);
        if (result != TY_OK) return result;
    }
    return TY_OK;
}

static void print_path_line(const cli_report* report) {
    const ty_path_stats* path = &report->run.path;
    char rests[96] = "";
    if (path->error_pixels > 0 && path->error_pixels < 10)
        snprintf(rests, sizeof rests, " (by %.0f pixels: other seeds may have far more or less)", path->error_pixels);
    printf("%s: %dx%d, %.4g spp, relative error %.3g%%%s, %.1f s (%.3g Mpaths/s)%s%s%s\n", report->method,
           report->width, report->height, path->spp, 100 * path->error, rests, path->seconds,
           path->seconds > 0 ? 1e-6 * (double)path->paths / path->seconds : 0.0,
           path->guide == TY_PATH_GUIDE_DOM ? ", guided by dom" : "", report->resumed ? ", resumed" : "",
           report->complete ? "" : ", interrupted");
}

static void print_method_lines(const cli_report* report) {
    const ty_method_run* run = &report->run;
    char text[256];
    if (run->enclosed)
        snprintf(text, sizeof text, "%d %s inside dielectrics, %.2f s (entering light %.2f, solve %.2f)",
                 (int)run->interiors.interiors, run->interiors.interiors == 1 ? "medium" : "media",
                 run->interiors.seconds, run->interiors.entering_seconds, run->interiors.solve_seconds);
    else
        report->ran->describe(run, text, sizeof text);
    printf("%s: %dx%d, %s\n", report->method, report->width, report->height, text);
    if (run->path.seconds > run->own_seconds)
        printf("surfaces: %.4g spp of path, %.2f s\n", run->path.spp, run->path.seconds - run->own_seconds);
}

static void print_closing_lines(const render_options* options, const cli_report* report) {
    if (report->ran->describe != NULL)
        print_method_lines(report);
    else
        print_path_line(report);
    if (options->denoise) cli_print_denoised(&report->denoised);
    printf("wrote %s\n", options->output);
    if (options->png != NULL) printf("wrote %s\n", options->png);
    if (options->denoise && options->denoised_png != NULL) printf("wrote %s (denoised)\n", options->denoised_png);
}

static cli_request make_request(const render_options* options, const cli_session* session,
                                const ty_render_settings* settings, cli_checkpoint* checkpoint, cli_tev* tev) {
    const bool bounded_otherwise = options->time > 0 || options->error > 0;
    cli_request request = {
        .spp = options->spp_given  ? options->spp
               : bounded_otherwise ? RENDER_SPP_MAX
                                   : settings->spp,
        .samples = options->spp_given && options->method == NULL,
        .seed = session->common.seed_given ? session->common.seed : settings->seed,
        .seconds = options->time,
        .error = options->error,
        .width = options->size[0],
        .height = options->size[1],
        .aovs = options->aovs | TY_AOV_SAMPLES | (options->denoise ? TY_DENOISE_AOVS : 0),
        .checkpoint = options->resume ? checkpoint : NULL,
        .checkpoint_seconds = options->checkpoint,
        .partial = options->tev != NULL ? cli_tev_show : NULL,
        .partial_user = tev,
        .light = options->light,
    };
    memcpy(request.crop, options->crop, sizeof request.crop);
    return request;
}

/* TY_ERROR_INPUT can only come from the resume state, whose message lacks the file name. */
static int fail_rendering(cli_session* session, ty_result result, const cli_checkpoint* checkpoint) {
    if (result != TY_ERROR_INPUT || checkpoint->bytes == NULL) return cli_fail_running(session, result);
    cli_progress_clear(&session->progress);
    return cli_fail(CLI_USAGE, "%s: %s; remove it to start again", checkpoint->path, ty_take_error(session->context));
}

/* True for channels that --aov asks for, and R, G, B and samples.N. */
static bool is_wanted(void* user, const char* name) {
    const render_options* options = user;
    const char* names[TY_AOV_CHANNELS_MAX];
    const int32_t count = ty_aov_names(options->aovs | TY_AOV_SAMPLES, names);
    for (int32_t i = 0; i < count; ++i)
        if (strcmp(names[i], name) == 0) return true;
    return false;
}

/* An image that was interrupted before it had the samples for it stays without the layers, after a warning. */
static ty_result denoise(cli_session* session, render_options* options, cli_report* report, ty_image** image) {
    ty_denoise_def def = ty_default_denoise_def();
    def.denoiser = (ty_denoiser)options->denoiser;
    def.progress = cli_progress_report;
    def.progress_user = &session->progress;
    report->denoised = ty_default_denoise_stats();
    const ty_result result = cli_add_denoised(session, &def, is_wanted, options, image, &report->denoised);
    if (report->complete || (result != TY_ERROR_INPUT && result != TY_CANCELLED)) return result;
    cli_progress_warn(&session->progress,
                      result == TY_CANCELLED ? "the image is not denoised" : ty_take_error(session->context));
    options->denoise = false;
    return TY_OK;
}

/* Writes a finished or partial image; returns the exit status. */
static int write_result(cli_session* session, render_options* options, cli_report* report, ty_image** image,
                        double exposure) {
    ty_result result = options->denoise ? denoise(session, options, report, image) : TY_OK;
    if (result == TY_OK && (options->aovs & TY_AOV_SAMPLES) == 0)
        result = cli_drop_even_samples(session->context, image);
    if (result == TY_OK) result = cli_report_metadata(*image, report);
    if (result == TY_OK && options->key != NULL) result = ty_image_set_text(*image, RENDER_KEY, options->key);
    if (result == TY_OK && options->denoise) result = cli_denoised_metadata(*image, &report->denoised);
    if (result == TY_OK) result = write_images(session, options, *image, exposure);
    if (result == TY_OK && options->denoise && options->denoised_png != NULL)
        result = cli_write_denoised_png(session, *image, exposure, options->denoised_png);
    if (result != TY_OK) return cli_fail_running(session, result);
    if (!session->common.quiet && options->key == NULL && !options->more) print_closing_lines(options, report);
    return report->complete ? CLI_DONE : CLI_INTERRUPTED;
}

/* A part of a frame is a band of rows. */
static int take_part(const ty_scene* scene, const ty_method* method, render_options* options) {
    if (options->part[1] == 0) return CLI_GO;
    if (method != &cli_method_auto && !method->crops)
        return cli_usage_error("render", "--part: the method %s renders whole frames; its parts are those of --frames",
                               method->name);
    int32_t size[2];
    ty_image_resolution(scene, options->size[0], options->size[1], size);
    if (options->crop[2] == 0) memcpy(options->crop, (int32_t[]){0, 0, size[0], size[1]}, sizeof options->crop);
    const int64_t rows = options->crop[3], parts = options->part[1], part = options->part[0];
    if (rows < parts)
        return cli_usage_error("render", "--part: %d rows are fewer than %d parts", (int)rows, (int)parts);
    const int32_t first = (int32_t)(rows * (part - 1) / parts), end = (int32_t)(rows * part / parts);
    options->crop[1] += first;
    options->crop[3] = end - first;
    return CLI_GO;
}

int render_scene(cli_session* session, const ty_scene* scene, render_options* options, cli_checkpoint* checkpoint,
                 cli_tev* tev, cli_report* report) {
    const ty_render_settings settings = ty_scene_render_settings(scene);
    const ty_method* method = cli_find_method("render", options->method != NULL ? options->method : settings.method);
    if (method == NULL) return CLI_USAGE;
    if (options->denoise && method != &cli_method_auto && strcmp(method->name, "path") != 0)
        return cli_usage_error("render", "--denoise is for method path, and %s has no noise of samples", method->name);
    const int taken = take_part(scene, method, options);
    if (taken != CLI_GO) return taken;
    const cli_request request = make_request(options, session, &settings, checkpoint, tev);
    if (options->denoise && request.spp < 2)
        return cli_usage_error("render", "--denoise compares two halves of the samples, and there is one a pixel");
    if (options->denoise && cli_check_denoiser(session, options->denoiser) != CLI_GO) return CLI_USAGE;
    const int possible = cli_check_request(session, scene, method, &request);
    if (possible != CLI_GO) return possible;
    if (options->key == NULL && method != &cli_method_auto && strcmp(method->name, "path") != 0 && !method->divides)
        cli_ranks_tell_alone(session, method->name);
    report->method = method->name;
    report->seed = request.seed;
    report->fov_y = ty_scene_camera(scene).fov_y;
    report->scene_bytes = ty_scene_get_info(scene).bytes;
    snprintf(report->scene, sizeof report->scene, "%016" PRIx64, ty_scene_hash(scene));
    report->resumed = options->resume && checkpoint->bytes != NULL;
    ty_image* image = NULL;
    const ty_result result = cli_render_method(session, scene, method, &request, &image, report);
    cli_progress_clear(&session->progress);
    if (image == NULL) return fail_rendering(session, result, checkpoint);
    if (tev != NULL) cli_tev_show(tev, image);
    report->complete = result == TY_OK;
    report->width = ty_image_width(image);
    report->height = ty_image_height(image);
    const double exposure = options->exposure_given ? options->exposure : ty_scene_camera(scene).exposure;
    const int status = write_result(session, options, report, &image, exposure);
    ty_image_destroy(image);
    return status;
}

void render_report_stats(json_writer* json, const void* user) {
    const cli_report* report = user;
    cli_report_stats(json, report);
    if (report->denoised.cookie != 0) cli_denoised_json(json, &report->denoised);
}

static int load_and_render(cli_session* session, const char* path, render_options* options) {
    cli_checkpoint checkpoint = {.session = session};
    cli_report report = {.method = "", .complete = false};
    cli_tev tev = {.session = session};
    ty_scene* scene = NULL;
    int status = options->tev != NULL ? cli_tev_open(&tev, session, options->tev, options->output) : CLI_GO;
    if (status == CLI_GO && options->resume) status = cli_checkpoint_open(&checkpoint, session, options->output);
    if (status == CLI_GO) {
        cli_end_on_interrupt(true);
        const ty_result result =
            ty_scene_load(session->context, path, options->overrides.items, options->overrides.count, &scene);
        cli_end_on_interrupt(false);
        status = result != TY_OK ? cli_fail_reading(session, result) : cli_ranks_greet(session, scene);
    }
    if (status == CLI_GO) {
        report.load_seconds = cli_wall_seconds() - session->started;
        session->stats = render_report_stats;
        session->stats_user = &report;
        status = render_scene(session, scene, options, &checkpoint, &tev, &report);
    }
    ty_scene_destroy(scene);
    cli_tev_close(&tev);
    cli_checkpoint_close(&checkpoint);
    return cli_session_close(session, status);
}

/* Checks of options that need no file. */
static int check_options(render_options* options) {
    if (options->output == NULL) return cli_usage_error("render", "where to? Give -o OUT.exr or -o OUT.png");
    const bool png = cli_has_extension(options->output, ".png");
    if (!png && !cli_has_extension(options->output, ".exr"))
        return cli_usage_error("render", "%s: the extension is not .exr or .png", options->output);
    if (options->png != NULL && !cli_has_extension(options->png, ".png"))
        return cli_usage_error("render", "%s: the extension is not .png", options->png);
    int status = options->frames_text != NULL || options->chain_given ? render_check_sequence(options) : CLI_GO;
    if (status == CLI_GO && options->more) status = render_check_more(options);
    if (status == CLI_GO && options->part_text != NULL)
        status = cli_parse_part("render", options->part_text, options->part);
    if (status != CLI_GO) return status;
    if (options->aov != NULL && png)
        return cli_usage_error("render", "--aov is for .exr images, and %s is none", options->output);
    if (options->denoise && png)
        return cli_usage_error("render",
                               "--denoise adds layers to .exr images, and %s is none; --denoised-png has a PNG",
                               options->output);
    if (options->denoised_png != NULL && !options->denoise)
        return cli_usage_error("render", "--denoised-png shows what --denoise makes; give both");
    if (options->denoiser_given && !options->denoise)
        return cli_usage_error("render", "--denoiser says by what --denoise removes noise; give both");
    if (options->denoised_png != NULL && !cli_has_extension(options->denoised_png, ".png"))
        return cli_usage_error("render", "%s: the extension is not .png", options->denoised_png);
    if (options->checkpoint_given && !options->resume)
        return cli_usage_error("render", "--checkpoint says how often --resume saves; give both");
    if (options->tev != NULL) status = cli_tev_check_address("render", options->tev);
    if (status == CLI_GO && options->aov != NULL) status = cli_parse_aovs("render", options->aov, &options->aovs);
    if (status == CLI_GO) status = cli_check_output("render", options->output);
    if (status == CLI_GO && options->png != NULL) status = cli_check_output("render", options->png);
    return status != CLI_GO || options->denoised_png == NULL ? status
                                                             : cli_check_output("render", options->denoised_png);
}

static bool print_words(FILE* file, const char* option) {
    if (option == NULL) return false;
    if (strcmp(option, "define") == 0) {
        cli_print_option_keys(file);
        return true;
    }
    if (strcmp(option, "method") != 0) return false;
    fprintf(file, "%s ", cli_method_auto.name);
    for (int i = 0; ty_methods[i] != NULL; ++i) fprintf(file, "%s ", ty_methods[i]->name);
    return true;
}

int cli_render(int count, char** arguments) {
    render_options options = {.checkpoint = TY_AUTO, .chain = 8};
    char methods[160];
    cli_name_methods_in("(default: that of the scene, or auto)", methods, sizeof methods);
    const cli_option table[] = {
        {"output", 'o', CLI_TEXT, "FILE", "the image to write: .exr (linear, with metadata) or .png", &options.output,
         0, 0, NULL},
        {"method", 0, CLI_TEXT, "NAME", methods, &options.method, 0, 0, NULL},
        {"spp", 0, CLI_INT, "N", "samples per pixel (default: what the scene says)", &options.spp, 1, RENDER_SPP_MAX,
         &options.spp_given},
        {"time", 0, CLI_REAL, "SECONDS", "stop after this time; without --spp nothing else does", &options.time, 1e-3,
         1e7, NULL},
        {"error", 0, CLI_REAL, "E", "stop at this relative error of the pixels, 0.01 for 1%", &options.error, 1e-6, 1,
         NULL},
        {"size", 0, CLI_SIZE, "WxH", "pixels (default: what the scene says)", options.size, 0, 0, NULL},
        {"crop", 0, CLI_CROP, "X,Y,WxH", "only this part of the frame, from the top left", options.crop, 0, 0, NULL},
        {"define", 'D', CLI_LIST, "KEY=VALUE", "change the scene: -D media[0].g=0.5 (again for more)",
         &options.overrides, 0, 0, NULL},
        {"png", 0, CLI_TEXT, "FILE", "also write a PNG", &options.png, 0, 0, NULL},
        {"exposure", 0, CLI_REAL, "STOPS", "exposure of the PNG (default: the camera's)", &options.exposure, -64, 64,
         &options.exposure_given},
        {"aov", 0, CLI_TEXT, "NAME,...", "also write these channels to the EXR (see above)", &options.aov, 0, 0, NULL},
        {"denoise", 0, CLI_FLAG, NULL, "add the layers denoised and denoised_error to the EXR (path, see above)",
         &options.denoise, 0, 0, NULL},
        {"denoiser", 0, CLI_CHOICE, "regression|oidn",
         "what removes the noise (default regression; oidn: Intel Open Image Denoise, where it is installed)",
         &options.denoiser, 0, 0, &options.denoiser_given},
        {"denoised-png", 0, CLI_TEXT, "FILE", "with --denoise: also write a PNG of the denoised light",
         &options.denoised_png, 0, 0, NULL},
        {"resume", 0, CLI_FLAG, NULL, "go on from FILE.state if it is there, and keep it up to date", &options.resume,
         0, 0, NULL},
        {"frames", 0, CLI_TEXT, "A-B[:STEP]",
         "render these frames of a sequence; OUT has #### in place of the number (see above)", &options.frames_text, 0,
         0, NULL},
        {"chain", 0, CLI_INT, "N", "with --frames: frames that follow one another as one task (default 8)",
         &options.chain, 1, 1 << 20, &options.chain_given},
        {"more", 0, CLI_FLAG, NULL, "then render the scenes that the lines of stdin name (see above)", &options.more, 0,
         0, NULL},
        {"part", 0, CLI_TEXT, "I/N", "only part I of N: a band of rows, or of --frames every Nth chain",
         &options.part_text, 0, 0, NULL},
        {"checkpoint", 0, CLI_REAL, "SECONDS", "time between two states of --resume (default: 2, see above)",
         &options.checkpoint, 0.05, 1e6, &options.checkpoint_given},
        {"tev", 0, CLI_TEXT, "HOST:PORT", "also show the image in the viewer tev; path while it converges",
         &options.tev, 0, 0, NULL},
    };
    const cli_syntax syntax = {
        "render",
        "SCENE -o OUT.exr|OUT.png [options]",
        "Renders a scene to an image.",
        "SCENE is a JSON file, or builtin:NAME. Interrupting (Ctrl-C) writes what there is and exits with 130, SIGTERM "
        "with\n143 and SIGHUP with 129.\n"
        "-D render.METHOD.KEY=VALUE sets an option of a method; 'tyndall help --options METHOD' lists them.\n\n"
        "Method auto, which scenes have that name none, looks at media, lights and surfaces, and says on stderr what\n"
        "it chose and why. --time, --error, --resume and --crop ask for path, which alone can do that; so does --spp,\n"
        "but for --method auto: other methods take it for surfaces.\n\n"
        "With --resume the same command goes on where the last one was interrupted, also by a crash, and ends with\n"
        "the same image; the seconds of all runs count for --time, and --spp may be larger than before. Changes are\n"
        "added to FILE.state every 2 seconds, so that a kill costs at most 5 seconds of work, as long as the "
        "disk\n"
        "takes it within one. One process at a time may use FILE.state.\n\n"
        "--frames renders the scene with frame=A, A+1 ... B, which picks the files of volumes, into images of their "
        "own;\n"
        "--resume then leaves those that the same command finished before. dom starts from the light of the frame\n"
        "before in the chain. Under mpirun the ranks divide a frame's paths, or frames: docs/farm.md.\n"
        "--more is for programs whose scenes come one after another: each line of stdin is SCENE, a tab and OUT, and "
        "may\n"
        "have another tab and a file for --stats. The light of the image before is the start of dom's, as in a chain. "
        "After\n"
        "each image, that of the command first, stdout has a line 'done' or 'failed' with the reason.\n"
        "--part is for machines without MPI: 'tyndall merge' puts bands together to the same image, bit for bit.\n\n"
        "--aov: depth, transmittance (of the media before the first surface), single and multiple (radiance that "
        "media\n"
        "scattered once, and otherwise), albedo (fraction that media scatter), surface_albedo (of the first\n"
        "surface, times transmittance), normal, variance (of the pixels), samples, or all, and half (the even samples' "
        "mean of each). --denoise leaves R, G, B and --png as they are.\n"
        "Partial images always have samples, so that 'tyndall merge' knows what they weigh.",
        table,
        sizeof table / sizeof table[0],
        1,
        1,
        print_words};
    cli_arguments given;
    int status = cli_parse(&syntax, count, arguments, &given);
    if (status == CLI_GO) status = check_options(&options);
    cli_session session;
    if (status == CLI_GO) status = cli_session_open(&session, "render", &given.common);
    if (status == CLI_GO) status = cli_ranks_open(&session);
    if (status != CLI_GO) return status;
    if (options.more) return render_more(&session, given.positional[0], &options);
    if (options.frames_text != NULL) return render_sequence(&session, given.positional[0], &options);
    return cli_ranks_helps(&session) ? cli_help_paths(&session, given.positional[0], &options.overrides, false)
                                     : load_and_render(&session, given.positional[0], &options);
}
