/* Packing: every array is copied as it is, every structure with its pointers exchanged for the device's, what it names
 * before itself. */
#include "scene/packed/packed.h"

#include "base/context.h"
#include "grid/grid.h"
#include "scene/media/medium.h"
#include "scene/media/spans.k.h"
#include "scene/surfaces/accel_kept.h"
#include "scene/surfaces/bvh.h"
#include "scene/surfaces/closed_mesh.h"
#include "scene/surfaces/shape.h"

#include <string.h>

/* A packing under way. After the first failure nothing more is done. */
typedef struct packing {
    ty_packed_scene* packed;
    ty_device_arrays* arrays;
    const ty_scene* scene;
    ty_address surfaces;
} packing;

/* ---- media ---- */

static size_t product(const int32_t size[3]) {
    return (size_t)size[0] * (size_t)size[1] * (size_t)size[2];
}

static void* retain_grid(void* grid) {
    return ty_grid_retain(grid);
}

static void release_grid(void* grid) {
    ty_grid_release(grid);
}

/* The grid among those of the scene's media that has these values; its address tells it from others while it lives. */
static const ty_device_origin* find_grid(const packing* p, const void* values, ty_device_origin* origin) {
    ty_grid* grids[TY_MEDIUM_GRIDS];
    for (size_t i = 0; i < p->scene->medium_count; ++i) {
        ty_medium_grids(&p->scene->media[i], grids);
        for (int k = 0; k < TY_MEDIUM_GRIDS; ++k) {
            if (grids[k] == NULL || grids[k]->values != values) continue;
            *origin = (ty_device_origin){(uintptr_t)grids[k], release_grid, retain_grid, grids[k]};
            return origin;
        }
    }
    return NULL;
}

static void take_grid(packing* p, ty_grid_view* grid) {
    const size_t values = grid->table != NULL ? (size_t)grid->block_count * TY_GRID_BLOCK_VOXELS : product(grid->size);
    const void* stored = grid->floats != NULL ? (const void*)grid->floats : grid->halves;
    ty_device_origin own;
    const ty_device_origin* origin = stored != NULL ? find_grid(p, stored, &own) : NULL;
    ty_device_take_from(p->arrays, &grid->floats, values, sizeof(float), origin);
    ty_device_take_from(p->arrays, &grid->halves, values, sizeof(uint16_t), origin);
    ty_device_take_from(p->arrays, &grid->table, product(grid->table_size), sizeof *grid->table, origin);
    ty_device_take_from(p->arrays, &grid->extremes, 2 * product(grid->bricks), sizeof(float), origin);
}

static void take_phase(packing* p, ty_medium_view* medium) {
    if (medium->phase == NULL) return;
    ty_phase_view phase = *medium->phase;
    for (int32_t i = 0; i < phase.count; ++i)
        ty_device_take(p->arrays, &phase.terms[i].nodes, (size_t)phase.terms[i].node_count,
                       sizeof *phase.terms[i].nodes);
    ty_device_point(&medium->phase, ty_device_place_constant(p->arrays, &phase, sizeof phase));
}

/* ---- hierarchies ---- */

/* A hierarchy with the device's pointers, but for its surfaces. */
static ty_bvh take_bvh(packing* p, const ty_bvh_data* data, const ty_device_origin* origin) {
    ty_bvh bvh = data->bvh;
    ty_device_take_from(p->arrays, &bvh.nodes, data->node_count, sizeof *data->nodes, origin);
    ty_device_take_from(p->arrays, &bvh.primitives, data->primitive_count, sizeof *data->primitives, origin);
    ty_device_take_from(p->arrays, &bvh.quads, data->quad_count, sizeof *data->quads, origin);
    ty_device_take_from(p->arrays, &bvh.spheres, data->sphere_count, sizeof *data->spheres, origin);
    return bvh;
}

/* Of the same surfaces as `accel`, which keeps it for the next time if the device keeps arrays. */
static ty_bvh place_bvh(packing* p, ty_accel* accel, const ty_accel_input* input, const ty_triangle_mesh* closed) {
    ty_context* context = p->scene->context;
    const bool keeps = p->arrays->device->keep > 0;
    ty_bvh_data *own = NULL, **data = keeps ? ty_accel_hierarchy(accel) : &own;
    ty_bvh bvh = {.nodes = NULL};
    const ty_device_origin origin = {.version = ty_accel_version(accel)};
    if (*data == NULL)
        p->arrays->result =
            closed != NULL ? ty_bvh_create_closed(context, closed, data) : ty_bvh_create(context, input, data);
    if (p->arrays->result == TY_OK) bvh = take_bvh(p, *data, keeps ? &origin : NULL);
    ty_bvh_destroy(own);
    return bvh;
}

/* The hierarchy of a closed mesh that bounds a medium. */
static void take_shell(packing* p, ty_medium_view* medium) {
    if (medium->bounds != TY_BOUNDED_MESH || p->arrays->result != TY_OK) return;
    ty_closed_mesh* closed = NULL;
    for (size_t i = 0; i < p->scene->medium_count; ++i)
        if (p->scene->media[i].shell != NULL && p->scene->media[i].shell->mesh == medium->shell)
            closed = p->scene->media[i].shell;
    if (closed == NULL) {
        p->arrays->result = ty_fail(p->scene->context, TY_ERROR_INTERNAL, "a medium's shell is not one of the scene's");
        return;
    }
    const ty_bvh bvh = place_bvh(p, closed->mesh, NULL, closed->triangles);
    ty_device_point(&medium->shell, ty_device_place_constant(p->arrays, &bvh, sizeof bvh));
}

static void take_medium(packing* p, ty_medium_view* medium) {
    take_grid(p, &medium->grid);
    ty_device_take(p->arrays, &medium->extremes, 2 * product(medium->grid.bricks), sizeof(float));
    take_shell(p, medium);
    take_phase(p, medium);
    ty_device_take(p->arrays, &medium->transfer, (size_t)medium->transfer_count, sizeof *medium->transfer);
    for (int32_t c = 0; c < medium->albedo_fields; ++c) take_grid(p, &medium->albedo[c].grid);
    take_grid(p, &medium->g_field.grid);
    take_grid(p, &medium->temperature.grid);
    ty_device_take(p->arrays, &medium->blackbody, 1, sizeof *medium->blackbody);
}

static ty_address take_media(packing* p, const ty_medium_view* media, int32_t count) {
    ty_context* context = p->scene->context;
    if (count > TY_DEVICE_MEDIA_MAX && p->arrays->result == TY_OK)
        p->arrays->result =
            ty_fail(context, TY_ERROR_UNSUPPORTED, "a device takes scenes of at most %d media, and this has %d",
                    TY_DEVICE_MEDIA_MAX, count);
    ty_address out = 0;
    if (count == 0 || p->arrays->result != TY_OK) return out;
    ty_medium_view* own = ty_alloc_array(context, (size_t)count, sizeof *own, false);
    if (own == NULL) {
        p->arrays->result = TY_ERROR_MEMORY;
        return out;
    }
    memcpy(own, media, (size_t)count * sizeof *own);
    for (int32_t i = 0; i < count; ++i) take_medium(p, &own[i]);
    out = ty_device_place_constant(p->arrays, own, (size_t)count * sizeof *own);
    ty_free_array(context, own, (size_t)count, sizeof *own);
    return out;
}

static void take_interiors(packing* p, ty_scene_view* view) {
    ty_context* context = p->scene->context;
    const size_t count = (size_t)view->interior_count;
    if (count == 0 || p->arrays->result != TY_OK) return;
    ty_interior* own = ty_alloc_array(context, count, sizeof *own, false);
    if (own == NULL) {
        p->arrays->result = TY_ERROR_MEMORY;
        return;
    }
    memcpy(own, view->interiors, count * sizeof *own);
    for (size_t i = 0; i < count; ++i) ty_device_point(&own[i].media, take_media(p, own[i].media, own[i].medium_count));
    ty_device_point(&view->interiors, ty_device_place_constant(p->arrays, own, count * sizeof *own));
    ty_free_array(context, own, count, sizeof *own);
}

/* ---- surfaces ---- */

static void take_texture(packing* p, ty_texture_view* texture, const ty_device_origin* origin) {
    const size_t numbers = 4 * (size_t)texture->width * (size_t)texture->height;
    ty_device_take_from(p->arrays, &texture->rgba8, numbers, sizeof(uint8_t), origin);
    ty_device_take_from(p->arrays, &texture->floats, numbers, sizeof(float), origin);
    ty_device_take(p->arrays, &texture->decode, 256, sizeof(float));
}

static void take_gloss(packing* p, ty_surface* surface, const ty_device_origin* origin) {
    if (surface->gloss == NULL) return;
    ty_surface_gloss gloss = *surface->gloss;
    ty_device_take(p->arrays, &gloss.tables, 1, sizeof *gloss.tables);
    for (int i = 0; i < TY_SURFACE_TEXTURES; ++i) take_texture(p, &gloss.textures[i], origin);
    ty_device_point(&surface->gloss, ty_device_place_constant(p->arrays, &gloss, sizeof gloss));
    p->packed->glossy = true;
}

/* mesh: NULL for shapes. Meshes live as long as the scene's acceleration structure, with their textures; those of
 * shapes may be exchanged. */
static void take_surface(packing* p, ty_surface* surface, const ty_triangle_mesh* mesh) {
    const size_t vertices = mesh != NULL ? mesh->vertex_count : 0, triangles = mesh != NULL ? mesh->triangle_count : 0;
    const ty_device_origin of_scene = {.version = ty_accel_version(p->scene->surfaces.accel)};
    const ty_device_origin* origin = mesh != NULL ? &of_scene : NULL;
    take_texture(p, &surface->albedo_texture, origin);
    take_texture(p, &surface->emission_texture, origin);
    ty_device_take_from(p->arrays, &surface->indices, 3 * triangles, sizeof(uint32_t), origin);
    ty_device_take_from(p->arrays, &surface->positions, 3 * vertices, sizeof(float), origin);
    ty_device_take_from(p->arrays, &surface->normals, 3 * vertices, sizeof(float), origin);
    for (int i = 0; i < 2; ++i) ty_device_take_from(p->arrays, &surface->uv[i], 2 * vertices, sizeof(float), origin);
    ty_device_take_from(p->arrays, &surface->colors, 4 * vertices, sizeof(float), origin);
    ty_device_take(p->arrays, &surface->lights, triangles, sizeof(int32_t));
    ty_device_take_from(p->arrays, &surface->tangents, 4 * vertices, sizeof(float), origin);
    ty_device_take(p->arrays, &surface->faces, TY_SHAPE_FACES, sizeof *surface->faces);
    take_gloss(p, surface, origin);
}

static void take_surfaces(packing* p, ty_scene_view* view) {
    const ty_committed_surfaces* surfaces = &p->scene->surfaces;
    ty_context* context = p->scene->context;
    if (surfaces->count == 0 || p->arrays->result != TY_OK) return;
    ty_surface* own = ty_alloc_array(context, surfaces->count, sizeof *own, false);
    if (own == NULL) {
        p->arrays->result = TY_ERROR_MEMORY;
        return;
    }
    memcpy(own, surfaces->surfaces, surfaces->count * sizeof *own);
    for (size_t i = 0; i < surfaces->count; ++i)
        take_surface(p, &own[i], i < surfaces->shape_count ? NULL : p->scene->meshes[i - surfaces->shape_count]);
    p->surfaces = ty_device_place_constant(p->arrays, own, surfaces->count * sizeof *own);
    ty_device_point(&view->surfaces, p->surfaces);
    ty_free_array(context, own, surfaces->count, sizeof *own);
}

static void take_hierarchy(packing* p, ty_scene_view* view) {
    const ty_committed_surfaces* surfaces = &p->scene->surfaces;
    const ty_accel_input input = {.shapes = surfaces->shapes,
                                  .shape_count = surfaces->shape_count,
                                  .meshes = p->scene->meshes,
                                  .mesh_count = p->scene->mesh_count,
                                  .surfaces = surfaces->surfaces};
    if (view->mesh == NULL || p->arrays->result != TY_OK) return;
    ty_bvh bvh = place_bvh(p, surfaces->accel, &input, NULL);
    ty_device_point(&bvh.surfaces, p->surfaces + surfaces->shape_count * sizeof(ty_surface));
    ty_device_point(&view->mesh, ty_device_place_constant(p->arrays, &bvh, sizeof bvh));
}

/* ---- lights ---- */

static void take_light(packing* p, ty_light_view* light) {
    ty_environment_view* map = &light->environment;
    if (light->textured != NULL)
        ty_device_point(&light->textured,
                        p->surfaces + (size_t)(light->textured - p->scene->surfaces.surfaces) * sizeof(ty_surface));
    if (light->kind != TY_KIND_ENVIRONMENT) return;
    ty_device_take(p->arrays, &map->pixels, 3 * (size_t)map->width * (size_t)map->height, sizeof(float));
    ty_device_take(p->arrays, &map->rows, (size_t)map->table_height + 1, sizeof(float));
    ty_device_take(p->arrays, &map->columns, (size_t)map->table_height * ((size_t)map->table_width + 1), sizeof(float));
    ty_device_take(p->arrays, &map->cells, (size_t)map->cells_width * (size_t)map->cells_height, sizeof *map->cells);
}

static void take_lights(packing* p, ty_light_set* set) {
    const ty_light_tree* tree = p->scene->committed_lights.tree;
    ty_context* context = p->scene->context;
    const size_t count = (size_t)set->count;
    if (count == 0 || p->arrays->result != TY_OK) return;
    ty_light_view* own = ty_alloc_array(context, count, sizeof *own, false);
    if (own == NULL) {
        p->arrays->result = TY_ERROR_MEMORY;
        return;
    }
    memcpy(own, set->lights, count * sizeof *own);
    for (size_t i = 0; i < count; ++i) take_light(p, &own[i]);
    ty_device_point(&set->lights, ty_device_place_constant(p->arrays, own, count * sizeof *own));
    ty_free_array(context, own, count, sizeof *own);
    ty_device_take(p->arrays, &set->distant, (size_t)set->distant_count, sizeof *set->distant);
    ty_device_take(p->arrays, &set->nodes, tree->node_count, sizeof *set->nodes);
    ty_device_take(p->arrays, &set->trails, tree->light_count, sizeof *set->trails);
}

/* ---- scenes ---- */

ty_result ty_scene_pack(ty_device* device, const ty_scene* scene, const ty_scene_view* view, ty_packed_scene** out) {
    ty_packed_scene* packed = ty_alloc_array(device->context, 1, sizeof *packed, true);
    packing p = {.packed = packed, .scene = scene};
    ty_scene_view own = *view;
    if (packed == NULL) return TY_ERROR_MEMORY;
    packed->arrays.device = device;
    p.arrays = &packed->arrays;
    take_surfaces(&p, &own);
    take_hierarchy(&p, &own);
    take_lights(&p, &own.lights);
    ty_device_point(&own.media, take_media(&p, own.media, own.medium_count));
    take_interiors(&p, &own);
    packed->view = ty_device_place_constant(p.arrays, &own, sizeof own);
    const ty_result result = packed->arrays.result;
    if (result == TY_OK)
        *out = packed;
    else
        ty_packed_scene_destroy(packed);
    return result;
}

void ty_packed_scene_destroy(ty_packed_scene* packed) {
    if (packed == NULL) return;
    ty_device_free(&packed->arrays);
    ty_free_array(packed->arrays.device->context, packed, 1, sizeof *packed);
}
