/* Grids, and files of volumes and meshes. */
#include "module.h"

#include <stdlib.h>
#include <string.h>

PyTypeObject* grid_type;

PyObject* wrap_grid(context_object* context, ty_grid* grid) {
    grid_object* self = new_object(grid_type);
    if (self == NULL) {
        ty_grid_release(grid);
        return NULL;
    }
    Py_INCREF((PyObject*)context);
    self->context = context;
    self->grid = grid;
    return (PyObject*)self;
}

static void destroy(PyObject* self) {
    grid_object* grid = (grid_object*)self;
    ty_grid_release(grid->grid);
    Py_XDECREF((PyObject*)grid->context);
    free_object(self);
}

/* ---- grids of arrays ---- */

/* The end of a loan, on any thread, with or without the interpreter's lock. */
static void end_loan(void* user) {
    input* in = user;
    const PyGILState_STATE state = PyGILState_Ensure();
    input_close(in);
    PyGILState_Release(state);
    free(in);
}

typedef struct create_work {
    ty_context* context;
    ty_grid_def def;
    ty_grid* out;
} create_work;

static ty_result create(void* user) {
    create_work* w = user;
    return ty_grid_create(w->context, &w->def, &w->out);
}

/* Values that are lent as they are: float32 in C order. Others are converted; *converted is freed by the caller. */
static int lend_values(input* in, ty_grid_def* def, float** converted) {
    const bool aligned = (uintptr_t)in->data % sizeof(float) == 0;
    if (in->kind == 'f' && in->itemsize == 4 && aligned && input_is_contiguous(in)) {
        def->values = in->data;
        def->release = end_loan;
        def->release_user = in;
        return 0;
    }
    *converted = malloc((size_t)in->count * sizeof(float));
    if (*converted == NULL) {
        PyErr_NoMemory();
        return -1;
    }
    input_to_floats(in, *converted);
    def->values = *converted;
    return 0;
}

static PyObject* grid_from(context_object* context, input* in, PyObject* placement, double background) {
    create_work w = {.context = context->context, .def = ty_default_grid_def()};
    float* converted = NULL;
    PyObject* grid = NULL;
    bool lent = false;
    if (in->ndim != 3) {
        raise_argument("a volume has %d axes, not 3: z, y and x", in->ndim);
    } else if (placement == Py_None || doubles_of(placement, "placement", 12, w.def.index_to_local.m) == 0) {
        for (int a = 0; a < 3; ++a) w.def.size[a] = in->shape[2 - a] <= INT32_MAX ? (int32_t)in->shape[2 - a] : -1;
        w.def.placed = placement != Py_None;
        w.def.background = (float)background;
        if (lend_values(in, &w.def, &converted) == 0 && call_simple(context, create, &w) == 0) {
            lent = w.def.release != NULL;
            grid = wrap_grid(context, w.out);
        } else if (w.out != NULL) { /* an interrupt came after the grid */
            lent = w.def.release != NULL;
            ty_grid_release(w.out);
        }
    }
    free(converted);
    if (!lent) {
        input_close(in);
        free(in);
    }
    return grid;
}

static PyObject* grid_create(PyObject* module, PyObject* arguments) {
    context_object* context;
    PyObject *object, *placement;
    double background;
    (void)module;
    if (!PyArg_ParseTuple(arguments, "O!OOd", context_type, &context, &object, &placement, &background)) return NULL;
    input* in = malloc(sizeof *in);
    if (in == NULL) return PyErr_NoMemory();
    if (input_open(object, "volume", in) != 0) {
        free(in);
        return NULL;
    }
    return grid_from(context, in, placement, background);
}

/* ---- attributes ---- */

static const char* storage_name(ty_grid_storage storage) {
    return storage == TY_GRID_PAGED ? "paged" : storage == TY_GRID_SPARSE ? "sparse" : "dense";
}

static PyObject* get_info(PyObject* self, void* closure) {
    const ty_grid_info info = ty_grid_get_info(((grid_object*)self)->grid);
    (void)closure;
    return Py_BuildValue("{s:N,s:s,s:N,s:d,s:d,s:d,s:d,s:n,s:N,s:s,s:L}", "size", tuple_of_ints(info.size, 3), "type",
                         info.type == TY_GRID_F16 ? "float16" : "float32", "placed", PyBool_FromLong(info.placed),
                         "background", (double)info.background, "min", (double)info.min, "max", (double)info.max,
                         "mean", info.mean, "bytes", (Py_ssize_t)info.bytes, "placement",
                         tuple_of_doubles(info.index_to_local.m, 12), "storage", storage_name(info.storage), "active",
                         (long long)info.active);
}

typedef struct store_work {
    ty_context* context;
    ty_grid *grid, *out;
} store_work;

static ty_result make_dense(void* user) {
    store_work* w = user;
    return ty_grid_store(w->context, w->grid, TY_GRID_DENSE, &w->out);
}

/* A view of the values: those of a dense grid themselves, and of a sparse one those of a dense copy. */
static PyObject* get_values(PyObject* self, void* closure) {
    grid_object* grid = (grid_object*)self;
    store_work w = {.context = grid->context->context, .grid = grid->grid};
    (void)closure;
    if (call_simple(grid->context, make_dense, &w) != 0) {
        ty_grid_release(w.out);
        return NULL;
    }
    PyObject* owner = wrap_grid(grid->context, w.out);
    if (owner == NULL) return NULL;
    const ty_grid_info info = ty_grid_get_info(w.out);
    const Py_ssize_t shape[3] = {info.size[2], info.size[1], info.size[0]};
    PyObject* view = array_view_const(owner, ty_grid_values(w.out), info.type == TY_GRID_F16 ? 'e' : 'f', 3, shape);
    Py_DECREF(owner);
    return view;
}

static PyGetSetDef properties[] = {
    {"info", get_info, NULL, "Size, placement, range and memory.", NULL},
    {"values", get_values, NULL, "The values, (nz, ny, nx) float32 or float16, read-only.", NULL},
    {NULL, NULL, NULL, NULL, NULL}};

/* ---- files ---- */

typedef struct file_work {
    ty_context* context;
    const char *path, *name, *codec; /* codec: NULL: the format's first */
    ty_volume_def def;
    ty_grid* out;
    void* entries; /* ty_vdb_entry or ty_mesh_file_entry */
    int32_t capacity, count;
    ty_scene_info info;
} file_work;

static PyType_Slot slots[] = {{Py_tp_doc, "Values on a regular grid of voxels."},
                              {Py_tp_dealloc, destroy},
                              {Py_tp_getset, properties},
                              {0, NULL}};

static PyType_Spec spec = {"tyndall._core.Grid", sizeof(grid_object), 0,
                           Py_TPFLAGS_DEFAULT | Py_TPFLAGS_DISALLOW_INSTANTIATION, slots};

int add_grid_type(PyObject* module) {
    return add_type(module, &spec, &grid_type);
}

enum { FIELDS_MAX = 16 };

typedef struct write_work {
    ty_context* context;
    const char *path, *codec; /* codec: NULL: the format's first */
    ty_volume_field fields[FIELDS_MAX];
    int32_t count;
} write_work;

static ty_result write_volume(void* user) {
    write_work* w = user;
    return ty_volume_write(w->context, w->fields, w->count, w->codec, w->path);
}

/* One field of a tuple (name, (grid, ...)): 0, or -1 after an exception. */
static int read_field(PyObject* pair, ty_volume_field* field) {
    PyObject* grids;
    if (!PyArg_ParseTuple(pair, "sO!", &field->name, &PyTuple_Type, &grids)) return -1;
    field->components = (int32_t)PyTuple_Size(grids);
    for (int32_t c = 0; c < field->components && c < 3; ++c) {
        PyObject* grid = PyTuple_GetItem(grids, c);
        if (!PyObject_TypeCheck(grid, grid_type)) {
            raise_argument("%s: expected grids", field->name);
            return -1;
        }
        field->grids[c] = ((grid_object*)grid)->grid;
    }
    return 0;
}

static PyObject* volume_write(PyObject* module, PyObject* arguments) {
    context_object* context;
    PyObject* fields;
    write_work w = {.count = 0};
    (void)module;
    if (!PyArg_ParseTuple(arguments, "O!szO!", context_type, &context, &w.path, &w.codec, &PyTuple_Type, &fields))
        return NULL;
    w.context = context->context;
    w.count = (int32_t)PyTuple_Size(fields);
    if (w.count > FIELDS_MAX) return raise_argument("%s: more than %d fields", w.path, (int)FIELDS_MAX);
    for (int32_t i = 0; i < w.count; ++i)
        if (read_field(PyTuple_GetItem(fields, i), &w.fields[i]) != 0) return NULL;
    if (call_simple(context, write_volume, &w) != 0) return NULL;
    Py_RETURN_NONE;
}

static ty_result read_volume(void* user) {
    file_work* w = user;
    return ty_volume_read(w->context, w->path, &w->def, &w->out);
}

/* raw: None, or (size, type, big_endian, offset, spacing). */
static int read_raw(PyObject* raw, ty_volume_def* def) {
    PyObject *size, *spacing;
    const char* type;
    int big_endian;
    long long offset;
    if (raw == Py_None) return 0;
    if (!PyArg_ParseTuple(raw, "OspLO", &size, &type, &big_endian, &offset, &spacing)) return -1;
    if (ints_of(size, "raw size", 3, def->raw_size) != 0) return -1;
    if (doubles_of(spacing, "raw spacing", 3, def->raw_spacing) != 0) return -1;
    if (strlen(type) >= sizeof def->raw_type) {
        raise_argument("raw type: \"%.32s\" is none", type);
        return -1;
    }
    memcpy(def->raw_type, type, strlen(type) + 1);
    def->raw_big_endian = big_endian != 0;
    def->raw_offset = offset;
    return 0;
}

/* more: (series, (effective radius, its value), (air density, its value), metres per unit). */
static int read_more(PyObject* more, ty_volume_def* def) {
    return PyArg_ParseTuple(more, "s(zd)(zd)d", &def->series, &def->effective_radius, &def->droplet_radius,
                            &def->air_density, &def->air_density_value, &def->meters_per_unit)
               ? 0
               : -1;
}

static PyObject* volume_read(PyObject* module, PyObject* arguments) {
    context_object* context;
    PyObject *raw, *more;
    file_work w = {.def = ty_default_volume_def()};
    int component, frame;
    (void)module;
    if (!PyArg_ParseTuple(arguments, "O!sziiOO", context_type, &context, &w.path, &w.name, &component, &frame, &raw,
                          &more))
        return NULL;
    w.context = context->context;
    if (w.name != NULL) w.def.grid = w.name;
    w.def.exact_grid = w.name != NULL;
    w.def.component = component;
    w.def.frame = frame;
    if (read_raw(raw, &w.def) != 0 || read_more(more, &w.def) != 0) return NULL;
    if (call_simple(context, read_volume, &w) == 0) return wrap_grid(context, w.out);
    ty_grid_release(w.out);
    return NULL;
}

static ty_result list_volume(void* user) {
    file_work* w = user;
    return ty_volume_list(w->context, w->path, w->entries, w->capacity, &w->count);
}

static PyObject* vdb_entry(const ty_vdb_entry* entry) {
    return Py_BuildValue("{s:s,s:s,s:L,s:N,s:N,s:N}", "name", entry->name, "type", entry->type, "active_voxels",
                         (long long)entry->active_voxels, "lower", tuple_of_ints(entry->lower, 3), "upper",
                         tuple_of_ints(entry->upper, 3), "voxel_size", tuple_of_doubles(entry->voxel_size, 3));
}

static PyObject* mesh_entry(const ty_mesh_file_entry* entry) {
    if (entry->camera)
        return Py_BuildValue("{s:s,s:s,s:d}", "kind", "camera", "name", entry->name, "fov_y", entry->fov_y);
    return Py_BuildValue("{s:s,s:s,s:N,s:N,s:N}", "kind", "material", "name", entry->name, "albedo",
                         tuple_of_floats(entry->material.albedo, 3), "emission",
                         tuple_of_floats(entry->material.emission, 3), "glossy", PyBool_FromLong(entry->glossy));
}

static int append(PyObject* list, PyObject* item) {
    const int status = item != NULL ? PyList_Append(list, item) : -1;
    Py_XDECREF(item);
    return status;
}

/* Lists the entries of a file, again with room for all of them if there are many: 0, or -1 after an exception. They are
 * freed by free(). */
static int list_entries(context_object* context, ty_result (*function)(void* user), file_work* w, size_t size) {
    w->context = context->context;
    for (w->capacity = 64;; w->capacity = w->count) {
        free(w->entries);
        w->entries = calloc((size_t)w->capacity, size);
        if (w->entries == NULL) {
            PyErr_NoMemory();
            return -1;
        }
        if (call_simple(context, function, w) != 0) return -1;
        if (w->count <= w->capacity) return 0;
    }
}

static PyObject* volume_list(PyObject* module, PyObject* arguments) {
    context_object* context;
    file_work w = {.entries = NULL};
    (void)module;
    if (!PyArg_ParseTuple(arguments, "O!s", context_type, &context, &w.path)) return NULL;
    PyObject* list = list_entries(context, list_volume, &w, sizeof(ty_vdb_entry)) == 0 ? PyList_New(0) : NULL;
    const ty_vdb_entry* entries = w.entries;
    for (int32_t i = 0; list != NULL && i < w.count; ++i)
        if (append(list, vdb_entry(&entries[i])) != 0) {
            Py_DECREF(list);
            list = NULL;
        }
    free(w.entries);
    return list;
}

static ty_result list_mesh(void* user) {
    file_work* w = user;
    return ty_mesh_file_list(w->context, w->path, &w->info, w->entries, w->capacity, &w->count);
}

static PyObject* mesh_list(PyObject* module, PyObject* arguments) {
    context_object* context;
    file_work w = {.entries = NULL};
    (void)module;
    if (!PyArg_ParseTuple(arguments, "O!s", context_type, &context, &w.path)) return NULL;
    PyObject* list = list_entries(context, list_mesh, &w, sizeof(ty_mesh_file_entry)) == 0 ? PyList_New(0) : NULL;
    const ty_mesh_file_entry* entries = w.entries;
    for (int32_t i = 0; list != NULL && i < w.count; ++i)
        if (append(list, mesh_entry(&entries[i])) != 0) {
            Py_DECREF(list);
            list = NULL;
        }
    free(w.entries);
    if (list == NULL) return NULL;
    return Py_BuildValue("{s:i,s:L,s:i,s:N,s:N,s:N}", "meshes", (int)w.info.meshes, "triangles",
                         (long long)w.info.triangles, "lights", (int)w.info.lights, "lower",
                         tuple_of_doubles(w.info.lower, 3), "upper", tuple_of_doubles(w.info.upper, 3), "entries",
                         list);
}

PyMethodDef volume_functions[] = {
    {"grid_create", grid_create, METH_VARARGS,
     "grid_create(context, array, placement, background)\n--\n\nA grid of an array, (nz, ny, nx), which is borrowed if "
     "it is "
     "float32 in C order and all finite. placement: 12 numbers of a map from voxel indices to metres, or None."},
    {"volume_read", volume_read, METH_VARARGS,
     "volume_read(context, path, grid, component, frame, raw, more)\n--\n\nReads a volume file."},
    {"volume_write", volume_write, METH_VARARGS,
     "volume_write(context, path, codec, fields)\n--\n\nWrites fields, (name, (grid, ...)), to a volume file."},
    {"volume_list", volume_list, METH_VARARGS, "volume_list(context, path)\n--\n\nThe grids of a file."},
    {"mesh_list", mesh_list, METH_VARARGS, "mesh_list(context, path)\n--\n\nThe content of a mesh file."},
    {NULL, NULL, 0, NULL}};
