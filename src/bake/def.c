/* Options and their checks. */
#include "bake/gather.h"

#include "base/context.h"
#include "scene/check.h"

ty_bake_def ty_default_bake_def(void) {
    return (ty_bake_def){.cookie = TY_DEF_COOKIE, .spp = 64, .scatterings = 10, .back_scattering = true};
}

ty_result ty_bake_check(ty_context* context, const ty_bake_def* def) {
    ty_result result = ty_check_def(context, def, "ty_default_bake_def");
    if (result == TY_OK) result = ty_check_number(context, "bake.method", (double)def->method, 0, TY_BAKE_PATH);
    if (result == TY_OK) result = ty_check_number(context, "bake.spp", def->spp, 1, 1 << 20);
    if (result == TY_OK) result = ty_check_number(context, "bake.error", def->error, 0, 1e9);
    if (result == TY_OK) result = ty_check_number(context, "bake.bounces", def->bounces, 0, INT32_MAX);
    if (result == TY_OK)
        result = ty_check_number(context, "bake.scatterings", def->scatterings, 1, TY_IMPULSE_BOUNCES_MAX);
    if (result == TY_OK) result = ty_check_number(context, "bake.cells", def->cells, 0, TY_CACHE_CELLS_MAX);
    if (result == TY_OK) result = ty_check_number(context, "bake.cell_paths", def->cell_paths, 0, 1 << 20);
    return result;
}
