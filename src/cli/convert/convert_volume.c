/* tyndall convert: volumes. */
#include "cli/convert/convert.h"
#include "grid/grid.h"

static void release(ty_grid* grids[3]) {
    for (int c = 0; c < 3; ++c) ty_grid_release(grids[c]);
}

/* The same grid of half floats. */
static ty_result make_half(ty_context* context, ty_grid** grid) {
    if (ty_grid_get_info(*grid).type == TY_GRID_F16) return TY_OK;
    ty_grid* made = NULL;
    const ty_result result = ty_grid_make_half(context, *grid, &made);
    if (result != TY_OK) return result;
    ty_grid_release(*grid);
    *grid = made;
    return TY_OK;
}

static int check_options(const convert_volume_options* options, const char* output) {
    const bool vdb = cli_has_extension(output, ".vdb");
    if (options->half && !vdb) return cli_usage_error("convert", "--half is for .vdb, and %s is none", output);
    const bool nifti = cli_has_extension(output, ".nii") || cli_has_extension(output, ".nii.gz");
    if (options->vector && !vdb && !nifti && !cli_has_extension(output, ".vti"))
        return cli_usage_error("convert", "--vector is for .vdb, .vti and .nii, and %s is none of these", output);
    return CLI_GO;
}

/* Reads one component, or all three. */
static int read_grids(cli_session* session, const convert_volume_options* options, const char* input,
                      ty_grid* grids[3]) {
    ty_volume_def def = options->def;
    int32_t components = 1;
    ty_result result = TY_OK;
    if (options->vector) result = ty_volume_components(session->context, input, &def, &components);
    if (result != TY_OK) return cli_fail_reading(session, result);
    if (options->vector && components != 3)
        return cli_usage_error("convert", "--vector: %s has %d values per voxel, not 3", input, components);
    for (int32_t c = 0; c < components && result == TY_OK; ++c) {
        if (options->vector) def.component = c;
        result = ty_volume_read(session->context, input, &def, &grids[c]);
    }
    return result == TY_OK ? CLI_GO : cli_fail_reading(session, result);
}

int cli_convert_volume(cli_session* session, convert_volume_options* options, const char* input, const char* output) {
    ty_grid* grids[3] = {NULL, NULL, NULL};
    int status = check_options(options, output);
    if (options->grid != NULL) {
        options->def.grid = options->grid;
        options->def.exact_grid = true;
    }
    if (cli_has_extension(output, ".bricks")) options->def.storage = TY_GRID_PAGED; /* larger than memory, maybe */
    if (status == CLI_GO) status = read_grids(session, options, input, grids);
    if (status != CLI_GO) {
        release(grids);
        return status;
    }
    cli_end_on_interrupt(false);
    ty_result result = TY_OK;
    for (int c = 0; c < 3 && options->half && result == TY_OK; ++c)
        if (grids[c] != NULL) result = make_half(session->context, &grids[c]);
    const ty_volume_field field = {
        .name = options->def.grid, .components = options->vector ? 3 : 1, .grids = {grids[0], grids[1], grids[2]}};
    if (result == TY_OK) result = ty_volume_write(session->context, &field, 1, options->codec, output);
    release(grids);
    if (result == TY_ERROR_INPUT) return cli_fail_reading(session, result); /* a grid that the format cannot hold */
    return result == TY_OK ? CLI_DONE : cli_fail_running(session, result);
}
