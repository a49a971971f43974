/* One light path, from the eye towards the lights: docs/method/path.md explains it. */
#ifndef TY_PATH_PATH_K_H
#define TY_PATH_PATH_K_H

#include "method/path/equiangular.k.h"
#include "scene/phase.k.h"

/* Vertices after which even a path that loses nothing is slowly ended. */
enum { TY_PATH_ROULETTE_DEPTH = 2000 };

/* What became of light between its source and the eye. */
enum {
    TY_PATH_UNCOLLIDED = 0, /* nothing */
    TY_PATH_REFLECTED = 1,  /* only surfaces reflected it */
    TY_PATH_SINGLE = 2,     /* one scattering in a medium, and nothing else */
    TY_PATH_MULTIPLE = 3,   /* anything else */
    TY_PATH_CLASS_COUNT = 4
};

typedef struct ty_path {
    const ty_path_request* request;
    ty_sampler random;
    ty_vec origin, direction;
    ty_vec normal;       /* of the surface that the path last left, on its side; 0 in media and at the eye */
    float beta[3];       /* throughput */
    float rr_throughput; /* throughput without what directions were weighted with: what Russian roulette looks at */
    float pdf;           /* per steradian, of direction; 0 where no light sampling competes (the eye) */
    int32_t scattered;   /* whether the last vertex is in a medium, where equi-angular sampling competed */
    float phase;         /* the phase function (green) of that vertex in direction, per steradian */
    int32_t depth;       /* scatterings and reflections so far */
    int32_t run;         /* scatterings since the last reflection */
    int32_t path_class;  /* what became of light that the path finds now */
    float radiance[TY_PATH_CLASS_COUNT][3]; /* found so far */
} ty_path;

/* The part after one more scattering, or reflection. */
TY_FN int32_t ty_path_class_scattered(int32_t part) {
    return part == TY_PATH_UNCOLLIDED ? TY_PATH_SINGLE : TY_PATH_MULTIPLE;
}

TY_FN int32_t ty_path_class_reflected(int32_t part) {
    return part <= TY_PATH_REFLECTED ? TY_PATH_REFLECTED : TY_PATH_MULTIPLE;
}

TY_FN void ty_path_add(ty_path* path, const float radiance[3]) {
    for (int c = 0; c < 3; ++c) path->radiance[path->path_class][c] += radiance[c];
}

/* What a ray that hit a surface finds there. */
typedef struct ty_intersection {
    ty_hit hit;
    ty_surface_point point;
} ty_intersection;

/* The share of light met on a surface that light sampling from where the ray began leaves to the ray. */
TY_FN float ty_path_mis_weight_emission(const ty_path* path, const ty_intersection* end) {
    const ty_light_set* lights = &path->request->scene->lights;
    const float distance = end->hit.distance;
    float weight = 1.0f;
    if (end->point.light < 0) return weight;
    const ty_light_view* light = &lights->lights[end->point.light];
    const float density = ty_light_pdf(light, path->origin, path->direction, distance);
    if (path->pdf > 0.0f) {
        const float chosen = ty_lights_probability(lights, end->point.light, path->origin, path->normal);
        weight = path->pdf / (path->pdf + chosen * density);
    }
    if (path->scattered != 0 && ty_light_is_local(light->kind))
        weight *= ty_mis_weight_collision(distance * distance, light->reach2, density, path->phase);
    return weight;
}

/* Light that the ray meets at its end. end: NULL where it meets no surface. */
TY_FN void ty_path_add_emission(ty_path* path, const float throughput[3], const ty_intersection* end) {
    const ty_light_set* lights = &path->request->scene->lights;
    float radiance[3];
    if (end != NULL) {
        if (!(ty_max3(end->point.emission) > 0.0f)) return;
        const float weight = ty_path_mis_weight_emission(path, end);
        for (int c = 0; c < 3; ++c) radiance[c] = throughput[c] * end->point.emission[c] * weight;
        ty_path_add(path, radiance);
        return;
    }
    for (int32_t i = 0; i < lights->distant_count; ++i) {
        const ty_light_view* light = &lights->lights[lights->distant[i]];
        if (light->kind != TY_KIND_ENVIRONMENT) continue;
        float weight = 1.0f;
        if (path->pdf > 0.0f && light->chosen > 0.0f)
            weight = path->pdf / (path->pdf + light->chosen * ty_environment_pdf(&light->environment, path->direction));
        ty_environment_radiance(&light->environment, path->direction, radiance);
        for (int c = 0; c < 3; ++c) radiance[c] *= throughput[c] * weight;
        ty_path_add(path, radiance);
    }
}

/* ---- directions in media ---- */

/* What scatters at a vertex: phase functions per channel, mixed by throughput, and lobes about lights. */
typedef struct ty_scatter_vertex {
    ty_vec incoming;
    float g[3];
    float share[3]; /* of the channels in the mixture; add up to 1 */
    int32_t gray;
    float guided;     /* probability of sampling a lobe about a light */
    float guide_g[3]; /* g, g^2, g^4: light that scatters once, twice, four times more */
    int32_t guide_count;
    ty_vec axis[TY_GUIDES_MAX];
    const float* axis_share;
} ty_scatter_vertex;

TY_FN ty_vec ty_light_axis(const ty_light_view* light, ty_vec from) {
    if (light->kind == TY_KIND_DIRECTIONAL) return ty_scale(light->direction, -1.0f);
    ty_vec to = ty_sub(light->position, from);
    const float middle = light->kind == TY_KIND_TRIANGLE ? 1.0f / 3.0f : 0.5f;
    if (light->kind == TY_KIND_AREA || light->kind == TY_KIND_TRIANGLE)
        to = ty_mad(ty_mad(to, light->u, middle), light->v, middle);
    const float d2 = ty_dot(to, to);
    return d2 > 1e-30f ? ty_scale(to, 1.0f / sqrtf(d2)) : ty_vec_make(0, 0, 1);
}

/* How much of the directions at a path's vertex of some depth (1: the first) is given to lobes about lights: much only
 * where g nears 1, and falling with depth fast enough that the weights of paths that never take a lobe stay bounded
 * (by 14). Both were chosen by measured cost of noise, in thin and in thick media. */
TY_FN float ty_guided_fraction(float g, int32_t depth) {
    const float g2 = ty_maxf(g, 0.0f) * ty_maxf(g, 0.0f), g4 = g2 * g2;
    const float fall = 1.0f / (1.0f + 0.25f * (float)(depth - 1));
    return 0.6f * g4 * g4 * fall * fall;
}

TY_FN void ty_scatter_vertex_begin(ty_scatter_vertex* s, const ty_path* path, const ty_medium_view* medium) {
    const ty_path_request* request = path->request;
    const float sum = ty_sum3(path->beta);
    float g = 0.0f;
    s->incoming = path->direction;
    s->gray = medium->gray_g;
    ty_medium_g(medium, path->origin, s->g);
    for (int c = 0; c < 3; ++c) {
        s->share[c] = path->beta[c] / sum;
        g += s->share[c] * s->g[c];
    }
    s->guide_count = request->guide_count;
    s->axis_share = request->guide_share;
    s->guided = s->guide_count > 0 ? ty_guided_fraction(g, path->depth) : 0.0f;
    if (s->guided <= 0.0f) return;
    s->guide_g[0] = g;
    s->guide_g[1] = g * g;
    s->guide_g[2] = g * g * g * g;
    for (int32_t i = 0; i < s->guide_count; ++i)
        s->axis[i] = ty_light_axis(&request->scene->lights.lights[request->guide_light[i]], path->origin);
}

/* The phase function per channel. */
TY_FN void ty_scatter_vertex_phase(const ty_scatter_vertex* s, ty_vec direction, float phase[3]) {
    const float mu = ty_clampf(ty_dot(s->incoming, direction), -1.0f, 1.0f);
    phase[0] = ty_hg(mu, s->g[0]);
    phase[1] = s->gray != 0 ? phase[0] : ty_hg(mu, s->g[1]);
    phase[2] = s->gray != 0 ? phase[0] : ty_hg(mu, s->g[2]);
}

TY_FN float ty_scatter_vertex_pdf(const ty_scatter_vertex* s, ty_vec direction, const float phase[3]) {
    const float plain = s->share[0] * phase[0] + s->share[1] * phase[1] + s->share[2] * phase[2];
    if (s->guided <= 0.0f) return plain;
    float lobes = 0.0f;
    for (int32_t i = 0; i < s->guide_count; ++i) {
        const float mu = ty_clampf(ty_dot(s->axis[i], direction), -1.0f, 1.0f);
        lobes += s->axis_share[i] * (ty_hg(mu, s->guide_g[0]) + ty_hg(mu, s->guide_g[1]) + ty_hg(mu, s->guide_g[2]));
    }
    return ty_lerpf(plain, lobes * (1.0f / 3.0f), s->guided);
}

TY_FN ty_vec ty_scatter_vertex_sample(const ty_scatter_vertex* s, ty_sampler* random) {
    const float v = ty_sobol_next(random);
    float u = ty_sobol_next(random);
    ty_vec axis = s->incoming;
    float g = s->g[0];
    if (u < s->guided) {
        const float lobes[3] = {1.0f, 1.0f, 1.0f};
        u /= s->guided;
        axis = s->axis[ty_sample_discrete(s->axis_share, s->guide_count, 1.0f, &u)];
        g = s->guide_g[ty_sample_discrete(lobes, 3, 3.0f, &u)];
    } else {
        u = (u - s->guided) / (1.0f - s->guided);
        if (s->gray == 0) g = s->g[ty_sample_discrete(s->share, 3, 1.0f, &u)];
    }
    return ty_hg_sample(axis, g, ty_minf(u, 0x1.fffffep-1f), v);
}

/* ---- vertices ---- */

/* The light chosen for a vertex with what probability, and its sample, unshadowed; NULL if there is none. */
TY_FN const ty_light_view* ty_path_choose_light(ty_path* path, ty_vec from, float* chosen, ty_light_sample* sample) {
    const ty_light_set* lights = &path->request->scene->lights;
    if (lights->count == 0) return NULL;
    float pick = lights->count > 1 ? ty_sobol_next(&path->random) : 0.0f;
    const int32_t i = ty_lights_choose(lights, from, path->normal, &pick, chosen);
    if (i < 0) return NULL;
    const ty_light_view* light = &lights->lights[i];
    float u = 0.5f, v = 0.5f;
    if (light->kind >= TY_KIND_AREA) {
        u = ty_sobol_next(&path->random);
        v = ty_sobol_next(&path->random);
    }
    return ty_light_sample_from(light, from, u, v, sample) ? light : NULL;
}

/* Whether no surface lies between a point and a light sample. */
TY_FN bool ty_path_light_visible(const ty_path* path, ty_vec from, const ty_light_sample* sample) {
    const ty_accel* mesh = path->request->scene->mesh;
    const float far = sample->distance < TY_FLOAT_MAX ? sample->distance * 0.9999f : TY_FLOAT_MAX;
    return mesh == NULL || !ty_accel_occluded(mesh, from, sample->wi, far);
}

/* Adds a light sample, with factor per channel (throughput, phase or reflectance, cosine), if nothing shadows it;
 * media attenuate it. */
TY_FN void ty_path_add_light(ty_path* path, ty_vec origin, const ty_light_sample* sample, const float factor[3],
                             float radiance[3]) {
    const ty_scene_view* scene = path->request->scene;
    float transmittance[3];
    for (int c = 0; c < 3; ++c) radiance[c] = factor[c] * sample->radiance[c];
    const float most = ty_max3(radiance);
    if (most < path->request->faint) {
        const float chance = most / path->request->faint;
        const bool traced = ty_rng_uniform(&path->random) < chance;
        for (int c = 0; c < 3; ++c) radiance[c] = traced ? radiance[c] / chance : 0.0f;
    }
    if (ty_sum3(radiance) > 0.0f && !ty_path_light_visible(path, origin, sample))
        for (int c = 0; c < 3; ++c) radiance[c] = 0.0f;
    if (!(ty_sum3(radiance) > 0.0f)) return;
    ty_transmittance(scene->media, scene->medium_count, origin, sample->wi, sample->distance, &path->random,
                     transmittance);
    for (int c = 0; c < 3; ++c) radiance[c] *= transmittance[c];
}

/* Samples a light from a vertex whose factor (see above) the caller knows how to evaluate: the weight is shared with
 * the vertex taking that direction itself, with density pdf, and with equi-angular sampling of the last stretch. phase:
 * in media, the phase function (green) towards the sample. */
TY_FN void ty_path_add_vertex_light(ty_path* path, const ty_light_view* light, float chosen,
                                    const ty_light_sample* sample, const float factor[3], float pdf, float phase) {
    float weight = 1.0f / chosen, weighted[3], radiance[3];
    if (sample->pdf > 0.0f) weight = sample->pdf / (chosen * sample->pdf + pdf);
    if (path->scattered != 0 && ty_light_is_local(light->kind))
        weight *= ty_mis_weight_collision(sample->distance * sample->distance, light->reach2, sample->pdf, phase);
    for (int c = 0; c < 3; ++c) weighted[c] = path->beta[c] * factor[c] * weight;
    ty_path_add_light(path, path->origin, sample, weighted, radiance);
    ty_path_add(path, radiance);
}

/* The equi-angular technique on the ray that the path has just begun: adds light scattered once along it. Rays that
 * pass a lamp at a distance take part by chance. */
TY_FN void ty_path_add_equiangular(ty_path* path, const ty_spans* spans) {
    const ty_scene_view* scene = path->request->scene;
    const ty_ray_interval stretch = ty_spans_interval(spans);
    float pick = scene->lights.local_count > 1 ? ty_rng_uniform(&path->random) : 0.0f, chosen = 1.0f;
    const int32_t lamp = ty_lights_choose_local(&scene->lights, path->origin, path->direction, stretch.enter,
                                                stretch.leave, &pick, &chosen);
    const float u = ty_sobol_next(&path->random), v = ty_sobol_next(&path->random);
    const float along = ty_sobol_next(&path->random);
    if (lamp < 0) return;
    const ty_light_view* light = &scene->lights.lights[lamp];
    float b1, b2;
    const bool flat = light->kind == TY_KIND_AREA || light->kind == TY_KIND_TRIANGLE;
    const ty_vec place = flat ? ty_light_place(light, u, v, &b1, &b2) : light->position;
    const ty_vec to = ty_sub(place, path->origin);
    const float nearest = ty_dot(to, path->direction);
    const ty_vec off = ty_mad(to, path->direction, -nearest);
    const float off2 = ty_dot(off, off) + 1e-10f * light->reach2;
    const float beyond = nearest - ty_clampf(nearest, stretch.enter, stretch.leave);
    const float chance = ty_mis_near_weight(off2 + beyond * beyond, light->reach2);
    if (ty_rng_uniform(&path->random) >= chance) return;
    float t;
    const float density = ty_equiangular_sample(stretch, nearest, sqrtf(off2), along, &t);
    const ty_vec at = ty_mad(path->origin, path->direction, t);
    ty_light_sample sample;
    if (!ty_light_sample_from(light, at, u, v, &sample)) return;
    const float near = ty_mis_near_weight(sample.distance * sample.distance, light->reach2);
    const float weight = near / (chosen * density * chance);
    const float mu = ty_clampf(ty_dot(path->direction, sample.wi), -1.0f, 1.0f);
    float factor[3] = {0.0f, 0.0f, 0.0f}, transmittance[3], radiance[3];
    for (int32_t i = 0; i < spans->count; ++i) {
        if (t < spans->enter[i] || t > spans->leave[i]) continue;
        const ty_medium_view* medium = &scene->media[spans->medium[i]];
        float sigma_s[3], g[3];
        ty_medium_sigma_s(medium, at, sigma_s);
        ty_medium_g(medium, at, g);
        const float share = ty_mis_small_light_weight(sample.pdf, ty_hg(mu, g[1]));
        const float amount = share * weight * ty_medium_density(medium, at, &path->random);
        for (int c = 0; c < 3; ++c) factor[c] += path->beta[c] * amount * sigma_s[c] * ty_hg(mu, g[c]);
    }
    if (!(ty_sum3(factor) > 0.0f)) return;
    ty_path_add_light(path, at, &sample, factor, radiance);
    if (!(ty_sum3(radiance) > 0.0f)) return;
    ty_transmittance(scene->media, scene->medium_count, path->origin, path->direction, t, &path->random, transmittance);
    for (int c = 0; c < 3; ++c)
        path->radiance[ty_path_class_scattered(path->path_class)][c] += radiance[c] * transmittance[c];
}

/* Light scattered at path->origin by a medium, and the direction in which the path goes on. */
TY_FN void ty_path_scatter(ty_path* path, const ty_medium_view* medium) {
    ty_scatter_vertex scatter;
    ty_light_sample sample;
    float phase[3], chosen;
    path->normal = ty_vec_make(0, 0, 0);
    ty_scatter_vertex_begin(&scatter, path, medium);
    const ty_light_view* light = ty_path_choose_light(path, path->origin, &chosen, &sample);
    if (light != NULL) {
        ty_scatter_vertex_phase(&scatter, sample.wi, phase);
        ty_path_add_vertex_light(path, light, chosen, &sample, phase,
                                 sample.pdf > 0.0f ? ty_scatter_vertex_pdf(&scatter, sample.wi, phase) : 0.0f,
                                 phase[1]);
    }
    path->direction = ty_scatter_vertex_sample(&scatter, &path->random);
    ty_scatter_vertex_phase(&scatter, path->direction, phase);
    path->phase = phase[1];
    path->pdf = ty_scatter_vertex_pdf(&scatter, path->direction, phase);
    for (int c = 0; c < 3; ++c) path->beta[c] *= phase[c] / path->pdf;
}

/* A cosine-distributed direction about the normal of the point where the path is. */
TY_FN void ty_path_sample_cosine_hemisphere(ty_path* path) {
    const float u = ty_sobol_next(&path->random), v = ty_sobol_next(&path->random);
    const float cosine = ty_maxf(sqrtf(1.0f - u), 1e-4f);
    path->direction = ty_direction_about(path->normal, cosine, v);
    path->pdf = cosine * (1.0f / TY_PI);
}

/* Any direction with equal density. */
TY_FN void ty_path_sample_sphere(ty_path* path) {
    const float u = ty_sobol_next(&path->random), v = ty_sobol_next(&path->random);
    path->direction = ty_direction_about(ty_vec_make(0, 0, 1), 1.0f - 2.0f * u, v);
    path->pdf = TY_INV_4PI;
}

/* Light reflected by a Lambertian surface, and the direction in which the path goes on. Cosines are those of the
 * smoothed normal; nothing comes from behind the face itself. */
TY_FN void ty_path_reflect(ty_path* path, const ty_intersection* at) {
    const ty_surface_point* point = &at->point;
    ty_light_sample sample;
    float factor[3], chosen;
    path->origin = ty_hit_leave(&at->hit, point->ng);
    path->normal = point->ns;
    const ty_light_view* light = ty_path_choose_light(path, path->origin, &chosen, &sample);
    const float facing = light != NULL ? ty_dot(point->ns, sample.wi) * (1.0f / TY_PI) : 0.0f;
    if (facing > 0.0f && ty_dot(point->ng, sample.wi) > 0.0f) {
        for (int c = 0; c < 3; ++c) factor[c] = point->albedo[c] * facing;
        ty_path_add_vertex_light(path, light, chosen, &sample, factor, facing, 0.0f);
    }
    ty_path_sample_cosine_hemisphere(path);
    const bool outside = ty_dot(point->ng, path->direction) > 0.0f;
    for (int c = 0; c < 3; ++c) path->beta[c] *= outside ? point->albedo[c] : 0.0f;
    path->rr_throughput *= ty_max3(point->albedo);
}

/* Ends paths that have little left to bring, by a chance that keeps the mean. */
TY_FN bool ty_path_survives(ty_path* path, float before) {
    const float now = ty_sum3(path->beta);
    if (!(now > 0.0f)) return false;
    path->rr_throughput *= ty_minf(1.0f, now / before);
    /* What lobes took away can come back, but not more than the phase functions differ by. */
    path->rr_throughput = ty_minf(path->rr_throughput, 1e6f * now);
    /* Light that nothing absorbs in a closed room would go round for ever. */
    if (path->depth >= TY_PATH_ROULETTE_DEPTH) path->rr_throughput *= 0.99f;
    if (path->rr_throughput >= 0.2f) return true;
    const float chance = ty_maxf(path->rr_throughput * 2.5f, 0.02f);
    if (ty_rng_uniform(&path->random) >= chance) return false;
    for (int c = 0; c < 3; ++c) path->beta[c] /= chance;
    path->rr_throughput /= chance;
    return true;
}

/* Without scattering: the path goes on to its ray's end (NULL: it meets no surface), as much of it as media let pass.
 * True when it stands at a surface that reflects. Means of several estimates towards the eye would cost what they save.
 */
TY_FN bool ty_path_pass_unscattered(ty_path* path, const ty_intersection* end, float before) {
    const ty_scene_view* scene = path->request->scene;
    const float far = end != NULL ? end->hit.distance : TY_FLOAT_MAX;
    float transmittance[3];
    ty_transmittance(scene->media, scene->medium_count, path->origin, path->direction, far, &path->random,
                     transmittance);
    for (int c = 0; c < 3; ++c) path->beta[c] *= transmittance[c];
    ty_path_add_emission(path, path->beta, end);
    return end != NULL && ty_max3(end->point.albedo) > 0.0f && ty_path_survives(path, before);
}

/* The next event of a path: true when it now stands at a vertex, in *medium or, where that is NULL, at *end. */
TY_FN bool ty_path_next_event(ty_path* path, const ty_medium_view** medium, ty_intersection* end) {
    const ty_scene_view* scene = path->request->scene;
    const ty_medium_view* media = scene->media;
    const float before = ty_sum3(path->beta);
    if (!(before > 1e-30f)) return false;
    const bool last = (path->request->max_depth > 0 && path->depth >= path->request->max_depth) ||
                      (path->request->max_run > 0 && path->run >= path->request->max_run);
    const bool on_surface =
        scene->mesh != NULL && ty_accel_intersect(scene->mesh, path->origin, path->direction, TY_FLOAT_MAX, &end->hit);
    if (on_surface) ty_surface_evaluate(&scene->surfaces[end->hit.surface], &end->hit, path->direction, &end->point);
    *medium = NULL;
    if (path->request->unscattered != 0) return ty_path_pass_unscattered(path, on_surface ? end : NULL, before);
    ty_spans spans;
    ty_collision collision;
    float glow[3] = {0.0f, 0.0f, 0.0f};
    ty_spans_find(media, scene->medium_count, path->origin, path->direction,
                  on_surface ? end->hit.distance : TY_FLOAT_MAX, &spans);
    if (spans.count > 0 && scene->lights.local_count > 0 && !last) ty_path_add_equiangular(path, &spans);
    if (spans.heterogeneous != 0) {
        const bool collides = ty_delta_tracking(media, &spans, path->origin, path->direction, &path->random, path->beta,
                                                glow, &collision);
        if (spans.emits != 0) ty_path_add(path, glow);
        if (collides) {
            *medium = &media[collision.medium];
            path->scattered = 1;
            path->origin = ty_mad(path->origin, path->direction, collision.t);
            return ty_path_survives(path, before);
        }
        ty_path_add_emission(path, path->beta, on_surface ? end : NULL);
        path->scattered = 0;
        return on_surface && ty_max3(end->point.albedo) > 0.0f && ty_path_survives(path, before);
    }
    /* Homogeneous media: what reaches the end is known, so its light is taken in full and the path goes where it has
     * more to bring. */
    float depth[3], stopped[3], passing[3], reflecting = 0.0f, colliding = 0.0f;
    ty_spans_optical_depth(media, &spans, TY_FLOAT_MAX, depth);
    if (spans.emits != 0) {
        ty_spans_emitted_radiance(media, &spans, glow);
        for (int c = 0; c < 3; ++c) glow[c] *= path->beta[c];
        ty_path_add(path, glow);
    }
    for (int c = 0; c < 3; ++c) {
        stopped[c] = ty_collision_probability(depth[c]);
        passing[c] = path->beta[c] * ty_expf(-depth[c]);
        colliding += path->beta[c] * stopped[c];
        if (on_surface) reflecting += passing[c] * end->point.albedo[c];
    }
    ty_path_add_emission(path, passing, on_surface ? end : NULL);
    const float sum = colliding + reflecting;
    if (!(sum > 0.0f)) return false;
    const float chance = colliding / sum;
    const float u = ty_sobol_next(&path->random);
    if (u < chance) {
        if (!ty_sample_homogeneous_collision(media, &spans, stopped, u / chance, &path->random, path->beta, &collision))
            return false;
        for (int c = 0; c < 3; ++c) path->beta[c] /= chance;
        *medium = &media[collision.medium];
        path->scattered = 1;
        path->origin = ty_mad(path->origin, path->direction, collision.t);
    } else {
        for (int c = 0; c < 3; ++c) path->beta[c] = passing[c] / (1.0f - chance);
        path->scattered = 0;
    }
    return ty_path_survives(path, before);
}

/* Follows a path to its end; returns its vertices. */
TY_FN uint32_t ty_path_follow(ty_path* path) {
    const int32_t max_depth = path->request->max_depth;
    const ty_medium_view* medium;
    ty_intersection end;
    uint32_t vertices = 0;
    while (ty_path_next_event(path, &medium, &end)) {
        if (max_depth > 0 && path->depth >= max_depth) break;
        path->run = medium != NULL ? path->run + 1 : 0;
        if (path->request->max_run > 0 && path->run > path->request->max_run) break;
        ++path->depth;
        ++vertices;
        path->path_class =
            medium != NULL ? ty_path_class_scattered(path->path_class) : ty_path_class_reflected(path->path_class);
        if (medium != NULL)
            ty_path_scatter(path, medium);
        else
            ty_path_reflect(path, &end);
    }
    return vertices;
}

TY_FN void ty_path_begin(ty_path* path, const ty_path_request* request, uint64_t item, uint32_t sample) {
    path->request = request;
    path->random = ty_sampler_begin(request->sobol, request->seed, item, sample);
    path->rr_throughput = 1.0f;
    path->pdf = 0.0f;
    path->scattered = 0;
    path->phase = 0.0f;
    path->depth = 0;
    path->run = 0;
    path->path_class = TY_PATH_UNCOLLIDED;
    path->normal = ty_vec_make(0, 0, 0);
    for (int c = 0; c < 3; ++c) path->beta[c] = 1.0f;
    memset(path->radiance, 0, sizeof path->radiance);
}

/* Starts a path that measures fluence at point: light from everywhere, with equal weight. */
TY_FN void ty_path_begin_fluence(ty_path* path, ty_vec point) {
    const float factor[3] = {1.0f, 1.0f, 1.0f};
    ty_light_sample sample;
    float chosen;
    path->origin = point;
    const ty_light_view* light = ty_path_choose_light(path, point, &chosen, &sample);
    if (light != NULL) ty_path_add_vertex_light(path, light, chosen, &sample, factor, TY_INV_4PI, 0.0f);
    ty_path_sample_sphere(path);
    for (int c = 0; c < 3; ++c) path->beta[c] = 1.0f / TY_INV_4PI;
}

#endif
