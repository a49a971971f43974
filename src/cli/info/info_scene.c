/* tyndall info of a scene. */
#include "cli/info/info.h"
#include "cli/text/text.h"

#include <inttypes.h>
#include <stdlib.h>

void cli_print_vector(const char* label, const double v[3], const char* after) {
    printf("%s(%.6g, %.6g, %.6g)%s", label, v[0], v[1], v[2], after);
}

static void print_color(const char* label, const float c[3], const char* after) {
    if (c[0] == c[1] && c[1] == c[2])
        printf("%s%.6g%s", label, (double)c[0], after);
    else
        printf("%s(%.6g, %.6g, %.6g)%s", label, (double)c[0], (double)c[1], (double)c[2], after);
}

static const char* bounds_name(const ty_medium_def* medium) {
    static const char* const names[] = {"none", "box", "sphere", "closed mesh"};
    return names[medium->bounds];
}

static bool has_emission(const ty_medium_def* medium) {
    const float* radiance = medium->emission;
    return medium->temperature_grid != NULL || radiance[0] > 0 || radiance[1] > 0 || radiance[2] > 0;
}

static void print_grid(const char* label, const ty_grid* grid) {
    if (grid == NULL) return;
    const ty_grid_info info = ty_grid_get_info(grid);
    char bytes[24];
    cli_format_bytes((double)info.bytes, bytes);
    printf("            %s %dx%dx%d %s%s, %.6g to %.6g, mean %.6g, %s%s\n", label, info.size[0], info.size[1],
           info.size[2], info.type == TY_GRID_F16 ? "half" : "float", info.placed ? "" : ", filling the box",
           (double)info.min, (double)info.max, info.mean, cli_storage_note(info.storage), bytes);
    printf("            %" PRId64 " active voxels\n", info.active);
}

static void print_bounds(const ty_medium_def* medium) {
    static const double none[12] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
    switch (medium->bounds) {
    case TY_BOUNDS_NONE: printf("            where its density is"); break;
    case TY_BOUNDS_BOX:
        cli_print_vector("            box ", medium->box_min, " to ");
        cli_print_vector("", medium->box_max, " m");
        break;
    case TY_BOUNDS_SPHERE:
        cli_print_vector("            sphere around ", medium->sphere_center, ", ");
        printf("radius %.6g m", medium->sphere_radius);
        break;
    case TY_BOUNDS_SHELL: printf("            within a closed mesh"); break;
    }
    bool transformed = false;
    for (int i = 0; i < 12; ++i) transformed = transformed || medium->transform.m[i] != none[i];
    printf("%s\n", transformed ? ", transformed" : "");
}

static const char* const phase_kinds[] = {[TY_PHASE_DRAINE] = "draine",
                                          [TY_PHASE_MIE] = "mie",
                                          [TY_PHASE_FOURNIER_FORAND] = "fournier_forand",
                                          [TY_PHASE_TABLE] = "table"};

static void print_lobe(const ty_phase_lobe* lobe) {
    printf("            phase function %s", phase_kinds[lobe->kind]);
    switch (lobe->kind) {
    case TY_PHASE_DRAINE: printf(", g %.6g, alpha %.6g", lobe->g, lobe->alpha); break;
    case TY_PHASE_MIE: printf(", droplets of %.6g um", lobe->diameter); break;
    case TY_PHASE_FOURNIER_FORAND:
        if (lobe->n > 0)
            printf(", n %.6g, mu %.6g", lobe->n, lobe->mu);
        else
            printf(", backscatter %.6g", lobe->backscatter);
        break;
    case TY_PHASE_TABLE: printf(" of %d nodes", lobe->count); break;
    }
    print_color(", weight ", lobe->weight, "\n");
}

static void print_fields(const ty_medium_def* medium) {
    static const char* const labels[] = {"albedo (red)", "albedo (green)", "albedo (blue)"};
    print_grid("density", medium->density_grid);
    if (medium->transfer_count > 0)
        printf("            transfer function of %d points, %.6g to %.6g%s\n", medium->transfer_count,
               (double)medium->transfer[0].value, (double)medium->transfer[medium->transfer_count - 1].value,
               medium->transfer_albedo ? ", with albedo" : "");
    const bool gray = medium->albedo_grid[0] == medium->albedo_grid[1];
    for (int c = 0; c < (gray ? 1 : 3); ++c) print_grid(gray ? "albedo" : labels[c], medium->albedo_grid[c]);
    print_grid("g", medium->g_grid);
    if (!has_emission(medium)) return;
    print_color("            emission: radiance ", medium->emission, " W m^-2 sr^-1");
    if (medium->temperature_grid != NULL)
        printf(", black body of %.6g K at 0 to %.6g K at 1, scale %.6g", medium->kelvin[0], medium->kelvin[1],
               (double)medium->emission_scale);
    printf("\n");
    print_grid("temperature", medium->temperature_grid);
}

static void print_medium(int32_t index, const ty_medium_def* medium) {
    printf("medium %-4d ", index);
    cli_print_text(stdout, medium->name, 0);
    if (medium->name[0] != '\0') printf(": ");
    print_color("sigma_s ", medium->sigma_s, ", ");
    print_color("sigma_a ", medium->sigma_a, " 1/m, ");
    print_color("g ", medium->g, "");
    printf(", scale %.6g\n", (double)medium->scale);
    for (int32_t i = 0; i < medium->phase_count; ++i) print_lobe(&medium->phase[i]);
    print_bounds(medium);
    print_fields(medium);
}

/* The axes along which a scene repeats, such as "xy"; "": none. */
static const char* periodic_axes(const ty_periodic_def* periodic, char out[4]) {
    int count = 0;
    for (int a = 0; a < 3; ++a)
        if (periodic->axes[a]) out[count++] = (char)('x' + a);
    out[count] = '\0';
    return out;
}

static void print_boundary(const ty_scene* scene) {
    const ty_periodic_def periodic = ty_scene_periodic(scene);
    char axes[4];
    if (periodic_axes(&periodic, axes)[0] == '\0') return;
    printf("boundary    periodic,");
    for (int a = 0; a < 3; ++a)
        if (periodic.axes[a]) printf(" %c %.6g to %.6g", 'x' + a, periodic.lower[a], periodic.upper[a]);
    printf(" m\n");
}

static void print_scene(const ty_scene* scene, const char* path) {
    const ty_scene_info info = ty_scene_get_info(scene);
    const ty_camera_def camera = ty_scene_camera(scene);
    const ty_render_settings settings = ty_scene_render_settings(scene);
    char bytes[24], texture_bytes[24];
    cli_format_bytes((double)info.bytes, bytes);
    cli_format_bytes((double)info.texture_bytes, texture_bytes);
    printf("scene       %s\nhash        %016" PRIx64 "\nup          %c\n", path, ty_scene_hash(scene),
           ty_scene_up_axis(scene) == TY_AXIS_Z ? 'z' : 'y');
    printf("render      %s, %d spp, seed %" PRIu64 "\n", settings.method, settings.spp, settings.seed);
    print_boundary(scene);
    printf("camera      %dx%d, ", camera.resolution[0], camera.resolution[1]);
    cli_print_vector("from ", camera.position, " to ");
    cli_print_vector("", camera.target, "");
    const char* source = ty_scene_camera_source(scene);
    printf(" m, %.6g degrees high, exposure %.6g%s", camera.fov_y, camera.exposure, source[0] != '\0' ? ", " : "");
    cli_print_text(stdout, source, 0);
    printf("\n");
    for (int32_t i = 0; i < info.media; ++i) {
        ty_medium_def medium;
        if (ty_scene_get_medium(scene, i, &medium) == TY_OK &&
            ty_medium_mean_cosine(ty_scene_context(scene), &medium, medium.g) == TY_OK)
            print_medium(i, &medium);
    }
    printf("media       %d\nlights      %d\nshapes      %d\n", info.media, info.lights, info.shapes);
    if (info.meshes > 0) printf("meshes      %d, %" PRId64 " triangles\n", info.meshes, info.triangles);
    if (info.textures > 0) printf("textures    %" PRId64 ", %s\n", info.textures, texture_bytes);
    printf("emitters    %" PRId64 "\n", info.emitters);
    if (info.bounded) {
        cli_print_vector("bounds      ", info.lower, " to ");
        cli_print_vector("", info.upper, " m\n");
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

static void json_grid(json_writer* json, const char* name, const ty_grid* grid) {
    if (grid == NULL) return;
    const ty_grid_info info = ty_grid_get_info(grid);
    json_open_object(json, name);
    json_numbers(json, "size", (const double[]){info.size[0], info.size[1], info.size[2]}, 3);
    json_text(json, "type", info.type == TY_GRID_F16 ? "half" : "float");
    json_bool(json, "placed", info.placed);
    json_number(json, "min", decimal(info.min));
    json_number(json, "max", decimal(info.max));
    json_number(json, "mean", info.mean);
    json_int(json, "bytes", (int64_t)info.bytes);
    json_text(json, "storage", cli_storage_name(info.storage));
    json_int(json, "active_voxels", info.active);
    json_close_object(json);
}

static void json_fields(json_writer* json, const ty_medium_def* medium) {
    if (medium->transfer_count > 0) {
        json_open_array(json, "transfer");
        for (int32_t i = 0; i < medium->transfer_count; ++i) {
            const ty_transfer_point* point = &medium->transfer[i];
            json_open_object(json, NULL);
            json_number(json, "value", decimal(point->value));
            json_number(json, "density", decimal(point->density));
            if (medium->transfer_albedo) json_color(json, "albedo", point->albedo);
            json_close_object(json);
        }
        json_close_array(json);
    }
    if (medium->albedo_grid[0] != NULL) {
        const bool gray = medium->albedo_grid[0] == medium->albedo_grid[1];
        json_open_array(json, "albedo");
        for (int c = 0; c < (gray ? 1 : 3); ++c) json_grid(json, NULL, medium->albedo_grid[c]);
        json_close_array(json);
    }
    json_grid(json, "g_grid", medium->g_grid);
    if (!has_emission(medium)) return;
    json_open_object(json, "emission");
    json_color(json, "radiance", medium->emission);
    if (medium->temperature_grid != NULL) {
        json_grid(json, "temperature", medium->temperature_grid);
        json_numbers(json, "kelvin", medium->kelvin, 2);
        json_number(json, "scale", decimal(medium->emission_scale));
    }
    json_close_object(json);
}

static void json_phase(json_writer* json, const ty_medium_def* medium) {
    json_open_array(json, "phase");
    for (int32_t i = 0; i < medium->phase_count; ++i) {
        const ty_phase_lobe* lobe = &medium->phase[i];
        json_open_object(json, NULL);
        json_text(json, "type", phase_kinds[lobe->kind]);
        json_color(json, "weight", lobe->weight);
        if (lobe->kind == TY_PHASE_DRAINE) {
            json_number(json, "g", lobe->g);
            json_number(json, "alpha", lobe->alpha);
        } else if (lobe->kind == TY_PHASE_MIE) {
            json_number(json, "diameter", lobe->diameter);
        } else if (lobe->kind == TY_PHASE_TABLE) {
            json_int(json, "nodes", lobe->count);
        } else if (lobe->n > 0) {
            json_number(json, "n", lobe->n);
            json_number(json, "mu", lobe->mu);
        } else {
            json_number(json, "backscatter", lobe->backscatter);
        }
        json_close_object(json);
    }
    json_close_array(json);
}

static void json_medium(json_writer* json, const ty_medium_def* medium) {
    json_open_object(json, NULL);
    json_text(json, "name", medium->name);
    json_color(json, "sigma_s", medium->sigma_s);
    json_color(json, "sigma_a", medium->sigma_a);
    json_color(json, "g", medium->g);
    if (medium->phase_count > 0) json_phase(json, medium);
    json_number(json, "scale", decimal(medium->scale));
    json_text(json, "bounds", bounds_name(medium));
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
    json_grid(json, "grid", medium->density_grid);
    json_fields(json, medium);
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
    json_int(&json, "spp", settings.spp);
    json_unsigned(&json, "seed", settings.seed);
    json_close_object(&json);
    const ty_periodic_def periodic = ty_scene_periodic(scene);
    char axes[4];
    if (periodic_axes(&periodic, axes)[0] != '\0') {
        json_open_object(&json, "boundary");
        json_text(&json, "periodic", axes);
        json_numbers(&json, "lower", periodic.lower, 3);
        json_numbers(&json, "upper", periodic.upper, 3);
        json_close_object(&json);
    }
    json_open_object(&json, "camera");
    json_numbers(&json, "resolution", (const double[]){camera.resolution[0], camera.resolution[1]}, 2);
    json_numbers(&json, "position", camera.position, 3);
    json_numbers(&json, "target", camera.target, 3);
    json_numbers(&json, "up", camera.up, 3);
    json_number(&json, "fov_y", camera.fov_y);
    json_number(&json, "exposure", camera.exposure);
    if (ty_scene_camera_source(scene)[0] != '\0') json_text(&json, "source", ty_scene_camera_source(scene));
    json_close_object(&json);
    json_open_array(&json, "media");
    for (int32_t i = 0; i < info.media; ++i) {
        ty_medium_def medium;
        if (ty_scene_get_medium(scene, i, &medium) == TY_OK &&
            ty_medium_mean_cosine(ty_scene_context(scene), &medium, medium.g) == TY_OK)
            json_medium(&json, &medium);
    }
    json_close_array(&json);
    json_int(&json, "lights", info.lights);
    json_int(&json, "shapes", info.shapes);
    json_int(&json, "meshes", info.meshes);
    json_int(&json, "triangles", info.triangles);
    json_int(&json, "textures", info.textures);
    json_int(&json, "texture_bytes", (int64_t)info.texture_bytes);
    json_int(&json, "emitters", info.emitters);
    if (info.bounded) {
        json_open_array(&json, "bounds");
        json_numbers(&json, NULL, info.lower, 3);
        json_numbers(&json, NULL, info.upper, 3);
        json_close_array(&json);
    }
    json_int(&json, "bytes", (int64_t)info.bytes);
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
