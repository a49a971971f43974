/* tyndall info of a scene. */
#include "cli/info.h"

#include <inttypes.h>
#include <stdlib.h>

static void print_vector(const char* label, const double v[3], const char* after) {
    printf("%s(%.6g, %.6g, %.6g)%s", label, v[0], v[1], v[2], after);
}

static void print_color(const char* label, const float c[3], const char* after) {
    if (c[0] == c[1] && c[1] == c[2])
        printf("%s%.6g%s", label, (double)c[0], after);
    else
        printf("%s(%.6g, %.6g, %.6g)%s", label, (double)c[0], (double)c[1], (double)c[2], after);
}

static void print_medium(int32_t index, const ty_medium_def* medium) {
    static const double none[12] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
    printf("medium %-4d %s%s", index, medium->name, medium->name[0] == '\0' ? "" : ": ");
    print_color("sigma_s ", medium->sigma_s, ", ");
    print_color("sigma_a ", medium->sigma_a, " 1/m, ");
    print_color("g ", medium->g, "");
    printf(", scale %.6g\n", (double)medium->scale);
    if (medium->bounds == TY_BOUNDS_BOX) {
        print_vector("            box ", medium->box_min, " to ");
        print_vector("", medium->box_max, " m");
    } else if (medium->bounds == TY_BOUNDS_SPHERE) {
        print_vector("            sphere around ", medium->sphere_center, ", ");
        printf("radius %.6g m", medium->sphere_radius);
    } else {
        printf("            where its grid is");
    }
    bool transformed = false;
    for (int i = 0; i < 12; ++i) transformed = transformed || medium->transform.m[i] != none[i];
    printf("%s\n", transformed ? ", transformed" : "");
    if (medium->density_grid == NULL) return;
    const ty_grid_info grid = ty_grid_get_info(medium->density_grid);
    char bytes[24];
    cli_format_bytes((double)grid.bytes, bytes);
    printf("            grid %dx%dx%d %s, density %.6g to %.6g, mean %.6g, %s\n", grid.size[0], grid.size[1],
           grid.size[2], grid.type == TY_GRID_F16 ? "half" : "float", (double)grid.min, (double)grid.max, grid.mean,
           bytes);
}

static void print_scene(const ty_scene* scene, const char* path) {
    const ty_scene_info info = ty_scene_get_info(scene);
    const ty_camera_def camera = ty_scene_camera(scene);
    const ty_render_settings settings = ty_scene_render_settings(scene);
    char bytes[24];
    cli_format_bytes((double)info.bytes, bytes);
    printf("scene       %s\nhash        %016" PRIx64 "\nup          %c\n", path, ty_scene_hash(scene),
           ty_scene_up_axis(scene) == TY_AXIS_Z ? 'z' : 'y');
    printf("render      %s, %d spp, seed %" PRIu64 "\n", settings.method, settings.spp, settings.seed);
    printf("camera      %dx%d, ", camera.resolution[0], camera.resolution[1]);
    print_vector("from ", camera.position, " to ");
    print_vector("", camera.target, "");
    printf(" m, %.6g degrees high, exposure %.6g\n", camera.fov_y, camera.exposure);
    for (int32_t i = 0; i < info.media; ++i) {
        ty_medium_def medium;
        if (ty_scene_get_medium(scene, i, &medium) == TY_OK) print_medium(i, &medium);
    }
    printf("media       %d\nlights      %d\nshapes      %d\n", info.media, info.lights, info.shapes);
    if (info.bounded) {
        print_vector("bounds      ", info.lower, " to ");
        print_vector("", info.upper, " m\n");
    }
    printf("memory      %s\n", bytes);
}

/* The shortest decimal that reads back as value: 0.7 rather than 0.699999988. */
static double decimal(float value) {
    char text[32];
    for (int digits = 6; digits <= 9; ++digits) {
        snprintf(text, sizeof text, "%.*g", digits, (double)value);
        if (strtof(text, NULL) == value) break;
    }
    return strtod(text, NULL);
}

static void json_color(json_writer* json, const char* name, const float color[3]) {
    const double values[3] = {decimal(color[0]), decimal(color[1]), decimal(color[2])};
    json_numbers(json, name, values, 3);
}

static void json_medium(json_writer* json, const ty_medium_def* medium) {
    json_open_object(json, NULL);
    json_text(json, "name", medium->name);
    json_color(json, "sigma_s", medium->sigma_s);
    json_color(json, "sigma_a", medium->sigma_a);
    json_color(json, "g", medium->g);
    json_number(json, "scale", decimal(medium->scale));
    if (medium->bounds == TY_BOUNDS_BOX) {
        json_open_array(json, "box");
        json_numbers(json, NULL, medium->box_min, 3);
        json_numbers(json, NULL, medium->box_max, 3);
        json_close_array(json);
    } else if (medium->bounds == TY_BOUNDS_SPHERE) {
        json_open_object(json, "sphere");
        json_numbers(json, "center", medium->sphere_center, 3);
        json_number(json, "radius", medium->sphere_radius);
        json_close_object(json);
    }
    json_numbers(json, "transform", medium->transform.m, 12);
    if (medium->density_grid != NULL) {
        const ty_grid_info grid = ty_grid_get_info(medium->density_grid);
        json_open_object(json, "grid");
        json_numbers(json, "size", (const double[]){grid.size[0], grid.size[1], grid.size[2]}, 3);
        json_text(json, "type", grid.type == TY_GRID_F16 ? "half" : "float");
        json_number(json, "min", decimal(grid.min));
        json_number(json, "max", decimal(grid.max));
        json_number(json, "mean", grid.mean);
        json_integer(json, "bytes", (int64_t)grid.bytes);
        json_close_object(json);
    }
    json_close_object(json);
}

static void print_scene_json(const ty_scene* scene, const char* path) {
    const ty_scene_info info = ty_scene_get_info(scene);
    const ty_camera_def camera = ty_scene_camera(scene);
    const ty_render_settings settings = ty_scene_render_settings(scene);
    char hash[17];
    snprintf(hash, sizeof hash, "%016" PRIx64, ty_scene_hash(scene));
    json_writer json = json_begin(stdout);
    json_open_object(&json, NULL);
    json_text(&json, "kind", "scene");
    json_text(&json, "file", path);
    json_text(&json, "hash", hash);
    json_text(&json, "up_axis", ty_scene_up_axis(scene) == TY_AXIS_Z ? "z" : "y");
    json_open_object(&json, "render");
    json_text(&json, "method", settings.method);
    json_integer(&json, "spp", settings.spp);
    json_unsigned(&json, "seed", settings.seed);
    json_close_object(&json);
    json_open_object(&json, "camera");
    json_numbers(&json, "resolution", (const double[]){camera.resolution[0], camera.resolution[1]}, 2);
    json_numbers(&json, "position", camera.position, 3);
    json_numbers(&json, "target", camera.target, 3);
    json_numbers(&json, "up", camera.up, 3);
    json_number(&json, "fov_y", camera.fov_y);
    json_number(&json, "exposure", camera.exposure);
    json_close_object(&json);
    json_open_array(&json, "media");
    for (int32_t i = 0; i < info.media; ++i) {
        ty_medium_def medium;
        if (ty_scene_get_medium(scene, i, &medium) == TY_OK) json_medium(&json, &medium);
    }
    json_close_array(&json);
    json_integer(&json, "lights", info.lights);
    json_integer(&json, "shapes", info.shapes);
    if (info.bounded) {
        json_open_array(&json, "bounds");
        json_numbers(&json, NULL, info.lower, 3);
        json_numbers(&json, NULL, info.upper, 3);
        json_close_array(&json);
    }
    json_integer(&json, "bytes", (int64_t)info.bytes);
    json_close_object(&json);
}

int cli_info_scene(cli_session* session, const char* path, const cli_list* overrides, bool json) {
    ty_scene* scene = NULL;
    const ty_result result = ty_scene_load(session->context, path, overrides->items, overrides->count, &scene);
    if (result != TY_OK) return cli_fail_reading(session, result);
    if (json)
        print_scene_json(scene, path);
    else
        print_scene(scene, path);
    ty_scene_destroy(scene);
    return CLI_DONE;
}
