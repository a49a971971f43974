/* Comparison of timings with earlier ones. */
#include "bench/compare.h"

#include "bench/bench.h"
#include "cli/text/text.h"

#include <stdlib.h>
#include <string.h>

static const char* text_of(const json_t* object, const char* key) {
    return json_string_value(json_object_get(object, key));
}

static int int_of(const json_t* object, const char* key) {
    return (int)json_integer_value(json_object_get(object, key));
}

/* ---- comparing ---- */

double bench_times_as_slow(const char* timing_name, bench_timing now, bench_timing before) {
    if (!(before.median > 0)) return 0;
    return bench_is_rate(timing_name) ? before.median / now.median : now.median / before.median;
}

/* Compares one bench; the timings of a bench without earlier ones do not count as new. */
static void compare_bench(const char* bench, const json_t* now, const json_t* before, double threshold, json_t* out) {
    const size_t count = json_object_size(now), earlier = json_object_size(before);
    double* ratios = calloc(count + 1, sizeof *ratios);
    const char* name;
    json_t* value;
    int compared = 0;
    if (ratios == NULL || count == 0 || earlier == 0) {
        free(ratios);
        return;
    }
    json_object_foreach((json_t*)now, name, value) {
        const bench_timing a = bench_get_timing(now, name), b = bench_get_timing(before, name);
        const double slower = bench_times_as_slow(name, a, b);
        if (slower == 0) continue;
        ratios[compared++] = slower;
        if (a.min <= b.max && a.max >= b.min) continue;
        if (slower <= 1 + threshold && 1 / slower <= 1 + threshold) continue;
        json_array_append_new(json_object_get(out, slower > 1 ? "slower" : "faster"),
                              json_pack("{s:s, s:s, s:f, s:f, s:f}", "bench", bench, "timing", name, "times_as_slow",
                                        slower, "now", a.median, "before", b.median));
    }
    if (compared > 0) {
        const double median = bench_median(ratios, compared);
        json_object_set_new(json_object_get(out, "times_as_slow"), bench,
                            json_pack("[f, f, f]", median, ratios[compared / 4], ratios[compared - 1 - compared / 4]));
    }
    free(ratios);
    json_object_set_new(json_object_get(out, "compared"), bench, json_integer(compared));
    json_object_set_new(out, "new", json_integer(int_of(out, "new") + (int)count - compared));
    json_object_set_new(out, "gone", json_integer(int_of(out, "gone") + (int)earlier - compared));
}

json_t* bench_compare(const json_t* now, const json_t* before, const char* path, double threshold) {
    json_t* out = json_pack("{s:s, s:s, s:s, s:f, s:i, s:i, s:{}, s:{}, s:[], s:[]}", "file", path, "version",
                            text_of(before, "version"), "date", text_of(before, "date"), "threshold", threshold, "new",
                            0, "gone", 0, "compared", "times_as_slow", "slower", "faster");
    const char* name;
    json_t* bench;
    json_object_foreach(json_object_get(now, "benches"), name, bench) {
        const json_t* earlier = json_object_get(json_object_get(before, "benches"), name);
        compare_bench(name, json_object_get(bench, "timings"), json_object_get(earlier, "timings"), threshold, out);
    }
    return out;
}

/* ---- printing ---- */

/* True if a member of both is the same. */
static bool is_same(const json_t* a, const json_t* b, const char* key) {
    return json_equal(json_object_get(a, key), json_object_get(b, key)) != 0;
}

void bench_warn_differences(cli_session* session, const json_t* now, const json_t* before, const char* path) {
    char text[512];
    if (session->common.quiet) return;
    if (!is_same(now, before, "version")) {
        snprintf(text, sizeof text, "%s is of version %s, and this is %s: they are compared all the same", path,
                 text_of(before, "version"), text_of(now, "version"));
        cli_progress_warn(&session->progress, text);
    }
    if (!is_same(now, before, "threads") || !is_same(now, before, "processors") || !is_same(now, before, "isa")) {
        snprintf(text, sizeof text, "%s is of another machine: %d threads on %d processors of %s, not %d on %d of %s",
                 path, int_of(before, "threads"), int_of(before, "processors"), text_of(before, "isa"),
                 int_of(now, "threads"), int_of(now, "processors"), text_of(now, "isa"));
        cli_progress_warn(&session->progress, text);
    }
    if (!is_same(now, before, "quick") || !is_same(now, before, "spp") || !is_same(now, before, "side") ||
        !is_same(now, before, "size")) {
        snprintf(text, sizeof text,
                 "%s was measured with other options (--spp %d, --side %d, %s size%s): some times mean other things",
                 path, int_of(before, "spp"), int_of(before, "side"),
                 json_integer_value(json_array_get(json_object_get(before, "size"), 0)) > 0 ? "a given" : "no given",
                 json_is_true(json_object_get(before, "quick")) ? ", --quick" : "");
        cli_progress_warn(&session->progress, text);
    }
}

static void print_changes(FILE* file, const json_t* comparison, const char* list) {
    size_t i;
    json_t* change;
    json_array_foreach(json_object_get(comparison, list), i, change) {
        const char* timing = text_of(change, "timing");
        const double slower = bench_number(change, "times_as_slow");
        char before[40], now[40];
        bench_format_timing(timing, bench_number(change, "before"), before);
        bench_format_timing(timing, bench_number(change, "now"), now);
        fprintf(file, "  %-7s %5.2f  %s/", list, slower > 1 ? slower : 1 / slower, text_of(change, "bench"));
        cli_print_text(file, timing, 0);
        fprintf(file, ": %s, before %s\n", now, before);
    }
}

static int count_changes(const json_t* comparison, const char* list, const char* bench) {
    size_t i;
    json_t* change;
    int count = 0;
    json_array_foreach(json_object_get(comparison, list), i, change) count +=
        strcmp(text_of(change, "bench"), bench) == 0 ? 1 : 0;
    return count;
}

void bench_print_comparison(FILE* file, const json_t* comparison) {
    const json_t* counts = json_object_get(comparison, "compared");
    const char* bench;
    json_t* ratios;
    int compared = 0;
    json_object_foreach(json_object_get(comparison, "times_as_slow"), bench, ratios) compared += int_of(counts, bench);
    fputs("against ", file);
    cli_print_text(file, text_of(comparison, "file"), 0);
    fprintf(file, " (%s, %s): %d times and rates, %d new, %d gone\n", text_of(comparison, "version"),
            text_of(comparison, "date"), compared, int_of(comparison, "new"), int_of(comparison, "gone"));
    fprintf(file, "%-10s %8s %18s %18s %8s %8s\n", "bench", "timings", "times as long", "half of them", "slower",
            "faster");
    json_object_foreach(json_object_get(comparison, "times_as_slow"), bench, ratios)
        fprintf(file, "%-10s %8d %18.2f %10.2f to %4.2f %8d %8d\n", bench, int_of(counts, bench),
                json_number_value(json_array_get(ratios, 0)), json_number_value(json_array_get(ratios, 1)),
                json_number_value(json_array_get(ratios, 2)), count_changes(comparison, "slower", bench),
                count_changes(comparison, "faster", bench));
    fprintf(file, "by more than %.3g %%, and by more than rounds differ:\n",
            100 * bench_number(comparison, "threshold"));
    print_changes(file, comparison, "slower");
    print_changes(file, comparison, "faster");
}
