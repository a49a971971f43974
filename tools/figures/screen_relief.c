/* Building reliefs. */
#include "figures/screen_relief.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Half extent of the medium, m, large enough that light from outside has no effect. */
static const double medium_reach = 60;

/* The mesh's arrays: four vertices and two triangles a pixel. */
typedef struct relief {
    float *positions, *uv;
    uint32_t* indices;
} relief;

static void free_relief(relief* r) {
    free(r->positions);
    free(r->uv);
    free(r->indices);
}

/* The camera's axes, unit. */
typedef struct axes {
    double right[3], up[3], ahead[3];
} axes;

static void cross(const double a[3], const double b[3], double out[3]) {
    for (int i = 0; i < 3; ++i) out[i] = a[(i + 1) % 3] * b[(i + 2) % 3] - a[(i + 2) % 3] * b[(i + 1) % 3];
}

static void normalize(double v[3]) {
    const double length = sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
    for (int i = 0; i < 3; ++i) v[i] /= length;
}

static axes find_axes(const ty_camera_def* camera) {
    axes a;
    for (int i = 0; i < 3; ++i) a.ahead[i] = camera->target[i] - camera->position[i];
    normalize(a.ahead);
    cross(a.ahead, camera->up, a.right);
    normalize(a.right);
    cross(a.right, a.ahead, a.up);
    return a;
}

/* The corners of pixel (x, y)'s facet, counter-clockwise as the camera sees them. */
static void place_facet(const screen_view* view, const axes* a, int32_t x, int32_t y, float out[12]) {
    static const int corners[4][2] = {{0, 1}, {1, 1}, {1, 0}, {0, 0}};
    const double left = x - 0.5 * view->width, top = y - 0.5 * view->height;
    const double u = (left + 0.5) / view->focal[0], v = (top + 0.5) / view->focal[1];
    const size_t i = (size_t)y * (size_t)view->width + (size_t)x;
    const double depth = (double)view->distance[i] / sqrt(1 + u * u + v * v);
    for (int corner = 0; corner < 4; ++corner) {
        const double across = (left + corners[corner][0]) / view->focal[0];
        const double down = (top + corners[corner][1]) / view->focal[1];
        for (int c = 0; c < 3; ++c)
            out[3 * corner + c] =
                (float)(view->camera.position[c] + depth * (a->ahead[c] + across * a->right[c] - down * a->up[c]));
    }
}

/* Creates the facets of pixels with a distance; returns their number. */
static int64_t fill_relief(const screen_view* view, relief* r) {
    static const uint32_t triangles[6] = {0, 1, 2, 0, 2, 3};
    const axes a = find_axes(&view->camera);
    int64_t facets = 0;
    for (int32_t y = 0; y < view->height; ++y)
        for (int32_t x = 0; x < view->width; ++x) {
            if (!(view->distance[(size_t)y * (size_t)view->width + (size_t)x] > 0)) continue;
            place_facet(view, &a, x, y, r->positions + 12 * facets);
            for (int corner = 0; corner < 4; ++corner) {
                r->uv[8 * facets + 2 * corner] = ((float)x + 0.5f) / (float)view->width;
                r->uv[8 * facets + 2 * corner + 1] = ((float)y + 0.5f) / (float)view->height;
            }
            for (int i = 0; i < 6; ++i) r->indices[6 * facets + i] = (uint32_t)(4 * facets) + triangles[i];
            ++facets;
        }
    return facets;
}

static ty_result add_relief(const screen_view* view, const relief* r, int64_t facets, ty_scene* scene) {
    ty_texture_def texture = ty_default_texture_def();
    ty_mesh_def mesh = ty_default_mesh_def();
    texture.image = view->surface;
    texture.nearest = true;
    ty_result result = ty_texture_create(ty_scene_context(scene), &texture, &mesh.material.emission_texture);
    if (result != TY_OK) return result;
    mesh.vertex_count = 4 * facets;
    mesh.triangle_count = 2 * facets;
    mesh.positions = r->positions;
    mesh.uv[0] = r->uv;
    mesh.indices = r->indices;
    for (int c = 0; c < 3; ++c) {
        mesh.material.albedo[c] = 0;
        mesh.material.emission[c] = 1;
    }
    result = ty_scene_add_mesh(scene, &mesh);
    ty_texture_release(mesh.material.emission_texture);
    return result;
}

static ty_result add_medium(const screen_view* view, const screen_water* water, ty_scene* scene) {
    if (water == NULL) return TY_OK;
    const ty_screen_def def = screen_room_def(view, water);
    ty_medium_def medium = ty_default_medium_def();
    medium.bounds = TY_BOUNDS_BOX;
    for (int c = 0; c < 3; ++c) {
        medium.box_min[c] = view->camera.position[c] - medium_reach;
        medium.box_max[c] = view->camera.position[c] + medium_reach;
    }
    memcpy(medium.sigma_s, def.sigma_s, sizeof medium.sigma_s);
    memcpy(medium.sigma_a, def.sigma_a, sizeof medium.sigma_a);
    memcpy(medium.g, def.g, sizeof medium.g);
    return ty_scene_add_medium(scene, &medium);
}

static ty_result fill_scene(const screen_view* view, const screen_water* water, ty_scene* scene) {
    const size_t pixels = (size_t)view->width * (size_t)view->height;
    relief r = {malloc(pixels * 12 * sizeof *r.positions), malloc(pixels * 8 * sizeof *r.uv),
                malloc(pixels * 6 * sizeof *r.indices)};
    ty_result result = TY_ERROR_MEMORY;
    if (r.positions != NULL && r.uv != NULL && r.indices != NULL) {
        const int64_t facets = fill_relief(view, &r);
        result = ty_scene_set_camera(scene, &view->camera);
        if (result == TY_OK) result = add_relief(view, &r, facets, scene);
        if (result == TY_OK) result = add_medium(view, water, scene);
        if (result == TY_OK) result = ty_scene_commit(scene);
    }
    free_relief(&r);
    return result;
}

ty_result screen_make_relief(figure_run* run, const screen_view* view, const screen_water* water, ty_scene** out) {
    ty_scene* scene = NULL;
    ty_result result = ty_scene_create(run->session->context, TY_AXIS_Y, &scene);
    if (result != TY_OK) return result;
    result = fill_scene(view, water, scene);
    if (result == TY_OK)
        *out = scene;
    else
        ty_scene_destroy(scene);
    return result;
}
