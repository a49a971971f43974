/* Comparison of timings with earlier ones. */
#include "bench/compare.h"

#include "bench/bench.h"
#include "cli/text.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- matching ---- */

static size_t count_timings(const bench_results* results) {
    size_t count = 0;
    for (int i = 0; i < results->count; ++i) count += results->benches[i].timing_count;
    return count;
}

static bench_change make_change(const bench_result* bench, const bench_timing* now, const bench_timing* before) {
    const double ratio = now->median / before->median;
    return (bench_change){.bench = bench,
                          .now = now,
                          .before = before,
                          .slower = bench_is_rate(now->name) ? 1 / ratio : ratio,
                          .disjoint = now->min > before->max || now->max < before->min};
}

/* Benches in only one of the results are not compared; their timings do not count as missing. */
ty_result bench_compare(const bench_results* now, const bench_results* before, bench_comparison* out) {
    *out = (bench_comparison){.now = now, .before = before};
    out->changes = calloc(count_timings(now) + 1, sizeof *out->changes);
    if (out->changes == NULL) return TY_ERROR_MEMORY;
    for (int i = 0; i < now->count; ++i) {
        const bench_result* bench = &now->benches[i];
        const bench_result* earlier = bench_find_result(before, bench->name);
        if (earlier == NULL || earlier->timing_count == 0 || bench->timing_count == 0) continue;
        const size_t found = out->count;
        for (size_t t = 0; t < bench->timing_count; ++t) {
            const bench_timing* timing = bench_find_timing(earlier, bench->timings[t].name);
            if (timing == NULL)
                ++out->only_now;
            else
                out->changes[out->count++] = make_change(bench, &bench->timings[t], timing);
        }
        out->only_before += earlier->timing_count - (out->count - found);
    }
    return TY_OK;
}

void bench_free_comparison(bench_comparison* comparison) {
    free(comparison->changes);
    *comparison = (bench_comparison){0};
}

const bench_change* bench_find_change(const bench_comparison* comparison, const bench_timing* now) {
    for (size_t i = 0; i < comparison->count; ++i)
        if (comparison->changes[i].now == now) return &comparison->changes[i];
    return NULL;
}

bool bench_is_slower(const bench_change* change, double threshold) {
    return change->disjoint && change->slower > 1 + threshold;
}

bool bench_is_faster(const bench_change* change, double threshold) {
    return change->disjoint && 1 / change->slower > 1 + threshold;
}

size_t bench_count_slower(const bench_comparison* comparison, double threshold) {
    size_t count = 0;
    for (size_t i = 0; i < comparison->count; ++i) count += bench_is_slower(&comparison->changes[i], threshold) ? 1 : 0;
    return count;
}

/* Ratios of one bench: median and quartiles. */
typedef struct summary {
    size_t count, slower, faster;
    double median, lower, upper;
} summary;

static summary summarize(const bench_comparison* comparison, const bench_result* bench, double threshold,
                         double* ratios) {
    summary s = {0};
    for (size_t i = 0; i < comparison->count; ++i) {
        const bench_change* change = &comparison->changes[i];
        if (change->bench != bench) continue;
        ratios[s.count++] = change->slower;
        s.slower += bench_is_slower(change, threshold) ? 1 : 0;
        s.faster += bench_is_faster(change, threshold) ? 1 : 0;
    }
    if (s.count == 0) return s;
    s.median = bench_median(ratios, (int)s.count);
    s.lower = ratios[s.count / 4];
    s.upper = ratios[s.count - 1 - s.count / 4];
    return s;
}

/* ---- printing ---- */

void bench_warn_differences(cli_session* session, const bench_comparison* comparison, const char* path) {
    const bench_results *now = comparison->now, *before = comparison->before;
    char text[512];
    if (session->common.quiet) return;
    if (strcmp(now->version, before->version) != 0) {
        snprintf(text, sizeof text, "%s is of version %s, and this is %s: they are compared all the same", path,
                 before->version, now->version);
        cli_progress_warn(&session->progress, text);
    }
    if (now->threads != before->threads || now->processors != before->processors ||
        strcmp(now->isa, before->isa) != 0) {
        snprintf(text, sizeof text, "%s is of another machine: %d threads on %d processors of %s, not %d on %d of %s",
                 path, before->threads, before->processors, before->isa, now->threads, now->processors, now->isa);
        cli_progress_warn(&session->progress, text);
    }
    if (now->quick != before->quick || now->spp != before->spp || now->side != before->side ||
        now->size[0] != before->size[0] || now->size[1] != before->size[1]) {
        snprintf(text, sizeof text,
                 "%s was measured with other options (--spp %d, --side %d, %s size%s): some times mean other things",
                 path, before->spp, before->side, before->size[0] > 0 ? "a given" : "no given",
                 before->quick ? ", --quick" : "");
        cli_progress_warn(&session->progress, text);
    }
}

void bench_format_timing(const char* name, double value, char out[40]) {
    static const char* const units[] = {"s", "ms", "us", "ns"};
    const char* unit = bench_timing_unit(name);
    int smaller = strcmp(unit, "ns") == 0 ? 3 : 0;
    if (strcmp(unit, "s") == 0)
        for (; smaller < 3 && value < 0.9995; ++smaller) value *= 1000;
    const bool time = smaller > 0 || strcmp(unit, "s") == 0;
    if (time) unit = units[smaller];
    snprintf(out, 40, value >= 1000 && value < 1e6 ? "%.0f%s%s" : "%.3g%s%s", value, unit[0] != '\0' ? " " : "", unit);
}

static void print_changes(FILE* file, const bench_comparison* comparison, double threshold, bool slower) {
    for (size_t i = 0; i < comparison->count; ++i) {
        const bench_change* change = &comparison->changes[i];
        char before[40], now[40];
        if (!(slower ? bench_is_slower(change, threshold) : bench_is_faster(change, threshold))) continue;
        bench_format_timing(change->now->name, change->before->median, before);
        bench_format_timing(change->now->name, change->now->median, now);
        fprintf(file, "  %-7s %5.2f  ", slower ? "slower" : "faster", slower ? change->slower : 1 / change->slower);
        cli_print_text(file, change->bench->name, 0);
        fputs("/", file);
        cli_print_text(file, change->now->name, 0);
        fprintf(file, ": %s, before %s\n", now, before);
    }
}

void bench_print_comparison(FILE* file, const bench_comparison* comparison, const char* path, double threshold) {
    double* ratios = malloc((comparison->count + 1) * sizeof *ratios);
    fputs("against ", file);
    cli_print_text(file, path, 0);
    fputs(" (", file);
    cli_print_text(file, comparison->before->version, 0);
    fputs(", ", file);
    cli_print_text(file, comparison->before->date, 0);
    fprintf(file, "): %zu times and rates, %zu new, %zu gone\n", comparison->count, comparison->only_now,
            comparison->only_before);
    if (ratios == NULL) return;
    fprintf(file, "%-10s %8s %18s %18s %8s %8s\n", "bench", "timings", "times as long", "half of them", "slower",
            "faster");
    for (int i = 0; i < comparison->now->count; ++i) {
        const bench_result* bench = &comparison->now->benches[i];
        const summary s = summarize(comparison, bench, threshold, ratios);
        if (s.count == 0) continue;
        cli_print_text(file, bench->name, 10);
        fprintf(file, " %8zu %18.2f %10.2f to %4.2f %8zu %8zu\n", s.count, s.median, s.lower, s.upper, s.slower,
                s.faster);
    }
    free(ratios);
    fprintf(file, "by more than %.3g %%, and by more than rounds differ:\n", 100 * threshold);
    print_changes(file, comparison, threshold, true);
    print_changes(file, comparison, threshold, false);
}

static void write_change(json_writer* json, const bench_change* change) {
    json_open_object(json, NULL);
    json_text(json, "bench", change->bench->name);
    json_text(json, "timing", change->now->name);
    json_number(json, "times_as_slow", change->slower);
    json_number(json, "now", change->now->median);
    json_number(json, "before", change->before->median);
    json_close_object(json);
}

void bench_write_comparison(json_writer* json, const bench_comparison* comparison, const char* path, double threshold) {
    double* ratios = malloc((comparison->count + 1) * sizeof *ratios);
    json_open_object(json, "baseline");
    json_text(json, "file", path);
    json_text(json, "version", comparison->before->version);
    json_text(json, "date", comparison->before->date);
    json_number(json, "threshold", threshold);
    json_open_object(json, "times_as_slow");
    for (int i = 0; i < comparison->now->count && ratios != NULL; ++i) {
        const bench_result* bench = &comparison->now->benches[i];
        const summary s = summarize(comparison, bench, threshold, ratios);
        if (s.count > 0) json_numbers(json, bench->name, (const double[]){s.median, s.lower, s.upper}, 3);
    }
    json_close_object(json);
    free(ratios);
    json_open_array(json, "slower");
    for (size_t i = 0; i < comparison->count; ++i)
        if (bench_is_slower(&comparison->changes[i], threshold)) write_change(json, &comparison->changes[i]);
    json_close_array(json);
    json_open_array(json, "faster");
    for (size_t i = 0; i < comparison->count; ++i)
        if (bench_is_faster(&comparison->changes[i], threshold)) write_change(json, &comparison->changes[i]);
    json_close_array(json);
    json_close_object(json);
}
