/* Paths through a periodic cell: rays in pieces from face to face (scene/media/periodic.k.h). Lights are distant. */
#ifndef TY_METHOD_PATH_TRACE_PERIODIC_K_H
#define TY_METHOD_PATH_TRACE_PERIODIC_K_H

#include "method/path/trace/collision.k.h"
#include "method/path/trace/light_path.k.h"
#include "scene/media/periodic.k.h"

/* Nonzero: the kernel of periodic scenes. */
#ifndef TY_PATH_PERIODIC
#define TY_PATH_PERIODIC 0
#endif

/* Transmittance of media and surfaces along a ray to a distant light. */
TY_FN_CALLED void ty_periodic_transmittance(const ty_scene_view* scene, ty_vec origin, ty_vec direction,
                                            ty_sampler* random, float transmittance[3]) {
    ty_periodic_walk walk;
    for (int c = 0; c < 3; ++c) transmittance[c] = 1.0f;
    if (!ty_periodic_walk_begin(&walk, &scene->periodic, origin, direction)) return;
    do {
        float piece[3];
        const bool occluded = scene->mesh != NULL && ty_accel_occluded(scene->mesh, walk.origin, direction, walk.far);
        if (!occluded)
            ty_transmittance(scene->media, scene->medium_count, walk.origin, direction, walk.far, random, piece);
        for (int c = 0; c < 3; ++c) transmittance[c] *= occluded ? 0.0f : piece[c];
    } while (ty_max3(transmittance) > 0.0f && ty_periodic_walk_next(&walk, &scene->periodic));
    if (ty_periodic_walk_is_lost(&walk))
        for (int c = 0; c < 3; ++c) transmittance[c] = 0.0f;
}

/* A collision of the path in homogeneous spans, as in media of any kind: throughput that passes them, or a vertex. */
TY_FN bool ty_periodic_collides(ty_path* path, const ty_spans* spans, ty_collision* collision) {
    float depth[3], collided[3], passed[3], emitted[3], colliding = 0.0f;
    ty_spans_optical_depth(path->media, spans, TY_FLOAT_MAX, depth);
    if (spans->emits != 0) {
        ty_spans_emitted_radiance(path->media, spans, emitted);
        for (int c = 0; c < 3; ++c) emitted[c] *= path->beta[c];
        ty_path_add(path, emitted);
    }
    for (int c = 0; c < 3; ++c) {
        collided[c] = ty_collision_probability(depth[c]);
        passed[c] = path->beta[c] * ty_expf(-depth[c]);
        colliding += path->beta[c] * collided[c];
    }
    const float chance = colliding / (colliding + ty_sum3(passed));
    const float u = ty_sobol_next(&path->random);
    if (u >= chance) {
        for (int c = 0; c < 3; ++c) path->beta[c] = passed[c] / (1.0f - chance);
        return false;
    }
    if (ty_sample_homogeneous_collision(path->media, spans, collided, u / chance, &path->random, path->beta,
                                        collision)) {
        for (int c = 0; c < 3; ++c) path->beta[c] /= chance;
    } else {
        collision->t = spans->enter[0];
        collision->medium = spans->medium[0];
        for (int c = 0; c < 3; ++c) path->beta[c] = 0.0f;
    }
    return true;
}

/* True if the path collides in the first `far` of a piece; otherwise its throughput accounts for the media there. */
TY_FN bool ty_periodic_meets_medium(ty_path* path, const ty_periodic_walk* walk, float far,
                                    const ty_medium_view** medium) {
    ty_spans spans;
    ty_collision collision;
    if (path->request->unscattered != 0) {
        float passed[3];
        ty_transmittance(path->media, path->medium_count, walk->origin, path->direction, far, &path->random, passed);
        for (int c = 0; c < 3; ++c) path->beta[c] *= passed[c];
        return false;
    }
    ty_spans_find(path->media, path->medium_count, walk->origin, path->direction, far, &spans);
    if (spans.count == 0) return false;
    if (spans.heterogeneous != 0) {
        float emitted[3] = {0.0f, 0.0f, 0.0f};
        const bool collides = ty_delta_tracking(path->media, &spans, walk->origin, path->direction, &path->random,
                                                path->beta, emitted, &collision);
        if (spans.emits != 0) ty_path_add(path, emitted);
        if (!collides) return false;
    } else if (!ty_periodic_collides(path, &spans, &collision)) {
        return false;
    }
    *medium = &path->media[collision.medium];
    path->origin = ty_mad(walk->origin, path->direction, collision.t);
    return true;
}

#endif
