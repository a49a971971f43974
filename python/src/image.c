/* Images. */
#include "module.h"

#include <stdlib.h>
#include <string.h>

PyTypeObject* image_type;

PyObject* wrap_image(context_object* context, ty_image* image) {
    image_object* self = new_object(image_type);
    if (self == NULL) {
        ty_image_destroy(image);
        return NULL;
    }
    Py_INCREF((PyObject*)context);
    self->context = context;
    self->image = image;
    return (PyObject*)self;
}

static void destroy(PyObject* self) {
    image_object* image = (image_object*)self;
    ty_image_destroy(image->image);
    Py_XDECREF((PyObject*)image->context);
    free_object(self);
}

static ty_image* image_of(PyObject* self) {
    return ((image_object*)self)->image;
}

/* ---- attributes ---- */

static PyObject* get_width(PyObject* self, void* closure) {
    (void)closure;
    return PyLong_FromLong(ty_image_width(image_of(self)));
}

static PyObject* get_height(PyObject* self, void* closure) {
    (void)closure;
    return PyLong_FromLong(ty_image_height(image_of(self)));
}

static PyObject* get_channels(PyObject* self, void* closure) {
    const ty_image* image = image_of(self);
    const int32_t count = ty_image_channel_count(image);
    (void)closure;
    PyObject* names = PyTuple_New(count);
    for (int32_t i = 0; names != NULL && i < count; ++i) {
        PyObject* name = PyUnicode_FromString(ty_image_channel_name(image, i));
        if (name == NULL || PyTuple_SetItem(names, i, name) != 0) {
            Py_DECREF(names);
            return NULL;
        }
    }
    return names;
}

static PyObject* get_frame(PyObject* self, void* closure) {
    int32_t frame[4];
    (void)closure;
    ty_image_get_frame(image_of(self), frame);
    return tuple_of_ints(frame, 4);
}

static PyObject* get_metadata(PyObject* self, void* closure) {
    const ty_image* image = image_of(self);
    (void)closure;
    PyObject* dict = PyDict_New();
    for (int32_t i = 0; dict != NULL && i < ty_image_metadata_count(image); ++i) {
        const char* key = ty_image_metadata_key(image, i);
        const char* text = ty_image_get_metadata(image, key);
        PyObject* value = PyUnicode_DecodeUTF8(text, (Py_ssize_t)strlen(text), "replace");
        if (value != NULL && ty_image_metadata_is_number(image, i)) {
            PyObject* number = PyFloat_FromString(value);
            Py_DECREF(value);
            value = number;
        }
        if (put(dict, key, value) != 0) {
            Py_DECREF(dict);
            return NULL;
        }
    }
    return dict;
}

static PyGetSetDef properties[] = {{"width", get_width, NULL, "Pixels in a row.", NULL},
                                   {"height", get_height, NULL, "Number of rows.", NULL},
                                   {"channels", get_channels, NULL, "Names of the channels.", NULL},
                                   {"frame", get_frame, NULL, "x, y, width and height of the frame.", NULL},
                                   {"metadata", get_metadata, NULL, "A copy of the metadata.", NULL},
                                   {NULL, NULL, NULL, NULL, NULL}};

/* ---- pixels ---- */

static PyObject* channel(PyObject* self, PyObject* arguments) {
    const char* name;
    if (!PyArg_ParseTuple(arguments, "s", &name)) return NULL;
    ty_image* image = image_of(self);
    const int32_t index = ty_image_find_channel(image, name);
    if (index < 0) {
        PyErr_Format(PyExc_KeyError, "%s", name);
        return NULL;
    }
    const Py_ssize_t shape[2] = {ty_image_height(image), ty_image_width(image)};
    return array_view(self, ty_image_plane(image, index), 'f', 2, shape, NULL);
}

/* Three channels as one array, if their planes are equally far from one another; else None. */
static PyObject* colors(PyObject* self, PyObject* arguments) {
    ty_image* image = image_of(self);
    const char* channels[3];
    const float* planes[3];
    if (!PyArg_ParseTuple(arguments, "sss", &channels[0], &channels[1], &channels[2])) return NULL;
    for (int c = 0; c < 3; ++c) {
        const int32_t index = ty_image_find_channel(image, channels[c]);
        if (index < 0) return PyErr_Format(PyExc_KeyError, "%s", channels[c]);
        planes[c] = ty_image_plane(image, index);
    }
    if (planes[1] - planes[0] != planes[2] - planes[1]) Py_RETURN_NONE;
    const Py_ssize_t shape[3] = {ty_image_height(image), ty_image_width(image), 3};
    const Py_ssize_t strides[3] = {shape[1] * (Py_ssize_t)sizeof(float), sizeof(float),
                                   (Py_ssize_t)(planes[1] - planes[0]) * (Py_ssize_t)sizeof(float)};
    return array_view(self, (void*)planes[0], 'f', 3, shape, strides);
}

static PyObject* set_metadata(PyObject* self, PyObject* arguments) {
    const char *key, *text = NULL;
    PyObject* value;
    double number = 0;
    if (!PyArg_ParseTuple(arguments, "sO", &key, &value)) return NULL;
    if (PyUnicode_Check(value)) {
        text = PyUnicode_AsUTF8AndSize(value, NULL);
        if (text == NULL) return NULL;
    } else {
        number = PyFloat_AsDouble(value);
        if (number == -1 && PyErr_Occurred() != NULL) return NULL;
    }
    ty_image* image = image_of(self);
    const ty_result result =
        text != NULL ? ty_image_set_text(image, key, text) : ty_image_set_number(image, key, number);
    if (result != TY_OK) return raise_result(result, ty_take_error(((image_object*)self)->context->context));
    Py_RETURN_NONE;
}

static PyObject* set_frame(PyObject* self, PyObject* arguments) {
    int x, y, width, height;
    if (!PyArg_ParseTuple(arguments, "iiii", &x, &y, &width, &height)) return NULL;
    const ty_result result = ty_image_set_frame(image_of(self), x, y, width, height);
    if (result != TY_OK) return raise_result(result, ty_take_error(((image_object*)self)->context->context));
    Py_RETURN_NONE;
}

/* ---- files and other images ---- */

typedef struct image_work {
    ty_context* context;
    const ty_image* image;
    const ty_image* second;
    ty_image* out;
    const char* text; /* a path, or the name of a layer */
    double number;
    int32_t index;
    ty_tone_curve curve;
    uint8_t* bytes;
    ty_difference difference;
} image_work;

static ty_result write_exr_work(void* user) {
    image_work* w = user;
    return ty_image_write_exr(w->context, w->image, w->text);
}

static ty_result write_png_work(void* user) {
    image_work* w = user;
    return ty_image_write_png(w->context, w->image, w->number, w->curve, w->text);
}

static ty_result write_png16_work(void* user) {
    image_work* w = user;
    return ty_image_write_png16(w->context, w->image, w->index, w->number, w->text);
}

static ty_result tonemap_work(void* user) {
    image_work* w = user;
    return ty_image_tonemap(w->context, w->image, w->number, w->curve, w->bytes);
}

static ty_result compare_work(void* user) {
    image_work* w = user;
    return ty_image_compare(w->context, w->image, w->second, w->index, &w->difference);
}

static ty_result layer_work(void* user) {
    image_work* w = user;
    return ty_image_create_layer(w->context, w->image, w->text, &w->out);
}

static ty_result full_frame_work(void* user) {
    image_work* w = user;
    return ty_image_create_full_frame(w->context, w->image, &w->out);
}

static ty_result read_work(void* user) {
    image_work* w = user;
    if (w->index == 1) return ty_image_read_raw(w->context, w->text, &w->out);
    return ty_image_read(w->context, w->text, &w->out);
}

static image_work start_work(PyObject* self) {
    image_object* image = (image_object*)self;
    return (image_work){.context = image->context->context, .image = image->image};
}

static PyObject* done(PyObject* self, ty_result (*function)(void* user), image_work* w) {
    if (call_simple(((image_object*)self)->context, function, w) != 0) return NULL;
    Py_RETURN_NONE;
}

static PyObject* write_exr(PyObject* self, PyObject* arguments) {
    image_work w = start_work(self);
    if (!PyArg_ParseTuple(arguments, "s", &w.text)) return NULL;
    return done(self, write_exr_work, &w);
}

static PyObject* write_png(PyObject* self, PyObject* arguments) {
    image_work w = start_work(self);
    int curve;
    if (!PyArg_ParseTuple(arguments, "sdi", &w.text, &w.number, &curve)) return NULL;
    w.curve = (ty_tone_curve)curve;
    return done(self, write_png_work, &w);
}

static PyObject* write_png16(PyObject* self, PyObject* arguments) {
    image_work w = start_work(self);
    const char* name;
    if (!PyArg_ParseTuple(arguments, "ssd", &w.text, &name, &w.number)) return NULL;
    w.index = ty_image_find_channel(w.image, name);
    if (w.index < 0) return PyErr_Format(PyExc_KeyError, "%s", name);
    return done(self, write_png16_work, &w);
}

static PyObject* tonemap(PyObject* self, PyObject* arguments) {
    image_work w = start_work(self);
    int curve;
    if (!PyArg_ParseTuple(arguments, "di", &w.number, &curve)) return NULL;
    w.curve = (ty_tone_curve)curve;
    const Py_ssize_t size = (Py_ssize_t)ty_image_width(w.image) * ty_image_height(w.image) * 3;
    w.bytes = malloc((size_t)size);
    if (w.bytes == NULL) return PyErr_NoMemory();
    PyObject* bytes = call_simple(((image_object*)self)->context, tonemap_work, &w) == 0
                          ? PyBytes_FromStringAndSize((const char*)w.bytes, size)
                          : NULL;
    free(w.bytes);
    return bytes;
}

static PyObject* made(PyObject* self, ty_result (*function)(void* user), image_work* w) {
    context_object* context = ((image_object*)self)->context;
    if (call_simple(context, function, w) == 0) return wrap_image(context, w->out);
    ty_image_destroy(w->out);
    return NULL;
}

static PyObject* layer(PyObject* self, PyObject* arguments) {
    image_work w = start_work(self);
    if (!PyArg_ParseTuple(arguments, "s", &w.text)) return NULL;
    return made(self, layer_work, &w);
}

static PyObject* full_frame(PyObject* self, PyObject* none) {
    image_work w = start_work(self);
    (void)none;
    return made(self, full_frame_work, &w);
}

static PyObject* compare(PyObject* self, PyObject* arguments) {
    image_work w = start_work(self);
    PyObject* second;
    int block;
    if (!PyArg_ParseTuple(arguments, "O!i", image_type, &second, &block)) return NULL;
    w.second = image_of(second);
    w.index = block;
    if (call_simple(((image_object*)self)->context, compare_work, &w) != 0) return NULL;
    const ty_difference* d = &w.difference;
    PyObject* dict = PyDict_New();
    if (dict == NULL) return NULL;
    if (put(dict, "mean_ratio", tuple_of_doubles(d->mean_ratio, 4)) != 0 ||
        put(dict, "rmse", tuple_of_doubles(d->rmse, 4)) != 0 ||
        put(dict, "relative_rmse", tuple_of_doubles(d->relative_rmse, 4)) != 0 ||
        put(dict, "rel_mse", tuple_of_doubles(d->rel_mse, 4)) != 0 ||
        put(dict, "not_finite", PyLong_FromLongLong(d->not_finite)) != 0 ||
        put(dict, "differing", PyLong_FromLongLong(d->differing)) != 0) {
        Py_DECREF(dict);
        return NULL;
    }
    return dict;
}

static PyMethodDef methods[] = {
    {"channel", channel, METH_VARARGS, "channel(name)\n--\n\nThe plane of a channel, (height, width) float32."},
    {"colors", colors, METH_VARARGS, "colors(r, g, b)\n--\n\nThree channels, (height, width, 3) float32, or None."},
    {"set_metadata", set_metadata, METH_VARARGS, "set_metadata(key, value)\n--\n\nSets a text or a number."},
    {"set_frame", set_frame, METH_VARARGS, "set_frame(x, y, width, height)\n--\n\nPlaces the pixels in a frame."},
    {"write_exr", write_exr, METH_VARARGS, "write_exr(path)\n--\n\nWrites an OpenEXR file."},
    {"write_png", write_png, METH_VARARGS, "write_png(path, exposure, curve)\n--\n\nWrites an 8-bit sRGB file."},
    {"write_png16", write_png16, METH_VARARGS, "write_png16(path, channel, scale)\n--\n\nWrites a channel."},
    {"tonemap", tonemap, METH_VARARGS, "tonemap(exposure, curve)\n--\n\nsRGB, 3 bytes a pixel."},
    {"layer", layer, METH_VARARGS, "layer(name)\n--\n\nAn image of one layer."},
    {"full_frame", full_frame, METH_NOARGS, "full_frame()\n--\n\nA copy that fills the frame."},
    {"compare", compare, METH_VARARGS, "compare(reference, block)\n--\n\nThe difference from a reference."},
    {NULL, NULL, 0, NULL}};

static PyType_Slot slots[] = {{Py_tp_doc, "An image of named float planes."},
                              {Py_tp_dealloc, destroy},
                              {Py_tp_methods, methods},
                              {Py_tp_getset, properties},
                              {0, NULL}};

static PyType_Spec spec = {"tyndall._core.Image", sizeof(image_object), 0,
                           Py_TPFLAGS_DEFAULT | Py_TPFLAGS_DISALLOW_INSTANTIATION, slots};

int add_image_type(PyObject* module) {
    return add_type(module, &spec, &image_type);
}

/* ---- functions ---- */

static PyObject* image_create(PyObject* module, PyObject* arguments) {
    enum { CHANNELS_MAX = 1024 };
    context_object* context;
    PyObject* names;
    int width, height;
    const char* texts[CHANNELS_MAX];
    (void)module;
    if (!PyArg_ParseTuple(arguments, "O!iiO!", context_type, &context, &width, &height, &PyTuple_Type, &names))
        return NULL;
    const Py_ssize_t count = PyTuple_Size(names);
    if (count > CHANNELS_MAX) return raise_argument("an image has %zd channels, more than %d", count, CHANNELS_MAX);
    for (Py_ssize_t i = 0; i < count; ++i) {
        texts[i] = PyUnicode_AsUTF8AndSize(PyTuple_GetItem(names, i), NULL);
        if (texts[i] == NULL) return NULL;
    }
    ty_image* image = NULL;
    const ty_result result = ty_image_create(context->context, width, height, (int32_t)count, texts, &image);
    if (result != TY_OK) return raise_result(result, ty_take_error(context->context));
    return wrap_image(context, image);
}

static PyObject* image_read(PyObject* module, PyObject* arguments) {
    context_object* context;
    image_work w = {.index = 0};
    int raw;
    (void)module;
    if (!PyArg_ParseTuple(arguments, "O!sp", context_type, &context, &w.text, &raw)) return NULL;
    w.context = context->context;
    w.index = raw;
    if (call_simple(context, read_work, &w) == 0) return wrap_image(context, w.out);
    ty_image_destroy(w.out);
    return NULL;
}

PyMethodDef image_functions[] = {
    {"image_create", image_create, METH_VARARGS,
     "image_create(context, width, height, names)\n--\n\nAn image of zeros."},
    {"image_read", image_read, METH_VARARGS, "image_read(context, path, raw)\n--\n\nReads an image file."},
    {NULL, NULL, 0, NULL}};
