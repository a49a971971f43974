/* Markdown tables of benches. */
#include "bench/compare.h"
#include "bench/markdown.h"

#include "cli/text/text.h"

#include <math.h>
#include <string.h>

/* Describes the machine in words, because published pages do not name machines. */
static const char* describe_isa(const char* isa) {
    if (strcmp(isa, "x86-64-v4") == 0) return "with AVX-512";
    if (strcmp(isa, "x86-64-v3") == 0) return "with AVX2";
    return "with SSE2 alone";
}

/* A timing's name without the suffix of its unit. */
static void print_name(FILE* file, const char* timing) {
    static const char* const ends[] = {"/seconds", "_seconds"};
    char name[BENCH_TIMING_NAME];
    snprintf(name, sizeof name, "%s", timing);
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

static void print_overview(FILE* file, const json_t* benches) {
    const char* name;
    json_t* bench;
    fputs("| bench | times and rates | seconds it takes | load before | processors that others kept busy |\n"
          "|---|---|---|---|---|\n",
          file);
    json_object_foreach((json_t*)benches, name, bench) {
        const char* skipped = json_string_value(json_object_get(bench, "skipped"));
        const char* failed = json_string_value(json_object_get(bench, "failed"));
        fprintf(file, "| %s | %zu |", name, json_object_size(json_object_get(bench, "timings")));
        if (skipped == NULL && failed == NULL) {
            print_number(file, bench_number(bench, "seconds"));
            print_number(file, bench_number(bench, "load_before"));
            print_number(file, bench_number(bench, "others_busy"));
        } else {
            fputs(skipped != NULL ? " skipped: " : " failed: ", file);
            cli_print_markdown(file, skipped != NULL ? skipped : failed);
            fputs(" | | |", file);
        }
        fputc('\n', file);
    }
}

static void print_timing(FILE* file, const char* name, bench_timing timing, bool spread) {
    char median[40], min[40], max[40];
    bench_format_timing(name, timing.median, median);
    bench_format_timing(name, timing.min, min);
    bench_format_timing(name, timing.max, max);
    fputs("| ", file);
    print_name(file, name);
    fprintf(file, " | %s |", median);
    if (spread && timing.min < timing.max) fprintf(file, " %s to %s |", min, max);
    if (spread && !(timing.min < timing.max)) fputs("  |", file);
}

/* before: timings of the baseline; NULL: there is none. */
static void print_bench(FILE* file, const char* bench, const json_t* timings, const json_t* before, bool spread,
                        bool compared) {
    const char* name;
    json_t* value;
    if (json_object_size(timings) == 0) return;
    fprintf(file, "\n### %s\n\n| what | median |%s%s\n|---|---|%s%s\n", bench, spread ? " range |" : "",
            compared ? " times as slow as before |" : "", spread ? "---|" : "", compared ? "---|" : "");
    json_object_foreach((json_t*)timings, name, value) {
        const bench_timing timing = bench_get_timing(timings, name);
        const double slower = bench_times_as_slow(name, timing, bench_get_timing(before, name));
        print_timing(file, name, timing, spread);
        if (compared && slower > 0) fprintf(file, " %.2f |", slower);
        if (compared && !(slower > 0)) fputs(" |", file);
        fputc('\n', file);
    }
}

/* Measurements of its programs other than path, beside the device's peaks. */
static void print_device_programs(FILE* file, const json_t* programs) {
    const char* name;
    json_t* of;
    if (programs == NULL) return;
    fputs("\n| program | device | its launches | processor | times as fast | of the peak bandwidth | of the peak "
          "arithmetic | values unlike the host twin's |\n|---|--:|--:|--:|--:|--:|--:|--:|\n",
          file);
    json_object_foreach((json_t*)programs, name, of) {
        fputs("| ", file);
        cli_print_markdown(file, name);
        fprintf(file, " | %.2f ms | %.2f ms | %.1f ms | %.1f | %.1f %% | %.1f %% | %.0f |\n",
                1e3 * bench_number(of, "device_seconds"), 1e3 * bench_number(of, "launched_seconds"),
                1e3 * bench_number(of, "cpu_seconds"), bench_number(of, "times_as_fast"),
                100 * bench_number(of, "of_peak_bandwidth"), 100 * bench_number(of, "of_peak_flops"),
                bench_number(of, "unlike_values"));
    }
}

/* Measurements of bench device, by scene, with the name of the GPU. */
static void print_device(FILE* file, const json_t* results) {
    const char *device = json_string_value(json_object_get(results, "device")), *name;
    json_t *unlike = json_object_get(results, "unlike_values"), *of;
    if (device == NULL) return;
    fputs("\nOn ", file);
    cli_print_markdown(file, device);
    fputs(", one sample of each pixel:\n\n"
          "| scene | device | its launches | processor | times as fast | million vertices/s | values unlike the host "
          "twin's |\n|---|--:|--:|--:|--:|--:|--:|\n",
          file);
    json_object_foreach(json_object_get(results, "scenes"), name, of) {
        fputs("| ", file);
        cli_print_markdown(file, name);
        fprintf(file, " | %.2f ms | %.2f ms | %.1f ms | %.1f | %.1f | %.0f |\n",
                1e3 * bench_number(of, "device_seconds"), 1e3 * bench_number(of, "launched_seconds"),
                1e3 * bench_number(of, "cpu_seconds"), bench_number(of, "times_as_fast"),
                bench_number(of, "mvertices_per_second"), bench_number(unlike, name));
    }
    print_device_programs(file, json_object_get(results, "programs"));
}

ty_result bench_print_markdown(ty_context* context, FILE* file, const void* user) {
    (void)context;
    const bench_tables* tables = user;
    json_t* benches = json_object_get(tables->results, "benches");
    const char *date, *version, *isa, *name;
    int quick, threads, processors, runs, rounds, complete;
    json_t* bench;
    if (json_unpack((json_t*)tables->results, "{s:s, s:s, s:s, s:b, s:i, s:i, s:i, s:i, s:b}", "date", &date, "version",
                    &version, "isa", &isa, "quick", &quick, "threads", &threads, "processors", &processors, "runs",
                    &runs, "rounds", &rounds, "complete", &complete) != 0)
        return TY_ERROR_INPUT;
    fprintf(file,
            "Measured on %.10s by version %s%s: %d threads on %d processors %s, %d run%s in each of %d round%s%s.\n\n",
            date, version, quick ? " with --quick" : "", threads, processors, describe_isa(isa), runs,
            runs == 1 ? "" : "s", rounds, rounds == 1 ? "" : "s", complete ? "" : ", interrupted");
    if (tables->before != NULL)
        fprintf(file, "Before: version %s, %.10s.\n\n", json_string_value(json_object_get(tables->before, "version")),
                json_string_value(json_object_get(tables->before, "date")));
    print_overview(file, benches);
    json_object_foreach(benches, name, bench) {
        const json_t* earlier = json_object_get(json_object_get(tables->before, "benches"), name);
        print_bench(file, name, json_object_get(bench, "timings"), json_object_get(earlier, "timings"), rounds > 1,
                    tables->before != NULL);
        if (strcmp(name, "device") == 0) print_device(file, json_object_get(bench, "results"));
    }
    return TY_OK;
}
