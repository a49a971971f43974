/* tyndall bake: the list of units and the estimate of memory. */
#include "cli/bake/bake.h"
#include "cli/bake/mesh_scene.h"

#include <ctype.h>
#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

enum { POINTS_MAX = 1 << 28, IMAGE_SIDE_MAX = 65536 };

/* Planes of a lightmap that denoising holds, at most: its own (5 x 6 + 29), 16 features, and the images of light and
 * geometry. */
enum { DENOISING_PLANES = 120 };

/* ---- Names ---- */

const char* bake_mesh_name(const ty_mesh_def* mesh) {
    if (mesh->origin.name != NULL && mesh->origin.name[0] != '\0') return mesh->origin.name;
    if (mesh->origin.file == NULL) return "mesh";
    const char* slash = strrchr(mesh->origin.file, '/');
    return slash == NULL ? mesh->origin.file : slash + 1;
}

/* A file name derived from a mesh's name, in a restricted character set. */
static void clean_name(const char* text, char name[BAKE_NAME_SIZE]) {
    size_t used = 0;
    for (const char* at = text; *at != '\0' && used < BAKE_NAME_SIZE - 16; ++at)
        name[used++] = isalnum((unsigned char)*at) || *at == '-' || *at == '_' ? *at : '_';
    name[used] = '\0';
    if (used == 0) snprintf(name, BAKE_NAME_SIZE, "mesh");
}

/* Names are compared without case, because some file systems ignore it. */
static bool is_taken(const bake_plan* plan, const char* name) {
    if (strcasecmp(name, "grid") == 0 || strcasecmp(name, "probes") == 0) return true;
    for (int32_t i = 0; i < plan->count; ++i)
        if (strcasecmp(plan->units[i].name, name) == 0) return true;
    return false;
}

static void name_unit(const bake_plan* plan, const char* text, char name[BAKE_NAME_SIZE]) {
    char plain[BAKE_NAME_SIZE];
    clean_name(text, plain);
    snprintf(name, BAKE_NAME_SIZE, "%s", plain);
    for (int number = 2; is_taken(plan, name); ++number)
        snprintf(name, BAKE_NAME_SIZE, "%.*s_%d", BAKE_NAME_SIZE - 16, plain, number);
}

void bake_image_path(const bake_run* run, const bake_unit* unit, int32_t primitive, const char* extension,
                     char path[BAKE_PATH_SIZE]) {
    char number[16] = "";
    if (primitive >= 0) snprintf(number, sizeof number, "-%d", (int)primitive);
    snprintf(path, BAKE_PATH_SIZE, "%s/%s%s%s", run->options->folder, unit->name, number, extension);
}

/* ---- Units ---- */

static ty_result add_unit(bake_plan* plan, const bake_unit* unit) {
    if (plan->count == plan->capacity) {
        const int32_t capacity = plan->capacity == 0 ? 64 : 2 * plan->capacity;
        bake_unit* grown = realloc(plan->units, (size_t)capacity * sizeof *grown);
        if (grown == NULL) return TY_ERROR_MEMORY;
        plan->units = grown;
        plan->capacity = capacity;
    }
    plan->units[plan->count++] = *unit;
    plan->receivers += unit->receivers;
    plan->bytes = fmax(plan->bytes, unit->bytes);
    return TY_OK;
}

static bool by_lightmap(const bake_options* options, const ty_mesh_def* mesh) {
    if (options->lightmaps && !options->vertices)
        return true; /* a mesh without texture coordinates fails here with an error */
    if (options->vertices && !options->lightmaps) return false;
    return mesh->uv[1] != NULL;
}

/* All primitives of a node have lightmaps of the same size, that of the largest. */
static ty_result plan_lightmap(bake_run* run, bake_unit* unit) {
    ty_atlas_def def = ty_default_atlas_def();
    def.density = run->options->density;
    def.padding = run->options->padding;
    def.width = run->options->size[0];
    def.height = run->options->size[1];
    ty_result result = TY_OK;
    for (int pass = 0; pass < 2 && result == TY_OK; ++pass) {
        double texels = 0, bytes = 0;
        for (int32_t i = 0; i < unit->count && result == TY_OK; ++i) {
            ty_mesh_def mesh;
            ty_atlas_size size;
            result = ty_scene_get_mesh(run->scene, unit->first + i, &mesh);
            if (result == TY_OK)
                result = ty_atlas_estimate(run->scene, unit->first + i, bake_mesh_name(&mesh), &def, &size);
            if (result != TY_OK) return result;
            unit->size[0] = size.width > unit->size[0] ? size.width : unit->size[0];
            unit->size[1] = size.height > unit->size[1] ? size.height : unit->size[1];
            texels += size.texels;
            bytes = fmax(bytes, size.bytes);
        }
        def.width = unit->size[0];
        def.height = unit->size[1];
        unit->receivers = (int64_t)texels;
        /* The images of finished primitives stay in memory until the last primitive is done. */
        const double plane = (double)sizeof(float) * unit->size[0] * unit->size[1];
        unit->bytes = bytes + (unit->count - 1) * 29 * plane;
        /* Denoised images, light of both halves, and what denoising itself takes. */
        if (run->options->denoise)
            unit->bytes += (unit->count * 29 + DENOISING_PLANES) * plane + 2 * texels * sizeof(ty_bake_light);
    }
    run->plan.texels += (int64_t)unit->size[0] * unit->size[1];
    run->plan.lightmapped += unit->count;
    return result;
}

static ty_result plan_vertices(bake_run* run, bake_unit* unit) {
    for (int32_t i = 0; i < unit->count; ++i) {
        ty_mesh_def mesh;
        const ty_result result = ty_scene_get_mesh(run->scene, unit->first + i, &mesh);
        if (result != TY_OK) return result;
        unit->receivers += mesh.vertex_count;
    }
    const double each = sizeof(ty_bake_receiver) + sizeof(ty_bake_light) + 28.0 * sizeof(float);
    unit->size[0] = (int32_t)fmin((double)unit->receivers, BAKE_ROW);
    unit->size[1] = (int32_t)((unit->receivers + unit->size[0] - 1) / unit->size[0]);
    unit->bytes = each * (double)unit->receivers;
    run->plan.by_vertex += unit->count;
    return TY_OK;
}

static ty_result plan_meshes(bake_run* run) {
    const int32_t meshes = ty_scene_get_info(run->scene).meshes;
    ty_result result = TY_OK;
    for (int32_t first = 0, next; first < meshes && result == TY_OK; first = next) {
        ty_mesh_def mesh, other;
        result = ty_scene_get_mesh(run->scene, first, &mesh);
        if (result != TY_OK) return result;
        const bool lightmap = by_lightmap(run->options, &mesh);
        for (next = first + 1; next < meshes; ++next) {
            result = ty_scene_get_mesh(run->scene, next, &other);
            if (result != TY_OK) return result;
            if (!cli_same_node(&mesh, &other) || by_lightmap(run->options, &other) != lightmap) break;
        }
        bake_unit unit = {.kind = lightmap ? BAKE_LIGHTMAP : BAKE_VERTICES, .first = first, .count = next - first};
        name_unit(&run->plan, bake_mesh_name(&mesh), unit.name);
        result = lightmap ? plan_lightmap(run, &unit) : plan_vertices(run, &unit);
        if (result == TY_OK) result = add_unit(&run->plan, &unit);
    }
    return result;
}

/* ---- Points ---- */

/* The bounds of all meshes, or else of everything with a position. */
static ty_result find_box(const ty_scene* scene, double lower[3], double upper[3]) {
    const ty_scene_info info = ty_scene_get_info(scene);
    for (int a = 0; a < 3; ++a) {
        lower[a] = info.meshes > 0 ? INFINITY : info.lower[a];
        upper[a] = info.meshes > 0 ? -INFINITY : info.upper[a];
    }
    for (int32_t i = 0; i < info.meshes; ++i) {
        ty_mesh_def mesh;
        const ty_result result = ty_scene_get_mesh(scene, i, &mesh);
        if (result != TY_OK) return result;
        for (size_t k = 0; k < 3 * (size_t)mesh.vertex_count; ++k) {
            lower[k % 3] = fmin(lower[k % 3], (double)mesh.positions[k]);
            upper[k % 3] = fmax(upper[k % 3], (double)mesh.positions[k]);
        }
    }
    return TY_OK;
}

/* Probes are at the centers of equal cells of the box; a given spacing sets the number of cells that covers it. */
static int place_grid(const bake_options* options, const double lower[3], const double upper[3], bake_grid* grid) {
    for (int a = 0; a < 3; ++a) {
        const double extent = upper[a] - lower[a];
        double count = options->grid[a];
        if (options->grid_spacing > 0) count = fmax(ceil(extent / options->grid_spacing - 1e-6), 1);
        if (!(count <= IMAGE_SIDE_MAX))
            return cli_fail(CLI_USAGE, "--grid-spacing %g: more than %d probes along %c", options->grid_spacing,
                            (int)IMAGE_SIDE_MAX, "xyz"[a]);
        grid->size[a] = (int32_t)count;
        grid->spacing[a] = options->grid_spacing > 0 ? options->grid_spacing : extent > 0 ? extent / count : 1;
        grid->origin[a] = 0.5 * (lower[a] + upper[a]) - 0.5 * (count - 1) * grid->spacing[a];
    }
    const double rows = (double)grid->size[1] * grid->size[2];
    if (rows > IMAGE_SIDE_MAX || rows * grid->size[0] > POINTS_MAX)
        return cli_fail(CLI_USAGE, "a light grid of %d x %d x %d probes: NY times NZ is at most %d, all together %d",
                        (int)grid->size[0], (int)grid->size[1], (int)grid->size[2], (int)IMAGE_SIDE_MAX,
                        (int)POINTS_MAX);
    return CLI_GO;
}

static double probe_bytes(const bake_options* options, double channels) {
    return sizeof(ty_bake_probe) + 3 * sizeof(float) + channels * options->sh * options->sh * sizeof(float);
}

static int plan_grid(bake_run* run) {
    double lower[3], upper[3];
    if (!ty_scene_get_info(run->scene).bounded)
        return cli_fail(CLI_USAGE, "--grid: nothing in %s has a position for a grid to cover", run->options->scene);
    ty_result result = find_box(run->scene, lower, upper);
    if (result != TY_OK) return cli_fail_running(run->session, result);
    const int status = place_grid(run->options, lower, upper, &run->plan.grid);
    if (status != CLI_GO) return status;
    const int32_t* size = run->plan.grid.size;
    bake_unit unit = {.kind = BAKE_GRID, .name = "grid", .size = {size[0], size[1] * size[2]}};
    unit.receivers = (int64_t)size[0] * size[1] * size[2];
    unit.bytes = (double)unit.receivers * probe_bytes(run->options, 3 * (1 + TY_BAKE_LAYERS));
    result = add_unit(&run->plan, &unit);
    return result == TY_OK ? CLI_GO : cli_fail_running(run->session, result);
}

static int plan_probes(bake_run* run) {
    ty_result result =
        ty_points_read(run->session->context, run->options->probes, &run->plan.probes, &run->plan.probe_count);
    if (result != TY_OK) return cli_fail_reading(run->session, result);
    bake_unit unit = {.kind = BAKE_PROBES, .name = "probes", .receivers = run->plan.probe_count};
    unit.bytes = (double)unit.receivers * probe_bytes(run->options, 0);
    result = add_unit(&run->plan, &unit);
    return result == TY_OK ? CLI_GO : cli_fail_running(run->session, result);
}

/* ---- Plan ---- */

static bool wants_grid(const bake_options* options) {
    return options->grid_text != NULL || options->grid_spacing > 0;
}

int bake_make_plan(bake_run* run) {
    const bake_options* options = run->options;
    const bool points = wants_grid(options) || options->probes != NULL;
    if (!points || options->lightmaps || options->vertices) {
        if (ty_scene_get_info(run->scene).meshes == 0)
            return cli_fail(CLI_USAGE, "%s: there are no meshes to bake; --grid and --probes need none",
                            options->scene);
        const ty_result result = plan_meshes(run);
        if (result != TY_OK) return cli_fail_reading(run->session, result);
    }
    if (run->def.method == TY_BAKE_CACHE) {
        const ty_result result = ty_bake_cache_estimate(run->scene, &run->def, &run->plan.cache);
        if (result != TY_OK) return cli_fail_running(run->session, result);
    }
    int status = wants_grid(options) ? plan_grid(run) : CLI_GO;
    if (status == CLI_GO && options->probes != NULL) status = plan_probes(run);
    return status;
}

void bake_free_plan(cli_session* session, bake_plan* plan) {
    if (plan->probes != NULL) ty_points_destroy(session->context, plan->probes, plan->probe_count);
    free(plan->units);
}

void bake_print_plan(const bake_run* run) {
    const bake_plan* plan = &run->plan;
    const ty_scene_info info = ty_scene_get_info(run->scene);
    const int32_t* grid = plan->grid.size;
    char bytes[24];
    if (plan->lightmapped + plan->by_vertex > 0)
        printf("meshes: %d by lightmap (%" PRId64 " texels), %d by vertex\n", (int)plan->lightmapped, plan->texels,
               (int)plan->by_vertex);
    if (plan->lightmapped + plan->by_vertex > 0 && info.shapes > 0)
        printf("%d shapes have no coordinates to bake by; they give and block light\n", (int)info.shapes);
    if (grid[0] > 0) printf("light grid: %d x %d x %d\n", (int)grid[0], (int)grid[1], (int)grid[2]);
    if (plan->probe_count > 0) printf("probes: %" PRId64 "\n", plan->probe_count);
    cli_format_bytes(plan->bytes + plan->cache.bytes + (double)info.bytes, bytes);
    if (plan->cache.bytes > 0)
        printf("light in media: %d x %d x %d cells of %.3g m\n", (int)plan->cache.size[0], (int)plan->cache.size[1],
               (int)plan->cache.size[2], plan->cache.cell);
    printf("about %" PRId64 " receivers, %s of memory\n", plan->receivers, bytes);
}
