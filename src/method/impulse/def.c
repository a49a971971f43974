/* Options, creation and destruction of tables. */
#include "method/impulse/tables.h"
#include "option/option.h"

#include <math.h>

static const ty_option options[] = {
    {TY_OPTION_FIELD(ty_impulse_def, bounces), .type = TY_OPTION_INT, .min = 1, .max = TY_IMPULSE_BOUNCES_MAX,
     .preset = 10, .doc = "Scatterings at most."},
    {TY_OPTION_FIELD(ty_impulse_def, range), .type = TY_OPTION_DOUBLE, .min = 1, .max = 100, .preset = 20,
     .doc = "Optical distance that the tables go to."},
};

static const ty_option_table table = TY_OPTION_TABLE("impulse", ty_impulse_def, "ty_default_impulse_def", options);

void ty_init_impulse_def(void* def, size_t bytes) {
    ty_options_init(&table, def, bytes);
}

ty_result ty_impulse_allocate(ty_context* context, const ty_impulse_def* def, ty_impulse** out) {
    ty_impulse* tables = ty_alloc_array(context, 1, sizeof *tables, true);
    if (tables == NULL) return TY_ERROR_MEMORY;
    tables->context = context;
    tables->bounces = def->bounces;
    tables->range = def->range;
    tables->density = 1;
    tables->density = (TY_IMPULSE_DISTANCES - 1) / ty_impulse_bin_position(tables, def->range);
    tables->row = (TY_IMPULSE_PHASES + def->bounces - 1) * TY_IMPULSE_VECTOR;
    tables->count = (size_t)TY_IMPULSE_ROWS * (size_t)tables->row;
    tables->values = ty_alloc_array(context, tables->count, sizeof *tables->values, true);
    *out = tables;
    if (tables->values != NULL) return TY_OK;
    ty_impulse_destroy(tables);
    return TY_ERROR_MEMORY;
}

void ty_impulse_destroy(ty_impulse* tables) {
    if (tables == NULL) return;
    ty_free_array(tables->context, tables->values, tables->count, sizeof *tables->values);
    ty_free_array(tables->context, tables, 1, sizeof *tables);
}

ty_result ty_impulse_create(ty_context* context, const ty_impulse_def* def, ty_impulse** out, ty_impulse_stats* stats) {
    ty_impulse_def known;
    ty_impulse_stats made;
    ty_result result = ty_take_stats(context, stats, "ty_default_impulse_stats", &made, sizeof made);
    if (result == TY_OK) result = ty_options_take(context, &table, def, &known);
    if (result == TY_OK && out == NULL) result = ty_fail(context, TY_ERROR_ARGUMENT, "ty_impulse_create: out is NULL");
    if (result != TY_OK) return result;
    def = &known;
    const double start = ty_wall_seconds();
    ty_impulse* tables = NULL;
    ty_impulse_path(def, made.path);
    result = ty_impulse_allocate(context, def, &tables);
    if (result != TY_OK) return result;
    made.built = made.path[0] == '\0' || !ty_impulse_load(tables, made.path);
    if (made.built) result = ty_impulse_build(tables, def);
    if (result != TY_OK) {
        ty_impulse_destroy(tables);
        return result;
    }
    if (made.built && made.path[0] != '\0' && !ty_impulse_save(tables, made.path)) made.path[0] = '\0';
    made.seconds = ty_wall_seconds() - start;
    ty_give_stats(&made, sizeof made, stats);
    *out = tables;
    return TY_OK;
}
