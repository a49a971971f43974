/* The face of a thick medium that a ray of the camera enters first. */
#ifndef TY_IMAGE_EDGES_K_H
#define TY_IMAGE_EDGES_K_H

#include "image/march/kernel.h"
#include "image/march/voxel.k.h"
#include "scene/media/spans.k.h"

/* Optical depth of the width of a pixel above which a medium counts as thick: below, the strip that is lit along an
 * edge is two pixels wide and more. */
#define TY_EDGES_MIN_DEPTH 0.5f
/* Faces of a medium: of a box by axis and direction, of all others one. */
enum { TY_EDGES_FACES = 7 };

/* Width of a pixel per distance from the camera. */
TY_FN float ty_edges_pixel(const ty_camera_view* camera, float x, float y) {
    const ty_vec through = ty_mad(ty_mad(camera->corner, camera->dx, x), camera->dy, y);
    return sqrtf(ty_dot(camera->dx, camera->dx) / ty_maxf(1e-30f, ty_dot(through, through)));
}

/* The face of the unit cube at a point on it. */
TY_FN int32_t ty_edges_face_of_cube(ty_vec p) {
    const float x = fabsf(p.x), y = fabsf(p.y), z = fabsf(p.z);
    if (x >= y && x >= z) return p.x > 0.0f ? 1 : 0;
    if (y >= z) return p.y > 0.0f ? 3 : 2;
    return p.z > 0.0f ? 5 : 4;
}

/* Extinction of a medium where a ray has entered it by half of the width of a pixel, 1/m. */
TY_FN float ty_edges_extinction(TY_GLOBAL const ty_medium_view* medium, ty_vec point) {
    if (medium->has_grid == 0) return medium->sigma_t_max;
    return medium->sigma_t_max * ty_voxels_density(medium, ty_map_point(medium->to_index, point));
}

/* Number of the face, from 1 on, and its distance; 0: the ray enters no thick medium, or begins in one. */
TY_FN int32_t ty_edges_face(TY_GLOBAL const ty_march_request* request, ty_vec direction, float pixel, float* distance) {
    TY_GLOBAL const ty_scene_view* scene = request->scene;
    const ty_vec origin = request->camera.origin;
    ty_spans spans;
    int32_t face = 0;
    *distance = TY_FLOAT_MAX;
    ty_spans_find(scene->media, scene->medium_count, origin, direction, TY_FLOAT_MAX, &spans);
    for (int32_t i = 0; i < spans.count; ++i) {
        TY_GLOBAL const ty_medium_view* medium = &scene->media[spans.medium[i]];
        const float enter = spans.enter[i], width = pixel * enter;
        if (enter >= *distance) continue;
        if (width * ty_edges_extinction(medium, ty_mad(origin, direction, enter + 0.5f * width)) < TY_EDGES_MIN_DEPTH)
            continue;
        const ty_vec at = ty_map_point(medium->to_bounds, ty_mad(origin, direction, enter));
        *distance = enter;
        face = 1 + TY_EDGES_FACES * spans.medium[i] +
               (medium->bounds == TY_BOUNDED_BOX ? ty_edges_face_of_cube(at) : TY_EDGES_FACES - 1);
    }
    return face;
}

/* The face that the ray through the center of a pixel enters first, before any surface; 0: none. */
TY_FN int32_t ty_edges_face_of_pixel(TY_GLOBAL const ty_march_request* request, int32_t x, int32_t y) {
    const ty_camera_view* camera = &request->camera;
    const ty_vec direction = ty_camera_direction(camera, (float)x + 0.5f, (float)y + 0.5f);
    const float pixel = ty_edges_pixel(camera, (float)x + 0.5f, (float)y + 0.5f);
    float distance;
    const int32_t face = ty_edges_face(request, direction, pixel, &distance);
    if (face != 0 && request->scene->mesh != NULL &&
        ty_accel_occluded(request->scene->mesh, camera->origin, direction, distance))
        return 0;
    return face;
}

/* True if the face of a pixel differs from that of one of the eight around. faces: of an image of this width, with a
 * border of one pixel. */
TY_FN bool ty_edges_are_at(TY_GLOBAL const int32_t* faces, int32_t width, int32_t x, int32_t y) {
    const size_t columns = (size_t)width + 2;
    TY_GLOBAL const int32_t* corner = faces + (size_t)y * columns + (size_t)x;
    for (size_t k = 0; k < 9; ++k)
        if (corner[k / 3 * columns + k % 3] != corner[columns + 1]) return true;
    return false;
}

#endif
