/* Lightmaps: validation of a mesh's second texture coordinates, the size of its map, and the receivers of its texels.
 */
#include "bake/atlas/atlas.h"

#include "base/context.h"
#include "base/check.h"
#include "scene/surfaces/accel.h"

#include <math.h>
#include <stdio.h>

enum { SIDE_MIN = 4, SIDE_MAX = 16384, SIDE_OF_DENSITY_MAX = 4096, SIDE_STEP = 4, PADDING_MAX = 64 };

/* Tolerance of coordinates outside 0..1 against rounding: half a texel of 4096. */
static const float coordinate_tolerance = 1.25e-4f;
/* Fraction of texels that may be covered by two charts before a map is rejected. */
static const double overlap_tolerance = 1e-3;

enum { NAME_SIZE = 160 };

/* Properties of a mesh before its map is rasterised. */
typedef struct mesh_survey {
    ty_mesh_def mesh;
    char name[NAME_SIZE];
    int64_t outside;               /* triangles */
    float lower[2], upper[2];      /* bounds of the coordinates */
    double surface_area, map_area; /* m^2; of the unit square */
} mesh_survey;

void ty_init_atlas_def(void* def, size_t bytes) {
    const ty_atlas_def own = {.density = 8, .padding = 4, .close_seams = true};
    ty_init_def(def, bytes, &own, sizeof own);
}

static ty_result check_side(ty_context* context, const char* field, int32_t side) {
    return side == 0 ? TY_OK : ty_check_number(context, field, side, SIDE_MIN, SIDE_MAX);
}

static ty_result check_atlas_def(ty_context* context, const ty_atlas_def** given, ty_atlas_def* own) {
    *own = ty_default_atlas_def();
    ty_result result = ty_take_def(context, *given, "ty_default_atlas_def", own, sizeof *own);
    const ty_atlas_def* def = *given = own;
    if (result == TY_OK) result = check_side(context, "atlas.width", def->width);
    if (result == TY_OK) result = check_side(context, "atlas.height", def->height);
    if (result == TY_OK) result = ty_check_number(context, "atlas.padding", def->padding, 0, PADDING_MAX);
    if (result == TY_OK && !(def->density > 0 && isfinite(def->density)))
        result = ty_fail(context, TY_ERROR_ARGUMENT, "atlas.density: %g is not above 0", def->density);
    return result;
}

/* ---- mesh survey ---- */

static void survey_triangle(mesh_survey* survey, size_t triangle) {
    const ty_mesh_def* mesh = &survey->mesh;
    bool outside = false;
    for (size_t corner = 0; corner < 3; ++corner)
        for (size_t axis = 0; axis < 2; ++axis) {
            const float at = mesh->uv[1][2 * (size_t)mesh->indices[3 * triangle + corner] + axis];
            outside |= at < -coordinate_tolerance || at > 1 + coordinate_tolerance;
            survey->lower[axis] = fminf(survey->lower[axis], at);
            survey->upper[axis] = fmaxf(survey->upper[axis], at);
        }
    survey->outside += outside;
    double corners[3][2];
    float area = 0;
    if (!ty_atlas_triangle(mesh, triangle, 1 << 14, 1 << 14, corners)) return;
    const uint32_t* corner = mesh->indices + 3 * triangle;
    const ty_vec a = ty_vec_load(mesh->positions + 3 * (size_t)corner[0]);
    const ty_vec ab = ty_sub(ty_vec_load(mesh->positions + 3 * (size_t)corner[1]), a);
    ty_triangle_normal(ab, ty_sub(ty_vec_load(mesh->positions + 3 * (size_t)corner[2]), a), &area);
    survey->surface_area += (double)area;
    survey->map_area += fabs((corners[1][0] - corners[0][0]) * (corners[2][1] - corners[0][1]) -
                             (corners[2][0] - corners[0][0]) * (corners[1][1] - corners[0][1])) *
                        0.5 / ((double)(1 << 14) * (1 << 14));
}

static ty_result survey_mesh(const ty_scene* scene, int32_t index, const char* name, mesh_survey* survey) {
    *survey = (mesh_survey){.lower = {INFINITY, INFINITY}, .upper = {-INFINITY, -INFINITY}};
    const ty_result result = ty_scene_get_mesh(scene, index, &survey->mesh);
    if (result != TY_OK) return result;
    ty_context* context = ty_scene_context(scene);
    if (name != NULL && name[0] != '\0')
        snprintf(survey->name, sizeof survey->name, "%s", name);
    else
        snprintf(survey->name, sizeof survey->name, "mesh %d", (int)index);
    if (survey->mesh.uv[1] == NULL)
        return ty_fail(context, TY_ERROR_INPUT,
                       "%s has no second texture coordinates to lay a lightmap out by: bake vertices instead "
                       "(--vertices), or add a lightmap channel (UV2) by tyndall unwrap or in your modelling program",
                       survey->name);
    for (int64_t t = 0; t < survey->mesh.triangle_count; ++t) survey_triangle(survey, (size_t)t);
    if (survey->outside > 0)
        return ty_fail(context, TY_ERROR_INPUT,
                       "%s: the second texture coordinates of %lld of its %lld triangles leave 0..1 (u %g..%g, v "
                       "%g..%g): move or scale the lightmap channel (UV2) into one tile in your modelling program",
                       survey->name, (long long)survey->outside, (long long)survey->mesh.triangle_count,
                       (double)survey->lower[0], (double)survey->upper[0], (double)survey->lower[1],
                       (double)survey->upper[1]);
    if (!(survey->map_area > 0))
        return ty_fail(context, TY_ERROR_INPUT,
                       "%s: its second texture coordinates cover no area: bake vertices instead (--vertices), or "
                       "unwrap the lightmap channel (UV2) by tyndall unwrap --all or in your modelling program",
                       survey->name);
    return TY_OK;
}

/* Side in texels that reaches the requested texel density, rounded up to whole steps. */
static int32_t side_for(double texels) {
    const double steps = ceil(texels / SIDE_STEP - 1e-9);
    return (int32_t)fmin(fmax(SIDE_STEP * steps, SIDE_MIN), SIDE_OF_DENSITY_MAX);
}

static void find_size(const mesh_survey* survey, const ty_atlas_def* def, ty_atlas_size* out) {
    const double texels = survey->surface_area * def->density * def->density / survey->map_area;
    out->width = def->width;
    out->height = def->height;
    if (out->width == 0) out->width = side_for(out->height == 0 ? sqrt(texels) : texels / out->height);
    if (out->height == 0) out->height = def->width == 0 ? out->width : side_for(texels / out->width);
}

/* Peak memory in bytes, for the given number of valid texels. */
static double bytes_of(const mesh_survey* survey, const ty_atlas_def* def, const ty_atlas_size* size, double texels) {
    const double all = (double)size->width * size->height;
    const double steps = sizeof(int32_t) + sizeof(int8_t) + (def->close_seams ? sizeof(int32_t) : 0);
    const double drawn = all * (sizeof(ty_texel) + sizeof(int32_t));
    const double image = all * (sizeof(int32_t) + TY_ATLAS_CHANNELS * sizeof(float) + steps);
    const double own = sizeof(ty_bake_receiver) + 2 * sizeof(int32_t) + sizeof(float);
    const double light = sizeof(ty_bake_light) + sizeof(bool);
    const double neighbours = 12.0 * sizeof(int32_t) * (double)survey->mesh.triangle_count +
                              5.0 * sizeof(int32_t) * (double)survey->mesh.vertex_count;
    return fmax(drawn + neighbours, image + texels * light) + texels * own;
}

/* Chart edges touch more texels than the area of the charts accounts for. */
static void estimate(const mesh_survey* survey, const ty_atlas_def* def, ty_atlas_size* out) {
    find_size(survey, def, out);
    const double all = (double)out->width * out->height;
    out->texels = fmin(1.1 * fmin(survey->map_area, 1) * all + 1, all);
    out->bytes = bytes_of(survey, def, out, out->texels);
}

ty_result ty_atlas_estimate(const ty_scene* scene, int32_t mesh, const char* name, const ty_atlas_def* def,
                            ty_atlas_size* out) {
    mesh_survey survey;
    ty_atlas_def own;
    ty_result result = check_atlas_def(ty_scene_context(scene), &def, &own);
    if (result == TY_OK) result = survey_mesh(scene, mesh, name, &survey);
    if (result == TY_OK) estimate(&survey, def, out);
    return result;
}

/* ---- rasterisation ---- */

static ty_result check_overlaps(const ty_atlas* atlas, const mesh_survey* survey, const ty_raster* raster) {
    if (raster->overlaps == 0) return TY_OK;
    const double fraction = (double)raster->overlaps / (double)raster->centers;
    if (fraction > overlap_tolerance)
        return ty_fail(atlas->context, TY_ERROR_INPUT,
                       "%s: %.3g%% of the lightmap's texels belong to several places of the surface: its second "
                       "texture coordinates overlap; unwrap the lightmap channel (UV2) without overlaps in your "
                       "modelling program, or bake vertices instead (--vertices)",
                       survey->name, 100 * fmin(fraction, 1));
    ty_log(atlas->context, TY_LOG_WARNING, "%s: %lld of %lld texels of the lightmap belong to several charts",
           survey->name, (long long)raster->overlaps, (long long)raster->centers);
    return TY_OK;
}

typedef struct receiver_job {
    ty_atlas* atlas;
    const ty_mesh_def* mesh;
    ty_surface surface; /* the mesh's, for its normals */
    const ty_texel* texels;
    const int32_t* charts;
} receiver_job;

/* The receiver of a texel: the sample point on its triangle, lit on the triangle's front. */
static ty_bake_receiver make_receiver(const receiver_job* work, int32_t texel) {
    const size_t triangle = (size_t)work->texels[texel].triangle;
    const int32_t width = work->atlas->width;
    const double center[2] = {texel % width + 0.5, texel / width + 0.5};
    double corners[3][2], b1, b2;
    ty_atlas_triangle(work->mesh, triangle, width, work->atlas->height, corners);
    ty_atlas_texel_point(corners, center, &b1, &b2);
    const uint32_t* corner = work->mesh->indices + 3 * triangle;
    const ty_vec a = ty_vec_load(work->mesh->positions + 3 * (size_t)corner[0]);
    const ty_vec b = ty_vec_load(work->mesh->positions + 3 * (size_t)corner[1]);
    const ty_vec c = ty_vec_load(work->mesh->positions + 3 * (size_t)corner[2]);
    const ty_vec ab = ty_sub(b, a), ac = ty_sub(c, a);
    ty_hit hit = {.primitive_id = (int32_t)triangle, .b1 = (float)b1, .b2 = (float)b2};
    float area;
    hit.normal = ty_triangle_normal(ab, ac, &area);
    ty_surface_point point;
    ty_surface_evaluate(&work->surface, &hit, ty_scale(hit.normal, -1.0f), &point);
    const ty_vec at = ty_mad(ty_mad(a, ab, hit.b1), ac, hit.b2);
    return (ty_bake_receiver){.position = {at.x, at.y, at.z},
                              .normal = {point.ns.x, point.ns.y, point.ns.z},
                              .face = {hit.normal.x, hit.normal.y, hit.normal.z},
                              .margin = ty_accel_ray_epsilon(hit.normal, a, b, c)};
}

enum { BLOCK = 1024 };

static void make_receiver_block(void* user, int64_t index, int32_t worker) {
    (void)worker;
    const receiver_job* work = user;
    ty_atlas* atlas = work->atlas;
    const int64_t end = (index + 1) * BLOCK < atlas->count ? (index + 1) * BLOCK : atlas->count;
    for (int64_t i = index * BLOCK; i < end; ++i) {
        const ty_texel* texel = &work->texels[atlas->texels[i]];
        atlas->receivers[i] = make_receiver(work, atlas->texels[i]);
        atlas->charts[i] = work->charts[texel->triangle];
        atlas->coverage[i] = fminf(texel->rank, 1);
    }
}

static void number_receivers(ty_atlas* atlas, const ty_texel* texels) {
    const size_t all = ty_atlas_texels(atlas);
    for (size_t i = 0; i < all; ++i) atlas->receiver[i] = texels[i].triangle < 0 ? -1 : (int32_t)atlas->count++;
}

static ty_result create_receivers(ty_atlas* atlas, const mesh_survey* survey, const ty_texel* texels,
                                  const int32_t* charts) {
    const size_t count = (size_t)atlas->count;
    atlas->texels = ty_alloc_array(atlas->context, count, sizeof *atlas->texels, false);
    atlas->charts = ty_alloc_array(atlas->context, count, sizeof *atlas->charts, false);
    atlas->coverage = ty_alloc_array(atlas->context, count, sizeof *atlas->coverage, false);
    atlas->receivers = ty_alloc_array(atlas->context, count, sizeof *atlas->receivers, false);
    if (atlas->texels == NULL || atlas->charts == NULL || atlas->coverage == NULL || atlas->receivers == NULL)
        return TY_ERROR_MEMORY;
    const int32_t all = (int32_t)ty_atlas_texels(atlas);
    for (int32_t i = 0; i < all; ++i)
        if (atlas->receiver[i] >= 0) atlas->texels[atlas->receiver[i]] = i;
    receiver_job work = {.atlas = atlas,
                         .mesh = &survey->mesh,
                         .surface = {.indices = survey->mesh.indices,
                                     .positions = survey->mesh.positions,
                                     .normals = survey->mesh.normals},
                         .texels = texels,
                         .charts = charts};
    ty_parallel_for(atlas->context, (atlas->count + BLOCK - 1) / BLOCK, make_receiver_block, &work);
    return TY_OK;
}

static ty_result rasterise_map(ty_atlas* atlas, const mesh_survey* survey, const ty_atlas_def* def, ty_texel* texels,
                               int32_t* charts) {
    ty_raster raster;
    ty_result result = ty_atlas_rasterise(atlas->context, &survey->mesh, atlas->width, atlas->height, texels, &raster);
    if (result == TY_OK) result = check_overlaps(atlas, survey, &raster);
    if (result == TY_OK)
        result = ty_atlas_find_charts(atlas->context, &survey->mesh, atlas->width, atlas->height, charts, &atlas->seams,
                                      &atlas->seam_count, &atlas->seam_capacity);
    if (result != TY_OK) return result;
    if (!def->close_seams) atlas->seam_count = 0;
    number_receivers(atlas, texels);
    return create_receivers(atlas, survey, texels, charts);
}

static ty_result fill_atlas(ty_atlas* atlas, const mesh_survey* survey, const ty_atlas_def* def) {
    const size_t all = ty_atlas_texels(atlas), triangles = (size_t)survey->mesh.triangle_count;
    atlas->receiver = ty_alloc_array(atlas->context, all, sizeof *atlas->receiver, false);
    ty_texel* texels = ty_alloc_array(atlas->context, all, sizeof *texels, false);
    int32_t* charts = ty_alloc_array(atlas->context, triangles, sizeof *charts, false);
    const bool ready = atlas->receiver != NULL && texels != NULL && charts != NULL;
    const ty_result result = ready ? rasterise_map(atlas, survey, def, texels, charts) : TY_ERROR_MEMORY;
    ty_free_array(atlas->context, texels, all, sizeof *texels);
    ty_free_array(atlas->context, charts, triangles, sizeof *charts);
    return result;
}

ty_result ty_atlas_create(const ty_scene* scene, int32_t mesh, const char* name, const ty_atlas_def* def,
                          ty_atlas** out) {
    ty_context* context = ty_scene_context(scene);
    mesh_survey survey;
    ty_atlas_size size;
    ty_atlas_def own;
    ty_result result = check_atlas_def(context, &def, &own);
    if (result == TY_OK) result = survey_mesh(scene, mesh, name, &survey);
    if (result != TY_OK) return result;
    estimate(&survey, def, &size);
    char what[NAME_SIZE + 32];
    snprintf(what, sizeof what, "%s: a lightmap of %d x %d texels", survey.name, (int)size.width, (int)size.height);
    result = ty_check_memory(context, size.bytes, what);
    if (result != TY_OK) return result;
    ty_atlas* atlas = ty_alloc_array(context, 1, sizeof *atlas, true);
    if (atlas == NULL) return TY_ERROR_MEMORY;
    atlas->context = context;
    atlas->width = size.width;
    atlas->height = size.height;
    atlas->padding = def->padding;
    result = fill_atlas(atlas, &survey, def);
    if (result == TY_OK)
        *out = atlas;
    else
        ty_atlas_destroy(atlas);
    return result;
}

void ty_atlas_destroy(ty_atlas* atlas) {
    if (atlas == NULL) return;
    ty_context* context = atlas->context;
    const size_t count = (size_t)atlas->count;
    ty_free_array(context, atlas->texels, count, sizeof *atlas->texels);
    ty_free_array(context, atlas->charts, count, sizeof *atlas->charts);
    ty_free_array(context, atlas->coverage, count, sizeof *atlas->coverage);
    ty_free_array(context, atlas->receivers, count, sizeof *atlas->receivers);
    ty_free_array(context, atlas->receiver, ty_atlas_texels(atlas), sizeof *atlas->receiver);
    ty_free_array(context, atlas->seams, atlas->seam_capacity, sizeof *atlas->seams);
    ty_free_array(context, atlas, 1, sizeof *atlas);
}

int32_t ty_atlas_width(const ty_atlas* atlas) {
    return atlas->width;
}

int32_t ty_atlas_height(const ty_atlas* atlas) {
    return atlas->height;
}

const ty_bake_receiver* ty_atlas_receivers(const ty_atlas* atlas, int64_t* count) {
    *count = atlas->count;
    return atlas->receivers;
}
