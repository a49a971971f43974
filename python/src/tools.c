/* Work on images: fog over a picture, denoising; and facts: methods, the schema, presets, phase functions. */
#include "module.h"

#include <stdlib.h>
#include <string.h>

/* ---- screen-space scattering ---- */

typedef struct screen_work {
    ty_context* context;
    ty_screen_def def;
    ty_screen_image planes;
    ty_screen_stats stats;
    const char* medium; /* to parse */
    float environment[3];
    bool balance, fill;
    float* filled;
    int64_t filled_count;
} screen_work;

/* Distances without holes in place of the caller's. */
static ty_result fill_distances(screen_work* w) {
    const ty_screen_image* planes = &w->planes;
    w->filled = malloc((size_t)planes->width * (size_t)planes->height * sizeof *w->filled);
    if (w->filled == NULL) return TY_ERROR_MEMORY;
    for (int32_t y = 0; y < planes->height; ++y)
        for (int32_t x = 0; x < planes->width; ++x)
            w->filled[(size_t)y * (size_t)planes->width + (size_t)x] =
                planes->distance[y * planes->distance_row + x * planes->distance_step];
    w->planes.distance = w->filled;
    w->planes.distance_row = planes->width;
    w->planes.distance_step = 1;
    return ty_screen_fill_distance(w->context, planes->width, planes->height, w->filled, &w->filled_count);
}

static ty_result apply_screen(void* user) {
    screen_work* w = user;
    ty_medium_def medium = ty_default_medium_def();
    ty_result result = ty_medium_parse(w->context, w->medium, &medium);
    if (result == TY_OK && w->fill) result = fill_distances(w);
    if (result != TY_OK) return result;
    memcpy(w->def.sigma_s, medium.sigma_s, sizeof w->def.sigma_s);
    memcpy(w->def.sigma_a, medium.sigma_a, sizeof w->def.sigma_a);
    memcpy(w->def.g, medium.g, sizeof w->def.g);
    if (w->balance)
        ty_screen_balance(&w->def, w->environment);
    else
        memcpy(w->def.environment, w->environment, sizeof w->environment);
    w->stats = ty_default_screen_stats();
    return ty_screen_apply(w->context, &w->def, &w->planes, NULL, 0, &w->stats);
}

/* Strides of floats, in floats; false if an array is none of float32 with `axes` axes. */
static bool plane_strides(const input* in, int axes, ptrdiff_t* step, ptrdiff_t* row) {
    if (in->kind != 'f' || in->itemsize != 4 || in->ndim != axes) return false;
    for (int i = 0; i < axes; ++i)
        if (in->strides[i] % (Py_ssize_t)sizeof(float) != 0) return false;
    *row = in->strides[0] / (ptrdiff_t)sizeof(float);
    *step = in->strides[1] / (ptrdiff_t)sizeof(float);
    return true;
}

/* Sets the planes of a picture and its distances, which stay where they are. */
static bool set_planes(screen_work* w, const input* color, const input* distance, ty_image* out) {
    if (!plane_strides(color, 3, &w->planes.color.step, &w->planes.color.row) || color->shape[2] < 3) return false;
    if (!plane_strides(distance, 2, &w->planes.distance_step, &w->planes.distance_row)) return false;
    if (color->shape[0] != distance->shape[0] || color->shape[1] != distance->shape[1]) return false;
    if (color->shape[0] > 65536 || color->shape[1] > 65536) return false;
    w->planes.width = (int32_t)color->shape[1];
    w->planes.height = (int32_t)color->shape[0];
    const ptrdiff_t channel = color->strides[2] / (ptrdiff_t)sizeof(float);
    for (int c = 0; c < 3; ++c) {
        w->planes.color.data[c] = (float*)color->data + c * channel;
        w->planes.out.data[c] = ty_image_plane(out, c);
    }
    w->planes.out.row = w->planes.width;
    w->planes.distance = (const float*)distance->data;
    return true;
}

static PyObject* screen_result(context_object* context, screen_work* w, PyObject* progress, ty_image* out) {
    call running = {.context = context, .work = apply_screen, .user = w, .progress = callable_or_null(progress)};
    w->def.progress = call_progress;
    w->def.progress_user = &running;
    call_run(&running);
    free(w->filled);
    if (call_raise(&running, NULL) != 0) {
        ty_image_destroy(out);
        return NULL;
    }
    PyObject* image = wrap_image(context, out);
    if (image == NULL) return NULL;
    return Py_BuildValue("(N{s:d,s:i,s:d,s:L,s:L,s:L,s:L})", image, "seconds", w->stats.seconds, "levels",
                         (int)w->stats.levels, "spread", w->stats.spread, "oversized", (long long)w->stats.oversized,
                         "nonfinite_fixed", (long long)w->stats.nonfinite_fixed, "missing_depth",
                         (long long)w->stats.missing_depth, "filled", (long long)w->filled_count);
}

static PyObject* run_screen(context_object* context, screen_work* w, const input* color, const input* distance,
                            PyObject* progress) {
    ty_image* out = NULL;
    const int32_t width = color->ndim == 3 ? (int32_t)color->shape[1] : 0;
    const int32_t height = color->ndim == 3 ? (int32_t)color->shape[0] : 0;
    const ty_result result = ty_image_create_rgb(context->context, width, height, &out);
    if (result != TY_OK) return raise_result(result, ty_take_error(context->context));
    if (set_planes(w, color, distance, out)) return screen_result(context, w, progress, out);
    ty_image_destroy(out);
    return raise_argument("expected an image (height, width, 3 or more) and distances (height, width), both float32");
}

enum { VARIANT_NAIVE = 3, VARIANT_PUBLISHED = 4 }; /* after those of ty_screen_variant */

/* Options of TY_SCREEN_GATHER and TY_SCREEN_REFERENCE that a dict has: 0, or -1 after an exception. */
static int read_gathering(PyObject* given, ty_screen_def* def) {
    const struct {
        const char* key;
        float* number;
        bool* choice;
    } keys[] = {{"mask_width", &def->mask_width, NULL},
                {"level_scale", &def->level_scale, NULL},
                {"luminance_weights", NULL, &def->luminance_weights},
                {"blurred_distance", NULL, &def->blurred_distance},
                {"normalise", NULL, &def->normalise}};
    for (size_t i = 0; i < sizeof keys / sizeof *keys; ++i) {
        PyObject* value = PyDict_GetItemString(given, keys[i].key);
        if (value == NULL) continue;
        if (keys[i].number != NULL)
            *keys[i].number = (float)PyFloat_AsDouble(value);
        else
            *keys[i].choice = PyObject_IsTrue(value) != 0;
    }
    PyObject *mask = PyDict_GetItemString(given, "mask"), *window = PyDict_GetItemString(given, "window");
    if (mask != NULL) def->mask = (ty_screen_mask)PyLong_AsLong(mask);
    if (window != NULL) def->window = (int32_t)PyLong_AsLong(window);
    return PyErr_Occurred() != NULL ? -1 : 0;
}

/* (context, image, distance, medium, (focal x, focal y), (centre x, centre y), axis, environment, balance, variant,
 * spread, filter, levels, missing depth, fill, options of gathering, progress) */
static PyObject* screen(PyObject* module, PyObject* arguments) {
    context_object* context;
    PyObject *image, *depth, *focal, *center, *environment, *gathering, *progress, *answer = NULL;
    screen_work w = {.def = ty_default_screen_def(), .planes = ty_default_screen_image()};
    double radiance[3];
    int axis, balance, variant, spread, filter, levels, fill;
    input color, distance;
    (void)module;
    if (!PyArg_ParseTuple(arguments, "O!OOsOOpOpiiiifpO!O", context_type, &context, &image, &depth, &w.medium, &focal,
                          &center, &axis, &environment, &balance, &variant, &spread, &filter, &levels,
                          &w.def.missing_depth, &fill, &PyDict_Type, &gathering, &progress))
        return NULL;
    w.context = context->context;
    if (doubles_of(focal, "focal", 2, w.def.focal) != 0 || doubles_of(center, "center", 2, w.def.center) != 0 ||
        doubles_of(environment, "environment", 3, radiance) != 0)
        return NULL;
    w.def.distance_kind = axis ? TY_SCREEN_DISTANCE_AXIS : TY_SCREEN_DISTANCE_RAY;
    if (variant == VARIANT_NAIVE)
        ty_screen_naive_def(&w.def);
    else if (variant == VARIANT_PUBLISHED)
        ty_screen_published_def(&w.def);
    else
        w.def.variant = (ty_screen_variant)variant;
    w.def.spread = (ty_screen_spread)spread;
    w.def.filter = filter;
    if (read_gathering(gathering, &w.def) != 0) return NULL;
    w.def.levels = levels;
    w.balance = balance != 0;
    w.fill = fill != 0;
    for (int c = 0; c < 3; ++c) w.environment[c] = (float)radiance[c];
    if (input_open(image, "image", &color) != 0) return NULL;
    if (input_open(depth, "distance", &distance) == 0) {
        answer = run_screen(context, &w, &color, &distance, progress);
        input_close(&distance);
    }
    input_close(&color);
    return answer;
}

/* ---- denoising ---- */

typedef struct denoise_work {
    ty_context* context;
    const ty_image* image;
    ty_denoise_def def;
    ty_denoise_stats stats;
    ty_image* out;
} denoise_work;

static ty_result remove_noise(void* user) {
    denoise_work* w = user;
    return ty_denoise_image(w->context, w->image, &w->def, &w->out, &w->stats);
}

/* (image, features, previous, denoiser, parts, progress) -> (image, measurements) */
static PyObject* denoise(PyObject* module, PyObject* arguments) {
    PyObject *object, *features, *previous, *progress;
    int denoiser, parts;
    (void)module;
    if (!PyArg_ParseTuple(arguments, "O!O!OipO", image_type, &object, &PyTuple_Type, &features, &previous, &denoiser,
                          &parts, &progress))
        return NULL;
    context_object* context = ((image_object*)object)->context;
    denoise_work w = {.context = context->context,
                      .image = ((image_object*)object)->image,
                      .def = ty_default_denoise_def(),
                      .stats = ty_default_denoise_stats()};
    call running = {.context = context, .work = remove_noise, .user = &w, .progress = callable_or_null(progress)};
    const Py_ssize_t count = PyTuple_Size(features);
    if (count > TY_DENOISE_FEATURES_MAX) return raise_argument("features: there are %zd, more than 4", count);
    for (Py_ssize_t i = 0; i < count; ++i) {
        PyObject* feature = PyTuple_GetItem(features, i);
        if (!PyObject_TypeCheck(feature, image_type)) return raise_argument("features: expected images");
        w.def.features[i] = ((image_object*)feature)->image;
    }
    if (PyObject_TypeCheck(previous, image_type)) w.def.previous = ((image_object*)previous)->image;
    w.def.denoiser = (ty_denoiser)denoiser;
    w.def.parts = parts != 0;
    w.def.progress = call_progress;
    w.def.progress_user = &running;
    call_run(&running);
    if (call_raise(&running, NULL) != 0) {
        ty_image_destroy(w.out);
        return NULL;
    }
    PyObject* image = wrap_image(context, w.out);
    if (image == NULL) return NULL;
    return Py_BuildValue("(N{s:d,s:d,s:d})", image, "seconds", w.stats.seconds, "error", w.stats.error, "raw_error",
                         w.stats.raw_error);
}

PyMethodDef tool_functions[] = {{"screen", screen, METH_VARARGS, "Scattering over one image; see tyndall.screen."},
                                {"denoise", denoise, METH_VARARGS, "Noise removal; see tyndall.denoise."},
                                {NULL, NULL, 0, NULL}};

/* ---- facts ---- */

static PyObject* schema(PyObject* module, PyObject* none) {
    (void)module, (void)none;
    return PyUnicode_FromString(ty_scene_schema());
}

static PyObject* method_names(PyObject* module, PyObject* none) {
    (void)module, (void)none;
    int32_t count = 0;
    while (ty_method_name(count) != NULL) ++count;
    PyObject* tuple = PyTuple_New(count);
    for (int32_t i = 0; tuple != NULL && i < count; ++i) {
        PyObject* name = PyUnicode_FromString(ty_method_name(i));
        if (name == NULL || PyTuple_SetItem(tuple, i, name) != 0) {
            Py_DECREF(tuple);
            return NULL;
        }
    }
    return tuple;
}

static PyObject* presets(PyObject* module, PyObject* none) {
    static const char* const kinds[] = {"measured", "water", "visibility"};
    (void)module, (void)none;
    PyObject* dict = PyDict_New();
    for (int32_t i = 0; dict != NULL && i < ty_medium_preset_count(); ++i)
        if (put(dict, ty_medium_preset_name(i), PyUnicode_FromString(kinds[ty_medium_preset_kind(i)])) != 0) {
            Py_DECREF(dict);
            return NULL;
        }
    return dict;
}

/* The coefficients of a medium given as on a command line. */
static PyObject* parse_medium(PyObject* module, PyObject* arguments) {
    context_object* context;
    const char* text;
    ty_medium_def medium = ty_default_medium_def();
    (void)module;
    if (!PyArg_ParseTuple(arguments, "O!s", context_type, &context, &text)) return NULL;
    const ty_result result = ty_medium_parse(context->context, text, &medium);
    if (result != TY_OK) return raise_result(result, ty_take_error(context->context));
    return Py_BuildValue("{s:N,s:N,s:N}", "sigma_s", tuple_of_floats(medium.sigma_s, 3), "sigma_a",
                         tuple_of_floats(medium.sigma_a, 3), "g", tuple_of_floats(medium.g, 3));
}

static PyObject* blackbody(PyObject* module, PyObject* arguments) {
    double kelvin;
    float radiance[3];
    (void)module;
    if (!PyArg_ParseTuple(arguments, "d", &kelvin)) return NULL;
    ty_blackbody(kelvin, radiance);
    return tuple_of_floats(radiance, 3);
}

PyMethodDef fact_functions[] = {
    {"schema", schema, METH_NOARGS, "schema()\n--\n\nThe JSON Schema of scene files."},
    {"methods", method_names, METH_NOARGS, "methods()\n--\n\nNames of the methods."},
    {"presets", presets, METH_NOARGS, "presets()\n--\n\nNames of the presets of media and their kinds."},
    {"parse_medium", parse_medium, METH_VARARGS, "parse_medium(context, text)\n--\n\nCoefficients, 1/m, and g."},
    {"blackbody", blackbody, METH_VARARGS, "blackbody(kelvin)\n--\n\nRadiance, W m^-2 sr^-1."},
    {NULL, NULL, 0, NULL}};
