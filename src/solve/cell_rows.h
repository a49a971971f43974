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

/* A step of Algorithm 1 for SOR_BLOCK cells side by side, of which those of one colour are kept: vectors are loaded as
 * they lie, so that twice the arithmetic is less work. phi and diff: of the first cell, x = begin; ends: whether the
 * row's first or last cell is among them; edge: whether they touch a boundary along y or z. */
INLINE float NAME(sor_block)(const ty_cells* cells, const int32_t limiter, const sor_view* v, REAL* phi, float* diff,
                             float omega, int32_t begin, int32_t first, const bool ends, const bool edge) {
    const ptrdiff_t row = cells->box.row, plane = cells->box.plane;
    const int32_t last = cells->box.size[0] - 1 - begin, count = last + 1 < SOR_BLOCK ? last + 1 : SOR_BLOCK;
    const float *extinction = v->cells[0], *absorption = v->cells[1], *source = v->cells[2];
    const float k0 = v->k[0], k1 = v->k[1], k2 = v->k[2], k3 = v->k[3], k4 = v->k[4], k5 = v->k[5];
    const float beyond0 = v->beyond[0], beyond1 = v->beyond[1];
    const REAL scale = (REAL)cells->scale;
    REAL next[SOR_BLOCK];
    float next_d[SOR_BLOCK], squares = 0;
#pragma omp simd reduction(+ : squares)
    for (int32_t i = 0; i < SOR_BLOCK; ++i) {
        const float d = ty_cell_hold(diff[i], NAME(diffusivity)(cells, limiter, phi, extinction[i], i));
        const float low = ends && i == -begin ? 1.0f : 0.0f, high = ends && i == last ? 1.0f : 0.0f;
        const float x0 = (1.0f - low) * k0 * (d + diff[i - 1]), x1 = (1.0f - high) * k1 * (d + diff[i + 1]);
        const float y0 = k2 * (d + diff[i - row]), y1 = k3 * (d + diff[i + row]);
        const float z0 = k4 * (d + diff[i - plane]), z1 = k5 * (d + diff[i + plane]);
        const REAL here = phi[i];
        REAL left = (REAL)source[i] * scale - (REAL)absorption[i] * here + (REAL)x0 * (phi[i - 1] - here) +
                    (REAL)x1 * (phi[i + 1] - here) + (REAL)y0 * (phi[i - row] - here) +
                    (REAL)y1 * (phi[i + row] - here) + (REAL)z0 * (phi[i - plane] - here) +
                    (REAL)z1 * (phi[i + plane] - here);
        float lost = absorption[i] + x0 + x1 + y0 + y1 + z0 + z1;
        if (ends) {
            const float w0 = low * ty_cell_boundary(v->a[0], v->b[0], d);
            const float w1 = high * ty_cell_boundary(v->a[1], v->b[1], d);
            left += (REAL)w0 * ((REAL)beyond0 - here) + (REAL)w1 * ((REAL)beyond1 - here);
            lost += w0 + w1;
        }
        if (edge)
            for (int s = 2; s < 6; ++s) {
                const float w = ty_cell_boundary(v->a[s], v->b[s], d);
                left += (REAL)w * ((REAL)v->cells[1 + s][i] - here);
                lost += w;
            }
        const REAL moved = here + (REAL)(omega * (float)left / ty_maxf(lost, 1e-30f));
        const REAL kept = (REAL)TY_CELL_KEPT * here;
        next[i] = limiter == TY_LIMITER_NONE || moved > kept ? moved : kept;
        next_d[i] = d;
        squares += ((i ^ first) & 1) == 0 && i < count ? (float)left * (float)left : 0.0f;
    }
    for (int32_t i = first; i < count; i += 2) {
        phi[i] = next[i];
        diff[i] = next_d[i];
    }
    return squares;
}

INLINE double NAME(sor_row)(const ty_cells* cells, const int32_t limiter, REAL* phi, float* diff, float omega,
                            int32_t color, int32_t y, int32_t z) {
    const int32_t nx = cells->box.size[0], first = (color + y + z) & 1;
    const bool edge = is_edge(cells, y, z);
    double sum = 0;
    sor_view v;
    sor_view_set(cells, y, z, edge, &v);
    phi += ty_box_at(&cells->box, y, z);
    diff += ty_box_at(&cells->box, y, z);
    for (int32_t x = 0; x < nx; x += SOR_BLOCK) {
        sor_view_enter(&v, x, nx - x);
        if (edge)
            sum += (double)NAME(sor_block)(cells, limiter, &v, phi + x, diff + x, omega, x, first, true, true);
        else if (x == 0 || x + SOR_BLOCK >= nx)
            sum += (double)NAME(sor_block)(cells, limiter, &v, phi + x, diff + x, omega, x, first, true, false);
        else
            sum += (double)NAME(sor_block)(cells, limiter, &v, phi + x, diff + x, omega, x, first, false, false);
    }
    return sum;
}

#define SOR_ROWS(kind)                                                                                                 \
    case kind:                                                                                                         \
        for (int32_t y = 0; y < cells->box.size[1]; ++y)                                                               \
            sum += NAME(sor_row)(cells, kind, phi, diffusivity, (float)omega, color, y, z);                            \
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
