/* Images of scenes by the names of methods. */
#include "module.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

typedef struct measurement {
    char name[48], text[64];
    double numbers[24];
    int32_t count; /* -1: the text */
} measurement;

enum { MEASUREMENTS_MAX = 64 };

typedef struct render_work {
    const ty_scene* scene;
    ty_render_def def;
    ty_render_settings settings;
    ty_choose_def choose;
    ty_choice choice;
    ty_image* out;
    measurement measurements[MEASUREMENTS_MAX];
    int32_t count;
    context_object* context;
    PyObject* partial;      /* called with images so far; NULL: none */
    pthread_mutex_t lock;   /* of latest */
    ty_image* latest;       /* not yet shown; NULL: none */
    const char* state_path; /* of a file to go on from, if it is there, and to keep up to date; NULL: none */
} render_work;

static void keep_measurement(void* user, const char* name, const double* numbers, int32_t count, const char* text) {
    render_work* w = user;
    if (w->count == MEASUREMENTS_MAX) return;
    measurement* m = &w->measurements[w->count++];
    snprintf(m->name, sizeof m->name, "%s", name);
    m->count = text != NULL ? -1 : count;
    if (text != NULL) snprintf(m->text, sizeof m->text, "%s", text);
    for (int32_t i = 0; text == NULL && i < count && i < 24; ++i) m->numbers[i] = numbers[i];
}

/* A copy of the channels; NULL without memory. */
static ty_image* copy_image(ty_context* context, const ty_image* image) {
    enum { CHANNELS_MAX = 64 };
    const char* names[CHANNELS_MAX];
    const int32_t count = ty_image_channel_count(image);
    const size_t pixels = (size_t)ty_image_width(image) * (size_t)ty_image_height(image);
    ty_image* copy = NULL;
    if (count > CHANNELS_MAX) return NULL;
    for (int32_t i = 0; i < count; ++i) names[i] = ty_image_channel_name(image, i);
    if (ty_image_create(context, ty_image_width(image), ty_image_height(image), count, names, &copy) != TY_OK)
        return NULL;
    for (int32_t i = 0; i < count; ++i)
        memcpy(ty_image_plane(copy, i), ty_image_plane_const(image, i), pixels * sizeof(float));
    return copy;
}

/* Leaves a copy of the image so far for show_partial, on any thread. */
static bool keep_partial(void* user, const ty_image* image) {
    render_work* w = user;
    ty_image* copy = copy_image(w->context->context, image);
    pthread_mutex_lock(&w->lock);
    ty_image* before = w->latest;
    w->latest = copy != NULL ? copy : before;
    pthread_mutex_unlock(&w->lock);
    if (copy != NULL) ty_image_destroy(before);
    return true;
}

/* Shows the latest image to Python, on the calling thread. */
static PyObject* show_partial(void* user) {
    render_work* w = user;
    pthread_mutex_lock(&w->lock);
    ty_image* latest = w->latest;
    w->latest = NULL;
    pthread_mutex_unlock(&w->lock);
    if (latest == NULL) Py_RETURN_NONE;
    PyObject* image = wrap_image(w->context, latest);
    PyObject* answer = image != NULL ? PyObject_CallFunction(w->partial, "O", image) : NULL;
    Py_XDECREF(image);
    return answer;
}

/* A state that cannot be written is a warning, and the work goes on. */
static bool write_state(void* user, const void* state, size_t size) {
    render_work* w = user;
    ty_context* context = w->context->context;
    if (ty_bytes_write(context, w->state_path, state, size) != TY_OK)
        context_log(w->context, TY_LOG_WARNING, ty_take_error(context));
    return true;
}

static ty_result render_scene(void* user) {
    render_work* w = user;
    ty_context* context = w->context->context;
    uint8_t* bytes = NULL;
    size_t size = 0;
    ty_result result = TY_OK;
    if (w->state_path != NULL) {
        w->def.state = write_state;
        w->def.state_user = w;
        if (access(w->state_path, F_OK) == 0)
            result = ty_bytes_read(context, w->state_path, PTRDIFF_MAX, &bytes, &size);
    }
    w->def.resume = bytes;
    w->def.resume_size = size;
    if (result == TY_OK) result = ty_render(w->scene, &w->def, &w->out);
    ty_bytes_destroy(context, bytes, size);
    return result;
}

static PyObject* measurements(const render_work* w) {
    PyObject* dict = PyDict_New();
    for (int32_t i = 0; dict != NULL && i < w->count; ++i) {
        const measurement* m = &w->measurements[i];
        PyObject* value = m->count < 0    ? PyUnicode_FromString(m->text)
                          : m->count == 1 ? PyFloat_FromDouble(m->numbers[0])
                                          : tuple_of_doubles(m->numbers, m->count);
        if (put(dict, m->name, value) != 0) {
            Py_DECREF(dict);
            return NULL;
        }
    }
    return dict;
}

static int read_settings(const char* method, int spp, unsigned long long seed, ty_render_settings* out) {
    if (strlen(method) >= sizeof out->method) {
        raise_argument("there is no method %.32s", method);
        return -1;
    }
    memcpy(out->method, method, strlen(method) + 1);
    out->spp = spp;
    out->seed = seed;
    return 0;
}

/* (method, spp, seed, seconds, error, (width, height), (x, y, width, height), aovs, state, partial, progress) ->
 * (image, measurements, complete) */
PyObject* scene_render(PyObject* self, PyObject* arguments) {
    scene_object* scene = (scene_object*)self;
    PyObject *size, *crop, *partial, *progress;
    const char *method, *state;
    int spp;
    unsigned int aovs;
    unsigned long long seed;
    int32_t sides[2];
    double seconds, error;
    if (!PyArg_ParseTuple(arguments, "siKddOOIzOO", &method, &spp, &seed, &seconds, &error, &size, &crop, &aovs, &state,
                          &partial, &progress))
        return NULL;
    render_work* w = calloc(1, sizeof *w);
    if (w == NULL) return PyErr_NoMemory();
    call running = {.context = scene->context, .work = render_scene, .user = w, .progress = callable_or_null(progress)};
    w->def = ty_default_render_def();
    w->context = scene->context;
    w->state_path = state;
    w->partial = callable_or_null(partial);
    pthread_mutex_init(&w->lock, NULL);
    if (w->partial != NULL) {
        w->def.partial = keep_partial;
        w->def.partial_user = w;
        running.poll = show_partial;
    }
    PyObject* answer = NULL;
    bool ready = read_settings(method, spp, seed, &w->settings) == 0 && ints_of(size, "size", 2, sides) == 0 &&
                 ints_of(crop, "crop", 4, w->def.crop) == 0;
    if (ready) {
        w->def.width = sides[0];
        w->def.height = sides[1];
        w->def.settings = &w->settings;
        w->def.seconds = seconds;
        w->def.error = error;
        w->def.aovs = aovs;
        w->def.progress = call_progress;
        w->def.progress_user = &running;
        w->def.measurement = keep_measurement;
        w->def.measurement_user = w;
        w->scene = scene_begin(scene);
        ready = w->scene != NULL;
    }
    if (ready) {
        call_run(&running);
        scene_end(scene);
        PyObject* image = w->out != NULL ? wrap_image(scene->context, w->out) : NULL;
        PyObject* stats = measurements(w);
        PyObject* made =
            image != NULL && stats != NULL ? Py_BuildValue("(OOi)", image, stats, running.result == TY_OK) : NULL;
        Py_XDECREF(image);
        Py_XDECREF(stats);
        if (made == NULL) PyErr_Clear();
        if (call_raise(&running, made) == 0)
            answer = made;
        else
            Py_XDECREF(made);
        if (answer == NULL && PyErr_Occurred() == NULL) PyErr_NoMemory();
    }
    ty_image_destroy(w->latest);
    pthread_mutex_destroy(&w->lock);
    free(w);
    return answer;
}

static ty_result choose_method(void* user) {
    render_work* w = user;
    return ty_choose_method(w->scene, &w->choose, &w->choice);
}

/* (asks, aovs, (width, height), spp) -> (method, reason, error, seconds of one thread) */
PyObject* scene_choose(PyObject* self, PyObject* arguments) {
    scene_object* scene = (scene_object*)self;
    PyObject* size;
    unsigned int asks, aovs;
    int spp;
    int32_t sides[2];
    if (!PyArg_ParseTuple(arguments, "IIOi", &asks, &aovs, &size, &spp) || ints_of(size, "size", 2, sides) != 0)
        return NULL;
    render_work* w = calloc(1, sizeof *w);
    if (w == NULL) return PyErr_NoMemory();
    w->choose = ty_default_choose_def();
    w->choose.asks = asks;
    w->choose.aovs = aovs;
    w->choose.width = sides[0];
    w->choose.height = sides[1];
    w->choose.spp = spp;
    PyObject* answer = NULL;
    w->scene = scene_begin(scene);
    if (w->scene != NULL) {
        const int status = call_simple(scene->context, choose_method, w);
        scene_end(scene);
        if (status == 0)
            answer = Py_BuildValue("(ssdd)", w->choice.method, w->choice.reason, w->choice.error, w->choice.seconds);
    }
    free(w);
    return answer;
}
