#include "bench/ray_sets.h"

#include "base/random.k.h"
#include "base/vector.k.h"

#include <stdlib.h>
#include <string.h>

enum { TILE = 4, TERRAIN_CELLS = 361 };

/* ---- the mesh ---- */

static float terrain_height(float x, float z) {
    float height = 0, size = 0.2f, frequency = 2;
    for (int octave = 0; octave < 6; ++octave) {
        const float turn = 0.7f * (float)octave;
        height += size * sinf(frequency * (x + turn)) * cosf(frequency * (z - 0.3f * x + 2 * turn));
        size *= 0.45f;
        frequency *= 2.1f;
    }
    return height;
}

ty_result bench_add_terrain(ty_scene* scene) {
    const uint32_t side = TERRAIN_CELLS + 1;
    ty_mesh_def def = ty_default_mesh_def();
    def.vertex_count = (int64_t)side * side;
    def.triangle_count = 2 * (int64_t)TERRAIN_CELLS * TERRAIN_CELLS;
    float* positions = malloc((size_t)def.vertex_count * 3 * sizeof *positions);
    uint32_t* indices = malloc((size_t)def.triangle_count * 3 * sizeof *indices);
    ty_result result = TY_ERROR_MEMORY;
    if (positions != NULL && indices != NULL) {
        float* position = positions;
        for (uint32_t k = 0; k < side; ++k)
            for (uint32_t i = 0; i < side; ++i, position += 3) {
                position[0] = 2 * (float)i / TERRAIN_CELLS - 1;
                position[2] = 2 * (float)k / TERRAIN_CELLS - 1;
                position[1] = terrain_height(position[0], position[2]);
            }
        uint32_t* index = indices;
        for (uint32_t k = 0; k < TERRAIN_CELLS; ++k)
            for (uint32_t i = 0; i < TERRAIN_CELLS; ++i, index += 6) {
                const uint32_t corner = k * side + i;
                const uint32_t corners[6] = {corner,     corner + side, corner + 1,
                                             corner + 1, corner + side, corner + side + 1};
                memcpy(index, corners, sizeof corners);
            }
        def.positions = positions;
        def.indices = indices;
        result = ty_scene_add_mesh(scene, &def);
    }
    free(positions);
    free(indices);
    return result;
}

/* ---- the rays ---- */

static void set_ray(ty_ray* ray, ty_vec origin, ty_vec direction, float far) {
    memcpy(ray->origin, &origin, sizeof ray->origin);
    memcpy(ray->direction, &direction, sizeof ray->direction);
    ray->far = far;
}

/* A ball around the mesh. */
static ty_vec bounding_sphere(const ty_scene* scene, float* radius) {
    const ty_scene_info info = ty_scene_get_info(scene);
    float center[3];
    double square = 0;
    for (int a = 0; a < 3; ++a) {
        center[a] = (float)(0.5 * (info.lower[a] + info.upper[a]));
        square += 0.25 * (info.upper[a] - info.lower[a]) * (info.upper[a] - info.lower[a]);
    }
    *radius = (float)sqrt(square);
    return ty_vec_load(center);
}

/* Camera rays from obliquely above, pixels in tiles of sixteen. */
static void fill_camera(const ty_scene* scene, const int32_t size[2], ty_ray* rays) {
    float radius = 0;
    const ty_vec center = bounding_sphere(scene, &radius);
    const ty_vec back = ty_normalize(ty_vec_make(0.6f, 0.5f, 0.62f));
    const ty_vec eye = ty_mad(center, back, 1.6f * radius);
    const ty_vec right = ty_normalize(ty_cross(ty_vec_make(0, 1, 0), back)), up = ty_cross(back, right);
    for (int32_t tile_y = 0; tile_y < size[1]; tile_y += TILE)
        for (int32_t tile_x = 0; tile_x < size[0]; tile_x += TILE)
            for (int32_t y = tile_y; y < tile_y + TILE && y < size[1]; ++y)
                for (int32_t x = tile_x; x < tile_x + TILE && x < size[0]; ++x) {
                    const float across = 0.45f * ((2 * (float)x + 1) / (float)size[0] - 1);
                    const float down = 0.45f * ((2 * (float)y + 1) / (float)size[1] - 1);
                    const ty_vec omega = ty_mad(ty_mad(ty_scale(back, -1), right, across), up, -down);
                    set_ray(rays++, eye, ty_normalize(omega), INFINITY);
                }
}

static float random_in(uint32_t* state, float lower, float upper) {
    *state += 0x9e3779b9u;
    return lower + (upper - lower) * (float)(ty_mix32(*state) >> 8) * 0x1p-24f;
}

/* Cosine-distributed directions about the normal. */
static ty_vec random_cosine_direction(uint32_t* state, ty_vec normal) {
    ty_vec omega;
    do {
        omega = ty_vec_make(random_in(state, -1, 1), random_in(state, -1, 1), random_in(state, -1, 1));
    } while (ty_dot(omega, omega) > 1 || ty_dot(omega, omega) < 0.01f);
    const ty_vec sum = ty_mad(ty_normalize(omega), normal, 1.001f);
    return ty_normalize(sum);
}

static void shuffle(ty_ray* rays, int64_t count) {
    uint32_t state = 2;
    for (int64_t i = count - 1; i > 0; --i) {
        state += 0x9e3779b9u;
        const int64_t j = (int64_t)((uint64_t)ty_mix32(state) * (uint64_t)(i + 1) >> 32);
        const ty_ray swapped = rays[i];
        rays[i] = rays[j];
        rays[j] = swapped;
    }
}

/* Secondary rays from camera hits: to a point light above, and in random directions. */
static void continue_rays(const ty_scene* scene, const ty_ray_hit* hits, ray_set sets[RAY_SETS]) {
    float radius = 0;
    const ty_vec center = bounding_sphere(scene, &radius);
    const ty_vec light = ty_add(center, ty_vec_make(0.3f * radius, 1.2f * radius, 0.4f * radius));
    uint32_t state = 1;
    int64_t count = 0;
    for (int64_t i = 0; i < sets[RAYS_CAMERA].count; ++i) {
        if (hits[i].surface < 0) continue;
        const ty_vec position = ty_vec_load(hits[i].position);
        ty_vec facing = ty_vec_load(hits[i].normal);
        if (ty_dot(facing, ty_vec_load(sets[RAYS_CAMERA].rays[i].direction)) > 0) facing = ty_scale(facing, -1);
        const ty_vec start = ty_mad(position, facing, hits[i].margin), there = ty_sub(light, start);
        const float distance = sqrtf(ty_dot(there, there));
        set_ray(&sets[RAYS_SHADOW].rays[count], start, ty_scale(there, 1 / distance), distance);
        set_ray(&sets[RAYS_BOUNCE].rays[count], start, random_cosine_direction(&state, facing), INFINITY);
        ++count;
    }
    for (int set = RAYS_SHADOW; set < RAY_SETS; ++set) sets[set].count = count;
    memcpy(sets[RAYS_SHUFFLED_SHADOW].rays, sets[RAYS_SHADOW].rays, (size_t)count * sizeof(ty_ray));
    shuffle(sets[RAYS_SHUFFLED_SHADOW].rays, count);
    shuffle(sets[RAYS_BOUNCE].rays, count);
}

ty_result bench_make_rays(const ty_scene* scene, const int32_t size[2], ray_set sets[RAY_SETS]) {
    static const ray_set kinds[RAY_SETS] = {
        {"camera, packets", "camera_packets", true, false, NULL, 0},
        {"shadow, packets", "shadow_packets", true, true, NULL, 0},
        {"shadow, shuffled, single", "shadow_single", false, true, NULL, 0},
        {"bounce, shuffled, single", "bounce_single", false, false, NULL, 0},
    };
    const int64_t count = (int64_t)size[0] * size[1];
    ty_ray_hit* hits = malloc((size_t)count * sizeof *hits);
    bool allocated = hits != NULL;
    for (int set = 0; set < RAY_SETS; ++set) {
        sets[set] = kinds[set];
        sets[set].rays = malloc((size_t)count * sizeof(ty_ray));
        allocated = allocated && sets[set].rays != NULL;
    }
    ty_result result = allocated ? TY_OK : TY_ERROR_MEMORY;
    if (allocated) {
        sets[RAYS_CAMERA].count = count;
        fill_camera(scene, size, sets[RAYS_CAMERA].rays);
        result = ty_scene_trace(scene, sets[RAYS_CAMERA].rays, count, TY_RAYS_COHERENT, hits);
    }
    if (result == TY_OK) continue_rays(scene, hits, sets);
    free(hits);
    if (result != TY_OK) bench_free_rays(sets);
    return result;
}

void bench_free_rays(ray_set sets[RAY_SETS]) {
    for (int set = 0; set < RAY_SETS; ++set) free(sets[set].rays);
}
