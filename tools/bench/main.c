/* tyndall-bench: common options of benches, and output of their results. */
#include "bench/markdown.h"
#include "bench/run.h"
#include "cli/text_file.h"

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

/* True if a list such as "fld,pop" contains the name. */
static bool is_wanted(const char* list, const char* name) {
    const size_t length = strlen(name);
    if (strcmp(list, "all") == 0) return true;
    for (const char* at = list; at != NULL; at = strchr(at, ','), at += at != NULL ? 1 : 0)
        if (strncmp(at, name, length) == 0 && (at[length] == ',' || at[length] == '\0')) return true;
    return false;
}

static bool names_several(const char* list) {
    return strcmp(list, "all") == 0 || strchr(list, ',') != NULL;
}

/* ---- benches with immediate output ---- */

static int print_benches(cli_session* session, const bench_options* options, const char* name) {
    int worst = CLI_DONE;
    for (int i = 0; i < BENCH_COUNT && !cli_interrupted(); ++i) {
        if (!is_wanted(name, bench_entries[i].name)) continue;
        json_writer text = json_begin_plain(stdout);
        const bench_session bench = {session, options, &text};
        json_open_object(&text, NULL);
        json_open_object(&text, bench_entries[i].name);
        const int status = bench_entries[i].run(&bench);
        json_close_object(&text);
        json_close_object(&text);
        if (!names_several(name)) return status;
        if (status != CLI_DONE && !cli_interrupted()) cli_fail(status, "bench %s was left out", bench_entries[i].name);
        if (status == CLI_FAILED) worst = CLI_FAILED;
    }
    return cli_interrupted() ? CLI_INTERRUPTED : worst;
}

/* ---- benches with stored results ---- */

/* The exit status over all benches: a skipped bench is no failure unless all were skipped. */
static int result_status(const bench_keeping* keeping, const bench_results* results) {
    int worst = CLI_DONE, done = 0;
    for (int i = 0; i < results->count; ++i) {
        const int status = results->benches[i].status;
        done += status == CLI_DONE ? 1 : 0;
        if (status == CLI_FAILED) worst = CLI_FAILED;
    }
    if (keeping->from == NULL && !results->complete) return CLI_INTERRUPTED;
    return worst == CLI_DONE && done == 0 ? CLI_USAGE : worst;
}

/* Selects the requested benches. */
static int choose_results(const bench_keeping* keeping, const char* name, bench_results* results) {
    int count = 0;
    for (int i = 0; i < results->count; ++i) {
        if (is_wanted(name, results->benches[i].name)) {
            ++count;
        } else {
            results->benches[i].status = CLI_GO;
            results->benches[i].timing_count = 0;
        }
    }
    return count > 0 ? CLI_GO : cli_fail(CLI_USAGE, "%s: there is nothing of bench %s in it", keeping->from, name);
}

static int get_results(cli_session* session, const bench_options* options, const bench_keeping* keeping,
                       const char* name, bench_results* out) {
    const bench_entry* wanted[BENCH_COUNT];
    int count = 0;
    if (keeping->from != NULL) {
        const int status = bench_read_results(session, keeping->from, out);
        return status == CLI_GO ? choose_results(keeping, name, out) : status;
    }
    for (int i = 0; i < BENCH_COUNT; ++i)
        if (is_wanted(name, bench_entries[i].name)) wanted[count++] = &bench_entries[i];
    return bench_run_all(session, options, wanted, count, keeping->rounds, out);
}

/* Output to a file or to stdout. */
typedef struct result_output {
    const bench_keeping* keeping;
    const bench_results* results;
    const bench_comparison* comparison; /* or NULL */
} result_output;

static ty_result print_json(ty_context* context, FILE* file, const void* user) {
    (void)context;
    const result_output* k = user;
    json_writer json = json_begin(file);
    json_open_object(&json, NULL);
    bench_write_results(&json, k->results);
    if (k->comparison != NULL)
        bench_write_comparison(&json, k->comparison, k->keeping->baseline, 0.01 * k->keeping->threshold);
    json_close_object(&json);
    return TY_OK;
}

static int write_output(cli_session* session, const bench_options* options, const result_output* k) {
    const bench_keeping* keeping = k->keeping;
    const bench_tables tables = {k->results, k->comparison};
    ty_result result = TY_OK;
    if (options->json) print_json(session->context, stdout, k);
    if (keeping->output != NULL) result = cli_write_text_file(session->context, keeping->output, print_json, k);
    if (result == TY_OK && keeping->markdown != NULL)
        result = cli_write_text_file(session->context, keeping->markdown, bench_print_markdown, &tables);
    return result == TY_OK ? CLI_DONE : cli_fail_running(session, result);
}

/* Writes and prints the results; before NULL: no comparison. */
static int output_results(cli_session* session, const bench_options* options, const bench_keeping* keeping,
                          const bench_results* results, const bench_results* before) {
    bench_comparison comparison = {0};
    const result_output k = {keeping, results, before != NULL ? &comparison : NULL};
    if (before != NULL && bench_compare(results, before, &comparison) != TY_OK)
        return cli_fail(CLI_FAILED, "not enough memory");
    int status = write_output(session, options, &k);
    if (before != NULL) {
        bench_warn_differences(session, &comparison, keeping->baseline);
        bench_print_comparison(options->json ? stderr : stdout, &comparison, keeping->baseline,
                               0.01 * keeping->threshold);
    }
    const size_t slower = keeping->fails ? bench_count_slower(&comparison, 0.01 * keeping->fail_slower) : 0;
    bench_free_comparison(&comparison);
    if (status == CLI_DONE) status = result_status(keeping, results);
    if (status == CLI_DONE && slower > 0)
        status = cli_fail(CLI_FAILED, "%zu times and rates are by more than %g %% worse than in %s", slower,
                          keeping->fail_slower, keeping->baseline);
    return status;
}

/* The baseline is read first, so that an invalid one is refused before any measurement. */
static int record_benches(cli_session* session, const bench_options* options, const bench_keeping* keeping,
                          const char* name) {
    bench_results results = {0}, before = {0};
    int status = keeping->baseline != NULL ? bench_read_results(session, keeping->baseline, &before) : CLI_GO;
    if (status == CLI_GO) status = get_results(session, options, keeping, name, &results);
    if (status == CLI_GO)
        status = output_results(session, options, keeping, &results, keeping->baseline != NULL ? &before : NULL);
    bench_free_results(&results);
    bench_free_results(&before);
    return status;
}

static int run_benches(cli_session* session, const bench_options* options, const bench_keeping* keeping,
                       const char* name) {
    const bool kept_somewhere = options->json || keeping->output != NULL || keeping->from != NULL ||
                                keeping->baseline != NULL || keeping->markdown != NULL;
    return kept_somewhere ? record_benches(session, options, keeping, name) : print_benches(session, options, name);
}

/* ---- the command ---- */

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

/* Checks that every name of a list is a bench: CLI_GO, or CLI_USAGE after a message. */
static int check_names(const char* list) {
    char name[64];
    if (strcmp(list, "all") == 0) return CLI_GO;
    for (const char* at = list; at != NULL; at = strchr(at, ','), at += at != NULL ? 1 : 0) {
        bool found = false;
        snprintf(name, sizeof name, "%.*s", (int)strcspn(at, ","), at);
        for (int i = 0; i < BENCH_COUNT; ++i) found = found || strcmp(name, bench_entries[i].name) == 0;
        if (!found) return unknown_bench(name);
    }
    return CLI_GO;
}

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
         "fld, pop: 1024x1024; lpv: 1280x720; dom: 384x216; bake: 48x48 receivers)",
         options.size, 0, 0, &options.size_given},
        {"runs", 0, CLI_INT, "N", "repetitions whose median counts (default 3)", &options.runs, 1, 99, &runs_given},
        {"side", 0, CLI_INT, "N", "voxels a side of the volumes to load (default 192)", &options.side, 8, 1024,
         &side_given},
        {"scenes", 0, CLI_TEXT, "A,B,...", "scenes to render: files, or names of builtin ones", &options.scenes, 0, 0,
         NULL},
        {"full", 0, CLI_FLAG, NULL, "screen: the whole image through the reference, not 100 rows", &options.full, 0, 0,
         NULL},
        {"mesh", 0, CLI_TEXT, "FILE", "mesh for the rays (default: a terrain)", &options.mesh, 0, 0, NULL},
        {"reference", 0, CLI_TEXT, "DIR", "also compare with DIR/SCENE.exr", &options.reference, 0, 0, NULL},
        {"data", 0, CLI_TEXT, "DIR", "lpv, dom: third-party scenes (default: the environment variable TYNDALL_DATA)",
         &options.data, 0, 0, NULL},
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
    if (status == CLI_GO) status = check_names(given.positional[0]);
    if (status == CLI_GO) status = check_keeping(&keeping);
    cli_session session;
    if (status == CLI_GO) status = cli_session_open(&session, "bench", &given.common);
    if (status != CLI_GO) return status;
    choose_quick(&options, spp_given, runs_given, side_given);
    return cli_session_close(&session, run_benches(&session, &options, &keeping, given.positional[0]));
}

int main(int count, char** arguments) {
    cli_start_program();
    return cli_finish(measure(count - 1, arguments + 1));
}
