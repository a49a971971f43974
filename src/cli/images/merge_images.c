/* Merging renderings of one scene. */
#include "cli/images/merge_images.h"
#include "cli/images/merge_seeds.h"
#include "cli/session/metadata.h"

#include <inttypes.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char samples_name[] = "samples.N";

/* A window of the frame: columns [x0, x1), rows [y0, y1). */
typedef struct window {
    int64_t x0, y0, x1, y1;
} window;

/* Metadata of an input image. */
typedef struct input {
    const char* path;
    const ty_image* image;
    window bounds;
    const float* samples; /* NULL: spp everywhere */
    double spp, seconds;
    bool complete;
    cli_seeds seeds;
} input;

typedef struct merge {
    ty_context* context;
    char* message;
    int count;
    input* inputs;
    window bounds;        /* window of the result */
    double* weight;       /* per pixel of the window */
    double* sum;          /* per pixel, of the current channel */
    double* sum_weight;   /* per pixel, the total weight of sum */
    bool uniform_weights; /* all weights are equal */
    ty_image* image;
} merge;

static ty_result refuse(merge* m, ty_result result, const char* format, ...) __attribute__((format(printf, 3, 4)));
static ty_result refuse(merge* m, ty_result result, const char* format, ...) {
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(m->message, CLI_MESSAGE_SIZE, format, arguments);
    va_end(arguments);
    return result;
}

static ty_result no_memory(merge* m) {
    return refuse(m, TY_ERROR_MEMORY, "not enough memory to merge");
}

static window window_of(const ty_image* image) {
    int32_t frame[4];
    ty_image_get_frame(image, frame);
    return (window){frame[0], frame[1], (int64_t)frame[0] + ty_image_width(image),
                    (int64_t)frame[1] + ty_image_height(image)};
}

static bool overlap(const window* a, const window* b) {
    return a->x0 < b->x1 && b->x0 < a->x1 && a->y0 < b->y1 && b->y0 < a->y1;
}

static size_t pixels_of(const window* w) {
    return (size_t)(w->x1 - w->x0) * (size_t)(w->y1 - w->y0);
}

/* ---- properties of the inputs ---- */

static bool read_number(const ty_image* image, const char* key, double* out) {
    return cli_metadata_number(image, key, out) && *out >= 0;
}

static ty_result describe(merge* m, const cli_piece* piece, input* out) {
    const ty_image* image = piece->image;
    double complete = 1;
    *out = (input){.path = piece->path, .image = image, .bounds = window_of(image)};
    static const char* const needed[] = {"tyndall.scene", "tyndall.method", "tyndall.seed"};
    for (size_t i = 0; i < sizeof needed / sizeof *needed; ++i)
        if (ty_image_get_metadata(image, needed[i]) == NULL)
            return refuse(m, TY_ERROR_INPUT, "%s: it has no %s, so it cannot be merged", piece->path, needed[i]);
    if (!cli_seeds_add(&out->seeds, ty_image_get_metadata(image, "tyndall.seed")))
        return refuse(m, TY_ERROR_INPUT, "%s: tyndall.seed is no list of seeds", piece->path);
    const int32_t samples = ty_image_find_channel(image, samples_name);
    if (samples >= 0) out->samples = ty_image_plane_const(image, samples);
    if (samples < 0 && !(read_number(image, "tyndall.spp", &out->spp) && out->spp > 0))
        return refuse(m, TY_ERROR_INPUT, "%s: neither %s nor tyndall.spp tells what it weighs", piece->path,
                      samples_name);
    if (!read_number(image, "tyndall.seconds", &out->seconds)) out->seconds = 0;
    out->complete = !read_number(image, "tyndall.complete", &complete) || complete != 0;
    return TY_OK;
}

/* The number of channels without samples.N. */
static int32_t count_channels(const ty_image* image) {
    return ty_image_channel_count(image) - (ty_image_find_channel(image, samples_name) >= 0);
}

static ty_result check_channels(merge* m, const input* a, const input* b) {
    for (int32_t i = 0; i < ty_image_channel_count(a->image); ++i) {
        const char* name = ty_image_channel_name(a->image, i);
        if (strcmp(name, samples_name) != 0 && ty_image_find_channel(b->image, name) < 0)
            return refuse(m, TY_ERROR_INPUT, "%s: the channel %s of %s is missing", b->path, name, a->path);
    }
    if (count_channels(a->image) != count_channels(b->image))
        return refuse(m, TY_ERROR_INPUT, "%s: there are channels that %s does not have", b->path, a->path);
    return TY_OK;
}

static ty_result check_pair(merge* m, const input* a, const input* b) {
    static const char* const keys[] = {"tyndall.scene", "tyndall.method"};
    for (size_t i = 0; i < sizeof keys / sizeof *keys; ++i) {
        const char *va = ty_image_get_metadata(a->image, keys[i]), *vb = ty_image_get_metadata(b->image, keys[i]);
        if (strcmp(va, vb) != 0)
            return refuse(m, TY_ERROR_INPUT, "%s: %s is %s, and that of %s is %s", b->path, keys[i], vb, a->path, va);
    }
    int32_t fa[4], fb[4];
    ty_image_get_frame(a->image, fa);
    ty_image_get_frame(b->image, fb);
    if (fa[2] != fb[2] || fa[3] != fb[3])
        return refuse(m, TY_ERROR_INPUT, "%s: the frame is %d x %d, and that of %s is %d x %d", b->path, fb[2], fb[3],
                      a->path, fa[2], fa[3]);
    return TY_OK;
}

/* Images of the same seed have the same samples, which must not be counted twice. */
static ty_result check_seeds(merge* m, const input* a, const input* b) {
    uint64_t seed;
    if (!overlap(&a->bounds, &b->bounds) || !cli_seeds_shared(&a->seeds, &b->seeds, &seed)) return TY_OK;
    return refuse(m, TY_ERROR_INPUT, "%s: it shares seed %" PRIu64 " with %s, and samples do not count twice", b->path,
                  seed, a->path);
}

static ty_result check_inputs(merge* m) {
    ty_result result = TY_OK;
    for (int i = 1; result == TY_OK && i < m->count; ++i) {
        result = check_pair(m, &m->inputs[0], &m->inputs[i]);
        if (result == TY_OK) result = check_channels(m, &m->inputs[0], &m->inputs[i]);
        for (int j = 0; result == TY_OK && j < i; ++j) result = check_seeds(m, &m->inputs[j], &m->inputs[i]);
    }
    return result;
}

/* ---- sums ---- */

static double weight_at(const input* p, size_t pixel) {
    return p->samples != NULL ? (double)p->samples[pixel] : p->spp;
}

/* The index in the result of the first pixel of a row of a window. */
static size_t row_start(const merge* m, const input* p, int64_t row) {
    const int64_t width = m->bounds.x1 - m->bounds.x0;
    return (size_t)((p->bounds.y0 + row - m->bounds.y0) * width + p->bounds.x0 - m->bounds.x0);
}

static void add_weights(merge* m, const input* p) {
    const int64_t width = p->bounds.x1 - p->bounds.x0, height = p->bounds.y1 - p->bounds.y0;
    for (int64_t y = 0; y < height; ++y)
        for (int64_t x = 0; x < width; ++x)
            m->weight[row_start(m, p, y) + (size_t)x] += weight_at(p, (size_t)(y * width + x));
}

typedef enum channel_kind { CHANNEL_MEAN, CHANNEL_VARIANCE, CHANNEL_DEPTH } channel_kind;

static channel_kind kind_of(const char* name) {
    if (strncmp(name, "variance.", 9) == 0) return CHANNEL_VARIANCE;
    return strcmp(name, "depth.Z") == 0 || strcmp(name, "half.depth.Z") == 0 ? CHANNEL_DEPTH : CHANNEL_MEAN;
}

static void add_values(merge* m, const input* p, const char* name) {
    const int64_t width = p->bounds.x1 - p->bounds.x0, height = p->bounds.y1 - p->bounds.y0;
    const float* plane = ty_image_plane_const(p->image, ty_image_find_channel(p->image, name));
    const channel_kind kind = kind_of(name);
    for (int64_t y = 0; y < height; ++y)
        for (int64_t x = 0; x < width; ++x) {
            const size_t from = (size_t)(y * width + x), to = row_start(m, p, y) + (size_t)x;
            const double value = (double)plane[from], weight = weight_at(p, from);
            if (weight == 0 || (kind == CHANNEL_DEPTH && value == 0)) continue;
            m->sum[to] += value * weight * (kind == CHANNEL_VARIANCE ? weight : 1);
            m->sum_weight[to] += weight;
        }
}

static void merge_channel(merge* m, int32_t channel) {
    const char* name = ty_image_channel_name(m->image, channel);
    float* plane = ty_image_plane(m->image, channel);
    const size_t pixels = pixels_of(&m->bounds);
    if (strcmp(name, samples_name) == 0) {
        for (size_t i = 0; i < pixels; ++i) plane[i] = (float)m->weight[i];
        return;
    }
    memset(m->sum, 0, pixels * sizeof *m->sum);
    memset(m->sum_weight, 0, pixels * sizeof *m->sum_weight);
    for (int i = 0; i < m->count; ++i) add_values(m, &m->inputs[i], name);
    for (size_t i = 0; i < pixels; ++i) {
        const double weight = m->sum_weight[i];
        if (weight > 0) plane[i] = (float)(m->sum[i] / weight / (kind_of(name) == CHANNEL_VARIANCE ? weight : 1));
    }
}

/* Normalizes mean normals; vectors already of unit length keep their bits. */
static void unit_normals(merge* m, const char* const names[3]) {
    float* n[3];
    for (int c = 0; c < 3; ++c) {
        n[c] = ty_image_plane(m->image, ty_image_find_channel(m->image, names[c]));
        if (n[c] == NULL) return;
    }
    for (size_t i = 0; i < pixels_of(&m->bounds); ++i) {
        const double x = (double)n[0][i], y = (double)n[1][i], z = (double)n[2][i];
        const double length = sqrt(x * x + y * y + z * z);
        if (!(length > 0) || fabs(length - 1) < 1e-6) continue;
        for (int c = 0; c < 3; ++c) n[c][i] = (float)((double)n[c][i] / length);
    }
}

/* ---- the result ---- */

static ty_result find_bounds(merge* m) {
    m->bounds = m->inputs[0].bounds;
    for (int i = 1; i < m->count; ++i) {
        const window* p = &m->inputs[i].bounds;
        if (p->x0 < m->bounds.x0) m->bounds.x0 = p->x0;
        if (p->y0 < m->bounds.y0) m->bounds.y0 = p->y0;
        if (p->x1 > m->bounds.x1) m->bounds.x1 = p->x1;
        if (p->y1 > m->bounds.y1) m->bounds.y1 = p->y1;
    }
    if (m->bounds.x1 - m->bounds.x0 > 65536 || m->bounds.y1 - m->bounds.y0 > 65536)
        return refuse(m, TY_ERROR_INPUT, "the images together are more than 65536 pixels wide or high");
    const size_t pixels = pixels_of(&m->bounds);
    m->weight = calloc(pixels, sizeof *m->weight);
    m->sum = calloc(pixels, sizeof *m->sum);
    m->sum_weight = calloc(pixels, sizeof *m->sum_weight);
    if (m->weight == NULL || m->sum == NULL || m->sum_weight == NULL) return no_memory(m);
    for (int i = 0; i < m->count; ++i) add_weights(m, &m->inputs[i]);
    m->uniform_weights = true;
    for (size_t i = 1; i < pixels && m->uniform_weights; ++i) m->uniform_weights = m->weight[i] == m->weight[0];
    return TY_OK;
}

static ty_result create_image(merge* m) {
    const ty_image* first = m->inputs[0].image;
    const char** names = calloc((size_t)ty_image_channel_count(first) + 1, sizeof *names);
    if (names == NULL) return no_memory(m);
    bool with_samples = !m->uniform_weights;
    for (int i = 0; i < m->count; ++i) with_samples = with_samples || m->inputs[i].samples != NULL;
    int32_t count = 0;
    for (int32_t i = 0; i < ty_image_channel_count(first); ++i) {
        const char* name = ty_image_channel_name(first, i);
        if (strcmp(name, samples_name) != 0) names[count++] = name;
    }
    if (with_samples) names[count++] = samples_name;
    const window* w = &m->bounds;
    ty_result result =
        ty_image_create(m->context, (int32_t)(w->x1 - w->x0), (int32_t)(w->y1 - w->y0), count, names, &m->image);
    free(names);
    int32_t frame[4];
    ty_image_get_frame(first, frame);
    if (result == TY_OK) result = ty_image_set_frame(m->image, (int32_t)w->x0, (int32_t)w->y0, frame[2], frame[3]);
    return result == TY_OK ? TY_OK : refuse(m, result, "%s", ty_take_error(m->context));
}

/* Root mean square standard error over the mean; negative when the image has no variance. */
static double relative_error(const ty_image* image) {
    static const char* const names[3] = {"variance.R", "variance.G", "variance.B"};
    const size_t pixels = (size_t)ty_image_width(image) * (size_t)ty_image_height(image);
    const float* colour[3];
    double variance = 0, mean = 0;
    if (!ty_image_rgb_planes(image, colour)) return -1;
    for (int c = 0; c < 3; ++c) {
        const float* plane = ty_image_plane_const(image, ty_image_find_channel(image, names[c]));
        if (plane == NULL) return -1;
        for (size_t i = 0; i < pixels; ++i) {
            variance += (double)plane[i];
            mean += (double)colour[c][i];
        }
    }
    return mean > 0 ? sqrt(variance * 3 * (double)pixels) / mean : 0;
}

static double mean_weight(const merge* m) {
    double sum = 0;
    const size_t pixels = pixels_of(&m->bounds);
    for (size_t i = 0; i < pixels; ++i) sum += m->weight[i];
    return m->uniform_weights ? m->weight[0] : sum / (double)pixels;
}

static ty_result set_seeds(merge* m) {
    cli_seeds all = {0};
    char* text = NULL;
    bool complete = true;
    for (int i = 0; i < m->count && complete; ++i)
        complete = cli_seeds_add(&all, ty_image_get_metadata(m->inputs[i].image, "tyndall.seed"));
    if (complete) text = cli_seeds_text(&all);
    const ty_result result = text != NULL ? ty_image_set_text(m->image, "tyndall.seed", text) : TY_ERROR_MEMORY;
    free(text);
    cli_seeds_free(&all);
    return result;
}

static ty_result set_metadata(merge* m) {
    static const char* const copied_keys[] = {"tyndall.method", "tyndall.scene"};
    double seconds = 0;
    bool complete = true;
    for (int i = 0; i < m->count; ++i) {
        seconds += m->inputs[i].seconds;
        complete = complete && m->inputs[i].complete;
    }
    ty_result result = ty_image_set_text(m->image, "tyndall.version", ty_version());
    for (size_t i = 0; result == TY_OK && i < sizeof copied_keys / sizeof *copied_keys; ++i)
        result = ty_image_set_text(m->image, copied_keys[i], ty_image_get_metadata(m->inputs[0].image, copied_keys[i]));
    double fov_y = 0;
    if (result == TY_OK && read_number(m->inputs[0].image, cli_fov_key, &fov_y))
        result = ty_image_set_number(m->image, cli_fov_key, fov_y);
    if (result == TY_OK) result = set_seeds(m);
    if (result == TY_OK) result = ty_image_set_number(m->image, "tyndall.spp", mean_weight(m));
    if (result == TY_OK) result = ty_image_set_number(m->image, "tyndall.seconds", seconds);
    if (result == TY_OK) result = ty_image_set_number(m->image, "tyndall.complete", complete ? 1 : 0);
    const double error = relative_error(m->image);
    if (result == TY_OK && error >= 0) result = ty_image_set_number(m->image, "tyndall.error", error);
    return result == TY_OK ? TY_OK : no_memory(m);
}

static ty_result merge_inputs(merge* m, const cli_piece* pieces) {
    ty_result result = TY_OK;
    for (int i = 0; result == TY_OK && i < m->count; ++i) result = describe(m, &pieces[i], &m->inputs[i]);
    if (result == TY_OK) result = check_inputs(m);
    if (result == TY_OK) result = find_bounds(m);
    if (result == TY_OK) result = create_image(m);
    if (result != TY_OK) return result;
    for (int32_t i = 0; i < ty_image_channel_count(m->image); ++i) merge_channel(m, i);
    unit_normals(m, (const char* const[]){"normal.X", "normal.Y", "normal.Z"});
    unit_normals(m, (const char* const[]){"half.normal.X", "half.normal.Y", "half.normal.Z"});
    return set_metadata(m);
}

ty_result cli_merge_images(ty_context* context, int count, const cli_piece* pieces, ty_image** out,
                           char message[CLI_MESSAGE_SIZE]) {
    merge m = {.context = context, .message = message, .count = count};
    m.inputs = calloc((size_t)count, sizeof *m.inputs);
    if (m.inputs == NULL) return no_memory(&m);
    const ty_result result = merge_inputs(&m, pieces);
    for (int i = 0; i < count; ++i) cli_seeds_free(&m.inputs[i].seeds);
    free(m.inputs);
    free(m.weight);
    free(m.sum);
    free(m.sum_weight);
    if (result == TY_OK)
        *out = m.image;
    else
        ty_image_destroy(m.image);
    return result;
}
