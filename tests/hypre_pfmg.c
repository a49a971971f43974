/* Linear diffusion on a divided grid, by ty_diffusion_solve and by hypre's PFMG (Ashby and Falgout 1996) and conjugate
 * gradients with it: the same equations, to the same residual. Prints both processor times, of all ranks.
 * usage, under mpirun or alone: hypre_pfmg CELLS TOLERANCE RUNS, of cells along an axis. Status 1: the solutions
 * differ, or hypre takes less time. */
#define _GNU_SOURCE
#include "comm/domain.h"
#include "solve/diffusion/diffusion.h"

#include <HYPRE_struct_ls.h>
#include <math.h>
#include <mpi.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

extern const ty_comm_backend ty_comm_module;

/* Fluences may differ by so many tolerances, relative to the largest one. */
static const double MAX_DIFFERENCE = 10;

/* A rank's part: coefficients of its box and of the cells around it. */
typedef struct setting {
    ty_comm* comm;
    ty_domain domain;
    int32_t cells, size[3];
    double cell, tolerance;
    size_t count;
    float *extinction, *absorption, *source, *fluence;
} setting;

static double processor_seconds(void) {
    struct timespec time;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
    return (double)time.tv_sec + 1e-9 * (double)time.tv_nsec;
}

static double of_all(setting* s, double value) {
    ty_comm_sum(s->comm, &value, 1);
    return value;
}

static float* floats(size_t count) {
    float* items = malloc(sizeof(float) * count);
    if (items == NULL) exit(1);
    return items;
}

/* ---- the problem: balls of smoke in thinner air, 40 to 1, lit from a corner ---- */

static float extinction_at(const setting* s, const int32_t at[3]) {
    double wave = 1;
    for (int a = 0; a < 3; ++a) wave *= sin(11.0 * (at[a] + 0.5) / s->cells + a);
    return wave > 0.1 ? 80 : 2;
}

static void fill(setting* s) {
    size_t i = 0;
    int32_t at[3];
    for (at[2] = s->domain.first[2]; at[2] < s->domain.end[2]; ++at[2])
        for (at[1] = s->domain.first[1]; at[1] < s->domain.end[1]; ++at[1])
            for (at[0] = 0; at[0] < s->cells; ++at[0], ++i) {
                const double x = (at[0] + 0.5) / s->cells, y = (at[1] + 0.5) / s->cells, z = (at[2] + 0.5) / s->cells;
                s->extinction[i] = extinction_at(s, at);
                s->absorption[i] = 0.01f * s->extinction[i];
                s->source[i] = (float)exp(-8 * (x * x + y * y + z * z));
            }
}

/* ---- ours ---- */

static double solve_ours(setting* s, ty_context* context, int* cycles) {
    ty_diffusion_def def = ty_default_diffusion_def();
    for (int a = 0; a < 3; ++a) def.size[a] = s->size[a];
    for (int a = 0; a < 3; ++a) def.cell[a] = s->cell;
    def.extinction = s->extinction;
    def.absorption = s->absorption;
    def.source = s->source;
    def.limiter = TY_LIMITER_NONE;
    def.tolerance = s->tolerance;
    def.domain = s->comm != NULL ? &s->domain : NULL;
    const ty_diffusion_out out = {.fluence = s->fluence};
    ty_diffusion_stats stats;
    const double begun = processor_seconds();
    const ty_result result = ty_diffusion_solve(context, &def, &out, &stats);
    const double seconds = of_all(s, processor_seconds() - begun);
    if (result != TY_OK || !stats.converged) {
        fprintf(stderr, "ty_diffusion_solve: %s, residual %g\n", ty_result_name(result), stats.residual);
        exit(1);
    }
    *cycles = stats.cycles;
    return seconds;
}

/* ---- hypre's ---- */

typedef struct system {
    HYPRE_StructGrid grid;
    HYPRE_StructStencil stencil;
    HYPRE_StructMatrix matrix;
    HYPRE_StructVector right, solution;
    int lower[3], upper[3];
} system_;

/* Row of a cell: its diagonal, and the couplings D / h^2 with the mean D of two cells; Marshak's vacuum boundary lets
 * through D / (h^2 / 2 + 2 D h) of the fluence. */
static void row_of(const setting* s, const int32_t at[3], double absorption, double row[7]) {
    const double h = s->cell, here = 1 / (3 * (double)extinction_at(s, at));
    row[0] = absorption;
    for (int side = 0; side < 6; ++side) {
        int32_t next[3] = {at[0], at[1], at[2]};
        next[side / 2] += (side & 1) != 0 ? 1 : -1;
        const bool inside = next[side / 2] >= 0 && next[side / 2] < s->cells;
        const double beyond = inside ? 1 / (3 * (double)extinction_at(s, next)) : 0;
        const double out = inside ? 0.5 * (here + beyond) / (h * h) : here / (0.5 * h * h + 2 * h * here);
        row[0] += out;
        row[1 + side] = inside ? -out : 0;
    }
}

static system_ assemble(const setting* s) {
    system_ m;
    static const int offsets[7][3] = {{0, 0, 0}, {-1, 0, 0}, {1, 0, 0}, {0, -1, 0}, {0, 1, 0}, {0, 0, -1}, {0, 0, 1}};
    int entries[7] = {0, 1, 2, 3, 4, 5, 6};
    for (int a = 0; a < 3; ++a) m.lower[a] = s->domain.first[a];
    for (int a = 0; a < 3; ++a) m.upper[a] = s->domain.end[a] - 1;
    HYPRE_StructGridCreate(MPI_COMM_WORLD, 3, &m.grid);
    HYPRE_StructGridSetExtents(m.grid, m.lower, m.upper);
    HYPRE_StructGridAssemble(m.grid);
    HYPRE_StructStencilCreate(3, 7, &m.stencil);
    for (int e = 0; e < 7; ++e) HYPRE_StructStencilSetElement(m.stencil, e, (int*)(uintptr_t)offsets[e]);
    HYPRE_StructMatrixCreate(MPI_COMM_WORLD, m.grid, m.stencil, &m.matrix);
    HYPRE_StructMatrixInitialize(m.matrix);
    HYPRE_StructVectorCreate(MPI_COMM_WORLD, m.grid, &m.right);
    HYPRE_StructVectorCreate(MPI_COMM_WORLD, m.grid, &m.solution);
    HYPRE_StructVectorInitialize(m.right);
    HYPRE_StructVectorInitialize(m.solution);
    double* rows = malloc(sizeof(double) * 7 * s->count);
    double* right = malloc(sizeof(double) * s->count);
    if (rows == NULL || right == NULL) exit(1);
    size_t i = 0;
    int32_t at[3];
    for (at[2] = m.lower[2]; at[2] <= m.upper[2]; ++at[2])
        for (at[1] = m.lower[1]; at[1] <= m.upper[1]; ++at[1])
            for (at[0] = m.lower[0]; at[0] <= m.upper[0]; ++at[0], ++i) {
                row_of(s, at, (double)s->absorption[i], rows + 7 * i);
                right[i] = (double)s->source[i];
            }
    HYPRE_StructMatrixSetBoxValues(m.matrix, m.lower, m.upper, 7, entries, rows);
    HYPRE_StructMatrixAssemble(m.matrix);
    HYPRE_StructVectorSetBoxValues(m.right, m.lower, m.upper, right);
    HYPRE_StructVectorAssemble(m.right);
    HYPRE_StructVectorAssemble(m.solution);
    free(rows);
    free(right);
    return m;
}

/* V(1,1)-cycles with red-black Gauss-Seidel; skip: levels without smoothing, as hypre's own default does. */
static HYPRE_StructSolver make_pfmg(double tolerance, int max_iterations, int skip) {
    HYPRE_StructSolver solver;
    HYPRE_StructPFMGCreate(MPI_COMM_WORLD, &solver);
    HYPRE_StructPFMGSetTol(solver, tolerance);
    HYPRE_StructPFMGSetMaxIter(solver, max_iterations);
    HYPRE_StructPFMGSetRelaxType(solver, 2);
    HYPRE_StructPFMGSetSkipRelax(solver, skip);
    HYPRE_StructPFMGSetLogging(solver, 1);
    if (max_iterations == 1) HYPRE_StructPFMGSetZeroGuess(solver);
    return solver;
}

/* Processor seconds of set-up and solve, without assembly. kind: 0, 1: PFMG with skip 0, 1; 2, 3: conjugate gradients
 * with it. */
static double solve_hypre(setting* s, system_* m, int kind, int* cycles, double* residual) {
    const bool krylov = kind >= 2;
    HYPRE_StructSolver pfmg = make_pfmg(krylov ? 0 : s->tolerance, krylov ? 1 : 500, kind & 1), cg = NULL;
    HYPRE_StructVectorSetConstantValues(m->solution, 0);
    const double begun = processor_seconds();
    if (krylov) {
        HYPRE_StructPCGCreate(MPI_COMM_WORLD, &cg);
        HYPRE_StructPCGSetTol(cg, s->tolerance);
        HYPRE_StructPCGSetMaxIter(cg, 500);
        HYPRE_StructPCGSetTwoNorm(cg, 1);
        HYPRE_StructPCGSetPrecond(cg, HYPRE_StructPFMGSolve, HYPRE_StructPFMGSetup, pfmg);
        HYPRE_StructPCGSetup(cg, m->matrix, m->right, m->solution);
        HYPRE_StructPCGSolve(cg, m->matrix, m->right, m->solution);
        HYPRE_StructPCGGetNumIterations(cg, cycles);
        HYPRE_StructPCGGetFinalRelativeResidualNorm(cg, residual);
    } else {
        HYPRE_StructPFMGSetup(pfmg, m->matrix, m->right, m->solution);
        HYPRE_StructPFMGSolve(pfmg, m->matrix, m->right, m->solution);
        HYPRE_StructPFMGGetNumIterations(pfmg, cycles);
        HYPRE_StructPFMGGetFinalRelativeResidualNorm(pfmg, residual);
    }
    const double seconds = of_all(s, processor_seconds() - begun);
    if (cg != NULL) HYPRE_StructPCGDestroy(cg);
    HYPRE_StructPFMGDestroy(pfmg);
    return seconds;
}

/* The largest difference of the two fluences, relative to the largest fluence. */
static double difference(setting* s, const system_* m) {
    double* other = malloc(sizeof(double) * s->count);
    if (other == NULL) exit(1);
    HYPRE_StructVectorGetBoxValues(m->solution, (int*)(uintptr_t)m->lower, (int*)(uintptr_t)m->upper, other);
    double largest[2] = {0, 0};
    for (size_t i = 0; i < s->count; ++i) {
        largest[0] = fmax(largest[0], fabs(other[i] - (double)s->fluence[i]));
        largest[1] = fmax(largest[1], other[i]);
    }
    ty_comm_max(s->comm, largest, 2);
    free(other);
    return largest[0] / largest[1];
}

static void begin(setting* s) {
    ty_diffusion_def def = ty_default_diffusion_def();
    const int32_t cells[3] = {s->cells, s->cells, s->cells}, unit[3] = {1, 1, 1};
    for (int a = 0; a < 3; ++a) def.size[a] = s->cells;
    for (int a = 0; a < 3; ++a) def.cell[a] = s->cell;
    const bool divided = s->comm != NULL ? ty_diffusion_divide(s->comm, &def, &s->domain)
                                         : ty_domain_create(NULL, cells, 0, unit, 1, &s->domain);
    if (!divided) exit(2);
    s->count = 1;
    for (int a = 0; a < 3; ++a) s->count *= (size_t)(s->size[a] = s->domain.end[a] - s->domain.first[a]);
    s->extinction = floats(s->count);
    s->absorption = floats(s->count);
    s->source = floats(s->count);
    s->fluence = floats(s->count);
    fill(s);
}

int main(int count, char** arguments) {
    static const char* const kinds[] = {"PFMG", "PFMG, skip", "CG + PFMG", "CG + PFMG, skip"};
    if (count != 4) return 2;
    setting s = {.cells = (int32_t)strtol(arguments[1], NULL, 10), .tolerance = strtod(arguments[2], NULL)};
    const int runs = (int)strtol(arguments[3], NULL, 10);
    int32_t rank, size;
    s.cell = 1.0 / s.cells;
    ty_comm_launched(&rank, &size);
    if (ty_comm_join(&ty_comm_module, 60, rank, &s.comm) != TY_OK) return 2;
    ty_comm* world = s.comm;
    if (ty_comm_size(world) == 1) s.comm = NULL;
    begin(&s);
    ty_context_def context_def = ty_default_context_def();
    ty_context* context = NULL;
    context_def.threads = 1;
    if (ty_context_create(&context_def, &context) != TY_OK) return 2;
    double ours = INFINITY, best = INFINITY, residual, differs = 0;
    int cycles = 0;
    for (int run = 0; run < runs; ++run) ours = fmin(ours, solve_ours(&s, context, &cycles));
    if (rank == 0)
        printf("%d^3 cells, tolerance %g, %d ranks, processor s of all, least of %d:\nours             %3d cycles  "
               "%.3f s\n",
               (int)s.cells, s.tolerance, (int)size, runs, cycles, ours);
    system_ m = assemble(&s);
    for (int kind = size > 1 ? 3 : 0; kind < 4; ++kind) { /* of several ranks the fastest alone: they spin */
        double seconds = INFINITY;
        for (int run = 0; run < runs; ++run) seconds = fmin(seconds, solve_hypre(&s, &m, kind, &cycles, &residual));
        const double apart = difference(&s, &m);
        if (rank == 0)
            printf("%-16s %3d cycles  %.3f s  residual %.2g  largest difference %.2g\n", kinds[kind], cycles, seconds,
                   residual, apart);
        if (!(residual <= s.tolerance)) continue; /* it does not converge */
        best = fmin(best, seconds);
        differs = fmax(differs, apart);
    }
    if (rank == 0) printf("hypre's best over ours: %.2f\n", best / ours);
    ty_context_destroy(context);
    ty_domain_destroy(&s.domain);
    ty_comm_close(world, true, 0);
    /* Ranks that wait for messages spend processor time in MPI, so that only one rank tells who is faster. */
    return differs <= MAX_DIFFERENCE * s.tolerance && (size > 1 || ours < best) ? 0 : 1;
}
