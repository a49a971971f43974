/* Properties of every model, whatever file it came from. */
#ifndef TY_TESTS_MODEL_CHECK_H
#define TY_TESTS_MODEL_CHECK_H

#include "io/meshes/model.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>

static inline bool all_within(const float* values, size_t count, float low, float high) {
    for (size_t i = 0; values != NULL && i < count; ++i)
        if (!(values[i] >= low && values[i] <= high)) return false;
    return true;
}

static inline bool mesh_is_whole(const ty_model* model, const ty_model_mesh* mesh) {
    const size_t count = mesh->vertex_count;
    for (size_t i = 0; i < 3 * mesh->triangle_count; ++i)
        if (mesh->indices[i] >= count) return false;
    return count > 0 && mesh->triangle_count > 0 && mesh->material >= -1 &&
           mesh->material < (int32_t)model->material_count &&
           all_within(mesh->positions, 3 * count, -FLT_MAX, FLT_MAX) &&
           all_within(mesh->normals, 3 * count, -1.0001f, 1.0001f) && all_within(mesh->colors, 4 * count, 0, 1) &&
           all_within(mesh->uv[0], 2 * count, -FLT_MAX, FLT_MAX) &&
           all_within(mesh->uv[1], 2 * count, -FLT_MAX, FLT_MAX);
}

static inline bool material_is_whole(const ty_model* model, const ty_model_material* material) {
    const ty_material_def* def = &material->def;
    return material->name != NULL && material->albedo_texture < (int32_t)model->texture_count &&
           material->emission_texture < (int32_t)model->texture_count && all_within(def->albedo, 3, 0, 1) &&
           all_within(&def->alpha, 1, 0, 1) && all_within(def->emission, 3, 0, 1.1e15f) && def->albedo_uv >= 0 &&
           def->albedo_uv < 2 && def->emission_uv >= 0 && def->emission_uv < 2;
}

static inline bool model_is_whole(const ty_model* model) {
    bool whole = true;
    for (size_t i = 0; i < model->mesh_count; ++i) whole = whole && mesh_is_whole(model, &model->meshes[i]);
    for (size_t i = 0; i < model->material_count; ++i) whole = whole && material_is_whole(model, &model->materials[i]);
    for (size_t i = 0; i < model->instance_count; ++i)
        whole = whole && model->instances[i].mesh >= 0 && model->instances[i].mesh < (int32_t)model->mesh_count;
    for (size_t i = 0; i < model->texture_count; ++i)
        whole = whole && model->textures[i].image < (int32_t)model->image_count;
    for (size_t i = 0; i < model->image_count; ++i)
        whole = whole && model->images[i].rgba8 != NULL && model->images[i].encoded == NULL;
    return whole;
}

#endif
