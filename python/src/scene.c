/* Scenes: editors of their documents. */
#include "module.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

PyTypeObject* scene_type;

static void destroy(PyObject* self) {
    scene_object* scene = (scene_object*)self;
    ty_scene_editor_close(scene->editor);
    Py_XDECREF(scene->others);
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

/* Keeps the context of a grid, which the scene may hold longer than others do: 0, or -1 after an exception. */
static int keep_context(scene_object* scene, context_object* context) {
    if (context == scene->context) return 0;
    if (scene->others == NULL) scene->others = PySet_New(NULL);
    return scene->others != NULL ? PySet_Add(scene->others, (PyObject*)context) : -1;
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
        if (keep_context(scene, ((grid_object*)grid)->context) != 0) return NULL;
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

/* The scene as it is, for a reader that keeps the interpreter's lock; NULL after an exception if it is being changed.
 */
static const ty_scene* scene_of(PyObject* self) {
    const ty_scene* scene = scene_begin((scene_object*)self);
    if (scene != NULL) scene_end((scene_object*)self);
    return scene;
}

static PyObject* get_text(PyObject* self, void* closure) {
    (void)closure;
    if (scene_of(self) == NULL) return NULL;
    return PyUnicode_FromString(ty_scene_editor_text(((scene_object*)self)->editor));
}

static PyObject* get_hash(PyObject* self, void* closure) {
    const ty_scene* scene = scene_of(self);
    char text[20];
    (void)closure;
    if (scene == NULL) return NULL;
    snprintf(text, sizeof text, "%016" PRIx64, ty_scene_hash(scene));
    return PyUnicode_FromString(text);
}

static PyObject* get_info(PyObject* self, void* closure) {
    const ty_scene* scene = scene_of(self);
    (void)closure;
    if (scene == NULL) return NULL;
    const ty_scene_info info = ty_scene_get_info(scene);
    return Py_BuildValue("{s:i,s:i,s:i,s:i,s:L,s:L,s:L,s:N,s:N,s:N,s:n}", "media", (int)info.media, "lights",
                         (int)info.lights, "shapes", (int)info.shapes, "meshes", (int)info.meshes, "triangles",
                         (long long)info.triangles, "textures", (long long)info.textures, "emitters",
                         (long long)info.emitters, "bounded", PyBool_FromLong(info.bounded), "lower",
                         tuple_of_doubles(info.lower, 3), "upper", tuple_of_doubles(info.upper, 3), "bytes",
                         (Py_ssize_t)info.bytes);
}

static PyObject* get_settings(PyObject* self, void* closure) {
    const ty_scene* scene = scene_of(self);
    (void)closure;
    if (scene == NULL) return NULL;
    const ty_render_settings settings = ty_scene_render_settings(scene);
    return Py_BuildValue("{s:s,s:i,s:K}", "method", settings.method, "spp", (int)settings.spp, "seed",
                         (unsigned long long)settings.seed);
}

static PyObject* get_camera(PyObject* self, void* closure) {
    const ty_scene* scene = scene_of(self);
    (void)closure;
    if (scene == NULL) return NULL;
    const ty_camera_def camera = ty_scene_camera(scene);
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

static PyMethodDef methods[] = {
    {"apply", apply, METH_VARARGS, "apply(changes)\n--\n\nApplies changes, (path, JSON, path, JSON ...), or none."},
    {"set_volume", set_volume, METH_VARARGS, "set_volume(name, grids)\n--\n\nGives memory:NAME."},
    {"set_mesh", set_mesh, METH_VARARGS,
     "set_mesh(name, positions, indices, normals, uv, colors)\n--\n\nGives memory:NAME."},
    {"set_image", set_image, METH_VARARGS, "set_image(name, image)\n--\n\nGives memory:NAME."},
    {"drop", drop, METH_VARARGS, "drop(name)\n--\n\nForgets memory:NAME."},
    {"render", scene_render, METH_VARARGS,
     "render(method, spp, seed, seconds, error, size, crop, aovs, state, partial, progress)\n--\n\n(image, "
     "measurements, "
     "complete)."},
    {"choose", scene_choose, METH_VARARGS, "choose(asks, aovs, size, spp)\n--\n\n(method, reason, error, seconds)."},
    {"solve", scene_solve, METH_VARARGS, "solve(method, progress)\n--\n\n(light, measurements)."},
    {"fluence", scene_fluence, METH_VARARGS,
     "fluence(lower, upper, size, spp, seed, progress)\n--\n\n(fluence, uncollided, variance) by path tracing."},
    {"radiance", scene_radiance, METH_VARARGS,
     "radiance(rays, spp, seed, progress)\n--\n\n(radiance, variance) by path tracing."},
    {"flux", scene_flux, METH_VARARGS,
     "flux(levels, views, columns, area, spp, seed, progress)\n--\n\nPairs of values "
     "and errors: up, down_diffuse, down_direct, absorbed, radiance."},
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
