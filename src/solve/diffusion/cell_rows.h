/* Loops over the cells of the box for fluences of one type; included by cell_kernel.c with REAL and NAME() set. */

/* Ghost value beside a boundary cell that makes the central difference there the mean of the slopes at its two faces.
 */
static REAL NAME(ghost)(const ty_side* side, REAL here, REAL next, float value) {
    if (side->kind == TY_BOUNDARY_DIRICHLET) return 2 * (REAL)value - here;
    if (side->kind == TY_BOUNDARY_MARSHAK) return 2 * here - next;
    return here;
}

static void NAME(ghosts)(const ty_cells* cells, REAL* phi, int32_t z) {
    const ty_box* box = &cells->box;
    const int32_t nx = box->size[0], ny = box->size[1], nz = box->size[2];
    const ty_side* sides = cells->sides;
    for (int32_t y = 0; y < ny; ++y) {
        REAL* row = phi + ty_box_at(box, y, z);
        const int32_t in = nx > 1 ? 1 : 0;
        row[-1] = NAME(ghost)(&sides[0], row[0], row[in], sides[0].value[sides[0].step * z + y]);
        row[nx] = NAME(ghost)(&sides[1], row[nx - 1], row[nx - 1 - in], sides[1].value[sides[1].step * z + y]);
    }
    for (int upper = 0; upper < 2; ++upper) {
        if (!ty_box_ends(box, 2 + upper)) continue;
        const int32_t y = upper ? ny - 1 : 0;
        const ptrdiff_t out = upper ? box->row : -box->row, in = ny > 1 ? -out : 0;
        const ty_side* side = &sides[2 + upper];
        REAL* row = phi + ty_box_at(box, y, z);
        for (int32_t x = 0; x < nx; ++x)
            row[x + out] = NAME(ghost)(side, row[x], row[x + in], side->value[side->step * z + x]);
    }
    for (int upper = 0; upper < 2; ++upper) {
        if (z != (upper ? nz - 1 : 0) || !ty_box_ends(box, 4 + upper)) continue;
        const ptrdiff_t out = upper ? box->plane : -box->plane, in = nz > 1 ? -out : 0;
        const ty_side* side = &sides[4 + upper];
        for (int32_t y = 0; y < ny; ++y) {
            REAL* row = phi + ty_box_at(box, y, z);
            for (int32_t x = 0; x < nx; ++x)
                row[x + out] = NAME(ghost)(side, row[x], row[x + in], side->value[side->step * y + x]);
        }
    }
}

/* sigma: extinction; phi and the differences of the neighbours along each axis. */
TY_INLINE float NAME(limited)(const ty_cells* cells, const int32_t limiter, float sigma, REAL phi, REAL dx, REAL dy,
                              REAL dz) {
    return ty_cell_diffusivity(limiter, cells->larsen_power, ty_maxf(sigma, cells->min_extinction), (float)phi,
                               (float)dx * cells->half_inverse[0], (float)dy * cells->half_inverse[1],
                               (float)dz * cells->half_inverse[2]);
}

TY_INLINE float NAME(diffusivity)(const ty_cells* cells, const int32_t limiter, const REAL* phi, float sigma,
                                  ptrdiff_t i) {
    const ptrdiff_t row = cells->box.row, plane = cells->box.plane;
    return NAME(limited)(cells, limiter, sigma, phi[i], phi[i + 1] - phi[i - 1], phi[i + row] - phi[i - row],
                         phi[i + plane] - phi[i - plane]);
}

/* Block of cells of one colour in a row with their neighbours, stored contiguously for vector loads and padded to whole
 * vectors. Neighbours along x have one more entry: the lower one of each cell, and the upper one of the last. */
typedef struct NAME(sor_block) {
    REAL here[SOR_BLOCK], x[SOR_BLOCK + SOR_LANES], y0[SOR_BLOCK], y1[SOR_BLOCK], z0[SOR_BLOCK], z1[SOR_BLOCK];
    float d[SOR_BLOCK], dx[SOR_BLOCK + SOR_LANES], dy0[SOR_BLOCK], dy1[SOR_BLOCK], dz0[SOR_BLOCK], dz1[SOR_BLOCK];
    float sigma[SOR_BLOCK], absorption[SOR_BLOCK], source[SOR_BLOCK], value[4][SOR_BLOCK];
} NAME(sor_block);

/* Gathers cells i, i + 2, ... edge: the row touches a boundary along y or z. */
TY_INLINE void NAME(sor_gather)(const ty_cells* cells, const row_view* view, const REAL* phi, const float* diff,
                                int32_t i, int32_t count, const bool edge, NAME(sor_block) * block) {
    const ptrdiff_t row = cells->box.row, plane = cells->box.plane;
    NAME(every_other)(phi + i, count, block->here);
    NAME(every_other)(phi + i - 1, count + 1, block->x);
    NAME(every_other)(phi + i - row, count, block->y0);
    NAME(every_other)(phi + i + row, count, block->y1);
    NAME(every_other)(phi + i - plane, count, block->z0);
    NAME(every_other)(phi + i + plane, count, block->z1);
    every_other_float(diff + i, count, block->d);
    every_other_float(diff + i - 1, count + 1, block->dx);
    every_other_float(diff + i - row, count, block->dy0);
    every_other_float(diff + i + row, count, block->dy1);
    every_other_float(diff + i - plane, count, block->dz0);
    every_other_float(diff + i + plane, count, block->dz1);
    every_other_float(view->extinction + i, count, block->sigma);
    every_other_float(view->absorption + i, count, block->absorption);
    every_other_float(view->source + i, count, block->source);
    for (int side = 2; side < 6 && edge; ++side)
        every_other_float(view->value[side] + i, count, block->value[side - 2]);
}

/* Updates SOR_LANES cells of a block from `begin`: D, then fluence by Eq. 32 (Koerner 2014) with
 * over-relaxation. Cells from `count` on are padding. */
TY_INLINE double NAME(sor_lanes)(const ty_cells* cells, const int32_t limiter, const row_view* view, REAL omega,
                                 int32_t i, int32_t begin, int32_t count, const bool edge, NAME(sor_block) * block) {
    const int32_t last = cells->box.size[0] - 1;
    const float* k = view->k;
    const REAL scale = (REAL)cells->scale;
    double sum = 0;
#pragma omp simd reduction(+ : sum)
    for (int32_t lane = 0; lane < SOR_LANES; ++lane) {
        const int32_t n = begin + lane, x = i + 2 * n;
        const REAL here = block->here[n];
        const float limited = NAME(limited)(cells, limiter, block->sigma[n], here, block->x[n + 1] - block->x[n],
                                            block->y1[n] - block->y0[n], block->z1[n] - block->z0[n]);
        const float d = ty_filter_diffusivity_update(block->d[n], limited), is_first = x == 0 ? 1.0f : 0.0f,
                    is_last = x == last ? 1.0f : 0.0f;
        const REAL x0 = (REAL)((1.0f - is_first) * k[0] * (d + block->dx[n]));
        const REAL x1 = (REAL)((1.0f - is_last) * k[1] * (d + block->dx[n + 1]));
        const REAL y0 = (REAL)(k[2] * (d + block->dy0[n])), y1 = (REAL)(k[3] * (d + block->dy1[n]));
        const REAL z0 = (REAL)(k[4] * (d + block->dz0[n])), z1 = (REAL)(k[5] * (d + block->dz1[n]));
        const REAL w0 = (REAL)(is_first * ty_cell_boundary(view->a[0], view->b[0], d));
        const REAL w1 = (REAL)(is_last * ty_cell_boundary(view->a[1], view->b[1], d));
        REAL numerator = (REAL)block->source[n] * scale + x0 * block->x[n] + x1 * block->x[n + 1] + y0 * block->y0[n] +
                         y1 * block->y1[n] + z0 * block->z0[n] + z1 * block->z1[n] + w0 * (REAL)view->value[0][0] +
                         w1 * (REAL)view->value[1][0];
        REAL denominator = (REAL)block->absorption[n] + x0 + x1 + y0 + y1 + z0 + z1 + w0 + w1;
        if (edge)
            for (int s = 2; s < 6; ++s) {
                const REAL w = (REAL)ty_cell_boundary(view->a[s], view->b[s], d);
                numerator += w * (REAL)block->value[s - 2][n];
                denominator += w;
            }
        const REAL residual = numerator - here * denominator;
        const REAL next = here + omega * residual / (denominator > (REAL)1e-30 ? denominator : (REAL)1e-30);
        const REAL min_phi = (REAL)TY_POSITIVITY_FLOOR * here;
        block->d[n] = d;
        block->here[n] = limiter == TY_LIMITER_NONE || next > min_phi ? next : min_phi;
        sum += n < count ? (double)residual * (double)residual : 0.0;
    }
    return sum;
}

/* Pass of Algorithm 1 over the cells of a colour in [first, end). */
TY_INLINE double NAME(sor_colour)(const ty_cells* cells, const int32_t limiter, const row_view* view, REAL* phi,
                                  float* diff, REAL omega, int32_t first, int32_t end, const bool edge,
                                  NAME(sor_block) * block) {
    double sum = 0;
    for (int32_t i = first; i < end; i += 2 * SOR_BLOCK) {
        const int32_t remaining = (end - i + 1) / 2, count = remaining < SOR_BLOCK ? remaining : SOR_BLOCK;
        NAME(sor_gather)(cells, view, phi, diff, i, count, edge, block);
        for (int32_t n = 0; n < count; n += SOR_LANES)
            sum += NAME(sor_lanes)(cells, limiter, view, omega, i, n, count, edge, block);
        for (int32_t n = 0; n < count; ++n) {
            diff[i + 2 * n] = block->d[n];
            phi[i + 2 * n] = block->here[n];
        }
    }
    return sum;
}

/* Cells of a row in [range[0], range[1]). */
TY_INLINE double NAME(sor_row)(const ty_cells* cells, const int32_t limiter, REAL* phi, float* diff, REAL omega,
                               int32_t color, const int32_t range[2], int32_t y, int32_t z, NAME(sor_block) * block) {
    const int32_t first = range[0] + ((color + y + z + range[0]) & 1), end = range[1];
    row_view view;
    set_row(cells, y, z, &view);
    for (int side = 0; side < 2; ++side) { /* boundary terms of both ends, with the couplings of interior cells */
        set_x_side(cells, y, z, side, &view);
        view.k[side] = cells->coupling[0];
    }
    REAL* row = phi + ty_box_at(&cells->box, y, z);
    float* d = diff + ty_box_at(&cells->box, y, z);
    return is_edge(cells, y, z) ? NAME(sor_colour)(cells, limiter, &view, row, d, omega, first, end, true, block)
                                : NAME(sor_colour)(cells, limiter, &view, row, d, omega, first, end, false, block);
}

/* One function per limiter. Not inlined: compilers fail to vectorise some of the inlined copies. */
#define SOR_ROW(limiter, name)                                                                                         \
    static __attribute__((noinline)) double NAME(name)(const ty_cells* cells, REAL* phi, float* diff, REAL omega,      \
                                                       int32_t color, const int32_t range[2], int32_t y, int32_t z,    \
                                                       NAME(sor_block) * block) {                                      \
        return NAME(sor_row)(cells, limiter, phi, diff, omega, color, range, y, z, block);                             \
    }
SOR_ROW(TY_LIMITER_NONE, sor_none)
SOR_ROW(TY_LIMITER_SUM, sor_sum)
SOR_ROW(TY_LIMITER_MAX, sor_max)
SOR_ROW(TY_LIMITER_KERSHAW, sor_kershaw)
SOR_ROW(TY_LIMITER_LARSEN, sor_larsen)
SOR_ROW(TY_LIMITER_LEVERMORE_POMRANING, sor_levermore_pomraning)
#undef SOR_ROW

static double NAME(sor)(const ty_cells* cells, REAL* phi, float* diffusivity, double omega, int32_t color,
                        int32_t depth, int32_t z) {
    static double (*const rows[TY_LIMITER_COUNT])(const ty_cells*, REAL*, float*, REAL, int32_t, const int32_t[2],
                                                  int32_t, int32_t, NAME(sor_block)*) = {
        [TY_LIMITER_NONE] = NAME(sor_none),     [TY_LIMITER_SUM] = NAME(sor_sum),
        [TY_LIMITER_MAX] = NAME(sor_max),       [TY_LIMITER_KERSHAW] = NAME(sor_kershaw),
        [TY_LIMITER_LARSEN] = NAME(sor_larsen), [TY_LIMITER_LEVERMORE_POMRANING] = NAME(sor_levermore_pomraning)};
    NAME(sor_block) block = {0};
    double sum = 0;
    for (int32_t y = 0; y < cells->box.size[1]; ++y) {
        int32_t ranges[2][2];
        const int32_t count = ranges_within(cells, depth, y, z, ranges);
        for (int32_t n = 0; n < count; ++n)
            sum += rows[cells->limiter](cells, phi, diffusivity, (REAL)omega, color, ranges[n], y, z, &block);
    }
    return sum;
}
