/* Gradients of a loss on the fluence of light that fld or dom solved for. */
#include "module.h"

#include <stdlib.h>

/* The derivatives by one medium's density and coefficients. */
typedef struct medium_gradient {
    int32_t size[3];
    double* voxels; /* NULL: there are none */
    double sigma_s[3], sigma_a[3], g[3];
    bool has_coefficients;
} medium_gradient;

typedef struct gradient_work {
    const ty_fld* fld; /* one of both */
    const ty_dom* dom;
    const ty_scene* scene;
    double lower[3], upper[3];
    int32_t size[3];
    const double* weights;
    call* running;
    /* out */
    ty_gradient_stats stats;
    int32_t planes, cells[3];
    double cells_lower[3], cells_upper[3];
    double* coefficients[3]; /* by ty_gradient_coefficient, plane by plane */
    double* lights;          /* 3 per light */
    int32_t light_count, medium_count;
    medium_gradient* media;
} gradient_work;

/* Media without such derivatives leave theirs out. */
static ty_result read_medium(const ty_gradient* gradient, const ty_scene* scene, int32_t index, medium_gradient* out) {
    ty_result result = ty_gradient_density_size(scene, index, out->size);
    if (result != TY_OK) return result;
    const size_t count = (size_t)out->size[0] * (size_t)out->size[1] * (size_t)out->size[2];
    out->has_coefficients = ty_gradient_medium(gradient, scene, index, out->sigma_s, out->sigma_a, out->g) == TY_OK;
    if (count > 0) {
        out->voxels = calloc(count, sizeof(double));
        if (out->voxels == NULL) return TY_ERROR_MEMORY;
        if (ty_gradient_density(gradient, scene, index, out->voxels) != TY_OK) {
            free(out->voxels);
            out->voxels = NULL;
        }
    }
    (void)ty_take_error(ty_scene_context(scene));
    return TY_OK;
}

static ty_result read_gradient(gradient_work* w, const ty_gradient* gradient) {
    ty_gradient_box(gradient, w->cells_lower, w->cells_upper, w->cells);
    w->planes = ty_gradient_planes(gradient);
    const size_t cells = (size_t)w->cells[0] * (size_t)w->cells[1] * (size_t)w->cells[2];
    for (int i = 0; i < 3; ++i) {
        w->coefficients[i] = calloc(cells * (size_t)w->planes, sizeof(double));
        if (w->coefficients[i] == NULL) return TY_ERROR_MEMORY;
        for (int32_t p = 0; p < w->planes; ++p) {
            const ty_result result =
                ty_gradient_cells(gradient, (ty_gradient_coefficient)i, p, w->coefficients[i] + cells * (size_t)p);
            if (result != TY_OK) return result;
        }
    }
    w->lights = calloc((size_t)w->light_count + 1, 3 * sizeof(double));
    w->media = calloc((size_t)w->medium_count + 1, sizeof *w->media);
    if (w->lights == NULL || w->media == NULL) return TY_ERROR_MEMORY;
    for (int32_t i = 0; i < w->light_count; ++i) {
        const ty_result result = ty_gradient_light(gradient, i, w->lights + 3 * (size_t)i);
        if (result != TY_OK) return result;
    }
    for (int32_t i = 0; i < w->medium_count; ++i) {
        const ty_result result = read_medium(gradient, w->scene, i, &w->media[i]);
        if (result != TY_OK) return result;
    }
    return TY_OK;
}

static ty_result by_fld(gradient_work* w, ty_gradient** out) {
    ty_fld_def def = ty_default_fld_def();
    const ty_result result = ty_method_options(w->scene, "fld", &def);
    def.progress = call_progress;
    def.progress_user = w->running;
    if (result != TY_OK) return result;
    return ty_fld_gradient(w->fld, w->scene, &def, w->lower, w->upper, w->size, w->weights, out, &w->stats);
}

static ty_result by_dom(gradient_work* w, ty_gradient** out) {
    ty_dom_def def = ty_default_dom_def();
    const ty_result result = ty_method_options(w->scene, "dom", &def);
    def.progress = call_progress;
    def.progress_user = w->running;
    if (result != TY_OK) return result;
    return ty_dom_gradient(w->dom, w->scene, &def, w->lower, w->upper, w->size, w->weights, out, &w->stats);
}

static ty_result find_gradient(void* user) {
    gradient_work* w = user;
    ty_gradient* gradient = NULL;
    w->stats = ty_default_gradient_stats();
    ty_result result = w->dom != NULL ? by_dom(w, &gradient) : by_fld(w, &gradient);
    if (result == TY_OK) result = read_gradient(w, gradient);
    ty_gradient_destroy(gradient);
    return result;
}

static void free_work(gradient_work* w) {
    for (int i = 0; i < 3; ++i) free(w->coefficients[i]);
    for (int32_t i = 0; i < w->medium_count && w->media != NULL; ++i) free(w->media[i].voxels);
    free(w->media);
    free(w->lights);
}

/* The arrays take over their memory. */
static PyObject* coefficient_array(gradient_work* w, int index) {
    const Py_ssize_t shape[4] = {w->planes, w->cells[2], w->cells[1], w->cells[0]};
    double* data = w->coefficients[index];
    w->coefficients[index] = NULL;
    return array_own(data, 'd', 4, shape);
}

static PyObject* voxel_array(medium_gradient* medium) {
    const Py_ssize_t shape[3] = {medium->size[2], medium->size[1], medium->size[0]};
    double* data = medium->voxels;
    if (data == NULL) Py_RETURN_NONE;
    medium->voxels = NULL;
    return array_own(data, 'd', 3, shape);
}

static PyObject* medium_tuple(gradient_work* w, int32_t index) {
    medium_gradient* medium = &w->media[index];
    PyObject* voxels = voxel_array(medium);
    if (!medium->has_coefficients) return Py_BuildValue("(NOOO)", voxels, Py_None, Py_None, Py_None);
    return Py_BuildValue("(NNNN)", voxels, tuple_of_doubles(medium->sigma_s, w->planes),
                         tuple_of_doubles(medium->sigma_a, w->planes), tuple_of_doubles(medium->g, w->planes));
}

static PyObject* stats_dict(const ty_gradient_stats* stats) {
    return Py_BuildValue("{s:O,s:i,s:d,s:d,s:d}", "converged", stats->converged ? Py_True : Py_False, "iterations",
                         (int)stats->iterations, "residual", stats->residual, "imbalance", stats->imbalance, "seconds",
                         stats->seconds);
}

static PyObject* make_answer(gradient_work* w) {
    PyObject* media = PyTuple_New(w->medium_count);
    for (int32_t i = 0; i < w->medium_count && media != NULL; ++i) {
        PyObject* one = medium_tuple(w, i);
        if (one == NULL || PyTuple_SetItem(media, i, one) != 0) {
            Py_DECREF(media);
            return NULL;
        }
    }
    if (media == NULL) return NULL;
    const Py_ssize_t lights[2] = {w->light_count, 3};
    double* strengths = w->lights;
    w->lights = NULL;
    return Py_BuildValue("(N(NNN)(NNN)NN)", stats_dict(&w->stats), tuple_of_doubles(w->cells_lower, 3),
                         tuple_of_doubles(w->cells_upper, 3), tuple_of_ints(w->cells, 3), coefficient_array(w, 0),
                         coefficient_array(w, 1), coefficient_array(w, 2), array_own(strengths, 'd', 2, lights), media);
}

PyObject* light_gradient(const ty_fld* fld, const ty_dom* dom, PyObject* arguments) {
    PyObject *object, *lower, *upper, *size, *given, *progress, *answer = NULL;
    gradient_work w = {.fld = fld, .dom = dom};
    if (!PyArg_ParseTuple(arguments, "O!OOOOO", scene_type, &object, &lower, &upper, &size, &given, &progress) ||
        doubles_of(lower, "lower", 3, w.lower) != 0 || doubles_of(upper, "upper", 3, w.upper) != 0 ||
        ints_of(size, "size", 3, w.size) != 0)
        return NULL;
    scene_object* scene = (scene_object*)object;
    Py_ssize_t count = 0;
    double* weights = doubles_from(given, "weights", 3, &count);
    if (weights == NULL) return NULL;
    const double cells = (double)w.size[0] * w.size[1] * w.size[2];
    if ((double)count != cells) {
        free(weights);
        return raise_argument("weights: %zd cells, not %g", count, cells);
    }
    w.weights = weights;
    w.scene = scene_begin(scene);
    if (w.scene != NULL) {
        const ty_scene_info info = ty_scene_get_info(w.scene);
        w.light_count = (int32_t)info.lights;
        w.medium_count = (int32_t)info.media;
        call running = {
            .context = scene->context, .work = find_gradient, .user = &w, .progress = callable_or_null(progress)};
        w.running = &running;
        call_run(&running);
        scene_end(scene);
        if (call_raise(&running, NULL) == 0) answer = make_answer(&w);
    }
    free(weights);
    free_work(&w);
    return answer;
}
