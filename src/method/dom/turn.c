/* Light on surfaces that are walls between cells. */
#include "method/dom/view.h"
#include "solve/angular/harmonics.h"

/* Faces of cells get what the surfaces do where these are no more slanted than this. */
static const float least_slant = 1.03f;

/* What arrives on a slanted surface, of a cell's moments: harmonics about its normal times those of the cosine. */
static float irradiance_of(const ty_dom* light, int32_t channel, size_t cell, ty_vec normal) {
    static const double cosine[] = {TY_PI, TY_PI * 2 / 3, TY_PI / 4, 0, -TY_PI / 24, 0};
    const double way[3] = {-(double)normal.x, -(double)normal.y, -(double)normal.z};
    double y[TY_DOM_BANDS_MAX * TY_DOM_BANDS_MAX], sum = 0;
    const int32_t bands = light->kept < 6 ? light->kept : 6;
    ty_harmonics_at(way, bands, y);
    for (int32_t l = 0; l < bands; ++l)
        for (int32_t t = l * l; t < (l + 1) * (l + 1); ++t)
            sum += cosine[l] * y[t] * (double)ty_dom_plane(light, light->moments[channel], t)[cell];
    return ty_maxf(0, (float)sum);
}

static void turn(const ty_dom* light, int32_t channel, int32_t side, size_t cell, float* const terms[TY_FIELD_TERMS]) {
    const ty_wall* wall = &light->walls->sides[side];
    const float normal[3] = {wall->normal.x, wall->normal.y, wall->normal.z};
    float along = 0, wanted = light->arrived[channel][side];
    if (wall->stairs > least_slant) wanted = irradiance_of(light, channel, cell, wall->normal);
    wanted += light->forward[channel][side];
    for (int a = 0; a < 3; ++a) along += terms[1 + a][cell] * normal[a];
    /* pi (even - 2/3 along) is what first moments bring. */
    const float more = 1.5f * (terms[0][cell] - wanted / TY_PI) - along;
    for (int a = 0; a < 3; ++a) terms[1 + a][cell] += more * normal[a];
}

void ty_dom_turn_to_walls(const ty_dom* light, int32_t channel, float* const terms[TY_FIELD_TERMS]) {
    const ty_walls* walls = light->walls;
    if (walls == NULL || light->arrived[channel] == NULL) return;
    const int64_t rows = (int64_t)walls->size[1] * walls->size[2];
    for (int64_t row = 0; row < rows; ++row)
        for (int32_t side = walls->first[row]; side < walls->first[row + 1]; ++side)
            turn(light, channel, side, (size_t)row * (size_t)walls->size[0] + (size_t)walls->x[side], terms);
}
