/* Baking: lightmaps, vertices and probes as images. */
#include "module.h"

#include <stdlib.h>
#include <string.h>

typedef struct bake_work {
    ty_context* context;
    const ty_scene* scene;
    int32_t mesh, terms, width, grid[3];
    ty_bake_def def;
    ty_atlas_def atlas;
    const float* positions;
    int64_t count;
    bool partial;
    ty_image* out;
} bake_work;

/* Light at receivers, for images; freed by free(). TY_CANCELLED leaves it valid. */
static ty_result gather(bake_work* w, const ty_bake_receiver* receivers, int64_t count, ty_bake_light** light) {
    *light = calloc((size_t)count + 1, sizeof **light);
    if (*light == NULL) return TY_ERROR_MEMORY;
    ty_result result = count > 0 ? ty_bake_surfaces(w->scene, &w->def, receivers, count, *light, NULL) : TY_OK;
    w->partial = result == TY_CANCELLED;
    return w->partial ? TY_OK : result;
}

static ty_result bake_lightmap(void* user) {
    bake_work* w = user;
    ty_atlas* atlas = NULL;
    ty_bake_light* light = NULL;
    int64_t count = 0;
    ty_result result = ty_atlas_create(w->scene, w->mesh, "mesh", &w->atlas, &atlas);
    if (result != TY_OK) return result;
    const ty_bake_receiver* receivers = ty_atlas_receivers(atlas, &count);
    result = gather(w, receivers, count, &light);
    if (result == TY_OK) result = ty_atlas_create_image(atlas, light, &w->out);
    free(light);
    ty_atlas_destroy(atlas);
    return result == TY_OK && w->partial ? TY_CANCELLED : result;
}

static ty_result bake_vertices(void* user) {
    bake_work* w = user;
    ty_mesh_def mesh = ty_default_mesh_def();
    ty_result result = ty_scene_get_mesh(w->scene, w->mesh, &mesh);
    if (result != TY_OK) return result;
    ty_bake_receiver* receivers = calloc((size_t)mesh.vertex_count, sizeof *receivers);
    ty_bake_light* light = NULL;
    if (receivers == NULL) return TY_ERROR_MEMORY;
    result = ty_bake_vertices(w->scene, w->mesh, receivers);
    if (result == TY_OK) result = gather(w, receivers, mesh.vertex_count, &light);
    const int32_t width = mesh.vertex_count < 4096 ? (int32_t)mesh.vertex_count : 4096;
    if (result == TY_OK) result = ty_bake_create_light_image(w->context, light, mesh.vertex_count, width, &w->out);
    free(light);
    free(receivers);
    return result == TY_OK && w->partial ? TY_CANCELLED : result;
}

static ty_result bake_probes(void* user) {
    bake_work* w = user;
    ty_bake_probe* probes = calloc((size_t)w->count, sizeof *probes);
    if (probes == NULL) return TY_ERROR_MEMORY;
    ty_result result = ty_bake_probes(w->scene, &w->def, w->positions, w->count, probes, NULL);
    w->partial = result == TY_CANCELLED;
    if (result == TY_OK || w->partial)
        result = ty_bake_create_probe_image(w->context, probes, w->grid, w->terms, &w->out);
    free(probes);
    return result == TY_OK && w->partial ? TY_CANCELLED : result;
}

/* options: (method, spp, error, bounces, scatterings, back_scattering, cells, cell_paths, seed), None: the default. */
static int read_options(PyObject* options, ty_bake_def* def) {
    int32_t* const integers[] = {&def->spp, &def->bounces, &def->scatterings, &def->cells, &def->cell_paths};
    PyObject *method, *given[5], *error, *back, *seed;
    *def = ty_default_bake_def();
    if (!PyArg_ParseTuple(options, "OOOOOOOOO", &method, &given[0], &error, &given[1], &given[2], &back, &given[3],
                          &given[4], &seed))
        return -1;
    for (int i = 0; i < 5; ++i) {
        if (given[i] == Py_None) continue;
        const long value = PyLong_AsLong(given[i]);
        if (value == -1 && PyErr_Occurred() != NULL) return -1;
        *integers[i] = value < INT32_MIN || value > INT32_MAX ? -1 : (int32_t)value;
    }
    if (method != Py_None) def->method = (ty_bake_method)PyLong_AsLong(method);
    if (error != Py_None) def->error = PyFloat_AsDouble(error);
    if (back != Py_None) def->back_scattering = PyObject_IsTrue(back) != 0;
    if (seed != Py_None) def->seed = PyLong_AsUnsignedLongLong(seed);
    return PyErr_Occurred() != NULL ? -1 : 0;
}

/* atlas: (width, height, density, padding, close_seams). */
static int read_atlas(PyObject* atlas, ty_atlas_def* def) {
    int width, height, padding, close;
    *def = ty_default_atlas_def();
    if (!PyArg_ParseTuple(atlas, "iidip", &width, &height, &def->density, &padding, &close)) return -1;
    def->width = width;
    def->height = height;
    def->padding = padding;
    def->close_seams = close != 0;
    return 0;
}

/* Runs a bake: the image, and whether it is complete. */
static PyObject* run(scene_object* scene, ty_result (*function)(void* user), bake_work* w, PyObject* progress) {
    call running = {.context = scene->context, .work = function, .user = w, .progress = callable_or_null(progress)};
    w->context = scene->context->context;
    w->def.progress = call_progress;
    w->def.progress_user = &running;
    w->scene = scene_begin(scene);
    if (w->scene == NULL) return NULL;
    call_run(&running);
    scene_end(scene);
    PyObject* image = w->out != NULL ? wrap_image(scene->context, w->out) : NULL;
    PyObject* answer = image != NULL ? Py_BuildValue("(OO)", image, w->partial ? Py_False : Py_True) : NULL;
    Py_XDECREF(image);
    if (answer == NULL) PyErr_Clear();
    if (call_raise(&running, answer) == 0) {
        if (answer == NULL) PyErr_NoMemory();
        return answer;
    }
    Py_XDECREF(answer);
    return NULL;
}

PyObject* scene_bake_lightmap(PyObject* self, PyObject* arguments) {
    PyObject *options, *atlas, *progress;
    int mesh;
    bake_work w = {.partial = false};
    if (!PyArg_ParseTuple(arguments, "iOOO", &mesh, &options, &atlas, &progress)) return NULL;
    w.mesh = mesh;
    if (read_options(options, &w.def) != 0 || read_atlas(atlas, &w.atlas) != 0) return NULL;
    return run((scene_object*)self, bake_lightmap, &w, progress);
}

PyObject* scene_bake_vertices(PyObject* self, PyObject* arguments) {
    PyObject *options, *progress;
    int mesh;
    bake_work w = {.partial = false};
    if (!PyArg_ParseTuple(arguments, "iOO", &mesh, &options, &progress)) return NULL;
    w.mesh = mesh;
    if (read_options(options, &w.def) != 0) return NULL;
    return run((scene_object*)self, bake_vertices, &w, progress);
}

PyObject* scene_bake_probes(PyObject* self, PyObject* arguments) {
    PyObject *positions, *size, *options, *progress;
    int terms;
    Py_ssize_t count = 0;
    bake_work w = {.partial = false};
    if (!PyArg_ParseTuple(arguments, "OOiOO", &positions, &size, &terms, &options, &progress)) return NULL;
    w.terms = terms;
    if (read_options(options, &w.def) != 0 || ints_of(size, "size", 3, w.grid) != 0) return NULL;
    float* points = floats_from(positions, "positions", 3, &count);
    if (points == NULL) return NULL;
    PyObject* answer = NULL;
    w.positions = points;
    w.count = count;
    if ((int64_t)w.grid[0] * w.grid[1] * w.grid[2] == count)
        answer = run((scene_object*)self, bake_probes, &w, progress);
    else
        raise_argument("positions: there are %zd, which do not fill the grid", count);
    free(points);
    return answer;
}
