/* What scatters of uncollided light, as moments on the cells of ordinates: means over fine cells, near lamps with the
 * light's direction in each of them. */
#include "base/context.h"
#include "direct/cover.h"
#include "method/dom/job.h"
#include "scene/scene.h"
#include "solve/angular/harmonics.h"

#include <math.h>
#include <string.h>

enum { CHUNK = 1 << 15, TERMS_MAX = TY_DOM_BANDS_MAX * TY_DOM_BANDS_MAX };

/* A lamp's light has one direction in all of a cell whose diagonal is at most this much of its distance; a fine cell
 * nearer to it than this many of its sides is looked at in NEAR_POINTS^3 points. */
static const double one_way = 0.25, near_sides = 2.5;
enum { NEAR_POINTS = 4 };

/* Relative difference up to which mean cosines are the same: they are means of many. */
static const float alike = 1e-5f;

/* ---- memory ---- */

/* Whether all that scatters on a plane of fine cells has the same g, and which. */
static bool find_g(const ty_grid_medium* fine, int32_t plane, float* g) {
    const float* scattering = fine->scattering[plane];
    size_t first = 0;
    while (first < fine->cells && !(scattering[first] > 0)) ++first;
    *g = first < fine->cells ? fine->g[plane][first] : 0;
    for (size_t i = first; i < fine->cells; ++i)
        if (scattering[i] > 0 && fabsf(fine->g[plane][i] - *g) > alike) return false;
    return true;
}

ty_result ty_dom_scratch_create(const ty_dom_job* job, ty_dom_scratch* scratch) {
    for (int32_t p = 0; p < job->fine->planes; ++p) scratch->uniform[p] = find_g(job->fine, p, &scratch->g[p]);
    scratch->turned = ty_alloc_array(job->context, job->fine->cells, sizeof(float), false);
    scratch->means = ty_alloc_array(job->context, job->coarse->cells, TY_DOM_MEANS * sizeof(float), false);
    return scratch->turned != NULL && scratch->means != NULL ? TY_OK : TY_ERROR_MEMORY;
}

void ty_dom_scratch_destroy(const ty_dom_job* job, ty_dom_scratch* scratch) {
    ty_free_array(job->context, scratch->turned, job->fine->cells, sizeof(float));
    ty_free_array(job->context, scratch->means, job->coarse->cells, TY_DOM_MEANS * sizeof(float));
}

/* ---- means over coarse cells ---- */

/* What one plane of a field is turned into. */
typedef struct add_job {
    ty_dom_job* job;
    ty_dom_scratch* scratch;
    const ty_single_light* single;
    const ty_source* source;   /* one of those whose light it is */
    float cosine;              /* of beams, about their direction */
    const float* fluence;      /* of fine cells */
    const float* scattering;   /* of the medium there */
    const float* g;            /* and its mean cosines */
    bool uniform;              /* whether all that scatters has the same */
    float power[TY_DOM_MEANS]; /* where uniform: g^l, or what a fit has in place of it, the last of what goes straight
                                  on; else 1 */
    int32_t channel_count, channels[3];
    float factor[3]; /* of the fluence, for each */
} add_job;

/* sigma_s times the fluence. */
static void scatter_chunk(void* user, int64_t index, int32_t worker) {
    (void)worker;
    const add_job* add = user;
    const size_t begin = (size_t)index * CHUNK, cells = add->job->fine->cells;
    const size_t end = cells - begin < CHUNK ? cells : begin + CHUNK;
    float* turned = add->scratch->turned;
    for (size_t i = begin; i < end; ++i) turned[i] = add->scattering[i] * add->fluence[i];
}

/* The same times g once more. */
static void turn_chunk(void* user, int64_t index, int32_t worker) {
    (void)worker;
    const add_job* add = user;
    const size_t begin = (size_t)index * CHUNK, cells = add->job->fine->cells;
    const size_t end = cells - begin < CHUNK ? cells : begin + CHUNK;
    float* turned = add->scratch->turned;
    for (size_t i = begin; i < end; ++i) turned[i] *= add->g[i];
}

/* means[l]: of sigma_s g^l times the fluence, l up to L; if g is the same everywhere, of l = 0 alone. */
static void find_means(const add_job* add) {
    const ty_dom_job* job = add->job;
    const int64_t chunks = (int64_t)((job->fine->cells + CHUNK - 1) / CHUNK);
    for (int32_t l = 0; l <= (add->uniform ? 0 : job->light->bands); ++l) {
        ty_parallel_for(job->context, chunks, l == 0 ? scatter_chunk : turn_chunk, (void*)add);
        ty_grid_average(job->context, add->scratch->turned, job->fine->box.size, job->coarse->box.size,
                        add->scratch->means + job->coarse->cells * (size_t)l);
    }
}

/* Coarse cells' means of sigma_s F, which times power[l] are those of sigma_s g^l F. */
static const float* means_of(const add_job* add, int32_t l) {
    return add->scratch->means + (add->uniform ? 0 : add->job->coarse->cells * (size_t)l);
}

/* ---- moments of lamps ---- */

static void find_middle(const ty_grid_medium* medium, const int32_t cell[3], double at[3]) {
    for (int a = 0; a < 3; ++a) at[a] = medium->box.lower[a] + (cell[a] + 0.5) * medium->cell[a];
}

static double unit_from(const double lamp[3], const double at[3], double way[3]) {
    double square = 0;
    for (int a = 0; a < 3; ++a) {
        way[a] = at[a] - lamp[a];
        square += way[a] * way[a];
    }
    const double length = sqrt(square);
    for (int a = 0; a < 3; ++a) way[a] = length > 0 ? way[a] / length : 0;
    return length;
}

/* How bright the lamp is that way: of most of a cell about a spot, or a lamp on a surface, it is dark. */
static double profile_of(const add_job* add, const double way[3]) {
    const ty_source* source = add->source;
    const ty_light_view* light =
        source->stand_in != NULL ? source->stand_in : &ty_scene_get_view(add->job->scene)->lights.lights[source->light];
    const ty_vec to = ty_vec_make((float)way[0], (float)way[1], (float)way[2]);
    return (double)ty_source_profile(light, ty_dot(source->direction, to));
}

/* The mean of harmonics over a fine cell about the lamp or next to it, weighted by its light without media. */
static void near_harmonics(const add_job* add, const double lamp[3], const double middle[3], double* y) {
    const double* cell = add->job->fine->cell;
    const int32_t bands = add->job->light->bands;
    double own[TERMS_MAX], weight = 0;
    memset(y, 0, sizeof *y * (size_t)(bands * bands));
    for (int p = 0; p < NEAR_POINTS * NEAR_POINTS * NEAR_POINTS; ++p) {
        const int index[3] = {p % NEAR_POINTS, p / NEAR_POINTS % NEAR_POINTS, p / (NEAR_POINTS * NEAR_POINTS)};
        double at[3], way[3];
        for (int a = 0; a < 3; ++a) at[a] = middle[a] + cell[a] * ((index[a] + 0.5) / NEAR_POINTS - 0.5);
        const double distance = unit_from(lamp, at, way);
        if (!(distance > 0)) continue;
        const double share = profile_of(add, way) / (distance * distance);
        ty_harmonics_at(way, bands, own);
        for (int32_t t = 0; t < bands * bands; ++t) y[t] += share * own[t];
        weight += share;
    }
    for (int32_t t = 0; t < bands * bands && weight > 0; ++t) y[t] /= weight;
}

/* One fine cell's part of a coarse one's moments. */
static void add_fine_cell(const add_job* add, const double lamp[3], const int32_t index[3], double share,
                          double* moments) {
    const ty_grid_medium* fine = add->job->fine;
    const int32_t bands = add->job->light->bands;
    const int32_t* size = fine->box.size;
    const size_t i = (size_t)index[0] + (size_t)size[0] * ((size_t)index[1] + (size_t)size[1] * (size_t)index[2]);
    const double sent = share * (double)add->scattering[i] * (double)add->fluence[i], g = (double)add->g[i];
    double middle[3], way[3], y[TERMS_MAX];
    if (!(sent > 0)) return;
    find_middle(fine, index, middle);
    const double distance = unit_from(lamp, middle, way);
    if (distance < near_sides * fmax(fine->cell[0], fmax(fine->cell[1], fine->cell[2])))
        near_harmonics(add, lamp, middle, y);
    else
        ty_harmonics_at(way, bands, y);
    const double straight = add->uniform ? (double)add->power[bands] : pow(g, bands);
    double power = 1;
    for (int32_t l = 0; l < bands; ++l, power *= g) {
        const double turned = (add->uniform ? (double)add->power[l] : power) - straight;
        for (int32_t t = l * l; t < (l + 1) * (l + 1); ++t) moments[t] += sent * turned * y[t];
    }
}

/* A coarse cell about a lamp, fine cell by fine cell. */
static void add_near(const add_job* add, const double lamp[3], const int32_t cell[3], double* moments) {
    const ty_grid_box* box = &add->job->coarse->box;
    const ty_cover_box cells = {box->lower, box->upper, box->size};
    ty_cover axes[3];
    memset(moments, 0, TERMS_MAX * sizeof *moments);
    ty_cover_cell(&add->job->fine->box, &cells, cell, axes);
    for (int32_t k = axes[2].first; k < axes[2].first + axes[2].count; ++k)
        for (int32_t j = axes[1].first; j < axes[1].first + axes[1].count; ++j)
            for (int32_t i = axes[0].first; i < axes[0].first + axes[0].count; ++i) {
                const int32_t index[3] = {i, j, k};
                const double share =
                    ty_cover_share(&axes[0], i) * ty_cover_share(&axes[1], j) * ty_cover_share(&axes[2], k);
                if (share > 0) add_fine_cell(add, lamp, index, share, moments);
            }
}

/* A cell that light crosses one way. */
static void add_far(const add_job* add, const double* y, size_t cell, double* moments) {
    const int32_t bands = add->job->light->bands;
    const double straight = (double)(add->power[bands] * means_of(add, bands)[cell]);
    for (int32_t l = 0; l < bands; ++l) {
        const double turned = (double)(add->power[l] * means_of(add, l)[cell]) - straight;
        for (int32_t t = l * l; t < (l + 1) * (l + 1); ++t) moments[t] = turned * y[t];
    }
}

static void keep_moments(const add_job* add, size_t cell, const double* moments) {
    const ty_dom* light = add->job->light;
    for (int32_t n = 0; n < add->channel_count; ++n) {
        float* source = add->job->source[add->channels[n]] + cell;
        for (int32_t t = 0; t < light->bands * light->bands; ++t)
            source[light->cells * (size_t)t] += (float)((double)add->factor[n] * moments[t]);
    }
}

static void add_lamp_row(void* user, int64_t row, int32_t worker) {
    (void)worker;
    const add_job* add = user;
    const ty_grid_medium* coarse = add->job->coarse;
    const int32_t* size = coarse->box.size;
    const double lamp[3] = {(double)add->single->toward.x, (double)add->single->toward.y,
                            (double)add->single->toward.z};
    const double* side = coarse->cell;
    const double diagonal = sqrt(side[0] * side[0] + side[1] * side[1] + side[2] * side[2]);
    double moments[TERMS_MAX];
    for (int32_t i = 0; i < size[0]; ++i) {
        const int32_t cell[3] = {i, (int32_t)(row % size[1]), (int32_t)(row / size[1])};
        const size_t at = (size_t)row * (size_t)size[0] + (size_t)i;
        double middle[3], way[3], y[TERMS_MAX];
        if (!(add->scratch->means[at] > 0)) continue;
        find_middle(coarse, cell, middle);
        if (diagonal > one_way * unit_from(lamp, middle, way)) {
            add_near(add, lamp, cell, moments);
        } else {
            ty_harmonics_at(way, add->job->light->bands, y);
            add_far(add, y, at, moments);
        }
        keep_moments(add, at, moments);
    }
}

/* ---- moments of beams ---- */

static void add_beam_row(void* user, int64_t row, int32_t worker) {
    (void)worker;
    const add_job* add = user;
    ty_dom* light = add->job->light;
    const int32_t width = light->box.size[0], bands = light->bands;
    const double way[3] = {(double)add->single->toward.x, (double)add->single->toward.y, (double)add->single->toward.z};
    const size_t at = (size_t)row * (size_t)width;
    const float* straight = means_of(add, bands) + at;
    float spread = 1;
    double y[TERMS_MAX];
    ty_harmonics_at(way, add->job->light->bands, y);
    for (int32_t n = 0; n < add->channel_count; ++n, spread = 1)
        for (int32_t l = 0; l < bands; ++l, spread *= add->cosine) {
            const float* sent = means_of(add, l) + at;
            for (int32_t t = l * l; t < (l + 1) * (l + 1); ++t) {
                const float factor = add->factor[n] * spread * (float)y[t];
                const float more = factor * add->power[l], less = factor * add->power[bands];
                float* out = add->job->source[add->channels[n]] + light->cells * (size_t)t + at;
                for (int32_t i = 0; i < width; ++i) out[i] += more * sent[i] - less * straight[i];
            }
        }
}

/* ---- all planes of a field ---- */

float ty_dom_channel_factor(const ty_dom* light, const ty_light_field* field, int32_t plane, int32_t channel) {
    if (field->planes == 3) return plane == channel ? 1 : 0;
    if (!light->shared) return field->color[channel];
    return (field->color[0] + field->color[1] + field->color[2]) /
           (light->color[0] + light->color[1] + light->color[2]);
}

/* The channels that a plane of a field brings light to, and how much. */
static void choose_channels(add_job* add, const ty_light_field* field, int32_t plane) {
    const ty_dom* light = add->job->light;
    add->channel_count = 0;
    for (int32_t c = 0; c < ty_dom_channels(light); ++c) {
        if (field->planes == 3 && c != plane) continue;
        add->factor[add->channel_count] = ty_dom_channel_factor(light, field, plane, c);
        add->channels[add->channel_count++] = c;
    }
}

static void find_powers(add_job* add, float g) {
    const ty_dom* light = add->job->light;
    add->power[0] = 1;
    for (int32_t l = 1; l < TY_DOM_MEANS; ++l) add->power[l] = add->uniform ? add->power[l - 1] * g : 1;
    if (light->fit.bands == 0) return;
    const float straight = light->fit.straight;
    for (int32_t l = 0; l < light->bands; ++l) add->power[l] = straight + light->fit.moments[l];
    add->power[light->bands] = straight;
}

void ty_dom_add_source(ty_dom_job* job, const ty_light_field* field, const ty_single_light* single,
                       const ty_source* source, float cosine, ty_dom_scratch* scratch) {
    const ty_grid_medium* fine = job->fine;
    const ty_dom* light = job->light;
    const int64_t rows = (int64_t)light->box.size[1] * light->box.size[2];
    add_job add = {.job = job, .scratch = scratch, .single = single, .source = source, .cosine = cosine};
    for (int32_t p = 0; p < field->planes; ++p) {
        const int32_t plane = fine->planes == 3 ? p : 0;
        add.fluence = field->fluence[p];
        add.scattering = fine->scattering[plane];
        add.g = fine->g[plane];
        add.uniform = scratch->uniform[plane] || light->fit.bands > 0;
        find_powers(&add, scratch->g[plane]);
        choose_channels(&add, field, p);
        find_means(&add);
        ty_parallel_for(job->context, rows, single->kind == TY_SINGLE_LAMP ? add_lamp_row : add_beam_row, &add);
    }
}
