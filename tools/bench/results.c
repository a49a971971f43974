/* Extraction of times and rates from the output of benches, and result files. */
#include "bench/results.h"

#include "bench/bench.h"

#include <math.h>
#include <string.h>

const char bench_format_name[] = "tyndall bench";

enum { FILE_SIZE_MAX = 16 << 20, DEPTH_MAX = 12, RESULTS_MAX = 64, TIMINGS_MAX = 4096 };

/* ---- recognition of times ---- */

static bool has_end(const char* text, const char* end) {
    const size_t length = strlen(text), size = strlen(end);
    return length >= size && strcmp(text + length - size, end) == 0;
}

bool bench_is_rate(const char* name) {
    return strstr(name, "per_second") != NULL || strstr(name, "per_core_second") != NULL ||
           strstr(name, "gflops") != NULL || has_end(name, "mrays");
}

static bool is_time(const char* name) {
    return strstr(name, "seconds") != NULL || strstr(name, "_ns") != NULL || strstr(name, "ns_per_") != NULL ||
           has_end(name, "cost");
}

static const char* unit_of(const char* name) {
    if (strstr(name, "gflops") != NULL) return "GFLOP/s";
    if (strstr(name, "gb_per") != NULL) return "GB/s";
    if (strstr(name, "mrays") != NULL) return "million rays/s";
    if (strstr(name, "mcells") != NULL) return "million cells/s";
    if (strstr(name, "msamples") != NULL) return "million samples/s";
    if (strstr(name, "mvertices") != NULL) return "million vertices/s";
    if (strstr(name, "mvoxels") != NULL) return "million voxels/s";
    if (bench_is_rate(name)) return "1/s";
    if (strstr(name, "_ns") != NULL || strstr(name, "ns_per_") != NULL) return "ns";
    return strstr(name, "seconds") != NULL ? "s" : "";
}

void bench_format_timing(const char* name, double value, char out[40]) {
    static const char* const units[] = {"s", "ms", "us", "ns"};
    const char* unit = unit_of(name);
    int smaller = strcmp(unit, "ns") == 0 ? 3 : 0;
    if (strcmp(unit, "s") == 0)
        for (; smaller < 3 && value < 0.9995; ++smaller) value *= 1000;
    const bool time = smaller > 0 || strcmp(unit, "s") == 0;
    if (time) unit = units[smaller];
    snprintf(out, 40, value >= 1000 && value < 1e6 ? "%.0f%s%s" : "%.3g%s%s", value, unit[0] != '\0' ? " " : "", unit);
}

/* ---- names ---- */

/* Members that identify an element of an array. */
static const char* const identities[] = {"name", "case",      "mode", "medium", "rays",   "scaled",
                                         "side", "thickness", "size", "width",  "height", "threads"};
enum { IDENTITIES = sizeof identities / sizeof identities[0] };

static void append(char name[BENCH_TIMING_NAME], const char* separator, const char* text) {
    const size_t used = strlen(name);
    snprintf(name + used, BENCH_TIMING_NAME - used, "%s%s", used > 0 ? separator : "", text);
}

static void append_identity(char label[BENCH_TIMING_NAME], const json_t* value) {
    char text[BENCH_TIMING_NAME] = "";
    if (json_is_array(value)) {
        for (size_t i = 0; i < json_array_size(value); ++i) {
            char number[32];
            snprintf(number, sizeof number, "%.6g", json_number_value(json_array_get(value, i)));
            append(text, "x", number);
        }
    } else if (json_is_number(value)) {
        snprintf(text, sizeof text, "%.6g", json_number_value(value));
    } else if (json_is_string(value)) {
        snprintf(text, sizeof text, "%s", json_string_value(value));
    }
    append(label, " ", text);
}

/* Labels of an array of numbers from a parallel array: "16" of values, "2 threads". */
static const json_t* find_labels(const json_t* object, const json_t* array, const char** unit) {
    static const struct { const char *key, *unit; } kinds[] = {{"values", ""}, {"threads", " threads"}};
    for (size_t i = 0; i < sizeof kinds / sizeof kinds[0]; ++i) {
        const json_t* labels = json_object_get(object, kinds[i].key);
        *unit = kinds[i].unit;
        if (json_is_array(labels) && json_array_size(labels) == json_array_size(array)) return labels;
    }
    return NULL;
}

/* The label of an element: "limited beam 64", or its index without identifying members. */
static void label_element(const json_t* element, size_t index, char label[BENCH_TIMING_NAME]) {
    label[0] = '\0';
    for (int i = 0; i < IDENTITIES; ++i) {
        const json_t* value = json_object_get(element, identities[i]);
        if (value != NULL) append_identity(label, value);
        if (value != NULL && strcmp(identities[i], "threads") == 0) append(label, " ", "threads");
    }
    if (label[0] == '\0') snprintf(label, BENCH_TIMING_NAME, "%zu", index);
}

/* ---- traversal ---- */

/* Adds a number under its name, or, as that is taken, under "NAME #2". */
static void add_timing(json_t* timings, const char* name, double value) {
    char own[BENCH_TIMING_NAME];
    if (!(value > 0) || json_object_size(timings) >= TIMINGS_MAX) return;
    snprintf(own, sizeof own, "%s", name);
    for (int copy = 2; json_object_get(timings, own) != NULL; ++copy)
        snprintf(own, sizeof own, "%.*s #%d", BENCH_TIMING_NAME - 16, name, copy);
    json_object_set_new(timings, own, json_real(value));
}

static void collect(json_t* timings, const json_t* value, const char* name, int depth);

/* object: the parent of the array. */
static void collect_elements(json_t* timings, const json_t* array, const json_t* object, const char* name, int depth) {
    const char* unit;
    const json_t* labels = find_labels(object, array, &unit);
    for (size_t i = 0; i < json_array_size(array); ++i) {
        const json_t* element = json_array_get(array, i);
        char label[BENCH_TIMING_NAME], own[BENCH_TIMING_NAME];
        if (labels != NULL)
            snprintf(label, sizeof label, "%.6g%s", json_number_value(json_array_get(labels, i)), unit);
        else
            label_element(element, i, label);
        snprintf(own, sizeof own, "%s", name);
        append(own, "/", label);
        collect(timings, element, own, depth + 1);
    }
}

/* Rates derived from an object's seconds are left out. */
static bool is_repeated(const json_t* object, const char* key) {
    return json_object_get(object, "seconds") != NULL && strcmp(key, "seconds") != 0 &&
           (strstr(key, "per_second") != NULL || strstr(key, "per_core_second") != NULL ||
            strstr(key, "ns_per_") != NULL || strstr(key, "gflops") != NULL);
}

static void collect(json_t* timings, const json_t* value, const char* name, int depth) {
    const char* key;
    json_t* member;
    if (depth > DEPTH_MAX) return;
    if (json_is_number(value) && (bench_is_rate(name) || is_time(name)))
        add_timing(timings, name, json_number_value(value));
    if (json_is_array(value)) collect_elements(timings, value, NULL, name, depth);
    json_object_foreach((json_t*)value, key, member) {
        char own[BENCH_TIMING_NAME];
        if (is_repeated(value, key)) continue;
        snprintf(own, sizeof own, "%s", name);
        append(own, "/", key);
        if (json_is_array(member))
            collect_elements(timings, member, value, own, depth + 1);
        else
            collect(timings, member, own, depth + 1);
    }
}

/* ---- rounds ---- */

json_t* bench_rounded(double value) {
    if (!isfinite(value)) return json_null();
    if (!(value > 0)) return json_real(value);
    const double unit = pow(10, floor(log10(value)) - 4);
    return json_real(unit < 1 ? round(value / unit) / round(1 / unit) : round(value / unit) * unit);
}

json_t* bench_collect_timings(json_t* const* rounds, int count) {
    json_t *lists[BENCH_ROUNDS_MAX], *timings = json_object(), *first;
    const char* name;
    for (int i = 0; i < count; ++i) collect(lists[i] = json_object(), rounds[i], "", 0);
    json_object_foreach(lists[0], name, first) {
        double values[BENCH_ROUNDS_MAX];
        int found = 0;
        for (int i = 0; i < count; ++i)
            if (json_object_get(lists[i], name) != NULL) values[found++] = bench_number(lists[i], name);
        const double median = bench_median(values, found);
        json_object_set_new(
            timings, name,
            json_pack("[o, o, o]", bench_rounded(median), bench_rounded(values[0]), bench_rounded(values[found - 1])));
    }
    for (int i = 0; i < count; ++i) json_decref(lists[i]);
    return timings;
}

bench_timing bench_get_timing(const json_t* timings, const char* name) {
    const json_t* value = json_object_get(timings, name);
    return (bench_timing){json_number_value(json_array_get(value, 0)), json_number_value(json_array_get(value, 1)),
                          json_number_value(json_array_get(value, 2))};
}

double bench_number(const json_t* object, const char* key) {
    const json_t* value = json_object_get(object, key);
    return json_is_number(value) ? json_number_value(value) : NAN;
}

/* ---- writing ---- */

static bool all_numbers(const json_t* array) {
    for (size_t i = 0; i < json_array_size(array); ++i)
        if (!json_is_number(json_array_get(array, i))) return false;
    return json_array_size(array) <= 16;
}

void bench_write_value(json_writer* json, const char* name, const json_t* value) {
    double numbers[16];
    const char* key;
    json_t* member;
    if (json->depth + 2 >= JSON_DEPTH_MAX) return; /* the file contains unexpected members */
    switch (json_typeof(value)) {
    case JSON_OBJECT:
        json_open_object(json, name);
        json_object_foreach((json_t*)value, key, member) bench_write_value(json, key, member);
        json_close_object(json);
        return;
    case JSON_ARRAY:
        if (all_numbers(value)) {
            for (size_t i = 0; i < json_array_size(value); ++i)
                numbers[i] = json_number_value(json_array_get(value, i));
            json_numbers(json, name, numbers, (int)json_array_size(value));
            return;
        }
        json_open_array(json, name);
        for (size_t i = 0; i < json_array_size(value); ++i) bench_write_value(json, NULL, json_array_get(value, i));
        json_close_array(json);
        return;
    case JSON_STRING: json_text(json, name, json_string_value(value)); return;
    case JSON_TRUE: json_bool(json, name, true); return;
    case JSON_FALSE: json_bool(json, name, false); return;
    case JSON_NULL: json_number(json, name, NAN); return;
    default: json_number(json, name, json_number_value(value)); return;
    }
}

/* ---- reading ---- */

/* Text that can be printed: a version, a date or the name of a bench. */
static bool is_plain(const char* text) {
    static const char plain[] = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789-+.:";
    return text != NULL && text[0] != '\0' && strlen(text) < 32 && text[strspn(text, plain)] == '\0';
}

static bool is_valid_timing(const char* name, const json_t* timings) {
    const json_t* value = json_object_get(timings, name);
    const bench_timing t = bench_get_timing(timings, name);
    return strlen(name) < BENCH_TIMING_NAME && json_array_size(value) == 3 && all_numbers(value) && t.min > 0 &&
           t.min <= t.median && t.median <= t.max;
}

static bool is_valid_bench(const char* name, const json_t* bench) {
    const json_t* timings = json_object_get(bench, "timings");
    const char* key;
    json_t* value;
    if (!is_plain(name)) return false;
    if (timings == NULL)
        return json_is_string(json_object_get(bench, "skipped")) || json_is_string(json_object_get(bench, "failed"));
    json_object_foreach((json_t*)timings, key, value) if (!is_valid_timing(key, timings)) return false;
    return json_is_object(timings) && json_object_size(timings) <= TIMINGS_MAX &&
           json_is_object(json_object_get(bench, "results"));
}

static bool are_valid_benches(const json_t* benches) {
    const char* name;
    json_t* bench;
    json_object_foreach((json_t*)benches, name, bench) if (!is_valid_bench(name, bench)) return false;
    return json_is_object(benches) && json_object_size(benches) <= RESULTS_MAX;
}

static int check_file(const char* path, const json_t* file) {
    static const char* const texts[] = {"version", "date", "isa"};
    const char* format = json_string_value(json_object_get(file, "format"));
    if (format == NULL || strcmp(format, bench_format_name) != 0)
        return cli_fail(CLI_USAGE, "%s: is no result file of 'tyndall bench --json'", path);
    const json_int_t shape = json_integer_value(json_object_get(file, "format_version"));
    if (shape != BENCH_FORMAT_VERSION)
        return cli_fail(CLI_USAGE, "%s: is of format version %lld, and this program reads %d: measure it anew", path,
                        (long long)shape, BENCH_FORMAT_VERSION);
    for (size_t i = 0; i < sizeof texts / sizeof *texts; ++i)
        if (!is_plain(json_string_value(json_object_get(file, texts[i]))))
            return cli_fail(CLI_USAGE, "%s: its %s is not as 'tyndall bench --json' writes it", path, texts[i]);
    if (are_valid_benches(json_object_get(file, "benches"))) return CLI_GO;
    return cli_fail(CLI_USAGE, "%s: its benches are not as 'tyndall bench --json' writes them", path);
}

int bench_read_results(cli_session* session, const char* path, json_t** out) {
    uint8_t* bytes = NULL;
    size_t size = 0;
    json_error_t error;
    const ty_result result = ty_bytes_read(session->context, path, FILE_SIZE_MAX, &bytes, &size);
    if (result != TY_OK) return cli_fail_reading(session, result);
    *out = json_loadb((const char*)bytes, size, JSON_REJECT_DUPLICATES, &error);
    ty_bytes_destroy(session->context, bytes, size);
    if (*out == NULL) return cli_fail(CLI_USAGE, "%s:%d: is not JSON: %s", path, error.line, error.text);
    return check_file(path, *out);
}
