/* tyndall flux: files of spectral bands. */
#include "cli/flux/flux.h"

#include <jansson.h>
#include <stdlib.h>
#include <string.h>

/* "KEY=VALUE", as -D has it; NULL: no memory. */
static char* make_change(const char* key, const json_t* value) {
    char* text = json_dumps(value, JSON_ENCODE_ANY | JSON_COMPACT);
    const size_t size = text != NULL ? strlen(key) + strlen(text) + 2 : 0;
    char* change = text != NULL ? malloc(size) : NULL;
    if (change != NULL) snprintf(change, size, "%s=%s", key, text);
    free(text);
    return change;
}

static int read_changes(const char* path, size_t i, json_t* set, flux_band* band) {
    const char* key;
    json_t* value;
    json_object_foreach(set, key, value) {
        if (band->change_count == FLUX_BAND_CHANGES_MAX)
            return cli_usage_error("flux", "%s: band %zu: there are more than %d changes", path, i,
                                   FLUX_BAND_CHANGES_MAX);
        char* change = make_change(key, value);
        if (change == NULL) return cli_usage_error("flux", "%s: band %zu: not enough memory", path, i);
        band->changes[band->change_count++] = change;
    }
    return CLI_GO;
}

static int read_band(const char* path, size_t i, const json_t* entry, flux_band* band) {
    static const char* const keys[] = {"name", "weight", "set", NULL};
    const char* key;
    json_t *value, *name = json_object_get(entry, "name"), *weight = json_object_get(entry, "weight");
    json_t* set = json_object_get(entry, "set");
    if (!json_is_object(entry)) return cli_usage_error("flux", "%s: band %zu is not an object", path, i);
    json_object_foreach((json_t*)entry, key, value) {
        int k = 0;
        while (keys[k] != NULL && strcmp(keys[k], key) != 0) ++k;
        if (keys[k] == NULL)
            return cli_usage_error("flux", "%s: band %zu: unknown key \"%s\"; there are name, weight, set", path, i,
                                   key);
    }
    if (!json_is_string(name) || (weight != NULL && !json_is_number(weight)) || !json_is_object(set))
        return cli_usage_error("flux", "%s: band %zu needs \"name\": TEXT and \"set\": {KEY: VALUE, ...}", path, i);
    band->name = json_string_value(name);
    band->weight = weight != NULL ? json_number_value(weight) : 1;
    return read_changes(path, i, set, band);
}

int flux_read_bands(const char* path, flux_bands* out) {
    json_error_t error;
    json_t* root = path != NULL ? json_load_file(path, JSON_REJECT_DUPLICATES, &error) : NULL;
    if (path != NULL && root == NULL)
        return cli_usage_error("flux", "%s:%d: %s", path, error.line > 0 ? error.line : 1, error.text);
    out->document = root;
    const size_t count = path != NULL ? json_array_size(root) : 1;
    if (count < 1 || count > FLUX_BANDS_MAX)
        return cli_usage_error("flux", "%s: it is not an array of 1 to %d bands", path, FLUX_BANDS_MAX);
    out->bands = calloc(count, sizeof *out->bands);
    if (out->bands == NULL) return cli_usage_error("flux", "not enough memory for %zu bands", count);
    out->count = (int32_t)count;
    out->bands[0].name = "";
    out->bands[0].weight = 1;
    int status = CLI_GO;
    for (size_t i = 0; i < count && path != NULL && status == CLI_GO; ++i)
        status = read_band(path, i, json_array_get(root, i), &out->bands[i]);
    return status;
}

void flux_free_bands(flux_bands* bands) {
    for (int32_t i = 0; i < bands->count; ++i) {
        for (int32_t k = 0; k < bands->bands[i].change_count; ++k) free(bands->bands[i].changes[k]);
        ty_flux_destroy(bands->bands[i].flux);
    }
    free(bands->bands);
    json_decref(bands->document);
}
