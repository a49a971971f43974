/* Scenes: editors of their documents, and rendering. */
#include "module.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

PyTypeObject* scene_type;

static void destroy(PyObject* self) {
    scene_object* scene = (scene_object*)self;
    ty_scene_editor_close(scene->editor);
    Py_XDECREF((PyObject*)scene->context);
    free_object(self);
}

const ty_scene* scene_begin(scene_object* scene) {
    if (scene->edits > 0) {
        raise_argument("the scene is being changed in another thread");
        return NULL;
    }
    ++scene->users;
    return ty_scene_editor_scene(scene->editor);
}

void scene_end(scene_object* scene) {
    --scene->users;
}

/* scene_begin for changes; false after an exception. edit_end follows. */
static bool edit_begin(scene_object* scene) {
    if (scene->users > 0 || scene->edits > 0) {
        raise_argument("the scene is in use: it cannot change before the calls that use it have returned");
        return false;
    }
    ++scene->edits;
    return true;
}

static void edit_end(scene_object* scene) {
    --scene->edits;
}

/* ---- opening ---- */

typedef struct open_work {
    ty_context* context;
    const char *path, *text, *name, *folder;
    Py_ssize_t length;
    const char** overrides;
    int32_t count;
    ty_scene_editor* out;
} open_work;

static ty_result open_scene(void* user) {
    open_work* w = user;
    if (w->path != NULL) return ty_scene_editor_open(w->context, w->path, w->overrides, w->count, &w->out);
    return ty_scene_editor_open_text(w->context, w->text, (size_t)w->length, w->name, w->folder, w->overrides, w->count,
                                     &w->out);
}

/* Texts of a tuple of strings, which they belong to; freed by free(); NULL after an exception. */
static const char** texts_of(PyObject* tuple) {
    const Py_ssize_t count = PyTuple_Size(tuple);
    const char** texts = calloc((size_t)count + 1, sizeof *texts);
    if (texts == NULL) PyErr_NoMemory();
    for (Py_ssize_t i = 0; texts != NULL && i < count; ++i) {
        texts[i] = PyUnicode_AsUTF8AndSize(PyTuple_GetItem(tuple, i), NULL);
        if (texts[i] != NULL) continue;
        free(texts);
        return NULL;
    }
    return texts;
}

static PyObject* create(PyTypeObject* type, PyObject* arguments, PyObject* keywords) {
    context_object* context;
    PyObject* overrides;
    open_work w = {.count = 0};
    (void)keywords;
    if (!PyArg_ParseTuple(arguments, "O!zz#zzO!", context_type, &context, &w.path, &w.text, &w.length, &w.name,
                          &w.folder, &PyTuple_Type, &overrides))
        return NULL;
    w.context = context->context;
    w.count = (int32_t)PyTuple_Size(overrides);
    w.overrides = texts_of(overrides);
    if (w.overrides == NULL) return NULL;
    const int status = call_simple(context, open_scene, &w);
    free(w.overrides);
    scene_object* self = status == 0 ? new_object(type) : NULL;
    if (self == NULL) {
        ty_scene_editor_close(w.out);
        return NULL;
    }
    Py_INCREF((PyObject*)context);
    self->context = context;
    self->editor = w.out;
    return (PyObject*)self;
}

/* ---- changes ---- */

typedef struct apply_work {
    ty_scene_editor* editor;
    ty_scene_change* changes;
    int32_t count;
    uint32_t edited;
} apply_work;

static ty_result apply_changes(void* user) {
    apply_work* w = user;
    return ty_scene_editor_apply(w->editor, w->changes, w->count, &w->edited);
}

/* changes: a tuple of paths and values, one after another. */
static PyObject* apply(PyObject* self, PyObject* arguments) {
    scene_object* scene = (scene_object*)self;
    PyObject* given;
    if (!PyArg_ParseTuple(arguments, "O!", &PyTuple_Type, &given)) return NULL;
    apply_work w = {.editor = scene->editor, .count = (int32_t)(PyTuple_Size(given) / 2)};
    const char** texts = texts_of(given);
    if (texts == NULL) return NULL;
    w.changes = calloc((size_t)w.count + 1, sizeof *w.changes);
    for (int32_t i = 0; w.changes != NULL && i < w.count; ++i)
        w.changes[i] = (ty_scene_change){.path = texts[2 * i], .value = texts[2 * i + 1]};
    PyObject* edited = NULL;
    if (w.changes == NULL) {
        PyErr_NoMemory();
    } else if (edit_begin(scene)) {
        if (call_simple(scene->context, apply_changes, &w) == 0) edited = PyLong_FromUnsignedLong(w.edited);
        edit_end(scene);
    }
    free(w.changes);
    free(texts);
    return edited;
}

typedef struct memory_work {
    ty_scene_editor* editor;
    const char* name;
    ty_grid* grids[3];
    int32_t count;
    ty_mesh_def mesh;
    const ty_image* image;
} memory_work;

static ty_result give_volume(void* user) {
    memory_work* w = user;
    return ty_scene_editor_set_volume(w->editor, w->name, w->grids, w->count);
}

static ty_result give_mesh(void* user) {
    memory_work* w = user;
    return ty_scene_editor_set_mesh(w->editor, w->name, &w->mesh);
}

static ty_result give_image(void* user) {
    memory_work* w = user;
    return ty_scene_editor_set_image(w->editor, w->name, w->image);
}

static PyObject* give(scene_object* scene, ty_result (*function)(void* user), memory_work* w) {
    if (!edit_begin(scene)) return NULL;
    const int status = call_simple(scene->context, function, w);
    edit_end(scene);
    if (status != 0) return NULL;
    Py_RETURN_NONE;
}

static PyObject* set_volume(PyObject* self, PyObject* arguments) {
    scene_object* scene = (scene_object*)self;
    memory_work w = {.editor = scene->editor};
    PyObject* grids;
    if (!PyArg_ParseTuple(arguments, "sO!", &w.name, &PyTuple_Type, &grids)) return NULL;
    w.count = (int32_t)PyTuple_Size(grids);
    for (int32_t i = 0; i < w.count && i < 3; ++i) {
        PyObject* grid = PyTuple_GetItem(grids, i);
        if (!PyObject_TypeCheck(grid, grid_type)) return raise_argument("%s: expected a Grid", w.name);
        w.grids[i] = ((grid_object*)grid)->grid;
    }
    return give(scene, give_volume, &w);
}

static PyObject* set_image(PyObject* self, PyObject* arguments) {
    scene_object* scene = (scene_object*)self;
    memory_work w = {.editor = scene->editor};
    PyObject* image;
    if (!PyArg_ParseTuple(arguments, "sO!", &w.name, image_type, &image)) return NULL;
    w.image = ((image_object*)image)->image;
    return give(scene, give_image, &w);
}

/* Numbers per vertex, NULL for None: true on success. */
static bool vertex_values(PyObject* object, const char* what, Py_ssize_t per_vertex, Py_ssize_t vertices, float** out) {
    Py_ssize_t count = 0;
    *out = NULL;
    if (object == Py_None) return true;
    *out = floats_from(object, what, per_vertex, &count);
    if (*out == NULL || count == vertices) return *out != NULL;
    raise_argument("%s: there are %zd, and %zd vertices", what, count, vertices);
    return false;
}

static PyObject* set_mesh(PyObject* self, PyObject* arguments) {
    scene_object* scene = (scene_object*)self;
    memory_work w = {.editor = scene->editor, .mesh = ty_default_mesh_def()};
    PyObject *positions, *indices, *normals, *uv, *colors;
    if (!PyArg_ParseTuple(arguments, "sOOOOO", &w.name, &positions, &indices, &normals, &uv, &colors)) return NULL;
    Py_ssize_t vertices = 0, triangles = 0;
    float *points = floats_from(positions, "positions", 3, &vertices), *normal = NULL, *texture = NULL, *color = NULL;
    uint32_t* corners = points != NULL ? indices_from(indices, "indices", 3, &triangles) : NULL;
    PyObject* done = NULL;
    if (corners != NULL && vertex_values(normals, "normals", 3, vertices, &normal) &&
        vertex_values(uv, "uv", 2, vertices, &texture) && vertex_values(colors, "colors", 4, vertices, &color)) {
        w.mesh.vertex_count = vertices;
        w.mesh.triangle_count = triangles;
        w.mesh.positions = points;
        w.mesh.indices = corners;
        w.mesh.normals = normal;
        w.mesh.uv[0] = w.mesh.uv[1] = texture;
        w.mesh.colors = color;
        done = give(scene, give_mesh, &w);
    }
    free(points);
    free(corners);
    free(normal);
    free(texture);
    free(color);
    return done;
}

static PyObject* drop(PyObject* self, PyObject* arguments) {
    scene_object* scene = (scene_object*)self;
    const char* name;
    if (!PyArg_ParseTuple(arguments, "s", &name) || !edit_begin(scene)) return NULL;
    ty_scene_editor_drop(scene->editor, name);
    edit_end(scene);
    Py_RETURN_NONE;
}

/* ---- attributes ---- */

static PyObject* get_text(PyObject* self, void* closure) {
    (void)closure;
    return PyUnicode_FromString(ty_scene_editor_text(((scene_object*)self)->editor));
}

static const ty_scene* scene_of(PyObject* self) {
    return ty_scene_editor_scene(((scene_object*)self)->editor);
}

static PyObject* get_hash(PyObject* self, void* closure) {
    char text[20];
    (void)closure;
    snprintf(text, sizeof text, "%016" PRIx64, ty_scene_hash(scene_of(self)));
    return PyUnicode_FromString(text);
}

static PyObject* get_info(PyObject* self, void* closure) {
    const ty_scene_info info = ty_scene_get_info(scene_of(self));
    (void)closure;
    return Py_BuildValue("{s:i,s:i,s:i,s:i,s:L,s:L,s:L,s:N,s:N,s:N,s:n}", "media", (int)info.media, "lights",
                         (int)info.lights, "shapes", (int)info.shapes, "meshes", (int)info.meshes, "triangles",
                         (long long)info.triangles, "textures", (long long)info.textures, "emitters",
                         (long long)info.emitters, "bounded", PyBool_FromLong(info.bounded), "lower",
                         tuple_of_doubles(info.lower, 3), "upper", tuple_of_doubles(info.upper, 3), "bytes",
                         (Py_ssize_t)info.bytes);
}

static PyObject* get_settings(PyObject* self, void* closure) {
    const ty_render_settings settings = ty_scene_render_settings(scene_of(self));
    (void)closure;
    return Py_BuildValue("{s:s,s:i,s:K}", "method", settings.method, "spp", (int)settings.spp, "seed",
                         (unsigned long long)settings.seed);
}

static PyObject* get_camera(PyObject* self, void* closure) {
    const ty_camera_def camera = ty_scene_camera(scene_of(self));
    (void)closure;
    return Py_BuildValue("{s:N,s:N,s:N,s:d,s:N,s:d}", "position", tuple_of_doubles(camera.position, 3), "target",
                         tuple_of_doubles(camera.target, 3), "up", tuple_of_doubles(camera.up, 3), "fov_y",
                         camera.fov_y, "resolution", tuple_of_ints(camera.resolution, 2), "exposure", camera.exposure);
}

static PyGetSetDef properties[] = {{"text", get_text, NULL, "The document as JSON.", NULL},
                                   {"hash", get_hash, NULL, "Hash of the document and of what it names.", NULL},
                                   {"info", get_info, NULL, "Counts, bounding box (m) and memory.", NULL},
                                   {"settings", get_settings, NULL, "Method, samples and seed.", NULL},
                                   {"camera", get_camera, NULL, "The camera.", NULL},
                                   {NULL, NULL, NULL, NULL, NULL}};

/* ---- rendering ---- */

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

/* (method, spp, seed, seconds, error, (width, height), (x, y, width, height), aovs, state, progress) ->
 * (image, measurements, complete) */
static PyObject* render(PyObject* self, PyObject* arguments) {
    scene_object* scene = (scene_object*)self;
    PyObject *size, *crop, *progress;
    const char *method, *state;
    int spp;
    unsigned int aovs;
    unsigned long long seed;
    int32_t sides[2];
    double seconds, error;
    if (!PyArg_ParseTuple(arguments, "siKddOOIzO", &method, &spp, &seed, &seconds, &error, &size, &crop, &aovs, &state,
                          &progress))
        return NULL;
    render_work* w = calloc(1, sizeof *w);
    if (w == NULL) return PyErr_NoMemory();
    call running = {.context = scene->context, .work = render_scene, .user = w, .progress = callable_or_null(progress)};
    w->def = ty_default_render_def();
    w->context = scene->context;
    w->state_path = state;
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
        PyObject* partial =
            image != NULL && stats != NULL ? Py_BuildValue("(OOi)", image, stats, running.result == TY_OK) : NULL;
        Py_XDECREF(image);
        Py_XDECREF(stats);
        if (partial == NULL) PyErr_Clear();
        if (call_raise(&running, partial) == 0)
            answer = partial;
        else
            Py_XDECREF(partial);
        if (answer == NULL && PyErr_Occurred() == NULL) PyErr_NoMemory();
    }
    free(w);
    return answer;
}

static ty_result choose_method(void* user) {
    render_work* w = user;
    return ty_choose_method(w->scene, &w->choose, &w->choice);
}

/* (asks, aovs, (width, height), spp) -> (method, reason, error, seconds of one thread) */
static PyObject* choose(PyObject* self, PyObject* arguments) {
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

static PyMethodDef methods[] = {
    {"apply", apply, METH_VARARGS, "apply(changes)\n--\n\nApplies changes, (path, JSON, path, JSON ...), or none."},
    {"set_volume", set_volume, METH_VARARGS, "set_volume(name, grids)\n--\n\nGives memory:NAME."},
    {"set_mesh", set_mesh, METH_VARARGS,
     "set_mesh(name, positions, indices, normals, uv, colors)\n--\n\nGives memory:NAME."},
    {"set_image", set_image, METH_VARARGS, "set_image(name, image)\n--\n\nGives memory:NAME."},
    {"drop", drop, METH_VARARGS, "drop(name)\n--\n\nForgets memory:NAME."},
    {"render", render, METH_VARARGS,
     "render(method, spp, seed, seconds, error, size, crop, aovs, state, progress)\n--\n\n(image, measurements, "
     "complete)."},
    {"choose", choose, METH_VARARGS, "choose(asks, aovs, size, spp)\n--\n\n(method, reason, error, seconds)."},
    {"solve", scene_solve, METH_VARARGS, "solve(method, progress)\n--\n\n(light, measurements)."},
    {"fluence", scene_fluence, METH_VARARGS,
     "fluence(lower, upper, size, spp, seed, progress)\n--\n\n(fluence, uncollided, variance) by path tracing."},
    {"radiance", scene_radiance, METH_VARARGS,
     "radiance(rays, spp, seed, progress)\n--\n\n(radiance, variance) by path tracing."},
    {"transmittance", scene_transmittance, METH_VARARGS, "transmittance(start, end, spp, seed)\n--\n\nOf the media."},
    {"bake_lightmap", scene_bake_lightmap, METH_VARARGS,
     "bake_lightmap(mesh, options, atlas, progress)\n--\n\nAn image."},
    {"bake_vertices", scene_bake_vertices, METH_VARARGS, "bake_vertices(mesh, options, progress)\n--\n\nAn image."},
    {"bake_probes", scene_bake_probes, METH_VARARGS,
     "bake_probes(positions, size, terms, options, progress)\n--\n\nAn image."},
    {NULL, NULL, 0, NULL}};

static PyType_Slot slots[] = {
    {Py_tp_doc, "Scene(context, path, text, name, folder, overrides)\n--\n\nA scene with its document."},
    {Py_tp_new, create},
    {Py_tp_dealloc, destroy},
    {Py_tp_methods, methods},
    {Py_tp_getset, properties},
    {0, NULL}};

static PyType_Spec spec = {"tyndall._core.Scene", sizeof(scene_object), 0, Py_TPFLAGS_DEFAULT, slots};

int add_scene_type(PyObject* module) {
    return add_type(module, &spec, &scene_type);
}
