/* tyndall flux: its files, and the means that it prints. */
#include "cli/flux/flux.h"
#include "cli/text/text_file.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const struct {
    ty_flux_quantity quantity;
    const char* name;
} level_quantities[] = {
    {TY_FLUX_UP, "up"}, {TY_FLUX_DOWN_DIFFUSE, "down_diffuse"}, {TY_FLUX_DOWN_DIRECT, "down_direct"}};

enum { LEVEL_QUANTITIES = sizeof level_quantities / sizeof level_quantities[0] };

/* The numbers of a quantity: of one band, or summed over all bands. */
typedef struct numbers {
    const flux_band* bands;
    int32_t count;
    ty_flux_quantity quantity;
    int32_t index;
} numbers;

static numbers numbers_of(const flux_result* result, int32_t band, ty_flux_quantity quantity, int32_t index) {
    const bool sum = band == result->bands->count;
    return (numbers){sum ? result->bands->bands : &result->bands->bands[band], sum ? result->bands->count : 1, quantity,
                     index};
}

static double weight_of(const numbers* n, int32_t band) {
    return n->count > 1 ? n->bands[band].weight : 1;
}

/* Value i, a channel of a column. Bands have common random numbers, so that errors of a sum may add. */
static double value_at(const numbers* n, int64_t i, double* error) {
    double sum = 0;
    *error = 0;
    for (int32_t b = 0; b < n->count; ++b) {
        sum += weight_of(n, b) * ty_flux_values(n->bands[b].flux, n->quantity, n->index)[i];
        *error += fabs(weight_of(n, b)) * ty_flux_errors(n->bands[b].flux, n->quantity, n->index)[i];
    }
    return sum;
}

static void mean_of(const numbers* n, double mean[3], double error[3]) {
    for (int c = 0; c < 3; ++c) mean[c] = error[c] = 0;
    for (int32_t b = 0; b < n->count; ++b) {
        double own[3], own_error[3];
        ty_flux_mean(n->bands[b].flux, n->quantity, n->index, own, own_error);
        for (int c = 0; c < 3; ++c) {
            mean[c] += weight_of(n, b) * own[c];
            error[c] += fabs(weight_of(n, b)) * own_error[c];
        }
    }
}

static ty_flux_def places_of(const flux_result* result) {
    return ty_flux_places(result->bands->bands[0].flux);
}

/* Bands, and behind several of them their sum. */
static int32_t tables_of(const flux_result* result) {
    return result->bands->count > 1 ? result->bands->count + 1 : 1;
}

static const char* table_name(const flux_result* result, int32_t table) {
    return table == result->bands->count ? "sum" : result->bands->bands[table].name;
}

/* ---- JSON ---- */

static void write_numbers(json_writer* json, const char* name, const flux_result* result, numbers n, bool columns) {
    const ty_flux_def places = places_of(result);
    const int64_t count = (int64_t)places.columns[0] * places.columns[1];
    double mean[3], error[3];
    mean_of(&n, mean, error);
    json_open_object(json, name);
    json_numbers(json, "mean", mean, 3);
    json_numbers(json, "error", error, 3);
    for (int part = 0; part < 2 && columns; ++part) {
        json_open_array(json, part == 0 ? "columns" : "column_errors");
        for (int64_t i = 0; i < count; ++i) {
            double rgb[3], errors[3];
            for (int c = 0; c < 3; ++c) rgb[c] = value_at(&n, 3 * i + c, &errors[c]);
            json_numbers(json, NULL, part == 0 ? rgb : errors, 3);
        }
        json_close_array(json);
    }
    json_close_object(json);
}

static void write_table(json_writer* json, const flux_result* result, int32_t table, bool columns) {
    const ty_flux_def places = places_of(result);
    json_open_array(json, "levels");
    for (int32_t i = 0; i < places.level_count; ++i) {
        json_open_object(json, NULL);
        json_number(json, "height", places.levels[i]);
        for (int q = 0; q < LEVEL_QUANTITIES; ++q)
            write_numbers(json, level_quantities[q].name, result,
                          numbers_of(result, table, level_quantities[q].quantity, i), columns);
        json_close_object(json);
    }
    json_close_array(json);
    write_numbers(json, "absorbed", result, numbers_of(result, table, TY_FLUX_ABSORBED, 0), columns);
    if (places.view_count == 0) return;
    json_open_array(json, "views");
    for (int32_t i = 0; i < places.view_count; ++i) {
        json_open_object(json, NULL);
        json_number(json, "zenith", places.views[i].zenith);
        json_number(json, "azimuth", places.views[i].azimuth);
        write_numbers(json, "radiance", result, numbers_of(result, table, TY_FLUX_RADIANCE, i), columns);
        json_close_object(json);
    }
    json_close_array(json);
}

static void write_tables(json_writer* json, const flux_result* result, bool columns) {
    if (tables_of(result) == 1) {
        write_table(json, result, 0, columns);
        return;
    }
    json_open_array(json, "bands");
    for (int32_t t = 0; t < tables_of(result); ++t) {
        json_open_object(json, NULL);
        json_text(json, "name", table_name(result, t));
        if (t < result->bands->count) json_number(json, "weight", result->bands->bands[t].weight);
        write_table(json, result, t, columns);
        json_close_object(json);
    }
    json_close_array(json);
}

/* Bands may have several numbers of samples where time ends them. */
static double min_spp(const flux_result* result) {
    double spp = result->bands->bands[0].spp;
    for (int32_t b = 1; b < result->bands->count; ++b) spp = fmin(spp, result->bands->bands[b].spp);
    return spp;
}

static ty_result print_json(ty_context* context, FILE* file, const void* user) {
    (void)context;
    const flux_result* result = user;
    const ty_flux_def places = places_of(result);
    json_writer json = json_begin(file);
    json_open_object(&json, NULL);
    json_text(&json, "scene", result->scene);
    json_text(&json, "method", "path");
    json_number(&json, "spp", min_spp(result));
    json_unsigned(&json, "seed", result->seed);
    json_text(&json, "axes", result->z_up ? "xy" : "xz");
    json_numbers(&json, "columns", (const double[]){places.columns[0], places.columns[1]}, 2);
    json_numbers(&json, "lower", places.lower, 2);
    json_numbers(&json, "upper", places.upper, 2);
    write_tables(&json, result, true);
    json_close_object(&json);
    return TY_OK;
}

/* ---- CSV ---- */

/* Text of a field, in quotes where it holds what separates fields (RFC 4180). */
static void print_text(FILE* file, const char* text) {
    const bool quoted = strpbrk(text, ",\"\r\n") != NULL;
    if (quoted) fputc('"', file);
    for (; *text != '\0'; ++text) {
        if (*text == '"') fputc('"', file);
        fputc(*text, file);
    }
    if (quoted) fputc('"', file);
}

static void print_rows(FILE* file, const flux_result* result, int32_t table, const char* name, const char* place,
                       numbers n) {
    const ty_flux_def places = places_of(result);
    for (int64_t i = 0; i < (int64_t)places.columns[0] * places.columns[1]; ++i) {
        const int32_t at[2] = {(int32_t)(i % places.columns[0]), (int32_t)(i / places.columns[0])};
        print_text(file, table_name(result, table));
        fprintf(file, ",%s,%s", name, place);
        for (int a = 0; a < 2; ++a)
            fprintf(file, ",%.9g",
                    places.lower[a] + (at[a] + 0.5) * (places.upper[a] - places.lower[a]) / places.columns[a]);
        double errors[3];
        for (int c = 0; c < 3; ++c) fprintf(file, ",%.9g", value_at(&n, 3 * i + c, &errors[c]));
        for (int c = 0; c < 3; ++c) fprintf(file, ",%.3g", errors[c]);
        fputc('\n', file);
    }
}

static ty_result print_csv(ty_context* context, FILE* file, const void* user) {
    (void)context;
    const flux_result* result = user;
    const ty_flux_def places = places_of(result);
    char place[64];
    fprintf(file, "band,quantity,height,zenith,azimuth,x,%s,R,G,B,error_R,error_G,error_B\n", result->z_up ? "y" : "z");
    for (int32_t t = 0; t < tables_of(result); ++t) {
        for (int32_t i = 0; i < places.level_count; ++i)
            for (int q = 0; q < LEVEL_QUANTITIES; ++q) {
                snprintf(place, sizeof place, "%.9g,,", places.levels[i]);
                print_rows(file, result, t, level_quantities[q].name, place,
                           numbers_of(result, t, level_quantities[q].quantity, i));
            }
        print_rows(file, result, t, "absorbed", ",,", numbers_of(result, t, TY_FLUX_ABSORBED, 0));
        for (int32_t i = 0; i < places.view_count; ++i) {
            snprintf(place, sizeof place, ",%.9g,%.9g", places.views[i].zenith, places.views[i].azimuth);
            print_rows(file, result, t, "radiance", place, numbers_of(result, t, TY_FLUX_RADIANCE, i));
        }
    }
    return TY_OK;
}

ty_result flux_write(cli_session* session, const char* path, const flux_result* result) {
    return cli_write_text_file(session->context, path, cli_has_extension(path, ".csv") ? print_csv : print_json,
                               result);
}

void flux_print(const flux_result* result) {
    json_writer json = json_begin_plain(stdout);
    json_open_object(&json, NULL);
    write_tables(&json, result, false);
    json_close_object(&json);
}
