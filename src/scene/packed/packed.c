/* Packing: every array is copied as it is, every structure with its pointers exchanged for the device's, what it names
 * before itself. */
#include "scene/packed/packed.h"

#include "base/context.h"
#include "scene/media/spans.k.h"
#include "scene/surfaces/bvh.h"
#include "scene/surfaces/closed_mesh.h"
#include "scene/surfaces/shape.h"

#include <string.h>

_Static_assert(sizeof(void*) == sizeof(ty_address), "addresses stand in the place of pointers");

/* A packing under way. After the first failure nothing more is done. */
typedef struct packing {
    ty_packed_scene* packed;
    const ty_scene* scene;
    ty_address surfaces;
    ty_result result;
} packing;

/* ---- arrays ---- */

static ty_address find(const ty_packed_scene* packed, const void* from, size_t bytes) {
    for (size_t i = 0; i < packed->count; ++i)
        if (packed->arrays[i].from == from && packed->arrays[i].bytes == bytes) return packed->arrays[i].address;
    return 0;
}

/* Copies an array to the device; 0 for none. shared: it is an array of the scene's, which may be named again. */
static ty_address copy(packing* p, const void* from, size_t bytes, bool shared) {
    ty_packed_scene* packed = p->packed;
    const ty_device_backend* backend = packed->device->backend;
    if (p->result != TY_OK || from == NULL || bytes == 0) return 0;
    const ty_address known = shared ? find(packed, from, bytes) : 0;
    if (known != 0) return known;
    if (!ty_grow_array(packed->device->context, (void**)&packed->arrays, &packed->capacity, packed->count,
                       sizeof *packed->arrays)) {
        p->result = TY_ERROR_MEMORY;
        return 0;
    }
    ty_address address = 0;
    p->result = backend->alloc(packed->device, bytes, &address);
    if (p->result != TY_OK) return 0;
    packed->arrays[packed->count++] = (ty_packed_array){shared ? from : NULL, bytes, address};
    packed->bytes += bytes;
    p->result = backend->write(packed->device, address, from, bytes);
    return address;
}

/* Sets the pointer at `field` to an address. */
static void point(void* field, ty_address address) {
    memcpy(field, &address, sizeof address);
}

/* Exchanges the pointer at `field`, to an array of the scene's, for that of its copy. */
static void take(packing* p, void* field, size_t count, size_t element) {
    const void* from;
    memcpy(&from, field, sizeof from);
    point(field, copy(p, from, count * element, true));
}

/* ---- media ---- */

static size_t product(const int32_t size[3]) {
    return (size_t)size[0] * (size_t)size[1] * (size_t)size[2];
}

static void take_grid(packing* p, ty_grid_view* grid) {
    const size_t values = grid->table != NULL ? (size_t)grid->block_count * TY_GRID_BLOCK_VOXELS : product(grid->size);
    take(p, &grid->floats, values, sizeof(float));
    take(p, &grid->halves, values, sizeof(uint16_t));
    take(p, &grid->table, product(grid->table_size), sizeof *grid->table);
    take(p, &grid->extremes, 2 * product(grid->bricks), sizeof(float));
}

static void take_phase(packing* p, ty_medium_view* medium) {
    if (medium->phase == NULL) return;
    ty_phase_view phase = *medium->phase;
    for (int32_t i = 0; i < phase.count; ++i)
        take(p, &phase.terms[i].nodes, (size_t)phase.terms[i].node_count, sizeof *phase.terms[i].nodes);
    point(&medium->phase, copy(p, &phase, sizeof phase, false));
}

/* The hierarchy of a closed mesh that bounds a medium. */
static void take_shell(packing* p, ty_medium_view* medium) {
    if (medium->bounds != TY_BOUNDED_MESH || p->result != TY_OK) return;
    const ty_triangle_mesh* triangles = NULL;
    for (size_t i = 0; i < p->scene->medium_count; ++i)
        if (p->scene->media[i].shell != NULL && p->scene->media[i].shell->mesh == medium->shell)
            triangles = p->scene->media[i].shell->triangles;
    if (triangles == NULL) {
        p->result = ty_fail(p->scene->context, TY_ERROR_INTERNAL, "a medium's shell is not one of the scene's");
        return;
    }
    ty_bvh_data* data = NULL;
    p->result = ty_bvh_create_closed(p->scene->context, triangles, &data);
    if (p->result != TY_OK) return;
    ty_bvh bvh = data->bvh;
    point(&bvh.nodes, copy(p, data->nodes, data->node_count * sizeof *data->nodes, false));
    point(&bvh.primitives, copy(p, data->primitives, data->primitive_count * sizeof *data->primitives, false));
    ty_bvh_destroy(data);
    point(&medium->shell, copy(p, &bvh, sizeof bvh, false));
}

static void take_medium(packing* p, ty_medium_view* medium) {
    take(p, &medium->extremes, 2 * product(medium->grid.bricks), sizeof(float));
    take_grid(p, &medium->grid);
    take_shell(p, medium);
    take_phase(p, medium);
    take(p, &medium->transfer, (size_t)medium->transfer_count, sizeof *medium->transfer);
    for (int32_t c = 0; c < medium->albedo_fields; ++c) take_grid(p, &medium->albedo[c].grid);
    take_grid(p, &medium->g_field.grid);
    take_grid(p, &medium->temperature.grid);
    take(p, &medium->blackbody, 1, sizeof *medium->blackbody);
}

static ty_address take_media(packing* p, const ty_medium_view* media, int32_t count) {
    ty_context* context = p->scene->context;
    if (count > TY_DEVICE_MEDIA_MAX && p->result == TY_OK)
        p->result = ty_fail(context, TY_ERROR_UNSUPPORTED, "a device takes scenes of at most %d media, and this has %d",
                            TY_DEVICE_MEDIA_MAX, count);
    ty_address out = 0;
    if (count == 0 || p->result != TY_OK) return out;
    ty_medium_view* own = ty_alloc_array(context, (size_t)count, sizeof *own, false);
    if (own == NULL) {
        p->result = TY_ERROR_MEMORY;
        return out;
    }
    memcpy(own, media, (size_t)count * sizeof *own);
    for (int32_t i = 0; i < count; ++i) take_medium(p, &own[i]);
    out = copy(p, own, (size_t)count * sizeof *own, false);
    ty_free_array(context, own, (size_t)count, sizeof *own);
    return out;
}

static void take_interiors(packing* p, ty_scene_view* view) {
    ty_context* context = p->scene->context;
    const size_t count = (size_t)view->interior_count;
    if (count == 0 || p->result != TY_OK) return;
    ty_interior* own = ty_alloc_array(context, count, sizeof *own, false);
    if (own == NULL) {
        p->result = TY_ERROR_MEMORY;
        return;
    }
    memcpy(own, view->interiors, count * sizeof *own);
    for (size_t i = 0; i < count; ++i) point(&own[i].media, take_media(p, own[i].media, own[i].medium_count));
    point(&view->interiors, copy(p, own, count * sizeof *own, false));
    ty_free_array(context, own, count, sizeof *own);
}

/* ---- surfaces ---- */

static void take_texture(packing* p, ty_texture_view* texture) {
    const size_t numbers = 4 * (size_t)texture->width * (size_t)texture->height;
    take(p, &texture->rgba8, numbers, sizeof(uint8_t));
    take(p, &texture->floats, numbers, sizeof(float));
    take(p, &texture->decode, 256, sizeof(float));
}

static void take_gloss(packing* p, ty_surface* surface) {
    if (surface->gloss == NULL) return;
    ty_surface_gloss gloss = *surface->gloss;
    take(p, &gloss.tables, 1, sizeof *gloss.tables);
    for (int i = 0; i < TY_SURFACE_TEXTURES; ++i) take_texture(p, &gloss.textures[i]);
    point(&surface->gloss, copy(p, &gloss, sizeof gloss, false));
    p->packed->glossy = true;
}

/* mesh: NULL for shapes. */
static void take_surface(packing* p, ty_surface* surface, const ty_triangle_mesh* mesh) {
    const size_t vertices = mesh != NULL ? mesh->vertex_count : 0, triangles = mesh != NULL ? mesh->triangle_count : 0;
    take_texture(p, &surface->albedo_texture);
    take_texture(p, &surface->emission_texture);
    take(p, &surface->indices, 3 * triangles, sizeof(uint32_t));
    take(p, &surface->positions, 3 * vertices, sizeof(float));
    take(p, &surface->normals, 3 * vertices, sizeof(float));
    for (int i = 0; i < 2; ++i) take(p, &surface->uv[i], 2 * vertices, sizeof(float));
    take(p, &surface->colors, 4 * vertices, sizeof(float));
    take(p, &surface->lights, triangles, sizeof(int32_t));
    take(p, &surface->tangents, 4 * vertices, sizeof(float));
    take(p, &surface->faces, TY_SHAPE_FACES, sizeof *surface->faces);
    take_gloss(p, surface);
}

static void take_surfaces(packing* p, ty_scene_view* view) {
    const ty_committed_surfaces* surfaces = &p->scene->surfaces;
    ty_context* context = p->scene->context;
    if (surfaces->count == 0 || p->result != TY_OK) return;
    ty_surface* own = ty_alloc_array(context, surfaces->count, sizeof *own, false);
    if (own == NULL) {
        p->result = TY_ERROR_MEMORY;
        return;
    }
    memcpy(own, surfaces->surfaces, surfaces->count * sizeof *own);
    for (size_t i = 0; i < surfaces->count; ++i)
        take_surface(p, &own[i], i < surfaces->shape_count ? NULL : p->scene->meshes[i - surfaces->shape_count]);
    p->surfaces = copy(p, own, surfaces->count * sizeof *own, false);
    point(&view->surfaces, p->surfaces);
    ty_free_array(context, own, surfaces->count, sizeof *own);
}

static void take_hierarchy(packing* p, ty_scene_view* view) {
    const ty_committed_surfaces* surfaces = &p->scene->surfaces;
    const ty_accel_input input = {.shapes = surfaces->shapes,
                                  .shape_count = surfaces->shape_count,
                                  .meshes = p->scene->meshes,
                                  .mesh_count = p->scene->mesh_count,
                                  .surfaces = surfaces->surfaces};
    ty_bvh_data* data = NULL;
    if (view->mesh == NULL || p->result != TY_OK) return;
    p->result = ty_bvh_create(p->scene->context, &input, &data);
    if (p->result != TY_OK) return;
    ty_bvh bvh = data->bvh;
    point(&bvh.nodes, copy(p, data->nodes, data->node_count * sizeof *data->nodes, false));
    point(&bvh.primitives, copy(p, data->primitives, data->primitive_count * sizeof *data->primitives, false));
    point(&bvh.quads, copy(p, data->quads, data->quad_count * sizeof *data->quads, false));
    point(&bvh.spheres, copy(p, data->spheres, data->sphere_count * sizeof *data->spheres, false));
    point(&bvh.surfaces, p->surfaces + surfaces->shape_count * sizeof(ty_surface));
    ty_bvh_destroy(data);
    point(&view->mesh, copy(p, &bvh, sizeof bvh, false));
}

/* ---- lights ---- */

static void take_light(packing* p, ty_light_view* light) {
    ty_environment_view* map = &light->environment;
    if (light->textured != NULL)
        point(&light->textured,
              p->surfaces + (size_t)(light->textured - p->scene->surfaces.surfaces) * sizeof(ty_surface));
    if (light->kind != TY_KIND_ENVIRONMENT) return;
    take(p, &map->pixels, 3 * (size_t)map->width * (size_t)map->height, sizeof(float));
    take(p, &map->rows, (size_t)map->table_height + 1, sizeof(float));
    take(p, &map->columns, (size_t)map->table_height * ((size_t)map->table_width + 1), sizeof(float));
    take(p, &map->cells, (size_t)map->cells_width * (size_t)map->cells_height, sizeof *map->cells);
}

static void take_lights(packing* p, ty_light_set* set) {
    const ty_light_tree* tree = p->scene->committed_lights.tree;
    ty_context* context = p->scene->context;
    const size_t count = (size_t)set->count;
    if (count == 0 || p->result != TY_OK) return;
    ty_light_view* own = ty_alloc_array(context, count, sizeof *own, false);
    if (own == NULL) {
        p->result = TY_ERROR_MEMORY;
        return;
    }
    memcpy(own, set->lights, count * sizeof *own);
    for (size_t i = 0; i < count; ++i) take_light(p, &own[i]);
    point(&set->lights, copy(p, own, count * sizeof *own, false));
    ty_free_array(context, own, count, sizeof *own);
    take(p, &set->distant, (size_t)set->distant_count, sizeof *set->distant);
    take(p, &set->nodes, tree->node_count, sizeof *set->nodes);
    take(p, &set->trails, tree->light_count, sizeof *set->trails);
}

/* ---- scenes ---- */

ty_result ty_scene_pack(ty_device* device, const ty_scene* scene, const ty_scene_view* view, ty_packed_scene** out) {
    packing p = {.scene = scene};
    ty_scene_view own = *view;
    p.packed = ty_alloc_array(device->context, 1, sizeof *p.packed, true);
    if (p.packed == NULL) return TY_ERROR_MEMORY;
    p.packed->device = device;
    take_surfaces(&p, &own);
    take_hierarchy(&p, &own);
    take_lights(&p, &own.lights);
    point(&own.media, take_media(&p, own.media, own.medium_count));
    take_interiors(&p, &own);
    p.packed->view = copy(&p, &own, sizeof own, false);
    if (p.result == TY_OK)
        *out = p.packed;
    else
        ty_packed_scene_destroy(p.packed);
    return p.result;
}

void ty_packed_scene_destroy(ty_packed_scene* packed) {
    if (packed == NULL) return;
    ty_context* context = packed->device->context;
    for (size_t i = 0; i < packed->count; ++i) packed->device->backend->free(packed->device, packed->arrays[i].address);
    ty_free_array(context, packed->arrays, packed->capacity, sizeof *packed->arrays);
    ty_free_array(context, packed, 1, sizeof *packed);
}
