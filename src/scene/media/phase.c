/* Phase functions: checks, copies, and views for kernels. */
#include "scene/media/phase.h"

#include "base/context.h"
#include "base/legendre.k.h"
#include "base/quadrature.h"
#include "base/check.h"
#include "scene/media/phase_fit.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* ---- checks ---- */

static ty_result check_table(ty_context* context, const char* name, const ty_phase_lobe* lobe) {
    if (lobe->cosines == NULL || lobe->values == NULL || lobe->count < 2 || lobe->count > TY_PHASE_NODES_MAX)
        return ty_fail(context, TY_ERROR_ARGUMENT, "%s: %d nodes are not 2..%d", name, (int)lobe->count,
                       (int)TY_PHASE_NODES_MAX);
    const double first = lobe->cosines[0], last = lobe->cosines[lobe->count - 1];
    if (!((first == -1 && last == 1) || (first == 1 && last == -1)))
        return ty_fail(context, TY_ERROR_ARGUMENT, "%s: the nodes do not reach from 0 to 180 degrees", name);
    bool any = false;
    for (int32_t i = 0; i < lobe->count; ++i) {
        if (i > 0 && !((lobe->cosines[i] - lobe->cosines[i - 1]) * last > 0))
            return ty_fail(context, TY_ERROR_ARGUMENT, "%s: node %d is not beyond the one before", name, (int)i);
        if (!(lobe->values[i] >= 0 && lobe->values[i] <= TY_COLOR_MAX))
            return ty_fail(context, TY_ERROR_ARGUMENT, "%s: the value %g of node %d is outside [0, %g]", name,
                           lobe->values[i], (int)i, TY_COLOR_MAX);
        any = any || lobe->values[i] > 1 / TY_COLOR_MAX;
    }
    return any ? TY_OK : ty_fail(context, TY_ERROR_ARGUMENT, "%s: all values are 0", name);
}

static ty_result check_lobe(ty_context* context, const char* name, const ty_phase_lobe* lobe) {
    switch (lobe->kind) {
    case TY_PHASE_DRAINE: {
        if (!(lobe->g > -1 && lobe->g < 1))
            return ty_fail(context, TY_ERROR_ARGUMENT, "%s: g: %g is outside (-1, 1)", name, lobe->g);
        return ty_check_number(context, name, lobe->alpha, 0, TY_PHASE_ALPHA_MAX);
    }
    case TY_PHASE_MIE:
        return ty_check_number(context, name, lobe->diameter, TY_PHASE_DIAMETER_MIN, TY_PHASE_DIAMETER_MAX);
    case TY_PHASE_FOURNIER_FORAND: {
        if (lobe->n == 0)
            return ty_check_number(context, name, lobe->backscatter, TY_PHASE_BACKSCATTER_MIN,
                                   TY_PHASE_BACKSCATTER_MAX);
        const ty_result result = ty_check_number(context, name, lobe->n, TY_PHASE_INDEX_MIN, TY_PHASE_INDEX_MAX);
        if (result != TY_OK) return result;
        return ty_check_number(context, name, lobe->mu, TY_PHASE_SLOPE_MIN, TY_PHASE_SLOPE_MAX);
    }
    case TY_PHASE_TABLE: return check_table(context, name, lobe);
    }
    return ty_fail(context, TY_ERROR_ARGUMENT, "%s: %d is not a ty_phase_kind", name, (int)lobe->kind);
}

ty_result ty_phase_check(ty_context* context, const char* name, const ty_phase_lobe* lobes, int32_t count) {
    if (lobes == NULL || count < 1 || count > TY_PHASE_LOBES_MAX)
        return ty_fail(context, TY_ERROR_ARGUMENT, "%s: %d lobes are not 1..%d", name, (int)count,
                       (int)TY_PHASE_LOBES_MAX);
    double sums[3] = {0, 0, 0};
    for (int32_t i = 0; i < count; ++i) {
        char lobe[64];
        snprintf(lobe, sizeof lobe, count > 1 ? "%.40s[%d]" : "%.40s", name, (int)i);
        ty_result result = check_lobe(context, lobe, &lobes[i]);
        for (int c = 0; c < 3 && result == TY_OK; ++c) {
            result = ty_check_number(context, lobe, (double)lobes[i].weight[c], 0, TY_COLOR_MAX);
            sums[c] += (double)lobes[i].weight[c];
        }
        if (result != TY_OK) return result;
    }
    if (!(sums[0] > 0 && sums[1] > 0 && sums[2] > 0))
        return ty_fail(context, TY_ERROR_ARGUMENT, "%s: the weights add up to 0", name);
    return TY_OK;
}

/* ---- copies ---- */

static double* copy_numbers(ty_context* context, const double* from, int32_t count) {
    double* to = ty_alloc_array(context, (size_t)count, sizeof *to, false);
    if (to != NULL) memcpy(to, from, (size_t)count * sizeof *to);
    return to;
}

void ty_phase_free_tables(ty_context* context, const ty_phase_lobe* lobes, int32_t count) {
    for (int32_t i = 0; i < count; ++i) {
        if (lobes[i].kind != TY_PHASE_TABLE) continue;
        ty_free_array(context, (void*)lobes[i].cosines, (size_t)lobes[i].count, sizeof(double));
        ty_free_array(context, (void*)lobes[i].values, (size_t)lobes[i].count, sizeof(double));
    }
}

bool ty_phase_copy_tables(ty_context* context, const ty_phase_lobe* lobes, int32_t count, ty_phase_lobe* copy) {
    for (int32_t i = 0; i < count; ++i) {
        if (lobes[i].kind != TY_PHASE_TABLE) continue;
        copy[i].cosines = copy_numbers(context, lobes[i].cosines, lobes[i].count);
        copy[i].values = copy_numbers(context, lobes[i].values, lobes[i].count);
        if (copy[i].cosines != NULL && copy[i].values != NULL) continue;
        ty_phase_free_tables(context, copy, i + 1);
        return false;
    }
    return true;
}

/* ---- tables ---- */

/* Nodes of the table of a phase function that is not bounded in the forward direction, evenly spaced in the logarithm
 * of 1 - mu from NARROW on. Below, within 0.06 degrees, single precision knows no cosines. */
enum { FORMULA_NODES = 512 };
static const double narrow = 5e-7;

/* Twice pi times the integral of the table from each node to the next. */
static double panel(const ty_phase_node* nodes, const double* one_minus_mu, int32_t i) {
    return TY_PI_F64 * (one_minus_mu[i + 1] - one_minus_mu[i]) * ((double)nodes[i].value + (double)nodes[i + 1].value);
}

/* Tilts in double precision, nodes in the single precision of kernels, whose integral becomes 1. */
static void normalize_nodes(ty_phase_node* nodes, const double* one_minus_mu, int32_t count) {
    double sum = 0, cdf = 0;
    for (int32_t i = 0; i + 1 < count; ++i) sum += panel(nodes, one_minus_mu, i);
    for (int32_t i = 0; i < count; ++i) {
        nodes[i].one_minus_mu = (float)one_minus_mu[i];
        nodes[i].value = (float)((double)nodes[i].value / sum);
    }
    for (int32_t i = 0; i < count; ++i) {
        nodes[i].cdf = (float)cdf;
        if (i + 1 < count) cdf += panel(nodes, one_minus_mu, i);
    }
}

static int32_t node_count(const ty_phase_lobe* lobe) {
    return lobe->kind == TY_PHASE_TABLE ? lobe->count : lobe->kind == TY_PHASE_FOURNIER_FORAND ? FORMULA_NODES : 0;
}

/* The nodes of a given table, forward first. Values are scaled to those of a float; cosines that a float does not tell
 * apart keep their order. */
static void fill_from_table(const ty_phase_lobe* lobe, ty_phase_node* nodes, double* one_minus_mu) {
    double largest = 0;
    for (int32_t i = 0; i < lobe->count; ++i) largest = fmax(largest, lobe->values[i]);
    const bool ascending = lobe->cosines[0] < 0;
    for (int32_t i = 0; i < lobe->count; ++i) {
        const int32_t from = ascending ? lobe->count - 1 - i : i;
        one_minus_mu[i] = 1 - lobe->cosines[from];
        nodes[i].value = (float)(lobe->values[from] / largest);
    }
}

static void fill_from_formula(const ty_phase_lobe* lobe, ty_phase_node* nodes, double* one_minus_mu) {
    const bool given = lobe->n > 0;
    const double slope = given ? lobe->mu : ty_fournier_forand_slope(lobe->backscatter),
                 n = given ? lobe->n : ty_fournier_forand_index(slope);
    double sum = 0;
    one_minus_mu[0] = 0;
    for (int32_t i = 1; i < FORMULA_NODES; ++i) {
        one_minus_mu[i] = i + 1 < FORMULA_NODES ? narrow * pow(2 / narrow, (i - 1) / (FORMULA_NODES - 2.0)) : 2;
        nodes[i].value = (float)fmax(0, ty_fournier_forand(n, slope, one_minus_mu[i]));
        if (i > 1) sum += panel(nodes, one_minus_mu, i - 1);
    }
    /* The function integrates to 1, so that the rest belongs to the first panel. */
    const double mean = fmax(0, 1 - sum) / (2 * TY_PI_F64 * narrow);
    nodes[0].value = (float)fmax((double)nodes[1].value, 2 * mean - (double)nodes[1].value);
}

static void fill_nodes(const ty_phase_lobe* lobe, ty_phase_node* nodes) {
    double one_minus_mu[TY_PHASE_NODES_MAX];
    if (lobe->kind == TY_PHASE_TABLE)
        fill_from_table(lobe, nodes, one_minus_mu);
    else
        fill_from_formula(lobe, nodes, one_minus_mu);
    normalize_nodes(nodes, one_minus_mu, node_count(lobe));
}

/* ---- moments ---- */

typedef struct moment {
    const ty_phase_node* nodes;
    int32_t order;
} moment;

/* The integrand of a Legendre moment between two nodes. */
static double table_moment(const void* user, double one_minus_mu) {
    const moment* m = user;
    const double fraction = (one_minus_mu - (double)m->nodes[0].one_minus_mu) /
                            (double)(m->nodes[1].one_minus_mu - m->nodes[0].one_minus_mu);
    double before = 0, now = 1;
    for (int32_t l = 0; l < m->order; ++l) {
        const double next = ty_legendre_next_f64(l, 1 - one_minus_mu, now, before);
        before = now;
        now = next;
    }
    return 2 * TY_PI_F64 * now * ((1 - fraction) * (double)m->nodes[0].value + fraction * (double)m->nodes[1].value);
}

/* The Draine lobe's moment from those of Henyey-Greenstein, g^l, by mu P_l = (l + 1) / (2 l + 1) P_l+1 + l / (2 l + 1)
 * P_l-1 twice; l = 1 is the mean cosine of Draine (2003). */
static double draine_moment(double g, double alpha, int32_t l) {
    const double up = (l + 1.0) / (2 * l + 1), down = l / (2 * l + 1.0);
    const double up_again = (l + 2.0) / (2 * l + 3), back = (l + 1.0) / (2 * l + 3);
    double squares = up * up_again * pow(g, l + 2) + up * back * pow(g, l);
    if (l > 0) squares += down * (l / (2.0 * l - 1)) * pow(g, l);
    if (l > 1) squares += down * ((l - 1) / (2.0 * l - 1)) * pow(g, l - 2);
    return (pow(g, l) + alpha * squares) * 3 / (3 + alpha * (1 + 2 * g * g));
}

static double term_moment(const ty_phase_term* term, int32_t l) {
    if (term->node_count == 0) return draine_moment((double)term->g, (double)term->alpha, l);
    double sum = 0;
    for (int32_t i = 0; i + 1 < term->node_count; ++i) {
        const moment m = {&term->nodes[i], l};
        if (!(m.nodes[1].one_minus_mu > m.nodes[0].one_minus_mu))
            continue; /* cosines that a float does not tell apart */
        sum += ty_integrate(table_moment, &m, (double)m.nodes[0].one_minus_mu, (double)m.nodes[1].one_minus_mu, 1);
    }
    return sum;
}

static void find_moments(ty_phase_view* view) {
    for (int32_t l = 0; l < TY_PHASE_MOMENTS; ++l) {
        double sums[3] = {0, 0, 0};
        for (int32_t i = 0; i < view->count; ++i) {
            const double value = term_moment(&view->terms[i], l);
            for (int c = 0; c < 3; ++c) sums[c] += (double)view->terms[i].weight[c] * value;
        }
        for (int c = 0; c < 3; ++c) view->moments[c][l] = (float)sums[c];
    }
}

/* ---- views ---- */

static ty_phase_term* add_draine(ty_phase_view* view, double fraction, double g, double alpha) {
    ty_phase_term* term = &view->terms[view->count++];
    for (int c = 0; c < 3; ++c) term->weight[c] = (float)fraction;
    term->g = (float)g;
    term->alpha = (float)alpha;
    term->scale = (float)(3 / (3 + alpha * (1 + 2 * g * g)));
    return term;
}

static void add_lobe(ty_phase_view* view, const ty_phase_lobe* lobe, const double sums[3], const ty_phase_node* nodes) {
    const int32_t first = view->count;
    if (lobe->kind == TY_PHASE_DRAINE) {
        add_draine(view, 1, lobe->g, lobe->alpha);
    } else if (lobe->kind == TY_PHASE_MIE) {
        const ty_mie_fit fit = ty_mie_fit_of(lobe->diameter);
        add_draine(view, 1 - fit.draine_weight, fit.g, 0);
        add_draine(view, fit.draine_weight, fit.draine_g, fit.alpha);
    } else {
        ty_phase_term* term = add_draine(view, 1, 0, 0);
        term->node_count = node_count(lobe);
        term->nodes = nodes;
    }
    for (int32_t i = first; i < view->count; ++i)
        for (int c = 0; c < 3; ++c)
            view->terms[i].weight[c] = (float)((double)view->terms[i].weight[c] * (double)lobe->weight[c] / sums[c]);
}

ty_result ty_phase_view_create(ty_context* context, const ty_phase_lobe* lobes, int32_t count, ty_phase_view** out) {
    double sums[3] = {0, 0, 0};
    ty_phase_view* view = ty_alloc_array(context, 1, sizeof *view, true);
    if (view == NULL) return TY_ERROR_MEMORY;
    for (int32_t i = 0; i < count; ++i)
        for (int c = 0; c < 3; ++c) sums[c] += (double)lobes[i].weight[c];
    for (int32_t i = 0; i < count; ++i) {
        const int32_t nodes = node_count(&lobes[i]);
        ty_phase_node* table = nodes > 0 ? ty_alloc_array(context, (size_t)nodes, sizeof *table, true) : NULL;
        if (nodes > 0 && table == NULL) {
            ty_phase_view_destroy(context, view);
            return TY_ERROR_MEMORY;
        }
        if (nodes > 0) fill_nodes(&lobes[i], table);
        add_lobe(view, &lobes[i], sums, table);
    }
    view->gray = 1;
    for (int32_t i = 0; i < view->count; ++i)
        for (int c = 1; c < 3; ++c) view->gray &= view->terms[i].weight[c] == view->terms[i].weight[0];
    find_moments(view);
    *out = view;
    return TY_OK;
}

void ty_phase_view_destroy(ty_context* context, const ty_phase_view* view) {
    if (view == NULL) return;
    for (int32_t i = 0; i < view->count; ++i)
        if (view->terms[i].nodes != NULL)
            ty_free_array(context, (void*)view->terms[i].nodes, (size_t)view->terms[i].node_count,
                          sizeof(ty_phase_node));
    ty_free_array(context, (void*)view, 1, sizeof *view);
}

/* ---- public ---- */

static ty_result view_given(ty_context* context, const ty_phase_lobe* lobes, int32_t count, bool complete,
                            ty_phase_view** view) {
    if (!complete) return ty_fail(context, TY_ERROR_ARGUMENT, "phase: an array is NULL or a number is out of range");
    const ty_result result = ty_phase_check(context, "phase", lobes, count);
    return result == TY_OK ? ty_phase_view_create(context, lobes, count, view) : result;
}

ty_result ty_phase_values(ty_context* context, const ty_phase_lobe* lobes, int32_t count, int32_t cosine_count,
                          const double* cosines, float* values) {
    ty_phase_view* view = NULL;
    bool complete = cosine_count >= 0 && cosines != NULL && values != NULL;
    for (int32_t i = 0; complete && i < cosine_count; ++i) complete = cosines[i] >= -1 && cosines[i] <= 1;
    const ty_result result = view_given(context, lobes, count, complete, &view);
    if (result != TY_OK) return result;
    for (int32_t i = 0; i < cosine_count; ++i) ty_phase_evaluate(view, (float)cosines[i], values + 3 * i);
    ty_phase_view_destroy(context, view);
    return TY_OK;
}

ty_result ty_phase_moments(ty_context* context, const ty_phase_lobe* lobes, int32_t count, int32_t order,
                           double* moments) {
    ty_phase_view* view = NULL;
    const bool complete = order >= 0 && order <= TY_PHASE_ORDER_MAX && moments != NULL;
    const ty_result result = view_given(context, lobes, count, complete, &view);
    if (result != TY_OK) return result;
    for (int c = 0; c < 3; ++c)
        for (int32_t l = 0; l <= order; ++l) moments[c * (order + 1) + l] = (double)view->moments[c][l];
    ty_phase_view_destroy(context, view);
    return TY_OK;
}
