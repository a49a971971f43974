#include "solve/diffusion/adjoint/adjoint.h"

#include "base/context.h"
#include "base/parallel.h"
#include "base/progress.h"
#include "solve/diffusion/adjoint/limiter_slope.h"
#include "solve/diffusion/adjoint/linear.h"

#include <math.h>
#include <string.h>

/* Krylov vectors until a restart; largest number of linear solves; their multigrid cycles at most, and tolerance. */
enum { KRYLOV = 40, SOLVES_MAX = 150, CYCLES = 1 };
static const double SOLVE_TOLERANCE = 0.1;
/* The adjoint need not be more exact than this part of the error of the light. */
static const double PART_OF_IMBALANCE = 0.3;
/* Where iterations stop: their residual is exact but for rounding. */
static const double BELOW_TOLERANCE = 0.9;
/* Smaller boxes run on one thread: waking the others takes longer. */
enum { CELLS_FOR_THREADS = 1 << 14 };

/* State of a call. Vectors have one double per cell. */
typedef struct adjoint_job {
    ty_context* context;
    const ty_diffusion_def* def;
    const float *fluence, *weight;
    ptrdiff_t stride[3];
    int64_t cells;
    double min_extinction;
    double* diffusivity;              /* D */
    double* by_fluence;               /* dD/dphi of a cell's own fluence */
    double* by_slope[3];              /* dD/d(difference of the neighbours' fluences along an axis) */
    double* by_extinction;            /* dD/dsigma */
    float* basis[KRYLOV + 1];         /* Krylov vectors */
    double *step, *next;              /* one of them preconditioned, and what the equation makes of that */
    double *adjoint, *by_diffusivity; /* lambda, C^T lambda */
    double *plane_sums, *products;    /* products: KRYLOV numbers per plane */
    double* parts;                    /* of a vector along the first `count` of the basis */
    int32_t count;
    const double* a; /* operands of a loop over planes */
    double *to, factor;
    ty_linear_diffusion* linear;
    float* scaled;          /* of `to` times factor */
    double start, reported; /* s */
    ty_diffusion_adjoint_stats* stats;
} adjoint_job;

static double run_planes(adjoint_job* job, ty_parallel_fn body) {
    ty_parallel_flushed(job->cells >= CELLS_FOR_THREADS ? job->context : NULL, job->def->size[2], body, job);
    double sum = 0;
    for (int32_t z = 0; z < job->def->size[2]; ++z) sum += job->plane_sums[z];
    return sum;
}

static int64_t plane_cells(const adjoint_job* job) {
    return job->stride[2];
}

/* ---- the equation of a cell ---- */

/* Outflow per fluence through a face of the box, a D / (1 + b D), and its derivative by D. */
static void boundary_of(const adjoint_job* job, int side, double diffusivity, double out[2]) {
    const double cell = job->def->cell[side / 2];
    const ty_boundary_kind kind = job->def->boundary[side].kind;
    const double a = kind == TY_BOUNDARY_REFLECTING ? 0 : 2 / (cell * cell);
    const double b = kind == TY_BOUNDARY_MARSHAK ? 4 / cell : 0, series = 1 + b * diffusivity;
    out[0] = a * diffusivity / series;
    out[1] = a / (series * series);
}

/* Weights of a cell's own fluence and of its neighbour's for the ghost beyond a face of the box (cell_rows.h). */
static void ghost_of(const adjoint_job* job, int side, double out[2]) {
    const bool has_next = job->def->size[side / 2] > 1;
    const ty_boundary_kind kind = job->def->boundary[side].kind;
    out[0] = kind == TY_BOUNDARY_DIRICHLET ? -1 : kind == TY_BOUNDARY_MARSHAK && has_next ? 2 : 1;
    out[1] = kind == TY_BOUNDARY_MARSHAK && has_next ? -1 : 0;
}

/* The difference of the fluences above and below a cell along an axis, as weights of the cell below, itself and the one
 * above. */
static void slope_of(const adjoint_job* job, int axis, int32_t at, double out[3]) {
    double ghost[2];
    out[0] = -1;
    out[1] = 0;
    out[2] = 1;
    if (at == 0) {
        ghost_of(job, 2 * axis, ghost);
        out[0] = 0;
        out[1] -= ghost[0];
        out[2] -= ghost[1];
    }
    if (at == job->def->size[axis] - 1) {
        ghost_of(job, 2 * axis + 1, ghost);
        out[2] = 0;
        out[1] += ghost[0];
        out[0] += ghost[1];
    }
    if (job->def->size[axis] == 1) out[0] = out[2] = 0;
}

/* D of Eq. 15 (Koerner 2014) with R of Eq. 34, and its derivatives. */
static void differentiate_cell(adjoint_job* job, const int32_t at[3], int64_t i) {
    const ty_diffusion_def* def = job->def;
    const double phi = (double)job->fluence[i], own = (double)def->extinction[i];
    const double sigma = fmax(own, job->min_extinction);
    double gradient[3], square = 0;
    for (int a = 0; a < 3; ++a) {
        double weight[3], difference;
        slope_of(job, a, at[a], weight);
        difference = weight[1] * phi;
        if (weight[0] != 0) difference += weight[0] * (double)job->fluence[i - job->stride[a]];
        if (weight[2] != 0) difference += weight[2] * (double)job->fluence[i + job->stride[a]];
        gradient[a] = difference / (2 * def->cell[a] * def->streaming);
        square += gradient[a] * gradient[a];
    }
    const bool defined = square > 0 && phi > 0;
    const double r = defined ? sqrt(square) / (sigma * phi) : 0;
    const ty_limiter_point f = ty_limiter_at(def->limiter, def->larsen_power, r);
    job->diffusivity[i] = f.value / sigma;
    job->by_fluence[i] = defined ? -f.slope * r / (sigma * phi) : 0;
    for (int a = 0; a < 3; ++a)
        job->by_slope[a][i] =
            defined ? f.slope * r / (sigma * square) * gradient[a] / (2 * def->cell[a] * def->streaming) : 0;
    job->by_extinction[i] = own > job->min_extinction ? -(f.value + f.slope * r) / (sigma * sigma) : 0;
}

static void differentiate_plane(void* user, int64_t z, int32_t worker) {
    (void)worker;
    adjoint_job* job = user;
    const int32_t* size = job->def->size;
    job->plane_sums[z] = 0;
    for (int32_t y = 0; y < size[1]; ++y)
        for (int32_t x = 0; x < size[0]; ++x)
            differentiate_cell(job, (const int32_t[3]){x, y, (int32_t)z},
                               z * plane_cells(job) + y * job->stride[1] + x);
}

/* A value per cell: of fluences, in single precision, or of a vector. */
static double value_at(const adjoint_job* job, const double* vector, int64_t i) {
    return vector != NULL ? vector[i] : (double)job->fluence[i];
}

/* A v for a cell, with the fluence as v if that is NULL. */
static double apply_cell(const adjoint_job* job, const double* v, const int32_t at[3], int64_t i) {
    const ty_diffusion_def* def = job->def;
    const double here = value_at(job, v, i), d = job->diffusivity[i];
    double sum = def->absorption != NULL ? (double)def->absorption[i] * here : 0;
    for (int side = 0; side < 6; ++side) {
        const int axis = side / 2;
        const bool upper = side % 2 != 0;
        if (at[axis] == (upper ? def->size[axis] - 1 : 0)) {
            double boundary[2];
            boundary_of(job, side, d, boundary);
            sum += boundary[0] * here;
            continue;
        }
        const int64_t next = i + (upper ? job->stride[axis] : -job->stride[axis]);
        const double coupling = 0.5 / (def->cell[axis] * def->cell[axis]) * (d + job->diffusivity[next]);
        sum += coupling * (here - value_at(job, v, next));
    }
    return sum;
}

/* C^T v of a cell: the derivative of the sum of v R by its D. */
static double by_diffusivity_of(const adjoint_job* job, const double* v, const int32_t at[3], int64_t i) {
    const ty_diffusion_def* def = job->def;
    const double phi = (double)job->fluence[i];
    double sum = 0;
    for (int side = 0; side < 6; ++side) {
        const int axis = side / 2;
        const bool upper = side % 2 != 0;
        if (at[axis] == (upper ? def->size[axis] - 1 : 0)) {
            double boundary[2];
            boundary_of(job, side, job->diffusivity[i], boundary);
            sum -= boundary[1] * phi * v[i];
            continue;
        }
        const int64_t next = i + (upper ? job->stride[axis] : -job->stride[axis]);
        sum += 0.5 / (def->cell[axis] * def->cell[axis]) * ((double)job->fluence[next] - phi) * (v[i] - v[next]);
    }
    return sum;
}

/* E^T c of a cell, with c the derivatives by D. */
static double by_fluence_of(const adjoint_job* job, const double* c, const int32_t at[3], int64_t i) {
    double sum = c[i] * job->by_fluence[i];
    for (int a = 0; a < 3; ++a) {
        double weight[3];
        slope_of(job, a, at[a], weight);
        sum += weight[1] * c[i] * job->by_slope[a][i];
        if (at[a] > 0) {
            const int64_t below = i - job->stride[a];
            slope_of(job, a, at[a] - 1, weight);
            sum += weight[2] * c[below] * job->by_slope[a][below];
        }
        if (at[a] < job->def->size[a] - 1) {
            const int64_t above = i + job->stride[a];
            slope_of(job, a, at[a] + 1, weight);
            sum += weight[0] * c[above] * job->by_slope[a][above];
        }
    }
    return sum;
}

/* True if cell (x, y, z) is at least `depth` cells from all faces of the box, but for x. */
static bool is_inside(const adjoint_job* job, int32_t y, int64_t z, int32_t depth) {
    const int32_t* size = job->def->size;
    return y >= depth && y < size[1] - depth && z >= depth && z < size[2] - depth;
}

/* The same as by_diffusivity_of for cells [begin, end) of a row inside of the box. */
static void by_diffusivity_inside(const adjoint_job* job, const double* v, int64_t begin, int64_t end, double* to) {
    const float* phi = job->fluence;
    const ptrdiff_t row = job->stride[1], plane = job->stride[2];
    const double *cell = job->def->cell,
                 k[3] = {0.5 / (cell[0] * cell[0]), 0.5 / (cell[1] * cell[1]), 0.5 / (cell[2] * cell[2])};
#pragma omp simd
    for (int64_t i = begin; i < end; ++i) {
        const double here = (double)phi[i], own = v[i];
        to[i] =
            k[0] * (((double)phi[i - 1] - here) * (own - v[i - 1]) + ((double)phi[i + 1] - here) * (own - v[i + 1])) +
            k[1] * (((double)phi[i - row] - here) * (own - v[i - row]) +
                    ((double)phi[i + row] - here) * (own - v[i + row])) +
            k[2] * (((double)phi[i - plane] - here) * (own - v[i - plane]) +
                    ((double)phi[i + plane] - here) * (own - v[i + plane]));
    }
}

/* The same as by_fluence_of at least two cells from the faces. */
static void by_fluence_inside(const adjoint_job* job, const double* c, int64_t begin, int64_t end, double* to) {
    const double *own = job->by_fluence, *x = job->by_slope[0], *y = job->by_slope[1], *z = job->by_slope[2];
    const ptrdiff_t row = job->stride[1], plane = job->stride[2];
#pragma omp simd
    for (int64_t i = begin; i < end; ++i)
        to[i] = c[i] * own[i] + c[i - 1] * x[i - 1] - c[i + 1] * x[i + 1] + c[i - row] * y[i - row] -
                c[i + row] * y[i + row] + c[i - plane] * z[i - plane] - c[i + plane] * z[i + plane];
}

/* A v - to, as of apply_cell, inside of the box. */
static void apply_inside(const adjoint_job* job, const double* v, int64_t begin, int64_t end, double* to) {
    const double* d = job->diffusivity;
    const float* absorption = job->def->absorption;
    const ptrdiff_t row = job->stride[1], plane = job->stride[2];
    const double *cell = job->def->cell,
                 k[3] = {0.5 / (cell[0] * cell[0]), 0.5 / (cell[1] * cell[1]), 0.5 / (cell[2] * cell[2])};
#pragma omp simd
    for (int64_t i = begin; i < end; ++i) {
        const double own = v[i], here = d[i];
        to[i] = k[0] * ((here + d[i - 1]) * (own - v[i - 1]) + (here + d[i + 1]) * (own - v[i + 1])) +
                k[1] * ((here + d[i - row]) * (own - v[i - row]) + (here + d[i + row]) * (own - v[i + row])) +
                k[2] * ((here + d[i - plane]) * (own - v[i - plane]) + (here + d[i + plane]) * (own - v[i + plane])) -
                to[i];
    }
    for (int64_t i = begin; i < end && absorption != NULL; ++i) to[i] += (double)absorption[i] * v[i];
}

/* A pass over a plane: of cells near the faces one by one, of others in rows. */
typedef struct cell_pass {
    double (*cell)(const adjoint_job* job, const double* v, const int32_t at[3], int64_t i);
    void (*inside)(const adjoint_job* job, const double* v, int64_t begin, int64_t end, double* to);
    int32_t depth;   /* cells from the faces from which `inside` holds */
    double previous; /* factor of what is there */
} cell_pass;

static void fill_cells(const adjoint_job* job, const cell_pass* pass, int32_t begin, int32_t end, int32_t y,
                       int64_t z) {
    const int64_t row = z * job->stride[2] + y * job->stride[1];
    for (int32_t x = begin; x < end; ++x) {
        const double value = pass->cell(job, job->a, (const int32_t[3]){x, y, (int32_t)z}, row + x);
        job->to[row + x] = pass->previous != 0 ? pass->previous * job->to[row + x] + value : value;
    }
}

static void fill_plane(const adjoint_job* job, int64_t z, const cell_pass* pass) {
    const int32_t* size = job->def->size;
    for (int32_t y = 0; y < size[1]; ++y) {
        const int64_t row = z * job->stride[2] + y * job->stride[1];
        if (!is_inside(job, y, z, pass->depth) || size[0] <= 2 * pass->depth) {
            fill_cells(job, pass, 0, size[0], y, z);
            continue;
        }
        fill_cells(job, pass, 0, pass->depth, y, z);
        pass->inside(job, job->a, row + pass->depth, row + size[0] - pass->depth, job->to);
        fill_cells(job, pass, size[0] - pass->depth, size[0], y, z);
    }
    job->plane_sums[z] = 0;
}

static void by_diffusivity_plane(void* user, int64_t z, int32_t worker) {
    (void)worker;
    static const cell_pass pass = {by_diffusivity_of, by_diffusivity_inside, 1, 0};
    fill_plane(user, z, &pass);
}

static void by_fluence_plane(void* user, int64_t z, int32_t worker) {
    (void)worker;
    static const cell_pass pass = {by_fluence_of, by_fluence_inside, 2, 0};
    fill_plane(user, z, &pass);
}

static void apply_plane(void* user, int64_t z, int32_t worker) {
    (void)worker;
    static const cell_pass pass = {apply_cell, apply_inside, 1, -1};
    fill_plane(user, z, &pass);
}

/* to = (A - C E)^T v = A v - E^T C^T v. */
static void apply_adjoint(adjoint_job* job, const double* v, double* to) {
    job->a = v;
    job->to = job->by_diffusivity;
    run_planes(job, by_diffusivity_plane);
    job->a = job->by_diffusivity;
    job->to = to;
    run_planes(job, by_fluence_plane);
    job->a = v;
    run_planes(job, apply_plane);
}

/* Squared residual of the solution's own equation, relative to the source's. */
static void imbalance_plane(void* user, int64_t z, int32_t worker) {
    (void)worker;
    adjoint_job* job = user;
    const int32_t* size = job->def->size;
    int64_t i = z * plane_cells(job);
    double sum = 0;
    for (int32_t y = 0; y < size[1]; ++y)
        for (int32_t x = 0; x < size[0]; ++x, ++i) {
            const double residual =
                (double)job->def->source[i] - apply_cell(job, NULL, (const int32_t[3]){x, y, (int32_t)z}, i);
            sum += residual * residual;
        }
    job->plane_sums[z] = sum;
}

static void square_plane(void* user, int64_t z, int32_t worker) {
    (void)worker;
    adjoint_job* job = user;
    double sum = 0;
    for (int64_t i = z * plane_cells(job); i < (z + 1) * plane_cells(job); ++i)
        sum += (double)job->def->source[i] * (double)job->def->source[i];
    job->plane_sums[z] = sum;
}

/* ---- vectors ---- */

static void add_plane(void* user, int64_t z, int32_t worker) {
    (void)worker;
    adjoint_job* job = user;
    for (int64_t i = z * plane_cells(job); i < (z + 1) * plane_cells(job); ++i) job->to[i] += job->a[i];
    job->plane_sums[z] = 0;
}

/* to += a. */
static void add(adjoint_job* job, const double* a, double* to) {
    job->a = a;
    job->to = to;
    run_planes(job, add_plane);
}

/* Cells whose part of a vector stays in the cache. */
enum { CELLS_AT_ONCE = 1024 };

/* Inner products of the vector at hand with the first basis vectors, per plane. */
static void project_plane(void* user, int64_t z, int32_t worker) {
    (void)worker;
    adjoint_job* job = user;
    double* sums = job->products + z * KRYLOV;
    const int64_t last = (z + 1) * plane_cells(job);
    for (int32_t k = 0; k < job->count; ++k) sums[k] = 0;
    for (int64_t begin = z * plane_cells(job); begin < last; begin += CELLS_AT_ONCE) {
        const int64_t end = begin + CELLS_AT_ONCE < last ? begin + CELLS_AT_ONCE : last;
        for (int32_t k = 0; k < job->count; ++k) {
            double sum = 0;
#pragma omp simd reduction(+ : sum)
            for (int64_t i = begin; i < end; ++i) sum += job->to[i] * (double)job->basis[k][i];
            sums[k] += sum;
        }
    }
    job->plane_sums[z] = 0;
}

/* Subtracts these parts, and sums the squares of the rest. */
static void remove_plane(void* user, int64_t z, int32_t worker) {
    (void)worker;
    adjoint_job* job = user;
    const int64_t last = (z + 1) * plane_cells(job);
    double square = 0;
    for (int64_t begin = z * plane_cells(job); begin < last; begin += CELLS_AT_ONCE) {
        const int64_t end = begin + CELLS_AT_ONCE < last ? begin + CELLS_AT_ONCE : last;
        for (int32_t k = 0; k < job->count; ++k) {
            const double part = job->parts[k];
#pragma omp simd
            for (int64_t i = begin; i < end; ++i) job->to[i] -= part * (double)job->basis[k][i];
        }
#pragma omp simd reduction(+ : square)
        for (int64_t i = begin; i < end; ++i) square += job->to[i] * job->to[i];
    }
    job->plane_sums[z] = square;
}

/* Makes a vector orthogonal to the first `count` basis vectors, of which it had `parts`. Returns its length. */
static double orthogonalise(adjoint_job* job, double* vector, int32_t count, double* parts) {
    job->to = vector;
    job->count = count;
    job->parts = parts;
    run_planes(job, project_plane);
    for (int32_t k = 0; k < count; ++k) {
        parts[k] = 0;
        for (int32_t z = 0; z < job->def->size[2]; ++z) parts[k] += job->products[(int64_t)z * KRYLOV + k];
    }
    return sqrt(run_planes(job, remove_plane));
}

static void scale_plane(void* user, int64_t z, int32_t worker) {
    (void)worker;
    adjoint_job* job = user;
    for (int64_t i = z * plane_cells(job); i < (z + 1) * plane_cells(job); ++i)
        job->scaled[i] = (float)(job->factor * job->to[i]);
    job->plane_sums[z] = 0;
}

/* out = factor * v. */
static void scale(adjoint_job* job, double factor, double* v, float* out) {
    job->factor = factor;
    job->to = v;
    job->scaled = out;
    run_planes(job, scale_plane);
}

/* The sum of the first `count` basis vectors, times -parts. */
static void combine(adjoint_job* job, int32_t count, double* parts, double* out) {
    memset(out, 0, sizeof *out * (size_t)job->cells);
    job->to = out;
    job->count = count;
    job->parts = parts;
    run_planes(job, remove_plane);
}

/* ---- the generalised minimal residual method ---- */

/* to = about A^-1 v: a fixed number of cycles, linear in v. */
static void precondition(adjoint_job* job, const float* v, double* to) {
    job->stats->iterations += 1;
    job->stats->cycles += ty_linear_diffusion_solve(job->linear, v, SOLVE_TOLERANCE, CYCLES, to);
}

/* The linear problem at the solution's D. */
static ty_result make_linear(adjoint_job* job) {
    ty_diffusion_def def = *job->def;
    float* extinction = ty_alloc_array(job->context, (size_t)job->cells, sizeof *extinction, false);
    if (extinction == NULL) return TY_ERROR_MEMORY;
    for (int64_t i = 0; i < job->cells; ++i) extinction[i] = (float)(1 / (3 * job->diffusivity[i]));
    def.extinction = extinction;
    def.min_extinction = 1e-30;
    const ty_result result = ty_linear_diffusion_create(job->context, &def, &job->linear);
    ty_free_array(job->context, extinction, (size_t)job->cells, sizeof *extinction);
    return result;
}

/* Residuals decrease about geometrically to the tolerance. */
static ty_result report(adjoint_job* job, double residual, double tolerance) {
    const ty_diffusion_def* def = job->def;
    if (def->progress == NULL || !ty_report_due(&job->reported)) return TY_OK;
    const double done = residual > 0 && residual < 1 ? fmin(log(residual) / log(tolerance), 1) : 0;
    const ty_progress progress = ty_progress_at("adjoint", done, job->reported - job->start);
    return def->progress(def->progress_user, &progress) ? TY_OK : TY_CANCELLED;
}

/* Least squares of the Hessenberg matrix by Givens rotations, column by column. */
typedef struct hessenberg {
    double column[KRYLOV][KRYLOV + 1], cosine[KRYLOV], sine[KRYLOV], right[KRYLOV + 1];
} hessenberg;

static void rotate_column(hessenberg* h, int32_t j) {
    double* column = h->column[j];
    for (int32_t i = 0; i < j; ++i) {
        const double first = column[i];
        column[i] = h->cosine[i] * first + h->sine[i] * column[i + 1];
        column[i + 1] = h->cosine[i] * column[i + 1] - h->sine[i] * first;
    }
    const double length = hypot(column[j], column[j + 1]);
    h->cosine[j] = length > 0 ? column[j] / length : 1;
    h->sine[j] = length > 0 ? column[j + 1] / length : 0;
    column[j] = length;
    h->right[j + 1] = -h->sine[j] * h->right[j];
    h->right[j] *= h->cosine[j];
}

/* Adds the solution in `count` Krylov vectors to lambda. */
static void take_steps(adjoint_job* job, const hessenberg* h, int32_t count) {
    double y[KRYLOV];
    for (int32_t i = count - 1; i >= 0; --i) {
        y[i] = h->right[i];
        for (int32_t j = i + 1; j < count; ++j) y[i] -= h->column[j][i] * y[j];
        y[i] = h->column[i][i] != 0 ? y[i] / h->column[i][i] : 0;
    }
    combine(job, count, y, job->next);
    scale(job, -1, job->next, job->basis[0]);
    precondition(job, job->basis[0], job->step);
    add(job, job->step, job->adjoint);
}

/* Iterates from the residual `next`, of norm `norm`, to the tolerance of `whole`. */
static ty_result iterate(adjoint_job* job, double norm, double tolerance, double whole) {
    const double target = BELOW_TOLERANCE * tolerance * whole;
    hessenberg h = {.right = {norm}};
    ty_result result = TY_OK;
    int32_t j = 0;
    scale(job, 1 / norm, job->next, job->basis[0]);
    while (j < KRYLOV && job->stats->iterations < SOLVES_MAX && fabs(h.right[j]) > target) {
        precondition(job, job->basis[j], job->step);
        apply_adjoint(job, job->step, job->next);
        const double length = h.column[j][j + 1] = orthogonalise(job, job->next, j + 1, h.column[j]);
        scale(job, length > 0 ? 1 / length : 0, job->next, job->basis[j + 1]);
        rotate_column(&h, j++);
        result = report(job, fabs(h.right[j]) / whole, tolerance);
        if (result != TY_OK) return result;
    }
    take_steps(job, &h, j);
    return TY_OK;
}

static void residual_plane(void* user, int64_t z, int32_t worker) {
    (void)worker;
    adjoint_job* job = user;
    double square = 0;
    for (int64_t i = z * plane_cells(job); i < (z + 1) * plane_cells(job); ++i) {
        job->to[i] = (double)job->weight[i] - job->to[i];
        square += job->to[i] * job->to[i];
    }
    job->plane_sums[z] = square;
}

/* Sets `next` to the residual of lambda, and returns its length. */
static double find_residual(adjoint_job* job) {
    apply_adjoint(job, job->adjoint, job->next);
    job->to = job->next;
    return sqrt(run_planes(job, residual_plane));
}

/* Restarts until the residual of the adjoint equation is small. */
static ty_result solve(adjoint_job* job, double tolerance) {
    ty_diffusion_adjoint_stats* stats = job->stats;
    memset(job->next, 0, sizeof *job->next * (size_t)job->cells);
    job->to = job->next;
    const double whole = sqrt(run_planes(job, residual_plane));
    double norm = whole;
    stats->converged = !(whole > 0);
    while (!stats->converged && stats->iterations < SOLVES_MAX) {
        const ty_result result = iterate(job, norm, tolerance, whole);
        if (result != TY_OK) return result;
        norm = find_residual(job);
        stats->residual = norm / whole;
        stats->converged = stats->residual <= tolerance;
    }
    return TY_OK;
}

/* ---- the call ---- */

enum { VECTORS = 10 };

static void list_vectors(adjoint_job* job, double** out[VECTORS]) {
    double** const vectors[VECTORS] = {&job->diffusivity,    &job->by_fluence, &job->by_slope[0],   &job->by_slope[1],
                                       &job->by_slope[2],    &job->adjoint,    &job->by_extinction, &job->step,
                                       &job->by_diffusivity, &job->next};
    memcpy(out, vectors, sizeof vectors);
}

static ty_result allocate(adjoint_job* job) {
    const size_t cells = (size_t)job->cells;
    double** vectors[VECTORS];
    bool whole = true;
    list_vectors(job, vectors);
    for (int i = 0; i < VECTORS && whole; ++i) {
        *vectors[i] = ty_alloc_array(job->context, cells, sizeof(double), true);
        whole = *vectors[i] != NULL;
    }
    for (int i = 0; i <= KRYLOV && whole; ++i) {
        job->basis[i] = ty_alloc_array(job->context, cells, sizeof(float), false);
        whole = job->basis[i] != NULL;
    }
    if (whole) job->plane_sums = ty_alloc_array(job->context, (size_t)job->def->size[2], sizeof(double), false);
    if (whole) job->products = ty_alloc_array(job->context, (size_t)job->def->size[2], KRYLOV * sizeof(double), false);
    return whole && job->products != NULL && job->plane_sums != NULL ? TY_OK : TY_ERROR_MEMORY;
}

static void free_all(adjoint_job* job) {
    const size_t cells = (size_t)job->cells;
    double** vectors[VECTORS];
    list_vectors(job, vectors);
    for (int i = 0; i < VECTORS; ++i) ty_free_array(job->context, *vectors[i], cells, sizeof(double));
    for (int i = 0; i <= KRYLOV; ++i) ty_free_array(job->context, job->basis[i], cells, sizeof(float));
    ty_linear_diffusion_destroy(job->linear);
    ty_free_array(job->context, job->products, (size_t)job->def->size[2], KRYLOV * sizeof(double));
    ty_free_array(job->context, job->plane_sums, (size_t)job->def->size[2], sizeof(double));
}

static ty_result begin(adjoint_job* job) {
    const ty_diffusion_def* def = job->def;
    double longest = 0;
    for (int a = 0; a < 3; ++a) longest = fmax(longest, def->cell[a] * def->size[a]);
    job->min_extinction = def->min_extinction > 0 ? def->min_extinction : 1e-3 / longest;
    run_planes(job, differentiate_plane);
    const double source = run_planes(job, square_plane), residual = run_planes(job, imbalance_plane);
    job->stats->imbalance = source > 0 ? sqrt(residual / source) : 0;
    return make_linear(job);
}

/* R is in inverse proportion to the bound of the flux, so that dD/dstreaming = phi dD/dphi / streaming at a constant
 * gradient. */
static void store(adjoint_job* job, const ty_diffusion_adjoint_out* out) {
    job->a = job->adjoint;
    job->to = job->by_diffusivity;
    run_planes(job, by_diffusivity_plane);
    for (int64_t i = 0; i < job->cells; ++i) {
        out->source[i] = (float)job->adjoint[i];
        out->absorption[i] = (float)(-job->adjoint[i] * (double)job->fluence[i]);
        out->extinction[i] = (float)(job->by_diffusivity[i] * job->by_extinction[i]);
    }
    double streaming = 0;
    for (int64_t i = 0; i < job->cells; ++i)
        streaming += job->by_diffusivity[i] * job->by_fluence[i] * (double)job->fluence[i];
    *out->streaming = streaming / job->def->streaming;
}

ty_result ty_diffusion_adjoint(ty_context* context, const ty_diffusion_def* def, const float* fluence,
                               const float* weight, double tolerance, const ty_diffusion_adjoint_out* out,
                               ty_diffusion_adjoint_stats* stats) {
    *stats = (ty_diffusion_adjoint_stats){.converged = false};
    if (def->faces != NULL)
        return ty_fail(context, TY_ERROR_ARGUMENT, "diffusion: surfaces between cells have no adjoint");
    adjoint_job job = {.context = context, .def = def, .fluence = fluence, .weight = weight, .stats = stats};
    job.start = job.reported = ty_wall_seconds();
    job.stride[0] = 1;
    job.stride[1] = def->size[0];
    job.stride[2] = (ptrdiff_t)def->size[0] * def->size[1];
    job.cells = (int64_t)job.stride[2] * def->size[2];
    ty_result result = allocate(&job);
    if (result == TY_OK) result = begin(&job);
    if (result == TY_OK) result = solve(&job, fmax(tolerance, PART_OF_IMBALANCE * stats->imbalance));
    if (result == TY_OK) store(&job, out);
    free_all(&job);
    return result;
}
