/* tyndall info of a mesh file. */
#include "cli/info/info.h"
#include "cli/text/text.h"

#include <inttypes.h>
#include <stdlib.h>

enum { ENTRIES_MIN = 1024 };

typedef struct mesh_summary {
    const char* path;
    ty_scene_info scene;
    const ty_mesh_file_entry* entries;
    int32_t entry_count;
} mesh_summary;

static int32_t count_entries(const mesh_summary* mesh, bool cameras) {
    int32_t count = 0;
    for (int32_t i = 0; i < mesh->entry_count; ++i) count += mesh->entries[i].camera == cameras;
    return count;
}

static void print_entries(const mesh_summary* mesh, const char* label, bool cameras) {
    printf("%-16s %d\n", label, count_entries(mesh, cameras));
    for (int32_t i = 0; i < mesh->entry_count; ++i) {
        const ty_mesh_file_entry* entry = &mesh->entries[i];
        if (entry->camera != cameras) continue;
        printf("%-17s", "");
        cli_print_text(stdout, entry->name[0] != '\0' ? entry->name : "(no name)", 0);
        if (!cameras) cli_print_material(entry);
        if (cameras && entry->fov_y > 0) printf(", %.6g degrees high", entry->fov_y);
        if (cameras && !(entry->fov_y > 0)) printf(", orthographic");
        printf("\n");
    }
}

static void print_mesh(const mesh_summary* mesh) {
    char bytes[24], texture_bytes[24];
    cli_format_bytes((double)mesh->scene.bytes, bytes);
    cli_format_bytes((double)mesh->scene.texture_bytes, texture_bytes);
    printf("mesh             %s\nmeshes           %d, %" PRId64 " triangles\n", mesh->path, mesh->scene.meshes,
           mesh->scene.triangles);
    print_entries(mesh, "materials", false);
    printf("textures         %" PRId64 ", %s\n", mesh->scene.textures, texture_bytes);
    printf("lights           %d\nemitters         %" PRId64 "\n", mesh->scene.lights, mesh->scene.emitters);
    print_entries(mesh, "cameras", true);
    if (mesh->scene.bounded) {
        cli_print_vector("bounds           ", mesh->scene.lower, " to ");
        cli_print_vector("", mesh->scene.upper, "\n");
    }
    printf("memory           %s\n", bytes);
}

static void json_entries(json_writer* json, const mesh_summary* mesh, const char* label, bool cameras) {
    json_open_array(json, label);
    for (int32_t i = 0; i < mesh->entry_count; ++i) {
        const ty_mesh_file_entry* entry = &mesh->entries[i];
        if (entry->camera != cameras) continue;
        json_open_object(json, NULL);
        json_text(json, "name", entry->name);
        if (!cameras) cli_write_material(json, entry);
        if (cameras) json_bool(json, "orthographic", !(entry->fov_y > 0));
        if (cameras && entry->fov_y > 0) json_number(json, "fov_y", entry->fov_y);
        json_close_object(json);
    }
    json_close_array(json);
}

static void print_mesh_json(const mesh_summary* mesh) {
    json_writer json = json_begin(stdout);
    json_open_object(&json, NULL);
    json_text(&json, "kind", "mesh");
    json_text(&json, "file", mesh->path);
    json_int(&json, "meshes", mesh->scene.meshes);
    json_int(&json, "triangles", mesh->scene.triangles);
    json_entries(&json, mesh, "materials", false);
    json_int(&json, "textures", mesh->scene.textures);
    json_int(&json, "texture_bytes", (int64_t)mesh->scene.texture_bytes);
    json_int(&json, "lights", mesh->scene.lights);
    json_int(&json, "emitters", mesh->scene.emitters);
    json_entries(&json, mesh, "cameras", true);
    if (mesh->scene.bounded) {
        json_open_array(&json, "bounds");
        json_numbers(&json, NULL, mesh->scene.lower, 3);
        json_numbers(&json, NULL, mesh->scene.upper, 3);
        json_close_array(&json);
    }
    json_int(&json, "bytes", (int64_t)mesh->scene.bytes);
    json_close_object(&json);
}

int cli_info_mesh(cli_session* session, const char* path, bool json) {
    mesh_summary mesh = {.path = path};
    int32_t capacity = ENTRIES_MIN;
    ty_mesh_file_entry* entries = NULL;
    do {
        if (mesh.entry_count > capacity) capacity = mesh.entry_count;
        free(entries);
        entries = calloc((size_t)capacity, sizeof *entries);
        if (entries == NULL) return cli_fail(CLI_FAILED, "not enough memory");
        const ty_result result =
            ty_mesh_file_list(session->context, path, &mesh.scene, entries, capacity, &mesh.entry_count);
        if (result != TY_OK) {
            free(entries);
            return cli_fail_reading(session, result);
        }
    } while (mesh.entry_count > capacity);
    mesh.entries = entries;
    if (json)
        print_mesh_json(&mesh);
    else
        print_mesh(&mesh);
    free(entries);
    return CLI_DONE;
}
