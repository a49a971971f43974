/* Meshes: checks, and copies in world space. */
#include "scene/surfaces/triangle_mesh.h"

#include "base/context.h"
#include "base/check.h"
#include "scene/surfaces/gloss.h"
#include "scene/surfaces/texture.h"

void ty_init_material_def(void* def, size_t bytes) {
    const ty_material_def own = {.albedo = {0.5f, 0.5f, 0.5f},
                                 .alpha = 1,
                                 .albedo_map = {1, 0, 0, 0, 1, 0},
                                 .emission_map = {1, 0, 0, 0, 1, 0},
                                 .alpha_cutoff = 0.5f,
                                 .gloss = ty_default_gloss()};
    ty_init_def(def, bytes, &own, sizeof own);
}

void ty_init_mesh_def(void* def, size_t bytes) {
    const ty_mesh_def own = {
        .transform = ty_affine_identity(), .material = ty_default_material_def(), .origin = {.node = -1}};
    ty_init_def(def, bytes, &own, sizeof own);
}

static ty_result check_map(ty_context* context, const char* field, const float map[6]) {
    for (int i = 0; i < 6; ++i)
        if (!(fabsf(map[i]) <= 1e9f))
            return ty_fail(context, TY_ERROR_ARGUMENT, "%s[%d]: %g is outside [-1e9, 1e9]", field, i, (double)map[i]);
    return TY_OK;
}

static ty_result check_material(ty_context* context, const ty_material_def* def) {
    ty_material_def own = ty_default_material_def();
    ty_result result = ty_take_def(context, def, "ty_default_material_def", &own, sizeof own);
    if (result == TY_OK) result = ty_check_rgb(context, "material.albedo", def->albedo, 0, 1);
    if (result == TY_OK) result = ty_check_rgb(context, "material.emission", def->emission, 0, TY_COLOR_MAX);
    if (result == TY_OK) result = ty_check_number(context, "material.alpha", (double)def->alpha, 0, 1);
    if (result == TY_OK) result = ty_check_number(context, "material.alpha_cutoff", (double)def->alpha_cutoff, 0, 1);
    if (result == TY_OK) result = check_map(context, "material.albedo_map", def->albedo_map);
    if (result == TY_OK) result = check_map(context, "material.emission_map", def->emission_map);
    if (result == TY_OK) result = ty_check_number(context, "material.albedo_uv", def->albedo_uv, 0, 1);
    if (result == TY_OK) result = ty_check_number(context, "material.emission_uv", def->emission_uv, 0, 1);
    if (result == TY_OK) result = ty_check_number(context, "material.alpha_mode", def->alpha_mode, 0, TY_ALPHA_BLEND);
    if (result == TY_OK) result = ty_gloss_check(context, "material.gloss", &def->gloss);
    return result;
}

ty_result ty_triangle_mesh_check(ty_context* context, const char* what, const float* positions, int64_t vertex_count,
                                 const uint32_t* indices, int64_t triangle_count) {
    if (vertex_count < 1 || triangle_count < 1 || vertex_count > INT32_MAX || triangle_count > INT32_MAX)
        return ty_fail(context, TY_ERROR_ARGUMENT, "%s: %lld vertices and %lld triangles are not both in 1..2^31 - 1",
                       what, (long long)vertex_count, (long long)triangle_count);
    if (positions == NULL || indices == NULL)
        return ty_fail(context, TY_ERROR_ARGUMENT, "%s: positions or indices are NULL", what);
    for (int64_t i = 0; i < 3 * triangle_count; ++i)
        if (indices[i] >= (uint64_t)vertex_count)
            return ty_fail(context, TY_ERROR_ARGUMENT, "%s: indices[%lld] is %u, and there are %lld vertices", what,
                           (long long)i, indices[i], (long long)vertex_count);
    for (int64_t i = 0; i < 3 * vertex_count; ++i)
        if (!(fabsf(positions[i]) <= 1e15f))
            return ty_fail(context, TY_ERROR_ARGUMENT, "%s: the position of vertex %lld is outside [-1e15, 1e15]", what,
                           (long long)(i / 3));
    return TY_OK;
}

static ty_result check_mesh(ty_context* context, const ty_mesh_def** given, ty_mesh_def* own) {
    *own = ty_default_mesh_def();
    ty_result result = ty_take_def(context, *given, "ty_default_mesh_def", own, sizeof *own);
    const ty_mesh_def* def = *given = own;
    if (result == TY_OK) result = ty_check_affine(context, "mesh.transform", &def->transform);
    if (result == TY_OK) result = check_material(context, &def->material);
    if (result != TY_OK) return result;
    return ty_triangle_mesh_check(context, "mesh", def->positions, def->vertex_count, def->indices,
                                  def->triangle_count);
}

/* Normals transform by the inverse transpose; non-finite ones become 0, which counts as none. */
static void map_normals(const ty_affine* map, const float* in, size_t count, float* out) {
    ty_affine inverse;
    ty_affine_invert(map, &inverse);
    for (size_t i = 0; i < count; ++i) {
        double n[3], length = 0;
        for (int r = 0; r < 3; ++r) {
            n[r] = 0;
            for (int c = 0; c < 3; ++c) n[r] += inverse.m[4 * c + r] * (double)in[3 * i + (size_t)c];
            length += n[r] * n[r];
        }
        const double scale = isfinite(length) && length > 0 ? 1 / sqrt(length) : 0;
        for (int r = 0; r < 3; ++r) out[3 * i + (size_t)r] = scale > 0 ? (float)(n[r] * scale) : 0;
    }
}

/* Tangents transform as differences of positions; maps with negative determinant change the bitangent's sign. */
static void map_tangents(const ty_affine* map, double determinant, size_t count, float* tangents) {
    for (size_t i = 0; i < count; ++i) {
        float* t = tangents + 4 * i;
        double mapped[3], length = 0;
        for (int r = 0; r < 3; ++r) {
            const double* row = map->m + 4 * r;
            mapped[r] = row[0] * (double)t[0] + row[1] * (double)t[1] + row[2] * (double)t[2];
            length += mapped[r] * mapped[r];
        }
        const double scale = isfinite(length) && length > 0 ? 1 / sqrt(length) : 0;
        for (int r = 0; r < 3; ++r) t[r] = scale > 0 ? (float)(mapped[r] * scale) : 0;
        if (determinant < 0) t[3] = -t[3];
    }
}

static void map_positions(const ty_affine* map, const float* in, ty_triangle_mesh* out) {
    for (size_t i = 0; i < out->vertex_count; ++i) {
        const double point[3] = {in[3 * i], in[3 * i + 1], in[3 * i + 2]};
        double mapped[3];
        ty_affine_point(map, point, mapped);
        for (size_t a = 0; a < 3; ++a) {
            out->positions[3 * i + a] = (float)mapped[a];
            out->lower[a] = fmin(out->lower[a], mapped[a]);
            out->upper[a] = fmax(out->upper[a], mapped[a]);
        }
    }
}

static double determinant_of(const ty_affine* map) {
    const double* m = map->m;
    return m[0] * (m[5] * m[10] - m[6] * m[9]) - m[1] * (m[4] * m[10] - m[6] * m[8]) +
           m[2] * (m[4] * m[9] - m[5] * m[8]);
}

/* Maps with negative determinant flip the orientation of triangles; swapping two corners restores it. */
static void copy_indices(const ty_mesh_def* def, uint32_t* out) {
    const size_t second = determinant_of(&def->transform) < 0 ? 2 : 1;
    for (size_t i = 0; i < (size_t)def->triangle_count; ++i) {
        out[3 * i] = def->indices[3 * i];
        out[3 * i + 1] = def->indices[3 * i + second];
        out[3 * i + 2] = def->indices[3 * i + 3 - second];
    }
}

/* Copy of per-vertex values clamped to [low, high], with non-finite ones as low; *failed stays true. */
static float* copy_values(ty_context* context, const float* in, size_t count, float low, float high, bool* failed) {
    if (in == NULL || *failed) return NULL;
    float* out = ty_alloc_array(context, count, sizeof *out, false);
    if (out == NULL) *failed = true;
    for (size_t i = 0; i < count && out != NULL; ++i) out[i] = in[i] > low ? fminf(in[i], high) : low;
    return out;
}

/* NULL strings stay NULL; false: allocation failure. */
static bool copy_origin(ty_context* context, const ty_mesh_origin* in, ty_mesh_origin* out) {
    *out = *in;
    out->file = in->file == NULL ? NULL : ty_copy_text(context, in->file);
    out->name = in->name == NULL ? NULL : ty_copy_text(context, in->name);
    return (out->file == NULL) == (in->file == NULL) && (out->name == NULL) == (in->name == NULL);
}

ty_result ty_triangle_mesh_create(ty_context* context, const ty_mesh_def* def, ty_triangle_mesh** out) {
    ty_mesh_def own;
    const ty_result result = check_mesh(context, &def, &own);
    if (result != TY_OK) return result;
    ty_triangle_mesh* t = ty_alloc_array(context, 1, sizeof *t, true);
    if (t == NULL) return TY_ERROR_MEMORY;
    const size_t vertices = (size_t)def->vertex_count, triangles = (size_t)def->triangle_count;
    t->vertex_count = vertices;
    t->triangle_count = triangles;
    t->material = def->material;
    ty_texture_retain(t->material.albedo_texture);
    ty_texture_retain(t->material.emission_texture);
    ty_gloss_retain(&t->material.gloss);
    for (int a = 0; a < 3; ++a) {
        t->lower[a] = INFINITY;
        t->upper[a] = -INFINITY;
    }
    t->positions = ty_alloc_array(context, 3 * vertices + 1, sizeof(float), true);
    t->indices = ty_alloc_array(context, 3 * triangles, sizeof(uint32_t), false);
    bool failed = !copy_origin(context, &def->origin, &t->origin) || t->positions == NULL || t->indices == NULL;
    if (!failed && def->normals != NULL) {
        t->normals = ty_alloc_array(context, 3 * vertices, sizeof(float), false);
        failed = t->normals == NULL;
    }
    for (int set = 0; set < 2; ++set)
        t->uv[set] = copy_values(context, def->uv[set], 2 * vertices, -1e9f, 1e9f, &failed);
    t->colors = copy_values(context, def->colors, 4 * vertices, 0, 1, &failed);
    if (def->material.gloss.textures[TY_GLOSS_NORMAL].texture != NULL ||
        def->material.gloss.textures[TY_GLOSS_CLEARCOAT_NORMAL].texture != NULL)
        t->tangents = copy_values(context, def->tangents, 4 * vertices, -1, 1, &failed);
    if (failed) {
        ty_triangle_mesh_destroy(context, t);
        return TY_ERROR_MEMORY;
    }
    map_positions(&def->transform, def->positions, t);
    for (int a = 0; a < 3; ++a)
        if (!(t->lower[a] >= -1e15 && t->upper[a] <= 1e15)) {
            ty_triangle_mesh_destroy(context, t);
            return ty_fail(context, TY_ERROR_ARGUMENT, "mesh: its transform takes it outside [-1e15, 1e15]");
        }
    if (t->normals != NULL) map_normals(&def->transform, def->normals, vertices, t->normals);
    if (t->tangents != NULL) map_tangents(&def->transform, determinant_of(&def->transform), vertices, t->tangents);
    copy_indices(def, t->indices);
    *out = t;
    return TY_OK;
}

void ty_triangle_mesh_destroy(ty_context* context, ty_triangle_mesh* t) {
    if (t == NULL) return;
    ty_free_array(context, t->positions, 3 * t->vertex_count + 1, sizeof(float));
    ty_free_array(context, t->normals, 3 * t->vertex_count, sizeof(float));
    for (int set = 0; set < 2; ++set) ty_free_array(context, t->uv[set], 2 * t->vertex_count, sizeof(float));
    ty_free_array(context, t->colors, 4 * t->vertex_count, sizeof(float));
    ty_free_array(context, t->tangents, 4 * t->vertex_count, sizeof(float));
    ty_free_array(context, t->indices, 3 * t->triangle_count, sizeof(uint32_t));
    ty_texture_release(t->material.albedo_texture);
    ty_texture_release(t->material.emission_texture);
    ty_gloss_release(&t->material.gloss);
    ty_free_text(context, (char*)t->origin.file);
    ty_free_text(context, (char*)t->origin.name);
    ty_free_array(context, t, 1, sizeof *t);
}

size_t ty_triangle_mesh_bytes(const ty_triangle_mesh* t) {
    const size_t floats = 3 + (t->normals != NULL ? 3u : 0u) + (t->uv[0] != NULL ? 2u : 0u) +
                          (t->uv[1] != NULL ? 2u : 0u) + (t->colors != NULL ? 4u : 0u) +
                          (t->tangents != NULL ? 4u : 0u);
    return sizeof *t + floats * sizeof(float) * t->vertex_count + 3 * sizeof(uint32_t) * t->triangle_count;
}

bool ty_triangle_mesh_emits(const ty_triangle_mesh* t) {
    return t->material.emission[0] > 0 || t->material.emission[1] > 0 || t->material.emission[2] > 0;
}

ty_surface ty_triangle_mesh_get_surface(const ty_triangle_mesh* t) {
    const ty_material_def* material = &t->material;
    ty_surface surface;
    memset(&surface, 0, sizeof surface);
    memcpy(surface.albedo, material->albedo, sizeof surface.albedo);
    memcpy(surface.emission, material->emission, sizeof surface.emission);
    surface.first_light = -1;
    surface.two_sided = material->double_sided;
    surface.alpha_mode = (int32_t)material->alpha_mode;
    surface.alpha = material->alpha;
    surface.cutoff = material->alpha_cutoff;
    surface.albedo_texture = ty_texture_get_view(material->albedo_texture);
    surface.emission_texture = ty_texture_get_view(material->emission_texture);
    surface.albedo_uv = material->albedo_uv;
    surface.emission_uv = material->emission_uv;
    memcpy(surface.albedo_map, material->albedo_map, sizeof surface.albedo_map);
    memcpy(surface.emission_map, material->emission_map, sizeof surface.emission_map);
    surface.indices = t->indices;
    surface.positions = t->positions;
    surface.normals = t->normals;
    surface.uv[0] = t->uv[0];
    surface.uv[1] = t->uv[1];
    surface.colors = t->colors;
    surface.tangents = t->tangents;
    return surface;
}

void ty_closed_triangle_bounds(const ty_triangle_mesh* triangles, size_t triangle, float low[3], float high[3]) {
    for (int a = 0; a < 3; ++a) {
        low[a] = TY_FLOAT_MAX;
        high[a] = -TY_FLOAT_MAX;
    }
    for (size_t corner = 0; corner < 3; ++corner)
        for (size_t a = 0; a < 3; ++a) {
            const float value = triangles->positions[3 * (size_t)triangles->indices[3 * triangle + corner] + a];
            low[a] = ty_minf(low[a], value);
            high[a] = ty_maxf(high[a], value);
        }
    const float size = ty_maxf(high[0] - low[0], ty_maxf(high[1] - low[1], high[2] - low[2]));
    for (int a = 0; a < 3; ++a) {
        const float padding = 1e-6f * (size + ty_maxf(fabsf(low[a]), fabsf(high[a])));
        low[a] = low[a] - padding;
        high[a] = high[a] + padding;
    }
}
