/* Overlaps of triangles in a map, by the points of a raster. */
#include "bake/unwrap/unwrap.h"

#include <math.h>

bool ty_unwrap_cover(float p[3][2], int32_t width, int32_t height, uint8_t* owned) {
    float low[2], high[2];
    for (int b = 0; b < 2; ++b) {
        low[b] = fminf(fminf(p[0][b], p[1][b]), p[2][b]);
        high[b] = fmaxf(fmaxf(p[0][b], p[1][b]), p[2][b]);
    }
    const float area = (p[1][0] - p[0][0]) * (p[2][1] - p[0][1]) - (p[1][1] - p[0][1]) * (p[2][0] - p[0][0]);
    if (!(fabsf(area) > 1e-12f)) return false;
    bool met = false;
    for (int pass = 0; pass < 2 && !met; ++pass)
        for (int32_t y = (int32_t)fmaxf(low[1], 0); y <= (int32_t)high[1] && y < height; ++y)
            for (int32_t x = (int32_t)fmaxf(low[0], 0); x <= (int32_t)high[0] && x < width; ++x) {
                const float at[2] = {(float)x + 0.5f, (float)y + 0.5f};
                float smallest = INFINITY;
                for (int k = 0; k < 3; ++k) {
                    const float *a = p[k], *b = p[(k + 1) % 3];
                    const float side = (b[0] - a[0]) * (at[1] - a[1]) - (b[1] - a[1]) * (at[0] - a[0]);
                    smallest = fminf(smallest, side / area);
                }
                if (!(smallest > 1e-4f)) continue; /* points on edges belong to nobody */
                if (pass == 0)
                    met = met || owned[(size_t)y * (size_t)width + (size_t)x];
                else
                    owned[(size_t)y * (size_t)width + (size_t)x] = 1;
            }
    return met;
}
