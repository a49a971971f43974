/* Fills missing distances with a push-pull pyramid: known distances are averaged upwards, then each unknown texel
 * interpolates the coarser level. The edge of a hole follows its neighbours, its center the wider surroundings. */
#include "method/screen/job.h"

#include "base/context.h"

enum { FILL_LEVELS = 17 }; /* 65536 pixels halved down to one */

typedef struct fill_level {
    int32_t width, height;
    float* distance; /* 0: unknown */
} fill_level;

static bool is_known(float distance) {
    return distance > 0 && distance < TY_FLOAT_MAX;
}

/* Mean of the known distances among four texels. */
static float pull_texel(const fill_level* fine, int32_t x, int32_t y) {
    float sum = 0;
    int known = 0;
    for (int32_t j = 2 * y; j < 2 * y + 2 && j < fine->height; ++j)
        for (int32_t i = 2 * x; i < 2 * x + 2 && i < fine->width; ++i) {
            const float distance = fine->distance[(ptrdiff_t)j * fine->width + i];
            if (!is_known(distance)) continue;
            sum += ty_minf(distance, TY_SCREEN_DISTANCE_MAX);
            ++known;
        }
    return known > 0 ? sum / (float)known : 0;
}

static void pull(const fill_level* fine, const fill_level* coarse) {
    for (int32_t y = 0; y < coarse->height; ++y)
        for (int32_t x = 0; x < coarse->width; ++x)
            coarse->distance[(ptrdiff_t)y * coarse->width + x] = pull_texel(fine, x, y);
}

/* Bilinear interpolation of the four nearest texels of the coarser level, all of them known. */
static float push_texel(const fill_level* coarse, int32_t x, int32_t y) {
    const int32_t columns[2] = {x / 2, ty_screen_clamp_index(x / 2 + ((x & 1) != 0 ? 1 : -1), coarse->width)};
    const int32_t rows[2] = {y / 2, ty_screen_clamp_index(y / 2 + ((y & 1) != 0 ? 1 : -1), coarse->height)};
    static const float weights[2] = {0.75f, 0.25f};
    float sum = 0;
    for (int j = 0; j < 2; ++j)
        for (int i = 0; i < 2; ++i)
            sum += weights[j] * weights[i] * coarse->distance[(ptrdiff_t)rows[j] * coarse->width + columns[i]];
    return sum;
}

static int64_t push(const fill_level* coarse, const fill_level* fine) {
    int64_t filled = 0;
    for (int32_t y = 0; y < fine->height; ++y)
        for (int32_t x = 0; x < fine->width; ++x) {
            float* distance = &fine->distance[(ptrdiff_t)y * fine->width + x];
            if (is_known(*distance)) continue;
            *distance = push_texel(coarse, x, y);
            ++filled;
        }
    return filled;
}

ty_result ty_screen_fill_distance(ty_context* context, int32_t width, int32_t height, float* distance,
                                  int64_t* filled) {
    if (context == NULL) return TY_ERROR_ARGUMENT;
    if (width < 1 || height < 1 || width > TY_SCREEN_SIDE_MAX || height > TY_SCREEN_SIDE_MAX || distance == NULL ||
        filled == NULL)
        return ty_fail(context, TY_ERROR_ARGUMENT,
                       "filling distances: %d x %d is outside 1..%d, or distance or filled is NULL", width, height,
                       TY_SCREEN_SIDE_MAX);
    fill_level levels[FILL_LEVELS] = {{width, height, distance}};
    int32_t count = 1;
    size_t texels = 0;
    for (; levels[count - 1].width > 1 || levels[count - 1].height > 1; ++count) {
        levels[count].width = (levels[count - 1].width + 1) / 2;
        levels[count].height = (levels[count - 1].height + 1) / 2;
        texels += (size_t)levels[count].width * (size_t)levels[count].height;
    }
    float* memory = ty_alloc_array(context, texels, sizeof(float), false);
    if (memory == NULL) return TY_ERROR_MEMORY;
    float* next = memory;
    for (int32_t k = 1; k < count; ++k) {
        levels[k].distance = next;
        next += (ptrdiff_t)levels[k].width * levels[k].height;
        pull(&levels[k - 1], &levels[k]);
    }
    *filled = 0;
    if (is_known(levels[count - 1].distance[0]))
        for (int32_t k = count - 1; k > 0; --k) *filled = push(&levels[k], &levels[k - 1]);
    ty_free_array(context, memory, texels, sizeof(float));
    return TY_OK;
}
