#include "method/screen/pyramid.h"

#include "method/screen/spread.h"

#include <math.h>

static int32_t halved(int32_t side) {
    return (side + 1) / 2;
}

static void allocate_areas(ty_screen_level* level, ty_arena* memory) {
    level->area[0] = ty_arena_take(memory, sizeof(float) * (size_t)level->width);
    level->area[1] = ty_arena_take(memory, sizeof(float) * (size_t)level->height);
}

void ty_screen_pyramid_lay_out(ty_screen_pyramid* p, const ty_screen_def* def, int32_t width, int32_t height,
                               ty_arena* memory) {
    p->level_limit = ty_screen_level_limit(def, width, height);
    p->taps = ty_screen_choose_taps(def->filter);
    p->levels[0] = (ty_screen_level){.width = width, .height = height};
    allocate_areas(&p->levels[0], memory);
    for (int32_t k = 1; k <= p->level_limit; ++k) {
        p->levels[k] =
            (ty_screen_level){.width = halved(p->levels[k - 1].width), .height = halved(p->levels[k - 1].height)};
        allocate_areas(&p->levels[k], memory);
    }
}

/* Small-angle spread: light is oversized if more than this fraction should pass beyond the last level, and there are
 * enough levels if less than the second fraction should. Tails are long, and coarse levels are nearly free. */
static const double oversized_fraction = 0.5, residual_fraction = 0.01;

/* The optical thickness at which light becomes oversized. */
static float thickness_limit(double width, double variance) {
    double low = 0, high = 1e6;
    for (int i = 0; i < 40; ++i) {
        const double center = i < 20 ? sqrt((low + 1e-6) * high) : 0.5 * (low + high);
        if (ty_screen_wider_fraction(width, center, variance) > oversized_fraction)
            high = center;
        else
            low = center;
    }
    return (float)low;
}

double ty_screen_pyramid_radius(const ty_screen_pyramid* p, const ty_screen_job* job, int32_t level) {
    double min_radius = HUGE_VAL;
    for (int c = 0; c < 3; ++c) {
        const float variance = p->variance[level];
        const float measure = job->small_angle ? thickness_limit(job->width[c], (double)variance) : variance;
        min_radius = fmin(min_radius, ty_screen_radius(job, c, (double)measure));
    }
    return min_radius;
}

static void set_edges(ty_screen_taps taps, ty_screen_level* level) {
    const int32_t count = halved(level->width), begin = ty_screen_edge_begin(count);
    float* weights = level->edges;
    for (int32_t i = 0; i < count; i = i + 1 == begin ? ty_screen_edge_end(count) : i + 1) {
        ty_screen_down_weights(taps, level->area[0], level->width, i, weights);
        weights += TY_SCREEN_DOWN_WEIGHTS;
    }
}

/* Texels of the last row or column of a level may lie only partly in the image. */
static void set_areas(ty_screen_pyramid* p) {
    for (int axis = 0; axis < 2; ++axis) {
        const int32_t pixels = axis == 0 ? p->levels[0].width : p->levels[0].height;
        for (int32_t i = 0; i < pixels; ++i) p->levels[0].area[axis][i] = 1;
        for (int32_t k = 1; k <= p->level_limit; ++k) {
            const int32_t fine = axis == 0 ? p->levels[k - 1].width : p->levels[k - 1].height;
            float weights[TY_SCREEN_DOWN_WEIGHTS];
            for (int32_t i = 0; i < halved(fine); ++i)
                p->levels[k].area[axis][i] =
                    ty_screen_down_weights(p->taps, p->levels[k - 1].area[axis], fine, i, weights);
        }
    }
    for (int32_t k = 0; k < p->level_limit; ++k) set_edges(p->taps, &p->levels[k]);
}

static void set_fractions(ty_screen_pyramid* p, const ty_screen_job* job) {
    const float step = ty_screen_taps_variance(p->taps);
    p->variance[0] = 0;
    for (int32_t k = 0; k <= p->level_limit; ++k) p->variance[k + 1] = p->variance[k] + step * exp2f(2.0f * (float)k);
    for (int c = 0; c < 3; ++c) {
        ty_screen_down_fraction fractions[TY_SCREEN_LEVELS_MAX + 1];
        const bool same_as_previous = c > 0 && job->width[c] == job->width[c - 1];
        if (same_as_previous) {
            p->limit[c] = p->limit[c - 1];
        } else if (job->small_angle) {
            ty_screen_small_angle_fractions(job->width[c], p->variance, p->level_limit, fractions);
            p->limit[c] = thickness_limit(job->width[c], (double)p->variance[p->level_limit]);
        } else {
            ty_screen_gaussian_fractions(p->variance, p->level_limit, fractions);
            p->limit[c] = p->variance[p->level_limit];
        }
        for (int32_t k = 0; k < p->level_limit; ++k)
            p->levels[k].down_fraction[c] = same_as_previous ? p->levels[k].down_fraction[c - 1] : fractions[k];
    }
}

int32_t ty_screen_pyramid_levels(const ty_screen_pyramid* p, const ty_screen_job* job, const ty_screen_counts* counts,
                                 int32_t count) {
    if (job->def->levels > 0 || job->stats.oversized > 0) return p->level_limit;
    int32_t levels = 1;
    for (int32_t band = 0; band < count; ++band)
        for (int c = 0; c < 3; ++c) {
            const double measure = (double)counts[band].largest[c];
            while (levels < p->level_limit &&
                   (job->small_angle ? ty_screen_wider_fraction(job->width[c], measure, (double)p->variance[levels]) >
                                           residual_fraction
                                     : (double)p->variance[levels] < measure))
                ++levels;
        }
    return levels;
}

void ty_screen_pyramid_set(ty_screen_pyramid* p, const ty_screen_job* job) {
    set_areas(p);
    set_fractions(p, job);
}

double ty_screen_pyramid_bytes(const ty_screen_pyramid* p, int32_t levels) {
    const double pixels = (double)p->levels[0].width * p->levels[0].height;
    double floats = pixels * (4 + 3) + pixels * (3 + 3);
    for (int32_t k = 1; k <= levels; ++k) {
        const double texels = (double)p->levels[k].width * p->levels[k].height;
        floats += texels * TY_SCREEN_PLANES; /* written while descending */
        if (k < levels)
            floats += texels * (TY_SCREEN_PLANES + TY_SCREEN_PLANES +
                                3); /* read while descending, read and written while ascending */
        floats += texels * 3;       /* read by the level above */
    }
    return floats * sizeof(float);
}
