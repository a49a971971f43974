/* Light that is solved once: fluence, radiance and images of it; and the same by path tracing. */
#include "module.h"

#include <stdlib.h>
#include <string.h>

PyTypeObject* light_type;

typedef enum solver { FLD, DOM, POP, LPV, OCTAVES, SOLVERS } solver;
static const char* const names[SOLVERS] = {"fld", "dom", "pop", "lpv", "octaves"};

struct light_object {
    PyObject_HEAD context_object* context;
    solver solver;
    void* light;
};

static void destroy_light(solver kind, void* light) {
    switch (kind) {
    case FLD: ty_fld_destroy(light); break;
    case DOM: ty_dom_destroy(light); break;
    case POP: ty_pop_destroy(light); break;
    case LPV: ty_lpv_destroy(light); break;
    case OCTAVES: ty_octaves_destroy(light); break;
    case SOLVERS: break;
    }
}

static void destroy(PyObject* self) {
    light_object* light = (light_object*)self;
    if (light->light != NULL) destroy_light(light->solver, light->light);
    Py_XDECREF((PyObject*)light->context);
    free_object(self);
}

/* ---- solving and viewing ---- */

typedef struct light_work {
    solver kind;
    const ty_scene* scene;
    void* light; /* in or out */
    bool viewed; /* false: solve */
    int32_t size[2], spp;
    uint32_t aovs;
    uint64_t seed;
    call* running;
    ty_image* surfaces; /* path-traced, for views */
    ty_image* out;
    union {
        ty_fld_stats fld;
        ty_dom_stats dom;
        ty_pop_stats pop;
        ty_lpv_stats lpv;
        ty_octaves_stats octaves;
    } stats;
} light_work;

/* The solve or the view of one method, with the options of the scene. */
#define DEFINE_WORK(method, ...)                                                                                       \
    static ty_result work_##method(light_work* w) {                                                                    \
        ty_##method##_def def = ty_default_##method##_def();                                                           \
        ty_result result = ty_method_options(w->scene, #method, &def);                                                 \
        if (result != TY_OK) return result;                                                                            \
        w->stats.method = ty_default_##method##_stats();                                                               \
        def.seed = w->seed;                                                                                            \
        def.width = w->size[0];                                                                                        \
        def.height = w->size[1];                                                                                       \
        def.aovs = w->aovs;                                                                                            \
        def.progress = call_progress;                                                                                  \
        def.progress_user = w->running;                                                                                \
        __VA_ARGS__;                                                                                                   \
        if (w->viewed) return ty_##method##_view(w->light, w->scene, &def, &w->out, &w->stats.method);                 \
        ty_##method* light = NULL;                                                                                     \
        result = ty_##method##_solve(w->scene, &def, &light, &w->stats.method);                                        \
        w->light = light;                                                                                              \
        return result;                                                                                                 \
    }
DEFINE_WORK(fld, def.unscattered = w->surfaces)
DEFINE_WORK(dom, def.unscattered = w->surfaces)
DEFINE_WORK(pop, def.unscattered = w->surfaces; def.keep_lobes = true)
DEFINE_WORK(lpv, )
DEFINE_WORK(octaves, def.unscattered = w->surfaces)

/* Light of surfaces through the media, for views of methods that do not find it. */
static ty_result trace_surfaces(light_work* w) {
    const ty_scene_info info = ty_scene_get_info(w->scene);
    if (w->kind == LPV || (info.shapes == 0 && info.meshes == 0)) return TY_OK;
    ty_path_def def = ty_default_path_def();
    ty_result result = ty_method_options(w->scene, "path", &def);
    def.spp = w->spp;
    def.seed = w->seed;
    def.width = w->size[0];
    def.height = w->size[1];
    def.aovs = 0;
    def.unscattered = true;
    def.progress = call_progress;
    def.progress_user = w->running;
    if (result == TY_OK) result = ty_path_render(w->scene, &def, &w->surfaces, NULL);
    return result;
}

static ty_result run_light(void* user) {
    light_work* w = user;
    const ty_result result = w->viewed ? trace_surfaces(w) : TY_OK;
    if (result != TY_OK) return result;
    switch (w->kind) {
    case FLD: return work_fld(w);
    case DOM: return work_dom(w);
    case POP: return work_pop(w);
    case LPV: return work_lpv(w);
    case OCTAVES: return work_octaves(w);
    case SOLVERS: break;
    }
    return TY_ERROR_INTERNAL;
}

/* ---- measurements of solves ---- */

static int put_common(PyObject* dict, double seconds, const int32_t size[3]) {
    return put(dict, "seconds", PyFloat_FromDouble(seconds)) != 0 ? -1 : put(dict, "size", tuple_of_ints(size, 3));
}

static int put_power(PyObject* dict, const double emitted[3], const double absorbed[3], const double leaving[3]) {
    if (put(dict, "emitted", tuple_of_doubles(emitted, 3)) != 0) return -1;
    if (put(dict, "absorbed", tuple_of_doubles(absorbed, 3)) != 0) return -1;
    return put(dict, "leaving", tuple_of_doubles(leaving, 3));
}

static int put_stats(PyObject* dict, const light_work* w) {
    switch (w->kind) {
    case FLD:
        if (put_common(dict, w->stats.fld.seconds, w->stats.fld.diffusion_size) != 0) return -1;
        if (put(dict, "converged", PyBool_FromLong(w->stats.fld.converged)) != 0) return -1;
        if (put(dict, "iterations", tuple_of_ints(w->stats.fld.iterations, 3)) != 0) return -1;
        return put_power(dict, w->stats.fld.emitted, w->stats.fld.absorbed, w->stats.fld.leaving);
    case DOM:
        if (put_common(dict, w->stats.dom.seconds, w->stats.dom.size) != 0) return -1;
        if (put(dict, "converged", PyBool_FromLong(w->stats.dom.converged)) != 0) return -1;
        if (put(dict, "sweeps", tuple_of_ints(w->stats.dom.sweeps, 3)) != 0) return -1;
        return put_power(dict, w->stats.dom.emitted, w->stats.dom.absorbed, w->stats.dom.leaving);
    case POP:
        if (put(dict, "converged", PyBool_FromLong(w->stats.pop.converged)) != 0) return -1;
        return put_common(dict, w->stats.pop.seconds, w->stats.pop.merged_size);
    case LPV:
        if (put(dict, "iterations", PyLong_FromLong(w->stats.lpv.iterations)) != 0) return -1;
        return put_common(dict, w->stats.lpv.seconds, w->stats.lpv.size[0]);
    case OCTAVES: return put_common(dict, w->stats.octaves.seconds, w->stats.octaves.size);
    case SOLVERS: break;
    }
    return 0;
}

static bool find_solver(const char* name, solver* out) {
    for (int i = 0; i < SOLVERS; ++i)
        if (strcmp(names[i], name) == 0) {
            *out = (solver)i;
            return true;
        }
    return false;
}

static PyObject* wrap_light(context_object* context, solver kind, void* content) {
    light_object* light = new_object(light_type);
    if (light == NULL) {
        destroy_light(kind, content);
        return NULL;
    }
    Py_INCREF((PyObject*)context);
    light->context = context;
    light->solver = kind;
    light->light = content;
    return (PyObject*)light;
}

PyObject* scene_solve(PyObject* self, PyObject* arguments) {
    scene_object* scene = (scene_object*)self;
    PyObject* progress;
    const char* name;
    unsigned long long seed;
    light_work w = {.viewed = false};
    if (!PyArg_ParseTuple(arguments, "sKO", &name, &seed, &progress)) return NULL;
    if (!find_solver(name, &w.kind))
        return raise_argument("%.32s does not solve for light; fld, dom, pop, lpv and octaves do", name);
    call running = {.context = scene->context, .work = run_light, .user = &w, .progress = callable_or_null(progress)};
    w.seed = seed;
    w.running = &running;
    w.scene = scene_begin(scene);
    if (w.scene == NULL) return NULL;
    call_run(&running);
    scene_end(scene);
    if (call_raise(&running, NULL) != 0) {
        if (w.light != NULL) destroy_light(w.kind, w.light);
        return NULL;
    }
    PyObject* light = wrap_light(scene->context, w.kind, w.light);
    PyObject* stats = PyDict_New();
    PyObject* answer =
        light != NULL && stats != NULL && put_stats(stats, &w) == 0 ? Py_BuildValue("(OO)", light, stats) : NULL;
    Py_XDECREF(light);
    Py_XDECREF(stats);
    return answer;
}

/* (scene, (width, height), spp, seed, aovs, progress) -> image */
static PyObject* view(PyObject* self, PyObject* arguments) {
    light_object* light = (light_object*)self;
    PyObject *object, *size, *progress;
    int spp;
    unsigned int aovs;
    unsigned long long seed;
    light_work w = {.viewed = true, .kind = light->solver, .light = light->light};
    if (!PyArg_ParseTuple(arguments, "O!OiKIO", scene_type, &object, &size, &spp, &seed, &aovs, &progress) ||
        ints_of(size, "size", 2, w.size) != 0)
        return NULL;
    scene_object* scene = (scene_object*)object;
    if (scene->context != light->context) return raise_argument("light and scene are of two contexts");
    call running = {.context = scene->context, .work = run_light, .user = &w, .progress = callable_or_null(progress)};
    w.spp = spp;
    w.seed = seed;
    w.aovs = aovs;
    w.running = &running;
    w.scene = scene_begin(scene);
    if (w.scene == NULL) return NULL;
    call_run(&running);
    scene_end(scene);
    ty_image_destroy(w.surfaces);
    if (call_raise(&running, NULL) == 0) return wrap_image(scene->context, w.out);
    ty_image_destroy(w.out);
    return NULL;
}

/* ---- fields ---- */

typedef struct field_work {
    solver kind; /* SOLVERS: path tracing */
    const void* light;
    const ty_scene* scene;
    ty_path_def path;
    double lower[3], upper[3];
    int32_t size[3];
    double *fluence, *uncollided, *variance, *flux;
    const double* rays;
    int64_t count;
    double *radiance, *ray_variance;
    double transmittance[3];
} field_work;

static ty_result find_fluence(void* user) {
    field_work* w = user;
    switch (w->kind) {
    case FLD: return ty_fld_fluence(w->light, w->lower, w->upper, w->size, w->fluence, w->uncollided, w->flux);
    case DOM: return ty_dom_fluence(w->light, w->lower, w->upper, w->size, w->fluence, w->uncollided);
    case POP: return ty_pop_fluence(w->light, w->lower, w->upper, w->size, w->fluence, w->uncollided);
    case LPV: return ty_lpv_fluence(w->light, w->lower, w->upper, w->size, w->fluence);
    case OCTAVES: break;
    case SOLVERS:
        return ty_path_fluence(w->scene, &w->path, w->lower, w->upper, w->size, w->fluence, w->uncollided, w->variance);
    }
    return TY_ERROR_UNSUPPORTED;
}

static int read_box(PyObject* lower, PyObject* upper, PyObject* size, field_work* w) {
    if (doubles_of(lower, "lower", 3, w->lower) != 0 || doubles_of(upper, "upper", 3, w->upper) != 0 ||
        ints_of(size, "size", 3, w->size) != 0)
        return -1;
    for (int a = 0; a < 3; ++a)
        if (w->size[a] < 1 || w->size[a] > 16384) {
            raise_argument("size: %d cells, outside 1..16384", (int)w->size[a]);
            return -1;
        }
    return 0;
}

static size_t cells_of(const field_work* w) {
    return (size_t)w->size[0] * (size_t)w->size[1] * (size_t)w->size[2];
}

/* An array (nz, ny, nx, 3), or (nz, ny, nx, 3, 3); None for NULL. */
static PyObject* field_array(const field_work* w, double* data, int axes) {
    if (data == NULL) Py_RETURN_NONE;
    if (axes == 1) {
        const Py_ssize_t shape[4] = {w->size[2], w->size[1], w->size[0], 3};
        return array_own(data, 'd', 4, shape);
    }
    const Py_ssize_t shape[3] = {(Py_ssize_t)cells_of(w), 3, 3};
    return array_own(data, 'd', 3, shape);
}

/* (lower, upper, size) -> (fluence, uncollided, flux) */
static PyObject* fluence(PyObject* self, PyObject* arguments) {
    light_object* light = (light_object*)self;
    PyObject *lower, *upper, *size;
    field_work w = {.kind = light->solver, .light = light->light};
    if (!PyArg_ParseTuple(arguments, "OOO", &lower, &upper, &size) || read_box(lower, upper, size, &w) != 0)
        return NULL;
    if (w.kind == OCTAVES) return raise_argument("octaves has no fluence, but images alone");
    const size_t numbers = 3 * cells_of(&w);
    w.fluence = calloc(numbers, sizeof(double));
    if (w.kind != LPV) w.uncollided = calloc(numbers, sizeof(double));
    if (w.kind == FLD) w.flux = calloc(3 * numbers, sizeof(double));
    const bool allocated =
        w.fluence != NULL && (w.kind == LPV || w.uncollided != NULL) && (w.kind != FLD || w.flux != NULL);
    if (!allocated) PyErr_NoMemory();
    if (!allocated || call_simple(light->context, find_fluence, &w) != 0) {
        free(w.fluence);
        free(w.uncollided);
        free(w.flux);
        return NULL;
    }
    return Py_BuildValue("(NNN)", field_array(&w, w.fluence, 1), field_array(&w, w.uncollided, 1),
                         field_array(&w, w.flux, 2));
}

static ty_result find_radiance(void* user) {
    field_work* w = user;
    if (w->kind == DOM) return ty_dom_radiance(w->light, w->rays, w->count, w->radiance);
    if (w->kind == POP) return ty_pop_radiance(w->light, w->rays, w->count, w->radiance);
    return ty_path_radiance(w->scene, &w->path, w->rays, w->count, w->radiance, w->ray_variance);
}

static PyObject* ray_array(const field_work* w, double* data) {
    const Py_ssize_t shape[2] = {(Py_ssize_t)w->count, 3};
    if (data == NULL) Py_RETURN_NONE;
    return array_own(data, 'd', 2, shape);
}

/* Radiance along rays, for light and scene; with_variance by path tracing. */
static PyObject* radiance_along(call* running, PyObject* rays, field_work* w, bool with_variance) {
    Py_ssize_t count = 0;
    double* numbers = doubles_from(rays, "rays", 6, &count);
    if (numbers == NULL) return NULL;
    w->rays = numbers;
    w->count = count;
    w->radiance = calloc(3 * (size_t)count, sizeof(double));
    if (with_variance) w->ray_variance = calloc(3 * (size_t)count, sizeof(double));
    int status = -1;
    if (w->radiance == NULL || (with_variance && w->ray_variance == NULL)) {
        PyErr_NoMemory();
    } else {
        call_run(running);
        status = call_raise(running, NULL);
    }
    free(numbers);
    if (status == 0) return Py_BuildValue("(NN)", ray_array(w, w->radiance), ray_array(w, w->ray_variance));
    free(w->radiance);
    free(w->ray_variance);
    return NULL;
}

static PyObject* radiance(PyObject* self, PyObject* arguments) {
    light_object* light = (light_object*)self;
    PyObject* rays;
    field_work w = {.kind = light->solver, .light = light->light};
    if (!PyArg_ParseTuple(arguments, "O", &rays)) return NULL;
    if (w.kind != DOM && w.kind != POP) return raise_argument("radiance is of dom, pop and path");
    call running = {.context = light->context, .work = find_radiance, .user = &w};
    return radiance_along(&running, rays, &w, false);
}

static PyObject* gradient(PyObject* self, PyObject* arguments) {
    light_object* light = (light_object*)self;
    if (light->solver == DOM) return light_gradient(NULL, light->light, arguments);
    if (light->solver != FLD) return raise_argument("gradients are of fld and dom, not of %s", names[light->solver]);
    return light_gradient(light->light, NULL, arguments);
}

/* ---- the same by path tracing ---- */

static int start_path(const ty_scene* scene, scene_object* object, int spp, unsigned long long seed, call* running,
                      field_work* w) {
    w->kind = SOLVERS;
    w->scene = scene;
    w->path = ty_default_path_def();
    const ty_result result = ty_method_options(scene, "path", &w->path);
    w->path.spp = spp;
    w->path.seed = seed;
    w->path.progress = call_progress;
    w->path.progress_user = running;
    if (result == TY_OK) return 0;
    raise_result(result, ty_take_error(object->context->context));
    return -1;
}

PyObject* scene_fluence(PyObject* self, PyObject* arguments) {
    scene_object* scene = (scene_object*)self;
    PyObject *lower, *upper, *size, *progress;
    int spp;
    unsigned long long seed;
    field_work w = {.kind = SOLVERS};
    if (!PyArg_ParseTuple(arguments, "OOOiKO", &lower, &upper, &size, &spp, &seed, &progress) ||
        read_box(lower, upper, size, &w) != 0)
        return NULL;
    call running = {
        .context = scene->context, .work = find_fluence, .user = &w, .progress = callable_or_null(progress)};
    const size_t numbers = 3 * cells_of(&w);
    w.fluence = calloc(numbers, sizeof(double));
    w.uncollided = calloc(numbers, sizeof(double));
    w.variance = calloc(numbers, sizeof(double));
    int status = -1;
    const ty_scene* content = NULL;
    if (w.fluence == NULL || w.uncollided == NULL || w.variance == NULL)
        PyErr_NoMemory();
    else
        content = scene_begin(scene);
    if (content != NULL) {
        status = start_path(content, scene, spp, seed, &running, &w);
        if (status == 0) call_run(&running);
        scene_end(scene);
        if (status == 0) status = call_raise(&running, NULL);
    }
    if (status == 0)
        return Py_BuildValue("(NNN)", field_array(&w, w.fluence, 1), field_array(&w, w.uncollided, 1),
                             field_array(&w, w.variance, 1));
    free(w.fluence);
    free(w.uncollided);
    free(w.variance);
    return NULL;
}

PyObject* scene_radiance(PyObject* self, PyObject* arguments) {
    scene_object* scene = (scene_object*)self;
    PyObject *rays, *progress, *answer = NULL;
    int spp;
    unsigned long long seed;
    field_work w = {.kind = SOLVERS};
    if (!PyArg_ParseTuple(arguments, "OiKO", &rays, &spp, &seed, &progress)) return NULL;
    call running = {
        .context = scene->context, .work = find_radiance, .user = &w, .progress = callable_or_null(progress)};
    const ty_scene* content = scene_begin(scene);
    if (content == NULL) return NULL;
    if (start_path(content, scene, spp, seed, &running, &w) == 0) answer = radiance_along(&running, rays, &w, true);
    scene_end(scene);
    return answer;
}

static ty_result find_transmittance(void* user) {
    field_work* w = user;
    return ty_path_transmittance(w->scene, &w->path, w->lower, w->upper, w->transmittance);
}

PyObject* scene_transmittance(PyObject* self, PyObject* arguments) {
    scene_object* scene = (scene_object*)self;
    PyObject *start, *end, *answer = NULL;
    int spp;
    unsigned long long seed;
    field_work w = {.kind = SOLVERS};
    if (!PyArg_ParseTuple(arguments, "OOiK", &start, &end, &spp, &seed) ||
        doubles_of(start, "start", 3, w.lower) != 0 || doubles_of(end, "end", 3, w.upper) != 0)
        return NULL;
    call running = {.context = scene->context, .work = find_transmittance, .user = &w};
    const ty_scene* content = scene_begin(scene);
    if (content == NULL) return NULL;
    if (start_path(content, scene, spp, seed, &running, &w) == 0) {
        call_run(&running);
        if (call_raise(&running, NULL) == 0) answer = tuple_of_doubles(w.transmittance, 3);
    }
    scene_end(scene);
    return answer;
}

/* ---- the type ---- */

static PyObject* get_method(PyObject* self, void* closure) {
    (void)closure;
    return PyUnicode_FromString(names[((light_object*)self)->solver]);
}

static PyGetSetDef properties[] = {{"method", get_method, NULL, "Name of the method.", NULL},
                                   {NULL, NULL, NULL, NULL, NULL}};

static PyMethodDef methods[] = {
    {"view", view, METH_VARARGS, "view(scene, size, spp, seed, aovs, progress)\n--\n\nAn image."},
    {"fluence", fluence, METH_VARARGS, "fluence(lower, upper, size)\n--\n\n(fluence, uncollided, flux)."},
    {"gradient", gradient, METH_VARARGS,
     "gradient(scene, lower, upper, size, weights, progress)\n--\n\n(stats, box, coefficients, lights, media)."},
    {"radiance", radiance, METH_VARARGS, "radiance(rays)\n--\n\n(radiance, None)."},
    {NULL, NULL, 0, NULL}};

static PyType_Slot slots[] = {{Py_tp_doc, "Light in the media of a scene, solved once."},
                              {Py_tp_dealloc, destroy},
                              {Py_tp_methods, methods},
                              {Py_tp_getset, properties},
                              {0, NULL}};

static PyType_Spec spec = {"tyndall._core.Light", sizeof(light_object), 0,
                           Py_TPFLAGS_DEFAULT | Py_TPFLAGS_DISALLOW_INSTANTIATION, slots};

int add_light_type(PyObject* module) {
    return add_type(module, &spec, &light_type);
}
