/* The images of a box that repeats. The radiance that enters by a face in a sweep is that which left by the opposite
 * one in the sweep before. So the radiance there belongs to the iterate: Anderson weights mix it like the moments, its
 * change is a source of the diffusion equation, and it is corrected by the even radiance of that one's solution. */
#include "base/constants.h"
#include "base/context.h"
#include "base/kernel.h"
#include "solve/ordinates/job.h"
#include "solve/ordinates/sweep_kernel.h"

#include <math.h>
#include <string.h>

/* A face where the box repeats: its place in the arrays of radiance, and the cells on both sides of it. */
typedef struct image_face {
    int axis;
    int32_t cell[3]; /* at the lower face */
    float* radiance; /* of the first octant; others follow by `stride` */
    size_t stride;
} image_face;

typedef void (*face_fn)(ty_ordinates_job* job, const image_face* face, void* user);

static void for_faces(ty_ordinates_job* job, float* radiance, face_fn body, void* user) {
    const int32_t* size = job->def->size;
    const size_t pitch = (size_t)ty_sweep_pitch(job->sweep);
    for (int a = 0; a < 3; ++a) {
        if ((job->def->periodic >> a & 1) == 0) continue;
        const int u = a == 0 ? 1 : 0, v = a == 2 ? 1 : 2;
        image_face face = {.axis = a, .stride = pitch * (size_t)size[u] * (size_t)size[v]};
        for (int32_t j = 0; j < size[v]; ++j)
            for (int32_t i = 0; i < size[u]; ++i) {
                face.cell[u] = i;
                face.cell[v] = j;
                face.radiance = radiance + pitch * ((size_t)j * (size_t)size[u] + (size_t)i);
                body(job, &face, user);
            }
        radiance += 8 * face.stride;
    }
}

/* The cell that a face's light enters (octants whose bit of the axis is 0 enter at the lower end), as x, y and z. */
static void entered_cell(const ty_ordinates_job* job, const image_face* face, int octant, int32_t cell[3]) {
    for (int a = 0; a < 3; ++a) cell[a] = face->cell[a];
    cell[face->axis] = (octant >> face->axis & 1) != 0 ? job->def->size[face->axis] - 1 : 0;
}

/* Adds the P1 radiance of a fluence and of its flux along the axis, both as moments over sqrt(4 pi). */
static void add_p1(const ty_ordinates_job* job, const image_face* face, float fluence, float flux) {
    const ty_angular_quadrature* set = job->def->set;
    const float norm = (float)(1 / TY_SQRT_4PI_F64);
    for (int32_t o = 0; o < 8; ++o)
        for (int32_t d = 0; d < set->first[1]; ++d)
            face->radiance[face->stride * (size_t)o + (size_t)d] +=
                norm * (fluence + 3 * set->direction[face->axis][set->first[o] + d] * flux);
}

ty_result ty_ordinates_images_create(ty_ordinates_job* job) {
    if (job->def->periodic == 0) return TY_OK;
    const ty_result result = ty_sweep_repeat(job->sweep, job->def->periodic);
    if (result != TY_OK) return result;
    job->image_floats = ty_sweep_inflow_floats(job->sweep);
    for (int32_t i = 0; i < job->depth; ++i) {
        job->images[i] = ty_alloc_array(job->context, job->image_floats, sizeof(float), true);
        if (job->images[i] == NULL) return TY_ERROR_MEMORY;
    }
    job->stats->bytes += (double)job->depth * (double)job->image_floats * sizeof(float);
    return TY_OK;
}

void ty_ordinates_images_destroy(ty_ordinates_job* job) {
    for (int32_t i = 0; i < job->depth; ++i)
        if (job->images[i] != NULL) ty_free_array(job->context, job->images[i], job->image_floats, sizeof(float));
}

/* ---- before and after sweeps ---- */

/* A low-order moment of the first iterate in a cell. */
static float low_order_of(const ty_ordinates_job* job, const int32_t cell[3], int32_t term) {
    const int32_t* size = job->def->size;
    const size_t row = (size_t)size[0] * ((size_t)cell[1] + (size_t)size[1] * (size_t)cell[2]);
    return job
        ->low_order[job->latest][row * (size_t)job->low_order_terms + (size_t)term * (size_t)size[0] + (size_t)cell[0]];
}

static void begin_face(ty_ordinates_job* job, const image_face* face, void* user) {
    (void)user;
    const int32_t p1 = face->axis == 0 ? 3 : face->axis;
    float fluence = 0, flux = 0;
    for (int end = 0; end < 2; ++end) {
        int32_t cell[3];
        entered_cell(job, face, 7 * end, cell);
        fluence += 0.5f * low_order_of(job, cell, 0);
        if (job->low_order_terms > 1) flux += 0.5f * low_order_of(job, cell, p1) / sqrtf(3);
    }
    add_p1(job, face, fluence, flux);
}

void ty_ordinates_images_begin(ty_ordinates_job* job) {
    if (job->def->periodic == 0 || job->count == 0) return;
    memset(job->images[job->latest], 0, sizeof(float) * job->image_floats);
    for_faces(job, job->images[job->latest], begin_face, NULL);
}

void ty_ordinates_images_emit(const ty_ordinates_job* job, ty_sweep* sweep) {
    float* inflow = ty_sweep_inflow(sweep);
    memset(inflow, 0, sizeof(float) * job->image_floats);
    for (int32_t i = 0; i < job->count; ++i) {
        const float weight = (float)job->anderson_weights[i], *from = job->images[i];
        for (size_t k = 0; weight != 0 && k < job->image_floats; ++k) inflow[k] += weight * from[k];
    }
    for (size_t k = 0; k < job->image_floats; ++k) inflow[k] = ty_maxf(0, inflow[k]);
}

double ty_ordinates_images_receive(ty_ordinates_job* job) {
    if (job->def->periodic == 0) return 0;
    ty_sweep_outflow(job->sweep, job->images[job->latest]);
    return ty_sweep_inflow_power(job->sweep, job->images[job->latest]) -
           ty_sweep_inflow_power(job->sweep, ty_sweep_inflow(job->sweep));
}

/* ---- diffusion ---- */

typedef struct residual_sum {
    const float *inflow, *outflow;
    const float* weight[3]; /* power per radiance of a direction, over volume and sqrt(4 pi) */
    double squares;
} residual_sum;

static void residual_face(ty_ordinates_job* job, const image_face* face, void* user) {
    residual_sum* sum = user;
    const ty_box* box = ty_dsa_box(job->dsa);
    const float norm = (float)(1 / (job->def->cell[0] * job->def->cell[1] * job->def->cell[2] * TY_SQRT_4PI_F64));
    const ptrdiff_t before = face->radiance - sum->outflow;
    for (int32_t o = 0; o < 8; ++o) {
        int32_t cell[3];
        float power = 0;
        const float *out = face->radiance + face->stride * (size_t)o,
                    *in = sum->inflow + before + face->stride * (size_t)o;
        for (int32_t d = 0; d < job->def->set->first[1]; ++d) power += sum->weight[face->axis][d] * (out[d] - in[d]);
        entered_cell(job, face, o, cell);
        float* f = ty_dsa_source(job->dsa) + ty_box_at(box, cell[1], cell[2]) + cell[0];
        sum->squares -= (double)(*f * *f);
        *f += norm * power;
        sum->squares += (double)(*f * *f);
    }
}

double ty_ordinates_images_residual(ty_ordinates_job* job, bool first) {
    if (job->def->periodic == 0 || first) return 0;
    residual_sum sum = {.inflow = ty_sweep_inflow(job->sweep), .outflow = job->images[job->latest]};
    for (int a = 0; a < 3; ++a) sum.weight[a] = ty_sweep_tables(job->sweep)->partial_current_weight[a];
    for_faces(job, job->images[job->latest], residual_face, &sum);
    return sum.squares;
}

static void correct_face(ty_ordinates_job* job, const image_face* face, void* user) {
    const float* e = user;
    const ty_box* box = ty_dsa_box(job->dsa);
    const ptrdiff_t steps[3] = {1, box->row, box->plane}, step = steps[face->axis];
    int32_t cell[3];
    entered_cell(job, face, 0, cell);
    const ptrdiff_t at = ty_box_at(box, cell[1], cell[2]) + cell[0];
    const float *d = ty_dsa_diffusivity(job->dsa), here = d[at], below = d[at - step];
    /* Without the flux of e, which overshoots in thin cells: a cloud takes 26 sweeps, and 38 with it. */
    add_p1(job, face, (here * e[at] + below * e[at - step]) / (here + below), 0);
}

void ty_ordinates_images_correct(ty_ordinates_job* job, const float* e) {
    if (job->def->periodic != 0 && !job->from_guess) for_faces(job, job->images[job->latest], correct_face, (void*)e);
}
