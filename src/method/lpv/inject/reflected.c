/* Injection of light that surfaces reflect. */
#include "direct/media/attenuation.k.h"
#include "method/lpv/inject/rsm_rays.h"
#include "method/lpv/lattice/lookup.k.h"
#include "method/lpv/inject/splat.h"

float ty_lpv_window(const ty_lpv_def* def, int32_t l) {
    const double window = def->window >= 0 ? def->window : def->bands == 3 ? 0.01 : 0;
    return (float)(1 / (1 + window * l * l * (l + 1) * (l + 1)));
}

typedef struct reflect_job {
    const ty_lattice* lattice;
    ty_rsm_ray_view view;
    ty_splat_cells cells;
} reflect_job;

/* The splat of one texel; false if it reflects nothing into the lattice. */
static bool reflect(const reflect_job* job, const ty_rsm_rays* rays, int32_t i, ty_splat* out) {
    if (!(rays->measure[i] > 0.0f) || !isfinite(rays->length[i])) return false;
    const ty_vec origin = ty_rsm_ray_vec(rays->origin, i);
    const ty_vec direction = ty_rsm_ray_vec(rays->direction, i);
    const ty_vec normal = ty_rsm_ray_vec(rays->normal, i);
    const ty_vec point = ty_mad(origin, direction, rays->length[i]);
    float depth[3];
    out->cell = ty_splat_cell(&job->cells, ty_lattice_lit_side(job->lattice, point, normal));
    if (out->cell < 0) out->cell = ty_splat_cell(&job->cells, ty_lattice_lift(point, normal, job->lattice->cell));
    if (out->cell < 0) return false;
    out->axis = normal;
    const float* albedo = job->view.light->rsm->albedo + 3 * (rays->first + (size_t)i);
    const float* color = job->view.light->light->color;
    ty_rsm_ray_optical_depth(&job->view.medium, rays, i, depth);
    for (int c = 0; c < 3; ++c) out->power[c] = rays->measure[i] * color[c] * albedo[c] * ty_attenuation(depth[c]);
    return true;
}

static int32_t reflect_row(const void* user, int64_t row, ty_splat* out) {
    const reflect_job* job = user;
    int32_t count = 0;
    ty_rsm_rays rays;
    for (int32_t x = 0; x < job->view.light->rsm->side; x += TY_RSM_RAYS) {
        ty_rsm_rays_at(&job->view, row, x, &rays);
        for (int32_t i = 0; i < rays.count; ++i) count += reflect(job, &rays, i, &out[count]);
    }
    return count;
}

ty_result ty_lattice_inject_reflected(ty_lattice* lattice, const ty_lpv_def* def, const ty_lpv_light* light,
                                      const ty_grid_medium* medium, double power[3]) {
    const bool dims = (def->parts & TY_LPV_SCATTERING) != 0;
    const reflect_job job = {.lattice = lattice,
                             .view = ty_rsm_ray_view_of(light, dims ? medium : NULL),
                             .cells = ty_splat_cells_of(lattice)};
    ty_splat_rows rows = {
        .rows = ty_rsm_row_count(light), .max_splats = light->rsm->side, .user = &job, .row = reflect_row, .band = {1}};
    if (light->rsm->normal == NULL) return TY_OK;
    /* A virtual light per texel, as a clamped cosine lobe about its normal (Kaplanyan and Dachsbacher 2010). */
    for (int32_t l = 1; l < lattice->bands; ++l)
        rows.band[l] = ty_lpv_window(def, l) * ty_sh_cosine(l) / ty_sh_cosine(0);
    return ty_splats_add(lattice, &rows, power);
}
