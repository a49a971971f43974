/* tyndall unwrap: second texture coordinates for the meshes of a glTF file. */
#include "bake/unwrap/unwrap.h"
#include "base/context.h"
#include "cli/bake/mesh_scene.h"
#include "cli/commands.h"

#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

typedef struct unwrap_options {
    const char *input, *output;
    ty_unwrap_def def;
    bool all, json;
} unwrap_options;

/* The writer's description of one mesh, with its arrays. */
typedef struct new_mesh {
    ty_mesh_uv2 mesh;
    int64_t* source;
    float* uv;
    uint32_t* indices;
} new_mesh;

typedef struct unwrap_run {
    cli_session* session;
    const unwrap_options* options;
    ty_scene* scene;
    new_mesh* meshes; /* one per mesh of the scene, filled in order */
    int64_t count;
    json_writer json;
} unwrap_run;

/* ---- One node ---- */

/* The triangles of several meshes as one. */
static bool join(const unwrap_run* run, int32_t first, int32_t count, ty_unwrap_mesh* out, float** positions,
                 uint32_t** indices) {
    int64_t vertices = 0, triangles = 0;
    ty_mesh_def mesh;
    for (int32_t i = first; i < first + count && ty_scene_get_mesh(run->scene, i, &mesh) == TY_OK; ++i) {
        vertices += mesh.vertex_count;
        triangles += mesh.triangle_count;
    }
    *positions = malloc((size_t)vertices * 3 * sizeof **positions);
    *indices = malloc((size_t)triangles * 3 * sizeof **indices);
    if (*positions == NULL || *indices == NULL) return false;
    *out = (ty_unwrap_mesh){*positions, *indices, 0, 0};
    for (int32_t i = first; i < first + count && ty_scene_get_mesh(run->scene, i, &mesh) == TY_OK; ++i) {
        memcpy(*positions + 3 * out->vertex_count, mesh.positions, (size_t)mesh.vertex_count * 3 * sizeof(float));
        for (int64_t k = 0; k < 3 * mesh.triangle_count; ++k)
            (*indices)[3 * out->triangle_count + k] = mesh.indices[k] + (uint32_t)out->vertex_count;
        out->vertex_count += mesh.vertex_count;
        out->triangle_count += mesh.triangle_count;
    }
    return true;
}

/* One vertex per vertex and chart that has it; lists of them by vertex, from the last on. */
static bool split(const ty_mesh_def* mesh, const ty_unwrap* unwrap, int64_t first_triangle, new_mesh* out) {
    const size_t corners = 3 * (size_t)mesh->triangle_count;
    int64_t *last = malloc((size_t)mesh->vertex_count * sizeof *last), *before = malloc(corners * sizeof *before);
    int32_t* charts = malloc(corners * sizeof *charts);
    *out = (new_mesh){.source = malloc(corners * sizeof *out->source),
                      .uv = malloc(2 * corners * sizeof *out->uv),
                      .indices = malloc(corners * sizeof *out->indices)};
    const bool made = last != NULL && before != NULL && charts != NULL && out->source != NULL && out->uv != NULL &&
                      out->indices != NULL;
    int64_t count = 0;
    for (int64_t i = 0; made && i < mesh->vertex_count; ++i) last[i] = -1;
    for (size_t k = 0; made && k < corners; ++k) {
        const uint32_t vertex = mesh->indices[k];
        const int32_t chart = unwrap->chart[first_triangle + (int64_t)(k / 3)];
        int64_t found = last[vertex];
        while (found >= 0 && charts[found] != chart) found = before[found];
        if (found < 0) {
            found = count++;
            before[found] = last[vertex];
            last[vertex] = found;
            charts[found] = chart;
            out->source[found] = vertex;
            memcpy(out->uv + 2 * found, unwrap->uv + 2 * (3 * (size_t)first_triangle + k), 2 * sizeof(float));
        }
        out->indices[k] = (uint32_t)found;
    }
    out->mesh = (ty_mesh_uv2){mesh->origin, count, out->source, out->uv, mesh->triangle_count, out->indices};
    free(last);
    free(before);
    free(charts);
    return made;
}

static void report(unwrap_run* run, const ty_mesh_def* mesh, const ty_unwrap* unwrap) {
    const char* name = mesh->origin.name == NULL ? "" : mesh->origin.name;
    if (run->options->json) {
        json_open_object(&run->json, NULL);
        json_text(&run->json, "mesh", name);
        json_int(&run->json, "triangles", unwrap->triangle_count);
        json_int(&run->json, "charts", unwrap->charts);
        json_numbers(&run->json, "size", (const double[]){unwrap->width, unwrap->height}, 2);
        json_number(&run->json, "texels_per_meter", unwrap->density);
        json_number(&run->json, "fill", unwrap->fill);
        json_number(&run->json, "stretch", unwrap->stretch);
        json_number(&run->json, "mean_stretch", unwrap->mean_stretch);
        json_close_object(&run->json);
    } else if (!run->session->common.quiet) {
        printf("%s: %" PRId64 " triangles in %d charts, %d x %d texels, %.0f %% filled, stretch %.2f (L2 %.3f)\n", name,
               unwrap->triangle_count, (int)unwrap->charts, (int)unwrap->width, (int)unwrap->height, 100 * unwrap->fill,
               unwrap->stretch, unwrap->mean_stretch);
    }
}

static ty_result unwrap_node(unwrap_run* run, int32_t first, int32_t count) {
    ty_context* context = run->session->context;
    ty_unwrap_mesh joined;
    ty_unwrap unwrap = {.uv = NULL};
    float* positions = NULL;
    uint32_t* indices = NULL;
    ty_mesh_def mesh;
    ty_result result = join(run, first, count, &joined, &positions, &indices) ? TY_OK : TY_ERROR_MEMORY;
    if (result == TY_OK) result = ty_unwrap_mesh_create(context, &joined, &run->options->def, &unwrap);
    int64_t triangle = 0;
    for (int32_t i = first; i < first + count && result == TY_OK; ++i) {
        result = ty_scene_get_mesh(run->scene, i, &mesh);
        if (result == TY_OK && !split(&mesh, &unwrap, triangle, &run->meshes[run->count++])) result = TY_ERROR_MEMORY;
        triangle += mesh.triangle_count;
    }
    if (result == TY_OK) report(run, &mesh, &unwrap);
    ty_unwrap_free(context, &unwrap);
    free(positions);
    free(indices);
    return result;
}

/* ---- The file ---- */

static ty_result unwrap_nodes(unwrap_run* run) {
    const int32_t meshes = ty_scene_get_info(run->scene).meshes;
    ty_result result = TY_OK;
    for (int32_t first = 0, next; first < meshes && result == TY_OK; first = next) {
        ty_mesh_def mesh, other;
        result = ty_scene_get_mesh(run->scene, first, &mesh);
        bool has_all = mesh.uv[1] != NULL;
        for (next = first + 1; next < meshes && ty_scene_get_mesh(run->scene, next, &other) == TY_OK; ++next) {
            if (!cli_same_node(&mesh, &other)) break;
            has_all = has_all && other.uv[1] != NULL;
        }
        if (result == TY_OK && (run->options->all || !has_all)) result = unwrap_node(run, first, next - first);
    }
    return result;
}

static int write_file(unwrap_run* run) {
    ty_context* context = run->session->context;
    ty_mesh_uv2* meshes = calloc((size_t)run->count + 1, sizeof *meshes);
    ty_result result = meshes == NULL ? TY_ERROR_MEMORY : TY_OK;
    for (int64_t i = 0; i < run->count && result == TY_OK; ++i) meshes[i] = run->meshes[i].mesh;
    if (result == TY_OK)
        result = ty_mesh_file_write_uv2(context, run->options->input, meshes, run->count, run->options->output);
    free(meshes);
    return result == TY_OK ? CLI_DONE : cli_fail_reading(run->session, result);
}

static int run_unwrap(unwrap_run* run) {
    const cli_list nothing = {.count = 0};
    cli_end_on_interrupt(true);
    ty_result result = cli_load_mesh_scene(run->session, run->options->input, &nothing, &run->scene);
    if (result != TY_OK) return cli_fail_reading(run->session, result);
    const int32_t meshes = ty_scene_get_info(run->scene).meshes;
    run->meshes = calloc((size_t)meshes + 1, sizeof *run->meshes);
    result = run->meshes == NULL ? TY_ERROR_MEMORY : TY_OK;
    run->json = json_begin(stdout);
    if (run->options->json) json_open_array(&run->json, NULL);
    if (result == TY_OK) result = unwrap_nodes(run);
    if (run->options->json) json_close_array(&run->json);
    cli_end_on_interrupt(false);
    int status = result == TY_OK ? write_file(run) : cli_fail_running(run->session, result);
    for (int64_t i = 0; i < run->count; ++i) {
        free(run->meshes[i].source);
        free(run->meshes[i].uv);
        free(run->meshes[i].indices);
    }
    free(run->meshes);
    ty_scene_destroy(run->scene);
    if (status == CLI_DONE && !run->session->common.quiet && !run->options->json)
        printf("wrote %s: %" PRId64 " meshes with new coordinates\n", run->options->output, run->count);
    return status;
}

int cli_unwrap(int count, char** arguments) {
    unwrap_options options = {.def = {.density = 8, .stretch = 1.5, .padding = 4}};
    const cli_option table[] = {
        {"output", 'o', CLI_TEXT, "FILE", "the copy, .glb", &options.output, 0, 0, NULL},
        {"density", 0, CLI_REAL, "T", "texels per metre for which charts are packed (default 8, as bake has it)",
         &options.def.density, 1e-6, 1e6, NULL},
        {"padding", 0, CLI_INT, "N", "texels between charts (default 4)", &options.def.padding, 0, 64, NULL},
        {"stretch", 0, CLI_REAL, "S", "largest ratio of lengths on the surface and in the map (default 1.5)",
         &options.def.stretch, 1.01, 100, NULL},
        {"all", 0, CLI_FLAG, NULL, "also meshes that have second texture coordinates", &options.all, 0, 0, NULL},
        {"json", 0, CLI_FLAG, NULL, "print what each node got as JSON", &options.json, 0, 0, NULL},
    };
    const cli_syntax syntax = {"unwrap",
                               "LEVEL.glb -o OUT.glb [options]",
                               "Gives the meshes of a glTF file second texture coordinates, for lightmaps.",
                               "LEVEL is .glb or .gltf. Meshes without TEXCOORD_1 are cut into charts, which are\n"
                               "mapped conformally within the stretch and packed without overlaps, one map for each\n"
                               "node. Vertices at the seams become several; everything else is copied as it is.",
                               table,
                               sizeof table / sizeof table[0],
                               1,
                               1,
                               NULL};
    cli_arguments given;
    int status = cli_parse(&syntax, count, arguments, &given);
    if (status == CLI_GO && options.output == NULL) status = cli_usage_error("unwrap", "-o FILE is missing");
    if (status == CLI_GO && !cli_has_extension(options.output, ".glb"))
        status = cli_usage_error("unwrap", "%s: the extension is not .glb", options.output);
    if (status == CLI_GO && !cli_has_extension(given.positional[0], ".glb") &&
        !cli_has_extension(given.positional[0], ".gltf"))
        status = cli_usage_error("unwrap", "%s: the extension is not .glb or .gltf", given.positional[0]);
    if (status == CLI_GO) status = cli_check_output("unwrap", options.output);
    cli_session session;
    if (status == CLI_GO) status = cli_session_open(&session, "unwrap", &given.common);
    if (status != CLI_GO) return status;
    options.input = given.positional[0];
    unwrap_run run = {.session = &session, .options = &options};
    return cli_session_close(&session, run_unwrap(&run));
}
