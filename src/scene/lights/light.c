/* Lights: checks, views, and selection probabilities. */
#include "scene/lights/light.h"

#include "base/constants.h"
#include "base/context.h"
#include "base/check.h"
#include "scene/surfaces/shape.h"

void ty_init_light_def(void* def, size_t bytes) {
    const ty_light_def own = {.kind = TY_LIGHT_DIRECTIONAL,
                              .color = {1, 1, 1},
                              .direction = {0, -1, 0},
                              .cone = 40,
                              .penumbra = 0.15,
                              .scale = 1};
    ty_init_def(def, bytes, &own, sizeof own);
}

ty_result ty_light_check(ty_context* context, const ty_light_def** given, ty_light_def* own) {
    *own = ty_default_light_def();
    ty_result result = ty_take_def(context, *given, "ty_default_light_def", own, sizeof *own);
    const ty_light_def* def = *given = own;
    if (result == TY_OK) result = ty_check_rgb(context, "light.color", def->color, 0, TY_COLOR_MAX);
    if (result != TY_OK) return result;
    switch (def->kind) {
    case TY_LIGHT_DIRECTIONAL: return ty_check_direction(context, "light.direction", def->direction);
    case TY_LIGHT_POINT:
        result = ty_check_point(context, "light.position", def->position);
        return result == TY_OK ? ty_check_number(context, "light.radius", def->radius, 0, 1e9) : result;
    case TY_LIGHT_SPOT:
        result = ty_check_point(context, "light.position", def->position);
        if (result == TY_OK) result = ty_check_number(context, "light.radius", def->radius, 0, 1e9);
        if (result == TY_OK) result = ty_check_direction(context, "light.direction", def->direction);
        if (result == TY_OK && !(def->cone > 0 && def->cone <= 180))
            result = ty_fail(context, TY_ERROR_ARGUMENT, "light.cone: %g is outside (0, 180]", def->cone);
        if (result == TY_OK) result = ty_check_number(context, "light.penumbra", def->penumbra, 0, 1);
        return result;
    case TY_LIGHT_AREA:
        result = ty_check_point(context, "light.position", def->position);
        return result == TY_OK ? ty_check_edges(context, "light", def->u, def->v) : result;
    case TY_LIGHT_ENVIRONMENT:
        result = ty_check_number(context, "light.scale", def->scale, 0, TY_COLOR_MAX);
        return result == TY_OK ? ty_check_number(context, "light.rotation", def->rotation, -36000, 36000) : result;
    }
    return ty_fail(context, TY_ERROR_ARGUMENT, "light.kind: %d is not a ty_light_kind", (int)def->kind);
}

static ty_vec to_vec(const double v[3]) {
    return ty_vec_make((float)v[0], (float)v[1], (float)v[2]);
}

static ty_vec normalized(const double v[3]) {
    const double length = sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
    return ty_vec_make((float)(v[0] / length), (float)(v[1] / length), (float)(v[2] / length));
}

ty_light_view ty_light_quad_view(const double origin[3], const double u[3], const double v[3],
                                 const float radiance[3]) {
    ty_light_view view;
    memset(&view, 0, sizeof view);
    view.kind = TY_KIND_AREA;
    view.position = to_vec(origin);
    view.u = to_vec(u);
    view.v = to_vec(v);
    view.direction = ty_shape_normal(u, v);
    const ty_vec cross = ty_cross(view.u, view.v);
    view.area = sqrtf(ty_dot(cross, cross));
    memcpy(view.color, radiance, sizeof view.color);
    return view;
}

ty_light_view ty_light_sphere_view(const double center[3], double radius, const float radiance[3]) {
    ty_light_view view;
    memset(&view, 0, sizeof view);
    view.kind = TY_KIND_SPHERE;
    view.position = to_vec(center);
    view.radius = (float)radius;
    memcpy(view.color, radiance, sizeof view.color);
    return view;
}

/* Number of texels of a texture under a triangle. */
static double count_texels(const ty_surface* surface, const ty_texture_view* texture, int32_t set, const float map[6],
                           int32_t triangle) {
    const uint32_t* corners = surface->indices + 3 * (size_t)triangle;
    const float* uv = surface->uv[set];
    if (uv == NULL || !ty_texture_exists(texture)) return 1;
    const float* a = uv + 2 * (size_t)corners[0];
    const float* b = uv + 2 * (size_t)corners[1];
    const float* c = uv + 2 * (size_t)corners[2];
    const double area = fabs((double)(b[0] - a[0]) * (c[1] - a[1]) - (double)(b[1] - a[1]) * (c[0] - a[0])) / 2;
    return area * fabs((double)map[0] * map[4] - (double)map[1] * map[3]) * texture->width * texture->height;
}

/* Mean radiance over a textured triangle: about one sample per texel, 16..4096. */
static void mean_emission(const ty_surface* surface, int32_t triangle, float mean[3]) {
    const double texels =
        fmax(count_texels(surface, &surface->emission_texture, surface->emission_uv, surface->emission_map, triangle),
             count_texels(surface, &surface->albedo_texture, surface->albedo_uv, surface->albedo_map, triangle));
    const int32_t side = (int32_t)fmin(fmax(ceil(sqrt(texels)), 4), 64);
    double sum[3] = {0, 0, 0};
    for (int32_t j = 0; j < side; ++j)
        for (int32_t i = 0; i < side; ++i) {
            const float root = sqrtf(((float)i + 0.5f) / (float)side), v = ((float)j + 0.5f) / (float)side;
            float emission[3];
            ty_surface_mean_emission(surface, triangle, 1.0f - root, root * v, emission);
            for (int c = 0; c < 3; ++c) sum[c] += (double)emission[c];
        }
    for (int c = 0; c < 3; ++c) mean[c] = (float)(sum[c] / side / side);
}

bool ty_light_triangle_view(const ty_surface* surface, int32_t triangle, ty_light_view* out) {
    const uint32_t* corners = surface->indices + 3 * (size_t)triangle;
    memset(out, 0, sizeof *out);
    out->kind = TY_KIND_TRIANGLE;
    out->position = ty_vec_load(surface->positions + 3 * (size_t)corners[0]);
    out->u = ty_sub(ty_vec_load(surface->positions + 3 * (size_t)corners[1]), out->position);
    out->v = ty_sub(ty_vec_load(surface->positions + 3 * (size_t)corners[2]), out->position);
    out->direction = ty_triangle_normal(out->u, out->v, &out->area);
    if (!(out->area > 0)) return false;
    out->two_sided = surface->two_sided;
    out->primitive_id = triangle;
    if (ty_texture_exists(&surface->emission_texture) || surface->alpha_mode != TY_ALPHA_OPAQUE) {
        out->textured = surface;
        mean_emission(surface, triangle, out->color);
    } else {
        memcpy(out->color, surface->emission, sizeof out->color);
    }
    return out->color[0] > 0 || out->color[1] > 0 || out->color[2] > 0;
}

bool ty_light_is_surface(const ty_light_def* def) {
    const bool local_light = def->kind == TY_LIGHT_POINT || def->kind == TY_LIGHT_SPOT;
    return def->kind == TY_LIGHT_AREA || (local_light && def->radius > 0);
}

ty_shape_def ty_light_shape(const ty_light_def* def) {
    ty_shape_def shape = ty_default_shape_def();
    double radiance_per_color = 1;
    if (def->kind != TY_LIGHT_AREA) {
        shape.kind = TY_SHAPE_SPHERE;
        shape.radius = def->radius;
        radiance_per_color = 1 / (TY_PI_F64 * def->radius * def->radius); /* L = I / (pi r^2) */
    }
    for (int a = 0; a < 3; ++a) {
        shape.origin[a] = def->position[a];
        shape.u[a] = def->u[a];
        shape.v[a] = def->v[a];
        shape.albedo[a] = 0;
        shape.emission[a] = (float)fmin((double)def->color[a] * radiance_per_color, TY_COLOR_MAX);
    }
    return shape;
}

void ty_light_set_cone(const ty_light_def* def, ty_light_view* view) {
    const double half = def->cone * (TY_PI_F64 / 360);
    view->cone = true;
    view->direction = normalized(def->direction);
    view->cos_outer = (float)cos(half);
    view->cos_inner = (float)cos(half * (1 - def->penumbra));
}

ty_light_view ty_light_get_view(const ty_light_def* def, const ty_environment* environment, ty_axis up) {
    ty_light_view view;
    memset(&view, 0, sizeof view);
    view.kind = (int32_t)def->kind;
    memcpy(view.color, def->color, sizeof view.color);
    view.position = to_vec(def->position);
    if (def->kind == TY_LIGHT_DIRECTIONAL) view.direction = normalized(def->direction);
    if (def->kind == TY_LIGHT_SPOT) ty_light_set_cone(def, &view);
    if (def->kind == TY_LIGHT_ENVIRONMENT) {
        view.environment = ty_environment_get_view(environment, up);
        memcpy(view.color, environment->mean, sizeof view.color);
    }
    return view;
}

/* Fluence at squared distance d2, W m^-2, mean of the channels. A constant environment counts as 0: paths hit it
 * uniformly by themselves, so that sampling would only add noise. */
static double typical_fluence(const ty_light_view* light, double d2) {
    const double color = ((double)light->color[0] + light->color[1] + light->color[2]) / 3;
    switch (light->kind) {
    case TY_KIND_ENVIRONMENT: return light->environment.pixels == NULL ? 0 : 4 * TY_PI_F64 * color;
    case TY_KIND_POINT:
    case TY_KIND_SPOT: return color / d2;
    case TY_KIND_AREA: return color * light->area / d2;
    case TY_KIND_TRIANGLE: return color * light->area * (light->two_sided != 0 ? 2 : 1) / d2;
    case TY_KIND_SPHERE: return color * TY_PI_F64 * light->radius * light->radius / d2;
    default: return color;
    }
}

/* Squared distance from a light's position to the box [lower, upper]. */
static double distance2_to_box(const ty_light_view* light, const double lower[3], const double upper[3]) {
    const double position[3] = {light->position.x, light->position.y, light->position.z};
    double sum = 0;
    for (int a = 0; a < 3; ++a) {
        const double outside = fmax(fmax(lower[a] - position[a], position[a] - upper[a]), 0);
        sum += outside * outside;
    }
    return sum;
}

static bool is_positioned(const ty_light_view* light) {
    return light->kind != TY_KIND_DIRECTIONAL && light->kind != TY_KIND_ENVIRONMENT;
}

float ty_light_set_choice(ty_light_view* lights, size_t count, const double lower[3], const double upper[3]) {
    double d2 = 0, positioned = 0, sum = 0;
    size_t choices = 0;
    for (int a = 0; a < 3; ++a) d2 += (upper[a] - lower[a]) * (upper[a] - lower[a]) / 16;
    if (!(d2 > 0)) d2 = 1;
    for (size_t i = 0; i < count; ++i) {
        const double outside2 = is_positioned(&lights[i]) ? distance2_to_box(&lights[i], lower, upper) : 0;
        lights[i].typical = (float)fmin(typical_fluence(&lights[i], d2 + outside2), 1e30);
        lights[i].reach2 = (float)fmax(0.3 * lights[i].area, 0.015 * d2);
        sum += (double)lights[i].typical;
        if (is_positioned(&lights[i]))
            positioned += (double)lights[i].typical;
        else
            choices += lights[i].typical > 0;
    }
    choices += positioned > 0;
    const double uniform_probability = choices > 0 ? 0.1 / (double)choices : 0;
    const double positioned_probability = positioned > 0 ? 0.9 * positioned / sum + uniform_probability : 0;
    double running = positioned_probability;
    for (size_t i = 0; i < count; ++i) {
        if (is_positioned(&lights[i]) || !(lights[i].typical > 0)) continue;
        lights[i].chosen = (float)(0.9 * (double)lights[i].typical / sum + uniform_probability);
        running += (double)lights[i].chosen;
        lights[i].cumulative = (float)running;
    }
    return (float)positioned_probability;
}
