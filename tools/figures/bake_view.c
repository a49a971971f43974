/* Baked irradiance at the surfaces visible to a camera. */
#include "figures/bake_view.h"

#include "scene/camera.h"

#include <math.h>
#include <stdlib.h>

enum { SPP = 128, SPP_TRUTH = 512, SPP_QUICK = 8, SPP_TRUTH_QUICK = 32 };

int32_t bake_spp(const figure_run* run, bool truth) {
    const int32_t choice = run->options->quick ? (truth ? SPP_TRUTH_QUICK : SPP_QUICK) : (truth ? SPP_TRUTH : SPP);
    return truth ? figure_samples(run, choice) : choice;
}

/* ---- visible surfaces ---- */

static ty_result trace_camera(const ty_scene* scene, const int32_t size[2], ty_ray_hit** out, ty_ray** rays_out) {
    const ty_camera_def def = ty_scene_camera(scene);
    const ty_camera_view camera = ty_camera_get_view(&def, size[0], size[1]);
    const int64_t count = (int64_t)size[0] * size[1];
    ty_ray* rays = malloc((size_t)count * sizeof *rays);
    *out = malloc((size_t)count * sizeof **out);
    *rays_out = rays;
    if (rays == NULL || *out == NULL) return TY_ERROR_MEMORY;
    for (int64_t i = 0; i < count; ++i) {
        const ty_vec to = ty_camera_direction(&camera, (float)(i % size[0]) + 0.5f, (float)(i / size[0]) + 0.5f);
        rays[i] = (ty_ray){.origin = {camera.origin.x, camera.origin.y, camera.origin.z},
                           .direction = {to.x, to.y, to.z},
                           .far = INFINITY};
    }
    return ty_scene_trace(scene, rays, count, TY_RAYS_INCOHERENT, *out);
}

/* The side that the camera sees. */
static ty_bake_receiver receiver_at(const ty_ray_hit* hit, const ty_ray* ray) {
    ty_bake_receiver receiver = {.margin = hit->margin};
    const float cosine =
        hit->normal[0] * ray->direction[0] + hit->normal[1] * ray->direction[1] + hit->normal[2] * ray->direction[2];
    for (int a = 0; a < 3; ++a) {
        receiver.position[a] = hit->position[a];
        receiver.normal[a] = receiver.face[a] = cosine > 0 ? -hit->normal[a] : hit->normal[a];
    }
    return receiver;
}

static ty_result add_surfaces(const ty_ray_hit* hits, const ty_ray* rays, bake_view* view) {
    const int64_t pixels = (int64_t)view->size[0] * view->size[1];
    view->receivers = malloc((size_t)pixels * sizeof *view->receivers);
    if (view->receivers == NULL) return TY_ERROR_MEMORY;
    for (int64_t i = 0; i < pixels; ++i) {
        view->pixels[i] = (bake_pixel){.at = {-1, -1, -1}, .weight = {1, 0, 0}};
        if (hits[i].surface < 0) continue;
        for (int k = 0; k < 3; ++k) view->pixels[i].at[k] = view->count;
        view->receivers[view->count++] = receiver_at(&hits[i], &rays[i]);
    }
    return TY_OK;
}

/* Adds the vertices of a mesh that pixels need: numbers[v] becomes the receiver index of vertex v plus one. */
static ty_result add_mesh_vertices(const ty_scene* scene, int32_t number, int32_t first, const ty_ray_hit* hits,
                                   bake_view* view) {
    ty_mesh_def mesh;
    ty_result result = ty_scene_get_mesh(scene, number, &mesh);
    if (result != TY_OK) return result;
    ty_bake_receiver* all = malloc((size_t)mesh.vertex_count * sizeof *all);
    int64_t* numbers = calloc((size_t)mesh.vertex_count, sizeof *numbers);
    result = all == NULL || numbers == NULL ? TY_ERROR_MEMORY : ty_bake_vertices(scene, number, all);
    for (int64_t i = 0; i < (int64_t)view->size[0] * view->size[1] && result == TY_OK; ++i) {
        if (hits[i].surface != first + number) continue;
        bake_pixel* pixel = &view->pixels[i];
        *pixel = (bake_pixel){.weight = {1 - hits[i].b1 - hits[i].b2, hits[i].b1, hits[i].b2}};
        for (int k = 0; k < 3; ++k) {
            const uint32_t vertex = mesh.indices[3 * (size_t)hits[i].part + (size_t)k];
            if (numbers[vertex] == 0) {
                view->receivers[view->count] = all[vertex];
                numbers[vertex] = ++view->count;
            }
            pixel->at[k] = numbers[vertex] - 1;
        }
    }
    free(all);
    free(numbers);
    return result;
}

static ty_result add_vertices(const ty_scene* scene, const ty_ray_hit* hits, bake_view* view) {
    const int64_t pixels = (int64_t)view->size[0] * view->size[1];
    const ty_scene_info info = ty_scene_get_info(scene);
    ty_result result = TY_OK;
    view->receivers = malloc((size_t)pixels * 3 * sizeof *view->receivers);
    if (view->receivers == NULL) return TY_ERROR_MEMORY;
    for (int64_t i = 0; i < pixels; ++i) view->pixels[i] = (bake_pixel){.at = {-1, -1, -1}};
    for (int32_t mesh = 0; mesh < info.meshes && result == TY_OK; ++mesh)
        result = add_mesh_vertices(scene, mesh, info.shapes, hits, view);
    return result;
}

ty_result bake_view_create(const ty_scene* scene, const int32_t size[2], bool by_vertex, bake_view* out) {
    ty_ray_hit* hits = NULL;
    ty_ray* rays = NULL;
    *out = (bake_view){.size = {size[0], size[1]}};
    out->pixels = malloc((size_t)size[0] * (size_t)size[1] * sizeof *out->pixels);
    ty_result result = out->pixels == NULL ? TY_ERROR_MEMORY : trace_camera(scene, size, &hits, &rays);
    if (result == TY_OK) result = by_vertex ? add_vertices(scene, hits, out) : add_surfaces(hits, rays, out);
    free(hits);
    free(rays);
    return result;
}

void bake_view_free(bake_view* view) {
    free(view->pixels);
    free(view->receivers);
    *view = (bake_view){.count = 0};
}

/* ---- light ---- */

ty_result bake_view_light(figure_run* run, const char* item, const ty_scene* scene, const ty_bake_def* def,
                          const ty_bake_receiver* receivers, int64_t count, ty_bake_light** out, double* seconds) {
    ty_bake_def own = *def;
    ty_bake_stats stats = ty_default_bake_stats();
    ty_bake_light* light = calloc((size_t)count + 1, sizeof *light);
    own.seed += run->session->common.seed;
    own.progress = cli_progress_report;
    own.progress_user = &run->session->progress;
    ty_result result = light == NULL ? TY_ERROR_MEMORY : ty_bake_surfaces(scene, &own, receivers, count, light, &stats);
    if (result == TY_OK) figure_note(run, item, "time", "s", stats.seconds);
    *seconds = stats.seconds;
    if (result == TY_OK)
        *out = light;
    else
        free(light);
    return result;
}

static float component_of(const ty_bake_light* light, int c, bake_component component) {
    float sum = 0;
    for (int layer = component == BAKE_SCATTERED ? TY_BAKE_SINGLE : TY_BAKE_DIRECT; layer < TY_BAKE_LAYERS; ++layer)
        sum += light->irradiance[layer][c];
    return sum;
}

ty_result bake_view_image(figure_run* run, const bake_view* view, const ty_bake_light* light, bake_component component,
                          ty_image** out) {
    ty_image* image = NULL;
    const ty_result result = ty_image_create_rgb(run->session->context, view->size[0], view->size[1], &image);
    if (result != TY_OK) return result;
    for (int64_t i = 0; i < (int64_t)view->size[0] * view->size[1]; ++i)
        for (int c = 0; c < 3; ++c)
            for (int k = 0; k < 3 && view->pixels[i].at[0] >= 0; ++k)
                ty_image_plane(image, c)[i] +=
                    view->pixels[i].weight[k] * component_of(&light[view->pixels[i].at[k]], c, component);
    *out = image;
    return TY_OK;
}

bake_errors bake_compare(const ty_bake_light* light, const ty_bake_light* truth, int64_t count,
                         bake_component component) {
    double mean = 0, expected = 0, squares = 0, noise = 0;
    for (int64_t i = 0; i < count; ++i)
        for (int c = 0; c < 3; ++c) {
            const double a = (double)component_of(&light[i], c, component),
                         b = (double)component_of(&truth[i], c, component);
            mean += a;
            expected += b;
            squares += (a - b) * (a - b);
            noise += component == BAKE_ALL ? (double)truth[i].variance[c] : 0;
        }
    const double values = 3 * (double)count;
    return (bake_errors){mean / expected,
                         bench_without_noise(sqrt(squares / values), sqrt(noise / values)) / (expected / values)};
}

void bake_note_errors(figure_run* run, const char* item, const bake_errors* errors, bool checked) {
    figure_expect(run, item, "mean ratio", "1", errors->mean_ratio, checked ? 1 : NAN, checked ? 0.05 : NAN);
    figure_expect(run, item, "relative RMSE", "1", errors->relative_rmse, checked ? 0 : NAN, checked ? 0.08 : NAN);
}

void bake_write_errors(const char* what, const bake_errors* errors, char line[PLOT_LABEL_SIZE]) {
    char rmse[32] = "< noise";
    if (!isnan(errors->relative_rmse)) snprintf(rmse, sizeof rmse, "%.1f %%", 100 * errors->relative_rmse);
    snprintf(line, PLOT_LABEL_SIZE, "%.20s %.3f, RMSE %s", what, errors->mean_ratio, rmse);
}
