/* Fluxes through levels, by columns of a scene. */
#include "module.h"

#include <stdlib.h>
#include <string.h>

typedef struct flux_work {
    const ty_scene* scene;
    ty_path_def path;
    ty_flux_def def;
    ty_flux* out;
    ty_path_stats stats;
} flux_work;

static ty_result find_flux(void* user) {
    flux_work* w = user;
    return ty_path_flux(w->scene, &w->path, &w->def, &w->out, &w->stats);
}

/* (levels or views, ny, nx, 3) of values or of their errors. */
static PyObject* quantity_array(const flux_work* w, ty_flux_quantity quantity, int32_t count, bool errors) {
    const size_t numbers = 3 * (size_t)w->def.columns[0] * (size_t)w->def.columns[1];
    const Py_ssize_t shape[4] = {count, w->def.columns[1], w->def.columns[0], 3};
    double* data = calloc(numbers * (size_t)count, sizeof(double));
    if (data == NULL) return PyErr_NoMemory();
    for (int32_t i = 0; i < count; ++i)
        memcpy(data + numbers * (size_t)i,
               errors ? ty_flux_errors(w->out, quantity, i) : ty_flux_values(w->out, quantity, i),
               numbers * sizeof(double));
    return array_own(data, 'd', 4, shape);
}

static PyObject* quantity_pair(const flux_work* w, ty_flux_quantity quantity) {
    const int32_t count = quantity == TY_FLUX_ABSORBED   ? 1
                          : quantity == TY_FLUX_RADIANCE ? w->def.view_count
                                                         : w->def.level_count;
    if (count == 0) Py_RETURN_NONE;
    return Py_BuildValue("(NN)", quantity_array(w, quantity, count, false), quantity_array(w, quantity, count, true));
}

static PyObject* make_parts(const flux_work* w) {
    return Py_BuildValue("(NNNNN)", quantity_pair(w, TY_FLUX_UP), quantity_pair(w, TY_FLUX_DOWN_DIFFUSE),
                         quantity_pair(w, TY_FLUX_DOWN_DIRECT), quantity_pair(w, TY_FLUX_ABSORBED),
                         quantity_pair(w, TY_FLUX_RADIANCE));
}

/* Box of all columns: None, or four numbers, lower and upper. */
static int read_area(PyObject* area, ty_flux_def* def) {
    double corners[4];
    if (area == Py_None) return 0;
    if (doubles_of(area, "area", 4, corners) != 0) return -1;
    memcpy(def->lower, corners, sizeof def->lower);
    memcpy(def->upper, corners + 2, sizeof def->upper);
    return 0;
}

PyObject* scene_flux(PyObject* self, PyObject* arguments) {
    scene_object* scene = (scene_object*)self;
    PyObject *levels, *views, *columns, *area, *progress, *answer = NULL;
    int spp;
    unsigned long long seed;
    Py_ssize_t level_count = 0, view_count = 0;
    flux_work w = {.def = ty_default_flux_def(), .path = ty_default_path_def(), .stats = ty_default_path_stats()};
    if (!PyArg_ParseTuple(arguments, "OOOOiKO", &levels, &views, &columns, &area, &spp, &seed, &progress) ||
        ints_of(columns, "columns", 2, w.def.columns) != 0 || read_area(area, &w.def) != 0)
        return NULL;
    double* heights = doubles_from(levels, "levels", 1, &level_count);
    double* directions = views != Py_None ? doubles_from(views, "views", 2, &view_count) : NULL;
    call running = {.context = scene->context, .work = find_flux, .user = &w, .progress = callable_or_null(progress)};
    const bool whole = heights != NULL && (views == Py_None || directions != NULL);
    if (whole) w.scene = scene_begin(scene);
    if (w.scene != NULL) {
        w.def.levels = heights;
        w.def.level_count = (int32_t)level_count;
        w.def.views = (const ty_flux_view*)directions;
        w.def.view_count = (int32_t)view_count;
        const ty_result result = ty_method_options(w.scene, "path", &w.path);
        w.path.spp = spp;
        w.path.seed = seed;
        w.path.progress = call_progress;
        w.path.progress_user = &running;
        if (result == TY_OK) call_run(&running);
        scene_end(scene);
        if (result != TY_OK)
            raise_result(result, ty_take_error(scene->context->context));
        else if (call_raise(&running, NULL) == 0)
            answer = make_parts(&w);
    }
    ty_flux_destroy(w.out);
    free(heights);
    free(directions);
    return answer;
}
