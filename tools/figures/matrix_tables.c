/* The tables of the matrix as Markdown. */
#include "figures/matrix.h"
#include "cli/text/text_file.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { REASONS_MAX = 256 };

bool matrix_is_outlier(const matrix_cell* cell) {
    if (cell->state == MATRIX_REFUSED) return false;
    return cell->state != MATRIX_RENDERED || !(cell->ratio >= 2.0 / 3 && cell->ratio <= 1.5);
}

/* ---- statistics ---- */

static int compare_doubles(const void* a, const void* b) {
    const double x = *(const double*)a, y = *(const double*)b;
    return (x > y) - (x < y);
}

/* Of one method, over the scenes with a value of a factor; all scenes where factor is MATRIX_FACTORS. */
typedef struct summary {
    int32_t scenes, rendered, refused, failed;
    int32_t within[2];           /* mean ratio within 3 % and relative RMSE of .06; within 10 % and .15 */
    double rmse, worst, seconds; /* rmse and seconds: medians */
} summary;

static bool has_value(const matrix_row* row, int32_t factor, int32_t value) {
    return factor == MATRIX_FACTORS || row->scene.values[factor] == value;
}

static bool is_within(const matrix_cell* cell, double ratio, double rmse) {
    return fabs(cell->ratio - 1) <= ratio && cell->rmse <= rmse;
}

static double take_median(double* values, int32_t count) {
    if (count == 0) return NAN;
    qsort(values, (size_t)count, sizeof *values, compare_doubles);
    return 0.5 * (values[(count - 1) / 2] + values[count / 2]);
}

static summary summarize(const matrix_table* table, int32_t method, int32_t factor, int32_t value) {
    double errors[MATRIX_SCENES], seconds[MATRIX_SCENES];
    summary out = {.scenes = 0};
    for (int32_t i = 0; i < table->row_count; ++i) {
        const matrix_cell* cell = &table->rows[i].cells[method];
        if (!has_value(&table->rows[i], factor, value)) continue;
        ++out.scenes;
        out.refused += cell->state == MATRIX_REFUSED;
        out.failed += cell->state != MATRIX_REFUSED && cell->state != MATRIX_RENDERED;
        if (cell->state != MATRIX_RENDERED) continue;
        errors[out.rendered] = cell->rmse;
        seconds[out.rendered++] = cell->seconds;
        out.worst = fmax(out.worst, cell->rmse);
        out.within[0] += is_within(cell, 0.03, 0.06);
        out.within[1] += is_within(cell, 0.1, 0.15);
    }
    out.rmse = take_median(errors, out.rendered);
    out.seconds = take_median(seconds, out.rendered);
    return out;
}

/* ---- tables ---- */

static void print_methods(FILE* file, const matrix_table* table, const char* first) {
    fprintf(file, "| %s |", first);
    for (int32_t m = 0; m < table->method_count; ++m) fprintf(file, " %s |", table->methods[m]);
    fputs("\n|---|", file);
    for (int32_t m = 0; m < table->method_count; ++m) fputs("---|", file);
    fputc('\n', file);
}

static void print_summaries(FILE* file, const matrix_table* table) {
    fputs("| method | rendered | refused | failed | within 3 % and .06 | within 10 % and .15 | median RMSE | largest | "
          "median time, s |\n|---|---|---|---|---|---|---|---|---|\n",
          file);
    for (int32_t m = 0; m < table->method_count; ++m) {
        const summary all = summarize(table, m, MATRIX_FACTORS, 0);
        fprintf(file, "| `%s` | %d | %d | %d | %d | %d |", table->methods[m], all.rendered, all.refused, all.failed,
                all.within[0], all.within[1]);
        if (all.rendered > 0)
            fprintf(file, " %.3f | %.3g | %.2g |\n", all.rmse, all.worst, all.seconds);
        else
            fputs(" | | |\n", file);
    }
}

static void print_factors(FILE* file, const matrix_table* table) {
    print_methods(file, table, "scenes with");
    for (int32_t f = 0; f < MATRIX_FACTORS; ++f)
        for (int32_t v = 0; v < matrix_factors[f].count; ++v) {
            const int32_t scenes = summarize(table, 0, f, v).scenes;
            if (scenes == 0) continue;
            fprintf(file, "| %s %s (%d) |", matrix_factors[f].name, matrix_factors[f].values[v], scenes);
            for (int32_t m = 0; m < table->method_count; ++m) {
                const summary part = summarize(table, m, f, v);
                if (part.rendered > 0)
                    fprintf(file, " %.3f%s |", part.rmse, part.rendered < scenes ? "*" : "");
                else
                    fputs(" |", file);
            }
            fputc('\n', file);
        }
}

static void print_outliers(FILE* file, const matrix_table* table) {
    int32_t count = 0;
    fputs("| scene | method | mean ratio | relative RMSE, or what it says |\n|---|---|---|---|\n", file);
    for (int32_t m = 0; m < table->method_count; ++m)
        for (int32_t i = 0; i < table->row_count; ++i) {
            const matrix_cell* cell = &table->rows[i].cells[m];
            if (!matrix_is_outlier(cell)) continue;
            ++count;
            if (cell->state == MATRIX_RENDERED)
                fprintf(file, "| %s | `%s` | %.3g | %.3g |\n", table->rows[i].name, table->methods[m], cell->ratio,
                        cell->rmse);
            else
                fprintf(file, "| %s | `%s` | | %s |\n", table->rows[i].name, table->methods[m], cell->words);
        }
    if (count == 0) fputs("| none | | | |\n", file);
}

/* Each reason once, with the number of scenes and the first of them. */
static void print_refusals(FILE* file, const matrix_table* table) {
    const matrix_cell* seen[REASONS_MAX];
    int32_t count = 0;
    fputs("| method | reason | scenes | the first |\n|---|---|---|---|\n", file);
    for (int32_t m = 0; m < table->method_count; ++m)
        for (int32_t i = 0; i < table->row_count; ++i) {
            const matrix_cell* cell = &table->rows[i].cells[m];
            int32_t scenes = 0, before = 0;
            if (cell->state != MATRIX_REFUSED) continue;
            while (before < count && strcmp(seen[before]->words, cell->words) != 0) ++before;
            if (before < count || count == REASONS_MAX) continue;
            seen[count++] = cell;
            for (int32_t k = 0; k < table->row_count; ++k)
                scenes += table->rows[k].cells[m].state == MATRIX_REFUSED &&
                          strcmp(table->rows[k].cells[m].words, cell->words) == 0;
            fprintf(file, "| `%s` | %s | %d | %s |\n", table->methods[m], cell->words, scenes, table->rows[i].name);
        }
    if (count == 0) fputs("| none | | | |\n", file);
}

/* ---- bakes and views ---- */

/* The i-th of the columns: bakes, then the view. */
static const matrix_cell* use_at(const matrix_row* row, int32_t i) {
    return i < MATRIX_BAKES ? &row->bakes[i] : &row->view;
}

static void print_use(FILE* file, const matrix_table* table, int32_t use, const char* name) {
    double errors[MATRIX_SCENES];
    double worst = 0;
    int32_t made = 0, left_out = 0, failed = 0, within[2] = {0, 0};
    for (int32_t i = 0; i < table->row_count; ++i) {
        const matrix_cell* cell = use_at(&table->rows[i], use);
        left_out += cell->state == MATRIX_LEFT_OUT;
        failed += cell->state != MATRIX_LEFT_OUT && cell->state != MATRIX_RENDERED;
        if (cell->state != MATRIX_RENDERED) continue;
        errors[made++] = cell->rmse;
        worst = fmax(worst, cell->rmse);
        within[0] += is_within(cell, 0.03, 0.06);
        within[1] += is_within(cell, 0.1, 0.15);
    }
    fprintf(file, "| %s | %d | %d | %d | %d | %d | %.3f | %.3g |\n", name, made, left_out, failed, within[0], within[1],
            take_median(errors, made), worst);
}

static void print_uses(FILE* file, const matrix_table* table) {
    fputs("| | compared | left out | failed | within 3 % and .06 | within 10 % and .15 | median RMSE | largest |\n"
          "|---|---|---|---|---|---|---|---|\n",
          file);
    for (int32_t i = 0; i < MATRIX_BAKES; ++i) {
        char name[40];
        snprintf(name, sizeof name, "bake by `%s`", matrix_bakes[i]);
        print_use(file, table, i, name);
    }
    print_use(file, table, MATRIX_BAKES, "view");
    fputs("\n| scene (noise of irradiance by path, %) |", file);
    for (int32_t i = 0; i < MATRIX_BAKES; ++i) fprintf(file, " bake by `%s` |", matrix_bakes[i]);
    fputs(" view |\n|---|", file);
    for (int32_t i = 0; i <= MATRIX_BAKES; ++i) fputs("---|", file);
    fputc('\n', file);
    for (int32_t i = 0; i < table->row_count; ++i) {
        const matrix_row* row = &table->rows[i];
        fprintf(file, "| %s (%.1f) |", row->name, 100 * row->bake_noise);
        for (int32_t k = 0; k <= MATRIX_BAKES; ++k) {
            const matrix_cell* cell = use_at(row, k);
            const char* method = k == MATRIX_BAKES && row->view_method != NULL ? row->view_method : "";
            const char* gap = method[0] != '\0' ? ": " : "";
            if (cell->state == MATRIX_RENDERED)
                fprintf(file, " %s%s%.3f / %.3f |", method, gap, cell->ratio, cell->rmse);
            else
                fprintf(file, " %s%s%s |", method, gap, cell->words);
        }
        fputc('\n', file);
    }
}

static void print_all(FILE* file, const matrix_table* table) {
    static const char* const states[] = {"", "refuses", "fails", "crashes", "too long"};
    print_methods(file, table, "scene (noise of the reference, %)");
    for (int32_t i = 0; i < table->row_count; ++i) {
        const matrix_row* row = &table->rows[i];
        fprintf(file, "| %s (%.1f) |", row->name, 100 * row->noise);
        for (int32_t m = 0; m < table->method_count; ++m) {
            const matrix_cell* cell = &row->cells[m];
            if (cell->state == MATRIX_RENDERED)
                fprintf(file, " %.2f / %.3f / %.2g |", cell->ratio, cell->rmse, cell->seconds);
            else
                fprintf(file, " %s |", states[cell->state]);
        }
        fputc('\n', file);
    }
}

static ty_result print_tables(ty_context* context, FILE* file, const void* user) {
    const matrix_table* table = user;
    (void)context;
    fputs("### Methods\n\n", file);
    print_summaries(file, table);
    fputs("\n### By kind of scene\n\nMedian of the relative RMSE. *: the method refuses some of these scenes.\n\n",
          file);
    print_factors(file, table);
    fputs("\n### Refusals\n\n", file);
    print_refusals(file, table);
    fputs("\n### Outliers\n\nMean ratios below 2/3 or above 3/2, and failures.\n\n", file);
    print_outliers(file, table);
    fputs("\n### Baking and viewing\n\nMean ratio / relative RMSE.\n\n", file);
    print_uses(file, table);
    fputs("\n### All scenes\n\nMean ratio / relative RMSE / processor time in s.\n\n", file);
    print_all(file, table);
    return TY_OK;
}

ty_result matrix_write_tables(ty_context* context, const matrix_table* table, const char* path) {
    return cli_write_text_file(context, path, print_tables, table);
}
