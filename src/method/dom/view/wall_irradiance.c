/* Irradiance on boundary faces from the first two moments of their cells. */
#include "method/dom/view/view.h"

static void match_side(const ty_dom* light, int32_t channel, int32_t side, size_t cell,
                       float* const terms[TY_FIELD_TERMS]) {
    const ty_boundary_side* boundary_side = &light->boundary->sides[side];
    const float irradiance = ty_dom_side_irradiance(light, boundary_side, light->wall_irradiance[channel][side],
                                                    light->moments[channel], light->output_bands, cell);
    ty_side_match_irradiance(boundary_side, irradiance + light->wall_forward[channel][side], cell, terms);
}

void ty_dom_match_wall_irradiance(const ty_dom* light, int32_t channel, float* const terms[TY_FIELD_TERMS]) {
    const ty_boundary_faces* faces = light->boundary;
    if (faces == NULL || light->wall_irradiance[channel] == NULL) return;
    const int64_t rows = (int64_t)faces->size[1] * faces->size[2];
    for (int64_t row = 0; row < rows; ++row)
        for (int32_t side = faces->first[row]; side < faces->first[row + 1]; ++side)
            match_side(light, channel, side, (size_t)row * (size_t)faces->size[0] + (size_t)faces->x[side], terms);
}
