/* Irradiance on boundary faces from the first two moments of their cells. */
#include "method/dom/view/view.h"
#include "solve/angular/harmonics.h"

/* Staircase factor up to which the irradiance of the face is that of the surface. */
static const float min_slant = 1.03f;

/* Irradiance on a slanted surface from a cell's moments: harmonics along its normal times those of the clamped cosine.
 */
static float irradiance_of(const ty_dom* light, int32_t channel, size_t cell, ty_vec normal) {
    static const double cosine[] = {TY_PI, TY_PI * 2 / 3, TY_PI / 4, 0, -TY_PI / 24, 0};
    const double omega[3] = {-(double)normal.x, -(double)normal.y, -(double)normal.z};
    double y[TY_DOM_BANDS_MAX * TY_DOM_BANDS_MAX], sum = 0;
    const int32_t bands = light->output_bands < 6 ? light->output_bands : 6;
    ty_harmonics_at(omega, bands, y);
    for (int32_t l = 0; l < bands; ++l)
        for (int32_t t = l * l; t < (l + 1) * (l + 1); ++t)
            sum += cosine[l] * y[t] * (double)ty_dom_plane(light, light->moments[channel], t)[cell];
    return ty_maxf(0, (float)sum);
}

static void match_side(const ty_dom* light, int32_t channel, int32_t side, size_t cell,
                       float* const terms[TY_FIELD_TERMS]) {
    const ty_boundary_side* boundary_side = &light->boundary->sides[side];
    float target = light->wall_irradiance[channel][side];
    if (boundary_side->staircase_factor > min_slant)
        target = irradiance_of(light, channel, cell, boundary_side->normal);
    target += light->wall_forward[channel][side];
    ty_side_match_irradiance(boundary_side, target, cell, terms);
}

void ty_dom_match_wall_irradiance(const ty_dom* light, int32_t channel, float* const terms[TY_FIELD_TERMS]) {
    const ty_boundary_faces* faces = light->boundary;
    if (faces == NULL || light->wall_irradiance[channel] == NULL) return;
    const int64_t rows = (int64_t)faces->size[1] * faces->size[2];
    for (int64_t row = 0; row < rows; ++row)
        for (int32_t side = faces->first[row]; side < faces->first[row + 1]; ++side)
            match_side(light, channel, side, (size_t)row * (size_t)faces->size[0] + (size_t)faces->x[side], terms);
}
