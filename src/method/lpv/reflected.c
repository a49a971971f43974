/* Light that surfaces reflect. */
#include "direct/beam.k.h"
#include "method/lpv/lamp_ray.h"
#include "method/lpv/splat.h"

float ty_lpv_window(const ty_lpv_def* def, int32_t l) {
    const double window = def->window >= 0 ? def->window : def->bands == 3 ? 0.01 : 0;
    return (float)(1 / (1 + window * l * l * (l + 1) * (l + 1)));
}

typedef struct reflect_job {
    const ty_lattice* lattice;
    const ty_lpv_lamp* lamp;
    ty_splat_cells cells;
    ty_lamp_medium medium;
} reflect_job;

/* false: the texel reflects nothing into the lattice. */
static bool reflect(const reflect_job* job, const ty_lamp_ray* ray, ty_splat* out) {
    const ty_light_map* map = job->lamp->map;
    if (!isfinite(ray->length)) return false;
    const ty_vec normal = ty_vec_load(map->normal + 3 * ray->texel);
    const ty_vec point = ty_mad(ray->origin, ray->direction, ray->length);
    float depth[3];
    out->cell = ty_splat_cell(&job->cells, ty_mad(point, normal, ty_splat_clearance(job->lattice, normal)));
    if (out->cell < 0) return false;
    out->axis = normal;
    ty_lamp_depth(&job->medium, ray, ray->length, depth);
    for (int c = 0; c < 3; ++c)
        out->power[c] = ray->power[c] * map->albedo[3 * ray->texel + (size_t)c] * ty_decay(depth[c]);
    return true;
}

static int32_t reflect_row(const void* user, int64_t row, ty_splat* out) {
    const reflect_job* job = user;
    int32_t count = 0;
    for (int32_t x = 0; x < job->lamp->map->side; ++x) {
        ty_lamp_ray ray;
        if (ty_lamp_ray_at(job->lamp, row, x, &ray)) count += reflect(job, &ray, &out[count]);
    }
    return count;
}

ty_result ty_lattice_inject_reflected(ty_lattice* lattice, const ty_lpv_def* def, const ty_lpv_lamp* lamp,
                                      const ty_grid_medium* medium, double power[3]) {
    const reflect_job job = {.lattice = lattice,
                             .lamp = lamp,
                             .cells = ty_splat_cells_of(lattice),
                             .medium = ty_lamp_medium_of((def->parts & TY_LPV_SCATTERING) != 0 ? medium : NULL)};
    ty_splat_rows rows = {
        .rows = ty_lamp_rows(lamp), .most = lamp->map->side, .user = &job, .row = reflect_row, .band = {1}};
    if (lamp->map->normal == NULL) return TY_OK;
    for (int32_t l = 1; l < lattice->bands; ++l)
        rows.band[l] = ty_lpv_window(def, l) * ty_sh_cosine(l) / ty_sh_cosine(0);
    return ty_splats_add(lattice, &rows, power);
}
