/* tyndall-bench: common options of benches, and output of their results. */
#include "bench/compare.h"
#include "bench/markdown.h"
#include "bench/run.h"
#include "cli/text/text_file.h"

#include <stdlib.h>
#include <string.h>

/* Defaults of --quick. */
static void choose_quick(bench_options* options, bool spp_given, bool runs_given, bool side_given) {
    if (!options->quick) return;
    if (!spp_given) options->spp = 4;
    if (!runs_given) options->runs = 1;
    if (!side_given) options->side = 48;
    if (!options->size_given) options->size[0] = options->size[1] = 64;
}

/* Output options beyond printing. */
typedef struct bench_keeping {
    int32_t rounds;
    const char *output, *from, *baseline, *markdown; /* files, or NULL */
    double threshold, fail_slower;                   /* percent */
    bool fails;                                      /* fail_slower was given */
} bench_keeping;

/* The requested benches. */
typedef struct bench_choice {
    const char* list; /* "fld,pop", or "all" */
    const bench_entry* entries[BENCH_COUNT];
    int count;
} bench_choice;

static int unknown_bench(const char* name) {
    const char* names[BENCH_COUNT + 1];
    char list[256] = "";
    for (int i = 0; i < BENCH_COUNT; ++i) {
        names[i] = bench_entries[i].name;
        const size_t used = strlen(list);
        snprintf(list + used, sizeof list - used, "%s, ", names[i]);
    }
    names[BENCH_COUNT] = "all";
    const char* nearest = cli_nearest(name, names, BENCH_COUNT + 1);
    if (nearest != NULL)
        return cli_usage_error("bench", "unknown bench '%s'; did you mean '%s'? There are: %sall", name, nearest, list);
    return cli_usage_error("bench", "unknown bench '%s'; there are: %sall", name, list);
}

/* True if a name is in the list. */
static bool is_listed(const char* list, const char* name) {
    const size_t length = strlen(name);
    for (const char* at = list; at != NULL; at = strchr(at, ','), at += at != NULL ? 1 : 0)
        if (strncmp(at, name, length) == 0 && (at[length] == ',' || at[length] == '\0')) return true;
    return false;
}

/* CLI_GO, or CLI_USAGE after a message. */
static int choose_benches(const char* list, bench_choice* out) {
    char name[64];
    const bool all = strcmp(list, "all") == 0;
    *out = (bench_choice){.list = list};
    for (int i = 0; i < BENCH_COUNT; ++i)
        if (all || is_listed(list, bench_entries[i].name)) out->entries[out->count++] = &bench_entries[i];
    for (const char* at = list; at != NULL && !all; at = strchr(at, ','), at += at != NULL ? 1 : 0) {
        bool found = false;
        snprintf(name, sizeof name, "%.*s", (int)strcspn(at, ","), at);
        for (int i = 0; i < BENCH_COUNT; ++i) found = found || strcmp(name, bench_entries[i].name) == 0;
        if (!found) return unknown_bench(name);
    }
    return CLI_GO;
}

/* ---- benches with immediate output ---- */

static int print_benches(cli_session* session, const bench_options* options, const bench_choice* choice) {
    const bool several = strcmp(choice->list, "all") == 0 || choice->count > 1;
    int worst = CLI_DONE;
    for (int i = 0; i < choice->count && !cli_interrupted(); ++i) {
        json_writer text = json_begin_plain(stdout);
        const bench_session bench = {session, options, &text};
        json_open_object(&text, NULL);
        json_open_object(&text, choice->entries[i]->name);
        const int status = choice->entries[i]->run(&bench);
        json_close_object(&text);
        json_close_object(&text);
        if (!several) return status;
        if (status != CLI_DONE && !cli_interrupted())
            cli_fail(status, "bench %s was left out", choice->entries[i]->name);
        if (status == CLI_FAILED) worst = CLI_FAILED;
    }
    return cli_interrupted() ? CLI_INTERRUPTED : worst;
}

/* ---- benches with stored results ---- */

/* The exit status over all benches: a skipped bench is no failure unless all were skipped. */
static int result_status(const bench_keeping* keeping, const json_t* results) {
    const char* name;
    json_t* bench;
    int worst = CLI_DONE, done = 0;
    json_object_foreach(json_object_get(results, "benches"), name, bench) {
        done += json_object_get(bench, "timings") != NULL ? 1 : 0;
        if (json_object_get(bench, "failed") != NULL) worst = CLI_FAILED;
    }
    if (keeping->from == NULL && !json_is_true(json_object_get(results, "complete"))) return CLI_INTERRUPTED;
    return worst == CLI_DONE && done == 0 ? CLI_USAGE : worst;
}

/* Reads results without their comparison and the benches that are not requested. */
static int read_chosen(cli_session* session, const char* path, const bench_choice* choice, json_t** out) {
    const char* name;
    json_t* bench;
    void* next;
    const int status = bench_read_results(session, path, out);
    if (status != CLI_GO) return status;
    json_t* benches = json_object_get(*out, "benches");
    json_object_del(*out, "baseline");
    json_object_foreach_safe(benches, next, name,
                             bench) if (strcmp(choice->list, "all") != 0 && !is_listed(choice->list, name))
        json_object_del(benches, name);
    if (json_object_size(benches) > 0) return CLI_GO;
    return cli_fail(CLI_USAGE, "%s: there is nothing of bench %s in it", path, choice->list);
}

static ty_result print_json(ty_context* context, FILE* file, const void* user) {
    (void)context;
    const char* key;
    json_t* value;
    json_writer json = json_begin(file);
    json_open_object(&json, NULL);
    json_object_foreach((json_t*)user, key, value) bench_write_value(&json, key, value);
    json_close_object(&json);
    return TY_OK;
}

/* Writes the results, with the comparison in them as "baseline". */
static int write_output(cli_session* session, const bench_options* options, const bench_keeping* keeping,
                        const bench_tables* tables) {
    ty_result result = TY_OK;
    if (options->json) print_json(session->context, stdout, tables->results);
    if (keeping->output != NULL)
        result = cli_write_text_file(session->context, keeping->output, print_json, tables->results);
    if (result == TY_OK && keeping->markdown != NULL)
        result = cli_write_text_file(session->context, keeping->markdown, bench_print_markdown, tables);
    return result == TY_OK ? CLI_DONE : cli_fail_running(session, result);
}

/* CLI_FAILED, after a message, if timings are slower than --fail-slower allows. */
static int check_slower(const bench_keeping* keeping, const json_t* results, const json_t* before) {
    if (!keeping->fails) return CLI_DONE;
    json_t* comparison = bench_compare(results, before, keeping->baseline, 0.01 * keeping->fail_slower);
    const size_t slower = json_array_size(json_object_get(comparison, "slower"));
    json_decref(comparison);
    if (slower == 0) return CLI_DONE;
    return cli_fail(CLI_FAILED, "%zu times and rates are by more than %g %% worse than in %s", slower,
                    keeping->fail_slower, keeping->baseline);
}

/* Writes and prints the results; before NULL: no comparison. */
static int output_results(cli_session* session, const bench_options* options, const bench_keeping* keeping,
                          json_t* results, const json_t* before) {
    const bench_tables tables = {results, before};
    json_t* comparison = NULL;
    if (before != NULL) {
        comparison = bench_compare(results, before, keeping->baseline, 0.01 * keeping->threshold);
        json_object_set(results, "baseline", comparison);
    }
    int status = write_output(session, options, keeping, &tables);
    if (before != NULL) {
        bench_warn_differences(session, results, before, keeping->baseline);
        bench_print_comparison(options->json ? stderr : stdout, comparison);
    }
    json_decref(comparison);
    if (status == CLI_DONE) status = result_status(keeping, results);
    return status == CLI_DONE ? check_slower(keeping, results, before) : status;
}

/* The baseline is read first, so that an invalid one is refused before any measurement. */
static int record_benches(cli_session* session, const bench_options* options, const bench_keeping* keeping,
                          const bench_choice* choice) {
    json_t *results = NULL, *before = NULL;
    int status = keeping->baseline != NULL ? bench_read_results(session, keeping->baseline, &before) : CLI_GO;
    if (status == CLI_GO && keeping->from != NULL)
        status = read_chosen(session, keeping->from, choice, &results);
    else if (status == CLI_GO)
        results = bench_run_all(session, options, choice->entries, choice->count, keeping->rounds);
    if (status == CLI_GO) status = output_results(session, options, keeping, results, before);
    json_decref(results);
    json_decref(before);
    return status;
}

static int run_benches(cli_session* session, const bench_options* options, const bench_keeping* keeping,
                       const bench_choice* choice) {
    const bool kept_somewhere = options->json || keeping->output != NULL || keeping->from != NULL ||
                                keeping->baseline != NULL || keeping->markdown != NULL;
    return kept_somewhere ? record_benches(session, options, keeping, choice) : print_benches(session, options, choice);
}

/* ---- the command ---- */

static int check_keeping(const bench_keeping* keeping) {
    int status = CLI_GO;
    if (keeping->fails && keeping->baseline == NULL)
        status = cli_usage_error("bench", "--fail-slower: slower than what? Give --baseline");
    if (status == CLI_GO && keeping->output != NULL) status = cli_check_output("bench", keeping->output);
    if (status == CLI_GO && keeping->markdown != NULL) status = cli_check_output("bench", keeping->markdown);
    return status;
}

static bool print_words(FILE* file, const char* option) {
    if (option != NULL) return false;
    fputs("all ", file);
    for (int i = 0; i < BENCH_COUNT; ++i) fprintf(file, "%s ", bench_entries[i].name);
    return true;
}

static int measure(int count, char** arguments) {
    bench_options options = {.spp = 64,
                             .size = {256, 256},
                             .runs = 3,
                             .side = 192,
                             .data = getenv("TYNDALL_DATA"),
                             .scenes = "cube_g0,cube_g0.7,cube_g0.96,cornell_fog,lamps,cloud_sun,cloud_sky"};
    bench_keeping keeping = {.rounds = 1, .threshold = 15};
    bool spp_given = false, runs_given = false, side_given = false;
    const cli_option table[] = {
        {"json", 0, CLI_FLAG, NULL, "print JSON", &options.json, 0, 0, NULL},
        {"output", 'o', CLI_TEXT, "FILE.json", "write the same JSON to a file", &keeping.output, 0, 0, NULL},
        {"rounds", 0, CLI_INT, "N", "times that all is done, for medians and spreads in files (default 1)",
         &keeping.rounds, 1, BENCH_ROUNDS_MAX, NULL},
        {"quick", 0, CLI_FLAG, NULL, "small sizes and one run: to try things out, not to be told", &options.quick, 0, 0,
         NULL},
        {"from", 0, CLI_TEXT, "FILE.json", "measure nothing: read the results of an earlier run", &keeping.from, 0, 0,
         NULL},
        {"baseline", 0, CLI_TEXT, "FILE.json", "compare with the results of an earlier run", &keeping.baseline, 0, 0,
         NULL},
        {"threshold", 0, CLI_REAL, "PERCENT", "a change that is told (default 15)", &keeping.threshold, 0, 1e6, NULL},
        {"fail-slower", 0, CLI_REAL, "PERCENT", "exit with 1 if a time is by more than that longer than the baseline's",
         &keeping.fail_slower, 0, 1e6, &keeping.fails},
        {"markdown", 0, CLI_TEXT, "FILE.md", "write tables for a page", &keeping.markdown, 0, 0, NULL},
        {"spp", 0, CLI_INT, "N", "samples per pixel (default 64)", &options.spp, 1, 1 << 24, &spp_given},
        {"size", 0, CLI_SIZE, "WxH",
         "pixels (default 256x256; rays: 1024x1024; screen: 1, 2, 4 and 8 million; "
         "fld, pop, octaves, denoise: 1024x1024; lpv: 1280x720; dom: 384x216; bake: 48x48 receivers)",
         options.size, 0, 0, &options.size_given},
        {"runs", 0, CLI_INT, "N", "repetitions whose median counts (default 3)", &options.runs, 1, 99, &runs_given},
        {"side", 0, CLI_INT, "N", "voxels a side of the volumes to load (default 192)", &options.side, 8, 1024,
         &side_given},
        {"scenes", 0, CLI_TEXT, "A,B,...", "scenes to render: files, or names of builtin ones; view: photograph, too",
         &options.scenes, 0, 0, &options.scenes_given},
        {"full", 0, CLI_FLAG, NULL,
         "screen: the whole image through the reference, not 100 rows; denoise: errors over many scenes", &options.full,
         0, 0, NULL},
        {"mesh", 0, CLI_TEXT, "FILE", "mesh for the rays (default: a terrain)", &options.mesh, 0, 0, NULL},
        {"guide", 0, CLI_FLAG, NULL, "path: each scene with a guide, too", &options.guide, 0, 0, NULL},
        {"reference", 0, CLI_TEXT, "DIR", "also compare with DIR/SCENE.exr", &options.reference, 0, 0, NULL},
        {"data", 0, CLI_TEXT, "DIR",
         "lpv, dom, edit, view: third-party data (default: the environment variable TYNDALL_DATA)", &options.data, 0, 0,
         NULL},
    };
    char details[2048] =
        "Without --json, -o, --from, --baseline and --markdown numbers are printed as YAML as they come. "
        "'all' goes on when a bench\n"
        "fails or lacks data. A time counts as changed when it is off by more than the threshold and "
        "the rounds' ranges\n"
        "do not overlap.\n\nbenches:";
    for (int i = 0; i < BENCH_COUNT; ++i) {
        const size_t used = strlen(details);
        snprintf(details + used, sizeof details - used, "\n  %-10s %s", bench_entries[i].name,
                 bench_entries[i].summary);
    }
    const cli_syntax syntax = {"bench",
                               "NAME[,NAME...]|all [options]",
                               "Measures speed on this machine.",
                               details,
                               table,
                               sizeof table / sizeof table[0],
                               1,
                               1,
                               print_words};
    cli_arguments given;
    int status = cli_parse(&syntax, count, arguments, &given);
    bench_choice choice;
    if (status == CLI_GO) status = choose_benches(given.positional[0], &choice);
    if (status == CLI_GO) status = check_keeping(&keeping);
    cli_session session;
    if (status == CLI_GO) status = cli_session_open(&session, "bench", &given.common);
    if (status != CLI_GO) return status;
    choose_quick(&options, spp_given, runs_given, side_given);
    return cli_session_close(&session, run_benches(&session, &options, &keeping, &choice));
}

int main(int count, char** arguments) {
    cli_start_program();
    return cli_finish(measure(count - 1, arguments + 1));
}
