/* The module: its types, functions and contexts. */
#include "module.h"

#include <stdlib.h>
#include <string.h>

PyTypeObject* context_type;

/* ---- objects ---- */

void* new_object(PyTypeObject* type) {
    return PyType_GenericAlloc(type, 0);
}

void free_object(PyObject* self) {
    PyTypeObject* type = Py_TYPE(self);
    PyObject_Free(self);
    Py_DECREF(type);
}

int add_type(PyObject* module, PyType_Spec* spec, PyTypeObject** out) {
    PyObject* type = PyType_FromSpec(spec);
    if (type == NULL) return -1;
    *out = (PyTypeObject*)type;
    return PyModule_AddObjectRef(module, strrchr(spec->name, '.') + 1, type);
}

/* ---- values ---- */

static int check_sequence(PyObject* sequence, const char* what, int count) {
    if (PySequence_Check(sequence) && PySequence_Size(sequence) == count) return 0;
    PyErr_Clear();
    raise_argument("%s: expected %d numbers", what, count);
    return -1;
}

int doubles_of(PyObject* sequence, const char* what, int count, double* out) {
    if (check_sequence(sequence, what, count) != 0) return -1;
    for (int i = 0; i < count; ++i) {
        PyObject* item = PySequence_GetItem(sequence, i);
        out[i] = item != NULL ? PyFloat_AsDouble(item) : -1;
        Py_XDECREF(item);
        if (out[i] == -1 && PyErr_Occurred() != NULL) return -1;
    }
    return 0;
}

int ints_of(PyObject* sequence, const char* what, int count, int32_t* out) {
    if (check_sequence(sequence, what, count) != 0) return -1;
    for (int i = 0; i < count; ++i) {
        PyObject* item = PySequence_GetItem(sequence, i);
        PyObject* index = item != NULL ? PyNumber_Index(item) : NULL;
        const long value = index != NULL ? PyLong_AsLong(index) : -1;
        Py_XDECREF(item);
        Py_XDECREF(index);
        if (value == -1 && PyErr_Occurred() != NULL) return -1;
        if (value < INT32_MIN || value > INT32_MAX) {
            raise_argument("%s: %ld is too large", what, value);
            return -1;
        }
        out[i] = (int32_t)value;
    }
    return 0;
}

PyObject* tuple_of_doubles(const double* values, Py_ssize_t count) {
    PyObject* tuple = PyTuple_New(count);
    for (Py_ssize_t i = 0; tuple != NULL && i < count; ++i) {
        PyObject* value = PyFloat_FromDouble(values[i]);
        if (value == NULL || PyTuple_SetItem(tuple, i, value) != 0) {
            Py_DECREF(tuple);
            return NULL;
        }
    }
    return tuple;
}

PyObject* tuple_of_floats(const float* values, Py_ssize_t count) {
    double wide[16] = {0};
    for (Py_ssize_t i = 0; i < count && i < 16; ++i) wide[i] = values[i];
    return tuple_of_doubles(wide, count);
}

PyObject* tuple_of_ints(const int32_t* values, Py_ssize_t count) {
    PyObject* tuple = PyTuple_New(count);
    for (Py_ssize_t i = 0; tuple != NULL && i < count; ++i) {
        PyObject* value = PyLong_FromLong(values[i]);
        if (value == NULL || PyTuple_SetItem(tuple, i, value) != 0) {
            Py_DECREF(tuple);
            return NULL;
        }
    }
    return tuple;
}

int put(PyObject* dict, const char* key, PyObject* value) {
    const int status = value != NULL ? PyDict_SetItemString(dict, key, value) : -1;
    Py_XDECREF(value);
    return status;
}

/* ---- contexts ---- */

static PyObject* create_context(PyTypeObject* type, PyObject* arguments, PyObject* keywords) {
    static char* names[] = {"threads", "device", NULL};
    int threads = TY_AUTO;
    const char* device = NULL;
    if (!PyArg_ParseTupleAndKeywords(arguments, keywords, "|iz", names, &threads, &device)) return NULL;
    context_object* self = new_object(type);
    if (self == NULL) return NULL;
    pthread_mutex_init(&self->lock, NULL);
    ty_context_def def = ty_default_context_def();
    def.threads = threads;
    def.device = device;
    def.log = context_log;
    def.log_user = self;
    const ty_result result = ty_context_create(&def, &self->context);
    if (result == TY_OK) return (PyObject*)self;
    raise_result(result, ty_take_error(NULL));
    Py_DECREF(self);
    return NULL;
}

static void destroy_context(PyObject* self) {
    context_object* context = (context_object*)self;
    ty_context_destroy(context->context);
    while (context->first != NULL) {
        log_line* line = context->first;
        context->first = line->next;
        free(line);
    }
    pthread_mutex_destroy(&context->lock);
    free_object(self);
}

static PyObject* get_threads(PyObject* self, void* closure) {
    (void)closure;
    return PyLong_FromLong(ty_context_threads(((context_object*)self)->context));
}

static PyGetSetDef context_properties[] = {{"threads", get_threads, NULL, "Number of threads of long work.", NULL},
                                           {NULL, NULL, NULL, NULL, NULL}};

static PyType_Slot context_slots[] = {
    {Py_tp_doc,
     "Context(threads=-1, device=None)\n--\n\nThe threads and the device that work is done with. threads: 1..1024, or "
     "-1: one per processor. device: \"cpu\", \"cuda:N\" or \"auto\" (docs/device.md)."},
    {Py_tp_new, create_context},
    {Py_tp_dealloc, destroy_context},
    {Py_tp_getset, context_properties},
    {0, NULL}};

static PyType_Spec context_spec = {"tyndall._core.Context", sizeof(context_object), 0, Py_TPFLAGS_DEFAULT,
                                   context_slots};

int add_context_type(PyObject* module) {
    return add_type(module, &context_spec, &context_type);
}

/* ---- the module ---- */

static struct PyModuleDef definition = {PyModuleDef_HEAD_INIT,
                                        "_core",
                                        "Tyndall's C API; the package tyndall is made of it.",
                                        -1,
                                        NULL,
                                        NULL,
                                        NULL,
                                        NULL,
                                        NULL};

static int fill(PyObject* module) {
    PyMethodDef* functions[] = {image_functions, volume_functions, tool_functions, fact_functions};
    for (size_t i = 0; i < sizeof functions / sizeof functions[0]; ++i)
        if (PyModule_AddFunctions(module, functions[i]) != 0) return -1;
    if (add_context_type(module) != 0 || add_array_type(module) != 0 || add_image_type(module) != 0) return -1;
    if (add_grid_type(module) != 0 || add_scene_type(module) != 0 || add_light_type(module) != 0) return -1;
    return PyModule_AddStringConstant(module, "version", ty_version());
}

PyMODINIT_FUNC PyInit__core(void);

PyMODINIT_FUNC PyInit__core(void) {
    if (load_errors() != 0) return NULL;
    PyObject* module = PyModule_Create(&definition);
    if (module != NULL && fill(module) != 0) {
        Py_DECREF(module);
        return NULL;
    }
    return module;
}
