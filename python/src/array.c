/* Arrays for Python: memory of images, grids and results, by the buffer protocol and DLPack, without copies. */
#include "dlpack.h"
#include "module.h"

#include <stdlib.h>
#include <string.h>

PyTypeObject* array_type;

static Py_ssize_t size_of(char format) {
    return format == 'd' ? 8 : format == 'f' ? 4 : format == 'e' ? 2 : 1;
}

static PyObject* create(PyObject* owner, void* data, char format, int ndim, const Py_ssize_t* shape,
                        const Py_ssize_t* strides) {
    array_object* array = new_object(array_type);
    if (array == NULL) return NULL;
    Py_XINCREF(owner);
    array->owner = owner;
    array->data = data;
    array->format[0] = format;
    array->ndim = ndim;
    array->itemsize = size_of(format);
    Py_ssize_t stride = array->itemsize;
    for (int i = ndim - 1; i >= 0; --i) {
        array->shape[i] = shape[i];
        array->strides[i] = strides != NULL ? strides[i] : stride;
        stride *= shape[i];
        array->dl_shape[i] = (int64_t)shape[i];
        array->dl_strides[i] = (int64_t)(array->strides[i] / array->itemsize);
    }
    return (PyObject*)array;
}

PyObject* array_view(PyObject* owner, void* data, char format, int ndim, const Py_ssize_t* shape,
                     const Py_ssize_t* strides) {
    return create(owner, data, format, ndim, shape, strides);
}

PyObject* array_view_const(PyObject* owner, const void* data, char format, int ndim, const Py_ssize_t* shape) {
    PyObject* array = create(owner, (void*)data, format, ndim, shape, NULL);
    if (array != NULL) ((array_object*)array)->readonly = true;
    return array;
}

PyObject* array_own(void* data, char format, int ndim, const Py_ssize_t* shape) {
    if (data == NULL) return PyErr_NoMemory();
    PyObject* array = create(NULL, data, format, ndim, shape, NULL);
    if (array == NULL) free(data);
    return array;
}

static void destroy(PyObject* self) {
    array_object* array = (array_object*)self;
    if (array->owner == NULL) free(array->data);
    Py_XDECREF(array->owner);
    free_object(self);
}

/* ---- the buffer protocol ---- */

static bool is_contiguous(const array_object* array) {
    Py_ssize_t stride = array->itemsize;
    for (int i = array->ndim - 1; i >= 0; --i) {
        if (array->shape[i] > 1 && array->strides[i] != stride) return false;
        stride *= array->shape[i];
    }
    return true;
}

static Py_ssize_t byte_count(const array_object* array) {
    Py_ssize_t bytes = array->itemsize;
    for (int i = 0; i < array->ndim; ++i) bytes *= array->shape[i];
    return bytes;
}

static int get_buffer(PyObject* self, Py_buffer* view, int flags) {
    array_object* array = (array_object*)self;
    const bool contiguous = is_contiguous(array), wants_strides = (flags & PyBUF_STRIDES) == PyBUF_STRIDES;
    const bool wants_c = (flags & PyBUF_C_CONTIGUOUS) == PyBUF_C_CONTIGUOUS;
    const bool wants_f = (flags & PyBUF_F_CONTIGUOUS) == PyBUF_F_CONTIGUOUS && array->ndim > 1;
    const bool wants_any = (flags & PyBUF_ANY_CONTIGUOUS) == PyBUF_ANY_CONTIGUOUS;
    view->obj = NULL;
    if (((!wants_strides || wants_c || wants_any) && !contiguous) || wants_f) {
        PyErr_SetString(PyExc_BufferError, "the array is not contiguous in this order; its strides are needed");
        return -1;
    }
    if (array->readonly && (flags & PyBUF_WRITABLE) == PyBUF_WRITABLE) {
        PyErr_SetString(PyExc_BufferError, "the array is read-only");
        return -1;
    }
    Py_INCREF(self);
    view->obj = self;
    view->buf = array->data;
    view->len = byte_count(array);
    view->readonly = array->readonly;
    view->itemsize = array->itemsize;
    view->format = (flags & PyBUF_FORMAT) == PyBUF_FORMAT ? array->format : NULL;
    view->ndim = array->ndim;
    view->shape = (flags & PyBUF_ND) == PyBUF_ND ? array->shape : NULL;
    view->strides = wants_strides ? array->strides : NULL;
    view->suboffsets = NULL;
    view->internal = NULL;
    return 0;
}

/* ---- DLPack ---- */

/* Consumers may call it from any thread. */
static void release_tensor(DLManagedTensor* tensor) {
    const PyGILState_STATE state = PyGILState_Ensure();
    Py_DECREF((PyObject*)tensor->manager_ctx);
    free(tensor);
    PyGILState_Release(state);
}

/* A capsule that nobody consumed. */
static void release_capsule(PyObject* capsule) {
    if (!PyCapsule_IsValid(capsule, "dltensor")) return;
    DLManagedTensor* tensor = PyCapsule_GetPointer(capsule, "dltensor");
    tensor->deleter(tensor);
}

/* True for no device and for the host's memory. */
static bool is_host(PyObject* device) {
    int type = 0, number = 0;
    if (device == Py_None) return true;
    if (PyTuple_Check(device) && PyArg_ParseTuple(device, "ii", &type, &number)) return type == DL_CPU;
    PyErr_Clear();
    return false;
}

static PyObject* dlpack(PyObject* self, PyObject* arguments, PyObject* keywords) {
    static char* names[] = {"stream", "max_version", "dl_device", "copy", NULL};
    array_object* array = (array_object*)self;
    PyObject *stream, *version, *device = Py_None, *copy = Py_None; /* streams are for devices */
    if (!PyArg_ParseTupleAndKeywords(arguments, keywords, "|$OOOO", names, &stream, &version, &device, &copy))
        return NULL;
    const char* refusal = array->readonly    ? "the array is read-only, which DLPack cannot tell; copy it"
                          : !is_host(device) ? "the array is in the host's memory alone"
                          : copy == Py_True  ? "the array is not copied by DLPack; copy its view"
                                             : NULL;
    if (refusal != NULL) {
        PyErr_SetString(PyExc_BufferError, refusal);
        return NULL;
    }
    DLManagedTensor* tensor = calloc(1, sizeof *tensor);
    if (tensor == NULL) return PyErr_NoMemory();
    const char format = array->format[0];
    tensor->dl_tensor = (DLTensor){
        .data = array->data,
        .device = {.device_type = DL_CPU, .device_id = 0},
        .ndim = array->ndim,
        .dtype = {.code = format == 'B' ? DL_UINT : DL_FLOAT, .bits = (uint8_t)(8 * array->itemsize), .lanes = 1},
        .shape = array->dl_shape,
        .strides = array->dl_strides};
    tensor->manager_ctx = self;
    tensor->deleter = release_tensor;
    PyObject* capsule = PyCapsule_New(tensor, "dltensor", release_capsule);
    if (capsule == NULL)
        free(tensor);
    else
        Py_INCREF(self);
    return capsule;
}

static PyObject* dlpack_device(PyObject* self, PyObject* none) {
    (void)self, (void)none;
    return Py_BuildValue("(ii)", DL_CPU, 0);
}

/* ---- attributes ---- */

static PyObject* get_shape(PyObject* self, void* closure) {
    const array_object* array = (array_object*)self;
    (void)closure;
    PyObject* shape = PyTuple_New(array->ndim);
    for (int i = 0; shape != NULL && i < array->ndim; ++i) {
        PyObject* side = PyLong_FromSsize_t(array->shape[i]);
        if (side == NULL || PyTuple_SetItem(shape, i, side) != 0) {
            Py_DECREF(shape);
            return NULL;
        }
    }
    return shape;
}

static PyObject* get_format(PyObject* self, void* closure) {
    (void)closure;
    return PyUnicode_FromString(((array_object*)self)->format);
}

static PyObject* get_address(PyObject* self, void* closure) {
    (void)closure;
    return PyLong_FromVoidPtr(((array_object*)self)->data);
}

static Py_ssize_t length(PyObject* self) {
    return ((array_object*)self)->shape[0];
}

static PyMethodDef methods[] = {
    {"__dlpack__", (PyCFunction)(void (*)(void))dlpack, METH_VARARGS | METH_KEYWORDS,
     "__dlpack__(*, stream=None, max_version=None, dl_device=None, copy=None)\n--\n\nA DLPack capsule of the same "
     "memory."},
    {"__dlpack_device__", dlpack_device, METH_NOARGS, "__dlpack_device__()\n--\n\n(1, 0): the host's memory."},
    {NULL, NULL, 0, NULL}};

static PyGetSetDef properties[] = {{"shape", get_shape, NULL, "Length along each axis.", NULL},
                                   {"format", get_format, NULL, "Type of a value, as in the module struct.", NULL},
                                   {"address", get_address, NULL, "Address of the first value.", NULL},
                                   {NULL, NULL, NULL, NULL, NULL}};

static PyType_Slot slots[] = {
    {Py_tp_doc,
     "Memory as an array: numpy.asarray(array), memoryview(array) and torch.from_dlpack(array) view it without "
     "a copy, and keep alive what it belongs to."},
    {Py_bf_getbuffer, get_buffer},
    {Py_tp_dealloc, destroy},
    {Py_tp_methods, methods},
    {Py_tp_getset, properties},
    {Py_sq_length, length},
    {0, NULL}};

static PyType_Spec spec = {"tyndall._core.Array", sizeof(array_object), 0,
                           Py_TPFLAGS_DEFAULT | Py_TPFLAGS_DISALLOW_INSTANTIATION, slots};

int add_array_type(PyObject* module) {
    return add_type(module, &spec, &array_type);
}
