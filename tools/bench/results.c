/* Extraction of times and rates from the output of benches, and result files. */
#include "bench/results.h"

#include "bench/bench.h"

#include <jansson.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

static const char format_name[] = "tyndall bench";

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

const char* bench_timing_unit(const char* name) {
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

typedef struct timing_list {
    bench_timing* items;
    size_t count, capacity;
    bool failed; /* out of memory */
} timing_list;

static bool has_timing(const timing_list* list, const char* name) {
    for (size_t i = 0; i < list->count; ++i)
        if (strcmp(list->items[i].name, name) == 0) return true;
    return false;
}

static void add_timing(timing_list* list, const char* name, double value) {
    if (!(value > 0) || list->count >= TIMINGS_MAX) return;
    if (list->count == list->capacity) {
        const size_t capacity = list->capacity == 0 ? 64 : 2 * list->capacity;
        bench_timing* grown = realloc(list->items, capacity * sizeof *grown);
        list->failed = list->failed || grown == NULL;
        if (grown == NULL) return;
        list->items = grown;
        list->capacity = capacity;
    }
    bench_timing timing = {.median = value, .min = value, .max = value};
    snprintf(timing.name, sizeof timing.name, "%s", name);
    for (int copy = 2; has_timing(list, timing.name); ++copy)
        snprintf(timing.name, sizeof timing.name, "%.*s #%d", BENCH_TIMING_NAME - 16, name, copy);
    list->items[list->count++] = timing;
}

static void collect(timing_list* list, const json_t* value, const char* name, int depth);

/* object: the parent of the array. */
static void collect_elements(timing_list* list, const json_t* array, const json_t* object, const char* name,
                             int depth) {
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
        collect(list, element, own, depth + 1);
    }
}

/* Rates derived from an object's seconds are left out. */
static bool is_repeated(const json_t* object, const char* key) {
    return json_object_get(object, "seconds") != NULL && strcmp(key, "seconds") != 0 &&
           (strstr(key, "per_second") != NULL || strstr(key, "per_core_second") != NULL ||
            strstr(key, "ns_per_") != NULL || strstr(key, "gflops") != NULL);
}

static void collect_members(timing_list* list, const json_t* object, const char* name, int depth) {
    const char* key;
    json_t* value;
    json_object_foreach((json_t*)object, key, value) {
        char own[BENCH_TIMING_NAME];
        snprintf(own, sizeof own, "%s", name);
        append(own, "/", key);
        if (is_repeated(object, key)) continue;
        if (json_is_array(value))
            collect_elements(list, value, object, own, depth + 1);
        else
            collect(list, value, own, depth + 1);
    }
}

static void collect(timing_list* list, const json_t* value, const char* name, int depth) {
    if (depth > DEPTH_MAX) return;
    if (json_is_object(value)) collect_members(list, value, name, depth);
    if (json_is_array(value)) collect_elements(list, value, NULL, name, depth);
    if (json_is_number(value) && (bench_is_rate(name) || is_time(name)))
        add_timing(list, name, json_number_value(value));
}

/* ---- rounds ---- */

ty_result bench_add_round(bench_result* result, const char* text, size_t size) {
    json_t* round = json_loadb(text, size, 0, NULL);
    if (round == NULL) return TY_ERROR_MEMORY; /* the JSON is our own, and so valid */
    result->rounds[result->round_count++] = round;
    return TY_OK;
}

static void summarize_timing(bench_timing* timing, const timing_list lists[], int count) {
    double values[BENCH_ROUNDS_MAX];
    int found = 0;
    for (int i = 0; i < count; ++i)
        for (size_t j = 0; j < lists[i].count; ++j)
            if (strcmp(lists[i].items[j].name, timing->name) == 0) values[found++] = lists[i].items[j].median;
    timing->median = bench_median(values, found);
    timing->min = values[0];
    timing->max = values[found - 1];
}

ty_result bench_finish_result(bench_result* result) {
    timing_list lists[BENCH_ROUNDS_MAX] = {{0}};
    bool failed = false;
    for (int i = 0; i < result->round_count; ++i) {
        collect(&lists[i], result->rounds[i], "", 0);
        failed = failed || lists[i].failed;
    }
    bench_timing* timings = calloc(lists[0].count + 1, sizeof *timings);
    failed = failed || timings == NULL;
    for (size_t i = 0; i < lists[0].count && !failed; ++i) {
        timings[i] = lists[0].items[i];
        summarize_timing(&timings[i], lists, result->round_count);
    }
    result->timings = timings;
    result->timing_count = failed ? 0 : lists[0].count;
    for (int i = 0; i < result->round_count; ++i) free(lists[i].items);
    return failed ? TY_ERROR_MEMORY : TY_OK;
}

void bench_free_results(bench_results* results) {
    for (int i = 0; i < results->count; ++i) {
        bench_result* result = &results->benches[i];
        for (int r = 0; r < result->round_count; ++r) json_decref(result->rounds[r]);
        free(result->timings);
    }
    free(results->benches);
    json_decref(results->file);
    *results = (bench_results){0};
}

const bench_timing* bench_find_timing(const bench_result* result, const char* name) {
    for (size_t i = 0; i < result->timing_count; ++i)
        if (strcmp(result->timings[i].name, name) == 0) return &result->timings[i];
    return NULL;
}

const bench_result* bench_find_result(const bench_results* results, const char* name) {
    for (int i = 0; i < results->count; ++i)
        if (strcmp(results->benches[i].name, name) == 0) return &results->benches[i];
    return NULL;
}

/* ---- writing ---- */

static bool all_numbers(const json_t* array) {
    for (size_t i = 0; i < json_array_size(array); ++i)
        if (!json_is_number(json_array_get(array, i))) return false;
    return json_array_size(array) <= 16;
}

static void write_value(json_writer* json, const char* name, const json_t* value) {
    double numbers[16];
    const char* key;
    json_t* member;
    if (json->depth + 2 >= JSON_DEPTH_MAX) return; /* the file contains unexpected members */
    switch (json_typeof(value)) {
    case JSON_OBJECT:
        json_open_object(json, name);
        json_object_foreach((json_t*)value, key, member) write_value(json, key, member);
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
        for (size_t i = 0; i < json_array_size(value); ++i) write_value(json, NULL, json_array_get(value, i));
        json_close_array(json);
        return;
    case JSON_STRING: json_text(json, name, json_string_value(value)); return;
    case JSON_TRUE: json_bool(json, name, true); return;
    case JSON_FALSE: json_bool(json, name, false); return;
    case JSON_NULL: json_number(json, name, NAN); return;
    default: json_number(json, name, json_number_value(value)); return;
    }
}

/* Rounds to five digits, more than the precision of timings. */
static double rounded(double value) {
    if (!(value > 0)) return value;
    const double unit = pow(10, floor(log10(value)) - 4);
    return unit < 1 ? round(value / unit) / round(1 / unit) : round(value / unit) * unit;
}

static void write_timings(json_writer* json, const bench_result* result) {
    json_open_object(json, "timings");
    for (size_t i = 0; i < result->timing_count; ++i) {
        const bench_timing* timing = &result->timings[i];
        json_numbers(json, timing->name,
                     (const double[]){rounded(timing->median), rounded(timing->min), rounded(timing->max)}, 3);
    }
    json_close_object(json);
}

static void write_result(json_writer* json, const bench_result* result) {
    json_open_object(json, result->name);
    json_number(json, "load_before", rounded(result->load_before));
    if (result->status == CLI_DONE) {
        json_number(json, "others_busy", rounded(result->other_load));
        json_number(json, "seconds", rounded(result->seconds));
        write_timings(json, result);
        write_value(json, "results", result->rounds[0]);
    } else {
        json_text(json, result->status == CLI_USAGE ? "skipped" : "failed", result->message);
    }
    json_close_object(json);
}

void bench_write_results(json_writer* json, const bench_results* results) {
    json_text(json, "format", format_name);
    json_int(json, "format_version", BENCH_FORMAT_VERSION);
    json_text(json, "version", results->version);
    json_text(json, "date", results->date);
    json_int(json, "processors", results->processors);
    json_int(json, "threads", results->threads);
    json_text(json, "isa", results->isa);
    json_bool(json, "quick", results->quick);
    json_int(json, "spp", results->spp);
    json_numbers(json, "size", (const double[]){results->size[0], results->size[1]}, 2);
    json_int(json, "side", results->side);
    json_int(json, "runs", results->runs);
    json_int(json, "rounds", results->rounds);
    json_bool(json, "complete", results->complete);
    json_open_object(json, "benches");
    for (int i = 0; i < results->count; ++i)
        if (results->benches[i].status != CLI_GO) write_result(json, &results->benches[i]);
    json_close_object(json);
}

/* ---- reading ---- */

static const char plain[] = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789-+.:";

/* Copies text up to the first character that cannot be part of a version or a date. */
static void copy_text(const json_t* file, const char* key, char* out, size_t size) {
    const char* text = json_string_value(json_object_get(file, key));
    snprintf(out, size, "%s", text != NULL ? text : "");
    out[strspn(out, plain)] = '\0';
}

static double number_or_nan(const json_t* object, const char* key) {
    const json_t* value = json_object_get(object, key);
    return json_is_number(value) ? json_number_value(value) : NAN;
}

static bool read_timing(const char* name, const json_t* value, bench_timing* out) {
    if (json_array_size(value) != 3 || !all_numbers(value) || strlen(name) >= sizeof out->name) return false;
    snprintf(out->name, sizeof out->name, "%s", name);
    out->median = json_number_value(json_array_get(value, 0));
    out->min = json_number_value(json_array_get(value, 1));
    out->max = json_number_value(json_array_get(value, 2));
    return out->median > 0 && out->min > 0 && out->min <= out->median && out->median <= out->max;
}

/* Returns false for invalid input. */
static bool read_result(const char* name, const json_t* value, bench_result* out) {
    const json_t* timings = json_object_get(value, "timings");
    const char *key, *skipped = json_string_value(json_object_get(value, "skipped"));
    const char* failed = json_string_value(json_object_get(value, "failed"));
    json_t* timing;
    if (name[0] == '\0' || name[strspn(name, plain)] != '\0') return false;
    *out = (bench_result){.name = name,
                          .load_before = number_or_nan(value, "load_before"),
                          .other_load = number_or_nan(value, "others_busy"),
                          .seconds = number_or_nan(value, "seconds")};
    out->status = timings != NULL ? CLI_DONE : skipped != NULL ? CLI_USAGE : CLI_FAILED;
    if (timings == NULL) {
        snprintf(out->message, sizeof out->message, "%s", skipped != NULL ? skipped : failed != NULL ? failed : "");
        return skipped != NULL || failed != NULL;
    }
    out->timings = calloc(json_object_size(timings) + 1, sizeof *out->timings);
    if (out->timings == NULL || !json_is_object(timings) || json_object_size(timings) > TIMINGS_MAX) return false;
    json_t* results = json_object_get(value, "results");
    if (json_is_object(results)) out->rounds[out->round_count++] = json_incref(results);
    json_object_foreach((json_t*)timings, key,
                        timing) if (!read_timing(key, timing, &out->timings[out->timing_count++])) return false;
    return out->round_count == 1;
}

static bool read_benches(bench_results* results) {
    const json_t* benches = json_object_get(results->file, "benches");
    const char* key;
    json_t* value;
    if (!json_is_object(benches) || json_object_size(benches) > RESULTS_MAX) return false;
    results->benches = calloc(json_object_size(benches) + 1, sizeof *results->benches);
    if (results->benches == NULL) return false;
    json_object_foreach((json_t*)benches, key,
                        value) if (!read_result(key, value, &results->benches[results->count++])) return false;
    return true;
}

static int refuse(const char* path, const char* what) {
    return cli_fail(CLI_USAGE, "%s: %s", path, what);
}

static int parse_file(const char* path, bench_results* out) {
    const char* format = json_string_value(json_object_get(out->file, "format"));
    if (format == NULL || strcmp(format, format_name) != 0)
        return refuse(path, "is no result file of 'tyndall bench --json'");
    const json_int_t shape = json_integer_value(json_object_get(out->file, "format_version"));
    if (shape != BENCH_FORMAT_VERSION)
        return cli_fail(CLI_USAGE, "%s: is of format version %lld, and this program reads %d: measure it anew", path,
                        (long long)shape, BENCH_FORMAT_VERSION);
    copy_text(out->file, "version", out->version, sizeof out->version);
    copy_text(out->file, "date", out->date, sizeof out->date);
    copy_text(out->file, "isa", out->isa, sizeof out->isa);
    out->processors = (int)json_integer_value(json_object_get(out->file, "processors"));
    out->threads = (int)json_integer_value(json_object_get(out->file, "threads"));
    out->spp = (int)json_integer_value(json_object_get(out->file, "spp"));
    out->side = (int)json_integer_value(json_object_get(out->file, "side"));
    for (size_t i = 0; i < 2; ++i)
        out->size[i] = (int)json_integer_value(json_array_get(json_object_get(out->file, "size"), i));
    out->runs = (int)json_integer_value(json_object_get(out->file, "runs"));
    out->rounds = (int)json_integer_value(json_object_get(out->file, "rounds"));
    out->quick = json_is_true(json_object_get(out->file, "quick"));
    out->complete = json_is_true(json_object_get(out->file, "complete"));
    return read_benches(out) ? CLI_GO : refuse(path, "its benches are not as 'tyndall bench --json' writes them");
}

int bench_read_results(cli_session* session, const char* path, bench_results* out) {
    uint8_t* bytes = NULL;
    size_t size = 0;
    json_error_t error;
    *out = (bench_results){0};
    const ty_result result = ty_bytes_read(session->context, path, FILE_SIZE_MAX, &bytes, &size);
    if (result != TY_OK) return cli_fail_reading(session, result);
    out->file = json_loadb((const char*)bytes, size, JSON_REJECT_DUPLICATES, &error);
    ty_bytes_destroy(session->context, bytes, size);
    if (out->file == NULL) return cli_fail(CLI_USAGE, "%s:%d: is not JSON: %s", path, error.line, error.text);
    const int status = parse_file(path, out);
    if (status != CLI_GO) bench_free_results(out);
    return status;
}
