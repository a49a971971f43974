/* Slabs of an ordinate's grid. */
#include "method/pop/slab.h"

#include "method/pop/lobe.k.h"

size_t ty_pop_cells(const ty_pop_frame* frame) {
    return (size_t)frame->size[0] * (size_t)frame->size[1] * (size_t)frame->size[2];
}

float* ty_pop_seen_slab(const ty_pop_light* light, int32_t k) {
    const size_t slab = ty_pop_ringed_cells(&light->frame) / (size_t)light->frame.size[2];
    return light->seen + (size_t)light->floats * slab * (size_t)k;
}

size_t ty_pop_seen_floats(const ty_pop_frame* frame, int32_t floats) {
    return ty_pop_ringed_cells(frame) * (size_t)floats;
}

static float mean_g(const ty_grid_medium* medium, int32_t plane) {
    double turned = 0, scattering = 0;
    for (size_t i = 0; i < medium->cells; ++i) {
        scattering += (double)medium->scattering[plane][i];
        turned += (double)(medium->scattering[plane][i] * medium->g[plane][i]);
    }
    return scattering > 0 ? (float)(turned / scattering) : 0;
}

/* A medium of one density and of one g for each channel, which is what most are, takes one lookup. */
static bool find_multiples(const ty_pop_grid_kernels* kernels, const ty_grid_medium* medium, ty_pop_slab* slab) {
    const float* density = medium->extinction[0];
    const int32_t cells = (int32_t)medium->cells;
    size_t most = 0;
    for (size_t i = 0; i < medium->cells; ++i)
        if (density[i] > density[most]) most = i;
    if (!(density[most] > 0)) return false;
    for (int32_t p = 0; p < medium->planes; ++p) {
        const float* const planes[2] = {medium->extinction[p], medium->scattering[p]};
        for (int i = 0; i < 2; ++i) {
            slab->multiple[i][p] = planes[i][most] / density[most];
            if (kernels->misfit(planes[i], density, slab->multiple[i][p], 1e-6f * planes[i][most], cells) > 0)
                return false;
        }
        slab->usual_g[p] = medium->g[p][most];
        if (kernels->unevenness(medium->g[p], medium->scattering[p], slab->usual_g[p], 1e-6f, cells) > 0) return false;
    }
    return true;
}

void ty_pop_slab_setup(const ty_pop_grid_kernels* kernels, const ty_grid_medium* medium, const ty_pop_columns* columns,
                       ty_pop_slab* slab) {
    slab->columns = columns;
    slab->medium = medium;
    for (int a = 0; a < 3; ++a) slab->per_metre[a] = (float)(1 / medium->cell[a]);
    slab->multiples = find_multiples(kernels, medium, slab);
    for (int32_t p = 0; p < medium->planes && slab->multiples == 0; ++p) slab->usual_g[p] = mean_g(medium, p);
}

void ty_pop_slab_enter(const ty_pop_grid_kernels* kernels, int32_t k, ty_pop_slab* slab) {
    const ty_pop_frame* frame = slab->columns->frame;
    slab->ends[0] = ty_pop_slab_begin(frame, k);
    slab->ends[1] = ty_pop_slab_begin(frame, k + 1);
    slab->middle = frame->kind == TY_DISCRETE_DIRECTIONAL ? 0.5f * (slab->ends[0] + slab->ends[1])
                                                          : ty_pop_radius(frame, (float)k + 0.5f);
    kernels->sample(slab);
}

void ty_pop_transmittance_begin(const ty_pop_grid_kernels* kernels, int32_t orders, ty_pop_slab* slab,
                                ty_pop_transmittance* t) {
    float unused[TY_POP_BLOCK];
    t->orders = orders;
    for (int32_t p = 0; p < slab->medium->planes; ++p)
        for (int32_t order = 0; order < orders; ++order) {
            t->mean[p][order] = unused;
            for (int32_t i = 0; i < slab->columns->count; ++i) t->along[p][order][i] = 1;
        }
    if (slab->columns->frame->kind == TY_DISCRETE_DIRECTIONAL) return;
    ty_pop_slab_enter(kernels, -1, slab);
    kernels->light(slab);
    kernels->pass(slab, t);
}

void ty_pop_look_setup(const ty_grid_medium* medium, const float eye[3], const ty_pop_light* light, ty_pop_look* look) {
    for (int a = 0; a < 3; ++a) look->eye[a] = (float)((double)eye[a] - medium->box.lower[a]);
    look->cosine = light->ordinate.mean_cosine;
    look->width = ty_pop_disc_width(look->cosine);
}

/* Merged cells take light most from where it scatters, not from vacuum beside it; cells of little depth count alike. */
static const float least_weight = 0.05f;

static void weigh(const ty_pop_slab* slab, float weight[TY_POP_BLOCK]) {
    const int32_t count = slab->columns->count, planes = slab->medium->planes;
    const float per_plane = 1 / (float)planes;
    for (int32_t i = 0; i < count; ++i) weight[i] = 0;
    for (int32_t p = 0; p < planes; ++p)
        for (int32_t i = 0; i < count; ++i) weight[i] += slab->extinction[p][i] * slab->length[i];
    for (int32_t i = 0; i < count; ++i) weight[i] = least_weight + weight[i] * per_plane;
}

void ty_pop_write_seen(const ty_pop_light* light, const ty_pop_slab* slab, const ty_pop_look* look, int32_t k) {
    float weight[TY_POP_BLOCK], *cells = ty_pop_seen_slab(light, k);
    const float *radiance[3], *fluence[3], *color = light->ordinate.color;
    weigh(slab, weight);
    for (int32_t c = 0; c < 3; ++c) {
        const int32_t p = light->planes == 3 ? c : 0;
        radiance[c] = look->radiance[p];
        fluence[c] = look->mean[p][1];
    }
    for (int32_t i = 0; i < slab->columns->count; ++i) {
        float* seen = cells + (size_t)light->floats * (size_t)slab->columns->cell[i];
        const float tinted[3] = {weight[i] * color[0], weight[i] * color[1], weight[i] * color[2]};
        for (int32_t c = 0; c < 3; ++c) {
            seen[c] = tinted[c] * radiance[c][i];
            seen[3 + c] = tinted[c] * fluence[c][i];
        }
        seen[TY_POP_WEIGHT] = weight[i];
        seen[TY_POP_WEIGHT + 1] = 0;
    }
}
