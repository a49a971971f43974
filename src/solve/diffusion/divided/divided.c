#include "solve/diffusion/divided/divided.h"

#include "solve/diffusion/images.h"

#include <string.h>

/* A level of at most so many cells is whole on every rank: there messages would take longer than the cells. */
enum { WHOLE_CELLS = 32 * 32 * 32 };

/* ---- cuts ---- */

/* Coarsest levels that may be divided, and the cells of the finest grid per cell of level `levels`. */
static int32_t plan_levels(const int32_t size[3], const double cell[3], int32_t max_levels, int32_t unit[3]) {
    int32_t whole[3], ratio[3] = {1, 1, 1}, children[3], levels = 0;
    double edge[3];
    memcpy(whole, size, sizeof whole);
    memcpy(edge, cell, sizeof edge);
    while (levels < max_levels && (levels == 0 || (int64_t)whole[0] * whole[1] * whole[2] > WHOLE_CELLS) &&
           ty_multigrid_coarsen_size(whole, edge, children)) {
        ++levels;
        /* Boxes of the last divided level begin at even cells, too, so that colours are those of the grid. */
        for (int a = 0; a < 3; ++a) unit[a] = ratio[a] * 2;
        for (int a = 0; a < 3; ++a) ratio[a] *= children[a];
    }
    return levels;
}

bool ty_diffusion_divide(ty_comm* comm, const ty_diffusion_def* def, ty_domain* out) {
    int32_t unit[3] = {1, 1, 1};
    int32_t levels = plan_levels(def->size, def->cell, TY_LEVELS_MAX, unit);
    for (; levels > 0; levels = plan_levels(def->size, def->cell, levels - 1, unit)) {
        const int32_t min_cells = 2 * (unit[1] > unit[2] ? unit[1] : unit[2]), units[3] = {1, unit[1], unit[2]};
        if (ty_domain_create(comm, def->size, TY_CUT_Y | TY_CUT_Z, units, min_cells, out)) return true;
    }
    return false;
}

/* The number of levels by which ty_diffusion_divide chose the domain's unit. */
void ty_divided_begin(ty_diffusion_job* job) {
    const ty_diffusion_def* def = job->def;
    const ty_domain* domain = def->domain;
    static const int32_t ratio[3] = {1, 1, 1};
    job->domain = domain != NULL && ty_comm_size(domain->comm) > 1 ? def->domain : NULL;
    job->divided = 0;
    if (job->domain != NULL) {
        int32_t unit[3] = {0, 0, 0};
        job->divided = plan_levels(domain->cells, def->cell, TY_LEVELS_MAX, unit);
        while (job->divided > 1 && (unit[1] != domain->unit[1] || unit[2] != domain->unit[2]))
            job->divided = plan_levels(domain->cells, def->cell, job->divided - 1, unit);
    }
    job->cells.box = ty_divided_box(job, job->domain != NULL ? domain->cells : def->size, ratio, job->domain != NULL);
}

/* Cells [*first, *end) of the ranks at place p along an axis of a coarser grid. */
static void cells_of_place(const ty_domain* domain, int axis, int32_t p, int32_t ratio, int32_t whole, int32_t* first,
                           int32_t* end) {
    *first = ty_domain_first(domain, axis, p) / ratio;
    *end = p + 1 == domain->ranks[axis] ? whole : ty_domain_first(domain, axis, p + 1) / ratio;
}

ty_box ty_divided_box(const ty_diffusion_job* job, const int32_t whole[3], const int32_t ratio[3], bool divided) {
    int32_t first[3] = {0, 0, 0}, end[3] = {whole[0], whole[1], whole[2]};
    uint32_t cut = 0;
    for (int a = 0; a < 3 && divided; ++a)
        cells_of_place(job->domain, a, job->domain->at[a], ratio[a], whole[a], &first[a], &end[a]);
    for (int side = 0; side < 6 && divided; ++side)
        if (ty_domain_neighbour(job->domain, side) >= 0) cut |= UINT32_C(1) << side;
    ty_box box = ty_box_make(end[0] - first[0], end[1] - first[1], end[2] - first[2]);
    memcpy(box.whole, whole, sizeof box.whole);
    memcpy(box.first, first, sizeof box.first);
    memcpy(box.ratio, ratio, sizeof box.ratio);
    for (int a = 1; a < 3; ++a) /* rows along x are never cut */
        if ((job->def->periodic >> a & 1) != 0 && whole[a] > 1) cut |= UINT32_C(3) << 2 * a;
    box.cut = cut;
    return box;
}

/* This rank's part of a whole box, in the memory of that. */
static ty_box part_of(const ty_diffusion_job* job, const ty_box* box) {
    ty_box part = ty_divided_box(job, box->whole, box->ratio, true);
    part.row = box->row;
    part.plane = box->plane;
    part.dense_rows = box->dense_rows;
    return part;
}

static void set_part_level(ty_diffusion_job* job) {
    const ty_level* level = &job->levels[job->divided];
    ty_level* part = &job->part_level;
    *part = *level;
    part->box = part_of(job, &level->box);
    const ptrdiff_t at = ty_box_at(&level->box, part->box.first[1], part->box.first[2]);
    part->d += at;
    part->e += at;
    part->f += at;
    for (int a = 0; a < 3; ++a) part->g[a] += at;
}

static void set_part_stage(ty_diffusion_job* job) {
    const ty_fas_level* stage = &job->stages[job->divided];
    ty_fas_level* part = &job->part_stage;
    *part = *stage;
    ty_box* box = &part->cells.box;
    *box = part_of(job, &stage->cells.box);
    const ptrdiff_t at = ty_box_at(box, box->first[1], box->first[2]);
    const ptrdiff_t dense = ty_box_dense(box, box->first[1], box->first[2]);
    part->phi += at;
    part->diffusivity += at;
    part->restricted += at;
    part->extinction += dense;
    part->absorption += dense;
    part->source += dense;
    for (int side = 0; side < 6; ++side) {
        const int axis = side / 2;
        ty_side* s = &part->cells.sides[side];
        s->value += s->step * box->first[axis == 2 ? 1 : 2] + box->first[axis == 0 ? 1 : 0];
    }
}

void ty_divided_lay_out_sums(ty_diffusion_job* job, ty_arena* arena) {
    const ty_domain* domain = job->domain;
    if (domain == NULL) return;
    const size_t ranks = (size_t)ty_comm_size(domain->comm),
                 planes = (size_t)domain->cells[2] * (size_t)domain->ranks[1];
    job->offsets = ty_arena_take(arena, sizeof(size_t) * (ranks + 1));
    job->all_sums = ty_arena_take(arena, sizeof(ty_plane_sums) * planes);
}

void ty_divided_lay_out(ty_diffusion_job* job, ty_arena* arena) {
    if (job->domain == NULL) return;
    job->gathered =
        ty_arena_take(arena, sizeof(float) * TY_GATHERED_MAX * (size_t)ty_box_cells(&job->levels[job->divided].box));
    if (arena->base == NULL) return;
    set_part_level(job);
    set_part_stage(job);
}

bool ty_divided_gathers(const ty_diffusion_job* job, int32_t i) {
    return job->domain != NULL && i + 1 == job->divided;
}

const ty_level* ty_divided_coarse_level(const ty_diffusion_job* job, int32_t i) {
    return ty_divided_gathers(job, i) ? &job->part_level : &job->levels[i + 1];
}

const ty_fas_level* ty_divided_coarse_stage(const ty_diffusion_job* job, int32_t i) {
    return ty_divided_gathers(job, i) ? &job->part_stage : &job->stages[i + 1];
}

/* ---- layers beyond the cuts ---- */

static ty_halo halo_of(const ty_box* box, void* origin, size_t item) {
    return (ty_halo){origin, item, {1, box->row, box->plane}};
}

void ty_divided_exchange(const ty_diffusion_job* job, const ty_box* box, float* const* arrays, int32_t count) {
    for (int32_t i = 0; i < count; ++i) ty_diffusion_wrap(job, box, arrays[i], sizeof(float));
    if (job->domain == NULL || box->cut == 0) return;
    ty_halo halos[TY_GATHERED_MAX];
    for (int32_t i = 0; i < count; ++i) halos[i] = halo_of(box, arrays[i], sizeof(float));
    ty_domain_exchange(job->domain, box->size, halos, count);
}

void ty_divided_exchange_fluence(const ty_diffusion_job* job, const ty_box* box, void* phi, float* diffusivity) {
    const size_t item = job->def->solver == TY_DIFFUSION_SOR_FLOAT ? sizeof(float) : sizeof(double);
    ty_diffusion_wrap(job, box, phi, item);
    if (diffusivity != NULL) ty_diffusion_wrap(job, box, diffusivity, sizeof(float));
    if (job->domain == NULL || box->cut == 0) return;
    const ty_halo halos[2] = {halo_of(box, phi, item), halo_of(box, diffusivity, sizeof(float))};
    ty_domain_exchange(job->domain, box->size, halos, diffusivity != NULL ? 2 : 1);
}

/* ---- parts together ---- */

/* Cells of a rank's part of the first whole level along y and z. */
static void part_of_rank(const ty_diffusion_job* job, int32_t rank, int32_t first[3], int32_t end[3]) {
    const ty_box* box = &job->levels[job->divided].box;
    int32_t at[3];
    ty_domain_place(job->domain, rank, at);
    for (int a = 0; a < 3; ++a) cells_of_place(job->domain, a, at[a], box->ratio[a], box->whole[a], &first[a], &end[a]);
}

/* Copies a rank's part between arrays and the message. */
static void copy_part(const ty_diffusion_job* job, int32_t rank, float* const* arrays, int32_t count, bool with_ghosts,
                      float* message, bool out) {
    const ty_box* box = &job->levels[job->divided].box;
    int32_t first[3], end[3];
    part_of_rank(job, rank, first, end);
    const size_t items = (size_t)box->size[0];
    for (int32_t i = 0; i < count; ++i)
        for (int32_t z = first[2]; z < end[2]; ++z)
            for (int32_t y = first[1]; y < end[1]; ++y, message += items) {
                float* row = arrays[i] + (with_ghosts ? ty_box_at(box, y, z) : ty_box_dense(box, y, z));
                memcpy(out ? message : row, out ? row : message, sizeof(float) * items);
            }
}

void ty_divided_gather(const ty_diffusion_job* job, float* const* arrays, int32_t count, bool with_ghosts) {
    const int32_t ranks = ty_comm_size(job->domain->comm), own = ty_comm_rank(job->domain->comm);
    job->offsets[0] = 0;
    for (int32_t r = 0; r < ranks; ++r) {
        int32_t first[3], end[3];
        part_of_rank(job, r, first, end);
        size_t items = (size_t)count;
        for (int a = 0; a < 3; ++a) items *= (size_t)(end[a] - first[a]);
        job->offsets[r + 1] = job->offsets[r] + sizeof(float) * items;
    }
    copy_part(job, own, arrays, count, with_ghosts, job->gathered + job->offsets[own] / sizeof(float), true);
    ty_comm_gather_all(job->domain->comm, job->gathered, job->offsets);
    for (int32_t r = 0; r < ranks; ++r)
        if (r != own)
            copy_part(job, r, arrays, count, with_ghosts, job->gathered + job->offsets[r] / sizeof(float), false);
}

/* Values of a side of the first whole stage: those of the ranks beside it. */
static size_t copy_side(const ty_diffusion_job* job, int side, int32_t rank, float* message, bool out) {
    const ty_side* s = &job->stages[job->divided].cells.sides[side];
    const int axis = side / 2, u = axis == 0 ? 1 : 0, v = axis == 2 ? 1 : 2;
    int32_t first[3], end[3];
    part_of_rank(job, rank, first, end);
    if ((side & 1) != 0 ? end[axis] != job->levels[job->divided].box.whole[axis] : first[axis] != 0) return 0;
    const size_t items = (size_t)(end[u] - first[u]);
    for (int32_t j = first[v]; j < end[v] && message != NULL; ++j, message += items) {
        float* row = (float*)s->value + s->step * j + first[u];
        memcpy(out ? message : row, out ? row : message, sizeof(float) * items);
    }
    return sizeof(float) * items * (size_t)(end[v] - first[v]);
}

void ty_divided_gather_side(const ty_diffusion_job* job, int side) {
    const int32_t ranks = ty_comm_size(job->domain->comm), own = ty_comm_rank(job->domain->comm);
    job->offsets[0] = 0;
    for (int32_t r = 0; r < ranks; ++r) job->offsets[r + 1] = job->offsets[r] + copy_side(job, side, r, NULL, true);
    copy_side(job, side, own, job->gathered + job->offsets[own] / sizeof(float), true);
    ty_comm_gather_all(job->domain->comm, job->gathered, job->offsets);
    for (int32_t r = 0; r < ranks; ++r)
        if (r != own) copy_side(job, side, r, job->gathered + job->offsets[r] / sizeof(float), false);
}

/* ---- sums ---- */

/* Planes in the order of the grid; where they are cut along y, their parts in that order. */
ty_plane_sums ty_divided_sum(const ty_diffusion_job* job, const ty_box* box) {
    const ty_domain* domain = job->domain;
    const int32_t ranks = ty_comm_size(domain->comm), own = ty_comm_rank(domain->comm);
    ty_plane_sums total = {0};
    job->offsets[0] = 0;
    for (int32_t r = 0; r < ranks; ++r) {
        int32_t at[3], first, end;
        ty_domain_place(domain, r, at);
        cells_of_place(domain, 2, at[2], box->ratio[2], box->whole[2], &first, &end);
        job->offsets[r + 1] = job->offsets[r] + sizeof total * (size_t)(end - first);
    }
    memcpy((char*)job->all_sums + job->offsets[own], job->sums, job->offsets[own + 1] - job->offsets[own]);
    ty_comm_gather_all(domain->comm, job->all_sums, job->offsets);
    for (int32_t pz = 0; pz < domain->ranks[2]; ++pz) {
        const int32_t place[3] = {0, 0, pz}, lowest = ty_domain_rank(domain, place);
        const size_t planes = (job->offsets[lowest + 1] - job->offsets[lowest]) / sizeof total;
        for (size_t z = 0; z < planes; ++z) {
            ty_plane_sums plane = {0};
            for (int32_t py = 0; py < domain->ranks[1]; ++py) {
                const ty_plane_sums* part = &job->all_sums[job->offsets[lowest + py] / sizeof total + z];
                plane = py == 0 ? *part : (ty_plane_sums){plane.a + part->a, plane.b + part->b, plane.c + part->c};
            }
            total.a += plane.a;
            total.b += plane.b;
            total.c += plane.c;
        }
    }
    return total;
}

void ty_divided_add(const ty_diffusion_job* job, double* value) {
    if (job->domain != NULL) ty_comm_sum(job->domain->comm, value, 1);
}

bool ty_divided_any(const ty_diffusion_job* job, bool own) {
    double value = own ? 1 : 0;
    if (job->domain != NULL) ty_comm_max(job->domain->comm, &value, 1);
    return value > 0;
}
