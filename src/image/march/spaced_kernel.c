/* Rays several pixels apart, and the pixels between them; built once per instruction set, with TY_ISA naming it. */
#include "image/march/spaced.h"

#include "base/float_mode.h"
#include "image/march/pixel.k.h"
#include "image/march/similarity.k.h"

/* Range of the radiance of the rays around a pixel, relative to the pixel's, above which the pixel gets a ray of its
 * own. */
static const float contrast_max = 0.25f;
/* Error of the distance that is interpolated, relative to the distance and for opaque media, above which it gets one,
 * too. */
static const float distance_error_max = 0.01f;
/* Cosine between the normals of surfaces at which the irradiance of one no longer counts for the other. */
static const float cosine_min = 0.7f;

/* ---- rays ---- */

static int32_t pixel_of(int32_t ray, int32_t spacing, int32_t pixels) {
    return ray * spacing < pixels ? ray * spacing : pixels - 1;
}

static ty_vec direction_through(const ty_march_request* request, int32_t x, int32_t y, int32_t sample) {
    float dx, dy;
    ty_pixel_place(sample, request->spp, &dx, &dy);
    return ty_camera_direction(&request->camera, (float)x + dx, (float)y + dy);
}

static uint32_t march_ray(const ty_march_request* request, ty_march_ray* ray, ty_vec direction, float offset,
                          ty_spaced_ray* out) {
    const ty_accel* mesh = request->scene->mesh;
    const ty_vec origin = request->camera.origin;
    ty_hit hit;
    const bool hits = mesh != NULL && ty_accel_intersect(mesh, origin, direction, TY_FLOAT_MAX, &hit);
    memset(out, 0, sizeof *out);
    out->distance = hits ? hit.distance : TY_FLOAT_MAX;
    ty_march_follow(ray, request, origin, direction, out->distance, offset, 1.0f);
    uint32_t steps = ray->steps;
    const ty_march_light light = ray->light;
    for (int c = 0; c < 3; ++c) {
        out->transmittance[c] = light.transmittance[c];
        out->emission[c] = light.emission[c];
        out->single[c] = light.single[c];
        out->multiple[c] = light.multiple[c];
    }
    if (!hits) {
        if (request->blurred != NULL) ty_pixel_add_blurred(request, direction, &light, out->multiple);
        return steps;
    }
    const ty_vec cells = ty_cell_coordinates(&request->surface_field.lattice, hit.position);
    if (request->has_field == 0 || ty_cell_inside(&request->surface_field.lattice, cells)) return steps;
    ty_surface_point point;
    ty_surface_evaluate(&request->scene->surfaces[hit.surface], &hit, direction, &point);
    if (!ty_reflect_is_visible(&point, out->transmittance)) return steps;
    steps += ty_reflect_gather(request, ray, ty_hit_leave(&hit, point.ng), point.ng, point.ns, TY_REFLECT_RAYS_SPACED,
                               offset, out->irradiance);
    out->gathered = 1;
    out->normal = point.ns;
    return steps;
}

static uint64_t march_rays(const ty_march_request* request, const ty_spaced_rays* lattice, int32_t sample, int32_t row,
                           int32_t begin, int32_t end) {
    const unsigned state = ty_flush_denormals();
    const int32_t y = pixel_of(row, lattice->spacing, lattice->height);
    uint64_t steps = 0;
    ty_march_ray ray;
    for (int32_t i = begin; i < end; ++i) {
        const int32_t x = pixel_of(i, lattice->spacing, lattice->width);
        steps += march_ray(request, &ray, direction_through(request, x, y, sample),
                           ty_pixel_offset(request, i, row, sample, request->spp),
                           &lattice->rays[(size_t)row * (size_t)lattice->columns + (size_t)i]);
    }
    ty_restore_denormals(state);
    return steps;
}

/* ---- pixels ---- */

/* The four rays around a pixel, and their weights. */
typedef struct neighbours {
    const ty_spaced_ray* rays[4];
    float weight[4];
} neighbours;

/* The ray before a pixel along one axis, and the weight of the next. */
static float part_of(int32_t pixel, int32_t spacing, int32_t pixels, int32_t* first) {
    *first = pixel / spacing;
    const int32_t from = pixel_of(*first, spacing, pixels), to = pixel_of(*first + 1, spacing, pixels);
    return to > from ? (float)(pixel - from) / (float)(to - from) : 0.0f;
}

/* Bilinear weights; rays without weight are not read. */
static void find_neighbours(const ty_spaced_rays* lattice, int32_t x, int32_t y, neighbours* around) {
    int32_t column, row;
    const float along = part_of(x, lattice->spacing, lattice->width, &column);
    const float down = part_of(y, lattice->spacing, lattice->height, &row);
    const ty_spaced_ray* first = lattice->rays + (size_t)row * (size_t)lattice->columns + column;
    const size_t right = along > 0.0f ? 1 : 0, below = down > 0.0f ? (size_t)lattice->columns : 0;
    for (size_t i = 0; i < 4; ++i) {
        around->rays[i] = first + (i & 1) * right + (i >> 1) * below;
        around->weight[i] = ((i & 1) != 0 ? along : 1.0f - along) * ((i >> 1) != 0 ? down : 1.0f - down);
    }
}

/* Scales weights so that they sum to 1; false: the rays around the pixel do not represent it. */
static bool normalise(float weight[4]) {
    const float sum = (weight[0] + weight[1]) + (weight[2] + weight[3]);
    if (!(sum >= TY_SIMILARITY_WEIGHT_MIN)) return false;
    for (int i = 0; i < 4; ++i) weight[i] *= 1.0f / sum;
    return true;
}

/* The media in front of a pixel. */
static bool interpolate_media(neighbours* around, float distance, ty_spaced_ray* out) {
    for (int i = 0; i < 4; ++i)
        if (around->weight[i] > 0.0f) around->weight[i] *= ty_similarity(distance, around->rays[i]->distance);
    if (!normalise(around->weight)) return false;
    out->distance = 0.0f;
    for (int c = 0; c < 3; ++c) out->transmittance[c] = out->emission[c] = out->single[c] = out->multiple[c] = 0.0f;
    for (int i = 0; i < 4; ++i) {
        if (around->weight[i] > 0.0f) out->distance += around->weight[i] * around->rays[i]->distance;
        for (int c = 0; c < 3; ++c) {
            const float weight = around->weight[i];
            out->transmittance[c] += weight * around->rays[i]->transmittance[c];
            out->emission[c] += weight * around->rays[i]->emission[c];
            out->single[c] += weight * around->rays[i]->single[c];
            out->multiple[c] += weight * around->rays[i]->multiple[c];
        }
    }
    const float* passed = out->transmittance;
    const float opacity = 1.0f - ty_minf(passed[0], ty_minf(passed[1], passed[2]));
    return !(distance < TY_FLOAT_MAX) || opacity * fabsf(out->distance - distance) <= distance_error_max * distance;
}

/* The media's irradiance on a surface outside of the field. */
static bool interpolate_irradiance(const neighbours* around, ty_vec normal, float irradiance[3]) {
    float weight[4];
    for (int i = 0; i < 4; ++i) {
        const ty_spaced_ray* ray = around->rays[i];
        const float cosine = ray->gathered != 0 ? ty_dot(ray->normal, normal) : 0.0f;
        weight[i] = around->weight[i] * ty_maxf(0.0f, (cosine - cosine_min) * (1.0f / (1.0f - cosine_min)));
    }
    if (!normalise(weight)) return false;
    for (int c = 0; c < 3; ++c) {
        irradiance[c] = 0.0f;
        for (int i = 0; i < 4; ++i) irradiance[c] += weight[i] * around->rays[i]->irradiance[c];
    }
    return true;
}

static float sum_of(const float values[3]) {
    return values[0] + values[1] + values[2];
}

/* True if the rays around a pixel differ too much to be interpolated; behind: radiance behind the media. */
static bool differ(const neighbours* around, const ty_spaced_ray* mean, const float behind[3]) {
    float min = TY_FLOAT_MAX, max = 0.0f, level = 0.0f;
    for (int i = -1; i < 4; ++i) {
        const ty_spaced_ray* ray = i < 0 ? mean : around->rays[i];
        float light = sum_of(ray->emission) + sum_of(ray->single) + sum_of(ray->multiple);
        for (int c = 0; c < 3; ++c) light += ray->transmittance[c] * behind[c];
        if (i < 0) {
            level = light;
        } else if (around->weight[i] > 0.0f) {
            min = ty_minf(min, light);
            max = ty_maxf(max, light);
        }
    }
    return max - min > contrast_max * level;
}

/* Radiance behind the media: of the environment, or reflected by the surface. False: the rays around do not tell. */
static bool find_behind(const ty_march_request* request, const neighbours* around, ty_vec direction, const ty_hit* hit,
                        float behind[3]) {
    static const float clear[3] = {1.0f, 1.0f, 1.0f};
    for (int c = 0; c < 3; ++c) behind[c] = 0.0f;
    if (hit == NULL) {
        if (request->has_background != 0) ty_pixel_add_environment(request, direction, clear, behind);
        return true;
    }
    ty_surface_point point;
    float irradiance[3];
    if (request->has_field == 0) return true;
    ty_surface_evaluate(&request->scene->surfaces[hit->surface], hit, direction, &point);
    if (!ty_reflect_is_visible(&point, clear)) return true;
    const ty_vec cells = ty_cell_coordinates(&request->surface_field.lattice, hit->position);
    if (ty_cell_inside(&request->surface_field.lattice, cells))
        ty_upsample_irradiance(&request->surface_field, cells, point.ns, irradiance);
    else if (!interpolate_irradiance(around, point.ns, irradiance))
        return false;
    for (int c = 0; c < 3; ++c) behind[c] = point.albedo[c] * (1.0f / TY_PI) * irradiance[c];
    return true;
}

/* Adds a pixel from the rays around it; false: it needs one of its own. */
static bool interpolate(const ty_march_request* request, const ty_spaced_rays* lattice, int32_t x, int32_t y,
                        ty_vec direction, const ty_hit* hit, ty_march_pixel* pixel) {
    neighbours around;
    ty_spaced_ray mean;
    float behind[3];
    find_neighbours(lattice, x, y, &around);
    if (!interpolate_media(&around, hit != NULL ? hit->distance : TY_FLOAT_MAX, &mean)) return false;
    if (!find_behind(request, &around, direction, hit, behind) || differ(&around, &mean, behind)) return false;
    for (int c = 0; c < 3; ++c) {
        const float passed = mean.transmittance[c] * behind[c];
        pixel->unscattered[c] += mean.emission[c] + (hit == NULL ? passed : 0.0f);
        pixel->single[c] += mean.single[c];
        pixel->multiple[c] += mean.multiple[c] + (hit != NULL ? passed : 0.0f);
        pixel->transmittance[c] += mean.transmittance[c];
    }
    if (hit != NULL) {
        pixel->depth += hit->distance;
        pixel->hits += 1.0f;
    }
    return true;
}

/* Surfaces that the pixels of a packet see. */
static void intersect(const ty_march_request* request, int32_t x, int32_t y, int32_t count, int32_t sample,
                      ty_vec directions[TY_PACKET], ty_hit hits[TY_PACKET]) {
    const ty_vec origin = request->camera.origin;
    ty_ray rays[TY_PACKET];
    for (int32_t i = 0; i < count; ++i) {
        const ty_vec d = directions[i] = direction_through(request, x + i, y, sample);
        rays[i] = (ty_ray){{origin.x, origin.y, origin.z}, {d.x, d.y, d.z}, TY_FLOAT_MAX};
        hits[i].surface = -1;
    }
    if (request->scene->mesh != NULL) ty_accel_intersect_packet(request->scene->mesh, rays, count, hits);
}

static uint64_t fill_pixels(const ty_march_request* request, const ty_spaced_rays* lattice, int32_t sample, int32_t y,
                            int32_t begin, int32_t end, ty_march_pixel* pixels) {
    const unsigned state = ty_flush_denormals();
    uint64_t steps = 0;
    ty_march_ray ray;
    for (int32_t first = begin; first < end; first += TY_PACKET) {
        const int32_t count = end - first < TY_PACKET ? end - first : TY_PACKET;
        ty_vec directions[TY_PACKET];
        ty_hit hits[TY_PACKET];
        intersect(request, first, y, count, sample, directions, hits);
        for (int32_t i = 0; i < count; ++i) {
            const ty_hit* hit = hits[i].surface >= 0 ? &hits[i] : NULL;
            ty_march_pixel* pixel = &pixels[first - begin + i];
            if (interpolate(request, lattice, first + i, y, directions[i], hit, pixel)) continue;
            ty_pixel_add_ray(request, &ray, directions[i], hit, (float)(first + i), (float)y,
                             ty_pixel_offset(request, first + i, y, sample, request->spp), pixel);
            steps += ray.steps;
        }
    }
    ty_restore_denormals(state);
    return steps;
}

const ty_spaced_kernels TY_KERNEL_NAME(ty_spaced_kernels) = {.march = march_rays, .fill = fill_pixels};
