/* Cells of an interior, and the faces between them and its surface. */
#include "solve/enclosed/body.h"

#include "base/context.h"
#include "scene/media/medium.h"
#include "scene/media/spans.k.h"
#include "solve/diffusion/fresnel_boundary.h"

#include <math.h>

/* Fraction of the scattering that may count as unscattered. */
static const float max_peak = 0.2f;
/* Cells along the longest side by default. */
enum { MIN_CELLS = 32, MAX_CELLS = 48 };
/* Thickness of a cell, transport mean free paths, above which in all channels ordinates give way to diffusion. */
static const double max_thickness = 2;
/* Samples of a varying density per cell. */
enum { DENSITY_SAMPLES = 8 };
/* Surfaces of other solids beside that of an interior that a ray passes at most. */
enum { MAX_OVERLAPS = 4 };

/* ---- memory ---- */

void ty_enclosed_body_destroy(ty_enclosed_body* body) {
    ty_context* context = body->context;
    const size_t cells = body->cells, sides = (size_t)body->side_count, terms = (size_t)body->terms;
    const size_t rows = (size_t)body->size[1] * (size_t)body->size[2];
    for (int c = 0; c < 3; ++c) {
        ty_free_array(context, body->extinction[c], cells, sizeof(float));
        ty_free_array(context, body->scattering[c], cells, sizeof(float));
        float* const moments[4] = {body->of_lights[c], body->of_surfaces[c], body->field[c], body->solved[c]};
        for (int i = 0; i < 4; ++i) ty_free_array(context, moments[i], cells * terms, sizeof(float));
    }
    ty_free_array(context, body->inside, cells, 1);
    ty_free_array(context, body->near_cell, cells, 1);
    ty_free_array(context, body->first, rows + 1, sizeof *body->first);
    ty_free_array(context, body->x, sides, sizeof *body->x);
    ty_free_array(context, body->face, sides, 1);
    float* const of_sides[3] = {body->albedo, body->emission, body->ior};
    for (int i = 0; i < 3; ++i) ty_free_array(context, of_sides[i], sides, sizeof(float));
    for (int c = 0; c < 3; ++c) ty_free_array(context, body->exitance[c], sides, sizeof(float));
    ty_free_array(context, body->normal, 3 * sides, sizeof(float));
    ty_free_array(context, body->sides, sides, sizeof *body->sides);
}

static bool allocate_cells(ty_enclosed_body* body) {
    ty_context* context = body->context;
    const size_t cells = body->cells, terms = (size_t)body->terms;
    bool enough = true;
    for (int c = 0; c < 3; ++c) {
        body->extinction[c] = ty_alloc_array(context, cells, sizeof(float), true);
        body->scattering[c] = ty_alloc_array(context, cells, sizeof(float), true);
        body->of_lights[c] = ty_alloc_array(context, cells * terms, sizeof(float), true);
        body->of_surfaces[c] = ty_alloc_array(context, cells * terms, sizeof(float), true);
        body->field[c] = ty_alloc_array(context, cells * terms, sizeof(float), true);
        body->solved[c] = ty_alloc_array(context, cells * terms, sizeof(float), true);
        enough = enough && body->extinction[c] != NULL && body->scattering[c] != NULL && body->of_lights[c] != NULL &&
                 body->of_surfaces[c] != NULL && body->field[c] != NULL && body->solved[c] != NULL;
    }
    body->inside = ty_alloc_array(context, cells, 1, true);
    body->near_cell = ty_alloc_array(context, cells, 1, true);
    const size_t rows = (size_t)body->size[1] * (size_t)body->size[2];
    body->first = ty_alloc_array(context, rows + 1, sizeof *body->first, true);
    return enough && body->inside != NULL && body->near_cell != NULL && body->first != NULL;
}

static bool allocate_sides(ty_enclosed_body* body) {
    ty_context* context = body->context;
    const size_t sides = (size_t)body->side_count;
    body->x = ty_alloc_array(context, sides, sizeof *body->x, true);
    body->face = ty_alloc_array(context, sides, 1, true);
    body->albedo = ty_alloc_array(context, sides, sizeof(float), true);
    body->emission = ty_alloc_array(context, sides, sizeof(float), true);
    body->ior = ty_alloc_array(context, sides, sizeof(float), true);
    body->normal = ty_alloc_array(context, 3 * sides, sizeof(float), true);
    body->sides = ty_alloc_array(context, sides, sizeof *body->sides, true);
    for (int c = 0; c < 3; ++c) {
        body->exitance[c] = ty_alloc_array(context, sides, sizeof(float), true);
        if (body->exitance[c] == NULL) return false;
    }
    return body->x != NULL && body->face != NULL && body->albedo != NULL && body->emission != NULL &&
           body->ior != NULL && body->normal != NULL && body->sides != NULL;
}

/* ---- cells ---- */

static ty_vec center_of(const ty_enclosed_body* body, const int32_t at[3]) {
    float center[3];
    for (int a = 0; a < 3; ++a) center[a] = (float)(body->lower[a] + (at[a] + 0.5) * body->cell[a]);
    return ty_vec_load(center);
}

/* Cells along a longest side of a reduced optical thickness. Where MAX_CELLS would be thick, paths see little of cells
 * but the light that leaves, and MIN_CELLS suffice. */
static int32_t auto_cells(double thickness) {
    if (thickness > max_thickness * MAX_CELLS) return MIN_CELLS;
    return (int32_t)fmin(fmax(ceil(thickness), MIN_CELLS), MAX_CELLS);
}

/* Reduced extinction of a medium of density 1, 1/m: the minimum and maximum of the channels. */
static void find_reduced_extinction(const ty_medium_view* medium, ty_vec at, double range[2]) {
    float g[3], scattering[3];
    ty_medium_g(medium, at, g);
    ty_medium_sigma_s(medium, at, scattering);
    for (int c = 0; c < 3; ++c) {
        const double reduced = (double)(medium->sigma_t[c] - g[c] * scattering[c]);
        range[0] = c > 0 ? fmin(range[0], reduced) : reduced;
        range[1] = c > 0 ? fmax(range[1], reduced) : reduced;
    }
}

/* Nearly cubic cells over the extent of the medium. */
static void cut(ty_enclosed_body* body, const ty_medium_def* medium, const ty_medium_view* view) {
    double upper[3], reduced[2], longest = 0;
    ty_vec center;
    ty_medium_extent(medium, body->lower, upper);
    for (int a = 0; a < 3; ++a) longest = fmax(longest, upper[a] - body->lower[a]);
    center = ty_vec_make((float)(body->lower[0] + upper[0]) / 2, (float)(body->lower[1] + upper[1]) / 2,
                         (float)(body->lower[2] + upper[2]) / 2);
    find_reduced_extinction(view, center, reduced);
    const int32_t along = body->def->cells != TY_AUTO ? body->def->cells : auto_cells(longest * reduced[1]);
    body->diffusion = body->def->diffusion || longest / along * reduced[0] > max_thickness;
    body->cells = 1;
    for (int a = 0; a < 3; ++a) {
        const double side = upper[a] - body->lower[a];
        body->size[a] = (int32_t)fmax(1, lround(side / longest * along));
        body->cell[a] = side / body->size[a];
        body->cells *= (size_t)body->size[a];
    }
}

/* Marks the cells of a row whose centers the medium holds. */
static void find_inside(ty_enclosed_body* body, const ty_medium_view* medium, int32_t y, int32_t z) {
    const int32_t first[3] = {0, y, z};
    ty_vec origin = center_of(body, first);
    const float start = (float)(body->lower[0] - body->cell[0]), edge = (float)body->cell[0];
    ty_spans spans;
    origin.x = start;
    ty_spans_find(medium, 1, origin, ty_vec_make(1, 0, 0), TY_FLOAT_MAX, &spans);
    uint8_t* row = body->inside + ((size_t)z * (size_t)body->size[1] + (size_t)y) * (size_t)body->size[0];
    for (int32_t i = 0; i < spans.count; ++i)
        for (int32_t x = 0; x < body->size[0]; ++x) {
            const float t = ((float)x + 1.5f) * edge;
            if (t > spans.enter[i] && t < spans.leave[i]) row[x] = 1;
        }
}

/* Coefficients of a cell: the dielectric's own absorption and the medium that fills it. */
static void sample_cell(ty_enclosed_body* body, const ty_medium_view* medium, size_t cell, ty_vec center) {
    const ty_interior* interior = &body->scene->interiors[body->interior];
    ty_sampler random = ty_sampler_begin(NULL, body->def->seed, cell, 0);
    float density = 0, scattering[3];
    for (int i = 0; i < DENSITY_SAMPLES && medium->has_grid != 0; ++i) {
        ty_vec point = center;
        point.x += ((i & 1) != 0 ? 0.25f : -0.25f) * (float)body->cell[0];
        point.y += ((i & 2) != 0 ? 0.25f : -0.25f) * (float)body->cell[1];
        point.z += ((i & 4) != 0 ? 0.25f : -0.25f) * (float)body->cell[2];
        density += ty_medium_density(medium, point, &random) / DENSITY_SAMPLES;
    }
    if (medium->has_grid == 0) density = 1;
    ty_medium_sigma_s(medium, center, scattering);
    for (int c = 0; c < 3; ++c) {
        const float own = interior->absorbs != 0 ? interior->media[0].sigma_t[c] : 0;
        body->scattering[c][cell] = density * scattering[c];
        body->extinction[c][cell] = ty_maxf(density * medium->sigma_t[c], body->scattering[c][cell]) + own;
    }
}

/* Cells outside hold no light: they absorb. */
static void sample_cells(ty_enclosed_body* body, const ty_medium_view* medium) {
    const float opaque = (float)(1 / (body->cell[0] * body->size[0]));
    for (size_t i = 0; i < body->cells; ++i) {
        const int32_t at[3] = {(int32_t)(i % (size_t)body->size[0]),
                               (int32_t)(i / (size_t)body->size[0] % (size_t)body->size[1]),
                               (int32_t)(i / ((size_t)body->size[0] * (size_t)body->size[1]))};
        for (int c = 0; c < 3; ++c) body->extinction[c][i] = opaque;
        if (body->inside[i] != 0) sample_cell(body, medium, i, center_of(body, at));
    }
}

/* ---- phase function ---- */

/* Moments of the phase function, and the number of bands whose last leaves a small forward peak. */
static void choose_bands(ty_enclosed_body* body, const ty_medium_view* medium, ty_vec center) {
    float g[3], peak = 1;
    ty_medium_g(medium, center, g);
    for (int c = 0; c < 3; ++c)
        for (int32_t l = 0; l < TY_SH_BANDS_MAX; ++l)
            body->legendre[c][l] = medium->phase != NULL ? medium->phase->moments[c][l] : powf(g[c], (float)l);
    body->bands = body->diffusion ? 2 : 1;
    do {
        if (body->bands > 1) peak = 0;
        for (int c = 0; c < 3 && body->bands < TY_SH_BANDS_MAX; ++c)
            peak = ty_maxf(peak, fabsf(body->legendre[c][body->bands]));
    } while (!body->diffusion && peak > max_peak && ++body->bands < TY_SH_BANDS_MAX);
    if (body->bands < 2) body->bands = 2;
    body->terms = body->bands * body->bands;
    for (int c = 0; c < 3; ++c) {
        const int32_t order = body->diffusion ? 1 : body->bands;
        const float moment = order < TY_SH_BANDS_MAX ? body->legendre[c][order]
                             : medium->phase != NULL ? medium->phase->moments[c][order]
                                                     : powf(g[c], (float)order);
        body->forward[c] = ty_maxf(moment, 0);
    }
}

/* ---- faces ---- */

static bool is_inside(const ty_enclosed_body* body, const int32_t at[3]) {
    for (int a = 0; a < 3; ++a)
        if (at[a] < 0 || at[a] >= body->size[a]) return false;
    return body->inside[((size_t)at[2] * (size_t)body->size[1] + (size_t)at[1]) * (size_t)body->size[0] +
                        (size_t)at[0]] != 0;
}

bool ty_enclosed_meet_surface(const ty_enclosed_body* body, ty_vec origin, ty_vec w, float far, ty_hit* hit) {
    const ty_scene_view* scene = body->scene;
    float passed = 0;
    for (int i = 0; i < MAX_OVERLAPS && ty_accel_intersect(scene->mesh, origin, w, far - passed, hit); ++i) {
        const ty_surface_gloss* gloss = scene->surfaces[hit->surface].gloss;
        const bool own = hit->surface == scene->interiors[body->interior].surface;
        passed += hit->distance;
        hit->distance = passed;
        if (own || gloss == NULL || gloss->dielectric.solid == 0) return true;
        origin = ty_hit_leave(hit, w);
    }
    return false;
}

/* The interior's own surface along a ray from within. */
static bool meet_own_surface(const ty_enclosed_body* body, ty_vec origin, ty_vec w, float far, ty_hit* hit) {
    return ty_enclosed_meet_surface(body, origin, w, far, hit) &&
           hit->surface == body->scene->interiors[body->interior].surface && ty_dot(hit->normal, w) > 0;
}

/* The nearest surface around a cell's center along its axes and diagonals. */
static bool find_nearest(const ty_enclosed_body* body, ty_vec origin, float far, ty_hit* nearest) {
    bool found = false;
    for (int i = 0; i < 27; ++i) {
        const ty_vec w = ty_vec_make((float)(i % 3 - 1), (float)(i / 3 % 3 - 1), (float)(i / 9 - 1));
        ty_hit hit;
        if (i == 13 || !meet_own_surface(body, origin, ty_normalize(w), found ? nearest->distance : far, &hit))
            continue;
        *nearest = hit;
        found = true;
    }
    return found;
}

/* Point and normal of the surface behind a face, or, where that is far because the surface slants, of that nearest to
 * the cell; the face's own where rays miss it. */
static void find_surface(const ty_enclosed_body* body, const int32_t at[3], int32_t face, ty_enclosed_side* side) {
    const int axis = face / 2;
    float direction[3] = {0, 0, 0}, offset[3];
    direction[axis] = (face & 1) != 0 ? 1 : -1;
    const ty_vec origin = center_of(body, at), w = ty_vec_load(direction);
    const float edge = (float)body->cell[axis];
    ty_hit hit;
    side->normal = w;
    side->position = ty_mad(origin, w, 0.5f * edge);
    side->margin = 1e-4f * edge;
    if (meet_own_surface(body, origin, w, 1.1f * edge, &hit) || find_nearest(body, origin, 2 * edge, &hit)) {
        side->normal = hit.normal;
        side->position = hit.position;
        side->margin = ty_maxf(side->margin, hit.margin);
    }
    offset[0] = fabsf(side->normal.x);
    offset[1] = fabsf(side->normal.y);
    offset[2] = fabsf(side->normal.z);
    side->area = (float)(body->cell[(axis + 1) % 3] * body->cell[(axis + 2) % 3]) / (offset[0] + offset[1] + offset[2]);
}

/* A side inside is an interface, one outside a black face. */
static void set_side(ty_enclosed_body* body, int32_t i, const int32_t at[3], int32_t face) {
    ty_enclosed_side* side = &body->sides[i];
    const int axis = face / 2;
    body->x[i] = at[0];
    body->face[i] = (uint8_t)face;
    side->cell = -1;
    if (!is_inside(body, at)) return;
    const double ior = (double)body->scene->interiors[body->interior].ior;
    const double area = body->cell[(axis + 1) % 3] * body->cell[(axis + 2) % 3];
    side->cell = (at[2] * body->size[1] + at[1]) * body->size[0] + at[0];
    find_surface(body, at, face, side);
    body->ior[i] = (float)ior;
    body->albedo[i] = (float)ty_fresnel_effective_reflectance(ior, area / (double)side->area);
    body->normal[3 * i] = side->normal.x;
    body->normal[3 * i + 1] = side->normal.y;
    body->normal[3 * i + 2] = side->normal.z;
}

/* Counts the sides; fills them in, unless `body` has no memory for them yet. */
static int32_t find_sides(ty_enclosed_body* body) {
    int32_t count = 0, at[3];
    for (at[2] = 0; at[2] < body->size[2]; ++at[2])
        for (at[1] = 0; at[1] < body->size[1]; ++at[1]) {
            for (at[0] = 0; at[0] < body->size[0]; ++at[0])
                for (int32_t face = 0; face < 6; ++face) {
                    int32_t next[3] = {at[0], at[1], at[2]};
                    next[face / 2] += (face & 1) != 0 ? 1 : -1;
                    if (is_inside(body, next) == is_inside(body, at)) continue;
                    if (body->sides != NULL) set_side(body, count, at, face);
                    ++count;
                }
            body->first[at[2] * body->size[1] + at[1] + 1] = count;
        }
    return count;
}

ty_result ty_enclosed_body_create(const ty_scene* scene, const ty_enclosed_def* def, int32_t interior, int32_t medium,
                                  ty_enclosed_body* out) {
    *out = (ty_enclosed_body){.context = scene->context, .scene = &scene->view, .def = def, .interior = interior};
    const ty_medium_view* view = &scene->view.media[medium];
    cut(out, &scene->media[medium], view);
    const int32_t center[3] = {out->size[0] / 2, out->size[1] / 2, out->size[2] / 2};
    choose_bands(out, view, center_of(out, center));
    if (!allocate_cells(out)) return TY_ERROR_MEMORY;
    for (int32_t z = 0; z < out->size[2]; ++z)
        for (int32_t y = 0; y < out->size[1]; ++y) find_inside(out, view, y, z);
    sample_cells(out, view);
    out->side_count = find_sides(out);
    if (out->side_count == 0) return TY_OK;
    if (!allocate_sides(out)) return TY_ERROR_MEMORY;
    find_sides(out);
    return TY_OK;
}
