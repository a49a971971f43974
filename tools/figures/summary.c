/* Reading figures back, and checking and counting their numbers. */
#define _GNU_SOURCE
#include "figures/summary.h"

#include <jansson.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { FILE_SIZE_MAX = 16 << 20, QUANTITIES_MAX = 1 << 16 };

bool figure_is_there(const figure_outcome* outcome) {
    return outcome->state == FIGURE_EARLIER || outcome->state == FIGURE_MADE || outcome->state == FIGURE_KEPT;
}

bool figure_is_listed(const figure_outcome* outcome) {
    return outcome->state != FIGURE_ABSENT;
}

bool figure_has_paper(const figure_summary* summary, int paper) {
    for (int i = 0; i < figure_entry_count; ++i)
        if ((int)figure_entries[i].paper == paper && figure_is_listed(&summary->outcomes[i])) return true;
    return false;
}

const char* figure_state_name(figure_state state) {
    static const char* const names[] = {
        [FIGURE_ABSENT] = "absent",   [FIGURE_EARLIER] = "earlier", [FIGURE_MADE] = "made",     [FIGURE_KEPT] = "kept",
        [FIGURE_SKIPPED] = "skipped", [FIGURE_FAILED] = "failed",   [FIGURE_LEFT] = "not made",
    };
    return names[state];
}

/* ---- files ---- */

static bool has_file(const char* folder, const char* name, const char* extension) {
    char path[FIGURE_PATH_SIZE];
    snprintf(path, sizeof path, "%s/%s%s", folder, name, extension);
    return access(path, R_OK) == 0;
}

/* NULL: missing, or not JSON. */
static json_t* read_json(cli_session* session, const char* folder, const char* name) {
    char path[FIGURE_PATH_SIZE];
    uint8_t* bytes = NULL;
    size_t size = 0;
    snprintf(path, sizeof path, "%s/%s.json", folder, name);
    if (access(path, R_OK) != 0 || ty_bytes_read(session->context, path, FILE_SIZE_MAX, &bytes, &size) != TY_OK)
        return NULL;
    json_t* root = json_loadb((const char*)bytes, size, 0, NULL);
    ty_bytes_destroy(session->context, bytes, size);
    const char* figure = json_string_value(json_object_get(root, "figure"));
    if (figure != NULL && strcmp(figure, name) == 0) return root;
    json_decref(root);
    return NULL;
}

static bool is_number(const json_t* value, double number) {
    return json_is_number(value) && json_number_value(value) == number;
}

bool figure_can_keep(cli_session* session, const figure_options* options, const char* name) {
    json_t* root = read_json(session, options->folder, name);
    const char* version = json_string_value(json_object_get(root, "version"));
    const json_t* size = json_object_get(root, "size");
    const json_t* network = json_object_get(root, "network");
    const bool data = options->data != NULL && access(options->data, R_OK) == 0;
    const bool up_to_date = version != NULL && strcmp(version, ty_version()) == 0 &&
                            json_is_true(json_object_get(root, "quick")) == options->quick &&
                            json_is_true(json_object_get(root, "data")) == data &&
                            is_number(json_object_get(root, "spp"), options->samples) &&
                            is_number(json_array_get(network, 0), options->latency) &&
                            is_number(json_array_get(network, 1), options->bandwidth) &&
                            is_number(json_object_get(root, "seed"), (double)session->common.seed) &&
                            is_number(json_array_get(size, 0), options->size[0]) &&
                            is_number(json_array_get(size, 1), options->size[1]);
    json_decref(root);
    return up_to_date && has_file(options->folder, name, ".png") && has_file(options->folder, name, ".csv");
}

/* ---- reading ---- */

static double number_or_nan(const json_t* object, const char* key) {
    const json_t* value = json_object_get(object, key);
    return json_is_number(value) ? json_number_value(value) : NAN;
}

static void copy_text(const json_t* object, const char* key, char* out, size_t size) {
    const char* text = json_string_value(json_object_get(object, key));
    snprintf(out, size, "%s", text != NULL ? text : "");
}

bool figure_is_within(const figure_quantity* q) {
    return fabs(q->measured - q->expected) <= q->tolerance + 1e-9 * fabs(q->expected);
}

static void count_quantity(const figure_quantity* q, figure_outcome* out) {
    if (isnan(q->expected)) return;
    out->checked += isnan(q->tolerance) ? 0 : 1;
    out->compared += isnan(q->tolerance) ? 1 : 0;
    if (isnan(q->tolerance)) return;
    out->within += figure_is_within(q) ? 1 : 0;
    out->unknown += isnan(q->measured) ? 1 : 0;
}

static ty_result read_outcome(const json_t* root, figure_outcome* out) {
    const json_t* quantities = json_object_get(root, "quantities");
    const char* caption = json_string_value(json_object_get(root, "caption"));
    const size_t count = json_array_size(quantities) < QUANTITIES_MAX ? json_array_size(quantities) : QUANTITIES_MAX;
    out->seconds = number_or_nan(root, "seconds");
    out->quick = json_is_true(json_object_get(root, "quick"));
    out->own_settings = !out->quick && is_number(json_object_get(root, "spp"), 0) &&
                        is_number(json_array_get(json_object_get(root, "size"), 0), 0);
    copy_text(root, "version", out->version, sizeof out->version);
    out->caption = strdup(caption != NULL ? caption : "");
    out->quantities = calloc(count + 1, sizeof *out->quantities);
    out->unit_texts = calloc(count + 1, sizeof *out->unit_texts);
    if (out->caption == NULL || out->quantities == NULL || out->unit_texts == NULL) return TY_ERROR_MEMORY;
    for (size_t i = 0; i < count; ++i) {
        const json_t* value = json_array_get(quantities, i);
        figure_quantity* q = &out->quantities[i];
        copy_text(value, "item", q->item, sizeof q->item);
        copy_text(value, "name", q->name, sizeof q->name);
        copy_text(value, "unit", out->unit_texts[i], sizeof out->unit_texts[i]);
        q->unit = out->unit_texts[i];
        q->measured = number_or_nan(value, "measured");
        q->expected = number_or_nan(value, "expected");
        q->tolerance = number_or_nan(value, "tolerance");
        count_quantity(q, out);
    }
    out->count = count;
    return TY_OK;
}

ty_result figure_read_summary(cli_session* session, figure_summary* summary) {
    ty_result result = TY_OK;
    for (int i = 0; i < figure_entry_count && result == TY_OK; ++i) {
        figure_outcome* outcome = &summary->outcomes[i];
        const char* name = figure_entries[i].name;
        if (outcome->state != FIGURE_ABSENT && !figure_is_there(outcome)) continue;
        json_t* root = has_file(summary->folder, name, ".png") ? read_json(session, summary->folder, name) : NULL;
        if (root != NULL) {
            if (outcome->state == FIGURE_ABSENT) outcome->state = FIGURE_EARLIER;
            result = read_outcome(root, outcome);
        }
        json_decref(root);
    }
    return result;
}

void figure_free_summary(figure_summary* summary) {
    for (int i = 0; i < figure_entry_count && summary->outcomes != NULL; ++i) {
        free(summary->outcomes[i].caption);
        free(summary->outcomes[i].quantities);
        free(summary->outcomes[i].unit_texts);
    }
    free(summary->outcomes);
    *summary = (figure_summary){0};
}

/* ---- groups ---- */

static bool are_alike(const figure_quantity* a, const figure_quantity* b) {
    return strcmp(a->name, b->name) == 0 && strcmp(a->unit, b->unit) == 0 && !isnan(b->expected) &&
           isnan(a->tolerance) == isnan(b->tolerance);
}

static bool begins_group(const figure_outcome* outcome, size_t at, bool checked) {
    const figure_quantity* q = &outcome->quantities[at];
    if (isnan(q->expected) || isnan(q->tolerance) == checked) return false;
    for (size_t i = 0; i < at; ++i)
        if (are_alike(q, &outcome->quantities[i])) return false;
    return true;
}

static bool expects_same(const figure_outcome* outcome, size_t from) {
    const figure_quantity* first = &outcome->quantities[from];
    for (size_t i = from; i < outcome->count; ++i) {
        const figure_quantity* q = &outcome->quantities[i];
        const bool same = q->expected == first->expected && (q->tolerance == first->tolerance || isnan(q->tolerance));
        if (are_alike(first, q) && !same) return false;
    }
    return true;
}

static void add_out(figure_group* group, const figure_quantity* q) {
    const size_t used = strlen(group->out);
    snprintf(group->out + used, sizeof group->out - used, "%s%s: %.4g", used > 0 ? "; " : "", q->item, q->measured);
}

static double group_value(const figure_group* group, const figure_quantity* q) {
    if (group->same) return q->measured;
    if (!group->checked) return q->measured / q->expected;
    return q->measured == q->expected ? 0 : fabs(q->measured - q->expected) / q->tolerance;
}

static void add_to_group(figure_group* group, const figure_quantity* q) {
    const double value = group_value(group, q);
    const bool within = group->checked && figure_is_within(q);
    ++group->count;
    group->within += within ? 1 : 0;
    group->unknown += isnan(value) ? 1 : 0;
    group->min = fmin(group->min, value);
    group->max = fmax(group->max, value);
    if (group->checked && !within && !isnan(value)) add_out(group, q);
}

bool figure_get_group(const figure_outcome* outcome, size_t index, figure_group* out) {
    size_t found = 0;
    for (int unchecked = 0; unchecked < 2; ++unchecked)
        for (size_t i = 0; i < outcome->count; ++i) {
            if (!begins_group(outcome, i, unchecked == 0) || found++ != index) continue;
            const figure_quantity* first = &outcome->quantities[i];
            *out = (figure_group){.first = first,
                                  .checked = unchecked == 0,
                                  .same = expects_same(outcome, i),
                                  .min = INFINITY,
                                  .max = -INFINITY};
            for (size_t j = i; j < outcome->count; ++j)
                if (are_alike(first, &outcome->quantities[j])) add_to_group(out, &outcome->quantities[j]);
            return true;
        }
    return false;
}
