/* Arrays that Python gives: any object with the buffer protocol, or with DLPack on the host (torch). */
#include "dlpack.h"
#include "module.h"

#include <stdlib.h>
#include <string.h>

/* ---- opening ---- */

/* Kind and size of the values of a format of the module struct; false for others. */
static bool read_format(input* in) {
    const char* format = in->view.format != NULL ? in->view.format : "B";
    const int one = 1;
    const bool little = *(const char*)&one == 1;
    if (*format == '@' || *format == '=' || *format == (little ? '<' : '>')) ++format;
    if (format[0] == '\0' || format[1] != '\0') return false;
    in->itemsize = (int)in->view.itemsize;
    switch (*format) {
    case 'e':
    case 'f':
    case 'd': in->kind = 'f'; break;
    case 'b':
    case 'h':
    case 'i':
    case 'l':
    case 'q': in->kind = 'i'; break;
    case '?':
    case 'B':
    case 'H':
    case 'I':
    case 'L':
    case 'Q': in->kind = 'u'; break;
    default: return false;
    }
    return in->itemsize == 1 || in->itemsize == 2 || in->itemsize == 4 || in->itemsize == 8;
}

static int finish(input* in, const char* what) {
    /* Strides of 0 make arrays larger than memory. */
    const Py_ssize_t most = PTRDIFF_MAX / (Py_ssize_t)sizeof(double);
    bool fits = true;
    in->count = 1;
    for (int i = 0; i < in->ndim; ++i) {
        fits = fits && (in->shape[i] <= 0 || in->count <= most / in->shape[i]);
        if (fits) in->count *= in->shape[i];
    }
    if (fits && in->count > 0) return 0;
    input_close(in);
    raise_argument(fits ? "%s: the array is empty" : "%s: the array is too large", what);
    return -1;
}

static int open_buffer(PyObject* object, const char* what, input* in) {
    if (PyObject_GetBuffer(object, &in->view, PyBUF_STRIDES | PyBUF_FORMAT) != 0) return -1;
    in->data = in->view.buf;
    in->ndim = in->view.ndim;
    if (in->ndim < 1 || in->ndim > 8 || !read_format(in)) {
        const char* format = in->view.format != NULL ? in->view.format : "B";
        raise_argument("%s: arrays of %d axes and values \"%.16s\" are not taken; numbers of 1 to 8 axes are", what,
                       in->ndim, format);
        PyBuffer_Release(&in->view);
        return -1;
    }
    for (int i = 0; i < in->ndim; ++i) {
        in->shape[i] = in->view.shape[i];
        in->strides[i] = in->view.strides[i];
    }
    return finish(in, what);
}

static bool read_tensor(input* in, const DLTensor* tensor) {
    const int32_t device = tensor->device.device_type;
    if ((device != DL_CPU && device != DL_CUDA_HOST) || tensor->ndim < 1 || tensor->ndim > 8) return false;
    if (tensor->dtype.lanes != 1 || tensor->dtype.code > DL_FLOAT) return false;
    in->kind = tensor->dtype.code == DL_FLOAT ? 'f' : tensor->dtype.code == DL_INT ? 'i' : 'u';
    in->itemsize = tensor->dtype.bits / 8;
    if (in->itemsize != 1 && in->itemsize != 2 && in->itemsize != 4 && in->itemsize != 8) return false;
    if (in->kind == 'f' && in->itemsize == 1) return false;
    in->data = (const char*)tensor->data + tensor->byte_offset;
    in->ndim = tensor->ndim;
    Py_ssize_t stride = in->itemsize;
    for (int i = in->ndim - 1; i >= 0; --i) {
        in->shape[i] = (Py_ssize_t)tensor->shape[i];
        in->strides[i] = tensor->strides != NULL ? (Py_ssize_t)tensor->strides[i] * in->itemsize : stride;
        stride *= in->shape[i];
    }
    return true;
}

static int open_dlpack(PyObject* object, const char* what, input* in) {
    PyObject* capsule = PyObject_CallMethod(object, "__dlpack__", NULL);
    if (capsule == NULL) return -1;
    DLManagedTensor* tensor = PyCapsule_GetPointer(capsule, "dltensor");
    /* the name tells the capsule that its tensor is ours to release */
    if (tensor == NULL || PyCapsule_SetName(capsule, "used_dltensor") != 0) {
        Py_DECREF(capsule);
        return -1;
    }
    Py_DECREF(capsule);
    in->dlpack = tensor;
    if (read_tensor(in, &tensor->dl_tensor)) return finish(in, what);
    input_close(in);
    raise_argument("%s: tensors of the host with 1 to 8 axes of plain numbers are taken", what);
    return -1;
}

int input_open(PyObject* object, const char* what, input* in) {
    memset(in, 0, sizeof *in);
    if (PyObject_CheckBuffer(object)) return open_buffer(object, what, in);
    if (PyObject_HasAttrString(object, "__dlpack__")) return open_dlpack(object, what, in);
    raise_argument("%s: expected an array: an object with the buffer protocol or __dlpack__", what);
    return -1;
}

void input_close(input* in) {
    if (in->dlpack != NULL) {
        DLManagedTensor* tensor = in->dlpack;
        in->dlpack = NULL;
        if (tensor->deleter != NULL) tensor->deleter(tensor);
    } else if (in->view.obj != NULL) {
        PyBuffer_Release(&in->view);
    }
}

bool input_is_contiguous(const input* in) {
    Py_ssize_t stride = in->itemsize;
    for (int i = in->ndim - 1; i >= 0; --i) {
        if (in->shape[i] > 1 && in->strides[i] != stride) return false;
        stride *= in->shape[i];
    }
    return true;
}

/* ---- values ---- */

static double half_value(uint16_t bits) {
    const int exponent = bits >> 10 & 31, mantissa = bits & 1023;
    uint32_t wide = (uint32_t)(bits >> 15) << 31;
    if (exponent == 0) {
        const double value = mantissa / 16777216.0; /* 2^-24 */
        return wide != 0 ? -value : value;
    }
    wide |= (exponent == 31 ? 255u : (uint32_t)exponent + 112u) << 23 | (uint32_t)mantissa << 13;
    float value;
    memcpy(&value, &wide, sizeof value);
    return value;
}

static double float_value(const char* at, int itemsize) {
    float single;
    double value;
    uint16_t half;
    switch (itemsize) {
    case 2: memcpy(&half, at, sizeof half); return half_value(half);
    case 4: memcpy(&single, at, sizeof single); return single;
    default: memcpy(&value, at, sizeof value); return value;
    }
}

static double integer_value(const char* at, char kind, int itemsize) {
    uint8_t byte;
    uint16_t two;
    uint32_t four;
    uint64_t eight;
    const bool is_signed = kind == 'i';
    switch (itemsize) {
    case 1: memcpy(&byte, at, 1); return is_signed ? (double)(int8_t)byte : (double)byte;
    case 2: memcpy(&two, at, 2); return is_signed ? (double)(int16_t)two : (double)two;
    case 4: memcpy(&four, at, 4); return is_signed ? (double)(int32_t)four : (double)four;
    default: memcpy(&eight, at, 8); return is_signed ? (double)(int64_t)eight : (double)eight;
    }
}

static double value_at(const input* in, const char* at) {
    return in->kind == 'f' ? float_value(at, in->itemsize) : integer_value(at, in->kind, in->itemsize);
}

/* Steps the index of each axis to the next value in C order, and returns its address. */
static const char* next(const input* in, Py_ssize_t index[8], const char* at) {
    for (int i = in->ndim - 1; i >= 0; --i) {
        at += in->strides[i];
        if (++index[i] < in->shape[i]) return at;
        at -= in->strides[i] * in->shape[i];
        index[i] = 0;
    }
    return at;
}

void input_to_floats(const input* in, float* out) {
    Py_ssize_t index[8] = {0};
    const char* at = in->data;
    if (in->kind == 'f' && in->itemsize == 4 && input_is_contiguous(in)) {
        memcpy(out, at, (size_t)in->count * sizeof *out);
        return;
    }
    for (Py_ssize_t i = 0; i < in->count; ++i, at = next(in, index, at)) out[i] = (float)value_at(in, at);
}

void input_to_doubles(const input* in, double* out) {
    Py_ssize_t index[8] = {0};
    const char* at = in->data;
    for (Py_ssize_t i = 0; i < in->count; ++i, at = next(in, index, at)) out[i] = value_at(in, at);
}

static int check_count(const input* in, const char* what, Py_ssize_t multiple) {
    const Py_ssize_t last = in->shape[in->ndim - 1];
    if (last == multiple || (in->ndim == 1 && in->count % multiple == 0)) return 0;
    raise_argument("%s: the last axis has %zd values, not %zd", what, last, multiple);
    return -1;
}

float* floats_from(PyObject* object, const char* what, Py_ssize_t multiple, Py_ssize_t* count) {
    input in;
    float* out = NULL;
    if (input_open(object, what, &in) != 0) return NULL;
    if (check_count(&in, what, multiple) == 0) {
        out = malloc((size_t)in.count * sizeof *out);
        if (out != NULL) input_to_floats(&in, out);
        if (out == NULL) PyErr_NoMemory();
        *count = in.count / multiple;
    }
    input_close(&in);
    return out;
}

double* doubles_from(PyObject* object, const char* what, Py_ssize_t multiple, Py_ssize_t* count) {
    input in;
    double* out = NULL;
    if (input_open(object, what, &in) != 0) return NULL;
    if (check_count(&in, what, multiple) == 0) {
        out = malloc((size_t)in.count * sizeof *out);
        if (out != NULL) input_to_doubles(&in, out);
        if (out == NULL) PyErr_NoMemory();
        *count = in.count / multiple;
    }
    input_close(&in);
    return out;
}

/* Values as indices, or false for one that is none. */
static bool to_indices(const input* in, uint32_t* out) {
    Py_ssize_t index[8] = {0};
    const char* at = in->data;
    for (Py_ssize_t i = 0; i < in->count; ++i, at = next(in, index, at)) {
        const double value = value_at(in, at);
        if (!(value >= 0 && value <= 4294967295.0)) return false;
        out[i] = (uint32_t)value;
    }
    return true;
}

uint32_t* indices_from(PyObject* object, const char* what, Py_ssize_t multiple, Py_ssize_t* count) {
    input in;
    uint32_t* out = NULL;
    if (input_open(object, what, &in) != 0) return NULL;
    if (in.kind == 'f') {
        raise_argument("%s: expected integers", what);
    } else if (check_count(&in, what, multiple) == 0) {
        out = malloc((size_t)in.count * sizeof *out);
        if (out == NULL) PyErr_NoMemory();
        *count = in.count / multiple;
        if (out != NULL && !to_indices(&in, out)) {
            raise_argument("%s: an index is below 0 or above 2^32 - 1", what);
            free(out);
            out = NULL;
        }
    }
    input_close(&in);
    return out;
}
