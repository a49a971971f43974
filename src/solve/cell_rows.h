/* Loops over the cells of the box for fluences of one type: included by kernel.c with REAL and NAME() set. */

/* Fills the ghost beside a cell so that the central difference there is the mean of the slopes at its two faces. */
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
    for (int high = 0; high < 2; ++high) {
        const int32_t y = high ? ny - 1 : 0;
        const ptrdiff_t out = high ? box->row : -box->row, in = ny > 1 ? -out : 0;
        const ty_side* side = &sides[2 + high];
        REAL* row = phi + ty_box_at(box, y, z);
        for (int32_t x = 0; x < nx; ++x)
            row[x + out] = NAME(ghost)(side, row[x], row[x + in], side->value[side->step * z + x]);
    }
    for (int high = 0; high < 2; ++high) {
        if (z != (high ? nz - 1 : 0)) continue;
        const ptrdiff_t out = high ? box->plane : -box->plane, in = nz > 1 ? -out : 0;
        const ty_side* side = &sides[4 + high];
        for (int32_t y = 0; y < ny; ++y) {
            REAL* row = phi + ty_box_at(box, y, z);
            for (int32_t x = 0; x < nx; ++x)
                row[x + out] = NAME(ghost)(side, row[x], row[x + in], side->value[side->step * y + x]);
        }
    }
}

INLINE float NAME(diffusivity)(const ty_cells* cells, const int32_t limiter, const REAL* phi, float sigma,
                               ptrdiff_t i) {
    const ptrdiff_t row = cells->box.row, plane = cells->box.plane;
    const float gx = (float)(phi[i + 1] - phi[i - 1]) * cells->half_inverse[0];
    const float gy = (float)(phi[i + row] - phi[i - row]) * cells->half_inverse[1];
    const float gz = (float)(phi[i + plane] - phi[i - plane]) * cells->half_inverse[2];
    return ty_cell_diffusivity(limiter, cells->larsen_power, ty_maxf(sigma, cells->least_extinction), (float)phi[i], gx,
                               gy, gz);
}

/* A pass of Algorithm 1 over cells begin, begin + 2, ... of a row; edge: whether any of them touches a boundary. */
INLINE double NAME(sor_range)(const ty_cells* cells, const int32_t limiter, const row_view* view, REAL* phi,
                              float* diff, REAL omega, int32_t begin, int32_t end, const bool edge) {
    const ptrdiff_t row = cells->box.row, plane = cells->box.plane;
    const float *k = view->k, *absorption = view->absorption;
    const REAL scale = (REAL)cells->scale;
    double sum = 0;
#pragma omp simd reduction(+ : sum)
    for (int32_t i = begin; i < end; i += 2) {
        const float d = ty_cell_hold(diff[i], NAME(diffusivity)(cells, limiter, phi, view->extinction[i], i));
        diff[i] = d;
        const REAL x0 = (REAL)(k[0] * (d + diff[i - 1])), x1 = (REAL)(k[1] * (d + diff[i + 1]));
        const REAL y0 = (REAL)(k[2] * (d + diff[i - row])), y1 = (REAL)(k[3] * (d + diff[i + row]));
        const REAL z0 = (REAL)(k[4] * (d + diff[i - plane])), z1 = (REAL)(k[5] * (d + diff[i + plane]));
        REAL numerator = (REAL)view->source[i] * scale + x0 * phi[i - 1] + x1 * phi[i + 1] + y0 * phi[i - row] +
                         y1 * phi[i + row] + z0 * phi[i - plane] + z1 * phi[i + plane];
        REAL denominator = (REAL)absorption[i] + x0 + x1 + y0 + y1 + z0 + z1;
        if (edge)
            for (int s = 0; s < 6; ++s) {
                const REAL w = (REAL)ty_cell_boundary(view->a[s], view->b[s], d);
                numerator += w * (REAL)view->value[s][s < 2 ? 0 : i];
                denominator += w;
            }
        const REAL here = phi[i], left = numerator - here * denominator;
        const REAL next = here + omega * left / (denominator > (REAL)1e-30 ? denominator : (REAL)1e-30);
        const REAL kept = (REAL)TY_CELL_KEPT * here;
        phi[i] = limiter == TY_LIMITER_NONE || next > kept ? next : kept;
        sum += (double)left * (double)left;
    }
    return sum;
}

INLINE double NAME(sor_row)(const ty_cells* cells, const int32_t limiter, REAL* phi, float* diff, REAL omega,
                            int32_t color, int32_t y, int32_t z) {
    const int32_t nx = cells->box.size[0], first = (color + y + z) & 1;
    row_view view = view_row(cells, y, z);
    const bool edge = is_edge(cells, y, z);
    REAL* row = phi + ty_box_at(&cells->box, y, z);
    float* d = diff + ty_box_at(&cells->box, y, z);
    double sum = 0;
    if (first == 0) {
        const row_view low = with_x_sides(cells, view, y, z, true, nx == 1);
        sum += NAME(sor_range)(cells, limiter, &low, row, d, omega, 0, 1, true);
    }
    const int32_t begin = first == 0 ? 2 : 1;
    sum += edge ? NAME(sor_range)(cells, limiter, &view, row, d, omega, begin, nx - 1, true)
                : NAME(sor_range)(cells, limiter, &view, row, d, omega, begin, nx - 1, false);
    if (nx > 1 && ((nx - 1) & 1) == first) {
        const row_view high = with_x_sides(cells, view, y, z, false, true);
        sum += NAME(sor_range)(cells, limiter, &high, row, d, omega, nx - 1, nx, true);
    }
    return sum;
}

#define SOR_ROWS(kind)                                                                                                 \
    case kind:                                                                                                         \
        for (int32_t y = 0; y < cells->box.size[1]; ++y)                                                               \
            sum += NAME(sor_row)(cells, kind, phi, diffusivity, (REAL)omega, color, y, z);                             \
        break

static double NAME(sor)(const ty_cells* cells, REAL* phi, float* diffusivity, double omega, int32_t color, int32_t z) {
    double sum = 0;
    switch (cells->limiter) {
        SOR_ROWS(TY_LIMITER_SUM);
        SOR_ROWS(TY_LIMITER_MAX);
        SOR_ROWS(TY_LIMITER_KERSHAW);
        SOR_ROWS(TY_LIMITER_LARSEN);
        SOR_ROWS(TY_LIMITER_LEVERMORE_POMRANING);
        SOR_ROWS(TY_LIMITER_NONE);
    default: break;
    }
    return sum;
}
#undef SOR_ROWS
