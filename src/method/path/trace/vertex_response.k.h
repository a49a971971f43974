/* Responses of vertices to directions that they do not sample themselves: phase functions, BSDFs. */
#ifndef TY_METHOD_PATH_TRACE_VERTEX_RESPONSE_K_H
#define TY_METHOD_PATH_TRACE_VERTEX_RESPONSE_K_H

#include "method/path/trace/interface.k.h"
#include "method/path/trace/scatter.k.h"

/* Response of a vertex to a direction that it does not sample itself: of scatter, of surface, or of neither for a point
 * that receives light evenly. */
typedef struct ty_vertex_response {
    const ty_scatter_vertex* scatter;
    const ty_surface_point* surface;
    const ty_guide_vertex* guide; /* of a diffuse surface; NULL: none */
} ty_vertex_response;

/* Phase function, or BSDF times cosine, for light from a direction; returns the density with which the vertex samples
 * that direction, 1/sr, or 0 if no light comes from there. */
TY_FN float ty_vertex_response_evaluate(const ty_vertex_response* response, ty_vec direction, float factor[3]) {
    if (response->scatter != NULL) {
        ty_scatter_vertex_phase(response->scatter, direction, factor);
        return ty_scatter_vertex_pdf(response->scatter, direction, factor);
    }
    const ty_surface_point* point = response->surface;
    if (point == NULL) {
        for (int c = 0; c < 3; ++c) factor[c] = 1.0f;
        return TY_INV_4PI;
    }
    if (TY_PATH_GLOSS != 0 && point->glossy != 0) return ty_surface_evaluate_bsdf(point, direction, factor);
    const float cosine = ty_dot(point->ns, direction) * (1.0f / TY_PI);
    if (!(cosine > 0.0f) || !(ty_dot(point->ng, direction) > 0.0f)) return 0.0f;
    for (int c = 0; c < 3; ++c) factor[c] = point->albedo[c] * cosine;
    return ty_guide_vertex_pdf(response->guide, direction, cosine);
}

#endif
