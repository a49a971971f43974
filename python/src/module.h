/* The extension module tyndall._core: Tyndall's public C API as Python objects, over Python's limited API.
 *
 * Every object holds a reference to the context that it was made with. Long calls run in a thread of their own, while
 * the calling thread waits without the interpreter's lock, delivers progress and looks for signals (call.c). */
#ifndef TYNDALL_PYTHON_MODULE_H
#define TYNDALL_PYTHON_MODULE_H

#ifndef Py_LIMITED_API
#define Py_LIMITED_API 0x030b0000
#endif
#define PY_SSIZE_T_CLEAN
#include <Python.h>

#include <pthread.h>
#include <tyndall/tyndall.h>

/* ---- objects ---- */

typedef struct log_line {
    struct log_line* next;
    int level;
    char text[]; /* zero-terminated */
} log_line;

typedef struct context_object {
    PyObject_HEAD ty_context* context;
    pthread_mutex_t lock; /* of the lines */
    log_line *first, *last;
} context_object;

typedef struct image_object {
    PyObject_HEAD context_object* context;
    ty_image* image;
} image_object;

typedef struct grid_object {
    PyObject_HEAD context_object* context;
    ty_grid* grid;
} grid_object;

/* Memory of another object, or of its own, as an array for others to view. */
typedef struct array_object {
    PyObject_HEAD PyObject* owner; /* keeps data; NULL: data is freed with the array */
    void* data;
    char format[2]; /* of the struct module: "f", "d", "e", "B" */
    bool readonly;
    int ndim;
    Py_ssize_t itemsize, shape[4], strides[4]; /* strides in bytes */
    int64_t dl_shape[4], dl_strides[4];
} array_object;

typedef struct scene_object {
    PyObject_HEAD context_object* context;
    ty_scene_editor* editor;
    int32_t users;    /* calls that read the scene */
    int32_t edits;    /* calls that change it */
    PyObject* others; /* contexts of grids that it may hold; NULL: its own alone */
} scene_object;

typedef struct light_object light_object;

extern PyTypeObject *context_type, *image_type, *grid_type, *array_type, *scene_type, *light_type;

/* Create the types, and add them to the module: 0, or -1 after an exception. */
int add_context_type(PyObject* module);
int add_image_type(PyObject* module);
int add_grid_type(PyObject* module);
int add_array_type(PyObject* module);
int add_scene_type(PyObject* module);
int add_light_type(PyObject* module);
int add_type(PyObject* module, PyType_Spec* spec, PyTypeObject** out);

/* Functions of the module, ended by a NULL name. */
extern PyMethodDef image_functions[], volume_functions[], tool_functions[], fact_functions[];

/* An object of a type, its fields 0; NULL after an exception. */
void* new_object(PyTypeObject* type);
/* Frees an object whose fields have been released. */
void free_object(PyObject* self);

/* Take over content, also on failure. */
PyObject* wrap_image(context_object* context, ty_image* image);
PyObject* wrap_grid(context_object* context, ty_grid* grid);

/* ---- calls and errors (call.c) ---- */

/* Finds tyndall._errors: 0, or -1 after an exception. */
int load_errors(void);
/* Raises the exception of a result; returns NULL. */
PyObject* raise_result(ty_result result, const char* message);
/* Raises tyndall.ArgumentError; returns NULL. */
PyObject* raise_argument(const char* format, ...);
/* Passes lines of the log on to Python's logging; they wait where no call may run Python. */
void context_log(void* user, ty_log_level level, const char* text);
int drain_log(context_object* context);

typedef struct call {
    context_object* context;
    ty_result (*work)(void* user); /* must not touch Python */
    void* user;
    PyObject* progress;            /* called with (stage, fraction, seconds, remaining, done, total); NULL: none */
    PyObject* (*poll)(void* user); /* called as often, with the interpreter's lock: None, or an answer as of progress */
    ty_result result;
    char message[2048];
    PyObject *type, *value, *traceback; /* exception of a signal or of progress; NULL: none */
    bool stopped;                       /* progress returned False */
    /* between the two threads */
    pthread_mutex_t lock;
    pthread_cond_t wake;
    bool finished, cancelled, fresh;
    ty_progress now;
    char stage[64];
} call;

/* The ty_progress_fn of a call; user: the call. */
bool call_progress(void* user, const ty_progress* progress);
/* Runs running->work: its result, message and exception tell the outcome. */
void call_run(call* running);
/* Raises the exception of a call that failed or was interrupted; returns -1, or 0 if it succeeded. A call that was
 * stopped by its progress function has succeeded if it has a partial result. An exception of an interrupted call
 * receives the partial result, which may be NULL, as its attribute `image`. */
int call_raise(call* running, PyObject* partial);
/* function(user) in a thread of its own, without progress: 0, or -1 after an exception. */
int call_simple(context_object* context, ty_result (*function)(void* user), void* user);

/* ---- arrays from Python (input.c) ---- */

typedef struct input {
    Py_buffer view;
    void* dlpack; /* a DLManagedTensor; NULL: the view */
    const char* data;
    char kind; /* 'f' float, 'i' signed, 'u' unsigned */
    int itemsize, ndim;
    Py_ssize_t shape[8], strides[8]; /* bytes */
    Py_ssize_t count;
} input;

/* Opens an object with the buffer protocol, or with __dlpack__ on the host. `what` names it in messages. The input must
 * stay where it is. 0, or -1 after an exception. */
int input_open(PyObject* object, const char* what, input* in);
void input_close(input* in);
bool input_is_contiguous(const input* in);
/* Writes all values in C order. */
void input_to_floats(const input* in, float* out);
void input_to_doubles(const input* in, double* out);
/* Values of an array whose last axis has `multiple` of them, or of one axis with a multiple; freed by free(); NULL
 * after an exception. *count: the number of such groups. */
float* floats_from(PyObject* object, const char* what, Py_ssize_t multiple, Py_ssize_t* count);
double* doubles_from(PyObject* object, const char* what, Py_ssize_t multiple, Py_ssize_t* count);
uint32_t* indices_from(PyObject* object, const char* what, Py_ssize_t multiple, Py_ssize_t* count);

/* ---- arrays for Python (array.c) ---- */

/* An array over memory that owner keeps. Strides in bytes. */
PyObject* array_view(PyObject* owner, void* data, char format, int ndim, const Py_ssize_t* shape,
                     const Py_ssize_t* strides);
/* The same for memory that must not change. */
PyObject* array_view_const(PyObject* owner, const void* data, char format, int ndim, const Py_ssize_t* shape);
/* An array of memory from malloc, which is taken over, also on failure; in C order. */
PyObject* array_own(void* data, char format, int ndim, const Py_ssize_t* shape);

/* ---- values ---- */

/* Number of values in a tuple or list, stored: 0, or -1 after an exception. */
int doubles_of(PyObject* sequence, const char* what, int count, double* out);
int ints_of(PyObject* sequence, const char* what, int count, int32_t* out);
PyObject* tuple_of_doubles(const double* values, Py_ssize_t count);
PyObject* tuple_of_ints(const int32_t* values, Py_ssize_t count);
PyObject* tuple_of_floats(const float* values, Py_ssize_t count); /* count: 16 at most */
/* Sets a value of a dict and drops the caller's reference: 0, or -1 after an exception; value may be NULL. */
int put(PyObject* dict, const char* key, PyObject* value);
/* The callable, or NULL for None. */
static inline PyObject* callable_or_null(PyObject* object) {
    return object == Py_None ? NULL : object;
}

/* The committed scene of a call; NULL after an exception if it is being changed. scene_end follows. */
const ty_scene* scene_begin(scene_object* scene);
void scene_end(scene_object* scene);

/* Implementations of the scene's methods in other files. */
PyObject* scene_render(PyObject* self, PyObject* arguments);
PyObject* scene_choose(PyObject* self, PyObject* arguments);
PyObject* scene_solve(PyObject* self, PyObject* arguments);
PyObject* scene_fluence(PyObject* self, PyObject* arguments);
PyObject* scene_flux(PyObject* self, PyObject* arguments);
PyObject* scene_radiance(PyObject* self, PyObject* arguments);
PyObject* scene_transmittance(PyObject* self, PyObject* arguments);
PyObject* scene_bake_lightmap(PyObject* self, PyObject* arguments);
PyObject* scene_bake_vertices(PyObject* self, PyObject* arguments);
PyObject* scene_bake_probes(PyObject* self, PyObject* arguments);

/* (scene, lower, upper, size, weights, progress) -> (stats, box, (extinction, albedo, g), lights, media), for light of
 * fld or dom; the other one is NULL. */
PyObject* light_gradient(const ty_fld* fld, const ty_dom* dom, PyObject* arguments);

#endif
