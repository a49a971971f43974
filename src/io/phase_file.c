#include "io/phase_file.h"

#include "base/constants.h"
#include "base/context.h"
#include "base/legendre.k.h"
#include "base/number.h"
#include "io/file.h"
#include "scene/media/phase.h"

#include <ctype.h>
#include <math.h>
#include <string.h>

enum { FILE_SIZE_MAX = 1 << 28, ORDER_MAX = 16384, NODES_LEAST = 361, NODES_PER_ORDER = 8, RECORD = 4 };

/* Text of a file, and a position in it. */
typedef struct source {
    ty_context* context;
    const char *path, *at;
    long line;
} source;

double ty_phase_cosine(double degrees) {
    if (degrees <= 0) return 1;
    return degrees >= 180 ? -1 : cos(degrees * (TY_PI_F64 / 180));
}

/* Moves to the next number or word, over comments and ends of lines; false at the end. */
static bool skip_blanks(source* s) {
    for (; *s->at != '\0'; ++s->at) {
        if (*s->at == '#' || *s->at == '!') s->at += strcspn(s->at, "\n");
        if (*s->at == '\0') return false;
        if (*s->at == '\n')
            ++s->line;
        else if (!isspace((unsigned char)*s->at))
            return true;
    }
    return false;
}

static ty_result fail_line(const source* s, const char* what) {
    return ty_fail(s->context, TY_ERROR_INPUT, "%s:%ld: %s", s->path, s->line, what);
}

/* A finite number in the current line. */
static ty_result take_number(source* s, double* out) {
    const char* end;
    s->at += strspn(s->at, " \t\r,");
    *out = *s->at == '\n' ? NAN : ty_parse_number(s->at, &end);
    if (*s->at == '\n' || end == s->at || !(fabs(*out) <= 1e15))
        return fail_line(s, "a number is missing or too large");
    s->at = end;
    return TY_OK;
}

/* ---- nodes ---- */

static ty_result read_nodes(source* s, bool angles, double* cosines, double* values, int32_t* count) {
    for (*count = 0; skip_blanks(s); ++*count) {
        double node = 0, value = 0;
        if (*count == TY_PHASE_NODES_MAX) return fail_line(s, "there are more than 4096 nodes");
        ty_result result = take_number(s, &node);
        if (result == TY_OK) result = take_number(s, &value);
        if (result != TY_OK) return result;
        s->at += strcspn(s->at, "\n"); /* further columns */
        cosines[*count] = angles ? ty_phase_cosine(node) : node;
        values[*count] = value;
    }
    return TY_OK;
}

/* ---- Legendre series ---- */

/* Coefficients (2 l + 1) chi_l. */
typedef struct legendre_series {
    double* coefficients;
    int32_t count;
} legendre_series;

static bool begin_series(ty_context* context, legendre_series* out) {
    *out = (legendre_series){.coefficients = ty_alloc_array(context, ORDER_MAX, sizeof *out->coefficients, true)};
    return out->coefficients != NULL;
}

static void end_series(ty_context* context, legendre_series* series) {
    ty_free_array(context, series->coefficients, ORDER_MAX, sizeof *series->coefficients);
}

static ty_result read_series(source* s, bool moments, legendre_series* out) {
    while (skip_blanks(s)) {
        if (out->count == ORDER_MAX) return fail_line(s, "there are more than 16384 moments");
        double* c = &out->coefficients[out->count];
        const ty_result result = take_number(s, c);
        if (result != TY_OK) return result;
        if (moments) *c *= 2 * out->count + 1;
        ++out->count;
    }
    if (out->count > 0 && fabs(out->coefficients[0] - 1) < 1e-3) return TY_OK;
    return ty_fail(s->context, TY_ERROR_INPUT, "%s: the first moment is not 1", s->path);
}

/* The series at a cosine, times 4 pi. */
static double evaluate(const legendre_series* series, double cosine) {
    double before = 0, now = 1, sum = 0;
    for (int32_t l = 0; l < series->count; ++l) {
        sum += series->coefficients[l] * now;
        const double next = ty_legendre_next_f64(l, cosine, now, before);
        before = now;
        now = next;
    }
    return sum;
}

/* p(mu) = sum of (2 l + 1) chi_l P_l(mu) / (4 pi) at angles that are evenly spaced, several per oscillation of the last
 * term. */
static void tabulate(source* s, const legendre_series* series, double* cosines, double* values, int32_t* count) {
    double lost = 0;
    const int32_t wanted = NODES_PER_ORDER * series->count + 1;
    *count = wanted < NODES_LEAST ? NODES_LEAST : wanted > TY_PHASE_NODES_MAX ? TY_PHASE_NODES_MAX : wanted;
    for (int32_t i = 0; i < *count; ++i) {
        const double degrees = 180.0 * i / (*count - 1);
        cosines[i] = i + 1 < *count ? ty_phase_cosine(degrees) : -1;
        values[i] = evaluate(series, cosines[i]) / (4 * TY_PI_F64);
        if (values[i] >= 0) continue;
        lost -= values[i] * sin(degrees * (TY_PI_F64 / 180)) * 2 * TY_PI_F64 * TY_PI_F64 / (*count - 1);
        values[i] = 0;
    }
    if (lost > 0.01)
        ty_log(s->context, TY_LOG_WARNING,
               "%s: the Legendre series is below 0 at some angles; 0 there adds %.0f %% of the light", s->path,
               100 * lost);
}

/* ---- scattering tables of SHDOM ---- */

/* Reads the line before a series: effective radius, extinction, albedo, order; false at the end. */
static bool find_record(source* s, double record[RECORD], ty_result* result) {
    while (skip_blanks(s)) {
        const char* end = s->at + strcspn(s->at, "\n");
        const char* mark = strstr(s->at, "Nleg");
        if (mark != NULL && mark < end) {
            for (int i = 0; i < RECORD && *result == TY_OK; ++i) *result = take_number(s, &record[i]);
            s->at = end;
            return true;
        }
        s->at = end;
    }
    return false;
}

static ty_result read_record(source* s, const double record[RECORD], legendre_series* out) {
    if (!(record[3] >= 0 && record[3] < ORDER_MAX)) return fail_line(s, "the number of coefficients is out of range");
    out->count = (int32_t)record[3] + 1;
    for (int32_t l = 0; l < out->count; ++l) {
        if (!skip_blanks(s)) return fail_line(s, "the table ends within a phase function");
        const ty_result result = take_number(s, &out->coefficients[l]);
        if (result != TY_OK) return result;
    }
    if (fabs(out->coefficients[0] - 1) < 1e-3) return TY_OK;
    return fail_line(s, "the first coefficient of a phase function is not 1");
}

/* a = (1 - t) a + t b. */
static void mix(legendre_series* a, const legendre_series* b, double t) {
    a->count = a->count > b->count ? a->count : b->count;
    for (int32_t l = 0; l < a->count; ++l)
        a->coefficients[l] = (1 - t) * a->coefficients[l] + (l < b->count ? t * b->coefficients[l] : 0);
}

/* Clears what a longer series had. */
static void copy_series(const legendre_series* from, legendre_series* to) {
    for (int32_t l = 0; l < from->count || l < to->count; ++l)
        to->coefficients[l] = l < from->count ? from->coefficients[l] : 0;
    to->count = from->count;
}

/* Reads through the table, which ascends in radius, to the neighbours of the one that is wanted. */
static ty_result search_table(source* s, double radius, legendre_series* before, legendre_series* here) {
    double record[RECORD], first = 0, last = 0;
    int32_t records = 0;
    ty_result result = TY_OK;
    while (find_record(s, record, &result) && result == TY_OK) {
        result = read_record(s, record, here);
        if (result != TY_OK) return result;
        if (records == 0) first = record[0];
        if (records > 0 && !(record[0] > last)) return fail_line(s, "the effective radii do not ascend");
        if (records > 0 && radius >= last && radius <= record[0]) {
            mix(before, here, (radius - last) / (record[0] - last));
            return TY_OK;
        }
        copy_series(here, before);
        last = record[0];
        ++records;
    }
    if (result != TY_OK) return result;
    if (records == 0)
        return ty_fail(s->context, TY_ERROR_INPUT, "%s: there is no line of \"Reff Ext Alb Nleg\"", s->path);
    if (records == 1 && (radius == 0 || radius == first)) return TY_OK;
    return ty_fail(s->context, TY_ERROR_INPUT, "%s: the table has effective radii from %g to %g, not %g", s->path,
                   first, last, radius);
}

static ty_result read_table(source* s, double radius, legendre_series* out) {
    legendre_series here;
    const char* polarized = strstr(s->at, "Polarized");
    if (polarized != NULL && polarized < s->at + strcspn(s->at, "\n"))
        return ty_fail(s->context, TY_ERROR_INPUT, "%s: tables of polarized light cannot be read", s->path);
    if (!begin_series(s->context, &here)) return TY_ERROR_MEMORY;
    const ty_result result = search_table(s, radius, out, &here);
    end_series(s->context, &here);
    return result;
}

static ty_result read_content(source* s, ty_phase_content content, double radius, double* cosines, double* values,
                              int32_t* count) {
    if (content == TY_PHASE_FILE_ANGLES || content == TY_PHASE_FILE_COSINES)
        return read_nodes(s, content == TY_PHASE_FILE_ANGLES, cosines, values, count);
    legendre_series found;
    if (!begin_series(s->context, &found)) return TY_ERROR_MEMORY;
    const ty_result result = content == TY_PHASE_FILE_SHDOM ? read_table(s, radius, &found)
                                                            : read_series(s, content == TY_PHASE_FILE_MOMENTS, &found);
    if (result == TY_OK) tabulate(s, &found, cosines, values, count);
    end_series(s->context, &found);
    return result;
}

ty_result ty_phase_file_read(ty_context* context, const char* path, ty_phase_content content, double effective_radius,
                             double* cosines, double* values, int32_t* count) {
    uint8_t* bytes = NULL;
    size_t size = 0;
    if (path == NULL || cosines == NULL || values == NULL || count == NULL || !(effective_radius >= 0))
        return ty_fail(context, TY_ERROR_ARGUMENT, "ty_phase_file_read: an argument is NULL, or the radius below 0");
    if (content < TY_PHASE_FILE_ANGLES || content > TY_PHASE_FILE_SHDOM)
        return ty_fail(context, TY_ERROR_ARGUMENT, "ty_phase_file_read: %d is none of ty_phase_content", (int)content);
    ty_result result = ty_read_file(context, path, FILE_SIZE_MAX, &bytes, &size);
    if (result != TY_OK) return result;
    source s = {.context = context, .path = path, .at = (const char*)bytes, .line = 1};
    if (memchr(bytes, 0, size) != NULL)
        result = ty_fail(context, TY_ERROR_INPUT, "%s: a byte is a zero, which no text has", path);
    else
        result = read_content(&s, content, effective_radius, cosines, values, count);
    ty_free_file(context, bytes, size);
    if (result != TY_OK) return result;
    const ty_phase_lobe lobe = {
        .kind = TY_PHASE_TABLE, .weight = {1, 1, 1}, .cosines = cosines, .values = values, .count = *count};
    result = ty_phase_check(context, path, &lobe, 1);
    return result == TY_ERROR_ARGUMENT ? TY_ERROR_INPUT : result;
}
