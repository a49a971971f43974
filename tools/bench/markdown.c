/* Markdown tables of benches. */
#include "bench/markdown.h"

#include "cli/text.h"

#include <math.h>
#include <string.h>

/* Describes the machine in words, because published pages do not name machines. */
static const char* describe_isa(const char* isa) {
    if (strcmp(isa, "x86-64-v4") == 0) return "with AVX-512";
    if (strcmp(isa, "x86-64-v3") == 0) return "with AVX2";
    return "with SSE2 alone";
}

/* A timing's name without the suffix of its unit. */
static void print_name(FILE* file, const bench_timing* timing) {
    static const char* const ends[] = {"/seconds", "_seconds"};
    char name[BENCH_TIMING_NAME];
    snprintf(name, sizeof name, "%s", timing->name);
    for (size_t i = 0; i < sizeof ends / sizeof ends[0]; ++i) {
        const size_t length = strlen(name), size = strlen(ends[i]);
        if (length > size && strcmp(name + length - size, ends[i]) == 0) name[length - size] = '\0';
    }
    for (char* c = name; *c != '\0'; ++c) *c = *c == '_' ? ' ' : *c;
    cli_print_markdown(file, name);
}

static void print_number(FILE* file, double value) {
    if (isfinite(value))
        fprintf(file, " %.1f |", value);
    else
        fputs(" |", file);
}

static void print_overview(FILE* file, const bench_results* results) {
    fputs("| bench | times and rates | seconds it takes | load before | processors that others kept busy |\n"
          "|---|---|---|---|---|\n",
          file);
    for (int i = 0; i < results->count; ++i) {
        const bench_result* bench = &results->benches[i];
        if (bench->status == CLI_GO) continue;
        fprintf(file, "| %s | %zu |", bench->name, bench->timing_count);
        if (bench->status == CLI_DONE) {
            print_number(file, bench->seconds);
            print_number(file, bench->load_before);
            print_number(file, bench->other_load);
        } else {
            fputs(bench->status == CLI_USAGE ? " skipped: " : " failed: ", file);
            cli_print_markdown(file, bench->message);
            fputs(" | | |", file);
        }
        fputc('\n', file);
    }
}

/* Prints "1.2 to 1.4 ms", or nothing after a single round. */
static void print_range(FILE* file, const bench_timing* timing) {
    char min[40], max[40];
    if (timing->min < timing->max) {
        bench_format_timing(timing->name, timing->min, min);
        bench_format_timing(timing->name, timing->max, max);
        fprintf(file, "%s to %s", min, max);
    }
}

static void print_bench(FILE* file, const bench_tables* tables, const bench_result* bench) {
    const bool spread = tables->results->rounds > 1, compared = tables->comparison != NULL;
    if (bench->timing_count == 0) return;
    fprintf(file, "\n### %s\n\n| what | median |%s%s\n|---|---|%s%s\n", bench->name, spread ? " least to most |" : "",
            compared ? " times as slow as before |" : "", spread ? "---|" : "", compared ? "---|" : "");
    for (size_t i = 0; i < bench->timing_count; ++i) {
        const bench_timing* timing = &bench->timings[i];
        const bench_change* change = compared ? bench_find_change(tables->comparison, timing) : NULL;
        char median[40];
        bench_format_timing(timing->name, timing->median, median);
        fputs("| ", file);
        print_name(file, timing);
        fprintf(file, " | %s |", median);
        if (spread) {
            fputc(' ', file);
            print_range(file, timing);
            fputs(" |", file);
        }
        if (change != NULL) fprintf(file, " %.2f |", change->slower);
        if (compared && change == NULL) fputs(" |", file);
        fputc('\n', file);
    }
}

ty_result bench_print_markdown(ty_context* context, FILE* file, const void* user) {
    (void)context;
    const bench_tables* tables = user;
    const bench_results* results = tables->results;
    fprintf(file,
            "Measured on %.10s by version %s%s: %d threads on %d processors %s, %d run%s in each of %d round%s%s.\n\n",
            results->date, results->version, results->quick ? " with --quick" : "", results->threads,
            results->processors, describe_isa(results->isa), results->runs, results->runs == 1 ? "" : "s",
            results->rounds, results->rounds == 1 ? "" : "s", results->complete ? "" : ", interrupted");
    if (tables->comparison != NULL)
        fprintf(file, "Before: version %s, %.10s.\n\n", tables->comparison->before->version,
                tables->comparison->before->date);
    print_overview(file, results);
    for (int i = 0; i < results->count; ++i) print_bench(file, tables, &results->benches[i]);
    return TY_OK;
}
